"""The page of a comparison of segmentation methods."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ssjs_cli.report.contact_page import ContactPage, render_contacts
from ssjs_cli.report.number_text import count_text
from ssjs_cli.report.sheet import SheetColumn, sheet
from ssjs_cli.segmentation.contact_sheet import SheetEntry

if TYPE_CHECKING:
    from ssjs_cli.segmentation.comparison import MethodComparison

COLUMNS: tuple[SheetColumn, ...] = (
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
            sheets=[sheet("methods", "Methods", COLUMNS, comparison.methods, note=NOTE)],
            failures=list(comparison.failures),
            objects_are_shown=False,
            truth_is_shown=comparison.truth_is_known,
        )
    )
