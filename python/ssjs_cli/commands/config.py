"""ssjs-cli config: the settings as text, as a schema, and files checked."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from ssjs_cli.exit_codes import DONE
from ssjs_cli.options import common_options
from ssjs_cli.session import Session

if TYPE_CHECKING:
    from ssjs_cli.config import SettingsKind

OF_RUN, OF_UNDERWATER, OF_FRAMES, OF_SEGMENTATION, OF_PICTURES = "run", "underwater", "frames", "segmentation", "pictures"
_MISSIONS = {OF_RUN: "in the plane", OF_UNDERWATER: "under water", OF_FRAMES: "of frames alone"}


def _kind_option(command: Callable[..., Any]) -> Callable[..., Any]:
    text = (
        "Settings of `run` and its studies on land, of `run` under water or with frames alone, of `segment`, or of the pictures of "
        "aekf-loop-images."
    )
    return click.option(
        "--of",
        "kind_name",
        type=click.Choice((OF_RUN, OF_UNDERWATER, OF_FRAMES, OF_SEGMENTATION, OF_PICTURES)),
        default=OF_RUN,
        show_default=True,
        help=text,
    )(command)


def _kind(name: str) -> "SettingsKind":
    if name == OF_SEGMENTATION:
        from ssjs_cli.segmentation.settings import SEGMENTATION

        return SEGMENTATION
    if name == OF_PICTURES:
        from ssjs_cli.sonar_loop import PICTURES

        return PICTURES
    if name == OF_FRAMES:
        from ssjs_cli.optical.frame_settings import FRAMES_ALONE

        return FRAMES_ALONE
    from ssjs_cli.config import ESTIMATOR, UNDERWATER

    return UNDERWATER if name == OF_UNDERWATER else ESTIMATOR


@click.group()
def config() -> None:
    """The settings: defaults, JSON schema, a file checked."""


def _deliver(session: Session, text: str, out: str | None, force: bool) -> int:
    """The text on stdout, or in a file."""
    from ssjs_cli.errors import UserError
    from ssjs_cli.formats.atomic import write_file

    if out is None:
        click.echo(text, nl=False)
        return DONE
    target = Path(out)
    if target.exists() and not force:
        raise UserError(f"{target}: exists already; choose another --out, or replace it with --force")
    target.parent.mkdir(parents=True, exist_ok=True)
    write_file(target, text)
    session.answer({"written": str(target)}, str(target))
    return DONE


@config.command()
@_kind_option
@click.option("--config", "config_path", type=click.Path(), default=None, help="Settings laid over the defaults.")
@click.option("--set", "assignments", multiple=True, metavar="KEY=VALUE", help="One setting by its full key; may be repeated.")
@common_options(out_help="File to write (default: stdout).")
@click.pass_obj
def dump(
    session: Session,
    kind_name: str,
    config_path: str | None,
    assignments: tuple[str, ...],
    seed: int | None,
    force: bool,
    out: str | None,
) -> int:
    """Print every setting as TOML (with --json as JSON), ready for `run --config` or `segment --config`."""
    from ssjs_cli.config import DEFAULT_SEED, SEED_KEY, layer_from_assignments, layer_from_file, nest, resolve

    kind = _kind(kind_name)
    layers, file_seed = [], None
    if config_path is not None:
        layer, file_seed = layer_from_file(Path(config_path), kind)
        layers.append(layer)
    settings = resolve([*layers, layer_from_assignments(assignments, kind)], kind)
    chosen = seed if seed is not None else DEFAULT_SEED if file_seed is None else file_seed
    if session.json_output and out is None:
        return _deliver(session, json.dumps({SEED_KEY: chosen, **nest(settings.values)}, indent=2) + "\n", out, force)
    return _deliver(session, settings.to_toml(chosen), out, force)


@config.command()
@_kind_option
@common_options(out_help="File to write (default: stdout).")
@click.pass_obj
def schema(session: Session, kind_name: str, seed: int | None, force: bool, out: str | None) -> int:
    """Print the JSON schema of the settings."""
    from ssjs_cli.config import json_schema

    return _deliver(session, json.dumps(json_schema(_kind(kind_name)), indent=2) + "\n", out, force)


@config.command()
@click.argument("file", type=click.Path())
@_kind_option
@common_options(out_help="Not used: nothing is written.")
@click.pass_context
def check(context: click.Context, file: str, kind_name: str, seed: int | None, force: bool, out: str | None) -> int:
    """Check FILE: a configuration file, a mission.toml or a mission directory, whose own files tell --of."""
    from ssjs_cli.config import Layer, layer_from_file, layer_from_tables, resolve
    from ssjs_cli.errors import UserError
    from ssjs_cli.formats.mission import MISSION_FILE, holds_frames_alone, is_underwater, read_mission_document

    path = Path(file)
    if path.is_dir():
        path = path / MISSION_FILE
    layer: Layer
    if path.name == MISSION_FILE and kind_name != OF_SEGMENTATION:
        own = OF_FRAMES if holds_frames_alone(path.parent) else OF_UNDERWATER if is_underwater(path.parent) else OF_RUN
        if context.get_parameter_source("kind_name") is ParameterSource.COMMANDLINE and kind_name != own:
            raise UserError(f"--of {kind_name}: {path} is of a mission {_MISSIONS[own]}; give --of {own}, or leave it out")
        kind = _kind(own)
        layer = layer_from_tables(read_mission_document(path).settings, f"{path} [settings]", kind)
    else:
        kind = _kind(kind_name)
        layer, _ = layer_from_file(path, kind)
    resolve([layer], kind)
    session: Session = context.obj
    changed: dict[str, Any] = dict(layer.values)
    session.answer({"file": str(path), "valid": True, "settings": changed}, f"{path}: valid, {len(changed)} settings given")
    return DONE
