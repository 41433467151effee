"""Landmarks in a frame: where each was predicted (+) with the 95 % ellipse of its innovation, and where it was measured (x). Figure 5.16 of
the thesis."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ssjs_cli.formats.frame_image import Frame
from ssjs_cli.formats.number_table import FloatArray

if TYPE_CHECKING:
    from PIL import Image

CHI_SQUARED_95 = 5.991464547107979  # two degrees of freedom
ENLARGED = 2
CORNERS = 40
ARM_PX = 5.0
PREDICTED, MEASURED = "#ffd166", "#4cc9f0"


def sightings_by_time(
    sightings: Mapping[str, Any] | None, files: Mapping[float, Any], most: int
) -> Iterator[tuple[float, dict[str, FloatArray]]]:
    """The rows of the frames with the most landmarks, one in each part of the mission, in order of time."""
    if sightings is None or not len(sightings["time_s"]):
        return
    time_s = np.asarray(sightings["time_s"])
    times, counts = np.unique(time_s, return_counts=True)
    known = np.array([time in files for time in times.tolist()])
    times, counts = times[known], counts[known]
    for part in np.array_split(np.arange(len(times)), min(most, max(len(times), 1))):
        if not len(part):
            continue
        best = float(times[part[np.argmax(counts[part])]])
        rows = time_s == best
        yield best, {key: np.asarray(sightings[key])[rows] for key in ("measured_px", "predicted_px", "innovation_covariance_px2")}


def sighting_picture(frame: Frame, rows: Mapping[str, FloatArray]) -> "Image.Image":
    from PIL import Image, ImageDraw

    picture = Image.fromarray(frame).convert("RGB")
    picture = picture.resize((picture.width * ENLARGED, picture.height * ENLARGED), Image.Resampling.BILINEAR)
    draw = ImageDraw.Draw(picture)
    for measured, predicted, covariance in zip(rows["measured_px"], rows["predicted_px"], rows["innovation_covariance_px2"], strict=True):
        outline = ellipse(predicted, covariance)
        draw.line([_on_picture(point) for point in outline], fill=PREDICTED, width=1)
        x, y = _on_picture(predicted)
        draw.line((x - ARM_PX, y, x + ARM_PX, y), fill=PREDICTED, width=2)
        draw.line((x, y - ARM_PX, x, y + ARM_PX), fill=PREDICTED, width=2)
        x, y = _on_picture(measured)
        draw.line((x - ARM_PX, y - ARM_PX, x + ARM_PX, y + ARM_PX), fill=MEASURED, width=2)
        draw.line((x - ARM_PX, y + ARM_PX, x + ARM_PX, y - ARM_PX), fill=MEASURED, width=2)
    return picture


def _on_picture(pixel: FloatArray) -> tuple[float, float]:
    """(u + 1/2) times the enlargement, less 1/2, is where an enlarged pixel lies."""
    return float((pixel[0] + 0.5) * ENLARGED - 0.5), float((pixel[1] + 0.5) * ENLARGED - 0.5)


def ellipse(middle: FloatArray, covariance: FloatArray) -> FloatArray:
    """(CORNERS + 1, 2) closed; covariance: uu, uv, vv."""
    S = np.array([[covariance[0], covariance[1]], [covariance[1], covariance[2]]])
    values, vectors = np.linalg.eigh(S)
    angle = np.linspace(0.0, 2.0 * np.pi, CORNERS + 1)
    circle = np.column_stack((np.cos(angle), np.sin(angle)))
    points: FloatArray = middle + np.sqrt(CHI_SQUARED_95) * circle * np.sqrt(np.maximum(values, 0.0)) @ vectors.T
    return points
