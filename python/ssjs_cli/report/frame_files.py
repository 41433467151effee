"""What the run of a camera mission leaves beside the files of every run: the mosaic, matches and sightings drawn in frames."""

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ssjs_cli.errors import UserError
from ssjs_cli.formats.run_directory import PICTURES_FOLDER, PICTURES_INDEX_FILE
from ssjs_cli.report.json_object import RUN_AGAIN, read_json_object
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
class PatchPlace:
    """Row and column of a patch in the picture of them all; the frame that it was cut from, and where."""

    row: int
    column: int
    file: str
    u_px: float
    v_px: float


@dataclass(frozen=True)
class LandmarkPatches:
    """places: by the number of the landmark, as text."""

    path: Path
    side_px: int
    part_of_width: float
    places: dict[str, PatchPlace]


@dataclass(frozen=True)
class FramePictures:
    """matches, sightings: the entries of the index whose files are there; frames: how many were given, used, had a region."""

    folder: Path
    mosaic: PlacedMosaic | None
    matches: list[dict[str, Any]]
    sightings: list[dict[str, Any]]
    frames: dict[str, int]
    patches: LandmarkPatches | None = None


def read_frame_pictures(run_dir: Path) -> FramePictures | None:
    folder = run_dir / PICTURES_FOLDER
    path = folder / PICTURES_INDEX_FILE
    index = read_json_object(path)
    if index is None:
        return None
    frames = index.get("frames")
    counts = {str(key): int(value) for key, value in frames.items() if isinstance(value, int)} if isinstance(frames, dict) else {}
    return FramePictures(
        folder,
        _mosaic(folder, index.get("mosaic")),
        _there(folder, index, "matches"),
        _there(folder, index, "sightings"),
        counts,
        _patches(folder, index.get("landmarks")),
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


def _patches(folder: Path, entry: Any) -> LandmarkPatches | None:
    if not isinstance(entry, dict):
        return None
    path, table = _inside(folder, entry, "picture"), _inside(folder, entry, "table")
    side_px, part = finite_number(entry.get("side_px")), finite_number(entry.get("part_of_width"))
    if path is None or table is None or not side_px or part is None:
        return None
    places = {}
    with table.open(encoding="utf-8", newline="") as file:
        for number, row in enumerate(csv.DictReader(file), 2):
            try:
                place = PatchPlace(int(row["row"]), int(row["column"]), row["file"], float(row["u_px"]), float(row["v_px"]))
                places[row["landmark"]] = place
            except (KeyError, TypeError, ValueError) as error:
                raise UserError(f"{table}:{number}: is not a row of this table ({error}); {RUN_AGAIN}") from error
    return LandmarkPatches(path, int(side_px), part, places)


def _there(folder: Path, index: dict[str, Any], key: str) -> list[dict[str, Any]]:
    entries = index.get(key)
    if not isinstance(entries, list):
        return []
    return [entry for entry in entries if isinstance(entry, dict) and _picture(folder, entry) is not None]


def _picture(folder: Path, entry: dict[str, Any]) -> Path | None:
    return _inside(folder, entry, "picture")


def _inside(folder: Path, entry: dict[str, Any], key: str) -> Path | None:
    """The file of this name; nothing outside the folder."""
    name = entry.get(key)
    if not isinstance(name, str) or Path(name).name != name or not (folder / name).is_file():
        return None
    return folder / name
