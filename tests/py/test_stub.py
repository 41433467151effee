"""The stub of the compiled module against the module: names, and the names of their arguments."""

import ast
import inspect
import re
from pathlib import Path

import ssjs_cli
from ssjs_cli import _core

STUB = ast.parse((Path(ssjs_cli.__file__).parent / "_core.pyi").read_text(encoding="utf-8"))


def stated_arguments(function: ast.FunctionDef) -> list[str]:
    names = [argument.arg for argument in (*function.args.args, *function.args.kwonlyargs)]
    return names[1:] if names[:1] == ["self"] else names


def true_arguments(function: object) -> list[str]:
    """pybind11 writes the signature into the first line of the documentation."""
    signature = (inspect.getdoc(function) or "").splitlines()[0]
    names = re.findall(r"(?:\(|, )(\w+): ", signature.split(" -> ")[0])
    return names[1:] if names[:1] == ["self"] else names


def members(owner: object) -> dict[str, object]:
    return {name: value for name, value in vars(owner).items() if not name.startswith("_")}


def test_the_module_has_what_the_stub_says_and_nothing_else() -> None:
    stated = {node.name for node in STUB.body if isinstance(node, ast.FunctionDef | ast.ClassDef)}
    assert stated == set(members(_core))


def test_functions_take_the_stated_arguments() -> None:
    for node in STUB.body:
        if isinstance(node, ast.FunctionDef):
            assert true_arguments(getattr(_core, node.name)) == stated_arguments(node), node.name


def test_classes_have_the_stated_members() -> None:
    for node in STUB.body:
        if not isinstance(node, ast.ClassDef):
            continue
        stated = {part.name: part for part in node.body if isinstance(part, ast.FunctionDef)}
        kind = getattr(_core, node.name)
        assert {name for name in stated if not name.startswith("_")} == set(members(kind)), node.name
        for name, part in stated.items():
            if isinstance(vars(kind)[name], property):
                assert any(isinstance(mark, ast.Name) and mark.id == "property" for mark in part.decorator_list), name
            elif not name.startswith("_"):
                assert true_arguments(getattr(kind, name)) == stated_arguments(part), f"{node.name}.{name}"
