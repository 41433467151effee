"""Workers of a Dask cluster. Dask itself runs a job again when the worker that had it in hand dies."""

import importlib
import logging
import queue
import re
from collections.abc import Iterator, Sequence
from typing import Any

from ssjs_cli.errors import UserError
from ssjs_cli.studies.executor import POLL_S, Job, Outcome, Work, attempt

CONNECT_TIMEOUT_S = 10.0
WORKER_TIMEOUT_S = 30.0
ADDRESS = re.compile(r"(?:[a-z]+://)?(?:\[[0-9a-fA-F:.]+\]|[^\s:/\[\]]+):[0-9]{1,5}")


class DaskPool:
    """The workers behind a scheduler such as tcp://10.0.0.1:8786. They need the same ssjs as this process."""

    def __init__(self, address: str) -> None:
        if not ADDRESS.fullmatch(address):
            raise UserError(f"--scheduler {address}: is no address; give one such as tcp://10.0.0.1:8786")
        try:
            self._distributed: Any = importlib.import_module("distributed")
        except ImportError as error:
            raise UserError("--scheduler needs the extra 'dask': pip install 'ssjs[dask]', here and at the workers") from error
        self._address = address
        # what it logs of a lost connection is said once, in our words
        logging.getLogger("distributed").setLevel(logging.CRITICAL)

    def outcomes(self, work: Work, jobs: Sequence[Job]) -> Iterator[Outcome | None]:
        if not jobs:
            return
        client = self._connected()
        ended: queue.SimpleQueue[Any] = queue.SimpleQueue()
        futures = {}
        try:
            for job in jobs:
                future = client.submit(attempt, work, job, key=f"ssjs-{job.key}", pure=False)
                futures[future.key] = job.key
                future.add_done_callback(ended.put)
            waiting = len(futures)
            held = dict.fromkeys(futures)
            while waiting:
                try:
                    future = ended.get(timeout=POLL_S)
                except queue.Empty:
                    if client.status not in ("running", "connecting"):
                        raise self._gone() from None
                    yield None
                    continue
                if future.status in ("cancelled", "lost"):
                    raise self._gone()
                waiting -= 1
                del held[future.key]
                yield _outcome_of(future, futures[future.key])
        finally:
            client.close(timeout=CONNECT_TIMEOUT_S)

    def _gone(self) -> UserError:
        return UserError(f"--scheduler {self._address}: the scheduler is gone or has dropped the work; the same command continues")

    def _connected(self) -> Any:
        try:
            client = self._distributed.Client(self._address, timeout=CONNECT_TIMEOUT_S, set_as_default=False)
        except (OSError, ValueError) as error:
            reason = (str(error).splitlines() or [type(error).__name__])[0]
            raise UserError(f"--scheduler {self._address}: no Dask scheduler answers ({reason}); check the address") from error
        try:
            client.wait_for_workers(1, timeout=WORKER_TIMEOUT_S)
        except TimeoutError as error:
            client.close()
            raise UserError(f"--scheduler {self._address}: has no worker; start one with: dask worker {self._address}") from error
        return client


def _outcome_of(future: Any, key: str) -> Outcome:
    if future.status == "finished":
        outcome: Outcome = future.result()
        return outcome
    error = future.exception()
    first_line = (str(error).splitlines() or [""])[0]
    return Outcome(key, reason=f"{type(error).__name__}: {first_line}")
