"""Simulated missions: a scenario by name or by file, as a mission with truth."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field, ValidationError

from ssjs_cli import _core
from ssjs_cli.config import (
    DEFAULT_SEED,
    VEHICLE_KEY,
    StrictModel,
    checked_seed,
    describe_validation_error,
    flatten,
    layer_from_tables,
    nest,
    resolve,
)
from ssjs_cli.errors import UserError, nearest_hint
from ssjs_cli.formats.mission import Mission, Observations, Odometry, Reference, ReferenceDescription, SurveyedLandmarks
from ssjs_cli.formats.toml_file import load_toml
from ssjs_cli.formats.tum import PoseSeries


class ScenarioDocument(StrictModel):
    """A scenario file: a built-in scenario under another name, seed or settings."""

    scenario: str
    name: str = Field(default="", pattern=r"^[\w .-]*$")
    description: str = ""
    seed: int | None = None
    settings: dict[str, Any] = Field(default_factory=dict)


@dataclass(frozen=True)
class Scenario:
    """`settings` are nested tables laid over those of the built-in scenario."""

    built_in: str
    name: str
    seed: int
    description: str = ""
    settings: Mapping[str, Any] = field(default_factory=dict)


def read_scenario(text: str, seed: int | None) -> Scenario:
    """A built-in name, or a TOML file."""
    path = Path(text)
    if path.suffix != ".toml":
        return Scenario(text, text, DEFAULT_SEED if seed is None else seed)
    content = load_toml(path)
    try:
        document = ScenarioDocument.model_validate(content)
    except ValidationError as error:
        raise UserError(describe_validation_error(error, str(path), list(ScenarioDocument.model_fields))) from error
    layer_from_tables(document.settings, f"{path} [settings]")
    file_seed = None if document.seed is None else checked_seed(document.seed, f"{path}: seed")
    chosen = seed if seed is not None else file_seed
    return Scenario(
        document.scenario,
        document.name or path.stem,
        DEFAULT_SEED if chosen is None else chosen,
        document.description,
        document.settings,
    )


def simulate_mission(scenario: Scenario) -> Mission:
    names = _core.scenario_names()
    if scenario.built_in not in names:
        hint = nearest_hint(scenario.built_in, names)
        raise UserError(f"scenario '{scenario.built_in}' is not known{hint}; the built-in ones are {', '.join(names)}")
    try:
        simulated = _core.simulate(scenario.built_in, scenario.seed)
    except ValueError as error:
        raise UserError(f"scenario '{scenario.built_in}': {error}") from error
    settings = {**dict(simulated["config"]), **dict(flatten(scenario.settings))}
    resolve([layer_from_tables(nest(settings), f"scenario {scenario.name}")])
    settings.setdefault(VEHICLE_KEY, "ackerman")
    return Mission(
        name=scenario.name,
        description=scenario.description or f"simulated: {scenario.built_in}, seed {scenario.seed}",
        odometry=Odometry("ackerman", np.column_stack([simulated["control_time_s"], simulated["speed_m_s"], simulated["steering_rad"]])),
        observations=Observations(
            np.asarray(simulated["scan_time_s"], dtype=np.float64),
            np.asarray(simulated["range_m"], dtype=np.float64),
            np.asarray(simulated["bearing_rad"], dtype=np.float64),
            landmark_id=np.asarray(simulated["landmark_id"], dtype=np.int64),
        ),
        settings=nest(settings),
        # The estimate starts at the true pose, which defines the frame: nothing to align.
        reference=Reference(
            ReferenceDescription(alignment="none"),
            truth=PoseSeries(
                np.asarray(simulated["truth_time_s"], dtype=np.float64), np.asarray(simulated["truth_pose"], dtype=np.float64)
            ),
            landmarks=SurveyedLandmarks(
                np.asarray(simulated["landmark_ids"], dtype=np.int64), np.asarray(simulated["landmark_position"], dtype=np.float64)
            ),
        ),
    )
