"""Sensors in beads at ends without walls, on which a drive or the precompression acts."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import hertzchain as hc

DRIVE = hc.SineBurst(40.0, 10e3, cycles=0.5, window="none")


def test_a_driven_end_bead_carries_the_force_of_the_drive():
    """By SciPy: the mean of the driving force and that in the first contact."""
    chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=6, velocity=0.0)
    mass, k = chain.masses[0], chain.stiffness[0]
    times = np.linspace(0.0, 60e-6, 601)

    def forces(x):
        return k * np.maximum(x[:-1] - x[1:], 0.0) ** 1.5

    def rhs(t, y):
        inner = forces(y[:6])
        outer = 40.0 * np.sin(2e4 * np.pi * t) if t < 50e-6 else 0.0
        return np.concatenate((y[6:], (np.r_[outer, inner] - np.r_[inner, 0.0]) / mass))

    done = solve_ivp(rhs, (0.0, 60e-6), np.zeros(12), t_eval=times, rtol=1e-10, atol=1e-16,
                     max_step=1e-7)  # fmt: skip
    outer = np.where(times < 50e-6, 40.0 * np.sin(2e4 * np.pi * times), 0.0)
    expected = 0.5 * (outer + np.array([forces(x)[0] for x in done.y[:6].T]))
    run = hc.simulate(chain.replace(drive=DRIVE), until=60e-6, times=601)
    np.testing.assert_allclose(run.sensor(1), expected, atol=2e-3)
    found = run.sensor_force(1)
    assert found.first_maximum == pytest.approx(expected.max(), rel=1e-4)
    assert run.sensor(2) == pytest.approx(0.5 * (run.force(1) + run.force(2)))


def test_ends_held_by_a_force_carry_it():
    row = hc.Chain.from_materials(5e-3, "steel-52100", beads=8, velocity=1e-4)
    held = row.replace(precompression="20 N", held_by="force")
    run = hc.simulate(held, until=600e-6, times=2401)
    for bead in (1, 4, 8):
        assert run.sensor(bead)[0] == pytest.approx(20.0, rel=1e-9)
    assert run.sensor_force(1).first_maximum == pytest.approx(run.sensor(1).max(), rel=1e-4)
    keep = ["sensor.first_maximum", "sensor.largest", "sensor.impulse"]
    table = hc.simulate_many([held], keep=keep, sensors=[1, 4, 8], until=600e-6)
    for i, bead in enumerate((1, 4, 8)):
        assert table["sensor.largest"][0, i] == pytest.approx(run.sensor(bead).max(), rel=1e-5)
        impulse = np.trapezoid(run.sensor(bead), run.times)
        assert table["sensor.impulse"][0, i] == pytest.approx(impulse, rel=1e-5)
    assert table["sensor.first_maximum"][0, 0] == pytest.approx(run.sensor_force(1).first_maximum)
    with pytest.raises(hc.InputError, match="no gradient in an end bead on which a force of prec"):
        hc.gradient(held, "sensor.largest@8", to=["radii"], until=600e-6)
    # Between walls, the forces on the ends are those of the walls.
    walls = row.replace(precompression="20 N", left_wall=hc.Wall(), right_wall=hc.Wall())
    run = hc.simulate(walls, until=50e-6, times=101)
    np.testing.assert_array_equal(run.sensor(8), 0.5 * (run.force(7) + run.forces[:, -1]))


def test_ensembles_have_the_same_sensors():
    row = hc.Chain.from_materials(5e-3, "steel-52100", beads=6, velocity=0.0)
    driven = row.replace(drive=DRIVE, right_wall=hc.Wall())
    table = hc.simulate_many([driven], keep=["sensor.largest"], sensors=[1], until=100e-6)
    run = hc.simulate(driven, until=100e-6, times=4001)
    assert table["sensor.largest"][0, 0] == pytest.approx(run.sensor(1).max(), rel=1e-3)


@pytest.mark.filterwarnings("ignore::hertzchain.IncompleteWarning")
@pytest.mark.parametrize("side", ["left_wall", "right_wall"])
def test_the_force_on_a_free_end_under_gravity_is_that_of_equilibrium(side):
    towards = 0.01 if side == "right_wall" else -0.01
    chain = hc.Chain.uniform(5).replace(
        **{side: hc.Wall()}, gravity=towards, precompression=0.1, held_by="force",
        velocities=np.zeros(5),
    )  # fmt: skip
    run, forces = hc.simulate(chain, until=1.0, times=21), hc.equilibrium(chain).forces
    for bead in range(1, 6):
        expected = 0.5 * (forces[bead - 1] + forces[bead])
        np.testing.assert_allclose(run.sensor(bead), expected, rtol=1e-9)
        assert run.sensor_force(bead).static_force == pytest.approx(expected, rel=1e-12)


@pytest.mark.filterwarnings("ignore::hertzchain.IncompleteWarning")
def test_the_force_on_the_end_acts_behind_the_strikers():
    held = hc.Chain.uniform(5).replace(precompression=0.1, held_by="force")
    run = hc.simulate(held.struck_by(velocity=0.1, gap=1.0), until=5.0, times=21)
    np.testing.assert_allclose(run.sensor(1), 0.0, atol=1e-15)
    np.testing.assert_allclose(run.sensor(2), 0.1, rtol=1e-9)
    assert run.sensor_force(1).static_force == 0.0
    assert run.sensor_force(2).static_force == pytest.approx(0.1)


def test_a_free_face_is_reported_and_twice_the_force_accelerates_the_body():
    row = hc.Chain.from_materials(5e-3, "steel-52100", beads=6).with_cap("0.5 kg")
    run = hc.simulate(row.struck_by(velocity="0.1 m/s"), times=4001)
    cap = run.sensor_force("cap")
    assert cap.free_face
    for text in (repr(cap), cap._repr_html_()):
        assert "the force on the body is twice this" in " ".join(text.split())
    # Newton's second law, from the velocity of the cap.
    acceleration = np.gradient(run.velocities[:, -1], run.times, edge_order=2)
    assert 2.0 * cap.largest_so_far == pytest.approx(0.5 * acceleration.max(), rel=1e-4)
    # The striker has a free face, too.
    assert [run.sensor_force(bead).free_face for bead in (1, 2, 7)] == [True, False, False]


def test_faces_with_walls_drives_or_precompression_are_not_free():
    row = hc.Chain.from_materials(5e-3, "steel-52100", beads=6, velocity=1e-3)
    walls = row.replace(right_wall=hc.Wall())
    driven = row.replace(velocities=np.zeros(6), drive=DRIVE)
    held = row.replace(precompression="20 N", held_by="force")
    found = [
        [hc.simulate(chain, until=800e-6).sensor_force(bead).free_face for bead in (1, 6)]
        for chain in (row, walls, driven, held)
    ]
    assert found == [[True, True], [True, False], [False, True], [False, False]]


def test_the_summary_states_a_free_face(run):
    row = ["simulate", "--material", "steel-52100", "--diameter", "10 mm", "--beads", "6",
           "--cap", "0.5 kg", "--speed", "0.1 m/s"]  # fmt: skip
    shown = run(*row, "--sensor", "cap", "--sensor", "3")[1]
    assert shown.count("the free face has none: the force on the body is twice this") == 1
    sensors = json.loads(run(*row, "--sensor", "cap", "--sensor", "3", "--json")[1])["sensors"]
    assert [each["free_face"] for each in sensors] == [True, False]


def test_the_numbers_of_forces_as_json_are_documented(run):
    row = ["simulate", "--material", "steel-52100", "--diameter", "10 mm", "--beads", "6",
           "--wall", "same", "--speed", "0.1 m/s", "--sensor", "3", "--contacts"]  # fmt: skip
    found = json.loads(run(*row, "--json")[1])
    table = (Path(__file__).parents[1] / "docs/reference/json.md").read_text(encoding="utf-8")
    named = set(
        re.findall(r"`(\w+)`", table.split("## `hertzchain simulate --json`")[1].split("\n## ")[0])
    )
    for name in ("walls", "sensors", "materials", "contacts"):
        assert set(found[name][0]) <= named, name
    free = json.loads(run(*[each for each in row if each not in ("--wall", "same")], "--json")[1])
    assert set(free["last_bead_force"]) <= named
