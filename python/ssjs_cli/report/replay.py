"""What the time slider needs: a few thousand moments of the mission, and when each landmark, base and loop closure came to be."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssjs_cli.report.figure_style import listed
from ssjs_cli.report.map_figure import MapAxes, SubmapColours
from ssjs_cli.report.number_text import finite_number
from ssjs_cli.report.result_files import Columns, PositionCovariance, RunFiles, Track
from ssjs_cli.report.submap_colours import PALETTE, UNKNOWN_COLOUR

FloatArray = NDArray[np.float64]

MAX_MOMENTS = 3000


def replay_moments(time_s: FloatArray, max_moments: int = MAX_MOMENTS) -> NDArray[np.int64]:
    """Row numbers of at most `max_moments` moments, evenly spaced in time, first and last among them."""
    if len(time_s) <= max_moments:
        return np.arange(len(time_s), dtype=np.int64)
    wanted = np.linspace(time_s[0], time_s[-1], max_moments)
    rows = np.clip(np.searchsorted(time_s, wanted), 0, len(time_s) - 1)
    return np.unique(np.concatenate((rows, [len(time_s) - 1]))).astype(np.int64)


def replay_data(files: RunFiles, axes: MapAxes, colours: SubmapColours) -> dict[str, Any] | None:
    """None without a track. Everything in drawn coordinates (across, up); headings anticlockwise from the across axis, rad."""
    base_track = files.trajectory if files.trajectory is not None else files.online
    if base_track is None or len(base_track.time_s) < 2:
        return None
    moments = replay_moments(base_track.time_s)
    time_s = base_track.time_s[moments]
    estimates = []
    for key, label, track, covariance in (
        ("final", "final estimate", files.trajectory, files.trajectory_covariance),
        ("online", "as seen at the time", files.online, files.online_covariance),
    ):
        if track is not None and len(track.time_s) >= 2:
            estimates.append(_estimate(key, label, track, covariance, time_s, axes))
    data: dict[str, Any] = {
        "time_s": listed(time_s, 3),
        "estimates": estimates,
        "names": list(axes.short_names),
        "unit": axes.unit,
        "north_up": axes.north_up,
        "palette": [*PALETTE, UNKNOWN_COLOUR],
    }
    data.update(_events(files, axes, colours))
    data["error_m"] = _error_at(files.errors, time_s)
    data["submap"] = _submap_at(files, time_s)
    return data


def _rows_at(source_time_s: FloatArray, time_s: FloatArray) -> NDArray[np.int64]:
    """The last row at or before each moment."""
    return np.clip(np.searchsorted(source_time_s, time_s, side="right") - 1, 0, len(source_time_s) - 1).astype(np.int64)


def _estimate(
    key: str, label: str, track: Track, covariance: PositionCovariance | None, time_s: FloatArray, axes: MapAxes
) -> dict[str, Any]:
    rows = _rows_at(track.time_s, time_s)
    position = axes.drawn(track.position[rows])
    estimate: dict[str, Any] = {
        "key": key,
        "label": label,
        "x": listed(position[:, 0], 3),
        "y": listed(position[:, 1], 3),
        "heading": listed(axes.drawn_heading(track.heading[rows]), 4),
        "world_heading": listed(track.heading[rows], 4),
        "covariance": None,
    }
    if covariance is not None and len(covariance.time_s):
        at_moment = axes.drawn_covariance(covariance.covariance[_rows_at(covariance.time_s, time_s)])
        estimate["covariance"] = [listed(at_moment[:, column], 7) for column in range(3)]
    return estimate


def _events(files: RunFiles, axes: MapAxes, colours: SubmapColours) -> dict[str, Any]:
    """Landmarks (born with their submap), bases and accepted loop closures, each in the order of their times."""
    events: dict[str, Any] = {"landmarks": None, "bases": None, "loops": None}
    if files.submaps is None:
        return events
    start_s = {int(entry["index"]): finite_number(entry.get("start_time_s")) or 0.0 for entry in files.submaps.submaps}
    base = {int(entry["index"]): np.array(entry["base_pose"][:3], dtype=np.float64) for entry in files.submaps.submaps}
    if base:
        order = sorted(base, key=lambda index: (start_s[index], index))
        pose = np.array([base[index] for index in order])
        origin, heading = axes.drawn(pose[:, :2]), axes.drawn_heading(pose[:, 2])
        events["bases"] = {
            "time_s": [round(start_s[index], 3) for index in order],
            "x": listed(origin[:, 0], 3),
            "y": listed(origin[:, 1], 3),
            "heading": listed(heading, 4),
            "colour": [colours.groups[index] for index in order],
        }
    if files.landmarks is not None and len(files.landmarks.id):
        born = np.array([start_s.get(int(submap), 0.0) for submap in files.landmarks.submap])
        order_by_birth = np.argsort(born, kind="stable")
        points = axes.drawn(files.landmarks.position[order_by_birth])
        events["landmarks"] = {
            "time_s": listed(born[order_by_birth], 3),
            "x": listed(points[:, 0], 3),
            "y": listed(points[:, 1], 3),
            "colour": [colours.groups.get(int(submap), len(PALETTE)) for submap in files.landmarks.submap[order_by_birth]],
        }
    closures = [loop for loop in files.submaps.loops if loop.get("accepted") and loop.get("from") in base and loop.get("to") in base]
    closures.sort(key=lambda loop: finite_number(loop.get("time_s")) or 0.0)
    if closures:
        ends = axes.drawn(np.array([[base[loop["from"]][:2], base[loop["to"]][:2]] for loop in closures]))
        events["loops"] = {
            "time_s": [round(finite_number(loop.get("time_s")) or 0.0, 3) for loop in closures],
            "ends": [listed(pair.reshape(-1), 3) for pair in ends],
        }
    return events


def _error_at(errors: Columns | None, time_s: FloatArray) -> list[float | None] | None:
    """Error of the final estimate at each moment; null where no reference lies within a second."""
    if errors is None or len(errors["time_s"]) == 0:
        return None
    rows = _rows_at(errors["time_s"], time_s)
    near = np.abs(errors["time_s"][rows] - time_s) <= 1.0
    return listed(np.where(near, errors["error_m"][rows], np.nan), 4)


def _submap_at(files: RunFiles, time_s: FloatArray) -> list[int] | None:
    table = files.trajectory_submaps
    if table is None or len(table["time_s"]) == 0:
        return None
    return [int(value) for value in table["submap"][_rows_at(table["time_s"], time_s)]]


def timeline_spans(files: RunFiles, colours: SubmapColours) -> dict[str, Any] | None:
    """Per cent of the mission: where each submap begins and ends, and where loops closed. For the strip under the slider."""
    track = files.trajectory if files.trajectory is not None else files.online
    if files.submaps is None or track is None or len(track.time_s) < 2 or not files.submaps.submaps:
        return None
    first_s, last_s = float(track.time_s[0]), float(track.time_s[-1])
    scale = 1000.0 / (last_s - first_s) if last_s > first_s else 0.0

    def place(time_s: float | None) -> float:
        return round(min(max(((time_s if time_s is not None else first_s) - first_s) * scale, 0.0), 1000.0), 2)

    spans = []
    for entry in files.submaps.submaps:
        start, end = place(finite_number(entry.get("start_time_s"))), place(finite_number(entry.get("end_time_s")))
        spans.append({"start": start, "width": round(max(end - start, 0.0), 2), "colour": colours.colour(int(entry["index"]))})
    ticks = [place(finite_number(loop.get("time_s"))) for loop in files.submaps.loops if loop.get("accepted")]
    return {"spans": spans, "ticks": ticks}
