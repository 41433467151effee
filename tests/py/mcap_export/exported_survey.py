"""A recording as its reader gives it back."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Recording:
    """messages: topic -> (log time in ns, content) in the order of the file; order: all log times in that order."""

    messages: dict[str, list[tuple[int, dict[str, Any]]]]
    schemas: dict[str, dict[str, Any]]
    schema_of: dict[str, str]
    order: list[int]

    def contents(self, topic: str) -> list[dict[str, Any]]:
        return [content for _, content in self.messages[topic]]

    def times_s(self, topic: str) -> list[float]:
        return [time_ns / 1e9 for time_ns, _ in self.messages[topic]]


def read_recording(path: Path) -> Recording:
    from mcap.reader import make_reader

    recording = Recording({}, {}, {}, [])
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages(log_time_order=False):
            assert schema is not None and schema.encoding == "jsonschema" and channel.message_encoding == "json"
            recording.schemas.setdefault(schema.name, json.loads(schema.data))
            recording.schema_of[channel.topic] = schema.name
            recording.messages.setdefault(channel.topic, []).append((message.log_time, json.loads(message.data)))
            recording.order.append(message.log_time)
    return recording


@dataclass(frozen=True)
class Survey:
    mission: Path
    run: Path
    recording_path: Path
    recording: Recording
