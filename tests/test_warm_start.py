import gc
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import hertzchain as hc
from hertzchain import warm_start
from hertzchain.warm_start import FIRST, STAGES, Stage, compile_stages

# Functions that Python calls and that are compiled when the stages have been run.
COMPILED_NOW = """
import sys
import hertzchain as hc
assert hc.__file__.startswith(sys.argv[1])
from numba.core import event
found = []
class Listener(event.Listener):
    def on_start(self, event):
        found.append(event.data["dispatcher"].py_func.__qualname__)
    def on_end(self, event):
        pass
event.register("numba:compile", Listener())
chain = hc.Chain.tapered("forward-exponential", 0.03, beads=9)
steel = hc.Chain.from_materials([0.01, 0.008, 0.012], "steel-52100", velocity=0.1)
other = hc.Chain.from_radii([1, 2, 1.5], exponent=2.2)
hc.propagate(chain), hc.propagate_many([chain] * 5), hc.propagate(steel), hc.propagate(other)
for exponent in (1.5, 1.7, 2.0):
    other_law = hc.Chain.from_radii(chain.radii, exponent=exponent)
    hc.local_rate(other_law), hc.local_rate_gradient(other_law, "velocity", bead=2)
for loss in (None, hc.Dashpot(0.2), hc.Viscoelastic(0.1), hc.Restitution(0.8), hc.WaltonBraun(0.6)):
    walled = chain.replace(right_wall=hc.Wall(), loss=loss)
    hc.simulate(walled, rtol=1e-6, until=2.0)
    if loss is None or isinstance(loss, hc.Dashpot):
        hc.gradient(walled, "wall_force.peak")
hc.gradient(chain, "velocity@4"), hc.gradient(steel, "peak_force@2")
hc.design(hc.Design(chain, minimise="velocity@5", vary=[hc.vary.radii(0.5, 2.0)]), budget=100)
mixed = chain.replace(right_wall=hc.Wall(stiffness=1.0), exponent=[1.5] * 4 + [2.0] * 4)
hc.simulate(mixed, until=2.0)
hc.simulate(chain.replace(loss=[None] * 4 + [hc.Dashpot(0.2)] * 4), until=2.0)
hc.simulate(chain)
for each in (chain, chain.replace(right_wall=hc.Wall()), mixed):
    for method in ("verlet", "forward-4"):
        hc.simulate(each, method=method, until=2.0)
hc.simulate_many([chain, chain], keep=["peak_force"])
print(sorted(set(found)))
"""


def test_stages_can_be_compiled_and_are_counted():
    done, thresholds = [], gc.get_threshold()
    compile_stages(range(len(STAGES)), lambda: done.append(gc.get_threshold()))
    assert len(done) == len(STAGES)
    # The garbage collector runs less often, but only meanwhile.
    assert thresholds not in done
    assert gc.get_threshold() == thresholds
    assert STAGES[: len(FIRST)] == FIRST


def test_progress_reaches_the_end_and_the_time_is_returned():
    counts = []
    seconds = hc.warm_up(first=True, progress=lambda *each: counts.append(each))
    assert counts == [(done, len(FIRST)) for done in range(1, len(FIRST) + 1)]
    assert 0.0 < seconds < 600.0


def test_one_processor_compiles_in_this_process(monkeypatch):
    done = []
    stages = tuple(Stage(each.name, lambda _: done.append(1), each.general) for each in STAGES)
    monkeypatch.setattr(warm_start, "STAGES", stages)
    monkeypatch.setattr(warm_start, "worker_count", lambda *_: 1)
    hc.warm_up()
    assert len(done) == len(STAGES)


@pytest.mark.long
def test_a_script_without_a_guard(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        "import hertzchain as hc\nprint('begin')\nprint(hc.warm_up(first=True) > 0)\n", "utf-8"
    )
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("begin\nTrue\n", "")


def test_a_kernel_that_fails_is_reported(monkeypatch):
    monkeypatch.setattr(
        warm_start, "PROGRAM", "import sys; print('text', file=sys.stderr); raise SystemExit(3)"
    )
    monkeypatch.setattr(warm_start, "worker_count", lambda *_: 2)
    with pytest.raises(hc.SimulationError, match="a kernel cannot be compiled: text"):
        hc.warm_up()


def test_the_command_says_how_long_it_took(run, monkeypatch):
    monkeypatch.setattr(hc, "warm_up", lambda first, **_: 2.5 if first else 7.3)
    assert run("warm-up").stdout == "All kernels are compiled (7.3 s).\n"
    assert run("warm-up", "--first").stdout == "The first kernels are compiled (2.5 s).\n"


@pytest.mark.long
def test_nothing_that_people_call_is_compiled_afterwards(tmp_path):
    package = tmp_path / "hertzchain"
    shutil.copytree(Path(hc.__file__).parent, package, ignore=shutil.ignore_patterns("__pycache__"))
    paths = f"import sys; sys.path.insert(0, {str(tmp_path)!r})\n"
    for program in ("import hertzchain as hc; hc.warm_up()", COMPILED_NOW):
        command = [sys.executable, "-c", paths + program, str(tmp_path)]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
