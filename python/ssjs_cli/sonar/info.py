"""The command `sonar info`: what a log holds, what the reader decided, what was wrong."""

import json
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from ssjs_cli.errors import UserError
from ssjs_cli.exit_codes import DONE, PARTLY_DONE
from ssjs_cli.formats.atomic import check_writable, write_file
from ssjs_cli.session import Session
from ssjs_cli.sonar.log_blocks import blocks, open_log

RECORDS = ("positions", "attitudes", "velocities", "depths", "altitudes")


def show_info(path: Path, out: Path | None, session: Session, *, layback: str, force: bool) -> int:
    document = describe(path, layback)
    if out is not None:
        check_writable(out, [path], force=force)
        out.parent.mkdir(parents=True, exist_ok=True)
        write_file(out, json.dumps(document, indent=2, allow_nan=False) + "\n")
    session.answer(document, _text(path, document))
    return exit_code(document["problems"])


def exit_code(problems: list[dict[str, Any]]) -> int:
    return PARTLY_DONE if any(problem["data_lost"] for problem in problems) else DONE


def describe(path: Path, layback: str = "auto") -> dict[str, Any]:
    log = open_log(path, layback)
    first_s, last_s = np.inf, -np.inf
    kinds: Counter[tuple[str, float]] = Counter()
    ranges_m: Counter[float] = Counter()
    sound_m_s: Counter[float] = Counter()
    records = dict.fromkeys(RECORDS, 0)
    for block in blocks(log):
        known_s = block["pings"]["time_s"][np.isfinite(block["pings"]["time_s"])]
        first_s, last_s = min(first_s, known_s.min(initial=np.inf)), max(last_s, known_s.max(initial=-np.inf))
        for speed_m_s, channels in zip(block["pings"]["sound_speed_m_s"].tolist(), block["channels"], strict=True):
            sound_m_s[round(speed_m_s, 3)] += 1
            for channel in channels:
                kinds[channel["side"], channel["frequency_hz"]] += 1
                end_s = channel["first_sample_s"] + len(channel["samples"]) * channel["sample_interval_s"]
                ranges_m[round(end_s * speed_m_s / 2.0, 3)] += 1
        for name in RECORDS:
            records[name] += len(block[name]["time_s"])
    info = log.info()
    if not info["pings"]:
        problems = "; ".join(problem["what"] for problem in info["problems"]) or "it holds other records only"
        raise UserError(f"{path}: holds no side-scan ping ({problems}); check that it is the right file")
    return {
        "format": info["format"],
        "recorder": info["recorder"],
        "sonar": info["sonar"],
        "pings": info["pings"],
        "channels": len(kinds),
        "channel_list": [{"side": side, "frequency_hz": frequency, "pings": count} for (side, frequency), count in sorted(kinds.items())],
        "start_time_s": float(first_s) if np.isfinite(first_s) else None,
        "duration_s": round(float(last_s - first_s), 6) if np.isfinite(first_s) else None,
        "range_m": ranges_m.most_common(1)[0][0] or None,
        "sound_velocity_m_s": sound_m_s.most_common(1)[0][0],
        "position_source": _leading(info["decisions"]["position_source"]),
        "altitude_source": _leading(info["decisions"]["altitude_source"]),
        "decisions": info["decisions"],
        "repeated_positions": info["repeated_positions"],
        "navigation_records": records,
        "packet_types": {str(kind): count for kind, count in info["packet_types"].items()},
        "bytes_skipped": info["bytes_skipped"],
        "problems": info["problems"],
    }


def _leading(counts: dict[str, int]) -> str:
    """The most frequent choice that is one."""
    known = {name: count for name, count in counts.items() if name != "none"}
    return max(known, key=lambda name: known[name]) if known else "none"


def _text(path: Path, document: dict[str, Any]) -> str:
    names = ", ".join(f"{entry['side']} {entry['frequency_hz'] / 1e3:g} kHz" for entry in document["channel_list"])
    recorder = " ".join(part for part in (document["recorder"], document["sonar"]) if part)
    duration = "without times" if document["duration_s"] is None else f"{document['duration_s']:g} s"
    range_text = "unknown" if document["range_m"] is None else f"{document['range_m']:g} m"
    lines = [
        f"{path}: {document['format'].upper()}{f' by {recorder}' if recorder else ''}, {document['pings']} pings, {duration}",
        f"  channels     {names}",
        f"  slant range  {range_text}, sound speed {document['sound_velocity_m_s']:g} m/s",
    ]
    for name, counts in document["decisions"].items():
        choices = ", ".join(f"{choice} ({count})" for choice, count in sorted(counts.items(), key=lambda item: (-item[1], item[0])))
        lines.append(f"  {name.replace('_', ' '):<19}{choices}")
    lines.append(f"  positions repeat between pings {document['repeated_positions']} times")
    others = [f"{count} {name}" for name, count in document["navigation_records"].items() if count]
    if others:
        lines.append(f"  besides the pings: {', '.join(others)}")
    lines += [f"  {describe_problem(problem)}" for problem in document["problems"]]
    return "\n".join(lines)


def describe_problem(problem: dict[str, Any]) -> str:
    kind = "lost" if problem["data_lost"] else "note"
    return f"{kind}: {problem['what']}: {problem['count']} times, first at byte {problem['first_offset']}"
