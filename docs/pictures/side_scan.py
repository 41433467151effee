"""The picture of docs/math/side_scan.md: a simulated survey line in slant range, and in ground range with the contacts found.

PYTHONPATH=python python docs/pictures/side_scan.py docs/pictures/side_scan.png
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw

from ssjs_cli import _core

SEED = 3
MARGIN_PX = 6
FOUND, MISSED = (80, 220, 255), (255, 140, 60)


def main() -> None:
    survey = _core.simulated_side_scan_pictures(track={"lines": 1, "line_length_m": 90.0}, objects=26, clearance_m=7.0, seed=SEED)
    slant = Image.fromarray(survey["slant"]).convert("RGB")
    ground = Image.fromarray(_with_unknown_grey(survey)).convert("RGB")
    ground = ground.resize((slant.width, slant.height), Image.Resampling.BOX if ground.width > slant.width else Image.Resampling.BILINEAR)
    scale = slant.width / survey["ground"].shape[1]
    draw = ImageDraw.Draw(ground)
    for sighting in survey["sightings"]:
        _ring(draw, survey, scale, sighting["ping"], sighting["body_position_m"][1], 2, MISSED)
    for contact in survey["contacts"]:
        _ring(draw, survey, scale, contact["index"], contact["body_position_m"][1], 9, FOUND)
    sheet = Image.new("RGB", (slant.width, slant.height + ground.height + MARGIN_PX), "white")
    sheet.paste(slant, (0, 0))
    sheet.paste(ground, (0, slant.height + MARGIN_PX))
    sheet.quantize(48).save(Path(sys.argv[1]), optimize=True)


def _with_unknown_grey(survey: dict[str, Any]) -> np.ndarray:
    return np.where(survey["ground_valid"] > 0, survey["ground"], 128).astype(np.uint8)


def _ring(
    draw: ImageDraw.ImageDraw, survey: dict[str, Any], scale: float, row: int, across_m: float, radius_px: int, colour: tuple[int, int, int]
) -> None:
    x = (survey["ground_nadir_column"] + across_m / survey["ground_column_m"]) * scale
    draw.ellipse((x - radius_px, row - radius_px, x + radius_px, row + radius_px), outline=colour, width=2)


if __name__ == "__main__":
    main()
