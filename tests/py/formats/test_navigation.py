from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from ssjs_cli.errors import UserError
from ssjs_cli.formats.navigation import Attitude, BottomVelocity, Scalars, UnderwaterNavigation, read_navigation, write_navigation

TIME_S = np.array([0.0, 0.1, 0.1, 0.35])
NAVIGATION = UnderwaterNavigation(
    Attitude(TIME_S, np.arange(12.0).reshape(4, 3) / 7.0, np.arange(12.0).reshape(4, 3) / 3.0),
    BottomVelocity(TIME_S[:2], np.array([[1.5, 0.1, -0.2], [np.nan, np.nan, np.nan]]), np.array([True, False])),
    Scalars(TIME_S, np.linspace(1.0, 2.0, 4)),
    Scalars(TIME_S[1:], np.linspace(9.0, 8.0, 3)),
)


def test_what_is_written_reads_back_to_the_last_bit(tmp_path: Path) -> None:
    write_navigation(tmp_path, NAVIGATION)
    read = read_navigation(tmp_path)
    assert read is not None
    for sensor in fields(UnderwaterNavigation):
        expected, found = getattr(NAVIGATION, sensor.name), getattr(read, sensor.name)
        if expected is None:  # fixes are read with the mission, which knows where its origin is
            continue
        for column in fields(expected):
            np.testing.assert_array_equal(getattr(found, column.name), getattr(expected, column.name))


def test_a_mission_on_land_has_none(tmp_path: Path) -> None:
    assert read_navigation(tmp_path) is None


def test_a_velocity_without_lock_may_be_empty_and_one_with_it_may_not(tmp_path: Path) -> None:
    (tmp_path / "imu.csv").write_text("time_s,roll_rad,pitch_rad,yaw_rad\n0,0,0,0\n")
    path = tmp_path / "dvl.csv"
    path.write_text("time_s,vx_m_s,vy_m_s,vz_m_s,bottom_lock\n0,,,,0\n")
    read = read_navigation(tmp_path)
    assert read is not None and read.velocity is not None and not read.velocity.bottom_lock[0]
    path.write_text("time_s,vx_m_s,vy_m_s,vz_m_s,bottom_lock\n0,1,2,3,1\n1,,,,1\n")
    with pytest.raises(UserError, match=r"dvl\.csv:3: a velocity is empty"):
        read_navigation(tmp_path)


@pytest.mark.parametrize(
    ("name", "text", "complaint"),
    [
        ("depth.csv", "time_s,depth_m\n0,1\n", r"imu\.csv: is missing beside depth\.csv"),
        ("imu.csv", "time_s,roll_rad,pitch_rad,yaw_rad\n1,0,0,0\n0,0,0,0\n", r"imu\.csv:3: time_s = 0\.0 goes back"),
        ("imu.csv", "time_s,roll_rad,pitch_rad,yaw_rad\n", r"imu\.csv: holds no line"),
        ("imu.csv", "time_s,roll_deg,pitch_rad,yaw_rad\n0,0,0,0\n", r"imu\.csv:1: unknown column 'roll_deg'.*roll_rad"),
        ("imu.csv", "time_s,roll_rad,pitch_rad,yaw_rad,turn_rate_z_rad_s\n0,0,0,0,0\n", r"imu\.csv:1: holds turn_rate_z_rad_s alone"),
        ("dvl.csv", "time_s,vx_m_s,vy_m_s,vz_m_s,bottom_lock\n0,1,2,3,2\n", r"dvl\.csv:2: bottom_lock = 2\.0 must be 1"),
    ],
)
def test_a_fault_is_named_with_its_line(tmp_path: Path, name: str, text: str, complaint: str) -> None:
    if name == "dvl.csv":
        (tmp_path / "imu.csv").write_text("time_s,roll_rad,pitch_rad,yaw_rad\n0,0,0,0\n")
    (tmp_path / name).write_text(text)
    with pytest.raises(UserError, match=complaint):
        read_navigation(tmp_path)
