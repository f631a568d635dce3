"""The excess energy of a budget: that over the static state, from the work of net forces."""

import numpy as np
import pytest

import hertzchain as hc
from hertzchain import Chain, Wall

# Nodes and weights on [0, 1]; forces are smooth while no contact opens.
NODES, WEIGHTS = np.polynomial.legendre.leggauss(40)
NODES, WEIGHTS = (NODES + 1.0) / 2.0, WEIGHTS / 2.0
ROW = Chain.from_radii([1.0, 0.7, 1.3, 0.9, 1.1, 0.8])
SUPPORTS = {
    "held by forces": {"precompression": 1.0, "held_by": "force"},
    "between walls": {"precompression": 1.0, "left_wall": Wall(), "right_wall": Wall(0.7)},
    "pressed on a wall": {"precompression": 0.5, "held_by": "force", "right_wall": Wall()},
    "hanging in a tube": {
        "precompression": 0.2, "gravity": -0.1, "left_wall": Wall(), "right_wall": Wall(),
    },
}  # fmt: skip


def potential(chain, positions):
    """Work against the net forces on the straight way from the static state."""
    state = hc.equilibrium(chain)
    moved = positions - state.positions
    found = 0.0
    for node, weight in zip(NODES, WEIGHTS, strict=True):
        x = np.concatenate(([0.0], state.positions + node * moved, [0.0]))
        overlaps = np.maximum(x[:-1] - x[1:] - state.gaps, 0.0)
        forces = chain.contact_stiffness * overlaps**chain.exponent
        found -= weight * (forces[:-1] - forces[1:] + state.body_forces) @ moved
    return found


@pytest.mark.parametrize("support", SUPPORTS)
def test_excess_energy_is_the_work_against_the_net_forces(support):
    chain = ROW.replace(velocities=[0.1, *[0.0] * 5], **SUPPORTS[support])
    run = hc.simulate(chain, until=15.0, times=40)
    budget = run.budget().over_static()
    stored = budget.energy["contacts"] + budget.energy["walls"]
    expected = [potential(chain, positions) for positions in run.positions]
    impact = 0.5 * chain.masses[0] * 0.1**2
    assert run.forces[:, 1:-1].min() > 0.0
    assert stored.max() > 0.3 * impact
    assert stored.min() >= 0.0
    np.testing.assert_allclose(stored, expected, atol=1e-10 * impact)
    # It is conserved: there is neither a drive nor a loss.
    np.testing.assert_allclose(budget.kinetic_energy + expected, impact, rtol=1e-10)
    assert budget.energy_given["start"] == pytest.approx(impact, rel=1e-10)
    for origin in ("gravity", "drive", "held ends"):
        assert not budget.energy_given[origin].any()


def test_excess_energy_of_a_driven_wall_is_the_work_beyond_the_static_force():
    burst = hc.SineBurst(amplitude=0.02, frequency=0.1, cycles=3, of="displacement")
    chain = ROW.replace(velocities=[0.0] * 6, drive=burst, **SUPPORTS["between walls"])
    run = hc.simulate(chain, until=30.0, times=3001)
    budget = run.budget().over_static()
    force = run.forces[:, 0] - hc.equilibrium(chain).forces[0]
    work = np.trapezoid(force, burst.value(run.times))
    assert budget.energy_given["drive"][-1] == pytest.approx(work, rel=1e-4)
    assert np.abs(budget.residual("energy")).max() < 1e-10


def test_strikers_above_a_resting_row_fall_freely():
    row = ROW.replace(loss=hc.Restitution(0.9)).struck_by(velocity=0.5, gap=1.0)
    run = hc.simulate(row.replace(gravity=0.1, right_wall=Wall()), until=10.0)
    budget = run.budget().over_static()
    fallen = run.positions[:, 0] - run.positions[0, 0]
    np.testing.assert_allclose(
        budget.energy_given["gravity"], 0.1 * row.masses[0] * fallen, atol=1e-12
    )
    assert np.abs(budget.residual("energy")).max() < 1e-10


def test_without_static_forces_all_energy_is_excess_energy():
    run = hc.simulate(ROW.replace(loss=hc.Restitution(0.9), right_wall=Wall()), until=20.0)
    one, other = run.budget(), run.budget().over_static()
    for name, values in one.energy.items():
        np.testing.assert_array_equal(values, other.energy[name])
    assert one.plot().get_ylabel() == "energy"
    assert other.plot().get_ylabel() == "excess energy"
    for text in (repr(other), str(other)):
        assert "excess energy" in text
