"""The settings of training, detection and evaluation: the core's, and how samples are made and boxes are scored."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from ssjs_cli import _core
from ssjs_cli.cascade.preparation import BORDER_KEY, SMOOTHING_KEY
from ssjs_cli.cascade.size_limits import DETECTOR_PREFIX, SIZE_FIELDS, size_violations
from ssjs_cli.config import (
    FieldDescription,
    Scalar,
    Settings,
    SettingsKind,
    described_by_core,
    layer_from_flag,
    part,
    resolve_request,
)
from ssjs_cli.segmentation.ground_settings import GROUND_FIELDS, ground_layers, ground_violations

TRAINER_PREFIX = "training."
AUGMENTATION_PREFIX = "augmentation."
WINDOW_WIDTH_KEY = "window.width_px"
WINDOW_HEIGHT_KEY = "window.height_px"
MARGIN_KEY = "window.margin"
COPIES_KEY = "augmentation.copies"
BACKGROUND_KEY = "samples.use_background"
MASK_GAP_KEY = "samples.mask_gap_px"
MIN_OBJECT_KEY = "samples.min_object_px"
VALIDATION_FRACTION_KEY = "validation.fraction"
VALIDATION_WINDOWS_KEY = "validation.windows"
IOU_KEY = "evaluation.iou"
CONTOUR_KEY = "contour.learn"
VERIFY_KEY = "detector.verify"
BOOTSTRAP_KEY = "evaluation.bootstrap"
WINDOWS_KEY = "evaluation.windows"

_MASK_FIELDS = (
    FieldDescription(
        MASK_GAP_KEY, "float", 2.0, (), "must lie in [0, 1000]", "parts of a mask at most so many pixels apart are one object"
    ),
    FieldDescription(MIN_OBJECT_KEY, "int", 4, (), "must be at least 1", "objects narrower or lower than this are left out"),
)  # fmt: skip
_SAMPLE_FIELDS = (
    FieldDescription(
        SMOOTHING_KEY, "int", 1, (), "must be odd and lie in [1, 31]",
        "pictures are averaged over squares of so many pixels first, in training and detection; 1: as they are, and as OpenCV takes them",
    ),
    FieldDescription(
        BORDER_KEY, "int", 0, (), "must lie in [0, 1000]",
        "pictures are mirrored beyond their borders by so many pixels, in training and detection, so that objects cut by them are found",
    ),
    FieldDescription(WINDOW_WIDTH_KEY, "int", 24, (), "must lie in [3, 256]", "of the windows trained on: the smallest object found"),
    FieldDescription(WINDOW_HEIGHT_KEY, "int", 24, (), "must lie in [3, 256]", "of the windows trained on"),
    FieldDescription(
        MARGIN_KEY, "float", 0.1, (), "must lie in [0, 2]",
        "part of an object's box added on each side, so that the window holds some of the ground around it",
    ),
    FieldDescription(
        BACKGROUND_KEY, "bool", True, (), "",
        "mine false alarms in the pictures with objects, too, around their boxes; not where objects are unlabelled",
    ),
    *_MASK_FIELDS,
    FieldDescription(
        VALIDATION_FRACTION_KEY, "float", 0.2, (), "must lie in [0, 0.9]", "part of the objects, by whole recordings, held back to validate"
    ),
    FieldDescription(VALIDATION_WINDOWS_KEY, "int", 20000, (), "must lie in [100, 10000000]", "windows without object held back"),
    FieldDescription(
        CONTOUR_KEY, "bool", True, (), "", "keep in the model what the contours of the echoes look like, to verify detections with"
    ),
)  # fmt: skip
_EVALUATION_FIELDS = (
    FieldDescription(IOU_KEY, "float", 0.3, (), "must lie in [0.01, 1]", "intersection over union from which a box has found an object"),
    FieldDescription(BOOTSTRAP_KEY, "int", 500, (), "must lie in [0, 100000]", "samples for the confidence bands, drawn by recording"),
    FieldDescription(WINDOWS_KEY, "int", 20000, (), "must lie in [100, 10000000]", "windows without object in the table of layers"),
    *_MASK_FIELDS,
)
_BOUNDS: Mapping[str, tuple[float, float]] = {
    SMOOTHING_KEY: (1, 31),
    BORDER_KEY: (0, 1000),
    MASK_GAP_KEY: (0, 1000),
    MIN_OBJECT_KEY: (1, float("inf")),
    WINDOW_WIDTH_KEY: (3, 256),
    WINDOW_HEIGHT_KEY: (3, 256),
    MARGIN_KEY: (0, 2),
    VALIDATION_FRACTION_KEY: (0, 0.9),
    VALIDATION_WINDOWS_KEY: (100, 10_000_000),
    IOU_KEY: (0.01, 1),
    BOOTSTRAP_KEY: (0, 100_000),
    WINDOWS_KEY: (100, 10_000_000),
}


def _core_fields(prefix: str, entries: Sequence[Mapping[str, object]], leave_out: Sequence[str] = ()) -> Iterator[FieldDescription]:
    renamed = [{**entry, "key": f"{prefix}{entry['key']}"} for entry in entries if entry["key"] not in leave_out]
    yield from described_by_core(renamed)


def _training_fields() -> Iterator[FieldDescription]:
    yield from _SAMPLE_FIELDS
    yield from _core_fields(AUGMENTATION_PREFIX, _core.augmentation_fields())
    yield from _core_fields(TRAINER_PREFIX, _core.cascade_trainer_fields(), ("seed",))


def _detection_fields() -> Iterator[FieldDescription]:
    yield from GROUND_FIELDS
    yield from _core_fields(DETECTOR_PREFIX, _core.cascade_detector_fields())
    yield from SIZE_FIELDS


def _evaluation_fields() -> Iterator[FieldDescription]:
    yield from _EVALUATION_FIELDS
    yield from _detection_fields()


def _own_violations(values: Mapping[str, Scalar], fields: Sequence[FieldDescription]) -> list[str]:
    found = []
    for described in fields:
        low, high = _BOUNDS.get(described.key, (float("-inf"), float("inf")))
        value = values[described.key]
        if described.type != "bool" and not low <= float(value or 0) <= high:
            found.append(f"{described.key} = {value}: {described.rule}")
    return found


def _training_violations(values: Mapping[str, Scalar]) -> list[str]:
    found = _own_violations(values, _SAMPLE_FIELDS)
    if int(values[SMOOTHING_KEY] or 0) % 2 == 0:
        found.append(f"{SMOOTHING_KEY} = {values[SMOOTHING_KEY]}: must be odd and lie in [1, 31]")
    found += [AUGMENTATION_PREFIX + text for text in _core.validate_augmentation(part(values, AUGMENTATION_PREFIX))]
    return found + [TRAINER_PREFIX + text for text in _core.validate_cascade_trainer(part(values, TRAINER_PREFIX))]


def _detection_violations(values: Mapping[str, Scalar]) -> list[str]:
    in_metres = {described.key for described in SIZE_FIELDS}
    own = {key: value for key, value in values.items() if key not in in_metres}
    found = [DETECTOR_PREFIX + text for text in _core.validate_cascade_detector(part(own, DETECTOR_PREFIX))]
    found += ground_violations(values) + size_violations(values)
    for side in ("width", "height"):
        least, most = values[f"{DETECTOR_PREFIX}min_{side}_px"], values[f"{DETECTOR_PREFIX}max_{side}_px"]
        if least is not None and most is not None and float(least) > float(most):
            found.append(f"{DETECTOR_PREFIX}min_{side}_px = {least}: must not be greater than max_{side}_px = {most}")
    return found


def _evaluation_violations(values: Mapping[str, Scalar]) -> list[str]:
    return _own_violations(values, _EVALUATION_FIELDS) + _detection_violations(values)


TRAINING = SettingsKind("Cascade training", "training.feature_set=side_scan", _training_fields, _training_violations)
DETECTION = SettingsKind("Cascade detection", "detector.min_neighbours=5", _detection_fields, _detection_violations)
EVALUATION = SettingsKind("Cascade evaluation", "evaluation.iou=0.5", _evaluation_fields, _evaluation_violations)


@dataclass(frozen=True)
class SettingsRequest:
    """What the command line said about settings; None: nothing."""

    config_path: Path | None = None
    assignments: Sequence[str] = ()
    seed: int | None = None
    nadir: str | None = None
    pixel_size: str | None = None
    verify: str | None = None


def resolve_cascade(request: SettingsRequest, kind: SettingsKind) -> tuple[Settings, int]:
    """defaults < --config < --set < the other flags; the seed: default < file < --seed."""
    flags = [*ground_layers(request.nadir, request.pixel_size), layer_from_flag("--verify", VERIFY_KEY, request.verify, kind)]
    return resolve_request(kind, request.config_path, request.assignments, request.seed, flags=flags)
