"""Settings of a camera mission that follow from its files."""

from pathlib import Path

from ssjs_cli.config import Layer, Scalar
from ssjs_cli.formats.frames import CALIBRATION_FILE, FRAMES_FOLDER
from ssjs_cli.formats.mission import Mission

KEYPOINTS_KEY = "frames.keypoints.max_keypoints"
#: Each is a landmark of the filter until it is out of sight.
MAX_KEYPOINTS = 40
CHANCE_KEY = "joining.max_chance_odds"
#: A seabed full of keypoints offers a foreign one for every pair: where few pairs speak for each other none is taken.
MAX_CHANCE_ODDS = 0.01
ALIGNMENTS_KEY = "joining.max_chance_alignments"
#: A line of a survey lies over earlier ones some eighty times: so that hardly one mission in ten is turned by a chance alignment.
MAX_CHANCE_ALIGNMENTS = 0.001
SIGMA_KEY = "camera.sigma_px"
#: Of SURF in frames, with what the keypoints of a landmark have in common from frame to frame: so the maps' links are as wrong as they say.
SIGMA_PX = 0.7
RELIEF_KEY = "camera.relief"
#: Part of the altitude. A wider one leaves it to the velocity log how far away the seabed is, and the maps come out too small.
RELIEF = 0.1


def camera_of(mission: Mission, directory: Path) -> Layer:
    """The pinhole camera that is left once the lens is corrected, as many keypoints of a frame as a filter can follow, their noise, the
    seabed's relief, and how surely one must be another's."""
    if mission.frames is None or mission.has_frames_alone:
        return Layer("no camera", {})
    values: dict[str, Scalar] = {
        KEYPOINTS_KEY: MAX_KEYPOINTS,
        CHANCE_KEY: MAX_CHANCE_ODDS,
        ALIGNMENTS_KEY: MAX_CHANCE_ALIGNMENTS,
        SIGMA_KEY: SIGMA_PX,
        RELIEF_KEY: RELIEF,
    }
    camera = mission.frames.calibration
    if camera is not None:
        values |= {
            "camera.width_px": camera.width_px,
            "camera.height_px": camera.height_px,
            "camera.fx_px": camera.focal_x_px,
            "camera.fy_px": camera.focal_y_px,
            "camera.cx_px": camera.centre_x_px,
            "camera.cy_px": camera.centre_y_px,
        }
    return Layer(str(directory / FRAMES_FOLDER / CALIBRATION_FILE), values)
