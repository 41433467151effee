"""What a study keeps of one run besides its numbers: short curves for the drawings. Statistics never use them, but where said so."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssjs_cli.evaluation import Evaluation, judged_frame, last_of_each_time, pose_nees
from ssjs_cli.formats.mission import Reference
from ssjs_cli.formats.number_table import FloatArray
from ssjs_cli.formats.run_directory import Estimate
from ssjs_cli.formats.tum import PoseSeries
from ssjs_cli.report.figure_style import listed, with_gaps
from ssjs_cli.report.result_files import CLOCK_TIME_S
from ssjs_cli.report.simplification import every_nth, keep_extremes, simplify_line, span_edges

TIME_SPANS = 300
ERROR_SPANS = 250
#: At least so many instants or spans, and at most two and a half times as many.
NEES_INSTANTS = 200
NIS_SPANS = 80
MAX_TRACK_POINTS = 2500
MAX_LANDMARKS = 4000
#: A drawn track leaves the full one by at most this part of its extent.
TRACK_TOLERANCE = 1.0 / 20_000.0
#: A reference with fewer fixes than one in so many steps is drawn as dots: between them nothing is known.
FEW_FIXES = 5
SECONDS, METRES, NUMBER = 3, 3, 6


def _listed(values: NDArray[Any], decimals: int) -> list[float]:
    rounded: list[float] = (np.round(values, decimals) + 0.0).tolist()
    return rounded


def time_origin_s(result: Mapping[str, Any]) -> float:
    """What is taken off every time of the curves: the start of the mission where its clock is that of a calendar, as in the report of a
    run, else 0."""
    start_s = float(result["time_s"][0])
    return start_s if abs(start_s) >= CLOCK_TIME_S else 0.0


def counted_from(origin_s: float, curve: Any) -> Any:
    """The curve, or the curves by name, with every time counted from origin_s."""
    if not isinstance(curve, dict):
        return curve
    return {
        key: [None if time is None else round(time - origin_s, SECONDS) for time in value]
        if key == "time_s"
        else counted_from(origin_s, value)
        for key, value in curve.items()
    }


def round_interval(duration_s: float, least_parts: int) -> float:
    """The largest of ..., 1, 2, 5, 10, ... s that cuts the duration into at least so many parts. Runs of one scenario may last a little
    longer or shorter, where the vehicle slips: a round interval is the same for all of them."""
    if not duration_s > 0.0:
        return 1.0
    decade = math.floor(math.log10(duration_s / least_parts))
    return max(
        interval for power in (decade - 1, decade) for digit in (1, 2, 5) if (interval := digit * 10.0**power) <= duration_s / least_parts
    )


def cumulative_time(result: Mapping[str, Any]) -> dict[str, list[float]]:
    """Computing time spent until a time of the mission, at the ends of equal spans."""
    time_s = np.asarray(result["time_s"], dtype=np.float64)
    ends = span_edges(time_s, TIME_SPANS)[1:] - 1
    spent_s = 1e-6 * np.cumsum(np.asarray(result["step_time_us"], dtype=np.float64))
    return {"time_s": _listed(time_s[ends], SECONDS), "spent_s": _listed(spent_s[ends], NUMBER)}


def nees_over_time(estimate: Estimate, reference: Reference) -> dict[str, Any] | None:
    """NEES of the vehicle pose, final and online, after the last event until round instants of the mission, the same in every run of one
    scenario. Needs dense truth. These values are used for the mean over runs."""
    if reference.truth is None:
        return None
    final, final_covariance = last_of_each_time(estimate.final, estimate.final_covariance)
    online, online_covariance = last_of_each_time(estimate.online, estimate.online_covariance)
    max_gap_s = reference.description.max_gap_s
    frame = judged_frame(estimate, reference.truth, max_gap_s, np.zeros(3))
    start_s, end_s = float(final.time_s[0]), float(final.time_s[-1])
    interval_s = round_interval(end_s - start_s, NEES_INSTANTS)
    instants_s: FloatArray = start_s + interval_s * np.arange(1, math.floor((end_s - start_s) / interval_s) + 1, dtype=np.float64)
    rows = np.searchsorted(final.time_s, instants_s + 1e-3 * interval_s, side="right") - 1
    curves: dict[str, Any] = {"time_s": _listed(instants_s, SECONDS)}
    for name, series, covariance in (("final", final, final_covariance), ("online", online, online_covariance)):
        judged = PoseSeries(series.time_s[rows], series.pose[rows])
        times, values = pose_nees(judged, covariance[rows], reference.truth, frame, max_gap_s)
        found = dict(zip(times.tolist(), np.round(values, NUMBER).tolist(), strict=True))
        curves[name] = [found.get(time) for time in judged.time_s.tolist()]
    return curves


def nis_over_time(result: Mapping[str, Any]) -> dict[str, list[float]] | None:
    """Sums of NIS and of its degrees of freedom in spans of a round length, empty spans included."""
    updates = result["updates"]
    time_s = np.asarray(updates["time_s"], dtype=np.float64)
    if len(time_s) == 0:
        return None
    mission_time_s = np.asarray(result["time_s"], dtype=np.float64)
    start_s, duration_s = float(mission_time_s[0]), float(mission_time_s[-1] - mission_time_s[0])
    interval_s = round_interval(duration_s, NIS_SPANS)
    spans = max(math.ceil(duration_s / interval_s), 1)
    span = np.clip(((time_s - start_s) / interval_s).astype(np.int64), 0, spans - 1)
    nis = np.bincount(span, weights=np.asarray(updates["nis"], dtype=np.float64), minlength=spans)
    dof = np.bincount(span, weights=np.asarray(updates["dof"], dtype=np.float64), minlength=spans)
    return {
        "time_s": _listed(start_s + interval_s * (np.arange(spans) + 0.5), SECONDS),
        "nis": _listed(nis, NUMBER),
        "dof": _listed(dof, 0),
    }


def error_over_time(evaluation: Evaluation) -> dict[str, Any] | None:
    """Position error against the reference, its rejected fixes left out, without losing a peak; null where the reference pauses."""
    if evaluation.errors is None:
        return None
    curves = {}
    for name, table in (("final", evaluation.errors), ("online", evaluation.online_errors)):
        if table is None:
            continue
        time_s, error_m, is_outlier = (np.asarray(column, dtype=np.float64) for column in table.columns[:3])
        trusted = is_outlier == 0.0
        time_s, error_m = time_s[trusted], error_m[trusted]
        if len(time_s) < 2:
            continue
        drawn_time_s, drawn_error_m = with_gaps(time_s, error_m, keep_extremes(time_s, error_m, ERROR_SPANS))
        curves[name] = {"time_s": listed(drawn_time_s, SECONDS), "error_m": listed(drawn_error_m, 4)}
    return curves


def map_of(estimate: Estimate, evaluation: Evaluation) -> dict[str, Any]:
    """Track, landmarks, dead reckoning and reference, all in the frame of the estimate."""
    tracks: dict[str, Any] = {
        "track": _track(estimate.final.pose[:, :2]),
        "dead_reckoning": _track(estimate.dead_reckoning.pose[:, :2]),
    }
    if evaluation.reference is not None:
        points = np.column_stack(evaluation.reference[1:3])
        is_sparse = FEW_FIXES * len(points) < len(estimate.final.time_s)
        drawn = _points(points[every_nth(len(points), MAX_TRACK_POINTS)[0]]) if is_sparse else _track(points)
        tracks["reference"] = {**drawn, "sparse": is_sparse}
    rows, _ = every_nth(len(estimate.landmarks.position), MAX_LANDMARKS)
    tracks["landmarks"] = _points(estimate.landmarks.position[rows])
    return tracks


def _track(points: FloatArray) -> dict[str, list[float]]:
    extent_m = float(np.ptp(points, axis=0).max()) if len(points) else 0.0
    rows = simplify_line(points, MAX_TRACK_POINTS, extent_m * TRACK_TOLERANCE).indices
    return _points(points[rows])


def _points(points: FloatArray) -> dict[str, list[float]]:
    return {"x_m": _listed(points[:, 0], METRES), "y_m": _listed(points[:, 1], METRES)}
