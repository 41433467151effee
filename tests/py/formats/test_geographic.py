import math

import numpy as np
import pytest

from ssjs_cli.formats.geographic import from_longitude_latitude, to_longitude_latitude, to_utm, utm_epsg
from ssjs_cli.formats.mission import Geodetic

# WGS 84: a = 6378137 m, f = 1/298.257223563, e^2 = f (2 - f) = 0.00669437999014
SEMI_MAJOR_AXIS_M = 6378137.0
MERIDIAN_RADIUS_AT_EQUATOR_M = 6335439.3273  # a (1 - e^2)


def test_x_points_east_by_default_and_y_north() -> None:
    at_equator = Geodetic(origin_latitude_deg=0.0, origin_longitude_deg=10.0)
    east, north = to_longitude_latitude(np.array([[100.0, 0.0], [0.0, 100.0]]), at_equator)
    assert east == pytest.approx([10.0 + math.degrees(100.0 / SEMI_MAJOR_AXIS_M), 0.0], abs=1e-9)
    assert north == pytest.approx([10.0, math.degrees(100.0 / MERIDIAN_RADIUS_AT_EQUATOR_M)], abs=1e-9)


def test_a_heading_of_zero_turns_x_to_the_north_and_y_to_the_west() -> None:
    at_equator = Geodetic(origin_latitude_deg=0.0, origin_longitude_deg=10.0, heading_deg=0.0)
    x, y = to_longitude_latitude(np.array([[100.0, 0.0], [0.0, 100.0]]), at_equator)
    assert x == pytest.approx([10.0, math.degrees(100.0 / MERIDIAN_RADIUS_AT_EQUATOR_M)], abs=1e-9)
    assert y == pytest.approx([10.0 - math.degrees(100.0 / SEMI_MAJOR_AXIS_M), 0.0], abs=1e-9)


def test_at_60_degrees_a_metre_east_is_twice_as_many_degrees() -> None:
    # Radius of the parallel: N cos(lat), N = a / sqrt(1 - e^2 sin^2 lat) = 6394209.17 m at 60 degrees
    geodetic = Geodetic(origin_latitude_deg=60.0, origin_longitude_deg=0.0)
    ((longitude, latitude),) = to_longitude_latitude(np.array([[1.0, 0.0]]), geodetic)
    assert longitude == pytest.approx(math.degrees(1.0 / (6394209.17 * 0.5)), rel=1e-7)
    assert latitude == pytest.approx(60.0, abs=1e-9)


def test_the_origin_stays_the_origin() -> None:
    geodetic = Geodetic(origin_latitude_deg=-33.9, origin_longitude_deg=151.2, heading_deg=35.0)
    assert to_longitude_latitude(np.zeros((1, 2)), geodetic)[0] == pytest.approx([151.2, -33.9], abs=1e-12)


def test_there_and_back_again() -> None:
    geodetic = Geodetic(origin_latitude_deg=60.1, origin_longitude_deg=-20.3, heading_deg=35.0)
    position_m = np.random.default_rng(1).uniform(-1000.0, 1000.0, (20, 2))
    there = to_longitude_latitude(position_m, geodetic)
    assert from_longitude_latitude(there, geodetic) == pytest.approx(position_m, abs=1e-4)


@pytest.mark.parametrize(
    ("longitude_deg", "latitude_deg", "epsg"),
    [
        (-180.0, 10.0, 32601),
        (179.9, 10.0, 32660),
        (180.0, 10.0, 32601),
        (9.0, 48.0, 32632),
        (151.2, -33.9, 32756),
        (5.3, 60.4, 32632),  # Bergen, in a zone made wider
        (15.6, 78.2, 32633),  # Longyearbyen
        (20.0, 75.0, 32633),
    ],
)
def test_the_zone_of_a_place(longitude_deg: float, latitude_deg: float, epsg: int) -> None:
    assert utm_epsg(longitude_deg, latitude_deg) == epsg


def test_the_central_meridian_has_500_km_east_and_the_scale_0_9996() -> None:
    # Arc of the meridian from the equator to 1 degree: 110574.4 m
    ((easting, northing),) = to_utm(np.array([[9.0, 1.0]]), 32632)
    assert easting == pytest.approx(500000.0, abs=1e-6)
    assert northing == pytest.approx(0.9996 * 110574.3886, abs=0.01)
