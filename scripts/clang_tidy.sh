#!/usr/bin/env bash
# clang-tidy over library sources: all of cpp/src, or the files named. Checks: .clang-tidy.
set -euo pipefail
cd "$(dirname "$0")/.."

# clang cannot read a precompiled header of gcc: a build description of its own.
build=build/tidy
cmake -S . -B $build -G Ninja -DCMAKE_BUILD_TYPE=Debug -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON \
  -DSSJS_BUILD_TESTS=OFF -DSSJS_BUILD_BENCHMARKS=OFF -DSSJS_BUILD_PYTHON=OFF >/dev/null

if [[ $# -gt 0 ]]; then
  sources=("$@")
else
  mapfile -t sources < <(find cpp/src -name '*.cpp' | sort)
fi
printf '%s\0' "${sources[@]}" |
  xargs --null --max-args=1 --max-procs="$(nproc)" .venv/bin/clang-tidy -p $build --quiet --warnings-as-errors='*' 2> >(grep -v 'warnings generated\|Suppressed\|Use -header-filter' >&2)
