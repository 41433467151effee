import numpy as np
import pytest

from ssjs_cli.errors import UserError
from ssjs_cli.formats.mission import UNKNOWN_LANDMARK
from ssjs_cli.formats.tum import PoseSeries
from ssjs_cli.simulated_posts import ScanningSonar, place_posts, simulate_posts

TIME_S = np.linspace(0.0, 600.0, 601)


def a_way(heading_rad: float = 0.3) -> PoseSeries:
    """Ten minutes ahead at 0.2 m/s."""
    along = 0.2 * TIME_S
    return PoseSeries(TIME_S, np.column_stack([along * np.cos(heading_rad), along * np.sin(heading_rad), np.full(601, heading_rad)]))


def test_a_sighting_leads_from_the_true_pose_to_its_post() -> None:
    way = a_way()
    seen = simulate_posts(way, 25, seed=3)
    points = seen.points
    assert points.landmark_id is not None and points.covariance_m2 is not None
    real = points.landmark_id != UNKNOWN_LANDMARK
    assert int((~real).sum()) == seen.clutter
    cos, sin = np.cos(0.3), np.sin(0.3)
    x, y = points.position_m[real, 0], points.position_m[real, 1]
    at = 0.2 * points.time_s[real, None] * np.array([cos, sin])
    placed = at + np.column_stack([cos * x - sin * y, sin * x + cos * y])
    error = placed - seen.landmarks.position_m[points.landmark_id[real]]
    turned = np.column_stack([cos * error[:, 0] + sin * error[:, 1], -sin * error[:, 0] + cos * error[:, 1]])
    covariance = points.covariance_m2[real][:, [0, 1, 1, 3]].reshape(-1, 2, 2)
    nees = np.einsum("ni,nij,nj->n", turned, np.linalg.inv(covariance), turned)
    assert real.sum() > 150
    assert nees.mean() == pytest.approx(2.0, abs=4.0 * np.sqrt(4.0 / real.sum()))


def test_a_post_is_seen_once_a_turn_as_often_as_it_is_detected() -> None:
    sonar = ScanningSonar(clutter_per_turn=0.0)
    still = PoseSeries(TIME_S, np.zeros((601, 3)))
    seen = simulate_posts(still, 5, seed=1, sonar=sonar)
    turns = 600.0 / (sonar.ping_interval_s * sonar.pings_per_turn)
    assert seen.clutter == 0
    assert len(seen.points.time_s) == pytest.approx(5 * turns * sonar.detection_probability, rel=0.15)


def test_clutter_is_within_reach_and_as_dense_as_asked() -> None:
    sonar = ScanningSonar(clutter_per_turn=5.0)
    points = simulate_posts(a_way(), 1, seed=2, sonar=sonar).points
    assert points.landmark_id is not None
    clutter = points.position_m[points.landmark_id == UNKNOWN_LANDMARK]
    assert len(clutter) == pytest.approx(5.0 * 600.0 / 13.8, rel=0.2)
    range_m = np.hypot(clutter[:, 0], clutter[:, 1])
    assert range_m.max() <= sonar.max_range_m and range_m.min() >= sonar.min_range_m
    assert (range_m**2).mean() == pytest.approx(0.5 * sonar.max_range_m**2, rel=0.15)  # evenly over the disc


def test_the_same_seed_gives_the_same_echoes_and_another_gives_others() -> None:
    first, again, other = (simulate_posts(a_way(), 10, seed=seed).points.position_m for seed in (7, 7, 8))
    assert np.array_equal(first, again)
    assert not np.array_equal(first[:5], other[:5])


def test_more_posts_than_fit_are_refused() -> None:
    sonar = ScanningSonar(max_range_m=4.0)
    with pytest.raises(UserError, match=r"40 landmarks do not fit around the track; ask for fewer than \d+"):
        place_posts(np.zeros((1, 2)), 40, sonar, np.random.default_rng(1))
