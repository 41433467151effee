"""Frames of a vehicle whose poses are known, over pebbles."""

from pathlib import Path

import numpy as np
from PIL import Image
from seabed_frames import pebbles

from ssjs_cli import _core
from ssjs_cli.formats.camera_calibration import CameraCalibration
from ssjs_cli.formats.frames import FrameIndex
from ssjs_cli.formats.number_table import FloatArray

CAMERA = CameraCalibration(240, 180, 220.0, 220.0, 119.5, 89.5)
SEABED_M = 12.0
DEPTH_M = 8.0
METRES_PER_PX = 0.02  # of the picture of the ground: north up, its lower left corner at (0, 0)
GROUND_PX = 600


def poses() -> FloatArray:
    """(n, 6): two lines north and south, tilted a little."""
    north = np.concatenate((np.linspace(3.0, 9.0, 13), np.linspace(9.0, 3.0, 13)))
    east = np.concatenate((np.full(13, 5.0), np.full(13, 7.0)))
    heading = np.concatenate((np.zeros(13), np.full(13, np.pi)))
    tilt = 0.05 * np.sin(np.arange(26))
    return np.column_stack((north, east, np.full(26, DEPTH_M), tilt, -tilt, heading))


def write_frames(folder: Path) -> FrameIndex:
    folder.mkdir()
    ground = pebbles(GROUND_PX, GROUND_PX)
    names = []
    camera = {**CAMERA.__dict__}
    for number, pose in enumerate(poses()):
        world = _core.ground_homography(pose, SEABED_M, camera, {})
        assert world is not None
        # (north, east) -> column, row of the ground's picture
        picture = np.array([[0.0, 1.0 / METRES_PER_PX, -0.5], [-1.0 / METRES_PER_PX, 0.0, GROUND_PX - 0.5], [0.0, 0.0, 1.0]]) @ world
        picture /= picture[2, 2]
        size = (CAMERA.width_px, CAMERA.height_px)
        names.append(f"{number:02d}.png")
        ground.transform(size, Image.Transform.PERSPECTIVE, picture.ravel()[:8].tolist(), Image.Resampling.BILINEAR).save(
            folder / names[-1]
        )
    return FrameIndex(folder, np.arange(26.0), tuple(names), CAMERA)
