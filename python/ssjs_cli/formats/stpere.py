"""The log of the Ictineu vehicle in the abandoned marina of Sant Pere Pescador as an underwater mission: AHRS, DVL and DGPS.

What the headers of the files do not say, or say wrongly:
- the AHRS columns called position are roll, pitch and yaw in degrees, those called velocity the rates of turn of its axes in rad/s;
- the DVL counts its clock in six columns of its own, which are not that of the log: the first column is the time; velocities are in cm/s
  and 32767 where the bottom was not seen (status 0); the log was mounted turned by (180, 0, 60) degrees: upside down, and aside;
- the column called pressure holds two values, 1472 and 1488, for the whole hour: no depth can be had from it. The vehicle was held
  near the surface by the float of its DGPS antenna;
- latitude and longitude are degrees and minutes run together, 4212.225 = 42 deg 12.225';
- the yaw of the AHRS points about 80 degrees east of north: an offset to be estimated, not a constant of the mission.
"""

import math
from pathlib import Path

import numpy as np

from ssjs_cli.errors import UserError
from ssjs_cli.formats.attitude import rotation
from ssjs_cli.formats.file_digest import file_digest
from ssjs_cli.formats.geographic import from_longitude_latitude
from ssjs_cli.formats.mission import Fixes, Geodetic, ImportRecord, Mission, Reference, ReferenceDescription
from ssjs_cli.formats.navigation import Attitude, BottomVelocity, UnderwaterNavigation
from ssjs_cli.formats.number_table import FloatArray

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

# A gyro with a bias of half a degree a second, and a small vehicle whose velocity changes within the second between two DVL samples.
VEHICLE_SETTINGS = {
    "motion": {"velocity_walk_m_s_sqrt_s": 0.5},
    "start": {"gyro_bias_sigma_rad_s": 0.02, "speed_m_s": 0.0},
    "velocity_log": {"sigma_m_s": 0.05},
}


def read_stpere(source: Path) -> Mission:
    if not source.is_dir():
        raise UserError(f"{source}: is no directory; name the one that holds the files *{AHRS_SUFFIX}, *{DVL_SUFFIX} and *{DGPS_SUFFIX}")
    paths = [_only(source, suffix) for suffix in (AHRS_SUFFIX, DVL_SUFFIX, DGPS_SUFFIX)]
    ahrs, dvl, dgps = (_read_log(path, fields) for path, fields in zip(paths, (AHRS_FIELDS, DVL_FIELDS, DGPS_FIELDS), strict=True))
    velocity = bottom_velocity(dvl)
    latitude, longitude = (degrees_of(dgps[:, column], paths[2]) for column in (1, 2))
    geodetic = Geodetic(origin_latitude_deg=float(latitude[0]), origin_longitude_deg=float(longitude[0]), heading_deg=0.0, y_axis="right")
    lost = int((~velocity.bottom_lock).sum())
    return Mission(
        name="stpere",
        description="Ictineu vehicle in an abandoned marina, 56 minutes, about 690 m",
        notes="Reference: DGPS of a float above the vehicle. North-east-down; yaw is that of the AHRS, about 80 degrees off north. "
        "No depth: the pressure column of the log holds two values.",
        navigation=UnderwaterNavigation(
            attitude=Attitude(ahrs[:, 0], np.deg2rad(ahrs[:, 1:4]), np.ascontiguousarray(ahrs[:, 4:7])),
            velocity=velocity,
        ),
        reference=Reference(
            ReferenceDescription(alignment="none", max_gap_s=2.0),
            fixes=Fixes(
                dgps[:, 0], from_longitude_latitude(np.column_stack([longitude, latitude]), geodetic), np.full(len(dgps), DGPS_SIGMA_M)
            ),
        ),
        settings=VEHICLE_SETTINGS,
        geodetic=geodetic,
        import_record=ImportRecord(
            format="stpere",
            counts={
                "attitudes": len(ahrs),
                "bottom_velocities": len(dvl),
                "bottom_velocities_without_lock": lost,
                "dgps_fixes": len(dgps),
            },
            digests={path.name: file_digest(path) for path in paths},
        ),
    )


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
