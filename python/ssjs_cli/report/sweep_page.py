"""The report of a sweep: a curve over the threshold for every submap size."""

from typing import TYPE_CHECKING, Any

from ssjs_cli.methods import known_methods
from ssjs_cli.report import figure_style as style
from ssjs_cli.report.figure_style import Figure, Trace
from ssjs_cli.report.method_colours import method_colours
from ssjs_cli.report.page_parts import Plot
from ssjs_cli.report.sheet import SheetColumn, sheet
from ssjs_cli.report.study_page import Section, StudyPage, render_study, seeds_text
from ssjs_cli.report.submap_colours import PALETTE

if TYPE_CHECKING:
    from ssjs_cli.studies.sweep import Sweep

CELL_SHEET: tuple[SheetColumn, ...] = (
    ("method", "method", None, 1.0),
    ("submap_size", "submap size", 0, 1.0),
    ("fusion_threshold", "threshold", 2, 1.0),
    ("runs", "runs", 0, 1.0),
    ("time_total_s", "total [s]", 3, 1.0),
    ("time_local_s", "local [s]", 3, 1.0),
    ("time_association_s", "association [s]", 3, 1.0),
    ("time_global_s", "global [s]", 3, 1.0),
    ("loop_candidates", "pairs tested", 0, 1.0),
    ("fusions", "fusions", 0, 1.0),
    ("live_maps", "live maps", 0, 1.0),
    ("wrong_pairs", "wrong pairs", 1, 1.0),
    ("map_error_mean_m", "map mean [m]", 3, 1.0),
    ("map_error_max_m", "map max [m]", 3, 1.0),
    ("trajectory_rmse_m", "RMSE [m]", 3, 1.0),
    ("nees_joint_per_dof", "bases jointly / dof", 2, 1.0),
    ("nees_position_per_dof", "position / dof", 2, 1.0),
    ("inside_3_sigma_fraction", "within 3 σ [%]", 1, 100.0),
    ("inside_3_sigma_online_fraction", "online [%]", 1, 100.0),
    ("reason", "failed because", None, 1.0),
)
#: key, heading, axis, section
CURVES = (
    ("time_total_s", "Computing time", "time [s]", "cost"),
    ("loop_candidates", "Map pairs tested", "pairs [count]", "cost"),
    ("fusions", "Fusions", "fusions [count]", "cost"),
    ("live_maps", "Maps left in the end", "maps [count]", "cost"),
    ("map_error_mean_m", "Map error", "mean error [m]", "accuracy"),
    ("trajectory_rmse_m", "Trajectory RMSE", "RMSE [m]", "accuracy"),
    ("nees_joint_per_dof", "Joint NEES of all bases", "NEES / dof [-]", "consistency"),
    ("nees_position_per_dof", "NEES of the position", "NEES / dof [-]", "consistency"),
    ("inside_3_sigma_fraction", "Share of the mission inside three standard deviations", "share [-]", "consistency"),
    ("inside_3_sigma_online_fraction", "The same, of the online estimate", "share [-]", "consistency"),
)
DASHES = ("solid", "6px,4px", "2px,3px", "8px,3px,2px,3px")


def sweep_page(sweep: "Sweep") -> str:
    sections = {name: Section(f"{name}-section", name.capitalize(), []) for name in ("cost", "accuracy", "consistency")}
    for key, heading, axis, section in CURVES:
        figure = (_over_sizes if len(sweep.thresholds) == 1 and len(sweep.sizes) > 1 else _over_thresholds)(sweep, key, axis)
        if figure is None:
            continue
        notes = []
        if key == "time_total_s":
            side = {None: "on the workers of a scheduler", 1: "one run at a time"}.get(sweep.workers, f"{sweep.workers} runs side by side")
            notes = [f"Median over the runs of a cell; taken {side}."]
        sections[section].plots.append(Plot(key.replace("_", "-"), heading, figure, notes))
    page = StudyPage(
        kind="sweep of submap size and fusion threshold",
        title=sweep.scenario.name,
        subtitle=sweep.scenario.description,
        facts=[
            ("methods", ", ".join(sweep.methods)),
            ("runs a cell", str(len(sweep.seeds))),
            ("seeds", seeds_text(sweep.seeds)),
        ],
        sheets=[],
        sections=[section for section in sections.values() if section.plots],
        failures=[
            (f"{cell['method']}, size {cell['submap_size']:g}, threshold {cell['fusion_threshold']:g}", cell["reason"])
            for cell in sweep.cells
            if cell["reason"]
        ],
    )
    colours = [_colour(sweep, cell["submap_size"]) for cell in sweep.cells]
    page.sheets.append(sheet("cells", "Every pair of values", CELL_SHEET, sweep.cells, colours=colours))
    return render_study(page)


def _colour(sweep: "Sweep", size: float) -> str:
    return PALETTE[sweep.sizes.index(size) % len(PALETTE)]


def _over_thresholds(sweep: "Sweep", key: str, axis: str) -> Figure | None:
    traces: list[Trace] = []
    for number, method in enumerate(sweep.methods):
        for size in sweep.sizes:
            cells: list[dict[str, Any]] = [
                cell for cell in sweep.cells if cell["method"] == method and cell["submap_size"] == size and cell[key] is not None
            ]
            if not cells:
                continue
            name = f"{size:g} {sweep.axes.unit}" if len(sweep.methods) == 1 else f"{method}, {size:g} {sweep.axes.unit}"
            hover = f"{name}, threshold %{{x:.2f}}: %{{y:.4g}}<extra></extra>"
            x, y = [cell["fusion_threshold"] for cell in cells], [cell[key] for cell in cells]
            traces.append(_marked_line(x, y, name, _colour(sweep, size), DASHES[number % len(DASHES)], hover))
    if not traces:
        return None
    return _figure(traces, sweep.thresholds, "fusion threshold [share of the newer submap]", axis)


def _over_sizes(sweep: "Sweep", key: str, axis: str) -> Figure | None:
    """With one threshold a curve a method says more."""
    colours = method_colours(sweep.methods, known_methods())
    traces: list[Trace] = []
    for method in sweep.methods:
        cells = [cell for cell in sweep.cells if cell["method"] == method and cell[key] is not None]
        if not cells:
            continue
        x, y = [cell["submap_size"] for cell in cells], [cell[key] for cell in cells]
        hover = f"{method}, %{{x:g}} {sweep.axes.unit}: %{{y:.4g}}<extra></extra>"
        traces.append(_marked_line(x, y, method, colours[method], DASHES[0], hover))
    return _figure(traces, sweep.sizes, f"submap size [{sweep.axes.unit}]", axis) if traces else None


def _marked_line(x: list[float | None], y: list[float | None], name: str, colour: str, dash: str, hover: str) -> Trace:
    line = style.line(x, y, name, colour, 2.0, line={"dash": dash}, hovertemplate=hover)
    return {**line, "mode": "lines+markers", "marker": {"size": 7, "color": colour}}


def _figure(traces: list[Trace], values: list[float], title: str, axis: str) -> Figure:
    low, high = min(values), max(values)
    margin = 0.04 * (high - low) if high > low else 0.05
    xaxis = style.axis(title, range=[low - margin, high + margin])
    return {"data": traces, "layout": style.layout(340, xaxis=xaxis, yaxis=style.axis(axis, rangemode="tozero"))}
