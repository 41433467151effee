"""The table of docs/comparison.md from a finished study.

    ssjs-cli consistency grid-survey --runs 20 --methods all --association known --jobs 1 --out STUDY
    python benchmarks/methods_table.py STUDY

Times and memory are medians over the runs, all else means unless the head says otherwise.
"""

import json
import statistics
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

Summary = dict[str, Any]


def runs_by_method(study: Path) -> dict[str, list[Summary]]:
    runs: dict[str, list[Summary]] = {}
    for file in sorted((study / "runs").glob("*.json")):
        run = json.loads(file.read_text())
        if "summary" in run["record"]:
            runs.setdefault(run["identity"]["settings"]["method"], []).append(run["record"]["summary"])
    return runs


def cell(runs: list[Summary], key: str, digits: int, over: Callable[[list[float]], float] = statistics.fmean) -> str:
    values = [run[key] for run in runs if run.get(key) is not None]
    return f"{over(values):.{digits}f}" if values else ""


def joint_nees(runs: list[Summary]) -> str:
    """Sum of the joint NEES of all bases over the sum of their degrees of freedom; one base says nothing about the map."""
    tested = [run for run in runs if run["nees_joint_per_dof"] is not None]
    degrees = sum(run["nees_joint_dof"] for run in tested)
    return f"{sum(run['nees_joint_per_dof'] * run['nees_joint_dof'] for run in tested) / degrees:.2f}" if degrees else ""


def main() -> None:
    runs = runs_by_method(Path(sys.argv[1]))
    print(
        "| method | total s | map level s | map error m | worst seed m | trajectory m | online m | pose NEES (3)"
        " | joint NEES/dof | landmark NEES (2) | closures | fewest | wrong pairs |"
    )
    print("|---" * 13 + "|")
    for method, found in sorted(runs.items(), key=lambda item: statistics.median(run["time_total_s"] for run in item[1])):
        columns = [
            f"`{method}`",
            cell(found, "time_total_s", 3, statistics.median),
            cell(found, "time_global_s", 3, statistics.median),
            cell(found, "map_error_mean_m", 2),
            cell(found, "map_error_mean_m", 2, max),
            cell(found, "trajectory_rmse_m", 2),
            cell(found, "trajectory_online_rmse_m", 2),
            cell(found, "nees_mean", 2),
            joint_nees(found),
            cell(found, "nees_map_mean", 2),
            cell(found, "loop_closures", 0),
            cell(found, "loop_closures", 0, min),
            cell(found, "wrong_pairs", 1),
        ]
        print("| " + " | ".join(columns) + " |")
    drift = [run["dead_reckoning_final_drift_percent"] for run in next(iter(runs.values()))]
    print(f"\ndead reckoning: final drift {statistics.fmean(drift):.1f} % of the path, {min(drift):.1f} to {max(drift):.1f}")


if __name__ == "__main__":
    main()
