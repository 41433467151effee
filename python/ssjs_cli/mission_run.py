"""One mission through the estimator: files in, a run directory out."""

import hashlib
import os
import resource
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from ssjs_cli import _core
from ssjs_cli.camera.frame_reading import FrameOutcome, with_keypoints
from ssjs_cli.camera.run_output import doubtful_frames, write_camera
from ssjs_cli.camera.settings import camera_of
from ssjs_cli.config import (
    ASSOCIATION_KEY,
    DEFAULT_SEED,
    ESTIMATOR,
    LANDMARK_SOURCE,
    METHOD_KEY,
    SONAR_MODEL,
    UNDERWATER,
    VEHICLE_KEY,
    Layer,
    Scalar,
    Settings,
    SettingsKind,
    checked_seed,
    core_sonar_values,
    layer_from_assignments,
    layer_from_file,
    layer_from_flag,
    layer_from_tables,
    levelled_values,
    resolve,
    sonar_values,
)
from ssjs_cli.errors import UserError
from ssjs_cli.evaluation import Evaluation, evaluate
from ssjs_cli.formats.atomic import check_replaceable, new_directory
from ssjs_cli.formats.mission import MISSION_FILE, Mission, Observations, Odometry, input_digests, mission_directory, read_mission
from ssjs_cli.formats.navigation import POSITION_FIXES_FILE
from ssjs_cli.formats.number_table import FloatArray
from ssjs_cli.formats.run_directory import (
    CONFIG_FILE,
    LOG_FILE,
    MISSION_LINK_FILE,
    SUMMARY_FILE,
    TIMING_FILE,
    Estimate,
    estimate_of,
    json_text,
    numbers_of,
    why_not_a_run,
    write_estimate,
)
from ssjs_cli.methods import refuse_elsewhere
from ssjs_cli.optical.frame_settings import FRAMES_ALONE, FrameSettings
from ssjs_cli.optical.mosaic_landmarks import with_mosaic_points
from ssjs_cli.optical.planar_output import write_planar_survey
from ssjs_cli.optical.planar_survey import PlanarSurvey, planar_survey
from ssjs_cli.progress import interruptible, working
from ssjs_cli.run_measures import measures, run_times
from ssjs_cli.session import Session
from ssjs_cli.sonar.contacts import Sighting, body_points, sightings_in
from ssjs_cli.sonar.detector import detector_model
from ssjs_cli.sonar.log_times import check_log_times
from ssjs_cli.sonar.survey_record import SurveyRecord
from ssjs_cli.survey_output import write_survey
from ssjs_cli.underwater_log import build_navigation_log, north, rotation_drive

RUN_KIND = "run directory"
RANGE_SIGMA_KEY = "sensor.range_sigma_m"
BEARING_SIGMA_KEY = "sensor.bearing_sigma_rad"
SMOOTHING_KEY = "smoothing.enabled"
SMOOTHING_ITERATIONS_KEY = "smoothing.max_iterations"
# Beyond the last odometry record the motion is unknown: later observations cannot be used.
MAX_OBSERVATION_LAG_S = 1.0
MAX_REFUSED_FRACTION = 0.1


@dataclass(frozen=True)
class RunRequest:
    """What the user asked for. None means: not said."""

    mission_path: Path
    out: Path | None = None
    seed: int | None = None
    method: str | None = None
    association: str | None = None
    config_path: Path | None = None
    assignments: Sequence[str] = ()
    calibrate: bool = False
    smooth: bool = False
    force: bool = False


@dataclass
class FinishedRun:
    directory: Path
    summary: dict[str, Any]
    lost: list[str] = field(default_factory=list)


@dataclass
class _Stopwatch:
    """Wall time of each part of the call, for timing.json."""

    parts_s: dict[str, float] = field(default_factory=dict)
    started_s: float = field(default_factory=time.perf_counter)
    lap_s: float = field(default_factory=time.perf_counter)

    def lap(self, name: str) -> None:
        now_s = time.perf_counter()
        self.parts_s[f"{name}_s"] = round(now_s - self.lap_s, 6)
        self.lap_s = now_s


def resolve_settings(request: RunRequest, directory: Path, mission: Mission) -> tuple[Settings, int]:
    """defaults < mission.toml [settings] < --config file < --set < flags; the seed: default < file < --seed."""
    kind = settings_kind(mission)
    layers = [layer_from_tables(mission.settings, f"{directory / MISSION_FILE} [settings]", kind)]
    file_seed = None
    if request.config_path is not None:
        layer, file_seed = layer_from_file(request.config_path, kind)
        layers.append(layer)
    layers.append(layer_from_assignments(request.assignments, kind))
    if request.method is not None:
        refuse_elsewhere(request.method, kind, "--method")
    layers.append(layer_from_flag("--method", METHOD_KEY, request.method, kind))
    layers.append(layer_from_flag("--association", ASSOCIATION_KEY, request.association, kind))
    if kind is UNDERWATER:
        refuse_planar_options(request, directory)
        layers[:0] = [rotation_drive(mission, directory), north(mission, directory), camera_of(mission, directory)]
    if kind is FRAMES_ALONE and request.calibrate:
        raise UserError(f"--calibrate: is for odometry of a vehicle, and {directory} holds frames alone; leave it out")
    layers.append(layer_from_flag("--smooth", SMOOTHING_KEY, "true" if request.smooth else None))
    if mission.odometry is not None and all(VEHICLE_KEY not in layer.values for layer in layers):
        layers.insert(0, Layer(f"the columns of {directory / 'odometry.csv'}", {VEHICLE_KEY: mission.odometry.kind}))
    seed = request.seed if request.seed is not None else file_seed
    return resolve(layers, kind), DEFAULT_SEED if seed is None else checked_seed(seed, "--seed")


def with_contacts(
    mission: Mission, settings: Mapping[str, Scalar], lost: list[str], record: SurveyRecord | None = None
) -> tuple[Mission, list[Sighting]]:
    """The mission with what is found in its sonar logs, where it does not bring its observations along; the record is told of what the
    pings look like."""
    if not mission.sonar_logs or mission.points is not None:
        return mission, []
    if mission.navigation is not None:
        check_log_times(mission.sonar_logs, mission.navigation.attitude.time_s)
    model = detector_model(sonar_values(settings))
    cascade = None if model is None else model.cascade
    sightings = sightings_in(mission.sonar_logs, core_sonar_values(settings), lost, cascade, record)
    return replace(mission, points=body_points(sightings)), sightings


def model_digests(settings: Settings) -> dict[str, str]:
    """Of the files that the settings name: they determine a result as the files of the mission do."""
    model = detector_model(sonar_values(settings.values)) if settings.kind is UNDERWATER else None
    return {} if model is None else {SONAR_MODEL.key: model.digest}


def settings_kind(mission: Mission) -> SettingsKind:
    if mission.has_frames_alone:
        return FRAMES_ALONE
    return UNDERWATER if mission.odometry is None else ESTIMATOR


def refuse_planar_options(request: RunRequest, directory: Path) -> None:
    for flag, given in (("--calibrate", request.calibrate), ("--smooth", request.smooth)):
        if given:
            raise UserError(f"{flag}: is for vehicles with odometry in the plane, and {directory} is an underwater mission; leave it out")


def build_log(mission: Mission, settings: Settings, directory: Path, lost: list[str]) -> Any:
    """The records of a mission as the estimator takes them."""
    if mission.frames is not None and mission.has_frames_alone:
        return survey_of_frames(mission, settings.values, DEFAULT_SEED, lost, lambda fraction: True).log
    if mission.odometry is None:
        return build_navigation_log(mission, directory, lost)
    kind = settings.values[VEHICLE_KEY]
    if kind != mission.odometry.kind:
        raise UserError(
            f"{directory / 'odometry.csv'}: holds {mission.odometry.kind} odometry and {VEHICLE_KEY} is {kind} "
            f'({settings.origin.get(VEHICLE_KEY, "default")}); set {VEHICLE_KEY} = "{mission.odometry.kind}" or give other columns'
        )
    observed = {"observations.csv": mission.observations, "scans.npz": mission.scans, "sonar_hits.csv": mission.sonar_hits}
    present = [name for name, records in observed.items() if records is not None]
    if len(present) > 1:
        raise UserError(f"{directory}: holds both {' and '.join(present[:2])}, which would be used twice; remove one of them")
    log = _core.MissionLog()
    try:
        _add_odometry(log, mission.odometry)
        last_time_s = float(mission.odometry.time_s[-1]) + MAX_OBSERVATION_LAG_S
        if mission.observations is not None:
            observations = mission.observations
            used = observations.time_s <= last_time_s
            _note_unused(used, "observations", lost)
            log.add_features(
                observations.time_s[used],
                observations.range_m[used],
                observations.bearing_rad[used],
                _observation_covariance(observations, settings)[used],
                None if observations.landmark_id is None else observations.landmark_id[used],
            )
        if mission.scans is not None:
            scans = mission.scans
            used = scans.time_s <= last_time_s
            _note_unused(used, "scans", lost)
            log.add_scans(scans.time_s[used], np.ascontiguousarray(scans.range_m[used]), scans.first_angle_rad, scans.step_rad)
        if mission.sonar_hits is not None:
            hits = mission.sonar_hits
            used = hits.time_s <= last_time_s
            _note_unused(used, "sonar hits", lost)
            log.add_sonar_hits(hits.time_s[used], hits.range_m[used], hits.bearing_rad[used])
    except ValueError as error:
        raise UserError(f"{directory}: {error}") from error
    return log


def survey_of_frames(
    mission: Mission, settings: Mapping[str, Scalar], seed: int, lost: list[str], progress: Callable[[float], bool]
) -> PlanarSurvey:
    """A mission of frames alone, made one with odometry and landmarks."""
    if mission.frames is None:
        raise UserError(f"mission '{mission.name}': holds no frames")
    return planar_survey(
        mission.frames, FrameSettings(settings), seed, lost, lambda log: run_estimator(settings, log, seed, lambda fraction: True), progress
    )


def _observation_covariance(observations: Observations, settings: Settings) -> FloatArray:
    """(n, 3) var_range, cov, var_bearing: of the log, or the sensor's where the log gives none."""
    if observations.covariance is not None:
        return observations.covariance
    range_sigma_m, bearing_sigma_rad = (float(settings.values[key] or 0.0) for key in (RANGE_SIGMA_KEY, BEARING_SIGMA_KEY))
    return np.tile([range_sigma_m**2, 0.0, bearing_sigma_rad**2], (len(observations.time_s), 1))


def _note_unused(used: Any, what: str, lost: list[str]) -> None:
    count = int((~used).sum())
    if count:
        lag = f"more than {MAX_OBSERVATION_LAG_S:g} s after the last odometry record"
        lost.append(f"{count} of {len(used)} {what} come {lag} and were not used")


def _add_odometry(log: Any, odometry: Odometry) -> None:
    columns = [np.ascontiguousarray(column) for column in odometry.values.T]
    if odometry.kind == "ackerman":
        log.add_ackerman(*columns)
    elif odometry.kind == "unicycle":
        log.add_velocity(*columns)
    else:
        time_s, dx_m, dy_m, dheading_rad, sigma_x_m, sigma_y_m, sigma_heading_rad = columns
        zero = np.zeros(len(time_s))
        covariance = np.column_stack([sigma_x_m**2, zero, zero, sigma_y_m**2, zero, sigma_heading_rad**2])
        log.add_increments(time_s, dx_m, dy_m, dheading_rad, covariance)


def default_out(mission_name: str, method: str) -> Path:
    return Path("runs") / f"{path_name(mission_name)}-{method}"


def path_name(text: str) -> str:
    """A name for people as a name for a directory: letters, digits, dots, dashes and underscores."""
    kept = "".join(character if character.isalnum() or character in "._-" else "-" for character in text.strip())
    return kept.strip(".-") or "mission"


def run_mission(request: RunRequest, session: Session) -> FinishedRun:
    stopwatch = _Stopwatch()
    directory = mission_directory(request.mission_path)
    with working("reading the mission"):
        mission = read_mission(directory)
        digests = input_digests(directory)
    settings, seed = resolve_settings(request, directory, mission)
    out = request.out or default_out(mission.name, settings.method)
    session.fault_log = out.with_name(out.name + ".fault.jsonl")
    check_replaceable(out, force=request.force, why_not_ours=why_not_a_run, kind=RUN_KIND)
    lost: list[str] = []
    warnings: list[str] = []
    sightings: list[Sighting] = []
    record = SurveyRecord()
    if mission.sonar_logs and mission.points is None:
        digests.update(model_digests(settings))
        with working("looking for contacts in the sonar logs"):
            mission, sightings = with_contacts(mission, settings.values, lost, record)
        stopwatch.lap("detect")
    outcomes: list[FrameOutcome] = []
    if mission.frames is not None and not mission.has_frames_alone:
        with interruptible("reading the frames") as progress:
            mission, outcomes = with_keypoints(mission, settings.values, lost, progress)
        stopwatch.lap("frames")
    frames: PlanarSurvey | None = None
    if mission.has_frames_alone:
        with interruptible("registering the frames") as progress:
            frames = survey_of_frames(mission, settings.values, seed, lost, progress)
        stopwatch.lap("register")
    log = build_log(mission, settings, directory, lost) if frames is None else frames.log
    if outcomes and settings.values[LANDMARK_SOURCE] == "mosaic-points":
        with interruptible("points of the mosaic") as progress:
            used = [(outcome.time_s, outcome.file) for outcome in outcomes if not outcome.kind]
            mission = with_mosaic_points(mission, used, settings.values, run_estimator(settings.values, log, seed, progress), seed)
            log = build_log(mission, settings, directory, lost)
        stopwatch.lap("mosaic_points")
    if not mission.has_observations:
        warnings.append("the mission holds no observations: the answer is dead reckoning")
        session.warn(f"{directory}: {warnings[-1]}")
    stopwatch.lap("read")
    session.log("mission read", mission=mission.name, seed=seed, method=settings.method, origin=dict(settings.origin), digests=digests)

    with new_directory(out, force=request.force, why_not_ours=why_not_a_run, kind=RUN_KIND) as partial:
        if request.calibrate:
            settings = _calibrated(settings, log, seed, session)
            stopwatch.lap("calibrate")
        with interruptible("estimating") as progress:
            result = run_estimator(settings.values, log, seed, progress)
        stopwatch.lap("estimate")
        for text in [*doubtful_frames(outcomes), *doubtful_navigation(mission, result)]:
            warnings.append(text)
            session.warn(f"{directory}: {text}")
        if result["counters"].get("smoothing_converged") is False:
            warnings.append(f"the smoother stopped before its minimum; raise {SMOOTHING_ITERATIONS_KEY} or try a kernel")
            session.warn(f"{directory}: {warnings[-1]}")
        estimate = estimate_of(result)
        with working("writing the results"):
            write_estimate(partial, estimate, result, mission.geodetic)
            survey = {} if mission.odometry is not None or frames else write_survey(partial, mission, estimate, sightings, record)
            if outcomes:
                survey.update(write_camera(partial, mission, estimate, result, settings.values, outcomes))
            if frames is not None:
                survey = write_planar_survey(partial, frames, FrameSettings(settings.values), estimate)
            evaluation = evaluate(estimate, mission.reference)
            evaluation.write(partial)
        lost += evaluation.lost
        config_text = settings.to_toml(seed)
        (partial / CONFIG_FILE).write_text(config_text, encoding="utf-8")
        link = {"mission": os.path.relpath(directory.resolve(), out.resolve()), "mission_name": mission.name}
        (partial / MISSION_LINK_FILE).write_text(json_text(link), encoding="utf-8")
        stopwatch.lap("write")
        timing = _timing(result, stopwatch)
        (partial / TIMING_FILE).write_text(json_text(timing), encoding="utf-8")
        summary = _summary(mission, settings, seed, digests, config_text, result, estimate, evaluation, timing, warnings, lost)
        summary.update(survey)
        (partial / SUMMARY_FILE).write_text(json_text(summary), encoding="utf-8")
        for text in lost:
            session.log("lost", level="warning", text=text)
        session.log("run finished", steps=summary["steps"], time_total_s=summary["time_total_s"])
        (partial / LOG_FILE).write_text(session.log_lines(), encoding="utf-8")
    return FinishedRun(out, summary, lost)


def run_estimator(settings: Mapping[str, Any], log: Any, seed: int, progress: Callable[[float], bool]) -> dict[str, Any]:
    try:
        if isinstance(log, _core.NavigationLog):
            return _core.run_levelled(levelled_values(settings), log, progress, seed)
        return _core.run(FrameSettings(settings).of_estimator, log, seed, progress)
    except ValueError as error:
        raise UserError(f"the estimator refused the mission: {error}; check the noise settings and the data") from error


def doubtful_navigation(mission: Mission, result: Mapping[str, Any]) -> list[str]:
    """What makes the track of an underwater vehicle worth little: no velocity over the bottom, a compass that jumps, and sensors that the
    filter hardly believes, because their noise, or another's, is not what the settings say."""
    texts: list[str] = []
    if mission.odometry is not None or mission.has_frames_alone:
        return texts
    if mission.navigation is not None and (mission.navigation.velocity is None or not mission.navigation.velocity.bottom_lock.any()):
        texts.append("no velocity over the bottom: the vehicle is taken to keep the speed it starts with (start.speed_m_s)")
    if mission.navigation is not None and mission.navigation.fixes is not None and not result.get("fixes"):
        texts.append(f"no position fix of {POSITION_FIXES_FILE} was used: only the method ssjs takes them, with split.fix_interval_s set")
    for fix in result.get("fixes", []):
        if fix["relocated"]:
            texts.append(
                f"by the position fixes about {fix['time_s']:.0f} s the track was {fix['distance_m']:.0f} m off, more than it knew of: it "
                "goes on from the fixes; look for a sensor that failed before, or for fixes in another frame"
            )
    jumps = result["counters"].get("compass_jumps", 0)
    if jumps:
        texts.append(f"the compass offset jumped between {jumps} submaps; check the compass, or its drift (motion.compass_walk_rad_sqrt_s)")
    unsound = result["counters"].get("unsound_maps", 0)
    if unsound:
        texts.append(
            f"in {unsound} submaps the filter lost its footing and nothing they say was believed; look for noise settings that are "
            "far too small"
        )
    for name, sensor in result.get("sensors", {}).items():
        total = sensor["used"] + sensor["refused"]
        if total and sensor["refused"] > MAX_REFUSED_FRACTION * total:
            texts.append(
                f"{sensor['refused']} of {total} samples of {name} lie outside its gate; check its mounting and noise ({name}.*), and the "
                "walks in motion.*"
            )
    return texts


def _calibrated(settings: Settings, log: Any, seed: int, session: Session) -> Settings:
    from ssjs_cli.calibrate import calibrate, expected_runs, plan_for

    plan = plan_for(settings)
    total_runs, finished_runs = expected_runs(plan), 0
    with interruptible("calibrating") as progress:

        def nis_of(values: Mapping[str, Any]) -> tuple[Any, Any]:
            nonlocal finished_runs
            result = run_estimator(
                {**values, SMOOTHING_KEY: False}, log, seed, lambda fraction: progress((finished_runs + fraction) / total_runs)
            )
            finished_runs += 1
            updates = result["updates"]
            return np.asarray(updates["nis"], dtype=np.float64), np.asarray(updates["dof"], dtype=np.int64)

        calibration = calibrate(settings, nis_of, plan)
    for key, value in calibration.changes.items():
        scanned = [[entry.value, entry.cost] for entry in calibration.scanned[key]]
        session.log("calibrated", key=key, value=value, scanned=scanned)
        session.message(f"calibrated {key} = {value:.6g}")
    return settings.replaced(calibration.changes, "--calibrate")


def _summary(
    mission: Mission,
    settings: Settings,
    seed: int,
    digests: Mapping[str, str],
    config_text: str,
    result: Mapping[str, Any],
    estimate: Estimate,
    evaluation: Evaluation,
    timing: Mapping[str, Any],
    warnings: Sequence[str],
    lost: Sequence[str],
) -> dict[str, Any]:
    summary: dict[str, Any] = {
        "mission": mission.name,
        "method": settings.method,
        "association": settings.values[ASSOCIATION_KEY],
        "version": _core.version(),
        "seed": seed,
        "input_digests": dict(digests),
        "config_digest": hashlib.sha256(config_text.encode("utf-8")).hexdigest(),
        "landmark_ids": "source" if estimate.landmarks.ids_are_of_source else "row",
    }
    if mission.odometry is None and not mission.has_frames_alone:
        summary["axis_names"] = ["x, ahead at the start", "y, starboard at the start"] if mission.geodetic is None else ["north", "east"]
        summary["sensors"] = numbers_of(result["sensors"])
        summary["geodetic"] = None if mission.geodetic is None else mission.geodetic.model_dump(exclude_none=True)
    summary.update(measures(result, evaluation, timing))
    summary["warnings"] = list(warnings)
    summary["lost"] = list(lost)
    return summary


def _timing(result: Mapping[str, Any], stopwatch: _Stopwatch) -> dict[str, Any]:
    usage = resource.getrusage(resource.RUSAGE_SELF)
    timing = run_times(result)
    timing["wall_s"] = round(time.perf_counter() - stopwatch.started_s, 6)
    timing["cpu_user_s"], timing["cpu_system_s"] = round(usage.ru_utime, 6), round(usage.ru_stime, 6)
    timing["parts"] = dict(stopwatch.parts_s)
    return timing
