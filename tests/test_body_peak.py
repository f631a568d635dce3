"""The force on the last body of a free end, as a method of a run."""

import math
from dataclasses import replace

import numpy as np
import pytest

import hertzchain as hc
from hertzchain import IncompleteWarning, InputError
from hertzchain.cli.last_bead import body_as_dict

ROW = hc.Chain.from_materials(diameters="10 mm", materials="steel-52100", beads=4)
BOX = ROW.with_cap("100 g").struck_by(mass="50 g", radius="flat", velocity="0.1 m/s")


def test_the_peak_is_that_of_a_fine_grid_of_times():
    found = hc.simulate(BOX, times=0).body_force()
    fine = hc.simulate(BOX, until="1 ms", times=40_001)
    force = fine.force(5)
    assert found.complete
    assert found.peak == found.force == pytest.approx(force.max(), rel=1e-5)
    assert found.time == pytest.approx(fine.times[force.argmax()], abs=3e-8)
    assert found.acceleration == pytest.approx(force.max() / 0.1, rel=1e-5)
    top = int(force.argmax())
    quiet = np.flatnonzero(force < 0.1 * force.max())
    before, after = quiet[quiet < top][-1], quiet[quiet > top][0]
    assert found.duration == pytest.approx(fine.times[after] - fine.times[before], abs=1e-7)


def test_the_method_and_the_command_have_the_same_numbers():
    run = hc.simulate(BOX)
    found, document = run.body_force(), body_as_dict(run)
    assert (found.force, found.acceleration, found.complete) == (
        document["force"], document["acceleration"], document["complete"]
    )  # fmt: skip


def test_a_short_run_has_no_peak():
    whole = hc.simulate(BOX).body_force()
    run = hc.simulate(BOX, until=1.4 * whole.time)
    with pytest.warns(IncompleteWarning, match="the force on the cap is not complete at the end"):
        found = run.body_force()
    assert math.isnan(found.peak)
    assert found.force == pytest.approx(whole.force, rel=1e-6)
    run = hc.simulate(BOX, until=0.2 * whole.time)
    with pytest.warns(IncompleteWarning, match="has no maximum yet"):
        found = run.body_force()
    assert math.isnan(found.force)
    assert not found.complete


def test_representations_have_units_and_the_name_of_the_cap():
    run = hc.simulate(BOX)
    found = run.body_force()
    for card in (f"{found!r}", found._repr_html_()):
        # Accelerations have no prefix, so that they can be compared with each other.
        words = card.replace("\N{NO-BREAK SPACE}", " ").replace("\n   ", "")
        for text in (f"{found.peak:.4g} N", f"{found.acceleration:.4g} m/s^2"):
            assert text in words
        assert f"{1e6 * found.duration:.4g} " in words
    assert "mass 0.1 kg" in repr(found)
    curves = run._repr_html_().partition("<svg")[0]
    assert "cap</span>" in curves
    assert f"bead {run.chain.beads}" not in curves
    scaled = hc.simulate(hc.Chain.uniform(4)).body_force()
    assert "m/s" not in repr(scaled) + scaled._repr_html_()
    fast = replace(found, force=500.0, mass=0.01)
    assert "acceleration 50000 m/s^2" in repr(fast)
    assert "50000 m/s^2" in fast._repr_html_().replace("\N{NO-BREAK SPACE}", " ")


def test_a_wall_has_its_own_method():
    with pytest.raises(InputError, match="this chain has a right wall: use wall_force"):
        hc.simulate(ROW.replace(right_wall=hc.Wall(), velocities=[0.1, 0, 0, 0])).body_force()


def test_the_card_of_a_run_shows_the_force_on_a_cap_or_a_wall():
    run = hc.simulate(BOX)
    card = run._repr_html_()
    assert "cap, largest force" in card
    assert f"{run.body_force().peak:.4g} N" in card.replace("\N{NO-BREAK SPACE}", " ")
    walled = hc.simulate(ROW.struck_by(velocity="0.1 m/s").replace(right_wall=hc.Wall()))
    card = walled._repr_html_()
    assert "right wall, largest force" in card
    assert f"{walled.wall_force().peak:.4g} N" in card.replace("\N{NO-BREAK SPACE}", " ")
