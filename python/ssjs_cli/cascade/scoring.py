"""Detections against labelled boxes: which found what, and the curves that follow from it.

A detection, best first, takes the object that it overlaps most of those not taken yet, where the intersection over union reaches
the limit; every other detection is false, a second one on the same object too. [everingham2010]
FROC: share of objects found against false boxes an image, over all thresholds on the score. Precision and recall likewise.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ssjs_cli.cascade.window_boxes import intersection_over_union
from ssjs_cli.formats.annotations.boxes import Box

Floats = NDArray[np.float64]
#: Of the normal distribution: 95 % lie within.
_Z_95 = 1.959963984540054
BAND = (2.5, 97.5)


@dataclass(frozen=True)
class Scored:
    """neighbours: windows that agreed on the box; of equal scores more of them are better, for cascades of few features know few scores."""

    box: Box
    score: float
    neighbours: int = 0

    @property
    def rank(self) -> tuple[float, int]:
        return self.score, self.neighbours


@dataclass(frozen=True)
class ImageMatch:
    """found[i]: the object that detection i found, None: it is false. Detections by falling score. group: of images that go together."""

    detections: Sequence[Scored]
    objects: Sequence[Box]
    found: Sequence[int | None]
    group: str

    def missed(self) -> list[int]:
        taken = {index for index in self.found if index is not None}
        return [index for index in range(len(self.objects)) if index not in taken]


def match(detections: Sequence[Scored], objects: Sequence[Box], iou: float, group: str = "") -> ImageMatch:
    ordered = sorted(detections, key=lambda detection: detection.rank, reverse=True)
    free = set(range(len(objects)))
    found: list[int | None] = []
    for detection in ordered:
        best, best_iou = None, iou
        for index in sorted(free):
            overlap = intersection_over_union(detection.box, objects[index])
            if overlap >= best_iou and (best is None or overlap > best_iou):
                best, best_iou = index, overlap
        found.append(best)
        if best is not None:
            free.discard(best)
    return ImageMatch(ordered, objects, found, group)


@dataclass(frozen=True)
class Curve:
    """One entry for each threshold, falling: objects found so far, false boxes so far."""

    thresholds: Floats
    true_boxes: Floats
    false_boxes: Floats
    objects: int
    images: int

    @property
    def detection_rate(self) -> Floats:
        return self.true_boxes / max(self.objects, 1)

    @property
    def false_per_image(self) -> Floats:
        return self.false_boxes / max(self.images, 1)

    @property
    def precision(self) -> Floats:
        precision: Floats = self.true_boxes / np.maximum(self.true_boxes + self.false_boxes, 1)
        return precision

    def rate_at(self, false_per_image: Floats | float) -> Floats:
        """The best detection rate with no more false boxes an image than that."""
        place = np.searchsorted(self.false_per_image, np.asarray(false_per_image) + 1e-12, side="right")
        return np.concatenate([[0.0], self.detection_rate])[place]

    def average_precision(self) -> float:
        """The area below precision over recall, precision being the best at that recall or a greater one."""
        envelope = np.maximum.accumulate(self.precision[::-1])[::-1]
        return float(np.sum(np.diff(self.detection_rate, prepend=0.0) * envelope))


def curve(matches: Sequence[ImageMatch]) -> Curve:
    ranks = np.array([detection.rank for image in matches for detection in image.detections], dtype=np.float64).reshape(-1, 2)
    true = np.array([index is not None for image in matches for index in image.found], dtype=bool)
    order = np.lexsort((-ranks[:, 1], -ranks[:, 0]))
    ranks, true = ranks[order], true[order]
    last = np.flatnonzero(np.append((np.diff(ranks, axis=0) != 0).any(axis=1), True)) if len(ranks) else np.zeros(0, dtype=np.int64)
    return Curve(
        ranks[last, 0],
        np.cumsum(true)[last].astype(np.float64),
        np.cumsum(~true)[last].astype(np.float64),
        sum(len(image.objects) for image in matches),
        len(matches),
    )


def bootstrap_band(matches: Sequence[ImageMatch], grid: Floats, samples: int, seed: int) -> tuple[Floats, Floats] | None:
    """95 % of the detection rate at each number of false boxes an image, whole groups drawn again and again. None for fewer than two
    groups: images of one recording say nothing about another."""
    groups = sorted({image.group for image in matches})
    if len(groups) < 2 or samples < 1:
        return None
    of_group = {group: [image for image in matches if image.group == group] for group in groups}
    rng = np.random.default_rng(seed)
    rates = np.empty((samples, len(grid)))
    for sample in range(samples):
        drawn = [image for index in rng.integers(0, len(groups), len(groups)) for image in of_group[groups[index]]]
        rates[sample] = curve(drawn).rate_at(grid)
    low, high = np.percentile(rates, BAND, axis=0)
    return low, high


def wilson_band(successes: int, trials: int) -> tuple[float, float]:
    """95 % of a rate. [wilson1927]"""
    if trials == 0:
        return 0.0, 1.0
    rate, z2 = successes / trials, _Z_95**2
    centre = (rate + z2 / (2 * trials)) / (1 + z2 / trials)
    half = _Z_95 / (1 + z2 / trials) * math.sqrt(rate * (1 - rate) / trials + z2 / (4 * trials**2))
    return max(0.0, centre - half), min(1.0, centre + half)
