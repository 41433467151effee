"""The published Victoria Park graph, smoothed: half chi-squared of the optimum, which batch optimisers reach from a good start only."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

from ssjs_cli.app import call

HALF_CHI2_BAR = 2345.0  # the optimum of the graph is 2,339


def test_the_smoother_reaches_the_optimum(data_set: Callable[[str], Path], tmp_path: Path) -> None:
    source = data_set("victoria_park_graph") / "victoria_park.txt"
    assert call(["import", "graph", str(source), "--out", str(tmp_path / "mission")]) == 0
    assert call(["run", str(tmp_path / "mission"), "--smooth", "--no-report", "--out", str(tmp_path / "run")]) == 0
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert summary["half_chi2_final"] <= HALF_CHI2_BAR
    assert summary["smoothing_converged"] is True
    # nothing is left out to get there
    assert summary["smoothing_poses"] == 6969
    assert summary["smoothing_sightings"] == 3640
    assert summary["landmarks"] == 151
