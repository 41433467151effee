"""A side-scan log, a block of pings at a time, so that its length does not count."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ssjs_cli import _core
from ssjs_cli.errors import UserError

PINGS_PER_BLOCK = 512

#: "auto" is what the format means: see docs/sonar_logs.md
LAYBACK_MODES = ("auto", "apply", "ignore")


def open_log(path: Path, layback: str = "auto") -> _core.SonarLog:
    if path.is_file() and path.stat().st_size == 0:
        raise UserError(f"{path}: is empty; copy it from the recorder again")
    try:
        return _core.SonarLog(str(path), layback=layback)
    except OSError as error:
        raise UserError(str(error)) from error


def blocks(log: _core.SonarLog) -> Iterator[dict[str, Any]]:
    """Until the end of the log."""
    while (block := log.read(PINGS_PER_BLOCK)) is not None:
        yield block
