"""Pictures of the run of a camera mission with navigation: the mosaic of its keyframes, matches between them, and landmarks in frames as
they were predicted and measured (thesis 5.16)."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from ssjs_cli import _core
from ssjs_cli.config import Scalar, mosaic_values
from ssjs_cli.formats.frame_image import decoded, frame_bytes
from ssjs_cli.formats.frames import FrameIndex
from ssjs_cli.formats.navigation import Scalars
from ssjs_cli.formats.number_table import IntArray
from ssjs_cli.formats.run_directory import PICTURES_FOLDER
from ssjs_cli.formats.tum import PoseSeries
from ssjs_cli.optical.keyframes import Keyframe, keyframes, middles
from ssjs_cli.optical.landmark_patches import Looks, patch_sheet
from ssjs_cli.optical.match_pictures import shown_links
from ssjs_cli.optical.mosaic_picture import draw_mosaic
from ssjs_cli.optical.picture_index import PictureIndex
from ssjs_cli.optical.sighting_pictures import sighting_picture, sightings_by_time

#: Of the shorter side of what a frame shows: the mosaic's frames are so far apart.
MOSAIC_STEP = 0.35
MAX_SIGHTING_PICTURES = 4
#: So many keyframes apart they show the same ground only when the vehicle has come back.
FAR_KEYFRAMES = 4
MATCHED_FRAMES = 12


def write_camera_pictures(
    directory: Path,
    frames: FrameIndex,
    used: Sequence[tuple[float, str]],
    with_region: int,
    track: PoseSeries,
    altitude: Scalars | None,
    result: Mapping[str, Any],
    settings: Mapping[str, Scalar],
    landmark_ids: IntArray | None = None,
) -> None:
    """used: time and file of every frame that was read; track: the final one; settings: of the run, of which those of the camera's
    mounting, [frames] and [mosaic] are looked at; landmark_ids: of the landmarks of the result, their numbers in landmarks.csv."""
    if frames.calibration is None or not used:
        return
    calibration = asdict(frames.calibration)
    reader = _core.FrameReader({}, calibration)
    index = PictureIndex(directory / PICTURES_FOLDER, "m")
    chosen = keyframes(frames, used, track, altitude, settings, MOSAIC_STEP)
    if chosen:
        placed = np.array([keyframe.placed for keyframe in chosen])
        is_colour = any(keyframe.is_colour for keyframe in chosen)

        def pixels() -> Any:
            for keyframe in chosen:
                frame = keyframe.pixels()
                yield np.repeat(frame[:, :, None], 3, axis=2) if is_colour and frame.ndim == 2 else frame

        index.add_mosaic(draw_mosaic(pixels, placed, reader, mosaic_values(settings)))
        _add_matches(index, chosen, calibration)
    files = {time_s: frames.folder / name for time_s, name in used}
    for time_s, rows in sightings_by_time(result.get("frame_sightings"), files, MAX_SIGHTING_PICTURES):
        picture = sighting_picture(reader.corrected(decoded(frame_bytes(files[time_s]))), rows)
        index.add_sighting(picture, files[time_s].name, len(rows["measured_px"]))
    looks = _looks(result, used, landmark_ids)
    size_px = (calibration["width_px"], calibration["height_px"])
    sheet = patch_sheet(looks, size_px, lambda number: reader.corrected(decoded(frame_bytes(frames.folder / used[number][1]))))
    if sheet is not None:
        index.add_landmarks(sheet, lambda number: used[number][1])
    index.frames(given=len(frames.files), used=len(used), with_region=with_region)
    index.write()


def _looks(result: Mapping[str, Any], used: Sequence[tuple[float, str]], landmark_ids: IntArray | None) -> Looks:
    """A landmark that the estimator found to be known twice has several tracks."""
    sightings = result.get("frame_sightings")
    if landmark_ids is None or sightings is None:
        return Looks(np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64), np.zeros((0, 2)))
    tracks = zip(landmark_ids.tolist(), result["landmarks"]["tracks"], strict=True)
    landmark_of_track = {track: number for number, own in tracks for track in own}
    landmark = np.array([landmark_of_track.get(track, -1) for track in np.asarray(sightings["landmark"]).tolist()], dtype=np.int64)
    frame = np.searchsorted([time_s for time_s, _ in used], np.asarray(sightings["time_s"]), side="right") - 1
    rows = landmark >= 0
    return Looks(landmark[rows], frame[rows], np.asarray(sightings["measured_px"])[rows])


def _add_matches(index: PictureIndex, chosen: list[Keyframe], calibration: dict[str, Any]) -> None:
    """Of keyframes that follow each other and of those that meet again, a few are registered anew."""
    settings = {"frames.places": "frame", "frames.keypoints.max_keypoints": 800}
    reader = _core.FrameReader(settings, calibration)
    place = middles(chosen, calibration)
    pairs = [(k, k + 1) for k in np.unique(np.linspace(0, len(chosen) - 2, 5).astype(int)).tolist()] if len(chosen) > 1 else []
    far = []
    for second in range(FAR_KEYFRAMES, len(chosen)):
        distance = np.linalg.norm(place[: second - FAR_KEYFRAMES + 1] - place[second], axis=1)
        far.append((float(distance.min()), int(distance.argmin()), second))
    pairs += [(first, second) for _, first, second in sorted(far)[:MATCHED_FRAMES]]
    features: dict[int, Any] = {}
    links: dict[tuple[int, int], dict[str, Any]] = {}
    for first, second in pairs:
        for number in (first, second):
            if number not in features:
                features[number] = reader.read(chosen[number].pixels())
        found = _core.register_frames(features[first], features[second], settings)
        if found is not None:
            links[first, second] = found
    for first, second in shown_links(links, FAR_KEYFRAMES - 1):
        rows = links[first, second]["inliers"]
        index.add_matches(
            (chosen[first].path.name, chosen[second].path.name),
            (reader.corrected(chosen[first].pixels()), reader.corrected(chosen[second].pixels())),
            (features[first].keypoints["position_px"][rows[:, 0]], features[second].keypoints["position_px"][rows[:, 1]]),
            seconds_apart=chosen[second].time_s - chosen[first].time_s,
        )
