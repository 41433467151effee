"""The report of a sonar survey: its sections, with the numbers of the run's files."""

import json
import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from synthetic_run import SMALL, write_synthetic_run
from synthetic_survey import DEPTH_M, OBJECTS, SEABED_M, write_synthetic_survey

from ssjs_cli.formats.number_table import FloatArray
from ssjs_cli.formats.tum import read_tum
from ssjs_cli.report import build_report

SECTIONS = ("views-section", "contacts-section", "sonar-section", "depth-section", "uncertainty-section")
PLOTS = ("space-view", "top-view", "side-view", "coverage", "depth-profile", "uncertainty")


def page(run_dir: Path) -> str:
    return build_report(run_dir).read_text(encoding="utf-8")


def figures(text: str) -> dict[str, Any]:
    data = re.search(r'<script type="application/json" id="report-data">(.*?)</script>', text, re.DOTALL)
    assert data is not None
    answer: dict[str, Any] = json.loads(data.group(1))["figures"]
    return answer


def trace(figure: dict[str, Any], name: str) -> dict[str, Any]:
    return next(entry for entry in figure["data"] if entry.get("name") == name)


def values(entry: dict[str, Any], key: str) -> FloatArray:
    return np.array([value for value in entry[key] if value is not None], dtype=np.float64)


@pytest.fixture(scope="module")
def survey(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_synthetic_survey(tmp_path_factory.mktemp("survey") / "run")


@pytest.fixture(scope="module")
def text(survey: Path) -> str:
    return page(survey)


def test_every_section_is_there_and_linked(text: str) -> None:
    for section in SECTIONS:
        assert f'<section id="{section}">' in text
        assert f'href="#{section}"' in text
    assert set(PLOTS) <= set(figures(text))


def test_the_page_fetches_nothing_and_is_bounded(survey: Path, text: str) -> None:
    assert not re.search(r'(?:src|href)="(?!data:|#)', text)
    assert (survey / "report.html").stat().st_size < 15e6


def test_depth_grows_downwards_and_the_seabed_lies_under_the_vehicle(text: str) -> None:
    for name in ("depth-profile", "side-view"):
        deep, shallow = figures(text)[name]["layout"]["yaxis"]["range"]
        assert deep > SEABED_M and shallow <= 0.0
    profile = figures(text)["depth-profile"]
    assert set(values(trace(profile, "vehicle"), "y")) == {DEPTH_M}
    assert set(values(trace(profile, "seabed"), "y")) == {SEABED_M}
    assert set(values(trace(profile, "altitude"), "y")) == {SEABED_M - DEPTH_M}


def test_the_views_show_each_submap_in_its_colour(survey: Path, text: str) -> None:
    track = read_tum(survey / "trajectory.tum")
    lines = [entry for entry in figures(text)["space-view"]["data"] if entry["mode"] == "lines"]
    assert len({entry["line"]["color"] for entry in lines}) == 2
    drawn = np.concatenate([values(entry, "x") for entry in lines])
    assert drawn.max() == pytest.approx(track.pose[:, 1].max())  # east is drawn across
    marks = [entry for entry in figures(text)["space-view"]["data"] if entry["mode"] == "markers"]
    assert len(marks[0]["x"]) == len(OBJECTS)


def test_each_loop_has_the_sigma_before_and_after_it(text: str) -> None:
    ties = trace(figures(text)["uncertainty"], "loop closure: before to after")
    assert values(ties, "y").tolist() == [0.8, 0.3]
    assert set(values(ties, "x")) == {110.0}
    table = re.search(r'<table id="closing-table".*?</table>', text, re.DOTALL)
    assert table is not None and ">0.800<" in table.group(0) and ">0.300<" in table.group(0) and ">38<" in table.group(0)
    assert table.group(0).count("<tr") == 2  # heading and one: the refused pair changes nothing


def test_the_contact_sheet_has_a_card_a_picture_and_the_place(survey: Path, text: str) -> None:
    cards = re.findall(r'<figure class="contact-card" id="contact-(\d+)">(.*?)</figure>', text, re.DOTALL)
    assert [number for number, _ in cards] == ["0", "1"]  # most often seen first; two objects lie beyond the swath
    first = cards[0][1]
    for expected in ("2.0 × 1.0 m", "0.5 m", "0.20 × 0.10 m", "0.90", "3 ×", "10.0 m starboard"):
        assert expected in first
    assert "41.700360° N" in first  # 40 m north
    assert first.count("data:image/jpeg;base64,") == 2
    assert (survey / "snippets" / "contact-0000.png").is_file() and (survey / "snippets" / "contact-0000-strip.png").is_file()
    table = re.search(r'<table id="contact-table".*?</table>', text, re.DOTALL)
    assert table is not None and table.group(0).count("<tr") == 1 + len(OBJECTS)


def test_the_waterfall_marks_what_was_detected(text: str) -> None:
    figure = re.search(r'<figure class="plot-card waterfall".*?</figure>', text, re.DOTALL)
    assert figure is not None
    assert figure.group(0).count('class="sighting"') == 2
    assert figure.group(0).count('class="clutter"') == 1
    ring = re.search(r'class="sighting" cx="([\d.]+)" cy="([\d.]+)"', figure.group(0))
    assert ring is not None
    # 40.5 pings of 221 along 1200, 10 m to starboard of 28 m on either side along 180
    assert float(ring.group(1)) == pytest.approx(40.5 * 1200 / 221, abs=0.1)
    assert float(ring.group(2)) == pytest.approx(38.0 * 180 / 56, abs=0.5)


def test_the_area_stands_in_the_headline_and_under_the_figure(survey: Path, text: str) -> None:
    summary = json.loads((survey / "summary.json").read_text())
    hectares = f"{summary['coverage_area_m2'] / 1e4:.3g} ha"
    percent = f"{100 * summary['coverage_fraction']:.1f} %"
    assert f'<p class="value">{summary["coverage_area_m2"]:,.0f} m²</p>' in text or f'<p class="value">{hectares}</p>' in text
    assert text.count(percent) >= 2
    assert figures(text)["coverage"]["layout"]["images"][0]["source"].startswith("data:image/png")


def test_sensors_are_listed_with_what_their_gates_refused(text: str) -> None:
    table = re.search(r'<table id="sensor-table".*?</table>', text, re.DOTALL)
    assert table is not None
    for expected in ("compass", ">950<", ">50<", ">5.00<", ">0.980<", "side scan", ">1.310<"):
        assert expected in table.group(0)


def test_the_map_has_degrees_where_the_mission_has_a_place_on_earth(text: str, tmp_path: Path) -> None:
    layout = figures(text)["map"]["layout"]
    assert layout["xaxis2"]["range"][0] < 3.0 < layout["xaxis2"]["range"][1]
    assert layout["yaxis2"]["range"][0] < 41.7 < layout["yaxis2"]["range"][1]
    metres_per_degree = (layout["yaxis"]["range"][1] - layout["yaxis"]["range"][0]) / (
        layout["yaxis2"]["range"][1] - layout["yaxis2"]["range"][0]
    )
    assert metres_per_degree == pytest.approx(111_080, rel=1e-3)  # a degree of latitude of WGS 84 at 41.7 degrees
    bare = figures(page(write_synthetic_survey(tmp_path / "run", origin=None)))["map"]["layout"]
    assert "xaxis2" not in bare


def test_times_of_a_calendar_clock_count_from_the_start(tmp_path: Path) -> None:
    text = page(write_synthetic_survey(tmp_path / "run", clock_s=1.7e9))
    assert values(trace(figures(text)["depth-profile"], "altitude"), "x").max() == pytest.approx(220.0)
    assert set(values(trace(figures(text)["uncertainty"], "loop closure: before to after"), "x")) == {110.0}
    assert "t = 40.0 s" in text


def test_the_labels_say_what_is_shown(text: str) -> None:
    assert "NIS of the updates, all sensors together" in text
    assert "NIS of the scan updates" not in text
    assert re.search(r'title="time_association_s">association</th><td class="absent">not measured', text)


@pytest.mark.parametrize(
    "name", ["contacts.csv", "snippets", "waterfall", "coverage.npz", "altitude.csv", "sightings.csv", "landmarks.csv"]
)
def test_what_is_missing_is_left_out(survey: Path, tmp_path: Path, name: str) -> None:
    run_dir = tmp_path / "run"
    shutil.copytree(survey, run_dir)
    shutil.rmtree(run_dir / name) if (run_dir / name).is_dir() else (run_dir / name).unlink()
    text = page(run_dir)
    gone = {
        "contacts.csv": 'id="contacts-section"', "snippets": 'class="contact-card"', "waterfall": 'class="sonar-picture',
        "coverage.npz": 'id="coverage"', "altitude.csv": '"seabed"', "sightings.csv": 'class="sighting"', "landmarks.csv": '"contacts"',
    }[name]  # fmt: skip
    assert gone not in text
    assert 'id="depth-section"' in text


def test_a_mission_without_sonar_has_depth_and_no_pictures(tmp_path: Path) -> None:
    text = page(write_synthetic_survey(tmp_path / "run", sonar=False))
    for section in ("views-section", "depth-section", "uncertainty-section"):
        assert f'id="{section}"' in text
    for section in ("contacts-section", "sonar-section"):
        assert section not in text


def test_a_vehicle_in_the_plane_has_none_of_it(tmp_path: Path) -> None:
    text = page(write_synthetic_run(tmp_path / "run", SMALL))
    for section in SECTIONS:
        assert section not in text
    assert "sensor-table" not in text


def test_a_picture_outside_the_folder_is_not_read(survey: Path, tmp_path: Path) -> None:
    run_dir = tmp_path / "run"
    shutil.copytree(survey, run_dir)
    shutil.copy(run_dir / "snippets" / "contact-0000.png", tmp_path / "other.png")
    contacts = (run_dir / "contacts.csv").read_text().replace("snippets/contact-0000.png", "../../other.png")
    (run_dir / "contacts.csv").write_text(contacts)
    assert 'id="contact-0"' not in page(run_dir)
