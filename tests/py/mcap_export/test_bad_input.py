"""What `export mcap` refuses, and what it leaves out aloud."""

import json
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from exported_survey import Survey, read_recording


def test_a_moved_mission_is_said_and_can_be_named(survey: Survey, cli: Callable[..., Any], tmp_path: Path) -> None:
    run, mission = tmp_path / "run", tmp_path / "elsewhere" / "mission"
    shutil.copytree(survey.run, run)
    answer = cli("export", "mcap", run, "--json")
    assert answer.code == 3
    assert "--mission" in json.loads(answer.out)["lost"][0]
    recording = read_recording(tmp_path / "run.mcap")
    assert "/sonar" not in recording.messages and "/position" not in recording.messages
    assert len(recording.messages["/contacts"]) == len(survey.recording.messages["/contacts"])

    shutil.copytree(survey.mission, mission)
    assert cli("export", "mcap", run, "--mission", mission, "--force").code == 0
    assert (tmp_path / "run.mcap").read_bytes() == survey.recording_path.read_bytes()


def test_another_mission_than_the_one_that_was_run_is_not_mixed_in(survey: Survey, cli: Callable[..., Any], tmp_path: Path) -> None:
    shutil.copytree(survey.run, tmp_path / "run")
    shutil.copytree(survey.mission, tmp_path / "mission")
    with (tmp_path / "mission" / "depth.csv").open("a") as file:
        file.write("1867225600.0,1.0\n")
    answer = cli("export", "mcap", tmp_path / "run")
    assert answer.code == 3 and "depth.csv" in answer.err and "/sensors/depth" not in answer.out
    answer = cli("export", "mcap", tmp_path / "run", "--mission", tmp_path / "mission", "--force")
    assert answer.code == 2 and "depth.csv" in answer.err and "--mission" in answer.err


def test_nothing_is_overwritten_without_force(survey: Survey, cli: Callable[..., Any], tmp_path: Path) -> None:
    target = tmp_path / "a.mcap"
    target.write_text("mine")
    answer = cli("export", "mcap", survey.run, "--out", target)
    assert answer.code == 2 and "--force" in answer.err and target.read_text() == "mine"


@pytest.mark.parametrize("name", ["a.bag", "a", "folder.mcap"])
def test_a_target_that_is_no_mcap_file(survey: Survey, cli: Callable[..., Any], tmp_path: Path, name: str) -> None:
    (tmp_path / "folder.mcap").mkdir()
    answer = cli("export", "mcap", survey.run, "--out", tmp_path / name)
    assert answer.code == 2 and ".mcap" in answer.err
    assert [path.name for path in tmp_path.iterdir()] == ["folder.mcap"]


def test_a_folder_that_is_no_run(cli: Callable[..., Any], tmp_path: Path) -> None:
    answer = cli("export", "mcap", tmp_path, "--out", tmp_path / "a.mcap")
    assert answer.code == 2 and "summary.json" in answer.err


def test_without_the_package_the_extra_is_named(
    survey: Survey, cli: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "mcap.writer", None)
    answer = cli("export", "mcap", survey.run, "--out", tmp_path / "a.mcap")
    assert answer.code == 2 and "pip install 'ssjs[mcap]'" in answer.err


def _cut(path: Path) -> None:
    path.write_text("\n".join(path.read_text().splitlines()[:-3]) + "\n")


def _early(path: Path) -> None:
    path.write_text("-5.0 " + path.read_text().split(" ", 1)[1])


def _replaced(old: str, new: str) -> Callable[[Path], None]:
    def change(path: Path) -> None:
        text = path.read_text()
        assert old in text
        path.write_text(text.replace(old, new, 1))

    return change


@pytest.mark.parametrize(
    ("name", "damage", "said"),
    [
        ("dead_reckoning.tum", _cut, "dead_reckoning.tum"),
        ("trajectory_online.tum", _cut, "trajectory_online.tum"),
        ("trajectory_covariance.csv", _cut, "trajectory_covariance.csv"),
        ("trajectory.tum", lambda path: path.write_text(""), "trajectory.tum"),
        ("trajectory.tum", lambda path: path.write_bytes(b"\xff\xfe"), "trajectory.tum:1"),
        ("trajectory.tum", lambda path: path.unlink(), "trajectory.tum"),
        ("landmarks.csv", _replaced("times_seen", "seen"), "landmarks.csv:1"),
        ("consistency.csv", _replaced(",4", ",four"), "consistency.csv"),
        ("submaps.json", lambda path: path.write_text("{}"), "submaps.json"),
        ("submaps.json", _replaced('"base_pose": [', '"base_pose": [[],'), "submaps.json"),
        ("submaps.json", _replaced('"pairs": ', '"pairs": null, "x": '), "submaps.json"),
        ("contacts.csv", _replaced(",port,", ",port,x"), "contacts.csv:"),
        ("trajectory.tum", _early, "-5.0"),
    ],
)
def test_damaged_result_files_are_named(
    survey: Survey, cli: Callable[..., Any], tmp_path: Path, name: str, damage: Callable[[Path], object], said: str
) -> None:
    run = tmp_path / "run"
    shutil.copytree(survey.run, run)
    damage(run / name)
    answer = cli("export", "mcap", run, "--mission", survey.mission)
    assert answer.code == 2, answer.err
    assert said in answer.err
    assert [path.name for path in tmp_path.iterdir()] == ["run"]
