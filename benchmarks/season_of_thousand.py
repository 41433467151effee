"""A season of many small missions through `batch` while its processes are killed: nothing is lost, nothing is done twice.

    python benchmarks/season_of_thousand.py --missions 1000 --work /tmp/thousand

Simulates the missions (short surveys over shared seabeds, twenty a site), runs them with workers and parent killed by SIGKILL at random
moments, resumes, and checks: every mission is finished; a resumed call does exactly the rest; one more call does nothing; a sample has the
same bytes as an undisturbed batch. Prints what it measured as JSON.
"""

import argparse
import hashlib
import json
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ssjs_cli import _core
from ssjs_cli.formats.mission import write_mission
from ssjs_cli.mission_run import RunRequest
from ssjs_cli.simulation import Scenario, simulate_mission
from ssjs_cli.studies.batch import perform_mission
from ssjs_cli.studies.batch_plan import MissionTask

MISSIONS_A_SITE = 20
SITE_STEP_DEG = 0.01
LINES = {"lines": 1, "line_length_m": 60.0, "cross_lines": 0}
SEABED = {"north_m": 160.0, "east_m": 160.0, "landmarks": 120, "origin_sigma_m": 3.0}
#: Written by the clock, or naming it: these differ from one call to the next.
MEASURED_FILES = ("timing.json", "log.jsonl", "step_times.csv", "summary.json", "submaps.json", "mission_link.json", "report.html")
POLL_S = 0.05


@dataclass
class Disturbance:
    """worker_kills: how often a worker is killed in the first call; parent_kills: calls that are ended so."""

    worker_kills: int
    parent_kills: int


@dataclass
class Call:
    """One call of batch: finished runs before and after, what was killed in it, its largest memory, its wall time, and the processor time
    of it and its workers (of those that outlived it, none)."""

    finished_before: int
    finished_after: int
    code: int
    wall_s: float
    cpu_s: float
    parent_mb: float
    workers_killed: int = 0
    parent_killed: bool = False


@dataclass
class Outcome:
    calls: list[Call] = field(default_factory=list)
    figures: dict[str, Any] = field(default_factory=dict)


def simulate(work: Path, count: int) -> list[Path]:
    """Missions dive0000 and on, where they are not there already."""
    folders = [work / "missions" / f"dive{number:04d}" for number in range(count)]
    missing = [number for number, folder in enumerate(folders) if not (folder / "mission.toml").is_file()]
    with ProcessPoolExecutor(2) as pool:
        list(pool.map(_simulate_one, [str(folders[number]) for number in missing], missing, chunksize=8))
    return folders


def _simulate_one(folder: str, number: int) -> None:
    site = number // MISSIONS_A_SITE
    place = {"latitude_deg": 41.0 + SITE_STEP_DEG * (site // 10), "longitude_deg": 2.0 + SITE_STEP_DEG * (site % 10)}
    season = {**SEABED, **place, "world_seed": site}
    scenario = Scenario(f"dive {number:04d}", number + 1, built_in="auv-survey", survey={"lines": LINES}, season=season)
    target = Path(folder)
    partial = target.with_name(target.name + ".partial")
    shutil.rmtree(partial, ignore_errors=True)
    partial.mkdir(parents=True)
    write_mission(partial, simulate_mission(scenario))
    partial.rename(target)


def disturbed_season(work: Path, missions: list[Path], disturbance: Disturbance, seed: int, sample: int) -> Outcome:
    """Raises AssertionError where something was lost, done twice, or is not the same."""
    chance = random.Random(seed)
    season = work / "season"
    shutil.rmtree(season, ignore_errors=True)
    outcome = Outcome()
    marks: dict[str, int] = {}
    for kill in range(disturbance.parent_kills):
        share = (kill + chance.uniform(0.2, 0.8)) / (disturbance.parent_kills + 1)
        workers = disturbance.worker_kills // max(disturbance.parent_kills, 1)
        outcome.calls.append(_call(season, missions, chance, end_at=int(share * len(missions)), worker_kills=workers))
        _unchanged(marks, season)
        marks = _marks(season)
    outcome.calls.append(_call(season, missions, chance))
    _unchanged(marks, season)
    last = outcome.calls[-1]
    assert last.code == 0, f"batch ended with {last.code}"
    assert last.finished_after == len(missions), f"{len(missions) - last.finished_after} missions are lost"
    assert len(list((season / "missions").iterdir())) == len(missions), "run directories are missing, or some are left behind"
    before = _marks(season)
    again = _call(season, missions, chance)
    assert again.code == 0
    assert _marks(season) == before, "the second call did something"
    outcome.calls.append(again)
    chosen = sorted(chance.sample(missions, sample))
    calm = work / "calm"
    shutil.rmtree(calm, ignore_errors=True)
    undisturbed = _call(calm, chosen, chance)
    compared = _compare(calm / "missions", season / "missions")
    outcome.figures = _figures(outcome, missions, season, compared)
    outcome.figures["undisturbed_cpu_s_per_mission"] = round(undisturbed.cpu_s / len(chosen), 3)
    outcome.figures["run_cpu_s"] = round(_run_cpu_s(chosen, work / "alone"), 3)
    return outcome


def _call(season: Path, missions: list[Path], chance: random.Random, *, end_at: int | None = None, worker_kills: int = 0) -> Call:
    """end_at: the parent is killed once so many runs are finished."""
    before = _finished(season)
    command = [sys.executable, "-m", "ssjs_cli", "batch", *map(str, missions), "--out", str(season), "--jobs", "2", "--no-report"]
    began_s, cpu_before_s = time.monotonic(), _children_cpu_s()
    with (season.parent / "batch.log").open("ab") as log:
        process = subprocess.Popen(command, stdout=log, stderr=log)
    call = Call(before, before, 0, 0.0, 0.0, 0.0)
    due = sorted(chance.uniform(before, end_at) for _ in range(worker_kills)) if end_at is not None else []
    while process.poll() is None:
        call.parent_mb = max(call.parent_mb, _peak_mb(process.pid))
        done = _finished(season)
        if due and done >= due[0] and _kill_a_worker(process.pid, chance):
            due.pop(0)
            call.workers_killed += 1
        if end_at is not None and done >= end_at:
            process.kill()  # at whatever moment this is; its workers are left to themselves
            call.parent_killed = True
        time.sleep(POLL_S)
    call.wall_s, call.cpu_s = time.monotonic() - began_s, _children_cpu_s() - cpu_before_s
    call.code, call.finished_after = process.wait(), _finished(season)
    return call


def _children_cpu_s() -> float:
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def _finished(season: Path) -> int:
    try:
        with os.scandir(season / "runs") as entries:
            return sum(entry.name.endswith(".json") and not entry.name.startswith(".") for entry in entries)
    except FileNotFoundError:
        return 0


def _children(pid: int) -> list[int]:
    try:
        return [int(child) for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
    except (FileNotFoundError, ProcessLookupError):
        return []


def _kill_a_worker(pid: int, chance: random.Random) -> bool:
    workers = [child for child in _children(pid) if b"spawn_main" in _command_line(child)]
    return bool(workers) and _kill(chance.choice(workers))


def _command_line(pid: int) -> bytes:
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes()
    except (FileNotFoundError, ProcessLookupError):
        return b""


def _kill(pid: int) -> bool:
    try:
        os.kill(pid, signal.SIGKILL)
    except ProcessLookupError:
        return False
    return True


def _peak_mb(pid: int) -> float:
    try:
        status = Path(f"/proc/{pid}/status").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return 0.0
    peak = next((line for line in status.splitlines() if line.startswith("VmHWM")), "VmHWM: 0 kB")
    return int(peak.split()[1]) / 1024.0


def _marks(season: Path) -> dict[str, int]:
    """When each record and each file of a finished run was written last."""
    marks = {path.as_posix(): path.stat().st_mtime_ns for path in (season / "runs").glob("[!.]*.json")}
    for run in (season / "missions").glob("[!.]*"):
        marks.update({path.as_posix(): path.stat().st_mtime_ns for path in run.iterdir()})
    return marks


def _unchanged(marks: dict[str, int], season: Path) -> None:
    """Finished runs are not done again: those of a record that was there."""
    finished = {Path(path).stem[:12] for path in marks if "/runs/" in path}
    now = _marks(season)
    for path, mark in marks.items():
        of_finished_run = "/runs/" in path or Path(path).parent.name[-12:] in finished
        assert not of_finished_run or now.get(path) == mark, f"{path} was written again"


def _run_cpu_s(missions: list[Path], out: Path) -> float:
    """Of one run in this process, the mean without the first."""
    spent = []
    for mission in missions:
        began_s = time.process_time()
        perform_mission(MissionTask(RunRequest(mission.resolve(), out=out, force=True), _core.version(), False))
        spent.append(time.process_time() - began_s)
    return sum(spent[1:]) / max(len(spent) - 1, 1)


def _compare(calm: Path, season: Path) -> int:
    """Files that are the same in both."""
    count = 0
    for run in sorted(calm.iterdir()):
        for path in sorted(run.iterdir()):
            if path.name in MEASURED_FILES:
                continue
            other = season / run.name / path.name
            assert _digest(path) == _digest(other), f"{other} differs from that of an undisturbed batch"
            count += 1
    return count


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _figures(outcome: Outcome, missions: list[Path], season: Path, compared: int) -> dict[str, Any]:
    calls = outcome.calls[:-1]
    again = outcome.calls[-1]
    wall_s = sum(call.wall_s for call in calls)
    one_run = next((season / "missions").iterdir())
    made = json.loads((season / "season_map.json").read_text())
    return {
        "missions": len(missions),
        "workers_killed": sum(call.workers_killed for call in calls),
        "parents_killed": sum(call.parent_killed for call in calls),
        "finished_after_each_call": [call.finished_after for call in calls],
        "wall_s": round(wall_s, 1),
        "missions_per_s": round(len(missions) / wall_s, 2),
        "cpu_s_of_each_call": [round(call.cpu_s, 1) for call in calls],
        "second_call_s": round(again.wall_s, 2),
        "second_call_cpu_s": round(again.cpu_s, 2),
        "parent_peak_mb": round(max(call.parent_mb for call in outcome.calls), 1),
        "page_mb": round((season / "report.html").stat().st_size / 1e6, 2),
        "run_directory_kb": round(sum(path.stat().st_size for path in one_run.iterdir()) / 1e3, 1),
        "record_kb": round(next((season / "runs").glob("*.json")).stat().st_size / 1e3, 1),
        "files_compared": compared,
        "regions": len(made["regions"]),
        "contacts": sum(region["contacts"] for region in made["regions"]),
        "seen_by_several": sum(region["seen_by_several"] for region in made["regions"]),
        "apart": len(made["apart"]),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--missions", type=int, default=1000)
    parser.add_argument("--work", type=Path, required=True, help="folder for the missions and the batch")
    parser.add_argument("--seed", type=int, default=1, help="of the moments at which processes are killed")
    parser.add_argument("--worker-kills", type=int, default=10)
    parser.add_argument("--parent-kills", type=int, default=2)
    parser.add_argument("--sample", type=int, default=20, help="missions that are run again undisturbed")
    arguments = parser.parse_args()
    began_s = time.monotonic()
    missions = simulate(arguments.work, arguments.missions)
    simulated_s = time.monotonic() - began_s
    disturbance = Disturbance(arguments.worker_kills, arguments.parent_kills)
    outcome = disturbed_season(arguments.work, missions, disturbance, arguments.seed, arguments.sample)
    print(json.dumps({"simulated_s": round(simulated_s, 1), **outcome.figures}, indent=2))


if __name__ == "__main__":
    main()
