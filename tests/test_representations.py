"""The representations of every public object: short, and with the numbers that matter."""

import re
import warnings

import matplotlib.pyplot as plt
import numpy as np
import pytest
from figure_texts import legend_texts

import hertzchain as hc
from hertzchain.app.wording import chain_in_words
from hertzchain.chain.drives import SineBurst, StepDrive, TableDrive
from hertzchain.evaluation import Case, paper_cases
from hertzchain.notebook.drawing import numbers, table
from hertzchain.paper import errata, reproduce, reproduce_figure, reproduce_table
from hertzchain.plotting.titles import chain_words
from hertzchain.recorded_warnings import ignore_warnings
from hertzchain.representation import (
    MAX_LINES,
    MAX_WIDTH,
    measure,
    percent,
    short,
    without_negative_zeros,
)
from hertzchain.sweeps.axes import Axis
from hertzchain.sweeps.specification import read_specification
from hertzchain.theory import RatioCorrection
from hertzchain.verification.case import Case as KnownValue

BEADS = (3, 300)
UNITS = ("scaled", "SI")


def balls(beads, units):
    if units == "SI":
        return hc.Chain.from_materials(5e-3, "steel-52100", beads=beads, velocity=0.1)
    return hc.Chain.uniform(beads)


def time_unit(chain):
    return hc.Scales.of(chain).time if chain.units == "SI" else 1.0


def run_of(beads, units):
    """A run of a chain in front of a wall, from which the pulse has just returned."""
    chain = balls(beads, units).replace(right_wall=hc.Wall())
    return hc.simulate(chain, until=(1.3 * beads + 8) * time_unit(chain), times=max(200, 7 * beads))


@pytest.fixture(scope="module", params=[(n, u) for u in UNITS for n in BEADS], ids=str)
def results(request):
    """Everything that one run and one pulse give, with words that the representation must have."""
    beads, units = request.param
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hc.IncompleteWarning)
        run = run_of(beads, units)
        wall = run.wall_force()
    kind = "steel-52100 " if units == "SI" else ""
    chain, free = run.chain, balls(beads, units)
    pulse = hc.bca(free)
    held = chain.replace(precompression=1.0, held_by="force")
    decorated = free.decorated(0.2)
    newton, speed = (" N", " m/s") if units == "SI" else ("", "")
    factor, second = 1.0, ""
    if units == "SI":
        factor, second = (1e6, " us") if beads == 3 else (1e3, " ms")
    end = f"t = {factor * run.times[-1]:.4g}{second}"
    found = [
        (chain, [f"{beads} {kind}beads", "right wall"]),
        (run, ["t = ", f"{len(run.times)} saved times", "energy drift"]),
        (
            run.state,
            [
                f"t = {factor * run.state.time:.4g}{second}",
                "steps",
                speed,
                "the last whole step before the end of the run",
            ],
        ),
        (run.budget(), [end, "energy", "momentum", "right wall", "adds up within"]),
        (wall, ["right wall", f"{wall.largest_so_far:.4g}{newton}", "contact"]),
        (run.sensor_force(2), ["bead 2", "first maximum", newton]),
        (run.leading_pulse(), [f"of {beads - 1} contacts", "momentum", "kinetic energy"]),
        (run.fronts(), [f"of {beads - 1} contacts", "t = "]),
        (run.velocity_peaks(2), ["bead 2", "the first", speed]),
        (run.pulse(), ["simulation", f"v_{beads} = ", speed]),
        (pulse, ["BCA", f"v_{beads} = {pulse.velocity[-1]:.4g}{speed}"]),
        (pulse.compare(hc.hard_sphere(free)), ["BCA against hard sphere", "velocity", "k = "]),
        (hc.propagate_many([free, free]), ["2 chains", f"up to {beads} beads"]),
        (
            hc.equilibrium(held),
            [
                f"{beads} beads",
                "static forces 1 N .. 1 N" if held.units == "SI" else "forces 1 .. 1",
            ],
        ),
        (hc.effective_chain(decorated), [f"{beads} large beads of {2 * beads - 1}"]),
        (hc.effective_chain(decorated).bca(), [f"v_{2 * beads - 1} = ", newton]),
    ]
    if units == "SI":
        found += [
            (hc.hertz_range(chain), ["overlap", "yield", "speed"]),
            (hc.Scales.of(chain), ["radius=0.005"]),
        ]
    return found


def check(item, words):
    text = repr(item)
    lines = text.split("\n")
    assert len(lines) <= MAX_LINES, text
    assert max(map(len, lines)) <= MAX_WIDTH, text
    assert text.startswith(type(item).__name__ + "("), text
    assert text.endswith(")"), text
    assert "array(" not in text
    joined = " ".join(text.split())
    for word in words:
        assert word in joined, (word, text)


def test_results_of_short_and_long_chains(results):
    for item, words in results:
        check(item, words)


@pytest.mark.parametrize("units", UNITS)
@pytest.mark.parametrize("beads", [8, 120])
def test_waves_and_what_belongs_to_them(beads, units):
    chain = balls(beads, units).replace(right_wall=hc.Wall.rigid())
    run = hc.simulate(chain, until=2.2 * beads * time_unit(chain), times=20 * beads)
    newton = " N" if units == "SI" else ""
    waves = run.waves()
    assert len(waves) > 1
    check(waves, ["right", "left", "the strongest", newton])
    check(waves[0], ["right, contacts", f"force {waves[0].amplitude:.4g}{newton}"])
    check(waves[0].events[0], ["contact", "to the right", f"{newton}, impulse"])
    with ignore_warnings():  # of contacts near the wall in a short chain
        reflection = run.reflection(beads // 2, beads)
    check(reflection, ["reflected energy", "transmitted energy", "1 wave"])
    check(run.energy_flux(), ["most to the right", "contact"])
    check(run.energy_flux().balance(beads // 2, beads), ["incident energy", "returned", "kept"])
    check(run.horizon(), ["predictable within 1%", "rtol 1e-13"])
    check(run, ["predictable"])
    assert len(str(waves).splitlines()) > len(waves)


@pytest.mark.parametrize("beads", [3, 200])
def test_spectra(beads):
    chain = balls(beads, "SI").replace(precompression=1.0, held_by="force")
    check(hc.spectrum(chain), [f"{beads} modes", "Hz"])


def test_everything_else(tmp_path):
    stored = hc.stream(hc.Chain.uniform(5), tmp_path / ("long" * 20), times=[1.0, 2.0])
    calibration = hc.calibrate("backward-linear", rates=(0.5,), beads=30, window=(5, 25))
    plan = {"chain": {"taper": "uniform"}, "axes": {"beads": list(range(5, 600))}}
    features = hc.Chain.uniform(5).replace(
        precompression=1.0, gravity=0.1, left_wall=hc.Wall(), right_wall=hc.Wall(),
        loss=hc.Dashpot(0.1), velocities=[1, 1, 0, 0, 0], masses=[1, 2, 3, 4, 5],
    )  # fmt: skip
    known = KnownValue("a group", "a quantity", 1.0, 0.1, "a source" * 50, float)
    for item, words in (
        (stored, []),
        (calibration, ["backward-linear", "1 rate", "RatioCorrection(ratio=", "rms"]),
        (hc.scoreboard(theories=["hard-sphere"]), ["1 theory on 52 chains"]),
        (hc.Verdict(known, 1.05), ["a quantity", "1.05", "expected 1 within 0.1", "agrees"]),
        (hc.Verdict(known, 1.5), ["does not agree"]),
        (known, ["a group, a quantity: 1 within 0.1"]),
        (paper_cases()[0], []),
        (Case("equal", "equal", "smooth", hc.Chain.uniform(30)), ["30 beads"]),
        (read_specification(plan), ["beads (595)", "propagate"]),
        (Axis(("rate",), {"linspace": [0.02, 0.1, 500]}), ["rate: 500 values", "0.02 .. 0.1"]),
        (hc.solitary_wave(), ["p = 1.5", "C = 0.9074"]),
        (hc.solitary_wave().velocity, []),
        (RatioCorrection(0.6), ["ratio=0.6"]),
        (features, ["5 beads", "precompression", "gravity", "left wall", "dashpot 0.1"]),
        (TableDrive(np.linspace(0, 1, 999), np.linspace(0, 1, 999)), ["999 times"]),
        (hc.material("brass"), ["8530 kg/m^3", "101 GPa"]),
        (hc.Material("x" * 400, 1e3, 1e9, 0.3), []),
    ):
        check(item, words)


@pytest.mark.parametrize(
    "item",
    [
        hc.Dashpot(0.1), hc.Restitution(0.9, attractive=False), hc.Viscoelastic(1e-6),
        hc.UnloadingRatio(0.1), hc.VelocityPower(0.1, 1.5), hc.WaltonBraun(0.9),
        SineBurst(1.0, 2.0), StepDrive(1.0, rise=0.5), RatioCorrection(0.6),
        hc.Scales(radius=0.005, mass=0.004073598474154764, velocity=0.1, length=1.97450360669e-06),
    ],
    ids=lambda item: type(item).__name__,
)  # fmt: skip
def test_simple_values_can_be_evaluated_again(item):
    check(item, [])
    assert eval(repr(item), vars(hc) | {type(item).__name__: type(item)}) == item


def test_what_does_not_fit_ends_in_an_ellipsis():
    text = short("Name", "about", *(["a fact of some length"] * 40))
    assert len(text.split("\n")) == MAX_LINES
    assert text.endswith("a fact of some length; ...)")
    # A number stays with its unit, and with the name before it.
    for width in range(60, 101):
        lines = short("Name", "x" * (width - 20), "at t = 1.25 s", "more", "y" * 40).split("\n")
        assert any("t = 1.25 s" in line for line in lines)


@pytest.mark.parametrize(
    ("item", "expected"),
    [
        (
            hc.Chain.dimer(diameters=["10 mm", "6 mm"], materials=["brass", "ptfe"], beads=9),
            "Chain(9 beads of brass and ptfe, diameters 10 mm and 6 mm in turn, impact at 1 m/s)",
        ),
        (
            hc.Chain.from_materials([5e-3, 3e-3], "brass", velocity=0.25),
            "Chain(2 brass beads, diameters 10 mm to 6 mm, impact at 0.25 m/s)",
        ),
        (
            hc.Chain.from_materials([10e-3] * 9 + [16.1e-3] + [10e-3] * 10, "steel-52100"),
            "Chain(20 steel-52100 beads, diameter 20 mm, except bead 10 (32.2 mm), "
            "impact at 1 m/s)",
        ),
        (
            hc.Chain.from_materials([4e-3, 5e-3, 5e-3, 5e-3], "brass"),
            "Chain(4 brass beads, diameter 10 mm, except bead 1 (8 mm), impact at 1 m/s)",
        ),
        (
            hc.Chain.from_materials(20e-6, "glass", beads=3, velocity=0.1),
            "Chain(3 glass beads, diameter 40 um, impact at 0.1 m/s)",
        ),
        (hc.Chain.from_materials(0.8, "glass", beads=3, precompression=1.0, held_by="force"),
         "Chain(3 glass beads, diameter 1.6 m, precompression, at rest)"),
        (hc.Chain.uniform(3), "Chain(uniform, 3 beads)"),
        (hc.Chain.dimer(0.3, beads=9), "Chain(dimer, mass ratio 0.3, 9 beads)"),
        (hc.Chain.dimer(0.3, beads=9).replace(stiffness=[2.0] * 8),
         "Chain(dimer, mass ratio 0.3, 9 beads, given masses, given stiffness)"),
        (hc.Chain.uniform(4).replace(masses=[1.0, 2.0, 1.0, 2.0]),
         "Chain(dimer, mass ratio 2, 4 beads)"),
        (hc.Chain.dimer(radii=[1.0, 0.5], beads=8), "Chain(dimer, radius ratio 0.5, 8 beads)"),
        (hc.Chain.dimer(radii=[1.0, 0.5], beads=8).struck_by(velocity=2.0),
         "Chain(dimer, radius ratio 0.5, 8 beads, and 1 striker, impact at 2)"),
        (hc.Chain.tapered("forward-linear", 0.01, beads=9).struck_by(radius=2.0, count=2),
         "Chain(forward-linear, S = 0.01, 9 beads, and 2 strikers (radius 2))"),
        (hc.Chain.tapered("backward-exponential", 0.3, beads=9).struck_by().struck_by(
            velocity=0.5),
         "Chain(backward-exponential, q = 0.3, 9 beads, and 2 strikers, velocities)"),
        (hc.Chain.uniform(2).replace(radii=[1.0, 2.0]).struck_by(),
         "Chain(given radii, 2 beads, and 1 striker)"),
        (hc.Chain.uniform(9).with_defects({1: 2.0}),
         "Chain(uniform except bead 1 (radius 2), 9 beads)"),
        (hc.Chain.from_radii([1.0, 0.5, 0.5, 0.5]),
         "Chain(uniform (radius 0.5) except bead 1 (radius 1), 4 beads)"),
        (hc.Chain.uniform(9).with_defects({4: 1.0 + 1e-6}),
         "Chain(uniform except bead 4 (radius 1.000001), 9 beads)"),
        (hc.Chain.uniform(9).with_defects({4: 0.5, 5: 0.5}), "Chain(given radii, 9 beads)"),
        (hc.Chain.uniform(9).replace(masses=[2.0] * 8 + [3.0]),
         "Chain(uniform (mass 2) except bead 9 (mass 3), 9 beads)"),
        (hc.Chain.tapered("forward-exponential", 0.05, beads=11).decorated(0.4),
         "Chain(forward-exponential, q = 0.05, decorated (ratio 0.4), 21 beads)"),
        (hc.Chain.tapered("backward-linear", 0.1, beads=5).decorated(0.3, between=2),
         "Chain(backward-linear, S = 0.1, decorated (2 of ratio 0.3), 13 beads)"),
        (hc.Chain.tapered(
            first_diameter="20 mm", last_diameter="8 mm", beads=10, material="brass", velocity=0.1,
         ).decorated(0.4),
         "Chain(19 brass beads, diameters 20 mm to 8 mm, exponential taper, decorated (ratio 0.4), "
         "impact at\n    0.1 m/s)"),
        (hc.Chain.tapered(
            "linear", first_diameter="20 mm", last_diameter="8 mm", beads=9, material="brass",
            velocity=0.1,
         ),
         "Chain(9 brass beads, diameters 20 mm to 8 mm, linear taper, impact at 0.1 m/s)"),
        (hc.Chain.tapered(
            first_diameter="20 mm", last_diameter="8 mm", beads=20, material="brass", velocity=0.1,
         ).with_defects(diameters={10: "14 mm"}),
         "Chain(20 brass beads, diameters 20 mm to 8 mm, exponential taper, 1 changed bead, impact "
         "at 0.1 m/s)"),
        (hc.Chain.tapered(
            "linear", first_diameter="8 mm", last_diameter="20 mm", beads=20, material="brass",
            velocity=0.1,
         ).with_defects({1: "7 mm", 2: "7 mm", 20: "7 mm"}),
         "Chain(20 brass beads, diameters 8 mm to 20 mm, linear taper, 3 changed beads, impact at "
         "0.1 m/s)"),
        (hc.Chain.from_materials([5e-3, 7e-3, 4e-3, 3e-3], "brass", velocity=0.1),
         "Chain(4 brass beads, diameters between 6 mm and 14 mm, impact at 0.1 m/s)"),
        (hc.Chain.tapered("backward-exponential", 0.05, beads=60).with_defects({1: 0.5, 9: 2.0}),
         "Chain(backward-exponential, q = 0.05, 2 changed beads, 60 beads)"),
        (hc.Chain.tapered("forward-linear", 0.01, beads=9).with_defects({9: 2.0}).struck_by(),
         "Chain(forward-linear, S = 0.01, 1 changed bead, 9 beads, and 1 striker)"),
        (hc.Chain.from_radii([2.0, 0.95, 0.9, 0.85, 0.8, 0.75]), "Chain(given radii, 6 beads)"),
        (hc.Chain.from_radii([1.0, 0.4, 0.9, 0.3, 0.8]), "Chain(given radii, 5 beads)"),
        (hc.Chain.from_radii([1.0, 0.5, 0.3] * 2), "Chain(cells of 3 beads, 6 beads)"),
        (hc.Chain.from_radii([1.0, 0.5, 1.0, 0.5, 0.3]), "Chain(given radii, 5 beads)"),
        (hc.Wall.of("ptfe", gap=1e-5), "Wall(ptfe, gap = 10 um)"),
        (hc.Wall(gap="2 mm", stiffness="1 N/m^1.5"),
         "Wall(stiffness = 1 N/m^1.5, gap = 2 mm)"),
        (hc.Wall("5e6 N/m", exponent=1), "Wall(stiffness = 5 kN/mm, p = 1)"),
        (hc.Wall("5 N/um^1.5"), "Wall(stiffness = 5 N/um^1.5)"),
        (hc.Wall(5e6), "Wall(stiffness = 5e+06)"),
        (hc.Wall(2.5e7, exponent=1), "Wall(stiffness = 2.5e+07 (in SI units 25 kN/mm), p = 1)"),
        (hc.Wall(2.5, exponent=1), "Wall(stiffness = 2.5, p = 1)"),
        (hc.Wall(gap=1e-5), "Wall(own material, gap = 1e-05)"),
    ],
)  # fmt: skip
def test_chains_and_walls_have_units(item, expected):
    assert repr(item) == expected


def test_columns_of_a_budget_do_not_touch():
    chain = hc.Chain.uniform(5).replace(left_wall=hc.Wall(), right_wall=hc.Wall())
    budget = hc.simulate(chain, until=3000.0).budget()
    parts = [line.split() for line in str(budget).splitlines() if "wall " in line]
    assert [words[:2] for words in parts] == [["left", "wall"], ["right", "wall"]]
    for words in parts:
        value, part = float(words[2]), float(words[3].removesuffix("%"))
        assert abs(part) > 10_000.0
        # The value has three decimals.
        assert part == pytest.approx(100.0 * value, abs=0.06)


def test_one_limit_is_in_the_singular():
    fast = hc.Chain.from_materials(5e-3, "steel-52100", beads=2, velocity=1.0)
    found = hc.hertz_range(fast)
    assert len(found.violations) == 1
    assert "1 limit exceeded" in repr(found)


@pytest.fixture(scope="module")
def reproduced():
    return reproduce(["table1", "table3", "figure1", "errata"])


def test_results_of_the_paper(reproduced):
    table, figure = reproduced.tables[0], reproduced.figures[0]
    check(reproduced, ["2 tables, 1 figure: ", "entries agree", "errata: 19"])
    check(table, ["table1, momentum", f"{len(table.entries)} entries agree", "beads 5 to 80"])
    check(figure, ["figure1", "3 curves", "holds"])
    check(reproduced.errata[0], ["Eqs. (38)", "printed"])
    frame = reproduced.to_dataframe()
    assert len(frame) == sum(len(each.entries) for each in reproduced.tables)
    assert frame.table.unique().tolist() == ["table1", "table3"]
    difference = (frame.recomputed - frame.printed).abs()
    assert difference[frame.verdict == "same digits"].max() < 0.51e-4
    assert "printed" in table._repr_html_()
    assert table.entries[0].printed.text in table._repr_html_()
    assert "verdict" in dir(reproduced)
    assert "holding_statements" not in dir(reproduced)


def test_parts_of_the_paper_simulate_their_chains(reproduced):
    assert reproduce_table("table3").entries == reproduced.tables[1].entries
    statement = reproduce_figure("figure1").statement
    assert statement.measured == reproduced.figures[0].statement.measured
    assert errata()[3].place == reproduced.errata[3].place
    assert callable(hc.paper.errata)
    assert "pulses" in reproduce_figure.__doc__
    for call in (reproduce_figure, reproduce_table):
        with pytest.raises(hc.InputError, match="of the paper"):
            call("table9")


@pytest.mark.filterwarnings("ignore::hertzchain.errors.IncompleteWarning")
def test_tables_and_theories_have_views_in_notebooks():
    chains = [hc.Chain.uniform(9).with_scatter(seed, relative=0.05) for seed in range(6)]
    pulses = hc.propagate_many(chains)
    walled = [chain.replace(right_wall=hc.Wall()) for chain in chains]
    runs = hc.simulate_many(walled, keep=["wall_peak_force", "velocity"])
    failed = hc.propagate_many([[1.0, -1.0]])
    calibration = hc.calibrate("backward-linear", rates=(0.5,), beads=30, window=(5, 25))
    for item, words in (
        (pulses, ["<svg", "median", f"{np.median(pulses.velocity[:, -1]):.4g}"]),
        (runs, ["<svg", "wall_peak_force", f"{runs['wall_peak_force'].max():.4g}"]),
        (failed, ["failed"]),
        (hc.solitary_wave(), ["<svg", "0.9074700784", "force of a contact"]),
        (calibration, ["<svg", f"{calibration.worst_error:.2%}", "in the paper"]),
    ):
        page = item._repr_html_()
        assert len(page) < 20_000
        for word in words:
            assert word in page, (type(item), word)


@pytest.mark.parametrize("relative", [5e-4, 1e-4, 3e-6, 1e-8])
def test_sizes_that_scatter_are_stated_with_enough_digits(relative):
    balls = hc.Chain.from_materials(diameters="20 mm", materials="steel-52100", beads=20)
    lot = balls.with_scatter(1, relative=relative).replace(scatter=None)
    low, high = map(float, re.search(r"between ([\d.]+) mm and ([\d.]+) mm", repr(lot)).groups())
    deviation = 2e3 * np.ptp(lot.radii)
    assert high - low == pytest.approx(deviation, rel=0.6)
    assert 2e3 * lot.radii.min() == pytest.approx(low, abs=0.5 * deviation)
    assert f"between {low:.10g} mm and {high:.10g} mm" in hc.plot_chain(lot).get_title()
    plt.close("all")


def test_equal_sizes_are_stated_once():
    balls = hc.Chain.from_materials(diameters="20 mm", materials="steel-52100", beads=20)
    lot = balls.with_scatter(1, relative=1e-14).replace(scatter=None)
    assert "beads, diameters 20 mm, " in repr(lot)
    pair = hc.Chain.periodic(["5 mm", "5.00005 mm"], cells=5, materials=["brass"] * 2)
    assert "diameters 10 mm and 10.0001 mm in turn" in repr(pair)


def test_small_errors_have_digits():
    chain = hc.Chain.tapered("forward-linear", 0.001, beads=50)
    found = hc.local_rate(chain).compare(hc.propagate(chain))
    worst, rms = found.worst("velocity"), found.rms("velocity")
    (row,) = (line.split() for line in str(found).splitlines() if line.startswith("  velocity"))
    for text, error in zip((row[1], row[3]), (worst, rms), strict=True):
        assert float(text.removesuffix("%")) == pytest.approx(100.0 * error, rel=0.06)
        assert 0.0 < error < 1e-4
    assert "0.00%" not in str(found) + repr(found)
    large = hc.bca(chain).compare(hc.propagate(chain))
    assert f"{large.worst('velocity'):.2%}" in str(large)
    same = hc.bca(chain)
    assert str(same.compare(same)).splitlines()[2].split() == ["velocity", "0%", "2", "0%"]


def test_one_theory_is_in_the_singular():
    assert repr(hc.scoreboard(theories=["bca"])) == "Scoreboard(1 theory on 52 chains)"
    assert "2 theories on" in repr(hc.scoreboard(theories=["bca", "hard-sphere"]))


def test_names_that_a_budget_does_not_contain_raise_an_error_with_its_names():
    budget = hc.simulate(hc.Chain.uniform(5)).budget()
    names = "choose from leading pulse, lagging, scattered back"
    said = f"unknown part of a budget 'kinetic': {names}, contacts, walls, lost; the kinetic energy"
    with pytest.raises(hc.InputError, match=f"^{said} of all beads is Budget.kinetic_energy$"):
        budget.energy["kinetic"]
    with pytest.raises(hc.InputError, match=f"'wall' .did you mean [^:]*: {names}"):
        budget.momentum["wall"]
    assert "kinetic" not in budget.energy


def test_budgets_show_rounding_errors_as_zero():
    """After this collision, bead 1 moves back with a velocity of -2e-14."""
    budget = hc.simulate(hc.Chain.uniform(2)).budget()
    assert 0.0 < abs(budget.momentum["scattered back"][-1]) < 1e-12
    for text in (str(budget), repr(budget), budget._repr_html_()):
        assert "-0.0" not in text
        assert "e-1" not in text.partition(" up within")[0]
    assert "scattered back" not in repr(budget)
    assert "    leading pulse              1    100.00%" in str(budget)
    # Amounts above the rounding errors remain.
    walls = hc.simulate(hc.Chain.uniform(20, right_wall=hc.Wall()), until=40.0).budget()
    assert "e-0" in str(walls).partition("adds up")[0]


@pytest.mark.parametrize(
    ("value", "unit", "shown"),
    [
        (9999.0, "N", "9999 N"), (12503.2, "N", "12.5 kN"), (-2e5, "N", "-200 kN"),
        (999e-6, "s", "999 us"), (7.673e-3, "s", "7.673 ms"), (1.5, "s", "1.5 s"),
        (2.5e8, "Pa", "250 MPa"), (1.6e10, "Pa", "16 GPa"),
    ],
)  # fmt: skip
def test_values_have_their_usual_units(value, unit, shown):
    assert measure(value, unit) == shown


def test_percentages_fit_into_columns():
    shown = [percent(value) for value in (0.4807, 2.2e-5, 1.5, 72504.0884)]
    assert shown == ["48.07%", "0.0022%", "150.00%", "7.25e+06%"]


def test_thousands_have_no_exponent():
    assert [measure(value, "N", "SI", 3) for value in (964.21, 1483.5, 14835.0)] == [
        "964 N", "1484 N", "14.8 kN"
    ]  # fmt: skip


BALLS = hc.Chain.from_materials("10 mm", "steel-316", beads=20)


@pytest.mark.parametrize(
    ("chain", "description", "title", "on_page"),
    [
        (BALLS.with_defects({10: 8e-3}, material="ptfe"),
         "20 steel-316 beads, diameter 20 mm, except bead 10 (16 mm ptfe)",
         "20 steel balls, 20 mm, except ball 10 (16 mm PTFE)",
         "20 steel-316 beads, diameter 20 mm, except bead 10 (16 mm ptfe), impact at 1 m/s"),
        (BALLS.with_defects({10: 10e-3}, material="brass").with_scatter(1, relative=0.01),
         "20 steel-316 beads, diameter 20 mm, except bead 10 (brass), 1% scatter",
         "20 steel balls, 20 mm, except ball 10 (brass), 1% scatter",
         "20 steel-316 beads, diameter 20 mm, except bead 10 (brass), 1% scatter, impact at 1 m/s"),
        # A ball is counted without the striker, as on the page.
        (BALLS.with_defects({10: 8e-3}).struck_by(velocity=0.1, radius="10 mm"),
         "20 steel-316 beads, diameter 20 mm, except ball 10 (16 mm), and 1 striker",
         "20 steel balls, 20 mm, except ball 10 (16 mm), and a striker, 20 mm",
         "20 steel-316 beads, diameter 20 mm, except ball 10 (16 mm), striker (20 mm), "
         "impact at 0.1 m/s"),
        (hc.Chain.uniform(20).with_defects({10: 0.5}).struck_by(mass=5.0),
         "uniform except ball 10 (radius 0.5), 20 beads, and 1 striker (radius 1.71)",
         "20 beads, equal except ball 10 (radius 0.5), and 1 striker (radius 1.71)",
         "uniform except ball 10 (radius 0.5), 20 beads, striker (radius 1.71)"),
        (hc.Chain.uniform(20).with_defects({10: 0.5}),
         "uniform except bead 10 (radius 0.5), 20 beads",
         "20 beads, equal except bead 10 (radius 0.5)",
         "uniform except bead 10 (radius 0.5), 20 beads"),
    ],
)  # fmt: skip
def test_a_bead_that_differs_from_equal_ones_is_named(chain, description, title, on_page):
    assert chain.description == description
    assert chain_words(chain) == title
    assert chain_in_words(chain) == on_page


def test_labels_of_compared_pulses_name_the_odd_bead():
    slow = BALLS.replace(velocities=[1e-3] + [0.0] * 19)
    rows = [slow.with_defects({5: each / 2.0}, material="brass") for each in (18e-3, 16e-3)]
    axes = hc.plot_pulses([hc.propagate(chain) for chain in (slow, *rows)])
    labels = legend_texts(axes)
    assert labels[1:3] == ["except ball 5 (18 mm brass)", "except ball 5 (16 mm brass)"]


def test_numbers_rounded_to_zero_have_no_sign():
    text = "kept -0.0000, from -0.01 to -0 m/s, (-0.00), 1e-05, 2-0 -0.5"
    assert (
        without_negative_zeros(text) == "kept 0.0000, from -0.01 to 0 m/s, (0.00), 1e-05, 2-0 -0.5"
    )
    assert "-0.0000" not in numbers({"momentum kept": "-0.0000"}) + table(["a"], [["-0.0000"]])
