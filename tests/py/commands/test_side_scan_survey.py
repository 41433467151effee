"""A survey from sonar pictures to a map: simulated, detected, corrected."""

import csv
import json
from pathlib import Path

import pytest

from ssjs_cli.app import main
from ssjs_cli.formats.mission import read_mission
from ssjs_cli.sonar.log_blocks import open_log


def run(*arguments: str | Path) -> int:
    with pytest.raises(SystemExit) as ended:
        main([str(argument) for argument in arguments])
    return int(ended.value.code or 0)


@pytest.fixture(scope="module")
def survey(tmp_path_factory: pytest.TempPathFactory) -> Path:
    directory = tmp_path_factory.mktemp("survey") / "mission"
    assert run("simulate", "side-scan-survey", "--seed", "3", "--out", directory) == 0
    return directory


def test_the_mission_holds_navigation_pings_and_truth(survey: Path) -> None:
    mission = read_mission(survey)
    assert mission.navigation is not None and mission.points is None
    assert [path.name for path in mission.sonar_logs] == ["survey.xtf"]
    assert mission.reference.landmarks is not None and len(mission.reference.landmarks.ids) == 60
    log = open_log(mission.sonar_logs[0])
    block = log.read(100_000)
    assert block is not None and not log.info()["problems"]
    time_s = block["pings"]["time_s"]
    assert abs(time_s[0] - mission.time_s[0]) < 0.01 and abs(time_s[-1] - mission.time_s[-1]) < 0.2


def test_contacts_correct_the_track(survey: Path, tmp_path: Path) -> None:
    assert run("run", survey, "--out", tmp_path / "run", "--no-report") == 0
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert summary["loop_closures"] > 0
    assert summary["trajectory_rmse_m"] < summary["dead_reckoning_rmse_m"]
    assert summary["map_error_matched"] >= 30


def test_the_run_leaves_a_picture_of_each_contact_and_its_coverage(survey: Path, tmp_path: Path) -> None:
    directory = tmp_path / "run"
    assert run("run", survey, "--out", directory) == 0
    with (directory / "contacts.csv").open(newline="") as file:
        named = [row["snippet"] for row in csv.DictReader(file) if row["snippet"]]
    assert len(named) >= 40
    assert len(set(named)) == len(named)
    assert all((directory / name).is_file() for name in named)
    with (directory / "sightings.csv").open(newline="") as file:
        sightings = list(csv.DictReader(file))
    summary = json.loads((directory / "summary.json").read_text())
    assert len(sightings) == summary["sightings"] == summary["observations"]
    assert {row["contact"] for row in sightings} >= {
        name.removeprefix("snippets/contact-").removesuffix(".png").lstrip("0") for name in named
    } - {""}
    # five lines of 120 m, 20 m apart, with 29 m to each side, and cross lines: the whole of 120 m x 80 m and what lies around it
    assert 120 * 80 < summary["coverage_area_m2"] < summary["surveyed_area_m2"] < 200 * 170
    assert summary["coverage_twice_fraction"] < summary["coverage_fraction"] < 1.0
    page = (directory / "report.html").read_text(encoding="utf-8")
    assert page.count('class="contact-card"') == len(named)
    assert len(page) < 15e6


def test_a_survey_can_be_replaced(survey: Path) -> None:
    before = (survey / "pings" / "survey.xtf").read_bytes()
    assert run("simulate", "side-scan-survey", "--seed", "3", "--out", survey, "--force") == 0
    assert (survey / "pings" / "survey.xtf").read_bytes() == before
