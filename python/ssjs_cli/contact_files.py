"""The contacts of a run in every form that operators take."""

from collections.abc import Sequence
from pathlib import Path

from ssjs_cli.formats.contact_table import Contact, contacts_csv
from ssjs_cli.formats.geojson import survey_geojson
from ssjs_cli.formats.geopackage import write_geopackage
from ssjs_cli.formats.kml import survey_kml
from ssjs_cli.formats.mission import Geodetic
from ssjs_cli.formats.number_table import FloatArray
from ssjs_cli.formats.run_directory import CONTACTS_FILE, CONTACTS_GEOJSON_FILE, CONTACTS_GPKG_FILE, CONTACTS_KML_FILE


def write_contacts(directory: Path, name: str, track_m: FloatArray, contacts: Sequence[Contact], geodetic: Geodetic | None) -> None:
    """The geographic ones only where the mission has an origin. track_m (n, 2), global frame."""
    (directory / CONTACTS_FILE).write_text(contacts_csv(contacts, geodetic), encoding="utf-8")
    if geodetic is None:
        return
    (directory / CONTACTS_GEOJSON_FILE).write_text(survey_geojson(track_m, contacts, geodetic), encoding="utf-8")
    (directory / CONTACTS_KML_FILE).write_text(survey_kml(name, track_m, contacts, geodetic), encoding="utf-8")
    write_geopackage(directory / CONTACTS_GPKG_FILE, track_m, contacts, geodetic)
