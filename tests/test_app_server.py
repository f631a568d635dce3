"""The server of `hertzchain app`: its numbers, its files, and how it starts."""

import base64
import csv
import http.client
import io
import json
import math
import os
import re
import signal
import subprocess
import sys
import threading
import time
import tomllib
import warnings
from pathlib import Path

import click
import matplotlib.pyplot as plt
import numpy as np
import pytest
from app_client import STEEL, TAPER, WALL, Client, computed, serving, unpacked

import hertzchain as hc
from hertzchain.app import background_import
from hertzchain.app import results as app_results
from hertzchain.app.about import about, gallery
from hertzchain.app.documents import chain_of, document_as_toml, document_of_file, document_of_toml
from hertzchain.app.exports import _pulse_axes
from hertzchain.app.force_curves import contact_durations
from hertzchain.app.messages import Part
from hertzchain.app.results import Cancelled, limited
from hertzchain.app.serve import RunningServer, bind
from hertzchain.app.warm_up import WarmUp
from hertzchain.app.wording import chain_in_words, on_the_page, sentences, warnings_on_the_page
from hertzchain.cli import cli
from hertzchain.simulation import wall_watch
from hertzchain.theory.catalogue import THEORIES
from hertzchain.warm_start import Stage


@pytest.fixture(scope="module")
def running():
    with serving(TAPER) as found:
        yield found


@pytest.fixture
def client(running):
    return Client(running)


# Numbers -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("document", [TAPER, STEEL], ids=["scaled", "SI"])
def test_pulses_are_those_of_the_library(client, document):
    answer = client.results(document)
    assert [header["part"] for header, _ in answer] == ["status", "beads", "pulse", "run"]
    parts = {header["part"]: (header, arrays) for header, arrays in answer}
    chain = chain_of(document)
    methods = {"bca": hc.bca(chain), "hard-sphere": hc.hard_sphere(chain),
               "local-rate": hc.local_rate(chain), "exact": hc.propagate(chain)}  # fmt: skip
    sent = parts["beads"][1] | parts["pulse"][1]
    for name, pulse in methods.items():
        for quantity, values in pulse.columns().items():
            assert np.array_equal(sent[f"{name}.{quantity}"], values), (name, quantity)
    assert np.array_equal(sent["radii"], chain.radii)


def test_runs_are_those_of_the_library():
    header, arrays = computed(WALL, frames=100, sensors=[7])["run"]
    chain = hc.Chain.uniform(20).replace(right_wall=hc.Wall.rigid())
    run = hc.simulate(chain, times=arrays["times"], rtol=1e-9)
    for name, values in (("velocities", run.velocities), ("forces", run.forces)):
        shown = arrays[name] * (arrays[f"{name}.scale"] / 32767)
        # Half a step of 16 bits, relative to the largest value of each bead.
        assert np.all(np.abs(shown - values) <= 1.6e-5 * np.abs(values).max(axis=0))
        assert np.any(values)
    fine = hc.simulate(chain, times=arrays["forces.times"], rtol=1e-9)
    assert np.array_equal(arrays["force.7"], fine.sensor(7))
    assert np.array_equal(arrays["force.right"], fine.forces[:, -1])
    assert header["peaks"]["right"]["first"] == run.wall_force().peak
    budget = run.budget()
    for name in ("contacts", "leading pulse"):
        assert np.array_equal(arrays[f"energy.{name}"], budget.energy[name].astype("f4"))
    pulse = computed(WALL)["pulse"][1]
    assert np.array_equal(pulse["exact.velocity"], run.pulse().velocity)


def test_the_budget_of_a_compressed_chain_is_that_over_the_static_state():
    crystal = {"taper": "uniform", "beads": 12, "precompression": 0.5, "held_by": "force"}
    header, arrays = computed({"chain": crystal})["run"]
    assert header["over_static"].startswith("Excess over the static state")
    total = sum(values for name, values in arrays.items() if name.startswith("energy."))
    assert total == pytest.approx(0.5, rel=1e-6)
    header, _ = computed(WALL)["run"]
    assert header["over_static"] == ""


def test_the_force_of_a_drive_is_shown():
    drive = {"kind": "table", "of": "force", "times": [0.0, 3.0, 7.3, 12.0],
             "values": [0.0, -0.2, 0.5, 0.0]}  # fmt: skip
    row = {"taper": "uniform", "beads": 9, "velocities": 0.0, "drive": drive}
    header, arrays = computed({"chain": row}, run_until=20.0)["run"]
    expected = hc.TableDrive(drive["times"], drive["values"]).value(arrays["forces.times"])
    assert np.array_equal(arrays["force.drive"], expected)
    assert header["peaks"]["drive"]["shown"] == [["largest", 0.5, 7.3]]
    # A constant force has no time.
    row["drive"] = {"kind": "step", "amplitude": 0.1}
    header, _ = computed({"chain": row}, run_until=20.0)["run"]
    assert header["peaks"]["drive"]["shown"] == [["largest", 0.1, None]]
    # The note does not name functions of Python.
    note = computed({"chain": row}, run_until=20.0)["pulse"][0]["note"]
    assert "residence: bead 1: not struck" in note
    assert "Run." not in note


def steep(rate, beads):
    wall = {"rigid": True}
    taper = {"taper": "forward-exponential", "rate": rate, "beads": beads, "right_wall": wall}
    return {"chain": taper}


@pytest.mark.parametrize("clock", ["beads", "time"])
@pytest.mark.parametrize("document", [WALL, steep(0.03, 60), steep(0.1, 35)], ids=str)
def test_the_peak_on_a_wall_is_complete_and_shown(document, clock):
    wall = hc.simulate(chain_of(document), times=0, rtol=1e-9).wall_force()
    header, arrays = computed(document, frames=320, clock=clock)["run"]
    peak = header["peaks"]["right"]
    assert (peak["first"], peak["time"]) == (wall.peak, wall.peak_time)
    assert peak["impact"] == [
        ["impulse of the impact", wall.impulse_of_impact, "N s"],
        ["duration (impulse / peak)", wall.duration, "s"],
    ]
    assert arrays["times"].size == 320
    assert arrays["times"][-1] > wall.peak_time


def test_a_run_that_ends_before_the_impact_on_a_soft_wall_says_so(monkeypatch):
    monkeypatch.setattr(wall_watch, "MAX_REBOUNDS", 0.0)
    row = {"diameters": "12 mm", "beads": 60, "materials": "steel-52100", "velocity": "0.3 m/s"}
    document = {"chain": {**row, "right_wall": {"stiffness": 1e6}}}
    whole = hc.simulate(chain_of(document), times=0, rtol=1e-9, check=False)
    # The peak is complete, but the wall is loaded for much longer.
    assert whole.wall_force().complete_since is None
    header, arrays = computed(document, frames=320)["run"]
    assert arrays["times"][-1] >= whole.end_time > 4.0 * whole.wall_force().peak_time
    said = header["warnings"][-1]
    assert said.startswith(f"the run ends at t = {1e3 * arrays['times'][-1]:.4g} ms; the impact")
    assert "has not ended: the wall is still loaded with" in said
    assert header["peaks"]["right"]["impact"] == []


def test_an_impact_without_a_complete_peak_says_so():
    chain = {"taper": "uniform", "beads": 10, "right_wall": {}}
    drive = {"kind": "step", "of": "force", "amplitude": 0.1}
    ended, driven = (computed({"chain": {**chain, **more}})["run"][0]["warnings"]
                     for more in ({}, {"drive": drive}))  # fmt: skip
    assert not any("the run ends" in each for each in ended)
    assert re.search("the run ends at .*; the peak on the right wall is not complete", driven[-1])


def test_a_table_whose_time_0_is_rounded_is_shown_to_the_end_of_its_pulse():
    times = 2e-6 * np.arange(-70, 130)
    times[70] = 7e-21
    force = np.where((times > 0.0) & (times < 2e-5), 10.0, 0.1)
    drive = {"kind": "table", "of": "force", "times": times.tolist(), "values": force.tolist()}
    row = {"diameters": "10 mm", "beads": 8, "materials": "steel-52100", "velocity": "0 m/s"}
    parts = computed({"chain": {**row, "drive": drive, "right_wall": {}}}, sensors=[4])
    header, arrays = parts["run"]
    assert arrays["times"][-1] > times[-1]
    assert header["peaks"]["right"]["largest"] > 1.0
    assert header["warnings"][-1].endswith(
        "the peak on the right wall is not complete: the drive does not end: a force of 0.1 N "
        "remains"
    )


def test_contacts_that_are_still_closed_are_stated():
    heavy = {"diameters": "12 mm", "beads": 20, "materials": "steel-52100",
             "struck_by": {"velocity": "10 mm/s", "mass": "5 kg"}}  # fmt: skip
    header, arrays = computed({"chain": heavy})["run"]
    closed = int(np.count_nonzero(arrays["forces"][-1].reshape(-1)))
    assert header["message"].endswith(
        f"{closed} contacts still closed, so velocities are not final"
    )
    assert "closed" not in computed(TAPER)["run"][0]["message"].replace("nothing", "")


def test_the_peak_with_contacts_that_yield_is_stated():
    row = {"diameters": "12 mm", "beads": 10, "materials": "steel-316", "right_wall": {}}
    yields, below = ({"chain": {**row, "velocity": each}} for each in ("2 m/s", "1 mm/s"))
    peak = computed(yields)["run"][0]["peaks"]["right"]
    dented = chain_of(yields).replace(loss=hc.ElasticPlastic())
    expected = hc.simulate(dented).wall_force().peak
    harder = chain_of(yields).replace(loss=hc.ElasticPlastic(factor=2.8))
    harder = hc.simulate(harder).wall_force().peak
    assert peak["yielding"] == pytest.approx(expected, rel=1e-6)
    assert peak["first"] > 10.0 * expected
    assert [each[:2] for each in peak["shown"]] == [
        ["peak", peak["first"]],
        ["peak if contacts yield at 1.6 Y", peak["yielding"]],
        ["at 2.8 Y", pytest.approx(harder, rel=1e-6)],
    ]
    # Contacts that do not yield have the same peak; that of other losses is not known.
    peak = computed(below)["run"][0]["peaks"]["right"]
    assert peak["yielding"] == peak["first"]
    assert len(peak["shown"]) == 1
    plastic = {"chain": {**yields["chain"], "loss": {"law": "elastic-plastic"}}}
    header = computed(plastic)["run"][0]
    peak = header["peaks"]["right"]
    assert peak["yielding"] == peak["first"] == pytest.approx(expected, rel=1e-6)
    # The table of two chains compares it with an elastic one at both pressures.
    assert [each[:2] for each in peak["shown"]] == [
        ["peak", peak["first"]],
        ["peak if contacts yield at 1.6 Y", pytest.approx(expected, rel=1e-6)],
        ["at 2.8 Y", pytest.approx(harder, rel=1e-6)],
    ]
    assert sum("the yield pressure is assumed" in each for each in header["warnings"]) == 1
    # A given pressure is neither of both, unless no contact yields.
    given = {"law": "elastic-plastic", "factor": 2.8}
    for chain, same in ((yields["chain"], False), (below["chain"], True)):
        peak = computed({"chain": {**chain, "loss": given}})["run"][0]["peaks"]["right"]
        assert len(peak["shown"]) == 1
        assert peak["yielding"] == (peak["first"] if same else None)
    lossy = {"chain": {**yields["chain"], "loss": LOSS}}
    assert computed(lossy)["run"][0]["peaks"]["right"]["yielding"] is None


def test_a_note_states_that_the_pressure_of_a_peak_with_yield_is_assumed():
    row = {"diameters": "12 mm", "beads": 10, "materials": "steel-316", "right_wall": {}}
    for velocity, stated in (("2 m/s", True), ("1 mm/s", False)):
        warnings = computed({"chain": {**row, "velocity": velocity}})["run"][0]["warnings"]
        note = "peak if contacts yield at 1.6 Y: the yield pressure is assumed"
        assert any(each.startswith(note) for each in warnings) == stated


def test_a_peak_with_yield_outside_the_range_of_the_law_says_so():
    row = {"diameters": "10 mm", "beads": 5, "materials": "ptfe", "right_wall": {}}
    peak = computed({"chain": {**row, "velocity": "20 m/s"}})["run"][0]["peaks"]["right"]
    label, value, time = peak["shown"][1]
    assert label == "peak if contacts yield at 1.6 Y, outside the range of the law"
    assert 0.0 < value < peak["first"]
    assert time is None
    # The table of two chains does not compare it.
    assert peak["yielding"] is None


def test_the_pressure_of_each_contact_is_compared_with_yield():
    chain = {"diameters": ["6 mm", "4 mm", "5 mm"], "materials": "steel-52100",
             "velocity": "0.2 m/s", "right_wall": {"material": "steel-52100"}}  # fmt: skip
    run = hc.simulate(chain_of({"chain": chain}), times=0, rtol=1e-9, check=False)
    ratios = hc.hertz_range(run.chain, run.largest_overlaps).yield_ratio
    assert len(ratios) == 4
    _, arrays = computed({"chain": chain})["run"]
    assert arrays["yield_ratio"] == pytest.approx(ratios[1:], rel=1e-5)
    assert "dent" not in arrays
    # Scaled chains have no materials.
    assert "yield_ratio" not in computed(WALL)["run"][1]


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
@pytest.mark.parametrize("loss", [
    {"law": "elastic-plastic"}, {"law": "elastic"}, {"law": "restitution", "coefficient": 0.9},
])  # fmt: skip
def test_largest_forces_pressures_and_dents_are_those_of_the_whole_run(loss):
    # The second impact of the heavy flat hammer causes larger forces than the first pulse.
    chain = {"diameters": "10 mm", "beads": 6, "materials": "steel-52100", "loss": loss,
             "right_wall": {"stiffness": 2e7, "exponent": 1, "loss": {"law": "elastic"}},
             "struck_by": [{"mass": "150 g", "radius": "inf", "velocity": "1.5 m/s"}]}  # fmt: skip
    _, arrays = computed({"chain": chain})["run"]
    own = chain_of({"chain": chain})
    run = hc.simulate(own, until="2 ms", times=20_001, rtol=1e-10, check=False)
    forces = np.abs(run.forces).max(axis=0)[1:]
    assert arrays["largest_force"] == pytest.approx(forces, rel=2e-3)
    assert (arrays["largest_force"][1:-1] > 1.5 * run.pulse().peak_force[1:]).any()
    limits = hc.hertz_range(own, run.largest_overlaps)
    ratios = np.fmax(limits.yield_ratio, limits.law_yield_ratio)[1:]
    assert arrays["yield_ratio"] == pytest.approx(ratios, rel=2e-3, nan_ok=True)
    # Pressures belong to these forces: p^3 is proportional to the force of an elastic contact.
    if loss["law"] == "elastic":
        parts = arrays["yield_ratio"][1:-1] ** 3 / arrays["largest_force"][1:-1]
        assert parts == pytest.approx(parts[0], rel=1e-4)
    if loss["law"] == "elastic-plastic":
        assert arrays["dent"] == pytest.approx(run.dents[1:], rel=2e-3)
    else:
        assert "dent" not in arrays


def test_beads_of_several_materials_are_described():
    diameters = ["6 mm", "12 mm", "6 mm", "10 mm"]
    materials = ["ptfe", "steel-316", "ptfe", "steel-316"]
    both = {"chain": {"diameters": diameters, "materials": materials, "velocity": "0.1 m/s"}}
    header, arrays = computed(both)["beads"]
    assert header["kinds"] == [["ptfe", "6 mm"], ["steel-316", "12 mm to 10 mm"]]
    assert arrays["kinds"].tolist() == [0, 1, 0, 1]
    assert computed(STEEL)["beads"][0]["kinds"] == []


LOSS = {"law": "restitution", "coefficient": 0.8}
LOSSY = {"chain": {**STEEL["chain"], "loss": LOSS}}


@pytest.mark.long
@pytest.mark.parametrize("clock", ["beads", "time"])
@pytest.mark.parametrize("document", [WALL, STEEL, LOSSY], ids=["wall", "SI", "loss"])
def test_maxima_in_sensors_do_not_depend_on_the_clock(document, clock):
    peaks = computed(document, frames=320, clock=clock, sensors=[3, 10])["run"][0]["peaks"]
    chain = chain_of(document)
    end = hc.simulate(chain, times=0, rtol=1e-9).end_time
    run = hc.simulate(chain, times=np.linspace(0.0, end, 40_001), rtol=1e-9)
    for bead in (3, 10):
        sensor = run.sensor_force(bead)
        assert peaks[str(bead)]["first"] == pytest.approx(sensor.first_maximum, rel=2e-6)


HARD_AND_SOFT = {
    "chain": {
        "radii": "4.75 mm", "materials": ["steel-52100"] * 6 + ["ptfe"] * 6,
        "struck_by": {"diameter": "19 mm", "material": "steel-52100", "velocity": "2 mm/s"},
        "right_wall": {"material": "steel-52100"},
    }
}  # fmt: skip


@pytest.mark.parametrize("clock", ["beads", "time"])
def test_forces_after_the_first_transit_are_resolved(clock):
    """The largest force is that of a short oscillation between two frames of the animation."""
    header, arrays = computed(HARD_AND_SOFT, frames=320, clock=clock, sensors=[4])["run"]
    times, force = arrays["forces.times"], arrays["force.5"]
    chain = chain_of(HARD_AND_SOFT)
    run = hc.simulate(chain, times=np.linspace(0.0, times[-1], 100_001), rtol=1e-9)
    sensor = run.sensor_force(5)
    peaks = header["peaks"]["5"]
    assert peaks["largest"] == pytest.approx(sensor.largest_so_far, rel=1e-4)
    assert peaks["largest_time"] == pytest.approx(sensor.largest_so_far_time, rel=1e-4)
    assert peaks["largest"] > 1.05 * peaks["first"]
    assert [each[0] for each in peaks["shown"]] == ["first maximum", "largest in this run"]
    # Straight lines between the points deviate by at most 4% of the largest force.
    assert np.abs(np.interp(run.times, times, force) - sensor.force).max() < 0.04 * force.max()
    assert len(times) < 2000
    assert not any("forces in sensors" in each for each in header["warnings"])


def test_forces_that_are_not_resolved_are_stated():
    header, arrays = computed(steep(0.1, 35), frames=320)["run"]
    assert 4000 <= len(arrays["forces.times"]) <= 4320
    said = [each for each in header["warnings"] if each.startswith("forces in sensors and on")]
    assert len(said) == 1
    assert "forces in between are not shown" in said[0]


def test_durations_of_contacts_are_those_of_collisions():
    pair = hc.Chain.from_materials([5e-3, 3e-3], "steel-52100", velocity=0.1)
    pair = pair.replace(right_wall=hc.Wall.rigid(gap=1e-3))
    # Until the second ball returns from the wall.
    run = hc.simulate(pair, until=7e-3, times=400_001, rtol=1e-9)
    inner, wall = contact_durations(pair, run.largest_overlaps)[1:]
    for duration, force in ((inner, run.forces[:, 1]), (wall, run.forces[:, 2])):
        assert np.ptp(run.times[force > 0.0]) == pytest.approx(duration, rel=0.01)


def test_negative_residence_times_have_a_note():
    bouncing = {"chain": {"diameters": ["20 mm", "4 mm"] * 4, "materials": "steel-52100",
                          "velocity": "10 mm/s"}}  # fmt: skip
    header, arrays = computed(bouncing)["pulse"]
    assert arrays["exact.residence"].min() < 0.0
    assert header["table_note"].startswith("residence: negative where")
    assert computed(TAPER)["pulse"][0]["table_note"] == ""


def test_a_chain_with_a_wall_begins_without_a_sensor():
    wall = {"chain": {**TAPER["chain"], "right_wall": {}}}
    assert about(wall)["sensors"] == []
    # The page chooses the middle bead; its example has a sensor, too.
    assert about(TAPER)["sensors"] is about()["sensors"] is None
    assert "m v² / 2" in about()["quantities"]["energy"]["description"]


def test_the_table_explains_negative_residence_times(client):
    bouncing = {"chain": {"diameters": ["20 mm", "4 mm"] * 4, "materials": "steel-52100",
                          "velocity": "10 mm/s"}}  # fmt: skip
    head, *rows = csv.reader(io.StringIO(exported(client, bouncing, "csv").decode()))
    column = head.index("residence (simulation) [s]")
    early = [bool(row[column]) and float(row[column]) < 0.0 for row in rows]
    assert any(early)
    assert head[-1] == "note"
    assert [row[-1].startswith("residence: negative where") for row in rows] == early
    assert {len(row) for row in rows} == {len(head)}
    assert "note" not in exported(client, TAPER, "csv").decode().splitlines()[0]


def test_drafts_and_endless_drives_have_the_largest_force_so_far():
    peak = computed(steep(0.1, 40), frames=60, draft=True, rtol=1e-6)["run"][0]["peaks"]["right"]
    assert peak["first"] is None
    assert peak["largest"] > 0.0
    assert peak["shown"][0][0] == "largest so far"
    assert [each[1] for each in peak["impact"]] == [None, None]
    burst = {"kind": "step", "of": "force", "amplitude": 0.1}
    driven = {"chain": {"taper": "uniform", "beads": 10, "drive": burst, "right_wall": {}}}
    peak = computed(driven, frames=60)["run"][0]["peaks"]["right"]
    assert (peak["first"], peak["impact"]) == (None, [])
    assert peak["largest"] > 0.0
    assert peak["shown"][0][0] == "largest in this run"
    held = {"taper": "uniform", "beads": 10, "left_wall": {}, "right_wall": {}}
    pressed = {"chain": {**held, "precompression": 0.1}}
    peaks = computed(pressed, frames=60, sensors=[5])["run"][0]["peaks"]
    assert peaks["5"]["shown"][-1][0] == "largest in this run (with the static force)"


@pytest.mark.parametrize("draft", [False, True])
def test_a_constant_force_has_no_time(draft):
    row = {"diameters": "10 mm", "beads": 12, "materials": "steel-52100", "right_wall": {}}
    pressed = row | {"velocity": "0 m/s", "precompression": "15 N", "left_wall": {}}
    peaks = computed({"chain": pressed}, sensors=[4], draft=draft)["run"][0]["peaks"]
    assert list(peaks) == ["4", "left", "right"]
    for each in peaks.values():
        ((words, force, time),) = each["shown"]
        assert words.endswith("(with the static force)")
        # Differences are rounding errors.
        assert (force, time) == (pytest.approx(15.0, rel=1e-12), None)
        assert each["largest_time"] is None
    # The pulse changes the force by about 1%.
    slow = pressed | {"velocity": "1 mm/s"}
    for each in computed({"chain": slow}, sensors=[4], draft=draft)["run"][0]["peaks"].values():
        *_, (_, force, time) = each["shown"]
        assert 15.0 < force < 15.3
        assert time > 0.0


def test_times_show_each_bead_equally_long():
    times = computed(TAPER, frames=200)["run"][1]["times"]
    arrival = hc.propagate(chain_of(TAPER)).arrival
    passed = np.searchsorted(times, arrival)
    assert np.ptp(np.diff(passed)[1:]) <= 1
    # In this taper, equally spaced times would spend most frames on the last beads.
    even = computed(TAPER, frames=200, clock="time")["run"][1]["times"]
    assert np.diff(even).max() < 1.001 * np.diff(even).min()
    assert np.searchsorted(even, arrival[20]) < 0.25 * len(even)


@pytest.mark.parametrize("clock", ["beads", "time"])
@pytest.mark.parametrize("gaps", [[0.0], [0.02], [0.02, 0.0], [1e-5, 0.0, 0.0]], ids=str)
def test_short_chains_are_shown_until_the_last_bead_has_separated(gaps, clock):
    chain = {"radii": [0.01] * (len(gaps) + 1), "materials": "steel-52100", "velocity": 0.2}
    document = {"chain": {**chain, "gaps": gaps}}
    arrays = computed(document, frames=320, clock=clock)["run"][1]
    exact = hc.simulate(chain_of(document), until=0.3, times=0).pulse()
    last = arrays["velocities"][-1, -1] / 32767 * arrays["velocities.scale"][-1]
    assert last == pytest.approx(exact.velocity[-1], rel=1e-4)
    if len(gaps) == 1:  # Two equal balls exchange their velocities.
        assert last == pytest.approx(0.2, rel=1e-4)
    assert np.all(np.diff(arrays["times"]) > 0.0)


@pytest.mark.parametrize("beads", [2, 3, 20])
def test_the_impact_of_a_ball_from_a_distance_is_resolved(beads):
    gaps = [0.003] + [0.0] * (beads - 2)
    document = {"chain": {"radii": [0.01] * beads, "materials": "steel-52100", "velocity": 0.2,
                          "gaps": gaps}}  # fmt: skip
    arrays = computed(document, frames=320)["run"][1]
    # Exact times between which the second ball has gained 1% and 80% of its velocity.
    exact = hc.simulate(chain_of(document), until=0.016, times=16001)
    gained = exact.velocities[:, 1] / exact.velocities[:, 1].max()
    begin, end = (exact.times[np.argmax(gained > part)] for part in (0.01, 0.8))
    times = arrays["times"]
    assert times[-1] > end
    assert np.count_nonzero((times > begin) & (times < end)) >= 5


@pytest.mark.parametrize("clock", ["beads", "time"])
@pytest.mark.parametrize("gap", [1e-4, 0.02, 0.2])
def test_the_impact_on_a_distant_wall_is_shown(gap, clock):
    # One ball struck by another, which flies to the wall with the velocity of the striker.
    chain = {"radii": [0.01, 0.01], "materials": "steel-52100", "velocity": 0.2, "gaps": [0.003],
             "right_wall": {"material": "steel-52100", "gap": gap}}  # fmt: skip
    header, arrays = computed({"chain": chain}, frames=320, clock=clock)["run"]
    arrival = (0.003 + gap) / 0.2
    assert arrival < header["peaks"]["right"]["largest_time"] < arrival + 3e-4
    assert arrays["times"][-1] > header["peaks"]["right"]["largest_time"]


def test_a_long_flight_to_the_wall_does_not_take_the_frames_of_the_passage():
    wall = {"material": "steel-52100", "gap": "20 mm"}
    document = {"chain": {**STEEL["chain"], "right_wall": wall}}
    header, arrays = computed(document, frames=320)["run"]
    times, force = arrays["times"], arrays["force.right"]
    passed = hc.propagate(chain_of(STEEL)).arrival[-1]
    assert np.count_nonzero(times < passed) > 120
    assert times[-1] > 20 * passed
    # The impact itself is resolved.
    assert force.max() > 0.95 * header["peaks"]["right"]["largest"]


def test_theories_that_do_not_cover_a_chain_give_their_reason():
    theories = computed(WALL)["beads"][0]["theories"]
    with pytest.raises(hc.InputError) as error:
        hc.bca(chain_of(WALL))
    refusal = str(error.value)
    assert "; use simulate, or omit the wall: chain.replace(right_wall=None) (chain" in refusal
    # The page simulates each chain.
    assert theories["bca"] == {"refusal": refusal.partition("; use simulate")[0]}


@pytest.mark.parametrize("example", gallery(), ids=lambda example: example["title"])
def test_examples_have_results(example):
    for document in (example["document"], example["other"]):
        if document is not None:
            parts = computed(document, frames=60, draft=True)
            assert parts["run"][0]["success"]
            assert np.isfinite(parts["pulse"][1]["exact.velocity"]).any()
    assert example["look_for"].endswith(".")


def example_chain(title, part="document"):
    return chain_of(next(each for each in gallery() if each["title"] == title)[part])


def shares(parts):
    """Shares of the parts of a budget in its total at the last saved time."""
    total = sum(values[-1] for values in parts.values())
    return {name: values[-1] / total for name, values in parts.items()}


def test_numbers_in_texts_of_examples_are_those_of_simulations():
    texts = {each["title"]: each["look_for"] for each in gallery()}

    def stated(title, *values):
        found = [float(each) for each in re.findall(r"([\d.]+)%", texts[title])]
        assert len(found) == len(values), title
        assert found == pytest.approx([100 * value for value in values], abs=0.5), title

    balls = example_chain("Steel balls in front of a wall")
    taper = {"first_diameter": "20 mm", "last_diameter": "8 mm", "beads": 20}
    smaller = hc.Chain.tapered(**taper, material="steel-52100", velocity="0.1 m/s")
    lower = hc.simulate(smaller.replace(right_wall=hc.Wall())).wall_force().peak
    run = hc.simulate(balls)
    peak = run.wall_force().peak
    stated("Steel balls in front of a wall", 1.0 - lower / peak)
    assert peak / run.pulse().peak_force[10] == pytest.approx(1.9, abs=0.05)
    equal = hc.simulate(example_chain("Equal beads: a solitary wave"))
    stated("Equal beads: a solitary wave", equal.pulse().velocity[30], -equal.velocities[-1, 0])
    forward = hc.simulate(example_chain("Forward-exponential taper"))
    budget = forward.budget()
    energy, momentum = shares(budget.energy), shares(budget.momentum)
    radii = forward.chain.radii
    stated(
        "Forward-exponential taper", 1.0 - radii[1], energy["leading pulse"], momentum["lagging"]
    )
    linear = example_chain("Forward-linear taper")
    left = hc.simulate(linear).budget().momentum["leading pulse"][-1]
    stated("Forward-linear taper", linear.radii[-1], left)
    absorber, equal_beads = (
        hc.simulate(example_chain("Shock absorber", part)).wall_force()
        for part in ("document", "other")
    )
    stated("Shock absorber", absorber.peak / equal_beads.peak)
    assert absorber.duration / equal_beads.duration == pytest.approx(1.4, abs=0.05)
    backward = hc.simulate(example_chain("Backward-exponential taper")).velocities[-1]
    assert (backward[:-2] < 0).all()
    assert (backward[-2:] > 0).all()
    decorated = example_chain("Decorated chain")
    effective = hc.effective_chain(decorated)
    alone = hc.Chain(np.ones(25), masses=effective.masses, stiffness=effective.stiffness)
    ratio = hc.propagate(decorated).velocity[::2] / hc.simulate(alone).pulse().velocity
    assert abs(ratio[2:-1] - 1.0).max() < 0.01 < abs(ratio[1] - 1.0)


def test_drives_without_end_and_chains_at_rest_have_results_or_a_reason():
    step = {"chain": {"taper": "uniform", "beads": 9, "drive": {"kind": "step", "amplitude": 0.1}}}
    assert computed(step)["run"][0]["success"]
    rest = {"chain": {"radii": [1.0, 1.0, 1.0], "velocities": [0.0, 0.0, 0.0]}}
    assert set(computed(rest)) & {"run", "error"}


# Bad input ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("table", "sentence"),
    [
        ({"taper": "uniform", "beads": 1}, "beads"),
        ({"taper": "uniform", "beads": 2001}, "at most 2000 beads"),
        ({"cell": [1.0, 0.5], "cells": 10**9}, "at most 2000 beads"),
        ({"cell_diameters": [1.0, 0.5], "cells": 1500}, "at most 2000 beads, got 3000"),
        ({"taper": "uniform", "beads": 9, "struck_by": {"count": 10**9}}, "at most 2000 beads"),
        ({"taper": "uniform", "beads": 9, "decorated": {"ratio": 0.4, "between": 10**9}}, "2000"),
        ({"file": "/etc/passwd"}, "cannot refer to files"),
        ({"taper": "uniform", "beads": 9, "drive": {"kind": "table", "file": "x.csv"}}, "files"),
        ({"taper": "uniform", "beads": 9, "loss": [{"law": "x", "file": "y"}]}, "files"),
        ({"taper": "nothing", "beads": 9}, "taper"),
        ("text", "[chain]"),
    ],
)
def test_invalid_chains_are_answered_with_a_sentence(client, table, sentence):
    header, _ = client.results({"chain": table})[-1]
    assert header["part"] == "error"
    assert sentence in header["message"]
    assert "\n" not in header["message"]


STRUCK = {"diameters": "10 mm", "materials": "steel-52100", "beads": 10}


@pytest.mark.parametrize("wall", [{}, {"right_wall": {"material": "steel-52100"}}], ids=str)
@pytest.mark.parametrize("velocity", ["-1 m/s", "0 m/s", "1e-300 m/s", "1e300 m/s"])
def test_impacts_that_cannot_be_simulated_have_the_sentence_of_the_library(velocity, wall):
    document = {"chain": {**STRUCK, "velocity": velocity, **wall}}
    with (
        warnings.catch_warnings(action="ignore"),
        pytest.raises((hc.InputError, hc.SimulationError)) as error,
    ):
        hc.simulate(chain_of(document), times=0)
    header, _ = computed(document)["error"]
    assert header["message"] == re.sub(",? or until$", "", str(error.value))


def test_overflows_on_the_way_to_a_result_are_not_shown():
    warned = [RuntimeWarning("overflow encountered in multiply"), hc.InputWarning("a long run")]
    assert warnings_on_the_page(warned) == ["a long run"]


def test_a_force_that_is_too_large_ends_with_a_sentence(monkeypatch):
    monkeypatch.setattr(app_results, "MAX_SECONDS", 0.5)
    drive = {"kind": "step", "of": "force", "amplitude": "1e300 N"}
    wall = {"material": "steel-52100"}
    answer = computed({"chain": {**STRUCK, "right_wall": wall, "drive": drive}})
    assert "takes longer" in answer["error"][0]["message"]


def test_infinite_radii_can_be_sent():
    flat = {"chain": {"taper": "uniform", "beads": 9, "struck_by": {"radius": "inf", "mass": 2.0}}}
    assert chain_of(flat).masses[0] == 2.0
    assert tomllib.loads(document_as_toml(flat))["chain"]["struck_by"]["radius"] == math.inf


# Requests that are out of date -------------------------------------------------------------------

LONG = {"chain": {"taper": "uniform", "beads": 1500, "right_wall": {}}}


def test_a_newer_request_cancels_the_older_one(client):
    computed(WALL)  # compiled
    answers = {}

    def ask(number, document, **more):
        answers[number] = client.results(document, number, **more), time.monotonic()

    first = threading.Thread(target=ask, args=(10, LONG), kwargs={"rtol": 1e-13})
    first.start()
    time.sleep(1.0)
    assert first.is_alive()
    began = time.monotonic()
    ask(11, TAPER)
    first.join()
    assert answers[10][0][-1][0]["part"] == "cancelled"
    # A call of the kernel takes a fraction of a second; the whole run takes about ten seconds.
    assert answers[10][1] - began < 2.0
    assert answers[11][0][-1][0]["part"] == "run"


def test_the_time_of_compilation_does_not_count(monkeypatch):
    clock = iter([0.0, 0.0, 19.0, 21.0])
    monkeypatch.setattr(time, "perf_counter", lambda: next(clock))
    progress = limited(lambda: False)
    progress()
    progress()
    with pytest.raises(hc.SimulationError, match="longer than 20 s"):
        progress()
    with pytest.raises(Cancelled):
        limited(lambda: True)()


def test_a_request_that_arrives_late_is_not_computed(client):
    client.results(TAPER, 21)
    assert client.results(TAPER, 20)[-1][0]["part"] == "cancelled"
    assert client.results(TAPER, 20, slot="B")[-1][0]["part"] == "run"


# Files -------------------------------------------------------------------------------------------


def exported(client, document, kind, **more):
    answer = client.ask("POST", "/api/export", {"document": document, "kind": kind, **more})
    assert answer.status == 200, answer.content
    return answer.content


@pytest.mark.parametrize("document", [each["document"] for each in gallery()], ids=str)
def test_chain_files_round_trip(client, document):
    text = exported(client, document, "toml")
    read = client.ask("POST", "/api/chain", text, Content_Type="application/toml")
    assert json.loads(read.content) == {"document": document}


BETWEEN_WALLS = {"chain": {"taper": "uniform", "beads": 6, "left_wall": {}, "right_wall": {}}}


# No wave has reached the left wall at the end of the run of the page.
@pytest.mark.filterwarnings("ignore::hertzchain.IncompleteWarning")
@pytest.mark.parametrize(
    "document", [TAPER, WALL, STEEL, BETWEEN_WALLS], ids=["taper", "wall", "SI", "two walls"]
)
def test_the_script_gives_the_numbers_of_the_page(client, document, tmp_path, monkeypatch, capsys):
    arrays = {}
    for _, each in client.results(document, 30):
        arrays |= each
    script = exported(client, document, "python", until=float(arrays["times"][-1]))
    monkeypatch.chdir(tmp_path)
    Path("chain.toml").write_text("a file of the user")
    names = {}
    exec(compile(script, "chain.py", "exec"), names)
    printed = capsys.readouterr().out
    assert [each.name for each in tmp_path.iterdir()] == ["chain.toml"]
    assert Path("chain.toml").read_text() == "a file of the user"
    for side in ("left", "right"):
        wall = f"{side} wall" in names["chain"].features
        assert (f"WallForce({side} wall" in printed) == wall
    # The table of the page: one row per bead.
    (first,) = (i for i, line in enumerate(printed.splitlines()) if line.split()[:1] == ["bead"])
    rows = [line.split() for line in printed.splitlines()[first + 1 :]]
    beads = [row for row in rows if row[0].isdecimal()]
    assert [int(row[0]) for row in beads[: names["chain"].beads]] == [
        *range(1, names["chain"].beads + 1)
    ]
    head = printed.splitlines()[first - 1].split()
    for column, name in enumerate(head, 1):
        exact = arrays[f"exact.{name}"][1]
        assert float(beads[1][column]) == pytest.approx(exact, rel=1e-6), name
    assert repr(names["run"]).partition(":")[0] in printed
    for quantity in ("velocity", "arrival"):
        assert np.array_equal(arrays[f"exact.{quantity}"], getattr(names["pulse"], quantity))


def test_a_run_is_described_by_its_own_warnings_and_units(client):
    """A soft wall, on which the impact ends long after the leading pulse."""
    pad = {"chain": {"diameters": "20 mm", "materials": "steel-52100", "beads": 20,
                     "struck_by": [{"velocity": "0.5 m/s"}],
                     "right_wall": {"material": "rubber"}}}  # fmt: skip
    headers = {header["part"]: header for header, _ in client.results(pad, 77)}
    run = headers["run"]
    limits = [text.partition(" is ")[0] for text in run["warnings"] if "assumed" not in text]
    assert len(set(limits)) == len(limits) == 2
    # The overlap at the wall is that of the peak, which the whole run contains.
    with pytest.warns(hc.ModelRangeWarning) as issued:
        hc.simulate(chain_of(pad), until=8e-3, times=0)
    # The folded line of the page shows the first warning.
    assert run["warnings"][:2] == [on_the_page(each.message) for each in issued]
    assert run["warnings"][0].startswith("contacts would be dented, and forces may be lower: p")
    assert run["warnings"][1].startswith("overlap / radius")
    (assumed,) = run["warnings"][2:]
    assert assumed.startswith("peak if contacts yield at 1.6 Y: the yield pressure is assumed")
    # The run for the page ends as that of `simulate` without `until`.
    found = re.match(
        r"the run ends at t = (\d+\.\d+) ms, with 1 contact still closed", run["message"]
    )
    with pytest.warns(hc.ModelRangeWarning):
        expected = hc.simulate(chain_of(pad), times=0).end_time
    assert 1e-3 * float(found[1]) == pytest.approx(expected, rel=1e-2)


def test_times_are_equally_spaced_while_a_soft_wall_is_loaded_and_missed_collisions_are_stated():
    row = {"diameters": "20 mm", "materials": "steel-52100", "beads": 10, "velocity": "0.03 m/s"}
    header, arrays = computed({"chain": {**row, "right_wall": {"material": "rubber"}}})["run"]
    steps = np.diff(arrays["times"])
    later = steps[arrays["times"][:-1] > 1e-3]
    assert later == pytest.approx(later.mean(), rel=1e-3)
    found = re.search(
        r"up to ([\d.]+) µs apart, .* last ([\d.]+) µs: they do not", header["coarse"]
    )
    assert float(found[1]) == pytest.approx(1e6 * steps.max(), rel=1e-3)
    # Two balls of 20 mm collide for 2.94 (m / 2 / k)^0.4 v^-0.2 (Landau and Lifshitz).
    ball = chain_of({"chain": {**row, "beads": 2}})
    mass, stiffness = ball.masses[0] / 2, ball.contact_stiffness[1]
    alone = 2.9432 * (mass / (0.8 * stiffness)) ** 0.4 * 0.03**-0.2
    assert float(found[2]) == pytest.approx(1e6 * alone, rel=0.1)
    header, _ = computed({"chain": {**row, "right_wall": {}}})["run"]
    assert header["coarse"] == ""


def test_final_velocities_of_a_cradle_are_those_of_separate_collisions():
    """Balls with gaps collide one after another, and equal balls exchange their velocities."""
    cradle = next(each for each in gallery() if each["title"] == "Newton's cradle")
    header, arrays = computed(cradle["document"], run_until=cradle["view"]["until"])["run"]
    assert arrays["times"][-1] >= 1e-3
    assert header["closed"] == ""
    assert arrays["final"] == pytest.approx([0.0, 0.0, 0.0, 0.1, 0.1], abs=5e-9)
    # The pulse has left the row before the balls have separated.
    header, arrays = computed(cradle["document"])["run"]
    assert header["closed"] == "1 contact still closed, so velocities are not final"
    assert "final" not in arrays
    for until in (-1.0, math.inf, "1 ms"):
        with pytest.raises(hc.InputError, match="run until"):
            computed(cradle["document"], run_until=until)


def test_forces_are_saved_until_the_end_of_the_run_of_the_page(client, tmp_path):
    path = tmp_path / "forces.csv"
    for until in (0.0, 5e-3):
        path.write_bytes(exported(client, STEEL, "forces", sensors=[4], run_until=until))
        end = 1e-6 * np.loadtxt(path, delimiter=",", skiprows=1)[-1, 0]
        assert (end >= 5e-3) == (until > 0.0)


def test_forces_are_saved_as_traces(client, tmp_path):
    row = {"chain": {"diameters": "10 mm", "materials": "steel-52100", "beads": 9,
                     "struck_by": [{"velocity": "0.2 m/s"}],
                     "right_wall": {"material": "steel-52100"}}}  # fmt: skip
    path = tmp_path / "forces.csv"
    path.write_bytes(exported(client, row, "forces", sensors=[4]))
    assert path.read_text().splitlines()[0] == "time [us],ball 4 [N],wall [N]"
    times, ball, wall = np.loadtxt(path, delimiter=",", skiprows=1, unpack=True)
    # The same run at other times, which do not change the steps of the integration.
    run = hc.simulate(chain_of(row), times=1e-6 * times, rtol=1e-9)
    for saved, force in ((ball, run.sensor("ball 4")), (wall, run.forces[:, -1])):
        assert saved == pytest.approx(force, abs=1e-6 * force.max())
    assert run.wall_force().complete
    assert hc.load_traces(path).names == ("ball 4", "wall")
    body = {"kind": "forces", "document": TAPER}
    answer = client.ask("POST", "/api/export", body)
    assert answer.status == 422
    assert "no wall and no sensor" in answer.content.decode()


def test_tables_have_all_digits(client):
    rows = list(csv.reader(io.StringIO(exported(client, STEEL, "csv").decode())))
    column = rows[0].index("velocity (simulation) [m/s]")
    velocity = hc.propagate(chain_of(STEEL)).velocity
    assert [float(row[column]) for row in rows[1:]] == velocity.tolist()
    # As in files of the library, columns without a dimension have no unit.
    assert "velocity_error (local-rate)" in rows[0]


@pytest.mark.parametrize(
    ("form", "magic"), [("svg", b"<?xml"), ("pdf", b"%PDF"), ("png", b"\x89PNG")]
)
def test_figures_are_those_of_the_library(client, form, magic):
    for figure in ("chain", "pulse", "map", "forces", "budget"):
        content = exported(client, WALL, "figure", figure=figure, format=form)
        assert content.startswith(magic)
        if form != "svg":
            break


HIDDEN = ["hard-sphere", "two-thirds-bca", "modified-bca-printed"]


def texts_of(figure):
    """Texts of an SVG figure, which Matplotlib writes as comments above their outlines."""
    return re.findall(r"<!-- (.*?) -->", figure.decode())


def test_the_figure_of_the_pulse_shows_the_curves_of_the_page(client):
    def legend(hidden, **more):
        stored = {"view": {"hidden": hidden, "log": False}}
        given = {"figure": "pulse", "format": "svg", "view": stored, **more}
        found = texts_of(exported(client, TAPER, "figure", **given))
        names = ("simulation", "BCA", "hard sphere", "2/3 BCA",
                 "modified BCA", "modified BCA, printed", "local-rate law")  # fmt: skip
        chains = [each for each in found if each[:3] in ("A, ", "B, ")]
        return {*(name for name in names if name in found), *chains}, chains

    usual = {"simulation", "BCA", "modified BCA", "local-rate law"}
    assert legend(HIDDEN)[0] == usual
    assert legend([*HIDDEN, "exact"])[0] == usual - {"simulation"}
    assert legend([])[0] == usual | {"hard sphere", "2/3 BCA", "modified BCA, printed"}
    second = {"other": {"chain": {"taper": "uniform", "beads": TAPER["chain"]["beads"]}}}
    # Colours show the chains, of which A is the first, and lines the methods.
    taper = "backward-exponential, $q$ = 0.05"
    for slot, chains in (
        ("A", [f"A, {taper}", "B, uniform"]),
        ("B", ["A, uniform", f"B, {taper}"]),
    ):
        assert legend(HIDDEN, slot=slot, **second) == (usual | {*chains}, chains)
    same = legend(HIDDEN, other=TAPER)[1]
    assert same[:2] == ["A, simulation", "B, simulation"]
    decorated = {"chain": {"taper": "uniform", "beads": 9, "decorated": {"ratio": 0.4}}}
    for hidden, shown in ((HIDDEN, True), ([*HIDDEN, "effective-chain"], False)):
        given = {"figure": "pulse", "format": "svg", "view": {"view": {"hidden": hidden}}}
        found = texts_of(exported(client, decorated, "figure", **given))
        assert ("effective chain" in found) == shown
    everything = ["exact", *THEORIES]
    body = {"kind": "figure", "figure": "pulse", "document": TAPER,
            "view": {"view": {"hidden": everything}}}  # fmt: skip
    answer = client.ask("POST", "/api/export", body)
    assert answer.status == 422
    assert "shows no curve" in answer.content.decode()


def test_the_figure_of_the_pulse_has_the_same_balls_above_each_other():
    row = hc.Chain.uniform(9)
    chains = row, row.struck_by(radius=1.4)
    for own, other in (chains, chains[::-1]):
        curves = {"A, simulation": hc.propagate(own), "B, simulation": hc.propagate(other)}
        axes = _pulse_axes("velocity", own, curves, {}, ("A, ", "B, "))
        lines = [line for line in axes.lines if len(line.get_xdata()) > 1]
        for line, chain in zip(lines, (own, other), strict=True):
            ball_3 = np.flatnonzero(line.get_xdata() == 3 + own.strikers)
            assert line.get_ydata()[ball_3] == hc.propagate(chain).velocity[2 + chain.strikers]
        ends = {line.get_xdata()[0] for line in axes.lines if len(line.get_xdata()) == 1}
        assert ends == {9 + own.strikers}
        plt.close(axes.figure)


def test_the_map_shows_the_quantity_of_the_page(client):
    for quantity, words in (("velocities", "velocity"), ("forces", "force")):
        stored = {"view": {"map": quantity}}
        content = exported(client, WALL, "figure", figure="map", format="svg", view=stored)
        assert any(words in text for text in texts_of(content))


def test_messages_are_in_the_words_of_the_page(client):
    fast = {"chain": {"taper": "uniform", "radius": "5 mm", "beads": 10,
                      "materials": "steel-52100", "velocity": "1 m/s"}}  # fmt: skip
    headers = [header for header, _ in client.results(fast, 78)]
    warnings = [text for header in headers for text in header.get("warnings", [])]
    assert any("choose the loss elastic-plastic" in text for text in warnings)
    dented = "contacts would be dented, and forces may be lower: pressure / yield is "
    assert any(text.startswith(dented) for text in warnings)
    polymer = fast["chain"] | {"materials": "ptfe"}
    assert computed({"chain": polymer})["run"][0]["warnings"][0].startswith("pressure / yield is ")
    assert not any("ElasticPlastic" in json.dumps(header) for header in headers)
    assert on_the_page("because 2.364 uJ is travelling") == "because 2.364 µJ is travelling"
    assert sentences(["one note.", "", "another", "another"]) == "one note; another"


def test_the_page_does_not_advise_to_call_functions():
    uniform = {"chain": {"taper": "uniform", "beads": 9}}
    decorated = {"chain": {"radii": [1.0, 0.4, 1.0, 0.4, 1.0, 0.4, 1.0]}}
    for document in (uniform, decorated, WALL):
        parts = computed(document, run=False).values()
        notes = [text for header, _ in parts for theory in header.get("theories", {}).values()
                 for text in theory.values() if text]  # fmt: skip
        assert notes
        for text in notes:
            assert not re.search(r"\buse (simulate|propagate|bca|effective_chain)\b|theory\.", text)
    given = "2 errors:\n  [chain] has no cells, which goes with x\n  b of [chain] c"
    assert on_the_page(given) == "2 errors:\n  enter the number of cells\n  b c"
    assert on_the_page("it takes too long; use hertzchain simulate") == (
        "it takes too long; use hertzchain simulate"
    )


@pytest.mark.parametrize(("make", "words"), [
    (lambda: hc.Chain.tapered(first="20 mm", last="5 mm", beads=9), "choose a material, such as"),
    (lambda: hc.Chain.from_materials(diameters="9 mm:5 mm", materials="steel-52100", beads=9),
     "; for a taper between two sizes, choose 'end diameters'"),
    (lambda: hc.Chain.from_materials(
        diameters="9 mm", materials="steel-52100", beads=9, precompression="9 N"
     ), "; add a left wall, or choose 'held by force' for a constant force"),
    (lambda: hc.modified_bca(hc.Chain.uniform(9).replace(right_wall=hc.Wall())),
     "the modified BCA does not support a right wall"),
    (lambda: hc.hard_sphere(hc.Chain.uniform(9).replace(right_wall=hc.Wall())),
     "the hard-sphere theory does not support a right wall"),
    (lambda: chain_of({"chain": {"last": "9 mm", "beads": 9, "materials": "steel-52100"}}),
     "enter the size of the beads"),
    (lambda: chain_of({"chain": {"first": 1.0, "beads": 9}}), "enter the size of the last bead"),
    (lambda: chain_of({"chain": {"cell": [1.0, 0.5]}}), "enter the number of cells"),
    (lambda: chain_of({"chain": {"taper": "uniform", "beads": 9, "materials": "steel-52100"}}),
     "enter the radius"),
    (lambda: chain_of({"chain": {"taper": "forward-linear", "beads": 9}}),
     "enter the rate S of the taper"),
    (lambda: hc.Chain.tapered(first=1000.0, last=1e-6, beads=20), "choose 'a list of radii'"),
    (lambda: hc.Wall(stiffness=-1.0), "for a rigid wall, choose 'rigid'"),
    (lambda: chain_of(WALL | {"chain": WALL["chain"] | {"right_wall": {"exponent": 1.0}}}),
     "; enter its stiffness"),
])  # fmt: skip
def test_errors_are_in_the_words_of_the_page(make, words):
    with pytest.raises(hc.InputError) as raised:
        make()
    text = on_the_page(raised.value)
    assert words in text
    assert not re.search(r"\[chain|Chain\.|Wall[.(]|_wall|_by|materials=|_bca|; remove ", text)


def test_a_saved_page_contains_everything(client):
    page = exported(client, TAPER, "page", other=WALL).decode()
    assert not re.findall(r'(?:src|href)="(?!data:|#)', page)
    assert "token" not in page
    saved = json.loads(re.search(r'id="embedded">(.*?)</script>', page)[1])
    assert saved["about"]["document"] == TAPER
    assert 'from "./' not in page
    # A page that is saved while chain B is shown has the same chains A and B.
    stored = {"view": {"errors": "difference"}, "B": WALL}
    page = exported(client, TAPER, "page", other=WALL, slot="B", view=stored).decode()
    saved = json.loads(re.search(r'id="embedded">(.*?)</script>', page)[1])
    assert saved["about"]["document"] == WALL
    assert saved["about"]["view"] == {"view": {"errors": "difference"}, "B": TAPER}


def stored_in(file):
    """The data in a saved page, and the parts of its results."""
    stored = json.loads(re.search(r'id="embedded">(.*?)</script>', file.read_text("utf-8"))[1])
    return stored, unpacked(base64.b64decode(stored["parts"]))


def test_a_page_names_its_files_strikers_and_impact(tmp_path):
    text = """[chain]
        diameters = ["20 mm", "10 mm"]
        materials = "steel-52100"
        struck_by = {velocity = "0.1 m/s", diameter = "24 mm", gap = "1 mm"}"""
    (tmp_path / "a<b>.toml").write_text(text)
    (tmp_path / "equal.toml").write_text(text.replace('"10 mm"', '"20 mm"'))
    files = [str(tmp_path / each) for each in ("a<b>.toml", "equal.toml", "page.html")]
    cli.main(["app", files[0], "--compare", files[1], "--save", files[2]], standalone_mode=False)
    _, found = stored_in(tmp_path / "page.html")
    words = [
        (header["description"], header["file"]) for header, _ in found if header["part"] == "beads"
    ]
    striker = "striker (24 mm, gap 1 mm), impact at 0.1 m/s"
    tapered = f"2 steel-52100 beads, diameters 20 mm to 10 mm, {striker}"
    assert words == [
        (tapered, "a<b>.toml"),
        (f"2 steel-52100 beads, diameter 20 mm, {striker}", "equal.toml"),
    ]
    title = f"<title>{tapered} – a&lt;b&gt;.toml – hertzchain</title>"
    assert title in Path(files[2]).read_text("utf-8")


def opened(tmp_path, *options):
    """The document and the chain that the command opens."""
    page = tmp_path / "page.html"
    cli.main(["app", *options, "--save", str(page)], standalone_mode=False)
    document = stored_in(page)[0]["about"]["document"]
    return document, chain_of(document)


def test_the_command_accepts_the_options_of_a_chain(tmp_path):
    taper = ("--taper", "backward-exponential", "--rate", "0.05")
    _, chain = opened(tmp_path, *taper, "--beads", "30")
    expected = hc.Chain.tapered("backward-exponential", 0.05, beads=30)
    assert np.array_equal(chain.radii, expected.radii)
    page = (tmp_path / "page.html").read_text("utf-8")
    assert f"<title>{chain.description} – hertzchain</title>" in page
    steel = ("--diameter", "10 mm", "--material", "steel-52100", "--beads", "9")
    _, chain = opened(tmp_path, *steel, "--speed", "0.2 m/s", "--striker", "2", "--wall", "same")
    row = hc.Chain.from_materials(5e-3, "steel-52100", beads=9)
    expected = row.struck_by(velocity=0.2, count=2).replace(right_wall=hc.Wall())
    for name in ("radii", "masses", "velocities"):
        assert np.array_equal(getattr(chain, name), getattr(expected, name))
    assert (chain.strikers, chain.right_wall) == (2, expected.right_wall)


def test_options_change_the_chain_of_a_file(tmp_path):
    file = tmp_path / "row.toml"
    file.write_text(
        '[chain]\ndiameters = "10 mm"\nbeads = 9\nmaterials = "brass"\nvelocity = "1 cm/s"\n'
    )
    # A file that nothing changes keeps its units.
    for given in ((str(file),), ("--chain", str(file))):
        assert opened(tmp_path, *given)[0]["chain"]["velocity"] == "1 cm/s"
    _, chain = opened(tmp_path, str(file), "--speed", "0.3 m/s", "--wall", "rigid")
    assert chain.velocities.tolist() == [0.3] + 8 * [0.0]
    assert chain.right_wall == hc.Wall.rigid()
    assert "row.toml" in (tmp_path / "page.html").read_text("utf-8")
    for wrong, said in (
        ((str(file), "--beads", "3"), "give a chain FILE or --beads, not both"),
        ((str(file), str(file)), "give one chain FILE, and a second one as --compare FILE, got 2"),
        ((), "--save requires a chain FILE, or options such as --taper"),
        (("--rate", "0.1"), "--rate requires --taper"),
        (("--beads", "2001"), "at most 2000 beads"),
    ):
        with pytest.raises((click.UsageError, hc.InputError), match=said):
            opened(tmp_path, *wrong)


def test_a_saved_comparison_has_sensors_in_the_same_balls(tmp_path):
    row = hc.Chain.uniform(8)
    struck = row.struck_by(radius=1.4)
    for first, other, sensor in ((row, struck, 3), (struck, row, "ball 3"), (struck, row, 4)):
        hc.save_page(first, tmp_path / "page.html", other=other, sensors=[sensor])
        _, found = stored_in(tmp_path / "page.html")
        runs = {header["slot"]: header for header, _ in found if header["part"] == "run"}
        for slot, chain in (("A", first), ("B", other)):
            bead = 3 + chain.strikers
            peaks = runs[slot]["peaks"][str(bead)]
            assert peaks["label"].removesuffix(" (ball 3)") == f"sensor in bead {bead}"
            assert (peaks["ball"], peaks["name"]) == ("sensor in ball 3", "sensor0")
            force = hc.simulate(chain, rtol=1e-9).sensor_force(bead)
            assert peaks["first"] == pytest.approx(force.first_maximum, rel=1e-4)


def test_sensors_outside_one_chain_keep_their_colours():
    found = computed(WALL, sensors=[30, 5])["run"][0]["peaks"]
    assert {place: each["name"] for place, each in found.items()} == {
        "5": "sensor1", "right": "wall-right"
    }  # fmt: skip


def test_files_of_designs_and_fits_show_their_chain(tmp_path):
    text = '[chain]\ntaper = "uniform"\nbeads = 9\n'
    more = '[fit]\nfree = ["velocity"]\n[design]\nminimise = "wall_force.peak"\nfile = "a.csv"\n'
    path = tmp_path / "design.toml"
    path.write_text(text + more)
    expected = {"chain": {"taper": "uniform", "beads": 9}}
    assert document_of_file(path) == document_of_toml(text + more) == expected
    assert hc.load_chain(path).radii.tolist() == hc.Chain.uniform(9).radii.tolist()
    with pytest.raises(hc.InputError, match="unknown table or key 'desing'"):
        document_of_toml(text + "[desing]\n")


def test_ball_grades_of_the_slider_exist():
    balls = hc.Chain.from_materials("5 mm", "steel-52100", beads=4)
    for grade in about()["ranges"]["grade"][0]:
        assert balls.with_scatter(1, grade=grade).radii.std() > 0.0


def test_chains_in_words_name_strikers():
    plain = hc.Chain.uniform(10)
    assert chain_in_words(plain) == "uniform, 10 beads"
    two = plain.struck_by(count=2, radius=1.5, gap=0.5)
    assert chain_in_words(two) == "uniform, 10 beads, 2 strikers (radius 1.5, gap 0.5)"
    heavy = hc.Chain.uniform(10).struck_by(radius=1.0, mass=3.0)
    assert chain_in_words(heavy).endswith("striker (radius 1, mass 3)")
    flat = hc.Chain.from_materials("5 mm", "brass", beads=9).struck_by(
        radius=np.inf, mass="10 g", velocity="0.2 m/s"
    )
    assert chain_in_words(flat).endswith("striker (10 g), impact at 0.2 m/s")


def test_a_page_saved_from_python_has_the_results_of_both_chains(tmp_path):
    row = hc.Chain.uniform(12).replace(right_wall=hc.Wall())
    taper = hc.Chain.tapered("forward-linear", 0.05, beads=10).replace(right_wall=hc.Wall())
    hc.save_page(taper, tmp_path / "page.html", other=row, sensors=[3, "bead 4"])
    stored, found = stored_in(tmp_path / "page.html")
    assert stored["about"]["view"]["view"] == {
        "sensors": [3, 4],
        "errors": "difference",
        "until": 0.0,
    }
    runs = {header["slot"]: header for header, _ in found if header["part"] == "run"}
    for slot, chain in (("A", taper), ("B", row)):
        peak = hc.simulate(chain, rtol=1e-9).wall_force().peak
        assert runs[slot]["peaks"]["right"]["largest"] == pytest.approx(peak, rel=1e-6)


def test_pictures_of_the_gallery_mark_the_beads_that_move():
    moving = {each["title"]: each["moving"] for each in gallery()}
    assert moving["Newton's cradle"] == 2
    assert moving["Two strikers"] == 2
    assert moving["Equal beads: a solitary wave"] == 1


def test_a_chain_at_rest_shows_no_rounding_errors(tmp_path):
    crystal = hc.Chain.from_materials(
        5e-3, "steel-52100", beads=9, velocity=0.0, precompression=10.0, held_by="force"
    )
    hc.save_page(crystal, tmp_path / "page.html")
    ((header, arrays),) = (
        part for part in stored_in(tmp_path / "page.html")[1] if part[0]["part"] == "run"
    )
    assert not arrays["velocities"].any()
    assert not arrays["velocities.scale"].any()
    assert header["warnings"][0].startswith("nothing moves, because bead 1 is not struck")
    assert "spectrum" not in header
    assert not [name for name in arrays if name.startswith("energy")]


def test_a_saved_page_lasts_until_a_given_time(tmp_path):
    row = hc.Chain.from_materials(2e-3, "brass", beads=4, velocity=0.1, right_wall=hc.Wall())
    ends = {}
    for until in (None, "2 ms"):
        hc.save_page(row, tmp_path / "page.html", until=until)
        stored, found = stored_in(tmp_path / "page.html")
        (ends[until],) = (
            arrays["times"][-1] for header, arrays in found if header["part"] == "run"
        )
        assert stored["about"]["view"]["view"]["until"] == (2e-3 if until else 0.0)
    assert ends[None] < 1e-3
    assert ends["2 ms"] >= 2e-3


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"path": "page.pdf"}, r"path must end in .html, got 'page.pdf'"),
        ({"sensors": [77]}, "bead with a sensor must be a whole number from 1 to 10, got 77"),
        ({"sensors": range(1, 7)}, "up to 4 sensors, got 6"),
        ({"other": hc.Chain.from_materials("5 mm", "ptfe", beads=3)}, "both be in SI units"),
        ({"chain": hc.Chain.uniform(3000)}, "at most 2000 beads, got 3000"),
        ({"until": -1.0}, "until must be above 0, got -1"),
        ({"until": "2 ms"}, "until .* scaled"),
    ],
)
def test_a_page_that_cannot_be_saved(tmp_path, monkeypatch, changes, said):
    monkeypatch.chdir(tmp_path)
    chain = hc.Chain.tapered("forward-linear", 0.05, beads=10)
    with pytest.raises(hc.InputError, match=said):
        hc.save_page(**({"chain": chain, "path": "page.html"} | changes))
    assert not list(tmp_path.iterdir())


def test_exports_reject_bad_requests(client):
    for body in ({"kind": "nothing"}, {"kind": "toml"}, {"kind": "figure", "document": TAPER},
                 {"kind": "toml", "document": {"chain": {"file": "/etc/passwd"}}}):  # fmt: skip
        answer = client.ask("POST", "/api/export", body)
        assert answer.status == 422
        assert "Traceback" not in answer.content.decode()


def test_files_that_are_not_chains_are_rejected(client):
    for text in (b"\xff", b"chain = ", b"[chain]\ntaper = 1\n", b"[chain]\nfile = 'x.csv'\n",
                 b"a = " + b"[" * 50_000, b"[chain]\nradii = [nan, 1.0]\n"):  # fmt: skip
        read = client.ask("POST", "/api/chain", text, Content_Type="application/toml")
        assert "error" in json.loads(read.content)


# Starting ----------------------------------------------------------------------------------------


def test_files_named_in_a_chain_file_are_included(tmp_path):
    (tmp_path / "beads.csv").write_text("radius\n1\n0.9\n0.8\n")
    file = tmp_path / "chain.toml"
    file.write_text('[chain]\nfile = "beads.csv"\n')
    document = document_of_file(file)
    assert chain_of(document).radii.tolist() == [1.0, 0.9, 0.8]
    assert chain_of(document_of_file(tmp_path / "beads.csv")).beads == 3


def test_a_port_that_is_taken_is_replaced_by_the_next():
    with bind(0) as first, bind(first.getsockname()[1]) as second:
        assert first.getsockname()[1] < second.getsockname()[1] <= first.getsockname()[1] + 20


def test_theories_are_sent_while_simulations_are_compiled():
    compiled = threading.Event()
    found = RunningServer(0, warm_up=False)
    stages = (
        Stage("the simulation", lambda _: compiled.wait(30.0)),
        Stage("the law", lambda _: None),
    )
    found.app.warm_up = WarmUp(stages)
    found.start()
    answers = {}

    def ask(number):
        answers[number] = Client(found).results(TAPER, number)

    threads = [threading.Thread(target=ask, args=(number,)) for number in range(5)]
    for thread in threads:
        thread.start()
        time.sleep(0.15)
    # Requests that are out of date do not wait for the compiler, so that threads remain.
    for thread in threads[:-1]:
        thread.join(5.0)
        assert not thread.is_alive()
    assert threads[-1].is_alive()
    assert {"cancelled"} == {answers[number][-1][0]["part"] for number in range(4)}
    compiled.set()
    threads[-1].join(30.0)
    headers = [header for header, _ in answers[4]]
    assert [each["part"] for each in headers][:3] == ["status", "beads", "status"]
    assert headers[0]["pending"] == ["the simulation", "the law"]
    assert headers[-1]["part"] == "run"
    found.stop()


def test_the_page_is_served_before_the_library_is_imported(monkeypatch):
    code = (
        "import sys; import hertzchain.app.serve;"
        "print([name for name in ('numpy', 'numba', 'scipy') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
    imported = threading.Event()

    def load():
        assert imported.wait(30.0)
        background_import.LOADED.set()

    monkeypatch.setattr(background_import, "LOADED", threading.Event())
    monkeypatch.setattr(background_import, "load", load)
    found = RunningServer(0, TAPER)
    found.start()
    try:
        answers = []
        thread = threading.Thread(
            target=lambda: answers.append(Client(found).ask("GET", "/api/about").status)
        )
        thread.start()
        response = Client(found).ask("GET", "/")
        assert response.status == 200
        assert found.app.warm_up.pending() == ["the library"]
        assert thread.is_alive()
        imported.set()
        thread.join(30.0)
        assert answers == [200]
    finally:
        imported.set()
        found.stop()


def test_the_stages_of_the_compilation_are_those_that_messages_need():
    background_import.load()
    warm_up = WarmUp()
    # The numbers of stages in `NEEDED` depend on this order.
    assert warm_up.pending() == [
        "walls", "the simulation of the pulse", "the local-rate law",
        "the simulation of all beads", "losses", "heterogeneous chains",
    ]  # fmt: skip
    began = time.monotonic()
    warm_up.wait("beads", ["right wall"], lambda: time.monotonic() > began + 0.2)
    assert time.monotonic() > began + 0.2
    WarmUp(()).wait("beads", ["right wall"], lambda: False)


def test_a_chain_with_a_wall_waits_for_walls_alone():
    compiled, rest = threading.Event(), threading.Event()
    first = Stage("walls", lambda _: compiled.set())
    warm_up = WarmUp((first, *(Stage("more", lambda _: rest.wait(30.0)) for _ in range(4))))
    warm_up.start()
    assert compiled.wait(30.0)
    began = time.monotonic()
    warm_up.wait("pulse", ["SI units", "right wall"], lambda: time.monotonic() > began + 20.0)
    assert time.monotonic() < began + 20.0
    for features in (["SI units"], ["right wall", "loss"]):
        stopped = []
        warm_up.wait(
            "pulse", features, lambda stopped=stopped: stopped.append(1) or len(stopped) > 2
        )
        assert len(stopped) == 3
    rest.set()


def test_a_stage_that_fails_does_not_stop_requests(monkeypatch):
    seen = []
    monkeypatch.setattr(threading, "excepthook", seen.append)

    def fail(_):
        raise RuntimeError("no compiler")

    warm_up = WarmUp((Stage("the simulation", fail), Stage("the law", fail)))
    warm_up.start()
    began = time.monotonic()
    warm_up.wait("beads", ["right wall"], lambda: time.monotonic() > began + 20.0)
    assert warm_up.pending() == []
    while not seen and time.monotonic() < began + 20.0:
        time.sleep(0.01)
    assert [str(each.exc_value) for each in seen] == ["no compiler"]


def test_the_page_receives_the_schema():
    text = json.dumps(about(TAPER), allow_nan=False)
    found = json.loads(text)
    assert found["document"] == TAPER
    known = set(hc.store.chain_schema.SECTIONS)
    assert set(found["schema"]["sections"]) == known - {"chain.striker_properties"}
    assert len(found["gallery"]) >= 12


def test_numbers_that_json_lacks_become_null():
    header, _ = unpacked(Part({"a": math.nan, "b": [math.inf, np.float64(1.5)]}).pack())[0]
    assert (header["a"], header["b"]) == (None, [None, 1.5])


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_the_command_prints_the_address_and_stops(tmp_path):
    file = tmp_path / "chain.toml"
    file.write_text(document_as_toml(TAPER))
    command = [sys.executable, "-m", "hertzchain", "app", str(file), "--no-open", "--port", "0"]
    environment = os.environ | {"PYTHONUNBUFFERED": "1"}
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment
    ) as process:
        address = process.stdout.readline().strip()
        host, _, token = address.removeprefix("http://").partition("/?token=")
        link = http.client.HTTPConnection(host, timeout=20)
        link.request("GET", f"/?token={token}")
        answer = link.getresponse()
        answer.read()
        link.request("GET", "/api/about", headers={"Cookie": answer.headers["set-cookie"]})
        assert json.loads(link.getresponse().read())["document"] == TAPER
        link.close()
        process.send_signal(signal.SIGINT)
        assert process.wait(20) == 0
        assert "stopped" in process.stderr.read()


def test_a_flat_striker_is_drawn_as_a_plate_without_a_radius():
    hammer = {"mass": "50 g", "radius": math.inf, "material": "brass", "velocity": "0.1 m/s"}
    row = {"diameters": "8 mm", "materials": "steel-52100", "beads": 3}
    header, arrays = computed({"chain": row | {"struck_by": [hammer]}})["beads"]
    assert arrays["radii"].tolist() == [math.inf, 4e-3, 4e-3, 4e-3]
    assert np.allclose(arrays["widths"], [1e-3, 4e-3, 4e-3, 4e-3])
    assert np.allclose(arrays["heights"], 4e-3)
    assert np.allclose(arrays["centres"], [1e-3, 6e-3, 14e-3, 22e-3])
    assert header["kinds"] == [["brass", "flat"], ["steel-52100", "8 mm"]]


def test_contacts_that_have_yielded_are_in_the_visible_notes():
    law = {"law": "elastic-plastic"}
    table = {"radii": 5e-3, "beads": 6, "materials": "steel-52100", "velocity": 4.0,
             "right_wall": {"material": "aluminium"}, "loss": law}  # fmt: skip
    wall, loss = hc.Wall.of("aluminium"), hc.ElasticPlastic()
    run = hc.simulate(
        hc.Chain.from_materials(
            5e-3, "steel-52100", beads=6, velocity=4.0, right_wall=wall, loss=loss
        )
    )
    header, _ = computed({"chain": table})["run"]
    yielded, assumed, *_ = header["warnings"]
    assert yielded.startswith("contacts 1 to 5 and the right wall have yielded; deepest dent ")
    assert f"deepest dent {1e6 * run.dents.max():.3g} µm at the right wall; overlap" in yielded
    assert "is assumed to be 1.6 times the yield strength" in assumed
    assert "choose 2.8 as the factor of the loss" in assumed
    law["factor"] = 2.8
    warnings = computed({"chain": table})["run"][0]["warnings"]
    assert any("have yielded" in each for each in warnings)
    assert not any("assumed" in each for each in warnings)
    table["velocity"] = 0.01
    assert not any("yield" in each for each in computed({"chain": table})["run"][0]["warnings"])
