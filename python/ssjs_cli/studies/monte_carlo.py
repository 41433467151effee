"""Consistency over many seeds: does the covariance that a method claims describe the errors it makes? docs/math/evaluation.md (E-9)"""

import itertools
import statistics
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ssjs_cli import _core
from ssjs_cli.errors import UserError
from ssjs_cli.evaluation import POSE_DOF
from ssjs_cli.progress import working
from ssjs_cli.session import Session
from ssjs_cli.simulation import Scenario
from ssjs_cli.studies.carry_out import carry_out
from ssjs_cli.studies.executor import Record
from ssjs_cli.studies.scenario_runs import StudyRequest, definition_of, plan_scenario
from ssjs_cli.studies.single_run import perform
from ssjs_cli.studies.study_folder import key_of, open_study
from ssjs_cli.studies.tables import csv_text, json_text

CONSISTENCY_FILE = "consistency.json"
TABLE_FILE = "consistency.csv"
OVER_TIME_FILE = "consistency_over_time.csv"
RUNS_FILE = "consistency_runs.csv"
REPORT_FILE = "report.html"
OUTPUTS = (CONSISTENCY_FILE, TABLE_FILE, OVER_TIME_FILE, RUNS_FILE, REPORT_FILE)
DECIMALS = 6

KEYS = (
    "method",
    "reason",
    "runs",
    "nees_mean",
    "nees_dof",
    "nees_band_low",
    "nees_band_high",
    "nees_inside_fraction",
    "nees_online_mean",
    "nees_online_inside_fraction",
    "nees_joint_per_dof",
    "nees_joint_band_low",
    "nees_joint_band_high",
    "nees_base_mean",
    "nees_map_mean",
    "nees_position_per_dof",
    "inside_3_sigma_fraction",
    "nees_position_online_per_dof",
    "inside_3_sigma_online_fraction",
    "nis_mean",
    "nis_band_low",
    "nis_band_high",
    "nis_inside_fraction",
    "trajectory_rmse_m",
    "trajectory_online_rmse_m",
    "map_error_mean_m",
    "map_error_max_m",
    "wrong_pairs",
)
OVER_TIME_KEYS = ("method", "time_s", "runs", "nees_mean", "nees_online_mean", "band_low", "band_high")
RUN_KEYS = (
    "method",
    "seed",
    "reason",
    "nees_mean",
    "nees_inside_fraction",
    "nees_joint_per_dof",
    "nees_joint_dof",
    "nees_base_mean",
    "nees_map_mean",
    "nees_position_per_dof",
    "inside_3_sigma_fraction",
    "nees_position_online_per_dof",
    "inside_3_sigma_online_fraction",
    "nis_mean",
    "nis_inside_fraction",
    "nis_dof",
    "trajectory_rmse_m",
    "trajectory_online_rmse_m",
    "trajectory_max_m",
    "map_error_mean_m",
    "map_error_max_m",
    "landmarks_missed",
    "landmarks_false",
    "wrong_pairs",
    "loop_candidates",
    "loop_closures",
    "fusions",
)
#: Means over the runs, without a band of their own.
AVERAGED = (
    "nees_base_mean",
    "nees_map_mean",
    "nees_position_per_dof",
    "inside_3_sigma_fraction",
    "nees_position_online_per_dof",
    "inside_3_sigma_online_fraction",
    "nis_inside_fraction",
    "trajectory_rmse_m",
    "trajectory_online_rmse_m",
    "map_error_mean_m",
    "map_error_max_m",
    "wrong_pairs",
)


@dataclass
class ConsistencyStudy:
    """rows: one a method; over_time, runs: rows of the tables of those names; nis: (sum of NIS, of dof) in spans, by method."""

    folder: Path
    scenario: Scenario
    seeds: list[int]
    rows: list[dict[str, Any]]
    over_time: list[dict[str, Any]]
    runs: list[dict[str, Any]]
    nis: dict[str, dict[str, list[float]]]
    lost: list[str] = field(default_factory=list)

    @property
    def document(self) -> dict[str, Any]:
        return {"scenario": self.scenario.name, "seeds": self.seeds, "methods": self.rows, "runs": self.runs}


def study_consistency(request: StudyRequest, session: Session) -> ConsistencyStudy:
    executor = request.executor()
    plan = plan_scenario(request)
    settings, refused = {}, {}
    plan.settings(request, None, {})  # a fault of the command is that of every method
    for method in request.methods:
        try:
            settings[method] = plan.settings(request, method, {})
        except UserError as error:
            refused[method] = str(error)
    planned = {
        method: [plan.run(chosen, seed, "consistency", request.time_limit_s) for seed in plan.seeds] for method, chosen in settings.items()
    }
    out = request.folder(plan.scenario, "consistency")
    session.fault_log = out.with_name(out.name + ".fault.jsonl")
    digest = key_of({method: dict(chosen.values) for method, chosen in settings.items()})
    definition = definition_of("consistency", request, plan, settings=digest)
    with open_study(out, definition, outputs=OUTPUTS, force=request.force) as folder:
        runs = [planned[method][number] for number in range(request.runs) for method in planned]
        done = carry_out(perform, runs, executor, folder, "consistency", session)
        study = ConsistencyStudy(out, plan.scenario, plan.seeds, [], [], [], {})
        for method in request.methods:
            keys = [run.key for run in planned.get(method, [])]
            records = [done.records[key] for key in keys if key in done.records]
            for seed, key in zip(plan.seeds, keys, strict=False):
                study.runs.append(_run_row(method, seed, done.records.get(key), done.reasons.get(key)))
            failures = [done.reasons[key] for key in keys if key in done.reasons]
            reason = refused.get(method) or (f"{len(failures)} of {len(keys)} runs failed: {failures[0]}" if failures else None)
            if reason:
                study.lost.append(f"{method}: {reason}")
            over_time = nees_over_time(method, records)
            study.over_time += over_time
            study.nis[method] = _nis_sums(records)
            study.rows.append(_method_row(method, reason, records, over_time))
        folder.write(CONSISTENCY_FILE, json_text(study.document))
        folder.write(TABLE_FILE, csv_text(KEYS, study.rows))
        folder.write(OVER_TIME_FILE, csv_text(OVER_TIME_KEYS, study.over_time))
        folder.write(RUNS_FILE, csv_text(RUN_KEYS, study.runs))
        with working("building the report"):
            from ssjs_cli.report.consistency_page import consistency_page

            folder.write(REPORT_FILE, consistency_page(study))
    return study


def _run_row(method: str, seed: int, record: Record | None, reason: str | None) -> dict[str, Any]:
    summary = {} if record is None else record["summary"]
    return {**{key: summary.get(key) for key in RUN_KEYS}, "method": method, "seed": seed, "reason": reason}


def nees_over_time(method: str, records: Sequence[Record]) -> list[dict[str, Any]]:
    """Mean pose NEES over the runs at each instant that all of them share, with the 95 % band of the mean of so many values. An instant
    at which some run has no value (the start, exact by definition) is left out."""
    curves = [record["nees"] for record in records if record.get("nees")]
    if not curves or len(curves) < len(records):
        return []
    final, online = ([dict(zip(curve["time_s"], curve[name], strict=True)) for curve in curves] for name in ("final", "online"))
    band_low, band_high = _rounded_pair(_core.mean_band(POSE_DOF, len(curves)))
    rows = []
    for time_s in curves[0]["time_s"]:
        values = [curve.get(time_s) for curve in final]
        if any(value is None for value in values):
            continue
        row: dict[str, Any] = {"method": method, "time_s": time_s, "runs": len(values), "nees_mean": _mean(values)}
        row["nees_online_mean"] = _mean([curve.get(time_s) for curve in online])
        rows.append({**row, "band_low": band_low, "band_high": band_high})
    return rows


def _method_row(method: str, reason: str | None, records: Sequence[Record], over_time: Sequence[dict[str, Any]]) -> dict[str, Any]:
    row: dict[str, Any] = dict.fromkeys(KEYS)
    row.update({"method": method, "reason": reason, "runs": len(records)})
    summaries = [record["summary"] for record in records]
    for key in AVERAGED:
        row[key] = _mean([summary.get(key) for summary in summaries])
    if over_time:
        low, high = over_time[0]["band_low"], over_time[0]["band_high"]
        row.update({"nees_dof": POSE_DOF, "nees_band_low": low, "nees_band_high": high})
        for name, source in (("nees", "nees_mean"), ("nees_online", "nees_online_mean")):
            values = [entry[source] for entry in over_time if entry[source] is not None]
            if values:
                row[f"{name}_mean"] = _mean(values)
                row[f"{name}_inside_fraction"] = round(sum(low <= value <= high for value in values) / len(values), DECIMALS)
    joint = [
        (summary["nees_joint_per_dof"], summary["nees_joint_dof"]) for summary in summaries if summary.get("nees_joint_per_dof") is not None
    ]
    if joint:
        # sums of independent chi-squared values; runs have different numbers of bases
        dof = sum(count for _, count in joint)
        row["nees_joint_per_dof"] = round(sum(value * count for value, count in joint) / dof, DECIMALS)
        row["nees_joint_band_low"], row["nees_joint_band_high"] = _rounded_pair(_core.mean_band(dof, 1), dof)
    updates = [(summary["nis_mean"], summary["nis_dof"]) for summary in summaries if summary.get("nis_dof")]
    if updates:
        dof = sum(count for _, count in updates)
        row["nis_mean"] = round(sum(value * count for value, count in updates) / dof, DECIMALS)
        row["nis_band_low"], row["nis_band_high"] = _rounded_pair(_core.mean_band(dof, 1), dof)
    return row


def _nis_sums(records: Sequence[Record]) -> dict[str, list[float]]:
    """Runs of one scenario last about equally long: their spans begin alike, and some have one more."""
    curves = [record["nis"] for record in records if record.get("nis")]
    if not curves:
        return {}
    longest = max((curve["time_s"] for curve in curves), key=len)
    columns = {name: itertools.zip_longest(*(curve[name] for curve in curves), fillvalue=0.0) for name in ("nis", "dof")}
    return {"time_s": longest, **{name: [round(sum(values), DECIMALS) for values in column] for name, column in columns.items()}}


def _mean(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return round(statistics.fmean(known), DECIMALS) if known else None


def _rounded_pair(band: tuple[float, float], divisor: float = 1.0) -> tuple[float, float]:
    return round(band[0] / divisor, DECIMALS), round(band[1] / divisor, DECIMALS)
