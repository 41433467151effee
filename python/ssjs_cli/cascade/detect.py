"""The command `cascade detect`: a model and images in, boxes with scores out. The same bytes at any number of workers."""

import os
import time
from collections.abc import Sequence, Set
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ssjs_cli import _core
from ssjs_cli.cascade.labelled_images import mirrored_names
from ssjs_cli.cascade.model_file import Model, load_model
from ssjs_cli.cascade.one_image import OVERLAYS, DetectionTask, detect_in_image
from ssjs_cli.cascade.settings import DETECTION, DETECTOR_PREFIX, SettingsRequest, part, resolve_cascade
from ssjs_cli.config import Settings
from ssjs_cli.errors import UserError
from ssjs_cli.formats.atomic import new_directory
from ssjs_cli.segmentation.image_list import ListedImage, listed_images
from ssjs_cli.segmentation.run import carried_out
from ssjs_cli.session import Session
from ssjs_cli.studies.executor import Job, Outcome
from ssjs_cli.studies.study_folder import key_of
from ssjs_cli.studies.tables import csv_text, json_text

KIND = "detection directory"
SUMMARY_FILE = "detections.json"
TABLE_FILE = "detections.csv"
CONFIG_FILE = "config.toml"
TIMING_FILE = "timing.json"
FAULT_FILE = "faults.log"
FILES = (SUMMARY_FILE, TABLE_FILE, CONFIG_FILE, TIMING_FILE, FAULT_FILE, OVERLAYS)
COLUMNS = ("image", "x_px", "y_px", "width_px", "height_px", "score")
MAX_REASONS = 20


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


@dataclass(frozen=True)
class FinishedDetection:
    directory: Path
    document: dict[str, Any]
    failures: list[tuple[str, str]]


def detect(request: DetectionRequest, session: Session) -> FinishedDetection:
    settings, seed = resolve_cascade(request.settings, DETECTION)
    model = load_model(request.model)
    images = listed_images(request.images)
    out = request.out or Path("runs") / f"{Path(os.path.abspath(request.images[0])).stem}-detections"
    session.fault_log = out.with_name(out.name + ".fault.jsonl")
    started_s = time.perf_counter()
    with new_directory(out, force=request.force, why_not_ours=why_not_detections, kind=KIND) as partial:
        overlays = partial / OVERLAYS if request.with_overlays else None
        if overlays is not None:
            overlays.mkdir()
        outcomes = outcomes_of(images, model, settings, request.jobs, overlays, session, mirrored_names(images, request.mirrored))
        failures = [(image.name, outcomes[image.stem].reason) for image in images if outcomes[image.stem].record is None]
        records = [record for image in images if (record := outcomes[image.stem].record) is not None]
        document = {
            "version": _core.version(),
            "model": model.path.name,
            "model_sha256": model.digest,
            "configuration_digest": key_of(dict(settings.values)),
            "totals": {
                "images": len(records),
                "failed": len(failures),
                "detections": sum(record["summary"]["detections"] for record in records),
            },
            "failed": [{"image": name, "reason": reason} for name, reason in failures],
            "images": [{**record["summary"], "boxes": record["detections"]} for record in records],
        }
        rows = [row for record in records for row in record["detections"]]
        (partial / TABLE_FILE).write_text(csv_text(COLUMNS, rows), encoding="utf-8")
        (partial / SUMMARY_FILE).write_text(json_text(document), encoding="utf-8")
        (partial / CONFIG_FILE).write_text(settings.to_toml(seed), encoding="utf-8")
        timing = {
            "time_total_s": round(time.perf_counter() - started_s, 6),
            "images": [{"image": record["summary"]["image"], "time_detect_s": record["time_detect_s"]} for record in records],
        }
        (partial / TIMING_FILE).write_text(json_text(timing), encoding="utf-8")
        faults = [outcome.fault for outcome in outcomes.values() if outcome.fault]
        if faults:
            (partial / FAULT_FILE).write_text("\n".join(faults) + "\n", encoding="utf-8")
    return FinishedDetection(out, document, failures)


def outcomes_of(
    images: Sequence[ListedImage],
    model: Model,
    settings: Settings,
    jobs: int | None,
    overlays: Path | None,
    session: Session,
    mirrored: Set[str],
) -> dict[str, Outcome]:
    """By the stem of the image. One image is searched by all workers, many by one each. Raises UserError if none could be used."""
    workers = jobs or os.cpu_count() or 1
    text = model.cascade.to_json()
    values = part(settings.values, DETECTOR_PREFIX)
    tasks = [
        Job(
            image.stem,
            DetectionTask(
                path=str(image.path),
                name=image.name,
                model=text,
                margin=model.margin,
                smoothing_px=model.smoothing_px,
                settings=values,
                threads=workers if len(images) == 1 else 1,
                overlay=None if overlays is None else str(overlays / f"{image.stem}.png"),
                mirrored=image.name in mirrored,
            ),
        )
        for image in images
    ]
    outcomes = carried_out(detect_in_image, tasks, workers, "detecting")
    for image in images:
        if outcomes[image.stem].fault:
            session.log("fault", level="error", image=image.name, traceback=outcomes[image.stem].fault)
    reasons = [outcomes[image.stem].reason for image in images if outcomes[image.stem].record is None]
    if len(reasons) == len(images):
        more = f"\nand {len(reasons) - MAX_REASONS} more images that could not be used" if len(reasons) > MAX_REASONS else ""
        raise UserError("\n".join(reasons[:MAX_REASONS]) + more)
    return outcomes


def why_not_detections(directory: Path) -> str | None:
    if not (directory / SUMMARY_FILE).is_file():
        return f"it holds no {SUMMARY_FILE}"
    foreign = sorted(entry.name for entry in directory.iterdir() if entry.name not in FILES)
    return f"it also holds {foreign[0]}" if foreign else None
