"""The sonar loop found in pictures: two thresholds, three methods, several seeds. docs/paper_chain.md

    PYTHONPATH=python python benchmarks/paper_chain.py --seeds 1-10 [--out rows.csv]
    PYTHONPATH=python python benchmarks/paper_chain.py --tables        # the source's two tables, taken apart

Errors of landmarks: distances between each of the 54 and the one on the map that it is paired with (one to one, within 3 m, the least
sum of squares over everything that can be on the map), as it stands, and after the one turn and shift of the map that fits best.
"""

import argparse
import csv
import json
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from ssjs_cli.app import call

Points = NDArray[np.float64]
THRESHOLDS = ("improved-otsu", "max-entropy")
METHODS = ("aekf", "ekf", "ssjs")
LANDMARKS, QUOTED = 54, 8
PAIRED_WITHIN_M = 3.0

# Tables 10 and 11 of the source: true x, y and estimated x, y in metres.
TABLE_10 = np.array(
    [
        [53.5, 60.3, 53.66, 60.23], [54.23, 65.39, 54.31, 65.32], [18.73, -11.56, 18.8, -11.49], [-94.98, -66.29, -94.99, -66.35],
        [-96.69, -66.06, -96.67, -66.12], [-102.12, -61.57, -102.2, -61.59], [-102.41, -70.3, -102.4, -70.34],
        [-106.55, -81.13, -106.4, -81.44],
    ]
)  # fmt: skip
TABLE_11 = np.array(
    [
        [53.61, 60.18, 54.24, 59.12], [54.22, 65.4, 54.96, 64.35], [18.75, -11.55, 18.62, -11.69], [-99.23, -67.7, -100.1, -65.82],
        [-97.59, -72.08, -98.58, -70.23],
    ]
)  # fmt: skip


def fitted(estimated: Points, true: Points) -> tuple[Points, float]:
    """The estimated points turned and shifted onto the true ones with least squares, and the turn."""
    about, onto = estimated.mean(axis=0), true.mean(axis=0)
    e, t = estimated - about, true - onto
    turn = float(np.arctan2(np.sum(e[:, 0] * t[:, 1] - e[:, 1] * t[:, 0]), np.sum(e * t)))
    c, s = np.cos(turn), np.sin(turn)
    return e @ np.array([[c, s], [-s, c]]) + onto, turn


def distances(a: Points, b: Points) -> Points:
    return np.asarray(np.linalg.norm(a - b, axis=1))


def table_text(name: str, table: Points) -> str:
    true, estimated = table[:, :2], table[:, 2:]
    best, turn = fitted(estimated, true)
    return (
        f"{name}: mean distance {distances(true, estimated).mean():.3f} m, after a turn of {np.degrees(turn):+.2f} deg and a shift "
        f"{distances(true, best).mean():.3f} m"
    )


def read_points(path: Path, columns: tuple[str, ...]) -> Points:
    with path.open(encoding="utf-8") as file:
        return np.array([[float(row[name]) for name in columns] for row in csv.DictReader(file)]).reshape(-1, len(columns))


def pairs_of(true: Points, mapped: Points) -> list[tuple[int, int]]:
    squared = np.sum((true[:, None] - mapped[None]) ** 2, axis=2)
    rows, columns = linear_sum_assignment(np.minimum(squared, PAIRED_WITHIN_M**2))
    return [(int(r), int(c)) for r, c in zip(rows, columns, strict=True) if squared[r, c] < PAIRED_WITHIN_M**2]


def row_of(mission: Path, run: Path) -> dict[str, Any]:
    summary: Mapping[str, Any] = json.loads((run / "summary.json").read_text(encoding="utf-8"))
    truth = read_points(mission / "truth_landmarks.csv", ("id", "x_m", "y_m"))
    mapped = read_points(run / "landmarks.csv", ("x_m", "y_m"))
    pairs = pairs_of(truth[:, 1:], mapped)
    ours = [(r, c) for r, c in pairs if truth[r, 0] < LANDMARKS]
    quoted = [(r, c) for r, c in ours if truth[r, 0] < QUOTED]
    true, estimated = truth[[r for r, _ in ours], 1:], mapped[[c for _, c in ours]]
    best, turn = fitted(estimated, true)
    quoted_error = distances(truth[[r for r, _ in quoted], 1:], mapped[[c for _, c in quoted]])
    return {
        "on_map": len(mapped),
        "landmarks": len(ours),
        "spots": len(pairs) - len(ours),
        "of_nothing_or_twice": len(mapped) - len(pairs),
        "landmark_error_m": distances(true, estimated).mean(),
        "quoted_error_m": quoted_error.mean() if len(quoted_error) else np.nan,
        "turn_deg": abs(np.degrees(turn)),
        "fitted_error_m": distances(true, best).mean(),
        "trajectory_rmse_m": summary["trajectory_rmse_m"],
        "dead_reckoning_m": summary["dead_reckoning_rmse_m"],
        "pose_nees": summary["nees_mean"],
        "nis": summary["nis_mean"],
        "wrong_pairs": summary["scan_wrong_pairs"],
        "observations": summary["observations"],
        "time_s": summary["time_total_s"],
    }


def rows_of(seed: int, folder: Path, methods: list[str], assignments: list[str]) -> list[dict[str, Any]]:
    rows = []
    sets = [part for assignment in assignments for part in ("--set", assignment)]
    for threshold in (*THRESHOLDS, "points"):
        mission = folder / f"{threshold}-{seed}"
        scenario = ["aekf-loop"] if threshold == "points" else ["aekf-loop-images", "--set", f"segmentation.method={threshold}"]
        call(["simulate", *scenario, "--seed", str(seed), "--out", str(mission), "--json"])
        for method in methods:
            run = folder / f"{threshold}-{seed}-{method}"
            call(["run", str(mission), "--method", method, "--out", str(run), "--no-report", "--json", *sets])
            rows.append({"threshold": threshold, "method": method, "seed": seed, **row_of(mission, run)})
    return rows


def show(rows: list[dict[str, Any]]) -> None:
    for threshold in (*THRESHOLDS, "points"):
        for method in METHODS:
            mine = [row for row in rows if row["threshold"] == threshold and row["method"] == method]
            if not mine:
                continue
            print(f"{threshold}, {method}: {len(mine)} seeds")
            for key in list(mine[0])[3:]:
                values = np.array([float(row[key]) for row in mine])
                print(f"  {key:22} mean {values.mean():9.3f}  median {np.median(values):9.3f}  {values.min():9.3f} to {values.max():9.3f}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default="1-10")
    parser.add_argument("--methods", default=",".join(METHODS))
    parser.add_argument("--set", action="append", default=[], dest="assignments", help="key=value of the runs")
    parser.add_argument("--out", type=Path, help="a CSV with one row a run; with --read: is read instead")
    parser.add_argument("--read", action="store_true")
    parser.add_argument("--tables", action="store_true")
    given = parser.parse_args()
    if given.tables:
        print(table_text("table 10, improved Otsu", TABLE_10), table_text("table 11, maximum entropy", TABLE_11), sep="\n")
        return
    if given.read:
        with given.out.open(encoding="utf-8") as file:
            show(list(csv.DictReader(file)))
        return
    first, last = (int(text) for text in given.seeds.split("-"))
    rows: list[dict[str, Any]] = []
    for seed in range(first, last + 1):
        with tempfile.TemporaryDirectory() as folder:
            rows += rows_of(seed, Path(folder), given.methods.split(","), given.assignments)
        if given.out is not None:
            with given.out.open("w", encoding="utf-8", newline="") as file:
                writer = csv.DictWriter(file, list(rows[0]))
                writer.writeheader()
                writer.writerows(rows)
    show(rows)


if __name__ == "__main__":
    main()
