"""What the run of a camera mission leaves beside the files of every run: the mosaic, matches and sightings drawn in frames."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ssjs_cli.formats.run_directory import PICTURES_FOLDER, PICTURES_INDEX_FILE
from ssjs_cli.report.json_index import read_json_index
from ssjs_cli.report.number_text import finite_number

MOSAIC_PLACE = ("left", "right", "bottom", "top", "width_px", "height_px")


@dataclass(frozen=True)
class PlacedMosaic:
    """Its file and the part of the map that it covers, across and up."""

    path: Path
    left: float
    right: float
    bottom: float
    top: float
    width_px: int
    height_px: int


@dataclass(frozen=True)
class FramePictures:
    """matches, sightings: the entries of the index whose files are there; frames: how many were given, used, had a region."""

    folder: Path
    mosaic: PlacedMosaic | None
    matches: list[dict[str, Any]]
    sightings: list[dict[str, Any]]
    frames: dict[str, int]


def read_frame_pictures(run_dir: Path) -> FramePictures | None:
    folder = run_dir / PICTURES_FOLDER
    path = folder / PICTURES_INDEX_FILE
    index = read_json_index(path)
    if index is None:
        return None
    frames = index.get("frames")
    counts = {str(key): int(value) for key, value in frames.items() if isinstance(value, int)} if isinstance(frames, dict) else {}
    return FramePictures(
        folder, _mosaic(folder, index.get("mosaic")), _there(folder, index, "matches"), _there(folder, index, "sightings"), counts
    )


def _mosaic(folder: Path, entry: Any) -> PlacedMosaic | None:
    if not isinstance(entry, dict):
        return None
    path = _picture(folder, entry)
    place = [finite_number(entry.get(key)) for key in MOSAIC_PLACE]
    if path is None or any(value is None for value in place):
        return None
    left, right, bottom, top, width_px, height_px = (value or 0.0 for value in place)
    if not (right > left and top > bottom and width_px >= 1 and height_px >= 1):
        return None
    return PlacedMosaic(path, left, right, bottom, top, int(width_px), int(height_px))


def _there(folder: Path, index: dict[str, Any], key: str) -> list[dict[str, Any]]:
    entries = index.get(key)
    if not isinstance(entries, list):
        return []
    return [entry for entry in entries if isinstance(entry, dict) and _picture(folder, entry) is not None]


def _picture(folder: Path, entry: dict[str, Any]) -> Path | None:
    """Nothing outside the folder."""
    name = entry.get("picture")
    if not isinstance(name, str) or Path(name).name != name or not (folder / name).is_file():
        return None
    return folder / name
