"""Pictures of a run inside its page: smaller than their files, because a page is looked at and not measured."""

import io
from pathlib import Path
from typing import TYPE_CHECKING

from ssjs_cli.errors import UserError
from ssjs_cli.report.page_parts import data_url

if TYPE_CHECKING:
    from PIL import Image


def jpeg_url(path: Path, quality: int, width_px: int | None = None, *, upside_down: bool = False) -> str:
    """As JPEG, no wider than width_px; upside_down for who draws rows upwards. Throws UserError on a file that is no picture."""
    from PIL import Image, UnidentifiedImageError

    try:
        with Image.open(path) as image:
            image.load()
            picture = image if image.mode in ("L", "RGB") else image.convert("RGB")
    except (OSError, UnidentifiedImageError, Image.DecompressionBombError) as error:
        raise UserError(f"{path}: is not a readable picture ({error}); run the mission again") from error
    if width_px is not None and picture.width > width_px:
        height_px = max(round(picture.height * width_px / picture.width), 1)
        picture = picture.resize((width_px, height_px), Image.Resampling.BOX)
    if upside_down:
        picture = picture.transpose(Image.Transpose.FLIP_TOP_BOTTOM)
    return picture_url(picture, quality)


def picture_url(picture: "Image.Image", quality: int) -> str:
    file = io.BytesIO()
    picture.save(file, format="JPEG", quality=quality, optimize=True)
    return data_url(file.getvalue(), "image/jpeg")
