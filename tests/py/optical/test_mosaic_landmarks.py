"""Random points of the mosaic of a mission with navigation, seen in its frames."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from navigated_frames import CAMERA, DEPTH_M, SEABED_M, poses, write_frames

from ssjs_cli import _core
from ssjs_cli.errors import UserError
from ssjs_cli.formats.frames import FrameIndex
from ssjs_cli.formats.navigation import Scalars
from ssjs_cli.formats.tum import PoseSeries
from ssjs_cli.optical.mosaic_landmarks import mosaic_landmarks

TIME_S = np.arange(26.0)
TRACK = PoseSeries(TIME_S, poses()[:, [0, 1, 5]], poses()[:, 2:5])
ALTITUDE = Scalars(TIME_S, np.full(26, SEABED_M - DEPTH_M))


def test_a_point_is_at_one_place_in_all_frames_that_see_it(tmp_path: Path) -> None:
    frames = write_frames(tmp_path / "frames")
    used = list(zip(TIME_S.tolist(), frames.files, strict=True))
    found = mosaic_landmarks(frames, used, TRACK, ALTITUDE, {}, 300, 5)
    assert found.landmark_id is not None
    assert len(found.pixel) == len(found.landmark_id) == found.count.sum()
    assert len(np.unique(found.landmark_id)) == 300
    row = np.repeat(found.time_s.astype(int), found.count)
    on_ground = np.empty((len(row), 2))
    for sighting, (frame, pixel) in enumerate(zip(row.tolist(), found.pixel, strict=True)):
        ground = _core.ground_homography(poses()[frame], SEABED_M, dict(CAMERA.__dict__), {})
        assert ground is not None
        x, y, w = ground @ (*pixel, 1.0)
        on_ground[sighting] = x / w, y / w
    spreads, seen = [], []
    for identity in range(300):
        points = on_ground[found.landmark_id == identity]
        seen.append(len(points))
        spreads += np.linalg.norm(points - points.mean(axis=0), axis=1).tolist()
    assert np.mean(seen) >= 3.0
    assert np.median(spreads) < 0.03  # a pixel is 0.018 m
    again = mosaic_landmarks(frames, used, TRACK, ALTITUDE, {}, 300, 5)
    np.testing.assert_array_equal(again.pixel, found.pixel)


def test_without_a_calibration_or_altitudes_there_is_no_mosaic(tmp_path: Path) -> None:
    frames = write_frames(tmp_path / "frames")
    used = list(zip(TIME_S.tolist(), frames.files, strict=True))
    with pytest.raises(UserError, match="mosaic"):
        mosaic_landmarks(FrameIndex(frames.folder, frames.time_s, frames.files), used, TRACK, ALTITUDE, {}, 300, 5)
    with pytest.raises(UserError, match="mosaic"):
        mosaic_landmarks(frames, used, TRACK, None, {}, 300, 5)
