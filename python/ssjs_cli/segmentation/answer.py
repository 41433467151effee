"""What a finished segmentation says on the terminal."""

from ssjs_cli.finished import Finished, note_losses
from ssjs_cli.segmentation import comparison as compared
from ssjs_cli.segmentation.result_files import OBJECTS_FILE, PAGE_FILE, REGIONS_FILE
from ssjs_cli.session import Session
from ssjs_cli.studies.tables import Column, terminal_table

COMPARISON_COLUMNS: tuple[Column, ...] = (
    ("method", "method", ""),
    ("threshold_median", "threshold", ".0f"),
    ("time_ms_median", "ms", ".3f"),
    ("chain_time_ms_median", "chain ms", ".3f"),
    ("hit_rate", "hit rate", ".3f"),
    ("recall", "recall", ".3f"),
    ("object_recall", "found", ".3f"),
    ("fpr", "FPR", ".4f"),
    ("ppv", "PPV", ".3f"),
    ("centroid_error_px_median", "centroid px", ".2f"),
    ("false_regions_per_image", "false regions", ".2f"),
    ("false_area_fraction", "false area", ".2%"),
    ("regions_per_image", "regions", ".1f"),
)


def answer_segmentation(finished: Finished, session: Session) -> int:
    code = note_losses(finished.failures, session)
    totals = finished.document["totals"]
    lines = [f"{totals['images']} images, {totals['regions']} regions, {totals['objects']} objects ({finished.document['method']})"]
    if finished.document["method"] == "improved-otsu":
        lines.append(f"  second pass in {totals['second_pass_fired']} images")
    if totals["without_threshold"]:
        lines.append(f"  {totals['without_threshold']} images have no threshold")
    if totals["failed"]:
        lines.append(f"  {totals['failed']} images could not be used")
    names = [name for name in (REGIONS_FILE, OBJECTS_FILE, PAGE_FILE) if (finished.directory / name).is_file()]
    lines += [f"{name.split('.')[0]:<11} {finished.directory / name}" for name in names]
    session.answer({"directory": str(finished.directory), **finished.document}, "\n".join(lines))
    return code


def answer_comparison(comparison: compared.MethodComparison, session: Session) -> int:
    code = note_losses(comparison.failures, session)
    rows = comparison.methods
    names = [name for name in (compared.COMPARISON_FILE, compared.PAGE_FILE) if name != compared.PAGE_FILE or comparison.has_page]
    lines = [f"{name.split('.')[0]:<11} {comparison.directory / name}" for name in names]
    title = f"{comparison.title}: {rows[0]['images']} images"
    session.answer(comparison.document, terminal_table(title, COMPARISON_COLUMNS, rows) + "\n\n" + "\n".join(lines))
    return code
