"""What each landmark looks like: a patch of a corrected frame that shows it well, all of them side by side in one picture."""

import csv
import io
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ssjs_cli.formats.frame_image import Frame
from ssjs_cli.formats.number_table import FloatArray, IntArray

#: Three blocks of a JPEG, so that neighbours do not run into each other.
SIDE_PX = 48
#: Of the width of a frame: what a patch shows across.
PART_OF_WIDTH = 0.15
#: Beyond these, those seen most often; their picture is some 6 MB.
MOST_PATCHES = 10_000
#: Darkest and brightest part of a patch are drawn black and white, but its noise is not blown up.
LEVEL_QUANTILES = (0.01, 0.99)
MOST_GAIN = 4.0
TABLE_COLUMNS = ("landmark", "file", "u_px", "v_px", "row", "column")


@dataclass(frozen=True)
class Looks:
    """One row each time a frame showed a landmark: number of the landmark in landmarks.csv (n,), of the frame (n,), and where (n, 2), in
    the corrected frame."""

    landmark: IntArray
    frame: IntArray
    pixel: FloatArray


@dataclass(frozen=True)
class PatchSheet:
    """looks: those that are shown, from left to right and from top to bottom."""

    picture: Frame
    columns: int
    looks: Looks

    def table(self, names: Callable[[int], str]) -> str:
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(TABLE_COLUMNS)
        rows = zip(self.looks.landmark.tolist(), self.looks.frame.tolist(), self.looks.pixel.tolist(), strict=True)
        for place, (landmark, frame, (u, v)) in enumerate(rows):
            writer.writerow((landmark, names(frame), f"{u:.2f}", f"{v:.2f}", *divmod(place, self.columns)))
        return text.getvalue()


def patch_sheet(looks: Looks, size_px: tuple[int, int], pixels: Callable[[int], Frame]) -> PatchSheet | None:
    """size_px: width and height of every frame; pixels: of a frame, corrected. Each frame is asked for once. None without looks."""
    shown = best_looks(_most_seen(looks, MOST_PATCHES), size_px)
    if not len(shown.landmark):
        return None
    columns = int(np.ceil(np.sqrt(len(shown.landmark))))
    rows = -(-len(shown.landmark) // columns)
    picture = np.zeros((rows * SIDE_PX, columns * SIDE_PX, 3), dtype=np.uint8)
    for frame in np.unique(shown.frame).tolist():
        image = pixels(frame)
        for place in np.flatnonzero(shown.frame == frame).tolist():
            top, left = (SIDE_PX * number for number in divmod(place, columns))
            picture[top : top + SIDE_PX, left : left + SIDE_PX] = patch(image, shown.pixel[place])
    return PatchSheet(picture, columns, shown)


def best_looks(looks: Looks, size_px: tuple[int, int]) -> Looks:
    """One look a landmark, in the order of their numbers. Those are good whose patch lies inside the frame; of a landmark without, that
    nearest to the middle. Frames with the most good looks are opened until every landmark has one; of several that nearest to the middle
    is taken, where the camera sees sharpest and from straight above."""
    width_px, height_px = size_px
    offset = np.abs(looks.pixel - ((width_px - 1) / 2, (height_px - 1) / 2))
    distance = np.linalg.norm(offset, axis=1)
    half = 0.5 * PART_OF_WIDTH * width_px
    is_inside = (offset <= (0.5 * width_px - half, 0.5 * height_px - half)).all(axis=1)
    _, number = np.unique(looks.landmark, return_inverse=True)
    nearest = np.full(int(number.max(initial=-1)) + 1, np.inf)
    np.minimum.at(nearest, number, distance)
    has_inside = np.zeros(len(nearest), dtype=np.bool_)
    has_inside[number[is_inside]] = True
    good = np.flatnonzero(np.where(has_inside[number], is_inside, distance <= nearest[number]))
    opened = []
    missing = good
    while len(missing):
        opened.append(int(np.bincount(looks.frame[missing]).argmax()))
        shown = number[missing[looks.frame[missing] == opened[-1]]]
        missing = missing[~np.isin(number[missing], shown)]
    good = good[np.isin(looks.frame[good], opened)]
    good = good[np.lexsort((looks.frame[good], distance[good], number[good]))]
    row = good[np.flatnonzero(np.diff(number[good], prepend=-1))]
    return Looks(looks.landmark[row], looks.frame[row], looks.pixel[row])


def _most_seen(looks: Looks, most: int) -> Looks:
    landmarks, counts = np.unique(looks.landmark, return_counts=True)
    if len(landmarks) <= most:
        return looks
    kept = np.isin(looks.landmark, landmarks[np.lexsort((landmarks, -counts))[:most]])
    return Looks(looks.landmark[kept], looks.frame[kept], looks.pixel[kept])


def patch(image: Frame, pixel: FloatArray) -> Frame:
    """(SIDE_PX, SIDE_PX, 3) around the pixel; black beyond the border of the frame."""
    from PIL import Image

    half = 0.5 * PART_OF_WIDTH * image.shape[1]
    left, top = (int(np.floor(value - half + 0.5)) for value in pixel.tolist())
    side = max(round(2.0 * half), 1)
    cut = Image.fromarray(image).convert("RGB").crop((left, top, left + side, top + side))
    levels = np.asarray(cut.resize((SIDE_PX, SIDE_PX), Image.Resampling.BICUBIC))
    share = np.cumsum(np.bincount(levels.ravel(), minlength=256)) / levels.size
    low, high = np.searchsorted(share, LEVEL_QUANTILES).tolist()
    gain = min(255.0 / max(high - low, 1), MOST_GAIN)
    stretched = np.clip(np.rint(127.5 + gain * (np.arange(256) - 0.5 * (low + high))), 0, 255).astype(np.uint8)
    drawn: Frame = stretched[levels]
    return drawn
