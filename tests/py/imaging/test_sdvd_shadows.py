"""Highlights with shadows on real side-scan tiles of one effigy each. Tiles of the left channel have the nadir on their right."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from ssjs_cli import _core

PADDING_PX = 400  # black areas from this size on are no measurement


def grey(path: Path) -> NDArray[np.uint8]:
    return np.array(Image.open(path).convert("L"))


def shadows(path: Path, mirrored: bool = False) -> dict:
    image = grey(path)
    valid = _core.remove_small_components(image == 0, PADDING_PX) == 0
    is_left = path.stem.startswith("left") != mirrored
    return _core.highlight_shadow(image, image.shape[1] if is_left else 0, valid)


def lies_on(mask: NDArray[np.bool_], centroids: list[list[float]] | NDArray[np.float64]) -> bool:
    return any(mask[int(y + 0.5), int(x + 0.5)] for x, y in centroids)


def hit_rate_and_objects(tiles: Path, mirrored: bool) -> tuple[float, float]:
    hits, objects = [], []
    for path in sorted((tiles / "images").iterdir()):
        mask = np.array(Image.open(tiles / "masks" / path.name))
        mask = (mask if mask.ndim == 2 else mask[..., 0]) > 127
        found = shadows(path, mirrored)["objects"]
        hits.append(lies_on(mask, [entry["centroid_px"] for entry in found]))
        objects.append(len(found))
    assert len(hits) == 142
    return float(np.mean(hits)), float(np.mean(objects))


def test_the_shadow_tells_the_object_and_the_side(data_set: Callable[[str], Path]) -> None:
    """docs/math/regions.md: 0.63 of the effigies with 1.6 objects a tile; 0.37 with 2.1 if the nadir is taken for the other side."""
    tiles = data_set("sdvd")
    hit_rate, objects = hit_rate_and_objects(tiles, mirrored=False)
    assert hit_rate >= 0.6
    assert objects <= 1.7
    wrong_side, _ = hit_rate_and_objects(tiles, mirrored=True)
    assert wrong_side <= 0.4


def test_most_bright_spots_of_an_empty_seabed_have_no_shadow(data_set: Callable[[str], Path]) -> None:
    paths = sorted((data_set("sdvd") / "negatives").iterdir())
    found = [shadows(path, mirrored) for path in paths for mirrored in (False, True)]  # their side is not known
    candidates = sum(len(_core.find_regions(entry["highlights"], entry["highlights"])) for entry in found)
    objects = sum(len(entry["objects"]) for entry in found)
    assert candidates > 20 * len(found)
    assert objects <= 0.06 * candidates
