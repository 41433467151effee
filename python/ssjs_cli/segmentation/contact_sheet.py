"""Many images on one sheet: each with its pictures (as it is, its mask, its regions and centroids) small and side by side."""

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from ssjs_cli.segmentation.pictures import Drawing, Panels, Pixels, panels

#: Box of one picture on the sheets.
THUMBNAIL_PX = (200, 180)
#: The sheets show so many images; of more, evenly chosen ones. Tables hold all.
MAX_IMAGES = 72

_BACKGROUND = (255, 255, 255)
_INK = (20, 33, 61)
_MUTED = (102, 113, 126)
_FRAME = (184, 194, 204)
_MARGIN_PX = 18
_GAP_PX = 4
_CELL_GAP_PX = 22
_LINE_PX = 16
_FONT_PX = 13
_WIDTH_PX = 1960
_JPEG_QUALITY = 84


@dataclass(frozen=True)
class Thumbnail:
    """label: what the picture shows; data: JPEG, or PNG for masks."""

    label: str
    data: bytes

    @property
    def media_type(self) -> str:
        return "image/png" if self.data.startswith(b"\x89PNG") else "image/jpeg"


@dataclass(frozen=True)
class SheetEntry:
    """One image. lines: below its pictures; link: of the large picture, beside the page."""

    name: str
    lines: Sequence[str]
    thumbnails: Sequence[Thumbnail]
    link: str = ""
    sort_keys: Mapping[str, float] = field(default_factory=dict)


def thumbnails(drawing: Drawing) -> list[Thumbnail]:
    made: Panels = panels(drawing, THUMBNAIL_PX)
    return [
        Thumbnail("picture", jpeg_bytes(made.original)),
        Thumbnail("mask", png_bytes(made.mask)),
        Thumbnail("regions and centroids", jpeg_bytes(made.marked)),
    ]


def shown_positions(count: int, most: int = MAX_IMAGES) -> list[int]:
    """Which of `count` images a sheet shows: all, or evenly chosen ones with the first and the last."""
    if count <= most:
        return list(range(count))
    return [round(index * (count - 1) / (most - 1)) for index in range(most)]


def contact_sheet(entries: Sequence[SheetEntry], title: str) -> bytes:
    """A PNG."""
    box_width, box_height = THUMBNAIL_PX
    panel_count = max((len(entry.thumbnails) for entry in entries), default=1)
    cell_width = panel_count * box_width + (panel_count - 1) * _GAP_PX
    columns = max(1, min(len(entries), (_WIDTH_PX - 2 * _MARGIN_PX + _CELL_GAP_PX) // (cell_width + _CELL_GAP_PX)))
    lines = max((1 + len(entry.lines) for entry in entries), default=0)
    cell_height = box_height + _LINE_PX + _GAP_PX + lines * _LINE_PX
    rows = -(-len(entries) // columns)
    top = _MARGIN_PX + 2 * _LINE_PX
    width = 2 * _MARGIN_PX + columns * cell_width + (columns - 1) * _CELL_GAP_PX
    height = top + rows * (cell_height + _CELL_GAP_PX) - (_CELL_GAP_PX if rows else 0) + _MARGIN_PX
    sheet = Image.new("RGB", (width, height), _BACKGROUND)
    canvas = ImageDraw.Draw(sheet)
    label_font, font, title_font = (ImageFont.load_default(size) for size in (_FONT_PX - 2, _FONT_PX, _FONT_PX + 3))
    canvas.text((_MARGIN_PX, _MARGIN_PX - 4), title, fill=_INK, font=title_font)
    for position, entry in enumerate(entries):
        row, column = divmod(position, columns)
        left = _MARGIN_PX + column * (cell_width + _CELL_GAP_PX)
        upper = top + row * (cell_height + _CELL_GAP_PX)
        for panel, thumbnail in enumerate(entry.thumbnails):
            with Image.open(io.BytesIO(thumbnail.data)) as picture:
                x = left + panel * (box_width + _GAP_PX) + (box_width - picture.width) // 2
                y = upper + box_height - picture.height
                sheet.paste(picture.convert("RGB"), (x, y))
                canvas.rectangle((x - 1, y - 1, x + picture.width, y + picture.height), outline=_FRAME)
            canvas.text((x, upper + box_height + 2), thumbnail.label, fill=_MUTED, font=label_font)
        for line, text in enumerate([entry.name, *entry.lines]):
            place = (left, upper + box_height + _LINE_PX + _GAP_PX + line * _LINE_PX)
            canvas.text(place, _fitted(text, font, cell_width), fill=_MUTED if line else _INK, font=font)
    return png_bytes(np.asarray(sheet))


def _fitted(text: str, font: ImageFont.FreeTypeFont | ImageFont.ImageFont, width_px: int) -> str:
    """The end of a text that is too long: that is where names differ."""
    if font.getlength(text) <= width_px:
        return text
    while text and font.getlength("..." + text) > width_px:
        text = text[1:]
    return "..." + text


def jpeg_bytes(pixels: Pixels) -> bytes:
    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, format="JPEG", quality=_JPEG_QUALITY, subsampling=0)
    return buffer.getvalue()


def png_bytes(pixels: Pixels) -> bytes:
    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, format="PNG", compress_level=6)
    return buffer.getvalue()
