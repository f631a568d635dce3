"""Tracebacks of errors in IPython."""

import re
import subprocess
import sys
import traceback

import pytest

import hertzchain as hc

pytest.importorskip("IPython")

CELL = """
import hertzchain as hc
def built(beads):
    return hc.Chain.uniform(beads)
"""


def shown(*cells):
    """Output of cells in a new shell of IPython, without colours."""
    code = (
        "from IPython.core.interactiveshell import InteractiveShell\n"
        "shell = InteractiveShell.instance(history_manager=None, colors='nocolor')\n"
        f"for cell in {cells!r}:\n    shell.run_cell(cell)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return re.sub(r"\x1b\[[0-9;]*m", "", done.stdout)


def test_the_traceback_has_the_lines_of_the_user_and_the_sentence():
    out = shown(CELL, "built(-3)")
    assert "----> 1 built(-3)" in out
    assert "return hc.Chain.uniform(beads)" in out
    assert out.rstrip().endswith("InputError: beads must be a whole number of at least 1, got -3")
    assert "src/hertzchain" not in out
    assert "checked_beads" not in out


def test_runs_that_end_too_early_have_a_short_traceback():
    cells = "run.reflection(3, 12)", "run.fource", "print(run.fource)"
    out = shown(CELL, "run = hc.simulate(built(20), until=5.0)", *cells)
    assert "----> 1 run.reflection(3, 12)" in out
    assert (
        out.count("AttributeError: 'Run' object has no attribute 'fource'; did you mean 'force'?")
        == 2
    )
    assert "SimulationError: " in out
    assert "src/hertzchain" not in out
    out = shown("import hertzchain as hc", "raise hc.StoreError('the disk is full')")
    assert out.rstrip().endswith("StoreError: the disk is full")


def test_the_complete_traceback_remains_available():
    names = "print([each.name for each in traceback.extract_tb(sys.last_traceback)])"
    out = shown(CELL, "built(-3)", "%xmode Verbose", "%tb", "import sys, traceback", names)
    assert "checked_beads" in out.partition("Verbose")[2].partition("['")[0]
    assert "'uniform', 'checked_beads', 'whole_number']" in out


def test_lines_of_the_user_that_the_package_calls_are_shown():
    own = "def progress(done, total):\n    hc.Chain.uniform(0)\n"
    out = shown(CELL, own, "hc.simulate(built(5), progress=progress)")
    assert "hc.simulate(built(5), progress=progress)" in out
    assert "----> 2     hc.Chain.uniform(0)" in out
    assert "src/hertzchain" not in out


def test_other_errors_are_complete():
    out = shown("import hertzchain.units, hertzchain.errors",
                "hertzchain.errors.raise_all(3)")  # fmt: skip
    assert "src/hertzchain" in out or "hertzchain/errors.py" in out


def test_python_shows_the_complete_traceback():
    with pytest.raises(hc.InputError) as caught:
        hc.Chain.uniform(-3)
    # Outside of IPython, the method returns the complete traceback, too.
    names = "".join(caught.value._render_traceback_())
    assert "checked_beads" in names
    assert names == "".join(traceback.format_exception(caught.value))
