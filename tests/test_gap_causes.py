"""Gaps that no difference between delays of sensors shows, in data integrated by SciPy."""

from scipy_row import FREE, chain, forces, recorded, traces

import hertzchain as hc
from hertzchain.fitting.fit import fit_experiment, fitted
from hertzchain.fitting.gap_causes import cause_of, fit_of
from hertzchain.fitting.rough_gaps import gap_names, is_in_front, rough_gap, sizes_of

LAST = 15


def undiagnosed(data):
    """The fit without a gap."""
    return fit_experiment(data, chain(), lambda result, *_: result, free=FREE)


def best_of(result, names):
    """The best rough fit of a gap at one of these contacts."""
    found = [
        rough_gap(result, name, sizes_of(name, result))
        for name in gap_names(result.chain) if str(name) in names
    ]  # fmt: skip
    return min((each for each in found if each is not None), key=lambda each: each.cost)


def test_a_large_gap_in_front_of_the_first_sensor_is_found_but_not_its_size():
    result = undiagnosed(traces(gap=20e-6, behind=2))
    assert not result.describes
    gap = best_of(result, ["gap[1-2]", "gap[2-3]", "gap[3-4]"])
    assert str(gap.name) == "gap[2-3]"
    cause = cause_of(gap, fit_of(gap, fitted))
    assert cause.result.describes
    assert cause.what.startswith("gap[2-3] of at least ")
    least = float(cause.what.split()[-2])
    assert cause.what.endswith(" um")
    assert 6.0 < least < 20.0  # that of 6 um is determined, see test_flat_valleys
    assert cause.advice.startswith("check for a gap between balls 2 and 3. Larger ones only delay")
    places = [str(name) for name in gap_names(chain()) if is_in_front(name, result)]
    assert places == [f"gap[{k}-{k + 1}]" for k in range(5)]


def test_a_gap_at_the_wall_is_found():
    gap = best_of(undiagnosed(traces(gap=2e-6, behind=LAST)), ["gap[14-15]", "right_wall.gap"])
    assert str(gap.name) == "right_wall.gap"
    assert abs(gap.size - 2e-6) < 0.02e-6


def test_a_small_gap_between_two_sensors_is_found():
    signals = {name: forces(gap=0.3e-6, behind=8)[name] for name in ("ball 5", "wall")}
    data = hc.Traces.from_arrays(*recorded(signals=signals))
    gap = best_of(undiagnosed(data), [f"gap[{k}-{k + 1}]" for k in range(6, 12)])
    assert str(gap.name) == "gap[8-9]"
    assert abs(gap.size - 0.3e-6) < 0.03e-6


def test_only_a_chain_with_a_wall_has_a_gap_there():
    assert str(gap_names(chain())[-1]) == "right_wall.gap"
    assert str(gap_names(chain().replace(right_wall=None))[-1]) == "gap[14-15]"
