"""Real sonar images through the command line: what docs/segmentation.md promises of the improved Otsu chain."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from scipy import ndimage

Cli = Callable[..., Any]
DataSet = Callable[[str], Path]
#: The paper's chain without a filter, its spots as for side-scan pictures of low resolution.
RAW = ("--set", "segmentation.improved_otsu.spot_px=15")
#: Chosen on half of the recordings, docs/segmentation.md.
FILTERED = (
    *("--padding", 0, "--set", "segmentation.filter.kind=gaussian", "--set", "segmentation.filter.sigma_px=2.5"),
    *(
        "--set",
        "segmentation.gain.kind=local_mean",
        "--set",
        "segmentation.gain.window_px=51",
        "--set",
        "segmentation.gain.target_level=40",
    ),
    *("--set", "segmentation.improved_otsu.spot_px=15", "--set", "segmentation.dilations=3"),
)
WALL_CLASS, FIRST_CLASS, LAST_CLASS = 11, 1, 10
SMALLEST_OBJECT_PX = 100


def compared(cli: Cli, out: Path, *arguments: object) -> dict[str, dict[str, Any]]:
    answer = cli("segment-compare", *arguments, "--repeat", 1, "--no-report", "--out", out, "--json")
    assert answer.code == 0, answer.err
    return {row["method"]: row for row in json.loads(answer.out)["methods"]}


def test_side_scan_tiles_one_filtered_chain(cli: Cli, data_set: DataSet, tmp_path: Path) -> None:
    folder = data_set("sdvd")
    rows = compared(cli, tmp_path / "out", folder / "images", "--masks", folder / "masks", "--one-object", *FILTERED)
    improved = rows["improved-otsu"]
    assert improved["objects"] == improved["images"] == 142
    assert improved["hit_rate"] >= 0.60
    assert improved["recall"] >= 0.75
    assert improved["hit_rate"] >= rows["otsu"]["hit_rate"] + 0.10


def test_side_scan_tiles_the_papers_chain(cli: Cli, data_set: DataSet, tmp_path: Path) -> None:
    folder = data_set("sdvd")
    rows = compared(cli, tmp_path / "out", folder / "images", "--masks", folder / "masks", "--one-object", *RAW)
    assert rows["improved-otsu"]["hit_rate"] == pytest.approx(0.6, abs=0.07)
    assert rows["improved-otsu"]["recall"] == pytest.approx(0.6, abs=0.07)


def test_the_best_preset_beats_the_filtered_chain(cli: Cli, data_set: DataSet, tmp_path: Path) -> None:
    """By hit rate x (1 - false area)."""
    folder = data_set("sdvd")
    tiles = (folder / "images", "--masks", folder / "masks", "--one-object")
    best = compared(cli, tmp_path / "best", *tiles, "--padding", 0, "--preset", "best")
    chosen = best["local"]
    filtered = compared(cli, tmp_path / "filtered", *tiles, *FILTERED)["improved-otsu"]
    assert chosen["hit_rate"] * (1 - chosen["false_area_fraction"]) > filtered["hit_rate"] * (1 - filtered["false_area_fraction"])
    assert chosen["hit_rate"] * (1 - chosen["false_area_fraction"]) >= 0.80


def test_tiles_without_objects(cli: Cli, data_set: DataSet, tmp_path: Path) -> None:
    """The paper's chain marks less of an empty seabed than maximum entropy."""
    rows = compared(cli, tmp_path / "out", data_set("sdvd") / "negatives", "--no-objects", *RAW)
    assert rows["improved-otsu"]["images"] == 57
    assert rows["improved-otsu"]["false_area_fraction"] <= 0.6 * rows["max-entropy"]["false_area_fraction"]


def test_forward_looking_frames(cli: Cli, data_set: DataSet, tmp_path: Path) -> None:
    """Walls and what lies outside of the fan are masked; objects of more than 100 pixels count."""
    folder = data_set("marine_debris_fls")
    frames = sorted((folder / "images").glob("*.png"))
    fan = ndimage.binary_fill_holes(np.max([np.asarray(Image.open(path)) for path in frames], axis=0) > 0)
    for name in ("valid", "objects"):
        (tmp_path / name).mkdir()
    for path in frames:
        classes = np.asarray(Image.open(folder / "masks" / path.name))
        valid = fan & (classes != WALL_CLASS)
        labels, count = ndimage.label((classes >= FIRST_CLASS) & (classes <= LAST_CLASS), structure=np.ones((3, 3)))
        sizes = ndimage.sum_labels(np.ones_like(labels), labels, range(1, count + 1))
        objects = np.isin(labels, 1 + np.flatnonzero(np.asarray(sizes) > SMALLEST_OBJECT_PX))
        Image.fromarray(np.where(valid, 255, 0).astype(np.uint8)).save(tmp_path / "valid" / path.name)
        Image.fromarray(np.where(objects, 255, 0).astype(np.uint8)).save(tmp_path / "objects" / path.name)
    rows = compared(
        cli, tmp_path / "out", folder / "images", "--masks", tmp_path / "objects", "--mask", tmp_path / "valid",
        "--set", "segmentation.improved_otsu.spot_px=40", "--set", "segmentation.gain.kind=local_mean",
    )  # fmt: skip
    assert rows["improved-otsu"]["objects"] > 120
    assert rows["improved-otsu"]["hit_rate"] >= 0.45
    assert rows["improved-otsu"]["centroid_error_px_median"] <= 18
