"""The Victoria Park data set (Guivant and Nebot, IEEE Trans. Robotics and Automation 17(3), 2001) as a mission.

Odometry and GPS come from the .mat files, the laser from LASER.txt (a text without line ends, 362 numbers a scan: time in s,
then 361 ranges in m from -90 to +90 deg), whose clock is moved to that of the .mat files.
"""

import hashlib
import math
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from ssjs_cli.errors import UserError
from ssjs_cli.formats.mission import Fixes, ImportRecord, Mission, Odometry, Reference, ReferenceDescription, Scans
from ssjs_cli.formats.number_table import FloatArray
from ssjs_cli.formats.zip_member import read_member

LASER_FILE = "LASER.txt"
LASER_ARCHIVE = "victoria_park_ascii.zip"
ODOMETRY_FILE = "aa3_dr.mat"
GPS_FILE = "aa3_gpsx.mat"

BEAMS = 361
TOKENS_PER_SCAN = 1 + BEAMS
LASER_CLOCK_OFFSET_S = 20.967
MAX_LASER_BYTES = 256 * 1024**2
MAX_MAT_BYTES = 64 * 1024**2

# The GPS is referenced at the laser; the tracked point a = 3.78, b = 0.5 m is the laser to within this arm.
LEVER_ARM_FORWARD_M = -0.09
LEVER_ARM_LEFT_M = -0.06
GPS_OUTLIER_M = 10.0
# Per axis; the fixes lie 0.93 m (median) from a published least-squares track, and the median of a planar error is 1.18 sigma.
GPS_SIGMA_M = 0.8

SETTINGS: dict[str, Any] = {
    "vehicle": {
        "kind": "ackerman",
        "ackerman": {
            "wheelbase_m": 2.83,
            "encoder_offset_m": 0.76,
            "reference_forward_m": 3.78,
            "reference_left_m": 0.5,
            "steering_scale": 1.037,
            "steering_offset_rad": 0.0043,
            "speed_sigma_m_s": 0.5,
            "steering_sigma_rad": math.radians(2.0),
            "lateral_sigma_m_s": 0.5,
            "noise_step_s": 0.025,
        },
    },
    "sensor": {
        "range_sigma_m": 0.1,
        "bearing_sigma_rad": math.radians(0.5),
        "bearing_offset_rad": math.radians(-1.0),
        "min_range_m": 3.0,
        "max_range_m": 38.0,
    },
    # Beams 0-11 see the vehicle itself, 80 m and more means that nothing was hit.
    "trees": {"masked_beams": 12, "no_return_m": 80.0, "min_range_m": 3.0, "max_range_m": 38.0},
    "association": {"method": "jcbb", "gate_probability": 0.99, "new_landmark_squared_distance": 25.0},
    # The detector sees things that are no trees: a landmark counts after three sightings. Standing still repeats the same errors.
    "submap": {
        "max_landmarks": 15,
        "max_sigma_xy_m": 2.0,
        "min_sightings": 3,
        "prune_after_scans": 15,
        "min_motion_m": 0.02,
        "split_boundary_scan": True,
    },
    # Neighbouring maps overlap (range 38 m, a map is 17 m long) and would fill the fused maps: a gap of 3.
    # The ambiguity gate is 0.3 of the median tree spacing, 5.7 m.
    "joining": {
        "fusion_threshold": 0.4,
        "min_gap": 3,
        "max_fused_landmarks": 60,
        "max_pairing_sigma_m": 1.7,
        "joint_gate_probability": 0.95,
        "fusion_probability": 0.99,
    },
}


def read_victoria_park(source: Path) -> Mission:
    if not source.is_dir():
        files = f"{LASER_ARCHIVE} (or {LASER_FILE}), {ODOMETRY_FILE} and {GPS_FILE}"
        raise UserError(f"{source}: is no directory; name the one that holds {files}")
    counts: dict[str, int] = {}
    lost: list[str] = []
    odometry = _read_odometry(source / ODOMETRY_FILE)
    laser_text, laser_path = _laser_text(source)
    scans = parse_laser_text(laser_text, laser_path, lost)
    gps_path = source / GPS_FILE
    fixes = _read_gps(gps_path) if gps_path.is_file() else None
    if fixes is None:
        lost.append(f"{GPS_FILE} is missing: the mission has no reference")
    counts.update(odometry_records=len(odometry.values), scans=len(scans.time_s), gps_fixes=0 if fixes is None else len(fixes.time_s))
    used = [laser_path, source / ODOMETRY_FILE, *([gps_path] if fixes is not None else [])]
    return Mission(
        name="victoria-park",
        description="utility car with a laser among the trees of Victoria Park, Sydney, 26 minutes, about 4 km",
        notes="Guivant and Nebot, IEEE Trans. Robotics and Automation 17(3), 2001. Reference: GPS of one drive, no surveyed map.",
        odometry=odometry,
        scans=scans,
        settings=SETTINGS,
        reference=Reference(
            ReferenceDescription(
                lever_arm_forward_m=LEVER_ARM_FORWARD_M,
                lever_arm_left_m=LEVER_ARM_LEFT_M,
                outlier_m=GPS_OUTLIER_M,
                alignment="se2",
            ),
            fixes=fixes,
        ),
        import_record=ImportRecord(
            format="victoria-park",
            counts=counts,
            lost=lost,
            digests={path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in used},
        ),
    )


def _laser_text(source: Path) -> tuple[bytes, Path]:
    archive_path, text_path = source / LASER_ARCHIVE, source / LASER_FILE
    if archive_path.is_file():
        return read_member(archive_path, LASER_FILE, MAX_LASER_BYTES), archive_path
    if text_path.is_file():
        if text_path.stat().st_size > MAX_LASER_BYTES:
            raise UserError(f"{text_path}: is larger than the {MAX_LASER_BYTES} bytes allowed; give the file of the data set")
        return text_path.read_bytes(), text_path
    raise UserError(f"{source}: neither {LASER_ARCHIVE} nor {LASER_FILE} is there; name the directory that holds the data set")


def parse_laser_text(data: bytes, path: Path, lost: list[str]) -> Scans:
    """Scans on the clock of the .mat files. What an incomplete last scan holds is dropped and named in `lost`."""
    values = _parse_numbers(data, path)
    scan_count, rest = divmod(len(values), TOKENS_PER_SCAN)
    if scan_count == 0:
        raise UserError(f"{path}: {LASER_FILE} holds {len(values)} numbers, less than one scan of {TOKENS_PER_SCAN}; fetch the file again")
    if rest:
        lost.append(f"{LASER_FILE}: the last scan is incomplete ({rest} of {TOKENS_PER_SCAN} numbers) and was dropped")
    rows = values[: scan_count * TOKENS_PER_SCAN].reshape(scan_count, TOKENS_PER_SCAN)
    # Both clocks count whole milliseconds: rounding removes the error of the addition.
    time_s = np.round(rows[:, 0] + LASER_CLOCK_OFFSET_S, 3)
    not_finite = ~np.isfinite(rows).all(axis=1)
    if not_finite.any():
        raise UserError(f"{path}: {LASER_FILE} scan {int(np.argmax(not_finite))} holds NaN or infinity; fetch the file again")
    backwards = np.diff(time_s) < 0.0
    if backwards.any():
        scan = int(np.argmax(backwards)) + 1
        raise UserError(f"{path}: {LASER_FILE} scan {scan} goes back in time; a number before it is missing or extra, fetch the file again")
    if (rows[:, 1:] < 0.0).any():
        scan = int(np.argmax((rows[:, 1:] < 0.0).any(axis=1)))
        raise UserError(f"{path}: {LASER_FILE} scan {scan} holds a negative range; fetch the file again")
    return Scans(time_s, np.ascontiguousarray(rows[:, 1:]), math.radians(-90.0), math.radians(0.5))


def _parse_numbers(data: bytes, path: Path) -> FloatArray:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            return np.fromstring(data.decode("ascii"), dtype=np.float64, sep=" ")
    except (ValueError, DeprecationWarning, UnicodeDecodeError) as error:
        raise UserError(f"{path}: {LASER_FILE} {_first_bad_token(data)}; fetch the file again") from error


def _first_bad_token(data: bytes) -> str:
    for position, token in enumerate(data.split()):
        try:
            float(token)
        except ValueError:
            return f"number {position + 1} (scan {position // TOKENS_PER_SCAN}) is {token[:20]!r}"
    return "is not a text of numbers"


def _load_mat(path: Path, names: tuple[str, ...]) -> list[FloatArray]:
    """The named vectors of a MATLAB file, all of one length."""
    from scipy.io import loadmat

    if not path.is_file():
        raise UserError(f"{path}: is missing; name the directory that holds the data set")
    if path.stat().st_size > MAX_MAT_BYTES:
        raise UserError(f"{path}: is larger than the {MAX_MAT_BYTES} bytes allowed; give the file of the data set")
    try:
        content: dict[str, Any] = loadmat(path, variable_names=list(names))
    except Exception as error:  # the reader raises many kinds on a damaged file
        raise UserError(f"{path}: is damaged or no MATLAB file ({type(error).__name__}: {error}); fetch the file again") from error
    vectors: list[FloatArray] = []
    for name in names:
        array = content.get(name)
        if array is None or array.dtype.kind not in "fiu":
            raise UserError(f"{path}: the variable {name} is missing or holds no numbers; fetch the file again")
        vector = np.asarray(array, dtype=np.float64).ravel()
        if len(vector) == 0 or not np.isfinite(vector).all():
            raise UserError(f"{path}: the variable {name} is empty or holds NaN; fetch the file again")
        vectors.append(vector)
    if len({len(vector) for vector in vectors}) > 1:
        raise UserError(f"{path}: {', '.join(names)} differ in length; fetch the file again")
    if (np.diff(vectors[0]) < 0.0).any():
        raise UserError(f"{path}: {names[0]} goes back at entry {int(np.argmax(np.diff(vectors[0]) < 0.0)) + 2}; fetch the file again")
    return vectors


def _read_odometry(path: Path) -> Odometry:
    time_ms, speed_m_s, steering_rad = _load_mat(path, ("time", "speed", "steering"))
    return Odometry("ackerman", np.column_stack([time_ms / 1000.0, speed_m_s, steering_rad]))


def _read_gps(path: Path) -> Fixes:
    """x east (Lo_m), y north (La_m), metres from an arbitrary origin."""
    time_ms, east_m, north_m = _load_mat(path, ("timeGps", "Lo_m", "La_m"))
    return Fixes(time_ms / 1000.0, np.column_stack([east_m, north_m]), np.full(len(time_ms), GPS_SIGMA_M))
