"""Single bad samples of traces, which a fit names and does not use; the forces are from SciPy."""

import numpy as np
import pytest
from scipy_row import BEFORE, FREE, SPACING, TRUTH, chain, traces

import hertzchain as hc
from hertzchain.traces.spikes import without_spikes


def with_spike(sample, value):
    def change(columns):
        changed = columns["ball 10 [N]"].copy()
        changed[sample] = value
        return columns | {"ball 10 [N]": changed}

    return traces(change=change)


@pytest.mark.long
@pytest.mark.parametrize(("sample", "value"), [(20, 900.0), (20, 4.0), (500, 60.0)])
def test_a_spike_is_named_and_not_used(sample, value):
    result = hc.fit(with_spike(sample, value), chain(), free=FREE)
    assert result.describes
    (note,) = [each for each in result.notes if "ball 10" in each]
    assert note.startswith(f"sample {sample + 1} (at {1e6 * sample * SPACING:.3g} us) of ball 10")
    assert note.endswith("and is not used")
    signal = result.traces.shots[0].signals[1]
    assert signal.spikes == (sample,)
    assert not signal.valid[sample]
    # The noise of the traces is 0.1 N; a spike would have increased the estimate.
    assert signal.noise == pytest.approx(0.1, rel=3.0 / (2.0 * BEFORE) ** 0.5)
    deviations = [(result.values[name] - TRUTH[name]) / result.errors[name] for name in FREE]
    assert np.abs(deviations).max() < 3.5


def test_only_the_shot_with_the_spike_changes():
    both = traces(seed=1) + with_spike(20, 5.0)
    result = hc.fit(both, chain(), free=FREE)
    assert [shot.signals[1].spikes for shot in result.traces.shots] == [(), (20,)]
    assert any("sample 21 (at 14 us) of ball 10 in shot 2 differs" in each for each in result.notes)


def test_a_sample_beyond_the_range_remains_so_in_a_signal_with_a_spike():
    crest = int(np.argmax(traces().shots[0].signals[1].values))

    def change(columns):
        changed = columns["ball 10 [N]"].copy()
        changed[20], changed[crest] = 4.0, np.inf
        return columns | {"ball 10 [N]": changed}

    shot = traces(change=change).shots[0]
    (_, signal, _) = without_spikes(shot, [1e-5] * 3).signals
    assert signal.spikes == (20,)
    assert np.flatnonzero(~signal.valid).tolist() == [20, crest]
