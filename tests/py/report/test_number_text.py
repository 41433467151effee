import math

import pytest

from ssjs_cli.report.number_text import count_text, finite_number, metres_text, percent_text, plain_text, seconds_text, times_text


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0 m"), (0.00123, "0.0012 m"), (0.0456, "0.046 m"), (1.404, "1.40 m"), (-12.345, "-12.35 m"), (4123.44, "4,123.4 m")],
)
def test_metres(value, text):
    assert metres_text(value) == text


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0 s"), (3.14e-6, "3.14 µs"), (0.0118, "11.8 ms"), (1.94, "1.94 s"), (1549.2, "1,549 s"), (999.9e-6, "1 ms"), (0.9999, "1 s")],
)
def test_seconds(value, text):
    assert seconds_text(value) == text


def test_counts_shares_and_plain_numbers():
    assert count_text(61_945) == "61,945"
    assert percent_text(0.9534) == "95.3 %"
    assert [plain_text(value) for value in (3.0, 2.9436, 12044.13)] == ["3", "2.944", "12,044.1"]


def test_times_never_stand_as_powers_of_ten():
    assert [times_text(factor) for factor in (1.04, 9.94, 9.96, 107.2, 1830.0)] == ["1", "9.9", "10", "107", "1,830"]


@pytest.mark.parametrize("value", [None, "1.0", True, math.nan, math.inf, [1.0]])
def test_no_answer_is_no_number(value):
    assert finite_number(value) is None
