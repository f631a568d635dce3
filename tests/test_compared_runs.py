"""The table of several chains that `hertzchain simulate` prints."""

import math

import pytest

import hertzchain as hc
from hertzchain.chain.hertz_ratios import with_yield
from hertzchain.simulation.body_force import body_force

pytestmark = pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")


def row(last, **more):
    chain = hc.Chain.tapered(
        first_diameter="10 mm", last_diameter=last, beads=6, material="steel-52100"
    )
    return chain.replace(velocities=[1.0, 0, 0, 0, 0, 0], **more)


def written(folder, **chains):
    for name, chain in chains.items():
        (folder / f"{name}.toml").write_text(hc.chain_as_toml(chain))
    return [folder / f"{name}.toml" for name in chains]


def rows_of(out):
    """Cells of the rows of the table at the end of the output, by chain."""
    lines = out[out.index(" chains: ") :].splitlines()
    return {line.split()[0]: line for line in lines[3:] if line.strip() and "\u2500" not in line}


def test_several_chains_are_compared_in_a_table(run, tmp_path):
    law = hc.ElasticPlastic()
    chains = {
        name: row(last, loss=law, right_wall=hc.Wall.of("aluminium"))
        for name, last in (("wide", "9 mm"), ("narrow", "5 mm"))
    }
    code, out, err = run("simulate", *written(tmp_path, **chains))
    assert code == 0, err
    assert "2 chains: force on the right wall; * marks the smallest" in out
    table = rows_of(out)
    runs = {name: hc.simulate(chain) for name, chain in chains.items()}
    full = hc.ElasticPlastic(factor=2.8)
    others = {name: hc.simulate(chain.replace(loss=full)) for name, chain in chains.items()}
    for of in (runs, others):
        peaks = {name: each.wall_force().peak for name, each in of.items()}
        for name, peak in peaks.items():
            mark = "* " if peak == min(peaks.values()) else " "
            assert f"{mark}{peak:.5g} N" in table[name]
            assert f"* {peak:.5g} N" not in table[name] or mark == "* "
    for name, each in runs.items():
        assert f"{1e6 * each.wall_force().peak_time:.5g} us" in table[name]
        assert f"{1e6 * each.dents.max():.3g} um" in table[name]
    assert "pressure/yield is at most 1 with a law of yield; the dents show how far" in out
    header = out[out.index(" chains: force on ") :].splitlines()[3]
    for column in ("impulse", "duration", "/radius", "/yield", "2.8 Y"):
        assert column in header


def heavy_strike(material, **more):
    balls = hc.Chain.from_materials(diameters=["10 mm"] * 10, materials=material)
    wall = hc.Wall.of("steel-52100")
    return balls.replace(right_wall=wall, **more).struck_by(
        mass="30 g", material="steel-52100", velocity="0.8 m/s"
    )


def test_a_comparison_that_yield_reverses_says_so(run, tmp_path):
    chains = {"row": heavy_strike(["steel-52100", "ptfe"] * 5), "nylon": heavy_strike("nylon")}
    code, out, err = run("simulate", *written(tmp_path, **chains))
    assert code == 0, err
    table = rows_of(out)
    for factor in (1.6, 2.8):
        law = hc.ElasticPlastic(factor=factor)
        peaks = {
            name: hc.simulate(with_yield(chain, law), times=0).wall_force().peak
            for name, chain in chains.items()
        }
        assert peaks["row"] < peaks["nylon"]
        assert f"* {peaks['row']:.5g} N" in table["row"]
        assert f" {peaks['nylon']:.5g} N" in table["nylon"]
    assert "* 85.048 N" in table["nylon"]
    assert "yield at 1.6 and 2.8 times the yield strength, the smallest peak is that of row" in out
    assert "which reverses the comparison" in out


def test_elastic_peaks_are_not_compared_with_those_of_contacts_that_yield(run, tmp_path):
    chains = {
        "steelp": heavy_strike("steel-52100", loss=hc.ElasticPlastic()),
        "steel": heavy_strike("steel-52100"),
        "nylon": heavy_strike("nylon"),
    }
    code, out, err = run("simulate", *written(tmp_path, **chains))
    assert code == 0, err
    table = rows_of(out)
    assert table["nylon"].split()[1:3] == ["85.048", "N"]
    # Nothing is marked but the two peaks of contacts that yield.
    assert [table[name].count("*") for name in chains] == [0, 0, 2]
    assert table["steel"].split()[-4:] == table["steelp"].split()[-4:]
    assert "the peaks of steel and nylon are those of elastic contacts beyond yield" in out
    assert "reverses the comparison" not in out


def test_a_chain_below_yield_has_its_own_peak_at_both_pressures(run, tmp_path):
    gentle = row("9 mm", right_wall=hc.Wall.of("steel-52100"))
    gentle = gentle.replace(velocities=1e-3 * gentle.velocities)
    chains = {"gentle": gentle, "steelp": heavy_strike("steel-52100", loss=hc.ElasticPlastic())}
    table = rows_of(run("simulate", *written(tmp_path, **chains)).stdout)
    peak = f"* {hc.simulate(gentle).wall_force().peak:.5g} N"
    assert table["gentle"].count(peak) == 2


def test_a_loss_without_yield_has_no_peak_at_a_yield_pressure(run, tmp_path):
    chains = {
        "soft": heavy_strike("nylon", loss=hc.Restitution(0.9)),
        "hard": heavy_strike("nylon"),
    }
    table = rows_of(run("simulate", *written(tmp_path, **chains)).stdout)
    assert table["soft"].split()[-2:] == ["-", "-"]
    assert table["hard"].count("*") == 0
    assert table["soft"].count("*") == 1


def test_a_figure_of_elastic_contacts_beyond_yield_says_so():
    from hertzchain.cli.compared_yield import AtPressures, figure_title
    from hertzchain.cli.run_summary import peaks_if_yielding

    runs = {"nylon": hc.simulate(heavy_strike("nylon")), "gentle": hc.simulate(row("9 mm"))}
    yielding = {name: peaks_if_yielding(each) for name, each in runs.items()}
    title = figure_title(runs, yielding)
    assert title == "nylon: elastic contacts; peaks if contacts yield at 1.6 Y: nylon 42.1 N"
    del runs["gentle"], yielding["gentle"]
    assert figure_title(runs, yielding).endswith("; peak if contacts yield at 1.6 Y: 42.1 N")
    assert figure_title({"gentle": runs["nylon"]}, {"gentle": (None, None)}) == ""
    runs["yields"] = hc.simulate(row("9 mm", loss=hc.ElasticPlastic()))
    assert figure_title(runs, {}) == "yields: contacts yield at 1.6 Y (Y: yield strength)"
    at = {"nylon": AtPressures(42.1, 60.0, elastic=True), "yields": AtPressures(3.0, 3.0)}
    assert figure_title(runs, yielding, at) == (
        "yields: contacts yield at 1.6 Y (Y: yield strength)\n"
        "peaks at 1.6 and 2.8 Y: nylon 42.1 and 60 N, yields 3 and 3 N"
    )
    at["nylon"] = at["nylon"]._replace(largest=math.inf)
    assert figure_title(runs, yielding, at).endswith(": nylon 42.1 N")
    pulses = [each.pulse() for each in runs.values()]
    title = hc.plot_pulses(pulses).get_title().replace("\n", " ")
    assert title.endswith(", contacts yield at 1.6 Y (Y: yield strength)")


def test_chains_without_walls_are_compared_by_their_sensors(run, tmp_path):
    files = written(tmp_path, a=row("9 mm"), b=row("5 mm"))
    out = run("simulate", *files, "--sensor", "3").stdout
    table = rows_of(out)
    for name, last in (("a", "9 mm"), ("b", "5 mm")):
        largest = hc.simulate(row(last), times=4000).sensor_force(3).largest_so_far
        assert f"{largest:.5g} N" in table[name]
    assert "force in the first sensor" in out


@pytest.mark.parametrize("walls", [0, 1])
def test_free_ends_are_compared_by_their_last_beads(run, tmp_path, walls):
    chains = {"a": row("9 mm"), "b": row("5 mm")}
    if walls:
        chains["c"] = row("5 mm", right_wall=hc.Wall.of("steel-52100"))
    code, out, err = run("simulate", *written(tmp_path, **chains))
    assert code == 0, err
    table = rows_of(out)
    for name in ("a", "b"):
        pulse = hc.simulate(chains[name]).pulse()
        assert f"{pulse.velocity[-1]:.5g} m/s" in table[name]
        assert f"{1e3 * pulse.momentum[-1]:.4g} mN s" in table[name]
    walls_in_title = "force on the right wall, " if walls else ""
    title = f"{len(chains)} chains: {walls_in_title}last bead of free ends in the leading pulse"
    assert title in out
    # Nothing is the smallest of forces and velocities.
    assert "*" not in "".join(table.values())
    if walls:
        assert table["a"].split()[1:3] == ["-", "-"]
        assert f"{hc.simulate(chains['c']).wall_force().peak:.5g} N" in table["c"]


def test_there_is_no_table_of_one_chain_or_of_different_units(run, tmp_path):
    scaled = hc.Chain.uniform(5).replace(right_wall=hc.Wall())
    files = written(tmp_path, a=row("9 mm", right_wall=hc.Wall()), b=scaled)
    assert " chains: " not in run("simulate", files[0]).stdout
    assert " chains: " not in run("simulate", *files).stdout


def test_dashes_are_explained(run, tmp_path):
    chains = {"lossy": heavy_strike("nylon", loss=hc.Restitution(0.9)),
              "hard": heavy_strike("nylon")}  # fmt: skip
    out = run("simulate", *written(tmp_path, **chains)).stdout
    words = "-: no peak at a yield pressure (contacts have a loss without yield), lossy\n"
    assert words in out
    assert "hard" not in out[out.index(words) :].splitlines()[0]


def test_walls_and_boxes_have_peaks_at_both_yield_pressures(run, tmp_path):
    balls = heavy_strike("nylon")
    chains = {"wall": balls, "box": balls.replace(right_wall=None).with_cap(mass="20 g")}
    out = run("simulate", *written(tmp_path, **chains)).stdout
    table = rows_of(out)
    for factor in (1.6, 2.8):
        law = hc.ElasticPlastic(factor=factor)
        dented = {
            name: hc.simulate(with_yield(each, law), times=0) for name, each in chains.items()
        }
        assert f" {dented['wall'].wall_force().peak:.5g} N" in table["wall"]
        force = body_force(dented["box"]).force
        assert f" {force:.5g} N" in table["box"]
    body = body_force(hc.simulate(chains["box"], times=0))
    assert f"{body.acceleration:.4g} m/s^2" in table["box"]
    # Forces on walls and boxes are not compared.
    assert "*" not in "".join(table.values())


@pytest.mark.filterwarnings("ignore::hertzchain.IncompleteWarning")
def test_all_dashes_of_different_ends_have_a_reason(run, tmp_path):
    balls = '[chain]\ndiameters = "10 mm"\nbeads = 4\nmaterials = "steel-52100"\n'
    ends = {"wall": 'right_wall = "same"', "box": 'cap = "100 g"', "free": ""}
    for name, end in ends.items():
        (tmp_path / f"{name}.toml").write_text(f"{balls}{end}\n")
    files = [tmp_path / f"{name}.toml" for name in ends]
    out = run("simulate", *files, "--speed", "0.5m/s", "--speed", "1m/s").stdout
    notes = [line for line in out.splitlines() if line.startswith("-: ")]
    assert notes == [
        "-: no right wall, box and free", "-: no right wall and no cap, free",
        "-: no free end, wall", "-: no cap, free",
    ]  # fmt: skip
    # Walls and boxes have the peaks at both yield pressures, and boxes have an acceleration.
    table = [line for line in out.splitlines() if " 0.00" in line]
    rows = {name: [line for line in table if f" {name} " in line] for name in ends}
    assert [line.count(" N ") for line in rows["wall"]] == [3, 3]
    assert [line.count(" N ") for line in rows["box"]] == [3, 3]
    assert ["m/s^2" in line for line in rows["box"]] == [True, True]
    early = run("simulate", *files[:1], *files[2:], "--speed", "0.1m/s", "--until", "40us").stdout
    assert "-: no right wall, free" in early
