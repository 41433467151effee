"""JSF logs written field by field: no library writes them. Offsets count from the end of the 16-byte message header."""

import struct
from collections.abc import Sequence

PORT, STARBOARD = 0, 1
#: position, speed, heading, pitch and roll, altitude, depth
ALL_VALID = 1 | 1 << 2 | 1 << 3 | 1 << 5 | 1 << 6 | 1 << 9
START_S = 1_582_934_398  # 2020-02-28 23:59:58 UTC


def message(kind: int, body: bytes, *, subsystem: int = 0, channel: int = 0, size: int | None = None) -> bytes:
    return struct.pack("<HBBHBBBBHi", 0x1601, 0x0D, 0, kind, 0, subsystem, channel, 0, 0, len(body) if size is None else size) + body


def trace(
    number: int, channel: int, samples: Sequence[int], *, subsystem: int = 20, stored: str = "<H", **fields: tuple[str, int, float]
) -> bytes:
    """One side of a ping, 0.1 s after the one before. fields: name=(struct format, offset, value), over the defaults."""
    header = bytearray(240)
    milliseconds = (START_S % 86400) * 1000 + 100 * number
    defaults: dict[str, tuple[str, int, float]] = {
        "time": ("<I", 0, START_S + number // 10),
        "today_ms": ("<I", 200, milliseconds),
        "number": ("<I", 8, number),
        "validity": ("<H", 30, ALL_VALID),
        "longitude": ("<i", 80, -68 * 600000 + 100 * number),
        "latitude": ("<i", 84, 48 * 600000 + 30 * 10000),
        "units": ("<h", 88, 2),
        "count": ("<H", 114, len(samples)),
        "interval_ns": ("<I", 116, 20000),
        "start_frequency": ("<H", 126, 11500),
        "end_frequency": ("<H", 128, 12500),
        "depth_mm": ("<i", 136, 12340),
        "altitude_mm": ("<i", 144, 7650),
        "sound_speed": ("<f", 148, 1480.0),
        "weight": ("<h", 168, 0),
        "heading": ("<H", 172, 9000),
        "pitch": ("<h", 174, 1820),
        "roll": ("<h", 176, -910),
        "speed": ("<h", 194, 30),
    }
    for layout, offset, value in (defaults | fields).values():
        struct.pack_into(layout, header, offset, value if layout[-1] == "f" else int(value))
    return message(80, bytes(header) + b"".join(struct.pack(stored, sample) for sample in samples), subsystem=subsystem, channel=channel)


def ping(
    number: int, port: Sequence[int] = (1, 2, 3, 4), starboard: Sequence[int] = (5, 6, 7, 8), **fields: tuple[str, int, float]
) -> bytes:
    return trace(number, PORT, port, **fields) + trace(number, STARBOARD, starboard, **fields)
