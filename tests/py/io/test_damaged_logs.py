"""Damage costs what it hit and nothing else; it is counted, and told with its place."""

import pickle
from collections.abc import Callable
from pathlib import Path

import jsf_files as jsf
import numpy as np
import pytest
import xtf_files as xtf
from read_log import read_log

from ssjs_cli import _core

CUT = "the log ends within a packet; what it held is lost"
GAP = "bytes that are no packet; reading goes on at the next one"
EMPTY = "a packet of length zero or shorter than its header"
TOO_LONG = "a packet whose length leads beyond the end of the log"


def xtf_pings(count: int) -> tuple[bytes, list[bytes]]:
    rng = np.random.default_rng(1)
    return xtf.file_header(), [xtf.ping(number, rng.integers(0, 65535, (2, 40), dtype=np.uint16)) for number in range(count)]


def jsf_pings(count: int) -> tuple[bytes, list[bytes]]:
    rng = np.random.default_rng(2)
    return b"", [jsf.ping(number, *rng.integers(0, 65535, (2, 40)).tolist()) for number in range(count)]


FORMATS = pytest.mark.parametrize(("suffix", "make"), [("xtf", xtf_pings), ("jsf", jsf_pings)])
Maker = Callable[[int], tuple[bytes, list[bytes]]]


def numbers(path: Path) -> list[int]:
    return list(read_log(path).pings["number"])


@FORMATS
def test_a_log_cut_anywhere_keeps_every_ping_before(tmp_path: Path, suffix: str, make: Maker) -> None:
    header, pings = make(6)
    whole = header + b"".join(pings)
    ends = np.cumsum([len(header), *map(len, pings)])
    for end in range(int(ends[1]), len(whole) + 1, 7):
        path = xtf.write(tmp_path / f"a.{suffix}", whole[:end])
        complete = int(np.searchsorted(ends, end, side="right")) - 1
        found = numbers(path)
        assert found[:complete] == list(range(complete)), end
        # JSF: of a ping cut in its second side the first is left
        assert len(found) - complete in ((0,) if suffix == "xtf" else (0, 1)), end


@FORMATS
def test_cut_at_a_packet_boundary_nothing_is_wrong_and_within_one_it_is_said(tmp_path: Path, suffix: str, make: Maker) -> None:
    header, pings = make(4)
    for kept in range(1, 5):
        path = xtf.write(tmp_path / f"a.{suffix}", header, *pings[:kept])
        assert numbers(path) == list(range(kept)) and read_log(path).problems == {}
    log = read_log(xtf.write(tmp_path / f"b.{suffix}", header, *pings[:3], pings[3][:-1]))
    assert log.info["problems"][0]["what"] == CUT and log.info["problems"][0]["data_lost"]
    start = len(header) + sum(map(len, pings[:3])) + (0 if suffix == "xtf" else len(pings[3]) // 2)
    assert log.info["problems"][0]["first_offset"] == start


@FORMATS
def test_bytes_between_packets_are_passed_over(tmp_path: Path, suffix: str, make: Maker) -> None:
    header, pings = make(4)
    log = read_log(xtf.write(tmp_path / f"a.{suffix}", header, pings[0], b"noise" * 30, pings[1], bytes(500), pings[2], pings[3]))
    assert log.pings["number"].tolist() == [0, 1, 2, 3]
    assert log.problems == {GAP: 2}
    assert log.info["problems"][0]["first_offset"] == len(header) + len(pings[0])


def test_a_record_of_length_zero_does_not_stop_the_reading(tmp_path: Path) -> None:
    header, pings = xtf_pings(3)
    empty = bytearray(pings[1])
    empty[10:14] = bytes(4)
    log = read_log(xtf.write(tmp_path / "a.xtf", header, pings[0], bytes(empty), pings[2]))
    assert log.pings["number"].tolist() == [0, 2]
    assert log.problems == {EMPTY: 1}


@FORMATS
def test_a_length_beyond_the_file_costs_one_packet(tmp_path: Path, suffix: str, make: Maker) -> None:
    header, pings = make(4)
    broken = bytearray(pings[1])
    at = 10 if suffix == "xtf" else 12
    broken[at : at + 4] = (0x7FFFFFF0).to_bytes(4, "little")
    log = read_log(xtf.write(tmp_path / f"a.{suffix}", header, pings[0], bytes(broken), pings[2], pings[3]))
    assert log.pings["number"].tolist() == ([0, 2, 3] if suffix == "xtf" else [0, 1, 2, 3])
    assert log.problems[TOO_LONG] == 1


def test_a_length_over_several_packets_does_not_swallow_them(tmp_path: Path) -> None:
    header, pings = xtf_pings(6)
    broken = bytearray(pings[1])
    broken[10:14] = (3 * len(pings[1])).to_bytes(4, "little")
    log = read_log(xtf.write(tmp_path / "a.xtf", header, pings[0], bytes(broken), *pings[2:]))
    assert log.pings["number"].tolist() == [0, 1, 2, 3, 4, 5]
    assert log.problems == {"a packet longer than its content; the packets within are read": 1}


def test_a_length_too_short_is_found_out(tmp_path: Path) -> None:
    header, pings = xtf_pings(3)
    broken = bytearray(pings[1])
    broken[10:14] = (300).to_bytes(4, "little")
    log = read_log(xtf.write(tmp_path / "a.xtf", header, pings[0], bytes(broken), pings[2]))
    assert log.pings["number"].tolist() == [0, 2]
    assert len(log.problems) == 1


def test_the_magic_number_among_samples_is_no_packet(tmp_path: Path) -> None:
    samples = np.full(200, 0xFACE, dtype=np.uint16)
    header = xtf.file_header()
    full = [xtf.ping(number, (samples, samples)) for number in range(3)]
    damaged = bytearray(full[1])
    damaged[0:2] = b"\0\0"
    log = read_log(xtf.write(tmp_path / "a.xtf", header, full[0], bytes(damaged), full[2]))
    assert log.pings["number"].tolist() == [0, 2] and log.problems == {GAP: 1}


def test_packets_of_unknown_types_are_counted(tmp_path: Path) -> None:
    header, pings = xtf_pings(2)
    unknown = bytearray(128)
    unknown[0:3] = b"\xce\xfa\xc8"
    unknown[10:14] = (128).to_bytes(4, "little")
    log = read_log(xtf.write(tmp_path / "a.xtf", header, pings[0], bytes(unknown), pings[1]))
    assert log.info["packet_types"] == {0: 2, 200: 1} and log.info["pings"] == 2 and log.problems == {}


def test_without_a_file_header_sides_and_sample_size_are_worked_out(tmp_path: Path) -> None:
    samples = np.arange(100, dtype=np.uint8)
    pings = [xtf.ping(number, (samples[::-1].copy(), samples)) for number in range(3)]
    log = read_log(xtf.write(tmp_path / "a.xtf", bytes(1024), *pings))
    assert log.info["pings"] == 3 and len(log.problems) >= 1
    assert [channel["side"] for channel in log.channels[0]] == ["port", "starboard"]
    assert log.channels[0][0]["samples"].tolist() == log.channels[0][1]["samples"].tolist() == list(range(100))


def test_too_many_channels_for_the_packet_keep_the_first(tmp_path: Path) -> None:
    header, pings = xtf_pings(3)
    broken = bytearray(pings[1])
    broken[4:6] = (5).to_bytes(2, "little")
    log = read_log(xtf.write(tmp_path / "a.xtf", header, pings[0], bytes(broken), pings[2]))
    assert log.info["pings"] == 3 and [len(channels) for channels in log.channels] == [2, 2, 2]
    assert log.problems == {"channels that do not fit into their ping": 1}


@FORMATS
def test_random_damage_costs_no_ping_it_did_not_hit(tmp_path: Path, suffix: str, make: Maker) -> None:
    header, pings = make(40)
    whole = header + b"".join(pings)
    starts = np.cumsum([len(header), *map(len, pings)])
    rng = np.random.default_rng(4)
    for _ in range(60):
        damaged = bytearray(whole)
        hits = rng.integers(len(header), len(whole), 5)
        for hit in hits:
            damaged[hit : hit + 30] = rng.bytes(min(30, len(whole) - hit))
        touched = {
            int(np.searchsorted(starts, position, side="right")) - 1 for hit in hits for position in (hit, min(hit + 29, len(whole) - 1))
        }
        found = set(numbers(xtf.write(tmp_path / f"a.{suffix}", bytes(damaged))))
        assert set(range(40)) - touched <= found


def test_files_beside_the_log_are_not_opened(tmp_path: Path) -> None:
    header, pings = xtf_pings(2)
    path = xtf.write(tmp_path / "a.xtf", header, *pings)
    trace = tmp_path / "was-run"

    class Trap:
        def __reduce__(self) -> tuple[object, tuple[str, str]]:
            return open, (str(trace), "w")

    (tmp_path / "a.pyxtf_idx").write_bytes(pickle.dumps(Trap()))
    assert read_log(path).info["pings"] == 2
    assert not trace.exists()
    pickle.loads((tmp_path / "a.pyxtf_idx").read_bytes())  # the trap works
    assert trace.exists()


@pytest.mark.parametrize("content", [b"", b"\0", b"no sonar log at all" * 100])
def test_what_is_no_log_is_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "a.xtf"
    path.write_bytes(content)
    with pytest.raises(OSError, match="neither an XTF nor a JSF log"):
        _core.SonarLog(str(path))


def test_memory_does_not_follow_what_a_log_claims(tmp_path: Path) -> None:
    header, pings = xtf_pings(2)
    broken = bytearray(pings[0])
    broken[256 + 42 : 256 + 46] = (0xFFFFFFFF).to_bytes(4, "little")  # samples of the first channel
    log = read_log(xtf.write(tmp_path / "a.xtf", header, bytes(broken), pings[1]))
    assert log.pings["number"].tolist() == [1]
