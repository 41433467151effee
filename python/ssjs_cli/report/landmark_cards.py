"""The landmarks of a camera mission: what each looks like, and a table of them all."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ssjs_cli.report.frame_files import FramePictures
from ssjs_cli.report.map_figure import MapAxes
from ssjs_cli.report.number_text import count_text, length_digits
from ssjs_cli.report.picture_data import picture_url
from ssjs_cli.report.planar_shapes import ellipse_axes
from ssjs_cli.report.result_files import Landmarks, RunFiles
from ssjs_cli.report.sheet import NAME, Sheet, sheet

if TYPE_CHECKING:
    from PIL import Image

#: Cards with a patch; so many of them are some 1 MB.
MAX_CARDS = 300
MAX_ROWS = 3000
PATCH_QUALITY = 80


@dataclass(frozen=True)
class LandmarkCard:
    number: str
    url: str
    lines: list[str]
    title: str


@dataclass(frozen=True)
class LandmarkSheet:
    cards: list[LandmarkCard]
    table: Sheet
    note: str


def landmark_sheet(files: RunFiles, axes: MapAxes) -> LandmarkSheet | None:
    """Those seen most often first. None for a mission without frames, or without landmarks."""
    landmarks = files.landmarks
    if files.pictures is None or landmarks is None or not landmarks.id:
        return None
    order = np.lexsort((np.arange(len(landmarks.id)), -landmarks.times_seen)).tolist()
    half_axes, _ = ellipse_axes(landmarks.covariance)
    in_space = files.trajectory is not None and files.trajectory.depth is not None
    first, second = axes.short_names
    columns: list[tuple[str, str, int | None, float]] = [
        ("id", "landmark", NAME, 1.0),
        ("x", f"{first} [{axes.short_unit}]", 3, 1.0),
        ("y", f"{second} [{axes.short_unit}]", 3, 1.0),
        ("depth", f"depth [{axes.short_unit}]", 3, 1.0),
        ("major", f"σ major [{axes.short_unit}]", 4, 1.0),
        ("minor", f"σ minor [{axes.short_unit}]", 4, 1.0),
        ("seen", "times seen", 0, 1.0),
        ("submap", "submap", 0, 1.0),
    ]
    rows = [
        {
            "id": _number(landmarks.id[row]),
            "x": float(landmarks.position[row, 0]),
            "y": float(landmarks.position[row, 1]),
            "depth": float(landmarks.depth[row]) if in_space else None,
            "major": float(half_axes[row, 0]),
            "minor": float(half_axes[row, 1]),
            "seen": int(landmarks.times_seen[row]),
            "submap": int(landmarks.submap[row]) if landmarks.submap[row] >= 0 else None,
        }
        for row in order[:MAX_ROWS]
    ]
    cards = _cards(files.pictures, landmarks, order, half_axes[:, 0].tolist())
    table_note = f"The first {count_text(MAX_ROWS)} of {count_text(len(order))}." if len(order) > MAX_ROWS else ""
    return LandmarkSheet(
        cards, sheet("landmark-table", "Every landmark", columns, rows, note=table_note), _note(files.pictures, cards, axes.unit)
    )


def _number(text: str) -> float | None:
    return float(text) if text else None


def _cards(pictures: FramePictures, landmarks: Landmarks, order: list[int], sigma: list[float]) -> list[LandmarkCard]:
    from PIL import Image

    patches = pictures.patches
    if patches is None:
        return []
    cards = []
    with Image.open(patches.path) as whole:
        for row in order:
            place = patches.places.get(landmarks.id[row])
            if place is None:
                continue
            seen = int(landmarks.times_seen[row])
            cards.append(
                LandmarkCard(
                    number=landmarks.id[row],
                    url=_patch_url(whole, place.row, place.column, patches.side_px),
                    lines=[f"{seen} look{'' if seen == 1 else 's'}", f"σ {length_digits(sigma[row])}"],
                    title=f"{place.file} at ({place.u_px:.0f}, {place.v_px:.0f}) px",
                )
            )
            if len(cards) == MAX_CARDS:
                break
    return cards


def _patch_url(whole: "Image.Image", row: int, column: int, side_px: int) -> str:
    left, top = column * side_px, row * side_px
    return picture_url(whole.crop((left, top, left + side_px, top + side_px)), PATCH_QUALITY)


def _note(pictures: FramePictures, cards: list[LandmarkCard], unit: str) -> str:
    patches = pictures.patches
    if patches is None or not cards:
        return ""
    count = len(patches.places)
    which = f"The {len(cards)} of {count_text(count)} landmarks that were seen most often" if len(cards) < count else "Landmarks"
    return (
        f"{which}, each in the middle of a patch {100.0 * patches.part_of_width:.0f} % of a frame wide, lens corrected, contrast "
        f"stretched; σ [{unit}] along the larger axis of its position. All patches are in {pictures.folder.name}/{patches.path.name}."
    )
