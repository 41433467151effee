"""SLAM on the real Sant Pere log with simulated posts: error against DGPS and consistency, over several draws of posts and echoes.

    python benchmarks/stpere_half_real.py DATA/stpere --landmarks 60 --seeds 1 2 3 4 5 6

Errors after alignment in x, y, heading (se2), and without (the world starts at the first fix, north by the first quarter of the log).
"""

import argparse
import csv
import json
import statistics
import sys
import tempfile
from pathlib import Path
from typing import Any

from ssjs_cli.app import call


def run_once(source: Path, landmarks: int, seed: int, association: str, folder: Path) -> dict[str, Any]:
    mission, run, aligned = (folder / name for name in (f"mission-{seed}", f"run-{association}-{seed}", f"aligned-{association}-{seed}"))
    if not mission.is_dir():
        _done(["import", "stpere", str(source), "--landmarks", str(landmarks), "--seed", str(seed), "--out", str(mission)])
    _done(["run", str(mission), "--association", association, "--out", str(run), "--no-report"])
    _done(["evaluate", str(run), "--align", "se2", "--out", str(aligned), "--force"])
    plain, fitted = (json.loads((path / "summary.json").read_text()) for path in (run, aligned))
    return {
        "association": association,
        "seed": seed,
        "rmse_se2_m": fitted["trajectory_rmse_m"],
        "max_se2_m": fitted["trajectory_max_m"],
        "rmse_m": plain["trajectory_rmse_m"],
        "dead_reckoning_se2_m": fitted["dead_reckoning_rmse_m"],
        "nees": plain["nees_mean"],
        "inside_three_sigma": inside_three_sigma(run / "errors.csv"),
        "map_error_m": plain["map_error_mean_m"],
        "submaps": plain["submaps"],
        "landmarks": plain["landmarks"],
        "loops": plain["loop_closures"],
        "wrong_pairs": plain["wrong_pairs"],
    }


def inside_three_sigma(errors: Path) -> float:
    """Share of the compared poses whose x and y both lie within three standard deviations of the estimate."""
    with errors.open(encoding="utf-8", newline="") as file:
        rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
    inside = [all(abs(row[f"error_{axis}_m"]) <= 3.0 * row[f"sigma_{axis}_m"] for axis in "xy") for row in rows]
    return sum(inside) / len(inside)


def _done(arguments: list[str]) -> None:
    if call([*arguments, "--json"]) != 0:
        raise SystemExit(f"ssjs-cli {' '.join(arguments)} failed")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("source", type=Path)
    parser.add_argument("--landmarks", type=int, default=60)
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3, 4, 5, 6])
    parser.add_argument("--associations", nargs="+", default=["known", "jcbb"])
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for association in arguments.associations:
            rows = [run_once(arguments.source, arguments.landmarks, seed, association, Path(folder)) for seed in arguments.seeds]
            for row in rows:
                _print(row)
            means = {key: statistics.mean(row[key] for row in rows) for key in rows[0] if key not in ("association", "seed")}
            _print({"association": association, "seed": "mean", **means})


def _print(row: dict[str, Any]) -> None:
    texts = (f"{value:.3f}" if isinstance(value, float) else str(value) for value in row.values())
    print("|", " | ".join(f"{key} {text}" for key, text in zip(row, texts, strict=True)), "|", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
