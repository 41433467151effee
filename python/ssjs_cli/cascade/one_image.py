"""Detection in one image, in whatever process: read, searched, its overlay written, its boxes returned as plain data."""

import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ssjs_cli import _core
from ssjs_cli.cascade.box_pictures import FOUND, DrawnBox, overlay
from ssjs_cli.cascade.model_file import cascade_from_text
from ssjs_cli.cascade.smoothing import smoothed
from ssjs_cli.cascade.window_boxes import object_box
from ssjs_cli.config import Scalar
from ssjs_cli.formats.file_digest import file_digest
from ssjs_cli.formats.image_file import read_image, write_png

OVERLAYS = "overlays"
SCORE_DECIMALS = 6
SIDE, AS_TRAINED, MIRRORED = "side", "as_trained", "mirrored"


@dataclass(frozen=True)
class DetectionTask:
    """Plain data, so that it can go to another process. overlay: the file to write, none: no picture."""

    path: str
    name: str
    model: str
    margin: float
    smoothing_px: int
    settings: Mapping[str, Scalar]
    threads: int = 1
    overlay: str | None = None
    mirrored: bool = False


def seen_from(task: DetectionTask) -> dict[str, Scalar]:
    """The detector's settings; mirrored images turn the side round."""
    if not task.mirrored:
        return dict(task.settings)
    return {**task.settings, SIDE: AS_TRAINED if task.settings[SIDE] == MIRRORED else MIRRORED}


def detect_in_image(task: DetectionTask) -> dict[str, Any]:
    """summary: one row about the image; detections: a row each, best score first."""
    _core.set_image_threads(1)
    path = Path(task.path)
    image = read_image(path)
    started_s = time.perf_counter()
    levels = smoothed(image.levels, image.valid, task.smoothing_px)
    found = _core.detect_objects(cascade_from_text(task.model), levels, image.valid, seen_from(task), task.threads)
    time_detect_s = time.perf_counter() - started_s
    rows = []
    boxes = []
    for *window, score, neighbours in found.tolist():
        box = object_box((int(window[0]), int(window[1]), int(window[2]), int(window[3])), task.margin)
        boxes.append(DrawnBox(box, FOUND, f"{score:.2f}"))
        left, top, width, height = box
        rows.append(
            {
                "image": task.name, "x_px": left, "y_px": top, "width_px": width, "height_px": height,
                "score": round(score, SCORE_DECIMALS), "neighbours": int(neighbours),
            }
        )  # fmt: skip
    if task.overlay is not None:
        write_png(Path(task.overlay), overlay(image, boxes))
    summary = {
        "image": task.name,
        "sha256": file_digest(path),
        "width_px": image.width_px,
        "height_px": image.height_px,
        "detections": len(rows),
        "notes": list(image.notes),
    }
    return {"summary": summary, "detections": rows, "time_detect_s": round(time_detect_s, 6)}
