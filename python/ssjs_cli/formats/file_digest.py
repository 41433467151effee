"""What tells one file's content from another's."""

import hashlib
from pathlib import Path


def file_digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
