"""What a command has done that works through many images: one unusable image is named, the others are answered."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ssjs_cli.exit_codes import DONE, PARTLY_DONE
from ssjs_cli.session import Session

MAX_SHOWN = 20


@dataclass(frozen=True)
class Finished:
    """directory: with the result files; document: the main one of them; failures: name and reason of what could not be used."""

    directory: Path
    document: dict[str, Any]
    failures: Sequence[tuple[str, str]]


def note_losses(failures: Sequence[tuple[str, str]], session: Session) -> int:
    """Says what was unusable and gives the exit code."""
    for name, reason in failures[:MAX_SHOWN]:
        session.message(f"lost: {reason}" if name in reason else f"lost: {name}: {reason}")
    if len(failures) > MAX_SHOWN:
        session.message(f"lost: {len(failures) - MAX_SHOWN} more, listed in the result files")
    return PARTLY_DONE if failures else DONE
