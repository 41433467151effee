import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ssjs_cli.formats.mission import input_digests, read_mission
from ssjs_cli.simulation import read_scenario


@pytest.fixture
def simulated(cli: Callable[..., Any], tmp_path: Path) -> Path:
    answer = cli("simulate", "grid-survey", "--seed", 4, "--out", tmp_path / "a")
    assert answer.code == 0, answer.err
    return tmp_path / "a"


def test_a_simulated_mission_has_truth_and_settings(simulated: Path) -> None:
    mission = read_mission(simulated)
    assert mission.odometry.kind == "ackerman"
    assert mission.observations is not None
    assert mission.observations.landmark_id is not None
    assert mission.reference.truth is not None
    assert mission.reference.landmarks is not None
    # The grid of 21 x 21 landmarks; a scan every 24 steps of 12.5 ms
    assert len(mission.reference.landmarks.ids) == 441
    assert np.unique(mission.observations.time_s)[:2] == pytest.approx([0.3, 0.6])
    assert mission.settings["vehicle"]["ackerman"]["noise_step_s"] == 0.0125
    assert mission.reference.description.alignment == "none"


def test_the_same_seed_gives_the_same_bytes_and_another_seed_others(cli: Callable[..., Any], simulated: Path, tmp_path: Path) -> None:
    assert cli("simulate", "grid-survey", "--seed", 4, "--out", tmp_path / "b").code == 0
    assert input_digests(simulated) == input_digests(tmp_path / "b")
    assert cli("simulate", "grid-survey", "--seed", 5, "--out", tmp_path / "c").code == 0
    assert input_digests(simulated)["odometry.csv"] != input_digests(tmp_path / "c")["odometry.csv"]


def test_a_scenario_file_lays_settings_over_a_built_in_one(cli: Callable[..., Any], simulated: Path, tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('scenario = "grid-survey"\nseed = 4\n[settings.sensor]\nrange_sigma_m = 0.3\n')
    answer = cli("simulate", path, "--out", tmp_path / "b", "--json")
    assert answer.code == 0, answer.err
    assert json.loads(answer.out)["name"] == "mine"
    assert read_mission(tmp_path / "b").settings["sensor"]["range_sigma_m"] == 0.3
    assert input_digests(tmp_path / "b")["odometry.csv"] == input_digests(simulated)["odometry.csv"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('scenario = "grid-survey"\nsed = 4\n', "unknown key 'sed' (did you mean 'seed'?)"),
        ("seed = 4\n", "key 'scenario' is missing"),
        (
            'scenario = "grid-survey"\n[settings.sensor]\nrange_sigma = 1.0\n',
            "unknown key 'sensor.range_sigma' (did you mean 'sensor.range_sigma_m'?)",
        ),
        ('scenario = "grid-survey"\nseed = -1\n', "seed = -1: must be a whole number from 0"),
    ],
)
def test_a_faulty_scenario_file_is_the_users_error(cli: Callable[..., Any], tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(text)
    answer = cli("simulate", path, "--out", tmp_path / "b")
    assert answer.code == 2
    assert message in answer.err
    assert not (tmp_path / "b").exists()


def test_an_unknown_scenario_lists_the_known_ones(cli: Callable[..., Any], tmp_path: Path) -> None:
    answer = cli("simulate", "grid-survay", "--out", tmp_path / "b")
    assert answer.code == 2
    assert "scenario 'grid-survay' is not known (did you mean 'grid-survey'?); the built-in ones are grid-survey, " in answer.err


def test_an_existing_mission_is_kept_without_force(cli: Callable[..., Any], simulated: Path) -> None:
    assert cli("simulate", "grid-survey", "--seed", 9, "--out", simulated).code == 2
    assert cli("simulate", "grid-survey", "--seed", 9, "--out", simulated, "--force").code == 0
    assert "seed 9" in read_mission(simulated).description


SMALL_PICTURES = ("--set", "picture.pixel_m=0.5", "--set", "picture.max_range_m=12", "--set", "segmentation.smallest_area_px=4")


def test_the_loop_in_pictures_observes_regions_with_covariances(cli: Callable[..., Any], tmp_path: Path) -> None:
    counts = {}
    for method in ("improved-otsu", "max-entropy"):
        out = tmp_path / method
        answer = cli("simulate", "aekf-loop-images", *SMALL_PICTURES, "--set", f"segmentation.method={method}", "--out", out)
        assert answer.code == 0, answer.err
        mission = read_mission(out)
        assert mission.observations is not None
        assert mission.observations.covariance is not None
        # The sensor's own 0.1 m and what the centroid adds
        assert mission.observations.covariance[:, 0].min() > 0.01
        assert mission.observations.range_m.max() < 12.5
        assert mission.reference.landmarks is not None
        assert set(range(54)) <= set(mission.reference.landmarks.ids.tolist())
        assert "pictures" in mission.notes
        counts[method] = len(mission.observations.time_s)
    assert counts["improved-otsu"] != counts["max-entropy"]
    answer = cli("run", tmp_path / "max-entropy", "--method", "aekf", "--no-report", "--out", tmp_path / "run")
    assert answer.code == 0, answer.err


def test_a_scenario_file_sets_pictures_and_the_command_line_wins(cli: Callable[..., Any], tmp_path: Path) -> None:
    text = (
        'scenario = "aekf-loop-images"\n[pictures.picture]\npixel_m = 0.5\nmax_range_m = 12.0\n[pictures.segmentation]\nmethod = "otsu"\n'
    )
    (tmp_path / "loop.toml").write_text(text)
    scenario = read_scenario(str(tmp_path / "loop.toml"), 3, ("picture.pixel_m=1.0",))
    assert scenario.pictures == {"picture.pixel_m": 1.0, "picture.max_range_m": 12.0, "segmentation.method": "otsu"}
    assert scenario.identity["pictures"] == scenario.pictures


@pytest.mark.parametrize(
    ("scenario", "assignment", "message"),
    [
        ("grid-survey", "picture.pixel_m=1", "--set: scenario 'grid-survey' has no pictures to set; aekf-loop-images has"),
        ("aekf-loop-images", "picture.pixel=1", "--set: unknown key 'picture.pixel' (did you mean 'picture.pixel_m'?)"),
        ("aekf-loop-images", "picture.max_range_m=0.5", "picture.max_range_m: must be above picture.min_range_m"),
        ("aekf-loop-images", "segmentation.method=entropy", "must be one of improved-otsu"),
    ],
)
def test_wrong_settings_of_pictures_are_the_users_error(
    cli: Callable[..., Any], tmp_path: Path, scenario: str, assignment: str, message: str
) -> None:
    answer = cli("simulate", scenario, "--set", assignment, "--out", tmp_path / "a")
    assert answer.code == 2
    assert message in answer.err
    assert not (tmp_path / "a").exists()
