import json
import math
import subprocess
import sys
import time
import tracemalloc

import numpy as np
import pytest
import xarray as xr
from figure_texts import legend_texts

import hertzchain as hc
from hertzchain.plotting.sweeps import plot_sweep
from hertzchain.store import sweep_export
from hertzchain.store.sweep_export import export_sweep, tables_of
from hertzchain.store.sweep_store import FAILED
from hertzchain.sweeps import axes as axes_module
from hertzchain.sweeps import timing
from hertzchain.sweeps.axes import Axis
from hertzchain.sweeps.batches import Stopped, _Batch, run_batch
from hertzchain.sweeps.plan import Plan, check_plan
from hertzchain.sweeps.specification import read_specification, specification_from_json
from hertzchain.sweeps.sweep import differences, estimate

FORWARD = {"taper": "forward-exponential", "beads": 40}
RATES = [0.02, 0.05, 0.08]
BALLS = {"radii": "5 mm", "beads": 4, "materials": "brass", "velocity": "2 cm/s"}


def swept(chain, axes, **settings):
    method = settings.pop("method", {})
    return hc.sweep({"chain": chain, "axes": axes, "sweep": settings, "method": method})


def test_every_point_is_what_the_methods_give_alone():
    methods = ["propagate", "simulate", "bca", "local-rate"]
    found = swept(FORWARD, {"rate": RATES, "beads": [20, 30]}, methods=methods,
                  keep=["velocity", "energy", "peak_force", "arrival"])  # fmt: skip
    assert found.velocity.dims == ("rate", "beads", "approach", "bead")
    for rate in RATES:
        for beads in (20, 30):
            chain = hc.Chain.tapered("forward-exponential", rate, beads=beads)
            point = found.sel(rate=rate, beads=beads)
            pulses = {
                "propagate": hc.propagate(chain), "bca": hc.bca(chain),
                "simulate": hc.simulate(chain, times=0).pulse(), "local-rate": hc.local_rate(chain),
            }  # fmt: skip
            for by, pulse in pulses.items():
                one = point.sel(approach=by)
                # Batches of simulations are integrated by another method, `simulate_many`; both
                # have a tolerance of 1e-13.
                near = 1e-12 if by == "simulate" else 1e-15
                np.testing.assert_allclose(one.velocity[:beads], pulse.velocity, rtol=near)
                np.testing.assert_allclose(one.energy[:beads], pulse.energy, rtol=4.0 * near)
                np.testing.assert_allclose(one.arrival[:beads], pulse.arrival, rtol=near)
                force = one.peak_force[: beads - 1]
                np.testing.assert_allclose(force, pulse.peak_force, rtol=4.0 * near)
                assert np.isnan(one.velocity[beads:]).all()
    assert (found.status == 1).all()


def test_beads_are_chosen_by_number_or_the_last():
    axes = {"beads": [10, 20]}
    every = swept(FORWARD | {"rate": 0.05}, axes, keep=["velocity", "residence"])
    some = swept(FORWARD | {"rate": 0.05}, axes, keep=["velocity", "residence"], at=[2, 15])
    last = swept(FORWARD | {"rate": 0.05}, axes, keep=["velocity", "residence"], at="last")
    np.testing.assert_array_equal(some.bead, [2, 15])
    np.testing.assert_array_equal(some.velocity, every.velocity.sel(bead=[2, 15]))
    assert last.velocity.dims == ("beads", "approach")
    for beads in (10, 20):
        one, whole = last.sel(beads=beads), every.sel(beads=beads)
        assert one.velocity.item() == whole.velocity.sel(bead=beads).item()
        assert one.residence.item() == whole.residence.sel(contact=beads - 1).item()


def test_errors_are_measured_from_the_reference():
    found = swept(FORWARD, {"rate": RATES}, methods=["bca", "propagate"], errors=["velocity"],
                  reference="propagate")  # fmt: skip
    bca, exact = found.velocity.sel(approach="bca"), found.velocity.sel(approach="propagate")
    expected = (bca - exact) / exact
    np.testing.assert_allclose(
        found.relative_error_of_velocity.sel(approach="bca"), expected, rtol=1e-12, atol=1e-15
    )
    worst = np.abs(expected.values[:, 1:]).max(axis=1)
    np.testing.assert_allclose(found.worst_error_of_velocity.sel(approach="bca"), worst, rtol=1e-12)
    assert (found.worst_error_of_velocity.sel(approach="propagate") == 0.0).all()


def test_zip_and_points_run_together():
    axes = {"taper": ["forward-linear", "backward-linear"], "rate": [0.01, 0.3]}
    zipped = swept({"beads": 20}, axes, combine="zip")
    assert zipped.velocity.dims == ("point", "approach", "bead")
    for i, (taper, rate) in enumerate(zip(*axes.values(), strict=True)):
        pulse = hc.propagate(hc.Chain.tapered(taper, rate, beads=20))
        np.testing.assert_array_equal(zipped.velocity[i, 0], pulse.velocity)
    rows = [dict(zip(axes, row, strict=True)) for row in zip(*axes.values(), strict=True)]
    points = hc.sweep({"chain": {"beads": 20}, "points": rows})
    xr.testing.assert_equal(points, zipped)


def test_points_come_from_a_csv_file(tmp_path):
    (tmp_path / "points.csv").write_text("rate,beads\n0.02,10\n0.05,20\n")
    (tmp_path / "sweep.toml").write_text(
        'points = "points.csv"\n[chain]\ntaper = "forward-exponential"\n'
    )
    found = hc.sweep(tmp_path / "sweep.toml")
    assert found.rate.values.tolist() == [0.02, 0.05]
    assert found.beads.values.tolist() == [10, 20]


def test_real_chains_walls_and_losses():
    chain = {
        "radii": 5e-3, "beads": 8, "materials": "steel-52100", "velocity": 0.05,
        "loss": {"law": "restitution", "coefficient": 0.9}, "right_wall": {"rigid": True},
    }  # fmt: skip
    axes = {
        "loss": {"coefficient": [0.8, 1.0]},
        "velocity": {"linspace": [1, 5, 3], "unit": "cm/s"},
    }
    keep = ["velocity", "wall_peak_force", "wall_impulse", "wall_first_contact_impulse"]
    found = swept(chain, axes, methods=["simulate"], keep=keep, method={"until": 5e-3})
    np.testing.assert_allclose(found.chain_velocity, [1.0, 3.0, 5.0])
    assert found.chain_velocity.units == "cm/s"
    assert found.wall_peak_force.units == "N"
    one = hc.Chain.from_materials(5e-3, "steel-52100", beads=8, velocity=0.03).replace(
        loss=hc.Restitution(0.8), right_wall=hc.Wall.rigid()
    )
    wall = hc.simulate(one, times=0, until=5e-3).wall_force()
    point = found.isel(coefficient=0, chain_velocity=1, approach=0)
    assert point.wall_peak_force.item() == wall.peak
    assert point.wall_impulse.item() == wall.impulse
    assert point.wall_first_contact_impulse.item() == wall.first_contact_impulse
    assert not found.incomplete.any()


@pytest.mark.filterwarnings("ignore::hertzchain.errors.InputWarning")
def test_reflections_and_largest_velocities_are_those_of_runs():
    keep = ["reflection.reflected_energy@18-42", "kept_momentum@18-42",
            "largest_velocity@30",
            "largest_energy@ball 40"]  # fmt: skip
    found = hc.sweep({
        "chain": {"radii": [1.0] * 60, "right_wall": {"rigid": True}},
        "axes": {"radii.30": [0.5, 2.0]},
        "sweep": {"methods": ["simulate"], "keep": keep}, "method": {"until": 80.0},
    }).sel(approach="simulate")  # fmt: skip
    for i, radius in enumerate((0.5, 2.0)):
        chain = hc.Chain.uniform(60).with_defects({30: radius}).replace(right_wall=hc.Wall.rigid())
        run = hc.simulate(chain, until=80.0, times=4000)
        defect = run.reflection(18, 42)
        assert found.reflected_energy_18_42[i] == pytest.approx(defect.reflected_energy)
        assert found.kept_momentum_18_42[i] == pytest.approx(defect.kept_momentum)
        # Those that gradients locate within the steps.
        for name, bead, kept in (("velocity", 30, found.largest_velocity_30),
                                 ("energy", 40, found.largest_energy_ball_40)):  # fmt: skip
            largest = hc.gradient(chain, f"bead.largest_{name}", bead=bead, until=80.0).value
            assert kept[i] == pytest.approx(largest, rel=1e-5)
    assert found.largest_velocity_30.attrs["long_name"].endswith("in the run, bead 30")
    label = "reflected energy / incident energy, contacts 18 to 42"
    assert plot_sweep(found, "reflected_energy@18-42").get_ylabel().replace("\n", " ") == label
    assert plot_sweep(found, "largest_velocity@30").get_ylabel() == "largest velocity of bead 30"


def test_an_option_of_the_simulation_in_the_wrong_table_is_answered_with_its_table():
    with pytest.raises(hc.InputError, match=r"did you mean until of \[method\][?]"):
        hc.sweep({"chain": {"taper": "uniform"}, "axes": {"beads": [5, 9]},
                  "sweep": {"until": 20.0}})  # fmt: skip


def test_a_missing_reflection_has_a_reason():
    found = hc.sweep({
        "chain": {"taper": "uniform"}, "axes": {"beads": [20, 60]},
        "sweep": {"methods": ["simulate"], "keep": ["transmitted_energy@10-50"]},
        "method": {"until": 8.0},
    })  # fmt: skip
    assert np.isnan(found.transmitted_energy_10_50).all()
    reasons = found.reason.values[:, 0]
    assert "reflection.transmitted_energy@10-50: there are no such contacts among 20" in reasons[0]
    assert "no wave towards contact 50 passes contact 10" in reasons[1]


def test_reflections_of_runs_that_end_too_early_are_incomplete():
    """At 1.8 ms, the wave that bead 40 of this size reflects has not passed contact 25."""
    keep = ["reflection.reflected_energy@25-55", "reflection.transmitted_energy@25-55"]
    specification = {
        "chain": {"diameters": "12 mm", "materials": "steel-52100", "beads": 80,
                  "velocity": "0.1 m/s", "masses": "7.039178 g"},
        "axes": {"masses.40": ["2 g", "11 g", "20 g"]},
        "sweep": {"methods": ["simulate"], "keep": keep},
    }  # fmt: skip
    early, late = (hc.sweep(specification | {"method": {"until": end}})
                   for end in ("1.8 ms", "3 ms"))  # fmt: skip
    assert early.incomplete.values[:, 0].tolist() == [1, 0, 0]
    assert not late.incomplete.any()
    values = early.reflected_energy_25_55.values[:, 0]
    assert np.isnan(values[0])
    assert values[1:] == pytest.approx(late.reflected_energy_25_55.values[1:, 0], rel=1e-3)
    (reason,) = (each for each in early.reason.values[:, 0] if "not complete" in each)
    assert reason.count("simulate for longer") == 1
    assert "waves have not passed" in early.incomplete.attrs["long_name"]


@pytest.mark.parametrize("coefficient", [1.0, 0.9])
def test_forces_in_sensors_are_those_of_runs(coefficient):
    chain = {"diameters": "6 mm", "materials": "steel-52100", "beads": 6,
             "right_wall": {"material": "steel-52100"}}  # fmt: skip
    chain["struck_by"] = {"radius": "5 mm", "velocity": "0.1 m/s"}
    if coefficient < 1.0:
        chain["loss"] = {"law": "restitution", "coefficient": coefficient}
    names = ["sensor.largest@ball 5", "sensor.first_maximum@2", "sensor.impulse@last"]
    for keep in (names, names[:2]):
        found = hc.sweep({
            "chain": chain, "axes": {"beads": [3, 6]},
            "sweep": {"methods": ["simulate"], "keep": keep},
        })  # fmt: skip
        law = None if coefficient == 1.0 else hc.Restitution(coefficient)
        for i, beads in enumerate((3, 6)):
            row = hc.Chain.from_materials("3 mm", "steel-52100", beads=beads, loss=law)
            row = row.struck_by(radius="5 mm", velocity="0.1 m/s")
            run = hc.simulate(row.replace(right_wall=hc.Wall.of("steel-52100")), times=4000)
            second = run.sensor_force(2).first_maximum
            assert found.sensor_first_maximum_2[i, 0] == pytest.approx(second, rel=1e-5)
            if beads == 6:
                largest = run.sensor_force("ball 5").largest_so_far
                assert found.sensor_largest_so_far_ball_5[i, 0] == pytest.approx(largest, rel=1e-5)
            if keep == names:
                impulse = np.trapezoid(run.sensor_force(run.chain.beads).force, run.times)
                assert found.sensor_impulse_last[i, 0] == pytest.approx(impulse, rel=1e-3)
        assert np.isnan(found.sensor_largest_so_far_ball_5[0, 0])
        assert "sensor.largest@ball 5: there is no such bead among 4" in str(found.reason[0, 0])
        assert (found.status == 1).all()
    assert found.sensor_largest_so_far_ball_5.attrs["units"] == "N"
    assert plot_sweep(found, "sensor.first_maximum@2").get_ylabel() == (
        "first maximum of the force in bead 2 [N]"
    )
    with pytest.raises(hc.InputError, match="unknown quantity of this sweep 'sensor.largest@3'"):
        plot_sweep(found, "sensor.largest@3")


@pytest.mark.parametrize("more", [[], ["wall_impulse"]])  # together, or one after the other
def test_points_at_which_contacts_yield_have_a_reason_and_are_counted(more, tmp_path, run):
    row = {"materials": "steel-52100", "radii": 2e-3, "beads": 3, "right_wall": "same"}
    keep = {"methods": ["simulate"], "keep": ["wall_peak_force", *more]}
    axes = {"velocity": [0.1, 1.0]}
    with pytest.warns(hc.ModelRangeWarning, match="at 1, contacts yield.*variable reason"):
        found = hc.sweep({"chain": row, "axes": axes, "sweep": keep}, tmp_path / "store")
    fast = hc.Chain.from_materials(
        2e-3, "steel-52100", beads=3, velocity=1.0, right_wall=hc.Wall.of("steel-52100")
    )
    with pytest.warns(hc.ModelRangeWarning):
        ratio = hc.hertz_range(fast, hc.simulate(fast).largest_overlaps).largest_yield_ratio
    slow, reason = found.reason.values.ravel()
    assert slow == ""
    assert reason == f"contacts yield, which their law omits: pressure / yield is {ratio:.3g}"
    shown = run("sweep", "status", str(tmp_path / "store")).stdout
    assert "points at which contacts yield, which their law omits: 1 (see" in shown
    row["loss"] = "elastic-plastic"
    assert (hc.sweep({"chain": row, "axes": axes, "sweep": keep}).reason == "").all()


def test_a_missing_ratio_of_pressure_and_yield_has_a_reason():
    row = {"radii": 2e-3, "beads": 4, "velocity": 0.1, "right_wall": {}}
    keep = {"methods": ["simulate"], "keep": ["yield_ratio", "wall_peak_force"]}
    for key, chains, known in (
        ("loss.coefficient", {"materials": "steel-52100", "loss": {"law": "restitution"}}, True),
        ("loss.yield_pressure", {"materials": "steel-52100", "loss": {"law": "elastic-plastic"}},
         False),
        ("velocity", {"materials": "silicon-nitride"}, False),
    ):  # fmt: skip
        values = [1e9, 2e9] if key == "loss.yield_pressure" else [0.8, 0.9]
        found = hc.sweep({"chain": row | chains, "sweep": keep, "axes": {key: {"list": values}}})
        missing = np.isnan(found.yield_ratio.values)
        assert (missing != known).all()
        yields = key == "loss.yield_pressure"
        unknown = (
            "all contacts between beads may yield, which limits their pressure; keep dent"
            if yields
            else "no elastic contact has a known yield strength"
        )
        reason = "" if known else f"yield_ratio: {unknown}"
        assert (found.reason.values == reason).all()
        assert not (found.status.values == 2).any()


def test_si_chains_by_scaled_methods_are_in_si():
    chain = {"radii": 5e-3, "materials": "glass", "velocity": 0.01}
    found = swept(chain, {"beads": [10, 12]}, methods=["propagate", "bca"], keep=["peak_force"])
    one = hc.Chain.from_materials(5e-3, "glass", beads=12, velocity=0.01)
    force = hc.simulate(one, times=0).pulse().peak_force
    assert found.peak_force.units == "N"
    np.testing.assert_allclose(
        found.peak_force.sel(beads=12, approach="propagate"), force, rtol=1e-7
    )


def test_any_bead_and_any_part_can_vary():
    found = swept({"radii": [1.0, 1.0, 1.0, 1.0]}, {"radii.3": [0.5, 1.0]})
    assert found.radii_3.values.tolist() == [0.5, 1.0]
    pulse = hc.propagate(hc.Chain.from_radii([1.0, 1.0, 0.5, 1.0]))
    np.testing.assert_array_equal(found.velocity.sel(radii_3=0.5)[0], pulse.velocity)
    seeds = swept({"taper": "uniform", "beads": 12, "with_scatter": {"relative": 0.01}},
                  {"with_scatter": {"seed": [1, 2]}}, keep=["velocity", "arrival"])  # fmt: skip
    scattered = hc.Chain.uniform(12).with_scatter(2, relative=0.01)
    pulse = hc.propagate(scattered)
    np.testing.assert_array_equal(seeds.velocity.sel(seed=2)[0], pulse.velocity)
    np.testing.assert_array_equal(seeds.arrival.sel(seed=2)[0], pulse.arrival)


def test_a_chain_and_arrays_are_welcome():
    chain = hc.Chain.uniform(15).replace(loss=hc.Dashpot(0.1))
    found = swept(chain, {"loss.gamma": np.array([0.0, 0.1])}, methods=["simulate"])
    pulse = hc.simulate(chain, times=0).pulse()
    np.testing.assert_array_equal(found.velocity.sel(gamma=0.1)[0], pulse.velocity)


def test_an_axis_does_not_add_a_second_striker():
    row = hc.Chain.from_materials(diameters=["9 mm"] * 5, materials="steel-52100")
    struck = row.struck_by(velocity="0.1 m/s", diameter="20 mm", material="steel-52100")
    spec = {"chain": struck, "axes": {"struck_by.velocity": [1.0]}, "sweep": {"methods": ["bca"]}}
    with pytest.raises(hc.InputError, match="would add a further striker.*vary 'velocity'"):
        hc.sweep(spec)
    spec["axes"] = {"velocity": ["0.1 m/s", "0.2 m/s"]}
    expected = hc.propagate(struck).velocity
    spec["sweep"] = {"methods": ["propagate"], "keep": ["velocity"]}
    found = hc.sweep(spec).velocity.sel(chain_velocity=0.1).squeeze()
    assert found.values == pytest.approx(expected, rel=1e-9)


def test_a_point_that_fails_has_its_reason_and_the_others_go_on():
    chain, axes = {"taper": "forward-linear"}, {"rate": [0.01, 0.05], "beads": [15, 40]}
    first = "rate = 0.05, beads = 40, approach = propagate: the radii .* reach zero"
    with pytest.warns(hc.IncompleteWarning, match=f"1 of 4 points failed .* at {first}"):
        found = swept(chain, axes, methods=["propagate", "bca"])
    assert found.status.sel(rate=0.05, beads=40).values.tolist() == [2, 2]
    assert "reach zero at bead" in str(found.reason.sel(rate=0.05, beads=40).values[0])
    assert (found.status == 2).sum() == 2
    assert np.isnan(found.velocity.sel(rate=0.05, beads=40)).all()
    assert np.isfinite(found.velocity.sel(rate=0.01, beads=40)).all()


@pytest.mark.parametrize("methods", [["bca"], ["propagate", "bca"]])
def test_a_first_point_that_fails_hides_nothing_of_the_others(methods):
    # Bead 41 is not in the first chain, nor in the one of the other cells: how long they are is
    # seen where the bead is another.
    chain = {"cell": [1.0, 0.9], "with_defects": {"bead": 3, "radius": 0.95}}
    axes = {"with_defects.bead": [41, 3], "cells": [10, 15, 25]}
    with pytest.warns(hc.IncompleteWarning, match="2 of 6 points failed"):
        found = swept(chain, axes, methods=methods)
    assert found.status.sel(approach="bca").values.tolist() == [[2, 2, 1], [1, 1, 1]]
    assert found.beads.values.tolist() == [[0, 0, 50], [20, 30, 50]]
    pulse = hc.bca(hc.Chain.periodic([1.0, 0.9], cells=25).with_defects({41: 0.95}))
    np.testing.assert_array_equal(found.velocity[0, 2].sel(approach="bca"), pulse.velocity)


def test_a_point_in_other_units_fails():
    plan = Plan(read_specification({"chain": FORWARD, "axes": {"rate": RATES}}))
    plan.__dict__["units"] = "SI"
    batch = _Batch(plan, 0, lambda: False)
    batch.one_by_one(0, "bca")
    assert batch.reason[0] == ["the chain is in scaled units, and others in SI units"]
    assert (batch.status == 2).all()


def test_warnings_of_theories_are_kept_and_not_shown(recwarn):
    chain = {"taper": "backward-exponential", "beads": 40}
    found = swept(chain, {"rate": [0.05, 0.8]}, methods=["local-rate"])
    assert found.outside_range.values.tolist() == [[0], [1]]
    assert not recwarn.list


def test_options_can_vary():
    found = swept({"taper": "uniform", "beads": 30}, {"method": {"rtol": [1e-6, 1e-9]}})
    pulse = hc.propagate(hc.Chain.uniform(30), rtol=1e-6)
    np.testing.assert_array_equal(found.velocity.sel(rtol=1e-6)[0], pulse.velocity)
    assert not np.array_equal(found.velocity.sel(rtol=1e-9)[0], pulse.velocity)


BAD = [
    ({}, "a sweep needs a table \\[chain\\]"),
    ({"chain": {"taper": "uniform"}}, "axes: nothing varies"),
    ({"chian": {}}, "unknown table or key 'chian'.*did you mean 'chain'"),
    ({"axes": {"raet": [1]}}, "axes.raet: unknown parameter 'raet'.*did you mean 'rate'"),
    ({"axes": {"rate": 3}}, "axes.rate: must be a list of values or a table with linspace, got 3"),
    ({"axes": {"rate": []}}, "axes.rate: has no values"),
    ({"axes": {"rate": [0.1, "a"]}}, "axes.rate: has values of different types: float, str$"),
    ({"axes": {"last": ["4 mm", "12 mm", 9]}},
     'axes.last: .* float, str; .* give {linspace = \\["4 mm", "12 mm", 9\\]}$'),
    ({"axes": {"rate": [0.02, 0.05], "with_scatter.seed": [1, 2]}},
     "^axes: with every combination of values, \\[chain.with_scatter\\] has neither relative, "),
    ({"axes": {"rate": ["a", "b"], "beads": [20, 40]}}, "^axes: with every combination of values"),
    ({"axes": {"rate": [0.1, 0.1]}}, "axes.rate: has the value 0.1 twice"),
    ({"axes": {"rate": [float("nan")]}}, "axes.rate: value 1 is nan: it must be finite"),
    ({"axes": {"rate": {"linspace": [1, 2]}}}, "linspace must be \\[first, last, number"),
    ({"axes": {"rate": {"geomspace": [-1, 2, 3]}}}, "first and last of the same sign"),
    ({"axes": {"rate": {"linspace": [0, 1, 2], "step": 1}}}, "unknown key of an axis 'step'"),
    ({"axes": {"rate": {"list": [1], "unit": "mm"}}}, "has the unit 'mm', but rate takes none"),
    ({"axes": {"radius": {"list": [1], "unit": "furlong"}}}, "unknown unit of length 'furlong'"),
    ({"axes": {"rate": [0.05, 2.0]}}, "axes.rate\\[2\\]: q of .* between 0 and 1, got 2"),
    ({"axes": {"rate": ["a", "b"]}}, "axes.rate: with every value, "),
    ({"axes": {"method": {"rtl": [1]}}}, "unknown option 'rtl'.*did you mean 'rtol'"),
    ({"axes": {"rate": [0.1, 0.2], "beads": [9]}, "sweep": {"combine": "zip"}},
     "axes: zip needs axes of the same length, but rate has 2, beads has 1 values"),
    ({"chain": {"radii": 1.0}, "axes": {"radii.2": [0.8, 0.9]}},
     "\\[chain\\] has one value of radii, 1.0, for all: list the radii"),
    ({"axes": {"radii.2": [0.8, 0.9]}}, "\\[chain\\] has no list radii: list the radii"),
    ({"sweep": {"methods": ["propgate"]}}, "sweep.methods\\[1\\]: .*did you mean 'propagate'"),
    ({"sweep": {"methods": []}}, "sweep.methods: must be a list of names"),
    ({"sweep": {"keep": ["speed"]}}, "sweep.keep\\[1\\]: sweeps do not keep the speed"),
    ({"sweep": {"keep": ["wall_impulse"]}}, "only the method 'simulate'"),
    ({"sweep": {"methods": ["simulate"], "keep": ["yield_ratio"]}}, "add materials to"),
    ({"sweep": {"methods": ["simulate"], "keep": ["wall_impulse"]}}, "have no right wall"),
    ({"sweep": {"methods": ["modified-bca"], "keep": ["arrival"]}}, "no method gives arrival"),
    ({"sweep": {"at": "first"}}, "sweep.at: must be 'every', 'last' or a list"),
    ({"sweep": {"at": [3, 2]}}, "sweep.at: numbers of beads must increase"),
    ({"sweep": {"at": [50]}}, "sweep.at: there is no bead 50 in 40 beads"),
    ({"sweep": {"errors": ["velocity"]}}, "there is only one method"),
    ({"sweep": {"reference": "bca"}}, "sweep.reference: unknown reference 'bca'"),
    ({"sweep": {"batch": 0}}, "sweep.batch: .*from 1 to 1000000, got 0"),
    ({"sweep": {"kep": []}}, "sweep: unknown key 'kep'.*did you mean 'keep'"),
    ({"method": {"until": 3}}, "method.until: no method accepts it: add simulate"),
    ({"method": {"rtol": "small"}}, "method.rtol: rtol must be a number"),
    ({"chain": {"taper": "forward-exponential", "beads": 40, "gravity": 0.1}},
     "sweep.methods\\[1\\]: propagate does not support gravity"),
    ({"chain": {"file": "beads.csv"}}, "chain: .*beads.csv"),
    ({"points": [{"rate": 1}]}, "points: there are also axes"),
    ({"chain": {"radii": [0.1, 0.1], "masses": [1.0, 1.0], "stiffness": 1.0},
      "axes": {"units": ["SI", "scaled"]}}, "some chains are in SI units, others scaled"),
    ({"method": {"max_steps": 2.5}, "sweep": {"methods": ["simulate"]}},
     "method.max_steps: max_steps must be a whole number of at least 1, got 2.5"),
    ({"axes": {"method.rtol": [1e-8, -1.0]}}, "axes.method.rtol: rtol must be at least 1e-10 .*-1"),
    ({"method": {"rtol": 1e-3}}, "method.rtol: rtol must be .* at most 1e-05, got 0.001"),
    ({"method": {"rtol": 1e-5}, "sweep": {"methods": ["simulate", "bca"]}},
     "method.rtol: rtol must be .* at most 1e-06, got 1e-05"),
    ({"method": {"until": 0.0}, "sweep": {"methods": ["simulate"]}}, "until must be above 0"),
    ({"axes": {"rate": {"linspace": [0, 1, 10**12]}}}, "from 1 to 10000000, got 1000000000000"),
    ({"axes": {"rate": {"linspace": [-1e308, 1e308, 3]}}}, "linspace's first must be at least"),
    ({"axes": {"velocity": {"list": ["a"], "unit": "m/s"}}}, "value 1 must be a number, got 'a'"),
    ({"axes": {"velocity": {"list": [1], "unit": ["m/s"]}}}, "has the unit \\['m/s'\\], .*text"),
    ({"axes": {"rate": [1j]}}, "axes.rate: value 1 is 1j, which a specification cannot hold"),
    ({"axes": {"rate": [0.1], "beads": {"linspace": [20, 100, 101]}}},
     "^axes.beads: value 2 must be a whole number, got 20.8$"),
    ({"axes": {"beads": [20.0, 40.0]}}, "value 1 must be a whole number, got 20.0; write 20$"),
    ({"axes": {"rate": [None]}}, "value 1 is None, which a specification cannot hold"),
    ({"axes": {"with_scatter.seed": [10**30]}}, "value 1 is too large: .* 63 bits"),
    ({"axes": {"rate": [0.05], 3.5: [1]}}, "axes.3.5: unknown parameter '3.5'"),
    ({"axes": {"radii.3": [0.5], "radii": [[1, 1]]}}, "axes.radii: would undo axes.radii.3"),
    ({"axes": {"loss": {"gamma": [1]}, "loss.gamma": [2]}}, "loss.gamma: would undo axes.loss.gam"),
    ({"sweep": {"methods": [["bca"]]}}, "sweep.methods\\[1\\]: unknown method \\['bca'\\]"),
    ({"sweep": {"methods": ["simulate"], "keep": ["sensor.largest"]}},
     "sweep.keep\\[1\\]: sensor.largest needs the bead .* sensor.largest@5, "),
    ({"sweep": {"methods": ["simulate"], "keep": ["sensor.largest@bal 3"]}}, "needs the bead"),
    ({"sweep": {"methods": ["simulate"], "keep": ["velocity", "sensor.largest@99"]}},
     "sweep.keep\\[2\\]: sensor.largest@99: there is no such bead in"),
    ({"sweep": {"keep": ["sensor.largest@5"]}}, "only the method 'simulate' gives it"),
    ({"sweep": {"keep": ["largest_energy@5"]}}, "only the method 'simulate' gives it"),
    ({"sweep": {"methods": ["simulate"], "keep": ["reflection.reflected_energy"]}},
     "sweep.keep\\[1\\]: .* needs the contacts .* reflection.reflected_energy@20-35, or"),
    ({"sweep": {"methods": ["simulate"], "keep": ["reflection.reflected_energy@20"]}},
     "needs the contacts on both sides"),
    ({"sweep": {"methods": ["simulate"], "keep": ["reflected_force@5-999"]}},
     "reflection.reflected_force@5-999: there are no such contacts in"),
    ({"sweep": {"keep": ["velocity@5"]}}, "is velocity of one bead: keep velocity, .*at = \\[5\\]"),
    ({"sweep": {"combine": np.arange(3)}}, "sweep.combine: unknown combination \\[0, 1, 2\\]"),
    ({"sweep": {"reference": np.arange(3)}}, "sweep.reference: unknown reference"),
    ({"sweep": {"at": [[1]]}}, "sweep.at: bead must be a whole number"),
    ({"sweep": {"batch": object()}}, "sweep: batch is <object .* a specification cannot hold"),
    ({"title": "\ud800"}, "title: .* is not valid text"),
    ({"chain": FORWARD | {"rate": float("nan")}}, "chain: rate is nan: it must be finite"),
    ({"chain": {"taper": "uniform", "beads": 5, "struck_by": {"mass": math.inf}}},
     "chain: struck_by.mass is inf: it must be finite; infinite lengths are text"),
    ({"chain": FORWARD | {"loss": {"gamma": {1, 2}}}}, "chain: loss.gamma is {1, 2}, which"),
    ({"materials": {"m": {"young": None}}}, "materials: m.young is None, which"),
]  # fmt: skip


def test_scaled_chains_of_sweeps_have_flat_strikers():
    striker = {"mass": 4.0, "radius": math.inf}
    given = {"chain": {"taper": "uniform", "beads": 6, "struck_by": striker}}
    found = hc.sweep(given | {"axes": {"struck_by.mass": [2.0, 4.0]}})
    for k, mass in enumerate([2.0, 4.0]):
        chain = hc.Chain.uniform(6).struck_by(mass=mass, radius=math.inf)
        assert chain.striker_properties[0].flat
        np.testing.assert_allclose(
            found["velocity"][k].squeeze(), hc.propagate(chain).velocity, rtol=1e-6
        )


@pytest.mark.parametrize(("change", "said"), BAD)
def test_invalid_specifications_are_rejected(change, said):
    given = {"chain": dict(FORWARD), "axes": {"rate": [0.05]}}
    if change in (BAD[0][0], BAD[1][0]):
        given = {}
    with pytest.raises(hc.InputError, match=said):
        hc.sweep(given | change)


def test_too_many_combinations_are_rejected_before_their_values_are_made(monkeypatch):
    made = []
    monkeypatch.setattr(axes_module, "_spaced", lambda *given: made.append(given) or [0.05])
    million = {"linspace": [0.01, 0.1, 10**6]}
    axes = {"rate": million, "radii": {"5": million}, "beads": {"list": [10, 20]}}
    said = (
        r"^axes: .* 2000000000000 points, 1000000 \(rate\) x 1000000 \(radii.5\) x 2 \(beads\); "
        "at most 10000000000 are allowed"
    )
    with pytest.raises(hc.InputError, match=said):
        read_specification({"chain": dict(FORWARD), "axes": axes})
    assert not made
    # Values that vary together are not combined.
    with pytest.raises(hc.InputError, match="zip needs axes of the same length"):
        read_specification({"chain": dict(FORWARD), "axes": axes, "sweep": {"combine": "zip"}})
    assert len(made) == 2


@pytest.mark.parametrize("name", ["struck_by.velocity", "struck_by.1.mass"])
@pytest.mark.parametrize("chain", [BALLS, hc.Chain.from_materials("5 mm", "brass", beads=4)])
def test_an_axis_does_not_add_a_striker(name, chain):
    plan = {"chain": chain, "axes": {name: [0.1, 0.2]}}
    said = f"axes.{name}: .chain. has no striker: add a table 'struck_by', or vary 'velocity'"
    with pytest.raises(hc.InputError, match=said):
        hc.sweep(plan)
    # Axes may provide the properties of a striker that [chain] has, or the whole striker.
    row = {"radii": "5 mm", "beads": 4, "materials": "brass"}
    struck, axes = row | {"struck_by": {}}, {"struck_by.velocity": [0.1, 0.2]}
    whole = {"struck_by": [{"velocity": 0.1}, {"velocity": 0.2}]}
    for table, given in ((struck, axes), (row, whole)):
        plan = Plan(read_specification({"chain": table, "axes": given}))
        assert plan.chain((1,)).velocities.tolist() == [0.2, 0.0, 0.0, 0.0, 0.0]


def test_names_of_keys_in_a_list_of_strikers_need_its_number():
    chain = {"diameters": "10 mm", "beads": 5, "material": "steel-52100",
             "struck_by": [{"velocity": "0.1 m/s", "diameter": "10 mm"}]}  # fmt: skip
    axes = {"struck_by.velocity": ["0.1 m/s", "0.2 m/s"], "struck_by.2.diameter": ["5 mm", "6 mm"]}
    two = chain | {"struck_by": 2 * chain["struck_by"]}
    axes["struck_by.3.diameter"] = axes.pop("struck_by.2.diameter")
    with pytest.raises(hc.InputError) as raised:
        hc.sweep({"chain": two, "axes": axes})
    assert str(raised.value).splitlines()[1:] == [
        "  axes.struck_by.velocity: struck_by is a list of 2, so the name needs a number: write "
        "'struck_by.1.velocity' for its first item",
        "  axes.struck_by.3.diameter: there is no item 3 in struck_by, a list of 2",
    ]
    sweep = {"methods": ["simulate"], "keep": ["velocity"], "at": "last"}
    # The only striker needs no number.
    for name in ("struck_by.1.velocity", "struck_by.velocity"):
        plan = {"chain": chain, "axes": {name: ["1 mm/s", "2 mm/s"]}, "sweep": sweep}
        slow, fast = hc.sweep(plan).velocity.values.ravel()
        # Hertz's law has no scale of velocity.
        assert fast == pytest.approx(2.0 * slow, rel=1e-9)


def test_constants_of_named_materials_vary():
    kinds = ["brass", "mine", "brass", "mine"]
    chain = {"diameters": "10 mm", "beads": 4, "velocity": "0.1 m/s", "materials": kinds,
             "right_wall": {"rigid": True}}  # fmt: skip
    mine = {"density": 2000.0, "young": "1 GPa", "poisson": 0.3}
    spec = {"chain": chain, "materials": {"mine": mine},
            "sweep": {"methods": ["simulate"], "keep": ["wall_peak_force"]}}  # fmt: skip
    axes = {f"materials.{name}.young": ["2 GPa", "8 GPa"] for name in ("brass", "mine")}
    found = hc.sweep(spec | {"axes": axes}).wall_peak_force.values.squeeze()
    # If all moduli change together, forces are proportional to their power 2/5.
    assert found[1, 1] == pytest.approx(4.0**0.4 * found[0, 0], rel=1e-6)
    assert found[0, 0] < min(found[0, 1], found[1, 0])
    axes = {"materials.steel-304.young": [2e9], "materials.mine.yung": [2e9]}
    with pytest.raises(hc.InputError) as raised:
        hc.sweep(spec | {"axes": axes})
    assert "[chain] has nothing of 'steel-304'; it has brass, mine" in str(raised.value)
    assert "unknown constant of a material 'yung'" in str(raised.value)


@pytest.mark.parametrize(("points", "said"), [
    (3, r"must be tables \[\[points\]\] or the name of a CSV file, got 3"),
    ([3], r"points\[1\]: must be a table of parameters, got 3"),
    ([{}], r"points\[1\]: must be a table of parameters, got {}"),
    ([{"rate": 0.1}, {"rtae": 0.1}],
     r"points\[2\]: must have the same parameters as points\[1\]: rate"),
    ([{"rate": 0.1}, {"rate": "a"}], "points.rate: has values of different types: float, str"),
    ("missing.csv", "missing.csv': cannot be read"),
    ("\0.csv", "points must be a path"),
])  # fmt: skip
def test_points_that_cannot_be_used_are_rejected(points, said):
    with pytest.raises(hc.InputError, match=said):
        hc.sweep({"chain": dict(FORWARD), "points": points})


@pytest.mark.parametrize(("text", "said"), [
    ("", "must have a header with parameters and one row per point"),
    ("rate,beads\n", "must have a header with parameters and one row per point"),
    ("rate,rate\n1,2\n", "has two columns 'rate'"),
    ("rate,beads\n0.1\n", "row 1 has 1 cell, but the header has 2"),
    ("rate,beads\n0.1,10,5\n", "row 1 has 3 cells, but the header has 2"),
    ("rate,beads\n0.1,10\n,10\n", "row 2 has no rate"),
    ("rate,beads\n0.1,10\nnan,10\n", "points.rate: value 2 is nan"),
    ("rate,baeds\n0.1,10\n", "unknown parameter 'baeds'.*did you mean 'beads'"),
    ("rate,beads\n0.1,ten\n", "beads of .chain. must be a whole number, got 'ten'"),
    ('rate,beads\n"0.1,10\n', "not a CSV table"),
])  # fmt: skip
def test_tables_of_points_that_cannot_be_used_are_rejected(tmp_path, text, said):
    (tmp_path / "points.csv").write_text(text)
    with pytest.raises(hc.InputError, match=said):
        hc.sweep({"chain": dict(FORWARD), "points": str(tmp_path / "points.csv")})


def test_long_lists_of_errors_are_cut():
    axes = {"rate": [-1.0 - i for i in range(50)] + [0.1]}
    with pytest.raises(hc.InputError) as error:
        hc.sweep({"chain": FORWARD, "axes": axes})
    lines = str(error.value).splitlines()
    assert lines[0] == "50 errors:"
    assert len(lines) == 22
    assert lines[-1].strip() == "and 30 more"


def test_all_errors_are_listed_at_once(tmp_path):
    (tmp_path / "bad.toml").write_text(
        '[chain]\ntaper = "uniform"\n[axes]\nbeads = []\n[sweep]\nmethods = ["bac"]\nkeep = ["v"]\n'
    )
    with pytest.raises(hc.InputError) as error:
        hc.sweep(tmp_path / "bad.toml")
    lines = str(error.value).splitlines()
    assert lines[0].endswith("bad.toml: 3 errors:")
    assert [line.split(":")[0].strip() for line in lines[1:]] == [
        "axes.beads", "sweep.methods[1]", "sweep.keep[1]",
    ]  # fmt: skip


def test_specifications_survive_json_and_tell_their_differences():
    given = {"chain": dict(FORWARD), "axes": {"rate": {"linspace": [0.01, 0.1, 4]}, "beads": [9]}}
    spec = read_specification(given)
    again = specification_from_json(spec.as_json())
    assert again.as_json() == spec.as_json()
    assert Plan(again).shape == Plan(spec).shape == (4, 1)
    other = read_specification(given | {"sweep": {"at": "last"}})
    assert differences(spec.as_json(), other.as_json()) == ["sweep.at: 'every', now 'last'"]
    assert json.loads(spec.as_json())["axes"]["rate"] == {"linspace": [0.01, 0.1, 4]}


@pytest.mark.parametrize(("beads", "most"), [(20, 2048), (20_000, 48), (2_000_000, 1)])
@pytest.mark.parametrize("kept", ["last", "every"])
def test_a_batch_holds_little_in_memory(beads, most, kept):
    axes = {"rate": {"linspace": [1e-7, 2e-7, 100_000]}}
    plan = Plan(read_specification({
        "chain": {"taper": "backward-exponential", "beads": beads}, "axes": axes,
        "sweep": {"at": kept},
    }))  # fmt: skip
    assert math.prod(plan.block) <= most
    assert plan.bytes_in_memory <= 2**27 or most == 1


def test_batches_too_large_for_memory_are_rejected():
    given = {"chain": {"taper": "backward-exponential", "beads": 10_000_000},
             "axes": {"rate": {"linspace": [1e-9, 2e-9, 1000]}},
             "sweep": {"at": "last", "batch": 1000}}  # fmt: skip
    with pytest.raises(hc.InputError, match=r"1000 points of 10000000 beads need .* GiB of"):
        hc.sweep(given, workers=1)


MEMORY = """
from pathlib import Path
import hertzchain as hc

class Enough(Exception):
    pass

def stop(done, _):
    if done > 0:
        raise Enough

given = {"chain": {"taper": "backward-exponential", "beads": 20_000},
         "axes": {"rate": {"linspace": [1e-7, 2e-7, 64_000]}}, "sweep": {"at": "last"}}
try:
    hc.sweep(given, workers=2, progress=stop)
except Enough:
    pass
peak = next(line for line in Path("/proc/self/status").open() if line.startswith("VmHWM"))
print(int(peak.split()[1]) / 1024)
"""


@pytest.mark.long
def test_memory_does_not_grow_with_what_is_not_kept():
    done = subprocess.run(
        [sys.executable, "-c", MEMORY], capture_output=True, text=True, check=True
    )
    assert float(done.stdout) < 1000


def test_chains_in_the_making_can_be_stopped():
    """Chains of a batch take seconds to make, and nothing else looks at the clock."""
    axes = {"decorated.between": {"linspace": [900, 930, 31]}, "decorated.radius": [0.2, 0.3]}
    given = {"chain": {"taper": "uniform", "beads": 40}, "axes": axes,
             "sweep": {"at": "last", "batch": 62}}  # fmt: skip
    begun = []

    def stop():
        begun.append(time.monotonic())
        return len(begun) > 5

    with pytest.raises(Stopped):
        run_batch(read_specification(given).as_json(), 0, stop)
    assert max(np.diff(begun)) < 2.0


@pytest.mark.parametrize("count", [1, 1000])
def test_a_trial_makes_each_chain_once(monkeypatch, count):
    made = []
    chain = Plan.chain
    monkeypatch.setattr(Plan, "chain", lambda plan, index: made.append(index) or chain(plan, index))
    axes = {"beads": {"linspace": [3, count + 2, count]}, "exponent": [1.5, 1.6]}
    plan = Plan(read_specification({"chain": {"taper": "uniform"}, "axes": axes}))
    check_plan(plan)
    assert plan.longest == count + 2
    # Some are made again to be propagated.
    assert len(made) <= len(set(made)) + 4


@pytest.mark.parametrize("shape", [(1,), (7,), (1000,), (3, 5), (40, 300), (2, 1, 9), (70, 80, 3)])
def test_batches_hold_every_point_once(shape):
    names = ("rate", "gravity", "exponent")[: len(shape)]
    axes = {name: {"linspace": [0.01, 0.02, n]} if n > 1 else [0.01]
            for name, n in zip(names, shape, strict=True)}  # fmt: skip
    plan = Plan(read_specification({"chain": dict(FORWARD), "axes": axes}))
    seen = np.zeros(shape, int)
    for batch in range(plan.batches):
        indices = list(plan.indices(batch))
        assert len(indices) <= max(8, -(-seen.size // 32))
        seen[plan.region(batch)] += 1
        assert all(seen[index] == 1 for index in indices)
    assert (seen == 1).all()


@pytest.mark.filterwarnings("ignore:1 of 4 points failed:hertzchain.IncompleteWarning")
@pytest.mark.parametrize("ending", [".csv", ".parquet", ".nc"])
def test_exports_hold_the_numbers(tmp_path, ending):
    import pandas as pd

    found = swept({"taper": "forward-linear"}, {"rate": [0.01, 0.05], "beads": [15, 40]},
                  methods=["propagate", "bca"], keep=["velocity", "residence"])  # fmt: skip
    file = tmp_path / f"sweep{ending}"
    export_sweep(found, file)
    assert [item.name for item in tmp_path.iterdir()] == [file.name]
    if ending == ".nc":
        with xr.open_dataset(file, engine="h5netcdf") as again:
            np.testing.assert_array_equal(again.velocity, found.velocity)
            assert again.attrs["specification"] == found.attrs["specification"]
        return
    table = pd.read_csv(file) if ending == ".csv" else pd.read_parquet(file)
    assert len(table) == 2 * 2 * (15 + 40)
    row = table.query("rate == 0.01 and beads == 40 and approach == 'bca' and bead == 7").iloc[0]
    point = found.sel(rate=0.01, beads=40, approach="bca")
    assert row.velocity == pytest.approx(point.velocity.sel(bead=7).item(), rel=1e-8)
    assert row.residence == pytest.approx(point.residence.sel(contact=7).item(), rel=1e-8)
    failed = table.query("rate == 0.05 and beads == 40")
    assert (failed.status == 2).all()
    assert failed.reason.str.contains("reach zero").all()


@pytest.mark.long
def test_exports_need_memory_for_a_part_alone(tmp_path, monkeypatch):
    rates = {"linspace": [0.001, 0.05, 3000]}
    hc.sweep({"chain": {"taper": "forward-exponential", "beads": 100}, "axes": {"rate": rates},
              "sweep": {"methods": ["bca"], "keep": ["velocity", "peak_force"]}},
             tmp_path / "sweep")  # fmt: skip
    found = hc.open_sweep(tmp_path / "sweep")
    monkeypatch.setattr(sweep_export, "ROWS", 5000)
    tracemalloc.start()
    rows = [len(table) for table in tables_of(found)]
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert rows == [5000] * 60
    # Of 4.8 MB of numbers, a part and its table; measured 1.1 MB, and 5.5 MB with all in memory.
    assert peak < 2e6


def test_exports_of_another_kind_are_rejected(tmp_path):
    found = swept(FORWARD, {"rate": [0.05]})
    with pytest.raises(hc.InputError, match="exported as .csv, .parquet, .nc, got 'a.xls'"):
        export_sweep(found, tmp_path / "a.xls")
    with pytest.raises(hc.InputError, match="cannot write"):
        export_sweep(found, tmp_path / "missing" / "a.csv")


def test_curves_and_maps():
    found = swept(FORWARD, {"rate": RATES, "beads": [20, 30]}, methods=["propagate", "bca"],
                  keep=["momentum"], at="last", errors=["velocity"])  # fmt: skip
    curves = plot_sweep(found, "momentum", beads=20)
    assert [line.get_label() for line in curves.lines] == ["propagation", "BCA"]
    np.testing.assert_array_equal(
        curves.lines[1].get_ydata(), found.momentum.sel(beads=20, approach="bca")
    )
    assert plot_sweep(found, "pulse.momentum", beads=20).get_ylabel() == curves.get_ylabel()
    with pytest.raises(hc.InputError, match="'momentum@20' is momentum of one bead: .* at bead=20"):
        plot_sweep(found, "momentum@20")
    drawn = plot_sweep(found, "worst_error_of_velocity", approach="bca", log=True, levels=[0.4])
    labels = drawn.get_xlabel(), drawn.get_ylabel()
    assert labels == ("rate of the taper $q$", "number of beads $N$")
    bar = drawn.collections[0].colorbar.ax
    assert bar.get_ylabel() == "largest error of velocity [%]"
    np.testing.assert_array_equal(
        drawn.collections[0].get_array().reshape(2, 3),
        100.0 * found.worst_error_of_velocity.sel(approach="bca").T,
    )
    one_method = "2 remaining dimensions, .*and 2 methods.* approach='propagate', or .* beads=20$"
    with pytest.raises(hc.InputError, match=one_method):
        plot_sweep(found, "momentum", levels=[1.0])
    with pytest.raises(hc.InputError, match="no remaining axis to plot along; omit rate or beads"):
        plot_sweep(found, "momentum", rate=0.02, beads=20)
    with pytest.raises(hc.InputError, match="beads is 21, which is not a .*; the nearest is 20"):
        plot_sweep(found, "momentum", beads=21)
    with pytest.raises(hc.InputError, match="rate must be at least 0.02 and at most 0.08, got 2"):
        plot_sweep(found, "momentum", rate=2)
    with pytest.raises(hc.InputError, match="unknown dimension of momentum 'baeds'"):
        plot_sweep(found, "momentum", baeds=3)
    with pytest.raises(hc.InputError, match="unknown approach 'bac'"):
        plot_sweep(found, "momentum", approach="bac")
    with pytest.raises(hc.InputError, match="unknown quantity of this sweep 'speed'"):
        plot_sweep(found, "speed")


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
def test_an_axis_with_few_values_gives_one_curve_per_value():
    chain = {"materials": "steel-52100", "beads": 4}
    speeds = {"linspace": [0.1, 0.8, 8], "unit": "m/s"}
    found = swept(chain, {"diameters": ["10 mm", "20 mm"], "velocity": speeds},
                  keep=["peak_force"], at="last")  # fmt: skip
    curves = plot_sweep(found)
    shown = legend_texts(curves)
    assert shown[:2] == ["diameter = 10 mm", "diameter = 20 mm"]
    assert (curves.get_xlabel(), len(curves.collections)) == ("velocity [m/s]", 0)
    second = next(line for line in curves.lines if line.get_label() == "diameter = 20 mm")
    forces = found.peak_force.sel(diameters=20.0, approach="propagate")
    np.testing.assert_array_equal(second.get_ydata(), forces)
    assert plot_sweep(found, levels=[50.0]).collections


def test_missing_points_are_counted_in_a_plot_and_an_empty_sweep_is_rejected(tmp_path):
    spec = {"chain": FORWARD, "axes": {"rate": RATES}, "sweep": {"keep": ["momentum"],
            "at": "last", "batch": 1}}  # fmt: skip
    hc.sweep(spec, tmp_path / "part.zarr", shard=(1, 3))
    part = hc.open_sweep(tmp_path / "part.zarr")
    with pytest.warns(hc.IncompleteWarning, match="of the 3 points to plot, 2 missing: left blank"):
        plot_sweep(part)
    status = part.status.copy(data=np.zeros_like(part.status.values))
    empty = part.assign(status=status, momentum=part.momentum * np.nan)
    with pytest.raises(hc.InputError, match=r"none of the 3 points to plot is done \(3 missing\)"):
        plot_sweep(empty)


@pytest.mark.filterwarnings("ignore::hertzchain.errors.IncompleteWarning")
def test_the_axis_of_one_bead_has_its_number():
    found = hc.sweep({
        "chain": {"radii": [1.0] * 8}, "axes": {"radii.5": {"linspace": [0.5, 1.0, 3]}},
        "sweep": {"keep": ["velocity"], "at": "last"},
    })  # fmt: skip
    assert hc.plot_sweep(found).get_xlabel() == "radius of bead 5"


def test_a_plot_without_any_value_is_rejected():
    chain = {"taper": "uniform", "right_wall": {"gap": 0.0}}
    # The runs end before the pulse arrives.
    found = hc.sweep({"chain": chain, "axes": {"beads": [10, 20]}, "method": {"until": 3.0},
                      "sweep": {"methods": ["simulate"], "keep": ["wall_peak_force"]}})  # fmt: skip
    assert (found.status == 1).all()
    words = "no value of wall_peak_force at any of the 2 points to plot; set until, or keep"
    with pytest.raises(hc.InputError, match=words):
        plot_sweep(found)


def test_cells_of_a_map_meet_halfway_on_its_scales_for_any_order_of_values():
    found = hc.sweep({
        "chain": {"taper": "forward-linear"},
        "axes": {"rate": {"geomspace": [1e-4, 1e-2, 3]}, "beads": [40, 20, 30]},
        "sweep": {"keep": ["momentum"], "at": "last"},
    })  # fmt: skip
    assert len(plot_sweep(found, "momentum").lines) == 3
    drawn = plot_sweep(found, "momentum", levels=[0.1])
    # All cells are whole.
    assert drawn.get_xlim() == pytest.approx((10**-4.5, 10**-1.5))
    assert drawn.get_ylim() == (15.0, 45.0)
    corners = drawn.collections[0].get_coordinates()
    assert corners[0, :, 0].tolist() == pytest.approx(
        [10**-4.5, 10**-3.5, 10**-2.5, 10**-1.5], rel=1e-12
    )
    assert corners[:, 0, 1].tolist() == pytest.approx([15.0, 25.0, 35.0, 45.0])
    longest = found.momentum.sel(approach="propagate", beads=40).values
    assert drawn.collections[0].get_array()[-1].tolist() == pytest.approx(longest.tolist())


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
@pytest.mark.filterwarnings("ignore::hertzchain.IncompleteWarning")
def test_maps_mark_cells_outside_the_range_and_failed_ones():
    found = hc.sweep({
        "chain": {"first_diameter": "10 mm", "materials": "steel-52100", "beads": 6},
        "axes": {"velocity": [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7],
                 "ratio": [0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0]},
        "sweep": {"methods": ["simulate"], "keep": ["velocity"], "at": "last"},
    })  # fmt: skip
    outside = found.outside_range.values[:, :, 0].astype(bool)
    assert 5 < outside.sum() < 44
    found.status[6, 2] = FAILED
    found.velocity[6, 2] = np.nan
    outside[6, 2] = False
    axes = plot_sweep(found, "velocity")
    # Those without places are for the legend.
    marks = [each.get_offsets().tolist() for each in axes.collections[1:]]
    failed, places = (each for each in marks if each)
    assert failed == [[0.7, 0.6]]
    expected = [[float(found.chain_velocity[i]), float(found.ratio[j])]
                for i, j in np.argwhere(outside)]  # fmt: skip
    assert sorted(places) == sorted(expected)
    names = legend_texts(axes)
    assert names == ["failed", "outside the range of the method or of Hertz's law"]
    assert axes.get_ylabel() == "last radius / first radius"
    # Cells extend beyond the values, so all ticks are at values.
    assert axes.get_xticks().tolist() == found.chain_velocity.values.tolist()
    assert axes.get_yticks().tolist() == found.ratio.values.tolist()


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
def test_scaled_curves_have_no_range_of_hertz_law():
    found = hc.sweep({
        "chain": {"taper": "forward-exponential", "beads": 30}, "axes": {"rate": [0.02, 0.05, 0.3]},
        "sweep": {"methods": ["local-rate"], "keep": ["velocity"], "at": "last"},
    })  # fmt: skip
    assert found.outside_range.values.any()
    names = plot_sweep(found).get_legend_handles_labels()[1]
    assert "outside the range of the method" in names


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
def test_axes_of_pictures_say_what_varies():
    chain = {"radii": 5e-3, "materials": "steel-316", "beads": 5, "loss": {"law": "restitution",
             "coefficient": 1.0}, "struck_by": {"velocity": 0.1}}  # fmt: skip
    masses = {"list": [4, 6, 9], "unit": "g"}
    kinds = ["steel-316", "ptfe", "brass"]
    axes = {"materials": kinds, "loss.coefficient": [0.8, 0.9, 1.0],
            "struck_by.mass": masses}  # fmt: skip
    found = swept(chain, axes, methods=["simulate"], at="last", keep=["velocity"])
    across = plot_sweep(found, levels=[0.05], **{"struck_by.mass": 6.0})
    across.figure.canvas.draw()
    assert [tick.get_text() for tick in across.get_xticklabels()] == kinds
    assert across.get_ylabel() == "coefficient of restitution"
    outside = "all points outside the range of the method or of Hertz's law"
    first, *others = across.get_title().split("\n")
    assert [first, " ".join(others)] == ["mass of the striker = 6 g", outside]
    assert across.collections[0].colorbar.ax.get_ylabel() == "velocity $v_{N}$ [m/s]"
    along = plot_sweep(found, materials="ptfe", coefficient=0.9)
    # A geometric progression over less than a decade has no ticks to read on a logarithmic scale.
    assert (along.get_xlabel(), along.get_xscale()) == ("mass of the striker [g]", "linear")


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
@pytest.mark.parametrize(
    ("strikers", "axis", "label"),
    [(1, "struck_by.1.velocity", "velocity of the striker [m/s]"),
     (2, "struck_by.2.velocity", "velocity of striker 2 [m/s]")],
)  # fmt: skip
def test_only_several_strikers_have_numbers_in_labels(strikers, axis, label):
    chain = {"radii": 5e-3, "materials": "steel-316", "beads": 3,
             "struck_by": [{"velocity": 0.01}] * strikers}  # fmt: skip
    axes = {axis: {"list": [0.01, 0.02], "unit": "m/s"}}
    found = swept(chain, axes, methods=["simulate"], at="last", keep=["velocity"])
    assert plot_sweep(found).get_xlabel() == label


def test_spaced_values_are_looked_up_as_they_are_written():
    losses = Axis(("loss", "coefficient"), {"linspace": [0.8, 1.0, 5]})
    assert losses.values == [0.8, 0.85, 0.9, 0.95, 1.0]
    assert Axis(("rate",), {"geomspace": [1e-3, 0.1, 3]}).values == [0.001, 0.01, 0.1]
    assert Axis(("radius",), {"list": [0.7, 2.3], "unit": "mm"}).values == [0.0007, 0.0023]
    ends = {"linspace": [np.pi / 100, np.pi / 10, 3]}
    assert Axis(("rate",), ends).values[::2] == [np.pi / 100, np.pi / 10]


def test_tables_begin_with_where_and_end_with_how_it_went():
    axes = {"rate": [0.02, 0.05], "beads": [10, 12]}
    found = swept({"taper": "forward-exponential"}, axes, combine="zip", methods=["bca"],
                  keep=["velocity", "peak_force"])  # fmt: skip
    (table,) = tables_of(found)
    assert list(table) == ["point", "rate", "beads", "approach", "bead", "velocity", "peak_force",
                           "outside_range", "reason", "status"]  # fmt: skip


@pytest.mark.parametrize(("at", "told"), [
    ({"rate": 0.03}, "rate = 0.03 is not a value of this sweep; the nearest, 0.02, is plotted"),
    ({"exponent": 1.6}, "exponent = 1.6 is not .* of this sweep; the nearest, 1.5, is plotted"),
])  # fmt: skip
def test_the_nearest_value_of_an_axis_is_plotted_with_a_warning(at, told):
    axes = {"rate": [0.02, 0.05], "beads": [10, 20], "exponent": [1.5, 2.0]}
    found = swept({"taper": "forward-exponential"}, axes, at="last")
    with pytest.warns(hc.InputWarning, match=told):
        plot_sweep(found, **at)
    ((name, value),) = at.items()
    nearest = found[name].values[0]
    assert f"= {nearest:g}" in plot_sweep(found, **{name: nearest}).get_title(), value


@pytest.mark.parametrize(("at", "error"), [
    ({"beads": 11}, "beads is 11, which is not a value of this sweep; the nearest is 10"),
    ({"with_scatter.seed": 3}, "seed is 3, which is not a value of this sweep; the nearest is 2"),
])  # fmt: skip
def test_whole_numbers_have_no_nearest_value(at, error):
    axes = {"rate": [0.02, 0.05], "beads": [10, 20], "with_scatter.seed": [1, 2, 7]}
    chain = {"taper": "forward-exponential", "with_scatter": {"relative": 0.01}}
    with pytest.raises(hc.InputError, match=error):
        plot_sweep(swept(chain, axes, at="last"), **at)


def test_the_time_for_compiling_is_not_part_of_an_estimate(monkeypatch):
    """The first computation of each batch takes two seconds more."""
    begun = set()

    def computed(plan, batch):
        key = (plan.batches, batch)
        first, _ = key not in begun, begun.add(key)
        return 2.0 * first + 1e-3 * sum(1 for _ in plan.indices(batch))

    monkeypatch.setattr(timing, "time_of_batch", computed)
    spec = {"chain": {"taper": "uniform"}, "axes": {"beads": list(range(10, 40))}}
    assert timing.time_per_point(read_specification(spec)).seconds == pytest.approx(1e-3)


def test_points_are_ticked_by_whole_numbers():
    axes = {"rate": [0.02, 0.05, 0.02, 0.05], "beads": [10, 12, 12, 10]}
    found = swept({"taper": "forward-exponential"}, axes, combine="zip")
    ticks = plot_sweep(found, bead=10).get_xticks()
    np.testing.assert_array_equal(ticks, ticks.round())


@pytest.mark.parametrize(("chosen", "said"), [
    ({"quantity": "reason"}, "unknown quantity of this sweep 'reason'"),
    ({"quantity": ["speed"]}, "unknown quantity of this sweep 'speed'"),
    ({"bead": 41}, "bead must be at least 1 and at most 40, got 41"),
    ({"bead": 2.5}, "bead is 2.5, which is not a value of this sweep"),
    ({"bead": "x"}, "bead must be a number, got 'x'"),
    ({"bead": [1, 2]}, r"bead must be a number, got \[1, 2\]"),
    ({"rate": 7.0}, "rate must be at least 0.02 and at most 0.08, got 7"),
    ({"rate": float("nan")}, "rate must be .*, got nan"),
    ({"approach": 3}, "unknown approach 3: choose from propagate, bca"),
    ({"bead": 3, "rate": 0.02, "approach": "bca"}, "velocity has no remaining axis to plot along"),
    ({"levels": 3}, "levels must be a list of numbers, got 3"),
    ({"levels": ["a"]}, "level must be a number, got 'a'"),
    ({"bead": 3, "ax": 3}, "ax must be an Axes, got 3"),
])  # fmt: skip
def test_sweeps_that_cannot_be_plotted_are_rejected(chosen, said):
    found = swept(FORWARD, {"rate": RATES}, methods=["propagate", "bca"])
    with pytest.raises(hc.InputError, match=said):
        plot_sweep(found, **chosen)


@pytest.mark.parametrize("given", [3, None, {}, xr.Dataset({"a": ("x", [1.0])})])
def test_anything_but_a_sweep_is_neither_plotted_nor_exported(tmp_path, given):
    for use in (plot_sweep, lambda dataset: export_sweep(dataset, tmp_path / "a.csv")):
        with pytest.raises(
            hc.InputError, match=r"dataset must be a Dataset|is not the result of a sweep"
        ):
            use(given)
    assert list(tmp_path.iterdir()) == []


def test_workers_of_an_estimate_are_checked():
    given = {"chain": FORWARD, "axes": {"rate": RATES}}
    for workers in (0, "2", 2.5):
        with pytest.raises(hc.InputError, match="workers must be a whole number of at least 1"):
            estimate(given, workers=workers)


def test_values_with_a_unit_are_those_in_si():
    """Text in a list and a list with one unit give one specification; the chains are the same."""
    in_mm = (["4 mm", "5 mm"], {"list": [4, 5], "unit": "mm"}, {"list": ["4 mm", "5.0 mm"]})
    in_m = ([4e-3, 5e-3], ["0.4 cm", "5000 um"])
    for ways in (in_mm, in_m):
        specs = [read_specification({"chain": BALLS, "axes": {"radii": way}}) for way in ways]
        assert len({spec.as_json() for spec in specs}) == 1
        assert all(spec.axes[0].values == [4e-3, 5e-3] for spec in specs)
    again = read_specification(json.loads(specs[0].as_json()))
    assert again.as_json() == specs[0].as_json()


@pytest.mark.parametrize(
    ("entry", "values", "unit"),
    [
        (["8 mm", "10 mm"], [8.0, 10.0], "mm"),
        ({"linspace": [8, 10, 2], "unit": "mm"}, [8.0, 10.0], "mm"),
        (["8 mm", "1 cm"], [0.008, 0.01], "m"),
        ([0.008, 0.01], [0.008, 0.01], "m"),
    ],
)
def test_an_axis_is_in_the_unit_in_which_it_was_typed(entry, values, unit, tmp_path):
    pd = pytest.importorskip("pandas")
    chain = {"diameters": "9 mm", "beads": 4, "materials": "glass", "velocity": "1 cm/s"}
    found = swept(chain, {"diameters": entry}, keep=["peak_force"], at="last")
    assert found.diameters.values.tolist() == values
    assert found.diameters.units == unit
    one = hc.Chain.from_materials(5e-3, "glass", beads=4, velocity=0.01)
    force = hc.propagate(one).peak_force[-1]
    at = {"diameters": values[1], "approach": "propagate"}
    assert found.peak_force.sel(at).item() == pytest.approx(force, rel=1e-9)
    hc.export_sweep(found, tmp_path / "table.csv")
    table = pd.read_csv(tmp_path / "table.csv")
    assert table[f"diameters [{unit}]"].tolist() == values
    assert table["peak_force [N]"].iloc[1] == pytest.approx(force, rel=1e-8)
    assert plot_sweep(found).get_xlabel() == f"diameter [{unit}]"
    found = swept(chain, {"diameters": entry}, keep=["peak_force"])
    assert f"diameter = {values[1]:g} {unit}" in plot_sweep(found, diameters="1 cm").get_title()


@pytest.mark.parametrize(
    "entry",
    [
        ["1%", "3%", "5%"],
        {"list": [1, 3, 5], "unit": "%"},
        {"linspace": ["1%", "5 %", 3]},
        {"linspace": [1, 5, 3], "unit": "%"},
    ],
)
def test_an_axis_of_percentages(entry):
    chain = {"taper": "forward-exponential", "beads": 10}
    found = swept(chain, {"rate": entry}, keep=["velocity"], at="last")
    assert found.rate.values.tolist() == [1.0, 3.0, 5.0]
    assert found.rate.units == "%"
    last = hc.propagate(hc.Chain.tapered("forward-exponential", 0.03, beads=10)).velocity[-1]
    assert found.velocity.sel(rate=3.0).item() == pytest.approx(last, rel=1e-9)
    assert plot_sweep(found).get_xlabel() == "rate of the taper $q$ [%]"
    found = swept(chain, {"rate": entry}, keep=["velocity"])
    assert "$q$ = 3%" in plot_sweep(found, rate="3%").get_title()
    plain = swept(chain, {"rate": [0.01, 0.03, 0.05]}, keep=["velocity"])
    assert "$q$ = 0.03" in plot_sweep(plain, rate="3%").get_title()
    with pytest.raises(hc.InputError, match="bead must not be a percentage"):
        plot_sweep(plain, bead="3%")


def test_percentages_of_points_in_a_csv_file(tmp_path):
    (tmp_path / "points.csv").write_text("rate,loss.coefficient\n1%,95%\n3%,90%\n")
    (tmp_path / "plan.toml").write_text(
        'points = "points.csv"\n[chain]\ntaper = "forward-exponential"\nbeads = 10\n'
        '[chain.loss]\nlaw = "restitution"\n[sweep]\nmethods = "simulate"\n'
    )
    spec = read_specification(tmp_path / "plan.toml")
    assert [axis.values for axis in spec.axes] == [[0.01, 0.03], [0.95, 0.9]]


def test_the_ends_of_an_axis_may_have_units():
    given = {"chain": BALLS, "axes": {"radii": {"linspace": ["1/8 in", "1/4 in", 3]}}}
    spec = read_specification(given)
    assert spec.axes[0].values == [3.175e-3, 4.7625e-3, 6.35e-3]
    assert (spec.axes[0].typed, spec.axes[0].unit) == ([0.125, 0.1875, 0.25], "in")
    assert read_specification(json.loads(spec.as_json())).as_json() == spec.as_json()
    assert Axis(("radii",), ["3/16 in", "1/4 in"]).values == [4.7625e-3, 6.35e-3]


def test_units_of_an_axis_are_kept_in_a_store(tmp_path):
    chain = {"diameters": "9 mm", "beads": 4, "materials": "glass", "velocity": "1 cm/s"}
    plan = {"chain": chain, "axes": {"diameters": ["8 mm", "10 mm"]}}
    hc.sweep(plan, tmp_path / "store.zarr")
    found = hc.open_sweep(tmp_path / "store.zarr")
    assert found.diameters.values.tolist() == [8.0, 10.0]
    assert found.diameters.units == "mm"
    hc.sweep(plan, tmp_path / "store.zarr")  # the same specification resumes


def test_a_store_has_the_attributes_of_a_sweep_in_memory(tmp_path):
    """Attributes that only the store needs are neither shown nor exported."""
    plan = {"chain": dict(FORWARD), "axes": {"rate": [0.02, 0.05]}}
    plain, stored = hc.sweep(plan), hc.sweep(plan, tmp_path / "store.zarr")
    export_sweep(stored, tmp_path / "sweep.nc")
    with xr.open_dataset(tmp_path / "sweep.nc", engine="h5netcdf") as exported:
        for found in (stored, exported):
            assert {key: found.attrs[key] for key in plain.attrs} == plain.attrs
            assert found.attrs.keys() - plain.attrs.keys() == {"schema"}
            for name, values in plain.variables.items():
                assert found[name].attrs.keys() - {"_FillValue"} == values.attrs.keys()


def test_units_in_a_specification():
    for path, values in (("gravity", ["1 m/s^2"]), ("method.until", ["2 ms"]),
                         ("struck_by.mass", ["5 g"]), ("right_wall.stiffness", ["7 N/um^1.5"]),
                         ("drive.amplitude", ["5 um"]), ("drive.amplitude", ["5 mN"])):  # fmt: skip
        drive = {"kind": "step", "rise": 1.0, "of": "displacement"}
        chain = BALLS | {"drive": drive, "struck_by": {"velocity": "2 cm/s"}}
        spec = read_specification({"chain": chain, "axes": {path: values},
                                   "sweep": {"methods": "simulate"}})  # fmt: skip
        assert isinstance(spec.axes[0].values[0], float)


def test_an_axis_within_a_list_that_has_a_unit():
    chain = {"radii": {"list": [5, 5, 4], "unit": "mm"}, "materials": "brass", "velocity": 0.02}
    plan = Plan(read_specification({"chain": chain, "axes": {"radii.2": ["3 mm", "4 mm"]}}))
    np.testing.assert_array_equal(plan.chain((1,)).radii, [5e-3, 4e-3, 4e-3])


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"chain": FORWARD | {"right_wall": {"rigid": "false"}}}, "rigid .* must be true or false"),
        ({"chain": FORWARD | {"units": "banana"}}, "unknown units of .chain. 'banana'"),
        ({"chain": FORWARD | {"right_wall": {"stif": 1}}}, "key of .chain.right_wall. 'stif'"),
        ({"chain": FORWARD | {"beads": "40"}}, "beads of .chain. must be a whole number, got '40'"),
        ({"materials": {"m": {"name": "x"}}}, "unknown key of .materials.m. 'name'"),
        ({"chain": {"file": {"a": 1}}}, "file of .chain. must be a path"),
        ({"axes": {"file": [{"a": 1}, {"a": 2}]}}, "file of .chain. must be a path"),
        ({"axes": {"right_wall.gap": {"list": [1, 2], "unit": "um"}}},
         "axes.right_wall.gap: has a unit, but the chains are in scaled variables"),
        ({"axes": {"right_wall.gap": ["1 um", "2 um"]}}, "gap: has a unit, but the chains are in"),
        ({"axes": {"right_wall.gap": {"linspace": ["1 um", "2 um", 3]}}}, "gap: has a unit"),
        ({"axes": {"right_wall.gap": {"linspace": ["1 um", "2 mm", 3]}}},
         "axes.right_wall.gap: linspace's first and last must have the same unit, got um and mm"),
        ({"axes": {"exponent": {"list": [150], "unit": "%"}}}, "unit '%', but exponent takes none"),
        ({"axes": {"exponent": ["150%"]}}, "exponent of .chain. must be a number, got '150%'"),
        ({"axes": {"rate": ["5 mm"]}}, "rate"),
        ({"axes": {"right_wall.gap": {"linspace": [1, 2, 3], "unit": "um"}}}, "gap: has a unit"),
        ({"method": {"until": "2 kg"}, "sweep": {"methods": ["simulate"]}}, "until must have a"),
        ({"method": {"until": "2 ms"}, "sweep": {"methods": ["simulate"]}}, "scaled variables"),
    ],
)  # fmt: skip
def test_specifications_have_a_strict_schema(change, said):
    given = {"chain": FORWARD | {"rate": 0.05}, "axes": {"exponent": [1.5]}}
    with pytest.raises(hc.InputError, match=said):
        hc.sweep(given | change)


def test_a_sweep_until_a_time_with_a_unit():
    chain = BALLS | {"right_wall": {}}
    settings = {"methods": ["simulate"], "keep": ["wall_impulse"]}
    peaks = [
        hc.sweep({"chain": chain, "axes": {"gravity": [0.0]}, "sweep": settings,
                  "method": {"until": until}}).wall_impulse.item()
        for until in ("0.2 ms", 2e-4)
    ]  # fmt: skip
    assert peaks[0] == peaks[1] > 0.0


def test_estimates_consider_points_that_take_longer(monkeypatch):
    """The times of chains with 10 and 80 beads alternate; every second batch has long ones."""
    from hertzchain.sweeps import timing

    spec = {"chain": {"taper": "forward-linear"}, "sweep": {"at": "last", "batch": 4},
            "axes": {"rate": {"linspace": [0.001, 0.01, 25]},
                     "beads": [8, 9, 10, 11, 80, 82, 84, 86]}}  # fmt: skip

    def time_of(plan, batch):
        return sum(1e-3 * plan.chain(index).beads for index in plan.indices(batch))

    monkeypatch.setattr(timing, "time_of_batch", time_of)
    expected = 25 * 1e-3 * (8 + 9 + 10 + 11 + 80 + 82 + 84 + 86)
    monkeypatch.setattr(timing, "SAMPLE_SECONDS", 0.2 * expected)
    found = estimate(spec, workers=1).seconds
    assert found == pytest.approx(expected, rel=0.15)


def test_short_times_are_plotted_in_microseconds():
    spec = {"chain": {"diameters": "10 mm", "materials": "steel-52100", "right_wall": {},
                      "velocity": "0.1 m/s"},
            "axes": {"beads": [5, 8]}, "sweep": {"methods": ["simulate"],
                                                 "keep": ["wall_duration"]}}  # fmt: skip
    found = hc.sweep(spec)
    axes = plot_sweep(found)
    assert axes.get_ylabel().endswith("[µs]")
    expected = 1e6 * found.wall_duration.squeeze().values
    np.testing.assert_allclose(axes.lines[0].get_ydata(), expected)
    assert 10.0 < expected.min() < 100.0


def sizes_of_one_bead(key, values):
    """Peaks on the wall of a row of equal balls, for velocities and sizes of bead 5."""
    row = hc.Chain.from_materials(
        ["5 mm"] * 8, "steel-52100", velocity="0.1 m/s", right_wall=hc.Wall()
    )
    found = hc.sweep({
        "chain": row, "axes": {"velocity": [0.1, 0.2], f"{key}.5": values},
        "sweep": {"methods": "simulate", "keep": "wall_peak_force", "at": "last"},
    })  # fmt: skip
    return row, found.wall_peak_force.values.squeeze()


@pytest.mark.parametrize(("key", "values"), [("radii", [0.004, 0.006]),
                                             ("diameters", ["8 mm", "12 mm"])])  # fmt: skip
def test_one_bead_of_a_chain_of_equal_beads_varies(key, values):
    row, peaks = sizes_of_one_bead(key, values)
    expected = np.empty((2, 2))
    for i, velocity in enumerate((0.1, 0.2)):
        for j, radius in enumerate((0.004, 0.006)):
            radii = np.where(np.arange(8) == 4, radius, 0.005)
            chain = row.replace(radii=radii, velocities=velocity * (np.arange(8) == 0))
            expected[i, j] = hc.simulate(chain, times=0).wall_force().peak
    np.testing.assert_allclose(peaks, expected, rtol=1e-7)


@pytest.mark.parametrize(
    ("chain", "axis", "same", "values"),
    [
        # One value for all, in a chain file.
        ({"radii": 1.0, "beads": 6}, "radii.3", {"radii": [1.0] * 6}, [0.9, 1.0]),
        ({"radii": "5 mm", "beads": 6, "materials": "steel-52100"}, "radii.3",
         {"radii": ["5 mm"] * 6, "materials": "steel-52100"}, ["4 mm", "5 mm"]),
        ({"diameters": ["8 mm", "9 mm", "8 mm"], "materials": "steel-52100"}, "materials.3",
         {"diameters": ["8 mm", "9 mm", "8 mm"], "materials": ["steel-52100"] * 3},
         ["ptfe", "steel-52100"]),
        # Chains that are written as tapers, and contacts without gaps.
        (hc.Chain.tapered("forward-exponential", 0.05, beads=6), "radii.3",
         {"radii": hc.Chain.tapered("forward-exponential", 0.05, beads=6).radii.tolist()},
         [0.9, 1.0]),
        (hc.Chain.from_materials("5 mm", "steel-52100", beads=4), "gaps.2",
         {"radii": "5 mm", "beads": 4, "materials": "steel-52100", "gaps": [0.0] * 3},
         ["1 um", "2 um"]),
    ],
)  # fmt: skip
@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
def test_axes_of_single_values_need_no_list(chain, axis, same, values):
    rest = {"axes": {axis: values}, "sweep": {"methods": "simulate", "at": "last"}}
    found, expected = (hc.sweep({"chain": each} | rest) for each in (chain, same))
    assert (found.status == 1).all()
    np.testing.assert_allclose(found.velocity, expected.velocity, rtol=1e-12)
    assert np.ptp(found.velocity.values) > 0.0


@pytest.mark.parametrize(
    ("chain", "message"),
    [
        ({"taper": "uniform", "beads": 160}, "[chain] has no list radii: list the radii, or write "
         "radii = 1.0 and beads = 160 instead of the taper"),
        ({"taper": "uniform", "radius": "5 mm", "materials": "ptfe", "beads": 9},
         "[chain] has no list radii: list the radii, or write radii = '5 mm' and beads = 9 instead "
         "of the taper"),
        ({"diameters": "5 mm", "beads": 9, "materials": "ptfe"},
         "[chain] has no list radii: list the radii, or vary diameters.5"),
        ({"radii": "5 mm", "materials": "ptfe"},
         "[chain] has one value of radii, '5 mm', for all: list the radii, or give beads, the "
         "number of equal beads"),
    ],
)  # fmt: skip
def test_errors_about_missing_lists_name_only_their_axis(chain, message):
    axes = {"velocity": [0.1, 0.2], "radii.5": ["4 mm", "5 mm"]}
    with pytest.raises(hc.InputError) as caught:
        hc.sweep({"chain": chain, "axes": axes})
    assert str(caught.value) == f"axes.radii.5: {message}"


LONG_RUNS = {
    "chain": {"radii": "5 mm", "materials": "steel-52100", "beads": 300, "right_wall": {}},
    "axes": {"velocity": {"linspace": [0.01, 0.02, 100]}},
    "sweep": {"methods": "simulate", "keep": "wall_peak_force"},
}


def test_estimated_files_are_those_of_the_store(tmp_path):
    """In SI units, each batch also writes variables about the range and the completeness."""
    given = {
        "chain": {"radii": "5 mm", "materials": "steel-52100", "beads": 5, "right_wall": {}},
        "axes": {"velocity": [0.001, 0.002, 0.003, 0.004]},
        "sweep": {"methods": "simulate", "keep": "wall_peak_force", "batch": 1},
    }
    hc.sweep(given, tmp_path / "sweep")
    files = [file for file in (tmp_path / "sweep").rglob("*") if file.is_file()]
    assert abs(estimate(given, workers=1).files - len(files)) <= 3


def test_estimates_do_not_wait_for_long_runs(monkeypatch):
    hc.sweep(LONG_RUNS | {"axes": {"beads": [4], "velocity": [0.01]}})  # compiles
    monkeypatch.setattr(timing, "LONGEST", 0.05)
    found = estimate(LONG_RUNS, workers=2)
    assert found.unfinished
    assert found.seconds == pytest.approx(100 * 0.05 / 2)


def test_compiling_is_not_part_of_the_limit_of_an_estimate(monkeypatch):
    # A clock that advances by an hour within the first call only.
    times = iter([0.0, 3600.0, *(3600.0 + 0.1 * np.arange(1, 200))])
    monkeypatch.setattr(timing.time, "perf_counter", lambda: float(next(times)))
    limit = timing._Limit()
    calls = 1
    while not limit():
        calls += 1
    assert 0.1 * calls == pytest.approx(timing.LONGEST - timing.CALLED, abs=0.25)


def test_estimates_of_points_of_different_length_are_lower_bounds_if_one_is_unfinished(monkeypatch):
    def time_of(plan, batch):
        (index, *_) = plan.indices(batch)
        return np.inf if plan.chain(index).beads > 50 else 1e-3

    monkeypatch.setattr(timing, "time_of_batch", time_of)
    spec = {"chain": {"taper": "uniform"}, "axes": {"beads": [*range(10, 60)]}}
    found = timing.time_per_point(read_specification(spec | {"sweep": {"batch": 1}}))
    assert found.unfinished
    assert 1e-3 < found.seconds <= timing.LONGEST


def test_a_point_that_fails_by_two_methods_counts_once(run, tmp_path):
    (tmp_path / "sweep.toml").write_text("""
        [chain]
        taper = "forward-linear"
        [axes]
        rate = [0.01, 0.02, 0.05]
        beads = [20, 40, 60]
        [sweep]
        methods = ["propagate", "bca"]
    """)
    code, out, _ = run("sweep", tmp_path / "sweep.toml", "--store", tmp_path / "store")
    assert code == 1
    assert "6 of 9 points done, 3 failed" in out
    assert "(and 2 more points, similarly)" in out


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
def test_a_sweep_states_its_assumed_yield_pressure(run, tmp_path):
    spec = {"chain": {"diameters": "8 mm", "beads": 3, "material": "brass", "velocity": "0.1 m/s",
                      "loss": {"law": "elastic-plastic"}},
            "axes": {"velocity": [0.1]}, "sweep": {"methods": ["simulate"], "keep": ["velocity"]},
            }  # fmt: skip
    note = "the yield pressure is assumed to be 1.6 times the yield strength"
    found = hc.sweep(spec, tmp_path / "store")
    assert found.attrs["yield_pressure"].startswith(note)
    *_, last = hc.plot_sweep(found, bead=3).get_title().split("\n")
    assert last == "contacts yield at 1.6 Y (Y: yield strength)"
    assert f"  note: {note}" in run("sweep", "status", tmp_path / "store")[1]
    spec["axes"] = {"loss": [{"law": "elastic-plastic"}, {"law": "elastic"}], **spec["axes"]}
    both = hc.sweep(spec)
    titles = [hc.plot_sweep(both, bead=3, loss=law).get_title() for law in both.loss.to_numpy()]
    assert [title.endswith("yield strength)") for title in titles] == [True, False]
    del spec["axes"]["loss"]
    spec["chain"]["loss"]["factor"] = 2.8
    found = hc.sweep(spec)
    assert "yield_pressure" not in found.attrs
    assert "yield" not in hc.plot_sweep(found, bead=3).get_title()


def test_failed_points_are_grouped_by_their_reasons(run, tmp_path):
    (tmp_path / "sweep.toml").write_text("""
        [chain]
        taper = "uniform"
        beads = 8
        [axes]
        exponent = [1.4, 1.5, 1.6]
        "method.max_steps" = [10, 20, 100000]
        [sweep]
        methods = "simulate"
    """)
    code, out, _ = run("sweep", tmp_path / "sweep.toml", "--store", tmp_path / "store")
    assert code == 1
    shown = [line for line in out.splitlines() if "stopped by the step limit" in line]
    assert len(shown) == 1
    assert "max_steps = 10" in shown[0]
    assert "(and 5 more points, similarly)" in shown[0]
    assert "see variable `reason`" not in out


def test_misspelt_full_names_are_recognised():
    document = {
        "chain": {"beads": 4, "right_wall": "same"}, "axes": {"beads": [4, 5]},
        "sweep": {"methods": ["simulate"], "keep": ["wall_forc.peak"]},
    }  # fmt: skip
    said = r"did you mean 'wall_force\.peak'.*wall_peak_force.* body_force\.peak"
    with pytest.raises(hc.InputError, match=said):
        hc.sweep(document)
