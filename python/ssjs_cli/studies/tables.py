"""The tables of a study: JSON and CSV for programs, columns of text for the terminal."""

import csv
import io
import json
import shutil
import sys
from collections.abc import Mapping, Sequence
from typing import Any

UNKNOWN = "–"
#: Where the output is no terminal nothing is folded.
PLAIN_WIDTH = 200


def json_text(document: Mapping[str, Any]) -> str:
    return json.dumps(document, indent=2, allow_nan=False) + "\n"


def csv_text(keys: Sequence[str], rows: Sequence[Mapping[str, Any]]) -> str:
    """One line a row; what is unknown stays empty."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(keys)
    for row in rows:
        writer.writerow(["" if row.get(key) is None else _field(row[key]) for key in keys])
    return text.getvalue()


def _field(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(value) if isinstance(value, float) else str(value)


Column = tuple[str, str, str]  # key, heading, format of a number ("" for text)


def terminal_table(title: str, columns: Sequence[Column], rows: Sequence[Mapping[str, Any]]) -> str:
    """Columns in which no row has a value are left out."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    shown = [column for column in columns if any(row.get(column[0]) is not None for row in rows)]
    table = Table(box=None, pad_edge=False, header_style="dim")
    for _, heading, number_format in shown:
        table.add_column(heading, justify="right" if number_format else "left", no_wrap=bool(number_format))
    for row in rows:
        table.add_row(*(Text(number_text(row.get(key), number_format)) for key, _, number_format in shown))
    width = shutil.get_terminal_size().columns if sys.stdout.isatty() else PLAIN_WIDTH
    console = Console(file=io.StringIO(), width=width, force_terminal=False, color_system=None)
    with console.capture() as captured:
        console.print(table)
    return "\n".join([title, *(line.rstrip() for line in captured.get().splitlines())])


def number_text(value: Any, number_format: str) -> str:
    if value is None:
        return UNKNOWN
    return format(value, number_format) if number_format else str(value)
