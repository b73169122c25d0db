# Every target sets up what it needs from nothing but Python 3.11+, venv, make and git.
PYTHON ?= python3
BIN := .venv/bin
.PHONY: demo test check bench bench-judgement mutants fuzz soak pictures man dist-check clean
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

# Compiles the test modules once: each of the workers of a first run would do it beside the others.
.venv/.compiled-tests: .venv/.installed-dev
	-@$(BIN)/python -m pytest -n 0 --collect-only -qq >/dev/null
	@touch $@

# Four workers on two cores: what waits for real programs and for screens leaves room for others.
test: .venv/.compiled-tests
	$(BIN)/python -m pytest -n 4 --dist worksteal

check: .venv/.installed-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

# Speed, some minutes.
bench: .venv/.installed-dev
	$(BIN)/python -m benchmarks

# Every picture of the documentation, from a seeded emulator at fixed virtual times.
pictures: .venv/.installed
	$(BIN)/python -m tools.pictures docs/pictures

# The man page, from the program's own options.
man: .venv/.installed-dev
	$(BIN)/python -m tools.man_page

# Wheel and source archive: built, looked into, the wheel installed alone and used.
dist-check: .venv/.installed-dev
	$(BIN)/python -m tools.dist_check

# How good the answers are, on thousands of made-up trackers: some two hours. Fewer days
# and single cells: `python -m benchmarks.judgement_stopping --help`.
bench-judgement: .venv/.installed-dev
	$(BIN)/python -m benchmarks judgement

# Three hundred small changes of the source, one at a time: the share that the neighbouring tests
# notice, and those they do not. Half an hour on two cores, in copies of the checkout.
mutants: .venv/.installed-dev
	$(BIN)/python -m tools.mutants

# A million cases of nonsense at every door a file or a line comes in by.
fuzz: .venv/.installed-dev
	$(BIN)/python -m fuzzing

# An emulated month on the screen, and a thousand writers killed: an hour or so.
soak: .venv/.installed-dev
	$(BIN)/python -m soak

clean:
	rm -rf .venv build dist .pytest_cache .mypy_cache .ruff_cache
