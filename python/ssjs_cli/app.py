"""ssjs-cli: the commands, loaded when they are called, and the one place where errors become exit codes.

0 done, 1 our fault, 2 the user's input or usage, 3 finished but part of the input was unusable, 130 interrupted.
"""

import importlib
import json
import signal
import sys
from collections.abc import Sequence
from types import FrameType
from typing import Any

import click

from ssjs_cli.errors import InterruptionError, UserError, describe_os_error
from ssjs_cli.exit_codes import DONE, INTERRUPTED, OUR_FAULT, USER_ERROR
from ssjs_cli.session import Session

# name: (module, attribute, one line of help)
COMMANDS = {
    "demo": ("ssjs_cli.commands.demo", "demo", "The built-in mission: simulate, run, report; needs no download."),
    "run": ("ssjs_cli.commands.run", "run", "A mission through SLAM to results and a report."),
    "compare": ("ssjs_cli.commands.compare", "compare", "One mission through several methods: time, accuracy, consistency."),
    "consistency": ("ssjs_cli.commands.consistency", "consistency", "A scenario under many seeds: does a method know its own error?"),
    "sweep": ("ssjs_cli.commands.sweep", "sweep", "Cost and accuracy over submap size and fusion threshold."),
    "batch": ("ssjs_cli.commands.batch", "batch", "A season of missions: each run by itself, one table, what stands out first."),
    "simulate": ("ssjs_cli.commands.simulate", "simulate", "Make a mission directory with truth from a scenario."),
    "import": ("ssjs_cli.commands.import_", "import_", "Make a mission directory from logs of other systems."),
    "evaluate": ("ssjs_cli.commands.evaluate", "evaluate", "Errors of a finished run against a reference."),
    "export": ("ssjs_cli.commands.export", "export", "A finished run for other programs: MCAP recordings."),
    "report": ("ssjs_cli.commands.report", "report", "(Re)build the HTML report of a finished run."),
    "segment": ("ssjs_cli.commands.segment", "segment", "Sonar images to masks, regions and centroids."),
    "segment-compare": ("ssjs_cli.commands.segment_compare", "segment_compare", "Five threshold methods on the same images."),
    "cascade": ("ssjs_cli.commands.cascade", "cascade", "Haar cascades: train, detect, evaluate, show."),
    "sonar": ("ssjs_cli.commands.sonar", "sonar", "Side-scan logs: what they hold, their picture."),
    "config": ("ssjs_cli.commands.config", "config", "The settings: defaults, JSON schema, a file checked."),
}


class LazyGroup(click.Group):
    """Knows its commands by name and help line, and imports one only when it is called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        module_name, attribute, _ = COMMANDS[cmd_name]
        command: click.Command = getattr(importlib.import_module(module_name), attribute)
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, help_line) for name, (_, _, help_line) in COMMANDS.items()])


def _print_version(context: click.Context, parameter: click.Parameter, value: bool) -> None:
    if not value or context.resilient_parsing:
        return
    from ssjs_cli import _core

    click.echo(f"ssjs-cli {_core.version()}")
    context.exit(0)


@click.command(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.option("--version", is_flag=True, expose_value=False, is_eager=True, callback=_print_version, help="Show the version and exit.")
def cli() -> None:
    """Submap joining SLAM: from vehicle logs to a corrected trajectory, a map and a report.

    Start with `ssjs-cli demo`, or import a log and `ssjs-cli run` it.
    """


def _stop(signal_number: int, frame: FrameType | None) -> None:
    raise InterruptionError


def call(arguments: Sequence[str]) -> int:
    """Runs one command line and gives its exit code."""
    session = Session(json_output="--json" in arguments)
    try:
        code = cli.main(args=list(arguments), prog_name="ssjs-cli", standalone_mode=False, obj=session)
    except (InterruptionError, KeyboardInterrupt, click.Abort) as error:
        return _fail(session, INTERRUPTED, str(error) or "interrupted; no unfinished result was left")
    except click.UsageError as error:
        return _fail(session, USER_ERROR, _usage_text(error))
    except click.ClickException as error:
        return _fail(session, USER_ERROR, error.format_message())
    except UserError as error:
        return _fail(session, USER_ERROR, str(error))
    except OSError as error:
        return _fail(session, USER_ERROR, describe_os_error(error))
    except MemoryError as error:
        return _fault(session, error)
    except Exception as error:
        return _fault(session, error)
    return code if isinstance(code, int) else DONE


def _usage_text(error: click.UsageError) -> str:
    command = error.ctx.command_path if error.ctx is not None else "ssjs-cli"
    return f"{error.format_message()} (see `{command} --help`)"


def _fault(session: Session, error: BaseException) -> int:
    path = session.write_fault(error)
    where = "its traceback could not be written" if path is None else f"traceback in {path}"
    first_line = (str(error).splitlines() or [""])[0]
    return _fail(session, OUR_FAULT, f"internal fault: {type(error).__name__}: {first_line} ({where}; please report it)")


def _fail(session: Session, code: int, text: str) -> int:
    for line in text.splitlines() or [""]:
        print(f"ssjs-cli: {line}", file=sys.stderr)
    if session.json_output:
        print(json.dumps({"error": {"exit_code": code, "message": text}}))
    return code


def main(arguments: Sequence[str] | None = None) -> Any:
    """The entry point of the program."""
    signal.signal(signal.SIGTERM, _stop)
    code = call(sys.argv[1:] if arguments is None else arguments)
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        sys.stderr.close()
    sys.exit(code)
