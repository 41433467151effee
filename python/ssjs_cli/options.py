"""The options that several commands take."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from ssjs_cli.session import Session

MAX_SEED = 2**64 - 1


def _note_json(context: click.Context, parameter: click.Parameter, value: bool) -> bool:
    session = context.find_object(Session)
    if session is not None and value:
        session.json_output = True
    return value


def common_options(*, out_help: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """--seed, --force, --json and --out, passed on as seed, force and out; --json is kept in the session."""

    def decorate(command: Callable[..., Any]) -> Callable[..., Any]:
        for option in (
            click.option("--out", type=click.Path(), default=None, help=out_help),
            click.option(
                "--json",
                is_flag=True,
                is_eager=True,
                expose_value=False,
                callback=_note_json,
                help="Print exactly one JSON document on stdout; messages go to stderr.",
            ),
            click.option("--force", is_flag=True, help="Replace an output of ours that exists."),
            click.option("--seed", type=click.IntRange(0, MAX_SEED), default=None, help="Seed of every random draw (default 1)."),
        ):
            command = option(command)
        return command

    return decorate


Decorator = Callable[[Callable[..., Any]], Callable[..., Any]]


def options(*given: Decorator) -> Decorator:
    """Several options as one, in the order in which --help lists them."""

    def decorate(command: Callable[..., Any]) -> Callable[..., Any]:
        for option in reversed(given):
            command = option(command)
        return command

    return decorate


settings_options = options(
    click.option("--config", "config_path", type=click.Path(), default=None, help="TOML file, such as the config.toml of a result."),
    click.option("--set", "assignments", multiple=True, metavar="KEY=VALUE", help="One setting by its full key; may be repeated."),
)
pixel_size_option = click.option(
    "--pixel-size-m", "pixel_size", default=None, metavar="ALONG,ACROSS", help="Size of a pixel on the seabed, for metres."
)


def path_of(text: str | None) -> Path | None:
    return None if text is None else Path(text)
