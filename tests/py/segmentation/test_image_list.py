import os
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ssjs_cli.errors import UserError
from ssjs_cli.segmentation.image_list import listed_images, shortest_unique_ends


def touch(path: Path) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(b"x")
    return path


def test_a_folder_gives_its_images_by_name_and_nothing_else(tmp_path: Path) -> None:
    for name in ("b.PNG", "a.jpg", "c.tiff", "notes.txt", ".hidden.png", "deeper/d.png"):
        touch(tmp_path / name)
    listed = listed_images([str(tmp_path)])
    assert [image.name for image in listed] == ["a.jpg", "b.PNG", "c.tiff"]
    assert [image.stem for image in listed] == ["a", "b", "c"]


def test_a_pattern_reaches_into_folders(tmp_path: Path) -> None:
    touch(tmp_path / "one" / "x.png")
    touch(tmp_path / "two" / "deep" / "y.png")
    assert [image.name for image in listed_images([f"{tmp_path}/**/*.png"])] == ["x.png", "y.png"]


def test_an_image_named_twice_is_taken_once(tmp_path: Path) -> None:
    image = touch(tmp_path / "a.png")
    os.symlink(image, tmp_path / "link.png")
    assert [listed.name for listed in listed_images([str(image), str(tmp_path), str(tmp_path / "*.png")])] == ["a.png"]


def test_equal_names_of_different_folders_stay_apart(tmp_path: Path) -> None:
    for folder in ("east/high", "west/high"):
        touch(tmp_path / folder / "001.png")
    touch(tmp_path / "east" / "002.png")
    listed = listed_images([str(tmp_path / "east" / "high"), str(tmp_path / "west" / "high"), str(tmp_path / "east" / "002.png")])
    assert [image.name for image in listed] == ["east/high/001.png", "west/high/001.png", "002.png"]
    assert [image.stem for image in listed] == ["east--high--001", "west--high--001", "002"]


def test_names_that_differ_in_the_suffix_alone_keep_it(tmp_path: Path) -> None:
    touch(tmp_path / "a.png")
    touch(tmp_path / "a.tif")
    assert [image.stem for image in listed_images([str(tmp_path)])] == ["a.png", "a.tif"]


def test_a_folder_and_a_name_that_look_alike_stay_apart(tmp_path: Path) -> None:
    paths = [touch(tmp_path / "p" / "a.png"), touch(tmp_path / "q" / "a.png"), touch(tmp_path / "p--a.png")]
    assert [image.stem for image in listed_images([str(path) for path in paths])] == ["p--a", "q--a", "p--a-2"]


def test_what_is_not_there_is_said(tmp_path: Path) -> None:
    touch(tmp_path / "notes.txt")
    with pytest.raises(UserError, match="holds no image"):
        listed_images([str(tmp_path)])
    with pytest.raises(UserError, match="No such file or directory; check the path"):
        listed_images([str(tmp_path / "absent.png")])
    with pytest.raises(UserError, match="no image matches this pattern"):
        listed_images([str(tmp_path / "*.png")])


@given(st.sets(st.lists(st.sampled_from(["a", "b", "a.png"]), min_size=1, max_size=4).map(tuple), min_size=1, max_size=12))
def test_shortest_ends_are_unique_and_are_ends(parts: set[tuple[str, ...]]) -> None:
    paths = [Path("/", *entry) for entry in sorted(parts)]
    ends = shortest_unique_ends(paths)
    assert len(set(ends)) == len(paths)
    assert all(str(path).endswith(end) for path, end in zip(paths, ends, strict=True))
