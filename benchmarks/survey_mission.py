"""The simulated four-hour survey from sonar log to contacts, over seeds and methods: errors, consistency, contacts, speed, memory.

    python benchmarks/survey_mission.py --seeds 1 2 3 --methods ssjs ekf
    python benchmarks/survey_mission.py --seeds 1 --methods ssjs --hours 1 2 4      # does the memory grow?

Every simulation and every run is a process of its own, so that its processor time and its largest memory are its own. A contact is found
or false as contact_score.py says. Prints Markdown: one line a run, then the means of each method.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

# summary key (or computed below), heading, decimals
COLUMNS = (
    ("dead_reckoning_rmse_m", "dead reckoning RMSE m", 2),
    ("trajectory_rmse_m", "RMSE m", 2),
    ("ratio", "dead reckoning / RMSE", 1),
    ("inside_3_sigma_percent", "inside 3 sigma %", 1),
    ("depth_inside_3_sigma_percent", "depth %", 1),
    ("nees_mean", "pose NEES (3)", 1),
    ("nees_joint_per_dof", "joint base NEES per dof", 2),
    ("found_percent", "found %", 1),
    ("false_percent", "false %", 1),
    ("contacts_duplicate", "duplicates", 0),
    ("contact_position_rms_m", "contact RMS m", 2),
    ("loop_closures", "loops", 0),
    ("submaps", "submaps", 0),
    ("cpu_s", "run CPU s", 1),
    ("times_real_time", "times real time", 0),
    ("peak_rss_mb", "run MB", 0),
    ("simulate_rss_mb", "simulate MB", 0),
)


@dataclass(frozen=True)
class Finished:
    cpu_s: float
    peak_rss_mb: float


def finish(arguments: Sequence[str]) -> Finished:
    """ssjs-cli in a process of its own."""
    process = subprocess.Popen([sys.executable, "-m", "ssjs_cli", *arguments], stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise SystemExit(f"ssjs-cli {' '.join(arguments)}: exit code {process.returncode}")
    return Finished(usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024.0 / 1e6)


def scenario_file(folder: Path, scenario: str, hours: float | None) -> str:
    """The scenario by its name, or cut after so many hours."""
    if hours is None:
        return scenario
    path = folder / f"{scenario}-{hours:g}h.toml"
    path.write_text(f'scenario = "{scenario}"\n[survey.vehicle]\nduration_s = {3600.0 * hours!r}\n', encoding="utf-8")
    return str(path)


def measured(run: Path, mission: Path, simulated: Finished | None, finished: Finished) -> dict[str, Any]:
    summary: dict[str, Any] = json.loads((run / "summary.json").read_text(encoding="utf-8"))
    time_s = np.loadtxt(mission / "truth_trajectory.tum", usecols=0)
    summary["ratio"] = summary["dead_reckoning_rmse_m"] / summary["trajectory_rmse_m"]
    for name, key in (
        ("inside_3_sigma", "inside_3_sigma_fraction"),
        ("depth_inside_3_sigma", "inside_3_sigma_depth_fraction"),
        ("found", "contacts_found_fraction"),
        ("false", "contacts_false_fraction"),
    ):
        summary[f"{name}_percent"] = None if summary[key] is None else 100.0 * summary[key]
    summary["cpu_s"], summary["peak_rss_mb"] = finished.cpu_s, finished.peak_rss_mb
    summary["times_real_time"] = float(time_s[-1] - time_s[0]) / finished.cpu_s
    summary["simulate_rss_mb"] = None if simulated is None else simulated.peak_rss_mb
    return summary


def line(label: str, values: Sequence[float | None]) -> str:
    cells = ["" if value is None else f"{value:.{decimals}f}" for value, (_, _, decimals) in zip(values, COLUMNS, strict=True)]
    return f"| {label} | " + " | ".join(cells) + " |"


def mean(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if known else None


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenario", default="remus-survey")
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3])
    parser.add_argument("--methods", nargs="+", default=["ssjs", "ekf"])
    parser.add_argument("--hours", type=float, nargs="+", default=[None], help="cut the mission; several: one after the other")
    parser.add_argument("--missions", type=Path, help="keep the simulated missions here, and take those that are here already")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="a setting of every run")
    arguments = parser.parse_args()
    print("| mission, method | " + " | ".join(heading for _, heading, _ in COLUMNS) + " |")
    print("|---" * (len(COLUMNS) + 1) + "|", flush=True)
    rows: dict[str, list[dict[str, Any]]] = {}
    settings = [text for assignment in arguments.set for text in ("--set", assignment)]
    with tempfile.TemporaryDirectory() as name:
        run = Path(name) / "run"
        for hours in arguments.hours:
            length = "" if hours is None else f"{hours:g} h, "
            for seed in arguments.seeds:
                source = scenario_file(Path(name), arguments.scenario, hours)
                mission = Path(name) / "mission"
                if arguments.missions is not None:
                    mission = arguments.missions / f"{Path(source).stem}-{seed}"
                simulated = None
                if arguments.missions is None or not mission.is_dir():
                    simulated = finish(["simulate", source, "--seed", str(seed), "--out", str(mission), "--force"])
                for method in arguments.methods:
                    asked = ["run", str(mission), "--method", method, "--no-report", "--out", str(run), "--force", *settings]
                    row = measured(run, mission, simulated, finish(asked))
                    rows.setdefault(f"{length}{method}", []).append(row)
                    print(line(f"{length}seed {seed}, {method}", [row[key] for key, _, _ in COLUMNS]), flush=True)
    for label, of_method in rows.items():
        print(line(f"mean, {label}", [mean([row[key] for row in of_method]) for key, _, _ in COLUMNS]))


if __name__ == "__main__":
    main()
