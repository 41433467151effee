"""ssjs-cli run --smooth: the whole mission once more, by least squares."""

import json
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ssjs_cli.config import METHOD_KEY, field_descriptions
from ssjs_cli.formats.number_table import read_table
from ssjs_cli.formats.run_directory import COVARIANCE_NAMES
from ssjs_cli.formats.tum import read_tum


def finished(cli: Callable[..., Any], mission: Path, out: Path, *arguments: str) -> dict[str, Any]:
    answer = cli("run", mission, "--out", out, "--no-report", *arguments)
    assert answer.code == 0, answer.err
    summary: dict[str, Any] = json.loads((out / "summary.json").read_text())
    return summary


@pytest.mark.parametrize("association", ["known", "jcbb"])
def test_smoothing_fills_its_keys_and_makes_nothing_worse(
    cli: Callable[..., Any], circle_mission: Path, tmp_path: Path, association: str
) -> None:
    joined = finished(cli, circle_mission, tmp_path / "joined", "--association", association)
    smooth = finished(cli, circle_mission, tmp_path / "smooth", "--association", association, "--smooth")
    assert joined["half_chi2_initial"] is None
    assert joined["half_chi2_final"] is None
    assert joined["time_smoothing_s"] is None
    assert 0.0 < smooth["half_chi2_final"] < smooth["half_chi2_initial"]
    assert smooth["smoothing_converged"] is True
    assert smooth["time_smoothing_s"] > 0.0
    # two numbers a sighting, two unknowns a landmark: chi-squared within six of its standard deviations
    dof = 2.0 * (smooth["smoothing_sightings"] - smooth["landmarks"])
    assert abs(2.0 * smooth["half_chi2_final"] - dof) < 6.0 * np.sqrt(2.0 * dof)
    assert smooth["trajectory_rmse_m"] <= joined["trajectory_rmse_m"]
    assert smooth["map_error_mean_m"] <= 1.05 * joined["map_error_mean_m"]
    assert smooth["landmarks_missed"] == joined["landmarks_missed"]
    assert tomllib.loads((tmp_path / "smooth" / "config.toml").read_text())["smoothing"]["enabled"] is True


def test_files_hold_the_smoothed_answer_and_are_the_same_every_time(cli: Callable[..., Any], circle_mission: Path, tmp_path: Path) -> None:
    finished(cli, circle_mission, tmp_path / "joined")
    for name in ("one", "two"):
        finished(cli, circle_mission, tmp_path / name, "--smooth")
    for name in ("trajectory.tum", "trajectory_covariance.csv", "landmarks.csv", "submaps.json", "trajectory_online.tum"):
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()
    for name in ("submaps.json", "trajectory_online.tum"):
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "joined" / name).read_bytes()
    joined, smooth = (read_tum(tmp_path / name / "trajectory.tum") for name in ("joined", "one"))
    assert np.array_equal(joined.time_s, smooth.time_s)
    assert 0.0 < np.abs(joined.pose[:, :2] - smooth.pose[:, :2]).max() < 1.0
    covariance = read_table(tmp_path / "one" / "trajectory_covariance.csv", required=COVARIANCE_NAMES)
    for column in ("var_xx", "var_yy", "var_hh"):
        assert (covariance[column][1:] > 0.0).all()


def test_every_method_leads_to_the_same_optimum(cli: Callable[..., Any], tmp_path: Path) -> None:
    """With known identities every method hands the smoother one problem, from a start of its own."""
    assert cli("simulate", "grid-survey-stress", "--out", tmp_path / "survey").code == 0
    methods = field_descriptions()[METHOD_KEY].choices
    assert len(methods) == 10
    arguments = ("--smooth", "--association", "known", "--method")
    smoothed = {method: finished(cli, tmp_path / "survey", tmp_path / method, *arguments, method) for method in methods}
    costs = {method: summary["half_chi2_final"] for method, summary in smoothed.items()}
    assert all(summary["smoothing_converged"] for summary in smoothed.values())
    assert max(costs.values()) - min(costs.values()) < 1e-4, costs
    dof = 2 * (smoothed["ssjs"]["smoothing_sightings"] - smoothed["ssjs"]["landmarks"])
    assert abs(2.0 * costs["ssjs"] - dof) < 6.0 * np.sqrt(2.0 * dof)
    errors_m = [summary["map_error_mean_m"] for summary in smoothed.values()]
    assert max(errors_m) - min(errors_m) < 0.01
    assert len({summary["half_chi2_initial"] for summary in smoothed.values()}) > 5


def test_a_kernel_of_another_name_is_refused(cli: Callable[..., Any], circle_mission: Path, tmp_path: Path) -> None:
    answer = cli("run", circle_mission, "--out", tmp_path / "run", "--smooth", "--set", "smoothing.kernel=tukey")
    assert answer.code == 2
    assert "smoothing.kernel" in answer.err
    assert "cauchy" in answer.err


@pytest.mark.parametrize("kernel", ["huber", "cauchy"])
def test_a_robust_kernel_doubts_a_gross_error(cli: Callable[..., Any], circle_mission: Path, tmp_path: Path, kernel: str) -> None:
    path = circle_mission / "observations.csv"
    lines = path.read_text().splitlines()
    for row in range(200, len(lines), 200):
        time_s, range_m, rest = lines[row].split(",", 2)
        lines[row] = f"{time_s},{float(range_m) + 2.0!r},{rest}"
    path.write_text("\n".join(lines) + "\n")
    plain = finished(cli, circle_mission, tmp_path / "plain", "--smooth")
    robust = finished(cli, circle_mission, tmp_path / "robust", "--smooth", "--set", f"smoothing.kernel={kernel}")
    assert plain["smoothing_doubted"] == 0
    assert robust["smoothing_doubted"] >= len(range(200, len(lines), 200))
    assert robust["map_error_mean_m"] < plain["map_error_mean_m"]


def test_a_smoother_that_is_stopped_early_says_so(cli: Callable[..., Any], circle_mission: Path, tmp_path: Path) -> None:
    summary = finished(cli, circle_mission, tmp_path / "run", "--smooth", "--set", "smoothing.max_iterations=1")
    assert summary["smoothing_converged"] is False
    assert "smoothing.max_iterations" in summary["warnings"][0]
