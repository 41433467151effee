import errno
import os
from pathlib import Path

import pytest

from ssjs_cli.errors import UserError
from ssjs_cli.formats.atomic import new_directory, write_file


def ours(directory: Path) -> str | None:
    return None if (directory / "mark").is_file() else "it holds no mark"


def make(target: Path, *, force: bool = False, text: str = "new") -> None:
    with new_directory(target, force=force, why_not_ours=ours, kind="run directory") as partial:
        (partial / "mark").write_text(text)


def entries(directory: Path) -> list[str]:
    return sorted(os.listdir(directory))


def test_the_directory_appears_whole(tmp_path: Path) -> None:
    with new_directory(tmp_path / "a" / "b", force=False, why_not_ours=ours, kind="run directory") as partial:
        (partial / "mark").write_text("new")
        assert entries(tmp_path / "a") == [partial.name]
    assert entries(tmp_path / "a") == ["b"]
    assert (tmp_path / "a" / "b" / "mark").read_text() == "new"


@pytest.mark.parametrize("error", [KeyboardInterrupt(), ZeroDivisionError()])
def test_a_failure_leaves_nothing(tmp_path: Path, error: BaseException) -> None:
    with (
        pytest.raises(type(error)),
        new_directory(tmp_path / "a", force=False, why_not_ours=ours, kind="run directory") as partial,
    ):
        (partial / "mark").write_text("half")
        raise error
    assert entries(tmp_path) == []


def test_a_full_disk_names_the_output_and_leaves_nothing(tmp_path: Path) -> None:
    with (
        pytest.raises(UserError, match=r"/a: No space left on device; free some space on that disk or choose another --out$"),
        new_directory(tmp_path / "a", force=False, why_not_ours=ours, kind="run directory"),
    ):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    assert entries(tmp_path) == []


def test_a_failure_of_an_input_keeps_its_own_name(tmp_path: Path) -> None:
    with (
        pytest.raises(FileNotFoundError),
        new_directory(tmp_path / "a", force=False, why_not_ours=ours, kind="run directory"),
    ):
        (tmp_path / "input.csv").read_bytes()


def test_nothing_is_overwritten_without_force(tmp_path: Path) -> None:
    make(tmp_path / "a", text="old")
    with pytest.raises(UserError, match=r"/a: exists already; choose another --out, or replace it with --force$"):
        make(tmp_path / "a")
    assert (tmp_path / "a" / "mark").read_text() == "old"


def test_force_replaces_one_of_ours(tmp_path: Path) -> None:
    make(tmp_path / "a", text="old")
    make(tmp_path / "a", force=True)
    assert (tmp_path / "a" / "mark").read_text() == "new"
    assert entries(tmp_path) == ["a"]


def test_force_spares_a_directory_that_is_not_ours(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "thesis.txt").write_text("mine")
    with pytest.raises(UserError, match=r"--force replaces only a run directory, and this is none \(it holds no mark\)"):
        make(tmp_path / "a", force=True)
    assert entries(tmp_path / "a") == ["thesis.txt"]


def test_a_failed_replacement_keeps_the_old_one(tmp_path: Path) -> None:
    make(tmp_path / "a", text="old")
    with (
        pytest.raises(ZeroDivisionError),
        new_directory(tmp_path / "a", force=True, why_not_ours=ours, kind="run directory") as partial,
    ):
        (partial / "mark").write_text("half")
        raise ZeroDivisionError
    assert (tmp_path / "a" / "mark").read_text() == "old"


def test_an_empty_directory_may_be_filled(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    make(tmp_path / "a")
    assert entries(tmp_path / "a") == ["mark"]


def test_an_output_below_a_file_is_the_users_error(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match="file/a: "):
        make(tmp_path / "file" / "a")


def test_a_file_in_the_way_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("")
    with pytest.raises(UserError, match="is a file, and a run directory is a directory"):
        make(tmp_path / "a", force=True)


def test_a_file_is_replaced_whole(tmp_path: Path) -> None:
    write_file(tmp_path / "a.json", "1")
    write_file(tmp_path / "a.json", "2")
    assert (tmp_path / "a.json").read_text() == "2"
    assert entries(tmp_path) == ["a.json"]
