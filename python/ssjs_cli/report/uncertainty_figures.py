"""How surely the vehicle is known over the mission, and what each loop closure does to it."""

from dataclasses import dataclass

import numpy as np

from ssjs_cli.report import figure_style as style
from ssjs_cli.report.error_figures import SPANS, Drawing
from ssjs_cli.report.figure_style import Figure, FloatArray, Trace, listed, with_gaps
from ssjs_cli.report.number_text import count_text, finite_number, metres_text
from ssjs_cli.report.planar_shapes import ellipse_axes
from ssjs_cli.report.result_files import PositionCovariance, RunFiles
from ssjs_cli.report.sheet import Sheet, sheet
from ssjs_cli.report.simplification import keep_extremes

#: More rows are in submaps.json.
MAX_ROWS = 2000
#: Two closings at one time are one event.
SAME_TIME_S = 1e-6


@dataclass(frozen=True)
class Closing:
    """One time at which submaps were tied: sigma along the major axis of the online position before and after, in m; the axes of the
    ellipse as text."""

    time_s: float
    pairs: list[tuple[int, int]]
    before_m: FloatArray
    after_m: FloatArray


def closings(files: RunFiles) -> list[Closing]:
    """Accepted loops by their times, with the online half axes (major, minor; one sigma) of the row before and of the first row at or
    after them."""
    online = files.online_covariance
    if online is None or files.submaps is None or not len(online.time_s):
        return []
    half_axes, _ = ellipse_axes(online.covariance)
    by_time: dict[float, list[tuple[int, int]]] = {}
    for loop in files.submaps.loops:
        time_s = finite_number(loop.get("time_s"))
        if loop.get("accepted") and time_s is not None:
            by_time.setdefault(time_s, []).append((int(loop["from"]), int(loop["to"])))
    answer = []
    for time_s in sorted(by_time):
        after = int(np.searchsorted(online.time_s, time_s - SAME_TIME_S))
        if 0 < after < len(online.time_s):
            answer.append(Closing(time_s, by_time[time_s], half_axes[after - 1], half_axes[after]))
    return answer


def uncertainty(files: RunFiles) -> Drawing | None:
    """One sigma along the larger axis of the position, online and final, with a mark for each loop closure. None without covariances."""
    if files.online_covariance is None or len(files.online_covariance.time_s) < 2:
        return None
    traces: list[Trace] = []
    online_m = _major(files.online_covariance)
    top_m = float(online_m.max())
    traces.append(_curve(files.online_covariance.time_s, online_m, "online", style.ONLINE, 1.4))
    if files.trajectory_covariance is not None and len(files.trajectory_covariance.time_s) >= 2:
        final_m = _major(files.trajectory_covariance)
        top_m = max(top_m, float(final_m.max()))
        traces.append(_curve(files.trajectory_covariance.time_s, final_m, "final", style.FINAL, 1.6))
    notes = ["One standard deviation along the larger axis of the position's ellipse."]
    ties = closings(files)
    if ties:
        drops: list[float | None] = []
        ends: list[float | None] = []
        for tie in ties:
            drops += [round(tie.time_s, 2)] * 2 + [None]
            ends += [round(float(tie.before_m[0]), 4), round(float(tie.after_m[0]), 4), None]
        traces.append({**style.line(drops, ends, "loop closure: before to after", style.LOOP, 2.2), "hoverinfo": "skip"})
        traces.append({
            "type": "scatter", "mode": "markers", "showlegend": False, "x": [round(tie.time_s, 2) for tie in ties],
            "y": [round(float(tie.after_m[0]), 4) for tie in ties],
            "marker": {"symbol": "triangle-down", "size": 8, "color": style.LOOP},
            "text": [f"{_pairs_text(tie)}<br>σ {metres_text(tie.before_m[0])} before, {metres_text(tie.after_m[0])} after" for tie in ties],
            "hovertemplate": "%{text}<br>t = %{x:.0f} s<extra></extra>",
        })  # fmt: skip
        ratio = np.array([tie.after_m[0] / tie.before_m[0] for tie in ties if tie.before_m[0] > 0.0])
        if len(ratio):
            usual, best = 100.0 * float(np.median(ratio)), 100.0 * float(ratio.min())
            notes.append(
                f"Submaps were tied at {count_text(len(ties))} moments; σ falls to {usual:.0f} % (median), at best to {best:.0f} %."
            )
    time_s = files.online_covariance.time_s
    figure: Figure = {
        "data": traces,
        "layout": style.layout(
            340,
            xaxis=style.axis("time [s]", range=[round(float(time_s[0]), 2), round(float(time_s[-1]), 2)]),
            yaxis=style.axis("σ of the position [m]", range=[0.0, round(1.08 * top_m, 4)]),
        ),
    }
    return Drawing(figure, notes)


def closing_sheet(files: RunFiles) -> Sheet | None:
    ties = closings(files)
    if not ties:
        return None
    rows = [
        {
            "time_s": tie.time_s, "pairs": _pairs_text(tie),
            "before_m": float(tie.before_m[0]), "before_minor_m": float(tie.before_m[1]),
            "after_m": float(tie.after_m[0]), "after_minor_m": float(tie.after_m[1]),
            "percent": 100.0 * float(tie.after_m[0] / tie.before_m[0]) if tie.before_m[0] > 0.0 else None,
        }
        for tie in ties[:MAX_ROWS]
    ]  # fmt: skip
    columns = [
        ("time_s", "time [s]", 1, 1.0), ("pairs", "submaps tied", None, 1.0), ("before_m", "σ major before [m]", 3, 1.0),
        ("before_minor_m", "σ minor before [m]", 3, 1.0), ("after_m", "σ major after [m]", 3, 1.0),
        ("after_minor_m", "σ minor after [m]", 3, 1.0), ("percent", "after / before [%]", 0, 1.0),
    ]  # fmt: skip
    note = f"The first {count_text(MAX_ROWS)} of {count_text(len(ties))}." if len(ties) > MAX_ROWS else ""
    return sheet("closing-table", "Position before and after each loop closure", columns, rows, note=note)


def _pairs_text(tie: Closing) -> str:
    shown = ", ".join(f"{first} – {second}" for first, second in tie.pairs[:4])
    return shown if len(tie.pairs) <= 4 else f"{shown} and {len(tie.pairs) - 4} more"


def _major(covariance: PositionCovariance) -> FloatArray:
    half_axes, _ = ellipse_axes(covariance.covariance)
    return half_axes[:, 0]


def _curve(time_s: FloatArray, value: FloatArray, name: str, colour: str, width_px: float) -> Trace:
    time_drawn, drawn = with_gaps(time_s, value, keep_extremes(time_s, value, SPANS))
    hover = f"{name} σ %{{y:.3f}} m at %{{x:.0f}} s<extra></extra>"
    return style.line(listed(time_drawn, 2), listed(drawn, 4), name, colour, width_px, hovertemplate=hover)
