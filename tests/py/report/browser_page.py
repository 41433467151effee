"""A report opened in a real browser without a network."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

LOADING_LIMIT_MS = 120_000
SCREEN = {"width": 1440, "height": 900}

#: Shapes with a path inside a plot: lines, fills, markers, bars.
DRAWN_SHAPES = """id => [...document.querySelectorAll(`#${id} .scatterlayer path, #${id} .barlayer path`)]
    .filter(path => (path.getAttribute("d") || "").length > 4).length"""


@contextmanager
def opened(chromium: Any, report: Path) -> Iterator[Any]:
    """The page once everything is drawn, and what it complained about and asked for until it was closed."""
    page = chromium.new_page(viewport=SCREEN)
    complaints, requests = [], []
    page.on("console", lambda message: complaints.append(message.text))
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("dialog", lambda dialog: (complaints.append(dialog.message), dialog.dismiss()))
    page.on("request", lambda request: requests.append(request.url))
    page.goto(report.as_uri())
    page.wait_for_selector("html[data-report=ready]", state="attached", timeout=LOADING_LIMIT_MS)
    yield page
    page.close()
    assert complaints == []
    assert requests == [report.as_uri()]
