"""The contact sheet of a survey: a card for each contact with its picture, and a table of them all."""

from dataclasses import dataclass
from pathlib import Path

from ssjs_cli.report.number_text import count_text
from ssjs_cli.report.picture_data import jpeg_url
from ssjs_cli.report.sheet import NAME, Sheet, sheet
from ssjs_cli.report.survey_files import SurveyFiles

#: Cards with a picture; so many of them are some 4 MB.
MAX_CARDS = 200
MAX_ROWS = 3000
SNIPPET_PX = 180
SNIPPET_QUALITY = 70
STRIP_PX = 380
STRIP_QUALITY = 55


@dataclass(frozen=True)
class ContactCard:
    number: str
    name: str
    snippet: str
    strip: str
    facts: list[tuple[str, str]]
    remark: str


@dataclass(frozen=True)
class ContactSheet:
    cards: list[ContactCard]
    table: Sheet
    note: str


#: column, heading, decimals; the columns of a run that has them
TABLE = (
    ("id", "contact", NAME),
    ("latitude_deg", "latitude [°]", 6),
    ("longitude_deg", "longitude [°]", 6),
    ("x_m", "x [m]", 2),
    ("y_m", "y [m]", 2),
    ("depth_m", "depth [m]", 2),
    ("sigma_major_m", "σ major [m]", 2),
    ("sigma_minor_m", "σ minor [m]", 2),
    ("length_m", "length [m]", 2),
    ("width_m", "width [m]", 2),
    ("height_m", "height [m]", 2),
    ("confidence", "confidence", 2),
    ("sightings", "times seen", 0),
    ("passes", "passes", 0),
    ("existence", "existence", 3),
    ("channel", "side", None),
    ("time_s", "time [s]", 1),
    ("log", "log", None),
    ("ping", "ping", 0),
)


def number_of(row: dict[str, str], key: str) -> float | None:
    try:
        return float(row.get(key, ""))
    except ValueError:
        return None


def contact_sheet(survey: SurveyFiles) -> ContactSheet | None:
    """Those seen most often first, among them the surest first. None without contacts."""
    rows = survey.contacts
    if not rows:
        return None
    ordered = sorted(
        rows, key=lambda row: (-(number_of(row, "sightings") or 0.0), -(number_of(row, "confidence") or 0.0), row.get("id", ""))
    )
    pictured = [row for row in ordered if _picture(survey, row, "") is not None]
    cards = [_card(survey, row) for row in pictured[:MAX_CARDS]]
    notes = []
    if len(pictured) > MAX_CARDS:
        notes.append(
            f"The {MAX_CARDS} of {count_text(len(pictured))} contacts that were seen most often are shown; all pictures are in snippets/."
        )
    without = len(rows) - len(pictured)
    if cards and without:
        notes.append(f"{count_text(without)} contacts have no picture: no sighting lies near enough to them on the final track.")
    table_rows = [
        {key: (row.get(key) or None) if decimals is None else _of_run(survey, row, key) for key, _, decimals in TABLE}
        for row in ordered[:MAX_ROWS]
    ]
    columns = [(key, heading, decimals, 1.0) for key, heading, decimals in TABLE]
    table_note = f"The first {count_text(MAX_ROWS)} of {count_text(len(rows))}." if len(rows) > MAX_ROWS else ""
    return ContactSheet(cards, sheet("contact-table", "Every contact", columns, table_rows, note=table_note), " ".join(notes))


def _of_run(survey: SurveyFiles, row: dict[str, str], key: str) -> float | None:
    value = number_of(row, key)
    return value - survey.time_origin_s if value is not None and key == "time_s" else value


def _picture(survey: SurveyFiles, row: dict[str, str], suffix: str) -> Path | None:
    """The file that contacts.csv names, inside snippets/ and nowhere else."""
    name = Path(row.get("snippet", "")).name
    if survey.snippets is None or not name:
        return None
    path = survey.snippets / name
    path = path.with_name(f"{path.stem}{suffix}{path.suffix}")
    return path if path.is_file() else None


def _card(survey: SurveyFiles, row: dict[str, str]) -> ContactCard:
    snippet, strip = _picture(survey, row, ""), _picture(survey, row, "-strip")
    return ContactCard(
        number=row.get("id", ""),
        name=row.get("name", "") or f"contact {row.get('id', '')}",
        snippet="" if snippet is None else jpeg_url(snippet, SNIPPET_QUALITY, SNIPPET_PX),
        strip="" if strip is None else jpeg_url(strip, STRIP_QUALITY, STRIP_PX),
        facts=_facts(row),
        remark=row.get("remark", ""),
    )


def _facts(row: dict[str, str]) -> list[tuple[str, str]]:
    def text(key: str, decimals: int) -> str:
        value = number_of(row, key)
        return "" if value is None else f"{value:.{decimals}f}"

    facts: list[tuple[str, str]] = []
    length, width, height = (text(key, 1) for key in ("length_m", "width_m", "height_m"))
    if length and width:
        facts.append(("size", f"{length} × {width} m"))
    if height:
        facts.append(("height", f"{'≥ ' if 'lower bound' in row.get('remark', '') else ''}{height} m"))
    latitude, longitude = number_of(row, "latitude_deg"), number_of(row, "longitude_deg")
    if latitude is not None and longitude is not None:
        facts.append(
            ("position", f"{abs(latitude):.6f}° {'N' if latitude >= 0 else 'S'} {abs(longitude):.6f}° {'E' if longitude >= 0 else 'W'}")
        )
    else:
        facts.append(("position", f"x {text('x_m', 1)} m, y {text('y_m', 1)} m"))
    facts.append(("σ", f"{text('sigma_major_m', 2)} × {text('sigma_minor_m', 2)} m"))
    if text("confidence", 2):
        facts.append(("confidence", text("confidence", 2)))
    passes = text("passes", 0)
    facts.append(("seen", f"{text('sightings', 0)} ×" + (f" in {passes} pass{'' if passes == '1' else 'es'}" if passes else "")))
    if text("existence", 2):
        facts.append(("existence", text("existence", 2)))
    if text("ground_range_m", 1):
        facts.append(("best", f"{text('ground_range_m', 1)} m {row.get('channel', '')}, ping {text('ping', 0)}"))
    return facts
