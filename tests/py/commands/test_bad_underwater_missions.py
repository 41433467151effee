"""Bad input of an underwater mission: exit code 2, the file, the line and the mend in the message, nothing left behind."""

import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from bad_missions import KEPT_S, TIMED_FILES, Spoil, all_of, column, directory_instead, run_spoiled, shorten, written

from ssjs_cli import _core
from ssjs_cli.formats.number_table import MAX_LINE_BYTES
from ssjs_cli.underwater_clock import MAX_SILENCE_S

RIGHT_ANGLE = "1.5707963267948966"
PLANAR_ODOMETRY = "time_s,speed_m_s,turn_rate_rad_s\n" + "".join(f"{step / 10},1,0\n" for step in range(600))


@pytest.fixture(scope="module")
def base(tmp_path_factory: pytest.TempPathFactory) -> Path:
    from ssjs_cli.app import call

    directory = tmp_path_factory.mktemp("base") / "mission"
    assert call(["simulate", "auv-survey", "--out", str(directory)]) == 0
    shorten(directory)
    return directory


def scaled(factor: float, offset: float = 0.0) -> Callable[[str], str]:
    return lambda text: repr(float(text) * factor + offset)


def in_every_file(change: Callable[[str], str]) -> Spoil:
    return all_of(*(column(name, "time_s", change) for name in TIMED_FILES))


def constant(text: str) -> Callable[[str], str]:
    return lambda _: text


def huge_line(mission: Path) -> None:
    """Two gigabytes without a line end, of which the disk holds nothing."""
    with (mission / "depth.csv").open("wb") as file:
        file.write(b"time_s,depth_m\n0,")
        file.truncate(2 * 1024**3)


def odometry_too(mission: Path) -> None:
    (mission / "odometry.csv").write_text(PLANAR_ODOMETRY)


VALUES = [
    ("depth.csv", "depth_m", "1e300", "positive down"),
    ("depth.csv", "depth_m", "-50", "positive down"),
    ("altitude.csv", "altitude_m", "-5", "altimeter"),
    ("altitude.csv", "altitude_m", "1e200", "altimeter"),
    ("dvl.csv", "vx_m_s", "1e200", "m/s"),
    ("dvl.csv", "vz_m_s", "-1500", "mm/s"),
    ("imu.csv", "yaw_rad", "1e200", "degrees"),
    ("imu.csv", "yaw_rad", "271.5", "degrees"),
    ("imu.csv", "roll_rad", "-30", "degrees"),
    ("imu.csv", "pitch_rad", RIGHT_ANGLE, "the same turn"),
    ("imu.csv", "pitch_rad", "-" + RIGHT_ANGLE, "the same turn"),
    ("imu.csv", "turn_rate_z_rad_s", "1e200", "rad/s"),
    ("imu.csv", "turn_rate_x_rad_s", "-90", "rad/s"),
    ("observations.csv", "x_m", "1e200", "body frame"),
    ("observations.csv", "z_m", "-1e9", "body frame"),
    *((name, "time_s", "1e17", "nanoseconds") for name in TIMED_FILES),
]


@pytest.mark.parametrize(("name", "heading", "value", "mend"), VALUES)
def test_a_value_that_no_sensor_gives_is_named_with_its_line(
    base: Path, cli: Callable[..., Any], tmp_path: Path, name: str, heading: str, value: str, mend: str
) -> None:
    answer = run_spoiled(cli, base, tmp_path, column(name, heading, constant(value), slice(-1, None)))
    assert answer.code == 2
    last_line = len((base / name).read_text().splitlines())
    assert f"{name}:{last_line}: {heading} = {float(value)!r} must lie between" in answer.err
    assert mend in answer.err


def test_a_velocity_without_bottom_lock_may_be_anything(base: Path, cli: Callable[..., Any], tmp_path: Path) -> None:
    spoil = all_of(
        column("dvl.csv", "vx_m_s", constant("-32768"), slice(3, 4)), column("dvl.csv", "bottom_lock", constant("0"), slice(3, 4))
    )
    assert run_spoiled(cli, base, tmp_path, spoil).code == 0


CLOCKS = [
    ("every record at one time", in_every_file(constant("5.0")), r"imu\.csv: all 600 lines have the time 5\.0; give each"),
    ("a stuck clock of one sensor", column("depth.csv", "time_s", constant("5.0")), r"depth\.csv: all 600 lines have the time 5\.0"),
    ("one moment", written("imu.csv", "time_s,roll_rad,pitch_rad,yaw_rad\n0,0,0,0\n"), r"imu\.csv: holds one moment alone"),
    ("nanoseconds since 1970", in_every_file(scaled(1e9, 1.767e18)), r"imu\.csv:2: time_s = 1\.767e\+18 .* convert milliseconds"),
    ("milliseconds since 1970", in_every_file(scaled(1e3, 1.767e12)), r"imu\.csv:2: time_s = .* convert milliseconds"),
    ("milliseconds since the start", in_every_file(scaled(1e6)), r"imu\.csv: its lines are 100000 s apart .* convert milliseconds"),
    ("attitude in milliseconds", column("imu.csv", "time_s", scaled(1e3)), r"imu\.csv: its lines are 100 s apart"),
    ("a DVL on another clock", column("dvl.csv", "time_s", scaled(1.0, 1e6)), r"dvl\.csv: its times, .* have nothing in common"),
    ("depth before the attitude", column("depth.csv", "time_s", scaled(1.0, -1e6)), r"depth\.csv: its times, .* have nothing in common"),
    ("sightings of another day", column("observations.csv", "time_s", scaled(1.0, 86400.0)), r"observations\.csv: its times"),
    ("times that go back", column("imu.csv", "time_s", constant("3.0"), slice(200, 201)), r"imu\.csv:202: time_s = 3\.0 goes back"),
    ("a silence", column("imu.csv", "time_s", constant("86400.0"), slice(-1, None)), r"imu\.csv:601: time_s = 86400\.0 comes .* split"),
]


@pytest.mark.parametrize(("spoil", "said"), [case[1:] for case in CLOCKS], ids=[case[0] for case in CLOCKS])
def test_clocks_that_cannot_be_are_named(base: Path, cli: Callable[..., Any], tmp_path: Path, spoil: Spoil, said: str) -> None:
    answer = run_spoiled(cli, base, tmp_path, spoil)
    assert answer.code == 2
    assert re.search(said, answer.err), answer.err


@pytest.mark.parametrize("beyond_s", [-1.0, 1.0, 1e6])
def test_the_estimator_outlasts_any_silence_and_says_what_it_does_not_know(beyond_s: float) -> None:
    from ssjs_cli.config import UNDERWATER, levelled_values, resolve

    log = _core.NavigationLog()
    log.add_attitude([0.0, 1.0, 1.0 + MAX_SILENCE_S + beyond_s], [[0.0, 0.0, 0.0]] * 3)
    settings = levelled_values(resolve([], UNDERWATER).values)
    covariance = _core.run_levelled({**settings, "motion.drive": "rates"}, log)["covariance"]
    reach_m = 3.5 * (MAX_SILENCE_S + beyond_s)  # 1.5 m/s, and twice the sigma of 1 m/s
    assert covariance[-1, 0] >= 0.9 * (0.5 * reach_m) ** 2


TABLES = [
    ("NaN", column("depth.csv", "depth_m", constant("nan"), slice(5, 6)), r"depth\.csv:7: depth_m is empty or NaN"),
    ("infinity", column("imu.csv", "yaw_rad", constant("-inf"), slice(5, 6)), r"imu\.csv:7: yaw_rad is infinite"),
    ("an empty field", column("altitude.csv", "altitude_m", constant(""), slice(5, 6)), r"altitude\.csv:7: altitude_m is empty"),
    ("an empty file", written("depth.csv", ""), r"depth\.csv:1: is empty; it needs a header line"),
    ("blank lines", written("depth.csv", "\n\n \n"), r"depth\.csv:1: is empty"),
    ("a header alone", written("depth.csv", "time_s,depth_m\n"), r"depth\.csv: holds no line after the header"),
    ("no attitude", written("imu.csv", "time_s,roll_rad,pitch_rad,yaw_rad\n"), r"imu\.csv: holds no line after the header"),
    ("no UTF-8", written("depth.csv", b"time_s,depth_m\n0,1\n\xff\xfe,2\n"), r"depth\.csv:3: is not text"),
    ("UTF-16", written("depth.csv", "time_s,depth_m\n0,1\n".encode("utf-16")), r"depth\.csv:1: is not text"),
    ("zeros", written("depth.csv", b"time_s,depth_m\n0,1\n\0\0\0\n"), r"depth\.csv:3: has 1 fields"),
    ("a column twice", written("depth.csv", "time_s,depth_m,depth_m\n0,1,1\n"), r"depth\.csv:1: column 'depth_m' appears twice"),
    (
        "an unknown column",
        written("depth.csv", "time_s,deepth_m\n0,1\n"),
        r"depth\.csv:1: unknown column 'deepth_m' \(did you mean 'depth_m'",
    ),
    ("semicolons", written("depth.csv", "time_s;depth_m\n0;1\n"), r"depth\.csv:1: unknown column"),
    ("decimal commas", written("depth.csv", "time_s,depth_m\n0,1,5\n"), r"depth\.csv:2: has 3 fields"),
    ("hexadecimal", written("depth.csv", "time_s,depth_m\n0,0x10\n"), r"depth\.csv:2: depth_m = '0x10' is not a number"),
    ("underscores", written("depth.csv", "time_s,depth_m\n0,1\n1,1_0\n"), r"depth\.csv:3: depth_m = '1_0' is not a number"),
    ("digits of another script", written("depth.csv", "time_s,depth_m\n0,\u0661\n"), r"depth\.csv:2: depth_m = .* is not a number"),
    ("an endless line", huge_line, rf"depth\.csv:2: is longer than {MAX_LINE_BYTES} bytes"),
    ("an endless header", written("depth.csv", b"time_s,depth_m" + b"," * 3_000_000), r"depth\.csv:1: is longer than"),
    ("an endless number", written("depth.csv", b"time_s,depth_m\n0," + b"1" * 30_000_000), r"depth\.csv:2: is longer than"),
    ("two bottoms", column("dvl.csv", "bottom_lock", constant("2"), slice(1, 2)), r"dvl\.csv:3: bottom_lock = 2\.0 must be 1"),
    (
        "a huge identity",
        column("observations.csv", "landmark_id", constant("1e300"), slice(0, 1)),
        r"observations\.csv:2: landmark_id = 1e\+300",
    ),
    *((f"{name} a directory", directory_instead(name), rf"{name}: is a directory where a file is wanted; remove") for name in TIMED_FILES),
    ("truth a directory", directory_instead("truth_trajectory.tum"), r"truth_trajectory\.tum: is a directory where a file is wanted"),
    ("mission.toml a directory", directory_instead("mission.toml"), r"mission\.toml: is a directory where a file is wanted"),
    ("a link to nothing", lambda mission: (mission / "odometry.csv").symlink_to("nowhere"), r"odometry\.csv: is a link to nothing"),
    ("pings a file", written("pings", "x"), r"pings: is no folder"),
    ("two kinds of vehicle", odometry_too, r"observations\.csv:1: has the column z_m .* remove odometry\.csv"),
    ("an endless mission.toml", lambda mission: os.truncate(mission / "mission.toml", 2 * 1024**3), r"mission\.toml: holds more than"),
]


@pytest.mark.parametrize(("spoil", "said"), [case[1:] for case in TABLES], ids=[case[0] for case in TABLES])
def test_files_that_are_no_tables_are_named(base: Path, cli: Callable[..., Any], tmp_path: Path, spoil: Spoil, said: str) -> None:
    answer = run_spoiled(cli, base, tmp_path, spoil)
    assert answer.code == 2
    assert re.search(said, answer.err), answer.err


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes here")
def test_a_pipe_is_not_waited_for(base: Path, cli: Callable[..., Any], tmp_path: Path) -> None:
    def spoil(mission: Path) -> None:
        (mission / "depth.csv").unlink()
        os.mkfifo(mission / "depth.csv")

    answer = run_spoiled(cli, base, tmp_path, spoil)
    assert answer.code == 2 and "depth.csv: is no regular file" in answer.err


def test_a_vehicle_in_the_plane_may_hold_attitude_too(base: Path, cli: Callable[..., Any], tmp_path: Path) -> None:
    answer = run_spoiled(cli, base, tmp_path, all_of(odometry_too, lambda mission: (mission / "observations.csv").unlink()))
    assert answer.code == 0 and "dead reckoning" in answer.err


def test_a_mission_that_was_not_spoiled_is_run(base: Path, cli: Callable[..., Any], tmp_path: Path) -> None:
    assert run_spoiled(cli, base, tmp_path, lambda mission: None).code == 0
    assert float((base / "imu.csv").read_text().splitlines()[-1].split(",")[0]) < KEPT_S


@pytest.mark.parametrize("arguments", [(), ("--of", "underwater")])
def test_config_check_takes_underwater_missions(base: Path, cli: Callable[..., Any], arguments: tuple[str, ...]) -> None:
    for path in (base, base / "mission.toml"):
        answer = cli("config", "check", path, *arguments)
        assert answer.code == 0 and "valid" in answer.out, answer.err


def test_config_check_knows_the_keys_of_underwater_missions(base: Path, cli: Callable[..., Any], tmp_path: Path) -> None:
    for name in ("imu.csv", "mission.toml"):
        (tmp_path / name).write_text((base / name).read_text())
    text = (tmp_path / "mission.toml").read_text()
    (tmp_path / "mission.toml").write_text(text.replace("[settings]", "[settings.motion]\ncompass_walk = 1.0\n[settings.x]", 1))
    answer = cli("config", "check", tmp_path)
    assert answer.code == 2 and "compass_walk" in answer.err and "did you mean" in answer.err


def test_config_check_of_the_wrong_kind_names_the_right_one(base: Path, circle_mission: Path, cli: Callable[..., Any]) -> None:
    answer = cli("config", "check", base, "--of", "run")
    assert answer.code == 2 and "under water; give --of underwater" in answer.err
    answer = cli("config", "check", circle_mission, "--of", "underwater")
    assert answer.code == 2 and "in the plane; give --of run" in answer.err
