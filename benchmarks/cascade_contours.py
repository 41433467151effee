"""What the contour of the echo adds to a cascade on simulated side-scan pictures: round objects, and false boxes of two kinds.

    PYTHONPATH=python python benchmarks/cascade_contours.py

A cascade learns discs with a shadow against seabed. It is then evaluated, with and without --verify contour, on pictures that hold
discs, bars of the same area with the same shadow, which it has never seen, and rocks: small echoes without shadow.
"""

import argparse
import csv
import json
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from ssjs_cli.app import call

HEIGHT_PX, WIDTH_PX, CELL_PX = 128, 256, 64
PLAN = ((0.99, 0.5, 2), (0.985, 0.2, 4), (0.98, 0.05, 10), (0.97, 0.01, 20))
SETTINGS = (
    "training.feature_set=side_scan_basic",
    "training.max_asymmetry=1",
    "training.negatives_per_layer=1000",
    "augmentation.copies=3",
)
SCORES = (0.02, 0.05, 0.1, 0.2)

Picture = NDArray[np.float64]


def echo_of(kind: str, rng: np.random.Generator, radius: float) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Echo and shadow in a cell."""
    y, x = np.mgrid[:CELL_PX, :CELL_PX] - CELL_PX / 2.0
    x = x + 8
    if kind == "disc":
        echo = np.hypot(x, y) < radius
    elif kind == "bar":
        angle = rng.uniform(0, np.pi)
        along, across = x * np.cos(angle) + y * np.sin(angle), y * np.cos(angle) - x * np.sin(angle)
        length = 2 * radius
        echo = (np.abs(along) < length) & (np.abs(across) < np.pi * radius**2 / (4 * length))
    else:
        echo = np.hypot(x, y) < 0.5 * radius
    shadow = np.zeros_like(echo)
    if kind != "rock":
        for shift in range(1, round(2 * radius)):
            shadow[:, shift:] |= echo[:, :-shift]
    return echo, shadow & ~echo


def make_pictures(folder: Path, count: int, seed: int, kinds: tuple[str, ...]) -> None:
    rng = np.random.default_rng(seed)
    for name in ("images", "masks"):
        (folder / name).mkdir(parents=True)
    for index in range(count):
        levels, mask = 60 * rng.gamma(4.0, 1.0 / 4.0, (HEIGHT_PX, WIDTH_PX)), np.zeros((HEIGHT_PX, WIDTH_PX), dtype=np.uint8)
        for top in range(0, HEIGHT_PX, CELL_PX):
            for left in range(0, WIDTH_PX, CELL_PX):
                kind = kinds[int(rng.integers(0, len(kinds)))]
                if kind == "nothing":
                    continue
                echo, shadow = echo_of(kind, rng, rng.uniform(6, 11))
                cell = (slice(top, top + CELL_PX), slice(left, left + CELL_PX))
                levels[cell] *= np.where(echo, rng.uniform(2, 3.2), np.where(shadow, rng.uniform(0.2, 0.5), 1.0))
                if kind == "disc":
                    mask[cell][echo | shadow] = 255
        Image.fromarray(np.clip(levels, 0, 255).astype(np.uint8)).save(folder / "images" / f"{index:03d}.png")
        Image.fromarray(mask).save(folder / "masks" / f"{index:03d}.png")


def evaluated(folder: Path, name: str, *options: str) -> dict[str, float]:
    test = folder / "test"
    command = ["cascade", "evaluate", str(folder / "model"), str(test / "images"), "--masks", str(test / "masks"), "--no-report"]
    if call([*command, "--set", "evaluation.bootstrap=0", *options, "--out", str(folder / name)]) != 0:
        raise SystemExit(f"the evaluation {name} failed")
    document = json.loads((folder / name / "evaluation.json").read_text())
    with (folder / name / "detections.csv").open(newline="") as file:
        assert sum(1 for _ in csv.DictReader(file)) == document["totals"]["found"] + document["totals"]["false_boxes"]
    return {**{key: document["totals"][key] for key in ("objects", "found", "false_boxes")}, **document["rates"]}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pictures", type=int, default=60, help="to train on, and as many to evaluate on")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        make_pictures(folder / "train", arguments.pictures, 1, ("disc", "nothing"))
        make_pictures(folder / "seabed", arguments.pictures // 2, 2, ("nothing", "rock"))
        make_pictures(folder / "test", arguments.pictures, 3, ("disc", "bar", "rock", "nothing"))
        plan = "".join(f"[[layer]]\ndetection_rate = {d}\nfalse_positive_rate = {f}\nmax_features = {n}\n" for d, f, n in PLAN)
        (folder / "plan.toml").write_text(plan)
        train = ["cascade", "train", "--positives", str(folder / "train" / "images"), "--masks", str(folder / "train" / "masks")]
        train += ["--negatives", str(folder / "seabed" / "images"), "--plan", str(folder / "plan.toml"), "--no-report"]
        for setting in SETTINGS:
            train += ["--set", setting]
        if call([*train, "--out", str(folder / "model")]) != 0:
            raise SystemExit("the training failed")
        results = {"none": evaluated(folder, "none")}
        for score in SCORES:
            verify = ("--verify", "contour", "--set", f"detector.min_contour_score={score}")
            results[str(score)] = evaluated(folder, str(score), *verify)
    for verified, rates in results.items():
        print(verified, json.dumps(rates))


if __name__ == "__main__":
    main()
