"""Rows of the submap, loop and configuration tables. Text is escaped where it enters the page, by the template."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ssjs_cli.report.map_figure import MapAxes, SubmapColours
from ssjs_cli.report.number_text import finite_number
from ssjs_cli.report.planar_shapes import ellipse_axes
from ssjs_cli.report.result_files import Submaps
from ssjs_cli.report.simplification import every_nth

MAX_REFUSED_ROWS = 1000
NOTHING = "–"
#: Absent numbers sort first; HTML knows no infinity.
BELOW_EVERY_NUMBER = -1e300


@dataclass(frozen=True)
class Cell:
    """text: what is shown; order: what a click on the column's head sorts by."""

    text: str
    order: float | str


@dataclass(frozen=True)
class Row:
    """x, y: where on the map, drawn coordinates; None when unknown."""

    cells: list[Cell]
    colour: str = ""
    x: float | None = None
    y: float | None = None
    refused: bool = False
    wrong: bool = False


def number_cell(value: Any, decimals: int, factor: float = 1.0) -> Cell:
    number = finite_number(value)
    if number is None:
        return Cell(NOTHING, BELOW_EVERY_NUMBER)
    return Cell(f"{factor * number:,.{decimals}f}", factor * number)


def text_cell(value: Any) -> Cell:
    text = "" if value is None else str(value)
    return Cell(text or NOTHING, text)


SUBMAP_COLUMNS = (
    "submap", "start [s]", "duration [s]", "landmarks", "live map", "base {0} [{2}]", "base {1} [{2}]", "heading [°]",
    "σ base [{2}]", "σ heading [°]", "closed because",
)  # fmt: skip
LOOP_COLUMNS = ("time [s]", "from", "to", "answer", "pairs", "wrong", "χ²", "dof", "χ² / dof", "reason")


def submap_columns(axes: MapAxes) -> list[str]:
    return [name.format(*axes.short_names, axes.short_unit) for name in SUBMAP_COLUMNS]


def submap_rows(submaps: Submaps, axes: MapAxes, colours: SubmapColours) -> list[Row]:
    rows = []
    for entry in submaps.submaps:
        x, y, heading = (float(value) for value in entry["base_pose"][:3])
        sigma_m, sigma_heading = _base_sigma(entry.get("base_covariance"))
        start_s, end_s = finite_number(entry.get("start_time_s")), finite_number(entry.get("end_time_s"))
        duration_s = None if start_s is None or end_s is None else end_s - start_s
        place = axes.drawn(np.array([x, y]))
        rows.append(
            Row(
                cells=[
                    Cell(str(int(entry["index"])), float(entry["index"])),
                    number_cell(start_s, 1),
                    number_cell(duration_s, 1),
                    number_cell(entry.get("landmarks"), 0),
                    number_cell(entry.get("live_map"), 0),
                    number_cell(x, 2),
                    number_cell(y, 2),
                    number_cell(math.degrees(heading), 1),
                    number_cell(sigma_m, 3),
                    number_cell(sigma_heading, 3, factor=180.0 / math.pi),
                    text_cell(entry.get("closed_because")),
                ],
                colour=colours.colour(int(entry["index"])),
                x=round(float(place[0]), 2),
                y=round(float(place[1]), 2),
            )
        )
    return rows


def _base_sigma(triangle: Any) -> tuple[float | None, float | None]:
    """Upper triangle xx xy xh yy yh hh -> one sigma along the major axis of the position (m), and of the heading (rad)."""
    if not isinstance(triangle, list) or len(triangle) != 6:
        return None, None
    values = [finite_number(value) for value in triangle]
    if any(value is None for value in values):
        return None, None
    numbers = [value for value in values if value is not None]
    half_axes, _ = ellipse_axes(np.array([[numbers[0], numbers[1], numbers[3]]]))
    return float(half_axes[0, 0]), math.sqrt(max(numbers[5], 0.0))


def loop_rows(submaps: Submaps, axes: MapAxes) -> tuple[list[Row], str]:
    """Accepted loops all, refused ones thinned to MAX_REFUSED_ROWS; and the sentence that says so."""
    refused = [loop for loop in submaps.loops if not loop.get("accepted")]
    chosen, stride = every_nth(len(refused), MAX_REFUSED_ROWS)
    shown = {id(refused[index]) for index in chosen}
    base = {int(entry["index"]): entry["base_pose"][:2] for entry in submaps.submaps}
    rows = []
    for loop in submaps.loops:
        accepted = bool(loop.get("accepted"))
        if not accepted and id(loop) not in shown:
            continue
        chi2, dof = finite_number(loop.get("chi2")), finite_number(loop.get("dof"))
        wrong = finite_number(loop.get("wrong_pairs"))
        ends = [base[end] for end in (loop.get("from"), loop.get("to")) if isinstance(end, int) and end in base]
        place = axes.drawn(np.array(ends, dtype=np.float64).mean(axis=0)) if ends else None
        rows.append(
            Row(
                cells=[
                    number_cell(loop.get("time_s"), 1),
                    number_cell(loop.get("from"), 0),
                    number_cell(loop.get("to"), 0),
                    Cell("joined" if accepted else "refused", "joined" if accepted else "refused"),
                    number_cell(loop.get("pairs"), 0),
                    number_cell(wrong, 0),
                    number_cell(chi2, 1),
                    number_cell(dof, 0),
                    number_cell(chi2 / dof if chi2 is not None and dof else None, 2),
                    text_cell(loop.get("reason")),
                ],
                x=None if place is None else round(float(place[0]), 2),
                y=None if place is None else round(float(place[1]), 2),
                refused=not accepted,
                wrong=bool(wrong),
            )
        )
    note = f"One refused pair in {stride} of {len(refused):,} is listed." if stride > 1 else ""
    return rows, note


@dataclass(frozen=True)
class Section:
    """One table of the configuration file: its dotted name and its keys."""

    name: str
    entries: list[tuple[str, str]]


def configuration_sections(config: dict[str, Any]) -> list[Section]:
    sections: list[Section] = []
    _collect(config, "", sections)
    return sections


def _collect(table: dict[str, Any], name: str, sections: list[Section]) -> None:
    plain = [(key, _value_text(value)) for key, value in table.items() if not isinstance(value, dict)]
    if plain:
        sections.append(Section(name, plain))
    for key, value in table.items():
        if isinstance(value, dict):
            _collect(value, f"{name}.{key}" if name else key, sections)


def _value_text(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return f"{value:.10g}"
    if isinstance(value, list):
        return ", ".join(_value_text(entry) for entry in value)
    return str(value)
