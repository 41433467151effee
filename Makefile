# On a fresh Debian 12 with git and make, `make demo` and `make test` install what they need and run.
SHELL := /bin/bash
.DEFAULT_GOAL := help
.PHONY: help setup demo test test-cpp test-python build format format-check lint bench clean

help:
	@echo "make demo    simulate a survey, run it, write the report (installs what is missing)"
	@echo "make test    C++ and Python tests"
	@echo "make build   compile everything, install the command line into .venv"
	@echo "make format  rewrite the sources in the project's layout"
	@echo "make lint    layout, ruff, mypy, include directions, clang-tidy"
	@echo "make bench   benchmarks"
	@echo "make clean   remove build folders and .venv"

demo:
	@scripts/setup.sh use
	@scripts/build.sh use
	.venv/bin/ssjs-cli demo --force

setup:
	@scripts/setup.sh develop

build: setup
	@scripts/build.sh develop

test: test-cpp test-python

test-cpp: build
	ctest --test-dir build/release --label-exclude long --output-on-failure --no-tests=error --parallel $$(nproc)

test-python: build
	.venv/bin/python -m pytest -m "not long"

format: setup
	@scripts/check_format.sh --write

format-check: setup
	@scripts/check_format.sh

lint: format-check
	.venv/bin/ruff check
	.venv/bin/mypy
	.venv/bin/python tests/cpp/include_rules/check_includes.py .
	scripts/clang_tidy.sh

bench: build
	build/release/ssjs_benchmarks

clean:
	rm -rf build .venv
