"""The picture of docs/sonar_logs.md: the wreck of the Scotsman in ground range, the contacts found, and the point that came with the log.

PYTHONPATH=python python docs/pictures/iver2_wreck.py DATA/iver2_xtf docs/pictures/iver2_wreck.png
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw

from ssjs_cli import _core

LOG = "scotsman-iver2.xtf"
#: With the bottom found in the picture the hull is one object; with the log's altitude only its far edge is.
SETTINGS = {"altitude": "bottom_tracking"}
FIRST_PING, LAST_PING = 170, 430
FARTHEST_M = 20.0
PIXELS_PER_COLUMN, PIXELS_PER_PING = 4, 3
WRECK, OTHER, HIT = (80, 220, 255), (255, 190, 60), (255, 70, 70)


def hit_of(folder: Path) -> tuple[int, float]:
    """Ping and ground range, m, to starboard (channel 1). Its sample counts along the bottom."""
    _, sample, ping = map(int, (folder / f"{LOG}.hits").read_text().split())
    block = _core.SonarLog(str(folder / LOG)).read(ping + 1)
    if block is None:
        raise SystemExit(f"{folder / LOG}: holds no ping")
    channel = block["channels"][ping][1]
    return ping, sample * channel["sample_interval_s"] * 1500.0 / 2.0


def box_of(contact: dict[str, Any]) -> tuple[int, int, float, float]:
    """First and last ping, nearest and farthest ground range, m."""
    ground_m, half_m = contact["ground_range_m"], 0.5 * contact["width_m"]
    return contact["first_index"], contact["last_index"], ground_m - half_m, ground_m + half_m


def holds(contact: dict[str, Any], ping: int, ground_m: float) -> bool:
    first, last, nearest, farthest = box_of(contact)
    return contact["side"] == "starboard" and first <= ping <= last and nearest <= ground_m <= farthest


def main() -> None:
    folder, out = Path(sys.argv[1]), Path(sys.argv[2])
    survey = _core.side_scan_pictures(_core.SonarLog(str(folder / LOG)), 4096, SETTINGS)
    nadir, column_m = survey["ground_nadir_column"], survey["ground_column_m"]
    columns = round(FARTHEST_M / column_m)
    grey = np.where(survey["ground_valid"] > 0, survey["ground"], 128).astype(np.uint8)[FIRST_PING:LAST_PING, nadir : nadir + columns]
    picture = Image.fromarray(grey).convert("RGB").resize((PIXELS_PER_COLUMN * columns, PIXELS_PER_PING * len(grey)))
    draw = ImageDraw.Draw(picture)

    def at(ping: float, ground_m: float) -> tuple[float, float]:
        return PIXELS_PER_COLUMN * ground_m / column_m, PIXELS_PER_PING * (ping - FIRST_PING)

    ping, ground_m = hit_of(folder)
    for contact in survey["contacts"]:
        if contact["side"] != "starboard":
            continue
        first, last, nearest, farthest = box_of(contact)
        draw.rectangle((*at(first, nearest), *at(last + 1, farthest)), outline=WRECK if holds(contact, ping, ground_m) else OTHER, width=2)
    x, y = at(ping + 0.5, ground_m)
    draw.line((x - 9, y, x + 9, y), fill=HIT, width=3)
    draw.line((x, y - 9, x, y + 9), fill=HIT, width=3)
    picture.quantize(palette=_palette(), dither=Image.Dither.NONE).save(out, optimize=True)


def _palette() -> Image.Image:
    """A few greys and the three colours, which an automatic palette would drop."""
    greys = [(level, level, level) for level in np.linspace(0, 255, 48, dtype=int).tolist()]
    palette = Image.new("P", (1, 1))
    palette.putpalette([part for colour in (*greys, WRECK, OTHER, HIT) for part in colour])
    return palette


if __name__ == "__main__":
    main()
