"""A cascade from a file, with the numbers that its training left for its users."""

import functools
from dataclasses import dataclass
from pathlib import Path

from ssjs_cli import _core
from ssjs_cli.cascade.preparation import BORDER_KEY, SMOOTHING_KEY, Preparation
from ssjs_cli.errors import UserError, describe_os_error
from ssjs_cli.formats.file_digest import file_digest

MODEL_FILE = "cascade.json"
XML_FILE = "cascade.xml"
MEAN_FILE = "mean_positive.png"
MARGIN_SETTING = "window.margin"


@dataclass(frozen=True)
class Model:
    """margin: part of an object's size that the windows hold on each side of it; preparation: of pictures; digest: of the file."""

    path: Path
    cascade: _core.HaarCascade
    margin: float
    preparation: Preparation
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
    preparation = Preparation(int(_number(cascade, SMOOTHING_KEY, 1.0)), int(_number(cascade, BORDER_KEY, 0.0)))
    return Model(path, cascade, _number(cascade, MARGIN_SETTING, 0.0), preparation, digest)


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
