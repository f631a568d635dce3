"""Peaks on a wall to which beads can return are peaks so far, wherever they are shown."""

import json

import pytest

import hertzchain as hc
from hertzchain.simulation.wall_bound import LATER_IMPACTS

OPTIONS = ["--material", "steel-52100", "--diameter", "10 mm", "--beads", 6, "--speed", "0.1 m/s",
           "--wall", "same"]  # fmt: skip


def row(gravity):
    return hc.Chain.from_materials(
        "5 mm",
        "steel-52100",
        beads=6,
        velocity="0.1 m/s",
        right_wall=hc.Wall(),
        gravity=gravity,
    )


@pytest.mark.parametrize(("gravity", "later"), [("9.81 m/s^2", True), (0.0, False)])
def test_every_result_states_whether_a_later_impact_may_be_stronger(gravity, later):
    chain = row(gravity)
    peak = hc.simulate(chain).wall_force()
    assert peak.complete
    assert peak.proven is not later
    scattered = hc.distribution(chain, "wall_force.peak", hc.Scatter(radius=0.01, samples=4))
    slopes = hc.gradient(chain, "wall_force.peak", to="radii", until="2 ms")
    problem = hc.Design(
        chain, minimise="wall_force.peak", vary=[hc.vary.radii("4 mm", "6 mm", beads="3")]
    )
    found = hc.design(problem, budget=20)
    texts = [repr(scattered), scattered._repr_html_(), repr(slopes), slopes._repr_html_(),
             " ".join(found.as_dict()["notes"]), str(found.summary())]  # fmt: skip
    words = LATER_IMPACTS.partition(", and ")[2]
    assert [words in " ".join(each.split()) for each in texts] == [later] * len(texts)


def test_a_force_elsewhere_has_no_such_note():
    chain = row("9.81 m/s^2")
    found = hc.distribution(chain, "velocity@3", hc.Scatter(radius=0.01, samples=4))
    assert "later impact" not in repr(found)
    largest = hc.distribution(
        chain, "wall_force.largest_so_far", hc.Scatter(radius=0.01, samples=4), until="0.5 ms"
    )
    assert "later impact" not in repr(largest)


@pytest.mark.parametrize("command", [("scatter", "--scatter", "1%", "--chains", 4),
                                     ("sensitivity", "--until", "0.5 ms")])  # fmt: skip
def test_commands_state_it_on_the_terminal_and_in_json(run, command):
    given = [*command, *OPTIONS, "--gravity", "9.81 m/s^2"]
    assert f": {LATER_IMPACTS}" in run(*given).stdout
    assert any(LATER_IMPACTS in each for each in json.loads(run(*given, "--json").stdout)["notes"])


def test_a_range_of_yield_pressures_that_is_not_complete_says_so(run):
    given = [*OPTIONS, "--precompression", "20 N", "--loss", "elastic-plastic"]
    given[1:8:2] = ["steel-316", "19 mm", 12, "0.05 m/s"]
    done = run("simulate", *given)
    assert "right wall: no range, because the peak at 2.8 times is not complete" in done.stdout
    assert done.stderr == ""


def test_a_range_under_gravity_is_that_so_far(run):
    given = [*OPTIONS, "--gravity", "9.81 m/s^2", "--loss", "elastic-plastic"]
    given[given.index("steel-52100")] = "steel-304"
    assert "  right wall: peak so far " in run("simulate", *given).stdout
