import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

LIMIT_S = 60.0
SURVEY_LIMIT_S = 120.0


def test_the_demo_runs_the_whole_chain(cli: Callable[..., Any], tmp_path: Path) -> None:
    started = time.perf_counter()
    answer = cli("demo", "--scenario", "grid-survey", "--out", tmp_path / "demo", "--json")
    spent_s = time.perf_counter() - started
    assert answer.code == 0, answer.err
    document = json.loads(answer.out)
    assert document["report"] == str(tmp_path / "demo" / "report.html")
    assert (tmp_path / "demo" / "report.html").stat().st_size > 0
    assert (tmp_path / "demo-mission" / "mission.toml").is_file()
    assert document["mission"] == "grid-survey"
    assert document["trajectory_rmse_m"] < document["dead_reckoning_rmse_m"]
    assert spent_s < LIMIT_S
    assert cli("demo", "--scenario", "grid-survey", "--out", tmp_path / "demo").code == 2


def test_the_first_minutes_of_the_survey_under_water(cli: Callable[..., Any], tmp_path: Path) -> None:
    scenario = tmp_path / "beginning.toml"
    scenario.write_text('scenario = "remus-survey"\n[survey.vehicle]\nduration_s = 1200.0\n')
    answer = cli("demo", "--scenario", scenario, "--out", tmp_path / "demo")
    assert answer.code == 0, answer.err
    assert "objects found" in answer.out and "dead reckoning" in answer.out
    assert str(tmp_path / "demo" / "report.html") in answer.out
    assert (tmp_path / "demo-mission" / "pings" / "survey.xtf").is_file()
    assert (tmp_path / "demo" / "contacts.csv").is_file()


@pytest.mark.long
def test_the_demo_is_a_survey_from_sonar_pings_in_two_minutes(cli: Callable[..., Any], tmp_path: Path) -> None:
    started = time.process_time()
    answer = cli("demo", "--out", tmp_path / "demo", "--json")
    spent_s = time.process_time() - started
    assert answer.code == 0, answer.err
    document = json.loads(answer.out)
    assert document["mission"] == "remus-survey"
    assert document["dead_reckoning_rmse_m"] > 4.0 * document["trajectory_rmse_m"]
    assert document["contacts_found_fraction"] >= 0.9
    assert document["contact_position_rms_m"] <= 1.5
    assert spent_s < SURVEY_LIMIT_S
