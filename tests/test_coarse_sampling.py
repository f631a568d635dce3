"""Records with about one sample per pulse, from SciPy."""

import numpy as np
import pytest
from scipy_row import BEFORE, FREE, SPACING, chain, forces

import hertzchain as hc

pytestmark = pytest.mark.filterwarnings("ignore::hertzchain.errors.ModelRangeWarning")
# Static force that the chain has, and sensors with AC coupling do not show [N].
STATIC = 1.0


def coarse(every, static=0.0, noise=0.03):
    """One sample of ``every``, without the static force."""
    start = BEFORE % every
    columns = {}
    for name, force in forces(static=static).items():
        seen = np.concatenate((np.zeros(BEFORE), force - force[0]))[start::every]
        columns[f"{name} [N]"] = seen + np.random.default_rng(1).normal(0.0, noise, len(seen))
    times = SPACING * np.arange(len(seen)) * every
    return hc.Traces.from_arrays(times, columns, noise=noise)


def simulated(**fields):
    return hc.simulate(chain(**fields), until=700e-6, times=1401)


def test_a_pulse_of_one_sample_is_not_part_of_the_level():
    every = 50
    traces = coarse(every, STATIC)
    for signal in traces.shots[0].signals:
        assert abs(signal.level) < 0.1
    shown = simulated(precompression=STATIC, held_by="force").compare(traces).summary(width=None)
    assert "check the zero" not in shown
    assert "AC coupling of ball 5, ball 10, wall" in shown


@pytest.mark.parametrize(("every", "noted"), [(50, True), (30, True), (4, False)])
def test_few_samples_per_pulse_are_noted(every, noted):
    shown = simulated().compare(coarse(every)).summary(width=None)
    assert ("peaks and arrival times are uncertain; sample every" in shown) == noted
    if every == 50:
        assert "has about 1 sample at half of its peak" in shown


def test_a_fit_notes_few_samples_per_pulse():
    notes = hc.fit(coarse(40), chain(), free=FREE).notes
    (note,) = (each for each in notes if "at half of its peak" in each)
    assert note.startswith("the pulse at ")
    assert note.endswith("us or less")
    assert not any(
        "at half of its peak" in each for each in hc.fit(coarse(4), chain(), free=FREE).notes
    )
