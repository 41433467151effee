"""A real XTF log of an autonomous vehicle over a wreck, every field against another reader."""

import datetime
import importlib.util
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import pyxtf

from ssjs_cli import _core

LOG = "scotsman-iver2.xtf"
PICTURE = Path(__file__).resolve().parents[3] / "docs" / "pictures" / "iver2_wreck.py"


@pytest.fixture
def folder(data_set: Callable[[str], Path]) -> Path:
    return data_set("iver2_xtf")


@pytest.fixture
def theirs(folder: Path, tmp_path: Path) -> list[pyxtf.XTFPingHeader]:
    """pyxtf opens files beside the log: it gets a copy in a folder of its own."""
    shutil.copy(folder / LOG, tmp_path / LOG)
    _, packets = pyxtf.xtf_read(str(tmp_path / LOG))
    return list(packets[pyxtf.XTFHeaderType.sonar])


def test_every_field_of_every_ping(folder: Path, theirs: list[pyxtf.XTFPingHeader]) -> None:
    log = _core.SonarLog(str(folder / LOG))
    block = log.read(1000)
    assert block is not None and log.read(1) is None
    pings = block["pings"]
    assert len(block["channels"]) == len(theirs) == 461

    def field(name: str) -> np.ndarray:
        return np.array([getattr(ping, name) for ping in theirs], dtype=np.float64)

    epoch = datetime.datetime(1970, 1, 1)
    stamps = [datetime.datetime(p.Year, p.Month, p.Day, p.Hour, p.Minute, p.Second) - epoch for p in theirs]
    np.testing.assert_allclose(
        pings["time_s"], [stamp.total_seconds() + p.HSeconds / 100 for stamp, p in zip(stamps, theirs, strict=True)], atol=1e-6
    )
    np.testing.assert_array_equal(pings["number"], field("PingNumber"))
    known = field("SensorYcoordinate") != 0.0
    assert known.tolist() == [False] + [True] * 460, "the first ping has navigation of zeros"
    columns = {
        "latitude_deg": field("SensorYcoordinate"),
        "longitude_deg": field("SensorXcoordinate"),
        "heading_rad": np.radians(field("SensorHeading")),
        "pitch_rad": np.radians(field("SensorPitch")),
        "roll_rad": np.radians(field("SensorRoll")),
        "speed_m_s": field("SensorSpeed") * 1852.0 / 3600.0,
        "depth_m": field("SensorDepth"),
        "altitude_m": field("SensorPrimaryAltitude"),
    }
    for name, expected in columns.items():
        np.testing.assert_allclose(pings[name][known], expected[known], rtol=1e-12, err_msg=name)
        assert np.isnan(pings[name][0]), name
    np.testing.assert_array_equal(pings["sound_speed_m_s"], 2.0 * field("SoundVelocity"))
    assert np.isnan(pings["east_m"]).all()

    for channels, ping in zip(block["channels"], theirs, strict=True):
        assert [channel["side"] for channel in channels] == ["port", "starboard"]
        np.testing.assert_array_equal(channels[0]["samples"], ping.data[0][::-1].astype(np.float32))
        np.testing.assert_array_equal(channels[1]["samples"], ping.data[1].astype(np.float32))
        for channel, header in zip(channels, ping.ping_chan_headers, strict=True):
            assert channel["frequency_hz"] == header.Frequency * 1e3
            assert channel["first_sample_s"] == header.TimeDelay
            range_m = channel["sample_interval_s"] * len(channel["samples"]) * 1500.0 / 2.0
            assert range_m == pytest.approx(header.SlantRange, rel=1e-9)
    # The fix lies within a centisecond of its stamp, and its milliseconds narrow that down to less than two.
    fix_s = [datetime.datetime(p.Year, p.Month, p.Day, p.FixTimeHour, p.FixTimeMinute, p.FixTimeSecond) - epoch for p in theirs[1:]]
    stamp_s = np.array([fix.total_seconds() + p.FixTimeHsecond / 100 for fix, p in zip(fix_s, theirs[1:], strict=True)])
    late_s = pings["position_time_s"][1:] - stamp_s
    assert late_s.min() >= -1e-6 and late_s.max() <= 0.01 + 1e-6
    zero_s = pings["position_time_s"][1:] - field("NavFixMilliseconds")[1:] * 1e-3
    assert np.ptp(zero_s[100:]) <= 0.002


def test_what_the_reader_decided(folder: Path) -> None:
    log = _core.SonarLog(str(folder / LOG))
    while log.read(100) is not None:
        pass
    info = log.info()
    assert info["pings"] == 461 and info["bytes_skipped"] == 0 and info["repeated_positions"] > 0
    assert info["decisions"] == {
        "time_source": {"date and hundredths": 461},
        "position_source": {"sensor": 460, "none": 1},
        "layback_mode": {"none recorded": 460},
        "altitude_source": {"primary (bottom track)": 460, "none": 1},
        "sound_speed_source": {"field, doubled": 461},
    }
    assert [(problem["what"], problem["count"], problem["data_lost"]) for problem in info["problems"]] == [
        ("a ping without a position (its navigation is all zero)", 1, False)
    ]


def test_the_supplied_hit_is_bright(folder: Path) -> None:
    """The sample of the hit counts along the bottom: at 3.75 m altitude it is 5.5 m from the sonar, where the hull clips the recorder.
    As a slant range it would be 0.2 m above the first echo of the bottom."""
    channel, sample, ping = map(int, (folder / f"{LOG}.hits").read_text().split())
    log = _core.SonarLog(str(folder / LOG))
    block = log.read(1000)
    assert block is not None
    strengths = np.array([channels[channel]["samples"] for channels in block["channels"]])
    per_sample_m = block["channels"][ping][channel]["sample_interval_s"] * 1500.0 / 2.0

    def clipped(chosen: int) -> float:
        """Fraction of the echoes within 0.6 m of the hit's place across the track that clip the recorder."""
        slant = round(np.hypot(sample * per_sample_m, block["pings"]["altitude_m"][chosen]) / per_sample_m)
        return float((strengths[chosen, slant - 20 : slant + 21] >= 32767.0).mean())

    assert np.mean([clipped(chosen) for chosen in range(ping - 5, ping + 6)]) >= 0.15
    for before_or_behind in (range(100, 200), range(370, 410)):
        assert np.mean([clipped(chosen) for chosen in before_or_behind]) <= 0.03


def test_the_supplied_hit_lies_in_the_box_of_the_wreck(folder: Path) -> None:
    """In ground range, as its sample counts. The box is that of the picture in docs/sonar_logs.md, and it is drawn."""
    specification = importlib.util.spec_from_file_location("iver2_wreck", PICTURE)
    assert specification is not None and specification.loader is not None
    drawing = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(drawing)
    ping, ground_m = drawing.hit_of(folder)
    assert ping == 281 and ground_m == pytest.approx(4.04, abs=0.02)
    survey = _core.side_scan_pictures(_core.SonarLog(str(folder / LOG)), 4096, drawing.SETTINGS)
    wrecks = [contact for contact in survey["contacts"] if drawing.holds(contact, ping, ground_m)]
    assert len(wrecks) == 1
    assert 15.0 < wrecks[0]["length_m"] < 30.0
    assert 4.0 < wrecks[0]["width_m"] < 12.0
    # Not by being everywhere.
    first, last, nearest, farthest = drawing.box_of(wrecks[0])
    assert last - first < 0.5 * len(survey["altitude_m"]) and farthest - nearest < 12.0
