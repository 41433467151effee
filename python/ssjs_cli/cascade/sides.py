"""The sides of a picture: shadows fall to the right on one of them, to the left on the other."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ssjs_cli import _core
from ssjs_cli.cascade.labelled_images import LabelledImage
from ssjs_cli.cascade.preparation import Preparation
from ssjs_cli.cascade.size_limits import DETECTOR_PREFIX
from ssjs_cli.config import Scalar
from ssjs_cli.formats.annotations.boxes import Box
from ssjs_cli.formats.image_file import read_image
from ssjs_cli.formats.image_levels import LevelImage
from ssjs_cli.segmentation.ground_settings import nadir_column_in

SIDE_KEY = f"{DETECTOR_PREFIX}side"
AS_TRAINED, MIRRORED = "as_trained", "mirrored"
PORT, STARBOARD = "port", "starboard"


@dataclass(frozen=True)
class PictureSide:
    """Columns from first_column to before end_column. mirrored: shadows fall the other way than in training. name: where it is known."""

    first_column: int
    end_column: int
    mirrored: bool
    name: str | None = None

    @property
    def as_setting(self) -> str:
        return MIRRORED if self.mirrored else AS_TRAINED

    def levels_of(self, image: LevelImage, preparation: Preparation) -> tuple[NDArray[np.uint8], NDArray[np.uint8] | None]:
        """Its columns in 8 bits, prepared for themselves, and where they are valid. Not turned."""
        columns = slice(self.first_column, self.end_column)
        valid = None if image.valid is None else np.ascontiguousarray(image.valid[:, columns])
        levels = _core.in_8_bits(image.levels, image.valid)
        return preparation.picture(np.ascontiguousarray(levels[:, columns]), valid)


def sides_of(values: Mapping[str, Scalar], width_px: int, name: str, *, mirrored: bool = False) -> list[PictureSide]:
    """Without a nadir the whole picture is one side. With one, what lies right of it is starboard, where shadows fall to the right, and
    is seen as a picture without nadir is; what lies left of it is port, and is seen the other way round."""
    as_given = mirrored != (values[SIDE_KEY] == MIRRORED)
    column = nadir_column_in(values, width_px, name)
    if column is None:
        return [PictureSide(0, width_px, as_given)]
    sides = [PictureSide(0, column, not as_given, PORT), PictureSide(column, width_px, as_given, STARBOARD)]
    return [side for side in sides if side.end_column > side.first_column]


@dataclass(frozen=True)
class SideView:
    """A side of a labelled image, turned so that shadows fall as in training."""

    image: LabelledImage
    side: PictureSide

    def read(self, preparation: Preparation) -> tuple[NDArray[np.uint8], NDArray[np.uint8] | None]:
        levels, valid = self.side.levels_of(read_image(self.image.listed.path), preparation)
        if self.side.mirrored:
            levels, valid = np.ascontiguousarray(levels[:, ::-1]), None if valid is None else np.ascontiguousarray(valid[:, ::-1])
        return levels, valid

    def ground(self, preparation: Preparation) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
        """Levels, and where they are valid and no object reaches into this side."""
        levels, valid = self.read(preparation)
        free = np.full((self.image.height_px, self.side.end_column - self.side.first_column), 255, dtype=np.uint8)
        for left, top, width, height in self._seen(self.image.boxes):
            free[top : top + height, left : left + width] = 0
        free = preparation.continued(free)
        return levels, free if valid is None else np.minimum(free, valid)

    def objects(self, preparation: Preparation) -> list[Box]:
        """What lies on this side by its middle, where read() shows it."""
        first, end = self.side.first_column, self.side.end_column
        seen = self._seen([box for box in self.image.boxes if first <= box[0] + box[2] / 2 < end])
        return [preparation.object_in_prepared(box, end - first, self.image.height_px) for box in seen]

    def _seen(self, boxes: Sequence[Box]) -> list[Box]:
        seen = []
        for left, top, width, height in boxes:
            start, end = max(left, self.side.first_column), min(left + width, self.side.end_column)
            if start < end:
                at = self.side.end_column - end if self.side.mirrored else start - self.side.first_column
                seen.append((at, top, end - start, height))
        return seen


def views_of(images: Sequence[LabelledImage], values: Mapping[str, Scalar]) -> list[SideView]:
    return [
        SideView(image, side) for image in images for side in sides_of(values, image.width_px, image.listed.name, mirrored=image.mirrored)
    ]
