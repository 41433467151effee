"""How far the landmarks of a camera lie from what they were seen at. docs/math/camera_simulation.md, Truth of a landmark

A keypoint has no name in the world. Its truth is where the ray of its first sighting, from where the vehicle truly was, meets the true
seabed.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ssjs_cli.config import Scalar
from ssjs_cli.formats.mission import Mission, Reference
from ssjs_cli.formats.number_table import FloatArray, IntArray
from ssjs_cli.formats.true_surface import TrueSurface
from ssjs_cli.optical.keyframes import poses_at

#: Steps of (CS-4); each shrinks the error to less than a half.
STEPS = 60
MOUNT = ("mount_roll_rad", "mount_pitch_rad", "mount_yaw_rad", "mount_forward_m", "mount_starboard_m", "mount_down_m")
INTRINSICS = ("fx_px", "fy_px", "cx_px", "cy_px")


def landmark_numbers(mission: Mission, result: Mapping[str, Any], settings: Mapping[str, Scalar]) -> dict[str, Any]:
    """Keys of summary.json; None where the truth is not there, or not in the frame of the estimate."""
    keys = ("landmarks_compared", "landmark_error_rms_m", "landmark_error_median_m", "landmark_error_max_m")
    reference = mission.reference
    if reference.surface is None or reference.truth is None or reference.description.alignment != "none":
        return dict.fromkeys(keys)
    error_m = landmark_errors_m(reference, result, settings)
    if not len(error_m):
        return dict.fromkeys(keys)
    numbers = (np.sqrt((error_m**2).mean()), np.median(error_m), error_m.max())
    return dict(zip(keys, (len(error_m), *(round(float(number), 6) for number in numbers)), strict=True))


def landmark_errors_m(reference: Reference, result: Mapping[str, Any], settings: Mapping[str, Scalar]) -> FloatArray:
    """(n,) of the landmarks with a sighting, in space."""
    landmarks, sightings = result["landmarks"], result["frame_sightings"]
    first = _first_sightings(landmarks["tracks"], np.asarray(sightings["landmark"]))
    rows = np.flatnonzero(first >= 0)
    if reference.truth is None or reference.surface is None or not len(rows):
        return np.zeros(0)
    pose = poses_at(reference.truth, np.asarray(sightings["time_s"])[first[rows]])
    pixel = np.asarray(sightings["measured_px"])[first[rows]]
    seen_m = seen_points_m(pose, pixel, reference.surface, {key: float(settings[f"camera.{key}"] or 0.0) for key in (*INTRINSICS, *MOUNT)})
    error_m: FloatArray = np.linalg.norm(np.asarray(landmarks["position"])[rows] - seen_m, axis=1)
    return error_m


def _first_sightings(tracks: Any, of_sighting: IntArray) -> IntArray:
    """By landmark: the first row of its tracks, -1 without one."""
    first_of_track: dict[int, int] = {}
    for row, track in enumerate(of_sighting.tolist()):
        first_of_track.setdefault(track, row)
    firsts = [min((first_of_track[track] for track in own if track in first_of_track), default=-1) for own in tracks]
    return np.array(firsts, dtype=np.int64)


def seen_points_m(pose: FloatArray, pixel: FloatArray, surface: TrueSurface, camera: Mapping[str, float]) -> FloatArray:
    """pose (n, 6) x, y, z, roll, pitch, heading of the vehicle; pixel (n, 2), corrected. (n, 3) points of the surface. (CS-4)"""
    fx, fy, cx, cy = (camera[key] for key in INTRINSICS)
    mount = np.array([camera[key] for key in MOUNT])
    ray = np.column_stack([(pixel[:, 0] - cx) / fx, (pixel[:, 1] - cy) / fy, np.ones(len(pixel))])
    world_R_vehicle = rotations(pose[:, 3:6])
    direction = np.einsum("nij,jk,nk->ni", world_R_vehicle, rotations(mount[None, :3])[0], ray)
    origin = pose[:, :3] + np.einsum("nij,j->ni", world_R_vehicle, mount[3:])
    depth_m = surface.at(origin[:, 0], origin[:, 1])
    point: FloatArray = origin
    for _ in range(STEPS):
        point = origin + ((depth_m - origin[:, 2]) / direction[:, 2])[:, None] * direction
        depth_m = surface.at(point[:, 0], point[:, 1])
    return point


def rotations(rpy: FloatArray) -> FloatArray:
    """(n, 3) roll, pitch, yaw: (n, 3, 3) Rz Ry Rx."""
    (sr, sp, sy), (cr, cp, cy) = np.sin(rpy).T, np.cos(rpy).T
    rows = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    R: FloatArray = np.moveaxis(np.array(rows), 2, 0)
    return R
