"""The page as text: what it holds, what it must not hold."""

import json
import re
import shutil

import pytest
from plotly.graph_objects import Figure
from synthetic_run import SMALL, write_synthetic_run

from ssjs_cli.report import build_report
from ssjs_cli.report.page import FIGURE_IDS

MAX_BYTES = 12_000_000


def embedded(page):
    return json.loads(re.search(r'<script type="application/json" id="report-data">(.*?)</script>', page, re.DOTALL).group(1))


def without_scripts(page):
    return re.sub(r"<(script|style)\b.*?</\1>", "", page, flags=re.DOTALL)


def test_long_mission_stays_below_the_size_limit_and_holds_every_figure(full_run):
    report = build_report(full_run)
    assert report == full_run / "report.html"
    assert report.stat().st_size < MAX_BYTES
    page = report.read_text(encoding="utf-8")
    figures = embedded(page)["figures"]
    assert tuple(figures) == tuple(sorted(FIGURE_IDS))
    for name, figure in figures.items():
        Figure(figure)
        assert page.count(f'<div id="{name}" class="plot"') == 1
    assert page.count("plotly.js v") == 1


def test_same_files_give_the_same_bytes_wherever_they_lie(small_run, tmp_path):
    elsewhere = tmp_path / "another" / "place"
    shutil.copytree(small_run, elsewhere)
    first = build_report(small_run).read_bytes()
    assert build_report(elsewhere).read_bytes() == first
    assert build_report(small_run).read_bytes() == first
    assert str(tmp_path).encode() not in first
    assert sorted(path.name for path in elsewhere.iterdir() if "report" in path.name) == ["report.html"]


def test_page_asks_for_nothing_from_outside(small_run):
    markup = without_scripts(build_report(small_run).read_text(encoding="utf-8"))
    assert not re.search(r"""(src|href|action)\s*=\s*["'](?!#|data:,)""", markup)
    assert "default-src 'none'" in markup


def test_every_axis_has_a_unit(full_run):
    for figure in embedded(build_report(full_run).read_text(encoding="utf-8"))["figures"].values():
        for name, axis in figure["layout"].items():
            if re.fullmatch(r"[xy]axis\d*", name):
                assert re.search(r"\[.+\]", axis["title"]["text"]), axis["title"]["text"]


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("errors.csv", "errors.csv is missing: this mission has no reference"),
        ("errors_online.csv", "errors_online.csv is missing: only the final estimate is drawn."),
        ("nees.csv", "nees.csv is missing: NEES needs the true trajectory"),
        ("consistency.csv", "consistency.csv is missing, so there is no NIS to draw."),
        ("step_times.csv", "step_times.csv is missing, so the time of single steps is not known."),
        ("submaps.json", "submaps.json is missing, so the submaps are not known."),
        ("config.toml", "config.toml is missing, so the settings of this run are not known."),
        ("reference.csv", "Not in the run directory: reference (reference.csv)."),
        ("dead_reckoning.tum", "Not in the run directory: dead reckoning (dead_reckoning.tum)."),
    ],
)
def test_missing_file_is_named_in_its_place(small_run, name, sentence):
    assert sentence not in build_report(small_run).read_text(encoding="utf-8")
    (small_run / name).unlink()
    assert sentence in build_report(small_run).read_text(encoding="utf-8")


@pytest.mark.parametrize("name", ["trajectory_covariance.csv", "trajectory_online_covariance.csv", "trajectory_submaps.csv", "timing.json"])
def test_page_does_without_the_other_files(small_run, name):
    (small_run / name).unlink()
    assert embedded(build_report(small_run).read_text(encoding="utf-8"))["replay"] is not None


def test_without_reference_the_cards_say_so(tmp_path):
    run_dir = write_synthetic_run(tmp_path / "run", SMALL, reference=False)
    page = without_scripts(build_report(run_dir).read_text(encoding="utf-8"))
    assert page.count('<p class="value">no reference</p>') == 3


def test_text_from_files_is_escaped(tmp_path):
    hostile = "<script>alert(1)</script>\"'&</title>"
    run_dir = write_synthetic_run(tmp_path / "run", SMALL, mission=hostile)
    document = json.loads((run_dir / "submaps.json").read_text())
    document["submaps"][0]["closed_because"] = hostile
    document["loops"] = [{"time_s": 1.0, "from": 1, "to": 0, "accepted": False, "reason": hostile, "pairs": 0}]
    (run_dir / "submaps.json").write_text(json.dumps(document))
    summary = json.loads((run_dir / "summary.json").read_text())
    summary.update(description=hostile, method=hostile, axis_names=[hostile, hostile], alignment=hostile, input_digests={hostile: hostile})
    (run_dir / "summary.json").write_text(json.dumps(summary))
    (run_dir / "config.toml").write_text(f"[{json.dumps(hostile)}]\n{json.dumps(hostile)} = {json.dumps(hostile)}\n")
    page = build_report(run_dir).read_text(encoding="utf-8")
    assert "<script>alert" not in page
    assert without_scripts(page).count("</title>") == 1
    refused = next(trace for trace in embedded(page)["figures"]["map"]["data"] if "refused" in (trace.get("text") or [""])[0])
    assert "&lt;script&gt;alert(1)&lt;/script&gt;" in refused["text"][0]
