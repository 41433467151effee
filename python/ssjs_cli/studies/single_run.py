"""One run of a study, as a worker carries it out: a mission from disk or simulated on the spot, estimated, judged, and put in a record."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Literal

from ssjs_cli import _core
from ssjs_cli.config import Scalar, Settings
from ssjs_cli.errors import UserError
from ssjs_cli.evaluation import evaluate
from ssjs_cli.formats.mission import Mission, read_mission
from ssjs_cli.formats.run_directory import estimate_of
from ssjs_cli.mission_run import build_log, run_estimator
from ssjs_cli.run_measures import measures, run_times
from ssjs_cli.simulation import Scenario, simulate_mission
from ssjs_cli.studies import curves
from ssjs_cli.studies.executor import Record

Detail = Literal["numbers", "consistency", "all"]


@dataclass(frozen=True)
class RunTask:
    """source: a mission directory, or a scenario with its seed. settings: every setting, resolved. version: of the core that planned
    the run; a worker with another one refuses. detail: which curves the record keeps."""

    source: str | Scenario
    settings: Mapping[str, Scalar]
    seed: int
    version: str
    detail: Detail


def perform(task: RunTask) -> Record:
    if _core.version() != task.version:
        raise UserError(f"the worker has ssjs {_core.version()} and this study {task.version}; install the same version at the workers")
    mission, where = _mission_of(task)
    lost: list[str] = []
    log = build_log(mission, Settings(task.settings), where, lost)
    result = run_estimator(task.settings, log, task.seed, lambda fraction: True)
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
        record["map"] = curves.map_of(estimate, evaluation)
    record["time_origin_s"] = curves.time_origin_s(result)
    record.update(curves.counted_from(record["time_origin_s"], over_time))
    return record


def _mission_of(task: RunTask) -> tuple[Mission, Path]:
    if isinstance(task.source, Scenario):
        return simulate_mission(task.source), Path(f"scenario {task.source.name}")
    return read_mission(Path(task.source)), Path(task.source)


@cache
def core_identity() -> Mapping[str, str]:
    """What of the program determines a result: its version, and the compiled estimator itself, which may be rebuilt under one version."""
    library = Path(str(_core.__file__))
    return MappingProxyType({"version": _core.version(), "core": hashlib.sha256(library.read_bytes()).hexdigest()[:16]})
