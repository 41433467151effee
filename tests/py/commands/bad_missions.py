"""A minute of a simulated survey, ways to spoil its files, and what a refusal must look like."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

SENSOR_FILES = ("imu.csv", "dvl.csv", "depth.csv", "altitude.csv")
TIMED_FILES = (*SENSOR_FILES, "observations.csv")
KEPT_S = 60.0

Spoil = Callable[[Path], object]


def shorten(mission: Path, keep_s: float = KEPT_S) -> None:
    """The first part of every sensor's file; no truth."""
    first_s = float((mission / "imu.csv").read_text().split("\n", 2)[1].split(",")[0])
    for name in TIMED_FILES:
        if (mission / name).is_file():
            header, *lines = (mission / name).read_text().splitlines()
            kept = [line for line in lines if float(line.split(",")[0]) < first_s + keep_s]
            (mission / name).write_text("\n".join([header, *kept]) + "\n")
    for name in ("truth_trajectory.tum", "truth_landmarks.csv"):
        (mission / name).unlink(missing_ok=True)


def column(name: str, heading: str, change: Callable[[str], str], rows: slice | None = None) -> Spoil:
    """The fields of a column, in all rows or in some."""

    def spoil(mission: Path) -> None:
        path = mission / name
        header, *lines = path.read_text().splitlines()
        position = header.split(",").index(heading)
        chosen = range(len(lines))[slice(None) if rows is None else rows]
        assert len(chosen)
        for row in chosen:
            fields = lines[row].split(",")
            fields[position] = change(fields[position])
            lines[row] = ",".join(fields)
        path.write_text("\n".join([header, *lines]) + "\n")

    return spoil


def written(name: str, content: str | bytes) -> Spoil:
    return lambda mission: (mission / name).write_bytes(content.encode() if isinstance(content, str) else content)


def directory_instead(name: str) -> Spoil:
    def spoil(mission: Path) -> None:
        (mission / name).unlink(missing_ok=True)
        (mission / name).mkdir()

    return spoil


def all_of(*steps: Spoil) -> Spoil:
    def spoil(mission: Path) -> None:
        for step in steps:
            step(mission)

    return spoil


def run_spoiled(cli: Callable[..., Any], base: Path, folder: Path, spoil: Spoil) -> Any:
    """The answer of `run`; nothing but the mission and a whole result may be left in the folder."""
    mission, out = folder / "mission", folder / "run"
    shutil.copytree(base, mission)
    spoil(mission)
    answer = cli("run", mission, "--out", out, "--no-report")
    left = {path.name for path in folder.iterdir()}
    assert answer.code in (0, 2, 3), answer.err
    assert "internal fault" not in answer.err and "Traceback" not in answer.err
    assert left == ({"mission"} if answer.code == 2 else {"mission", "run"})
    if answer.code != 2:
        json.loads((out / "summary.json").read_text(), parse_constant=_refuse)
    return answer


def _refuse(constant: str) -> None:
    raise AssertionError(f"{constant} in summary.json")
