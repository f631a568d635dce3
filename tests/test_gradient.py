"""Derivatives of simulated quantities against long double, closed forms and symmetries."""

import copy
import dataclasses
import math
import pickle
import warnings
from types import SimpleNamespace

import numpy as np
import pytest
from kernel_call import callable_from_python
from long_double_steps import derivative
from scipy_chain import trajectory

import hertzchain as hc
from hertzchain.derivatives import gradient as module
from hertzchain.errors import IncompleteWarning, InputError

NUMBERS = "masses", "stiffness", "overlaps", "velocities"


@pytest.fixture
def recorded(monkeypatch):
    """Records of runs, and derivatives by the numbers of the equation of motion."""
    kept = {"slopes": []}
    run, back, follow = module.run, module.backward_pass, module.follow_pulse

    def keep_run(*args):
        kept["record"] = run(*args)
        return kept["record"]

    def keep_pass(record, dependence):
        slopes = back(record, dependence)
        kept["slopes"].append((dependence, slopes))
        return slopes

    def keep_window(*args, **options):
        kept["record"] = kept["window"] = follow(*args, **options)
        return kept["record"]

    monkeypatch.setattr(module, "run", keep_run)
    monkeypatch.setattr(module, "follow_pulse", keep_window)
    monkeypatch.setattr(module, "backward_pass", keep_pass)
    return kept


def apart(exponent=1.5):
    """A chain between walls in which no contact is touching, so that forces are smooth."""
    chain = hc.Chain.from_radii([1.0, 0.7, 1.2, 0.9, 0.8], exponent=exponent)
    return chain.replace(
        gaps=[0.02, 0.01, 0.03, 0.015], velocities=[1.0, 0.1, 0.0, -0.05, 0.0],
        left_wall=hc.Wall(gap=0.1, stiffness=1.2), right_wall=hc.Wall(gap=0.05, stiffness=1.5),
    )  # fmt: skip


READ = {
    "wall_force.peak": lambda at: at.forces(at.x)[-1],
    "wall_force.impulse": lambda at: at.impulse[-1],
    "sensor.impulse@3": lambda at: 0.5 * (at.impulse[2] + at.impulse[3]),
    "pulse.velocity@4": lambda at: at.v[3],
    "pulse.energy@3": lambda at: 0.5 * at.masses[2] * at.v[2] ** 2,
    "pulse.peak_force@2": lambda at: at.forces(at.x)[2],
    "final.position@2": lambda at: at.x[1],
    "energy.contacts": lambda at: (
        at.forces(at.x) * np.maximum(at.overlaps_at(at.x), 0) / (at.exponents + 1)
    )[1:-1].sum(),
    "energy.kinetic": lambda at: (0.5 * at.masses * at.v**2).sum(),
}


# Between two walls no peak is ever complete.
@pytest.mark.long
@pytest.mark.filterwarnings("ignore::hertzchain.errors.IncompleteWarning")
@pytest.mark.parametrize("exponent", [1.5, 2.0])
def test_derivatives_of_the_steps_in_long_double(recorded, exponent):
    found = hc.gradients(apart(exponent), [*READ], to="masses", until=25.0, rtol=1e-6)
    check_derivatives(recorded, found)


def check_derivatives(recorded, found, numbers=NUMBERS):
    """Compare derivatives by all numbers with differences on the same steps."""
    record = recorded["record"]
    lengths = np.concatenate([block.lengths for block in record.blocks])
    for each, (dependence, slopes) in zip(found, recorded["slopes"], strict=True):
        own = lengths
        if dependence.places:
            place = dependence.places[0]
            own = np.append(lengths[: place.step], place.length)
        for name in numbers:
            exact = getattr(slopes, name)
            for index in (0, 2, len(exact) - 1):
                reference = derivative(record.equation, name, index, own, READ[each.quantity], 1e-8)
                error = abs(exact[index] - reference) / np.abs(exact).max()
                assert error < 1e-8, (each.quantity, name, index)


@pytest.mark.parametrize("kind", ["forward", "backward"])
def test_derivatives_of_the_steps_of_a_window_in_long_double(recorded, kind):
    chain = hc.Chain.tapered(f"{kind}-exponential", 0.03, beads=12)
    quantities = [name for name in READ if name.startswith("pulse")]
    found = hc.gradients(chain, quantities, to="masses", rtol=1e-6)
    assert recorded["window"] is not None
    # Differences of gaps and velocities of touching beads converge only like a root.
    check_derivatives(recorded, found, ("masses", "stiffness"))


SMOOTH = {
    "forward": hc.Chain.tapered("forward-exponential", 0.03, beads=60),
    "backward": hc.Chain.tapered("backward-exponential", 0.03, beads=60),
    "sine": hc.Chain.from_radii(1.0 + 0.3 * np.sin(np.arange(60) / 5.0)),
    "exponent 2": hc.Chain.uniform(60, exponent=2.0),
}


@pytest.mark.parametrize("chain", SMOOTH.values(), ids=SMOOTH)
def test_gradients_of_a_window_are_those_of_all_beads(recorded, monkeypatch, chain):
    names = [f"pulse.{name}@48" for name in ("velocity", "peak_time", "arrival", "residence")]
    names += ["pulse.peak_force@30", "pulse.momentum@60"]
    to = ("radii", "masses", "stiffness")
    found = hc.gradients(chain, names, to=to)
    widths = np.diff(recorded["window"].blocks[0].windows, axis=1)
    assert 4 < np.median(widths) < 20
    assert max(each.error for each in found) < 1e-3
    monkeypatch.setattr(module, "follow_pulse", lambda *_, **__: None)
    for each, whole in zip(found, hc.gradients(chain, names, to=to, rtol=1e-11), strict=True):
        assert each.value == pytest.approx(whole.value, rel=2e-7)
        for name in to:
            largest = np.abs(whole[name]).max()
            assert each[name] == pytest.approx(whole[name], abs=each.error * largest)


def differences(chain, read, change, size):
    """Central difference of a quantity of `simulate_many` at tight tolerance."""
    low, high = (read(change(chain, sign * size)) for sign in (-1.0, 1.0))
    return (high - low) / (2.0 * size)


def wall_peak(chain):
    table = hc.simulate_many([chain], keep=["wall_peak_force"], rtol=1e-13, threads=1)
    return float(table["wall_peak_force"][0])


def radius_changed(k):
    def change(chain, size):
        radii = chain.radii.copy()
        radii[k] += size
        return chain.replace(radii=radii)

    return change


def test_radii_against_differences_of_simulations():
    chain = hc.Chain.tapered("forward-exponential", 0.04, beads=8).replace(right_wall=hc.Wall())
    found = hc.gradient(chain, "wall_force.peak")
    for k in (1, 4, 7):
        reference = differences(chain, wall_peak, radius_changed(k), 1e-4)
        assert found["radii"][k] == pytest.approx(reference, abs=3e-5)


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
def test_materials_against_differences_of_simulations():
    chain = hc.Chain.from_materials(
        np.full(4, 5e-3), ["steel-316", "ptfe", "steel-316", "ptfe"], velocity=0.5,
        right_wall=hc.Wall.of("brass"),
    )  # fmt: skip
    to = ("young", "poisson", "density", "radii", "right_wall.stiffness")
    found = hc.gradient(chain, "wall_force.peak", to=to)

    def material_changed(name, k):
        def change(chain, size):
            kinds = list(chain.materials)
            value = getattr(kinds[k], name) * (1.0 + size)
            kinds[k] = type(kinds[k])(**(vars(kinds[k]) | {name: value}))
            return chain.replace(materials=tuple(kinds))

        return change

    for name in ("young", "poisson", "density"):
        for k in (1, 3):
            reference = differences(chain, wall_peak, material_changed(name, k), 1e-4)
            typical = np.abs(found[name] * [getattr(m, name) for m in chain.materials]).max()
            got = found[name][k] * getattr(chain.materials[k], name)
            assert got == pytest.approx(reference, abs=2e-4 * typical)


def test_static_loads_against_differences_of_simulations():
    chain = hc.Chain.from_radii([1.0, 0.8, 1.1, 0.9, 1.0]).replace(
        precompression=0.05,
        held_by="force",
        gravity=0.01,
        right_wall=hc.Wall(stiffness=1.4),
    )
    to = ("precompression", "gravity", "masses", "stiffness", "right_wall.stiffness")
    found = hc.gradient(chain, "wall_force.impulse", to=to, until=6.0)

    def read(chain):
        table = hc.simulate_many(
            [chain], keep=["wall_impulse"], until=6.0, rtol=1e-13, threads=1
        )  # fmt: skip
        return float(table["wall_impulse"][0])

    def with_array(name, k):
        def change(chain, size):
            values = np.array(getattr(chain, name))
            values[k] += size
            return chain.replace(**{name: values})

        return change

    def with_number(name):
        return lambda chain, size: chain.replace(**{name: getattr(chain, name) + size})

    changes = [(name, None, with_number(name)) for name in ("precompression", "gravity")]
    changes += [(name, k, with_array(name, k)) for name in ("masses", "stiffness") for k in (0, 3)]
    for name, k, change in changes:
        reference = differences(chain, read, change, 1e-5)
        got = found[name] if k is None else found[name][k]
        assert float(got) == pytest.approx(reference, rel=2e-5, abs=2e-6), (name, k)


def test_two_beads_have_the_derivatives_of_the_closed_form():
    chain = hc.Chain.from_radii([1.0, 0.8]).replace(masses=[1.3, 0.6], stiffness=[0.9])
    m, n, k = 1.3, 0.6, 0.9
    to = ("masses", "stiffness", "velocities")
    velocity = hc.gradient(chain, "pulse.velocity@2", to=to)
    assert velocity.value == pytest.approx(2.0 * m / (m + n), rel=1e-10)
    assert velocity["masses"] == pytest.approx(
        [2.0 * n / (m + n) ** 2, -2.0 * m / (m + n) ** 2], rel=1e-5
    )
    assert velocity["stiffness"] == pytest.approx([0.0], abs=1e-5)
    assert velocity["velocities"] == pytest.approx([2.0 * m / (m + n), (n - m) / (m + n)], rel=1e-5)

    # The largest overlap stores the energy of relative motion.
    reduced = m * n / (m + n)
    overlap = (1.25 * reduced / k) ** 0.4
    found = hc.gradient(chain, "pulse.peak_overlap@1", to=to)
    assert found.value == pytest.approx(overlap, rel=1e-10)
    by_reduced = 0.4 * overlap / reduced
    assert found["masses"] == pytest.approx(
        by_reduced * np.array([n**2, m**2]) / (m + n) ** 2, rel=1e-6
    )
    assert found["stiffness"] == pytest.approx([-0.4 * overlap / k], rel=1e-6)
    assert found["velocities"] == pytest.approx([0.8 * overlap, -0.8 * overlap], rel=1e-6)


# Powers of mass, length and time in each quantity.
UNITS = {
    "wall_force.peak": (1, 1, -2),
    "wall_force.peak_time": (0, 0, 1),
    "wall_force.first_contact_impulse": (1, 1, -1),
    "wall_force.duration": (0, 0, 1),
    "pulse.velocity@6": (0, 1, -1),
    "pulse.momentum@6": (1, 1, -1),
    "pulse.energy@3": (1, 2, -2),
    "pulse.peak_time@6": (0, 0, 1),
    "pulse.arrival@7": (0, 0, 1),
    "pulse.residence@4": (0, 0, 1),
    "pulse.peak_overlap@5": (0, 1, 0),
    "sensor.first_maximum@4": (1, 1, -2),
    "sensor.first_maximum_time@4": (0, 0, 1),
}


def test_a_change_of_units_changes_a_quantity_by_its_dimension():
    chain = hc.Chain.from_radii([1.0, 1.2, 0.8, 1.1, 0.9, 1.0, 0.7]).replace(
        right_wall=hc.Wall(gap=0.05), gaps=[0.0, 0.02, 0.0, 0.01, 0.0, 0.0]
    )
    to = ("masses", "stiffness", "gaps", "velocities", "right_wall.stiffness", "right_wall.gap")
    for each in hc.gradients(chain, [*UNITS], to=to):

        def by(name, values, found=each):
            return float(np.sum(found[name] * values))

        m = by("masses", chain.masses)
        k = by("stiffness", chain.stiffness)
        k += by("right_wall.stiffness", chain.wall_stiffness[1])
        length = by("gaps", chain.gaps) + by("right_wall.gap", 0.05)
        v = by("velocities", chain.velocities)
        # A stiffness is a mass over the root of a length and the square of a time.
        expected = np.array(UNITS[each.quantity]) * each.value
        got = m + k, length + v - 0.5 * k, -v - 2.0 * k
        assert got == pytest.approx(expected, abs=1e-4 * abs(each.value)), each.quantity


def test_a_common_velocity_is_added_to_all_beads():
    chain = hc.Chain.from_radii([1.0, 1.2, 0.8, 1.1, 0.9])
    found = hc.gradient(chain, "pulse.velocity@4", to="velocities")
    assert found["velocities"].sum() == pytest.approx(1.0, abs=1e-6)
    # No external force acts on a free chain.
    total = hc.gradients(chain, [f"final.velocity@{k}" for k in range(1, 6)], until=9.0,
                         to=("masses", "velocities"))  # fmt: skip
    momentum = sum(m * each["velocities"] for m, each in zip(chain.masses, total, strict=True))
    assert momentum == pytest.approx(chain.masses, abs=1e-9)


def test_values_are_those_of_simulations():
    chain = hc.Chain.from_radii([1.0, 0.9, 1.1, 0.7, 0.8]).replace(right_wall=hc.Wall())
    names = ("peak", "impulse_of_impact", "first_contact_impulse", "duration", "peak_time")
    found = hc.gradients(chain, [f"wall_force.{name}" for name in names])
    wall = hc.simulate(chain, rtol=1e-11).wall_force()
    for name, each in zip(names, found, strict=True):
        assert each.status == "complete"
        assert each.value == pytest.approx(getattr(wall, name), rel=1e-6), name
    free = hc.Chain.tapered("backward-exponential", 0.05, beads=20)
    pulse = hc.propagate(free)
    for name in ("velocity", "momentum", "energy", "arrival", "residence", "peak_force"):
        value, _ = hc.gradient(free, f"pulse.{name}", bead=12)
        assert value == pytest.approx(pulse.column(name)[11], rel=1e-8), name


def test_both_walls_are_mirror_images():
    chain = apart()
    mirrored = chain.replace(
        radii=chain.radii[::-1] / chain.radii[-1], masses=chain.masses[::-1],
        stiffness=chain.stiffness[::-1], gaps=chain.gaps[::-1],
        velocities=-chain.velocities[::-1], left_wall=chain.right_wall, right_wall=chain.left_wall,
    )  # fmt: skip
    one = hc.gradient(chain, "wall_force.impulse", to="masses", until=30.0, rtol=1e-12)
    other = hc.gradient(mirrored, "left_wall_force.impulse", to="masses", until=30.0, rtol=1e-12)
    assert other.value == pytest.approx(one.value, rel=1e-9)
    assert other["masses"][::-1] == pytest.approx(one["masses"], abs=3e-5)


LOSSES = {
    "loss.time": hc.Viscoelastic(0.05),
    "loss.coefficient": hc.Restitution(0.8),
    "no pull": hc.Restitution(0.8, attractive=False),
    "time, pulling": hc.Viscoelastic(0.05, attractive=True),
}


def damped(law):
    return hc.Chain.from_radii([1.0, 0.9, 1.1, 0.8, 0.7]).replace(
        right_wall=hc.Wall(stiffness=1.3, gap=0.02), loss=law
    )


@pytest.mark.parametrize("law", LOSSES.values(), ids=LOSSES)
def test_units_of_damped_chains(law):
    chain, viscous = damped(law), isinstance(law, hc.Viscoelastic)
    to = ["masses", "stiffness", "velocities", "right_wall.stiffness", "right_wall.gap"]
    to += ["loss.time"] if viscous else []
    names = ["wall_force.peak", "pulse.energy@3", "sensor.first_maximum@4"]
    for each in hc.gradients(chain, names, to=to):
        m = float(each["masses"] @ chain.masses)
        k = float(each["stiffness"] @ chain.stiffness) + 1.3 * each["right_wall.stiffness"]
        v = float(each["velocities"] @ chain.velocities)
        length = 0.02 * float(each["right_wall.gap"]) + v - 0.5 * k
        time = -v - 2.0 * k + (0.05 * float(each["loss.time"]) if viscous else 0.0)
        expected = np.array(UNITS[each.quantity]) * each.value
        # Units of mass and length do not change the lengths of steps; that of time does.
        assert (m + k, length) == pytest.approx(expected[:2], abs=2e-11 * abs(each.value))
        limit = 1e-5 if viscous else 5e-5
        assert time == pytest.approx(expected[2], abs=limit * abs(each.value))


@pytest.mark.parametrize("name", ["loss.time", "loss.coefficient"])
def test_losses_against_differences_of_simulations(name):
    chain = damped(LOSSES[name])
    field = name.removeprefix("loss.")

    def loss_changed(chain, size):
        return chain.replace(loss=type(chain.loss)(getattr(chain.loss, field) + size))

    found = hc.gradient(chain, "wall_force.peak", to=(name, "radii"))
    assert found.value == pytest.approx(wall_peak(chain), rel=1e-8)
    for got, change in ((found[name], loss_changed), (found["radii"][2], radius_changed(2))):
        reference = differences(chain, wall_peak, change, 1e-4)
        assert float(got) == pytest.approx(reference, abs=2e-4)


LAWS = {
    "restitution": hc.Restitution(0.8),
    "restitution, no pull": hc.Restitution(0.8, attractive=False),
    "viscoelastic": hc.Viscoelastic(0.05),
    "dashpot": hc.Dashpot(0.1),
    "dashpot, no pull": hc.Dashpot(0.1, attractive=False),
    "linear velocity power": hc.VelocityPower(0.1, alpha=1.0),
}


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::hertzchain.errors.IncompleteWarning")
@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_contacts_that_close_again_against_differences_of_simulations(law):
    chain = apart().replace(loss=law)
    parameter = {"Restitution": "coefficient", "Viscoelastic": "time"}.get(
        type(law).__name__, "gamma"
    )
    to = ("masses", "velocities", "right_wall.gap", f"loss.{parameter}")
    speed, push = hc.gradients(chain, ["final.velocity@3", "wall_force.impulse"], to=to, until=20.0)

    def read(chain):
        table = hc.simulate_many(
            [chain], keep=["final_velocity", "wall_impulse"], until=20.0, rtol=1e-13, threads=1
        )
        return np.array([table["final_velocity"][0, 2], table["wall_impulse"][0]])

    def changed(chain, size, name, k):
        if name == "right_wall.gap":
            wall = hc.Wall(gap=chain.right_wall.gap + size, stiffness=chain.right_wall.stiffness)
            return chain.replace(right_wall=wall)
        if name.startswith("loss"):
            changes = {parameter: getattr(law, parameter) + size}
            return chain.replace(loss=dataclasses.replace(law, **changes))
        values = np.array(getattr(chain, name))
        values[k] += size
        return chain.replace(**{name: values})

    for name, k in (("masses", 1), ("velocities", 2), (to[2], ()), (to[3], ())):
        reference = differences(chain, read, lambda c, s, n=name, k=k: changed(c, s, n, k), 1e-6)
        got = float(speed[name][k]), float(push[name][k])
        size = np.abs(speed[name]).max(), np.abs(push[name]).max()
        assert np.abs(got - reference) / size == pytest.approx(0.0, abs=1e-4), name


@pytest.mark.filterwarnings("ignore::hertzchain.errors.IncompleteWarning")
@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_errors_of_damped_gradients_are_those_stated(law):
    chain = apart().replace(loss=law)
    exact = hc.gradient(chain, "final.velocity@3", to=NUMBERS[:2], until=20.0, rtol=1e-14)
    for rtol in (1e-8, 1e-10, 1e-12):
        found = hc.gradient(chain, "final.velocity@3", to=NUMBERS[:2], until=20.0, rtol=rtol)
        for name in NUMBERS[:2]:
            error = np.abs(found[name] - exact[name]).max() / np.abs(exact[name]).max()
            assert error < found.error < 0.02, (rtol, name)


def test_forces_that_are_largest_at_a_jump_have_no_gradient():
    chain = hc.Chain.from_radii([1.0, 0.8]).replace(
        loss=hc.Dashpot(20.0), right_wall=hc.Wall(gap=0.1)
    )
    with pytest.warns(IncompleteWarning, match="largest where a force jumps"):
        found = hc.gradient(chain, "wall_force.peak")
    assert math.isnan(found.value)


def pulse_chain(kind):
    if kind in ("forward", "backward"):
        return hc.Chain.tapered(f"{kind}-exponential", 0.04, beads=50)
    rng = np.random.default_rng(7)
    if kind == "rough":
        return hc.Chain.from_radii(np.r_[1.0, rng.uniform(0.3, 1.0, 69)])
    # In light beads between heavy ones, the pulse breaks up, and its parts join behind them.
    rates = np.r_[np.zeros(5), np.full(8, -0.15), np.zeros(20), np.full(8, 0.15), np.zeros(28)]
    return hc.Chain.from_radii(np.exp(np.r_[0.0, np.cumsum(rates)]))


@pytest.mark.parametrize("kind", ["forward", "backward", "rough", "valley"])
def test_a_window_does_not_change_gradients_of_the_pulse(kind):
    chain = pulse_chain(kind)
    window = hc.gradient(chain, "pulse.velocity@45")
    # A wall ahead of the pulse changes nothing before it arrives there, but all beads are kept.
    whole = hc.gradient(chain.replace(right_wall=hc.Wall(gap=1e3)), "pulse.velocity@45")
    assert window.value == pytest.approx(whole.value, rel=1e-9)
    largest = np.abs(whole["radii"]).max()
    assert window["radii"] == pytest.approx(whole["radii"], abs=window.error * largest)
    other = hc.simulate(chain, times=0, rtol=1e-11).pulse().velocity[44]
    assert window.value == pytest.approx(other, rel=1e-8)


def rough_chains():
    """Chains whose neighbours differ as much as a window allows, and tapers."""
    rng = np.random.default_rng(5)
    beads = np.arange(60)
    logs = {
        "backward": 0.1 * beads[:30],
        "sine": 0.5 * np.sin(beads / 4.0),
        "walk": np.cumsum(rng.normal(0.0, 0.05, 60)),
        "rough": rng.normal(0.0, 0.04, 60),
    }
    return {name: hc.Chain.from_radii(np.exp(each - each[0])) for name, each in logs.items()}


@pytest.mark.parametrize("rtol", [1e-7, None, 1e-9])
@pytest.mark.parametrize("name", rough_chains())
def test_errors_in_a_window_are_at_most_those_stated(recorded, name, rtol):
    """Reference: all beads, with a tolerance at which differences of rtol do not matter."""
    chain = rough_chains()[name]
    bead = chain.beads - 4
    names = [f"pulse.{each}@{bead}" for each in ("velocity", "arrival", "residence", "peak_force")]
    to = ("radii", "masses", "stiffness", "gaps", "velocities")
    found = hc.gradients(chain, names, to=to, rtol=rtol)
    window = recorded["window"]
    assert window is not None
    assert name == "rough" or len(window.blocks[0].releases) > 5
    until = 1.3 * hc.propagate(chain).peak_time[-1]
    for each, exact in zip(
        found, hc.gradients(chain, names, to=to, until=until, rtol=1e-12), strict=True
    ):
        assert each.value == pytest.approx(exact.value, rel=each.error)
        for key in to:
            error = np.abs(each[key] - exact[key]).max() / np.abs(exact[key]).max()
            assert error < each.error < 5e-3, (each.quantity, key)


def released_state(w):
    """Rows of the kernels with a window of four beads, of which the second contact opens soon."""
    from hertzchain.kernels import adjoint_layout as layout

    rng = np.random.default_rng(8)
    for c in range(6):
        w[layout.STIFFNESS + c] = rng.uniform(0.8, 1.2)
        w[layout.EXPONENT + c] = 1.5
        w[layout.INVERSE_MASS + c] = rng.uniform(0.8, 1.2)
    w[layout.X + 1 : layout.X + 5] = [0.9, 0.62, 0.6, 0.0]
    w[layout.V + 1 : layout.V + 5] = [0.1, 0.2, 0.6, 0.5]
    return w


def released_sum(change, weights):
    """A linear function of the state after contact 2 has been released."""
    from hertzchain.kernels import adjoint_layout as layout
    from hertzchain.kernels import adjoint_release as kernel

    w = released_state(np.zeros(layout.END_OF_ROWS))
    for entry, size in change.items():
        w[entry] += size
    out = np.zeros(layout.RELEASE)
    assert callable_from_python(kernel.release)(w, 2, 7, out)
    states = np.r_[w[layout.X + 1 : layout.X + 5], w[layout.V + 1 : layout.V + 5]]
    return states @ weights, w, out


@pytest.mark.long
def test_the_release_of_a_contact_has_the_derivatives_of_its_differences():
    from hertzchain.kernels import adjoint_layout as layout
    from hertzchain.kernels import adjoint_release as kernel

    weights = np.random.default_rng(9).normal(size=8)
    _, _, out = released_sum({}, weights)
    w = released_state(np.zeros(layout.END_OF_ROWS))
    w[layout.LX : layout.LX + 4], w[layout.LV : layout.LV + 4] = weights[:4], weights[4:]
    callable_from_python(kernel.reverse_release)(w, out)
    entries = [(layout.X + 1 + i, w[layout.LX + i]) for i in range(4)]
    entries += [(layout.V + 1 + i, w[layout.LV + i]) for i in range(4)]
    entries += [(layout.STIFFNESS + c, w[layout.BY_STIFFNESS + c]) for c in (1, 2, 3)]
    # The masses are stored as inverses, and their derivatives as those by logarithms.
    entries += [
        (layout.INVERSE_MASS + i, -w[layout.BY_MASS + i] / w[layout.INVERSE_MASS + i])
        for i in (1, 2, 3)
    ]
    for entry, derivative_found in entries:
        size = 1e-5
        above, below = (released_sum({entry: sign * size}, weights)[0] for sign in (1.0, -1.0))
        assert derivative_found == pytest.approx((above - below) / (2.0 * size), abs=2e-8)


def test_a_released_contact_gives_the_motion_of_the_complete_force():
    """Reference: SciPy's DOP853 until the contact is open."""
    from scipy.integrate import solve_ivp

    from hertzchain.kernels import adjoint_layout as layout

    _, after, _ = released_sum({}, np.zeros(8))
    before = released_state(np.zeros(layout.END_OF_ROWS))
    k = before[layout.STIFFNESS + 1 : layout.STIFFNESS + 4]
    inverse = before[layout.INVERSE_MASS : layout.INVERSE_MASS + 4]

    def motion(w, released):
        def rates(_, y):
            d = np.maximum(y[:3] - y[1:4], 0.0)
            d[1] *= not released
            forces = np.pad(k * d**1.5, 1)
            return np.r_[y[4:], -np.diff(forces) * inverse]

        start = np.r_[w[layout.X + 1 : layout.X + 5], w[layout.V + 1 : layout.V + 5]]
        return solve_ivp(rates, (0.0, 0.3), start, method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]

    whole, closed_form = motion(before, False), motion(after, True)
    # The bead behind keeps its velocity: it no longer affects those ahead.
    assert np.abs(whole - closed_form)[[2, 3, 6, 7]].max() < 2e-6


def top_of(samples):
    """Maximum of the parabola through the largest sample and its neighbours."""
    n = int(samples.argmax())
    if n == 0:
        return samples[0]
    before, top, after = samples[n - 1 : n + 2]
    return top + (after - before) ** 2 / (8.0 * (2.0 * top - before - after))


@pytest.mark.long
@pytest.mark.parametrize("loss", [None, hc.Viscoelastic(0.02)])
def test_the_largest_velocity_of_the_whole_run_is_that_of_scipy(loss):
    """A later maximum can be larger than the first; reference: SciPy's DOP853 at many times."""
    chain = hc.Chain.from_radii([1.0, 0.4, 0.9, 0.35, 0.8, 0.5, 0.7, 0.6])
    chain = chain.replace(right_wall=hc.Wall(), loss=loss)
    times = np.linspace(0.0, 30.0, 20_001)
    motion = trajectory(chain, times).velocities
    later = 0
    for bead in (1, 2, 4, 8):
        found = hc.gradient(chain, "bead.largest_velocity", bead=bead, until=30.0)
        assert found.value == pytest.approx(top_of(motion[:, bead - 1]), rel=1e-7)
        first = hc.gradient(chain, "pulse.velocity", bead=bead, until=30.0).value
        later += found.value > 1.01 * first
        energy = hc.gradient(chain, "bead.largest_energy", bead=bead, until=30.0).value
        assert energy == pytest.approx(0.5 * chain.masses[bead - 1] * found.value**2)
    assert later


def test_the_largest_velocity_has_the_derivatives_of_its_differences():
    chain = hc.Chain.from_radii([1.0, 0.7, 0.9, 0.6, 0.8, 0.75, 0.5])
    for bead in (3, 6):
        found = hc.gradient(chain, "bead.largest_velocity", bead=bead)

        def largest(changed, bead=bead):
            times = np.linspace(0.0, 40.0, 4001)
            run = hc.simulate(changed, until=40.0, times=times, rtol=1e-12)
            return run.velocity_peaks(bead).velocities.max()

        for k in (1, 4):
            reference = differences(chain, largest, radius_changed(k), 1e-4)
            assert found["radii"][k] == pytest.approx(reference, abs=2e-5)


def test_maxima_include_the_largest_one():
    chain = hc.Chain.from_radii([1.0, 0.5, 0.9, 0.4, 0.7]).replace(right_wall=hc.Wall())
    peak, *maxima = hc.gradients(chain, ["wall_force.peak", "wall_force.maxima"])
    assert maxima[0].value == peak.value
    assert maxima[0]["radii"] == pytest.approx(peak["radii"], abs=0.0)
    assert all(0.5 * peak.value <= each.value <= peak.value for each in maxima)


def test_quantities_that_do_not_exist_are_nan_with_a_reason():
    chain = hc.Chain.uniform(10).replace(right_wall=hc.Wall())
    with pytest.warns(IncompleteWarning, match="has no maximum before the end"):
        found = hc.gradient(chain, "wall_force.peak", until=3.0)
    assert math.isnan(found.value)
    assert np.isnan(found["radii"]).all()
    with pytest.warns(IncompleteWarning, match="not complete"):
        found = hc.gradient(chain, "wall_force.peak", until=12.6)
    assert found.status == "the peak is not complete"
    with pytest.warns(IncompleteWarning, match="impact on the wall has not ended"):
        peak, *others = hc.gradients(
            chain, ["wall_force." + name for name in ("peak", "duration", "impulse_of_impact")],
            until=13.5,
        )  # fmt: skip
    assert peak.status == "complete"
    assert all(each.status == "the impact on the wall has not ended" for each in others)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert hc.gradient(chain, "wall_force.peak").status == "complete"


# An overlap at yield that no contact reaches: an elastic chain without exact derivatives.
DENTED = hc.Chain.tapered("forward-exponential", 0.05, beads=5).replace(
    right_wall=hc.Wall(), loss=hc.ElasticPlastic(yield_overlap=10.0)
)


@pytest.mark.parametrize("quantity", ["wall_force.peak", "velocity@4", "arrival@last",
                                      "sensor.first_maximum@3", "wall_force.impulse"])  # fmt: skip
@pytest.mark.parametrize("to", ["radii", "masses", "stiffness"])
def test_differences_are_the_exact_derivatives_of_the_same_motion(quantity, to):
    found = hc.gradient(DENTED, quantity, to=to, until=12.0)
    exact = hc.gradient(DENTED.replace(loss=None), quantity, to=to, until=12.0)
    largest = np.abs(exact[to]).max()
    assert found.value == pytest.approx(exact.value, rel=1e-5)
    assert found.method == "central differences"
    assert exact.method == "adjoint"
    assert found.error < 3e-3
    error = np.abs(found[to] - exact[to]).max() / largest
    assert error < found.error + exact.error + 1e-6


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
def test_differences_of_balls_that_yield_have_the_powers_of_dimensional_analysis():
    """F = E R^2 f(rho v^2/E, Y/E) in closed form; by the yield strength of 52100 steel."""
    radii = np.linspace(10e-3, 4e-3, 6)
    chain = hc.Chain.from_materials(
        radii, "steel-52100", velocity=1.0, right_wall=hc.Wall(), loss=hc.ElasticPlastic()
    )
    steps = []
    to = ("radii", "velocities", "density")
    found = hc.gradient(
        chain, "wall_force.peak", to=to, progress=lambda *done: steps.append(done)
    )  # fmt: skip
    by_radii, by_velocity, by_density = (found.relative(name).sum() for name in to)
    assert by_radii == pytest.approx(2.0, abs=2e-5)
    assert by_velocity == pytest.approx(2.0 * by_density, abs=2e-5)
    # Elastic contacts have the power 1.2.
    assert by_velocity < 0.9
    assert np.isnan(found["velocities"][1:]).all()
    assert steps[-1] == (6 * (6 + 1 + 6), 6 * (6 + 1 + 6))
    assert "by central differences; complete" in " ".join(repr(found).split())
    pickle.loads(pickle.dumps(found))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"quantity": "wall_peak"}, "'wall_peak' .did you mean 'wall_force.peak'..:"),
        ({"quantity": "left_wall_force.peak"}, "the left end of this chain is free"),
        ({"quantity": "pulse.velocity"}, "belongs to a bead"),
        ({"quantity": "pulse.velocity@9"}, "whole number from 1 to 5, got 9"),
        ({"quantity": "energy.kinetic"}, "depends on the end of the run; give until"),
        ({"to": ()}, "to must have at least one parameter"),
        ({"to": "radius"}, "unknown parameter 'radius'"),
        ({"to": "young"}, "young is a parameter of materials, which this chain"),
        ({"to": "left_wall.gap"}, "it has no left_wall"),
        ({"to": "gravity"}, "give a small gravity"),
        ({"until": -1.0}, "until must be above 0"),
        ({"rtol": 1.0}, "rtol must be at least 1e-14 and at most 1e-05, got 1"),
        ({"quantity": ["wall_force.peak"]}, "use gradients for several"),
        ({"chain": None}, "gradient requires a Chain"),
        ({"chain": DENTED, "to": "gaps"}, "gaps has exact derivatives only"),
        ({"chain": DENTED, "quantity": "energy.kinetic", "until": 9.0},
         "energy.kinetic has exact derivatives only"),
        ({"progress": 3}, "progress must be a function"),
        ({"to": "loss.time"}, "the chain has no loss.time, because no law of its contacts has it"),
        (
            {"chain": hc.Chain.uniform(3).replace(loss=hc.Dashpot(0.0)), "to": "loss.gamma",
             "quantity": "pulse.velocity@3"},
            "nearly 0, such as 1e-06",
        ),
        (
            {"chain": hc.Chain.uniform(3).replace(loss=hc.Restitution(1.0)),
             "to": "loss.coefficient", "quantity": "pulse.velocity@3"},
            "nearly 1, such as 0.999",
        ),
        (
            {"chain": hc.Chain.uniform(3).replace(drive=hc.StepDrive(1.0))},
            "does not support a drive",
        ),
    ],
)  # fmt: skip
def test_invalid_input_is_rejected_in_one_sentence(arguments, message):
    given = {
        "chain": hc.Chain.uniform(5).replace(right_wall=hc.Wall()), "quantity": "wall_force.peak",
    } | arguments  # fmt: skip
    with pytest.raises(InputError, match=message):
        hc.gradient(given.pop("chain"), given.pop("quantity"), **given)


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
def test_relative_derivatives_of_a_homogeneous_chain_are_powers():
    """Closed form: the force of Hertz's law scales as v^(6/5) E^(2/5) rho^(3/5) R^2."""
    chain = hc.Chain.from_materials(
        [3e-3, 2e-3, 2.5e-3, 1e-3], "steel-304", velocity=0.1, right_wall=hc.Wall()
    )
    names = ("velocities", "young", "density", "radii")
    found = hc.gradient(chain, "wall_force.peak", to=names)
    sums = [found.relative(name).sum() for name in names]
    assert sums == pytest.approx([1.2, 0.4, 0.6, 2.0], abs=2e-5)
    assert found.units == {
        "velocities": "N/(m/s)", "young": "N/Pa", "density": "N/(kg/m^3)", "radii": "N/m",
    }  # fmt: skip
    assert "N: derivatives by velocities [N/(m/s)], young [N/Pa]" in " ".join(repr(found).split())
    with pytest.raises(hc.InputError, match=r"such as gradient\['velocities'\], got 0; its value"):
        found[0]
    assert found._ipython_key_completions_() == [*names]
    with pytest.raises(hc.InputError, match="unknown parameter of this gradient 'gaps'"):
        found.relative("gaps")


def test_the_bead_that_matters_most_depends_on_the_choice_of_derivative():
    chain = hc.Chain.tapered("forward-exponential", 0.05, beads=20).replace(right_wall=hc.Wall())
    found = hc.gradient(chain, "wall_force.peak")
    assert np.abs(found["radii"]).argmax() == 19
    assert np.abs(found.relative()).argmax() == 0
    # The last radius 1% larger and smaller, by another method of integration.
    forces = []
    for factor in (0.99, 1.01):
        radii = chain.radii.copy()
        radii[19] *= factor
        run = hc.simulate(chain.replace(radii=radii), times=0, rtol=1e-11)
        forces.append(run.wall_force().peak)
    change = np.log(forces[1] / forces[0]) / np.log(1.01 / 0.99)
    assert found.relative()[19] == pytest.approx(change, rel=1e-3)


def random_chains(count):
    """Tapers and chains of random radii, most of which a window can follow."""
    rng = np.random.default_rng(3)
    for _ in range(count):
        beads = int(rng.integers(8, 24))
        yield hc.Chain.from_radii(np.exp(rng.normal(0.0, rng.choice([0.01, 0.05, 0.2]), beads)))
        rate = rng.uniform(0.01, 0.08)
        yield hc.Chain.tapered(f"{rng.choice(['backward', 'forward'])}-exponential", rate,
                               beads=beads)  # fmt: skip


def differences_by_radii(chain, step):
    """Derivatives of all velocities by all radii, by simulations at a tight tolerance."""
    change = np.eye(chain.beads) * step
    radii = np.concatenate([chain.radii + change, chain.radii - change])
    chains = [chain.replace(radii=each) for each in radii]
    speeds = hc.simulate_many(chains, keep="velocity", rtol=1e-13)["velocity"]
    return np.subtract(*np.split(speeds, 2)) / (2.0 * step)


@pytest.mark.long
@pytest.mark.parametrize("rtol", [None, 1e-7])
def test_errors_are_realistic_also_for_the_last_bead(rtol):
    """Reference: central differences of simulations by another method and at a tight tolerance."""
    ratios = {"inner": [], "last": []}
    for chain in random_chains(8):
        coarse, fine = (differences_by_radii(chain, step) for step in (2e-5, 1e-5))
        for which, bead in (("inner", chain.beads // 2 + 1), ("last", chain.beads)):
            found = hc.gradient(chain, f"pulse.velocity@{bead}", rtol=rtol)
            reference, largest = fine[:, bead - 1], np.abs(fine[:, bead - 1]).max()
            error = np.abs(found["radii"] - reference).max() / largest
            uncertain = np.abs(coarse[:, bead - 1] - reference).max() / largest
            assert error < found.error + 2.0 * uncertain + 1e-7, (chain, bead)
            if error > 5.0 * (uncertain + 1e-7):
                ratios[which].append(found.error / error)
            assert found.error < (1e-3 if rtol is None else 1e-2)
    assert len(ratios["last"]) > 5
    assert all(np.median(each) < 30.0 for each in ratios.values() if each), ratios


def test_errors_need_no_second_run_until_they_are_read(recorded):
    found = hc.gradients(hc.Chain.uniform(10), ["pulse.velocity@5", "pulse.velocity@6"])
    runs = len(recorded["slopes"])
    assert [each.error for each in found] == [each.error for each in found]
    assert len(recorded["slopes"]) == 2 * runs
    copies = [copy.copy(found[0]), pickle.loads(pickle.dumps(found[0]))]
    assert [each.error for each in copies] == [found[0].error] * 2
    failing = hc.gradient(hc.Chain.uniform(10), "pulse.velocity@5", rtol=1e-14)
    assert 0.0 < failing.error < 1e-4


def test_a_record_that_would_not_fit_in_memory_is_rejected(monkeypatch):
    # As on a machine with 300 MB of free memory; a chain of 200 beads needs 16 kB per step.
    monkeypatch.setattr("psutil.virtual_memory", lambda: SimpleNamespace(available=3e8))
    chain = hc.Chain.uniform(200).replace(left_wall=hc.Wall(), right_wall=hc.Wall())
    with pytest.raises(hc.InputError, match=r"GiB of memory, but 0\.3 GiB are free; use a larger"):
        hc.gradient(chain, "velocity@5", until=1e4)


def test_the_constant_of_a_dashpot_has_a_unit():
    chain = hc.Chain.from_materials("5 mm", "steel-52100", beads=4, velocity=0.1)
    found = hc.gradient(
        chain.replace(right_wall=hc.Wall(), loss=hc.Dashpot(0.5)), "velocity@3", to=["loss.gamma"]
    )
    assert found.units["loss.gamma"] == "(m/s)/(kg/s)"
