"""What every page is made of: plots with a fixed place, the templates, and the data inside one script element."""

import base64
import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup

from ssjs_cli.report.figure_style import Figure

TEMPLATES = Path(__file__).parent / "templates"
#: More stay in the result files.
MAX_FAILURES = 50


@dataclass
class Plot:
    """div_id: fixed, so that tests and links find it; missing: what to say instead of an empty plot."""

    div_id: str
    heading: str
    figure: Figure | None = None
    notes: list[str] = field(default_factory=list)
    missing: str = ""

    @property
    def height_px(self) -> int:
        return int(self.figure["layout"]["height"]) if self.figure is not None else 0


def render(
    template: str,
    data: dict[str, Any],
    scripts: tuple[str, ...],
    *,
    styles: tuple[str, ...] = ("report.css",),
    with_plots: bool = True,
    **variables: Any,
) -> str:
    """A whole page: style, our scripts and plotly (where it has plots) inside, `data` as JSON for them. Nothing is fetched."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES), autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    return environment.get_template(template).render(
        style_sheet=_joined(styles),
        plotly_script=_plotly() if with_plots else Markup(""),
        page_script=_joined(scripts),
        data=_json_for_script(data),
        **variables,
    )


def data_url(data: bytes, media_type: str = "image/png") -> str:
    return f"data:{media_type};base64,{base64.b64encode(data).decode('ascii')}"


def shown_failures(failures: Sequence[tuple[str, str]]) -> list[tuple[str, str]]:
    shown = list(failures[:MAX_FAILURES])
    if len(failures) > MAX_FAILURES:
        shown.append((f"{len(failures) - MAX_FAILURES} more", "are listed in the result files"))
    return shown


def _plotly() -> Markup:
    from plotly.offline import get_plotlyjs

    return Markup(get_plotlyjs())


def _joined(names: tuple[str, ...]) -> Markup:
    return Markup("\n").join(_raw(name) for name in names)


def _raw(name: str) -> Markup:
    return Markup((TEMPLATES / name).read_text(encoding="utf-8"))


def _json_for_script(document: dict[str, Any]) -> Markup:
    """JSON that no text inside can break out of a script element: <, > and & leave as escapes."""
    text = json.dumps(document, ensure_ascii=False, allow_nan=False, separators=(",", ":"), sort_keys=True)
    for character in "<>&\u2028\u2029":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return Markup(text)
