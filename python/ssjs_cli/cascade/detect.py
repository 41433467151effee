"""The command `cascade detect`: a model and images in, boxes with scores out. The same bytes at any number of workers."""

import os
import time
from collections.abc import Sequence, Set
from dataclasses import dataclass, field
from pathlib import Path

from ssjs_cli import _core
from ssjs_cli.cascade.labelled_images import mirrored_names
from ssjs_cli.cascade.model_file import Model, load_model
from ssjs_cli.cascade.one_image import OVERLAYS, DetectionTask, detect_in_image, further_columns
from ssjs_cli.cascade.settings import DETECTION, VERIFY_KEY, SettingsRequest, resolve_cascade
from ssjs_cli.config import Settings
from ssjs_cli.errors import UserError
from ssjs_cli.finished import Finished
from ssjs_cli.formats.atomic import holds_only, new_directory
from ssjs_cli.segmentation.image_jobs import ImageResults, each_image
from ssjs_cli.segmentation.image_list import ListedImage, listed_images, title_of
from ssjs_cli.session import Session
from ssjs_cli.studies.study_folder import key_of
from ssjs_cli.studies.tables import csv_text, json_text

KIND = "detection directory"
SUMMARY_FILE = "detections.json"
TABLE_FILE = "detections.csv"
CONFIG_FILE = "config.toml"
TIMING_FILE = "timing.json"
FAULT_FILE = "faults.log"
FILES = (SUMMARY_FILE, TABLE_FILE, CONFIG_FILE, TIMING_FILE, FAULT_FILE, OVERLAYS)
why_not_detections = holds_only(FILES, (SUMMARY_FILE,))
COLUMNS = ("image", "x_px", "y_px", "width_px", "height_px", "score")


@dataclass(frozen=True)
class DetectionRequest:
    model: Path
    images: Sequence[str]
    settings: SettingsRequest = field(default_factory=SettingsRequest)
    mirrored: str | None = None
    jobs: int | None = None
    with_overlays: bool = True
    out: Path | None = None
    force: bool = False


def detect(request: DetectionRequest, session: Session) -> Finished:
    settings, seed = resolve_cascade(request.settings, DETECTION)
    model = load_model(request.model)
    images = listed_images(request.images)
    out = request.out or Path("runs") / f"{title_of(request.images)}-detections"
    session.fault_log = out.with_name(out.name + ".fault.jsonl")
    started_s = time.perf_counter()
    with new_directory(out, force=request.force, why_not_ours=why_not_detections, kind=KIND) as partial:
        overlays = partial / OVERLAYS if request.with_overlays else None
        if overlays is not None:
            overlays.mkdir()
        results = detections_in(images, model, settings, request.jobs, overlays, session, mirrored_names(images, request.mirrored))
        records = list(results.records.values())
        document = {
            "version": _core.version(),
            "model": model.path.name,
            "model_sha256": model.digest,
            "configuration_digest": key_of(dict(settings.values)),
            "totals": {
                "images": len(records),
                "failed": len(results.failures),
                "detections": sum(record["summary"]["detections"] for record in records),
            },
            "failed": [{"image": name, "reason": reason} for name, reason in results.failures],
            "images": [{**record["summary"], "boxes": record["detections"]} for record in records],
        }
        rows = [row for record in records for row in record["detections"]]
        (partial / TABLE_FILE).write_text(csv_text((*COLUMNS, *further_columns(settings.values)), rows), encoding="utf-8")
        (partial / SUMMARY_FILE).write_text(json_text(document), encoding="utf-8")
        (partial / CONFIG_FILE).write_text(settings.to_toml(seed), encoding="utf-8")
        timing = {
            "time_total_s": round(time.perf_counter() - started_s, 6),
            "images": [{"image": record["summary"]["image"], "time_detect_s": record["time_detect_s"]} for record in records],
        }
        (partial / TIMING_FILE).write_text(json_text(timing), encoding="utf-8")
        if results.faults:
            (partial / FAULT_FILE).write_text("\n".join(results.faults) + "\n", encoding="utf-8")
    return Finished(out, document, results.failures)


def check_verifiable(model: Model, settings: Settings) -> None:
    if settings.values[VERIFY_KEY] == "contour" and model.cascade.contours_known == 0:
        raise UserError(
            f"{model.path}: holds no contours to verify detections with; give a cascade.json trained with contour.learn = true, "
            "or leave --verify out"
        )


def detections_in(
    images: Sequence[ListedImage],
    model: Model,
    settings: Settings,
    jobs: int | None,
    overlays: Path | None,
    session: Session,
    mirrored: Set[str],
) -> ImageResults:
    """One image is searched by all workers, many by one each. Raises UserError if none could be used."""
    workers = jobs or os.cpu_count() or 1
    text = model.cascade.to_json()
    check_verifiable(model, settings)

    def task_of(_: int, image: ListedImage) -> DetectionTask:
        return DetectionTask(
            path=str(image.path),
            name=image.name,
            model=text,
            margin=model.margin,
            preparation=model.preparation,
            settings=dict(settings.values),
            threads=workers if len(images) == 1 else 1,
            overlay=None if overlays is None else str(overlays / f"{image.stem}.png"),
            mirrored=image.name in mirrored,
        )

    return each_image(detect_in_image, images, task_of, workers, "detecting", session)
