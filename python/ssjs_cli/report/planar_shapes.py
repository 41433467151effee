"""Outlines to draw: ellipses of a 2 x 2 covariance and convex hulls, all in the map's own coordinates (metres)."""

import math

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

#: Chi-squared quantile of 95 % with 2 degrees of freedom, in closed form: -2 ln(0.05) = 5.991.
CHI2_95_TWO_DOF = -2.0 * math.log(0.05)


def ellipse_axes(covariance: FloatArray) -> tuple[FloatArray, FloatArray]:
    """covariance (n, 3) as xx, xy, yy -> one-sigma half axes (n, 2), major first, and the major axis' direction (n,) in rad from +x."""
    xx, xy, yy = covariance[:, 0], covariance[:, 1], covariance[:, 2]
    centre = 0.5 * (xx + yy)
    radius = np.hypot(0.5 * (xx - yy), xy)
    variances = np.column_stack((centre + radius, np.maximum(centre - radius, 0.0)))
    return np.sqrt(np.maximum(variances, 0.0)), 0.5 * np.arctan2(2.0 * xy, xx - yy)


def ellipse_outlines(centre: FloatArray, covariance: FloatArray, corners: int) -> FloatArray:
    """95 % ellipses of n points: centre (n, 2), covariance (n, 3) -> closed outlines (n, corners + 1, 2)."""
    half_axes, direction = ellipse_axes(covariance)
    half_axes = half_axes * math.sqrt(CHI2_95_TWO_DOF)
    angle = np.linspace(0.0, 2.0 * math.pi, corners + 1)
    major = half_axes[:, :1] * np.cos(angle)
    minor = half_axes[:, 1:] * np.sin(angle)
    cosine, sine = np.cos(direction)[:, None], np.sin(direction)[:, None]
    return np.stack((centre[:, :1] + cosine * major - sine * minor, centre[:, 1:] + sine * major + cosine * minor), axis=-1)


def convex_hull(points: FloatArray) -> FloatArray:
    """Corners of the convex hull of points (n, 2), anticlockwise, not closed (Andrew's monotone chain)."""
    ordered = np.unique(points, axis=0).tolist()
    if len(ordered) < 3:
        return np.array(ordered, dtype=np.float64).reshape(-1, 2)

    def half_hull(path: list[list[float]]) -> list[list[float]]:
        corners: list[list[float]] = []
        for point in path:
            while len(corners) >= 2 and _turn(corners[-2], corners[-1], point) <= 0.0:
                corners.pop()
            corners.append(point)
        return corners[:-1]

    return np.array(half_hull(ordered) + half_hull(ordered[::-1]), dtype=np.float64)


def _turn(a: list[float], b: list[float], c: list[float]) -> float:
    """Twice the signed area of the triangle a b c: positive when c lies left of the line from a to b."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
