"""Cascades against OpenCV's detector and a textbook AdaBoost in numpy; a training that is killed and carried on."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from ssjs_cli import _core

Picture = NDArray[np.uint8]
SIDE = 14


def speckle(rng: np.random.Generator, rows: int, columns: int) -> Picture:
    return np.clip(70 * rng.gamma(3, 1 / 3, (rows, columns)), 0, 255).astype(np.uint8)


def with_object(picture: Picture, rng: np.random.Generator) -> Picture:
    """An echo at the left of the middle, its shadow at the right."""
    rows, columns = picture.shape
    y, x = np.mgrid[:rows, :columns] * 24.0 / rows
    cx, cy = 9 + rng.normal(0, 1), 12 + rng.normal(0, 1)
    levels = picture.astype(float)
    levels = np.where(((x - cx) / 4) ** 2 + ((y - cy) / 5) ** 2 < 1, levels * rng.uniform(1.5, 3) + 20, levels)
    levels = np.where(((x - cx - 8) / 5) ** 2 + ((y - cy) / 5) ** 2 < 1, levels * rng.uniform(0.15, 0.6), levels)
    return np.clip(levels, 0, 255).astype(np.uint8)


def objects(count: int, seed: int, side: int = SIDE) -> _core.WindowSet:
    rng = np.random.default_rng(seed)
    windows = _core.WindowSet(side, side)
    for i in range(count):
        windows.add(with_object(speckle(rng, side, side), rng), i // 10)
    return windows


def seafloor(index: int) -> Picture:
    """Speckle with objects seen from the wrong side."""
    rng = np.random.default_rng(1000 + index)
    picture = speckle(rng, 120, 160)
    for _ in range(12):
        side = int(rng.integers(14, 28))
        y, x = int(rng.integers(0, 120 - side)), int(rng.integers(0, 160 - side))
        picture[y : y + side, x : x + side] = with_object(picture[y : y + side, x : x + side], rng)
    return np.ascontiguousarray(picture[:, ::-1])


def train(feature_set: str, checkpoint: str | None = None, layers: int = 3, seed: int = 1) -> _core.HaarCascade:
    return _core.train_cascade(
        objects(150, seed),
        validation_positives=objects(80, seed + 100),
        images=12,
        read=seafloor,
        plan=_core.uniform_plan(layers, 0.97, 0.4, 6),
        config={"feature_set": feature_set, "negatives_per_layer": 200},
        threads=2,
        checkpoint=checkpoint,
        resume=True,
    )


@pytest.mark.parametrize("model", ["frontalface_default", "basic", "all", "side_scan"])
def test_every_window_found_is_the_one_that_opencv_finds(model: str, tmp_path: Path) -> None:
    cv2 = pytest.importorskip("cv2")
    if model == "frontalface_default":
        path = os.path.join(cv2.data.haarcascades, f"haarcascade_{model}.xml")
        cascade = _core.HaarCascade.load(path)
    else:
        cascade = train(model)
        path = str(tmp_path / "model.xml")
        cascade.save(path)
    peer = cv2.CascadeClassifier(path)
    assert not peer.empty()
    rng = np.random.default_rng(7)
    found = 0
    for k in range(50):
        picture = speckle(rng, int(rng.integers(20, 150)), int(rng.integers(20, 180)))
        if k % 2:
            picture = cv2.GaussianBlur(picture, (0, 0), 1.5)
        for neighbours in (0, 2):
            expected = {tuple(box) for box in np.reshape(peer.detectMultiScale(picture, 1.1, neighbours), (-1, 4)).tolist()}
            rows = _core.detect_objects(cascade, picture, config={"min_neighbours": neighbours}, threads=2)
            assert {tuple(int(v) for v in row[:4]) for row in rows} == expected
            found += len(expected)
    if model != "frontalface_default":
        assert found > 500


@pytest.mark.parametrize("kind", ["gentle", "discrete"])
def test_a_stage_is_that_of_a_textbook_adaboost(kind: str) -> None:
    side = 9
    positives, negatives = objects(40, 3, side), _core.WindowSet(side, side)
    rng = np.random.default_rng(4)
    for k in range(50):
        picture = speckle(rng, side, side)
        negatives.add(np.ascontiguousarray(with_object(picture, rng)[:, ::-1]) if k % 2 else picture)
    config = {"feature_set": "side_scan", "boost": kind, "negatives_per_layer": 50, "rejecting_features": 0, "max_shift": 0.0}
    cascade = _core.train_cascade(positives, negatives=negatives, plan=[(1.0, 1e-9, 4, 1.0)], config=config)

    both = _core.WindowSet(side, side)
    both.append(positives)
    both.append(negatives)
    features = _core.haar_features("side_scan", side, side)
    values = np.array([both.responses(tilted, rects) for tilted, rects in features])
    y = np.r_[np.ones(40), -np.ones(50)]
    w = np.r_[np.full(40, 0.5 / 40), np.full(50, 0.5 / 50)]
    order = np.argsort(values, axis=1, kind="stable")
    ranked = np.take_along_axis(values, order, axis=1)
    gap = ranked[:, :-1] < ranked[:, 1:]
    for weak in cascade.stages[0][1]:
        (feature, threshold, _, _), leaves = weak[0][0], weak[1]
        p = np.cumsum(np.where(y > 0, w, 0)[order], axis=1)
        n = np.cumsum(np.where(y < 0, w, 0)[order], axis=1)
        left_p, left_n, right_p, right_n = p[:, :-1], n[:, :-1], p[:, -1:] - p[:, :-1], n[:, -1:] - n[:, :-1]
        if kind == "gentle":
            with np.errstate(invalid="ignore", divide="ignore"):
                gain = (left_p - left_n) ** 2 / (left_p + left_n) + (right_p - right_n) ** 2 / (right_p + right_n)
        else:
            gain = np.maximum(left_p + right_n, left_n + right_p)
        gain = np.where(gap, gain, -1)
        best, cut = np.unravel_index(np.argmax(gain), gain.shape)
        mine = both.responses(*cascade.features()[feature])
        left = np.array(mine) < threshold
        side_p, side_n = w[left & (y > 0)].sum(), w[left & (y < 0)].sum()
        rest_p, rest_n = w[~left & (y > 0)].sum(), w[~left & (y < 0)].sum()
        if kind == "gentle":
            achieved = (side_p - side_n) ** 2 / (side_p + side_n) + (rest_p - rest_n) ** 2 / (rest_p + rest_n)
            expected = [(side_p - side_n) / (side_p + side_n), (rest_p - rest_n) / (rest_p + rest_n)]
        else:
            achieved = max(side_p + rest_n, side_n + rest_p)
            vote = 0.5 * np.log(achieved / (1 - achieved)) * (1 if rest_p + side_n >= side_p + rest_n else -1)
            expected = [-vote, vote]
        assert achieved == pytest.approx(gain[best, cut], abs=2e-7)
        assert leaves == pytest.approx(expected, abs=1e-5)
        w = w * np.exp(-y * np.where(left, leaves[0], leaves[1]))
        w /= w.sum()


def test_a_training_killed_in_a_later_stage_is_carried_on_to_the_same_bytes(tmp_path: Path) -> None:
    expected = train("basic", layers=4).to_json()
    checkpoint = tmp_path / "model.json"
    here = str(Path(__file__).parent)
    script = f"import sys; sys.path[:0] = [{here!r}]; import test_cascade; test_cascade.train('basic', {str(checkpoint)!r}, layers=4)"
    process = subprocess.Popen([sys.executable, "-c", script], env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)})
    deadline = time.monotonic() + 120
    while process.poll() is None and time.monotonic() < deadline:
        if checkpoint.exists() and len(_core.HaarCascade.load(str(checkpoint)).stages) >= 2:
            break
        time.sleep(0.002)
    process.send_signal(signal.SIGKILL)
    process.wait()
    before = _core.HaarCascade.load(str(checkpoint))
    assert len(before.stages) >= 2
    assert train("basic", str(checkpoint), layers=4).to_json() == expected
    assert checkpoint.read_text() == expected


def test_what_is_wrong_is_named(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="uint8 or uint16"):
        _core.WindowSet(8, 8).add(np.zeros((8, 8)))
    with pytest.raises(ValueError, match="8 x 8"):
        _core.WindowSet(8, 8).add(np.zeros((8, 9), np.uint8))
    with pytest.raises(ValueError, match="no such configuration key"):
        _core.detect_objects(train("side_scan", layers=1), np.zeros((40, 40), np.uint8), config={"scale": 1.2})
    path = tmp_path / "cut.json"
    path.write_text('{"format": "ssjs-haar-cascade", "ver')
    with pytest.raises(OSError, match=r"cut\.json: at byte"):
        _core.HaarCascade.load(str(path))
    with pytest.raises(ValueError, match="at least two objects"):
        _core.train_cascade(objects(1, 1), plan=_core.thesis_plan())


def test_a_picture_that_cannot_be_read_is_passed_over_and_counted() -> None:
    def read(index: int) -> Picture | None:
        return None if index == 5 else seafloor(index)

    windows, _, _, missing = _core.mine_negatives(None, SIDE, SIDE, 12, read, 100)
    assert (len(windows), missing) == (100, 1)
