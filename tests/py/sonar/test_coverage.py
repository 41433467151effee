"""Areas of swaths whose size is known by hand."""

from pathlib import Path

import numpy as np
import pytest

from ssjs_cli.formats.tum import PoseSeries
from ssjs_cli.sonar.coverage import Coverage, coverage, covered_hull, write_coverage
from ssjs_cli.sonar.survey_record import Reach

NEAR_M, FAR_M = 2.0, 20.0


def line(length_m: int = 100, start_s: float = 0.0) -> tuple[PoseSeries, Reach]:
    """Along x at 1 m/s, a ping a second, the same reach on both sides."""
    time_s = start_s + np.arange(length_m + 1, dtype=np.float64)
    pose = np.column_stack((time_s - start_s, np.zeros((length_m + 1, 2))))
    ranges = np.tile([NEAR_M, FAR_M, NEAR_M, FAR_M], (length_m + 1, 1))
    return PoseSeries(time_s, pose), Reach(time_s, np.full(length_m + 1, 5.0), ranges)


def found(track: PoseSeries, reach: Reach) -> Coverage:
    answer = coverage(track, reach)
    assert answer is not None
    return answer


def test_a_straight_line_covers_both_sides_but_not_the_nadir() -> None:
    answer = found(*line())
    assert answer.cell_m == 1.0
    # 100 m long and 18 m wide on either side; cells are touched to half a metre beyond it
    assert answer.covered_m2 == pytest.approx(100.0 * 36.0, rel=0.08)
    assert answer.twice_m2 == 0.0
    assert answer.surveyed_m2 == pytest.approx(100.0 * 40.0, rel=0.08)
    on_track = int(np.floor((0.0 - answer.corner_m[1]) / answer.cell_m))
    assert not answer.passes[:, on_track].any()
    assert answer.numbers()["coverage_fraction"] == pytest.approx(0.9, abs=0.03)


def test_the_line_back_over_it_is_a_second_pass() -> None:
    track, reach = line()
    back_s = 200.0 + track.time_s
    both = PoseSeries(
        np.concatenate((track.time_s, back_s)),
        np.concatenate((track.pose, np.column_stack((track.pose[::-1, 0], track.pose[:, 1], np.full(101, -np.pi))))),
    )
    answer = found(both, Reach(both.time_s, np.full(202, 5.0), np.tile(reach.ranges_m, (2, 1))))
    once = found(track, reach)
    assert answer.covered_m2 == pytest.approx(once.covered_m2, rel=0.03)
    assert answer.twice_m2 == pytest.approx(once.covered_m2, rel=0.05)
    assert answer.passes.max() == 2


def test_a_silent_stretch_and_a_gap_in_time_are_not_covered() -> None:
    track, reach = line()
    ranges = reach.ranges_m.copy()
    ranges[40:60] = np.nan
    silent = found(track, Reach(reach.time_s, reach.altitude_m, ranges))
    # from ping 39 to ping 60: 21 of 100 intervals have an end without an answer
    assert silent.covered_m2 == pytest.approx(0.79 * found(track, reach).covered_m2, rel=0.03)
    keep = np.r_[0:40, 60:101]
    gap = found(track, Reach(reach.time_s[keep], reach.altitude_m[keep], reach.ranges_m[keep]))
    assert gap.covered_m2 == pytest.approx(silent.covered_m2, rel=0.03)


def test_one_side_is_one_side() -> None:
    track, reach = line()
    ranges = reach.ranges_m.copy()
    ranges[:, :2] = np.nan
    answer = found(track, Reach(reach.time_s, reach.altitude_m, ranges))
    assert answer.corner_m[1] > 0.0  # x ahead, y to starboard: nothing at port
    assert answer.covered_m2 == pytest.approx(100.0 * 18.0, rel=0.1)


def test_a_sonar_that_heard_nothing_has_no_coverage() -> None:
    track, reach = line()
    assert coverage(track, Reach(reach.time_s, reach.altitude_m, np.full((101, 4), np.nan))) is None
    assert coverage(track, Reach(np.zeros(0), np.zeros(0), np.zeros((0, 4)))) is None


def test_a_long_way_gets_larger_cells() -> None:
    track, reach = line(60_000)
    assert found(track, reach).cell_m == 1.0  # 60 km by 40 m are 2.4 million
    turned = PoseSeries(track.time_s, np.column_stack((track.pose[:, 0] * 0.7, track.pose[:, 0] * 0.7, np.full(60_001, np.pi / 4))))
    answer = found(turned, reach)
    assert answer.passes.size <= 4_000_000
    assert answer.cell_m > 10.0


def test_the_hull_holds_every_covered_cell() -> None:
    passes = np.zeros((5, 6), dtype=np.int64)
    passes[1, 2] = passes[3, 4] = 1
    corners = covered_hull(passes)
    assert corners.min(axis=0).tolist() == [1.0, 2.0]
    assert corners.max(axis=0).tolist() == [4.0, 5.0]


def test_the_file_holds_the_grid(tmp_path: Path) -> None:
    answer = found(*line())
    write_coverage(tmp_path / "coverage.npz", answer)
    with np.load(tmp_path / "coverage.npz") as archive:
        assert archive["passes"].tolist() == answer.passes.tolist()
        assert float(archive["cell_m"]) == 1.0
