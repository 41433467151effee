"""The ARACATI 2017 data set as a mission: a remotely operated vehicle with a forward-looking sonar (BlueView P900-130) in a marina.

`keyframes.csv` holds dead reckoning, DGPS and compass at every keyframe, `sonar_points_body.csv` the strong returns of the sonar in each.
The heading of the dead reckoning is the compass, turned anticlockwise; its distances come from commanded speeds (0, 0.3 or 0.6 m/s), which
know nothing of current, of the tether or of hovering. The DGPS is the reference and nothing else.
"""

import hashlib
import math
from pathlib import Path
from typing import Any

import numpy as np

from ssjs_cli.errors import UserError
from ssjs_cli.formats.mission import Fixes, ImportRecord, Mission, Odometry, Reference, ReferenceDescription, SonarHits
from ssjs_cli.formats.number_table import FloatArray, IntArray, NumberTable, read_table, require_positive_range, whole_numbers
from ssjs_cli.formats.tum import wrapped_angle

KEYFRAMES_FILE = "keyframes.csv"
HITS_FILE = "sonar_points_body.csv"
KEYFRAME_COLUMNS = ("keyframe_id", "time", "dr_x", "dr_y", "dr_theta", "dgps_x", "dgps_y")
HIT_COLUMNS = ("keyframe_id", "range_m", "bearing_rad", "intensity")

# A commanded speed is wrong by the current and the thrust for as long as it is held; the rest is a random walk.
SPEED_SIGMA_M_S = 0.07
WALK_SIGMA_M_SQRT_S = 0.05
# Of the difference of two compass readings; there is no drift beside it.
HEADING_SIGMA_RAD = math.radians(0.05)
# The trajectory begins at the first keyframe, known there by definition.
START_SIGMA = 1e-4
DGPS_SIGMA_M = 1.0

# docs/marinas.md says how each was chosen. The scale is the one at which most point targets of images 4 to 6 keyframes apart coincide.
# Piles stand 2 to 2.5 m apart in rows: a tight joint gate keeps a scan from being paired one pile further.
SETTINGS: dict[str, Any] = {
    "vehicle": {"kind": "increments", "increments": {"distance_scale": 0.92}},
    "sensor": {"range_sigma_m": 0.3, "bearing_sigma_rad": math.radians(1.0), "min_range_m": 1.5, "max_range_m": 50.0},
    "persistence": {"min_earlier_sightings": 1, "window_scans": 5, "gate_m": 0.8, "gate_growth_m": 0.12},
    "association": {
        "method": "jcbb",
        "gate_probability": 0.99,
        "joint_gate_probability": 0.8,
        "new_landmark_squared_distance": 25.0,
        "node_budget": 5000,
    },
    "submap": {"max_landmarks": 30, "max_sigma_xy_m": 20.0, "min_sightings": 1, "prune_after_scans": 10},
    "joining": {"max_fused_landmarks": 400, "max_pairing_sigma_m": 2.0, "node_budget": 5000},
}


def read_aracati(source: Path) -> Mission:
    if not source.is_dir():
        raise UserError(f"{source}: is no directory; name the one that holds {KEYFRAMES_FILE} and {HITS_FILE}")
    for name in (KEYFRAMES_FILE, HITS_FILE):
        if not (source / name).is_file():
            raise UserError(f"{source / name}: is missing; name the directory that holds the data set")
    keyframes = read_table(source / KEYFRAMES_FILE, required=KEYFRAME_COLUMNS, other_columns_allowed=True)
    identities = _checked_keyframes(keyframes)
    hits = _read_hits(source / HITS_FILE, keyframes, identities)
    fixes = Fixes(keyframes["time"], keyframes.stacked(("dgps_x", "dgps_y")), np.full(keyframes.rows, DGPS_SIGMA_M))
    images = len(np.unique(hits.time_s))
    return Mission(
        name="aracati2017",
        description="remotely operated vehicle with a forward-looking sonar among the piers of a marina, 44 minutes, about 620 m",
        notes="ARACATI 2017. Reference: DGPS of a float above the vehicle. Heading and distances: compass and commanded speeds.",
        odometry=Odometry("increments", increments(keyframes)),
        sonar_hits=hits,
        settings=SETTINGS,
        reference=Reference(ReferenceDescription(alignment="se2", max_gap_s=60.0), fixes=fixes),
        import_record=ImportRecord(
            format="aracati",
            counts={"keyframes": keyframes.rows, "sonar_hits": len(hits.time_s), "sonar_images": images, "dgps_fixes": keyframes.rows},
            digests={name: hashlib.sha256((source / name).read_bytes()).hexdigest() for name in (KEYFRAMES_FILE, HITS_FILE)},
        ),
    )


def _checked_keyframes(keyframes: NumberTable) -> IntArray:
    if keyframes.rows < 2:
        raise UserError(f"{keyframes.path}: holds {keyframes.rows} keyframes; a mission needs at least two")
    later = np.diff(keyframes["time"]) > 0.0
    if not later.all():
        raise UserError(
            f"{keyframes.where(int(np.argmin(later)) + 1)}: time does not increase; sort the keyframes and keep one of equal times"
        )
    identities = whole_numbers(keyframes, "keyframe_id")
    growing = np.diff(identities) > 0
    if not growing.all():
        raise UserError(f"{keyframes.where(int(np.argmin(growing)) + 1)}: keyframe_id does not increase; sort the keyframes by it")
    return identities


def increments(keyframes: NumberTable) -> FloatArray:
    """Rows of increment odometry, each in the frame of the keyframe before; the first row stands at the first keyframe."""
    time_s, heading = keyframes["time"], keyframes["dr_theta"]
    step = np.diff(keyframes.stacked(("dr_x", "dr_y")), axis=0)
    cos, sin = np.cos(heading[:-1]), np.sin(heading[:-1])
    dt_s = np.diff(time_s)
    sigma_m = np.hypot(SPEED_SIGMA_M_S * dt_s, WALK_SIGMA_M_SQRT_S * np.sqrt(dt_s))
    rows = np.column_stack(
        [
            time_s[1:],
            cos * step[:, 0] + sin * step[:, 1],
            cos * step[:, 1] - sin * step[:, 0],
            wrapped_angle(np.diff(heading)),
            sigma_m,
            sigma_m,
            np.full(len(dt_s), HEADING_SIGMA_RAD),
        ]
    )
    start = [time_s[0], 0.0, 0.0, 0.0, START_SIGMA, START_SIGMA, START_SIGMA]
    return np.vstack([start, rows])


def _read_hits(path: Path, keyframes: NumberTable, identities: IntArray) -> SonarHits:
    table = read_table(path, required=HIT_COLUMNS)
    if table.rows == 0:
        raise UserError(f"{path}: holds no sonar hit; fetch the file again")
    require_positive_range(table)
    of_keyframe = whole_numbers(table, "keyframe_id")
    place = np.minimum(np.searchsorted(identities, of_keyframe), len(identities) - 1)
    unknown = identities[place] != of_keyframe
    if unknown.any():
        row = int(np.argmax(unknown))
        raise UserError(f"{table.where(row)}: keyframe {of_keyframe[row]} is not in {keyframes.path.name}; correct or remove the line")
    order = np.argsort(of_keyframe, kind="stable")
    return SonarHits(keyframes["time"][place][order], table["range_m"][order], table["bearing_rad"][order], table["intensity"][order])
