import csv
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from ssjs_cli.segmentation.comparison import IMAGE_KEYS, KEYS, method_row
from ssjs_cli.segmentation.one_comparison import METHODS

Cli = Callable[..., Any]
Folder = Callable[..., Path]
CONTRACT = (
    "method", "threshold_median", "time_ms_median", "hit_rate", "recall", "fpr", "ppv", "centroid_error_px_median",
    "false_regions_per_image",
)  # fmt: skip


def rows_of(answer: Any) -> dict[str, dict[str, Any]]:
    document = json.loads(answer.out)
    assert [row["method"] for row in document["methods"]] == list(METHODS)
    for row in document["methods"]:
        assert set(CONTRACT) <= set(row)
        assert tuple(row) == KEYS
    return {row["method"]: row for row in document["methods"]}


def test_on_clear_scenes_every_method_that_can_is_right(cli: Cli, scene_folder: Folder, tmp_path: Path) -> None:
    folder = scene_folder(4)
    answer = cli("segment-compare", folder, "--masks", folder / "masks", "--out", tmp_path / "out", "--json")
    assert answer.code == 0, answer.err
    rows = rows_of(answer)
    for method in ("improved-otsu", "otsu", "iterative"):
        row = rows[method]
        assert (row["hit_rate"], row["recall"], row["ppv"], row["false_regions_per_image"]) == (1.0, 1.0, 1.0, 0.0)
        assert row["fpr"] in (None, 0.0)
        assert row["centroid_error_px_median"] < 0.5
        assert row["objects"] == row["images"] == 4
    assert rows["local"]["threshold_median"] is None
    assert all(row["time_ms_median"] > 0 and row["chain_time_ms_median"] > 0 for row in rows.values())
    with (tmp_path / "out" / "images.csv").open(newline="") as file:
        images = list(csv.DictReader(file))
    assert tuple(images[0]) == IMAGE_KEYS
    assert len(images) == 4 * len(METHODS)
    assert {"comparison.json", "comparison.csv", "config.toml", "images.csv", "report.html"} == {
        entry.name for entry in (tmp_path / "out").iterdir()
    }


def test_counts_add_up_by_hand() -> None:
    """Two images: 2 of 3 objects hit, 3 true and 2 false regions, 1 missed, 8 candidates rightly left out."""
    shared = {"threshold": 10, "second_pass_fired": None, "regions": 2, "time_ms": 1.0, "chain_time_ms": 2.0}
    first = {
        **shared, "method": "otsu", "objects": 2, "hits": 1, "true_positives": 2, "false_positives": 0, "false_negatives": 1,
        "true_negatives": 3, "pixel_recall": 0.5, "mask_iou": 0.4, "false_area_fraction": 0.0,
    }  # fmt: skip
    second = {
        **first, "threshold": 30, "objects": 1, "hits": 1, "true_positives": 1, "false_positives": 2, "false_negatives": 0,
        "true_negatives": 5, "pixel_recall": 1.0, "mask_iou": 0.8, "false_area_fraction": 0.1, "time_ms": 3.0,
    }  # fmt: skip
    records = [{"rows": [first], "centroid_errors_px": {"otsu": [4.0]}}, {"rows": [second], "centroid_errors_px": {"otsu": [1.0]}}]
    row = method_row("otsu", records)
    assert row["threshold_median"] == 20
    assert row["time_ms_median"] == 2
    assert row["hit_rate"] == pytest.approx(2 / 3, abs=1e-6)
    assert row["recall"] == 0.75
    assert row["object_recall"] == pytest.approx(2 / 3, abs=1e-6)
    assert row["fpr"] == pytest.approx(2 / 10)
    assert row["ppv"] == pytest.approx(3 / 5)
    assert row["centroid_error_px_median"] == 2.5
    assert row["false_regions_per_image"] == 1.0
    assert row["false_area_fraction"] == pytest.approx(0.05)


def test_boxes_serve_as_truth_and_have_no_outline(cli: Cli, scene_folder: Folder, tmp_path: Path) -> None:
    folder = scene_folder(2)
    lines = ["image,x_px,y_px,width_px,height_px"]
    for stem in ("000", "001"):
        y, x = np.nonzero(np.asarray(Image.open(folder / "masks" / f"{stem}.png")))
        lines.append(f"{stem}.png,{x.min()},{y.min()},{x.max() - x.min() + 1},{y.max() - y.min() + 1}")
    (tmp_path / "boxes.csv").write_text("\n".join(lines) + "\n")
    rows = rows_of(cli("segment-compare", folder, "--boxes", tmp_path / "boxes.csv", "--out", tmp_path / "out", "--json"))
    assert rows["otsu"]["hit_rate"] == 1.0
    assert rows["otsu"]["object_recall"] == 1.0
    assert rows["otsu"]["recall"] is None


def test_images_without_objects_have_false_regions_alone(cli: Cli, scene_folder: Folder, tmp_path: Path) -> None:
    rows = rows_of(cli("segment-compare", scene_folder(2), "--no-objects", "--out", tmp_path / "out", "--json"))
    assert rows["otsu"]["false_regions_per_image"] == 1.0
    assert rows["otsu"]["false_area_fraction"] == pytest.approx(22 * 14 / (96 * 128), abs=1e-6)
    assert rows["otsu"]["hit_rate"] is None
    assert rows["otsu"]["ppv"] == 0.0


def test_without_a_truth_thresholds_and_times_remain(cli: Cli, scene_folder: Folder, tmp_path: Path) -> None:
    answer = cli("segment-compare", scene_folder(2), "--out", tmp_path / "out", "--json", "--no-report")
    row = rows_of(answer)["max-entropy"]
    assert row["threshold_median"] is not None
    assert all(row[key] is None for key in ("hit_rate", "recall", "fpr", "ppv", "centroid_error_px_median", "false_regions_per_image"))
    assert not (tmp_path / "out" / "report.html").exists()


def test_an_image_without_its_mask_is_lost_alone(cli: Cli, scene_folder: Folder, tmp_path: Path) -> None:
    folder = scene_folder(3)
    (folder / "masks" / "001.png").unlink()
    answer = cli("segment-compare", folder, "--masks", folder / "masks", "--out", tmp_path / "out", "--json")
    assert answer.code == 3
    assert json.loads(answer.out)["failed"][0]["image"] == "001.png"
    assert rows_of(answer)["otsu"]["images"] == 2


def test_two_truths_are_refused(cli: Cli, scene_folder: Folder, tmp_path: Path) -> None:
    folder = scene_folder(1)
    answer = cli("segment-compare", folder, "--masks", folder / "masks", "--no-objects", "--out", tmp_path / "out")
    assert answer.code == 2
    assert "are different truths; give one of them" in answer.err


def test_real_side_scan_tiles(cli: Cli, data_set: Callable[[str], Path], tmp_path: Path) -> None:
    """One recording, the paper's settings for pictures of low resolution: the improved threshold is never below Otsu's,
    and its second pass leaves fewer false regions."""
    folder = data_set("sdvd")
    answer = cli(
        "segment-compare", f"{folder}/images/*20240430033948*.png", "--masks", folder / "masks", "--one-object", "--preset", "sss-low",
        "--out", tmp_path / "out", "--json",
    )  # fmt: skip
    assert answer.code == 0, answer.err
    rows = rows_of(answer)
    assert rows["otsu"]["objects"] == rows["otsu"]["images"] == 10
    assert rows["improved-otsu"]["second_pass_fraction"] > 0
    assert rows["improved-otsu"]["threshold_median"] > rows["otsu"]["threshold_median"]
    assert rows["improved-otsu"]["false_regions_per_image"] < rows["otsu"]["false_regions_per_image"]
    assert rows["improved-otsu"]["fpr"] < rows["otsu"]["fpr"]
