"""The log of the Ictineu vehicle in the abandoned marina of Sant Pere Pescador as an underwater mission: AHRS, DVL and DGPS.

What the headers of the files do not say, or say wrongly:
- the AHRS columns called position are roll, pitch and yaw in degrees, those called velocity the rates of turn of its axes in rad/s;
- the DVL counts its clock in six columns of its own, which are not that of the log: the first column is the time; velocities are in cm/s
  and 32767 where the bottom was not seen (status 0); the log was mounted turned by (180, 0, 60) degrees: upside down, and aside;
- the column called pressure holds two values, 1472 and 1488, for the whole hour: no depth can be had from it. The vehicle was held
  near the surface by the float of its DGPS antenna;
- latitude and longitude are degrees and minutes run together, 4212.225 = 42 deg 12.225';
- the yaw of the AHRS points about 80 degrees east of north: an offset to be estimated, not a constant of the mission. The import takes it
  from the first quarter of the log; the rest of DGPS is for scoring alone.

With `landmarks` the mission is half real (simulated_posts): the log is real, and posts are put around the way that DGPS tells.
"""

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ssjs_cli.errors import UserError
from ssjs_cli.formats.attitude import rotation
from ssjs_cli.formats.bottom_track import bottom_track, positions_at, yaw_between, yaw_between_legs
from ssjs_cli.formats.file_digest import file_digest
from ssjs_cli.formats.geographic import from_longitude_latitude
from ssjs_cli.formats.mission import Fixes, Geodetic, ImportRecord, Mission, Reference, ReferenceDescription
from ssjs_cli.formats.navigation import Attitude, BottomVelocity, UnderwaterNavigation
from ssjs_cli.formats.number_table import FloatArray
from ssjs_cli.formats.tum import PoseSeries, wrapped_angle
from ssjs_cli.simulated_posts import simulate_posts

AHRS_SUFFIX = "_MTI.log"
DVL_SUFFIX = "_DVL.log"
DGPS_SUFFIX = "_DGPS.log"
AHRS_FIELDS, DVL_FIELDS, DGPS_FIELDS = 10, 32, 10

DVL_VELOCITY = slice(11, 14)
DVL_STATUS = 14
NO_VELOCITY = 32767.0
DVL_MOUNTING_RPY_DEG = (180.0, 0.0, 60.0)
CM_S = 0.01
DGPS_SIGMA_M = 1.0

# A gyro with a bias of half a degree a second. Two velocities differ by 0.29 m/s (RMS of an axis) whether 1 or 16 samples lie between them:
# white noise of 0.2 m/s on a velocity that hardly changes. With such a log a map is uncertain to 0.3 m within seconds.
VEHICLE_SETTINGS = {
    "motion": {"velocity_walk_m_s_sqrt_s": 0.05},
    "start": {"gyro_bias_sigma_rad_s": 0.02, "speed_m_s": 0.0},
    "velocity_log": {"sigma_m_s": 0.2},
    "split": {"max_sigma_xy_m": 1.0},
}
CALIBRATION_FRACTION = 0.25
# DGPS steps by 0.2 m and follows the vehicle on a line; the velocity log's drift takes some minutes to grow beyond that.
LEG_S = 40


@dataclass(frozen=True)
class YawOffset:
    """AHRS yaw plus `rad` is the heading from north."""

    rad: float
    sigma_rad: float
    fixes: int


def read_stpere(source: Path, *, landmarks: int = 0, seed: int = 1) -> Mission:
    if not source.is_dir():
        raise UserError(f"{source}: is no directory; name the one that holds the files *{AHRS_SUFFIX}, *{DVL_SUFFIX} and *{DGPS_SUFFIX}")
    paths = [_only(source, suffix) for suffix in (AHRS_SUFFIX, DVL_SUFFIX, DGPS_SUFFIX)]
    ahrs, dvl, dgps = (_read_log(path, fields) for path, fields in zip(paths, (AHRS_FIELDS, DVL_FIELDS, DGPS_FIELDS), strict=True))
    attitude = Attitude(ahrs[:, 0], np.deg2rad(ahrs[:, 1:4]), np.ascontiguousarray(ahrs[:, 4:7]))
    velocity = bottom_velocity(dvl)
    latitude, longitude = (degrees_of(dgps[:, column], paths[2]) for column in (1, 2))
    geodetic = Geodetic(origin_latitude_deg=float(latitude[0]), origin_longitude_deg=float(longitude[0]), heading_deg=0.0, y_axis="right")
    fixes = Fixes(dgps[:, 0], from_longitude_latitude(np.column_stack([longitude, latitude]), geodetic), np.full(len(dgps), DGPS_SIGMA_M))
    offset = yaw_offset(attitude, velocity, fixes)
    counts = {
        "attitudes": len(ahrs),
        "bottom_velocities": len(dvl),
        "bottom_velocities_without_lock": int((~velocity.bottom_lock).sum()),
        "dgps_fixes": len(dgps),
        "dgps_fixes_used_for_yaw_offset": 0 if offset is None else offset.fixes,
    }
    mission = Mission(
        name="stpere",
        description="Ictineu vehicle in an abandoned marina, 56 minutes, about 690 m",
        notes="Reference: DGPS of a float above the vehicle. North-east-down. "
        f"No depth: the pressure column of the log holds two values. {_said(offset)}",
        navigation=UnderwaterNavigation(attitude, velocity),
        reference=Reference(ReferenceDescription(alignment="none", max_gap_s=2.0), fixes=fixes),
        settings=VEHICLE_SETTINGS if offset is None else {**VEHICLE_SETTINGS, "joining": _north(offset)},
        geodetic=geodetic,
        import_record=ImportRecord(format="stpere", counts=counts, digests={path.name: file_digest(path) for path in paths}),
    )
    return _with_posts(mission, attitude, velocity, fixes, landmarks, seed) if landmarks else mission


def yaw_offset(attitude: Attitude, velocity: BottomVelocity, fixes: Fixes) -> YawOffset | None:
    """Of the track of the first quarter of the log, turned on DGPS. None where the log is too short to tell."""
    tracked_s, tracked_m = bottom_track(attitude, velocity)
    if len(tracked_s) < 2:
        return None
    end_s = tracked_s[0] + CALIBRATION_FRACTION * (tracked_s[-1] - tracked_s[0])
    early = (fixes.time_s >= tracked_s[0]) & (fixes.time_s <= end_s)
    if int(early.sum()) <= 2 * LEG_S:
        return None
    track_m, reference_m = positions_at(fixes.time_s[early], tracked_s, tracked_m), fixes.position_m[early]
    _, sigma_rad = yaw_between_legs(track_m, reference_m, LEG_S)
    return YawOffset(yaw_between(track_m, reference_m), sigma_rad, int(early.sum()))


def _north(offset: YawOffset) -> dict[str, float]:
    """What the AHRS is expected to read when the vehicle heads north."""
    return {"north_offset_rad": round(-offset.rad, 6), "north_offset_sigma_rad": round(offset.sigma_rad, 6)}


def _said(offset: YawOffset | None) -> str:
    if offset is None:
        return "Yaw is that of the AHRS, about 80 degrees off north; the log is too short to estimate the offset."
    return (
        f"Yaw is that of the AHRS; heading = yaw {math.degrees(offset.rad):+.1f} deg (sigma {math.degrees(offset.sigma_rad):.1f}), "
        f"joining.north_offset_rad, from the velocity log's track and the {offset.fixes} fixes of the first quarter of the log alone."
    )


def _with_posts(mission: Mission, attitude: Attitude, velocity: BottomVelocity, fixes: Fixes, count: int, seed: int) -> Mission:
    """Seen from where DGPS is, heading by the AHRS less its offset over the whole log: neither is told to the filter."""
    truth = reference_poses(attitude, velocity, fixes)
    seen = simulate_posts(truth, count, seed)
    simulated = {"simulated_landmarks": count, "simulated_sightings": len(seen.points.time_s), "simulated_clutter": seen.clutter}
    record = mission.import_record
    return replace(
        mission,
        name="stpere-half-real",
        description=f"{mission.description}; {count} simulated posts, seed {seed}",
        notes=f"{mission.notes} Posts and what a scanning sonar of 30 m sees of them are simulated; all else is the log.",
        points=seen.points,
        reference=replace(mission.reference, truth=truth, landmarks=seen.landmarks),
        import_record=None if record is None else record.model_copy(update={"counts": {**record.counts, **simulated}}),
    )


def reference_poses(attitude: Attitude, velocity: BottomVelocity, fixes: Fixes) -> PoseSeries:
    """The way that DGPS tells, at every attitude between two fixes. The offset of the heading is that of legs over the whole log."""
    tracked_s, tracked_m = bottom_track(attitude, velocity)
    inside = (fixes.time_s >= tracked_s[0]) & (fixes.time_s <= tracked_s[-1])
    if int(inside.sum()) <= 2 * LEG_S:
        raise UserError("the log is too short to place landmarks along it; leave --landmarks out")
    offset_rad, _ = yaw_between_legs(positions_at(fixes.time_s[inside], tracked_s, tracked_m), fixes.position_m[inside], LEG_S)
    between = (attitude.time_s >= fixes.time_s[0]) & (attitude.time_s <= fixes.time_s[-1])
    time_s = attitude.time_s[between]
    heading_rad = wrapped_angle(attitude.angles_rad[between, 2] + offset_rad)
    return PoseSeries(time_s, np.column_stack([positions_at(time_s, fixes.time_s, fixes.position_m), heading_rad]))


def bottom_velocity(dvl: FloatArray) -> BottomVelocity:
    """In the body frame, forward, starboard, down. The status decides, and so does the number that stands for no velocity."""
    measured = dvl[:, DVL_VELOCITY]
    lock = (dvl[:, DVL_STATUS] == 1.0) & (measured != NO_VELOCITY).all(axis=1)
    body_R_dvl = rotation(*(math.radians(angle) for angle in DVL_MOUNTING_RPY_DEG))
    velocity = np.where(lock[:, None], CM_S * measured, np.nan) @ body_R_dvl.T
    return BottomVelocity(dvl[:, 0], velocity, lock)


def degrees_of(degrees_and_minutes: FloatArray, path: Path) -> FloatArray:
    """4212.225 -> 42.20375"""
    degrees = np.floor(degrees_and_minutes / 100.0)
    minutes = degrees_and_minutes - 100.0 * degrees
    odd = (minutes >= 60.0) | (np.abs(degrees) > 180.0)
    if odd.any():
        raise UserError(
            f"{path}: {float(degrees_and_minutes[int(np.argmax(odd))])!r} is no angle of degrees and minutes; fetch the file again"
        )
    angle: FloatArray = degrees + minutes / 60.0
    return angle


def _only(source: Path, suffix: str) -> Path:
    found = sorted(source.glob(f"*{suffix}"))
    if len(found) != 1:
        names = ", ".join(path.name for path in found)
        raise UserError(f"{source}: holds {len(found)} files *{suffix}{f' ({names})' if names else ''}; it must hold exactly one")
    return found[0]


def _read_log(path: Path, fields: int) -> FloatArray:
    """Rows of numbers between blanks. Lines that begin with % are comments, in the character set of their time."""
    rows: list[list[float]] = []
    for line, text in enumerate(path.read_text(encoding="latin-1").splitlines(), 1):
        content = text.strip()
        if not content or content.startswith("%"):
            continue
        words = content.split()
        if len(words) != fields:
            raise UserError(f"{path}:{line}: has {len(words)} fields where {fields} are needed; complete or remove the line")
        try:
            row = [float(word) for word in words]
        except ValueError as error:
            raise UserError(f"{path}:{line}: {error}; correct or remove the line") from error
        if not all(math.isfinite(value) for value in row):
            raise UserError(f"{path}:{line}: holds NaN or infinity; correct or remove the line")
        if rows and row[0] < rows[-1][0]:
            raise UserError(f"{path}:{line}: the time goes back from {rows[-1][0]!r} to {row[0]!r}; sort the lines")
        rows.append(row)
    if not rows:
        raise UserError(f"{path}: holds no line of numbers; fetch the file again")
    return np.array(rows)
