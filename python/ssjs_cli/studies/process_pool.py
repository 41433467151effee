"""Worker processes on this machine. Each has a pipe of its own, so a worker that dies is known with the very job it had in hand."""

import ctypes
import multiprocessing
import os
import signal
import sys
import time
from collections import Counter, deque
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess

from ssjs_cli.studies.executor import MAX_ATTEMPTS, POLL_S, Job, Outcome, Work, attempt, time_limit_reason

#: One worker computes on one thread: more would fight over the cores, and sums split over threads differ in their last digit.
ONE_THREAD: Mapping[str, str] = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
STOP_TIMEOUT_S = 5.0
#: Of prctl(2): the signal that a process gets when its parent dies.
PR_SET_PDEATHSIG = 1
#: A run ends itself at its time limit, but only between two steps of the method: so much later its process is ended.
TIME_LIMIT_GRACE_S = 10.0


class ProcessPool:
    """`workers` processes. With fresh_processes every job gets a new one, whose largest memory is then that of the job alone. Work that
    does not keep to time_limit_s by itself is ended with its process."""

    def __init__(self, workers: int, *, fresh_processes: bool = False, time_limit_s: float | None = None) -> None:
        self._workers = workers
        self._fresh_processes = fresh_processes
        self._time_limit_s = time_limit_s

    def outcomes(self, work: Work, jobs: Sequence[Job]) -> Iterator[Outcome | None]:
        waiting = deque(jobs)
        attempts: Counter[str] = Counter()
        workers: list[_Worker] = []
        try:
            while waiting or any(worker.job is not None for worker in workers):
                while len(workers) < self._workers and sum(worker.job is None for worker in workers) < len(waiting):
                    workers.append(_Worker(work))
                for worker in workers:
                    if worker.job is None and waiting:
                        worker.begin(waiting.popleft())
                ended = self._ended(workers)
                if not ended:
                    yield None
                for worker in ended:
                    job = worker.job
                    outcome = worker.finish()
                    if outcome is None or self._fresh_processes:
                        workers.remove(worker)
                        worker.stop()
                    if job is None:  # an idle worker died: a new one takes its place
                        continue
                    if outcome is None:
                        attempts[job.key] += 1
                        if attempts[job.key] < MAX_ATTEMPTS:
                            waiting.append(job)
                            continue
                        outcome = Outcome(job.key, reason=f"its worker process died {MAX_ATTEMPTS} times ({worker.cause_of_death()})")
                    yield outcome
                if self._time_limit_s is not None:
                    for worker in [worker for worker in workers if worker.busy_s > self._time_limit_s + TIME_LIMIT_GRACE_S]:
                        workers.remove(worker)
                        worker.stop()
                        if worker.job is not None:
                            yield Outcome(
                                worker.job.key, reason=time_limit_reason(self._time_limit_s, "its process was ended in one long step")
                            )
        finally:
            for worker in workers:
                worker.stop()

    @staticmethod
    def _ended(workers: Sequence["_Worker"]) -> list["_Worker"]:
        """Workers that have an answer or are dead, in the order of the pool."""
        ready = set(wait([handle for worker in workers for handle in worker.handles], timeout=POLL_S))
        return [worker for worker in workers if ready.intersection(worker.handles)]


class _Worker:
    def __init__(self, work: Work) -> None:
        context = multiprocessing.get_context("spawn")
        self._connection, theirs = context.Pipe()
        self._process: BaseProcess = context.Process(target=_serve, args=(theirs, work, os.getpid()), daemon=True)
        with _environment(ONE_THREAD):
            self._process.start()
        theirs.close()  # so that the death of the process ends the pipe
        self.job: Job | None = None
        self._began_s = 0.0

    @property
    def handles(self) -> tuple[Connection, int]:
        return self._connection, self._process.sentinel

    def begin(self, job: Job) -> None:
        """A worker that has died meanwhile is noticed by its sentinel."""
        self.job = job
        self._began_s = time.monotonic()
        try:
            self._connection.send(job)
        except OSError:
            self._process.join(STOP_TIMEOUT_S)

    @property
    def busy_s(self) -> float:
        """Since the job was given; 0 for an idle worker."""
        return 0.0 if self.job is None else time.monotonic() - self._began_s

    def finish(self) -> Outcome | None:
        """The answer, or None when the process died without one."""
        self.job = None
        try:
            if self._connection.poll():
                outcome: Outcome = self._connection.recv()
                return outcome
        except (EOFError, OSError):
            pass
        self._process.join(STOP_TIMEOUT_S)  # lets a process that is ending come to its own end, whose cause is told
        return None

    def cause_of_death(self) -> str:
        code = self._process.exitcode
        if code is not None and code < 0:
            hint = ", as a system short of memory does" if -code == signal.SIGKILL else ""
            return f"killed by {signal.Signals(-code).name}{hint}"
        return f"exit code {code}"

    def stop(self) -> None:
        self._connection.close()
        self._process.terminate()
        self._process.join(STOP_TIMEOUT_S)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()


def _serve(connection: Connection, work: Work, parent: int) -> None:
    """The life of a worker: jobs in, outcomes out, until the pipe ends. Ctrl-C is the study's to handle."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    _die_with(parent)
    try:
        while True:
            connection.send(attempt(work, connection.recv()))
    except (EOFError, OSError):
        return


def _die_with(parent: int) -> None:
    """Where the parent is killed its worker is too, by the system (Linux), and writes nothing while another call takes the study up again.
    Elsewhere it ends with the job that it has in hand."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:  # it died before we asked
            os._exit(1)


@contextmanager
def _environment(values: Mapping[str, str]) -> Iterator[None]:
    """The variables as a new process inherits them; a choice of the user stays."""
    added = [name for name in values if name not in os.environ]
    os.environ.update({name: values[name] for name in added})
    try:
        yield
    finally:
        for name in added:
            del os.environ[name]
