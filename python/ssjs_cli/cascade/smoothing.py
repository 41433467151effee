"""Speckle averaged before anything else: pictures of a pyramid are sampled, not averaged, and would keep all of it."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssjs_cli import _core


def smoothed(levels: NDArray[Any], valid: NDArray[np.uint8] | None, size_px: int) -> NDArray[np.uint8]:
    """In 8 bits, each pixel the mean of the size_px x size_px pixels about it, those beyond the border mirrored; 1: as it is."""
    picture: NDArray[np.uint8] = _core.in_8_bits(np.ascontiguousarray(levels), valid)
    if size_px <= 1:
        return picture
    from scipy.ndimage import uniform_filter

    wide = uniform_filter(picture.astype(np.float64), size_px, mode="mirror")
    averaged: NDArray[np.uint8] = np.rint(wide).astype(np.uint8)
    return averaged
