"""Tables of a page, made from rows of results."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ssjs_cli.report.tables import Cell, Row, number_cell, text_cell

#: Instead of decimals: the number is a name, without separators.
NAME = -1
#: key, heading, decimals (None for text, NAME), factor
SheetColumn = tuple[str, str, int | None, float]


@dataclass(frozen=True)
class Sheet:
    """swatch: the first column shows the colour of its row; in_overview: at the top of the page, not in a section of its own."""

    id: str
    heading: str
    columns: list[str]
    rows: list[Row]
    note: str = ""
    swatch: bool = False
    in_overview: bool = True


def sheet(
    sheet_id: str,
    heading: str,
    columns: Sequence[SheetColumn],
    rows: Sequence[Mapping[str, Any]],
    *,
    colours: Sequence[str] = (),
    note: str = "",
    in_overview: bool = True,
) -> Sheet:
    """Columns in which no row has a value are left out; rows with a `reason` are marked."""
    shown = [column for column in columns if any(row.get(column[0]) is not None for row in rows)]
    made = []
    for position, row in enumerate(rows):
        cells: list[Cell] = []
        for key, _, decimals, factor in shown:
            cells.append(_cell(row.get(key), decimals, factor))
        made.append(Row(cells, colour=colours[position] if colours else "", refused=bool(row.get("reason"))))
    return Sheet(sheet_id, heading, [column[1] for column in shown], made, note, bool(colours), in_overview)


def _cell(value: Any, decimals: int | None, factor: float) -> Cell:
    if decimals is None:
        return text_cell(value)
    if decimals == NAME:
        cell = number_cell(value, 0)
        return Cell(cell.text.replace(",", ""), cell.order)
    return number_cell(value, decimals, factor)
