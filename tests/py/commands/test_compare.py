import csv
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from ssjs_cli.config import METHOD_KEY, field_descriptions
from ssjs_cli.formats.run_directory import MEASURED_KEYS, STEP_TIME_KEYS, TIME_KEYS

# docs of the command line: every key of summary.json is a key of a row
CONTRACT = [
    *MEASURED_KEYS, *TIME_KEYS, *STEP_TIME_KEYS, "peak_rss_mb",
    "trajectory_rmse_m", "trajectory_mean_m", "trajectory_std_m", "trajectory_max_m", "final_drift_percent", "dead_reckoning_rmse_m",
    "dead_reckoning_final_drift_percent", "reference_outliers", "map_error_mean_m", "map_error_std_m", "map_error_max_m",
    "landmarks_missed", "landmarks_false", "nees_mean", "nees_inside_fraction", "nees_joint_per_dof", "nees_base_mean",
    "nees_map_mean", "nis_mean",
    "nis_inside_fraction", "half_chi2_initial", "half_chi2_final", "alignment",
]  # fmt: skip
MEASURED_TIMES = {*TIME_KEYS, *STEP_TIME_KEYS, "peak_rss_mb"}


def without_times(document: dict[str, Any]) -> list[dict[str, Any]]:
    return [{key: value for key, value in row.items() if key not in MEASURED_TIMES} for row in document["methods"]]


def test_every_method_of_the_estimator_is_a_row_with_every_key(cli: Callable[..., Any], circle_mission: Path, tmp_path: Path) -> None:
    answer = cli("compare", circle_mission, "--out", tmp_path / "c", "--json")
    assert answer.code in (0, 3), answer.err
    document = json.loads(answer.out)
    assert document == json.loads((tmp_path / "c" / "comparison.json").read_text())
    assert tuple(row["method"] for row in document["methods"]) == field_descriptions()[METHOD_KEY].choices
    for row in document["methods"]:
        assert set(CONTRACT) <= set(row)
    with (tmp_path / "c" / "comparison.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["method"] for row in rows] == [row["method"] for row in document["methods"]]
    assert float(rows[0]["trajectory_rmse_m"]) == document["methods"][0]["trajectory_rmse_m"]


def test_a_row_is_the_run_of_that_method(cli: Callable[..., Any], circle_mission: Path, tmp_path: Path) -> None:
    answer = cli("compare", circle_mission, "--methods", "ekf,ssjs", "--association", "nn", "--out", tmp_path / "c", "--json", "--seed", 5)
    assert answer.code == 0, answer.err
    for row in json.loads(answer.out)["methods"]:
        run = cli(
            "run", circle_mission, "--method", row["method"], "--association", "nn", "--seed", 5, "--out", tmp_path / row["method"],
            "--no-report", "--json",
        )  # fmt: skip
        summary = json.loads(run.out)
        assert {key: row[key] for key in CONTRACT if key not in MEASURED_TIMES} == {
            key: summary[key] for key in CONTRACT if key not in MEASURED_TIMES
        }
        # a process of its own has its own largest memory, far below that of the tests, and no run without any
        assert 20.0 < row["peak_rss_mb"] < 1000.0
        assert row["time_total_s"] > 0.0
        # three degrees of freedom, two-sided 95 %: 0.216 to 9.348 (tables)
        assert row["nees_band_low"] == pytest.approx(0.216, abs=1e-3)
        assert row["nees_band_high"] == pytest.approx(9.348, abs=1e-3)
        assert row["nis_band_low"] < 1.0 < row["nis_band_high"]


def test_repeats_take_turns_and_their_median_counts(cli: Callable[..., Any], circle_mission: Path, tmp_path: Path) -> None:
    answer = cli("compare", circle_mission, "--methods", "ssjs,ekf", "--repeat", 3, "--out", tmp_path / "c", "--json")
    assert answer.code == 0, answer.err
    runs = [json.loads(path.read_text()) for path in sorted((tmp_path / "c" / "runs").iterdir(), key=lambda path: path.stat().st_mtime_ns)]
    order = [(run["identity"]["repeat"], run["identity"]["settings"]["method"]) for run in runs]
    assert order == [(repeat, method) for repeat in range(3) for method in ("ssjs", "ekf")]
    for row in json.loads(answer.out)["methods"]:
        times = sorted(run["record"]["summary"]["time_total_s"] for run in runs if run["identity"]["settings"]["method"] == row["method"])
        assert row["time_total_s"] == times[1]
        assert row["repeats"] == 3


def test_the_same_command_gives_the_same_answer_and_force_another_time(
    cli: Callable[..., Any], circle_mission: Path, tmp_path: Path
) -> None:
    command = ["compare", circle_mission, "--methods", "ssjs,ekf", "--out", tmp_path / "c", "--json"]
    first, second, anew = (cli(*command, *more) for more in ([], [], ["--force"]))
    assert first.out == second.out
    assert "2 of 2" not in anew.err
    assert without_times(json.loads(anew.out)) == without_times(json.loads(first.out))


def test_a_method_that_cannot_finish_says_why_and_the_rest_goes_on(
    cli: Callable[..., Any], circle_mission: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from ssjs_cli.studies import comparison
    from ssjs_cli.studies.executor import Outcome, attempt

    class EkfDies:
        def __init__(self, workers: int, *, fresh_processes: bool, time_limit_s: float | None) -> None:
            assert (workers, fresh_processes, time_limit_s) == (1, True, None)

        def outcomes(self, work: Any, jobs: Any) -> Any:
            for job in jobs:
                dies = job.payload.settings["method"] == "ekf"
                yield Outcome(job.key, reason="its worker process died 3 times") if dies else attempt(work, job)

    monkeypatch.setattr(comparison, "ProcessPool", EkfDies)
    command = ["compare", circle_mission, "--methods", "ekf,ssjs", "--out", tmp_path / "c", "--json"]
    answer = cli(*command)
    assert answer.code == 3
    assert "lost: ekf: its worker process died 3 times" in answer.err
    ekf, ssjs = json.loads(answer.out)["methods"]
    assert (ekf["reason"], ekf["trajectory_rmse_m"]) == ("its worker process died 3 times", None)
    assert (ssjs["reason"], ssjs["repeats"]) == (None, 1)
    assert "its worker process died 3 times" in (tmp_path / "c" / "report.html").read_text()
    # what may have passed is tried again, and only that
    monkeypatch.undo()
    answer = cli(*command)
    assert answer.code == 0
    assert "1 of 2 runs are finished already" in answer.err
    assert json.loads(answer.out)["methods"][0]["reason"] is None


def test_what_the_mission_loses_is_said(cli: Callable[..., Any], circle_mission: Path, tmp_path: Path) -> None:
    with (circle_mission / "observations.csv").open("a") as file:
        file.write("999.0,5.0,0.1,1\n")
    answer = cli("compare", circle_mission, "--methods", "ssjs", "--out", tmp_path / "c")
    assert answer.code == 3
    assert "lost: ssjs: 1 of " in answer.err


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--methods", "efk"], "--methods: 'efk' is no method (did you mean 'ekf'?); the known ones are ssjs, "),
        (["--methods", "all,ekf"], "'all' is no method"),
        (["--repeat", 0], "'--repeat': 0 is not in the range"),
        (["--association", "jcb"], "did you mean 'jcbb'?"),
        (["--set", "submap.max_landmarks=2"], "submap.max_landmarks = 2: must be at least"),
    ],
)
def test_faulty_usage_is_named(cli: Callable[..., Any], circle_mission: Path, tmp_path: Path, options: list[Any], message: str) -> None:
    answer = cli("compare", circle_mission, "--out", tmp_path / "c", *options)
    assert answer.code == 2
    assert message in answer.err
    assert not (tmp_path / "c").exists()


def test_a_faulty_mission_is_the_users_error(cli: Callable[..., Any], circle_mission: Path, tmp_path: Path) -> None:
    assert cli("compare", tmp_path / "nowhere", "--out", tmp_path / "c").code == 2
    (circle_mission / "odometry.csv").write_text("time_s,speed_m_s,turn_rate_rad_s\n0,x,0\n")
    answer = cli("compare", circle_mission, "--out", tmp_path / "c")
    assert answer.code == 2
    assert "odometry.csv:2: speed_m_s = 'x' is not a number" in answer.err


def test_an_output_that_cannot_be_written(cli: Callable[..., Any], circle_mission: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    answer = cli("compare", circle_mission, "--methods", "ssjs", "--out", tmp_path / "file" / "below")
    assert answer.code == 2
    assert "Not a directory" in answer.err
    answer = cli("compare", circle_mission, "--methods", "ssjs", "--out", circle_mission)
    assert answer.code == 2
    assert "is no study" in answer.err
