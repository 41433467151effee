"""Training windows as arrays (n, height, width) of uint8, and the core's sets of them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssjs_cli import _core
from ssjs_cli.formats.annotations.boxes import Box

Windows = NDArray[np.uint8]
#: The core's seeds are whole numbers of 31 bits.
_SEED_MODULUS = 2**31


def core_seed(seed: int) -> int:
    return seed % _SEED_MODULUS


def no_windows(width_px: int, height_px: int) -> Windows:
    return np.zeros((0, height_px, width_px), dtype=np.uint8)


def window_set(windows: Windows, recordings: Sequence[int] = ()) -> _core.WindowSet:
    made = _core.WindowSet(int(windows.shape[2]), int(windows.shape[1]))
    for index in range(len(windows)):
        made.add(np.ascontiguousarray(windows[index]), recordings[index] if recordings else 0)
    return made


def window_of(levels: NDArray[np.uint8], box: Box, width_px: int, height_px: int) -> NDArray[np.uint8] | None:
    """(height, width): the box resampled; None where it leaves the picture."""
    made = _core.WindowSet(width_px, height_px)
    return made.picture(0) if made.add_object(levels, box) else None


def background_windows(
    count: int, read: Callable[[int], Any], wanted: int, width_px: int, height_px: int, seed: int, name: str, threads: int
) -> Windows:
    """Windows at random places of `count` pictures; fewer than wanted where most of them hold invalid pixels."""
    mined, _, _, _ = _core.mine_negatives(None, width_px, height_px, count, read, wanted, seed=core_seed(seed), name=name, threads=threads)
    return mined.pictures()


def judged(cascade: _core.HaarCascade, windows: Windows) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Layers passed, -1 for windows too flat to be looked at, and scores."""
    verdicts = cascade.judge(window_set(windows))
    return np.array([passed for passed, _ in verdicts], dtype=np.int64), np.array([score for _, score in verdicts], dtype=np.float64)


@dataclass(frozen=True)
class Feature:
    """parts: left, top, width, height, weight."""

    tilted: bool
    parts: list[tuple[int, int, int, int, float]]

    def values(self, windows: Windows) -> NDArray[np.float64]:
        return np.array(window_set(windows).responses(self.tilted, self.parts), dtype=np.float64)


@dataclass(frozen=True)
class Weak:
    """nodes: feature, threshold, left, right."""

    nodes: list[tuple[int, float, int, int]]
    leaves: list[float]


@dataclass(frozen=True)
class Stage:
    threshold: float
    weak: list[Weak]


def features_of(cascade: _core.HaarCascade) -> list[Feature]:
    return [Feature(tilted, parts) for tilted, parts in cascade.features()]


def stages_of(cascade: _core.HaarCascade) -> list[Stage]:
    return [Stage(threshold, [Weak(nodes, leaves) for nodes, leaves in weak]) for threshold, weak in cascade.stages]
