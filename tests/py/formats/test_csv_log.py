import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ssjs_cli.errors import UserError
from ssjs_cli.formats.csv_log import find_log_files, parse_mappings, read_csv_log
from ssjs_cli.formats.mission import Mission

NOTHING = {"odometry": None, "observations": None, "fixes": None, "landmarks": None}


def mission_of(directory: Path, *mappings: str, delimiter: str = ",", **texts: str) -> Mission:
    for name, text in texts.items():
        (directory / f"{name}.csv").write_text(text)
    return read_csv_log(find_log_files(directory, NOTHING), parse_mappings(mappings), name="log", delimiter=delimiter)


def test_columns_are_renamed_and_converted(tmp_path: Path) -> None:
    mission = mission_of(
        tmp_path,
        "time_s=t:ms",
        "speed_m_s=v:km/h",
        "turn_rate_rad_s=gyro:-deg/s",
        odometry="t,gyro,v,junk\n21940,0,0,a\n21965,90,36,b\n".replace(",a", ",1").replace(",b", ",2"),
    )
    assert mission.odometry.kind == "unicycle"
    # 36 km/h = 10 m/s; 90 deg/s turned round is -pi/2 rad/s; 21940 ms = 21.94 s exactly
    assert mission.odometry.values.tolist() == [[21.94, 0.0, 0.0], [21.965, 10.0, -math.pi / 2]]
    assert mission.settings == {"vehicle": {"kind": "unicycle"}}


def test_a_column_that_is_not_mapped_may_hold_any_text(tmp_path: Path) -> None:
    mission = mission_of(tmp_path, odometry="time_s,speed_m_s,mode,turn_rate_rad_s\n0,1,auto,0\n1,1,,0\n")
    assert mission.odometry.values.tolist() == [[0.0, 1.0, 0.0], [1.0, 1.0, 0.0]]


def test_a_mapping_may_be_for_one_file_only(tmp_path: Path) -> None:
    mission = mission_of(
        tmp_path,
        "observations.time_s=stamp:ns",
        "range_m=r:mm",
        odometry="time_s,speed_m_s,turn_rate_rad_s\n0,1,0\n2,1,0\n",
        observations="stamp,r,bearing_rad,landmark_id\n1500000000,2500,0.5,4\n",
    )
    assert mission.observations is not None
    assert (mission.observations.time_s.tolist(), mission.observations.range_m.tolist()) == ([1.5], [2.5])
    assert mission.observations.landmark_id is not None
    assert mission.observations.landmark_id.tolist() == [4]


def test_other_delimiters(tmp_path: Path) -> None:
    mission = mission_of(tmp_path, delimiter=";", odometry="time_s;speed_m_s;turn_rate_rad_s\n0;1;0\n")
    assert len(mission.odometry.values) == 1


def test_fixes_and_landmarks_come_along(tmp_path: Path) -> None:
    mission = mission_of(
        tmp_path,
        odometry="time_s,speed_m_s,turn_rate_rad_s\n0,1,0\n",
        reference_fixes="time_s,x_m,y_m\n0,1,2\n",
        truth_landmarks="id,x_m,y_m\n7,1,2\n",
    )
    assert mission.reference.fixes is not None
    assert mission.reference.landmarks is not None
    assert mission.reference.landmarks.ids.tolist() == [7]


@pytest.mark.parametrize(
    ("mapping", "message"),
    [
        ("time_s", r"--map time_s: must be target=source\[:unit\], for example time_s=t:ms"),
        ("tim_s=t", r"--map tim_s=t: unknown target column 'tim_s' \(did you mean 'time_s'\?\)"),
        ("odometri.time_s=t", r"unknown file 'odometri' \(did you mean 'odometry'\?\)"),
        ("time_s=t:sec", r"--map time_s=t:sec: unknown unit 'sec' of 'time_s'"),
        ("time_s=t:deg", r"unknown unit 'deg' of 'time_s'.*; known: s, ms, us, ns, min, h"),
        ("landmark_id=n:m", r"column 'landmark_id' has no unit; leave ':m' out"),
    ],
)
def test_a_wrong_mapping_says_what_it_must_be(mapping: str, message: str) -> None:
    with pytest.raises(UserError, match=message):
        parse_mappings([mapping])


@pytest.mark.parametrize(
    ("text", "mappings", "message"),
    [
        ("time_s,speed_m_s\n0,1\n", [], r"odometry\.csv:1: .* is missing; the header holds time_s,speed_m_s; name the column with --map "),
        ("t,speed_m_s,steering_rad\n0,1,0\n", ["time_s=stamp"], r"odometry\.csv:1: "),
        ("time_s,speed_m_s,turn_rate_rad_s\n", [], r"odometry\.csv: the mission is empty"),
        ("time_s,speed_m_s,turn_rate_rad_s\n1,1,0\n0,1,0\n", [], r"odometry\.csv:3: time_s = 0\.0 goes back from 1\.0"),
        ("time_s,speed_m_s,turn_rate_rad_s\n1,fast,0\n", [], r"odometry\.csv:2: speed_m_s = 'fast' is not a number"),
        (
            "time_s,speed_m_s,turn_rate_rad_s,steering_rad\n1,1,0,0\n",
            [],
            r"odometry\.csv:1: holds the columns of ackerman and unicycle odometry",
        ),
    ],
)
def test_faults_name_the_file_and_the_line(tmp_path: Path, text: str, mappings: list[str], message: str) -> None:
    with pytest.raises(UserError, match=message):
        mission_of(tmp_path, *mappings, odometry=text)


def test_a_given_file_that_is_missing_is_named(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"--observations laser\.csv: .*laser\.csv is missing"):
        find_log_files(tmp_path, {**NOTHING, "observations": "laser.csv"})


@given(rows=st.lists(st.tuples(st.integers(0, 10**12), st.floats(-50, 50), st.floats(-3, 3)), min_size=1, max_size=20))
def test_an_unmapped_log_keeps_its_numbers_exactly(rows: list[tuple[int, float, float]], tmp_path_factory: pytest.TempPathFactory) -> None:
    rows = sorted(rows, key=lambda row: row[0])
    text = "time_s,speed_m_s,turn_rate_rad_s\n" + "".join(f"{time!r},{speed!r},{rate!r}\n" for time, speed, rate in rows)
    mission = mission_of(tmp_path_factory.mktemp("log"), odometry=text)
    assert np.array_equal(mission.odometry.values, np.array(rows, dtype=float))
