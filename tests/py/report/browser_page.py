"""A report opened in a real browser without a network."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

LOADING_LIMIT_MS = 120_000
ViewportSize = dict[str, int]
SCREEN: ViewportSize = {"width": 1440, "height": 900}

#: Shapes with a path inside a plot: lines, fills, markers, bars.
DRAWN_SHAPES = """id => [...document.querySelectorAll(`#${id} .scatterlayer path, #${id} .barlayer path`)]
    .filter(path => (path.getAttribute("d") || "").length > 4).length"""


#: What a browser without a graphics card says of any picture in space: advice on speed, not a fault of the page.
SPEED_ADVICE = ("Canvas2D: Multiple readback operations", "[.WebGL-")


@contextmanager
def opened(chromium: Any, report: Path, screen: ViewportSize = SCREEN, advice: tuple[str, ...] = ()) -> Iterator[Any]:
    """The page once everything is drawn, and what it complained about and asked for until it was closed. advice: beginnings of lines on
    the console that are none."""
    page = chromium.new_page(viewport=screen)
    complaints: list[str] = []
    requests: list[str] = []
    page.on("console", lambda message: None if message.text.startswith(advice or "\0") else complaints.append(message.text))
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("dialog", lambda dialog: (complaints.append(dialog.message), dialog.dismiss()))
    page.on("request", lambda request: requests.append(request.url))
    page.goto(report.as_uri())
    page.wait_for_selector("html[data-report=ready]", state="attached", timeout=LOADING_LIMIT_MS)
    yield page
    page.close()
    assert complaints == []
    assert requests == [report.as_uri()]
