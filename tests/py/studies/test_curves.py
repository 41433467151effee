import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ssjs_cli.studies.curves import counted_from, cumulative_time, nis_over_time, round_interval, time_origin_s


@given(st.floats(1e-3, 1e7), st.integers(1, 1000))
def test_a_round_interval_cuts_into_enough_and_not_too_many_parts(duration_s: float, parts: int) -> None:
    interval_s = round_interval(duration_s, parts)
    assert interval_s * parts <= duration_s * (1.0 + 1e-9)
    assert 2.5 * interval_s * parts >= duration_s * (1.0 - 1e-9)
    digit = float(f"{interval_s:e}".split("e")[0])
    assert digit in (1.0, 2.0, 5.0)


@pytest.mark.parametrize(("duration_s", "interval_s"), [(642.3, 2.0), (200.0, 1.0), (199.9, 0.5), (1000.0, 5.0), (999.9, 2.0)])
def test_the_interval_is_the_largest_round_one(duration_s: float, interval_s: float) -> None:
    assert round_interval(duration_s, 200) == pytest.approx(interval_s)


def test_time_spent_ends_with_the_sum_of_all_steps() -> None:
    time_s = np.linspace(0.0, 99.0, 1000)
    step_time_us = np.arange(1000.0)
    curve = cumulative_time({"time_s": time_s, "step_time_us": step_time_us})
    # 0 + 1 + ... + 999 us
    assert curve["spent_s"][-1] == pytest.approx(499500e-6)
    assert curve["time_s"][-1] == 99.0
    assert all(np.diff(curve["spent_s"]) >= 0.0)
    assert len(curve["time_s"]) <= 300


def test_nis_is_summed_by_spans_and_empty_spans_stay() -> None:
    updates = {"time_s": [0.5, 1.5, 1.6, 80.0], "nis": [1.0, 2.0, 3.0, 9.0], "dof": [2, 2, 4, 6]}
    curve = nis_over_time({"time_s": [0.0, 80.0], "updates": updates})
    assert curve is not None
    # 80 s in at least 80 spans: 1 s each, the last one closed
    assert len(curve["time_s"]) == 80
    assert curve["time_s"][:2] == [0.5, 1.5]
    assert (curve["nis"][:3], curve["dof"][:3]) == ([1.0, 5.0, 0.0], [2.0, 6.0, 0.0])
    assert (curve["nis"][-1], curve["dof"][-1]) == (9.0, 6.0)
    assert nis_over_time({"time_s": [0.0, 80.0], "updates": {"time_s": [], "nis": [], "dof": []}}) is None


def test_times_of_a_calendar_clock_count_from_the_start() -> None:
    assert time_origin_s({"time_s": [12.5, 13.0]}) == 0.0
    assert time_origin_s({"time_s": [1248446200.25, 1248446300.0]}) == 1248446200.25
    curves = {"error": {"final": {"time_s": [1248446200.25, None, 1248446201.0], "error_m": [1.0, None, 2.0]}}, "nees": None}
    expected = {"error": {"final": {"time_s": [0.0, None, 0.75], "error_m": [1.0, None, 2.0]}}, "nees": None}
    assert counted_from(1248446200.25, curves) == expected
