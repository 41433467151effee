"""What a batch costs beside its runs: the parent's work over many missions that are all finished.

    PYTHONPATH=python python benchmarks/batch_scan.py --missions 10000 --work /tmp/scan

Makes missions with one small file each and what a batch would have left of their runs (a record, a run directory with a summary), then
measures each step of a call that finds everything done. Processor seconds of one process; the files are in the system's cache.
"""

import argparse
import json
import resource
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from ssjs_cli.formats.mission import Geodetic
from ssjs_cli.formats.run_directory import SUMMARY_FILE
from ssjs_cli.formats.season_contacts import season_contacts_csv, season_geojson
from ssjs_cli.report.season_page import season_page
from ssjs_cli.session import Session
from ssjs_cli.studies.batch import KEYS, RESULT_KEYS, run_batch
from ssjs_cli.studies.batch_plan import BatchRequest, plan_batch
from ssjs_cli.studies.mission_manifest import MANIFEST_FILE, SETTLED_NS, KnownMission, MissionManifest
from ssjs_cli.studies.process_pool import ProcessPool
from ssjs_cli.studies.season import worst_first
from ssjs_cli.studies.season_map import PlacedMission, Region, SeasonContact, SeasonMap
from ssjs_cli.studies.season_output import REPORT_FILE, write_season
from ssjs_cli.studies.study_folder import StudyFolder, open_study
from ssjs_cli.studies.tables import csv_text, json_text

MISSION = '[mission]\nname = "dive {0:06d}"\n'
ODOMETRY = "time_s,speed_m_s,steering_rad\n0.0,1.0,0.0\n"


class Steps:
    """Processor seconds of each step."""

    def __init__(self) -> None:
        self.cpu_s: dict[str, float] = {}

    def measure(self, name: str, work: Callable[[], Any]) -> Any:
        began_s = time.process_time()
        result = work()
        self.cpu_s[name] = round(time.process_time() - began_s, 3)
        return result


def make_missions(folder: Path, count: int) -> list[Path]:
    missions = []
    for number in range(count):
        mission = folder / f"{number:06d}"
        if not mission.is_dir():
            mission.mkdir(parents=True)
            (mission / "odometry.csv").write_text(ODOMETRY)
            (mission / "mission.toml").write_text(MISSION.format(number))
        missions.append(mission)
    return missions


def finish_runs(request: BatchRequest, out: Path) -> None:
    """Leaves what a batch would have left."""
    with open_study(out, {"study": "batch"}, outputs=("missions", MANIFEST_FILE), force=False) as folder:
        plan = plan_batch(request, out, folder)
        for number, run in enumerate(plan.runs.values()):
            if run.plan is None:
                continue
            results = {**dict.fromkeys(RESULT_KEYS), "nis_mean": 1.0 + 0.001 * (number % 97), "landmarks": 20, "trajectory_rmse_m": 0.5}
            folder.store(run.key, run.plan.identity, {"results": results, "warnings": [], "lost": []})
            (out / run.directory).mkdir()
            (out / run.directory / SUMMARY_FILE).write_text(json.dumps({"mission": run.mission, "geodetic": None}))


def scan(missions: list[Path], out: Path) -> dict[str, Any]:
    request = BatchRequest(missions, ProcessPool(1), out=out)
    finish_runs(request, out)
    time.sleep(1.1 * SETTLED_NS / 1e9)
    steps = Steps()
    folder = StudyFolder(out)
    (out / MANIFEST_FILE).unlink(missing_ok=True)
    steps.measure("plan, no manifest", lambda: plan_batch(request, out, folder))
    plan = steps.measure("plan, by the manifest", lambda: plan_batch(request, out, folder))
    assert not plan.missing
    rows = [
        {**dict.fromkeys(KEYS), "mission": run.mission, "path": str(path), **plan.finished[run.key]["results"], "directory": run.directory}
        for path, run in plan.runs.items()
    ]
    ranked = steps.measure("outliers", lambda: worst_first(rows))
    steps.measure("season.json, season.csv", lambda: (json_text({"missions": ranked}), csv_text(KEYS, ranked)))
    steps.measure("map and page, nothing on the map", lambda: write_season(out, ranked, folder))
    steps.measure("whole call, everything new", lambda: run_batch(request, Session()))
    steps.measure("whole call, nothing to do", lambda: run_batch(request, Session()))
    return {
        "missions": len(missions),
        "cpu_s": steps.cpu_s,
        "manifest_mb": round((out / MANIFEST_FILE).stat().st_size / 1e6, 2),
        "page_mb": round((out / REPORT_FILE).stat().st_size / 1e6, 2),
        "peak_mb": round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3, 1),
    }


def tables(count: int) -> dict[str, Any]:
    """The steps that need no files, of rows made up."""
    numbers = dict.fromkeys(RESULT_KEYS, 1.0)
    rows = [
        {
            **dict.fromkeys(KEYS),
            **numbers,
            "mission": f"dive {i:06d}",
            "nis_mean": 1.0 + 0.001 * (i % 97),
            "directory": f"missions/dive-{i:06d}",
        }
        for i in range(count)
    ]
    manifest = MissionManifest(
        "request", {f"/data/{i:06d}": KnownMission("x" * 600, f"dive {i:06d}", f"{i:032x}") for i in range(count)}, True
    )
    steps = Steps()
    with TemporaryDirectory() as folder:
        steps.measure("manifest, written", lambda: manifest.write(Path(folder)))
        size_mb = (Path(folder) / MANIFEST_FILE).stat().st_size / 1e6
        steps.measure("manifest, read", lambda: MissionManifest.read(Path(folder), "request"))
    ranked = steps.measure("outliers", lambda: worst_first(rows))
    steps.measure("season.json, season.csv", lambda: (json_text({"missions": ranked}), csv_text(KEYS, ranked)))
    contacts = [SeasonContact(i, (0.01 * i, 5.0, 16.0), (0.1, 0.0, 0.1), 0.1, ((f"dive-{i:06d}", i),), 2) for i in range(count)]
    places = [
        PlacedMission(f"dive-{i:06d}", i, (0.0, 0.0, 0.0), 1.0, 1.0, np.array([[0.01 * i, 0.0], [0.01 * i, 50.0]])) for i in range(count)
    ]
    made = SeasonMap(
        [Region(Geodetic(origin_latitude_deg=41.0, origin_longitude_deg=2.0, heading_deg=0.0, y_axis="right"), places, contacts)]
    )
    page = steps.measure("page", lambda: season_page("season", ranked, made))
    steps.measure("contacts as CSV and GeoJSON", lambda: (season_contacts_csv(made.regions), season_geojson(made.regions)))
    peak_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
    return {
        "rows": count,
        "cpu_s": steps.cpu_s,
        "manifest_mb": round(size_mb, 1),
        "page_mb": round(len(page) / 1e6, 2),
        "peak_mb": round(peak_mb, 1),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--missions", type=int, default=10000)
    parser.add_argument("--work", type=Path, help="folder for the missions; without it only what needs no files is measured")
    arguments = parser.parse_args()
    if arguments.work is None:
        print(json.dumps(tables(arguments.missions), indent=2))
        return
    missions = make_missions(arguments.work / "missions", arguments.missions)
    print(json.dumps(scan(missions, arguments.work / f"batch-{arguments.missions}"), indent=2))


if __name__ == "__main__":
    main()
