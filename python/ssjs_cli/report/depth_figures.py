"""How deep: the vehicle and the seabed over time, and the survey seen from the side. Depth grows downwards, as in the water."""

import html

import numpy as np

from ssjs_cli.report import figure_style as style
from ssjs_cli.report.error_figures import SPANS, Drawing
from ssjs_cli.report.figure_style import Figure, FloatArray, Trace, listed, marker_size, with_gaps
from ssjs_cli.report.map_figure import MapAxes, SubmapColours
from ssjs_cli.report.number_text import count_text, metres_text
from ssjs_cli.report.result_files import Landmarks, RunFiles
from ssjs_cli.report.simplification import every_nth, keep_extremes
from ssjs_cli.report.survey_files import Altitudes
from ssjs_cli.report.survey_track import coloured_track

SEABED = "#8c6d46"
SEABED_FILL = "rgba(140,109,70,0.16)"
ALTITUDE = "#00859c"
MAX_SEABED_DOTS = 1500
MAX_LANDMARKS = 3000
#: So many times deeper than the seabed lies below the vehicle, the water above is left out of the picture.
DEEP_SHARE = 4.0
SURFACE_LEFT_OUT = "Depth does not begin at the surface."


def depth_profile(files: RunFiles) -> Drawing | None:
    """Depth of the vehicle and of the seabed, and the altitude between them, on one time axis. None for a vehicle in the plane."""
    track = files.trajectory
    if track is None or track.depth is None or len(track.time_s) < 2:
        return None
    altitudes = files.survey.altitudes
    end_s = [round(float(track.time_s[0]), 2), round(float(track.time_s[-1]), 2)]
    traces: list[Trace] = []
    notes = [f"Vehicle between {metres_text(float(track.depth.min()))} and {metres_text(float(track.depth.max()))} deep."]
    deepest_m = float(track.depth.max())
    if altitudes is not None:
        seabed_m = seabed_depth(files, altitudes)
        deepest_m = max(deepest_m, float(np.quantile(seabed_m, 0.999)))
        floor_m = _floor_m(track.depth, deepest_m)
        traces += _seabed(altitudes.time_s, seabed_m, floor_m)
        shallow_m, deep_m = (metres_text(float(np.quantile(seabed_m, share))) for share in (0.001, 0.999))
        usual_m = metres_text(float(np.median(altitudes.altitude_m)))
        notes.append(f"Seabed (the vehicle's depth and its altitude together) between {shallow_m} and {deep_m}; median altitude {usual_m}.")
    top_m = _top_m(track.depth, deepest_m, 0.04 * deepest_m + 0.2)
    notes += [SURFACE_LEFT_OUT] if top_m > 0.0 else []
    traces.append(
        _curve(track.time_s, track.depth, "vehicle", style.FINAL, 1.6, hovertemplate="vehicle %{y:.2f} m deep at %{x:.0f} s<extra></extra>")
    )
    both = altitudes is not None
    if altitudes is not None:
        traces.append(_curve(
            altitudes.time_s, altitudes.altitude_m, "altitude", ALTITUDE, 1.2, yaxis="y2",
            hovertemplate="altitude %{y:.2f} m at %{x:.0f} s<extra></extra>",
        ))  # fmt: skip
    layout = style.layout(
        430 if both else 300,
        xaxis=style.axis("time [s]", range=end_s, anchor="y2" if both else "y"),
        yaxis=style.axis(
            "depth [m]", range=[round(_floor_m(track.depth, deepest_m), 2), round(top_m, 2)], domain=[0.36, 1.0] if both else [0.0, 1.0]
        ),
    )
    if altitudes is not None:
        highest_m = float(np.quantile(altitudes.altitude_m, 0.999))
        layout["yaxis2"] = style.axis(
            "altitude [m]", range=[0.0, round(1.08 * highest_m, 2)], domain=[0.0, 0.28], anchor="x", rangemode="tozero"
        )
    return Drawing({"data": traces, "layout": layout}, notes)


def seabed_depth(files: RunFiles, altitudes: Altitudes) -> FloatArray:
    """Depth of the vehicle at the time of each altitude, and that altitude below it."""
    track = files.trajectory
    assert track is not None and track.depth is not None
    depth: FloatArray = np.interp(altitudes.time_s, track.time_s, track.depth) + altitudes.altitude_m
    return depth


def side_view(files: RunFiles, axes: MapAxes, colours: SubmapColours, height_px: int) -> Drawing | None:
    """Track, seabed and landmarks against the world axis along which the survey is longer. None for a vehicle in the plane."""
    track = files.trajectory
    if track is None or track.depth is None or len(track.time_s) < 2:
        return None
    along = int(np.argmax(np.ptp(track.position, axis=0)))
    traces: list[Trace] = []
    deepest_m = float(track.depth.max())
    if files.survey.altitudes is not None:
        trace, seabed_m = _seabed_dots(files, files.survey.altitudes, along)
        traces.append(trace)
        deepest_m = max(deepest_m, seabed_m)
    for piece in coloured_track(files, colours):
        traces.append({
            **style.line(listed(piece.points[:, along], 2), listed(piece.points[:, 2], 3), "track", piece.colour, 1.3),
            "showlegend": False, "customdata": listed(piece.time_s, 1),
            "hovertemplate": "%{y:.2f} m deep at t = %{customdata:.0f} s<extra></extra>",
        })  # fmt: skip
    if files.landmarks is not None and len(files.landmarks.id):
        traces += _landmarks(files.landmarks, colours, along)
        deepest_m = max(deepest_m, float(np.quantile(files.landmarks.depth, 0.98)))
    name = html.escape(axes.names[along])
    top_m = _top_m(track.depth, deepest_m, 0.2)
    figure: Figure = {
        "data": traces,
        "layout": style.layout(
            height_px,
            margin={"l": 56, "r": 12, "t": 30, "b": 48},
            xaxis=style.axis(f"{name} [m]"),
            yaxis=style.axis("depth [m]", range=[round(deepest_m + 0.06 * (deepest_m - max(top_m, 0.0)) + 0.3, 2), round(top_m, 2)]),
        ),
    }
    return Drawing(figure, ["Depth is drawn larger than length.", *([SURFACE_LEFT_OUT] if top_m > 0.0 else [])])


def _floor_m(depth_m: FloatArray, deepest_m: float) -> float:
    """Where it ends."""
    return deepest_m + 0.04 * (deepest_m - max(_top_m(depth_m, deepest_m, 0.0), 0.0)) + 0.5


def _top_m(depth_m: FloatArray, deepest_m: float, margin_m: float) -> float:
    """Where the depth axis begins: at the surface, or, of a vehicle deep down and near to the seabed, a little above it."""
    highest_m = float(depth_m.min())
    span_m = deepest_m - highest_m
    return highest_m - 0.1 * span_m - 0.2 if highest_m > DEEP_SHARE * span_m > 0.0 else min(highest_m - margin_m, 0.0)


def _seabed(time_s: FloatArray, seabed_m: FloatArray, floor_m: float) -> list[Trace]:
    curve = _curve(time_s, seabed_m, "seabed", SEABED, 1.2, hovertemplate="seabed %{y:.2f} m deep at %{x:.0f} s<extra></extra>")
    floor = [None if value is None else round(floor_m, 2) for value in curve["y"]]
    area = style.band(curve["x"], floor, curve["y"], "ground", fillcolor=SEABED_FILL, showlegend=False)
    return [area, curve]


def _curve(time_s: FloatArray, value: FloatArray, name: str, colour: str, width_px: float, **more: object) -> Trace:
    time_drawn, drawn = with_gaps(time_s, value, keep_extremes(time_s, value, SPANS))
    return style.line(listed(time_drawn, 2), listed(drawn, 3), name, colour, width_px, **more)


def _seabed_dots(files: RunFiles, altitudes: Altitudes, along: int) -> tuple[Trace, float]:
    track = files.trajectory
    assert track is not None
    rows, _ = every_nth(len(altitudes.time_s), MAX_SEABED_DOTS)
    seabed_m = seabed_depth(files, altitudes)
    place = np.interp(altitudes.time_s[rows], track.time_s, track.position[:, along])
    trace = {
        "type": "scatter", "mode": "markers", "name": "seabed below the vehicle", "x": listed(place, 2), "y": listed(seabed_m[rows], 2),
        "marker": {"color": SEABED, "size": 3, "opacity": 0.45}, "hoverinfo": "skip",
    }  # fmt: skip
    return trace, float(np.quantile(seabed_m, 0.995))


def _landmarks(landmarks: Landmarks, colours: SubmapColours, along: int) -> list[Trace]:
    rows, _ = every_nth(len(landmarks.id), MAX_LANDMARKS)
    colour = [colours.colour(int(landmarks.submap[row])) for row in rows]
    text = [f"landmark {landmarks.id[row]}, seen {count_text(int(landmarks.times_seen[row]))} times" for row in rows]
    return [{
        "type": "scatter", "mode": "markers", "name": "landmarks", "x": listed(landmarks.position[rows, along], 2),
        "y": listed(landmarks.depth[rows], 2), "text": text, "hovertemplate": "%{text}<br>%{y:.2f} m deep<extra></extra>",
        "marker": {"color": colour, "size": marker_size(len(rows), 6.0), "symbol": "diamond", "line": {"color": "#ffffff", "width": 0.7}},
    }]  # fmt: skip
