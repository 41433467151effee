"""The import commands; what the readers do is tested with the formats."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from ssjs_cli.formats.mission import read_mission

GRAPH = "ODOMETRY 0 1 1 0 0 0.04 0 0 0.01 0 0.0001\nODOMETRY 1 2 1 0 0 0.04 0 0 0.01 0 0.0001\nLANDMARK 2 3 2 1 0.4 0 0.4\n"


def test_a_graph_becomes_a_mission_that_runs(cli: Callable[..., Any], tmp_path: Path) -> None:
    (tmp_path / "g.txt").write_text(GRAPH)
    answer = cli("import", "graph", tmp_path / "g.txt", "--out", tmp_path / "g", "--json")
    assert answer.code == 0, answer.err
    document = json.loads(answer.out)
    assert (document["odometry_kind"], document["odometry_records"], document["observations"]) == ("increments", 2, 1)
    answer = cli("run", tmp_path / "g", "--out", tmp_path / "run", "--no-report")
    assert answer.code == 0, answer.err
    assert json.loads((tmp_path / "run" / "summary.json").read_text())["landmarks"] == 1


def test_tables_become_a_mission_that_runs(cli: Callable[..., Any], tmp_path: Path) -> None:
    rows = "".join(f"{100 * step};3.6;10\n" for step in range(50))
    (tmp_path / "log.csv").write_text("t;v;rate\n" + rows)
    answer = cli(
        *("import", "csv", tmp_path / "log.csv", "--delimiter", ";", "--map", "time_s=t:ms", "--map", "speed_m_s=v:km/h"),
        *("--map", "turn_rate_rad_s=rate:deg/s", "--out", tmp_path / "m"),
    )
    assert answer.code == 0, answer.err
    assert read_mission(tmp_path / "m").odometry.values[49, :2].tolist() == [4.9, 1.0]
    assert cli("run", tmp_path / "m", "--out", tmp_path / "run", "--no-report").code == 0


def test_what_was_lost_gives_exit_code_3(cli: Callable[..., Any], tmp_path: Path) -> None:
    (tmp_path / "Barcodes.dat").write_text("1 5\n6 61\n")
    (tmp_path / "Robot1_Odometry.dat").write_text("0.0 1 0\n1.0 1 0\n")
    (tmp_path / "Robot1_Measurement.dat").write_text("0.5 61 2 0\n0.6 99 2 0\n")
    answer = cli("import", "mrclam", tmp_path, "--robot", 1, "--out", tmp_path / "m")
    assert answer.code == 2
    assert "Robot1_Measurement.dat:2: barcode 99 is not in Barcodes.dat" in answer.err
    assert not (tmp_path / "m").exists()
    answer = cli("import", "mrclam", tmp_path, "--robot", 1, "--skip-unknown-barcodes", "--out", tmp_path / "m", "--json")
    assert answer.code == 3
    assert len(json.loads(answer.out)["lost"]) == 3  # the barcode, and neither truth nor landmarks are there


def test_the_output_is_kept_without_force(cli: Callable[..., Any], tmp_path: Path) -> None:
    (tmp_path / "g.txt").write_text(GRAPH)
    assert cli("import", "graph", tmp_path / "g.txt", "--out", tmp_path / "g").code == 0
    assert cli("import", "graph", tmp_path / "g.txt", "--out", tmp_path / "g").code == 2
    assert cli("import", "graph", tmp_path / "g.txt", "--out", tmp_path / "g", "--force").code == 0


@pytest.mark.parametrize("command", [["victoria-park"], ["mrclam", "--robot", "1"], ["graph"], ["csv"]])
def test_a_missing_source_is_the_users_error(cli: Callable[..., Any], tmp_path: Path, command: list[str]) -> None:
    answer = cli("import", *command, tmp_path / "nowhere", "--out", tmp_path / "m")
    assert answer.code == 2
    assert "nowhere" in answer.err
    assert not (tmp_path / "m").exists()


def test_the_real_park_runs(cli: Callable[..., Any], data_set: Callable[[str], Path], tmp_path: Path) -> None:
    assert cli("import", "victoria-park", data_set("victoria_park"), "--out", tmp_path / "m").code == 0
    answer = cli("run", tmp_path / "m", "--out", tmp_path / "run", "--no-report", "--json")
    assert answer.code == 0, answer.err
    summary = json.loads(answer.out)
    # A published full least-squares solution scores 1.55 m with 3 fixes beyond 10 m rejected.
    assert summary["trajectory_rmse_m"] <= 2.0
    assert summary["reference_outliers"] <= 10
    assert summary["dead_reckoning_rmse_m"] > 10.0
