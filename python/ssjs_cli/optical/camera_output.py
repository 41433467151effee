"""Pictures of the run of a camera mission with navigation: the mosaic of its keyframes, matches between them, and landmarks in frames as
they were predicted and measured (thesis 5.16)."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ssjs_cli import _core
from ssjs_cli.config import Scalar
from ssjs_cli.formats.frame_image import Frame, FrameError, decoded, frame_bytes
from ssjs_cli.formats.frames import FrameIndex
from ssjs_cli.formats.navigation import Scalars
from ssjs_cli.formats.number_table import FloatArray
from ssjs_cli.formats.run_directory import PICTURES_FOLDER
from ssjs_cli.formats.tum import PoseSeries
from ssjs_cli.optical.match_pictures import shown_links
from ssjs_cli.optical.mosaic_picture import draw_mosaic
from ssjs_cli.optical.picture_index import PictureIndex
from ssjs_cli.optical.sighting_pictures import sighting_picture, sightings_by_time

#: Of the shorter side of what a frame shows: keyframes are so far apart.
KEYFRAME_STEP = 0.35
KEYFRAME_TURN_RAD = 0.5
MAX_KEYFRAMES = 1500
#: A frame that shows so much more ground than the usual one was taken by a vehicle that leant over.
MAX_AREA_RATIO = 3.0
MAX_SIGHTING_PICTURES = 4
#: So many keyframes apart they show the same ground only when the vehicle has come back.
FAR_KEYFRAMES = 4
MATCHED_FRAMES = 12
MOUNT_KEYS = (
    "mount_roll_rad", "mount_pitch_rad", "mount_yaw_rad", "mount_forward_m", "mount_starboard_m", "mount_down_m",
)  # fmt: skip
#: Across is east, up is north; the world is north, east, down.
MAP_H_WORLD = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


@dataclass(frozen=True)
class Keyframe:
    """placed: its corrected pixels -> the map, across and up."""

    time_s: float
    path: Path
    placed: FloatArray

    def pixels(self) -> Frame:
        return decoded(frame_bytes(self.path))


def write_camera_pictures(
    directory: Path,
    frames: FrameIndex,
    used: Sequence[tuple[float, str]],
    with_region: int,
    track: PoseSeries,
    altitude: Scalars | None,
    result: Mapping[str, Any],
    settings: Mapping[str, Scalar],
) -> None:
    """used: time and file of every frame that was read; track: the final one; settings: of the run, of which those of the camera's
    mounting, [frames] and [mosaic] are looked at."""
    if frames.calibration is None or not used:
        return
    calibration = asdict(frames.calibration)
    reader = _core.FrameReader({}, calibration)
    index = PictureIndex(directory / PICTURES_FOLDER, "m")
    keyframes = _keyframes(frames, used, track, altitude, calibration, settings)
    if keyframes:
        placed = np.array([keyframe.placed for keyframe in keyframes])
        mosaic_settings = {key: value for key, value in settings.items() if key.startswith("mosaic.")}
        channels = {keyframe.pixels().ndim for keyframe in keyframes}

        def pixels() -> Any:
            for keyframe in keyframes:
                frame = keyframe.pixels()
                yield np.repeat(frame[:, :, None], 3, axis=2) if len(channels) > 1 and frame.ndim == 2 else frame

        index.add_mosaic(draw_mosaic(pixels, placed, reader, mosaic_settings))
        _add_matches(index, keyframes, calibration)
    files = {time_s: frames.folder / name for time_s, name in used}
    for time_s, rows in sightings_by_time(result.get("frame_sightings"), files, MAX_SIGHTING_PICTURES):
        picture = sighting_picture(reader.corrected(decoded(frame_bytes(files[time_s]))), rows)
        index.add_sighting(picture, files[time_s].name, len(rows["measured_px"]))
    index.frames(given=len(frames.files), used=len(used), with_region=with_region)
    index.write()


def _keyframes(
    frames: FrameIndex,
    used: Sequence[tuple[float, str]],
    track: PoseSeries,
    altitude: Scalars | None,
    calibration: dict[str, Any],
    settings: Mapping[str, Scalar],
) -> list[Keyframe]:
    """Those that show new ground, and can be read once more."""
    if track.space is None or altitude is None:
        return []
    mount = {key.removeprefix("camera."): settings[key] for key in (f"camera.{name}" for name in MOUNT_KEYS) if key in settings}
    time_s = np.array([time for time, _ in used])
    pose = _poses_at(track, time_s)
    known = np.isfinite(altitude.value) & (altitude.value > 0.0)
    if not known.any():
        return []
    height = np.interp(time_s, altitude.time_s[known], altitude.value[known])
    shorter = min(calibration["width_px"] / calibration["focal_x_px"], calibration["height_px"] / calibration["focal_y_px"])
    chosen: list[Keyframe] = []
    last: FloatArray | None = None
    for row, (time, name) in enumerate(used):
        here = pose[row]
        if last is not None:
            turn = abs(float(np.remainder(here[5] - last[5] + np.pi, 2.0 * np.pi) - np.pi))
            if float(np.hypot(*(here[:2] - last[:2]))) < KEYFRAME_STEP * shorter * height[row] and turn < KEYFRAME_TURN_RAD:
                continue
        ground = _core.ground_homography(here, float(here[2] + height[row]), calibration, mount)
        if ground is None or not _is_ahead(ground, calibration):
            continue
        chosen.append(Keyframe(time, frames.folder / name, MAP_H_WORLD @ ground))
        last = here
    chosen = [chosen[k] for k in np.unique(np.linspace(0, len(chosen) - 1, min(len(chosen), MAX_KEYFRAMES)).astype(int))] if chosen else []
    areas = np.array([_area(keyframe.placed, calibration) for keyframe in chosen])
    usual = float(np.median(areas)) if len(areas) else 0.0
    return [keyframe for keyframe, area in zip(chosen, areas, strict=True) if area < MAX_AREA_RATIO * usual and _can_be_read(keyframe)]


def _poses_at(track: PoseSeries, time_s: FloatArray) -> FloatArray:
    """(n, 6) x, y, z, roll, pitch, heading, between the steps of the track."""
    space = np.zeros((len(track.time_s), 3)) if track.space is None else track.space
    turned = np.unwrap(np.column_stack((space[:, 1:], track.pose[:, 2])), axis=0)
    columns = [track.pose[:, 0], track.pose[:, 1], space[:, 0], *turned.T]
    return np.column_stack([np.interp(time_s, track.time_s, column) for column in columns])


def _corners(calibration: Mapping[str, Any]) -> FloatArray:
    right, bottom = float(calibration["width_px"]) - 0.5, float(calibration["height_px"]) - 0.5
    return np.array([[-0.5, -0.5, 1.0], [right, -0.5, 1.0], [right, bottom, 1.0], [-0.5, bottom, 1.0]])


def _is_ahead(ground: FloatArray, calibration: Mapping[str, Any]) -> bool:
    depth = _corners(calibration) @ ground[2]
    return bool((depth * ground[2, 2] > 0.05 * ground[2, 2] ** 2).all())


def _area(placed: FloatArray, calibration: Mapping[str, Any]) -> float:
    corner = _corners(calibration) @ placed.T
    x, y = corner[:, 0] / corner[:, 2], corner[:, 1] / corner[:, 2]
    return float(0.5 * abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))))


def _can_be_read(keyframe: Keyframe) -> bool:
    try:
        keyframe.pixels()
    except FrameError:
        return False
    return True


def _add_matches(index: PictureIndex, keyframes: list[Keyframe], calibration: dict[str, Any]) -> None:
    """Of keyframes that follow each other and of those that meet again, a few are registered anew."""
    settings = {"frames.places": "frame", "frames.keypoints.max_keypoints": 800}
    reader = _core.FrameReader(settings, calibration)
    middle = np.array([calibration["centre_x_px"], calibration["centre_y_px"], 1.0])
    place = np.array([keyframe.placed @ middle for keyframe in keyframes])
    place = place[:, :2] / place[:, 2:]
    pairs = [(k, k + 1) for k in np.unique(np.linspace(0, len(keyframes) - 2, 5).astype(int)).tolist()] if len(keyframes) > 1 else []
    far = []
    for second in range(FAR_KEYFRAMES, len(keyframes)):
        distance = np.linalg.norm(place[: second - FAR_KEYFRAMES + 1] - place[second], axis=1)
        far.append((float(distance.min()), int(distance.argmin()), second))
    pairs += [(first, second) for _, first, second in sorted(far)[:MATCHED_FRAMES]]
    features: dict[int, Any] = {}
    links: dict[tuple[int, int], dict[str, Any]] = {}
    for first, second in pairs:
        for number in (first, second):
            if number not in features:
                features[number] = reader.read(keyframes[number].pixels())
        found = _core.register_frames(features[first], features[second], settings)
        if found is not None:
            links[first, second] = found
    for first, second in shown_links(links, FAR_KEYFRAMES - 1):
        rows = links[first, second]["inliers"]
        index.add_matches(
            (keyframes[first].path.name, keyframes[second].path.name),
            (reader.corrected(keyframes[first].pixels()), reader.corrected(keyframes[second].pixels())),
            (features[first].keypoints["position_px"][rows[:, 0]], features[second].keypoints["position_px"][rows[:, 1]]),
            seconds_apart=keyframes[second].time_s - keyframes[first].time_s,
        )
