"""A season whose workers and parents are killed by SIGKILL: benchmarks/season_of_thousand.py, small; whole with -m long."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[3] / "benchmarks"))
from season_of_thousand import Disturbance, disturbed_season, simulate

pytestmark = pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="needs /proc")


def test_twelve_missions_survive_a_killed_worker_and_a_killed_parent(tmp_path: Path) -> None:
    missions = simulate(tmp_path, 12)
    outcome = disturbed_season(tmp_path, missions, Disturbance(worker_kills=1, parent_kills=1), seed=1, sample=2)
    assert outcome.figures["parents_killed"] == 1
    assert 0 < outcome.calls[0].finished_after < 12  # the kill came in the middle
    assert outcome.calls[1].finished_before == outcome.calls[0].finished_after
    assert outcome.figures["files_compared"] > 20


@pytest.mark.long
def test_a_thousand_missions_survive_ten_killed_workers_and_two_killed_parents(tmp_path: Path) -> None:
    missions = simulate(tmp_path, 1000)
    outcome = disturbed_season(tmp_path, missions, Disturbance(worker_kills=10, parent_kills=2), seed=1, sample=20)
    assert outcome.figures["parents_killed"] == 2 and outcome.figures["workers_killed"] >= 5
    assert outcome.figures["apart"] < 100
    assert outcome.figures["page_mb"] < 10.0
