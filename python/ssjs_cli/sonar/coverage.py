"""Where the sonar has listened: cells of the seabed between the near and the far range of each ping, counted once a pass."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssjs_cli.formats.number_table import FloatArray, IntArray
from ssjs_cli.formats.tum import PoseSeries
from ssjs_cli.sonar.survey_record import Reach

#: The finest of these that keeps the grid within MOST_CELLS.
CELL_SIZES_M = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0)
MOST_CELLS = 4_000_000
#: A cell heard again after this time was passed again.
PASS_GAP_S = 20.0
#: Pings farther apart in time have nothing between them.
LONGEST_PING_GAP_S = 3.0
#: Part of PASS_GAP_S that is worked on at once.
CHUNK_S = 5.0


@dataclass(frozen=True)
class Coverage:
    """passes (rows, columns): rows along x, columns along y of the global frame, cells of cell_m, the corner of the first at corner_m.

    surveyed_m2: convex hull of the covered cells, what the survey goes around; the shares are of it."""

    passes: IntArray
    corner_m: FloatArray
    cell_m: float
    surveyed_m2: float

    @property
    def covered_m2(self) -> float:
        return float((self.passes > 0).sum()) * self.cell_m**2

    @property
    def twice_m2(self) -> float:
        return float((self.passes > 1).sum()) * self.cell_m**2

    def numbers(self) -> dict[str, Any]:
        """For summary.json."""
        share = min(self.covered_m2 / self.surveyed_m2, 1.0) if self.surveyed_m2 > 0.0 else None
        twice = min(self.twice_m2 / self.surveyed_m2, 1.0) if self.surveyed_m2 > 0.0 else None
        return {
            "coverage_area_m2": round(self.covered_m2, 1),
            "coverage_area_twice_m2": round(self.twice_m2, 1),
            "surveyed_area_m2": round(self.surveyed_m2, 1),
            "coverage_fraction": None if share is None else round(share, 6),
            "coverage_twice_fraction": None if twice is None else round(twice, 6),
            "coverage_cell_m": self.cell_m,
        }


def coverage(track: PoseSeries, reach: Reach) -> Coverage | None:
    """By the final track. None where the sonar has listened nowhere."""
    ends = _ends(track, reach)
    heard = np.isfinite(ends).all(axis=(2, 3))
    if not heard.any():
        return None
    low, high = np.nanmin(ends, axis=(0, 1, 2)), np.nanmax(ends, axis=(0, 1, 2))
    cell_m = next((size for size in CELL_SIZES_M if np.prod(np.ceil((high - low) / size) + 1.0) <= MOST_CELLS), CELL_SIZES_M[-1])
    corner = np.floor(low / cell_m) * cell_m
    shape = (np.floor((high - corner) / cell_m).astype(np.int64) + 1).tolist()
    passes = np.zeros(shape[0] * shape[1], dtype=np.int64)
    heard_last_s = np.full(len(passes), -np.inf)
    for first, end in _chunks(reach.time_s):
        cells, times = _cells_of(ends[first : end + 1], reach.time_s[first : end + 1], corner, cell_m, shape[1])
        if not len(cells):
            continue
        seen, position, inverse = np.unique(cells, return_index=True, return_inverse=True)
        # cells come in the order of time: the first of each is its earliest
        passes[seen] += times[position] - heard_last_s[seen] > PASS_GAP_S
        latest = np.full(len(seen), -np.inf)
        np.maximum.at(latest, inverse, times)
        heard_last_s[seen] = latest
    grid = passes.reshape(shape)
    return Coverage(grid, corner, cell_m, _hull_area_m2(grid, cell_m))


def write_coverage(path: Path, found: Coverage) -> None:
    np.savez_compressed(path, passes=np.minimum(found.passes, 255).astype(np.uint8), corner_m=found.corner_m, cell_m=found.cell_m)


def _ends(track: PoseSeries, reach: Reach) -> FloatArray:
    """(n, 2 sides, near and far, x and y): where the swath of each ping begins and ends, NaN on a silent side. The vehicle taken level."""
    x, y = (np.interp(reach.time_s, track.time_s, track.pose[:, axis]) for axis in (0, 1))
    heading = np.interp(reach.time_s, track.time_s, np.unwrap(track.pose[:, 2]))
    starboard = np.column_stack((-np.sin(heading), np.cos(heading)))
    across_m = reach.ranges_m.reshape(-1, 2, 2) * np.array([-1.0, 1.0])[None, :, None]
    place: FloatArray = np.column_stack((x, y))[:, None, None, :] + across_m[..., None] * starboard[:, None, None, :]
    outside = (reach.time_s < track.time_s[0]) | (reach.time_s > track.time_s[-1])
    place[outside] = np.nan
    return place


def _chunks(time_s: FloatArray) -> list[tuple[int, int]]:
    """Runs of rows of at most CHUNK_S; each goes on to the first row of the next one."""
    edges = np.flatnonzero(np.diff(np.floor(time_s / CHUNK_S))) + 1
    starts = [0, *edges.tolist()]
    return list(zip(starts, [*edges.tolist(), len(time_s) - 1], strict=True))


def _cells_of(ends: FloatArray, time_s: FloatArray, corner: FloatArray, cell_m: float, columns: int) -> tuple[IntArray, FloatArray]:
    """Cell numbers under the swath between the rows, in the order of time, and when each was heard."""
    found: list[IntArray] = []
    when: list[FloatArray] = []
    for row in range(len(time_s) - 1):
        if time_s[row + 1] - time_s[row] > LONGEST_PING_GAP_S:
            continue
        for side in range(2):
            quad = ends[row : row + 2, side]
            if np.isnan(quad).any():
                continue
            points = _filled(quad, 0.5 * cell_m)
            cell = np.floor((points - corner) / cell_m).astype(np.int64)
            number = np.unique(cell[:, 0] * columns + cell[:, 1])
            found.append(number)
            when.append(np.full(len(number), time_s[row]))
    if not found:
        return np.zeros(0, dtype=np.int64), np.zeros(0)
    return np.concatenate(found), np.concatenate(when)


def _filled(quad: FloatArray, step_m: float) -> FloatArray:
    """Points (n, 2) no farther apart than step_m that fill the quadrilateral (2 rows, near and far, 2)."""
    along = int(np.ceil(float(np.linalg.norm(quad[1] - quad[0], axis=1).max()) / step_m)) + 1
    across = int(np.ceil(float(np.linalg.norm(quad[:, 1] - quad[:, 0], axis=1).max()) / step_m)) + 1
    u, v = np.linspace(0.0, 1.0, along)[:, None, None], np.linspace(0.0, 1.0, across)[None, :, None]
    near = quad[0, 0] * (1.0 - u) + quad[1, 0] * u
    far = quad[0, 1] * (1.0 - u) + quad[1, 1] * u
    points: FloatArray = (near * (1.0 - v) + far * v).reshape(-1, 2)
    return points


def covered_hull(passes: NDArray[np.int64]) -> FloatArray:
    """Corners (n, 2) of the convex hull of the covered cells, in cells from the grid's corner."""
    from ssjs_cli.report.planar_shapes import convex_hull

    rows = np.flatnonzero((passes > 0).any(axis=1))
    first = np.argmax(passes[rows] > 0, axis=1)
    last = passes.shape[1] - 1 - np.argmax((passes[rows] > 0)[:, ::-1], axis=1)
    corners = [np.column_stack((rows + i, edge)) for i in (0, 1) for edge in (first, last + 1)]
    return convex_hull(np.concatenate(corners).astype(np.float64))


def _hull_area_m2(passes: IntArray, cell_m: float) -> float:
    x, y = covered_hull(passes).T
    return 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1))) * cell_m**2
