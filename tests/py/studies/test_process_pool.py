import os
from pathlib import Path
from typing import Any

import pytest
import some_work

from ssjs_cli.studies.executor import Job, Outcome
from ssjs_cli.studies.process_pool import ProcessPool


def outcomes(pool: ProcessPool, work: Any, payloads: list[dict[str, Any]]) -> dict[str, Outcome]:
    jobs = [Job(f"job{number}", payload) for number, payload in enumerate(payloads)]
    ended = [outcome for outcome in pool.outcomes(work, jobs) if outcome is not None]
    assert len(ended) == len(jobs)
    return {outcome.key: outcome for outcome in ended}


@pytest.mark.parametrize("workers", [1, 3])
def test_every_job_ends_once_with_its_own_result(workers: int) -> None:
    done = outcomes(ProcessPool(workers), some_work.square, [{"number": number} for number in range(12)])
    assert [done[f"job{number}"].record["square"] for number in range(12)] == [number**2 for number in range(12)]
    processes = {outcome.record["process"] for outcome in done.values()}
    assert os.getpid() not in processes
    assert len(processes) <= workers


def test_fresh_processes_are_not_used_twice() -> None:
    done = outcomes(ProcessPool(1, fresh_processes=True), some_work.square, [{"number": number} for number in range(3)])
    assert len({outcome.record["process"] for outcome in done.values()}) == 3


def test_no_job_is_no_work() -> None:
    assert list(ProcessPool(2).outcomes(some_work.square, [])) == []


def test_the_caller_hears_from_a_pool_that_is_busy() -> None:
    first = next(iter(ProcessPool(1).outcomes(some_work.square, [Job("slow", {"number": 1, "pause_s": 5.0})])))
    assert first is None


def test_failures_become_reasons_and_the_rest_goes_on() -> None:
    payloads = [{"number": 2, "how": how} for how in ("refuse", "fault", "memory", "")]
    done = outcomes(ProcessPool(2), some_work.misbehave, payloads)
    assert (done["job0"].reason, done["job0"].lasting) == ("this input is no good; give another", True)
    assert (done["job1"].reason, done["job1"].lasting) == ("internal fault: RuntimeError: a fault of ours", False)
    assert "in misbehave" in done["job1"].fault
    assert "memory" in done["job2"].reason
    assert done["job3"].record is not None


def test_a_poisonous_job_ends_as_a_failure_and_harms_no_other() -> None:
    payloads = [{"number": number, "how": "kill" if number == 1 else "exit" if number == 4 else ""} for number in range(6)]
    done = outcomes(ProcessPool(2), some_work.misbehave, payloads)
    assert done["job1"].reason == "its worker process died 3 times (killed by SIGKILL, as a system short of memory does)"
    assert not done["job1"].lasting
    assert done["job4"].reason == "its worker process died 3 times (exit code 7)"
    assert [done[f"job{number}"].record["square"] for number in (0, 2, 3, 5)] == [0, 4, 9, 25]


def test_a_job_whose_worker_was_killed_is_done_again(tmp_path: Path) -> None:
    payloads = [{"number": number, "how": "kill once", "mark": str(tmp_path / f"mark{number}")} for number in range(4)]
    done = outcomes(ProcessPool(2), some_work.misbehave, payloads)
    assert [done[f"job{number}"].record["square"] for number in range(4)] == [0, 1, 4, 9]


def test_a_pool_that_is_left_ends_its_workers() -> None:
    answers = ProcessPool(2).outcomes(some_work.square, [Job(str(number), {"number": number, "pause_s": 0.0}) for number in range(50)])
    process = next(outcome for outcome in answers if outcome is not None).record["process"]
    answers.close()
    with pytest.raises(ProcessLookupError):
        os.kill(process, 0)


def test_a_worker_computes_on_one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "2")
    (done,) = outcomes(ProcessPool(1), some_work.threads, [{}]).values()
    assert done.record == {"OPENBLAS_NUM_THREADS": "2", "OMP_NUM_THREADS": "1"}
    assert "OMP_NUM_THREADS" not in os.environ
