"""Files and directories that appear under their final name only when they are complete."""

import os
import shutil
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from ssjs_cli.errors import UserError, describe_os_error


def _partial_sibling(target: Path, role: str = "partial") -> Path:
    return target.with_name(f".{target.name}.{os.getpid()}.{role}")


def write_file(target: Path, data: bytes | str) -> None:
    """Writes a temporary sibling and renames it."""
    partial = _partial_sibling(target)
    try:
        partial.write_bytes(data.encode("utf-8") if isinstance(data, str) else data)
        os.replace(partial, target)
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise UserError(describe_os_error(error, str(target))) from error
    except BaseException:
        partial.unlink(missing_ok=True)
        raise


@contextmanager
def new_file(target: Path) -> Iterator[BinaryIO]:
    """A temporary sibling to write; it gets the final name when the block ends, and vanishes when the block fails."""
    partial = _partial_sibling(target)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with partial.open("wb") as file:
            yield file
        os.replace(partial, target)
    except OSError as error:
        partial.unlink(missing_ok=True)
        if error.filename is None or str(error.filename) == str(partial):
            raise UserError(describe_os_error(error, str(target))) from error
        raise
    except BaseException:
        partial.unlink(missing_ok=True)
        raise


def check_replaceable(target: Path, *, force: bool, why_not_ours: Callable[[Path], str | None], kind: str) -> None:
    """Refuses a target that holds something, unless --force is given and it is a directory of ours.
    why_not_ours gives the reason why a directory is not one of `kind`, or None when it is."""
    if target.is_symlink() and not target.exists():
        raise UserError(f"{target}: is a dangling link; remove it or choose another --out")
    if not target.exists() or (target.is_dir() and not any(target.iterdir())):
        return
    if not target.is_dir():
        raise UserError(f"{target}: is a file, and a {kind} is a directory; choose another --out")
    if not force:
        raise UserError(f"{target}: exists already; choose another --out, or replace it with --force")
    reason = why_not_ours(target)
    if reason is not None:
        raise UserError(f"{target}: --force replaces only a {kind}, and this is none ({reason}); choose another --out")


def holds_only(files: Collection[str], needed: Sequence[str]) -> Callable[[Path], str | None]:
    """A why_not_ours for directories that hold the files `needed`, and none but `files`."""

    def why_not(directory: Path) -> str | None:
        for name in needed:
            if not (directory / name).is_file():
                return f"it holds no {name}"
        foreign = sorted(entry.name for entry in directory.iterdir() if entry.name not in files)
        return f"it also holds {foreign[0]}" if foreign else None

    return why_not


def check_writable(target: Path, inputs: Iterable[Path], *, force: bool) -> None:
    """A file to be written: never one that is read, and one that exists only with --force."""
    if not target.exists():
        return
    if any(source.exists() and target.samefile(source) for source in inputs):
        raise UserError(f"{target}: is the file that is read; choose another --out")
    if not force:
        raise UserError(f"{target}: exists already; choose another --out, or replace it with --force")


@contextmanager
def new_directory(target: Path, *, force: bool, why_not_ours: Callable[[Path], str | None], kind: str) -> Iterator[Path]:
    """A temporary sibling to fill; it gets the final name when the block ends, and vanishes when the block fails."""
    target = Path(os.path.abspath(target))
    check_replaceable(target, force=force, why_not_ours=why_not_ours, kind=kind)
    if target.is_symlink():
        target = target.resolve()
    partial = _partial_sibling(target)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.rmtree(partial, ignore_errors=True)
        partial.mkdir()
    except OSError as error:
        raise UserError(describe_os_error(error, str(target))) from error
    try:
        yield partial
        check_replaceable(target, force=force, why_not_ours=why_not_ours, kind=kind)
        _rename_over(partial, target)
    except OSError as error:
        shutil.rmtree(partial, ignore_errors=True)
        if error.filename is None or str(error.filename).startswith(str(partial)):
            raise UserError(describe_os_error(error, str(target))) from error
        raise
    except BaseException:
        shutil.rmtree(partial, ignore_errors=True)
        raise


def _rename_over(partial: Path, target: Path) -> None:
    if not target.exists() or not any(target.iterdir()):
        os.rename(partial, target)
        return
    replaced = _partial_sibling(target, "replaced")
    os.rename(target, replaced)
    try:
        os.rename(partial, target)
    except BaseException:
        os.rename(replaced, target)
        raise
    shutil.rmtree(replaced, ignore_errors=True)
