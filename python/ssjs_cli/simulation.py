"""Simulated missions: a scenario by name or by file, as a mission with truth."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ssjs_cli import _core
from ssjs_cli.config import (
    DEFAULT_SEED,
    ESTIMATOR,
    UNDERWATER,
    VEHICLE_KEY,
    Scalar,
    SettingsKind,
    checked_seed,
    flatten,
    layer_from_tables,
    nest,
    resolve,
)
from ssjs_cli.errors import UserError, nearest_hint
from ssjs_cli.formats.mission import Mission, Observations, Odometry, Reference, ReferenceDescription, SurveyedLandmarks
from ssjs_cli.formats.scenario_file import WORLD_TABLES, read_scenario_file
from ssjs_cli.formats.tum import PoseSeries
from ssjs_cli.scenario_world import simulate_world, simulator_config
from ssjs_cli.sonar_loop import SONAR_LOOP, picture_settings, simulate_sonar_loop
from ssjs_cli.underwater_simulation import AUV_SURVEY, UNDERWATER_SCENARIOS, simulate_underwater


@dataclass(frozen=True)
class Scenario:
    """Either a built-in scenario by its name, or the tables of a scenario file. `settings` are laid over those that it brings along,
    `pictures` over the defaults of one that simulates pictures. Plain data, so that a worker elsewhere can simulate it."""

    name: str
    seed: int
    built_in: str = ""
    world: Mapping[str, Any] | None = None
    description: str = ""
    settings: Mapping[str, Any] = field(default_factory=dict)
    survey: Mapping[str, Any] = field(default_factory=dict)
    season: Mapping[str, Any] = field(default_factory=dict)
    pictures: Mapping[str, Scalar] = field(default_factory=dict)

    @property
    def kind(self) -> SettingsKind:
        return UNDERWATER if self.built_in in UNDERWATER_SCENARIOS else ESTIMATOR

    @property
    def identity(self) -> dict[str, Any]:
        """All that determines its mission, but for the seed."""
        pictures = {"pictures": dict(self.pictures)} if self.pictures else {}
        season = {"season": dict(self.season)} if self.season else {}
        settings, survey = dict(self.settings), dict(self.survey)
        return {"built_in": self.built_in, "world": self.world, "settings": settings, "survey": survey, **season, **pictures}


def read_scenario(text: str, seed: int | None, assignments: tuple[str, ...] = ()) -> Scenario:
    """A built-in name, or a TOML file. `assignments`: of its pictures, key=value."""
    path = Path(text)
    if path.suffix != ".toml":
        pictures = picture_settings(text, {}, "", assignments)
        return Scenario(text, DEFAULT_SEED if seed is None else seed, built_in=text, pictures=pictures)
    document = read_scenario_file(path)
    settings = document.get("settings", {})
    file_seed = None if document.get("seed") is None else checked_seed(document["seed"], f"{path}: seed")
    chosen = seed if seed is not None else file_seed
    scenario = Scenario(
        document["name"] or path.stem,
        DEFAULT_SEED if chosen is None else chosen,
        built_in=document.get("scenario", ""),
        world={table: document[table] for table in WORLD_TABLES} if "path" in document else None,
        description=document["description"],
        settings=settings,
        survey=document.get("survey", {}),
        season=document.get("season", {}),
        pictures=picture_settings(document.get("scenario", "of a file"), document.get("pictures", {}), str(path), assignments),
    )
    layer_from_tables(settings, f"{path} [settings]", scenario.kind)
    if scenario.survey and scenario.built_in not in UNDERWATER_SCENARIOS:
        raise UserError(f"{path}: [survey] is for the underwater scenarios {', '.join(UNDERWATER_SCENARIOS)}; leave it out")
    if scenario.season and scenario.built_in != AUV_SURVEY:
        raise UserError(f"{path}: [season] is for the scenario {AUV_SURVEY}; leave it out")
    if scenario.world is not None:
        simulator_config(scenario.world, str(path))
    return scenario


def _simulated(scenario: Scenario) -> dict[str, Any]:
    if scenario.world is not None:
        return simulate_world(scenario.world, scenario.seed, f"scenario {scenario.name}")
    if scenario.built_in == SONAR_LOOP:
        return simulate_sonar_loop(scenario.pictures, scenario.seed)
    names = [*_core.scenario_names(), SONAR_LOOP, *UNDERWATER_SCENARIOS]
    if scenario.built_in not in names:
        hint = nearest_hint(scenario.built_in, names)
        known = ", ".join(names)
        raise UserError(f"scenario '{scenario.built_in}' is not known{hint}; the built-in ones are {known}; or name a .toml file")
    try:
        return _core.simulate(scenario.built_in, scenario.seed)
    except ValueError as error:
        raise UserError(f"scenario '{scenario.built_in}': {error}") from error


def simulate_mission(scenario: Scenario) -> Mission:
    if scenario.built_in in UNDERWATER_SCENARIOS:
        return simulate_underwater(
            scenario.built_in,
            scenario.name,
            scenario.description,
            scenario.settings,
            scenario.seed,
            scenario.survey,
            scenario.season,
        )
    simulated = _simulated(scenario)
    settings = {**dict(simulated["config"]), **dict(flatten(scenario.settings))}
    resolve([layer_from_tables(nest(settings), f"scenario {scenario.name}")])
    settings.setdefault(VEHICLE_KEY, "ackerman")
    return Mission(
        name=scenario.name,
        description=scenario.description or f"simulated: {scenario.built_in or scenario.name}, seed {scenario.seed}",
        notes=simulated.get("notes", ""),
        odometry=Odometry("ackerman", np.column_stack([simulated["control_time_s"], simulated["speed_m_s"], simulated["steering_rad"]])),
        observations=Observations(
            np.asarray(simulated["scan_time_s"], dtype=np.float64),
            np.asarray(simulated["range_m"], dtype=np.float64),
            np.asarray(simulated["bearing_rad"], dtype=np.float64),
            # Points share one covariance, which the settings hold; regions have each their own.
            covariance=np.asarray(simulated["covariance"], dtype=np.float64) if scenario.built_in == SONAR_LOOP else None,
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
