"""The folder of a study: what it is, its finished runs, and in the end its tables. It can be left at any time and taken up again."""

import fcntl
import hashlib
import json
import os
import shutil
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ssjs_cli.errors import UserError, describe_os_error
from ssjs_cli.formats.atomic import write_file
from ssjs_cli.studies.executor import Record

STUDY_FILE = "study.json"
RUNS_FOLDER = "runs"
LOCK_FILE = ".lock"
FAULT_FILE = "faults.log"
KEY_LENGTH = 32


def key_of(identity: Mapping[str, Any]) -> str:
    """A digest of all that determines a run: the same identity has the same result."""
    return hashlib.sha256(canonical_text(identity).encode("utf-8")).hexdigest()[:KEY_LENGTH]


def canonical_text(document: Mapping[str, Any]) -> str:
    return json.dumps(document, sort_keys=True, separators=(",", ":"), allow_nan=False)


class StudyFolder:
    """Open only through open_study(), which holds the lock."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def finished(self, keys: Iterable[str]) -> dict[str, Record]:
        """Records of earlier calls. A file that is no record (a disk that was full) is as good as absent."""
        records: dict[str, Record] = {}
        for key in keys:
            try:
                document = json.loads((self.path / RUNS_FOLDER / f"{key}.json").read_text(encoding="utf-8"))
            except (OSError, ValueError):
                continue
            if isinstance(document, dict) and document.get("key") == key and isinstance(document.get("record"), dict):
                records[key] = document["record"]
        return records

    def store(self, key: str, identity: Mapping[str, Any], record: Record) -> Record:
        """Writes one finished run; gives it back as a later call would read it."""
        text = json.dumps({"key": key, "identity": identity, "record": record}, allow_nan=False)
        write_file(self.path / RUNS_FOLDER / f"{key}.json", text + "\n")
        stored: Record = json.loads(text)["record"]
        return stored

    def write(self, name: str, text: str) -> Path:
        write_file(self.path / name, text)
        return self.path / name

    def note_fault(self, traceback_text: str) -> None:
        with (self.path / FAULT_FILE).open("a", encoding="utf-8") as file:
            file.write(traceback_text + "\n")


@contextmanager
def open_study(path: Path, definition: Mapping[str, Any], *, outputs: Iterable[str], force: bool) -> Iterator[StudyFolder]:
    """A new study, or the same one taken up again; --force starts anew. `outputs`: names of the files it ends with."""
    ours = {STUDY_FILE, RUNS_FOLDER, LOCK_FILE, FAULT_FILE, *outputs}
    _check_target(path, ours, force=force)
    created = not path.exists()
    try:
        path.mkdir(parents=True, exist_ok=True)
        with (path / LOCK_FILE).open("w") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError as error:
                raise UserError(f"{path}: another ssjs-cli is at work on this study; wait for it, or choose another --out") from error
            if force:
                _empty(path)
            _check_definition(path, definition)
            (path / RUNS_FOLDER).mkdir(exist_ok=True)
            _remove_partial_files(path)
            write_file(path / STUDY_FILE, json.dumps(definition, indent=2, allow_nan=False) + "\n")
            try:
                yield StudyFolder(path)
            except BaseException:
                if created and not any((path / RUNS_FOLDER).iterdir()):  # nothing to take up again
                    shutil.rmtree(path, ignore_errors=True)
                raise
    except OSError as error:
        raise UserError(describe_os_error(error, None if error.filename else str(path))) from error


def _check_target(path: Path, ours: set[str], *, force: bool) -> None:
    if path.is_symlink() and not path.exists():
        raise UserError(f"{path}: is a dangling link; remove it or choose another --out")
    if not path.exists():
        return
    if not path.is_dir():
        raise UserError(f"{path}: is a file, and a study is a folder; choose another --out")
    names = sorted(entry.name for entry in path.iterdir() if entry.name != LOCK_FILE)
    if not names:
        return
    if STUDY_FILE not in names:
        raise UserError(f"{path}: exists already and is no study (it holds no {STUDY_FILE}); choose another --out")
    foreign = [name for name in names if name not in ours and not name.endswith(".partial")]
    if force and foreign:
        raise UserError(f"{path}: --force replaces only a study of this kind, and this also holds {foreign[0]}; choose another --out")


def _check_definition(path: Path, definition: Mapping[str, Any]) -> None:
    try:
        earlier = json.loads((path / STUDY_FILE).read_text(encoding="utf-8"))
    except FileNotFoundError:
        return
    except ValueError:
        earlier = {}
    if not isinstance(earlier, dict):
        earlier = {}
    differing = [key for key in (*definition, *earlier) if earlier.get(key) != definition.get(key)]
    if differing:
        names = ", ".join(dict.fromkeys(differing))
        raise UserError(f"{path}: holds another study (different: {names}); choose another --out, or start anew with --force")


def _empty(path: Path) -> None:
    for entry in path.iterdir():
        if entry.name == LOCK_FILE:
            continue
        if entry.is_dir() and not entry.is_symlink():
            shutil.rmtree(entry)
        else:
            entry.unlink()


def _remove_partial_files(path: Path) -> None:
    """What a killed call has left: nobody else is at work here, the lock says so."""
    for folder in (path, path / RUNS_FOLDER):
        for entry in folder.glob(".*.partial"):
            os.unlink(entry)
