"""Pictures continued beyond their borders, copies cut from them, and noise that objects and ground have alike."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from ssjs_cli.cascade.copies import Variation
from ssjs_cli.cascade.preparation import Preparation
from ssjs_cli.cascade.samples import PictureSource
from ssjs_cli.cascade.window_boxes import intersection_over_union

SIZE = (100, 60)  # width, height


def speckle(seed: int = 1) -> np.ndarray:
    return np.random.default_rng(seed).integers(40, 200, (SIZE[1], SIZE[0])).astype(np.uint8)


def test_a_picture_goes_on_beyond_its_border_as_its_mirror_image() -> None:
    levels = speckle()
    valid = np.full(levels.shape, 255, np.uint8)
    valid[:, :7] = 0
    seen, seen_valid = Preparation(border_px=20).picture(levels, valid)
    assert seen.shape == (100, 140)
    assert np.array_equal(seen[20:80, 20:120], levels)
    assert np.array_equal(seen[20:80, :20], levels[:, 20:0:-1])
    assert seen_valid is not None and not seen_valid[:, 14:27].any() and seen_valid[:, 27:].all()
    same, none = Preparation().picture(levels, None)
    assert np.array_equal(same, levels) and none is None


def test_averages_know_nothing_of_the_border_added() -> None:
    levels = speckle()
    alone, _ = Preparation(smoothing_px=5).picture(levels, None)
    seen, _ = Preparation(smoothing_px=5, border_px=9).picture(levels, None)
    assert np.array_equal(seen[9:-9, 9:-9], alone)


@pytest.mark.parametrize(
    ("box", "whole"),
    [
        ((40, 20, 10, 8), (60, 40, 10, 8)),  # not cut: only moved
        ((0, 20, 10, 8), (10, 40, 20, 8)),  # 10 columns on either side of the border, which is column 20
        ((92, 20, 8, 8), (112, 40, 16, 8)),
        ((40, 50, 10, 10), (60, 70, 10, 20)),
        ((0, 0, 10, 6), (10, 14, 20, 12)),
        ((0, 20, 100, 8), (20, 40, 100, 8)),  # from border to border
    ],
)  # fmt: skip
def test_a_cut_object_is_completed_and_comes_back_as_it_was(box: tuple[int, ...], whole: tuple[int, ...]) -> None:
    preparation = Preparation(border_px=20)
    assert preparation.object_in_prepared(box, *SIZE) == whole  # type: ignore[arg-type]
    assert preparation.object_in_picture(whole, *SIZE) == box  # type: ignore[arg-type]


def test_the_mirror_image_of_an_object_is_no_detection() -> None:
    preparation = Preparation(border_px=30)
    assert preparation.object_in_picture((5, 50, 20, 20), *SIZE) is None  # left of the border
    assert preparation.object_in_picture((15, 50, 20, 20), *SIZE) is None  # 5 of 20 columns inside
    assert preparation.object_in_picture((17, 50, 20, 20), *SIZE) == (0, 20, 7, 20)
    assert Preparation().object_in_picture((1, 2, 3, 4), *SIZE) == (1, 2, 3, 4)


def test_copies_stay_near_their_object_and_inside_the_picture() -> None:
    variation = Variation(copies=4, scale=0.15, shift_px=1.0)
    rng = np.random.default_rng(3)
    for box in ((40, 20, 24, 24), (0, 0, 60, 60), (76, 36, 24, 24)):
        made = [variation.box(box, 16, SIZE, rng) for _ in range(200)]
        for left, top, width, height in made:
            assert left >= 0 and top >= 0 and left + width <= SIZE[0] and top + height <= SIZE[1]
        assert min(intersection_over_union(box, copy) for copy in made) > 0.5
        assert len(set(made)) > 20
    assert Variation().box((40, 20, 24, 24), 16, SIZE, rng) == (40, 20, 24, 24)


def test_every_other_copy_is_upside_down_and_none_is_turned_left_to_right() -> None:
    window = np.arange(6, dtype=np.uint8).reshape(3, 2)
    flipping = Variation(flip_along_track=True)
    assert np.array_equal(flipping.turned(window, 0), window[::-1])
    assert np.array_equal(flipping.turned(window, 1), window)
    assert np.array_equal(Variation().turned(window, 0), window)


def test_noise_has_its_deviation() -> None:
    level = np.full((200, 200), 100, np.uint8)
    noisy = Variation(additive_noise=3.0, multiplicative_noise=0.04).levels(level, np.random.default_rng(1))
    assert noisy.std() == pytest.approx(5.0, rel=0.03)
    assert noisy.mean() == pytest.approx(100, abs=0.1)
    louder = {int(Variation(gain=0.2).levels(level, np.random.default_rng(seed)).mean()) for seed in range(30)}
    assert min(louder) >= 80 and max(louder) <= 120 and len(louder) > 10


def test_ground_has_noise_in_the_share_that_objects_have_it(tmp_path: Path) -> None:
    paths = []
    for number in range(6):
        paths.append(tmp_path / f"{number}.png")
        Image.fromarray(speckle(number)).save(paths[-1])
    variation = Variation(copies=2, additive_noise=5.0)
    source = PictureSource(paths, [()] * 6, [False] * 6, variation=variation, seed=1)
    plain = [np.array_equal(source.read(index), speckle(index)) for index in range(6)]
    assert plain == [True, False, False, True, False, False]
    assert np.array_equal(source.read(1), source.read(1))
    other = PictureSource(paths, [()] * 6, [False] * 6, variation=variation, seed=2)
    assert not np.array_equal(source.read(1), other.read(1))
    assert len({source.digest(), other.digest(), PictureSource(paths, [()] * 6, [False] * 6).digest()}) == 3


def test_windows_of_ground_touch_neither_an_object_nor_its_mirror_image(tmp_path: Path) -> None:
    path = tmp_path / "tile.png"
    Image.fromarray(speckle()).save(path)
    _, valid = PictureSource([path], [((0, 10, 5, 6),)], [False], Preparation(border_px=8)).read(0)
    assert not valid[18:24, 4:13].any()  # columns 0 to 4 of the picture and, beyond the border, their image
    assert valid[:18].all() and valid[:, 13:].all()
