"""Progress on stderr for work that takes longer than a second, and a clean stop on Ctrl-C."""

from __future__ import annotations

import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import TYPE_CHECKING

from ssjs_cli.errors import InterruptionError

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

QUIET_S = 1.0
MIN_INTERVAL_S = 0.1


class ProgressBar:
    """Shows nothing for the first second and nothing where stderr is no terminal."""

    def __init__(self, label: str) -> None:
        self._label = label
        self._text = ""
        self._started_s = time.perf_counter()
        self._shown_s = 0.0
        self._bar: Progress | None = None
        self._task: TaskID | None = None
        self._enabled = sys.stderr.isatty()

    def describe(self, text: str) -> None:
        """What is being done just now, beside the label."""
        self._text = text

    def show(self, fraction: float) -> None:
        now_s = time.perf_counter()
        if not self._enabled or now_s - self._started_s < QUIET_S or now_s - self._shown_s < MIN_INTERVAL_S:
            return
        self._shown_s = now_s
        if self._bar is None or self._task is None:
            self._start()
        if self._bar is not None and self._task is not None:
            description = f"{self._label}: {self._text}" if self._text else self._label
            self._bar.update(self._task, completed=min(max(fraction, 0.0), 1.0), description=description)

    def _start(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TaskProgressColumn(),
            TimeRemainingColumn(),
            console=Console(stderr=True),
            transient=True,
        )
        self._bar.start()
        self._task = self._bar.add_task(self._label, total=1.0)

    def close(self) -> None:
        if self._bar is not None:
            self._bar.stop()
            self._bar = None


class Watch:
    """The callback of a long computation, called with the fraction done."""

    def __init__(self, bar: ProgressBar) -> None:
        self._bar = bar
        self.interrupted = False

    def __call__(self, fraction: float) -> bool:
        self._bar.show(fraction)
        return not self.interrupted

    def describe(self, text: str) -> None:
        self._bar.describe(text)


@contextmanager
def interruptible(label: str) -> Iterator[Watch]:
    """Gives the callback of a long computation: it shows the fraction done and answers False once Ctrl-C was pressed.
    A second Ctrl-C stops at once. After the block an interruption that was not answered yet is raised."""
    bar = ProgressBar(label)
    watch = Watch(bar)

    def note_interruption(signal_number: int, frame: FrameType | None) -> None:
        if watch.interrupted:
            raise KeyboardInterrupt
        watch.interrupted = True

    in_main_thread = threading.current_thread() is threading.main_thread()
    previous = signal.signal(signal.SIGINT, note_interruption) if in_main_thread else None
    try:
        yield watch
    finally:
        bar.close()
        if in_main_thread:
            signal.signal(signal.SIGINT, previous)
    if watch.interrupted:
        raise InterruptionError


@contextmanager
def working(label: str) -> Iterator[None]:
    """A spinner on the terminal for work without a known length, shown when it takes longer than a second."""
    if not sys.stderr.isatty():
        yield
        return
    shown: list[Progress] = []
    lock = threading.Lock()
    finished = False

    def show() -> None:
        from rich.console import Console
        from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

        with lock:
            if finished:
                return
            columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
            progress = Progress(*columns, console=Console(stderr=True), transient=True)
            progress.add_task(label, total=None)
            progress.start()
            shown.append(progress)

    timer = threading.Timer(QUIET_S, show)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
        with lock:
            finished = True
        for progress in shown:
            progress.stop()
