"""What a batch remembers of the missions it has planned, so that the next call need not read them again: by path, the run that its files,
as the disk describes them, stand for."""

import json
import os
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ssjs_cli.formats.atomic import write_file
from ssjs_cli.formats.frames import FRAMES_FOLDER
from ssjs_cli.formats.mission import PINGS_FOLDER, is_mission_file

MANIFEST_FILE = "manifest.json"
#: A file that changed so shortly before it was read may change again without another time stamp.
SETTLED_NS = 2_000_000_000


@dataclass(frozen=True)
class KnownMission:
    """signature: names, sizes, times and numbers of its files; key: of its run."""

    signature: str
    mission: str
    key: str


@dataclass
class MissionManifest:
    """request: a digest of all that determines the runs beside the missions; another one knows nothing."""

    request: str
    known: dict[str, KnownMission] = field(default_factory=dict)
    changed: bool = False

    @classmethod
    def read(cls, folder: Path, request: str) -> "MissionManifest":
        try:
            document = json.loads((folder / MANIFEST_FILE).read_text(encoding="utf-8"))
            known = {path: KnownMission(*entry) for path, entry in document["missions"].items()} if document["request"] == request else {}
        except (OSError, ValueError, TypeError, KeyError, AttributeError):
            known = {}
        return cls(request, known)

    def find(self, path: Path) -> KnownMission | None:
        entry = self.known.get(path.as_posix())
        return entry if entry is not None and entry.signature == signature_of(path) else None

    def note(self, path: Path, signature: str, mission: str, key: str) -> None:
        """signature: taken before the mission was read; empty for one that is not to be relied on."""
        if signature:
            self.known[path.as_posix()] = KnownMission(signature, mission, key)
            self.changed = True

    def write(self, folder: Path) -> None:
        if not self.changed:
            return
        missions: Mapping[str, Any] = {path: [entry.signature, entry.mission, entry.key] for path, entry in sorted(self.known.items())}
        write_file(folder / MANIFEST_FILE, json.dumps({"request": self.request, "missions": missions}, separators=(",", ":")) + "\n")


def signature_of(directory: Path, *, settled: bool = False) -> str:
    """Of the files of a mission, without reading them. Empty where there is no such directory or, if asked for `settled` ones, a file has
    changed just now."""
    parts: list[str] = []
    newest_ns = 0
    try:
        with os.scandir(directory) as entries:
            folders = (PINGS_FOLDER, FRAMES_FOLDER)
            names = sorted(entry.name for entry in entries if is_mission_file(entry.name) or entry.name in folders)
        for folder in folders:
            if folder in names:
                names += [f"{folder}/{name}" for name in sorted(os.listdir(directory / folder))]
        for name in names:
            status = os.stat(directory / name)
            newest_ns = max(newest_ns, status.st_mtime_ns, status.st_ctime_ns)
            parts.append(f"{name}:{status.st_size}:{status.st_mtime_ns}:{status.st_ctime_ns}:{status.st_ino}")
    except OSError:
        return ""
    if settled and newest_ns > time.time_ns() - SETTLED_NS:
        return ""
    return ";".join(parts)
