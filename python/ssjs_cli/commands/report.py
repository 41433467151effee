"""ssjs-cli report: the HTML page from result files alone."""

from pathlib import Path

import click

from ssjs_cli.exit_codes import DONE
from ssjs_cli.options import common_options
from ssjs_cli.session import Session


@click.command()
@click.argument("run_dir", type=click.Path())
@common_options(out_help="Also put the page here (default: only RUN_DIR/report.html).")
@click.pass_obj
def report(session: Session, run_dir: str, seed: int | None, force: bool, out: str | None) -> int:
    """Build report.html of RUN_DIR from its result files; an older report there is replaced."""
    from ssjs_cli.errors import UserError
    from ssjs_cli.formats.atomic import write_file
    from ssjs_cli.formats.run_directory import run_directory
    from ssjs_cli.run_summary import build_run_report

    directory = run_directory(Path(run_dir))
    target = None if out is None else Path(out)
    if target is not None and target.exists() and not force:
        raise UserError(f"{target}: exists already; choose another --out, or replace it with --force")
    path = build_run_report(directory)
    if target is not None:
        target.parent.mkdir(parents=True, exist_ok=True)
        write_file(target, path.read_bytes())
        path = target
    session.answer({"report": str(path)}, str(path))
    return DONE
