import numpy as np
import pytest

from ssjs_cli.report.simplification import every_nth, keep_extremes, simplify_line, span_edges


def test_straight_line_needs_its_ends_only():
    points = np.column_stack((np.arange(100.0), 2.0 * np.arange(100.0)))
    line = simplify_line(points, max_points=50, tolerance=1e-9)
    assert line.indices.tolist() == [0, 99]
    assert line.deviation < 1e-9


def test_corner_is_kept_and_the_small_bump_is_stated():
    # (0,0) (5,0.1) (10,0) (10,10): the bump is 0.1 from the chord to (10,0), the corner far from every other chord
    points = np.array([[0.0, 0.0], [5.0, 0.1], [10.0, 0.0], [10.0, 10.0]])
    line = simplify_line(points, max_points=3, tolerance=0.0)
    assert line.indices.tolist() == [0, 2, 3]
    assert line.deviation == pytest.approx(0.1)


def test_closed_track_does_not_collapse():
    # first and last point coincide: distances count from that point, so the far corner comes first
    square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0], [0.0, 0.0]])
    assert simplify_line(square, max_points=10, tolerance=0.01).indices.tolist() == [0, 1, 2, 3, 4]


def test_no_point_left_out_is_farther_than_stated():
    rng = np.random.default_rng(3)
    points = np.cumsum(rng.normal(size=(800, 2)), axis=0)
    line = simplify_line(points, max_points=120, tolerance=0.0)
    assert len(line.indices) == 120
    worst = 0.0
    for first, last in zip(line.indices[:-1], line.indices[1:], strict=True):
        chord = points[last] - points[first]
        for point in points[first : last + 1]:
            along = np.clip((point - points[first]) @ chord / (chord @ chord), 0.0, 1.0)
            worst = max(worst, float(np.hypot(*(point - points[first] - along * chord))))
    assert worst == pytest.approx(line.deviation)


@pytest.mark.parametrize("count", [0, 1, 2])
def test_short_lines_stay_whole(count):
    assert simplify_line(np.zeros((count, 2)), 10, 0.1).indices.tolist() == list(range(count))


def test_spans_are_equal_in_time_not_in_rows():
    # cuts at 5: rows 0..3 lie in the first half of the time, row 4 in the second
    time_s = np.array([0.0, 1.0, 2.0, 3.0, 10.0])
    assert span_edges(time_s, 2).tolist() == [0, 4, 5]


def test_standing_clock_gives_one_span():
    assert span_edges(np.full(5, 7.0), 3).tolist() == [0, 5]


def test_every_peak_survives():
    time_s = np.linspace(0.0, 100.0, 10_001)
    value = np.zeros(10_001)
    value[[1234, 7777]] = 5.0, -3.0
    rows = keep_extremes(time_s, value, spans=50)
    assert {0, 1234, 7777, 10_000} <= set(rows.tolist())
    assert len(rows) <= 4 * 50
    assert (np.diff(rows) > 0).all()


def test_few_rows_are_all_kept():
    assert keep_extremes(np.arange(8.0), np.arange(8.0), spans=2).tolist() == list(range(8))


def test_every_nth_keeps_at_most_what_is_asked():
    # 10 rows, at most 4: every third, rows 0 3 6 9
    rows, stride = every_nth(10, 4)
    assert (rows.tolist(), stride) == ([0, 3, 6, 9], 3)
    assert every_nth(4, 4)[1] == 1
