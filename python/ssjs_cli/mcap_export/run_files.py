"""The files of a run as the messages need them: with the very numbers that they hold."""

import csv
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ssjs_cli.errors import UserError
from ssjs_cli.formats.contact_table import COLUMNS
from ssjs_cli.formats.number_table import FloatArray, NumberTable, read_columns, read_header, read_table, require_times_in_order
from ssjs_cli.formats.run_directory import (
    CONSISTENCY_FILE,
    CONTACTS_FILE,
    COVARIANCE_FILE,
    COVARIANCE_NAMES,
    DEAD_RECKONING_FILE,
    LANDMARK_NAMES,
    LANDMARKS_FILE,
    ONLINE_FILE,
    PASSES_NAMES,
    SPACE_COVARIANCE_NAMES,
    SUBMAPS_FILE,
    SUMMARY_FILE,
    TRAJECTORY_FILE,
    read_json,
)
from ssjs_cli.formats.tum import TUM_COLUMNS
from ssjs_cli.mcap_export.schemas import CONTACT, TEXT, WHOLE_NUMBER

RUN_AGAIN = "run the mission again"
PLANE_3X3 = ("var_xx", "cov_xy", None, "cov_xy", "var_yy", None, None, None, None)
SPACE_3X3 = ("var_xx", "cov_xy", "cov_xz", "cov_xy", "var_yy", "cov_yz", "cov_xz", "cov_yz", "var_zz")


@dataclass(frozen=True)
class Track:
    """time_s (n,); position_m (n, 3) and orientation (n, 4) x y z w, frame world"""

    time_s: FloatArray
    position_m: FloatArray
    orientation: FloatArray


@dataclass(frozen=True)
class RunFiles:
    """covariance_m2 (n, 3, 3) of the corrected positions, heading_variance (n,); nis: time_s, nis, dof; landmarks as in landmarks.csv;
    base_m: x, y of each submap's base; contacts: the filled fields of each row of contacts.csv, none where the run has no such file."""

    summary: dict[str, Any]
    under_water: bool
    corrected: Track
    online: Track
    dead_reckoning: Track
    covariance_m2: FloatArray
    heading_variance: FloatArray
    nis: NumberTable
    landmarks: NumberTable
    base_m: dict[int, tuple[float, float]]
    loops: list[dict[str, Any]]
    contacts: list[dict[str, str | int | float]]


def read_run_files(directory: Path) -> RunFiles:
    corrected = _read_track(directory / TRAJECTORY_FILE)
    covariance = _read_covariance(directory / COVARIANCE_FILE, len(corrected.time_s))
    nis = read_table(directory / CONSISTENCY_FILE, required=("time_s", "nis", "dof"))
    require_times_in_order(nis)
    submaps = read_json(directory / SUBMAPS_FILE)
    online, dead_reckoning = (_read_track(directory / name, len(corrected.time_s)) for name in (ONLINE_FILE, DEAD_RECKONING_FILE))
    return RunFiles(
        summary=read_json(directory / SUMMARY_FILE),
        under_water="var_zz" in covariance,
        corrected=corrected,
        online=online,
        dead_reckoning=dead_reckoning,
        covariance_m2=position_covariance(covariance),
        heading_variance=covariance["var_hh"],
        nis=nis,
        landmarks=read_table(directory / LANDMARKS_FILE, required=LANDMARK_NAMES, optional=PASSES_NAMES),
        base_m=_base_places(directory, submaps),
        loops=_records(directory, submaps, "loops", numbers=("time_s", "from", "to", "pairs"), others=("accepted", "reason")),
        contacts=_read_contacts(directory / CONTACTS_FILE),
    )


def position_covariance(table: NumberTable) -> FloatArray:
    """(rows, 3, 3) of x, y, z; a planar one has zeros for z."""
    names = SPACE_3X3 if "var_zz" in table else PLANE_3X3
    columns = [np.zeros(table.rows) if name is None else table[name] for name in names]
    return np.column_stack(columns).reshape(-1, 3, 3)


def _read_track(path: Path, rows: int | None = None) -> Track:
    table = read_columns(path, TUM_COLUMNS)
    if table.rows == 0:
        raise UserError(f"{path}: holds no pose; {RUN_AGAIN}")
    _require_rows(table, rows)
    require_times_in_order(table)
    return Track(table["time_s"], table.stacked(("x_m", "y_m", "z_m")), table.stacked(("qx", "qy", "qz", "qw")))


def _read_covariance(path: Path, rows: int) -> NumberTable:
    in_space = path.is_file() and "var_zz" in read_header(path)
    table = read_table(path, required=SPACE_COVARIANCE_NAMES if in_space else COVARIANCE_NAMES)
    _require_rows(table, rows)
    return table


def _require_rows(table: NumberTable, rows: int | None) -> None:
    if rows is not None and table.rows != rows:
        raise UserError(f"{table.path}: has {table.rows} rows where the trajectory has {rows}; {RUN_AGAIN}")


def _base_places(directory: Path, document: dict[str, Any]) -> dict[int, tuple[float, float]]:
    places = {}
    for submap in _records(directory, document, "submaps", numbers=("index",), others=("base_pose",)):
        base = submap["base_pose"]
        if not isinstance(base, list) or len(base) != 3 or not all(isinstance(value, int | float) for value in base):
            raise UserError(f"{directory / SUBMAPS_FILE}: base_pose of submap {submap['index']} must be x, y, heading; {RUN_AGAIN}")
        places[int(submap["index"])] = (float(base[0]), float(base[1]))
    return places


def _records(
    directory: Path, document: dict[str, Any], name: str, *, numbers: tuple[str, ...], others: tuple[str, ...]
) -> list[dict[str, Any]]:
    records = document.get(name)
    usable = isinstance(records, list) and all(
        isinstance(record, dict) and set(others) <= set(record) and all(isinstance(record.get(key), int | float) for key in numbers)
        for record in records
    )
    if not isinstance(records, list) or not usable:
        raise UserError(f"{directory / SUBMAPS_FILE}: {name} must be a list of objects with {', '.join((*numbers, *others))}; {RUN_AGAIN}")
    return records


def _read_contacts(path: Path) -> list[dict[str, str | int | float]]:
    if not path.is_file():
        return []
    contacts = []
    with path.open(encoding="utf-8", newline="") as file:
        reader = csv.DictReader(file)
        for row in reader:
            try:
                contacts.append({name: _contact_value(name, row[name]) for name in COLUMNS if row.get(name)})
            except ValueError as error:
                raise UserError(f"{path}:{reader.line_num}: {error}; {RUN_AGAIN}") from error
    return contacts


def _contact_value(name: str, text: str) -> str | int | float:
    kind = CONTACT["properties"][name]
    if kind is WHOLE_NUMBER:
        return int(text)
    if kind is TEXT:
        return text
    number = float(text)
    if not math.isfinite(number):
        raise ValueError(f"{name} = '{text}' is not finite")
    return number
