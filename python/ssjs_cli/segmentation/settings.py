"""The settings of a segmentation: the chain and the shadows as the core describes them, and how images are read."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from ssjs_cli import _core
from ssjs_cli.config import (
    FieldDescription,
    Layer,
    Scalar,
    Settings,
    SettingsKind,
    described_by_core,
    field_descriptions,
    layer_from_flag,
    resolve_request,
)
from ssjs_cli.errors import UserError, nearest_hint
from ssjs_cli.segmentation.ground_settings import GROUND_FIELDS, NADIR_KEY, NO_NADIR, ground_layers, ground_violations

CHAIN_PREFIX = "segmentation."
SHADOW_PREFIX = "shadows."
METHOD_KEY = "segmentation.method"
OBJECTS_KEY = "objects.kind"
PAGE_KEY = "image.page"
INVALID_VALUE_KEY = "image.invalid_value"
PADDING_LEVEL_KEY = "image.padding_level"
ALTITUDE_KEY = "objects.altitude_m"
RANGES_KEY = "objects.ranges"

REGION_OBJECTS, SHADOW_OBJECTS = "regions", "shadows"
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
    *GROUND_FIELDS,
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


def _violations(values: Mapping[str, Scalar]) -> list[str]:
    described_by_us = {described.key for described in _IMAGE_FIELDS}
    found: list[str] = _core.validate_segmentation({key: value for key, value in values.items() if key not in described_by_us})
    for key, low, high in ((PAGE_KEY, 1, None), (INVALID_VALUE_KEY, 0, 65535), (PADDING_LEVEL_KEY, 0, 65535)):
        value = values[key]
        if value is not None and (int(value) < low or (high is not None and int(value) > high)):
            found.append(f"{key} = {value}: {field_descriptions(SEGMENTATION)[key].rule}")
    altitude_m = values[ALTITUDE_KEY]
    if altitude_m is not None and not 0.0 < float(altitude_m) < float("inf"):
        found.append(f"{ALTITUDE_KEY} = {altitude_m}: {field_descriptions(SEGMENTATION)[ALTITUDE_KEY].rule}")
    found += ground_violations(values)
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
    flags = [
        layer_from_flag("--method", METHOD_KEY, request.method, SEGMENTATION),
        layer_from_flag("--objects", OBJECTS_KEY, request.objects, SEGMENTATION),
        *ground_layers(request.nadir, request.pixel_size),
    ]
    for flag, key, value in (
        ("--invalid-value", INVALID_VALUE_KEY, request.invalid_value),
        ("--padding", PADDING_LEVEL_KEY, request.padding_level),
        ("--altitude-m", ALTITUDE_KEY, request.altitude_m),
    ):
        if value is not None:
            flags.append(Layer(flag, {key: value}))
    presets = [] if request.preset is None else [preset_layer(request.preset)]
    return resolve_request(SEGMENTATION, request.config_path, request.assignments, request.seed, presets=presets, flags=flags)


def preset_layer(name: str) -> Layer:
    """The settings that a preset is about; all others stay as they are."""
    names = _core.segmentation_preset_names()
    if name not in names:
        raise UserError(f"--preset {name}: must be one of {', '.join(names)}{nearest_hint(name, names)}")
    values = _core.segmentation_preset(name)
    default = _core.segmentation_preset(DEFAULT_PRESET)
    return Layer(f"--preset {name}", {key: value for key, value in values.items() if value != default[key] or key in _PAPER_KEYS})
