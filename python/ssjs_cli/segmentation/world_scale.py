"""From pixels to metres.

Rows follow the track, columns lie across it. Along-track distances grow downwards from the upper edge of the picture; across-track
ones grow to the right, from the left edge or, where the nadir is known, from the nadir (so that port is negative). A picture's first
pixel has its centre at (0, 0) px, half a pixel inside the edges.
"""

from dataclasses import dataclass

from ssjs_cli.config import Settings
from ssjs_cli.segmentation.ground_settings import PIXEL_ACROSS_KEY, PIXEL_ALONG_KEY, nadir_column


@dataclass(frozen=True)
class WorldScale:
    pixel_along_m: float
    pixel_across_m: float
    origin_column: int = 0

    def along_m(self, y_px: float) -> float:
        return (y_px + 0.5) * self.pixel_along_m

    def across_m(self, x_px: float) -> float:
        return (x_px + 0.5 - self.origin_column) * self.pixel_across_m

    def area_m2(self, area_px: float) -> float:
        return area_px * self.pixel_along_m * self.pixel_across_m


def world_scale(settings: Settings, width_px: int) -> WorldScale | None:
    along_m, across_m = settings.values[PIXEL_ALONG_KEY], settings.values[PIXEL_ACROSS_KEY]
    if along_m is None or across_m is None:
        return None
    return WorldScale(float(along_m), float(across_m), nadir_column(settings.values, width_px) or 0)
