"""The built-in surveys of an underwater vehicle, as missions with truth."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from ssjs_cli import _core
from ssjs_cli.camera_simulation import CAMERA_SCENARIOS, CAMERA_SURVEY, SimulatedCamera
from ssjs_cli.config import UNDERWATER, flatten, layer_from_tables, nest
from ssjs_cli.errors import UserError
from ssjs_cli.formats.geographic import to_longitude_latitude
from ssjs_cli.formats.mission import BodyPoints, Geodetic, Mission, Reference, ReferenceDescription, SurveyedLandmarks
from ssjs_cli.formats.navigation import Attitude, BottomVelocity, PositionFixes, Scalars, UnderwaterNavigation
from ssjs_cli.formats.number_table import FloatArray
from ssjs_cli.formats.tum import PoseSeries
from ssjs_cli.formats.xtf_writer import SideScanPings, write_xtf

AUV_SURVEY = "auv-survey"
WEAK_HEADING_SURVEY = "auv-survey-weak-heading"
SIDE_SCAN_SURVEY = "side-scan-survey"
SIDE_SCAN_SURVEY_LARGE = "side-scan-survey-large"
REMUS_SURVEY = "remus-survey"
REMUS_SURVEY_WITHOUT_FIXES = "remus-survey-no-fix"

# Objects on 400 m x 300 m, four hours: two dives over the same lines and cross lines, at 12 m and at 14 m.
_REMUS: Mapping[str, Any] = MappingProxyType(
    {
        "lines.lines": 12,
        "lines.line_length_m": 370.0,
        "lines.line_spacing_m": 25.0,
        "lines.cross_lines": 17,
        "lines.cross_margin_m": 15.0,
        "lines.landmark_margin_m": 12.5,
        "lines.dives": 2,
        "vehicle.dive_step_m": 2.0,
        "vehicle.depth_gain_rad_m": 0.3,
        "vehicle.sample_loss_fraction": 0.02,
        "seabed.depth_m": 15.8,
        "seabed.slope_north": 0.002,
        "seabed.slope_east": -0.001,
        "seabed.undulation_m": 0.15,
        "seabed.ripple_m": 0.03,
        "objects": 80,
        "clearance_m": 8.0,
        "max_altitude_m": 8.0,
    }
)

# By scenario with sonar pings, what differs from the simulator's own defaults.
SONAR_SCENARIOS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        SIDE_SCAN_SURVEY: {},
        SIDE_SCAN_SURVEY_LARGE: {
            "lines.lines": 11,
            "lines.line_length_m": 400.0,
            "lines.line_spacing_m": 30.0,
            "lines.cross_lines": 5,
            "objects": 300,
        },
        # From the surface, and satellites whenever the vehicle is there.
        REMUS_SURVEY: {**_REMUS, "lines.surface_start": True, "lines.run_in_m": 150.0, "vehicle.fix_interval_s": 1.0},
        REMUS_SURVEY_WITHOUT_FIXES: _REMUS,
    }
)
# By scenario with sightings, the same. Turn rates of 4 deg/s noise instead of 0.2: 1.3 deg/sqrt(s) of heading are lost.
POINT_SCENARIOS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {AUV_SURVEY: {}, WEAK_HEADING_SURVEY: {"motion.gyro_sigma_rad_s": math.radians(4.0)}}
)
# Settings that a mission brings along. Looked for are objects of 0.4 m and more: with a pixel more on each side, 6 columns of 0.1 m across
# the track and 4 pings 0.21 m apart. False echoes are rare enough that two hardly ever fall on one spot. With a weak heading: a filter that
# knows it and leaves the compass alone.
_REMUS_SETTINGS: Mapping[str, Any] = MappingProxyType(
    {"sonar.highlight_shadow.smallest_highlight_px": 24, "existence.chance_probability": 0.003}
)
# The filter knows the motion and the sensors of the small, slow vehicle.
_CAMERA_SETTINGS: Mapping[str, Any] = MappingProxyType(
    {
        "motion.velocity_walk_m_s_sqrt_s": 0.006,
        "motion.gyro_sigma_rad_s": 0.0175,
        "motion.compass_walk_rad_sqrt_s": 0.0035,
        "velocity_log.sigma_m_s": 0.03,
        "start.speed_m_s": 0.23,
        "start.speed_sigma_m_s": 0.2,
        "start.altitude_m": 2.5,
        "start.altitude_sigma_m": 2.0,
    }
)
SCENARIO_SETTINGS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        REMUS_SURVEY: _REMUS_SETTINGS,
        REMUS_SURVEY_WITHOUT_FIXES: _REMUS_SETTINGS,
        CAMERA_SURVEY: _CAMERA_SETTINGS,
        WEAK_HEADING_SURVEY: {**POINT_SCENARIOS[WEAK_HEADING_SURVEY], "compass_use": "none"},
    }
)
UNDERWATER_SCENARIOS = (*POINT_SCENARIOS, *SONAR_SCENARIOS, *CAMERA_SCENARIOS)

# Of the corner of a shared seabed.
PLACE_DEG: Mapping[str, float] = MappingProxyType({"latitude_deg": 41.7, "longitude_deg": 2.9})

# 2026-01-01: logs of sonars carry dates.
SONAR_EPOCH_S = 1767225600.0
PINGS_PER_BLOCK = 512
LOG_NAME = "survey.xtf"
# Easting and northing of the vehicle's start in the grid that it believes in.
GRID_ORIGIN_M = (500_000.0, 6_000_000.0)


def simulate_underwater(
    built_in: str,
    name: str,
    description: str,
    settings: Mapping[str, Any],
    seed: int,
    changes: Mapping[str, Any],
    season: Mapping[str, Any],
) -> Mission:
    """`built_in`: one of UNDERWATER_SCENARIOS, with the sensors that the filter's defaults describe. `changes`: tables or dotted keys of
    the simulator, laid over those of the scenario. `season`: the seabed that the mission shares with others, and where on earth it is."""
    settings = nest({**SCENARIO_SETTINGS.get(built_in, {}), **dict(flatten(settings))})
    layer_from_tables(settings, f"scenario {name}", UNDERWATER)
    said = description or f"simulated: {built_in}, seed {seed}"
    if built_in in POINT_SCENARIOS:
        survey, geodetic = _point_survey(name, seed, {**POINT_SCENARIOS[built_in]}, changes, season)
        return _mission(name, said, settings, survey, points=_points(survey), geodetic=geodetic)
    if built_in in CAMERA_SCENARIOS:
        camera = SimulatedCamera(built_in, name, changes, seed)
        mission = _mission(name, said, settings, camera.survey(), frames=camera.frames(), photographs=camera.photograph)
        return replace(mission, reference=replace(mission.reference, landmarks=None, surface=camera.surface()))
    try:
        sonar = _core.SideScanMission({**SONAR_SCENARIOS[built_in], **dict(flatten(changes))}, seed)
    except ValueError as error:
        raise UserError(f"scenario {name} [survey]: {error}") from error
    survey = _dated(sonar.survey())

    def record(folder: Path) -> None:
        write_xtf(folder / LOG_NAME, _pings(sonar, *_reckoned(survey)), sonar="ssjs simulator")

    return _mission(name, said, settings, survey, recording=record)


def _point_survey(
    name: str, seed: int, vehicle: Mapping[str, Any], changes: Mapping[str, Any], season: Mapping[str, Any]
) -> tuple[dict[str, Any], Geodetic | None]:
    """With its place on earth where it is one of a season."""
    unknown = [table for table in changes if table not in ("lines", "vehicle")]
    if unknown:
        raise UserError(f"scenario {name} [survey]: {unknown[0]}: no such table; it takes [survey.lines] and [survey.vehicle]")
    vehicle = {**vehicle, **dict(flatten(changes.get("vehicle", {})))}
    lines = dict(changes.get("lines", {}))
    place = {key: season[key] for key in PLACE_DEG if key in season}
    seabed = {key: value for key, value in season.items() if key not in PLACE_DEG}
    try:
        if not season:
            return _core.simulate_auv_survey(seed, vehicle, lines), None
        survey = _core.simulate_on_shared_seabed(seed, vehicle, lines, seabed)
    except ValueError as error:
        raise UserError(f"scenario {name}: {error}") from error
    corner = Geodetic(
        origin_latitude_deg=float(place.get("latitude_deg", PLACE_DEG["latitude_deg"])),
        origin_longitude_deg=float(place.get("longitude_deg", PLACE_DEG["longitude_deg"])),
        heading_deg=0.0,
        y_axis="right",
    )
    longitude, latitude = to_longitude_latitude(np.asarray(survey["origin_m"])[None, :], corner)[0]
    sigma_m = next(entry["default"] for entry in _core.shared_seabed_fields() if entry["key"] == "origin_sigma_m")
    origin = corner.model_copy(
        update={
            "origin_latitude_deg": float(latitude),
            "origin_longitude_deg": float(longitude),
            "origin_sigma_m": float(seabed.get("origin_sigma_m", sigma_m)) or None,
        }
    )
    return survey, origin


def _mission(name: str, description: str, settings: Mapping[str, Any], survey: Mapping[str, Any], **observed: Any) -> Mission:
    attitude, velocity, truth = (survey[key] for key in ("attitude", "velocity", "truth"))
    return Mission(
        name=name,
        description=description,
        notes="North-east-down; the first line heads north from the origin.",
        navigation=UnderwaterNavigation(
            Attitude(attitude[:, 0], attitude[:, 1:4], survey["gyro"][:, 1:4]),
            BottomVelocity(velocity[:, 0], velocity[:, 1:4], velocity[:, 4] == 1.0),
            Scalars(*np.ascontiguousarray(survey["depth"].T)),
            Scalars(*np.ascontiguousarray(survey["altitude"].T)),
            _fixes(survey),
        ),
        settings=dict(settings),
        # The estimate starts at the true pose, which defines the frame: nothing to align.
        reference=Reference(
            ReferenceDescription(alignment="none"),
            truth=PoseSeries(truth[:, 0], truth[:, [1, 2, 6]], truth[:, [3, 4, 5]]),
            landmarks=SurveyedLandmarks(np.asarray(survey["landmark_ids"]), survey["landmarks"][:, :2]),
        ),
        **observed,
    )


def _fixes(survey: Mapping[str, Any]) -> PositionFixes | None:
    fixes = survey["fixes"]
    return PositionFixes(fixes[:, 0], fixes[:, 1:3], fixes[:, 3]) if len(fixes) else None


def _points(survey: Mapping[str, Any]) -> BodyPoints | None:
    points = survey["sightings"]
    return BodyPoints(points[:, 0], points[:, 1:4], np.asarray(survey["sighting_ids"])) if len(points) else None


def _dated(survey: Mapping[str, Any]) -> dict[str, Any]:
    """With UTC instead of seconds since the start."""
    dated = dict(survey)
    for key in ("attitude", "gyro", "velocity", "depth", "altitude", "fixes", "truth"):
        table = survey[key].copy()
        table[:, 0] += SONAR_EPOCH_S
        dated[key] = table
    return dated


def _reckoned(survey: Mapping[str, Any]) -> tuple[FloatArray, FloatArray]:
    """Times, and easting and northing: the position that the vehicle writes beside its pings, from compass and Doppler log alone."""
    attitude, velocity = survey["attitude"], survey["velocity"]
    time_s, heading = attitude[:, 0], attitude[:, 3]
    locked = velocity[velocity[:, 4] == 1.0]
    forward, starboard = (np.interp(time_s, locked[:, 0], locked[:, column]) for column in (1, 2))
    step_s = np.diff(time_s, prepend=time_s[0])
    north = np.cumsum(step_s * (np.cos(heading) * forward - np.sin(heading) * starboard))
    east = np.cumsum(step_s * (np.sin(heading) * forward + np.cos(heading) * starboard))
    return time_s, np.column_stack([east, north]) + GRID_ORIGIN_M


def _pings(sonar: Any, time_s: FloatArray, position_m: FloatArray) -> Iterator[SideScanPings]:
    while (block := sonar.next_pings(PINGS_PER_BLOCK)) is not None:
        navigation = block.pop("navigation")
        pinged_s = navigation[:, 0] + SONAR_EPOCH_S
        place = np.column_stack([np.interp(pinged_s, time_s, position_m[:, axis]) for axis in (0, 1)])
        yield SideScanPings(time_s=pinged_s, navigation=navigation[:, 1:], position_m=place, **block)
