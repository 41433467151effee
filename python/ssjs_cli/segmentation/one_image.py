"""The work on one image, in whatever process: read, segmented, its pictures written, its numbers returned as plain data."""

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ssjs_cli import _core
from ssjs_cli.config import Scalar, Settings, part
from ssjs_cli.errors import UserError
from ssjs_cli.formats.file_digest import file_digest
from ssjs_cli.formats.image_file import write_png
from ssjs_cli.formats.image_levels import LevelImage, Mask
from ssjs_cli.segmentation.contact_sheet import thumbnails
from ssjs_cli.segmentation.ground_settings import nadir_column_in
from ssjs_cli.segmentation.picture_input import MaskSource, read_picture
from ssjs_cli.segmentation.pictures import Drawing, Point, overlay
from ssjs_cli.segmentation.settings import (
    ALTITUDE_KEY,
    CHAIN_PREFIX,
    METHOD_KEY,
    OBJECTS_KEY,
    RANGES_KEY,
    SEGMENTATION,
    SHADOW_OBJECTS,
    SHADOW_PREFIX,
)
from ssjs_cli.segmentation.world_scale import WorldScale, world_scale

MASKS, OVERLAYS, STEPS = "masks", "overlays", "intermediates"
NO_THRESHOLD = "its valid pixels have fewer than two levels"
NO_VALID_PIXEL = "it has no valid pixel"
#: Pixels are told to this part of one, levels and angles likewise.
_DECIMALS = 4


@dataclass(frozen=True)
class ImageTask:
    """Plain data, so that it can go to another process. out: the folder that masks, overlays and steps are written below."""

    path: str
    name: str
    stem: str
    settings: Mapping[str, Scalar]
    out: str
    valid_mask: str | None = None
    with_thumbnails: bool = False
    keep_steps: bool = False


def segment_image(task: ImageTask) -> dict[str, Any]:
    """summary: one row about the image; regions, objects: a row each; time_*_s; thumbnails, where asked for."""
    _core.set_image_threads(1)
    started_s = time.perf_counter()
    settings = Settings(task.settings, kind=SEGMENTATION)
    path = Path(task.path)
    image = read_picture(path, settings, None if task.valid_mask is None else MaskSource(Path(task.valid_mask)))
    read_s = time.perf_counter()
    result = _core.segment(image.levels, image.valid, part(settings.values, CHAIN_PREFIX), task.keep_steps)
    scale = world_scale(settings, image.width_px)
    regions = _region_rows(task.name, result["regions"], result["objects"]["object_of_region"], scale)
    if settings.values[OBJECTS_KEY] == SHADOW_OBJECTS:
        objects = _shadow_rows(task.name, image, settings, scale, path)
        for region in regions:
            region["object"] = None  # regions of the chain and objects of the detector are found apart from each other
    else:
        objects = _object_rows(task.name, result["objects"], scale)
    segmented_s = time.perf_counter()
    drawing = Drawing(image, result["mask"], _centroids(regions), _centroids(objects) if len(objects) != len(regions) else [])
    _write_pictures(Path(task.out), task.stem, drawing, result["steps"])
    return {
        "summary": _summary(task, path, image, result, settings, len(regions), len(objects)),
        "regions": regions,
        "objects": objects,
        "thumbnails": thumbnails(drawing) if task.with_thumbnails else [],
        "time_read_s": round(read_s - started_s, 6),
        "time_segment_s": round(segmented_s - read_s, 6),
        "time_write_s": round(time.perf_counter() - segmented_s, 6),
    }


def _summary(
    task: ImageTask, path: Path, image: LevelImage, result: Mapping[str, Any], settings: Settings, regions: int, objects: int
) -> dict[str, Any]:
    improved = result["improved_otsu"] or {}
    pixels = image.levels.size
    valid_pixels = pixels if image.valid is None else int((image.valid != 0).sum())
    foreground = int((result["mask"] != 0).sum())
    found_threshold = result["threshold"] is not None or settings.values[METHOD_KEY] == "local"
    reason = NO_VALID_PIXEL if valid_pixels == 0 else None if found_threshold else NO_THRESHOLD
    return {
        "image": task.name,
        "files": task.stem,
        "sha256": file_digest(path),
        "width_px": image.width_px,
        "height_px": image.height_px,
        "bits": image.bits,
        "valid_fraction": round(valid_pixels / pixels, 6),
        "notes": list(image.notes),
        "threshold": result["threshold"],
        "first_threshold": improved.get("first_threshold"),
        "spots": improved.get("spots"),
        "spot_px": improved.get("spot_px"),
        "spot_limit": _rounded(improved.get("spot_limit")),
        "canny_high": _rounded(improved.get("canny_high")),
        "second_pass_fired": improved.get("second_pass_fired"),
        "smallest_area_px": result["smallest_area_px"],
        "regions": regions,
        "objects": objects,
        "foreground_fraction": round(foreground / valid_pixels, 6) if valid_pixels else 0.0,
        "reason": reason,
    }


def _rounded(value: Any) -> float | None:
    return None if value is None else round(float(value), _DECIMALS)


def _place(x_px: float, y_px: float, scale: WorldScale | None) -> dict[str, Any]:
    return {
        "x_px": _rounded(x_px),
        "y_px": _rounded(y_px),
        "across_m": _rounded(scale.across_m(x_px)) if scale else None,
        "along_m": _rounded(scale.along_m(y_px)) if scale else None,
    }


def _extent(area_px: int, box: Any, scale: WorldScale | None) -> dict[str, Any]:
    left, top, width, height = (int(number) for number in box)
    area_m2 = _rounded(scale.area_m2(area_px)) if scale else None
    return {"area_px": area_px, "area_m2": area_m2, "left_px": left, "top_px": top, "width_px": width, "height_px": height}


def _region_rows(image: str, regions: Any, object_of_region: Any, scale: WorldScale | None) -> list[dict[str, Any]]:
    centroid, box, area = regions.centroid_px, regions.bounding_box_px, regions.area_px
    measures = {
        key: getattr(regions, key) for key in ("orientation_rad", "major_axis_px", "minor_axis_px", "mean_intensity", "max_intensity")
    }
    return [
        {
            "image": image,
            "region": index + 1,
            "object": int(object_of_region[index]) + 1,
            **_place(float(centroid[index, 0]), float(centroid[index, 1]), scale),
            **_extent(int(area[index]), box[index], scale),
            **{key: _rounded(values[index]) for key, values in measures.items()},
        }
        for index in range(len(regions))
    ]


def _object_rows(image: str, objects: Mapping[str, Any], scale: WorldScale | None) -> list[dict[str, Any]]:
    counts = [0] * len(objects["area_px"])
    for index in objects["object_of_region"]:
        counts[int(index)] += 1
    return [
        {
            "image": image,
            "object": index + 1,
            "regions": counts[index],
            **_place(float(objects["centroid_px"][index, 0]), float(objects["centroid_px"][index, 1]), scale),
            **_extent(int(objects["area_px"][index]), objects["bounding_box_px"][index], scale),
        }
        for index in range(len(counts))
    ]


def _shadow_rows(image: str, picture: LevelImage, settings: Settings, scale: WorldScale | None, path: Path) -> list[dict[str, Any]]:
    """Highlights with a shadow behind them; their area and box are the highlight's."""
    column = nadir_column_in(settings.values, picture.width_px, str(path))
    if column is None:
        raise UserError(f"{path}: objects from shadows need --nadir")
    found = _core.highlight_shadow(picture.levels, column, picture.valid, part(settings.values, SHADOW_PREFIX))
    rows = []
    for index, entry in enumerate(found["objects"]):
        x_px, y_px = (float(number) for number in entry["centroid_px"])
        start_px, tip_px = float(entry["shadow_start_px"]), float(entry["shadow_tip_px"])
        rows.append(
            {
                "image": image,
                "object": index + 1,
                **_place(x_px, y_px, scale),
                **_extent(int(entry["highlight_area_px"]), entry["highlight_box_px"], scale),
                "side": entry["side"],
                "shadow_area_px": int(entry["shadow_area_px"]),
                "shadow_length_px": _rounded(tip_px - start_px),
                "shadow_length_m": _rounded((tip_px - start_px) * scale.pixel_across_m) if scale else None,
                "shadow_is_cut": bool(entry["shadow_is_cut"]),
                "height_m": _height_m(start_px, tip_px, settings, scale),
            }
        )
    return rows


def _height_m(start_px: float, tip_px: float, settings: Settings, scale: WorldScale | None) -> float | None:
    """None where the scale or the altitude is not known, or the ranges cannot be at this altitude."""
    altitude_m = settings.values[ALTITUDE_KEY]
    if scale is None or altitude_m is None:
        return None
    ranges = str(settings.values[RANGES_KEY])
    try:
        height_m = _core.height_from_shadow_m(float(altitude_m), start_px * scale.pixel_across_m, tip_px * scale.pixel_across_m, ranges)
    except ValueError:
        return None
    return _rounded(height_m) if math.isfinite(height_m) else None


def _centroids(rows: list[dict[str, Any]]) -> list[Point]:
    return [(float(row["x_px"]), float(row["y_px"])) for row in rows]


def _write_pictures(out: Path, stem: str, drawing: Drawing, steps: Mapping[str, Mask] | None) -> None:
    write_png(out / MASKS / f"{stem}.png", drawing.mask)
    write_png(out / OVERLAYS / f"{stem}.png", overlay(drawing))
    if steps is None:
        return
    folder = out / STEPS / stem
    folder.mkdir(parents=True)
    for number, (name, picture) in enumerate(steps.items(), 1):
        write_png(folder / f"{number}_{name}.png", picture)
