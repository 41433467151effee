from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from ssjs_cli.calibrate import PLANS, CalibrationPlan, Scan, calibrate, expected_runs, mean_nis_per_dof, plan_for
from ssjs_cli.config import Layer, Scalar, field_descriptions, resolve
from ssjs_cli.errors import UserError

YAW = "sensor.bearing_offset_rad"
OFFSET = "vehicle.ackerman.steering_offset_rad"
SCALE = "vehicle.ackerman.steering_scale"
SLIP = "vehicle.ackerman.lateral_sigma_m_s"
# The last grid has a spacing of half_width / 8 and the parabola is exact for a quadratic cost: only rounding is left.
TOLERANCE = 1e-6


class QuadraticVehicle:
    """NIS per degree of freedom = 0.3 + the squared distance from the true parameters, divided by 1 + slip / 0.1 up to 0.5 m/s."""

    def __init__(self, yaw: float, offset: float, scale: float) -> None:
        self.truth = {YAW: yaw, OFFSET: offset, SCALE: scale}
        self.runs: list[Mapping[str, Scalar]] = []

    def __call__(self, values: Mapping[str, Scalar]) -> tuple[Any, Any]:
        self.runs.append(dict(values))
        miss = sum((float(values[key] or 0.0) - truth) ** 2 for key, truth in self.truth.items())
        slip = min(float(values[SLIP] or 0.0), 0.5)
        return np.array([2.0 * (0.3 + 10.0 * miss) / (1.0 + slip / 0.1)]), np.array([2])


def test_every_parameter_is_found() -> None:
    vehicle = QuadraticVehicle(yaw=-0.021, offset=0.0043, scale=1.037)
    calibration = calibrate(resolve([]), vehicle, PLANS["ackerman"])
    assert calibration.changes[YAW] == pytest.approx(-0.021, abs=TOLERANCE)
    assert calibration.changes[OFFSET] == pytest.approx(0.0043, abs=TOLERANCE)
    assert calibration.changes[SCALE] == pytest.approx(1.037, abs=TOLERANCE)


def test_the_slip_is_the_smallest_that_gains_most() -> None:
    # Cost 0.3 / (1 + slip / 0.1), no more below 0.5: candidates 0, .1, .2, .5, 1 give .3, .15, .1, .05, .05; 0.9 of the gain is .225.
    calibration = calibrate(resolve([]), QuadraticVehicle(0.0, 0.0, 1.0), PLANS["ackerman"])
    assert calibration.changes[SLIP] == 0.5
    assert [entry.value for entry in calibration.scanned[SLIP]] == [0.0, 0.1, 0.2, 0.5, 1.0]


def test_systematic_parameters_are_scanned_without_slip() -> None:
    vehicle = QuadraticVehicle(0.01, 0.0, 1.0)
    settings = resolve([Layer("--set", {SLIP: 0.5})])
    calibrate(settings, vehicle, PLANS["ackerman"])
    candidates = len(PLANS["ackerman"].slip_candidates)
    assert {run[SLIP] for run in vehicle.runs[:-candidates]} == {0.0}


def test_a_found_value_is_used_in_the_next_scan() -> None:
    vehicle = QuadraticVehicle(0.02, 0.001, 1.0)
    calibration = calibrate(resolve([]), vehicle, PLANS["ackerman"])
    assert vehicle.runs[-1][YAW] == calibration.changes[YAW]


def test_no_value_leaves_the_rule_of_its_setting() -> None:
    plan = CalibrationPlan(scans=(Scan(OFFSET, half_width=2.0),), slip_key=SLIP)
    vehicle = QuadraticVehicle(0.0, 0.4, 1.0)
    calibrate(resolve([]), vehicle, plan)
    assert all(-0.5 <= float(run[OFFSET] or 0.0) <= 0.5 for run in vehicle.runs)


def test_the_number_of_runs_is_as_expected() -> None:
    vehicle = QuadraticVehicle(0.0, 0.0, 1.0)
    calibrate(resolve([]), vehicle, PLANS["ackerman"])
    assert len(vehicle.runs) <= expected_runs(PLANS["ackerman"])


def test_the_plans_name_settings_of_the_estimator() -> None:
    for plan in PLANS.values():
        for key in [plan.slip_key, *(scan.key for scan in plan.scans)]:
            assert key in field_descriptions()


def test_increments_have_nothing_to_calibrate() -> None:
    with pytest.raises(UserError, match="vehicles of the kind 'increments' have nothing to calibrate"):
        plan_for(resolve([Layer("--set", {"vehicle.kind": "increments"})]))


def test_without_any_pairing_the_calibration_says_so() -> None:
    with pytest.raises(UserError, match=f"with no value of {YAW} was any observation paired"):
        calibrate(resolve([]), lambda values: (np.zeros(0), np.zeros(0, dtype=np.int64)), PLANS["ackerman"])


def test_the_cost_is_the_sum_of_nis_over_the_sum_of_dof() -> None:
    # (1 + 5) / (2 + 10)
    assert mean_nis_per_dof(np.array([1.0, 5.0]), np.array([2, 10])) == 0.5
