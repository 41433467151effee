import json
import math

import numpy as np
import pytest

from ssjs_cli.formats.geojson import CHI_SQUARED_95_TWO_DOF, ellipse_outline, map_geojson, to_longitude_latitude
from ssjs_cli.formats.mission import Geodetic

# WGS 84: a = 6378137 m, f = 1/298.257223563, e^2 = f (2 - f) = 0.00669437999014
SEMI_MAJOR_AXIS_M = 6378137.0
MERIDIAN_RADIUS_AT_EQUATOR_M = 6335439.3273  # a (1 - e^2)
MICRODEGREE = 1e-6


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


def test_the_ellipse_has_the_95_percent_radii_and_runs_anticlockwise() -> None:
    outline = ellipse_outline(np.array([1.0, 2.0]), (4.0, 0.0, 0.25))
    radius = math.sqrt(CHI_SQUARED_95_TWO_DOF)
    assert outline[:, 0].max() - 1.0 == pytest.approx(2.0 * radius)
    assert outline[:, 1].max() - 2.0 == pytest.approx(0.5 * radius)
    assert (outline[0] == outline[-1]).all()
    x, y = outline.T
    assert float(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1])) > 0.0


def test_the_document_holds_track_points_and_ellipses_and_no_crs() -> None:
    geodetic = Geodetic(origin_latitude_deg=0.0, origin_longitude_deg=0.0)
    track = np.array([[0.0, 0.0], [0.01, 0.0], [1.0, 0.0], [1.0, 0.0]])
    document = json.loads(map_geojson(track, np.array([[5.0, 5.0]]), np.array([[0.04, 0.0, 0.09]]), [7], geodetic))
    assert "crs" not in document
    assert [feature["geometry"]["type"] for feature in document["features"]] == ["LineString", "Point", "Polygon"]
    # The second point is 1 cm from the first and left out; the last one is kept.
    assert len(document["features"][0]["geometry"]["coordinates"]) == 3
    assert document["features"][1]["properties"] == {"kind": "landmark", "id": 7, "sigma_major_m": 0.3}


def test_a_vehicle_that_stands_still_still_gives_a_line() -> None:
    geodetic = Geodetic(origin_latitude_deg=0.0, origin_longitude_deg=0.0)
    document = json.loads(map_geojson(np.zeros((3, 2)), np.zeros((0, 2)), np.zeros((0, 3)), [], geodetic))
    assert len(document["features"][0]["geometry"]["coordinates"]) == 2
