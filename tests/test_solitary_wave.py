import itertools
import math
import pickle

import numpy as np
import pytest
from scipy.integrate import quad

import hertzchain as hc
from hertzchain.theory.long_wave import (
    QUOTED_COEFFICIENTS,
    long_wave_speed_constant,
    long_wave_velocity,
    precompressed_speed,
    sen_manciu_coefficients,
    sen_manciu_velocity,
)
from hertzchain.theory.solitary_wave import solitary_wave
from hertzchain.theory.wave_profile import WaveProfile

# Digits on which an integration of the strike and the fixed point agree, found with other code.
CONSTANTS = {
    1.25: ("0.9466818312", "2.20829199", "1.47921353", "1.00354850"),
    1.5: ("0.9074700784", "1.66997125", "1.06932295", "1.01301939"),
    1.75: ("0.8779190188", "1.44816612", "0.89292995", "1.02715347"),
    2.0: ("0.8552519319", "1.32465263", "0.79121100", "1.04519028"),
    2.5: ("0.8239183900", "1.19136868", "0.67716278", "1.09123488"),
    3.0: ("0.8047601163", "1.12214576", "0.61546478", "1.14869213"),
    4.0: ("0.7867928562", "1.05541083", "0.55372328", "1.29110662"),
}


@pytest.mark.parametrize("exponent", CONSTANTS)
def test_constants_to_every_printed_digit(exponent):
    wave = solitary_wave(exponent)
    found = (wave.speed_constant, wave.momentum_constant, wave.energy_constant)
    for printed, value in zip(CONSTANTS[exponent], (*found, wave.force_constant), strict=True):
        assert f"{value:.{len(printed) - 2}f}" == printed


@pytest.mark.parametrize("exponent", [1.5, 2.5])
def test_the_wave_that_a_strike_makes(exponent):
    pulse = hc.propagate(hc.Chain.uniform(100, exponent=exponent), rtol=1e-10)
    wave, v = solitary_wave(exponent), float(pulse.velocity[80])
    period = (pulse.peak_time[90] - pulse.peak_time[70]) / 20
    assert wave.speed(v) == pytest.approx(1.0 / period, rel=2e-11)
    if exponent == 1.5:
        assert f"{period:.10f}" == f"{1.0 / wave.speed(v):.10f}" == "1.1897555770"
    assert wave.peak_force(v) == pytest.approx(pulse.peak_force[80], rel=1e-10)


def test_momentum_and_energy_of_the_wave_in_a_run(uniform_run):
    v = 0.681631548571
    time = int(np.searchsorted(uniform_run.times, 80.0))
    crest = int(np.argmax(uniform_run.velocities[time]))
    near = slice(crest - 8, crest + 9)
    velocity, position = uniform_run.velocities[time, near], uniform_run.positions[time]
    overlap = np.maximum(-np.diff(position[crest - 8 : crest + 10]), 0.0)
    wave = solitary_wave()
    assert wave.momentum(v) == pytest.approx(velocity.sum(), abs=1e-9)
    energy = 0.5 * np.sum(velocity**2) + np.sum(overlap**2.5) / 2.5
    assert wave.energy(v) == pytest.approx(energy, abs=1e-9)


@pytest.mark.parametrize("exponent", [1.05, 1.5, 4.0, 20.0])
def test_profiles_solve_the_equation_by_another_quadrature(exponent):
    """c^2 phi(x) is the integral of force times triangle, by Gauss' rule on each half."""
    wave = solitary_wave(exponent)
    nodes, weights = np.polynomial.legendre.leggauss(60)
    s, w = 0.5 * (nodes + 1.0), 0.5 * weights
    x = np.linspace(-2.0, 2.0, 9)

    def folded(y):
        left, right = wave.force(y - s), wave.force(y + s)
        return np.sum(w * (1.0 - s) * (left + right))

    squared_speed = folded(0.0)
    ours = np.array([folded(y) for y in x]) / squared_speed
    np.testing.assert_allclose(ours, wave.overlap(x), atol=5e-13)
    kinetic = 0.5 * np.mean(wave.velocity(np.arange(-5, 5, 1 / 64)) ** 2) * 10
    if exponent == 1.5:
        assert kinetic / wave.energy_constant == pytest.approx(wave.kinetic_fraction, rel=1e-12)


def test_tail_of_hertz_contacts_by_arithmetic_of_sixty_digits():
    # The fixed point in mpmath with 60 digits, 16 and 24 points per bead: all digits agree.
    wave, known = solitary_wave(), {
        1: 0.3925945372443485687, 2: 0.019563612249527638832, 3: 0.000065885232434039029111,
        4: 4.694144675343125841e-9, 5: 1.1204623338285220291e-15, 6: 5.4206027678837335763e-26,
    }  # fmt: skip
    for distance, overlap in known.items():
        assert wave.overlap(distance) == pytest.approx(overlap, rel=1e-11)
        assert wave.force(-distance) == pytest.approx(overlap**1.5, rel=1e-11)


def integral(function, cuts):
    """Of a function that falls steeply from the first of the increasing cuts on."""
    return sum(quad(function, low, high, epsrel=1e-11)[0] for low, high in itertools.pairwise(cuts))


@pytest.mark.long
@pytest.mark.parametrize("exponent", [1.05, 1.25, 1.5, 2.0, 3.0, 20.0])
def test_tail_solves_the_equation_by_another_quadrature(exponent):
    wave, p = solitary_wave(exponent), exponent
    squared_speed = 2.0 * quad(lambda s: (1.0 - s) * wave.force(s), 0.0, 1.0)[0]
    seam = 0.5 * wave.overlap.width(1e-3)
    for x in np.linspace(0.8 * seam, 0.5 * wave.overlap.width(1e-290), 9):
        # Over the force a bead nearer to the crest: forces may be too small for the range.
        nearer = math.log(wave.overlap(x - 1.0))

        def share(at, x=x, nearer=nearer):
            overlap = max(float(wave.overlap(at)), 1e-308)
            return (1.0 - abs(x - at)) * math.exp(p * (math.log(overlap) - nearer))

        cuts = x - 1.0 + np.array([0.0, 1e-4, 1e-3, 1e-2, 0.1, 0.3, 1.0, 2.0])
        logarithm = p * nearer + math.log(integral(share, cuts) / squared_speed)
        assert math.log(wave.overlap(x)) == pytest.approx(logarithm, abs=1e-9)


@pytest.mark.parametrize("exponent", [1.25, 1.5, 3.0])
def test_velocity_of_the_tail_is_the_mean_of_the_force(exponent):
    wave = solitary_wave(exponent)
    scale = quad(lambda s: wave.force(s), -0.5, 0.5)[0]
    for x in (0.5, 1.0, 1.4, 2.0, 2.5):
        x *= wave.velocity.width(1e-3) / 2.0
        lower = float(wave.force(x - 0.5))
        cuts = x - 0.5 + np.array([0.0, 1e-3, 1e-2, 0.1, 0.4, 1.0])
        mean = lower * integral(lambda at, f=lower: wave.force(at) / f, cuts)
        assert wave.velocity(x) == pytest.approx(mean / scale, rel=1e-9)


def test_tail_falls_doubly_exponentially():
    # English and Pego 2005: ln phi(x + 1) / ln phi(x) tends to p, from above.
    for p in (1.5, 2.0, 3.0):
        wave = solitary_wave(p)
        logs = np.log(wave.overlap(np.arange(2.0, 0.5 * wave.overlap.width(1e-300))))
        ratios = logs[1:] / logs[:-1]
        assert (np.diff(ratios) < 0.0).all()
        assert p < ratios[-1] < 1.1 * p


def test_profiles_reach_far_and_can_be_pickled():
    wave = pickle.loads(pickle.dumps(solitary_wave(2.0)))
    assert wave.overlap(7.0) == solitary_wave(2.0).overlap(7.0) > 0.0
    assert wave.overlap([60.0, -1e9]).tolist() == [0.0, 0.0]
    assert (np.diff(wave.velocity(np.linspace(0.0, 9.0, 400))) <= 0.0).all()
    level = 1e-100
    assert wave.overlap(wave.overlap.width(level) / 2.0) == pytest.approx(level, rel=1e-9)


@pytest.mark.parametrize("exponent", [1.25, 1.5, 2.0, 3.0, 20.0])
def test_profiles_are_zero_where_they_underflow(exponent):
    wave, at = hc.solitary_wave(exponent), np.arange(0.0, 60.0, 0.05)
    for profile in (wave.velocity, wave.overlap, wave.force):
        with np.errstate(over="raise", invalid="raise"):
            values = profile(at)
        assert (np.diff(values) <= 0.0).all()
        assert values[-1] == 0.0


def test_printed_profile():
    xi = np.arange(0.0, 3.1, 0.5)
    velocity = [1, 0.75888, 0.32625, 0.07566, 8.723e-3, 4.450e-4, 8.602e-6]
    force = [1, 0.70732, 0.24599, 0.03985, 2.736e-3, 6.925e-5, 5.348e-7]
    wave = solitary_wave()
    np.testing.assert_allclose(wave.velocity(xi), velocity, rtol=7e-5)
    np.testing.assert_allclose(wave.force(-xi), force, rtol=2e-4)
    assert wave.overlap.width() == pytest.approx(1.72571, abs=5e-6)
    assert wave.force.width() == pytest.approx(1.41193, abs=5e-6)
    assert wave.velocity.width() == pytest.approx(1.57914, abs=5e-6)


def test_hard_spheres_are_the_limit_of_stiff_laws():
    wave = solitary_wave(20.0)
    assert wave.momentum_constant == pytest.approx(1.0, abs=1e-6)
    assert wave.energy_constant == pytest.approx(0.5, abs=1e-6)


def test_units_scale_as_the_equation_does():
    wave, (length, time, mass) = solitary_wave(2.0), (3.0, 5.0, 7.0)
    stiffness = mass / (length * time**2)
    speed = wave.speed(0.3 * length / time, mass, stiffness)
    assert speed * time == pytest.approx(wave.speed(0.3), rel=1e-14)
    force = wave.peak_force(0.3 * length / time, mass, stiffness)
    assert force / (mass * length / time**2) == pytest.approx(wave.peak_force(0.3), rel=1e-14)


def test_long_wave_theory_is_off_by_what_it_is_known_to_be_off():
    assert long_wave_speed_constant() / solitary_wave().speed_constant == pytest.approx(
        1.0079, abs=5e-5
    )
    small = solitary_wave(1.05).speed_constant
    assert long_wave_speed_constant(1.05) == pytest.approx(small, rel=1.3e-4)
    end = np.pi / 2 / np.sqrt(0.4)
    np.testing.assert_allclose(
        long_wave_velocity([0.0, 1.0, end - 1e-9, end, 5.0]),
        [1.0, np.cos(np.sqrt(0.4)) ** 4, 0.0, 0.0, 0.0],
        atol=1e-15,
    )


def test_sen_manciu_form_is_the_published_one():
    ours = sen_manciu_coefficients(solitary_wave())
    off = np.abs(np.array(ours) / QUOTED_COEFFICIENTS - 1.0)
    assert np.all(off < [6e-5, 7e-4, 0.02])
    xi = np.linspace(-1.5, 1.5, 61)
    exact = solitary_wave().velocity(xi)
    for coefficients in (ours, QUOTED_COEFFICIENTS):
        off = np.abs(sen_manciu_velocity(xi, coefficients) - exact).max()
        assert 5e-4 < off < 1e-3
    near = solitary_wave().velocity(0.05)
    assert sen_manciu_velocity(0.05, ours) == pytest.approx(near, abs=1e-9)


def exact_precompressed_speed(force_ratio, exponent):
    """Fixed point of c^2 phi = triangle * ((1 + phi)^p - 1) with a given crest."""
    n, step = 4096, 40.0 / 4096
    x = (np.arange(n) - n // 2) * step
    triangle = np.sinc(np.fft.rfftfreq(n, step)) ** 2
    crest = force_ratio ** (1.0 / exponent) - 1.0
    overlap = crest / np.cosh(x / 2) ** 2
    for _ in range(2000):
        new = np.fft.irfft(np.fft.rfft((1.0 + overlap) ** exponent - 1.0) * triangle, n)
        new = 0.5 * (new + np.roll(new[::-1], 1)) * crest / new[n // 2]
        change, overlap = np.abs(new - overlap).max(), new
        if change < 1e-11 * crest:
            break
    full = np.fft.irfft(np.fft.rfft((1.0 + overlap) ** exponent - 1.0) * triangle, n)
    return np.sqrt(full[n // 2] / crest / exponent)


@pytest.mark.parametrize(
    ("ratio", "low"), [(1.5, 0.00015), (3.0, 0.00105), (10.0, 0.0039), (55.0, 0.0080)]
)
def test_precompressed_speed_against_the_exact_wave(ratio, low):
    exact = exact_precompressed_speed(ratio, 1.5)
    assert 1.0 - precompressed_speed(ratio) / exact == pytest.approx(low, rel=0.1)
    hertz = np.sqrt(4 / 15 * (3 + 2 * ratio ** (5 / 3) - 5 * ratio ** (2 / 3)))
    assert precompressed_speed(ratio) == pytest.approx(hertz / (ratio ** (2 / 3) - 1), rel=1e-13)


def test_precompressed_speed_is_smooth_where_its_two_forms_meet():
    p = 1.5
    edge = 1.05**p
    ratios = edge + np.array([-2e-6, -1e-6, 0.0, 1e-6, 2e-6])
    assert np.ptp(np.diff(precompressed_speed(ratios))) < 1e-12
    assert precompressed_speed(1.0) == 1.0
    assert precompressed_speed(1.001, 3.0) == pytest.approx(1.0 + 0.001 / 9, rel=1e-7)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: solitary_wave(1.0), r"exponent .* at least 1.05 and at most 20, got 1"),
        (lambda: solitary_wave(float("nan")), "got nan"),
        (lambda: solitary_wave("Hertz"), "must be a number, got 'Hertz'"),
        (lambda: solitary_wave().speed(-1.0), "velocity .* at least 1e-60 .* got -1"),
        (lambda: solitary_wave().speed(1.0, mass=0.0), "mass .* at least 1e-60 .* got 0"),
        (lambda: solitary_wave().velocity.width(1.0), "level .* got 1"),
        (lambda: solitary_wave().force.crest_derivative(2), "power one"),
        (lambda: solitary_wave().force([0.0, np.inf]), "must be finite, got inf"),
        (
            lambda: WaveProfile.from_samples(np.ones(8), 6.0)([0.0, 7.0]),
            "be at most 6 beads, got 7",
        ),
        (lambda: precompressed_speed([2.0, 0.5]), "at least 1, got 0.5"),
        (lambda: long_wave_speed_constant(1.0), "above 1"),
    ],
)
def test_bad_input_is_rejected(call, said):
    with pytest.raises(hc.InputError, match=said):
        call()


def test_arguments_of_a_wave_have_units():
    wave = hc.solitary_wave()
    plain, words = (0.05, 4e-3, 7e9), ("5 cm/s", "4 g", "7 N/um^1.5")
    for name in ("speed", "peak_force"):
        method = getattr(wave, name)
        assert method(*words) == pytest.approx(method(*plain), rel=1e-14)
        assert method(words[0], *plain[1:]) == pytest.approx(method(*plain), rel=1e-14)
    for name in ("momentum", "energy"):
        method = getattr(wave, name)
        assert method(*words[:2]) == pytest.approx(method(*plain[:2]), rel=1e-14)
    with pytest.raises(hc.InputError, match="mass and stiffness must be given in SI units"):
        wave.speed("0.05 m/s")
    with pytest.raises(hc.InputError, match="velocity"):
        wave.speed("5 mm", 1e-3, 1e9)


@pytest.mark.parametrize("exponent", [1.2, 1.5, 3.0])
def test_the_velocity_that_belongs_to_a_simulated_force(exponent):
    chain = hc.Chain.uniform(100, exponent=exponent).replace(stiffness=np.full(99, 3.0))
    pulse, wave = hc.propagate(chain), hc.solitary_wave(exponent)
    velocity = wave.velocity_from_force(pulse.peak_force[80], 1.0, 3.0)
    assert velocity == pytest.approx(pulse.velocity[80], rel=1e-7)


def test_the_speed_of_spheres_grows_with_the_sixth_root_of_the_force():
    wave = solitary_wave()
    speeds = [wave.speed(wave.velocity_from_force(force)) for force in (1.0, 64.0)]
    assert speeds[1] / speeds[0] == pytest.approx(2.0, rel=1e-14)
    with pytest.raises(hc.InputError, match="force of a solitary wave must be"):
        wave.velocity_from_force(-1.0)
    with pytest.raises(hc.InputError, match="mass and stiffness must be given in SI units"):
        wave.velocity_from_force("20 N")


def test_arrays_give_the_values_of_their_elements():
    wave, forces, masses = solitary_wave(), np.array([1.0, 20.0, 64.0]), np.array([[0.5], [2.0]])
    steel = {"mass": "4.07 g", "stiffness": 7.4e9}
    found = wave.velocity_from_force(forces, masses, 3.0)
    assert found.shape == (2, 3)
    for i, mass in enumerate(masses[:, 0]):
        for j, force in enumerate(forces):
            v = wave.velocity_from_force(force, mass, 3.0)
            assert isinstance(v, float)
            assert found[i, j] == pytest.approx(v, rel=1e-15)
            for name in ("speed", "peak_force"):
                many = getattr(wave, name)(found, masses, 3.0)
                assert many[i, j] == pytest.approx(getattr(wave, name)(v, mass, 3.0), rel=1e-14)
            for name in ("momentum", "energy"):
                many = getattr(wave, name)(found, masses)
                assert many[i, j] == pytest.approx(getattr(wave, name)(v, mass), rel=1e-14)
    assert wave.peak_force(found, masses, 3.0)[1] == pytest.approx(forces, rel=1e-14)
    speeds = wave.speed(["0.1 m/s", "0.2 m/s"], **steel, diameter="10 mm")
    assert speeds[1] == wave.speed("0.2 m/s", **steel, diameter="10 mm")
    with pytest.raises(hc.InputError, match="at least 1e-60 and at most 1e[+]60, got -2"):
        wave.velocity_from_force([1.0, -2.0])
    with pytest.raises(hc.InputError, match=r"do not fit together: velocity \(2,\), mass \(3,\)"):
        wave.momentum([1.0, 2.0], [1.0, 2.0, 3.0])
