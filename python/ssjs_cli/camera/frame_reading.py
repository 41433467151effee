"""From the frames of a mission to keypoints: read by several threads, taken in their order, so that the answer does not depend on them."""

import hashlib
import os
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from ssjs_cli import _core
from ssjs_cli.config import Scalar, frame_values
from ssjs_cli.errors import UserError
from ssjs_cli.formats.camera_calibration import CameraCalibration
from ssjs_cli.formats.frame_image import FrameError, decoded, frame_bytes
from ssjs_cli.formats.frames import CALIBRATION_FILE, FrameIndex, FrameKeypoints
from ssjs_cli.formats.mission import Mission
from ssjs_cli.formats.number_table import FloatArray
from ssjs_cli.formats.run_directory import FRAMES_FILE

#: What is wrong with a frame that is lost, by the one word of its outcome. Others that are left out (dark, blank, blurred) show nothing.
LOST_KINDS: Mapping[str, str] = MappingProxyType(
    {
        "missing": "are missing",
        "damaged": "cannot be read",
        "duplicate": "are duplicates of others",
        "size": "are not of the size of their calibration",
        "outside": "lie outside the time of the vehicle's attitude",
    }
)


#: In one line; all are in the table of the run.
MOST_NAMED = 10


@dataclass(frozen=True)
class FrameOutcome:
    """What became of one frame. `kind` and `reason` are empty where it was used."""

    time_s: float
    file: str
    kind: str
    reason: str
    regions: int = 0
    keypoints: int = 0


@dataclass(frozen=True)
class _Read:
    kind: str = ""
    reason: str = ""
    content: str = ""
    regions: int = 0
    pixel: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))
    descriptor: NDArray[np.float32] = field(default_factory=lambda: np.zeros((0, 0), dtype=np.float32))


def frame_reader(frames: FrameIndex, settings: Mapping[str, Scalar]) -> _core.FrameReader:
    """With the settings `frames.*` and the calibration of the mission."""
    calibration = None if frames.calibration is None else asdict(frames.calibration)
    try:
        return _core.FrameReader(frame_values(settings), calibration)
    except ValueError as error:
        raise UserError(f"{frames.folder}: {error}") from error


def read_keypoints(
    frames: FrameIndex,
    settings: Mapping[str, Scalar],
    span_s: tuple[float, float],
    progress: Callable[[float], bool] | None = None,
    workers: int | None = None,
) -> tuple[FrameKeypoints, list[FrameOutcome]]:
    """Of the frames within a span of time. One outcome a frame, in the order of the index; the same for any number of workers."""
    if frames.calibration is None:
        raise UserError(f"{frames.folder / CALIBRATION_FILE}: is missing; the way of the vehicle needs the calibration of its camera")
    reader, camera = frame_reader(frames, settings), frames.calibration
    _core.set_image_threads(1)  # each frame is one thread's
    outcomes: list[FrameOutcome] = []
    used: list[_Read] = []
    seen: dict[str, str] = {}
    for number, read in enumerate(_in_order(frames, lambda path: _read(path, reader, camera), workers or len(os.sched_getaffinity(0)))):
        if progress is not None and not progress(number / len(frames.files)):
            break
        name, time_s = frames.files[number], float(frames.time_s[number])
        kind, reason = read.kind, read.reason
        if not span_s[0] <= time_s <= span_s[1]:
            kind, reason = "outside", f"was taken at {time_s!r} s, outside the time of the vehicle's attitude"
        if not kind and read.content in seen:
            again = seen[read.content] == name
            kind, reason = "duplicate", "is named twice" if again else f"is a duplicate of {seen[read.content]}"
        seen.setdefault(read.content, name)
        outcomes.append(FrameOutcome(time_s, name, kind, reason, read.regions, 0 if kind else len(read.pixel)))
        if not kind:
            used.append(read)
    return _keypoints(used, [outcome.time_s for outcome in outcomes if not outcome.kind]), outcomes


def _in_order(frames: FrameIndex, read: Callable[[Path], _Read], workers: int) -> Iterator[_Read]:
    with ThreadPoolExecutor(workers) as pool:
        waiting: deque[Future[_Read]] = deque()
        try:
            for number in range(len(frames.files)):
                waiting.append(pool.submit(read, frames.path(number)))
                if len(waiting) > 4 * workers:
                    yield waiting.popleft().result()
            while waiting:
                yield waiting.popleft().result()
        finally:
            for future in waiting:
                future.cancel()


def _read(path: Path, reader: _core.FrameReader, camera: CameraCalibration) -> _Read:
    try:
        frame = decoded(frame_bytes(path))
    except FrameError as error:
        return _Read("missing" if str(error) == "is missing" else "damaged", str(error))
    rows, columns = frame.shape[:2]
    if (columns, rows) != (camera.width_px, camera.height_px):
        return _Read("size", f"has {columns} x {rows} pixels, and its calibration is of {camera.width_px} x {camera.height_px}")
    content = hashlib.sha256(frame.tobytes()).hexdigest()
    features = reader.read(frame)
    if features.left_out is not None:
        return _Read(features.left_out.split(":")[0], f"is {features.left_out}", content)
    return _Read("", "", content, len(features.regions["area_px"]), features.keypoints["position_px"], features.descriptors)


def _keypoints(used: list[_Read], time_s: list[float]) -> FrameKeypoints:
    """A frame without keypoints has no descriptors either, whatever their width."""
    rows = [read.descriptor for read in used if len(read.pixel)]
    return FrameKeypoints(
        np.array(time_s, dtype=np.float64),
        np.array([len(read.pixel) for read in used], dtype=np.int64),
        np.concatenate([read.pixel for read in used]) if used else np.zeros((0, 2)),
        np.concatenate(rows) if rows else np.zeros((0, 0), dtype=np.float32),
    )


def with_keypoints(
    mission: Mission, settings: Mapping[str, Scalar], lost: list[str], progress: Callable[[float], bool] | None = None
) -> tuple[Mission, list[FrameOutcome]]:
    """The mission with what is seen in its frames; `lost` is told of those that could not be read."""
    if mission.frames is None or mission.navigation is None:
        return mission, []
    attitude_s = mission.navigation.attitude.time_s
    keypoints, outcomes = read_keypoints(mission.frames, settings, (float(attitude_s[0]), float(attitude_s[-1])), progress)
    lost += lost_frames(outcomes)
    return replace(mission, keypoints=keypoints), outcomes


def lost_frames(outcomes: Sequence[FrameOutcome]) -> list[str]:
    """One line for each thing that can be wrong, with the names of the frames."""
    texts = []
    for kind, text in LOST_KINDS.items():
        of_kind = [outcome for outcome in outcomes if outcome.kind == kind]
        if not of_kind:
            continue
        named = "; ".join(f"{outcome.file} {outcome.reason}" for outcome in of_kind[:MOST_NAMED])
        more = f"; the others are in {FRAMES_FILE}" if len(of_kind) > MOST_NAMED else ""
        texts.append(f"{len(of_kind)} of {len(outcomes)} frames {text}: {named}{more}")
    return texts
