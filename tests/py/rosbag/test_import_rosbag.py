"""Recordings as missions: axes, times, topics."""

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bag_files import FORMATS, MCAP, ROS1, SECOND_NS, SQLITE, START_NS, Messages, angles_at, dive, write_bag

from ssjs_cli.formats.mission import Mission, read_mission

START_S = START_NS / SECOND_NS


def bag_path(folder: Path, kind: str) -> Path:
    return folder / ("dive.bag" if kind == ROS1 else "dive")


def imported(cli: Callable[..., Any], source: Path, out: Path, *arguments: str, code: int = 0) -> tuple[Mission, dict[str, Any]]:
    answer = cli("import", "rosbag", source, "--out", out, "--json", *arguments)
    assert answer.code == code, answer.err
    return read_mission(out), json.loads(answer.out)


@pytest.mark.parametrize("kind", FORMATS)
def test_every_format_gives_the_motion_in_the_axes_of_the_sea(kind: str, cli: Callable[..., Any], tmp_path: Path) -> None:
    source = write_bag(bag_path(tmp_path, kind), kind, dive(kind))
    mission, document = imported(cli, source, tmp_path / "mission")
    navigation = mission.navigation
    assert navigation is not None and mission.odometry is None
    steps = np.arange(200)
    # the header's times, not the recorder's
    assert navigation.attitude.time_s == pytest.approx(START_S + steps / 10, abs=1e-6)
    assert navigation.attitude.angles_rad == pytest.approx(np.array([angles_at(step) for step in steps]), abs=1e-12)
    assert navigation.attitude.turn_rate_rad_s == pytest.approx(np.tile([0.001, -0.002, 0.02], (200, 1)))
    assert navigation.velocity is not None and navigation.velocity.bottom_lock.all()
    assert navigation.velocity.velocity_m_s == pytest.approx(np.tile([1.5, 0.1, -0.05], (100, 1)), abs=1.1e-3)
    assert navigation.depth is not None and navigation.depth.value == pytest.approx(np.full(200, 7.0))
    # ten of a hundred altimeter messages are beyond their range
    assert navigation.altitude is not None and len(navigation.altitude.value) == 90 and (navigation.altitude.value == 9.0).all()
    counts = document["counts"]
    assert counts["altitude without an answer"] == 10 and counts["fix without an answer"] == 1
    assert counts["not used: /log (std_msgs/msg/String)"] == 20
    assert document["lost"] == []


def test_fixes_are_the_origin_and_the_reference(cli: Callable[..., Any], tmp_path: Path) -> None:
    source = write_bag(tmp_path / "dive", MCAP, dive(MCAP))
    mission, _ = imported(cli, source, tmp_path / "mission")
    assert mission.geodetic is not None and mission.geodetic.origin_longitude_deg == 3.03
    assert mission.geodetic.origin_latitude_deg == pytest.approx(41.78 + 1.5 / 111_000.0)
    fixes = mission.reference.fixes
    assert fixes is not None and len(fixes.time_s) == 19
    # from the second fix on, 1.5 m north each second; the 111 km a degree of the writer are 111.07 here
    assert fixes.position_m[:, 0] == pytest.approx(1.5 * np.arange(19), rel=1e-3)
    assert np.abs(fixes.position_m[:, 1]).max() < 0.01
    assert fixes.sigma_m == pytest.approx(np.full(19, 3.0))


def test_a_recording_is_run_and_judged(cli: Callable[..., Any], tmp_path: Path) -> None:
    source = write_bag(tmp_path / "dive.bag", ROS1, dive(ROS1))
    imported(cli, source, tmp_path / "mission")
    assert cli("run", tmp_path / "mission", "--out", tmp_path / "run", "--no-report").code == 0
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert summary["reference_compared"] > 10 and summary["sensors"]["velocity_log"]["refused"] == 0


def test_the_same_recording_gives_the_same_bytes(cli: Callable[..., Any], tmp_path: Path) -> None:
    source = write_bag(tmp_path / "dive", SQLITE, dive(SQLITE))
    for name in ("a", "b"):
        imported(cli, source, tmp_path / name)
    names = sorted(path.name for path in (tmp_path / "a").iterdir())
    assert "imu.csv" in names and "reference_fixes.csv" in names
    assert all((tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes() for name in names)


def test_one_file_of_a_ros_2_recording_is_enough(cli: Callable[..., Any], tmp_path: Path) -> None:
    for kind in (MCAP, SQLITE):
        folder = write_bag(tmp_path / kind, kind, dive(kind, seconds=3))
        (folder / "metadata.yaml").unlink()
        (file,) = folder.iterdir()
        for number, source in enumerate((folder, file)):
            mission, _ = imported(cli, source, tmp_path / f"{kind} {number}")
            assert len(mission.time_s) == 30


@pytest.mark.parametrize(
    ("flu_in_enu", "roll_pitch_yaw"),
    [
        # x y z w of ROS: the identity looks east with its left to the north
        ((0.0, 0.0, 0.0, 1.0), (0.0, 0.0, math.pi / 2)),
        # turned by 90 degrees anticlockwise it looks north
        ((0.0, 0.0, math.sin(math.pi / 4), math.cos(math.pi / 4)), (0.0, 0.0, 0.0)),
        # rolled about the forward axis: left side up is starboard down
        ((math.sin(0.1), 0.0, 0.0, math.cos(0.1)), (0.2, 0.0, math.pi / 2)),
        # pitched about the left axis: bow down in ROS
        ((0.0, math.sin(0.1), 0.0, math.cos(0.1)), (0.0, -0.2, math.pi / 2)),
    ],
)
def test_quaternions_by_hand(flu_in_enu: tuple[float, ...], roll_pitch_yaw: tuple[float, ...]) -> None:
    from ssjs_cli.rosbag.marine_frames import marine_attitude

    assert marine_attitude(np.array([flu_in_enu]), is_marine=False)[0].tolist() == pytest.approx(list(roll_pitch_yaw), abs=1e-12)


def test_marine_axes_stay_as_they_are(cli: Callable[..., Any], tmp_path: Path) -> None:
    source = write_bag(tmp_path / "dive", MCAP, dive(MCAP, seconds=3))
    mission, _ = imported(cli, source, tmp_path / "mission", "--axes", "marine")
    assert mission.navigation is not None and mission.navigation.velocity is not None
    # what was written as forward, left, up is taken as forward, starboard, down
    assert mission.navigation.velocity.velocity_m_s[0].tolist() == pytest.approx([1.5, -0.1, 0.05])


def only_imu(make: Messages, count: int = 30, **more: Any) -> list[Any]:
    times_ns = [START_NS + step * SECOND_NS // 10 for step in range(count)]
    return [("/imu", "sensor_msgs/msg/Imu", time_ns, make.imu(time_ns, (0, 0, 0), (0, 0, 0), **more)) for time_ns in times_ns]


def test_depth_and_altitude_as_bare_numbers_are_found_by_name_and_have_the_recorders_time(cli: Callable[..., Any], tmp_path: Path) -> None:
    make = Messages(MCAP)
    messages = only_imu(make)
    for step in range(30):
        for topic, value in (("/vehicle/depth", 4.0), ("/vehicle/altitude", 6.0), ("/battery", 24.0)):
            messages.append((topic, "std_msgs/msg/Float64", START_NS + step * SECOND_NS // 10, make.number(value)))
    mission, document = imported(cli, write_bag(tmp_path / "dive", MCAP, messages), tmp_path / "mission")
    navigation = mission.navigation
    assert navigation is not None and navigation.depth is not None and navigation.altitude is not None
    assert (navigation.depth.value == 4.0).all() and (navigation.altitude.value == 6.0).all()
    assert document["counts"]["depth with the recorder's time"] == 30
    assert document["counts"]["not used: /battery (std_msgs/msg/Float64)"] == 30
    assert navigation.velocity is None and mission.reference.is_empty and mission.geodetic is None


def test_a_point_of_ros_is_up(cli: Callable[..., Any], tmp_path: Path) -> None:
    make = Messages(ROS1)
    messages = only_imu(make)
    for step in range(30):
        time_ns = START_NS + step * SECOND_NS // 10
        point = make.make("geometry_msgs/msg/Point", x=0.0, y=0.0, z=-3.5)
        stamped = make.make("geometry_msgs/msg/PointStamped", header=make.header(time_ns), point=point)
        messages.append(("/depth_sensor", "geometry_msgs/msg/PointStamped", time_ns, stamped))
    mission, _ = imported(cli, write_bag(tmp_path / "dive.bag", ROS1, messages), tmp_path / "mission")
    assert mission.navigation is not None and mission.navigation.depth is not None
    assert (mission.navigation.depth.value == 3.5).all()


def test_an_orientation_that_is_not_given_is_none(cli: Callable[..., Any], tmp_path: Path) -> None:
    make = Messages(MCAP)
    source = write_bag(tmp_path / "dive", MCAP, only_imu(make, known=False))
    answer = cli("import", "rosbag", source, "--out", tmp_path / "mission")
    assert answer.code == 2 and "/imu holds no attitude that can be used" in answer.err and "--topic imu=" in answer.err


def test_an_imu_without_gyro_gives_attitude_alone(cli: Callable[..., Any], tmp_path: Path) -> None:
    mission, _ = imported(cli, write_bag(tmp_path / "dive", MCAP, only_imu(Messages(MCAP), gyro=False)), tmp_path / "mission")
    assert mission.navigation is not None and mission.navigation.attitude.turn_rate_rad_s is None


def test_a_velocity_that_is_not_finite_has_no_bottom_lock(cli: Callable[..., Any], tmp_path: Path) -> None:
    make = Messages(MCAP)
    messages = only_imu(make)
    for step in range(30):
        time_ns = START_NS + step * SECOND_NS // 10
        velocity = (1.0, 0.0, 0.0) if step % 3 else (math.nan, 0.0, 0.0)
        messages.append(("/dvl", "geometry_msgs/msg/TwistWithCovarianceStamped", time_ns, make.twist(time_ns, velocity)))
    mission, _ = imported(cli, write_bag(tmp_path / "dive", MCAP, messages), tmp_path / "mission")
    assert mission.navigation is not None and mission.navigation.velocity is not None
    assert int((~mission.navigation.velocity.bottom_lock).sum()) == 10


def test_messages_are_put_in_the_order_of_their_stamps(cli: Callable[..., Any], tmp_path: Path) -> None:
    messages = only_imu(Messages(MCAP))
    topic, kind, time_ns, _ = messages[7]
    swapped = [*messages[:7], (topic, kind, time_ns, messages[8][3]), (topic, kind, time_ns + 1, messages[7][3]), *messages[9:]]
    mission, document = imported(cli, write_bag(tmp_path / "dive", MCAP, swapped), tmp_path / "mission")
    assert (np.diff(mission.time_s) > 0.0).all() and document["counts"]["imu put in order of their stamps"] == 1


def test_stpere_comes_back_as_its_own_importer_gives_it(data_set: Callable[[str], Path], cli: Callable[..., Any], tmp_path: Path) -> None:
    """An hour of a real vehicle, written in the axes of ROS."""
    assert cli("import", "stpere", data_set("stpere"), "--out", tmp_path / "direct").code == 0
    direct = read_mission(tmp_path / "direct").navigation
    assert direct is not None and direct.velocity is not None and direct.attitude.turn_rate_rad_s is not None
    make = Messages(MCAP)
    messages: list[Any] = []
    for time_s, angles, rates in zip(
        direct.attitude.time_s[::5].tolist(), direct.attitude.angles_rad[::5], direct.attitude.turn_rate_rad_s[::5], strict=True
    ):
        time_ns = round(time_s * SECOND_NS)
        messages.append(("/ahrs", "sensor_msgs/msg/Imu", time_ns, make.imu(time_ns, angles, rates)))
    for time_s, velocity in zip(direct.velocity.time_s.tolist(), direct.velocity.velocity_m_s, strict=True):
        time_ns = round(time_s * SECOND_NS)
        messages.append(("/dvl", "geometry_msgs/msg/TwistWithCovarianceStamped", time_ns, make.twist(time_ns, velocity)))
    mission, _ = imported(cli, write_bag(tmp_path / "bag", MCAP, messages), tmp_path / "mission")
    assert mission.navigation is not None and mission.navigation.velocity is not None
    back = mission.navigation
    difference = back.attitude.angles_rad - direct.attitude.angles_rad[::5]
    assert np.abs(np.remainder(difference + np.pi, 2.0 * np.pi) - np.pi).max() < 1e-9
    np.testing.assert_array_equal(back.velocity.bottom_lock, direct.velocity.bottom_lock)  # type: ignore[union-attr]
    np.testing.assert_allclose(back.velocity.velocity_m_s, direct.velocity.velocity_m_s, atol=1e-12)  # type: ignore[union-attr]
