"""The command `segment`: images in, a directory of masks, tables and pictures out. The same bytes at any number of workers."""

import os
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ssjs_cli.config import Settings
from ssjs_cli.errors import UserError
from ssjs_cli.formats.atomic import new_directory
from ssjs_cli.progress import interruptible
from ssjs_cli.segmentation.contact_sheet import shown_positions
from ssjs_cli.segmentation.image_list import ListedImage, listed_images
from ssjs_cli.segmentation.one_image import MASKS, OVERLAYS, STEPS, ImageTask, segment_image
from ssjs_cli.segmentation.result_files import KIND, Segmented, why_not_a_segmentation, write_results
from ssjs_cli.segmentation.settings import DEFAULT_PRESET, SettingsRequest, resolve_segmentation
from ssjs_cli.session import Session
from ssjs_cli.studies.executor import Job, Outcome, Work, attempt
from ssjs_cli.studies.process_pool import ProcessPool


@dataclass(frozen=True)
class SegmentationRequest:
    images: Sequence[str]
    settings: SettingsRequest = field(default_factory=SettingsRequest)
    valid_mask: Path | None = None
    jobs: int | None = None
    keep_steps: bool = False
    with_report: bool = True
    out: Path | None = None
    force: bool = False


@dataclass(frozen=True)
class FinishedSegmentation:
    directory: Path
    document: dict[str, Any]
    failures: list[tuple[str, str]]


def segment_images(request: SegmentationRequest, session: Session) -> FinishedSegmentation:
    settings, seed = resolve_segmentation(request.settings)
    images = listed_images(request.images)
    if request.valid_mask is not None and not request.valid_mask.exists():
        raise UserError(f"{request.valid_mask}: No such file or directory; check the path of --mask")
    out = request.out or Path("runs") / f"{title_of(request.images)}-segmentation"
    session.fault_log = out.with_name(out.name + ".fault.jsonl")
    started_s = time.perf_counter()
    with new_directory(out, force=request.force, why_not_ours=why_not_a_segmentation, kind=KIND) as partial:
        for folder in (MASKS, OVERLAYS, *([STEPS] if request.keep_steps else [])):
            (partial / folder).mkdir()
        outcomes = carried_out(segment_image, _jobs(images, settings, partial, request), request.jobs, "segmenting")
        records = [outcomes[image.stem].record for image in images]
        failures = [(image.name, outcomes[image.stem].reason) for image in images if outcomes[image.stem].record is None]
        for image in images:
            if outcomes[image.stem].fault:
                session.log("fault", level="error", image=image.name, traceback=outcomes[image.stem].fault)
        if len(failures) == len(images):
            raise UserError("\n".join(reason for _, reason in failures[:20]) + _more(len(failures) - 20))
        segmented = Segmented(
            title=title_of(request.images),
            method=str(settings.values["segmentation.method"]),
            preset=request.settings.preset or (DEFAULT_PRESET if request.settings.config_path is None else None),
            seed=seed,
            settings=settings,
            records=[record for record in records if record is not None],
            failures=failures,
            faults=[outcomes[image.stem].fault for image in images if outcomes[image.stem].fault],
            time_total_s=time.perf_counter() - started_s,
        )
        document = write_results(partial, segmented, with_report=request.with_report)
    return FinishedSegmentation(out, document, failures)


def _jobs(images: Sequence[ListedImage], settings: Settings, partial: Path, request: SegmentationRequest) -> list[Job]:
    shown = set(shown_positions(len(images))) if request.with_report else set()
    return [
        Job(
            image.stem,
            ImageTask(
                path=str(image.path),
                name=image.name,
                stem=image.stem,
                settings=dict(settings.values),
                out=str(partial),
                valid_mask=None if request.valid_mask is None else str(request.valid_mask),
                with_thumbnails=position in shown,
                keep_steps=request.keep_steps,
            ),
        )
        for position, image in enumerate(images)
    ]


def carried_out(work: Work, jobs: Sequence[Job], workers: int | None, label: str) -> dict[str, Outcome]:
    """Every job's outcome by its key. workers None: one a core; a single job, or one worker, is done in this process."""
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


def title_of(arguments: Sequence[str]) -> str:
    """The name of the first folder or image, as far as it is a name."""
    first = Path(arguments[0])
    while any(character in first.name for character in "*?["):
        first = first.parent
    first = Path(os.path.abspath(first))
    return (first.name if first.is_dir() else first.stem) or "images"


def _more(count: int) -> str:
    return f"\nand {count} more images that could not be used" if count > 0 else ""
