"""Times of single steps over repeated runs, and what they are measured on."""

import os
import platform
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray


def steady_step_times(rounds: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Every step's median over the rounds, (steps,): what other processes took from one round is gone."""
    return np.median(np.stack(rounds), axis=0)


def quantile_text(step_time_us: NDArray[np.float64]) -> str:
    p50, p99, highest = np.percentile(step_time_us, [50.0, 99.0, 100.0])
    return f"p50 {p50:.1f} us, p99 {p99:.0f} us, max {highest:.0f} us"


def data_directory() -> Path:
    """The directory that holds the public data sets."""
    path = os.environ.get("SSJS_DATA")
    if not path:
        raise SystemExit("SSJS_DATA is not set: name the directory that holds the data sets")
    return Path(path)


def machine_text() -> str:
    model = platform.processor() or platform.machine()
    for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
        if line.startswith("model name"):
            model = line.split(":", 1)[1].strip()
            break
    return f"{model}, {os.cpu_count()} cores, {platform.platform()}, Python {platform.python_version()}"
