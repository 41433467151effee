"""Time per step: the usual, the rare and the worst."""

import itertools
import math
from dataclasses import dataclass

import numpy as np

from ssjs_cli.report import figure_style as style
from ssjs_cli.report.figure_style import Figure, FloatArray, Trace, listed
from ssjs_cli.report.number_text import count_text, seconds_text
from ssjs_cli.report.result_files import Columns
from ssjs_cli.report.simplification import span_edges

HISTOGRAM_BINS = 70
SPANS = 300
QUANTILES = ((0.5, "median"), (0.9, "90 %"), (0.99, "99 %"), (0.999, "99.9 %"), (1.0, "largest"))


@dataclass(frozen=True)
class StepTimes:
    """quantiles: name and time as text, over every step."""

    histogram: Figure
    over_time: Figure
    quantiles: list[tuple[str, str]]
    notes: list[str]


def step_times(table: Columns) -> StepTimes | None:
    """None without a usable row. Times of 0 us (below the clock's resolution) are drawn at the smallest time above 0."""
    usable = np.isfinite(table["step_time_us"])
    time_s, step_us = table["time_s"][usable], table["step_time_us"][usable]
    positive = step_us[step_us > 0.0]
    if len(positive) < 2:
        return None
    drawn_us = np.maximum(step_us, float(positive.min()))
    quantiles = [(name, seconds_text(1e-6 * float(np.quantile(step_us, share)))) for share, name in QUANTILES]
    spans = len(span_edges(time_s, SPANS)) - 1
    note = f"Over time: median, 99 % quantile and largest of {count_text(len(step_us))} steps in each of {spans} equal time spans."
    return StepTimes(_histogram(drawn_us), _over_time(time_s, drawn_us), quantiles, [note])


def _decade_ticks(low: float, high: float) -> tuple[list[float], list[str]]:
    """Whole decades of microseconds that cover low..high (log10), with their text."""
    decades = list(range(math.floor(low), math.ceil(high) + 1))
    return [float(decade) for decade in decades], [seconds_text(10.0 ** (decade - 6)) for decade in decades]


def _histogram(step_us: FloatArray) -> Figure:
    decade = np.log10(step_us)
    low, high = float(decade.min()), float(decade.max())
    if high - low < 0.1:
        low, high = low - 0.05, high + 0.05
    count, edges = np.histogram(decade, bins=HISTOGRAM_BINS, range=(low, high))
    centre = 0.5 * (edges[:-1] + edges[1:])
    width = float(edges[1] - edges[0])
    edge_texts = [seconds_text(1e-6 * 10.0 ** float(edge)) for edge in edges]
    texts = [f"{first} to {last}" for first, last in itertools.pairwise(edge_texts)]
    traces: list[Trace] = [{
        "type": "bar", "x": listed(centre, 4), "y": count.tolist(), "width": 0.92 * width, "marker": {"color": "#6f8fb3"},
        "text": texts, "textposition": "none", "hovertemplate": "%{text}: %{y:,} steps<extra></extra>", "showlegend": False,
    }]  # fmt: skip
    shapes, annotations = [], []
    previous = -math.inf
    for share, name in ((0.5, "median"), (0.99, "99 %"), (1.0, "largest")):
        place = round(math.log10(float(np.quantile(step_us, share))), 4)
        shapes.append({
            "type": "line", "x0": place, "x1": place, "y0": 0, "y1": 1, "yref": "paper",
            "line": {"color": style.OUTSIDE, "width": 1.2, "dash": "dot"},
        })  # fmt: skip
        # a label too close to the one before would cover it; the same number stands above the figure
        room = place - previous > (0.3 if share == 1.0 else 0.2) * (high - low)
        previous = place
        if not room:
            continue
        annotations.append({
            "x": place, "y": 1.0, "yref": "paper", "yanchor": "bottom", "showarrow": False, "font": {"size": 11, "color": style.OUTSIDE},
            "text": f"{name} {seconds_text(1e-6 * 10.0 ** place)}", "xanchor": "right" if share == 1.0 else "center",
        })  # fmt: skip
    values, texts = _decade_ticks(low, high)
    return {
        "data": traces,
        "layout": style.layout(
            300,
            bargap=0.05,
            shapes=shapes,
            annotations=annotations,
            xaxis=style.axis(
                "time per step [as marked]", tickvals=values, ticktext=texts, range=[round(low - width, 4), round(high + width, 4)]
            ),
            yaxis=style.axis("steps [count, log scale]", type="log", dtick=1),
        ),
    }


def _over_time(time_s: FloatArray, step_us: FloatArray) -> Figure:
    edges = span_edges(time_s, SPANS)
    runs = list(zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True))
    middle_s = listed(np.array([0.5 * (time_s[first] + time_s[end - 1]) for first, end in runs]), 2)
    traces: list[Trace] = []
    for share, name, colour, width_px in (
        (1.0, "largest", "#e4a3ab", 1.0),
        (0.99, "99 % quantile", style.OUTSIDE, 1.2),
        (0.5, "median", style.INK, 1.8),
    ):
        value = np.array([np.quantile(step_us[first:end], share) for first, end in runs])
        texts = [seconds_text(1e-6 * float(entry)) for entry in value]
        hover = f"{name} %{{text}} near %{{x:.0f}} s<extra></extra>"
        traces.append(style.line(middle_s, listed(value, 3), name, colour, width_px, text=texts, hovertemplate=hover))
    low, high = math.log10(float(step_us.min())), math.log10(float(step_us.max()))
    values, texts = _decade_ticks(low, high)
    return {
        "data": traces,
        "layout": style.layout(
            300,
            xaxis=style.axis("time [s]", range=[round(float(time_s[0]), 2), round(float(time_s[-1]), 2)]),
            yaxis=style.axis("time per step [as marked]", type="log", tickvals=[10.0**value for value in values], ticktext=texts),
        ),
    }
