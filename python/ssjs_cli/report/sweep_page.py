"""The report of a sweep: a curve over the threshold for every submap size."""

from typing import TYPE_CHECKING, Any

from ssjs_cli.report import figure_style as style
from ssjs_cli.report.figure_style import Figure, Trace
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
    ("nees_joint_per_dof", "Joint NEES of all bases", "NEES / dof [-]", "accuracy"),
)
DASHES = ("solid", "6px,4px", "2px,3px", "8px,3px,2px,3px")


def sweep_page(sweep: "Sweep") -> str:
    sections = {"cost": Section("cost-section", "Cost", []), "accuracy": Section("accuracy-section", "Accuracy", [])}
    for key, heading, axis, section in CURVES:
        figure = _curves(sweep, key, axis)
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
            (f"{cell['method']}, size {cell['submap_size']}, threshold {cell['fusion_threshold']:g}", cell["reason"])
            for cell in sweep.cells
            if cell["reason"]
        ],
    )
    colours = [_colour(sweep, cell["submap_size"]) for cell in sweep.cells]
    page.sheets.append(sheet("cells", "Every pair of values", CELL_SHEET, sweep.cells, colours=colours))
    return render_study(page)


def _colour(sweep: "Sweep", size: int) -> str:
    return PALETTE[sweep.sizes.index(size) % len(PALETTE)]


def _curves(sweep: "Sweep", key: str, axis: str) -> Figure | None:
    traces: list[Trace] = []
    for number, method in enumerate(sweep.methods):
        for size in sweep.sizes:
            cells: list[dict[str, Any]] = [
                cell for cell in sweep.cells if cell["method"] == method and cell["submap_size"] == size and cell[key] is not None
            ]
            if not cells:
                continue
            name = f"{size} landmarks" if len(sweep.methods) == 1 else f"{method}, {size} landmarks"
            hover = f"{name}, threshold %{{x:.2f}}: %{{y:.4g}}<extra></extra>"
            dash = {"dash": DASHES[number % len(DASHES)]}
            x, y = [cell["fusion_threshold"] for cell in cells], [cell[key] for cell in cells]
            line = style.line(x, y, name, _colour(sweep, size), 2.0, line=dash, hovertemplate=hover)
            traces.append({**line, "mode": "lines+markers", "marker": {"size": 7, "color": _colour(sweep, size)}})
    if not traces:
        return None
    low, high = min(sweep.thresholds), max(sweep.thresholds)
    margin = 0.04 * (high - low) if high > low else 0.05
    return {
        "data": traces,
        "layout": style.layout(
            340,
            xaxis=style.axis("fusion threshold [share of the newer submap]", range=[low - margin, high + margin]),
            yaxis=style.axis(axis, rangemode="tozero"),
        ),
    }
