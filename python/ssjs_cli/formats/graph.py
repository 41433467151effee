"""A published pose and landmark graph (lines ODOMETRY and LANDMARK) as a mission of increments.

`ODOMETRY i j dx dy dheading v11 v12 v13 v22 v23 v33` (variances, or the information order of TORO: I11 I12 I22 I33 I13 I23),
`LANDMARK pose id x y v11 v12 v22` in the pose's frame. Poses and landmarks share one number space.
Times are the positions of the poses in the chain: 0, 1, 2, ...
"""

import hashlib
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ssjs_cli.errors import UserError
from ssjs_cli.formats.mission import ImportRecord, Mission, Observations, Odometry

# The published reader takes the variance of a sighting as that of its range, and as 10 m^2 times that of its bearing.
SIGHTING_VARIANCE_RATIO_M2 = 10.0
ODOMETRY_FIELDS = 12
LANDMARK_FIELDS = 8


@dataclass(frozen=True)
class _Sighting:
    pose: int
    landmark: int
    x_m: float
    y_m: float
    variance_m2: float
    line: int


def read_graph(source: Path, *, range_sigma_m: float | None = None, bearing_sigma_rad: float | None = None) -> Mission:
    """The given sigmas replace those of the file."""
    if not source.is_file():
        raise UserError(f"{source}: is no file; name the graph file itself")
    text = source.read_text(encoding="utf-8", errors="replace")
    increments: list[list[float]] = []
    chain: dict[int, int] = {}
    sightings: list[_Sighting] = []
    for line, content in enumerate(text.splitlines(), 1):
        fields = content.split()
        if not fields or fields[0].startswith("#"):
            continue
        where = f"{source}:{line}"
        if fields[0] == "ODOMETRY":
            increments.append(_parse_odometry(fields, where, chain, len(increments)))
        elif fields[0] == "LANDMARK":
            sightings.append(_parse_landmark(fields, where, line))
        else:
            raise UserError(f"{where}: '{fields[0]}' is neither ODOMETRY nor LANDMARK; remove the line")
    if not increments:
        raise UserError(f"{source}: the mission is empty: there is no ODOMETRY line; name the graph file itself")
    observations = _observations(source, sightings, chain)
    sensor = _sensor_settings(sightings, range_sigma_m, bearing_sigma_rad)
    if sensor is None and observations is not None:
        observations = _with_own_covariance(observations, sightings, chain)
    return Mission(
        name=graph_name(source),
        description="published graph: odometry increments and sightings of landmarks with known association",
        odometry=Odometry("increments", np.array(increments)),
        observations=observations,
        settings={
            "vehicle": {"kind": "increments"},
            **({"sensor": sensor} if sensor else {}),
            "association": {"method": "known"},
        },
        import_record=ImportRecord(
            format="graph",
            counts={"poses": len(chain), "observations": len(sightings), "landmarks": len({sighting.landmark for sighting in sightings})},
            digests={source.name: hashlib.sha256(source.read_bytes()).hexdigest()},
        ),
    )


def graph_name(source: Path) -> str:
    """victoria_park.txt -> victoria-park-graph"""
    return source.stem.replace("_", "-").removesuffix("-graph") + "-graph"


def _numbers(fields: list[str], where: str, whole: int) -> tuple[list[int], list[float]]:
    """The first `whole` fields after the tag as integers, the rest as numbers."""
    try:
        identities = [int(text) for text in fields[1 : 1 + whole]]
        values = [float(text) for text in fields[1 + whole :]]
    except ValueError as error:
        raise UserError(f"{where}: {error}; correct or remove the line") from error
    if not all(math.isfinite(value) for value in values):
        raise UserError(f"{where}: holds NaN or infinity; every value must be a finite number, so correct or remove the line")
    return identities, values


def _require_fields(fields: list[str], count: int, where: str) -> None:
    if len(fields) != count:
        raise UserError(f"{where}: {fields[0]} has {len(fields)} fields where {count} are needed; complete or remove the line")


def _parse_odometry(fields: list[str], where: str, chain: dict[int, int], position: int) -> list[float]:
    """One row of increment odometry, and the two poses entered into the chain (pose -> position)."""
    _require_fields(fields, ODOMETRY_FIELDS, where)
    (pose, next_pose), values = _numbers(fields, where, 2)
    if not chain:
        chain[pose] = 0
    if chain.get(pose) != position:
        raise UserError(f"{where}: starts at pose {pose}, which is not the last one; the ODOMETRY lines must form one chain in order")
    if next_pose in chain:
        raise UserError(f"{where}: pose {next_pose} exists already; each ODOMETRY line must lead to a new pose")
    chain[next_pose] = position + 1
    dx_m, dy_m, dheading_rad = values[:3]
    return [float(position + 1), dx_m, dy_m, dheading_rad, *_sigmas(values[3:], where)]


def _sigmas(fields: list[float], where: str) -> tuple[float, float, float]:
    """Of x, y, heading. The layout shows by which fields are zero."""
    v0, v1, v2, v3, v4, v5 = fields
    if v0 > 0.0 and v3 > 0.0 and v5 > 0.0 and v1 == v2 == v4 == 0.0:
        return math.sqrt(v0), math.sqrt(v3), math.sqrt(v5)
    if v0 > 0.0 and v2 > 0.0 and v3 > 0.0 and v1 == v4 == v5 == 0.0:
        return 1.0 / math.sqrt(v0), 1.0 / math.sqrt(v2), 1.0 / math.sqrt(v3)
    raise UserError(
        f"{where}: the six noise fields {fields} are no diagonal of positive variances (fields 1, 4, 6) or informations (1, 3, 4); "
        "correct the line"
    )


def _parse_landmark(fields: list[str], where: str, line: int) -> _Sighting:
    _require_fields(fields, LANDMARK_FIELDS, where)
    (pose, landmark), (x_m, y_m, v11, v12, v22) = _numbers(fields, where, 2)
    if not (v11 > 0.0 and v22 > 0.0):
        raise UserError(f"{where}: the noise {v11} {v12} {v22} must be positive; correct the line")
    if v12 != 0.0 or abs(v11 - v22) > 1e-4:
        raise UserError(f"{where}: the noise {v11} {v12} {v22} must be the same in x and y and uncorrelated; correct the line")
    return _Sighting(pose, landmark, x_m, y_m, v11, line)


def _observations(source: Path, sightings: list[_Sighting], chain: dict[int, int]) -> Observations | None:
    for sighting in sightings:
        if sighting.pose not in chain:
            raise UserError(f"{source}:{sighting.line}: pose {sighting.pose} is in no ODOMETRY line; correct or remove the line")
        if sighting.landmark in chain:
            raise UserError(
                f"{source}:{sighting.line}: {sighting.landmark} is a pose, and poses and landmarks share their numbers; correct the line"
            )
    if not sightings:
        return None
    ordered = sorted(sightings, key=lambda sighting: chain[sighting.pose])
    x_m, y_m = np.array([sighting.x_m for sighting in ordered]), np.array([sighting.y_m for sighting in ordered])
    return Observations(
        time_s=np.array([float(chain[sighting.pose]) for sighting in ordered]),
        range_m=np.hypot(x_m, y_m),
        bearing_rad=np.arctan2(y_m, x_m),
        landmark_id=np.array([sighting.landmark for sighting in ordered], dtype=np.int64),
    )


def _sensor_settings(sightings: list[_Sighting], range_sigma_m: float | None, bearing_sigma_rad: float | None) -> dict[str, float] | None:
    """One sigma for all sightings: the given ones, or those of the file where it has the same for all."""
    variances = {sighting.variance_m2 for sighting in sightings}
    if len(variances) > 1 and (range_sigma_m is None) != (bearing_sigma_rad is None):
        raise UserError("--range-sigma-m and --bearing-sigma-rad: the sightings of this graph differ in noise, so give both or neither")
    if len(variances) == 1:
        variance_m2 = variances.pop()
        range_sigma_m = math.sqrt(variance_m2) if range_sigma_m is None else range_sigma_m
        bearing_sigma_rad = math.sqrt(variance_m2 / SIGHTING_VARIANCE_RATIO_M2) if bearing_sigma_rad is None else bearing_sigma_rad
    if range_sigma_m is None or bearing_sigma_rad is None:
        return None
    return {"range_sigma_m": range_sigma_m, "bearing_sigma_rad": bearing_sigma_rad}


def _with_own_covariance(observations: Observations, sightings: list[_Sighting], chain: dict[int, int]) -> Observations:
    ordered = sorted(sightings, key=lambda sighting: chain[sighting.pose])
    variance = np.array([sighting.variance_m2 for sighting in ordered])
    covariance = np.column_stack([variance, np.zeros(len(variance)), variance / SIGHTING_VARIANCE_RATIO_M2])
    return Observations(observations.time_s, observations.range_m, observations.bearing_rad, covariance, observations.landmark_id)
