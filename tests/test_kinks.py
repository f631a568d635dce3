"""Contacts that open or close within a step of `simulate_many`, against quadrature and scans."""

import numpy as np
import pytest
from kernel_call import callable_from_python
from scipy.integrate import quad

import hertzchain as hc
from hertzchain.kernels import elastic_chains, elastic_kinks, rkn8
from hertzchain.kernels import elastic_layout as layout
from hertzchain.simulation.ensemble_input import kernel_input

H, LEFT, RIGHT, AT = 0.7, 2.0, 0.5, 5 * layout.LANES + 1


def kink(sign, q):
    """A kink that begins before or after the start of a step, or ends in it."""
    entries = np.zeros(layout.KINK_ROWS)
    entries[layout.KINK_AT], entries[layout.KINK_SIGN] = AT, sign
    entries[layout.KINK_Q], entries[layout.KINK_A], entries[layout.KINK_B] = q, 1.3, -0.4
    entries[layout.KINK_LEFT], entries[layout.KINK_RIGHT] = LEFT, RIGHT
    entries[layout.KINK_STEP] = H
    callable_from_python(elastic_kinks.set_shifts)(entries, 1)
    return entries


def force(entries, t):
    """The subtracted terms at a time within the step."""
    q = max(entries[layout.KINK_Q] + entries[layout.KINK_SIGN] * t, 0.0)
    return q**1.5 * (entries[layout.KINK_A] + entries[layout.KINK_B] * q)


def motion(entries, end):
    """Change of position and velocity of unit mass by the terms, by quadrature."""
    q = abs(entries[layout.KINK_Q])
    options = {"points": [q] if 0.0 < q < end else None, "epsabs": 1e-14, "epsrel": 1e-13}
    position = quad(lambda t: (end - t) * force(entries, t), 0.0, end, **options)[0]
    return position, quad(lambda t: force(entries, t), 0.0, end, **options)[0]


@pytest.mark.parametrize(("sign", "q"), [(1.0, -0.3), (1.0, 0.1), (-1.0, 0.4), (-1.0, 0.9)])
def test_shifts_are_the_defects_of_the_method(sign, q):
    """The method's own sums over the stages, less the motion by quadrature."""
    entries = kink(sign, q)
    at_stages = np.array([force(entries, c * H) for c in (0.0, *rkn8.C)])
    for stage, (c, weights) in enumerate(zip(rkn8.C, rkn8.A, strict=True), 1):
        exact = H**2 * np.dot(weights, at_stages[:stage]) - motion(entries, c * H)[0]
        assert entries[layout.KINK_SHIFT + stage * layout.MAX_KINKS] == pytest.approx(
            exact, abs=1e-12
        )
    position, velocity = motion(entries, H)
    exact = H**2 * np.dot(rkn8.B_POSITION, at_stages[:7]) - position
    assert entries[layout.KINK_SHIFT_X] == pytest.approx(exact, abs=1e-12)
    exact = H * np.dot(rkn8.B_VELOCITY, at_stages) - velocity
    assert entries[layout.KINK_SHIFT_V] == pytest.approx(exact, abs=1e-12)
    at_ends = np.append(at_stages, force(entries, H))
    exact = np.dot(rkn8.E_VELOCITY, at_ends)
    assert entries[layout.KINK_ERROR] == pytest.approx(exact, abs=1e-12)


@pytest.mark.parametrize(("sign", "q"), [(1.0, -0.3), (-1.0, 0.4)])
def test_the_motion_of_both_beads(sign, q):
    entries, kink_motion = kink(sign, q), callable_from_python(elastic_kinks.kink_motion)
    for slot, mass in ((AT, -LEFT), (AT + layout.LANES, RIGHT), (AT + 2 * layout.LANES, 0.0)):
        found = kink_motion(entries, 1, slot, 0.5)
        position, velocity = motion(entries, 0.5)
        assert found[0] == pytest.approx(mass * position, abs=1e-12)
        assert found[1] == pytest.approx(mass * velocity, abs=1e-12)
        assert found[2] == pytest.approx(mass * force(entries, 0.5), abs=1e-12)
        rate = (force(entries, 0.5 + 1e-6) - force(entries, 0.5 - 1e-6)) / 2e-6
        assert found[3] == pytest.approx(mass * rate, abs=1e-8)


def peaks_and_steps(chains, rtol, *, kinks):
    """Largest forces on the wall and tried steps; without kinks by the kernel of any exponent."""
    given, count = kernel_input(chains, None), len(chains)
    beads = chains[0].beads
    records, summary = np.zeros((count, layout.RECORDS, beads)), np.zeros((count, layout.SUMMARY))
    readings = np.zeros((count, 1, layout.GAUGE_ROWS))
    elastic_chains.follow(
        given.chains, given.numbers, np.array([(beads, beads)]), rtol, 1e6, kinks, given.walled,
        given.careful, records, summary, readings, np.zeros(2, np.int64),
        *elastic_chains.scratch_for(1),
    )  # fmt: skip
    tried = summary[:, layout.TAKEN] + summary[:, layout.REFUSED]
    return readings[:, 0, layout.PEAK], float(tried.mean())


def test_steps_are_not_shortened_at_kinks():
    rng, wall = np.random.default_rng(3), hc.Wall.of("steel-52100")
    chains = [
        hc.Chain.from_materials(
            np.full(12, 4.76e-3), np.where(rng.random(12) < 0.5, "steel-52100", "ptfe").tolist(),
            velocity=0.05, right_wall=wall,
        )
        for _ in range(40)
    ]  # fmt: skip
    exact, _ = peaks_and_steps(chains, 1e-12, kinks=False)
    found, steps = peaks_and_steps(chains, 1e-6, kinks=True)
    other, more = peaks_and_steps(chains, 1e-6, kinks=False)
    assert steps < 0.6 * more
    assert np.median(np.abs(found / exact - 1.0)) < 2e-7
    assert np.quantile(np.abs(found / exact - 1.0), 0.95) < 1e-5
    assert np.quantile(np.abs(other / exact - 1.0), 0.95) < 1e-5
