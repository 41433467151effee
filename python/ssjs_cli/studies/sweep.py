"""Cost, accuracy and consistency over the two values that tune submap joining: how large a submap grows, and how much two must share to
be fused."""

import itertools
import statistics
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ssjs_cli.config import UNDERWATER, Scalar, SettingsKind, field_descriptions
from ssjs_cli.errors import UserError
from ssjs_cli.formats.run_directory import TIME_KEYS
from ssjs_cli.progress import working
from ssjs_cli.session import Session
from ssjs_cli.simulation import Scenario
from ssjs_cli.studies.carry_out import carry_out
from ssjs_cli.studies.executor import Record
from ssjs_cli.studies.scenario_runs import StudyRequest, definition_of, plan_scenario
from ssjs_cli.studies.single_run import perform
from ssjs_cli.studies.study_folder import key_of, open_study
from ssjs_cli.studies.tables import csv_text, json_text

SWEEP_FILE = "sweep.json"
TABLE_FILE = "sweep.csv"
REPORT_FILE = "report.html"
OUTPUTS = (SWEEP_FILE, TABLE_FILE, REPORT_FILE)
DECIMALS = 6
MEANS = (
    "loop_candidates",
    "loop_closures",
    "fusions",
    "submaps",
    "live_maps",
    "wrong_pairs",
    "map_error_mean_m",
    "map_error_max_m",
    "trajectory_rmse_m",
    "nees_joint_per_dof",
    "nees_mean",
    "nees_position_per_dof",
    "inside_3_sigma_fraction",
    "nees_position_online_per_dof",
    "inside_3_sigma_online_fraction",
)
KEYS = ("method", "submap_size", "fusion_threshold", "runs", "reason", *TIME_KEYS, *MEANS)


@dataclass(frozen=True)
class Axes:
    """What the two values are for one kind of mission. sizes are of `unit`; laid_aside: other settings that would cut a submap short."""

    size_key: str
    unit: str
    threshold_key: str
    laid_aside: Callable[[float], Mapping[str, Scalar]]

    def changes(self, size: float, threshold: float) -> dict[str, Scalar]:
        return {self.size_key: size, self.threshold_key: threshold, **self.laid_aside(size)}


PLANAR_AXES = Axes("submap.max_landmarks", "landmarks", "joining.fusion_threshold", lambda _: {})
#: A levelled submap grows by the way: what sonar abeam sees of it are few landmarks, seldom seen again in the same map.
UNDERWATER_AXES = Axes(
    "split.max_distance_m",
    "m",
    "fusing.fusion_threshold",
    lambda size: {"split.longest_m": 2.0 * size, "split.max_landmarks": None, "split.max_sigma_xy_m": None},
)


def axes_of(kind: SettingsKind) -> Axes:
    return UNDERWATER_AXES if kind is UNDERWATER else PLANAR_AXES


@dataclass
class Sweep:
    """cells: one a method and pair of values. workers: how many runs stood side by side while the times were taken; None: unknown."""

    folder: Path
    scenario: Scenario
    seeds: list[int]
    methods: list[str]
    axes: Axes
    sizes: list[float]
    thresholds: list[float]
    cells: list[dict[str, Any]]
    workers: int | None
    lost: list[str] = field(default_factory=list)

    @property
    def document(self) -> dict[str, Any]:
        axes = {"submap_sizes": self.sizes, "fusion_thresholds": self.thresholds}
        return {"scenario": self.scenario.name, "seeds": self.seeds, **axes, "cells": self.cells}


def listed_values(flag: str, key: str, text: str, kind: SettingsKind) -> list[Any]:
    """ "10,15,20" as values of a setting, each once, ascending."""
    number, wanted = (int, "whole number") if field_descriptions(kind)[key].type in ("int", "optional_int") else (float, "number")
    values = []
    for part in (part.strip() for part in text.split(",") if part.strip()):
        try:
            value = number(part)
        except ValueError:
            raise UserError(f"{flag}: '{part}' is no {wanted}; give values of {key} with commas between them") from None
        if value in values:
            raise UserError(f"{flag}: names {part} twice; name each value once")
        values.append(value)
    if not values:
        raise UserError(f"{flag}: names no value; give values of {key} with commas between them")
    return sorted(values)


def sweep(request: StudyRequest, sizes: Sequence[float], thresholds: Sequence[float] | None, session: Session) -> Sweep:
    """thresholds None: the one that the settings name."""
    executor = request.executor()
    plan = plan_scenario(request)
    axes = axes_of(plan.scenario.kind)
    if thresholds is None:
        thresholds = [float(plan.settings(request, None, {}).values[axes.threshold_key] or 0.0)]
    places = list(itertools.product(request.methods, sizes, thresholds))
    planned = {}
    for place in places:
        method, size, threshold = place
        settings = plan.settings(request, method, axes.changes(size, threshold), "--submap-size, --fusion-threshold")
        planned[place] = [plan.run(settings, seed, "numbers", request.time_limit_s) for seed in plan.seeds]
    out = request.folder(plan.scenario, "sweep")
    session.fault_log = out.with_name(out.name + ".fault.jsonl")
    digest = key_of({"settings": [dict(planned[place][0].payload.settings) for place in places]})
    swept = {axes.size_key: list(sizes), axes.threshold_key: list(thresholds), "settings": digest}
    with open_study(out, definition_of("sweep", request, plan, **swept), outputs=OUTPUTS, force=request.force) as folder:
        runs = [planned[place][number] for number in range(request.runs) for place in places]
        done = carry_out(perform, runs, executor, folder, "sweep", session)
        workers = None if request.scheduler is not None else executor_width(request, len(runs))
        result = Sweep(out, plan.scenario, plan.seeds, list(request.methods), axes, list(sizes), list(thresholds), [], workers)
        for place in places:
            keys = [run.key for run in planned[place]]
            failures = [done.reasons[key] for key in keys if key in done.reasons]
            cell = _cell(place, [done.records[key] for key in keys if key in done.records], failures)
            result.cells.append(cell)
            if cell["reason"]:
                result.lost.append(f"{place[0]}, submap size {place[1]:g}, threshold {place[2]:g}: {cell['reason']}")
        folder.write(SWEEP_FILE, json_text(result.document))
        folder.write(TABLE_FILE, csv_text(KEYS, result.cells))
        with working("building the report"):
            from ssjs_cli.report.sweep_page import sweep_page

            folder.write(REPORT_FILE, sweep_page(result))
    return result


def executor_width(request: StudyRequest, runs: int) -> int:
    from ssjs_cli.studies.scenario_runs import cores

    return min(request.workers if request.workers is not None else cores(), runs)


def _cell(place: tuple[str, float, float], records: Sequence[Record], failures: Sequence[str]) -> dict[str, Any]:
    method, size, threshold = place
    cell: dict[str, Any] = dict.fromkeys(KEYS)
    cell.update({"method": method, "submap_size": size, "fusion_threshold": threshold, "runs": len(records)})
    if failures:
        cell["reason"] = f"{len(failures)} of {len(records) + len(failures)} runs failed: {failures[0]}"
    for key in TIME_KEYS:
        values = [record["summary"][key] for record in records if record["summary"].get(key) is not None]
        cell[key] = statistics.median(values) if values else None
    for key in MEANS:
        values = [record["summary"][key] for record in records if record["summary"].get(key) is not None]
        cell[key] = round(statistics.fmean(values), DECIMALS) if values else None
    return cell
