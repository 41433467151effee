"""What the detectors of a survey find, pass by pass, and what `run` makes of it. docs/cascade.md

    PYTHONPATH=python python benchmarks/survey_detectors.py --missions DIR... --model cascade.json [--set detector.key=value ...]

A pass: the vehicle passes an object where the picture is valid. It is found when a contact, placed from the
true pose at its ping, lies within 2 m of the object; a contact with no object within 2 m is false.
"""

import argparse
import json
import tempfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ssjs_cli.app import call
from ssjs_cli.cascade.model_file import load_model
from ssjs_cli.config import UNDERWATER, core_sonar_values, layer_from_assignments, resolve
from ssjs_cli.formats.mission import Mission, read_mission
from ssjs_cli.sonar.contacts import sightings_in
from ssjs_cli.sonar.tiles import abeam, blocks_of

NEAR_M = 2.0


def passes_of(directory: Path, mission: Mission) -> list[tuple[float, int]]:
    """Time and object of every pass."""
    found = []
    for block in blocks_of(directory, mission, 4096):
        for side in ("port", "starboard"):
            for row, range_m, _, index in abeam(block.time_s, mission, side):
                step = int(range_m / block.column_m)
                column = block.nadir_column + (step if side == "starboard" else -1 - step)
                if 0 <= column < block.valid.shape[1] and block.valid[row, column]:
                    found.append((float(block.time_s[row]), index))
    return found


def score(directory: Path, assignments: list[str], model: Path | None) -> Mapping[str, float]:
    mission = read_mission(directory)
    truth, landmarks = mission.reference.truth, mission.reference.landmarks
    assert truth is not None and landmarks is not None
    values = resolve([layer_from_assignments(assignments, UNDERWATER)], UNDERWATER).values
    cascade = None if model is None else load_model(model).cascade
    sightings = sightings_in(mission.sonar_logs, core_sonar_values(values), [], cascade)
    passes = passes_of(directory, mission)
    seen: set[tuple[float, int]] = set()
    false = 0
    heading = np.unwrap(truth.pose[:, 2])
    for sighting in sightings:
        time_s = float(sighting.found["time_s"])
        x, y = (np.interp(time_s, truth.time_s, truth.pose[:, axis]) for axis in (0, 1))
        c, s = np.cos(np.interp(time_s, truth.time_s, heading)), np.sin(np.interp(time_s, truth.time_s, heading))
        forward, starboard, _ = sighting.found["body_position_m"]
        place = np.array([x + c * forward - s * starboard, y + s * forward + c * starboard])
        distance_m = np.linalg.norm(landmarks.position_m - place, axis=1)
        nearest = int(np.argmin(distance_m))
        if distance_m[nearest] > NEAR_M:
            false += 1
        else:
            seen |= {(at, index) for at, index in passes if index == nearest and abs(at - time_s) < 10.0}
    return {"passes": len(passes), "found": len(seen), "contacts": len(sightings), "false": false}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--missions", nargs="+", type=Path, required=True)
    parser.add_argument("--model", type=Path)
    parser.add_argument("--set", action="append", default=[], dest="assignments", help="sonar.key=value")
    parser.add_argument("--no-run", action="store_true", help="sightings only")
    given = parser.parse_args()
    assignments = list(given.assignments)
    if given.model is not None:
        assignments += ["sonar.detector=cascade", f"sonar.cascade_model={given.model}"]
    total: dict[str, float] = {}
    maps = []
    for directory in given.missions:
        for key, value in score(directory, assignments, given.model).items():
            total[key] = total.get(key, 0) + value
        if given.no_run:
            continue
        with tempfile.TemporaryDirectory() as folder:
            run = Path(folder) / "run"
            sets = [part for assignment in assignments for part in ("--set", assignment)]
            if call(["run", str(directory), "--out", str(run), "--no-report", "--json", *sets]) != 0:
                raise SystemExit(1)
            summary = json.loads((run / "summary.json").read_text(encoding="utf-8"))
        keys = ("trajectory_rmse_m", "map_error_mean_m", "map_error_matched", "landmarks_false", "nees_mean")
        maps.append([float(summary[key]) for key in keys])
    print()
    print(f"passes {total['passes']:.0f}, found {total['found'] / total['passes']:.3f}, contacts {total['contacts']:.0f}, "
          f"false {total['false'] / max(total['contacts'], 1):.3f}")  # fmt: skip
    if maps:
        rmse, error, matched, none, nees = np.mean(maps, axis=0)
        print(f"run: RMSE {rmse:.2f} m, map error {error:.2f} m, objects {matched:.1f}, none {none:.1f}, pose NEES {nees:.1f}")


if __name__ == "__main__":
    main()
