"""One image as the chain takes it: its levels, and everything that is known of where they are valid."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ssjs_cli import _core
from ssjs_cli.config import Settings
from ssjs_cli.errors import UserError
from ssjs_cli.formats.image_file import SUFFIXES, read_image, read_mask
from ssjs_cli.formats.image_levels import SET, LevelImage, Mask
from ssjs_cli.segmentation.settings import INVALID_VALUE_KEY, PADDING_LEVEL_KEY, PAGE_KEY


@dataclass(frozen=True)
class MaskSource:
    """A mask for all images, or a folder with one for each, of the same name up to the suffix."""

    path: Path

    def file_for(self, image_path: Path) -> Path:
        if not self.path.is_dir():
            return self.path
        for suffix in (image_path.suffix, *SUFFIXES):
            candidate = self.path / f"{image_path.stem}{suffix}"
            if candidate.is_file():
                return candidate
        raise UserError(f"{image_path}: has no mask {image_path.stem}.png in {self.path}; add it, or leave this image out")

    def read_for(self, image_path: Path, image: LevelImage) -> Mask:
        path = self.file_for(image_path)
        mask = read_mask(path)
        if mask.shape != image.levels.shape:
            raise UserError(
                f"{path}: has {mask.shape[1]} x {mask.shape[0]} pixels and {image_path} has {image.width_px} x {image.height_px}; "
                "give a mask of the size of its image"
            )
        return mask


def read_picture(path: Path, settings: Settings, mask_source: MaskSource | None) -> LevelImage:
    """Valid is what alpha and real numbers say, and the mask, and neither the invalid value nor padding."""
    image = read_image(path, page=int(settings.values[PAGE_KEY] or 1))
    masks = [] if image.valid is None else [image.valid]
    if mask_source is not None:
        masks.append(mask_source.read_for(path, image))
    invalid_value, padding_level = settings.values[INVALID_VALUE_KEY], settings.values[PADDING_LEVEL_KEY]
    if invalid_value is not None:
        masks.append(np.where(image.levels == int(invalid_value), 0, SET).astype(np.uint8))
    if padding_level is not None:
        masks.append(outside_padding(image, int(padding_level)))
    if not masks:
        return image
    valid = masks[0]
    for mask in masks[1:]:
        valid = np.minimum(valid, mask)
    return LevelImage(image.levels, None if bool(valid.all()) else valid, image.notes)


def outside_padding(image: LevelImage, level: int) -> Mask:
    """255 but for pixels of at most `level` that are 4-connected to the border through such pixels."""
    bright = (image.levels > level).astype(np.uint8)
    return _core.fill_holes(bright)
