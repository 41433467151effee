"""What a sensor under water can say at all. A value outside is a slip of units, of sign, or of the logger, and never weather."""

import math
from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ssjs_cli.errors import UserError
from ssjs_cli.formats.number_table import NumberTable


class Bounds(NamedTuple):
    lowest: float
    highest: float
    mend: str


_ANGLE = "angles are in rad: convert degrees, wrap to [-pi, pi), or remove the line"
_RATE = "turn rates are in rad/s: convert degrees, or remove the line"
_SPEED = "velocities are in m/s: convert mm/s or cm/s, or set bottom_lock to 0"
_POINT = "points are in m in the body frame, not on a map: correct or remove the line"

BOUNDS: Mapping[str, Bounds] = MappingProxyType(
    {
        "time_s": Bounds(-1e10, 1e10, "times are in s: convert milliseconds, microseconds or nanoseconds"),
        "roll_rad": Bounds(-2.0 * math.pi, 2.0 * math.pi, _ANGLE),
        # At 90 degrees roll and yaw are one turn, and the attitude has no derivative.
        "pitch_rad": Bounds(-1.55, 1.55, "near +-pi/2 roll and yaw are the same turn: remove the line; " + _ANGLE),
        "yaw_rad": Bounds(-4.0 * math.pi, 4.0 * math.pi, _ANGLE),
        **dict.fromkeys(("turn_rate_x_rad_s", "turn_rate_y_rad_s", "turn_rate_z_rad_s"), Bounds(-20.0, 20.0, _RATE)),
        **dict.fromkeys(("vx_m_s", "vy_m_s", "vz_m_s"), Bounds(-50.0, 50.0, _SPEED)),
        # A pressure sensor at the surface may read a little above it.
        "depth_m": Bounds(-20.0, 12_000.0, "depth is in m, positive down: convert it, or remove the line"),
        "altitude_m": Bounds(0.0, 12_000.0, "altitude is in m over the bottom: remove the lines in which the altimeter saw none"),
        **dict.fromkeys(("x_m", "y_m", "z_m"), Bounds(-20_000.0, 20_000.0, _POINT)),
        **dict.fromkeys(("var_xx_m2", "var_yy_m2", "var_zz_m2"), Bounds(0.0, 1e8, "variances are in m^2: correct the line")),
    }
)


def require_plausible(table: NumberTable, names: Iterable[str], rows: NDArray[np.bool_] | None = None) -> None:
    """`rows`: those that mean anything; all without it."""
    for name in names:
        bounds, values = BOUNDS[name], table[name]
        bad = ~((values >= bounds.lowest) & (values <= bounds.highest))
        if rows is not None:
            bad &= rows
        if bad.any():
            row = int(np.argmax(bad))
            limits = f"between {bounds.lowest:.6g} and {bounds.highest:.6g}"
            raise UserError(f"{table.where(row)}: {name} = {float(values[row])!r} must lie {limits}; {bounds.mend}")
