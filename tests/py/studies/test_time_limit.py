"""--time-limit-s: a run that takes too long is ended, its row says so, and the others go on."""

import csv
import json
import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import some_work

from ssjs_cli.studies import process_pool
from ssjs_cli.studies.executor import Job
from ssjs_cli.studies.process_pool import ProcessPool

#: 3,600 landmarks: an EKF over all of them takes minutes, submap joining less than a second.
FIELD = """
name = "field"
[vehicle]
speed_m_s = 3.0
step_s = 0.1
speed_sigma_m_s = 0.3
steering_sigma_rad = 0.035
[sensor]
max_range_m = 8.0
range_sigma_m = 0.1
bearing_sigma_rad = 0.017
scan_period_s = 0.5
[landmarks.grid]
columns = 60
rows = 60
spacing_m = 5.0
jitter_m = 1.0
[path.lawn_mower]
lines = 30
line_spacing_m = 10.0
first_line_m = 2.5
start_m = 5.0
end_m = 290.0
[settings.association]
method = "known"
"""
LIMIT_S = 8.0
REASON = "not finished within the time limit of 8 s ("


@pytest.fixture
def field_scenario(tmp_path: Path) -> Path:
    path = tmp_path / "field.toml"
    path.write_text(FIELD)
    return path


def by_method(rows: list[dict[str, Any]]) -> dict[str, dict[str, Any]]:
    return {row["method"]: row for row in rows}


def test_a_method_that_takes_too_long_is_a_row_of_the_comparison(cli: Callable[..., Any], field_scenario: Path, tmp_path: Path) -> None:
    assert cli("simulate", field_scenario, "--out", tmp_path / "field").code == 0
    command = ["compare", tmp_path / "field", "--methods", "ekf,ssjs", "--out", tmp_path / "c", "--json"]
    began_s = time.monotonic()
    answer = cli(*command, "--time-limit-s", LIMIT_S)
    assert time.monotonic() - began_s < 60.0
    assert answer.code == 3, answer.err
    rows = by_method(json.loads(answer.out)["methods"])
    assert rows["ekf"]["reason"].startswith(REASON)
    assert " % of the mission done)" in rows["ekf"]["reason"]
    assert rows["ekf"]["time_total_s"] is None
    assert f"lost: ekf: {REASON}" in answer.err
    assert rows["ssjs"]["reason"] is None
    assert 0.0 < rows["ssjs"]["map_error_mean_m"] < 20.0
    assert REASON in (tmp_path / "c" / "report.html").read_text()
    with (tmp_path / "c" / "comparison.csv").open() as file:
        assert by_method(list(csv.DictReader(file)))["ekf"]["reason"] == rows["ekf"]["reason"]
    # Another limit is the same study: what was finished stays, and what was ended is tried again.
    answer = cli(*command, "--time-limit-s", 1.5)
    assert "1 of 2 runs are finished already" in answer.err
    again = by_method(json.loads(answer.out)["methods"])
    assert "the time limit of 1.5 s" in again["ekf"]["reason"]
    assert again["ssjs"] == rows["ssjs"]


def test_runs_of_a_consistency_study_and_of_a_sweep_end_at_the_limit(cli: Callable[..., Any], field_scenario: Path, tmp_path: Path) -> None:
    answer = cli(
        "consistency", field_scenario, "--runs", 1, "--methods", "ekf,ssjs", "--time-limit-s", LIMIT_S, "--out", tmp_path / "c", "--json"
    )
    assert answer.code == 3, answer.err
    rows = by_method(json.loads(answer.out)["methods"])
    assert rows["ekf"]["reason"].startswith(f"1 of 1 runs failed: {REASON}")
    assert (rows["ssjs"]["reason"], rows["ssjs"]["runs"]) == (None, 1)
    values = ["--submap-size", 15, "--fusion-threshold", 0.4]
    answer = cli("sweep", field_scenario, *values, "--methods", "ekf", "--time-limit-s", 1.0, "--out", tmp_path / "s", "--json")
    assert answer.code == 3
    (cell,) = json.loads(answer.out)["cells"]
    assert cell["runs"] == 0
    assert "time limit of 1 s" in cell["reason"]


def test_workers_of_a_cluster_end_their_runs_as_well(cli: Callable[..., Any], field_scenario: Path, tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=1, threads_per_worker=1, processes=True, dashboard_address=None) as cluster:
        command = ["consistency", field_scenario, "--runs", 2, "--methods", "ekf", "--time-limit-s", 3, "--out", tmp_path / "c", "--json"]
        began_s = time.monotonic()
        answer = cli(*command, "--scheduler", cluster.scheduler_address)
        assert time.monotonic() - began_s < 60.0
    assert answer.code == 3, answer.err
    (row,) = json.loads(answer.out)["methods"]
    assert row["reason"].startswith("2 of 2 runs failed: not finished within the time limit of 3 s (")


def test_a_limit_that_is_not_reached_changes_no_byte(cli: Callable[..., Any], small_scenario: Path, tmp_path: Path) -> None:
    command = ["consistency", small_scenario, "--runs", 2, "--methods", "ssjs,lmj"]
    assert cli(*command, "--out", tmp_path / "free").code == 0
    assert cli(*command, "--out", tmp_path / "limited", "--time-limit-s", 600).code == 0
    for name in ("consistency.json", "consistency_runs.csv", "study.json"):
        assert (tmp_path / "free" / name).read_bytes() == (tmp_path / "limited" / name).read_bytes()


def test_work_that_never_looks_at_the_clock_is_ended_with_its_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(process_pool, "TIME_LIMIT_GRACE_S", 0.5)
    jobs = [Job("stuck", {"number": 1, "pause_s": 1000.0}), *(Job(str(number), {"number": number}) for number in range(3))]
    began_s = time.monotonic()
    done = {outcome.key: outcome for outcome in ProcessPool(1, time_limit_s=3.0).outcomes(some_work.square, jobs) if outcome is not None}
    assert 3.5 <= time.monotonic() - began_s < 60.0
    assert done["stuck"].reason.startswith("not finished within the time limit of 3 s (its process was ended in one long step)")
    assert not done["stuck"].lasting
    assert [done[str(number)].record["square"] for number in range(3)] == [0, 1, 4]


@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="needs a system that keeps to RLIMIT_AS")
def test_a_method_that_runs_out_of_memory_is_a_row(field_scenario: Path, tmp_path: Path) -> None:
    """One map of 3,600 landmarks holds 7,203 x 7,203 numbers, 415 MB, and joining it takes two: more than the process may have."""
    limit_bytes = 2**20 * 600

    def call(*arguments: object) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "ssjs_cli", *(str(argument) for argument in arguments)]
        environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
        limited = lambda: resource.setrlimit(resource.RLIMIT_AS, (limit_bytes, limit_bytes))  # noqa: E731
        return subprocess.run(command, preexec_fn=limited, env=environment, capture_output=True, text=True, check=False)

    assert call("simulate", field_scenario, "--out", tmp_path / "field").returncode == 0
    answer = call("compare", tmp_path / "field", "--methods", "dcs,ssjs", "--out", tmp_path / "c", "--json")
    assert answer.returncode == 3, answer.stderr
    rows = by_method(json.loads(answer.stdout)["methods"])
    assert rows["dcs"]["reason"] == "the memory was used up; free some, or run fewer jobs at a time"
    assert rows["ssjs"]["reason"] is None


@pytest.mark.parametrize("text", ["0", "-1", "soon"])
def test_a_limit_that_is_none(cli: Callable[..., Any], small_scenario: Path, tmp_path: Path, text: str) -> None:
    answer = cli("consistency", small_scenario, "--runs", 1, "--time-limit-s", text, "--out", tmp_path / "out")
    assert answer.code == 2
    assert "--time-limit-s" in answer.err
