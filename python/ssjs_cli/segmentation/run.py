"""The command `segment`: images in, a directory of masks, tables and pictures out. The same bytes at any number of workers."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from ssjs_cli.config import Settings
from ssjs_cli.errors import UserError
from ssjs_cli.finished import Finished
from ssjs_cli.formats.atomic import new_directory
from ssjs_cli.segmentation.contact_sheet import shown_positions
from ssjs_cli.segmentation.image_jobs import each_image
from ssjs_cli.segmentation.image_list import ListedImage, listed_images, title_of
from ssjs_cli.segmentation.one_image import MASKS, OVERLAYS, STEPS, ImageTask, segment_image
from ssjs_cli.segmentation.result_files import KIND, Segmented, why_not_a_segmentation, write_results
from ssjs_cli.segmentation.settings import DEFAULT_PRESET, SettingsRequest, resolve_segmentation
from ssjs_cli.session import Session


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


def segment_images(request: SegmentationRequest, session: Session) -> Finished:
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
        task_of = _tasks(len(images), settings, partial, request)
        results = each_image(segment_image, images, task_of, request.jobs, "segmenting", session)
        segmented = Segmented(
            title=title_of(request.images),
            method=str(settings.values["segmentation.method"]),
            preset=request.settings.preset or (DEFAULT_PRESET if request.settings.config_path is None else None),
            seed=seed,
            settings=settings,
            records=list(results.records.values()),
            failures=results.failures,
            faults=results.faults,
            time_total_s=time.perf_counter() - started_s,
        )
        document = write_results(partial, segmented, with_report=request.with_report)
    return Finished(out, document, results.failures)


def _tasks(images: int, settings: Settings, partial: Path, request: SegmentationRequest) -> Callable[[int, ListedImage], ImageTask]:
    shown = set(shown_positions(images)) if request.with_report else set()

    def task_of(position: int, image: ListedImage) -> ImageTask:
        return ImageTask(
            path=str(image.path),
            name=image.name,
            stem=image.stem,
            settings=dict(settings.values),
            out=str(partial),
            valid_mask=None if request.valid_mask is None else str(request.valid_mask),
            with_thumbnails=position in shown,
            keep_steps=request.keep_steps,
        )

    return task_of
