"""Random moduli and yield strengths: `Scatter(young=...)` and `hertzchain scatter`."""

import json
import re

import numpy as np
import pytest
from click.testing import CliRunner

import hertzchain as hc
from hertzchain.cli import cli

STEEL = hc.material("steel-52100")
ROW = hc.Chain.from_materials(
    "5 mm", ["steel-52100", "brass"] * 3, velocity="0.05 m/s", right_wall=hc.Wall.of("steel-52100")
)
PLAIN = ROW.replace(materials=["steel-52100"] * 6)
OPTIONS = [
    "scatter", "--material", "steel-52100", "--diameter", "10 mm", "--beads", "6",
    "--speed", "0.05m/s", "--wall", "same", "--chains", "5", "--json",
]  # fmt: skip


def _moduli(chain):
    return np.array([each.young for each in chain.materials])


def test_peaks_of_elastic_rows_are_proportional_to_a_power_of_the_modulus():
    scatter = hc.Scatter(young="5%", samples=30)
    moduli = np.array([_moduli(each)[0] for each in scatter.sample(PLAIN)]) / STEEL.young
    found = hc.distribution(PLAIN, "wall_force.peak", scatter)
    # Hertz's law at one velocity: F ~ E^(2/5), of which balls and wall have one.
    assert found.values / found.nominal == pytest.approx(moduli**0.4, rel=1e-5)
    assert np.log(moduli).std() == pytest.approx(0.05, rel=0.4)


def test_balls_and_walls_of_a_material_have_one_factor_and_those_of_others_have_another():
    wide = ROW.replace(left_wall=hc.Wall.of("ptfe"))
    for chain in hc.Scatter(young=0.05, samples=3).sample(wide, seed=2):
        factors = _moduli(chain) / _moduli(ROW)
        assert factors == pytest.approx(np.tile(factors[:2], 3), rel=1e-12)
        assert factors[0] != factors[1]
        assert chain.right_wall.material == chain.materials[0]
        assert chain.left_wall.material.young != hc.material("ptfe").young
        assert [each.density for each in chain.materials] == [m.density for m in ROW.materials]


def test_each_material_has_its_own_scatter():
    both = hc.Scatter(young={"brass": "20%", "others": "1%"}, samples=40).sample(ROW)
    steel, brass = np.log([_moduli(each)[:2] / _moduli(ROW)[:2] for each in both]).T
    assert steel.std() == pytest.approx(0.01, rel=0.3)
    assert brass.std() == pytest.approx(0.2, rel=0.3)
    # The same random numbers, so that the other material only loses its deviation.
    one = hc.Scatter(young={"brass": 0.2}, samples=40).sample(ROW)
    assert [_moduli(each)[0] for each in one] == [STEEL.young] * 40
    assert [_moduli(each)[1] for each in one] == [_moduli(each)[1] for each in both]
    assert hc.Scatter(young={"brass": 0.2})._in_words("SI") == "modulus brass +-20%"


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"ptfe": 0.05}, "unknown material of a scatter of Young's moduli 'ptfe'.*brass, steel"),
        ({"brass": 5.0}, "young of a scatter of brass.*'5%'"),
        ({}, "names no material"),
    ],
)
def test_other_scatters_by_material_are_errors(given, message):
    with pytest.raises(hc.InputError, match=message):
        hc.Scatter(young=given).sample(ROW)


def test_losses_by_pairs_of_materials_follow_and_rigid_walls_stay():
    pairs = {("steel-52100", "brass"): hc.Restitution(0.9), "others": hc.Elastic()}
    lossy = ROW.replace(loss=pairs, left_wall=hc.Wall.rigid())
    (chain, _) = hc.Scatter(young=0.05, samples=2).sample(lossy)
    assert chain.contact_losses[1:-1] == lossy.contact_losses[1:-1]
    assert chain.left_wall == lossy.left_wall


def test_one_ball_between_walls_of_other_materials():
    walls = {"left_wall": hc.Wall.of("ptfe"), "right_wall": hc.Wall.of("brass")}
    one = hc.Chain.from_materials("5 mm", "steel-52100", beads=1, **walls)
    (chain, _) = hc.Scatter(young=0.05, samples=2).sample(one)
    assert len({_moduli(chain)[0] / STEEL.young} | {
        wall.material.young / hc.material(wall.material.name).young
        for wall in (chain.left_wall, chain.right_wall)
    }) == 3  # fmt: skip


def test_radii_gaps_and_speed_do_not_depend_on_the_scatter_of_materials():
    others = {"radius": 0.01, "gaps": "5 um", "speed": 0.02, "samples": 3}
    plain = hc.Scatter(**others).sample(ROW, seed=2)
    varied = hc.Scatter(**others, young=0.05).sample(ROW, seed=2)
    for one, two in zip(plain, varied, strict=True):
        for field in ("radii", "gaps", "velocities"):
            assert (getattr(one, field) == getattr(two, field)).all()


def test_yield_strengths_scale_the_first_yield():
    yielding = PLAIN.replace(loss=hc.ElasticPlastic())
    for chain in hc.Scatter(yield_strength="10%", samples=3).sample(yielding):
        own = chain.materials[0]
        assert own.young == STEEL.young
        assert own.yield_strength != STEEL.yield_strength
        assert chain.right_wall.material == own


@pytest.mark.parametrize("value", [0.0, -0.1, 0.31, "5 GPa", np.nan])
@pytest.mark.parametrize("key", ["young", "yield_strength"])
def test_other_scatters_are_errors(key, value):
    with pytest.raises(hc.InputError, match=f"{key} of a scatter"):
        hc.Scatter(**{key: value})


@pytest.mark.parametrize(
    ("chain", "key", "message"),
    [
        (hc.Chain.uniform(4), "young", "Young's moduli requires a chain with materials"),
        (ROW.replace(stiffness=ROW.stiffness), "young", "stiffness of the contacts, which"),
        (ROW, "yield_strength", "yield strengths changes only contacts that yield"),
        (ROW.replace(loss=hc.ElasticPlastic(yield_pressure="2 GPa")), "yield_strength",
         "this chain has none"),
    ],
)  # fmt: skip
def test_chains_whose_forces_do_not_depend_on_the_materials_are_errors(chain, key, message):
    with pytest.raises(hc.InputError, match=message):
        hc.Scatter(**{key: 0.05}).sample(chain)


def test_the_command_prints_the_distribution_of_python():
    more = ["--young-scatter", "1%", "--young-scatter", "steel-52100=5%", "--yield-scatter", "0.1",
            "--loss", "elastic-plastic"]  # fmt: skip
    done = CliRunner().invoke(cli, [*OPTIONS, *more])
    assert done.exit_code == 0, done.output
    document = json.loads(done.stdout)
    assert document["scatter"]["young"] == {"others": 0.01, "steel-52100": 0.05}
    assert document["scatter"]["yield_strength"] == 0.1
    scatter = hc.Scatter(young=0.05, yield_strength=0.1, samples=5)
    found = hc.distribution(PLAIN.replace(loss=hc.ElasticPlastic()), "wall_force.peak", scatter)
    assert document["values"] == pytest.approx(found.values.tolist(), rel=1e-6)


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (["--young-scatter", "5"], "--young-scatter.*for a scatter of 5%, give '5%'"),
        (["--young-scatter", "210 GPa"], "--young-scatter"),
        (
            ["--yield-scatter", "5%"],
            "changes only contacts that yield.*: add --loss elastic-plastic, or",
        ),
        (["--young-scatter", "1%", "--young-scatter", "5%"], "names no material, nor does"),
        ([], "--young-scatter or --yield-scatter, such as 5%"),
    ],
)
def test_bad_input_of_the_command(run, more, message):
    done = run(*OPTIONS, *more)
    assert done.returncode == 2
    assert re.search(message, done.stderr)


def test_the_title_of_the_figure_has_the_scatter():
    scatter = hc.Scatter(radius=0.01, young=0.05, yield_strength=0.1)
    assert scatter._in_words("SI") == "1% scatter, modulus +-5%, yield strength +-10%"
