"""Who carries out the runs of a study. Jobs are independent: their results do not depend on the number of workers or on the order."""

import traceback
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from ssjs_cli.errors import UserError

#: An executor answers at least this often, so that its caller can show progress and notice Ctrl-C.
POLL_S = 0.2
#: How often a job is tried whose worker dies under it.
MAX_ATTEMPTS = 3

Record = dict[str, Any]
Work = Callable[[Any], Record]


@dataclass(frozen=True)
class Job:
    """key: unique in the study; payload: what the work takes, plain data that can be sent to another process."""

    key: str
    payload: Any


@dataclass(frozen=True)
class Outcome:
    """Either a record, or the reason why there is none. `lasting`: the same job would fail again; a dead worker or a full memory
    would not say so. `fault`: the traceback of a fault that is ours."""

    key: str
    record: Record | None = None
    reason: str = ""
    lasting: bool = False
    fault: str = ""


class TimeLimitError(Exception):
    """A run has come to its time limit. Another day it might not: the reason is not a lasting one."""


def time_limit_reason(time_limit_s: float, how_far: str) -> str:
    return f"not finished within the time limit of {time_limit_s:g} s ({how_far}); a longer --time-limit-s lets it go on"


class Executor(Protocol):
    def outcomes(self, work: Work, jobs: Sequence[Job]) -> Iterator[Outcome | None]:
        """Every job once, in the order in which they end; None whenever POLL_S passed without an end. Closing the iterator stops
        what is under way. `work` is a function of a module, so that a worker can import it."""
        ...


def attempt(work: Work, job: Job) -> Outcome:
    """The work on one job, in the worker: whatever goes wrong becomes a reason, and the study goes on."""
    try:
        return Outcome(job.key, record=work(job.payload))
    except UserError as error:
        return Outcome(job.key, reason=str(error), lasting=True)
    except TimeLimitError as error:
        return Outcome(job.key, reason=str(error))
    except MemoryError:
        return Outcome(job.key, reason="the memory was used up; free some, or run fewer jobs at a time")
    except Exception as error:
        first_line = (str(error).splitlines() or [""])[0]
        return Outcome(job.key, reason=f"internal fault: {type(error).__name__}: {first_line}", fault=traceback.format_exc())
