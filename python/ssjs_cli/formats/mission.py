"""A mission directory: mission.toml and one file per sensor and reference."""

import difflib
import math
import zipfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal

import numpy as np
import tomli_w
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from ssjs_cli.errors import UserError, nearest_hint
from ssjs_cli.formats.atomic import holds_only
from ssjs_cli.formats.camera_calibration import calibration_text
from ssjs_cli.formats.file_digest import file_digest
from ssjs_cli.formats.frames import (
    CALIBRATION_FILE,
    FRAME_INDEX_FILE,
    FRAMES_FOLDER,
    FrameIndex,
    FrameKeypoints,
    frame_digests,
    index_text,
    outline_frames,
    read_frames,
)
from ssjs_cli.formats.navigation import (
    NAVIGATION_FILES,
    POSITION_FIXES_FILE,
    UnderwaterNavigation,
    outline_navigation,
    read_navigation,
    write_navigation,
)
from ssjs_cli.formats.number_table import (
    EXACT,
    TEXT,
    WHOLE,
    FloatArray,
    IntArray,
    NumberTable,
    holds_file,
    read_header,
    read_table,
    require_positive,
    require_positive_range,
    require_times_in_order,
    whole_numbers,
    write_table,
)
from ssjs_cli.formats.physical_bounds import require_plausible
from ssjs_cli.formats.position_fixes import read_position_fixes
from ssjs_cli.formats.toml_file import load_toml
from ssjs_cli.formats.true_surface import SURFACE_FILE, TrueSurface, read_true_surface, write_true_surface
from ssjs_cli.formats.tum import PoseSeries, read_tum, write_tum
from ssjs_cli.formats.zip_member import check_archive_size

MISSION_FILE = "mission.toml"
ODOMETRY_FILE = "odometry.csv"
OBSERVATIONS_FILE = "observations.csv"
SCANS_FILE = "scans.npz"
PINGS_FOLDER = "pings"
SONAR_LOG_SUFFIXES = (".xtf", ".jsf")
SONAR_HITS_FILE = "sonar_hits.csv"
TRUTH_FILE = "truth_trajectory.tum"
FIXES_FILE = "reference_fixes.csv"
LANDMARKS_FILE = "truth_landmarks.csv"
MISSION_FILES = (
    MISSION_FILE,
    ODOMETRY_FILE,
    OBSERVATIONS_FILE,
    SCANS_FILE,
    SONAR_HITS_FILE,
    *NAVIGATION_FILES,
    POSITION_FIXES_FILE,
    TRUTH_FILE,
    FIXES_FILE,
    LANDMARKS_FILE,
    SURFACE_FILE,
)

ODOMETRY_COLUMNS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "ackerman": ("time_s", "speed_m_s", "steering_rad"),
        "unicycle": ("time_s", "speed_m_s", "turn_rate_rad_s"),
        "increments": ("time_s", "dx_m", "dy_m", "dheading_rad", "sigma_x_m", "sigma_y_m", "sigma_heading_rad"),
    }
)
POLAR_COLUMNS = ("range_m", "bearing_rad")
CARTESIAN_COLUMNS = ("x_m", "y_m")
POINT_COLUMNS = ("x_m", "y_m", "z_m")
POINT_COVARIANCE_COLUMNS = ("var_xx_m2", "cov_xy_m2", "cov_xz_m2", "var_yy_m2", "cov_yz_m2", "var_zz_m2")
COVARIANCE_COLUMNS = ("var_range_m2", "cov_range_bearing", "var_bearing_rad2")
SCAN_ARRAYS = ("time_s", "range_m", "first_angle_rad", "step_rad")
MAX_SCANS_BYTES = 4 * 1024**3

# What the estimator takes as "not told". In files the field is empty.
UNKNOWN_LANDMARK = -1

ALIGNMENTS = ("none", "origin", "yaw", "se2")


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)


class MissionDescription(_Table):
    name: str = Field(min_length=1)
    description: str = ""
    notes: str = ""


class Geodetic(_Table):
    """Where the global frame's origin lies and where its x axis points (degrees clockwise from north; 90 is east). The y axis lies to
    the left of it, as on land, or to the right, as under water, where z points down."""

    origin_latitude_deg: float = Field(ge=-90.0, le=90.0)
    origin_longitude_deg: float = Field(ge=-180.0, le=180.0)
    heading_deg: float = Field(default=90.0, ge=-360.0, le=360.0)
    y_axis: Literal["left", "right"] = "left"
    # How far the origin may be off, each axis, and the x axis turned: what other missions over the same ground are held against.
    origin_sigma_m: float | None = Field(default=None, gt=0.0)
    heading_sigma_deg: float | None = Field(default=None, gt=0.0)


class ReferenceDescription(_Table):
    """How the reference is compared. The lever arm leads from the tracked point of the vehicle to the referenced one."""

    lever_arm_forward_m: float = 0.0
    lever_arm_left_m: float = 0.0
    outlier_m: float | None = Field(default=None, gt=0.0)
    alignment: Literal["none", "origin", "yaw", "se2"] = "none"
    max_gap_s: float = Field(default=1.0, gt=0.0)


class ImportRecord(_Table):
    """What an importer read, dropped and lost."""

    format: str
    counts: dict[str, int] = Field(default_factory=dict)
    lost: list[str] = Field(default_factory=list)
    digests: dict[str, str] = Field(default_factory=dict)


class MissionDocument(_Table):
    """mission.toml. `settings` is checked against the estimator's own description when a run resolves its configuration."""

    mission: MissionDescription
    geodetic: Geodetic | None = None
    settings: dict[str, Any] = Field(default_factory=dict)
    reference: ReferenceDescription = Field(default_factory=ReferenceDescription)
    import_record: ImportRecord | None = Field(default=None, alias="import")


@dataclass(frozen=True)
class Odometry:
    """kind: a key of ODOMETRY_COLUMNS; values (n, columns of the kind) in the order of those columns."""

    kind: str
    values: FloatArray

    @property
    def time_s(self) -> FloatArray:
        return self.values[:, 0]


@dataclass(frozen=True)
class Observations:
    """time_s, range_m, bearing_rad (n,), sensor frame; covariance (n, 3) var_range, cov, var_bearing; landmark_id (n,),
    UNKNOWN_LANDMARK where the source does not tell."""

    time_s: FloatArray
    range_m: FloatArray
    bearing_rad: FloatArray
    covariance: FloatArray | None = None
    landmark_id: IntArray | None = None


@dataclass(frozen=True)
class BodyPoints:
    """Points seen by an underwater vehicle: time_s (n,); position_m (n, 3), body frame (forward, starboard, down); landmark_id as in
    Observations; covariance_m2 (n, 6) upper triangles where the source gives them."""

    time_s: FloatArray
    position_m: FloatArray
    landmark_id: IntArray | None = None
    covariance_m2: FloatArray | None = None


@dataclass(frozen=True)
class Scans:
    """time_s (n,); range_m (n, beams); beam i points at first_angle_rad + i step_rad, 0 ahead, anticlockwise."""

    time_s: FloatArray
    range_m: FloatArray
    first_angle_rad: float
    step_rad: float


@dataclass(frozen=True)
class SonarHits:
    """Strong returns of a forward-looking sonar, sensor frame: time_s, range_m, bearing_rad (n,); rows of equal time are one image.
    intensity (n,) as the sensor gives it."""

    time_s: FloatArray
    range_m: FloatArray
    bearing_rad: FloatArray
    intensity: FloatArray | None = None


@dataclass(frozen=True)
class Fixes:
    """Sparse positions such as GPS: time_s (n,), position_m (n, 2), sigma_m (n,)."""

    time_s: FloatArray
    position_m: FloatArray
    sigma_m: FloatArray | None = None


@dataclass(frozen=True)
class SurveyedLandmarks:
    """ids (l,), position_m (l, 2)."""

    ids: IntArray
    position_m: FloatArray


@dataclass(frozen=True)
class Reference:
    """What a run is compared with. Each part may be absent."""

    description: ReferenceDescription
    truth: PoseSeries | None = None
    fixes: Fixes | None = None
    landmarks: SurveyedLandmarks | None = None
    surface: TrueSurface | None = None

    @property
    def is_empty(self) -> bool:
        return self.truth is None and self.fixes is None and self.landmarks is None and self.surface is None


@dataclass(frozen=True)
class Mission:
    """A planar vehicle has odometry; an underwater one may have navigation instead, or the frames of a camera alone. `recording` writes the
    sonar logs of a mission that is not on disk yet into the folder it is given; `photographs` the pictures of its frames. `keypoints`:
    what was found in the frames, which no file holds."""

    name: str
    odometry: Odometry | None = None
    description: str = ""
    notes: str = ""
    observations: Observations | None = None
    scans: Scans | None = None
    sonar_hits: SonarHits | None = None
    points: BodyPoints | None = None
    sonar_logs: Sequence[Path] = ()
    recording: Callable[[Path], None] | None = None
    frames: FrameIndex | None = None
    photographs: Callable[[Path], None] | None = None
    keypoints: FrameKeypoints | None = None
    navigation: UnderwaterNavigation | None = None
    settings: Mapping[str, Any] = field(default_factory=dict)
    reference: Reference = field(default_factory=lambda: Reference(ReferenceDescription()))
    geodetic: Geodetic | None = None
    import_record: ImportRecord | None = None

    @property
    def has_observations(self) -> bool:
        return any(records is not None for records in (self.observations, self.scans, self.sonar_hits, self.points, self.frames))

    @property
    def has_frames_alone(self) -> bool:
        """A camera, and nothing that tells of the vehicle's motion but its pictures."""
        return self.frames is not None and self.odometry is None and self.navigation is None

    @property
    def time_s(self) -> FloatArray:
        """Of the records that span the mission: the odometry, the attitude of an underwater vehicle, or the frames of a camera alone."""
        if self.odometry is not None:
            return self.odometry.time_s
        if self.navigation is not None:
            return self.navigation.attitude.time_s
        if self.frames is not None:
            return self.frames.time_s
        raise UserError(f"mission '{self.name}': holds neither odometry nor navigation; give one of them")


def mission_directory(path: Path) -> Path:
    """The directory of a mission named by itself or by its mission.toml."""
    directory = path.parent if path.name == MISSION_FILE else path
    if not directory.is_dir():
        raise UserError(f"{path}: is no mission directory; name the directory that holds {MISSION_FILE}")
    if not holds_file(directory / MISSION_FILE):
        raise UserError(f"{directory / MISSION_FILE}: is missing; write one with a name in its [mission] table, or use `ssjs-cli import`")
    return directory


why_not_a_mission = holds_only((*MISSION_FILES, PINGS_FOLDER, FRAMES_FOLDER), (MISSION_FILE,))


def is_mission_file(name: str) -> bool:
    """Whether a name of `input_digests` is that of a mission's own file."""
    return name in MISSION_FILES or name.startswith((f"{PINGS_FOLDER}/", f"{FRAMES_FOLDER}/"))


def input_digests(directory: Path) -> dict[str, str]:
    """sha256 of every file of the mission that exists, by its name; of all pictures together."""
    digests = {}
    paths = [directory / name for name in MISSION_FILES if (directory / name).is_file()]
    for path in [*paths, *sonar_logs_in(directory)]:
        digests[path.relative_to(directory).as_posix()] = file_digest(path)
    return {**digests, **frame_digests(directory)}


# --- reading ---------------------------------------------------------------------------------------------------------


def read_mission(path: Path) -> Mission:
    directory = mission_directory(path)
    document = read_mission_document(directory / MISSION_FILE)
    navigation = read_navigation(directory)
    frames = read_frames(directory)
    has_odometry = _has_odometry(directory, navigation, frames)
    if not has_odometry and document.geodetic is not None:
        _require_north_east(document.geodetic, directory / MISSION_FILE)
    if navigation is not None and not has_odometry:
        navigation = replace(navigation, fixes=read_position_fixes(directory, document.geodetic))
    return Mission(
        name=document.mission.name,
        description=document.mission.description,
        notes=document.mission.notes,
        odometry=_read_odometry(directory / ODOMETRY_FILE) if has_odometry else None,
        observations=_read_observations(directory / OBSERVATIONS_FILE) if has_odometry else None,
        points=None if has_odometry else _read_points(directory / OBSERVATIONS_FILE),
        scans=_read_scans(directory / SCANS_FILE),
        sonar_hits=_read_sonar_hits(directory / SONAR_HITS_FILE),
        sonar_logs=() if has_odometry else _read_sonar_logs(directory, document.import_record),
        frames=frames,
        navigation=navigation,
        settings=document.settings,
        reference=read_reference(directory, document.reference),
        geodetic=document.geodetic,
        import_record=document.import_record,
    )


def read_mission_outline(path: Path) -> Mission:
    """What the settings of its run follow from: the description and which sensors there are, none of their records. What is wrong in the
    records is found by who reads them."""
    directory = mission_directory(path)
    document = read_mission_document(directory / MISSION_FILE)
    navigation = outline_navigation(directory)
    frames = outline_frames(directory)
    odometry = None
    if _has_odometry(directory, navigation, frames):
        kind = _odometry_kind(directory / ODOMETRY_FILE, _odometry_header(directory / ODOMETRY_FILE))
        odometry = Odometry(kind, np.zeros((0, len(ODOMETRY_COLUMNS[kind]))))
    elif document.geodetic is not None:
        _require_north_east(document.geodetic, directory / MISSION_FILE)
    return Mission(
        document.mission.name,
        odometry=odometry,
        frames=frames,
        navigation=navigation,
        settings=document.settings,
        geodetic=document.geodetic,
    )


def _has_odometry(directory: Path, navigation: UnderwaterNavigation | None, frames: FrameIndex | None) -> bool:
    """Whether it has, or must have: one without any motion is a mission whose odometry is missing."""
    has_file = holds_file(directory / ODOMETRY_FILE)
    if has_file and frames is not None:
        raise UserError(
            f"{frames.folder}: frames are of an underwater vehicle, and {ODOMETRY_FILE} makes this mission one of a vehicle in the plane; "
            f"remove {ODOMETRY_FILE}, or the folder"
        )
    return has_file or (navigation is None and frames is None)


def holds_frames_alone(directory: Path) -> bool:
    """Whether the files of a mission are those of a camera, and nothing that tells of the vehicle's motion."""
    others = (ODOMETRY_FILE, *NAVIGATION_FILES)
    return (directory / FRAMES_FOLDER).is_dir() and not any(holds_file(directory / name) for name in others)


def is_underwater(directory: Path) -> bool:
    """Whether the files of a mission are those of an underwater vehicle: its own sensors or a camera, and no odometry."""
    if holds_file(directory / ODOMETRY_FILE):
        return False
    return any(holds_file(directory / name) for name in NAVIGATION_FILES) or (directory / FRAMES_FOLDER).is_dir()


def _require_north_east(geodetic: Geodetic, path: Path) -> None:
    if geodetic.heading_deg % 360.0 != 0.0 or geodetic.y_axis != "right":
        raise UserError(
            f'{path}: geodetic.heading_deg = {geodetic.heading_deg:g}, geodetic.y_axis = "{geodetic.y_axis}": the world of an underwater '
            'mission has x to the north and y to the east; set heading_deg = 0.0 and y_axis = "right"'
        )


def _read_sonar_logs(directory: Path, record: ImportRecord | None) -> list[Path]:
    """A survey whose log has gone is not one of dead reckoning."""
    logs = sonar_logs_in(directory)
    folder = directory / PINGS_FOLDER
    expected = folder.is_dir() or (record is not None and f".{record.format}" in SONAR_LOG_SUFFIXES)
    if expected and not logs and not (directory / OBSERVATIONS_FILE).is_file():
        held = ", ".join(sorted(path.name for path in folder.iterdir())[:3]) if folder.is_dir() else ""
        raise UserError(
            f"{folder}: holds no sonar log{f' ({held})' if held else ''}; put it back, its name ending in .xtf or .jsf, "
            "or import the mission again"
        )
    return logs


def sonar_logs_in(directory: Path) -> list[Path]:
    """In the order of their names."""
    folder = directory / PINGS_FOLDER
    if not folder.is_dir():
        if folder.exists() or folder.is_symlink():
            raise UserError(f"{folder}: is no folder; the sonar logs of a mission lie in one of this name")
        return []
    return sorted(path for path in folder.iterdir() if path.suffix.lower() in SONAR_LOG_SUFFIXES and holds_file(path))


def read_mission_document(path: Path) -> MissionDocument:
    document = load_toml(path)
    try:
        return MissionDocument.model_validate(document)
    except ValidationError as error:
        raise UserError("\n".join(_document_faults(error, path))) from error


def _document_faults(error: ValidationError, path: Path) -> list[str]:
    known = [f"{table}.{key}" for table, model in _DOCUMENT_TABLES.items() for key in model.model_fields] + [*_DOCUMENT_TABLES, "settings"]
    faults = []
    for item in error.errors():
        key = ".".join(str(part) for part in item["loc"])
        if item["type"] == "extra_forbidden":
            faults.append(f"{path}: unknown key '{key}'{nearest_hint(key, known)}")
        elif item["type"] == "missing":
            faults.append(f"{path}: key '{key}' is missing; add it")
        else:
            faults.append(f"{path}: {key} = {item['input']!r}: {item['msg']}")
    return faults


_DOCUMENT_TABLES: Mapping[str, type[BaseModel]] = MappingProxyType(
    {"mission": MissionDescription, "geodetic": Geodetic, "reference": ReferenceDescription, "import": ImportRecord}
)


def read_reference(directory: Path, description: ReferenceDescription) -> Reference:
    truth_path = directory / TRUTH_FILE
    return Reference(
        description=description,
        truth=read_tum(truth_path) if holds_file(truth_path) else None,
        fixes=read_fixes(directory / FIXES_FILE) if holds_file(directory / FIXES_FILE) else None,
        landmarks=read_landmarks(directory / LANDMARKS_FILE) if holds_file(directory / LANDMARKS_FILE) else None,
        surface=read_true_surface(directory),
    )


def _odometry_header(path: Path) -> list[str]:
    if not holds_file(path):
        choices = " or ".join(",".join(columns) for columns in ODOMETRY_COLUMNS.values())
        raise UserError(f"{path}: is missing; a mission needs its odometry, with the columns {choices}")
    return read_header(path)


def _read_odometry(path: Path) -> Odometry:
    kind = _odometry_kind(path, _odometry_header(path))
    table = read_table(path, required=ODOMETRY_COLUMNS[kind])
    if table.rows == 0:
        raise UserError(f"{path}: the mission is empty: there is no line after the header; give at least one odometry record")
    require_times_in_order(table)
    if kind == "increments":
        for name in ("sigma_x_m", "sigma_y_m", "sigma_heading_rad"):
            require_positive(table, name)
    return Odometry(kind, table.stacked(ODOMETRY_COLUMNS[kind]))


def _odometry_kind(path: Path, header: list[str]) -> str:
    """The kind whose columns the header resembles most; what is unknown or missing is then reported against it."""
    exact = [kind for kind, columns in ODOMETRY_COLUMNS.items() if set(columns) <= set(header)]
    if len(exact) > 1:
        raise UserError(f"{path}:1: holds the columns of {' and '.join(exact)} odometry; keep the columns of one")
    return exact[0] if exact else max(ODOMETRY_COLUMNS, key=lambda kind: _resemblance(header, ODOMETRY_COLUMNS[kind]))


def _resemblance(header: list[str], columns: tuple[str, ...]) -> float:
    return sum(max(difflib.SequenceMatcher(None, name, column).ratio() for column in columns) for name in header)


def _read_observations(path: Path) -> Observations | None:
    if not holds_file(path):
        return None
    header = read_header(path)
    cartesian = set(CARTESIAN_COLUMNS) <= set(header)
    if set(POINT_COLUMNS) <= set(header):
        raise UserError(
            f"{path}:1: has the column z_m of an underwater mission, and {ODOMETRY_FILE} makes this one of a vehicle in the plane; "
            f"remove {ODOMETRY_FILE} to run with {NAVIGATION_FILES[0]}, or the column z_m"
        )
    place = CARTESIAN_COLUMNS if cartesian else POLAR_COLUMNS
    covariance_columns = () if cartesian else COVARIANCE_COLUMNS
    has_covariance = any(name in header for name in covariance_columns)
    table = read_table(
        path,
        required=("time_s", *place, *(covariance_columns if has_covariance else ())),
        optional=("landmark_id", *covariance_columns),
        may_be_empty=("landmark_id",),
    )
    if table.rows == 0:
        return None
    require_times_in_order(table)
    if cartesian:
        range_m = np.hypot(table["x_m"], table["y_m"])
        bearing_rad = np.arctan2(table["y_m"], table["x_m"])
    else:
        range_m, bearing_rad = table["range_m"], table["bearing_rad"]
        require_positive_range(table)
    covariance = None
    if has_covariance:
        _require_definite_covariance(table)
        covariance = table.stacked(COVARIANCE_COLUMNS)
    return Observations(table["time_s"], range_m, bearing_rad, covariance, landmark_ids(table))


def _read_points(path: Path) -> BodyPoints | None:
    if not holds_file(path):
        return None
    has_covariance = any(name in read_header(path) for name in POINT_COVARIANCE_COLUMNS)
    covariance_columns = POINT_COVARIANCE_COLUMNS if has_covariance else ()
    table = read_table(
        path, required=("time_s", *POINT_COLUMNS, *covariance_columns), optional=("landmark_id",), may_be_empty=("landmark_id",)
    )
    if table.rows == 0:
        return None
    require_times_in_order(table)
    require_plausible(table, ("time_s", *POINT_COLUMNS, *(name for name in covariance_columns if name.startswith("var_"))))
    covariance_m2 = table.stacked(POINT_COVARIANCE_COLUMNS) if has_covariance else None
    if covariance_m2 is not None:
        indefinite = np.linalg.eigvalsh(covariance_m2[:, [0, 1, 2, 1, 3, 4, 2, 4, 5]].reshape(-1, 3, 3))[:, 0] <= 0.0
        if indefinite.any():
            raise UserError(f"{table.where(int(np.argmax(indefinite)))}: the covariance of the point is not positive definite; correct it")
    return BodyPoints(table["time_s"], table.stacked(POINT_COLUMNS), landmark_ids(table), covariance_m2)


def _require_definite_covariance(table: NumberTable) -> None:
    require_positive(table, "var_range_m2")
    require_positive(table, "var_bearing_rad2")
    determinant = table["var_range_m2"] * table["var_bearing_rad2"] - table["cov_range_bearing"] ** 2
    if (determinant <= 0.0).any():
        row = int(np.argmax(determinant <= 0.0))
        raise UserError(f"{table.where(row)}: cov_range_bearing is too large for its variances; the covariance must be positive definite")


def landmark_ids(table: NumberTable) -> IntArray | None:
    """Empty fields become UNKNOWN_LANDMARK; a column without any identity is none."""
    if "landmark_id" not in table:
        return None
    empty = np.isnan(table["landmark_id"])
    if empty.all():
        return None
    negative = table["landmark_id"] < 0.0
    if negative.any():
        row = int(np.argmax(negative))
        raise UserError(f"{table.where(row)}: landmark_id must not be negative; leave it empty where the landmark is unknown")
    columns = {"landmark_id": np.where(empty, UNKNOWN_LANDMARK, table["landmark_id"])}
    return whole_numbers(NumberTable(table.path, columns, table.rows), "landmark_id")


def _read_scans(path: Path) -> Scans | None:
    if not holds_file(path):
        return None
    try:
        check_archive_size(path, MAX_SCANS_BYTES)
        with np.load(path, allow_pickle=False) as archive:
            missing = [name for name in SCAN_ARRAYS if name not in archive.files]
            if missing:
                raise UserError(f"{path}: the array {', '.join(missing)} is missing; it needs {', '.join(SCAN_ARRAYS)}")
            arrays = {name: np.asarray(archive[name]) for name in SCAN_ARRAYS}
    except (zipfile.BadZipFile, ValueError, EOFError, OSError) as error:
        if isinstance(error, OSError) and error.errno is not None:
            raise
        raise UserError(f"{path}: is damaged or no scan archive ({error}); import the mission again") from error
    return _checked_scans(path, arrays)


def _checked_scans(path: Path, arrays: Mapping[str, Any]) -> Scans | None:
    for name, array in arrays.items():
        if array.dtype.kind not in "fiu":
            raise UserError(f"{path}: {name} holds {array.dtype}, not numbers; import the mission again")
    time_s = np.ascontiguousarray(arrays["time_s"], dtype=np.float64)
    range_m = np.ascontiguousarray(arrays["range_m"], dtype=np.float64)
    if time_s.ndim != 1 or range_m.ndim != 2 or len(range_m) != len(time_s) or range_m.shape[1] == 0:
        raise UserError(f"{path}: time_s {time_s.shape} and range_m {range_m.shape} must be (n,) and (n, beams); import the mission again")
    for name in ("first_angle_rad", "step_rad"):
        if arrays[name].size != 1 or not math.isfinite(float(arrays[name].reshape(-1)[0])):
            raise UserError(f"{path}: {name} must be one finite number; import the mission again")
    for name, array in (("time_s", time_s), ("range_m", range_m)):
        bad = ~np.isfinite(array) if array.ndim == 1 else np.isnan(array).any(axis=1)
        if bad.any():
            scan = int(np.argmax(bad))
            raise UserError(f"{path}: {name} of scan {scan} is not a number; write no return as infinity")
    backwards = np.diff(time_s) < 0.0
    if backwards.any():
        scan = int(np.argmax(backwards)) + 1
        before, after = float(time_s[scan - 1]), float(time_s[scan])
        raise UserError(f"{path}: time_s of scan {scan} goes back from {before!r} to {after!r}; sort the scans")
    if len(time_s) == 0:
        return None
    return Scans(time_s, range_m, float(arrays["first_angle_rad"].reshape(-1)[0]), float(arrays["step_rad"].reshape(-1)[0]))


def _read_sonar_hits(path: Path) -> SonarHits | None:
    if not holds_file(path):
        return None
    table = read_table(path, required=("time_s", *POLAR_COLUMNS), optional=("intensity",))
    if table.rows == 0:
        return None
    require_times_in_order(table)
    require_positive_range(table)
    return SonarHits(table["time_s"], table["range_m"], table["bearing_rad"], table.columns.get("intensity"))


def read_fixes(path: Path) -> Fixes:
    table = read_table(path, required=("time_s", "x_m", "y_m"), optional=("sigma_m",))
    require_times_in_order(table)
    if "sigma_m" in table:
        require_positive(table, "sigma_m")
    if table.rows == 0:
        raise UserError(f"{path}: holds no fix; give at least one line after the header, or remove the file")
    return Fixes(table["time_s"], table.stacked(("x_m", "y_m")), table.columns.get("sigma_m"))


def read_landmarks(path: Path) -> SurveyedLandmarks:
    table = read_table(path, required=("id", "x_m", "y_m"), optional=("z_m",))
    ids = whole_numbers(table, "id")
    unique, counts = np.unique(ids, return_counts=True)
    if (counts > 1).any():
        repeated = int(unique[np.argmax(counts > 1)])
        row = int(np.flatnonzero(ids == repeated)[1])
        raise UserError(f"{table.where(row)}: landmark {repeated} appears twice; give each landmark one line")
    return SurveyedLandmarks(ids, table.stacked(("x_m", "y_m")))


# --- writing ---------------------------------------------------------------------------------------------------------


def write_mission(directory: Path, mission: Mission) -> None:
    """Fills an existing directory. The same mission gives the same bytes."""
    document: dict[str, Any] = {"mission": {"name": mission.name, "description": mission.description}}
    if mission.notes:
        document["mission"]["notes"] = mission.notes
    if mission.geodetic is not None:
        document["geodetic"] = mission.geodetic.model_dump(exclude_none=True)
    document["settings"] = dict(mission.settings)
    if not mission.reference.is_empty:
        document["reference"] = mission.reference.description.model_dump(exclude_none=True)
    if mission.import_record is not None:
        document["import"] = mission.import_record.model_dump()
    (directory / MISSION_FILE).write_text(tomli_w.dumps(document), encoding="utf-8")

    if mission.odometry is not None:
        columns = ODOMETRY_COLUMNS[mission.odometry.kind]
        write_table(directory / ODOMETRY_FILE, ",".join(columns), list(mission.odometry.values.T), [EXACT] * len(columns))
    if mission.navigation is not None:
        write_navigation(directory, mission.navigation)
    if mission.observations is not None:
        _write_observations(directory / OBSERVATIONS_FILE, mission.observations)
    if mission.points is not None:
        _write_points(directory / OBSERVATIONS_FILE, mission.points)
    if mission.scans is not None:
        _write_scans(directory / SCANS_FILE, mission.scans)
    if mission.sonar_hits is not None:
        _write_sonar_hits(directory / SONAR_HITS_FILE, mission.sonar_hits)
    if mission.recording is not None:
        (directory / PINGS_FOLDER).mkdir()
        mission.recording(directory / PINGS_FOLDER)
    if mission.frames is not None:
        _write_frames(directory / FRAMES_FOLDER, mission.frames)
    if mission.photographs is not None:
        mission.photographs(directory / FRAMES_FOLDER)
    _write_reference(directory, mission.reference)


def _write_observations(path: Path, observations: Observations) -> None:
    names = ["time_s", *POLAR_COLUMNS]
    columns: list[FloatArray | IntArray] = [observations.time_s, observations.range_m, observations.bearing_rad]
    formats = [EXACT] * 3
    if observations.landmark_id is not None:
        names.append("landmark_id")
        known = observations.landmark_id != UNKNOWN_LANDMARK
        columns.append(observations.landmark_id if known.all() else np.where(known, observations.landmark_id.astype(str), ""))
        formats.append(WHOLE if known.all() else TEXT)
    if observations.covariance is not None:
        names += COVARIANCE_COLUMNS
        columns += list(observations.covariance.T)
        formats += [EXACT] * 3
    write_table(path, ",".join(names), columns, formats)


def _write_points(path: Path, points: BodyPoints) -> None:
    names = ["time_s", *POINT_COLUMNS]
    columns: list[FloatArray | IntArray] = [points.time_s, *points.position_m.T]
    formats = [EXACT] * 4
    if points.covariance_m2 is not None:
        names += POINT_COVARIANCE_COLUMNS
        columns += list(points.covariance_m2.T)
        formats += [EXACT] * 6
    if points.landmark_id is not None:
        names.append("landmark_id")
        columns.append(_shown_ids(points.landmark_id))
        formats.append(TEXT)
    write_table(path, ",".join(names), columns, formats)


def _shown_ids(ids: IntArray) -> Any:
    """Text, empty where the landmark is not known."""
    return np.where(ids != UNKNOWN_LANDMARK, ids.astype(str), "")


def _write_frames(folder: Path, frames: FrameIndex) -> None:
    folder.mkdir()
    (folder / FRAME_INDEX_FILE).write_text(index_text(frames.time_s, frames.files), encoding="utf-8")
    if frames.calibration is not None:
        (folder / CALIBRATION_FILE).write_text(calibration_text(frames.calibration), encoding="utf-8")


def _write_scans(path: Path, scans: Scans) -> None:
    np.savez_compressed(
        path,
        time_s=scans.time_s,
        range_m=scans.range_m,
        first_angle_rad=np.float64(scans.first_angle_rad),
        step_rad=np.float64(scans.step_rad),
    )


def _write_sonar_hits(path: Path, hits: SonarHits) -> None:
    names, columns = ["time_s", *POLAR_COLUMNS], [hits.time_s, hits.range_m, hits.bearing_rad]
    if hits.intensity is not None:
        names.append("intensity")
        columns.append(hits.intensity)
    write_table(path, ",".join(names), columns, [EXACT] * len(columns))


def _write_reference(directory: Path, reference: Reference) -> None:
    if reference.truth is not None:
        write_tum(directory / TRUTH_FILE, reference.truth)
    if reference.fixes is not None:
        fixes = reference.fixes
        names, columns = ["time_s", "x_m", "y_m"], [fixes.time_s, fixes.position_m[:, 0], fixes.position_m[:, 1]]
        if fixes.sigma_m is not None:
            names.append("sigma_m")
            columns.append(fixes.sigma_m)
        write_table(directory / FIXES_FILE, ",".join(names), columns, [EXACT] * len(columns))
    if reference.landmarks is not None:
        landmarks = reference.landmarks
        write_table(
            directory / LANDMARKS_FILE,
            "id,x_m,y_m",
            [landmarks.ids, landmarks.position_m[:, 0], landmarks.position_m[:, 1]],
            [WHOLE, EXACT, EXACT],
        )
    if reference.surface is not None:
        write_true_surface(directory, reference.surface)
