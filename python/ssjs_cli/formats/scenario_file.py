"""A scenario file: a world, a vehicle, a sensor and a path, or a built-in scenario under other settings. docs/scenarios.md."""

from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field, ValidationError, create_model

from ssjs_cli import _core
from ssjs_cli.config import StrictModel, describe_validation_error
from ssjs_cli.errors import UserError
from ssjs_cli.formats.toml_file import load_toml

NAME_PATTERN = r"^[\w .-]*$"
VEHICLE_PREFIX = "vehicle."
#: Keys of the simulator that stand beside its vehicle section and belong to the vehicle all the same.
DRIVING_KEYS = ("speed_m_s", "max_steering_rad", "step_s", "lookahead_m")
STEPS_PER_SCAN = "steps_per_scan"
SCAN_PERIOD = "scan_period_s"
WORLD_TABLES = ("vehicle", "sensor", "path", "landmarks")

Point = Annotated[list[float], Field(min_length=2, max_length=2)]
Length = Annotated[float, Field(gt=0.0)]


class BuiltInVariant(StrictModel):
    """A built-in scenario under another name, seed or settings."""

    scenario: str
    name: str = Field(default="", pattern=NAME_PATTERN)
    description: str = ""
    seed: int | None = None
    settings: dict[str, Any] = Field(default_factory=dict)
    survey: dict[str, Any] = Field(default_factory=dict)
    season: dict[str, Any] = Field(default_factory=dict)
    pictures: dict[str, Any] = Field(default_factory=dict)


class LawnMower(StrictModel):
    """Parallel lines, driven to and fro. along: the axis they run along; the first lies at first_line_m of the other axis."""

    lines: int = Field(ge=1)
    line_spacing_m: float
    first_line_m: float
    start_m: float
    end_m: float
    along: Literal["x", "y"] = "x"
    return_between: bool = False


class PathOfScenario(StrictModel):
    waypoints_m: list[Point] | None = Field(default=None, min_length=2)
    lawn_mower: LawnMower | None = None
    laps: int | None = Field(default=None, ge=1)


class Grid(StrictModel):
    columns: int = Field(ge=1)
    rows: int = Field(ge=1)
    spacing_m: Length
    jitter_m: float = Field(default=0.0, ge=0.0)
    origin_m: Point = Field(default_factory=lambda: [0.0, 0.0])


class RandomField(StrictModel):
    count: int = Field(ge=1, le=1_000_000)
    width_m: Length
    height_m: Length
    min_distance_m: float = Field(default=0.0, ge=0.0)
    origin_m: Point = Field(default_factory=lambda: [0.0, 0.0])


class Landmarks(StrictModel):
    positions_m: list[Point] | None = Field(default=None, min_length=1)
    grid: Grid | None = None
    random: RandomField | None = None


@cache
def simulator_defaults() -> dict[str, Any]:
    """Every key of the simulator with its default."""
    return {entry["key"]: entry["default"] for entry in _core.simulation_fields()}


@cache
def toml_keys() -> dict[str, str]:
    """Where each key of the simulator stands in a scenario file."""
    places = {}
    for key in simulator_defaults():
        if key.startswith(VEHICLE_PREFIX):
            places[key] = key
        elif key in DRIVING_KEYS:
            places[key] = f"vehicle.{key}"
        else:
            places[key] = f"sensor.{SCAN_PERIOD if key == STEPS_PER_SCAN else key}"
    return places


@cache
def world_model() -> type[BaseModel]:
    """The vehicle and sensor tables take exactly what the simulator describes."""
    tables: dict[str, dict[str, Any]] = {"vehicle": {}, "sensor": {}}
    for place in toml_keys().values():
        table, key = place.split(".", 1)
        tables[table][key] = (float | None, None)
    vehicle = create_model("Vehicle", __base__=StrictModel, **tables["vehicle"])
    sensor = create_model("Sensor", __base__=StrictModel, **tables["sensor"])
    model: type[BaseModel] = create_model(
        "ScenarioFile",
        __base__=StrictModel,
        name=(str, Field(default="", pattern=NAME_PATTERN)),
        description=(str, ""),
        seed=(int | None, None),
        settings=(dict[str, Any], Field(default_factory=dict)),
        vehicle=(vehicle, Field(default_factory=vehicle)),
        sensor=(sensor, Field(default_factory=sensor)),
        path=(PathOfScenario, ...),
        landmarks=(Landmarks, ...),
    )
    return model


def known_keys(model: type[BaseModel], prefix: str = "") -> list[str]:
    """Every dotted key of a model and of those inside it."""
    keys = []
    for name, field in model.model_fields.items():
        keys.append(f"{prefix}{name}")
        inner = [part for part in (field.annotation, *getattr(field.annotation, "__args__", ())) if isinstance(part, type)]
        for part in inner:
            if issubclass(part, BaseModel):
                keys += known_keys(part, f"{prefix}{name}.")
    return keys


def read_scenario_file(path: Path) -> dict[str, Any]:
    """The checked document as plain data. It has the key `scenario` (a built-in one) or the tables path and landmarks."""
    content = load_toml(path)
    has_world = "scenario" not in content and any(table in content for table in WORLD_TABLES)
    model = world_model() if has_world else BuiltInVariant
    try:
        document = model.model_validate(content)
    except ValidationError as error:
        raise UserError(describe_validation_error(error, str(path), known_keys(model))) from error
    plain: dict[str, Any] = document.model_dump(exclude_none=True)
    if has_world:
        _require_one(plain["path"], ("waypoints_m", "lawn_mower"), f"{path} [path]")
        _require_one(plain["landmarks"], ("positions_m", "grid", "random"), f"{path} [landmarks]")
    return plain


def _require_one(table: dict[str, Any], names: tuple[str, ...], where: str) -> None:
    given = [name for name in names if name in table]
    if len(given) != 1:
        shown = f"holds {' and '.join(given)}" if given else "is empty"
        raise UserError(f"{where}: {shown}; give exactly one of {', '.join(names)}")
