"""Calibrations of cameras as four programs write them."""

from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from ssjs_cli.errors import UserError
from ssjs_cli.formats.camera_calibration import CameraCalibration, calibration_text, read_calibration

OPENCV = """%YAML:1.0
---
calibration_time: "Mon 02 Nov 2026"
image_width: 320
image_height: 240
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 405.5, 0., 161.25, 0., 404.5, 118.75, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 5
   cols: 1
   dt: d
   data: [ -2.5e-01, 8.e-02, 1.e-03, -2.e-03, 2.e-02 ]
"""
KALIBR = """cam0:
  camera_model: pinhole
  intrinsics: [405.5, 404.5, 161.25, 118.75]
  distortion_model: radtan
  distortion_coeffs: [-0.25, 0.08, 0.001, -0.002]
  resolution: [320, 240]
  rostopic: /camera
"""
BROWN = (-0.25, 0.08, 0.001, -0.002, 0.02)
EXPECTED = CameraCalibration(320, 240, 405.5, 404.5, 161.25, 118.75, 0.0, "brown", BROWN)


def written(folder: Path, text: str, name: str = "camera.yaml") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def test_opencv(tmp_path: Path) -> None:
    assert read_calibration(written(tmp_path, OPENCV)) == EXPECTED


def test_kalibr(tmp_path: Path) -> None:
    assert read_calibration(written(tmp_path, KALIBR)) == CameraCalibration(320, 240, 405.5, 404.5, 161.25, 118.75, 0.0, "brown", BROWN[:4])
    wide = KALIBR.replace("radtan", "equidistant")
    assert read_calibration(written(tmp_path, wide)).lens == "equidistant"


def test_ros_is_what_we_write(tmp_path: Path) -> None:
    for calibration in (
        EXPECTED,
        CameraCalibration(320, 240, 405.5, 404.5, 161.25, 118.75, 0.5),
        CameraCalibration(320, 240, 405.5, 404.5, 161.25, 118.75, 0.0, "equidistant", (0.01, 0.0, -0.002, 0.0)),
    ):
        assert read_calibration(written(tmp_path, calibration_text(calibration))) == calibration


def test_bouguet(tmp_path: Path) -> None:
    path = tmp_path / "Calib_Results.mat"
    columns = {"fc": [405.5, 404.5], "cc": [161.25, 118.75], "kc": BROWN, "alpha_c": [0.01]}
    savemat(path, {**{key: np.array(value)[:, None] for key, value in columns.items()}, "nx": 320, "ny": 240})
    found = read_calibration(path)
    assert (found.lens, found.distortion, found.width_px, found.height_px) == ("brown", BROWN, 320, 240)
    assert found.skew_px == pytest.approx(0.01 * 405.5)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "holds no calibration"),
        ("[1, 2]", "holds no calibration"),
        ("a: [", "not valid YAML"),
        ("a: 1\n", "neither camera_matrix nor intrinsics"),
        ("a: &x [1]\nb: [*x, *x]\n", "aliases"),
        ("!!python/object/apply:os.system ['true']", "not valid YAML"),
        (OPENCV.replace("image_width: 320", "image_width: 320.5"), "whole number"),
        (OPENCV.replace("image_width: 320\n", ""), "image_width"),
        (OPENCV.replace("image_width: 320", "image_width: -320"), "width_px"),
        (OPENCV.replace("405.5, 0., 161.25", "405.5, 0."), "9 numbers"),
        (
            OPENCV.replace("405.5, 0., 161.25, 0., 404.5, 118.75, 0., 0., 1.", "405.5, 0., 0., 0., 404.5, 0., 161.25, 118.75, 1."),
            "row by row",
        ),
        (OPENCV.replace("405.5", ".nan"), "focal_x_px"),
        (OPENCV.replace("2.e-02 ]", "2.e-02, 0.1, 0., 0. ]"), "first 5"),
        (OPENCV.replace("-2.5e-01", "-9.0"), "folds"),
        (KALIBR.replace("pinhole", "omni"), "camera_model"),
        (KALIBR.replace("radtan", "fov"), "distortion_model"),
        (KALIBR.replace("118.75]", "]"), "intrinsics"),
    ],
)
def test_what_is_wrong_is_named(tmp_path: Path, text: str, words: str) -> None:
    path = written(tmp_path, text)
    with pytest.raises(UserError, match=r"camera\.yaml") as raised:
        read_calibration(path)
    assert words in str(raised.value)


def test_other_files(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"missing\.yaml"):
        read_calibration(tmp_path / "missing.yaml")
    (tmp_path / "a.mat").write_bytes(b"MATLAB 5.0 MAT-file" + bytes(200))
    with pytest.raises(UserError, match=r"a\.mat"):
        read_calibration(tmp_path / "a.mat")
    (tmp_path / "a.yaml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(UserError, match="UTF-8"):
        read_calibration(tmp_path / "a.yaml")
