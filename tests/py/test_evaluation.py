"""A vehicle that drives 10 m along x in 10 s, one pose a second, against references whose errors are known."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ssjs_cli.evaluation import evaluate, position_consistency, with_alignment
from ssjs_cli.formats.mission import Fixes, Reference, ReferenceDescription, SurveyedLandmarks
from ssjs_cli.formats.number_table import FloatArray, read_table
from ssjs_cli.formats.run_directory import ERROR_HEADER, REFERENCE_KEYS, Bases, Estimate, Landmarks
from ssjs_cli.formats.tum import PoseSeries

TIMES = np.arange(11.0)
STRAIGHT = np.column_stack([TIMES, np.zeros(11), np.zeros(11)])
# sigma_x 0.1 m, sigma_y 0.2 m, sigma_heading 0.01 rad, uncorrelated
COVARIANCE = np.tile([0.01, 0.0, 0.0, 0.04, 0.0, 1e-4], (11, 1))


def estimate_of(pose: FloatArray = STRAIGHT, *, landmarks: Landmarks | None = None, bases: Bases | None = None) -> Estimate:
    no_landmarks = Landmarks(np.zeros(0, np.int64), False, np.zeros((0, 2)), np.zeros((0, 3)), np.zeros(0, np.int64), np.zeros(0, np.int64))
    series = PoseSeries(TIMES, pose)
    return Estimate(series, COVARIANCE, series, COVARIANCE, series, landmarks or no_landmarks, bases, TIMES)


def column(table: object, name: str) -> list[float]:
    columns = getattr(table, "columns")  # noqa: B009
    values: list[float] = np.asarray(columns[ERROR_HEADER.split(",").index(name)], dtype=float).tolist()
    return values


def test_without_a_reference_every_key_is_unknown() -> None:
    evaluation = evaluate(estimate_of(), Reference(ReferenceDescription()))
    assert evaluation.summary == dict.fromkeys(REFERENCE_KEYS)
    assert evaluation.errors is None
    assert evaluation.lost == []


def under_water(pose: FloatArray, depth_m: float, landmarks: Landmarks | None = None) -> Estimate:
    """sigma of the depth 0.05 m"""
    space = np.column_stack([np.full(11, depth_m), np.zeros(11), np.zeros(11)])
    covariance = np.zeros((11, 21))
    covariance[:, [0, 1, 5, 6, 10, 20]] = COVARIANCE[:, [0, 1, 2, 3, 4, 5]]
    covariance[:, 11] = 0.0025
    estimate = estimate_of(landmarks=landmarks)
    return replace(estimate, final=PoseSeries(TIMES, pose, space), space_covariances=(covariance, covariance))


@pytest.mark.parametrize(("depth_m", "inside"), [(12.14, 1.0), (12.16, 0.0)])
def test_the_depth_has_its_own_three_sigma(depth_m: float, inside: float) -> None:
    # 3 sigma are 0.15 m
    truth = PoseSeries(TIMES, STRAIGHT, np.column_stack([np.full(11, 12.0), np.zeros(11), np.zeros(11)]))
    summary = evaluate(under_water(STRAIGHT, depth_m), Reference(ReferenceDescription(alignment="none"), truth=truth)).summary
    assert summary["inside_3_sigma_depth_fraction"] == pytest.approx(inside)


def test_contacts_are_found_false_or_a_second_one_of_an_object() -> None:
    # objects at (0, 0), (20, 0), (40, 0); contacts 0.6 m and 2 m off the first, 0.8 m off the second, and one 9 m from the third
    points = np.array([[0.0, 0.6], [0.0, -2.0], [20.8, 0.0], [40.0, 9.0]])
    landmarks = Landmarks(np.arange(4), False, points, np.tile([0.01, 0.0, 0.01], (4, 1)), np.ones(4, np.int64), np.zeros(4, np.int64))
    objects = SurveyedLandmarks(np.arange(3), np.array([[0.0, 0.0], [20.0, 0.0], [40.0, 0.0]]))
    truth = PoseSeries(TIMES, STRAIGHT)
    reference = Reference(ReferenceDescription(alignment="none"), truth=truth, landmarks=objects)
    summary = evaluate(under_water(STRAIGHT, 12.0, landmarks), reference).summary
    assert (summary["objects"], summary["contacts"]) == (3, 4)
    assert (summary["contacts_found"], summary["contacts_false"], summary["contacts_duplicate"]) == (2, 2, 1)
    assert summary["contacts_found_fraction"] == pytest.approx(2 / 3, abs=1e-6)
    assert summary["contacts_false_fraction"] == pytest.approx(0.5)
    # sqrt((0.6^2 + 0.8^2) / 2)
    assert summary["contact_position_rms_m"] == pytest.approx(math.sqrt(0.5), abs=1e-6)
    assert evaluate(estimate_of(landmarks=landmarks), reference).summary["contacts"] is None


def test_a_constant_offset_is_the_error_without_alignment_and_vanishes_with_it() -> None:
    # Fixes 0.3 m to the left and 0.4 m ahead: every error is 0.5 m.
    fixes = Fixes(TIMES, STRAIGHT[:, :2] + [0.4, 0.3])
    raw = evaluate(estimate_of(), Reference(ReferenceDescription(alignment="none"), fixes=fixes))
    assert raw.summary["trajectory_rmse_m"] == pytest.approx(0.5)
    assert raw.summary["trajectory_std_m"] == pytest.approx(0.0, abs=1e-6)
    # 100 * 0.5 m / 10 m
    assert raw.summary["final_drift_percent"] == pytest.approx(5.0)
    assert raw.summary["dead_reckoning_rmse_m"] == pytest.approx(0.5)
    assert raw.summary["alignment"] == "none"
    assert raw.errors is not None
    assert column(raw.errors, "error_x_m") == pytest.approx([-0.4] * 11)
    assert column(raw.errors, "error_y_m") == pytest.approx([-0.3] * 11)
    assert column(raw.errors, "sigma_x_m") == pytest.approx([0.1] * 11)
    assert column(raw.errors, "sigma_major_m") == pytest.approx([0.2] * 11)
    aligned = evaluate(estimate_of(), with_alignment(Reference(ReferenceDescription(), fixes=fixes), "se2"))
    assert aligned.summary["trajectory_rmse_m"] == pytest.approx(0.0, abs=1e-6)
    assert aligned.summary["alignment"] == "se2"


def test_alignment_turns_the_ellipse_and_moves_the_reference_back() -> None:
    # The reference drives along y: the estimate is turned by 90 degrees, its x sigma becomes the y sigma.
    fixes = Fixes(TIMES, np.column_stack([np.full(11, 5.0), TIMES]))
    evaluation = evaluate(estimate_of(), Reference(ReferenceDescription(alignment="se2"), fixes=fixes))
    assert evaluation.summary["trajectory_rmse_m"] == pytest.approx(0.0, abs=1e-6)
    assert evaluation.errors is not None
    assert column(evaluation.errors, "sigma_x_m") == pytest.approx([0.2] * 11)
    assert column(evaluation.errors, "sigma_y_m") == pytest.approx([0.1] * 11)
    assert evaluation.reference is not None
    assert np.column_stack(evaluation.reference[1:]) == pytest.approx(STRAIGHT[:, :2], abs=1e-9)


def test_the_lever_arm_moves_the_compared_point_and_widens_its_sigma() -> None:
    # An antenna 2 m ahead of the vehicle: exact, and sigma_y^2 = 0.04 + (2 m * 0.01 rad)^2 = 0.0404
    fixes = Fixes(TIMES, STRAIGHT[:, :2] + [2.0, 0.0])
    evaluation = evaluate(estimate_of(), Reference(ReferenceDescription(lever_arm_forward_m=2.0), fixes=fixes))
    assert evaluation.summary["trajectory_rmse_m"] == pytest.approx(0.0, abs=1e-6)
    assert evaluation.errors is not None
    assert column(evaluation.errors, "sigma_y_m") == pytest.approx([math.sqrt(0.0404)] * 11)


def test_outliers_are_rejected_counted_and_marked() -> None:
    position = STRAIGHT[:, :2].copy()
    position[4] += [0.0, 50.0]
    reference = Reference(ReferenceDescription(outlier_m=10.0, alignment="none"), fixes=Fixes(TIMES, position))
    evaluation = evaluate(estimate_of(), reference)
    assert evaluation.summary["reference_outliers"] == 1
    assert evaluation.summary["reference_compared"] == 11
    assert evaluation.summary["trajectory_rmse_m"] == pytest.approx(0.0, abs=1e-6)
    assert evaluation.summary["dead_reckoning_rmse_m"] == pytest.approx(0.0, abs=1e-6)
    assert evaluation.errors is not None
    assert column(evaluation.errors, "is_outlier") == [1.0 if row == 4 else 0.0 for row in range(11)]


def test_of_several_estimates_at_one_time_the_last_counts() -> None:
    time_s = np.array([0.0, 1.0, 1.0, 2.0])
    series = PoseSeries(time_s, np.array([[0.0, 0, 0], [9.0, 9.0, 0], [1.0, 0, 0], [2.0, 0, 0]]))
    base = estimate_of()
    estimate = Estimate(series, COVARIANCE[:4], series, COVARIANCE[:4], series, base.landmarks, None, time_s)
    fixes = Fixes(np.array([0.5, 1.0]), np.array([[0.5, 0.0], [1.0, 0.0]]))
    evaluation = evaluate(estimate, Reference(ReferenceDescription(), fixes=fixes))
    assert evaluation.summary["trajectory_max_m"] == pytest.approx(0.0, abs=1e-6)


def test_a_reference_of_another_time_is_lost_and_said() -> None:
    fixes = Fixes(TIMES + 1000.0, STRAIGHT[:, :2])
    evaluation = evaluate(estimate_of(), Reference(ReferenceDescription(), fixes=fixes))
    assert evaluation.summary["trajectory_rmse_m"] is None
    (text,) = evaluation.lost
    assert text.startswith("the reference covers 1000.000 to 1010.000 s and the run 0.000 to 10.000 s")


def test_pose_nees_by_hand() -> None:
    # Truth 0.1 m ahead (1 sigma), 0.4 m to the left (2 sigma) and 0.03 rad turned (3 sigma): 1 + 4 + 9 = 14. The first pose is exact:
    # it defines the frame.
    pose = STRAIGHT.copy()
    truth = STRAIGHT + np.array([0.1, 0.4, 0.03])
    truth[0] = pose[0]
    evaluation = evaluate(estimate_of(pose), Reference(ReferenceDescription(alignment="none"), truth=PoseSeries(TIMES, truth)))
    assert evaluation.nees is not None
    assert evaluation.nees[1].tolist() == pytest.approx([0.0] + [14.0] * 10)
    assert evaluation.nees[2].tolist() == [3] * 11
    assert evaluation.summary["nees_mean"] == pytest.approx(140.0 / 11.0)
    assert evaluation.summary["nees_dof"] == 3


def test_nees_is_judged_from_the_start_whatever_the_alignment() -> None:
    # The truth starts at (5, 7) heading along y and drives exactly as estimated: NEES 0 under every alignment.
    truth = PoseSeries(TIMES, np.column_stack([np.full(11, 5.0), 7.0 + TIMES, np.full(11, math.pi / 2)]))
    for alignment in ("none", "se2"):
        evaluation = evaluate(estimate_of(), Reference(ReferenceDescription(alignment=alignment), truth=truth))
        assert evaluation.summary["nees_mean"] == pytest.approx(0.0, abs=1e-6)


def test_an_uncertain_start_is_not_moved_to_the_truth() -> None:
    # Position fixes put the whole mission 0.1 m (1 sigma) off; the start is as wrong as the rest, in heading by 2 sigma besides. Moved
    # there, the end would be 10 m * 0.02 rad = 0.2 m = 1 sigma off to the side.
    pose = STRAIGHT + np.array([0.1, 0.0, 0.0])
    pose[0, 2] = 0.02
    first = np.array([[0.01, 0, 0, 0.04, 0, 1e-4]])
    bases = Bases(np.array([0.0]), pose[:1], first, None)
    reference = Reference(ReferenceDescription(alignment="none"), truth=PoseSeries(TIMES, STRAIGHT))
    evaluation = evaluate(estimate_of(pose, bases=bases), reference)
    assert evaluation.nees is not None
    assert evaluation.nees[1].tolist() == pytest.approx([5.0] + [1.0] * 10)
    assert evaluation.summary["nees_base_mean"] == pytest.approx(5.0)
    assert evaluation.summary["nees_position_per_dof"] == pytest.approx(0.5)


def test_base_nees_leaves_out_the_exact_first_base() -> None:
    joint = np.zeros((9, 9))
    joint[3:6, 3:6] = joint[6:9, 6:9] = np.diag([0.01, 0.04, 1e-4])
    alone = np.array([[0.0] * 6, [0.01, 0, 0, 0.04, 0, 1e-4], [0.01, 0, 0, 0.04, 0, 1e-4]])
    bases = Bases(np.array([0.0, 4.0, 8.0]), np.array([[0.0, 0, 0], [4.1, 0, 0], [8.0, 0.4, 0]]), alone, joint)
    reference = Reference(ReferenceDescription(), truth=PoseSeries(TIMES, STRAIGHT))
    evaluation = evaluate(estimate_of(bases=bases), reference)
    # (0.1 / 0.1)^2 = 1 and (0.4 / 0.2)^2 = 4: mean 2.5; together 5 over 6 degrees of freedom
    assert evaluation.summary["nees_base_mean"] == pytest.approx(2.5)
    assert evaluation.summary["nees_joint_per_dof"] == pytest.approx(5.0 / 6.0)
    without_joint = evaluate(estimate_of(bases=replace(bases, joint_covariance=None)), reference).summary
    assert without_joint["nees_base_mean"] == pytest.approx(2.5)
    assert without_joint["nees_joint_per_dof"] is None


def test_map_errors_by_identity() -> None:
    landmarks = Landmarks(
        np.array([7, 8, 9]),
        True,
        np.array([[1.0, 0.3], [2.0, 0.0], [50.0, 50.0]]),
        np.tile([0.09, 0.0, 0.09], (3, 1)),
        np.ones(3, np.int64),
        np.zeros(3, np.int64),
    )
    truth = SurveyedLandmarks(np.array([7, 8, 4]), np.array([[1.0, 0.0], [2.0, 0.0], [9.0, 9.0]]))
    reference = Reference(ReferenceDescription(), truth=PoseSeries(TIMES, STRAIGHT), landmarks=truth)
    summary = evaluate(estimate_of(landmarks=landmarks), reference).summary
    # Errors 0.3 and 0; landmark 9 is nobody, landmark 4 was never seen. NEES 0.09 / 0.09 = 1 and 0.
    assert summary["map_error_mean_m"] == pytest.approx(0.15)
    assert summary["map_error_max_m"] == pytest.approx(0.3)
    assert (summary["landmarks_missed"], summary["landmarks_false"], summary["map_error_matched"]) == (1, 1, 2)
    assert summary["nees_map_mean"] == pytest.approx(0.5)


def test_the_tables_are_written_and_stale_ones_removed(tmp_path: Path) -> None:
    fixes = Fixes(TIMES, STRAIGHT[:, :2] + [0.4, 0.3])
    evaluate(estimate_of(), Reference(ReferenceDescription(), fixes=fixes)).write(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["errors.csv", "errors_online.csv", "reference.csv"]
    table = read_table(tmp_path / "errors.csv", required=ERROR_HEADER.split(","))
    assert table["error_m"] == pytest.approx(np.full(11, 0.5))
    evaluate(estimate_of(), Reference(ReferenceDescription())).write(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_e10_errors_within_three_standard_deviations() -> None:
    # errors (1, 0) and (0, 7) m with standard deviations 1 and 2 m: NEES 1 and 49 / 4, per degree of freedom of two 0.5 and 6.125; the
    # second lies 3.5 standard deviations off. A third pose is exact by definition and has none.
    time_s = np.array([0.0, 1.0, 2.0])
    truth = PoseSeries(np.array([0.0, 1.0, 2.0]), np.zeros((3, 3)))
    estimate = PoseSeries(time_s, np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.1], [0.0, 7.0, -0.1]]))
    covariance = np.array([[0.0] * 6, [1.0, 0.0, 0.0, 4.0, 0.0, 1.0], [1.0, 0.0, 0.0, 4.0, 0.0, 1.0]])
    judged = position_consistency(estimate, covariance, truth, np.zeros(3), 10.0)
    assert judged is not None
    assert judged[0] == pytest.approx((0.5 + 6.125) / 2)
    assert judged[1] == 0.5
    # the same in a frame turned by 90 degrees, with the covariance of its own axes
    turned = PoseSeries(time_s, np.array([[0.0, 0.0, 0.0], [0.0, -1.0, 0.0], [7.0, 0.0, 0.0]]))
    swapped = covariance[:, [3, 1, 2, 0, 4, 5]]
    assert position_consistency(turned, swapped, truth, np.array([0.0, 0.0, np.pi / 2]), 10.0) == pytest.approx(judged)
    assert position_consistency(estimate, np.zeros((3, 6)), truth, np.zeros(3), 10.0) is None
