import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

LIMIT_S = 60.0


def test_the_demo_runs_the_whole_chain(cli: Callable[..., Any], tmp_path: Path) -> None:
    started = time.perf_counter()
    answer = cli("demo", "--out", tmp_path / "demo", "--json")
    spent_s = time.perf_counter() - started
    assert answer.code == 0, answer.err
    document = json.loads(answer.out)
    assert document["report"] == str(tmp_path / "demo" / "report.html")
    assert (tmp_path / "demo" / "report.html").stat().st_size > 0
    assert (tmp_path / "demo-mission" / "mission.toml").is_file()
    assert document["mission"] == "grid-survey"
    assert document["trajectory_rmse_m"] < document["dead_reckoning_rmse_m"]
    assert spent_s < LIMIT_S
    assert cli("demo", "--out", tmp_path / "demo").code == 2
