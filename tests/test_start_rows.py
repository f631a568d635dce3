"""Designs whose search begins with a given row of balls."""

import pytest

import hertzchain as hc
from hertzchain.designs.ball_space import BallSpace

SIZES = ("3 mm", "4 mm", "5 mm", "6.35 mm", "8 mm")
ABSORBER = hc.Chain.from_materials(
    "3.175 mm", "steel-52100", beads=9, velocity="0.3 m/s", right_wall=hc.Wall.of("steel-52100")
)
# The best of all 488 280 rows at most 60 mm long (docs/how-to/design.md).
BEST = ("5 mm", "4 mm", "8 mm", "3 mm", "8 mm", "6.35 mm", "5 mm", "3 mm")
LIMITS = {"length": "<= 60 mm", "yield_ratio": "<= 1"}


def absorber(start, **more):
    given = {"materials": "steel-52100", "diameters": SIZES, "optional": True} | more
    balls = hc.vary.balls(start=start, **given)
    return hc.Design(ABSORBER, minimise="wall_force.peak", vary=[balls], subject_to=LIMITS)


@pytest.mark.long
def test_the_search_begins_with_the_row():
    """Rows near the best one contain it; random rows do not within this budget."""
    exchanged = ("5 mm", "4 mm", "3 mm", "8 mm", "8 mm", "6.35 mm", "5 mm", "3 mm")
    best = absorber(None).evaluate(absorber(BEST).space.chain_of(absorber(BEST).space.start))
    found = hc.design(absorber(exchanged), budget=1000)
    without = hc.design(absorber(None), budget=1000)
    assert found.value == pytest.approx(best.values["wall_force.peak"], rel=1e-9)
    assert found.value < 0.98 * without.value


def test_the_row_and_equal_balls_are_compared_with_the_design():
    found = hc.design(absorber(BEST), budget=200)
    assert list(found.references) == ["given row", "row of equal balls", "geometric taper"]
    assert found.value <= found.objective_of(found.references["given row"])
    summary = found.summary()
    assert "given row: 12.79 N\n    this design: 100.0% of this value\n" in summary
    assert "nothing better than the given row" in summary


@pytest.mark.parametrize("ball", ["6.35 mm", "1/4 in", "6.35 mm steel-52100", 6.35e-3])
def test_a_ball_may_be_given_by_its_diameter_and_material(ball):
    space = absorber(["2 x 5 mm", ball]).space
    assert isinstance(space, BallSpace)
    assert space.start.tolist() == [2, 2, 3, 5, 5, 5, 5, 5]
    assert space.chain_of(space.start).beads == 4


@pytest.mark.parametrize(
    ("start", "more", "told"),
    [
        ("5 mm", {}, "start must be a list of balls, such as '5 mm' or '5 mm ptfe', got '5 mm'"),
        (["5"], {}, "a ball of start must be a diameter with its unit, .* got '5'"),
        (["5.5 mm"], {}, "'5.5 mm' of start is not among the balls that may be chosen: 3 mm "),
        (["5 mm ptfe"], {}, "'5 mm ptfe' of start is not among the balls"),
        ([True], {}, "diameter of a ball of start must be a number, got True"),
        (["99999999999 x 5 mm"], {}, "start must have at most 8 balls, .* got 99999999999"),
        ([], {}, "start must have at least 1 ball, got 0"),
        (["5 mm"], {"optional": False}, "must have 8 balls, .* got 1; optional = true permits"),
        (["8 x 5 mm"], {"materials": ["steel-52100", "steel-304"]},
         "'8 x 5 mm' of start has no material: add steel-52100 or steel-304"),
    ],
)  # fmt: skip
def test_a_row_that_cannot_be_chosen_is_reported(start, more, told):
    with pytest.raises(hc.InputError, match=told):
        absorber(start, **more)


def test_a_row_needs_no_more_balls_than_are_in_stock(tmp_path):
    drawer = tmp_path / "drawer.csv"
    drawer.write_text("diameter [mm],material,count\n4,steel-52100,2\n5,steel-52100,\n")
    with pytest.raises(hc.InputError, match="3 balls of 4 mm steel-52100, of which 2 are in stock"):
        hc.Design(
            ABSORBER, minimise="wall_force.peak",
            vary=[hc.vary.balls(drawer, optional=True, start=["3 x 4 mm", "5 mm"])],
        )  # fmt: skip


def test_the_row_is_a_key_of_a_design_file(tmp_path):
    file = tmp_path / "absorber.toml"
    file.write_text(
        '[chain]\nradii = "3 mm"\nmaterials = "steel-52100"\nbeads = 4\nvelocity = "0.3 m/s"\n'
        'right_wall = {material = "steel-52100"}\n[design]\nminimise = "wall_force.peak"\n'
        '[[design.vary]]\nballs = "bearing-balls"\nmaterials = ["steel-52100", "ptfe"]\n'
        'start = ["2 x 4 mm steel-52100", "4.7625 mm ptfe"]\n'
    )
    problem, _ = hc.load_design(file)
    chain = problem.space.chain_of(problem.space.start)
    assert [2e3 * radius for radius in chain.radii] == pytest.approx([6, 4, 4, 4.7625])
    assert [each.name for each in chain.materials[1:]] == ["steel-52100", "steel-52100", "ptfe"]
