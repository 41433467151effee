"""Calibrations of cameras: what OpenCV, ROS, Kalibr and Bouguet's toolbox write, and the file of a mission, which is ROS's.

All of them count pixels from the centre of the top left one, which is (0, 0); Bouguet's toolbox too, though MATLAB counts from 1.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from ssjs_cli.errors import UserError, describe_os_error
from ssjs_cli.formats.frame_image import MAX_PIXELS

Lens = Literal["pinhole", "brown", "equidistant"]

MAX_BYTES = 1024 * 1024
#: Names of distortion models, and how many coefficients each has here.
_LENSES: dict[str, tuple[Lens, int]] = {
    "plumb_bob": ("brown", 5),
    "radtan": ("brown", 5),
    "rational_polynomial": ("brown", 5),
    "equidistant": ("equidistant", 4),
    "fisheye": ("equidistant", 4),
    "none": ("pinhole", 0),
    "": ("brown", 5),
}
_KNOWN = (
    "OpenCV (camera_matrix, distortion_coefficients), ROS (camera_matrix with data), Kalibr (cam0 with intrinsics), "
    "Bouguet's toolbox (Calib_Results.mat)"
)


@dataclass(frozen=True)
class CameraCalibration:
    """`distortion`: brown k1 k2 p1 p2 k3, equidistant k1 k2 k3 k4, pinhole none."""

    width_px: int
    height_px: int
    focal_x_px: float
    focal_y_px: float
    centre_x_px: float
    centre_y_px: float
    skew_px: float = 0.0
    lens: Lens = "pinhole"
    distortion: tuple[float, ...] = ()


def read_calibration(path: Path) -> CameraCalibration:
    """Raises UserError that names the file, what is wrong with it, and how to mend it."""
    try:
        if path.stat().st_size > MAX_BYTES:
            raise UserError(f"{path}: is larger than any calibration ({MAX_BYTES} bytes); check that it is the right file")
        found = _bouguet(path) if path.suffix.lower() == ".mat" else _yaml(path)
    except OSError as error:
        raise UserError(describe_os_error(error, str(path))) from error
    _check(found, path)
    return found


def calibration_text(calibration: CameraCalibration, name: str = "camera") -> str:
    """As ROS's camera_info writes it."""
    c = calibration
    model = {"pinhole": "plumb_bob", "brown": "plumb_bob", "equidistant": "equidistant"}[c.lens]
    distortion = [*c.distortion, *([0.0] * ((4 if c.lens == "equidistant" else 5) - len(c.distortion)))]
    matrix = [c.focal_x_px, c.skew_px, c.centre_x_px, 0.0, c.focal_y_px, c.centre_y_px, 0.0, 0.0, 1.0]
    return (
        f"image_width: {c.width_px}\nimage_height: {c.height_px}\ncamera_name: {name}\n"
        f"camera_matrix:\n  rows: 3\n  cols: 3\n  data: {_list(matrix)}\n"
        f"distortion_model: {model}\n"
        f"distortion_coefficients:\n  rows: 1\n  cols: {len(distortion)}\n  data: {_list(distortion)}\n"
    )


def _list(values: Sequence[float]) -> str:
    return "[" + ", ".join(repr(float(value)) for value in values) + "]"


def _yaml(path: Path) -> CameraCalibration:
    import yaml

    class Loader(yaml.SafeLoader):
        """Plain values, and OpenCV's matrices as the mappings that they are."""

    def mapping(loader: yaml.SafeLoader, node: yaml.MappingNode) -> dict[Any, Any]:
        return loader.construct_mapping(node, deep=True)

    Loader.add_constructor("tag:yaml.org,2002:opencv-matrix", mapping)
    try:
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise UserError(f"{path}: is not UTF-8 text (byte {error.start}); calibrations are read from YAML or Calib_Results.mat") from error
    if text.startswith("%YAML:1.0"):  # OpenCV's first line is not YAML's
        text = "#" + text
    try:
        _refuse_aliases(text, yaml)
        content = yaml.load(text, Loader)  # a SafeLoader: no objects are made
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise UserError(f"{path}: is not valid YAML: {' '.join(str(error).split())}; export the calibration again") from error
    if not isinstance(content, dict):
        raise UserError(f"{path}: holds no calibration; known are those of {_KNOWN}")
    if isinstance(content.get("cam0"), dict):
        return _kalibr(content["cam0"], path)
    if "intrinsics" in content:
        return _kalibr(content, path)
    return _matrices(content, path)


def _refuse_aliases(text: str, yaml: Any) -> None:
    """A few lines of aliases can stand for a thousand million entries."""
    if any(isinstance(event, yaml.AliasEvent) for event in yaml.parse(text, yaml.SafeLoader)):
        raise ValueError("aliases (*name) have no place in a calibration")


def _kalibr(camera: Mapping[str, Any], path: Path) -> CameraCalibration:
    model = camera.get("camera_model", "pinhole")
    if model != "pinhole":
        raise UserError(f"{path}: camera_model '{model}' is not known here; calibrate with pinhole-radtan or pinhole-equi")
    focal_x, focal_y, centre_x, centre_y = _numbers(camera, "intrinsics", path, 4)
    width, height = _numbers(camera, "resolution", path, 2)
    lens, distortion = _distortion(
        str(camera.get("distortion_model", "none")), camera.get("distortion_coeffs", []), "distortion_coeffs", path
    )
    return CameraCalibration(
        _whole(width, "resolution", path), _whole(height, "resolution", path), focal_x, focal_y, centre_x, centre_y, 0.0, lens, distortion
    )


def _matrices(content: Mapping[str, Any], path: Path) -> CameraCalibration:
    matrix_key = next((key for key in ("camera_matrix", "Camera_Matrix", "cameraMatrix", "K") if key in content), None)
    if matrix_key is None:
        raise UserError(f"{path}: has neither camera_matrix nor intrinsics; known are calibrations of {_KNOWN}")
    matrix = _numbers(content, matrix_key, path, 9)
    if (matrix[3], matrix[6], matrix[7], matrix[8]) != (0.0, 0.0, 0.0, 1.0):
        raise UserError(f"{path}: {matrix_key} is not a camera matrix [fx s cx; 0 fy cy; 0 0 1]; check its order (row by row)")
    keys = ("distortion_coefficients", "Distortion_Coefficients", "distCoeffs", "D")
    distortion_key = next((key for key in keys if key in content), None)
    model = str(content.get("distortion_model", "fisheye" if content.get("fisheye_model") in (1, True) else ""))
    coefficients = content[distortion_key] if distortion_key is not None else []
    lens, distortion = _distortion(model, coefficients, distortion_key or "distortion", path)
    sizes = [next((content[key] for key in names if key in content), None) for names in _SIZE_KEYS]
    if sizes[0] is None or sizes[1] is None:
        raise UserError(f"{path}: image_width or image_height is missing; add the size of the frames that were calibrated")
    width, height = (_whole(size, key[0], path) for size, key in zip(sizes, _SIZE_KEYS, strict=True))
    return CameraCalibration(width, height, matrix[0], matrix[4], matrix[2], matrix[5], matrix[1], lens, distortion)


_SIZE_KEYS = (("image_width", "image_Width", "width"), ("image_height", "image_Height", "height"))


def _bouguet(path: Path) -> CameraCalibration:
    """fc, cc, kc (k1 k2 p1 p2 k3), alpha_c (skew over fc(1)), nx, ny."""
    from scipy.io import loadmat

    try:
        content: dict[str, Any] = loadmat(path, variable_names=["fc", "cc", "kc", "alpha_c", "nx", "ny"])
    except OSError:
        raise
    except Exception as error:  # whatever the reader meets in a damaged file
        raise UserError(f"{path}: is not a MATLAB file, or damaged ({' '.join(str(error).split())}); save the calibration again") from error
    values = {
        key: [float(x) for x in value.ravel()] for key, value in content.items() if not key.startswith("_") and value.dtype.kind in "fiu"
    }
    for key, count in (("fc", 2), ("cc", 2), ("kc", 5), ("nx", 1), ("ny", 1)):
        if len(values.get(key, [])) != count:
            raise UserError(
                f"{path}: {key} is missing or not of {count} numbers; a Calib_Results.mat of Bouguet's toolbox has fc, cc, kc, nx, ny"
            )
    skew = values.get("alpha_c", [0.0])[0] * values["fc"][0]
    distortion = tuple(values["kc"])
    lens: Lens = "brown" if any(distortion) else "pinhole"
    width, height = (_whole(values[key][0], key, path) for key in ("nx", "ny"))
    (focal_x, focal_y), (centre_x, centre_y) = values["fc"], values["cc"]
    return CameraCalibration(width, height, focal_x, focal_y, centre_x, centre_y, skew, lens, distortion if lens == "brown" else ())


def _numbers(content: Mapping[str, Any], key: str, path: Path, count: int) -> list[float]:
    found = _flat(content.get(key))
    if found is None or len(found) != count:
        raise UserError(f"{path}: {key} must be {count} numbers")
    return found


def _flat(value: Any) -> list[float] | None:
    """The numbers of a list, of a list of rows, or of the data of a matrix."""
    if isinstance(value, dict):
        value = value.get("data")
    if not isinstance(value, list):
        return None
    flat = [entry for row in value for entry in (row if isinstance(row, list) else [row])]
    if not all(isinstance(entry, int | float) and not isinstance(entry, bool) for entry in flat):
        return None
    return [float(entry) for entry in flat]


def _distortion(model: str, value: Any, key: str, path: Path) -> tuple[Lens, tuple[float, ...]]:
    if model not in _LENSES:
        raise UserError(f"{path}: distortion_model '{model}' is not known here; known are plumb_bob (radtan) and equidistant (fisheye)")
    lens, most = _LENSES[model]
    coefficients = _flat(value)
    if coefficients is None:
        raise UserError(f"{path}: {key} must be a list of numbers")
    if any(coefficient != 0.0 for coefficient in coefficients[most:]):
        raise UserError(
            f"{path}: {key} has {len(coefficients)} coefficients and only the first {most} of this model are known here; "
            "calibrate without the rational, thin prism and tilted models"
        )
    kept = tuple(coefficients[:most])
    return (lens, kept) if any(kept) or lens == "equidistant" else ("pinhole", ())


def _whole(value: Any, key: str, path: Path) -> int:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value) or value != int(value):
        raise UserError(f"{path}: {key} must be a whole number of pixels")
    return int(value)


def _check(calibration: CameraCalibration, path: Path) -> None:
    from dataclasses import asdict

    from ssjs_cli import _core

    if calibration.width_px * calibration.height_px > MAX_PIXELS:
        raise UserError(
            f"{path}: is of {calibration.width_px} x {calibration.height_px} pixels, more than {MAX_PIXELS / 1e6:.0f} million; "
            "give the size of the frames that were calibrated"
        )
    try:
        _core.check_calibration(asdict(calibration))
    except ValueError as error:
        raise UserError(f"{path}: {error}; correct its camera matrix or coefficients, or calibrate again") from error
