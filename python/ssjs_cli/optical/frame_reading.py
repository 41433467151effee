"""The frames of a mission, read one after the other: what they hold, and their pixels once more. Those that are worth nothing are named,
none is fatal."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from ssjs_cli.errors import UserError
from ssjs_cli.formats.frame_image import Frame, FrameError, decoded, frame_bytes, frame_size_px
from ssjs_cli.formats.frames import FrameIndex
from ssjs_cli.formats.number_table import FloatArray

#: A mission of many bad frames is told about the first ones by name.
MAX_NAMED = 5


@dataclass(frozen=True)
class UsableFrames:
    """time_s (n,), increasing; paths, features: by frame; size_px: width, height of all. with_region: frames that have a region of
    interest."""

    time_s: FloatArray
    paths: tuple[Path, ...]
    features: tuple[Any, ...]
    size_px: tuple[int, int]
    is_colour: bool
    with_region: int
    given: int

    def straightened(self, lens: dict[str, Any]) -> "UsableFrames":
        return replace(self, features=tuple(features.straightened(lens) for features in self.features))

    def part(self, begin: int, end: int) -> "UsableFrames":
        features = self.features[begin:end]
        with_region = sum(len(found.regions["area_px"]) > 0 for found in features)
        return replace(self, time_s=self.time_s[begin:end], paths=self.paths[begin:end], features=features, with_region=with_region)

    def positions_px(self) -> list[FloatArray]:
        return [features.keypoints["position_px"] for features in self.features]

    def pixels_of(self, number: int) -> Frame:
        """From its file; all with as many channels."""
        frame = decoded(frame_bytes(self.paths[number]))
        return np.repeat(frame[:, :, None], 3, axis=2) if self.is_colour and frame.ndim == 2 else frame


class _RefusalError(Exception):
    """Why a frame is left out."""


def usable_frames(index: FrameIndex, reader: Any, lost: list[str], progress: Callable[[float], bool]) -> UsableFrames:
    """Frames that can be read, have the size of most, hold something, and show something else than those before at a later time.
    Raises UserError when fewer than two are left."""
    times: list[float] = []
    paths: list[Path] = []
    features: list[Any] = []
    size = _usual_size_px(index)
    is_colour = False
    seen: dict[str, str] = {}
    refused: list[str] = []
    for number, time_s in enumerate(index.time_s.tolist()):
        if not progress(number / len(index.files)):
            raise KeyboardInterrupt
        path = index.path(number)
        try:
            data = frame_bytes(path)
            frame = decoded(data)
            _check(frame, size, time_s, times, seen, sha256(data).hexdigest(), path.name)
            found = reader.read(frame)
            if found.left_out is not None:
                raise _RefusalError(f"is {found.left_out}")
        except (FrameError, _RefusalError, ValueError) as error:
            refused.append(f"{path.name} {error}")
            continue
        is_colour = is_colour or frame.ndim == 3
        times.append(time_s)
        paths.append(path)
        features.append(found)
    if refused:
        more = f"; and {len(refused) - MAX_NAMED} more" if len(refused) > MAX_NAMED else ""
        lost.append(f"{len(refused)} of {len(index.files)} frames were left out: {'; '.join(refused[:MAX_NAMED])}{more}")
    if size is None or len(times) < 2:
        raise UserError(f"{index.folder}: fewer than two frames can be used{'; ' + refused[0] if refused else ''}; give more of them")
    with_region = sum(len(found.regions["area_px"]) > 0 for found in features)
    return UsableFrames(np.array(times), tuple(paths), tuple(features), size, is_colour, with_region, len(index.files))


def _usual_size_px(index: FrameIndex) -> tuple[int, int] | None:
    """That of the most frames; of equally many the first one's. None where no file tells."""
    sizes = Counter(size for size in (frame_size_px(index.path(number)) for number in range(len(index.files))) if size is not None)
    return sizes.most_common(1)[0][0] if sizes else None


def _check(
    frame: Frame, size: tuple[int, int] | None, time_s: float, times: list[float], seen: dict[str, str], digest: str, name: str
) -> None:
    here = (frame.shape[1], frame.shape[0])
    if size is not None and here != size:
        raise _RefusalError(f"has {here[0]} x {here[1]} pixels, and most have {size[0]} x {size[1]}")
    if times and time_s <= times[-1]:
        raise _RefusalError("was taken at the time of the frame before")
    if digest in seen:
        raise _RefusalError(f"is a duplicate of {seen[digest]}")
    seen[digest] = name
