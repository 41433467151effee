"""YOLO: beside or apart from the pictures a folder of .txt, `class x_centre y_centre width height` a line, parts of the picture's size.
A picture without a file holds no object."""

from pathlib import Path

from ssjs_cli.errors import UserError
from ssjs_cli.formats.annotations.boxes import LabelledBox, number, read_lines

CLASS_FILE = "classes.txt"


def read_yolo_file(path: Path, class_names: list[str]) -> list[LabelledBox]:
    boxes = []
    for line_number, line in enumerate(read_lines(path), 1):
        where = f"{path}:{line_number}"
        fields = line.split()
        if not fields:
            continue
        if len(fields) not in (5, 6):  # the sixth is the confidence of a detector
            raise UserError(f"{where}: has {len(fields)} fields; write `class x_centre y_centre width height`")
        if not fields[0].isdecimal():
            raise UserError(f"{where}: '{fields[0]}' is no number of a class; write the class as 0, 1, ...")
        x, y, width, height = (number(field, where) for field in fields[1:5])
        if not (0 <= x <= 1 and 0 <= y <= 1 and 0 < width <= 1 and 0 < height <= 1):
            raise UserError(f"{where}: the box {' '.join(fields[1:5])} does not lie in 0 to 1; YOLO boxes are parts of the picture's size")
        position = int(fields[0])
        label = class_names[position] if position < len(class_names) else fields[0]
        boxes.append(LabelledBox(x - width / 2, y - height / 2, width, height, where, label, relative=True))
    return boxes


def read_class_names(folder: Path) -> list[str]:
    for candidate in (folder / CLASS_FILE, folder.parent / CLASS_FILE):
        if candidate.is_file():
            return [line.strip() for line in read_lines(candidate) if line.strip()]
    return []
