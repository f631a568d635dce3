"""Headlines of designs outside the range of the law, ties, and figures of equal rows."""

import itertools

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.patches import Rectangle

import hertzchain as hc
from hertzchain.designs.comparison import same_as, shown_chains
from hertzchain.designs.search_budget import budget_from, simulations_within
from hertzchain.plotting.design_beads import _write_names

STEEL = "steel-52100"
WORDS = "outside the range of Hertz's law, where forces are not a prediction"


def absorber(material, diameters, limit, speed):
    """The fewest balls behind a heavy hammer, for a limit of the force on the wall."""
    row = hc.Chain.from_materials(
        diameters="10 mm", materials=STEEL, beads=3, right_wall=hc.Wall.of(STEEL)
    ).struck_by(mass="50 g", material=STEEL, velocity=speed)
    balls = hc.vary.balls(materials=[material], diameters=diameters, beads="2:", optional=True)
    problem = hc.Design(
        row,
        minimise="beads",
        vary=[balls],
        subject_to={"wall_force.peak": f"<= {limit}", "overlap_ratio": "<= 10"},
    )
    return hc.design(problem, budget=500)


@pytest.fixture(scope="module")
def soft():
    return absorber("ptfe", ["3.175 mm", "6.35 mm"], "400 N", "1.41 m/s")


@pytest.fixture(scope="module")
def stiff():
    return absorber(STEEL, ["4 mm", "6 mm", "10 mm"], "40 N", "0.01 m/s")


@pytest.mark.long
def test_the_headline_states_that_forces_are_not_a_prediction(soft):
    assert soft.met
    with pytest.warns(hc.ModelRangeWarning):
        run = hc.simulate(soft.chain)
    ratio = hc.hertz_range(soft.chain, run.largest_overlaps).overlap_ratio
    assert np.nanmax(ratio) > 0.1
    assert soft.summary().splitlines()[0].endswith(WORDS)
    assert soft.as_dict()["forces_predicted"] is False
    axes = soft.plot("beads")
    assert "forces not predicted" in "".join(text.get_text() for text in axes.texts)
    plt.close(axes.figure)


def test_a_valid_design_has_no_such_statement(stiff):
    assert "not a prediction" not in stiff.summary()
    assert stiff.as_dict()["forces_predicted"] is True


def test_the_force_decides_between_rows_of_as_many_balls(stiff):
    """The best of all rows with the fewest balls, each of them simulated here."""
    peaks = {}
    for row in itertools.product([4e-3, 6e-3, 10e-3], repeat=stiff.chain.beads - 1):
        chain = hc.Chain.from_materials(
            diameters=list(row), materials=STEEL, right_wall=hc.Wall.of(STEEL)
        ).struck_by(mass="50 g", material=STEEL, velocity="0.01 m/s")
        peaks[row] = hc.simulate(chain).wall_force().peak
    assert len(peaks) > 1
    assert stiff.values["wall_force.peak"] == pytest.approx(min(peaks.values()), rel=1e-6)
    assert "the smallest wall_force.peak is preferred" in stiff.summary()


def test_equal_rows_are_drawn_once(stiff):
    assert same_as(stiff) == "best row of equal balls"
    assert [*shown_chains(stiff)] == ["design"]
    axes = stiff.plot("forces")
    assert axes.get_legend().get_texts()[0].get_text().startswith("design = best row of equal")
    plt.close(axes.figure)


def test_a_name_that_is_taller_than_small_balls_ends_above_the_label_of_the_diameters():
    axes = plt.subplots(figsize=(7.0, 2.2))[1]
    axes.set(aspect="equal", xlim=(0.0, 120.0), ylim=(-22.0, 6.0))
    lines = ["design = best", "row of equal", "balls"]
    _write_names([(0.0, ["given chain"]), (-14.0, lines)], axes, 2.5)
    _, last = axes.texts
    axes.figure.canvas.draw()
    extent = last.get_window_extent().transformed(axes.transData.inverted())
    assert extent.height > 5.0
    # The lowest line has room below its letters.
    assert extent.y0 == pytest.approx(-16.5, abs=0.2)
    plt.close(axes.figure)


def test_the_figure_of_an_enumeration_has_the_distribution_of_all_choices():
    row = hc.Chain.from_materials(diameters="10 mm", materials=STEEL, beads=4, velocity="0.1 m/s")
    balls = hc.vary.balls(materials=[STEEL], diameters=["5 mm", "8 mm", "10 mm"], beads="2:")
    found = hc.design(hc.Design(row, maximise="velocity@last", vary=[balls]), method="enumerate")
    assert len(found.candidates) == 27
    assert found.candidates.max() == pytest.approx(found.value, rel=1e-4)
    axes = found.plot("history")
    assert axes.patches[0].get_data().values.sum() == 27
    assert axes.get_xlabel() == "velocity of the last bead [m/s]"
    assert axes.lines[0].get_xdata()[0] == pytest.approx(found.value, rel=1e-4)
    plt.close(axes.figure)


def test_the_figure_of_an_acceleration_has_a_raised_exponent():
    row = hc.Chain.from_materials(diameters="10 mm", materials=STEEL, beads=3).with_cap(mass="50 g")
    row = row.struck_by(mass="50 g", velocity="0.05 m/s")
    balls = hc.vary.balls(materials=[STEEL], diameters=["8 mm", "10 mm"], beads="2:")
    problem = hc.Design(row, minimise="body_force.acceleration", vary=[balls], until="1 ms")
    axes = hc.design(problem, budget=20).plot("history")
    assert axes.get_xlabel().endswith("[m/s²]")
    plt.close(axes.figure)


def test_durations_on_a_body_permit_fewer_simulations():
    """Tables that keep them run chain by chain."""
    row = hc.Chain.from_materials(diameters="10 mm", materials=STEEL, beads=3, velocity="0.1 m/s")
    row, radii = row.with_cap(mass="50 g"), [hc.vary.radii("4 mm", "5 mm")]
    limit = budget_from("30 s")
    force, duration = (
        simulations_within(limit, hc.Design(row, minimise=f"body_force.{name}", vary=radii))
        for name in ("peak", "duration")
    )
    assert force == pytest.approx(30.0 * duration)


@pytest.mark.parametrize(
    ("named", "numbered"),
    [("ball 1:", "2:"), ("ball1:ball 2", "2:3"), ("ball 3", "4"), ("ball 2:last", "3:4"),
     (["ball 1", "bead 4"], [2, 4])],
)  # fmt: skip
def test_names_of_balls_do_not_count_strikers(named, numbered):
    row = hc.Chain.from_materials(diameters="10 mm", materials=STEEL, beads=3)
    row = row.struck_by(mass="50 g", velocity="0.1 m/s")
    for vary in (
        lambda beads: hc.vary.balls(materials=[STEEL], beads=beads),
        lambda beads: hc.vary.radii("4 mm", "5 mm", beads=beads),
    ):
        found, expected = (
            hc.Design(row, maximise="velocity@last", vary=[vary(beads)]).space
            for beads in (named, numbered)
        )
        if hasattr(found, "places"):
            np.testing.assert_array_equal(found.places, expected.places)
        else:
            np.testing.assert_array_equal(found.blocks[0].places, expected.blocks[0].places)


@pytest.mark.parametrize(
    ("beads", "message"),
    [("ball 1:3", "name both ends, as in 'ball 1:ball 5'"), ("ball 4:", "there is no ball 4"),
     ("cap", "the chain has no cap")],
)  # fmt: skip
def test_ambiguous_and_missing_names_are_rejected(beads, message):
    row = hc.Chain.from_materials(diameters="10 mm", materials=STEEL, beads=3)
    row = row.struck_by(mass="50 g", velocity="0.1 m/s")
    radii = hc.vary.radii("4 mm", "5 mm", beads=beads)
    with pytest.raises(hc.InputError, match=message):
        hc.Design(row, maximise="velocity@last", vary=[radii])


def test_a_pad_is_a_layer_in_front_of_the_wall():
    row = hc.Chain.from_materials(diameters=["12 mm"] * 3, materials=STEEL, velocity="0.1 m/s")
    for wall, layers in ((hc.Wall(stiffness="1 kN/mm", exponent=1), 1), (hc.Wall.of(STEEL), 0)):
        problem = hc.Design(row.replace(right_wall=wall), minimise="wall_force.peak",
                            vary=hc.vary.radii("5 mm", "6 mm"))  # fmt: skip
        axes = hc.design(problem, budget=100, seed=1).plot("beads")
        pads = [patch for patch in axes.patches if isinstance(patch, Rectangle)]
        ends = [line.get_xdata()[0] for line in axes.lines if line.get_linewidth() == 3.0]
        assert len(pads) == layers * len(ends)
        for pad, end in zip(pads, ends, strict=False):
            assert pad.get_x() + pad.get_width() == pytest.approx(end)
