"""The page of many segmented images: facts, small pictures side by side, tables. One file, offline, of bounded size."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from urllib.parse import quote

from ssjs_cli.report.page_parts import data_url, render, shown_failures
from ssjs_cli.report.sheet import Sheet
from ssjs_cli.segmentation.contact_sheet import SheetEntry
from ssjs_cli.segmentation.pictures import BORDER, CENTROID, INVALID, OBJECT, TRUTH, Colour

#: More rows stay in the tables beside the page.
MAX_ROWS = 2000


@dataclass(frozen=True)
class ContactPage:
    """orders: key of an entry's sort_keys and what the reader calls it; images: how many there are, shown or not."""

    kind: str
    title: str
    facts: list[tuple[str, str]]
    entries: Sequence[SheetEntry]
    images: int
    sheets: list[Sheet]
    orders: list[tuple[str, str]] = field(default_factory=list)
    failures: list[tuple[str, str]] = field(default_factory=list)
    objects_are_shown: bool = True
    truth_is_shown: bool = False


def render_contacts(page: ContactPage) -> str:
    shown = len(page.entries)
    return render(
        "contacts.html.j2",
        {},
        ("sorted_tables.js", "contacts.js"),
        styles=("report.css", "pictures.css"),
        with_plots=False,
        kind=page.kind,
        title=page.title,
        subtitle="",
        facts=page.facts,
        failures=shown_failures(page.failures),
        entries=[_with_safe_link(entry) for entry in page.entries],
        orders=page.orders,
        legend=_legend(page),
        shown_text=f"{shown} of {page.images} images, evenly chosen" if shown < page.images else f"{shown} images" if shown != 1 else "",
        panels=max((len(entry.thumbnails) for entry in page.entries), default=1),
        sheets=[sheet for sheet in page.sheets if sheet.rows],
        data_url=data_url,
    )


def _with_safe_link(entry: SheetEntry) -> SheetEntry:
    return SheetEntry(entry.name, entry.lines, entry.thumbnails, quote(entry.link), entry.sort_keys)


def _legend(page: ContactPage) -> list[tuple[str, str, bool]]:
    marks: list[tuple[Colour, str, bool]] = [(BORDER, "border of a region", False), (CENTROID, "its centroid", False)]
    if page.objects_are_shown:
        marks.append((OBJECT, "centroid of an object", True))
    if page.truth_is_shown:
        marks.append((TRUTH, "border of the truth", False))
    marks.append((INVALID, "invalid pixels", False))
    return [("#{:02x}{:02x}{:02x}".format(*colour), text, ring) for colour, text, ring in marks]
