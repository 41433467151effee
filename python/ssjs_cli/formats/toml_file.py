"""TOML files with messages that name the file and the line."""

import tomllib
from pathlib import Path
from typing import Any

from ssjs_cli.errors import UserError

MAX_BYTES = 16 * 1024 * 1024


def load_toml(path: Path) -> dict[str, Any]:
    try:
        if path.stat().st_size > MAX_BYTES:
            raise UserError(f"{path}: holds more than the {MAX_BYTES} bytes that settings may; check that it is the right file")
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError as error:
        raise UserError(f"{path}: is missing; check the path") from error
    except UnicodeDecodeError as error:
        raise UserError(f"{path}: is not UTF-8 text (byte {error.start}); save it as UTF-8") from error
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise UserError(f"{path}: is not valid TOML: {error}; correct that line") from error
