"""Designs with balls of which only limited numbers are in stock."""

import itertools

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.designs import stock
from hertzchain.designs.ball_space import BallSpace

STEEL = hc.Chain.from_materials(
    "2 mm", "steel-304", beads=6, velocity=0.1, right_wall=hc.Wall.of("steel-304")
)
IN_STOCK = "diameter [mm],material,count\n4,steel-304,2\n5,steel-304,1\n6,steel-304,\n"


@pytest.fixture
def drawer(tmp_path):
    """A catalogue of two small balls, a middle one, and any number of large ones."""
    file = tmp_path / "drawer.csv"
    file.write_text(IN_STOCK)
    return file


def all_rows(limits, size, *, optional):
    """All rows, from all tuples of balls and empty places."""
    kinds = len(limits)
    found = []
    for row in itertools.product(range(kinds + optional), repeat=size):
        empty = [item == kinds for item in row]
        if sorted(empty) == empty and all(row.count(i) <= limits[i] for i in range(kinds)):
            found.append(list(row))
    return found


@pytest.mark.parametrize("optional", [False, True])
@pytest.mark.parametrize("limits", [(2, 1, 4), (0, 3), (4, 4, 4), (1, 1, 1, 1)])
def test_rows_are_those_that_the_stock_permits(limits, optional):
    expected = all_rows(limits, 4, optional=optional)
    lengths = range(0 if optional else 4, 5)
    assert [row.tolist() for row in stock.all_rows(limits, 4, optional=optional)] == expected
    assert stock.count_rows(limits, lengths) == len(expected)


@pytest.mark.parametrize("optional", [False, True])
def test_balls_that_are_missing_are_replaced(optional):
    rng, limits = np.random.default_rng(1), (2, 1, 3)
    seen = set()
    for _ in range(200):
        row = rng.integers(0, len(limits) + optional, 6)
        found = stock.repaired(limits, row, rng, optional=optional)
        assert stock.within(limits, found)
        counts = np.bincount(row, minlength=4)
        kept = np.isin(row, np.flatnonzero(counts <= [*limits, 6]))
        assert (found[kept] == row[kept]).all()
        seen.add(found.tobytes())
    assert len(seen) > 30


@pytest.mark.filterwarnings("ignore::hertzchain.errors.ModelRangeWarning")
@pytest.mark.parametrize("optional", [False, True])
def test_the_best_design_is_that_of_all_rows_in_stock(drawer, optional):
    balls = hc.vary.balls(drawer, optional=optional)
    problem = hc.Design(STEEL, minimise="wall_force.peak", vary=[balls])
    assert isinstance(problem.space, BallSpace)
    found = hc.design(problem, budget=500)
    rows = all_rows((2, 1, 5), 5, optional=optional)
    radii = [[2e-3, *([2e-3, 2.5e-3, 3e-3][i] for i in row if i < 3)] for row in rows]
    chains = [
        hc.Chain.from_materials(each, "steel-304", velocity=0.1, right_wall=STEEL.right_wall)
        for each in radii if len(each) > 1
    ]  # fmt: skip
    table = hc.simulate_many(chains, keep=["wall_peak_force"])
    # The arriving ball alone cannot be simulated.
    assert problem.space.count == len(chains)
    assert found.value == pytest.approx(table["wall_peak_force"].min(), rel=1e-6)
    # Only rows of equal balls that are in stock are compared.
    tapers = {"geometric taper": 4} if optional else {}
    assert found.compared == {"row of equal balls": 8 if optional else 1} | tapers


@pytest.mark.filterwarnings("ignore::hertzchain.errors.ModelRangeWarning")
def test_a_design_from_too_few_equal_balls_is_compared_with_sorted_ones(tmp_path):
    file = tmp_path / "drawer.csv"
    file.write_text("diameter [mm],material,count\n5,steel-304,1\n4,steel-304,2\n6,steel-304,3\n")
    problem = hc.Design(STEEL, minimise="wall_force.peak", vary=[hc.vary.balls(file)])
    found = hc.design(problem, budget=500)
    large, small = [2.0, 2.5, 3.0, 3.0, 3.0], [2.0, 2.0, 2.5, 3.0, 3.0]
    rows = [row[::step] for row in (large, small) for step in (1, -1)]
    chains = [
        hc.Chain.from_materials(1e-3 * np.array([2.0, *row]), "steel-304", velocity=0.1,
                                right_wall=STEEL.right_wall)
        for row in rows
    ]  # fmt: skip
    peaks = hc.simulate_many(chains, keep=["wall_peak_force"])["wall_peak_force"]
    (name,) = found.compared
    assert found.compared == {"row of balls sorted by size": 4}
    best = rows[int(np.argmin(peaks))]
    reference = found.references[name]
    np.testing.assert_allclose(1e3 * reference.chain.radii[1:], best)
    assert found.objective_of(reference) == pytest.approx(peaks.min(), rel=1e-6)
    ends = f"{2.0 * best[0]:g} mm to {2.0 * best[-1]:g} mm"
    assert f"best {name} (of 4 tried), {ends}:" in found.summary()
    sorted_balls = found.summary().partition(f"best {name} ")[2]
    (line,) = (x for x in sorted_balls.splitlines() if "this design / value" in x)
    assert line.split()[4] == f"{found.value / peaks.min():.1%}"


def test_a_genetic_search_uses_no_more_balls_than_there_are(drawer):
    problem = hc.Design(STEEL, minimise="wall_force.peak", vary=[hc.vary.balls(drawer)])
    best = hc.design(problem, budget=500)
    found = hc.design(problem, method="genetic", budget=500)
    diameters = np.round(2e3 * found.chain.radii[1:], 6).tolist()
    assert diameters.count(4.0) <= 2
    assert diameters.count(5.0) <= 1
    assert found.value == pytest.approx(best.value, rel=1e-9)


def test_too_few_balls_are_reported(tmp_path):
    file = tmp_path / "few.csv"
    file.write_text("diameter [mm],material,count\n4,steel-304,2\n5,steel-304,1\n")
    with pytest.raises(hc.InputError, match="3 balls in stock for 5 places"):
        hc.Design(STEEL, minimise="wall_force.peak", vary=[hc.vary.balls(file)])
    problem = hc.Design(
        STEEL, minimise="wall_force.peak", vary=[hc.vary.balls(file, optional=True)]
    )
    assert hc.design(problem, budget=100).chain.beads <= 4
    file.write_text("diameter [mm],material,count\n4,steel-304,2.5\n5,steel-304,1\n")
    with pytest.raises(hc.InputError, match="count in row 1 must be a whole number"):
        hc.Design(STEEL, minimise="wall_force.peak", vary=[hc.vary.balls(file)])
