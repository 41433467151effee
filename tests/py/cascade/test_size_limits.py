"""Objects between sizes in metres."""

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from side_scan_scenes import Scenes

from ssjs_cli.cascade.settings import DETECTION
from ssjs_cli.cascade.size_limits import in_pixels
from ssjs_cli.cascade.window_boxes import object_length
from ssjs_cli.config import defaults

Cli = Callable[..., Any]


@pytest.mark.parametrize("margin", [0.0, 0.1, 0.37, 2.0])
@pytest.mark.parametrize(("least_m", "most_m", "pixel_m"), [(0.3, 0.9, 0.1), (2.0, 2.0, 0.5), (1.0, 7.3, 0.26), (0.01, 3.0, 0.7)])
def test_windows_are_those_whose_objects_keep_to_the_limits(margin: float, least_m: float, most_m: float, pixel_m: float) -> None:
    values = {
        **defaults(DETECTION), "image.pixel_across_m": pixel_m, "image.pixel_along_m": 9.0,
        "detector.min_width_m": least_m, "detector.max_width_m": most_m,
    }  # fmt: skip
    found = in_pixels(values, margin)
    kept = [
        window for window in range(1, 200)
        if least_m * (1 - 1e-9) <= object_length(window, margin) * pixel_m <= most_m * (1 + 1e-9)
    ]  # fmt: skip
    assert kept == list(range(int(found["min_width_px"] or 0), int(found["max_width_px"] or 0) + 1))
    assert found["min_height_px"] is None
    assert not any(key.endswith("_m") for key in found)


def test_huge_limits_are_limits_all_the_same() -> None:
    values = {
        **defaults(DETECTION), "image.pixel_across_m": 0.001, "image.pixel_along_m": 0.001,
        "detector.min_width_m": 1e300, "detector.max_height_m": 1e300,
    }  # fmt: skip
    found = in_pixels(values, 0.1)
    assert 1_000_000 <= int(found["min_width_px"] or 0) <= 2**31 - 1
    assert 1_000_000 <= int(found["max_height_px"] or 0) <= 2**31 - 1


def table(directory: Path) -> list[dict[str, str]]:
    with (directory / "detections.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_detections_keep_to_metres_and_are_told_in_metres(cli: Cli, scenes: Scenes, trained: Path, tmp_path: Path) -> None:
    command = ("cascade", "detect", trained, scenes.positives, "--no-overlays", "--pixel-size-m", "0.2,0.1")
    assert cli(*command, "--out", tmp_path / "all").code == 0
    everything = table(tmp_path / "all")
    assert list(everything[0]) == ["image", "x_px", "y_px", "width_px", "height_px", "score", "width_m", "height_m"]
    for row in everything:
        assert float(row["width_m"]) == pytest.approx(0.1 * int(row["width_px"]), abs=1e-9)
        assert float(row["height_m"]) == pytest.approx(0.2 * int(row["height_px"]), abs=1e-9)
    limits = ("--set", "detector.min_width_m=2.0", "--set", "detector.max_height_m=4.6")
    assert cli(*command, *limits, "--out", tmp_path / "some").code == 0
    some = table(tmp_path / "some")
    assert 0 < len(some) < len(everything)
    assert min(float(row["width_m"]) for row in everything) < 2.0
    assert max(float(row["height_m"]) for row in everything) > 4.6
    for row in some:
        assert float(row["width_m"]) >= 2.0
        assert float(row["height_m"]) <= 4.6
    # the same windows said in pixels: 20 px and more wide, 23 px and less high without their margin of a tenth on each side
    pixels = ("--set", "detector.min_width_px=24", "--set", "detector.max_height_px=28")
    assert cli(*command, *pixels, "--out", tmp_path / "pixels").code == 0
    assert table(tmp_path / "pixels") == some


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        (["detector.min_width_m=2"], "detector.min_width_m = 2.0: metres need the size of a pixel; give --pixel-size-m ALONG,ACROSS"),
        (["detector.max_height_m=-1", "--pixel"], "detector.max_height_m = -1.0: must be positive"),
        (["detector.max_height_m=nan", "--pixel"], "detector.max_height_m = nan: must be positive"),
        (["detector.max_width_m=0.05", "--pixel"], "detector.max_width_m = 0.05: is less than one pixel of 0.1 m"),
        (["detector.min_width_m=3", "detector.max_width_m=2", "--pixel"], "detector.min_width_m = 3.0: must not be greater than"),
        (["detector.min_width_m=3", "detector.min_width_px=20", "--pixel"], "detector.min_width_m: is given in pixels, too"),
        (["image.pixel_along_m=0.1"], "image.pixel_along_m and image.pixel_across_m: are given together or not at all"),
    ],
)
def test_limits_that_cannot_be_are_named(
    cli: Cli, scenes: Scenes, trained: Path, tmp_path: Path, options: list[str], complaint: str
) -> None:
    command = ["cascade", "detect", trained, scenes.positives, "--out", tmp_path / "out"]
    for option in options:
        command += ["--pixel-size-m", "0.2,0.1"] if option == "--pixel" else ["--set", option]
    answer = cli(*command)
    assert answer.code == 2
    assert complaint in answer.err
