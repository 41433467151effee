#!/usr/bin/env bash
# The layout of every C++ and Python source: checked, or with --write rewritten. Needs the packages of `setup.sh develop`.
set -euo pipefail
cd "$(dirname "$0")/.."

folders=()
for folder in cpp tests benchmarks examples; do
  [[ ! -d $folder ]] || folders+=("$folder")
done
mapfile -t sources < <(find "${folders[@]}" -name '*.cpp' -o -name '*.hpp' | sort)

if [[ ${1:-} == --write ]]; then
  .venv/bin/clang-format -i "${sources[@]}"
  .venv/bin/ruff format --quiet
  .venv/bin/ruff check --select I --fix --quiet # import order
else
  .venv/bin/clang-format --dry-run --Werror "${sources[@]}"
  .venv/bin/ruff format --check --quiet
fi
