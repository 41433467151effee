"""A topic is a named stream of messages in the order of time; a file is the merge of its topics."""

import heapq
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from ssjs_cli.errors import UserError
from ssjs_cli.mcap_export.schemas import Schema

NANOSECONDS = 1_000_000_000
MAX_TIME_S = 2.0**32 - 1.0  # what viewers hold in the seconds of a time

Stamped = tuple[int, dict[str, Any]]


@dataclass(frozen=True)
class Topic:
    """messages: time in ns, and what the schema describes, its timestamp set by `stamped`."""

    name: str
    schema: Schema
    messages: Iterable[Stamped]


@dataclass(frozen=True)
class Message:
    topic: int
    time_ns: int
    content: dict[str, Any]


def nanoseconds(time_s: float) -> int:
    if not 0.0 <= time_s <= MAX_TIME_S:
        raise UserError(f"time_s = {time_s!r} cannot be written: MCAP counts from 0 to {MAX_TIME_S:.0f} s; shift the times of the mission")
    return round(time_s * NANOSECONDS)


def timestamp(time_ns: int) -> dict[str, int]:
    seconds, rest = divmod(time_ns, NANOSECONDS)
    return {"sec": seconds, "nsec": rest}


def stamped(time_s: float, /, **fields: Any) -> Stamped:
    time_ns = nanoseconds(time_s)
    return time_ns, {"timestamp": timestamp(time_ns), **fields}


def merged(topics: Sequence[Topic]) -> Iterator[Message]:
    """In the order of time; of the same time, in the order of the topics. Nothing but one message a topic is held."""

    def numbered(index: int) -> Iterator[Message]:
        for time_ns, content in topics[index].messages:
            yield Message(index, time_ns, content)

    return heapq.merge(*(numbered(index) for index in range(len(topics))), key=lambda message: message.time_ns)
