"""A run against its reference: the estimator's measures, and the tables that the report draws."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ssjs_cli import _core
from ssjs_cli.contact_score import contact_score
from ssjs_cli.errors import UserError, describe_os_error
from ssjs_cli.formats.mission import Reference, ReferenceDescription, SurveyedLandmarks
from ssjs_cli.formats.number_table import EXACT, FIXED, SCIENTIFIC, WHOLE, FloatArray, IntArray, write_table
from ssjs_cli.formats.run_directory import (
    ERROR_HEADER,
    ERRORS_FILE,
    NEES_FILE,
    ONLINE_ERRORS_FILE,
    REFERENCE_FILE,
    REFERENCE_KEYS,
    Estimate,
)
from ssjs_cli.formats.tum import PoseSeries, wrapped_angle

# An estimated landmark farther from every surveyed one is a false one.
MAP_MATCH_DISTANCE_M = 10.0
POSE_DOF = 3
POINT_DOF = 2
SUMMARY_DECIMALS = 6
BOUND_SIGMAS = 3.0
UNUSABLE_REFERENCE = "the reference covers"


@dataclass(frozen=True)
class ErrorTable:
    """One row per compared fix, in the frame of the reference; the columns of ERROR_HEADER."""

    columns: list[FloatArray | IntArray]

    def write(self, path: Path) -> None:
        write_table(path, ERROR_HEADER, self.columns, [EXACT, FIXED, WHOLE, *[FIXED] * 5])


@dataclass(frozen=True)
class Evaluation:
    """`summary` holds every key of REFERENCE_KEYS (None where unknown); absent tables are None. `lost` names what could not be used."""

    summary: dict[str, Any]
    errors: ErrorTable | None = None
    online_errors: ErrorTable | None = None
    reference: list[FloatArray] | None = None
    nees: list[FloatArray | IntArray] | None = None
    lost: list[str] = field(default_factory=list)

    def write(self, directory: Path) -> None:
        """Replaces the tables of an earlier evaluation; one that no longer applies is removed."""
        tables: dict[str, Any] = {
            ERRORS_FILE: self.errors and self.errors.write,
            ONLINE_ERRORS_FILE: self.online_errors and self.online_errors.write,
            REFERENCE_FILE: self.reference and self._write_reference,
            NEES_FILE: self.nees and self._write_nees,
        }
        for name, write in tables.items():
            path = directory / name
            if write is None:
                path.unlink(missing_ok=True)
                continue
            partial = directory / f".{name}.partial"
            try:
                write(partial)
                partial.replace(path)
            except OSError as error:
                raise UserError(describe_os_error(error, str(path))) from error
            finally:
                partial.unlink(missing_ok=True)

    def _write_reference(self, path: Path) -> None:
        if self.reference is not None:
            write_table(path, "time_s,x_m,y_m", self.reference, [EXACT, FIXED, FIXED])

    def _write_nees(self, path: Path) -> None:
        if self.nees is not None:
            write_table(path, "time_s,nees,dof", self.nees, [EXACT, SCIENTIFIC, WHOLE])


@dataclass(frozen=True)
class _Track:
    """The reference as fixes: time_s (k,) strictly increasing; position (k, 2); heading (k,) or None."""

    time_s: FloatArray
    position: FloatArray
    heading: FloatArray | None


def evaluate(estimate: Estimate, reference: Reference) -> Evaluation:
    """Dense truth is preferred to sparse fixes. Everything is compared in the frame of the reference, after its alignment."""
    description = reference.description
    summary: dict[str, Any] = dict.fromkeys(REFERENCE_KEYS)
    lost: list[str] = []
    track = _track_of(reference)
    reference_T_estimate: FloatArray = np.zeros(3)
    errors = online_errors = None
    moved_reference = nees = None
    final, final_covariance = last_of_each_time(estimate.final, estimate.final_covariance)
    online, online_covariance = last_of_each_time(estimate.online, estimate.online_covariance)
    if track is not None:
        summary["alignment"] = description.alignment
        measured = _trajectory_error(final, track, description, description.outlier_m)
        if measured is None:
            lost.append(
                f"{UNUSABLE_REFERENCE} {_span(track.time_s)} and the run {_span(final.time_s)}, so that no fix could be compared "
                f"(reference.max_gap_s = {description.max_gap_s}); check that both use one clock"
            )
        else:
            reference_T_estimate = np.asarray(measured["reference_T_estimate"], dtype=np.float64)
            errors = _error_table(final, final_covariance, track, measured, description)
            online_measured = _trajectory_error(online, track, description, description.outlier_m)
            if online_measured is not None:
                online_errors = _error_table(online, online_covariance, track, online_measured, description)
            _summarize_trajectory(summary, estimate, track, measured, online_measured, description)
            moved_reference = [track.time_s, *_into_estimate_frame(track.position, reference_T_estimate).T]
    truth_T_estimate = reference_T_estimate
    if reference.truth is not None and errors is not None:
        truth_T_estimate = judged_frame(estimate, reference.truth, description.max_gap_s, reference_T_estimate)
        nees = _pose_nees(summary, final, final_covariance, estimate.update_time_s, reference.truth, truth_T_estimate, description)
        for prefix, series, covariance in (("", final, final_covariance), ("online_", online, online_covariance)):
            judged = position_consistency(series, covariance, reference.truth, truth_T_estimate, description.max_gap_s)
            if judged is not None:
                summary[f"nees_position_{prefix}per_dof"], summary[f"inside_3_sigma_{prefix}fraction"] = judged
        summary["inside_3_sigma_depth_fraction"] = _depth_inside(estimate, reference.truth)
        _summarize_bases(summary, estimate, reference.truth, truth_T_estimate, description)
    if reference.landmarks is not None:
        _summarize_map(summary, estimate, reference.landmarks, reference_T_estimate, truth_T_estimate)
        if estimate.is_under_water:
            position = _into_reference_frame(estimate.landmarks.claimed.position, reference_T_estimate)
            summary.update(contact_score(position, reference.landmarks))
    return Evaluation({key: _rounded(value) for key, value in summary.items()}, errors, online_errors, moved_reference, nees, lost)


def _rounded(value: Any) -> Any:
    return round(float(value), SUMMARY_DECIMALS) if isinstance(value, float) else value


def _span(time_s: FloatArray) -> str:
    return f"{time_s[0]:.3f} to {time_s[-1]:.3f} s"


def _track_of(reference: Reference) -> _Track | None:
    if reference.truth is not None:
        truth = reference.truth
        keep = _is_last_of_its_time(truth.time_s)
        return _Track(truth.time_s[keep], truth.pose[keep, :2], truth.pose[keep, 2])
    if reference.fixes is not None:
        keep = _is_last_of_its_time(reference.fixes.time_s)
        return _Track(reference.fixes.time_s[keep], reference.fixes.position_m[keep], None)
    return None


def _is_last_of_its_time(time_s: FloatArray) -> np.ndarray[Any, np.dtype[np.bool_]]:
    return np.append(np.diff(time_s) > 0.0, True)


def last_of_each_time(series: PoseSeries, covariance: FloatArray) -> tuple[PoseSeries, FloatArray]:
    """Several events may share a time; what counts is the estimate after the last of them."""
    keep = _is_last_of_its_time(series.time_s)
    return PoseSeries(series.time_s[keep], series.pose[keep], None if series.space is None else series.space[keep]), covariance[keep]


def _trajectory_error(
    series: PoseSeries, track: _Track, description: ReferenceDescription, outlier_m: float | None
) -> dict[str, Any] | None:
    lever_arm = np.array([description.lever_arm_forward_m, description.lever_arm_left_m])
    return _core.trajectory_error(
        series.time_s,
        series.pose,
        track.time_s,
        track.position,
        track.heading,
        lever_arm,
        description.alignment,
        outlier_m,
        description.max_gap_s,
    )


def interpolated_pose(series: PoseSeries, at_s: FloatArray) -> FloatArray:
    """(k, 3) poses at times inside the series, positions linear, headings along the shorter arc. Times strictly increasing."""
    x, y = (np.interp(at_s, series.time_s, series.pose[:, axis]) for axis in (0, 1))
    heading = np.interp(at_s, series.time_s, np.unwrap(series.pose[:, 2]))
    return np.column_stack([x, y, wrapped_angle(heading)])


def _interpolated_covariance(time_s: FloatArray, covariance: FloatArray, at_s: FloatArray) -> FloatArray:
    """(k, 3, 3) from (n, 6) upper triangles, linear between neighbours."""
    return _symmetric(np.column_stack([np.interp(at_s, time_s, covariance[:, entry]) for entry in range(6)]))


def _symmetric(upper: FloatArray) -> FloatArray:
    """(k, 3, 3) from (k, 6) upper triangles."""
    return upper[:, [0, 1, 2, 1, 3, 4, 2, 4, 5]].reshape(-1, 3, 3)


def _rotation(heading_rad: float) -> FloatArray:
    cosine, sine = np.cos(heading_rad), np.sin(heading_rad)
    return np.array([[cosine, -sine], [sine, cosine]])


def _into_reference_frame(estimate_p: FloatArray, reference_T_estimate: FloatArray) -> FloatArray:
    moved: FloatArray = estimate_p @ _rotation(reference_T_estimate[2]).T + reference_T_estimate[:2]
    return moved


def _into_estimate_frame(reference_p: FloatArray, reference_T_estimate: FloatArray) -> FloatArray:
    moved: FloatArray = (reference_p - reference_T_estimate[:2]) @ _rotation(reference_T_estimate[2])
    return moved


def _error_table(
    series: PoseSeries, covariance: FloatArray, track: _Track, measured: Mapping[str, Any], description: ReferenceDescription
) -> ErrorTable:
    """Errors and standard deviations of the referenced point (lever arm included), x and y of the reference frame."""
    time_s = np.asarray(measured["time_s"], dtype=np.float64)
    fix_p = track.position[np.searchsorted(track.time_s, time_s)]
    reference_T_estimate = np.asarray(measured["reference_T_estimate"], dtype=np.float64)
    at_s = np.clip(time_s, series.time_s[0], series.time_s[-1])
    pose = interpolated_pose(series, at_s)
    cosine, sine = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    forward, left = description.lever_arm_forward_m, description.lever_arm_left_m
    arm = np.column_stack([cosine * forward - sine * left, sine * forward + cosine * left])
    error = _into_reference_frame(pose[:, :2] + arm, reference_T_estimate) - fix_p
    # d(pose (+) arm) / d(x, y, heading) = [1 0 -arm_y; 0 1 arm_x]
    J_point = np.zeros((len(pose), 2, 3))
    J_point[:, 0, 0] = J_point[:, 1, 1] = 1.0
    J_point[:, 0, 2], J_point[:, 1, 2] = -arm[:, 1], arm[:, 0]
    reference_J = _rotation(reference_T_estimate[2]) @ J_point
    P = reference_J @ _interpolated_covariance(series.time_s, covariance, at_s) @ reference_J.transpose(0, 2, 1)
    variance_x, variance_y, covariance_xy = P[:, 0, 0], P[:, 1, 1], P[:, 0, 1]
    variance_major = 0.5 * (variance_x + variance_y) + np.hypot(0.5 * (variance_x - variance_y), covariance_xy)
    sigmas = [np.sqrt(np.maximum(variance, 0.0)) for variance in (variance_x, variance_y, variance_major)]
    return ErrorTable([time_s, np.asarray(measured["error_m"]), np.asarray(measured["is_outlier"], dtype=np.int64), *error.T, *sigmas])


def _summarize_trajectory(
    summary: dict[str, Any],
    estimate: Estimate,
    track: _Track,
    measured: Mapping[str, Any],
    online: Mapping[str, Any] | None,
    description: ReferenceDescription,
) -> None:
    for key in ("rmse_m", "mean_m", "std_m", "max_m", "median_m"):
        summary[f"trajectory_{key}"] = float(measured[key])
    summary["final_drift_percent"] = float(measured["final_drift_percent"])
    summary["reference_outliers"] = int(measured["outliers"])
    summary["reference_compared"] = int(measured["compared"])
    if measured["heading_rmse_rad"] is not None:
        summary["heading_rmse_rad"] = float(measured["heading_rmse_rad"])
    if online is not None:
        summary["trajectory_online_rmse_m"] = float(online["rmse_m"])
        summary["trajectory_online_reference_outliers"] = int(online["outliers"])
    # Dead reckoning is compared with the fixes that the final estimate trusts: its own large errors are no outliers of the reference.
    rejected = np.asarray(measured["time_s"])[np.asarray(measured["is_outlier"], dtype=bool)]
    keep = ~np.isin(track.time_s, rejected)
    trusted = _Track(track.time_s[keep], track.position[keep], None if track.heading is None else track.heading[keep])
    series, _ = last_of_each_time(estimate.dead_reckoning, estimate.final_covariance)
    dead_reckoning = _trajectory_error(series, trusted, description, None)
    if dead_reckoning is not None:
        summary["dead_reckoning_rmse_m"] = float(dead_reckoning["rmse_m"])
        summary["dead_reckoning_final_drift_percent"] = float(dead_reckoning["final_drift_percent"])


def _depth_inside(estimate: Estimate, truth: PoseSeries) -> float | None:
    """Share of the rows that the truth covers whose depth lies within three of its standard deviations; None in the plane."""
    final, variance_m2 = estimate.final, estimate.depth_variance_m2
    if variance_m2 is None or final.space is None or truth.space is None:
        return None
    rows = (final.time_s >= truth.time_s[0]) & (final.time_s <= truth.time_s[-1])
    if not rows.any():
        return None
    error_m = final.space[rows, 0] - np.interp(final.time_s[rows], truth.time_s, truth.space[:, 0])
    return float((error_m**2 <= BOUND_SIGMAS**2 * variance_m2[rows]).mean())


def judged_frame(estimate: Estimate, truth: PoseSeries, max_gap_s: float, otherwise: FloatArray) -> FloatArray:
    """truth_T_estimate in which errors are compared with the covariances claimed. An estimate that is exact at its start has covariances
    about that start and is judged from the first pose that the truth covers: a least-squares alignment would move errors from the end of
    the mission to its start. One whose start is uncertain is in a world that something else defines, position fixes: `otherwise`."""
    if estimate.bases is not None and len(estimate.bases.covariance) and estimate.bases.covariance[0].any():
        return otherwise
    series, _ = last_of_each_time(estimate.final, estimate.final_covariance)
    start_errors, rows = _pose_errors(series, truth, np.zeros(3), max_gap_s)
    if len(rows) == 0:
        return otherwise
    estimate_T_vehicle = series.pose[rows[0]]
    truth_T_vehicle = estimate_T_vehicle - start_errors[0]
    heading = float(truth_T_vehicle[2] - estimate_T_vehicle[2])
    translation = truth_T_vehicle[:2] - _rotation(heading) @ estimate_T_vehicle[:2]
    return np.array([*translation, heading])


def _summarize_map(
    summary: dict[str, Any], estimate: Estimate, truth: SurveyedLandmarks, reference_T_estimate: FloatArray, truth_T_estimate: FloatArray
) -> None:
    landmarks = estimate.landmarks.claimed
    position = _into_reference_frame(landmarks.position, reference_T_estimate)
    ids: list[int | None] = landmarks.ids.tolist() if landmarks.ids_are_of_source else [None] * len(landmarks.ids)
    measured = _core.map_error(position, ids, truth.position_m, truth.ids, MAP_MATCH_DISTANCE_M, False)
    if measured is None:
        summary["landmarks_missed"], summary["landmarks_false"] = len(truth.ids), len(position)
        return
    for key in ("mean_m", "std_m", "max_m"):
        summary[f"map_error_{key}"] = float(measured[key])
    summary["map_error_matched"] = int(measured["matched"])
    summary["landmarks_missed"], summary["landmarks_false"] = int(measured["missed"]), int(measured["false_landmarks"])
    R = _rotation(truth_T_estimate[2])
    position = _into_reference_frame(landmarks.position, truth_T_estimate)
    values = []
    for row, truth_row in enumerate(measured["truth_of"]):
        if truth_row is None:
            continue
        xx, xy, yy = landmarks.covariance[row]
        value = _squared_error(position[row] - truth.position_m[truth_row], R @ np.array([[xx, xy], [xy, yy]]) @ R.T)
        if value is not None:
            values.append(value)
    if values:
        summary["nees_map_mean"] = float(np.mean(values))


def _squared_error(error: FloatArray, covariance: FloatArray) -> float | None:
    """None where the estimate is exact by definition (the first base) and has no covariance to be judged by."""
    try:
        return float(_core.normalized_squared_error(np.ascontiguousarray(error), np.ascontiguousarray(covariance)))
    except ValueError:
        return None


def _pose_errors(series: PoseSeries, truth: PoseSeries, reference_T_estimate: FloatArray, max_gap_s: float) -> tuple[FloatArray, IntArray]:
    """Errors (k, 3) of aligned poses against the truth at their times, and the rows of the series they belong to."""
    keep = _is_last_of_its_time(truth.time_s)
    truth = PoseSeries(truth.time_s[keep], truth.pose[keep])
    after = np.clip(np.searchsorted(truth.time_s, series.time_s), 1, max(len(truth.time_s) - 1, 1))
    inside = (series.time_s >= truth.time_s[0]) & (series.time_s <= truth.time_s[-1])
    if len(truth.time_s) > 1:
        inside &= (truth.time_s[after] - truth.time_s[after - 1]) <= 2.0 * max_gap_s
    rows = np.flatnonzero(inside)
    expected = interpolated_pose(truth, series.time_s[rows])
    pose = series.pose[rows]
    position_error = _into_reference_frame(pose[:, :2], reference_T_estimate) - expected[:, :2]
    heading_error = wrapped_angle(pose[:, 2] + reference_T_estimate[2] - expected[:, 2])
    return np.column_stack([position_error, heading_error]), rows


def pose_nees(
    series: PoseSeries, covariance: FloatArray, truth: PoseSeries, truth_T_estimate: FloatArray, max_gap_s: float
) -> tuple[FloatArray, FloatArray]:
    """Times and NEES of the rows of `series` that the truth covers; a row whose covariance is singular (exact by definition) has none."""
    errors, rows = _pose_errors(series, truth, truth_T_estimate, max_gap_s)
    R: FloatArray = np.eye(3)
    R[:2, :2] = _rotation(truth_T_estimate[2])
    P = R @ _symmetric(covariance[rows]) @ R.T
    times, values = [], []
    for time, error, pose_covariance in zip(series.time_s[rows].tolist(), errors, P, strict=True):
        value = _squared_error(error, pose_covariance)
        if value is not None:
            times.append(time)
            values.append(value)
    return np.array(times), np.array(values)


def position_consistency(
    series: PoseSeries, covariance: FloatArray, truth: PoseSeries, truth_T_estimate: FloatArray, max_gap_s: float
) -> tuple[float, float] | None:
    """(E-10) Over all rows that the truth covers: the mean NEES of x, y per degree of freedom, and the share of rows whose errors along x
    and y both lie within three of their standard deviations. Rows that are exact by definition are left out."""
    errors, rows = _pose_errors(series, truth, truth_T_estimate, max_gap_s)
    R = _rotation(truth_T_estimate[2])
    P = R @ _symmetric(covariance[rows])[:, :2, :2] @ R.T
    determinant = P[:, 0, 0] * P[:, 1, 1] - P[:, 0, 1] ** 2
    known = (determinant > 0.0) & (P[:, 0, 0] > 0.0)
    if not known.any():
        return None
    (x, y), P = errors[known, :2].T, P[known]
    nees = (P[:, 1, 1] * x**2 - 2.0 * P[:, 0, 1] * x * y + P[:, 0, 0] * y**2) / determinant[known]
    inside = (np.abs(x) <= 3.0 * np.sqrt(P[:, 0, 0])) & (np.abs(y) <= 3.0 * np.sqrt(P[:, 1, 1]))
    return float(nees.mean()) / POINT_DOF, float(inside.mean())


def _pose_nees(
    summary: dict[str, Any],
    series: PoseSeries,
    covariance: FloatArray,
    update_time_s: FloatArray,
    truth: PoseSeries,
    truth_T_estimate: FloatArray,
    description: ReferenceDescription,
) -> list[FloatArray | IntArray] | None:
    """The vehicle pose after every scan update; without updates, after every event."""
    chosen = np.isin(series.time_s, update_time_s) if len(update_time_s) else np.ones(len(series.time_s), dtype=bool)
    judged = PoseSeries(series.time_s[chosen], series.pose[chosen])
    times, values = pose_nees(judged, covariance[chosen], truth, truth_T_estimate, description.max_gap_s)
    if not len(values):
        return None
    dof = np.full(len(values), POSE_DOF, dtype=np.int64)
    consistency = _core.consistency_summary(values, dof)
    summary["nees_mean"] = float(consistency["mean"])
    summary["nees_inside_fraction"] = float(consistency["inside_fraction"])
    summary["nees_dof"] = POSE_DOF
    return [times, values, dof]


def _summarize_bases(
    summary: dict[str, Any], estimate: Estimate, truth: PoseSeries, truth_T_estimate: FloatArray, description: ReferenceDescription
) -> None:
    """All base poses together and one by one; a base without covariance (the first defines the frame) is left out."""
    bases = estimate.bases
    if bases is None or len(bases.time_s) == 0:
        return
    errors, rows = _pose_errors(PoseSeries(bases.time_s, bases.pose), truth, truth_T_estimate, description.max_gap_s)
    R: FloatArray = np.eye(3)
    R[:2, :2] = _rotation(truth_T_estimate[2])
    values, kept = [], []
    for row, error, covariance in zip(rows.tolist(), errors, _symmetric(bases.covariance[rows]), strict=True):
        value = _squared_error(error, R @ covariance @ R.T)
        if value is not None:
            values.append(value)
            kept.append((row, error))
    if not kept:
        return
    summary["nees_base_mean"] = float(np.mean(values))
    if bases.joint_covariance is None:
        return
    blocks = np.concatenate([np.arange(3 * row, 3 * row + 3) for row, _ in kept])
    count = len(kept)
    joint = bases.joint_covariance[np.ix_(blocks, blocks)].reshape(count, 3, count, 3)
    joint = np.einsum("ij,ajbk,lk->aibl", R, joint, R, optimize=True).reshape(3 * count, 3 * count)
    value = _squared_error(np.concatenate([error for _, error in kept]), joint)
    if value is not None:
        summary["nees_joint_per_dof"] = value / (POSE_DOF * count)
        summary["nees_joint_dof"] = POSE_DOF * count


def with_alignment(reference: Reference, alignment: str | None) -> Reference:
    """The same reference under another alignment; None keeps the one it has."""
    if alignment is None:
        return reference
    description = ReferenceDescription.model_validate({**reference.description.model_dump(), "alignment": alignment})
    return Reference(description, reference.truth, reference.fixes, reference.landmarks)


def require_reference(reference: Reference, source: str) -> Reference:
    if reference.is_empty:
        raise UserError(f"{source}: holds no reference; give one with --truth FILE (a .tum trajectory, or fixes with time_s,x_m,y_m)")
    return reference
