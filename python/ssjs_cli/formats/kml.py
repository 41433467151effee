"""Contacts and track as KML 2.2, for Google Earth and chart plotters."""

import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from typing import Any

from ssjs_cli.formats.contact_table import COLUMNS, Contact, contact_rows
from ssjs_cli.formats.geographic import to_longitude_latitude
from ssjs_cli.formats.geojson import thinned
from ssjs_cli.formats.mission import Geodetic
from ssjs_cli.formats.number_table import FloatArray

NAMESPACE = "http://www.opengis.net/kml/2.2"


def survey_kml(name: str, track_m: FloatArray, contacts: Sequence[Contact], geodetic: Geodetic) -> str:
    """track_m (n, 2), global frame, thinned as in map.geojson."""
    ElementTree.register_namespace("", NAMESPACE)
    root = ElementTree.Element(f"{{{NAMESPACE}}}kml")
    document = _child(root, "Document")
    _child(document, "name", _legal(name))
    if len(track_m):
        place = _child(document, "Placemark")
        _child(place, "name", "track")
        line = _child(place, "LineString")
        _child(line, "tessellate", "1")
        _child(line, "coordinates", " ".join(_coordinate(*point) for point in to_longitude_latitude(thinned(track_m), geodetic)))
    for row in contact_rows(contacts, geodetic):
        place = _child(document, "Placemark")
        _child(place, "name", _legal(row["name"]))
        if row["remark"]:
            _child(place, "description", _legal(row["remark"]))
        data = _child(place, "ExtendedData")
        for column, decimals in COLUMNS.items():
            if row[column] is not None:
                entry = _child(data, "Data")
                entry.set("name", column)
                _child(entry, "value", _legal(str(row[column])) if decimals is None else f"{row[column]:.{decimals}f}")
        _child(_child(place, "Point"), "coordinates", _coordinate(row["longitude_deg"], row["latitude_deg"]))
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def _child(parent: ElementTree.Element, tag: str, text: Any = None) -> ElementTree.Element:
    element = ElementTree.SubElement(parent, f"{{{NAMESPACE}}}{tag}")
    element.text = text
    return element


def _coordinate(longitude_deg: float, latitude_deg: float) -> str:
    return f"{longitude_deg:.9f},{latitude_deg:.9f}"


def _legal(text: str) -> str:
    """Control characters are not allowed in XML, escaped or not."""
    return "".join(character if character in "\t\n" or character >= " " else "�" for character in text)
