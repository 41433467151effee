"""Logs of other programs as a mission: columns are mapped by name and converted from their units.

A mapping is `target=source[:unit]`, e.g. `time_s=t:ms`, `bearing_rad=brg:-deg` (a minus turns the sign). It may name the
file it is for: `odometry.time_s=stamp:ns`.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from ssjs_cli.errors import UserError, nearest_hint
from ssjs_cli.formats.file_digest import file_digest
from ssjs_cli.formats.mission import (
    CARTESIAN_COLUMNS,
    COVARIANCE_COLUMNS,
    FIXES_FILE,
    LANDMARKS_FILE,
    OBSERVATIONS_FILE,
    ODOMETRY_COLUMNS,
    ODOMETRY_FILE,
    POLAR_COLUMNS,
    Fixes,
    ImportRecord,
    Mission,
    Observations,
    Odometry,
    Reference,
    ReferenceDescription,
    SurveyedLandmarks,
    landmark_ids,
)
from ssjs_cli.formats.number_table import (
    FloatArray,
    NumberTable,
    read_header,
    read_table,
    require_positive,
    require_positive_range,
    require_times_in_order,
    whole_numbers,
)
from ssjs_cli.formats.tum import wrapped_angle

# What one unit of the source is in the unit of the target, by the ending of the target's name.
UNITS: Mapping[str, Mapping[str, float]] = MappingProxyType(
    {
        "_rad_s": {"rad/s": 1.0, "deg/s": math.pi / 180.0, "rpm": 2.0 * math.pi / 60.0},
        "_m_s": {"m/s": 1.0, "cm/s": 0.01, "mm/s": 0.001, "km/h": 1.0 / 3.6, "mph": 0.44704, "kn": 1852.0 / 3600.0},
        "_rad2": {"rad2": 1.0, "deg2": (math.pi / 180.0) ** 2},
        "_m2": {"m2": 1.0, "cm2": 1e-4, "mm2": 1e-6},
        "_rad": {"rad": 1.0, "deg": math.pi / 180.0, "mrad": 1e-3, "grad": math.pi / 200.0},
        "_m": {"m": 1.0, "cm": 0.01, "mm": 0.001, "km": 1000.0, "ft": 0.3048},
        "_s": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0},
    }
)
DIVISORS: Mapping[str, float] = MappingProxyType(
    {"ms": 1e3, "us": 1e6, "ns": 1e9, "cm": 1e2, "mm": 1e3, "cm/s": 1e2, "mm/s": 1e3, "mrad": 1e3}
)

FILE_OF: Mapping[str, str] = MappingProxyType(
    {"odometry": ODOMETRY_FILE, "observations": OBSERVATIONS_FILE, "fixes": FIXES_FILE, "landmarks": LANDMARKS_FILE}
)
TARGETS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "odometry": tuple(dict.fromkeys(name for columns in ODOMETRY_COLUMNS.values() for name in columns)),
        "observations": ("time_s", *POLAR_COLUMNS, *CARTESIAN_COLUMNS, "landmark_id", *COVARIANCE_COLUMNS),
        "fixes": ("time_s", "x_m", "y_m", "sigma_m"),
        "landmarks": ("id", "x_m", "y_m"),
    }
)


@dataclass(frozen=True)
class ColumnMapping:
    source: str
    factor: float
    divisor: float


@dataclass(frozen=True)
class LogFiles:
    """The files to read; an absent one is None."""

    odometry: Path
    observations: Path | None = None
    fixes: Path | None = None
    landmarks: Path | None = None

    def present(self) -> dict[str, Path]:
        named = {"odometry": self.odometry, "observations": self.observations, "fixes": self.fixes, "landmarks": self.landmarks}
        return {role: path for role, path in named.items() if path is not None}


def find_log_files(source: Path, given: Mapping[str, str | None]) -> LogFiles:
    """`source` is the odometry file or the directory of all. Given names are relative to the directory; the others are
    taken where they exist."""
    if not source.exists():
        raise UserError(f"{source}: is missing; name the odometry file or the directory that holds it")
    directory = source if source.is_dir() else source.parent
    found: dict[str, Path | None] = {}
    for role, default_name in FILE_OF.items():
        name = given.get(role)
        if name is not None:
            found[role] = directory / name
            if not (directory / name).is_file():
                raise UserError(f"--{role} {name}: {directory / name} is missing; check the name")
        elif role == "odometry" and source.is_file():
            found[role] = source
        else:
            found[role] = directory / default_name if (directory / default_name).is_file() else None
    odometry = found["odometry"]
    if odometry is None:
        raise UserError(f"{directory / ODOMETRY_FILE}: is missing; name the odometry file with --odometry")
    return LogFiles(odometry, found["observations"], found["fixes"], found["landmarks"])


def parse_mappings(texts: Sequence[str]) -> dict[str, dict[str, ColumnMapping]]:
    """role -> target column -> where it comes from."""
    mappings: dict[str, dict[str, ColumnMapping]] = {role: {} for role in TARGETS}
    for text in texts:
        target, separator, rest = text.partition("=")
        target = target.strip()
        if not separator or not target or not rest:
            raise UserError(f"--map {text}: must be target=source[:unit], for example time_s=t:ms")
        source, _, unit = rest.partition(":")
        role, dot, column = target.partition(".")
        roles = [role] if dot else list(TARGETS)
        column = column if dot else target
        if dot and role not in TARGETS:
            raise UserError(f"--map {text}: unknown file '{role}'{nearest_hint(role, TARGETS)}; the files are {', '.join(TARGETS)}")
        fitting = [name for name in roles if column in TARGETS[name]]
        if not fitting:
            known = list(dict.fromkeys(name for candidate in roles for name in TARGETS[candidate]))
            raise UserError(f"--map {text}: unknown target column '{column}'{nearest_hint(column, known)}; known: {', '.join(known)}")
        factor, divisor = _conversion(column, unit.strip(), text)
        for name in fitting:
            mappings[name][column] = ColumnMapping(source.strip(), factor, divisor)
    return mappings


def _conversion(column: str, unit: str, text: str) -> tuple[float, float]:
    """(factor, divisor): decimal parts of a unit divide, because 21940 / 1000 is nearer to 21.94 than 21940 * 0.001."""
    if not unit:
        return 1.0, 1.0
    sign, unit = (-1.0, unit[1:]) if unit.startswith("-") else (1.0, unit)
    units = next((table for ending, table in UNITS.items() if column.endswith(ending)), None)
    if units is None:
        raise UserError(f"--map {text}: column '{column}' has no unit; leave ':{unit}' out")
    if unit not in units:
        raise UserError(f"--map {text}: unknown unit '{unit}' of '{column}'{nearest_hint(unit, units)}; known: {', '.join(units)}")
    return (sign, DIVISORS[unit]) if unit in DIVISORS else (sign * units[unit], 1.0)


class _Source:
    """One file seen through its mappings: target columns by their mission names."""

    def __init__(self, path: Path, role: str, mappings: Mapping[str, ColumnMapping], delimiter: str) -> None:
        header = read_header(path, delimiter)
        self._mapping: dict[str, ColumnMapping] = {}
        for target in TARGETS[role]:
            chosen = mappings.get(target)
            if chosen is not None and chosen.source not in header:
                if all(other.source not in header for other in mappings.values()):
                    raise UserError(f"{path}:1: holds none of the mapped columns; the header holds {','.join(header)}")
                raise UserError(
                    f"{path}:1: column '{chosen.source}', mapped to {target}, is missing{nearest_hint(chosen.source, header)}; "
                    f"the header holds {','.join(header)}"
                )
            if chosen is None and target in header:
                chosen = ColumnMapping(target, 1.0, 1.0)
            if chosen is not None:
                self._mapping[target] = chosen
        self.path = path
        self._delimiter = delimiter
        self._header = header

    @property
    def targets(self) -> set[str]:
        return set(self._mapping)

    def read(self, names: Sequence[str]) -> NumberTable:
        missing = [name for name in names if name not in self._mapping]
        if missing:
            raise UserError(
                f"{self.path}:1: {','.join(missing)} is missing; the header holds {','.join(self._header)}; "
                f"name the column with --map {missing[0]}=COLUMN[:UNIT]"
            )
        sources = list(dict.fromkeys(self._mapping[name].source for name in names))
        identity = [self._mapping["landmark_id"].source] if "landmark_id" in names else []
        raw = read_table(self.path, required=sources, may_be_empty=identity, other_columns_allowed=True, delimiter=self._delimiter)
        columns = {}
        for name in names:
            chosen = self._mapping[name]
            columns[name] = raw[chosen.source] * chosen.factor / chosen.divisor
        table = NumberTable(self.path, columns, raw.rows)
        if "time_s" in columns:
            require_times_in_order(table)
        return table


def read_csv_log(
    files: LogFiles,
    mappings: Mapping[str, Mapping[str, ColumnMapping]],
    *,
    name: str,
    delimiter: str = ",",
    settings: Mapping[str, Any] | None = None,
) -> Mission:
    sources = {role: _Source(path, role, mappings[role], delimiter) for role, path in files.present().items()}
    odometry = _odometry(sources["odometry"])
    observations = _observations(sources["observations"]) if "observations" in sources else None
    fixes = _fixes(sources["fixes"]) if "fixes" in sources else None
    landmarks = _landmarks(sources["landmarks"]) if "landmarks" in sources else None
    counts = {"odometry_records": len(odometry.values), "observations": 0 if observations is None else len(observations.time_s)}
    return Mission(
        name=name,
        description="imported from comma-separated logs",
        odometry=odometry,
        observations=observations,
        settings={**(settings or {}), "vehicle": {**((settings or {}).get("vehicle", {})), "kind": odometry.kind}},
        reference=Reference(ReferenceDescription(alignment="se2"), fixes=fixes, landmarks=landmarks),
        import_record=ImportRecord(
            format="csv",
            counts=counts,
            digests={path.name: file_digest(path) for path in files.present().values()},
        ),
    )


def _odometry(source: _Source) -> Odometry:
    complete = [kind for kind, columns in ODOMETRY_COLUMNS.items() if set(columns) <= source.targets]
    if len(complete) > 1:
        raise UserError(f"{source.path}:1: holds the columns of {' and '.join(complete)} odometry; map the columns of one only")
    kind = complete[0] if complete else max(ODOMETRY_COLUMNS, key=lambda kind: len(set(ODOMETRY_COLUMNS[kind]) & source.targets))
    table = source.read(ODOMETRY_COLUMNS[kind])
    if table.rows == 0:
        raise UserError(f"{source.path}: the mission is empty: there is no line after the header; give at least one odometry record")
    if kind == "increments":
        for sigma in ("sigma_x_m", "sigma_y_m", "sigma_heading_rad"):
            require_positive(table, sigma)
    return Odometry(kind, table.stacked(ODOMETRY_COLUMNS[kind]))


def _observations(source: _Source) -> Observations | None:
    cartesian = not set(POLAR_COLUMNS) <= source.targets and set(CARTESIAN_COLUMNS) <= source.targets
    place = CARTESIAN_COLUMNS if cartesian else POLAR_COLUMNS
    covariance_columns = COVARIANCE_COLUMNS if set(COVARIANCE_COLUMNS) & source.targets else ()
    identity = ("landmark_id",) if "landmark_id" in source.targets else ()
    table = source.read(("time_s", *place, *identity, *covariance_columns))
    if table.rows == 0:
        return None
    if cartesian:
        range_m, bearing_rad = np.hypot(table["x_m"], table["y_m"]), np.arctan2(table["y_m"], table["x_m"])
    else:
        require_positive_range(table)
        range_m, bearing_rad = table["range_m"], wrapped_angle(table["bearing_rad"])
    covariance: FloatArray | None = None
    if covariance_columns:
        require_positive(table, "var_range_m2")
        require_positive(table, "var_bearing_rad2")
        covariance = table.stacked(COVARIANCE_COLUMNS)
    return Observations(table["time_s"], range_m, bearing_rad, covariance, landmark_ids(table))


def _fixes(source: _Source) -> Fixes:
    sigma = ("sigma_m",) if "sigma_m" in source.targets else ()
    table = source.read(("time_s", "x_m", "y_m", *sigma))
    return Fixes(table["time_s"], table.stacked(("x_m", "y_m")), table["sigma_m"] if sigma else None)


def _landmarks(source: _Source) -> SurveyedLandmarks:
    table = source.read(("id", "x_m", "y_m"))
    return SurveyedLandmarks(whole_numbers(table, "id"), table.stacked(("x_m", "y_m")))
