"""The page of a comparison of segmentation methods."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ssjs_cli.report.contact_page import ContactPage, TableSheet, render_contacts
from ssjs_cli.report.number_text import count_text
from ssjs_cli.report.tables import Cell, Row, number_cell, text_cell
from ssjs_cli.segmentation.contact_sheet import SheetEntry

if TYPE_CHECKING:
    from ssjs_cli.segmentation.comparison import MethodComparison

#: key, heading, decimals (None for text), factor
COLUMNS: tuple[tuple[str, str, int | None, float], ...] = (
    ("method", "method", None, 1.0),
    ("threshold_median", "threshold", 0, 1.0),
    ("hit_rate", "hit rate", 3, 1.0),
    ("recall", "recall", 3, 1.0),
    ("object_recall", "objects with a region", 3, 1.0),
    ("fpr", "FPR", 4, 1.0),
    ("ppv", "PPV", 3, 1.0),
    ("centroid_error_px_median", "centroid error [px]", 1, 1.0),
    ("false_regions_per_image", "false regions / image", 1, 1.0),
    ("false_area_fraction", "false area [%]", 1, 100.0),
    ("mask_iou_mean", "mask IoU", 3, 1.0),
    ("regions_per_image", "regions / image", 1, 1.0),
    ("second_pass_fraction", "second pass [%]", 0, 100.0),
    ("time_ms_median", "threshold [ms]", 3, 1.0),
    ("chain_time_ms_median", "chain [ms]", 3, 1.0),
)
NOTE = (
    "Every method has the same filter, gain, power law and morphology. Hit rate: objects that a region meets with an intersection over "
    "union above 0.3. Recall: share of the objects' pixels that are foreground, mean over the images. FPR and PPV count regions; what is "
    "rightly left out are components of the plain Otsu mask away from the objects. Times are medians on one thread."
)


def segment_comparison_page(comparison: "MethodComparison", entries: Sequence[SheetEntry]) -> str:
    shown = [column for column in COLUMNS if any(row.get(column[0]) is not None for row in comparison.methods)]
    rows = []
    for row in comparison.methods:
        cells: list[Cell] = []
        for key, _, decimals, factor in shown:
            cells.append(text_cell(row[key]) if decimals is None else number_cell(row[key], decimals, factor))
        rows.append(Row(cells))
    images = comparison.methods[0]["images"]
    facts = [("images", count_text(images))]
    if comparison.methods[0]["objects"] is not None:
        facts.append(("objects", count_text(comparison.methods[0]["objects"])))
    if comparison.failures:
        facts.append(("failed", count_text(len(comparison.failures))))
    return render_contacts(
        ContactPage(
            kind="five methods side by side",
            title=comparison.title,
            facts=facts,
            entries=entries,
            images=images,
            sheets=[TableSheet("methods", "Methods", [column[1] for column in shown], rows, NOTE, in_overview=True)],
            failures=list(comparison.failures),
            objects_are_shown=False,
            truth_is_shown=comparison.truth_is_known,
        )
    )
