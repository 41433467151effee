"""Pictures of camera missions with navigation, from poses that are known."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from navigated_frames import DEPTH_M, GROUND_PX, METRES_PER_PX, SEABED_M, poses, write_frames
from PIL import Image
from seabed_frames import pebbles

from ssjs_cli.formats.frames import FrameIndex
from ssjs_cli.formats.navigation import Scalars
from ssjs_cli.formats.number_table import IntArray
from ssjs_cli.formats.tum import PoseSeries
from ssjs_cli.optical.camera_output import write_camera_pictures
from ssjs_cli.optical.sighting_pictures import ellipse, sighting_picture, sightings_by_time


def write(run: Path, index: FrameIndex, result: dict[str, Any] | None = None, ids: IntArray | None = None) -> dict[str, Any]:
    run.mkdir()
    pose = poses()
    track = PoseSeries(index.time_s, pose[:, [0, 1, 5]], pose[:, 2:5])
    altitude = Scalars(index.time_s, np.full(26, SEABED_M - DEPTH_M))
    used = list(zip(index.time_s.tolist(), index.files, strict=True))
    write_camera_pictures(run, index, used, 7, track, altitude, result or {}, {}, ids)
    document: dict[str, Any] = json.loads((run / "pictures" / "pictures.json").read_text())
    return document


def test_the_mosaic_is_the_ground(tmp_path: Path) -> None:
    index = write(tmp_path / "run", write_frames(tmp_path / "frames"))
    place = index["mosaic"]
    assert index["frames"] == {"given": 26, "used": 26, "with_region": 7}
    with Image.open(tmp_path / "run" / "pictures" / "mosaic.jpg") as picture:
        mosaic = np.asarray(picture.convert("L"), dtype=float)
    ground = np.asarray(pebbles(GROUND_PX, GROUND_PX), dtype=float)
    rows, columns = np.mgrid[0 : mosaic.shape[0], 0 : mosaic.shape[1]]
    east = place["left"] + (columns + 0.5) * place["pixel_length"]
    north = place["top"] - (rows + 0.5) * place["pixel_length"]
    inside = (np.abs(east - 6.0) < 2.0) & (np.abs(north - 6.0) < 3.0)
    seen = ground[(GROUND_PX - north[inside] / METRES_PER_PX).astype(int), (east[inside] / METRES_PER_PX).astype(int)]
    assert np.corrcoef(mosaic[inside], seen)[0, 1] > 0.9


def test_matches_are_drawn_between_neighbours_and_between_lines(tmp_path: Path) -> None:
    index = write(tmp_path / "run", write_frames(tmp_path / "frames"))
    apart = [entry["seconds_apart"] for entry in index["matches"]]
    assert min(apart) < 5.0 and max(apart) >= 10.0
    assert all((tmp_path / "run" / "pictures" / entry["picture"]).is_file() for entry in index["matches"])


def test_sightings_are_drawn_where_they_are(tmp_path: Path) -> None:
    frames = write_frames(tmp_path / "frames")
    sightings = {
        "time_s": np.array([3.0, 3.0, 20.0, 21.5]),
        "measured_px": np.array([[50.0, 60.0], [100.0, 90.0], [30.0, 30.0], [1.0, 1.0]]),
        "predicted_px": np.array([[54.0, 60.0], [100.0, 80.0], [30.0, 35.0], [1.0, 1.0]]),
        "innovation_covariance_px2": np.tile([16.0, 0.0, 9.0], (4, 1)),
    }
    index = write(tmp_path / "run", frames, {"frame_sightings": sightings})
    assert [(entry["frame"], entry["sightings"]) for entry in index["sightings"]] == [("03.png", 2), ("20.png", 1)]
    rows = dict(sightings_by_time(sightings, {3.0: None, 20.0: None}, 4))
    picture = np.asarray(sighting_picture(np.zeros((180, 240), dtype=np.uint8), rows[3.0])).astype(int)
    # twice as large: predicted (54, 60) is at (108.5, 120.5), yellow; measured (50, 60) at (100.5, 120.5), blue
    assert picture[120, 106, 0] > 200 and picture[120, 106, 2] < 150
    assert picture[117, 97, 2] > 200 and picture[117, 97, 0] < 150


def test_each_landmark_has_the_patch_of_a_frame_that_showed_it(tmp_path: Path) -> None:
    """Landmark 11 was known twice, by its tracks 5 and 8; nobody saw landmark 12."""
    frames = write_frames(tmp_path / "frames")
    sightings = {
        "time_s": np.array([3.0, 3.0, 20.0]),
        "landmark": np.array([4, 5, 8]),
        "measured_px": np.array([[119.0, 90.0], [5.0, 5.0], [120.0, 80.0]]),
        "predicted_px": np.zeros((3, 2)),
        "innovation_covariance_px2": np.tile([16.0, 0.0, 9.0], (3, 1)),
    }
    result = {"frame_sightings": sightings, "landmarks": {"tracks": [[4], [5, 8], []]}}
    index = write(tmp_path / "run", frames, result, np.array([10, 11, 12]))
    assert index["landmarks"]["count"] == 2
    table = (tmp_path / "run" / "pictures" / index["landmarks"]["table"]).read_text()
    assert table == "landmark,file,u_px,v_px,row,column\n10,03.png,119.00,90.00,0,0\n11,20.png,120.00,80.00,0,1\n"
    with Image.open(tmp_path / "run" / "pictures" / index["landmarks"]["picture"]) as picture:
        assert picture.size == (96, 48)


def test_the_ellipse_is_that_of_the_covariance() -> None:
    covariance = np.array([9.0, 4.0, 4.0])
    offset = ellipse(np.array([10.0, 20.0]), covariance) - (10.0, 20.0)
    S = np.array([[9.0, 4.0], [4.0, 4.0]])
    distances = np.einsum("ij,jk,ik->i", offset, np.linalg.inv(S), offset)
    np.testing.assert_allclose(distances, 5.991464547107979)


def test_frames_without_a_calibration_leave_no_pictures(tmp_path: Path) -> None:
    frames = write_frames(tmp_path / "frames")
    bare = FrameIndex(frames.folder, frames.time_s, frames.files)
    (tmp_path / "run").mkdir()
    track = PoseSeries(frames.time_s, poses()[:, [0, 1, 5]], poses()[:, 2:5])
    write_camera_pictures(tmp_path / "run", bare, [(0.0, "00.png")], 0, track, None, {}, {})
    assert not (tmp_path / "run" / "pictures").exists()
