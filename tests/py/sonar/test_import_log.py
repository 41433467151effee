"""Sonar logs as missions."""

import json
import struct
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jsf_files as jsf
import numpy as np
import pytest
import pyxtf
import xtf_files as xtf

from ssjs_cli.formats.navigation import read_navigation
from ssjs_cli.formats.number_table import read_table


def test_an_xtf_log_becomes_a_mission(cli: Callable[..., Any], tmp_path: Path) -> None:
    nothing = dict.fromkeys(
        ("SensorYcoordinate", "SensorXcoordinate", "SensorHeading", "SensorDepth", "SensorPrimaryAltitude", "SensorSpeed"), 0.0
    )
    log = xtf.write(
        tmp_path / "line 1.xtf", xtf.file_header(), xtf.ping(0, **nothing), *(xtf.ping(n, SensorHeading=350.0) for n in range(1, 6))
    )
    out = tmp_path / "mission"
    answer = cli("import", "xtf", log, "--out", out, "--json")
    document = json.loads(answer.out)
    assert answer.code == 0 and document["pings"] == 6 and document["lost"] == []
    assert (out / "pings" / "line 1.xtf").read_bytes() == log.read_bytes()
    settings = tomllib.loads((out / "mission.toml").read_text())
    # the first ping has no position: the second is the origin
    assert settings["geodetic"] == {
        "origin_latitude_deg": 48.4,
        "origin_longitude_deg": -68.8 + 1e-5,
        "heading_deg": 0.0,
        "y_axis": "right",
    }
    navigation = read_navigation(out)
    assert navigation is not None and navigation.velocity is None
    assert navigation.depth is not None and navigation.altitude is not None
    assert len(navigation.attitude.time_s) == len(navigation.depth.value) == 5
    np.testing.assert_allclose(np.degrees(navigation.attitude.angles_rad), [[0.0, 0.0, -10.0]] * 5, atol=1e-6)
    np.testing.assert_array_equal(navigation.depth.value, [12.0] * 5)
    np.testing.assert_array_equal(navigation.altitude.value, [7.0] * 5)
    names = ("latitude_deg", "speed_m_s")
    table = read_table(
        out / "pings" / "navigation.csv",
        required=("time_s", "ping", *names),
        optional=("position_time_s", "longitude_deg", "heading_rad", "roll_rad", "pitch_rad", "depth_m", "altitude_m"),
        may_be_empty=("position_time_s", *names, "longitude_deg", "heading_rad", "roll_rad", "pitch_rad", "depth_m", "altitude_m"),
    )
    assert table.rows == 6 and np.isnan(table["latitude_deg"][0]) and table["speed_m_s"][1] == pytest.approx(3.0 * 1852.0 / 3600.0)


def test_records_of_sensors_come_before_fields_of_pings(cli: Callable[..., Any], tmp_path: Path) -> None:
    attitude = [xtf.small_packet(pyxtf.XTFAttitudeData, Pitch=1.0, Roll=2.0, Heading=3.0, Millisecond=40 * index) for index in range(20)]
    log = xtf.write(tmp_path / "a.xtf", xtf.file_header(), *attitude, xtf.ping(0), xtf.ping(1))
    assert cli("import", "xtf", log, "--out", tmp_path / "m").code == 0
    navigation = read_navigation(tmp_path / "m")
    assert navigation is not None
    np.testing.assert_allclose(np.degrees(navigation.attitude.angles_rad), [[2.0, 1.0, 3.0]] * 20, rtol=1e-6)


def test_a_jsf_log_with_doppler_velocities(cli: Callable[..., Any], tmp_path: Path) -> None:
    parts = []
    for number in range(4):
        velocity = bytearray(72)
        struct.pack_into("<iI", velocity, 0, jsf.START_S, 100 * number)
        flags = 1 | 1 << 1 | 1 << 5 if number != 2 else 0
        struct.pack_into("<I4i3h", velocity, 12, flags, 1000, 1000, 1000, 1000, 100, 1500, 0)
        parts += [jsf.message(2080, bytes(velocity)), jsf.ping(number)]
    path = tmp_path / "a.jsf"
    path.write_bytes(b"".join(parts))
    assert cli("import", "jsf", path, "--out", tmp_path / "m").code == 0
    navigation = read_navigation(tmp_path / "m")
    assert navigation is not None and navigation.velocity is not None and navigation.altitude is not None
    assert navigation.velocity.bottom_lock.tolist() == [True, True, False, True]
    np.testing.assert_allclose(navigation.velocity.velocity_m_s[0], [1.5, 0.1, 0.0])
    np.testing.assert_array_equal(navigation.altitude.value, [10.0] * 3)


def test_times_that_go_back_are_dropped_and_counted(cli: Callable[..., Any], tmp_path: Path) -> None:
    log = xtf.write(tmp_path / "a.xtf", xtf.file_header(), xtf.ping(0), xtf.ping(5), xtf.ping(2), xtf.ping(6))
    answer = cli("import", "xtf", log, "--out", tmp_path / "m", "--json")
    assert answer.code == 3 and any("1 rows" in text for text in json.loads(answer.out)["lost"])
    navigation = read_navigation(tmp_path / "m")
    assert navigation is not None and len(navigation.attitude.time_s) == 3


def test_the_other_format_is_refused(cli: Callable[..., Any], tmp_path: Path) -> None:
    path = tmp_path / "a.xtf"
    path.write_bytes(jsf.ping(0))
    answer = cli("import", "xtf", path, "--out", tmp_path / "m")
    assert answer.code == 2 and "import jsf" in answer.err and not (tmp_path / "m").exists()


def test_a_mission_is_replaced_only_with_force(cli: Callable[..., Any], tmp_path: Path) -> None:
    log = xtf.write(tmp_path / "a.xtf", xtf.file_header(), xtf.ping(0), xtf.ping(1))
    out = tmp_path / "m"
    assert cli("import", "xtf", log, "--out", out).code == 0
    first = {path.name: path.read_bytes() for path in out.rglob("*") if path.is_file()}
    assert cli("import", "xtf", log, "--out", out).code == 2
    assert cli("import", "xtf", log, "--out", out, "--force").code == 0
    assert {path.name: path.read_bytes() for path in out.rglob("*") if path.is_file()} == first
    (out / "mine.txt").write_text("mine")
    assert cli("import", "xtf", log, "--out", out, "--force").code == 2
