"""consistency and sweep through the command line: the same bytes whoever does the work, and whatever happens to the workers."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from ssjs_cli import _core
from ssjs_cli.app import call
from ssjs_cli.studies import dask_pool

TABLES = ("consistency.json", "consistency.csv", "consistency_over_time.csv", "consistency_runs.csv", "report.html")
DEADLINE_S = 120.0


def tables(folder: Path) -> dict[str, bytes]:
    return {name: (folder / name).read_bytes() for name in TABLES}


@pytest.fixture
def study(cli: Callable[..., Any], small_scenario: Path, tmp_path: Path) -> Callable[..., Path]:
    def run(name: str, *options: object, runs: int = 4) -> Path:
        answer = cli("consistency", small_scenario, "--runs", runs, "--methods", "ssjs,ekf", "--out", tmp_path / name, *options)
        assert answer.code == 0, answer.err
        return tmp_path / name

    return run


def test_the_tables_do_not_depend_on_the_number_of_workers(study: Callable[..., Path]) -> None:
    assert tables(study("one", "--jobs", 1)) == tables(study("two", "--jobs", 2))


def test_dask_gives_the_bytes_of_the_pool(study: Callable[..., Path]) -> None:
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster:
        by_dask = study("dask", "--scheduler", cluster.scheduler_address)
    assert tables(by_dask) == tables(study("pool", "--jobs", 2))


def test_the_numbers_are_the_means_of_the_runs(study: Callable[..., Path]) -> None:
    folder = study("study")
    document = json.loads((folder / "consistency.json").read_text())
    assert document["seeds"] == [1, 2, 3, 4]
    for row in document["methods"]:
        runs = [run for run in document["runs"] if run["method"] == row["method"]]
        assert [run["seed"] for run in runs] == [1, 2, 3, 4]
        assert row["trajectory_rmse_m"] == pytest.approx(sum(run["trajectory_rmse_m"] for run in runs) / 4, abs=1e-6)
        dof = sum(run["nis_dof"] for run in runs)
        assert row["nis_mean"] == pytest.approx(sum(run["nis_mean"] * run["nis_dof"] for run in runs) / dof, abs=1e-6)
        # Four values of three degrees of freedom: chi-squared of 12 has 2.5 % below 4.404 and above 23.337 (tables)
        assert row["nees_band_low"] == pytest.approx(4.404 / 4, abs=1e-3)
        assert row["nees_band_high"] == pytest.approx(23.337 / 4, abs=1e-3)
    with (folder / "consistency_over_time.csv").open() as file:
        over_time = [row for row in csv.DictReader(file) if row["method"] == "ssjs"]
    values = [float(row["nees_mean"]) for row in over_time]
    assert len(values) >= 100
    ssjs = document["methods"][0]
    assert ssjs["nees_mean"] == pytest.approx(sum(values) / len(values), abs=1e-5)
    inside = [ssjs["nees_band_low"] <= value <= ssjs["nees_band_high"] for value in values]
    assert ssjs["nees_inside_fraction"] == pytest.approx(sum(inside) / len(inside), abs=1e-6)


def test_a_finished_study_is_read_again_and_force_starts_anew(cli: Callable[..., Any], study: Callable[..., Path]) -> None:
    folder = study("study")
    before, marks = tables(folder), {path: path.stat().st_mtime_ns for path in (folder / "runs").iterdir()}
    assert tables(study("study")) == before
    assert {path: path.stat().st_mtime_ns for path in (folder / "runs").iterdir()} == marks
    assert tables(study("study", "--force")) == before
    assert {path: path.stat().st_mtime_ns for path in (folder / "runs").iterdir()} != marks


def test_another_seed_is_another_study(cli: Callable[..., Any], small_scenario: Path, study: Callable[..., Path]) -> None:
    folder = study("study")
    answer = cli("consistency", small_scenario, "--runs", 4, "--methods", "ssjs,ekf", "--out", folder, "--seed", 9)
    assert answer.code == 2
    assert "holds another study (different: seed)" in answer.err


class Call:
    """The command as a process of its own, so that it and its workers can be stopped from outside."""

    def __init__(self, out: Path, *workers: str) -> None:
        self.out = out
        study = ["consistency", "grid-survey-stress", "--runs", "6", *(workers or ("--jobs", "2")), "--out", str(out)]
        self.command = [sys.executable, "-m", "ssjs_cli", *study]
        self.process: subprocess.Popen[str] | None = None

    def start(self) -> None:
        self.process = subprocess.Popen(self.command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.wait_for(lambda: len(list((self.out / "runs").glob("*.json"))) >= 1)

    def wait_for(self, condition: Callable[[], bool]) -> None:
        assert self.process is not None
        deadline_s = time.monotonic() + DEADLINE_S
        while not condition():
            assert self.process.poll() is None, self.process.communicate()
            assert time.monotonic() < deadline_s
            time.sleep(0.01)

    def workers(self) -> list[int]:
        assert self.process is not None
        children = Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children").read_text().split()
        return [int(child) for child in children if b"spawn_main" in Path(f"/proc/{child}/cmdline").read_bytes()]

    def end(self) -> tuple[int, str]:
        assert self.process is not None
        _, errors = self.process.communicate(timeout=DEADLINE_S)
        return self.process.returncode, errors


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    out = tmp_path_factory.mktemp("undisturbed") / "calm"
    assert call(["consistency", "grid-survey-stress", "--runs", "6", "--jobs", "2", "--out", str(out)]) == 0
    return tables(out)


@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="needs /proc")
def test_a_killed_worker_loses_no_run(tmp_path: Path, undisturbed: dict[str, bytes]) -> None:
    study_call = Call(tmp_path / "killed")
    study_call.start()
    workers = study_call.workers()
    assert len(workers) == 2
    os.kill(workers[0], signal.SIGKILL)
    code, errors = study_call.end()
    assert code == 0, errors
    assert tables(study_call.out) == undisturbed


@pytest.mark.long
def test_a_killed_worker_of_a_cluster_loses_no_run(tmp_path: Path, undisturbed: dict[str, bytes]) -> None:
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster:
        study_call = Call(tmp_path / "killed", "--scheduler", cluster.scheduler_address)
        study_call.start()
        os.kill(cluster.workers[0].pid, signal.SIGKILL)
        code, errors = study_call.end()
    assert code == 0, errors
    assert tables(study_call.out) == undisturbed


def test_a_scheduler_that_is_not_there(
    cli: Callable[..., Any], small_scenario: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr(dask_pool, "CONNECT_TIMEOUT_S", 0.5)
    command = ["consistency", small_scenario, "--runs", 1, "--out", tmp_path / "out", "--scheduler"]
    for address, message in (("tcp://127.0.0.1:9", "no Dask scheduler answers"), ("rubbish", "is no address; give one such as tcp://")):
        answer = cli(*command, address)
        assert answer.code == 2
        assert f"--scheduler {address}: {message}" in answer.err
        assert not (tmp_path / "out").exists()


def test_a_missing_extra_is_named(cli: Callable[..., Any], small_scenario: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    answer = cli("consistency", small_scenario, "--runs", 1, "--out", tmp_path / "out", "--scheduler", "tcp://127.0.0.1:8786")
    assert answer.code == 2
    assert "--scheduler needs the extra 'dask': pip install 'ssjs[dask]'" in answer.err


def test_an_interrupted_study_goes_on_with_the_same_command(cli: Callable[..., Any], tmp_path: Path, undisturbed: dict[str, bytes]) -> None:
    study_call = Call(tmp_path / "left")
    study_call.start()
    study_call.process.send_signal(signal.SIGINT)
    code, errors = study_call.end()
    assert code == 130
    assert f"of 6 runs; the same command continues with {study_call.out}" in errors
    assert not (study_call.out / "consistency.json").exists()
    kept = {path: path.stat().st_mtime_ns for path in (study_call.out / "runs").glob("*.json")}
    assert 1 <= len(kept) < 6
    answer = cli("consistency", "grid-survey-stress", "--runs", 6, "--jobs", 2, "--out", study_call.out)
    assert answer.code == 0
    assert f"{len(kept)} of 6 runs are finished already" in answer.err
    assert tables(study_call.out) == undisturbed
    assert {path: path.stat().st_mtime_ns for path in kept} == kept


@pytest.mark.long
def test_a_killed_study_goes_on_and_leaves_no_worker(cli: Callable[..., Any], tmp_path: Path, undisturbed: dict[str, bytes]) -> None:
    study_call = Call(tmp_path / "dead")
    study_call.start()
    workers = study_call.workers()
    study_call.process.kill()
    study_call.process.wait()
    deadline_s = time.monotonic() + DEADLINE_S
    while any(Path(f"/proc/{worker}/cmdline").exists() and Path(f"/proc/{worker}/cmdline").read_bytes() for worker in workers):
        assert time.monotonic() < deadline_s
        time.sleep(0.05)
    assert cli("consistency", "grid-survey-stress", "--runs", 6, "--jobs", 2, "--out", study_call.out).code == 0
    assert tables(study_call.out) == undisturbed


def without_times(cells: list[dict[str, Any]]) -> list[dict[str, Any]]:
    return [{key: value for key, value in cell.items() if not key.startswith("time_")} for cell in cells]


def test_a_sweep_covers_every_pair_of_values(cli: Callable[..., Any], small_scenario: Path, tmp_path: Path) -> None:
    command = ["sweep", small_scenario, "--submap-size", "14,8", "--fusion-threshold", "0.3,0.9", "--runs", 2, "--json"]
    answer = cli(*command, "--out", tmp_path / "a", "--jobs", 1)
    assert answer.code == 0, answer.err
    document = json.loads(answer.out)
    assert document == json.loads((tmp_path / "a" / "sweep.json").read_text())
    places = [(cell["submap_size"], cell["fusion_threshold"]) for cell in document["cells"]]
    assert places == [(8, 0.3), (8, 0.9), (14, 0.3), (14, 0.9)]
    by_place = dict(zip(places, document["cells"], strict=True))
    assert all(cell["runs"] == 2 and cell["time_total_s"] > 0.0 for cell in document["cells"])
    assert by_place[8, 0.3]["submaps"] > by_place[14, 0.3]["submaps"]
    # what is fused less leaves more maps
    assert by_place[8, 0.3]["fusions"] > by_place[8, 0.9]["fusions"]
    assert by_place[8, 0.3]["live_maps"] < by_place[8, 0.9]["live_maps"]
    with (tmp_path / "a" / "sweep.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row["map_error_mean_m"]) for row in rows] == [cell["map_error_mean_m"] for cell in document["cells"]]
    assert cli(*command, "--out", tmp_path / "b", "--jobs", 2).code == 0
    assert without_times(json.loads((tmp_path / "b" / "sweep.json").read_text())["cells"]) == without_times(document["cells"])


def test_a_cell_of_a_sweep_is_the_run_of_the_same_settings(cli: Callable[..., Any], small_scenario: Path, tmp_path: Path) -> None:
    command = ["sweep", small_scenario, "--submap-size", 8, "--fusion-threshold", 0.5, "--json", "--out", tmp_path / "s"]
    (cell,) = json.loads(cli(*command).out)["cells"]
    assert cli("simulate", small_scenario, "--out", tmp_path / "m").code == 0
    settings = ["--set", "submap.max_landmarks=8", "--set", "joining.fusion_threshold=0.5"]
    summary = json.loads(cli("run", tmp_path / "m", "--out", tmp_path / "r", "--no-report", "--json", *settings).out)
    for key in ("fusions", "loop_candidates", "submaps", "map_error_mean_m", "trajectory_rmse_m"):
        assert cell[key] == summary[key], key


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["consistency", "SCENARIO", "--runs", 0], "'--runs': 0 is not in the range"),
        (["consistency", "SCENARIO"], "Missing option '--runs'"),
        (["consistency", "SCENARIO", "--runs", 1, "--methods", "efk"], "'efk' is no method (did you mean 'ekf'?)"),
        (["consistency", "SCENARIO", "--runs", 1, "--methods", "ekf,ekf"], "'ekf' appears twice"),
        (["consistency", "SCENARIO", "--runs", 1, "--methods", ","], "names no method"),
        (["consistency", "grid-survay", "--runs", 1], "did you mean 'grid-survey'?"),
        (["consistency", "SCENARIO", "--runs", 2, "--seed", 2**64 - 1], "leaves no room for 2 seeds"),
        (["consistency", "SCENARIO", "--runs", 1, "--jobs", 2, "--scheduler", "tcp://a:1"], "give one of the two"),
        (["consistency", "SCENARIO", "--runs", 1, "--set", "submap.max_landmark=3"], "did you mean 'submap.max_landmarks'?"),
        (["sweep", "SCENARIO", "--submap-size", "6,x", "--fusion-threshold", "0.3"], "'x' is no whole number"),
        (["sweep", "SCENARIO", "--submap-size", "6,6", "--fusion-threshold", "0.3"], "names 6 twice"),
        (["sweep", "SCENARIO", "--submap-size", ",", "--fusion-threshold", "0.3"], "names no value"),
        (["sweep", "SCENARIO", "--submap-size", "6", "--fusion-threshold", "3"], "joining.fusion_threshold = 3: must lie in [0, 1]"),
        (["sweep", "SCENARIO", "--submap-size", "6", "--fusion-threshold", "nan"], "must lie in [0, 1]"),
    ],
)
def test_faulty_usage_is_named(cli: Callable[..., Any], small_scenario: Path, tmp_path: Path, arguments: list[Any], message: str) -> None:
    replaced = [small_scenario if argument == "SCENARIO" else argument for argument in arguments]
    answer = cli(*replaced, "--out", tmp_path / "out")
    assert answer.code == 2
    assert message in answer.err
    assert not (tmp_path / "out").exists()


def test_a_method_that_fails_is_a_row_with_its_reason(
    cli: Callable[..., Any], small_scenario: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from ssjs_cli.studies import scenario_runs
    from ssjs_cli.studies.executor import Job, Outcome, attempt

    class OneFails:
        """In this process; the second run of ekf fails."""

        def outcomes(self, work: Any, jobs: list[Job]) -> Any:
            for job in jobs:
                if job.payload.settings["method"] == "ekf" and job.payload.seed == 2:
                    yield Outcome(job.key, reason="the wheels came off", lasting=True)
                else:
                    yield attempt(work, job)

    monkeypatch.setattr(scenario_runs.StudyRequest, "executor", lambda self: OneFails())
    answer = cli("consistency", small_scenario, "--runs", 3, "--methods", "ssjs,ekf", "--out", tmp_path / "out", "--json")
    assert answer.code == 3
    assert "lost: ekf: 1 of 3 runs failed: the wheels came off" in answer.err
    ssjs, ekf = json.loads(answer.out)["methods"]
    assert (ssjs["runs"], ssjs["reason"]) == (3, None)
    assert (ekf["runs"], ekf["reason"]) == (2, "1 of 3 runs failed: the wheels came off")
    # the band of the mean of two, chi-squared of 6: 1.237 to 14.449 (tables)
    assert ekf["nees_band_high"] == pytest.approx(14.449 / 2, abs=1e-3)
    assert "the wheels came off" in (tmp_path / "out" / "report.html").read_text()
    # a lasting reason is kept, without another attempt
    monkeypatch.undo()
    assert cli("consistency", small_scenario, "--runs", 3, "--methods", "ssjs,ekf", "--out", tmp_path / "out").code == 3
    assert _core.version() in (tmp_path / "out" / "study.json").read_text()
