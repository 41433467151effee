"""What Dask costs a batch beside its runs: start of workers, time a task, processor time of the scheduler, bytes a task.

    PYTHONPATH=python python benchmarks/dask_overhead.py --tasks 2000

Scheduler and two workers are processes of their own on this machine. The tasks are those of a batch, with real payloads and no work.
"""

import argparse
import json
import pickle
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from ssjs_cli.mission_run import RunRequest
from ssjs_cli.studies.batch_plan import MissionTask
from ssjs_cli.studies.dask_pool import DaskPool
from ssjs_cli.studies.executor import Job, Record, attempt
from ssjs_cli.studies.process_pool import ProcessPool

CLOCK_HZ = 100.0
WORKERS = 2


def nothing(task: Any) -> Record:
    """What a worker does: as much as it says of a run."""
    return {"results": dict.fromkeys(range(60), 1.0), "warnings": [], "lost": []}


def jobs(count: int) -> list[Job]:
    missions = Path("/data/season/2026")
    return [
        Job(
            f"{number:032x}",
            MissionTask(RunRequest(missions / f"dive{number:06d}", out=missions / f"dive-{number:012x}", force=True), "0.1.0", False),
        )
        for number in range(count)
    ]


def cpu_s(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / CLOCK_HZ


def measure_dask(count: int) -> dict[str, Any]:
    import distributed

    with tempfile.TemporaryDirectory() as folder:
        scheduler_file = Path(folder) / "scheduler.json"
        started_s = time.monotonic()
        common = ["--scheduler-file", str(scheduler_file)]
        scheduler = subprocess.Popen(
            [sys.executable, "-m", "distributed.cli.dask_scheduler", "--port", "0", "--no-dashboard", *common], stderr=subprocess.DEVNULL
        )
        workers = [
            subprocess.Popen(
                [sys.executable, "-m", "distributed.cli.dask_worker", "--nthreads", "1", "--no-nanny", "--no-dashboard", *common],
                stderr=subprocess.DEVNULL,
                cwd=folder,
            )
            for _ in range(WORKERS)
        ]
        try:
            while not scheduler_file.is_file() or not scheduler_file.read_text():
                time.sleep(0.02)
            address = json.loads(scheduler_file.read_text())["address"]
            with distributed.Client(address, set_as_default=False) as client:
                client.wait_for_workers(WORKERS)
            start_s = time.monotonic() - started_s
            pool = DaskPool(address)
            list(pool.outcomes(nothing, jobs(10)))  # imports at the workers
            before, own, wall = cpu_s(scheduler.pid), time.process_time(), time.monotonic()
            done = sum(outcome is not None for outcome in pool.outcomes(nothing, jobs(count)))
            assert done == count
            spent, own, wall = cpu_s(scheduler.pid) - before, time.process_time() - own, time.monotonic() - wall
            memory = next(line for line in Path(f"/proc/{scheduler.pid}/status").read_text().splitlines() if line.startswith("VmHWM"))
        finally:
            for process in (*workers, scheduler):
                process.terminate()
                process.wait()
    return {
        "start_of_scheduler_and_workers_s": round(start_s, 2),
        "wall_ms_per_task": round(1e3 * wall / count, 2),
        "scheduler_cpu_ms_per_task": round(1e3 * spent / count, 3),
        "client_cpu_ms_per_task": round(1e3 * own / count, 3),
        "scheduler_peak_mb": round(int(memory.split()[1]) / 1024.0, 1),
    }


def measure_pool(count: int) -> dict[str, Any]:
    own, wall = time.process_time(), time.monotonic()
    done = sum(outcome is not None for outcome in ProcessPool(WORKERS).outcomes(nothing, jobs(count)))
    assert done == count
    return {
        "wall_ms_per_task": round(1e3 * (time.monotonic() - wall) / count, 2),
        "parent_cpu_ms_per_task": round(1e3 * (time.process_time() - own) / count, 3),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--tasks", type=int, default=2000)
    arguments = parser.parse_args()
    (job,) = jobs(1)
    sizes = {"task_bytes": len(pickle.dumps((attempt, nothing, job))), "outcome_bytes": len(pickle.dumps(attempt(nothing, job)))}
    print(json.dumps({**sizes, "dask": measure_dask(arguments.tasks), "pool": measure_pool(arguments.tasks)}, indent=2))


if __name__ == "__main__":
    main()
