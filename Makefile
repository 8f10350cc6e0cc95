# Everything runs in .venv, made on first use by any Python 3.11 or newer.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

.PHONY: demo picture setup test test-all lint bench real fuzz clean

demo: $(VENV)/.demo
	$(BIN)/python -m imubench.demo $(ESTIMATORS)

# README's first picture, drawn anew.
picture: demo
	cp demo/concealed/concealed.png docs/images/concealed.png

setup: $(VENV)/.test

# Every core has a worker already: with BLAS threads of their own they wait for each other (11 minutes, not 7).
test test-all: export OMP_NUM_THREADS := 1
# Where bytecode may not be kept, every process of a test compiles the package anew, and every worker all tests.
test test-all: export PYTHONDONTWRITEBYTECODE :=

test: $(VENV)/.test
	$(BIN)/python -m pytest -n auto --dist loadfile --durations 25 -m "not slow and not long"

test-all: $(VENV)/.test
	$(BIN)/python -m pytest -n auto --dist loadfile

lint: $(VENV)/.lint
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/python scripts/type_links.py
	$(BIN)/mypy

bench: $(VENV)/.bench
	$(BIN)/python -m benchmarks

# What else it takes: make real REAL="--only 'broad/*' --workers 1", or `.venv/bin/python -m benchmarks.real --help`.
REAL ?=

real: $(VENV)/.test
	$(BIN)/python -m benchmarks.real $(REAL)

# What else it takes: make fuzz FUZZ="--inputs 100000 --each 3000", or `.venv/bin/python -m fuzz --help`.
FUZZ ?= --seconds 600

fuzz: $(VENV)/.test
	$(BIN)/python -m fuzz $(FUZZ)

clean:
	rm -rf $(VENV) .types build dist *.egg-info demo

$(BIN)/python:
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "imubench needs Python 3.11 or newer; try: make PYTHON=python3.12 ...")'
	$(PYTHON) -m venv $(VENV)

$(VENV)/.demo: $(BIN)/python pyproject.toml
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[plot,convert]"
	@touch $@

$(VENV)/.test: $(BIN)/python pyproject.toml
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[test]"
	@touch $@

$(VENV)/.lint: $(BIN)/python pyproject.toml
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[test,lint]"
	@touch $@

$(VENV)/.bench: $(BIN)/python pyproject.toml
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[plot,convert,bench]"
	@touch $@
