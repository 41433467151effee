import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ssjs_cli.formats.number_table import read_table
from ssjs_cli.formats.tum import PoseSeries, read_tum, write_tum


def summary_of(run: Path) -> dict[str, Any]:
    document: dict[str, Any] = json.loads((run / "summary.json").read_text())
    return document


@pytest.fixture
def run(cli: Callable[..., Any], circle_mission: Path, tmp_path: Path) -> Path:
    assert cli("run", circle_mission, "--out", tmp_path / "run", "--no-report").code == 0
    return tmp_path / "run"


def test_evaluating_again_changes_nothing(cli: Callable[..., Any], run: Path) -> None:
    before = summary_of(run)
    answer = cli("evaluate", run)
    assert answer.code == 0, answer.err
    assert summary_of(run) == before


def test_another_alignment_updates_the_keys_that_depend_on_it(cli: Callable[..., Any], run: Path) -> None:
    before = summary_of(run)
    assert cli("evaluate", run, "--align", "se2").code == 0
    after = summary_of(run)
    assert after["alignment"] == "se2"
    assert after["trajectory_rmse_m"] < before["trajectory_rmse_m"]
    assert after["nis_mean"] == before["nis_mean"]
    assert after["time_total_s"] == before["time_total_s"]
    assert after["nees_mean"] == pytest.approx(before["nees_mean"])


def test_a_given_trajectory_is_the_reference(cli: Callable[..., Any], run: Path, tmp_path: Path) -> None:
    """The estimate itself, moved by (3, 4): an error of 5 m everywhere."""
    final = read_tum(run / "trajectory.tum")
    write_tum(tmp_path / "truth.tum", PoseSeries(final.time_s, final.pose + np.array([3.0, 4.0, 0.0])))
    assert cli("evaluate", run, "--truth", tmp_path / "truth.tum", "--align", "none").code == 0
    assert summary_of(run)["trajectory_mean_m"] == pytest.approx(5.0, abs=1e-3)
    # No surveyed landmarks came with it.
    assert summary_of(run)["map_error_mean_m"] is None


def test_given_fixes_are_the_reference(cli: Callable[..., Any], run: Path, tmp_path: Path) -> None:
    (tmp_path / "fixes.csv").write_text("time_s,x_m,y_m\n10.0,0,0\n20.0,1,1\n30.0,2,2\n")
    answer = cli("evaluate", run, "--truth", tmp_path / "fixes.csv", "--json")
    assert answer.code == 0
    assert json.loads(answer.out)["reference_compared"] == 3
    assert read_table(run / "errors.csv", required=("time_s",), other_columns_allowed=True)["time_s"].tolist() == [10.0, 20.0, 30.0]
    assert not (run / "nees.csv").exists()
    assert summary_of(run)["nees_mean"] is None


def test_a_mission_directory_may_be_the_reference(cli: Callable[..., Any], run: Path, circle_mission: Path, tmp_path: Path) -> None:
    before = summary_of(run)
    shutil.move(circle_mission, tmp_path / "elsewhere")
    assert cli("evaluate", run, "--truth", tmp_path / "elsewhere").code == 0
    assert summary_of(run) == before


def test_the_evaluation_may_go_elsewhere(cli: Callable[..., Any], run: Path, tmp_path: Path) -> None:
    before = (run / "summary.json").read_bytes()
    assert cli("evaluate", run, "--align", "se2", "--out", tmp_path / "evaluation").code == 0
    assert (run / "summary.json").read_bytes() == before
    assert summary_of(tmp_path / "evaluation")["alignment"] == "se2"
    assert (tmp_path / "evaluation" / "errors.csv").is_file()
    assert cli("evaluate", run, "--out", tmp_path / "evaluation").code == 2


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--align", "se3"], "--align se3: must be one of none, origin, yaw, se2 (did you mean 'se2'?)"),
        (["--truth", "nowhere.tum"], "nowhere.tum: is missing; check the path"),
    ],
)
def test_wrong_arguments_are_the_users_error(cli: Callable[..., Any], run: Path, arguments: list[str], message: str) -> None:
    before = summary_of(run)
    answer = cli("evaluate", run, *arguments)
    assert answer.code == 2
    assert message in answer.err
    assert summary_of(run) == before


def test_a_mission_that_moved_away_is_named(cli: Callable[..., Any], run: Path, circle_mission: Path, tmp_path: Path) -> None:
    shutil.move(circle_mission, tmp_path / "elsewhere")
    answer = cli("evaluate", run)
    assert answer.code == 2
    assert f"its mission is no longer at {circle_mission}; give --truth FILE" in answer.err


def test_a_reference_of_another_time_leaves_the_run_as_it_was(cli: Callable[..., Any], run: Path, tmp_path: Path) -> None:
    (tmp_path / "fixes.csv").write_text("time_s,x_m,y_m\n99999,0,0\n")
    before = {path.name: path.read_bytes() for path in run.iterdir()}
    answer = cli("evaluate", run, "--truth", tmp_path / "fixes.csv")
    assert answer.code == 2
    assert "no fix could be compared" in answer.err
    assert {path.name: path.read_bytes() for path in run.iterdir()} == before


def test_a_directory_that_is_no_run_is_refused(cli: Callable[..., Any], tmp_path: Path) -> None:
    answer = cli("evaluate", tmp_path)
    assert answer.code == 2
    assert "summary.json: is missing; name a directory that a finished run has written" in answer.err
