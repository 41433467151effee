import math

import numpy as np
import pytest

from ssjs_cli.cascade.scoring import Scored, bootstrap_band, curve, match, wilson_band
from ssjs_cli.cascade.window_boxes import intersection_over_union, object_box, window_box


def test_intersection_over_union_by_hand() -> None:
    # 10 x 10 each, moved by 5: 50 of 150
    assert intersection_over_union((0, 0, 10, 10), (5, 0, 10, 10)) == pytest.approx(50 / 150)
    assert intersection_over_union((0, 0, 10, 10), (0, 0, 10, 10)) == 1.0
    assert intersection_over_union((0, 0, 10, 10), (10, 0, 10, 10)) == 0.0
    assert intersection_over_union((0, 0, 10, 10), (20, 20, 10, 10)) == 0.0


def test_an_object_is_found_once_by_the_best_score() -> None:
    objects = [(0, 0, 10, 10), (40, 0, 10, 10)]
    matched = match(
        [Scored((1, 0, 10, 10), 1.0), Scored((0, 0, 10, 10), 0.5), Scored((41, 0, 10, 10), 2.0), Scored((80, 0, 10, 10), 3.0)], objects, 0.3
    )
    assert [detection.score for detection in matched.detections] == [3.0, 2.0, 1.0, 0.5]
    assert matched.found == [None, 1, 0, None]
    assert matched.missed() == []


def test_a_detection_takes_what_it_overlaps_most() -> None:
    matched = match([Scored((4, 0, 10, 10), 1.0)], [(0, 0, 10, 10), (5, 0, 10, 10)], 0.3)
    assert matched.found == [1]
    assert matched.missed() == [0]
    assert match([Scored((8, 0, 10, 10), 1.0)], [(0, 0, 10, 10)], 0.3).found == [None]  # 20 of 180


def test_curves_by_hand() -> None:
    """Two pictures, three objects; scores 5 right, 4 false, 3 right, 2 false and right at once."""
    first = match([Scored((0, 0, 10, 10), 5.0), Scored((50, 50, 10, 10), 4.0), Scored((70, 70, 10, 10), 2.0)], [(0, 0, 10, 10)], 0.5, "a")
    second = match([Scored((0, 0, 10, 10), 3.0), Scored((30, 0, 10, 10), 2.0)], [(0, 0, 10, 10), (30, 0, 10, 10)], 0.5, "b")
    made = curve([first, second])
    assert made.thresholds.tolist() == [5.0, 4.0, 3.0, 2.0]
    assert made.detection_rate.tolist() == pytest.approx([1 / 3, 1 / 3, 2 / 3, 1.0])
    assert made.false_per_image.tolist() == [0.0, 0.5, 0.5, 1.0]
    assert made.precision.tolist() == pytest.approx([1.0, 1 / 2, 2 / 3, 3 / 5])
    assert made.rate_at(np.array([0.0, 0.4, 0.5, 2.0])).tolist() == pytest.approx([1 / 3, 1 / 3, 2 / 3, 1.0])
    # thirds of recall, at the best precision of that recall or a greater one
    assert made.average_precision() == pytest.approx((1.0 + 2 / 3 + 3 / 5) / 3)


def test_of_equal_scores_the_one_with_more_windows_is_better() -> None:
    matched = match([Scored((50, 0, 10, 10), 1.0, 2), Scored((0, 0, 10, 10), 1.0, 9)], [(0, 0, 10, 10)], 0.5)
    assert [detection.neighbours for detection in matched.detections] == [9, 2]
    made = curve([matched])
    assert made.thresholds.tolist() == [1.0, 1.0]
    assert made.precision.tolist() == [1.0, 0.5]


def test_nothing_detected_is_no_curve_and_no_error() -> None:
    made = curve([match([], [(0, 0, 10, 10)], 0.5)])
    assert made.rate_at(1.0) == 0.0
    assert made.average_precision() == 0.0


def test_the_wilson_interval_is_the_one_of_the_formula() -> None:
    # its ends solve (p - rate)^2 = z^2 p (1 - p) / n
    for successes, trials in ((8, 10), (0, 20), (20, 20), (450, 1000)):
        rate, z = successes / trials, 1.959963984540054
        for end in wilson_band(successes, trials):
            assert (end - rate) ** 2 == pytest.approx(z**2 * end * (1 - end) / trials, abs=1e-12)
    assert wilson_band(0, 0) == (0.0, 1.0)


def test_the_band_covers_the_true_rate_about_as_often_as_it_says() -> None:
    """Thirty recordings of four objects, each found with a chance of 0.7: the middle 95 % of 200 bands hold it in most cases."""
    rng = np.random.default_rng(4)
    covered = 0
    for trial in range(100):
        matches = []
        for recording in range(30):
            hits = rng.random(4) < 0.7
            boxes = [(20 * index, 0, 10, 10) for index in range(4)]
            matches.append(match([Scored(box, 1.0) for box, hit in zip(boxes, hits, strict=True) if hit], boxes, 0.5, str(recording)))
        band = bootstrap_band(matches, np.array([0.0]), 200, trial)
        assert band is not None
        covered += bool(band[0][0] <= 0.7 <= band[1][0])
    assert covered >= 95 - 3 * math.sqrt(100 * 0.95 * 0.05)


def test_there_is_no_band_for_one_recording() -> None:
    assert bootstrap_band([match([], [(0, 0, 9, 9)], 0.5, "a")] * 3, np.array([1.0]), 50, 1) is None


def test_windows_are_grown_about_the_object_and_moved_into_the_picture() -> None:
    # 20 x 10 with a tenth on each side is 24 x 12, in a square window 24 x 24 about (50, 45)
    assert window_box((40, 40, 20, 10), 0.1, (24, 24), (200, 200)) == (38, 33, 24, 24)
    assert window_box((0, 195, 20, 5), 0.1, (24, 24), (200, 200)) == (0, 176, 24, 24)
    assert window_box((0, 0, 190, 5), 0.1, (24, 24), (200, 200)) is None


def test_the_object_of_a_window_is_the_window_without_its_margin() -> None:
    assert object_box((38, 33, 24, 24), 0.1) == (40, 35, 20, 20)
    assert object_box((3, 4, 5, 6), 0.0) == (3, 4, 5, 6)
