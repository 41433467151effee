"""Settings as text, columns of logs, and samples of a vehicle as the bytes that the fuzzers take apart (tests/fuzz/byte_stream.hpp)."""

import math
from itertools import pairwise


def settings() -> list[bytes]:
    vehicle = {
        "method": "ssjs",
        "split.longest_m": "150",
        "split.max_duration_s": "none",
        "split.needs_velocity_fix": "false",
        "arrival.window_s": "0.5",
        "arrival.capacity": "64",
        "compass_use": "mean",
        "joining.solver": "recursive",
        "joining.north_offset_rad": "-0.3",
        "joining.gate_probability": "0.99",
        "existence.min_probability": "1e-3",
        "side_scan.sigma_m": "0.2",
    }
    planar = {
        "method": "dcs",
        "vehicle.kind": "unicycle",
        "submap.split.max_landmarks": "none",
        "joining.max_pairing_sigma_m": "0.16",
        "persistence.scans": "3",
        "smoothing.enabled": "true",
    }
    odd = ("nan", "inf", "-0", "1e999", "0x10", "1 2", "", " 1", "TRUE", "none ", "1,5", "9" * 40, "\0", "\u00e9")
    seeds = [b"%c%s=%s" % (kind, key.encode(), text.encode()) for kind, table in ((0, vehicle), (1, planar)) for key, text in table.items()]
    for key in ("split.longest_m", "split.max_landmarks"):
        seeds += [b"\0" + "\n".join(f"{key}={text}" for text in odd[i : i + 4]).encode() for i in range(0, len(odd), 4)]
    return seeds


def plausible(value: float, scale: float) -> bytes:
    """What ByteStream.plausible(scale) makes `value` of."""
    return max(0, min(65535, round((value / scale + 1.0) * 32767.5))).to_bytes(2, "little")


def log_columns() -> list[bytes]:
    """Whole columns of every sensor, four rows each, of both logs."""
    widths_of = {0: [1, 1, 1, 6, 5, 1], 1: [3, 3, 1, 1, 3, 3]}  # of an event log, of a navigation log
    seeds = []
    for log, widths in widths_of.items():
        for kind, width in enumerate(widths):
            head = bytes([log, 4, kind]) + plausible(0.0, 100.0) + bytes([1, 2, 3, 4])
            seeds.append(head + b"".join(b"\0" + b"\x10\x90" * 4 * width for _ in range(4)))
    return seeds


class Samples:
    """A vehicle's samples, one after the other, each a step after the one before."""

    def __init__(self, choice: int) -> None:
        self.bytes = bytes([choice, 1])

    def add(self, sensor: int, step: int, values: list[tuple[float, float]], tail: bytes = b"") -> None:
        self.bytes += bytes([sensor, step]) + b"".join(plausible(*value) for value in values) + tail

    def tick(self, speed: float, turn: float, heading: float) -> None:
        self.add(0, 1, [(0.0, 0.3), (0.0, 0.3), (turn, 0.5)])
        self.add(1, 1, [(0.01, 0.5), (-0.01, 0.5)])
        self.add(2, 1, [(heading, 7.0)])
        self.add(3, 1, [(5.0, 30.0)])
        self.add(4, 1, [(6.0, 20.0)])
        self.add(5, 100, [(speed, 4.0), (0.0, 0.5), (0.0, 0.5)], b"\1")

    def sight(self, ahead: float, across: float, kind: int = 0) -> None:
        self.add(7, 1, [(ahead, 5.0), (across, 25.0), (6.0, 20.0)], bytes([kind]))


def square(choice: int, ticks: int, landmarks: int, kind: int = 0) -> bytes:
    """Rounds of a square past `landmarks` objects beside each leg: the later rounds see them again."""
    samples = Samples(choice)
    leg = max(1, ticks // 8)
    for i in range(ticks):
        samples.tick(2.0, 0.0, (i // leg) * math.pi / 2 % 6.0)
        if landmarks and i % max(1, leg // landmarks) == 0:
            samples.sight(0.0, 10.0 if i % 2 else -8.0, kind)
    return samples.bytes


def online() -> list[bytes]:
    whole = square(0, 12, 1)
    seeds = [whole, square(1 + 4, 12, 1), square(2 + 16, 8, 1, 1), square(64, 10, 1, 2), square(128, 10, 1), square(192 + 12, 10, 1, 2)]
    late = b"".join(whole[a:b] for a, b in pairwise((0, 2, 40, 30, 90, 60, 300)) if a < b)
    odd = whole[:200] + bytes([245, 1]) + b"\xff" * 24 + whole[200:400]  # a velocity of NaN
    jump = whole[:200] + bytes([3, 250, 0, 0]) * 6 + whole[200:400]  # a clock that jumps, and is followed
    return [*seeds, late, odd, jump, b""]


def checkpoint_edits() -> list[bytes]:
    """Kind, then edits of a true checkpoint: where (3 bytes), how, and eight bytes."""
    edits = [
        (5, 0, b"\xff" * 8),
        (2000, 1, b"\0" * 8),
        (4000, 2, b"\1" + b"\0" * 7),
        (9000, 3, b"\0\0\0\0\0\0\xf0\x7f"),
        (3000, 4, b"\0" * 8),
    ]
    each = [at.to_bytes(3, "little") + bytes([how]) + value for at, how, value in edits]
    return [bytes([kind]) + edit for kind in range(3) for edit in [b"", *each, b"".join(each)]]
