"""Runs of missions of frames alone."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from seabed_frames import METRES_PER_PX, STEP_PX, true_poses, write_mission

from ssjs_cli.formats.tum import read_tum


@pytest.fixture
def mission(tmp_path: Path) -> Path:
    write_mission(tmp_path / "pebbles")
    return tmp_path / "pebbles"


def summary_of(run: Path) -> dict[str, Any]:
    document: dict[str, Any] = json.loads((run / "summary.json").read_text())
    return document


def position_errors(run: Path, kept: list[int]) -> Any:
    """Of the final pose at each frame, about the first one."""
    track = read_tum(run / "trajectory.tum")
    rows = np.searchsorted(track.time_s, np.array(kept, dtype=float), side="right") - 1
    truth = true_poses()[kept]
    return np.linalg.norm(track.pose[rows, :2] - truth[:, :2], axis=1)


def test_the_track_is_found_and_lines_are_joined(cli: Callable[..., Any], mission: Path, tmp_path: Path) -> None:
    run = tmp_path / "run"
    assert cli("run", mission, "--out", run, "--set", "submap.max_landmarks=20").code == 0
    errors = position_errors(run, list(range(18)))
    assert errors.max() < 0.1  # the track is 10 m long: 1 %, or ten pixels
    summary = summary_of(run)
    assert (summary["frames"], summary["frames_used"], summary["frames_registered"]) == (18, 18, 17)
    assert summary["frames_on_mosaic"] == 18
    assert summary["frame_revisits"] >= 10
    assert summary["loop_closures"] >= 1
    assert summary["length_unit"] == "m"
    index = json.loads((run / "pictures" / "pictures.json").read_text())
    mosaic = index["mosaic"]
    # eight steps and a frame along x; a line gap and a frame along y
    assert mosaic["right"] - mosaic["left"] == pytest.approx(METRES_PER_PX * (8 * STEP_PX + 180), rel=0.1)
    assert mosaic["top"] - mosaic["bottom"] == pytest.approx(METRES_PER_PX * (130 + 240), rel=0.1)
    assert len(index["matches"]) >= 1
    page = (run / "report.html").read_text()
    assert 'id="frames-section"' in page and 'id="mosaic"' in page


def test_the_same_bytes_again(cli: Callable[..., Any], mission: Path, tmp_path: Path) -> None:
    for name in ("a", "b"):
        assert cli("run", mission, "--out", tmp_path / name, "--no-report").code == 0
    for file in ("trajectory.tum", "landmarks.csv", "submaps.json", "config.toml", "pictures/mosaic.jpg", "pictures/pictures.json"):
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes(), file


def test_without_a_scale_lengths_are_widths_of_a_frame(cli: Callable[..., Any], mission: Path, tmp_path: Path) -> None:
    assert cli("run", mission, "--out", tmp_path / "run", "--set", "frames.metres_per_px=none").code == 0
    assert summary_of(tmp_path / "run")["length_unit"] == "frame widths"
    track = read_tum(tmp_path / "run" / "trajectory.tum")
    assert track.pose[:, 0].max() == pytest.approx(8 * STEP_PX / 240, rel=0.05)
    assert "widths" in (tmp_path / "run" / "report.html").read_text()


def test_maps_side_by_side_have_no_metres_without_a_scale(cli: Callable[..., Any], mission: Path, tmp_path: Path) -> None:
    without = ("--set", "frames.metres_per_px=none")
    assert cli("compare", mission, "--out", tmp_path / "both", "--methods", "ssjs,ekf", *without).code == 0
    page = next((tmp_path / "both").glob("*.html")).read_text()
    assert "x [frame widths]" in page and "x [m]" not in page and "%{y:.2f} m" not in page


def test_points_of_the_mosaic_as_landmarks(cli: Callable[..., Any], mission: Path, tmp_path: Path) -> None:
    run = tmp_path / "run"
    options = ["--set", "frames.landmarks=mosaic-points", "--set", "frames.mosaic_points=300"]
    assert cli("run", mission, "--out", run, *options).code == 0
    assert 200 <= summary_of(run)["landmarks"] <= 300
    assert position_errors(run, list(range(18))).max() < 0.1


def test_bad_frames_are_named_and_none_is_fatal(cli: Callable[..., Any], mission: Path, tmp_path: Path) -> None:
    from PIL import Image

    frames = mission / "frames"
    (frames / "f03.png").unlink()
    (frames / "f05.png").write_bytes((frames / "f05.png").read_bytes()[:200])
    Image.new("L", (240, 180), 0).save(frames / "f12.png")
    (frames / "f15.png").write_bytes((frames / "f14.png").read_bytes())
    Image.new("L", (100, 80), 90).save(frames / "f17.png")
    assert cli("run", mission, "--out", tmp_path / "run").code == 3
    (lost,) = [text for text in summary_of(tmp_path / "run")["lost"] if "frames were left out" in text]
    assert lost.startswith("5 of 18")
    for name, reason in (("f03", "missing"), ("f05", "damaged"), ("f12", "dark"), ("f15", "duplicate of f14"), ("f17", "100 x 80")):
        assert f"{name}.png" in lost and reason in lost
    kept = [number for number in range(18) if number not in (3, 5, 12, 15, 17)]
    assert position_errors(tmp_path / "run", kept).max() < 0.4


def test_the_size_of_most_frames_counts_not_that_of_the_first(cli: Callable[..., Any], mission: Path, tmp_path: Path) -> None:
    from PIL import Image

    with Image.open(mission / "frames" / "f00.png") as picture:
        small = picture.resize((120, 90))
    small.save(mission / "frames" / "f00.png")
    assert cli("run", mission, "--out", tmp_path / "run").code == 3
    assert summary_of(tmp_path / "run")["frames_used"] == 17
    (lost,) = [text for text in summary_of(tmp_path / "run")["lost"] if "frames were left out" in text]
    assert "f00.png has 120 x 90 pixels, and most have 240 x 180" in lost


def test_the_longer_part_of_a_mission_with_a_pause_is_used(cli: Callable[..., Any], mission: Path, tmp_path: Path) -> None:
    index = mission / "frames" / "index.csv"
    rows = index.read_text().splitlines()
    # two frames, an hour, and the rest from another place on
    kept = [rows[0], *rows[1:3], *(f"{3600.0 + number!r},{rows[number].split(',')[1]}" for number in range(6, 19))]
    index.write_text("\n".join(kept) + "\n")
    assert cli("run", mission, "--out", tmp_path / "run").code == 3
    summary = summary_of(tmp_path / "run")
    assert any(text.startswith("2 of 15 frames lie beyond a pause") for text in summary["lost"])
    assert summary["frames_used"] == 13
    track = read_tum(tmp_path / "run" / "trajectory.tum")
    assert track.time_s[0] >= 3600.0


def test_frames_of_different_places_are_refused(cli: Callable[..., Any], mission: Path) -> None:
    rows = (mission / "frames" / "index.csv").read_text().splitlines()
    (mission / "frames" / "index.csv").write_text("\n".join([rows[0], rows[1], "1.0," + rows[9].split(",")[1]]) + "\n")
    answer = cli("run", mission)
    assert answer.code == 2
    assert "no two frames that follow each other show the same ground" in answer.err


def test_options_of_other_vehicles_are_refused(cli: Callable[..., Any], mission: Path) -> None:
    answer = cli("run", mission, "--calibrate")
    assert answer.code == 2 and "--calibrate" in answer.err
    answer = cli("run", mission, "--set", "frames.rounds=0")
    assert answer.code == 2 and "frames.rounds" in answer.err


def test_its_settings_have_their_own_defaults(cli: Callable[..., Any], mission: Path) -> None:
    dumped = cli("config", "dump", "--of", "frames", "--json")
    assert json.loads(dumped.out)["frames"]["keypoints"]["max_keypoints"] == 1000
    assert cli("config", "check", mission).code == 0
    assert cli("config", "check", mission, "--of", "underwater").code == 2
    text = (mission / "mission.toml").read_text()
    (mission / "mission.toml").write_text(text + "roundz = 3\n")
    answer = cli("config", "check", mission)
    assert answer.code == 2 and "roundz" in answer.err and "rounds" in answer.err
