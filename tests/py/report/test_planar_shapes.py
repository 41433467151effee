import math

import numpy as np
import pytest

from ssjs_cli.report.planar_shapes import CHI2_95_TWO_DOF, convex_hull, ellipse_axes, ellipse_outlines


def test_quantile_is_the_tabulated_one():
    assert pytest.approx(5.991, abs=5e-4) == CHI2_95_TWO_DOF


def test_axes_of_a_turned_covariance():
    # variances 9 and 1 turned by 30 degrees: xx = 9 cos^2 + sin^2 = 7, yy = 3, xy = 8 sin cos = 2 sqrt(3)
    half_axes, direction = ellipse_axes(np.array([[7.0, 2.0 * math.sqrt(3.0), 3.0]]))
    assert half_axes[0] == pytest.approx([3.0, 1.0])
    assert direction[0] == pytest.approx(math.radians(30.0))


def test_outline_of_a_circle_has_the_95_percent_radius_and_is_closed():
    outline = ellipse_outlines(np.array([[10.0, -5.0]]), np.array([[4.0, 0.0, 4.0]]), corners=12)[0]
    radius = np.hypot(outline[:, 0] - 10.0, outline[:, 1] + 5.0)
    assert radius == pytest.approx(np.full(13, 2.0 * math.sqrt(5.991464547)))
    assert outline[0] == pytest.approx(outline[-1])


def test_hull_drops_inner_and_collinear_points():
    points = np.array([[0.0, 0.0], [2.0, 0.0], [1.0, 0.0], [2.0, 2.0], [0.0, 2.0], [1.0, 1.0], [0.0, 0.0]])
    assert convex_hull(points).tolist() == [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]


@pytest.mark.parametrize("points", [np.zeros((0, 2)), np.array([[1.0, 2.0]]), np.array([[1.0, 2.0], [3.0, 4.0]])])
def test_hull_of_fewer_than_three_points_is_the_points(points):
    assert convex_hull(points).tolist() == points.tolist()
