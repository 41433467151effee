from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ssjs_cli.formats.mission import input_digests, read_mission
from ssjs_cli.formats.scenario_file import read_scenario_file, simulator_defaults, toml_keys

EXAMPLES = Path(__file__).parents[3] / "examples" / "scenarios"
WORLD = """
[path]
waypoints_m = [[0.0, 0.0], [30.0, 0.0]]
[landmarks]
positions_m = [[5.0, 3.0], [15.0, -3.0], [25.0, 3.0]]
"""


def test_the_written_out_grid_survey_is_the_built_in_one(cli: Callable[..., Any], tmp_path: Path) -> None:
    assert cli("simulate", EXAMPLES / "grid-survey.toml", "--seed", 4, "--out", tmp_path / "file").code == 0
    assert cli("simulate", "grid-survey", "--seed", 4, "--out", tmp_path / "built-in").code == 0
    assert input_digests(tmp_path / "file") == input_digests(tmp_path / "built-in")


@pytest.mark.parametrize("example", sorted(EXAMPLES.glob("*.toml")), ids=lambda path: path.stem)
def test_every_example_runs(cli: Callable[..., Any], tmp_path: Path, example: Path) -> None:
    assert cli("simulate", example, "--out", tmp_path / "m").code == 0
    assert cli("run", tmp_path / "m", "--out", tmp_path / "r", "--no-report").code == 0


def test_every_key_of_the_simulator_has_its_place() -> None:
    assert set(toml_keys()) == set(simulator_defaults())
    assert len(set(toml_keys().values())) == len(toml_keys())
    assert all(place.split(".")[0] in ("vehicle", "sensor") for place in toml_keys().values())


def test_the_sensor_sees_what_the_file_says(cli: Callable[..., Any], tmp_path: Path) -> None:
    path = tmp_path / "line.toml"
    path.write_text(
        'name = "line"\n[vehicle]\nstep_s = 0.1\n[sensor]\nmax_range_m = 12.0\nfield_of_view_rad = 3.0\nscan_period_s = 0.4\n' + WORLD
    )
    assert cli("simulate", path, "--seed", 2, "--out", tmp_path / "m").code == 0
    mission = read_mission(tmp_path / "m")
    assert mission.name == "line"
    assert mission.description == "simulated: line, seed 2"
    observations = mission.observations
    assert observations is not None
    # four steps of 0.1 s a scan; half of 3 rad to each side, plus noise of 1 degree
    assert np.allclose(np.round(observations.time_s / 0.4), observations.time_s / 0.4)
    assert np.abs(observations.bearing_rad).max() < 1.5 + 0.1
    assert observations.range_m.max() < 12.5
    assert mission.settings["vehicle"]["ackerman"]["noise_step_s"] == 0.1


def test_landmarks_of_a_random_field_follow_the_seed(cli: Callable[..., Any], tmp_path: Path) -> None:
    for name, seed in (("a", 3), ("b", 3), ("c", 4)):
        assert cli("simulate", EXAMPLES / "pond.toml", "--seed", seed, "--out", tmp_path / name).code == 0
    assert input_digests(tmp_path / "a") == input_digests(tmp_path / "b")
    landmarks = [read_mission(tmp_path / name).reference.landmarks.position_m for name in ("a", "c")]
    assert landmarks[0].shape == landmarks[1].shape == (40, 2)
    assert not np.allclose(landmarks[0], landmarks[1])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (WORLD + "[senor]\nmax_range_m = 3.0\n", "unknown key 'senor' (did you mean 'sensor'?)"),
        (WORLD + "[sensor]\nmax_range = 3.0\n", "unknown key 'sensor.max_range' (did you mean 'sensor.max_range_m'?)"),
        (WORLD + "[vehicle]\nsteps_per_scan = 3\n", "unknown key 'vehicle.steps_per_scan'"),
        (WORLD + "[vehicle]\nspeed_m_s = -1.0\n", "vehicle.speed_m_s = -1: must be positive"),
        (WORLD + "[vehicle]\nspeed_m_s = true\n", "vehicle.speed_m_s = true: must be a number"),
        (WORLD + "[sensor]\nfield_of_view_rad = 7.0\n", "sensor.field_of_view_rad = 7: must lie in"),
        (WORLD + "[sensor]\nscan_period_s = 0.02\n", "sensor.scan_period_s = 0.02: must be a whole number of steps of 0.0125 s"),
        (WORLD + "[sensor]\nscan_period_s = 0.0\n", "sensor.scan_period_s = 0.0: must be a whole number of steps"),
        (WORLD + "[sensor]\nmin_range_m = 9.0\n", "max_range_m = 8: must be above min_range_m"),
        (WORLD + "seed = 3\n", "unknown key 'landmarks.seed' (did you mean 'seed'?)"),
        ("[path]\nwaypoints_m = [[0.0, 0.0], [1.0, 0.0]]\n", "key 'landmarks' is missing"),
        ("[landmarks]\npositions_m = [[1.0, 1.0]]\n", "key 'path' is missing"),
        ("[landmarks]\npositions_m = [[1.0, 1.0]]\n[path]\n", "[path]: is empty; give exactly one of waypoints_m, lawn_mower"),
        (WORLD + "[landmarks.grid]\ncolumns = 2\nrows = 2\nspacing_m = 3.0\n", "holds positions_m and grid; give exactly one of"),
        (WORLD.replace("[30.0, 0.0]", "[0.0, 0.0]"), "path.waypoints_m[1] = 0: must be finite and differ from the point before"),
        (WORLD.replace("[30.0, 0.0]", "[nan, 0.0]"), "[path]: holds a number that is not finite"),
        (WORLD.replace("[30.0, 0.0]", "[30.0]"), "path.waypoints_m.1"),
        (WORLD.replace("[30.0, 0.0]", "[1e12, 0.0]"), "are too many; shorten the path or lengthen step_s"),
        ("scenario = 'grid-survey'\n" + WORLD, "unknown key 'path'"),
        (
            "[path]\nwaypoints_m = [[0.0, 0.0], [9.0, 0.0]]\n"
            "[landmarks.random]\ncount = 900\nwidth_m = 9.0\nheight_m = 9.0\nmin_distance_m = 2.0\n",
            "[landmarks.random]: min_distance_m = 2: leaves room for about",
        ),
        (
            "[path]\nwaypoints_m = [[0.0, 0.0], [9.0, 0.0]]\n[landmarks.grid]\ncolumns = 3\nrows = 3\nspacing_m = 2.0\njitter_m = 1.5\n",
            "[landmarks.grid]: jitter_m = 1.5: must be at least 0 and below half the spacing",
        ),
        ("this is = = no TOML\n", "is not valid TOML"),
        (WORLD + "[settings.submap]\nmax_landmark = 5\n", "unknown key 'submap.max_landmark' (did you mean 'submap.max_landmarks'?)"),
    ],
)
def test_a_faulty_file_is_the_users_error(cli: Callable[..., Any], tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(text)
    answer = cli("simulate", path, "--out", tmp_path / "m")
    assert answer.code == 2, answer.err
    assert message in answer.err
    assert not (tmp_path / "m").exists()


def test_defaults_that_are_left_out_stay_out(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(WORLD)
    document = read_scenario_file(path)
    assert document["vehicle"] == {}
    assert document["sensor"] == {}
