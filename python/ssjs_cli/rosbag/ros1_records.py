"""The records of a ROS 1 bag (version 2.0) from its start to where it ends or breaks off, without its index, which a recorder that was
killed has not written. Format: https://wiki.ros.org/Bags/Format/2.0"""

import bz2
import io
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

from ssjs_cli.rosbag.records import BagMessage, BagTopic, BrokenBagError

MAGIC = b"#ROSBAG V2.0\n"
MESSAGE, CHUNK, CONNECTION = 0x02, 0x05, 0x07
MAX_BYTES = 1 << 30  # of one record

Fields = dict[str, bytes]


def ros1_records(path: Path) -> Iterator[BagTopic | BagMessage]:
    """Ends in BrokenBagError where the file does not end with a whole record."""
    with path.open("rb") as file:
        if file.read(len(MAGIC)) != MAGIC:
            raise BrokenBagError("it does not start as a bag of ROS 1, version 2.0")
        topics: dict[int, BagTopic] = {}
        for fields, data in _records(file):
            if _operation(fields) != CHUNK:
                yield from _content(fields, data, topics)
                continue
            inner = io.BytesIO(_unpacked(data, fields.get("compression", b"none")))
            for inner_fields, inner_data in _records(inner):
                yield from _content(inner_fields, inner_data, topics)


def _records(file: BinaryIO) -> Iterator[tuple[Fields, bytes]]:
    """A chunk that breaks off is given as far as it goes, before BrokenBagError."""
    while head := file.read(4):
        fields = _fields_of(_whole(file, _length(head)))
        wanted = _length(file.read(4))
        data = file.read(wanted)
        if len(data) == wanted or _operation(fields) == CHUNK:
            yield fields, data
        if len(data) < wanted:
            raise BrokenBagError("it breaks off within a record")


def _length(data: bytes) -> int:
    if len(data) < 4:
        raise BrokenBagError("it breaks off within a record")
    (length,) = struct.unpack("<I", data)
    if length > MAX_BYTES:
        raise BrokenBagError(f"a record claims {length} bytes")
    return int(length)


def _whole(file: BinaryIO, length: int) -> bytes:
    data = file.read(length)
    if len(data) < length:
        raise BrokenBagError("it breaks off within a record")
    return data


def _fields_of(header: bytes) -> Fields:
    fields: Fields = {}
    stream = io.BytesIO(header)
    while head := stream.read(4):
        name, _, value = _whole(stream, _length(head)).partition(b"=")
        fields[name.decode("ascii", "replace")] = value
    return fields


def _operation(fields: Fields) -> int:
    return fields.get("op", b"\0")[0] if fields.get("op") else 0


def _unpacked(data: bytes, compression: bytes) -> bytes:
    """As much as can be."""
    if compression == b"none":
        return data
    decompressor: Any
    if compression == b"bz2":
        decompressor = bz2.BZ2Decompressor()
    elif compression == b"lz4":
        import lz4.frame

        decompressor = lz4.frame.LZ4FrameDecompressor()
    else:
        raise BrokenBagError(f"a chunk is packed by {compression.decode('ascii', 'replace')}, which is not known")
    try:
        unpacked: bytes = decompressor.decompress(data, MAX_BYTES)
    except (OSError, RuntimeError, ValueError, EOFError) as error:
        raise BrokenBagError(f"a chunk cannot be unpacked ({error})") from error
    return unpacked


def _content(fields: Fields, data: bytes, topics: dict[int, BagTopic]) -> Iterator[BagTopic | BagMessage]:
    operation = _operation(fields)
    try:
        if operation == CONNECTION:
            (number,) = struct.unpack("<I", fields["conn"])
            about = _fields_of(data)
            if number not in topics:
                kind = about["type"].decode("utf-8").replace("/", "/msg/", 1)
                definition = about["message_definition"].decode("utf-8", "replace")
                topics[number] = BagTopic(fields["topic"].decode("utf-8"), kind, definition)
                yield topics[number]
        elif operation == MESSAGE:
            (number,) = struct.unpack("<I", fields["conn"])
            seconds, nanoseconds = struct.unpack("<II", fields["time"])
            if number in topics:
                yield BagMessage(topics[number].name, seconds * 1_000_000_000 + nanoseconds, data)
    except (KeyError, struct.error, UnicodeDecodeError) as error:
        raise BrokenBagError(f"a record is damaged ({error})") from error
