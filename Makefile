# Every target sets up what it needs from nothing but Python 3.11+, venv, make and git.
PYTHON ?= python3
BIN := .venv/bin
.PHONY: demo test check bench fuzz soak clean
.DELETE_ON_ERROR:

$(BIN)/python:
	$(PYTHON) -m venv .venv

.venv/.installed: $(BIN)/python pyproject.toml
	$(BIN)/pip install --quiet --disable-pip-version-check -e .
	@touch $@

.venv/.installed-dev: $(BIN)/python pyproject.toml
	$(BIN)/pip install --quiet --disable-pip-version-check -e '.[dev]'
	@touch $@ .venv/.installed

demo: .venv/.installed
	$(BIN)/solarcal demo

test: .venv/.installed-dev
	$(BIN)/python -m pytest -n 2 --dist worksteal

check: .venv/.installed-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: .venv/.installed-dev
	$(BIN)/python -m benchmarks

fuzz: .venv/.installed-dev
	$(BIN)/python -m fuzzing

soak: .venv/.installed-dev
	$(BIN)/python -m soak

clean:
	rm -rf .venv build dist .pytest_cache .mypy_cache .ruff_cache
