"""Generated side-scan pictures: speckle with echoes that have a shadow to their right, and pictures with echoes whose shadow lies to the
left, which are none."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

HEIGHT_PX, WIDTH_PX = 100, 130
#: One layer after the other, quick to train.
PLAN = """[[layer]]
detection_rate = 0.98
false_positive_rate = 0.5
max_features = 3

[[layer]]
detection_rate = 0.96
false_positive_rate = 0.1
max_features = 6

[[layer]]
detection_rate = 0.94
false_positive_rate = 0.02
max_features = 10
"""
SMALL = (
    "window.width_px=12", "window.height_px=12", "training.feature_set=side_scan", "training.rejecting_features=0",
    "training.negatives_per_layer=300", "validation.windows=2000", "augmentation.copies=2",
)  # fmt: skip


@dataclass(frozen=True)
class Scenes:
    """positives, masks, negatives: folders; boxes: by the name of the picture."""

    positives: Path
    masks: Path
    negatives: Path
    plan: Path
    boxes: dict[str, list[tuple[int, int, int, int]]]

    @property
    def options(self) -> list[object]:
        options: list[object] = ["--positives", self.positives, "--masks", self.masks, "--negatives", self.negatives, "--plan", self.plan]
        for assignment in SMALL:
            options += ["--set", assignment]
        return options


def speckle(rng: np.random.Generator, height_px: int = HEIGHT_PX, width_px: int = WIDTH_PX) -> np.ndarray:
    return 70 * rng.gamma(4.0, 1.0 / 4.0, (height_px, width_px))


def draw_object(levels: np.ndarray, left: int, top: int, side: int, *, shadow_right: bool = True) -> None:
    """An echo of a third of the box, the rest of it shadow."""
    third = side // 3
    echo = slice(left, left + third) if shadow_right else slice(left + side - third, left + side)
    shadow = slice(left + third, left + side) if shadow_right else slice(left, left + side - third)
    rows = slice(top, top + side)
    levels[rows, echo] = 2.4 * levels[rows, echo] + 40
    levels[rows, shadow] *= 0.25


def as_picture(levels: np.ndarray) -> np.ndarray:
    return np.clip(levels, 0, 255).astype(np.uint8)


def make_scenes(folder: Path, *, pictures: int = 24, seed: int = 3) -> Scenes:
    rng = np.random.default_rng(seed)
    positives, masks, negatives = folder / "positives", folder / "masks", folder / "negatives"
    for path in (positives, masks, negatives):
        path.mkdir(parents=True)
    boxes: dict[str, list[tuple[int, int, int, int]]] = {}
    for index in range(pictures):
        levels, mask, name = speckle(rng), np.zeros((HEIGHT_PX, WIDTH_PX), dtype=np.uint8), f"line{index // 3:02d}_{index:03d}.png"
        boxes[name] = []
        for half in (0, 1):
            side = int(rng.integers(15, 30))
            left, top = int(rng.integers(4, 60 - side)) + 65 * half, int(rng.integers(4, HEIGHT_PX - side - 4))
            draw_object(levels, left, top, side)
            mask[top : top + side, left : left + side] = 255
            boxes[name].append((left, top, side, side))
        Image.fromarray(as_picture(levels)).save(positives / name)
        Image.fromarray(mask).save(masks / name)
    for index in range(10):
        levels = speckle(rng)
        for _ in range(4):
            side = int(rng.integers(15, 30))
            draw_object(levels, int(rng.integers(0, WIDTH_PX - side)), int(rng.integers(0, HEIGHT_PX - side)), side, shadow_right=False)
        Image.fromarray(as_picture(levels)).save(negatives / f"seabed{index:02d}.png")
    plan = folder / "plan.toml"
    plan.write_text(PLAN)
    return Scenes(positives, masks, negatives, plan, boxes)
