"""Detection in one image, in whatever process: read, searched, its overlay written, its boxes returned as plain data."""

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ssjs_cli import _core
from ssjs_cli.cascade.box_pictures import FOUND, DrawnBox, overlay
from ssjs_cli.cascade.model_file import cascade_from_text
from ssjs_cli.cascade.preparation import Preparation
from ssjs_cli.cascade.settings import VERIFY_KEY
from ssjs_cli.cascade.sides import SIDE_KEY, PictureSide, sides_of
from ssjs_cli.cascade.size_limits import DETECTOR_PREFIX, in_pixels
from ssjs_cli.cascade.window_boxes import object_box
from ssjs_cli.config import Scalar
from ssjs_cli.formats.file_digest import file_digest
from ssjs_cli.formats.image_file import read_image, write_png
from ssjs_cli.formats.image_levels import LevelImage
from ssjs_cli.segmentation.ground_settings import NADIR_KEY, NO_NADIR, PIXEL_ACROSS_KEY, PIXEL_ALONG_KEY

OVERLAYS = "overlays"
SCORE_DECIMALS = 6
LENGTH_DECIMALS = 4


@dataclass(frozen=True)
class DetectionTask:
    """Plain data, so that it can go to another process. settings: all of a detection; overlay: the file to write, none: no picture."""

    path: str
    name: str
    model: str
    margin: float
    preparation: Preparation
    settings: Mapping[str, Scalar]
    threads: int = 1
    overlay: str | None = None
    mirrored: bool = False


def further_columns(settings: Mapping[str, Scalar]) -> tuple[str, ...]:
    """What a detection's row holds besides its box and score."""
    return (
        *(("width_m", "height_m") if settings[PIXEL_ACROSS_KEY] is not None else ()),
        *(("side",) if settings[NADIR_KEY] != NO_NADIR else ()),
        *(("contour_distance", "contour_score") if settings[VERIFY_KEY] == "contour" else ()),
    )


def detect_in_image(task: DetectionTask) -> dict[str, Any]:
    """summary: one row about the image; detections: a row each, best score first."""
    _core.set_image_threads(1)
    path = Path(task.path)
    image = read_image(path)
    started_s = time.perf_counter()
    sides = sides_of(task.settings, image.width_px, str(path), mirrored=task.mirrored)
    rows = [row for side in sides for row in _detections_on(side, image, task)]
    if len(sides) > 1:
        rows.sort(key=lambda row: (-row["score"], row["y_px"], row["x_px"], row["width_px"], row["height_px"]))
    time_detect_s = time.perf_counter() - started_s
    if task.overlay is not None:
        boxes = [DrawnBox((row["x_px"], row["y_px"], row["width_px"], row["height_px"]), FOUND, f"{row['score']:.2f}") for row in rows]
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


def _detections_on(side: PictureSide, image: LevelImage, task: DetectionTask) -> list[dict[str, Any]]:
    levels, valid = side.levels_of(image, task.preparation)
    config = {**in_pixels(task.settings, task.margin), SIDE_KEY.removeprefix(DETECTOR_PREFIX): side.as_setting}
    found = _core.detect_objects(cascade_from_text(task.model), levels, valid, config, task.threads)
    across_m, along_m = task.settings[PIXEL_ACROSS_KEY], task.settings[PIXEL_ALONG_KEY]
    rows = []
    for x, y, window_width, window_height, score, neighbours, *contour in found.tolist():
        inner = object_box((int(x), int(y), int(window_width), int(window_height)), task.margin, mirrored=side.mirrored)
        shown = task.preparation.object_in_picture(inner, side.end_column - side.first_column, image.height_px)
        if shown is None:
            continue
        left, top, width, height = shown[0] + side.first_column, *shown[1:]
        row: dict[str, Any] = {
            "image": task.name, "x_px": left, "y_px": top, "width_px": width, "height_px": height,
            "score": round(score, SCORE_DECIMALS), "neighbours": int(neighbours),
        }  # fmt: skip
        if across_m is not None and along_m is not None:
            row["width_m"] = round(width * float(across_m), LENGTH_DECIMALS)
            row["height_m"] = round(height * float(along_m), LENGTH_DECIMALS)
        if side.name is not None:
            row["side"] = side.name
        if contour:
            distance, contour_score = contour
            row["contour_distance"] = None if math.isnan(distance) else round(distance, SCORE_DECIMALS)
            row["contour_score"] = round(contour_score, SCORE_DECIMALS)
        rows.append(row)
    return rows
