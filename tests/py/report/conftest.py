"""Run directories for the tests, and the browser that looks at their pages."""

import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from synthetic_run import FULL, SMALL, write_synthetic_run

CHROMIUM = Path("/usr/bin/chromium")
BROWSER_OPTIONS = [
    "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--no-first-run", "--disable-component-update", "--disable-sync",
]  # fmt: skip


@pytest.fixture
def small_run(tmp_path: Path) -> Path:
    return write_synthetic_run(tmp_path / "run", SMALL)


@pytest.fixture(scope="session")
def full_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """60,000 steps, 200 submaps, 1,500 landmarks."""
    return write_synthetic_run(tmp_path_factory.mktemp("full") / "run", FULL)


def _absent(what: str) -> None:
    if os.environ.get("SSJS_REQUIRE_DATA") == "1":
        pytest.fail(f"{what}, and SSJS_REQUIRE_DATA=1 asks for it")
    pytest.skip(what)


@pytest.fixture(scope="session")
def chromium() -> Iterator[Any]:
    if not CHROMIUM.is_file():
        _absent(f"{CHROMIUM} is not installed")
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        _absent("the Python package playwright is not installed")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=str(CHROMIUM), args=BROWSER_OPTIONS)
        yield browser
        browser.close()
