"""Data moves one way: which folder of the C++ library may include which.

    python check_includes.py PROJECT_FOLDER

Prints every include that goes against the rules, as file:line, and exits with 1 if there is one.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

# Folder -> the folders it uses directly; it may include all that can be reached from them, and itself.
USES = {
    "base": [],
    "geometry": ["base"],
    "sensors": ["geometry"],
    "features": ["sensors"],
    "association": ["features"],
    "filter": ["association"],
    "mapping": ["filter"],
    "joining": ["mapping"],
    "simulation": ["features"],
    "evaluation": ["joining"],
    "io": ["evaluation", "simulation"],
    "pipeline": ["joining", "simulation", "evaluation", "io"],
    "imaging": ["base"],
    "cascade": ["imaging"],
    "optical": ["imaging"],
    "survey": ["pipeline", "imaging", "cascade", "optical"],
    "embed": ["pipeline"],
}

# Third-party headers that stay in few places: pattern -> the files (relative to cpp/) that may include them.
CONFINED = {
    r"(suitesparse/)?(cholmod|SuiteSparse|amd|camd|colamd|ccolamd)[\w.]*": r"src/joining/sparse_cholesky\.cpp",
    r"opencv2?/.*": r"(src|include/ssjs)/(imaging|cascade|optical|survey)/.*|bindings/.*",
    r"pugixml\.hpp": r"src/cascade/cascade_xml\.cpp",
    r"nlohmann/.*": r"src/(cascade/cascade|pipeline/checkpoint)_file\.cpp",
    r"dlib/.*": r"src/optical/.*",
    r"pybind11/.*": r"bindings/.*",
    r"Eigen/.*|unsupported/Eigen/.*": r"(src|bindings)/.*|include/ssjs/(?!base/|embed/).*",
}

INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^">]+)[">]')


def reachable(folder: str) -> set[str]:
    """The folders that `folder` may include, itself among them."""
    found = {folder}
    for used in USES[folder]:
        found |= reachable(used)
    return found


def headers_it_is_part_of(header: Path) -> list[Path]:
    """a/b_c_d.hpp -> a/b_c.hpp, a/b.hpp: a long source is split into parts that begin with the name of the whole."""
    words = header.stem.split("_")
    return [header.with_name("_".join(words[:count]) + ".hpp") for count in range(len(words) - 1, 0, -1)]


def folder_of(path: Path) -> str | None:
    """The library folder of a file given relative to cpp/, None outside the library (bindings)."""
    parts = path.parts
    if parts[0] == "src" and len(parts) > 2:
        return parts[1]
    if parts[:2] == ("include", "ssjs") and len(parts) > 3:
        return parts[2]
    return None


def violations(project: Path) -> list[str]:
    """Every include against the rules and every file out of place, as "file:line: what is wrong"."""
    cpp = project / "cpp"
    found: list[str] = []
    for path in sorted([*cpp.rglob("*.hpp"), *cpp.rglob("*.cpp")]):
        relative = path.relative_to(cpp)
        folder = folder_of(relative)
        name = path.relative_to(project).as_posix()
        if relative.parts[0] != "bindings" and folder not in USES:
            found.append(f"{name}:1: folder is not in the rules; known: {', '.join(USES)}")
            continue
        if relative.parts[0] == "src":
            header = (cpp / "include" / "ssjs" / relative.relative_to("src")).with_suffix(".hpp")
            if not any(candidate.exists() for candidate in (header, *headers_it_is_part_of(header))):
                found.append(f"{name}:1: no header {header.relative_to(project).as_posix()} of the same path")
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1):
            match = INCLUDE.match(line)
            if match is None:
                continue
            target = match.group(1)
            for pattern, allowed in CONFINED.items():
                if re.fullmatch(pattern, target) and not re.fullmatch(allowed, relative.as_posix()):
                    found.append(f"{name}:{number}: {target} may be included only by cpp/{allowed}")
            if folder is not None and target.startswith("ssjs/"):
                used = target.split("/")[1]
                if used not in reachable(folder):
                    found.append(f"{name}:{number}: {folder}/ must not include {used}/ ({target})")
    return found


def main() -> int:
    if len(sys.argv) != 2:
        print("usage: check_includes.py PROJECT_FOLDER", file=sys.stderr)
        return 2
    found = violations(Path(sys.argv[1]).resolve())
    print("\n".join(found) if found else "include directions: all as they should be")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
