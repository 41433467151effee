"""Track, landmarks and their 95 % ellipses as GeoJSON (RFC 7946: longitude, latitude, WGS 84)."""

import json
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ssjs_cli.formats.contact_table import COLUMNS, Contact, contact_rows
from ssjs_cli.formats.geographic import to_longitude_latitude
from ssjs_cli.formats.mission import Geodetic
from ssjs_cli.formats.number_table import FloatArray

CHI_SQUARED_95_TWO_DOF = 5.991464547107979
ELLIPSE_POINTS = 24
DEGREE_DECIMALS = 9
MIN_TRACK_STEP_M = 0.1


def ellipse_outline(position_m: FloatArray, covariance: Sequence[float]) -> FloatArray:
    """(points + 1, 2) closed anticlockwise outline of the 95 % ellipse of xx, xy, yy."""
    xx, xy, yy = covariance
    eigenvalues, axes = np.linalg.eigh(np.array([[xx, xy], [xy, yy]]))
    radii = np.sqrt(np.maximum(eigenvalues, 0.0) * CHI_SQUARED_95_TWO_DOF)
    if np.linalg.det(axes) < 0.0:
        axes = axes[:, ::-1]
        radii = radii[::-1]
    angle = np.linspace(0.0, 2.0 * np.pi, ELLIPSE_POINTS + 1)
    circle = np.column_stack([radii[0] * np.cos(angle), radii[1] * np.sin(angle)])
    outline: FloatArray = position_m + circle @ axes.T
    outline[-1] = outline[0]
    return outline


def map_geojson(
    track_m: FloatArray, landmarks_m: FloatArray, covariances: FloatArray, landmark_ids: Sequence[int], geodetic: Geodetic
) -> str:
    """track_m (n, 2), thinned to MIN_TRACK_STEP_M; landmarks_m (l, 2); covariances (l, 3) xx xy yy."""
    features = [track_feature(track_m, geodetic)]
    for landmark_id, position_m, covariance in zip(landmark_ids, landmarks_m, covariances, strict=True):
        sigma_major_m = math.sqrt(max(float(np.linalg.eigvalsh(np.array([covariance[:2], covariance[1:]]))[-1]), 0.0))
        properties = {"kind": "landmark", "id": landmark_id, "sigma_major_m": round(sigma_major_m, 9)}
        features.append(_feature("Point", _coordinates(position_m[None, :], geodetic)[0], properties))
        outline = _coordinates(ellipse_outline(position_m, covariance), geodetic)
        features.append(_feature("Polygon", [outline], {"kind": "ellipse", "id": landmark_id, "probability": 0.95}))
    return feature_collection(features)


def survey_geojson(track_m: FloatArray, contacts: Sequence[Contact], geodetic: Geodetic) -> str:
    """track_m (n, 2) as above; contacts with the columns of contacts.csv as properties, and their ellipses."""
    properties: list[dict[str, Any]] = []
    for row in contact_rows(contacts, geodetic):
        told = {column: decimals for column, decimals in COLUMNS.items() if row[column] is not None}
        properties.append(
            {column: row[column] if decimals is None else round(float(row[column]), decimals) for column, decimals in told.items()}
        )
    features = [track_feature(track_m, geodetic)] if len(track_m) else []
    return feature_collection([*features, *contact_features(contacts, properties, geodetic)])


def contact_features(contacts: Sequence[Contact], properties: Sequence[dict[str, Any]], geodetic: Geodetic) -> list[dict[str, Any]]:
    """A point with its properties, latitude_deg and longitude_deg among them, and its 95 % ellipse."""
    features = []
    for contact, told in zip(contacts, properties, strict=True):
        place = [round(float(told[key]), DEGREE_DECIMALS) for key in ("longitude_deg", "latitude_deg")]
        features.append(_feature("Point", place, {"kind": "contact", **told}))
        outline = _coordinates(ellipse_outline(np.array([contact.x_m, contact.y_m]), contact.covariance_m2), geodetic)
        features.append(_feature("Polygon", [outline], {"kind": "ellipse", "id": contact.id, "probability": 0.95}))
    return features


def track_feature(track_m: FloatArray, geodetic: Geodetic, **properties: Any) -> dict[str, Any]:
    return _feature("LineString", _coordinates(thinned(track_m), geodetic), {"kind": "track", **properties})


def feature_collection(features: Sequence[dict[str, Any]]) -> str:
    return json.dumps({"type": "FeatureCollection", "features": features}, allow_nan=False) + "\n"


def _feature(kind: str, coordinates: Any, properties: dict[str, Any]) -> dict[str, Any]:
    return {"type": "Feature", "geometry": {"type": kind, "coordinates": coordinates}, "properties": properties}


def _coordinates(position_m: FloatArray, geodetic: Geodetic) -> list[list[float]]:
    rounded: list[list[float]] = np.round(to_longitude_latitude(position_m, geodetic), DEGREE_DECIMALS).tolist()
    return rounded


def thinned(track_m: FloatArray) -> FloatArray:
    """First, last, and the points at least MIN_TRACK_STEP_M from the one kept before; a line needs two."""
    kept = [0]
    for index in range(1, len(track_m)):
        step = track_m[index] - track_m[kept[-1]]
        if step[0] * step[0] + step[1] * step[1] >= MIN_TRACK_STEP_M**2:
            kept.append(index)
    if kept[-1] != len(track_m) - 1 or len(kept) == 1:
        kept.append(len(track_m) - 1)
    return track_m[kept]
