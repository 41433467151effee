"""A run directory as a long land mission would leave it: every file of the contract, made of seeded numpy draws.

The vehicle drives six wandering laps through a park of about 420 m x 300 m at 40 steps a second; the estimates are the truth plus smooth
errors whose size the written covariances state truly, so consistency figures must look consistent.
"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

STEP_S = 0.025
STEPS_PER_SCAN = 8


@dataclass(frozen=True)
class Size:
    steps: int = 60_000
    submaps: int = 200
    landmarks: int = 1_500


FULL = Size()
SMALL = Size(steps=1_200, submaps=6, landmarks=40)


def write_synthetic_run(
    run_dir: Path, size: Size = FULL, seed: int = 7, mission: str = "Botanical garden, six laps", reference: bool = True
) -> Path:
    run_dir.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(seed)
    time_s = STEP_S * np.arange(size.steps)
    truth = _drive(time_s)
    submap_of_step, starts = _cut(size, rng)
    anchored = 1.0 - 0.75 * np.linspace(0.0, 1.0, size.steps)
    sigma_final = 0.05 + 0.30 * np.sin(np.pi * np.linspace(0.0, 1.0, size.steps)) ** 2
    sigma_online = 0.08 + 0.9 * anchored * _sawtooth(size.steps, rng)
    final_error = _smooth_unit_noise(size.steps, rng) * sigma_final[:, None]
    online_error = _smooth_unit_noise(size.steps, rng) * sigma_online[:, None]
    final, online = truth.copy(), truth.copy()
    final[:, :2] += final_error
    online[:, :2] += online_error
    final[:, 2] += 0.004 * _smooth_unit_noise(size.steps, rng)[:, 0]
    _write_track(run_dir / "trajectory.tum", time_s, final)
    _write_track(run_dir / "trajectory_online.tum", time_s, online)
    _write_track(run_dir / "dead_reckoning.tum", time_s, _dead_reckon(truth, rng))
    _write_covariance(run_dir / "trajectory_covariance.csv", time_s, sigma_final)
    _write_covariance(run_dir / "trajectory_online_covariance.csv", time_s, sigma_online)
    _write_csv(run_dir / "trajectory_submaps.csv", "time_s,submap", (time_s, submap_of_step), ("%.3f", "%d"))
    landmark, landmark_submap = _write_landmarks(run_dir, size, truth, submap_of_step, rng)
    submaps = _write_submaps(run_dir, size, time_s, final, starts, landmark_submap, rng)
    _write_consistency(run_dir, time_s, rng)
    _write_step_times(run_dir, time_s, starts, rng)
    if reference:
        _write_errors(run_dir, time_s, truth, final_error, online_error, sigma_final, sigma_online, rng)
    _write_summary(run_dir, size, submaps, len(landmark), final_error, mission, reference)
    _write_config(run_dir)
    return run_dir


def _drive(time_s: FloatArray) -> FloatArray:
    """Pose (n, 3): laps of a slowly turning, wobbling ellipse."""
    phase = 2.0 * np.pi * 6.0 * time_s / 1500.0
    x = 150.0 * np.cos(phase) + 48.0 * np.cos(2.35 * phase + 1.0) + 20.0 * np.cos(5.1 * phase)
    y = 105.0 * np.sin(phase) + 42.0 * np.sin(1.65 * phase + 0.4) + 18.0 * np.sin(4.3 * phase)
    heading = np.arctan2(np.gradient(y), np.gradient(x))
    return np.column_stack((x, y, heading))


def _smooth_unit_noise(count: int, rng: np.random.Generator, waves: int = 60) -> FloatArray:
    """Two columns of unit-variance noise, smooth over time (random phases)."""
    step = np.linspace(0.0, 1.0, count)
    columns = []
    for _ in range(2):
        frequency, phase = rng.uniform(1.0, 160.0, waves), rng.uniform(0.0, 2.0 * np.pi, waves)
        columns.append(sum(np.sin(2.0 * np.pi * f * step + p) for f, p in zip(frequency, phase, strict=True)) * np.sqrt(2.0 / waves))
    return np.column_stack(columns)


def _sawtooth(count: int, rng: np.random.Generator) -> FloatArray:
    """Grows while the vehicle sees new ground, falls at a loop closure."""
    value, level = np.empty(count), 0.1
    falls = set(np.sort(rng.choice(count, max(3, count // 900), replace=False)).tolist())
    for step in range(count):
        level = 0.12 * level if step in falls else min(level + 0.0006, 1.0)
        value[step] = level
    return value


def _dead_reckon(truth: FloatArray, rng: np.random.Generator) -> FloatArray:
    turn = np.cumsum(rng.normal(2e-6, 2e-4, len(truth)))
    step = np.diff(truth[:, :2], axis=0, prepend=truth[:1, :2])
    cosine, sine = np.cos(turn), np.sin(turn)
    moved = np.column_stack((cosine * step[:, 0] - sine * step[:, 1], sine * step[:, 0] + cosine * step[:, 1])) * 1.01
    return np.column_stack((truth[0, :2] + np.cumsum(moved, axis=0), truth[:, 2] + turn))


def _cut(size: Size, rng: np.random.Generator) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    length = rng.uniform(0.6, 1.4, size.submaps)
    starts = np.concatenate(([0], np.cumsum(length)[:-1] / length.sum() * size.steps)).astype(np.int64)
    return np.searchsorted(starts, np.arange(size.steps), side="right") - 1, starts


def _write_track(path: Path, time_s: FloatArray, pose: FloatArray) -> None:
    rows = np.zeros((len(time_s), 8))
    rows[:, 0], rows[:, 1:3] = time_s, pose[:, :2]
    rows[:, 6], rows[:, 7] = np.sin(0.5 * pose[:, 2]), np.cos(0.5 * pose[:, 2])
    np.savetxt(path, rows, fmt="%.6f")


def _write_csv(path: Path, header: str, columns: tuple[Any, ...], formats: tuple[str, ...]) -> None:
    np.savetxt(path, np.column_stack(columns), fmt=formats, delimiter=",", header=header, comments="")


def _write_covariance(path: Path, time_s: FloatArray, sigma_m: FloatArray) -> None:
    zero = np.zeros_like(sigma_m)
    columns = (time_s, sigma_m**2, 0.25 * sigma_m**2, zero, sigma_m**2, zero, np.full_like(sigma_m, 0.004**2))
    _write_csv(path, "time_s,var_xx,cov_xy,cov_xh,var_yy,cov_yh,var_hh", columns, ("%.3f",) + ("%.9g",) * 6)


def _write_landmarks(
    run_dir: Path, size: Size, truth: FloatArray, submap_of_step: NDArray[np.int64], rng: np.random.Generator
) -> tuple[FloatArray, NDArray[np.int64]]:
    """Beside the track, at most 30 m off; each belongs to the first submap that comes within 32 m."""
    step = np.sort(rng.integers(0, size.steps, size.landmarks))
    position = truth[step, :2] + rng.uniform(4.0, 30.0, size.landmarks)[:, None] * _directions(rng.uniform(-np.pi, np.pi, size.landmarks))
    coarse = truth[::40, :2]
    submap = np.array([submap_of_step[40 * int(np.argmax(np.hypot(*(coarse - point).T) < 32.0))] for point in position])
    order = np.argsort(submap, kind="stable")
    position, submap = position[order], submap[order]
    sigma_major = rng.uniform(0.15, 0.6, size.landmarks)
    sigma_minor = sigma_major * rng.uniform(0.25, 0.9, size.landmarks)
    turn = rng.uniform(-np.pi, np.pi, size.landmarks)
    xx = (sigma_major * np.cos(turn)) ** 2 + (sigma_minor * np.sin(turn)) ** 2
    yy = (sigma_major * np.sin(turn)) ** 2 + (sigma_minor * np.cos(turn)) ** 2
    xy = (sigma_major**2 - sigma_minor**2) * np.sin(turn) * np.cos(turn)
    zero = np.zeros(size.landmarks)
    _write_csv(
        run_dir / "landmarks.csv",
        "id,x_m,y_m,z_m,var_xx,cov_xy,cov_xz,var_yy,cov_yz,var_zz,times_seen,submap",
        (np.arange(size.landmarks), *position.T, zero, xx, xy, zero, yy, zero, zero, rng.integers(3, 240, size.landmarks), submap),
        ("%d",) + ("%.6f",) * 9 + ("%d", "%d"),
    )
    return position, submap


def _directions(angle_rad: FloatArray) -> FloatArray:
    return np.column_stack((np.cos(angle_rad), np.sin(angle_rad)))


def _write_submaps(
    run_dir: Path, size: Size, time_s: FloatArray, final: FloatArray, starts: NDArray[np.int64], landmark_submap: NDArray[np.int64],
    rng: np.random.Generator,
) -> dict[str, Any]:  # fmt: skip
    ends = np.append(starts[1:], size.steps) - 1
    live = np.minimum(np.arange(size.submaps), rng.integers(0, max(2, size.submaps // 5), size.submaps))
    submaps = []
    for index, (start, end) in enumerate(zip(starts.tolist(), ends.tolist(), strict=True)):
        sigma = 0.05 + 0.3 * np.sin(np.pi * index / size.submaps) ** 2
        submaps.append({
            "index": index, "start_time_s": float(time_s[start]), "end_time_s": float(time_s[end]), "base_pose": final[start].tolist(),
            "base_covariance": [sigma**2, 0.2 * sigma**2, 0.0, 0.8 * sigma**2, 0.0, 0.003**2],
            "landmarks": int((landmark_submap == index).sum()), "live_map": int(live[index]),
            "link_pose": [8.0, 0.4, 0.05] if index + 1 < size.submaps else None,
            "link_covariance": [0.006, 0.0, 0.0, 0.006, 0.0, 2.5e-5] if index + 1 < size.submaps else None,
            "closed_because": ["landmarks", "landmarks", "uncertainty"][index % 3] if index + 1 < size.submaps else "end of mission",
        })  # fmt: skip
    base = final[starts, :2]
    loops = []
    for index in range(4, size.submaps):
        distance = np.hypot(*(base[: index - 3] - base[index]).T)
        for other in np.argsort(distance)[:3].tolist():
            if distance[other] > 34.0:
                continue
            accepted = bool(distance[other] < 16.0 and rng.random() < 0.8)
            pairs = int(rng.integers(6, 12)) if accepted else int(rng.integers(0, 6))
            dof = 2 * pairs - 3 if pairs >= 2 else 0
            refusal = rng.choice(["too few pairs: 6 needed", "joint gate at 95 % failed", "ambiguous: sigma 2.1 m over the 1.5 m gate"])
            loops.append({
                "time_s": float(time_s[ends[index]]), "from": index, "to": other, "accepted": accepted,
                "reason": "joined" if accepted else str(refusal), "pairs": pairs, "wrong_pairs": 0,
                "chi2": float(rng.chisquare(dof)) if dof else None, "dof": dof,
            })  # fmt: skip
    members = [{"index": int(m), "members": np.flatnonzero(live == m).tolist(), "landmarks": 30} for m in sorted(set(live.tolist()))]
    document = {"submaps": submaps, "live_maps": members, "loops": loops}
    (run_dir / "submaps.json").write_text(json.dumps(document), encoding="utf-8")
    return document


def _write_consistency(run_dir: Path, time_s: FloatArray, rng: np.random.Generator) -> None:
    scan_s = time_s[::STEPS_PER_SCAN]
    dof = 2 * rng.integers(2, 11, len(scan_s))
    _write_csv(run_dir / "consistency.csv", "time_s,nis,dof", (scan_s, 0.92 * rng.chisquare(dof), dof), ("%.3f", "%.6f", "%d"))


def _write_step_times(run_dir: Path, time_s: FloatArray, starts: NDArray[np.int64], rng: np.random.Generator) -> None:
    step_us = rng.lognormal(np.log(3.0), 0.25, len(time_s))
    step_us[::STEPS_PER_SCAN] = rng.lognormal(np.log(42.0), 0.35, len(step_us[::STEPS_PER_SCAN]))
    step_us[starts] = rng.lognormal(np.log(2500.0), 0.6, len(starts)) * np.linspace(0.4, 1.8, len(starts))
    _write_csv(run_dir / "step_times.csv", "time_s,step_time_us", (time_s, step_us), ("%.3f", "%.3f"))


def _write_errors(
    run_dir: Path, time_s: FloatArray, truth: FloatArray, final_error: FloatArray, online_error: FloatArray,
    sigma_final: FloatArray, sigma_online: FloatArray, rng: np.random.Generator,
) -> None:  # fmt: skip
    header = "time_s,error_m,is_outlier,error_x_m,error_y_m,sigma_x_m,sigma_y_m,sigma_major_m"
    outlier = rng.random(len(time_s)) < 2e-4
    for name, error, sigma in (("errors.csv", final_error, sigma_final), ("errors_online.csv", online_error, sigma_online)):
        size_m = np.hypot(error[:, 0], error[:, 1]) + 25.0 * outlier
        columns = (time_s, size_m, outlier, error[:, 0], error[:, 1], sigma, sigma, 1.118 * sigma)
        _write_csv(run_dir / name, header, columns, ("%.3f", "%.6f", "%d") + ("%.6f",) * 5)
    _write_csv(run_dir / "reference.csv", "time_s,x_m,y_m", (time_s, truth[:, 0], truth[:, 1]), ("%.3f", "%.4f", "%.4f"))
    third = _smooth_unit_noise(len(time_s), rng)[:, 0]
    nees = ((final_error / sigma_final[:, None]) ** 2).sum(axis=1) + third**2
    _write_csv(run_dir / "nees.csv", "time_s,nees,dof", (time_s, nees, np.full(len(time_s), 3)), ("%.3f", "%.6f", "%d"))


def _write_summary(
    run_dir: Path, size: Size, submaps: dict[str, Any], landmarks: int, final_error: FloatArray, mission: str, reference: bool
) -> None:
    error_m = np.hypot(final_error[:, 0], final_error[:, 1])
    accuracy = {
        "trajectory_rmse_m": float(np.sqrt(np.mean(error_m**2))), "trajectory_mean_m": float(error_m.mean()),
        "trajectory_std_m": float(error_m.std()),
        "trajectory_max_m": float(error_m.max()), "final_drift_percent": 0.0061, "dead_reckoning_rmse_m": 21.83,
        "dead_reckoning_final_drift_percent": 1.42, "reference_outliers": 13, "map_error_mean_m": 0.312, "map_error_std_m": 0.171,
        "map_error_max_m": 1.37, "landmarks_missed": 6, "landmarks_false": 2, "wrong_pairs": 0, "nees_mean": 2.94,
        "nees_inside_fraction": 0.953, "nees_joint_per_dof": 1.04, "nees_base_mean": 3.1, "nees_map_mean": 2.07, "alignment": "se2",
    }  # fmt: skip
    accepted = [loop for loop in submaps["loops"] if loop["accepted"]]
    summary = {
        "mission": mission, "description": "Synthetic mission of the report tests: six laps, trunks as landmarks, no real vehicle.",
        "method": "ssjs", "association": "jcbb", "version": "0.1.0", "seed": 7,
        "steps": size.steps, "observations": 6 * size.steps // STEPS_PER_SCAN, "landmarks": landmarks, "submaps": size.submaps,
        "loop_candidates": len(submaps["loops"]), "loop_closures": len(accepted), "fusions": len(accepted) + 20,
        "time_total_s": 1.94, "time_local_s": 0.71, "time_global_s": 0.62, "time_association_s": 0.49, "time_other_s": 0.12,
        "step_time_p50_us": 3.1, "step_time_p99_us": 88.4, "step_time_max_us": 11840.0, "peak_rss_mb": 96.2,
        "nis_mean": 10.9, "nis_inside_fraction": 0.946, "half_chi2_initial": 12044.1, "half_chi2_final": 2339.4,
        **{key: (value if reference else None) for key, value in accuracy.items()},
        "input_digests": {
            "odometry.csv": "sha256:5d41402abc4b2a76b9719d911017c592", "observations.csv": "sha256:7d793037a0760186574b0282f2f435e7",
        },
        "configuration_digest": "sha256:9e107d9d372bb6826bd81d3542a419d6",
    }  # fmt: skip
    (run_dir / "summary.json").write_text(json.dumps(summary, indent=1), encoding="utf-8")
    timing = {"wall_s": 2.31, "cpu_s": 2.24, "peak_rss_mb": 96.2}
    (run_dir / "timing.json").write_text(json.dumps(timing), encoding="utf-8")


def _write_config(run_dir: Path) -> None:
    (run_dir / "config.toml").write_text(
        """method = "ssjs"
seed = 7

[vehicle]
kind = "ackerman"
[vehicle.ackerman]
wheelbase_m = 2.83
speed_sigma_m_s = 0.5
steering_sigma_rad = 0.0349066
lateral_sigma_m_s = 0.5
[sensor]
sigma_range_m = 0.1
sigma_bearing_rad = 0.00872665
min_range_m = 3.0
max_range_m = 38.0
[association]
method = "jcbb"
gate_probability = 0.99
joint_gate_probability = 0.95
max_nodes = 600
[submap]
max_landmarks = 15
min_times_seen = 3
max_sigma_xy_m = 2.0
split_boundary = true
[joining]
fusion_threshold = 0.4
min_gap = 3
max_live_landmarks = 60
fusion_gate_probability = 0.99
[output]
online_track = true
""",
        encoding="utf-8",
    )
