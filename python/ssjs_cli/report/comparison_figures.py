"""The curves of several methods in one frame: time spent, where it went, error, consistency, and the maps."""

import html
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.special import chdtri

from ssjs_cli.report import figure_style as style
from ssjs_cli.report.figure_style import Figure, Trace, listed
from ssjs_cli.report.headline import TIME_PARTS
from ssjs_cli.report.map_figure import Layer
from ssjs_cli.report.number_text import finite_number, seconds_text

LOW_TAIL = 0.025
NO_VALUE = None


@dataclass(frozen=True)
class MethodCurves:
    """record: what the study kept of one run of the method; numbers: its row of the table."""

    method: str
    colour: str
    record: Mapping[str, Any]
    numbers: Mapping[str, Any]


@dataclass
class MapOfMethods:
    figure: Figure
    layers: list[Layer] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


def cumulative_time(methods: Sequence[MethodCurves]) -> Figure | None:
    traces = [
        style.line(
            entry.record["time"]["time_s"], entry.record["time"]["spent_s"], entry.method, entry.colour, 1.8,
            hovertemplate=f"{entry.method}: %{{y:.3g}} s spent by %{{x:.0f}} s<extra></extra>",
        )
        for entry in methods
        if entry.record.get("time")
    ]  # fmt: skip
    if not traces:
        return None
    return {
        "data": traces,
        "layout": style.layout(
            380, xaxis=style.axis("mission time [s]", range=_span(traces)), yaxis=style.axis("computing time [s]", rangemode="tozero")
        ),
    }


def time_split(methods: Sequence[MethodCurves]) -> Figure | None:
    """One bar a method, its parts one after the other."""
    shown = [entry for entry in methods if finite_number(entry.numbers.get("time_total_s")) is not None]
    if not shown:
        return None
    names = [entry.method for entry in shown]
    traces: list[Trace] = []
    for key, label, colour in TIME_PARTS:
        values = [max(finite_number(entry.numbers.get(key)) or 0.0, 0.0) for entry in shown]
        traces.append({
            "type": "bar", "orientation": "h", "name": label, "y": names, "x": [round(value, 6) for value in values],
            "marker": {"color": colour}, "text": [seconds_text(value) for value in values], "textposition": "none",
            "hovertemplate": f"%{{y}}, {label}: %{{text}}<extra></extra>",
        })  # fmt: skip
    totals = [sum(float(trace["x"][row]) for trace in traces) for row in range(len(shown))]
    notes = [
        {"x": total, "y": name, "text": seconds_text(total), "showarrow": False, "xanchor": "left", "xshift": 6, "font": {"size": 12}}
        for name, total in zip(names, totals, strict=True)
    ]
    return {
        "data": traces,
        "layout": style.layout(
            110 + 34 * len(shown),
            barmode="stack",
            bargap=0.35,
            annotations=notes,
            xaxis=style.axis("computing time [s]", range=[0.0, 1.12 * max(totals)]),
            yaxis=style.axis("", autorange="reversed", type="category"),
        ),
    }


def errors(methods: Sequence[MethodCurves], estimate: str) -> Figure | None:
    """estimate: "final" or "online"."""
    traces = []
    for entry in methods:
        curve = (entry.record.get("error") or {}).get(estimate)
        if not curve:
            continue
        hover = f"{entry.method}: %{{y:.3f}} m at %{{x:.0f}} s<extra></extra>"
        traces.append(style.line(curve["time_s"], curve["error_m"], entry.method, entry.colour, 1.3, hovertemplate=hover))
    if not traces:
        return None
    return {
        "data": traces,
        "layout": style.layout(
            330, xaxis=style.axis("mission time [s]", range=_span(traces)), yaxis=style.axis("position error [m]", rangemode="tozero")
        ),
    }


def nees(methods: Sequence[MethodCurves], estimate: str, dof: int) -> Figure | None:
    """NEES of the vehicle pose against the two-sided 95 % band of a single value."""
    shown = [entry for entry in methods if entry.record.get("nees")]
    if not shown:
        return None
    low, high = (float(chdtri(dof, 1.0 - tail)) for tail in (LOW_TAIL, 1.0 - LOW_TAIL))
    time_s = shown[0].record["nees"]["time_s"]
    traces = band_traces([time_s[0], time_s[-1]], [low, low], [high, high])
    largest = high
    for entry in shown:
        values = entry.record["nees"][estimate]
        largest = max(largest, *(value for value in values if value is not None))
        hover = f"{entry.method}: NEES %{{y:.2f}} at %{{x:.0f}} s<extra></extra>"
        traces.append(style.line(entry.record["nees"]["time_s"], values, entry.method, entry.colour, 1.3, hovertemplate=hover))
    # values far above the band need another scale, or nothing is seen of the others
    scale = {"type": "log", "dtick": 1} if largest > 20.0 * high else {"range": [0.0, round(1.08 * largest, 3)]}
    return {
        "data": traces,
        "layout": style.layout(
            330, xaxis=style.axis("mission time [s]", range=[time_s[0], time_s[-1]]), yaxis=style.axis(f"NEES, {dof} dof [-]", **scale)
        ),
    }


def nis(methods: Sequence[MethodCurves]) -> Figure | None:
    """Mean NIS per degree of freedom in spans of the mission, against the band of the span's own degrees of freedom."""
    shown = [entry for entry in methods if entry.record.get("nis")]
    if not shown:
        return None
    reference = max(shown, key=lambda entry: sum(entry.record["nis"]["dof"]))
    time_s = reference.record["nis"]["time_s"]
    traces = nis_band(reference.record["nis"])
    for entry in shown:
        values = nis_per_dof(entry.record["nis"])
        hover = f"{entry.method}: NIS / dof %{{y:.2f}} near %{{x:.0f}} s<extra></extra>"
        traces.append(style.line(entry.record["nis"]["time_s"], values, entry.method, entry.colour, 1.3, hovertemplate=hover))
    return {
        "data": traces,
        "layout": style.layout(
            330, xaxis=style.axis("mission time [s]", range=[time_s[0], time_s[-1]]), yaxis=style.axis("NIS / dof [-]", rangemode="tozero")
        ),
    }


def nis_band(curve: Mapping[str, Any]) -> list[Trace]:
    """The 95 % band of NIS / dof in each span, interrupted where no scan updated the filter."""
    dof = np.array(curve["dof"], dtype=np.float64)
    dof[dof <= 0.0] = np.nan
    low, high = chdtri(dof, 1.0 - LOW_TAIL) / dof, chdtri(dof, LOW_TAIL) / dof
    time_s = [None if np.isnan(value) else time for time, value in zip(curve["time_s"], dof.tolist(), strict=True)]
    return band_traces(time_s, listed(low, 4), listed(high, 4))


def nis_per_dof(curve: Mapping[str, Any]) -> list[float | None]:
    """null where no scan updated the filter."""
    pairs = zip(curve["nis"], curve["dof"], strict=True)
    return [round(nis_sum / dof, 4) if dof > 0.0 else NO_VALUE for nis_sum, dof in pairs]


def band_traces(x: list[float | None], low: list[float | None], high: list[float | None]) -> list[Trace]:
    edge = {"showlegend": False, "hoverinfo": "skip"}
    return [
        style.band(x, low, high, "95 % band", showlegend=True),
        {**style.line(x, low, "band", style.BAND, 0.8), **edge},
        {**style.line(x, high, "band", style.BAND, 0.8), **edge},
    ]


def maps(methods: Sequence[MethodCurves]) -> MapOfMethods | None:
    """Tracks and landmarks of all methods in the frame of their common start; one switch a method."""
    shown = [entry for entry in methods if entry.record.get("map")]
    if not shown:
        return None
    traces: list[Trace] = []
    layers: list[Layer] = []

    def add(key: str, label: str, colour: str, symbol: str, new: list[Trace], visible: bool) -> None:
        layers.append(Layer(key, label, colour, symbol, list(range(len(traces), len(traces) + len(new))), visible))
        traces.extend({**trace, "visible": visible, "showlegend": False} for trace in new)

    first = shown[0].record["map"]
    unit = html.escape(str(first.get("unit", "m")))
    place = f"%{{x:.2f}} {unit}, %{{y:.2f}} {unit}"
    notes = []
    if first.get("reference"):
        line = style.line(first["reference"]["x_m"], first["reference"]["y_m"], "reference", style.REFERENCE, 3.0, hoverinfo="skip")
        dots = {**line, "mode": "markers", "marker": {"color": style.REFERENCE, "size": 3.5}}
        sparse = first["reference"]["sparse"]
        add("reference", "Reference", style.REFERENCE, "dot" if sparse else "line", [dots if sparse else line], True)
        notes.append(f"The reference stands as aligned to {shown[0].method}.")
    line = style.line(
        first["dead_reckoning"]["x_m"], first["dead_reckoning"]["y_m"], "dead reckoning", style.DEAD_RECKONING, 1.2,
        line={"dash": "4px,3px"}, hoverinfo="skip",
    )  # fmt: skip
    add("dead_reckoning", "Dead reckoning", style.DEAD_RECKONING, "dotted", [line], False)
    low, high = np.full(2, np.inf), np.full(2, -np.inf)
    for entry in shown:
        drawn = entry.record["map"]
        dots = {
            "type": "scatter", "mode": "markers", "x": drawn["landmarks"]["x_m"], "y": drawn["landmarks"]["y_m"],
            "marker": {"color": entry.colour, "size": 5, "opacity": 0.75}, "name": entry.method,
            "hovertemplate": f"{entry.method}: landmark<br>{place}<extra></extra>",
        }  # fmt: skip
        hover = f"{entry.method}: track<br>{place}<extra></extra>"
        track = style.line(drawn["track"]["x_m"], drawn["track"]["y_m"], entry.method, entry.colour, 1.4, hovertemplate=hover)
        add(f"method-{entry.method}", entry.method, entry.colour, "line", [dots, track], True)
        for part in (drawn["track"], drawn["landmarks"]):
            if part["x_m"]:
                points = np.column_stack([part["x_m"], part["y_m"]])
                low, high = np.minimum(low, points.min(axis=0)), np.maximum(high, points.max(axis=0))
    margin = 0.04 * max(float((high - low).max()), 1.0)
    ranges = [[round(float(low[side]) - margin, 2), round(float(high[side]) + margin, 2)] for side in (0, 1)]
    figure: Figure = {
        "data": traces,
        "layout": style.layout(
            650,
            showlegend=False,
            dragmode="pan",
            margin={"l": 64, "r": 12, "t": 12, "b": 52},
            xaxis=style.axis(f"x [{unit}]", range=ranges[0], constrain="range"),
            yaxis=style.axis(f"y [{unit}]", range=ranges[1], scaleanchor="x", scaleratio=1, constrain="range"),
        ),
    }
    return MapOfMethods(figure, layers, notes)


def _span(traces: Sequence[Trace]) -> list[float]:
    return [min(trace["x"][0] for trace in traces), max(trace["x"][-1] for trace in traces)]
