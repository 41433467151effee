"""The mosaic of a run: every frame placed where the final track has it. docs/math/optical.md (V-22..V-24)"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ssjs_cli import _core
from ssjs_cli.formats.frame_image import Frame
from ssjs_cli.formats.number_table import FloatArray

UNSEEN_LEVEL = 255


@dataclass(frozen=True)
class Mosaic:
    """picture: (rows, columns[, 3]), white where nothing was seen; window: left, bottom, pixel_length in the units of the map."""

    picture: Frame
    seen: Frame
    window: Mapping[str, Any]

    @property
    def right(self) -> float:
        return float(self.window["left"] + self.window["width_px"] * self.window["pixel_length"])

    @property
    def top(self) -> float:
        return float(self.window["bottom"] + self.window["height_px"] * self.window["pixel_length"])


def draw_mosaic(pixels: Callable[[], Iterator[Frame]], map_H_frame: FloatArray, reader: Any, settings: Mapping[str, Any]) -> Mosaic:
    """pixels: the frames as taken, anew at each call; map_H_frame (n, 3, 3) of the corrected ones, the map's x to the right and its y
    upwards; reader: takes the lens out."""
    light = _core.LampLight(settings)
    first: Frame | None = None
    for frame in pixels():
        light.learn(frame)
        first = frame if first is None else first
    if first is None:
        raise ValueError("a mosaic needs a frame")
    rows, columns = first.shape[:2]
    channels = 3 if first.ndim == 3 else 1
    valid = np.where(reader.corrected(np.full((rows, columns), 255, dtype=np.uint8)) > 250, 255, 0).astype(np.uint8)
    canvas = _core.MosaicCanvas(map_H_frame, columns, rows, channels, settings)
    for frame, placed in zip(pixels(), map_H_frame, strict=True):
        canvas.add(reader.corrected(light.evened(frame)), placed, valid)
    seen = canvas.seen()
    picture = canvas.picture()
    picture[seen == 0] = UNSEEN_LEVEL
    return Mosaic(picture, seen, canvas.window)
