"""One look for every figure: colours, axes, and the JSON form of arrays. A figure is plotly's own {"data": [...], "layout": {...}}."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Figure = dict[str, Any]
Trace = dict[str, Any]
FloatArray = NDArray[np.float64]
IndexArray = NDArray[np.int64]

INK = "#14213d"
GRID = "rgba(20,33,61,0.08)"
AXIS_LINE = "#b8c2cc"
MUTED = "#66717e"
FINAL = "#14213d"
ONLINE = "#e4572e"
DEAD_RECKONING = "#9aa3ad"
REFERENCE = "#2a9d55"
LOOP = "#b5179e"
REFUSED = "#c98a04"
BAND = "#2a6fbb"
BAND_FILL = "rgba(42,111,187,0.10)"
OUTSIDE = "#d1495b"
FONT = "Inter, 'Helvetica Neue', Helvetica, Arial, sans-serif"


def listed(values: FloatArray, decimals: int) -> list[float | None]:
    """Rounded values for JSON; NaN and infinities become null, which plotly draws as a gap."""
    rounded = np.round(values, decimals) + 0.0
    return [value if keep else None for value, keep in zip(rounded.tolist(), np.isfinite(rounded).tolist(), strict=True)]


def axis(title: str, **more: Any) -> dict[str, Any]:
    """title: quantity and unit, such as "time [s]"."""
    return {
        "title": {"text": title, "standoff": 8, "font": {"size": 12, "color": MUTED}},
        "gridcolor": GRID,
        "linecolor": AXIS_LINE,
        "showline": True,
        "zeroline": False,
        "ticks": "outside",
        "ticklen": 4,
        "tickcolor": AXIS_LINE,
        "tickfont": {"size": 11, "color": MUTED},
        "automargin": True,
        "exponentformat": "none",
        "separatethousands": True,
        **more,
    }


def layout(height_px: int, **more: Any) -> dict[str, Any]:
    return {
        "height": height_px,
        "autosize": True,
        "margin": {"l": 64, "r": 16, "t": 34, "b": 52},
        "paper_bgcolor": "#ffffff",
        "plot_bgcolor": "#ffffff",
        "font": {"family": FONT, "size": 12, "color": INK},
        "hoverlabel": {"bgcolor": "#ffffff", "bordercolor": AXIS_LINE, "font": {"family": FONT, "size": 12, "color": INK}, "align": "left"},
        "hovermode": "closest",
        "modebar": {"bgcolor": "rgba(255,255,255,0.85)", "color": DEAD_RECKONING, "activecolor": INK},
        "legend": {
            "orientation": "h", "x": 0, "xanchor": "left", "y": 1.0, "yanchor": "bottom", "traceorder": "normal", "font": {"size": 12},
            "bgcolor": "rgba(0,0,0,0)",
        },
        **more,
    }  # fmt: skip


def line(x: list[float | None], y: list[float | None], name: str, colour: str, width_px: float = 1.5, **more: Any) -> Trace:
    style = {"color": colour, "width": width_px, **more.pop("line", {})}
    return {"type": "scatter", "mode": "lines", "x": x, "y": y, "name": name, "line": style, **more}


def band(x: list[float | None], low: list[float | None], high: list[float | None], name: str, **more: Any) -> Trace:
    """The area between two curves over the same x, one closed outline for each stretch without a gap (null)."""
    outline_x: list[float | None] = []
    outline_y: list[float | None] = []
    start = 0
    for end in [*(row for row, value in enumerate(x) if value is None), len(x)]:
        if end > start:
            outline_x += [*x[start:end], *x[start:end][::-1], None]
            outline_y += [*high[start:end], *low[start:end][::-1], None]
        start = end + 1
    area = line(outline_x, outline_y, name, BAND, 0.0, fill="toself", fillcolor=BAND_FILL, hoverinfo="skip")
    return {**area, **more}


def with_gaps(time_s: FloatArray, value: FloatArray, rows: IndexArray) -> tuple[FloatArray, FloatArray]:
    """The chosen rows (ascending) with a NaN between two of them wherever the file has a gap: a row more than 20 usual intervals, and
    2 s, after the one before. Nothing is drawn across a time without data."""
    if len(time_s) < 3:
        return time_s[rows], value[rows]
    interval_s = np.diff(time_s, prepend=time_s[0])
    gaps_before = np.cumsum(interval_s > max(20.0 * float(np.median(interval_s[1:])), 2.0))
    breaks = np.flatnonzero(np.diff(gaps_before[rows])) + 1
    return np.insert(time_s[rows], breaks, np.nan), np.insert(value[rows], breaks, np.nan)


def marker_size(count: int, usual: float) -> float:
    """Of marks on a figure: thousands of them are drawn smaller, or they hide each other."""
    return usual if count <= 300 else round(0.55 * usual, 2)
