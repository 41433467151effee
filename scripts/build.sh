#!/usr/bin/env bash
# Builds build/release and installs the Python package from it into .venv, editable: the sources in python/ are used in place.
#   scripts/build.sh use       the Python module only
#   scripts/build.sh develop   C++ tests and benchmarks as well
# The Python package, ctest and the installed C++ package share this one build. Call scripts/setup.sh with the same word first.
set -euo pipefail
cd "$(dirname "$0")/.."

purpose=${1:-use}
build=build/release
python=.venv/bin/python

# The project as a Python package: configures the build, compiles the module, writes the command ssjs-cli.
stamp=.venv/package-$(cat pyproject.toml scripts/build.sh | sha256sum | cut -c1-16)
if [[ ! -e $stamp || ! -e $build/build.ninja ]]; then
  echo "building the Python package in $build (minutes the first time)"
  CMAKE_GENERATOR=Ninja $python -m pip install --quiet --quiet --disable-pip-version-check --no-build-isolation --no-deps \
    --config-settings=build-dir=$build --editable .
  rm -f .venv/package-*
  touch "$stamp"
fi

if [[ $purpose == develop ]]; then
  for option in SSJS_BUILD_TESTS SSJS_BUILD_BENCHMARKS; do
    grep -q "^$option:BOOL=ON$" $build/CMakeCache.txt || options+=("-D$option=ON")
  done
  [[ -z ${options[*]:-} ]] || cmake "${options[@]}" $build >/dev/null
  cmake --build $build
else
  cmake --build $build --target _core
fi

# The module of an editable package lies among the installed packages; bring it up to date with this build.
cmake --install $build --component python --strip --prefix "$($python -c 'import sysconfig; print(sysconfig.get_path("platlib"))')" >/dev/null
