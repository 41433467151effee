"""What one call of the program shares: where messages go, what is logged, where a fault leaves its traceback."""

import json
import sys
import tempfile
import time
import traceback
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any


@dataclass
class Session:
    """Messages go to stderr, so that stdout holds the answer alone. `records` becomes log.jsonl of a run."""

    json_output: bool = False
    fault_log: Path | None = None
    records: list[dict[str, Any]] = field(default_factory=list)
    started_s: float = field(default_factory=time.perf_counter)

    def log(self, event: str, level: str = "info", **fields: Any) -> None:
        elapsed_s = round(time.perf_counter() - self.started_s, 6)
        self.records.append({"elapsed_s": elapsed_s, "level": level, "event": event, **fields})

    def message(self, text: str) -> None:
        print(text, file=sys.stderr)

    def warn(self, text: str) -> None:
        self.log("warning", level="warning", text=text)
        self.message(f"warning: {text}")

    def answer(self, document: dict[str, Any], text: str) -> None:
        """The answer on stdout: the JSON document where --json asks for it, the text otherwise."""
        print(json.dumps(document, indent=2, allow_nan=False) if self.json_output else text)

    def log_lines(self) -> str:
        return "".join(json.dumps(record) + "\n" for record in self.records)

    def write_fault(self, error: BaseException) -> Path | None:
        """The log so far and the traceback, in a file beside the output or, without one, in the system's temporary directory.
        None where neither can be written."""
        self.log("fault", level="error", traceback="".join(traceback.format_exception(error)))
        candidates = [self.fault_log] if self.fault_log is not None else []
        candidates.append(Path(tempfile.gettempdir()) / "ssjs-cli-fault.log.jsonl")
        for path in candidates:
            try:
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(self.log_lines(), encoding="utf-8")
            except OSError:
                continue
            return path
        return None
