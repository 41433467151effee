"""The command `export mcap`: the topics of a run and of its mission, merged by time into one file."""

import importlib
import json
from collections import Counter
from pathlib import Path
from typing import Any, BinaryIO

from ssjs_cli import _core
from ssjs_cli.errors import UserError
from ssjs_cli.exit_codes import DONE, PARTLY_DONE
from ssjs_cli.formats.atomic import check_writable, new_file
from ssjs_cli.formats.mission import Mission, input_digests, mission_directory, read_mission
from ssjs_cli.formats.mission_link import linked_mission
from ssjs_cli.formats.run_directory import RUN_FILES, run_directory
from ssjs_cli.mcap_export.mission_topics import StripSize, mission_topics
from ssjs_cli.mcap_export.run_files import RunFiles, read_run_files
from ssjs_cli.mcap_export.run_topics import run_topics
from ssjs_cli.mcap_export.schemas import schema_bytes
from ssjs_cli.mcap_export.topics import NANOSECONDS, Topic, merged
from ssjs_cli.progress import working
from ssjs_cli.session import Session

WITHOUT = "the depth and altitude sensors, the sonar, latitude and longitude are left out"


def export_mcap(path: Path, out: Path | None, session: Session, *, mission_path: Path | None, strips: StripSize | None, force: bool) -> int:
    writer_module = _mcap_writer()
    directory = run_directory(path)
    target = out if out is not None else directory.with_name(f"{directory.resolve().name}.mcap")
    if target.is_dir() or target.suffix.lower() != ".mcap":
        raise UserError(f"{target}: the recording is one file; end the name of --out with .mcap")
    check_writable(target, [directory / name for name in RUN_FILES], force=force)
    lost: list[str] = []
    run = read_run_files(directory)
    mission = _mission_of(directory, run, mission_path, lost)
    topics = run_topics(run, None if mission is None else mission.geodetic)
    if mission is not None:
        topics += mission_topics(mission, strips, lost)
    with working("writing the recording"), new_file(target) as file:
        counts, span_s = _write(file, topics, run, writer_module)
    document = {"recording": str(target), "duration_s": round(span_s, 6), "messages": counts, "lost": lost}
    for text in lost:
        session.message(f"lost: {text}")
    lines = [f"{target}: {sum(counts.values())} messages over {span_s:g} s", *(f"  {name:<24}{count}" for name, count in counts.items())]
    session.answer(document, "\n".join(lines))
    return PARTLY_DONE if lost else DONE


def _mcap_writer() -> Any:
    try:
        return importlib.import_module("mcap.writer")
    except ImportError as error:
        raise UserError("export mcap needs the extra 'mcap': pip install 'ssjs[mcap]'") from error


def _mission_of(directory: Path, run: RunFiles, given: Path | None, lost: list[str]) -> Mission | None:
    """The mission that was run, if it can be found and is still what was run."""
    if given is not None:
        mission = mission_directory(given)
    else:
        try:
            mission = linked_mission(directory, "name it with --mission DIR")
        except UserError as error:
            lost.append(f"{error}; {WITHOUT}")
            return None
    digests = input_digests(mission)
    changed = sorted(name for name, digest in run.summary.get("input_digests", {}).items() if digests.get(name) != digest)
    if changed:
        text = f"{mission / changed[0]}: is not the file that was run"
        if given is not None:
            raise UserError(f"{text}; give the mission of this run as --mission, or run it again")
        lost.append(f"{text}, run the mission again; {WITHOUT}")
        return None
    return read_mission(mission)


def _write(file: BinaryIO, topics: list[Topic], run: RunFiles, writer_module: Any) -> tuple[dict[str, int], float]:
    """The number of messages of each topic, and the time from the first to the last."""
    writer = writer_module.Writer(file)
    writer.start(profile="", library=f"ssjs {_core.version()}")
    summary = run.summary
    about = {key: str(summary.get(key, "")) for key in ("mission", "method", "association", "version", "seed")}
    writer.add_metadata("ssjs", about)
    schema_ids: dict[str, int] = {}
    channels = []
    for topic in topics:
        title = topic.schema["title"]
        if title not in schema_ids:
            schema_ids[title] = writer.register_schema(name=title, encoding="jsonschema", data=schema_bytes(topic.schema))
        channels.append(writer.register_channel(topic=topic.name, message_encoding="json", schema_id=schema_ids[title]))
    counts: Counter[int] = Counter()
    first_ns = last_ns = 0
    for message in merged(topics):
        first_ns = message.time_ns if not counts else first_ns
        last_ns = message.time_ns
        data = json.dumps(message.content, separators=(",", ":"), allow_nan=False).encode("utf-8")
        writer.add_message(
            channel_id=channels[message.topic],
            log_time=message.time_ns,
            publish_time=message.time_ns,
            sequence=counts[message.topic],
            data=data,
        )
        counts[message.topic] += 1
    writer.finish()
    return {topic.name: counts[index] for index, topic in enumerate(topics)}, (last_ns - first_ns) / NANOSECONDS
