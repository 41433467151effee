"""Many missions, each with the whole of `run`: a run directory for every one, a table of the season, what stands out on top."""

import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ssjs_cli import _core
from ssjs_cli.errors import UserError
from ssjs_cli.formats.mission import input_digests, mission_directory, read_mission
from ssjs_cli.formats.run_directory import MEASURED_KEYS, REFERENCE_KEYS, SUMMARY_FILE
from ssjs_cli.mission_run import RunRequest, model_digests, path_name, resolve_settings, run_mission
from ssjs_cli.progress import interruptible
from ssjs_cli.run_summary import build_run_report
from ssjs_cli.session import Session
from ssjs_cli.studies.carry_out import CarriedOut, PlannedRun, carry_out
from ssjs_cli.studies.executor import Executor, Record
from ssjs_cli.studies.season import worst_first
from ssjs_cli.studies.single_run import core_identity
from ssjs_cli.studies.study_folder import RUNS_FOLDER, STUDY_FILE, StudyFolder, key_of, open_study
from ssjs_cli.studies.tables import csv_text, json_text

SEASON_FILE = "season.json"
TABLE_FILE = "season.csv"
REPORT_FILE = "report.html"
MISSIONS_FOLDER = "missions"
NAME_DIGITS = 12
OUTPUTS = (SEASON_FILE, TABLE_FILE, REPORT_FILE, MISSIONS_FOLDER)
RESULT_KEYS = (*MEASURED_KEYS, *REFERENCE_KEYS, "nis_mean", "nis_inside_fraction", "time_total_s", "peak_rss_mb")
KEYS = ("mission", "path", "reason", "outlier_score", "stands_out_by", "warnings", "lost", "directory", *RESULT_KEYS)


@dataclass(frozen=True)
class BatchRequest:
    mission_paths: Sequence[Path]
    executor: Executor
    method: str | None = None
    association: str | None = None
    config_path: Path | None = None
    assignments: Sequence[str] = ()
    seed: int | None = None
    out: Path | None = None
    force: bool = False
    resume: bool = False
    with_reports: bool = True


@dataclass(frozen=True)
class MissionTask:
    """One mission, as a worker takes it: the paths are absolute, on a disk that all workers see. version: as in RunTask."""

    request: RunRequest
    version: str
    with_report: bool


@dataclass
class Season:
    """rows: one a mission, every key of KEYS, the worst first."""

    folder: Path
    rows: list[dict[str, Any]]
    lost: list[str] = field(default_factory=list)

    @property
    def document(self) -> dict[str, Any]:
        return {"missions": self.rows}


def run_batch(request: BatchRequest, session: Session) -> Season:
    out = request.out or Path("runs") / "batch"
    if request.resume and not (out / STUDY_FILE).is_file():
        raise UserError(f"--resume: {out} holds no batch to go on with; name its folder with --out, or leave --resume out")
    session.fault_log = out.with_name(out.name + ".fault.jsonl")
    with open_study(out, {"study": "batch"}, outputs=OUTPUTS, force=request.force) as folder:
        (out / MISSIONS_FOLDER).mkdir(exist_ok=True)
        _remove_unfinished(out / MISSIONS_FOLDER)
        plans, reasons = _planned(request, out)
        _forget_lost_directories(folder, plans)
        done = carry_out(perform_mission, list(plans.values()), request.executor, folder, "running the missions", session)
        season = _assembled(request, out, plans, reasons, done)
        folder.write(SEASON_FILE, json_text(season.document))
        folder.write(TABLE_FILE, csv_text(KEYS, season.rows))
        from ssjs_cli.report.season_page import season_page

        folder.write(REPORT_FILE, season_page(season))
    return season


def perform_mission(task: MissionTask) -> Record:
    """In the worker: the run directory is there under its name only when it is whole."""
    if _core.version() != task.version:
        raise UserError(f"the worker has ssjs {_core.version()} and this batch {task.version}; install the same version at the workers")
    finished = run_mission(task.request, _SilentSession())
    if task.with_report:
        build_run_report(finished.directory)
    summary = finished.summary
    return {
        "results": {key: summary.get(key) for key in RESULT_KEYS},
        "warnings": list(summary["warnings"]),
        "lost": list(finished.lost),
    }


class _SilentSession(Session):
    """A worker says nothing: what there is to say is in the summary of the run."""

    def message(self, text: str) -> None:
        return None


def _planned(request: BatchRequest, out: Path) -> tuple[dict[Path, PlannedRun], dict[Path, str]]:
    """A run for every mission that can be read, and the reason why not for the others."""
    plans: dict[Path, PlannedRun] = {}
    reasons: dict[Path, str] = {}
    with interruptible("reading the missions") as progress:
        for position, path in enumerate(request.mission_paths):
            if not progress(position / len(request.mission_paths)):
                break
            try:
                plans[path] = _plan(request, path, out)
            except UserError as error:
                reasons[path] = str(error)
    return plans, reasons


def _plan(request: BatchRequest, path: Path, out: Path) -> PlannedRun:
    directory = mission_directory(path)
    mission = read_mission(directory)
    run = RunRequest(
        directory.resolve(),
        seed=request.seed,
        method=request.method,
        association=request.association,
        config_path=None if request.config_path is None else request.config_path.resolve(),
        assignments=request.assignments,
        force=True,  # what an earlier call left in this very place is the same run, broken off
    )
    settings, seed = resolve_settings(run, directory, mission)
    identity = {
        **core_identity(),
        "mission": mission.name,
        "files": {**input_digests(directory), **model_digests(settings)},
        "seed": seed,
        "settings": dict(settings.values),
        "report": request.with_reports,
    }
    key = key_of(identity)
    target = (out / MISSIONS_FOLDER / f"{path_name(mission.name)}-{key[:NAME_DIGITS]}").resolve()
    return PlannedRun(identity, MissionTask(replace(run, out=target), core_identity()["version"], request.with_reports))


def _remove_unfinished(missions: Path) -> None:
    """What a killed worker has left: nobody else is at work here, the lock says so."""
    for entry in (*missions.glob(".*.partial"), *missions.glob(".*.replaced")):
        shutil.rmtree(entry, ignore_errors=True)


def _forget_lost_directories(folder: StudyFolder, plans: Mapping[Path, PlannedRun]) -> None:
    """A mission whose run directory is gone is done again."""
    for plan in plans.values():
        record = folder.path / RUNS_FOLDER / f"{plan.key}.json"
        if (
            record.is_file()
            and "results" in folder.finished([plan.key]).get(plan.key, {})
            and not (plan.payload.request.out / SUMMARY_FILE).is_file()
        ):
            record.unlink()


def _assembled(request: BatchRequest, out: Path, plans: Mapping[Path, PlannedRun], reasons: Mapping[Path, str], done: CarriedOut) -> Season:
    rows: list[dict[str, Any]] = []
    lost: list[str] = []
    for path in request.mission_paths:
        row: dict[str, Any] = {**dict.fromkeys(KEYS), "mission": path.name, "path": path.as_posix()}
        plan = plans.get(path)
        row["reason"] = reasons.get(path) if plan is None else done.reasons.get(plan.key)
        if plan is not None:
            row["mission"] = plan.identity["mission"]
        if plan is not None and plan.key in done.records:
            record = done.records[plan.key]
            row.update(record["results"])
            row["warnings"], row["lost"] = len(record["warnings"]), len(record["lost"])
            row["directory"] = plan.payload.request.out.relative_to(out.resolve()).as_posix()
        elif row["reason"]:
            lost.append(f"{path}: {row['reason']}")
        rows.append(row)
    return Season(out, worst_first(rows), lost)
