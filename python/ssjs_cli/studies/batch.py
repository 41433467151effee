"""Many missions, each with the whole of `run`: a run directory for every one, a table of the season, and one map."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ssjs_cli import _core
from ssjs_cli.errors import UserError
from ssjs_cli.formats.run_directory import MEASURED_KEYS, REFERENCE_KEYS
from ssjs_cli.mission_run import run_mission
from ssjs_cli.run_summary import build_run_report
from ssjs_cli.session import Session
from ssjs_cli.studies.batch_plan import MISSIONS_FOLDER, BatchPlan, BatchRequest, MissionTask, plan_batch
from ssjs_cli.studies.carry_out import REFUSED, CarriedOut, carry_out
from ssjs_cli.studies.executor import Record
from ssjs_cli.studies.mission_manifest import MANIFEST_FILE
from ssjs_cli.studies.season import worst_first
from ssjs_cli.studies.season_output import CONTACTS_CSV_FILE, CONTACTS_GEOJSON_FILE, MAP_FILE, REPORT_FILE, write_season
from ssjs_cli.studies.study_folder import STUDY_FILE, open_study
from ssjs_cli.studies.tables import csv_text, json_text

SEASON_FILE = "season.json"
TABLE_FILE = "season.csv"
OUTPUTS = (
    SEASON_FILE, TABLE_FILE, REPORT_FILE, MAP_FILE, CONTACTS_CSV_FILE, CONTACTS_GEOJSON_FILE, MISSIONS_FOLDER, MANIFEST_FILE,
)  # fmt: skip
RESULT_KEYS = (*MEASURED_KEYS, *REFERENCE_KEYS, "nis_mean", "nis_inside_fraction", "time_total_s", "peak_rss_mb")
KEYS = ("mission", "path", "reason", "outlier_score", "stands_out_by", "warnings", "lost", "directory", *RESULT_KEYS)


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
        plan = plan_batch(request, out, folder)
        done = carry_out(
            perform_mission, plan.missing, request.executor, folder, "running the missions", session, finished=len(plan.finished)
        )
        season = _assembled(request.mission_paths, out, plan, done)
        folder.write(SEASON_FILE, json_text(season.document))
        folder.write(TABLE_FILE, csv_text(KEYS, season.rows))
        write_season(out, season.rows, folder)
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


def _assembled(paths: Iterable[Path], out: Path, plan: BatchPlan, done: CarriedOut) -> Season:
    rows: list[dict[str, Any]] = []
    lost: list[str] = []
    for path in paths:
        row: dict[str, Any] = {**dict.fromkeys(KEYS), "mission": path.name, "path": path.as_posix()}
        run = plan.runs.get(path)
        record: Record | None = None
        if run is None:
            row["reason"] = plan.reasons.get(path)
        else:
            row["mission"] = run.mission
            record = plan.finished.get(run.key) or done.records.get(run.key)
            row["reason"] = done.reasons.get(run.key) or (record or {}).get(REFUSED)
        if run is not None and record is not None and "results" in record:
            row.update(record["results"])
            row["warnings"], row["lost"] = len(record["warnings"]), len(record["lost"])
            row["directory"] = run.directory
        elif row["reason"]:
            lost.append(f"{path}: {row['reason']}")
        rows.append(row)
    return Season(out, worst_first(rows), lost)
