"""The topics that the mission of a run fills: what the vehicle measured, and the sonar's picture in strips."""

import base64
import io
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ssjs_cli.formats.mission import Mission
from ssjs_cli.formats.navigation import Scalars
from ssjs_cli.mcap_export import schemas
from ssjs_cli.mcap_export.frames import VEHICLE
from ssjs_cli.mcap_export.topics import Stamped, Topic, stamped
from ssjs_cli.sonar.info import describe_problem
from ssjs_cli.sonar.log_blocks import open_log
from ssjs_cli.sonar.waterfall import Survey, grey_rows, survey_log

JPEG_QUALITY = 80


@dataclass(frozen=True)
class StripSize:
    """pings: rows of a picture; side_px: columns to each side, at most; a log with fewer samples keeps its own."""

    pings: int = 64
    side_px: int = 256


def mission_topics(mission: Mission, strips: StripSize | None, lost: list[str]) -> list[Topic]:
    """No strips: no pictures. `lost` is told, while the pictures are taken, of what could not be read."""
    topics = []
    navigation = mission.navigation
    if navigation is not None and navigation.depth is not None:
        topics.append(Topic("/sensors/depth", schemas.DEPTH, _scalars(navigation.depth, "depth_m")))
    if navigation is not None and navigation.altitude is not None:
        topics.append(Topic("/sensors/altitude", schemas.ALTITUDE, _scalars(navigation.altitude, "altitude_m")))
    if strips is not None:
        for path in mission.sonar_logs:
            name = "/sonar" if len(mission.sonar_logs) == 1 else f"/sonar/{path.stem}"
            topics.append(Topic(name, schemas.COMPRESSED_IMAGE, _strips(path, strips, lost)))
    return topics


def _scalars(series: Scalars, name: str) -> Iterator[Stamped]:
    for time_s, value in zip(series.time_s.tolist(), series.value.tolist(), strict=True):
        yield stamped(time_s, **{name: value})


def _strips(path: Path, size: StripSize, lost: list[str]) -> Iterator[Stamped]:
    """Every ping of the first frequency once, first at the top; a strip has the time of its last ping. Pings without a time belong to
    the strip in hand, and a clock that goes back is held."""
    survey = _narrowed(survey_log(path, None), size.side_px)
    log = open_log(path)
    rows: list[NDArray[np.uint8]] = []
    latest_s = -math.inf
    for time_s, row in grey_rows(log, survey, "log"):
        rows.append(row)
        latest_s = max(latest_s, time_s) if math.isfinite(time_s) else latest_s
        if len(rows) >= size.pings and math.isfinite(latest_s):
            yield _strip(latest_s, rows)
            rows = []
    if rows and math.isfinite(latest_s):
        yield _strip(latest_s, rows)
    elif rows:
        lost.append(f"{path}: no ping has a time, so that its picture is left out")
    lost += [f"{path}: {describe_problem(problem)}" for problem in log.info()["problems"] if problem["data_lost"]]


def _narrowed(survey: Survey, side_px: int) -> Survey:
    """Fewer pixels over the same range; where no range is known a sample is a pixel, and all are kept."""
    return replace(survey, width_px=min(side_px, survey.width_px)) if survey.range_m > 0.0 else survey


def _strip(time_s: float, rows: list[NDArray[np.uint8]]) -> Stamped:
    from PIL import Image

    picture = io.BytesIO()
    Image.fromarray(np.vstack(rows)).save(picture, format="JPEG", quality=JPEG_QUALITY)
    return stamped(time_s, frame_id=VEHICLE, data=base64.b64encode(picture.getvalue()).decode("ascii"), format="jpeg")
