"""Region measures against scikit-image, groups against all pairs of pixels."""

import math
import threading

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree
from skimage import measure

from ssjs_cli import _core

ROUNDING = 1e-9


def blobs(seed: int, shape: tuple[int, int] = (150, 210), level: float = 0.06) -> NDArray[np.bool_]:
    return ndimage.gaussian_filter(np.random.default_rng(seed).standard_normal(shape), 2.5) > level


@pytest.mark.parametrize("type_", [np.uint8, np.uint16])
@pytest.mark.parametrize("seed", range(4))
def test_measures_are_those_of_scikit_image(seed: int, type_: type) -> None:
    mask = blobs(seed)
    image = np.random.default_rng(seed).integers(0, np.iinfo(type_).max, mask.shape, dtype=type_, endpoint=True)
    regions = _core.find_regions(mask, image)
    reference = measure.regionprops(measure.label(mask, connectivity=2), image)
    np.testing.assert_array_equal(regions.labels, measure.label(mask, connectivity=2))
    assert len(regions) == len(reference) > 20
    for i, region in enumerate(reference):
        assert regions.area_px[i] == region.area
        np.testing.assert_allclose(regions.centroid_px[i], region.centroid[::-1], rtol=0, atol=ROUNDING)
        top, left, bottom, right = region.bbox
        assert regions.bounding_box_px[i].tolist() == [left, top, right - left, bottom - top]
        assert regions.mean_intensity[i] == pytest.approx(region.intensity_mean, rel=1e-12)
        assert regions.max_intensity[i] == region.intensity_max
        # scikit-image takes pixels as points, we as squares of variance 1/12: (4 sqrt(l + 1/12))^2 = (4 sqrt(l))^2 + 16/12
        assert regions.major_axis_px[i] ** 2 - 4 / 3 == pytest.approx(region.axis_major_length**2, rel=1e-9, abs=1e-9)
        assert regions.minor_axis_px[i] ** 2 - 4 / 3 == pytest.approx(region.axis_minor_length**2, rel=1e-9, abs=1e-9)
        if regions.major_axis_px[i] - regions.minor_axis_px[i] > 1e-3:
            turn = math.pi / 2 - regions.orientation_rad[i] - region.orientation
            assert math.remainder(turn, math.pi) == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("gap_px", [0, 2, 2.1, 4, 9.5, 40, math.inf])
def test_groups_are_those_of_all_pairs_of_pixels(gap_px: float) -> None:
    mask = blobs(7, level=0.15)
    regions = _core.find_regions(mask, mask.view(np.uint8))
    pixels = np.argwhere(mask)
    label = regions.labels[mask] - 1
    # all pairs of pixels nearer than the gap; a k-d tree takes pairs at most that far apart
    pairs = cKDTree(pixels).query_pairs(math.nextafter(min(gap_px, 1e3), 0), output_type="ndarray") if gap_px < 20 else None
    if pairs is None:
        tree = [cKDTree(pixels[label == i]) for i in range(len(regions))]
        near = [(i, j) for i in range(len(tree)) for j in range(i) if tree[i].query(tree[j].data)[0].min() < gap_px]
        joined = np.array(near, dtype=int).reshape(-1, 2)
    else:
        joined = label[pairs]
    graph = coo_array((np.ones(len(joined)), (joined[:, 0], joined[:, 1])), shape=(len(regions), len(regions)))
    count, expected = connected_components(graph, directed=False)
    objects = _core.group_regions(regions, gap_px, "area")
    assert len(objects["area_px"]) == count
    _, first = np.unique(expected, return_index=True)
    order = np.argsort(np.argsort(first))  # scipy numbers groups as it meets them; so do we, by their first region
    np.testing.assert_array_equal(objects["object_of_region"], order[expected])
    for k in range(count):
        members = objects["object_of_region"][label] == k
        assert objects["area_px"][k] == members.sum()
        np.testing.assert_allclose(objects["centroid_px"][k], pixels[members].mean(axis=0)[::-1], rtol=0, atol=ROUNDING)
        top, left = pixels[members].min(axis=0)
        bottom, right = pixels[members].max(axis=0)
        assert objects["bounding_box_px"][k].tolist() == [left, top, right - left + 1, bottom - top + 1]


def test_labels_are_a_view_that_outlives_the_regions() -> None:
    mask = blobs(3)
    labels = _core.find_regions(mask, mask.view(np.uint8)).labels
    np.testing.assert_array_equal(labels > 0, mask)


def test_foreign_byte_order() -> None:
    mask = blobs(3)
    image = np.random.default_rng(1).integers(0, 65535, mask.shape, dtype=np.uint16)
    swapped = image.astype(image.dtype.newbyteorder())
    np.testing.assert_array_equal(_core.find_regions(mask, swapped).mean_intensity, _core.find_regions(mask, image).mean_intensity)


def test_threads_share_a_mask() -> None:
    mask = blobs(3)
    expected = _core.find_regions(mask, mask.view(np.uint8)).centroid_px
    found: list[NDArray[np.float64]] = []
    threads = [threading.Thread(target=lambda: found.append(_core.find_regions(mask, mask.view(np.uint8)).centroid_px)) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 8
    for centroids in found:
        np.testing.assert_array_equal(centroids, expected)


def test_what_does_not_fit_is_named() -> None:
    mask = blobs(3)
    with pytest.raises(ValueError, match=r"intensity = 3 x 2: must have the size of the mask, 210 x 150"):
        _core.find_regions(mask, np.zeros((2, 3), np.uint8))
    with pytest.raises(ValueError, match=r"intensity = float32 of shape \(150, 210\): must be a two-dimensional array of uint8 or uint16"):
        _core.find_regions(mask, mask.astype(np.float32))
    with pytest.raises(ValueError, match=r"weighting = mass: must be one of regions, area"):
        _core.group_regions(_core.find_regions(mask, mask.view(np.uint8)), 3, "mass")
