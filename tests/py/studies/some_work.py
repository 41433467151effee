"""Functions that tests hand to workers."""

import os
import signal
import sys
import time
from pathlib import Path
from typing import Any

from ssjs_cli.errors import UserError


def square(payload: dict[str, Any]) -> dict[str, Any]:
    time.sleep(payload.get("pause_s", 0.0))
    return {"square": payload["number"] ** 2, "process": os.getpid()}


def misbehave(payload: dict[str, Any]) -> dict[str, Any]:
    """As told by payload["how"]; anything else is squared."""
    how = payload.get("how")
    if how == "refuse":
        raise UserError("this input is no good; give another")
    if how == "fault":
        raise RuntimeError("a fault of ours\nsecond line")
    if how == "memory":
        raise MemoryError
    if how == "kill":
        os.kill(os.getpid(), signal.SIGKILL)
    if how == "exit":
        sys.exit(7)
    if how == "kill once":
        mark = Path(payload["mark"])
        if not mark.exists():
            mark.touch()
            os.kill(os.getpid(), signal.SIGKILL)
    return square(payload)


def threads(payload: dict[str, Any]) -> dict[str, Any]:
    return {"OPENBLAS_NUM_THREADS": os.environ.get("OPENBLAS_NUM_THREADS"), "OMP_NUM_THREADS": os.environ.get("OMP_NUM_THREADS")}
