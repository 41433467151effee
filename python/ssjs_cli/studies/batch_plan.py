"""What a batch has to do: the run of every mission that can be read, and which of them are finished."""

import shutil
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ssjs_cli.errors import UserError
from ssjs_cli.formats.file_digest import file_digest
from ssjs_cli.formats.mission import input_digests, is_mission_file, mission_directory, read_mission_outline
from ssjs_cli.formats.run_directory import SUMMARY_FILE
from ssjs_cli.mission_run import RunRequest, model_digests, path_name, resolve_settings
from ssjs_cli.progress import interruptible
from ssjs_cli.studies.carry_out import PlannedRun
from ssjs_cli.studies.executor import Executor, Record
from ssjs_cli.studies.mission_manifest import MissionManifest, signature_of
from ssjs_cli.studies.single_run import core_identity
from ssjs_cli.studies.study_folder import RUNS_FOLDER, StudyFolder, key_of

MISSIONS_FOLDER = "missions"
NAME_DIGITS = 12
LEFT_BEHIND = (".partial", ".replaced")


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

    @property
    def digest(self) -> str:
        """Of all that determines the runs beside the missions themselves."""
        config = None if self.config_path is None or not self.config_path.is_file() else file_digest(self.config_path)
        return key_of(
            {
                **core_identity(),
                "method": self.method,
                "association": self.association,
                "config": config,
                "assignments": list(self.assignments),
                "seed": self.seed,
                "report": self.with_reports,
            }
        )


@dataclass(frozen=True)
class MissionTask:
    """One mission, as a worker takes it: the paths are absolute, on a disk that all workers see. version: as in RunTask."""

    request: RunRequest
    version: str
    with_report: bool


@dataclass(frozen=True)
class BatchRun:
    """The run of one mission. plan: what a worker would need, absent where the record is there."""

    mission: str
    key: str
    plan: PlannedRun | None

    @property
    def directory(self) -> str:
        """In the folder of the batch."""
        return f"{MISSIONS_FOLDER}/{path_name(self.mission)}-{self.key[:NAME_DIGITS]}"


@dataclass
class BatchPlan:
    """runs and reasons by the path of the mission: each has one or the other. finished: records by the key of the run."""

    runs: dict[Path, BatchRun] = field(default_factory=dict)
    reasons: dict[Path, str] = field(default_factory=dict)
    finished: dict[str, Record] = field(default_factory=dict)

    @property
    def missing(self) -> list[PlannedRun]:
        return [run.plan for run in self.runs.values() if run.plan is not None]


def plan_batch(request: BatchRequest, out: Path, folder: StudyFolder) -> BatchPlan:
    """A mission is looked at when its files, or what is asked for, are not those of an earlier call, or its run is not finished."""
    planned = BatchPlan()
    (out / MISSIONS_FOLDER).mkdir(exist_ok=True)
    _remove_unfinished(out / MISSIONS_FOLDER)
    manifest = MissionManifest.read(out, request.digest)
    paths = request.mission_paths
    with interruptible("reading the missions") as progress:
        for position, path in enumerate(paths):
            if not progress(position / len(paths)):
                break
            try:
                planned.runs[path] = _run_of(request, path, out, folder, manifest, planned.finished)
            except UserError as error:
                planned.reasons[path] = str(error)
    manifest.write(out)
    return planned


def _run_of(
    request: BatchRequest, path: Path, out: Path, folder: StudyFolder, manifest: MissionManifest, finished: dict[str, Record]
) -> BatchRun:
    directory = mission_directory(path)
    known = manifest.find(directory)
    if known is not None:
        run = BatchRun(known.mission, known.key, None)
        if _is_finished(run, out, folder, finished):
            return run
    signature = signature_of(directory, settled=True)
    plan = _plan(request, directory, out)
    key = plan.key
    run = BatchRun(plan.identity["mission"], key, None)
    if all(is_mission_file(name) for name in plan.identity["files"]):  # a model elsewhere may change under the same signature
        manifest.note(directory, signature, run.mission, key)
    return run if _is_finished(run, out, folder, finished) else replace(run, plan=plan)


def _is_finished(run: BatchRun, out: Path, folder: StudyFolder, finished: dict[str, Record]) -> bool:
    """A mission whose run directory is gone is done again."""
    record = folder.finished([run.key]).get(run.key)
    if record is None:
        return False
    if "results" in record and not (out / run.directory / SUMMARY_FILE).is_file():
        (folder.path / RUNS_FOLDER / f"{run.key}.json").unlink(missing_ok=True)
        return False
    finished[run.key] = record
    return True


def _plan(request: BatchRequest, directory: Path, out: Path) -> PlannedRun:
    mission = read_mission_outline(directory)
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
    identity: dict[str, Any] = {
        **core_identity(),
        "mission": mission.name,
        "files": {**input_digests(directory), **model_digests(settings)},
        "seed": seed,
        "settings": dict(settings.values),
        "report": request.with_reports,
    }
    target = (out / BatchRun(mission.name, key_of(identity), None).directory).resolve()
    return PlannedRun(identity, MissionTask(replace(run, out=target), core_identity()["version"], request.with_reports))


def _remove_unfinished(missions: Path) -> None:
    """What a killed worker has left: nobody else is at work here, the lock says so."""
    for entry in missions.iterdir():
        if entry.name.startswith(".") and entry.name.endswith(LEFT_BEHIND):
            shutil.rmtree(entry, ignore_errors=True)
