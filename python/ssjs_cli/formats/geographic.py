"""Between the global frame of a mission, longitude and latitude (WGS 84), and the UTM grid."""

import math
from functools import lru_cache
from typing import Any

import numpy as np

from ssjs_cli.formats.mission import Geodetic
from ssjs_cli.formats.number_table import FloatArray


def to_longitude_latitude(position_m: FloatArray, geodetic: Geodetic) -> FloatArray:
    """(n, 2) x, y of the global frame to (n, 2) longitude, latitude in degrees. The global frame is the plane that touches WGS 84
    at the origin, from where a point goes to its foot on the ellipsoid."""
    east_north = _turned(position_m, geodetic, -1.0)
    longitude, latitude, _ = _tangent_plane(geodetic).transform(
        east_north[:, 0], east_north[:, 1], np.zeros(len(position_m)), direction="INVERSE"
    )
    return np.column_stack([longitude, latitude])


def from_longitude_latitude(longitude_latitude_deg: FloatArray, geodetic: Geodetic) -> FloatArray:
    """(n, 2) longitude, latitude in degrees to (n, 2) x, y of the global frame. At 10 km from the origin the plane lies 8 m above the
    ellipsoid, and a length on it is 1 in a million too long."""
    longitude, latitude = longitude_latitude_deg.T
    east, north, _ = _tangent_plane(geodetic).transform(longitude, latitude, np.zeros(len(longitude)))
    return _turned(np.column_stack([east, north]), geodetic, 1.0)


def utm_epsg(longitude_deg: float, latitude_deg: float) -> int:
    """The EPSG code of the WGS 84 / UTM zone of a place, with the exceptions of Norway and Svalbard; beyond 84 N and 80 S the nearest."""
    longitude_deg = (longitude_deg + 180.0) % 360.0 - 180.0
    zone = min(int((longitude_deg + 180.0) // 6.0) + 1, 60)
    if 56.0 <= latitude_deg < 64.0 and 3.0 <= longitude_deg < 12.0:
        zone = 32
    elif 72.0 <= latitude_deg <= 84.0 and 0.0 <= longitude_deg < 42.0:
        zone = 31 + 2 * int((longitude_deg + 3.0) // 12.0)
    return (32600 if latitude_deg >= 0.0 else 32700) + zone


def to_utm(longitude_latitude_deg: FloatArray, epsg: int) -> FloatArray:
    """(n, 2) longitude, latitude in degrees to (n, 2) easting, northing in metres."""
    return np.column_stack(_utm(epsg).transform(longitude_latitude_deg[:, 0], longitude_latitude_deg[:, 1]))


def _turned(position_m: FloatArray, geodetic: Geodetic, sign: float) -> FloatArray:
    """By the angle from the x axis to the east, against it for -1."""
    angle = sign * math.radians(geodetic.heading_deg - 90.0)
    cosine, sine = math.cos(angle), math.sin(angle)
    x, y = position_m.T
    return np.column_stack([x * cosine - y * sine, x * sine + y * cosine])


# PROJ is loaded where it is needed, for it takes a while.
@lru_cache(maxsize=8)
def _plane_at(longitude_deg: float, latitude_deg: float) -> Any:
    from pyproj import Transformer

    return Transformer.from_pipeline(
        "+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad +step +proj=cart +ellps=WGS84 "
        f"+step +proj=topocentric +ellps=WGS84 +lon_0={longitude_deg!r} +lat_0={latitude_deg!r} +h_0=0"
    )


def _tangent_plane(geodetic: Geodetic) -> Any:
    return _plane_at(geodetic.origin_longitude_deg, geodetic.origin_latitude_deg)


@lru_cache(maxsize=8)
def _utm(epsg: int) -> Any:
    from pyproj import Transformer

    return Transformer.from_crs(4326, epsg, always_xy=True)
