"""Rubbish in: exit 2 with the file and the mend, or exit 3 with what was lost; never a traceback."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

Cli = Callable[..., Any]


def quick(scenes: Any, out: Path, *more: object) -> list[object]:
    return ["cascade", "train", *scenes.options, "--no-report", "--out", out, *more]


def without(options: list[object], flag: str) -> list[object]:
    place = options.index(flag)
    return options[:place] + options[place + 2 :]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--set", "training.boost=fast"), "training.boost = 'fast': must be one of gentle, discrete"),
        (("--set", "window.width=12"), "unknown key 'window.width' (did you mean 'window.width_px'?)"),
        (("--set", "window.width_px=2"), "window.width_px = 2: must lie in [3, 256]"),
        (("--set", "training.min_improvement=7"), "training.min_improvement"),
        (("--recordings", "("), "is no regular expression"),
        (("--label", "wreck"), "masks have no classes"),
        (("--annotations", "boxes.csv"), "either --masks DIR or --annotations FILE"),
        (("--masks", "nowhere"), "nowhere: is no folder"),
        (("--plan", "nowhere.toml"), "nowhere.toml: is missing"),
        (("--negatives", "nowhere"), "nowhere: No such file or directory"),
    ],
)
def test_usage_that_cannot_be_meant(cli: Cli, scenes: Any, tmp_path: Path, arguments: tuple[str, ...], says: str) -> None:
    answer = cli(*quick(scenes, tmp_path / "out", *arguments))
    assert answer.code == 2
    assert says in answer.err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "holds no layer"),
        ("[[layer]]\ndetection_rate = 0.99\n", "layer 1: key 'false_positive_rate' is missing"),
        ("[[layer]]\ndetection_rat = 0.99\n", "layer 1: unknown key 'detection_rat' (did you mean 'detection_rate'?)"),
        ("[[layer]]\ndetection_rate = 1.5\nfalse_positive_rate = 0.5\nmax_features = 3\n", "plan.toml: "),
        ("[[layer]]\ndetection_rate = 0.9\nfalse_positive_rate = 0.5\nmax_features = 0\n", "max_features = 0"),
        ("[[layer]]\ndetection_rate = 0.9\nfalse_positive_rate = 'x'\nmax_features = 1\n", "must be a number"),
        ("layers = 3\n", "unknown key 'layers' (did you mean 'layer'?)"),
        ("[[layer]\n", "is not valid TOML"),
    ],
)
def test_plans_that_are_none(cli: Cli, scenes: Any, tmp_path: Path, text: str, says: str) -> None:
    plan = tmp_path / "plan.toml"
    plan.write_text(text)
    answer = cli(*quick(scenes, tmp_path / "out", "--plan", plan))
    assert answer.code == 2
    assert str(plan) in answer.err
    assert says in answer.err


def test_one_image_missing_among_many_is_named_and_the_rest_is_used(cli: Cli, new_scenes: Callable[..., Any], tmp_path: Path) -> None:
    scenes = new_scenes(pictures=12)
    lines = [f"{name} {len(boxes)} " + " ".join(" ".join(map(str, box)) for box in boxes) for name, boxes in scenes.boxes.items()]
    lines.append("gone.png 1 1 2 20 20")
    lines[3] += " 1"  # broken below, by a box outside the picture
    name = lines[3].split()[0]
    lines[3] = f"{name} 1 500 2 20 20"
    info = tmp_path / "info.dat"
    info.write_text("\n".join(lines) + "\n")
    (scenes.negatives / "broken.png").write_bytes(b"\x89PNG\r\n\x1a\nno picture")
    options = without(scenes.options, "--masks")
    answer = cli("cascade", "train", *options, "--annotations", info, "--no-report", "--out", tmp_path / "out", "--json")
    assert answer.code == 3, answer.err
    document = json.loads(answer.out)
    lost = {entry["image"]: entry["reason"] for entry in document["failed"]}
    assert set(lost) == {"gone.png", name, "broken.png"}
    assert f"{info}:4: the box" in lost[name]
    assert "gone.png" in answer.err
    assert document["totals"]["images"] == 11


def test_no_object_at_all(cli: Cli, new_scenes: Callable[..., Any], tmp_path: Path) -> None:
    scenes = new_scenes(pictures=3)
    for mask in scenes.masks.iterdir():
        Image.fromarray(np.zeros((100, 130), dtype=np.uint8)).save(mask)
    answer = cli(*quick(scenes, tmp_path / "out"))
    assert answer.code == 2
    assert "holds no object of these images" in answer.err


def test_all_objects_identical(cli: Cli, new_scenes: Callable[..., Any], tmp_path: Path) -> None:
    scenes = new_scenes(pictures=8)
    first = sorted(scenes.positives.iterdir())[0]
    for folder in (scenes.positives, scenes.masks):
        for path in folder.iterdir():
            path.write_bytes((folder / first.name).read_bytes())
    answer = cli(*quick(scenes, tmp_path / "out", "--set", "augmentation.copies=0", "--set", "samples.use_background=false"))
    assert answer.code == 0, answer.err
    assert (tmp_path / "out" / "cascade.json").is_file()


def test_negatives_too_small_for_a_window(cli: Cli, new_scenes: Callable[..., Any], tmp_path: Path) -> None:
    scenes = new_scenes(pictures=6)
    for path in scenes.negatives.iterdir():
        Image.fromarray(np.full((5, 5), 9, dtype=np.uint8)).save(path)
    answer = cli(*quick(scenes, tmp_path / "out", "--set", "samples.use_background=false"))
    assert answer.code == 2
    assert "training:" in answer.err
    assert not (tmp_path / "out").exists()


def test_a_model_cut_off_anywhere_is_refused(cli: Cli, trained: Path, scenes: Any, tmp_path: Path) -> None:
    picture = sorted(scenes.positives.iterdir())[0]
    for name in ("cascade.json", "cascade.xml"):
        data = (trained / name).read_bytes()
        path = tmp_path / name
        for length in [0, 1, 17, *range(100, len(data.rstrip()) - 1, max(1, len(data) // 12))]:
            path.write_bytes(data[:length])
            answer = cli("cascade", "detect", path, picture, "--out", tmp_path / "out")
            assert answer.code == 2, (name, length)
            assert str(path) in answer.err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("command", ["detect", "show"])
def test_models_that_are_none(cli: Cli, scenes: Any, tmp_path: Path, command: str) -> None:
    image = sorted(scenes.positives.iterdir())[0]
    for model in (tmp_path / "gone.json", image, tmp_path):
        arguments = [image] if command == "detect" else []
        answer = cli("cascade", command, model, *arguments, "--out", tmp_path / "out")
        assert answer.code == 2
        assert str(model) in answer.err


def test_pictures_smaller_than_a_window_and_damaged_ones(cli: Cli, trained: Path, scenes: Any, tmp_path: Path) -> None:
    small, damaged = tmp_path / "small.png", tmp_path / "damaged.png"
    Image.fromarray(np.full((4, 4), 7, dtype=np.uint8)).save(small)
    damaged.write_bytes((sorted(scenes.positives.iterdir())[0]).read_bytes()[:200])
    answer = cli("cascade", "detect", trained, small, damaged, "--out", tmp_path / "out", "--json")
    assert answer.code == 3, answer.err
    document = json.loads(answer.out)
    assert document["totals"] == {"images": 1, "failed": 1, "detections": 0}
    assert document["failed"][0]["image"] == "damaged.png"
    assert cli("cascade", "detect", trained, damaged, "--out", tmp_path / "none").code == 2


def test_masks_of_another_size(cli: Cli, trained: Path, new_scenes: Callable[..., Any], tmp_path: Path) -> None:
    scenes = new_scenes(pictures=4)
    name = next(iter(scenes.boxes))
    Image.fromarray(np.zeros((9, 9), dtype=np.uint8)).save(scenes.masks / name)
    answer = cli("cascade", "evaluate", trained, scenes.positives, "--masks", scenes.masks, "--no-report", "--out", tmp_path / "out")
    assert answer.code == 3
    assert f"{scenes.masks / name}: has 9 x 9 pixels" in answer.err
