"""When the sonar logs of a mission were recorded: within its navigation, and none twice."""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ssjs_cli.errors import UserError
from ssjs_cli.formats.navigation import IMU_FILE
from ssjs_cli.formats.number_table import FloatArray
from ssjs_cli.sonar.log_blocks import blocks, open_log

# A recorder that goes on in a new file may write its last ping into both.
MAX_OVERLAP_S = 1.0


class LogSpan(NamedTuple):
    first_s: float
    last_s: float
    path: Path


def check_log_times(logs: Sequence[Path], attitude_s: FloatArray) -> None:
    """Reads every log once. Pings of the same time in two logs would be used twice."""
    spans = sorted(span_of(path) for path in logs)
    for span in spans:
        if span.last_s < attitude_s[0] or span.first_s > attitude_s[-1]:
            raise UserError(
                f"{span.path}: its pings, {span.first_s!r} to {span.last_s!r} s, and {IMU_FILE}, {float(attitude_s[0])!r} to "
                f"{float(attitude_s[-1])!r} s, have no time in common; bring both on one clock, or remove the log"
            )
    for before, after in pairwise(spans):
        overlap_s = min(before.last_s, after.last_s) - after.first_s
        if overlap_s > MAX_OVERLAP_S:
            raise UserError(
                f"{after.path}: {overlap_s:g} s of it are also in {before.path.name}, and a sighting counts once; keep one of the logs"
            )


def span_of(path: Path) -> LogSpan:
    """The earliest and the latest time of its pings."""
    log = open_log(path)
    first_s, last_s = np.inf, -np.inf
    for block in blocks(log):
        time_s = block["pings"]["time_s"]
        known_s = time_s[np.isfinite(time_s)]
        first_s, last_s = min(first_s, known_s.min(initial=np.inf)), max(last_s, known_s.max(initial=-np.inf))
    if not log.info()["pings"]:
        raise UserError(f"{path}: holds no side-scan ping; put the log of this survey there, or remove the file")
    if not np.isfinite(first_s):
        raise UserError(f"{path}: none of its pings has a time, so that the vehicle cannot be placed; export the log anew with its times")
    return LogSpan(float(first_s), float(last_s), path)
