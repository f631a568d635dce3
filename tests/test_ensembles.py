"""`simulate_many` against `simulate`, SciPy and closed forms; bad members, units, interrupts."""

import numpy as np
import pytest
import scipy_chain
from interruption import interrupted

import hertzchain as hc
from hertzchain.pulse.quantities import (
    FINAL_QUANTITIES,
    QUANTITIES,
    SENSOR_QUANTITIES,
    WALL_QUANTITIES,
)
from hertzchain.simulation import ensemble_columns, ensemble_input

PULSE = [name for name, row in QUANTITIES.items() if not row.estimate]
WALL = hc.Wall()


def elastic_chains(count=16):
    """Random chains with every feature that the elastic kernel covers, in turn."""
    rng = np.random.default_rng(20)
    found = []
    for i in range(count):
        n = int(rng.integers(3, 14))
        chain = hc.Chain.from_radii(rng.uniform(0.7, 1.3, n)).replace(right_wall=WALL)
        inner = rng.uniform(0.5, 2.0, n - 1)
        found.append((
            chain,
            hc.Chain.tapered("forward-exponential", 0.03, beads=n).replace(
                right_wall=hc.Wall.rigid()
            ),
            chain.replace(
                stiffness=inner, left_wall=hc.Wall(stiffness=0.7), right_wall=hc.Wall(stiffness=0.4)
            ),
            chain.replace(gaps=rng.uniform(0.0, 0.3, n - 1), right_wall=hc.Wall(gap=0.2)),
            chain.replace(precompression=0.05, left_wall=hc.Wall()),
            hc.Chain.uniform(n, exponent=float(rng.uniform(1.2, 2.5))),
            chain.replace(
                exponent=rng.uniform(1.3, 2.2, n - 1), stiffness=inner,
                right_wall=hc.Wall(stiffness=1.2, exponent=1.7),
            ),
            hc.Chain.uniform(n).struck_by(mass=4.0).replace(right_wall=WALL),
        )[i % 8])  # fmt: skip
    return found


CHAINS = elastic_chains()
WALLED = [chain for chain in CHAINS if chain.right_wall is not None]
BALLS = hc.Chain.from_materials(5e-3, "steel-52100", beads=8, velocity=0.1)


def relative(found, exact, size=None):
    """Largest difference over the size of the exact values; NaN must be in the same places."""
    np.testing.assert_array_equal(np.isnan(found), np.isnan(exact))
    away = np.where(found == exact, 0.0, np.abs(found - exact))
    size = np.abs(exact) if size is None else size
    return float(np.nan_to_num(away / np.where(size > 0.0, size, 1.0)).max(initial=0.0))


@pytest.fixture(scope="module")
def tables():
    """The random chains, with and without a wall, at a tight tolerance."""
    return (
        hc.simulate_many(CHAINS, keep=PULSE, rtol=1e-12),
        hc.simulate_many(WALLED, keep=[*WALL_QUANTITIES], rtol=1e-12),
    )


def test_the_kernel_covers_these_chains():
    assert all(ensemble_input.is_covered(chain, None) for chain in CHAINS)
    for other in (
        BALLS.replace(loss=hc.Restitution(0.9)), BALLS.replace(drive=hc.StepDrive(1.0)),
        BALLS.replace(velocities=np.r_[0.0, 0.1, np.zeros(6)]),
    ):  # fmt: skip
        assert not ensemble_input.is_covered(other, None)


def test_pulses_agree_with_simulate(tables):
    table = tables[0]
    assert not table.reasons
    for i, chain in enumerate(CHAINS):
        run = hc.simulate(chain, times=0, rtol=1e-13)
        assert table.status[i] == run.status
        pulse = run.pulse()
        for name in PULSE:
            exact = pulse.column(name)
            found = table[name][i, : len(exact)]
            # Velocities are flat at their maximum, so that its time is found less exactly.
            tolerance = 1e-8 if name == "peak_time" else 1e-10
            size = np.nanmax(np.abs(exact)) if name in ("residence", "peak_time") else None
            assert relative(found, exact, size) < tolerance, (chain, name)
            assert np.isnan(table[name][i, len(exact) :]).all()


def test_walls_agree_with_simulate(tables):
    table = tables[1]
    tolerances = {
        "wall_peak_force": 1e-10, "wall_peak_time": 3e-8, "wall_largest_so_far": 1e-9,
        "wall_first_contact_impulse": 1e-9,
        # The wall is released within a step that ends at another time.
        "wall_impulse_of_impact": 1e-3, "wall_duration": 1e-3,
    }  # fmt: skip
    for i, chain in enumerate(WALLED):
        run = hc.simulate(chain, times=0, rtol=1e-13)
        wall = run._wall_force("right")
        assert table.status[i] == run.status
        assert table.complete[i] == wall.complete
        for name, tolerance in tolerances.items():
            exact = getattr(wall, WALL_QUANTITIES[name].attribute)
            exact = np.nan if exact is None else exact
            assert relative(table[name][i], exact) < tolerance, (chain, name)


def test_the_state_at_a_time_agrees_with_scipy():
    """An independent integration by SciPy: displacements, velocities, forces and impulses."""
    until = 6.0
    table = hc.simulate_many(
        CHAINS, keep=["final_position", "final_velocity", "end_time"], until=until, rtol=1e-12
    )
    walls = hc.simulate_many(WALLED, keep=["wall_impulse"], until=until, rtol=1e-12)
    assert (table["end_time"] == until).all()
    moved = {id(chain): i for i, chain in enumerate(WALLED)}
    for i, chain in enumerate(CHAINS):
        motion = scipy_chain.trajectory(chain, [until])
        rest = hc.equilibrium(chain).positions
        x, v = motion.displacements[0], motion.velocities[0]
        position = table["final_position"][i, : chain.beads] - rest
        assert relative(position, x, np.abs(x).max()) < 1e-8, chain
        assert relative(table["final_velocity"][i, : chain.beads], v, np.abs(v).max()) < 1e-8, chain
        if id(chain) in moved:
            impulse = walls["wall_impulse"][moved[id(chain)]]
            assert impulse == pytest.approx(motion.impulses[0, 1], abs=1e-8)


def test_energy_and_momentum_are_conserved():
    names = [name for name in FINAL_QUANTITIES if name.startswith("energy_")]
    chains = [chain for chain in WALLED if chain.left_wall is None and not chain.precompression]
    table = hc.simulate_many(
        chains, keep=[*names, "final_velocity", "final_position", "wall_impulse"], until=7.0,
        rtol=1e-12,
    )  # fmt: skip
    assert not table["energy_lost"].any()
    assert np.sum([table[name] for name in names], axis=0) == pytest.approx(1.0, abs=1e-14)
    for i, chain in enumerate(chains):
        velocities = table["final_velocity"][i, : chain.beads]
        given = float(chain.masses @ chain.velocities)
        left = float(chain.masses @ velocities) + table["wall_impulse"][i]
        assert left == pytest.approx(given, rel=1e-11)
        kinetic = 0.5 * float(chain.masses @ velocities**2)
        energy = 0.5 * float(chain.masses @ chain.velocities**2)
        moving = table["energy_forward"][i] + table["energy_backward"][i]
        # The parts are relative to their sum, the energy at the start.
        assert kinetic / moving == pytest.approx(energy, rel=1e-10)


def test_mirrored_chains():
    """Two equal beads in opposite motion: a chain and its mirror image end as mirror images."""
    rng = np.random.default_rng(3)
    radii = rng.uniform(0.8, 1.2, 9)
    masses, stiffness = radii**3, rng.uniform(0.5, 1.5, 8)
    velocities = np.r_[1.0, np.zeros(7), -1.0]
    walls = {"left_wall": hc.Wall(stiffness=0.7), "right_wall": hc.Wall(stiffness=1.3)}
    one = hc.Chain.uniform(9).replace(
        masses=masses, stiffness=stiffness, velocities=velocities, **walls
    )
    other = hc.Chain.uniform(9).replace(
        masses=masses[::-1], stiffness=stiffness[::-1], velocities=velocities,
        left_wall=walls["right_wall"], right_wall=walls["left_wall"],
    )  # fmt: skip
    table = hc.simulate_many(
        [one, other], keep=["final_velocity", "final_position"], until=20.0, rtol=1e-12
    )
    for name in ("final_velocity", "final_position"):
        np.testing.assert_allclose(table[name][0], -table[name][1][::-1], atol=1e-9)


def test_two_beads_and_a_rigid_wall_in_closed_form():
    """A bead of equal mass gives its velocity on; the last one presses the wall with all of it."""
    chain = hc.Chain.uniform(2).replace(right_wall=hc.Wall(gap=5.0, stiffness=1.0))
    table = hc.simulate_many([chain], keep=["wall_peak_force", "wall_first_contact_impulse"])
    # Half the energy of motion 1/2 is (2/5) k d^(5/2).
    assert table["wall_peak_force"][0] == pytest.approx((2.5 * 0.5) ** 0.6, rel=1e-7)
    assert table["wall_first_contact_impulse"][0] == pytest.approx(2.0, rel=1e-7)


def test_sensors_agree_with_densely_saved_forces():
    chains = [chain for chain in CHAINS if chain.beads > 5]
    table = hc.simulate_many(chains, keep=[*SENSOR_QUANTITIES], sensors=[3, 5], rtol=1e-10)
    assert table["sensor_impulse"].shape == (len(chains), 2)
    for i, chain in enumerate(chains):
        run = hc.simulate(chain, times=2000, rtol=1e-10)
        spacing = run.times[1] - run.times[0]
        near = table["sensor_first_maximum_time"][i]
        times = np.unique([time + np.linspace(-spacing, spacing, 801) for time in near])
        close = hc.simulate(chain, times=times, rtol=1e-12)
        for s, bead in enumerate((3, 5)):
            seen = run.sensor_force(bead).first_maximum_time
            assert abs(near[s] - seen) <= 1.01 * spacing, chain
            force = close.sensor(bead)[np.abs(times - near[s]) <= spacing]
            first = table["sensor_first_maximum"][i, s]
            assert first == pytest.approx(force.max(), rel=1e-6), chain
    until = hc.simulate_many(chains, keep=["sensor_impulse"], sensors=[3], until=5.0, rtol=1e-10)
    for i, chain in enumerate(chains):
        run = hc.simulate(chain, times=np.linspace(0.0, 5.0, 4001), rtol=1e-12)
        impulse = np.trapezoid(run.sensor(3), run.times)
        assert until["sensor_impulse"][i, 0] == pytest.approx(impulse, rel=1e-5, abs=1e-9)


def test_chains_with_losses_and_drives_have_the_same_columns():
    """They are integrated by `simulate`, in the same call and order."""
    walled = BALLS.replace(right_wall=WALL)
    lossy = walled.replace(loss=hc.Restitution(0.8))
    driven = walled.replace(drive=hc.StepDrive(1.0, rise="20 us"), velocities=np.zeros(8))
    chains = [lossy, walled, driven.replace(drive=hc.SineBurst(5.0, 5e3, cycles=0.5)), lossy]
    keep = [*PULSE, *WALL_QUANTITIES, *FINAL_QUANTITIES]
    table = hc.simulate_many(chains, keep=keep, rtol=1e-10)
    assert not table.reasons
    assert table.complete.all()
    for i, chain in enumerate(chains):
        run = hc.simulate(chain, times=0, rtol=1e-12)
        wall = run.wall_force()
        assert table["wall_peak_force"][i] == pytest.approx(wall.peak, rel=1e-7)
        velocity = run.pulse().velocity
        assert relative(table["velocity"][i], velocity, np.nanmax(np.abs(velocity))) < 1e-7
    assert table["energy_lost"][0] > 0.1
    assert table["energy_lost"][1] == 0.0
    parts = [table[name] for name in FINAL_QUANTITIES if name.startswith("energy_")]
    assert np.sum(parts, axis=0) == pytest.approx(1.0, abs=1e-12)
    assert table.units == "SI"


def test_largest_overlaps_are_those_of_the_whole_run():
    """References: runs of `simulate` with finely saved times, and the same call by `simulate`."""
    chains = [WALLED[0], WALLED[1], WALLED[2].replace(loss=hc.Restitution(0.8))]
    table = hc.simulate_many(chains, keep=["largest_overlap", "peak_overlap"], rtol=1e-10)
    for i, chain in enumerate(chains):
        fine = hc.simulate(chain, times=8000, rtol=1e-12).largest_overlaps
        own = table["largest_overlap"][i, : chain.beads - 1]
        assert own == pytest.approx(fine[1:-1], rel=1e-6)
        assert table._overlaps[i, chain.beads] == pytest.approx(fine[-1], rel=1e-6)
    # Where the wave from the wall meets the pulse, contacts are loaded more than before.
    assert np.nanmax(table["largest_overlap"] / table["peak_overlap"]) > 1.01


def test_lossy_chains_without_loss_agree_with_the_kernel(monkeypatch):
    """The two ways to integrate give the same numbers for the same chains."""
    keep = [*PULSE, "wall_peak_force", "wall_peak_time", *SENSOR_QUANTITIES]
    chains = WALLED[:8]
    sensors = [2]
    one = hc.simulate_many(chains, keep=keep, sensors=sensors, rtol=1e-11)
    monkeypatch.setattr("hertzchain.simulation.ensemble_columns.is_covered", lambda *_: False)
    other = hc.simulate_many(chains, keep=keep, sensors=sensors, rtol=1e-11)
    for name in keep:
        if name == "sensor_impulse" or name.startswith("sensor_largest"):
            continue  # of whole runs, which end at other times
        size = np.nanmax(np.abs(other[name]))
        # `simulate` finds maxima of sensors at saved times.
        assert relative(one[name], other[name], size) < (1e-3 if "sensor" in name else 1e-7), name


def test_tolerances_are_kept():
    """Errors of largest forces and velocities of short chains are of the size of the tolerance."""
    exact = hc.simulate_many(WALLED, keep=["wall_peak_force", "velocity"], rtol=1e-13)
    for rtol in (1e-6, 1e-8, 1e-10):
        table = hc.simulate_many(WALLED, keep=["wall_peak_force", "velocity"], rtol=rtol)
        assert relative(table["wall_peak_force"], exact["wall_peak_force"]) < 100.0 * rtol
        assert relative(table["velocity"], exact["velocity"], 1.0) < 100.0 * rtol


def test_peaks_that_a_later_impact_exceeds_are_not_reported():
    """After a first impact, motion is integrated less exactly until a larger force follows."""
    rng = np.random.default_rng(7)
    names = ["ptfe", "steel-52100"]
    chains = [
        hc.Chain.from_materials(
            np.full(20, 4.76e-3), [names[i] for i in 1 * (rng.random(20) < 0.5)], velocity=0.005,
            right_wall=hc.Wall.of("steel-52100"),
        )
        for _ in range(50)
    ]  # fmt: skip
    keep = ["wall_peak_force", "wall_peak_time", "velocity"]
    table = hc.simulate_many(chains, keep=keep, check_range=False, rtol=1e-10)
    assert table.complete.all()
    later = 0
    for i, chain in enumerate(chains):
        run = hc.simulate(chain, times=2000, rtol=1e-12)
        wall = run.wall_force()
        assert relative(table["wall_peak_force"][i], wall.peak) < 1e-6, i
        assert relative(table["wall_peak_time"][i], wall.peak_time) < 1e-5, i
        force = run.forces[:, -1]
        before = force[: int(np.argmax(force))]
        top = np.maximum.accumulate(before)
        later += bool(((before < 0.4 * top) & (top > 0.5 * wall.peak)).any())
    assert later > 5


def test_long_chains_and_many_lanes():
    """A chain does not depend on those that are integrated next to it, nor on threads."""
    rng = np.random.default_rng(4)
    chains = [
        hc.Chain.from_radii(rng.uniform(0.8, 1.2, n)).replace(right_wall=WALL)
        for n in rng.integers(5, 9, 70)
    ]
    keep = ["wall_peak_force", "arrival", "final_velocity"]
    together = hc.simulate_many(chains, keep=keep, threads=2)
    order = rng.permutation(len(chains))
    shuffled = hc.simulate_many((chains[i] for i in order), keep=keep, threads=1)
    for name in keep:
        np.testing.assert_array_equal(together[name][order], shuffled[name])
    long = hc.Chain.tapered("forward-exponential", 0.002, beads=300)
    walled = long.replace(right_wall=WALL)
    assert ensemble_input.is_covered(walled, None)
    assert not ensemble_input.is_covered(long, None)
    velocity = hc.simulate_many([long, walled], keep="velocity", rtol=1e-9)["velocity"]
    exact = hc.propagate(long, rtol=1e-10).velocity
    # The wall pushes the last bead back before it reaches its velocity at a free end.
    assert relative(velocity[0, :-1], exact[:-1]) < 1e-6
    assert relative(velocity[1, :-2], exact[:-2]) < 1e-6


@pytest.mark.filterwarnings("ignore::hertzchain.errors.IncompleteWarning")
def test_bad_members_do_not_stop_the_others():
    walled = hc.Chain.uniform(5).replace(right_wall=WALL)
    table = hc.simulate_many(
        [walled, hc.Chain.uniform(5), "chain", walled, walled.replace(loss=hc.Restitution(0.5))],
        keep=["wall_peak_force", "sensor_first_maximum"], sensors=[5], max_steps=100_000,
    )  # fmt: skip
    assert table.status.tolist()[1:3] == ["failed", "failed"]
    assert table.reasons[1] == "the right end of this chain is free; add a right_wall"
    assert "requires a Chain, got 'chain'" in table.reasons[2]
    assert set(table.reasons) == {1, 2}
    assert np.isnan(table["wall_peak_force"][[1, 2]]).all()
    assert table["wall_peak_force"][0] == table["wall_peak_force"][3]
    assert table.beads.tolist() == [5, 5, 0, 5, 5]
    few = hc.simulate_many([walled, walled.replace(loss=hc.Restitution(0.5))], max_steps=10)
    assert all("stopped by the step limit" in reason for reason in few.reasons.values())
    assert len(few.reasons) == 2
    longer = hc.Chain.uniform(6).replace(right_wall=WALL)
    short = hc.simulate_many([walled, longer], keep=["sensor_impulse"], sensors=[6])
    assert short.reasons == {0: "there is no bead 6 with a sensor among 5"}
    falling = walled.replace(right_wall=None, gravity=0.1, left_wall=hc.Wall())
    assert "gravity accelerates this chain" in hc.simulate_many([falling]).reasons[0]


def test_incomplete_peaks():
    chain = hc.Chain.uniform(20).replace(right_wall=WALL)
    table = hc.simulate_many([chain], keep=["wall_peak_force", "wall_largest_so_far"], until=24.0)
    assert not table.complete[0]
    assert np.isnan(table["wall_peak_force"][0])
    run = hc.simulate(chain, until=24.0, times=0)
    largest = run._wall_force("right").largest_so_far
    assert table["wall_largest_so_far"][0] == pytest.approx(largest, rel=1e-6)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"chains": hc.Chain.uniform(3)}, "a list of chains, got one; use simulate"),
        ({"chains": [hc.Chain.uniform(3), BALLS]}, "1 of 2 chains are in SI units and the others"),
        ({"chains": 3}, "chains must be a list of chains, got 3"),
        ({"keep": "force"}, "quantity"),
        ({"keep": []}, "keep must have at least one quantity"),
        ({"keep": "velocity_error"}, "quantity"),
        ({"keep": "sensor_impulse"}, "quantities of sensors need sensors"),
        ({"sensors": [0]}, "bead with a sensor must be a whole number of at least 1"),
        ({"rtol": 1e-3}, "rtol must be"),
        ({"until": 0.0}, "until must be above 0"),
        ({"threads": 0}, "threads must be"),
        ({"max_steps": 0}, "max_steps must be"),
    ],
)
def test_bad_options(options, said):
    with pytest.raises(hc.InputError, match=said):
        hc.simulate_many(**({"chains": [hc.Chain.uniform(3)]} | options))


def test_scratch_arrays_of_few_sizes_are_kept():
    """A set of 8 MB of each number of beads would fill the memory in a sweep of lengths."""
    chains = [hc.Chain.uniform(beads).replace(right_wall=WALL) for beads in range(4, 40)]
    runs = hc.simulate_many(chains, keep=["largest_overlap"], threads=2)
    kept = [scratch for _, scratch in ensemble_columns._SPARE]
    assert 0 < sum(values.nbytes for scratch in kept for values in scratch) < 2**28
    again = hc.simulate_many(chains, keep=["largest_overlap"], threads=2)
    np.testing.assert_array_equal(again["largest_overlap"], runs["largest_overlap"])


def test_too_little_memory(monkeypatch):
    import psutil

    class Memory:
        available = 2**20

    monkeypatch.setattr(psutil, "virtual_memory", Memory)
    with pytest.raises(hc.InputError, match=r"100000 chains of up to 800 beads need 1\.\d GiB"):
        hc.simulate_many([hc.Chain.uniform(800)] * 100_000)


def test_tables():
    chains = [hc.Chain.uniform(n).replace(right_wall=WALL) for n in (4, 6)]
    table = hc.simulate_many(
        chains, keep=["velocity", "peak_force", "wall_peak_force", "sensor_impulse"], sensors=[2, 4]
    )
    data = table.to_xarray()
    assert dict(data.sizes) == {"chain": 2, "bead": 6, "contact": 5, "sensor": 2}
    assert data.sensor.values.tolist() == [2, 4]
    assert data.wall_peak_force.attrs["long_name"] == "peak force on the right wall"
    frame = table.to_dataframe()
    assert frame["sensor_impulse_4"].tolist() == table["sensor_impulse"][:, 1].tolist()
    assert frame["status"].tolist() == ["wall force complete"] * 2
    assert "velocity_6" in frame
    assert np.isnan(frame["velocity_6"][0])
    with pytest.raises(hc.InputError, match="quantity of this table"):
        table["arrival"]
    with pytest.raises(ValueError, match="read-only"):
        table["velocity"][0] = 1.0
    assert len(hc.simulate_many([])) == 0


@pytest.mark.filterwarnings("ignore::hertzchain.errors.ModelRangeWarning")
def test_outside_the_range_of_hertz():
    slow = hc.Chain.from_materials(5e-3, "steel-52100", beads=5, velocity=0.05)
    fast = hc.Chain.from_materials(5e-3, "steel-52100", beads=5, velocity=5.0)
    table = hc.simulate_many([slow, fast])
    assert table.outside_range.tolist() == [False, True]


def test_progress():
    seen = []
    chains = [hc.Chain.uniform(5)] * 60
    hc.simulate_many(chains, progress=lambda done, of: seen.append((done, of)))
    assert seen[-1] == (60, 60)
    assert seen == sorted(seen)


INTERRUPTED = {
    "kernel": "[hc.Chain.uniform(200).replace(left_wall=hc.Wall(), right_wall=hc.Wall())] * 4",
    "simulate": "[hc.Chain.uniform(200).replace(loss=hc.Restitution(0.9), gaps=[0.1] * 199)] * 4",
}


@pytest.mark.parametrize("what", INTERRUPTED)
def test_interrupt(what):
    """Ctrl-C ends the work within two seconds and says how far it came."""
    code = f"""
        import hertzchain as hc
        short = hc.Chain.uniform(3)
        hc.simulate_many([short, short.replace(loss=hc.Restitution(0.9))], until=1.0)
        report = lambda done, of: print("working", flush=True)
        hc.simulate_many({INTERRUPTED[what]}, until=1e6, progress=report)
    """
    errors = interrupted(code)
    assert "KeyboardInterrupt" in errors
    assert "stopped after" in errors


def test_sweeps_simulate_batches_together(monkeypatch):
    """The same values as one by one, and the same reasons and flags."""
    specification = {
        "chain": {"taper": "forward-exponential", "beads": 8, "right_wall": {}},
        "axes": {"rate": [0.01, 0.03, 0.06]},
        "sweep": {
            "methods": ["simulate"], "keep": ["velocity", "arrival", "wall_peak_force"],
            "at": "every",
        },
    }  # fmt: skip
    together = hc.sweep(specification)
    monkeypatch.setattr("hertzchain.sweeps.batches.is_covered", lambda *_: False)
    alone = hc.sweep(specification)
    for name in ("velocity", "arrival", "wall_peak_force"):
        np.testing.assert_allclose(together[name], alone[name], rtol=1e-10)
    for name in ("status", "reason", "outside_range", "incomplete", "sensitive"):
        if name in alone:
            assert together[name].values.tolist() == alone[name].values.tolist()


def test_sweeps_keep_the_reasons_of_values_that_are_absent():
    specification = {
        "chain": {"taper": "uniform", "beads": 8},
        "axes": {"beads": [4, 8]},
        "sweep": {"methods": ["simulate"], "keep": ["velocity"], "at": "every"},
        "method": {"until": 3.0},
    }
    with pytest.warns(hc.IncompleteWarning, match="2 of 2 points failed"):
        found = hc.sweep(specification)
    assert "no first maximum of the velocity" in str(found["reason"].sel(beads=8).values)


@pytest.mark.filterwarnings("ignore::hertzchain.errors.ModelRangeWarning")
def test_the_check_of_reflections_can_be_omitted():
    """The leading pulse is elastic in this taper, but not its reflection in front of the wall."""
    tapers = [
        hc.Chain.tapered(
            first="6.35 mm", last=last, beads=3, material="steel-52100", taper="exponential"
        ).replace(right_wall=hc.Wall.of("steel-52100"))
        for last in ("4 mm", "5 mm")
    ]
    chains = [taper.replace(velocities=[0.3, 0.0, 0.0]) for taper in tapers]
    whole = hc.simulate_many(chains, keep=["wall_peak_force"])
    leading = hc.simulate_many(chains, keep=["wall_peak_force"], check_range=False)
    # Steps end at checks of the wall, which are less frequent if only the peak is requested.
    assert leading["wall_peak_force"] == pytest.approx(whole["wall_peak_force"], rel=1e-12)
    assert whole.outside_range.tolist() == [True, False]
    assert leading.outside_range.tolist() == [False, False]
    assert "1 of 2 chains outside Hertz's range:" in repr(whole)
    assert "0 of 2 chains outside Hertz's range (reflections not" in repr(leading)


@pytest.mark.filterwarnings("ignore::hertzchain.errors.IncompleteWarning")
def test_sensors_of_beads_that_no_chain_has_are_rejected():
    chains = [hc.Chain.uniform(8), hc.Chain.uniform(10)]
    with pytest.raises(hc.InputError, match="no bead 11 for a sensor in chains of up to 10 beads"):
        hc.simulate_many(chains, keep=["sensor_impulse"], sensors=[3, 11])
    # The shorter chain has no bead 9.
    table = hc.simulate_many(chains, keep=["sensor_impulse"], sensors=[9])
    assert [*table.reasons] == [0]


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
@pytest.mark.parametrize(
    "loss", [hc.ElasticPlastic(), hc.Restitution(0.9), hc.WaltonBraun(0.8)], ids=str
)
def test_a_run_for_the_peak_alone_ends_when_the_peak_is_proven(loss, monkeypatch):
    """Reference: the whole run."""
    rng = np.random.default_rng(4)
    runs, ends = [], []
    own = ensemble_columns.simulate_to_peak
    monkeypatch.setattr(
        ensemble_columns, "simulate_to_peak", lambda *a, **b: runs.append(own(*a, **b)) or runs[-1]
    )
    for _ in range(6):
        radii = rng.choice([1.5e-3, 2e-3, 2.5e-3, 4e-3], 7)
        chain = hc.Chain.from_materials(
            radii, "steel-52100", velocity=1.0, right_wall=hc.Wall(), loss=loss
        )
        keep = ["wall_peak_force", "wall_peak_time", "velocity", "arrival"]
        table = hc.simulate_many([chain], keep=keep, check_range=False)
        whole = hc.simulate_many([chain], keep=keep)
        for name in keep:
            np.testing.assert_allclose(table[name], whole[name], rtol=1e-6)
        ends.append(hc.simulate(chain, times=0).end_time)
    assert sum(run.end_time for run in runs) < 0.95 * sum(ends)
    assert len(runs) == 6
    # The impulse needs the whole impact.
    hc.simulate_many([chain], keep="wall_impulse_of_impact", check_range=False)
    assert len(runs) == 6


@pytest.mark.parametrize("loss", [None, hc.Viscoelastic(1e-7)])
def test_one_warning_states_the_number_of_chains_outside_the_range_at_the_line_of_the_call(loss):
    """Chains with losses are integrated one by one, in threads."""
    chain = hc.Chain.from_materials("5 mm", "steel-304", beads=5, velocity="1 m/s")
    slow = chain.replace(velocities=1e-3 * chain.velocities)
    chains = [each.replace(loss=loss) for each in (slow, chain, chain)]
    with pytest.warns(hc.ModelRangeWarning) as raised:
        table = hc.simulate_many(chains)
    assert len(raised) == 1
    assert raised[0].filename == __file__
    text = str(raised[0].message)
    assert text.startswith(
        "simulation: 2 of 3 chains exceed the limits of Hertz's law; in the first of them, "
    )
    assert text.endswith(f"chain 1, {table.exceeded_limits(1)[0]}")
    assert [bool(table.exceeded_limits(i)) for i in range(3)] == table.outside_range.tolist()
    hc.simulate_many(chains, check_range=False)


@pytest.mark.parametrize("many", [hc.propagate_many, hc.simulate_many])
def test_a_warning_states_the_number_of_failed_chains_and_the_first_reason(many):
    falling = hc.Chain.uniform(5).replace(gravity=0.1)
    with pytest.warns(hc.IncompleteWarning) as raised:
        table = many([hc.Chain.uniform(5), falling, falling])
    assert str(raised[0].message) == (
        "2 of 3 chains failed and have no values; in the first of them, chain 1, "
        f"{table.reasons[1]}"
    )
    assert raised[0].filename == __file__
