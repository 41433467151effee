"""Random points of the mosaic as landmarks of a camera mission with navigation (thesis 5.3): each is seen in the keyframe whose middle is
nearest and in those registered with it, with a known identity. docs/math/optical.md (V-25), (V-26)"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from ssjs_cli import _core
from ssjs_cli.config import LANDMARK_SOURCE, MOSAIC_POINTS, Scalar
from ssjs_cli.errors import UserError
from ssjs_cli.formats.frames import FrameIndex, FrameKeypoints
from ssjs_cli.formats.mission import Mission
from ssjs_cli.formats.navigation import Scalars
from ssjs_cli.formats.number_table import FloatArray
from ssjs_cli.formats.run_directory import estimate_of
from ssjs_cli.formats.tum import PoseSeries
from ssjs_cli.optical.keyframes import Keyframe, keyframes, middles

#: Of the shorter side of what a frame shows: a point is seen by several keyframes of a line.
STEP = 0.15
#: Keyframes farther apart than this part of the longer side are not compared, and each with so many others at most.
REACH = 0.8
MOST_NEIGHBOURS = 12
SETTINGS: dict[str, Scalar] = {"frames.places": "frame", "frames.keypoints.max_keypoints": 500}


def mosaic_landmarks(
    frames: FrameIndex,
    used: Sequence[tuple[float, str]],
    track: PoseSeries,
    altitude: Scalars | None,
    settings: Mapping[str, Scalar],
    count: int,
    seed: int,
) -> FrameKeypoints:
    """track: as good as it is known, it decides where points lie, not where they are seen."""
    chosen = keyframes(frames, used, track, altitude, settings, STEP)
    if frames.calibration is None or len(chosen) < 2:
        raise UserError(f"{frames.folder}: a mosaic needs a calibration, altitudes and two frames at least; use frames.landmarks=keypoints")
    calibration = asdict(frames.calibration)
    size = (calibration["width_px"], calibration["height_px"])
    links = _links(chosen, calibration)
    if not links:
        raise UserError(f"{frames.folder}: no two keyframes register, so points of the mosaic would be seen once each")
    table = _core.mosaic_points([keyframe.placed for keyframe in chosen], *size, links, count, seed)
    counts = np.bincount(table["frame"], minlength=len(chosen))
    shown = np.flatnonzero(counts)
    return FrameKeypoints(
        np.array([chosen[number].time_s for number in shown.tolist()]),
        counts[shown],
        table["pixel"],
        np.zeros((0, 0), dtype=np.float32),
        table["point"],
    )


def with_mosaic_points(
    mission: Mission, used: Sequence[tuple[float, str]], settings: Mapping[str, Scalar], result: Mapping[str, Any], seed: int
) -> Mission:
    """result: of a run with keypoints, whose track makes the mosaic."""
    if mission.frames is None or mission.navigation is None:
        raise UserError(f"{LANDMARK_SOURCE}: points of a mosaic are for missions with frames; use keypoints")
    track = estimate_of(result).final
    count = int(settings[MOSAIC_POINTS] or 0)
    keypoints = mosaic_landmarks(mission.frames, used, track, mission.navigation.altitude, settings, count, seed)
    return replace(mission, keypoints=keypoints)


def _links(chosen: list[Keyframe], calibration: dict[str, Any]) -> list[tuple[int, int, FloatArray]]:
    reader = _core.FrameReader(SETTINGS, calibration)
    features = [reader.read(keyframe.pixels()) for keyframe in chosen]
    place = middles(chosen, calibration)
    corner = np.array([-0.5, calibration["centre_y_px"], 1.0])
    links = []
    for second, keyframe in enumerate(chosen):
        side = keyframe.placed @ corner
        half = float(np.linalg.norm(side[:2] / side[2] - place[second]))
        distance = np.linalg.norm(place[:second] - place[second], axis=1)
        near = np.argsort(distance, kind="stable")[:MOST_NEIGHBOURS]
        for first in sorted(near[distance[near] < 2.0 * REACH * half].tolist()):
            found = _core.register_frames(features[first], features[second], SETTINGS)
            if found is not None:
                links.append((first, second, found["second_H_first"]))
    return links
