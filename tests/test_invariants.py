"""Transformations that must not change the motion of random chains with all features.

Each check compares two runs that are physically the same, or whose difference is bounded.
Deviations are relative to the rough sizes of velocity and force in a chain (`Units`).
"""

import dataclasses

import numpy as np
import pytest
from random_chains import LAWS, at_rest, force_difference
from scipy_chain import Units

import hertzchain as hc
from hertzchain.simulation.state import fingerprint

# Rounding, amplified by the collisions of a run; measured on 300 chains of each check: 2e-8.
SAME = 1e-7
pytestmark = [
    pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning"),
    # Of gaps that nothing crosses, and of the gravity of impacts at high speed.
    pytest.mark.filterwarnings("ignore:.*gap .* but the beads are only:hertzchain.InputWarning"),
    pytest.mark.filterwarnings("ignore:the gravity is:hertzchain.InputWarning"),
]
ZERO_LOSSES = [
    hc.Restitution(1.0),
    hc.Restitution(1.0, attractive=False),
    hc.Viscoelastic(0.0),
    hc.Viscoelastic(0.0, attractive=True),
    hc.UnloadingRatio(0.0),
    hc.VelocityPower(0.0, 1.5),
    hc.Dashpot(0.0),
    hc.Dashpot(0.0, attractive=False),
    hc.WaltonBraun(1.0),
]


def times_of(case):
    return np.linspace(0.0, case.until, 21)


def run_of(case, chain=None, **options):
    return hc.simulate(
        case.chain if chain is None else chain, **{"times": times_of(case)} | options
    )


def difference(velocities, others, units):
    return np.abs(velocities - others).max() / units.velocity


def largest_difference(run, other, units):
    """Largest difference of velocities and of forces."""
    return max(
        difference(run.velocities, other.velocities, units),
        force_difference(run, other.forces, units),
    )


def test_a_uniform_motion_changes_nothing(try_chains):
    def deviation(case):
        shift = 0.37 * case.units.velocity
        run = run_of(case)
        other = run_of(case, case.chain.replace(velocities=case.chain.velocities + shift))
        return max(
            difference(run.velocities, other.velocities - shift, case.units),
            force_difference(run, other.forces, case.units),
        )

    try_chains(deviation, SAME, without=("walls",))


def mirrored(chain):
    """The mirror image of a chain; scaled, with all numbers given."""
    fields = {
        item.name: getattr(chain, item.name)
        for item in dataclasses.fields(chain)
        if item.init and item.name not in ("taper", "rate", "masses", "stiffness")
    }
    fields |= {
        "radii": chain.radii[::-1], "velocities": -chain.velocities[::-1],
        "gaps": chain.gaps[::-1], "gravity": -chain.gravity,
        "left_wall": chain.right_wall, "right_wall": chain.left_wall,
    }  # fmt: skip
    if chain.units == "SI":
        return hc.Chain(**fields | {"materials": chain.materials[::-1]})
    walls = zip(("right_wall", "left_wall"), chain.wall_stiffness, strict=True)
    for end, (side, k) in zip((chain.left_wall, chain.right_wall), walls, strict=True):
        fields[side] = end and hc.Wall(stiffness=k, gap=end.gap)
    fields |= {"radii": fields["radii"] / chain.radii[-1]}
    return hc.Chain(**fields, masses=chain.masses[::-1], stiffness=chain.stiffness[::-1])


def test_a_mirrored_chain_moves_as_the_mirror_shows(try_chains):
    def deviation(case):
        run, other = run_of(case), run_of(case, mirrored(case.chain))
        return max(
            difference(run.velocities, -other.velocities[:, ::-1], case.units),
            force_difference(run, other.forces[:, ::-1], case.units),
        )

    try_chains(deviation, SAME, without=("drive", "strikers"))


def test_a_run_in_scaled_units_is_the_run_in_si_units(try_chains):
    def deviation(case):
        scales = hc.Scales.of(case.chain, velocity=case.units.velocity)
        scaled = scales.to_scaled(case.chain)
        other = hc.simulate(scaled, times=times_of(case) / scales.time)
        back = run_of(case, scales.to_si(scaled))
        run = run_of(case)
        return max(
            largest_difference(run, scales.to_si(other), case.units),
            largest_difference(run, back, case.units),
        )

    try_chains(deviation, SAME, only=("SI",))


def rescaled(chain, mass, length, time):
    """The same chain measured in other units, by the dimension of each of its numbers."""
    force, velocity = mass * length / time**2, length / time
    k = force / length**chain.exponent
    changes = {
        "masses": chain.masses * mass, "stiffness": chain.stiffness * k,
        "velocities": chain.velocities * velocity, "gaps": chain.gaps * length,
        "precompression": chain.precompression * force, "gravity": chain.gravity * length / time**2,
    }  # fmt: skip
    for side, own in zip(("left_wall", "right_wall"), chain.wall_stiffness, strict=True):
        wall = getattr(chain, side)
        changes[side] = wall and hc.Wall(stiffness=own * k, gap=wall.gap * length)
    if chain.drive is not None:
        size = force if chain.drive.of == "force" else length
        dimensions = {"amplitude": size, "values": size, "frequency": 1.0 / time, "rise": time,
                      "times": time}  # fmt: skip
        changes["drive"] = _multiplied(chain.drive, dimensions)
    if chain.loss is not None:
        alpha = getattr(chain.loss, "alpha", 1.0)
        changes["loss"] = _multiplied(chain.loss, {"time": time, "gamma": force / velocity**alpha})
    return chain.replace(**changes)


def _multiplied(part, factors):
    names = {item.name for item in dataclasses.fields(part)} & set(factors)
    return dataclasses.replace(
        part, **{name: getattr(part, name) * factors[name] for name in names}
    )


def test_units_of_mass_length_and_time_are_free(try_chains):
    def deviation(case):
        factors = np.random.default_rng(case.seed).uniform(0.02, 50.0, 3)
        other = hc.simulate(rescaled(case.chain, *factors), times=times_of(case) * factors[2])
        run, units = run_of(case), Units(*(factors[[1, 2, 0]] * case.units))
        velocities = other.velocities * (case.units.velocity / units.velocity)
        forces = other.forces * (case.units.force / units.force)
        return max(
            difference(run.velocities, velocities, case.units),
            force_difference(run, forces, case.units),
        )

    try_chains(deviation, SAME)


@pytest.mark.long
@pytest.mark.parametrize("law", ZERO_LOSSES, ids=repr)
def test_a_law_that_loses_nothing_changes_nothing(try_chains, law):
    def deviation(case):
        return largest_difference(
            run_of(case), run_of(case, case.chain.replace(loss=law)), case.units
        )

    try_chains(deviation, SAME, fewer=4, without=("loss",))


def weak(law, part, units):
    """A law with a small part of the loss of a strong one."""
    return {
        "Restitution": lambda: hc.Restitution(1.0 - part),
        "Viscoelastic": lambda: hc.Viscoelastic(part * units.time),
        "UnloadingRatio": lambda: hc.UnloadingRatio(part),
        "VelocityPower": lambda: hc.VelocityPower(part * units.force / units.velocity**1.5, 1.5),
        "Dashpot": lambda: hc.Dashpot(part * units.force / units.velocity),
        "WaltonBraun": lambda: hc.WaltonBraun(1.0 - part),
    }[law]()


@pytest.mark.parametrize("name", LAWS)
def test_a_little_loss_changes_little(try_chains, name):
    """In proportion to it."""

    def deviation(case):
        elastic = run_of(case)
        changes = [
            difference(
                run_of(case, case.chain.replace(loss=weak(name, part, case.units))).velocities,
                elastic.velocities,
                case.units,
            )
            for part in (1e-5, 1e-6)
        ]
        return max(changes[0] / 1e-5, changes[1] / 1e-6)

    # Measured: 4.7e3, in a chain that is driven for long.
    try_chains(deviation, 4e4, fewer=4, without=("loss",))


def test_saving_more_often_changes_no_bit(try_chains):
    def deviation(case):
        run = run_of(case)
        other = hc.simulate(case.chain, times=[case.until])
        np.testing.assert_array_equal(run.velocities[-1], other.velocities[-1])
        np.testing.assert_array_equal(run.forces[-1], other.forces[-1])
        return 0.0

    try_chains(deviation, 0.0)


def test_a_run_resumes_from_a_saved_state_bit_for_bit(try_chains, tmp_path):
    def deviation(case):
        times, path = times_of(case), tmp_path / "state.npz"
        first = hc.simulate(case.chain, until=0.43 * case.until, times=0)
        hc.save_state(first.state, path)
        state = hc.load_state(path, case.chain)
        later = times[times > state.time]
        second, whole = hc.simulate(case.chain, start=state, times=later), run_of(case)
        for name in ("positions", "velocities", "forces"):
            ours = getattr(second, name)
            np.testing.assert_array_equal(ours, getattr(whole, name)[-len(later) :], name)
        assert second.steps == whole.steps
        return 0.0

    try_chains(deviation, 0.0)


def test_a_chain_from_its_file_is_the_same_to_the_last_bit(try_chains, tmp_path):
    def deviation(case):
        path = tmp_path / "chain.toml"
        path.write_text(hc.chain_as_toml(case.chain), encoding="utf-8")
        read = hc.load_chain(path)
        assert fingerprint(read) == fingerprint(case.chain)
        assert read.features == case.chain.features
        np.testing.assert_array_equal(run_of(case, read).velocities, run_of(case).velocities)
        return 0.0

    try_chains(deviation, 0.0)


def test_names_and_order_of_materials_play_no_part(try_chains, tmp_path):
    def deviation(case):
        rng = np.random.default_rng(case.seed)
        known = sorted({each.name for each in case.chain.materials})
        names = dict(zip(known, rng.permutation(["z", "y", "x"]), strict=False))
        renamed = tuple(
            dataclasses.replace(each, name=str(names[each.name])) for each in case.chain.materials
        )
        other = case.chain.replace(materials=renamed)
        path = tmp_path / "chain.toml"
        path.write_text(hc.chain_as_toml(other), encoding="utf-8")
        for chain in (other, hc.load_chain(path)):
            np.testing.assert_array_equal(run_of(case).velocities, run_of(case, chain).velocities)
        return 0.0

    try_chains(deviation, 0.0, only=("SI",))


def test_strikers_together_are_strikers_one_after_another(try_chains):
    def deviation(case):
        units = case.units
        striker = {"velocity": 0.8 * units.velocity, "mass": 1.7 * units.mass}
        if case.chain.exponent != 1.5 or "stiffness" in case.chain.given:
            striker["stiffness"] = 1.3 * units.stiffness(case.chain.exponent)
        chain = at_rest(case.chain)
        together = chain.struck_by(count=3, gap=0.2 * units.length, **striker)
        chain = chain.struck_by(gap=0.2 * units.length, **striker)
        for _ in range(2):
            chain = chain.struck_by(**striker)
        assert chain.strikers == together.strikers
        return largest_difference(run_of(case, together), run_of(case, chain), units)

    try_chains(deviation, SAME, without=("walls", "strikers"))


def test_chains_far_apart_do_not_feel_each_other(try_chains):
    """Two chains in a row with a gap that nothing crosses."""

    def deviation(case):
        chain, units = case.chain, case.units
        # The same chain once more in front: without the drive, and with other velocities.
        rng = np.random.default_rng(case.seed)
        ahead = chain.replace(
            drive=None, left_wall=None,
            velocities=rng.uniform(-0.5, 0.9, chain.beads) * units.velocity,
        )  # fmt: skip
        behind = chain.replace(right_wall=None)
        far = 1e5 * units.length
        both = behind.replace(
            radii=np.concatenate((chain.radii, chain.radii)),
            masses=np.concatenate((chain.masses, chain.masses)),
            stiffness=np.concatenate((chain.stiffness, [chain.stiffness[0]], chain.stiffness)),
            materials=chain.materials and chain.materials * 2,
            velocities=np.concatenate((behind.velocities, ahead.velocities)),
            gaps=np.concatenate((chain.gaps, [far], chain.gaps)),
            left_wall=_explicit(chain, 0),
            right_wall=_explicit(chain, 1),
        )
        ours = run_of(case, both).velocities
        return max(
            difference(ours[:, : chain.beads], run_of(case, behind).velocities, units),
            difference(ours[:, chain.beads :], run_of(case, ahead).velocities, units),
        )

    try_chains(deviation, SAME, without=("precompression", "gravity", "strikers"))


def _explicit(chain, side):
    """A wall of the chain with its stiffness given."""
    wall = (chain.left_wall, chain.right_wall)[side]
    return wall and hc.Wall(stiffness=chain.wall_stiffness[side], gap=wall.gap)


def test_numbers_that_follow_may_as_well_be_given(try_chains):
    def deviation(case):
        chain = case.chain
        given = chain.replace(
            masses=chain.masses, stiffness=chain.stiffness,
            left_wall=_explicit(chain, 0), right_wall=_explicit(chain, 1),
        )  # fmt: skip
        np.testing.assert_array_equal(run_of(case).velocities, run_of(case, given).velocities)
        return 0.0

    try_chains(deviation, 0.0)


def test_a_wall_is_a_bead_too_heavy_to_move(try_chains):
    def deviation(case):
        chain, units = case.chain, case.units
        if chain.right_wall is None:
            chain = chain.replace(right_wall=hc.Wall(stiffness=units.stiffness(chain.exponent)))
        heavy = chain.replace(
            radii=np.append(chain.radii, chain.radii[-1]),
            masses=np.append(chain.masses, 1e12 * units.mass),
            stiffness=chain.contact_stiffness[1:],
            materials=chain.materials and chain.materials + chain.materials[-1:],
            velocities=np.append(chain.velocities, 0.0),
            gaps=np.append(chain.gaps, chain.right_wall.gap),
            left_wall=_explicit(chain, 0), right_wall=None,
        )  # fmt: skip
        return difference(
            run_of(case, chain).velocities, run_of(case, heavy).velocities[:, :-1], units
        )

    try_chains(deviation, SAME, without=("precompression", "gravity"))


def test_a_drive_that_comes_later_does_the_same_later(try_chains):
    """On a chain at rest and without weight."""

    def deviation(case):
        chain, units = case.chain, case.units
        rng = np.random.default_rng(case.seed)
        times = np.concatenate(([0.0], np.cumsum(rng.uniform(0.3, 3.0, 4)))) * units.time
        of = "force" if chain.left_wall is None else str(rng.choice(["force", "displacement"]))
        size = 0.6 * units.force if of == "force" else units.length
        values = size * np.append(0.0, rng.uniform(-1.0, 1.0, 4))
        delay = rng.uniform(0.5, 3.0) * units.time
        # Forces may jump where the drive begins.
        saved = times_of(case)[1:]
        chain = chain.replace(velocities=np.zeros(chain.beads))
        now = chain.replace(drive=hc.TableDrive(times, values, of))
        then = chain.replace(drive=hc.TableDrive(times + delay, values, of))
        later = hc.simulate(then, times=saved + delay)
        return largest_difference(hc.simulate(now, times=saved), later, units)

    try_chains(deviation, SAME, without=("gravity", "strikers", "drive"))


def test_a_lossless_chain_runs_back(try_chains):
    def deviation(case):
        state = hc.simulate(case.chain, until=0.5 * case.until, times=0).state
        back = hc.simulate(case.chain, start=state.reversed(), times=[state.time])
        return difference(-back.velocities[0], case.chain.velocities, case.units)

    try_chains(deviation, SAME, without=("loss", "drive"))


def test_a_power_of_one_is_a_dashpot(try_chains):
    def deviation(case):
        chain, gamma = case.chain, 0.1 * case.units.force / case.units.velocity
        pulls = case.seed % 2 == 0
        one = run_of(case, chain.replace(loss=hc.Dashpot(gamma, pulls)))
        other = run_of(case, chain.replace(loss=hc.VelocityPower(gamma, 1.0, pulls)))
        return largest_difference(one, other, case.units)

    try_chains(deviation, SAME)


def test_hertz_is_one_exponent_among_others(try_chains):
    """3/2 has separate loops."""

    def deviation(case):
        chain = case.chain.replace(
            masses=case.chain.masses, stiffness=case.chain.stiffness, exponent=1.5,
            left_wall=_explicit(case.chain, 0), right_wall=_explicit(case.chain, 1),
        )  # fmt: skip
        near = chain.replace(exponent=1.5 + 1e-12)
        return difference(run_of(case, chain).velocities, run_of(case, near).velocities, case.units)

    try_chains(deviation, SAME, without=("SI",))


def test_gaps_that_vanish_are_none(try_chains):
    def deviation(case):
        chain, units = case.chain.replace(gaps=None), case.units
        touching = run_of(case, chain).velocities
        changes = [
            difference(run_of(case, chain.replace(gaps=part * units.length)).velocities, touching,
                       units)
            for part in (1e-5, 1e-7)
        ]  # fmt: skip
        return max(changes[0] / 1e-5, changes[1] / 1e-7)

    # Measured: 1e2.
    try_chains(deviation, 1e3, without=("precompression", "gravity"))


def test_precompression_that_vanishes_is_none(try_chains):
    r"""The change vanishes with the static overlap :math:`(F/k)^{1/p}`."""

    def deviation(case):
        chain, units = case.chain, case.units
        free = run_of(case, chain.replace(precompression=0.0)).velocities
        changes = []
        for part in (1e-8, 1e-11):
            held = chain.replace(precompression=part * units.force)
            overlap = part ** (1.0 / chain.exponent)
            changes.append(difference(run_of(case, held).velocities, free, units) / overlap)
        return max(changes)

    # Measured: 1.3e3.
    try_chains(deviation, 1e4, only=("precompression",), without=("gravity",))


@pytest.mark.long
def test_runs_converge_with_their_tolerance(try_chains):
    def deviation(case):
        best = run_of(case)
        return max(
            difference(run_of(case, rtol=rtol).velocities, best.velocities, case.units) / rtol
            for rtol in (1e-7, 1e-9, 1e-11)
        )

    # Measured: 2e3.
    try_chains(deviation, 1e4)


def test_energy_and_momentum_balance(try_chains):
    def deviation(case):
        budget = run_of(case).budget()
        return max(np.abs(budget.residual(of)).max() for of in ("energy", "momentum"))

    # Measured: 4e-11.
    try_chains(deviation, 4e-10)
