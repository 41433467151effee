"""Pictures of the other side of the vehicle, and pictures smoothed against speckle."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageOps
from side_scan_scenes import Scenes

from ssjs_cli.cascade.smoothing import smoothed

Cli = Callable[..., Any]


def turned(scenes: Scenes, folder: Path) -> Path:
    """The positives seen from the other side, under names of their own."""
    folder.mkdir()
    for path in scenes.positives.iterdir():
        ImageOps.mirror(Image.open(path)).save(folder / f"port_{path.name}")
    return folder


def rows(directory: Path) -> list[list[str]]:
    return [line.split(",") for line in (directory / "detections.csv").read_text().splitlines()[1:]]


def test_mirrored_pictures_hold_the_mirrored_boxes(cli: Cli, scenes: Scenes, trained: Path, tmp_path: Path) -> None:
    port = turned(scenes, tmp_path / "port")
    assert cli("cascade", "detect", trained, scenes.positives, "--no-overlays", "--out", tmp_path / "starboard").code == 0
    assert cli("cascade", "detect", trained, port, "--mirrored", "^port_", "--no-overlays", "--out", tmp_path / "turned").code == 0
    starboard = {(f"port_{name}", x, y, width, height, score) for name, x, y, width, height, score in rows(tmp_path / "starboard")}
    found = {
        (name, str(130 - int(x) - int(width)), y, width, height, score) for name, x, y, width, height, score in rows(tmp_path / "turned")
    }
    # a group is the rounded mean of its boxes, and a margin of odd width lies one pixel more to the right: two pixels are all there is
    assert len(found) == len(starboard) > 40
    for name, *box, score in found:
        assert any(
            name == other[0] and score == other[5] and all(abs(int(a) - int(b)) <= 2 for a, b in zip(box, other[1:5], strict=True))
            for other in starboard
        ), (name, box, sorted(other for other in starboard if other[0] == name))


def test_a_training_on_the_other_side_gives_the_same_cascade(cli: Cli, scenes: Scenes, trained: Path, tmp_path: Path) -> None:
    port, masks, negatives = turned(scenes, tmp_path / "port"), tmp_path / "masks", tmp_path / "negatives"
    for source, target in ((scenes.masks, masks), (scenes.negatives, negatives)):
        target.mkdir()
        for path in source.iterdir():
            ImageOps.mirror(Image.open(path)).save(target / f"port_{path.name}")
    options = [*scenes.options]
    for flag, folder in (("--positives", port), ("--masks", masks), ("--negatives", negatives)):
        options[options.index(flag) + 1] = folder
    command = ("--recordings", r"(line\d\d)", "--mirrored", "^port_", "--no-report", "--out", tmp_path / "model")
    answer = cli("cascade", "train", *options, *command)
    assert answer.code == 0, answer.err
    held = (tmp_path / "model" / "mean_positive.png").read_bytes()
    # windows are resampled from the turned-back picture: the same pixels
    difference = np.asarray(Image.open(tmp_path / "model" / "mean_positive.png")).astype(int)
    difference = difference - np.asarray(Image.open(trained / "mean_positive.png")).astype(int)
    assert held
    assert np.abs(difference).max() <= 12  # a window of odd rest may begin one pixel beside
    assert np.abs(difference).mean() < 4


def test_smoothing_is_the_mean_of_the_surroundings() -> None:
    levels = np.zeros((5, 7), dtype=np.uint8)
    levels[2, 3] = 90
    expected = np.zeros((5, 7))
    expected[1:4, 2:5] = 10
    assert np.array_equal(smoothed(levels, None, 3), expected)
    assert np.array_equal(smoothed(levels, None, 1), levels)


def test_smoothing_belongs_to_the_model(cli: Cli, scenes: Scenes, tmp_path: Path) -> None:
    """Detection smooths as training did, without being told."""
    out = tmp_path / "model"
    assert cli("cascade", "train", *scenes.options, "--set", "image.smoothing_px=3", "--no-report", "--out", out).code == 0
    assert cli("cascade", "detect", out, scenes.positives, "--no-overlays", "--out", tmp_path / "found").code == 0
    smooth = tmp_path / "smooth"
    smooth.mkdir()
    for path in scenes.positives.iterdir():
        Image.fromarray(smoothed(np.asarray(Image.open(path)), None, 3)).save(smooth / path.name)
    # the XML form does not know of it, so that smoothed pictures give the same windows
    assert cli("cascade", "detect", out / "cascade.xml", smooth, "--no-overlays", "--out", tmp_path / "xml").code == 0
    assert [row[5] for row in rows(tmp_path / "found")] == [row[5] for row in rows(tmp_path / "xml")]
    even = cli("cascade", "train", *scenes.options, "--set", "image.smoothing_px=4", "--out", tmp_path / "even")
    assert even.code == 2
    assert "image.smoothing_px = 4: must be odd" in even.err
