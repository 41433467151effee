"""The command `cascade evaluate`: what a model finds in labelled images, layer by layer and threshold by threshold."""

import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssjs_cli import _core
from ssjs_cli.cascade.detect import detections_in
from ssjs_cli.cascade.labelled_images import LabelledImages, LabelSource, read_labelled_images, recording_names
from ssjs_cli.cascade.model_file import Model, load_model
from ssjs_cli.cascade.one_image import further_columns
from ssjs_cli.cascade.scoring import Curve, ImageMatch, Scored, bootstrap_band, curve, match, wilson_band
from ssjs_cli.cascade.settings import BOOTSTRAP_KEY, EVALUATION, IOU_KEY, WINDOWS_KEY, SettingsRequest, resolve_cascade
from ssjs_cli.cascade.sides import views_of
from ssjs_cli.cascade.window_boxes import window_box
from ssjs_cli.cascade.windows import background_windows, judged, no_windows, stages_of, window_of
from ssjs_cli.config import Settings
from ssjs_cli.errors import UserError
from ssjs_cli.finished import Finished
from ssjs_cli.formats.atomic import holds_only, new_directory
from ssjs_cli.segmentation.image_list import title_of
from ssjs_cli.session import Session
from ssjs_cli.studies.study_folder import key_of
from ssjs_cli.studies.tables import csv_text, json_text

KIND = "cascade evaluation directory"
SUMMARY_FILE = "evaluation.json"
LAYERS_FILE = "layers.csv"
FROC_FILE = "froc.csv"
TABLE_FILE = "detections.csv"
CONFIG_FILE = "config.toml"
PAGE_FILE = "report.html"
FILES = (SUMMARY_FILE, LAYERS_FILE, FROC_FILE, TABLE_FILE, CONFIG_FILE, PAGE_FILE)
why_not_an_evaluation = holds_only(FILES, (SUMMARY_FILE,))
DETECTION_COLUMNS = ("image", "x_px", "y_px", "width_px", "height_px", "score", "outcome")
FROC_COLUMNS = ("threshold", "false_boxes_per_image", "detection_rate", "precision")
LAYER_COLUMNS = (
    *("layer", "features", "detection_rate", "detection_rate_low", "detection_rate_high"),
    *("false_positive_rate", "false_positive_rate_low", "false_positive_rate_high", "windows"),
)
FOUND, FALSE = "found", "false"
#: Where the curve is looked at for its band: false boxes an image.
GRID_POINTS = 60
RATE_DECIMALS = 6


@dataclass(frozen=True)
class EvaluationRequest:
    model: Path
    images: Sequence[str]
    labels: LabelSource
    recordings: str | None = None
    settings: SettingsRequest = field(default_factory=SettingsRequest)
    jobs: int | None = None
    with_report: bool = True
    out: Path | None = None
    force: bool = False


@dataclass(frozen=True)
class Evaluated:
    """All that the result files tell. band: false boxes an image, and the detection rate's limits there."""

    title: str
    model: Model
    labelled: LabelledImages
    matches: list[ImageMatch]
    curve: Curve
    band: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]] | None
    layers: list[dict[str, Any]]
    settings: Settings
    failures: list[tuple[str, str]]


def evaluate(request: EvaluationRequest, session: Session) -> Finished:
    settings, seed = resolve_cascade(request.settings, EVALUATION)
    model = load_model(request.model)
    labelled = read_labelled_images(request.images, request.labels, settings)
    if labelled.objects == 0:
        raise UserError(f"{request.labels.masks or request.labels.annotations}: holds no object of these images; check the paths")
    listed = [image.listed for image in labelled.images]
    recordings = recording_names(listed, request.recordings)
    title = title_of(request.images)
    out = request.out or Path("runs") / f"{title}-cascade-evaluation"
    session.fault_log = out.with_name(out.name + ".fault.jsonl")
    with new_directory(out, force=request.force, why_not_ours=why_not_an_evaluation, kind=KIND) as partial:
        results = detections_in(
            listed, model, settings, request.jobs, None, session, {image.listed.name for image in labelled.images if image.mirrored}
        )
        failures = [*labelled.problems, *results.failures]
        matches, rows, kept = [], [], []
        for image, recording in zip(labelled.images, recordings, strict=True):
            record = results.records.get(image.listed.name)
            if record is None:
                continue
            row_of = {
                Scored((row["x_px"], row["y_px"], row["width_px"], row["height_px"]), row["score"], row["neighbours"]): row
                for row in record["detections"]
            }
            matched = match(list(row_of), image.boxes, float(settings.values[IOU_KEY] or 0.0), recording)
            matches.append(matched)
            kept.append(image)
            rows += [
                {**row_of[detection], "outcome": FALSE if found is None else FOUND}
                for detection, found in zip(matched.detections, matched.found, strict=True)
            ]
        labelled = LabelledImages(kept, labelled.problems, labelled.unlabelled)
        made = curve(matches)
        evaluated = Evaluated(
            title,
            model,
            labelled,
            matches,
            made,
            _band(matches, made, int(settings.values[BOOTSTRAP_KEY] or 0), seed),
            layer_table(model, labelled, settings, int(settings.values[WINDOWS_KEY] or 0), seed, request.jobs or os.cpu_count() or 1),
            settings,
            failures,
        )
        document = _summary(evaluated, seed)
        (partial / TABLE_FILE).write_text(csv_text((*DETECTION_COLUMNS, *further_columns(settings.values)), rows), encoding="utf-8")
        (partial / SUMMARY_FILE).write_text(json_text(document), encoding="utf-8")
        (partial / LAYERS_FILE).write_text(csv_text(LAYER_COLUMNS, evaluated.layers), encoding="utf-8")
        (partial / FROC_FILE).write_text(csv_text(FROC_COLUMNS, _froc_rows(made)), encoding="utf-8")
        (partial / CONFIG_FILE).write_text(settings.to_toml(seed), encoding="utf-8")
        if request.with_report:
            from ssjs_cli.report.cascade_evaluation_page import evaluation_page

            (partial / PAGE_FILE).write_text(evaluation_page(evaluated, document), encoding="utf-8")
    return Finished(out, document, failures)


def layer_table(model: Model, labelled: LabelledImages, settings: Settings, wanted: int, seed: int, threads: int) -> list[dict[str, Any]]:
    """Rates of the cascade up to each layer: on the windows of the objects, and on windows at random places that touch no object."""
    cascade = model.cascade
    size = cascade.window
    windows = []
    views = views_of(labelled.images, settings.values)
    for view in views:
        boxes = view.objects(model.preparation)
        if not boxes:
            continue
        levels, _ = view.read(model.preparation)
        for box in boxes:
            grown = window_box(box, model.margin, size, levels.shape[::-1])
            window = None if grown is None else window_of(levels, grown, *size)
            if window is not None:
                windows.append(window)

    def without_objects(index: int) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
        return views[index].ground(model.preparation)

    background = background_windows(len(views), without_objects, wanted, *size, seed, "windows of the layer table", threads)
    objects = np.stack(windows) if windows else no_windows(*size)
    of_objects, _ = judged(cascade, objects)
    of_background, _ = judged(cascade, background)
    rows = []
    for layer, stage in enumerate(stages_of(cascade), 1):
        detected, passed = int((of_objects >= layer).sum()), int((of_background >= layer).sum())
        low, high = wilson_band(detected, len(of_objects))
        false_low, false_high = wilson_band(passed, len(of_background))
        rows.append(
            {
                "layer": layer,
                "features": len(stage.weak),
                "detection_rate": _rounded(detected / max(len(of_objects), 1)),
                "detection_rate_low": _rounded(low),
                "detection_rate_high": _rounded(high),
                "false_positive_rate": _rounded(passed / max(len(of_background), 1)),
                "false_positive_rate_low": _rounded(false_low),
                "false_positive_rate_high": _rounded(false_high),
                "windows": len(of_background),
            }
        )
    return rows


def _band(
    matches: Sequence[ImageMatch], made: Curve, samples: int, seed: int
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]] | None:
    if not len(made.false_boxes):
        return None
    most = max(float(made.false_per_image[-1]), 1.0 / max(made.images, 1))
    grid = np.concatenate([[0.0], np.geomspace(min(1.0 / max(made.images, 1), most), most, GRID_POINTS)])
    limits = bootstrap_band(matches, grid, samples, seed)
    return None if limits is None else (grid, *limits)


def _froc_rows(made: Curve) -> list[dict[str, Any]]:
    return [
        {
            "threshold": float(made.thresholds[index]),
            "false_boxes_per_image": _rounded(made.false_per_image[index]),
            "detection_rate": _rounded(made.detection_rate[index]),
            "precision": _rounded(made.precision[index]),
        }
        for index in range(len(made.thresholds))
    ]


def _summary(evaluated: Evaluated, seed: int) -> dict[str, Any]:
    made = evaluated.curve
    found = int(made.true_boxes[-1]) if len(made.true_boxes) else 0
    false_boxes = int(made.false_boxes[-1]) if len(made.false_boxes) else 0
    low, high = wilson_band(found, made.objects)
    return {
        "version": _core.version(),
        "model": evaluated.model.path.name,
        "model_sha256": evaluated.model.digest,
        "seed": seed,
        "configuration_digest": key_of(dict(evaluated.settings.values)),
        "totals": {
            "images": made.images,
            "failed": len(evaluated.failures),
            "unlabelled_images": evaluated.labelled.unlabelled,
            "objects": made.objects,
            "found": found,
            "false_boxes": false_boxes,
        },
        "rates": {
            "detection_rate": _rounded(found / max(made.objects, 1)),
            "detection_rate_band": [_rounded(low), _rounded(high)],
            "false_boxes_per_image": _rounded(false_boxes / max(made.images, 1)),
            "detection_rate_at_one_false_box": _rounded(float(made.rate_at(1.0))),
            "average_precision": _rounded(made.average_precision()),
        },
        "layers": evaluated.layers,
        "failed": [{"image": name, "reason": reason} for name, reason in evaluated.failures],
    }


def _rounded(value: float) -> float:
    return round(float(value), RATE_DECIMALS)
