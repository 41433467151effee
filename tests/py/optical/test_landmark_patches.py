"""The patch of each landmark: which frame it is cut from, and what it shows."""

from __future__ import annotations

import csv
import io

import numpy as np

from ssjs_cli.formats.frame_image import Frame
from ssjs_cli.optical.landmark_patches import SIDE_PX, Looks, best_looks, patch, patch_sheet

SIZE_PX = (320, 240)
MIDDLE = (159.5, 119.5)


def looks(*rows: tuple[int, int, tuple[float, float]]) -> Looks:
    landmark, frame, pixel = zip(*rows, strict=True)
    return Looks(np.array(landmark), np.array(frame), np.array(pixel, dtype=np.float64))


def test_of_many_looks_that_nearest_to_the_middle_is_taken() -> None:
    found = best_looks(looks((7, 3, (20.0, 20.0)), (7, 4, MIDDLE), (7, 5, (300.0, 10.0)), (2, 0, (5.0, 5.0))), SIZE_PX)
    assert (found.landmark.tolist(), found.frame.tolist()) == ([2, 7], [0, 4])


def test_few_frames_are_opened() -> None:
    """Frame 1 shows both well enough, though each has a frame where it is nearer to the middle."""
    found = best_looks(looks((0, 0, MIDDLE), (0, 1, (120.0, 119.5)), (1, 1, (200.0, 119.5)), (1, 2, MIDDLE)), SIZE_PX)
    assert found.frame.tolist() == [1, 1]
    # where their patches are cut off, frame 1 is no good look at either
    found = best_looks(looks((0, 0, MIDDLE), (0, 1, (10.0, 119.5)), (1, 1, (310.0, 119.5)), (1, 2, MIDDLE)), SIZE_PX)
    assert found.frame.tolist() == [0, 2]


def test_the_landmark_is_in_the_middle_of_its_patch() -> None:
    frame = np.full((240, 320, 3), 90, dtype=np.uint8)
    frame[98:103, 198:203] = (200, 60, 60)
    cut = patch(frame, np.array([200.0, 100.0])).astype(int)
    rows, columns = np.nonzero(cut[:, :, 0] > cut[:, :, 2] + 100)
    assert abs(rows.mean() - (SIDE_PX - 1) / 2) < 0.6 and abs(columns.mean() - (SIDE_PX - 1) / 2) < 0.6
    assert 4 <= np.ptp(rows) + 1 <= 6  # 5 of the 48 pixels that are 15 % of 320


def test_noise_is_not_blown_up_and_beyond_the_border_is_black() -> None:
    noise = np.random.default_rng(1).integers(100, 104, size=(240, 320), dtype=np.uint8)
    assert np.std(patch(noise, np.array(MIDDLE))) < 8.0
    corner = patch(noise, np.array([0.0, 0.0]))
    assert corner[:20, :20].max() == 0 and corner[-20:, -20:].min() > 100


def test_the_sheet_has_a_place_for_each_and_reads_each_frame_once() -> None:
    asked = []

    def pixels(number: int) -> Frame:
        asked.append(number)
        return np.full((240, 320), 40 * number, dtype=np.uint8)

    middle = [(landmark, 1 + landmark // 3, MIDDLE) for landmark in range(5)]
    sheet = patch_sheet(looks(*middle), SIZE_PX, pixels)
    assert sheet is not None and asked == [1, 2]
    assert sheet.picture.shape == (2 * SIDE_PX, 3 * SIDE_PX, 3)
    rows = list(csv.DictReader(io.StringIO(sheet.table(lambda number: f"{number}.png"))))
    assert [(row["landmark"], row["file"], row["row"], row["column"]) for row in rows] == [
        ("0", "1.png", "0", "0"), ("1", "1.png", "0", "1"), ("2", "1.png", "0", "2"), ("3", "2.png", "1", "0"), ("4", "2.png", "1", "1"),
    ]  # fmt: skip
    assert patch_sheet(Looks(np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64), np.zeros((0, 2))), SIZE_PX, pixels) is None
