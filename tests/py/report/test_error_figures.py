import numpy as np
import pytest
from plotly.graph_objects import Figure

from ssjs_cli.report.error_figures import axis_errors, position_error
from ssjs_cli.report.figure_style import band, with_gaps


def errors(time_s, error_x, error_y, sigma, outlier=None):
    time_s, error_x, error_y = (np.asarray(column, dtype=np.float64) for column in (time_s, error_x, error_y))
    sigma = np.full(len(time_s), float(sigma))
    is_outlier = np.zeros(len(time_s)) if outlier is None else np.array(outlier)
    return {
        "time_s": time_s, "error_m": np.hypot(error_x, error_y), "is_outlier": is_outlier,
        "error_x_m": error_x, "error_y_m": error_y, "sigma_x_m": sigma, "sigma_y_m": sigma, "sigma_major_m": sigma,
    }  # fmt: skip


def test_position_error_and_three_sigma():
    drawing = position_error(errors([0, 1, 2], [3, 0, 0], [4, 1, 2], 0.5), None)
    Figure(drawing.figure)
    by_name = {trace["name"]: trace for trace in drawing.figure["data"]}
    assert by_name["final error"]["y"] == [5.0, 1.0, 2.0]
    assert by_name["3σ claimed, major axis"]["y"] == [1.5, 1.5, 1.5]
    assert "The largest final error is 5.00 m." in drawing.notes


def test_outliers_count_for_nothing_and_stand_at_the_upper_edge():
    drawing = position_error(errors([0, 1, 2, 3], [1, 50, 1, 1], [0, 0, 0, 0], 0.1, outlier=[0.0, 1.0, 0.0, 0.0]), None)
    by_name = {trace["name"]: trace for trace in drawing.figure["data"]}
    top = drawing.figure["layout"]["yaxis"]["range"][1]
    assert top == pytest.approx(1.08)
    assert by_name["reference outlier"]["y"] == [1.08]
    assert by_name["reference outlier"]["customdata"] == [50.0]
    assert "The largest final error is 1.00 m." in drawing.notes


def test_share_inside_three_sigma_is_stated():
    # sigma 0.1: 0.2 and 0.3 are inside 0.3, 0.4 is not; along y everything is
    drawing = axis_errors(errors([0, 1, 2, 3], [0.2, -0.3, 0.4, 0.0], [0, 0, 0, 0], 0.1), ("x", "y"))
    Figure(drawing.figure)
    assert drawing.notes == ["Inside ±3σ: 75.0 % along x, 100.0 % along y; 99.7 % expected."]
    assert drawing.figure["layout"]["yaxis"]["title"]["text"] == "x error [m]"


def test_one_row_is_no_curve():
    assert position_error(errors([0], [1], [1], 1), None) is None
    assert axis_errors(errors([0, 1], [1, 1], [1, 1], np.nan), ("x", "y")) is None


def test_nothing_is_drawn_across_a_gap():
    # one row a second, then 100 s without; rows 0, 2, 3 are chosen
    time_s = np.array([0.0, 1.0, 2.0, 102.0, 103.0])
    drawn_s, drawn = with_gaps(time_s, 10.0 * time_s, np.array([0, 2, 3]))
    assert np.array_equal(drawn_s, [0.0, 2.0, np.nan, 102.0], equal_nan=True)
    assert np.array_equal(drawn, [0.0, 20.0, np.nan, 1020.0], equal_nan=True)


def test_thinned_rows_are_not_taken_for_gaps():
    time_s = np.arange(0.0, 1000.0, 0.1)
    drawn_s, _ = with_gaps(time_s, time_s, np.array([0, 4000, 4001, 9999]))
    assert not np.isnan(drawn_s).any()


def test_band_is_one_outline_for_each_stretch():
    trace = band([0.0, 1.0, None, 5.0], [0.0, 0.0, None, 0.0], [2.0, 3.0, None, 4.0], "band")
    assert trace["x"] == [0.0, 1.0, 1.0, 0.0, None, 5.0, 5.0, None]
    assert trace["y"] == [2.0, 3.0, 0.0, 0.0, None, 4.0, 0.0, None]
