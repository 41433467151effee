"""Keyframes of a camera mission with navigation: frames that show new ground, placed on the map by the track.

docs/math/optical.md (V-26)"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ssjs_cli import _core
from ssjs_cli.config import Scalar
from ssjs_cli.formats.frame_image import Frame, FrameError, decoded, frame_bytes
from ssjs_cli.formats.frames import FrameIndex
from ssjs_cli.formats.navigation import Scalars
from ssjs_cli.formats.number_table import FloatArray
from ssjs_cli.formats.tum import PoseSeries

TURN_RAD = 0.5
MAX_KEYFRAMES = 1500
#: A frame that shows so much more ground than the usual one was taken by a vehicle that leant over.
MAX_AREA_RATIO = 3.0
#: Of the way to the horizon: a corner that is nearer to it than this is not drawn.
LEAST_DEPTH = 0.05
MOUNT_KEYS = (
    "mount_roll_rad", "mount_pitch_rad", "mount_yaw_rad", "mount_forward_m", "mount_starboard_m", "mount_down_m",
)  # fmt: skip
#: Across is east, up is north; the world is north, east, down.
MAP_H_WORLD = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


@dataclass(frozen=True)
class Keyframe:
    """placed: its corrected pixels -> the map, across and up; is_colour: it has three channels."""

    time_s: float
    path: Path
    placed: FloatArray
    is_colour: bool = False

    def pixels(self) -> Frame:
        return decoded(frame_bytes(self.path))


def keyframes(
    frames: FrameIndex,
    used: Sequence[tuple[float, str]],
    track: PoseSeries,
    altitude: Scalars | None,
    settings: Mapping[str, Scalar],
    step: float,
) -> list[Keyframe]:
    """Of the frames `used` (time, file) those that the vehicle moved `step` times the shorter side of what it sees for, or turned, and
    that can be read. None without a calibration, or without altitudes."""
    if frames.calibration is None or track.space is None or altitude is None or not used:
        return []
    calibration = asdict(frames.calibration)
    mount = {name: settings[f"camera.{name}"] for name in MOUNT_KEYS if f"camera.{name}" in settings}
    known = np.isfinite(altitude.value) & (altitude.value > 0.0)
    if not known.any():
        return []
    time_s = np.array([time for time, _ in used])
    pose = poses_at(track, time_s)
    height = np.interp(time_s, altitude.time_s[known], altitude.value[known])
    shorter = min(calibration["width_px"] / calibration["focal_x_px"], calibration["height_px"] / calibration["focal_y_px"])
    chosen: list[Keyframe] = []
    last: FloatArray | None = None
    for row, (time, name) in enumerate(used):
        here = pose[row]
        if last is not None and not _shows_new_ground(last, here, step * shorter * float(height[row])):
            continue
        ground = _core.ground_homography(here, float(here[2] + height[row]), calibration, mount)
        if ground is None or not _is_ahead(ground, calibration):
            continue
        chosen.append(Keyframe(time, frames.folder / name, MAP_H_WORLD @ ground))
        last = here
    if len(chosen) > MAX_KEYFRAMES:
        chosen = [chosen[row] for row in np.linspace(0, len(chosen) - 1, MAX_KEYFRAMES).astype(int).tolist()]
    areas = np.array([_area(keyframe.placed, calibration) for keyframe in chosen])
    usual = float(np.median(areas)) if len(areas) else 0.0
    read = [_read(keyframe) for keyframe, area in zip(chosen, areas, strict=True) if area < MAX_AREA_RATIO * usual]
    return [keyframe for keyframe in read if keyframe is not None]


def middles(frames: Sequence[Keyframe], calibration: Mapping[str, Any]) -> FloatArray:
    """(n, 2) where on the map the camera of each looks straight ahead."""
    middle = np.array([calibration["centre_x_px"], calibration["centre_y_px"], 1.0])
    place = np.array([keyframe.placed @ middle for keyframe in frames]).reshape(-1, 3)
    on_map: FloatArray = place[:, :2] / place[:, 2:]
    return on_map


def _shows_new_ground(last: FloatArray, here: FloatArray, distance_m: float) -> bool:
    turn = abs(float(np.remainder(here[5] - last[5] + np.pi, 2.0 * np.pi) - np.pi))
    return float(np.hypot(*(here[:2] - last[:2]))) >= distance_m or turn >= TURN_RAD


def poses_at(track: PoseSeries, time_s: FloatArray) -> FloatArray:
    """(n, 6) x, y, z, roll, pitch, heading, between the steps of the track."""
    space = np.zeros((len(track.time_s), 3)) if track.space is None else track.space
    turned = np.unwrap(np.column_stack((space[:, 1:], track.pose[:, 2])), axis=0)
    columns = [track.pose[:, 0], track.pose[:, 1], space[:, 0], *turned.T]
    return np.column_stack([np.interp(time_s, track.time_s, column) for column in columns])


def _corners(calibration: Mapping[str, Any]) -> FloatArray:
    right, bottom = float(calibration["width_px"]) - 0.5, float(calibration["height_px"]) - 0.5
    return np.array([[-0.5, -0.5, 1.0], [right, -0.5, 1.0], [right, bottom, 1.0], [-0.5, bottom, 1.0]])


def _is_ahead(ground: FloatArray, calibration: Mapping[str, Any]) -> bool:
    """ground: its last element is 1."""
    return bool((_corners(calibration) @ ground[2] > LEAST_DEPTH).all())


def _area(placed: FloatArray, calibration: Mapping[str, Any]) -> float:
    corner = _corners(calibration) @ placed.T
    x, y = corner[:, 0] / corner[:, 2], corner[:, 1] / corner[:, 2]
    return float(0.5 * abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))))


def _read(keyframe: Keyframe) -> Keyframe | None:
    """None where its file has gone since, or is damaged."""
    try:
        return replace(keyframe, is_colour=keyframe.pixels().ndim == 3)
    except FrameError:
        return None
