"""Balance of the energy of all waves between two contacts."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import hertzchain as hc


def dimer(ratio, beads=140, last=70):
    """A dimer of masses 1 and ratio, then beads of mass 1."""
    masses = np.ones(beads)
    masses[1:last:2] = ratio
    return hc.Chain.uniform(beads).replace(masses=masses)


def flux_by_scipy(masses, contact, until):
    """Energy to the right and to the left through a contact; DOP853 and the trapezoidal rule."""
    beads, (k, p) = len(masses), (1.0, 1.5)

    def rate(_, y):
        x, v = y[:beads], y[beads:]
        force = k * np.maximum(x[:-1] - x[1:], 0.0) ** p
        return np.concatenate((v, (np.append(0.0, force) - np.append(force, 0.0)) / masses))

    start = np.zeros(2 * beads)
    start[beads] = 1.0
    times = np.linspace(0.0, until, 20_001)
    y = solve_ivp(rate, (0.0, until), start, "DOP853", times, rtol=1e-10, atol=1e-12).y
    j = contact - 1
    force = k * np.maximum(y[j] - y[j + 1], 0.0) ** p
    power = 0.5 * force * (y[beads + j] + y[beads + j + 1])
    return [np.trapezoid(np.maximum(sign * power, 0.0), times) for sign in (1.0, -1.0)]


def test_the_balance_of_a_dimer_agrees_with_scipy():
    chain = dimer(0.5, beads=60, last=30)
    flux = hc.simulate(chain, until=58.0, times=2000).energy_flux()
    right, left = flux_by_scipy(chain.masses, 20, 58.0)
    to, fro = flux_by_scipy(chain.masses, 30, 58.0)
    found = flux.balance(20, 30)
    assert found.incident_energy == pytest.approx(right, rel=1e-5)
    assert found.returned_energy == pytest.approx(left / right, rel=1e-3)
    assert found.passed_energy == pytest.approx((to - fro) / right, rel=1e-5)
    assert found.returned_energy + found.passed_energy + found.kept_energy == 1.0
    nearby = flux.left[13:19] / flux.right[13:19]
    assert found.nearby_energy == (nearby.min(), nearby.max())


def test_waves_to_the_left_and_walls():
    chain = hc.Chain.uniform(40).replace(right_wall=hc.Wall.rigid())
    flux = hc.simulate(chain, until=80.0, times=800).energy_flux()
    wall = flux.balance(25, "wall")
    assert (wall.after, wall.passed_energy) == (40, 0.0)
    assert wall.returned_energy == pytest.approx(1.0, abs=1e-3)
    back = flux.balance(25, 10)
    assert back.incident_energy == flux.left[24]
    assert back.passed_energy == pytest.approx(-flux.net[9] / flux.left[24])


def test_contacts_without_energy_are_named():
    flux = hc.simulate(hc.Chain.uniform(30), until=20.0, times=400).energy_flux()
    with pytest.raises(hc.SimulationError, match="no energy flows through contact 20 towards"):
        flux.balance(20, 10)
    with pytest.raises(hc.InputError, match="must be two contacts, got 20 twice"):
        flux.balance(20, 20)


def test_reflection_names_the_balance_where_a_dimer_sheds_waves():
    run = hc.simulate(dimer(0.5), until=130.0, times=4000)
    with pytest.raises(hc.SimulationError, match=r"energy_flux\(\)\.balance\(54, 84\)"):
        run.reflection(54, 84)
    # Where the dimer continues, the energy that the interface reflects is not in front of it.
    longer = hc.simulate(dimer(0.5, last=140), until=130.0, times=4000).energy_flux()
    found = run.energy_flux().balance(54, 70)
    missing = (longer.net - run.energy_flux().net)[53] / found.incident_energy
    assert missing == pytest.approx(found.returned_energy, abs=0.005)
