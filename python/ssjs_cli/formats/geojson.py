"""Track, landmarks and their 95 % ellipses as GeoJSON (RFC 7946: longitude, latitude, WGS 84)."""

import json
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ssjs_cli.formats.mission import Geodetic
from ssjs_cli.formats.number_table import FloatArray

WGS84_SEMI_MAJOR_AXIS_M = 6378137.0
WGS84_FLATTENING = 1.0 / 298.257223563
CHI_SQUARED_95_TWO_DOF = 5.991464547107979
ELLIPSE_POINTS = 24
DEGREE_DECIMALS = 9
MIN_TRACK_STEP_M = 0.1


def to_longitude_latitude(position_m: FloatArray, geodetic: Geodetic) -> FloatArray:
    """(n, 2) x, y of the global frame to (n, 2) longitude, latitude in degrees. The global frame is the plane that touches WGS 84
    at the origin: local east-north to earth-centred coordinates, and from there to the foot point on the ellipsoid."""
    heading = math.radians(geodetic.heading_deg)
    east_m = position_m[:, 0] * math.sin(heading) - position_m[:, 1] * math.cos(heading)
    north_m = position_m[:, 0] * math.cos(heading) + position_m[:, 1] * math.sin(heading)
    latitude, longitude = math.radians(geodetic.origin_latitude_deg), math.radians(geodetic.origin_longitude_deg)
    eccentricity_squared = WGS84_FLATTENING * (2.0 - WGS84_FLATTENING)
    radius_m = WGS84_SEMI_MAJOR_AXIS_M / math.sqrt(1.0 - eccentricity_squared * math.sin(latitude) ** 2)
    # Along the meridian plane of the origin: away from the axis, and up the axis.
    outward_m = radius_m * math.cos(latitude) - north_m * math.sin(latitude)
    axial_m = radius_m * (1.0 - eccentricity_squared) * math.sin(latitude) + north_m * math.cos(latitude)
    longitude_rad = longitude + np.arctan2(east_m, outward_m)
    latitude_rad = _geodetic_latitude(np.hypot(outward_m, east_m), axial_m, eccentricity_squared)
    return np.column_stack([np.degrees(longitude_rad), np.degrees(latitude_rad)])


def _geodetic_latitude(distance_to_axis_m: FloatArray, axial_m: FloatArray, eccentricity_squared: float) -> FloatArray:
    """Bowring's formula with the reduced latitude; near the surface its error is far below a micrometre."""
    semi_minor_axis_m = WGS84_SEMI_MAJOR_AXIS_M * (1.0 - WGS84_FLATTENING)
    second_eccentricity_squared = eccentricity_squared / (1.0 - eccentricity_squared)
    reduced = np.arctan2(axial_m * WGS84_SEMI_MAJOR_AXIS_M, distance_to_axis_m * semi_minor_axis_m)
    latitude: FloatArray = np.arctan2(
        axial_m + second_eccentricity_squared * semi_minor_axis_m * np.sin(reduced) ** 3,
        distance_to_axis_m - eccentricity_squared * WGS84_SEMI_MAJOR_AXIS_M * np.cos(reduced) ** 3,
    )
    return latitude


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
    features = [_feature("LineString", _coordinates(_thinned(track_m), geodetic), {"kind": "track"})]
    for landmark_id, position_m, covariance in zip(landmark_ids, landmarks_m, covariances, strict=True):
        sigma_major_m = math.sqrt(max(float(np.linalg.eigvalsh(np.array([covariance[:2], covariance[1:]]))[-1]), 0.0))
        properties = {"kind": "landmark", "id": landmark_id, "sigma_major_m": round(sigma_major_m, 9)}
        features.append(_feature("Point", _coordinates(position_m[None, :], geodetic)[0], properties))
        outline = _coordinates(ellipse_outline(position_m, covariance), geodetic)
        features.append(_feature("Polygon", [outline], {"kind": "ellipse", "id": landmark_id, "probability": 0.95}))
    return json.dumps({"type": "FeatureCollection", "features": features}, allow_nan=False) + "\n"


def _feature(kind: str, coordinates: Any, properties: dict[str, Any]) -> dict[str, Any]:
    return {"type": "Feature", "geometry": {"type": kind, "coordinates": coordinates}, "properties": properties}


def _coordinates(position_m: FloatArray, geodetic: Geodetic) -> list[list[float]]:
    rounded: list[list[float]] = np.round(to_longitude_latitude(position_m, geodetic), DEGREE_DECIMALS).tolist()
    return rounded


def _thinned(track_m: FloatArray) -> FloatArray:
    """First, last, and the points at least MIN_TRACK_STEP_M from the one kept before; a line needs two."""
    kept = [0]
    for index in range(1, len(track_m)):
        step = track_m[index] - track_m[kept[-1]]
        if step[0] * step[0] + step[1] * step[1] >= MIN_TRACK_STEP_M**2:
            kept.append(index)
    if kept[-1] != len(track_m) - 1 or len(kept) == 1:
        kept.append(len(track_m) - 1)
    return track_m[kept]
