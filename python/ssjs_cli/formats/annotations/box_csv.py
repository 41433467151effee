"""Boxes as a table: image,x_px,y_px,width_px,height_px and optionally label; other columns are left aside."""

import csv
from pathlib import Path

from ssjs_cli.errors import UserError, nearest_hint
from ssjs_cli.formats.annotations.boxes import LabelledBox, pixel_box, read_lines

COLUMNS = ("image", "x_px", "y_px", "width_px", "height_px")
LABEL = "label"


def read_box_csv(path: Path) -> dict[str, list[LabelledBox]]:
    """By the image column. A row with an image and no box says that the image holds no object."""
    images: dict[str, list[LabelledBox]] = {}
    rows = csv.reader(read_lines(path))
    try:
        header = [name.strip() for name in next(rows, [])]
        for name in COLUMNS:
            if name not in header:
                raise UserError(f"{path}:1: has no column '{name}'{nearest_hint(name, header)}; the header must hold {','.join(COLUMNS)}")
        places = [header.index(name) for name in COLUMNS]
        for row in rows:
            if not any(field.strip() for field in row):
                continue
            where = f"{path}:{rows.line_num}"
            if len(row) != len(header):
                raise UserError(f"{where}: has {len(row)} fields where the header has {len(header)}; correct that line")
            image, *numbers = (row[place].strip() for place in places)
            if not image:
                raise UserError(f"{where}: names no image; correct that line")
            boxes = images.setdefault(image, [])
            if any(numbers):
                boxes.append(pixel_box(numbers, where, row[header.index(LABEL)].strip() if LABEL in header else ""))
    except csv.Error as error:
        raise UserError(f"{path}:{rows.line_num}: is no line of a table ({error}); save it as CSV") from error
    return images
