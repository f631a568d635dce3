"""Help texts and messages of the command line: what they say, and in which words."""

import json

import numpy as np

import hertzchain as hc


def test_speed_is_that_of_the_pulse(run):
    command = ("pulse", "--material", "brass", "--diameter", "10 mm", "--beads", 9,
               "--speed", "0.01 m/s", "--quantity", "speed")  # fmt: skip
    code, out, _ = run(*command, "--json")
    (found,) = json.loads(out)["pulses"]
    assert code == 0
    np.testing.assert_allclose(found["speed"], 10e-3 / np.diff(found["arrival"]), rtol=1e-12)
    _, table, _ = run(*command)
    assert table.startswith("speed in m/s: 9 brass beads")
    assert f"{found['speed'][4]:.8g}" in table


def test_speeds_of_two_methods_are_compared(run):
    code, out, _ = run("pulse", "--beads", 9, "--quantity", "speed", "--method", "propagate",
                       "--method", "bca")  # fmt: skip
    chain = hc.Chain.uniform(9)
    arrivals = [method(chain).arrival for method in (hc.bca, hc.propagate)]
    errors = np.diff(arrivals[1]) / np.diff(arrivals[0]) - 1.0
    worst = np.abs(errors[1:]).max()
    assert code == 0
    assert out.splitlines()[-1].split()[:2] == ["speed", f"{worst:.2%}"]


def test_speed_without_arrivals(run):
    code, out, err = run("pulse", "--beads", 9, "--method", "hard-sphere", "--quantity", "speed")
    assert (code, out) == (2, "")
    assert "does not predict speed, only velocity, momentum and energy" in err
