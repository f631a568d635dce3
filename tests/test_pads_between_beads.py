"""Linear springs between two beads, such as a pad in front of the cap of a load cell."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import hertzchain as hc
from hertzchain.store.chain_as_toml import chain_as_toml
from hertzchain.store.chain_files import chain_from

BALLS = hc.Chain.from_materials(
    diameters="10 mm", materials="steel-52100", beads=3, right_wall=hc.Wall("20 kN/mm", exponent=1)
)
PAD = {"stiffness": "1 kN/mm", "exponent": 1}
HAMMER = {"velocity": "0.1 m/s", "mass": "150 g", "radius": "flat"}


def by_scipy(chain, times):
    """Displacements of a row whose beads touch, from its equations of motion."""
    stiffness = np.append(chain.stiffness, chain.wall_stiffness[1])
    exponents, masses, beads = chain.contact_exponents[1:], chain.masses, chain.beads

    def motion(_, state):
        x, v = np.split(state, 2)
        forces = stiffness * np.maximum(-np.diff(x, append=0.0), 0.0) ** exponents
        return np.concatenate((v, (np.append(0.0, forces[:-1]) - forces) / masses))

    start = np.concatenate((np.zeros(beads), chain.velocities))
    found = solve_ivp(motion, (0.0, times[-1]), start, t_eval=times, method="DOP853",
                      rtol=1e-10, atol=1e-14, max_step=1e-6)  # fmt: skip
    return found.y[:beads]


@pytest.mark.parametrize("balls", [1, 3])
def test_a_pad_in_front_of_a_cap_agrees_with_scipy(balls):
    chain = BALLS[-balls:].with_cap("15 g", **PAD).struck_by(**HAMMER)
    assert chain.contact_exponents.tolist() == [1.5] * (balls + 1) + [1.0, 1.0]
    assert chain.stiffness[-1] == 1e6
    times = np.linspace(0.0, 1e-3, 301)
    run = hc.simulate(chain, times=times, rtol=1e-10)
    expected = by_scipy(chain, times)
    pad, cell = 1e6 * (expected[-2] - expected[-1]), 2e7 * expected[-1]
    assert run.forces[:, -2] == pytest.approx(np.maximum(pad, 0.0), abs=1e-5 * pad.max())
    assert run.forces[:, -1] == pytest.approx(np.maximum(cell, 0.0), abs=1e-5 * cell.max())


@pytest.mark.parametrize("balls", [1, 3])
def test_the_order_of_hammer_and_cap_does_not_matter(balls):
    row = BALLS[-balls:]
    one, other = (row.with_cap("15 g", **PAD).struck_by(**HAMMER),
                  row.struck_by(**HAMMER).with_cap("15 g", **PAD))  # fmt: skip
    assert one == other


def test_the_pulse_in_a_window_and_ensembles_agree_with_the_run():
    chain = hc.Chain.uniform(6, exponent=[1.5, 1.5, 1.0, 1.5, 1.0])
    expected = hc.simulate(chain, rtol=1e-10).pulse().velocity
    assert hc.propagate(chain).velocity == pytest.approx(expected, rel=1e-6)
    many = hc.propagate_many([chain, chain]).velocity
    assert many[1] == pytest.approx(expected, rel=1e-6)


def test_a_pad_conserves_energy_under_gravity_and_precompression():
    chain = hc.Chain.uniform(
        5, exponent=[1.5, 1.0, 1.5, 1.5], gravity=0.01, precompression=0.1,
        left_wall=hc.Wall(), right_wall=hc.Wall(),
    )  # fmt: skip
    budget = hc.simulate(chain, until=60.0, rtol=1e-11).budget()
    assert np.abs(budget.residual()).max() < 1e-7


@pytest.mark.parametrize("balls", [1, 3])
def test_files_and_units_keep_a_pad(balls, tmp_path):
    chain = BALLS[-balls:].with_cap("15 g", **PAD).struck_by(**HAMMER)
    (tmp_path / "chain.toml").write_text(chain_as_toml(chain))
    assert hc.load_chain(tmp_path / "chain.toml") == chain
    scales = hc.Scales.of(chain)
    back = scales.to_si(scales.to_scaled(chain))
    assert back.contact_exponents.tolist() == chain.contact_exponents.tolist()
    assert back.stiffness == pytest.approx(chain.stiffness, rel=1e-12)


def test_a_chain_file_describes_a_pad():
    table = {
        "diameters": "10 mm", "beads": 3, "materials": "steel-52100",
        "right_wall": {"stiffness": "20 kN/mm", "exponent": 1},
        "cap": {"mass": "15 g", **PAD}, "struck_by": [HAMMER],
    }  # fmt: skip
    expected = BALLS.with_cap("15 g", **PAD).struck_by(**HAMMER)
    assert chain_from({"chain": table}) == expected
    cap = {"mass": "15 g", "stiffness": "1 kN/mm"}
    listed = table | {"exponent": [1.5, 1.5, 1], "cap": cap}
    assert chain_from({"chain": listed}) == expected
    with pytest.raises(hc.InputError, match="cap also has exponent: omit one"):
        chain_from({"chain": table | {"exponent": [1.5, 1.5, 1]}})


def test_walls_strikers_and_laws_of_spheres_are_not_those_of_the_pad():
    chain = BALLS[:2].with_cap("15 g", **PAD)
    walled = chain.replace(right_wall=hc.Wall("2e10 N/m^1.5"))
    assert walled.contact_exponents.tolist() == [1.5, 1.5, 1.0, 1.5]
    elastic = hc.Wall("20 kN/mm", exponent=1, loss=hc.Elastic())
    yielding = chain.replace(loss=hc.ElasticPlastic(), right_wall=elastic)
    assert [type(each).__name__ for each in yielding.contact_losses[1:]] == [
        "ElasticPlastic", "Elastic", "Elastic",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("build", "said"),
    [
        (lambda: BALLS.with_cap("15 g", exponent=1), "give stiffness in N/m, or"),
        (lambda: BALLS.with_cap("15 g", stiffness="1 kN/mm"), "this unit have exponent = 1"),
        (lambda: BALLS.with_cap("15 g", stiffness=1e6, exponent=0.9), "at least 1 and at most 50"),
        (lambda: hc.Chain.uniform(4, exponent=[1, 1, 1]), "all 3 contacts have the exponent 1"),
        (lambda: hc.Chain.uniform(4, exponent=1), "must be above 1"),
    ],
)
def test_springs_without_a_stiffness_and_rows_of_springs_are_rejected(build, said):
    with pytest.raises(hc.InputError, match=said.replace("^", r"\^")):
        build()


def test_pads_at_contacts_keep_the_stiffness_of_the_others():
    pad = hc.Pad("1 kN/mm")
    chain = BALLS.with_contacts({2: pad}).struck_by(**HAMMER)
    assert chain.contact_exponents.tolist() == [1.5, 1.5, 1.5, 1.0, 1.0]
    plain = BALLS.struck_by(**HAMMER)
    assert chain.stiffness == pytest.approx([*plain.stiffness[:2], 1e6], rel=1e-15)
    times = np.linspace(0.0, 1e-3, 301)
    run = hc.simulate(chain, times=times, rtol=1e-10)
    expected = by_scipy(chain, times)
    force = np.maximum(1e6 * (expected[2] - expected[3]), 0.0)
    assert run.forces[:, -2] == pytest.approx(force, abs=1e-5 * force.max())


def test_pads_in_chain_files():
    table = {
        "diameters": "10 mm", "materials": "steel-52100", "beads": 3,
        "right_wall": {"stiffness": "20 kN/mm", "exponent": 1},
        "with_contacts": [{"shape": "pad", "stiffness": "1 kN/mm", "contacts": [2]}],
    }  # fmt: skip
    chain = chain_from({"chain": table})
    assert chain == BALLS.with_contacts({2: hc.Pad(1e6)})
    table["with_contacts"][0]["stiffness"] = "1 kg"
    with pytest.raises(hc.InputError, match="stiffness"):
        chain_from({"chain": table})
