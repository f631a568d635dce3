"""Notes of fits and forecasts on data after the cap of a load cell has left its wall."""

import numpy as np
import pytest
from synthetic_traces import bench, measured

import hertzchain as hc
from hertzchain.cli.wording import on_command_line

FREE = ["stiffness", "struck_by.velocity", "time_offset"]
WORDS = "us after the impact, because walls do not pull; if it is fixed to its cell, it then"


def row(**fields):
    """Ten balls in front of a load cell, with or without a cap."""
    wall = hc.Wall("50 kN/mm", exponent=1, loss=hc.Elastic())
    return bench(hc.Viscoelastic("0.6 us"), beads=10, behind=3).replace(right_wall=wall, **fields)


@pytest.fixture(scope="module")
def leaves():
    """Time at which the cap leaves the wall."""
    return hc.simulate(row().with_cap("5 g"), until=600e-6).wall_force().first_contact_end


def note_of(result):
    found = [each for each in result.warnings if "the cap leaves the wall" in each]
    assert len(found) < 2
    return found[0] if found else ""


def fitted(duration, **clock):
    chain = row().with_cap("5 g")
    traces = measured(chain, np.random.default_rng(3), balls=(3, 6), duration=duration)
    return hc.fit(traces, chain, free=FREE, **clock)


def test_a_fit_to_later_data_states_when_the_cap_leaves_the_wall(leaves):
    note = note_of(fitted(leaves + 60e-6))
    assert f"leaves the wall {1e6 * leaves:.1f} {WORDS}" in note
    assert note.endswith("later signals are not described: fit only earlier samples")


def test_a_fit_to_earlier_data_has_no_note(leaves):
    # The record begins 4.2 us before the impact and ends before the cap leaves.
    assert note_of(fitted(leaves)) == ""


@pytest.mark.parametrize("later", [True, False])
def test_a_forecast_states_it_only_for_later_samples(leaves, later):
    end = leaves + (10e-6 if later else -10e-6)
    plan = hc.forecast(row().with_cap("5 g"), ["ball 3", "wall"], noise=0.1, interval="1 us",
                       free=FREE, until=end)  # fmt: skip
    note = note_of(plan)
    words = f"give until='{1e6 * leaves:.1f} us' or an earlier one"
    assert note.endswith(words) == later
    assert f"give --until '{1e6 * leaves:.1f} us' or" in on_command_line(words)
    assert (WORDS in note) == later


def test_a_chain_without_a_cap_has_no_note(leaves):
    plan = hc.forecast(row(), ["ball 3", "wall"], noise=0.1, interval="1 us", free=FREE,
                       until=leaves + 50e-6)  # fmt: skip
    assert note_of(plan) == ""
