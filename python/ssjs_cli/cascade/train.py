"""The command `cascade train`: labelled images in, a model with its report out. The same bytes at any number of threads."""

import os
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssjs_cli import _core
from ssjs_cli.cascade.contours import LEAST_OBJECTS, object_contours
from ssjs_cli.cascade.labelled_images import LabelledImages, LabelSource, mirrored_names, read_labelled_images, recording_names
from ssjs_cli.cascade.model_file import MEAN_FILE, MODEL_FILE, XML_FILE
from ssjs_cli.cascade.plan_file import Plan, plan_text, read_plan
from ssjs_cli.cascade.samples import TrainingSamples, make_samples
from ssjs_cli.cascade.settings import CONTOUR_KEY, TRAINER_PREFIX, TRAINING, SettingsRequest, resolve_cascade
from ssjs_cli.cascade.windows import core_seed, window_set
from ssjs_cli.config import Settings, part
from ssjs_cli.errors import InterruptionError, UserError
from ssjs_cli.finished import Finished
from ssjs_cli.formats.atomic import check_replaceable, holds_only, new_directory
from ssjs_cli.formats.image_file import write_png
from ssjs_cli.progress import interruptible, working
from ssjs_cli.segmentation.image_list import listed_images, title_of
from ssjs_cli.session import Session
from ssjs_cli.studies.study_folder import key_of
from ssjs_cli.studies.tables import csv_text, json_text

KIND = "cascade directory"
SUMMARY_FILE = "training.json"
LAYERS_FILE = "layers.csv"
PLAN_FILE = "plan.toml"
CONFIG_FILE = "config.toml"
TIMING_FILE = "timing.json"
PAGE_FILE = "report.html"
FILES = (MODEL_FILE, XML_FILE, MEAN_FILE, SUMMARY_FILE, LAYERS_FILE, PLAN_FILE, CONFIG_FILE, TIMING_FILE, PAGE_FILE)
why_not_a_cascade = holds_only(FILES, (SUMMARY_FILE,))
LAYER_KEYS = (
    *("layer", "features", "detection_rate", "false_positive_rate", "target_detection_rate", "target_false_positive_rate"),
    *("negatives", "negatives_looked_at"),
)


@dataclass(frozen=True)
class TrainingRequest:
    positives: Sequence[str]
    labels: LabelSource
    negatives: Sequence[str]
    plan: Path | None = None
    recordings: str | None = None
    settings: SettingsRequest = field(default_factory=SettingsRequest)
    threads: int | None = None
    resume: bool = False
    with_report: bool = True
    out: Path | None = None
    force: bool = False


@dataclass(frozen=True)
class Trained:
    """All that the result files tell. examples: windows that the first layers were trained on, for the pictures of features."""

    title: str
    seed: int
    cascade: _core.HaarCascade
    labelled: LabelledImages
    samples: TrainingSamples
    settings: Settings
    plan: Plan
    failures: list[tuple[str, str]]
    time_samples_s: float
    time_training_s: float

    @property
    def mean_positive(self) -> NDArray[np.uint8]:
        mean: NDArray[np.uint8] = np.rint(self.samples.positives.mean(axis=0)).astype(np.uint8)
        return mean


def train(request: TrainingRequest, session: Session) -> Finished:
    settings, seed = resolve_cascade(request.settings, TRAINING)
    plan = _core.thesis_plan() if request.plan is None else read_plan(request.plan)
    title = title_of(request.positives)
    out = request.out or Path("runs") / f"{title}-cascade"
    session.fault_log = out.with_name(out.name + ".fault.jsonl")
    check_replaceable(out, force=request.force, why_not_ours=why_not_a_cascade, kind=KIND)
    checkpoint = out.with_name(out.name + ".checkpoint.json")
    if checkpoint.exists() and not request.resume and not request.force:
        raise UserError(f"{checkpoint}: a training was left here; carry it on with --resume, or start anew with --force")
    out.parent.mkdir(parents=True, exist_ok=True)
    threads = request.threads or os.cpu_count() or 1
    started_s = time.perf_counter()
    with working("reading images"):
        labelled = read_labelled_images(request.positives, request.labels, settings)
        if labelled.objects == 0:
            raise UserError(
                f"{request.labels.masks or request.labels.annotations}: holds no object of these images; label some, or check the paths"
            )
        negatives = listed_images(request.negatives) if request.negatives else []
        samples = make_samples(
            labelled,
            recording_names([image.listed for image in labelled.images], request.recordings),
            negatives,
            recording_names(negatives, request.recordings),
            settings,
            seed,
            threads,
            mirrored_names(negatives, request.labels.mirrored),
        )
    if len(samples.negatives) == 0:
        raise UserError("no picture is left to take windows without object from; give more --negatives, or a lower validation.fraction")
    read_s = time.perf_counter()
    cascade = _trained(samples, plan, settings, seed, threads, checkpoint, request.resume)
    with working("looking at contours"):
        contours = object_contours(cascade, labelled.images, settings, threads) if settings.values[CONTOUR_KEY] else []
    if len(contours) >= LEAST_OBJECTS:
        cascade = cascade.with_contours(contours)
    trained_s = time.perf_counter()
    pictures = [*samples.negatives.problems.items(), *samples.validation_pictures.problems.items()]
    failures = [*labelled.problems, *pictures]
    trained = Trained(
        title,
        seed,
        cascade,
        labelled,
        samples,
        settings,
        plan,
        failures,
        time_samples_s=read_s - started_s,
        time_training_s=trained_s - read_s,
    )
    with new_directory(out, force=request.force, why_not_ours=why_not_a_cascade, kind=KIND) as partial:
        document = write_training(partial, trained, with_report=request.with_report)
    checkpoint.unlink(missing_ok=True)
    return Finished(out, document, failures)


def _trained(
    samples: TrainingSamples, plan: Plan, settings: Settings, seed: int, threads: int, checkpoint: Path, resume: bool
) -> _core.HaarCascade:
    with interruptible("training") as watch:

        def report(layer: int, layers: int, doing: str, features: int, max_features: int, fraction: float) -> bool:
            watch.describe(f"layer {layer} of {layers}, {doing}, {features} of {max_features} features")
            return watch(fraction)

        try:
            cascade = _core.train_cascade(
                window_set(samples.positives, samples.recordings),
                window_set(samples.validation_positives),
                validation_negatives=window_set(samples.validation_negatives),
                images=len(samples.negatives),
                read=samples.negatives.read,
                images_digest=samples.negatives.digest(),
                plan=plan,
                config={**part(settings.values, TRAINER_PREFIX), "seed": core_seed(seed)},
                threads=threads,
                checkpoint=str(checkpoint),
                resume=resume and checkpoint.exists(),
                progress=report,
            )
        except KeyboardInterrupt as error:
            left = f"; the layers so far are in {checkpoint}: carry on with --resume" if checkpoint.exists() else ""
            raise InterruptionError(f"interrupted{left}") from error
        except ValueError as error:
            raise UserError(f"training: {error}") from error
        except OSError as error:
            raise UserError(str(error)) from error
    own = {key: value for key, value in settings.values.items() if not key.startswith(TRAINER_PREFIX)}
    return cascade.with_settings([(key, "none" if value is None else str(value)) for key, value in own.items()])


def write_training(directory: Path, trained: Trained, *, with_report: bool) -> dict[str, Any]:
    """Gives the document of training.json."""
    document = _summary(trained)
    (directory / MODEL_FILE).write_text(trained.cascade.to_json(), encoding="utf-8")
    (directory / XML_FILE).write_text(trained.cascade.to_opencv_xml(), encoding="utf-8")
    write_png(directory / MEAN_FILE, trained.mean_positive)
    (directory / SUMMARY_FILE).write_text(json_text(document), encoding="utf-8")
    (directory / LAYERS_FILE).write_text(csv_text(LAYER_KEYS, document["layers"]), encoding="utf-8")
    (directory / PLAN_FILE).write_text(plan_text(trained.plan), encoding="utf-8")
    (directory / CONFIG_FILE).write_text(trained.settings.to_toml(trained.seed), encoding="utf-8")
    timing = {"time_samples_s": round(trained.time_samples_s, 6), "time_training_s": round(trained.time_training_s, 6)}
    (directory / TIMING_FILE).write_text(json_text(timing), encoding="utf-8")
    if with_report:
        from ssjs_cli.report.cascade_training_page import training_page

        (directory / PAGE_FILE).write_text(training_page(trained, document), encoding="utf-8")
    return document


def _summary(trained: Trained) -> dict[str, Any]:
    provenance = trained.cascade.provenance()
    samples, labelled = trained.samples, trained.labelled
    return {
        "version": _core.version(),
        "seed": trained.seed,
        "configuration_digest": key_of({**trained.settings.values, "plan": trained.plan}),
        "window_px": list(trained.cascade.window),
        "stopped_because": provenance["stopped_because"],
        "totals": {
            "images": len(labelled.images),
            "objects": labelled.objects,
            "unlabelled_images": labelled.unlabelled,
            "objects_left_out": len(samples.left_out),
            "positives": len(samples.positives),
            "objects_trained_on": samples.objects,
            "objects_held_back": len(samples.validation_positives),
            "negative_pictures": len(samples.negatives),
            "negative_pictures_held_back": len(samples.validation_pictures),
            "windows_held_back": len(samples.validation_negatives),
            "contours": trained.cascade.contours_known,
            "failed": len(trained.failures),
            "layers": len(provenance["layers"]),
            "features": sum(layer["features"] for layer in provenance["layers"]),
        },
        "layers": [{"layer": position, **layer} for position, layer in enumerate(provenance["layers"], 1)],
        "left_out": [{"object": name, "reason": reason} for name, reason in samples.left_out],
        "failed": [{"image": name, "reason": reason} for name, reason in trained.failures],
    }
