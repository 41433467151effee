import io
import os
import struct
import threading
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import tifffile
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from ssjs_cli.errors import UserError
from ssjs_cli.formats import image_file
from ssjs_cli.formats.image_file import read_image, read_mask, write_png

RAMP = np.arange(12, dtype=np.uint8).reshape(3, 4)


def refused(read: Callable[[Path], object], path: Path) -> str:
    with pytest.raises(UserError) as caught:
        read(path)
    message = str(caught.value)
    assert message.startswith(str(path)), "a message names the file"
    assert ";" in message, "a message names the mend"
    return message


def saved(path: Path, array: np.ndarray, mode: str | None = None) -> Path:
    picture = Image.fromarray(array)
    (picture if mode is None else picture.convert(mode)).save(path)
    return path


@pytest.mark.parametrize("suffix", ["png", "tif", "bmp", "pgm", "gif"])
def test_grey_of_8_bits_is_kept(tmp_path: Path, suffix: str) -> None:
    image = read_image(saved(tmp_path / f"a.{suffix}", 20 * RAMP))
    assert image.levels.dtype == np.uint8
    np.testing.assert_array_equal(image.levels, 20 * RAMP)
    assert image.valid is None
    assert (image.width_px, image.height_px, image.bits, image.notes) == (4, 3, 8, ())


@pytest.mark.parametrize("suffix", ["png", "tif"])
def test_grey_of_16_bits_is_kept(tmp_path: Path, suffix: str) -> None:
    image = read_image(saved(tmp_path / f"a.{suffix}", 5000 * RAMP.astype(np.uint16)))
    assert (image.levels.dtype, image.bits) == (np.uint16, 16)
    np.testing.assert_array_equal(image.levels, 5000 * RAMP.astype(np.uint16))


def test_the_other_byte_order_is_read(tmp_path: Path) -> None:
    tifffile.imwrite(tmp_path / "a.tif", 5000 * RAMP.astype(">u2"), byteorder=">")
    np.testing.assert_array_equal(read_image(tmp_path / "a.tif").levels, 5000 * RAMP.astype(np.uint16))


def test_one_bit_becomes_black_and_white(tmp_path: Path) -> None:
    image = read_image(saved(tmp_path / "a.png", np.where(RAMP % 2 == 1, 255, 0).astype(np.uint8), "1"))
    np.testing.assert_array_equal(image.levels, np.where(RAMP % 2 == 1, 255, 0))


def test_equal_channels_are_grey_and_others_become_luminance(tmp_path: Path) -> None:
    grey = np.repeat(RAMP[:, :, np.newaxis], 3, axis=2)
    image = read_image(saved(tmp_path / "grey.png", grey))
    np.testing.assert_array_equal(image.levels, RAMP)
    assert image.notes == ()
    colour = np.array([[[200, 100, 50], [0, 255, 0]]], dtype=np.uint8)
    image = read_image(saved(tmp_path / "colour.png", colour))
    # 0.299 x 200 + 0.587 x 100 + 0.114 x 50 = 124.2; 0.587 x 255 = 149.685
    np.testing.assert_array_equal(image.levels, [[124, 150]])
    assert image.notes == ("colour reduced to its luminance",)


def test_transparent_pixels_are_invalid(tmp_path: Path) -> None:
    alpha = np.array([[[9, 9, 9, 0], [9, 9, 9, 1]], [[9, 9, 9, 255], [9, 9, 9, 128]]], dtype=np.uint8)
    np.testing.assert_array_equal(read_image(saved(tmp_path / "rgba.png", alpha)).valid, [[0, 255], [255, 255]])
    np.testing.assert_array_equal(read_image(saved(tmp_path / "la.png", alpha, "LA")).valid, [[0, 255], [255, 255]])
    opaque = alpha | np.array([0, 0, 0, 255], dtype=np.uint8)
    assert read_image(saved(tmp_path / "opaque.png", opaque)).valid is None


def test_a_palette_is_looked_up(tmp_path: Path) -> None:
    picture = Image.fromarray(np.array([[0, 1]], dtype=np.uint8), mode="P")
    picture.putpalette([10, 10, 10, 200, 200, 200])
    picture.save(tmp_path / "a.png")
    np.testing.assert_array_equal(read_image(tmp_path / "a.png").levels, [[10, 200]])
    picture.save(tmp_path / "b.png", transparency=1)
    np.testing.assert_array_equal(read_image(tmp_path / "b.png").valid, [[255, 0]])


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_real_numbers_are_drawn_out_over_their_valid_range(tmp_path: Path, dtype: type) -> None:
    values = np.array([[-1.0, 0.0, np.nan], [1.0, 3.0, np.inf]], dtype=dtype)
    tifffile.imwrite(tmp_path / "a.tif", values)
    image = read_image(tmp_path / "a.tif")
    # (v + 1) / 4 x 65535
    np.testing.assert_array_equal(image.levels, [[0, 16384, 0], [32768, 65535, 0]])
    np.testing.assert_array_equal(image.valid, [[255, 255, 0], [255, 255, 0]])
    assert image.notes == ("values from -1 to 3 drawn out to 16 bits",)


def test_reals_without_a_valid_pixel_or_of_one_value_have_no_levels(tmp_path: Path) -> None:
    tifffile.imwrite(tmp_path / "nan.tif", np.full((2, 3), np.nan, dtype=np.float32))
    image = read_image(tmp_path / "nan.tif")
    assert image.valid is not None
    assert not image.valid.any()
    tifffile.imwrite(tmp_path / "flat.tif", np.full((2, 3), 7.5, dtype=np.float32))
    flat = read_image(tmp_path / "flat.tif")
    assert not flat.levels.any()
    assert flat.valid is None


def test_the_whole_range_of_reals_does_not_overflow(tmp_path: Path) -> None:
    largest = np.finfo(np.float64).max
    tifffile.imwrite(tmp_path / "a.tif", np.array([[-largest, 0.0, largest]]))
    np.testing.assert_array_equal(read_image(tmp_path / "a.tif").levels, [[0, 32768, 65535]])


def test_whole_numbers_that_fit_keep_their_values(tmp_path: Path) -> None:
    tifffile.imwrite(tmp_path / "fits.tif", 1000 * RAMP.astype(np.int32))
    np.testing.assert_array_equal(read_image(tmp_path / "fits.tif").levels, 1000 * RAMP.astype(np.uint16))
    tifffile.imwrite(tmp_path / "signed.tif", np.array([[-10, 0, 10]], dtype=np.int16))
    np.testing.assert_array_equal(read_image(tmp_path / "signed.tif").levels, [[0, 32768, 65535]])


@pytest.mark.parametrize("planes", ["separate", "contig"])
def test_colours_of_16_bits_are_read_in_planes_and_side_by_side(tmp_path: Path, planes: str) -> None:
    colours = np.stack([np.full((3, 4), 60000), np.full((3, 4), 30000), np.full((3, 4), 10000)]).astype(np.uint16)
    laid_out = colours if planes == "separate" else np.moveaxis(colours, 0, -1)
    tifffile.imwrite(tmp_path / "a.tif", laid_out, photometric="rgb", planarconfig=planes)
    image = read_image(tmp_path / "a.tif")
    # 0.299 x 60000 + 0.587 x 30000 + 0.114 x 10000
    np.testing.assert_array_equal(image.levels, np.full((3, 4), 36690, dtype=np.uint16))


def test_one_pixel_is_an_image(tmp_path: Path) -> None:
    image = read_image(saved(tmp_path / "a.png", np.array([[77]], dtype=np.uint8)))
    np.testing.assert_array_equal(image.levels, [[77]])


def test_pages_are_chosen_and_counted(tmp_path: Path) -> None:
    tifffile.imwrite(tmp_path / "a.tif", np.stack([RAMP, 2 * RAMP, 3 * RAMP]), photometric="minisblack")
    assert read_image(tmp_path / "a.tif").notes == ("page 1 of 3",)
    np.testing.assert_array_equal(read_image(tmp_path / "a.tif", page=3).levels, 3 * RAMP)
    assert "has no page 4, it holds 3" in refused(lambda path: read_image(path, page=4), tmp_path / "a.tif")


def test_what_is_no_image_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_text("not a picture")
    assert "is not an image of a known kind" in refused(read_image, tmp_path / "a.png")
    (tmp_path / "empty.png").write_bytes(b"")
    assert "is empty (0 bytes)" in refused(read_image, tmp_path / "empty.png")
    assert "No such file" in refused(read_image, tmp_path / "absent.png")
    assert "is a folder" in refused(read_image, tmp_path)


def test_formats_that_start_programs_are_not_opened(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 10 10\n(/tmp/x) (w) file\n%%EOF\n")
    assert "is not an image of a known kind" in refused(read_image, tmp_path / "a.png")


def test_a_pipe_is_refused_at_once(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "a.png")
    messages: list[str] = []
    reader = threading.Thread(target=lambda: messages.append(refused(read_image, tmp_path / "a.png")), daemon=True)
    reader.start()
    reader.join(timeout=10)
    assert messages
    assert "is no regular file" in messages[0]


def png_of_size(width_px: int, height_px: int) -> bytes:
    """A PNG that claims a size and holds next to nothing."""

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    header = struct.pack(">IIBBBBB", width_px, height_px, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(b"\0" * 8)) + chunk(b"IEND", b"")


def test_a_size_without_pixels_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(png_of_size(0, 5))
    refused(read_image, tmp_path / "a.png")
    (tmp_path / "b.pgm").write_bytes(b"P5 0 4 255\n")
    refused(read_image, tmp_path / "b.pgm")


def test_too_many_pixels_are_refused_before_they_are_decoded(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(png_of_size(60_000, 60_000))
    assert "has 60000 x 60000 pixels, and 500 million are the most" in refused(read_image, tmp_path / "a.png")


def test_pillows_own_limit_is_left_as_it_was(tmp_path: Path) -> None:
    before = Image.MAX_IMAGE_PIXELS
    read_image(saved(tmp_path / "a.png", RAMP))
    refused(read_image, tmp_path / "absent.png")
    assert before == Image.MAX_IMAGE_PIXELS


def test_a_picture_beyond_pillows_limit_and_within_ours_is_read(tmp_path: Path) -> None:
    pixels = np.zeros((10_000, 20_000), dtype=np.uint8)  # Pillow refuses from 179 million on
    pixels[-1, -1] = 9
    write_png(tmp_path / "a.png", pixels)
    image = read_image(tmp_path / "a.png")
    assert image.levels.shape == (10_000, 20_000)
    assert image.levels[-1, -1] == 9


def speckled(height_px: int, width_px: int) -> np.ndarray:
    return np.random.default_rng(3).integers(0, 256, (height_px, width_px), dtype=np.uint8)


@pytest.mark.parametrize("suffix", ["png", "jpg", "tif", "bmp", "webp"])
@settings(deadline=None, max_examples=25)
@given(kept=st.floats(0.0, 0.95))
def test_a_cut_off_file_is_refused_or_read_and_nothing_else(tmp_path_factory: pytest.TempPathFactory, suffix: str, kept: float) -> None:
    path = tmp_path_factory.mktemp("cut") / f"a.{suffix}"
    Image.fromarray(speckled(40, 50)).save(path)
    data = path.read_bytes()
    path.write_bytes(data[: int(kept * len(data))])
    with pytest.raises(UserError, match=r"a\.\w+: .*;"):
        read_image(path)


@settings(deadline=None, max_examples=200)
@given(
    data=st.binary(max_size=400), start=st.sampled_from([b"", b"\x89PNG\r\n\x1a\n", b"II*\0\x08\0\0\0", b"GIF89a", b"BM", b"P5 3 4 255\n"])
)
def test_arbitrary_bytes_are_refused_or_read_and_nothing_else(tmp_path_factory: pytest.TempPathFactory, data: bytes, start: bytes) -> None:
    path = tmp_path_factory.mktemp("bytes") / "a.png"
    path.write_bytes(start + data)
    try:
        image = read_image(path)
    except UserError as error:
        assert str(error).startswith(str(path))
    else:
        assert image.levels.size > 0


@settings(deadline=None, max_examples=150)
@given(
    changes=st.lists(st.tuples(st.floats(0, 1, exclude_max=True), st.integers(0, 255)), min_size=1, max_size=6),
    kind=st.sampled_from(["PNG", "TIFF"]),
)
def test_changed_bytes_are_refused_or_read_and_nothing_else(
    tmp_path_factory: pytest.TempPathFactory, changes: list[tuple[float, int]], kind: str
) -> None:
    buffer = io.BytesIO()
    Image.fromarray(speckled(8, 8)).save(buffer, format=kind)
    data = bytearray(buffer.getvalue())
    for place, value in changes:
        data[int(place * len(data))] = value
    path = tmp_path_factory.mktemp("changed") / "a.img"
    path.write_bytes(bytes(data))
    try:
        read_image(path)
    except UserError as error:
        assert str(error).startswith(str(path))


def test_masks_of_black_and_white_and_of_classes(tmp_path: Path) -> None:
    assert read_mask(saved(tmp_path / "classes.png", np.array([[0, 1, 11]], dtype=np.uint8))).tolist() == [[0, 255, 255]]
    assert read_mask(saved(tmp_path / "bytes.png", np.array([[3, 252, 0]], dtype=np.uint8))).tolist() == [[0, 255, 0]]
    assert read_mask(saved(tmp_path / "bits.png", np.array([[0, 255]], dtype=np.uint8), "1")).tolist() == [[0, 255]]
    opaque = np.array([[[0, 0, 0, 255], [255, 255, 255, 255]]], dtype=np.uint8)
    assert read_mask(saved(tmp_path / "alpha.png", opaque)).tolist() == [[0, 255]]


def test_a_damaged_mask_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(b"nothing")
    assert "is no readable mask" in refused(read_mask, tmp_path / "a.png")


def test_blocks_of_rows_join_without_a_seam(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ssjs_cli.formats.image_levels.BLOCK_PIXELS", 100)
    colour = np.random.default_rng(1).integers(0, 256, (31, 40, 4), dtype=np.uint8)
    colour[::3, ::2, 3] = 0
    image = read_image(saved(tmp_path / "a.png", colour))
    expected = np.rint(colour[:, :, :3].astype(float) @ [0.299, 0.587, 0.114])
    assert np.abs(image.levels.astype(float) - expected).max() <= 1
    np.testing.assert_array_equal(image.valid != 0, colour[:, :, 3] != 0)


def test_the_stated_maximum_holds_a_mosaic_of_20000_by_20000() -> None:
    assert image_file.MAX_PIXELS >= 20_000 * 20_000
