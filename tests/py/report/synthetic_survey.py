"""The run directory of a sonar survey: two lines over a flat seabed, four contacts, pictures of seeded speckle."""

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np

from ssjs_cli.formats.contact_table import Contact, contacts_csv
from ssjs_cli.formats.mission import Geodetic
from ssjs_cli.formats.run_directory import SPACE_COVARIANCE_NAMES
from ssjs_cli.formats.tum import PoseSeries, write_tum
from ssjs_cli.sonar.coverage import coverage, write_coverage
from ssjs_cli.sonar.survey_pictures import write_contact_pictures, write_waterfall
from ssjs_cli.sonar.survey_record import SurveyRecord

ORIGIN = Geodetic(origin_latitude_deg=41.7, origin_longitude_deg=3.0, heading_deg=0.0, y_axis="right")
SEABED_M, DEPTH_M = 16.0, 12.0
#: id, x, y, times seen
OBJECTS = ((0, 40.0, 10.0, 3), (1, 80.0, -12.0, 1), (2, 60.0, 30.0, 2), (3, 20.0, 45.0, 1))


class Found:
    """As much of a sighting as the writers of pictures ask for."""

    def __init__(self, log: str, found: dict[str, Any], picture: int | None) -> None:
        self.log, self.found, self.picture = log, found, picture


def write_synthetic_survey(run_dir: Path, origin: Geodetic | None = ORIGIN, sonar: bool = True, clock_s: float = 0.0) -> Path:
    run_dir.mkdir(parents=True)
    track = _track(clock_s)
    write_tum(run_dir / "trajectory.tum", track)
    write_tum(run_dir / "trajectory_online.tum", track)
    tie = len(track.time_s) // 2
    for name, before, after in (("trajectory_covariance.csv", 0.2, 0.2), ("trajectory_online_covariance.csv", 0.8, 0.3)):
        _write_covariance(run_dir / name, track.time_s, np.where(np.arange(len(track.time_s)) < tie, before, after))
    submap = (np.arange(len(track.time_s)) >= tie).astype(int)
    rows = "\n".join(f"{time!r},{number}" for time, number in zip(track.time_s.tolist(), submap.tolist(), strict=True))
    (run_dir / "trajectory_submaps.csv").write_text(f"time_s,submap\n{rows}\n")
    _write_landmarks(run_dir / "landmarks.csv")
    (run_dir / "submaps.json").write_text(json.dumps(_submaps(track, tie)))
    summary = {
        "mission": "two lines", "method": "ssjs", "association": "jcbb", "axis_names": ["north", "east"] if origin else
        ["x, ahead at the start", "y, starboard at the start"], "geodetic": None if origin is None else origin.model_dump(),
        "sensors": {
            "compass": {"used": 950, "refused": 50, "nis_per_dof": 0.98},
            "side_scan": {"used": 7, "refused": 0, "nis_per_dof": 1.31},
        },
        "time_total_s": 0.3, "time_local_s": 0.2, "time_global_s": 0.1, "time_association_s": 0.0, "landmarks": 4, "loop_closures": 1,
    }  # fmt: skip
    if sonar:
        summary.update(_write_sonar(run_dir, track, origin))
    altitude = [f"{time!r},{SEABED_M - DEPTH_M:.3f}" for time in track.time_s.tolist()]
    (run_dir / "altitude.csv").write_text("\n".join(["time_s,altitude_m", *altitude]) + "\n")
    (run_dir / "summary.json").write_text(json.dumps(summary))
    return run_dir


def _track(clock_s: float) -> PoseSeries:
    """100 m north at 1 m/s, 20 s across, and back 20 m further east."""
    there = np.column_stack((np.arange(100.0), np.zeros(100), np.zeros(100)))
    across = np.column_stack((np.full(20, 100.0), np.arange(20.0), np.full(20, np.pi / 2)))
    back = np.column_stack((100.0 - np.arange(101.0), np.full(101, 20.0), np.full(101, -np.pi)))
    pose = np.concatenate((there, across, back))
    space = np.column_stack((np.full(len(pose), DEPTH_M), np.zeros((len(pose), 2))))
    return PoseSeries(clock_s + np.arange(float(len(pose))), pose, space)


def _write_covariance(path: Path, time_s: Any, sigma_m: Any) -> None:
    columns = np.zeros((len(time_s), len(SPACE_COVARIANCE_NAMES)))
    columns[:, 0] = time_s
    columns[:, SPACE_COVARIANCE_NAMES.index("var_xx")] = sigma_m**2
    columns[:, SPACE_COVARIANCE_NAMES.index("var_yy")] = (0.5 * sigma_m) ** 2
    np.savetxt(path, columns, delimiter=",", header=",".join(SPACE_COVARIANCE_NAMES), comments="")


def _write_landmarks(path: Path) -> None:
    lines = ["id,x_m,y_m,z_m,var_xx,cov_xy,cov_xz,var_yy,cov_yz,var_zz,times_seen,submap"]
    lines += [f"{number},{x},{y},{SEABED_M},0.04,0,0,0.01,0,0.01,{seen},{int(y > 20)}" for number, x, y, seen in OBJECTS]
    path.write_text("\n".join(lines) + "\n")


def _submaps(track: PoseSeries, tie: int) -> dict[str, Any]:
    ends = [(0, tie - 1), (tie, len(track.time_s) - 1)]
    submaps = [
        {
            "index": index, "start_time_s": float(track.time_s[first]), "end_time_s": float(track.time_s[last]),
            "base_pose": track.pose[first].tolist(), "base_covariance": [0.01, 0.0, 0.0, 0.01, 0.0, 1e-5], "landmarks": 2,
            "live_map": index, "closed_because": "length",
        }
        for index, (first, last) in enumerate(ends)
    ]  # fmt: skip
    loop = {"time_s": float(track.time_s[tie]), "from": 1, "to": 0, "accepted": True, "reason": "joined", "pairs": 1, "chi2": 1.0, "dof": 3}
    refused = {**loop, "time_s": float(track.time_s[-1]), "accepted": False, "reason": "joint gate failed"}
    return {"submaps": submaps, "live_maps": [], "loops": [loop, refused]}


def _write_sonar(run_dir: Path, track: PoseSeries, origin: Geodetic | None) -> dict[str, Any]:
    record = SurveyRecord()
    rng = np.random.default_rng(5)
    reach = np.tile([1.0, 28.0, 1.0, 28.0], (len(track.time_s), 1))
    reach[100:120] = np.nan
    grey = rng.integers(30, 100, (len(track.time_s), 560), dtype=np.uint8)
    where = {"first_index": 0, "nadir_column": 280, "column_m": 0.1}
    found = {
        number: {
            "index": int(x), "first_index": int(x) - 1, "last_index": int(x) + 1,
            "time_s": float(track.time_s[int(x)]), "ground_range_m": abs(y),
            "side": "starboard" if y > 0 else "port", "width_m": 1.0, "length_m": 2.0,
        }
        for number, x, y, _ in OBJECTS if abs(y) < 28.0
    }  # fmt: skip
    block = {**where, "grey": grey, "time_s": track.time_s, "altitude_m": np.full(len(track.time_s), 4.0), "reach_m": reach}
    record.add_blocks("survey.xtf", [block], list(found.values()))
    best = {number: Found("survey.xtf", entry, record.keep({**where, "grey": grey})) for number, entry in found.items()}
    write_contact_pictures(run_dir, track, best, record)  # type: ignore[arg-type]
    write_waterfall(run_dir, record)
    covered = coverage(track, record.reach())
    assert covered is not None
    write_coverage(run_dir / "coverage.npz", covered)
    contacts = []
    for number, x, y, seen in OBJECTS:
        sonar = {
            "time_s": best[number].found["time_s"], "log": "survey.xtf", "ping": int(x), "channel": best[number].found["side"],
            "ground_range_m": abs(y), "length_m": 2.0, "width_m": 1.0, "height_m": 0.5 + 0.1 * number, "confidence": 0.9 - 0.1 * number,
            "snippet": f"snippets/contact-{number:04d}.png",
        } if number in best else {}  # fmt: skip
        contacts.append(Contact(number, x, y, (0.04, 0.0, 0.01), seen, depth_m=SEABED_M, **sonar))  # type: ignore[arg-type]
    (run_dir / "contacts.csv").write_text(contacts_csv(contacts, origin))
    with (run_dir / "sightings.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["time_s", "log", "ping", "channel", "ground_range_m", "length_m", "width_m", "confidence", "contact"])
        for number, entry in found.items():
            writer.writerow([entry["time_s"], "survey.xtf", entry["index"], entry["side"], entry["ground_range_m"], 2.0, 1.0, 0.9, number])
        writer.writerow([float(track.time_s[70]), "survey.xtf", 70, "port", 5.0, 1.0, 1.0, 0.6, ""])
    return {"pings": record.pings, "sightings": len(found) + 1, **covered.numbers()}
