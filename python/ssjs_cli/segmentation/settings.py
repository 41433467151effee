"""The settings of a segmentation: the chain and the shadows as the core describes them, and how images are read."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from ssjs_cli import _core
from ssjs_cli.config import (
    DEFAULT_SEED,
    FieldDescription,
    Layer,
    Scalar,
    Settings,
    SettingsKind,
    checked_seed,
    described_by_core,
    field_descriptions,
    layer_from_assignments,
    layer_from_file,
    layer_from_flag,
    resolve,
)
from ssjs_cli.errors import UserError, nearest_hint

CHAIN_PREFIX = "segmentation."
SHADOW_PREFIX = "shadows."
METHOD_KEY = "segmentation.method"
OBJECTS_KEY = "objects.kind"
PAGE_KEY = "image.page"
INVALID_VALUE_KEY = "image.invalid_value"
PADDING_LEVEL_KEY = "image.padding_level"
PIXEL_ALONG_KEY = "image.pixel_along_m"
PIXEL_ACROSS_KEY = "image.pixel_across_m"
NADIR_KEY = "image.nadir"
NADIR_COLUMN_KEY = "image.nadir_column"
ALTITUDE_KEY = "objects.altitude_m"
RANGES_KEY = "objects.ranges"

REGION_OBJECTS, SHADOW_OBJECTS = "regions", "shadows"
NO_NADIR, LEFT, MIDDLE, RIGHT, COLUMN = "none", "left", "middle", "right", "column"
DEFAULT_PRESET = "auto"
#: What the presets of the paper are about: an explicit preset sets these in any case.
_PAPER_KEYS = (
    "segmentation.improved_otsu.spot_px",
    "segmentation.improved_otsu.spot_limit",
    "segmentation.improved_otsu.canny_high",
    "segmentation.dilations",
)

_IMAGE_FIELDS = (
    FieldDescription(PAGE_KEY, "int", 1, (), "must be at least 1", "page of a file that holds several pictures"),
    FieldDescription(INVALID_VALUE_KEY, "optional_int", None, (), "must lie in [0, 65535]", "pixels of exactly this level are invalid"),
    FieldDescription(
        PADDING_LEVEL_KEY, "optional_int", None, (), "must lie in [0, 65535]",
        "pixels of at most this level that are joined to the border of the picture are padding, and invalid",
    ),
    FieldDescription(PIXEL_ALONG_KEY, "optional_float", None, (), "must be positive", "height of a pixel on the seabed, along the track"),
    FieldDescription(PIXEL_ACROSS_KEY, "optional_float", None, (), "must be positive", "width of a pixel on the seabed, across the track"),
    FieldDescription(NADIR_KEY, "choice", NO_NADIR, (NO_NADIR, LEFT, MIDDLE, RIGHT, COLUMN), "", "where the sonar passed"),
    FieldDescription(
        NADIR_COLUMN_KEY, "optional_int", None, (), "must not be negative",
        "first column to starboard of the sonar's path, where nadir is 'column'",
    ),
    FieldDescription(
        OBJECTS_KEY, "choice", REGION_OBJECTS, (REGION_OBJECTS, SHADOW_OBJECTS), "",
        "regions near each other, or highlights with a shadow behind them",
    ),
    FieldDescription(ALTITUDE_KEY, "optional_float", None, (), "must be positive", "of the sonar above the seabed, for heights by shadows"),
    FieldDescription(
        RANGES_KEY, "choice", "slant_top", ("ground", "slant_top", "slant_foot"), "",
        "columns count range on the seabed, or slant range, an object's top or foot echoing last before its shadow",
    ),
)  # fmt: skip


def _fields() -> Iterator[FieldDescription]:
    yield from described_by_core(_core.segmentation_fields())
    yield from _IMAGE_FIELDS


def part(values: Mapping[str, Scalar], prefix: str) -> dict[str, Scalar]:
    """The settings of one table, without its name."""
    return {key.removeprefix(prefix): value for key, value in values.items() if key.startswith(prefix)}


def _violations(values: Mapping[str, Scalar]) -> list[str]:
    described_by_us = {described.key for described in _IMAGE_FIELDS}
    found: list[str] = _core.validate_segmentation({key: value for key, value in values.items() if key not in described_by_us})
    for key, low, high in ((PAGE_KEY, 1, None), (INVALID_VALUE_KEY, 0, 65535), (PADDING_LEVEL_KEY, 0, 65535), (NADIR_COLUMN_KEY, 0, None)):
        value = values[key]
        if value is not None and (int(value) < low or (high is not None and int(value) > high)):
            found.append(f"{key} = {value}: {field_descriptions(SEGMENTATION)[key].rule}")
    for key in (PIXEL_ALONG_KEY, PIXEL_ACROSS_KEY, ALTITUDE_KEY):
        value = values[key]
        if value is not None and not 0.0 < float(value) < float("inf"):
            found.append(f"{key} = {value}: {field_descriptions(SEGMENTATION)[key].rule}")
    if (values[PIXEL_ALONG_KEY] is None) != (values[PIXEL_ACROSS_KEY] is None):
        found.append(f"{PIXEL_ALONG_KEY} and {PIXEL_ACROSS_KEY}: are given together or not at all")
    if (values[NADIR_KEY] == COLUMN) != (values[NADIR_COLUMN_KEY] is not None):
        found.append(f"{NADIR_COLUMN_KEY}: is given exactly where {NADIR_KEY} is '{COLUMN}'")
    if values[OBJECTS_KEY] == SHADOW_OBJECTS and values[NADIR_KEY] == NO_NADIR:
        found.append(f"{NADIR_KEY}: objects from shadows need it; give --nadir left, middle, right or a column")
    return found


SEGMENTATION = SettingsKind("Segmentation", "segmentation.gain.kind=local_mean", _fields, _violations)


@dataclass(frozen=True)
class SettingsRequest:
    """What the command line said about settings; None: nothing."""

    method: str | None = None
    preset: str | None = None
    objects: str | None = None
    nadir: str | None = None
    pixel_size: str | None = None
    invalid_value: int | None = None
    padding_level: int | None = None
    altitude_m: float | None = None
    config_path: Path | None = None
    assignments: Sequence[str] = ()
    seed: int | None = None


def resolve_segmentation(request: SettingsRequest) -> tuple[Settings, int]:
    """defaults < --config < --preset < --set < the other flags; the seed: default < file < --seed."""
    layers: list[Layer] = []
    file_seed = None
    if request.config_path is not None:
        layer, file_seed = layer_from_file(request.config_path, SEGMENTATION)
        layers.append(layer)
    if request.preset is not None:
        layers.append(preset_layer(request.preset))
    layers.append(layer_from_assignments(request.assignments, SEGMENTATION))
    layers.append(layer_from_flag("--method", METHOD_KEY, request.method, SEGMENTATION))
    layers.append(layer_from_flag("--objects", OBJECTS_KEY, request.objects, SEGMENTATION))
    layers.append(_nadir_layer(request.nadir))
    layers.append(_pixel_size_layer(request.pixel_size))
    for flag, key, value in (
        ("--invalid-value", INVALID_VALUE_KEY, request.invalid_value),
        ("--padding", PADDING_LEVEL_KEY, request.padding_level),
        ("--altitude-m", ALTITUDE_KEY, request.altitude_m),
    ):
        if value is not None:
            layers.append(Layer(flag, {key: value}))
    seed = request.seed if request.seed is not None else file_seed
    return resolve(layers, SEGMENTATION), DEFAULT_SEED if seed is None else checked_seed(seed, "--seed")


def preset_layer(name: str) -> Layer:
    """The settings that a preset is about; all others stay as they are."""
    names = _core.segmentation_preset_names()
    if name not in names:
        raise UserError(f"--preset {name}: must be one of {', '.join(names)}{nearest_hint(name, names)}")
    values = _core.segmentation_preset(name)
    default = _core.segmentation_preset(DEFAULT_PRESET)
    return Layer(f"--preset {name}", {key: value for key, value in values.items() if value != default[key] or key in _PAPER_KEYS})


def _nadir_layer(text: str | None) -> Layer:
    if text is None:
        return Layer("--nadir", {})
    if text in (NO_NADIR, LEFT, MIDDLE, RIGHT):
        return Layer("--nadir", {NADIR_KEY: text, NADIR_COLUMN_KEY: None})
    try:
        return Layer("--nadir", {NADIR_KEY: COLUMN, NADIR_COLUMN_KEY: int(text)})
    except ValueError as error:
        raise UserError(f"--nadir {text}: must be left, middle, right, none or a column, counted from 0") from error


def _pixel_size_layer(text: str | None) -> Layer:
    if text is None:
        return Layer("--pixel-size-m", {})
    try:
        along_m, across_m = (float(number) for number in text.split(","))
    except ValueError as error:
        raise UserError(f"--pixel-size-m {text}: must be two numbers ALONG,ACROSS, for example 0.05,0.02") from error
    return Layer("--pixel-size-m", {PIXEL_ALONG_KEY: along_m, PIXEL_ACROSS_KEY: across_m})
