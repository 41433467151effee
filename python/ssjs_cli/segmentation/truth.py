"""Which truth belongs to an image."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ssjs_cli import _core
from ssjs_cli.errors import UserError
from ssjs_cli.formats.image_levels import LevelImage, Mask
from ssjs_cli.formats.truth_file import Box, read_box_table, read_box_xml
from ssjs_cli.segmentation.picture_input import MaskSource


@dataclass(frozen=True)
class TruthSource:
    """At most one of: a folder of masks; a table or a folder of boxes; no_objects, where the images are known to hold none.
    one_object: what a mask shows is one object, connected or not."""

    masks: Path | None = None
    boxes: Path | None = None
    no_objects: bool = False
    one_object: bool = False

    def check(self) -> None:
        """Faults that are those of the command, not of an image."""
        if sum((self.masks is not None, self.boxes is not None, self.no_objects)) > 1:
            raise UserError("--masks, --boxes, --no-objects: are different truths; give one of them")
        if self.one_object and self.masks is None:
            raise UserError("--one-object: says what a mask shows; give --masks with it")
        for flag, path in (("--masks", self.masks), ("--boxes", self.boxes)):
            if path is not None and not path.exists():
                raise UserError(f"{path}: No such file or directory; check the path of {flag}")
        if self.boxes is not None and not self.boxes.is_dir():
            read_box_table(self.boxes)

    @property
    def is_known(self) -> bool:
        return self.masks is not None or self.boxes is not None or self.no_objects


@dataclass(frozen=True)
class Truth:
    """objects: the core's; shown: their pixels, for the eye."""

    objects: Any
    shown: Mask


def truth_for(source: TruthSource, path: Path, name: str, image: LevelImage) -> Truth | None:
    if source.masks is not None:
        mask = MaskSource(source.masks).read_for(path, image)
        objects = _core.GroundTruth.of_labels(mask) if source.one_object else _core.GroundTruth.of_mask(mask)
        return Truth(objects, mask)
    if source.boxes is not None:
        boxes = _boxes_for(source.boxes, path, name)
        try:
            objects = _core.GroundTruth.of_boxes(image.height_px, image.width_px, boxes)
        except ValueError as error:
            raise UserError(f"{source.boxes}: a box of {name} lies outside its picture ({error}); correct it") from error
        shown = np.zeros((image.height_px, image.width_px), dtype=np.uint8)
        for left, top, width, height in boxes:
            shown[max(0, top) : top + height, max(0, left) : left + width] = 255
        return Truth(objects, shown)
    if source.no_objects:
        nothing = np.zeros((image.height_px, image.width_px), dtype=np.uint8)
        return Truth(_core.GroundTruth.of_mask(nothing), nothing)
    return None


def _boxes_for(source: Path, path: Path, name: str) -> list[Box]:
    if source.is_dir():
        file = source / f"{path.stem}.xml"
        if not file.is_file():
            raise UserError(f"{path}: has no boxes {file.name} in {source}; add them, or leave this image out")
        return read_box_xml(file)
    table = read_box_table(source)
    return table.get(name) or table.get(path.name) or table.get(path.stem) or []
