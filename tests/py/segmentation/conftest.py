"""Generated sonar pictures: a quiet seabed with speckle and one bright object where it is known to be."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from PIL import Image


@dataclass(frozen=True)
class Scene:
    """box: left, top, width, height of the object, pixels."""

    levels: np.ndarray
    box: tuple[int, int, int, int]

    @property
    def truth(self) -> np.ndarray:
        left, top, width, height = self.box
        mask = np.zeros(self.levels.shape, dtype=np.uint8)
        mask[top : top + height, left : left + width] = 255
        return mask


def made_scene(seed: int, *, height_px: int = 96, width_px: int = 128, object_level: int = 220) -> Scene:
    rng = np.random.default_rng(seed)
    levels = np.clip(30 * rng.gamma(16.0, 1.0 / 16.0, (height_px, width_px)), 0, 255).astype(np.uint8)
    left, top = int(rng.integers(10, width_px - 40)), int(rng.integers(10, height_px - 30))
    levels[top : top + 12, left : left + 20] = object_level + rng.integers(0, 20, (12, 20), dtype=np.uint8)
    return Scene(levels, (left, top, 20, 12))


@pytest.fixture
def scene_folder(tmp_path: Path) -> Callable[..., Path]:
    """scene_folder(count) -> a folder of scenes 000.png, 001.png, ... with the truth in masks/."""

    def make(count: int, name: str = "scenes") -> Path:
        folder = tmp_path / name
        (folder / "masks").mkdir(parents=True)
        for seed in range(count):
            scene = made_scene(seed)
            Image.fromarray(scene.levels).save(folder / f"{seed:03d}.png")
            Image.fromarray(scene.truth).save(folder / "masks" / f"{seed:03d}.png")
        return folder

    return make
