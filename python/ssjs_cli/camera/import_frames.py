"""A folder of images as a mission: its frames with their times, the calibration of their camera, and what else lies in the folder of the
vehicle's own sensors and of the truth."""

import hashlib
import re
import shutil
from pathlib import Path

import numpy as np

from ssjs_cli.camera.frame_times import frame_times
from ssjs_cli.errors import UserError
from ssjs_cli.formats.camera_calibration import CameraCalibration, read_calibration
from ssjs_cli.formats.frame_image import SUFFIXES, FrameError, decoded, frame_bytes
from ssjs_cli.formats.frames import CALIBRATION_FILE, FRAME_INDEX_FILE, FRAMES_FOLDER, FrameIndex
from ssjs_cli.formats.mission import ImportRecord, Mission, ReferenceDescription, read_reference
from ssjs_cli.formats.navigation import read_navigation


def import_frames(source: Path, calibration: Path | None, times: Path | None, interval_s: float | None) -> Mission:
    """The images themselves are copied as they are when the mission is written. Damaged, repeated and missing ones are named as lost."""
    names = _images_in(source)
    if times is None and interval_s is None and (source / FRAME_INDEX_FILE).is_file():
        times = source / FRAME_INDEX_FILE
    if calibration is None and (source / CALIBRATION_FILE).is_file():
        calibration = source / CALIBRATION_FILE
    camera = None if calibration is None else read_calibration(calibration)
    timed = frame_times(source, names, times, interval_s)
    lost = list(timed.lost)
    kept, digest = _usable(source, timed.files, camera, lost)
    if not kept:
        raise UserError(f"{source}: holds no frame that can be used: {'; '.join(lost[:3])}")
    time_s = np.array([timed.time_s[number] for number in kept])
    files = tuple(timed.files[number] for number in kept)
    same = int((np.diff(time_s) == 0.0).sum())
    return Mission(
        name=source.resolve().name,
        description=f"frames of {source.name}",
        notes=f"times from {timed.source}" + (f"; {same} frames have the time of the one before" if same else ""),
        frames=FrameIndex(source / FRAMES_FOLDER, time_s, files, camera),
        photographs=lambda folder: _copy(source, files, folder),
        navigation=read_navigation(source),
        reference=read_reference(source, ReferenceDescription()),
        import_record=ImportRecord(
            format="frames", counts={"images": len(names), "frames": len(files)}, lost=lost, digests={"images": digest}
        ),
    )


def _images_in(source: Path) -> list[str]:
    """In natural order: 2 before 10."""
    if not source.is_dir():
        raise UserError(f"{source}: is no folder; name the folder that holds the images")
    names = [path.name for path in source.iterdir() if path.suffix.lower() in SUFFIXES and not path.name.startswith(".")]
    if not names:
        raise UserError(f"{source}: holds no image ({', '.join(SUFFIXES)}); name the folder that holds the images")
    return sorted(names, key=_natural)


def _natural(name: str) -> list[tuple[int, int, str]]:
    return [(0, int(part), "") if part.isdecimal() else (1, 0, part) for part in re.split(r"(\d+)", name) if part]


def _usable(source: Path, files: list[str], camera: CameraCalibration | None, lost: list[str]) -> tuple[list[int], str]:
    """Which of them can be read and show something that no earlier one does; and a digest of all that were read."""
    kept: list[int] = []
    sizes: list[str] = []
    seen: dict[str, str] = {}
    whole = hashlib.sha256()
    for number, name in enumerate(files):
        try:
            data = frame_bytes(source / name)
            whole.update(data)
            frame = decoded(data)
        except FrameError as error:
            lost.append(f"{name} {error}")
            continue
        content = hashlib.sha256(data).hexdigest()
        if content in seen:
            lost.append(f"{name} is a duplicate of {seen[content]}")
            continue
        seen[content] = name
        kept.append(number)
        sizes.append(f"{frame.shape[1]} x {frame.shape[0]}")
    if camera is not None:
        right = f"{camera.width_px} x {camera.height_px}"
        other = [(files[number], size) for number, size in zip(kept, sizes, strict=True) if size != right]
        if len(other) == len(kept) > 1 and len(set(sizes)) == 1:
            lost.append(f"all {len(kept)} frames have {sizes[0]} pixels, and the calibration is of {right}")
        else:
            lost += [f"{name} has {size} pixels, and the calibration is of {right}" for name, size in other]
    return kept, whole.hexdigest()


def _copy(source: Path, files: tuple[str, ...], folder: Path) -> None:
    for name in files:
        shutil.copyfile(source / name, folder / name)
