"""batch through the command line: one mission does not hold up another, nothing is done twice, and a killed call loses nothing."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from ssjs_cli.studies.season import worst_first

MEASURED = ("time_total_s", "peak_rss_mb")
DEADLINE_S = 120.0


@pytest.fixture
def missions(cli: Callable[..., Any], small_scenario: Path, tmp_path: Path) -> list[Path]:
    folders = [tmp_path / "missions" / f"dive{seed}" for seed in (1, 2, 3)]
    for seed, folder in enumerate(folders, start=1):
        assert cli("simulate", small_scenario, "--seed", seed, "--out", folder).code == 0
    return folders


def rows(folder: Path) -> dict[str, dict[str, Any]]:
    """By the path of the mission, without what differs from one call to the next."""
    document = json.loads((folder / "season.json").read_text())
    return {row["path"]: {key: value for key, value in row.items() if key not in MEASURED} for row in document["missions"]}


def results(folder: Path) -> dict[str, bytes]:
    names = ("trajectory.tum", "landmarks.csv", "submaps.json", "config.toml")
    return {f"{run.name}/{name}": (run / name).read_bytes() for run in sorted((folder / "missions").iterdir()) for name in names}


def test_every_mission_gets_the_run_that_it_would_get_alone(cli: Callable[..., Any], missions: list[Path], tmp_path: Path) -> None:
    answer = cli("batch", *missions, "--out", tmp_path / "season", "--jobs", 2)
    assert answer.code == 0, answer.err
    assert cli("run", missions[1], "--out", tmp_path / "alone").code == 0
    row = rows(tmp_path / "season")[missions[1].as_posix()]
    together = tmp_path / "season" / row["directory"]
    for name in ("trajectory.tum", "landmarks.csv", "submaps.json", "config.toml"):
        assert (together / name).read_bytes() == (tmp_path / "alone" / name).read_bytes()
    assert (together / "report.html").is_file()
    alone = json.loads((tmp_path / "alone" / "summary.json").read_text())
    assert row["trajectory_rmse_m"] == alone["trajectory_rmse_m"] is not None
    assert "dive" not in row["mission"] and (tmp_path / "season" / "report.html").is_file()


def test_a_mission_that_fails_is_a_row_with_its_reason(cli: Callable[..., Any], missions: list[Path], tmp_path: Path) -> None:
    (missions[0] / "mission.toml").write_text("name")
    (missions[1] / "odometry.csv").write_text("time_s,speed_m_s,steering_rad\n0,1,nonsense\n")
    nowhere = tmp_path / "nowhere"
    answer = cli("batch", *missions, nowhere, "--out", tmp_path / "season")
    assert answer.code == 3
    found = rows(tmp_path / "season")
    assert "mission.toml" in found[missions[0].as_posix()]["reason"]
    assert "odometry.csv" in found[missions[1].as_posix()]["reason"]
    assert "no mission directory" in found[nowhere.as_posix()]["reason"]
    assert found[missions[2].as_posix()]["reason"] is None
    assert len(list((tmp_path / "season" / "missions").iterdir())) == 1


def test_the_same_command_does_the_rest_and_no_more(cli: Callable[..., Any], missions: list[Path], tmp_path: Path) -> None:
    season = tmp_path / "season"
    assert cli("batch", *missions[:2], "--out", season).code == 0
    marks = {path: path.stat().st_mtime_ns for path in (season / "missions").rglob("*")}
    assert cli("batch", *missions, "--out", season, "--resume").code == 0
    assert {path: path.stat().st_mtime_ns for path in marks} == marks
    assert len(rows(season)) == 3
    shutil.rmtree(season / rows(season)[missions[0].as_posix()]["directory"])  # lost: done again
    before = rows(season)
    assert cli("batch", *missions, "--out", season, "--resume").code == 0
    assert rows(season) == before
    assert (season / before[missions[0].as_posix()]["directory"] / "summary.json").is_file()


def test_other_settings_or_other_data_are_other_runs(cli: Callable[..., Any], missions: list[Path], tmp_path: Path) -> None:
    season = tmp_path / "season"
    assert cli("batch", missions[0], "--out", season).code == 0
    assert cli("batch", missions[0], "--out", season, "--method", "ekf").code == 0
    with (missions[0] / "odometry.csv").open("a") as file:
        last = (missions[0] / "odometry.csv").read_text().splitlines()[-1].split(",")
        file.write(f"{float(last[0]) + 0.1},{last[1]},{last[2]}\n")
    assert cli("batch", missions[0], "--out", season, "--method", "ekf").code == 0
    assert len(list((season / "missions").iterdir())) == 3


def test_resume_wants_something_to_resume(cli: Callable[..., Any], missions: list[Path], tmp_path: Path) -> None:
    answer = cli("batch", missions[0], "--out", tmp_path / "season", "--resume")
    assert answer.code == 2
    assert "holds no batch" in answer.err
    assert not (tmp_path / "season").exists()


@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="needs /proc")
def test_killed_workers_and_a_killed_call_lose_nothing(cli: Callable[..., Any], missions: list[Path], tmp_path: Path) -> None:
    calm, season = tmp_path / "calm", tmp_path / "season"
    assert cli("batch", *missions, "--out", calm).code == 0
    command = [sys.executable, "-m", "ssjs_cli", "batch", *map(str, missions), "--out", str(season), "--jobs", "1"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    deadline_s = time.monotonic() + DEADLINE_S
    while not list((season / "runs").glob("*.json") if season.is_dir() else []):
        assert process.poll() is None and time.monotonic() < deadline_s
        time.sleep(0.01)
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    for child in children:
        os.kill(int(child), signal.SIGKILL)
    process.kill()
    process.communicate()
    assert cli("batch", *missions, "--out", season, "--resume").code == 0
    assert rows(season) == rows(calm)
    assert results(season) == results(calm)
    assert not list((season / "missions").glob(".*"))


def test_what_stands_out_comes_first() -> None:
    season = [{"mission": str(i), "reason": None, "nis_mean": 1.0 + 0.01 * i} for i in range(8)]
    season.append({"mission": "odd", "reason": None, "nis_mean": 9.0})
    season.append({"mission": "failed", "reason": "no odometry", "nis_mean": None})
    ordered = worst_first(season)
    assert [row["mission"] for row in ordered[:2]] == ["failed", "odd"]
    assert ordered[1]["stands_out_by"] == "nis_mean" and ordered[1]["outlier_score"] > 5.0
    assert all(row["outlier_score"] is None or row["outlier_score"] < 1.0 for row in ordered[2:])
