"""Statements of summaries of designs: starts, chains to compare with, notes."""

import dataclasses

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.designs.reference_chains import reference_points

WALLED = hc.Chain.uniform(6).replace(right_wall=hc.Wall())


@pytest.fixture(scope="module")
def limited():
    """A search of two starts, of which the second ends at a chain that violates a constraint."""
    limits = {"peak_force@4": "<= 0.25", "mass": ">= 3"}
    problem = hc.Design(
        WALLED, minimise="wall_force.peak", vary=[hc.vary.radii(0.5, 1.0)], subject_to=limits
    )
    return hc.design(problem, budget=150, method="gradient", seed=2)


def test_starts_outside_the_constraints_are_not_counted(limited):
    assert limited.met
    assert limited.finals_met.tolist() == [True, False]
    assert limited.spread == pytest.approx((limited.value, limited.value), rel=1e-6)
    assert "; not counting 1 outside the constraints" in limited.summary()
    document = limited.as_dict()
    assert document["starts"] == 2
    assert document["starts_outside_constraints"] == 1
    assert document["median_start"] == document["best_start"]


def test_a_start_that_violates_the_constraints_is_not_the_best_one(limited):
    other = dataclasses.replace(
        limited, finals=np.array([0.1, 0.6, 0.7, 0.9]), finals_met=np.array([0, 1, 1, 1], bool)
    )
    assert other.spread == (0.6, 0.7)
    text = "median at 0.7; not counting 1 outside the constraints; further trials improved it)"
    assert f"(the best one ended at 0.6, the {text}" in other.summary()
    none = dataclasses.replace(other, finals_met=np.zeros(4, bool))
    assert np.isnan(none.spread).all()
    assert none.as_dict()["best_start"] is None
    text = "(no start ended within the constraints: the design is the best of all trials that meet"
    assert text in none.summary()


def test_the_axis_of_a_history_over_more_than_a_factor_of_ten_is_logarithmic(limited):
    for values, scale in (([300.0, 40.0, 5.0], "log"), ([30.0, 5.0], "linear")):
        history = np.array([[1 + i, value] for i, value in enumerate(values)])
        axes = dataclasses.replace(limited, history=history).plot("history")
        assert axes.get_yscale() == scale


def problem_of(chain, *vary):
    return hc.Design(chain, minimise="wall_force.peak", vary=[*vary])


@pytest.mark.parametrize(("vary", "names"), [
    # Radius 1 of the given beads is one of the sizes, is not, or is outside the limits.
    (hc.vary.radii(0.5, 1.0), {"chain with equal varying sizes": 8, "chain of equal sizes": 1}),
    (hc.vary.radii(0.5, 1.1), {"chain with equal varying sizes": 9, "chain of equal sizes": 1}),
    (hc.vary.radii(0.5, 0.9), {"chain with equal varying sizes": 9}),
    # A spline begins at bead 1.
    (hc.vary.radii(0.5, 1.1, by="spline", knots=4),
     {"fast change to equal sizes": 9, "chain of equal sizes": 1}),
    (hc.vary.radii(0.5, 1.0, beads=[3]), {"chain of equal sizes": 1}),
])  # fmt: skip
def test_chains_of_equal_sizes_are_those(vary, names):
    problem = problem_of(WALLED, vary)
    found = reference_points(problem)
    assert {name: len(points) for name, points in found.items() if name != "taper"} == names
    for name, points in found.items():
        for point in points:
            radii = problem.space.chain_of(point).radii
            equal = np.ptp(radii) < 1e-9
            assert equal == (name == "chain of equal sizes")
            assert (np.ptp(radii[1:]) < 1e-9) == ("equal" in name and "fast" not in name)


def test_all_beads_but_strikers_are_equal_in_a_chain_of_equal_sizes():
    chain = hc.Chain.from_materials("3 mm", "steel-52100", beads=5,
                                    right_wall=hc.Wall.of("steel-52100"))  # fmt: skip
    chain = chain.struck_by(velocity="0.1 m/s", radius="8 mm", material="steel-52100")
    found = reference_points(problem_of(chain, hc.vary.diameters("4 mm", "9 mm")))
    assert {name: len(points) for name, points in found.items()} == {
        "chain of equal sizes": 9, "taper": 72,
    }  # fmt: skip


@pytest.mark.parametrize(("rate", "beads", "measure", "noted"), [
    (0.05, 20, "wall_force.peak", False),
    pytest.param(0.1, 40, "wall_force.peak", True, marks=pytest.mark.long),
    pytest.param(0.1, 40, "velocity@3", False, marks=pytest.mark.long),
])  # fmt: skip
def test_a_note_of_forces_that_small_differences_may_change(rate, beads, measure, noted):
    """As `WallForce.sensitive`; with a tenth of the tolerance, the peak is another one."""
    chain = hc.Chain.tapered("forward-exponential", rate, beads=beads)
    chain = chain.replace(right_wall=hc.Wall())
    problem = hc.Design(chain, minimise=measure, vary=[hc.vary.radii(0.5, 1.0, beads="2:3")])
    found = problem.evaluate(chain)
    assert any("sensitive to small changes" in note for note in found.notes) == noted
    if measure != "velocity@3":
        assert hc.simulate(chain).wall_force().sensitive == noted


def test_a_design_is_compared_with_a_chain_that_is_really_equal():
    """The best chain for the velocity of the last bead is that of equal beads."""
    problem = hc.Design(hc.Chain.uniform(9), maximise="velocity@8",
                        vary=[hc.vary.radii(1.0 / 3.0, 1.7, beads="2:6")])  # fmt: skip
    equal = hc.design(problem, budget=120).references["chain of equal sizes"]
    simulated = hc.simulate(hc.Chain.uniform(9)).pulse().velocity[7]
    assert equal.values["velocity@8"] == pytest.approx(simulated, rel=1e-9)


def test_rows_of_equal_balls_are_named_by_the_places_that_vary():
    chain = hc.Chain.from_materials("3 mm", "steel-52100", beads=5, velocity="0.1 m/s",
                                    right_wall=hc.Wall.of("steel-52100"))  # fmt: skip
    for beads, name in (("2:", "row of equal balls"), ("1:", "row of equal balls"),
                        ("2:4", "equal balls in the places that vary")):  # fmt: skip
        balls = hc.vary.balls(materials=["steel-52100"], diameters=["4 mm", "5 mm"], beads=beads)
        problem = problem_of(chain, balls)
        assert list(reference_points(problem)) == [name]
        if beads == "2:4":
            assert f"best {name} (of 2 tried), 3 balls of " in hc.design(problem).summary()


@pytest.mark.parametrize(("wall", "velocity", "said"), [
    ("aluminium", 0.2, "; aluminium of the right wall yields, not a ball: choose a harder wall"),
    ("steel-52100", 1.0, "; give a larger budget or another seed"),
])  # fmt: skip
def test_a_wall_that_yields_is_named_instead_of_a_larger_budget(wall, velocity, said):
    row = hc.Chain.from_materials(
        "5 mm", "steel-52100", beads=4, velocity=velocity, right_wall=hc.Wall.of(wall)
    )
    problem = hc.Design(
        row, minimise="wall_force.peak", vary=[hc.vary.radii("4 mm", "6 mm", beads="2:")],
        subject_to={"yield_ratio": "<= 1"},
    )  # fmt: skip
    first, *_ = hc.design(problem, budget=90).summary().splitlines()
    assert said in first
    assert ("budget" in first) == (wall == "steel-52100")


@pytest.mark.parametrize("struck", [False, True])
def test_the_summary_states_number_length_and_mass_of_all_balls(struck):
    row = hc.Chain.from_materials(
        "5 mm", "steel-52100", beads=3, velocity="0.01 m/s", right_wall=hc.Wall.of("steel-52100")
    )
    if struck:
        row = row.replace(velocities=None).struck_by(mass="50 g", radius="flat", velocity="1 mm/s")
    balls = hc.vary.balls(materials=["steel-52100"], diameters=["4 mm", "6 mm"], beads="2:3")
    found = hc.design(hc.Design(row, minimise="wall_force.peak", vary=[balls]))
    own = found.chain.radii[struck:]
    mass = 1e3 * found.chain.masses[struck:].sum()
    where = "without the striker" if struck else "with the arriving ball"
    line = f"in all, {where}: 3 beads, length {2e3 * own.sum():.4g} mm, mass {mass:.4g} g"
    assert line in found.summary().splitlines()


def test_a_front_names_the_numbers_of_beads_that_it_does_not_have():
    row = hc.Chain.from_materials(
        "5 mm", "steel-52100", beads=21, velocity="0.01 m/s", right_wall=hc.Wall.of("steel-52100")
    )
    balls = hc.vary.balls(
        materials=["steel-52100"], diameters=["8 mm", "10 mm"], beads="2:", optional=True
    )
    problem = hc.Design(row, minimise=["wall_force.peak", "beads"], vary=[balls])
    found = hc.design(problem, budget=80, seed=1)
    there = {int(each.values["beads"]) for each in found.front}
    (note,) = [each for each in found.notes if "has no rows of" in each]
    ranges, _ = note.removeprefix("the Pareto front has no rows of ").split(" beads (")
    named = [each.split(" to ") for each in ranges.replace(" and ", ", ").split(", ")]
    absent = {n for first, *last in named for n in range(int(first), int([first, *last][-1]) + 1)}
    assert absent == {*range(2, 22)} - there
    assert absent
    # All rows of up to three balls are simulated.
    complete = dataclasses.replace(problem, chain=row[:4].replace(right_wall=row.right_wall))
    assert not any("has no rows" in each for each in hc.design(complete, budget=100).notes)
