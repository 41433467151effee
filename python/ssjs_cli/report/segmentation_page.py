"""The page of a segmentation."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ssjs_cli.report.contact_page import MAX_ROWS, ContactPage, render_contacts
from ssjs_cli.report.number_text import count_text
from ssjs_cli.report.sheet import Sheet, SheetColumn, sheet
from ssjs_cli.segmentation.contact_sheet import SheetEntry

if TYPE_CHECKING:
    from ssjs_cli.segmentation.result_files import Segmented

COLUMNS: tuple[SheetColumn, ...] = (
    ("image", "image", None, 1.0),
    ("width_px", "width [px]", 0, 1.0),
    ("height_px", "height [px]", 0, 1.0),
    ("valid_fraction", "valid [%]", 1, 100.0),
    ("first_threshold", "T", 0, 1.0),
    ("threshold", "threshold", 0, 1.0),
    ("spots", "spots", 0, 1.0),
    ("spot_limit", "limit", 0, 1.0),
    ("second_pass", "second pass", None, 1.0),
    ("regions", "regions", 0, 1.0),
    ("objects", "objects", 0, 1.0),
    ("foreground_fraction", "foreground [%]", 2, 100.0),
    ("reason", "without threshold because", None, 1.0),
)
ORDERS = [("regions", "most regions"), ("foreground_fraction", "most foreground"), ("spots", "most spots")]


def segmentation_page(segmented: "Segmented", document: Mapping[str, Any], entries: Sequence[SheetEntry]) -> str:
    totals = document["totals"]
    facts = [("method", segmented.method)]
    if segmented.preset is not None:
        facts.append(("preset", segmented.preset))
    facts += [(name, count_text(totals[name])) for name in ("images", "regions", "objects")]
    if any(summary["spots"] is not None for summary in document["images"]):
        facts.append(("second pass", f"{count_text(totals['second_pass_fired'])} of {count_text(totals['images'])}"))
    for key in ("without_threshold", "failed"):
        if totals[key]:
            facts.append((key.replace("_", " "), count_text(totals[key])))
    facts.append(("version", str(document["version"])))
    used = {key for summary in document["images"] for key, value in summary.items() if value is not None}
    return render_contacts(
        ContactPage(
            kind="images, masks, centroids",
            title=segmented.title,
            facts=facts,
            entries=entries,
            images=len(segmented.records),
            sheets=[_table(document["images"])],
            orders=[(key, label) for key, label in ORDERS if key in used],
            failures=list(segmented.failures),
        )
    )


def _table(summaries: Sequence[Mapping[str, Any]]) -> Sheet:
    rows = [_with_words(summary) for summary in summaries[:MAX_ROWS]]
    note = f"The first {MAX_ROWS} of {len(summaries)} images; segmentation.json holds all." if len(summaries) > MAX_ROWS else ""
    return sheet("images", "Images", COLUMNS, rows, note=note, in_overview=False)


def _with_words(summary: Mapping[str, Any]) -> dict[str, Any]:
    fired = summary["second_pass_fired"]
    return {**summary, "second_pass": None if fired is None else "yes" if fired else "no"}
