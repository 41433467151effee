"""Two frames side by side with the matches that agree on one motion."""

from typing import TYPE_CHECKING, Any

import numpy as np

from ssjs_cli.formats.frame_image import Frame
from ssjs_cli.formats.number_table import FloatArray

if TYPE_CHECKING:
    from PIL import Image

MAX_LINES = 60
GAP_PX = 6
COLOURS = ("#ffd166", "#06d6a0", "#4cc9f0", "#ef476f", "#f78c6b", "#b8f2e6")


def match_picture(first: Frame, second: Frame, first_px: FloatArray, second_px: FloatArray) -> "Image.Image":
    """first_px, second_px (n, 2): matched pixels. Of many matches evenly chosen ones are drawn."""
    from PIL import Image, ImageDraw

    height = max(first.shape[0], second.shape[0])
    offset = first.shape[1] + GAP_PX
    picture = Image.new("RGB", (offset + second.shape[1], height), "#ffffff")
    picture.paste(Image.fromarray(first), (0, 0))
    picture.paste(Image.fromarray(second), (offset, 0))
    draw = ImageDraw.Draw(picture)
    rows = np.unique(np.linspace(0, len(first_px) - 1, min(MAX_LINES, len(first_px))).astype(int))
    for number, row in enumerate(rows.tolist()):
        ends = [(float(x), float(y)) for x, y in (first_px[row], second_px[row] + (offset, 0.0))]
        draw.line(ends, fill=COLOURS[number % len(COLOURS)], width=1)
        for x, y in ends:
            draw.ellipse((x - 2.5, y - 2.5, x + 2.5, y + 2.5), outline=COLOURS[number % len(COLOURS)])
    return picture


def shown_links(links: dict[tuple[int, int], dict[str, Any]], far_frames: int = 10) -> list[tuple[int, int]]:
    """Examples: the usual of the frames in sequence, and of those far apart in time the best and the usual one."""

    def by_matches(pairs: list[tuple[int, int]]) -> list[tuple[int, int]]:
        return sorted(pairs, key=lambda pair: (len(links[pair]["inliers"]), pair))

    near = by_matches([pair for pair in links if pair[1] - pair[0] == 1])
    far = by_matches([pair for pair in links if pair[1] - pair[0] > far_frames])
    chosen = near[len(near) // 2 : len(near) // 2 + 1] + far[-1:] + far[len(far) // 2 : len(far) // 2 + 1]
    return list(dict.fromkeys(chosen))
