"""From the command line to the files: training, detection, evaluation, the page of a model."""

import csv
import hashlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

Cli = Callable[..., Any]
RECORDINGS = ("--recordings", r"(line\d\d)")


def table(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def digests(directory: Path) -> dict[str, str]:
    """timing.json holds times; everything else is the same at any number of threads."""
    return {
        str(path.relative_to(directory)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(directory.rglob("*"))
        if path.is_file() and path.name != "timing.json"
    }


def test_a_training_leaves_model_xml_plan_and_page(trained: Path) -> None:
    names = {path.name for path in trained.iterdir()}
    assert names == {
        "cascade.json", "cascade.xml", "mean_positive.png", "training.json", "layers.csv", "plan.toml", "config.toml", "timing.json",
        "report.html",
    }  # fmt: skip
    document = json.loads((trained / "training.json").read_text())
    totals = document["totals"]
    assert totals["images"] == 24
    assert totals["objects"] == 48
    assert totals["objects_held_back"] == 12  # two of eight recordings of six objects: the first to reach 20 % of 48
    assert totals["objects_trained_on"] == 36
    assert totals["failed"] == 0
    assert document["layers"][-1]["false_positive_rate"] < 0.1
    assert document["layers"][-1]["detection_rate"] >= 0.94
    assert np.asarray(Image.open(trained / "mean_positive.png")).shape == (12, 12)
    # no path, host or date
    assert str(trained.parent) not in (trained / "cascade.json").read_text() + (trained / "training.json").read_text()


def test_objects_are_found_in_other_pictures(cli: Cli, trained: Path, new_scenes: Callable[..., Any], tmp_path: Path) -> None:
    scenes = new_scenes(pictures=10, seed=77)
    answer = cli("cascade", "detect", trained, scenes.positives, "--out", tmp_path / "found", "--json")
    assert answer.code == 0, answer.err
    document = json.loads(answer.out)
    rows = table(tmp_path / "found" / "detections.csv")
    assert list(rows[0]) == ["image", "x_px", "y_px", "width_px", "height_px", "score"]
    assert document["totals"]["detections"] == len(rows)
    found = 0
    for name, boxes in scenes.boxes.items():
        for box in boxes:
            found += any(overlap(box, row) >= 0.3 for row in rows if row["image"] == name)
    assert found >= 16, f"{found} of 20"
    assert len(rows) <= 40
    for name in scenes.boxes:
        assert Image.open(tmp_path / "found" / "overlays" / name).size == (130, 100)


def overlap(box: tuple[int, int, int, int], row: dict[str, str]) -> float:
    """Intersection over union by counting pixels."""
    canvas = np.zeros((2, 100, 130), dtype=bool)
    left, top, width, height = (int(row[key]) for key in ("x_px", "y_px", "width_px", "height_px"))
    canvas[0, box[1] : box[1] + box[3], box[0] : box[0] + box[2]] = True
    canvas[1, top : top + height, left : left + width] = True
    return float((canvas[0] & canvas[1]).sum() / (canvas[0] | canvas[1]).sum())


def test_training_gives_the_same_bytes_at_any_number_of_threads(cli: Cli, scenes: Any, trained: Path, tmp_path: Path) -> None:
    answer = cli("cascade", "train", *scenes.options, *RECORDINGS, "--jobs", "3", "--out", tmp_path / "again")
    assert answer.code == 0, answer.err
    assert digests(tmp_path / "again") == digests(trained)


def test_another_seed_gives_another_model(cli: Cli, scenes: Any, trained: Path, tmp_path: Path) -> None:
    answer = cli("cascade", "train", *scenes.options, *RECORDINGS, "--seed", "2", "--no-report", "--out", tmp_path / "other")
    assert answer.code == 0, answer.err
    assert (tmp_path / "other" / "cascade.xml").read_bytes() != (trained / "cascade.xml").read_bytes()
    assert not (tmp_path / "other" / "report.html").exists()


def test_a_killed_training_resumes_to_the_same_bytes(cli: Cli, scenes: Any, trained: Path, tmp_path: Path) -> None:
    out, checkpoint = tmp_path / "model", tmp_path / "model.checkpoint.json"
    command = [*map(str, scenes.options), *RECORDINGS, "--jobs", "1", "--out", str(out)]
    process = subprocess.Popen([sys.executable, "-m", "ssjs_cli", "cascade", "train", *command], stderr=subprocess.DEVNULL)
    deadline = time.monotonic() + 120
    while not checkpoint.exists() and process.poll() is None and time.monotonic() < deadline:
        time.sleep(0.005)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    assert checkpoint.exists(), "the training left no checkpoint"
    assert not out.exists(), "the training was done before it could be killed"

    refused = cli("cascade", "train", *command)
    assert refused.code == 2
    assert "--resume" in refused.err
    other = cli("cascade", "train", *command, "--resume", "--seed", "9")
    assert other.code == 2
    assert "--resume" in other.err  # says that the training was another one
    resumed = cli("cascade", "train", *command, "--resume")
    assert resumed.code == 0, resumed.err
    assert digests(out) == digests(trained)
    assert not checkpoint.exists()


@pytest.mark.parametrize("jobs", [2, 3])
def test_detections_are_the_same_bytes_at_any_number_of_workers(cli: Cli, scenes: Any, trained: Path, tmp_path: Path, jobs: int) -> None:
    for name, count in (("one", 1), ("more", jobs)):
        answer = cli("cascade", "detect", trained, scenes.positives, "--jobs", count, "--out", tmp_path / name)
        assert answer.code == 0, answer.err
    assert digests(tmp_path / "one") == digests(tmp_path / "more")


def test_detections_do_not_depend_on_the_form_of_the_model(cli: Cli, scenes: Any, trained: Path, tmp_path: Path) -> None:
    """OpenCV's form has no place for the margin, so it is set to what the windows are."""
    rows = {}
    for form in ("cascade.json", "cascade.xml"):
        answer = cli("cascade", "detect", trained / form, scenes.positives, "--no-overlays", "--out", tmp_path / form)
        assert answer.code == 0, answer.err
        rows[form] = table(tmp_path / form / "detections.csv")
    assert [row["score"] for row in rows["cascade.json"]] == [row["score"] for row in rows["cascade.xml"]]
    assert all(
        int(ours["width_px"]) < int(windows["width_px"]) for ours, windows in zip(rows["cascade.json"], rows["cascade.xml"], strict=True)
    )


def test_evaluation_agrees_with_its_own_tables(cli: Cli, scenes: Any, trained: Path, tmp_path: Path) -> None:
    out = tmp_path / "evaluation"
    command = ("cascade", "evaluate", trained, scenes.positives, "--masks", scenes.masks, *RECORDINGS)
    answer = cli(*command, "--set", "evaluation.windows=3000", "--out", out, "--json")
    assert answer.code == 0, answer.err
    document = json.loads(answer.out)
    totals, rates = document["totals"], document["rates"]
    rows = table(out / "detections.csv")
    assert totals["objects"] == 48
    assert totals["found"] == sum(row["outcome"] == "found" for row in rows)
    assert totals["false_boxes"] == sum(row["outcome"] == "false" for row in rows)
    assert rates["detection_rate"] == pytest.approx(totals["found"] / 48, abs=1e-6)
    assert rates["detection_rate"] > 0.85
    froc = table(out / "froc.csv")
    assert float(froc[-1]["detection_rate"]) == rates["detection_rate"]
    assert float(froc[-1]["false_boxes_per_image"]) == rates["false_boxes_per_image"]
    within = [float(row["detection_rate"]) for row in froc if float(row["false_boxes_per_image"]) <= 1.0]
    assert rates["detection_rate_at_one_false_box"] == max(within)
    layers = table(out / "layers.csv")
    assert [row["layer"] for row in layers] == [str(number + 1) for number in range(len(layers))]
    falling = [float(row["false_positive_rate"]) for row in layers]
    assert falling == sorted(falling, reverse=True)
    page = (out / "report.html").read_text()
    assert 'id="froc"' in page
    assert "http://" not in page.split("plotly.js")[0]


def test_a_model_is_shown(cli: Cli, trained: Path, tmp_path: Path) -> None:
    answer = cli("cascade", "show", trained, "--out", tmp_path / "model.html", "--json")
    assert answer.code == 0, answer.err
    document = json.loads(answer.out)
    assert document["window_px"] == [12, 12]
    assert document["settings"]["window.margin"] == "0.1"
    features = sum(layer["features"] for layer in document["layers"])
    page = (tmp_path / "model.html").read_text()
    assert page.count('<figure class="card">') == features + 1  # and the mean object
    again = cli("cascade", "show", trained, "--out", tmp_path / "model.html")
    assert again.code == 2
    assert "--force" in again.err
