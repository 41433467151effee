"""Haar cascades on real side-scan sonar, by folds: no recording is in training and test at once.

    SSJS_DATA=data PYTHONPATH=python python benchmarks/cascade_real.py sdvd
    SSJS_DATA=data PYTHONPATH=python python benchmarks/cascade_real.py klsg

sdvd: tiles with one effigy each (boxes from the masks) and tiles without; five folds by the minute in the file name.
klsg: crops of wrecks against crops of seafloor; five folds of single crops, for the set names no recordings; one layer, no box to find.
"""

import argparse
import json
import os
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from ssjs_cli import _core
from ssjs_cli.cascade.contours import object_contours
from ssjs_cli.cascade.labelled_images import LabelledImages, LabelSource, read_labelled_images, recording_names
from ssjs_cli.cascade.preparation import preparation_of
from ssjs_cli.cascade.samples import make_samples
from ssjs_cli.cascade.scoring import ImageMatch, Scored, bootstrap_band, curve, match, wilson_band
from ssjs_cli.cascade.settings import (
    DETECTION,
    DETECTOR_PREFIX,
    MARGIN_KEY,
    TRAINER_PREFIX,
    TRAINING,
    SettingsRequest,
    resolve_cascade,
)
from ssjs_cli.cascade.size_limits import in_pixels
from ssjs_cli.cascade.window_boxes import object_box
from ssjs_cli.cascade.windows import judged, window_set
from ssjs_cli.config import part
from ssjs_cli.formats.image_file import read_image
from ssjs_cli.segmentation.image_list import listed_images

FOLDS = 5
IOU = 0.3
SDVD_RECORDING = r"(\d{12})"
SDVD_MIRRORED = "^right_"
#: Cumulative: detection rate, false positive rate; most features; of what reaches the layer, how much may pass. The rates asked for are
#: out of reach, so that each layer takes all of its features: the layers weed out what is easily told, the score ranks the rest.
SDVD_PLAN = [(0.99, 0.0005, 10, 1.0), (0.98, 0.0005, 30, 1.0), (0.97, 0.0005, 60, 1.0), (0.96, 0.0005, 80, 1.0)]
SDVD_SETTINGS = (
    "image.smoothing_px=3", "image.border_px=40", "window.width_px=16", "window.height_px=16", "window.margin=0.25",
    "validation.fraction=0.15", "augmentation.copies=9", "augmentation.scale=0.15", "augmentation.shift_px=1.3",
    "augmentation.gain=0", "augmentation.additive_noise=0", "augmentation.multiplicative_noise=0", "training.feature_set=side_scan_basic",
    "training.max_asymmetry=1", "training.max_shift=0", "training.min_improvement=0.0001", "training.negatives_per_layer=3000",
)  # fmt: skip
SDVD_DETECTOR = (
    "detector.grouping=best", "detector.min_neighbours=0", "detector.max_overlap=0.5", "detector.max_width_px=180",
    "detector.opencv_grid=false",
)  # fmt: skip
KLSG_WINDOW_PX = 20


def folds_of(names: list[str], seed: int) -> list[int]:
    """A fold for each name; equal names share one."""
    distinct = sorted(set(names))
    order = np.random.default_rng(seed).permutation(len(distinct))
    fold = {distinct[index]: place % FOLDS for place, index in enumerate(order.tolist())}
    return [fold[name] for name in names]


def sdvd(folder: Path, jobs: int, folds: list[int], overrides: list[str], models: Path | None, seed: int) -> dict[str, Any]:
    """overrides: settings of the training, and of the detector with `detector.` before them."""
    of_detector = [assignment for assignment in overrides if assignment.startswith(DETECTOR_PREFIX)]
    of_training = [assignment for assignment in overrides if assignment not in of_detector]
    settings, _ = resolve_cascade(SettingsRequest(assignments=[*SDVD_SETTINGS, *of_training]), TRAINING)
    detecting, _ = resolve_cascade(SettingsRequest(assignments=[*SDVD_DETECTOR, *of_detector]), DETECTION)
    margin, preparation = float(settings.values[MARGIN_KEY] or 0.0), preparation_of(settings.values)
    detector = in_pixels(detecting.values, margin)
    labelled = read_labelled_images([str(folder / "images")], LabelSource(masks=folder / "masks", mirrored=SDVD_MIRRORED), settings)
    recordings = recording_names([image.listed for image in labelled.images], SDVD_RECORDING)
    negatives = listed_images([str(folder / "negatives")])
    fold_of_image, fold_of_negative = folds_of(recordings, seed), folds_of([image.name for image in negatives], seed)
    matches: list[ImageMatch] = []
    layers: list[dict[str, Any]] = []
    for fold in folds:
        chosen = [index for index, number in enumerate(fold_of_image) if number != fold]
        background = [image for image, number in zip(negatives, fold_of_negative, strict=True) if number != fold]
        samples = make_samples(
            LabelledImages([labelled.images[index] for index in chosen]), [recordings[index] for index in chosen],
            background, [image.name for image in background], settings, seed, jobs,
        )  # fmt: skip
        started_s = time.perf_counter()
        kept = None if models is None else models / f"sdvd-fold-{fold}.json"
        if kept is not None and kept.is_file():
            cascade = _core.HaarCascade.load(str(kept))
        else:
            cascade = _core.train_cascade(
                window_set(samples.positives, samples.recordings), window_set(samples.validation_positives),
                validation_negatives=window_set(samples.validation_negatives), images=len(samples.negatives), read=samples.negatives.read,
                images_digest=samples.negatives.digest(), plan=SDVD_PLAN, config={**part(settings.values, TRAINER_PREFIX), "seed": seed},
                threads=jobs,
            )  # fmt: skip
            if kept is not None:
                kept.parent.mkdir(parents=True, exist_ok=True)
                cascade.save(str(kept))
        time_s = time.perf_counter() - started_s
        if detector["verify"] == "contour":
            cascade = cascade.with_contours(object_contours(cascade, [labelled.images[index] for index in chosen], settings, jobs))
        tests = [
            (image.listed.path, image.boxes, recordings[index], image.mirrored)
            for index, image in enumerate(labelled.images)
            if fold_of_image[index] == fold
        ]
        tests += [(image.path, (), image.name, False) for image, number in zip(negatives, fold_of_negative, strict=True) if number == fold]
        for path, boxes, recording, mirrored in tests:
            image = read_image(path)
            levels, valid = preparation.picture(image.levels, image.valid)
            found = _core.detect_objects(cascade, levels, valid, {**detector, "side": "mirrored" if mirrored else "as_trained"}, jobs)
            detections = []
            for left, top, width, height, score, neighbours, *_ in found.tolist():
                inner = object_box((int(left), int(top), int(width), int(height)), margin, mirrored=mirrored)
                shown = preparation.object_in_picture(inner, image.width_px, image.height_px)
                if shown is not None:
                    detections.append(Scored(shown, score, int(neighbours)))
            matches.append(match(detections, boxes, IOU, recording))
        records = cascade.provenance()["layers"]
        layers.append(
            {"fold": fold, "layers": len(records), "time_training_s": round(time_s, 1), "stopped": cascade.provenance()["stopped_because"]}
        )
        print(f"fold {fold}: {froc_text(matches)} so far; {json.dumps(layers[-1])}", flush=True)
    made = curve(matches)
    grid = np.array([0.25, 0.5, 1.0, 2.0])
    band = bootstrap_band(matches, grid, 500, seed)
    return {
        "set": "sdvd", "tiles": made.images, "objects": made.objects, "iou": IOU,
        "froc": {str(limit): round(float(made.rate_at(limit)), 4) for limit in grid.tolist()},
        "band_95": None if band is None else {
            str(limit): [round(float(end[k]), 4) for end in band] for k, limit in enumerate(grid.tolist())
        },
        "average_precision": round(made.average_precision(), 4), "folds": layers,
    }  # fmt: skip


def froc_text(matches: list[ImageMatch]) -> str:
    made = curve(matches)
    reached = made.false_per_image[-1] if len(made.false_boxes) else 0.0
    most = made.detection_rate[-1] if len(made.true_boxes) else 0.0
    return f"{float(made.rate_at(1.0)):.3f} at 1 false box a tile ({most:.3f} at {reached:.2f})"


def klsg(folder: Path, jobs: int, folds: list[int], features: int, seed: int) -> dict[str, Any]:
    crops, classes = klsg_crops(folder)
    fold_of_crop = np.array(folds_of([str(index) for index in range(len(crops))], seed))
    scores = np.full(len(crops), np.nan)
    for fold in folds:
        train = np.flatnonzero(fold_of_crop != fold)
        objects, others = with_mirrored(crops[train][classes[train] == 1]), with_mirrored(crops[train][classes[train] == 0])
        started_s = time.perf_counter()
        cascade = _core.train_cascade(
            window_set(objects), negatives=window_set(others), plan=[(1.0, 1e-9, features, 1.0)], threads=jobs,
            config={"feature_set": "basic", "max_asymmetry": 1.0, "max_shift": 0.0, "negatives_per_layer": len(others), "seed": seed},
        )  # fmt: skip
        test = np.flatnonzero(fold_of_crop == fold)
        scores[test] = np.mean([judged(cascade, windows)[1] for windows in mirrored_views(crops[test])], axis=0)
        print(f"fold {fold}: {time.perf_counter() - started_s:.1f} s, {len(cascade.stages[0][1])} features", flush=True)
    used = np.isfinite(scores)
    return {"set": "klsg", "features": features, **classification(scores[used], classes[used])}


def klsg_crops(folder: Path) -> tuple[NDArray[np.uint8], NDArray[np.int64]]:
    """(n, h, w), and 1 for wrecks."""
    crops, classes = [], []
    for name, label in (("ship", 1), ("seafloor", 0)):
        for path in sorted((folder / name).iterdir()):
            image = read_image(path)
            levels = _core.in_8_bits(image.levels, image.valid)
            crops.append(np.asarray(Image.fromarray(levels).resize((KLSG_WINDOW_PX, KLSG_WINDOW_PX), Image.Resampling.BOX)))
            classes.append(label)
    return np.stack(crops), np.array(classes)


def mirrored_views(crops: NDArray[np.uint8]) -> list[NDArray[np.uint8]]:
    """Wrecks lie in any direction: a crop and its mirror images."""
    return [np.ascontiguousarray(view) for view in (crops, crops[:, ::-1], crops[:, :, ::-1], crops[:, ::-1, ::-1])]


def with_mirrored(crops: NDArray[np.uint8]) -> NDArray[np.uint8]:
    return np.concatenate(mirrored_views(crops))


def classification(scores: NDArray[np.float64], classes: NDArray[np.int64]) -> dict[str, Any]:
    """The stage's own threshold 0 of the boosted sum is unknown here: accuracy is taken at the cut that is best for the other folds'
    scores, and the true positive rate at the cut that lets 5 % of the seafloor pass."""
    accuracies = []
    halves = np.arange(len(scores)) % 2
    for half in (0, 1):
        cuts = np.unique(scores[halves != half])
        inside = [np.mean((scores[halves != half] >= cut) == (classes[halves != half] == 1)) for cut in cuts]
        cut = cuts[int(np.argmax(inside))]
        accuracies += ((scores[halves == half] >= cut) == (classes[halves == half] == 1)).tolist()
    at_five_percent = np.quantile(scores[classes == 0], 0.95)
    hits = int((scores[classes == 1] > at_five_percent).sum())
    wrecks = int((classes == 1).sum())
    return {
        "crops": len(scores), "accuracy": round(float(np.mean(accuracies)), 4),
        "accuracy_95": [round(limit, 4) for limit in wilson_band(sum(accuracies), len(accuracies))],
        "tpr_at_5_percent_fpr": round(hits / wrecks, 4), "tpr_95": [round(limit, 4) for limit in wilson_band(hits, wrecks)],
    }  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("set", choices=("sdvd", "klsg"))
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--folds", default=",".join(str(fold) for fold in range(FOLDS)), help="which of the five (default: all)")
    parser.add_argument("--features", type=int, default=60, help="klsg: weak classifiers")
    parser.add_argument(
        "--set", dest="overrides", action="append", default=[], help="sdvd: a setting of the training, or detector.min_neighbours, ..."
    )
    parser.add_argument("--models", type=Path, default=None, help="sdvd: folder of the trained models, which are used again")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    root = os.environ.get("SSJS_DATA")
    if root is None or not (Path(root) / arguments.set).is_dir():
        parser.error(f"the data set {arguments.set} is not there: set SSJS_DATA to the folder that holds it")
    folds = [int(fold) for fold in arguments.folds.split(",")]
    folder = Path(root) / arguments.set
    if arguments.set == "sdvd":
        result = sdvd(folder, arguments.jobs, folds, arguments.overrides, arguments.models, arguments.seed)
    else:
        result = klsg(folder, arguments.jobs, folds, arguments.features, arguments.seed)
    print(json.dumps(result, indent=2))


if __name__ == "__main__":
    main()
