"""What an underwater vehicle measures of itself: attitude, velocity over the bottom, depth, altitude. One CSV a sensor.

Body frame: x forward, y starboard, z down. Angles in rad: roll positive starboard down, pitch positive bow up, yaw clockwise from the
north of the compass. Each sensor keeps its own times.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ssjs_cli.errors import UserError
from ssjs_cli.formats.number_table import (
    EXACT,
    WHOLE,
    FloatArray,
    IntArray,
    NumberTable,
    holds_file,
    read_header,
    read_table,
    require_times_in_order,
    write_table,
)
from ssjs_cli.formats.physical_bounds import require_plausible

IMU_FILE = "imu.csv"
DVL_FILE = "dvl.csv"
DEPTH_FILE = "depth.csv"
ALTITUDE_FILE = "altitude.csv"
POSITION_FIXES_FILE = "fixes.csv"
NAVIGATION_FILES = (IMU_FILE, DVL_FILE, DEPTH_FILE, ALTITUDE_FILE)

ANGLE_COLUMNS = ("roll_rad", "pitch_rad", "yaw_rad")
TURN_RATE_COLUMNS = ("turn_rate_x_rad_s", "turn_rate_y_rad_s", "turn_rate_z_rad_s")
PLANE_COLUMNS = ("x_m", "y_m")
VELOCITY_COLUMNS = ("vx_m_s", "vy_m_s", "vz_m_s")

BoolArray = NDArray[np.bool_]


@dataclass(frozen=True)
class Attitude:
    """angles_rad (n, 3) roll, pitch, yaw; turn_rate_rad_s (n, 3) of the body axes, where there is a gyro."""

    time_s: FloatArray
    angles_rad: FloatArray
    turn_rate_rad_s: FloatArray | None = None


@dataclass(frozen=True)
class BottomVelocity:
    """velocity_m_s (n, 3), body frame; bottom_lock (n,): False where the log did not see the bottom and the velocity means nothing."""

    time_s: FloatArray
    velocity_m_s: FloatArray
    bottom_lock: BoolArray


@dataclass(frozen=True)
class Scalars:
    """One number at a time: depth below the surface, or altitude over the bottom, in m."""

    time_s: FloatArray
    value: FloatArray


@dataclass(frozen=True)
class PositionFixes:
    """Positions that the estimator may use, as on surfacing: position_m (n, 2), world frame; sigma_m (n,) of each coordinate."""

    time_s: FloatArray
    position_m: FloatArray
    sigma_m: FloatArray


@dataclass(frozen=True)
class UnderwaterNavigation:
    attitude: Attitude
    velocity: BottomVelocity | None = None
    depth: Scalars | None = None
    altitude: Scalars | None = None
    fixes: PositionFixes | None = None


def _present_files(directory: Path) -> list[str]:
    """Attitude must be there with any of the others."""
    present = [name for name in NAVIGATION_FILES if holds_file(directory / name)]
    if present and IMU_FILE not in present:
        columns = ",".join(("time_s", *ANGLE_COLUMNS))
        raise UserError(f"{directory / IMU_FILE}: is missing beside {present[0]}; give the attitude with the columns {columns}")
    return present


def read_navigation(directory: Path) -> UnderwaterNavigation | None:
    """None where the mission holds none of the files."""
    present = _present_files(directory)
    if not present:
        return None
    return UnderwaterNavigation(
        attitude=_read_attitude(directory / IMU_FILE),
        velocity=_read_velocity(directory / DVL_FILE) if DVL_FILE in present else None,
        depth=_read_scalars(directory / DEPTH_FILE, "depth_m") if DEPTH_FILE in present else None,
        altitude=_read_scalars(directory / ALTITUDE_FILE, "altitude_m") if ALTITUDE_FILE in present else None,
    )


def outline_navigation(directory: Path) -> UnderwaterNavigation | None:
    """The attitude without its records: only whether there is a gyro."""
    if not _present_files(directory):
        return None
    has_gyro = set(TURN_RATE_COLUMNS) <= set(read_header(directory / IMU_FILE))
    nothing = np.zeros((0, 3))
    return UnderwaterNavigation(Attitude(np.zeros(0), nothing, nothing if has_gyro else None))


def _read_attitude(path: Path) -> Attitude:
    table = _timed(read_table(path, required=("time_s", *ANGLE_COLUMNS), optional=TURN_RATE_COLUMNS))
    given = [name for name in TURN_RATE_COLUMNS if name in table]
    if given and len(given) < len(TURN_RATE_COLUMNS):
        raise UserError(f"{path}:1: holds {','.join(given)} alone; give all of {','.join(TURN_RATE_COLUMNS)}, or none")
    require_plausible(table, (*ANGLE_COLUMNS, *given))
    return Attitude(table["time_s"], table.stacked(ANGLE_COLUMNS), table.stacked(TURN_RATE_COLUMNS) if given else None)


def _read_velocity(path: Path) -> BottomVelocity:
    table = _timed(read_table(path, required=("time_s", *VELOCITY_COLUMNS), optional=("bottom_lock",), may_be_empty=VELOCITY_COLUMNS))
    lock = table["bottom_lock"] if "bottom_lock" in table else np.ones(table.rows)
    odd = (lock != 0.0) & (lock != 1.0)
    if odd.any():
        row = int(np.argmax(odd))
        raise UserError(f"{table.where(row)}: bottom_lock = {float(lock[row])!r} must be 1 (the bottom was seen) or 0")
    velocity = table.stacked(VELOCITY_COLUMNS)
    unknown = (lock == 1.0) & ~np.isfinite(velocity).all(axis=1)
    if unknown.any():
        row = int(np.argmax(unknown))
        raise UserError(f"{table.where(row)}: a velocity is empty or not finite though bottom_lock is 1; set it to 0 or give the velocity")
    require_plausible(table, VELOCITY_COLUMNS, lock == 1.0)
    return BottomVelocity(table["time_s"], velocity, lock == 1.0)


def _read_scalars(path: Path, name: str) -> Scalars:
    table = _timed(read_table(path, required=("time_s", name)))
    require_plausible(table, (name,))
    return Scalars(table["time_s"], table[name])


def _timed(table: NumberTable) -> NumberTable:
    require_times_in_order(table)
    if table.rows == 0:
        raise UserError(f"{table.path}: holds no line after the header; give at least one, or remove the file")
    require_plausible(table, ("time_s",))
    return table


def write_navigation(directory: Path, navigation: UnderwaterNavigation) -> None:
    """Fills an existing directory. Velocities without bottom lock are left empty."""
    attitude = navigation.attitude
    columns: list[FloatArray | IntArray] = [attitude.time_s, *attitude.angles_rad.T]
    names = ["time_s", *ANGLE_COLUMNS]
    if attitude.turn_rate_rad_s is not None:
        columns += list(attitude.turn_rate_rad_s.T)
        names += TURN_RATE_COLUMNS
    _write(directory / IMU_FILE, names, columns)
    if navigation.velocity is not None:
        velocity = navigation.velocity
        lock = velocity.bottom_lock.astype(np.int64)
        known = [np.where(velocity.bottom_lock, column, np.nan) for column in velocity.velocity_m_s.T]
        _write(directory / DVL_FILE, ["time_s", *VELOCITY_COLUMNS, "bottom_lock"], [velocity.time_s, *known, lock])
    if navigation.depth is not None:
        _write(directory / DEPTH_FILE, ["time_s", "depth_m"], [navigation.depth.time_s, navigation.depth.value])
    if navigation.altitude is not None:
        _write(directory / ALTITUDE_FILE, ["time_s", "altitude_m"], [navigation.altitude.time_s, navigation.altitude.value])
    if navigation.fixes is not None:
        write_fixes(directory / POSITION_FIXES_FILE, navigation.fixes)


def write_fixes(path: Path, fixes: PositionFixes) -> None:
    _write(path, ["time_s", *PLANE_COLUMNS, "sigma_m"], [fixes.time_s, *fixes.position_m.T, fixes.sigma_m])


def _write(path: Path, names: Sequence[str], columns: Sequence[FloatArray | IntArray]) -> None:
    formats = [WHOLE if column.dtype.kind == "i" else EXACT for column in columns]
    write_table(path, ",".join(names), columns, formats)
