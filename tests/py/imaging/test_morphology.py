"""Masks against scipy, scikit-image and OpenCV's own Python module."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from numpy.typing import NDArray
from scipy import ndimage
from skimage import measure

from ssjs_cli import _core

EIGHT = np.ones((3, 3), dtype=int)
masks = arrays(np.bool_, array_shapes(min_dims=2, max_dims=2, max_side=24))


def speckle(density: float, shape: tuple[int, int] = (240, 320)) -> NDArray[np.bool_]:
    return np.random.default_rng(5).random(shape) < density


@pytest.mark.parametrize("density", [0.02, 0.2, 0.41, 0.6, 0.95])
def test_speckle(density: float) -> None:
    mask = speckle(density)
    np.testing.assert_array_equal(_core.fill_holes(mask) > 0, ndimage.binary_fill_holes(mask))
    np.testing.assert_array_equal(_core.remove_small_components(mask, 9) > 0, without_small(mask, 9))
    np.testing.assert_array_equal(_core.dilate(mask, 2) > 0, cv2.dilate(mask.astype(np.uint8), np.ones((3, 3)), iterations=2) > 0)


@settings(deadline=None, max_examples=150)
@given(mask=masks, smallest=st.integers(0, 30), times=st.integers(0, 4))
def test_any_mask(mask: NDArray[np.bool_], smallest: int, times: int) -> None:
    np.testing.assert_array_equal(_core.fill_holes(mask) > 0, ndimage.binary_fill_holes(mask))
    np.testing.assert_array_equal(_core.remove_small_components(mask, smallest) > 0, without_small(mask, smallest))
    expected = ndimage.binary_dilation(mask, EIGHT, iterations=times) if times else mask
    np.testing.assert_array_equal(_core.dilate(mask, times) > 0, expected)
    np.testing.assert_array_equal(_core.bridge(mask) > 0, bridged(mask))


def without_small(mask: NDArray[np.bool_], smallest: int) -> NDArray[np.bool_]:
    labels = measure.label(mask, connectivity=2)
    sizes = np.bincount(labels.ravel())
    return mask & (sizes[labels] >= smallest)


def bridged(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """MATLAB's rule through scipy's labels of every neighbourhood with its centre cleared."""
    padded = np.pad(mask, 1)
    result = mask.copy()
    for y, x in zip(*np.nonzero(~mask), strict=True):
        around = padded[y : y + 3, x : x + 3]
        corners_of_a_side = around.sum() == 2 and any(np.rot90(around, k)[0].tolist() == [True, False, True] for k in range(4))
        result[y, x] = ndimage.label(around, EIGHT)[1] >= 2 and not corners_of_a_side
    return result


def test_result_is_a_new_mask_of_0_and_255() -> None:
    mask = speckle(0.3).astype(np.uint8) * 7
    before = mask.copy()
    for result in (_core.remove_small_components(mask, 4), _core.bridge(mask), _core.dilate(mask), _core.fill_holes(mask)):
        assert result.dtype == np.uint8
        assert set(np.unique(result)) == {0, 255}
        result[:] = 1
    np.testing.assert_array_equal(mask, before)


@pytest.mark.parametrize(
    "view",
    [
        lambda a: a[5:60, 7:90],
        lambda a: a[::2],
        lambda a: a[:, ::3],
        lambda a: a[::-1],
        lambda a: a[:, ::-1],
        lambda a: a.T,
        np.asfortranarray,
    ],
)
def test_views_are_what_they_show(view) -> None:
    part = view(speckle(0.4))
    np.testing.assert_array_equal(_core.fill_holes(part), _core.fill_holes(part.copy(order="C")))
    np.testing.assert_array_equal(_core.bridge(part), _core.bridge(part.copy(order="C")))


@pytest.mark.parametrize("shape", [(0, 0), (0, 5), (5, 0), (1, 1), (1, 9), (9, 1)])
def test_thin_and_empty_masks(shape: tuple[int, int]) -> None:
    mask = np.ones(shape, dtype=bool)
    for result in (_core.remove_small_components(mask, 0), _core.bridge(mask), _core.dilate(mask), _core.fill_holes(mask)):
        assert result.shape == shape
        assert (result == 255).all()


@pytest.mark.parametrize("bad", [np.zeros((3, 4)), np.zeros(4, np.uint8), np.zeros((3, 4, 3), np.uint8), np.zeros((3, 4), np.int8)])
def test_a_bad_mask_is_named_with_its_shape(bad: NDArray[np.generic]) -> None:
    with pytest.raises(ValueError, match=r"mask = \w+ of shape .*: must be a two-dimensional array of uint8"):
        _core.bridge(bad)
