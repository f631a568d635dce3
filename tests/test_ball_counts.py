"""One ball more or fewer in front of a cap; data are from SciPy."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import hertzchain as hc
from hertzchain.chain.cap import Cap
from hertzchain.fitting.ball_counts import ball_count, with_ball_fewer, with_ball_more
from hertzchain.fitting.causes import Cause
from hertzchain.fitting.diagnosis import _place_or_count

S, B = "steel-52100", "brass"
PAD = {"stiffness": "1 kN/mm", "exponent": 1}
SPACING, BEFORE = 1e-6, 80
# Density, Young's modulus and Poisson's ratio.
CONSTANTS = {S: (7780.0, 203e9, 0.3), B: (8530.0, 101e9, 0.35), "steel-304": (8000.0, 193e9, 0.3)}


def row(kinds, loss_time="1 us", cap=True, **options):
    """Balls between a striker and a load cell with a cap."""
    cell = hc.Wall("100 kN/mm", exponent=1, loss=hc.Elastic())
    balls = hc.Chain.from_materials(diameters="12 mm", materials=kinds)
    chain = balls.struck_by(velocity="0.1 m/s", material=S).replace(right_wall=cell)
    chain = chain.replace(loss=hc.Viscoelastic(loss_time))
    return chain.with_cap("5 g", material="steel-304", **options) if cap else chain


@pytest.mark.parametrize("options", [{}, PAD, {"cap": False}])
@pytest.mark.parametrize(("kinds", "following"), [
    ([S] * 5, S), ([S] * 3 + [B] * 3, B), ([S, B] * 3, S), ([S, B, B] * 2 + [S], B),
])  # fmt: skip
def test_a_ball_continues_the_pattern_in_front_of_the_cap(kinds, following, options):
    chain = row(kinds, **options)
    assert ball_count(chain) == len(kinds)
    assert with_ball_more(chain) == row([*kinds, following], **options)
    assert with_ball_fewer(chain) == row(kinds[:-1], **options)


def test_listed_values_move_with_their_balls():
    chain = row([S, B] * 3).replace(gaps=1e-9 * np.arange(7.0))
    masses = np.arange(1.0, 9.0) * 1e-3
    assert (with_ball_more(chain).gaps == 1e-9 * np.array([0, 1, 2, 3, 4, 5, 4, 6])).all()
    assert (with_ball_fewer(chain).gaps == 1e-9 * np.array([0, 1, 2, 3, 4, 6])).all()
    given = chain.replace(masses=masses, cap=Cap())
    assert (with_ball_more(given).masses == 1e-3 * np.array([1, 2, 3, 4, 5, 6, 7, 7, 8])).all()
    assert (with_ball_fewer(given).masses == 1e-3 * np.array([1, 2, 3, 4, 5, 6, 8])).all()


def test_a_row_of_one_ball_is_not_changed():
    for change in (with_ball_more, with_ball_fewer):
        with pytest.raises(hc.InputError, match="a row of one ball"):
            change(row([S]))


def forces(kinds, times, radius=6e-3, loss=0.8e-6, cap=5e-3, cell=1e8):
    """Forces of the contacts of `row`, from SciPy: a striker, balls, a cap and a linear cell."""
    bodies = [S, *kinds, "steel-304"]
    masses = np.array([CONSTANTS[each][0] * 4.0 / 3.0 * np.pi * radius**3 for each in bodies])
    masses[-1] = cap
    softness = np.array([(1.0 - nu**2) / young for _, young, nu in map(CONSTANTS.get, bodies)])
    reduced = np.array([radius / 2.0] * len(kinds) + [radius])
    k = 4.0 / 3.0 * np.sqrt(reduced) / (softness[:-1] + softness[1:])
    count = len(bodies)

    def forces_of(x, v):
        overlap, rate = np.maximum(x[:-1] - x[1:], 0.0), v[:-1] - v[1:]
        inner = k.reshape(-1, *[1] * (x.ndim - 1)) * (
            overlap**1.5 + 1.5 * loss * overlap**0.5 * rate
        )
        return np.concatenate((np.maximum(inner, 0.0), cell * np.maximum(x[-1:], 0.0)))

    def derivatives(_, y):
        force = forces_of(y[:count], y[count:])
        return np.concatenate((y[count:], (np.append(0.0, force[:-1]) - force) / masses))

    start = np.zeros(2 * count)
    start[count] = 0.1
    solved = solve_ivp(
        derivatives, (0.0, times[-1]), start, "DOP853", times, rtol=1e-9, atol=1e-14, max_step=2e-6
    )
    return forces_of(solved.y[:count], solved.y[count:])


@pytest.mark.parametrize(("true", "given", "words"), [
    pytest.param([S] * 8, [S] * 7, "one ball more (8)", marks=pytest.mark.long),
    ([S] * 4 + [B] * 4, [S] * 4 + [B] * 3, "one ball more (8)"),
    pytest.param([S] * 4 + [B] * 3, [S] * 4 + [B] * 4, "one ball fewer (7)",
                 marks=pytest.mark.long),
])  # fmt: skip
def test_a_missing_ball_is_named_in_a_row_with_a_cap(true, given, words):
    times = SPACING * np.arange(300)
    force = forces(true, times)
    seen = [0.5 * (force[2] + force[3]), 0.5 * (force[4] + force[5]), force[-1]]
    noise = np.random.default_rng(5).normal(0.0, 0.05, (3, BEFORE + len(times)))
    signals = noise + np.pad(seen, ((0, 0), (BEFORE, 0)))
    columns = dict(zip(("ball 3 [N]", "ball 5 [N]", "wall [N]"), signals, strict=True))
    traces = hc.Traces.from_arrays(SPACING * np.arange(signals.shape[1]), columns)
    free = ["stiffness", "loss.time", "struck_by.velocity", "time_offset"]
    found = hc.fit(traces, row(given), free=free, priors={"struck_by.velocity": (0.1, 0.002)})
    assert not found.describes
    (advice,) = found.advice
    assert advice.startswith(f"with {words}, chi2 falls from ")
    assert "and the model describes the data" in advice


def test_a_number_of_balls_is_named_beside_a_place_that_does_not_describe_the_data():
    def cause(what, chi2, describes=False, **kind):
        found = SimpleNamespace(chi2=chi2, describes=describes)
        return Cause(what, f"check {what}", found, 0, **kind)

    place, count = cause("a place", 76e3, place=True), cause("one more", 81e3, count=True)
    for best, other in ((place, count), (count, place)):
        assert f"With {other.what} instead, chi2 is " in _place_or_count(best, [place, count])
    assert not _place_or_count(place, [place, cause("one more", 3e5, count=True)])
    assert not _place_or_count(cause("a place", 900.0, True, place=True), [count])


@pytest.mark.long
def test_a_missing_ball_and_a_gap_are_named_without_the_full_search():
    chain = hc.Chain.from_materials("5 mm", S, beads=9).struck_by(velocity="0.3 m/s")
    chain = chain.replace(right_wall=hc.Wall(), loss=hc.Viscoelastic("0.5 us"))
    true = with_ball_fewer(chain).replace(gaps=[0, 0, 0, 0, 2e-6, 0, 0, 0])
    run = hc.simulate(true, times=SPACING * np.arange(300))
    seen = np.pad(
        [run.sensor("ball 3"), run.sensor("ball 7"), run.forces[:, -1]], ((0, 0), (80, 0))
    )
    seen += 0.1 * np.random.default_rng(3).standard_normal(seen.shape)
    columns = dict(zip(("ball 3 [N]", "ball 7 [N]", "wall [N]"), seen, strict=True))
    traces = hc.Traces.from_arrays(SPACING * np.arange(380), columns)
    free = ["stiffness", "loss.time", "struck_by.velocity", "time_offset"]
    found = hc.fit(traces, chain, free=free, diagnose=False)
    assert found.advice[0].startswith("with one ball fewer (8), and gap[4-5] = 2.0")
    assert "for a gap between balls 4 and 5 of the row with that number" in found.advice[0]
