import json
from collections.abc import Callable
from pathlib import Path
from typing import Any


def test_the_report_is_rebuilt_from_the_files(cli: Callable[..., Any], circle_mission: Path, tmp_path: Path) -> None:
    run = tmp_path / "run"
    assert cli("run", circle_mission, "--out", run, "--no-report").code == 0
    answer = cli("report", run)
    assert answer.code == 0, answer.err
    assert answer.out.strip() == str(run / "report.html")
    first = (run / "report.html").read_bytes()
    answer = cli("report", run, "--json")
    assert json.loads(answer.out) == {"report": str(run / "report.html")}
    assert (run / "report.html").read_bytes() == first
    answer = cli("report", run, "--out", tmp_path / "page.html")
    assert answer.code == 0
    assert (tmp_path / "page.html").read_bytes() == first
    assert cli("report", run, "--out", tmp_path / "page.html").code == 2


def test_a_directory_that_is_no_run_is_the_users_error(cli: Callable[..., Any], tmp_path: Path) -> None:
    answer = cli("report", tmp_path / "nowhere")
    assert answer.code == 2
    assert "nowhere: is no run directory" in answer.err


def test_a_damaged_summary_is_the_users_error(cli: Callable[..., Any], tmp_path: Path) -> None:
    (tmp_path / "summary.json").write_text("{")
    answer = cli("report", tmp_path)
    assert answer.code == 2
    assert "summary.json" in answer.err
