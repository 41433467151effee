"""The pages of the studies as a reader sees them: drawn plots, no request, no complaint."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from browser_page import DRAWN_SHAPES, opened

from ssjs_cli.app import call

POND = Path(__file__).parents[3] / "examples" / "scenarios" / "pond.toml"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Path]:
    """A command line whose --out is the folder returned."""
    folder = tmp_path_factory.mktemp("studies")

    def make(name: str, *arguments: object) -> Path:
        if not (folder / name).exists():
            assert call([*(str(argument) for argument in arguments), "--out", str(folder / name)]) == 0
        return folder / name

    return make


@pytest.fixture(scope="module")
def comparison(made: Callable[..., Path]) -> Path:
    mission = made("mission", "simulate", POND)
    return made("comparison", "compare", mission, "--methods", "ssjs,ekf") / "report.html"


def visible(page: Any, traces: list[int]) -> list[bool]:
    return [page.evaluate("index => document.getElementById('map').data[index].visible", index) is True for index in traces]


def drawn_figures(page: Any) -> list[str]:
    names = page.evaluate("Object.keys(JSON.parse(document.getElementById('report-data').textContent).figures)")
    for name in names:
        assert page.evaluate(DRAWN_SHAPES, name) > 0, name
    return names


def test_a_comparison_draws_every_curve_in_silence(chromium: Any, comparison: Path) -> None:
    with opened(chromium, comparison) as page:
        expected = ["map", "time-split", "cumulative-time", "error", "error-online", "nees", "nees-online", "nis"]
        assert sorted(drawn_figures(page)) == sorted(expected)
        assert page.locator(".missing").count() == 0
        for sheet in ("accuracy", "consistency-numbers", "times", "counts"):
            assert page.locator(f"#{sheet} tbody tr").count() == 2
        rows = json.loads((comparison.parent / "comparison.json").read_text())["methods"]
        shown = page.locator("#accuracy tbody tr").first.inner_text().split("\t")
        assert shown[:2] == ["ssjs", f"{rows[0]['trajectory_rmse_m']:.3f}"]


def test_a_switch_hides_a_method_on_the_map(chromium: Any, comparison: Path) -> None:
    with opened(chromium, comparison) as page:
        layers = page.evaluate("JSON.parse(document.getElementById('report-data').textContent).layers")
        assert visible(page, layers["method-ekf"]) == [True, True]
        assert visible(page, layers["dead_reckoning"]) == [False]
        page.click("label:has(input[data-layer=method-ekf])")
        page.wait_for_function("index => document.getElementById('map').data[index].visible === false", arg=layers["method-ekf"][0])
        assert visible(page, layers["method-ekf"]) == [False, False]
        assert visible(page, layers["method-ssjs"]) == [True, True]


def test_the_tables_of_a_comparison_sort(chromium: Any, comparison: Path) -> None:
    total = "() => [...document.querySelectorAll('#times tbody tr')].map(row => Number(row.cells[1].dataset.v))"
    with opened(chromium, comparison) as page:
        head = page.locator("#times th").nth(1)
        head.click()
        assert page.evaluate(total) == sorted(page.evaluate(total))
        head.click()
        assert page.evaluate(total) == sorted(page.evaluate(total), reverse=True)


def test_a_consistency_study_draws_its_bands(chromium: Any, made: Callable[..., Path]) -> None:
    folder = made("consistency", "consistency", POND, "--runs", 3, "--methods", "ssjs,ekf")
    with opened(chromium, folder / "report.html") as page:
        assert sorted(drawn_figures(page)) == ["joint", "nees", "nees-online", "nis", "rmse"]
        assert page.locator("#runs tbody tr").count() == 6
        assert "95 % band" in page.text_content("#nees .legend")


def test_a_sweep_draws_one_line_a_submap_size(chromium: Any, made: Callable[..., Path]) -> None:
    folder = made("sweep", "sweep", POND, "--submap-size", "8,12,16", "--fusion-threshold", "0.3,0.5,0.8")
    with opened(chromium, folder / "report.html") as page:
        assert {"time-total-s", "loop-candidates", "fusions", "live-maps", "map-error-mean-m"} <= set(drawn_figures(page))
        traces = page.evaluate("document.getElementById('time-total-s').data.map(trace => [trace.name, trace.x])")
        assert traces == [[f"{size} landmarks", [0.3, 0.5, 0.8]] for size in (8, 12, 16)]
        assert page.locator("#cells tbody tr").count() == 9


def test_a_mission_without_truth_and_a_hostile_name(chromium: Any, circle_mission: Path, tmp_path: Path) -> None:
    hostile = "</script><img src=x onerror=alert(1)>"
    for name in ("truth_trajectory.tum", "truth_landmarks.csv"):
        (circle_mission / name).unlink()
    text = (circle_mission / "mission.toml").read_text()
    (circle_mission / "mission.toml").write_text(text.replace('name = "circle"', f'name = "{hostile}"'))
    assert call(["compare", str(circle_mission), "--methods", "ssjs", "--out", str(tmp_path / "c")]) == 0
    with opened(chromium, tmp_path / "c" / "report.html") as page:
        assert page.inner_text("h1") == hostile
        assert page.locator("img").count() == 0
        assert page.locator(".missing").all_inner_texts() == [
            "The mission holds no reference to compare with.",
            "The mission holds no dense truth, which NEES needs; NIS below needs none.",
        ]
        assert sorted(drawn_figures(page)) == ["cumulative-time", "map", "nis", "time-split"]
