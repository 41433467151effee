"""The survey in space and from above: track and landmarks in the colours of their submaps."""

import numpy as np

from ssjs_cli.report import figure_style as style
from ssjs_cli.report.error_figures import Drawing
from ssjs_cli.report.figure_style import Figure, FloatArray, Trace, listed, marker_size
from ssjs_cli.report.map_figure import ELLIPSE_CORNERS, MapAxes, SubmapColours
from ssjs_cli.report.planar_shapes import ellipse_outlines
from ssjs_cli.report.result_files import Landmarks, RunFiles
from ssjs_cli.report.simplification import every_nth
from ssjs_cli.report.survey_track import coloured_track

MAX_LANDMARKS = 2000
#: Depth is drawn this part of the longer side of the survey high, however shallow the water.
HEIGHT_OF_EXTENT = 0.32


def space_view(files: RunFiles, axes: MapAxes, colours: SubmapColours, height_px: int) -> Drawing | None:
    """None for a vehicle in the plane. Depth downwards and enlarged."""
    track = files.trajectory
    if track is None or track.depth is None or len(track.time_s) < 2:
        return None
    traces: list[Trace] = []
    for piece in coloured_track(files, colours):
        across_up = axes.drawn(piece.points[:, :2])
        traces.append({
            "type": "scatter3d", "mode": "lines", "x": listed(across_up[:, 0], 2), "y": listed(across_up[:, 1], 2),
            "z": listed(piece.points[:, 2], 2), "line": {"color": piece.colour, "width": 3}, "showlegend": False,
            "customdata": listed(piece.time_s, 1), "connectgaps": False,
            "hovertemplate": "t = %{customdata:.0f} s, %{z:.2f} m deep<extra></extra>",
        })  # fmt: skip
    parts = [np.column_stack((axes.drawn(track.position), track.depth))]
    if files.landmarks is not None and len(files.landmarks.id):
        rows, _ = every_nth(len(files.landmarks.id), MAX_LANDMARKS)
        points = np.column_stack((axes.drawn(files.landmarks.position[rows]), files.landmarks.depth[rows]))
        parts.append(points)
        traces.append({
            "type": "scatter3d", "mode": "markers",
            "x": listed(points[:, 0], 2), "y": listed(points[:, 1], 2), "z": listed(points[:, 2], 2),
            "marker": _diamonds(files.landmarks, rows.tolist(), colours, 3.2),
            "showlegend": False, "text": [f"landmark {files.landmarks.id[row]}" for row in rows],
            "hovertemplate": "%{text}<br>%{z:.2f} m deep<extra></extra>",
        })  # fmt: skip
    extent_m = np.maximum(np.ptp(np.concatenate(parts), axis=0), 1e-3)
    longer_m = float(extent_m[:2].max())
    ratio = np.maximum(extent_m[:2] / longer_m, 0.15)
    across_title, up_title = axes.titles()
    figure: Figure = {
        "data": traces,
        "layout": style.layout(
            height_px,
            margin={"l": 0, "r": 0, "t": 0, "b": 0},
            scene={
                "xaxis": _axis(across_title),
                "yaxis": _axis(up_title),
                "zaxis": {**_axis("depth [m]"), "autorange": "reversed", "nticks": 5},
                "aspectmode": "manual",
                "aspectratio": {"x": round(float(ratio[0]), 3), "y": round(float(ratio[1]), 3), "z": HEIGHT_OF_EXTENT},
                "camera": {"eye": {"x": -0.82, "y": -0.99, "z": 0.55}, "center": {"x": 0.0, "y": 0.0, "z": -0.08}},
                "dragmode": "turntable",
            },
        ),
    }
    enlarged = HEIGHT_OF_EXTENT * longer_m / float(extent_m[2])
    return Drawing(figure, [f"Drag to turn. Depth is drawn {enlarged:.2g} times larger than length."])


def top_view(files: RunFiles, axes: MapAxes, colours: SubmapColours, height_px: int) -> Drawing | None:
    """The submaps in their colours with their landmarks and 95 % ellipses; the map below has every layer."""
    track = files.trajectory
    if track is None or track.depth is None or len(track.time_s) < 2:
        return None
    traces: list[Trace] = []
    for piece in coloured_track(files, colours):
        points = axes.drawn(piece.points[:, :2])
        traces.append({
            **style.line(listed(points[:, 0], 2), listed(points[:, 1], 2), "track", piece.colour, 1.4),
            "showlegend": False, "customdata": listed(piece.time_s, 1), "hovertemplate": "t = %{customdata:.0f} s<extra></extra>",
        })  # fmt: skip
    parts = [axes.drawn(track.position)]
    if files.landmarks is not None and len(files.landmarks.id):
        rows, _ = every_nth(len(files.landmarks.id), MAX_LANDMARKS)
        points = axes.drawn(files.landmarks.position[rows])
        parts.append(points)
        traces += _ellipses(points, axes.drawn_covariance(files.landmarks.covariance[rows]))
        traces.append({
            "type": "scatter", "mode": "markers", "x": listed(points[:, 0], 2), "y": listed(points[:, 1], 2),
            "marker": _diamonds(files.landmarks, rows.tolist(), colours, 5.0), "showlegend": False,
            "text": [f"landmark {files.landmarks.id[row]}, seen {files.landmarks.times_seen[row]} times" for row in rows],
            "hovertemplate": "%{text}<extra></extra>",
        })  # fmt: skip
    shown = np.concatenate(parts)
    margin_m = 0.04 * max(float(np.ptp(shown, axis=0).max()), 1.0)
    low, high = shown.min(axis=0) - margin_m, shown.max(axis=0) + margin_m
    across_title, up_title = axes.titles()
    figure: Figure = {
        "data": traces,
        "layout": style.layout(
            height_px,
            margin={"l": 56, "r": 12, "t": 10, "b": 48},
            showlegend=False,
            xaxis=style.axis(across_title, range=[round(float(low[0]), 2), round(float(high[0]), 2)], constrain="domain"),
            yaxis=style.axis(
                up_title, range=[round(float(low[1]), 2), round(float(high[1]), 2)], scaleanchor="x", scaleratio=1, constrain="domain"
            ),
        ),
    }
    return Drawing(figure, [])


def _ellipses(points: FloatArray, covariance: FloatArray) -> list[Trace]:
    outlines = ellipse_outlines(points, covariance, ELLIPSE_CORNERS)
    path = np.concatenate((outlines, np.full((len(outlines), 1, 2), np.nan)), axis=1).reshape(-1, 2)
    return [{
        **style.line(listed(path[:, 0], 2), listed(path[:, 1], 2), "95 % ellipses", style.MUTED, 0.8), "hoverinfo": "skip",
    }]  # fmt: skip


def _diamonds(landmarks: Landmarks, rows: list[int], colours: SubmapColours, size: float) -> dict[str, object]:
    drawn = [colours.colour(int(landmarks.submap[row])) for row in rows]
    return {"color": drawn, "size": marker_size(len(rows), size), "symbol": "diamond"}


def _axis(title: str) -> dict[str, object]:
    return {
        "title": {"text": title, "font": {"size": 11, "color": style.MUTED}},
        "tickfont": {"size": 10, "color": style.MUTED}, "gridcolor": "#dfe5ec", "zerolinecolor": "#dfe5ec", "showbackground": False,
    }  # fmt: skip
