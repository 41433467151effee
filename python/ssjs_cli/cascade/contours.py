"""Contours of the labelled objects, for the model to know its kind by. docs/math/cascade.md (C-19) to (C-24)"""

from collections.abc import Sequence

import numpy as np

from ssjs_cli import _core
from ssjs_cli.cascade.labelled_images import LabelledImage
from ssjs_cli.cascade.preparation import preparation_of
from ssjs_cli.cascade.samples import window_size
from ssjs_cli.cascade.settings import MARGIN_KEY
from ssjs_cli.cascade.sides import PictureSide
from ssjs_cli.cascade.window_boxes import intersection_over_union, object_box, window_box
from ssjs_cli.config import Settings
from ssjs_cli.formats.annotations.boxes import Box
from ssjs_cli.formats.image_file import read_image

#: Fewer objects do not show how much their kind varies.
LEAST_OBJECTS = 3
#: More images would hardly tell more; they are evenly chosen.
MOST_IMAGES = 500
#: From here on a detection is the object's.
_LEAST_IOU = 0.3


def object_contours(cascade: _core.HaarCascade, images: Sequence[LabelledImage], settings: Settings, threads: int) -> list[list[float]]:
    """The spectrum of each object whose window shows an echo. The windows are those in which the cascade finds the objects: labelled
    boxes fit better than boxes that are to be verified. The labelled one stands in for an object that is not found."""
    with_objects = [image for image in images if image.boxes]
    chosen = np.unique(np.linspace(0, len(with_objects) - 1, min(len(with_objects), MOST_IMAGES)).round().astype(int)).tolist()
    preparation = preparation_of(settings.values)
    spectra = []
    for image in (with_objects[index] for index in chosen):
        picture = read_image(image.listed.path)
        side = PictureSide(0, image.width_px, image.mirrored)
        levels, valid = side.levels_of(picture, preparation)
        detections = _core.detect_objects(cascade, levels, valid, {"side": side.as_setting}, threads)
        found = [(int(x), int(y), int(width), int(height)) for x, y, width, height in detections[:, :4].tolist()]
        size = (levels.shape[1], levels.shape[0])
        for box in image.boxes:
            shown = preparation.object_in_prepared(box, image.width_px, image.height_px)
            window = _window_on(shown, found, size, mirrored=image.mirrored, settings=settings)
            signature = None if window is None else _core.echo_signature(levels, window, valid)
            if signature is not None:
                spectra.append(signature[1])
    return spectra


def _window_on(box: Box, found: Sequence[Box], size: tuple[int, int], *, mirrored: bool, settings: Settings) -> Box | None:
    """Everything as the prepared picture of this size shows it."""
    margin = float(settings.values[MARGIN_KEY] or 0.0)
    overlaps = [intersection_over_union(object_box(window, margin, mirrored=mirrored), box) for window in found]
    if overlaps and max(overlaps) >= _LEAST_IOU:
        return found[int(np.argmax(overlaps))]
    return window_box(box, margin, window_size(settings), size)
