"""The files of a segmentation: tables for programs, one document about every image, sheets for the eye."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ssjs_cli import _core
from ssjs_cli.config import Settings
from ssjs_cli.formats.atomic import holds_only
from ssjs_cli.segmentation.contact_sheet import SheetEntry, contact_sheet
from ssjs_cli.segmentation.one_image import MASKS, OVERLAYS, STEPS
from ssjs_cli.studies.study_folder import key_of
from ssjs_cli.studies.tables import csv_text, json_text

KIND = "segmentation directory"
SUMMARY_FILE = "segmentation.json"
REGIONS_FILE = "regions.csv"
OBJECTS_FILE = "objects.csv"
CONFIG_FILE = "config.toml"
TIMING_FILE = "timing.json"
SHEET_FILE = "contact_sheet.png"
PAGE_FILE = "report.html"
FAULT_FILE = "faults.log"
FILES = (SUMMARY_FILE, REGIONS_FILE, OBJECTS_FILE, CONFIG_FILE, TIMING_FILE, SHEET_FILE, PAGE_FILE, FAULT_FILE, MASKS, OVERLAYS, STEPS)

_PLACE = ("x_px", "y_px", "across_m", "along_m")
_EXTENT = ("area_px", "area_m2", "left_px", "top_px", "width_px", "height_px")
REGION_KEYS = (
    *("image", "region", "object", *_PLACE, *_EXTENT),
    *("orientation_rad", "major_axis_px", "minor_axis_px", "mean_intensity", "max_intensity"),
)
OBJECT_KEYS = (
    *("image", "object", "regions", *_PLACE, *_EXTENT),
    *("side", "shadow_area_px", "shadow_length_px", "shadow_length_m", "shadow_is_cut", "height_m"),
)
TIME_KEYS = ("time_read_s", "time_segment_s", "time_write_s")


@dataclass(frozen=True)
class Segmented:
    """records: one an image that could be used, in the order of the images; failures: name and reason of the others."""

    title: str
    method: str
    preset: str | None
    seed: int
    settings: Settings
    records: Sequence[Mapping[str, Any]]
    failures: Sequence[tuple[str, str]]
    faults: Sequence[str]
    time_total_s: float


why_not_a_segmentation = holds_only(FILES, (SUMMARY_FILE,))


def write_results(directory: Path, segmented: Segmented, *, with_report: bool) -> dict[str, Any]:
    """Gives the document of segmentation.json."""
    document = summary_document(segmented)
    regions = [row for record in segmented.records for row in record["regions"]]
    objects = [row for record in segmented.records for row in record["objects"]]
    (directory / SUMMARY_FILE).write_text(json_text(document), encoding="utf-8")
    (directory / REGIONS_FILE).write_text(csv_text(REGION_KEYS, regions), encoding="utf-8")
    (directory / OBJECTS_FILE).write_text(csv_text(OBJECT_KEYS, objects), encoding="utf-8")
    (directory / CONFIG_FILE).write_text(segmented.settings.to_toml(segmented.seed), encoding="utf-8")
    (directory / TIMING_FILE).write_text(json_text(_timing(segmented)), encoding="utf-8")
    if segmented.faults:
        (directory / FAULT_FILE).write_text("\n".join(segmented.faults) + "\n", encoding="utf-8")
    if with_report:
        from ssjs_cli.report.segmentation_page import segmentation_page

        entries = sheet_entries(segmented.records)
        images = len(segmented.records)
        title = f"{segmented.title}: {len(entries)} of {images} images" if len(entries) < images else segmented.title
        (directory / SHEET_FILE).write_bytes(contact_sheet(entries, title))
        (directory / PAGE_FILE).write_text(segmentation_page(segmented, document, entries), encoding="utf-8")
    return document


def summary_document(segmented: Segmented) -> dict[str, Any]:
    summaries = [record["summary"] for record in segmented.records]
    return {
        "version": _core.version(),
        "method": segmented.method,
        "preset": segmented.preset,
        "seed": segmented.seed,
        "configuration_digest": key_of(dict(segmented.settings.values)),
        "totals": {
            "images": len(summaries),
            "failed": len(segmented.failures),
            "without_threshold": sum(summary["reason"] is not None for summary in summaries),
            "second_pass_fired": sum(summary["second_pass_fired"] is True for summary in summaries),
            "regions": sum(summary["regions"] for summary in summaries),
            "objects": sum(summary["objects"] for summary in summaries),
        },
        "failed": [{"image": name, "reason": reason} for name, reason in segmented.failures],
        "images": summaries,
    }


def _timing(segmented: Segmented) -> dict[str, Any]:
    return {
        "time_total_s": round(segmented.time_total_s, 6),
        "images": [{"image": record["summary"]["image"], **{key: record[key] for key in TIME_KEYS}} for record in segmented.records],
    }


def sheet_entries(records: Sequence[Mapping[str, Any]]) -> list[SheetEntry]:
    entries = []
    for record in records:
        if not record["thumbnails"]:
            continue
        summary = record["summary"]
        numbers = {key: float(summary[key]) for key in ("regions", "foreground_fraction", "spots") if summary[key] is not None}
        link = f"{OVERLAYS}/{summary['files']}.png"
        entries.append(SheetEntry(summary["image"], description_lines(summary), record["thumbnails"], link, numbers))
    return entries


def description_lines(summary: Mapping[str, Any]) -> list[str]:
    """Two lines below the pictures of an image."""
    size = f"{summary['width_px']} x {summary['height_px']} px"
    if summary["reason"] is not None:
        return [f"{size}, no threshold: {summary['reason']}", "0 regions"]
    threshold = "threshold of its surroundings" if summary["threshold"] is None else f"threshold {summary['threshold']}"
    if summary["spots"] is not None:
        gate = f"{summary['spots']} spots, limit {summary['spot_limit']:.0f}"
        threshold = f"{threshold} from {summary['first_threshold']} ({gate})" if summary["second_pass_fired"] else f"{threshold} ({gate})"
    counts = f"{_counted(summary['regions'], 'region')}, {_counted(summary['objects'], 'object')}"
    return [f"{size}, {threshold}", f"{counts}, {100 * summary['foreground_fraction']:.2f} % foreground"]


def _counted(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"
