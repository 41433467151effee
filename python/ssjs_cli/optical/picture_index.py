"""The pictures that a run of a camera mission leaves for its report, with one description of all."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from ssjs_cli.formats.frame_image import Frame
from ssjs_cli.formats.number_table import FloatArray
from ssjs_cli.formats.run_directory import PICTURES_INDEX_FILE, json_text
from ssjs_cli.optical.landmark_patches import PART_OF_WIDTH, SIDE_PX, PatchSheet
from ssjs_cli.optical.match_pictures import match_picture
from ssjs_cli.optical.mosaic_picture import Mosaic

QUALITY = 88


class PictureIndex:
    """Files are written as they are added, the description by write()."""

    def __init__(self, folder: Path, length_unit: str) -> None:
        folder.mkdir()
        self._folder = folder
        self._entries: dict[str, Any] = {"length_unit": length_unit, "matches": [], "sightings": []}

    def add_mosaic(self, mosaic: Mosaic) -> None:
        from PIL import Image

        Image.fromarray(mosaic.picture).save(self._folder / "mosaic.jpg", quality=QUALITY)
        window = mosaic.window
        self._entries["mosaic"] = {
            "picture": "mosaic.jpg",
            **{key: round(float(window[key]), 9) for key in ("left", "bottom", "pixel_length")},
            "right": round(mosaic.right, 9),
            "top": round(mosaic.top, 9),
            "width_px": int(window["width_px"]),
            "height_px": int(window["height_px"]),
        }

    def add_matches(
        self, names: tuple[str, str], frames: tuple[Frame, Frame], pixels: tuple[FloatArray, FloatArray], seconds_apart: float
    ) -> None:
        name = f"matches_{len(self._entries['matches']) + 1}.jpg"
        match_picture(*frames, *pixels).save(self._folder / name, quality=QUALITY)
        self._entries["matches"].append(
            {"picture": name, "first": names[0], "second": names[1], "matches": len(pixels[0]), "seconds_apart": round(seconds_apart, 3)}
        )

    def add_sighting(self, picture: Any, frame: str, sightings: int) -> None:
        """picture: a Pillow image of a frame with what was predicted and what was measured in it."""
        name = f"sightings_{len(self._entries['sightings']) + 1}.jpg"
        picture.save(self._folder / name, quality=QUALITY)
        self._entries["sightings"].append({"picture": name, "frame": frame, "sightings": sightings})

    def add_landmarks(self, sheet: PatchSheet, names: Callable[[int], str]) -> None:
        """names: the file of a frame by its number."""
        from PIL import Image

        Image.fromarray(sheet.picture).save(self._folder / "landmarks.jpg", quality=QUALITY)
        (self._folder / "landmarks.csv").write_text(sheet.table(names), encoding="utf-8")
        self._entries["landmarks"] = {
            "picture": "landmarks.jpg",
            "table": "landmarks.csv",
            "side_px": SIDE_PX,
            "part_of_width": PART_OF_WIDTH,
            "count": len(sheet.looks.landmark),
        }

    def frames(self, *, given: int, used: int, with_region: int) -> None:
        self._entries["frames"] = {"given": given, "used": used, "with_region": with_region}

    def write(self) -> None:
        (self._folder / PICTURES_INDEX_FILE).write_text(json_text(self._entries), encoding="utf-8")
