"""Settings: pydantic models made from the fields that the estimator describes, and the layers a run resolves them from.

Keys are flat and dotted inside the program ("vehicle.ackerman.wheelbase_m") and nested tables in TOML files. An optional
setting that is off is written "none".
"""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal

import tomli_w
from pydantic import BaseModel, ConfigDict, Field, ValidationError, create_model

from ssjs_cli import _core
from ssjs_cli.errors import UserError, nearest_hint
from ssjs_cli.formats.toml_file import load_toml

Scalar = float | int | bool | str | None

METHOD_KEY = "method"
ASSOCIATION_KEY = "association.method"
VEHICLE_KEY = "vehicle.kind"
SEED_KEY = "seed"
DEFAULT_SEED = 1
MAX_SEED = 2**64 - 1
OFF = "none"


class StrictModel(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, protected_namespaces=())


@dataclass(frozen=True)
class FieldDescription:
    key: str
    type: str
    default: Scalar
    choices: tuple[str, ...]
    rule: str
    description: str

    @property
    def is_optional(self) -> bool:
        return self.type.startswith("optional_")


@dataclass(frozen=True)
class SettingsKind:
    """Settings that are resolved together: who describes them, and who names the violated rules of their values."""

    name: str
    example: str
    describe: Callable[[], Iterable[FieldDescription]]
    violations: Callable[[Mapping[str, Scalar]], list[str]]


def described_by_core(entries: Iterable[Mapping[str, Any]]) -> Iterator[FieldDescription]:
    for entry in entries:
        choices = tuple(entry["choices"] or ())
        yield FieldDescription(entry["key"], entry["type"], entry["default"], choices, entry["rule"] or "", entry["description"])


ESTIMATOR = SettingsKind(
    "Settings",
    "submap.max_landmarks=20",
    lambda: described_by_core(_core.config_fields()),
    lambda values: _core.validate_config(values),
)


# Underwater missions: the estimator's settings, and behind these prefixes those of the search for contacts in sonar logs, and of the way
# from the frames of a camera to keypoints. The estimator has settings of the frames, too: how their keypoints find their landmarks.
SONAR_PREFIX = "sonar."
FRAMES_PREFIX = "frames."
MOSAIC_PREFIX = "mosaic."
#: What a landmark is, of those with that prefix: no setting of the way to keypoints.
LANDMARK_SOURCE = "frames.landmarks"
MOSAIC_POINTS = "frames.mosaic_points"


@cache
def _estimator_keys() -> frozenset[str]:
    return frozenset(entry["key"] for entry in _core.levelled_config_fields())


@cache
def _reader_keys() -> frozenset[str]:
    return frozenset(entry["key"] for entry in _core.frame_fields() if entry["key"].startswith(FRAMES_PREFIX))


SONAR_MODEL = FieldDescription(
    f"{SONAR_PREFIX}cascade_model", "optional_text", None, (), "", "detector cascade: the model, a cascade.json or the folder of a training"
)


def sonar_values(values: Mapping[str, Scalar]) -> dict[str, Scalar]:
    """The settings of the search for contacts, by their keys there."""
    return {key.removeprefix(SONAR_PREFIX): value for key, value in values.items() if key.startswith(SONAR_PREFIX)}


def core_sonar_values(values: Mapping[str, Scalar]) -> dict[str, Scalar]:
    """Those of them that the core knows: a model is read before."""
    return {key: value for key, value in sonar_values(values).items() if key != SONAR_MODEL.key.removeprefix(SONAR_PREFIX)}


def levelled_values(values: Mapping[str, Scalar]) -> dict[str, Scalar]:
    """The settings of the estimator of an underwater mission."""
    return {key: value for key, value in values.items() if key in _estimator_keys()}


def frame_values(values: Mapping[str, Scalar]) -> dict[str, Scalar]:
    """The settings of the way from frames to keypoints, as the core has them."""
    return {key: value for key, value in values.items() if key in _reader_keys()}


def mosaic_values(values: Mapping[str, Scalar]) -> dict[str, Scalar]:
    """The settings of the mosaic, as the core has them."""
    return {key: value for key, value in values.items() if key.startswith(MOSAIC_PREFIX)}


def _underwater_fields() -> Iterator[FieldDescription]:
    yield from described_by_core(_core.levelled_config_fields())
    for described in described_by_core(_core.side_scan_survey_fields()):
        yield replace(described, key=SONAR_PREFIX + described.key)
    yield SONAR_MODEL
    yield from (described for described in described_by_core(_core.frame_fields()) if described.key in _reader_keys())
    of_landmarks = described_by_core(_core.visual_odometry_fields())
    yield from (described for described in of_landmarks if described.key in (LANDMARK_SOURCE, MOSAIC_POINTS))
    yield from described_by_core(_core.mosaic_fields())


def _underwater_violations(values: Mapping[str, Scalar]) -> list[str]:
    of_sonar = _core.validate_side_scan_survey(core_sonar_values(values))
    of_frames = _core.validate_frames(frame_values(values)) + _core.validate_mosaic(mosaic_values(values))
    of_frames += _core.validate_visual_odometry({key: values[key] for key in (LANDMARK_SOURCE, MOSAIC_POINTS) if key in values})
    return _core.validate_levelled_config(levelled_values(values)) + [SONAR_PREFIX + violation for violation in of_sonar] + of_frames


UNDERWATER = SettingsKind("UnderwaterSettings", "split.max_landmarks=20", _underwater_fields, _underwater_violations)


@cache
def field_descriptions(kind: SettingsKind = ESTIMATOR) -> Mapping[str, FieldDescription]:
    """Every setting by its dotted key, in the order in which they are described."""
    return MappingProxyType({described.key: described for described in kind.describe()})


def known_keys(kind: SettingsKind = ESTIMATOR) -> list[str]:
    """Every key and every table, for suggestions."""
    keys = list(field_descriptions(kind))
    tables = {key[:position] for key in keys for position, character in enumerate(key) if character == "."}
    return [*keys, *sorted(tables)]


def defaults(kind: SettingsKind = ESTIMATOR) -> dict[str, Scalar]:
    return {key: described.default for key, described in field_descriptions(kind).items()}


def nest(flat: Mapping[str, Scalar]) -> dict[str, Any]:
    """Dotted keys to nested tables. Optional settings that are off become "none", which TOML can hold."""
    nested: dict[str, Any] = {}
    for key, value in flat.items():
        *sections, name = key.split(".")
        table = nested
        for section in sections:
            table = table.setdefault(section, {})
        table[name] = OFF if value is None else value
    return nested


def flatten(nested: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Nested tables to dotted keys with their values, in the order of the file."""
    for name, value in nested.items():
        key = f"{prefix}{name}"
        if isinstance(value, Mapping):
            yield from flatten(value, f"{key}.")
        else:
            yield key, value


def _annotation(described: FieldDescription) -> Any:
    plain: Any = {"float": float, "int": int, "bool": bool, "optional_float": float, "optional_int": int, "optional_text": str}.get(
        described.type
    )
    if described.type == "choice":
        plain = Literal[described.choices]
    if plain is None:
        raise TypeError(f"setting {described.key}: the type '{described.type}' is unknown to the command line")
    if plain is str:  # which "none" is, too
        return plain
    return plain | Literal["none"] if described.is_optional else plain


@cache
def settings_model(kind: SettingsKind = ESTIMATOR) -> type[BaseModel]:
    """The nested model of all settings: unknown keys are refused at every depth, types are not converted."""
    tree: dict[str, Any] = {}
    for key, described in field_descriptions(kind).items():
        *sections, name = key.split(".")
        table = tree
        for section in sections:
            table = table.setdefault(section, {})
        table[name] = described
    return _model_of(kind.name, tree)


def _model_of(name: str, tree: dict[str, Any]) -> type[BaseModel]:
    members: dict[str, Any] = {}
    for key, node in tree.items():
        if isinstance(node, FieldDescription):
            default = OFF if node.default is None else node.default
            text = f"{node.description} ({node.rule})" if node.rule else node.description
            members[key] = (_annotation(node), Field(default=default, description=text))
        else:
            section = _model_of("".join(part.capitalize() for part in key.split("_")) + "Settings", node)
            members[key] = (section, Field(default_factory=section))
    model: type[BaseModel] = create_model(name, __base__=StrictModel, **members)
    return model


def part(values: Mapping[str, Scalar], prefix: str) -> dict[str, Scalar]:
    """The settings of one table, without its name."""
    return {key.removeprefix(prefix): value for key, value in values.items() if key.startswith(prefix)}


def json_schema(kind: SettingsKind = ESTIMATOR) -> dict[str, Any]:
    return settings_model(kind).model_json_schema()


@dataclass(frozen=True)
class Layer:
    """Some settings and where they come from ("missions/a/mission.toml [settings]", "--set", ...)."""

    source: str
    values: Mapping[str, Scalar]


@dataclass(frozen=True)
class Settings:
    """Every setting with its value (dotted keys, the order of the estimator), valid."""

    values: Mapping[str, Scalar]
    origin: Mapping[str, str] = field(default_factory=dict)
    kind: SettingsKind = ESTIMATOR

    @property
    def method(self) -> str:
        return str(self.values[METHOD_KEY])

    def replaced(self, changes: Mapping[str, Scalar], source: str) -> "Settings":
        return resolve([Layer("this run", self.values), Layer(source, changes)], self.kind)

    def to_toml(self, seed: int) -> str:
        """The text of config.toml: everything a second run needs to give the same results."""
        return tomli_w.dumps({SEED_KEY: seed, **nest(self.values)})


def key_error(source: str, key: str, known: Sequence[str]) -> str:
    return f"{source}: unknown key '{key}'{nearest_hint(key, known)}"


def describe_validation_error(error: ValidationError, source: str, known: Sequence[str], kind: SettingsKind = ESTIMATOR) -> str:
    """One line for every violation: the source, the full key, the value and what is wrong with it."""
    lines: dict[str, None] = {}
    for item in error.errors():
        parts = [str(part) for part in item["loc"] if not str(part).startswith("literal[") and part not in ("float", "int", "str")]
        key = ".".join(parts)
        described = field_descriptions(kind).get(key)
        lines[_describe_item(item["type"], item.get("input"), item["msg"], key, described, source, known)] = None
    return "\n".join(lines)


def _shown(value: Any) -> str:
    """As TOML writes it."""
    return json.dumps(value, default=str)


def _describe_item(
    kind: str, value: Any, message: str, key: str, described: FieldDescription | None, source: str, known: Sequence[str]
) -> str:
    if kind == "extra_forbidden":
        return key_error(source, key, known)
    if kind == "missing":
        return f"{source}: key '{key}' is missing"
    if kind in ("model_type", "model_attributes_type", "dict_type"):
        return f"{source}: {key} = {_shown(value)}: must be a table, written [{key}]"
    if described is not None and described.type == "choice":
        hint = nearest_hint(str(value), described.choices)
        return f"{source}: {key} = {_shown(value)}: must be one of {', '.join(described.choices)}{hint}"
    wanted = {"float_type": "a number", "int_type": "a whole number", "bool_type": "true or false", "string_type": "a text"}.get(kind)
    if described is not None and described.is_optional and described.type != "optional_text":
        wanted = ("a whole number" if described.type == "optional_int" else "a number") + f' or "{OFF}"'
    if wanted is not None:
        return f"{source}: {key} = {_shown(value)}: must be {wanted}"
    return f"{source}: {key} = {_shown(value)}: {message}"


def layer_from_tables(nested: Mapping[str, Any], source: str, kind: SettingsKind = ESTIMATOR) -> Layer:
    """Settings as nested tables, checked for unknown keys and wrong types."""
    try:
        settings_model(kind).model_validate(dict(nested))
    except ValidationError as error:
        raise UserError(describe_validation_error(error, source, known_keys(kind), kind)) from error
    return Layer(source, {key: _converted(field_descriptions(kind)[key], value) for key, value in flatten(nested)})


def _converted(described: FieldDescription, value: Any) -> Scalar:
    if described.is_optional and value == OFF:
        return None
    if described.type in ("float", "optional_float"):
        return float(value)
    checked: Scalar = value
    return checked


def layer_from_assignments(assignments: Sequence[str], kind: SettingsKind = ESTIMATOR) -> Layer:
    """--set key=value, several times; the value is read as the type of its key."""
    values: dict[str, Scalar] = {}
    for assignment in assignments:
        key, separator, text = assignment.partition("=")
        key, text = key.strip(), text.strip()
        if not separator or not key:
            raise UserError(f"--set {assignment}: must be key=value, for example --set {kind.example}")
        described = field_descriptions(kind).get(key)
        if described is None:
            raise UserError(key_error("--set", key, list(field_descriptions(kind))))
        values[key] = parse_value(described, text, "--set")
    return Layer("--set", values)


def parse_value(described: FieldDescription, text: str, source: str) -> Scalar:
    if described.is_optional and text == OFF:
        return None
    if described.type == "choice":
        if text in described.choices:
            return text
        hint = nearest_hint(text, described.choices)
        raise UserError(f"{source}: {described.key} = {text!r}: must be one of {', '.join(described.choices)}{hint}")
    if described.type == "optional_text":
        return text
    if described.type == "bool":
        if text in ("true", "false"):
            return text == "true"
        raise UserError(f"{source}: {described.key} = {text!r}: must be true or false")
    number_type, wanted = (int, "a whole number") if described.type in ("int", "optional_int") else (float, "a number")
    try:
        return number_type(text)
    except ValueError as error:
        wanted += f' or "{OFF}"' if described.is_optional else ""
        raise UserError(f"{source}: {described.key} = {text!r}: must be {wanted}") from error


def layer_from_flag(flag: str, key: str, text: str | None, kind: SettingsKind = ESTIMATOR) -> Layer:
    """A flag such as --method, which is short for one setting; None means that it was not given."""
    if text is None:
        return Layer(flag, {})
    return Layer(flag, {key: parse_value(field_descriptions(kind)[key], text, flag)})


def layer_from_file(path: Path, kind: SettingsKind = ESTIMATOR) -> tuple[Layer, int | None]:
    """A configuration file: the settings as tables, and optionally `seed` at its top."""
    document = load_toml(path)
    seed = document.pop(SEED_KEY, None) if SEED_KEY not in field_descriptions(kind) else None
    if seed is not None:
        seed = checked_seed(seed, f"{path}: {SEED_KEY}")
    return layer_from_tables(document, str(path), kind), seed


def checked_seed(value: Any, source: str) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= MAX_SEED:
        raise UserError(f"{source} = {value!r}: must be a whole number from 0 to {MAX_SEED}")
    return value


def resolve(layers: Sequence[Layer], kind: SettingsKind = ESTIMATOR) -> Settings:
    """Later layers win over earlier ones, all of them over the defaults. Every violated rule is reported at once."""
    values = defaults(kind)
    origin: dict[str, str] = {}
    for layer in layers:
        for key, value in layer.values.items():
            values[key] = value
            origin[key] = layer.source
    violations = kind.violations(values)
    if violations:
        lines = [f"{origin.get(violation.split(' ', 1)[0], 'settings')}: {violation}" for violation in violations]
        raise UserError("\n".join(lines))
    return Settings(MappingProxyType(values), MappingProxyType(origin), kind)


def resolve_request(
    kind: SettingsKind,
    config_path: Path | None,
    assignments: Sequence[str],
    seed: int | None,
    *,
    presets: Sequence[Layer] = (),
    flags: Sequence[Layer] = (),
) -> tuple[Settings, int]:
    """defaults < --config < presets < --set < flags that are short for settings; the seed: default < file < --seed."""
    layers: list[Layer] = []
    file_seed = None
    if config_path is not None:
        layer, file_seed = layer_from_file(config_path, kind)
        layers.append(layer)
    layers += [*presets, layer_from_assignments(assignments, kind), *flags]
    chosen = seed if seed is not None else file_seed
    return resolve(layers, kind), DEFAULT_SEED if chosen is None else checked_seed(chosen, "--seed")
