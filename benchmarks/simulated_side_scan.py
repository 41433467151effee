"""Simulated side-scan objects for the cascade benchmarks: an echo with its shadow to the right, on speckle.

Seafloor without objects is strewn with what resembles one: an echo without shadow, a shadow without echo, a shadow on the wrong side.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from ssjs_cli.cascade.windows import background_windows

WINDOW_PX = 24
LEVEL = 70.0
LOOKS = 2.5
OBJECT, ECHO_ONLY, SHADOW_ONLY, WRONG_SIDE = range(4)
SEAFLOOR_SHAPE = (480, 640)
LOOKALIKES = 60

Levels = NDArray[np.float64]
Pictures = NDArray[np.uint8]


def speckle(rng: np.random.Generator, height: int, width: int) -> Levels:
    """Seafloor whose level varies slowly, times gamma deviates of mean 1."""
    slow = cv2.GaussianBlur(rng.normal(0, 1, (height, width)), (0, 0), 12) * 90
    made: Levels = np.clip(LEVEL + slow, 5, 255) * rng.gamma(LOOKS, 1 / LOOKS, (height, width))
    return made


def with_object(rng: np.random.Generator, levels: Levels, kind: int) -> Levels:
    """levels: the object's window; lengths are in 24ths of it."""
    height, width = levels.shape
    y, x = np.mgrid[:height, :width] * WINDOW_PX / height
    x_echo, y_echo = 9 + rng.normal(0, 1.2), 12 + rng.normal(0, 1.2)
    x_half, y_half = abs(3 + rng.normal(0, 0.8)) + 0.8, abs(4.5 + rng.normal(0, 1)) + 1
    gain, distance, shade, away = rng.uniform(1.5, 3.0), 8 + rng.normal(0, 1), rng.uniform(0.15, 0.6), 1
    if kind == WRONG_SIDE:
        x_echo, away = 15 + rng.normal(0, 1.2), -1
    if kind != SHADOW_ONLY:
        levels = np.where(((x - x_echo) / x_half) ** 2 + ((y - y_echo) / y_half) ** 2 < 1, levels * gain + 20 * (gain - 1), levels)
    if kind != ECHO_ONLY:
        shadow = ((x - x_echo - away * distance) / 5) ** 2 + ((y - y_echo) / (0.9 * y_half)) ** 2 < 1
        levels = np.where(shadow, levels * shade, levels)
    return levels


def in_8_bits(levels: Levels) -> Pictures:
    return np.clip(levels, 0, 255).astype(np.uint8)


def object_windows(count: int, seed: int) -> Pictures:
    """(count, 24, 24)"""
    rng = np.random.default_rng(seed)
    return np.stack([in_8_bits(with_object(rng, speckle(rng, WINDOW_PX, WINDOW_PX), OBJECT)) for _ in range(count)])


def seafloors(count: int, seed: int) -> list[Pictures]:
    rng = np.random.default_rng(seed)
    return [_seafloor(rng) for _ in range(count)]


def _seafloor(rng: np.random.Generator) -> Pictures:
    levels = speckle(rng, *SEAFLOOR_SHAPE)
    for _ in range(LOOKALIKES):
        side = int(rng.integers(20, 64))
        top, left = int(rng.integers(0, SEAFLOOR_SHAPE[0] - side)), int(rng.integers(0, SEAFLOOR_SHAPE[1] - side))
        part = (slice(top, top + side), slice(left, left + side))
        levels[part] = with_object(rng, levels[part], int(rng.integers(ECHO_ONLY, WRONG_SIDE + 1)))
    return in_8_bits(levels)


def seafloor_windows(pictures: list[Pictures], count: int, seed: int, threads: int) -> Pictures:
    """Windows at random places and of random sizes, resampled to 24 x 24."""
    return background_windows(len(pictures), pictures.__getitem__, count, WINDOW_PX, WINDOW_PX, seed, "seafloor", threads)
