"""Missing balls, wrong units and exchanged columns in a row with a load cell."""

from types import SimpleNamespace

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.fitting.causes import Cause
from hertzchain.fitting.diagnosis import _count_first
from hertzchain.fitting.names import Name

BEFORE, SPACING = 80, 1e-6
GAINS = {"ball 3": 0.02, "ball 6": 0.02, "wall": 0.01}
FREE = ["stiffness", "struck_by.velocity", "loss.time", "time_offset", "gain[*]"]
PRIORS = {"struck_by.velocity": (0.2, 0.002)} | {
    f"gain[{name}]": (gain, 0.05 * gain) for name, gain in GAINS.items()
}


def row(beads):
    cell = hc.Wall("50 kN/mm", exponent=1, loss=hc.Elastic())
    chain = hc.Chain.from_materials("5 mm", "steel-52100", beads=beads).struck_by(
        velocity="0.2 m/s"
    )
    return chain.replace(right_wall=cell, loss=hc.Viscoelastic("0.6 us")).with_cap("2 g")


def data(beads=10, sensors=("ball 3", "ball 6", "wall"), factor=1.0, noise=1e-3):
    """Signals in V of a row, in the columns of ball 3, ball 6 and the wall."""
    run = hc.simulate(row(beads), until=330e-6, times=331)
    # Beads are counted with the striker.
    forces = {"wall": run.forces[:, -1]} | {f"ball {k}": run.sensor(k + 1) for k in (3, 5, 6)}
    errors = noise * np.random.default_rng(6).standard_normal((3, BEFORE + 331))
    columns = {
        f"{name} [V]": factor * (np.pad(GAINS[name] * forces[seen], (BEFORE, 0)) + errors[k])
        for k, (name, seen) in enumerate(zip(GAINS, sensors, strict=True))
    }
    return hc.Traces.from_arrays(SPACING * np.arange(BEFORE + 331), columns)


def test_a_missing_ball_is_named_without_its_consequences():
    found = hc.fit(data(beads=9, noise=5e-3), row(10), free=FREE, priors=PRIORS, starts=1)
    advice = found.advice[0]
    assert found.explained
    assert advice.startswith("with one ball fewer (9), chi2 falls from ")
    assert "from its prior" not in found.summary(width=None)


def test_a_delay_that_describes_the_data_as_well_is_named_after_the_number_of_balls():
    def cause(what, chi2, count):
        result = SimpleNamespace(chi2=chi2, describes=True)
        return Cause(
            what, "add 'delay[wall]'", result, 0, count=count,
            names=() if count else (Name("delay", "wall"),),
        )  # fmt: skip

    count, delay = (
        cause("one ball fewer (9)", 1834.0, True),
        cause("delay[wall] = -22", 1831.0, False),
    )
    best, more = _count_first(delay, [delay, count])
    assert best is count
    assert "If the number is right, add 'delay[wall]': with delay[wall] = -22" in more
    # A delay that describes the data clearly better is named alone.
    count.result.chi2 = 1900.0
    assert _count_first(delay, [delay, count]) == (delay, "")


@pytest.mark.long
def test_a_ball_missing_between_two_sensors_is_named():
    found = hc.fit(data(9, ("ball 3", "ball 5", "wall")), row(10), free=FREE, priors=PRIORS)
    assert "with one ball fewer (9), between ball 3 and ball 6" in found.advice[0]


def test_a_wrong_unit_is_named_without_a_search():
    counts = []
    found = hc.fit(
        data(factor=1000.0), row(10), free=FREE, priors=PRIORS,
        progress=lambda done, _: counts.append(done),
    )  # fmt: skip
    assert found.misread
    assert found.explained
    assert "check the unit in the header of these columns" in found.advice[0]
    assert counts[-1] < 80


def test_exchanged_columns_are_named_although_the_record_ends_before_the_late_pulse():
    traces = data(sensors=("wall", "ball 6", "ball 3"))
    with pytest.warns(hc.InputWarning, match="exchanged"):
        found = hc.simulate(row(10), until=410e-6, times=2000).compare(traces)
    assert found.exchanged
