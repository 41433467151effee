"""Contacts as operators exchange them: one row an object, as CSV."""

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

import numpy as np

from ssjs_cli.formats.geographic import to_longitude_latitude, to_utm, utm_epsg
from ssjs_cli.formats.mission import Geodetic


@dataclass(frozen=True)
class Contact:
    """An object on the bottom. Positions in the global frame of the mission; what is not known is None.

    covariance_m2: xx, xy, yy of the position. The sonar's own part (ping, channel, ranges, heading, depth) is that of the best sighting.
    """

    id: int
    x_m: float
    y_m: float
    covariance_m2: tuple[float, float, float]
    sightings: int
    depth_m: float | None = None
    name: str = ""
    time_s: float | None = None
    log: str = ""
    ping: int | None = None
    channel: str = ""
    slant_range_m: float | None = None
    ground_range_m: float | None = None
    altitude_m: float | None = None
    sonar_heading_deg: float | None = None
    sonar_depth_m: float | None = None
    length_m: float | None = None
    width_m: float | None = None
    height_m: float | None = None
    kind: str = ""
    confidence: float | None = None
    passes_seen: int | None = None
    passes_expected: int | None = None
    existence: float | None = None
    snippet: str = ""
    remark: str = ""

    @property
    def label(self) -> str:
        return self.name or f"contact {self.id}"


# Column, and decimals of a number. Degrees to 9 decimals are 0.1 mm.
COLUMNS: dict[str, int | None] = {
    "id": None,
    "name": None,
    "latitude_deg": 9,
    "longitude_deg": 9,
    "easting_m": 3,
    "northing_m": 3,
    "epsg": None,
    "x_m": 4,
    "y_m": 4,
    "depth_m": 3,
    "sigma_major_m": 4,
    "sigma_minor_m": 4,
    "azimuth_deg": 1,
    "time_utc": None,
    "time_s": 3,
    "log": None,
    "ping": None,
    "channel": None,
    "slant_range_m": 3,
    "ground_range_m": 3,
    "altitude_m": 3,
    "sonar_heading_deg": 2,
    "sonar_depth_m": 3,
    "length_m": 2,
    "width_m": 2,
    "height_m": 2,
    "class": None,
    "confidence": 4,
    "sightings": None,
    "passes_seen": None,
    "passes_expected": None,
    "existence": 4,
    "snippet": None,
    "remark": None,
}
CALENDAR_TIMES_FROM_S = 1e8  # a clock that counts from the start of a mission is never here


def contact_rows(contacts: Sequence[Contact], geodetic: Geodetic | None) -> list[dict[str, Any]]:
    """One dictionary a contact with the keys of COLUMNS; None where not known. Geographic ones need an origin; all contacts get the
    UTM zone of the first one, so that a survey over the border of two zones stays in one grid."""
    rows: list[dict[str, Any]] = []
    places = utm = np.zeros((0, 2))
    epsg = None
    if geodetic is not None and contacts:
        places = to_longitude_latitude(np.array([[contact.x_m, contact.y_m] for contact in contacts]), geodetic)
        epsg = utm_epsg(*places[0])
        utm = to_utm(places, epsg)
    for index, contact in enumerate(contacts):
        row: dict[str, Any] = dict.fromkeys(COLUMNS)
        row.update({key: value for key, value in vars(contact).items() if key in COLUMNS and value != ""})
        row["class"] = contact.kind or None
        row["name"] = contact.label
        major, minor, azimuth = error_ellipse(contact.covariance_m2)
        row["sigma_major_m"], row["sigma_minor_m"] = major, minor
        if geodetic is not None:
            (row["longitude_deg"], row["latitude_deg"]), (row["easting_m"], row["northing_m"]) = places[index], utm[index]
            row["epsg"] = epsg
            clockwise = azimuth if geodetic.y_axis == "left" else -azimuth
            row["azimuth_deg"] = (clockwise + geodetic.heading_deg) % 180.0
        if contact.time_s is not None and contact.time_s >= CALENDAR_TIMES_FROM_S:
            row["time_utc"] = datetime.fromtimestamp(contact.time_s, UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
        rows.append(row)
    return rows


def error_ellipse(covariance_m2: Sequence[float]) -> tuple[float, float, float]:
    """Sigmas along the longer and the shorter axis, and the longer axis' angle away from the y axis, counted from the x axis in degrees,
    [0, 180): clockwise where y lies to the left."""
    xx, xy, yy = covariance_m2
    (minor, major), axes = np.linalg.eigh(np.array([[xx, xy], [xy, yy]]))
    angle = -np.degrees(np.arctan2(axes[1, 1], axes[0, 1])) % 180.0
    return float(np.sqrt(max(major, 0.0))), float(np.sqrt(max(minor, 0.0))), float(angle)


def contacts_csv(contacts: Sequence[Contact], geodetic: Geodetic | None) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for row in contact_rows(contacts, geodetic):
        writer.writerow([csv_field(row[column], decimals) for column, decimals in COLUMNS.items()])
    return text.getvalue()


def csv_field(value: Any, decimals: int | None) -> str:
    if value is None:
        return ""
    text = str(value) if decimals is None else f"{float(value):.{decimals}f}"
    # A spreadsheet takes a field that begins like a formula for one.
    return "'" + text if isinstance(value, str) and text[:1] in "=+-@\t\r" else text
