"""The options that the commands of segmentation share."""

from typing import TYPE_CHECKING, Any

import click

from ssjs_cli.options import options, path_of, settings_options

if TYPE_CHECKING:
    from ssjs_cli.segmentation.settings import SettingsRequest


segmentation_options = options(
    click.option("--preset", default=None, metavar="NAME", help="auto (default), sss-high, sss-low, fls, best; --set goes over it."),
    click.option("--mask", "valid_mask", type=click.Path(), default=None, metavar="FILE|DIR", help="Where pixels are valid."),
    click.option("--invalid-value", type=int, default=None, metavar="LEVEL", help="Pixels of exactly this level are invalid."),
    click.option("--padding", "padding_level", type=int, default=None, metavar="LEVEL", help="Dark border areas are invalid."),
    settings_options,
)


def settings_request(given: dict[str, Any]) -> "SettingsRequest":
    """What the options say about settings; commands without one of them leave it unsaid."""
    from ssjs_cli.segmentation.settings import SettingsRequest

    return SettingsRequest(
        method=given.get("method"),
        preset=given["preset"],
        objects=given.get("objects"),
        nadir=given.get("nadir"),
        pixel_size=given.get("pixel_size"),
        invalid_value=given["invalid_value"],
        padding_level=given["padding_level"],
        altitude_m=given.get("altitude_m"),
        config_path=path_of(given["config_path"]),
        assignments=given["assignments"],
        seed=given["seed"],
    )
