"""The records of an underwater mission as the estimator takes them."""

from pathlib import Path
from typing import Any

from ssjs_cli import _core
from ssjs_cli.config import Layer
from ssjs_cli.errors import UserError
from ssjs_cli.formats.mission import MISSION_FILE, Mission
from ssjs_cli.formats.navigation import IMU_FILE
from ssjs_cli.underwater_clock import check_clock

DRIVE_KEY = "motion.drive"
NORTH_KEY = "joining.north_offset_rad"


def rotation_drive(mission: Mission, directory: Path) -> Layer:
    """Without a gyro the turn rates are states of the filter."""
    if mission.navigation is not None and mission.navigation.attitude.turn_rate_rad_s is None:
        return Layer(f"no turn rates in {directory / IMU_FILE}", {DRIVE_KEY: "rates"})
    return Layer("turn rates", {})


def north(mission: Mission, directory: Path) -> Layer:
    """Where the mission has a place on earth, its world is aligned to the north of its compass."""
    if mission.geodetic is None:
        return Layer("no origin", {})
    return Layer(f"the origin in {directory / MISSION_FILE}", {NORTH_KEY: 0.0})


def build_navigation_log(mission: Mission, directory: Path, lost: list[str]) -> Any:
    """Sightings before the first attitude or after the last one have no vehicle to belong to; `lost` is told how many."""
    navigation = mission.navigation
    if navigation is None:
        raise UserError(f"{directory}: holds neither odometry.csv nor {IMU_FILE}; a mission needs the motion of its vehicle")
    check_clock(mission, navigation, directory)
    log = _core.NavigationLog()
    attitude = navigation.attitude
    try:
        log.add_attitude(attitude.time_s, attitude.angles_rad)
        if attitude.turn_rate_rad_s is not None:
            log.add_gyro(attitude.time_s, attitude.turn_rate_rad_s)
        if navigation.velocity is not None:
            velocity = navigation.velocity
            log.add_velocity(velocity.time_s, velocity.velocity_m_s, velocity.bottom_lock.tolist())
        if navigation.depth is not None:
            log.add_depth(navigation.depth.time_s, navigation.depth.value)
        if navigation.altitude is not None:
            log.add_altitude(navigation.altitude.time_s, navigation.altitude.value)
        if navigation.fixes is not None:
            fixes = navigation.fixes
            used = (fixes.time_s >= attitude.time_s[0]) & (fixes.time_s <= attitude.time_s[-1])
            if not used.all():
                lost.append(f"{int((~used).sum())} of {len(used)} position fixes lie outside the time of {IMU_FILE} and were not used")
            log.add_fixes(fixes.time_s[used], fixes.position_m[used], fixes.sigma_m[used])
        if mission.points is not None:
            points = mission.points
            used = (points.time_s >= attitude.time_s[0]) & (points.time_s <= attitude.time_s[-1])
            if not used.all():
                lost.append(f"{int((~used).sum())} of {len(used)} observations lie outside the time of {IMU_FILE} and were not used")
            covariance = None if points.covariance_m2 is None else points.covariance_m2[used]
            ids = None if points.landmark_id is None else points.landmark_id[used].tolist()
            log.add_sightings(points.time_s[used], points.position_m[used], covariance, ids)
        if mission.keypoints is not None:
            keypoints = mission.keypoints
            descriptor = keypoints.descriptor if len(keypoints.descriptor) else None
            ids = None if keypoints.landmark_id is None else keypoints.landmark_id.tolist()
            log.add_frames(keypoints.time_s, keypoints.pixel, keypoints.count.tolist(), descriptor, ids)
    except ValueError as error:
        raise UserError(f"{directory}: {error}") from error
    return log
