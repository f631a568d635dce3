"""Design files, the command `design`, resumed searches, and invalid problems."""

import dataclasses
import functools
import itertools
import json
import math
import os
import re
import signal
import subprocess
import sys
import time
from contextlib import contextmanager

import numpy as np
import pytest
from interruption import PROMPT
from scipy_chain import wall_peak

import hertzchain as hc
from hertzchain.cli.progress import _Pace
from hertzchain.designs import dry_run as timing
from hertzchain.designs import pareto, trials
from hertzchain.designs.balls import load_balls
from hertzchain.designs.bounds import impossible
from hertzchain.designs.design import dry_run
from hertzchain.designs.dry_run import in_lines
from hertzchain.designs.exports import chain_text
from hertzchain.designs.genetic import search
from hertzchain.designs.measures import parse_measure
from hertzchain.designs.methods import method_for
from hertzchain.designs.rejections import why_rejected
from hertzchain.designs.search_budget import budget_from, simulations_within
from hertzchain.designs.trials import Trials
from hertzchain.store.journal import Journal

WALLED = hc.Chain.uniform(8).replace(right_wall=hc.Wall())
PROBLEM = """
[chain]
taper = "uniform"
beads = 8
right_wall = {gap = 0.0}

[design]
minimise = "wall_force.peak"
budget = 400
seed = 2

[[design.vary]]
radii = [0.5, 1.0]
"""


def problem(**options):
    given = {"minimise": "wall_force.peak", "vary": [hc.vary.radii(0.5, 1.0)]} | options
    return hc.Design(given.pop("chain", WALLED), **given)


@pytest.fixture
def run(run, monkeypatch, tmp_path):
    """Runs ``hertzchain design`` in a temporary folder."""
    monkeypatch.chdir(tmp_path)
    return functools.partial(run, "design")


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "problem.toml"
    path.write_text(PROBLEM)
    return path


def test_a_design_file_describes_the_problem(file):
    found, options = hc.load_design(file)
    assert found.identity == problem().identity
    assert options == {"budget": 400, "seed": 2}


@pytest.mark.long
def test_a_search_that_is_cut_off_anywhere_gives_the_same_result(tmp_path):
    whole = hc.design(problem(), budget=200, store=tmp_path / "whole")
    (journal,) = (tmp_path / "whole").rglob("gradient-200-simulations-seed-0.journal")
    content, place = journal.read_bytes(), journal.relative_to(tmp_path / "whole")
    lengths = np.random.default_rng(1).integers(1, len(content), 4)
    for i, length in enumerate(sorted(lengths)):
        folder = tmp_path / f"cut-{i}"
        (folder / place).parent.mkdir(parents=True)
        (folder / place).write_bytes(content[:length])
        again = hc.design(problem(), budget=200, store=folder)
        assert again.chain.radii.tolist() == whole.chain.radii.tolist()
        assert (again.value, again.runs, again.history.tolist()) == (
            whole.value, whole.runs, whole.history.tolist(),
        )  # fmt: skip


@pytest.mark.long
def test_the_result_does_not_depend_on_the_number_of_threads():
    one, two = (hc.design(problem(), budget=300, threads=n) for n in (1, 2))
    assert one.chain.radii.tolist() == two.chain.radii.tolist()


@pytest.mark.long
def test_a_search_that_is_killed_ten_times_gives_the_same_result(file, tmp_path, run):
    file.write_text(PROBLEM.replace("budget = 400", "budget = 3000"))
    whole = json.loads(run(file, "--json", "--store", tmp_path / "whole").stdout)
    command = [sys.executable, "-m", "hertzchain", "design", str(file), "--json", "--store",
               str(tmp_path / "killed")]  # fmt: skip
    for delay in np.linspace(1.0, 4.0, 10):
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        time.sleep(delay)
        os.kill(process.pid, signal.SIGKILL)
        process.communicate()
    again = json.loads(run(*command[4:]).stdout)
    for key in ("radii", "value", "simulations", "best_start"):
        assert again[key] == whole[key]


@pytest.mark.long
def test_a_compilation_is_announced_and_can_be_interrupted(file, tmp_path):
    """The compiler itself cannot be interrupted."""
    cache = {"NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONUNBUFFERED": "1"}
    command = [sys.executable, "-m", "hertzchain", "design", str(file)]
    with subprocess.Popen(
        command, stderr=subprocess.PIPE, text=True, cwd=tmp_path, env=os.environ | cache
    ) as process:
        lines = []
        while not any("compiling once" in line for line in lines):
            lines.append(process.stderr.readline())
            assert lines[-1], lines
        time.sleep(1.0)
        process.send_signal(signal.SIGINT)
        began = time.monotonic()
        rest = process.communicate(timeout=60)[1]
    assert time.monotonic() - began < PROMPT
    assert process.returncode == 130
    assert rest.count("run the same command again to resume") == 1


def test_another_version_does_not_use_the_same_store(tmp_path):
    hc.design(problem(), budget=90, store=tmp_path / "store")
    (journal,) = (tmp_path / "store").rglob("*.journal")
    journal.write_bytes(journal.read_bytes().replace(b"version=", b"version=0.0."))
    with pytest.raises(hc.InputError, match="another version of hertzchain; remove it"):
        hc.design(problem(), budget=90, store=tmp_path / "store")


@pytest.mark.long
def test_searches_with_other_options_have_their_own_journals(file, tmp_path, run):
    options = ([], ["--seed", "3"], ["--budget", "150"], ["--method", "evolution"], ["--seed", "3"])
    found = [json.loads(run(file, "--json", *each).stdout) for each in options]
    assert found[1]["radii"] == found[4]["radii"]
    names = sorted(each.name for each in (tmp_path / "problem.design").rglob("*.journal"))
    assert len(names) == 4
    assert [name.partition("-")[2] for name in names if name.startswith("evolution")] == [
        "400-simulations-seed-2.journal"
    ]


@pytest.mark.long
def test_an_edited_problem_has_a_folder_of_its_own(file, tmp_path, run):
    first = json.loads(run(file, "--json").stdout)
    (journal,) = (tmp_path / "problem.design").rglob("*.journal")
    content = journal.read_bytes()
    file.write_text(PROBLEM.replace("[0.5, 1.0]", "[0.6, 1.0]"))
    edited = json.loads(run(file, "--json").stdout)
    fresh = json.loads(run(file, "--json", "--store", "other").stdout)
    assert edited["radii"] == fresh["radii"] != first["radii"]
    file.write_text(PROBLEM)
    assert json.loads(run(file, "--json").stdout)["radii"] == first["radii"]
    journals = list((tmp_path / "problem.design").rglob("*.journal"))
    assert len({each.parent for each in journals}) == len(journals) == 2
    assert journal.read_bytes() == content


def test_the_command_writes_chain_figure_and_json(file, tmp_path, run):
    found = run(file, "--out", "chain.toml", "--plot", "design.png", "--json")
    assert found.returncode == 0, found.stderr
    document = json.loads(found.stdout)
    chain = hc.load_chain(tmp_path / "chain.toml")
    assert chain.radii.tolist() == document["radii"]
    assert document["value"] == pytest.approx(wall_peak(chain, 30.0), rel=1e-7)
    assert (tmp_path / "design.png").stat().st_size > 20_000
    assert list((tmp_path / "problem.design").rglob("*-400-simulations-seed-2.journal"))


BALLS = """
[chain]
diameters = "6.35 mm"
materials = "steel-52100"
beads = 4
velocity = "0.2 m/s"
right_wall = {material = "steel-52100"}

[design]
minimise = ["wall_force.peak", "length"]

[[design.vary]]
balls = "bearing-balls"
materials = ["steel-52100", "ptfe"]
diameters = ["3.9688 mm", "5.5562 mm"]
optional = true
"""


@pytest.mark.long
def test_all_points_of_a_front_are_written(file, tmp_path, run):
    file.write_text(BALLS)
    points = json.loads(run(file, "--out", tmp_path / "row.toml", "--json").stdout)["front"]
    run(file, "--out", tmp_path / "row.csv")
    names = [f"row-{i}" for i in range(1, len(points) + 1)]
    assert len(points) > 2
    assert sorted(each.stem for each in tmp_path.glob("row*.toml")) == names
    for name, point in zip(names, points, strict=True):
        chain = hc.load_chain(tmp_path / f"{name}.toml")
        assert chain.radii.tolist() == point["radii"]
        assert [each.name for each in chain.materials] == point["materials"]
        assert 2.0 * chain.radii.sum() == pytest.approx(point["values"]["length"])
        assert "radii" not in (tmp_path / f"{name}.toml").read_text()
        table = hc.load_chain(tmp_path / f"{name}.csv")
        np.testing.assert_array_equal(table.masses, chain.masses)
    assert '["6.35 mm", ' in (tmp_path / "row-1.toml").read_text()


def test_the_verification_of_a_front_is_reported_in_a_pipe(file, monkeypatch, run):
    """As the search, which the budget ends before: a command in a log must not seem to hang."""
    monkeypatch.setattr(pareto, "INTERVAL", 0.0)
    file.write_text(BALLS)
    done = run(file, "--json")
    count = len(json.loads(done.stdout)["front"])
    lines = [f"hertzchain: verified {i} of {count} points of the Pareto front"
             for i in range(1, count + 1)]  # fmt: skip
    assert [line for line in done.stderr.splitlines() if "verified" in line] == lines


def test_a_dry_run_states_the_search_and_the_given_chain(file, tmp_path, run):
    file.write_text(BALLS.replace('["wall_force.peak", "length"]', '"wall_force.peak"'))
    shown = run(file, "--dry-run", "--budget", "500").stdout.splitlines()
    chain = hc.load_design(file)[0].chain
    peak = hc.simulate(chain, rtol=1e-10).wall_force().peak
    # Two materials and two sizes for up to three places.
    assert shown[0] == "objective: smallest wall_force.peak"
    assert shown[1] == "84 choices for 3 places, method 'enumerate'"
    assert shown[2] == "12 chains to compare with, budget 500 simulations"
    assert shown[3] == f"the given chain: wall_force.peak {peak:.4g} N"
    assert re.fullmatch(r"  pressure / yield 0\.\d+ at contact \d+ .limit 1.", shown[4])
    document = json.loads(run(file, "--dry-run", "--budget", "10 s", "--json").stdout)
    assert document["values"]["wall_force.peak"] == pytest.approx(peak, rel=1e-6)
    assert 0.0 < document["seconds_per_trial"] < 1.0
    assert not list(tmp_path.glob("*.design"))
    # No choice is tried twice.
    document = json.loads(run(file, "--dry-run", "--json").stdout)
    assert document["seconds"] == pytest.approx(84 * document["seconds_per_trial"])


def test_the_time_of_a_genetic_search_is_estimated_with_its_batches(monkeypatch):
    """A trial takes 1 ms, and a batch 5 ms more, as with calls that several threads share."""
    clock = [0.0]

    def values(_trials, points, _rtol):
        clock[0] += 5e-3 + 1e-3 * len(points)
        # Three neighbours matter together, and there are many local optima.
        rows = np.array(points)
        triples = rows[:, :-2] + 2 * rows[:, 1:-1] + 4 * rows[:, 2:]
        return np.sin(37.0 * triples * np.arange(1, rows.shape[1] - 1)).sum(axis=1, keepdims=True)

    chain = hc.Chain.from_materials(
        "2.38125 mm", "steel-52100", beads=17, velocity="1 m/s",
        right_wall=hc.Wall.of("steel-52100"),
    )  # fmt: skip
    balls = hc.vary.balls(
        materials=["steel-52100", "ptfe"], diameters=["4.7625 mm"], beads="2:"
    )  # fmt: skip
    problem = hc.Design(chain, minimise="wall_force.peak", vary=[balls])
    monkeypatch.setattr(Trials, "_values", values)
    monkeypatch.setattr(timing.time, "perf_counter", lambda: clock[0])
    found = dry_run(problem, budget=3000, method="genetic", threads=1)
    slow = dataclasses.replace(found, trial=0.1098)
    assert "about 110 ms per trial" in in_lines(problem, slow)
    whole = Trials(problem, budget_from(3000), Journal(None, ""), 0, 1)
    begun = clock[0]
    search(whole, 1.0, 0)
    # The two chains to compare with take 3.5 ms each, which would be 10.5 s.
    assert 1.3 > (clock[0] - begun) / found.seconds > 1.0 / 1.3


def test_the_summary_states_that_the_arriving_ball_counts(file, run):
    file.write_text(BALLS.replace('["wall_force.peak", "length"]', '"length"'))
    with file.open("a") as stream:
        stream.write('[design.subject_to]\n"wall_force.peak" = "<= 20 N"\nmass = "<= 1.2 g"\n')
    lines = run(file).stdout.splitlines()
    assert re.fullmatch(r"Smallest length: \d+\.?\d* mm with the arriving ball", lines[0])
    assert "parts, without the arriving ball:" in lines
    assert any(re.fullmatch(r"  mass <= 1.2 g: 1\.\d+ g with the arriving ball", x) for x in lines)
    # PTFE yields, which changes the force but not the length.
    assert not any("ElasticPlastic" in line for line in lines)
    (force,) = (line for line in lines if line.startswith("  wall_force.peak <= 20 N"))
    assert re.search(r" N with contacts that yield, \S+ N at 2.8 Y\)$", force)
    (place,) = (i for i, x in enumerate(lines) if "row of equal balls " in x and "tried" in x)
    equal = "".join(lines[place : place + 2])
    assert ("NOT meet" in equal) != ("of this value" in equal)
    assert ("  row of equal balls closest to the constraints (of " in equal) == (
        "NOT meet" in equal
    )


def test_constraints_that_cannot_be_met_give_exit_code_3(file, run):
    file.write_text(PROBLEM + '[design.subject_to]\n"wall_force.impulse_of_impact" = "<= 0.5"\n')
    chain = file.with_name("found.toml")
    found = run(file, "--out", chain)
    assert found.returncode == 3
    assert "cannot be met: wall_force.impulse_of_impact is at least 1" in found.stdout
    assert not chain.exists()
    assert f"{chain} was not written, because there is no design" in found.stderr


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("[[design.vary]]\nradii = [0.5, 1.0]", "", "no table [[design.vary]]"),
        ("radii = [0.5, 1.0]", "radius = [0.5, 1.0]", "has one of radii, diameters, masses"),
        ("radii = [0.5, 1.0]", "radii = [0.5]", "the smallest and the largest value"),
        ("radii = [0.5, 1.0]", 'radii = [0.5, 1.0]\nkind = "x"', "unknown key of radii"),
        (
            "radii = [0.5, 1.0]",
            "radii = [0.5, 1.0]\nscatter = {radius = 0.01}",
            "scatter is a key of [design], not of [[design.vary]]",
        ),
        ("minimise", "minimize", "unknown key of [design] 'minimize'"),
        ("right_wall = {gap = 0.0}", "", "needs a right wall"),
        ("budget = 400", "budget = 0", "budget must be a whole number of at least 1"),
        ("budget = 400", 'budget = "soon"', "a number of simulations or a time"),
        (
            'minimise = "wall_force.peak"',
            'minimise = ["wall_force.peak", "wall_force.peak"]',
            "a Pareto front needs two different measures, got wall_force.peak twice",
        ),
        (
            "[[design.vary]]",
            '[design.subject_to]\nwall_force.peak = "<= 30 N"\n[[design.vary]]',
            'because of the dot: write "wall_force.peak" = "<= 30 N"',
        ),
        (
            'minimise = "wall_force.peak"',
            "minimise = {wall_force.peak = 1.0}",
            'because of the dot: write "wall_force.peak" = 1.0',
        ),
        ("[design]", "[other]", "unknown table of a design file 'other'"),
        ("[design]", "[desing]", "did you mean 'design'"),
    ],
)
def test_invalid_files_are_explained(file, old, new, told, monkeypatch):
    file.write_text(PROBLEM.replace(old, new))
    monkeypatch.chdir(file.parent)

    def search():
        found, options = hc.load_design(file)
        hc.design(found, **options)

    with pytest.raises(hc.InputError) as error:
        search()
    assert told in str(error.value)
    assert "\n" not in str(error.value)


def test_unknown_names_of_all_tables_are_reported_together(file):
    text = PROBLEM.replace("beads = 8", "beads = 8\nmasss = 1").replace("wall_force.peak", "pk")
    limits = '[design.subject_to]\nlenth = "<= 80"\n[design.scatter]\nradus = 0.1\n'
    file.write_text(text.replace("budget", "budjet").replace("seed", "sead") + "foo = 1\n" + limits)
    with pytest.raises(hc.InputError) as error:
        hc.load_design(file)
    head, *found = str(error.value).splitlines()
    assert head.endswith("5 errors:")
    assert [line.partition(":")[0].strip() for line in found] == [
        "unknown keys of [design] 'budjet' (did you mean 'budget'?), 'sead' (did you mean 'seed'?)",
        "unknown quantities 'pk', 'lenth' (did you mean 'length'?)",
        "unknown key of radii in [[design.vary]] 'foo'",
        "unknown key of [design.scatter] 'radus' (did you mean 'radius'?)",
        "unknown key of [chain] 'masss' (did you mean 'masses'?)",
    ]


def test_invalid_values_of_all_tables_are_reported_together(file):
    limits = '[design.subject_to]\nlength = "80"\n"velocity@last" = "= 1"\n'
    limits += "[design.scatter]\nradius = -0.1\n"
    file.write_text(re.sub("seed = .*", "seed = -1", PROBLEM) + limits)
    with pytest.raises(hc.InputError) as error:
        hc.load_design(file)
    head, *found = str(error.value).splitlines()
    assert head.endswith("4 errors:"), found
    starts = "seed must be", "scatter of the radius", "the constraint on length"
    for line, start in zip(found, (*starts, "the constraint on velocity@last"), strict=True):
        assert line.strip().startswith(start)
    # Unknown names do not hide invalid limits.
    file.write_text(f'{PROBLEM}[design.subject_to]\nlenth = "<= 80"\n"velocity@last" = "= 1"\n')
    with pytest.raises(hc.InputError, match=r"(?s)2 errors:.*'lenth'.*constraint on velocity@last"):
        hc.load_design(file)


STEEL = hc.Chain.from_materials(5e-3, "steel-304", beads=6, velocity=1.0)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"vary": []}, "vary has no variables"),
        (
            {
                "chain": STEEL.replace(loss=hc.ElasticPlastic()),
                "minimise": ["velocity@last", "mass"],
                "vary": [hc.vary.radii("4 mm", "6 mm")],
                "subject_to": {"yield_ratio": "<= 1"},
            },
            "all contacts of this chain have a law with yield (ElasticPlastic): omit yield_ratio",
        ),
        ({"vary": [hc.vary.radii(1.0, 0.5)]}, "leaves nothing to vary"),
        ({"vary": [hc.vary.radii(-1.0, 0.5)]}, "smallest radius must be above 0"),
        ({"vary": [hc.vary.radii(0.5, 1.0), hc.vary.radii(0.6, 1.0)]}, "place 2 varies twice"),
        ({"vary": [hc.vary.radii(0.5, 1.0, beads="1:")]}, "is the unit of length"),
        ({"vary": [hc.vary.radii(0.5, 1.0, beads="3:20")]}, "is outside 1 to 8"),
        ({"vary": [hc.vary.radii(0.5, 1.0, by="spline", knots=30)]}, "too many for 8 beads"),
        ({"vary": [hc.vary.balls()]}, "build the chain with Chain.from_materials"),
        ({"vary": [hc.vary.order()]}, "all beads that can be exchanged are equal"),
        ({"minimise": "wall_force.pek"}, "did you mean 'wall_force.peak'"),
        ({"minimise": "peak force"}, "did you mean 'wall_force.peak'"),
        ({"minimise": "velocity"}, "needs a bead: write velocity@20"),
        ({"minimise": "velocity@9"}, "this chain has 8 beads"),
        ({"minimise": "largest_velocity@5"}, "because waves return; give until"),
        ({"minimise": "largest_velocity@9", "until": 9.0}, "this chain has 8 beads"),
        (
            {"chain": WALLED.replace(loss=hc.WaltonBraun(0.5)), "minimise": "largest_energy@5"},
            "needs a chain without drive that is elastic",
        ),
        ({"minimise": "largest_velocity@5/velocity@2"}, "must be quantities of the leading pulse"),
        ({"maximise": "length"}, "has one of minimise, maximise and match"),
        ({"minimise": {"length": 0.0}}, "all weights of the objective are 0"),
        ({"minimise": "price"}, "price needs balls of a catalogue"),
        ({"minimise": "yield_ratio"}, "needs a chain with materials"),
        ({"subject_to": {"length": "= 3"}}, "must look like '<= 5'"),
        ({"subject_to": {"length": "== 3"}}, "give both: ['<= 3', '>= 3']"),
        ({"subject_to": {"length": "about 1"}}, "give both: ['<= 5', '>= 5']"),
        ({"subject_to": {"length": 3}}, "give both: ['<= 5', '>= 5']"),
        ({"subject_to": {"length": ["<= 3", ">= 4"]}}, "exclude each other"),
        ({"subject_to": {"length": "<= 3 mm"}}, "scaled variables"),
        ({"scatter": {"radius": 0.01, "measure": "cvar"}}, "must be 'mean' or"),
        ({"scatter": {"grade": 10}}, "use Chain.from_materials"),
        ({"model": "hard-sphere"}, "does not give wall_force.peak"),
        ({"chain": STEEL, "minimise": "wall_force.peak"}, "needs a right wall"),
        (
            {"chain": WALLED.replace(loss=hc.Viscoelastic(0.1)), "minimise": "largest_force"},
            "and this chain has losses; use wall_force.peak",
        ),
    ],
)
def test_invalid_problems_are_explained_in_one_sentence(options, told):
    with pytest.raises(hc.InputError) as error:
        problem(**options)
    assert told in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"method": "genetic"}, "cannot vary sizes"),
        ({"method": "law"}, "method 'law' needs one spline"),
        ({"method": "scan"}, "method 'scan' has one variable, got 7"),
        ({"budget": 0}, "budget must be a whole number of at least 1"),
        ({"points": 1}, "points must be a whole number from 2"),
        ({"seed": -1}, "seed must be a whole number of at least 0"),
    ],
)
def test_invalid_options_are_explained(options, told):
    with pytest.raises(hc.InputError, match=told):
        hc.design(problem(), **options)


@pytest.mark.long
@pytest.mark.parametrize(
    ("options", "least", "told"),
    [
        ({}, 82, "81 chains to compare with and 1 trial need 82"),
        ({"scatter": {"radius": 0.01}}, 3280, "1 trial, of 40 samples each, need 3280"),
        ({"minimise": ["wall_force.peak", "length"]}, 85, "and 4 trials need 85"),
    ],
)
def test_a_budget_below_one_trial_is_explained(options, least, told):
    with pytest.raises(hc.InputError, match=told):
        hc.design(problem(**options), budget=least - 1, points=4)
    assert hc.design(problem(**options), budget=least, points=4).runs <= least


@pytest.mark.long
def test_no_search_exceeds_its_budget():
    """Each trial chain is counted where it is simulated."""
    damped = WALLED.replace(loss=hc.Dashpot(0.1))
    order = hc.Chain.from_radii([1.0, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1])
    cases = [
        ({}, {"method": "gradient"}, 131),
        ({}, {"method": "evolution"}, 131),
        ({}, {"method": "hybrid"}, 131),
        ({"chain": damped}, {"method": "gradient"}, 131),
        ({"scatter": {"radius": 0.01, "samples": 4}}, {"method": "gradient"}, 403),
        ({"minimise": ["wall_force.peak", "length"]}, {"points": 3}, 131),
        ({"vary": [hc.vary.radii(0.5, 1.0, by="common")]}, {}, 31),
        ({"chain": order, "minimise": "velocity@last", "vary": [hc.vary.order()]}, {}, 131),
    ]
    for options, how, budget in cases:
        given = problem(**options)
        with counted_chains() as count:
            found = hc.design(given, budget=budget, **how)
        assert found.runs <= budget
        # A gradient is counted as two simulations and central differences have none of their own.
        assert count[0] <= budget, (options, how)
        assert found.runs >= 0.75 * budget, (options, how)


@contextmanager
def counted_chains():
    """Count the chains that trials simulate."""
    count, own = [0], trials.measured
    with pytest.MonkeyPatch.context() as patch:

        def counting(chains, *args, **options):
            count[0] += len(chains)
            return own(chains, *args, **options)

        patch.setattr(trials, "measured", counting)
        yield count


def orders(loss=None):
    chain = hc.Chain.from_radii([1.0, *np.linspace(0.5, 1.2, 8)]).replace(loss=loss)
    return problem(chain=chain, minimise="velocity@last", vary=[hc.vary.order()])


def test_a_budget_of_time_ends_an_enumeration():
    """Of 40 320 orders, few can be simulated in 0.2 s."""
    found = hc.design(orders(), budget="0.2 s", method="enumerate")
    assert found.runs < 20_000
    (line,) = (line for line in found.summary().splitlines() if "choices" in line)
    assert f"best of the first {found.runs} of 40320 choices: the budget was used up" in line
    assert "give a larger budget, or method 'genetic'" in line


@pytest.mark.long
@pytest.mark.parametrize("method", ["auto", "enumerate"])
def test_a_budget_of_time_is_kept_by_slow_chains(method):
    """A batch of 512 chains with losses takes several seconds."""
    given = orders(hc.Restitution(0.9))
    hc.design(given, budget=100)  # compiled
    found = hc.design(given, budget="1 s", method=method)
    assert 20 < found.runs < 5000
    assert 0.9 < found.seconds < 5.0


@pytest.mark.parametrize(("budget", "method"), [("1 s", "genetic"), ("1 h", "enumerate")])
def test_a_budget_of_time_permits_an_enumeration_if_there_are_few_choices(budget, method):
    limit = budget_from(budget)
    given = orders()
    assert method_for(given, "auto", simulations_within(limit, given)) == method


def test_a_search_with_a_budget_of_time_resumes(tmp_path):
    """The numbers of trials between two checks of the time follow from the journal."""
    given, store = orders(), tmp_path / "store"
    first = hc.design(given, budget="0.5 s", store=store)
    again = hc.design(given, budget="0.5 s", store=store)
    assert again.runs == first.runs > 0
    assert again.value == first.value
    np.testing.assert_array_equal(again.history, first.history)


@pytest.mark.parametrize(("vary", "most"), [
    (hc.vary.radii(0.5, 1.0), "'gradient', which can use 2000"),
    (hc.vary.gaps(0.0, 0.1, contacts="1:2001"), "'hybrid', which can use 500"),
])  # fmt: skip
def test_too_many_variables_are_explained(vary, most):
    chain = hc.Chain.uniform(2002).replace(right_wall=hc.Wall())
    with pytest.raises(hc.InputError, match=f"2001 variables are too many for method {most}"):
        hc.design(problem(chain=chain, vary=vary), budget=10)


def test_catalogues_and_chain_files_have_the_same_headers(tmp_path):
    file = tmp_path / "balls.csv"
    file.write_text("Diameter (mm),Material\n4,ptfe\n")
    (ball,) = load_balls(file)
    assert (ball.diameter, ball.material.name) == (pytest.approx(4e-3), "ptfe")


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ("diameter [mm],material\n4,unobtainium\n", "row 1: unknown material"),
        ("diameter,material\n4,ptfe\n", "has no unit"),
        ("diameter [mm]\n4\n", "no column material"),
        ("diameter [mm],material\n", "has no balls"),
        ("diameter [mm],material\n-4,ptfe\n", "must be above 0"),
        ("diameter [mm],material\n.005,ptfe\n", "write diameter [m] if the column is in metres"),
        ("diameter [mm],material,colour\n4,ptfe,red\n", "unknown or repeated"),
        ("diameter [mm],material,price\n4,ptfe,-1\n", "price in row 1 must be at least 0"),
        ("diameter [mm],material\n4,\n", "row 1 has no material"),
    ],
)
def test_invalid_catalogues_are_explained(tmp_path, content, told):
    file = tmp_path / "balls.csv"
    file.write_text(content)
    with pytest.raises(hc.InputError) as error:
        problem(chain=STEEL, minimise="velocity@last", vary=[hc.vary.balls(file)])
    assert told in str(error.value)


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("optional = 1", "optional must be true or false, got 1"),
        ('balls = "bearing-ball"', "did you mean 'bearing-balls'?"),
    ],
)
def test_mistakes_in_tables_of_balls_are_explained_in_the_words_of_the_file(tmp_path, line, told):
    file = tmp_path / "problem.toml"
    balls = "" if line.startswith("balls") else 'balls = "bearing-balls"\n'
    file.write_text(
        '[chain]\ndiameters = "5 mm"\nmaterials = "steel-304"\nbeads = 4\n'
        f'[design]\nminimise = "velocity@last"\n[[design.vary]]\n{balls}{line}\n'
    )
    with pytest.raises(hc.InputError) as error:
        hc.load_design(file)
    assert told in str(error.value)


def test_rejected_trials_are_counted_in_a_search_that_resumes(tmp_path):
    given = {"budget": 200, "method": "evolution", "store": tmp_path / "store"}
    first, again = (hc.design(overflowing(), **given) for _ in range(2))
    assert first.rejected == again.rejected > 0
    assert first.notes == again.notes


def test_a_row_without_balls_is_no_choice():
    """The arriving ball alone is not simulated; with a second one, it may be."""
    balls = hc.vary.balls(materials="steel-304", diameters=["3 mm", "4 mm"], optional=True)
    chain = hc.Chain.from_materials("2 mm", "steel-304", beads=4, velocity=0.001)
    for beads, count, empty in (("2:", 14, False), ("3:", 7, True)):
        some = dataclasses.replace(balls, beads=beads)
        given = hc.Design(chain, maximise="energy_share@last", vary=[some])
        rows = [tuple(each) for each in given.space.rows()]
        assert given.space.count == len(rows) == len(set(rows)) == count
        assert any(set(row) == {2} for row in rows) == empty
        for method in ("enumerate", "genetic"):
            assert hc.design(given, budget=60, method=method).rejected == 0


def overflowing():
    # Masses of radii above 1e102 overflow.
    return hc.Design(
        hc.Chain.uniform(4), minimise="velocity@last", model="hard-sphere",
        vary=[hc.vary.radii(0.3, 1e120, beads="2:3")],
    )  # fmt: skip


def test_trials_that_cannot_be_simulated_are_rejected_and_counted():
    found = hc.design(overflowing(), budget=200, method="evolution")
    assert found.rejected > 0
    assert f"note: {found.rejected} trials were rejected, the first one because " in found.summary()


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::hertzchain.IncompleteWarning")
@pytest.mark.parametrize(("until", "said"), [(9.2e-5, "no rejected"), (8.5e-5, "may be better")])
def test_rejected_trials_are_compared_with_the_design(until, said):
    chain = hc.Chain.from_materials("3 mm", "steel-52100", beads=4, velocity=0.1)
    chain = chain.replace(right_wall=hc.Wall.of("steel-52100"))
    sizes = hc.vary.balls(materials="steel-52100", diameters=["3 mm", "6 mm"], beads="2:")
    problem = hc.Design(chain, minimise="wall_force.peak", vary=[sizes], until=until)
    found = hc.design(problem, budget=50, method="enumerate")
    rows = [chain.replace(radii=np.array([3e-3, *radii]))
            for radii in itertools.product((1.5e-3, 3e-3), repeat=3)]  # fmt: skip
    rejected = [row for row in rows if not hc.simulate(row, until=until).wall_force().complete]
    assert found.rejected == len(rejected) > 0
    reached = np.array([wall_peak(row, until) for row in rejected])
    better = int((reached < found.value).sum())
    headline = f"best of {8 - len(rejected)} of 8 choices ({len(rejected)} were rejected, see the"
    assert headline in found.summary()
    equal = sum(len(np.unique(row.radii[1:])) == 1 for row in rejected)
    assert (f"{equal} of 2 chains for the comparison with 'equal balls in the places that vary'"
            in found.summary()) == (equal > 0)  # fmt: skip
    last = found.notes[-1]
    assert said in last
    if better:
        assert last.startswith(f"{better} rejected trial")
    else:
        assert float(last.split()[-2]) == pytest.approx(reached.min(), rel=2e-4)
    (first,) = (note for note in found.notes if "wall_force.peak is not complete: largest" in note)
    assert "; omit until, or use wall_force.largest_so_far" in first


def test_a_trial_whose_peak_a_more_accurate_simulation_completes_is_described_as_such(monkeypatch):
    chain = hc.Chain.from_materials("3 mm", "steel-52100", beads=3, velocity=0.1)
    chain = chain.replace(right_wall=hc.Wall.of("steel-52100"))
    some = hc.vary.balls(materials="steel-52100", diameters=["3 mm", "6 mm"], beads="2:")
    problem = hc.Design(chain, minimise="wall_force.peak", vary=[some])
    trials = Trials(problem, budget_from(9), Journal(None, ""), seed=0)
    point = next(iter(problem.space.rows()))
    trials.failures.append(point)
    unknown = np.full((1, len(trials.measures)), np.nan)
    monkeypatch.setattr(Trials, "_values", lambda *_: unknown)
    peak = hc.simulate(problem.space.chain_of(point), rtol=1e-11).wall_force().peak
    why = why_rejected(trials)
    assert why.startswith("wall_force.peak was not complete at the tolerance of the search; rep")
    assert float(why.split()[-2]) == pytest.approx(peak, rel=1e-3)


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::hertzchain.errors.ModelRangeWarning")
def test_vertical_rows_can_be_compared_by_the_largest_force_in_the_run():
    """Beads that fall back to the wall keep its peak from being complete at a given end."""
    row = hc.Chain.from_materials("3 mm", "steel-52100", beads=2, velocity=0.0)
    chain = row.struck_by(mass=0.03, radius=math.inf, material="steel-304", velocity=0.1)
    chain = chain.replace(right_wall=hc.Wall.of("steel-52100"), gravity=9.81)
    balls = hc.vary.balls(materials="steel-52100", diameters=["5 mm", "6 mm"], beads="2:")
    given = {"vary": [balls], "until": "5 ms"}
    why = r"none of 4 .*: wall_force.peak is not complete: .*; use"
    with pytest.raises(hc.InputError, match=f"{why} wall_force.largest_so_far"):
        hc.design(hc.Design(chain, minimise="wall_force.peak", **given))
    found = hc.design(hc.Design(chain, minimise="wall_force.largest_so_far", **given))
    assert found.rejected == 0
    assert any("is not a complete peak, so a larger force may follow" in x for x in found.notes)
    rows = [chain.replace(radii=np.array([chain.radii[0], *radii]))
            for radii in itertools.product((2.5e-3, 3e-3), repeat=2)]  # fmt: skip
    peaks = hc.simulate_many(rows, keep=["wall_largest_so_far"], until=5e-3)["wall_largest_so_far"]
    best = int(peaks.argmin())
    assert found.chain.radii == pytest.approx(rows[best].radii)
    assert found.value == pytest.approx(wall_peak(rows[best], 3e-4), rel=1e-6)


@pytest.mark.long
def test_a_search_without_any_result_does_not_block_a_corrected_file(file, tmp_path, run):
    # The peak on a wall that no pulse reaches within this time is not known.
    file.write_text(PROBLEM.replace("seed = 2", "seed = 2\nuntil = 1.0"))
    failed = run(file)
    assert failed.returncode == 2
    assert "could be simulated with the required quantities" in failed.stderr
    assert not list((tmp_path / "problem.design").rglob("*.journal"))
    file.write_text(PROBLEM)
    corrected = run(file, "--json")
    assert corrected.returncode == 0, corrected.stderr
    fresh = run(file, "--json", "--store", "other")
    assert json.loads(corrected.stdout)["radii"] == json.loads(fresh.stdout)["radii"]


@pytest.mark.parametrize(
    ("changes", "fine"),
    [({}, False), ({"left_wall": hc.Wall.of("steel-304")}, True), ({"gravity": 9.81}, True)],
)  # fmt: skip
def test_chains_whose_beads_only_move_apart_are_rejected_at_once(changes, fine):
    chain = hc.Chain.from_materials("3 mm", "steel-304", beads=4, velocity=-0.3)
    chain = chain.replace(right_wall=hc.Wall.of("steel-304"), **changes)
    given = {"minimise": "largest_force", "until": 1e-3,
             "vary": [hc.vary.radii("2 mm", "4 mm", beads="2:")]}  # fmt: skip
    if fine:
        assert hc.Design(chain, **given).chain is chain
        return
    with pytest.raises(hc.InputError, match="the velocity of bead 1 is -0.3 m/s; give a positive"):
        hc.Design(chain, **given)


def test_chain_files_of_designs_have_units_and_end_with_a_newline():
    sizes = hc.vary.balls(materials="steel-304", diameters=["3 mm", "4 mm"], beads="2:")
    chain = hc.Chain.from_materials("2 mm", "steel-304", beads=4, velocity=0.3)
    found = hc.design(hc.Design(chain, maximise="velocity@last", vary=[sizes]), budget=30)
    text = chain_text(found)
    assert text.endswith("\n")
    assert 'velocity = "0.3 m/s"\n' in text
    assert "diameters = " in text


@pytest.mark.parametrize(
    ("limit", "optional", "said"),
    [
        # The arriving ball and a smallest one: a chain has two balls.
        ("7.9 mm", True, "length <= 7.9 mm cannot be met: every row has at least 8 mm"),
        ("8 mm", True, ""),
        ("13.9 mm", False, "length <= 13.9 mm cannot be met: every row has at least 14 mm"),
        ("14 mm", False, ""),
    ],
)
def test_balls_that_are_longer_than_a_limit_need_no_search(limit, optional, said):
    chain = hc.Chain.from_materials("2.5 mm", "steel-304", beads=4, velocity=0.01)
    chain = chain.replace(right_wall=hc.Wall.of("steel-304"))
    sizes = hc.vary.balls(
        materials="steel-304", diameters=["3 mm", "4 mm"], beads="2:", optional=optional
    )
    found = hc.design(
        hc.Design(chain, minimise="wall_force.peak", vary=[sizes],
                  subject_to={"length": f"<= {limit}"}), budget=30,
    )  # fmt: skip
    assert found.met == (not said)
    assert (found.runs == 1) == bool(said)
    assert said in "".join(found.notes)
    # The first row, which is the value of the result, is not a design.
    shown = found.summary()
    assert (shown == f"No chain can meet the constraints, so nothing was searched: {said}") == bool(
        said
    )


@pytest.mark.parametrize("beads", ["2:", "2:3", "1:"])
@pytest.mark.parametrize("optional", [True, False])
@pytest.mark.parametrize("key", ["length", "mass", "beads", "price"])
def test_the_range_of_all_rows_is_that_of_the_balls_in_stock(key, optional, beads, tmp_path):
    """Limits within the range are searched; those outside are not, to within rounding."""
    drawer = tmp_path / "drawer.csv"
    drawer.write_text(
        "diameter [mm],material,count,price\n3,ptfe,1,2\n4,steel-304,2,0.5\n5,ptfe,,3\n"
    )
    chain = hc.Chain.from_materials("2.5 mm", "steel-304", beads=4, velocity=0.01)
    kinds = hc.vary.balls(drawer, beads=beads, optional=optional)
    space = kinds.space(chain)
    measure = parse_measure(key)
    values = [measure.from_chain(space.chain_of(row), space.price(row)) for row in space.rows()]
    for sign, nearest in ((1, min(values)), (-1, max(values))):
        relation = "<=" if sign > 0 else ">="
        unit = "" if measure.unit == "1" else measure.unit
        for factor, met in ((1.0, True), (1.0 - 1e-3 * sign, nearest == 0.0)):
            given = hc.Design(
                chain, maximise="velocity@last", vary=[kinds],
                subject_to={key: f"{relation} {nearest * factor!r} {unit}"},
            )  # fmt: skip
            assert (impossible(given) is None) == met


def test_an_order_has_the_length_and_mass_of_its_balls():
    chain = hc.Chain.from_materials(["3 mm", "2 mm", "4 mm"], "steel-304", velocity=0.01)
    for limit, reason in (("<= 18 mm", None), ("<= 17 mm", "has at least 18 mm"),
                          (">= 19 mm", "has at most 18 mm")):  # fmt: skip
        given = hc.Design(chain, maximise="velocity@last", vary=[hc.vary.order()],
                          subject_to={"length": limit})  # fmt: skip
        told = impossible(given)
        assert told is None if reason is None else told.endswith(reason)


@pytest.mark.long
def test_diameters_vary_and_impossible_constraints_are_stated_before_the_search(tmp_path, run):
    file = tmp_path / "sizes.toml"
    text = """
[chain]
diameters = "10 mm"
materials = "steel-52100"
beads = 6
velocity = "0.01 m/s"
right_wall = {}
[design]
minimise = "wall_force.peak"
[[design.vary]]
diameters = ["5 mm", "10 mm"]
[design.subject_to]
"wall_force.impulse_of_impact" = "<= 1e-9 N*s"
"""
    file.write_text(text)
    found = run(file, "--dry-run")
    assert found.returncode == run(file, "--dry-run", "--json").returncode == 3
    shown = found.stdout
    assert "cannot be met" in shown
    assert "so no search is made" in shown
    assert "for the whole budget" not in shown
    file.write_text(text.partition("[design.subject_to]")[0])
    shown = run(file, "--dry-run", "--budget", "400").stdout
    assert "5 variables, method 'gradient'" in shown
    assert "for the whole budget, without the verification" in shown


@pytest.mark.parametrize("optional", [True, False])
def test_a_striker_that_varies_is_a_note(optional):
    row = hc.Chain.from_materials("3 mm", "steel-52100", beads=3, velocity=0.0)
    row = row.struck_by(radius="5 mm", velocity="0.1 m/s").replace(right_wall=hc.Wall())
    sizes = {"materials": "steel-52100", "diameters": ["5 mm", "8 mm"], "optional": optional}
    notes = []
    for beads in ("1:", "2:"):
        given = hc.Design(row, minimise="wall_force.peak",
                          vary=[hc.vary.balls(beads=beads, **sizes)])  # fmt: skip
        found = hc.design(given, budget=100)
        notes.append([each for each in found.notes if "striker" in each])
        text = in_lines(given, dry_run(given, budget=100))
        value, own = given.evaluate(row).values["wall_force.peak"], found.value
        assert (
            f"  given chain: {value:.4g} N\n    this design: {own / value:.1%}" in found.summary()
        )
        assert [f"note: {each}" for each in notes[-1]] == [
            line for line in text.splitlines() if "striker" in line
        ]
    assert notes == [["the striker varies, too, and with it the impact; beads = '2:' lets only the "
                      "beads behind vary"], []]  # fmt: skip


def test_a_dry_run_states_that_contacts_yield_which_the_search_assumes_to_be_elastic():
    row = hc.Chain.from_materials("3 mm", "steel-52100", beads=3, velocity="1 m/s")
    row = row.replace(right_wall=hc.Wall())
    with pytest.warns(hc.ModelRangeWarning, match="pressure / yield is") as caught:
        hc.simulate(row, rtol=1e-10)
    ratio = re.search(r"yield is (\S+) at", str(caught[0].message))[1]
    for limits, advice in (({}, "search with"), ({"yield_ratio": "<= 9"}, "remove yield_ratio")):
        given = hc.Design(row, minimise="wall_force.peak", subject_to=limits,
                          vary=[hc.vary.balls(materials="steel-52100", beads="2:")])  # fmt: skip
        text = in_lines(given, dry_run(given, budget=600))
        assert re.search(rf"  pressure / yield {ratio} at contact \d .*: {advice}", text)
        assert "the search assumes elastic contacts" in text


def test_a_dry_run_of_slow_trials_times_few(monkeypatch):
    given = problem()
    clock, count = [0.0], []

    def values(_trials, points, _rtol):
        count.append(len(points))
        clock[0] += 3.0 * len(points)
        return np.ones((len(points), 1))

    monkeypatch.setattr(Trials, "_values", values)
    monkeypatch.setattr(time, "perf_counter", lambda: clock[0])
    assert dry_run(given, budget=400, threads=1).trial == pytest.approx(3.0)
    assert sum(count) == 2


@pytest.mark.long
def test_a_dry_run_skips_balls_without_the_properties_of_the_law(tmp_path):
    """Glass has no yield strength; a search rejects its rows, and a dry run times the others."""
    steel = hc.Chain.from_materials("3 mm", "steel-304", beads=3, velocity=0.3)
    chain = steel.replace(right_wall=hc.Wall.of("steel-304"), loss=hc.ElasticPlastic())
    (tmp_path / "stock.csv").write_text("diameter [mm],material\n6,steel-304\n6,glass\n")
    balls = hc.vary.balls(tmp_path / "stock.csv", beads="2:")
    found = dry_run(hc.Design(chain, minimise="wall_force.peak", vary=[balls]), budget=50)
    assert found.choices == 4
    assert found.trial > 0.0


def test_a_dry_run_needs_no_row_of_equal_balls(tmp_path):
    """The stock has too few balls of each size for one."""
    chain = hc.Chain.from_materials("3 mm", "steel-304", beads=5, velocity=0.1)
    (tmp_path / "stock.csv").write_text(
        "diameter [mm],material,count\n6,steel-304,3\n8,steel-304,3\n"
    )
    balls = hc.vary.balls(tmp_path / "stock.csv", beads="2:")
    given = hc.Design(chain.replace(right_wall=hc.Wall()), minimise="wall_force.peak", vary=[balls])
    found = dry_run(given, budget=50)
    # All rows of four balls but those of four equal ones; those with balls sorted by size.
    assert (found.choices, found.compared) == (2**4 - 2, 4)
    assert found.trial > 0.0


def test_progress_of_an_enumeration_has_the_number_of_choices():
    balls = hc.vary.balls(materials="steel-304", diameters=["5 mm", "6 mm"], beads="2:")
    chain = hc.Chain.from_materials("3 mm", "steel-304", beads=4, velocity=0.1)
    reports = []
    hc.design(
        hc.Design(chain, minimise="velocity@last", vary=[balls]),
        method="enumerate", progress=lambda *each: reports.append(each),
    )  # fmt: skip
    assert {total for _, total in reports} == {8}
    assert reports[-1] == (8, 8)


def test_the_remaining_time_does_not_include_compilation(monkeypatch):
    clock = iter([0.0, 100.0, 102.0])
    monkeypatch.setattr("hertzchain.cli.progress.time.monotonic", lambda: next(clock))
    pace = _Pace()
    assert [pace.text(done, 50) for done in (0, 1)] == ["", ""]
    assert pace.text(21, 50) == "10 per second, 0:00:03 left"
