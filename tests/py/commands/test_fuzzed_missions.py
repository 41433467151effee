"""Files of an underwater mission spoiled at random: an answer or a refusal, never a fault of ours, and nothing half done."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bad_missions import TIMED_FILES, run_spoiled, shorten

ROUNDS = 6
SPOILS_PER_ROUND = 20
CELLS = ("", "nan", "-inf", "1e308", "-1e308", "1e-320", "0", "-0", "-1", "1e9", "1e200", "3.2", "9" * 400, "x", "1;2", '"1"', " 1 ", "0x1")


@pytest.fixture(scope="module")
def base(tmp_path_factory: pytest.TempPathFactory) -> Path:
    from ssjs_cli.app import call

    directory = tmp_path_factory.mktemp("base") / "mission"
    assert call(["simulate", "auv-survey", "--out", str(directory)]) == 0
    shorten(directory, 12.0)
    return directory


def spoil_cells(data: bytes, rng: np.random.Generator) -> bytes:
    lines = [line.split(",") for line in data.decode().splitlines()]
    for _ in range(int(rng.integers(1, 4))):
        row = int(rng.integers(len(lines)))
        lines[row][int(rng.integers(len(lines[row])))] = str(rng.choice(CELLS))
    return "\n".join(",".join(line) for line in lines).encode() + b"\n"


def spoil_lines(data: bytes, rng: np.random.Generator) -> bytes:
    lines = data.split(b"\n")
    first, second = (int(index) for index in rng.integers(len(lines), size=2))
    match int(rng.integers(4)):
        case 0:
            lines[first], lines[second] = lines[second], lines[first]
        case 1:
            del lines[min(first, second) : max(first, second)]
        case 2:
            lines.insert(first, lines[second])
        case _:
            lines = lines[:1] + [b",".join(part for index, part in enumerate(line.split(b",")) if index != first % 3) for line in lines[1:]]
    return b"\n".join(lines)


def spoil_bytes(data: bytes, rng: np.random.Generator) -> bytes:
    spoiled = bytearray(data)
    for _ in range(int(rng.integers(1, 6))):
        spoiled[int(rng.integers(len(spoiled)))] = int(rng.integers(256))
    return bytes(spoiled)


def cut(data: bytes, rng: np.random.Generator) -> bytes:
    return data[: int(rng.integers(len(data)))]


def scale_column(data: bytes, rng: np.random.Generator) -> bytes:
    header, *lines = data.decode().splitlines()
    position, factor = int(rng.integers(len(header.split(",")))), 10.0 ** float(rng.integers(-12, 20))
    rows = [line.split(",") for line in lines]
    for fields in rows:
        fields[position] = repr(float(fields[position] or 0.0) * factor)
    return "\n".join([header, *(",".join(fields) for fields in rows)]).encode() + b"\n"


SPOILS = (spoil_cells, spoil_lines, spoil_bytes, cut, scale_column)


@pytest.mark.parametrize("seed", range(ROUNDS))
def test_spoiled_files_never_end_in_a_fault(base: Path, cli: Callable[..., Any], tmp_path: Path, seed: int) -> None:
    rng = np.random.default_rng(seed)
    refused = 0
    for number in range(SPOILS_PER_ROUND):
        name = str(rng.choice((*TIMED_FILES, "mission.toml")))
        spoil = spoil_bytes if name == "mission.toml" else SPOILS[int(rng.integers(len(SPOILS)))]
        folder = tmp_path / str(number)
        folder.mkdir()

        def change(mission: Path, name: str = name, spoil: Callable[[bytes, np.random.Generator], bytes] = spoil) -> None:
            (mission / name).write_bytes(spoil((mission / name).read_bytes(), rng))

        answer = run_spoiled(cli, base, folder, change)
        if answer.code == 2:
            refused += 1
            assert str(folder / "mission") in answer.err or "estimator refused the mission" in answer.err, answer.err
    assert refused > 0
