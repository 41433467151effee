"""NEES and NIS over time: does the filter know how wrong it is? Each value against the 95 % band of its own degrees of freedom."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtr, chdtri

from ssjs_cli.report import figure_style as style
from ssjs_cli.report.figure_style import Figure, FloatArray, listed
from ssjs_cli.report.number_text import count_text
from ssjs_cli.report.result_files import Columns
from ssjs_cli.report.simplification import every_nth, span_edges

MAX_DOTS = 1800
MEAN_SPANS = 120
PERCENTILE_BINS = 20
LOW_TAIL = 0.025


@dataclass(frozen=True)
class Consistency:
    """Shares of the values inside, below and above their own two-sided 95 % band; mean of value / dof, 1 when the claim is true."""

    figure: Figure
    notes: list[str]
    count: int
    inside: float
    below: float
    above: float
    mean_per_dof: float
    dof_text: str


def consistency(table: Columns, quantity: str) -> Consistency | None:
    """quantity: "nees" or "nis", a column of the table. None without a usable row."""
    usable = np.isfinite(table[quantity]) & (table["dof"] > 0.0)
    time_s, value, dof = table["time_s"][usable], table[quantity][usable], table["dof"][usable]
    if len(time_s) < 2:
        return None
    lower, upper = chdtri(dof, 1.0 - LOW_TAIL), chdtri(dof, LOW_TAIL)
    below, above = value < lower, value > upper
    inside = ~(below | above)
    figure, notes = _draw(quantity.upper(), time_s, value, dof, inside)
    least, most = int(dof.min()), int(dof.max())
    return Consistency(
        figure=figure,
        notes=notes,
        count=len(value),
        inside=float(inside.mean()),
        below=float(below.mean()),
        above=float(above.mean()),
        mean_per_dof=float(value.sum() / dof.sum()),
        dof_text=f"{least}" if least == most else f"{least} to {most}",
    )


def _draw(label: str, time_s: FloatArray, value: FloatArray, dof: FloatArray, inside: NDArray[np.bool_]) -> tuple[Figure, list[str]]:
    per_dof = value / dof
    edges = span_edges(time_s, MEAN_SPANS)
    runs = list(zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True))
    middle_s = np.array([0.5 * (time_s[first] + time_s[end - 1]) for first, end in runs])
    middle_s[0], middle_s[-1] = time_s[0], time_s[-1]
    usual_dof = np.array([dof[first:end].mean() for first, end in runs])
    mean = np.array([value[first:end].sum() / dof[first:end].sum() for first, end in runs])
    band_low, band_high = chdtri(usual_dof, 1.0 - LOW_TAIL) / usual_dof, chdtri(usual_dof, LOW_TAIL) / usual_dof
    top = 1.05 * max(float(np.quantile(per_dof, 0.995)), 1.25 * float(band_high.max()), float(mean.max()))

    rows, stride = every_nth(len(value), MAX_DOTS)
    band_x = listed(middle_s, 2)
    traces = [
        {**style.line(band_x, listed(band_low, 4), "band", style.BAND, 0.8), "showlegend": False, "hoverinfo": "skip"},
        {**style.line(band_x, listed(band_high, 4), "95 % band", style.BAND, 0.8), "fill": "tonexty",
         "fillcolor": style.BAND_FILL, "hoverinfo": "skip"},
    ]  # fmt: skip
    for name, chosen, colour in (("inside", inside[rows], "#a9b8c8"), ("outside", ~inside[rows], "#e07f8c")):
        picked = rows[chosen]
        over = (per_dof[picked] > top).tolist()
        traces.append({
            "type": "scatter", "mode": "markers", "name": name,
            "x": listed(time_s[picked], 2), "y": listed(np.minimum(per_dof[picked], top), 4),
            "customdata": [[round(float(value[row]), 3), int(dof[row])] for row in picked],
            "marker": {"size": 3.5, "color": colour, "symbol": ["triangle-up" if high else "circle" for high in over]},
            "cliponaxis": False,
            "hovertemplate": f"{label} %{{customdata[0]:.2f}} at %{{customdata[1]}} dof<br>t = %{{x:.1f}} s<extra></extra>",
        })  # fmt: skip
    mean_hover = "mean %{y:.2f} near %{x:.0f} s<extra></extra>"
    traces.append(style.line(band_x, listed(mean, 4), "running mean", style.INK, 1.8, hovertemplate=mean_hover))

    # percentile of each value under its own chi-squared distribution: uniform when the claim is true
    share, _ = np.histogram(chdtr(dof, value), bins=PERCENTILE_BINS, range=(0.0, 1.0))
    centre = (np.arange(PERCENTILE_BINS) + 0.5) * 100.0 / PERCENTILE_BINS
    percent = 100.0 * share / len(value)
    expected = 100.0 / PERCENTILE_BINS
    traces.append({
        "type": "bar", "orientation": "v", "x": listed(centre, 2), "y": listed(percent, 3), "width": 0.86 * 100.0 / PERCENTILE_BINS,
        "marker": {"color": "#8fa3b8"}, "xaxis": "x2", "yaxis": "y2", "showlegend": False,
        "hovertemplate": "%{y:.1f} % of the values near the %{x:.0f} % percentile<extra></extra>",
    })  # fmt: skip
    traces.append({
        **style.line([0.0, 100.0], [expected, expected], "expected", style.BAND, 1.4, line={"dash": "dash"}),
        "xaxis": "x2", "yaxis": "y2", "showlegend": False, "hoverinfo": "skip",
    })  # fmt: skip
    figure: Figure = {
        "data": traces,
        "layout": style.layout(
            340,
            bargap=0.1,
            xaxis=style.axis("time [s]", range=[round(float(time_s[0]), 2), round(float(time_s[-1]), 2)], domain=[0.0, 0.74]),
            yaxis=style.axis(f"{label} / dof [-]", range=[0.0, round(top * 1.01, 4)]),
            xaxis2=style.axis("percentile [%]", domain=[0.82, 1.0], range=[0, 100], tickvals=[0, 50, 100], anchor="y2"),
            yaxis2=style.axis("share [%]", anchor="x2", range=[0.0, round(max(1.1 * float(percent.max()), 2.2 * expected), 2)]),
        ),
    }
    notes = []
    if dof.min() != dof.max():
        notes.append("The drawn band is that of the mean dof of its time span; the colour of a dot follows its own dof.")
    if stride > 1:
        notes.append(f"One value in {stride} of {count_text(len(value))} is drawn as a dot; band, mean and shares use every one.")
    over_count = int((per_dof > top).sum())
    if over_count:
        notes.append(f"{count_text(over_count)} values lie above the frame; those among the dots stand at its upper edge.")
    return figure, notes
