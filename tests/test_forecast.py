"""Expected errors of planned experiments, compared with other ways to compute them."""

import json
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from synthetic_traces import bench, signals

import hertzchain as hc

RADIUS, DENSITY, YOUNG, POISSON = 5e-3, 7780.0, 203e9, 0.3
FREE = ["stiffness", "struck_by.velocity", "time_offset"]
TIMES = 2e-6 * np.arange(101)


def row():
    """Four steel balls in front of a steel wall, struck by a fifth."""
    balls = hc.Chain.from_materials(RADIUS, "steel-52100", beads=4).struck_by(velocity=0.2)
    return balls.replace(right_wall=hc.Wall())


def forces_of_row(stiffness, velocity, offset):
    """Forces in ball 2 and on the wall at `TIMES`, integrated by SciPy."""
    mass = DENSITY * 4.0 / 3.0 * math.pi * RADIUS**3
    modulus = 0.5 * YOUNG / (1.0 - POISSON**2)
    sizes = np.array([RADIUS / 2.0] * 4 + [RADIUS])
    k = stiffness * 4.0 / 3.0 * modulus * np.sqrt(sizes)

    def forces(x):
        return k * np.maximum(x - np.append(x[1:], 0.0), 0.0) ** 1.5

    def derivatives(_, y):
        force = forces(y[:5])
        return np.append(y[5:], (np.append(0.0, force[:-1]) - force) / mass)

    start = np.append(np.zeros(5), [velocity, 0.0, 0.0, 0.0, 0.0])
    span = 0.0, TIMES[-1] + 1e-6
    run = solve_ivp(
        derivatives, span, start, "DOP853", rtol=1e-10, atol=1e-16, max_step=1e-6,
        dense_output=True,
    )  # fmt: skip
    found = np.array([forces(run.sol(max(each, 0.0))[:5]) for each in TIMES - offset])
    return np.concatenate((0.5 * (found[:, 1] + found[:, 2]), found[:, 4]))


def test_covariance_is_the_inverse_of_fishers_information():
    """Derivatives are differences of signals that SciPy integrates; the velocity has a prior."""
    centre, steps = np.array([1.0, 0.2, 0.0]), np.array([1e-3, 2e-4, 1e-8])
    sigma = np.repeat([0.05, 0.2], len(TIMES))
    columns = [
        (forces_of_row(*(centre + shift)) - forces_of_row(*(centre - shift))) / (2.0 * step)
        for step, shift in zip(steps, np.diag(steps), strict=True)
    ]
    jacobian = np.column_stack(columns) / sigma[:, np.newaxis]
    information = jacobian.T @ jacobian + np.diag([0.0, 1e-4**-2, 0.0])
    plan = hc.forecast(
        row(), ["ball 2", "wall"], noise={"ball 2": 0.05, "wall": "0.2 N"}, interval="2 us",
        until="200 us", free=FREE, priors={"struck_by.velocity": (0.2, 1e-4)},
    )  # fmt: skip
    expected = np.linalg.inv(information)
    assert plan.samples == len(sigma)
    assert plan.sigmas == pytest.approx(np.sqrt(np.diag(expected)), rel=2e-3)
    sizes = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    assert plan.covariance / sizes == pytest.approx(expected / sizes, abs=2e-3)
    assert plan.correlation == pytest.approx(expected / sizes, abs=4e-3)
    frame = plan.to_dataframe()
    assert frame.relative_error["struck_by.velocity"] == pytest.approx(plan.sigmas[1] / 0.2)
    assert frame.unit.tolist() == ["", "m/s", "s"]
    assert math.isnan(frame.relative_error["time_offset"])


def test_durations_of_pulses_are_those_of_signals_that_scipy_integrates():
    expected = []
    for force in forces_of_row(1.0, 0.2, 0.0).reshape(2, -1):
        curve = CubicSpline(TIMES, force)
        turns = curve.derivative().roots(extrapolate=False)
        peak = turns[np.argmax(curve(turns))]
        halves = curve.solve(0.5 * curve(peak), extrapolate=False)
        expected.append(halves[halves > peak].min() - halves[halves < peak].max())
    given = {"noise": 0.05, "interval": "5 us", "until": "200 us", "free": FREE}
    plan = hc.forecast(row(), ["ball 2", "wall"], **given)
    assert plan.pulse_durations == pytest.approx(expected, rel=2e-3)
    assert plan.samples_per_pulse == pytest.approx(np.array(expected) / 5e-6, rel=2e-3)
    assert plan.recommended_interval == pytest.approx(min(expected) / 10, rel=2e-3)
    line = f"ball 2 {1e6 * expected[0]:.3g} us, {expected[0] / 5e-6:.0f} samples; wall"
    assert line in plan.summary(width=None)
    assert plan.as_dict()["samples_per_pulse"]["wall"] == pytest.approx(expected[1] / 5e-6, 2e-3)


def test_a_pulse_that_does_not_end_has_no_duration():
    """The last ball of a row without a wall keeps its velocity."""
    balls = row().replace(right_wall=None)
    given = {"noise": 1e-3, "interval": "1 us", "until": "200 us", "free": ["stiffness"]}
    plan = hc.forecast(balls, ["ball 4 velocity"], **given)
    assert math.isnan(plan.recommended_interval)
    assert plan.summary(width=None).splitlines()[2].endswith("ball 4 velocity not complete")
    assert plan.as_dict()["pulse_durations"] == {"ball 4 velocity": None}


def test_errors_are_proportional_to_noise_and_to_the_root_of_the_interval():
    usual = hc.forecast(row(), ["wall"], noise=0.1, interval="1 us", until="200 us", free=FREE)
    noisy = hc.forecast(row(), ["wall"], noise=0.3, interval="1 us", until="200 us", free=FREE)
    rare = hc.forecast(row(), ["wall"], noise=0.1, interval="4 us", until="200 us", free=FREE)
    assert noisy.sigmas == pytest.approx(3.0 * usual.sigmas, rel=1e-6)
    # A sum over a smooth signal is nearly its integral over the interval.
    assert rare.sigmas == pytest.approx(2.0 * usual.sigmas, rel=0.02)


def test_closed_gaps_and_the_default_record_are_noted():
    """A gap that opens a contact delays the pulse, so that velocity and gap are correlated."""
    options = {"noise": 0.1, "interval": "2 us", "free": [*FREE, "gap[2-3]"]}
    closed = hc.forecast(row(), ["ball 2", "wall"], **options)
    record, gap = (
        next(each for each in closed.notes if words in each) for words in ("record", "gap[2-3]")
    )
    assert "gap[2-3] is assumed to be closed, and its error is not that of an open gap" in gap
    duration = f"{1e6 * closed.duration:.4g} us"
    assert f"the record is assumed to end after {duration}, 1.5 times" in record
    chain = row().replace(gaps=[0.0, 0.0, 2e-6, 0.0])
    until = closed.duration
    opened = hc.forecast(chain, ["ball 2", "wall"], until=until, **options)
    assert not opened.notes
    assert opened.sigmas[3] > 1.5 * closed.sigmas[3]


def test_undetermined_parameters_keep_their_assumed_values_and_are_not_fixed_by_priors():
    """Young's modulus and Poisson's ratio affect the signals only together."""
    steel = [f"materials[steel-52100].{name}" for name in ("young", "poisson")]
    balls = hc.Chain.from_materials("5 mm", "steel-52100", beads=8).struck_by(velocity="0.1 m/s")
    plan = hc.forecast(
        balls, ["ball 3"], noise=0.1, interval="2 us", free=[*steel, "struck_by.velocity", "gain"],
        priors={"gain": (1.0, 0.05)},
    )  # fmt: skip
    assert plan.rows()[0][1] == "203 GPa (not determined)"
    (held,) = (each for each in plan.weak if each.fixed_by)
    assert str(held).endswith(f"only the prior of gain fixes them, except {steel[0]}, which is not "
                              "determined")  # fmt: skip


def test_combinations_that_the_signals_do_not_determine_have_no_error():
    """Stiffness, velocity and a gain compensate each other exactly, in the ratio 0.5 : -1 : 1."""
    free = [*FREE, "gain[wall]"]
    given = {"noise": 0.1, "interval": "1 us", "free": free}
    plan = hc.forecast(row(), ["wall"], **given)
    (weak,) = plan.weak
    assert weak.weights == pytest.approx(
        {"stiffness": -0.5, "struck_by.velocity": 1.0, "gain[wall]": -1.0}, abs=1e-3
    )
    assert [math.isinf(plan.errors[name]) for name in free] == [True, True, False, True]
    assert plan.rows()[0][1] == "1 (not determined)"
    assert plan.as_dict()["parameters"]["stiffness"]["error"] is None
    known = hc.forecast(row(), ["wall"], **given, priors={"gain[wall]": (1.0, 0.02)})
    assert known.errors["struck_by.velocity"] == pytest.approx(0.02 * 0.2, rel=0.01)
    assert known.errors["stiffness"] == pytest.approx(0.01, rel=0.03)


def test_gains_of_sensors_in_volts_are_assumed():
    given = {"noise": "1 mV", "interval": "1 us", "free": ["stiffness", "gain[wall]"]}
    assumed = hc.forecast(row(), ["wall [mV]"], **given, start={"gain[wall]": 0.01})
    newtons = hc.forecast(row(), ["wall"], **given | {"noise": 0.1})
    assert assumed.sigmas == pytest.approx(newtons.sigmas * [1.0, 0.01], rel=1e-6)
    with pytest.raises(hc.InputError, match=r"gain\[wall\] is not known: give it a prior in V/N"):
        hc.forecast(row(), ["wall [V]"], **given)
    names = {"ball 2 velocity [V]": "gain[ball 2 velocity]", "wall [V]": "gain"}
    for (sensor, name), unit in zip(names.items(), ("V s/m", "V/N"), strict=True):
        with pytest.raises(hc.InputError, match=f"is not known: give it a prior in {unit}, or"):
            hc.forecast(row(), [sensor], **given | {"free": ["stiffness", name]})


def test_constants_that_are_taken_as_exact_are_those_of_fits():
    """The density changes all masses: in these units the stiffness changes in proportion."""
    free = ["stiffness", "time_offset"]
    plan = hc.forecast(row(), ["ball 2 velocity"], noise=1e-3, interval="1 us", free=free)
    change = {each.name: each.relative["stiffness"] for each in plan.constants}
    assert change["materials[steel-52100].density"] == pytest.approx(0.01, rel=0.01)
    assert any(each.startswith("materials[steel-52100].density is") for each in plan.warnings)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"sensors": ["foo"]}, "sensors must be names such as 'ball 6'"),
        ({"sensors": ["ball 9"]}, "there is no ball 9: the chain has 4 balls"),
        ({"sensors": ["left wall"]}, "the chain has no left wall"),
        ({"sensors": []}, "there is no sensor; name at least one"),
        ({"interval": "1 s"}, "an interval of 1 s is too long for"),
        ({"interval": "1e-12 s"}, "is too short for"),
        ({"noise": {"ball 2": 0.1}}, "wall has no noise"),
        ({"noise": "1 kg"}, "must have a unit such as N"),
        ({"until": "5 us"}, "the signal of ball 2 does not exceed its noise"),
        ({"free": ["foo"]}, "unknown parameter 'foo'"),
        ({"interval": "150 us", "until": "200 us"}, "cannot be fitted to 4 samples"),
        ({"chain": hc.Chain.uniform(9)}, "the chain is in scaled variables"),
    ],
)
def test_messages(change, message):
    given = {"chain": row(), "sensors": ["ball 2", "wall"], "noise": 0.1, "interval": "1 us",
             "free": [*FREE, "lag", "highpass"]}  # fmt: skip
    with pytest.raises(hc.InputError, match=message):
        hc.forecast(**given | change)


def test_command_prints_what_the_function_returns(run):
    file = hc.example_experiment()[1]
    words = ["forecast", file, "--sensor", "ball 6", "--sensor", "wall", "--noise", "0.1",
             "--interval", "1us", "--until", "600 us", "--free", "stiffness"]  # fmt: skip
    plan = hc.forecast(
        file, ["ball 6", "wall"], noise=0.1, interval="1 us", until="600 us",
        free=["stiffness"], also_free=["time_offset", "struck_by.velocity"],
        priors={"struck_by.velocity": ("0.3 m/s", "1 mm/s")},
    )  # fmt: skip
    more = ["--also-free", "time_offset", "--also-free", "struck_by.velocity",
            "--prior", "struck_by.velocity=0.3 m/s,1 mm/s"]  # fmt: skip
    code, out, _ = run(*words, *more)
    assert code == 0
    assert plan.names == ("stiffness", "time_offset", "struck_by.velocity")
    assert out.splitlines()[:4] == plan.summary(width=None).splitlines()[:4]
    code, out, _ = run(*words, *more, "--json")
    assert json.loads(out)["parameters"] == plan.as_dict()["parameters"]
    assert run(*words[:-2], "--prior", "stiffness=1")[0] == 2


@pytest.mark.long
def test_errors_are_the_scatter_of_fits_to_noisy_signals():
    chain, noise = bench(loss=hc.Viscoelastic(0.6e-6), beads=10), 0.1
    free = [*FREE, "loss.time"]
    times, seen = signals(chain, 400e-6, 0.0, balls=(3, 6))
    names, rng, found = ("ball 3 [N]", "ball 6 [N]", "wall [N]"), np.random.default_rng(11), []
    for _ in range(40):
        noisy = seen + noise * rng.standard_normal(seen.shape)
        traces = hc.Traces.from_arrays(times, dict(zip(names, noisy.T, strict=True)), noise=noise)
        found.append(hc.fit(traces, chain, free=free, starts=1).estimates)
    plan = hc.forecast(
        chain, ["ball 3", "ball 6", "wall"], noise=noise, interval="1 us", until=times[-1],
        free=free,
    )  # fmt: skip
    # The standard deviation of 40 values has an error of 11%.
    assert np.std(found, axis=0, ddof=1) == pytest.approx(plan.sigmas, rel=0.35)


def test_a_noise_in_volts_is_that_of_a_sensor_without_calibration():
    row = hc.Chain.from_materials("5 mm", "brass", beads=8).struck_by(velocity="0.1 m/s")
    known = {"interval": "1 us", "free": ["stiffness", "gain[*]"]}
    priors = {"gain[ball 5]": ("5 mV/N", "0.1 mV/N")}
    named = hc.forecast(row, ["ball 5 [V]"], noise="2 mV", priors=priors, **known)
    short = hc.forecast(row, ["ball 5"], noise={"ball 5": "2 mV"}, priors=priors, **known)
    assert short.rows() == named.rows()
    # The gain also converts a noise in N.
    given = hc.forecast(row, ["ball 5"], noise="0.4 N", priors=priors, **known)
    assert given.rows() == named.rows()
    assert any("a noise of 0.4 N is one of 2 mV" in each for each in given.notes)
    with pytest.raises(hc.InputError, match=r"got '0.4 N'; a gain with a unit, .* without \[V\]$"):
        hc.forecast(row, ["ball 5 [V]"], noise="0.4 N", priors=priors, **known)
    with pytest.raises(hc.InputError, match=r"such as '3 mV', got 'small'$"):
        hc.forecast(row, ["ball 5 [V]"], noise="small", priors=priors, **known)
    # A gain without a unit is a factor on a signal in N.
    plain = hc.forecast(row, ["ball 5"], noise="0.4 N", priors={"gain[ball 5]": (1, 0.02)}, **known)
    assert plain.rows()[1][1].startswith("1.0")
    assert not any("recorded in V" in each for each in plain.notes)


def test_a_driven_chain_needs_a_stop_time():
    row = hc.Chain.from_materials("5 mm", "brass", beads=8, right_wall=hc.Wall())
    driven = row.replace(drive=hc.SineBurst(20.0, 5e3, cycles=0.5, window="none"), velocities=None)
    with pytest.raises(hc.InputError, match="give until"):
        hc.forecast(driven, ["wall"], noise="0.1 N", interval="1 us")


def test_a_forecast_fixes_a_time_offset_that_the_chain_file_fixes(tmp_path):
    row = hc.Chain.from_materials("5 mm", "brass", beads=8).struck_by(velocity="0.1 m/s")
    file = tmp_path / "row.toml"
    file.write_text(hc.chain_as_toml(row) + '\n[fit]\ntime_offset = "80 us"\n')
    names = hc.forecast(file, ["ball 5"], noise="0.02 N", interval="1 us").names
    assert names == ("stiffness", "struck_by.velocity")
