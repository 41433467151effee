"""The options that the commands of segmentation share."""

from collections.abc import Callable
from typing import Any

import click


def settings_options(command: Callable[..., Any]) -> Callable[..., Any]:
    for option in (
        click.option("--set", "assignments", multiple=True, metavar="KEY=VALUE", help="One setting by its full key; may be repeated."),
        click.option("--config", "config_path", type=click.Path(), default=None, help="TOML file, such as the config.toml of a result."),
        click.option("--nadir", default=None, metavar="left|middle|right|COLUMN", help="Where the sonar passed; across-track 0."),
        click.option("--pixel-size-m", "pixel_size", default=None, metavar="ALONG,ACROSS", help="Size of a pixel on the seabed."),
        click.option(
            "--padding", "padding_level", type=int, default=None, metavar="LEVEL", help="Dark pixels joined to the border are invalid."
        ),
        click.option("--invalid-value", type=int, default=None, metavar="LEVEL", help="Pixels of exactly this level are invalid."),
        click.option("--preset", default=None, metavar="NAME", help="auto (default), sss-high, sss-low, fls, best; --set goes over it."),
    ):
        command = option(command)
    return command
