"""The table of quantities: consistent, read everywhere, and extended by one row."""

import dataclasses
import importlib
import json
import os
import pkgutil
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import hertzchain as hc
from hertzchain.chain.conversion import CHAIN_SCALES
from hertzchain.kernels import forces, state_layout
from hertzchain.pulse.quantities import (
    BEAD_QUANTITIES,
    FINAL_QUANTITIES,
    LARGEST_QUANTITIES,
    QUANTITIES,
    RUN_QUANTITIES,
    SENSOR_QUANTITIES,
    TIME,
    WALL_QUANTITIES,
    WAVE_QUANTITIES,
)
from hertzchain.simulation.state import ACCUMULATOR_SCALES, ROW_SCALES
from hertzchain.units import _parse

ROWS = [
    *QUANTITIES.values(), *WALL_QUANTITIES.values(), *RUN_QUANTITIES.values(),
    *WAVE_QUANTITIES.values(), *BEAD_QUANTITIES.values(), TIME,
    *SENSOR_QUANTITIES.values(), *FINAL_QUANTITIES.values(),
    *LARGEST_QUANTITIES.values(),
]  # fmt: skip
SCALES = hc.Scales(radius=5e-3, mass=4e-3, velocity=0.7, length=11e-6)
# Its unit of force, M V^2 / L.
FORCE = 4e-3 * 0.7**2 / 11e-6
TAPER = hc.Chain.tapered("forward-exponential", 0.03, beads=20)
RECIPES = Path(__file__).parents[1] / "docs" / "how-to" / "extend_theories.md"
PACKAGE = Path(hc.__file__).parent


def dimensions(scale):
    """Powers of length, mass and time of a unit of `Scales`, by changing one of them at a time."""
    changed = {
        "m": {"radius": 2.0, "length": 2.0, "velocity": 2.0},
        "kg": {"mass": 2.0},
        "s": {"velocity": 0.5},
    }
    one = dict.fromkeys(("radius", "mass", "velocity", "length"), 1.0)
    return tuple(float(np.log2(hc.Scales(**one | each).unit(scale))) for each in changed.values())


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row.per} {row.name}")
def test_units_and_scales_agree(row):
    unit = row.unit.replace("J", "N*m").replace(" ", "*")
    powers = (0.0, 0.0, 0.0) if unit == "1" else _parse(unit).powers
    assert dimensions(row.scale) == powers


def test_rows_are_complete():
    for row in (*QUANTITIES.values(), *WALL_QUANTITIES.values(), *RUN_QUANTITIES.values()):
        assert row.description
        assert row.label
    for row in WALL_QUANTITIES.values():
        assert hasattr(hc.WallForce, row.attribute) or row.attribute in {
            field.name for field in dataclasses.fields(hc.WallForce)
        }


@pytest.mark.parametrize("scale", ["speed", "force/", "force velocity", "force*", "time^x", "*1"])
def test_an_invalid_scale_is_an_error(scale):
    with pytest.raises(hc.InputError, match="a scale is a product of powers of 1, radius, mass"):
        SCALES.unit(scale)


def test_units_of_scales():
    assert SCALES.unit("1") == 1.0
    assert SCALES.unit("force/velocity^1.5") == SCALES.force / SCALES.velocity**1.5
    assert SCALES.unit("1/time") == 1.0 / SCALES.time
    assert SCALES.unit("mass*radius^-2e0") == pytest.approx(4e-3 / 25e-6, rel=1e-14)


def test_rows_of_a_state_have_units():
    sizes = {
        "clock": state_layout.CLOCK_SIZE, "flights": state_layout.FLIGHT_ROWS, "peaks": 2,
        "crossings": state_layout.CROSSING_ROWS,
        "walls": state_layout.WALL_ROWS, "completion": state_layout.COMPLETION_ROWS,
    }  # fmt: skip
    assert {name: len(units) for name, units in ROW_SCALES.items()} == sizes
    assert len(ACCUMULATOR_SCALES) == forces.ACCUMULATORS


def test_units_of_all_fields_can_be_evaluated():
    """Of every dataclass in the package that names the units of its fields."""
    found = 0
    for module in pkgutil.walk_packages([str(PACKAGE)], "hertzchain."):
        if module.name.endswith("__main__"):
            continue
        for item in vars(importlib.import_module(module.name)).values():
            if isinstance(item, type) and dataclasses.is_dataclass(item):
                for field in dataclasses.fields(item):
                    unit = field.metadata.get("scale", ())
                    for each in () if callable(unit) else [unit] if isinstance(unit, str) else unit:
                        assert SCALES.unit(each) > 0.0
                        found += 1
    assert found > 50
    assert all(SCALES.unit(unit) > 0.0 for unit in CHAIN_SCALES.values())


@pytest.mark.parametrize(
    ("part", "units"),
    [
        (hc.Wall(stiffness=2.0, gap=0.5), {"stiffness": FORCE / 11e-6**1.5, "gap": 11e-6}),
        (hc.SineBurst(2.0, 0.3), {"amplitude": FORCE, "frequency": 0.7 / 11e-6}),
        (hc.SineBurst(2.0, 0.3, of="displacement"), {"amplitude": 11e-6}),
        (hc.StepDrive(2.0, 0.3), {"amplitude": FORCE, "rise": 11e-6 / 0.7}),
        (hc.TableDrive([0.0, 1.0], [3.0, 2.0]), {"times": 11e-6 / 0.7, "values": FORCE}),
        (hc.TableDrive([0.0, 1.0], [3.0, 2.0], of="displacement"), {"values": 11e-6}),
        (hc.Viscoelastic(0.2), {"time": 11e-6 / 0.7}),
        (hc.VelocityPower(0.2, 1.6), {"gamma": FORCE / 0.7**1.6}),
        (hc.Dashpot(0.2), {"gamma": FORCE / 0.7}),
        (hc.Restitution(0.9), {}),
    ],
)
def test_parts_of_a_chain_are_converted(part, units):
    real = SCALES.to_si(part)
    for name, unit in units.items():
        scaled = np.asarray(getattr(part, name))
        np.testing.assert_allclose(getattr(real, name), unit * scaled, rtol=1e-14)
    assert repr(SCALES.to_scaled(real)) == repr(part)


@pytest.mark.parametrize("method", ["propagate", "local_rate", "bca"])
def test_every_quantity_is_converted_by_its_scale(method):
    scaled = getattr(hc, method)(TAPER)
    real = SCALES.to_si(scaled)
    assert real.columns().keys() == scaled.columns().keys()
    for name, values in scaled.columns().items():
        factor = SCALES.unit(QUANTITIES[name].scale)
        np.testing.assert_allclose(real.column(name), factor * values, rtol=1e-13)
        assert real.unit(name) == QUANTITIES[name].unit
    speed = SCALES.unit("radius/time") * scaled.speed
    np.testing.assert_allclose(real.speed, speed, rtol=1e-13)


def test_speed_of_the_pulse_is_that_of_the_solitary_wave():
    """Far from the struck bead: 0.9075 (k/m)^(2/5) v^(1/5) beads per time, 10 mm apart."""
    chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=150, velocity=0.4)
    pulse = hc.propagate(chain)
    per_time = (chain.stiffness[0] / chain.masses[0]) ** 0.4 * pulse.velocity[119] ** 0.2
    expected = 10e-3 * 0.9074700784 * per_time
    assert pulse.column("speed")[119] == pytest.approx(expected, rel=1e-7)
    assert hc.propagate_many([chain]).column("speed")[0, 119] == pulse.speed[119]
    assert pulse.plot("speed").lines[0].get_ydata()[119] == pulse.speed[119]
    assert pulse.unit("speed") == "m/s"
    assert "speed" not in pulse.columns()


def test_speeds_of_rows_of_radii():
    table = hc.propagate_many([[2.0, 4.0, 5.0], [1.0, 1.0]])
    for pulse, speeds in zip(table, table.column("speed"), strict=True):
        np.testing.assert_allclose(speeds[: len(pulse.speed)], pulse.speed, rtol=1e-14)


def test_errors_of_speed_follow_from_those_of_residence():
    comparison = hc.bca(TAPER).compare(hc.propagate(TAPER))
    expected = 1.0 / (1.0 + comparison.errors("residence")) - 1.0
    np.testing.assert_allclose(comparison.errors("speed"), expected, rtol=1e-9)
    drawn = comparison.plot("speed").lines[0].get_ydata()
    np.testing.assert_allclose(drawn, 100.0 * expected[1:], rtol=1e-9)


def test_speed_needs_residence_times():
    theory = hc.modified_bca(hc.Chain.tapered("forward-linear", 0.005, beads=9))
    with pytest.raises(
        hc.InputError, match="modified BCA does not predict speed, only velocity, mom"
    ):
        theory.plot("speed")


def test_results_whose_fields_have_no_units_are_not_converted():
    run = hc.simulate(hc.Chain.uniform(5), times=5)
    for result in (run.budget(), run.pulse().compare(run.pulse()), 3.0):
        with pytest.raises(hc.InputError, match="cannot convert .*convert the run and compute"):
            SCALES.to_si(result)


def test_a_table_of_pulses_has_the_quantities_of_its_pulses():
    chains = [TAPER, hc.Chain.uniform(9), hc.Chain.tapered("backward-linear", 0.3, beads=12)]
    table = hc.propagate_many(chains)
    dataset = table.to_xarray()
    for row, (pulse, chain) in enumerate(zip(table, chains, strict=True)):
        assert table.columns().keys() == pulse.columns().keys()
        for name, values in pulse.columns().items():
            count = QUANTITIES[name].count(chain.beads)
            np.testing.assert_array_equal(table.column(name)[row, :count], values)
            np.testing.assert_array_equal(dataset[name][row, :count], values)
            assert np.isnan(table.column(name)[row, count:]).all()
    assert table.column("velocity_error") is None


@pytest.mark.long
@pytest.mark.parametrize("name", QUANTITIES)
def test_every_quantity_can_be_plotted(name):
    estimated = QUANTITIES[name].estimate
    pulse = hc.disorder(TAPER, scatter=0.01) if estimated else hc.propagate(TAPER)
    axes = pulse.plot(name)
    assert axes.get_ylabel() == QUANTITIES[name].label
    # The last bead of a free end has a symbol of its own.
    drawn = {k: y for line in axes.lines for k, y in zip(*line.get_data(), strict=True)}
    assert [drawn[k] for k in sorted(drawn)] == pulse.column(name).tolist()
    real = SCALES.to_si(pulse).plot(name)
    unit = QUANTITIES[name].unit
    assert real.get_ylabel() == QUANTITIES[name].label + ("" if unit == "1" else f" [{unit}]")


def test_a_table_of_pulses_is_no_pulse():
    table = hc.propagate_many([TAPER])
    with pytest.raises(hc.InputError, match="reference must be a Pulse, got PulseTable"):
        hc.bca(TAPER).compare(table)


def test_errors_of_comparisons_name_what_helps():
    pulse = hc.propagate(TAPER)
    with pytest.raises(hc.InputError, match=r"got Run.*; that of a run is run\.pulse\(\)"):
        pulse.compare(hc.simulate(TAPER, until=5.0))
    with pytest.raises(hc.InputError, match="did you mean 'velocity'") as unknown:
        hc.bca(TAPER).compare(pulse).worst("veloc")
    assert "velocity_" not in str(unknown.value)


# Checks of a copy of the package with an additional quantity.
EVERYWHERE = """
import json, sys
import numpy as np
import hertzchain as hc
from hertzchain.plotting.pulses import plot_pulses
from hertzchain.plotting.sweeps import plot_sweep
from hertzchain.store.results import pulses_as_csv, pulses_as_json

name = sys.argv[1]
chain = hc.Chain.tapered("forward-exponential", 0.05, beads=20)
pulse, other = hc.bca(chain), hc.bca(chain, restitution=0.9)
values = getattr(pulse, name)
np.testing.assert_array_equal(values, pulse.column(name))
np.testing.assert_array_equal(pulse.to_dataframe()[name].to_numpy()[:19], values)
assert name in str(other.compare(pulse)) and other.compare(pulse).worst(name) > 0.0
variable = pulse.to_xarray()[name]
table = hc.PulseTable(
    np.tile(chain.radii, (2, 1)), np.array([20, 20]), np.array([1.5, 1.5]),
    *(np.tile(column, (2, 1)) for column in (
        pulse.velocity, pulse.arrival, pulse.arrival, pulse.peak_overlap, pulse.residence)),
    {}, **({name: np.tile(values, (2, 1))} if sys.argv[2:] else {}),
)
np.testing.assert_array_equal(table.column(name)[1], values)
np.testing.assert_array_equal(table.to_xarray()[name][1], values)
np.testing.assert_array_equal(table[1].column(name), values)
assert json.loads(pulses_as_json([pulse]))["pulses"][0][name] == values.tolist()
assert name in pulses_as_csv([pulse]).splitlines()[0].split(",")
scales = hc.Scales(radius=5e-3, mass=4e-3, velocity=0.7, length=11e-6)
real = scales.to_si(pulse)
kept = hc.sweep({
    "chain": {"taper": "forward-exponential", "beads": 20}, "axes": {"rate": [0.02, 0.05]},
    "sweep": {"methods": ["bca", "local-rate"], "keep": [name], "errors": [name]},
})
print(json.dumps({
    "values": values.tolist(), "real": real.column(name).tolist(), "unit": real.unit(name),
    "attributes": variable.attrs, "dims": variable.dims,
    "labels": [plot_pulses([real], name).get_ylabel(), plot_sweep(kept, rate=0.05).get_ylabel()],
    "kept": kept[name].sel(approach="bca", rate=0.05).values.tolist(),
    "errors": kept["worst_error_of_" + name].sel(approach="local-rate").values.tolist(),
}))
"""


@pytest.fixture
def run_copy(tmp_path):
    """Change files in a copy of the package; run Python, or its command line, with the copy."""
    shutil.copytree(PACKAGE, tmp_path / "hertzchain")
    environment = {**os.environ, "PYTHONPATH": str(tmp_path), "MPLBACKEND": "Agg"}

    def change(path, old, new):
        file = tmp_path / "hertzchain" / path
        text = file.read_text("utf-8")
        assert text.count(old) == 1
        file.write_text(text.replace(old, new), "utf-8")

    def run(*arguments):
        command = [sys.executable, *arguments]
        done = subprocess.run(
            command, capture_output=True, text=True, env=environment, cwd=tmp_path, check=False
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    return change, run


LAST_ROW = """            values="positive after the strikers", estimate=True,
        ),
"""


@pytest.mark.long
def test_the_recipe_for_a_quantity_needs_one_row(run_copy):
    change, run = run_copy
    section = RECIPES.read_text("utf-8").split("## Add a quantity\n")[1].split("\n## ")[0]
    row = "".join(re.findall(r"^\+( .*\n)", section, re.M))
    assert row.startswith("        Quantity(\n")
    change("pulse/quantities.py", LAST_ROW, LAST_ROW + row)
    found = json.loads(run("-c", EVERYWHERE, "stored_energy"))
    # The head-on collision of two beads, one of them at rest: at the largest overlap both move
    # with the velocity of their centre of mass, and the rest of the energy is in the contact.
    chain = hc.Chain.tapered("forward-exponential", 0.05, beads=20)
    m, v = chain.masses, hc.bca(chain).velocity
    expected = 0.5 * m[:-1] * m[1:] / (m[:-1] + m[1:]) * v[:-1] ** 2
    np.testing.assert_allclose(found["values"], expected, rtol=1e-13)
    energy = 4e-3 * 0.7**2
    np.testing.assert_allclose(found["real"], energy * expected, rtol=1e-13)
    assert (found["unit"], found["dims"]) == ("J", ["contact"])
    description = "energy stored in the contact at its largest overlap"
    assert found["attributes"] == {"long_name": description, "symbol": "U"}
    assert found["labels"] == ["stored energy $U_k$ [J]", "stored energy $U_k$"]
    assert found["kept"] == found["values"]
    law = hc.local_rate(chain)
    energy = law.peak_force * law.peak_overlap / 2.5
    assert found["errors"][1] == pytest.approx(np.abs(energy / expected - 1.0).max(), rel=1e-12)

    pulse = ("-m", "hertzchain", "pulse", "--taper", "forward-exponential", "--rate", "0.05",
             "--beads", "20", "--method", "bca")  # fmt: skip
    shown = run(*pulse, "--method", "local-rate", "--quantity", "stored_energy")
    assert shown.startswith("stored_energy: forward-exponential")
    assert "stored_energy" in run("-m", "hertzchain", "pulse", "--help")
    run(*pulse, "--quantity", "stored_energy", "--csv", "--plot", "energy.svg")


def test_a_quantity_that_a_theory_gives_needs_a_row_and_the_theory(run_copy):
    change, run = run_copy
    row = """        Quantity(
            "transfer", "f", "part of the energy that passes to the next bead",
            unit="1", scale="1", label="transfer $f_k$", per="contact",
        ),
"""
    change("pulse/quantities.py", LAST_ROW, LAST_ROW + row)
    change("theory/bca.py", "        peak_overlap=overlap,\n",
           "        peak_overlap=overlap,\n"
           "        transfer=(m * velocity**2)[1:] / (m * velocity**2)[:-1],\n")  # fmt: skip
    found = json.loads(run("-c", EVERYWHERE.replace(
        '["bca", "local-rate"]', '["bca"]').replace(', "errors": [name]', "").replace(
        '"errors": kept["worst_error_of_" + name].sel(approach="local-rate").values.tolist(),', ""),
        "transfer", "stored"))  # fmt: skip
    energy = hc.bca(hc.Chain.tapered("forward-exponential", 0.05, beads=20)).energy
    np.testing.assert_allclose(found["values"], energy[1:] / energy[:-1], rtol=1e-13)
    assert found["real"] == found["values"]
    assert found["labels"] == ["transfer $f_k$"] * 2


def test_sweeps_keep_the_quantities_of_walls():
    found = hc.sweep({
        "chain": {"taper": "uniform", "right_wall": {}},
        "axes": {"beads": [4, 6]},
        "sweep": {"methods": ["simulate"], "keep": list(WALL_QUANTITIES)},
    })  # fmt: skip
    assert isinstance(found, xr.Dataset)
    wall = hc.simulate(hc.Chain.uniform(6).replace(right_wall=hc.Wall()), times=0).wall_force()
    for name, row in WALL_QUANTITIES.items():
        assert found[name].attrs == {"long_name": row.description}
        assert found[name].sel(beads=6).item() == getattr(wall, row.attribute)
