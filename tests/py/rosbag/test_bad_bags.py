"""Recordings that are cut, are none, or leave the choice open."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from bag_files import MCAP, ROS1, SECOND_NS, SQLITE, START_NS, Messages, dive, write_bag

from ssjs_cli.formats.mission import read_mission
from ssjs_cli.rosbag.records import BagMessage, BrokenBagError
from ssjs_cli.rosbag.ros1_records import ros1_records


def whole_file(folder: Path, kind: str) -> Path:
    path = write_bag(folder / ("dive.bag" if kind == ROS1 else "dive"), kind, dive(kind))
    if kind == ROS1:
        return path
    return next(file for file in path.iterdir() if file.suffix in (".mcap", ".db3"))


def refused(cli: Callable[..., Any], source: Path, out: Path, *arguments: str) -> str:
    answer = cli("import", "rosbag", source, "--out", out, *arguments)
    assert answer.code == 2, answer.err
    assert "internal fault" not in answer.err
    assert not out.exists()
    text: str = answer.err
    return text


@pytest.mark.parametrize("fraction", [0.3, 0.6, 0.95, 0.999])
def test_a_cut_bag_of_ros_1_keeps_what_came_before(fraction: float, cli: Callable[..., Any], tmp_path: Path) -> None:
    path = whole_file(tmp_path, ROS1)
    data = path.read_bytes()
    path.write_bytes(data[: int(fraction * len(data))])
    answer = cli("import", "rosbag", path, "--out", tmp_path / "mission", "--json")
    assert answer.code == 3, answer.err
    (lost,) = json.loads(answer.out)["lost"]
    assert "dive.bag" in lost and "were kept" in lost
    kept = len(read_mission(tmp_path / "mission").time_s)
    if fraction < 0.9:  # the index stands at the end
        assert 0.8 * fraction * 200 < kept < 200
    else:
        assert kept == 200


def test_the_messages_of_a_cut_bag_are_those_of_the_whole_one(tmp_path: Path) -> None:
    path = whole_file(tmp_path, ROS1)
    whole = [record for record in ros1_records(path) if isinstance(record, BagMessage)]
    assert len(whole) == 200 + 100 + 100 + 200 + 20 + 20
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])
    before = []
    with pytest.raises(BrokenBagError):
        for record in ros1_records(path):
            if isinstance(record, BagMessage):
                before.append(record)
    assert 100 < len(before) < len(whole)
    assert before == whole[: len(before)]


def test_a_cut_mcap_keeps_its_whole_chunks(cli: Callable[..., Any], tmp_path: Path) -> None:
    path = whole_file(tmp_path, MCAP)
    data = path.read_bytes()
    path.write_bytes(data[:-60])  # the footer
    answer = cli("import", "rosbag", path, "--out", tmp_path / "mission")
    assert answer.code == 3 and "were kept" in answer.err, answer.err
    assert len(read_mission(tmp_path / "mission").time_s) == 200


@pytest.mark.parametrize("kind", [ROS1, MCAP, SQLITE])
@pytest.mark.parametrize("content", [b"", b"text\n" * 100, b"#ROSBAG V2.0\n", b"\x89MCAP0\r\n", b"SQLite format 3\0" + bytes(200)])
def test_a_file_that_is_no_bag(kind: str, content: bytes, cli: Callable[..., Any], tmp_path: Path) -> None:
    path = tmp_path / {ROS1: "a.bag", MCAP: "a.mcap", SQLITE: "a.db3"}[kind]
    path.write_bytes(content)
    assert path.name in refused(cli, path, tmp_path / "mission")


@pytest.mark.parametrize("kind", [ROS1, MCAP, SQLITE])
def test_damaged_bags_never_end_in_a_fault(kind: str, cli: Callable[..., Any], tmp_path: Path) -> None:
    import numpy as np

    path = whole_file(tmp_path, kind)
    data = path.read_bytes()
    rng = np.random.default_rng(5)
    for number in range(15):
        spoiled = bytearray(data[: int(rng.integers(len(data)))] if number % 3 == 0 else data)
        for _ in range(int(rng.integers(1, 30))):
            spoiled[int(rng.integers(len(spoiled)))] = int(rng.integers(256))
        file = tmp_path / f"{number}{path.suffix}"
        file.write_bytes(bytes(spoiled))
        answer = cli("import", "rosbag", file, "--out", tmp_path / str(number))
        assert answer.code in (0, 2, 3), answer.err
        assert (tmp_path / str(number)).exists() == (answer.code != 2)
        assert not list(tmp_path.glob("*fault*"))


def test_sources_that_are_not_there(cli: Callable[..., Any], tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "a.txt").write_text("x")
    assert "is missing; check the path" in refused(cli, tmp_path / "none.bag", tmp_path / "mission")
    assert "metadata.yaml" in refused(cli, tmp_path / "folder", tmp_path / "mission")
    assert "a.txt: is no bag by its name" in refused(cli, tmp_path / "a.txt", tmp_path / "mission")


def test_two_topics_of_one_kind_are_the_users_choice(cli: Callable[..., Any], tmp_path: Path) -> None:
    make = Messages(MCAP)
    messages: list[Any] = []
    for step in range(30):
        time_ns = START_NS + step * SECOND_NS // 10
        for topic, yaw in (("/a/imu", 0.5), ("/b/imu", 1.0)):
            messages.append((topic, "sensor_msgs/msg/Imu", time_ns, make.imu(time_ns, (0.0, 0.0, yaw), (0.0, 0.0, 0.0))))
    source = write_bag(tmp_path / "dive", MCAP, messages)
    said = refused(cli, source, tmp_path / "mission")
    assert "2 topics could be the imu: /a/imu, /b/imu; choose with --topic imu=/a/imu" in said
    assert cli("import", "rosbag", source, "--out", tmp_path / "mission", "--topic", "imu=/b/imu").code == 0
    navigation = read_mission(tmp_path / "mission").navigation
    assert navigation is not None and navigation.attitude.angles_rad[0, 2] == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("topic", "said"),
    [
        ("imu=/imu/dat", "there is no such topic (did you mean '/imu/data'?)"),
        ("imu=/pressure", "is sensor_msgs/msg/FluidPressure; imu can be read from sensor_msgs/msg/Imu"),
        ("imu=none", "holds no attitude"),
        ("compass=/x", "ROLE one of imu, velocity, depth, altitude, fix"),
        ("imu", "must be ROLE=TOPIC"),
    ],
)
def test_topics_that_cannot_be_chosen(topic: str, said: str, cli: Callable[..., Any], tmp_path: Path) -> None:
    source = write_bag(tmp_path / "dive", MCAP, dive(MCAP, seconds=2))
    assert said in refused(cli, source, tmp_path / "mission", "--topic", topic)


def test_a_role_can_be_left_out(cli: Callable[..., Any], tmp_path: Path) -> None:
    source = write_bag(tmp_path / "dive", MCAP, dive(MCAP, seconds=2))
    assert cli("import", "rosbag", source, "--out", tmp_path / "mission", "--topic", "fix=none", "--topic", "depth=none").code == 0
    mission = read_mission(tmp_path / "mission")
    assert mission.geodetic is None and mission.navigation is not None and mission.navigation.depth is None


def test_without_the_package_the_extra_is_named(cli: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    source = write_bag(tmp_path / "dive", MCAP, dive(MCAP, seconds=2))
    monkeypatch.setitem(sys.modules, "rosbags.highlevel", None)
    assert "pip install 'ssjs[rosbag]'" in refused(cli, source, tmp_path / "mission")
