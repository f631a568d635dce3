"""Words and defaults of help texts, and messages of the command line."""

import json
import re
from pathlib import Path

import click
import numpy as np
import pytest

import hertzchain as hc
from hertzchain import cli
from hertzchain.recorded_warnings import ignore_warnings


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
    assert "follows from residence times" in err


def test_methods_without_the_quantity_are_omitted(run, tmp_path):
    methods = [part for name in ("hard-sphere", "propagate", "bca") for part in ("--method", name)]
    figure = tmp_path / "speed.png"
    code, out, err = run("pulse", "--beads", 9, *methods, "--quantity", "speed", "--plot", figure)
    assert code == 0
    assert "note: hard sphere is omitted, as it does not predict the speed" in err
    assert "propagation" in out
    assert "BCA against propagation" in out
    assert "hard sphere" not in out
    assert "the last one is that to the free end" in " ".join(out.split())
    assert figure.stat().st_size > 1000


def test_a_given_quantity_is_shown_alone(run, tmp_path):
    chains = {
        "one": hc.Chain.uniform(10),
        "long": hc.Chain.tapered("forward-linear", 0.02, beads=12),
    }
    files = [tmp_path / f"{name}.csv" for name in chains]
    for file, chain in zip(files, chains.values(), strict=True):
        np.savetxt(file, chain.radii, header="radius", comments="")
    given = ("--method", "local-rate", "--quantity", "energy")
    code, out, _ = run("pulse", *files, *given)
    table = [line.split() for line in out.splitlines()]
    assert code == 0
    assert ["bead", "k", "one", "long"] in table
    assert out.count("bead k") == 1
    energies = [hc.local_rate(chain).energy for chain in chains.values()]
    rows = {each[0]: [*map(float, each[1:])] for each in table if each and each[0].isdecimal()}
    assert rows["9"] == pytest.approx([each[8] for each in energies], rel=1e-7)
    assert rows["12"] == pytest.approx([energies[1][11]], rel=1e-7)
    # By default, all quantities of each chain.
    assert run("pulse", *files, *given[:2])[1].count("bead k") == 2
    spread = hc.disorder(chains["one"], scatter=0.01).arrival_spread
    random = ("--method", "disorder", "--scatter", "1%", "--quantity", "arrival")
    out = run("pulse", files[0], *random)[1]
    assert "velocity" not in out
    assert out.count(f"{spread[7]:.3g}") >= 1
    _, out, err = run("pulse", files[0], "--method", "hard-sphere", "--method", "bca",
                      "--quantity", "arrival")  # fmt: skip
    assert "hard sphere is omitted" in err
    assert "velocity" not in out


def test_only_simulate_repeats_the_speed(run):
    words = "Repeat it to compare several."
    for command, count in (("simulate", 2), ("scatter", 0), ("app", 0)):
        assert " ".join(run(command, "--help")[1].split()).count(words) == count


def test_speeds_that_alternate_have_a_mean(run, tmp_path):
    chain = hc.Chain.dimer(radii=[1.0, 0.7], beads=30)
    pulse = hc.propagate(chain)
    # Both contacts of a cell: from one large bead to the next.
    mean = 2.0 * (chain.radii[14] + chain.radii[15]) / (pulse.arrival[16] - pulse.arrival[14])
    assert f"speed {mean:.4g} over contacts 15 and 16" in str(pulse)
    file = tmp_path / "dimer.csv"
    np.savetxt(file, chain.radii, header="radius", comments="")
    code, out, _ = run("pulse", file, "--quantity", "speed")
    assert code == 0
    note = f"alternates from bead to bead; the mean is {mean:.4g} over contacts 15 and 16"
    assert note in " ".join(out.split())
    assert "alternates" not in run("pulse", "--beads", 30, "--quantity", "speed")[1]


# For each command whose help shows defaults, arguments with which it takes at most a few seconds.
BALLS = ("--material", "steel-52100", "--diameter", "10 mm", "--beads", "3", "--speed", "0.1 m/s",
         "--wall", "same")  # fmt: skip
QUICK = {
    "calibrate": ("--taper", "forward-exponential", "--rates", "0.01,0.02,0.03"),
    "design": ("design.toml", "--dry-run"),
    "fit": (Path(hc.__file__).parent / "fitting/example/fast.csv", hc.example_experiment()[1]),
    "forecast": (
        hc.example_experiment()[1],
        "--sensor",
        "ball 6",
        "--noise",
        "0.1",
        "--interval",
        "1us",
    ),
    "pulse": BALLS[:-2],
    "reproduce": ("--only", "table1"),
    "scatter": (*BALLS, "--scatter", "1%"),
    "scoreboard": (),
    "sensitivity": BALLS,
    "sheet": (*BALLS, "--speed", "0.2 m/s", "--json"),
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
SWEEP = """
[chain]
taper = "forward-linear"
beads = 5
[axes]
rate = [0.1, 0.2]
[sweep]
keep = ["speed"]
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


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["pulse", *BALLS[:-2], "--loss", "restitution=0.9", "--method", "bca"],
         "the BCA does not support a loss; use --method simulate (chain: "),
        (["pulse", "--beads", "5", "--method", "local-rate"], "got 5; use --method propagate\n"),
        (["pulse", "--beads", "5", "--rtol", "1"], "at most 1e-05, got 1\n"),
        (["pulse", "--material", "stone", "--diameter", "9 mm"],
         "or define a custom one as [materials.NAME] in a chain file\n"),
        (["simulate", *BALLS[:-4], "--height", "0 mm"], "--height must be above 0, got '0 mm'\n"),
        (["simulate", *BALLS[:-4], "--height", "-1mm"], "--height must be above 0, got '-1mm'\n"),
        (["simulate", *BALLS, "--until", "-2 ms"], "--until must be above 0, got '-2 ms'\n"),
        (["simulate", *BALLS, "--step", "1 us"],
         "--step and --drift require --method symplectic, verlet or forward-4\n"),
        (["simulate", *BALLS, "--loss", "restitution"],
         "--loss restitution requires the value of its coefficient: write --loss"),
        (["simulate", *BALLS, "--sensor", "ball 9"],
         "there is no ball 9: the chain has 3 balls; give a number from 1 to 3\n"),
        (["scatter", *BALLS, "--relative", "1%"], "No such option '--relative'; use --scatter\n"),
        (["scatter", *BALLS, "--scatter", "2"], "got 2; for a scatter of 2%, give '2%'\n"),
        (["scatter", *BALLS, "--scatter", "1%", "--only", "7:"], "--only '7:' is outside 1 to 3\n"),
        (["sensitivity", "--beads", "5", "--to", "young"], "young is a parameter of materials"),
        (["spectrum", *QUICK["spectrum"], "--beads", "9", "--transfer", "30", "--plot", "a.png"],
         "--transfer must be a whole number from 0 to 9, where 0 and 9 are walls, got 30\n"),
        (["sweep", "sweep.toml"], "sweeps do not keep the speed of the pulse; keep residence"),
    ],
)  # fmt: skip
def test_messages_are_clear_sentences(run, tmp_path, monkeypatch, arguments, said):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "sweep.toml").write_text(SWEEP, "utf-8")
    code, out, err = run(*arguments)
    assert (code, out) == (2, "")
    assert said in err


BEADS = '[chain]\ntaper = "uniform"\nbeads = 6\n'
DRIVEN = BEADS + 'drive = {kind = "step", amplitude = 0.3}\n'
STEEL_BEADS = BEADS + 'materials = "steel-52100"\nradius = "5 mm"\n'
AT_REST = STEEL_BEADS + 'velocity = "0 m/s"\n'
RETREATING = STEEL_BEADS + 'velocity = "-1 m/s"\n'
FALLING = STEEL_BEADS + 'velocity = "0.1 m/s"\ngravity = "9.81 m/s^2"\nright_wall = {}\n'


@pytest.mark.parametrize(
    ("chain", "options", "said"),
    [
        (DRIVEN, ("simulate",), "so nothing ends the run; give --until or a right_wall\n"),
        (DRIVEN, ("pulse", "--method", "simulate"),
         "so nothing ends the run; use hertzchain simulate --until\n"),
        (AT_REST, ("simulate",), "; give it a velocity, a striker or a drive, or --until\n"),
        (AT_REST, ("pulse", "--method", "simulate"),
         "is not struck; give it a velocity, a striker or a drive\n"),
        (AT_REST, ("simulate", "--striker", "1"), "and no bead of the file moves: add --speed\n"),
        (STEEL_BEADS + "velocities = [1, 2, 0, 0, 0, 0]\n", ("pulse", "--speed", "1 m/s"),
         "beads of the chain have different velocities: change them there\n"),
        (RETREATING, ("simulate",), "; give a positive velocity, or --until\n"),
        (FALLING, ("sensitivity", "--quantity", "largest_velocity@3"),
         "under gravity has no natural end; give --until\n"),
        (FALLING, ("scatter", "--scatter", "1%", "--quantity", "largest_velocity@3"),
         "such as velocity@3, or give --until\n"),
    ],
)  # fmt: skip
def test_advice_is_about_options_that_the_command_has(run, tmp_path, chain, options, said):
    command, *more = options
    file = tmp_path / "chain.toml"
    file.write_text(chain, "utf-8")
    code, out, err = run(command, file, *more)
    assert (code, out) == (2, "")
    assert said in err


def test_scatter_of_a_driven_chain_needs_the_stop_time(run, tmp_path):
    file = tmp_path / "driven.toml"
    file.write_text(DRIVEN, "utf-8")
    command = ("scatter", file, "--scatter", "1%", "--chains", 3, "--quantity", "sensor.largest@2")
    code, out, err = run(*command)
    assert (code, out) == (1, "")
    assert "nothing ends the run; give --until or a right_wall\n" in err
    code, out, _ = run(*command, "--until", "20", "--json")
    assert code == 0
    largest = hc.simulate(hc.load_chain(file), until=20.0).sensor_force(2).largest_so_far
    assert json.loads(out)["nominal"] == pytest.approx(largest, rel=1e-7)


def test_sensitivities_at_a_stop_time_are_differences_of_runs(run, tmp_path):
    file = tmp_path / "falling.toml"
    file.write_text(FALLING, "utf-8")
    command = ("sensitivity", file, "--to", "velocities", "--until", "0.15 ms", "--json")
    code, out, _ = run(*command, "--quantity", "sensor.largest@3")
    found = json.loads(out)
    chain, step = hc.load_chain(file), 1e-4
    largest = [
        hc.simulate(chain.replace(velocities=chain.velocities * factor), until=1.5e-4)
        .sensor_force(3).largest_so_far
        for factor in (1.0 - step, 1.0, 1.0 + step)
    ]  # fmt: skip
    assert code == 0
    assert found["value"] == pytest.approx(largest[1], rel=1e-9)
    slope = (largest[2] - largest[0]) / (2.0 * step * largest[1])
    assert found["relative"][0] == pytest.approx(slope, rel=1e-5)


def test_keys_of_chain_files_are_named_where_a_chain_file_is_given(run):
    for command in (("compare", "data.csv", "chain.toml"), ("forecast", "chain.toml")):
        _, _, err = run(*command, "--beads", 5)
        assert "No such option '--beads'; in a chain FILE, write beads = ... in [chain]\n" in err
    _, _, err = run("simulate", "--beads", 100, "--defect", "50:2")
    odd = "with_defects = [{bead = ..., radius = ...}] in [chain]"
    assert f"No such option '--defect'; in a chain FILE, write {odd}\n" in err
    for command in ("plot", "export"):
        code, _, err = run("sweep", command, "a.zarr", "b.csv", "--beads", 5)
        assert code == 2
        assert "No such option '--beads'" in err
        assert "chain FILE" not in err


@pytest.mark.filterwarnings("default")
def test_unfinished_runs_name_the_option_that_sets_their_end(run, tmp_path):
    file = tmp_path / "soft.toml"
    wall = "left_wall = {}\nright_wall = {stiffness = 1e-3}\n"
    file.write_text(BEADS + wall, "utf-8")
    code, _, err = run("simulate", file, "--until", 10)
    assert code == 0
    assert (
        "(without --until, a run ends by itself when the peak is complete, at the latest at t = "
        in err
    )
    assert "because a run without --until lasts no longer" in run("simulate", file)[1]


def test_messages_of_functions_are_clear_sentences():
    chain = hc.Chain.uniform(5)
    for call, said in (
        (lambda: chain.with_scatter(1, relative=1), "got 1; for a scatter of 1%, give '1%'$"),
        (lambda: chain.with_scatter(1, relative="5"), "'5' is text; give '5%' for a percentage"),
        (lambda: chain.with_scatter(1), "^give either relative, such as 0.01, or grade, such as"),
        (lambda: hc.propagate(chain, rtol=1), "at most 1e-05, got 1$"),
        (lambda: hc.propagate(chain, rtol=1e-12), "got 1e-12; for smaller errors use hertzchain.s"),
        (
            lambda: hc.hard_sphere(chain.replace(right_wall=hc.Wall())),
            r"omit it: chain\.replace\(right_wall=None\)",
        ),
        (lambda: hc.Scatter(), "Scatter needs either radius, such as 0.01, or grade, such as 100"),
        (lambda: hc.simulate(chain, times=0).plot(), "the run has 0; give simulate times, such"),
    ):
        with pytest.raises(hc.InputError, match=said):
            call()
    assert repr(hc.propagate_many([])) == "PulseTable(0 chains of up to 0 beads)"


ROW = ("--material", "steel-52100", "--diameter", "10 mm", "--beads", "20", "--speed", "0.1 m/s",
       "--wall", "same", "--sensor", "15", "--sensor", "3")  # fmt: skip


@pytest.mark.filterwarnings("default")
def test_short_runs_state_that_the_pulse_has_not_arrived(run):
    """At 130 us, a pulse with 561.69 m/s 0.4^-0.2 0.1^0.2 = 426 m/s is in the sixth ball."""
    code, out, err = run("simulate", *ROW, "--until", "130 us")
    assert code == 0
    assert "right wall: the pulse has not arrived\n" in out
    assert "sensor in bead 15: the pulse has not arrived\n" in out
    assert "sensor in bead 3: first maximum" in out
    assert "e-" not in out.rpartition("right wall")[2]
    assert "Warning: the pulse had not reached bead 15 at t = 130 us; simulate for longer\n" in err
    assert "Warning: the pulse had not reached the right wall at t = 130 us, and up to" in err


def test_reached_at_sensors_and_walls():
    chain = hc.Chain.uniform(20).replace(right_wall=hc.Wall())
    for until, expected in ((5.0, (True, False, False)), (40.0, (True, True, True))):
        with ignore_warnings():
            run = hc.simulate(chain, until=until, times=400)
            reached = (*(run.sensor_force(k).reached for k in (2, 18)), run.wall_force().reached)
        assert reached == expected
    # A static force does not mean that the pulse has arrived.
    loaded = chain.replace(precompression=1e-3, held_by="force")
    with ignore_warnings():
        sensor = hc.simulate(loaded, until=1.0, times=50).sensor_force(18)
    assert sensor.largest_so_far == pytest.approx(1e-3)
    assert not sensor.reached
    assert "the pulse has not arrived" in repr(sensor)


def test_forces_in_front_of_a_pulse_are_not_contacts():
    """The force in front of the pulse decays double exponentially, here to 1e-150 N."""
    balls = hc.Chain.from_materials(10e-3, "steel-52100", beads=20, velocity=0.1)
    chain = balls.decorated(diameter="8 mm").replace(right_wall=hc.Wall())
    with pytest.warns(hc.IncompleteWarning, match="had not reached the right wall"):
        wall = hc.simulate(chain, until="1.17 ms", times=10).wall_force()
    assert 0.0 < wall.largest_so_far < 1e-100
    assert (wall.reached, wall.touches) == (False, 0)
    assert "the pulse has not arrived" in repr(wall)
    assert "contact with the wall" not in repr(wall)
    assert "impulse" not in repr(wall)
    with pytest.warns(hc.IncompleteWarning, match="is not complete"):
        assert hc.simulate(chain, until="1.8 ms", times=10).wall_force().touches == 1


def test_contacts_of_a_collision_of_two_balls(run):
    """Hertz: d = (5 m v^2 / (4 k))^(2/5) with m = M/2, p_0 = 2 E* sqrt(d/R) / pi, R = r/2."""
    balls = ("--material", "steel-52100", "--diameter", "10 mm", "--beads", "2", "--speed",
             "0.05 m/s", "--contacts")  # fmt: skip
    code, out, _ = run("simulate", *balls, "--json")
    document = json.loads(out)
    (contact,), (steel,) = document["contacts"], document["materials"]
    modulus = steel["young"] / (2.0 * (1.0 - steel["poisson"] ** 2))
    stiffness = 4.0 / 3.0 * modulus * np.sqrt(2.5e-3)
    mass = steel["density"] * 4.0 / 3.0 * np.pi * 5e-3**3
    overlap = (1.25 * 0.5 * mass * 0.05**2 / stiffness) ** 0.4
    pressure = 2.0 / np.pi * modulus * np.sqrt(overlap / 2.5e-3)
    assert code == 0
    assert steel["name"] == "steel-52100"
    assert contact["between"] == ["ball 1", "ball 2"]
    assert contact["stiffness"] == pytest.approx(stiffness, rel=1e-12)
    assert contact["largest_overlap"] == pytest.approx(overlap, rel=1e-9)
    ratio = pressure / (1.6 * steel["yield_strength"])
    assert contact["pressure_over_yield"] == pytest.approx(ratio, rel=1e-3)
    table = run("simulate", *balls)[1]
    assert "\nsteel-52100: 7780 kg/m^3, E = 203 GPa" in table
    assert table.rstrip().endswith(f"{contact['pressure_over_yield']:.3g}")


def test_contacts_without_a_known_yield_strength(run):
    glass = ("--material", "glass", "--diameter", "10 mm", "--beads", "3", "--speed", "0.05 m/s")
    *_, last = run("simulate", *glass, "--striker", "1", "--contacts")[1].rstrip().splitlines()
    assert last.split()[:6] == ["3", "ball", "2", "and", "ball", "3"]
    assert last.split()[-1] == "-"
    contacts = json.loads(run("simulate", "--beads", "3", "--contacts", "--json")[1])["contacts"]
    assert [each["pressure_over_yield"] for each in contacts] == [None, None]


def test_laws_and_materials_are_in_the_words_of_the_command_line(run):
    balls = (
        "--material",
        "steel-52100",
        "--diameter",
        "10 mm",
        "--beads",
        "3",
        "--speed",
        "1 cm/s",
    )
    law = "viscoelastic, restitution=0.93, speed=0.8 m/s"
    err = run("simulate", *balls, "--loss", law).stderr
    assert "--loss: viscoelastic, relaxation time 0.4185 us from the restitution" in err
    err = run("simulate", *balls, "--wall", "kryptonite").stderr
    assert "or define a custom one as [materials.NAME] in a chain file" in err
    assert "Material(" not in err
