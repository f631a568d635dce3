"""Dents of contacts that yield, in one impact and in two, and how they are reported."""

from __future__ import annotations

import dataclasses
import json
import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import hertzchain as hc
from hertzchain.chain.per_contact import contacts_in_words
from hertzchain.simulation.hits import peak_of_second_hit
from hertzchain.simulation.yielding import dents_in_words

pytestmark = pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
LAW = hc.ElasticPlastic()


class Thornton:
    """A contact of two steel balls, or of a ball with a plate, by the formulas of Thornton."""

    def __init__(self, radius):
        steel = hc.material("steel-52100")
        self.modulus = 0.5 * steel.young / (1.0 - steel.poisson**2)
        self.radius, self.pressure = radius, 1.6 * steel.yield_strength
        self.at = radius * (0.5 * math.pi * self.pressure / self.modulus) ** 2
        self.force_at = 4.0 / 3.0 * self.modulus * math.sqrt(radius) * self.at**1.5

    def load(self, d):
        if d <= self.at:
            return 4.0 / 3.0 * self.modulus * math.sqrt(self.radius) * max(d, 0.0) ** 1.5
        return self.force_at + math.pi * self.pressure * self.radius * (d - self.at)

    def unload(self, d, largest):
        """Force, on the curve of a Hertz contact of the larger radius."""
        if largest <= self.at:
            return self.load(d)
        k = self.stiffness(largest)
        return k * max(d - self.dent(largest), 0.0) ** 1.5

    def stiffness(self, largest):
        peak = self.load(largest)
        area = (2.0 * peak + self.force_at) / (2.0 * math.pi * self.pressure)
        radius = 4.0 * self.modulus / (3.0 * peak) * area**1.5
        return 4.0 / 3.0 * self.modulus * math.sqrt(radius)

    def dent(self, largest):
        if largest <= self.at:
            return 0.0
        return largest - (self.load(largest) / self.stiffness(largest)) ** (2.0 / 3.0)


def pair(speed, loss=LAW):
    return hc.Chain.from_materials(5e-3, "steel-52100", beads=2, velocity=speed, loss=loss)


def row(speed, **more):
    return hc.Chain.from_materials(
        [5e-3, 4e-3, 3e-3, 4e-3], "steel-52100", velocity=speed, loss=LAW,
        right_wall=hc.Wall.of("steel-52100"), **more,
    )  # fmt: skip


@pytest.mark.parametrize("speed", [0.3, 0.5, 2.0, 20.0])
def test_a_contact_opens_at_its_dent(speed):
    """The force of the kernel along unloading, to the power 2/3, reaches zero at the dent."""
    run = hc.simulate(pair(speed), until=2e-4, times=4001, rtol=1e-12)
    overlap, force = run.overlap(1), run.force(1)
    unloading = (np.arange(len(force)) > force.argmax()) & (force > 0.0)
    steps = np.flatnonzero(unloading)[[0, -1]]
    (d1, d2), (f1, f2) = overlap[steps], force[steps] ** (2.0 / 3.0)
    opens_at = d2 - f2 * (d2 - d1) / (f2 - f1)
    # Measured: 2e-12 of the largest overlap.
    assert run.dents[1] == pytest.approx(opens_at, abs=1e-11 * overlap.max())
    assert run.dents[1] == pytest.approx(
        Thornton(2.5e-3).dent(run.largest_overlaps[1]), rel=1e-9, abs=1e-11 * overlap.max()
    )
    assert (run.dents[1] > 0.0) == (speed > 0.43)
    assert run.dents[[0, 2]].tolist() == [0.0, 0.0]


@pytest.mark.parametrize(("loss", "part"), [
    (hc.WaltonBraun(0.7), 0.3), (hc.UnloadingRatio(0.3), 0.0), (hc.Dashpot("50 N s/m"), 0.0),
    (None, 0.0),
])  # fmt: skip
def test_dents_of_other_laws(loss, part):
    run = hc.simulate(pair(2.0, loss), until=2e-4, times=401)
    assert run.dents[1] == pytest.approx(part * run.largest_overlaps[1], rel=1e-14)


def test_a_second_impact_begins_at_the_dent():
    """The work of both impacts, by quadrature of the loading curve of Thornton."""
    contact, speed = Thornton(2.5e-3), 2.0
    chain = pair(speed)
    energy = 0.25 * chain.masses[0] * speed**2

    def returned(largest):
        return quad(lambda d: contact.unload(d, largest), contact.dent(largest), largest)[0]

    def work(begin, end):
        points = [contact.at] if begin < contact.at < end else None
        return quad(contact.load, begin, end, points=points)[0]

    first = brentq(lambda d: work(0.0, d) - energy, contact.at, 1e-3, xtol=1e-16)
    second = brentq(
        lambda d: returned(first) + work(first, d) - energy, first, 1e-3, xtol=1e-16
    )  # fmt: skip
    one = hc.simulate(chain, until=1e-3, rtol=1e-12)
    two = hc.simulate(chain, start=one.state.struck_again(), until=1e-3, rtol=1e-12)
    for run, largest in ((one, first), (two, second)):
        # Measured: 1e-9.
        assert run.dents[1] == pytest.approx(contact.dent(largest), rel=1e-8)
        rebound = np.diff(run.velocities[-1])[0] / speed
        assert rebound == pytest.approx(math.sqrt(returned(largest) / energy), rel=1e-8)
    assert two.energy_drift < 1e-9
    assert two.momentum_drift < 1e-12


def verlet(masses, contacts, largest, speed, end, steps):
    """A row in front of a plate whose contacts have largest overlaps; returns those after it."""
    largest, dt = list(largest), end / steps
    dents = [each.dent(d) for each, d in zip(contacts, largest, strict=True)]
    x, v, peak = np.cumsum(dents[::-1])[::-1], np.zeros(len(masses)), 0.0
    v[0], a = speed, np.zeros(len(masses))
    for _ in range(steps):
        v += 0.5 * dt * a
        x = x + dt * v
        forces = [0.0]
        for c, d in enumerate(-np.diff(np.append(x, 0.0))):
            largest[c] = max(largest[c], d)
            forces.append(contacts[c].unload(d, largest[c]))
        peak = max(peak, forces[-1])
        a = -np.diff(forces) / masses
        v += 0.5 * dt * a
    return largest, peak


def test_a_row_that_is_struck_twice_agrees_with_a_loop_over_the_formulas_of_the_law():
    chain = row(1.0)
    r = np.append(chain.radii, np.inf)
    contacts = [Thornton(1.0 / (1.0 / r[i] + 1.0 / r[i + 1])) for i in range(4)]
    largest, run, end = [0.0] * 4, None, 2e-4
    for _ in range(2):
        start = None if run is None else run.state.struck_again()
        run = hc.simulate(chain, start=start, until=end, rtol=1e-11)
        largest, peak = verlet(chain.masses, contacts, largest, 1.0, end, 20_000)
        expected = [each.dent(d) for each, d in zip(contacts, largest, strict=True)]
        # Measured: 2e-6, an error of the loop.
        np.testing.assert_allclose(run.dents[1:], expected, rtol=2e-5)
        assert run.wall_force().peak == pytest.approx(peak, rel=2e-5)


def test_a_weaker_pulse_leaves_the_dents_as_they_are():
    hard = hc.simulate(row(2.0), until=3e-4)
    state = hard.state.struck_again()
    beads = state.chain.beads
    assert state.velocities.tolist() == [2.0, 0.0, 0.0, 0.0]
    overlaps = -np.diff(np.append(state.positions, 0.0))
    np.testing.assert_allclose(overlaps, hard.dents[1:], rtol=1e-12)
    state.arrays["y"][beads] = 0.2
    soft = hc.simulate(state.chain, start=state, until=3e-4)
    assert soft.largest_overlaps[1] < hard.largest_overlaps[1]
    np.testing.assert_allclose(soft.dents, hard.dents, rtol=1e-14)


def test_beads_that_are_struck_again_keep_the_gaps_of_the_chain():
    chain = pair(2.0).replace(gaps=[1e-5])
    state = hc.simulate(chain, until=1e-3).state.struck_again()
    run = hc.simulate(chain, start=state, until=1e-3, times=[0.0, 1e-3])
    assert run.overlap(1)[0] == pytest.approx(-1e-5 + hc.simulate(chain, until=1e-3).dents[1])


@pytest.mark.parametrize(("change", "words"), [
    ({"gravity": 9.8}, "a chain with static forces cannot be struck again"),
    ({"drive": hc.SineBurst(frequency=1e4, amplitude=1e-6), "left_wall": hc.Wall()},
     "a chain with a drive cannot be struck again"),
])  # fmt: skip
def test_chains_that_cannot_be_struck_again(change, words):
    state = hc.simulate(row(0.1).replace(**change), until=1e-5).state
    with pytest.raises(hc.InputError, match=words):
        state.struck_again()


def test_elastic_contacts_have_no_dents_in_a_second_impact():
    chain = hc.Chain.uniform(6)
    again = hc.simulate(chain, start=hc.simulate(chain).state.struck_again(), until=5.0)
    whole = hc.simulate(chain, until=5.0)
    np.testing.assert_array_equal(again.velocities, whole.velocities)


def test_ensembles_and_sweeps_keep_dents():
    chains = [row(speed) for speed in (0.5, 2.0)] + [row(2.0).replace(loss=None)]
    table = hc.simulate_many(chains, keep=["dent"], until=3e-4)
    for found, chain in zip(table["dent"], chains, strict=True):
        run = hc.simulate(chain, until=3e-4, rtol=1e-9)
        assert found == pytest.approx(run.dents[1:-1], rel=1e-4, abs=1e-15)
    assert table["dent"][1].min() > 0.0 == table["dent"][2].max()
    swept = hc.sweep({
        "chain": {"radii": [5e-3, 4e-3, 3e-3, 4e-3], "materials": "steel-52100",
                  "loss": {"law": "elastic-plastic"}, "right_wall": {"material": "steel-52100"}},
        "axes": {"velocity": [0.5, 2.0]},
        "sweep": {"methods": ["simulate"], "keep": ["dent"]},
        "method": {"until": 3e-4},
    })  # fmt: skip
    assert swept.dent.attrs["units"] == "m"
    assert swept.dent.values[1, 0, :3] == pytest.approx(table["dent"][1], rel=1e-4)


def test_contacts_in_words():
    words = [contacts_in_words(np.array(each), 11) for each in (
        [3, 4, 5, 6], [2], [1, 2, 5, 11], [0, 11], [1, 3, 5, 7, 10],
    )]  # fmt: skip
    assert words == [
        "contacts 3 to 6", "contact 2", "contacts 1 to 2 and 5 and the right wall",
        "the left wall and the right wall", "5 contacts of two beads",
    ]  # fmt: skip


def test_the_range_of_a_run_states_the_contacts_that_have_yielded():
    for speed, words in (
        (0.2, "pressure / yield  0.932 at contact 2 (limit 1)"),
        (2.0, "pressure / yield  1 at contacts 1"),
    ):
        chain = row(speed)
        run = hc.simulate(chain, until=3e-4)
        found = hc.hertz_range(chain, run.largest_overlaps)
        assert words in str(found)
        assert "unknown" not in str(found) + repr(found) + found._repr_html_()
        contact = Thornton(1.0 / (1.0 / 5e-3 + 1.0 / 4e-3))
        expected = min(math.sqrt(run.largest_overlaps[1] / contact.at), 1.0)
        assert found.law_yield_ratio[1] == pytest.approx(expected, rel=1e-9)
        assert np.isnan(found.yield_ratio).all()
    mixed = row(2.0).replace(right_wall=hc.Wall(loss=hc.Elastic()))
    found = hc.hertz_range(mixed, hc.simulate(mixed, until=3e-4).largest_overlaps)
    assert np.isnan(found.law_yield_ratio[-1])
    assert found.yield_ratio[-1] > 1.0
    assert "; 1 at contacts 1 to 3, which yield by their law" in str(found)
    one = dataclasses.replace(found, law_yield_ratio=np.array([0.0, 0.0, 1.0, 0.0, 0.0]))
    assert "1 at contact 2, which yields by its law" in str(one)


def test_dents_in_words():
    run = hc.simulate(row(2.0), until=3e-4)
    deepest = 1e6 * run.dents.max()
    place = {4: "the right wall"}.get(int(run.dents.argmax()), f"contact {run.dents.argmax()}")
    text = dents_in_words(run.chain, run.largest_overlaps)
    assert text == (
        f"contacts 1 to 3 and the right wall have yielded; deepest dent {deepest:.3g} um at {place}"
    )
    elastic = row(2.0).replace(loss=None)
    assert not dents_in_words(elastic, run.largest_overlaps)
    slow = hc.simulate(row(0.1), until=3e-4)
    text = dents_in_words(slow.chain, slow.largest_overlaps)
    assert text.startswith("no contact has yielded: pressure / yield 0.")
    scaled = hc.Chain.uniform(3).replace(loss=hc.WaltonBraun(0.5))
    assert dents_in_words(scaled, np.array([0.0, 0.2, 0.4, 0.0])) == "deepest dent 0.2 at contact 2"
    fast = hc.simulate(row(200.0), until=1e-5)
    assert "outside the range of the law (overlap / radius " in dents_in_words(
        fast.chain, fast.largest_overlaps
    )
    (violation,) = [each for each in hc.hertz_range(row(200.0), fast.largest_overlaps).violations
                    if each.startswith("overlap")]  # fmt: skip
    assert "; beyond 0.1, forces are not a prediction" in violation


def test_laws_of_yield_have_their_own_limit_of_overlaps():
    # Steel balls of 5 mm radius at 5 m/s: overlap / radius 0.027, between both limits.
    chain = row(5.0)
    run = hc.simulate(chain, until=1e-4)
    near = hc.hertz_range(chain, run.largest_overlaps)
    assert 0.01 < near.overlap_ratio.max() < 0.1
    assert near.violations == ()
    assert "(limit of contacts that yield: 0.1); above 0.01" in near._remark
    assert "(limit 0.1)" in str(near)
    table = hc.simulate_many([chain, row(200.0)], until=1e-5)
    assert table.outside_range.tolist() == [False, True]
    # Elastic contacts keep the limit of Hertz's law.
    elastic = hc.hertz_range(chain.replace(loss=None), run.largest_overlaps)
    assert any(each.startswith("overlap / radius") for each in elastic.violations)
    assert not elastic._remark


ROW = ("simulate", "--material", "steel-52100", "--diameter", "10 mm", "--beads", 5, "--wall",
       "same", "--loss", "elastic-plastic", "--contacts")  # fmt: skip


def test_simulate_lists_dents(run):
    code, out, _ = run(*ROW, "--speed", "2 m/s")
    chain = hc.Chain.from_materials(
        5e-3, "steel-52100", beads=5, velocity=2.0, loss=LAW, right_wall=hc.Wall()
    )
    found = hc.simulate(chain)
    assert code == 0
    assert dents_in_words(chain, found.largest_overlaps) in out.splitlines()
    contacts = json.loads(run(*ROW, "--speed", "2 m/s", "--json")[1])["contacts"]
    assert [each["dent"] for each in contacts] == pytest.approx(found.dents[1:], rel=1e-6)
    assert [each["pressure_over_yield"] for each in contacts] == [1.0] * 5
    lines = [line.split() for line in out.splitlines() if " and " in line and "1.5" in line]
    assert [float(line[-1]) for line in lines] == pytest.approx(1e6 * found.dents[1:], rel=1e-3)
    assert [line[-2] for line in lines] == ["1"] * 5
    slow = run(*ROW, "--speed", "0.1 m/s")[1]
    assert "no contact has yielded: pressure / yield 0." in slow
    elastic = run(*ROW[:-3], "--contacts", "--speed", "0.1 m/s")[1]
    assert "dent um" not in elastic


def test_simulate_prints_further_hits(run):
    code, out, _ = run(*ROW[:-1], "--speed", "2 m/s", "--hits", 3, "--sensor", 4)
    assert code == 0
    first = hc.simulate(hc.Chain.from_materials(
        5e-3, "steel-52100", beads=5, velocity=2.0, loss=LAW, right_wall=hc.Wall()
    ))  # fmt: skip
    second = hc.simulate(first.chain, start=first.state.struck_again())
    third = hc.simulate(first.chain, start=second.state.struck_again())
    runs = [first, second, third]
    table = out.partition("3 hits, each with the dents of the previous ones")[2]
    lines = [line.split() for line in table.splitlines() if line.strip()[:1] in ("1", "2", "3")]
    assert [float(line[1]) for line in lines] == pytest.approx(
        [each.wall_force().peak for each in runs], rel=1e-4
    )
    # Saved times are about as close as those of the command.
    sensors = [hc.simulate(first.chain, start=each.state.struck_again(), times=4000)
               .sensor_force(4).largest_so_far for each in runs[:2]]  # fmt: skip
    assert [float(line[2]) for line in lines[1:]] == pytest.approx(sensors, rel=1e-3)
    assert [float(line[3]) for line in lines] == pytest.approx(
        [1e6 * each.dents.max() for each in runs], rel=1e-2
    )
    hits = json.loads(run(*ROW[:-1], "--speed", "2 m/s", "--hits", 2, "--json")[1])["hits"]
    assert [each["hit"] for each in hits] == [1, 2]
    assert hits[1]["wall_peaks"]["right"] == pytest.approx(second.wall_force().peak, rel=1e-9)
    assert hits[1]["dents"] == pytest.approx(second.dents.tolist(), rel=1e-9)
    code, _, err = run(*ROW[:-3], "--hits", 2)
    assert code == 2
    assert "--hits requires a loss that leaves dents" in err


def test_designs_with_dents_state_the_peak_of_the_second_hit():
    chain = hc.Chain.from_materials(
        5e-3, "steel-52100", beads=5, velocity=2.0, loss=LAW, right_wall=hc.Wall()
    )
    problem = hc.Design(chain, minimise="wall_force.peak", vary=[hc.vary.radii("4 mm", "6 mm")])
    found = problem.evaluate(chain)
    first = hc.simulate(chain)
    second = hc.simulate(chain, start=first.state.struck_again()).wall_force().peak
    assert found.second_peak == pytest.approx(second, rel=1e-6)
    assert found.dents == dents_in_words(chain, first.largest_overlaps)
    assert np.isnan(problem.evaluate(chain.replace(loss=None)).second_peak)
    slow = chain.replace(velocities=0.05 * chain.velocities)
    # Without dents, all hits are the same.
    assert peak_of_second_hit(slow) == hc.simulate(slow, times=0).wall_force().peak
    assert not problem.evaluate(slow)._dented
    box = chain.replace(right_wall=None).with_cap("1 g")
    problem = hc.Design(
        box, minimise="body_force.acceleration",
        vary=[hc.vary.balls(materials=["steel-52100"], diameters=["9 mm", "10 mm"], beads="5")],
    )  # fmt: skip
    result = hc.design(problem, budget=15, seed=1)
    first = hc.simulate(result.chain)
    second = hc.simulate(result.chain, start=first.state.struck_again()).body_force()
    assert result.verified.second_peak == pytest.approx(second.force, rel=1e-5)
    columns, own = result.summary().split("\n  body_force.acceleration ")[1].splitlines()[:2]
    assert "hit 2 at 1.6 Y" in columns
    assert f"  {second.acceleration:.4g} m/s^2" in own


@pytest.mark.long
def test_the_summary_of_a_pareto_front_states_dents_and_second_hits():
    chain = row(5.0).replace(right_wall=hc.Wall(), loss=LAW)
    radii = hc.vary.radii("4.5 mm", "5.5 mm")
    problem = hc.Design(chain, minimise=["wall_force.peak", "mass"], vary=[radii])
    result = hc.design(problem, budget=100, points=2, seed=1)
    lines = result.summary().splitlines()
    assert f"  {result.verified.dents}" in lines
    peaks = []
    for i, point in enumerate(result.front, start=1):
        first = hc.simulate(point.chain)
        again = hc.simulate(point.chain, start=first.state.struck_again())
        peaks.append(f"{again.wall_force().peak:.4g} N in the second hit")
        (line,) = [each for each in lines if each.startswith(f"  {i}: ")]
        assert line.endswith(f", wall_force.peak {peaks[-1]}")
    again = f"  struck again with these dents: wall_force.peak = {peaks[0]} ("
    assert any(each.startswith(again) for each in lines)
    assert any("hit 2 at 1.6 Y" in each for each in lines)


def test_designs_and_scatter_within_the_range_of_the_law_of_yield():
    # Overlap / radius is between the limits of Hertz's law and of contacts that yield.
    chain = row(5.0).replace(right_wall=hc.Wall(), loss=LAW)
    found = hc.distribution(chain, "wall_force.peak", hc.Scatter(radius=0.001, samples=3))
    assert found.outside_range == 0
    problem = hc.Design(chain, minimise="wall_force.peak", vary=[hc.vary.radii("4.9 mm", "5.1 mm")])
    result = hc.design(problem, budget=90, seed=1)
    assert not result.verified.outside_range
    first, pressures, second, third, fourth, fifth, *_ = result.summary().splitlines()
    assert "outside the range" not in first
    peaks = [hc.simulate(result.chain.replace(loss=hc.ElasticPlastic(factor=factor)))
             .wall_force().peak for factor in (1.6, 2.8)]  # fmt: skip
    assert result.yield_range == pytest.approx(peaks, rel=1e-6)
    low, high = (f"{peak:.4g} N" for peak in peaks)
    assert pressures == f"  {low} if contacts yield at 1.6 Y, {high} at 2.8 Y (Y: yield strength)"
    assert second.endswith("stayed within the range of their law")
    assert third == f"  {result.verified.dents}"
    peak = f"{result.verified.second_peak:.4g} N in the second hit"
    harder = result.verified.fully_plastic
    assert fourth == (f"  struck again with these dents: wall_force.peak = {peak} "
                      f"({harder.second_peak:.4g} N at 2.8 Y)")  # fmt: skip
    assert fifth == "  the search compares the first hit only"
    law = hc.ElasticPlastic(factor=2.8)
    first_hit = hc.simulate(result.chain.replace(loss=law))
    again = hc.simulate(first_hit.chain, start=first_hit.state.struck_again())
    assert harder.second_peak == pytest.approx(again.wall_force().peak, rel=1e-6)
    # The chains to compare with have a second hit, too.
    lines = [line for line in result.summary().splitlines() if "    value " in line]
    parts = [line for line in result.summary().splitlines() if "    this design / value" in line]
    compared = [problem.evaluate(chain), *result.references.values()]
    for line, part, each in zip(lines, parts, compared, strict=True):
        again = hc.simulate(each.chain, start=hc.simulate(each.chain).state.struck_again())
        own = hc.simulate(result.chain, start=hc.simulate(result.chain).state.struck_again())
        peaks = [hit.wall_force().peak for hit in (again, own)]
        assert line.split()[5:7] == [f"{peaks[0]:.4g}", "N"]
        assert part.split()[6] == f"{peaks[1] / peaks[0]:.1%}"
        assert each.second_peak == pytest.approx(peaks[0], rel=1e-6)
    (remark,) = [each for each in result.notes if each.startswith("overlap / radius")]
    assert remark.endswith("above 0.01, Hertz's law is less accurate")


def test_dented_contacts_without_a_force_are_open():
    """Without a saved time at the end, forces are unknown, and dents are overlaps."""
    run = hc.simulate(row(2.0).replace(right_wall=hc.Wall.of("aluminium")), rtol=1e-10)
    assert run.times[-1] < run.end_time
    again = hc.simulate(run.chain, until=run.end_time, rtol=1e-10)
    assert again.times[-1] == again.end_time
    pressed = np.flatnonzero(again.forces[-1][1:-1] > 0.0) + 1
    assert run.closed_contacts.tolist() == again.closed_contacts.tolist() == pressed.tolist()
    # Some contacts have dents, and are open.
    assert (run.dents[1:-1] > 0.0).sum() > len(pressed)


def test_a_run_states_that_no_contact_has_yielded():
    balls = hc.Chain.from_materials("5 mm", "steel-52100", beads=6, velocity="0.3 m/s")
    elastic, yielding = (
        repr(hc.simulate(balls.replace(loss=hc.ElasticPlastic(), velocities=[v, *[0.0] * 5])))
        for v in (0.3, 2.0)
    )
    assert "no contact has yielded" in " ".join(elastic.split())
    assert "yielded" not in yielding
    assert "yielded" not in repr(hc.simulate(balls))


@pytest.mark.long
def test_the_summary_states_limits_and_advantages_that_depend_on_the_yield_pressure():
    """Of a design and a row whose order or limits change between 1.6 and 2.8 Y."""
    chain = row(5.0).replace(right_wall=hc.Wall(), loss=LAW)
    sizes = [hc.vary.radii("4.9 mm", "5.1 mm")]
    free = hc.design(hc.Design(chain, minimise="wall_force.peak", vary=sizes), budget=90, seed=1)
    low, high = free.yield_range
    assert low < high
    limited = hc.Design(
        chain, minimise="wall_force.peak", vary=sizes,
        subject_to={"wall_force.peak": f"<= {0.5 * (low + high)} N"},
    )  # fmt: skip
    name, own = "wall_force.peak", free.verified
    better = own.fully_plastic._replace(values=own.fully_plastic.values | {name: 1.02 * high})
    other = dataclasses.replace(own, values=own.values | {name: 1.3 * low}, fully_plastic=better)
    found = dataclasses.replace(
        free, problem=limited, references={"row": other}, compared={"row": 1}
    )
    lines = found.summary().splitlines()
    assert "    this design is 23% better at 1.6 Y and 2% better at 2.8 Y: its advantage here depends on yield" in lines  # fmt: skip  # noqa: E501
    (limit,) = (line for line in lines if line.startswith(f"  {name} <= "))
    assert limit.endswith(f" ({high:.4g} N at 2.8 Y), NOT met if contacts yield at 2.8 Y")
    assert lines[0].endswith(" N; NOT all limits are met if contacts yield at 2.8 Y")
    assert any("the design does NOT meet wall_force.peak <= " in each and "at 2.8 Y: search with "
               "loss=ElasticPlastic(factor=2.8)" in each for each in lines)  # fmt: skip
    assert "constraints NOT met if contacts yield at 2.8 Y" in " ".join(repr(found).split())
    drawn = [" ".join(text.split()) for text in found.plot("forces").get_legend_handles_labels()[1]]
    assert any(f"N, violates wall_force.peak at 2.8 Y: {high:.4g} N" in each for each in drawn)
    document = found.as_dict()
    assert document["constraints_met"]
    assert document["constraints_met_with_yielding_contacts"] is False
    assert document["constraints_not_met_at_fully_plastic_pressure"] == document["constraints"][:1]
    assert document["at_fully_plastic_pressure"]["values"][name] == pytest.approx(high)
    (entry,) = document["references"].values()
    assert any("advantage here depends on yield" in each for each in entry["remarks"])
