"""`fixes.csv`: positions from outside that the estimator uses, such as those of satellites while the vehicle is at the surface.

Either x and y in the world frame of the mission, or latitude and longitude where the mission has an origin.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ssjs_cli.errors import UserError
from ssjs_cli.formats.navigation import PLANE_COLUMNS, POSITION_FIXES_FILE, PositionFixes
from ssjs_cli.formats.number_table import (
    FloatArray,
    NumberTable,
    holds_file,
    read_header,
    read_table,
    require_positive,
    require_times_in_order,
)

if TYPE_CHECKING:
    from ssjs_cli.formats.mission import Geodetic

GEOGRAPHIC_COLUMNS = ("latitude_deg", "longitude_deg")
# Farther from the origin the plane is not the map any more, and a number is more likely that of another grid.
FARTHEST_M = 200_000.0


def read_position_fixes(directory: Path, geodetic: Geodetic | None) -> PositionFixes | None:
    """None where the mission holds no such file."""
    path = directory / POSITION_FIXES_FILE
    if not holds_file(path):
        return None
    header = read_header(path)
    is_geographic = any(name in header for name in GEOGRAPHIC_COLUMNS)
    if is_geographic and geodetic is None:
        raise UserError(
            f"{path}: holds latitude and longitude, and mission.toml no origin to place them by; give mission.toml a table [geodetic] with "
            f"origin_latitude_deg and origin_longitude_deg, or the columns {','.join(PLANE_COLUMNS)}"
        )
    columns = GEOGRAPHIC_COLUMNS if is_geographic else PLANE_COLUMNS
    table = read_table(path, required=("time_s", *columns, "sigma_m"))
    if table.rows == 0:
        raise UserError(f"{path}: holds no fix; give at least one line after the header, or remove the file")
    require_times_in_order(table)
    require_positive(table, "sigma_m", "give the standard deviation of each coordinate of the fix")
    position_m = _from_geographic(table, geodetic) if geodetic is not None and is_geographic else table.stacked(PLANE_COLUMNS)
    far = ~(np.hypot(position_m[:, 0], position_m[:, 1]) <= FARTHEST_M)
    if far.any():
        row = int(np.argmax(far))
        raise UserError(
            f"{table.where(row)}: the fix lies farther than {FARTHEST_M / 1000.0:g} km from the origin of the world; x and y are "
            "metres from that origin, not of a national grid: subtract it, or correct the line"
        )
    return PositionFixes(table["time_s"], position_m, table["sigma_m"])


def _from_geographic(table: NumberTable, geodetic: Geodetic) -> FloatArray:
    from ssjs_cli.formats.geographic import from_longitude_latitude

    for name, limit in (("latitude_deg", 90.0), ("longitude_deg", 360.0)):
        bad = ~(np.abs(table[name]) <= limit)
        if bad.any():
            row = int(np.argmax(bad))
            raise UserError(f"{table.where(row)}: {name} = {float(table[name][row])!r} must lie between {-limit:g} and {limit:g} degrees")
    return from_longitude_latitude(table.stacked(("longitude_deg", "latitude_deg")), geodetic)
