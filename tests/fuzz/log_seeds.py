"""Sonar logs, XTF and JSF. The first byte of a seed chooses the format: 0 XTF, 1 JSF."""

import sys
from pathlib import Path

import numpy as np
import pyxtf

sys.path.insert(0, str(Path(__file__).parents[1] / "py" / "io"))
import jsf_files as jsf
import xtf_files as xtf


def xtf_seeds() -> list[bytes]:
    samples = np.arange(40, dtype=np.uint16)
    pings = [xtf.ping(number, (samples, samples)) for number in range(4)]
    navigation = [
        xtf.small_packet(pyxtf.XTFHeaderNavigation, RawYcoordinate=48.4, RawXcoordinate=-68.8),
        xtf.small_packet(pyxtf.XTFPosRawNavigation, RawYcoordinate=48.4, RawXcoordinate=-68.8, Heading=10.0),
        xtf.small_packet(pyxtf.XTFAttitudeData, Pitch=1.0, Roll=2.0, Heading=3.0),
        xtf.small_packet(pyxtf.XTFHeaderGyro, Gyro=45.0),
    ]
    wide = [np.arange(6, dtype=np.uint16)] * 9
    return [
        xtf.file_header() + b"".join(pings),
        xtf.file_header() + pings[0] + b"".join(navigation) + pings[1],
        xtf.file_header((1, 2) * 4 + (1,)) + xtf.ping(0, wide) + xtf.ping(1, wide),
        xtf.file_header(sample_bytes=1) + xtf.ping(0, (np.arange(64, dtype=np.uint8),) * 2),
        xtf.file_header(sample_bytes=4) + xtf.ping(0, (np.arange(16, dtype=np.uint32),) * 2),
        bytes(1024) + pings[0] + pings[1],
        xtf.file_header() + pings[0] + b"\x00" * 14 + pings[1] + b"\xce\xfa" * 20 + pings[2],
        xtf.file_header() + xtf.ping(0, (np.arange(15000, dtype=np.uint16),) * 2),
    ]


def jsf_seeds() -> list[bytes]:
    pings = [jsf.ping(number, range(30), range(30)) for number in range(4)]
    others = [
        jsf.message(2020, bytes(range(44))),
        jsf.message(2060, bytes(range(76))),
        jsf.message(2080, b"\xff" * 72),
        jsf.message(2002, b"$GPGGA"),
    ]
    return [
        b"".join(pings),
        pings[0] + b"".join(others) + pings[1],
        jsf.trace(0, 0, [1, -2, 3, -4], stored="<h", data_format=("<h", 34, 1), count=("<H", 114, 2)),
        pings[0] + b"\x01\x16" * 20 + pings[1] + jsf.message(80, b"", size=-1) + pings[2],
        jsf.trace(0, 0, range(25000)),
    ]


def sonar_log() -> list[bytes]:
    return [b"\0" + seed for seed in xtf_seeds()] + [b"\1" + seed for seed in jsf_seeds()]
