"""The settings that tell where a picture's pixels lie on the seabed: their size, and where the sonar passed."""

from collections.abc import Mapping

from ssjs_cli.config import FieldDescription, Layer, Scalar
from ssjs_cli.errors import UserError

PIXEL_ALONG_KEY = "image.pixel_along_m"
PIXEL_ACROSS_KEY = "image.pixel_across_m"
NADIR_KEY = "image.nadir"
NADIR_COLUMN_KEY = "image.nadir_column"
NO_NADIR, LEFT, MIDDLE, RIGHT, COLUMN = "none", "left", "middle", "right", "column"

GROUND_FIELDS = (
    FieldDescription(PIXEL_ALONG_KEY, "optional_float", None, (), "must be positive", "height of a pixel on the seabed, along the track"),
    FieldDescription(PIXEL_ACROSS_KEY, "optional_float", None, (), "must be positive", "width of a pixel on the seabed, across the track"),
    FieldDescription(NADIR_KEY, "choice", NO_NADIR, (NO_NADIR, LEFT, MIDDLE, RIGHT, COLUMN), "", "where the sonar passed"),
    FieldDescription(
        NADIR_COLUMN_KEY, "optional_int", None, (), "must not be negative",
        "first column to starboard of the sonar's path, where nadir is 'column'",
    ),
)  # fmt: skip


def ground_violations(values: Mapping[str, Scalar]) -> list[str]:
    found = []
    for key in (PIXEL_ALONG_KEY, PIXEL_ACROSS_KEY):
        value = values[key]
        if value is not None and not 0.0 < float(value) < float("inf"):
            found.append(f"{key} = {value}: must be positive")
    if (values[PIXEL_ALONG_KEY] is None) != (values[PIXEL_ACROSS_KEY] is None):
        found.append(f"{PIXEL_ALONG_KEY} and {PIXEL_ACROSS_KEY}: are given together or not at all")
    column = values[NADIR_COLUMN_KEY]
    if column is not None and int(column) < 0:
        found.append(f"{NADIR_COLUMN_KEY} = {column}: must not be negative")
    if (values[NADIR_KEY] == COLUMN) != (column is not None):
        found.append(f"{NADIR_COLUMN_KEY}: is given exactly where {NADIR_KEY} is '{COLUMN}'")
    return found


def ground_layers(nadir: str | None, pixel_size: str | None) -> list[Layer]:
    """Of --nadir and --pixel-size-m; None: not given."""
    return [_nadir_layer(nadir), _pixel_size_layer(pixel_size)]


def _nadir_layer(text: str | None) -> Layer:
    if text is None:
        return Layer("--nadir", {})
    if text in (NO_NADIR, LEFT, MIDDLE, RIGHT):
        return Layer("--nadir", {NADIR_KEY: text, NADIR_COLUMN_KEY: None})
    try:
        return Layer("--nadir", {NADIR_KEY: COLUMN, NADIR_COLUMN_KEY: int(text)})
    except ValueError as error:
        raise UserError(f"--nadir {text}: must be left, middle, right, none or a column, counted from 0") from error


def _pixel_size_layer(text: str | None) -> Layer:
    if text is None:
        return Layer("--pixel-size-m", {})
    try:
        along_m, across_m = (float(number) for number in text.split(","))
    except ValueError as error:
        raise UserError(f"--pixel-size-m {text}: must be two numbers ALONG,ACROSS, for example 0.05,0.02") from error
    return Layer("--pixel-size-m", {PIXEL_ALONG_KEY: along_m, PIXEL_ACROSS_KEY: across_m})


def nadir_column(values: Mapping[str, Scalar], width_px: int) -> int | None:
    """The first column to starboard, 0 to width; None: not given."""
    places = {NO_NADIR: None, LEFT: 0, MIDDLE: (width_px + 1) // 2, RIGHT: width_px}
    place = str(values[NADIR_KEY])
    if place in places:
        return places[place]
    return int(values[NADIR_COLUMN_KEY] or 0)


def nadir_column_in(values: Mapping[str, Scalar], width_px: int, name: str) -> int | None:
    """nadir_column(), which must lie in the picture called `name`. Raises UserError."""
    column = nadir_column(values, width_px)
    if column is not None and column > width_px:
        raise UserError(f"{name}: has {width_px} columns, and --nadir {column} lies outside; give another column")
    return column
