"""The smallest and largest object to look for in metres, as the detector takes them: window sizes in pixels."""

import math
from collections.abc import Mapping

from ssjs_cli.cascade.window_boxes import object_length
from ssjs_cli.config import FieldDescription, Scalar, part
from ssjs_cli.segmentation.ground_settings import PIXEL_ACROSS_KEY, PIXEL_ALONG_KEY

DETECTOR_PREFIX = "detector."
#: More than any picture is wide.
_MOST_PX = 1_000_000
#: Sizes that are whole pixels but for rounding are whole pixels.
_SLACK = 1e-9

_SIDES = (("width", PIXEL_ACROSS_KEY), ("height", PIXEL_ALONG_KEY))
_WORDS = {"min_width": "narrower", "min_height": "lower", "max_width": "wider", "max_height": "higher"}
SIZE_FIELDS = tuple(
    FieldDescription(
        f"{DETECTOR_PREFIX}{limit}_m", "optional_float", None, (), "must be positive",
        f"{word} objects, without margin, are not looked for; needs the size of a pixel",
    )
    for limit, word in _WORDS.items()
)  # fmt: skip
_KEYS = frozenset(described.key for described in SIZE_FIELDS)


def size_violations(values: Mapping[str, Scalar]) -> list[str]:
    found = []
    for side, pixel_key in _SIDES:
        limits = [values[f"{DETECTOR_PREFIX}{end}_{side}_m"] for end in ("min", "max")]
        pixel_m = values[pixel_key]
        for end, limit_m in zip(("min", "max"), limits, strict=True):
            key = f"{DETECTOR_PREFIX}{end}_{side}_m"
            if limit_m is None:
                continue
            if not 0.0 < float(limit_m) < math.inf:
                found.append(f"{key} = {limit_m}: must be positive")
            elif pixel_m is None:
                found.append(f"{key} = {limit_m}: metres need the size of a pixel; give --pixel-size-m ALONG,ACROSS, or {key[:-1]}px")
            elif end == "max" and float(limit_m) < float(pixel_m) * (1 - _SLACK):
                found.append(f"{key} = {limit_m}: is less than one pixel of {pixel_m} m")
            if values[f"{key[:-1]}px"] is not None:
                found.append(f"{key}: is given in pixels, too; leave {key[:-1]}px out")
        if limits[0] is not None and limits[1] is not None and float(limits[0]) > float(limits[1]):
            found.append(f"{DETECTOR_PREFIX}min_{side}_m = {limits[0]}: must not be greater than max_{side}_m = {limits[1]}")
    return found


def in_pixels(values: Mapping[str, Scalar], margin: float) -> dict[str, Scalar]:
    """The detector's own settings, without their prefix: windows in pixels whose objects keep to the limits in metres."""
    own = part({key: value for key, value in values.items() if key not in _KEYS}, DETECTOR_PREFIX)
    for side, pixel_key in _SIDES:
        least_m, most_m = values[f"{DETECTOR_PREFIX}min_{side}_m"], values[f"{DETECTOR_PREFIX}max_{side}_m"]
        pixel_m = float(values[pixel_key] or 0.0)
        if least_m is not None:
            own[f"min_{side}_px"] = _window_of(math.ceil(min(float(least_m) / pixel_m, _MOST_PX) * (1 - _SLACK)), margin)
        if most_m is not None:
            most_px = math.floor(min(float(most_m) / pixel_m, _MOST_PX) * (1 + _SLACK))
            own[f"max_{side}_px"] = max(1, _window_of(most_px + 1, margin) - 1)
    return own


def _window_of(object_px: int, margin: float) -> int:
    """The least window of an object that is at least so long."""
    window_px = max(1, math.floor((object_px - 1) * (1 + 2 * margin)))
    while object_length(window_px, margin) < object_px:
        window_px += 1
    return window_px
