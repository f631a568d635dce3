"""Solitary waves, wave trains and shocks in chains of equal beads."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial

import numpy as np

from ..chain.chain import Chain
from ..chain.drives import TableDrive
from ..chain.laws.dashpot import Dashpot
from ..chain.materials import Material
from ..chain.walls import Wall
from ..collision import Array
from ..pulse.pulse import Pulse
from ..simulation.run import Run
from ..simulation.simulate import simulate
from ..theory.bca import bca
from ..theory.long_wave import QUOTED_COEFFICIENTS, sen_manciu_coefficients
from ..theory.solitary_wave import SolitaryWave, solitary_wave
from ..theory.spectrum import spectrum
from .case import PULSE_FORCE, TWO_INTEGRATIONS, Case, shared

ROSAS = "Rosas, Lindenberg, PRE 69, 037601 (2004)"
HERBOLD = "Herbold, Nesterenko, PRE 75, 021304 (2007)"
# Time from bead to bead of the wave created by an impact with velocity one.
PERIOD = 1.18975557698


def cases() -> list[Case]:
    """Cases of this topic."""
    return [*_uniform(), *_published(), *_profile(), *_strikers(), *_shocks(), *_steel_beads()]


def _uniform() -> Iterator[Case]:
    """A uniform chain, struck by an identical bead."""
    velocities = {1.25: 0.57733689, 1.5: 0.68163155, 1.75: 0.74714607, 2.0: 0.79433275,
                  2.5: 0.85911287, 3.0: 0.90128004, 4.0: 0.95024781}  # fmt: skip
    speeds = {1.25: 0.9466818312, 1.5: 0.9074700784, 2.0: 0.8552519319, 3.0: 0.8047601163}
    for p, velocity in velocities.items():
        yield Case(
            "uniform chain", f"velocity of the leading pulse, p = {p:g}", velocity, 6e-9,
            TWO_INTEGRATIONS, partial(_velocity, p), "computed",
        )  # fmt: skip
    for p, constant in speeds.items():
        yield Case(
            "uniform chain", f"speed constant C, p = {p:g}", constant, 5e-10,
            "iteration of the wave equation", partial(_speed_constant, p), "computed",
        )  # fmt: skip
    yield Case(
        "uniform chain", "velocity of the last bead, which separates", 0.98567886, 6e-9,
        TWO_INTEGRATIONS, lambda: _struck(1.5).pulse().velocity[-1], "computed",
    )  # fmt: skip
    yield Case(
        "uniform chain", "velocity of the striker afterwards", -0.07108502, 6e-9,
        TWO_INTEGRATIONS, lambda: _struck(1.5).state.velocities[0], "computed",
    )  # fmt: skip
    yield Case(
        "uniform chain", "momentum of all beads that move forwards", 1.138305088728, 5e-9,
        TWO_INTEGRATIONS, lambda: _momentum("leading pulse", "lagging"), "computed",
    )  # fmt: skip
    # By definition, the leading pulse does not include all of its tail.
    yield Case(
        "uniform chain", "momentum of the leading pulse", 1.138305088728, 2e-5,
        TWO_INTEGRATIONS, lambda: _momentum("leading pulse"), "computed",
    )  # fmt: skip
    yield Case(
        "uniform chain", "twice the momentum transferred at the crest", 1.138305088728, 5e-9,
        "symmetry of the wave", lambda: 2.0 * _struck(1.5).leading_pulse().handed_over[150],
        "computed",
    )  # fmt: skip
    yield Case(
        "uniform chain", "kinetic part of the wave, mean over a bead", 5.0 / 9.0, 1e-9,
        "virial theorem", _kinetic_fraction,
    )  # fmt: skip
    cradle = {1: -0.07095235, 2: 0.07640304, 3: 0.99454931}
    for bead, velocity in cradle.items():
        yield Case(
            "uniform chain", f"Newton's cradle of 3 Hertz beads, bead {bead}", velocity, 6e-9,
            "as Herrmann, Seitz, Am. J. Phys. 50, 977 (1982)", partial(_cradle, bead), "computed",
        )  # fmt: skip


def _published() -> Iterator[Case]:
    """Published numbers, as printed."""
    yield Case(
        "published numbers", "speed of the pulse, numerical [beads/time]", 0.84, 5e-3, ROSAS,
        lambda: _speed(_struck(1.5).pulse()), "recalled",
    )  # fmt: skip
    yield Case(
        "published numbers", "speed of the pulse, BCA [beads/time]", 0.82, 5e-3, ROSAS,
        lambda: 1.0 / float(_residence(bca(Chain.uniform(3)))[0]), "recalled",
    )  # fmt: skip
    yield Case(
        "published numbers", "velocity of the pulse over the impact's", 0.682, 5e-4,
        "Hinch, Saint-Jean, Proc. R. Soc. A 455, 3201 (1999)", partial(_velocity, 1.5), "recalled",
    )  # fmt: skip
    yield Case(
        "published numbers", "Nesterenko's prefactor of the speed", 0.6802, 0.0125 * 0.6802,
        "Daraio et al., PRE 73, 026610 (2006); long-wave theory, known to be 1.24% too low",
        lambda: _steel_speed() / _speed_unit(_steel_force()), "recalled",
    )  # fmt: skip
    yield Case(
        "published numbers", "prefactor of the speed of sound", 0.9314, 1e-4,
        "Daraio et al., PRE 73, 026610 (2006); truncated", _sound_prefactor, "recalled",
    )  # fmt: skip
    # Differences between the fit and the Taylor coefficients of the exact wave.
    known_errors = (1.2e-4, 1.6e-4, 1.1e-4)
    for order, quoted, error in zip((1, 3, 5), QUOTED_COEFFICIENTS, known_errors, strict=True):
        yield Case(
            "published numbers", f"coefficient C{order} of Sen and Manciu", quoted, error,
            "PRE 64, 056605 (2001); a fit, compared with the Taylor series",
            partial(_sen_manciu, order), "recalled",
        )  # fmt: skip


def _profile() -> Iterator[Case]:
    """Limits of the wave profile."""
    yield Case(
        "wave profile", "ln of the overlap 4 beads from the crest", math.log(4.694144675343e-9),
        1e-9, "iteration in 60-digit arithmetic", partial(_log_overlap, 4.0), "computed",
    )  # fmt: skip
    yield Case(
        "wave profile", "ln of the overlap 6 beads from the crest", math.log(5.420602767884e-26),
        1e-9, "iteration in 60-digit arithmetic", partial(_log_overlap, 6.0), "computed",
    )  # fmt: skip
    yield Case(
        "wave profile", "Gaussian for p -> 1: exponent/3(p - 1)", 1.0, 1e-2,
        "Chatterjee, PRE 59, 5912 (1999); to second order in p - 1", _gaussian,
    )  # fmt: skip
    yield Case(
        "wave profile", "c^2 at p = 1.05, unit crest overlap", 0.975, 0.05**2,
        "1 - (p - 1)/2, to first order in p - 1", _squared_speed,
    )  # fmt: skip


def _strikers() -> Iterator[Case]:
    """Uniform chains struck by a lighter or heavier bead, by several beads, or at both ends."""
    velocities = {0.1: 0.12348280, 0.25: 0.27030873, 0.5: 0.44968037, 2.0: 0.94809654,
                  4.0: 1.21314076, 8.0: 1.44133545, 16.0: 1.62033946}  # fmt: skip
    for mass, velocity in velocities.items():
        yield Case(
            "strikers", f"velocity at bead 61, striker of mass {mass:g}", velocity, 6e-9,
            TWO_INTEGRATIONS, partial(_struck_by_mass, mass), "computed",
        )  # fmt: skip
    for count in range(1, 6):
        number = "1 striker" if count == 1 else f"{count} strikers"
        yield Case(
            "strikers", f"number of waves from {number}", count, 0.0,
            "PRE 67, 066607 (2003); above 5% of the first", partial(_waves, count), "abstract",
        )  # fmt: skip
    yield Case(
        "strikers", "head-on: middle force over the pulse's", 2.23838, 6e-6,
        "symmetry: equivalent to a rigid wall", _head_on,
    )  # fmt: skip


def _shocks() -> Iterator[Case]:
    """Shocks in a chain with dashpots, driven by a piston of velocity one."""
    for what, compute in (("speed of the front", _front_speed), ("force behind it", _force)):
        yield Case(
            "shocks", f"{what}, gamma = 0.2", 1.0, 1e-4, f"jump conditions; {HERBOLD}", compute,
        )  # fmt: skip
    # Deviations behind the front vary as exp(z t), with z^2 = (2 cosh z - 2)(3/2 - gamma z).
    real, imaginary = 0.8078330631538784, 2.174999391852513
    yield Case(
        "shocks", "half period behind the front, gamma = 0.2", math.pi / imaginary, 2e-3,
        "linearised equation, of limited accuracy at this amplitude", lambda: _ripples()[0],
    )  # fmt: skip
    yield Case(
        "shocks", "ratio of successive extrema, gamma = 0.2",
        -math.exp(-math.pi * real / imaginary), 5e-3,
        "linearised equation, of limited accuracy at this amplitude", lambda: _ripples()[1],
    )  # fmt: skip
    yield Case(
        "shocks", "overshoot, gamma = 0.4", 0.0, 1e-4,
        "monotonic above 0.395, where the roots coincide", lambda: _overshoot(0.4),
    )  # fmt: skip


def _steel_beads() -> Iterator[Case]:
    """Steel beads of 10 mm diameter (E = 203 GPa, nu = 0.3, 7780 kg/m^3), struck at 1 m/s."""
    for name, value, tolerance, compute in (
        ("speed of the pulse [m/s]", 674.659, 6e-4, _steel_speed),
        ("largest force [N]", 209.121, 6e-4, _steel_force),
        ("largest overlap [um]", 9.2479, 6e-5, _steel_overlap),
    ):
        yield Case(
            "steel beads", name, value, tolerance, "scaled constants converted to SI", compute,
        )  # fmt: skip


@shared
def _struck(p: float) -> Run:
    return simulate(Chain.uniform(200, exponent=p), times=0)


def _velocity(p: float) -> float:
    return float(_struck(p).pulse().velocity[150])


def _residence(pulse: Pulse) -> Array:
    assert pulse.residence is not None
    return pulse.residence


def _speed(pulse: Pulse) -> float:
    assert pulse.peak_time is not None
    return float(20.0 / (pulse.peak_time[160] - pulse.peak_time[140]))


def _speed_constant(p: float) -> float:
    pulse = _struck(p).pulse()
    return _speed(pulse) * float(pulse.velocity[150]) ** (-(p - 1.0) / (p + 1.0))


def _momentum(*parts: str) -> float:
    """Momentum of parts of the budget while the pulse is within the chain."""
    budget = simulate(Chain.uniform(100), until=80.0, times=[80.0]).budget()
    return float(sum(budget.momentum[part][0] for part in parts))


def _kinetic_fraction() -> float:
    """Kinetic fraction of the wave, averaged over the time in which it moves by one bead."""
    times = 60.0 + PERIOD * np.arange(24) / 24
    run = simulate(Chain.uniform(100), until=70.0, times=times)
    kinetic = 0.5 * run.velocities**2
    # Beads far behind are in free flight.
    behind = float(kinetic[0, :25].sum())
    return float(kinetic[:, 25:].sum(axis=1).mean()) / (0.5 - behind)


def _cradle(bead: int) -> float:
    return float(_three_beads().state.velocities[bead - 1])


@shared
def _three_beads() -> Run:
    return simulate(Chain.uniform(3), until=40.0, times=0)


def _wave_overlap(p: float, distance: float) -> float:
    return float(solitary_wave(p).overlap(distance))


def _log_overlap(distance: float) -> float:
    return math.log(_wave_overlap(1.5, distance))


def _sen_manciu(order: int) -> float:
    return float(sen_manciu_coefficients(solitary_wave())[(order - 1) // 2])


def _gaussian() -> float:
    """Exponent of the Gaussian, extrapolated linearly to p = 1."""
    near, far = (-math.log(_wave_overlap(p, 1.0)) / (3.0 * (p - 1.0)) for p in (1.05, 1.1))
    return 2.0 * near - far


def _squared_speed() -> float:
    wave: SolitaryWave = solitary_wave(1.05)
    p = wave.exponent
    velocity = wave.force_constant ** (-(p + 1.0) / (2.0 * p))
    return float((wave.speed_constant * velocity ** ((p - 1.0) / (p + 1.0))) ** 2)


def _struck_by_mass(mass: float) -> float:
    masses = np.ones(100)
    masses[0] = mass
    return float(simulate(Chain.uniform(100).replace(masses=masses), times=0).pulse().velocity[60])


def _waves(strikers: int) -> float:
    """Number of maxima of the velocity of one bead, without the ripples of 1% behind them."""
    chain = Chain.uniform(90).struck_by(count=strikers)
    velocity = simulate(chain, until=110.0, times=3000).velocity(50 + strikers)
    inner = velocity[1:-1]
    maxima = (inner > velocity[:-2]) & (inner >= velocity[2:]) & (inner > 0.05 * inner.max())
    return float(np.count_nonzero(maxima))


def _head_on() -> float:
    velocities = np.zeros(80)
    velocities[[0, -1]] = 1.0, -1.0
    run = simulate(Chain.uniform(80).replace(velocities=velocities), until=70.0, times=0)
    return float(run.largest_overlaps[40]) ** 1.5 / PULSE_FORCE


@shared
def _shock(gamma: float) -> Run:
    """Chain whose left wall moves with velocity one."""
    piston = TableDrive(np.array([0.0, 200.0]), np.array([0.0, 200.0]), of="displacement")
    chain = Chain.uniform(110).replace(
        left_wall=Wall(stiffness=1.0), drive=piston, loss=Dashpot(gamma)
    )
    return simulate(chain, until=90.0, times=np.linspace(40.0, 90.0, 1001))


def _front_speed() -> float:
    run = _shock(0.2)
    passed = [float(np.interp(0.5, np.maximum.accumulate(run.velocity(bead)), run.times))
              for bead in (50, 80)]  # fmt: skip
    return 30.0 / (passed[1] - passed[0])


def _force() -> float:
    return float(_shock(0.2).forces[-1, 40])


@shared
def _ripples() -> tuple[float, float]:
    """Time between extrema of the velocity behind the front, and the ratio of two of them."""
    from scipy.interpolate import CubicSpline

    run = _shock(0.2)
    curve = CubicSpline(run.times, run.velocity(60) - 1.0)
    extrema = curve.derivative().roots(extrapolate=False)
    extrema = extrema[extrema > extrema[np.argmax(curve(extrema))] - 1e-9][:6]
    return float(extrema[5] - extrema[2]) / 3.0, float(curve(extrema[3]) / curve(extrema[2]))


def _overshoot(gamma: float) -> float:
    return float(_shock(gamma).velocity(60).max()) - 1.0


@shared
def _steel() -> Pulse:
    # The values are for elastic beads (real ones would yield), so no yield strength is given.
    steel = Material("steel", density=7780.0, young=203e9, poisson=0.3)
    return simulate(Chain.from_materials(5e-3, steel, beads=100), times=0).pulse()


def _steel_speed() -> float:
    peak_time = _steel().peak_time
    assert peak_time is not None
    return float(0.2 / (peak_time[70] - peak_time[50]))


def _steel_force() -> float:
    force = _steel().peak_force
    assert force is not None
    return float(force[60])


def _steel_overlap() -> float:
    overlap = _steel().peak_overlap
    assert overlap is not None
    return float(1e6 * overlap[60])


def _speed_unit(force: float) -> float:
    r"""Unit :math:`[4E^2F/a^2\rho^3(1-\nu^2)^2]^{1/6}` for steel beads of diameter a."""
    return float((4.0 * 203e9**2 * force / (0.01**2 * 7780.0**3 * 0.91**2)) ** (1.0 / 6.0))


def _sound_prefactor() -> float:
    """Prefactor from the cut-off frequency f of the band, with c0 = pi f a."""
    held = _steel().chain.replace(precompression=5.0, held_by="force", velocities=np.zeros(100))
    return float(math.pi * spectrum(held).band_edges()[0, 1] * 0.01) / _speed_unit(5.0)
