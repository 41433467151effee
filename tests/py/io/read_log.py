"""A whole log in one piece."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ssjs_cli import _core


@dataclass(frozen=True)
class Log:
    block: dict[str, Any]
    info: dict[str, Any]

    @property
    def pings(self) -> dict[str, Any]:
        return dict(self.block["pings"])

    @property
    def channels(self) -> list[list[dict[str, Any]]]:
        return list(self.block["channels"])

    @property
    def problems(self) -> dict[str, int]:
        return {problem["what"]: problem["count"] for problem in self.info["problems"]}


def read_log(path: Path, **options: str) -> Log:
    log = _core.SonarLog(str(path), **options)
    block = log.read(100000)
    assert block is not None, log.info()
    assert log.read(1) is None
    return Log(block, log.info())
