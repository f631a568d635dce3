"""The limit of the overlap / radius that every search has, unless it cannot be exceeded."""

import dataclasses
import re

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.designs.default_limits import largest_overlap_bound
from hertzchain.designs.exact_gradients import covered, values_and_slopes
from hertzchain.designs.overlap_slopes import overlap_ratio_and_slopes
from hertzchain.errors import SimulationError

pytestmark = pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
LIMIT = ["overlap_ratio <= 0.1"]


def row(material, speed=1.0, beads=5):
    return hc.Chain.from_materials(
        diameters="10 mm", materials=material, beads=beads, velocity=speed,
        right_wall=hc.Wall.of("steel-52100"),
    )  # fmt: skip


def of_sizes(material, speed=1.0, low="4 mm", **options):
    vary = [hc.vary.radii(low, "8 mm", beads="2:")]
    chain = row(material, speed)
    return hc.Design(chain, **{"minimise": "wall_force.peak", "vary": vary} | options)


def limits_of(problem):
    return [str(each) for each in problem.requirements]


def of_balls(materials, speed=1.0, beads=4, **options):
    balls = hc.vary.balls(materials=materials, diameters=["6.35 mm", "12.7 mm"], beads="2:")
    return hc.Design(
        row("steel-52100", speed, beads), minimise="wall_force.peak", vary=[balls], **options
    )


def test_only_searches_that_can_leave_the_range_of_the_law_are_limited():
    assert limits_of(of_sizes("rubber")) == limits_of(of_balls(["steel-52100", "rubber"])) == LIMIT
    assert limits_of(of_sizes("steel-52100")) == limits_of(of_balls(["steel-52100"])) == []
    assert limits_of(of_sizes("steel-52100", speed=200.0)) == LIMIT
    lifted = of_sizes("rubber", subject_to={"overlap_ratio": "<= 10"})
    assert limits_of(lifted) == ["overlap_ratio <= 10"]


@pytest.mark.parametrize("material", ["steel-52100", "ptfe", "rubber"])
@pytest.mark.parametrize("seed", range(4))
def test_the_bound_exceeds_the_overlaps_of_random_rows(material, seed):
    problem = of_sizes(material, speed=0.1)
    bound = largest_overlap_bound(problem.space)
    chain = problem.space.chain_of(np.random.default_rng(seed).random(4))
    run = hc.simulate(chain)
    largest = hc.hertz_range(run.chain, run.largest_overlaps).overlap_ratio.max()
    assert 0.05 * bound < largest < bound


def test_the_bound_is_that_of_a_ball_that_gives_all_its_energy_to_one_contact():
    """m v^2/2 = 2/5 k d^(5/2) with two of the smallest balls."""
    problem = of_sizes("steel-52100", vary=[hc.vary.radii("4 mm", "5 mm")])
    pair = hc.Chain.from_materials(diameters="8 mm", materials="steel-52100", beads=2)
    heavy = row("steel-52100").masses[0]
    overlap = (1.25 * heavy / pair.stiffness[0]) ** 0.4
    assert largest_overlap_bound(problem.space) == pytest.approx(overlap / 2e-3, rel=1e-9)


@pytest.mark.parametrize(
    "change",
    [
        {"gravity": 9.81},
        {"stiffness": [1e9] * 4},
        {"precompression": 1.0, "left_wall": hc.Wall.of("steel-52100")},
    ],
)
def test_there_is_no_bound_with_other_forces_or_given_contacts(change):
    problem = of_sizes("steel-52100", until=1e-3)
    chain = row("steel-52100").replace(**change)
    space = dataclasses.replace(problem.space, chain=chain)
    assert np.isinf(largest_overlap_bound(space))


def test_the_best_row_of_balls_is_one_of_those_within_the_range():
    found = hc.design(of_balls(["steel-52100", "rubber"], speed=0.5), budget=400)
    assert found.values["overlap_ratio"] <= 0.1
    assert found.met
    free = of_balls(["steel-52100", "rubber"], speed=0.5, subject_to={"overlap_ratio": "<= 10"})
    soft = hc.design(free, budget=400)
    assert soft.values["overlap_ratio"] > 0.1
    assert soft.value < found.value
    assert "outside the range of Hertz's law" in soft.summary().splitlines()[0]
    assert "no force is predicted beyond it; to lift it, give a limit" in found.summary()


def test_a_search_without_a_row_in_the_range_says_so():
    found = hc.design(of_balls(["rubber"], speed=2.0), budget=100)
    assert not found.met
    assert re.match(
        r"No chain was found within the range of Hertz's law \(overlap_ratio <= 0\.1\); the "
        r"closest one has 0\.\d+ \(wall_force\.peak: \S+ N\)",
        found.summary(),
    )


@pytest.mark.parametrize(
    ("radii", "contact"), [([5, 6, 8, 9, 9], 1), ([9, 6, 4, 9, 9], 2), ([5, 4.5, 5, 6, 8], 2),
                           ([8, 7, 6, 5, 4], 4), ([9, 9, 9, 9, 4], 5)],
)  # fmt: skip
def test_slopes_of_the_overlap_are_those_of_differences(radii, contact):
    gel = hc.Material("gel", density=1000.0, young=1e6, poisson=0.4)
    wall = hc.Wall.of(gel if contact == 5 else "steel-52100")
    chain = row("rubber", 0.2).replace(radii=[1e-3 * r for r in radii], right_wall=wall)

    def value(moved):
        run = hc.simulate(chain.replace(radii=moved), rtol=1e-12)
        ratios = hc.hertz_range(run.chain, run.largest_overlaps).overlap_ratio
        return np.nan_to_num(ratios).max(), np.nan_to_num(ratios).argmax()

    own, place = value(chain.radii)
    found, slopes = overlap_ratio_and_slopes(chain, ("radii",), 0.0, 1e-10, None)
    assert found == pytest.approx(own, rel=1e-7)
    assert place == contact
    for bead in range(5):
        step = 1e-4 * chain.radii * (np.arange(5) == bead)
        difference = (value(chain.radii + step)[0] - value(chain.radii - step)[0]) / (
            2.0 * step[bead]
        )
        assert slopes["radii"][bead] == pytest.approx(difference, rel=1e-4, abs=1e-4 * own / 5e-3)


def test_far_below_the_limit_slopes_are_not_needed():
    chain = row("rubber", 0.01)
    value, slopes = overlap_ratio_and_slopes(chain, ("radii",), 0.1, 1e-9, None)
    assert 0.0 < value < 0.05
    assert not slopes["radii"].any()


def test_a_largest_overlap_behind_the_leading_pulse_has_no_exact_slopes():
    """A light ball is squeezed most when the heavy striker follows."""
    chain = row("rubber", 0.2).replace(radii=[5e-3, 3e-3, 9e-3, 9e-3, 9e-3])
    with pytest.raises(SimulationError, match="not that of the leading pulse"):
        overlap_ratio_and_slopes(chain, ("radii",), 0.0, 1e-9, None)


def test_descents_with_the_limit_have_exact_gradients():
    problem = of_sizes("rubber", speed=0.5)
    assert limits_of(problem) == LIMIT
    assert covered(problem)
    point = problem.space.taper(0.9, 0.8)
    values, slopes, _ = values_and_slopes(problem, point)
    assert values.shape == (2,)
    assert slopes.shape == (2, 4)
    found = hc.design(problem, budget=400, method="gradient", seed=1)
    assert found.gradients > 0
    assert found.values["overlap_ratio"] <= 0.1 * (1 + 1e-6)
    # A measure that is the objective itself needs its value everywhere.
    assert not covered(of_sizes("rubber", speed=0.5, minimise="overlap_ratio"))
