"""One mission through several methods, repeated in turn, so that a busy moment of the machine does not hit one method alone."""

import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ssjs_cli import _core
from ssjs_cli.config import ASSOCIATION_KEY, Settings
from ssjs_cli.errors import UserError
from ssjs_cli.evaluation import POSE_DOF
from ssjs_cli.formats.mission import Mission, input_digests, mission_directory, read_mission
from ssjs_cli.formats.run_directory import MEASURED_KEYS, REFERENCE_KEYS, STEP_TIME_KEYS, TIME_KEYS
from ssjs_cli.methods import chosen_methods
from ssjs_cli.mission_run import RunRequest, model_digests, path_name, resolve_settings, settings_kind
from ssjs_cli.progress import working
from ssjs_cli.session import Session
from ssjs_cli.studies.carry_out import CarriedOut, PlannedRun, carry_out
from ssjs_cli.studies.executor import Record
from ssjs_cli.studies.process_pool import ProcessPool
from ssjs_cli.studies.single_run import RunTask, core_identity, perform
from ssjs_cli.studies.study_folder import canonical_text, key_of, open_study
from ssjs_cli.studies.tables import csv_text, json_text

COMPARISON_FILE = "comparison.json"
TABLE_FILE = "comparison.csv"
REPORT_FILE = "report.html"
OUTPUTS = (COMPARISON_FILE, TABLE_FILE, REPORT_FILE)
NIS_KEYS = ("nis_mean", "nis_inside_fraction", "nis_dof")
#: Differ between two equal runs: the median over the repeats is taken.
MEASURED_TIMES = (*TIME_KEYS, *STEP_TIME_KEYS, "peak_rss_mb")
BANDS = ("nees_band_low", "nees_band_high", "nis_band_low", "nis_band_high")
SUMMARY_KEYS = (*MEASURED_KEYS, "live_maps", *MEASURED_TIMES, *REFERENCE_KEYS, *NIS_KEYS, *BANDS, "half_chi2_initial", "half_chi2_final")
KEYS = ("method", "reason", "association", "repeats", *SUMMARY_KEYS)
BAND_PROBABILITY = 0.95


@dataclass(frozen=True)
class ComparisonRequest:
    """methods: "all" that are defined for the mission, or names with commas between them."""

    mission_path: Path
    methods: str
    repeats: int = 1
    association: str | None = None
    config_path: Path | None = None
    assignments: Sequence[str] = ()
    seed: int | None = None
    out: Path | None = None
    force: bool = False
    time_limit_s: float | None = None


@dataclass
class Comparison:
    """rows: one a method, every key of KEYS; records: the first record of each method that finished,
    with the time curve of its repeat in the middle."""

    folder: Path
    mission: Mission
    seed: int
    rows: list[dict[str, Any]]
    records: dict[str, Record]
    lost: list[str] = field(default_factory=list)

    @property
    def document(self) -> dict[str, Any]:
        return {"methods": self.rows}


def compare(request: ComparisonRequest, session: Session) -> Comparison:
    directory = mission_directory(request.mission_path)
    with working("reading the mission"):
        mission = read_mission(directory)
        digests = input_digests(directory)
    methods = chosen_methods(request.methods, settings_kind(mission))
    _, seed = _settings_for(None, request, directory, mission)  # a fault of the mission or the command is that of every method
    plans: dict[str, list[PlannedRun]] = {}
    reasons: dict[str, str] = {}
    associations: dict[str, Any] = {}
    for method in methods:
        try:
            settings, _ = _settings_for(method, request, directory, mission)
        except UserError as error:
            reasons[method] = str(error)
            continue
        associations[method] = settings.values[ASSOCIATION_KEY]
        plans[method] = [_planned(settings, seed, repeat, directory, mission, digests, request) for repeat in range(request.repeats)]
    runs = [plans[method][repeat] for repeat in range(request.repeats) for method in plans]
    definition = {
        "study": "comparison",
        "mission": mission.name,
        "methods": methods,
        "repeats": request.repeats,
        "seed": seed,
        **core_identity(),
        "mission files": dict(digests),
        "settings": key_of({method: dict(plans[method][0].payload.settings) for method in plans}),
    }
    out = request.out or Path("runs") / f"{path_name(mission.name)}-comparison"
    session.fault_log = out.with_name(out.name + ".fault.jsonl")
    with open_study(out, definition, outputs=OUTPUTS, force=request.force) as folder:
        done = carry_out(
            perform, runs, ProcessPool(1, fresh_processes=True, time_limit_s=request.time_limit_s), folder, "comparing", session
        )
        result = _assembled(methods, out, mission, seed, plans, associations, reasons, done)
        folder.write(COMPARISON_FILE, json_text(result.document))
        folder.write(TABLE_FILE, csv_text(KEYS, result.rows))
        with working("building the report"):
            from ssjs_cli.report.comparison_page import comparison_page

            folder.write(REPORT_FILE, comparison_page(result))
    return result


def _settings_for(method: str | None, request: ComparisonRequest, directory: Path, mission: Mission) -> tuple[Settings, int]:
    run = RunRequest(
        request.mission_path,
        seed=request.seed,
        method=method,
        association=request.association,
        config_path=request.config_path,
        assignments=request.assignments,
    )
    return resolve_settings(run, directory, mission)


def _planned(
    settings: Settings,
    seed: int,
    repeat: int,
    directory: Path,
    mission: Mission,
    digests: Mapping[str, str],
    request: ComparisonRequest,
) -> PlannedRun:
    values = dict(settings.values)
    core = core_identity()
    identity = {
        "detail": "all",
        **core,
        "mission": mission.name,
        "files": {**digests, **model_digests(settings)},
        "seed": seed,
        "repeat": repeat,
        "settings": values,
    }
    return PlannedRun(identity, RunTask(str(directory.resolve()), values, seed, core["version"], "all", request.time_limit_s))


def _assembled(
    methods: Sequence[str],
    out: Path,
    mission: Mission,
    seed: int,
    plans: Mapping[str, Sequence[PlannedRun]],
    associations: Mapping[str, Any],
    reasons: Mapping[str, str],
    done: CarriedOut,
) -> Comparison:
    rows: list[dict[str, Any]] = []
    records: dict[str, Record] = {}
    lost: list[str] = []
    for method in methods:
        row: dict[str, Any] = dict.fromkeys(KEYS)
        row["method"], row["association"] = method, associations.get(method)
        finished = [done.records[plan.key] for plan in plans.get(method, ()) if plan.key in done.records]
        failures = [done.reasons[plan.key] for plan in plans.get(method, ()) if plan.key in done.reasons]
        row["reason"] = reasons.get(method) or (failures[0] if failures else None)
        row["repeats"] = len(finished)
        if finished:
            records[method] = {**finished[0], "time": _typical(finished).get("time")}
            row.update(_measured(finished))
            lost += [f"{method}: {text}" for text in finished[0]["lost"]]
            if any(_comparable(record) != _comparable(finished[0]) for record in finished[1:]):
                lost.append(f"{method}: its repeats do not agree; the first is shown")
        if row["reason"]:
            lost.append(f"{method}: {row['reason']}")
        rows.append(row)
    return Comparison(out, mission, seed, rows, records, lost)


def _measured(finished: Sequence[Record]) -> dict[str, Any]:
    """Every key of the first repeat; of times and memory the median."""
    summary = {key: finished[0]["summary"].get(key) for key in SUMMARY_KEYS}
    for key in MEASURED_TIMES:
        values = [record["summary"][key] for record in finished if record["summary"].get(key) is not None]
        summary[key] = statistics.median(values) if values else None
    if summary["nees_mean"] is not None:
        # the single values: those of one run follow each other, so that no band holds for their mean
        tail = 0.5 * (1.0 - BAND_PROBABILITY)
        summary["nees_band_low"], summary["nees_band_high"] = (
            round(_core.chi_squared_quantile(probability, POSE_DOF), 6) for probability in (tail, 1.0 - tail)
        )
    if summary["nis_dof"]:
        # innovations are white: the mean over all of them has a band
        low, high = _core.mean_band(summary["nis_dof"], 1, BAND_PROBABILITY)
        summary["nis_band_low"], summary["nis_band_high"] = (round(bound / summary["nis_dof"], 6) for bound in (low, high))
    return summary


def _typical(finished: Sequence[Record]) -> Record:
    """The repeat in the middle by its total time."""
    return sorted(finished, key=lambda record: float(record["summary"]["time_total_s"] or 0.0))[len(finished) // 2]


def _comparable(record: Record) -> str:
    """All of a record that two equal runs share."""
    summary = {key: value for key, value in record["summary"].items() if key not in MEASURED_TIMES}
    return canonical_text({**{key: value for key, value in record.items() if key != "time"}, "summary": summary})
