"""Contours of the labelled objects, for the model to know its kind by. docs/math/cascade.md (C-19) to (C-23)"""

from collections.abc import Sequence

from ssjs_cli import _core
from ssjs_cli.cascade.labelled_images import LabelledImage
from ssjs_cli.cascade.preparation import preparation_of
from ssjs_cli.cascade.samples import window_size
from ssjs_cli.cascade.settings import MARGIN_KEY
from ssjs_cli.cascade.window_boxes import window_box
from ssjs_cli.config import Settings
from ssjs_cli.formats.image_file import read_image

#: Fewer objects do not show how much their kind varies.
LEAST_OBJECTS = 3


def object_contours(images: Sequence[LabelledImage], settings: Settings) -> list[list[float]]:
    """The spectrum of each object whose window shows an echo, as the detector will see it: what masks draw, it does not see."""
    spectra = []
    for image in images:
        if not image.boxes:
            continue
        picture = read_image(image.listed.path)
        preparation = preparation_of(settings.values)
        levels, valid = preparation.picture(picture.levels, picture.valid)
        for box in image.boxes:
            shown = preparation.object_in_prepared(box, image.width_px, image.height_px)
            size = (levels.shape[1], levels.shape[0])
            window = window_box(shown, float(settings.values[MARGIN_KEY] or 0.0), window_size(settings), size)
            signature = None if window is None else _core.echo_signature(levels, window, valid)
            if signature is not None:
                spectra.append(signature[1])
    return spectra
