#!/usr/bin/env bash
# Everything the project needs, installed once: Debian packages, a Python environment in .venv, its Python packages.
#   scripts/setup.sh use       what building and using the program needs
#   scripts/setup.sh develop   the same and what tests, checks and benchmarks need
# A second call finds all in place and changes nothing. SSJS_PYTHON names another interpreter than /usr/bin/python3.
set -euo pipefail
cd "$(dirname "$0")/.."

purpose=${1:-use}
case $purpose in
  use | develop) ;;
  *) echo "setup.sh: '$purpose' is neither 'use' nor 'develop'" >&2; exit 2 ;;
esac
python=${SSJS_PYTHON:-/usr/bin/python3}

packages=(g++ cmake ninja-build pkg-config ca-certificates libeigen3-dev libsuitesparse-dev libopencv-imgproc-dev libpugixml-dev nlohmann-json3-dev libdlib-dev ccache python3 python3-dev python3-venv)
if [[ $purpose == develop ]]; then
  packages+=(libgtest-dev libbenchmark-dev libopencv-features2d-dev chromium clang-14 libclang-rt-14-dev libfuzzer-14-dev)
fi

install_debian_packages() {
  local missing=() package
  for package in "${packages[@]}"; do
    [[ $(dpkg-query --show --showformat='${db:Status-Status}' "$package" 2>/dev/null) == installed ]] || missing+=("$package")
  done
  [[ ${#missing[@]} -gt 0 ]] || return 0

  local as_root=()
  if [[ $EUID -ne 0 ]]; then
    if ! command -v sudo >/dev/null; then
      echo "setup.sh: missing Debian packages; as root, run: apt-get install ${missing[*]}" >&2
      exit 1
    fi
    as_root=(sudo)
  fi
  echo "installing Debian packages: ${missing[*]}"
  "${as_root[@]}" apt-get update --quiet
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install --yes --quiet --no-install-recommends "${missing[@]}"
}

if command -v dpkg-query >/dev/null && command -v apt-get >/dev/null; then
  install_debian_packages
else
  echo "setup.sh: no apt-get here; expecting the equivalents of: ${packages[*]}" >&2
fi

if [[ ! -x .venv/bin/python ]]; then
  "$python" -c 'import sys; sys.exit(sys.version_info < (3, 11) and "setup.sh: Python 3.11 or newer is needed, set SSJS_PYTHON")'
  "$python" -m venv .venv
fi

# What is installed is keyed by the files that say what to install.
stamp=.venv/installed-$purpose-$(cat pyproject.toml scripts/setup.sh | sha256sum | cut -c1-16)
if [[ ! -e $stamp ]]; then
  mapfile -t requirements < <(.venv/bin/python - "$purpose" <<'PYTHON'
import sys
import tomllib

with open("pyproject.toml", "rb") as file:
    pyproject = tomllib.load(file)
lines = pyproject["build-system"]["requires"] + pyproject["project"]["dependencies"]
if sys.argv[1] == "develop":
    lines += pyproject["project"]["optional-dependencies"]["develop"]
print("\n".join(lines))
PYTHON
  )
  echo "installing Python packages into .venv"
  .venv/bin/python -m pip install --quiet --quiet --disable-pip-version-check "${requirements[@]}"
  rm -f .venv/installed-"$purpose"-*
  touch "$stamp"
fi
