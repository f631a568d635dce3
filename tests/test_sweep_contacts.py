"""Sweeps over the stiffness of single contacts and over the mass of one bead."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from scipy.integrate import solve_ivp

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


# Some of these springs are too stiff to replace a contact.
@pytest.mark.filterwarnings("ignore:.*the spring of a wall is too stiff")
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


@pytest.mark.filterwarnings("ignore:.*the spring of a wall is too stiff")
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
    with pytest.raises(hc.InputError, match="such as N/m, N/mm, kN/mm, got 'N/m.1.5'"):
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


def energy_between(masses, before, after, until):
    """Energy of the beads and contacts between two contacts, integrated by SciPy."""
    count = len(masses)
    scaled = hc.Chain.uniform(count)
    mass, stiffness = scaled.masses[0] * masses, scaled.stiffness[0]

    def slope(_, state):
        forces = stiffness * np.maximum(state[: count - 1] - state[1:count], 0.0) ** 1.5
        net = np.concatenate(([0.0], forces)) - np.concatenate((forces, [0.0]))
        return np.concatenate((state[count:], net / mass))

    start = np.zeros(2 * count)
    start[count] = 1.0
    end = solve_ivp(slope, (0.0, until), start, method="DOP853", rtol=1e-10, atol=1e-12).y[:, -1]
    overlaps = np.maximum(end[before - 1 : after] - end[before : after + 1], 0.0)
    # Half of the energy of a contact belongs to each of its beads.
    stored = np.convolve(0.4 * stiffness * overlaps**2.5, [0.5, 0.5], "valid")
    kinetic = 0.5 * mass[before:after] * end[count + before : count + after] ** 2
    return (kinetic + stored).sum()


def test_an_axis_sets_a_range_of_items(tmp_path):
    spec = {
        "chain": {"taper": "uniform", "masses": 1.0, "beads": 40},
        "axes": {"masses.19-21": [0.5, 2.0], "masses.20": [1.0, 3.0]},
        "sweep": {"at": [30]},
    }
    found = hc.sweep(spec, tmp_path / "all")
    assert found.velocity.dims == ("masses_19_21", "masses_20", "approach", "bead")
    for i, several in enumerate([0.5, 2.0]):
        for j, middle in enumerate([1.0, 3.0]):
            chain = hc.Chain.uniform(40)
            masses = chain.masses.copy()
            masses[18:21] = several, middle, several
            expected = hc.propagate(chain.replace(masses=masses)).velocity[29]
            assert found.velocity[i, j, 0, 0] == pytest.approx(expected, rel=1e-12)
    # The store continues with the same specification, also from its shards.
    parts = [tmp_path / "a", tmp_path / "b"]
    for k, part in enumerate(parts, start=1):
        hc.sweep(spec, part, shard=(k, 2))
    merged, missing = hc.merge_sweeps(parts, tmp_path / "merged")
    assert missing == 0
    assert (merged.velocity == hc.sweep(spec, tmp_path / "all").velocity).all()
    axes = hc.plot_sweep(found, **{"masses.20": 1.0})
    assert axes.get_xlabel() == "mass of beads 19 to 21"
    plt.close(axes.figure)


@pytest.mark.parametrize(("axes", "message"), [
    ({"masses.19-41": [1.0, 2.0]}, "there are no items 19-41 in masses, a list of 40"),
    ({"masses.0-3": [1.0, 2.0]}, "there are no items 0-3"),
    ({"masses.21-19": [1.0, 2.0]}, "the range 21-19 of items must begin with the smaller"),
    ({"masses.20": [1.0], "masses.19-21": [2.0]}, "would undo axes.masses.20"),
    ({"masses.15-20": [1.0], "masses.19-21": [2.0]}, "would undo axes.masses.15-20"),
    ({"radii.19-21": [1.0, 2.0]}, "has no list radii"),
])  # fmt: skip
def test_ranges_of_items_that_do_not_exist_or_overlap_are_errors(axes, message):
    with pytest.raises(hc.InputError, match=message):
        hc.sweep({"chain": {"taper": "uniform", "masses": 1.0, "beads": 40}, "axes": axes})


def test_sweeps_keep_the_energy_that_a_reflection_lacks():
    contacts = "25-55"
    found = hc.sweep({
        "chain": {"taper": "uniform", "masses": 1.0, "beads": 80},
        "axes": {"masses.40": [5.0, 50.0]},
        "sweep": {"methods": ["simulate"], "keep": [
            f"reflection.{name}@{contacts}"
            for name in ("reflected_energy", "transmitted_energy", "kept_energy", "kept_momentum")
        ]},
        "method": {"until": 95.0},
    }).isel(approach=0)  # fmt: skip
    reflected, passed = found.reflected_energy_25_55, found.transmitted_energy_25_55
    kept = found.kept_energy_25_55
    assert float(reflected[0] + passed[0] + kept[0]) == pytest.approx(1.0, abs=1e-6)
    # The coefficients of the heavy bead are not complete, and this says by how much.
    assert found.incomplete.values.tolist() == [0, 1]
    assert np.isnan(reflected[1])
    assert 0.05 < float(kept[1]) < 0.1
    masses = np.ones(80)
    masses[39] = 5.0
    inside = energy_between(masses, 25, 55, 95.0)
    # The leading pulse has 99.4% of the energy 1/2 of the impact.
    assert float(kept[0]) == pytest.approx(inside / (0.994 * 0.5), rel=0.01)
