"""From the axes of ROS (REP 103: world east-north-up, body forward-left-up) to north-east-down and forward-starboard-down."""

import numpy as np

from ssjs_cli.formats.number_table import FloatArray

# Each is its own inverse.
NED_R_ENU = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
FRD_R_FLU = np.diag([1.0, -1.0, -1.0])


def rotation_of(quaternion: FloatArray) -> FloatArray:
    """(n, 4) x, y, z, w as ROS orders them, of about unit length, to (n, 3, 3)."""
    x, y, z, w = (quaternion / np.linalg.norm(quaternion, axis=1, keepdims=True)).T
    rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
        [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
    ]
    rotation: FloatArray = np.moveaxis(np.array(rows), 2, 0)
    return rotation


def roll_pitch_yaw(world_R_body: FloatArray) -> FloatArray:
    """(n, 3, 3) = Rz(yaw) Ry(pitch) Rx(roll) to (n, 3)."""
    roll = np.arctan2(world_R_body[:, 2, 1], world_R_body[:, 2, 2])
    pitch = -np.arcsin(np.clip(world_R_body[:, 2, 0], -1.0, 1.0))
    yaw = np.arctan2(world_R_body[:, 1, 0], world_R_body[:, 0, 0])
    return np.column_stack([roll, pitch, yaw])


def marine_attitude(quaternion: FloatArray, *, is_marine: bool) -> FloatArray:
    """(n, 4) x, y, z, w to (n, 3) roll, pitch, yaw of forward-starboard-down in north-east-down. is_marine: they are of these already."""
    world_R_body = rotation_of(quaternion)
    return roll_pitch_yaw(world_R_body if is_marine else NED_R_ENU @ world_R_body @ FRD_R_FLU)


def marine_vectors(body: FloatArray, *, is_marine: bool) -> FloatArray:
    """(n, 3) of body axes."""
    turned: FloatArray = body if is_marine else body @ FRD_R_FLU
    return turned
