from pathlib import Path

import numpy as np
import pytest

from ssjs_cli.errors import UserError
from ssjs_cli.formats.attitude import rotation
from ssjs_cli.formats.mission import read_mission, write_mission
from ssjs_cli.formats.stpere import degrees_of, read_stpere

COMMENT = "% Time: 17:35:52 trueCourse(\xba)\n\n"
AHRS = COMMENT + "100.0 90.0 -45.0 180.0 0.1 0.2 0.3 -0.4 -0.1 -9.8 \r\n100.1 0.0 0.0 -90.0 0.1 0.2 0.3 -0.4 -0.1 -9.8 \r\n"
TAIL = "1.84 1.88 1.86 143 142 149 100 207.7 -0.5 1.6 14.27 1488.00 12.80 0.5 1.5 0.08 -0.25\r\n"
# Water velocities first; the bottom velocities are the second three.
LOCKED = "100.05 2007 3 16 13 0 56 38.2 -47.0 1.8 1 100.0 0.0 -50.0 1 " + TAIL
LOST = "100.70 2007 3 16 13 0 57 38.2 -47.0 1.8 1 32767 32767 32767 0 " + TAIL
DGPS = COMMENT + "100.9 4212.225 306.2832 1 -2.1 51.8 23.6 24 0.1 0.1\r\n101.9 4212.235 306.2832 1 -2.1 51.8 23.6 24 0.1 0.1\r\n"


def source(tmp_path: Path, ahrs: str = AHRS, dvl: str = COMMENT + LOCKED + LOST, dgps: str = DGPS) -> Path:
    for name, text in (("_1_MTI.log", ahrs), ("_1_DVL.log", dvl), ("_1_DGPS.log", dgps)):
        (tmp_path / name).write_bytes(text.encode("latin-1"))
    return tmp_path


def test_columns_called_position_are_angles_in_degrees(tmp_path: Path) -> None:
    navigation = read_stpere(source(tmp_path)).navigation
    assert navigation is not None
    assert navigation.attitude.angles_rad == pytest.approx(np.array([[np.pi / 2, -np.pi / 4, np.pi], [0.0, 0.0, -np.pi / 2]]))
    assert navigation.attitude.turn_rate_rad_s is not None
    assert navigation.attitude.turn_rate_rad_s[0].tolist() == [0.1, 0.2, 0.3]


def test_bottom_velocities_are_turned_into_the_body_and_those_without_lock_marked(tmp_path: Path) -> None:
    mission = read_stpere(source(tmp_path))
    assert mission.navigation is not None and mission.navigation.velocity is not None
    velocity = mission.navigation.velocity
    # Upside down: (1, 0, -0.5) m/s -> (1, 0, 0.5); then 60 degrees aside: (cos 60, sin 60, 0.5).
    assert velocity.velocity_m_s[0] == pytest.approx([0.5, np.sqrt(0.75), 0.5])
    assert velocity.bottom_lock.tolist() == [True, False]
    assert np.isnan(velocity.velocity_m_s[1]).all()
    assert mission.import_record is not None
    assert mission.import_record.counts["bottom_velocities_without_lock"] == 1


def test_the_number_that_means_no_velocity_is_none_whatever_the_status(tmp_path: Path) -> None:
    dvl = COMMENT + LOCKED + LOST.replace("32767 0 ", "32767 1 ")
    navigation = read_stpere(source(tmp_path, dvl=dvl)).navigation
    assert navigation is not None and navigation.velocity is not None
    assert navigation.velocity.bottom_lock.tolist() == [True, False]


def test_the_reference_is_north_and_east_of_the_first_fix(tmp_path: Path) -> None:
    mission = read_stpere(source(tmp_path))
    assert mission.reference.fixes is not None
    # 0.01' of latitude: a hundredth of a nautical mile, 18.5 m at this latitude.
    assert mission.reference.fixes.position_m == pytest.approx(np.array([[0.0, 0.0], [18.51, 0.0]]), abs=0.01)
    assert mission.geodetic is not None
    assert mission.geodetic.origin_latitude_deg == pytest.approx(42.20375)
    assert mission.geodetic.origin_longitude_deg == pytest.approx(3.10472)


def test_a_mission_without_odometry_is_written_and_read_back(tmp_path: Path) -> None:
    directory = tmp_path / "mission"
    directory.mkdir()
    write_mission(directory, read_stpere(source(tmp_path)))
    mission = read_mission(directory)
    assert mission.odometry is None
    assert mission.navigation is not None and mission.navigation.velocity is not None
    assert mission.navigation.depth is None  # the pressure column is none
    assert mission.time_s.tolist() == [100.0, 100.1]


def test_rotation_turns_roll_first_and_yaw_last() -> None:
    assert rotation(np.pi / 2, 0.0, np.pi / 2) @ [0.0, 1.0, 0.0] == pytest.approx([0.0, 0.0, 1.0])
    assert rotation(0.0, np.pi / 2, 0.0) @ [1.0, 0.0, 0.0] == pytest.approx([0.0, 0.0, -1.0])


def test_degrees_and_minutes() -> None:
    assert degrees_of(np.array([4212.225, 306.2832]), Path("x")) == pytest.approx([42.20375, 3.10472])
    with pytest.raises(UserError, match=r"x: 4275\.0 is no angle of degrees and minutes"):
        degrees_of(np.array([4275.0]), Path("x"))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (AHRS.replace(" -9.8 \r\n", "\r\n", 1), r"_MTI\.log:3: has 9 fields where 10 are needed"),
        (AHRS.replace("-45.0", "fast"), r"_MTI\.log:3: could not convert"),
        (AHRS.replace("-45.0", "nan"), r"_MTI\.log:3: holds NaN"),
        (AHRS.replace("100.1", "99.1"), r"_MTI\.log:4: the time goes back from 100\.0 to 99\.1"),
        (COMMENT, r"_MTI\.log: holds no line of numbers"),
    ],
)
def test_bad_lines_are_named(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(UserError, match=message):
        read_stpere(source(tmp_path, ahrs=text))


def test_files_must_be_there_once(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"holds 0 files \*_MTI\.log; it must hold exactly one"):
        read_stpere(tmp_path)
    source(tmp_path)
    (tmp_path / "_2_DVL.log").write_text(LOCKED)
    with pytest.raises(UserError, match=r"holds 2 files \*_DVL\.log \(_1_DVL\.log, _2_DVL\.log\)"):
        read_stpere(tmp_path)
