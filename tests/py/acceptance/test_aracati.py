"""ARACATI 2017: point features from a real forward-looking sonar, against DGPS."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from ssjs_cli.app import call


def test_piles_correct_the_track(data_set: Callable[[str], Path], tmp_path: Path) -> None:
    mission = tmp_path / "mission"
    assert call(["import", "aracati", str(data_set("aracati2017")), "--out", str(mission)]) == 0
    assert call(["run", str(mission), "--out", str(tmp_path / "run")]) == 0
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert summary["trajectory_rmse_m"] <= 2.5
    assert summary["reference_outliers"] == 0
    assert summary["loop_closures"] >= 10
    assert 0.4 < summary["nis_mean"] < 1.0
    assert summary["nis_above_fraction"] < 0.03
    assert 0.8 < summary["fusion_chi2_per_dof"] < 1.3


def test_dead_reckoning_alone_is_as_published(data_set: Callable[[str], Path], tmp_path: Path) -> None:
    mission = tmp_path / "mission"
    assert call(["import", "aracati", str(data_set("aracati2017")), "--out", str(mission)]) == 0
    (mission / "sonar_hits.csv").unlink()
    command = ["run", str(mission), "--out", str(tmp_path / "run"), "--no-report", "--set", "vehicle.increments.distance_scale=1"]
    assert call(command) == 0
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert summary["trajectory_rmse_m"] == pytest.approx(10.6, abs=0.1)
