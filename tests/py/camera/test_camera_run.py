"""Camera missions with navigation: simulated, run, and run with frames that are worth nothing."""

import csv
import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image, ImageFilter

from ssjs_cli.camera.frame_reading import read_keypoints
from ssjs_cli.camera.landmark_truth import seen_points_m
from ssjs_cli.camera_simulation import SimulatedCamera
from ssjs_cli.config import UNDERWATER, defaults
from ssjs_cli.formats.camera_calibration import calibration_text
from ssjs_cli.formats.frames import read_frames
from ssjs_cli.formats.mission import read_mission
from ssjs_cli.formats.true_surface import TrueSurface, read_true_surface, write_true_surface
from ssjs_cli.mission_run import RunRequest, resolve_settings

LINES = {"lines": {"lines": 1, "line_length_m": 2.0, "cross_lines": 0}}


def frames_of(run: Path) -> dict[str, dict[str, str]]:
    with (run / "frames.csv").open(newline="") as file:
        return {row["file"]: row for row in csv.DictReader(file)}


def test_the_camera_improves_on_dead_reckoning(cli: Callable[..., Any], short_survey: Path, tmp_path: Path) -> None:
    answer = cli("run", short_survey, "--out", tmp_path / "run", "--json")
    assert answer.code == 0, answer.err
    summary = json.loads(answer.out)
    frames = len(read_mission(short_survey).time_s) and summary["frames"]
    assert summary["frames_used"] == frames > 100
    assert 0 < summary["frames_with_region"] < frames
    assert summary["frames_left_out"] == {}
    assert summary["landmarks_compared"] > 20
    assert summary["landmark_error_rms_m"] < 0.3
    assert summary["trajectory_rmse_m"] < summary["dead_reckoning_rmse_m"]
    assert summary["inside_3_sigma_fraction"] >= 0.95
    assert {"frames/index.csv", "frames/camera.yaml", "frames/*"} <= set(summary["input_digests"])
    assert "of 320 x 240" not in answer.err
    assert sum(row["regions"] != "0" for row in frames_of(tmp_path / "run").values()) == summary["frames_with_region"]


def test_what_camera_missions_bring_along_gives_way_to_the_users_settings(short_survey: Path) -> None:
    def settings_of(*assignments: str) -> Mapping[str, Any]:
        request = RunRequest(short_survey, assignments=list(assignments))
        return resolve_settings(request, short_survey, read_mission(short_survey))[0].values

    usual, brought, asked = defaults(UNDERWATER), settings_of(), settings_of("camera.sigma_px=1.5")
    assert usual["joining.max_chance_alignments"] is None and brought["joining.max_chance_alignments"] == 0.001
    assert brought["joining.max_chance_odds"] == 0.01 < usual["joining.max_chance_odds"]
    assert brought["camera.relief"] == 0.1 < usual["camera.relief"]
    assert (usual["camera.sigma_px"], brought["camera.sigma_px"], asked["camera.sigma_px"]) == (1.0, 0.7, 1.5)
    assert brought["camera.fx_px"] == asked["camera.fx_px"] != usual["camera.fx_px"]


def test_the_same_keypoints_from_any_number_of_threads(short_survey: Path) -> None:
    frames = read_frames(short_survey)
    assert frames is not None
    settings = defaults(UNDERWATER)
    one, outcomes = read_keypoints(frames, settings, (-np.inf, np.inf), workers=1)
    many, same_outcomes = read_keypoints(frames, settings, (-np.inf, np.inf), workers=5)
    assert outcomes == same_outcomes
    for name in ("time_s", "count", "pixel", "descriptor"):
        np.testing.assert_array_equal(getattr(one, name), getattr(many, name))


def test_the_same_frames_from_any_number_of_threads(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pictures = []
    for processors in (1, 4):
        monkeypatch.setattr(os, "sched_getaffinity", lambda _, count=processors: set(range(count)))
        folder = tmp_path / str(processors)
        folder.mkdir()
        SimulatedCamera("camera-survey", "short", LINES, 5).photograph(folder)
        pictures.append({path.name: path.read_bytes() for path in folder.iterdir()})
    assert pictures[0] == pictures[1]
    assert len(pictures[0]) > 20


def test_frames_that_are_worth_nothing_are_named_and_none_is_fatal(
    cli: Callable[..., Any], short_survey: Path, copy_of: Callable[[Path], Path], tmp_path: Path
) -> None:
    mission = copy_of(short_survey)
    frames = mission / "frames"

    def changed(name: str, change: Callable[[Image.Image], Image.Image]) -> None:
        with Image.open(frames / name) as picture:
            change(picture.convert("RGB")).save(frames / name, quality=92)

    changed("000010.jpg", lambda picture: picture.point(lambda level: level // 60))
    changed("000020.jpg", lambda picture: Image.new("RGB", picture.size, (90, 100, 80)))
    changed("000030.jpg", lambda picture: picture.filter(ImageFilter.GaussianBlur(6)))
    (frames / "000041.jpg").write_bytes((frames / "000040.jpg").read_bytes())
    (frames / "000050.jpg").unlink()
    (frames / "000060.jpg").write_bytes((frames / "000060.jpg").read_bytes()[:500])
    (frames / "000070.jpg").write_bytes(b"no picture at all")
    changed("000080.jpg", lambda picture: picture.resize((160, 120)))
    text = (frames / "index.csv").read_text()
    (frames / "index.csv").write_text(text + "500,000081.jpg\n")

    answer = cli("run", mission, "--out", tmp_path / "run", "--json")
    assert answer.code == 3, answer.err
    summary = json.loads(answer.out)
    assert summary["frames_left_out"] == {
        "blank": 1, "blurred": 1, "damaged": 2, "dark": 1, "duplicate": 1, "missing": 1, "outside": 1, "size": 1,
    }  # fmt: skip
    assert summary["frames_used"] == summary["frames"] - 9
    found = list(csv.reader((tmp_path / "run" / "frames.csv").open(newline="")))[1:]
    reasons = {row[1]: (row[2], row[3]) for row in found if row[2]}
    assert reasons["000010.jpg"][1].startswith("is dark: mean level")
    assert reasons["000020.jpg"][1].startswith("is blank: levels vary by")
    assert reasons["000030.jpg"][1].startswith("is blurred: sharpness")
    assert reasons["000041.jpg"] == ("duplicate", "is a duplicate of 000040.jpg")
    assert reasons["000050.jpg"] == ("missing", "is missing")
    assert reasons["000060.jpg"][1].startswith("is damaged or cut off")
    assert reasons["000070.jpg"][1].startswith("is no image of a known kind")
    assert reasons["000080.jpg"] == ("size", "has 160 x 120 pixels, and its calibration is of 320 x 240")
    lost = "\n".join(summary["lost"])
    for name in ("000041", "000050", "000060", "000070", "000080", "000081"):  # dark, blank and blurred ones are no loss
        assert name in lost
    assert "000010" not in lost
    assert summary["trajectory_rmse_m"] < 0.5


def test_a_calibration_of_another_size_leaves_dead_reckoning(
    cli: Callable[..., Any], short_survey: Path, copy_of: Callable[[Path], Path], tmp_path: Path
) -> None:
    mission = copy_of(short_survey)
    frames = read_frames(mission)
    assert frames is not None and frames.calibration is not None
    text = calibration_text(frames.calibration).replace("image_width: 320", "image_width: 640")
    (mission / "frames" / "camera.yaml").write_text(text)
    answer = cli("run", mission, "--out", tmp_path / "run", "--json")
    assert answer.code == 3, answer.err
    summary = json.loads(answer.out)
    assert summary["frames_used"] == 0 and summary["frames_left_out"] == {"size": summary["frames"]}
    assert "has 320 x 240 pixels, and its calibration is of 640 x 240" in summary["lost"][0]
    assert summary["landmarks"] == 0


def test_without_a_calibration_the_run_says_what_is_missing(
    cli: Callable[..., Any], short_survey: Path, copy_of: Callable[[Path], Path], tmp_path: Path
) -> None:
    mission = copy_of(short_survey)
    (mission / "frames" / "camera.yaml").unlink()
    answer = cli("run", mission, "--out", tmp_path / "run")
    assert answer.code == 2
    assert "camera.yaml: is missing" in answer.err


def test_an_unknown_key_of_the_simulator_is_named(cli: Callable[..., Any], tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text('scenario = "camera-survey"\n[survey.camera]\nfocal = 3.0\n')
    answer = cli("simulate", tmp_path / "a.toml", "--out", tmp_path / "mission")
    assert answer.code == 2
    assert "camera.focal" in answer.err


def test_the_true_depths_read_back_to_a_tenth_of_a_millimetre(tmp_path: Path) -> None:
    depth_m = np.random.default_rng(1).uniform(17.0, 19.0, (5, 4)).astype(np.float32)
    write_true_surface(tmp_path, TrueSurface(np.array([-1.0, 2.0]), 0.5, depth_m))
    read = read_true_surface(tmp_path)
    assert read is not None and read.cell_m == 0.5
    np.testing.assert_allclose(read.depth_m, depth_m, atol=0.6e-4)
    # the middle of a cell is the mean of its corners; beyond the border its value goes on
    middle = read.at(np.array([-0.75, 99.0]), np.array([2.25, 99.0]))
    np.testing.assert_allclose(middle, [depth_m[:2, :2].mean(), depth_m[-1, -1]], atol=1e-4)


def test_where_a_pixel_lies_on_a_slope() -> None:
    """The camera 2 m over the origin, the vehicle heading east, the seabed z = 10 + 0.1 x (x north). A pixel 100 columns to the left
    at f = 200 looks 0.5 to port, north: x = 0.5 h with h = 2 + 0.1 x, so x = 1/0.95."""
    x = np.arange(-5.0, 5.5, 0.5)
    surface = TrueSurface(np.array([-5.0, -5.0]), 0.5, np.repeat((10.0 + 0.1 * x)[:, None], len(x), axis=1).astype(np.float32))
    camera = {
        "fx_px": 200.0, "fy_px": 200.0, "cx_px": 160.0, "cy_px": 120.0, "mount_roll_rad": 0.0, "mount_pitch_rad": 0.0,
        "mount_yaw_rad": np.pi / 2, "mount_forward_m": 0.0, "mount_starboard_m": 0.0, "mount_down_m": 0.0,
    }  # fmt: skip
    pose = np.array([[0.0, 0.0, 8.0, 0.0, 0.0, np.pi / 2]])
    seen = seen_points_m(pose, np.array([[60.0, 120.0]]), surface, camera)
    np.testing.assert_allclose(seen, [[1.0 / 0.95, 0.0, 10.0 + 0.1 / 0.95]], atol=1e-5)


def test_studies_look_at_the_frames_too(cli: Callable[..., Any], short_survey: Path, tmp_path: Path) -> None:
    answer = cli("compare", short_survey, "--methods", "ssjs", "--out", tmp_path / "comparison", "--json")
    assert answer.code == 0, answer.err
    assert json.loads(answer.out)["methods"][0]["landmarks"] > 20
