"""Underwater missions from the command line: simulated, run, exported."""

import json
import sqlite3
from pathlib import Path

import numpy as np
import pytest

from ssjs_cli.app import main
from ssjs_cli.config import METHOD_KEY, UNDERWATER, field_descriptions
from ssjs_cli.formats.mission import BodyPoints, Geodetic, Mission, read_mission, write_mission
from ssjs_cli.formats.navigation import Attitude, Scalars, UnderwaterNavigation
from ssjs_cli.formats.run_directory import read_estimate
from ssjs_cli.formats.tum import read_tum

SAME_BYTES = ("trajectory.tum", "trajectory_covariance.csv", "landmarks.csv", "contacts.csv", "submaps.json", "graph.g2o", "config.toml")


def run(*arguments: str | Path | int) -> int:
    with pytest.raises(SystemExit) as ended:
        main([str(argument) for argument in arguments])
    return int(ended.value.code or 0)


@pytest.fixture(scope="module")
def survey(tmp_path_factory: pytest.TempPathFactory) -> Path:
    directory = tmp_path_factory.mktemp("survey") / "mission"
    assert run("simulate", "auv-survey", "--seed", "3", "--out", directory) == 0
    return directory


@pytest.fixture(scope="module")
def finished(survey: Path) -> Path:
    out = survey.parent / "run"
    assert run("run", survey, "--out", out, "--no-report") == 0
    return out


def test_a_simulated_survey_reads_back(survey: Path) -> None:
    mission = read_mission(survey)
    assert mission.odometry is None and mission.navigation is not None and mission.points is not None
    assert mission.navigation.velocity is not None and not mission.navigation.velocity.bottom_lock.all()
    assert mission.reference.truth is not None and mission.reference.truth.space is not None
    assert mission.points.position_m.shape[1] == 3


def test_the_track_is_better_than_dead_reckoning_and_honest(finished: Path) -> None:
    summary = json.loads((finished / "summary.json").read_text())
    assert summary["trajectory_rmse_m"] < 0.5 * summary["dead_reckoning_rmse_m"]
    assert summary["wrong_pairs"] == 0 and summary["loop_closures"] > 5
    assert summary["landmarks_false"] == 0
    assert 0.2 < summary["nees_joint_per_dof"] < 2.0
    assert summary["steps"] == 7023
    assert set(summary["sensors"]) == {"attitude", "compass", "depth", "altitude", "velocity_log", "side_scan", "fix", "gyro", "camera"}


def test_landmarks_say_how_often_they_were_passed_and_contacts_are_the_confirmed_ones(finished: Path, survey: Path) -> None:
    rows = np.genfromtxt(finished / "landmarks.csv", delimiter=",", names=True)
    assert (rows["passes_seen"] >= 1).all() and (rows["passes_expected"] >= rows["passes_seen"]).all()
    assert (rows["passes_expected"] > 1).any() and (rows["existence"] > 0).all()
    assert ((rows["existence"] >= 0.5) == (rows["confirmed"] == 1)).all()
    contacts = np.genfromtxt(finished / "contacts.csv", delimiter=",", names=True)
    assert contacts["id"].tolist() == rows["id"][rows["confirmed"] == 1].tolist()
    assert len(read_estimate(finished).landmarks.claimed.ids) == len(contacts)

    out = finished.with_name("strict")
    assert run("run", survey, "--out", out, "--no-report", "--set", "existence.min_existence=0.99") == 0
    strict = np.genfromtxt(out / "landmarks.csv", delimiter=",", names=True)
    assert len(strict) == len(rows) and 0 < strict["confirmed"].sum() < rows["confirmed"].sum()


def test_trajectories_hold_depth_and_attitude(finished: Path, survey: Path) -> None:
    final, truth = read_tum(finished / "trajectory.tum"), read_tum(survey / "truth_trajectory.tum")
    assert final.space is not None and truth.space is not None
    at = np.searchsorted(truth.time_s, final.time_s - 1e-6)
    assert np.abs(final.space[:, 0] - truth.space[at, 0]).max() < 0.2
    assert np.abs(final.space[:, 1:] - truth.space[at, 1:]).max() < np.radians(2.0)
    header = (finished / "trajectory_covariance.csv").read_text().split("\n", 1)[0].split(",")
    assert len(header) == 22 and header[1] == "var_xx" and header[-1] == "var_hh"
    assert read_estimate(finished).final_covariance.shape == (len(final.time_s), 6)


def test_landmarks_lie_on_the_bottom(finished: Path) -> None:
    rows = np.genfromtxt(finished / "landmarks.csv", delimiter=",", names=True)
    assert np.abs(rows["z_m"] - 16.0).max() < 1.5
    assert (rows["var_zz"] > 0.0).all()


def test_the_same_mission_gives_the_same_bytes(finished: Path, survey: Path) -> None:
    again = survey.parent / "again"
    assert run("run", survey, "--out", again, "--no-report") == 0
    for name in SAME_BYTES:
        assert (again / name).read_bytes() == (finished / name).read_bytes(), name


def test_the_report_shows_it(finished: Path) -> None:
    assert run("report", finished) == 0
    text = (finished / "report.html").read_text()
    assert "starboard at the start" in text


@pytest.mark.parametrize("flag", ["--smooth", "--calibrate"])
def test_what_is_for_odometry_is_refused(flag: str, survey: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert run("run", survey, "--out", tmp_path / "r", flag) == 2
    assert f"{flag}: is for vehicles with odometry" in capfd.readouterr().err


@pytest.mark.parametrize("method", ["cis", "cekf", "aekf"])
def test_methods_of_the_plane_alone_are_refused(method: str, survey: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    for command in (["run", survey, "--method", method], ["compare", survey, "--methods", f"ssjs,{method}"]):
        assert run(*command, "--out", tmp_path / "r") == 2
        said = capfd.readouterr().err
        assert f"'{method}' is defined for odometry in the plane" in said and "the methods here are ssjs, ekf, lmj" in said
    assert not (tmp_path / "r").exists()


def test_a_joining_method_of_the_plane_answers_in_six_degrees_of_freedom(survey: Path, tmp_path: Path) -> None:
    assert run("run", survey, "--out", tmp_path / "r", "--method", "dcs", "--association", "known") == 0
    summary = json.loads((tmp_path / "r" / "summary.json").read_text())
    assert summary["trajectory_rmse_m"] < 0.6 * summary["dead_reckoning_rmse_m"]
    assert summary["fusions"] == summary["submaps"] - 1
    assert summary["inside_3_sigma_fraction"] > 0.95
    track = read_tum(tmp_path / "r" / "trajectory.tum")
    assert track.space is not None and abs(float(np.median(track.space[:, 0])) - 12.0) < 0.5
    header, first = (tmp_path / "r" / "trajectory_covariance.csv").read_text().splitlines()[:2]
    assert len(header.split(",")) == len(first.split(",")) == 22
    rows = np.genfromtxt(tmp_path / "r" / "landmarks.csv", delimiter=",", names=True)
    assert np.abs(rows["z_m"] - 16.0).max() < 1.5 and (rows["var_zz"] > 0.0).all()
    assert (tmp_path / "r" / "report.html").is_file()


def test_every_method_that_is_defined_is_compared(survey: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert run("compare", survey, "--association", "known", "--out", tmp_path / "c", "--json") == 0
    rows = {row["method"]: row for row in json.loads(capfd.readouterr().out)["methods"]}
    assert tuple(rows) == field_descriptions(UNDERWATER)[METHOD_KEY].choices
    assert all(row["reason"] is None for row in rows.values())
    for method in ("ssjs", "ekf", "lmj", "dcs", "hs", "clsf", "ssjs-fused"):
        assert rows[method]["inside_3_sigma_fraction"] > 0.95, method
    # a heading that is taken for exact is not
    assert rows["ssjs-naive-heading"]["inside_3_sigma_fraction"] < 0.6
    assert rows["ssjs-naive-heading"]["nees_position_per_dof"] > 10.0
    assert (tmp_path / "c" / "report.html").is_file()


def test_a_survey_is_swept_over_the_length_of_its_submaps(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    command = ["sweep", "auv-survey", "--submap-size", "400,100", "--methods", "ssjs", "--runs", 1, "--association", "known", "--json"]
    assert run(*command, "--out", tmp_path / "s") == 0
    document = json.loads(capfd.readouterr().out)
    assert document["submap_sizes"] == [100.0, 400.0] and document["fusion_thresholds"] == [0.3]
    short, long = document["cells"]
    # 1.2 km: twelve or thirteen maps of 100 m, three or four of 400 m
    assert 11 <= short["submaps"] <= 14 and 3 <= long["submaps"] <= 5
    assert short["inside_3_sigma_fraction"] > 0.95
    before = (tmp_path / "s" / "sweep.json").read_bytes()
    assert run(*command, "--out", tmp_path / "s") == 0
    assert (tmp_path / "s" / "sweep.json").read_bytes() == before


def test_a_study_finds_the_contacts_of_simulated_pictures(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    command = ["consistency", "side-scan-survey", "--runs", 1, "--methods", "ssjs,lmj", "--jobs", 1, "--json"]
    assert run(*command, "--out", tmp_path / "s") == 0
    for row in json.loads(capfd.readouterr().out)["runs"]:
        assert row["reason"] is None
        assert row["trajectory_rmse_m"] < 1.5 and row["map_error_mean_m"] < 2.0


def test_the_weakly_known_heading_is_a_mission_of_its_own(tmp_path: Path) -> None:
    assert run("simulate", "auv-survey-weak-heading", "--seed", 2, "--out", tmp_path / "m") == 0
    assert read_mission(tmp_path / "m").settings == {"motion": {"gyro_sigma_rad_s": np.deg2rad(4.0)}, "compass_use": "none"}


def test_the_settings_are_described(capfd: pytest.CaptureFixture[str]) -> None:
    assert run("config", "dump", "--of", "underwater") == 0
    text = capfd.readouterr().out
    assert "[velocity_log]" in text and "[sonar" in text


def still_vehicle(seconds: int) -> UnderwaterNavigation:
    time_s = np.arange(10.0 * seconds) / 10.0
    return UnderwaterNavigation(Attitude(time_s, np.zeros((len(time_s), 3))), depth=Scalars(time_s, np.full(len(time_s), 5.0)))


def test_contacts_are_exported_where_the_mission_has_an_origin(tmp_path: Path) -> None:
    directory = tmp_path / "mission"
    directory.mkdir()
    covariance = np.array([[0.04, 0.0, 0.0, 0.04, 0.0, 0.04]] * 2)
    points = BodyPoints(np.array([1.0, 4.0]), np.array([[0.0, 10.0, 4.0], [0.0, -8.0, 4.0]]), covariance_m2=covariance)
    write_mission(directory, Mission("still", navigation=still_vehicle(6), points=points, geodetic=Geodetic(
        origin_latitude_deg=54.0, origin_longitude_deg=10.0, heading_deg=0.0, y_axis="right")))  # fmt: skip
    np.testing.assert_array_equal(read_mission(directory).points.covariance_m2, covariance)  # type: ignore[union-attr]
    assert run("run", directory, "--out", tmp_path / "run", "--no-report", "--set", "start.speed_m_s=0") == 0
    contacts = np.genfromtxt(tmp_path / "run" / "contacts.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
    assert len(contacts) == 2
    # starboard of a vehicle that heads north is east
    assert sorted(np.sign(contacts["longitude_deg"] - 10.0).tolist()) == [-1.0, 1.0]
    connection = sqlite3.connect(tmp_path / "run" / "contacts.gpkg")
    assert connection.execute("SELECT count(*) FROM contacts").fetchone() == (2,)
    connection.close()
    assert (tmp_path / "run" / "contacts.kml").is_file() and (tmp_path / "run" / "contacts.geojson").is_file()


def test_a_point_whose_covariance_is_none_is_named(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    directory = tmp_path / "mission"
    directory.mkdir()
    write_mission(directory, Mission("still", navigation=still_vehicle(1)))
    names = "time_s,x_m,y_m,z_m,var_xx_m2,cov_xy_m2,cov_xz_m2,var_yy_m2,cov_yz_m2,var_zz_m2"
    (directory / "observations.csv").write_text(f"{names}\n0.5,0,10,4,1,2,0,1,0,1\n")
    assert run("run", directory, "--out", tmp_path / "run") == 2
    assert "observations.csv:2: the covariance of the point is not positive definite" in capfd.readouterr().err


def test_an_origin_of_a_world_on_land_is_refused(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    directory = tmp_path / "mission"
    directory.mkdir()
    write_mission(
        directory, Mission("still", navigation=still_vehicle(1), geodetic=Geodetic(origin_latitude_deg=1, origin_longitude_deg=2))
    )
    assert run("run", directory, "--out", tmp_path / "run") == 2
    assert 'set heading_deg = 0.0 and y_axis = "right"' in capfd.readouterr().err


def test_a_vehicle_without_velocity_is_warned_of(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    directory = tmp_path / "mission"
    directory.mkdir()
    write_mission(directory, Mission("still", navigation=still_vehicle(6)))
    assert run("run", directory, "--out", tmp_path / "run", "--no-report") == 0
    assert "no velocity over the bottom" in capfd.readouterr().err


@pytest.mark.parametrize("command", ["info", "detect"])
def test_a_log_is_never_overwritten(command: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    log = tmp_path / "survey.xtf"
    log.write_bytes(b"\x7b" + bytes(4096))
    before = log.read_bytes()
    assert run("sonar", command, log, "--out", log, "--force") == 2
    assert log.read_bytes() == before
