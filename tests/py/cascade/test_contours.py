"""Detections looked at once more: the contour of the echo against those of the objects trained on."""

import csv
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from side_scan_scenes import Scenes

from ssjs_cli import _core

Cli = Callable[..., Any]


def table(directory: Path) -> list[dict[str, str]]:
    with (directory / "detections.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_a_training_keeps_the_contours_of_its_objects(cli: Cli, trained: Path, scenes: Scenes, tmp_path: Path) -> None:
    model = json.loads((trained / "cascade.json").read_text())
    assert len(model["contour"]["mean"]) == 16
    assert len(model["contour"]["distances"]) == 48  # every labelled object shows an echo
    assert json.loads((trained / "training.json").read_text())["totals"]["contours"] == 48
    answer = cli("cascade", "train", *scenes.options, "--set", "contour.learn=false", "--no-report", "--out", tmp_path / "without")
    assert answer.code == 0, answer.err
    assert "contour" not in json.loads((tmp_path / "without" / "cascade.json").read_text())
    refused = cli("cascade", "detect", tmp_path / "without", scenes.positives, "--verify", "contour", "--out", tmp_path / "out")
    assert refused.code == 2
    assert "holds no contours to verify detections with" in refused.err


def test_detections_carry_distance_and_score_of_their_contour(cli: Cli, trained: Path, scenes: Scenes, tmp_path: Path) -> None:
    command = ("cascade", "detect", trained, scenes.positives, "--no-overlays")
    assert cli(*command, "--out", tmp_path / "plain").code == 0
    verify = ("--verify", "contour", "--set")
    assert cli(*command, *verify, "detector.min_contour_score=0", "--out", tmp_path / "told").code == 0
    assert cli(*command, *verify, "detector.min_contour_score=0.3", "--out", tmp_path / "kept").code == 0
    plain, told, kept = (table(tmp_path / name) for name in ("plain", "told", "kept"))
    assert list(told[0]) == ["image", "x_px", "y_px", "width_px", "height_px", "score", "contour_distance", "contour_score"]
    assert [{key: row[key] for key in plain[0]} for row in told] == plain
    assert kept == [row for row in told if float(row["contour_score"]) >= 0.3]
    assert 0 < len(kept) < len(told)
    # a greater distance never scores better
    ordered = sorted(told, key=lambda row: float(row["contour_distance"]))
    scores = [float(row["contour_score"]) for row in ordered]
    assert scores == sorted(scores, reverse=True)


def test_an_evaluation_scores_what_is_left(cli: Cli, trained: Path, scenes: Scenes, tmp_path: Path) -> None:
    command = ("cascade", "evaluate", trained, scenes.positives, "--masks", scenes.masks, "--no-report", "--set", "evaluation.bootstrap=0")
    assert cli(*command, "--verify", "contour", "--out", tmp_path / "verified").code == 0
    rows = table(tmp_path / "verified")
    assert list(rows[0])[5:] == ["score", "outcome", "contour_distance", "contour_score"]
    assert all(float(row["contour_score"]) >= 0.05 for row in rows)
    totals = json.loads((tmp_path / "verified" / "evaluation.json").read_text())["totals"]
    assert totals["found"] == sum(row["outcome"] == "found" for row in rows)


def test_models_of_other_programs_know_no_contours(cli: Cli, trained: Path, scenes: Scenes, tmp_path: Path) -> None:
    answer = cli("cascade", "detect", trained / "cascade.xml", scenes.positives, "--verify", "contour", "--out", tmp_path / "out")
    assert answer.code == 2
    assert "cascade.xml: holds no contours" in answer.err
    wrong = cli("cascade", "detect", trained, scenes.positives, "--verify", "shape", "--out", tmp_path / "out")
    assert wrong.code == 2
    assert "must be one of none, contour" in wrong.err


def discs_and_bars(seed: int, kind: str, count: int) -> list[np.ndarray]:
    """Echoes of one area in speckle, 40 x 40: discs, or bars in any direction."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:40, :40] - 19.5
    windows = []
    for _ in range(count):
        angle = rng.uniform(0, np.pi)
        along, across = x * np.cos(angle) + y * np.sin(angle), y * np.cos(angle) - x * np.sin(angle)
        inside = np.hypot(x, y) < 9 if kind == "disc" else (np.abs(along) < 16) & (np.abs(across) < 4)
        windows.append(np.clip(60 * rng.gamma(6, 1 / 6, (40, 40)) * np.where(inside, 3, 1), 0, 255).astype(np.uint8))
    return windows


def test_shapes_of_equal_size_are_told_apart(scenes: Scenes, trained: Path) -> None:
    """A cascade that passes every window, so that the contour alone decides."""
    everything = _core.HaarCascade.load(str(trained / "cascade.json"))
    document = json.loads(everything.to_json())
    for stage in document["stages"]:
        stage["threshold"] = -1e6
    spectra = [_core.echo_signature(window, (0, 0, 40, 40)) for window in discs_and_bars(1, "disc", 60)]
    model = _core.HaarCascade.from_json(json.dumps(document)).with_contours([found[1] for found in spectra if found is not None])
    assert model.contours_known == 60
    # 40 px is the whole window at the last scale of 12 px by 10/3
    config = {"verify": "contour", "min_neighbours": 0, "min_width_px": 40, "max_width_px": 40, "scale_factor": 10 / 3}
    kept = {
        kind: sum(len(_core.detect_objects(model, window, None, config)) for window in discs_and_bars(2, kind, 100))
        for kind in ("disc", "bar")
    }
    assert kept["disc"] >= 88  # a twentieth is expected to be refused, with a deviation of two and a half
    assert kept["bar"] <= 5
