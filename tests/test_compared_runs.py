"""The table of several chains that `hertzchain simulate` prints."""

import pytest

import hertzchain as hc

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
    lines = out[out.index(" chains: force on ") :].splitlines()
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
    header = out[out.index(" chains: force on ") :].splitlines()[2]
    for column in ("impulse", "duration", "overlap/radius", "pressure/yield", "peak at 2.8 Y"):
        assert column in header


def test_chains_without_walls_are_compared_by_their_sensors(run, tmp_path):
    files = written(tmp_path, a=row("9 mm"), b=row("5 mm"))
    assert " chains: force on " not in run("simulate", *files).stdout
    out = run("simulate", *files, "--sensor", "3").stdout
    table = rows_of(out)
    for name, last in (("a", "9 mm"), ("b", "5 mm")):
        largest = hc.simulate(row(last), times=4000).sensor_force(3).largest_so_far
        assert f"{largest:.5g} N" in table[name]
    assert "force on the first sensor" in out


def test_there_is_no_table_of_one_chain_or_of_different_units(run, tmp_path):
    scaled = hc.Chain.uniform(5).replace(right_wall=hc.Wall())
    files = written(tmp_path, a=row("9 mm", right_wall=hc.Wall()), b=scaled)
    assert " chains: force on " not in run("simulate", files[0]).stdout
    assert " chains: force on " not in run("simulate", *files).stdout
