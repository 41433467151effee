"""The pictures of docs/segmentation.md: five methods on a drawn scene under uneven gain, and on real side-scan tiles.

    SSJS_DATA=... .venv/bin/python docs/pictures/segmentation.py

The tiles are of the side-scan data set sdvd (Open Database License 1.0, contents under the Database Contents License 1.0).
"""

import io
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from ssjs_cli import _core
from ssjs_cli.formats.image_file import read_image, read_mask
from ssjs_cli.formats.image_levels import LevelImage, Mask
from ssjs_cli.segmentation.contact_sheet import SheetEntry, Thumbnail, contact_sheet, jpeg_bytes
from ssjs_cli.segmentation.one_comparison import METHODS
from ssjs_cli.segmentation.picture_input import outside_padding
from ssjs_cli.segmentation.pictures import Drawing, panels, picture_with_truth

BOX_PX = (200, 180)
HERE = Path(__file__).parent
TILES = ("left_20240430034600H_sample_3_tile_5.png", "left_20240429102030L_sample_1_tile_1.png")
FILTERED: dict[str, Any] = {
    "filter.kind": "gaussian",
    "filter.sigma_px": 2.5,
    "gain.kind": "local_mean",
    "gain.window_px": 51,
    "gain.target_level": 40.0,
    "improved_otsu.spot_px": 15,
    "dilations": 3,
}
GAIN: dict[str, Any] = {"filter.kind": "gaussian", "filter.sigma_px": 3.0, "gain.kind": "local_mean", "gain.window_px": 257}


def uneven_scene() -> tuple[LevelImage, Mask]:
    """An echo with its shadow, contrast 2, four looks of speckle, gain from -60 % to +60 % across the track."""
    rng = np.random.default_rng(7)
    height_px, width_px = 400, 400
    y, x = np.mgrid[0:height_px, 0:width_px]
    echo = ((x - 150) / 36) ** 2 + ((y - 210) / 22) ** 2 <= 1
    shadow = (((x - 215) / 48) ** 2 + ((y - 210) / 22) ** 2 <= 1) & ~echo
    reflectivity = np.where(echo, 2.0, np.where(shadow, 0.2, 1.0))
    gain = 1 + 0.6 * np.linspace(-1, 1, width_px)
    levels = 55 * reflectivity * gain * rng.gamma(4.0, 0.25, reflectivity.shape)
    return LevelImage(np.clip(levels, 0, 255).astype(np.uint8), None), np.where(echo, 255, 0).astype(np.uint8)


def row(name: str, image: LevelImage, truth: Mask, chain: Mapping[str, Any]) -> SheetEntry:
    objects = _core.GroundTruth.of_labels(truth)
    pictures = [Thumbnail("picture and truth", jpeg_bytes(picture_with_truth(image, truth, BOX_PX)))]
    texts = []
    for method in METHODS:
        result = _core.segment(image.levels, image.valid, {**chain, "method": method})
        centroids = [(float(x), float(y)) for x, y in result["regions"].centroid_px]
        pictures.append(Thumbnail(method, jpeg_bytes(panels(Drawing(image, result["mask"], centroids, []), BOX_PX).marked)))
        best = max((entry["best_iou"] for entry in _core.segmentation_score(result["regions"], objects)["objects"]), default=0.0)
        texts.append(f"{method} {best:.2f}")
    return SheetEntry(name, ["IoU of the best region: " + ", ".join(texts)], pictures)


def main() -> None:
    image, truth = uneven_scene()
    entries = [row("The paper's chain", image, truth, {}), row("With a Gaussian filter and gain normalisation", image, truth, GAIN)]
    (HERE / "segmentation_gain.png").write_bytes(reduced(contact_sheet(entries, "Echo and shadow under a gain of +-60 % across the track")))
    folder = Path(os.environ["SSJS_DATA"]) / "sdvd"
    entries = []
    for name in TILES:
        tile = read_image(folder / "images" / name)
        mask = read_mask(folder / "masks" / name)
        valid = LevelImage(tile.levels, outside_padding(tile, 0))
        entries.append(row(f"{name}, the paper's chain", tile, mask, {"improved_otsu.spot_px": 15}))
        entries.append(row("the same tile, the filtered chain", valid, mask, FILTERED))
    (HERE / "segmentation_sdvd.png").write_bytes(reduced(contact_sheet(entries, "Side-scan tiles of the data set sdvd (ODbL 1.0)")))


def reduced(png: bytes) -> bytes:
    """To 200 colours, rare ones too: a third of the size."""
    with Image.open(io.BytesIO(png)) as picture:
        buffer = io.BytesIO()
        picture.convert("RGB").quantize(200, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).save(
            buffer, format="PNG", optimize=True
        )
    return buffer.getvalue()


if __name__ == "__main__":
    main()
