"""One run of a study, as a worker carries it out: a mission from disk or simulated on the spot, estimated, judged, and put in a record."""

import hashlib
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from types import MappingProxyType, TracebackType
from typing import Literal

from ssjs_cli import _core
from ssjs_cli.camera.frame_reading import with_keypoints
from ssjs_cli.config import Scalar, Settings
from ssjs_cli.errors import UserError
from ssjs_cli.evaluation import evaluate
from ssjs_cli.formats.mission import Mission, read_mission
from ssjs_cli.formats.run_directory import estimate_of
from ssjs_cli.mission_run import build_log, run_estimator, with_contacts
from ssjs_cli.optical.frame_settings import FrameSettings
from ssjs_cli.run_measures import measures, run_times
from ssjs_cli.simulation import Scenario, simulate_mission
from ssjs_cli.studies import curves
from ssjs_cli.studies.executor import Record, TimeLimitError, time_limit_reason

Detail = Literal["numbers", "consistency", "all"]


@dataclass(frozen=True)
class RunTask:
    """source: a mission directory, or a scenario with its seed. settings: every setting, resolved. version: of the core that planned
    the run; a worker with another one refuses. detail: which curves the record keeps. time_limit_s: wall time of the run, None for no
    limit; it changes no result, only whether there is one."""

    source: str | Scenario
    settings: Mapping[str, Scalar]
    seed: int
    version: str
    detail: Detail
    time_limit_s: float | None = None


def perform(task: RunTask) -> Record:
    if _core.version() != task.version:
        raise UserError(f"the worker has ssjs {_core.version()} and this study {task.version}; install the same version at the workers")
    limit = _TimeLimit(task.time_limit_s)
    lost: list[str] = []
    mission, where = _mission_of(task, lost)
    log = build_log(mission, Settings(task.settings), where, lost)
    with limit:
        result = run_estimator(task.settings, log, task.seed, limit.progress)
    timing = run_times(result)
    estimate = estimate_of(result)
    evaluation = evaluate(estimate, mission.reference)
    record: Record = {"summary": measures(result, evaluation, timing), "lost": [*lost, *evaluation.lost]}
    record["summary"]["live_maps"] = len(result["live_maps"])
    if task.detail == "numbers":
        return record
    over_time = {"nees": curves.nees_over_time(estimate, mission.reference), "nis": curves.nis_over_time(result)}
    if task.detail == "all":
        over_time["time"] = curves.cumulative_time(result)
        over_time["error"] = curves.error_over_time(evaluation)
        unit = FrameSettings(task.settings).length_unit if mission.has_frames_alone else "m"
        record["map"] = {**curves.map_of(estimate, evaluation), "unit": unit}
    record["time_origin_s"] = curves.time_origin_s(result)
    record.update(curves.counted_from(record["time_origin_s"], over_time))
    return record


class _TimeLimit:
    """The progress callback of a run, which asks it to stop once its time is over. Around the estimator: its answer to that becomes a
    TimeLimitError."""

    def __init__(self, time_limit_s: float | None) -> None:
        self._time_limit_s = time_limit_s
        self._began_s = time.monotonic()
        self._fraction = 0.0
        self._is_over = False

    def progress(self, fraction: float) -> bool:
        self._fraction = fraction
        self._is_over = self._time_limit_s is not None and time.monotonic() - self._began_s > self._time_limit_s
        return not self._is_over

    def __enter__(self) -> None:
        return None

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self._is_over and self._time_limit_s is not None and isinstance(error, KeyboardInterrupt):
            done = f"{100.0 * self._fraction:.1f} % of the mission done" if self._fraction < 1.0 else "in the last adjustment"
            raise TimeLimitError(time_limit_reason(self._time_limit_s, done)) from None


def _mission_of(task: RunTask, lost: list[str]) -> tuple[Mission, Path]:
    """With what was found in its sonar logs and frames; those of a simulated mission are gone once they have been searched."""
    if not isinstance(task.source, Scenario):
        return _searched(read_mission(Path(task.source)), task, lost), Path(task.source)
    mission, where = simulate_mission(task.source), Path(f"scenario {task.source.name}")
    if mission.recording is None and mission.photographs is None:
        return mission, where
    with TemporaryDirectory(prefix="ssjs-") as folder:
        if mission.recording is not None:
            mission.recording(Path(folder))
            mission = replace(mission, sonar_logs=sorted(Path(folder).iterdir()))
        if mission.photographs is not None and mission.frames is not None:
            mission.photographs(Path(folder))
            mission = replace(mission, frames=replace(mission.frames, folder=Path(folder)))
        return _searched(mission, task, lost), where


def _searched(mission: Mission, task: RunTask, lost: list[str]) -> Mission:
    mission, _ = with_contacts(mission, task.settings, lost)
    return with_keypoints(mission, task.settings, lost)[0]


@cache
def core_identity() -> Mapping[str, str]:
    """What of the program determines a result: its version, and the compiled estimator itself, which may be rebuilt under one version."""
    library = Path(str(_core.__file__))
    return MappingProxyType({"version": _core.version(), "core": hashlib.sha256(library.read_bytes()).hexdigest()[:16]})
