"""The command `segment-compare`: five methods over many images, one row a method."""

import statistics
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ssjs_cli.config import Settings
from ssjs_cli.errors import UserError
from ssjs_cli.formats.atomic import holds_only, new_directory
from ssjs_cli.segmentation.contact_sheet import SheetEntry, shown_positions
from ssjs_cli.segmentation.image_jobs import each_image
from ssjs_cli.segmentation.image_list import ListedImage, listed_images, title_of
from ssjs_cli.segmentation.one_comparison import METHODS, ComparisonTask, compare_on_image
from ssjs_cli.segmentation.settings import SettingsRequest, resolve_segmentation
from ssjs_cli.segmentation.truth import TruthSource
from ssjs_cli.session import Session
from ssjs_cli.studies.tables import csv_text, json_text

KIND = "segmentation comparison"
COMPARISON_FILE = "comparison.json"
TABLE_FILE = "comparison.csv"
IMAGES_FILE = "images.csv"
CONFIG_FILE = "config.toml"
PAGE_FILE = "report.html"
FILES = (COMPARISON_FILE, TABLE_FILE, IMAGES_FILE, CONFIG_FILE, PAGE_FILE)
#: Six pictures an image.
MAX_IMAGES_SHOWN = 36

KEYS = (
    "method", "threshold_median", "time_ms_median", "hit_rate", "recall", "fpr", "ppv", "centroid_error_px_median",
    "false_regions_per_image",
    # Beyond the contract.
    "object_recall", "mask_iou_mean", "false_area_fraction", "regions_per_image", "second_pass_fraction", "objects", "images",
    "chain_time_ms_median",
)  # fmt: skip
IMAGE_KEYS = (
    "image", "method", "threshold", "second_pass_fired", "spots", "regions", "objects", "hits", "true_positives", "false_positives",
    "false_negatives", "true_negatives", "pixel_recall", "mask_iou", "false_area_fraction", "time_ms", "chain_time_ms",
)  # fmt: skip
_DIGITS = 6


@dataclass(frozen=True)
class ComparisonRequest:
    images: Sequence[str]
    settings: SettingsRequest = field(default_factory=SettingsRequest)
    truth: TruthSource = field(default_factory=TruthSource)
    valid_mask: Path | None = None
    repeats: int = 3
    jobs: int = 1
    with_report: bool = True
    out: Path | None = None
    force: bool = False


@dataclass(frozen=True)
class MethodComparison:
    """methods: one row each, every key of KEYS; images: one row an image and method."""

    directory: Path
    title: str
    settings: Settings
    methods: list[dict[str, Any]]
    images: list[dict[str, Any]]
    failures: list[tuple[str, str]]
    truth_is_known: bool

    @property
    def has_page(self) -> bool:
        return (self.directory / PAGE_FILE).is_file()

    @property
    def document(self) -> dict[str, Any]:
        failed = [{"image": name, "reason": reason} for name, reason in self.failures]
        return {"methods": self.methods, "failed": failed}


def compare_methods(request: ComparisonRequest, session: Session) -> MethodComparison:
    request.truth.check()
    settings, seed = resolve_segmentation(request.settings)
    images = listed_images(request.images)
    if request.valid_mask is not None and not request.valid_mask.exists():
        raise UserError(f"{request.valid_mask}: No such file or directory; check the path of --mask")
    out = request.out or Path("runs") / f"{title_of(request.images)}-segment-comparison"
    session.fault_log = out.with_name(out.name + ".fault.jsonl")
    with new_directory(out, force=request.force, why_not_ours=holds_only(FILES, (COMPARISON_FILE, IMAGES_FILE)), kind=KIND) as partial:
        task_of = _tasks(len(images), settings, request)
        results = each_image(compare_on_image, images, task_of, request.jobs, "comparing methods", session)
        used = results.records
        comparison = MethodComparison(
            out,
            title_of(request.images),
            settings,
            [method_row(method, list(used.values())) for method in METHODS],
            [row for record in used.values() for row in record["rows"]],
            results.failures,
            request.truth.is_known,
        )
        (partial / COMPARISON_FILE).write_text(json_text(comparison.document), encoding="utf-8")
        (partial / TABLE_FILE).write_text(csv_text(KEYS, comparison.methods), encoding="utf-8")
        (partial / IMAGES_FILE).write_text(csv_text(IMAGE_KEYS, comparison.images), encoding="utf-8")
        (partial / CONFIG_FILE).write_text(settings.to_toml(seed), encoding="utf-8")
        if request.with_report:
            from ssjs_cli.report.segment_comparison_page import segment_comparison_page

            entries = [_entry(name, record) for name, record in used.items() if record["thumbnails"]]
            (partial / PAGE_FILE).write_text(segment_comparison_page(comparison, entries), encoding="utf-8")
    return comparison


def method_row(method: str, records: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Ratios of counts are of the sums over all images; recall, mask IoU and false area are means over the images that have them."""
    rows = [row for record in records for row in record["rows"] if row["method"] == method]
    errors = [error for record in records for error in record["centroid_errors_px"].get(method, [])]
    fired = [row["second_pass_fired"] for row in rows if row["second_pass_fired"] is not None]
    answer: dict[str, Any] = dict.fromkeys(KEYS)
    answer.update(
        method=method,
        threshold_median=_median([row["threshold"] for row in rows if row["threshold"] is not None]),
        time_ms_median=_median([row["time_ms"] for row in rows]),
        chain_time_ms_median=_median([row["chain_time_ms"] for row in rows]),
        regions_per_image=_rounded(statistics.fmean(row["regions"] for row in rows)),
        second_pass_fraction=_rounded(statistics.fmean(fired)) if fired else None,
        images=len(rows),
    )
    if all("objects" in row for row in rows):
        total = {key: sum(row[key] for row in rows) for key in ("objects", "hits", "true_positives", "false_positives", "true_negatives")}
        missed = sum(row["false_negatives"] for row in rows)
        answer.update(
            objects=total["objects"],
            hit_rate=_ratio(total["hits"], total["objects"]),
            recall=_mean(rows, "pixel_recall"),
            object_recall=_ratio(total["objects"] - missed, total["objects"]),
            fpr=_ratio(total["false_positives"], total["false_positives"] + total["true_negatives"]),
            ppv=_ratio(total["true_positives"], total["true_positives"] + total["false_positives"]),
            centroid_error_px_median=_median(errors),
            false_regions_per_image=_ratio(total["false_positives"], len(rows)),
            mask_iou_mean=_mean(rows, "mask_iou"),
            false_area_fraction=_mean(rows, "false_area_fraction"),
        )
    return answer


def _ratio(part: int, whole: int) -> float | None:
    return round(part / whole, _DIGITS) if whole else None


def _rounded(value: float) -> float:
    return round(float(value), _DIGITS)


def _median(values: Sequence[float]) -> float | None:
    return _rounded(statistics.median(values)) if values else None


def _mean(rows: Sequence[Mapping[str, Any]], key: str) -> float | None:
    values = [row[key] for row in rows if row[key] is not None]
    return _rounded(statistics.fmean(values)) if values else None


def _tasks(images: int, settings: Settings, request: ComparisonRequest) -> Callable[[int, ListedImage], ComparisonTask]:
    shown = set(shown_positions(images, MAX_IMAGES_SHOWN)) if request.with_report else set()
    valid_mask = None if request.valid_mask is None else str(request.valid_mask)

    def task_of(position: int, image: ListedImage) -> ComparisonTask:
        return ComparisonTask(
            str(image.path), image.name, dict(settings.values), request.truth, valid_mask, request.repeats, position in shown
        )

    return task_of


def _entry(name: str, record: Mapping[str, Any]) -> SheetEntry:
    thresholds = ", ".join(f"{row['method']} {row['threshold']}" for row in record["rows"] if row["threshold"] is not None)
    lines = [f"thresholds: {thresholds}" if thresholds else "no threshold", "regions: " + _each(record["rows"], "regions")]
    if all("hits" in row for row in record["rows"]) and record["rows"][0]["objects"]:
        lines.append("objects hit: " + _each(record["rows"], "hits"))
    return SheetEntry(name, lines, record["thumbnails"])


def _each(rows: Sequence[Mapping[str, Any]], key: str) -> str:
    return ", ".join(f"{row['method']} {row[key]}" for row in rows)
