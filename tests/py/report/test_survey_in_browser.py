"""The report of a survey as a reader sees it."""

from pathlib import Path
from typing import Any

import pytest
from browser_page import DRAWN_SHAPES, SPEED_ADVICE, opened
from synthetic_survey import write_synthetic_survey

from ssjs_cli.report import build_report

FLAT_PLOTS = ("map", "top-view", "side-view", "coverage", "depth-profile", "uncertainty")


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build_report(write_synthetic_survey(tmp_path_factory.mktemp("survey") / "run"))


@pytest.mark.parametrize("width", [1280, 800])
def test_everything_is_drawn_and_nothing_is_wider_than_the_screen(chromium: Any, report: Path, width: int) -> None:
    with opened(chromium, report, {"width": width, "height": 900}, SPEED_ADVICE) as page:
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        for name in FLAT_PLOTS:
            assert page.evaluate(DRAWN_SHAPES, name) > 0, name
        assert page.evaluate("document.querySelectorAll('#space-view .gl-container canvas, #space-view .gl-container').length") > 0
        broken = "[...document.images].filter(image => image.complete && image.naturalWidth === 0).length"
        assert page.evaluate(broken) == 0
        pictures = "[...document.querySelectorAll('.sonar-picture')].map(picture => picture.getBoundingClientRect().height)"
        assert min(page.evaluate(pictures)) > 60.0


def test_degrees_follow_the_map_as_it_is_enlarged(chromium: Any, report: Path) -> None:
    with opened(chromium, report, advice=SPEED_ADVICE) as page:
        page.evaluate("Plotly.relayout('map', {'xaxis.range': [0, 10], 'yaxis.range': [20, 30]})")
        page.wait_for_function("""() => {
            const shown = document.getElementById('map')._fullLayout, step = 1 / 111080;
            const bottom = 41.7 + shown.yaxis.range[0] * step;
            return shown.yaxis.range[1] - shown.yaxis.range[0] < 60 && Math.abs(shown.yaxis2.range[0] - bottom) < 1e-6;
        }""")
