"""Fewer points, same picture: what is left out of a drawn line, and by how much the drawing can then be wrong.

A page with every one of 60,000 steps would be slow and no sharper: the screen has some 1,300 columns. Nothing here touches a number that is
printed; statistics are always taken over every row of the file.
"""

import heapq
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IndexArray = NDArray[np.int64]


@dataclass(frozen=True)
class SimplifiedLine:
    """indices: the rows kept, ascending, first and last row always among them.

    deviation: the largest distance from a row left out to the drawn line, in the unit of the points.
    """

    indices: IndexArray
    deviation: float


def simplify_line(points: FloatArray, max_points: int, tolerance: float) -> SimplifiedLine:
    """Ramer-Douglas-Peucker, worst point first: splits where the drawn line is farthest off until it is within `tolerance` everywhere or
    `max_points` are kept. points (n, 2), both columns in the same unit; distances are to the chord, so closed tracks are safe."""
    count = len(points)
    if count <= 2:
        return SimplifiedLine(np.arange(count, dtype=np.int64), 0.0)
    kept = [0, count - 1]
    waiting: list[tuple[float, int, int, int]] = []
    _push_farthest(waiting, points, 0, count - 1)
    while waiting and len(kept) < max_points and -waiting[0][0] > tolerance:
        _, first, split, last = heapq.heappop(waiting)
        kept.append(split)
        _push_farthest(waiting, points, first, split)
        _push_farthest(waiting, points, split, last)
    deviation = -waiting[0][0] if waiting else 0.0
    return SimplifiedLine(np.array(sorted(kept), dtype=np.int64), deviation)


def _push_farthest(waiting: list[tuple[float, int, int, int]], points: FloatArray, first: int, last: int) -> None:
    if last - first < 2:
        return
    inner = points[first + 1 : last]
    chord = points[last] - points[first]
    length_squared = float(chord @ chord)
    offset = inner - points[first]
    along = np.clip(offset @ chord / length_squared, 0.0, 1.0) if length_squared > 0.0 else np.zeros(len(inner))
    distance = np.hypot(offset[:, 0] - along * chord[0], offset[:, 1] - along * chord[1])
    farthest = int(np.argmax(distance))
    heapq.heappush(waiting, (-float(distance[farthest]), first, first + 1 + farthest, last))


def span_edges(time_s: FloatArray, spans: int) -> IndexArray:
    """Row numbers that cut `time_s` (ascending) into at most `spans` non-empty runs of equal duration; first 0, last n."""
    count = len(time_s)
    if count == 0:
        return np.zeros(1, dtype=np.int64)
    cuts = np.linspace(time_s[0], time_s[-1], spans + 1)[1:-1]
    inner = np.searchsorted(time_s, cuts, side="left")
    return np.unique(np.concatenate(([0], inner, [count]))).astype(np.int64)


def keep_extremes(time_s: FloatArray, value: FloatArray, spans: int) -> IndexArray:
    """Rows that draw a curve over time without losing a peak: first, last, lowest and highest of each of `spans` equal time spans.
    With one span per screen column the picture is the same as with every row. [jugel2014]"""
    if len(time_s) <= 4 * spans:
        return np.arange(len(time_s), dtype=np.int64)
    edges = span_edges(time_s, spans)
    kept: set[int] = set()
    for first, end in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        run = value[first:end]
        kept.update((first, first + int(np.argmin(run)), first + int(np.argmax(run)), end - 1))
    return np.array(sorted(kept), dtype=np.int64)


def every_nth(count: int, max_points: int) -> tuple[IndexArray, int]:
    """Row numbers 0, n, 2n ... with the smallest n that keeps at most `max_points`, and that n."""
    stride = max(1, -(-count // max_points))
    return np.arange(0, count, stride, dtype=np.int64), stride
