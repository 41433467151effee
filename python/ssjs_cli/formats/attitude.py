"""Roll, pitch and yaw as a rotation."""

import math

import numpy as np

from ssjs_cli.formats.number_table import FloatArray


def rotation(roll: float, pitch: float, yaw: float) -> FloatArray:
    """Rz(yaw) Ry(pitch) Rx(roll): (3, 3), north-east-down from forward-starboard-down. rad"""
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, math.cos(roll), -math.sin(roll)], [0.0, math.sin(roll), math.cos(roll)]])
    about_y = np.array([[math.cos(pitch), 0.0, math.sin(pitch)], [0.0, 1.0, 0.0], [-math.sin(pitch), 0.0, math.cos(pitch)]])
    about_z = np.array([[math.cos(yaw), -math.sin(yaw), 0.0], [math.sin(yaw), math.cos(yaw), 0.0], [0.0, 0.0, 1.0]])
    product: FloatArray = about_z @ about_y @ about_x
    return product
