"""A recording opened: its topics, and its messages as Python objects. The library rosbags reads whole recordings; one without an index
at its end is read from its start to where it breaks off."""

import importlib
import struct
from collections import Counter
from collections.abc import Callable, Collection, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from ssjs_cli.errors import UserError
from ssjs_cli.rosbag.mcap_records import mcap_records
from ssjs_cli.rosbag.records import BagMessage, BagTopic, BrokenBagError
from ssjs_cli.rosbag.ros1_records import ros1_records

SUFFIXES = (".bag", ".mcap", ".db3")
METADATA = "metadata.yaml"
# What the decoding of a damaged message may end in.
UNDECODABLE = (struct.error, ValueError, LookupError, TypeError, AttributeError, AssertionError, ArithmeticError, MemoryError, SyntaxError)


class BagEntry(NamedTuple):
    topic: str
    time_ns: int
    message: Any


class Bag:
    def __init__(self, source: Path) -> None:
        self._rosbags = _library("rosbags.highlevel")
        self._typesys = importlib.import_module("rosbags.typesys")
        self.source = source
        self.parts = [_Part(path, self._rosbags, self._typesys) for path in _parts_of(source)]
        self._undecodable: Counter[str] = Counter()

    @property
    def lost(self) -> list[str]:
        """What could not be read, complete when the messages have been read."""
        told = [text for part in self.parts for text in part.lost]
        return told + [
            f"{self.source}: {count} messages of {topic} cannot be decoded" for topic, count in sorted(self._undecodable.items())
        ]

    def topics(self) -> dict[str, str]:
        """Name to type, in the order of names."""
        return dict(sorted((topic.name, topic.kind) for part in self.parts for topic in part.topics))

    def note_undecodable(self, topic: str) -> None:
        self._undecodable[topic] += 1

    def counts(self) -> Counter[str]:
        return sum((part.counts for part in self.parts), Counter())

    def messages(self, topics: Collection[str]) -> Iterator[BagEntry]:
        for part in self.parts:
            for topic, time_ns, message in part.messages(topics):
                if message is None:
                    self._undecodable[topic] += 1
                else:
                    yield BagEntry(topic, time_ns, message)


class _Part:
    """One file, or one directory of ROS 2 with its metadata."""

    def __init__(self, path: Path, rosbags: Any, typesys: Any) -> None:
        self._path, self._rosbags, self._typesys = path, rosbags, typesys
        self.topics: list[BagTopic] = []
        self.counts: Counter[str] = Counter()
        self.lost: list[str] = []
        self._is_whole = True
        try:
            with self._open() as reader:
                for connection in reader.connections:
                    self.topics.append(BagTopic(connection.topic, connection.msgtype, ""))
                    self.counts[connection.topic] += connection.msgcount
        except FileNotFoundError as error:
            raise UserError(f"{path}: is missing or incomplete ({error}); copy the whole recording") from error
        except Exception as error:  # of whatever kind: the library's readers trust the file
            self._is_whole = False
            self._scan(f"{type(error).__name__}: {error}")

    def _open(self) -> Any:
        store = self._typesys.get_typestore(self._typesys.Stores.ROS2_HUMBLE)
        return self._rosbags.AnyReader([self._path], default_typestore=store)

    def _records(self) -> Iterator[BagTopic | BagMessage]:
        return ros1_records(self._path) if self._path.suffix == ".bag" else mcap_records(self._path)

    def _scan(self, reason: str) -> None:
        """What there is before the damage; nothing at all is no recording."""
        if self._path.is_dir() or self._path.suffix not in (".bag", ".mcap"):
            raise UserError(f"{self._path}: cannot be read ({reason}); repair it with `ros2 bag reindex` or `sqlite3 FILE .recover`")
        broken = "its index is missing or damaged"
        try:
            for record in self._records():
                if isinstance(record, BagTopic):
                    self.topics.append(record)
                else:
                    self.counts[record.topic] += 1
        except BrokenBagError as error:
            broken = str(error)
        if not self.counts:
            raise UserError(f"{self._path}: is no bag of ROS, or nothing of it can be read ({broken}); copy the recording again")
        self.lost.append(f"{self._path}: {broken}; {sum(self.counts.values())} messages before that were kept")

    def messages(self, topics: Collection[str]) -> Iterator[tuple[str, int, Any]]:
        """None for a message that cannot be decoded."""
        if not self._is_whole:
            yield from self._messages_before_damage(topics)
            return
        given = 0
        with self._open() as reader:
            wanted = [connection for connection in reader.connections if connection.topic in topics]
            if not wanted:
                return
            try:
                for connection, time_ns, data in reader.messages(connections=wanted):
                    yield connection.topic, time_ns, _decoded(reader.deserialize, data, connection.msgtype, self._rosbags.AnyReaderError)
                    given += 1
            except GeneratorExit:
                raise
            except Exception as error:  # a damaged chunk: what came before it is good
                expected = sum(connection.msgcount for connection in wanted)
                self.lost.append(f"{self._path}: is damaged ({type(error).__name__}: {error}); {given} of {expected} messages were kept")

    def _messages_before_damage(self, topics: Collection[str]) -> Iterator[tuple[str, int, Any]]:
        """Types come in the order of the file, each before its first message."""
        decoders: dict[str, Callable[[bytes], Any]] = {}
        with suppress(BrokenBagError):  # said already
            for record in self._records():
                if isinstance(record, BagTopic) and record.name in topics and record.name not in decoders:
                    decoders[record.name] = self._decoder(record)
                elif isinstance(record, BagMessage) and record.topic in decoders:
                    yield record.topic, record.time_ns, decoders[record.topic](record.data)

    def _decoder(self, topic: BagTopic) -> Callable[[bytes], Any]:
        """By the definition in the recording; where that is damaged or missing, by the one that ROS delivers under this name."""
        is_ros1 = self._path.suffix == ".bag"
        stores, typesys_error = self._typesys.Stores, self._typesys.TypesysError
        store = self._typesys.get_typestore(stores.EMPTY)
        try:
            store.register(self._typesys.get_types_from_msg(topic.definition, topic.kind))
        except (typesys_error, *UNDECODABLE):
            store = self._typesys.get_typestore(stores.ROS1_NOETIC if is_ros1 else stores.ROS2_HUMBLE)
        deserialize = store.deserialize_ros1 if is_ros1 else store.deserialize_cdr
        serde_error = importlib.import_module("rosbags.serde").SerdeError
        return lambda data: _decoded(deserialize, data, topic.kind, serde_error)


def _decoded(deserialize: Callable[[bytes, str], Any], data: bytes, kind: str, error: type[Exception]) -> Any:
    try:
        return deserialize(data, kind)
    except (error, *UNDECODABLE):
        return None


def _library(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise UserError("import rosbag needs the extra 'rosbag': pip install 'ssjs[rosbag]'") from error


def _parts_of(source: Path) -> list[Path]:
    if source.is_file():
        if source.suffix not in SUFFIXES:
            raise UserError(f"{source}: is no bag by its name; give a .bag, .mcap or .db3, or the directory of a ROS 2 recording")
        return [source]
    if not source.is_dir():
        raise UserError(f"{source}: is missing; check the path")
    if (source / METADATA).is_file():
        return [source]
    files = sorted(path for path in source.iterdir() if path.suffix in SUFFIXES and path.is_file())
    if not files:
        raise UserError(f"{source}: holds neither {METADATA} nor any .bag, .mcap or .db3; name the directory of a recording")
    return files
