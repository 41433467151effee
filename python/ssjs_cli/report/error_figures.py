"""Error over time against the reference, with the three-sigma the filter claimed."""

import html
from dataclasses import dataclass
from typing import Any

import numpy as np

from ssjs_cli.report import figure_style as style
from ssjs_cli.report.figure_style import Figure, FloatArray, Trace, listed, with_gaps
from ssjs_cli.report.number_text import count_text, metres_text, percent_text
from ssjs_cli.report.result_files import Columns
from ssjs_cli.report.simplification import every_nth, keep_extremes

#: One span per screen column of a wide page; each keeps at most four rows.
SPANS = 700
MAX_OUTLIERS = 600
#: Share of a Gaussian error inside three sigma, per axis.
EXPECTED_INSIDE_THREE_SIGMA = 0.9973


@dataclass(frozen=True)
class Drawing:
    figure: Figure
    notes: list[str]


def _curve(time_s: FloatArray, value: FloatArray, name: str, colour: str, width_px: float, **more: Any) -> Trace:
    time_drawn, value_drawn = with_gaps(time_s, value, keep_extremes(time_s, value, SPANS))
    return style.line(listed(time_drawn, 2), listed(value_drawn, 4), name, colour, width_px, **more)


def _trusted(errors: Columns) -> Columns:
    """Rows that count: not flagged as reference outliers, with a finite error."""
    keep = (errors["is_outlier"] == 0.0) & np.isfinite(errors["error_m"])
    return {name: column[keep] for name, column in errors.items()}


def position_error(errors: Columns, errors_online: Columns | None) -> Drawing | None:
    """|error| of the final and the online estimate with three times the claimed sigma along the major axis. None without a usable row."""
    trusted = _trusted(errors)
    time_s = trusted["time_s"]
    if len(time_s) < 2:
        return None
    three_sigma = 3.0 * trusted["sigma_major_m"]
    traces: list[Trace] = []
    if np.isfinite(three_sigma).all():
        claimed = _curve(
            time_s, three_sigma, "3σ claimed, major axis", style.BAND, 1.0, hovertemplate="3σ %{y:.3f} m at %{x:.1f} s<extra></extra>",
        )  # fmt: skip
        zero = [None if value is None else 0.0 for value in claimed["y"]]
        traces += [style.band(claimed["x"], zero, claimed["y"], "3σ", showlegend=False), claimed]
    if errors_online is not None:
        online = _trusted(errors_online)
        if len(online["time_s"]) >= 2:
            traces.append(_curve(
                online["time_s"], online["error_m"], "online error", style.ONLINE, 1.0,
                hovertemplate="online %{y:.3f} m at %{x:.1f} s<extra></extra>",
            ))  # fmt: skip
    traces.append(_curve(
        time_s, trusted["error_m"], "final error", style.FINAL, 1.4, hovertemplate="final %{y:.3f} m at %{x:.1f} s<extra></extra>",
    ))  # fmt: skip
    top_m = 1.08 * max(float(np.nanmax(np.array([value for value in trace["y"] if value is not None]))) for trace in traces)
    notes = [f"The largest final error is {metres_text(float(trusted['error_m'].max()))}."]
    if len(time_s) > 4 * SPANS:
        rows_text = count_text(len(time_s))
        notes.append(
            f"Curves show the first, last, lowest and highest of {rows_text} rows in each of {SPANS} equal time spans: no peak is lost."
        )
    outlier = (errors["is_outlier"] != 0.0) & np.isfinite(errors["error_m"])
    if outlier.any():
        times, values = errors["time_s"][outlier], errors["error_m"][outlier]
        rows, stride = every_nth(len(times), MAX_OUTLIERS)
        traces.append({
            "type": "scatter", "mode": "markers", "name": "reference outlier", "cliponaxis": False,
            "x": listed(times[rows], 2), "y": listed(np.minimum(values[rows], top_m), 3), "customdata": listed(values[rows], 2),
            "marker": {"symbol": "triangle-up", "size": 8, "color": style.OUTSIDE},
            "hovertemplate": "outlier: %{customdata:.1f} m at %{x:.1f} s<extra></extra>",
        })  # fmt: skip
        which = "" if stride == 1 else f", one in {stride} drawn"
        notes.append(
            f"{count_text(int(outlier.sum()))} reference outliers are left out of every statistic{which}; "
            "those above the frame are drawn at its upper edge, their size is in the hover."
        )
    figure: Figure = {
        "data": traces,
        "layout": style.layout(
            330,
            xaxis=style.axis("time [s]", range=[round(float(time_s[0]), 2), round(float(time_s[-1]), 2)]),
            yaxis=style.axis("position error [m]", range=[0.0, round(top_m, 4)]),
        ),
    }
    return Drawing(figure, notes)


def axis_errors(errors: Columns, names: tuple[str, str]) -> Drawing | None:
    """Signed error along both axes, each inside its own band of three claimed sigma. None without sigma or rows."""
    trusted = _trusted(errors)
    time_s = trusted["time_s"]
    columns = (("error_x_m", "sigma_x_m"), ("error_y_m", "sigma_y_m"))
    if len(time_s) < 2 or not all(np.isfinite(trusted[name]).all() for pair in columns for name in pair):
        return None
    traces: list[Trace] = []
    inside: list[str] = []
    for number, ((error_name, sigma_name), axis_name) in enumerate(zip(columns, names, strict=True)):
        error, three_sigma = trusted[error_name], 3.0 * trusted[sigma_name]
        place = {} if number == 0 else {"yaxis": "y2"}
        drawn_name = html.escape(axis_name)
        shown = number == 0
        upper = _curve(time_s, three_sigma, "±3σ claimed", style.BAND, 0.8, showlegend=False, legendgroup="band", hoverinfo="skip", **place)
        lower = {**upper, "y": [None if value is None else -value for value in upper["y"]], "showlegend": shown}
        area = style.band(upper["x"], lower["y"], upper["y"], "±3σ", showlegend=False, legendgroup="band", **place)
        traces += [area, upper, lower]
        traces.append(_curve(
            time_s, error, "final error", style.FINAL, 1.2, showlegend=shown, legendgroup="error",
            hovertemplate=f"{drawn_name} error %{{y:.3f}} m at %{{x:.1f}} s<extra></extra>", **place,
        ))  # fmt: skip
        inside.append(f"{percent_text(float(np.mean(np.abs(error) <= three_sigma)))} along {axis_name}")
    figure: Figure = {
        "data": traces,
        "layout": style.layout(
            430,
            xaxis=style.axis("time [s]", range=[round(float(time_s[0]), 2), round(float(time_s[-1]), 2)], anchor="y2"),
            yaxis=style.axis(f"{html.escape(_short(names[0]))} error [m]", domain=[0.54, 1.0]),
            yaxis2=style.axis(f"{html.escape(_short(names[1]))} error [m]", domain=[0.0, 0.46], anchor="x"),
        ),
    }
    return Drawing(figure, [f"Inside ±3σ: {inside[0]}, {inside[1]}; {percent_text(EXPECTED_INSIDE_THREE_SIGMA)} expected."])


def _short(name: str) -> str:
    """ "x" of "x, ahead at the start": half the height of the figure has no room for more."""
    return name.split(",")[0]
