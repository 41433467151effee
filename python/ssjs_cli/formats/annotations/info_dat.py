"""OpenCV's list of positives: `path n x y w h ...`, one picture a line."""

import shlex
from pathlib import Path

from ssjs_cli.errors import UserError
from ssjs_cli.formats.annotations.boxes import LabelledBox, pixel_box, read_lines


def read_info_dat(path: Path) -> dict[str, list[LabelledBox]]:
    """By the path as it stands in the file. Paths with blanks stand in quotes."""
    images: dict[str, list[LabelledBox]] = {}
    for line_number, line in enumerate(read_lines(path), 1):
        where = f"{path}:{line_number}"
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        name, *numbers = _fields(line, where)
        if not numbers or not numbers[0].isdecimal():
            raise UserError(
                f"{where}: has no number of boxes after the path '{name}'; write `path n x y w h ...`, a path with blanks in quotes"
            )
        count = int(numbers[0])
        if len(numbers) - 1 != 4 * count:
            raise UserError(f"{where}: promises {count} boxes and holds {len(numbers) - 1} numbers, not {4 * count}; correct that line")
        boxes = [pixel_box(numbers[first : first + 4], where) for first in range(1, len(numbers), 4)]
        images.setdefault(name, []).extend(boxes)
    return images


def _fields(line: str, where: str) -> list[str]:
    if '"' not in line:
        return line.split()
    try:
        return shlex.split(line)
    except ValueError as error:
        raise UserError(f"{where}: a quote is not closed; correct that line") from error
