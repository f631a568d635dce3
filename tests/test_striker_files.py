"""Strikers of chains are written as tables [[chain.struck_by]], which describe the same chain."""

import tomllib

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.store.chain_as_toml import chain_document

BALLS = hc.Chain.from_materials([5e-3, 4e-3, 3e-3], "steel-52100", right_wall=hc.Wall())
LISTED = BALLS.replace(masses=[1e-3, 2e-3, 3e-3], stiffness=[1e9, 2e9])
# Chains, and the keys of their strikers, the nearest one first.
CASES = {
    "piston": (
        BALLS.struck_by(mass="200 g", radius="flat", velocity="0.5 m/s"),
        [{"velocity": "0.5 m/s", "mass": "200 g", "radius": "flat"}],
    ),
    "mass": (
        BALLS.struck_by(mass="200 g", velocity=2, material="brass"),
        [{"velocity": "2.0 m/s", "mass": "200 g", "material": "brass"}],
    ),
    "mass and face": (
        BALLS.struck_by(mass="200 g", diameter="30 mm"),
        [{"velocity": "1.0 m/s", "mass": "200 g", "diameter": "30 mm"}],
    ),
    "like the first": (BALLS.struck_by(), [{"velocity": "1.0 m/s"}]),
    "several": (
        BALLS.struck_by(count=3, diameter="3/8 in", gap="2 um")
        .struck_by(velocity=3, stiffness=1e9),
        [{"velocity": "1.0 m/s", "diameter": "9.525 mm", "gap": "0.002 mm", "count": 3},
         {"velocity": "3.0 m/s", "stiffness": 1e9}],
    ),
    "listed masses": (
        LISTED.struck_by(mass="50 g", diameter="12 mm", stiffness=3e9),
        [{"velocity": "1.0 m/s", "mass": "50 g", "diameter": "12 mm", "stiffness": 3e9}],
    ),
    "scatter and gaps": (
        BALLS.with_scatter(1, relative="1%", gaps="5 um").struck_by(mass="1 g", radius="flat"),
        [{"velocity": "1.0 m/s", "mass": "1 g", "radius": "flat"}],
    ),
    "loads": (
        BALLS.struck_by(velocity="0.3 m/s", gap="1 mm")
        .replace(gravity=9.81, loss=hc.ElasticPlastic()),
        [{"velocity": "0.3 m/s", "gap": "1 mm"}],
    ),
    "scaled": (
        hc.Chain.tapered("forward-linear", 0.01, beads=8).struck_by(mass=4.0, radius=1.0),
        [{"velocity": 1.0, "mass": 4.0, "radius": 1.0}],
    ),
}  # fmt: skip


@pytest.mark.parametrize(("chain", "expected"), CASES.values(), ids=CASES)
def test_strikers_are_written_as_struck_by(chain: hc.Chain, expected: list[dict]) -> None:
    text = hc.chain_as_toml(chain)
    table = tomllib.loads(text)["chain"]
    assert table["struck_by"] == expected
    assert not {"strikers", "striker_properties", "velocity"} & table.keys()
    read = hc.chain_from_toml(text)
    assert read == chain
    for name in ("radii", "masses", "stiffness", "gaps", "velocities"):
        np.testing.assert_array_equal(getattr(read, name), getattr(chain, name))
    assert hc.chain_from_toml(text).description == chain.description


def test_the_document_of_the_app_has_editable_strikers() -> None:
    table = chain_document(CASES["piston"][0])["chain"]
    assert table["struck_by"] == [{"velocity": 0.5, "mass": 0.2, "radius": "flat"}]


def test_other_strikers_are_listed_among_the_beads() -> None:
    """Strikers that move away from the chain cannot be arguments of `struck_by`."""
    chain = BALLS.struck_by(mass="200 g", radius="flat")
    chain = chain.replace(velocities=[-1.0, 0.0, 0.0, 0.5])
    text = hc.chain_as_toml(chain)
    table = tomllib.loads(text)["chain"]
    assert "struck_by" not in table
    assert table["strikers"] == 1
    assert "has a flat face" in text
    assert hc.chain_from_toml(text) == chain


@pytest.mark.long
def test_a_design_keeps_its_piston() -> None:
    problem = hc.Design(
        CASES["piston"][0], minimise="wall_force.peak",
        vary=[hc.vary.diameters("6 mm", "10 mm", beads="2:")],
    )  # fmt: skip
    found = hc.design(problem, budget=100)
    text = hc.chain_as_toml(found.chain)
    assert tomllib.loads(text)["chain"]["struck_by"] == CASES["piston"][1]
    assert hc.chain_from_toml(text) == found.chain
