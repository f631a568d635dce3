"""Descriptions and files of chains whose radii scatter, and of chains made from them."""

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.plotting.sweep_labels import axis_label
from hertzchain.plotting.titles import chain_words

STEEL = hc.Chain.from_materials(5e-3, "steel-316", beads=20)
TAPER = hc.Chain.tapered(first="10 mm", last="5 mm", beads=20, material="steel-316")
UNIFORM = hc.Chain.uniform(20).with_scatter(1, relative=0.1)
BALLS = STEEL.with_scatter(1, relative="1%")
# Chains with a scatter, their descriptions and their titles.
CASES = {
    "uniform": (UNIFORM, "uniform, 10% scatter, 20 beads", None),
    "exponent": (
        hc.Chain.uniform(9, exponent=2.0).with_scatter(1, relative=0.1),
        "uniform, 10% scatter, 9 beads, p = 2", None,
    ),
    "taper": (
        hc.Chain.tapered("forward-linear", 0.01, beads=20).with_scatter(1, relative=0.025),
        "forward-linear, S = 0.01, 2.5% scatter, 20 beads", None,
    ),
    "dimer": (
        hc.Chain.dimer(radii=[1.0, 0.5], beads=20).with_scatter(1, relative=0.02),
        "dimer, radius ratio 0.5, 2% scatter, 20 beads", None,
    ),
    "balls": (
        BALLS, "20 steel-316 beads, diameter 10 mm, 1% scatter",
        "20 steel balls, 10 mm, 1% scatter",
    ),
    "grade": (
        TAPER.with_scatter(1, grade=100),
        "20 steel-316 beads, diameters 20 mm to 10 mm, exponential taper, grade 100",
        "20 steel balls, 20 mm to 10 mm, exponential taper, grade 100",
    ),
    "projectile": (
        STEEL.with_scatter(1, relative=0.01, beads="2:"),
        "20 steel-316 beads, diameter 10 mm, 1% scatter", "20 steel balls, 10 mm, 1% scatter",
    ),
    "few": (
        STEEL.with_scatter(1, relative=0.01, beads=[3, 9]),
        "20 steel-316 beads, diameter 10 mm, 1% scatter of 2 beads",
        "20 steel balls, 10 mm, 1% scatter of 2 beads",
    ),
    "struck": (
        BALLS.struck_by(velocity=2.0),
        "20 steel-316 beads, diameter 10 mm, 1% scatter, and 1 striker",
        "20 steel balls, 10 mm, 1% scatter, and a striker, 10 mm",
    ),
    "two strikers": (
        BALLS.struck_by(radius="3 mm").struck_by(),
        "20 steel-316 beads, diameter 10 mm, 1% scatter, and 2 strikers (10 mm to 6 mm)",
        "20 steel balls, 10 mm, 1% scatter, and 2 strikers, 10 mm to 6 mm",
    ),
    "another striker": (
        BALLS.struck_by(radius="3 mm"),
        "20 steel-316 beads, diameter 10 mm, 1% scatter, and 1 striker (6 mm, 0.9048 g)",
        "20 steel balls, 10 mm, 1% scatter, and a striker, 6 mm",
    ),
}  # fmt: skip
EDITS = {
    "slice": (lambda chain: chain[4:12], "uniform, 10% scatter, 8 beads"),
    "first beads": (lambda chain: chain[:12], "uniform, 10% scatter, 12 beads"),
    "reversed": (lambda chain: chain.reversed(), "uniform, 10% scatter, 20 beads"),
    "joined": (lambda chain: chain + chain, "uniform, 10% scatter, 40 beads"),
    "joined with equal beads": (
        lambda chain: chain + hc.Chain.uniform(5), "given radii, 25 beads",
    ),
    "joined with another scatter": (
        lambda chain: chain + hc.Chain.uniform(5).with_scatter(1, relative=0.2),
        "given radii, 25 beads",
    ),
    "wall": (
        lambda chain: chain.replace(right_wall=hc.Wall()),
        "uniform, 10% scatter, 20 beads, right wall",
    ),
    "equal radii": (lambda chain: chain.replace(radii=np.ones(20)), "uniform, 20 beads"),
    "other radii": (
        lambda chain: chain.replace(radii=np.linspace(1.0, 2.0, 20)), "given radii, 20 beads",
    ),
    "decorated": (lambda chain: chain.decorated(0.3), "given radii, 39 beads"),
    "defects": (lambda chain: chain.with_defects({3: 0.5}), "given radii, 20 beads"),
    "scatter of given radii": (
        lambda chain: chain.with_scatter(2, relative=0.01), "given radii, 1% scatter, 20 beads",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_descriptions_and_titles_name_the_scatter(name):
    chain, description, title = CASES[name]
    assert chain.description == description
    assert repr(chain).startswith(f"Chain({description}")
    assert chain_words(chain) == (title or description)


@pytest.mark.parametrize("name", EDITS)
def test_edited_chains_have_no_false_description(name):
    edit, description = EDITS[name]
    assert edit(UNIFORM).description == description


@pytest.mark.parametrize("chain", [*(each for each, *_ in CASES.values()),
                                   *(edit(UNIFORM) for edit, _ in EDITS.values())])  # fmt: skip
def test_files_keep_the_scatter(chain, tmp_path):
    file = tmp_path / "chain.toml"
    file.write_text(hc.chain_as_toml(chain))
    again = hc.load_chain(file)
    assert again == chain
    assert (again.description, again.scatter) == (chain.description, chain.scatter)


def test_files_state_the_beads_without_scatter():
    lines = hc.chain_as_toml(BALLS).splitlines()
    assert lines[:4] == ["[chain]", 'diameters = "10 mm"', "beads = 20", 'materials = "steel-316"']
    assert lines[4].startswith("with_scatter = {relative = 0.01, radii = [0.0050")


def test_a_piece_without_deviating_beads_has_no_scatter():
    chain = STEEL.with_scatter(1, relative=0.01, beads="11:")
    assert chain[:10].description == "10 steel-316 beads, diameter 10 mm"
    assert chain[5:].description == "15 steel-316 beads, diameter 10 mm, 1% scatter of 10 beads"


def test_a_scatter_of_zero_keeps_the_taper():
    chain = hc.Chain.tapered("forward-linear", 0.01, beads=20)
    assert chain.with_scatter(1, relative=0.0) == chain


def test_the_scatter_does_not_change_the_motion():
    plain = UNIFORM.replace(scatter=None)
    assert plain.description == "given radii, 20 beads"
    assert plain != UNIFORM
    for name in ("velocity", "arrival", "peak_force"):
        one, other = (getattr(hc.propagate(each), name) for each in (UNIFORM, plain))
        np.testing.assert_array_equal(one, other)


def test_chains_in_other_units_have_the_scatter():
    scales = hc.Scales.of(BALLS)
    scaled = scales.to_scaled(BALLS)
    assert scaled.description == "uniform, 1% scatter, 20 beads"
    assert scales.to_si(scaled).description == BALLS.description


def test_samples_of_a_scatter_are_described_as_the_chain_with_scatter():
    for sample in hc.Scatter(radius=0.01, samples=3).sample(STEEL):
        assert sample.description == BALLS.description


def test_radii_can_be_given_instead_of_a_seed():
    measured = [f"{size} mm" for size in (5.01, 4.99, 5.0)]
    chain = STEEL[:3].with_scatter(relative="0.2%", radii=measured)
    np.testing.assert_allclose(chain.radii, [5.01e-3, 4.99e-3, 5e-3], rtol=1e-15)
    assert chain.description == "3 steel-316 beads, diameter 10 mm, 0.2% scatter"
    chain = STEEL[:3]
    for arguments, problem in (
        ({"radii": [5e-3] * 3, "seed": 1}, "omit seed, beads and gaps"),
        ({"radii": [5e-3] * 3, "beads": "2:"}, "omit seed, beads and gaps"),
        ({"radii": [5e-3] * 4}, "got 4"),
        ({}, "needs a seed of the random numbers, or radii"),
    ):
        with pytest.raises(hc.InputError, match=problem):
            chain.with_scatter(relative=0.01, **arguments)
    with pytest.raises(hc.InputError, match=r"scatter must be that of a chain of 3 beads"):
        chain.replace(scatter=BALLS.scatter)


def test_explore_and_sweeps_begin_with_the_radii():
    spec = {"chain": UNIFORM, "axes": {"radii.3": [0.9, 1.1]}, "sweep": {"at": "last"}}
    found = hc.sweep(spec)
    for i, radius in enumerate((0.9, 1.1)):
        radii = UNIFORM.radii.copy()
        radii[2] = radius
        pulse = hc.propagate(UNIFORM.replace(radii=radii))
        assert found.velocity.values.ravel()[i] == pytest.approx(pulse.velocity[-1], rel=1e-12)


@pytest.mark.parametrize("several", [False, True])
def test_sweeps_reject_axes_without_effect(several):
    scatter = {"relative": 0.1, "radii": [1.1, 0.9, 1.0]}
    chain = {"taper": "uniform", "beads": 3, "with_scatter": [scatter] if several else scatter}
    for name in ("relative", "seed"):
        axes = {f"with_scatter.{name}": [1, 2]}
        words = rf"axes\.with_scatter\.{name}: has no effect, because with_scatter has the radii"
        with pytest.raises(hc.InputError, match=words):
            hc.sweep({"chain": chain, "axes": axes, "sweep": {"at": "last"}})


def test_axes_of_sweeps_name_the_scatter():
    axes = {"with_scatter.relative": [0.01, 0.02], "with_scatter.seed": [1, 2]}
    chain = {"taper": "uniform", "beads": 8}
    found = hc.sweep({"chain": chain, "axes": axes, "sweep": {"at": "last"}})
    labels = [axis_label(found[name]) for name in ("relative", "seed")]
    assert labels == ["scatter of the radii", "seed of the radii"]
