"""First maxima in steep tapers, which later maxima may exceed."""

import numpy as np
import pytest

import hertzchain as hc


def later_maxima(chain):
    """Largest velocity of each bead over its first maximum, minus 1, from dense saved times."""
    pulse, end = hc.propagate(chain), hc.simulate(chain).end_time
    waits = np.diff(pulse.arrival, append=np.nan)
    waits[-1] = waits[-2]
    times = [
        np.linspace(arrival, arrival + 12.0 * wait, 300)
        for arrival, wait in zip(pulse.arrival[1:], waits[1:], strict=True)
    ]
    times = np.unique(np.concatenate([*times, np.linspace(0.0, 2.0 * end, 2000)]))
    run = hc.simulate(chain, until=float(times[-1]), times=times)
    return pulse, run.velocities.max(axis=0) / pulse.velocity - 1.0


@pytest.mark.parametrize("beads", [6, 10, 20, 40])
@pytest.mark.parametrize("rate", [0.02, 0.05, 0.1, 0.11, 0.14, 0.17, 0.2, 0.25, 0.3])
@pytest.mark.parametrize("direction", ["forward", "backward"])
def test_a_note_states_where_first_maxima_may_be_exceeded(direction, rate, beads):
    chain = hc.Chain.tapered(f"{direction}-exponential", rate, beads=beads)
    pulse, later = later_maxima(chain)
    note = pulse.notes.get("velocity", "")
    assert bool(note) == (direction == "forward" and rate > 0.1)
    # Bead 1 has no first maximum.
    exceeded = np.flatnonzero(later[1:] > 2e-4) + 2
    assert not exceeded.size or (note and exceeded.min() >= 5 and exceeded.max() < beads)
    if note:
        place = f"at beads 5 to {beads - 1}" if beads > 6 else "at bead 5"
        assert f"({place})" in note
        assert "steep forward taper" in note
        assert str(pulse).count(note) == 1
