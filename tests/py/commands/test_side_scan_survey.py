"""A survey from sonar pictures to a map: simulated, detected, corrected."""

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


def test_a_survey_can_be_replaced(survey: Path) -> None:
    before = (survey / "pings" / "survey.xtf").read_bytes()
    assert run("simulate", "side-scan-survey", "--seed", "3", "--out", survey, "--force") == 0
    assert (survey / "pings" / "survey.xtf").read_bytes() == before
