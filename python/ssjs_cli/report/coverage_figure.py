"""Where the sonar has listened, how often, and where it has not."""

import io
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssjs_cli.report import figure_style as style
from ssjs_cli.report.error_figures import Drawing
from ssjs_cli.report.figure_style import Figure, Trace, listed
from ssjs_cli.report.map_figure import LINE_TOLERANCE_OF_EXTENT, MAX_TRACK_POINTS, MapAxes
from ssjs_cli.report.number_text import finite_number, percent_text
from ssjs_cli.report.page_parts import data_url
from ssjs_cli.report.result_files import RunFiles
from ssjs_cli.report.simplification import simplify_line
from ssjs_cli.report.survey_files import CoverageGrid

#: Passes 0 (transparent), 1, 2, 3 and more.
COLOURS = ((255, 255, 255, 0), (190, 220, 235, 255), (96, 165, 205, 255), (28, 95, 150, 255))
LABELS = ("heard once", "twice", "three times and more")
MOST_PIXELS_A_SIDE = 1400
CONTACT = "#e08a00"


def area_text(area_m2: float) -> str:
    """Hectares from 1 on, square kilometres from 100 ha on."""
    if area_m2 >= 1e6:
        return f"{area_m2 / 1e6:.3g} km²"
    return f"{area_m2 / 1e4:.3g} ha" if area_m2 >= 1e4 else f"{area_m2:,.0f} m²"


def coverage_notes(summary: dict[str, Any]) -> list[str]:
    covered, twice, surveyed = (
        finite_number(summary.get(key)) for key in ("coverage_area_m2", "coverage_area_twice_m2", "surveyed_area_m2")
    )
    share, twice_share = (finite_number(summary.get(key)) for key in ("coverage_fraction", "coverage_twice_fraction"))
    if covered is None or surveyed is None or share is None:
        return []
    notes = [
        f"{area_text(covered)} of seabed heard, {percent_text(share)} of the {area_text(surveyed)} that the convex hull around it holds"
    ]
    if twice is not None and twice_share is not None:
        notes[0] += f"; {area_text(twice)} ({percent_text(twice_share)}) in two passes or more"
    notes[0] += "."
    notes.append("White inside: not heard, such as the nadir below the track and the turns, where nothing is looked for.")
    return notes


def coverage_figure(files: RunFiles, axes: MapAxes) -> Drawing | None:
    grid = files.survey.coverage
    if grid is None or not grid.passes.size:
        return None
    extent_m = np.array(grid.passes.shape) * grid.cell_m
    low = axes.drawn(grid.corner_m)
    high = axes.drawn(grid.corner_m + extent_m)
    traces: list[Trace] = []
    for label, colour in zip(LABELS, COLOURS[1:], strict=True):
        traces.append({
            "type": "scatter", "mode": "markers", "x": [None], "y": [None], "name": label, "hoverinfo": "skip",
            "marker": {"size": 12, "symbol": "square", "color": "rgb({},{},{})".format(*colour[:3])},
        })  # fmt: skip
    if files.trajectory is not None:
        points = axes.drawn(files.trajectory.position)
        kept = simplify_line(points, MAX_TRACK_POINTS, float(extent_m.max()) * LINE_TOLERANCE_OF_EXTENT).indices
        traces.append(style.line(listed(points[kept, 0], 2), listed(points[kept, 1], 2), "final track", style.FINAL, 1.0, hoverinfo="skip"))
    traces += _contacts(files, axes)
    across_title, up_title = axes.titles()
    figure: Figure = {
        "data": traces,
        "layout": style.layout(
            560,
            images=[{
                "source": data_url(_picture(grid, axes)), "xref": "x", "yref": "y", "layer": "below", "sizing": "stretch",
                "x": round(float(low[0]), 3), "y": round(float(high[1]), 3),
                "sizex": round(float(high[0] - low[0]), 3), "sizey": round(float(high[1] - low[1]), 3),
            }],
            dragmode="pan",
            xaxis=style.axis(across_title, range=[round(float(low[0]), 2), round(float(high[0]), 2)], constrain="domain"),
            yaxis=style.axis(
                up_title, range=[round(float(low[1]), 2), round(float(high[1]), 2)], scaleanchor="x", scaleratio=1, constrain="domain"
            ),
        ),
    }  # fmt: skip
    return Drawing(figure, [*coverage_notes(files.summary), f"Cells of {grid.cell_m:g} m."])


def _picture(grid: CoverageGrid, axes: MapAxes) -> bytes:
    """PNG, up on paper at the top."""
    from PIL import Image

    # rows grow with x, columns with y
    on_paper: NDArray[np.int64] = grid.passes if axes.north_up else grid.passes.T
    stride = max(1, -(-max(on_paper.shape) // MOST_PIXELS_A_SIDE))
    levels = np.minimum(on_paper[::stride, ::stride], len(COLOURS) - 1)[::-1]
    image = Image.fromarray(np.ascontiguousarray(levels).astype(np.uint8))
    image = image.convert("P")
    image.putpalette([value for colour in COLOURS for value in colour[:3]])
    file = io.BytesIO()
    image.save(file, format="PNG", transparency=0, optimize=True)
    return file.getvalue()


def _contacts(files: RunFiles, axes: MapAxes) -> list[Trace]:
    if files.landmarks is None or not len(files.landmarks.id):
        return []
    points = axes.drawn(files.landmarks.position)
    return [{
        "type": "scatter", "mode": "markers", "name": "contacts", "x": listed(points[:, 0], 2), "y": listed(points[:, 1], 2),
        "marker": {"size": 6, "symbol": "circle", "color": CONTACT, "line": {"color": "#ffffff", "width": 0.8}},
        "text": [f"contact {number}" for number in files.landmarks.id], "hovertemplate": "%{text}<extra></extra>",
    }]  # fmt: skip
