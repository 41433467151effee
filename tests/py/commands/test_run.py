"""ssjs-cli run on a small mission, with the real estimator."""

import errno
import json
import os
import shutil
import signal
import subprocess
import sys
import time
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ssjs_cli.formats.g2o import read_g2o
from ssjs_cli.formats.number_table import read_table
from ssjs_cli.formats.tum import read_tum

CONTRACT_KEYS = (
    "steps",
    "observations",
    "landmarks",
    "submaps",
    "loop_candidates",
    "loop_closures",
    "fusions",
    "wrong_pairs",
    "time_total_s",
    "time_local_s",
    "time_global_s",
    "time_association_s",
    "time_other_s",
    "step_time_p50_us",
    "step_time_p99_us",
    "step_time_max_us",
    "peak_rss_mb",
    "trajectory_rmse_m",
    "trajectory_mean_m",
    "trajectory_std_m",
    "trajectory_max_m",
    "final_drift_percent",
    "dead_reckoning_rmse_m",
    "dead_reckoning_final_drift_percent",
    "reference_outliers",
    "map_error_mean_m",
    "map_error_std_m",
    "map_error_max_m",
    "landmarks_missed",
    "landmarks_false",
    "nees_mean",
    "nees_inside_fraction",
    "nees_joint_per_dof",
    "nees_base_mean",
    "nees_map_mean",
    "nis_mean",
    "nis_inside_fraction",
    "half_chi2_initial",
    "half_chi2_final",
    "alignment",
)
NOT_REPRODUCIBLE = ("time_", "step_time_", "peak_rss_mb")
SAME_BYTES = (
    "trajectory.tum",
    "trajectory_covariance.csv",
    "trajectory_online.tum",
    "trajectory_online_covariance.csv",
    "trajectory_submaps.csv",
    "dead_reckoning.tum",
    "landmarks.csv",
    "submaps.json",
    "graph.g2o",
    "config.toml",
    "consistency.csv",
    "errors.csv",
    "errors_online.csv",
    "reference.csv",
    "nees.csv",
    "bases.npz",
)


def summary_of(run: Path) -> dict[str, Any]:
    document: dict[str, Any] = json.loads((run / "summary.json").read_text())
    return document


def reproducible(summary: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in summary.items() if not key.startswith(NOT_REPRODUCIBLE)}


@pytest.fixture
def finished(cli: Callable[..., Any], circle_mission: Path, tmp_path: Path) -> Path:
    answer = cli("run", circle_mission, "--out", tmp_path / "run", "--seed", 3, "--no-report")
    assert answer.code == 0, answer.err
    return tmp_path / "run"


def test_a_run_leaves_the_files_and_keys_of_the_contract(finished: Path) -> None:
    for name in (*SAME_BYTES, "summary.json", "timing.json", "step_times.csv", "log.jsonl"):
        assert (finished / name).is_file(), name
    summary = summary_of(finished)
    assert [key for key in CONTRACT_KEYS if key not in summary] == []
    assert (summary["method"], summary["seed"], summary["alignment"]) == ("ssjs", 3, "none")
    assert summary["input_digests"].keys() == {
        "mission.toml",
        "odometry.csv",
        "observations.csv",
        "truth_trajectory.tum",
        "truth_landmarks.csv",
    }
    assert not any(path.name.startswith(".") for path in finished.parent.iterdir())


def test_the_estimate_is_good_and_the_numbers_belong_together(finished: Path) -> None:
    summary = summary_of(finished)
    trajectory = read_tum(finished / "trajectory.tum")
    errors = read_table(finished / "errors.csv", required=("time_s", "error_m"), other_columns_allowed=True)
    landmarks = read_table(finished / "landmarks.csv", required=("id", "x_m", "y_m"), other_columns_allowed=True)
    assert len(trajectory.time_s) == summary["steps"]
    assert landmarks.rows == summary["landmarks"]
    assert summary["trajectory_rmse_m"] == pytest.approx(float(np.sqrt(np.mean(errors["error_m"] ** 2))), abs=1e-5)
    # A circle of 10 m radius driven twice, noise of 2 %: the error stays far below the landmark spacing of about 3 m.
    assert summary["trajectory_rmse_m"] < 0.3
    assert summary["trajectory_rmse_m"] < summary["dead_reckoning_rmse_m"]
    assert summary["landmarks_missed"] == 0
    assert summary["map_error_mean_m"] < 0.3
    assert 0.7 < summary["nis_mean"] < 1.3


def test_submaps_and_graph_agree(finished: Path) -> None:
    document = json.loads((finished / "submaps.json").read_text())
    graph = read_g2o(finished / "graph.g2o")
    assert document.keys() == {"submaps", "live_maps", "loops"}
    assert len(document["submaps"]) == summary_of(finished)["submaps"] == len(graph.vertices)
    assert len(graph.edges) == len(graph.vertices) - 1


def test_the_same_input_and_seed_give_the_same_bytes(cli: Callable[..., Any], circle_mission: Path, finished: Path, tmp_path: Path) -> None:
    assert cli("run", circle_mission, "--out", tmp_path / "again", "--seed", 3, "--no-report").code == 0
    for name in SAME_BYTES:
        assert (finished / name).read_bytes() == (tmp_path / "again" / name).read_bytes(), name
    assert reproducible(summary_of(finished)) == reproducible(summary_of(tmp_path / "again"))


def test_the_written_configuration_gives_the_same_bytes(
    cli: Callable[..., Any], circle_mission: Path, finished: Path, tmp_path: Path
) -> None:
    answer = cli("run", circle_mission, "--config", finished / "config.toml", "--out", tmp_path / "again", "--no-report")
    assert answer.code == 0
    for name in SAME_BYTES:
        assert (finished / name).read_bytes() == (tmp_path / "again" / name).read_bytes(), name
    assert reproducible(summary_of(finished)) == reproducible(summary_of(tmp_path / "again"))


def test_results_hold_no_absolute_paths(finished: Path, tmp_path: Path) -> None:
    for path in finished.iterdir():
        if path.suffix in (".json", ".toml", ".csv", ".tum", ".g2o"):
            assert str(tmp_path) not in path.read_text(), path.name


def test_json_prints_exactly_one_document(cli: Callable[..., Any], circle_mission: Path, tmp_path: Path) -> None:
    answer = cli("run", circle_mission, "--out", tmp_path / "run", "--no-report", "--json")
    document = json.loads(answer.out)
    assert document["run_directory"] == str(tmp_path / "run")
    assert reproducible({key: document[key] for key in summary_of(tmp_path / "run")}) == reproducible(summary_of(tmp_path / "run"))


def test_the_report_is_built_and_printed(cli: Callable[..., Any], circle_mission: Path, tmp_path: Path) -> None:
    answer = cli("run", circle_mission, "--out", tmp_path / "run")
    assert answer.code == 0, answer.err
    assert (tmp_path / "run" / "report.html").stat().st_size > 0
    assert str(tmp_path / "run" / "report.html") in answer.out


def test_settings_are_taken_in_their_order(cli: Callable[..., Any], circle_mission: Path, tmp_path: Path) -> None:
    """mission.toml says range_sigma_m 0.05, max_landmarks 6; the file and --set lie over it, flags over all."""
    config = tmp_path / "config.toml"
    config.write_text('seed = 9\nmethod = "ssjs"\n[sensor]\nrange_sigma_m = 0.06\nbearing_sigma_rad = 0.006\n')
    answer = cli(
        *("run", circle_mission, "--config", config, "--set", "sensor.range_sigma_m=0.07", "--set", "association.method=nn"),
        *("--association", "known", "--method", "ekf", "--out", tmp_path / "run", "--no-report"),
    )
    assert answer.code == 0, answer.err
    text = (tmp_path / "run" / "config.toml").read_text()
    expected = ("seed = 9", 'method = "ekf"', "range_sigma_m = 0.07", "bearing_sigma_rad = 0.006", "max_landmarks = 6", 'method = "known"')
    for line in expected:
        assert f"\n{line}\n" in f"\n{text}", line


def test_the_default_output_is_named_after_mission_and_method(
    cli: Callable[..., Any], circle_mission: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert cli("run", circle_mission, "--no-report", "--method", "ekf").code == 0
    assert (tmp_path / "runs" / "circle-ekf" / "summary.json").is_file()


def test_nothing_is_overwritten_without_force(cli: Callable[..., Any], circle_mission: Path, finished: Path) -> None:
    before = (finished / "summary.json").read_bytes()
    answer = cli("run", circle_mission, "--out", finished, "--no-report")
    assert answer.code == 2
    assert "exists already; choose another --out, or replace it with --force" in answer.err
    assert (finished / "summary.json").read_bytes() == before
    assert cli("run", circle_mission, "--out", finished, "--no-report", "--force", "--seed", 4).code == 0
    assert summary_of(finished)["seed"] == 4


def test_force_does_not_replace_a_mission_or_foreign_files(cli: Callable[..., Any], circle_mission: Path, finished: Path) -> None:
    answer = cli("run", circle_mission, "--out", circle_mission, "--force")
    assert answer.code == 2
    assert (circle_mission / "mission.toml").is_file()
    (finished / "notes.txt").write_text("mine")
    answer = cli("run", circle_mission, "--out", finished, "--force")
    assert answer.code == 2
    assert "it also holds notes.txt" in answer.err


def test_a_mission_without_observations_is_answered_by_dead_reckoning(
    cli: Callable[..., Any], circle_mission: Path, tmp_path: Path
) -> None:
    (circle_mission / "observations.csv").unlink()
    answer = cli("run", circle_mission, "--out", tmp_path / "run", "--no-report")
    assert answer.code == 0, answer.err
    assert f"warning: {circle_mission}: the mission holds no observations: the answer is dead reckoning" in answer.err
    summary = summary_of(tmp_path / "run")
    assert summary["warnings"] == ["the mission holds no observations: the answer is dead reckoning"]
    assert summary["landmarks"] == 0
    assert summary["nis_mean"] is None
    final, dead = read_tum(tmp_path / "run" / "trajectory.tum"), read_tum(tmp_path / "run" / "dead_reckoning.tum")
    assert np.abs(final.pose[:, :2] - dead.pose[:, :2]).max() < 1e-6


def test_an_unusable_reference_is_lost_and_exit_code_3(cli: Callable[..., Any], circle_mission: Path, tmp_path: Path) -> None:
    (circle_mission / "truth_trajectory.tum").unlink()
    (circle_mission / "reference_fixes.csv").write_text("time_s,x_m,y_m\n99999,0,0\n")
    answer = cli("run", circle_mission, "--out", tmp_path / "run", "--no-report")
    assert answer.code == 3
    assert "lost: the reference covers 99999.000 to 99999.000 s" in answer.err
    assert summary_of(tmp_path / "run")["lost"] != []
    assert (tmp_path / "run" / "trajectory.tum").is_file()


def test_observations_after_the_odometry_are_lost(cli: Callable[..., Any], circle_mission: Path, tmp_path: Path) -> None:
    with (circle_mission / "observations.csv").open("a") as file:
        file.write("500.0,5.0,0.0,3\n")
    answer = cli("run", circle_mission, "--out", tmp_path / "run", "--no-report")
    assert answer.code == 3
    (text,) = summary_of(tmp_path / "run")["lost"]
    assert text.startswith("1 of ")
    assert text.endswith("observations come more than 1 s after the last odometry record and were not used")


def edit(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


@pytest.mark.parametrize(
    ("name", "old", "new", "message"),
    [
        ("odometry.csv", "\n0.1,", "\nnan,", "odometry.csv:3: time_s is empty or NaN"),
        ("odometry.csv", "\n0.2,", "\n0.05,", "odometry.csv:4: time_s = 0.05 goes back from 0.1"),
        ("observations.csv", "range_m", "range_km", "observations.csv:1: unknown column 'range_km' (did you mean 'range_m'?)"),
        ("mission.toml", "range_sigma_m = 0.05", "range_sigma_m = 0.0", "[settings]: sensor.range_sigma_m = 0: must be positive"),
        ("mission.toml", "range_sigma_m = 0.05", "range_sigma_m = -1.0", "[settings]: sensor.range_sigma_m = -1: must be positive"),
        ("mission.toml", "range_sigma_m = 0.05", 'range_sigma_m = "a"', '[settings]: sensor.range_sigma_m = "a": must be a number'),
        ("mission.toml", "range_sigma_m", "range_sigm_m", "unknown key 'sensor.range_sigm_m' (did you mean 'sensor.range_sigma_m'?)"),
        ("mission.toml", 'kind = "unicycle"', 'kind = "ackerman"', "odometry.csv: holds unicycle odometry and vehicle.kind is ackerman"),
    ],
)
def test_a_faulty_mission_is_the_users_error(
    cli: Callable[..., Any], circle_mission: Path, tmp_path: Path, name: str, old: str, new: str, message: str
) -> None:
    edit(circle_mission / name, old, new)
    answer = cli("run", circle_mission, "--out", tmp_path / "run")
    assert answer.code == 2
    assert message in answer.err
    assert not (tmp_path / "run").exists()


def test_observations_and_scans_together_are_refused(cli: Callable[..., Any], circle_mission: Path, tmp_path: Path) -> None:
    np.savez(circle_mission / "scans.npz", time_s=np.array([1.0]), range_m=np.ones((1, 3)), first_angle_rad=0.0, step_rad=0.1)
    answer = cli("run", circle_mission, "--out", tmp_path / "run")
    assert answer.code == 2
    assert "holds both observations.csv and scans.npz, which would be used twice; remove one of them" in answer.err


def test_an_unknown_setting_or_method_is_the_users_error(cli: Callable[..., Any], circle_mission: Path) -> None:
    answer = cli("run", circle_mission, "--method", "efk")
    assert answer.code == 2
    assert "--method: method = 'efk': must be one of" in answer.err
    answer = cli("run", circle_mission, "--set", "joining.fusion_treshold=0.4")
    assert answer.code == 2
    assert "(did you mean 'joining.fusion_threshold'?)" in answer.err


def test_an_output_that_cannot_be_written_is_named_before_the_work(cli: Callable[..., Any], circle_mission: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    answer = cli("run", circle_mission, "--out", tmp_path / "file" / "run")
    assert answer.code == 2
    assert f"{tmp_path}/file/run: " in answer.err


def test_a_full_disk_is_exit_code_2_and_leaves_nothing(
    cli: Callable[..., Any], circle_mission: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*arguments: Any, **named: Any) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("ssjs_cli.formats.run_directory.write_table", full)
    answer = cli("run", circle_mission, "--out", tmp_path / "run")
    assert answer.code == 2
    assert f"{tmp_path}/run: No space left on device; free some space on that disk or choose another --out" in answer.err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["circle"]


def command(*arguments: object) -> list[str]:
    return [sys.executable, "-m", "ssjs_cli", *map(str, arguments)]


def test_a_file_size_limit_of_the_system_is_exit_code_2(circle_mission: Path, tmp_path: Path) -> None:
    line = f"ulimit -f 20; exec {' '.join(command('run', circle_mission, '--out', tmp_path / 'run', '--no-report'))}"
    finished = subprocess.run(["bash", "-c", line], capture_output=True, text=True)
    assert finished.returncode == 2, finished.stderr
    assert "File too large" in finished.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == ["circle"]


def long_mission(circle_mission: Path, copies: int) -> None:
    """The same drive many times, one after the other."""
    for name in ("odometry.csv", "observations.csv"):
        header, *rows = (circle_mission / name).read_text().splitlines()
        lines = [header]
        for copy in range(copies):
            lines += [f"{float(row.split(',', 1)[0]) + 140.0 * copy!r},{row.split(',', 1)[1]}" for row in rows]
        (circle_mission / name).write_text("\n".join(lines) + "\n")


@pytest.mark.parametrize("kind", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_run_leaves_nothing(circle_mission: Path, tmp_path: Path, kind: signal.Signals) -> None:
    long_mission(circle_mission, 60)
    process = subprocess.Popen(
        command("run", circle_mission, "--out", tmp_path / "run", "--set", "association.method=known"),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    deadline = time.monotonic() + 60.0
    while not any(path.name.startswith(".run.") for path in tmp_path.iterdir()):
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.01)
    process.send_signal(kind)
    _, err = process.communicate(timeout=60.0)
    assert process.returncode == 130, err
    assert err.strip().endswith("interrupted; no unfinished result was left")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["circle"]


def test_calibration_is_written_into_the_configuration(cli: Callable[..., Any], circle_mission: Path, tmp_path: Path) -> None:
    """The bearings of the log are turned by 0.03 rad: the calibration adds -0.03 rad, about its standard error."""
    header, *rows = (circle_mission / "observations.csv").read_text().splitlines()
    turned = []
    for row in rows:
        time_s, range_m, bearing_rad, landmark_id = row.split(",")
        turned.append(f"{time_s},{range_m},{float(bearing_rad) + 0.03!r},{landmark_id}")
    (circle_mission / "observations.csv").write_text("\n".join([header, *turned]) + "\n")
    answer = cli("run", circle_mission, "--calibrate", "--out", tmp_path / "run", "--no-report")
    assert answer.code == 0, answer.err
    assert "calibrated sensor.bearing_offset_rad" in answer.err
    config = tomllib.loads((tmp_path / "run" / "config.toml").read_text())
    assert config["sensor"]["bearing_offset_rad"] == pytest.approx(-0.03, abs=0.01)
    again = cli("run", circle_mission, "--config", tmp_path / "run" / "config.toml", "--out", tmp_path / "again", "--no-report")
    assert again.code == 0
    assert (tmp_path / "run" / "trajectory.tum").read_bytes() == (tmp_path / "again" / "trajectory.tum").read_bytes()


def test_a_geodetic_origin_gives_a_map(cli: Callable[..., Any], circle_mission: Path, tmp_path: Path) -> None:
    with (circle_mission / "mission.toml").open("a") as file:
        file.write("\n[geodetic]\norigin_latitude_deg = -33.9\norigin_longitude_deg = 151.2\n")
    assert cli("run", circle_mission, "--out", tmp_path / "run", "--no-report").code == 0
    document = json.loads((tmp_path / "run" / "map.geojson").read_text())
    longitude, latitude = document["features"][0]["geometry"]["coordinates"][0]
    assert (longitude, latitude) == pytest.approx((151.2, -33.9), abs=1e-5)


def test_the_mission_stays_as_it_was(cli: Callable[..., Any], circle_mission: Path, tmp_path: Path) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(circle_mission, copy)
    assert cli("run", circle_mission, "--out", tmp_path / "run", "--no-report").code == 0
    for path in copy.iterdir():
        assert path.read_bytes() == (circle_mission / path.name).read_bytes()
    assert sorted(os.listdir(copy)) == sorted(os.listdir(circle_mission))
