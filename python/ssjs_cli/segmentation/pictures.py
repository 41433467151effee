"""What the eye sees of a segmentation: the picture with the borders and centroids of its regions, and small versions side by side.

Nothing here is measured on: pictures are drawn out for the eye and shrunk by whole factors, masks so that no region vanishes.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from ssjs_cli.formats.image_levels import LevelImage, Levels, Mask

Colour = tuple[int, int, int]
Pixels = NDArray[np.uint8]
Point = tuple[float, float]

INVALID: Colour = (27, 38, 66)
BORDER: Colour = (255, 158, 27)
CENTROID: Colour = (255, 45, 85)
OBJECT: Colour = (64, 224, 255)
TRUTH: Colour = (70, 230, 110)
#: Overlays are not larger than this on their longer side.
MAX_OVERLAY_PX = 4096
#: What is drawn out to black and white: all but the darkest and brightest few valid pixels.
_DARK_QUANTILE, _BRIGHT_QUANTILE = 0.002, 0.998
_SAMPLE_PIXELS = 2_000_000
#: A small picture is magnified no more than this.
_MAX_MAGNIFICATION = 4


@dataclass(frozen=True)
class Drawing:
    """What is drawn of one image. regions_px, objects_px: centroids (x, y), the centre of the first pixel at (0, 0)."""

    image: LevelImage
    mask: Mask
    regions_px: Sequence[Point]
    objects_px: Sequence[Point]


def picture_with_truth(image: LevelImage, truth: Mask, box_px: tuple[int, int]) -> Pixels:
    """A thumbnail with the borders of what is truly there."""
    small, _ = _thumbnail(Drawing(image, truth, [], []), box_px)
    result = _coloured(small)
    result[_inner_border(small.mask)] = TRUTH
    return result


@dataclass(frozen=True)
class Panels:
    """(h, w, 3) each, of one size: the picture, its mask, the picture with regions and centroids."""

    original: Pixels
    mask: Pixels
    marked: Pixels


def overlay(drawing: Drawing) -> Pixels:
    """In full size up to MAX_OVERLAY_PX, then shrunk by a whole factor."""
    factor = math.ceil(max(drawing.image.levels.shape) / MAX_OVERLAY_PX)
    small = _shrunk(drawing, factor)
    return _with_marks(small, drawing, scale=1.0 / factor, mark_px=_mark_px(max(small.grey.shape)))


def panels(drawing: Drawing, box_px: tuple[int, int]) -> Panels:
    """Thumbnails that fit into a box of (width, height)."""
    small, scale = _thumbnail(drawing, box_px)
    mask = np.repeat(small.mask[:, :, np.newaxis], 3, axis=2)
    if small.valid is not None:
        mask[small.valid == 0] = INVALID
    return Panels(_coloured(small), mask, _with_marks(small, drawing, scale=scale, mark_px=3))


@dataclass(frozen=True)
class _Small:
    """8-bit display levels, mask and validity of one size."""

    grey: Pixels
    mask: Mask
    valid: Mask | None


def _thumbnail(drawing: Drawing, box_px: tuple[int, int]) -> tuple[_Small, float]:
    """With its scale, thumbnail pixels a pixel."""
    height_px, width_px = drawing.image.levels.shape
    scale = min(box_px[0] / width_px, box_px[1] / height_px, _MAX_MAGNIFICATION)
    size = (max(1, round(scale * width_px)), max(1, round(scale * height_px)))
    small = _shrunk(drawing, max(1, int(1.0 / scale)))
    grey = _resized(small.grey, size, Image.Resampling.BOX if scale < 1 else Image.Resampling.NEAREST)
    valid = None if small.valid is None else _resized(small.valid, size, Image.Resampling.NEAREST)
    return _Small(grey, _resized_mask(small.mask, size), valid), scale


def _shrunk(drawing: Drawing, factor: int) -> _Small:
    image = drawing.image
    table = display_table(image)
    grey = _in_blocks(image.levels, factor, lambda block: table[block], np.mean)
    mask = _in_blocks(drawing.mask, factor, _unchanged, np.max)
    valid = None if image.valid is None else _in_blocks(image.valid, factor, _unchanged, np.max)
    return _Small(grey, mask, valid)


def display_table(image: LevelImage) -> Pixels:
    """Level -> grey for the eye."""
    step = max(1, math.isqrt(image.levels.size // _SAMPLE_PIXELS))
    sample = image.levels[::step, ::step]
    if image.valid is not None:
        sample = sample[image.valid[::step, ::step] != 0]
    levels = np.arange(256 if image.bits == 8 else 65536, dtype=np.float64)
    low, high = (float(value) for value in np.quantile(sample, (_DARK_QUANTILE, _BRIGHT_QUANTILE))) if sample.size else (0.0, 255.0)
    if high <= low:
        low, high = min(low, 0.0), max(high, 255.0 if image.bits == 8 else 65535.0)
    return np.clip(np.rint(255.0 * (levels - low) / (high - low)), 0, 255).astype(np.uint8)


def _in_blocks(pixels: Levels, factor: int, prepare: Callable[[Levels], Pixels], reduce: Callable[..., Any]) -> Pixels:
    """Squares of factor x factor pixels become one; those at the far borders may be cut."""
    if factor == 1:
        return np.ascontiguousarray(prepare(pixels))
    height_px, width_px = pixels.shape
    rows, columns = math.ceil(height_px / factor), math.ceil(width_px / factor)
    result = np.empty((rows, columns), dtype=np.uint8)
    for row in range(rows):
        strip = prepare(pixels[row * factor : (row + 1) * factor])
        whole = width_px // factor
        result[row, :whole] = np.rint(reduce(strip[:, : whole * factor].reshape(strip.shape[0], whole, factor), axis=(0, 2)))
        if whole < columns:
            result[row, whole] = np.rint(reduce(strip[:, whole * factor :]))
    return result


def _unchanged(block: Levels) -> Pixels:
    return block.astype(np.uint8, copy=False)


def _resized(pixels: Pixels, size: tuple[int, int], resampling: Image.Resampling) -> Pixels:
    return np.asarray(Image.fromarray(pixels).resize(size, resampling))


def _resized_mask(mask: Mask, size: tuple[int, int]) -> Mask:
    """A pixel is set where any part of it is: what is small stays to be seen."""
    return np.where(np.asarray(Image.fromarray(mask).resize(size, Image.Resampling.BOX)) > 0, 255, 0).astype(np.uint8)


def _coloured(small: _Small) -> Pixels:
    result = np.repeat(small.grey[:, :, np.newaxis], 3, axis=2)
    if small.valid is not None:
        result[small.valid == 0] = INVALID
    return result


def _with_marks(small: _Small, drawing: Drawing, *, scale: float, mark_px: int) -> Pixels:
    result = _coloured(small)
    result[_inner_border(small.mask)] = BORDER
    picture = Image.fromarray(result)
    canvas = ImageDraw.Draw(picture)
    for x_px, y_px in drawing.objects_px:
        x, y = (x_px + 0.5) * scale - 0.5, (y_px + 0.5) * scale - 0.5
        reach = 2 * mark_px
        canvas.ellipse((x - reach, y - reach, x + reach, y + reach), outline=OBJECT, width=max(1, mark_px // 3))
    for x_px, y_px in drawing.regions_px:
        x, y = (x_px + 0.5) * scale - 0.5, (y_px + 0.5) * scale - 0.5
        width = max(1, mark_px // 3)
        canvas.line((x - mark_px, y, x + mark_px, y), fill=CENTROID, width=width)
        canvas.line((x, y - mark_px, x, y + mark_px), fill=CENTROID, width=width)
    return np.asarray(picture)


def _mark_px(longer_side_px: int) -> int:
    return max(3, min(10, longer_side_px // 100))


def _inner_border(mask: Mask) -> NDArray[np.bool_]:
    """Set pixels with a clear one beside, above or below them."""
    is_set = mask != 0
    inside = is_set.copy()
    inside[1:] &= is_set[:-1]
    inside[:-1] &= is_set[1:]
    inside[:, 1:] &= is_set[:, :-1]
    inside[:, :-1] &= is_set[:, 1:]
    border: NDArray[np.bool_] = is_set & ~inside
    return border
