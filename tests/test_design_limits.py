"""Constraints of designs: their bounds, and values that are unknown."""

import dataclasses
import re

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.designs.bounds import bounds_of, impossible
from hertzchain.designs.evolution import STALLED, evolve
from hertzchain.designs.search_budget import budget_from
from hertzchain.designs.trials import Trials
from hertzchain.designs.verified import excess_with_scatter, met
from hertzchain.store.journal import Journal

WALLED = hc.Chain.uniform(6).replace(right_wall=hc.Wall())


@pytest.mark.parametrize("quantity", ["energy", "energy_share"])
def test_a_ratio_of_energies_has_no_bound(quantity):
    """The bound of an energy is not that of its ratio to a smaller one."""
    ratio = f"{quantity}@8/{quantity}@4"
    problem = hc.Design(
        hc.Chain.uniform(10), maximise="velocity@last", vary=[hc.vary.radii(0.5, 1.5)],
        subject_to={ratio: ">= 1.5", f"{quantity}@4": ">= 0.05"},
    )  # fmt: skip
    assert impossible(problem) is None
    assert [str(bound.measure) for bound in bounds_of(problem)] == [f"{quantity}@4"]
    # A light bead passes most of its energy on before its velocity is largest.
    chain = hc.Chain([1.0, 1.0, 1.0, 0.6, *[1.0] * 6])
    assert problem.evaluate(chain).values[ratio] > 1.5


def trials_of(problem, budget=2000):
    return Trials(problem, budget_from(budget), Journal(None, ""), seed=1)


@pytest.mark.parametrize("limits", ["<= 1", ">= 1", ["<= 2", ">= 0.5"]])
def test_an_unknown_value_meets_no_constraint(limits):
    problem = hc.Design(
        WALLED, minimise="length", vary=[hc.vary.radii(0.5, 1.0)],
        subject_to={"wall_force.peak": limits, "mass": "<= 100"},
    )  # fmt: skip
    known = {"length": 10.0, "wall_force.peak": 1.0, "mass": 20.0}
    for values, fine in ((known, True), (known | {"wall_force.peak": np.nan}, False)):
        assert met(problem, values) == fine
        row = np.array([list(values.values())])
        (outcome,) = trials_of(problem).outcomes([np.zeros(5)], row)
        assert outcome.met == fine
        assert np.isfinite(outcome.rank).all() == fine


def test_a_length_is_not_exceeded_to_come_closer_to_a_limit_that_no_row_meets():
    problem = hc.Design(
        WALLED, minimise="wall_force.peak", vary=[hc.vary.radii(0.5, 1.0)],
        subject_to={"wall_force.peak": "<= 0.1", "length": "<= 10"},
    )  # fmt: skip
    # Columns of the force and the length; the second row is closer to the first limit.
    rows = {name: i for i, name in enumerate(map(str, problem.measures))}
    values = np.empty((2, 2))
    values[:, rows["wall_force.peak"]], values[:, rows["length"]] = (0.3, 0.2), (9.9, 10.01)
    trials = trials_of(problem)
    short, long = trials.outcomes([np.zeros(5), np.ones(5)], values)
    assert long.rank < short.rank
    trials.note_without_cost([short, long])
    assert trials.tops == [short]
    assert trials.best == [long, short]


def test_a_limit_of_which_the_verification_has_no_value_is_not_met():
    """The BCA has the velocity of bead 9; the simulation ends before the pulse arrives there."""
    problem = hc.Design(
        hc.Chain.uniform(10), maximise="velocity@4", model="bca", until=6.0,
        vary=[hc.vary.radii(0.9, 1.1, by="common", beads="5:")],
        subject_to={"velocity@9": ">= 0.5"},
    )  # fmt: skip
    found = hc.design(problem, budget=20)
    assert np.isnan(found.values["velocity@9"])
    assert not found.met
    assert "velocity@9 >= 0.5: nan, NOT met" in found.summary()


def test_an_evolution_among_chains_without_values_is_given_up():
    """No force on the wall is complete at this time."""
    problem = hc.Design(
        WALLED, minimise="wall_force.peak", vary=[hc.vary.radii(0.5, 1.0)], until=1.0,
        subject_to={"wall_force.duration": "<= 1"},
    )  # fmt: skip
    trials = trials_of(problem)
    best = evolve(trials, np.full(5, 0.5), 1.0, np.random.default_rng(1), population=10)
    assert np.isnan(best.violation)
    assert trials.rejected == trials.runs <= 10 * (2 * STALLED)


def test_a_limit_is_not_met_if_new_samples_have_no_value():
    """Peaks of all samples of the search, but not of all new ones, are complete at the end."""
    scatter = hc.Scatter(radius=0.05, samples=4, beads="2:")
    problem = hc.Design(
        hc.Chain.uniform(4).replace(right_wall=hc.Wall()), minimise="length", scatter=scatter,
        vary=[hc.vary.radii(0.9, 1.1, by="common")], until=5.5,
        subject_to={"wall_force.peak": "<= 5", "mass": "<= 100"},
    )  # fmt: skip
    found = hc.design(problem, budget=80)
    for count, seed, complete in ((4, 0, True), (400, 1_000_003, False)):
        chains = scatter._chains(found.chain, scatter._draws(seed, 4, count))
        peaks = hc.simulate_many(chains, keep=["wall_peak_force"], until=5.5)["wall_peak_force"]
        assert np.isfinite(peaks).all() == complete
    assert not found.met
    assert found.summary().startswith("The constraints are NOT met in new samples of the scatter.")
    said = "CVaR90 of wall_force.peak <= 5 cannot be checked, because some new samples"
    assert any(note.startswith(said) for note in found.notes)
    # Nothing is known if no samples can be made.
    without = dataclasses.replace(found.verified, scattered={})
    assert excess_with_scatter(problem, without) == {"CVaR90 of wall_force.peak <= 5": np.inf}


def test_limits_that_the_search_does_not_meet_are_not_blamed_on_new_samples():
    chain = hc.Chain.uniform(4).replace(right_wall=hc.Wall())
    vary = [hc.vary.radii(0.9, 1.1, by="common")]
    scatter = hc.Scatter(radius=0.05, samples=4, beads="2:")
    limit = {"wall_force.peak": "<= 0.1"}
    problem = hc.Design(
        chain, minimise="length", vary=vary, subject_to=limit, scatter=scatter, until=8.0
    )
    found = hc.design(problem, budget=80)
    assert not found.met
    assert not found.met_in_search
    text = found.summary()
    assert text.startswith("No trial meets the constraints; the closest one has a CVaR90 of length")
    assert re.search(r"of length of \S+ in the search, \S+ without scatter; give a ", text)
    assert "set stricter limits" not in text
    assert "CVaR90 of wall_force.peak <= 0.1" in "".join(
        excess_with_scatter(problem, found.verified)
    )


def test_the_range_of_the_law_is_stated_beside_the_value():
    chain = hc.Chain.from_materials("5 mm", "steel-52100", beads=4, velocity=1.0)
    problem = hc.Design(
        chain, maximise="largest_velocity@last", vary=[hc.vary.radii("2 mm", "5 mm", beads="2:")],
        subject_to={"yield_ratio": "<= 0.1"},
    )  # fmt: skip
    found = hc.design(problem, budget=100)
    assert not found.met
    assert re.match(
        r"No trial meets the constraints; the closest one has a largest_velocity@last of \S+ m/s, "
        "outside the range of Hertz's law; give a larger budget",
        found.summary(),
    )
    assert repr(found).startswith("DesignResult(maximum of largest_velocity@last: ")
    free = hc.Design(chain, minimise="largest_velocity@last", vary=problem.vary)
    assert str(free.objective) == "minimum of largest_velocity@last"


def test_lengths_of_designs_are_short_in_files():
    chain = hc.Chain.from_materials("5 mm", "steel-52100", beads=4, velocity=0.1)
    vary = [hc.vary.radii("1.1 mm", "5.3 mm", beads="2:"), hc.vary.gaps("1 um", "5 um")]
    found = hc.design(hc.Design(chain, maximise="velocity@last", vary=vary), budget=300, seed=1)
    text = hc.chain_as_toml(found.chain)
    sizes = re.findall(r'"(\S+) mm"', text)
    assert len(sizes) >= 4
    assert max(len(size.replace(".", "").lstrip("0")) for size in sizes) <= 9
    # The values are those of the chain in the file.
    again = hc.simulate(hc.chain_from_toml(text), rtol=1e-11).pulse().velocity[-1]
    assert again == pytest.approx(found.value, rel=1e-9)


SOFT = hc.Chain.from_materials(diameters="6.35 mm", materials="ptfe", beads=5)
STRUCK = SOFT.with_cap("40 g").struck_by(mass="50 g", radius=np.inf, velocity="1.5 m/s")
MIXED = [
    hc.vary.balls(
        materials=["ptfe", "steel-52100"], diameters=["6.35 mm", "7.9375 mm"], beads="2:6"
    )
]


def of_balls(loss, **options):
    return hc.Design(
        STRUCK.replace(loss=loss), minimise="sensor.largest@last", vary=MIXED, until=2e-3, **options
    )


@pytest.mark.long
def test_designs_with_yield_stay_within_the_range_of_the_law_unless_it_is_lifted():
    problem = of_balls(hc.ElasticPlastic())
    assert [str(each) for each in problem.requirements] == ["overlap_ratio <= 0.1"]
    assert problem.requirements[0].default
    found = hc.design(problem, budget=100, seed=1)
    assert found.values["overlap_ratio"] <= 0.1
    assert "overlap_ratio <= 0.1: " in found.summary()
    assert "(added because contacts yield; to lift it, give a limit" in found.summary()
    lifted = of_balls(hc.ElasticPlastic(), subject_to={"overlap_ratio": "<= 1"})
    assert [str(each) for each in lifted.requirements] == ["overlap_ratio <= 1"]
    assert lifted.identity != problem.identity
    soft = hc.design(lifted, budget=100, seed=1)
    # The search then prefers large dents, which the law does not describe.
    assert soft.values["overlap_ratio"] > 0.1
    assert soft.value < found.value
    assert "added because" not in soft.summary()


def test_objectives_without_a_simulation_have_no_default_limit():
    shortest = dataclasses.replace(of_balls(hc.ElasticPlastic()), minimise="length")
    assert not shortest.requirements


def test_a_given_row_that_violates_a_limit_is_compared(tmp_path):
    stock = tmp_path / "stock.csv"
    stock.write_text("diameter [mm],material\n4,steel-52100\n6,steel-52100\n")
    row = hc.Chain.from_materials(diameters="8 mm", materials="steel-52100", beads=4, velocity=0.01,
                                  right_wall=hc.Wall())  # fmt: skip
    found = hc.design(hc.Design(row, minimise="wall_force.peak",
                                vary=[hc.vary.balls(stock, beads="2:")],
                                subject_to={"length": "<= 30 mm"}), budget=8)  # fmt: skip
    given = found.summary().partition("  given chain: ")[2].splitlines()
    peak = hc.simulate(row).wall_force().peak
    assert given[0] == f"{peak:.4g} N"
    assert given[1] == f"    this design: {found.value / peak:.1%} of this value"
    assert given[2] == "    does NOT meet length <= 30 mm (32 mm)"
    axes = found.plot(kind="forces")
    labels = [text.get_text().replace("\n", " ") for text in axes.get_legend().get_texts()]
    assert labels[0] == f"given chain, peak {peak:.4g} N, violates length"
    assert axes.lines[0].get_linestyle() == ":"


def test_a_stock_has_a_row_to_compare_with_that_is_short_enough(tmp_path):
    """Only the balls of 8 mm suffice for a row of equal ones, which is too long."""
    stock = tmp_path / "stock.csv"
    rows = ("4,steel-52100,3", "6,steel-52100,3", "8,steel-52100,5")
    stock.write_text("\n".join(("diameter [mm],material,count", *rows)))
    row = hc.Chain.from_materials(diameters="8 mm", materials="steel-52100", beads=5)
    row = row.with_cap("40 g").struck_by(mass="5 g", radius=np.inf, velocity="0.01 m/s")
    problem = hc.Design(
        row, minimise="velocity@last", vary=[hc.vary.balls(stock, beads="2:6")],
        subject_to={"length": "<= 36 mm"},
    )  # fmt: skip
    found = hc.design(problem, budget=30, seed=1)
    lengths = {name: each.values["length"] for name, each in found.references.items()}
    assert lengths == {
        "row of equal balls": pytest.approx(40e-3),
        "row of balls sorted by size": pytest.approx(36e-3),
        "geometric taper": pytest.approx(34e-3),
    }
    text = found.summary()
    assert "    does NOT meet length <= 36 mm (40 mm)\n" in text
    assert "best row of balls sorted by size (of 2 tried)" in text
