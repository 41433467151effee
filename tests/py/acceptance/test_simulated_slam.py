"""The public 1000-step simulation (108 landmarks, odometry increments, range and bearing): known association.

Sigmas of the set: odometry (0.05 m, 0.05 m, 0.017 rad) a step, range 0.098 m, bearing 0.0172 rad. Pose k is at time k s; scan k is
taken at pose k, before increment k.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io
from numpy.typing import NDArray

from ssjs_cli import _core

ODOMETRY_SIGMA = np.array([0.05, 0.05, 0.017])
SCAN_SIGMA = np.array([0.098, 0.0172])
Array = NDArray[np.float64]


def wrap(angle: Array) -> Array:
    return (angle + np.pi) % (2.0 * np.pi) - np.pi


def into_frame(frame: Array, pose: Array) -> Array:
    """pose (3, n) or point (2, n) seen from frame (3,)."""
    c, s = np.cos(frame[2]), np.sin(frame[2])
    d = pose[:2] - frame[:2, None]
    rows = [c * d[0] + s * d[1], -s * d[0] + c * d[1]]
    if pose.shape[0] == 3:
        rows.append(wrap(pose[2] - frame[2]))
    return np.vstack(rows)


class Simulation:
    def __init__(self, path: Path) -> None:
        data = scipy.io.loadmat(path)
        self.poses: Array = data["poseGT"]
        self.landmarks: Array = data["landmarks"]
        self.increments: Array = data["odometry"]
        self.scans: list[Array] = list(data["z"].ravel())
        # identity of each observation: the landmark it fits best, in sigmas of the sensor
        self.identities: list[NDArray[np.int64]] = []
        for k, scan in enumerate(self.scans):
            seen = self.observe(k, np.arange(self.landmarks.shape[1]))
            difference = scan[:, :, None] - seen[:, None, :]
            difference[1] = wrap(difference[1])
            self.identities.append(((difference / SCAN_SIGMA[:, None, None]) ** 2).sum(axis=0).argmin(axis=1))

    def observe(self, k: int, landmarks: NDArray[np.int64]) -> Array:
        """Exact range and bearing (2, n) of landmarks at pose k."""
        d = into_frame(self.poses[:, k], self.landmarks[:, landmarks])
        return np.vstack([np.hypot(d[0], d[1]), np.arctan2(d[1], d[0])])

    def renoised(self, rng: np.random.Generator) -> tuple[Array, list[Array]]:
        steps = np.hstack([into_frame(self.poses[:, k], self.poses[:, [k + 1]]) for k in range(len(self.scans))])
        increments = steps + rng.normal(size=steps.shape) * ODOMETRY_SIGMA[:, None]
        scans = []
        for k, identities in enumerate(self.identities):
            scan = self.observe(k, identities)
            scans.append(scan + rng.normal(size=scan.shape) * SCAN_SIGMA[:, None])
        return increments, scans

    def run(self, increments: Array, scans: list[Array]) -> dict[str, Any]:
        log = _core.MissionLog()
        n = increments.shape[1]
        variance = ODOMETRY_SIGMA**2
        log.add_increments(np.arange(1.0, n + 1), *increments, np.tile([variance[0], 0, 0, variance[1], 0, variance[2]], (n, 1)))
        time_s = np.concatenate([np.full(scan.shape[1], float(k)) for k, scan in enumerate(scans)])
        stacked = np.hstack(scans)
        covariance = np.tile([SCAN_SIGMA[0] ** 2, 0.0, SCAN_SIGMA[1] ** 2], (len(time_s), 1))
        log.add_features(time_s, stacked[0], stacked[1], covariance, [int(i) for i in np.concatenate(self.identities)])
        return dict(_core.run({"vehicle.kind": "increments", "association.method": "known"}, log, 0, None))

    def nees(self, result: dict[str, Any]) -> Array:
        """Of the final pose at every step from the 20th on; the frame is the first pose."""
        k = np.rint(result["time_s"]).astype(int)
        k, rows = k[k >= 20], np.flatnonzero(k >= 20)
        error = result["pose"][rows] - into_frame(self.poses[:, 0], self.poses[:, k]).T
        error[:, 2] = wrap(error[:, 2])
        c = result["covariance"][rows]
        P = np.stack([c[:, [0, 1, 2]], c[:, [1, 3, 4]], c[:, [2, 4, 5]]], axis=1)
        return np.asarray(np.einsum("ni,ni->n", error, np.linalg.solve(P, error[:, :, None])[:, :, 0]))


@pytest.fixture(scope="module")
def simulation(data_set: Callable[[str], Path]) -> Simulation:
    return Simulation(data_set("simulated_slam") / "simulatedSLAM.mat")


def test_error_and_consistency_on_the_published_noise(simulation: Simulation) -> None:
    result = simulation.run(simulation.increments, simulation.scans)
    error = _core.trajectory_error(
        result["time_s"], result["pose"], np.arange(simulation.poses.shape[1], dtype=float), simulation.poses[:2].T
    )
    assert error is not None
    assert error["rmse_m"] < 0.3
    assert np.mean(simulation.nees(result) < _core.chi_squared_quantile(0.95, 3)) >= 0.90


def test_mean_nees_of_50_runs_lies_in_its_band(simulation: Simulation) -> None:
    runs = 50
    means = [simulation.nees(simulation.run(*simulation.renoised(np.random.default_rng(seed)))).mean() for seed in range(runs)]
    lower, upper = _core.mean_band(3, runs)
    assert lower <= np.mean(means) <= upper
