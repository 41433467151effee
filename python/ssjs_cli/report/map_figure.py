"""The map: what is drawn, in which layers, and what was left out of the drawing."""

import html
import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssjs_cli.report import figure_style as style
from ssjs_cli.report.figure_style import Figure, Trace, listed
from ssjs_cli.report.frame_files import PlacedMosaic
from ssjs_cli.report.number_text import count_text, finite_number, length_text
from ssjs_cli.report.picture_data import jpeg_url
from ssjs_cli.report.planar_shapes import convex_hull, ellipse_axes, ellipse_outlines
from ssjs_cli.report.result_files import Landmarks, RunFiles, Track
from ssjs_cli.report.simplification import every_nth, simplify_line
from ssjs_cli.report.submap_colours import PALETTE, UNKNOWN_COLOUR, colour_groups

FloatArray = NDArray[np.float64]

MAX_TRACK_POINTS = 4000
MAX_REFERENCE_MARKERS = 3000
MAX_REFUSED_LINES = 1500
MAX_LANDMARKS = 8000
MAX_ELLIPSES = 4000
ELLIPSE_CORNERS = 24
#: A drawn track may leave the full one by this part of the map's width: unseen until the map is enlarged forty times.
LINE_TOLERANCE_OF_EXTENT = 1.0 / 40_000.0


MOSAIC_WIDTH_PX = 1400
MOSAIC_QUALITY = 70

LAYER_ORDER = ("landmarks", "ellipses", "outlines", "bases", "loops", "refused", "final", "online", "dead_reckoning", "reference", "mosaic")


@dataclass(frozen=True)
class MapAxes:
    """Which world axis is drawn across and which one up. Planar missions: x across, y up. Under water y lies to starboard of x: y (east)
    across, x (north) up."""

    names: tuple[str, str]
    north_up: bool
    unit: str = "m"

    @staticmethod
    def from_summary(summary: dict[str, Any]) -> "MapAxes":
        names = summary.get("axis_names")
        if not isinstance(names, list) or len(names) < 2:
            names = ["x", "y"]
        first, second = str(names[0]), str(names[1])
        return MapAxes(
            names=(first, second),
            north_up=first.lower().startswith("north") or "starboard" in second.lower(),
            unit=str(summary.get("length_unit") or "m"),
        )

    @property
    def short_names(self) -> tuple[str, str]:
        """Without what explains them: "x, ahead at the start" is x."""
        return self.names[0].split(",")[0], self.names[1].split(",")[0]

    @property
    def short_unit(self) -> str:
        """For the head of a column: of "frame widths" the widths."""
        return self.unit.split()[-1]

    def drawn(self, points: FloatArray) -> FloatArray:
        """World points (..., 2) as (across, up)."""
        return points[..., ::-1] if self.north_up else points

    def drawn_covariance(self, covariance: FloatArray) -> FloatArray:
        """World covariance (n, 3) xx, xy, yy as (across across, across up, up up)."""
        return covariance[:, ::-1] if self.north_up else covariance

    def drawn_heading(self, heading_rad: FloatArray) -> FloatArray:
        """Angle of the heading on paper, anticlockwise from the across axis."""
        return math.pi / 2.0 - heading_rad if self.north_up else heading_rad

    def titles(self) -> tuple[str, str]:
        across, up = self.names[::-1] if self.north_up else self.names
        return f"{html.escape(across)} [{html.escape(self.unit)}]", f"{html.escape(up)} [{html.escape(self.unit)}]"


@dataclass(frozen=True)
class Layer:
    """One switch above the map: the traces it shows and hides."""

    key: str
    label: str
    colour: str
    symbol: str
    traces: list[int]
    visible: bool


@dataclass
class MapDrawing:
    figure: Figure
    layers: list[Layer] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class SubmapColours:
    """index of the submap -> colour group and colour."""

    groups: dict[int, int]

    @staticmethod
    def from_files(files: RunFiles) -> "SubmapColours":
        if files.submaps is None:
            return SubmapColours({})
        indices = [int(entry["index"]) for entry in files.submaps.submaps]
        bases = np.array([entry["base_pose"][:2] for entry in files.submaps.submaps], dtype=np.float64).reshape(-1, 2)
        return SubmapColours(dict(zip(indices, colour_groups(bases), strict=True)))

    def colour(self, submap: int) -> str:
        return PALETTE[self.groups[submap]] if submap in self.groups else UNKNOWN_COLOUR


def draw_map(files: RunFiles, axes: MapAxes, colours: SubmapColours) -> MapDrawing | None:
    """None when there is neither a track nor a landmark to draw."""
    shown = _shown_points(files, axes)
    if len(shown) == 0:
        return None
    low, high = shown.min(axis=0), shown.max(axis=0)
    extent_m = max(float((high - low).max()), 1.0)
    painter = _Painter(axes, colours, extent_m)
    if files.pictures is not None and files.pictures.mosaic is not None:
        painter.mosaic(files.pictures.mosaic)
    painter.outlines(files)
    painter.reference(files)
    painter.track(files.dead_reckoning, "dead_reckoning", "Dead reckoning", style.DEAD_RECKONING, {"width": 1.3, "dash": "4px,3px"})
    painter.track(files.online, "online", "Online track", style.ONLINE, {"width": 1.2})
    painter.track(files.trajectory, "final", "Final track", style.FINAL, {"width": 1.6})
    painter.loops(files)
    painter.bases(files)
    painter.landmarks(files.landmarks)
    margin = 0.04 * extent_m
    across_title, up_title = axes.titles()
    figure = {
        "data": painter.traces,
        "layout": style.layout(
            650,
            margin={"l": 64, "r": 12, "t": 12, "b": 52},
            # the replay is drawn behind the plot, so that its hover texts stay on top
            paper_bgcolor="rgba(0,0,0,0)",
            plot_bgcolor="rgba(0,0,0,0)",
            showlegend=False,
            dragmode="pan",
            xaxis=style.axis(across_title, range=_range(low[0], high[0], margin), constrain="range"),
            yaxis=style.axis(up_title, range=_range(low[1], high[1], margin), scaleanchor="x", scaleratio=1, constrain="range"),
        ),
    }
    if files.dead_reckoning is not None and len(files.dead_reckoning.position):
        dead = axes.drawn(files.dead_reckoning.position)
        if bool((dead < low - margin).any() or (dead > high + margin).any()):
            painter.notes.append("Dead reckoning leaves the picture: double-click the map to fit everything, and again to come back.")
    if axes.unit != "m":
        painter.notes.append(
            f"How long a pixel is on the ground is not known (frames.metres_per_px): lengths on this page are {axes.unit}."
        )
    if painter.simplified:
        said = "; ".join(painter.simplified)
        painter.notes.insert(0, f"Lines are simplified; no point left out is farther than stated from the drawn line: {said}.")
    return MapDrawing(figure, sorted(painter.layers, key=lambda layer: LAYER_ORDER.index(layer.key)), painter.notes)


def _range(low: float, high: float, margin: float) -> list[float]:
    return [round(float(low) - margin, 3), round(float(high) + margin, 3)]


def _shown_points(files: RunFiles, axes: MapAxes) -> FloatArray:
    """What the first view must hold: landmarks, the final track and the mosaic; without the first two the online track, without that
    dead reckoning."""
    parts = [part.position for part in (files.landmarks, files.trajectory) if part is not None and len(part.position)]
    if not parts:
        parts = [part.position for part in (files.online, files.dead_reckoning) if part is not None and len(part.position)][:1]
    if not parts:
        return np.zeros((0, 2))
    shown = axes.drawn(np.concatenate(parts))
    if files.pictures is None or files.pictures.mosaic is None:
        return shown
    mosaic = files.pictures.mosaic
    return np.concatenate((shown, [[mosaic.left, mosaic.bottom], [mosaic.right, mosaic.top]]))


class _Painter:
    def __init__(self, axes: MapAxes, colours: SubmapColours, extent_m: float) -> None:
        self.axes = axes
        self.colours = colours
        self.extent_m = extent_m
        self.traces: list[Trace] = []
        self.layers: list[Layer] = []
        self.notes: list[str] = []
        self.simplified: list[str] = []

    def _add(self, key: str, label: str, colour: str, symbol: str, traces: list[Trace], visible: bool = True) -> None:
        first = len(self.traces)
        for trace in traces:
            self.traces.append({**trace, "visible": visible, "showlegend": False})
        self.layers.append(Layer(key, label, colour, symbol, list(range(first, len(self.traces))), visible))

    @property
    def _place(self) -> str:
        """Where the mouse is, for a text of plotly's."""
        unit = html.escape(self.axes.unit)
        return f"%{{x:.2f}} {unit}, %{{y:.2f}} {unit}"

    def _note_line(self, label: str, drawn: int, count: int, deviation: float) -> None:
        self.simplified.append(
            f"{label.lower()} {count_text(drawn)} of {count_text(count)} points, within {length_text(deviation, self.axes.unit)}"
        )

    def mosaic(self, mosaic: PlacedMosaic) -> None:
        """Under everything. Plotly draws the rows of a picture in the direction of the axis: upwards."""
        url = jpeg_url(mosaic.path, MOSAIC_QUALITY, MOSAIC_WIDTH_PX, upside_down=True)
        columns = min(mosaic.width_px, MOSAIC_WIDTH_PX)
        rows = max(round(mosaic.height_px * columns / mosaic.width_px), 1)
        across, up = (mosaic.right - mosaic.left) / columns, (mosaic.top - mosaic.bottom) / rows
        self._add("mosaic", "Mosaic", "#8d99ae", "area", [{
            "type": "image", "source": url, "x0": mosaic.left + 0.5 * across, "dx": across, "y0": mosaic.bottom + 0.5 * up, "dy": up,
            "zsmooth": "fast", "hoverinfo": "skip",
        }])  # fmt: skip

    def track(self, track: Track | None, key: str, label: str, colour: str, line: dict[str, Any]) -> None:
        if track is None or len(track.position) == 0:
            return
        points = self.axes.drawn(track.position)
        kept = simplify_line(points, MAX_TRACK_POINTS, self.extent_m * LINE_TOLERANCE_OF_EXTENT)
        chosen = kept.indices
        self._add(key, label, colour, "line", [{
            "type": "scatter", "mode": "lines", "name": label,
            "x": listed(points[chosen, 0], 3), "y": listed(points[chosen, 1], 3),
            "line": {"color": colour, **line},
            "customdata": listed(track.time_s[chosen], 2),
            "hovertemplate": f"{label}<br>t = %{{customdata:.1f}} s<br>{self._place}<extra></extra>",
        }])  # fmt: skip
        if len(chosen) < len(points):
            self._note_line(label, len(chosen), len(points), kept.deviation)

    def reference(self, files: RunFiles) -> None:
        if files.reference is None or len(files.reference["time_s"]) == 0:
            return
        time_s = files.reference["time_s"]
        points = self.axes.drawn(np.column_stack((files.reference["x_m"], files.reference["y_m"])))
        steps = len(files.trajectory.time_s) if files.trajectory is not None else 0
        if 5 * len(points) < steps:
            chosen, stride = every_nth(len(points), MAX_REFERENCE_MARKERS)
            mark = {"mode": "markers", "marker": {"color": style.REFERENCE, "size": 3.5}}
            if stride > 1:
                self.notes.append(f"Reference: one fix in {stride} of {count_text(len(points))} drawn.")
        else:
            kept = simplify_line(points, MAX_TRACK_POINTS, self.extent_m * LINE_TOLERANCE_OF_EXTENT)
            chosen = kept.indices
            mark = {"mode": "lines", "line": {"color": style.REFERENCE, "width": 2.6}}
            if len(chosen) < len(points):
                self._note_line("Reference", len(chosen), len(points), kept.deviation)
        self._add("reference", "Reference", style.REFERENCE, "dot" if mark["mode"] == "markers" else "line", [{
            "type": "scatter", "name": "Reference", **mark,
            "x": listed(points[chosen, 0], 3), "y": listed(points[chosen, 1], 3),
            "customdata": listed(time_s[chosen], 2),
            "hovertemplate": f"Reference<br>t = %{{customdata:.1f}} s<br>{self._place}<extra></extra>",
        }])  # fmt: skip

    def landmarks(self, landmarks: Landmarks | None) -> None:
        if landmarks is None or len(landmarks.id) == 0:
            return
        points = self.axes.drawn(landmarks.position)
        covariance = self.axes.drawn_covariance(landmarks.covariance)
        half_axes, _ = ellipse_axes(covariance)
        # one group per colour; group -1 holds landmarks whose submap is not listed
        group = np.array([self.colours.groups.get(int(submap), -1) for submap in landmarks.submap])
        dots: list[Trace] = []
        ellipses: list[Trace] = []
        drawn_ellipses, stride = every_nth(len(points), MAX_ELLIPSES)
        if stride > 1:
            self.notes.append(f"Ellipses: one landmark in {stride} of {count_text(len(points))} has its ellipse drawn.")
        drawn_dots, stride = every_nth(len(points), MAX_LANDMARKS)
        if stride > 1:
            self.notes.append(f"Landmarks: one in {stride} of {count_text(len(points))} drawn; the replay shows every one.")
        for number in sorted(set(group.tolist())):
            colour = PALETTE[number] if number >= 0 else UNKNOWN_COLOUR
            members = np.flatnonzero(group == number)
            outlined = np.intersect1d(members, drawn_ellipses)
            members = np.intersect1d(members, drawn_dots)
            outlines = ellipse_outlines(points[outlined], covariance[outlined], ELLIPSE_CORNERS)
            closed = np.concatenate((outlines, np.full((len(outlines), 1, 2), np.nan)), axis=1).reshape(-1, 2)
            ellipses.append({
                "type": "scatter", "mode": "lines", "x": listed(closed[:, 0], 3), "y": listed(closed[:, 1], 3),
                "line": {"color": colour, "width": 1}, "opacity": 0.75, "hoverinfo": "skip",
            })  # fmt: skip
            dots.append({
                "type": "scatter", "mode": "markers", "x": listed(points[members, 0], 3), "y": listed(points[members, 1], 3),
                "marker": {"color": colour, "size": 5, "line": {"color": "#ffffff", "width": 0.6}},
                "text": [landmarks.id[member] or "without a number" for member in members],
                "customdata": [
                    [int(landmarks.submap[m]), int(landmarks.times_seen[m]), *np.round(half_axes[m], 4).tolist()] for m in members
                ],
                "hovertemplate": "<b>Landmark %{text}</b><br>submap %{customdata[0]}, seen %{customdata[1]} times"
                f"<br>{self._place}<br>σ %{{customdata[2]:.3f}} × %{{customdata[3]:.3f}} {html.escape(self.axes.unit)}<extra></extra>",
            })  # fmt: skip
        swatch = "conic-gradient(" + ",".join(PALETTE[:6]) + ")"
        self._add("ellipses", "95 % ellipses", style.MUTED, "ring", ellipses)
        self._add("landmarks", "Landmarks", swatch, "dot", dots)

    def outlines(self, files: RunFiles) -> None:
        """Convex hull of the landmarks and the base of each submap, filled lightly in its colour."""
        if files.submaps is None or files.landmarks is None or not files.submaps.submaps:
            return
        points = self.axes.drawn(files.landmarks.position)
        by_group: dict[int, list[FloatArray]] = {}
        for entry in files.submaps.submaps:
            index = int(entry["index"])
            base = self.axes.drawn(np.array([entry["base_pose"][:2]], dtype=np.float64))
            corners = convex_hull(np.concatenate((points[files.landmarks.submap == index], base)))
            if len(corners) >= 3:
                by_group.setdefault(self.colours.groups[index], []).append(np.concatenate((corners, corners[:1], [[np.nan, np.nan]])))
        traces: list[Trace] = []
        for number in sorted(by_group):
            path = np.concatenate(by_group[number])
            red, green, blue = (int(PALETTE[number][start : start + 2], 16) for start in (1, 3, 5))
            traces.append({
                "type": "scatter", "mode": "lines", "x": listed(path[:, 0], 3), "y": listed(path[:, 1], 3), "fill": "toself",
                "fillcolor": f"rgba({red},{green},{blue},0.07)", "line": {"color": f"rgba({red},{green},{blue},0.35)", "width": 0.8},
                "hoverinfo": "skip",
            })  # fmt: skip
        if traces:
            self._add("outlines", "Outlines", "#cfd8e3", "area", traces)

    def bases(self, files: RunFiles) -> None:
        """Each base as two short arms: the forward axis long, the second axis short."""
        if files.submaps is None or not files.submaps.submaps:
            return
        pose = np.array([entry["base_pose"][:3] for entry in files.submaps.submaps], dtype=np.float64)
        spacing_m = self.extent_m / max(8.0, math.sqrt(len(pose)) * 2.0)
        arm_m = min(self.extent_m / 45.0, spacing_m / 2.5)
        forward = np.column_stack((np.cos(pose[:, 2]), np.sin(pose[:, 2])))
        second = np.column_stack((-forward[:, 1], forward[:, 0]))
        gap = np.full_like(forward, np.nan)
        position = pose[:, :2]
        arms = [
            self.axes.drawn(np.stack((position, position + length * direction, gap), axis=1).reshape(-1, 2))
            for direction, length in ((forward, arm_m), (second, 0.6 * arm_m))
        ]
        origin = self.axes.drawn(position)
        text = [_base_text(entry, html.escape(self.axes.unit)) for entry in files.submaps.submaps]
        traces: list[Trace] = [
            {"type": "scatter", "mode": "lines", "x": listed(arm[:, 0], 3), "y": listed(arm[:, 1], 3), "hoverinfo": "skip",
             "line": {"color": colour, "width": 1.4}}
            for arm, colour in zip(arms, ("#c1121f", "#2a7f3f"), strict=True)
        ]  # fmt: skip
        traces.append({
            "type": "scatter", "mode": "markers", "x": listed(origin[:, 0], 3), "y": listed(origin[:, 1], 3),
            "marker": {"size": 4, "symbol": "square", "color": "#ffffff", "line": {"color": style.INK, "width": 1}},
            "text": text, "hovertemplate": "%{text}<extra></extra>",
        })  # fmt: skip
        self._add("bases", "Base frames", "#c1121f", "frame", traces)

    def loops(self, files: RunFiles) -> None:
        if files.submaps is None or not files.submaps.loops:
            return
        base = {int(entry["index"]): entry["base_pose"][:2] for entry in files.submaps.submaps}
        known = [loop for loop in files.submaps.loops if loop.get("from") in base and loop.get("to") in base]
        accepted = [loop for loop in known if loop.get("accepted")]
        refused = [loop for loop in known if not loop.get("accepted")]
        if accepted:
            self._add("loops", "Loop closures", style.LOOP, "line", self._loop_traces(accepted, base, style.LOOP, "circle", 1.4, "solid"))
        if refused:
            chosen, stride = every_nth(len(refused), MAX_REFUSED_LINES)
            if stride > 1:
                self.notes.append(f"Refused pairs: one in {stride} of {count_text(len(refused))} drawn.")
            some = [refused[index] for index in chosen]
            traces = self._loop_traces(some, base, style.REFUSED, "x-thin-open", 0.9, "dot")
            self._add("refused", "Refused pairs", style.REFUSED, "dotted", traces, visible=False)

    def _loop_traces(
        self, loops: list[dict[str, Any]], base: dict[int, Any], colour: str, symbol: str, width_px: float, dash: str
    ) -> list[Trace]:
        ends = self.axes.drawn(np.array([[base[loop["from"]], base[loop["to"]]] for loop in loops], dtype=np.float64))
        path = np.concatenate((ends, np.full((len(ends), 1, 2), np.nan)), axis=1).reshape(-1, 2)
        middle = ends.mean(axis=1)
        return [
            {"type": "scatter", "mode": "lines", "x": listed(path[:, 0], 3), "y": listed(path[:, 1], 3), "hoverinfo": "skip",
             "line": {"color": colour, "width": width_px, "dash": dash}},
            {"type": "scatter", "mode": "markers", "x": listed(middle[:, 0], 3), "y": listed(middle[:, 1], 3),
             "marker": {"color": colour, "size": 5 if symbol == "circle" else 6, "symbol": symbol, "line": {"color": colour, "width": 1.2}},
             "text": [_loop_text(loop) for loop in loops], "hovertemplate": "%{text}<extra></extra>"},
        ]  # fmt: skip


def _base_text(entry: dict[str, Any], unit: str) -> str:
    x, y, heading = (float(value) for value in entry["base_pose"][:3])
    lines = [f"<b>Submap {int(entry['index'])}</b>", f"base {x:.2f} {unit}, {y:.2f} {unit}, {math.degrees(heading):.1f}°"]
    start_s, end_s = finite_number(entry.get("start_time_s")), finite_number(entry.get("end_time_s"))
    if start_s is not None and end_s is not None:
        lines.append(f"{start_s:.1f} s to {end_s:.1f} s")
    if finite_number(entry.get("landmarks")) is not None:
        lines.append(f"{int(entry['landmarks'])} landmarks")
    if entry.get("closed_because"):
        lines.append("closed: " + html.escape(str(entry["closed_because"])))
    return "<br>".join(lines)


def _loop_text(loop: dict[str, Any]) -> str:
    lines = [f"<b>Submap {loop['from']} and {loop['to']}: {'joined' if loop.get('accepted') else 'refused'}</b>"]
    if loop.get("reason"):
        lines.append(html.escape(str(loop["reason"])))
    time_s, chi2, dof = finite_number(loop.get("time_s")), finite_number(loop.get("chi2")), finite_number(loop.get("dof"))
    details = [] if time_s is None else [f"t = {time_s:.1f} s"]
    if finite_number(loop.get("pairs")) is not None:
        details.append(f"{loop['pairs']} pair{'' if loop['pairs'] == 1 else 's'}")
    if chi2 is not None and dof is not None:
        details.append(f"χ² {chi2:.1f} at {dof:.0f} dof")
    return "<br>".join([*lines, ", ".join(details)])
