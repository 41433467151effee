"""The command `sonar tiles`: what a survey's detector sees, as labelled pictures for `cascade train`.

A tile is one side of a block of pings in ground range, gain normalised: port and starboard apart. The longest run of its rows without an
object is written beside it as a picture that holds none. Where nothing was recorded, in turns, and
where an object is cut by the tile's border, it is transparent, which trainings take as no measurement.
"""

import io
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from ssjs_cli import _core
from ssjs_cli.errors import UserError
from ssjs_cli.exit_codes import DONE
from ssjs_cli.formats.atomic import holds_only, new_directory
from ssjs_cli.formats.mission import Mission, mission_directory, read_mission
from ssjs_cli.formats.number_table import FloatArray
from ssjs_cli.mission_run import path_name
from ssjs_cli.session import Session
from ssjs_cli.sonar.log_blocks import open_log

KIND = "folder of tiles"
WITH_OBJECTS, EMPTY, ANNOTATIONS_FILE = "objects", "empty", "annotations.json"
why_not_tiles = holds_only((WITH_OBJECTS, EMPTY, ANNOTATIONS_FILE), (ANNOTATIONS_FILE,))
#: Of the box across track, before the middle of the object; the rest holds its shadow.
PART_BEFORE = 1 / 3
#: Fewer rows without an object are no picture of their own.
LEAST_ROWS = 48
SIDES = ("port", "starboard")

Box = tuple[int, int, int, int]


@dataclass(frozen=True)
class Block:
    """Pings of a log in ground range. time_s (rows,); grey, valid (rows, columns)."""

    time_s: FloatArray
    grey: NDArray[np.uint8]
    valid: NDArray[np.uint8]
    nadir_column: int
    column_m: float


@dataclass(frozen=True)
class TileRequest:
    """object_m: length along and across track of the box about an object and its shadow."""

    missions: Sequence[Path]
    out: Path
    pings: int = 400
    object_m: tuple[float, float] = (2.4, 3.6)
    force: bool = False


def size_of(text: str) -> tuple[float, float]:
    """Of --object-size-m."""
    try:
        along_m, across_m = (float(number) for number in text.split(","))
    except ValueError as error:
        raise UserError(f"--object-size-m {text}: must be two numbers ALONG,ACROSS, for example 2.4,3.6") from error
    if not (0.0 < along_m < 1e3 and 0.0 < across_m < 1e3):
        raise UserError(f"--object-size-m {text}: must be two positive lengths in metres")
    return along_m, across_m


def write_tiles(request: TileRequest, session: Session) -> int:
    document: dict[str, Any] = {"images": [], "annotations": [], "categories": [{"id": 1, "name": "object"}]}
    empty = 0
    session.fault_log = request.out.with_name(request.out.name + ".fault.jsonl")
    with new_directory(request.out, force=request.force, why_not_ours=why_not_tiles, kind=KIND) as partial:
        for folder in (WITH_OBJECTS, EMPTY):
            (partial / folder).mkdir()
        for directory, name in _named(request.missions):
            mission = read_mission(directory)
            for number, block in enumerate(blocks_of(directory, mission, request.pings)):
                for side in SIDES:
                    levels, alpha, boxes = _tile(block, side, mission, request.object_m)
                    file = f"{side}_{name}_{number:03}.png"
                    free = _longest_run_without(boxes, len(levels))
                    if free.stop - free.start >= LEAST_ROWS:
                        (partial / EMPTY / file).write_bytes(_png(levels[free], alpha[free]))
                        empty += 1
                    if not boxes:
                        continue
                    (partial / WITH_OBJECTS / file).write_bytes(_png(levels, alpha))
                    image = len(document["images"]) + 1
                    document["images"].append({"id": image, "file_name": file, "width": levels.shape[1], "height": levels.shape[0]})
                    for box in boxes:
                        entry = {"id": len(document["annotations"]) + 1, "image_id": image, "category_id": 1, "bbox": list(box)}
                        document["annotations"].append(entry)
        (partial / ANNOTATIONS_FILE).write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    answer = {"folder": str(request.out), "with_objects": len(document["images"]), "empty": empty, "objects": len(document["annotations"])}
    text = f"{request.out}: {answer['objects']} objects in {answer['with_objects']} tiles, {empty} pictures without"
    session.answer(answer, text)
    return DONE


def _named(missions: Sequence[Path]) -> list[tuple[Path, str]]:
    """Directories, and for each a name that no other has."""
    found = [mission_directory(mission) for mission in missions]
    names = [path_name(directory.resolve().name) for directory in found]
    for name in names:
        if names.count(name) > 1:
            raise UserError(f"two missions are called {name}: tiles are named after them; rename the folder of one")
    return list(zip(found, names, strict=True))


def blocks_of(directory: Path, mission: Mission, pings: int) -> Iterator[Block]:
    if mission.reference.truth is None or mission.reference.landmarks is None or not mission.sonar_logs:
        raise UserError(
            f"{directory}: tiles need sonar logs, truth_trajectory.tum and truth_landmarks.csv; `simulate side-scan-survey` makes all three"
        )
    for path in mission.sonar_logs:
        times, pictures = open_log(path), open_log(path)
        while (read := times.read(pings)) is not None and len(read["pings"]["time_s"]):
            time_s = np.asarray(read["pings"]["time_s"], dtype=np.float64)
            if len(time_s) < 2:
                return
            shown = _core.side_scan_pictures(pictures, len(time_s))
            yield Block(time_s, shown["ground"], shown["ground_valid"], shown["ground_nadir_column"], shown["ground_column_m"])


def _tile(
    block: Block, side: str, mission: Mission, object_m: tuple[float, float]
) -> tuple[NDArray[np.uint8], NDArray[np.uint8], list[Box]]:
    """Levels, where they are a measurement, and the boxes of the objects that it shows whole."""
    columns = slice(0, block.nadir_column) if side == "port" else slice(block.nadir_column, None)
    levels, alpha = block.grey[:, columns].copy(), block.valid[:, columns].copy()
    rows, width = levels.shape
    kept = []
    for row, range_m, row_m, _ in abeam(block.time_s, mission, side):
        along = max(1, round(object_m[0] / row_m))
        across = max(1, round(object_m[1] / block.column_m))
        near = round((range_m - PART_BEFORE * object_m[1]) / block.column_m)
        left = width - near - across if side == "port" else near
        box = (left, row - along // 2, across, along)
        x, y, x_end, y_end = max(left, 0), max(box[1], 0), min(left + across, width), min(box[1] + along, rows)
        if x >= x_end or y >= y_end:
            continue
        if (x_end - x, y_end - y) == (across, along) and alpha[y:y_end, x:x_end].all():
            kept.append(box)
        else:
            alpha[y:y_end, x:x_end] = 0
    whole = [box for box in kept if alpha[box[1] : box[1] + box[3], box[0] : box[0] + box[2]].all()]
    levels[alpha == 0] = 0
    return levels, alpha, whole


def _longest_run_without(boxes: Sequence[Box], rows: int) -> slice:
    """The most rows on end that no box covers."""
    taken = np.zeros(rows + 2, dtype=bool)
    taken[[0, -1]] = True
    for _, top, _, height in boxes:
        taken[top + 1 : top + 1 + height] = True
    borders = np.flatnonzero(taken)
    longest = int(np.argmax(np.diff(borders)))
    return slice(int(borders[longest]), int(borders[longest + 1]) - 1)


def abeam(time_s: FloatArray, mission: Mission, side: str) -> list[tuple[int, float, float, int]]:
    """Row, ground range, metres a row and index of every surveyed object that the vehicle passes on this side during these pings."""
    truth, landmarks = mission.reference.truth, mission.reference.landmarks
    assert truth is not None and landmarks is not None
    x, y = (np.interp(time_s, truth.time_s, truth.pose[:, axis]) for axis in (0, 1))
    heading = np.interp(time_s, truth.time_s, np.unwrap(truth.pose[:, 2]))
    row_m = float(np.median(np.hypot(np.diff(x), np.diff(y))))
    found = []
    for index, place in enumerate(landmarks.position_m):
        dx, dy = place[0] - x, place[1] - y
        ahead, starboard = np.cos(heading) * dx + np.sin(heading) * dy, np.cos(heading) * dy - np.sin(heading) * dx
        for row in np.flatnonzero((ahead[:-1] > 0.0) & (ahead[1:] <= 0.0)):
            if row_m > 0.0 and (starboard[row] > 0.0) == (side == "starboard"):
                found.append((int(row), float(abs(starboard[row])), row_m, index))
    return found


def _png(levels: NDArray[np.uint8], alpha: NDArray[np.uint8]) -> bytes:
    file = io.BytesIO()
    Image.merge("LA", (Image.fromarray(levels), Image.fromarray(alpha))).save(file, format="PNG", compress_level=6)
    return file.getvalue()
