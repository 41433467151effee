"""Contacts and track as a GeoPackage 1.3 (OGC 12-128r17): an SQLite database that every GIS opens."""

import sqlite3
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ssjs_cli.formats.contact_table import COLUMNS, Contact, contact_rows
from ssjs_cli.formats.geographic import to_longitude_latitude
from ssjs_cli.formats.geojson import thinned
from ssjs_cli.formats.mission import Geodetic
from ssjs_cli.formats.number_table import FloatArray

APPLICATION_ID = 0x47504B47  # "GPKG"
VERSION = 10300
WGS84 = 4326
# Not the time of writing, so that equal results are equal files.
LAST_CHANGE = "1970-01-01T00:00:00.000Z"

WGS84_WKT = (
    'GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],PRIMEM["Greenwich",0],'
    'UNIT["degree",0.0174532925199433],AUTHORITY["EPSG","4326"]]'
)
SCHEMA = """
CREATE TABLE gpkg_spatial_ref_sys (srs_name TEXT NOT NULL, srs_id INTEGER NOT NULL PRIMARY KEY, organization TEXT NOT NULL,
  organization_coordsys_id INTEGER NOT NULL, definition TEXT NOT NULL, description TEXT);
CREATE TABLE gpkg_contents (table_name TEXT NOT NULL PRIMARY KEY, data_type TEXT NOT NULL, identifier TEXT UNIQUE,
  description TEXT DEFAULT '', last_change DATETIME NOT NULL, min_x DOUBLE, min_y DOUBLE, max_x DOUBLE, max_y DOUBLE, srs_id INTEGER,
  CONSTRAINT fk_gc_r_srs_id FOREIGN KEY (srs_id) REFERENCES gpkg_spatial_ref_sys(srs_id));
CREATE TABLE gpkg_geometry_columns (table_name TEXT NOT NULL, column_name TEXT NOT NULL, geometry_type_name TEXT NOT NULL,
  srs_id INTEGER NOT NULL, z TINYINT NOT NULL, m TINYINT NOT NULL, CONSTRAINT pk_geom_cols PRIMARY KEY (table_name, column_name),
  CONSTRAINT fk_gc_tn FOREIGN KEY (table_name) REFERENCES gpkg_contents(table_name),
  CONSTRAINT fk_gc_srs FOREIGN KEY (srs_id) REFERENCES gpkg_spatial_ref_sys (srs_id));
"""


def write_geopackage(target: Path, track_m: FloatArray, contacts: Sequence[Contact], geodetic: Geodetic) -> None:
    """Layers `contacts` (points with the columns of contacts.csv) and `track` (a line). track_m (n, 2), global frame. `target` must not
    exist yet."""
    rows = contact_rows(contacts, geodetic)
    connection = sqlite3.connect(target)
    try:
        connection.execute("PRAGMA journal_mode = OFF")
        connection.execute(f"PRAGMA application_id = {APPLICATION_ID}")
        connection.execute(f"PRAGMA user_version = {VERSION}")
        connection.executescript(SCHEMA)
        connection.executemany(
            "INSERT INTO gpkg_spatial_ref_sys VALUES (?, ?, ?, ?, ?, ?)",
            [
                ("Undefined cartesian SRS", -1, "NONE", -1, "undefined", None),
                ("Undefined geographic SRS", 0, "NONE", 0, "undefined", None),
                ("WGS 84", WGS84, "EPSG", WGS84, WGS84_WKT, None),
            ],
        )
        places = np.array([[row["longitude_deg"], row["latitude_deg"]] for row in rows]).reshape(-1, 2)
        columns = {f'"{column}"': _sql_type(rows, column) for column in COLUMNS if column != "id"}
        values = [[row[column] for column in COLUMNS if column != "id"] for row in rows]
        ids = [contact.id for contact in contacts]
        _add_layer(connection, "contacts", "POINT", columns, ids, [_point(place) for place in places], values, places)
        if len(track_m):
            line = to_longitude_latitude(thinned(track_m), geodetic)
            _add_layer(connection, "track", "LINESTRING", {}, [1], [_line(line)], [[]], line)
        connection.commit()
    finally:
        connection.close()


def _sql_type(rows: Sequence[dict[str, Any]], column: str) -> str:
    if COLUMNS[column] is not None:
        return "DOUBLE"
    return "INTEGER" if column in ("epsg", "ping", "sightings") else "TEXT"


def _add_layer(
    connection: sqlite3.Connection,
    name: str,
    geometry_type: str,
    columns: dict[str, str],
    ids: Sequence[int],
    geometries: Sequence[bytes],
    values: Sequence[Sequence[Any]],
    places: FloatArray,
) -> None:
    described = "".join(f", {column} {kind}" for column, kind in columns.items())
    connection.execute(f"CREATE TABLE {name} (id INTEGER PRIMARY KEY NOT NULL, geometry {geometry_type}{described})")
    marks = ", ".join("?" * (2 + len(columns)))
    connection.executemany(
        f"INSERT INTO {name} VALUES ({marks})",
        [(key, geometry, *map(_plain, row)) for key, geometry, row in zip(ids, geometries, values, strict=True)],
    )
    bounds = [*places.min(axis=0).tolist(), *places.max(axis=0).tolist()] if len(places) else [None] * 4
    connection.execute(
        "INSERT INTO gpkg_contents VALUES (?, 'features', ?, '', ?, ?, ?, ?, ?, ?)", (name, name, LAST_CHANGE, *bounds, WGS84)
    )
    connection.execute("INSERT INTO gpkg_geometry_columns VALUES (?, 'geometry', ?, ?, 0, 0)", (name, geometry_type, WGS84))


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value


# A geometry is a header (magic, version 0, flags: little endian, no envelope; reference system) and well-known binary.
_HEADER = struct.pack("<2sBBi", b"GP", 0, 1, WGS84)


def _point(place: FloatArray) -> bytes:
    return _HEADER + struct.pack("<BIdd", 1, 1, *place)


def _line(places: FloatArray) -> bytes:
    return _HEADER + struct.pack("<BII", 1, 2, len(places)) + np.ascontiguousarray(places, dtype="<f8").tobytes()
