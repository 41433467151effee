"""Sant Pere: dead reckoning of the imported log against DGPS. Any sign, unit, clock or mounting gone wrong shows here."""

from __future__ import annotations

import importlib.util
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from ssjs_cli.app import call
from ssjs_cli.formats.mission import Fixes, read_mission
from ssjs_cli.formats.stpere import read_stpere, yaw_offset

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
    """The yaw offset is that of the first quarter of the log, as imported; the origin is the first fix."""
    mission, out = tmp_path / "mission", tmp_path / "run"
    assert call(["import", "stpere", str(data_set("stpere")), "--out", str(mission)]) == 0
    assert call(["run", str(mission), "--out", str(out), "--no-report"]) == 0
    summary = json.loads((out / "summary.json").read_text())
    assert summary["trajectory_rmse_m"] < 7.5
    assert summary["trajectory_rmse_m"] == pytest.approx(summary["dead_reckoning_rmse_m"], rel=0.1)
    sensors = summary["sensors"]
    assert all(sensor["refused"] < 0.02 * sensor["used"] for sensor in sensors.values() if sensor["used"])


def test_the_import_takes_the_yaw_offset_from_the_first_quarter(data_set: Callable[[str], Path], tmp_path: Path) -> None:
    source = data_set("stpere")
    whole = read_stpere(source)
    north = whole.settings["joining"]["north_offset_rad"]
    assert np.degrees(north) == pytest.approx(81.6, abs=0.1)
    assert 0.005 < whole.settings["joining"]["north_offset_sigma_rad"] < 0.06
    assert "836 fixes of the first quarter" in whole.notes
    # What DGPS says after the first quarter changes nothing.
    assert whole.navigation is not None and whole.navigation.velocity is not None and whole.reference.fixes is not None
    fixes = whole.reference.fixes
    spoilt = fixes.position_m.copy()
    spoilt[836:] = 1e4
    offset = yaw_offset(whole.navigation.attitude, whole.navigation.velocity, Fixes(fixes.time_s, spoilt))
    assert offset is not None and -offset.rad == pytest.approx(north, abs=1e-6)


@pytest.mark.parametrize("association", ["known", "jcbb"])
def test_posts_along_the_way_correct_the_track(association: str, data_set: Callable[[str], Path], tmp_path: Path) -> None:
    """A draw that no setting was chosen on."""
    mission, run, aligned = (tmp_path / name for name in ("mission", "run", "aligned"))
    assert call(["import", "stpere", str(data_set("stpere")), "--landmarks", "60", "--seed", "5", "--out", str(mission)]) == 0
    assert call(["run", str(mission), "--association", association, "--out", str(run), "--no-report"]) == 0
    assert call(["evaluate", str(run), "--align", "se2", "--out", str(aligned)]) == 0
    summary = json.loads((aligned / "summary.json").read_text())
    assert summary["trajectory_rmse_m"] <= 2.0
    assert summary["dead_reckoning_rmse_m"] > 2.0 * summary["trajectory_rmse_m"] or association == "jcbb"
    assert summary["wrong_pairs"] <= 2
