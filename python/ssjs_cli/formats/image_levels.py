"""Pixel values of any kind as the levels a threshold works on: 8 or 16 bits, and where they are measurements.

| values | become |
|---|---|
| 8 or 16 bits without sign | themselves |
| one bit | 0 and 255 |
| whole numbers that lie in 0 to 65535 | themselves, in 16 bits |
| other whole or real numbers | their valid range drawn out linearly to 0 to 65535 |
| three channels | the channel, where all three are equal; otherwise the luminance 0.299 R + 0.587 G + 0.114 B (ITU-R BT.601) |
| alpha | invalid where 0 |
| NaN, infinity | invalid |
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Levels = NDArray[np.uint8] | NDArray[np.uint16]
Mask = NDArray[np.uint8]

HIGHEST_16_BIT = 65535
SET = 255
#: Rows are worked on in blocks, so that a large mosaic is not held several times over.
BLOCK_PIXELS = 4_000_000
_LUMINANCE_PER_MILLE = (299, 587, 114)


@dataclass(frozen=True)
class LevelImage:
    """levels (h, w); valid (h, w), 255 where a pixel is a measurement, None: everywhere; notes: how the levels were made."""

    levels: Levels
    valid: Mask | None
    notes: tuple[str, ...] = ()

    @property
    def height_px(self) -> int:
        return int(self.levels.shape[0])

    @property
    def width_px(self) -> int:
        return int(self.levels.shape[1])

    @property
    def bits(self) -> int:
        return 8 * int(self.levels.dtype.itemsize)


#: rows(first, last) -> (rows, w) or (rows, w, channels)
RowReader = Callable[[int, int], NDArray[Any]]


def levels_of(rows: RowReader, height_px: int, width_px: int) -> LevelImage:
    """Channels: 1; 2 (grey and alpha); 3; 4 (colour and alpha). Raises ValueError for anything else."""
    first = rows(0, 1)
    channels = 1 if first.ndim == 2 else int(first.shape[2])
    if channels > 4:
        raise ValueError(f"has {channels} channels")
    if first.dtype.kind not in "buif":
        raise ValueError(f"holds values of the type {first.dtype}")
    blocks = _Blocks(rows, height_px, width_px)
    notes: list[str] = []
    valid = _alpha_mask(blocks) if channels in (2, 4) else None
    grey = _first_channel
    if channels >= 3 and not all(_is_grey(block) for _, block in blocks):
        grey = _luminance
        notes.append("colour reduced to its luminance")
    if first.dtype.kind == "b" or first.dtype in (np.uint8, np.uint16):
        dtype = np.uint16 if first.dtype == np.uint16 else np.uint8
        levels = np.empty((height_px, width_px), dtype=dtype)
        factor = SET if first.dtype.kind == "b" else 1
        for span, block in blocks:
            levels[span] = grey(block) * dtype(factor)
        return LevelImage(levels, valid, tuple(notes))
    return _drawn_out(blocks, grey, valid, notes)


@dataclass(frozen=True)
class _Blocks:
    rows: RowReader
    height_px: int
    width_px: int

    def __iter__(self) -> Iterator[tuple[slice, NDArray[Any]]]:
        step = max(1, BLOCK_PIXELS // self.width_px)
        for first in range(0, self.height_px, step):
            last = min(first + step, self.height_px)
            yield slice(first, last), self.rows(first, last)


def _first_channel(block: NDArray[Any]) -> NDArray[Any]:
    return block if block.ndim == 2 else block[:, :, 0]


def _is_grey(block: NDArray[Any]) -> bool:
    red = block[:, :, 0]
    return bool(np.array_equal(red, block[:, :, 1]) and np.array_equal(red, block[:, :, 2]))


def _luminance(block: NDArray[Any]) -> NDArray[Any]:
    whole = block.dtype.kind in "bu" and block.dtype.itemsize <= 2
    wide = block[:, :, :3].astype(np.uint32 if whole else np.float64)
    total: NDArray[Any] = wide @ np.array(_LUMINANCE_PER_MILLE, dtype=wide.dtype)
    return ((total + 500) // 1000).astype(block.dtype) if whole else total / 1000.0


def _alpha_mask(blocks: _Blocks) -> Mask | None:
    """None where nothing is transparent."""
    valid = np.empty((blocks.height_px, blocks.width_px), dtype=np.uint8)
    for span, block in blocks:
        valid[span] = np.where(block[:, :, -1] != 0, SET, 0)
    return None if bool(valid.all()) else valid


def _drawn_out(blocks: _Blocks, grey: Callable[[NDArray[Any]], NDArray[Any]], valid: Mask | None, notes: list[str]) -> LevelImage:
    """Real numbers, signed ones and those of more than 16 bits."""
    measured = np.full((blocks.height_px, blocks.width_px), SET, dtype=np.uint8) if valid is None else valid
    lowest, highest, whole = np.inf, -np.inf, True
    for span, block in blocks:
        values = grey(block)
        if values.dtype.kind == "f":
            whole = False
            measured[span][~np.isfinite(values)] = 0
        used = values[measured[span] != 0]
        if used.size:
            lowest, highest = min(lowest, float(used.min())), max(highest, float(used.max()))
    levels = np.zeros((blocks.height_px, blocks.width_px), dtype=np.uint16)
    keeps_values = whole and lowest >= 0 and highest <= HIGHEST_16_BIT
    span_of_values = highest - lowest
    for span, block in blocks:
        inside = measured[span] != 0
        values = grey(block)[inside]
        if keeps_values:
            levels[span][inside] = values.astype(np.uint16)
        elif span_of_values > 0:
            # halves first: the span of the largest real numbers is no number any more
            fraction = (values.astype(np.float64) / 2 - lowest / 2) / (highest / 2 - lowest / 2)
            levels[span][inside] = np.rint(HIGHEST_16_BIT * fraction).astype(np.uint16)
    if not keeps_values and np.isfinite(lowest):
        notes.append(f"values from {lowest:.9g} to {highest:.9g} drawn out to 16 bits")
    return LevelImage(levels, None if bool(measured.all()) else measured, tuple(notes))
