"""The same work on many images, here or in worker processes; the results do not depend on where."""

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from ssjs_cli.errors import UserError
from ssjs_cli.progress import interruptible
from ssjs_cli.segmentation.image_list import ListedImage
from ssjs_cli.session import Session
from ssjs_cli.studies.executor import Job, Outcome, Record, Work, attempt
from ssjs_cli.studies.process_pool import ProcessPool

MAX_REASONS = 20


@dataclass(frozen=True)
class ImageResults:
    """records: by the image's name; failures: name and reason of the images that could not be used; both in the order of the images.
    faults: tracebacks of faults that are ours."""

    records: dict[str, Record] = field(default_factory=dict)
    failures: list[tuple[str, str]] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)


def each_image(
    work: Work, images: Sequence[ListedImage], task_of: Callable[[int, ListedImage], Any], workers: int | None, label: str, session: Session
) -> ImageResults:
    """task_of(position, image): what the work takes. workers None: one a core. Raises UserError if no image could be used."""
    outcomes = _carried_out(work, [Job(image.stem, task_of(position, image)) for position, image in enumerate(images)], workers, label)
    results = ImageResults()
    for image in images:
        outcome = outcomes[image.stem]
        if outcome.record is not None:
            results.records[image.name] = outcome.record
        else:
            results.failures.append((image.name, outcome.reason))
        if outcome.fault:
            session.log("fault", level="error", image=image.name, traceback=outcome.fault)
            results.faults.append(outcome.fault)
    if not results.records:
        more = len(results.failures) - MAX_REASONS
        reasons = [reason for _, reason in results.failures[:MAX_REASONS]]
        raise UserError("\n".join([*reasons, *([f"and {more} more images that could not be used"] if more > 0 else [])]))
    return results


def _carried_out(work: Work, jobs: Sequence[Job], workers: int | None, label: str) -> dict[str, Outcome]:
    """Every job's outcome by its key; a single job, or one worker, is done in this process."""
    count = min(workers or os.cpu_count() or 1, len(jobs))
    done: dict[str, Outcome] = {}
    outcomes = _here(work, jobs) if count == 1 else ProcessPool(count).outcomes(work, jobs)
    try:
        with interruptible(label) as progress:
            for outcome in outcomes:
                if outcome is not None:
                    done[outcome.key] = outcome
                if not progress(len(done) / len(jobs)):
                    break
    finally:
        close = getattr(outcomes, "close", None)
        if close is not None:
            close()
    return done


def _here(work: Work, jobs: Sequence[Job]) -> Iterator[Outcome]:
    for job in jobs:
        yield attempt(work, job)
