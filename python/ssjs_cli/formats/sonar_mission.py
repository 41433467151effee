"""A side-scan log as a mission directory: the log itself under pings/, what the vehicle measured of itself as one CSV a sensor.

Global frame: x north, y east, from the first position of the log. A sensor's own records are taken where the log has them, the fields
of the pings otherwise.
"""

import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from ssjs_cli.errors import UserError
from ssjs_cli.formats.file_digest import file_digest
from ssjs_cli.formats.mission import MISSION_FILE, PINGS_FOLDER, Geodetic, ImportRecord
from ssjs_cli.formats.navigation import Attitude, BottomVelocity, Scalars, UnderwaterNavigation, write_navigation
from ssjs_cli.formats.number_table import EXACT, TEXT, WHOLE, FloatArray, write_table
from ssjs_cli.formats.tum import wrapped_angle
from ssjs_cli.sonar.info import describe_problem
from ssjs_cli.sonar.log_blocks import blocks, open_log

PING_TABLE = "navigation.csv"
TABLES = ("pings", "positions", "attitudes", "velocities", "depths", "altitudes")
PING_COLUMNS = ("heading_rad", "roll_rad", "pitch_rad", "speed_m_s", "depth_m", "altitude_m")

Columns = Mapping[str, Any]


@dataclass(frozen=True)
class SonarMission:
    name: str
    log: Path
    navigation: UnderwaterNavigation
    pings: Columns
    origin: Geodetic | None
    decisions: Mapping[str, Mapping[str, int]]
    import_record: ImportRecord


def read_sonar_mission(path: Path, kind: str) -> SonarMission:
    """kind: "xtf" or "jsf"; a log of the other is refused, lest a slip goes unseen."""
    log = open_log(path)
    parts: dict[str, list[Columns]] = {name: [] for name in TABLES}
    for block in blocks(log):
        for name in TABLES:
            parts[name].append(block[name])
    info = log.info()
    if info["format"] != kind:
        raise UserError(f"{path}: is a log in {info['format'].upper()}; use `ssjs-cli import {info['format']}`")
    if not info["pings"]:
        raise UserError(f"{path}: holds no side-scan ping; check that it is the right file")
    tables = {name: {column: np.concatenate([part[column] for part in parts[name]]) for column in parts[name][0]} for name in TABLES}
    lost = [describe_problem(problem) for problem in info["problems"] if problem["data_lost"]]
    navigation = _navigation(path, tables, lost)
    pings = _in_order(tables["pings"], "pings", lost)
    counts = {name: len(tables[name]["time_s"]) for name in TABLES if len(tables[name]["time_s"])}
    counts["repeated_positions"] = info["repeated_positions"]
    return SonarMission(
        name=path.stem,
        log=path,
        navigation=navigation,
        pings=pings,
        origin=_origin(pings),
        decisions=info["decisions"],
        import_record=ImportRecord(format=kind, counts=counts, lost=lost, digests={path.name: file_digest(path)}),
    )


def write_sonar_mission(directory: Path, mission: SonarMission) -> None:
    """Fills an existing directory. The same log gives the same bytes."""
    choices = "; ".join(
        f"{name.replace('_', ' ')}: {', '.join(f'{choice} ({count})' for choice, count in sorted(counts.items()))}"
        for name, counts in mission.decisions.items()
    )
    document: dict[str, Any] = {
        "mission": {"name": mission.name, "description": f"side-scan log {mission.log.name}", "notes": choices},
    }
    if mission.origin is not None:
        document["geodetic"] = mission.origin.model_dump(exclude_none=True)
    document["import"] = mission.import_record.model_dump()
    (directory / MISSION_FILE).write_text(tomli_w.dumps(document), encoding="utf-8")
    write_navigation(directory, mission.navigation)
    (directory / PINGS_FOLDER).mkdir()
    shutil.copyfile(mission.log, directory / PINGS_FOLDER / mission.log.name)
    _write_pings(directory / PINGS_FOLDER / PING_TABLE, mission.pings)


def _navigation(path: Path, tables: Mapping[str, Columns], lost: list[str]) -> UnderwaterNavigation:
    angles = ("roll_rad", "pitch_rad", "heading_rad")
    attitude = _first_known([("attitudes", tables["attitudes"]), ("pings", tables["pings"])], angles, lost)
    if attitude is None:
        raise UserError(f"{path}: holds no ping with heading, roll and pitch; a mission needs the attitude of its vehicle")
    velocity = _in_order(tables["velocities"], "velocities", lost)
    depth = _first_known([("depths", tables["depths"]), ("pings", tables["pings"])], ("depth_m",), lost)
    altitude = _first_known([("altitudes", tables["altitudes"]), ("pings", tables["pings"])], ("altitude_m",), lost)
    return UnderwaterNavigation(
        attitude=Attitude(
            attitude["time_s"], np.column_stack([attitude["roll_rad"], attitude["pitch_rad"], wrapped_angle(attitude["heading_rad"])])
        ),
        velocity=_velocity(velocity) if len(velocity["time_s"]) else None,
        depth=None if depth is None else Scalars(depth["time_s"], depth["depth_m"]),
        altitude=None if altitude is None else Scalars(altitude["time_s"], altitude["altitude_m"]),
    )


def _velocity(table: Columns) -> BottomVelocity:
    """Without a vertical velocity the vehicle is taken to move level."""
    down = np.where(np.isfinite(table["down_m_s"]), table["down_m_s"], 0.0)
    return BottomVelocity(table["time_s"], np.column_stack([table["forward_m_s"], table["starboard_m_s"], down]), table["bottom_lock"])


def _first_known(sources: Sequence[tuple[str, Columns]], names: tuple[str, ...], lost: list[str]) -> Columns | None:
    """The first table with rows in which every one of the columns is known, and those rows."""
    for source, table in sources:
        known = np.isfinite(table["time_s"])
        for name in names:
            known &= np.isfinite(table[name])
        if known.any():
            return _in_order({name: table[name][known] for name in ("time_s", *names)}, f"{', '.join(names)} of {source}", lost)
    return None


def _in_order(table: Columns, what: str, lost: list[str]) -> Columns:
    """Without the rows that have no time or one before that of an earlier row."""
    time_s: FloatArray = table["time_s"]
    known = np.isfinite(time_s)
    latest = np.maximum.accumulate(np.where(known, time_s, -np.inf))
    keep = known & (time_s >= latest)
    if not keep.all():
        lost.append(f"{what}: {int((~keep).sum())} rows without a time, or with one that goes back, dropped")
    return {name: column[keep] for name, column in table.items()}


def _origin(pings: Columns) -> Geodetic | None:
    known = np.flatnonzero(np.isfinite(pings["latitude_deg"]))
    if not len(known):
        return None
    latitude, longitude = pings["latitude_deg"][known[0]], pings["longitude_deg"][known[0]]
    return Geodetic(origin_latitude_deg=float(latitude), origin_longitude_deg=float(longitude), heading_deg=0.0, y_axis="right")


def _write_pings(path: Path, pings: Columns) -> None:
    place = ("latitude_deg", "longitude_deg") if np.isfinite(pings["latitude_deg"]).any() else ("east_m", "north_m")
    names = ("position_time_s", *place, *PING_COLUMNS)
    columns = [pings["time_s"], pings["number"], *(_empty_where_unknown(pings[name]) for name in names)]
    write_table(path, ",".join(("time_s", "ping", *names)), columns, [EXACT, WHOLE, *[TEXT] * len(names)])


def _empty_where_unknown(values: FloatArray) -> Any:
    return np.array([repr(value) if np.isfinite(value) else "" for value in values.tolist()], dtype=object)
