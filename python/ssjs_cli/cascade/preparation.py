"""What is done to a picture before a cascade sees it, in training and detection alike: smoothed, and continued beyond its borders.

An object at the border is cut. Mirrored beyond the border the picture goes on as the ground does, and the part of the object that shows
becomes a whole with its mirror image, which a window can hold in its middle.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssjs_cli.cascade.smoothing import smoothed
from ssjs_cli.config import Scalar
from ssjs_cli.formats.annotations.boxes import Box

SMOOTHING_KEY = "image.smoothing_px"
BORDER_KEY = "image.border_px"
#: Objects whose box ends so near the border are cut by it.
_TOUCHING_PX = 1
#: Of a box that reaches over the border at least this part of each side lies in the picture, or it is the mirror image of something.
_LEAST_PART_INSIDE = 1 / 3


@dataclass(frozen=True)
class Preparation:
    """smoothing_px: side of the squares averaged over, 1: none. border_px: pixels mirrored beyond each border."""

    smoothing_px: int = 1
    border_px: int = 0

    def picture(self, levels: NDArray[Any], valid: NDArray[np.uint8] | None) -> tuple[NDArray[np.uint8], NDArray[np.uint8] | None]:
        """In 8 bits, and where it is valid."""
        return self.continued(smoothed(levels, valid, self.smoothing_px)), None if valid is None else self.continued(valid)

    def continued(self, picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
        return np.ascontiguousarray(np.pad(picture, self.border_px, mode="reflect")) if self.border_px else picture

    def object_in_prepared(self, box: Box, width_px: int, height_px: int) -> Box:
        """An object of a picture of that size, with its mirror image where the border cuts it."""
        if not self.border_px:
            return box
        left, width = _completed(box[0], box[2], width_px)
        top, height = _completed(box[1], box[3], height_px)
        return left + self.border_px, top + self.border_px, width, height

    def object_in_picture(self, box: Box, width_px: int, height_px: int) -> Box | None:
        """The way back: the part of a detected object that the picture shows. None: the mirror image of something."""
        if not self.border_px:
            return box
        left, top = box[0] - self.border_px, box[1] - self.border_px
        x, y = max(left, 0), max(top, 0)
        width, height = min(left + box[2], width_px) - x, min(top + box[3], height_px) - y
        if width < _LEAST_PART_INSIDE * box[2] or height < _LEAST_PART_INSIDE * box[3]:
            return None
        return x, y, width, height


def preparation_of(values: Mapping[str, Scalar]) -> Preparation:
    return Preparation(int(values[SMOOTHING_KEY] or 1), int(values[BORDER_KEY] or 0))


def _completed(start: int, length: int, size: int) -> tuple[int, int]:
    """Along one axis; objects as long as the picture are left as they are."""
    at_start, at_end = start <= _TOUCHING_PX, start + length >= size - _TOUCHING_PX
    if at_start == at_end:
        return start, length
    end = start + length
    return (-end, 2 * end) if at_start else (start, 2 * (size - start))
