"""Trajectories as text: one line `t x y z qx qy qz qw` per pose, in seconds and metres, with a unit quaternion (x forward, y left on land;
under water y to the right, and z, which is the depth, down)."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ssjs_cli.errors import UserError
from ssjs_cli.formats.number_table import EXACT, FIXED, FloatArray, read_columns, require_times_in_order, write_table

TUM_COLUMNS = ("time_s", "x_m", "y_m", "z_m", "qx", "qy", "qz", "qw")
QUATERNION = "%.12f"
MAX_NORM_DEVIATION = 1e-3


@dataclass(frozen=True)
class PoseSeries:
    """time_s (n,), non-decreasing; pose (n, 3) x m, y m, heading rad in [-pi, pi). space (n, 3): depth m, roll rad, pitch rad of a
    vehicle that does not stay in the plane."""

    time_s: FloatArray
    pose: FloatArray
    space: FloatArray | None = None


def wrapped_angle(angle_rad: FloatArray) -> FloatArray:
    """The same angles in [-pi, pi)."""
    wrapped: FloatArray = np.mod(angle_rad + np.pi, 2.0 * np.pi) - np.pi
    return np.where(wrapped >= np.pi, -np.pi, wrapped)


def write_tum(path: Path, series: PoseSeries) -> None:
    if series.space is not None:
        _write_spatial(path, series, series.space)
        return
    half_heading = 0.5 * series.pose[:, 2]
    zero = np.zeros(len(series.time_s))
    columns = [series.time_s, series.pose[:, 0], series.pose[:, 1], zero, zero, zero, np.sin(half_heading), np.cos(half_heading)]
    formats = [EXACT, FIXED, FIXED, "%.0f", "%.0f", "%.0f", QUATERNION, QUATERNION]
    write_table(path, "", columns, formats, separator=" ")


def _write_spatial(path: Path, series: PoseSeries, space: FloatArray) -> None:
    sine, cosine = (function(0.5 * np.column_stack([space[:, 1], space[:, 2], series.pose[:, 2]])) for function in (np.sin, np.cos))
    (sr, sp, sy), (cr, cp, cy) = sine.T, cosine.T
    quaternion = [
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    ]
    columns = [series.time_s, series.pose[:, 0], series.pose[:, 1], space[:, 0], *quaternion]
    write_table(path, "", columns, [EXACT, *[FIXED] * 3, *[QUATERNION] * 4], separator=" ")


def read_tum(path: Path) -> PoseSeries:
    """Depth, roll and pitch are kept where any pose has one."""
    table = read_columns(path, TUM_COLUMNS)
    if table.rows == 0:
        raise UserError(f"{path}: holds no pose; it needs lines of {' '.join(TUM_COLUMNS)}")
    require_times_in_order(table)
    qx, qy, qz, qw = (table[name] for name in ("qx", "qy", "qz", "qw"))
    norm = np.sqrt(qx * qx + qy * qy + qz * qz + qw * qw)
    bad = np.abs(norm - 1.0) > MAX_NORM_DEVIATION
    if bad.any():
        row = int(np.argmax(bad))
        raise UserError(f"{table.where(row)}: qx qy qz qw has the length {norm[row]:.6g}, not 1; give a unit quaternion")
    heading = np.arctan2(2.0 * (qw * qz + qx * qy), 1.0 - 2.0 * (qy * qy + qz * qz))
    roll = np.arctan2(2.0 * (qw * qx + qy * qz), 1.0 - 2.0 * (qx * qx + qy * qy))
    pitch = np.arcsin(np.clip(2.0 * (qw * qy - qz * qx), -1.0, 1.0))
    space = np.column_stack([table["z_m"], roll, pitch])
    pose = np.column_stack([table["x_m"], table["y_m"], wrapped_angle(heading)])
    return PoseSeries(table["time_s"], pose, space if space.any() else None)
