import csv
import json
import sqlite3
import struct
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest

from ssjs_cli.formats.contact_table import COLUMNS, Contact, contacts_csv, error_ellipse
from ssjs_cli.formats.geojson import survey_geojson
from ssjs_cli.formats.geopackage import APPLICATION_ID, write_geopackage
from ssjs_cli.formats.kml import NAMESPACE, survey_kml
from ssjs_cli.formats.mission import Geodetic

KIEL = Geodetic(origin_latitude_deg=54.3, origin_longitude_deg=10.1, heading_deg=0.0)  # x to the north, y to the west
TRACK_M = np.column_stack([np.arange(20.0), np.zeros(20)])
CONTACTS = [
    Contact(4, 100.0, 0.0, (0.25, 0.0, 0.04), 3, depth_m=12.0, time_s=1.6e9, log="a.xtf", ping=281, channel="starboard", kind="wreck"),
    Contact(7, 0.0, 100.0, (0.1, 0.0, 0.2), 1, time_s=12.5, remark="=cmd|' /C calc'!A0 <&>\x07"),
]


def rows(geodetic: Geodetic | None) -> list[dict[str, str]]:
    return list(csv.DictReader(contacts_csv(CONTACTS, geodetic).splitlines()))


def test_a_row_holds_what_is_known_and_nothing_else() -> None:
    first, second = rows(KIEL)
    assert list(first) == list(COLUMNS)
    # Meridian radius at 54.3 degrees: 6377672 m; the origin's UTM easting lies west of the zone's middle of 9 degrees
    assert float(first["latitude_deg"]) == pytest.approx(54.3 + np.degrees(100.0 / 6377672.0), abs=1e-8)
    assert float(first["longitude_deg"]) == pytest.approx(10.1, abs=1e-8)
    assert float(second["longitude_deg"]) < 10.1
    assert first["epsg"] == "32632" and 571000.0 < float(first["easting_m"]) < 572000.0
    assert (first["time_utc"], second["time_utc"]) == ("2020-09-13T12:26:40.000Z", "")
    assert (first["sigma_major_m"], first["sigma_minor_m"], first["azimuth_deg"]) == ("0.5000", "0.2000", "0.0")
    assert second["azimuth_deg"] == "90.0"
    assert (first["class"], first["ping"], first["channel"], first["length_m"]) == ("wreck", "281", "starboard", "")


def test_without_an_origin_there_are_no_geographic_values() -> None:
    for row in rows(None):
        assert row["x_m"] and not any(row[key] for key in ("latitude_deg", "longitude_deg", "easting_m", "epsg", "azimuth_deg"))


def test_text_is_not_taken_for_a_formula() -> None:
    assert rows(None)[1]["remark"].startswith("'=cmd")


def test_the_ellipse_turns_clockwise_from_the_x_axis() -> None:
    sigma_major, sigma_minor, angle = error_ellipse((1.0, 0.5, 1.0))  # long axis along x = y, 45 degrees anticlockwise
    assert (sigma_major, sigma_minor, angle) == pytest.approx((1.5**0.5, 0.5**0.5, 135.0))


def test_geojson_has_points_with_the_columns_and_ellipses() -> None:
    document = json.loads(survey_geojson(TRACK_M, CONTACTS, KIEL))
    track, point, ellipse = document["features"][:3]
    assert (track["geometry"]["type"], point["geometry"]["type"], ellipse["geometry"]["type"]) == ("LineString", "Point", "Polygon")
    assert point["properties"]["class"] == "wreck" and "length_m" not in point["properties"]
    outline = np.array(ellipse["geometry"]["coordinates"][0])
    assert outline.mean(axis=0) == pytest.approx(point["geometry"]["coordinates"], abs=1e-6)


def test_kml_reads_back_whatever_the_texts_hold() -> None:
    root = ElementTree.fromstring(survey_kml("a <survey> & more", TRACK_M, CONTACTS, KIEL))
    names = [element.text for element in root.iter(f"{{{NAMESPACE}}}name")]
    assert names == ["a <survey> & more", "track", "contact 4", "contact 7"]
    coordinates = [element.text or "" for element in root.iter(f"{{{NAMESPACE}}}coordinates")]
    assert len(coordinates[0].split()) == len(TRACK_M)
    assert float(coordinates[1].split(",")[1]) > 54.3


def test_a_geopackage_is_a_database_with_points_in_degrees(tmp_path: Path) -> None:
    target = tmp_path / "contacts.gpkg"
    write_geopackage(target, TRACK_M, CONTACTS, KIEL)
    connection = sqlite3.connect(target)
    assert connection.execute("PRAGMA application_id").fetchone() == (APPLICATION_ID,)
    assert connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)
    assert connection.execute("PRAGMA foreign_key_check").fetchall() == []
    assert connection.execute("SELECT table_name, srs_id FROM gpkg_contents ORDER BY 1").fetchall() == [("contacts", 4326), ("track", 4326)]
    (geometry, ping, kind) = connection.execute('SELECT geometry, ping, "class" FROM contacts WHERE id = 4').fetchone()
    assert (ping, kind) == (281, "wreck")
    assert struct.unpack("<2sBBiBIdd", geometry)[:6] == (b"GP", 0, 1, 4326, 1, 1)
    assert struct.unpack("<dd", geometry[-16:]) == pytest.approx((10.1, 54.3 + np.degrees(100.0 / 6377672.0)), abs=1e-8)
    connection.close()


def test_the_same_contacts_are_the_same_bytes(tmp_path: Path) -> None:
    for name in ("a", "b"):
        write_geopackage(tmp_path / name, TRACK_M, CONTACTS, KIEL)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_no_contacts_are_an_empty_layer(tmp_path: Path) -> None:
    write_geopackage(tmp_path / "none.gpkg", np.zeros((0, 2)), [], KIEL)
    connection = sqlite3.connect(tmp_path / "none.gpkg")
    assert connection.execute("SELECT count(*) FROM contacts").fetchone() == (0,)
    connection.close()
    assert contacts_csv([], KIEL).count("\n") == 1
    assert json.loads(survey_geojson(np.zeros((0, 2)), [], KIEL))["features"] == []
