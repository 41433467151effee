"""COCO: one JSON file with `images`, `annotations` (bbox [x, y, width, height]) and `categories`."""

import json
from pathlib import Path
from typing import Any

from ssjs_cli.errors import UserError
from ssjs_cli.formats.annotations.boxes import LabelledBox, pixel_box, read_bytes


def read_coco(path: Path) -> dict[str, list[LabelledBox]]:
    """By `file_name`; images without annotation are there, with no box. Crowds (`iscrowd`) are no single objects and left out."""
    document = _document(path)
    labels = {entry.get("id"): str(entry.get("name", "")) for entry in _list(document, "categories", path, required=False)}
    names: dict[Any, str] = {}
    boxes: dict[str, list[LabelledBox]] = {}
    for position, entry in enumerate(_list(document, "images", path)):
        name = entry.get("file_name")
        if not isinstance(name, str) or not isinstance(entry.get("id"), int | str):
            raise UserError(f"{path}: images[{position}] has no id and file_name; export it again")
        names[entry["id"]] = name
        boxes.setdefault(name, [])
    for position, entry in enumerate(_list(document, "annotations", path)):
        where = f"{path}: annotations[{position}]"
        image = entry.get("image_id")
        if not isinstance(image, int | str) or image not in names:
            raise UserError(f"{where}: image_id = {json.dumps(image)[:40]} is no id of `images`; export it again")
        bounds = entry.get("bbox")
        if not isinstance(bounds, list) or len(bounds) != 4 or not all(_is_number(value) for value in bounds):
            raise UserError(f"{where}: bbox = {json.dumps(bounds)[:60]}: must be [x, y, width, height]")
        if entry.get("iscrowd"):
            continue
        category = entry.get("category_id")
        label = labels.get(category, "" if category is None else str(category)) if isinstance(category, int | str | None) else ""
        boxes[names[image]].append(pixel_box([repr(value) for value in bounds], where, label))
    return boxes


def _document(path: Path) -> dict[str, Any]:
    try:
        document = json.loads(read_bytes(path))
    except json.JSONDecodeError as error:
        raise UserError(f"{path}:{error.lineno}: is not valid JSON ({error.msg}); export it again") from error
    except (UnicodeDecodeError, RecursionError) as error:
        raise UserError(f"{path}: is not valid JSON ({type(error).__name__}); export it again") from error
    if not isinstance(document, dict):
        raise UserError(f"{path}: is no COCO file (a JSON object with images and annotations); check the path")
    return document


def _list(document: dict[str, Any], key: str, path: Path, *, required: bool = True) -> list[dict[str, Any]]:
    value = document.get(key, None if required else [])
    if not isinstance(value, list) or not all(isinstance(entry, dict) for entry in value):
        raise UserError(f"{path}: '{key}' must be a list of objects; export it again as COCO")
    return value


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
