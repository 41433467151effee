"""The contacts of a season as operators exchange them: season_contacts.csv and .geojson."""

import csv
import io
from collections.abc import Mapping, Sequence
from typing import Any

from ssjs_cli.formats.contact_table import COLUMNS as CONTACT_COLUMNS
from ssjs_cli.formats.contact_table import Contact, contact_rows, csv_field
from ssjs_cli.formats.geojson import contact_features, feature_collection, track_feature
from ssjs_cli.formats.mission import Geodetic

PLACE_COLUMNS = (
    "id", "latitude_deg", "longitude_deg", "easting_m", "northing_m", "epsg", "depth_m", "sigma_major_m", "sigma_minor_m", "azimuth_deg",
)  # fmt: skip
#: Column, and decimals of a number.
COLUMNS: Mapping[str, int | None] = {
    **{name: CONTACT_COLUMNS[name] for name in PLACE_COLUMNS},
    "depth_sigma_m": 3,
    "missions": None,
    "sightings": None,
    "seen_by": None,
}


def season_rows(contacts: Sequence[Any], origin: Geodetic) -> list[dict[str, Any]]:
    """One a SeasonContact; seen_by: run directory and number of the landmark there, a space between two missions."""
    rows = []
    for contact, placed in zip(contacts, contact_rows(_plain(contacts), origin), strict=True):
        row: dict[str, Any] = {name: placed[name] for name in PLACE_COLUMNS}
        row["depth_sigma_m"] = contact.depth_sigma_m
        row["missions"] = len(contact.seen_by)
        row["sightings"] = contact.times_seen
        row["seen_by"] = " ".join(f"{mission}:{landmark}" for mission, landmark in contact.seen_by)
        rows.append(row)
    return rows


def season_contacts_csv(regions: Sequence[Any]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for region in regions:
        for row in season_rows(region.contacts, region.origin):
            writer.writerow([csv_field(row[column], decimals) for column, decimals in COLUMNS.items()])
    return text.getvalue()


def season_geojson(regions: Sequence[Any]) -> str:
    """A track a mission, a point and an ellipse a contact."""
    features = []
    for region in regions:
        for mission in region.missions:
            features.append(track_feature(mission.track_m, region.origin, mission=mission.name))
        properties = [
            {name: row[name] if decimals is None else round(float(row[name]), decimals) for name, decimals in COLUMNS.items()}
            for row in season_rows(region.contacts, region.origin)
        ]
        features += contact_features(_plain(region.contacts), properties, region.origin)
    return feature_collection(features)


def _plain(contacts: Sequence[Any]) -> list[Contact]:
    return [
        Contact(contact.id, contact.position_m[0], contact.position_m[1], contact.covariance_m2, contact.times_seen, contact.position_m[2])
        for contact in contacts
    ]
