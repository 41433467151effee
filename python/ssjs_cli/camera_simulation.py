"""The built-in survey with a down-looking camera: its frames as JPEG, rendered by as many threads as there are processors to run on."""

import os
from collections import deque
from collections.abc import Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from PIL import Image

from ssjs_cli import _core
from ssjs_cli.config import flatten
from ssjs_cli.errors import UserError
from ssjs_cli.formats.camera_calibration import CameraCalibration
from ssjs_cli.formats.frames import FRAMES_FOLDER, FrameIndex
from ssjs_cli.formats.true_surface import TrueSurface

CAMERA_SURVEY = "camera-survey"
CAMERA_SCENARIOS: Mapping[str, Mapping[str, Any]] = MappingProxyType({CAMERA_SURVEY: {}})

QUALITY = 92


class SimulatedCamera:
    """The survey of one seed. Whatever the threads, the same bytes."""

    def __init__(self, built_in: str, name: str, changes: Mapping[str, Any], seed: int) -> None:
        try:
            self._survey = _core.CameraSurvey({**CAMERA_SCENARIOS[built_in], **dict(flatten(changes))}, seed)
        except ValueError as error:
            raise UserError(f"scenario {name} [survey]: {error}") from error

    def survey(self) -> dict[str, Any]:
        return self._survey.survey()

    def frames(self) -> FrameIndex:
        time_s = np.asarray(self._survey.frame_time_s, dtype=np.float64)
        files = tuple(f"{number:06d}.jpg" for number in range(len(time_s)))
        return FrameIndex(Path(FRAMES_FOLDER), time_s, files, CameraCalibration(**self._survey.calibration))

    def surface(self) -> TrueSurface:
        return TrueSurface(**self._survey.relief)

    def photograph(self, folder: Path) -> None:
        """Writes every frame of the index."""
        workers = len(os.sched_getaffinity(0))
        with ThreadPoolExecutor(workers) as pool:
            waiting: deque[Future[None]] = deque()
            for number, name in enumerate(self.frames().files):
                waiting.append(pool.submit(self._write, number, folder / name))
                if len(waiting) > 4 * workers:
                    waiting.popleft().result()
            for future in waiting:
                future.result()

    def _write(self, number: int, path: Path) -> None:
        Image.fromarray(self._survey.frame(number)).save(path, format="JPEG", quality=QUALITY, subsampling=0)
