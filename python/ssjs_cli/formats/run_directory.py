"""A run directory: what one run of the estimator leaves."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssjs_cli.errors import UserError
from ssjs_cli.formats.atomic import holds_only, write_file
from ssjs_cli.formats.g2o import Edge, PoseGraph, Vertex, edge_information, g2o_text
from ssjs_cli.formats.geojson import map_geojson
from ssjs_cli.formats.landmark_covariance import LANDMARK_COVARIANCE_FILE, write_landmark_covariance
from ssjs_cli.formats.mission import Geodetic
from ssjs_cli.formats.number_table import (
    EXACT,
    FIXED,
    SCIENTIFIC,
    WHOLE,
    FloatArray,
    IntArray,
    NumberTable,
    read_table,
    whole_numbers,
    write_table,
)
from ssjs_cli.formats.tum import PoseSeries, read_tum, write_tum

SUMMARY_FILE = "summary.json"
CONFIG_FILE = "config.toml"
TIMING_FILE = "timing.json"
LOG_FILE = "log.jsonl"
MISSION_LINK_FILE = "mission_link.json"
REPORT_FILE = "report.html"
TRAJECTORY_FILE = "trajectory.tum"
ONLINE_FILE = "trajectory_online.tum"
DEAD_RECKONING_FILE = "dead_reckoning.tum"
COVARIANCE_FILE = "trajectory_covariance.csv"
ONLINE_COVARIANCE_FILE = "trajectory_online_covariance.csv"
TRAJECTORY_SUBMAPS_FILE = "trajectory_submaps.csv"
LANDMARKS_FILE = "landmarks.csv"
SUBMAPS_FILE = "submaps.json"
BASES_FILE = "bases.npz"
GRAPH_FILE = "graph.g2o"
MAP_FILE = "map.geojson"
CONSISTENCY_FILE = "consistency.csv"
STEP_TIMES_FILE = "step_times.csv"
ERRORS_FILE = "errors.csv"
ONLINE_ERRORS_FILE = "errors_online.csv"
REFERENCE_FILE = "reference.csv"
NEES_FILE = "nees.csv"
CONTACTS_FILE = "contacts.csv"
CONTACTS_GEOJSON_FILE = "contacts.geojson"
CONTACTS_KML_FILE = "contacts.kml"
CONTACTS_GPKG_FILE = "contacts.gpkg"
ALTITUDE_FILE = "altitude.csv"
SIGHTINGS_FILE = "sightings.csv"
COVERAGE_FILE = "coverage.npz"
FRAMES_FILE = "frames.csv"
SNIPPETS_FOLDER = "snippets"
WATERFALL_FOLDER = "waterfall"
WATERFALL_INDEX_FILE = "waterfall.json"  # in that folder
PICTURES_FOLDER = "pictures"
PICTURES_INDEX_FILE = "pictures.json"  # in that folder
RUN_FILES = (
    SUMMARY_FILE,
    CONFIG_FILE,
    TIMING_FILE,
    LOG_FILE,
    MISSION_LINK_FILE,
    REPORT_FILE,
    TRAJECTORY_FILE,
    ONLINE_FILE,
    DEAD_RECKONING_FILE,
    COVARIANCE_FILE,
    ONLINE_COVARIANCE_FILE,
    TRAJECTORY_SUBMAPS_FILE,
    LANDMARKS_FILE,
    LANDMARK_COVARIANCE_FILE,
    SUBMAPS_FILE,
    BASES_FILE,
    GRAPH_FILE,
    MAP_FILE,
    CONSISTENCY_FILE,
    STEP_TIMES_FILE,
    ERRORS_FILE,
    ONLINE_ERRORS_FILE,
    REFERENCE_FILE,
    NEES_FILE,
    CONTACTS_FILE,
    CONTACTS_GEOJSON_FILE,
    CONTACTS_KML_FILE,
    CONTACTS_GPKG_FILE,
    ALTITUDE_FILE,
    SIGHTINGS_FILE,
    COVERAGE_FILE,
    FRAMES_FILE,
    SNIPPETS_FOLDER,
    WATERFALL_FOLDER,
    PICTURES_FOLDER,
)

COVARIANCE_HEADER = "time_s,var_xx,cov_xy,cov_xh,var_yy,cov_yh,var_hh"
COVARIANCE_NAMES = tuple(COVARIANCE_HEADER.split(","))
# x, y, depth, roll, pitch, heading: an underwater vehicle's.
SPACE_AXES = "xyzrph"
SPACE_COVARIANCE_NAMES = (
    "time_s",
    *(f"{'var' if i == j else 'cov'}_{SPACE_AXES[i]}{SPACE_AXES[j]}" for i in range(6) for j in range(i, 6)),
)
PLANAR_NAMES = ("var_xx", "cov_xy", "cov_xh", "var_yy", "cov_yh", "var_hh")
LANDMARK_HEADER = "id,x_m,y_m,z_m,var_xx,cov_xy,cov_xz,var_yy,cov_yz,var_zz,times_seen,submap"
PASSES_HEADER = "passes_seen,passes_expected,existence,confirmed"  # under water
LANDMARK_NAMES, PASSES_NAMES = tuple(LANDMARK_HEADER.split(",")), tuple(PASSES_HEADER.split(","))
ERROR_HEADER = "time_s,error_m,is_outlier,error_x_m,error_y_m,sigma_x_m,sigma_y_m,sigma_major_m"

MEASURED_KEYS = ("steps", "observations", "landmarks", "submaps", "loop_candidates", "loop_closures", "fusions", "wrong_pairs")
TIME_KEYS = ("time_total_s", "time_local_s", "time_global_s", "time_association_s", "time_smoothing_s", "time_other_s")
STEP_TIME_KEYS = ("step_time_p50_us", "step_time_p99_us", "step_time_max_us")
REFERENCE_KEYS = (
    "trajectory_rmse_m",
    "trajectory_mean_m",
    "trajectory_std_m",
    "trajectory_max_m",
    "final_drift_percent",
    "dead_reckoning_rmse_m",
    "dead_reckoning_final_drift_percent",
    "reference_outliers",
    "map_error_mean_m",
    "map_error_std_m",
    "map_error_max_m",
    "landmarks_missed",
    "landmarks_false",
    "nees_mean",
    "nees_inside_fraction",
    "nees_joint_per_dof",
    "nees_base_mean",
    "nees_map_mean",
    "alignment",
    # Beyond the contract: the same errors of the online estimate, and what the means above are made of.
    "trajectory_median_m",
    "nees_position_per_dof",
    "inside_3_sigma_fraction",
    "nees_position_online_per_dof",
    "inside_3_sigma_online_fraction",
    "trajectory_online_rmse_m",
    "trajectory_online_reference_outliers",
    "reference_compared",
    "heading_rmse_rad",
    "map_error_matched",
    "nees_dof",
    "nees_joint_dof",
    "inside_3_sigma_depth_fraction",
    # Of a survey's contacts: see contact_score.py
    "objects",
    "contacts",
    "contacts_found",
    "contacts_false",
    "contacts_duplicate",
    "contacts_found_fraction",
    "contacts_false_fraction",
    "contact_position_rms_m",
)


@dataclass(frozen=True)
class Passes:
    """How often a sonar passed each landmark (l,), how often it showed, and what that makes of it; those of a smaller probability of
    existence than the setting are not confirmed."""

    seen: IntArray
    expected: IntArray
    existence: FloatArray
    confirmed: NDArray[np.bool_]


@dataclass(frozen=True)
class Landmarks:
    """ids (l,): those of the source where `ids_are_of_source`, row numbers otherwise; position (l, 2); covariance (l, 3) xx xy yy.
    depth_m (l,), depth_covariance (l, 3) xz yz zz and passes under water."""

    ids: IntArray
    ids_are_of_source: bool
    position: FloatArray
    covariance: FloatArray
    times_seen: IntArray
    submap: IntArray
    depth_m: FloatArray | None = None
    depth_covariance: FloatArray | None = None
    passes: Passes | None = None

    @property
    def claimed(self) -> "Landmarks":
        """Without those that are not confirmed."""
        if self.passes is None:
            return self
        rows = self.passes.confirmed
        passes = Passes(self.passes.seen[rows], self.passes.expected[rows], self.passes.existence[rows], rows[rows])
        return Landmarks(
            self.ids[rows],
            self.ids_are_of_source,
            self.position[rows],
            self.covariance[rows],
            self.times_seen[rows],
            self.submap[rows],
            None if self.depth_m is None else self.depth_m[rows],
            None if self.depth_covariance is None else self.depth_covariance[rows],
            passes,
        )


@dataclass(frozen=True)
class Bases:
    """time_s (b,), pose (b, 3), covariance (b, 6) upper triangles of the bases in the global frame, final.

    joint_covariance (3b, 3b) is absent in a long mission.
    """

    time_s: FloatArray
    pose: FloatArray
    covariance: FloatArray
    joint_covariance: FloatArray | None


@dataclass(frozen=True)
class Estimate:
    """What a reference is compared with. Series have one row per fed event, or, under water, per remembered step; covariances (n, 6) are
    upper triangles of x, y, heading, and space_covariances (n, 21) those of x, y, depth, roll, pitch, heading: final and online."""

    final: PoseSeries
    final_covariance: FloatArray
    online: PoseSeries
    online_covariance: FloatArray
    dead_reckoning: PoseSeries
    landmarks: Landmarks
    bases: Bases | None
    update_time_s: FloatArray
    space_covariances: tuple[FloatArray, FloatArray] | None = None

    @property
    def is_under_water(self) -> bool:
        return self.space_covariances is not None

    @property
    def depth_variance_m2(self) -> FloatArray | None:
        """(n,) of the final poses"""
        if self.space_covariances is None:
            return None
        variance: FloatArray = self.space_covariances[0][:, SPACE_COVARIANCE_NAMES.index("var_zz") - 1]
        return variance


why_not_a_run = holds_only(RUN_FILES, (SUMMARY_FILE, CONFIG_FILE))


def run_directory(path: Path) -> Path:
    if not path.is_dir():
        raise UserError(f"{path}: is no run directory; name the directory that a run has written")
    if not (path / SUMMARY_FILE).is_file():
        raise UserError(f"{path / SUMMARY_FILE}: is missing; name a directory that a finished run has written")
    return path


def json_text(document: Mapping[str, Any]) -> str:
    return json.dumps(document, indent=2, allow_nan=False) + "\n"


def read_json(path: Path) -> dict[str, Any]:
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise UserError(f"{path}: is missing; run the mission again") from error
    except ValueError as error:
        raise UserError(f"{path}: is not a JSON document ({error}); run the mission again") from error
    if not isinstance(document, dict):
        raise UserError(f"{path}: must hold one JSON object; run the mission again")
    return document


def numbers_of(value: Any) -> Any:
    """Arrays and numpy scalars inside lists and dictionaries as plain Python numbers."""
    if isinstance(value, Mapping):
        return {str(key): numbers_of(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [numbers_of(entry) for entry in value]
    if isinstance(value, np.ndarray):
        return value.tolist()
    return value.item() if isinstance(value, np.generic) else value


def landmarks_of(result: Mapping[str, Any]) -> Landmarks:
    landmarks = result["landmarks"]
    position = np.asarray(landmarks["position"], dtype=np.float64)
    covariance = np.asarray(landmarks["covariance"], dtype=np.float64)
    in_space = position.shape[1] == 3
    identities = list(landmarks["landmark_id"])
    of_source = bool(identities) and all(identity is not None for identity in identities)
    ids = np.array(identities if of_source else range(len(position)), dtype=np.int64)
    return Landmarks(
        ids,
        of_source,
        position[:, :2],
        covariance[:, [0, 1, 3]] if in_space else covariance,
        np.asarray(landmarks["times_seen"], dtype=np.int64),
        np.asarray(landmarks["submap"], dtype=np.int64),
        position[:, 2] if in_space else None,
        covariance[:, [2, 4, 5]] if in_space else None,
        _passes_of(landmarks) if "existence" in landmarks else None,
    )


def _passes_of(landmarks: Mapping[str, Any]) -> Passes:
    return Passes(
        np.asarray(landmarks["passes_seen"], dtype=np.int64),
        np.asarray(landmarks["passes_expected"], dtype=np.int64),
        np.asarray(landmarks["existence"], dtype=np.float64),
        np.asarray(landmarks["confirmed"], dtype=np.bool_),
    )


def _poses(time_s: FloatArray, pose: Any) -> PoseSeries:
    """pose (n, 3) x, y, heading, or (n, 6) x, y, depth, roll, pitch, heading"""
    values = np.asarray(pose, dtype=np.float64)
    if values.shape[1] == 3:
        return PoseSeries(time_s, values)
    return PoseSeries(time_s, values[:, [0, 1, 5]], values[:, [2, 3, 4]])


def _planar(covariance: FloatArray) -> FloatArray:
    """(n, 6) of the plane out of (n, 21) of space; planar ones stay as they are."""
    if covariance.shape[1] == len(PLANAR_NAMES):
        return covariance
    return covariance[:, [SPACE_COVARIANCE_NAMES.index(name) - 1 for name in PLANAR_NAMES]]


def estimate_of(result: Mapping[str, Any]) -> Estimate:
    """The estimate as the estimator returned it."""
    time_s = np.asarray(result["time_s"], dtype=np.float64)
    submaps = result["submaps"]  # submap k starts at base k
    joint = result["joint_base_covariance"]
    covariance, online_covariance = (np.asarray(result[key], dtype=np.float64) for key in ("covariance", "online_covariance"))
    return Estimate(
        final=_poses(time_s, result["pose"]),
        final_covariance=_planar(covariance),
        online=_poses(time_s, result["online_pose"]),
        online_covariance=_planar(online_covariance),
        dead_reckoning=_poses(time_s, result["dead_reckoning"]),
        landmarks=landmarks_of(result),
        bases=Bases(
            np.array([submap["start_time_s"] for submap in submaps], dtype=np.float64),
            np.array([submap["base_pose"] for submap in submaps], dtype=np.float64).reshape(-1, 3),
            np.array([submap["base_covariance"] for submap in submaps], dtype=np.float64).reshape(-1, 6),
            None if joint is None else np.asarray(joint, dtype=np.float64)[: 3 * len(submaps), : 3 * len(submaps)],
        ),
        update_time_s=np.asarray(result["updates"]["time_s"], dtype=np.float64),
        space_covariances=(covariance, online_covariance) if covariance.shape[1] > len(PLANAR_NAMES) else None,
    )


def write_estimate(directory: Path, estimate: Estimate, result: Mapping[str, Any], geodetic: Geodetic | None) -> None:
    """The result files of a run that need no reference."""
    write_tum(directory / TRAJECTORY_FILE, estimate.final)
    write_tum(directory / ONLINE_FILE, estimate.online)
    write_tum(directory / DEAD_RECKONING_FILE, estimate.dead_reckoning)
    covariances = estimate.space_covariances or (estimate.final_covariance, estimate.online_covariance)
    names = COVARIANCE_NAMES if estimate.space_covariances is None else SPACE_COVARIANCE_NAMES
    for name, covariance in zip((COVARIANCE_FILE, ONLINE_COVARIANCE_FILE), covariances, strict=True):
        columns = [estimate.final.time_s, *covariance.T]
        write_table(directory / name, ",".join(names), columns, [EXACT, *[SCIENTIFIC] * covariance.shape[1]])
    time_s = estimate.final.time_s
    write_table(directory / TRAJECTORY_SUBMAPS_FILE, "time_s,submap", [time_s, np.asarray(result["submap"])], [EXACT, WHOLE])
    step_times = [np.asarray(result.get("tick_time_s", time_s)), np.asarray(result["step_time_us"])]
    write_table(directory / STEP_TIMES_FILE, "time_s,step_time_us", step_times, [EXACT, "%.3f"])
    updates = result["updates"]
    write_table(
        directory / CONSISTENCY_FILE,
        "time_s,nis,dof",
        [np.asarray(updates["time_s"]), np.asarray(updates["nis"]), np.asarray(updates["dof"])],
        [EXACT, SCIENTIFIC, WHOLE],
    )
    _write_landmarks(directory / LANDMARKS_FILE, estimate.landmarks)
    write_landmark_covariance(directory, result["landmarks"].get("joint_covariance"))
    submaps = {key: numbers_of(result[key]) for key in ("submaps", "live_maps", "loops")}
    (directory / SUBMAPS_FILE).write_text(json_text(submaps), encoding="utf-8")
    (directory / GRAPH_FILE).write_text(g2o_text(submap_graph(result["submaps"])), encoding="utf-8")
    if estimate.bases is not None:
        bases = estimate.bases
        joint: dict[str, Any] = {} if bases.joint_covariance is None else {"joint_covariance": bases.joint_covariance}
        np.savez_compressed(directory / BASES_FILE, time_s=bases.time_s, pose=bases.pose, covariance=bases.covariance, **joint)
    if geodetic is not None:
        landmarks = estimate.landmarks
        text = map_geojson(estimate.final.pose[:, :2], landmarks.position, landmarks.covariance, landmarks.ids.tolist(), geodetic)
        (directory / MAP_FILE).write_text(text, encoding="utf-8")


def _write_landmarks(path: Path, landmarks: Landmarks) -> None:
    """The world of a planar vehicle is flat: z and its covariance are zero."""
    xx, xy, yy = landmarks.covariance.T
    z = xz = yz = zz = np.zeros(len(landmarks.ids))
    of_z, of_z_covariance = "%.0f", "%.0f"
    if landmarks.depth_m is not None and landmarks.depth_covariance is not None:
        z, (xz, yz, zz) = landmarks.depth_m, landmarks.depth_covariance.T
        of_z, of_z_covariance = FIXED, SCIENTIFIC
    columns: list[FloatArray | IntArray] = [landmarks.ids, *landmarks.position.T, z, xx, xy, xz, yy, yz, zz]
    columns += [landmarks.times_seen, landmarks.submap]
    planar, deep = SCIENTIFIC, of_z_covariance
    formats = [WHOLE, FIXED, FIXED, of_z, planar, planar, deep, planar, deep, deep, WHOLE, WHOLE]
    header = LANDMARK_HEADER
    if (passes := landmarks.passes) is not None:
        header += "," + PASSES_HEADER
        columns += [passes.seen, passes.expected, passes.existence, passes.confirmed.astype(np.int64)]
        formats += [WHOLE, WHOLE, "%.4f", WHOLE]
    write_table(path, header, columns, formats)


def submap_graph(submaps: Sequence[Mapping[str, Any]]) -> PoseGraph:
    """Final bases as vertices, the links between submaps that follow each other as edges."""
    graph = PoseGraph()
    for submap in submaps:
        x, y, heading = (float(value) for value in submap["base_pose"])
        graph.vertices.append(Vertex(int(submap["index"]), (x, y, heading)))
    known = {vertex.id for vertex in graph.vertices}
    for submap in submaps:
        index = int(submap["index"])
        if submap["link_pose"] is None or submap["link_covariance"] is None or index + 1 not in known:
            continue
        x, y, heading = (float(value) for value in submap["link_pose"])
        information = edge_information((x, y, heading), [float(value) for value in submap["link_covariance"]])
        graph.edges.append(Edge(index, index + 1, (x, y, heading), information))
    return graph


def read_estimate(directory: Path) -> Estimate:
    """The estimate of a finished run, as far as its files hold it."""
    final = read_tum(directory / TRAJECTORY_FILE)
    summary = read_json(directory / SUMMARY_FILE)
    consistency = read_table(directory / CONSISTENCY_FILE, required=("time_s", "nis", "dof"))
    covariance, online_covariance = (
        _read_covariance(directory / name, len(final.time_s)) for name in (COVARIANCE_FILE, ONLINE_COVARIANCE_FILE)
    )
    in_space = covariance.shape[1] > len(PLANAR_NAMES)
    return Estimate(
        final=final,
        final_covariance=_planar(covariance),
        online=read_tum(directory / ONLINE_FILE),
        online_covariance=_planar(online_covariance),
        dead_reckoning=read_tum(directory / DEAD_RECKONING_FILE),
        landmarks=_read_landmarks(directory / LANDMARKS_FILE, summary.get("landmark_ids") == "source"),
        bases=_read_bases(directory / BASES_FILE),
        update_time_s=consistency["time_s"],
        space_covariances=(covariance, online_covariance) if in_space else None,
    )


def _read_covariance(path: Path, rows: int) -> FloatArray:
    """(rows, 6), or (rows, 21) of a vehicle under water."""
    table = read_table(path, required=COVARIANCE_NAMES, optional=SPACE_COVARIANCE_NAMES, other_columns_allowed=True)
    if table.rows != rows:
        raise UserError(f"{path}: has {table.rows} rows where the trajectory has {rows}; run the mission again")
    in_space = all(name in table for name in SPACE_COVARIANCE_NAMES)
    return table.stacked(SPACE_COVARIANCE_NAMES[1:] if in_space else PLANAR_NAMES)


def _read_landmarks(path: Path, ids_are_of_source: bool) -> Landmarks:
    table = read_table(path, required=LANDMARK_NAMES, optional=PASSES_NAMES, other_columns_allowed=True)
    return Landmarks(
        whole_numbers(table, "id"),
        ids_are_of_source,
        table.stacked(("x_m", "y_m")),
        table.stacked(("var_xx", "cov_xy", "var_yy")),
        whole_numbers(table, "times_seen"),
        whole_numbers(table, "submap"),
        passes=_read_passes(table) if "existence" in table else None,
    )


def _read_passes(table: NumberTable) -> Passes:
    confirmed = whole_numbers(table, "confirmed").astype(np.bool_)
    return Passes(whole_numbers(table, "passes_seen"), whole_numbers(table, "passes_expected"), table["existence"], confirmed)


def _read_bases(path: Path) -> Bases | None:
    if not path.is_file():
        return None
    with np.load(path, allow_pickle=False) as archive:
        return Bases(archive["time_s"], archive["pose"], archive["covariance"], archive.get("joint_covariance"))


def replace_json(path: Path, document: Mapping[str, Any]) -> None:
    write_file(path, json_text(document))
