import numpy as np
import pytest
from PIL import Image

import hertzchain as hc
from hertzchain.pictures import animate, bead_centres, plot_budget, plot_chain, plot_forces


@pytest.fixture(scope="module")
def run():
    chain = hc.Chain.tapered("forward-exponential", 0.05, beads=12)
    return hc.simulate(chain.replace(right_wall=hc.Wall()), until=40.0, times=200)


def test_traces_are_the_sensors(run):
    axes = plot_forces(run, [4, 13])
    np.testing.assert_array_equal(axes.lines[0].get_ydata(), run.sensor(4))
    np.testing.assert_array_equal(axes.lines[1].get_ydata(), run.wall_force().force)


def test_si_is_drawn_in_microseconds_and_newtons():
    chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=5, velocity=0.1)
    run = hc.simulate(chain, until=1e-4, times=50)
    axes = plot_forces(run, [2])
    assert axes.lines[0].get_xdata()[-1] == pytest.approx(100.0)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("time [µs]", "force [N]")
    assert run.plot("force").get_xlabel() == "time [µs]"


@pytest.mark.parametrize("of", ["energy", "momentum"])
def test_the_stack_ends_at_what_was_given(run, of):
    budget = run.budget()
    axes = plot_budget(budget, of)
    given = sum((budget.energy_given if of == "energy" else budget.momentum_given).values())
    top = max(path.get_paths()[0].vertices[:, 1].max() for path in axes.collections
              if path.get_paths())  # fmt: skip
    line = axes.lines[0].get_ydata()
    np.testing.assert_allclose(line, given)
    assert top >= line.max() - 1e-9
    if of == "energy":
        assert top == pytest.approx(line.max(), rel=1e-9)


def test_the_chain_is_to_scale():
    chain = hc.Chain.from_radii([2.0, 1.0, 3.0])
    np.testing.assert_allclose(bead_centres(chain), [1.0, 2.5, 4.5])
    radii = [patch.vertices[:, 0].max() for patch in plot_chain(chain).collections[0].get_paths()]
    assert len(radii) == 3


def test_an_animation_moves(run, tmp_path):
    file = animate(run, tmp_path / "beads.gif", frames=6)
    with Image.open(file) as pictures:
        assert pictures.n_frames == 6
        first = np.asarray(pictures.convert("RGB"))
        pictures.seek(3)
        assert np.any(np.asarray(pictures.convert("RGB")) != first)


def test_bad_requests(run, tmp_path):
    with pytest.raises(hc.InputError, match=r"\.gif file"):
        animate(run, tmp_path / "beads.mp4")
    with pytest.raises(hc.InputError, match="there is no bead 99"):
        plot_forces(run, [99])
    with pytest.raises(hc.InputError, match="unknown balance"):
        plot_budget(run.budget(), "mass")
    with pytest.raises(hc.InputError, match="unknown quantity of a map"):
        run.plot("mass")
