"""The best geometric taper of balls of a catalogue, with which a design is compared."""

import itertools
import json

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.designs.ball_tapers import GEOMETRIC_TAPER, geometric_tapers

SIZES = [30.0, 20.0, 15.0, 10.0, 8.0, 5.0]


def focuser(places=6, **options):
    row = hc.Chain.from_materials(15e-3, "steel-52100", beads=places + 1, velocity="0.05 m/s")
    balls = hc.vary.balls(
        materials=["steel-52100"], diameters=[f"{size} mm" for size in SIZES], beads="2:", **options
    )
    return hc.Design(row, maximise="velocity@last", vary=[balls])


def sizes_of(problem, rows):
    balls = problem.space.balls
    return {tuple(round(1e3 * balls[i].diameter, 4) for i in row if i < len(balls)) for row in rows}


def test_tapers_are_the_balls_nearest_to_geometric_sequences():
    problem = focuser()
    expected = set()
    for one, other in itertools.permutations(SIZES, 2):
        wanted = np.geomspace(one, other, 6)
        expected.add(tuple(min(SIZES, key=lambda s, w=w: abs(np.log(s / w))) for w in wanted))
    assert sizes_of(problem, geometric_tapers(problem.space)) == expected


def test_with_empty_places_tapers_of_several_lengths_are_compared():
    found = sizes_of(focuser(optional=True), geometric_tapers(focuser(optional=True).space))
    assert {len(each) for each in found} == {3, 4, 5, 6}


def test_no_taper_needs_more_balls_than_there_are(tmp_path):
    stock = tmp_path / "stock.csv"
    rows = [f"{size},steel-52100,1" for size in SIZES]
    stock.write_text("\n".join(["diameter [mm],material,count", *rows]))
    chain = hc.Chain.from_materials(15e-3, "steel-52100", beads=5, velocity="0.1 m/s")
    vary = [hc.vary.balls(stock, beads="2:")]
    problem = hc.Design(chain, maximise="velocity@last", vary=vary)
    found = sizes_of(problem, geometric_tapers(problem.space))
    assert found
    assert all(len(set(each)) == 4 for each in found)


def test_a_focuser_is_compared_with_the_best_taper():
    problem = focuser()
    found = hc.design(problem, budget=300, seed=1)
    taper = found.references[GEOMETRIC_TAPER]
    chains = map(problem.space.chain_of, geometric_tapers(problem.space))
    largest = max(float(hc.simulate(chain).pulse().velocity[-1]) for chain in chains)
    value = found.objective_of(taper)
    assert value == pytest.approx(largest, rel=1e-6)
    # The taper is a better rule than equal balls, and the design is at least as good.
    assert value > 1.5 * found.objective_of(found.references["row of equal balls"])
    assert found.value >= value * (1 - 1e-9)
    assert found.runs <= 300
    ends = found.compared[GEOMETRIC_TAPER]
    assert f"best geometric taper (of {ends} tried), 15 mm to 5 mm: " in found.summary()
    names = json.loads(json.dumps(found.as_dict()))["references"]
    assert any("geometric taper" in name for name in names)


def test_searches_with_scatter_and_fronts_have_a_taper_but_orders_have_none():
    problem = focuser()
    scatter = hc.Scatter(radius=0.01, samples=4, beads="2:")
    scattered = hc.Design(
        problem.chain, maximise="velocity@last", vary=problem.vary, scatter=scatter
    )
    plain = hc.design(problem, budget=200).references[GEOMETRIC_TAPER]
    taper = hc.design(scattered, budget=200).references[GEOMETRIC_TAPER]
    np.testing.assert_array_equal(taper.chain.radii, plain.chain.radii)
    assert taper.scattered["CVaR90 of velocity@last"] < taper.values["velocity@last"]
    both = hc.Design(problem.chain, maximise=["velocity@last", "mass"], vary=problem.vary)
    front = hc.design(both, budget=200)
    np.testing.assert_array_equal(front.references[GEOMETRIC_TAPER].chain.radii, plain.chain.radii)
    # No taper that the search missed beats a point of the front.
    assert front.front[0].value >= plain.values["velocity@last"]
    row = problem.chain.replace(radii=[15e-3, 10e-3, 8e-3, 5e-3, 4e-3, 3e-3, 2e-3])
    order = hc.Design(row, maximise="velocity@last", vary=[hc.vary.order(beads="2:")])
    assert geometric_tapers(order.space) == []


def test_neighbours_of_very_different_sizes_are_named():
    """The largest ratio of a chosen ball and its neighbour, and the key that limits it."""
    row = hc.Chain.from_materials(
        "5 mm", "steel-52100", beads=4, right_wall=hc.Wall.of("steel-52100"), velocity="0.01 m/s"
    )
    for diameters, noted in ((["1.5 mm", "2 mm"], True), (["3 mm", "4 mm"], False)):
        kinds = hc.vary.balls(materials=["steel-52100"], diameters=diameters, beads="2:")
        found = hc.design(hc.Design(row, minimise="wall_force.peak", vary=[kinds]), budget=100)
        notes = [each for each in found.notes if each.startswith("neighbouring balls")]
        assert len(notes) == noted
        first, second = 2e3 * found.chain.radii[:2]
        said = f"of {first:.4g} mm and {second:.4g} mm (beads 1 and 2) differ by a factor of "
        assert all(f"{said}{first / second:.2g}: " in each for each in notes)
        assert all("limit the sizes with diameters" in each for each in notes)
