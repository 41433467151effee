"""What the three-dimensional view draws: ellipsoids, lines and labels, as foxglove.SceneUpdate in the frame `world`."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ssjs_cli.formats.number_table import FloatArray
from ssjs_cli.mcap_export.frames import WORLD, quaternion_of
from ssjs_cli.mcap_export.schemas import UNUSED_PRIMITIVES

SIGMAS = 3.0
MIN_DIAMETER_M = 0.01  # of the axes in which the covariance says nothing, such as z in the plane
LINE_WIDTH_PX = 2.0
LABEL_SIZE_PX = 12.0

Colour = tuple[float, float, float, float]
Primitives = dict[str, list[dict[str, Any]]]

CORRECTED: Colour = (0.12, 0.47, 0.71, 1.0)
RECKONED: Colour = (0.50, 0.50, 0.50, 1.0)
OWN_ELLIPSOID: Colour = (0.12, 0.47, 0.71, 0.30)
LANDMARK: Colour = (1.00, 0.50, 0.05, 0.50)
LOOP: Colour = (0.17, 0.63, 0.17, 1.0)
LABEL: Colour = (1.00, 1.00, 1.00, 1.0)

NO_TURN = (0.0, 0.0, 0.0, 1.0)


def vector(values: Sequence[float]) -> dict[str, float]:
    return dict(zip("xyz", values, strict=True))


def quaternion(values: Sequence[float]) -> dict[str, float]:
    return dict(zip("xyzw", values, strict=True))


def pose(position_m: Sequence[float], orientation: Sequence[float] = NO_TURN) -> dict[str, Any]:
    return {"position": vector(position_m), "orientation": quaternion(orientation)}


def ellipsoid(position_m: Sequence[float], covariance_m2: FloatArray, colour: Colour) -> dict[str, Any]:
    """The 3-sigma surface of a (3, 3) covariance: the semi-axes are 3 sqrt(eigenvalue) along the eigenvectors."""
    eigenvalues, axes = np.linalg.eigh(covariance_m2)
    if np.linalg.det(axes) < 0.0:
        axes = -axes
    diameters = np.maximum(2.0 * SIGMAS * np.sqrt(np.maximum(eigenvalues, 0.0)), MIN_DIAMETER_M)
    return {"pose": pose(position_m, quaternion_of(axes)), "size": vector(diameters.tolist()), "color": _colour(colour)}


def line(points_m: FloatArray, kind: int, colour: Colour) -> dict[str, Any]:
    """points_m (n, 3)"""
    return {
        "type": kind,
        "pose": pose((0.0, 0.0, 0.0)),
        "thickness": LINE_WIDTH_PX,
        "scale_invariant": True,
        "points": [vector(point) for point in points_m.tolist()],
        "color": _colour(colour),
        "colors": [],
        "indices": [],
    }


def label(position_m: Sequence[float], text: str) -> dict[str, Any]:
    return {
        "pose": pose(position_m),
        "billboard": True,
        "font_size": LABEL_SIZE_PX,
        "scale_invariant": True,
        "color": _colour(LABEL),
        "text": text,
    }


def entity(identity: str, timestamp: dict[str, int], **primitives: list[dict[str, Any]]) -> dict[str, Any]:
    """Stays until one of the same identity replaces it."""
    empty: Primitives = {name: [] for name in ("spheres", "lines", "texts", *UNUSED_PRIMITIVES)}
    return {
        "timestamp": timestamp,
        "frame_id": WORLD,
        "id": identity,
        "lifetime": {"sec": 0, "nsec": 0},
        "frame_locked": True,
        "metadata": [],
        **empty,
        **primitives,
    }


def update(*entities: dict[str, Any]) -> dict[str, Any]:
    return {"deletions": [], "entities": list(entities)}


def _colour(colour: Colour) -> dict[str, float]:
    return dict(zip("rgba", colour, strict=True))
