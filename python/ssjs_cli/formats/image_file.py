"""Sonar pictures from image files. The file is looked at before it is decoded: what kind it is, and how large the picture would be.

Read: PNG, JPEG, TIFF and BigTIFF, BMP, PBM/PGM/PPM, GIF, WebP, JPEG 2000. Formats that start other programs (EPS, WMF) are not. Only
regular files are opened, so a pipe cannot keep the program waiting. Rows and columns are those of the file: orientation tags of cameras
do not turn a sonar picture.
"""

import os
import stat
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import tifffile
from numpy.typing import NDArray
from PIL import Image, UnidentifiedImageError

from ssjs_cli.errors import UserError, describe_os_error
from ssjs_cli.formats.image_levels import SET, LevelImage, Levels, Mask, levels_of

#: A picture of 22,360 x 22,360 pixels; 0.5 GB in 8 bits, and the segmentation takes up to eight bytes a pixel besides.
MAX_PIXELS = 500_000_000
FORMATS = ("PNG", "JPEG", "TIFF", "BMP", "PPM", "GIF", "WEBP", "JPEG2000")
SUFFIXES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".pbm", ".pgm", ".ppm", ".pnm", ".gif", ".webp", ".jp2")
#: A mask with a value from here on is a picture of black and white; others hold 0 and 1, or numbers of classes.
HALF_SCALE = 128

_TIFF_STARTS = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
_TIFF_BITS, _TIFF_CHANNELS = 258, 277
#: Pixel modes whose arrays are levels as they stand; all others are converted to colour first.
_PLAIN_MODES = ("1", "L", "LA", "I", "I;16", "I;16B", "I;16L", "I;16N", "F", "RGB", "RGBA")


def read_image(path: Path, *, page: int = 1) -> LevelImage:
    """page: of a file with several pictures, from 1; they are independent of each other. Raises UserError."""
    _check_file(path)
    try:
        with _opened(path) as picture:
            if _has_deep_colours(picture):
                return _read_scientific_tiff(path, page)
            notes = _turn_to_page(picture, page, path)
            _check_size(picture.width, picture.height, path)
            picture.load()
            if picture.mode not in _PLAIN_MODES:
                picture = _in_colour(picture)
            made = levels_of(_pillow_rows(picture), picture.height, picture.width)
            return LevelImage(made.levels, made.valid, (*notes, *made.notes))
    except UserError:
        raise
    except UnidentifiedImageError as error:
        if _starts_as_tiff(path):
            return _read_scientific_tiff(path, page)
        raise UserError(f"{path}: is not an image of a known kind ({', '.join(FORMATS)}); convert it to PNG or TIFF") from error
    except MemoryError as error:
        raise UserError(f"{path}: does not fit into the memory; free some, or cut the picture into pieces") from error
    except Exception as error:  # whatever a decoder meets in a damaged file
        raise UserError(f"{path}: is damaged or cut off ({_first_line(error)}); copy or export it again") from error


def read_mask(path: Path) -> Mask:
    """(h, w), 255 where set. Black and white: set above 127; values below 128 alone (0 and 1, numbers of classes): set above 0.
    Alpha is left aside, of colours the first counts."""
    _check_file(path)
    try:
        with _opened(path) as picture:
            _check_size(picture.width, picture.height, path)
            values = np.asarray(picture.convert("RGB") if picture.mode in ("P", "PA") and _has_colours(picture) else picture)
    except UserError:
        raise
    except MemoryError as error:
        raise UserError(f"{path}: does not fit into the memory; free some, or cut the picture into pieces") from error
    except Exception as error:  # whatever a decoder meets in a damaged file
        raise UserError(f"{path}: is no readable mask ({_first_line(error)}); give a PNG that is 0 outside and 255 inside") from error
    channel = values if values.ndim == 2 else values[:, :, 0]
    if channel.dtype.kind == "b":
        return np.where(channel, SET, 0).astype(np.uint8)
    limit = HALF_SCALE - 1 if channel.size and channel.max() >= HALF_SCALE else 0
    return np.where(channel > limit, SET, 0).astype(np.uint8)


def write_png(path: Path, pixels: Levels | NDArray[np.uint8]) -> None:
    """(h, w) of 8 or 16 bits, or (h, w, 3)."""
    Image.fromarray(np.ascontiguousarray(pixels)).save(path, format="PNG", compress_level=6)


def _check_file(path: Path) -> None:
    try:
        state = os.stat(path)
    except OSError as error:
        raise UserError(describe_os_error(error, str(path))) from error
    if stat.S_ISDIR(state.st_mode):
        raise UserError(f"{path}: is a folder; name an image")
    if not stat.S_ISREG(state.st_mode):
        raise UserError(f"{path}: is no regular file; name an image on a disk")
    if state.st_size == 0:
        raise UserError(f"{path}: is empty (0 bytes); copy or export it again")


@contextmanager
def _opened(path: Path) -> Iterator[Image.Image]:
    """Pillow's limit on the size of a picture stands aside for ours, which is checked before anything is decoded."""
    limit = Image.MAX_IMAGE_PIXELS
    Image.MAX_IMAGE_PIXELS = None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of odd tags; what cannot be decoded raises
            with Image.open(path, formats=FORMATS) as picture:
                yield picture
    finally:
        Image.MAX_IMAGE_PIXELS = limit


def _check_size(width_px: int, height_px: int, path: Path) -> None:
    if width_px < 1 or height_px < 1:
        raise UserError(f"{path}: has no pixels ({width_px} x {height_px}); export it again")
    if width_px * height_px > MAX_PIXELS:
        raise UserError(
            f"{path}: has {width_px} x {height_px} pixels, and {MAX_PIXELS / 1e6:.0f} million are the most; cut it into pieces that overlap"
        )


def _turn_to_page(picture: Image.Image, page: int, path: Path) -> list[str]:
    pages = int(getattr(picture, "n_frames", 1))
    if page > pages:
        raise UserError(f"{path}: has no page {page}, it holds {pages}; choose another page")
    if page > 1:
        picture.seek(page - 1)
    return [] if pages == 1 else [f"page {page} of {pages}"]


def _has_deep_colours(picture: Image.Image) -> bool:
    """TIFF of several channels of more than 8 bits, which Pillow would halve or mix up."""
    if picture.format != "TIFF":
        return False
    tags: Any = getattr(picture, "tag_v2", {})
    bits = tags.get(_TIFF_BITS, (1,))
    return int(tags.get(_TIFF_CHANNELS, 1)) > 1 and max(bits if isinstance(bits, tuple) else (bits,)) > 8


def _has_colours(picture: Image.Image) -> bool:
    colours = np.asarray(picture.getpalette("RGB") or [], dtype=np.uint8).reshape(-1, 3)
    return bool((colours != colours[:, :1]).any()) or not np.array_equal(colours[:, 0], np.arange(len(colours)))


def _in_colour(picture: Image.Image) -> Image.Image:
    transparent = "transparency" in picture.info or picture.mode in ("PA", "La", "RGBa")
    return picture.convert("RGBA" if transparent else "RGB")


def _pillow_rows(picture: Image.Image) -> Any:
    def rows(first: int, last: int) -> NDArray[Any]:
        values = np.asarray(picture.crop((0, first, picture.width, last)))
        return values.astype(values.dtype.newbyteorder("="), copy=False)

    return rows


def _starts_as_tiff(path: Path) -> bool:
    with path.open("rb") as file:
        return file.read(4) in _TIFF_STARTS


def _read_scientific_tiff(path: Path, page: int) -> LevelImage:
    """TIFF of kinds that pictures for the eye do not have: 64-bit reals, 16-bit colours in planes, and so on."""
    try:
        with tifffile.TiffFile(path) as file:
            pages = len(file.pages)
            if page > pages:
                raise UserError(f"{path}: has no page {page}, it holds {pages}; choose another page")
            chosen: Any = file.pages[page - 1]
            _check_size(int(chosen.imagewidth), int(chosen.imagelength), path)
            values = np.asarray(chosen.asarray())
            if values.ndim == 3 and chosen.planarconfig == tifffile.PLANARCONFIG.SEPARATE:
                values = np.moveaxis(values, 0, -1)
            made = levels_of(lambda first, last: values[first:last], values.shape[0], values.shape[1])
            notes = [] if pages == 1 else [f"page {page} of {pages}"]
            return LevelImage(made.levels, made.valid, (*notes, *made.notes))
    except UserError:
        raise
    except MemoryError as error:
        raise UserError(f"{path}: does not fit into the memory; free some, or cut the picture into pieces") from error
    except Exception as error:  # whatever a decoder meets in a damaged file
        raise UserError(
            f"{path}: is damaged, or TIFF of an unknown kind ({_first_line(error)}); convert it to PNG or plain TIFF"
        ) from error


def _first_line(error: BaseException) -> str:
    return (str(error).splitlines() or [""])[0] or type(error).__name__
