"""The page as a reader sees it, in a real browser without a network."""

import json
import re

import pytest
from browser_page import DRAWN_SHAPES, opened
from synthetic_run import SMALL, write_synthetic_run

from ssjs_cli.report import build_report
from ssjs_cli.report.page import FIGURE_IDS


@pytest.fixture(scope="module")
def full_report(full_run):
    return build_report(full_run)


@pytest.fixture(scope="module")
def small_page(chromium, tmp_path_factory):
    """One page for the tests that only need some mission: loading takes most of their time."""
    with opened(chromium, build_report(write_synthetic_run(tmp_path_factory.mktemp("small") / "run", SMALL))) as page:
        yield page


@pytest.fixture
def page(small_page):
    """The page as after loading: slider at the end, final estimate, screen."""
    small_page.select_option("#replay-estimate", "final")
    move_slider(small_page, 1.0)
    yield small_page
    small_page.emulate_media(media="screen")


def move_slider(page, part):
    page.evaluate(
        """part => { const slider = document.getElementById("replay-slider");
        slider.value = Math.round(part * slider.max); slider.dispatchEvent(new Event("input")); }""",
        part,
    )


def vehicle_place(page):
    """Pixels of the vehicle within the frame of the map."""
    transform = page.get_attribute("#vehicle-marker", "transform")
    return tuple(float(number) for number in re.match(r"translate\((\S+) (\S+)\)", transform).groups())


def test_long_mission_draws_every_plot_in_silence(chromium, full_report):
    with opened(chromium, full_report) as page:
        for name in FIGURE_IDS:
            assert page.evaluate(DRAWN_SHAPES, name) > 0, name
        assert page.locator("#map .scatterlayer .point").count() >= 1500
        assert page.locator("#submap-table tbody tr").count() == 200


def test_slider_moves_the_vehicle_and_hides_the_future(chromium, full_report):
    with opened(chromium, full_report) as page:
        at_end = vehicle_place(page)
        assert "1500 of 1500" in page.inner_text("#replay-readout")
        move_slider(page, 0.25)
        early = vehicle_place(page)
        move_slider(page, 0.5)
        late = vehicle_place(page)
        assert len({at_end, early, late}) == 3
        assert page.evaluate("document.getElementById('map-frame').classList.contains('replaying')")
        shown = int(re.search(r"landmarks\s+(\d+) of 1500", page.inner_text("#replay-readout")).group(1))
        assert 0 < shown < 1500
        assert page.get_attribute("#vehicle-ellipse", "d").startswith("M -")


def test_vehicle_stands_where_the_file_says(page):
    """Pixels of the marker, turned back into metres through plotly's own axes, against the replayed moment."""
    move_slider(page, 0.4)
    x_px, y_px = vehicle_place(page)
    x_m, y_m, expected_x, expected_y = page.evaluate(
        """([x, y]) => { const layout = document.getElementById("map")._fullLayout;
        const replay = JSON.parse(document.getElementById("report-data").textContent).replay;
        const moment = Number(document.getElementById("replay-slider").value);
        return [layout.xaxis.p2d(x - layout.xaxis._offset), layout.yaxis.p2d(y - layout.yaxis._offset),
                replay.estimates[0].x[moment], replay.estimates[0].y[moment]]; }""",
        [x_px, y_px],
    )
    assert x_m == pytest.approx(expected_x, abs=0.02)
    assert y_m == pytest.approx(expected_y, abs=0.02)


def test_one_metre_is_as_long_across_as_up(page):
    across, up = page.evaluate(
        """() => ["xaxis", "yaxis"].map(name => { const axis = document.getElementById("map")._fullLayout[name];
        return axis._length / Math.abs(axis.range[1] - axis.range[0]); })"""
    )
    assert across == pytest.approx(up, rel=1e-6)


def test_play_and_pause(page):
    page.select_option("#replay-duration", "15")
    page.click("#replay-play")
    page.wait_for_function("() => Number(document.getElementById('replay-slider').value) > 20")
    assert page.get_attribute("#replay-play", "aria-label") == "Pause"
    page.click("#replay-play")
    stopped = page.input_value("#replay-slider")
    page.wait_for_timeout(300)
    assert page.input_value("#replay-slider") == stopped
    assert int(stopped) < int(page.get_attribute("#replay-slider", "max"))


def test_online_estimate_can_be_replayed(page):
    move_slider(page, 0.5)
    final = vehicle_place(page)
    page.select_option("#replay-estimate", "online")
    assert vehicle_place(page) != final


def test_marks_follow_the_map_when_it_is_enlarged(page):
    before = vehicle_place(page)
    page.evaluate(
        """() => { const map = document.getElementById("map"), x = map._fullLayout.xaxis.range, y = map._fullLayout.yaxis.range;
        return Plotly.relayout(map, {"xaxis.range": [x[0] - 7, x[1] - 7], "yaxis.range": [y[0], y[1]]}); }"""
    )
    page.wait_for_function(
        """before => { const place = document.getElementById("vehicle-marker").getAttribute("transform").match(/[\\d.-]+/)[0];
        return Math.abs(Number(place) - before) > 5; }""",
        arg=before[0],
    )


def test_refused_pairs_are_shown_on_demand_with_their_reason(chromium, full_report):
    with opened(chromium, full_report) as page:
        lines, marks = page.evaluate("JSON.parse(document.getElementById('report-data').textContent).layers.refused")
        assert page.evaluate("index => document.getElementById('map').data[index].visible", marks) is False
        page.click("label:has(input[data-layer=refused])")
        page.wait_for_function("index => document.getElementById('map').data[index].visible === true", arg=marks)
        page.evaluate("index => Plotly.Fx.hover('map', [{curveNumber: index, pointNumber: 0}])", marks)
        page.wait_for_selector("#map .hoverlayer text")
        assert "refused" in page.text_content("#map .hoverlayer")
        assert page.evaluate("index => document.getElementById('map').data[index].visible", lines) is True


def test_row_of_a_submap_leads_to_its_base(page):
    row = page.locator("#submap-table tbody tr").nth(4)
    x, y = float(row.get_attribute("data-x")), float(row.get_attribute("data-y"))
    row.click()
    page.wait_for_function("() => document.getElementById('focus-mark').classList.contains('shown')")
    across, up = page.evaluate(
        "() => ['xaxis', 'yaxis'].map(name => document.getElementById('map')._fullLayout[name].range.reduce((a, b) => a + b) / 2)"
    )
    assert (across, up) == (pytest.approx(x, abs=0.01), pytest.approx(y, abs=0.01))


def test_tables_sort_by_number(page):
    landmarks = "() => [...document.querySelectorAll('#submap-table tbody tr')].map(row => Number(row.cells[3].dataset.v))"
    head = page.locator("#submap-table th").nth(3)
    head.click()
    assert page.evaluate(landmarks) == sorted(page.evaluate(landmarks))
    head.click()
    assert page.evaluate(landmarks) == sorted(page.evaluate(landmarks), reverse=True)
    assert head.get_attribute("aria-sort") == "descending"


def test_print_opens_every_number_and_keeps_the_plots_within_the_paper(page):
    page.evaluate("window.dispatchEvent(new Event('beforeprint'))")
    assert page.evaluate("document.querySelector('details.numbers').open")
    page.emulate_media(media="print")
    page.evaluate("document.body.style.width = '1030px'")  # A4 across without its margins
    widths = page.evaluate("() => [...document.querySelectorAll('.main-svg')].map(svg => svg.getBoundingClientRect().right)")
    page.evaluate("document.body.style.width = ''")
    assert max(widths) <= 1030
    assert page.locator(".replay").is_hidden()
    page.evaluate("window.dispatchEvent(new Event('afterprint'))")
    assert not page.evaluate("document.querySelector('details.numbers').open")


def test_run_with_a_summary_only(chromium, tmp_path):
    (tmp_path / "summary.json").write_text("{}")
    with opened(chromium, build_report(tmp_path)) as page:
        assert page.locator(".missing").count() == 8
        assert page.locator(".js-plotly-plot").count() == 0


def test_hostile_names_stay_text(chromium, tmp_path):
    hostile = "</script><img src=x onerror=alert(1)><b>wreck</b>"
    run_dir = write_synthetic_run(tmp_path / "run", SMALL, mission=hostile)
    summary = json.loads((run_dir / "summary.json").read_text())
    summary["axis_names"] = [f"north {hostile}", hostile]
    (run_dir / "summary.json").write_text(json.dumps(summary))
    document = json.loads((run_dir / "submaps.json").read_text())
    document["submaps"][0]["closed_because"] = hostile
    (run_dir / "submaps.json").write_text(json.dumps(document))
    with opened(chromium, build_report(run_dir)) as page:
        assert page.inner_text("h1") == hostile
        assert page.locator("img").count() == 0
        assert hostile in page.inner_text("#replay-readout")
        assert "<b>wreck</b>" in page.text_content("#map .g-xtitle")
        for name in ("landmarks", "bases"):
            index = page.evaluate(f"JSON.parse(document.getElementById('report-data').textContent).layers.{name}.at(-1)")
            page.evaluate("index => Plotly.Fx.hover('map', [{curveNumber: index, pointNumber: 0}])", index)
        assert page.locator("img").count() == 0


def test_no_button_sends_the_data_away(page):
    titles = page.evaluate("() => [...document.querySelectorAll('.modebar-btn')].map(button => button.dataset.title)")
    assert set(titles) == {"Download plot", "Zoom", "Pan", "Zoom in", "Zoom out", "Reset axes"}
