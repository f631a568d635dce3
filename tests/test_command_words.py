"""Words and defaults of help texts, and messages of the command line."""

import json
import re
from pathlib import Path

import click
import numpy as np
import pytest

import hertzchain as hc
from hertzchain import cli


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


# For each command whose help shows defaults, arguments with which it takes at most a few seconds.
BALLS = ("--material", "steel-52100", "--diameter", "10 mm", "--beads", "3", "--speed", "0.1 m/s",
         "--wall", "same")  # fmt: skip
QUICK = {
    "calibrate": ("--taper", "forward-exponential", "--rates", "0.01,0.02,0.03"),
    "design": ("design.toml", "--dry-run"),
    "fit": (Path(hc.__file__).parent / "fitting/example/fast.csv", hc.example_experiment()[1]),
    "pulse": BALLS[:-2],
    "reproduce": ("--only", "table1"),
    "scatter": (*BALLS, "--scatter", "1%"),
    "scoreboard": (),
    "sensitivity": BALLS,
    "simulate": BALLS,
    "spectrum": ("--material", "brass", "--diameter", "9 mm", "--precompression", "1 N"),
}
DESIGN = """
[chain]
radii = [1.0, 1.0, 1.0]
right_wall = {}
[design]
minimise = "wall_force.peak"
vary = [{radii = [0.5, 1.0]}]
"""


def shown_defaults():
    """``(command, option, value, further options)`` of all values that help texts show."""
    for name, command in cli.cli.commands.items():
        context = click.Context(command, info_name=name)
        for option in command.params:
            record = option.get_help_record(context) or ("", "")
            if found := re.search(r"\[default: (.*)\]", " ".join(record[1].split())):
                for text in found[1].split("; "):
                    condition = re.match(r"with (--\S+ \S+), (.*)", text)
                    value, more = (condition[2], condition[1].split()) if condition else (text, [])
                    value = value.split(",")[0]
                    # Other defaults are described in words.
                    if "<" not in value and (" " not in value or value == "1 m/s"):
                        yield name, option.opts[0], value, more


@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize(("command", "option", "value", "more"), [*shown_defaults()])
def test_shown_defaults_are_accepted(run, tmp_path, monkeypatch, command, option, value, more):
    if command == "app":  # which would serve its page
        cli.cli.commands["app"].make_context("app", [option, value])
        return
    monkeypatch.chdir(tmp_path)
    (tmp_path / "design.toml").write_text(DESIGN, "utf-8")
    arguments = [*QUICK[command]]
    if option in arguments:
        place = arguments.index(option)
        del arguments[place : place + 2]
    code, _, err = run(command, *arguments, *more, option, value)
    assert code in (0, 3), err
