"""Side-scan logs in XTF (eXtended Triton Format): a file header, then one sonar packet a ping with a port and a starboard channel.

What each field means, and how it is read back: docs/sonar_logs.md. Samples are 16 bits without a sign; port is stored far to near.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssjs_cli.formats.number_table import FloatArray

PACKET_MAGIC, SONAR_PACKET = 0xFACE, 0
FILE_FORMAT, SYSTEM_TYPE = 123, 1
PORT, STARBOARD = 1, 2
PING_HEADER_BYTES, CHANNEL_HEADER_BYTES = 256, 64
METRES, DEGREES = 0, 3
KNOT_M_S = 1852.0 / 3600.0
LARGEST_SAMPLE = 65535

_FILE_HEADER = np.dtype(
    {
        "names": ["FileFormat", "SystemType", "RecordingProgramName", "SonarName", "NavUnits", "NumberOfSonarChannels", "ChanInfo"],
        "formats": ["u1", "u1", "S8", "S16", "<u2", "<u2", "V768"],
        "offsets": [0, 1, 2, 18, 164, 166, 256],
        "itemsize": 1024,
    }
)
_CHANNEL_INFO = np.dtype(
    {
        "names": ["TypeOfChannel", "SubChannelNumber", "CorrectionFlags", "UniPolar", "BytesPerSample", "ChannelName", "Frequency"],
        "formats": ["u1", "u1", "<u2", "<u2", "<u2", "S16", "<f4"],
        "offsets": [0, 1, 2, 4, 6, 12, 32],
        "itemsize": 128,
    }
)
_PING_FIELDS = {
    "MagicNumber": ("<u2", 0), "HeaderType": ("u1", 2), "NumChansToFollow": ("<u2", 4), "NumBytesThisRecord": ("<u4", 10),
    "Year": ("<u2", 14), "Month": ("u1", 16), "Day": ("u1", 17), "Hour": ("u1", 18), "Minute": ("u1", 19), "Second": ("u1", 20),
    "HSeconds": ("u1", 21), "JulianDay": ("<u2", 22), "PingNumber": ("<u4", 28), "SoundVelocity": ("<f4", 32),
    "ComputedSoundVelocity": ("<f4", 72), "FixTimeHour": ("u1", 148), "FixTimeMinute": ("u1", 149), "FixTimeSecond": ("u1", 150),
    "FixTimeHsecond": ("u1", 151), "SensorSpeed": ("<f4", 152), "SensorYcoordinate": ("<f8", 160), "SensorXcoordinate": ("<f8", 168),
    "SensorDepth": ("<f4", 192), "SensorPrimaryAltitude": ("<f4", 196), "SensorPitch": ("<f4", 204), "SensorRoll": ("<f4", 208),
    "SensorHeading": ("<f4", 212), "AttitudeTimeTag": ("<u4", 224), "NavFixMilliseconds": ("<u4", 232),
}  # fmt: skip
_CHANNEL_FIELDS = {
    "ChannelNumber": ("<u2", 0), "SlantRange": ("<f4", 4), "TimeDelay": ("<f4", 12), "TimeDuration": ("<f4", 16),
    "SecondsPerPing": ("<f4", 20), "Frequency": ("<u2", 26), "NumSamples": ("<u4", 42),
}  # fmt: skip


@dataclass(frozen=True)
class SideScanPings:
    """n pings of a sonar with two sides. Times are UTC seconds since 1970. navigation (n, 6): roll, pitch, heading in rad, speed in m/s,
    depth and altitude in m; NaN where unknown. position_m (n, 2): east, north in a grid. port, starboard (n, samples): echo strengths,
    nearest first; sample i lies at the slant range i sample_interval_s sound_speed_m_s / 2."""

    first_number: int
    time_s: FloatArray
    navigation: FloatArray
    position_m: FloatArray
    port: NDArray[np.float32]
    starboard: NDArray[np.float32]
    sound_speed_m_s: float
    frequency_hz: float
    sample_interval_s: float


def write_xtf(path: Path, blocks: Iterable[SideScanPings], *, sonar: str) -> int:
    """Returns the number of pings. The same pings give the same bytes."""
    count = 0
    first_time_s: float | None = None
    with path.open("wb") as file:
        for block in blocks:
            if first_time_s is None:
                first_time_s = float(block.time_s[0])
                file.write(file_header(sonar, block.frequency_hz))
            file.write(packets(block, first_time_s))
            count += len(block.time_s)
    return count


def file_header(sonar: str, frequency_hz: float) -> bytes:
    infos = np.zeros(6, _CHANNEL_INFO)
    for index, (kind, name) in enumerate(((PORT, b"port"), (STARBOARD, b"starboard"))):
        infos[index]["TypeOfChannel"], infos[index]["SubChannelNumber"], infos[index]["ChannelName"] = kind, index, name
        infos[index]["CorrectionFlags"], infos[index]["UniPolar"], infos[index]["BytesPerSample"] = 1, 1, 2
        infos[index]["Frequency"] = frequency_hz / 1e3
    header = np.zeros(1, _FILE_HEADER)
    header["FileFormat"], header["SystemType"], header["RecordingProgramName"] = FILE_FORMAT, SYSTEM_TYPE, b"ssjs-cli"
    header["SonarName"], header["NavUnits"], header["NumberOfSonarChannels"] = sonar.encode("ascii"), METRES, 2
    header["ChanInfo"] = np.void(infos.tobytes())
    return header.tobytes()


def packets(pings: SideScanPings, first_time_s: float) -> bytes:
    """One after the other. The millisecond counters start at 1 with the ping of first_time_s: 0 would mean that there is none."""
    samples = pings.port.shape[1]
    table = np.zeros(len(pings.time_s), _packet_type(samples))
    ping = table["ping"]
    ping["MagicNumber"], ping["HeaderType"], ping["NumChansToFollow"] = PACKET_MAGIC, SONAR_PACKET, 2
    ping["NumBytesThisRecord"] = table.itemsize
    ping["PingNumber"] = pings.first_number + np.arange(len(table))
    ping["SoundVelocity"] = ping["ComputedSoundVelocity"] = pings.sound_speed_m_s
    _set_times(ping, pings.time_s, first_time_s)
    ping["SensorXcoordinate"], ping["SensorYcoordinate"] = pings.position_m.T
    known = np.nan_to_num(pings.navigation, nan=0.0)
    ping["SensorRoll"], ping["SensorPitch"] = np.degrees(known[:, 0]), np.degrees(known[:, 1])
    ping["SensorHeading"] = np.degrees(known[:, 2]) % 360.0
    ping["SensorSpeed"] = known[:, 3] / KNOT_M_S
    ping["SensorDepth"], ping["SensorPrimaryAltitude"] = known[:, 4], known[:, 5]
    duration_s = samples * pings.sample_interval_s
    for index, (side, strengths) in enumerate((("port", pings.port[:, ::-1]), ("starboard", pings.starboard))):
        channel = table[f"{side} header"]
        channel["ChannelNumber"], channel["NumSamples"] = index, samples
        channel["SlantRange"], channel["TimeDuration"] = 0.5 * duration_s * pings.sound_speed_m_s, duration_s
        channel["Frequency"] = round(pings.frequency_hz / 1e3)
        table[side] = np.clip(np.rint(strengths), 0, LARGEST_SAMPLE)
    return table.tobytes()


def _packet_type(samples: int) -> np.dtype[Any]:
    channel = _record(_CHANNEL_FIELDS, CHANNEL_HEADER_BYTES)
    return np.dtype(
        [
            ("ping", _record(_PING_FIELDS, PING_HEADER_BYTES)),
            ("port header", channel), ("port", "<u2", (samples,)),
            ("starboard header", channel), ("starboard", "<u2", (samples,)),
        ]
    )  # fmt: skip


def _record(fields: dict[str, tuple[str, int]], size: int) -> np.dtype[Any]:
    formats, offsets = zip(*fields.values(), strict=True)
    return np.dtype({"names": list(fields), "formats": list(formats), "offsets": list(offsets), "itemsize": size})


def _set_times(ping: NDArray[Any], time_s: FloatArray, first_time_s: float) -> None:
    """The clock is cut to hundredths; the counters tell milliseconds. Both are of the position too."""
    microseconds = np.rint(time_s * 1e6).astype(np.int64)
    date = (microseconds // 1_000_000).astype("datetime64[s]")
    day = date.astype("datetime64[D]")
    month = date.astype("datetime64[M]")
    year = date.astype("datetime64[Y]")
    second_of_day = (date - day).astype(np.int64)
    ping["Year"], ping["Month"] = year.astype(np.int64) + 1970, month.astype(np.int64) % 12 + 1
    ping["Day"] = (day - month.astype("datetime64[D]")).astype(np.int64) + 1
    ping["JulianDay"] = (day - year.astype("datetime64[D]")).astype(np.int64) + 1
    for prefix in ("", "FixTime"):
        ping[f"{prefix}Hour"], ping[f"{prefix}Minute"] = second_of_day // 3600, second_of_day // 60 % 60
        ping[f"{prefix}Second"] = second_of_day % 60
    ping["HSeconds"] = ping["FixTimeHsecond"] = microseconds % 1_000_000 // 10_000
    counter_ms = 1 + np.rint((time_s - first_time_s) * 1e3)
    ping["AttitudeTimeTag"] = ping["NavFixMilliseconds"] = counter_ms
