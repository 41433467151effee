import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ssjs_cli.errors import UserError
from ssjs_cli.formats.tum import PoseSeries, read_tum, wrapped_angle, write_tum

# The file keeps nine decimals of a metre and twelve of a quaternion.
POSITION_TOLERANCE_M = 0.6e-9
HEADING_TOLERANCE_RAD = 1e-11

POSES = st.lists(
    st.tuples(st.floats(0.0, 2e9), st.floats(-1e5, 1e5), st.floats(-1e5, 1e5), st.floats(-math.pi, math.pi, exclude_max=True)),
    min_size=1,
    max_size=30,
)


def angle_between(a: float, b: float) -> float:
    return abs(math.remainder(a - b, 2.0 * math.pi))


@given(rows=POSES)
def test_poses_read_back(rows: list[tuple[float, float, float, float]], tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.mktemp("tum") / "a.tum"
    time_s = np.sort(np.array([row[0] for row in rows]))
    pose = np.array([row[1:] for row in rows])
    write_tum(path, PoseSeries(time_s, pose))
    again = read_tum(path)
    assert np.array_equal(again.time_s, time_s)
    assert np.abs(again.pose[:, :2] - pose[:, :2]).max() <= POSITION_TOLERANCE_M + 1e-15 * np.abs(pose).max()
    for read, written in zip(again.pose[:, 2], pose[:, 2], strict=True):
        assert angle_between(read, written) <= HEADING_TOLERANCE_RAD
        assert -math.pi <= read < math.pi


def test_a_quarter_turn_is_the_quaternion_of_45_degrees(tmp_path: Path) -> None:
    path = tmp_path / "a.tum"
    write_tum(path, PoseSeries(np.array([1.5]), np.array([[1.0, -2.0, math.pi / 2]])))
    # sin 45 deg = cos 45 deg = 0.707106781187
    assert path.read_text() == "1.5 1.000000000 -2.000000000 0 0 0 0.707106781187 0.707106781187\n"


def test_roll_and_pitch_do_not_disturb_the_heading(tmp_path: Path) -> None:
    path = tmp_path / "a.tum"
    # Rz(90 deg) Ry(20 deg): qx = -sin 45 sin 10, qy = cos 45 sin 10, qz = sin 45 cos 10, qw = cos 45 cos 10
    s, c, s10, c10 = math.sin(math.pi / 4), math.cos(math.pi / 4), math.sin(math.radians(10)), math.cos(math.radians(10))
    path.write_text(f"0 1 2 3 {-s * s10} {c * s10} {s * c10} {c * c10}\n")
    assert read_tum(path).pose[0] == pytest.approx([1.0, 2.0, math.pi / 2], abs=1e-12)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0 0 0 0 0 0 0 1\n0 0 0 0 0 0 0\n", r"a\.tum:2: has 7 fields where 8 are needed"),
        ("0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0.5 0.5\n", r"a\.tum:2: qx qy qz qw has the length 0\.707107, not 1"),
        ("1 0 0 0 0 0 0 1\n0 0 0 0 0 0 0 1\n", r"a\.tum:2: time_s = 0\.0 goes back from 1\.0"),
        ("0 nan 0 0 0 0 0 1\n", r"a\.tum:1: x_m is empty or NaN"),
        ("# nothing\n", r"a\.tum: holds no pose"),
    ],
)
def test_faults_name_the_line(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "a.tum"
    path.write_text(text)
    with pytest.raises(UserError, match=message):
        read_tum(path)


def test_angles_are_wrapped_into_the_half_open_interval() -> None:
    angles = wrapped_angle(np.array([math.pi, -math.pi, 3.0 * math.pi, 0.5, 7.0]))
    assert angles == pytest.approx([-math.pi, -math.pi, -math.pi, 0.5, 7.0 - 2.0 * math.pi], abs=1e-12)
    assert ((angles >= -math.pi) & (angles < math.pi)).all()
