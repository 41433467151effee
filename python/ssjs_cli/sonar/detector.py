"""The model of a survey's detector, where it needs one."""

from collections.abc import Mapping
from pathlib import Path

from ssjs_cli.cascade.model_file import Model, load_model
from ssjs_cli.cascade.preparation import BORDER_KEY, SMOOTHING_KEY, Preparation
from ssjs_cli.config import Scalar
from ssjs_cli.errors import UserError

DETECTOR_KEY = "detector"
CASCADE = "cascade"
MODEL_KEY = "cascade_model"
VERIFY_KEY = "cascade.verify"


def detector_model(values: Mapping[str, Scalar], said: str = "sonar.") -> Model | None:
    """Of the settings of the search for contacts; None where the detector needs none. `said`: what stands before their keys, for errors."""
    if values[DETECTOR_KEY] != CASCADE:
        return None
    given = values.get(MODEL_KEY)
    if given is None:
        raise UserError(f"{said}{DETECTOR_KEY} = {CASCADE}: needs a model; give {said}{MODEL_KEY} (a cascade.json of `cascade train`)")
    model = load_model(Path(str(given)))
    if model.preparation != Preparation():
        raise UserError(
            f"{model.path}: was trained on pictures that were smoothed or continued beyond their borders, which those of a survey are not; "
            f"train with {SMOOTHING_KEY}=1 and {BORDER_KEY}=0"
        )
    if values.get(VERIFY_KEY) == "contour" and model.cascade.contours_known == 0:
        raise UserError(
            f"{model.path}: holds no contours to verify detections with; give a cascade.json trained with contour.learn = true, or set "
            f"{said}{VERIFY_KEY} to none"
        )
    return model
