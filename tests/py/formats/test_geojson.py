import json
import math

import numpy as np
import pytest

from ssjs_cli.formats.geojson import CHI_SQUARED_95_TWO_DOF, ellipse_outline, map_geojson
from ssjs_cli.formats.mission import Geodetic


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
