"""Waterfall pictures with both sides of the sonar: port is seen mirrored."""

import csv
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from side_scan_scenes import Scenes

Cli = Callable[..., Any]
Row = tuple[int, int, int, int, float]


def rows(directory: Path) -> list[dict[str, str]]:
    with (directory / "detections.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def boxes(found: list[dict[str, str]], image: str) -> list[Row]:
    keys = ("x_px", "y_px", "width_px", "height_px")
    made = [(*(int(row[key]) for key in keys), float(row["score"])) for row in found if row["image"] == image]
    return sorted(made)  # type: ignore[arg-type]


def waterfall(starboard: Path, port: Path, target: Path) -> None:
    """Two pictures with shadows to the right as the two sides of one."""
    sides = [np.asarray(Image.open(path)) for path in (port, starboard)]
    Image.fromarray(np.concatenate([sides[0][:, ::-1], sides[1]], axis=1)).save(target)


@pytest.fixture
def symmetric(scenes: Scenes, tmp_path: Path) -> Path:
    folder = tmp_path / "waterfall"
    folder.mkdir()
    for path in sorted(scenes.positives.iterdir())[:8]:
        waterfall(path, path, folder / path.name)
    return folder


def test_a_symmetric_picture_has_symmetric_boxes(cli: Cli, scenes: Scenes, trained: Path, symmetric: Path, tmp_path: Path) -> None:
    """130 columns a side: starboard is what the picture alone has, port its mirror image, to the last pixel."""
    assert cli("cascade", "detect", trained, scenes.positives, "--no-overlays", "--out", tmp_path / "alone").code == 0
    command = ("cascade", "detect", trained, symmetric, "--nadir", "middle", "--no-overlays")
    assert cli(*command, "--out", tmp_path / "both").code == 0
    alone, both = rows(tmp_path / "alone"), rows(tmp_path / "both")
    assert list(both[0])[6:] == ["side"]
    total = 0
    for path in symmetric.iterdir():
        expected = boxes(alone, path.name)
        total += len(expected)
        starboard = boxes([row for row in both if row["side"] == "starboard"], path.name)
        port = boxes([row for row in both if row["side"] == "port"], path.name)
        assert [(x - 130, *rest) for x, *rest in starboard] == expected
        assert sorted((130 - x - width, y, width, height, score) for x, y, width, height, score in port) == expected
    assert total > 12
    scores = [float(row["score"]) for row in both if row["image"] == both[0]["image"]]
    assert scores == sorted(scores, reverse=True)


def test_any_number_of_workers_gives_the_same_bytes(cli: Cli, trained: Path, symmetric: Path, tmp_path: Path) -> None:
    for jobs in ("1", "3"):
        assert cli("cascade", "detect", trained, symmetric, "--nadir", "middle", "--jobs", jobs, "--out", tmp_path / jobs).code == 0
    for name in ("detections.csv", "detections.json", "config.toml"):
        assert (tmp_path / "1" / name).read_bytes() == (tmp_path / "3" / name).read_bytes()


def test_the_nadir_is_where_it_is_said_to_be(cli: Cli, scenes: Scenes, trained: Path, tmp_path: Path) -> None:
    """130 columns of starboard right of 90 of port: boxes of port are those of its picture alone, mirrored."""
    one, other = sorted(scenes.positives.iterdir())[:2]
    narrow = tmp_path / "narrow.png"
    Image.open(other).crop((0, 0, 90, 100)).save(narrow)
    picture = tmp_path / "line.png"
    waterfall(one, narrow, picture)
    for name, image, options in (("both", picture, ["--nadir", "90"]), ("port", narrow, []), ("starboard", one, [])):
        assert cli("cascade", "detect", trained, image, *options, "--no-overlays", "--out", tmp_path / name).code == 0
    both = boxes(rows(tmp_path / "both"), "line.png")
    expected = [(90 - x - w, y, w, h, score) for x, y, w, h, score in boxes(rows(tmp_path / "port"), "narrow.png")]
    expected += [(x + 90, y, w, h, score) for x, y, w, h, score in boxes(rows(tmp_path / "starboard"), one.name)]
    assert len(expected) >= 3
    assert both == sorted(expected)


def test_a_nadir_at_the_border_leaves_one_side(cli: Cli, scenes: Scenes, trained: Path, tmp_path: Path) -> None:
    cases = {"plain": [], "left": ["--nadir", "left"], "mirrored": ["--mirrored", "."], "right": ["--nadir", "right"]}
    for name, options in cases.items():
        assert cli("cascade", "detect", trained, scenes.positives, *options, "--no-overlays", "--out", tmp_path / name).code == 0
    for one, other in (("plain", "left"), ("mirrored", "right")):
        held = [[row[key] for key in ("image", "x_px", "y_px", "score")] for row in rows(tmp_path / one)]
        assert held == [[row[key] for key in ("image", "x_px", "y_px", "score")] for row in rows(tmp_path / other)]
    assert rows(tmp_path / "plain") != rows(tmp_path / "mirrored")


@pytest.mark.parametrize(
    ("value", "complaint"),
    [("300", "has 130 columns, and --nadir 300 lies outside"), ("top", "--nadir top: must be left, middle, right"), ("-3", "must not be")],
)
def test_a_nadir_that_cannot_be_is_named(cli: Cli, scenes: Scenes, trained: Path, tmp_path: Path, value: str, complaint: str) -> None:
    answer = cli("cascade", "detect", trained, scenes.positives, "--nadir", value, "--out", tmp_path / "out")
    assert answer.code == 2
    assert complaint in answer.err


def test_an_evaluation_counts_both_sides(cli: Cli, scenes: Scenes, trained: Path, symmetric: Path, tmp_path: Path) -> None:
    """Each object is there twice, and found on both sides or on none."""
    for source, target in ((scenes.masks, tmp_path / "masks"), (scenes.positives, tmp_path / "alone")):
        target.mkdir()
        for path in symmetric.iterdir():
            if source is scenes.masks:
                waterfall(source / path.name, source / path.name, target / path.name)
            else:
                Image.open(source / path.name).save(target / path.name)
    evaluate = ("cascade", "evaluate", trained)
    options = ("--no-report", "--set", "evaluation.bootstrap=0")
    assert cli(*evaluate, symmetric, "--masks", tmp_path / "masks", "--nadir", "middle", *options, "--out", tmp_path / "two").code == 0
    assert cli(*evaluate, tmp_path / "alone", "--masks", scenes.masks, *options, "--out", tmp_path / "one").code == 0
    two, one = (json.loads((tmp_path / name / "evaluation.json").read_text()) for name in ("two", "one"))
    assert two["totals"]["objects"] == 2 * one["totals"]["objects"] == 32
    assert two["totals"]["found"] == 2 * one["totals"]["found"] > 20
    assert two["totals"]["false_boxes"] == 2 * one["totals"]["false_boxes"]
    assert [layer["detection_rate"] for layer in two["layers"]] == [layer["detection_rate"] for layer in one["layers"]]
