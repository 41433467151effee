"""Every convention of XTF in which readers go wrong, each on a file written for it by pyxtf."""

import math
from pathlib import Path

import numpy as np
import pytest
import pyxtf
import xtf_files as xtf
from read_log import read_log

KNOT_M_S = 1852.0 / 3600.0
#: 2020-02-29 23:59:58 UTC
START_S = 1_583_020_798.0


def test_an_undisturbed_log_has_no_problems(tmp_path: Path) -> None:
    log = read_log(xtf.write(tmp_path / "a.xtf", xtf.file_header(), *(xtf.ping(number) for number in range(5))))
    assert log.info["format"] == "xtf" and log.info["sonar"] == "test sonar" and log.info["pings"] == 5
    assert log.problems == {} and log.info["bytes_skipped"] == 0
    assert log.pings["number"].tolist() == [0, 1, 2, 3, 4]
    np.testing.assert_allclose(log.pings["time_s"], START_S + 0.1 * np.arange(5), atol=1e-6)


def test_port_samples_are_turned_round_and_starboard_samples_are_not(tmp_path: Path) -> None:
    # Both transducers saw the same: 50 nearest, 80 farthest. XTF stores port far to near.
    near_to_far = np.array([50, 60, 70, 80], dtype=np.uint16)
    log = read_log(xtf.write(tmp_path / "a.xtf", xtf.file_header(), xtf.ping(0, (near_to_far[::-1].copy(), near_to_far))))
    port, starboard = log.channels[0]
    assert (port["side"], starboard["side"]) == ("port", "starboard")
    assert port["samples"].tolist() == starboard["samples"].tolist() == [50.0, 60.0, 70.0, 80.0]
    assert port["frequency_hz"] == 600e3


def test_the_file_header_and_not_the_number_says_which_side(tmp_path: Path) -> None:
    log = read_log(xtf.write(tmp_path / "a.xtf", xtf.file_header((xtf.STARBOARD, xtf.PORT)), xtf.ping(0)))
    assert [channel["side"] for channel in log.channels[0]] == ["starboard", "port"]


def test_speeds_are_knots(tmp_path: Path) -> None:
    log = read_log(
        xtf.write(tmp_path / "a.xtf", xtf.file_header(), xtf.ping(0, SensorSpeed=4.0), xtf.ping(1, SensorSpeed=0.0, ShipSpeed=6.0))
    )
    np.testing.assert_allclose(log.pings["speed_m_s"], [4.0 * KNOT_M_S, 6.0 * KNOT_M_S], rtol=1e-6)


@pytest.mark.parametrize(
    ("fields", "speed_m_s", "source"),
    [
        ({"SoundVelocity": 1480.0}, 1480.0, "field"),
        ({"SoundVelocity": 750.0}, 1500.0, "field, doubled"),
        ({"SoundVelocity": 0.0, "ComputedSoundVelocity": 1465.0}, 1465.0, "computed field"),
        # 2 x 30 m in 0.04 s
        ({"SoundVelocity": 0.0}, 1500.0, "range and duration"),
    ],
)
def test_sound_speed_is_one_way_or_two(tmp_path: Path, fields: dict[str, float], speed_m_s: float, source: str) -> None:
    log = read_log(xtf.write(tmp_path / "a.xtf", xtf.file_header(), xtf.ping(0, **fields)))
    assert log.pings["sound_speed_m_s"][0] == pytest.approx(speed_m_s, rel=1e-6)
    assert log.info["decisions"]["sound_speed_source"] == {source: 1}


def test_without_any_sound_speed_one_is_assumed_and_said_so(tmp_path: Path) -> None:
    log = read_log(xtf.write(tmp_path / "a.xtf", xtf.file_header(), xtf.ping(0, SoundVelocity=0.0, channel_fields={"TimeDuration": 0.0})))
    assert log.pings["sound_speed_m_s"][0] == 1500.0
    assert log.info["decisions"]["sound_speed_source"] == {"assumed 1500 m/s": 1}


def test_the_slant_range_of_a_sample_does_not_depend_on_how_sound_speed_is_written(tmp_path: Path) -> None:
    path = xtf.write(tmp_path / "a.xtf", xtf.file_header(), xtf.ping(0, SoundVelocity=750.0), xtf.ping(1, SoundVelocity=1500.0))
    log = read_log(path)
    for index in (0, 1):
        channel = log.channels[index][0]
        metres = channel["sample_interval_s"] * log.pings["sound_speed_m_s"][index] / 2.0
        assert metres == pytest.approx(30.0 / 8.0, rel=1e-6)


def test_recording_may_start_late(tmp_path: Path) -> None:
    log = read_log(xtf.write(tmp_path / "a.xtf", xtf.file_header(), xtf.ping(0, channel_fields={"TimeDelay": 0.004})))
    assert log.channels[0][0]["first_sample_s"] == pytest.approx(0.004, rel=1e-6)


def test_samples_are_weighted(tmp_path: Path) -> None:
    samples = np.array([16, 32], dtype=np.uint16)
    for weight, expected in ((3, [2.0, 4.0]), (-2, [64.0, 128.0])):
        path = xtf.write(
            tmp_path / "a.xtf", xtf.file_header(), xtf.ping(0, (samples[::-1].copy(), samples), channel_fields={"Weight": weight})
        )
        assert [channel["samples"].tolist() for channel in read_log(path).channels[0]] == [expected, expected]


def test_an_impossible_weight_is_taken_as_none(tmp_path: Path) -> None:
    samples = np.array([16, 32], dtype=np.uint16)
    log = read_log(xtf.write(tmp_path / "a.xtf", xtf.file_header(), xtf.ping(0, (samples, samples), channel_fields={"Weight": 30000})))
    assert log.channels[0][1]["samples"].tolist() == [16.0, 32.0]
    assert log.problems == {"a weight of samples beyond 2^40, taken as none": 2}


@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.uint32])
def test_samples_of_every_size(tmp_path: Path, kind: type) -> None:
    samples = np.array([0, 1, np.iinfo(kind).max], dtype=kind)
    path = xtf.write(tmp_path / "a.xtf", xtf.file_header(sample_bytes=samples.itemsize), xtf.ping(0, (samples[::-1].copy(), samples)))
    for channel in read_log(path).channels[0]:
        np.testing.assert_array_equal(channel["samples"], samples.astype(np.float32))


def test_layback_moves_the_position_against_the_heading(tmp_path: Path) -> None:
    # Heading east: 100 m behind is 100 m west. One degree of longitude at 60 degrees north on WGS84 is 55,800.0 m.
    fields = {"SensorYcoordinate": 60.0, "SensorXcoordinate": 10.0, "SensorHeading": 90.0}
    path = xtf.write(tmp_path / "a.xtf", xtf.file_header(), xtf.ping(0, Layback=100.0, **fields), xtf.ping(1, Layback=0.0, **fields))
    log = read_log(path)
    assert log.pings["longitude_deg"][0] == pytest.approx(10.0 - 100.0 / 55800.0, abs=1e-8)
    assert log.pings["latitude_deg"][0] == pytest.approx(60.0, abs=1e-9)
    assert log.pings["longitude_deg"][1] == 10.0
    assert log.info["decisions"]["layback_mode"] == {"applied": 1, "none recorded": 1}
    ignored = read_log(path, layback="ignore")
    assert ignored.pings["longitude_deg"].tolist() == [10.0, 10.0]
    assert ignored.info["decisions"]["layback_mode"] == {"ignored": 1, "none recorded": 1}


def test_layback_in_metres(tmp_path: Path) -> None:
    fields = {"SensorYcoordinate": 5_000_000.0, "SensorXcoordinate": 400_000.0, "SensorHeading": 30.0, "Layback": 50.0}
    log = read_log(xtf.write(tmp_path / "a.xtf", xtf.file_header(nav_units=0), xtf.ping(0, **fields)))
    assert log.pings["east_m"][0] == pytest.approx(400_000.0 - 50.0 * 0.5, abs=1e-5)
    assert log.pings["north_m"][0] == pytest.approx(5_000_000.0 - 50.0 * math.sqrt(0.75), abs=1e-5)
    assert np.isnan(log.pings["latitude_deg"][0])


def test_degrees_said_to_be_metres_are_pointed_out(tmp_path: Path) -> None:
    log = read_log(xtf.write(tmp_path / "a.xtf", xtf.file_header(nav_units=0), xtf.ping(0)))
    assert "coordinates said to be metres that look like degrees" in log.problems


def test_the_ship_stands_in_for_a_sensor_without_position(tmp_path: Path) -> None:
    fields = {"SensorYcoordinate": 0.0, "SensorXcoordinate": 0.0, "ShipYcoordinate": 48.0, "ShipXcoordinate": 7.0}
    log = read_log(xtf.write(tmp_path / "a.xtf", xtf.file_header(), xtf.ping(0, **fields), xtf.ping(1)))
    assert (log.pings["latitude_deg"][0], log.pings["longitude_deg"][0]) == (48.0, 7.0)
    assert log.info["decisions"]["position_source"] == {"sensor": 1, "ship": 1}


def test_the_ship_measures_in_decimetres(tmp_path: Path) -> None:
    fields = {"SensorDepth": 0.0, "SensorPrimaryAltitude": 0.0, "ShipAltitude": 123, "ShipDepth": 45}
    on_hull = {"ShipYcoordinate": 48.4, "ShipXcoordinate": -68.8, "SensorXcoordinate": -68.8}
    log = read_log(xtf.write(tmp_path / "a.xtf", xtf.file_header(), xtf.ping(0, **fields, **on_hull), xtf.ping(1, **fields, Layback=30.0)))
    assert log.pings["altitude_m"][0] == pytest.approx(12.3) and log.pings["depth_m"][0] == pytest.approx(4.5)
    assert np.isnan(log.pings["altitude_m"][1]), "a towed sonar is not where the ship is"


def test_altitude_falls_back_from_bottom_track_to_altimeter(tmp_path: Path) -> None:
    log = read_log(
        xtf.write(
            tmp_path / "a.xtf",
            xtf.file_header(),
            xtf.ping(0, SensorPrimaryAltitude=7.5, SensorAuxAltitude=9.0),
            xtf.ping(1, SensorPrimaryAltitude=0.0, SensorAuxAltitude=9.0),
            xtf.ping(2, SensorPrimaryAltitude=0.0),
        )
    )
    np.testing.assert_array_equal(log.pings["altitude_m"], [7.5, 9.0, np.nan])
    assert log.info["decisions"]["altitude_source"] == {"primary (bottom track)": 1, "auxiliary (altimeter)": 1, "none": 1}


def test_navigation_of_zeros_is_none(tmp_path: Path) -> None:
    names = ("SensorYcoordinate", "SensorXcoordinate", "SensorHeading", "SensorDepth", "SensorPrimaryAltitude", "SensorSpeed")
    log = read_log(xtf.write(tmp_path / "a.xtf", xtf.file_header(), xtf.ping(0, **dict.fromkeys(names, 0.0)), xtf.ping(1)))
    for column in ("latitude_deg", "longitude_deg", "heading_rad", "roll_rad", "pitch_rad", "speed_m_s", "depth_m", "altitude_m"):
        assert np.isnan(log.pings[column][0]) and np.isfinite(log.pings[column][1]), column
    assert log.problems == {"a ping without a position (its navigation is all zero)": 1}


def test_repeated_fixes_are_counted_and_no_fault(tmp_path: Path) -> None:
    same = [xtf.ping(number, SensorXcoordinate=-68.8 + 1e-4 * (number // 3)) for number in range(9)]
    log = read_log(xtf.write(tmp_path / "a.xtf", xtf.file_header(), *same))
    assert log.info["repeated_positions"] == 6 and log.problems == {} and log.info["pings"] == 9


def test_attitude_is_bow_up_and_starboard_down_in_radians(tmp_path: Path) -> None:
    log = read_log(xtf.write(tmp_path / "a.xtf", xtf.file_header(), xtf.ping(0, SensorPitch=-20.0, SensorRoll=4.0, SensorHeading=354.0)))
    for name, degrees in (("pitch_rad", -20.0), ("roll_rad", 4.0), ("heading_rad", 354.0)):
        assert log.pings[name][0] == pytest.approx(math.radians(degrees), rel=1e-6), name


def test_a_millisecond_counter_gives_more_than_hundredths(tmp_path: Path) -> None:
    # True times START + 0.1 n + 3.7 ms n, the counter started 5.25 s before; the stamps are cut to 10 ms.
    true_s = START_S + 0.1037 * np.arange(40)
    pings = []
    for number, time_s in enumerate(true_s):
        past = time_s - START_S
        fields = {"Second": 58, "AttitudeTimeTag": int((past + 5.25) * 1000.0)}
        if past >= 2.0:
            fields |= {"Month": 3, "Day": 1, "Hour": 0, "Minute": 0, "Second": int(past - 2.0)}
        elif past >= 1.0:
            fields["Second"] = 59
        pings.append(xtf.ping(number, HSeconds=int(past * 100.0 + 1e-6) % 100, **fields))
    log = read_log(xtf.write(tmp_path / "a.xtf", xtf.file_header(), *pings))
    error_s = np.abs(log.pings["time_s"] - true_s)
    assert error_s.max() <= 0.010 + 1e-6
    assert error_s[20:].max() <= 0.002
    assert log.info["decisions"]["time_source"] == {"date and millisecond counter": 40}


def test_the_time_of_a_fix_is_its_own(tmp_path: Path) -> None:
    # The fix of 23:59:57.93 is carried by the ping of 23:59:58.00, and after midnight by that of 00:00:00.20.
    before = {"FixTimeHour": 23, "FixTimeMinute": 59, "FixTimeSecond": 57, "FixTimeHsecond": 93}
    after = {"Month": 3, "Day": 1, "Hour": 0, "Minute": 0, "Second": 0, "HSeconds": 20}
    log = read_log(xtf.write(tmp_path / "a.xtf", xtf.file_header(), xtf.ping(0, **before), xtf.ping(1, **before, **after)))
    np.testing.assert_allclose(log.pings["position_time_s"], [START_S - 0.07] * 2, atol=1e-6)


def test_milliseconds_of_a_fix(tmp_path: Path) -> None:
    pings = []
    for number in range(30):
        past = 0.0137 * number
        stamp = {"FixTimeHour": 23, "FixTimeMinute": 59, "FixTimeSecond": 58, "FixTimeHsecond": int(past * 100.0 + 1e-9)}
        pings.append(xtf.ping(number, **stamp, NavFixMilliseconds=7000 + int(past * 1000.0 + 1e-9)))
    log = read_log(xtf.write(tmp_path / "a.xtf", xtf.file_header(), *pings))
    error_s = np.abs(log.pings["position_time_s"] - (START_S + 0.0137 * np.arange(30)))
    assert error_s[15:].max() <= 0.002


def test_navigation_packets(tmp_path: Path) -> None:
    place = {"RawYcoordinate": 48.5, "RawXcoordinate": -68.5}
    log = read_log(
        xtf.write(
            tmp_path / "a.xtf",
            xtf.file_header(),
            xtf.small_packet(pyxtf.XTFHeaderNavigation, Microsecond=250_000, **place),
            # tenths of milliseconds: sixteen bits cannot hold a microsecond of a second
            xtf.small_packet(pyxtf.XTFPosRawNavigation, Microsecond=7500, Pitch=-2.0, Roll=3.0, Heading=45.0, **place),
            xtf.small_packet(pyxtf.XTFAttitudeData, Pitch=1.0, Roll=-1.5, Heading=359.0, Millisecond=125),
            xtf.small_packet(pyxtf.XTFHeaderGyro, Gyro=180.0, SourceEpoch=1_600_000_000, Microsecond=500_000),
            xtf.ping(0),
        )
    )
    positions, attitudes = log.block["positions"], log.block["attitudes"]
    np.testing.assert_allclose(positions["time_s"], [START_S + 0.25, START_S + 0.75], atol=1e-6)
    np.testing.assert_array_equal(positions["latitude_deg"], [48.5, 48.5])
    np.testing.assert_array_equal(positions["longitude_deg"], [-68.5, -68.5])
    np.testing.assert_allclose(attitudes["time_s"], [START_S + 0.75, START_S + 0.125, 1_600_000_000.5], atol=1e-6)
    np.testing.assert_allclose(np.degrees(attitudes["heading_rad"]), [45.0, 359.0, 180.0], rtol=1e-6)
    np.testing.assert_allclose(np.degrees(attitudes["roll_rad"]), [3.0, -1.5, np.nan], rtol=1e-6)
    np.testing.assert_allclose(np.degrees(attitudes["pitch_rad"]), [-2.0, 1.0, np.nan], rtol=1e-6)
    assert log.info["packet_types"] == {0: 1, 3: 1, 23: 1, 42: 1, 107: 1}


def test_more_than_six_channels(tmp_path: Path) -> None:
    kinds = [xtf.PORT, xtf.STARBOARD] * 4 + [xtf.PORT]
    channels = [np.full(5, number, dtype=np.uint16) for number in range(9)]
    log = read_log(xtf.write(tmp_path / "a.xtf", xtf.file_header(kinds), xtf.ping(0, channels), xtf.ping(1, channels)))
    assert log.info["pings"] == 2 and log.problems == {}
    assert [channel["samples"][0] for channel in log.channels[1]] == list(range(9))
    assert [channel["side"] for channel in log.channels[1]] == ["port", "starboard"] * 4 + ["port"]


def test_channels_that_are_no_side_scan_are_left_out(tmp_path: Path) -> None:
    channels = [np.full(5, number, dtype=np.uint16) for number in range(3)]
    log = read_log(xtf.write(tmp_path / "a.xtf", xtf.file_header((xtf.PORT, xtf.STARBOARD, 0)), xtf.ping(0, channels)))
    assert [channel["side"] for channel in log.channels[0]] == ["port", "starboard"]
