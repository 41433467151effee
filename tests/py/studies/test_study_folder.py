import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ssjs_cli.errors import UserError
from ssjs_cli.studies.study_folder import key_of, open_study

DEFINITION = {"study": "test", "runs": 2}
OUTPUTS = ("table.csv",)


def study(path: Path, definition: dict = DEFINITION, *, force: bool = False):
    return open_study(path, definition, outputs=OUTPUTS, force=force)


values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(),
    lambda inner: st.lists(inner, max_size=3),
)


@given(st.dictionaries(st.text(), values, max_size=5))
def test_the_key_does_not_depend_on_the_order_of_the_identity(identity: dict) -> None:
    assert key_of(identity) == key_of(dict(reversed(list(identity.items()))))
    assert key_of(identity) != key_of({**identity, "one more": 1})


def test_a_record_is_found_again_as_it_was(tmp_path: Path) -> None:
    record = {"summary": {"rmse": 0.1 + 0.2, "none": None}, "curve": [1.5, None]}
    with study(tmp_path / "s") as folder:
        assert folder.store("abc", {"seed": 1}, record) == record
    with study(tmp_path / "s") as folder:
        assert folder.finished(["abc", "def"]) == {"abc": record}


@pytest.mark.parametrize("text", ["", "{", "[]", '{"key": "other", "record": {}}', '{"key": "abc", "record": 3}'])
def test_a_file_that_is_no_record_counts_as_absent(tmp_path: Path, text: str) -> None:
    with study(tmp_path / "s") as folder:
        (folder.path / "runs" / "abc.json").write_text(text)
        assert folder.finished(["abc"]) == {}


def test_another_study_is_not_overwritten(tmp_path: Path) -> None:
    with study(tmp_path / "s") as folder:
        folder.store("abc", {}, {"number": 1})
    with (
        pytest.raises(UserError, match=r"holds another study \(different: runs\); choose another --out, or start anew with --force"),
        study(tmp_path / "s", {"study": "test", "runs": 3}),
    ):
        pass
    with study(tmp_path / "s") as folder:
        assert folder.finished(["abc"])


def test_force_starts_anew(tmp_path: Path) -> None:
    with study(tmp_path / "s") as folder:
        folder.store("abc", {}, {"number": 1})
        folder.write("table.csv", "old")
    with study(tmp_path / "s", {"study": "test", "runs": 3}, force=True) as folder:
        assert folder.finished(["abc"]) == {}
        assert not (folder.path / "table.csv").exists()
    assert json.loads((tmp_path / "s" / "study.json").read_text())["runs"] == 3


@pytest.mark.parametrize("force", [False, True])
def test_a_folder_of_another_kind_is_left_alone(tmp_path: Path, force: bool) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(UserError, match="is no study"), study(tmp_path, force=force):
        pass
    assert [entry.name for entry in tmp_path.iterdir()] == ["notes.txt"]


def test_force_spares_a_study_that_holds_something_else(tmp_path: Path) -> None:
    with study(tmp_path / "s") as folder:
        folder.store("abc", {}, {})
    (tmp_path / "s" / "notes.txt").write_text("mine")
    with pytest.raises(UserError, match=r"also holds notes\.txt"), study(tmp_path / "s", force=True):
        pass
    assert (tmp_path / "s" / "runs" / "abc.json").exists()


def test_a_file_in_the_place_of_the_folder(tmp_path: Path) -> None:
    (tmp_path / "s").write_text("")
    with pytest.raises(UserError, match="is a file, and a study is a folder"), study(tmp_path / "s"):
        pass
    with pytest.raises(UserError, match="Not a directory"), study(tmp_path / "s" / "below"):
        pass


def test_two_calls_do_not_work_on_one_study(tmp_path: Path) -> None:
    with study(tmp_path / "s"), pytest.raises(UserError, match="another ssjs-cli is at work"), study(tmp_path / "s"):
        pass


def test_a_study_without_a_finished_run_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(RuntimeError), study(tmp_path / "s"):
        raise RuntimeError
    assert not (tmp_path / "s").exists()
    with pytest.raises(RuntimeError), study(tmp_path / "s") as folder:
        folder.store("abc", {}, {})
        raise RuntimeError
    assert (tmp_path / "s" / "runs" / "abc.json").exists()


def test_half_files_of_a_killed_call_are_removed(tmp_path: Path) -> None:
    with study(tmp_path / "s") as folder:
        folder.store("abc", {}, {})
    half = tmp_path / "s" / "runs" / ".def.json.123.partial"
    half.write_text("{")
    with study(tmp_path / "s"):
        assert not half.exists()
