"""The images that a command line means: files, folders and patterns, each once, with names that cannot be mistaken for each other."""

import glob
import os
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from ssjs_cli.errors import UserError
from ssjs_cli.formats.image_file import SUFFIXES

_PATTERN_CHARACTERS = "*?["


@dataclass(frozen=True)
class ListedImage:
    """name: what tables call it, the end of its path that no other image shares; stem: of the files made from it, unique as well."""

    path: Path
    name: str
    stem: str


def listed_images(arguments: Sequence[str]) -> list[ListedImage]:
    """In the order of the arguments, a folder's and a pattern's images by name. Folders are not searched within folders: a pattern
    such as 'survey/**/*.png' does that."""
    paths: dict[Path, Path] = {}
    for argument in arguments:
        for path in _images_of(argument):
            paths.setdefault(Path(os.path.realpath(path)), path)
    return _named(list(paths.values()))


def _images_of(argument: str) -> list[Path]:
    path = Path(argument)
    if path.is_dir():
        found = sorted(entry for entry in path.iterdir() if _looks_like_an_image(entry))
        if not found:
            raise UserError(f"{path}: holds no image ({', '.join(SUFFIXES)}); name the folder that holds them, or a pattern")
        return found
    if path.exists() or path.is_symlink():
        return [path]
    if any(character in argument for character in _PATTERN_CHARACTERS):
        found = sorted(Path(match) for match in glob.glob(argument, recursive=True) if _looks_like_an_image(Path(match)))
        if not found:
            raise UserError(f"{argument}: no image matches this pattern; check it, and quote it if it holds **")
        return found
    raise UserError(f"{path}: No such file or directory; check the path")


def _looks_like_an_image(path: Path) -> bool:
    return path.suffix.lower() in SUFFIXES and not path.name.startswith(".") and not path.is_dir()


def _named(paths: Sequence[Path]) -> list[ListedImage]:
    names = shortest_unique_ends([path.absolute() for path in paths])
    times = Counter(Path(name).with_suffix("") for name in names)
    stems = [_stem(name, keep_suffix=times[Path(name).with_suffix("")] > 1) for name in names]
    return [ListedImage(path, name, stem) for path, name, stem in zip(paths, names, _made_unique(stems), strict=True)]


def shortest_unique_ends(paths: Sequence[Path]) -> list[str]:
    """For each of several different absolute paths the last parts of it that no other one ends with."""
    depth = dict.fromkeys(range(len(paths)), 1)
    unsettled = set(depth)
    while unsettled:
        ends = {index: paths[index].parts[-depth[index] :] for index in depth}
        times = Counter(ends.values())
        unsettled = {index for index in depth if times[ends[index]] > 1 and depth[index] < len(paths[index].parts)}
        for index in unsettled:
            depth[index] += 1
    return ["/".join(part for part in paths[index].parts[-depth[index] :] if part != os.sep) for index in range(len(paths))]


def title_of(arguments: Sequence[str]) -> str:
    """The name of the first folder or image, as far as it is a name."""
    first = Path(arguments[0])
    while any(character in first.name for character in _PATTERN_CHARACTERS):
        first = first.parent
    first = Path(os.path.abspath(first))
    return (first.name if first.is_dir() else first.stem) or "images"


def _stem(name: str, *, keep_suffix: bool) -> str:
    text = name if keep_suffix else str(Path(name).with_suffix(""))
    return text.replace("/", "--")


def _made_unique(stems: Iterable[str]) -> list[str]:
    """'a/b.png' and 'a--b.png' would share a name: the second gets a number. Names that differ in case alone are one on some disks."""
    taken: set[str] = set()
    result = []
    for stem in stems:
        unique, number = stem, 2
        while unique.casefold() in taken:
            unique, number = f"{stem}-{number}", number + 1
        taken.add(unique.casefold())
        result.append(unique)
    return result
