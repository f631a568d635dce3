import csv
import io
import json
import math
import os
import re
import signal
import subprocess
import sys
import time
import warnings
from pathlib import Path

import numpy as np
import pytest
from interruption import PROMPT
from scipy_chain import wall_peak

import hertzchain
from hertzchain import cli
from hertzchain.chain.tapers import TAPERS
from hertzchain.cli import progress
from hertzchain.representation import with_decimals
from hertzchain.store import streaming
from hertzchain.sweeps.methods import METHODS


@pytest.mark.parametrize(
    "command",
    [(), ("pulse",), ("simulate",), ("reproduce",), ("calibrate",), ("scoreboard",), ("cite",)],
)
def test_every_help_shows_an_example(run, command):
    code, out, _ = run(*command, "--help")
    assert code == 0
    assert "Example" in out
    assert f"hertzchain {command[0] if command else 'pulse'}" in out


def test_pulse_table(run):
    run("pulse", "--beads", 100)  # compiles, which may take long enough to show progress
    code, out, err = run("pulse", "--beads", 100)
    assert (code, err) == (0, "")
    assert "26 of 100 beads" in out
    assert "0.751472" not in out
    assert "0.751472" in run("pulse", "--beads", 100, "--all")[1]


def test_pulse_by_several_methods(run):
    code, out, _ = run(
        "pulse", "--taper", "backward-linear", "--rate", 0.5, "--beads", 12,
        "--method", "propagate", "--method", "bca", "--method", "modified-bca-printed",
        "--quantity", "energy",
    )  # fmt: skip
    assert code == 0
    assert "energy: backward-linear, S = 0.5, 12 beads" in out
    assert "modified BCA, printed against" in out


def test_pulse_by_all_methods(run):
    chain = ("pulse", "--taper", "forward-exponential", "--rate", 0.05, "--beads", 12)
    _, out, err = run(*chain, "--method", "all", "--json")
    found = [each["method"] for each in json.loads(out)["pulses"]]
    assert len(found) == len({*found}) == len(METHODS)
    assert not err
    walled = ("pulse", "--material", "steel-316", "--diameter", "10 mm", "--beads", 8,
              "--velocity", "0.001 m/s", "--wall", "same")  # fmt: skip
    code, out, err = run(*walled, "--method", "all", "--json")
    assert code == 0
    assert [each["method"] for each in json.loads(out)["pulses"]] == ["simulation"]
    assert "note: omitted, because they do not support this chain: propagate, bca," in err
    assert run(*walled, "--method", "all", "--method", "bca").returncode == 2


def test_the_error_at_a_free_end_is_stated_apart_from_that_of_the_other_beads(run):
    chain = hertzchain.Chain.tapered("forward-exponential", 0.05, beads=40)
    exact = hertzchain.propagate(chain).velocity
    errors = abs(hertzchain.modified_bca(chain).velocity / exact - 1.0)
    command = ("pulse", "--taper", "forward-exponential", "--rate", 0.05, "--beads", 40,
               "--method", "propagate")  # fmt: skip
    _, out, _ = run(*command, "--method", "modified-bca")
    assert errors[-1] > errors[1:-1].max()
    stated = f"{100.0 * errors[1:-1].max():.2f}%"
    assert (
        f"  without the last bead, at the free end:\n    velocity {stated}, momentum {stated}, "
        in out
    )
    assert "without the last bead" not in run(*command, "--method", "bca", "--beads", 2).stdout


def test_hard_spheres(run):
    code, out, err = run("pulse", "--beads", 5, "--method", "hard-sphere", "--csv")
    assert (code, err) == (0, "")
    (first, *_) = csv.DictReader(io.StringIO(out))
    assert "velocity" in first
    assert "arrival" not in first


@pytest.mark.filterwarnings("always::hertzchain.errors.InputWarning")
def test_a_warning_is_printed_once(run, tmp_path):
    file = tmp_path / "row.toml"
    file.write_text(
        '[chain]\ndiameters = ["10 mm", "8 mm"]\nmaterial = "steel-52100"\n'
        'velocity = "0.1 m/s"\nright_wall = {gap = 1}\n'
    )
    # The peak with yielding contacts is that of another chain.
    assert run("simulate", file).stderr.count("gap of the right wall is 1 m") == 1


@pytest.mark.filterwarnings("default")
def test_a_theory_out_of_its_range_warns_in_one_line(run, tmp_path):
    file = tmp_path / "chain.toml"
    file.write_text("[chain]\nradii = [1.0, 0.3, 1.0, 0.3, 1.0]\n")
    code, _, err = run("pulse", file, "--method", "bca")
    assert code == 0
    assert err.startswith("Warning: the BCA assumes one collision at a time, but bead 2")
    assert err.count("\n") == 1


def test_pulse_as_json_and_csv_is_nothing_but_data(run):
    code, out, err = run("pulse", "--beads", 5, "--method", "bca", "--json")
    assert (code, err) == (0, "")
    assert json.loads(out)["pulses"][0]["velocity"] == [1.0] * 5
    code, out, err = run("pulse", "--beads", 5, "--method", "simulate", "--csv")
    assert (code, err) == (0, "")
    assert len(list(csv.DictReader(io.StringIO(out)))) == 5


def test_pulse_from_a_file_with_a_plot(run, tmp_path):
    (tmp_path / "chain.toml").write_text("[chain]\nradii = [1, 2, 1]\n")
    code, out, _ = run("pulse", tmp_path / "chain.toml", "--plot", tmp_path / "pulse.png")
    assert code == 0
    assert "given radii, 3 beads" in out
    assert (tmp_path / "pulse.png").read_bytes().startswith(b"\x89PNG")


def test_a_plot_of_several_methods_has_their_differences(run, tmp_path):
    file = tmp_path / "pulse.svg"
    for methods, panel in ((["bca"], False), (["propagate", "bca"], True)):
        options = [each for name in methods for each in ("--method", name)]
        assert run("pulse", "--beads", 9, *options, "--plot", file)[0] == 0
        assert ("difference" in file.read_text()) is panel
    for kind in ("forward", "backward"):
        text = f'[chain]\ntaper = "{kind}-linear"\nrate = 0.01\nbeads = 9\n'
        (tmp_path / f"{kind}.toml").write_text(text)
    chains = tmp_path / "forward.toml", tmp_path / "backward.toml"
    assert run("pulse", *chains, *options, "--plot", file)[0] == 0
    texts = re.findall("<!-- (.*) -->", file.read_text())
    assert texts[-5:-1] == ["forward-linear", "backward-linear", "propagation", "BCA"]
    code, _, err = run("pulse", *chains, "--json")
    assert (code, "give one chain FILE, and run the command for each" in err) == (2, True)


def test_notes_below_a_narrow_table_have_the_width_of_the_terminal(run, monkeypatch):
    monkeypatch.setenv("COLUMNS", "100")
    *_, shown, speed = run("pulse", "--beads", 60, "--quantity", "speed")[1].splitlines()
    assert shown == "26 of 59 contacts; --all shows every one"
    assert speed.startswith("speed: the last one")
    assert speed.endswith("delays the arrival")


def test_plots_of_pulses_over_decades_are_logarithmic_unless_linear(run, tmp_path):
    file = tmp_path / "pulse.svg"
    chain = ("--taper", "backward-exponential", "--rate", 0.05, "--beads", 80, "--method", "bca")
    for options, logarithmic in (((), True), (("--log",), True), (("--linear",), False)):
        assert run("pulse", *chain, *options, "--plot", file)[0] == 0
        assert ("<!-- 0.01 -->" in file.read_text()) is logarithmic


def test_figures_have_the_width_of_a_journal(run, tmp_path):
    options = ("pulse", "--beads", 5, "--method", "bca")
    file = tmp_path / "pulse.svg"
    for width, points in (("single column", "243.7"), ("3.5", "252"), ("120 mm", "340.1")):
        assert run(*options, "--plot", file, "--width", width)[0] == 0
        assert f'width="{points}' in file.read_text()
    code, _, err = run(*options, "--plot", file, "--width", "86")
    assert (code, err.count("for mm, give '86 mm'")) == (2, 1)
    code, _, err = run(*options, "--width", "86 mm")
    assert (code, err.count("add --plot FILE")) == (2, 1)


def test_simulate_states_that_nothing_moves(run, tmp_path):
    (tmp_path / "crystal.toml").write_text(
        '[chain]\nradii = "5 mm"\nbeads = 10\nmaterials = "steel-52100"\n'
        'precompression = "20 N"\nheld_by = "force"\n'
    )
    code, out, _ = run("simulate", tmp_path / "crystal.toml", "--until", "1ms")
    assert code == 0
    assert "nothing moves, because bead 1 is not struck; give it a velocity" in out


def test_simulate(run, tmp_path):
    code, out, err = run(
        "simulate", "--beads", 10, "--until", 5, "--out", tmp_path / "run.csv",
        "--plot", tmp_path / "run.svg",
    )  # fmt: skip
    assert (code, err) == (0, "")
    assert "stopped as requested at t = 5" in out
    assert (tmp_path / "run.csv").exists()
    assert (tmp_path / "run.svg").exists()
    document = json.loads(run("simulate", "--beads", 10, "--json")[1])
    assert document["status"] == "pulse left"
    assert document["energy_drift"] < 1e-10


def test_simulate_saves_forces_and_describes_its_chain(run, tmp_path):
    balls = hertzchain.Chain.from_materials("5 mm", "steel-52100", beads=16)
    chain = balls.struck_by(velocity=0.005).replace(
        loss=hertzchain.Restitution(0.96), right_wall=hertzchain.Wall.of("brass")
    )
    (tmp_path / "chain.toml").write_text(hertzchain.chain_as_toml(chain))
    forces = tmp_path / "forces.csv"
    options = ("--sensor", "ball 10", "--forces", forces, "--json")
    code, out, _ = run("simulate", tmp_path / "chain.toml", *options)
    assert code == 0
    names = hertzchain.load_traces(forces).names
    assert names == ("ball 10", "wall")
    document = json.loads(out)
    assert document["hertzchain_version"] == hertzchain.__version__
    assert document["impact_velocity"] == 0.005
    assert document["walls"][0]["material"] == "brass"
    assert document["chain_file"]["chain"]["loss"]["coefficient"] == 0.96
    assert hertzchain.load_traces(forces).shots[0].signals[1].values.max() == pytest.approx(
        document["walls"][0]["peak"], rel=1e-3
    )
    code, _, err = run("simulate", "--beads", 5, "--forces", forces)
    assert (code, "--forces requires a force: add --sensor" in err) == (2, True)


def test_an_interrupted_stream_resumes_when_repeated(run, tmp_path, monkeypatch):
    saved = []

    def interrupt(*arguments):
        saved.append(arguments)
        if len(saved) == 3:
            raise KeyboardInterrupt
        write_bytes(*arguments)

    write_bytes = streaming.write_bytes
    # Ten times a file.
    monkeypatch.setattr(streaming, "FILE_SIZE", 10 * 8 * (3 * 12 + 1))
    monkeypatch.setattr(streaming, "write_bytes", interrupt)
    command = ["simulate", "--beads", 12, "--until", 40, "--times", 81, "--stream"]
    code, out, err = run(*command, tmp_path / "long")
    assert (code, out) == (130, "")
    assert "run the same command again to resume" in err
    first = streaming.StoredRun(tmp_path / "long").load()
    assert 0 < first.sizes["time"] <= 20

    monkeypatch.setattr(streaming, "write_bytes", write_bytes)
    code, out, err = run(*command, tmp_path / "long")
    assert (code, err) == (0, "")
    assert "81 times up to t = 40 in" in out
    stored = streaming.StoredRun(tmp_path / "long")
    whole = hertzchain.simulate(hertzchain.Chain.uniform(12), until=40.0, times=81)
    np.testing.assert_array_equal(stored.load().time, whole.times)
    np.testing.assert_array_equal(stored.load().velocity, whole.velocities)
    document = json.loads(run(*command, tmp_path / "long", "--json")[1])
    assert document["files"] == len(stored.files) > 3
    assert document["saved_times"] == 81


@pytest.mark.long
def test_reproduce_a_part(run, tmp_path):
    code, out, err = run("reproduce", "--only", "table3,figure6", "--out", tmp_path)
    assert (code, err) == (0, "")
    assert "20 of 20 table entries" in out
    assert (tmp_path / "report.html").exists()
    code, out, _ = run("reproduce", "--only", "table3", "--out", tmp_path, "--json")
    assert json.loads(out)["within_tolerance"] is True


def test_reproduce_leaves_with_3_outside_tolerance(run, tmp_path):
    code, out, _ = run(
        "reproduce", "--only", "table1", "--out", tmp_path, "--window-exponential", "20:40"
    )
    assert code == 3
    assert "outside tolerance: table1" in out


def test_cite(run):
    code, out, _ = run("cite")
    assert f"granular chains, version {hertzchain.__version__}," in out
    assert code == 0
    assert "arXiv:1307.1191" in out
    package = Path(hertzchain.__file__).parent
    sources = [*package.glob("theory/*.py"), *package.glob("chain/laws/*.py")]
    text = " ".join(file.read_text(encoding="utf-8") for file in sources)
    cited = set(re.findall(r"doi:(10[^\s;]+[^\s;.,)])", text))
    assert len(cited) >= 10
    assert not [doi for doi in cited if doi not in out]


@pytest.mark.parametrize(
    "page",
    [
        "how-to/defects.md",
        "how-to/interfaces.md",
        "how-to/localisation.md",
        "explanation/disorder.md",
    ],
)
def test_cite_has_the_literature_of_the_pages(page, run):
    text = (Path(__file__).parents[1] / "docs" / page).read_text(encoding="utf-8")
    cited = re.findall(r"(?:doi\.org|arxiv\.org/abs)/([^)]+)\)", text)
    assert cited
    assert not [name for name in cited if name not in run("cite")[1]]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["pulse", "--taper", "backward-exponential", "--rate", "1.5"], "between 0 and 1, got 1.5"),
        (["pulse", "--taper", "forward-linear", "--rate", "0.01", "--beads", "101"],
         "at most 100 beads"),
        (["pulse", "--taper", "backward-linear"], "requires --rate"),
        (["pulse", "--taper", "uniform", "--rate", "1"], "--rate cannot be used"),
        (["pulse", "--rate", "1"], "--rate requires --taper"),
        (["pulse", "--taper", "sideways", "--rate", "1"], "unknown taper 'sideways'"),
        (["pulse", "--beads", "1"], "at least 2"),
        (["pulse", "--beads", "2.5"], "not a valid integer"),
        (["pulse", "--beads", "1000000000000000"], "beads need 372529029.8 GiB of memory"),
        (["pulse", "--method", "bcaa"], "did you mean 'bca'"),
        (["pulse", "--taper", "fwd-exp"], "(did you mean 'forward-exponential'?)"),
        (["simulate", "--diamter", "1"], "'--diamter'. Did you mean '--diameter'? "),
        (["pulse", "--quantity", "sped"], "unknown quantity 'sped'"),
        (["pulse", "--quantity", "arrival_spread"], "arrival_spread requires --method disorder"),
        (["pulse", "--json", "--csv"], "cannot be combined"),
        (["pulse", "--plot", "pulse.doc"], "must end in .png, .svg or .pdf"),
        (["pulse", "missing.toml"], "cannot read chain file 'missing.toml'"),
        (["pulse", "0.9", "--beads", "3"], "not both; '0.9' is read as FILE"),
        (["pulse", "--method", "modified-bca"],
         "use --method bca or --method two-thirds-bca for other chains"),
        (["simulate", "--until", "-1"], "until must be above 0"),
        (["simulate", "--rtol", "1"], "rtol must be at least 1e-14 and at most 1e-06"),
        (["simulate", "--out", "run.xls"], "must end in .nc or .csv"),
        (["reproduce", "--only", "tabel1"], "did you mean 'table1'"),
        (["reproduce", "--window-linear", "5-60"], "must look like 5:60"),
        (["reproduce", "--only", ","], "parts must be a list of at least one"),
        (["simulate", "--times", "0", "--out", "run.csv"], "--times 0 is too few"),
        (["pulse", "--plot", "nowhere/pulse.png"], "the folder nowhere does not exist"),
        (["pulse", "--method", "bca", "--method", "hard-sphere", "--quantity", "peak_time"],
         "BCA does not predict peak_time"),
        (["reproduce", "--window-linear", "60:5", "--only", "table3"], "window 60..5"),
        (["reproduce", "--out", "/proc/nowhere"], "cannot write '/proc/nowhere'"),
        (["calibrate", "--taper", "forward-linaer"], "did you mean 'forward-linear'"),
        (["calibrate", "--rates", "0.1"], "requires exactly one --taper"),
        (["calibrate", "--taper", "forward-linear", "--rates", "a"],
         "--rates must be a number or a percentage such as '5%', got 'a'"),
        (["calibrate", "--taper", "forward-linear", "--rates", "1%,"], "must look like 0.01,0.02"),
        (["pulse", "--taper", "forward-linear", "--rate", "much"],
         "--rate must be a number or a percentage such as '5%', got 'much'"),
        (["pulse", "--taper", "forward-linear", "--rate", "5 mm"], "must have no unit, got 'mm'"),
        (["pulse", "--taper", "forward-exponential", "--rate", "150%"], "0 and 1, got 1.5"),
        (["simulate", "--rtol", "1%"], "rtol must be at least 1e-14 and at most 1e-06, got 0.01"),
        (["simulate", "--drift", "nan"], "--drift must be finite, got nan"),
        (["calibrate", "--taper", "forward-linear", "--rates", "0.5"], "reach zero at bead"),
        (["calibrate", "--taper", "forward-exponential", "--rates", "0.1"], "at least 3 different"),
        (["calibrate", "--window", "5-80"], "must look like 5:60"),
        (["calibrate", "--window", "5:100"], "the last one is a free end"),
        (["calibrate", "--out", "constants.json"], "must end in .toml"),
        (["calibrate", "--out", "nowhere/constants.toml"], "the folder nowhere does not exist"),
        (["scoreboard", "--quantity", "speed"], "unknown quantity 'speed'"),
        (["scoreboard", "--first-bead", "98", "--plot", "s.png"], "a whole number from 2 to 97"),
        (["scoreboard", "--plot", "s.gif"], "must end in .png"),
        (["simulate", "--stream", "long"], "--stream requires --until"),
        (["simulate", "--stream", "long", "--until", "-1"], "until must be above 0, got -1"),
        (["simulate", "--stream", "long", "--until", "9", "--times", "1"], "--times 1 is too few"),
        (["simulate", "--stream", "long", "--until", "9", "--out", "a.nc"],
         "--stream and --out cannot be combined"),
        (["simulate", "--stream", "long", "--until", "9", "--max-steps", "9"],
         "--stream and --max-steps cannot be combined"),
        (["simulate", "--stream", "long", "--until", "9", "--sensor", "3"],
         "--stream and --sensor cannot be combined"),
        (["simulate", "--sensor", "101"], "--sensor must be a whole number from 1 to 100, got 101; "
         "or give a name: 'ball 11', 'last' or 'wall'"),
        (["simulate", "--material", "brass", "--diameter", "9 mm", "--striker", "100g, flat, 5"],
         "has 5 flat strikers, of which one strikes at most: omit the number, or write its unit, "
         "such as '5 mm'"),
        (["simulate", "--sensor", "3", "--times", "0"], "--times 0 is too few"),
        (["simulate", "--stream", "/dev/null", "--until", "9"], "'/dev/null' is a file"),
        (["scatter", "--beads", "5", "--quantity", "mas"], "unknown quantity 'mas'"),
        (["hammer"], "unknown command 'hammer' (did you mean simulate with --striker?): choose"),
        (["recite"], "unknown command 'recite' (did you mean 'cite'?): choose from app, "),
        (["simulat"], "did you mean 'simulate'"),
        (["scatter", "--beads", "9", "--grade", "10"], "give a material and sizes, or --scatter"),
        (["simulate", "--material", "brass", "--diameter", "9 mm", "--speed", "fast"],
         "text with a unit such as '5 m/s', got 'fast'"),
    ],
)  # fmt: skip
def test_bad_input_gets_one_sentence_and_code_2(run, tmp_path, monkeypatch, arguments, said):
    monkeypatch.chdir(tmp_path)
    code, out, err = run(*arguments)
    assert code == 2
    assert out == ""
    assert said in err.replace("\n", " ")
    assert "Traceback" not in err
    assert [p for p in tmp_path.rglob("*") if p.is_file()] == []


def test_a_run_that_cannot_finish_has_failed(run):
    code, out, err = run("simulate", "--beads", 50, "--max-steps", 10)
    assert (code, out) == (1, "")
    assert "stopped by the step limit" in err


def test_interrupt_leaves_with_130(tmp_path):
    walls = "left_wall = {}\nright_wall = {}\n"
    (tmp_path / "walls.toml").write_text('[chain]\ntaper = "uniform"\nbeads = 200\n' + walls)
    environment = os.environ | {"PYTHONUNBUFFERED": "1"}
    command = [sys.executable, "-c", "from hertzchain.cli import main; main()"]
    process = subprocess.Popen(
        [*command, "simulate", "walls.toml", "--until", "1e6", "--max-steps", "1000000000"],
        cwd=tmp_path,
        env=environment,
        stderr=subprocess.PIPE,
        text=True,
    )
    time.sleep(6.0)
    process.send_signal(signal.SIGINT)
    started = time.monotonic()
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130
    assert time.monotonic() - started < PROMPT
    assert "Traceback" not in err


def test_calibrate_compares_with_the_paper(run):
    code, out, err = run("calibrate", "--taper", "forward-exponential")
    assert (code, err) == (0, "")
    assert re.search(r"d0 +5\.\d+ +\d\.\d+ +11\.1", out)
    assert "q = 0.06" in out
    assert "forward-linear" not in out


def test_calibrate_writes_what_make_calibrate_keeps(run, tmp_path):
    code, out, _ = run("calibrate", "--out", tmp_path / "constants.toml", "--json")
    assert code == 0
    document = json.loads(out)
    assert document["schema_version"] == 1
    assert [result["taper"] for result in document["calibrations"]] == list(TAPERS)
    stored = Path(hertzchain.__file__).parent / "theory" / "calibrated.toml"
    assert (tmp_path / "constants.toml").read_text("utf-8") == stored.read_text("utf-8")


def test_warm_up_as_json_has_the_version_of_all_documents(run, monkeypatch):
    monkeypatch.setattr(hertzchain, "warm_up", lambda **_: 1.5)
    code, out, _ = run("warm-up", "--json")
    assert (code, json.loads(out)) == (0, {"schema_version": 1, "seconds": 1.5, "warnings": []})


def test_scoreboard(run, tmp_path):
    code, out, err = run("scoreboard", "--plot", tmp_path / "board.svg")
    assert (code, err) == (0, "")
    (row,) = (line.split() for line in out.splitlines() if "waist" in line)
    # The modified BCA does not support it, the law does.
    assert row[-2] == "–"
    assert float(row[-1]) < 0.1
    (row,) = (line for line in out.splitlines() if "q = 0.12..0.3" in line)
    assert row.count("*") == 2
    assert "52 chains" in out
    assert (tmp_path / "board.svg").stat().st_size > 10_000


def test_scoreboard_of_every_chain_by_its_mean(run):
    code, out, _ = run("scoreboard", "--all", "--rms", "--quantity", "arrival", "--first-bead", 2)
    assert code == 0
    assert "arrival: rms relative error" in out
    assert "forward-exponential, q = 0.03" in out


def test_scoreboard_as_json_is_nothing_but_data(run):
    code, out, err = run("scoreboard", "--json")
    assert (code, err) == (0, "")
    document = json.loads(out)
    assert document["schema_version"] == 1
    assert document["last_bead"] == 97
    assert len(document["rows"]) == 52


def test_two_beads_can_be_compared(run):
    code, out, _ = run("pulse", "--beads", 2, "--method", "propagate", "--method", "bca")
    assert code == 0
    assert "BCA against" in out


@pytest.mark.parametrize("simulation", ["propagate", "simulate"])
def test_theories_are_compared_with_the_simulation_whatever_the_order(run, simulation):
    names = {"propagate": "propagation", "simulate": "simulation"}
    methods = ("--method", "bca", "--method", simulation, "--method", "local-rate")
    shown = run("pulse", "--beads", 9, *methods).stdout
    found = re.findall(r"^(.+) against (.+?), uniform", shown, re.MULTILINE)
    assert found == [("BCA", names[simulation]), ("local-rate law", names[simulation])]
    # Output for other programs has the order of the options.
    rows = json.loads(run("pulse", "--beads", 9, *methods, "--json").stdout)["pulses"]
    assert [each["method"] for each in rows] == ["BCA", names[simulation], "local-rate law"]
    # Without a simulation, the first is the reference.
    shown = run("pulse", "--beads", 9, "--method", "local-rate", "--method", "bca").stdout
    assert "BCA against local-rate law, uniform" in shown


@pytest.mark.long
def test_a_closed_pipe_is_no_failure_of_ours():
    script = "from hertzchain.cli import main; main()"
    done = subprocess.run(
        f'"{sys.executable}" -c "{script}" pulse --beads 400 --csv | head -1',
        shell=True,
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.startswith("method,bead")
    assert "Traceback" not in done.stderr


def test_progress_in_a_pipe_is_a_line_now_and_then(run, monkeypatch):
    monkeypatch.setattr(progress, "SECONDS_PER_LINE", 0.0)
    code, out, err = run("simulate", "--beads", 400, "--json")
    assert code == 0
    assert json.loads(out)["status"] == "pulse left"
    assert "beads passed: 400 of 400" in err


def test_progress_that_does_not_change_is_one_line(monkeypatch, capsys):
    monkeypatch.setattr(progress, "SECONDS_PER_LINE", 0.0)
    update = progress._Lines("chains", None)
    for done in (0, 0, 0, 3, 3, 5):
        update(done, 5)
    assert capsys.readouterr().err == "chains: 0 of 5\nchains: 3 of 5\nchains: 5 of 5\n"


def test_work_that_ends_early_states_its_total(monkeypatch, capsys):
    monkeypatch.setattr(progress, "SECONDS_PER_LINE", 0.0)
    with progress.progress_bar("simulations") as update:
        update(400, 418)
        update.interval = 1e9
        update(417, 418)
    assert capsys.readouterr().err == "simulations: 400 of 418\nsimulations: 417 in total\n"
    monkeypatch.setattr(progress, "SECONDS_PER_LINE", 1e9)
    with progress.progress_bar("simulations") as update:
        update(417, 418)
    assert capsys.readouterr().err == ""


def test_a_total_that_is_not_known_is_not_stated(monkeypatch, capsys):
    monkeypatch.setattr(progress, "SECONDS_PER_LINE", 0.0)
    with progress.progress_bar("simulations", counted=False) as update:
        update(400, 0)
        update.interval = 1e9
        update(417, 0)
    assert capsys.readouterr().err == "simulations: 400\nsimulations: 417 in total\n"


def test_lines_of_progress_become_rare(monkeypatch, capsys):
    now = 0.0
    monkeypatch.setattr(progress.time, "monotonic", lambda: now)
    update = progress._Lines("chains", None)
    for done in range(3600):
        now = float(done)
        update(done, 3600)
    lines = capsys.readouterr().err.splitlines()
    shown = [10, 30, 70, 150, 310, 610, *range(910, 3600, 300)]
    assert lines == [f"chains: {done} of 3600" for done in shown]


def test_the_last_line_of_progress_states_the_total(capsys):
    update = progress._Lines("chains", None)
    update(22, 23)
    update(23, 23)
    assert capsys.readouterr().err == ""
    update.interval = 0.0
    update(22, 23)
    update.interval = 1e9
    update(23, 23)
    update(23, 23)
    assert capsys.readouterr().err == "chains: 22 of 23\nchains: 23 of 23\n"


@pytest.mark.filterwarnings("default::hertzchain.ModelRangeWarning")
def test_a_chain_in_si_units_is_shown_in_si_units(run, tmp_path):
    beads = "\n".join(["diameter [mm],material", *["10,steel-52100"] * 60])
    (tmp_path / "balls.csv").write_text(beads)
    code, out, _ = run("pulse", "--chain", tmp_path / "balls.csv", "--json")
    assert code == 0
    document = json.loads(out)
    assert document["chain"]["units"] == "SI"
    # Published for these balls and 1 m/s: 209.121 N.
    assert document["pulses"][0]["peak_force"][50] == pytest.approx(209.121, rel=1e-5)
    _, out, err = run("pulse", tmp_path / "balls.csv")
    # Balls of hardened steel yield at 0.4 m/s.
    assert err.startswith("Warning: propagation: pressure / yield is 1.4 at contact 1")
    assert "m/s or use --method simulate --loss elastic-plastic" in err
    assert "[m/s]" in out
    assert "[N]" in out


def test_what_a_method_does_not_cover_is_bad_input(run, tmp_path):
    (tmp_path / "c.toml").write_text('[chain]\ntaper = "uniform"\nbeads = 5\ngravity = 1.0\n')
    code, out, err = run("pulse", "--chain", tmp_path / "c.toml")
    assert (code, out) == (2, "")
    assert "propagate does not support gravity" in err


def test_a_chain_is_given_once(run):
    code, _, err = run("pulse", "a.toml", "--chain", "b.toml")
    assert code == 2
    assert "not both" in err


def test_the_speed_of_a_file_can_be_replaced(run, tmp_path):
    """The force of an elastic chain grows with velocity^1.2."""
    file = tmp_path / "chain.toml"
    chain = '[chain]\ndiameters = "8 mm"\nmaterials = "steel-52100"\nbeads = 8\n'
    file.write_text(chain + '[[chain.struck_by]]\nvelocity = "0.2 m/s"\n[chain.right_wall]\n')
    peaks = [
        json.loads(run("simulate", file, *speed, "--json")[1])["walls"][0]["peak"]
        for speed in ([], ["--speed", "0.1 m/s"])
    ]
    assert peaks[1] / peaks[0] == pytest.approx(0.5**1.2, rel=1e-9)
    code, _, err = run("simulate", file, "--speed", "0.1")
    assert code == 2
    assert "has no unit" in err
    file.write_text(chain + '[chain.drive]\nkind = "step"\namplitude = 1.0\nrise = 1e-4\n')
    code, _, err = run("simulate", file, "--until", "1 ms", "--speed", "0.1 m/s")
    assert code == 2
    assert "has a drive: change the drive, or remove it\n" in err


def test_a_chain_with_a_wall_is_reported_with_units(run, tmp_path):
    file = tmp_path / "chain.toml"
    file.write_text(
        '[chain]\nradii = 5e-3\nmaterials = "steel-52100"\nbeads = 8\nvelocity = 0.05\n'
        "[chain.right_wall]\n"
    )
    code, out, _ = run("simulate", file, "--budget")
    assert code == 0
    assert ", since no larger force on the right wall can follow\n" in out
    assert "right wall: peak " in out
    assert "energy [J]" in out
    assert "momentum [N s]" in out


def test_simulate_prints_the_budget_as_json(run):
    code, out, _ = run("simulate", "--beads", "10", "--budget", "--json")
    assert code == 0
    budget = json.loads(out)["budget"]
    # The energy and momentum of a bead of mass and velocity 1, in a chain without walls.
    for of, given in (("energy", 0.5), ("momentum", 1.0)):
        assert sum(budget[of]["location"].values()) == pytest.approx(given, abs=1e-8)
        assert sum(budget[of]["origin"].values()) == pytest.approx(given, abs=1e-12)


def test_simulate_prints_the_budget(run):
    code, out, _ = run("simulate", "--beads", "10", "--budget")
    assert code == 0
    assert "scattered back" in out
    assert "adds up within" in out
    assert "energy  " in out
    code, _, err = run("simulate", "--beads", "10", "--times", "1", "--budget")
    assert code == 2
    assert "require saved times" in err


@pytest.mark.parametrize("only", ["", ",", "table9"])
def test_a_part_that_is_not_there_leaves_no_folder(run, tmp_path, only):
    code, _, err = run("reproduce", "--only", only, "--out", tmp_path / "report")
    assert code == 2
    assert "table1" in err
    assert not (tmp_path / "report").exists()


def test_a_quantity_of_contacts_has_one_row_per_contact(run):
    command = ("pulse", "--method", "propagate", "--method", "bca", "--quantity", "peak_force")
    _, out, _ = run(*command, "--beads", 12)
    table = out.partition("BCA against")[0]
    assert "contact k" in table
    rows = [line.split() for line in table.splitlines() if line.strip()[:1].isdigit()]
    assert [row[0] for row in rows] == [str(k) for k in range(1, 12)]
    assert all(len(row) == 3 for row in rows)


def test_verify_nothing(run):
    code, _, err = run("verify", "--only", ",")
    assert code == 2
    assert "groups must contain" in err


def test_a_stray_quotation_mark_is_no_number(run, tmp_path):
    (tmp_path / "beads.csv").write_text('radius\n1\n"1\n1\n')
    code, _, err = run("pulse", tmp_path / "beads.csv", "--method", "bca")
    assert code == 2
    assert "check its quotation marks" in err


EXPERIMENT = """[chain]
radii = [5e-3, 5e-3, 5e-3, 5e-3]
materials = "steel-52100"
velocity = 0.2
[chain.right_wall]
"""


@pytest.mark.filterwarnings("ignore::hertzchain.errors.IncompleteWarning")
@pytest.mark.parametrize("times", [0, 101])
def test_a_run_that_ends_during_a_contact_with_the_wall_says_so(run, tmp_path, times):
    file = tmp_path / "row.toml"
    row = hertzchain.Chain.uniform(3).replace(right_wall=hertzchain.Wall())
    arrival = hertzchain.simulate(row).wall_force().peak_time
    for chain, until, said in (
        (row, arrival, True), (row, 4.0 * arrival, False),
        # Static forces never let go of the wall.
        (row.replace(left_wall=hertzchain.Wall(), precompression=0.5), arrival, False),
    ):  # fmt: skip
        file.write_text(hertzchain.chain_as_toml(chain))
        code, out, _ = run("simulate", file, "--until", until, "--times", times)
        assert code == 0
        assert "impulse " in out
        assert ("in the whole run, which ends during a contact" in out) == said, chain


def test_simulate_prints_what_walls_and_sensors_felt(run, tmp_path):
    file, picture = tmp_path / "experiment.toml", tmp_path / "forces.svg"
    file.write_text(EXPERIMENT)
    command = ("simulate", file, "--until", "300 us", "--times", "101", "--sensor", "2")
    code, out, err = run(*command, "--sensor", "3", "--plot", picture)
    assert (code, err) == (0, "")
    felt = hertzchain.simulate(hertzchain.load_chain(file), until=3e-4, times=101)
    wall, sensor = felt.wall_force(), felt.sensor_force(3)
    peak = f"right wall: peak {wall.peak:.5g} N at t = {1e6 * wall.peak_time:.5g} us"
    assert f"{peak}; no larger force follows\n" in out
    impulse = f"{1e3 * wall.impulse_of_impact:.4g} mN s in the impact (1 contact with the wall)"
    assert f"  impulse {impulse}\n" in out
    lasts = 1e6 * wall.impulse_of_impact / wall.peak
    assert f"  duration of the impact (impulse / peak) {lasts:.4g} us\n" in out
    first, time = sensor.first_maximum, sensor.first_maximum_time
    told = f"sensor in bead 3: first maximum {first:.5g} N at t = {1e6 * time:.5g} us"
    assert sensor.largest_so_far_time == time
    assert f"{told}, the largest so far\n" in out
    drawn = picture.read_text()
    assert all(f"<!-- {name} -->" in drawn for name in ("bead 2", "bead 3", "right wall"))
    document = json.loads(run(*command, "--json")[1])
    assert document["walls"][0].pop("material") == "steel-52100"
    for name, value in document["walls"][0].items():
        assert value == getattr(wall, name)
    assert {"peak", "complete", "largest_so_far", "bound", "duration"} < document["walls"][0].keys()
    assert document["sensors"][0]["largest_so_far"] == felt.sensor_force(2).largest_so_far
    assert document["sensors"][0]["bead"] == 2


def test_simulate_states_the_largest_error_of_forces_in_sensors(run, tmp_path):
    file = tmp_path / "lossy.toml"
    file.write_text(EXPERIMENT + '[chain.loss]\nlaw = "restitution"\ncoefficient = 0.9\n')
    code, out, err = run("simulate", file, "--until", "300 us", "--times", "81", "--sensor", "3")
    assert code == 0, err
    sensor = hertzchain.simulate(hertzchain.load_chain(file), until=3e-4, times=81).sensor_force(3)
    assert f"(error at most {sensor.error:.2g} N, from 81 saved times)" in out


@pytest.mark.filterwarnings("ignore::hertzchain.IncompleteWarning")
def test_simulate_says_that_a_held_chain_may_hit_the_wall_harder_later(run, tmp_path):
    file = tmp_path / "experiment.toml"
    file.write_text(EXPERIMENT + "[chain.left_wall]\n")
    code, out, _ = run("simulate", file)
    assert code == 0
    assert "the impact on the right wall has ended at t = " in out
    assert "the beads can return to the wall, and a later impact may be stronger\n" in out
    line = next(line for line in out.splitlines() if line.startswith("right wall: "))
    assert line.startswith("right wall: peak so far ")
    assert line.endswith("; a later impact may be stronger")
    assert "is complete" not in out
    assert "can exceed" not in out


def test_simulate_says_what_a_wall_has_not_felt(run, tmp_path):
    file = tmp_path / "experiment.toml"
    file.write_text(EXPERIMENT)
    told = "Warning: the peak of the force on the right wall is not complete"
    with warnings.catch_warnings():
        warnings.simplefilter("always", hertzchain.IncompleteWarning)
        for until in ("90us", "60us"):
            command = ("simulate", file, "--until", until)
            code, early, err = run(*command, "--plot", tmp_path / "map.svg")
            assert (code, err.count(told)) == (0, 1)
            assert "right wall: peak not complete, largest so far " in early
            force = hertzchain.simulate(hertzchain.load_chain(file), until=until).wall_force().force
            falling = force[-1] < force.max()
            words = (", a maximum from which the force has fallen; up to ",
                     ", where the force is still rising; up to ")  # fmt: skip
            assert [each in early and each in err for each in words] == [falling, not falling]
        document = json.loads(run(*command, "--json")[1])
        assert document["walls"][0]["peak"] is None
        assert document["walls"][0]["complete"] is False
        file.write_text(EXPERIMENT + "gap = 0.03\n")
        assert (
            "right wall: the pulse has not arrived" in run("simulate", file, "--until", "10 us")[1]
        )
    assert json.loads(run("simulate", "--beads", 3, "--json")[1])["walls"] == []


def test_command_line_lists_waves(run):
    code, out, _ = run("simulate", "--beads", 40, "--until", 60, "--waves")
    assert code == 0
    assert "waves: 1 to the right, 0 to the left" in out
    assert "1..39" in out
    chain = ("--material", "steel-52100", "--diameter", "10 mm", "--beads", 20, "--wall", "same")
    si = ("simulate", *chain, "--speed", "0.1 m/s", "--until", "1 ms", "--waves")
    out, found = run(*si).stdout, json.loads(run(*si, "--json").stdout)["waves"]
    assert "times [us]" in out
    assert "width [us]" in out
    first = found[0]
    assert f"{1e6 * first['first_time']:#.4g}..{1e6 * first['last_time']:#.4g} " in out
    assert f" {1e6 * first['width']:#.4g} " in out
    code, out, _ = run("simulate", "--beads", 40, "--until", 60, "--waves", "--json")
    (wave,) = json.loads(out)["waves"]
    assert wave["direction"] == "right"
    assert wave["momentum"] == pytest.approx(1.1383, abs=1e-3)
    assert wave["resolved"] is True
    code, _, err = run("simulate", "--beads", 40, "--until", 60, "--times", 60, "--waves")
    assert code == 2
    assert re.search(r"--times \d+ is enough", err)
    code, _, err = run("simulate", "--beads", 40, "--stream", "x", "--until", 9, "--waves")
    assert code == 2
    assert "--stream and --waves cannot be combined" in err


def test_the_coefficients_of_a_reflection_are_printed(run):
    command = ("simulate", "--beads", 40, "--wall", "rigid", "--reflection")
    chain = hertzchain.Chain.uniform(40, right_wall=hertzchain.Wall.rigid())
    found = hertzchain.simulate(chain, times=1500).reflection(25, 40)
    code, out, _ = run(*command, "25:wall")
    assert code == 0
    assert "reflection: contacts 25 to 40, until t = " in out
    assert f"reflected energy {found.reflected_energy:.3f}" in out
    out = json.loads(run(*command, "25-40", "--json").stdout)["reflection"]
    assert (out["before"], out["after"], out["disturbed"]) == (25, 40, False)
    for name in ("reflected_energy", "transmitted_energy", "reflected_momentum", "kept_energy"):
        assert out[name] == pytest.approx(getattr(found, name), abs=1e-4)
    code, _, err = run(*command, 25)
    assert code == 2
    assert "'25' is not two contacts, such as 50:75 or 45:wall" in err
    code, _, err = run("simulate", "--beads", 60, "--until", 5, "--reflection", "25:40")
    assert code == 1
    assert "no wave towards contact 40 passes contact 25" in err
    for contacts, said in (
        ("25:200", "AFTER in --reflection must be a whole number from 0 to 60, got 200"),
        ("45:45", "BEFORE and AFTER in --reflection must be two contacts, got 45 twice"),
        ("45:wall", "the chain has no wall; add --wall MATERIAL"),
    ):
        # Before the run, which would print a summary.
        code, out, err = run("simulate", "--beads", 60, "--reflection", contacts)
        assert (code, out) == (2, "")
        assert said in err


@pytest.mark.parametrize(
    "beads",
    [
        'taper = "backward-exponential"\nrate = 0.03\nbeads = 60',
        'taper = "backward-exponential"\nrate = 0.03\nbeads = 60\nexponent = 2.0',
        'taper = "forward-exponential"\nrate = 0.03\nbeads = 60\nexponent = 2.0',
        f"radii = {[1.0] * 45 + [0.5] * 15}",
    ],
)
def test_command_line_saves_enough_times_for_waves(run, tmp_path, beads):
    """The default of 400 times is too few in long runs; a given number is not changed."""
    file = tmp_path / "chain.toml"
    file.write_text(f"[chain]\n{beads}\n")
    code, out, _ = run("simulate", file, "--waves", "--json")
    assert code == 0
    waves = json.loads(out)["waves"]
    assert waves
    assert all(wave["resolved"] for wave in waves)
    code, _, err = run("simulate", file, "--waves", "--times", 100)
    assert code == 2
    assert re.search(r"too few saved times .* --times \d+ is enough", " ".join(err.split()))


def test_command_line_tells_how_far_a_run_can_be_predicted(run, tmp_path):
    chain = tmp_path / "chain.toml"
    chain.write_text(
        '[chain]\ntaper = "uniform"\nbeads = 20\n[chain.left_wall]\n[chain.right_wall]\n'
    )
    code, out, _ = run("simulate", "--chain", chain, "--until", 300)
    assert code == 0
    assert "transits of the pulse: --horizon shows" in out
    code, out, _ = run("simulate", "--chain", chain, "--until", 300, "--horizon")
    assert code == 0
    assert "horizon: velocities predictable within 1% until t = " in out
    assert "--horizon shows" not in out
    assert "; later values are one of many possible outcomes" in out
    horizon = json.loads(
        run("simulate", "--chain", chain, "--until", 300, "--horizon", "--json")[1]
    )["horizon"]
    assert 60.0 < horizon["time"] < horizon["last_time"] == 300.0
    assert horizon["rtol"] < horizon["shadow_rtol"]
    short = json.loads(run("simulate", "--beads", 9, "--horizon", "--json")[1])["horizon"]
    assert short["time"] is None
    assert short["error"] < 1e-6
    code, _, err = run("simulate", "--beads", 9, "--times", 0, "--horizon")
    assert code == 2
    assert "--horizon require saved times" in err


@pytest.mark.long
def test_simulate_says_that_small_differences_may_change_a_late_peak(run):
    taper = ("simulate", "--taper", "forward-exponential", "--wall", "same", "--rate")
    code, out, _ = run(*taper, 0.1, "--beads", 40)
    assert code == 0
    line = next(line for line in out.splitlines() if line.startswith("right wall: "))
    assert "; no larger force follows in this run; " in line
    assert line.endswith("such as another tolerance: check with --horizon")
    assert "the run lasts 10 transits of the pulse: --horizon shows" in out
    code, out, _ = run(*taper, 0.1, "--beads", 40, "--horizon")
    assert code == 0
    assert " (after the horizon); no larger force follows in this run\n" in out
    assert "horizon: velocities predictable within 1% until t = " in out
    assert json.loads(run(*taper, 0.1, "--beads", 40, "--json")[1])["walls"][0]["sensitive"] is True
    code, out, _ = run(*taper, 0.05, "--beads", 30, "--until", 150)
    assert code == 0
    assert "; no larger force follows\n" in out
    assert "transits of the pulse: --horizon shows" in out


STEEL_TOML = '[chain]\nradii = "5 mm"\nbeads = 4\nmaterials = "brass"\nvelocity = "2 cm/s"\n'


def command(folder, *arguments, **variables):
    """Standard output and error of a command in a separate process."""
    return subprocess.run(
        [sys.executable, "-m", "hertzchain", *arguments],
        cwd=folder, env=os.environ | variables, capture_output=True, text=True, check=False,
    )  # fmt: skip


@pytest.mark.long
def test_no_environment_brings_a_traceback(tmp_path):
    (tmp_path / "chain.toml").write_text(STEEL_TOML)
    (tmp_path / "matplotlibrc").write_text("text.usetex: True\n")
    plots = "--plot", "pulse.png"
    for variables in ({"MPLBACKEND": "bogus"}, {"PATH": ""}):
        done = command(tmp_path, "pulse", "--beads", "5", *plots, **variables)
        # On a slow machine the progress is shown.
        said = [line for line in done.stderr.splitlines() if "beads passed" not in line]
        assert (done.returncode, said) == (0, [])
        (tmp_path / "pulse.png").unlink()
    done = command(tmp_path, "simulate", "chain.toml", NUMBA_NUM_THREADS="0")
    assert done.returncode == 2
    assert done.stderr.startswith("Error: the environment variable NUMBA_NUM_THREADS is '0'")
    assert len(done.stderr.splitlines()) == 1


@pytest.mark.parametrize(
    "more", ["", '[chain.right_wall]\n[chain.loss]\nlaw = "walton-braun"\nratio = 0.9\n']
)
def test_commands_work_without_compiling(tmp_path, more):
    (tmp_path / "chain.toml").write_text(STEEL_TOML + more)
    runs = [
        command(tmp_path, "simulate", "chain.toml", "--until", "20us", "--json", **variables)
        for variables in ({"NUMBA_DISABLE_JIT": "1"}, {"NUMBA_DISABLE_JIT": "0"})
    ]
    assert [done.returncode for done in runs] == [0, 0]
    plain, compiled = (json.loads(done.stdout) for done in runs)
    assert plain["end_time"] == compiled["end_time"] == 20e-6
    assert plain["steps"] == pytest.approx(compiled["steps"], abs=3)


def test_times_with_a_unit(run, tmp_path):
    chain = tmp_path / "chain.toml"
    chain.write_text(STEEL_TOML)
    code, out, _ = run("simulate", chain, "--until", "0.02ms", "--json")
    assert code == 0
    assert json.loads(out)["end_time"] == 2e-5
    code, _, err = run("simulate", "--beads", 5, "--until", "2ms")
    assert code == 2
    assert "--until has a unit ('2ms'), but the chain is in scaled variables" in err
    assert run("simulate", "--beads", 5, "--until", "soon")[2] == (
        "Error: --until must be a number, got 'soon'\n"
    )


def test_a_sweep_that_is_interrupted_states_whether_points_are_finished(run, tmp_path, monkeypatch):
    file, store = tmp_path / "row.toml", tmp_path / "row.zarr"
    file.write_text('[chain]\ntaper = "uniform"\n[axes]\nbeads = [5, 6]\n[sweep]\nbatch = 1\n')
    whole = hertzchain.sweep

    def interrupt(*given, shard=None, **options):
        whole(*given, shard=shard, **options) if finished else None
        raise KeyboardInterrupt

    for finished in (False, True):
        with monkeypatch.context() as patch:
            patch.setattr(hertzchain, "sweep", interrupt)
            code, _, err = run("sweep", file, "--store", store)
        assert code == 130
        assert ("no points are finished; run the same" in err) != finished
        assert (f"finished points are in {store}; run the same" in err) == finished


def test_sweeps_count_incomplete_peaks(run, tmp_path):
    specification, store = tmp_path / "walls.toml", tmp_path / "walls.zarr"
    specification.write_text(
        '[chain]\ntaper = "uniform"\n[chain.right_wall]\n[axes]\nbeads = [5, 20]\n'
        '[sweep]\nmethods = ["simulate"]\nkeep = ["wall_peak_force"]\n[method]\nuntil = 20.0\n'
    )
    told = (
        "points with an incomplete reflection or force on the wall or the cap: 1 (see variable "
        "`incomplete`)"
    )
    code, out, _ = run("sweep", specification, "--store", store)
    assert (code, told in out) == (0, True)
    assert told in run("sweep", "status", store)[1]
    assert json.loads(run("sweep", "status", store, "--json")[1])["incomplete"] == 1


def test_a_dry_run_states_what_the_estimate_does_not_contain(run, tmp_path):
    file = tmp_path / "sweep.toml"
    file.write_text('[chain]\ntaper = "uniform"\n[axes]\nbeads = [20, 40]\n')
    code, out, _ = run("sweep", file, "--dry-run")
    assert code == 0
    assert re.search(r"at most \d+ bytes of values on disk, and metadata, in about 13 files", out)
    assert "without starting and compiling" in out
    code, _, err = run("sweep", file, "--dry-run", "--store", file)
    assert code == 2
    assert "is not the store of a sweep" in err


def test_a_dry_run_shows_the_names_of_axes_that_differ_in_the_results(run, tmp_path):
    file = tmp_path / "sweep.toml"
    file.write_text(
        '[chain]\nradii = "5 mm"\nbeads = 5\nmaterials = "brass"\n[chain.struck_by]\n'
        'radius = "5 mm"\n[axes]\n"struck_by.velocity" = ["1 mm/s", "2 mm/s"]\n'
        '"struck_by.mass" = ["4 g", "5 g"]\n[sweep]\nkeep = ["velocity"]\n'
    )
    out = run("sweep", file, "--dry-run")[1]
    assert "axis struck_by.velocity is called chain_struck_by_velocity in the results" in out
    assert "axis struck_by.mass" not in out
    shown = json.loads(run("sweep", file, "--dry-run", "--json")[1])
    assert hertzchain.sweep(file).sizes.keys() >= set(shown["renamed"].values())


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.5, "0.5 s"), (300.0, "5 min"), (5000.0, "1 h 23 min"), (400 * 3600.0, "17 days"),
     (250998.1 * 3600.0, "29 years")],
)  # fmt: skip
def test_long_estimates_are_in_days_or_years(run, tmp_path, monkeypatch, seconds, text):
    from hertzchain.sweeps.sweep import Estimate

    (tmp_path / "sweep.toml").write_text('[chain]\ntaper = "uniform"\n[axes]\nbeads = [20, 40]\n')
    for unfinished, words in ((False, "about"), (True, "more than")):
        found = Estimate(2, 1, 320, seconds, unfinished, 13, {})
        monkeypatch.setattr(
            "hertzchain.sweeps.sweep.estimate", lambda *_, _found=found, **__: _found
        )
        out = run("sweep", tmp_path / "sweep.toml", "--dry-run")[1]
        assert f"{words} {text} of computing" in out
        assert ("not finished within ten seconds" in out) is unfinished


def test_simulate_compares_several_chain_files(run, tmp_path):
    (tmp_path / "equal.toml").write_text(EXPERIMENT)
    (tmp_path / "tapered.toml").write_text(EXPERIMENT.replace("5e-3, 5e-3]", "4e-3, 3e-3]"))
    files, picture = (tmp_path / "equal.toml", tmp_path / "tapered.toml"), tmp_path / "both.svg"
    code, out, _ = run("simulate", *files, "--plot", picture, "--sensor", "ball 2")
    assert code == 0
    assert "equal: 4 steel-52100 beads, diameter 10 mm, right wall, impact at 0.2 m/s\n" in out
    assert (
        "tapered: 4 steel-52100 beads, diameters 10 mm to 6 mm, right wall, impact at 0.2 m/s\n"
        in out
    )
    drawn = picture.read_text()
    # The run of the equal balls ends earlier.
    assert re.search(r"<!-- equal \(run ends at [0-9.]+ µs\) -->", drawn)
    for text in ("tapered", "bead 2", "right wall"):
        assert f"<!-- {text} -->" in drawn
    found = json.loads(run("simulate", *files, "--json")[1])["runs"]
    peaks = [hertzchain.simulate(hertzchain.load_chain(file)).wall_force().peak for file in files]
    assert [each["name"] for each in found] == ["equal", "tapered"]
    assert [each["walls"][0]["peak"] for each in found] == peaks
    assert run("simulate", *files, "--animate", tmp_path / "a.gif")[0] == 2
    assert run("pulse", *files, "--csv")[0] == 2


@pytest.mark.parametrize("wall", ["[chain.right_wall]\n", ""])
def test_a_plot_of_chains_with_different_losses_names_them(run, tmp_path, wall):
    text = EXPERIMENT.replace("[chain.right_wall]\n", wall)
    files, picture = [tmp_path / "elastic.toml", tmp_path / "lossy.toml"], tmp_path / "both.svg"
    files[0].write_text(text)
    files[1].write_text(f'{text}[chain.loss]\nlaw = "restitution"\ncoefficient = 0.9\n')
    assert run("simulate", *files, "--plot", picture)[0] == 0
    drawn = picture.read_text()
    assert "<!-- elastic (no loss)" in drawn
    assert "<!-- lossy (restitution 0.9)" in drawn
    assert "may be given once" in run("simulate", files[0], files[0])[2]


def test_animations_have_the_requested_magnification(run, tmp_path, monkeypatch):
    factors = []
    monkeypatch.setattr("hertzchain.plotting.animation._scales",
                        lambda _, factor: factors.append(factor) or "")  # fmt: skip
    chain = ("--beads", 5, "--until", 9, "--times", 3, "--animate", tmp_path / "a.gif")
    assert run("simulate", *chain, "--magnify", 0.25)[0] == 0
    assert factors == [0.25]
    code, _, message = run("simulate", "--beads", 5, "--magnify", 2)
    assert code == 2
    assert "--magnify requires --animate" in message
    code, _, message = run("simulate", *chain, "--magnify", -1)
    assert code == 2
    assert "--magnify" in message


BALLS = ("--material", "steel-52100", "--diameter", "10 mm", "--beads", 12, "--speed", "0.1 m/s",
         "--wall", "same")  # fmt: skip


def test_sensitivity_agrees_with_differences_of_runs(run, tmp_path):
    picture = tmp_path / "sensitivity.svg"
    found = json.loads(run("sensitivity", *BALLS, "--json", "--plot", picture)[1])
    chain = hertzchain.Chain.from_materials(5e-3, "steel-52100", beads=12, velocity=0.1)
    chain, peaks = chain.replace(right_wall=hertzchain.Wall()), []
    for factor in (0.9999, 1.0001):
        radii = np.where(np.arange(12) == 11, factor, 1.0) * chain.radii
        peaks.append(hertzchain.simulate(chain.replace(radii=radii)).wall_force().peak)
    slope = np.log(peaks[1] / peaks[0]) / np.log(1.0001 / 0.9999)
    assert found["relative"][-1] == pytest.approx(slope, rel=1e-3)
    assert (found["value"], found["unit"]) == (pytest.approx(np.mean(peaks), rel=1e-5), "N")
    assert "peak force on the wall" in picture.read_text()
    code, out, _ = run("sensitivity", *BALLS)
    assert code == 0
    assert f"{100.0 * found['change_if_larger'][-1]:+.4f}" in out
    assert run("sensitivity", *BALLS, "--quantity", "length")[0] == 2


def listed_beads(table):
    """Beads and changes in percent in the rows of a table of sensitivities."""
    rows = re.findall(r"^ +(\d+) +\S+ +([+-][\d.]+) +([+-][\d.]+) *$", table, re.MULTILINE)
    return [(int(bead), float(up), float(down)) for bead, up, down in rows]


def test_sensitivity_lists_the_most_influential_beads_first(run):
    chain = ("--material", "steel-52100", "--diameter", "20 mm:8 mm", "--beads", 40,
             "--speed", "0.1 m/s", "--wall", "same")  # fmt: skip
    code, out, _ = run("sensitivity", *chain)
    assert code == 0
    assert "the 26 largest of 40; --all shows every one" in out
    found = json.loads(run("sensitivity", *chain, "--json")[1])
    changes = np.abs([found["change_if_larger"], found["change_if_smaller"]]).max(axis=0)
    shown = [bead for bead, *_ in listed_beads(out)]
    assert len(shown) == 26
    assert (np.diff(changes[np.array(shown) - 1]) <= 0.0).all()
    # Balls 39, 38 and 2 follow the one that strikes and the one at the wall.
    assert shown[:5] == [1, 40, 39, 38, 2]
    left_out = set(range(1, 41)) - set(shown)
    assert changes[[bead - 1 for bead in left_out]].max() <= changes[shown[-1] - 1]
    every = [bead for bead, *_ in listed_beads(run("sensitivity", *chain, "--all")[1])]
    assert every[:26] == shown
    assert sorted(every) == list(range(1, 41))


@pytest.mark.long
def test_sensitivity_lists_simulated_changes(run, tmp_path):
    # The change for one ball is far from linear: +0.28% and -0.11%, where the derivative is 0.19.
    diameters = 1e-3 * np.array([6.35, 5.0, 4.0, 8.0, 3.0, 8.0, 6.35, 5.0, 3.0])
    chain = hertzchain.Chain.from_materials(0.5 * diameters, "steel-52100", velocity=0.3)
    chain = chain.replace(right_wall=hertzchain.Wall.of("steel-52100"))
    peaks = []
    for factor in (1.0, 1.01, 0.99):
        radii = chain.radii * np.where(np.arange(9) == 1, factor, 1.0)
        peaks.append(wall_peak(chain.replace(radii=radii), 4e-4))
    expected = [100.0 * (each / peaks[0] - 1.0) for each in peaks[1:]]
    (tmp_path / "design.toml").write_text(hertzchain.chain_as_toml(chain))
    rows = {
        bead: both for bead, *both in listed_beads(run("sensitivity", tmp_path / "design.toml")[1])
    }
    assert rows[2] == pytest.approx(expected, abs=1e-4)
    assert abs(sum(expected)) > 0.1


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
def test_sensitivity_to_larger_and_smaller_beads_at_the_kink_of_a_peak(run, tmp_path):
    # The best order of 8 steel and 7 PTFE balls has three maxima of nearly the same height.
    order = "SPPSSSSSSPSPPPP"
    kinds = [{"S": "steel-52100", "P": "ptfe"}[each] for each in order]
    chain = hertzchain.Chain.from_materials(
        "5 mm", kinds, velocity="2 m/s", right_wall=hertzchain.Wall.of("ptfe")
    )
    file = tmp_path / "order.toml"
    file.write_text(hertzchain.chain_as_toml(chain))
    found = json.loads(run("sensitivity", file, "--json")[1])
    assert "can make another maximum of the" in run("sensitivity", file)[1]
    changed = [
        chain.replace(radii=chain.radii * np.where(np.arange(15) == i, 1.0 + part, 1.0))
        for part in (0.01, -0.01) for i in range(15)
    ]  # fmt: skip
    peaks = np.array(
        [hertzchain.simulate(each, times=0).wall_force().peak for each in (chain, *changed)]
    )
    change = peaks[1:] / peaks[0] - 1.0
    np.testing.assert_allclose(found["change_if_larger"], change[:15], rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(found["change_if_smaller"], change[15:], rtol=0.0, atol=1e-6)
    # The figure shows the same changes, of both signs.
    picture = tmp_path / "changes.svg"
    assert run("sensitivity", file, "--plot", picture)[0] == 0
    assert all(f"<!-- {label} -->" in picture.read_text() for label in ("+1%", "\N{MINUS SIGN}1%"))
    # The derivatives alone would be wrong by more than 5%.
    assert np.abs(0.01 * np.array(found["relative"]) - change[:15]).max() > 0.05


YIELDING = (*BALLS[:4], "--beads", 6, "--speed", "1 m/s", "--wall", "same")


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
def test_sensitivity_and_scatter_of_elastic_contacts_that_would_yield(run, tmp_path):
    chain = hertzchain.Chain.from_materials(
        5e-3, "steel-52100", beads=6, velocity=1.0, right_wall=hertzchain.Wall()
    )
    elastic, yielding = (
        hertzchain.simulate(chain.replace(loss=loss)).wall_force().peak
        for loss in (None, hertzchain.ElasticPlastic())
    )
    shown = f"{yielding:.4g} N, {yielding / elastic:.1%} of the elastic value (--loss elastic-plas"
    code, out, _ = run("sensitivity", *YIELDING)
    assert code == 0
    assert f"= {elastic:.4g} N with elastic contacts, to which all changes refer" in out
    assert f"with contacts that yield, it is {shown}" in out
    found = json.loads(run("sensitivity", *YIELDING, "--json")[1])
    assert found["value_with_yielding_contacts"] == pytest.approx(yielding, rel=1e-5)
    assert found["method"] == "adjoint"
    picture = tmp_path / "scatter.svg"
    scatter = ("scatter", *YIELDING, "--scatter", "1%", "--chains", 5, "--plot", picture)
    assert (
        f"elastic contacts; with contacts that yield, the nominal one is {shown}"
        in (run(*scatter)[1])
    )
    assert "nominal chain, elastic contacts" in picture.read_text()
    found = json.loads(run(*scatter, "--json")[1])
    assert found["nominal_with_yielding_contacts"] == pytest.approx(yielding, rel=1e-5)
    slow = json.loads(run("scatter", *BALLS[:-3], "1 mm/s", *BALLS[-2:], *scatter[-6:-2],
                          "--json")[1])  # fmt: skip
    assert slow["nominal_with_yielding_contacts"] is None


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
def test_values_with_yield_outside_the_range_of_the_law_have_no_percentage(run):
    fast = ("--material", "ptfe", "--diameter", "10 mm", "--beads", 5, "--speed", "20 m/s",
            "--wall", "same")  # fmt: skip
    chain = hertzchain.Chain.from_materials(
        5e-3, "ptfe", beads=5, velocity=20.0, right_wall=hertzchain.Wall(),
        loss=hertzchain.ElasticPlastic(),
    )  # fmt: skip
    found = hertzchain.simulate(chain)
    ratio = hertzchain.hertz_range(chain, found.largest_overlaps).overlap_ratio.max()
    assert ratio > 0.1
    caution = f" N, outside the range of the law (overlap / radius {ratio:.2g})"
    peak = found.wall_force().peak
    for command in (("sensitivity", *fast), ("scatter", *fast, "--scatter", "1%", "--chains", 5)):
        out = run(*command)[1]
        assert f"{peak:.4g}{caution} (--loss elastic-plastic)" in out
        assert "of the elastic value" not in out
        document = json.loads(run(*command, "--json")[1])
        assert document["yielding_within_range"] is False
        assert document["yielding_overlap_ratio"] == pytest.approx(ratio, rel=1e-3)
    out = run("simulate", *fast)[1]
    shown = f"peak with contacts that yield: {peak:.5g} N (--loss elastic-plastic), {caution[4:]}"
    assert shown in out
    document = json.loads(run("simulate", *fast, "--json")[1])
    assert document["yielding_within_range"] is False
    assert document["yielding_overlap_ratio"] == pytest.approx(ratio, rel=1e-3)
    slow = json.loads(run("simulate", *fast[:-3], "1 m/s", "--wall", "same", "--json")[1])
    assert slow["yielding_within_range"] is True


def test_sensitivity_of_contacts_that_yield_is_found_by_differences(run):
    dented = (*YIELDING, "--loss", "elastic-plastic")
    found = json.loads(run("sensitivity", *dented, "--json")[1])
    assert found["method"] == "central differences"
    assert found["value_with_yielding_contacts"] is None
    assert 0.0 < found["error"] < 1e-3
    # The force on the wall is proportional to the square of all radii.
    assert sum(found["relative"]) == pytest.approx(2.0, abs=1e-4)
    changes = np.array([found["change_if_larger"], found["change_if_smaller"]])
    assert 50.0 * (changes[0] - changes[1]) == pytest.approx(found["relative"], abs=0.01)
    code, out, _ = run("sensitivity", *dented, "--quantity", "velocity@last", "--to", "velocities")
    assert code == 0
    assert "derivatives are central differences of simulations, with an estimated error of" in out
    found = run("sensitivity", *dented, "--quantity", "velocity@last", "--to", "velocities",
                "--json")[1]  # fmt: skip
    assert json.loads(found)["gradient"][1:] == [None] * 5


def test_sensitivity_to_gaps_of_contacts_that_yield_is_simulated(run):
    dented = (*YIELDING, "--loss", "elastic-plastic")
    code, out, _ = run("sensitivity", *dented, "--to", "gaps")
    assert code == 0
    assert "One gap at a time is 1 um larger. This loss has no derivatives by gaps." in out
    found = json.loads(run("sensitivity", *dented, "--to", "gaps", "--json")[1])
    chain = json.loads(run("simulate", *dented, "--json")[1])
    peak = chain["walls"][0]["peak"]
    assert found["value"] == pytest.approx(peak, rel=1e-6)
    assert set(found["gradient"]) == {None}
    assert found["method"] == "none"
    assert found["error"] is None
    row = hertzchain.Chain.from_materials(
        "5 mm", "steel-52100", beads=6, velocity=1.0, right_wall=hertzchain.Wall(),
        loss=hertzchain.ElasticPlastic(), gaps=[0.0, 0.0, 1e-6, 0.0, 0.0],
    )  # fmt: skip
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hertzchain.ModelRangeWarning)
        wider = hertzchain.simulate(row).wall_force().peak
    assert found["change_if_larger"][2] == pytest.approx(wider / peak - 1.0, rel=1e-3)


def test_sensitivity_by_the_stiffness_of_a_scaled_chain_keeps_its_wall(run, tmp_path):
    chain = hertzchain.Chain.tapered("forward-exponential", 0.05, beads=5)
    chain = chain.replace(right_wall=hertzchain.Wall())
    (tmp_path / "row.toml").write_text(hertzchain.chain_as_toml(chain))
    code, out, err = run("sensitivity", tmp_path / "row.toml", "--to", "stiffness", "--json")
    assert code == 0, err
    found = json.loads(out)
    assert 100.0 * np.array(found["change_if_larger"]) == pytest.approx(found["relative"], abs=5e-3)


@pytest.mark.long
def test_scatter_of_small_deviations_follows_from_the_sensitivities(run, tmp_path):
    picture = tmp_path / "scatter.svg"
    command = ("scatter", *BALLS, "--scatter", "0.05%", "--chains", 400, "--plot", picture)
    found = json.loads(run(*command, "--json")[1])
    relative = json.loads(run("sensitivity", *BALLS, "--json")[1])["relative"]
    expected = 5e-4 * np.linalg.norm(relative) * found["nominal"]
    # The standard deviation of 400 samples has an error of 3.5%.
    assert found["standard_deviation"] == pytest.approx(expected, rel=0.12)
    assert len(found["values"]) == 400
    assert np.percentile(found["values"], 95) == found["percentiles"]["95"]
    code, out, _ = run(*command)
    assert code == 0
    assert "wall_force.peak: 400 of 400 random chains" in out
    assert "peak force on the wall [N]" in picture.read_text()
    assert run("scatter", *BALLS)[0] == 2
    code, _, err = run("scatter", *BALLS, "--samples", 500)
    assert code == 2
    assert "No such option '--samples'; use --chains" in err
    assert (
        "--scatter must be a number or a percentage"
        in run("scatter", *BALLS, "--scatter", "much")[2]
    )
    assert "at most 30%, got '50%'" in run("scatter", *BALLS, "--scatter", "50%")[2]


SIZED = ("--material", "steel-52100", "--speed", "0.1 m/s", "--scatter", "0.05 mm", "--diameter")


@pytest.mark.parametrize(
    ("command", "advice"),
    [
        (("scatter", "--beads", 20, *SIZED, "10 mm"), "for diameters of 10 mm, give '0.5%'"),
        (("scatter", "--beads", 20, *SIZED, "20 mm:5 mm"),
         "for diameters of 20 mm to 5 mm, give '0.25%' to '1%'"),
        (("pulse", "--method", "disorder", "--beads", 50, *SIZED, "8 mm"),
         "for diameters of 8 mm, give '0.625%'"),
        (("scatter", "--beads", 20, "--scatter", "50um"), "for diameters of 10 mm, give '0.5%'"),
    ],
)  # fmt: skip
def test_a_scatter_in_mm_is_rejected_with_the_relative_one(run, command, advice):
    code, _, err = run(*command)
    given = "50um" if "50um" in command else "0.05 mm"
    assert code == 2
    assert err == (
        f"Error: --scatter must be relative to the diameters, got the length '{given}'; {advice}\n"
    )


def test_a_scatter_in_mm_is_rejected_in_python():
    words = "must be relative to the diameters, got the length '0.05 mm'; for diameters of "
    row = hertzchain.Chain.from_materials(diameters="5 mm", materials="brass", beads=40)
    for chain in (row, row.struck_by(diameter="20 mm", velocity="1 m/s")):
        with pytest.raises(hertzchain.InputError, match=f"relative scatter {words}5 mm, give '1%'"):
            chain.with_scatter(1, relative="0.05 mm")
    for call in (
        lambda: hertzchain.Scatter(radius="0.05 mm"),
        lambda: hertzchain.disorder(row, "0.05 mm"),
    ):
        with pytest.raises(hertzchain.InputError, match=f"scatter.* {words}10 mm, give '0.5%'"):
            call()


CRYSTAL = ("spectrum", "--material", "steel-316", "--diameter", "19 mm", "--beads", 6)


@pytest.mark.parametrize(("words", "option"), [
    (("pulse", "--beads", 5, "--beads", 6), "--beads"),
    (("simulate", *BALLS, "--cap", "1 g", "--cap", "2 g"), "--cap"),
    (("sweep", "run", "a.toml", "--shard", "1/2", "--shard", "2/2"), "--shard"),
    (("verify", "--only", "a", "--only", "b"), "--only"),
])  # fmt: skip
def test_options_with_one_value_are_given_once(run, words, option):
    code, out, err = run(*words)
    assert (code, out) == (2, "")
    assert err.endswith(f"Error: {option} is given 2 times; give it once\n")


@pytest.mark.parametrize(("words", "said"), [
    (("--speed", "nan"), "--speed must be finite, got nan"),
    (("--until", "nan"), "--until must be above 0 and finite, got nan"),
    (("--until", "inf"), "--until must be above 0 and finite, got inf"),
])  # fmt: skip
def test_values_that_are_no_numbers_are_not_asked_for_a_unit(run, words, said):
    balls = ("--material", "steel-52100", "--diameter", "10 mm", "--beads", 5)
    code, out, err = run("simulate", *balls, *words)
    assert (code, out) == (2, "")
    assert err.endswith(f"Error: {said}\n")


def test_advice_is_in_the_words_of_the_command_line(run):
    code, _, err = run("pulse", "--beads", 5, "--rtol", 1e-12)
    assert code == 2
    assert err.endswith("got 1e-12; for smaller errors use --method simulate\n")
    assert run("pulse", "--beads", 5, "--rtol", 1e-12, "--method", "simulate")[0] == 0


def test_places_that_cannot_be_written_are_rejected_before_the_run(run, tmp_path, monkeypatch):
    monkeypatch.setattr(hertzchain, "simulate", None)
    (tmp_path / "folder.nc").mkdir()
    code, _, err = run("simulate", "--beads", 5, "--out", tmp_path / "folder.nc")
    assert code == 2
    assert "folder.nc is a folder; give the name of a file" in err
    # The superuser may write everywhere.
    monkeypatch.setattr(os, "access", lambda path, _: path != tmp_path)
    code, _, err = run("simulate", "--beads", 5, "--plot", tmp_path / "run.png")
    assert code == 2
    assert f"the folder {tmp_path} is not writable" in err


def test_flags_and_repeatable_options_may_be_repeated(run):
    command = ("pulse", "--beads", 5, "--csv", "--csv", "--method", "bca", "--method", "propagate")
    code, out, _ = run(*command)
    assert code == 0
    assert [line.partition(",")[0] for line in out.splitlines()[1::5]] == ["BCA", "propagation"]


def test_spectra_have_transfer_functions(run, tmp_path):
    command = (*CRYSTAL, "--precompression", "0.1 N", "--transfer", 4)
    code, out, _ = run(*command, "--csv")
    rows = np.array([line.split(",") for line in out.splitlines()[1:]], float)
    assert (code, out.splitlines()[0]) == (0, "frequency [Hz],amplitude,phase [rad]")
    # The beads ahead of contact 4 are two of six, which a slow force moves together.
    assert rows[0, 1] == pytest.approx(2.0 / 6.0, rel=1e-4)
    balls = hertzchain.Chain.from_materials("9.5 mm", "steel-316", beads=6)
    found = hertzchain.spectrum(balls.replace(precompression="0.1 N", held_by="force"))
    expected = found.transfer_force(rows[:, 0], 4)
    np.testing.assert_allclose(rows[:, 1], np.abs(expected), rtol=1e-4)
    picture = tmp_path / "transfer.svg"
    assert run(*command, "--plot", picture)[0] == 0
    label = " ".join(re.findall(r"<!-- (.*) -->", picture.read_text()))
    assert "force in contact 4 per force on bead 1" in label
    for words, said in (
        (("--transfer", 4), "--transfer requires --plot FILE or --csv"),
        (("--csv",), "--csv prints a transfer function: add --transfer CONTACT"),
        (("--csv", "--json", "--transfer", 4), "--json and --csv cannot be combined"),
        (("--csv", "--transfer", 6), "contact 6 carries no force, because no wall touches"),
        (("--speed", "1 m/s"), "No such option '--speed'"),
        (("--striker", 1), "No such option '--striker'"),
    ):
        code, out, err = run(*CRYSTAL, "--precompression", "0.1 N", *words)
        assert (code, out) == (2, "")
        assert said in err


def test_spectra_advise_no_law_that_they_reject(run):
    with warnings.catch_warnings():
        warnings.simplefilter("always", hertzchain.ModelRangeWarning)
        code, _, err = run(*CRYSTAL, "--precompression", "20 N")
    assert code == 0
    assert "alone gives 3.8; reduce the precompression\n" in err


def test_digits_of_a_scatter_follow_its_standard_deviation(run):
    # Balls of grade 10 vary by 0.1 um: the force in ppm.
    command = ("scatter", *BALLS, "--grade", 10, "--chains", 30)
    found = json.loads(run(*command, "--json")[1])
    for name in ("G10", "g10"):
        same = ("scatter", *BALLS, "--grade", name, "--chains", 30, "--json")
        assert json.loads(run(*same)[1])["values"] == found["values"]
    code, _, err = run("scatter", *BALLS, "--grade", "X10")
    assert code == 2
    assert "'X10' is not a grade, such as 100 or G100" in err
    rows = {line[2:20].strip(): line[20:].split() for line in run(*command)[1].splitlines()[2:]}
    deviation, unit, percent = rows["standard deviation"]
    assert (unit, percent[-1]) == ("N", "%")
    assert float(deviation) == pytest.approx(found["standard_deviation"], rel=5e-3)
    for name, value in {"nominal": found["nominal"], "mean": found["mean"]}.items():
        assert float(rows[name][0]) == pytest.approx(value, abs=5e-3 * found["standard_deviation"])
        assert len(rows[name][0].partition(".")[2]) == len(deviation.partition(".")[2])
    part = 100.0 * found["standard_deviation"] / found["nominal"]
    assert float(percent[:-1]) == pytest.approx(part, rel=5e-3)
    # The same decimals, for values of any size, and plain numbers if nothing varies.
    assert with_decimals([1.23456789e9, 2e9], 5.5e7) == ["1.2346e+09", "2.0000e+09"]
    assert with_decimals([-1.5e-9, 0.0], 1e-10) == ["-1.500e-09", "0.000e-09"]
    assert with_decimals([25.649, 0.0], 0.0) == ["25.649", "0"]
    assert with_decimals([0.0], 0.0) == ["0"]


@pytest.mark.parametrize(
    ("chains", "few", "needed"), [(2, "1%, 5%, 95% and 99%", 100), (20, "1% and 99%", 100)]
)
def test_percentiles_that_few_chains_do_not_determine_are_named(run, chains, few, needed):
    command = ("scatter", *BALLS, "--grade", 10, "--chains")
    note = f"note: {chains} chains do not determine the percentiles {few}; at least {needed} do"
    *lines, last = run(*command, chains)[1].splitlines()
    assert last.startswith(note)
    assert [line for line in lines if " are below " in line] == [
        line for line in lines if "50% are below" in line or (chains == 20 and "5% are" in line)
    ]
    assert run(*command, needed)[1].count(" are below ") == 5


def test_numbers_without_a_dimension_may_be_percentages(run):
    taper = ("pulse", "--taper", "forward-exponential", "--beads", 12, "--csv")
    assert run(*taper, "--rate", "5%")[1] == run(*taper, "--rate", 0.05)[1]
    fixed = ("simulate", "--beads", 12, "--until", 15, "--method", "symplectic", "--json")
    assert run(*fixed, "--drift", "0.01%")[1] == run(*fixed, "--drift", 1e-4)[1]
    calibrate = ("calibrate", "--taper", "forward-exponential", "--window", "5:30", "--beads", 40)
    assert (
        run(*calibrate, "--rates", "2%, 4%,6 %")[1]
        == run(*calibrate, "--rates", "0.02,0.04,0.06")[1]
    )


def test_help_lists_each_command_once(run):
    out = run("--help")[1]
    for name in cli.cli.commands:
        assert len(re.findall(rf"^  {name} ", out, re.M)) == 1


def test_the_summary_states_the_velocity_that_a_striker_keeps(run, tmp_path):
    """A binary elastic collision leaves (M - m)/(M + m) of the velocity of the striker."""
    file = tmp_path / "hammer.toml"
    file.write_text(
        '[chain]\ndiameters = ["10 mm"]\nmaterials = "steel-52100"\n'
        '[chain.struck_by]\nvelocity = "0.05 m/s"\nmass = "20 g"\nradius = inf\n'
    )
    ball = hertzchain.material("steel-52100").density * math.pi / 6 * 0.01**3
    kept = (0.02 - ball) / (0.02 + ball)
    options = ("simulate", file, "--until", "2 ms")
    lines = run(*options)[1].splitlines()
    assert (
        f"striker at the end of the run: velocity {0.05 * kept:.4g} m/s, {100 * kept**2:.2f}% of "
        "its energy"
    ) in lines
    (found,) = json.loads(run(*options, "--json")[1])["strikers"]
    expected = {"striker": 1, "velocity": 0.05 * kept, "energy_kept": kept**2}
    assert found == pytest.approx(expected, rel=1e-7)
    # The state at the end is not saved.
    assert json.loads(run(*options, "--times", "0", "--json")[1])["strikers"] == []


def test_the_summary_has_the_momentum_of_the_last_bead(run):
    options = ("--material", "steel-52100", "--diameter", "10 mm", "--beads", "6", "--speed",
               "0.2 m/s")  # fmt: skip
    _, out, _ = run("simulate", *options)
    chain = hertzchain.Chain.from_materials(5e-3, "steel-52100", beads=6, velocity=0.2)
    pulse = hertzchain.propagate(chain)
    line = out.splitlines()[-2]
    assert line == (
        f"bead 6 at the free end: velocity {pulse.velocity[-1]:.5g} m/s, momentum "
        f"{1e6 * pulse.momentum[-1]:.4g} uN s in the leading pulse"
    )
    last = json.loads(run("simulate", *options, "--json")[1])["last_bead"]
    assert last["momentum"] == pytest.approx(pulse.momentum[-1], rel=1e-9)
    # With a wall, and before the pulse has arrived, there is none.
    for more in (("--wall", "same"), ("--until", "20us")):
        assert json.loads(run("simulate", *options, *more, "--json")[1])["last_bead"] is None


@pytest.mark.parametrize(
    ("words", "found"),
    [
        ("simulate --material st", {"steel-52100", "steel-304", "steel-316", "steel-440c"}),
        ("simulate --material brass,pt", {"brass,ptfe"}),
        ("simulate --wall-loss elastic", {"elastic", "elastic-plastic="}),
        ("pulse --loss v", {"velocity-power=", "viscoelastic="}),
        ("pulse --loss elastic", {"elastic", "elastic-plastic="}),
        ("simulate --wall r", {"rigid", "rubber"}),
        ("pulse --taper forward", {"forward-linear", "forward-exponential"}),
    ],
)
def test_names_are_completed_in_the_shell(words, found):
    from click.shell_completion import ShellComplete

    from hertzchain.cli import cli

    *args, incomplete = words.split()
    completion = ShellComplete(cli, {}, "hertzchain", "_HERTZCHAIN_COMPLETE")
    assert {each.value for each in completion.get_completions(args, incomplete)} == found


def test_the_title_of_a_table_is_one_line(run):
    options = ("--taper", "backward-exponential", "--rate", "0.05", "--beads", "60")
    _, out, _ = run("pulse", *options, "--method", "bca", "--method", "local-rate")
    assert out.splitlines()[0].strip() == "velocity: backward-exponential, q = 0.05, 60 beads"


def test_negative_residence_times_are_explained(run, tmp_path):
    (tmp_path / "row.csv").write_text("radius\n1\n0.1\n1\n0.1\n1\n0.3\n1\n")
    note = "residence: negative where the pulse arrives at the next bead before it arrives at this"
    assert note in run("pulse", tmp_path / "row.csv")[1]
    assert "negative" not in run("pulse", "--beads", "7")[1]


def test_pulse_by_the_disorder_law(run):
    options = ["pulse", "--beads", "20", "--method", "disorder"]
    code, out, _ = run(*options, "--scatter", "1%", "--modulus-scatter", "0.05", "--json")
    (found,) = json.loads(out)["pulses"]
    law = hertzchain.disorder(hertzchain.Chain.uniform(20), 0.01, modulus_scatter=0.05)
    assert code == 0
    for name in ("velocity", "arrival_spread", "peak_force_spread"):
        np.testing.assert_array_equal(found[name], law.columns()[name])
    for given, message in (
        (options, "--method disorder requires --scatter"),
        (["pulse", "--scatter", "1%"], "hertzchain scatter simulates"),
        ([*options, "--scatter", "0"], "--modulus-scatter above 0"),
        ([*options, "--scatter", "5%"], "at most 3%, got '5%'; for more, use hertzchain scatter"),
        ([*options, "--modulus-scatter", "20%"], "--modulus-scatter .* at most 10%, got '20%'"),
        (["pulse", "--beads", "5", "--method", "disorder", "--scatter", "1%"],
         "use hertzchain scatter"),
        (["pulse", "--quantity", "velocity_spread", "--method", "bca", "--method", "local-rate"],
         "velocity_spread requires --method disorder"),
    ):  # fmt: skip
        code, _, err = run(*given)
        assert code == 2
        assert re.search(message, err)
    code, _, err = run(*options, "--scatter", "1%", "--quantity", "energy")
    assert code == 0
    assert "note: the disorder law predicts no spread of the energy" in err
    assert "--only 2:" in " ".join(run("pulse", "--help")[1].split())


@pytest.mark.parametrize(
    "options",
    [(), ("--material", "steel-52100", "--diameter", "20 mm:5 mm", "--speed", "0.01 m/s")],
)
def test_table_of_the_disorder_law_fits_100_columns(run, options):
    code, out, _ = run(
        "pulse", "--beads", "100", "--method", "disorder", "--scatter", "1%", *options
    )
    assert code == 0
    assert max(map(len, out.splitlines())) <= 100
    symbols = [name for name in ("sd_v", "sd_t", "sd_F", "e_v") if name in out]
    assert len(symbols) == 4
    if not options:
        law = hertzchain.disorder(hertzchain.Chain.uniform(100), 0.01)
        row = next(line.split() for line in out.splitlines() if line.split()[:1] == ["5"])
        expected = law.velocity[4], law.columns()["velocity_spread"][4]
        assert [float(text) for text in row[1:3]] == pytest.approx(expected, rel=5e-3)


def test_forces_after_the_horizon_are_marked(capsys):
    from hertzchain.cli.run_summary import show_run
    from hertzchain.simulation.horizon import Horizon

    chain = hertzchain.Chain.uniform(9).replace(right_wall=hertzchain.Wall.rigid())
    run = hertzchain.simulate(chain, until=40.0, times=2001)
    sensors = {bead: run.sensor_force(bead).largest_so_far_time for bead in (2, 8)}
    # The horizon is between the maxima in both sensors.
    error = np.where(run.times > np.mean([*sensors.values()]), 1.0, 0.0)
    run.__dict__["_horizon"] = Horizon(chain, run.times, error, 0.01, 1e-13, 1e-12)
    show_run(run, [*sensors], waves=False, contacts=False)
    lines = capsys.readouterr().out.splitlines()
    marked = [line.split(":")[0] for line in lines if "(after the horizon)" in line]
    assert marked == ["right wall", "sensor in bead 8"]
    assert lines[-1].endswith("; later values are one of many possible outcomes")
    run.__dict__["_horizon"] = Horizon(chain, run.times, 0.0 * error, 0.01, 1e-13, 1e-12)
    show_run(run, [*sensors], waves=False, contacts=False)
    out = capsys.readouterr().out
    assert "after the horizon" not in out
    assert "outcomes" not in out


def test_pulse_has_the_tolerance_of_its_simulations(run):
    options = ("--beads", "12", "--loss", "restitution=0.9")
    _, out, err = run("pulse", *options)
    assert "use --method simulate (chain" in err
    _, out, _ = run("pulse", *options, "--method", "simulate", "--rtol", "1e-6", "--json")
    chain = hertzchain.Chain.uniform(12).replace(loss=hertzchain.Restitution(0.9))
    expected = hertzchain.simulate(chain, times=0, rtol=1e-6).pulse().velocity
    assert json.loads(out)["pulses"][0]["velocity"] == expected.tolist()
    code, _, err = run("pulse", "--method", "bca", "--rtol", "1e-6")
    assert code == 2
    assert "--rtol requires --method propagate or --method simulate" in err


def test_the_final_velocity_of_a_body_behind_a_row_is_printed(run, tmp_path):
    file = tmp_path / "box.toml"
    file.write_text("""
[chain]
diameters = "10 mm"
beads = 12
materials = "steel-52100"
cap = {mass = "0.4 kg"}
[chain.struck_by]
velocity = "0.1 m/s"
""")
    _, out, _ = run("simulate", file, "--until", "5 ms")
    document = json.loads(run("simulate", file, "--until", "5 ms", "--json")[1])
    assert document["closed_contacts"] == []
    # The balls rebound from the body, which receives more than the momentum of the impact.
    masses = hertzchain.load_chain(file).masses
    momenta = masses * np.array(document["final_velocities"])
    assert momenta.sum() == pytest.approx(0.1 * masses[0], rel=1e-9)
    assert momenta[-1] > momenta.sum()
    velocity = momenta[-1] / 0.4
    assert f"  velocity after the impact: {velocity:.5g} m/s, momentum " in out


def test_the_final_velocities_of_a_cradle_are_printed(run):
    balls = ("--material", "steel-52100", "--diameter", "10 mm", "--speed", "0.3 m/s", "--beads")
    _, out, _ = run("simulate", *balls, "5")
    document = json.loads(run("simulate", *balls, "5", "--json")[1])
    found = np.array(document["final_velocities"])
    # Momentum and energy are those of the impact, and all contacts are open.
    assert document["closed_contacts"] == []
    assert found.sum() == pytest.approx(0.3, rel=1e-12)
    assert (found**2).sum() == pytest.approx(0.3**2, rel=1e-10)
    assert (found < 0.0).tolist() == [True, True, True, False, False]
    shown = ", ".join(f"{each:.5f}" for each in found)
    assert out.splitlines()[-1] == (
        f"velocities at the end of the run, from bead 1 to bead 5: {shown} m/s"
    )
    # Two equal balls exchange their velocities; others have not separated, or are too many.
    for beads, more in ((2, ()), (5, ("--until", "60us")), (11, ("--until", "1ms"))):
        other = (*balls, beads, *more)
        assert "velocities at the end" not in run("simulate", *other)[1], beads
        assert len(json.loads(run("simulate", *other, "--json")[1])["final_velocities"]) == beads
