"""XTF logs as they are written: read back by the project's own reader and by pyxtf."""

from pathlib import Path

import numpy as np
import pytest
import pyxtf

from ssjs_cli.formats.xtf_writer import KNOT_M_S, SideScanPings, write_xtf
from ssjs_cli.sonar.log_blocks import open_log

# Ten seconds before the leap day.
START_S = 1582934390.0 + 0.0037
INTERVAL_S = 0.143
COUNT, SAMPLES = 120, 48


def some_pings(first: int = 0, count: int = COUNT) -> SideScanPings:
    rng = np.random.default_rng(7)
    numbers = np.arange(first, first + count)
    port, starboard = rng.integers(0, 65536, (2, COUNT, SAMPLES)).astype(np.float32)[:, first : first + count]
    along = numbers / COUNT
    navigation = np.column_stack([0.1 * along, -0.05 * along, 6.0 * along + 0.1, 1.5 + along, 12.0 + along, 4.0 - along])
    position = np.column_stack([500_000.0 + numbers, 6_000_000.0 - 0.5 * numbers])
    return SideScanPings(first, START_S + INTERVAL_S * numbers, navigation, position, port, starboard, 1490.0, 900e3, 5e-5)


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("log") / "some.xtf"
    assert write_xtf(path, [some_pings(0, 50), some_pings(50, COUNT - 50)], sonar="test sonar") == COUNT
    return path


def test_the_reader_gets_back_what_was_written(log: Path) -> None:
    written, reader = some_pings(), open_log(log)
    block = reader.read(COUNT + 1)
    assert block is not None
    pings = block["pings"]
    assert len(pings["time_s"]) == COUNT and reader.read(1) is None
    info = reader.info()
    assert info["problems"] == [] and info["bytes_skipped"] == 0 and info["sonar"] == "test sonar"
    names = ("roll_rad", "pitch_rad", "heading_rad", "speed_m_s", "depth_m", "altitude_m")
    np.testing.assert_allclose(np.column_stack([pings[name] for name in names]), written.navigation, rtol=1e-6, atol=1e-7)
    np.testing.assert_array_equal(np.column_stack([pings["east_m"], pings["north_m"]]), written.position_m)
    np.testing.assert_array_equal(pings["number"], np.arange(COUNT))


def test_times_are_known_to_a_millisecond(log: Path) -> None:
    block = open_log(log).read(COUNT)
    assert block is not None
    error_s = np.abs(block["pings"]["time_s"] - some_pings().time_s)
    assert error_s.max() < 0.01
    assert error_s[20:].max() < 0.0011
    assert np.abs(block["pings"]["position_time_s"] - some_pings().time_s)[20:].max() < 0.0011


def test_pyxtf_gets_the_same(log: Path) -> None:
    written = some_pings()
    header, packets = pyxtf.xtf_read(str(log))
    assert header.NavUnits == 0 and header.NumberOfSonarChannels == 2
    assert [header.ChanInfo[index].TypeOfChannel for index in (0, 1)] == [1, 2]
    assert header.ChanInfo[0].Frequency == 900.0
    sonar = packets[pyxtf.XTFHeaderType.sonar]
    assert len(sonar) == COUNT
    for index in (0, 7, COUNT - 1):
        ping = sonar[index]
        second_of_day = 3600 * ping.Hour + 60 * ping.Minute + ping.Second + 0.01 * ping.HSeconds
        assert 0.0 <= written.time_s[index] % 86400.0 - second_of_day < 0.0101
        np.testing.assert_array_equal(ping.data[0], written.port[index, ::-1])
        np.testing.assert_array_equal(ping.data[1], written.starboard[index])
        assert ping.SensorSpeed * KNOT_M_S == pytest.approx(written.navigation[index, 3])
        assert ping.SoundVelocity == 1490.0
        assert ping.ping_chan_headers[0].SlantRange == pytest.approx(0.5 * 1490.0 * 5e-5 * SAMPLES)
    last = sonar[-1]
    assert (last.Year, last.Month, last.Day, last.Hour, last.Minute) == (2020, 2, 29, 0, 0)
    assert sonar[0].JulianDay == 59 and last.JulianDay == 60


def test_echoes_too_strong_are_clipped_not_wrapped(tmp_path: Path) -> None:
    pings = some_pings(0, 1)
    pings.port[0, 0], pings.starboard[0, 0] = 70_000.0, -3.0
    write_xtf(tmp_path / "strong.xtf", [pings], sonar="test")
    sonar = pyxtf.xtf_read(str(tmp_path / "strong.xtf"))[1][pyxtf.XTFHeaderType.sonar]
    assert sonar[0].data[0][-1] == 65535 and sonar[0].data[1][0] == 0
