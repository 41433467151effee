"""The include check finds what it is for."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

SCRIPT = Path(__file__).with_name("check_includes.py")
spec = importlib.util.spec_from_file_location("check_includes", SCRIPT)
assert spec is not None
assert spec.loader is not None
check_includes = importlib.util.module_from_spec(spec)
spec.loader.exec_module(check_includes)


def project_with(folder: Path, files: dict[str, str]) -> Path:
    for name, text in files.items():
        path = folder / "cpp" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return folder


def test_the_project_itself_keeps_the_rules() -> None:
    assert check_includes.violations(SCRIPT.parents[3]) == []


def test_the_rules_have_no_circle() -> None:
    for folder, uses in check_includes.USES.items():
        for used in uses:
            assert folder not in check_includes.reachable(used)


def test_reaches_indirectly_but_not_backwards() -> None:
    assert check_includes.reachable("features") == {"features", "sensors", "geometry", "base"}
    assert "base" in check_includes.reachable("survey")
    assert "pipeline" not in check_includes.reachable("joining")


@pytest.mark.parametrize(
    ("name", "include", "message"),
    [
        ("include/ssjs/geometry/a.hpp", '"ssjs/filter/ekf.hpp"', "geometry/ must not include filter/"),
        ("include/ssjs/association/a.hpp", '"ssjs/filter/ekf.hpp"', "association/ must not include filter/"),
        ("include/ssjs/joining/a.hpp", "<suitesparse/cholmod.h>", "may be included only by"),
        ("include/ssjs/joining/a.hpp", "<cholmod.h>", "may be included only by"),
        ("include/ssjs/base/a.hpp", "<Eigen/Core>", "may be included only by"),
        ("include/ssjs/filter/a.hpp", "<opencv2/core.hpp>", "may be included only by"),
        ("include/ssjs/oddments/a.hpp", "<vector>", "folder is not in the rules"),
    ],
)
def test_finds_a_wrong_include(tmp_path: Path, name: str, include: str, message: str) -> None:
    found = check_includes.violations(project_with(tmp_path, {name: f"#pragma once\n#include {include}\n"}))
    assert len(found) == 1
    assert message in found[0]
    assert found[0].startswith(f"cpp/{name}:")


def test_finds_a_source_without_its_header(tmp_path: Path) -> None:
    found = check_includes.violations(project_with(tmp_path, {"src/filter/ekf.cpp": "int x;\n"}))
    assert found == ["cpp/src/filter/ekf.cpp:1: no header cpp/include/ssjs/filter/ekf.hpp of the same path"]


def test_accepts_what_is_right(tmp_path: Path) -> None:
    files = {
        "include/ssjs/joining/sparse_cholesky.hpp": '#pragma once\n#include <Eigen/Core>\n#include "ssjs/base/error.hpp"\n',
        "src/joining/sparse_cholesky.cpp": '#include "ssjs/joining/sparse_cholesky.hpp"\n#include <cholmod.h>\n',
        "src/joining/sparse_cholesky_updates.cpp": '#include "ssjs/joining/sparse_cholesky.hpp"\n',
        "bindings/joining.cpp": '#include <pybind11/pybind11.h>\n#include "ssjs/joining/sparse_cholesky.hpp"\n',
    }
    assert check_includes.violations(project_with(tmp_path, files)) == []
