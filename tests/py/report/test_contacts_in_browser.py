"""The pages of segmentations as a reader sees them: pictures loaded, no request, no complaint."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser_page import opened
from PIL import Image

from ssjs_cli.app import call


@pytest.fixture(scope="module")
def scenes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three pictures with 1, 2 and 3 bright squares on a quiet bottom."""
    folder = tmp_path_factory.mktemp("scenes")
    for squares in (1, 2, 3):
        levels = np.random.default_rng(squares).integers(20, 40, (80, 120), dtype=np.uint8)
        for index in range(squares):
            levels[30:42, 15 + 35 * index : 27 + 35 * index] = 230
        Image.fromarray(levels).save(folder / f"{squares}.png")
    return folder


def names(page: Any) -> list[str]:
    return page.locator(".contact h3").all_inner_texts()


def test_pictures_are_shown_sorted_and_enlarged(chromium: Any, scenes: Path) -> None:
    assert call(["segment", str(scenes), "--jobs", "1", "--out", str(scenes / "out")]) == 0
    with opened(chromium, scenes / "out" / "report.html") as page:
        assert names(page) == ["1.png", "2.png", "3.png"]
        assert page.locator("#images tbody tr").count() == 3
        page.select_option("#sheet-order", "regions")
        assert names(page) == ["3.png", "2.png", "1.png"]
        page.locator(".contact button").first.click()
        assert page.evaluate("document.getElementById('large').open && document.querySelector('#large img').naturalWidth > 100")
        page.locator("#large img").click()
        assert not page.evaluate("document.getElementById('large').open")


def test_methods_stand_side_by_side(chromium: Any, scenes: Path) -> None:
    assert call(["segment-compare", str(scenes), "--no-objects", "--repeat", "1", "--out", str(scenes / "compared")]) == 0
    with opened(chromium, scenes / "compared" / "report.html") as page:
        assert page.locator("#methods tbody tr").count() == 5
        assert page.locator(".contact").first.locator("figcaption").all_inner_texts() == [
            "picture and truth", "improved-otsu", "otsu", "local", "iterative", "max-entropy"
        ]  # fmt: skip
