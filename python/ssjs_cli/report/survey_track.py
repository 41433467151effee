"""The track of an underwater vehicle in the colours of its submaps, as the views of the survey draw it."""

from dataclasses import dataclass

import numpy as np

from ssjs_cli.report import figure_style as style
from ssjs_cli.report.figure_style import FloatArray, IndexArray
from ssjs_cli.report.map_figure import SubmapColours
from ssjs_cli.report.result_files import RunFiles
from ssjs_cli.report.simplification import keep_extremes, simplify_line
from ssjs_cli.report.submap_colours import PALETTE

MAX_POINTS = 3000
DEPTH_SPANS = 500
TOLERANCE_OF_EXTENT = 1.0 / 4000.0


@dataclass(frozen=True)
class TrackPiece:
    """Every stretch of the track in one colour: points (n, 3) x, y, depth with a row of NaN between two stretches, and their times."""

    colour: str
    time_s: FloatArray
    points: FloatArray


def drawn_rows(files: RunFiles) -> IndexArray:
    """Rows of the final track that draw it from above and from the side."""
    track = files.trajectory
    assert track is not None and track.depth is not None
    extent_m = max(float(np.ptp(track.position, axis=0).max()), 1.0)
    from_above = simplify_line(track.position, MAX_POINTS, extent_m * TOLERANCE_OF_EXTENT).indices
    return np.union1d(from_above, keep_extremes(track.time_s, track.depth, DEPTH_SPANS))


def coloured_track(files: RunFiles, colours: SubmapColours) -> list[TrackPiece]:
    """One piece a colour, in the order of the palette; a track without submaps is one piece."""
    track = files.trajectory
    assert track is not None and track.depth is not None
    rows = drawn_rows(files)
    points = np.column_stack((track.position, track.depth))
    members = files.trajectory_submaps
    if members is None or len(members["submap"]) != len(points):
        return [TrackPiece(style.FINAL, track.time_s[rows], points[rows])]
    submap = members["submap"].astype(np.int64)
    # the last row before a border and the first behind it: a piece ends where the next one begins
    borders = np.flatnonzero(np.diff(submap)) + 1
    rows = np.union1d(rows, borders)
    cuts = np.concatenate(([0], np.searchsorted(rows, borders), [len(rows) - 1]))
    by_colour: dict[str, list[IndexArray]] = {}
    for first, last in zip(cuts[:-1].tolist(), cuts[1:].tolist(), strict=True):
        if last > first:
            colour = colours.colour(int(submap[rows[first]]))
            by_colour.setdefault(colour, []).append(rows[first : last + 1])
    ordered = sorted(by_colour, key=lambda colour: PALETTE.index(colour) if colour in PALETTE else len(PALETTE))
    return [_piece(colour, by_colour[colour], track.time_s, points) for colour in ordered]


def _piece(colour: str, stretches: list[IndexArray], time_s: FloatArray, points: FloatArray) -> TrackPiece:
    gap = np.full((1, 3), np.nan)
    parts = [part for stretch in stretches for part in (points[stretch], gap)][:-1]
    times = [part for stretch in stretches for part in (time_s[stretch], gap[0, :1])][:-1]
    return TrackPiece(colour, np.concatenate(times), np.concatenate(parts))
