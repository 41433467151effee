"""Scores against plain numpy."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage
from skimage import measure

from ssjs_cli import _core


def blobs(seed: int, level: float) -> NDArray[np.bool_]:
    return ndimage.gaussian_filter(np.random.default_rng(seed).standard_normal((120, 160)), 3) > level


def regions_of(mask: NDArray[np.bool_]) -> _core.Regions:
    return _core.find_regions(mask, mask.view(np.uint8))


@pytest.mark.parametrize("match", ["centroid", "majority"])
@pytest.mark.parametrize("seed", range(5))
def test_against_plain_numpy(seed: int, match: str) -> None:
    truth_mask, noise, pool = blobs(seed, 0.14), blobs(seed + 100, 0.16), blobs(seed + 200, 0.1)
    detected_mask = (np.roll(truth_mask, 2, axis=1) & blobs(seed, 0.15)) | noise
    regions = regions_of(detected_mask)
    score = _core.segmentation_score(regions, _core.GroundTruth.of_mask(truth_mask), pool, {"match": match})

    labels = measure.label(detected_mask, connectivity=2)
    truth = measure.label(truth_mask, connectivity=2)
    detected = measure.regionprops(labels)
    owner = {}
    for region in detected:
        if match == "centroid":
            y, x = np.floor(np.array(region.centroid) + 0.5).astype(int)
            owner[region.label] = truth[y, x]
        else:
            counts = np.bincount(truth[labels == region.label], minlength=truth.max() + 1)
            best = 1 + int(np.argmax(counts[1:]))
            owner[region.label] = best if 2 * counts[best] > region.area else 0
    assert score["true_positives"] == sum(1 for o in owner.values() if o)
    assert score["false_positives"] == sum(1 for o in owner.values() if not o)
    assert score["false_negatives"] == truth.max() - len({o for o in owner.values() if o})
    candidates = measure.label(pool, connectivity=2)
    touched = set(np.unique(candidates[truth_mask | detected_mask])) - {0}
    assert score["true_negatives"] == candidates.max() - len(touched)
    assert score["false_positive_rate"] == score["false_positives"] / (score["false_positives"] + score["true_negatives"])

    errors = []
    for k, entry in enumerate(score["objects"], start=1):
        overlaps = [np.sum((labels == r.label) & (truth == k)) / np.sum((labels == r.label) | (truth == k)) for r in detected]
        assert entry["best_iou"] == pytest.approx(max(overlaps), rel=1e-12)
        mine = [r.centroid for r in detected if owner[r.label] == k]
        assert entry["labels"] == [r.label for r in detected if owner[r.label] == k]
        if mine:
            errors.append(np.linalg.norm(np.mean(mine, axis=0) - np.argwhere(truth == k).mean(axis=0)))
            assert entry["centroid_error_px"] == pytest.approx(errors[-1], rel=1e-9)
        else:
            assert entry["centroid_error_px"] is None
    assert score["mean_centroid_error_px"] == pytest.approx(np.mean(errors), rel=1e-9)
    assert score["hits"] == sum(entry["best_iou"] > 0.3 for entry in score["objects"]) > 0
    assert score["mask_iou"] == np.sum(detected_mask & truth_mask) / np.sum(detected_mask | truth_mask)
    assert score["pixel_recall"] == np.sum(detected_mask & truth_mask) / np.sum(truth_mask)
    assert score["false_area_px"] == np.sum(detected_mask & ~truth_mask)
    assert score["false_area_fraction"] == score["false_area_px"] / np.sum(~truth_mask)


def test_boxes_and_labels() -> None:
    mask = np.zeros((20, 30), bool)
    mask[4:9, 6:16] = True
    boxes = _core.GroundTruth.of_boxes(20, 30, [(6, 4, 10, 10), (25, 15, 50, 50)])
    np.testing.assert_array_equal(boxes.area_px, [100, 25])
    np.testing.assert_array_equal(boxes.centroid_px, [[10.5, 8.5], [27, 17]])
    score = _core.segmentation_score(regions_of(mask), boxes)
    assert [entry["best_iou"] for entry in score["objects"]] == [0.5, 0.0]
    assert score["mask_iou"] is None
    assert score["true_negatives"] is None
    assert score["false_positive_rate"] is None
    assert score["mean_centroid_error_px"] == 2.5

    labels = np.where(mask, np.int32(9), np.int32(0))
    labels[0, 0] = 2
    truth = _core.GroundTruth.of_labels(labels)
    np.testing.assert_array_equal(truth.area_px, [1, 50])
    assert _core.segmentation_score(regions_of(mask), truth)["hit_rate"] == 0.5


def test_bad_input_is_named() -> None:
    truth = _core.GroundTruth.of_mask(np.zeros((4, 6), bool))
    with pytest.raises(ValueError, match="labels = 5 x 4: must have the size of the truth, 6 x 4"):
        _core.segmentation_score(regions_of(np.zeros((4, 5), bool)), truth)
    with pytest.raises(ValueError, match="hit_iou = 2"):
        _core.segmentation_score(regions_of(np.zeros((4, 6), bool)), truth, config={"hit_iou": 2.0})
    with pytest.raises(ValueError, match=r"boxes\[0\]"):
        _core.GroundTruth.of_boxes(4, 6, [(6, 0, 2, 2)])
    with pytest.raises(ValueError, match=r"labels = int64 of shape \(2, 2\)"):
        _core.GroundTruth.of_labels(np.zeros((2, 2), np.int64))
