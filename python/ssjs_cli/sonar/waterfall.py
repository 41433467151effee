"""The command `sonar waterfall`: a log as a grey picture in slant range, the first ping at the top, port left of starboard, the track
between them. The log is read twice, for the levels and for the picture: echoes of 16 bits and more become 8 between two robust levels."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssjs_cli import _core
from ssjs_cli.errors import UserError
from ssjs_cli.formats.atomic import check_writable, write_file
from ssjs_cli.formats.image_file import MAX_PIXELS
from ssjs_cli.session import Session
from ssjs_cli.sonar.info import describe_problem, exit_code
from ssjs_cli.sonar.log_blocks import blocks, open_log

SCALES = ("log", "linear")
#: Fractions of the echoes that may become black and white.
DARK_FRACTION, BRIGHT_FRACTION = 0.01, 0.005
BINS_PER_OCTAVE = 64
MOST_OCTAVES = 64


@dataclass
class Survey:
    """What the first reading finds: levels and geometry of one frequency."""

    frequency_hz: float
    pings: int = 0
    width_px: int = 0
    range_m: float = 0.0
    histogram: NDArray[np.int64] = field(default_factory=lambda: np.zeros(MOST_OCTAVES * BINS_PER_OCTAVE + 1, dtype=np.int64))

    def add(self, channels: list[dict[str, Any]], sound_speed_m_s: float) -> None:
        self.pings += 1
        for channel in channels:
            samples = channel["samples"]
            self.width_px = max(self.width_px, len(samples))
            end_s = channel["first_sample_s"] + len(samples) * channel["sample_interval_s"]
            self.range_m = max(self.range_m, end_s * sound_speed_m_s / 2.0)
            bins = (np.log2(samples + 1.0) * BINS_PER_OCTAVE).astype(np.int64)
            self.histogram += np.bincount(np.minimum(bins, len(self.histogram) - 1), minlength=len(self.histogram))

    def levels(self) -> tuple[float, float]:
        """The echo strengths that become black and white."""
        below = np.cumsum(self.histogram) / max(int(self.histogram.sum()), 1)
        dark = int(np.searchsorted(below, DARK_FRACTION))
        bright = max(int(np.searchsorted(below, 1.0 - BRIGHT_FRACTION)) + 1, dark + 1)
        return 2.0 ** (dark / BINS_PER_OCTAVE) - 1.0, 2.0 ** (bright / BINS_PER_OCTAVE) - 1.0


def draw_waterfall(path: Path, out: Path | None, session: Session, *, scale: str, frequency_khz: float | None, force: bool) -> int:
    target = out or Path("runs") / f"{path.stem}-waterfall.png"
    if target.suffix.lower() != ".png":
        raise UserError(f"{target}: the picture is a PNG; end the name of --out with .png")
    check_writable(target, [path], force=force)
    survey = survey_log(path, None if frequency_khz is None else frequency_khz * 1e3)
    if survey.pings * 2 * survey.width_px > MAX_PIXELS:
        size = f"{survey.pings} pings of twice {survey.width_px} samples"
        raise UserError(f"{path}: {size} are more than the {MAX_PIXELS / 1e6:.0f} million pixels of a picture; split the log")
    pixels, problems = picture_of(path, survey, scale)
    target.parent.mkdir(parents=True, exist_ok=True)
    write_file(target, _png(pixels))
    dark, bright = survey.levels()
    document = {
        "picture": str(target),
        "pings": survey.pings,
        "width_px": 2 * survey.width_px,
        "height_px": survey.pings,
        "frequency_hz": survey.frequency_hz,
        "range_m": round(survey.range_m, 3),
        "m_per_px": survey.range_m / survey.width_px,
        "scale": scale,
        "black_level": dark,
        "white_level": bright,
        "problems": problems,
    }
    for problem in problems:
        session.message(describe_problem(problem))
    size = f"{survey.pings} pings by 2 x {survey.width_px} samples, {survey.range_m:g} m to each side"
    session.answer(document, f"{path}: {size}\npicture  {target}")
    return exit_code(problems)


def survey_log(path: Path, frequency_hz: float | None) -> Survey:
    """frequency_hz: the one wanted, to within 5 %; none for that of the first ping."""
    log = open_log(path)
    survey: Survey | None = None
    seen: set[float] = set()
    for block in blocks(log):
        for channels, sound_speed_m_s in zip(block["channels"], block["pings"]["sound_speed_m_s"], strict=True):
            seen.update(channel["frequency_hz"] for channel in channels)
            if survey is None:
                fitting = [
                    c["frequency_hz"]
                    for c in channels
                    if frequency_hz is None or abs(c["frequency_hz"] - frequency_hz) <= 0.05 * frequency_hz
                ]
                survey = Survey(fitting[0]) if fitting else None
            if survey is not None and (chosen := _of_frequency(channels, survey.frequency_hz)):
                survey.add(chosen, float(sound_speed_m_s))
    if survey is None:
        there = ", ".join(f"{frequency / 1e3:g}" for frequency in sorted(seen))
        asked = "" if frequency_hz is None else f" of {frequency_hz / 1e3:g} kHz"
        raise UserError(
            f"{path}: holds no side-scan ping{asked}; " + (f"there are {there} kHz" if seen else "check that it is the right file")
        )
    return survey


def picture_of(path: Path, survey: Survey, scale: str) -> tuple[NDArray[np.uint8], list[dict[str, Any]]]:
    """(pings, 2 width) grey levels, and the problems of the log."""
    log = open_log(path)
    pixels = np.zeros((survey.pings, 2 * survey.width_px), dtype=np.uint8)
    for row, (_, grey) in enumerate(grey_rows(log, survey, scale)):
        pixels[row] = grey
    problems: list[dict[str, Any]] = log.info()["problems"]
    return pixels, problems


def grey_rows(log: _core.SonarLog, survey: Survey, scale: str) -> Iterator[tuple[float, NDArray[np.uint8]]]:
    """Of each ping its time (NaN where the log has none) and its row of the picture, (2 width,): port, then starboard."""
    levels = survey.levels()
    for block in blocks(log):
        pings = block["pings"]
        for channels, time_s, sound_speed_m_s in zip(
            block["channels"], pings["time_s"].tolist(), pings["sound_speed_m_s"].tolist(), strict=True
        ):
            chosen = _of_frequency(channels, survey.frequency_hz)
            if not chosen:
                continue
            row = np.zeros(2 * survey.width_px, dtype=np.uint8)
            for channel in chosen:
                near_to_far = _grey(_on_grid(channel, sound_speed_m_s, survey), levels, scale)
                if channel["side"] == "port":
                    row[: survey.width_px] = near_to_far[::-1]
                else:
                    row[survey.width_px :] = near_to_far
            yield time_s, row


def _of_frequency(channels: list[dict[str, Any]], frequency_hz: float) -> list[dict[str, Any]]:
    return [channel for channel in channels if channel["frequency_hz"] == frequency_hz]


def _on_grid(channel: dict[str, Any], sound_speed_m_s: float, survey: Survey) -> NDArray[np.float64]:
    """The mean echo over each pixel; pixels before the first sample and behind the last hold nothing. Where no slant range is known,
    samples are pixels."""
    samples = channel["samples"].astype(np.float64)
    per_sample_m = channel["sample_interval_s"] * sound_speed_m_s / 2.0
    if per_sample_m == 0.0 or survey.range_m == 0.0:
        return np.pad(samples, (0, max(survey.width_px - len(samples), 0)))[: survey.width_px]
    edges_m = np.arange(survey.width_px + 1) * (survey.range_m / survey.width_px)
    edges = np.clip(edges_m / per_sample_m - channel["first_sample_s"] / channel["sample_interval_s"], 0.0, len(samples))
    total = np.interp(edges, np.arange(len(samples) + 1), np.concatenate([[0.0], np.cumsum(samples)]))
    covered = np.diff(edges)
    mean: NDArray[np.float64] = np.divide(np.diff(total), covered, out=np.zeros(survey.width_px), where=covered > 1e-6)
    return mean


def _grey(strength: NDArray[np.float64], levels: tuple[float, float], scale: str) -> NDArray[np.uint8]:
    dark, bright = levels
    if scale == "log":
        share = np.log2((strength + 1.0) / (dark + 1.0)) / np.log2((bright + 1.0) / (dark + 1.0))
    else:
        share = (strength - dark) / (bright - dark)
    grey: NDArray[np.uint8] = np.rint(np.clip(share, 0.0, 1.0) * 255.0).astype(np.uint8)
    return grey


def _png(pixels: NDArray[np.uint8]) -> bytes:
    import io

    from PIL import Image

    file = io.BytesIO()
    Image.fromarray(pixels).save(file, format="PNG", compress_level=6)
    return file.getvalue()
