"""The track that a velocity log and an attitude sensor tell by themselves, and the yaw between it and a reference."""

import math

import numpy as np

from ssjs_cli.formats.attitude import rotation
from ssjs_cli.formats.navigation import Attitude, BottomVelocity
from ssjs_cli.formats.number_table import FloatArray


def bottom_track(attitude: Attitude, velocity: BottomVelocity) -> tuple[FloatArray, FloatArray]:
    """Times (n,) and positions (n, 2), m, from the first sample with bottom lock on, in the horizontal frame of the attitude sensor's yaw.
    Between two samples the velocity changes evenly."""
    time_s = velocity.time_s[velocity.bottom_lock]
    angles = [np.interp(time_s, attitude.time_s, np.unwrap(column)) for column in attitude.angles_rad.T]
    body = velocity.velocity_m_s[velocity.bottom_lock]
    level = np.array([(rotation(*angle) @ v)[:2] for angle, v in zip(np.transpose(angles), body, strict=True)]).reshape(-1, 2)
    steps = 0.5 * (level[1:] + level[:-1]) * np.diff(time_s)[:, None]
    return time_s, np.vstack([np.zeros((1, 2)), np.cumsum(steps, axis=0)])


def positions_at(at_s: FloatArray, time_s: FloatArray, position_m: FloatArray) -> FloatArray:
    """(k, 2), linear between neighbours."""
    return np.column_stack([np.interp(at_s, time_s, column) for column in position_m.T])


def turned(position_m: FloatArray, angle_rad: float) -> FloatArray:
    """(n, 2), turned from x towards y."""
    cos, sin = math.cos(angle_rad), math.sin(angle_rad)
    moved: FloatArray = position_m @ np.array([[cos, sin], [-sin, cos]])
    return moved


def yaw_between(moved_m: FloatArray, reference_m: FloatArray) -> float:
    """The turn that takes the moved positions (n, 2) nearest to the reference (n, 2), both about their means. rad"""
    a, b = moved_m - moved_m.mean(axis=0), reference_m - reference_m.mean(axis=0)
    return _turn(a, b)


def yaw_between_legs(moved_m: FloatArray, reference_m: FloatArray, leg: int) -> tuple[float, float]:
    """The same from the legs over `leg` rows alone, and its standard deviation. rad. Drift that has piled up before a leg does not enter;
    the deviation takes legs that do not overlap as independent."""
    a, b = (position[leg:] - position[:-leg] for position in (moved_m, reference_m))
    turn = _turn(a, b)
    residual = turned(a, turn) - b
    variance = 0.5 * float((residual**2).mean()) * 2.0 * leg / float((a**2).sum())
    return turn, math.sqrt(variance)


def _turn(a: FloatArray, b: FloatArray) -> float:
    return math.atan2(float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum()), float((a * b).sum()))
