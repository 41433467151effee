"""The files of a run directory as arrays. Only summary.json must exist; every other file may be absent and is then None."""

from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from ssjs_cli.errors import UserError
from ssjs_cli.formats.number_table import FloatArray, IntArray, read_header, read_table
from ssjs_cli.formats.toml_file import load_toml
from ssjs_cli.formats.tum import read_tum
from ssjs_cli.report.frame_files import FramePictures, read_frame_pictures
from ssjs_cli.report.json_object import RUN_AGAIN, read_json_object
from ssjs_cli.report.number_text import finite_number
from ssjs_cli.report.survey_files import SurveyFiles, read_survey_files

#: A mission whose first time is beyond this (about 12 days) carries the time of a calendar clock, unreadable on an axis.
CLOCK_TIME_S = 1e6
TIME_KEYS = ("time_s", "start_time_s", "end_time_s")


@dataclass(frozen=True)
class Track:
    """time_s (n,); position (n, 2) x, y in metres; heading (n,) rad; frame global. depth (n,) in metres, of a vehicle under water."""

    time_s: FloatArray
    position: FloatArray
    heading: FloatArray
    depth: FloatArray | None = None


@dataclass(frozen=True)
class PositionCovariance:
    """time_s (n,); covariance (n, 3) of the position as xx, xy, yy in m^2; frame global."""

    time_s: FloatArray
    covariance: FloatArray


@dataclass(frozen=True)
class Landmarks:
    """id: number as text, empty where the landmark has none; position (l, 2) m; covariance (l, 3) xx, xy, yy m^2;
    times_seen (l,); submap (l,), -1 when empty; depth (l,) m, 0 in the plane. Frame global."""

    id: list[str]
    position: FloatArray
    covariance: FloatArray
    times_seen: IntArray
    submap: IntArray
    depth: FloatArray


@dataclass(frozen=True)
class Submaps:
    """submaps.json: one dictionary per submap, live map and tested loop."""

    submaps: list[dict[str, Any]]
    live_maps: list[dict[str, Any]]
    loops: list[dict[str, Any]]


Columns = dict[str, FloatArray]


@dataclass(frozen=True)
class RunFiles:
    """time_origin_s: what was taken off every time; 0 unless the mission's clock starts far from 0, as a calendar clock does."""

    time_origin_s: float
    summary: dict[str, Any]
    timing: dict[str, Any] | None
    config: dict[str, Any] | None
    trajectory: Track | None
    trajectory_covariance: PositionCovariance | None
    online: Track | None
    online_covariance: PositionCovariance | None
    dead_reckoning: Track | None
    trajectory_submaps: Columns | None
    landmarks: Landmarks | None
    submaps: Submaps | None
    reference: Columns | None
    errors: Columns | None
    errors_online: Columns | None
    nees: Columns | None
    nis: Columns | None
    step_times: Columns | None
    survey: SurveyFiles
    pictures: FramePictures | None = None

    @property
    def shows_contacts(self) -> bool:
        """What a camera alone sees are landmarks; the contacts of a sonar are things."""
        return self.pictures is None or self.survey.sightings is not None


ERROR_COLUMNS = ("time_s", "error_m", "is_outlier", "error_x_m", "error_y_m", "sigma_x_m", "sigma_y_m", "sigma_major_m")


def read_run_files(run_dir: Path) -> RunFiles:
    summary = read_json_object(run_dir / "summary.json")
    if summary is None:
        raise UserError(f"{run_dir}: holds no summary.json; name the directory of a finished run")
    files = RunFiles(
        time_origin_s=0.0,
        summary=summary,
        timing=read_json_object(run_dir / "timing.json"),
        config=_read_toml(run_dir / "config.toml"),
        trajectory=_read_track(run_dir / "trajectory.tum"),
        trajectory_covariance=_read_covariance(run_dir / "trajectory_covariance.csv"),
        online=_read_track(run_dir / "trajectory_online.tum"),
        online_covariance=_read_covariance(run_dir / "trajectory_online_covariance.csv"),
        dead_reckoning=_read_track(run_dir / "dead_reckoning.tum"),
        trajectory_submaps=_read_columns(run_dir / "trajectory_submaps.csv", ("time_s", "submap")),
        landmarks=_read_landmarks(run_dir / "landmarks.csv"),
        submaps=_read_submaps(run_dir / "submaps.json"),
        reference=_read_columns(run_dir / "reference.csv", ("time_s", "x_m", "y_m")),
        errors=_read_columns(run_dir / "errors.csv", ERROR_COLUMNS, ERROR_COLUMNS[1:]),
        errors_online=_read_columns(run_dir / "errors_online.csv", ERROR_COLUMNS, ERROR_COLUMNS[1:]),
        nees=_read_columns(run_dir / "nees.csv", ("time_s", "nees", "dof"), ("nees", "dof")),
        nis=_read_columns(run_dir / "consistency.csv", ("time_s", "nis", "dof"), ("nis", "dof")),
        step_times=_read_columns(run_dir / "step_times.csv", ("time_s", "step_time_us"), ("step_time_us",)),
        survey=read_survey_files(run_dir),
        pictures=read_frame_pictures(run_dir),
    )
    track = files.trajectory if files.trajectory is not None else files.online
    if track is None or abs(float(track.time_s[0])) < CLOCK_TIME_S:
        return files
    return _counted_from(files, float(track.time_s[0]))


def _counted_from(files: RunFiles, origin_s: float) -> RunFiles:
    """The same results with every time counted from origin_s."""
    earlier: dict[str, Any] = {"time_origin_s": origin_s}
    for field in fields(files):
        part = getattr(files, field.name)
        if isinstance(part, SurveyFiles):
            earlier[field.name] = part.counted_from(origin_s)
        elif isinstance(part, Track | PositionCovariance):
            earlier[field.name] = replace(part, time_s=part.time_s - origin_s)
        elif isinstance(part, Submaps):
            earlier[field.name] = Submaps(
                [_entry_counted_from(entry, origin_s) for entry in part.submaps],
                part.live_maps,
                [_entry_counted_from(entry, origin_s) for entry in part.loops],
            )
        elif isinstance(part, dict) and "time_s" in part and isinstance(part["time_s"], np.ndarray):
            earlier[field.name] = {**part, "time_s": part["time_s"] - origin_s}
    return replace(files, **earlier)


def _entry_counted_from(entry: dict[str, Any], origin_s: float) -> dict[str, Any]:
    times = {key: entry[key] - origin_s for key in TIME_KEYS if isinstance(entry.get(key), int | float)}
    return {**entry, **times}


def _read_toml(path: Path) -> dict[str, Any] | None:
    return load_toml(path) if path.is_file() else None


def _read_submaps(path: Path) -> Submaps | None:
    document = read_json_object(path)
    if document is None:
        return None
    parts: dict[str, list[dict[str, Any]]] = {}
    for key in ("submaps", "live_maps", "loops"):
        part = document.get(key, [])
        if not isinstance(part, list) or not all(isinstance(entry, dict) for entry in part):
            raise UserError(f"{path}: {key} must be a list of objects; {RUN_AGAIN}")
        parts[key] = part
    for position, entry in enumerate(parts["submaps"]):
        pose = entry.get("base_pose")
        usable = isinstance(pose, list) and len(pose) >= 3 and all(finite_number(value) is not None for value in pose[:3])
        if not isinstance(entry.get("index"), int) or not usable:
            raise UserError(f"{path}: submaps[{position}] needs a whole number as index and base_pose x, y, heading; {RUN_AGAIN}")
    return Submaps(submaps=parts["submaps"], live_maps=parts["live_maps"], loops=parts["loops"])


def _read_columns(path: Path, names: tuple[str, ...], may_be_empty: tuple[str, ...] = ()) -> Columns | None:
    """Columns by name; empty values are NaN."""
    if not path.is_file():
        return None
    table = read_table(path, required=names, may_be_empty=may_be_empty, other_columns_allowed=True)
    return {name: table[name] for name in names}


def _read_track(path: Path) -> Track | None:
    if not path.is_file():
        return None
    series = read_tum(path)
    depth = None if series.space is None else series.space[:, 0]
    return Track(time_s=series.time_s, position=series.pose[:, :2], heading=series.pose[:, 2], depth=depth)


def _read_covariance(path: Path) -> PositionCovariance | None:
    """time_s and the row-major upper triangle: 6 values in the plane (x, y, heading), 21 in space; yy is the first of the second row."""
    if not path.is_file():
        return None
    names = read_header(path)
    yy_column = {7: 4, 22: 7}.get(len(names))
    if yy_column is None:
        raise UserError(f"{path}:1: has {len(names)} columns; it needs a time and the 6 values (plane) or 21 (space) of a covariance")
    table = read_table(path, required=names)
    return PositionCovariance(time_s=table[names[0]], covariance=table.stacked([names[1], names[2], names[yy_column]]))


def _read_landmarks(path: Path) -> Landmarks | None:
    names = ("id", "x_m", "y_m", "z_m", "var_xx", "cov_xy", "var_yy", "times_seen", "submap")
    if not path.is_file():
        return None
    table = read_table(path, required=names, may_be_empty=("id", "times_seen", "submap"), other_columns_allowed=True)
    return Landmarks(
        id=["" if np.isnan(number) else f"{number:.0f}" for number in table["id"]],
        position=table.stacked(("x_m", "y_m")),
        covariance=table.stacked(("var_xx", "cov_xy", "var_yy")),
        times_seen=np.nan_to_num(table["times_seen"]).astype(np.int64),
        submap=np.nan_to_num(table["submap"], nan=-1.0).astype(np.int64),
        depth=table["z_m"],
    )
