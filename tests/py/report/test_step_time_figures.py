import numpy as np
from plotly.graph_objects import Figure

from ssjs_cli.report.step_time_figures import step_times


def test_quantiles_and_counts():
    # 1..1001 us: the median is 501, 90 % is 901, the largest 1,001
    answer = step_times({"time_s": np.arange(1001.0), "step_time_us": np.arange(1.0, 1002.0)})
    Figure(answer.histogram)
    Figure(answer.over_time)
    assert dict(answer.quantiles) == {"median": "501 µs", "90 %": "901 µs", "99 %": "991 µs", "99.9 %": "1 ms", "largest": "1 ms"}
    assert sum(answer.histogram["data"][0]["y"]) == 1001


def test_equal_times_and_zero_times_are_drawn():
    answer = step_times({"time_s": np.arange(5.0), "step_time_us": np.array([0.0, 2.0, 2.0, 2.0, 2.0])})
    assert sum(answer.histogram["data"][0]["y"]) == 5
    assert min(answer.over_time["data"][2]["y"]) == 2.0


def test_decades_are_named_with_their_unit():
    answer = step_times({"time_s": np.arange(3.0), "step_time_us": np.array([2.0, 300.0, 40_000.0])})
    assert answer.histogram["layout"]["xaxis"]["ticktext"] == ["1 µs", "10 µs", "100 µs", "1 ms", "10 ms", "100 ms"]


def test_without_times():
    assert step_times({"time_s": np.arange(2.0), "step_time_us": np.array([np.nan, 1.0])}) is None
