"""XTF logs written by pyxtf, each field where a test wants it."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyxtf
from pyxtf import xtf_ctypes

PORT, STARBOARD = 1, 2


def file_header(channel_types: Sequence[int] = (PORT, STARBOARD), *, nav_units: int = 3, sample_bytes: int = 2) -> bytes:
    """Up to six channels fit into 1024 bytes; each 1024 more hold eight further ones."""
    header = pyxtf.XTFFileHeader()
    header.SonarName = b"test sonar"
    header.NavUnits = nav_units
    header.NumberOfSonarChannels = len(channel_types)
    infos = []
    for number, kind in enumerate(channel_types):
        info = xtf_ctypes.XTFChanInfo()
        info.TypeOfChannel, info.SubChannelNumber, info.BytesPerSample = kind, number, sample_bytes
        info.Frequency = 600.0
        infos.append(info)
    for number, info in enumerate(infos[:6]):
        header.ChanInfo[number] = info
    further = b"".join(bytes(info) for info in infos[6:])
    return bytes(header) + further + bytes(-len(further) % 1024)


def ping(
    number: int,
    channels: Sequence[Any] = (np.arange(8, dtype=np.uint16), np.arange(8, dtype=np.uint16)),
    *,
    channel_fields: dict[str, Any] | None = None,
    **fields: Any,
) -> bytes:
    """At 2020-02-29 23:59:58 + number/10 s, sound speed 1500 m/s, 30 m slant range, on its way east, unless fields say otherwise."""
    packet = pyxtf.XTFPingHeader()
    hundredths = 10 * number
    packet.Year, packet.Month, packet.Day, packet.Hour, packet.Minute = 2020, 2, 29, 23, 59
    packet.Second, packet.HSeconds = min(58 + hundredths // 100, 59), hundredths % 100
    packet.PingNumber, packet.SoundVelocity = number, 1500.0
    packet.SensorYcoordinate, packet.SensorXcoordinate = 48.4, -68.8 + 1e-5 * number
    packet.SensorHeading, packet.SensorDepth, packet.SensorPrimaryAltitude, packet.SensorSpeed = 90.0, 12.0, 7.0, 3.0
    for name, value in fields.items():
        assert hasattr(packet, name), name
        setattr(packet, name, value)
    packet.NumChansToFollow = len(channels)
    packet.ping_chan_headers, packet.data = [], []
    for index, samples in enumerate(channels):
        channel = pyxtf.XTFPingChanHeader()
        channel.ChannelNumber, channel.NumSamples, channel.SlantRange, channel.Frequency = index, len(samples), 30.0, 600
        channel.TimeDuration = 0.04
        for name, value in (channel_fields or {}).items():
            assert hasattr(channel, name), name
            setattr(channel, name, value)
        packet.ping_chan_headers.append(channel)
        packet.data.append(np.asarray(samples))
    packet.NumBytesThisRecord = 256 + sum(64 + samples.nbytes for samples in packet.data)
    return bytes(packet.to_bytes())


def small_packet(kind: Any, **fields: Any) -> bytes:
    """A packet of 64 bytes: XTFHeaderNavigation, XTFPosRawNavigation, XTFAttitudeData, XTFHeaderGyro."""
    packet = kind()
    packet.NumBytesThisRecord = 64
    packet.Year, packet.Month, packet.Day, packet.Hour, packet.Minute, packet.Second = 2020, 2, 29, 23, 59, 58
    for name, value in fields.items():
        assert hasattr(packet, name), name
        setattr(packet, name, value)
    assert len(bytes(packet)) == 64
    return bytes(packet)


def write(path: Path, *parts: bytes) -> Path:
    path.write_bytes(b"".join(parts))
    return path
