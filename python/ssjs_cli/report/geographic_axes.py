"""Longitude above the map and latitude to its right, where the mission has a place on earth and its axes point north and east.

Over a survey a degree is a fixed number of metres: at 5 km from the origin and 45 degrees of latitude the label of a tick is 4 m off."""

from typing import Any

import numpy as np
from pydantic import ValidationError

from ssjs_cli.formats.geographic import to_longitude_latitude
from ssjs_cli.formats.mission import Geodetic
from ssjs_cli.report import figure_style as style
from ssjs_cli.report.figure_style import Figure
from ssjs_cli.report.map_figure import MapAxes

ALIGNED_WITHIN_DEG = 1e-6
STEP_M = 1000.0


def origin_of(summary: dict[str, Any]) -> Geodetic | None:
    entry = summary.get("geodetic")
    if not isinstance(entry, dict):
        return None
    try:
        return Geodetic.model_validate(entry)
    except ValidationError:
        return None


def add_geographic_axes(figure: Figure, summary: dict[str, Any], axes: MapAxes) -> bool:
    """Whether there was an origin to add them from. The page keeps them in step with the metres, by layout.meta."""
    origin = origin_of(summary)
    if origin is None or not _drawn_north_up(origin, axes):
        return False
    # one step along each drawn axis
    drawn = np.array([[0.0, 0.0], [STEP_M, 0.0], [0.0, STEP_M]])
    places = to_longitude_latitude(drawn[:, ::-1] if axes.north_up else drawn, origin)
    longitude = [float(places[0, 0]), float((places[1, 0] - places[0, 0]) / STEP_M)]
    latitude = [float(places[0, 1]), float((places[2, 1] - places[0, 1]) / STEP_M)]
    layout = figure["layout"]
    ranges = {name: layout[name]["range"] for name in ("xaxis", "yaxis")}
    layout["xaxis2"] = _axis("longitude [°]", [longitude[0] + longitude[1] * end for end in ranges["xaxis"]], overlaying="x", side="top")
    layout["yaxis2"] = _axis("latitude [°]", [latitude[0] + latitude[1] * end for end in ranges["yaxis"]], overlaying="y", side="right")
    layout["meta"] = {"degrees": {"xaxis": longitude, "yaxis": latitude}}
    layout["margin"] = {**layout["margin"], "t": 52, "r": 84}
    # an axis without a trace is not drawn
    figure["data"].append({
        "type": "scatter", "mode": "markers", "x": [longitude[0]], "y": [latitude[0]], "xaxis": "x2", "yaxis": "y2", "showlegend": False,
        "hoverinfo": "skip", "marker": {"opacity": 0.0},
    })  # fmt: skip
    return True


def _drawn_north_up(origin: Geodetic, axes: MapAxes) -> bool:
    """North and east along the drawn axes: x north and y east (to its right), or x east and y north (to its left)."""
    heading = origin.heading_deg % 360.0
    wanted, side = (0.0, "right") if axes.north_up else (90.0, "left")
    return abs(heading - wanted) < ALIGNED_WITHIN_DEG and origin.y_axis == side


def _axis(title: str, ends: list[float], **more: Any) -> dict[str, Any]:
    return {**style.axis(title, range=ends, nticks=7, showgrid=False, fixedrange=True), "separatethousands": False, **more}
