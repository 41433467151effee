"""Boxes, what an annotation says about one image, and numbers out of text with messages that say where they stood."""

import math
from dataclasses import dataclass
from pathlib import Path

from ssjs_cli.errors import UserError, describe_os_error

Box = tuple[int, int, int, int]
#: Boxes that reach so far over the border of the picture are cut there: rounding does that. Others are refused.
OVERHANG_PX = 2
MAX_BYTES = 500_000_000
_MAX_PIXEL = 1e9


@dataclass(frozen=True)
class LabelledBox:
    """left, top, width, height: pixels or, where `relative`, parts of the picture's size; where: file and line, for messages."""

    left: float
    top: float
    width: float
    height: float
    where: str
    label: str = ""
    relative: bool = False

    def in_pixels(self, width_px: int, height_px: int) -> Box:
        """Within a picture of that size. Raises UserError where the box leaves it."""
        across, along = (width_px, height_px) if self.relative else (1, 1)
        left, top = round(self.left * across), round(self.top * along)
        right, bottom = round((self.left + self.width) * across), round((self.top + self.height) * along)
        if left < -OVERHANG_PX or top < -OVERHANG_PX or right > width_px + OVERHANG_PX or bottom > height_px + OVERHANG_PX:
            raise UserError(
                f"{self.where}: the box {left} {top} {right - left} {bottom - top} leaves the picture of {width_px} x {height_px} px; "
                "correct it, or give the picture it was drawn on"
            )
        left, top, right, bottom = max(left, 0), max(top, 0), min(right, width_px), min(bottom, height_px)
        if right <= left or bottom <= top:
            raise UserError(f"{self.where}: the box has no pixel in the picture of {width_px} x {height_px} px; correct or remove it")
        return left, top, right - left, bottom - top


def pixel_box(texts: list[str], where: str, label: str = "") -> LabelledBox:
    """left, top, width, height as text."""
    left, top, width, height = (number(text, where) for text in texts)
    if width <= 0 or height <= 0:
        raise UserError(f"{where}: has a width of {width:g} and a height of {height:g}; both must be positive")
    return LabelledBox(left, top, width, height, where, label)


def number(text: str, where: str) -> float:
    try:
        value = float(text)
    except ValueError as error:
        raise UserError(f"{where}: '{text[:40]}' is no number; correct it") from error
    if not math.isfinite(value) or abs(value) > _MAX_PIXEL:
        raise UserError(f"{where}: '{text[:40]}' is no number of pixels; correct it")
    return value


def read_bytes(path: Path) -> bytes:
    try:
        if path.stat().st_size > MAX_BYTES:
            raise UserError(f"{path}: is larger than {MAX_BYTES / 1e6:.0f} MB; split the annotations")
        return path.read_bytes()
    except OSError as error:
        raise UserError(describe_os_error(error, str(path))) from error


def read_lines(path: Path) -> list[str]:
    data = read_bytes(path)
    try:
        return data.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise UserError(f"{path}:{line}: is not UTF-8 text; save it as UTF-8") from error
