"""Every convention of JSF in which readers go wrong, on messages written by hand after the format's description."""

import math
import struct
from pathlib import Path

import jsf_files as jsf
import numpy as np
import pyjsf
import pytest
from read_log import read_log

START_S = float(jsf.START_S)


def write(path: Path, *parts: bytes) -> Path:
    path.write_bytes(b"".join(parts))
    return path


def test_an_undisturbed_log_has_no_problems(tmp_path: Path) -> None:
    log = read_log(write(tmp_path / "a.jsf", *(jsf.ping(number) for number in range(25))))
    assert log.info["format"] == "jsf" and log.info["pings"] == 25 and log.problems == {}
    assert log.pings["number"].tolist() == list(range(25))
    np.testing.assert_allclose(log.pings["time_s"], START_S + 0.1 * np.arange(25), atol=1e-6)


def test_both_sides_are_stored_near_to_far(tmp_path: Path) -> None:
    log = read_log(write(tmp_path / "a.jsf", jsf.ping(0, [50, 60, 70], [50, 60, 70])))
    port, starboard = log.channels[0]
    assert (port["side"], starboard["side"]) == ("port", "starboard")
    assert port["samples"].tolist() == starboard["samples"].tolist() == [50.0, 60.0, 70.0]


def test_fields_and_their_units(tmp_path: Path) -> None:
    log = read_log(write(tmp_path / "a.jsf", jsf.ping(0)))
    expected = {
        "latitude_deg": 48.5,  # 48 degrees and 30 minutes, in ten-thousandths of a minute
        "longitude_deg": -68.0,
        "depth_m": 12.34,
        "altitude_m": 7.65,
        "heading_rad": math.radians(90.0),
        "pitch_rad": math.radians(1820 * 180.0 / 32768.0),
        "roll_rad": math.radians(-910 * 180.0 / 32768.0),
        "speed_m_s": 3.0 * 1852.0 / 3600.0,
        "sound_speed_m_s": 1480.0,
    }
    for name, value in expected.items():
        assert log.pings[name][0] == pytest.approx(value, rel=1e-6), name
    channel = log.channels[0][0]
    assert channel["frequency_hz"] == 120e3 and channel["sample_interval_s"] == pytest.approx(20e-6)


@pytest.mark.parametrize(("units", "metres"), [(1, 1e-3), (3, 0.1), (4, 0.01)])
def test_projected_coordinates(tmp_path: Path, units: int, metres: float) -> None:
    log = read_log(
        write(tmp_path / "a.jsf", jsf.ping(0, units=("<h", 88, units), longitude=("<i", 80, 400_123), latitude=("<i", 84, 5_000_456)))
    )
    assert log.pings["east_m"][0] == pytest.approx(400_123 * metres)
    assert log.pings["north_m"][0] == pytest.approx(5_000_456 * metres)


def test_fields_marked_invalid_are_not_used(tmp_path: Path) -> None:
    only_position = jsf.ping(0, validity=("<H", 30, 1))
    log = read_log(write(tmp_path / "a.jsf", only_position, jsf.ping(1, validity=("<H", 30, 0))))
    for name in ("depth_m", "altitude_m", "heading_rad", "pitch_rad", "speed_m_s"):
        assert np.isnan(log.pings[name][0]), name
        assert np.isfinite(log.pings[name][1]), f"{name}: without any validity bit what is not zero counts"
    assert log.pings["latitude_deg"][0] == 48.5


def test_recording_may_start_late_and_samples_are_weighted(tmp_path: Path) -> None:
    log = read_log(write(tmp_path / "a.jsf", jsf.ping(0, [16, 32], [48, 64], weight=("<h", 168, 4), start=("<I", 4, 100))))
    port, starboard = log.channels[0]
    assert port["samples"].tolist() == [1.0, 2.0] and starboard["samples"].tolist() == [3.0, 4.0]
    assert port["first_sample_s"] == pytest.approx(100 * 20e-6)


def test_envelopes_are_unsigned_and_analytic_signals_have_two_parts(tmp_path: Path) -> None:
    loud = jsf.trace(0, jsf.PORT, [65535, 1])
    analytic = jsf.trace(0, jsf.STARBOARD, [3, -4, -6, 8], stored="<h", data_format=("<h", 34, 1), count=("<H", 114, 2))
    port, starboard = read_log(write(tmp_path / "a.jsf", loud, analytic)).channels[0]
    assert port["samples"].tolist() == [65535.0, 1.0]
    assert starboard["samples"].tolist() == [5.0, 10.0]


def test_more_samples_than_sixteen_bits_count(tmp_path: Path) -> None:
    samples = [7] * 70_000
    high = {"count": ("<H", 114, 70_000 - 65_536), "high_bits": ("<H", 16, 1 << 8)}
    log = read_log(write(tmp_path / "a.jsf", jsf.trace(0, jsf.PORT, samples, **high), jsf.trace(0, jsf.STARBOARD, samples, **high)))
    assert [len(channel["samples"]) for channel in log.channels[0]] == [70_000, 70_000]
    assert log.problems == {}


def test_frequencies_are_pings_of_their_own(tmp_path: Path) -> None:
    low = [jsf.trace(number, side, [1, 2], subsystem=20) for number in (0, 1) for side in (0, 1)]
    high = [jsf.trace(number, side, [3, 4], subsystem=21) for number in (0, 1) for side in (0, 1)]
    interleaved = [part for pair in zip(low, high, strict=True) for part in pair]
    log = read_log(write(tmp_path / "a.jsf", *interleaved))
    assert log.info["pings"] == 4 and log.problems == {}
    assert [[channel["samples"][0] for channel in ping] for ping in log.channels] == [[1, 1], [3, 3], [1, 1], [3, 3]]


def test_a_missing_side_costs_no_other_ping(tmp_path: Path) -> None:
    log = read_log(write(tmp_path / "a.jsf", jsf.ping(0), jsf.trace(1, jsf.PORT, [1]), jsf.ping(2), jsf.trace(3, jsf.STARBOARD, [1])))
    assert log.pings["number"].tolist() == [0, 1, 2, 3]
    assert [len(channels) for channels in log.channels] == [2, 1, 2, 1]


def test_layback_is_taken_as_applied_unless_said_otherwise(tmp_path: Path) -> None:
    # Heading east at 48.5 degrees north: 100 m west; one degree of longitude is 73,901.4 m on WGS84.
    path = write(tmp_path / "a.jsf", jsf.ping(0, layback=("<f", 228, 100.0)))
    log = read_log(path)
    assert log.pings["longitude_deg"][0] == -68.0
    assert log.info["decisions"]["layback_mode"] == {"taken as applied by the recorder": 1}
    assert read_log(path, layback="apply").pings["longitude_deg"][0] == pytest.approx(-68.0 - 100.0 / 73901.4, abs=1e-8)


def test_navigation_messages(tmp_path: Path) -> None:
    clock = struct.pack("<iI4x", jsf.START_S, 250)
    tilt = bytearray(44)
    tilt[:12] = clock
    struct.pack_into("<hh", tilt, 24, 1820, -910)
    struct.pack_into("<Hi", tilt, 34, 12345, 1 << 6 | 1 << 7 | 1 << 9)
    pressure = bytearray(76)
    pressure[:12] = clock
    struct.pack_into("<i", pressure, 24, 1 << 5)
    struct.pack_into("<i", pressure, 36, 17)
    velocity = bytearray(72)
    velocity[:12] = clock
    struct.pack_into("<I4i3h", velocity, 12, 1 | 1 << 1 | 1 << 2 | 1 << 5 | 1 << 10, 1000, 1200, 0, 1100, 250, 1500, -30)
    struct.pack_into("<H", velocity, 44, 123)
    over_water = bytearray(velocity)
    struct.pack_into("<h", over_water, 32, -32768)
    log = read_log(
        write(
            tmp_path / "a.jsf",
            jsf.message(2020, bytes(tilt)),
            jsf.message(2060, bytes(pressure)),
            jsf.message(2080, bytes(velocity)),
            jsf.message(2080, bytes(over_water)),
            jsf.ping(0),
        )
    )
    attitudes, velocities = log.block["attitudes"], log.block["velocities"]
    assert attitudes["time_s"][0] == pytest.approx(START_S + 0.25, abs=1e-6)
    np.testing.assert_allclose(
        np.degrees([attitudes[name][0] for name in ("pitch_rad", "roll_rad", "heading_rad")]), [9.9976, -4.9988, 123.45], atol=1e-4
    )
    # x to starboard, y ahead, z up in the message
    assert [velocities[name][0] for name in ("forward_m_s", "starboard_m_s", "down_m_s")] == pytest.approx([1.5, 0.25, 0.03])
    assert velocities["bottom_lock"].tolist() == [True, False] and np.isnan(velocities["forward_m_s"][1])
    np.testing.assert_allclose(log.block["depths"]["depth_m"], [17.0, 12.3, 12.3])
    np.testing.assert_allclose(log.block["altitudes"]["altitude_m"], [11.0, 11.0])
    assert log.info["packet_types"] == {80: 2, 2020: 1, 2060: 1, 2080: 2}


def test_another_reader_finds_the_same(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    samples = rng.integers(0, 32000, (6, 2, 50))
    path = write(tmp_path / "a.jsf", *(jsf.ping(number, *samples[number].tolist(), weight=("<h", 168, 3)) for number in range(6)))
    messages = pyjsf.jsf_read(path)
    log = read_log(path)
    assert len(messages) == 12
    for index, (header, trace, data) in enumerate(messages):
        ping, side = divmod(index, 2)
        channel = log.channels[ping][side]
        assert header.channel_number == side and trace.ping_number == log.pings["number"][ping]
        np.testing.assert_array_equal(
            channel["samples"], data.apply_weighting(0).astype(np.float32) if hasattr(data, "apply_weighting") else data
        )
        assert trace.altitude / 1e3 == pytest.approx(log.pings["altitude_m"][ping])
        assert trace.depth / 1e3 == pytest.approx(log.pings["depth_m"][ping])
        assert trace.latitude / 600000.0 == log.pings["latitude_deg"][ping]
        assert trace.sound_speed == pytest.approx(log.pings["sound_speed_m_s"][ping])
        assert trace.compass_heading / 100.0 == pytest.approx(math.degrees(log.pings["heading_rad"][ping]))
