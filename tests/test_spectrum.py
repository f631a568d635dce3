"""Spectra against closed forms, matrices assembled here, and ringing simulated by `simulate`."""

import json

import numpy as np
import pytest
from click.testing import CliRunner
from figure_texts import legend_texts
from scipy.linalg import eig, expm

import hertzchain as hc
from hertzchain.cli import cli
from hertzchain.theory.dispersion import band_edges, dispersion_diatomic, dispersion_uniform
from hertzchain.theory.linear_contacts import linear_contacts

WALL = hc.Wall(stiffness=1.7)


def random_chain(seed, beads=6, *, exponent=1.5, loss=None, **ends):
    """Unlike beads and contacts under a static force, with or without walls and gravity."""
    rng = np.random.default_rng(seed)
    ends = ends or {"held_by": "force"}
    return hc.Chain.uniform(beads, exponent=exponent).replace(
        masses=rng.uniform(0.3, 3.0, beads), stiffness=rng.uniform(0.3, 3.0, beads - 1),
        precompression=0.8, loss=loss, **ends
    )  # fmt: skip


BETWEEN_WALLS = {"left_wall": WALL, "right_wall": hc.Wall(stiffness=0.6)}
ON_A_WALL = {"held_by": "force", "right_wall": WALL, "gravity": 0.2}


def force(loss, p, k, mu, d, rate):
    """Contact force as its docstring gives it."""
    elastic = k * d**p
    if isinstance(loss, hc.Restitution):
        return elastic + loss.damping(p) * np.sqrt(mu * k) * d ** ((p - 1) / 2) * rate
    if isinstance(loss, hc.Viscoelastic):
        return elastic + k * p * loss.time * d ** (p - 1) * rate
    if isinstance(loss, hc.Dashpot | hc.VelocityPower):
        return elastic + loss.gamma * rate
    return elastic


def matrices(chain):
    """M, C and K by differences of the forces of contacts about their static overlaps."""
    n, p, forces = chain.beads, chain.exponent, hc.equilibrium(chain).forces
    m = chain.masses
    mass, damping, spring = np.diag(m), np.zeros((n, n)), np.zeros((n, n))
    for c, k in enumerate(chain.contact_stiffness):
        if k == 0.0:
            continue
        ends = [b for b in (c - 1, c) if 0 <= b < n]
        mu = m[ends[0]] if len(ends) == 1 else m[c - 1] * m[c] / (m[c - 1] + m[c])
        d0, h = (forces[c] / k) ** (1 / p), 1e-5
        slopes = [
            (force(chain.loss, p, k, mu, d0 + h, 0) - force(chain.loss, p, k, mu, d0 - h, 0)),
            (force(chain.loss, p, k, mu, d0, h) - force(chain.loss, p, k, mu, d0, -h)),
        ]
        pattern = np.array([[1.0, -1.0], [-1.0, 1.0]])[:, 2 - len(ends) :][2 - len(ends) :]
        for matrix, slope in zip((spring, damping), slopes, strict=True):
            matrix[np.ix_(ends, ends)] += slope / (2 * h) * pattern
    return mass, damping, spring


LOSSES = [
    None, hc.Viscoelastic(0.2), hc.Dashpot(0.3), hc.VelocityPower(0.3, alpha=1.0),
    hc.Restitution(0.6), hc.Dashpot(4.0),
]  # fmt: skip


@pytest.mark.parametrize("ends", [{}, BETWEEN_WALLS, ON_A_WALL], ids=["free", "walls", "standing"])
@pytest.mark.parametrize("loss", LOSSES, ids=str)
@pytest.mark.parametrize("exponent", [1.5, 2.5])
def test_eigenvalues_solve_the_quadratic_problem(exponent, loss, ends):
    chain = random_chain(3, exponent=exponent, loss=loss, **ends)
    mass, damping, spring = matrices(chain)
    found = hc.spectrum(chain)
    zero, one = np.zeros_like(mass), np.eye(chain.beads)
    expected = eig(np.block([[zero, one], [-spring, -damping]]),
                   np.block([[one, zero], [zero, mass]]), right=False)  # fmt: skip
    # A chain that moves as a whole has the eigenvalue 0 twice, and is listed once.
    rigid = int(not ends)
    paired = found.eigenvalues[found.eigenvalues.imag > 0]
    alone = found.eigenvalues[found.eigenvalues.imag == 0]
    both = np.concatenate([paired, paired.conj(), alone, np.zeros(rigid)])
    assert len(both) == 2 * chain.beads
    for value in expected:
        nearest = np.abs(both - value).min()
        assert nearest < (1e-3 if rigid and abs(value) < 1e-3 else 1e-7)
    for value, shape in zip(found.eigenvalues, found.modes.T, strict=True):
        residual = (value**2 * mass + value * damping + spring) @ shape
        assert np.abs(residual).max() < 1e-7 * (1 + abs(value) ** 2)
        assert np.sum(chain.masses * np.abs(shape) ** 2) == pytest.approx(1.0, rel=1e-12)
    assert (np.diff(found.frequencies) >= 0).all()
    if loss is None:
        assert not found.decay_rates.any()
        assert found.modes.dtype == float


@pytest.mark.parametrize("ends", [{}, BETWEEN_WALLS, ON_A_WALL], ids=["free", "walls", "standing"])
@pytest.mark.parametrize("loss", [None, hc.Viscoelastic(0.2), hc.Dashpot(0.3)], ids=str)
def test_transfer_inverts_the_dynamic_stiffness(loss, ends):
    chain = random_chain(5, loss=loss, **ends)
    mass, damping, spring = matrices(chain)
    found, n = hc.spectrum(chain), chain.beads
    left, right = (chain.wall_stiffness[i] for i in (0, 1))
    for f in (0.01, 0.11, 0.3, 0.7):
        w = 2 * np.pi * f
        green = np.linalg.inv(spring - w**2 * mass + 1j * w * damping)
        for k in (1, 3, n):
            for j in (1, 4, n):
                assert found.transfer(f, k, at=j) == pytest.approx(green[k - 1, j - 1], rel=1e-7)
                ratio = green[k - 1, j - 1] / green[j - 1, j - 1]
                moved = found.transfer(f, k, drive="displacement", at=j)
                assert moved == pytest.approx(ratio, rel=1e-7)
            for side, stiffness, end in (("left", left, 0), ("right", right, n - 1)):
                if stiffness == 0.0:
                    continue
                contacts = found.contacts
                link = contacts.springs[end and -1] + 1j * w * contacts.dampers[end and -1]
                moved = found.transfer(f, k, drive="displacement", at=f"{side} wall")
                assert moved == pytest.approx(green[k - 1, end] * link, rel=1e-7)
        # Forces are those of the links between the beads that move.
        x = np.array([0.0, *(found.transfer(f, k, at=4) for k in range(1, n + 1)), 0.0])
        links = found.contacts.springs + 1j * w * found.contacts.dampers
        joined = np.flatnonzero(links)
        forces = [found.transfer_force(f, c, at=4) for c in joined]
        expected = (-links * np.diff(x))[joined]
        np.testing.assert_allclose(forces, expected, rtol=1e-10, atol=1e-13)
        for free in {0, n} - {*joined.tolist()}:
            with pytest.raises(hc.InputError, match=f"contact {free} carries no force, because no"):
                found.transfer_force(f, free)


def test_slow_drives_keep_their_digits():
    free = hc.spectrum(random_chain(1))
    masses = free.contacts.masses
    f = 1e-9
    # As a whole, by Newton's law; each contact pushes what lies ahead of it.
    expected = -1.0 / (masses.sum() * (2 * np.pi * f) ** 2)
    assert free.transfer(f, 6) == pytest.approx(expected, rel=1e-12)
    share = masses[3:].sum() / masses.sum()
    assert free.transfer_force(f, 3) == pytest.approx(share, rel=1e-12)
    assert free.transfer(0.0, 6, drive="displacement") == 1.0
    held = hc.spectrum(random_chain(1, **BETWEEN_WALLS))
    compliance = 1.0 / held.contacts.springs
    # Two parallel stacks of springs carry a static force on bead 3.
    stacks = 1.0 / compliance[:3].sum() + 1.0 / compliance[3:].sum()
    assert held.transfer(0.0, 3, at=3) == pytest.approx(1.0 / stacks, rel=1e-13)


def test_resonance_without_loss_is_infinite():
    wall = hc.Wall(stiffness=(2.0 * np.pi) ** 2 / 1.5)
    masses, stiffness = [1.0, 1.0], [(2.0 * np.pi) ** 2 / 1.5]
    chain = hc.Chain.uniform(2).replace(
        masses=masses, stiffness=stiffness, precompression=1e-12, left_wall=wall, right_wall=wall
    )
    found = hc.spectrum(chain)
    f = found.frequencies[0]
    assert np.abs(found.transfer([f, 0.9 * f], 1))[0] > 1e10 * abs(found.transfer(0.9 * f, 1))


@pytest.mark.parametrize(
    "loss", [None, hc.Viscoelastic(0.05), hc.Dashpot(0.2), hc.Restitution(0.8)], ids=str
)
def test_simulated_ringing_is_a_sum_of_the_modes(loss):
    chain = random_chain(7, beads=5, loss=loss, **BETWEEN_WALLS)
    found = hc.spectrum(chain)
    kick = 1e-7 * np.array([1.0, -0.5, 0.2, 0.7, -1.0])
    times = np.linspace(0.0, 40.0, 400)
    run = hc.simulate(chain.replace(velocities=kick), until=40.0, times=times)
    waves = np.exp(np.outer(times, found.eigenvalues))
    basis = np.column_stack([waves.real, waves.imag])
    for velocity in run.velocities.T:
        fitted = basis @ np.linalg.lstsq(basis, velocity, rcond=None)[0]
        assert np.abs(fitted - velocity).max() < 1e-5 * np.abs(velocity).max()
    # A frequency that is 0.1 % off is seen.
    waves = np.exp(np.outer(times, found.eigenvalues * np.array([1, 1, 1.001, 1, 1])))
    wrong = np.column_stack([waves.real, waves.imag])
    velocity = run.velocities[:, 0]
    missed = velocity - wrong @ np.linalg.lstsq(wrong, velocity, rcond=None)[0]
    assert np.abs(missed).max() > 1e-4 * np.abs(velocity).max()


def test_motion_from_modes_is_that_of_the_matrix_exponential():
    chain = random_chain(9, loss=hc.Dashpot(0.4), **ON_A_WALL)
    mass, damping, spring = matrices(chain)
    found = hc.spectrum(chain)
    inverse, zero = np.linalg.inv(mass), np.zeros_like(mass)
    system = np.block([[zero, np.eye(6)], [-inverse @ spring, -inverse @ damping]])
    start = np.concatenate([np.zeros(6), np.arange(6.0)])
    values = np.concatenate([found.eigenvalues, found.eigenvalues.conj()])
    shapes = np.concatenate([found.modes, found.modes.conj()], axis=1)
    weights = np.linalg.solve(np.vstack([shapes, shapes * values]), start)
    for t in (0.3, 4.0):
        moved = (shapes * np.exp(values * t)) @ weights
        np.testing.assert_allclose(moved, (expm(system * t) @ start)[:6], atol=1e-8)


@pytest.mark.parametrize(
    ("drive", "at", "wave"),
    [("force", 1, 1e-7), ("displacement", "left wall", 1e-7)],
)
def test_simulated_steady_motion_is_the_transfer_function(drive, at, wave):
    f, periods = 0.23, 60
    chain = random_chain(11, beads=4, loss=hc.Dashpot(0.5), **BETWEEN_WALLS)
    burst = hc.SineBurst(wave, f, cycles=np.inf, of=drive, window="none")
    times = (periods + np.linspace(0.0, 1.0, 41)[:-1]) / f
    run = hc.simulate(
        chain.replace(drive=burst), until=float(times[-1] + 0.1), times=times, rtol=1e-13
    )
    found = hc.spectrum(chain)
    # The drive is a sine: the imaginary part of the exponential.
    measure = 2.0 * np.exp(-2j * np.pi * f * times) * 1j / len(times)
    for bead in (1, 2, 4):
        moved = measure @ (run.positions[:, bead - 1])
        assert moved / wave == pytest.approx(found.transfer(f, bead, drive=drive, at=at), rel=1e-5)
    for contact in (0, 2, 4):
        force = measure @ run.forces[:, contact] / wave
        expected = found.transfer_force(f, contact, drive=drive, at=at)
        # The wall's own motion is not in the beads' positions, but it is in the force.
        assert force == pytest.approx(expected, rel=1e-5)


def test_damped_oscillators_in_closed_form():
    wall = hc.Wall(stiffness=1.0)
    base = hc.Chain.uniform(2).replace(precompression=1.0, left_wall=wall, right_wall=wall)
    in_phase, against = np.sqrt(1.5), np.sqrt(4.5)
    found = hc.spectrum(base.replace(loss=hc.Dashpot(0.2)))
    np.testing.assert_allclose(found.decay_rates, [0.1, 0.3], rtol=1e-12)
    omega = np.sqrt([1.5 - 0.1**2, 4.5 - 0.3**2])
    np.testing.assert_allclose(2 * np.pi * found.frequencies, omega, rtol=1e-12)
    np.testing.assert_allclose(found.damping_ratios, [0.1 / in_phase, 0.3 / against], rtol=1e-12)
    # gamma = 3: the beads against each other creep, in phase they do too.
    creeping = hc.spectrum(base.replace(loss=hc.Dashpot(3.0)))
    assert not creeping.frequencies.any()
    slow_fast = [1.5 - s * np.sqrt(1.5**2 - 1.5) for s in (1, -1)]
    opposite = [4.5 - s * np.sqrt(4.5**2 - 4.5) for s in (1, -1)]
    np.testing.assert_allclose(creeping.decay_rates, np.sort([*slow_fast, *opposite]), rtol=1e-12)
    assert (creeping.damping_ratios == 1.0).all()


def test_light_mass_defect_of_montroll_and_potts():
    # An infinite chain: 1/(eps (2 - eps)) above the squared band edge 4K/m; 61 beads are enough.
    masses = np.ones(61)
    masses[30] = 0.4
    wall = hc.Wall(stiffness=1.0)
    chain = hc.Chain.uniform(61).replace(
        masses=masses, precompression=1.0, left_wall=wall, right_wall=wall
    )
    found = hc.spectrum(chain)
    squared = (2 * np.pi * found.frequencies[-1]) ** 2 / 6.0
    assert squared == pytest.approx(1 / (0.4 * 1.6), rel=1e-13)
    # Next to it amplitudes fall by (2 - eps)/eps - 1 per bead, in turn.
    shape = found.modes[:, -1]
    assert shape[31] / shape[30] == pytest.approx(-0.25, rel=1e-12)


@pytest.mark.parametrize("ends", [{}, {"left_wall": hc.Wall(stiffness=1.0)}], ids=["free", "wall"])
def test_bands_are_the_diatomic_branches(ends):
    chain = hc.Chain.dimer(0.3, beads=20).replace(precompression=2.0, held_by="force", **ends)
    found, spring = hc.spectrum(chain), 1.5 * 2.0 ** (1 / 3)
    q = np.linspace(-np.pi, np.pi, 9)
    branches = dispersion_diatomic(q, other_mass=0.3, spring=spring)
    np.testing.assert_allclose(found.bands(q).T * 2 * np.pi, branches, rtol=1e-12, atol=1e-15)
    edges = band_edges(other_mass=0.3, spring=spring) / (2 * np.pi)
    np.testing.assert_allclose(found.band_edges().ravel(), edges, rtol=1e-13)
    # Two cells as one fold the branches.
    folded = found.band_edges(cell=4)
    assert folded.shape == (4, 2)
    assert folded[-1, 1] == pytest.approx(edges[-1], rel=1e-13)


def test_group_velocities_are_the_slopes_of_the_diatomic_branches():
    mass, spring = 0.3, 1.5 * 2.0 ** (1 / 3)
    chain = hc.Chain.dimer(mass, beads=20).replace(precompression=2.0, held_by="force")
    found, length = hc.spectrum(chain), float(chain.centre_distances[:2].sum())
    q = np.array([-2.5, -0.4, 0.3, 1.0, 2.0, 3.0])
    # Derivatives of omega^2 = K (1 + 1/m) -+ K root(q).
    root = np.sqrt((1.0 + 1.0 / mass) ** 2 - 4.0 * np.sin(0.5 * q) ** 2 / mass)
    slope = spring * np.sin(q) / (mass * root)
    omega = np.array(dispersion_diatomic(q, other_mass=mass, spring=spring))
    expected = length * np.array([slope, -slope]) / (2.0 * omega)
    np.testing.assert_allclose(found.group_velocity(q).T, expected, rtol=1e-11)
    assert found.group_velocity(0.0)[0] == pytest.approx(found.sound_speed, rel=1e-13)
    assert found.group_velocity(1e-4)[0] == pytest.approx(found.sound_speed, rel=1e-7)
    # Two cells as one have half the phase per length, and the same velocities.
    folded = found.group_velocity(2.0 * q[2:4], cell=4)
    assert found.group_velocity(q[2:4])[0, 0] == pytest.approx(folded[0, 0], rel=1e-11)
    with pytest.raises(hc.InputError, match="no cell of any length repeats"):
        hc.spectrum(
            hc.Chain.from_radii(np.linspace(1.0, 2.0, 9)).replace(
                precompression=1.0, held_by="force"
            )
        ).group_velocity(1.0)


def boechler():
    """80 spheres of aluminium and steel in turn, R = 9.53 mm, under 20.4 N, A = 7.04 N/um^1.5."""
    density = np.resize([2700.0, 8000.0], 80)
    radii = np.full(80, 9.53e-3)
    return hc.Chain(
        radii, units="SI", masses=4 / 3 * np.pi * density * radii**3, stiffness=np.full(79, 7.04e9),
        velocities=np.zeros(80), precompression=20.4, held_by="force",
    )  # fmt: skip


def test_band_edges_of_boechler_et_al():
    # PRL 104, 244302 (2010); frequencies and A recalled, masses from densities.
    (_, acoustic), (low, high) = hc.spectrum(boechler()).band_edges()
    np.testing.assert_allclose([acoustic, low, high], [5125.0, 8820.0, 10200.0], rtol=3e-3)


def test_units_make_no_difference():
    balls = hc.Chain.from_materials(5e-3, "steel-52100", beads=8, velocity=0.1)
    lossy = balls.replace(
        precompression=10.0, left_wall=hc.Wall(), right_wall=hc.Wall.rigid(),
        loss=hc.Viscoelastic(1e-6),
    )  # fmt: skip
    scales = hc.Scales.of(lossy)
    si, scaled = hc.spectrum(lossy), hc.spectrum(scales.to_scaled(lossy))
    np.testing.assert_allclose(si.eigenvalues * scales.time, scaled.eigenvalues, rtol=1e-10)
    # Between like walls, all springs K: f = 2 sqrt(K/m) sin(q/2)/2 pi, in Hz.
    k = np.full(7, balls.stiffness[0])
    wall = hc.Wall(stiffness=k[0])
    even = balls.replace(precompression=10.0, left_wall=wall, right_wall=wall)
    spring = 1.5 * k[0] ** (2 / 3) * 10.0 ** (1 / 3)
    q = np.pi * np.arange(1, 9) / 9
    expected = np.sqrt(spring / balls.masses[0]) / np.pi * np.sin(q / 2)
    np.testing.assert_allclose(hc.spectrum(even).frequencies, expected, rtol=1e-12)


def test_low_frequencies_of_strong_tapers_keep_their_digits():
    chain = hc.Chain.tapered("forward-exponential", 0.2, beads=60).replace(
        precompression=1.0, held_by="force"
    )
    found = hc.spectrum(chain)
    assert found.frequencies[0] == 0.0
    assert found.frequencies[1] > 0.0
    damped = hc.spectrum(chain.replace(loss=hc.Viscoelastic(1e-3)))
    omega = 2 * np.pi * found.frequencies
    delta = 0.5e-3 * omega**2
    # The light end is overdamped; oscillating modes are unchanged, delta = A omega^2/2.
    rings = damped.eigenvalues.imag > 0.0
    found, expected = np.sort(damped.decay_rates[rings]), delta[1:][delta[1:] < omega[1:]]
    np.testing.assert_allclose(found, expected, rtol=1e-10)


def test_dented_contacts_ring_along_the_steep_curve():
    # The error message of a WaltonBraun chain advises this.
    ratio, wall = 0.5, hc.Wall(stiffness=1.0)
    base = hc.Chain.uniform(3).replace(precompression=1.0, left_wall=wall, right_wall=wall)
    kick = 1e-6 * np.array([1.0, 0.3, -0.2])
    times = np.linspace(400.0, 440.0, 300)
    run = hc.simulate(
        base.replace(loss=hc.WaltonBraun(ratio), velocities=kick), until=440.0, times=times
    )
    steep = hc.Wall(stiffness=1.0 / ratio**1.5)
    chain = base.replace(stiffness=np.full(2, 1.0 / ratio**1.5), left_wall=steep, right_wall=steep)
    waves = np.exp(np.outer(times - 400.0, hc.spectrum(chain).eigenvalues))
    basis = np.column_stack([waves.real, waves.imag])
    for velocity in run.velocities.T:
        fitted = basis @ np.linalg.lstsq(basis, velocity, rcond=None)[0]
        assert np.abs(fitted - velocity).max() < 1e-4 * np.abs(velocity).max()


def test_a_wall_across_a_gap_is_not_there():
    standing = hc.Chain.uniform(4).replace(gravity=0.1, right_wall=hc.Wall())
    far = standing.replace(left_wall=hc.Wall(gap=0.5))
    np.testing.assert_array_equal(hc.spectrum(far).eigenvalues, hc.spectrum(standing).eigenvalues)


def test_weak_power_laws_are_lossless_and_say_so():
    chain = random_chain(2, loss=hc.VelocityPower(0.3, alpha=1.81))
    with pytest.warns(hc.ModelRangeWarning, match="power 1.81 of the speed.*decay rates are 0"):
        found = hc.spectrum(chain)
    np.testing.assert_array_equal(
        found.eigenvalues, hc.spectrum(chain.replace(loss=None)).eigenvalues
    )


HELD = random_chain(4, **BETWEEN_WALLS)
FREE = random_chain(4)
EQUAL = hc.Chain.uniform(4).replace(precompression=1.0, held_by="force")


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: hc.spectrum("chain"), "requires a Chain, got 'chain'"),
        (lambda: hc.spectrum(hc.Chain.uniform(3)), "contact 1 carries no static force"),
        (
            lambda: hc.spectrum(
                hc.Chain.uniform(3).replace(
                    gravity=0.1, left_wall=hc.Wall(), right_wall=hc.Wall()
                )
            ),
            r"contact 0 \(left wall\) carries no static force",
        ),
        (lambda: hc.spectrum(EQUAL.struck_by(velocity=1.0)), "strikers .* remove them"),
        (lambda: hc.spectrum(FREE.replace(loss=hc.UnloadingRatio(0.1))), "UnloadingRatio.* discon"),
        (lambda: hc.spectrum(FREE.replace(loss=hc.WaltonBraun(0.8))), "stiffness / 0.8"),
        (
            lambda: hc.spectrum(FREE.replace(loss=hc.VelocityPower(0.1, alpha=0.5))),
            "infinitely fast from rest",
        ),
        (lambda: hc.spectrum(HELD).transfer(-1.0, 1), "at least 0, got -1"),
        (lambda: hc.spectrum(HELD).transfer(1.0, 7), "bead must be .* from 1 to 6, got 7"),
        (lambda: hc.spectrum(HELD).transfer(1.0, 1, at=0), "driven bead must be"),
        (lambda: hc.spectrum(HELD).transfer(1.0, 1, drive="push"), "unknown drive 'push'"),
        (lambda: hc.spectrum(HELD).transfer(1.0, 1, at="left"), "did you mean 'left wall'"),
        (lambda: hc.spectrum(HELD).transfer(1.0, 1, at="left wall"), "does not move it"),
        (
            lambda: hc.spectrum(FREE).transfer(1.0, 1, drive="displacement", at="right wall"),
            "right wall cannot be driven",
        ),
        (lambda: hc.spectrum(FREE).transfer(0.0, 1), "frequencies above 0"),
        (lambda: hc.spectrum(HELD).transfer_force(1.0, 8), "contact must be .* from 0 to 6"),
        (lambda: hc.spectrum(HELD).bands(0.1), "no cell of any length repeats"),
        (lambda: hc.spectrum(HELD).band_edges(cell=4), "cell must be .* from 1 to 3, got 4"),
        (lambda: hc.spectrum(HELD).band_edges(cell=2), "no cell of 2 beads repeats"),
    ],
)  # fmt: skip
def test_bad_input_is_rejected(call, said):
    with pytest.raises(hc.InputError, match=said):
        call()


def test_losses_of_size_zero_are_none():
    for loss in (hc.UnloadingRatio(0.0), hc.WaltonBraun(1.0), hc.VelocityPower(0.0, 0.5),
                 hc.Restitution(1.0)):  # fmt: skip
        assert not linear_contacts(FREE.replace(loss=loss)).dampers.any()


def crystal(cells=6):
    """Alternating light and heavy balls under a constant force, in SI units."""
    pair = hc.Chain.periodic([5e-3] * 2, cells=cells, materials=["silicon-nitride", "steel-52100"])
    return pair.replace(precompression=10.0, held_by="force")


def test_bands_are_drawn_with_their_published_edges():
    chain = crystal()
    light, heavy = chain.masses[:2]
    spring = 1.5 * chain.stiffness[0] ** (2 / 3) * 10.0 ** (1 / 3)
    edges = np.sqrt(2.0 * spring / np.array([heavy, light, light * heavy / (light + heavy)]))
    axes = hc.spectrum(chain).plot()
    acoustic, optical = (line.get_ydata() for line in axes.lines[:2])
    drawn = [acoustic.max(), optical.min(), optical.max()]
    np.testing.assert_allclose(drawn, edges / (2e3 * np.pi), rtol=1e-12)
    gap, above = (patch.get_bbox() for patch in axes.patches)
    np.testing.assert_allclose([gap.y0, gap.y1, above.y0], drawn, rtol=1e-9)
    assert axes.get_ylabel() == "frequency [kHz]"


def test_chains_that_do_not_repeat_are_drawn_by_mode():
    found = hc.spectrum(random_chain(1))
    axes = found.plot()
    np.testing.assert_array_equal(axes.lines[0].get_ydata(), found.frequencies)
    assert axes.get_xlabel() == "mode"
    assert not axes.patches
    with pytest.raises(hc.InputError, match="no cell"):
        found.plot("bands")
    with pytest.raises(hc.InputError, match="bands, modes"):
        found.plot("waves")


def test_equal_beads_have_one_band_without_a_gap():
    held = hc.Chain.uniform(12).replace(precompression=1.0, held_by="force")
    axes = hc.spectrum(held).plot(cell=2)
    assert len(axes.patches) == 1  # above the band; the two halves of the band touch
    assert axes.get_ylabel() == "frequency $f$"


def test_a_simulation_has_the_transfer_function_that_is_drawn():
    chain = crystal().replace(loss=hc.Viscoelastic(3e-6))
    moments = np.linspace(0.0, 200e-6, 401)
    pulse = 0.01 * np.exp(-(((moments - 100e-6) / 15e-6) ** 2) / 2)
    pulse[[0, -1]] = 0.0
    drive, times = hc.TableDrive(moments, pulse), np.arange(8000) / 80e3
    run = hc.simulate(chain.replace(drive=drive), times=times)
    spectra = [np.fft.rfft(each) for each in (run.forces[:, 9] - 10.0, drive.value(times))]
    frequencies = np.fft.rfftfreq(len(times), times[1])[200:801:100]
    axes = hc.spectrum(chain).plot_transfer(9, frequencies=frequencies)
    measured = np.abs(spectra[0] / spectra[1])[200:801:100]
    # The linear theory neglects terms of the relative size of the pulse, 1e-3.
    np.testing.assert_allclose(axes.lines[0].get_ydata(), measured, rtol=2e-3)
    np.testing.assert_allclose(axes.lines[0].get_xdata(), frequencies / 1e3)


def test_shaded_frequencies_have_one_entry_in_the_legend():
    axes = hc.spectrum(crystal()).plot_transfer(9)
    assert legend_texts(axes) == ["no plane waves"]
    shaded = axes.get_legend().get_patches()[0].get_facecolor()
    assert shaded == axes.patches[0].get_facecolor()
    hc.spectrum(crystal().replace(loss=hc.Viscoelastic(3e-6))).plot_transfer(9, ax=axes)
    assert legend_texts(axes) == ["no loss", "viscoelastic 3 µs", "no plane waves"]
    taper = hc.Chain.tapered("forward-linear", 0.01, beads=20).replace(**PRESSED)
    assert hc.spectrum(taper).plot_transfer(9).get_legend() is None


GUIDE = hc.Chain.periodic(
    ["9.53 mm"] * 2, cells=10, materials=["silicon-nitride", "steel-52100"]
).replace(precompression="20 N", held_by="force")
PRESSED = {"precompression": 1.0, "held_by": "force", "right_wall": hc.Wall()}


@pytest.mark.parametrize(
    ("chain", "contact"),
    [
        (GUIDE, 16),
        (GUIDE.replace(loss=hc.Viscoelastic(1e-12)), 16),
        (GUIDE.replace(loss=hc.Viscoelastic("3 us")), 16),
        (hc.Chain.uniform(9).replace(**PRESSED), 9),
        (hc.Chain.uniform(2).replace(**PRESSED), 1),
        (hc.Chain.uniform(100).replace(**PRESSED), 50),
        (hc.Chain.periodic([1.0, 0.2], cells=20).replace(**PRESSED), 2),
    ],
)
def test_resonances_do_not_compress_the_rest_of_a_transfer_function(chain, contact):
    found = hc.spectrum(chain)
    axes = found.plot_transfer(contact)
    # The curve has further points at resonances.
    frequencies = np.linspace(0.0, 1.25 * found.frequencies.max(), 2002)[1:]
    force = np.abs(found.transfer_force(frequencies, contact))
    band = frequencies <= frequencies[-1] / 1.25  # up to the highest mode
    low, high = axes.get_ylim()
    shown = (force >= low) & (force <= high)
    assert shown[band].mean() > 0.99
    # The typical amplitude is neither at the top nor at the bottom of the frame.
    place = np.log(np.median(force[band]) / low) / np.log(high / low)
    assert 0.1 < place < 0.9


def test_the_frame_of_a_resonance_does_not_depend_on_a_frequency_that_meets_it():
    crystal = hc.spectrum(GUIDE)
    grid = np.linspace(10.0, 14e3, 1500)
    met = np.sort(np.append(grid, crystal.frequencies[1:]))
    limits = [crystal.plot_transfer(16, frequencies=each).get_ylim() for each in (grid, met)]
    assert limits[1][1] == pytest.approx(limits[0][1], rel=2.0)
    lossy = hc.spectrum(GUIDE.replace(loss=hc.Viscoelastic("3 us")))
    top = lossy.plot_transfer(16, frequencies=np.linspace(10.0, 14e3, 50)).get_ylim()[1]
    assert top > np.abs(lossy.transfer_force(np.linspace(10.0, 14e3, 50), 16)).max()


def test_transfer_functions_in_the_same_axes_remain_visible():
    lossy = crystal().replace(loss=hc.Viscoelastic(3e-6))
    alone = [hc.spectrum(chain).plot_transfer(9).get_ylim() for chain in (crystal(), lossy)]
    axes = hc.spectrum(lossy).plot_transfer(9)
    hc.spectrum(crystal()).plot_transfer(9, ax=axes)
    assert len({line.get_color() for line in axes.lines}) == 2
    assert axes.get_ylim() == (min(low for low, _ in alone), max(high for _, high in alone))


def frequencies_ahead_of(found, bead):
    """Frequencies of the beads ahead of a bead that does not move, from their matrix."""
    contacts = found.contacts
    springs, masses = contacts.springs[bead:], contacts.masses[bead:]
    matrix = np.diag(springs[:-1] + springs[1:])
    matrix = matrix - np.diag(springs[1:-1], 1) - np.diag(springs[1:-1], -1)
    scale = np.sqrt(masses)
    return np.sqrt(np.linalg.eigvalsh(matrix / np.outer(scale, scale))) / (2.0 * np.pi)


@pytest.mark.parametrize("points", [50, 333, 2001])
@pytest.mark.parametrize(
    ("drive", "at", "contact"), [("force", 1, 16), ("force", 7, 3), ("displacement", 6, 12)]
)
def test_all_resonances_without_loss_leave_the_frame(drive, at, contact, points):
    found = hc.spectrum(GUIDE)
    grid = np.linspace(10.0, 14e3, points)
    axes = found.plot_transfer(contact, drive=drive, at=at, frequencies=grid)
    frequencies, force = axes.lines[0].get_data()
    outside = 1e3 * frequencies[force > axes.get_ylim()[1]]
    if drive == "force":
        # A mode that does not move the bead or compress the contact is not excited.
        strain = np.diff(found.modes, axis=0)[contact - 1]
        felt = np.abs(strain * found.modes[at - 1]) > 1e-9 * np.abs(found.modes).max() ** 2
        expected = found.frequencies[felt & (found.frequencies > 1.0)]
    else:
        expected = frequencies_ahead_of(found, at)
    assert len(expected) > 13
    for resonance in expected:
        assert np.abs(outside - resonance).min() < 1e-6 * resonance


def test_a_mode_with_a_node_at_the_drive_is_not_excited():
    wall = hc.Wall()
    found = hc.spectrum(hc.Chain.uniform(9).replace(precompression=1.0, left_wall=wall,
                                                    right_wall=wall))  # fmt: skip
    axes = found.plot_transfer(2, at=5)
    frequencies, force = axes.lines[0].get_data()
    outside = frequencies[force > axes.get_ylim()[1]]
    distance = np.abs(outside[:, None] - found.frequencies).min(axis=0)
    assert (distance[::2] < 1e-6).all()
    # Modes 2, 4, 6 and 8 are odd.
    assert (distance[1::2] > 1e-3).all()


def test_the_axis_of_a_transfer_function_names_the_driven_place():
    found = hc.spectrum(crystal())
    label = found.plot_transfer(3, at=2).get_ylabel()
    assert label == "force in contact 3\nper force on bead 2"
    label = found.plot_transfer(3, drive="displacement").get_ylabel()
    assert label == "force in contact 3\nper displacement of bead 1 [N/m]"


@pytest.mark.parametrize("frequencies", [[1.0], [2.0, 1.0]])
def test_a_transfer_function_is_drawn_over_increasing_frequencies(frequencies):
    with pytest.raises(hc.InputError, match="two increasing"):
        hc.spectrum(crystal()).plot_transfer(3, frequencies=frequencies)


def test_precompressed_chains_in_si_units_are_at_rest_unless_struck():
    chain = crystal()
    assert not chain.velocities.any()
    assert repr(chain).endswith("precompression, at rest)")
    assert chain.replace(precompression=0.0).velocities[0] == 1.0
    struck = chain.struck_by(velocity=0.1)
    assert struck.velocities[:2].tolist() == [0.1, 0.0]
    assert "at rest" not in repr(struck)
    assert hc.Chain.uniform(4).replace(precompression=1.0, held_by="force").velocities[0] == 1.0
    with pytest.raises(hc.InputError, match="not struck; give it a velocity"):
        hc.simulate(chain)


def test_the_sound_speed_is_the_slope_of_the_acoustic_band():
    q = 1e-4
    balls = hc.Chain.from_materials(5e-3, "steel-52100", beads=20)
    found = hc.spectrum(balls.replace(precompression=10.0, held_by="force"))
    slope = dispersion_uniform(q, mass=balls.masses[0], spring=found.contacts.springs[1]) / q
    assert found.sound_speed == pytest.approx(10e-3 * slope, rel=1e-8)
    assert f"sound speed {found.sound_speed:.4g} m/s" in repr(found)
    # In a cell of three beads of two sizes, the reference is the slope of the lowest band.
    sizes = [5e-3, 3e-3, 5e-3]
    cell = hc.Chain.periodic(sizes, cells=4, materials=["brass", "glass", "brass"])
    found = hc.spectrum(cell.replace(precompression=1.0, held_by="force"))
    slope = 2.0 * np.pi * found.bands(q)[0] / q
    assert found.sound_speed == pytest.approx(2.0 * sum(sizes) * slope, rel=1e-7)


def test_a_chain_that_does_not_repeat_has_no_sound_speed():
    found = hc.spectrum(random_chain(1))
    with pytest.raises(hc.InputError, match="no cell of any length repeats"):
        _ = found.sound_speed
    assert "sound speed" not in repr(found)


def test_gaps_have_the_closed_form_of_diatomic_chains():
    for ratio in (0.3, 0.9):
        masses = np.where(np.arange(12) % 2, ratio, 1.0)
        chain = hc.Chain.uniform(12).replace(
            masses=masses, stiffness=np.ones(11), precompression=1.0, held_by="force"
        )
        found = hc.spectrum(chain)
        (_, below), (above, end) = band_edges(other_mass=ratio, spring=1.5).reshape(2, 2) / (
            2 * np.pi
        )
        np.testing.assert_allclose(found.gaps(), [[below, above], [end, np.inf]], rtol=1e-12)
        gap = f"gap {below:g} .. {above:g}"
        assert gap in " ".join(repr(found).split())
        assert "Gaps without waves" in found._repr_html_()
    equal = hc.spectrum(hc.Chain.uniform(12).replace(precompression=1.0, held_by="force"))
    # Bands of a doubled cell touch.
    for cell in (1, 2):
        np.testing.assert_allclose(
            equal.gaps(cell=cell), [[np.sqrt(6.0) / (2 * np.pi), np.inf]], rtol=1e-12
        )
    assert "gap" not in repr(equal)
    assert "Gaps without" not in equal._repr_html_()


def test_the_command_spectrum(run, tmp_path):
    file = tmp_path / "crystal.toml"
    file.write_text(
        '[chain]\ncell = ["9.53 mm", "9.53 mm"]\ncells = 10\n'
        'materials = ["silicon-nitride", "steel-52100"]\n'
        'precompression = "20 N"\nheld_by = "force"\n'
    )
    picture = tmp_path / "bands.svg"
    code, out, _ = run("spectrum", file, "--json", "--plot", picture)
    assert code == 0
    assert picture.stat().st_size > 1000
    found = json.loads(out)
    chain = hc.load_chain(file)
    light, heavy = chain.masses[:2]
    spring = 1.5 * chain.stiffness[0] ** (2 / 3) * 20.0 ** (1 / 3)
    edges = [np.sqrt(2 * spring / m) / (2 * np.pi)
             for m in (heavy, light, light * heavy / (light + heavy))]  # fmt: skip
    assert found["gaps"][0] == pytest.approx(edges[:2], rel=1e-9)
    assert found["gaps"][1] == [pytest.approx(edges[2], rel=1e-9), None]
    assert np.ravel(found["bands"]) == pytest.approx([0.0, *edges], rel=1e-9)
    speed = 4 * chain.radii[0] * np.sqrt(spring / (2 * (light + heavy)))
    assert found["sound_speed"] == pytest.approx(speed, rel=1e-9)
    assert len(found["frequencies"]) == 20
    text = run("spectrum", file, "--all")[1]
    assert f"no waves     {edges[0] / 1e3:.5g} to {edges[1] / 1e3:.5g} kHz" in text
    assert "frequency [kHz]" in text
    weaker = json.loads(run("spectrum", file, "--precompression", "0.3125 N", "--json")[1])
    assert weaker["sound_speed"] == pytest.approx(speed / 2, rel=1e-9)
    taper = ("spectrum", "--taper", "backward-linear", "--rate", 0.1, "--beads", 6)
    assert "no bands" in run(*taper, "--precompression", 1)[1]
    assert json.loads(run(*taper, "--precompression", 1, "--json")[1])["gaps"] is None
    code, _, err = run(*taper)
    assert code == 2
    assert "no static force: give --precompression" in err
    code, _, err = run("spectrum", file, "--precompression", "20")
    assert code == 2
    assert "has no unit" in err


def test_frequencies_of_a_transfer_function_may_have_units():
    chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=6).replace(
        precompression=10.0, held_by="force", right_wall=hc.Wall()
    )
    found = hc.spectrum(chain)
    expected = found.transfer_force([1e3, 2e3], 4)
    np.testing.assert_array_equal(found.transfer_force(["1 kHz", "2 kHz"], 4), expected)
    assert found.transfer("1 kHz", 4) == found.transfer(1e3, 4)
    with pytest.raises(hc.InputError, match="frequency must have a unit such as Hz, kHz"):
        found.transfer_force("1 N", 4)


def test_the_csv_of_a_transfer_function_has_no_file():
    arguments = ["spectrum", "chain.toml", "--transfer", "3", "--csv", "out.csv"]
    done = CliRunner().invoke(cli, arguments)
    assert done.exit_code == 2
    assert "--csv takes no file name, because the table is printed" in done.stderr


def test_springs_and_dampers_have_a_short_representation():
    held = {"precompression": 2.0, "held_by": "force"}
    equal = hc.Chain.uniform(200).replace(**held)
    contacts = hc.spectrum(equal).contacts
    spring = contacts.springs[100]
    assert repr(contacts) == f"LinearContacts(200 beads: springs {spring:.4g}; no dampers)"
    lossy = hc.Chain.tapered("forward-linear", 0.01, beads=9).replace(loss=hc.Dashpot(0.1), **held)
    contacts = hc.spectrum(lossy).contacts
    inner = np.sort(contacts.springs[contacts.springs > 0.0])
    assert repr(contacts) == (
        f"LinearContacts(9 beads: springs {inner[0]:.4g} to {inner[-1]:.4g}; dampers up to 0.1)"
    )
