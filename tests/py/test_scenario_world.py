import numpy as np
import pytest

from ssjs_cli.scenario_world import landmarks_of, simulator_config, waypoints_of


def lawn_mower(**more: object) -> dict[str, object]:
    return {
        "lines": 2,
        "line_spacing_m": 10.0,
        "first_line_m": 1.0,
        "start_m": 5.0,
        "end_m": 95.0,
        "along": "x",
        "return_between": False,
        **more,
    }


def test_lines_are_driven_to_and_fro() -> None:
    assert waypoints_of({"lawn_mower": lawn_mower()}).tolist() == [[5.0, 1.0], [95.0, 1.0], [95.0, 11.0], [5.0, 11.0]]


def test_lines_along_y_swap_the_axes() -> None:
    assert waypoints_of({"lawn_mower": lawn_mower(along="y")}).tolist() == [[1.0, 5.0], [1.0, 95.0], [11.0, 95.0], [11.0, 5.0]]


def test_the_way_back_runs_between_the_lines() -> None:
    points = waypoints_of({"lawn_mower": lawn_mower(return_between=True)})
    assert points[4:].tolist() == [[5.0, 16.0], [95.0, 16.0], [95.0, 6.0], [5.0, 6.0]]


def test_laps_close_the_circuit() -> None:
    corner = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0]]
    assert waypoints_of({"waypoints_m": corner, "laps": 2}).tolist() == [*corner, *corner, [0.0, 0.0]]
    assert waypoints_of({"waypoints_m": corner}).tolist() == corner


def test_a_field_begins_at_its_origin() -> None:
    points = landmarks_of({"grid": {"columns": 2, "rows": 2, "spacing_m": 3.0, "jitter_m": 0.0, "origin_m": [10.0, -5.0]}}, 1, "test")
    assert points.tolist() == [[10.0, -5.0], [13.0, -5.0], [10.0, -2.0], [13.0, -2.0]]
    points = landmarks_of(
        {"random": {"count": 50, "width_m": 4.0, "height_m": 2.0, "min_distance_m": 0.1, "origin_m": [10.0, -5.0]}}, 1, "test"
    )
    assert (points.min(axis=0) >= [10.0, -5.0]).all()
    assert (points.max(axis=0) <= [14.0, -3.0]).all()
    distance = np.hypot(*(points[:, None] - points[None]).transpose(2, 0, 1))
    assert distance[np.triu_indices(50, 1)].min() >= 0.1


def test_the_scan_period_becomes_steps() -> None:
    # 0.3 / 0.0125 is 23.999999999999996 in binary numbers
    assert simulator_config({"sensor": {"scan_period_s": 0.3}}, "test")["steps_per_scan"] == 24


@pytest.mark.parametrize("given", [{}, {"noise_step_s": 0.5}])
def test_the_noise_is_that_of_one_step_unless_said_otherwise(given: dict[str, float]) -> None:
    config = simulator_config({"vehicle": {"step_s": 0.2, **given}}, "test")
    assert config["vehicle.noise_step_s"] == given.get("noise_step_s", 0.2)
