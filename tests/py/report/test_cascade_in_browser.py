"""The pages about cascades as a reader sees them: plots drawn, pictures loaded, no request, no complaint."""

import sys
from pathlib import Path
from typing import Any

import pytest
from browser_page import DRAWN_SHAPES, opened

from ssjs_cli.app import call

sys.path.insert(0, str(Path(__file__).parents[1] / "cascade"))

from side_scan_scenes import make_scenes

ALL_LOADED = "[...document.querySelectorAll('.card img')].every(image => image.complete && image.naturalWidth > 20)"


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("cascade")
    scenes = make_scenes(folder / "scenes", pictures=12)
    assert call(["cascade", "train", *map(str, scenes.options), "--recordings", r"(line\d\d)", "--out", str(folder / "model")]) == 0
    arguments = [
        str(folder / "model"),
        str(scenes.positives),
        "--masks",
        str(scenes.masks),
        "--jobs",
        "1",
        "--set",
        "evaluation.windows=1000",
    ]
    assert call(["cascade", "evaluate", *arguments, "--out", str(folder / "evaluation")]) == 0
    assert call(["cascade", "show", str(folder / "model"), "--out", str(folder / "shown.html")]) == 0
    return folder


def test_the_page_of_a_training(chromium: Any, results: Path) -> None:
    with opened(chromium, results / "model" / "report.html") as page:
        assert page.evaluate(DRAWN_SHAPES, "rates") >= 4
        assert page.evaluate(DRAWN_SHAPES, "response-1") > 100  # a mark for each window
        assert page.evaluate(ALL_LOADED)
        layers = page.locator("#layers tbody tr").count()
        assert page.locator("section[id^=layer-]").count() == layers > 0


def test_the_page_of_an_evaluation(chromium: Any, results: Path) -> None:
    with opened(chromium, results / "evaluation" / "report.html") as page:
        assert page.evaluate(DRAWN_SHAPES, "froc") >= 1
        assert page.evaluate(DRAWN_SHAPES, "precision-recall") >= 1
        assert page.evaluate(ALL_LOADED)
        assert page.locator("#best .card").count() == 24  # of 24 objects


def test_the_page_of_a_model(chromium: Any, results: Path) -> None:
    with opened(chromium, results / "shown.html") as page:
        assert page.evaluate(ALL_LOADED)
        assert page.locator("#mean .card").count() == 1
        assert page.locator("#settings tbody tr").count() > 20
