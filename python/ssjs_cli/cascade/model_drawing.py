"""Haar features drawn over the mean object: where they add is light, where they subtract is dark."""

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from ssjs_cli.cascade.windows import Feature
from ssjs_cli.segmentation.pictures import Pixels

PICTURE_PX = 120
_GREY = 128
_ADDED, _SUBTRACTED = (255, 196, 61), (20, 60, 160)
_OPACITY = 0.62


def feature_picture(feature: Feature, mean: NDArray[np.uint8] | None, window_px: tuple[int, int]) -> Pixels:
    """mean: the mean positive of the window's size; None: plain grey."""
    scale = max(1, PICTURE_PX // max(window_px))
    size = (scale * window_px[0], scale * window_px[1])
    ground = np.full((window_px[1], window_px[0]), _GREY, dtype=np.uint8) if mean is None or mean.shape != window_px[::-1] else mean
    grey = np.asarray(Image.fromarray(drawn_out(ground)).resize(size, Image.Resampling.NEAREST), dtype=np.float64)
    weights = feature_weights(feature, size, scale)
    result = np.repeat(grey[:, :, np.newaxis], 3, axis=2)
    for colour, inside in ((_ADDED, weights > 0), (_SUBTRACTED, weights < 0)):
        result[inside] = (1 - _OPACITY) * result[inside] + _OPACITY * np.array(colour, dtype=np.float64)
    return np.rint(result).astype(np.uint8)


def feature_weights(feature: Feature, size: tuple[int, int], scale: int) -> NDArray[np.float64]:
    """What the feature multiplies each pixel with, of a window magnified `scale` times."""
    total = np.zeros((size[1], size[0]))
    for left, top, width, height, weight in feature.parts:
        canvas = Image.new("L", size, 0)
        draw = ImageDraw.Draw(canvas)
        if feature.tilted:
            corners = [
                (left, top),
                (left + width, top + width),
                (left + width - height, top + width + height),
                (left - height, top + height),
            ]
            draw.polygon([(scale * x, scale * y) for x, y in corners], fill=1)
        else:
            draw.rectangle((scale * left, scale * top, scale * (left + width) - 1, scale * (top + height) - 1), fill=1)
        total += weight * np.asarray(canvas, dtype=np.float64)
    return total


def drawn_out(levels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """From black to white."""
    low, high = int(levels.min()), int(levels.max())
    if high == low:
        return levels
    return np.rint(255.0 * (levels.astype(np.float64) - low) / (high - low)).astype(np.uint8)


def describe_feature(feature: Feature) -> str:
    """'8 dark : 1 bright, bright right' for two regions side by side along the range axis, otherwise the number of rectangles."""
    proportion = side_scan_proportion(feature)
    if proportion is None:
        return f"{'tilted, ' if feature.tilted else ''}{len(feature.parts)} rectangles"
    dark, gap, bright_is_right = proportion
    return f"{dark}:1{', gap' if gap else ''}, bright {'right' if bright_is_right else 'left'}"


def side_scan_proportion(feature: Feature) -> tuple[int, bool, bool] | None:
    """Dark to bright, whether they are apart, whether the bright region is on the right; None for features of another kind."""
    parts = feature.parts
    if feature.tilted or len(parts) not in (2, 3):
        return None
    left, top, width, height, outer_weight = parts[0]
    *bright_box, bright_weight = parts[-1]
    same_rows = all(part[1] == top and part[3] == height for part in parts)
    at_right = bright_box[0] + bright_box[2] == left + width
    at_left = bright_box[0] == left
    if not same_rows or outer_weight != -1 or at_left == at_right:
        return None
    dark = width - bright_box[2] * (2 if len(parts) == 3 else 1)
    if dark <= 0 or dark % bright_box[2] != 0 or bright_weight != dark // bright_box[2] + 1:
        return None
    return dark // bright_box[2], len(parts) == 3, at_right
