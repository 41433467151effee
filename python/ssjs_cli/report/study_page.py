"""The page of a study: tables of all its rows, then sections of figures."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from ssjs_cli.report.map_figure import Layer
from ssjs_cli.report.page_parts import Plot, render
from ssjs_cli.report.tables import Cell, Row, number_cell, text_cell

#: key, heading, decimals (None for text), factor
SheetColumn = tuple[str, str, int | None, float]

GATE_NOTE = "Association by gates cuts off the tail of the distribution, so that the mean of a good filter lies a few per cent below 1."


@dataclass(frozen=True)
class Sheet:
    """swatch: the first column shows the colour of its row."""

    id: str
    heading: str
    columns: list[str]
    rows: list[Row]
    note: str = ""
    swatch: bool = False


@dataclass(frozen=True)
class Section:
    id: str
    heading: str
    plots: list[Plot]


@dataclass
class StudyPage:
    kind: str
    title: str
    facts: list[tuple[str, str]]
    sheets: list[Sheet]
    sections: list[Section]
    subtitle: str = ""
    failures: list[tuple[str, str]] = field(default_factory=list)
    layers: list[Layer] = field(default_factory=list)


def sheet(
    sheet_id: str,
    heading: str,
    columns: Sequence[SheetColumn],
    rows: Sequence[dict[str, object]],
    *,
    colours: Sequence[str] = (),
    note: str = "",
) -> Sheet:
    """Columns in which no row has a value are left out."""
    shown = [column for column in columns if any(row.get(column[0]) is not None for row in rows)]
    made = []
    for position, row in enumerate(rows):
        cells: list[Cell] = []
        for key, _, decimals, factor in shown:
            cells.append(text_cell(row.get(key)) if decimals is None else number_cell(row.get(key), decimals, factor))
        made.append(Row(cells, colour=colours[position] if colours else "", refused=bool(row.get("reason"))))
    return Sheet(sheet_id, heading, [column[1] for column in shown], made, note, bool(colours))


def seeds_text(seeds: Sequence[int]) -> str:
    return str(seeds[0]) if len(seeds) == 1 else f"{seeds[0]} to {seeds[-1]}"


def render_study(page: StudyPage) -> str:
    plots = [plot for section in page.sections for plot in section.plots]
    return render(
        "study.html.j2",
        {
            "figures": {plot.div_id: plot.figure for plot in plots if plot.figure is not None},
            "layers": {layer.key: layer.traces for layer in page.layers},
        },
        ("sorted_tables.js", "plots.js", "study.js"),
        kind=page.kind,
        title=page.title,
        subtitle=page.subtitle,
        facts=page.facts,
        failures=page.failures,
        sheets=[entry for entry in page.sheets if entry.rows],
        sections=page.sections,
        layers=page.layers,
    )
