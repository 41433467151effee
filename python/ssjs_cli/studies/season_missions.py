"""What a finished mission brings to the map of its season: landmarks with their joint covariance, the track, and its place on earth."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from ssjs_cli.formats.landmark_covariance import read_landmark_covariance
from ssjs_cli.formats.mission import Geodetic
from ssjs_cli.formats.number_table import FloatArray, IntArray, read_columns, read_table, whole_numbers
from ssjs_cli.formats.run_directory import LANDMARK_NAMES, LANDMARKS_FILE, PASSES_NAMES, SUMMARY_FILE, TRAJECTORY_FILE, read_json
from ssjs_cli.formats.tum import TUM_COLUMNS
from ssjs_cli.report.simplification import simplify_line

#: Of a mission that does not tell: a position fix before the dive, and a compass.
ORIGIN_SIGMA_M = 5.0
HEADING_SIGMA_DEG = 1.0
#: Depths of one mission err together by the tide and the pressure sensor's zero.
DEPTH_SIGMA_M = 1.0
#: A track is drawn, not measured.
MAX_TRACK_POINTS = 60
TRACK_TOLERANCE_M = 0.5


class ApartError(Exception):
    """Why a mission cannot be laid over others."""


@dataclass(frozen=True)
class SeasonMission:
    """name: of its run directory; position_m (n, 3) x, y, depth; covariance (3n, 3n), x, y, depth of each, errors of its frame apart;
    confirmed (n,) whether it is a contact by this mission alone; track_m (t, 2)."""

    name: str
    start_s: float
    origin: Geodetic
    ids: IntArray
    position_m: FloatArray
    covariance_m2: FloatArray
    times_seen: IntArray
    confirmed: Any
    track_m: FloatArray

    @property
    def origin_sigma_m(self) -> float:
        return self.origin.origin_sigma_m or ORIGIN_SIGMA_M

    @property
    def heading_sigma_deg(self) -> float:
        return self.origin.heading_sigma_deg or HEADING_SIGMA_DEG


def read_season_mission(directory: Path) -> SeasonMission:
    """Of a run directory. Raises ApartError where it has no place among others."""
    summary = read_json(directory / SUMMARY_FILE)
    origin = _origin_of(summary)
    table = read_table(directory / LANDMARKS_FILE, required=LANDMARK_NAMES, optional=PASSES_NAMES, other_columns_allowed=True)
    if table.rows == 0:
        raise ApartError("saw no landmark")
    covariance = read_landmark_covariance(directory, table.rows)
    if covariance is None:
        raise ApartError("the joint covariance of its landmarks is not known: more than 300 of them, or a method that does not keep it")
    covariance[2::3, 2::3] += DEPTH_SIGMA_M**2  # (W-1)
    track = read_columns(directory / TRAJECTORY_FILE, TUM_COLUMNS)
    points = np.column_stack([track["x_m"], track["y_m"]])
    return SeasonMission(
        name=directory.name,
        start_s=float(track["time_s"][0]),
        origin=origin,
        ids=whole_numbers(table, "id"),
        position_m=table.stacked(("x_m", "y_m", "z_m")),
        covariance_m2=covariance,
        times_seen=whole_numbers(table, "times_seen"),
        confirmed=table["confirmed"] > 0.0 if "confirmed" in table else np.ones(table.rows, dtype=np.bool_),
        track_m=points[simplify_line(points, MAX_TRACK_POINTS, TRACK_TOLERANCE_M).indices],
    )


def _origin_of(summary: Mapping[str, Any]) -> Geodetic:
    if "geodetic" not in summary:
        raise ApartError("a vehicle in the plane: its landmarks are no contacts of a survey")
    if summary["geodetic"] is None:
        raise ApartError("has no place on earth; give [geodetic] in its mission.toml")
    try:
        return Geodetic.model_validate(summary["geodetic"])
    except ValidationError as error:
        raise ApartError("its place on earth cannot be read; run it again") from error
