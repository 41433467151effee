"""Sant Pere: dead reckoning of the imported log against DGPS. Any sign, unit, clock or mounting gone wrong shows here."""

from __future__ import annotations

import importlib.util
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np

from ssjs_cli.app import call
from ssjs_cli.formats.mission import read_mission

SCRIPT = Path(__file__).resolve().parents[3] / "benchmarks" / "stpere_dead_reckoning.py"


def test_dead_reckoning_agrees_with_dgps(data_set: Callable[[str], Path], tmp_path: Path) -> None:
    assert call(["import", "stpere", str(data_set("stpere")), "--out", str(tmp_path / "mission")]) == 0
    mission = read_mission(tmp_path / "mission")
    assert mission.navigation is not None and mission.navigation.velocity is not None and mission.reference.fixes is not None
    velocity = mission.navigation.velocity
    assert len(velocity.time_s) == 5045
    assert int((~velocity.bottom_lock).sum()) == 84
    assert float(np.abs(velocity.velocity_m_s[velocity.bottom_lock]).max()) < 2.5  # m/s, not cm/s

    specification = importlib.util.spec_from_file_location("stpere_dead_reckoning", SCRIPT)
    assert specification is not None and specification.loader is not None
    script = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(script)
    score = script.score(*script.dead_reckoning(mission.navigation), mission.reference.fixes)
    assert -86.0 < score["yaw_offset_deg"] < -79.0
    assert score["rmse_m"] < 6.0
    assert score["rmse_from_first_fix_m"] < 8.0


def test_the_filter_keeps_what_dead_reckoning_has(data_set: Callable[[str], Path], tmp_path: Path) -> None:
    """The yaw offset is that of the first quarter of the log; the origin is the first fix."""
    mission, out = tmp_path / "mission", tmp_path / "run"
    assert call(["import", "stpere", str(data_set("stpere")), "--out", str(mission)]) == 0
    assert call(["run", str(mission), "--out", str(out), "--no-report", "--set", f"joining.north_offset_rad={np.radians(81.6)}"]) == 0
    summary = json.loads((out / "summary.json").read_text())
    assert summary["trajectory_rmse_m"] < 6.5
    assert summary["trajectory_rmse_m"] < summary["dead_reckoning_rmse_m"]
    sensors = summary["sensors"]
    assert all(sensor["refused"] < 0.1 * sensor["used"] for sensor in sensors.values() if sensor["used"])
