"""The five methods on one image: what each finds, how it meets the truth, how long it takes. Same filter, gain, power law and
morphology for all."""

import statistics
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ssjs_cli import _core
from ssjs_cli.config import Scalar, Settings, part
from ssjs_cli.formats.image_levels import LevelImage, Mask
from ssjs_cli.segmentation.contact_sheet import THUMBNAIL_PX, Thumbnail, jpeg_bytes
from ssjs_cli.segmentation.picture_input import MaskSource, read_picture
from ssjs_cli.segmentation.pictures import Drawing, Pixels, panels, picture_with_truth
from ssjs_cli.segmentation.settings import CHAIN_PREFIX, SEGMENTATION
from ssjs_cli.segmentation.truth import Truth, TruthSource, truth_for

IMPROVED_OTSU, OTSU, LOCAL, ITERATIVE, MAX_ENTROPY = METHODS = ("improved-otsu", "otsu", "local", "iterative", "max-entropy")
COUNTS = ("true_positives", "false_positives", "false_negatives", "true_negatives", "hits", "false_area_px", "background_px")
_MS = 1000.0


@dataclass(frozen=True)
class ComparisonTask:
    path: str
    name: str
    settings: Mapping[str, Scalar]
    truth: TruthSource = field(default_factory=TruthSource)
    valid_mask: str | None = None
    repeats: int = 3
    with_thumbnails: bool = False


def compare_on_image(task: ComparisonTask) -> dict[str, Any]:
    """rows: one a method; objects: of each method the centroid error of every object it has a region of; thumbnails."""
    _core.set_image_threads(1)
    settings = Settings(task.settings, kind=SEGMENTATION)
    path = Path(task.path)
    image = read_picture(path, settings, None if task.valid_mask is None else MaskSource(Path(task.valid_mask)))
    truth = truth_for(task.truth, path, task.name, image)
    chain = part(settings.values, CHAIN_PREFIX)
    contrasted, valid = _contrasted(image, chain), image.valid
    first = _core.otsu_threshold(contrasted, valid)
    pool = np.zeros(contrasted.shape, dtype=np.uint8) if first is None else _core.foreground(contrasted, first, valid)
    times = _times_ms(image, contrasted, chain, task.repeats)
    rows, errors, drawings = [], {}, {}
    for method in METHODS:
        result = _core.segment(image.levels, valid, {**chain, "method": method})
        row: dict[str, Any] = {
            "image": task.name,
            "method": method,
            "threshold": result["threshold"],
            "second_pass_fired": (result["improved_otsu"] or {}).get("second_pass_fired"),
            "spots": (result["improved_otsu"] or {}).get("spots"),
            "regions": len(result["regions"]),
        }
        if truth is not None:
            score = _core.segmentation_score(result["regions"], truth.objects, pool)
            row.update({key: score[key] for key in COUNTS})
            row["objects"] = len(score["objects"])
            row["pixel_recall"], row["mask_iou"] = score["pixel_recall"], score["mask_iou"]
            row["false_area_fraction"] = score["false_area_fraction"]
            errors[method] = [entry["centroid_error_px"] for entry in score["objects"] if entry["centroid_error_px"] is not None]
        row.update(times[method])
        rows.append(row)
        centroids = [(float(x), float(y)) for x, y in result["regions"].centroid_px]
        drawings[method] = Drawing(image, result["mask"], centroids, [])
    return {
        "rows": rows,
        "centroid_errors_px": errors,
        "thumbnails": _thumbnails(image, truth, drawings) if task.with_thumbnails else [],
    }


def _contrasted(image: LevelImage, chain: Mapping[str, Scalar]) -> Pixels:
    """What every method finds its threshold on: the picture after filter, gain and power law."""
    steps = _core.segment(image.levels, image.valid, {**chain, "method": OTSU}, True)["steps"]
    picture: Pixels = steps["contrasted"]
    return picture


def _times_ms(image: LevelImage, contrasted: Pixels, chain: Mapping[str, Scalar], repeats: int) -> dict[str, dict[str, float]]:
    """Medians over rounds in which the methods take turns, on one thread: the thresholding alone, and the chain to the centroids."""
    threshold_ms: dict[str, list[float]] = {method: [] for method in METHODS}
    chain_ms: dict[str, list[float]] = {method: [] for method in METHODS}
    for _ in range(repeats):
        for method in METHODS:
            binarise = _binariser(method, contrasted, image.valid, chain)
            threshold_ms[method].append(_timed_ms(binarise))
            chain_ms[method].append(_timed_ms(partial(_core.segment, image.levels, image.valid, {**chain, "method": method})))
    return {
        method: {
            "time_ms": round(statistics.median(threshold_ms[method]), 4),
            "chain_time_ms": round(statistics.median(chain_ms[method]), 4),
        }
        for method in METHODS
    }


def _timed_ms(work: Callable[[], object]) -> float:
    started_s = time.perf_counter()
    work()
    return _MS * (time.perf_counter() - started_s)


def _binariser(method: str, picture: Pixels, valid: Mask | None, chain: Mapping[str, Scalar]) -> Callable[[], object]:
    """From the prepared picture to black and white."""
    if method == LOCAL:
        local = part(chain, "local.")
        return lambda: _core.local_foreground(picture, valid, local)
    if method == IMPROVED_OTSU:
        improved = part(chain, "improved_otsu.")

        def find() -> int | None:
            answer = _core.improved_otsu(picture, valid, improved)
            return None if answer is None else int(answer["threshold"])
    else:
        of_histogram = {
            OTSU: _core.otsu_threshold,
            ITERATIVE: _core.iterative_threshold,
            MAX_ENTROPY: _core.maximum_entropy_threshold,
        }[method]

        def find() -> int | None:
            return of_histogram(picture, valid)

    def binarise() -> object:
        threshold = find()
        return None if threshold is None else _core.foreground(picture, threshold, valid)

    return binarise


def _thumbnails(image: LevelImage, truth: Truth | None, drawings: Mapping[str, Drawing]) -> list[Thumbnail]:
    nothing = np.zeros(image.levels.shape, dtype=np.uint8)
    shown = picture_with_truth(image, nothing if truth is None else truth.shown, THUMBNAIL_PX)
    label = "picture" if truth is None else "picture and truth"
    found = [Thumbnail(method, jpeg_bytes(panels(drawing, THUMBNAIL_PX).marked)) for method, drawing in drawings.items()]
    return [Thumbnail(label, jpeg_bytes(shown)), *found]
