"""The tree of frames. Viewers are z up, an underwater run is z down: nothing is converted, the turn between them is a frame of its own.

`map` (east, north, up) -> `world` (the run's own global frame) -> `vehicle` (its body) -> `base_link` (forward, port, up), and
`world` -> `dead_reckoning`. All messages are in `world`, with the numbers of the run's files.
"""

import math

import numpy as np

from ssjs_cli.formats.mission import Geodetic
from ssjs_cli.formats.number_table import FloatArray

MAP, WORLD, VEHICLE, BASE_LINK, DEAD_RECKONING = "map", "world", "vehicle", "base_link", "dead_reckoning"


def map_R_world(geodetic: Geodetic | None, *, under_water: bool) -> FloatArray:  # noqa: N802
    """(3, 3). Without an origin the first heading of an underwater run is called north, the x axis of a planar one east."""
    heading_deg = geodetic.heading_deg if geodetic is not None else (0.0 if under_water else 90.0)
    y_is_right = under_water if geodetic is None else geodetic.y_axis == "right"
    sine, cosine = math.sin(math.radians(heading_deg)), math.cos(math.radians(heading_deg))
    x_axis = np.array([sine, cosine, 0.0])
    right = np.array([cosine, -sine, 0.0])
    up = np.array([0.0, 0.0, 1.0])
    return np.column_stack([x_axis, right, -up] if y_is_right else [x_axis, -right, up])


def vehicle_R_base_link(*, under_water: bool) -> FloatArray:  # noqa: N802
    """(3, 3): half a turn about the forward axis leads from starboard and down to port and up."""
    return np.diag([1.0, -1.0, -1.0]) if under_water else np.eye(3)


def quaternion_of(rotation: FloatArray) -> tuple[float, float, float, float]:
    """x, y, z, w of a (3, 3) rotation, with the sign that makes the largest component positive."""
    from scipy.spatial.transform import Rotation

    quaternion = Rotation.from_matrix(rotation).as_quat()
    quaternion = np.where(np.abs(quaternion) < 1e-15, 0.0, quaternion)
    x, y, z, w = (quaternion * np.sign(quaternion[np.argmax(np.abs(quaternion))]) + 0.0).tolist()
    return x, y, z, w
