"""The frames of a camera mission: the folder frames/ with the pictures, when each was taken (index.csv), and where it is known the
calibration of their camera (camera.yaml).

A file that the index names may be missing or damaged: the run leaves such a frame out and says so. The index itself must be right.
"""

import csv
import io
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ssjs_cli.errors import UserError, nearest_hint
from ssjs_cli.formats.camera_calibration import CameraCalibration, read_calibration
from ssjs_cli.formats.file_digest import file_digest
from ssjs_cli.formats.number_table import FloatArray, IntArray, NumberTable, holds_file, read_text, require_finite, require_times_in_order
from ssjs_cli.formats.physical_bounds import require_plausible

FRAMES_FOLDER = "frames"
FRAME_INDEX_FILE = "index.csv"
CALIBRATION_FILE = "camera.yaml"
INDEX_COLUMNS = ("time_s", "file")


@dataclass(frozen=True)
class FrameIndex:
    """time_s (n,), not decreasing; files (n): names in `folder`. `calibration` of the pictures as they were taken."""

    folder: Path
    time_s: FloatArray
    files: tuple[str, ...]
    calibration: CameraCalibration | None = None

    def path(self, frame: int) -> Path:
        return self.folder / self.files[frame]


@dataclass(frozen=True)
class FrameKeypoints:
    """Of the frames that were used: time_s (n,), count (n,) keypoints of each; pixel (m, 2) u, v of the corrected frame and descriptor
    (m, d), those of the first frame first. landmark_id (m,): where it is known what they show, and descriptors are not needed."""

    time_s: FloatArray
    count: IntArray
    pixel: FloatArray
    descriptor: NDArray[np.float32]
    landmark_id: IntArray | None = None


def read_frames(directory: Path) -> FrameIndex | None:
    """None where the mission has no folder of frames."""
    outline = outline_frames(directory)
    if outline is None:
        return None
    index = outline.folder / FRAME_INDEX_FILE
    time_s, files = read_index(index)
    return FrameIndex(outline.folder, time_s, files, outline.calibration)


def outline_frames(directory: Path) -> FrameIndex | None:
    """The camera alone, without its frames."""
    folder = directory / FRAMES_FOLDER
    if not folder.is_dir():
        if folder.exists() or folder.is_symlink():
            raise UserError(f"{folder}: is no folder; the frames of a mission lie in one of this name")
        return None
    if not holds_file(folder / FRAME_INDEX_FILE):
        raise UserError(f"{folder / FRAME_INDEX_FILE}: is missing; give when each frame was taken, with the columns time_s,file")
    calibration = folder / CALIBRATION_FILE
    return FrameIndex(folder, np.zeros(0), (), read_calibration(calibration) if holds_file(calibration) else None)


def read_index(path: Path) -> tuple[FloatArray, tuple[str, ...]]:
    """Times, not decreasing, and the names of the frames."""
    if not path.is_file():
        raise UserError(f"{path}: is missing; it needs the columns time_s,file")
    lines = [line if line.strip() and not line.lstrip().startswith("#") else "" for line in read_text(path).split("\n")]
    reader = csv.reader(io.StringIO("\n".join(lines)), strict=True)
    header: list[str] = []
    times: list[str] = []
    files: list[str] = []
    try:
        for row in reader:
            fields = [field.strip() for field in row]
            if not fields:
                continue
            if not header:
                header = _checked_header(fields, path, reader.line_num)
                continue
            if len(fields) != len(header):
                raise UserError(f"{path}:{reader.line_num}: has {len(fields)} fields where {len(header)} are needed (time_s,file)")
            times.append(fields[header.index("time_s")])
            files.append(_checked_name(fields[header.index("file")], f"{path}:{reader.line_num}"))
            _require_number(times[-1], f"{path}:{reader.line_num}")
    except csv.Error as error:
        raise UserError(f"{path}:{reader.line_num}: cannot be read ({error}); mend the quotes of the line") from error
    if not files:
        raise UserError(f"{path}: names no frame; give one line a frame after the header time_s,file")
    table = NumberTable(path, {"time_s": np.array([float(text) for text in times])}, len(times))
    require_finite(table, "time_s")
    require_plausible(table, ("time_s",))
    require_times_in_order(table)
    return table["time_s"], tuple(files)


def _checked_header(names: list[str], path: Path, line: int) -> list[str]:
    for name in names:
        if name not in INDEX_COLUMNS:
            raise UserError(f"{path}:{line}: unknown column '{name}'{nearest_hint(name, INDEX_COLUMNS)}; known columns: time_s,file")
    missing = [name for name in INDEX_COLUMNS if names.count(name) != 1]
    if missing:
        raise UserError(f"{path}:{line}: column {','.join(missing)} must be there once; the header holds {','.join(names)}")
    return names


def _checked_name(name: str, where: str) -> str:
    """Nothing outside the folder: a mission can come from anywhere."""
    if name in ("", ".", "..", FRAME_INDEX_FILE, CALIBRATION_FILE) or any(character in name for character in "/\\\0"):
        raise UserError(f"{where}: file = '{name}' is no name of a picture in the folder {FRAMES_FOLDER}/; put it there, and give its name")
    return name


def _require_number(text: str, where: str) -> None:
    try:
        float(text)
    except ValueError as error:
        raise UserError(f"{where}: time_s = '{text}' is not a number; correct or remove the line") from error


# --- writing and digests ---------------------------------------------------------------------------------------------


def index_text(time_s: FloatArray, files: tuple[str, ...] | list[str]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(INDEX_COLUMNS)
    writer.writerows((repr(float(time)), name) for time, name in zip(time_s.tolist(), files, strict=True))
    return text.getvalue()


def frame_digests(directory: Path) -> dict[str, str]:
    """sha256 of the index and of the calibration, and one over all pictures, in the order of their names."""
    folder = directory / FRAMES_FOLDER
    if not folder.is_dir():
        return {}
    digests = {}
    for name in (FRAME_INDEX_FILE, CALIBRATION_FILE):
        if (folder / name).is_file():
            digests[f"{FRAMES_FOLDER}/{name}"] = file_digest(folder / name)
    whole = sha256()
    for path in frame_files(folder):
        whole.update(f"{path.name}:{file_digest(path)}\n".encode())
    digests[f"{FRAMES_FOLDER}/*"] = whole.hexdigest()
    return digests


def frame_files(folder: Path) -> list[Path]:
    """In the order of their names."""
    return sorted(path for path in folder.iterdir() if path.is_file() and path.name not in (FRAME_INDEX_FILE, CALIBRATION_FILE))
