"""Notes of fits and forecasts on data after the cap of a load cell has left its wall."""

import re

import click
import numpy as np
import pytest
from scipy.integrate import solve_ivp
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
    until = re.search(r"fit only earlier samples, give fit until='(\S+) us' or an earlier", note)
    assert abs(float(until[1]) - 1e6 * leaves) < 10.0
    assert f"add --until '{until[1]} us'" in on_command_line(note)


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
    command = click.Command("forecast", params=[click.Option(["--until"])])
    with click.Context(command):
        assert on_command_line(words) == f"give --until '{1e6 * leaves:.1f} us' or an earlier one"
    assert (WORDS in note) == later


def test_a_chain_without_a_cap_has_no_note(leaves):
    plan = hc.forecast(row(), ["ball 3", "wall"], noise=0.1, interval="1 us", free=FREE,
                       until=leaves + 50e-6)  # fmt: skip
    assert note_of(plan) == ""


def oscillating(count=510, seed=4):
    """Ball 4 and a bolted cell, from SciPy: its cap stays attached, so that it also pulls."""
    young, density, radius, cell, cap = 203e9, 7780.0, 5e-3, 5e7, 2e-3
    masses = np.append(np.full(9, density * 4.0 / 3.0 * np.pi * radius**3), cap)
    k = 2.0 / 3.0 * young / 0.91 * np.sqrt(np.append(np.full(8, radius / 2.0), radius))

    def forces(x, v):
        overlap, rate = np.maximum(x[:-1] - x[1:], 0.0), v[:-1] - v[1:]
        inner = k[:, None] * (overlap**1.5 + 0.9e-6 * overlap**0.5 * rate)
        return np.vstack((np.maximum(inner, 0.0), cell * x[-1:]))

    def derivatives(_, y):
        x, v = y[:10, None], y[10:, None]
        force = forces(x, v)[:, 0]
        return np.concatenate((y[10:], (np.append(0.0, force[:-1]) - force) / masses))

    start = np.append(np.zeros(10), np.append(0.2, np.zeros(9)))
    times = 0.5e-6 * np.arange(count)
    y = solve_ivp(derivatives, (0.0, times[-1]), start, "DOP853", times, rtol=1e-9, atol=1e-14,
                  max_step=2e-6).y  # fmt: skip
    force = forces(y[:10], y[10:])
    seen = np.pad([0.5 * (force[3] + force[4]), force[-1]], ((0, 0), (80, 0)))
    seen += 0.1 * np.random.default_rng(seed).standard_normal(seen.shape)
    return hc.Traces.from_arrays(
        0.5e-6 * np.arange(seen.shape[1]), {"ball 4 [N]": seen[0], "wall [N]": seen[1]}
    )


def test_a_bolted_cell_is_named_and_earlier_samples_are_described():
    wall = hc.Wall("50 kN/mm", exponent=1, loss=hc.Elastic())
    chain = hc.Chain.from_materials("5 mm", "steel-52100", beads=8).struck_by(velocity="0.2 m/s")
    chain = chain.replace(right_wall=wall, loss=hc.Viscoelastic("0.6 us")).with_cap("2 g")
    traces, free = oscillating(), [*FREE, "loss.time"]
    priors = {"struck_by.velocity": (0.2, 0.002)}
    found = hc.fit(traces, chain, free=free, priors=priors)
    assert found.explained
    assert not found.describes
    advice = found.warnings[0]
    assert advice.startswith("with only the samples before t = ")
    assert "the cap leaves the wall" in advice
    until = re.search(r"give fit until='([^']*)'", advice)[1]
    again = hc.fit(traces, chain, free=free, priors=priors, until=until)
    assert again.describes
    assert again.values["stiffness"] == pytest.approx(1.0, abs=4.0 * again.errors["stiffness"])
