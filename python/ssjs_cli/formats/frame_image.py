"""One frame of a camera from its file: 8 bits, grey or colour. What cannot be read is told in a few words, for a frame that is left out."""

import io
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, UnidentifiedImageError

SUFFIXES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".pgm", ".ppm", ".webp")
FORMATS = ("PNG", "JPEG", "TIFF", "BMP", "PPM", "WEBP")
#: Of one frame: no camera under water takes more, and two at a time must fit into the memory.
MAX_PIXELS = 80_000_000
MAX_BYTES = 512 * 1024 * 1024

Frame = NDArray[np.uint8]

warnings.simplefilter("ignore", Image.DecompressionBombWarning)  # decoded() looks at the size itself, before any pixel is read


class FrameError(Exception):
    """Why a frame cannot be read."""


def frame_bytes(path: Path) -> bytes:
    if not path.exists():
        raise FrameError("is missing")
    if not path.is_file():
        raise FrameError("is no regular file")
    try:
        if path.stat().st_size > MAX_BYTES:
            raise FrameError(f"holds more than {MAX_BYTES} bytes")
        data = path.read_bytes()
    except OSError as error:
        raise FrameError(f"cannot be read ({error.strerror})") from error
    if not data:
        raise FrameError("is empty (0 bytes)")
    return data


def frame_size_px(path: Path) -> tuple[int, int] | None:
    """Width and height as its file says, without reading the pixels; None where it does not."""
    try:
        with Image.open(path, formats=FORMATS) as picture:
            return picture.width, picture.height
    except Exception:  # why it cannot be read is told by who reads it
        return None


def decoded(data: bytes) -> Frame:
    """(rows, columns) or (rows, columns, 3: red, green, blue); of 16 bits the upper eight, of alpha nothing."""
    try:
        with Image.open(io.BytesIO(data), formats=FORMATS) as picture:
            if picture.width * picture.height > MAX_PIXELS:
                raise FrameError(f"has {picture.width} x {picture.height} pixels, more than {MAX_PIXELS / 1e6:.0f} million")
            picture.load()
            return _levels(picture)
    except FrameError:
        raise
    except Image.DecompressionBombError as error:
        raise FrameError(f"has more than {MAX_PIXELS / 1e6:.0f} million pixels") from error
    except UnidentifiedImageError as error:
        raise FrameError(f"is no image of a known kind ({', '.join(FORMATS)})") from error
    except Exception as error:  # whatever a decoder meets in a damaged file
        raise FrameError(f"is damaged or cut off ({(str(error).splitlines() or [type(error).__name__])[0]})") from error


def _levels(picture: Any) -> Frame:
    if picture.mode in ("L", "RGB"):
        return np.asarray(picture)
    if picture.mode.startswith("I;16") or picture.mode == "I":
        values = np.asarray(picture).astype(np.int64)
        return np.clip(values >> 8 if values.max(initial=0) > 255 else values, 0, 255).astype(np.uint8)
    grey = picture.mode in ("1", "LA", "F")
    return np.asarray(picture.convert("L" if grey else "RGB"))
