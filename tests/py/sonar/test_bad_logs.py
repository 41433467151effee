"""Sonar logs of a mission that are gone, are none, or do not belong to its navigation."""

import gzip
import os
import re
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "commands"))

from bad_missions import SENSOR_FILES, Spoil, all_of, column, run_spoiled, shorten, written

HEADER_BYTES = 1024
PINGS = 400
LOG = "pings/survey.xtf"


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    from ssjs_cli.app import call

    directory = tmp_path_factory.mktemp("whole") / "mission"
    assert call(["simulate", "side-scan-survey", "--out", str(directory)]) == 0
    shorten(directory)
    return directory


@pytest.fixture(scope="module")
def part_of_log(whole: Path) -> Callable[[int, int], bytes]:
    """The header of the log and some of its pings, which are all of one size."""
    from ssjs_cli.sonar.info import describe

    log = (whole / LOG).read_bytes()
    size, rest = divmod(len(log) - HEADER_BYTES, describe(whole / LOG)["pings"])
    assert rest == 0
    return lambda first, last: log[:HEADER_BYTES] + log[HEADER_BYTES + first * size : HEADER_BYTES + last * size]


@pytest.fixture(scope="module")
def base(whole: Path, part_of_log: Callable[[int, int], bytes]) -> Path:
    directory = whole.with_name("base")
    shutil.copytree(whole, directory)
    (directory / LOG).write_bytes(part_of_log(0, PINGS))
    return directory


def without_log(mission: Path) -> None:
    (mission / LOG).unlink()


def without_pings_folder(mission: Path) -> None:
    shutil.rmtree(mission / "pings")
    with (mission / "mission.toml").open("a") as file:
        file.write('\n[import]\nformat = "xtf"\n')


CASES: list[tuple[str, Spoil, str]] = [
    ("missing", without_log, r"pings: holds no sonar log; put it back"),
    ("missing with its folder", without_pings_folder, r"pings: holds no sonar log; put it back"),
    (
        "renamed",
        lambda mission: (mission / LOG).rename(mission / "pings/survey.dat"),
        r"holds no sonar log \(survey\.dat\); .*\.xtf or \.jsf",
    ),
    ("empty", written(LOG, b""), r"survey\.xtf: is empty; copy it"),
    ("text", written(LOG, "time,x\n1,2\n"), r"survey\.xtf: is neither an XTF nor a JSF log"),
    ("zeros after the mark", written(LOG, b"\x7b" + bytes(100_000)), r"survey\.xtf: holds no side-scan ping"),
    ("a directory", all_of(without_log, lambda mission: (mission / LOG).mkdir()), r"survey\.xtf: is a directory where a file is wanted"),
    ("a link to nothing", all_of(without_log, lambda mission: (mission / LOG).symlink_to("nowhere")), r"survey\.xtf: is a link to nothing"),
    (
        "another day",
        all_of(*(column(name, "time_s", lambda text: repr(float(text) + 86400.0)) for name in SENSOR_FILES)),
        r"survey\.xtf: its pings, .* and imu\.csv, .* have no time in common; bring both on one clock",
    ),
    ("twice", lambda mission: shutil.copyfile(mission / LOG, mission / "pings/again.xtf"), r"\.xtf: .* s of it are also in .*; keep one"),
]


@pytest.mark.parametrize(("spoil", "said"), [case[1:] for case in CASES], ids=[case[0] for case in CASES])
def test_a_log_that_cannot_be_used_is_named(base: Path, cli: Callable[..., Any], tmp_path: Path, spoil: Spoil, said: str) -> None:
    answer = run_spoiled(cli, base, tmp_path, spoil)
    assert answer.code == 2
    assert re.search(said, answer.err), answer.err


def test_a_log_under_the_name_of_the_other_format_is_read(base: Path, cli: Callable[..., Any], tmp_path: Path) -> None:
    assert run_spoiled(cli, base, tmp_path, lambda mission: (mission / LOG).rename(mission / "pings/survey.jsf")).code == 0


def test_parts_of_a_log_are_compressed_cut_or_without_pings(
    base: Path, part_of_log: Callable[[int, int], bytes], cli: Callable[..., Any], tmp_path: Path
) -> None:
    for number, (content, said) in enumerate(
        [
            (gzip.compress(part_of_log(0, 50)), "is neither an XTF nor a JSF log"),
            (part_of_log(0, 0), "holds no side-scan ping"),
            (part_of_log(0, 0)[:500], "holds no side-scan ping"),
        ]
    ):
        (tmp_path / str(number)).mkdir()
        answer = run_spoiled(cli, base, tmp_path / str(number), written(LOG, content))
        assert answer.code == 2 and f"survey.xtf: {said}" in answer.err


def test_a_cut_log_is_used_as_far_as_it_goes(
    base: Path, part_of_log: Callable[[int, int], bytes], cli: Callable[..., Any], tmp_path: Path
) -> None:
    answer = run_spoiled(cli, base, tmp_path, written(LOG, part_of_log(0, PINGS)[:-100]))
    assert answer.code == 3 and "survey.xtf: lost: the log ends within a packet" in answer.err


def test_logs_that_follow_each_other_are_one_survey(
    base: Path, part_of_log: Callable[[int, int], bytes], cli: Callable[..., Any], tmp_path: Path
) -> None:
    halves = all_of(written(LOG, part_of_log(0, 200)), written("pings/second.xtf", part_of_log(200, PINGS)))
    assert run_spoiled(cli, base, tmp_path, halves).code == 0
    (tmp_path / "again").mkdir()
    overlapping = all_of(written(LOG, part_of_log(0, 200)), written("pings/second.xtf", part_of_log(150, PINGS)))
    answer = run_spoiled(cli, base, tmp_path / "again", overlapping)
    assert answer.code == 2 and "second.xtf: " in answer.err and "also in survey.xtf" in answer.err


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="the superuser may read every file")
def test_a_log_that_may_not_be_read(base: Path, cli: Callable[..., Any], tmp_path: Path) -> None:
    answer = run_spoiled(cli, base, tmp_path, lambda mission: (mission / LOG).chmod(0))
    assert answer.code == 2 and "survey.xtf: cannot be opened" in answer.err
