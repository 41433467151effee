"""A cascade from a file, with the numbers that its training left for its users."""

import functools
from dataclasses import dataclass
from pathlib import Path

from ssjs_cli import _core
from ssjs_cli.errors import UserError, describe_os_error
from ssjs_cli.formats.file_digest import file_digest

MODEL_FILE = "cascade.json"
XML_FILE = "cascade.xml"
MEAN_FILE = "mean_positive.png"
MARGIN_SETTING, SMOOTHING_SETTING = "window.margin", "image.smoothing_px"


@dataclass(frozen=True)
class Model:
    """margin: part of an object's size that the windows hold on each side of it; smoothing_px: pictures are averaged over so many pixels
    first; digest: of the file."""

    path: Path
    cascade: _core.HaarCascade
    margin: float
    smoothing_px: int
    digest: str


def load_model(path: Path) -> Model:
    if path.is_dir():
        path = path / MODEL_FILE
    try:
        digest = file_digest(path)
        cascade = _core.HaarCascade.load(str(path))
    except OSError as error:
        if error.errno is not None:
            raise UserError(describe_os_error(error, str(path))) from error
        raise UserError(f"{error}; give a model of `cascade train`, or OpenCV's cascade XML") from error
    except ValueError as error:
        raise UserError(f"{path}: {error}; give a model of `cascade train`, or OpenCV's cascade XML") from error
    return Model(path, cascade, _number(cascade, MARGIN_SETTING, 0.0), int(_number(cascade, SMOOTHING_SETTING, 1.0)), digest)


def _number(cascade: _core.HaarCascade, setting: str, otherwise: float) -> float:
    """otherwise: for models of other programs."""
    try:
        return float(cascade.provenance()["settings"].get(setting, otherwise))
    except ValueError:
        return otherwise


@functools.lru_cache(maxsize=2)
def cascade_from_text(text: str) -> _core.HaarCascade:
    """In a worker: once for all of its images."""
    return _core.HaarCascade.from_json(text)
