"""The commands `sonar info` and `sonar waterfall`."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jsf_files as jsf
import numpy as np
import pytest
import pyxtf
import xtf_files as xtf
from PIL import Image

KEYS = ("format", "pings", "channels", "duration_s", "range_m", "sound_velocity_m_s", "position_source", "problems")


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """Twelve pings; on each side the first half of the samples is silent, the second loud, and starboard has a bright sample 30."""
    near_to_far = np.repeat([10, 1000], 20).astype(np.uint16)
    starboard = near_to_far.copy()
    starboard[30] = 60000
    pings = [xtf.ping(number, (near_to_far[::-1].copy(), starboard)) for number in range(12)]
    return xtf.write(tmp_path / "line.xtf", xtf.file_header(), *pings)


def test_info_has_the_agreed_keys(cli: Callable[..., Any], log: Path) -> None:
    answer = cli("sonar", "info", log, "--json")
    document = json.loads(answer.out)
    assert answer.code == 0 and set(KEYS) <= set(document)
    assert {key: document[key] for key in KEYS} == {
        "format": "xtf",
        "pings": 12,
        "channels": 2,
        "duration_s": pytest.approx(1.1),
        "range_m": 30.0,
        "sound_velocity_m_s": 1500.0,
        "position_source": "sensor",
        "problems": [],
    }


def test_info_of_a_jsf_log(cli: Callable[..., Any], tmp_path: Path) -> None:
    path = tmp_path / "line.jsf"
    path.write_bytes(b"".join(jsf.ping(number, range(100), range(100)) for number in range(3)))
    document = json.loads(cli("sonar", "info", path, "--json").out)
    # 100 samples, 20 us apart, at 1480 m/s
    assert (document["format"], document["pings"], document["range_m"]) == ("jsf", 3, pytest.approx(100 * 20e-6 * 1480.0 / 2.0, abs=1e-3))
    assert document["sound_velocity_m_s"] == 1480.0 and document["position_source"] == "trace header"


def test_losses_are_said_with_their_place_and_in_the_exit_code(cli: Callable[..., Any], log: Path) -> None:
    log.write_bytes(log.read_bytes()[:-50])
    answer = cli("sonar", "info", log, "--json")
    document = json.loads(answer.out)
    assert answer.code == 3 and document["pings"] == 11
    (problem,) = document["problems"]
    assert problem["data_lost"] and problem["count"] == 1
    assert problem["first_offset"] == 1024 + 11 * (256 + 2 * (64 + 80))


def test_a_log_without_times_has_no_duration(cli: Callable[..., Any], tmp_path: Path) -> None:
    log = xtf.write(tmp_path / "a.xtf", xtf.file_header(), *(xtf.ping(number, Year=0, Month=0, Day=0) for number in range(3)))
    answer = cli("sonar", "info", log, "--json")
    document = json.loads(answer.out)
    assert answer.code == 0 and document["duration_s"] is None and document["pings"] == 3
    assert [problem["what"] for problem in document["problems"]] == ["a ping without a valid time"]


def test_records_without_a_ping_between_them(cli: Callable[..., Any], tmp_path: Path) -> None:
    many = [xtf.small_packet(pyxtf.XTFHeaderGyro, Gyro=10.0)] * 3
    log = xtf.write(tmp_path / "a.xtf", xtf.file_header(), *many, xtf.ping(0), *many)
    document = json.loads(cli("sonar", "info", log, "--json").out)
    assert document["pings"] == 1 and document["navigation_records"]["attitudes"] == 6


def test_a_log_without_pings_is_refused(cli: Callable[..., Any], tmp_path: Path) -> None:
    path = xtf.write(tmp_path / "empty.xtf", xtf.file_header())
    for command in ("info", "waterfall"):
        answer = cli("sonar", command, path)
        assert answer.code == 2 and "empty.xtf" in answer.err and "no side-scan ping" in answer.err


def test_waterfall_has_port_left_and_the_track_in_the_middle(cli: Callable[..., Any], log: Path, tmp_path: Path) -> None:
    out = tmp_path / "line.png"
    answer = cli("sonar", "waterfall", log, "--out", out, "--json")
    document = json.loads(answer.out)
    pixels = np.asarray(Image.open(out))
    assert answer.code == 0 and pixels.shape == (12, 80) and pixels.dtype == np.uint8
    assert document["m_per_px"] == pytest.approx(30.0 / 40.0)
    assert (pixels == pixels[0]).all()
    # Both sides silent within 15 m of the track in the middle, loud beyond; the echo of starboard sample 30 in column 40 + 30.
    assert pixels[0, 20:60].max() < pixels[0, :20].min() and pixels[0, 20:60].max() < pixels[0, 60:].min()
    assert pixels[0].argmax() == 70


def test_the_first_ping_is_at_the_top(cli: Callable[..., Any], tmp_path: Path) -> None:
    strengths = [np.full(10, 100 + 100 * number, dtype=np.uint16) for number in range(8)]
    log = xtf.write(tmp_path / "a.xtf", xtf.file_header(), *(xtf.ping(number, (s, s)) for number, s in enumerate(strengths)))
    assert cli("sonar", "waterfall", log, "--out", tmp_path / "a.png", "--scale", "linear").code == 0
    rows = np.asarray(Image.open(tmp_path / "a.png"))[:, 0].astype(int)
    assert (np.diff(rows) > 0).all()


def test_pings_of_another_range_keep_their_place_in_metres(cli: Callable[..., Any], tmp_path: Path) -> None:
    samples = np.zeros(20, dtype=np.uint16)
    samples[10] = 5000  # half way
    port = np.zeros(20, dtype=np.uint16)
    far = xtf.ping(0, (port, samples), channel_fields={"SlantRange": 40.0})
    near = xtf.ping(1, (port, samples), channel_fields={"SlantRange": 20.0})
    assert cli("sonar", "waterfall", xtf.write(tmp_path / "a.xtf", xtf.file_header(), far, near), "--out", tmp_path / "a.png").code == 0
    pixels = np.asarray(Image.open(tmp_path / "a.png"))[:, 20:]
    # 2 m a pixel: 20 m is column 10, 10 m is column 5; behind 20 m the second ping holds nothing
    assert [row.argmax() for row in pixels] == [10, 5] and pixels[1, 10:].max() == 0


def test_one_of_two_frequencies(cli: Callable[..., Any], tmp_path: Path) -> None:
    side = [jsf.trace(0, channel, [1, 2, 3, 4], subsystem=20) for channel in (0, 1)]
    high_frequency = {"start_frequency": ("<H", 126, 40000), "end_frequency": ("<H", 128, 42000)}
    side += [jsf.trace(0, channel, [9, 9], subsystem=21, **high_frequency) for channel in (0, 1)]
    path = tmp_path / "a.jsf"
    path.write_bytes(b"".join(side))
    answer = cli("sonar", "waterfall", path, "--frequency-khz", "410", "--out", tmp_path / "a.png", "--json")
    assert answer.code == 0 and json.loads(answer.out)["frequency_hz"] == 410e3
    assert np.asarray(Image.open(tmp_path / "a.png")).shape == (1, 4)
    wrong = cli("sonar", "waterfall", path, "--frequency-khz", "900", "--out", tmp_path / "b.png")
    assert wrong.code == 2 and "120, 410 kHz" in wrong.err


def test_pictures_are_not_replaced_unasked(cli: Callable[..., Any], log: Path, tmp_path: Path) -> None:
    out = tmp_path / "line.png"
    out.write_bytes(b"mine")
    assert cli("sonar", "waterfall", log, "--out", out).code == 2 and out.read_bytes() == b"mine"
    assert cli("sonar", "waterfall", log, "--out", out, "--force").code == 0
    first = out.read_bytes()
    assert cli("sonar", "waterfall", log, "--out", out, "--force").code == 0 and out.read_bytes() == first
