"""The page of a study: tables of all its rows, then sections of figures."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from ssjs_cli.report.map_figure import Layer
from ssjs_cli.report.page_parts import Plot, render
from ssjs_cli.report.sheet import Sheet

GATE_NOTE = "Association by gates cuts off the tail of the distribution, so that the mean of a good filter lies a few per cent below 1."


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
