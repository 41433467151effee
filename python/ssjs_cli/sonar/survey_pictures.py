"""The pictures of a finished survey in its run directory: a snippet and a strip of each contact, the whole waterfall, and the stretch with
the most contacts. Snippets lie in ground range with square pixels, port on the left, the first ping at the top."""

import io
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ssjs_cli.formats.number_table import FloatArray
from ssjs_cli.formats.run_directory import SNIPPETS_FOLDER, WATERFALL_FOLDER, WATERFALL_INDEX_FILE
from ssjs_cli.formats.tum import PoseSeries
from ssjs_cli.sonar.contacts import Sighting, snippet_name
from ssjs_cli.sonar.survey_record import ByteImage, Picture, SurveyRecord

#: A snippet shows a square of this side around its contact.
SNIPPET_M = 16.0
SNIPPET_PX = 320
BOX_COLOUR = (255, 196, 0)
#: Left free between the echo and its box.
BOX_MARGIN_M = 0.4
#: Of a strip along track: the whole swath across.
STRIP_M = 16.0
STRIP_WIDTH_PX = 640
#: Rows of the whole waterfall that are drawn in one line of the page.
ROWS_A_LINE = 1240
SPEED_WINDOW_S = 2.0
LEAST_SPACING_M = 1e-3
MOST_LINES = 8


@dataclass(frozen=True)
class Window:
    """What a drawn picture shows: metres to starboard of the track on the left and on the right, metres behind the contact's ping at the
    top and at the bottom."""

    left_m: float
    right_m: float
    top_m: float
    bottom_m: float


def write_contact_pictures(directory: Path, track: PoseSeries, best: Mapping[int, Sighting], record: SurveyRecord) -> None:
    """best: the most trusted sighting of each contact, by its number."""
    folder = directory / SNIPPETS_FOLDER
    chosen = {number: sighting for number, sighting in best.items() if sighting.picture is not None}
    if not chosen:
        return
    folder.mkdir()
    for number, sighting in sorted(chosen.items()):
        assert sighting.picture is not None
        picture = record.picture(sighting.picture)
        spacing_m = _row_spacing_m(track, sighting, picture)
        (folder / snippet_name(number)).write_bytes(_snippet(picture, sighting.found, spacing_m))
        (folder / strip_name(number)).write_bytes(_strip(picture, sighting.found, spacing_m))


def strip_name(number: int) -> str:
    return f"contact-{number:04d}-strip.png"


def write_waterfall(directory: Path, record: SurveyRecord) -> None:
    """The whole mission in lines, time to the right and port at the top, and the stretch with the most contacts the same way."""
    rows, time_s = record.waterfall()
    if not len(rows):
        return
    folder = directory / WATERFALL_FOLDER
    folder.mkdir()
    group = max(1, math.ceil(len(rows) / (ROWS_A_LINE * MOST_LINES)))
    if group > 1:
        whole = len(rows) // group * group
        rows = np.rint(rows[:whole].reshape(-1, group, rows.shape[1]).mean(axis=1)).astype(np.uint8)
        time_s = time_s[:whole].reshape(-1, group).mean(axis=1)
    lines = []
    for number, first in enumerate(range(0, len(rows), ROWS_A_LINE), start=1):
        part = slice(first, min(first + ROWS_A_LINE, len(rows)))
        name = f"line-{number:02d}.png"
        (folder / name).write_bytes(_png(np.ascontiguousarray(_brightened(rows[part]).T)))
        lines.append({"picture": name, "time_s": _times(time_s[part])})
    index: dict[str, Any] = {
        "pings": record.pings,
        "pings_per_row": record.pings_per_row * group,
        "range_m": round(0.5 * rows.shape[1] * record.column_m, 4),
        "lines": lines,
    }
    if record.stretch is not None:
        stretch = record.stretch
        name = "stretch.png"
        (folder / name).write_bytes(_png(np.ascontiguousarray(_brightened(stretch.picture.grey).T)))
        side = max(stretch.picture.nadir_column, stretch.picture.grey.shape[1] - stretch.picture.nadir_column)
        index["stretch"] = {
            "picture": name,
            "time_s": _times(stretch.time_s),
            "port_m": round(stretch.picture.nadir_column * stretch.picture.column_m, 4),
            "starboard_m": round((stretch.picture.grey.shape[1] - stretch.picture.nadir_column) * stretch.picture.column_m, 4),
            "range_m": round(side * stretch.picture.column_m, 4),
            "log": stretch.log,
            "contacts": stretch.contacts,
        }
    (folder / WATERFALL_INDEX_FILE).write_text(json.dumps(index, separators=(",", ":"), allow_nan=False) + "\n", encoding="utf-8")


def _times(time_s: FloatArray) -> list[float]:
    """A time that the log does not give is that of the ping before it."""
    known = np.isfinite(time_s)
    if not known.any():
        return [0.0] * len(time_s)
    rows = np.arange(len(time_s))
    return [round(float(value), 3) for value in np.interp(rows, rows[known], time_s[known])]


def _row_spacing_m(track: PoseSeries, sighting: Sighting, picture: Picture) -> float:
    """Metres along track between two pings: the way on the final track in the seconds around the contact. Where that is nothing, the
    contact's own length over its pings."""
    time_s = float(sighting.found["time_s"])
    around_s = np.array([time_s - SPEED_WINDOW_S, time_s + SPEED_WINDOW_S])
    x, y = (np.interp(around_s, track.time_s, track.pose[:, axis]) for axis in (0, 1))
    spacing_m = math.hypot(x[1] - x[0], y[1] - y[0]) / (2.0 * SPEED_WINDOW_S) * picture.ping_interval_s
    if math.isfinite(spacing_m) and spacing_m > LEAST_SPACING_M:
        return spacing_m
    pings = int(sighting.found["last_index"]) - int(sighting.found["first_index"]) + 1
    return max(float(sighting.found["length_m"]) / pings, LEAST_SPACING_M)


def _snippet(picture: Picture, found: Mapping[str, Any], spacing_m: float) -> bytes:
    from PIL import Image, ImageDraw

    across_m = _across_m(found)
    half = 0.5 * SNIPPET_M
    grey = _window(picture, found, spacing_m, Window(across_m - half, across_m + half, -half, half), (SNIPPET_PX, SNIPPET_PX))
    image = Image.fromarray(grey).convert("RGB")
    scale = SNIPPET_PX / SNIPPET_M
    row = int(found["index"])
    top_m, bottom_m = ((int(found[key]) - row + end) * spacing_m for key, end in (("first_index", -0.5), ("last_index", 0.5)))
    wide_m = 0.5 * float(found["width_m"]) + BOX_MARGIN_M
    box = [
        (half - wide_m) * scale,
        (half + top_m - BOX_MARGIN_M) * scale,
        (half + wide_m) * scale,
        (half + bottom_m + BOX_MARGIN_M) * scale,
    ]
    ImageDraw.Draw(image).rectangle([round(value) for value in box], outline=BOX_COLOUR, width=2)
    file = io.BytesIO()
    image.save(file, format="PNG", compress_level=6)
    return file.getvalue()


def _strip(picture: Picture, found: Mapping[str, Any], spacing_m: float) -> bytes:
    """The whole swath, STRIP_M along track, the contact's ping in the middle."""
    side_m = max(picture.nadir_column, picture.grey.shape[1] - picture.nadir_column) * picture.column_m
    height_px = max(round(STRIP_WIDTH_PX * STRIP_M / (2.0 * side_m)), 24)
    half = 0.5 * STRIP_M
    return _png(_window(picture, found, spacing_m, Window(-side_m, side_m, -half, half), (STRIP_WIDTH_PX, height_px)))


def _across_m(found: Mapping[str, Any]) -> float:
    return float(found["ground_range_m"]) * (1.0 if found["side"] == "starboard" else -1.0)


def _window(picture: Picture, found: Mapping[str, Any], spacing_m: float, window: Window, size_px: tuple[int, int]) -> ByteImage:
    """(height, width): black where the picture ends."""
    from PIL import Image

    row = int(found["index"]) - picture.first_index + 0.5
    box = (
        picture.nadir_column + window.left_m / picture.column_m,
        row + window.top_m / spacing_m,
        picture.nadir_column + window.right_m / picture.column_m,
        row + window.bottom_m / spacing_m,
    )
    width, height = size_px
    coefficients = ((box[2] - box[0]) / width, 0.0, box[0], 0.0, (box[3] - box[1]) / height, box[1])
    image = Image.fromarray(_brightened(picture.grey))
    return np.asarray(image.transform(size_px, Image.Transform.AFFINE, coefficients, resample=Image.Resampling.BILINEAR, fillcolor=0))


def _brightened(grey: ByteImage) -> ByteImage:
    """For the eye: the seabed, normalised to a quarter of white, at a good third of it."""
    table = np.rint(255.0 * (np.arange(256) / 255.0) ** 0.7).astype(np.uint8)
    bright: ByteImage = table[grey]
    return bright


def _png(pixels: ByteImage) -> bytes:
    from PIL import Image

    file = io.BytesIO()
    Image.fromarray(pixels).save(file, format="PNG", compress_level=6)
    return file.getvalue()
