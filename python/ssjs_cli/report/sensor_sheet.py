"""What each sensor of an underwater vehicle gave and what its gate refused."""

from typing import Any

from ssjs_cli.report.number_text import finite_number
from ssjs_cli.report.sheet import Sheet, sheet

COLUMNS = [
    ("sensor", "sensor", None, 1.0),
    ("used", "samples used", 0, 1.0),
    ("refused", "refused by its gate", 0, 1.0),
    ("refused_fraction", "refused [%]", 2, 100.0),
    ("nis_per_dof", "NIS per degree of freedom", 3, 1.0),
]


def sensor_sheet(summary: dict[str, Any]) -> Sheet | None:
    """None for a vehicle in the plane, whose summary counts no sensors."""
    sensors = summary.get("sensors")
    if not isinstance(sensors, dict) or not sensors:
        return None
    rows = []
    for name, entry in sensors.items():
        if not isinstance(entry, dict):
            continue
        used, refused = (finite_number(entry.get(key)) or 0.0 for key in ("used", "refused"))
        fraction = refused / (used + refused) if used + refused > 0.0 else None
        rows.append({"sensor": str(name).replace("_", " "), **entry, "refused_fraction": fraction})
    return sheet(
        "sensor-table",
        "Sensors",
        COLUMNS,
        rows,
        note="NIS of the samples used, each sensor by itself; 1 where its noise is what the settings say, less where they claim more noise "
        "than there is. A dash: no sample.",
    )
