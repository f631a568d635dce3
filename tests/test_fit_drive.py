"""Fits to chains with a drive, whose factor the signals determine only together with the gains."""

import numpy as np
import pytest

import hertzchain as hc

# Signals of rows with the stiffness k, the drive f and the gains g are the same as those with
# k/sqrt(c), c f and g/c: the overlaps are c times as large, at the same times.
FACTOR = 1.02
GAINS = {"ball 3": 0.02, "wall": 0.01}


@pytest.fixture(scope="module")
def chain():
    row = hc.Chain.from_materials("5 mm", "steel-52100", beads=8, right_wall=hc.Wall())
    return row.replace(drive=hc.SineBurst(20.0, 5e3, cycles=0.5, window="none"), velocities=None)


@pytest.fixture(scope="module")
def traces(chain, tmp_path_factory):
    """Signals in volts of a drive that is larger than that of the chain."""
    driven = chain.replace(drive=hc.SineBurst(20.0 * FACTOR, 5e3, cycles=0.5, window="none"))
    run = hc.simulate(driven, until=500e-6, times=501)
    signals = {"ball 3": run.sensor_force(3).force, "wall": run.wall_force().force}
    noise = np.random.default_rng(1)
    columns = [1e6 * run.times]
    for name, force in signals.items():
        columns.append(GAINS[name] * force + noise.normal(scale=1e-3, size=len(force)))
    path = tmp_path_factory.mktemp("drive") / "traces.csv"
    header = "time [us]," + ",".join(f"{name} [V]" for name in signals)
    np.savetxt(path, np.column_stack(columns), delimiter=",", header=header, comments="")
    return hc.load_traces(path, noise=1e-3)


def test_the_factor_of_a_drive_is_fitted_if_the_gains_are_known(chain, traces):
    priors = {f"gain[{name}]": (gain, 1e-4 * gain) for name, gain in GAINS.items()}
    result = hc.fit(traces, chain, free=["stiffness", "gain[*]", "drive.factor"], priors=priors)
    assert result.values["drive.factor"] == pytest.approx(FACTOR, rel=5e-4)
    assert result.values["stiffness"] == pytest.approx(1.0, rel=1e-3)
    assert result.chain.drive.amplitude == pytest.approx(20.0 * FACTOR, rel=5e-4)


def test_a_drive_that_is_taken_as_exact_is_named(chain, traces):
    priors = {f"gain[{name}]": (gain, 0.05 * gain) for name, gain in GAINS.items()}
    result = hc.fit(traces, chain, free=["stiffness", "gain[*]"], priors=priors)
    assert result.values["stiffness"] == pytest.approx(FACTOR**0.5, rel=1e-3)
    (found,) = (each for each in result.constants if each.name == "drive.factor")
    assert found.relative["stiffness"] == pytest.approx(-0.005, rel=0.02)
    assert found.relative["gain[wall]"] == pytest.approx(-0.01, rel=0.02)
    assert "drive.factor is taken as exact: 1% more changes stiffness by" in result.summary(
        width=None
    )
