"""The published Victoria Park graph (known association): ssjs, alone and smoothed, beside GTSAM's iSAM2, interleaved in one run.

    pip install gtsam
    SSJS_DATA=... python benchmarks/victoria_park_graph.py --rounds 5

Both take the same increments and sightings with the same noise. What is timed a step: iSAM2's update with the new factors and its
estimate of the newest pose; every event of ssjs, which answers with pose and covariance. The total of the smoothed run includes the
smoother and all covariances. Half chi2 is always that of GTSAM's own graph at the estimate.
"""

import argparse
import time
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

import gtsam
import numpy as np
from numpy.typing import NDArray
from step_times import data_directory, machine_text, quantile_text, steady_step_times

from ssjs_cli import _core
from ssjs_cli.config import layer_from_assignments, layer_from_tables, resolve
from ssjs_cli.formats.graph import read_graph
from ssjs_cli.formats.mission import Mission
from ssjs_cli.mission_run import build_log

Array = NDArray[np.float64]
SEED = 1
# Tight: the graph's first pose is the world frame.
FIRST_POSE_SIGMA = 1e-6
RELINEARIZE_THRESHOLD, RELINEARIZE_SKIP = 0.1, 10


@dataclass
class Estimate:
    pose: Array  # (n, 3), x y heading
    landmark: dict[int, Array]


@dataclass
class Run:
    total_s: float
    step_time_us: Array
    estimate: Estimate
    note: str


def pose_key(index: int) -> int:
    return gtsam.symbol("x", index)


def landmark_key(identity: int) -> int:
    return gtsam.symbol("l", identity)


@dataclass
class GraphStep:
    """The factors that arrive with one pose."""

    factors: gtsam.NonlinearFactorGraph
    increment: gtsam.Pose2 | None
    sightings: list[tuple[int, float, float]]  # landmark, range m, bearing rad


def graph_steps(mission: Mission, range_sigma_m: float, bearing_sigma_rad: float) -> list[GraphStep]:
    odometry, seen = mission.odometry.values, mission.observations
    sighting_noise = gtsam.noiseModel.Diagonal.Sigmas(np.array([bearing_sigma_rad, range_sigma_m]))
    steps = []
    first = np.searchsorted(seen.time_s, np.arange(len(odometry) + 2) - 0.5)
    for pose in range(len(odometry) + 1):
        factors, increment = gtsam.NonlinearFactorGraph(), None
        if pose == 0:
            tight = gtsam.noiseModel.Isotropic.Sigma(3, FIRST_POSE_SIGMA)
            factors.add(gtsam.PriorFactorPose2(pose_key(0), gtsam.Pose2(), tight))
        else:
            _, dx_m, dy_m, dheading_rad, *sigmas = odometry[pose - 1]
            increment = gtsam.Pose2(dx_m, dy_m, dheading_rad)
            noise = gtsam.noiseModel.Diagonal.Sigmas(np.array(sigmas))
            factors.add(gtsam.BetweenFactorPose2(pose_key(pose - 1), pose_key(pose), increment, noise))
        sightings = []
        for row in range(first[pose], first[pose + 1]):
            identity, range_m, bearing_rad = int(seen.landmark_id[row]), float(seen.range_m[row]), float(seen.bearing_rad[row])
            sightings.append((identity, range_m, bearing_rad))
            keys = pose_key(pose), landmark_key(identity)
            factors.add(gtsam.BearingRangeFactor2D(*keys, gtsam.Rot2(bearing_rad), range_m, sighting_noise))
        steps.append(GraphStep(factors, increment, sightings))
    return steps


def run_isam2(steps: list[GraphStep]) -> Run:
    parameters = gtsam.ISAM2Params()
    parameters.setOptimizationParams(gtsam.ISAM2GaussNewtonParams())
    parameters.setRelinearizeThreshold(RELINEARIZE_THRESHOLD)
    parameters.relinearizeSkip = RELINEARIZE_SKIP
    isam = gtsam.ISAM2(parameters)
    pose = gtsam.Pose2()
    known: set[int] = set()
    step_time_us = np.empty(len(steps))
    begin_s = time.process_time()
    for index, step in enumerate(steps):
        initial = gtsam.Values()
        if step.increment is not None:
            pose = pose.compose(step.increment)
        initial.insert(pose_key(index), pose)
        for identity, range_m, bearing_rad in step.sightings:
            if identity not in known:
                known.add(identity)
                ray = np.array([range_m * np.cos(bearing_rad), range_m * np.sin(bearing_rad)])
                initial.insert(landmark_key(identity), pose.transformFrom(ray))
        step_begin_s = time.perf_counter()
        isam.update(step.factors, initial)
        pose = isam.calculateEstimatePose2(pose_key(index))
        step_time_us[index] = 1e6 * (time.perf_counter() - step_begin_s)
    values = isam.calculateBestEstimate()
    total_s = time.process_time() - begin_s
    return Run(total_s, step_time_us, estimate_of(values, len(steps), known), f"{len(known)} landmarks, one map")


def estimate_of(values: gtsam.Values, poses: int, landmarks: set[int]) -> Estimate:
    pose = [values.atPose2(pose_key(index)) for index in range(poses)]
    return Estimate(
        np.array([[at.x(), at.y(), at.theta()] for at in pose]),
        {identity: np.asarray(values.atPoint2(landmark_key(identity))) for identity in sorted(landmarks)},
    )


def run_ssjs(settings: dict[str, Any], log: Any) -> Run:
    begin_s = time.process_time()
    result = _core.run(settings, log, SEED, None)
    total_s = time.process_time() - begin_s
    # Events at one time: the increment to a pose and its sightings; the pose is that after the last of them.
    time_s = np.asarray(result["time_s"])
    last = np.flatnonzero(np.append(np.diff(time_s) > 0.0, True))
    pose = np.asarray(result["pose"])[last]
    if time_s[0] > 0.0:
        pose = np.vstack([np.zeros(3), pose])
    # A landmark lives in several maps: their answers weighted by their information.
    information: dict[int, Array] = {}
    weighted: dict[int, Array] = {}
    landmarks = result["landmarks"]
    for identity, position, covariance in zip(landmarks["landmark_id"], landmarks["position"], landmarks["covariance"], strict=True):
        W = np.linalg.inv(np.array([[covariance[0], covariance[1]], [covariance[1], covariance[2]]]))
        information[identity] = information.get(identity, 0.0) + W
        weighted[identity] = weighted.get(identity, 0.0) + W @ position
    step_time_us = np.add.reduceat(np.asarray(result["step_time_us"]), np.flatnonzero(np.append(True, np.diff(time_s) > 0.0)))
    counters = result["counters"]
    note = f"{counters['submaps']} submaps, {len(result['live_maps'])} live maps, {counters['fusions']} fusions"
    if "half_chi2_final" in counters:
        note += f"; own half chi2 {counters['half_chi2_final']:.1f} after {counters['smoothing_iterations']} iterations"
        note += f", {result['timing']['time_smoothing_s']:.2f} s wall time"
    estimate = Estimate(pose, {identity: np.linalg.solve(information[identity], weighted[identity]) for identity in sorted(information)})
    return Run(total_s, step_time_us, estimate, note)


def dead_reckoning(steps: list[GraphStep]) -> Estimate:
    """The increments composed; a landmark where its first sighting from there puts it."""
    pose, poses, landmark = gtsam.Pose2(), [], {}
    for step in steps:
        if step.increment is not None:
            pose = pose.compose(step.increment)
        poses.append([pose.x(), pose.y(), pose.theta()])
        for identity, range_m, bearing_rad in step.sightings:
            ray = np.array([range_m * np.cos(bearing_rad), range_m * np.sin(bearing_rad)])
            landmark.setdefault(identity, np.asarray(pose.transformFrom(ray)))
    return Estimate(np.array(poses), landmark)


def values_of(estimate: Estimate) -> gtsam.Values:
    values = gtsam.Values()
    for index, (x_m, y_m, heading_rad) in enumerate(estimate.pose):
        values.insert(pose_key(index), gtsam.Pose2(x_m, y_m, heading_rad))
    for identity, position in estimate.landmark.items():
        values.insert(landmark_key(identity), position)
    return values


def batch(graph: gtsam.NonlinearFactorGraph, start: Estimate) -> tuple[Estimate, float, int, float]:
    """Levenberg-Marquardt from `start`: the optimum found, half its chi-squared, iterations, processor time."""
    parameters = gtsam.LevenbergMarquardtParams()
    parameters.setMaxIterations(100)
    parameters.setRelativeErrorTol(1e-9)
    begin_s = time.process_time()
    optimizer = gtsam.LevenbergMarquardtOptimizer(graph, values_of(start), parameters)
    values = optimizer.optimize()
    spent_s = time.process_time() - begin_s
    return estimate_of(values, len(start.pose), set(start.landmark)), graph.error(values), optimizer.iterations(), spent_s


def rms(errors: Array) -> float:
    return float(np.sqrt(np.mean(np.sum(errors**2, axis=1))))


def accuracy_text(estimate: Estimate, optimum: Estimate) -> str:
    identities = sorted(optimum.landmark)
    found, truth = (np.array([at.landmark[identity] for identity in identities]) for at in (estimate, optimum))
    centred, centred_truth = found - found.mean(axis=0), truth - truth.mean(axis=0)
    U, _, Vt = np.linalg.svd(centred.T @ centred_truth)
    rotation = (U @ np.diag([1.0, np.linalg.det(U @ Vt)]) @ Vt).T
    poses = rms(estimate.pose[:, :2] - optimum.pose[:, :2])
    return f"landmarks {rms(found - truth):.2f} m, aligned {rms(centred @ rotation.T - centred_truth):.2f} m, poses {poses:.2f} m"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5, help="repetitions; medians are shown")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="assignments", help="a setting, several times")
    arguments = parser.parse_args()

    path = data_directory() / "victoria_park_graph" / "victoria_park.txt"
    mission = read_graph(path)
    settings = resolve([layer_from_tables(mission.settings, path.name), layer_from_assignments(arguments.assignments)])
    methods = {
        "ssjs": settings,
        "ssjs, smoothed": settings.replaced({"smoothing.enabled": True}, "smoothed"),
        "ekf": settings.replaced({"method": "ekf"}, "ekf"),
    }
    log = build_log(mission, settings, path.parent, [])
    steps = graph_steps(mission, float(settings.values["sensor.range_sigma_m"]), float(settings.values["sensor.bearing_sigma_rad"]))
    graph = gtsam.NonlinearFactorGraph()
    for step in steps:
        graph.push_back(step.factors)

    runs: dict[str, list[Run]] = {"iSAM2": [], **{name: [] for name in methods}}
    for _ in range(arguments.rounds):
        runs["iSAM2"].append(run_isam2(steps))
        for name, method_settings in methods.items():
            runs[name].append(run_ssjs(dict(method_settings.values), log))
    optimum, optimum_error, _, _ = batch(graph, runs["iSAM2"][0].estimate)

    print(machine_text())
    print(f"ssjs {_core.version()}, GTSAM {version('gtsam')}, {arguments.rounds} interleaved runs")
    print(f"{len(steps)} poses, {len(mission.observations.time_s)} sightings, {len(optimum.landmark)} landmarks")
    print(f"batch optimum (Levenberg-Marquardt from iSAM2's estimate): half chi2 {optimum_error:.1f}")
    for name, measured in runs.items():
        total_s = [run.total_s for run in measured]
        estimate = measured[0].estimate
        print(f"{name}: total {np.median(total_s):.3f} s processor time, the median ({min(total_s):.3f} to {max(total_s):.3f})")
        print(f"  {measured[0].note}")
        print(f"  step, wall time: {quantile_text(steady_step_times([run.step_time_us for run in measured]))}")
        print(f"  against the optimum, RMS: {accuracy_text(estimate, optimum)}")
        print(f"  half chi2 of the estimate: {graph.error(values_of(estimate)):.1f}")
        _, error, iterations, spent_s = batch(graph, estimate)
        print(f"  batch started from it: half chi2 {error:.1f} after {iterations} iterations, {spent_s:.2f} s")
    start = dead_reckoning(steps)
    _, error, iterations, spent_s = batch(graph, start)
    print(f"dead reckoning: half chi2 {graph.error(values_of(start)):.1f}")
    print(f"  batch started from it: half chi2 {error:.1f} after {iterations} iterations, {spent_s:.2f} s")


if __name__ == "__main__":
    main()
