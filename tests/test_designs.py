"""Design of chains: problems, variables, methods of search, and verified results."""

import dataclasses
import importlib
import itertools
import re
import warnings

import matplotlib.pyplot as plt
import numpy as np
import pytest
from figure_texts import legend_texts
from scipy_chain import trajectory, wall_peak

import hertzchain as hc
from hertzchain.designs import pareto
from hertzchain.designs.balls import Ball, load_balls
from hertzchain.designs.bundle_descent import Model, _step
from hertzchain.designs.comparison import shown_chains
from hertzchain.designs.dominance import best_spread, undominated
from hertzchain.designs.evolution import Strategy, reflected
from hertzchain.designs.exact_gradients import covered, values_and_slopes
from hertzchain.designs.genetic import Population, enumerate_all, search
from hertzchain.designs.methods import method_for
from hertzchain.designs.reference_chains import evaluated_references
from hertzchain.designs.search_budget import budget_from
from hertzchain.designs.sensitivity import changes, sensitivity
from hertzchain.designs.sizes import spline_basis
from hertzchain.designs.smooth_tapers import promise
from hertzchain.designs.trials import Outcome, Trials
from hertzchain.designs.verified import quietly, verify_chain
from hertzchain.plotting.legends import covers_data
from hertzchain.store.journal import Journal

WALLED = hc.Chain.uniform(10).replace(right_wall=hc.Wall())
WALLED_40 = hc.Chain.uniform(40).replace(right_wall=hc.Wall())
WALLED_700 = hc.Chain.uniform(700).replace(right_wall=hc.Wall())
STEEL = hc.Chain.from_materials(
    2.38e-3, "steel-304", beads=7, velocity=1.0, right_wall=hc.Wall.of("steel-304")
)


def balls(**options):
    options = {"materials": ["steel-304", "ptfe"], "diameters": ["4.7625 mm"]} | options
    return hc.vary.balls(**options)


@pytest.fixture(scope="module")
def softest():
    problem = hc.Design(WALLED, minimise="wall_force.peak", vary=[hc.vary.radii(0.5, 1.0)])
    return hc.design(problem, budget=500)


def test_the_peak_force_of_a_design_is_that_of_another_integrator(softest):
    assert softest.value == pytest.approx(wall_peak(softest.chain, 40.0), rel=1e-7)
    assert softest.chain.radii[0] == 1.0
    assert (softest.chain.radii >= 0.5).all()
    assert (softest.chain.radii <= 1.0).all()


def test_a_design_is_much_better_than_equal_beads_and_tapers(softest):
    others = [softest.objective_of(each) for each in softest.references.values()]
    assert len(others) == 3
    assert softest.value < 0.65 * min(others)
    # The references are real: equal beads of radius 0.5 behind the striker.
    equal = hc.Chain(np.r_[1.0, np.full(9, 0.5)], right_wall=hc.Wall())
    assert hc.simulate(equal, times=0).wall_force().peak >= min(others) * (1 - 1e-6)


def test_geometric_masses_are_best_for_hard_spheres():
    """Closed form: with fixed ends, masses in geometric progression give the fastest last bead."""
    masses = np.ones(7)
    masses[-1] = 0.1
    chain = hc.Chain(np.cbrt(masses), masses=masses, stiffness=np.ones(6))
    problem = hc.Design(
        chain, maximise="velocity@last", model="hard-sphere",
        vary=[hc.vary.masses(0.05, 1.5, beads="2:6")],
    )  # fmt: skip
    found = hc.design(problem, method="gradient")
    assert found.chain.masses == pytest.approx(0.1 ** (np.arange(7) / 6), rel=1e-6)
    ratio = 0.1 ** (1 / 6)
    assert -found.expected == pytest.approx((2 / (1 + ratio)) ** 6, rel=1e-10)


@pytest.mark.long
def test_solitary_waves_of_dimers_are_optima_of_transmission():
    """Jayaprakash et al., Phys. Rev. E 83, 036606 (2011): four ratios of the masses."""
    problem = hc.Design(
        hc.Chain.dimer(0.5, beads=100), maximise="velocity@91/velocity@31",
        vary=[hc.vary.masses(0.05, 0.6, beads="2::2", by="common")],
    )  # fmt: skip
    found = hc.design(problem)
    ratios = np.array([each.chain.masses[1] for each in found.optima])
    for published in (0.3428, 0.1548, 0.0901, 0.0615):
        assert np.abs(ratios / published - 1.0).min() < 1e-3


def all_peaks():
    """Peak forces of all sequences of six balls behind the striker, by `simulate`."""
    steel, ptfe = hc.material("steel-304"), hc.material("ptfe")
    found = {}
    for kinds in itertools.product((steel, ptfe), repeat=5):
        radii = np.r_[2.38e-3, np.full(5, 4.7625e-3 / 2), 2.38e-3]
        chain = STEEL.replace(radii=radii, materials=(steel, *kinds, steel))
        found[kinds] = hc.simulate(chain, times=0).wall_force().peak
    return found


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
def test_enumeration_and_genetic_search_find_the_best_sequence():
    peaks = all_peaks()
    problem = hc.Design(STEEL, minimise="wall_force.peak", vary=[balls(beads="2:6")])
    for method, budget in (("enumerate", 40), ("genetic", 300)):
        found = hc.design(problem, method=method, budget=budget)
        assert found.value == pytest.approx(min(peaks.values()), rel=1e-6)
        assert found.chain.materials[1:6] == min(peaks, key=peaks.get)
    assert sum(count for count, _ in found.parts) == 5
    assert any("Hertz" in note for note in found.notes)


def test_all_orders_are_tried_once():
    chain = hc.Chain.from_radii([1.0, 0.5, 0.5, 0.8, 0.8, 0.8])
    problem = hc.Design(chain, maximise="velocity@last", vary=[hc.vary.order()])
    assert problem.space.count == 10
    found = hc.design(problem)
    assert found.method == "enumerate"
    assert found.runs == 10
    assert sorted(found.chain.radii) == sorted(chain.radii)
    best = max(
        hc.simulate(hc.Chain.from_radii([1.0, *order]), times=0).pulse().velocity[-1]
        for order in set(itertools.permutations(chain.radii[1:]))
    )
    assert found.value == pytest.approx(best, rel=1e-6)


def test_known_choices_join_a_new_population_without_another_simulation():
    """Neighbours that an earlier start has tried must not end the exchanges of a later one."""
    problem = hc.Design(
        hc.Chain.from_radii([1.0, 0.5, 0.6, 0.7, 0.8]), maximise="velocity@last",
        vary=[hc.vary.order()],
    )  # fmt: skip
    trials = Trials(problem, budget_from(100), Journal(None, ""), seed=0)
    first = Population(trials, np.random.default_rng(0))
    orders = [np.array(each) for each in itertools.permutations(range(4))]
    first.try_all(orders)
    assert trials.runs == 24
    best = first.members[0]
    later = Population(trials, np.random.default_rng(1))
    later.known = first.known
    start = next(x for x in orders if np.count_nonzero(x != best.x) == 2)
    later.try_all([start])
    assert later.try_all(later.neighbours(start))
    assert later.members[0].rank == best.rank
    assert len({each.x.tobytes() for each in later.members}) == len(later.members)
    assert trials.runs == 24


def test_each_choice_is_simulated_once():
    """In front of a wall, also the rows of equal balls with which the design is compared."""
    for vary, count in (
        ([balls(beads="2:6")], 32), ([balls(beads="2:5", optional=True)], 31),
    ):  # fmt: skip
        problem = hc.Design(STEEL, minimise="wall_force.peak", vary=vary)
        trials = Trials(problem, budget_from(1000), Journal(None, ""), seed=0, threads=1)
        trials.references = evaluated_references(trials)
        enumerate_all(trials, 1.0)
        assert problem.space.count == trials.runs == count


def test_the_history_has_each_improvement_at_its_simulation():
    chain = hc.Chain.from_radii([1.0, 0.5, 0.6, 0.7, 0.8])
    problem = hc.Design(chain, maximise="velocity@last", vary=[hc.vary.order()])
    trials = Trials(problem, budget_from(100), Journal(None, ""), seed=0)
    points = [np.array(each) for each in itertools.permutations(range(4))]
    scores = [each.score for each in trials.evaluate(points)]
    lowest = np.minimum.accumulate(scores)
    where = np.r_[0, 1 + np.flatnonzero(np.diff(lowest))]
    assert len(where) > 2
    assert trials.history == [(int(i) + 1, scores[i]) for i in where]


def test_the_order_of_beads_behind_a_striker_may_vary():
    chain = hc.Chain.from_radii([1.0, 0.5, 0.8, 0.6]).replace(right_wall=hc.Wall())
    struck = chain.struck_by(radius=1.5, gap=0.1)
    problem = hc.Design(struck, minimise="wall_force.peak", vary=[hc.vary.order(beads="3:")])
    found = hc.design(problem)
    peaks = [
        hc.simulate(
            hc.Chain.from_radii([1.0, *order]).replace(right_wall=hc.Wall())
            .struck_by(radius=1.5, gap=0.1), times=0,
        ).wall_force().peak
        for order in itertools.permutations([0.5, 0.8, 0.6])
    ]  # fmt: skip
    assert found.value == pytest.approx(min(peaks), rel=1e-6)
    assert found.chain.strikers == 1
    assert found.chain.gaps.tolist() == struck.gaps.tolist()


def test_the_summary_states_that_the_striker_does_not_count():
    hammered = STEEL.replace(velocities=None).struck_by(velocity=0.1, mass=0.05, radius=np.inf)
    problem = hc.Design(
        hammered, minimise="wall_force.peak", vary=[balls()], subject_to={"length": "<= 40 mm"}
    )
    found = hc.design(problem, budget=30)
    length = 2e3 * found.chain.radii[1:].sum()
    lines = found.summary().splitlines()
    assert any(
        line.startswith(f"  length <= 40 mm: {length:.4g} mm without the striker") for line in lines
    )


def test_places_may_be_empty_and_the_length_is_limited():
    problem = hc.Design(
        STEEL, minimise="wall_force.peak", vary=[balls(optional=True)],
        subject_to={"length": "<= 20 mm"},
    )  # fmt: skip
    found = hc.design(problem, budget=800)
    assert found.met
    assert found.chain.beads == 4
    assert 2 * found.chain.radii.sum() <= 0.02
    assert found.chain.velocities.tolist() == [1.0, 0.0, 0.0, 0.0]
    lines = found.summary().splitlines()
    length = 2e3 * found.chain.radii.sum()
    assert f"  length <= 20 mm: {length:.4g} mm with the arriving ball" in lines
    (order,) = [line for line in lines if line.startswith("order: ")]
    assert order.startswith("order: 4.76 mm steel-304 (arrives), ")
    counts = [int(each.split(" x ")[0]) if " x " in each else 1 for each in order.split(", ")]
    assert sum(counts) == found.chain.beads


def test_the_order_of_a_summary_may_be_the_start():
    """The ball that arrives has its mark in the summary, and does not vary."""

    def row(*start, beads="2:"):
        given = hc.vary.balls(
            materials="steel-304",
            diameters=["4 mm", "5 mm"],
            beads=beads,
            optional=True,
            start=start,
        )
        space = hc.Design(STEEL, minimise="velocity@last", vary=[given]).space
        return [space.balls[i].diameter for i in space.start if i < len(space.balls)]

    listed = "4 mm steel-304", "2 x 5 mm steel-304"
    assert row("23.0673 mm steel-304 (arrives)", *listed) == row(*listed) == [4e-3, 5e-3, 5e-3]
    # A ball that arrives and varies remains in the row.
    assert row("4 mm steel-304 (arrives)", "5 mm steel-304", beads="1:") == [4e-3, 5e-3]


def test_constraints_hold_and_are_active():
    limit = 0.95 * 2 * (1 + 9 * 0.75)
    problem = hc.Design(
        WALLED, minimise="wall_force.peak", vary=[hc.vary.radii(0.5, 1.0)],
        subject_to={"length": f">= {limit}", "velocity@5": "<= 1.2"},
    )  # fmt: skip
    found = hc.design(problem, budget=400, method="gradient")
    pulse = hc.simulate(found.chain, times=0).pulse()
    assert found.met
    assert 2 * found.chain.radii.sum() >= limit * (1 - 1e-6)
    assert pulse.velocity[4] <= 1.2 * (1 + 1e-6)


def absorber():
    """Balls of steel and PTFE in which later waves load contacts more than the leading pulse."""
    kinds = ["steel", "ptfe", "steel", "steel", "steel", "steel", "ptfe", "ptfe", "ptfe", "ptfe"]
    large = np.array([1, 0, 1, 1, 1, 0, 1, 0, 0, 0], bool)
    names = {"steel": "steel-52100", "ptfe": "ptfe"}
    return hc.Chain.from_materials(
        np.where(large, 3.175e-3, 2.38125e-3), [names[kind] for kind in kinds], velocity=1.0,
        right_wall=hc.Wall.of("steel-52100"),
    )  # fmt: skip


@pytest.fixture(scope="module")
def soft_row():
    chain = absorber()
    problem = hc.Design(chain, minimise="wall_force.peak", vary=[hc.vary.order()],
                        subject_to={"yield_ratio": "<= 1"})  # fmt: skip
    return quietly(problem, chain, np.nan, 0)


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
def test_limits_of_hertz_are_those_of_the_whole_run(soft_row):
    chain = soft_row.chain
    run = hc.simulate(chain)
    notes = hc.hertz_range(chain, run.largest_overlaps).violations
    assert len(notes) == 2
    assert set(notes) <= set(soft_row.notes)
    # Another integrator, saved so finely that maxima between times do not matter.
    motion = trajectory(chain, np.linspace(0.0, run.end_time, 20_001))
    overlaps = -np.diff(np.pad(motion.displacements, ((0, 0), (0, 1))), axis=1)
    overlaps = overlaps.max(axis=0, initial=0.0)
    expected = hc.hertz_range(chain, np.r_[0.0, overlaps]).yield_ratio.max()
    assert soft_row.values["yield_ratio"] == pytest.approx(expected, rel=1e-5)
    leading = hc.hertz_range(chain, run.pulse().peak_overlap).yield_ratio.max()
    assert leading < 0.95 * expected


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
def test_the_force_with_contacts_that_yield_is_reported_where_elastic_ones_leave_their_range(
    soft_row,
):
    dented = soft_row.chain.replace(loss=hc.ElasticPlastic())
    peak = hc.simulate(dented, rtol=1e-10).wall_force().peak
    assert soft_row.yielding["wall_force.peak"] == pytest.approx(peak, rel=1e-5)
    assert peak < 0.5 * soft_row.values["wall_force.peak"]


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
def test_if_no_chain_meets_the_constraints_the_closest_one_meets_those_of_sizes():
    problem = hc.Design(
        STEEL, minimise="wall_force.peak",
        vary=[balls(diameters=["4.7625 mm", "6.35 mm"], optional=True, beads="2:5")],
        subject_to={"length": ["<= 31 mm", ">= 28 mm"], "yield_ratio": "<= 1"},
    )  # fmt: skip
    rows = {}
    for choice in itertools.product(range(5), repeat=4):
        chain = problem.space.chain_of(np.array(choice))
        if chain in rows:
            continue
        run, length = hc.simulate(chain), 2.0 * chain.radii.sum()
        ratio = hc.hertz_range(chain, run.largest_overlaps).yield_ratio.max()
        total = max(0.0, length / 31e-3 - 1.0) + max(0.0, 1.0 - length / 28e-3)
        rows[chain] = (total, max(0.0, ratio - 1.0)), run.wall_force().peak
    least = min(rows.values())
    for method, budget in (("enumerate", 1000), ("genetic", 900)):
        found = hc.design(problem, method=method, budget=budget)
        assert not found.met
        assert found.value == pytest.approx(least[1], rel=1e-5)
        first = found.summary().splitlines()[0]
        assert first.startswith("No trial meets the constraints; the closest one has ")


def test_an_impossible_impulse_is_reported_with_its_bound():
    problem = hc.Design(
        WALLED, minimise="wall_force.peak", vary=[hc.vary.radii(0.5, 1.0)],
        subject_to={"wall_force.impulse_of_impact": "<= 0.9"},
    )  # fmt: skip
    found = hc.design(problem)
    assert not found.met
    assert found.runs == 1
    assert "at least 1, because the wall must stop the momentum" in found.notes[0]
    assert found.values["wall_force.impulse_of_impact"] >= 1.0


@pytest.mark.long
def test_the_law_keeps_its_promise():
    problem = hc.Design(
        hc.Chain.uniform(60), minimise="velocity@50",
        vary=[hc.vary.radii(0.5, 2.0, by="spline", knots=8)],
    )  # fmt: skip
    promised = promise(problem)
    truth = hc.propagate(problem.space.chain_of(promised.x)).velocity[49]
    assert promised.error <= 2e-3
    assert truth == pytest.approx(promised.value, rel=3e-3)
    found = hc.design(problem, budget=300)
    assert found.method == "law"
    assert found.value <= truth * (1 + 1e-6)


@pytest.mark.long
def test_a_scatter_is_summarised_by_the_worst_samples():
    scatter = hc.Scatter(radius=0.02, measure="cvar80", samples=10)
    problem = hc.Design(
        WALLED, minimise="wall_force.peak", vary=[hc.vary.radii(0.5, 1.0)], scatter=scatter
    )
    trials = Trials(problem, budget_from(100), Journal(None, ""), seed=3)
    (outcome,) = trials.evaluate([np.full(9, 0.4)])
    chain = problem.space.chain_of(np.full(9, 0.4))
    radii = chain.radii * np.exp(0.02 * scatter._draws(3, 10)[..., 0])
    peaks = [hc.simulate(chain.replace(radii=each), times=0).wall_force().peak for each in radii]
    assert outcome.score == pytest.approx(np.mean(sorted(peaks)[-2:]), rel=1e-6)
    found = hc.design(problem, budget=1600)
    assert found.verified.scattered["CVaR90 of wall_force.peak"] > found.value * 0.98
    # The first line states what was minimised: the mean of the two worst of ten samples.
    radii = found.chain.radii * np.exp(0.02 * scatter._draws(0, 10)[..., 0])
    peaks = [hc.simulate(found.chain.replace(radii=each), times=0).wall_force().peak
             for each in radii]  # fmt: skip
    first = found.summary().splitlines()[0]
    said = r"Smallest CVaR80 of wall_force.peak: (.*) in the search; (.*) without scatter"
    values = [float(each) for each in re.fullmatch(said, first).groups()]
    assert values == pytest.approx([np.mean(sorted(peaks)[-2:]), found.value], rel=2e-4)
    assert found.plot("history").get_ylabel() == "CVaR80 of peak force on the wall"


@pytest.mark.parametrize("budget", [900, pytest.param(2000, marks=pytest.mark.long)])
def test_starts_with_scatter_are_compared_by_its_statistic(budget):
    """With the smaller budget, no descent with scatter begins."""
    scatter = hc.Scatter(radius=0.01, samples=10)
    varied = hc.vary.radii("1.5 mm", "4 mm", beads="2:")
    chain = hc.Chain.from_materials("3.175 mm", "steel-52100", beads=9, velocity="0.3 m/s")
    problem = hc.Design(
        chain.replace(right_wall=hc.Wall()), minimise="wall_force.peak", vary=[varied],
        scatter=scatter,
    )  # fmt: skip
    found = hc.design(problem, budget=budget)
    assert found.expected > 1.01 * found.value
    assert found.finals.min() == pytest.approx(found.expected, rel=1e-12)
    lines = found.summary().splitlines()
    assert len(found.finals) == 2
    (line,) = (each for each in lines if " starts (" in each)
    assert f"(CVaR90: best {found._shown(found.expected).strip()}, median " in line
    assert any(re.fullmatch(r"  wall_force.peak +CVaR90 +no scatter( .*)?", each) for each in lines)


@pytest.mark.parametrize(("measure", "tail"), [("cvar80", "CVaR80"), ("mean", "CVaR90")])
def test_samples_that_exceed_a_limit_are_marked(measure, tail):
    scatter = hc.Scatter(radius=0.02, measure=measure, samples=10, beads="2:")
    given = {"minimise": "wall_force.peak", "vary": [hc.vary.radii(0.5, 1.0, by="common")]}
    free = hc.design(hc.Design(WALLED, scatter=scatter, **given), budget=120)
    samples = free.verified.scattered
    # Between the mean and the worst sample.
    limit = samples[f"{tail} of wall_force.peak"] * (1.0 - 1e-5)
    limited = hc.Design(
        WALLED, scatter=scatter, subject_to={"wall_force.peak": f"<= {limit}"}, **given
    )
    result = dataclasses.replace(free, problem=limited)
    lines = result.summary().splitlines()
    (line,) = (each for each in lines if each.startswith("  with scatter, 400 new samples"))
    assert line.endswith(f"({tail} and worst value exceed the limit)")
    assert "exceed" not in free.summary()


@pytest.mark.long
def test_limits_that_new_samples_violate_are_not_met():
    """The limit is between the CVaR of the samples and that of new ones."""
    chain = hc.Chain.from_materials("4 mm", "steel-52100", beads=3, velocity=0.1)
    chain = chain.replace(right_wall=hc.Wall.of("steel-52100"))
    given = {
        "minimise": "length",
        "vary": [hc.vary.balls(materials="steel-52100", diameters=["8 mm", "9 mm"], beads="2:")],
        "scatter": hc.Scatter(radius=0.01, samples=4, beads="2:"),
    }
    cvar = {}
    for count, seed in ((4, 0), (400, 1_000_003)):
        draws = given["scatter"]._draws(seed, 3, count)
        chains = given["scatter"]._chains(chain, draws)
        peaks = [hc.simulate(each, times=0, rtol=1e-8).wall_force().peak for each in chains]
        cvar[count] = np.mean(sorted(peaks)[-max(1, count // 10) :])
    assert cvar[4] < cvar[400]
    for limit, fine in ((0.5 * (cvar[4] + cvar[400]), False), (1.001 * cvar[400], True)):
        # Only the row of balls of 8 mm is short enough.
        subject = {"wall_force.peak": f"<= {limit:.9g} N", "length": "<= 24.1 mm"}
        result = hc.design(hc.Design(chain, subject_to=subject, **given), budget=100)
        assert result.met == result.as_dict()["constraints_met"] == fine
        assert result.summary().startswith("Smallest") == fine
        noted = [
            note for note in result.notes if "new samples of the scatter violate CVaR90" in note
        ]
        assert len(noted) == (not fine)


def test_models_of_samples_have_the_cvar_and_its_derivatives():
    scatter = hc.Scatter(radius=0.02, measure="cvar80", samples=10)
    problem = hc.Design(
        WALLED, minimise="wall_force.peak", vary=[hc.vary.radii(0.5, 1.0)], scatter=scatter
    )
    trials = Trials(problem, budget_from(100), Journal(None, ""), seed=3)
    outcome, slopes, models = trials.slopes(np.linspace(0.7, 0.2, 9))
    assert set(models[:, 0]) == set(range(10))
    highest = [max(models[models[:, 0] == i].tolist(), key=lambda row: row[1]) for i in range(10)]
    worst = np.array(sorted(highest, key=lambda row: row[1])[-2:])
    assert worst[:, 1].mean() == pytest.approx(outcome.score, rel=1e-4)
    assert worst[:, 2:].mean(axis=0) == pytest.approx(slopes[0], abs=1e-12)


def test_a_step_minimises_the_cvar_of_piecewise_linear_samples():
    """Of |x - a| over several a, a straight search finds the minimum."""
    points, at, counted = np.array([0.1, 0.2, 0.25, 0.6, 0.9]), 0.8, 2

    def cvar(x):
        return np.sort(np.abs(x - points))[-counted:].mean()

    pieces = np.array(
        [[i, sign * (at - a), sign] for i, a in enumerate(points) for sign in (1, -1)]
    )
    outcome = Outcome(np.array([at]), np.array([cvar(at)]), cvar(at), 0.0)
    model = Model(outcome, np.zeros(1), np.zeros(0), np.zeros((0, 1)), pieces, counted)
    step, gain = _step(model, [model], 1.0)
    grid = np.linspace(0.0, 1.0, 10_001)
    assert cvar(at + step[0]) == pytest.approx(min(map(cvar, grid)), abs=1e-9)
    assert gain == pytest.approx(cvar(at) - cvar(at + step[0]), abs=1e-9)


@pytest.mark.filterwarnings("ignore::hertzchain.errors.ModelRangeWarning")
def test_the_projectile_can_be_left_out_of_the_scatter_of_a_design():
    """By bead 1 alone the spread of the force is larger than by all others."""
    row = hc.Chain.from_materials(
        2.38e-3, "steel-304", beads=7, velocity=0.01, right_wall=hc.Wall.of("steel-304")
    )
    spread = {}
    for beads in (None, "2:", [1]):
        scatter = hc.Scatter(radius=0.01, beads=beads)
        chains = scatter._chains(row, scatter._draws(5, 7, 200))
        spread[str(beads)] = np.std(hc.simulate_many(chains, keep="wall_peak_force")[
            "wall_peak_force"])  # fmt: skip
        kept = [chain.radii[0] == row.radii[0] for chain in chains]
        assert all(kept) if beads == "2:" else not any(kept)
    assert spread["None"] > 1.3 * spread["2:"]
    with pytest.raises(hc.InputError, match="outside 1 to 7"):
        hc.Design(row, minimise="wall_force.peak", vary=[hc.vary.radii("2 mm", "3 mm")],
                  scatter={"radius": 0.01, "beads": "2:9"})  # fmt: skip


@pytest.mark.long
def test_a_front_has_only_designs_that_no_other_one_beats():
    problem = hc.Design(
        hc.Chain.uniform(6), maximise=["velocity@last", "smallest_radius"],
        vary=[hc.vary.radii(0.5, 1.0)],
    )  # fmt: skip
    found = hc.design(problem, budget=800, points=4)
    speeds = [each.values["velocity@last"] for each in found.front]
    sizes = [each.values["smallest_radius"] for each in found.front]
    assert len(found.front) == 4
    assert (np.diff(speeds) < 0).all()
    assert (np.diff(sizes) > 0).all()


def balls_and_masses(**more):
    """Three kinds of balls in four places, some of them empty: 120 rows."""
    chain = hc.Chain.from_materials(
        "3.175 mm", "steel-52100", beads=5, velocity=0.2, right_wall=hc.Wall.of("steel-52100")
    )
    balls = hc.vary.balls(
        materials="steel-52100", diameters=["4 mm", "5 mm", "6.35 mm"], optional=True
    )
    return hc.Design(chain, minimise=["wall_force.peak", "mass"], vary=[balls], **more)


def undominated_by_hand():
    """Pairs of force and mass of all rows that no other row beats, in order of the force."""
    sizes = [0.5e-3 * each for each in (4.0, 5.0, 6.35)]
    rows = [row for n in range(5) for row in itertools.product(sizes, repeat=n)]
    chains = [
        hc.Chain.from_materials([3.175e-3, *row], "steel-52100", velocity=0.2).replace(
            right_wall=hc.Wall.of("steel-52100")
        )
        for row in rows if row
    ]  # fmt: skip
    force = hc.simulate_many(chains, keep=["wall_peak_force"], rtol=1e-10)["wall_peak_force"]
    mass = np.array([each.masses.sum() for each in chains])
    return sorted(
        (f, m) for f, m in zip(force, mass, strict=True)
        if not ((force < f * (1 - 1e-4)) & (mass < m * (1 + 1e-9))).any()
        and not ((force < f * (1 + 1e-4)) & (mass < m * (1 - 1e-9))).any()
    )  # fmt: skip


@pytest.mark.parametrize(("method", "budget"), [("auto", 400), ("genetic", 3000)])
def test_a_front_of_balls_has_all_rows_that_no_other_one_beats(method, budget):
    problem = balls_and_masses()
    found = hc.design(problem, budget=budget, method=method)
    names = [str(each.single) for each in problem.objectives]
    front = [tuple(each.values[name] for name in names) for each in found.front]
    # Rows of equal force and mass are one point.
    listed = undominated_by_hand()
    expected = [
        pair for i, pair in enumerate(listed)
        if not i or pair != pytest.approx(listed[i - 1], rel=1e-4)
    ]  # fmt: skip
    assert len(expected) >= 5
    np.testing.assert_allclose(sorted(front), expected, rtol=1e-6)
    text = found.summary()
    first = found.front[0].values
    assert (f"  1: wall_force.peak {first['wall_force.peak']:.4g} N, "
            f"mass {1e3 * first['mass']:.4g} g") in text  # fmt: skip
    document = found.as_dict()["front"][-1]
    assert document["values"]["mass"] == found.front[-1].values["mass"]
    assert len(document["materials"]) == found.front[-1].chain.beads == len(document["radii"])
    assert document["chain_file"]["chain"]["right_wall"]["material"] == "steel-52100"


@pytest.mark.long
def test_a_genetic_search_finds_most_of_a_front_in_few_simulations():
    """A fifth of all 3279 rows; one search per level of the length found 7 of the 10 points."""
    chain = hc.Chain.from_materials(
        "3.175 mm", "steel-52100", beads=8, velocity=0.2, right_wall=hc.Wall.of("steel-52100")
    )
    sizes = hc.vary.balls(
        materials="steel-52100", diameters=["3 mm", "5 mm", "8 mm"], beads="2:", optional=True
    )
    problem = hc.Design(
        chain, minimise=["wall_force.peak", "length"], vary=[sizes],
        subject_to={"yield_ratio": "<= 1"},
    )  # fmt: skip

    def points(result):
        assert all(each.values["yield_ratio"] <= 1.0 for each in result.front)
        return np.array([[each.values[str(m)] for m in problem.reported] for each in result.front])

    complete = hc.design(problem)
    assert complete.front_is_complete
    assert "Pareto front:" in complete.summary()
    every = points(complete)
    for seed in range(3):
        found = hc.design(problem, budget=600, method="genetic", seed=seed)
        assert found.runs <= 600
        assert not found.front_is_complete
        assert (
            f"Pareto front of {found.runs} simulated choices, of {problem.space.count:.2g} in all; "
            "it may miss points" in found.summary()
        )
        assert f"Pareto front of {found.runs} simulated" in found._repr_html_()
        front = points(found)
        known = [bool((np.abs(front / one - 1.0) < 1e-4).all(axis=1).any()) for one in every]
        assert len(known) == 10
        assert sum(known) >= 9
        # The result is the first point of the front, also in the history of the search.
        assert found.value == found.front[0].value == front[:, 0].min()
        assert found.history[-1, 1] == pytest.approx(found.value, rel=1e-4)


def test_isolated_points_of_the_first_fronts_are_the_best_parents():
    costs = np.array([[0, 9], [1, 8], [2, 7], [5, 2], [9, 0], [1, 9], [6, 2], [9, 9]], float)
    assert undominated(costs) == [0, 1, 2, 3, 4]
    assert best_spread(costs, 7) == [0, 4, 3, 2, 1, 5, 6]
    assert best_spread(costs[:2], 7) == [0, 1]
    assert best_spread(np.empty((0, 2)), 7) == []


@pytest.fixture(scope="module")
def partly_yielding():
    """A front of rows of hard and of softer steel, of which only the latter yield."""
    chain = hc.Chain.from_materials(
        "3.175 mm", "steel-52100", beads=4, velocity=0.1, right_wall=hc.Wall.of("steel-52100")
    )
    kinds = hc.vary.balls(materials=["steel-52100", "steel-304"], diameters=["4 mm", "6.35 mm"])
    return hc.design(hc.Design(chain, minimise=["wall_force.peak", "mass"], vary=[kinds]))


def test_points_of_a_front_whose_contacts_yield_are_marked(partly_yielding):
    front = partly_yielding.front
    yields = []
    for point in front:
        with warnings.catch_warnings(record=True):
            warnings.simplefilter("always")
            run = hc.simulate(point.chain, times=0)
        yields.append(hc.hertz_range(point.chain, run.largest_overlaps).yield_ratio.max() > 1.0)
    assert 0 < sum(yields) < len(yields)
    lines = [line for line in partly_yielding.summary().splitlines()
             if re.match(r"  \d+: wall_force", line)]  # fmt: skip
    for line, point, outside in zip(lines, front, yields, strict=True):
        assert ("with contacts that yield" in line) == outside
        if outside:
            dented = point.chain.replace(loss=hc.ElasticPlastic())
            force = float(re.search(r"\((\S+) N with", line)[1])
            assert force == pytest.approx(hc.simulate(dented).wall_force().peak, rel=1e-3)
    assert f"contacts of {sum(yields)} of the {len(front)} points" in partly_yielding.summary()
    document = partly_yielding.as_dict()["front"]
    assert [not point["hertz_range_kept"] for point in document] == yields
    assert any(
        "the Pareto front is that of elastic contacts" in note for note in partly_yielding.notes
    )


def test_the_plot_of_a_front_has_hollow_points_where_contacts_yield(partly_yielding):
    axes = partly_yielding.plot("front")
    # Rows to compare with are hollow, too.
    own = [line for line in axes.lines if line.get_label().startswith("outside")]
    hollow = [line for line in own if line.get_markerfacecolor() == "none"]
    outside = sum(point.verified.outside_range for point in partly_yielding.front)
    assert [len(line.get_xdata()) for line in hollow] == [outside]
    # The same points with contacts that yield.
    label = "with contacts that yield"
    (crosses,) = (line for line in axes.lines if line.get_label() == label)
    yielding = [point.verified.yielding["wall_force.peak"] for point in partly_yielding.front
                if point.verified.outside_range]  # fmt: skip
    assert sorted(crosses.get_ydata()) == pytest.approx(sorted(yielding))
    assert label in legend_texts(axes)
    # Nothing is between rows of balls: only points are on the front, and the line has steps.
    (steps,) = (line for line in axes.lines if line.get_drawstyle() != "default")
    assert steps.get_drawstyle() == "steps-post"


@pytest.mark.long
def test_points_of_a_front_that_yield_beats_are_marked_and_the_verification_is_reported(
    monkeypatch,
):
    """A struck row of steel and PTFE; lengths are those of the row, without the striker."""
    lines = []
    monkeypatch.setattr(pareto, "INTERVAL", 0.0)
    monkeypatch.setattr(pareto, "write_current", lines.append)
    chain = hc.Chain.from_materials("5 mm", "steel-52100", beads=4, velocity=0.0)
    chain = chain.struck_by(diameter="20 mm", velocity="0.3 m/s")
    kinds = hc.vary.balls(
        materials=["steel-52100", "ptfe"], diameters=["4.7625 mm", "7.9375 mm"], beads="2:",
        optional=True,
    )  # fmt: skip
    found = hc.design(
        hc.Design(chain.replace(right_wall=hc.Wall.of("steel-52100")),
                  minimise=["wall_force.peak", "length"], vary=[kinds]),
        progress=print,
    )  # fmt: skip
    count = len(found.front)
    assert lines == [
        f"hertzchain: verified {i} of {count} points of the Pareto front"
        for i in range(1, count + 1)
    ]
    # One point is outside the range of the law of yield, and is not compared.
    outside = [point.verified.yielding_overlap_ratio > 0.1 for point in found.front]
    assert outside == [i == 5 for i in range(count)]
    kept = [point for point, far in zip(found.front, outside, strict=True) if not far]
    forces = [(point.values | point.verified.yielding)["wall_force.peak"] for point in kept]
    lengths = [point.values["length"] for point in kept]
    beaten = [
        (1e3 * length, force) for force, length in zip(forces, lengths, strict=True)
        if any(f <= force and x <= length and (f, x) != (force, length)
               for f, x in zip(forces, lengths, strict=True))
    ]  # fmt: skip
    assert beaten
    axes = found.plot("front")
    (marks,) = (line for line in axes.lines if str(line.get_label()).startswith("beaten"))
    assert sorted(marks.get_xydata().tolist()) == pytest.approx(np.array(sorted(beaten)))
    words = "with contacts that yield, outside the range of the law"
    (cross,) = (line for line in axes.lines if " ".join(line.get_label().split()) == words)
    assert len(cross.get_xdata()) == 1
    assert "1 of the 7 points is outside the range of the law" in found.summary()
    lines = [line for line in found.summary().splitlines() if re.match(r"  \d+: wall_force", line)]
    assert [words in line for line in lines] == outside
    ranges = [point["yielding_within_range"] for point in found.as_dict()["front"]]
    assert ranges == [not each for each in outside]
    assert axes.get_xlabel() == "length of the chain without the striker [mm]"
    # The striker is shaded where changes of the objective are plotted.
    panel = found.plot("sensitivity")
    assert "striker" in legend_texts(panel)


def test_forces_with_contacts_that_yield_are_dashed(partly_yielding):
    assert partly_yielding.verified.yielding
    axes = partly_yielding.plot("forces")
    elastic = [line for line in axes.lines if line.get_linestyle() == "-"]
    dashed = {line.get_color(): line for line in axes.lines if line.get_linestyle() == "--"}
    assert len(elastic) == 2
    dashed = dashed[elastic[1].get_color()]
    peak = partly_yielding.verified.yielding["wall_force.peak"]
    assert dashed.get_ydata().max() == pytest.approx(peak, rel=1e-3)
    texts = [text.get_text().replace("\n", " ") for text in axes.get_legend().get_texts()]
    value = partly_yielding.values["wall_force.peak"]
    assert texts[1] == f"design, peak {value:.4g} N (dashed, with yield, 1.6 Y: {peak:.4g} N)"
    (name, other), _ = shown_chains(partly_yielding).items()
    assert texts[0].startswith(f"{name}, peak ")
    assert ("with yield" in texts[0]) == bool(other.yielding)


def test_a_comparison_that_contacts_that_yield_reverse_says_so(partly_yielding):
    """A reference whose force is larger elastically, and smaller with contacts that yield."""
    elastic = next(point for point in partly_yielding.front if not point.verified.yielding)
    design, name, force = elastic.verified, "wall_force.peak", elastic.value
    values = design.values | {name: 2.0 * force}
    other = dataclasses.replace(design, values=values, yielding=values | {name: 0.5 * force})
    found = dataclasses.replace(elastic, references={"row": other}, compared={"row": 1})
    lines = found.summary().splitlines()
    place = lines.index("  row:")
    assert lines[place + 1].split() == ["value", f"{2 * force:.4g}", "N", f"{force / 2:.4g}", "N"]
    assert lines[place + 2].split()[-2:] == ["50.0%", "200.0%"]
    assert lines[place + 3] == ("    this design is 50% better with elastic contacts and 100% "
                                "worse at 1.6 Y: yield reverses the comparison")  # fmt: skip
    (entry,) = found.as_dict()["references"].values()
    assert entry["value"] == 2.0 * force
    assert entry["value_with_yielding_contacts"] == 0.5 * force
    assert entry["yielding_reverses_comparison"]


@pytest.fixture
def far_outside():
    """A design of PTFE and steel balls whose overlaps with yield are a third of the radius."""
    chain = hc.Chain.from_materials(
        "5 mm", "ptfe", beads=5, velocity=0.0, right_wall=hc.Wall.of("steel-52100")
    )
    chain = chain.struck_by(mass="200 g", radius=np.inf, material="steel-52100", velocity="2 m/s")
    kinds = hc.vary.balls(materials=["steel-52100", "ptfe"], diameters=["9.525 mm"])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        lifted = {"overlap_ratio": "<= 10"}
        problem = hc.Design(chain, minimise="wall_force.peak", vary=[kinds], subject_to=lifted)
        return hc.design(problem)


@pytest.mark.long
def test_values_with_yield_outside_the_range_of_the_law_are_not_compared(far_outside):
    found, name = far_outside, "wall_force.peak"
    dented = found.chain.replace(loss=hc.ElasticPlastic())
    with pytest.warns(hc.ModelRangeWarning, match="beyond 0.1, forces are not a prediction"):
        run = hc.simulate(dented)
    ratio = hc.hertz_range(dented, run.largest_overlaps).overlap_ratio.max()
    assert ratio > 0.1
    assert found.verified.yielding[name] == pytest.approx(run.wall_force().peak, rel=1e-3)
    assert found.verified.yielding_overlap_ratio == pytest.approx(ratio, rel=1e-3)
    assert found.verified.yielding_outside_range
    value = found.verified.yielding[name]
    line = f"{value:.4g} N, outside the range of the law (overlap / radius {ratio:.2g})"
    assert f"  the same chain with contacts that yield, loss=ElasticPlastic(): {line}" in (
        found.summary()
    )
    assert "have yielded" not in found.summary()
    # The other chain has a larger elastic force, and a smaller one with yield.
    values = found.verified.values
    other = dataclasses.replace(
        found.verified, values=values | {name: 2.0 * found.value},
        yielding=found.verified.yielding | {name: 0.5 * value},
    )  # fmt: skip
    both = dataclasses.replace(
        found, references={"row": other}, compared={"row": 1}, runners_up=(other,)
    )
    lines = both.summary().splitlines()
    place = lines.index("  row:")
    assert f"{0.5 * value:.4g} N*" in lines[place + 1]
    assert lines[place + 2].split()[4:6] == ["50.0%", "-"]
    assert "  * outside the range of the law, where forces are not a prediction" in lines
    assert not any("better" in line for line in lines)
    assert "runner-up 1" not in both.summary()
    document = both.as_dict()
    (entry,) = document["references"].values()
    assert entry["yielding_reverses_comparison"] is None
    assert document["better_if_yielding"] is None
    for each in (entry, document):
        assert each["yielding_within_range"] is False
        assert each["yielding_overlap_ratio"] == pytest.approx(ratio, rel=1e-3)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        axes = found.plot("forces")
    texts = [text.get_text().replace("\n", " ") for text in axes.get_legend().get_texts()]
    assert f"(dashed, with yield, 1.6 Y: {value:#.4g} N, outside the range of the law)" in texts[-2]
    assert texts[-1].startswith("not drawn: given chain, peak ")


def test_the_summary_of_a_design_states_dents(partly_yielding):
    point = next(point for point in partly_yielding.front if point.verified.yielding)
    run = hc.simulate(point.chain.replace(loss=hc.ElasticPlastic()), rtol=1e-9)
    text = f"deepest dent {1e6 * run.dents.max():.3g} um at contact {run.dents.argmax()}"
    assert text in point.verified.dents
    assert point.as_dict()["dents"] == point.verified.dents
    single = dataclasses.replace(point, front=())
    assert f"\n  {point.verified.dents}\n" in single.summary()


def test_the_row_of_equal_balls_is_named_and_a_search_that_does_not_beat_it_says_so():
    chain = hc.Chain.from_materials(
        "5 mm", "steel-52100", beads=5, velocity="0.1 m/s", right_wall=hc.Wall.of("steel-52100")
    )
    balls = hc.vary.balls(
        materials=["steel-52100"], diameters=["5 mm", "8 mm"], beads="2:", optional=True
    )
    found = hc.design(hc.Design(chain, minimise="length", vary=[balls]), budget=100)
    (line,) = (x for x in found.summary().splitlines() if "row of equal balls (" in x)
    assert line.endswith("tried), 1 ball of 5 mm steel-52100: 15 mm")
    assert "    this design: 100.0% of this value" in found.summary().splitlines()
    at_limit = "all balls have the smallest allowed diameter, 5 mm: allow smaller ones, which may"
    line = f"no other choice is better than the best row of equal balls; {at_limit} be better"
    assert f"  {line}" in found.summary().splitlines()
    entry, taper = found.as_dict()["references"].values()
    # A taper has at least three balls that vary.
    assert taper["value"] > 2 * entry["value"]
    assert entry["balls"] == "1 ball of 5 mm steel-52100"
    assert entry["chain_file"]["chain"]["radii"] == [5e-3, 2.5e-3]
    assert entry["value"] == pytest.approx(15e-3)
    few = hc.design(found.problem, method="genetic", budget=12)
    assert f"nothing better than the best row of equal balls; {at_limit}" in few.summary()
    assert "one start of method 'genetic'" in few.summary()
    problem = hc.Design(chain, minimise="wall_force.peak", vary=[balls])
    assert "nothing better" not in hc.design(problem, budget=100).summary()


def test_a_better_given_chain_of_other_sizes_is_explained_and_sizes_at_limits_are_named():
    chain = hc.Chain.from_materials(
        diameters=["10 mm", *["3 mm"] * 4], materials="steel-52100", velocity="0.05 m/s",
        right_wall=hc.Wall.of("steel-52100"),
    )  # fmt: skip
    balls = hc.vary.balls(materials=["steel-52100"], diameters=["8 mm", "10 mm"], beads="2:")
    found = hc.design(hc.Design(chain, minimise="wall_force.peak", vary=[balls]), budget=100)
    reason = "the given chain has sizes outside of the allowed ones: 3 mm"
    assert f"\n    {reason}\n" in found.summary()
    document = found.as_dict()
    assert document["given_chain"]["value"] < found.value
    assert document["given_chain"]["remarks"] == [reason]
    assert document["order"].startswith("10 mm steel-52100 (arrives), 8 mm steel-52100")
    assert document["totals"]["length"] == pytest.approx(2 * found.chain.radii.sum())
    # Among sizes, the given ones are allowed, and the mass is smallest at the smallest.
    sizes = hc.vary.radii("1.5 mm", "5 mm", beads="2:")
    light = hc.design(hc.Design(chain, minimise="mass", vary=[sizes]), budget=100)
    (line,) = (each for each in light.as_dict()["remarks"] if "that vary" in each)
    count = int(np.isclose(light.chain.radii[1:], 1.5e-3).sum())
    assert re.fullmatch(
        rf"{count} of the 4 diameters that vary (is|are) the smallest allowed, 3 mm: smaller ones "
        "may be better", line
    )  # fmt: skip
    assert f"\n  {line}\n" in light.summary()
    assert reason not in light.summary()


def test_a_search_with_scatter_says_that_it_found_nothing_better_than_equal_balls():
    chain = hc.Chain.from_materials(
        "5 mm", "steel-52100", beads=5, velocity="0.1 m/s", right_wall=hc.Wall.of("steel-52100")
    )
    balls = hc.vary.balls(
        materials=["steel-52100"], diameters=["5 mm", "8 mm"], beads="2:", optional=True
    )
    scatter = hc.Scatter(gaps="5 um", beads="2:", samples=10)
    said = {}
    for objective in ("length", "wall_force.peak"):
        problem = hc.Design(chain, minimise=objective, vary=[balls], scatter=scatter)
        said[objective] = (
            "than the best row of equal balls"
            in hc.design(problem, method="genetic", budget=400).summary()
        )
    assert said == {"length": True, "wall_force.peak": False}


def test_a_front_may_be_limited_to_some_points():
    whole = hc.design(balls_and_masses(), budget=400)
    found = hc.design(balls_and_masses(), budget=400, points=3)
    front, few = whole.front, found.front
    note = f"3 of the {len(front)} points of the Pareto front are shown"
    assert any(each.startswith(note) for each in found.notes)
    assert not any("points of the Pareto front are shown" in each for each in whole.notes)
    assert found.runs == whole.runs
    assert [few[0].value, few[-1].value] == [front[0].value, front[-1].value]
    assert len(few) == 3
    assert {each.value for each in few} < {each.value for each in front}


@pytest.mark.long
def test_a_search_among_balls_with_scatter_begins_with_the_best_without():
    """None of 250 trials with scatter would find a row as good as that of 6000 without it."""
    sizes = [f"{each} mm" for each in (3, 4, 5, 6, 7, 8)]
    chain = hc.Chain.from_materials(
        "3 mm", "steel-52100", beads=9, velocity=0.05, right_wall=hc.Wall.of("steel-52100")
    )
    row = hc.vary.balls(materials="steel-52100", diameters=sizes)
    given = {"minimise": "wall_force.peak", "vary": [row]}
    scatter = hc.Scatter(radius=0.003, samples=10, beads="2:")
    nominal = hc.design(hc.Design(chain, **given), budget=1500)
    found = hc.design(hc.Design(chain, **given, scatter=scatter), budget=5000)
    cold = Trials(
        hc.Design(chain, **given, scatter=scatter), budget_from(3500), Journal(None, ""), 0
    )
    (best, *_) = sorted(each.score for each in search(cold, 1.0, 0))
    assert found.expected < best
    assert found.expected < 1.1 * nominal.value


def test_the_figure_of_a_momentum_design_shows_momenta():
    problem = hc.Design(
        hc.Chain.uniform(6), maximise="momentum@5", vary=[hc.vary.radii(0.5, 1.5, by="common")]
    )
    found = hc.design(problem, budget=60)
    axes = found.plot("forces")
    assert axes.get_ylabel() == "momentum $P_k$"
    # A search that finds the row of equal beads draws it once.
    *_, line = axes.lines
    np.testing.assert_allclose(line.get_ydata()[4], found.value, rtol=1e-6)
    plt.close(axes.figure)


def test_equal_and_beaten_points_are_not_on_a_front():
    costs = np.array([[3.0, 1.0], [2.0, 1.0 + 1e-13], [2.0, 2.0], [1.0, 2.5], [1.0, 2.5], [4.0, 9]])
    assert undominated(costs) == [3, 1]


@pytest.mark.long
def test_a_curve_of_a_known_chain_is_found_again():
    chain = hc.Chain.from_radii([1.0, 0.8, 0.9, 0.7, 0.6])
    curve = hc.simulate(chain, times=0).pulse().velocity
    problem = hc.Design(
        hc.Chain.uniform(5), match={"velocity": curve}, vary=[hc.vary.radii(0.5, 1.2)]
    )
    found = hc.design(problem, budget=900, method="gradient")
    # Several chains have the same velocities.
    again = hc.simulate(found.chain, times=0).pulse().velocity
    assert again == pytest.approx(curve, rel=1e-6)


def test_slopes_are_those_of_finer_differences():
    problem = hc.Design(
        WALLED,
        minimise="wall_force.impulse_of_impact",
        vary=[hc.vary.radii(0.4, 1.5, by="spline", knots=4)],
    )
    trials = Trials(problem, budget_from(100), Journal(None, ""), seed=0)
    point = np.array([0.5, 0.4, 0.6])
    _, slopes, _ = trials.slopes(point)

    def impulse(x):
        run = hc.simulate(problem.space.chain_of(x), rtol=1e-12, times=0)
        return run.wall_force().impulse_of_impact

    for i, step in enumerate(1e-3 * np.eye(3)):
        near = [impulse(point + k * step) for k in (-2, -1, 1, 2)]
        fine = (near[0] - 8 * near[1] + 8 * near[2] - near[3]) / 12e-3
        assert slopes[0, i] == pytest.approx(fine, rel=1e-4, abs=1e-6)


def test_sizes_are_symmetric_or_monotone():
    rng = np.random.default_rng(0)
    for by in ("bead", "spline"):
        options = {"beads": "3:10", "by": by}
        same = hc.Design(
            WALLED, minimise="length", vary=[hc.vary.radii(0.5, 2.0, symmetric=True, **options)]
        ).space
        down = hc.Design(
            WALLED,
            minimise="length",
            vary=[hc.vary.radii(0.5, 2.0, monotone="decreasing", **options)],
        ).space
        for _ in range(5):
            radii = same.chain_of(rng.random(same.size)).radii[2:]
            assert radii == pytest.approx(radii[::-1])
            radii = down.chain_of(rng.random(down.size)).radii[2:]
            assert (np.diff(radii) <= 1e-12).all()


def test_splines_reproduce_constants_and_straight_lines():
    basis = spline_basis(30, 8)
    assert basis.sum(axis=1) == pytest.approx(np.ones(30))
    line = basis @ np.linalg.lstsq(basis, np.arange(30.0), rcond=None)[0]
    assert line == pytest.approx(np.arange(30.0), abs=1e-9)


def test_the_evolution_strategy_finds_the_minimum_of_an_ellipsoid():
    rng, centre = np.random.default_rng(5), np.linspace(0.3, 0.7, 8)
    weights = 10.0 ** np.arange(8.0)[::-1]
    strategy = Strategy(np.full(8, 0.5), 16)
    for _ in range(600):
        steps, points = strategy.ask(rng)
        strategy.tell(steps, np.argsort(((points - centre) ** 2 * weights).sum(axis=1)))
    assert strategy.mean == pytest.approx(centre, abs=1e-5)


def test_points_are_reflected_at_the_limits():
    assert reflected(np.array([-0.2, 0.3, 1.1, 2.3])) == pytest.approx([0.2, 0.3, 0.9, 0.3])


@pytest.mark.filterwarnings("ignore::hertzchain.errors.ModelRangeWarning")
def test_both_changes_of_a_radius_increase_equal_maxima():
    # The best order of 8 steel and 7 PTFE balls has three maxima of nearly the same height.
    kinds = [{"S": "steel-52100", "P": "ptfe"}[each] for each in "SPPSSSSSSPSPPPP"]
    chain = hc.Chain.from_materials("5 mm", kinds, velocity="2 m/s", right_wall=hc.Wall.of("ptfe"))
    radii = hc.vary.radii("4 mm", "6 mm")
    problem = hc.Design(chain, minimise="wall_force.peak", vary=[radii])
    larger, smaller = changes(problem, chain, 0.01)
    nominal, up, down = hc.simulate_many(
        [chain] + [
            chain.replace(radii=np.where(np.arange(15) == 2, factor, 1.0) * chain.radii)
            for factor in (1.01, 0.99)
        ], keep=["wall_peak_force"], rtol=1e-9,
    )["wall_peak_force"]  # fmt: skip
    assert (larger[2], smaller[2]) == pytest.approx((up / nominal - 1.0, down / nominal - 1.0))
    assert larger[2] > 0.001
    assert smaller[2] > 0.05


def test_the_sensitivity_is_the_exact_gradient():
    chain = hc.Chain.tapered("forward-exponential", 0.05, beads=10).replace(right_wall=hc.Wall())
    problem = hc.Design(chain, minimise="wall_force.peak", vary=[hc.vary.radii(0.5, 1.0)])
    value, slope = hc.gradient(chain, "wall_force.peak")
    expected = slope["radii"] * chain.radii / value
    assert sensitivity(problem, chain)[1:] == pytest.approx(expected[1:], abs=1e-5)


@pytest.mark.long
def test_the_sensitivity_of_a_limited_force_is_plotted_for_the_shortest_chain():
    """The changes of a length are those of the radii, which nobody needs to see."""
    kinds = hc.vary.balls(materials="steel-52100", diameters=["4 mm", "5 mm", "6.35 mm"])
    chain = hc.Chain.from_materials(
        "3.175 mm", "steel-52100", beads=4, velocity=0.2, right_wall=hc.Wall.of("steel-52100")
    )
    limit = {"wall_force.peak": "<= 22 N"}
    found = hc.design(hc.Design(chain, minimise="length", vary=[kinds], subject_to=limit))
    axes = found.plot("sensitivity")
    assert axes.get_ylabel().startswith("peak force on the wall:")
    radii = found.chain.radii * np.r_[1.0, 1.0, 1.01, 1.0]
    before, after = (
        wall_peak(hc.Chain.from_materials(each, "steel-52100", velocity=0.2,
                                          right_wall=hc.Wall.of("steel-52100")), 3e-4)
        for each in (found.chain.radii, radii)
    )  # fmt: skip
    height = axes.containers[0][2].get_height()
    assert height == pytest.approx(100.0 * (after / before - 1.0), abs=1e-3)
    forces = found.plot("forces")
    assert "limit 22 N" in legend_texts(forces)


def test_the_sensitivity_of_a_largest_velocity_is_the_exact_gradient():
    chain = hc.Chain.from_materials("5 mm", "steel-52100", beads=8, velocity="0.1 m/s")
    problem = hc.Design(chain, maximise="largest_velocity@4", vary=[hc.vary.radii("4 mm", "6 mm")])
    value, slope = hc.gradient(chain, "bead.largest_velocity", bead=4)
    relative = slope["radii"] * chain.radii / value
    assert sensitivity(problem, chain) == pytest.approx(relative, abs=1e-5)
    larger, smaller = changes(problem, chain, 1e-3)
    assert larger == pytest.approx(1e-3 * relative, abs=1e-5)
    assert smaller == pytest.approx(-1e-3 * relative, abs=1e-5)


def test_the_spread_of_a_largest_velocity_follows_from_its_gradient():
    chain = hc.Chain.from_materials("5 mm", "steel-52100", beads=8, velocity="0.1 m/s")
    found = hc.distribution(chain, "largest_velocity@4", hc.Scatter(radius=1e-3, samples=400))
    value, slope = hc.gradient(chain, "bead.largest_velocity", bead=4)
    assert found.nominal == pytest.approx(value, rel=1e-6)
    expected = 1e-3 * np.linalg.norm(slope["radii"] * chain.radii)
    # The standard deviation of 400 samples has an error of 3.5%.
    assert found.standard_deviation == pytest.approx(expected, rel=0.12)
    with pytest.raises(hc.InputError, match="because waves return; use .* such as velocity@4"):
        hc.distribution(
            chain.replace(right_wall=hc.Wall()), "largest_velocity@4", hc.Scatter(radius=1e-3)
        )


@pytest.mark.parametrize(("samples", "expected"), [(19, ["median"]), (40, ["5%", "median", "95%"])])
def test_the_percentiles_that_values_determine_are_marked(samples, expected):
    chain = hc.Chain.uniform(6)
    found = hc.distribution(chain, "velocity@last", hc.Scatter(radius=0.01, samples=samples))
    axes = found.plot()
    lines = [line for line in axes.lines if line.get_linestyle() == ":"]
    places = [line.get_xdata()[0] for line in lines]
    below = [(found.values < place).mean() for place in places]
    parts = [0.5] if samples < 20 else [0.05, 0.5, 0.95]
    np.testing.assert_allclose(below, parts, atol=0.51 / samples)
    # The legend has their values.
    names, _, values = lines[0].get_label().partition(": ")
    assert names.split(", ") == expected
    assert [float(value) for value in values.split(", ")] == pytest.approx(places, rel=1e-3)
    axes.figure.draw_without_rendering()
    assert not covers_data(axes.get_legend())


def difference_quotient(chain, quantity, place):
    """Derivative by a radius, from runs of another integrator; the error is of fourth order."""
    radii, step = chain.radii, 1e-3 * chain.radii[place]
    near = []
    for k in (-2, -1, 1, 2):
        changed = chain.replace(radii=radii + k * step * np.eye(chain.beads)[place])
        near.append(quantity(hc.simulate(changed, times=0, rtol=1e-11)))
    return (near[0] - 8 * near[1] + 8 * near[2] - near[3]) / (12 * step)


@pytest.mark.long
@pytest.mark.parametrize("loss", [hc.Viscoelastic(0.05), hc.Restitution(0.9)])
def test_slopes_of_damped_chains_are_exact(loss):
    damped = hc.Chain.uniform(8).replace(right_wall=hc.Wall(), loss=loss)
    given = hc.Design(
        damped, minimise="wall_force.peak", vary=[hc.vary.radii(0.5, 1.0)],
        subject_to={"energy@5": "<= 0.4"},
    )  # fmt: skip
    assert covered(given)
    point = np.linspace(0.9, 0.2, 7)
    chain = given.space.chain_of(point)
    values, slopes, models = values_and_slopes(given, point)
    assert len(models) >= 1
    assert models[0, 1:] == pytest.approx(np.r_[values[0], slopes[0]])
    to_x = chain.radii[1:] * np.log(2.0)
    for row, quantity in enumerate(
        (lambda run: run.wall_force().peak, lambda run: run.pulse().energy[4])
    ):
        assert values[row] == pytest.approx(
            quantity(hc.simulate(chain, times=0, rtol=1e-11)), rel=1e-7
        )
        expected = np.array([difference_quotient(chain, quantity, k) for k in range(1, 8)]) * to_x
        assert slopes[row] == pytest.approx(expected, abs=2e-3 * np.abs(expected).max())


def test_descents_are_the_default_if_their_derivatives_are_exact():
    for chain, sizes, expected in (
        (WALLED, hc.vary.radii(0.5, 1.0), "gradient"),
        (WALLED, hc.vary.masses(0.1, 1.0), "gradient"),
        (WALLED, hc.vary.radii(0.2, 1.0), "hybrid"),
        (WALLED_40, hc.vary.radii(0.2, 1.0), "gradient"),
        (WALLED_700, hc.vary.radii(0.5, 1.0), "gradient"),
        (WALLED_700, hc.vary.radii(0.2, 1.0), "gradient"),
        (WALLED, hc.vary.gaps(0.0, 0.1), "hybrid"),
        (WALLED.replace(loss=hc.Restitution(0.9)), hc.vary.radii(0.5, 1.0), "gradient"),
        (WALLED.replace(loss=hc.Dashpot(0.1)), hc.vary.radii(0.5, 1.0), "hybrid"),
    ):
        given = hc.Design(chain, minimise="wall_force.peak", vary=[sizes])
        assert method_for(given, "auto", 1e4) == expected


def test_the_law_is_not_used_for_ratios():
    sizes = hc.vary.radii(0.5, 2.0, by="spline", knots=8)
    for measure, expected in (("velocity@36", "law"), ("velocity@36/velocity@10", "hybrid")):
        problem = hc.Design(hc.Chain.uniform(40), maximise=measure, vary=sizes)
        assert method_for(problem, "auto", 1e4) == expected
    with pytest.raises(hc.InputError, match=r"one quantity of the leading pulse \(no ratio\)"):
        method_for(problem, "law", 1e4)


def test_losses_without_derivatives_are_not_covered():
    for loss in (hc.Dashpot(0.1), hc.UnloadingRatio(0.2), hc.WaltonBraun(0.8)):
        chain = WALLED.replace(loss=loss)
        given = hc.Design(chain, minimise="wall_force.peak", vary=[hc.vary.radii(0.5, 1.0)])
        assert not covered(given)


@pytest.mark.long
def test_a_damped_design_needs_few_simulations():
    """Central differences need 2 * 9 + 1 simulations for the slopes at each point."""
    damped = WALLED.replace(loss=hc.Viscoelastic(0.05))
    problem = hc.Design(damped, minimise="wall_force.peak", vary=[hc.vary.radii(0.5, 1.0)])
    found = hc.design(problem, budget=300, method="gradient")
    assert found.gradients > 300 / 19
    best = min(found.objective_of(each) for each in found.references.values())
    assert found.value < 0.8 * best
    assert found.value == pytest.approx(wall_peak(found.chain, 40.0), rel=1e-6)


@pytest.mark.long
def test_a_later_and_larger_maximum_is_reported():
    """The first maximum of a velocity may be a small precursor."""
    problem = hc.Design(
        hc.Chain.uniform(14), minimise="velocity@11", vary=[hc.vary.radii(0.3, 3.0)]
    )
    found = hc.design(problem, budget=150, method="gradient")
    end = hc.simulate(found.chain, times=0).end_time
    speed = trajectory(found.chain, np.linspace(0.0, end, 20_001)).velocities[:, 10]
    falling = (np.diff(speed) < 0.0) & (speed[1:] > 1e-3)
    first = speed[np.flatnonzero(falling)[0]]
    assert found.value == pytest.approx(first, rel=1e-3)
    assert speed.max() > 1.1 * first
    (note,) = (each for each in found.notes if "moves faster later" in each)
    assert f"a first maximum of {found.value:.4g}," in note
    reached = float(re.search("reaches ([0-9.]+) in the run", note)[1])
    assert reached == pytest.approx(speed.max(), rel=1e-3)
    assert note in found.summary()
    # The pulse of equal beads has no precursor.
    verified = quietly(problem, problem.chain, np.nan, 0)
    assert verified.notes == ()


@pytest.mark.long
def test_the_largest_velocity_of_the_whole_run_can_be_minimised():
    """Unlike the first maximum, it cannot be evaded by a small precursor."""
    problem = hc.Design(
        hc.Chain.uniform(14), minimise="largest_velocity@11", vary=[hc.vary.radii(0.3, 3.0)]
    )
    found = hc.design(problem, budget=150, method="gradient")
    times = np.linspace(0.0, 80.0, 40_001)
    speed = trajectory(found.chain, times).velocities[:, 10]
    assert found.value == pytest.approx(speed.max(), rel=1e-5)
    assert not any("moves faster later" in note for note in found.notes)
    assert found.value < 0.7 * min(map(found.objective_of, found.references.values()))


def test_results_are_exported(softest, tmp_path):
    data = softest.to_xarray()
    assert float(data["wall_force_peak"].sel(design="result")) == softest.value
    assert data["radii"].sel(design="result").values == pytest.approx(softest.chain.radii)
    file = tmp_path / "found.toml"
    file.write_text(softest.to_toml())
    assert hc.load_chain(file).radii.tolist() == softest.chain.radii.tolist()
    assert softest.as_dict()["value"] == softest.value
    assert "optimal" not in softest.summary()
    assert "best of" in softest.summary()


@pytest.mark.long
def test_forces_that_differ_much_share_axes_and_the_small_one_is_enlarged_below():
    chain = hc.Chain.uniform(8).replace(right_wall=hc.Wall())
    problem = hc.Design(chain, minimise="wall_force.peak", vary=[hc.vary.radii(0.05, 1.0)])
    # Without references, the given chain is compared.
    result = dataclasses.replace(hc.design(problem, budget=200), references={})
    initial = hc.simulate(chain).wall_force().peak
    assert initial > 5.0 * result.value
    for figure, first in ((result.plot(), 1), (result.plot("forces").figure, 0)):
        both, design = figure.axes[first : first + 2]
        tops = [float(line.get_ydata().max()) for line in both.lines]
        assert tops == pytest.approx([initial, result.value], rel=1e-3)
        assert initial < both.get_ylim()[1] < 1.2 * initial
        (line,) = design.lines
        assert line.get_color() == both.lines[1].get_color()
        assert result.value < design.get_ylim()[1] < 1.2 * result.value
        assert design.get_title(loc="left").startswith("design: force axis enlarged ")
        # Both panels have the same times, which are below them.
        assert both.get_xlim() == design.get_xlim()
        assert [axes.get_xlabel() for axes in (both, design)] == ["", "time $t$"]
    assert len(result.plot("forces", ax=plt.figure().add_subplot()).lines) == 2


@pytest.mark.long
def test_figures_show_both_chains(softest):
    figure = softest.plot()
    assert [axes.get_xlabel() for axes in figure.axes] == [
        "position", "time $t$", "simulations", "bead $k$"
    ]  # fmt: skip
    lines = figure.axes[1].lines
    assert lines[1].get_ydata().max() == pytest.approx(softest.value, rel=1e-2)
    labels = legend_texts(figure.axes[1])
    assert labels[1] == f"design, peak {softest.value:.4g}"
    with pytest.raises(hc.InputError, match="ax takes one kind"):
        softest.plot(ax=figure.axes[0])


def test_figures_state_that_the_initial_chain_violates_constraints():
    steel = "steel-52100"
    chain = hc.Chain.from_materials(
        "10 mm", steel, beads=13, velocity="0.01 m/s", right_wall=hc.Wall.of(steel)
    )
    problem = hc.Design(
        chain, minimise="wall_force.peak", vary=[hc.vary.radii("5 mm", "10 mm", beads="2:")],
        subject_to={"length": "<= 180 mm", "mass": "<= 1 kg"},
    )  # fmt: skip
    result = dataclasses.replace(hc.design(problem, budget=100), references={})
    assert result.met
    figure = result.plot()
    texts = [text.get_text() for text in figure.axes[0].texts]
    assert "given chain \nviolates length " in texts
    assert "design " in texts
    initial, design = (text.get_text() for text in figure.axes[1].get_legend().get_texts())
    assert re.fullmatch(r"given chain, peak \S+ N,\s*violates length", initial)
    assert "violates" not in design
    bars = figure.axes[-1]
    assert bars.get_xlabel() == "bead $k$"
    assert bars.get_xlim()[1] < 14.0


def test_a_design_is_compared_with_the_best_chain_that_meets_the_constraints(softest):
    chains = shown_chains(softest)
    name, other = next(iter(chains.items()))
    best = min(softest.references, key=lambda each: softest.objective_of(softest.references[each]))
    assert name == f"best {best}"
    assert other is softest.references[best]
    assert softest.objective_of(other) < softest.objective_of(softest.problem.chain)
    axes = softest.plot("forces")
    labels = legend_texts(axes)
    assert labels[0] == f"{name}, peak {softest.objective_of(other):.4g}"
    words = " ".join(text.get_text() for text in softest.plot("beads").texts)
    assert name in " ".join(words.split())
    # The given chain is shown if it is better, or if no reference meets the constraints.
    values = {str(each): 10.0 * value for each, value in softest._initial.values.items()}
    worse = {best: dataclasses.replace(softest._initial, values=values)}
    for references in ({}, worse):
        result = dataclasses.replace(softest, references=references)
        assert [*shown_chains(result)] == ["given chain", "design"]


def test_figures_at_the_width_of_a_column_are_legible():
    diameters = ["6.35 mm", "5 mm", "4 mm", "8 mm", "3 mm", "8 mm", "5 mm", "3.5 mm"]
    chain = hc.Chain.from_materials(
        diameters=diameters, materials="steel-52100", velocity="0.1 m/s", right_wall=hc.Wall()
    )
    problem = hc.Design(chain, minimise="wall_force.peak", vary=[hc.vary.order(beads="2:")])
    result = hc.design(problem, budget=50, seed=1)
    with hc.figure_style("single column"):
        figure = result.plot()
    figure.draw_without_rendering()
    assert figure.get_figwidth() == pytest.approx(0.086 / 0.0254)
    beads, forces = figure.axes[:2]
    assert not covers_data(forces.get_legend())
    for axes in figure.axes:
        label = axes.yaxis.label
        assert not label.get_text() or label.get_window_extent().height < axes.bbox.height
    # Each diameter is below its bead, and none is on another.
    texts = [text for text in beads.texts if re.fullmatch(r"[\d.]+", text.get_text())]
    assert [float(text.get_text()) for text in texts] == pytest.approx(2e3 * result.chain.radii)
    centres = np.cumsum(2e3 * result.chain.radii) - 1e3 * result.chain.radii
    assert [text.get_position()[0] for text in texts] == pytest.approx(centres)
    boxes = [text.get_window_extent() for text in texts]
    assert not any(one.overlaps(other) for one, other in itertools.pairwise(boxes))
    assert all(box.y0 >= beads.bbox.y0 for box in boxes)


@pytest.mark.long
def test_long_labels_of_narrow_figures_cover_no_data():
    """Several violated constraints, and values outside the range of the law of yield."""
    chain = hc.Chain.from_materials(
        "3.175 mm", "steel-52100", beads=9, velocity="10 m/s", right_wall=hc.Wall.of("steel-52100")
    )
    limits = {
        "length": "<= 30 mm", "mass": "<= 1 g", "yield_ratio": "<= 1", "overlap_ratio": "<= 0.01",
        "wall_force.peak": "<= 3 N",
    }  # fmt: skip
    balls = hc.vary.balls("bearing-balls", beads="2:", optional=True)
    problem = hc.Design(chain, minimise="wall_force.peak", vary=[balls], subject_to=limits)
    result = hc.design(problem, budget=150)
    for width in ("single column", "120 mm", "double column"):
        with hc.figure_style(width):
            figure, alone = result.plot(), result.plot("forces")
        for axes in (figure.axes[1], alone):
            axes.figure.draw_without_rendering()
            legend = axes.get_legend()
            assert "violates 5 constraints" in legend.get_texts()[0].get_text()
            assert "outside the range" in legend.get_texts()[1].get_text()
            assert not covers_data(legend)
            assert legend.get_window_extent().x1 <= axes.figure.bbox.x1


def test_forces_of_both_chains_end_at_the_same_time_and_do_not_end_rising():
    diameters = ["20 mm"] * 4 + ["15 mm"] * 3 + ["10 mm"] * 3
    chain = hc.Chain.from_materials(
        diameters=diameters, materials="steel-52100", velocity="0.1 m/s", right_wall=hc.Wall()
    )
    problem = hc.Design(chain, minimise="wall_force.peak", vary=[hc.vary.order(beads="2:")])
    result = hc.design(problem, budget=50, seed=1)
    ends = [hc.simulate(each).end_time for each in (chain, result.chain)]
    initial, design = result.plot("forces").lines
    for line, each in ((initial, chain), (design, result.chain)):
        assert 0.8e6 * max(ends) < line.get_xdata()[-1] <= 1.001e6 * max(ends)
        peak = hc.simulate(each).wall_force().peak
        assert line.get_ydata().max() == pytest.approx(peak, rel=1e-3)
        assert line.get_ydata()[-1] < 0.01 * peak


def test_changes_that_mirror_each_other_are_drawn_once(softest, monkeypatch):
    larger = np.array([0.02, -0.01, 0.005])
    for smaller, bars in ((-1.01 * larger, 3), (np.abs(larger), 6)):
        monkeypatch.setitem(softest.__dict__, "changes", (larger, smaller))
        axes = softest.plot("sensitivity")
        heights = [bar.get_height() for bar in axes.patches]
        assert heights == pytest.approx([*(100.0 * larger), *(100.0 * smaller)][:bars])
        assert ("+1%" in axes.get_ylabel()) == (bars == 3)


@pytest.mark.long
def test_any_chain_can_be_evaluated(softest):
    taper = hc.Chain.tapered("forward-linear", 0.03, beads=12).replace(right_wall=hc.Wall())
    peak = wall_peak(taper, 40.0)
    assert softest.objective_of(taper) == pytest.approx(peak, rel=1e-7)
    values = softest.problem.evaluate(taper).values
    assert values == {"wall_force.peak": softest.objective_of(taper)}
    assert softest.objective_of(softest.chain) == softest.value


@pytest.mark.parametrize(
    ("chain", "words"),
    [
        (hc.Chain.uniform(10), "wall"),
        (STEEL, "in SI units, and that of the problem in scaled"),
        ([1.0, 1.0], "chain"),
    ],
)
def test_chains_without_the_measure_are_not_evaluated(softest, chain, words):
    with pytest.raises(hc.InputError, match=words):
        softest.problem.evaluate(chain)


def test_a_bead_that_does_not_exist_is_not_evaluated():
    problem = hc.Design(WALLED, maximise="velocity@9", vary=[hc.vary.radii(0.5, 1.0)])
    with pytest.raises(hc.InputError, match="8"):
        problem.evaluate(hc.Chain.uniform(8))


def test_the_shipped_catalogue_has_known_sizes():
    found = load_balls("bearing-balls")
    # Balls per kg of steel in a maker's table (Technoball): 30500 of 2 mm, 119 of 12.7 mm.
    # A ball of 2 in weighs 1.18 lb or 535 g in tables of makers.
    for diameter, per_kg in ((2e-3, 30500), (12.7e-3, 119), (50.8e-3, 1 / 0.535)):
        ball = next(b for b in found if b.diameter == diameter and b.material.name == "steel-52100")
        mass = ball.material.density * np.pi / 6 * ball.diameter**3
        assert 1 / mass == pytest.approx(per_kg, rel=0.02)
    large = sorted({ball.diameter for ball in found if ball.diameter > 0.0254})
    names = "28.575 30 30.1625 31.75 33.3375 34.925 36.5125 38.1 41.275 44.45 50.8"
    assert large == pytest.approx([1e-3 * float(name) for name in names.split()], rel=1e-9)


@pytest.mark.parametrize(
    ("chosen", "told"),
    [
        ({"diameters": ["8.2 mm", "4 mm"]},
         "8.2 mm is not among the balls in the catalogue 'bearing-balls'; the nearest is 8 mm"),
        ({"diameters": ["4 mm", "5 mm", "9.525 mm"], "materials": "ptfe"},
         "4 mm, 5 mm are not among the balls of ptfe in .*; the nearest are 3.9688 mm, 4.7625 mm"),
        ({"materials": ["steel-304", "brass"]},
         "no balls of brass; it has steel-52100, steel-304.*'balls.csv'"),
        ({"materials": ["steel-52100", "ptfe"], "diameters": ["5 mm", "10 mm"]},
         "no ball of ptfe in .* has one of these diameters; the nearest are 4.7625 mm, 10.3188 mm"),
    ],
)  # fmt: skip
def test_balls_that_the_catalogue_does_not_have_are_reported(chosen, told):
    with pytest.raises(hc.InputError, match=told):
        hc.vary.balls(**chosen).space(hc.Chain.from_materials(5e-3, "steel-304", beads=4))


def test_a_size_that_one_of_the_materials_has_is_known():
    found = hc.vary.balls(materials=["steel-304", "ptfe"], diameters=["4 mm", "4.762 mm"]).balls
    assert [(1e3 * each.diameter, each.material.name) for each in found] == [
        (4.0, "steel-304"), (4.7625, "steel-304"), (4.7625, "ptfe")
    ]  # fmt: skip


def test_prices_come_from_a_catalogue_of_the_user(tmp_path):
    file = tmp_path / "balls.csv"
    file.write_text("diameter [mm],material,price\n4,steel-304,1.5\n5,ptfe,0.25\n")
    problem = hc.Design(
        STEEL, minimise="wall_force.peak", vary=[hc.vary.balls(file)],
        subject_to={"price": "<= 3"},
    )  # fmt: skip
    found = hc.design(problem, budget=64)
    assert found.met
    # Only one ball of steel is affordable.
    assert sum(material.name == "steel-304" for material in found.chain.materials[1:]) <= 1
    assert found.values["price"] <= 3.0
    counts = [count for count, _ in found.parts]
    assert np.dot(counts, found.part_prices) == pytest.approx(found.values["price"])
    text = found.summary()
    for (count, ball), price in zip(found.parts, found.part_prices, strict=True):
        assert f"  {count} x {ball}: {count * price:g} ({price:g} each)\n" in text
    assert f"  price of all: {found.values['price']:g}\n" in text
    assert "price of one" in found._repr_html_()
    assert ">order: " in found._repr_html_()
    assert [part["price"] for part in found.as_dict()["parts"]] == list(found.part_prices)


def test_a_budget_without_a_search_is_reported():
    problem = hc.Design(
        hc.Chain.uniform(12), maximise="energy_share@8", vary=[hc.vary.radii(0.5, 1.5)]
    )
    found = hc.design(problem, budget=83, method="gradient")
    assert found.runs <= 83
    assert "no search was completed: the budget was used up" in found.summary()


def test_limits_of_the_model_are_stated_once_for_the_result(recwarn):
    """Not once per trial: every chain of this search exceeds the yield pressure."""
    chain = hc.Chain.from_materials("4 mm", "steel-52100", beads=6, velocity="1 m/s")
    chain = chain.replace(right_wall=hc.Wall(), loss=hc.Restitution(0.95))
    vary = [hc.vary.radii("3 mm", "6 mm")]
    problem = hc.Design(chain, minimise="wall_force.peak", vary=vary)
    result = hc.design(problem, budget=100, method="evolution", threads=1)
    assert not recwarn.list
    assert result.summary().count("pressure / yield") == 1


@pytest.mark.parametrize(
    ("diameter", "inch"),
    [(7.1438e-3, "9/32"), (6.35e-3, "1/4"), (25.4e-3, "1"), (38.1e-3, "1 1/2"), (4e-3, ""),
     (8e-3, ""), (6.351e-3, "")],
)  # fmt: skip
def test_sizes_in_inches_are_stated(diameter, inch):
    ball = Ball(diameter, hc.material("steel-52100"))
    assert f"({inch} in)" in str(ball) if inch else "in" not in str(ball)


WALLED_STEEL = hc.Chain.from_materials("5 mm", "steel-52100", beads=6, velocity="0.1 m/s").replace(
    right_wall=hc.Wall()
)


@pytest.mark.parametrize("limit", ["<= 100", "< 0.1", ">= 1e-2"])
def test_limits_without_a_unit_are_rejected(limit):
    vary = [hc.vary.radii("3 mm", "5 mm")]
    with pytest.raises(hc.InputError, match=f"length needs a unit, such as '{limit} mm'"):
        hc.Design(WALLED_STEEL, minimise="wall_force.peak", vary=vary, subject_to={"length": limit})


def test_strict_and_weak_limits_are_the_same():
    problems = [
        hc.Design(
            WALLED_STEEL, minimise="wall_force.peak", vary=[hc.vary.radii("3 mm", "5 mm")],
            subject_to={"length": f"{sign} 50 mm"},
        )
        for sign in ("<", "<=")
    ]  # fmt: skip
    strict, weak = (problem.requirements for problem in problems)
    assert strict == weak
    with pytest.raises(hc.InputError, match="got '== 50 mm'.*'<= 50 mm', '>= 50 mm'"):
        hc.Design(
            WALLED_STEEL,
            minimise="wall_force.peak",
            vary=[hc.vary.radii("3 mm", "5 mm")],
            subject_to={"length": "== 50 mm"},
        )


@pytest.mark.long
def test_a_design_with_all_choices_states_the_search_and_units_of_scatter():
    scatter = hc.Scatter(radius=0.001, samples=4)
    problem = hc.Design(
        WALLED_STEEL, minimise="wall_force.peak", scatter=scatter,
        vary=[hc.vary.balls("bearing-balls", diameters=["5 mm", "6 mm"], beads="5:")],
    )  # fmt: skip
    result = hc.design(problem, method="enumerate", seed=1)
    count = int(problem.space.count)
    assert f"best of all {count} simulated choices" in repr(result)
    lines = [line for line in result.summary().splitlines() if "with scatter" in line]
    assert len(lines) == 1
    shown = re.fullmatch(r".*wall_force.peak mean (\S+) N, CVaR90 (\S+) N, worst (\S+) N", lines[0])
    values = [result.verified.scattered[f"{kind} of wall_force.peak"]
              for kind in ("mean", "CVaR90", "worst")]  # fmt: skip
    # The values differ in the fourth digit, and have enough digits to see by how much.
    assert float(shown[3]) - float(shown[1]) == pytest.approx(values[2] - values[0], rel=0.01)
    assert list(map(float, shown.groups())) == pytest.approx(values, rel=1e-4)


def test_a_design_without_a_trial_that_meets_the_constraints_is_drawn():
    problem = hc.Design(
        WALLED_STEEL, minimise="wall_force.peak", subject_to={"wall_force.peak": "<= 1 mN"},
        vary=[hc.vary.balls("bearing-balls", materials=["steel-52100"],
                            diameters=["5 mm", "6 mm"], beads="5:")],
    )  # fmt: skip
    result = hc.design(problem, method="enumerate")
    assert not result.met
    # The forces of other trials that violate the constraints are not compared.
    assert "median" not in hc.design(problem, method="genetic", budget=60).summary()
    texts = [text.get_text() for axes in result.plot().axes for text in axes.texts]
    assert "no trial met the constraints" in texts
    heading, unmet, given, *others = result.summary().splitlines()
    assert "the closest one has a wall_force.peak of " in heading
    own = 1e3 * hc.simulate(WALLED_STEEL, rtol=1e-10).wall_force().peak
    shown = re.fullmatch(
        r"  not met: wall_force.peak <= 1 mN \((\S+) mN; (\S+) mN in the given chain\)", unmet
    )
    values = [1e3 * result.value, own]
    assert list(map(float, shown.groups())) == pytest.approx(values, rel=1e-3)
    assert re.fullmatch(r"  the given chain has a wall_force.peak of \S+ N", given)
    parts = "parts of the row that comes closest (limits NOT met), without the arriving ball:"
    assert parts in others


@pytest.mark.long
@pytest.mark.parametrize("seed", [0, 1])
def test_gaps_of_balls_can_vary_by_the_usual_method(seed):
    row = hc.Chain.from_materials(
        diameters="6.35 mm", materials="steel-52100", beads=5, velocity="0.2 m/s",
        right_wall=hc.Wall.of("steel-52100"),
    )  # fmt: skip
    problem = hc.Design(row, minimise="wall_force.peak", vary=[hc.vary.gaps("0 um", "20 um")])
    found = hc.design(problem, budget=600, seed=seed)
    assert found.verified.values["wall_force.peak"] <= 1.0001 * hc.simulate(row).wall_force().peak


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
def test_a_larger_force_after_the_first_maximum_is_a_note():
    # A small ball before the sensor makes a weak precursor of the pulse.
    row = hc.Chain.from_materials(
        diameters=["10 mm", *["6 mm"] * 5], materials="steel-52100", velocity="0.1 m/s",
        right_wall=hc.Wall.of("steel-52100"),
    )  # fmt: skip
    sizes = hc.vary.radii("1.5 mm", "5 mm", beads="2:")
    found = hc.design(hc.Design(row, minimise="sensor.first_maximum@5", vary=[sizes]), budget=600)
    force = hc.simulate(found.chain).sensor_force(5)
    assert force.largest_so_far > 1.01 * force.first_maximum
    (note,) = (each for each in found.notes if "first maximum of the force" in each)
    assert f"{force.largest_so_far / force.first_maximum:.2g}" in note
    assert "sensor.largest@5" in note
    # The largest force of a design for it is below that of the best chain of equal sizes.
    largest = hc.design(hc.Design(row, minimise="sensor.largest@5", vary=[sizes]), budget=600)
    assert largest.value < largest.objective_of(found.references["chain of equal sizes"].chain)
    assert largest.value < force.largest_so_far
    assert hc.simulate(largest.chain, times=4000).sensor_force(5).largest_so_far == pytest.approx(
        largest.value, rel=1e-6
    )
    assert not [each for each in largest.notes if "sensor" in each]


@pytest.mark.parametrize("wall", [None, hc.Wall()])
@pytest.mark.parametrize("loss", [None, hc.Restitution(0.9)])
def test_slopes_of_the_largest_force_in_a_sensor_are_exact(wall, loss):
    chain = hc.Chain.uniform(8).replace(right_wall=wall, loss=loss)
    objective = {"sensor.largest@4": 1.0, "velocity@3": 1.0}
    given = hc.Design(chain, minimise=objective, vary=[hc.vary.radii(0.5, 1.0)])
    assert covered(given)
    point = np.linspace(0.9, 0.2, 7)
    chain = given.space.chain_of(point)
    values, slopes, _ = values_and_slopes(given, point)

    def largest(chain):
        run = hc.simulate(chain, times=4000, rtol=1e-11)
        return run.sensor_force(4).largest_so_far

    assert values[0] == pytest.approx(largest(chain), rel=1e-6)
    for place in (2, 5):
        radii, step = chain.radii, 1e-3 * chain.radii[place]
        up, down = (
            largest(chain.replace(radii=radii + sign * step * np.eye(8)[place]))
            for sign in (1.0, -1.0)
        )
        expected = (up - down) / (2.0 * step) * chain.radii[place] * np.log(2.0)
        assert slopes[0, place - 1] == pytest.approx(expected, rel=2e-3, abs=1e-5)


@pytest.mark.long
def test_summaries_list_the_sizes_that_varied():
    chain = hc.Chain.uniform(30).replace(right_wall=hc.Wall())
    vary = [hc.vary.radii(0.5, 1.0, beads="2:4"), hc.vary.gaps(0.0, 0.1, by="common")]
    found = hc.design(hc.Design(chain, minimise="wall_force.peak", vary=vary), budget=400)
    sizes, gaps = (line for line in found.summary().splitlines() if "from the struck end" in line)
    radii = [f"{value:.4g}" for value in found.chain.radii]
    assert sizes.startswith(f"radii, from the struck end: {radii[0]}, {radii[1]}")
    assert sizes.endswith("26 x 1")
    assert gaps == f"gaps, from the struck end: 29 x {found.chain.gaps[0]:.4g}"
    steel = hc.Chain.from_materials(10e-3, "steel-52100", beads=30, velocity=0.1)
    vary = [hc.vary.radii("5 mm", "10 mm", beads="2:")]
    found = hc.design(hc.Design(steel, minimise="velocity@last", vary=vary), budget=400)
    (sizes,) = (line for line in found.summary().splitlines() if "from the struck end" in line)
    head, _, listed = sizes.partition(": ")
    assert head == "diameters [mm], from the struck end"
    assert listed.split(", ")[0].endswith("20")
    assert len(listed.split(", ")) <= 13


def test_a_runner_up_that_is_better_with_yield_is_named():
    chain = hc.Chain.from_materials("10 mm", "steel-52100", beads=7, velocity="1 m/s").replace(
        right_wall=hc.Wall()
    )
    balls = hc.vary.balls(diameters=["5 mm", "10 mm", "16 mm", "20 mm"], materials="steel-52100")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = hc.design(hc.Design(chain, minimise="wall_force.peak", vary=[balls]), budget=500)
    by_yield = [each.yielding["wall_force.peak"] for each in (found.verified, *found.runners_up)]
    order = sorted(range(5), key=by_yield.__getitem__)
    swapped = dataclasses.replace(
        found, verified=[found.verified, *found.runners_up][order[1]],
        runners_up=tuple([found.verified, *found.runners_up][i] for i in (order[0], *order[2:])),
    )  # fmt: skip
    line = f"runner-up 1, which is worse with elastic contacts, has {by_yield[order[0]]:.4g} N"
    assert line in swapped.summary()
    entry = swapped.as_dict()["better_if_yielding"]
    assert entry["runner_up"] == 1
    assert entry["value_with_yielding_contacts"] == by_yield[order[0]]
    assert entry["radii"] == swapped.runners_up[0].chain.radii.tolist()
    best = dataclasses.replace(
        found, verified=[found.verified, *found.runners_up][order[0]],
        runners_up=tuple([found.verified, *found.runners_up][i] for i in order[1:]),
    )  # fmt: skip
    assert "runner-up" not in best.summary()
    assert best.as_dict()["better_if_yielding"] is None


def test_diameters_are_twice_the_radii():
    assert hc.vary.diameters("5 mm", "25 mm", beads="3:") == hc.vary.radii(
        "2.5 mm", "12.5 mm", beads="3:"
    )
    assert hc.vary.diameters(0.005, "1 in") == hc.vary.radii(0.0025, "0.5 in")


def test_limits_below_zero_cannot_be_met():
    problem = hc.Design(
        WALLED, minimise="length", vary=[hc.vary.radii(0.5, 1.0)],
        subject_to={"wall_force.peak": "<= -3"},
    )  # fmt: skip
    found = hc.design(problem, budget=200)
    assert found.method == "none"
    assert "wall_force.peak is never negative" in "".join(found.notes)


def without_value(monkeypatch, row):
    """Let one chain of a distribution, the first of which has no deviations, have no value."""
    module = importlib.import_module("hertzchain.designs.distribution")
    simulate_all = module.measured

    def incomplete(*arguments, **options):
        found = simulate_all(*arguments, **options)
        values = found.values.copy()
        values[row] = np.nan
        return found._replace(values=values)

    monkeypatch.setattr(module, "measured", incomplete)


def test_scattered_chains_without_a_value_have_a_reason(monkeypatch):
    found = hc.distribution(WALLED, "wall_force.peak", hc.Scatter(radius=0.01, samples=20))
    assert (found.failed, found.reason) == (0, "")
    without_value(monkeypatch, 3)
    found = hc.distribution(WALLED, "wall_force.peak", hc.Scatter(radius=0.01, samples=20))
    assert found.failed == 1
    assert found.reason == "wall_force.peak is not complete at the end of the run"


def test_a_distribution_needs_a_value_of_the_chain_itself(monkeypatch):
    without_value(monkeypatch, 0)
    said = r"the chain without deviations has no wall_force\.peak: .* is not complete"
    with pytest.raises(hc.SimulationError, match=said):
        hc.distribution(WALLED, "wall_force.peak", hc.Scatter(radius=0.01, samples=20))


@pytest.mark.parametrize(
    "given",
    [
        {"minimise": {"velocity@5": 1.0, "wall_force.peak": -2.0}},
        {"minimise": "velocity@5", "subject_to": {"wall_force.peak": ">= 0.5"}},
        {"minimise": {"velocity@5": 1.0, "wall_force.peak": 0.0},
         "subject_to": {"wall_force.peak": ">= 0.5"}},
    ],
)  # fmt: skip
def test_search_and_verification_average_the_same_end_of_the_samples(given):
    """Small forces are bad in these problems."""
    scatter = hc.Scatter(radius=0.02, measure="cvar80", samples=10)
    problem = hc.Design(WALLED, vary=[hc.vary.radii(0.5, 1.0)], scatter=scatter, **given)
    trials = Trials(problem, budget_from(100), Journal(None, ""), seed=3)
    radii = WALLED.radii * np.exp(0.02 * scatter._draws(3, 10)[..., 0])
    chains = [WALLED.replace(radii=row) for row in radii]
    peaks = np.sort(hc.simulate_many(chains, keep=["wall_peak_force"])["wall_peak_force"])
    outcome = trials.evaluate([problem.space.point(WALLED)])[0]
    where = trials.position[problem.measures[-1]]
    assert problem.measures[-1].key == "wall_force.peak"
    assert outcome.values[where] == pytest.approx(peaks[:2].mean(), rel=1e-6)
    sampled = verify_chain(problem, WALLED, np.nan, 0).scattered
    assert sampled["worst of wall_force.peak"] < sampled["mean of wall_force.peak"]


def test_limits_in_both_directions_need_the_mean_of_a_scatter():
    given = {
        "minimise": "velocity@5", "vary": [hc.vary.radii(0.5, 1.0)],
        "subject_to": {"wall_force.peak": ["<= 1.5", ">= 0.5"]},
    }  # fmt: skip
    said = "large and small values of wall_force.peak are both bad here, but CVaR90 is the mean of"
    with pytest.raises(hc.InputError, match=said):
        hc.Design(WALLED, scatter=hc.Scatter(radius=0.02), **given)
    hc.Design(WALLED, scatter=hc.Scatter(radius=0.02, measure="mean"), **given)
    hc.Design(WALLED, **given)


@pytest.mark.long
def test_a_material_that_constraints_exclude_does_not_hide_rows_without_it():
    """PTFE yields at once, so the best row is nearly that of a search among steel balls."""
    chain = hc.Chain.from_materials(
        "4 mm", "steel-52100", beads=10, right_wall=hc.Wall("5 kN/mm", exponent=1)
    ).struck_by(mass="30 g", velocity="0.2 m/s")
    limits = {"length": ["<= 80 mm", ">= 76 mm"], "yield_ratio": "<= 1"}
    sizes = ["6.35 mm", "7.9375 mm", "9.525 mm", "11.1125 mm"]
    values = []
    for materials in (["steel-52100"], ["steel-52100", "ptfe"]):
        balls = hc.vary.balls(materials=materials, diameters=sizes, beads="2:", optional=True)
        problem = hc.Design(chain, minimise="wall_force.peak", vary=[balls], subject_to=limits)
        values.append(hc.design(problem, budget=1000, method="genetic").value)
    assert values[1] <= 1.02 * values[0]
