import numpy as np
import pytest
from plotly.graph_objects import Figure

from ssjs_cli.report.consistency_figures import MAX_DOTS, consistency


def test_shares_against_the_tabulated_bounds():
    # chi-squared, 2.5 % and 97.5 %: 2 dof 0.0506 and 7.378, 4 dof 0.484 and 11.143
    table = {
        "time_s": np.arange(6.0),
        "nis": np.array([0.050, 0.051, 7.37, 7.39, 11.1, 0.49]),
        "dof": np.array([2.0, 2.0, 2.0, 2.0, 4.0, 4.0]),
    }
    answer = consistency(table, "nis")
    Figure(answer.figure)
    assert (answer.below, answer.above) == (pytest.approx(1 / 6), pytest.approx(1 / 6))
    assert answer.inside == pytest.approx(4 / 6)
    # sum of the values over the sum of their dof: 26.451 / 16
    assert answer.mean_per_dof == pytest.approx(26.451 / 16.0)
    assert answer.dof_text == "2 to 4"


def test_band_is_drawn_per_degree_of_freedom():
    # 3 dof: 0.2158 and 9.348, so 0.0719 and 3.116 per dof
    table = {"time_s": np.arange(10.0), "nees": np.full(10, 3.0), "dof": np.full(10, 3.0)}
    data = consistency(table, "nees").figure["data"]
    assert set(data[0]["y"]) == {0.0719}
    assert set(data[1]["y"]) == {3.1161}
    assert data[1]["name"] == "95 % band"


def test_percentiles_of_true_claims_are_level():
    rng = np.random.default_rng(11)
    dof = rng.choice([2.0, 6.0, 12.0], 40_000)
    answer = consistency({"time_s": np.arange(40_000.0), "nis": rng.chisquare(dof), "dof": dof}, "nis")
    bars = next(trace for trace in answer.figure["data"] if trace["type"] == "bar")
    # 20 bins of 5 %, standard deviation of a bin 100 sqrt(0.05 * 0.95 / 40,000) = 0.11
    assert max(abs(share - 5.0) for share in bars["y"]) < 0.5
    assert sum(bars["y"]) == pytest.approx(100.0, abs=0.02)
    assert answer.inside == pytest.approx(0.95, abs=0.005)


def test_dots_are_thinned_and_the_note_says_so():
    rng = np.random.default_rng(2)
    answer = consistency({"time_s": np.arange(10_000.0), "nis": rng.chisquare(4.0, 10_000), "dof": np.full(10_000, 4.0)}, "nis")
    dots = sum(len(trace["x"]) for trace in answer.figure["data"] if trace.get("mode") == "markers")
    # every 6th of 10,000: rows 0, 6, ... 9,996
    assert dots == 1667 <= MAX_DOTS
    assert any(note.startswith("One value in 6 of 10,000 is drawn") for note in answer.notes)


def test_rows_without_freedom_or_value_are_left_out():
    table = {"time_s": np.arange(4.0), "nis": np.array([1.0, np.nan, 2.0, 1.0]), "dof": np.array([2.0, 2.0, 0.0, 2.0])}
    assert consistency(table, "nis").count == 2
    assert consistency({name: column[:1] for name, column in table.items()}, "nis") is None
