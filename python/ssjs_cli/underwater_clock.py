"""The sensors of an underwater mission on one clock: what has no common time, or no time at all, is told before anything is estimated."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ssjs_cli.errors import UserError
from ssjs_cli.formats.frames import FRAME_INDEX_FILE, FRAMES_FOLDER
from ssjs_cli.formats.mission import OBSERVATIONS_FILE, Mission
from ssjs_cli.formats.navigation import ALTITUDE_FILE, DEPTH_FILE, DVL_FILE, IMU_FILE, POSITION_FIXES_FILE, UnderwaterNavigation
from ssjs_cli.formats.number_table import FloatArray, NumberTable

# Slower attitude is that of no vehicle, but one in other units.
MAX_ATTITUDE_STEP_S = 30.0
# The estimator knows nothing of a vehicle after this long without any record.
MAX_SILENCE_S = 4.0 * 3600.0

Series = tuple[str, FloatArray]


def check_clock(mission: Mission, navigation: UnderwaterNavigation, directory: Path) -> None:
    series = _series(mission, navigation)
    for name, time_s in series:
        if len(time_s) > 1 and time_s[0] == time_s[-1] and name not in (OBSERVATIONS_FILE, POSITION_FIXES_FILE):
            raise UserError(f"{directory / name}: all {len(time_s)} lines have the time {float(time_s[0])!r}; give each record its own")
    attitude_s = navigation.attitude.time_s
    if not attitude_s[-1] > attitude_s[0]:
        raise UserError(f"{directory / IMU_FILE}: holds one moment alone; a mission needs the attitude over a time")
    step_s = float(np.median(np.diff(attitude_s)))
    if step_s > MAX_ATTITUDE_STEP_S:
        raise UserError(
            f"{directory / IMU_FILE}: its lines are {step_s:g} s apart (median), and {MAX_ATTITUDE_STEP_S:g} s is the most; "
            "times are in s: convert milliseconds, microseconds or nanoseconds"
        )
    for name, time_s in series:
        _require_overlap(directory / name, time_s, attitude_s)
    _require_no_silence(series, directory)


def _series(mission: Mission, navigation: UnderwaterNavigation) -> list[Series]:
    parts = (
        (IMU_FILE, navigation.attitude),
        (DVL_FILE, navigation.velocity),
        (DEPTH_FILE, navigation.depth),
        (ALTITUDE_FILE, navigation.altitude),
        (POSITION_FIXES_FILE, navigation.fixes),
        (OBSERVATIONS_FILE, mission.points),
        (f"{FRAMES_FOLDER}/{FRAME_INDEX_FILE}", mission.frames),
    )
    return [(name, part.time_s) for name, part in parts if part is not None]


def _require_overlap(path: Path, time_s: FloatArray, attitude_s: FloatArray) -> None:
    if time_s[-1] >= attitude_s[0] and time_s[0] <= attitude_s[-1]:
        return
    raise UserError(
        f"{path}: its times, {_span(time_s)}, and those of {IMU_FILE}, {_span(attitude_s)}, have nothing in common; "
        "bring both on one clock, in s"
    )


def _span(time_s: FloatArray) -> str:
    return f"{float(time_s[0])!r} to {float(time_s[-1])!r}"


def _require_no_silence(series: Sequence[Series], directory: Path) -> None:
    """Records of any sensor count."""
    merged = np.sort(np.concatenate([time_s for _, time_s in series]))
    gaps_s = np.diff(merged)
    gap = int(np.argmax(gaps_s))
    if gaps_s[gap] <= MAX_SILENCE_S:
        return
    after_s = merged[gap + 1]
    for name, time_s in series:
        row = int(np.searchsorted(time_s, after_s))
        if row < len(time_s) and time_s[row] == after_s:
            where = NumberTable(directory / name, {}, len(time_s)).where(row)
            raise UserError(
                f"{where}: time_s = {float(after_s)!r} comes {gaps_s[gap]:g} s after every record before it, when nothing is known of the "
                "vehicle any more; mend the clock, or split the mission"
            )
