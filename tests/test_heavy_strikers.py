"""Impacts of heavy strikers on columns under gravity: the end of the first impact."""

import functools
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import hertzchain as hc

pytestmark = pytest.mark.filterwarnings("ignore::hertzchain.errors.ModelRangeWarning")

GRAVITY, BALLS, RADIUS, STRIKER = 9.81, 12, 19.05e-3 / 2, 0.5
CELL = 2e8
NYLON = hc.material("nylon")


def column(height="5 mm", gravity=GRAVITY):
    row = hc.Chain.from_materials(
        diameters="19.05 mm", materials="nylon", beads=BALLS, gravity=gravity,
        right_wall=hc.Wall(CELL, exponent=1),
    )  # fmt: skip
    return row.struck_by(mass=STRIKER, radius="inf", height=height)


@functools.cache
def integrated(height):
    """Peak, its time, end and impulse of the first contact with the cell, by SciPy."""
    modulus = NYLON.young / (2.0 * (1.0 - NYLON.poisson**2))
    masses = np.array([STRIKER] + [4.0 / 3.0 * math.pi * NYLON.density * RADIUS**3] * BALLS)
    radii = np.array([RADIUS] + [RADIUS / 2.0] * (BALLS - 1))
    stiffness = 4.0 / 3.0 * modulus * np.sqrt(radii)
    weights = np.cumsum(masses[1:]) * GRAVITY
    x = np.zeros(BALLS + 1)
    x[BALLS] = weights[-1] / CELL
    for i in range(BALLS - 1, 0, -1):
        x[i] = x[i + 1] + (weights[i - 1] / stiffness[i]) ** (2.0 / 3.0)
    x[0] = x[1]
    v = np.zeros(BALLS + 1)
    v[0] = math.sqrt(2.0 * 9.80665 * height)

    def forces(x):
        overlaps = np.maximum(np.append(x[:-1] - x[1:], x[-1]), 0.0)
        return np.append(stiffness * overlaps[:-1] ** 1.5, CELL * overlaps[-1])

    def rates(_, y):
        f = forces(y[: BALLS + 1])
        return [*y[BALLS + 1 : -1], *((np.append(0.0, f[:-1]) - f) / masses + GRAVITY), f[-1]]

    def leaves(_, y):
        return y[BALLS]

    leaves.terminal, leaves.direction = True, -1
    found = solve_ivp(
        rates, (0.0, 20e-3), [*x, *v, 0.0], method="DOP853", rtol=1e-10, atol=1e-13,
        events=leaves, max_step=4e-6,
    )  # fmt: skip
    force = CELL * found.y[BALLS]
    return force.max(), found.t[np.argmax(force)], found.t[-1], found.y[-1, -1]


@pytest.fixture(scope="module")
def run():
    return hc.simulate(column())


def test_the_first_impact_on_soft_balls_is_over_when_the_striker_has_rebounded(run):
    """With a stiff cell, the energy that rattles in the row could otherwise exceed any peak."""
    peak, time, end, impulse = integrated(5e-3)
    wall = run.wall_force()
    assert wall.complete
    assert not wall.proven
    assert wall.peak == pytest.approx(peak, rel=2e-4)
    assert wall.peak_time == pytest.approx(time, abs=4e-6)
    # The static force remains for a while after the force has fallen to it.
    assert wall.complete_since == pytest.approx(end, rel=0.01)
    assert wall.impulse_of_impact == pytest.approx(impulse, rel=1e-3)
    assert wall.duration == pytest.approx((impulse - end * wall.static_force) / peak, rel=0.01)
    assert "later impact may be stronger" in repr(wall)
    # The striker takes most of the energy away.
    kinetic = 0.5 * run.chain.masses * run.velocities[-1] ** 2
    assert run.velocities[-1, 0] < 0.0
    assert kinetic[0] > 0.9 * kinetic.sum()


@pytest.mark.parametrize("until", ["20 ms", "40 ms"])
def test_the_first_impact_remains_over_while_the_striker_falls_back(run, until):
    first, later = run.wall_force(), hc.simulate(column(), until=until).wall_force()
    for name in ("peak", "peak_time", "complete_since", "impulse_of_impact", "duration"):
        assert getattr(later, name) == pytest.approx(getattr(first, name), rel=1e-9)
    assert later.impulse > first.impulse


def test_a_stronger_later_impact_replaces_the_first_one(run):
    second = hc.simulate(column(), until="90 ms").wall_force()
    assert second.largest_so_far > 2.0 * run.wall_force().peak
    assert second.largest_so_far_time > 50e-3
    assert not second.complete or second.peak == second.largest_so_far


def test_ensembles_and_gradients_have_the_same_peak(run):
    wall = run.wall_force()
    table = hc.simulate_many(
        [column()], keep=["wall_peak_force", "wall_impulse_of_impact"], check_range=False
    )
    assert table["wall_peak_force"][0] == pytest.approx(wall.peak, rel=1e-6)
    assert table["wall_impulse_of_impact"][0] == pytest.approx(wall.impulse_of_impact, rel=1e-3)
    late = hc.simulate_many([column()], keep="wall_peak_force", until=20e-3, check_range=False)
    assert late["wall_peak_force"][0] == pytest.approx(wall.peak, rel=1e-6)
    slope = hc.gradient(column(), "wall_force.peak", to="velocities", until="20 ms")
    assert slope.value == pytest.approx(wall.peak, rel=1e-6)


def test_a_row_that_is_still_pressed_is_not_over():
    """Before the striker has left the row, its motion may still cause a larger force."""
    with pytest.warns(hc.IncompleteWarning, match="moves or can fall towards the wall"):
        early = hc.simulate(column(), until="6 ms").wall_force()
    assert not early.complete


def test_losses_do_not_keep_the_impact_from_ending():
    lossy = column().replace(loss=hc.Viscoelastic("7 us"))
    wall = hc.simulate(lossy).wall_force()
    assert wall.complete
    assert wall.peak < 125.0
    plastic = hc.simulate(column().replace(loss=hc.ElasticPlastic())).wall_force()
    assert plastic.complete
