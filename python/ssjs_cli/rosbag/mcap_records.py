"""The records of an MCAP bag from its start to where it breaks off, without the summary at its end."""

import struct
from collections.abc import Iterator
from pathlib import Path

from ssjs_cli.rosbag.records import BagMessage, BagTopic, BrokenBagError


def mcap_records(path: Path) -> Iterator[BagTopic | BagMessage]:
    """Ends in BrokenBagError where the file is cut or damaged: chunks are whole or lost."""
    from mcap.exceptions import McapError  # type: ignore[import-not-found,unused-ignore]
    from mcap.records import Channel, Message, Schema  # type: ignore[import-not-found,unused-ignore]
    from mcap.stream_reader import StreamReader  # type: ignore[import-not-found,unused-ignore]

    schemas: dict[int, Schema] = {}
    topics: dict[int, BagTopic] = {}
    with path.open("rb") as file:
        try:
            for record in StreamReader(file, validate_crcs=True, record_size_limit=1 << 30).records:
                if isinstance(record, Schema):
                    schemas[record.id] = record
                elif isinstance(record, Channel) and record.id not in topics and record.schema_id in schemas:
                    schema = schemas[record.schema_id]
                    definition = schema.data.decode("utf-8", "replace") if schema.encoding == "ros2msg" else ""
                    topics[record.id] = BagTopic(record.topic, schema.name, definition)
                    yield topics[record.id]
                elif isinstance(record, Message) and record.channel_id in topics:
                    yield BagMessage(topics[record.channel_id].name, record.log_time, record.data)
        except (McapError, ValueError, RuntimeError, EOFError, OSError, struct.error) as error:
            raise BrokenBagError(f"it breaks off or is damaged ({type(error).__name__}: {error})") from error
