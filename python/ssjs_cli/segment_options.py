"""The options that the commands of segmentation share."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from ssjs_cli.segmentation.settings import SettingsRequest


def settings_options(command: Callable[..., Any]) -> Callable[..., Any]:
    for option in (
        click.option("--set", "assignments", multiple=True, metavar="KEY=VALUE", help="One setting by its full key; may be repeated."),
        click.option("--config", "config_path", type=click.Path(), default=None, help="TOML file, such as the config.toml of a result."),
        click.option("--padding", "padding_level", type=int, default=None, metavar="LEVEL", help="Dark border areas are invalid."),
        click.option("--invalid-value", type=int, default=None, metavar="LEVEL", help="Pixels of exactly this level are invalid."),
        click.option("--mask", "valid_mask", type=click.Path(), default=None, metavar="FILE|DIR", help="Where pixels are valid."),
        click.option("--preset", default=None, metavar="NAME", help="auto (default), sss-high, sss-low, fls, best; --set goes over it."),
    ):
        command = option(command)
    return command


def settings_request(options: dict[str, Any]) -> "SettingsRequest":
    """What the options say about settings; commands without one of them leave it unsaid."""
    from ssjs_cli.segmentation.settings import SettingsRequest

    return SettingsRequest(
        method=options.get("method"),
        preset=options["preset"],
        objects=options.get("objects"),
        nadir=options.get("nadir"),
        pixel_size=options.get("pixel_size"),
        invalid_value=options["invalid_value"],
        padding_level=options["padding_level"],
        altitude_m=options.get("altitude_m"),
        config_path=path_of(options["config_path"]),
        assignments=options["assignments"],
        seed=options["seed"],
    )


def path_of(text: str | None) -> Path | None:
    return None if text is None else Path(text)
