"""The numbers of one run: what summary.json and the tables of a study hold."""

import resource
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ssjs_cli import _core
from ssjs_cli.evaluation import Evaluation
from ssjs_cli.formats.run_directory import MEASURED_KEYS, REFERENCE_KEYS, STEP_TIME_KEYS, TIME_KEYS, numbers_of

PROCESS_STATUS = Path("/proc/self/status")


def run_times(result: Mapping[str, Any]) -> dict[str, Any]:
    """Times of the estimator, quantiles of its steps, and the largest memory of this process so far."""
    step_time_us = np.asarray(result["step_time_us"], dtype=np.float64)
    quantiles = np.percentile(step_time_us, [50.0, 99.0, 100.0]).tolist() if len(step_time_us) else [None] * 3
    timing: dict[str, Any] = {key: result["timing"].get(key) for key in TIME_KEYS}
    timing.update({key: _tidy(value) for key, value in zip(STEP_TIME_KEYS, quantiles, strict=True)})
    timing["peak_rss_mb"] = peak_memory_mb()
    return timing


def peak_memory_mb() -> float:
    """Largest resident memory of this process. The kernel's own count is preferred, because what getrusage() tells begins with the
    size of the process that started this one."""
    try:
        fields = dict(line.split(":", 1) for line in PROCESS_STATUS.read_text(encoding="utf-8").splitlines() if ":" in line)
        return round(float(fields["VmHWM"].split()[0]) * 1024.0 / 1e6, 1)
    except (OSError, KeyError, ValueError):
        bytes_per_unit = 1 if sys.platform == "darwin" else 1024
        return round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * bytes_per_unit / 1e6, 1)


def measures(result: Mapping[str, Any], evaluation: Evaluation, timing: Mapping[str, Any]) -> dict[str, Any]:
    """Counts, times, errors and consistency, in the order of summary.json."""
    counters = result["counters"]
    summary: dict[str, Any] = {key: counters.get(key) for key in MEASURED_KEYS}
    summary.update({key: timing[key] for key in (*TIME_KEYS, *STEP_TIME_KEYS, "peak_rss_mb")})
    summary.update({key: evaluation.summary[key] for key in REFERENCE_KEYS})
    summary.update(_nis_summary(result["updates"]))
    summary["half_chi2_initial"] = _number_or_none(counters, result["timing"], "half_chi2_initial")
    summary["half_chi2_final"] = _number_or_none(counters, result["timing"], "half_chi2_final")
    summary.update({key: value for key, value in numbers_of(counters).items() if key not in summary})
    fusion_dof = counters.get("fusion_dof")
    summary["fusion_chi2_per_dof"] = round(float(result["fusion_chi2"]) / fusion_dof, 6) if fusion_dof else None
    return summary


def _tidy(value: float | None) -> float | None:
    return None if value is None else round(value, 3)


def _number_or_none(counters: Mapping[str, Any], timing: Mapping[str, Any], key: str) -> float | None:
    value = counters.get(key, timing.get(key))
    return None if value is None else float(value)


def _nis_summary(updates: Mapping[str, Any]) -> dict[str, Any]:
    """nis_mean is per degree of freedom, because scans differ in their number of pairings."""
    nis = np.asarray(updates["nis"], dtype=np.float64)
    if len(nis) == 0:
        return {"nis_mean": None, "nis_inside_fraction": None, "nis_above_fraction": None, "nis_dof": None}
    dof = np.asarray(updates["dof"], dtype=np.int64)
    consistency = _core.consistency_summary(nis, dof)
    return {
        "nis_mean": round(float(consistency["mean_per_dof"]), 6),
        "nis_inside_fraction": round(float(consistency["inside_fraction"]), 6),
        "nis_above_fraction": round(float(consistency["above_fraction"]), 6),
        "nis_dof": int(dof.sum()),
    }
