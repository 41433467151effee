"""The runs of a study, finished ones taken from its folder and the others carried out."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from ssjs_cli.errors import InterruptionError
from ssjs_cli.progress import interruptible
from ssjs_cli.session import Session
from ssjs_cli.studies.executor import Executor, Job, Record, Work
from ssjs_cli.studies.study_folder import FAULT_FILE, StudyFolder, key_of


@dataclass(frozen=True)
class PlannedRun:
    """identity: all that determines the result, as plain data; payload: what the work takes."""

    identity: Mapping[str, Any]
    payload: Any

    @cached_property
    def key(self) -> str:
        return key_of(self.identity)


@dataclass
class CarriedOut:
    """records and reasons by the key of the run: every run has one or the other."""

    records: dict[str, Record] = field(default_factory=dict)
    reasons: dict[str, str] = field(default_factory=dict)


REFUSED = "refused"


def carry_out(
    work: Work,
    runs: Sequence[PlannedRun],
    executor: Executor,
    folder: StudyFolder,
    label: str,
    session: Session,
    *,
    finished: int = 0,
) -> CarriedOut:
    """Each end of a run is stored at once, so that an interruption loses only what is under way. Runs that failed for a reason which
    may pass are not stored: the next call tries them again. finished: how many others the caller knows to be finished."""
    by_key = {run.key: run for run in runs}
    done = CarriedOut()
    for key, record in folder.finished(by_key).items():
        _note(done, key, record)
    missing = [Job(key, run.payload) for key, run in by_key.items() if key not in done.records and key not in done.reasons]
    total = len(by_key) + finished
    ended = total - len(missing)
    if missing and ended:
        session.message(f"{ended} of {total} runs are finished already")
    outcomes = executor.outcomes(work, missing)
    try:
        with interruptible(label) as progress:
            for outcome in outcomes:
                if outcome is not None:
                    ended += 1
                    if outcome.record is not None:
                        _note(done, outcome.key, folder.store(outcome.key, by_key[outcome.key].identity, outcome.record))
                    else:
                        _note_failure(done, outcome.key, outcome.reason, folder, outcome.fault)
                        if outcome.lasting:
                            folder.store(outcome.key, by_key[outcome.key].identity, {REFUSED: outcome.reason})
                if not progress(ended / total):
                    break
    except (InterruptionError, KeyboardInterrupt) as error:
        text = f"interrupted after {ended} of {total} runs; the same command continues with {folder.path}"
        raise InterruptionError(text) from error
    finally:
        _close(outcomes)
    return done


def _note(done: CarriedOut, key: str, record: Record) -> None:
    if REFUSED in record:
        done.reasons[key] = str(record[REFUSED])
    else:
        done.records[key] = record


def _note_failure(done: CarriedOut, key: str, reason: str, folder: StudyFolder, fault: str) -> None:
    if fault:
        folder.note_fault(fault)
        reason = f"{reason} (traceback in {FAULT_FILE})"
    done.reasons[key] = reason


def _close(outcomes: Any) -> None:
    close = getattr(outcomes, "close", None)
    if close is not None:
        close()
