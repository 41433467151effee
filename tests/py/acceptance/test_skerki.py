"""The Skerki Bank wreck from the stills of a remotely operated vehicle: no navigation, no calibration. The matches that come with the data
were made by others and are used to judge alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io

from ssjs_cli import _core
from ssjs_cli.config import resolve
from ssjs_cli.formats.frames import FrameIndex
from ssjs_cli.formats.number_table import FloatArray
from ssjs_cli.optical.frame_settings import FRAMES_ALONE, FrameSettings
from ssjs_cli.optical.planar_survey import PlanarSurvey, planar_survey, poses_at_frames

FIRST_CONTIGUOUS = 539
SECONDS_APART = 13.0
MIDDLE = np.array([287.5, 191.5])
#: Links of neighbours in time lead from one frame to the next or the one after it; all others join survey lines.
LINE_GAP = 2


@dataclass(frozen=True)
class SuppliedLink:
    """Rows of two frames of the survey, and matched pixels as taken."""

    first: int
    second: int
    first_px: FloatArray
    second_px: FloatArray


@dataclass(frozen=True)
class Survey:
    survey: PlanarSurvey
    settings: FrameSettings
    result: Mapping[str, Any]
    links: list[SuppliedLink]

    def straight(self, pixel: FloatArray) -> FloatArray:
        assert self.survey.lens is not None
        return _core.undistorted(pixel, self.survey.lens)


@pytest.fixture(scope="module")
def skerki(data_set: Callable[[str], Path]) -> Survey:
    folder = data_set("skerki")
    names = sorted(path.name for path in (folder / "images").glob("*.png") if int(path.name.split(".")[2]) >= FIRST_CONTIGUOUS)
    row = {int(name.split(".")[2]): number for number, name in enumerate(names)}
    settings = FrameSettings(resolve([], FRAMES_ALONE).values)

    def estimate(log: Any) -> Mapping[str, Any]:
        return _core.run(settings.of_estimator, log, 1)

    index = FrameIndex(folder / "images", SECONDS_APART * np.arange(len(names)), tuple(names))
    survey = planar_survey(index, settings, 1, [], estimate, lambda fraction: True)
    links = []
    for path in sorted((folder / "matches").glob("match*.mat")):
        first, second = (int(text) for text in path.stem.removeprefix("match").split("_"))
        if second - first > LINE_GAP:
            pairs = scipy.io.loadmat(path)
            links.append(SuppliedLink(row[first], row[second], pairs["ff"] + MIDDLE, pairs["gg"] + MIDDLE))
    return Survey(survey, settings, estimate(survey.log), links)


def test_frames_in_sequence_register(skerki: Survey) -> None:
    assert len(skerki.survey.frames.features) == 252
    assert all(len(features.keypoints["scale_px"]) > 0 for features in skerki.survey.frames.features)
    assert sum(second - first == 1 for first, second in skerki.survey.links) >= 240


def test_links_between_lines_are_reproduced(skerki: Survey) -> None:
    """Within 5 px of the frame as taken: median over the points of a link."""
    lens = skerki.survey.lens
    assert skerki.survey.lens_is_estimated and lens is not None
    assert -0.06 < lens["distortion"][0] < -0.02
    features = skerki.survey.frames.features
    reproduced = 0
    for link in skerki.links:
        found = _core.register_frames(features[link.first], features[link.second], skerki.settings.of_frames)
        if found is not None:
            there = np.column_stack((skerki.straight(link.first_px), np.ones(len(link.first_px)))) @ found["second_H_first"].T
            seen = _core.distorted(there[:, :2] / there[:, 2:], lens)
            reproduced += float(np.median(np.linalg.norm(seen - link.second_px, axis=1))) <= 5.0
    assert len(skerki.links) == 23
    assert reproduced >= 0.85 * len(skerki.links)


def test_slam_brings_the_lines_together(skerki: Survey) -> None:
    """Residual of the supplied links, in pixels: how far apart both frames put the same points. All links count, bad ones among them."""
    rows = np.searchsorted(np.asarray(skerki.result["time_s"]), skerki.survey.frames.time_s, side="right") - 1
    before = residuals(skerki, np.asarray(skerki.result["dead_reckoning"])[rows])
    after = residuals(skerki, poses_at_frames(skerki.result, skerki.survey.frames.time_s)[0])
    assert np.median(after) <= np.median(before) / 3.0
    assert root_mean_square(after) <= root_mean_square(before) / 3.0


def residuals(skerki: Survey, pose: FloatArray) -> FloatArray:
    placed = skerki.survey.placed_on_map(pose)

    def on_map(frame: int, pixel: FloatArray) -> FloatArray:
        return np.column_stack((skerki.straight(pixel), np.ones(len(pixel)))) @ placed[frame, :2].T

    pixel_length = float(np.median(skerki.survey.pixel_length))
    return np.array([
        np.median(np.linalg.norm(on_map(link.first, link.first_px) - on_map(link.second, link.second_px), axis=1)) / pixel_length
        for link in skerki.links
    ])  # fmt: skip


def root_mean_square(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))
