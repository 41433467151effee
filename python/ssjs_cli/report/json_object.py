"""What a run left as one JSON object, read back."""

import json
from pathlib import Path
from typing import Any

from ssjs_cli.errors import UserError

RUN_AGAIN = "run the mission again"


def read_json_object(path: Path) -> dict[str, Any] | None:
    """None where there is no such file."""
    if not path.is_file():
        return None
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise UserError(f"{path}: is not a JSON document ({error}); {RUN_AGAIN}") from error
    if not isinstance(document, dict):
        raise UserError(f"{path}: must hold one JSON object; {RUN_AGAIN}")
    return document
