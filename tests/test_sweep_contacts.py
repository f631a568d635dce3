"""Sweeps over the stiffness of single contacts and over the mass of one bead."""

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.sweeps.specification import read_specification, specification_from_json

BALLS = {"diameters": "10 mm", "materials": "steel-52100", "beads": 4, "velocity": "0.1 m/s"}
CELL = BALLS | {"right_wall": {"stiffness": "20 kN/mm", "exponent": 1}}
KEEP = {"methods": ["simulate"], "keep": ["wall_peak_force"]}
VALUES = ["2 kN/mm", "20 kN/mm"]


def peaks(chain):
    return [
        hc.simulate(chain.replace(right_wall=hc.Wall(value, exponent=1))).wall_force().peak
        for value in VALUES
    ]


ROW = hc.Chain.from_materials(diameters="10 mm", materials="steel-52100", beads=4,
                              velocity="0.1 m/s")  # fmt: skip


@pytest.mark.parametrize(
    "chain", [CELL, ROW.replace(right_wall=hc.Wall("20 kN/mm", exponent=1))], ids=["table", "chain"]
)
def test_the_unit_of_a_stiffness_follows_from_the_exponent_of_the_wall(chain):
    axes = {"right_wall.stiffness": VALUES}
    found = hc.sweep({"chain": chain, "axes": axes, "sweep": KEEP})
    assert found.stiffness.values.tolist() == [2.0, 20.0]
    assert found.stiffness.units == "kN/mm"
    forces = found.wall_peak_force.sel(approach="simulate")
    assert forces.values == pytest.approx(peaks(ROW), rel=1e-9)


def test_plain_numbers_are_in_newtons_per_metre():
    axes = {"right_wall.stiffness": {"geomspace": [1e6, 1e8, 3]}}
    found = hc.sweep({"chain": CELL, "axes": axes, "sweep": KEEP})
    assert found.stiffness.units == "N/m"
    assert hc.plot_sweep(found, "wall_peak_force").get_xlabel() == "right wall stiffness [N/m]"


@pytest.mark.parametrize(
    ("path", "more", "axes", "unit"),
    [
        ("right_wall.stiffness", {"right_wall": {"exponent": 2}}, {}, "N/m^2"),
        ("right_wall.stiffness", {"right_wall": {}}, {}, "N/m^1.5"),
        ("cap.stiffness", {"cap": {"mass": 0.01, "exponent": 1}}, {}, "N/m"),
        ("stiffness", {}, {}, "N/m^1.5"),
        ("stiffness", {}, {"exponent": [1.5, 2.0]}, None),
        ("right_wall.stiffness", {"right_wall": {}}, {"right_wall.exponent": [1.0, 1.5]}, None),
        ("stiffness", {"exponent": [1.5, 2.0, 1.5]}, {}, None),
    ],
)
def test_units_of_plain_numbers(path, more, axes, unit):
    given = {"chain": BALLS | more, "axes": {path: [1e6, 2e6]} | axes}
    spec = read_specification(given)
    assert spec.axes[0].si_unit == unit
    assert specification_from_json(spec.as_json()).axes[0].si_unit == unit


def test_the_unit_of_another_exponent_is_rejected():
    hertz = BALLS | {"right_wall": {"stiffness": 1e9}}
    with pytest.raises(hc.InputError, match="contacts with this unit have exponent = 1"):
        hc.sweep({"chain": hertz, "axes": {"right_wall.stiffness": VALUES}, "sweep": KEEP})
    values = ["1 N/m^1.5", "2 N/m^1.5"]
    with pytest.raises(hc.InputError, match="such as N/m, got 'N/m.1.5'"):
        hc.sweep({"chain": CELL, "axes": {"right_wall.stiffness": values}, "sweep": KEEP})


def test_a_sweep_over_the_stiffness_of_a_pad():
    cap = {"mass": "15 g", "stiffness": "1 kN/mm", "exponent": 1}
    found = hc.sweep(
        {"chain": CELL | {"cap": cap}, "axes": {"cap.stiffness": VALUES}, "sweep": KEEP}
    )
    row = ROW.replace(right_wall=hc.Wall("20 kN/mm", exponent=1))
    expected = [
        hc.simulate(row.with_cap("15 g", stiffness=value, exponent=1)).wall_force().peak
        for value in VALUES
    ]
    assert found.wall_peak_force.values.ravel() == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("more", [{}, {"cap": {"mass": 1.0, "stiffness": 1.0}}])
def test_one_mass_for_all_beads_can_vary_at_one_of_them(more):
    chain = {"taper": "uniform", "beads": 6, "masses": 1.0} | more
    spec = {"chain": chain, "axes": {"masses.3": [0.5, 2.0]}, "sweep": {"methods": ["simulate"]}}
    found = hc.sweep(spec).velocity.sel(approach="simulate")
    count = 7 if more else 6
    for mass in (0.5, 2.0):
        masses = np.ones(count)
        masses[2] = mass
        row = hc.Chain.uniform(6)
        row = (row.with_cap(1.0, stiffness=1.0) if more else row).replace(masses=masses)
        expected = hc.simulate(row).pulse().velocity
        assert found.sel(masses_3=mass).values == pytest.approx(expected, rel=1e-9)


def test_masses_that_are_not_given_cannot_vary_at_one_bead():
    with pytest.raises(hc.InputError, match="no list masses: give masses, one for all beads or"):
        hc.sweep({"chain": {"taper": "uniform", "beads": 6}, "axes": {"masses.3": [0.5]}})
