"""Objects with shadows, three classes against scikit-image."""

import numpy as np
import pytest
from numpy.typing import NDArray
from skimage.filters import threshold_multiotsu

from ssjs_cli import _core


def scene() -> NDArray[np.uint8]:
    """Grey 90 with a target of 10 x 20 pixels and its shadow of 30 x 20, on starboard."""
    image = np.full((100, 200), 90, np.uint8)
    image[40:60, 80:90] = 230
    image[40:60, 90:120] = 5
    return image


def test_a_drawn_target() -> None:
    found = _core.highlight_shadow(scene(), 0, config={"median_px": 1})
    assert (found["shadow_below"], found["highlight_above"]) == (90, 90)
    (target,) = found["objects"]
    assert target["side"] == "starboard"
    assert target["centroid_px"] == [84.5, 49.5]
    assert target["highlight_box_px"] == [80, 40, 10, 20]
    assert (target["highlight_area_px"], target["shadow_area_px"]) == (200, 600)
    assert (target["shadow_start_px"], target["shadow_tip_px"], target["shadow_is_cut"]) == (90, 120, False)
    height = _core.height_from_shadow_m(4.0, 0.1 * target["shadow_start_px"], 0.1 * target["shadow_tip_px"])
    assert height == pytest.approx(1.0)
    assert found["highlights"].shape == found["shadows"].shape == (100, 200)


def test_the_mirror_image_lies_on_port_without_a_copy_of_it() -> None:
    (target,) = _core.highlight_shadow(scene()[:, ::-1], 200, config={"median_px": 1})["objects"]
    assert target["side"] == "port"
    assert target["centroid_px"] == [114.5, 49.5]
    assert _core.highlight_shadow(scene()[:, ::-1], 0)["objects"] == []


def test_invalid_pixels_cast_no_shadow() -> None:
    valid = np.ones((100, 200), bool)
    valid[:, 90:] = False
    assert _core.highlight_shadow(scene(), 0, valid)["objects"] == []


def test_bad_settings_are_named() -> None:
    with pytest.raises(ValueError, match="median_px = 4: must be odd"):
        _core.highlight_shadow(scene(), 0, config={"median_px": 4})
    with pytest.raises(ValueError, match="nadir = 3: no such configuration key"):
        _core.highlight_shadow(scene(), 0, config={"nadir": 3})
    with pytest.raises(ValueError, match="nadir_column = 201"):
        _core.highlight_shadow(scene(), 201)
    with pytest.raises(ValueError, match="ranges = slope: must be one of ground, slant_top, slant_foot"):
        _core.height_from_shadow_m(4, 1, 2, "slope")
    assert {field["key"]: field["default"] for field in _core.highlight_shadow_fields()}["levels"] == "quantile"


@pytest.mark.parametrize("seed", range(12))
def test_three_classes_are_those_of_scikit_image(seed: int) -> None:
    rng = np.random.default_rng(seed)
    pixels = np.concatenate([rng.normal(mean, sigma, n) for mean, sigma, n in [(30, 9, 800), (100, 20, 6000), (210, 15, 400)]])
    image = np.clip(np.rint(pixels), 0, 255).astype(np.uint8)
    expected = threshold_multiotsu(hist=(np.bincount(image, minlength=256), np.arange(256)), classes=3)
    assert _core.three_class_otsu(np.bincount(image, minlength=256)) == tuple(expected)
