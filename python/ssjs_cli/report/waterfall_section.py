"""The sonar picture of the whole mission in lines, time to the right and port at the top, with what was detected."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ssjs_cli.formats.number_table import FloatArray
from ssjs_cli.report.number_text import count_text, finite_number
from ssjs_cli.report.picture_data import jpeg_url
from ssjs_cli.report.survey_files import SurveyFiles, WaterfallPictures
from ssjs_cli.report.ticks import nice_ticks

LINE_WIDTH = 1200
LINE_HEIGHT = 180
STRETCH_WIDTH = 580
STRETCH_HEIGHT = 392
LINE_QUALITY = 62
STRETCH_QUALITY = 80
MAX_MARKS = 3000
#: Beyond so many contacts their numbers would hide the picture.
MAX_NUMBERS = 150


@dataclass(frozen=True)
class Mark:
    """A sighting, in the drawn units of its picture; label: number of the contact where this is its most trusted sighting."""

    x: float
    y: float
    text: str
    is_contact: bool
    label: str = ""


@dataclass(frozen=True)
class DrawnLine:
    """url: the picture as a data URL; ticks: (place, text) along time (below) and along range (left)."""

    url: str
    width: int
    height: int
    marks: list[Mark]
    time_ticks: list[tuple[float, str]]
    range_ticks: list[tuple[float, str]]


@dataclass(frozen=True)
class WaterfallSection:
    lines: list[DrawnLine]
    note: str


@dataclass(frozen=True)
class _Sighting:
    time_s: float
    across_m: float
    contact: str
    confidence: float
    is_best: bool


def waterfall(survey: SurveyFiles) -> WaterfallSection | None:
    pictures = survey.waterfall
    if pictures is None:
        return None
    found = _sightings(survey)
    range_m = finite_number(pictures.index.get("range_m")) or 1.0
    lines = []
    for entry in _entries(pictures.index.get("lines")):
        lines.append(_line(survey, pictures, entry, range_m, range_m, found, (LINE_WIDTH, LINE_HEIGHT), LINE_QUALITY))
    lines = [line for line in lines if line is not None]
    if not lines:
        return None
    pings, per_row = (int(finite_number(pictures.index.get(key)) or 1) for key in ("pings", "pings_per_row"))
    one = "each column one ping" if per_row == 1 else f"{per_row} pings a column"
    note = (
        f"{count_text(pings)} pings in {len(lines)} line{'' if len(lines) == 1 else 's'}, {one}; ground range [m], gain normalised, "
        "port at the top, the track in the middle. Black: not looked at (turns, nadir). "
        + ("Rings: sightings of contacts on the map; crosses: detections that are none." if found else "")
    )
    return WaterfallSection([line for line in lines if line is not None], note)


def stretch(survey: SurveyFiles) -> DrawnLine | None:
    """The block of pings with the most contacts, with every pixel of it."""
    pictures = survey.waterfall
    entry = None if pictures is None else pictures.index.get("stretch")
    if pictures is None or not isinstance(entry, dict):
        return None
    port_m, starboard_m = (finite_number(entry.get(key)) or 1.0 for key in ("port_m", "starboard_m"))
    return _line(survey, pictures, entry, port_m, starboard_m, _sightings(survey), (STRETCH_WIDTH, STRETCH_HEIGHT), STRETCH_QUALITY)


def _entries(value: Any) -> list[dict[str, Any]]:
    return [entry for entry in value if isinstance(entry, dict)] if isinstance(value, list) else []


def _line(
    survey: SurveyFiles,
    pictures: WaterfallPictures,
    entry: dict[str, Any],
    port_m: float,
    starboard_m: float,
    found: Sequence[_Sighting],
    size: tuple[int, int],
    quality: int,
) -> DrawnLine | None:
    path = pictures.folder / str(entry.get("picture"))
    time_s = np.array(entry.get("time_s", []), dtype=np.float64) - survey.time_origin_s
    if not path.is_file() or len(time_s) < 2:
        return None
    width, height = size
    across = height / (port_m + starboard_m)
    rows = np.arange(len(time_s)) + 0.5
    # the last line of a mission is shorter than the others, at the same scale
    drawn_width = width if size == (STRETCH_WIDTH, STRETCH_HEIGHT) else max(round(width * min(len(time_s) / _longest(pictures), 1.0)), 1)

    def place(at_s: float) -> float:
        return round(float(np.interp(at_s, time_s, rows)) * drawn_width / len(time_s), 2)

    step_s = float(np.median(np.diff(time_s)))
    marks = []
    for sighting in found:
        if time_s[0] - step_s <= sighting.time_s <= time_s[-1] + step_s:
            label = sighting.contact if sighting.is_best else ""
            text = f"contact {sighting.contact}" if sighting.contact else "detection on no landmark"
            side = "starboard" if sighting.across_m > 0.0 else "port"
            text += f": {abs(sighting.across_m):.1f} m {side}, t = {sighting.time_s:.1f} s, confidence {sighting.confidence:.2f}"
            marks.append(Mark(place(sighting.time_s), round((port_m + sighting.across_m) * across, 2), text, bool(sighting.contact), label))
    ticks = [(place(at_s), f"{at_s:,.0f} s") for at_s in nice_ticks(float(time_s[0]), float(time_s[-1]), max(drawn_width // 120, 1))]
    ranges = [
        (round((port_m + at_m) * across, 2), f"{abs(at_m):.0f}") for at_m in nice_ticks(-port_m, starboard_m, 4 if height < 250 else 8)
    ]
    return DrawnLine(jpeg_url(path, quality), drawn_width, height, marks, ticks, ranges)


def _longest(pictures: WaterfallPictures) -> int:
    return max(len(entry.get("time_s", [])) for entry in _entries(pictures.index.get("lines")))


def _sightings(survey: SurveyFiles) -> list[_Sighting]:
    best: FloatArray = np.array([_number(row, "time_s") for row in survey.contacts or []], dtype=np.float64)
    numbered = len(best) <= MAX_NUMBERS
    rows = survey.sightings or []
    answer = []
    for row in rows[:MAX_MARKS]:
        time_s, range_m = _number(row, "time_s"), _number(row, "ground_range_m")
        if not np.isfinite(time_s + range_m):
            continue
        across_m = range_m if row.get("channel") == "starboard" else -range_m
        contact = row.get("contact", "")
        is_best = numbered and contact != "" and _is_best(survey, contact, time_s)
        confidence = _number(row, "confidence")
        answer.append(_Sighting(time_s - survey.time_origin_s, across_m, contact, confidence, is_best))
    return answer


def _is_best(survey: SurveyFiles, contact: str, time_s: float) -> bool:
    return any(row.get("id") == contact and abs(_number(row, "time_s") - time_s) < 2e-3 for row in survey.contacts or [])


def _number(row: dict[str, str], key: str) -> float:
    try:
        return float(row.get(key, ""))
    except ValueError:
        return float("nan")
