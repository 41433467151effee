"""When frames were taken: from a table, an interval, their names, or what their camera wrote into them (EXIF)."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from PIL import Image

from ssjs_cli.errors import UserError
from ssjs_cli.formats.frames import read_index

_DATE = re.compile(r"(?<!\d)(\d{4}|\d{2})-?(\d{2})-?(\d{2})[_T ](\d{2})[-:h]?(\d{2})[-:m]?(\d{2})(?!\d)")
_EPOCH_S = re.compile(r"(?<!\d)(\d{10}\.\d{1,9})(?!\d)")
_EPOCH_WHOLE = re.compile(r"(?<!\d)(\d{19}|\d{16}|\d{13})(?!\d)")
_DIGITS_OF_A_SECOND = {19: 10**9, 16: 10**6, 13: 10**3}
_CENTURY_ENDS = 70  # 70 to 99 are of the last century
_EXIF, _EXIF_TAKEN, _EXIF_PART = 0x8769, 0x9003, 0x9291


@dataclass(frozen=True)
class FrameTimes:
    """In the order in which they were taken; `source` says where from."""

    time_s: list[float]
    files: list[str]
    source: str
    lost: list[str]


def frame_times(folder: Path, names: Sequence[str], table: Path | None, interval_s: float | None) -> FrameTimes:
    """names: the images of the folder, in natural order."""
    if table is not None and interval_s is not None:
        raise UserError("--times and --interval: give one of them")
    if table is not None:
        return _of_table(table, names)
    if interval_s is not None:
        return FrameTimes([number * interval_s for number in range(len(names))], list(names), f"every {interval_s:g} s", [])
    for read, source in ((time_in_name, "their names"), (lambda name: exif_time(folder / name), "EXIF")):
        known = [read(name) for name in names]
        if all(time is not None for time in known):
            order = sorted(range(len(names)), key=lambda number: known[number] or 0.0)  # stable: equal times keep their order
            return FrameTimes([known[number] or 0.0 for number in order], [names[number] for number in order], source, [])
    unread = next(name for name in names if time_in_name(name) is None)
    raise UserError(
        f"{folder / unread}: neither its name nor its EXIF tells when it was taken; give --times FILE (a table time_s,file) or --interval S"
    )


def _of_table(path: Path, names: Sequence[str]) -> FrameTimes:
    time_s, files = read_index(path)
    there, named = set(names), set(files)
    lost = [f"{name} of {path.name} is missing among the images" for name in dict.fromkeys(files) if name not in there]
    lost += [f"{name} has no time in {path.name} and was not taken along" for name in names if name not in named]
    kept = [(float(time), name) for time, name in zip(time_s.tolist(), files, strict=True) if name in there]
    return FrameTimes([time for time, _ in kept], [name for _, name in kept], path.name, lost)


def time_in_name(name: str) -> float | None:
    """ESC.970621_234744.0001.png, 20230615T101530.jpg, 1423232339.123456.png, ...: seconds since 1970, UTC."""
    stem = name.rsplit(".", 1)[0]
    if (seconds := _EPOCH_S.search(stem)) is not None:
        return float(seconds[1])
    if (whole := _EPOCH_WHOLE.search(stem)) is not None:
        return int(whole[1]) / _DIGITS_OF_A_SECOND[len(whole[1])]
    if (date := _DATE.search(stem)) is None:
        return None
    year, *rest = (int(text) for text in date.groups())
    if len(date[1]) == 2:
        year += 1900 if year >= _CENTURY_ENDS else 2000
    return _since_1970(year, rest)


def exif_time(path: Path) -> float | None:
    try:
        with Image.open(path) as picture:
            tags = picture.getexif().get_ifd(_EXIF)
    except Exception:  # a damaged file has no time; it is named when its picture is read
        return None
    numbers = [int(text) for text in re.findall(r"\d+", str(tags.get(_EXIF_TAKEN, "")))]
    if len(numbers) != 6:
        return None
    part = re.sub(r"\D", "", str(tags.get(_EXIF_PART, "")))
    whole_s = _since_1970(numbers[0], numbers[1:])
    return None if whole_s is None else whole_s + (int(part) / 10 ** len(part) if part else 0.0)


def _since_1970(year: int, rest: Sequence[int]) -> float | None:
    """rest: month, day, hour, minute, second."""
    month, day, hour, minute, second = rest
    try:
        return datetime(year, month, day, hour, minute, second, tzinfo=UTC).timestamp()
    except ValueError:
        return None
