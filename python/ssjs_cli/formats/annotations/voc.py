"""Pascal VOC: one XML file a picture. Coordinates count from 1 and xmax, ymax are the last pixel inside. Nothing is expanded or fetched."""

import xml.etree.ElementTree as ElementTree
from pathlib import Path

from ssjs_cli.errors import UserError
from ssjs_cli.formats.annotations.boxes import LabelledBox, number, read_bytes

MAX_XML_BYTES = 10_000_000
_CORNERS = ("xmin", "ymin", "xmax", "ymax")


def read_voc_file(path: Path) -> tuple[str, list[LabelledBox]]:
    """The <filename>, empty where there is none, and the boxes."""
    data = read_bytes(path)
    if len(data) > MAX_XML_BYTES:
        raise UserError(f"{path}: is larger than {MAX_XML_BYTES / 1e6:.0f} MB, no annotation of one picture; check the path")
    root = _parsed(data, path)
    if root.tag != "annotation":
        raise UserError(f"{path}: its root is <{root.tag}>, not <annotation>; give a Pascal VOC file")
    boxes = []
    for position, entry in enumerate(root.findall("object"), 1):
        where = f"{path}: object {position}"
        bounds = entry.find("bndbox")
        values = {} if bounds is None else {child.tag: (child.text or "").strip() for child in bounds}
        missing = [name for name in _CORNERS if name not in values]
        if missing:
            raise UserError(f"{where}: has no <bndbox> with <{missing[0]}>; export it again")
        left, top, right, bottom = (number(values[name], where) for name in _CORNERS)
        if right < left or bottom < top:
            raise UserError(f"{where}: xmax, ymax ({right:g}, {bottom:g}) lie before xmin, ymin ({left:g}, {top:g}); correct it")
        label = (entry.findtext("name") or "").strip()
        boxes.append(LabelledBox(left - 1, top - 1, right - left + 1, bottom - top + 1, where, label))
    return (root.findtext("filename") or "").strip(), boxes


class _NoDeclarations(ElementTree.TreeBuilder):
    """Refuses a DOCTYPE before any entity of it could be used."""

    def doctype(self, name: str, public_id: str | None, system_id: str | None) -> None:
        raise ValueError(f"holds a DOCTYPE ({name})")


def _parsed(data: bytes, path: Path) -> ElementTree.Element:
    parser = ElementTree.XMLParser(target=_NoDeclarations())
    try:
        parser.feed(data)
        root: ElementTree.Element = parser.close()
    except ElementTree.ParseError as error:
        line, column = error.position
        raise UserError(f"{path}:{line}: is not valid XML (column {column}: {error.msg.split(':')[0]}); export it again") from error
    except (ValueError, LookupError) as error:
        raise UserError(f"{path}: {error}; export it again as plain XML without declarations") from error
    return root
