"""Where the objects of images truly are: masks beside them, boxes in a table, or boxes in one XML file an image.

Boxes are left, top, width, height in pixels, the first pixel at (0, 0). A table has the columns image, x_px, y_px, width_px, height_px;
an image without a row holds no object. XML is the form of Pascal VOC: <object><bndbox> with x, y, w, h or xmin, ymin, xmax, ymax.
"""

import csv
import math
import xml.etree.ElementTree as ElementTree
from pathlib import Path

from ssjs_cli.errors import UserError, describe_os_error, nearest_hint

Box = tuple[int, int, int, int]
BOX_COLUMNS = ("image", "x_px", "y_px", "width_px", "height_px")
MAX_XML_BYTES = 10_000_000


def read_box_table(path: Path) -> dict[str, list[Box]]:
    """Boxes by the image column, in the order of the table."""
    boxes: dict[str, list[Box]] = {}
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = csv.reader(file)
            header = [name.strip() for name in next(rows, [])]
            for name in BOX_COLUMNS:
                if name not in header:
                    hint = nearest_hint(name, header)
                    raise UserError(f"{path}:1: has no column '{name}'{hint}; the header must hold {','.join(BOX_COLUMNS)}")
            places = [header.index(name) for name in BOX_COLUMNS]
            for row in rows:
                if not any(field.strip() for field in row):
                    continue
                where = f"{path}:{rows.line_num}"
                if len(row) != len(header):
                    raise UserError(f"{where}: has {len(row)} fields where the header has {len(header)}; correct that line")
                image, *numbers = (row[place].strip() for place in places)
                boxes.setdefault(image, []).append(_box(numbers, where))
    except OSError as error:
        raise UserError(describe_os_error(error, str(path))) from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise UserError(f"{path}: is no table of text ({error}); save it as CSV in UTF-8") from error
    return boxes


def read_box_xml(path: Path) -> list[Box]:
    try:
        data = path.read_bytes()
    except OSError as error:
        raise UserError(describe_os_error(error, str(path))) from error
    if len(data) > MAX_XML_BYTES or b"<!DOCTYPE" in data or b"<!ENTITY" in data:
        raise UserError(f"{path}: is no plain list of boxes (declarations or more than 10 MB); export it again without a DOCTYPE")
    try:
        root = ElementTree.fromstring(data)
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise UserError(f"{path}: is not valid XML ({error}); export it again") from error
    boxes = []
    for number, entry in enumerate(root.iter("bndbox"), 1):
        values = {child.tag: (child.text or "").strip() for child in entry}
        where = f"{path}: box {number}"
        if {"x", "y", "w", "h"} <= set(values):
            boxes.append(_box([values[name] for name in ("x", "y", "w", "h")], where))
        elif {"xmin", "ymin", "xmax", "ymax"} <= set(values):
            left, top, right, bottom = (_whole(values[name], where) for name in ("xmin", "ymin", "xmax", "ymax"))
            boxes.append(_box([str(left), str(top), str(right - left), str(bottom - top)], where))
        else:
            raise UserError(f"{where}: has neither x, y, w, h nor xmin, ymin, xmax, ymax; export it again")
    return boxes


def _box(texts: list[str], where: str) -> Box:
    left, top, width, height = (_whole(text, where) for text in texts)
    if width < 1 or height < 1:
        raise UserError(f"{where}: has a width of {width} and a height of {height}; both must be at least 1")
    return left, top, width, height


def _whole(text: str, where: str) -> int:
    try:
        value = float(text)
    except ValueError as error:
        raise UserError(f"{where}: '{text}' is no number; correct it") from error
    if not math.isfinite(value) or abs(value) > 1e9:
        raise UserError(f"{where}: '{text}' is no number of pixels; correct it")
    return round(value)
