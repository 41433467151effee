"""What the pages about cascades are made of: facts, tables, plots, and groups of small pictures. One file, offline."""

from dataclasses import dataclass, field

from ssjs_cli.report.page_parts import data_url, render, shown_failures
from ssjs_cli.report.sheet import Sheet
from ssjs_cli.report.study_page import Section
from ssjs_cli.segmentation.contact_sheet import png_bytes
from ssjs_cli.segmentation.pictures import Pixels


@dataclass(frozen=True)
class Card:
    """picture: as a data URL; lines: below it, the first one is its title."""

    picture: str
    lines: list[str]


@dataclass(frozen=True)
class CardGroup:
    id: str
    heading: str
    cards: list[Card]
    note: str = ""
    card_px: int = 150


@dataclass
class CascadePage:
    kind: str
    title: str
    facts: list[tuple[str, str]]
    sheets: list[Sheet] = field(default_factory=list)
    sections: list[Section] = field(default_factory=list)
    groups: list[CardGroup] = field(default_factory=list)
    subtitle: str = ""
    failures: list[tuple[str, str]] = field(default_factory=list)


def card(pixels: Pixels, *lines: str) -> Card:
    return Card(data_url(png_bytes(pixels)), list(lines))


def render_cascade(page: CascadePage) -> str:
    plots = [plot for section in page.sections for plot in section.plots]
    figures = {plot.div_id: plot.figure for plot in plots if plot.figure is not None}
    return render(
        "cascade.html.j2",
        {"figures": figures, "layers": {}},
        ("sorted_tables.js", "plots.js", "cascade.js"),
        styles=("report.css", "cards.css"),
        with_plots=bool(figures),
        kind=page.kind,
        title=page.title,
        subtitle=page.subtitle,
        facts=page.facts,
        failures=shown_failures(page.failures),
        sheets=[sheet for sheet in page.sheets if sheet.rows],
        sections=page.sections,
        groups=[group for group in page.groups if group.cards],
    )
