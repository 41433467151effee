"""Changed copies of objects, cut from their pictures anew.

A copy made from a window is blurred by moving it and has no ground to move over: a cascade learns the blur. Cut from the picture with
another box it went through what every window goes through. Gain and noise, likewise, are put on whole pictures before anything else, and on
those that windows without object come from in the same share: what only objects had would be learnt as their mark.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ssjs_cli.cascade.settings import AUGMENTATION_PREFIX
from ssjs_cli.config import Scalar, part
from ssjs_cli.formats.annotations.boxes import Box


@dataclass(frozen=True)
class Variation:
    """How copies differ from their object: `augmentation.*` of the settings."""

    copies: int = 0
    scale: float = 0.0
    shift_px: float = 0.0
    gain: float = 0.0
    additive_noise: float = 0.0
    multiplicative_noise: float = 0.0
    flip_along_track: bool = False

    @property
    def changes_levels(self) -> bool:
        return max(self.gain, self.additive_noise, self.multiplicative_noise) > 0

    def levels(self, levels: NDArray[np.uint8], rng: np.random.Generator) -> NDArray[np.uint8]:
        """A picture with another gain, speckle and noise of the receiver."""
        if not self.changes_levels:
            return levels
        speckle = 1 + self.multiplicative_noise * rng.standard_normal(levels.shape)
        noisy = levels * ((1 + rng.uniform(-self.gain, self.gain)) * speckle) + self.additive_noise * rng.standard_normal(levels.shape)
        return np.rint(np.clip(noisy, 0, 255)).astype(np.uint8)

    def box(self, box: Box, window_width_px: int, picture_px: tuple[int, int], rng: np.random.Generator) -> Box:
        """A window's box, larger or smaller and moved, inside the picture. shift_px counts in pixels of the resampled window."""
        left, top, width, height = box
        scale = 1 + rng.uniform(-self.scale, self.scale)
        reach = self.shift_px * width / window_width_px
        x, y = left + width / 2 + rng.uniform(-reach, reach), top + height / 2 + rng.uniform(-reach, reach)
        scale = min(scale, picture_px[0] / width, picture_px[1] / height)
        size = max(1, int(width * scale + 1e-9)), max(1, int(height * scale + 1e-9))
        place = [min(max(round(centre - side / 2), 0), most - side) for centre, side, most in zip((x, y), size, picture_px, strict=True)]
        return place[0], place[1], size[0], size[1]

    def turned(self, window: NDArray[np.uint8], copy: int) -> NDArray[np.uint8]:
        """Every other copy upside down: rows are pings. Never left to right: a shadow has a direction."""
        return np.ascontiguousarray(window[::-1]) if self.flip_along_track and copy % 2 == 0 else window


def variation_of(values: Mapping[str, Scalar]) -> Variation:
    made = part(values, AUGMENTATION_PREFIX)
    return Variation(
        copies=int(made["copies"] or 0),
        flip_along_track=bool(made["flip_along_track"]),
        **{key: float(made[key] or 0) for key in ("scale", "shift_px", "gain", "additive_noise", "multiplicative_noise")},
    )
