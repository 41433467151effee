"""Boxes drawn on pictures for the eye: whole overlays, and cut-outs of single detections."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from ssjs_cli.formats.annotations.boxes import Box
from ssjs_cli.formats.image_levels import LevelImage
from ssjs_cli.segmentation.pictures import INVALID, MAX_OVERLAY_PX, Colour, Pixels, display_table

FOUND: Colour = (64, 224, 255)
FALSE: Colour = (255, 45, 85)
TRUTH: Colour = (64, 235, 120)


@dataclass(frozen=True)
class DrawnBox:
    box: Box
    colour: Colour
    text: str = ""


def display_levels(image: LevelImage) -> Pixels:
    """(h, w, 3), drawn out for the eye."""
    grey = display_table(image)[image.levels]
    result = np.repeat(grey[:, :, np.newaxis], 3, axis=2)
    if image.valid is not None:
        result[image.valid == 0] = INVALID
    return result


def overlay(image: LevelImage, boxes: Sequence[DrawnBox]) -> Pixels:
    """In full size up to MAX_OVERLAY_PX, then shrunk by a whole factor."""
    factor = math.ceil(max(image.levels.shape) / MAX_OVERLAY_PX)
    picture = Image.fromarray(display_levels(image))
    if factor > 1:
        picture = picture.reduce(factor)
    return _with_boxes(picture, boxes, 1.0 / factor, (0, 0))


def cut_out(image: LevelImage, centre: Box, boxes: Sequence[DrawnBox], side_px: int = 200) -> Pixels:
    """The surroundings of a box, twice its size, as a square of side_px."""
    left, top, width, height = centre
    reach = max(width, height, 8)
    x, y = left + width / 2 - reach, top + height / 2 - reach
    first_column, first_row = max(0, math.floor(x)), max(0, math.floor(y))
    last_column, last_row = min(image.width_px, math.ceil(x + 2 * reach)), min(image.height_px, math.ceil(y + 2 * reach))
    piece = display_levels(image)[first_row:last_row, first_column:last_column]
    canvas = np.empty((2 * reach + 1, 2 * reach + 1, 3), dtype=np.uint8)
    canvas[:] = INVALID
    row, column = first_row - math.floor(y), first_column - math.floor(x)
    canvas[row : row + piece.shape[0], column : column + piece.shape[1]] = piece[: canvas.shape[0] - row, : canvas.shape[1] - column]
    scale = side_px / canvas.shape[0]
    picture = Image.fromarray(canvas).resize((side_px, side_px), Image.Resampling.NEAREST if scale > 1 else Image.Resampling.BOX)
    return _with_boxes(picture, boxes, scale, (math.floor(x), math.floor(y)))


def _with_boxes(picture: Image.Image, boxes: Sequence[DrawnBox], scale: float, origin: tuple[int, int]) -> NDArray[np.uint8]:
    canvas = ImageDraw.Draw(picture)
    width_px = max(1, min(3, max(picture.size) // 300))
    for drawn in boxes:
        left, top, width, height = drawn.box
        x, y = (left - origin[0]) * scale, (top - origin[1]) * scale
        right, bottom = max(x, x + width * scale - 1), max(y, y + height * scale - 1)
        canvas.rectangle((x, y, right, bottom), outline=drawn.colour, width=width_px)
        if drawn.text:
            canvas.text((x + 2, y - 12 if y >= 12 else bottom + 1), drawn.text, fill=drawn.colour)
    return np.asarray(picture)
