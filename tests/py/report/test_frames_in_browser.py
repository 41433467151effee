"""The report of a camera mission as a reader sees it."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser_page import opened
from synthetic_run import SMALL, write_synthetic_run

from ssjs_cli.formats.run_directory import PICTURES_FOLDER
from ssjs_cli.optical.landmark_patches import Looks, patch_sheet
from ssjs_cli.optical.mosaic_picture import Mosaic
from ssjs_cli.optical.picture_index import PictureIndex
from ssjs_cli.report import build_report

RED, BLUE = (220, 30, 30), (30, 30, 220)


@pytest.fixture
def report(tmp_path: Path) -> Path:
    """A mosaic far larger than the map's first view, red above y = 0 and blue below."""
    run = write_synthetic_run(tmp_path / "run", SMALL)
    picture = np.zeros((400, 600, 3), dtype=np.uint8)
    picture[:200], picture[200:] = RED, BLUE
    window = {"left": -900.0, "bottom": -600.0, "pixel_length": 3.0, "width_px": 600, "height_px": 400}
    index = PictureIndex(run / PICTURES_FOLDER, "m")
    index.add_mosaic(Mosaic(picture, np.full((400, 600), 255, dtype=np.uint8), window))
    frame = np.full((60, 80), 120, dtype=np.uint8)
    points = np.array([[10.0, 10.0], [40.0, 30.0]])
    index.add_matches(("a.png", "b.png"), (frame, frame), (points, points + 5.0), 13.0)
    landmarks = Looks(np.array([0, 3]), np.array([0, 0]), points)
    sheet = patch_sheet(landmarks, (80, 60), lambda number: frame)
    assert sheet is not None
    index.add_landmarks(sheet, lambda number: "a.png")
    index.frames(given=9, used=8, with_region=2)
    index.write()
    return build_report(run)


def test_the_mosaic_lies_under_the_map_the_right_way_up(chromium: Any, report: Path) -> None:
    with opened(chromium, report) as page:
        page.evaluate("Plotly.relayout('map', {'xaxis.range': [-200, 200], 'yaxis.range': [-200, 200]})")
        page.wait_for_timeout(500)
        above, below = shown_colours(page)
        assert above[0] > above[2] + 60 and below[2] > below[0] + 60
        page.locator("label:has(input[data-layer=mosaic])").click()
        page.wait_for_timeout(500)
        above, below = shown_colours(page)
        assert abs(above[0] - above[2]) < 60 and abs(below[0] - below[2]) < 60


def shown_colours(page: Any) -> tuple[Any, Any]:
    """Median colours of the upper and the lower part of the map."""
    from PIL import Image

    with Image.open(io.BytesIO(page.locator("#map").screenshot())) as picture:
        pixels = np.asarray(picture.convert("RGB")).astype(int)
    height, width = pixels.shape[:2]
    middle = slice(width // 3, 2 * width // 3)
    upper, lower = pixels[height // 10 : 3 * height // 10, middle], pixels[6 * height // 10 : 8 * height // 10, middle]
    return np.median(upper.reshape(-1, 3), axis=0), np.median(lower.reshape(-1, 3), axis=0)


@pytest.mark.parametrize("width", [1280, 800])
def test_frames_have_their_section(chromium: Any, report: Path, width: int) -> None:
    with opened(chromium, report, {"width": width, "height": 900}) as page:
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        assert "8 of 9 frames were used; 2 of them (25 %)" in page.locator("#frames-section").inner_text().replace("25.0", "25")
        assert "a.png and b.png" in page.locator("#frames-section .matches").inner_text()
        broken = "[...document.images].filter(image => image.complete && image.naturalWidth === 0).length"
        assert page.evaluate(broken) == 0


def test_landmarks_have_their_patches(chromium: Any, report: Path) -> None:
    with opened(chromium, report) as page:
        section = page.locator("#landmarks-section")
        assert section.locator("h2").inner_text() == "Landmarks"
        cards = section.locator(".patch-card")
        assert cards.count() == 2
        assert sorted(cards.nth(number).locator("b").inner_text() for number in range(2)) == ["0", "3"]
        assert "looks" in cards.first.inner_text() and cards.first.get_attribute("title").startswith("a.png at (")
        assert section.locator("#landmark-table tbody tr").count() > 2
        assert page.locator("#contacts-section").count() == 0


def test_without_a_scale_no_length_is_in_metres(chromium: Any, report: Path) -> None:
    run = report.parent
    summary = json.loads((run / "summary.json").read_text())
    (run / "summary.json").write_text(json.dumps({**summary, "length_unit": "frame widths"}))
    with opened(chromium, build_report(run)) as page:
        heads = page.locator("#submap-table th").all_text_contents() + page.locator("#landmark-table th").all_text_contents()
        assert [text for text in heads if "[m]" in text] == [] and any("[widths]" in text for text in heads)
        assert "frame widths" in page.locator("#replay-readout").inner_text()
        hover = page.evaluate("[...document.getElementById('map').data].map(trace => trace.hovertemplate || '').join(' ')")
        assert "frame widths" in hover and "} m" not in hover
