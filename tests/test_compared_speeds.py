"""Chains compared at several speeds by `hertzchain simulate`."""

import json

import pytest
from click.testing import CliRunner

import hertzchain as hc
from hertzchain.cli import cli

STEEL = "steel-52100"


@pytest.fixture
def files(tmp_path):
    """Two chain files in front of walls, whose beads differ."""
    found = []
    for name, sizes in (("equal", "10 mm"), ("tapered", ["10 mm", "8 mm", "6 mm", "5 mm"])):
        path = tmp_path / f"{name}.toml"
        text = json.dumps(sizes)
        beads = "beads = 4\n" if name == "equal" else ""
        path.write_text(
            f'[chain]\ndiameters = {text}\n{beads}materials = "{STEEL}"\nvelocity = "1 m/s"\n'
            f'right_wall = {{material = "{STEEL}"}}\n'
        )
        found.append(str(path))
    return found


def invoked(*arguments):
    return CliRunner().invoke(cli, ["simulate", *arguments])


def peak(diameters, speed):
    """The force on the wall from the library."""
    beads = {} if isinstance(diameters, list) else {"beads": 4}
    chain = hc.Chain.from_materials(
        diameters=diameters, materials=STEEL, velocity=speed, right_wall=hc.Wall.of(STEEL), **beads
    )
    return hc.simulate(chain).wall_force().peak


def test_the_table_has_each_chain_at_each_speed(files, tmp_path):
    figure = tmp_path / "peaks.png"
    speeds = ["--speed", "0.02m/s", "--speed", "40 mm/s"]
    done = invoked(*files, *speeds, "--plot", str(figure))
    assert done.exit_code == 0, done.output
    assert "2 chains at 2 speeds: force on the right wall; * marks the smallest of each speed" in (
        done.output
    )
    assert figure.stat().st_size > 1000
    sizes = {"equal": "10 mm", "tapered": ["10 mm", "8 mm", "6 mm", "5 mm"]}
    lines = [line for line in done.output.splitlines() if any(name in line for name in sizes)]
    assert len(lines) == 4
    for i, speed in enumerate((0.02, 0.04)):
        values = {name: peak(size, speed) for name, size in sizes.items()}
        least = min(values, key=values.__getitem__)
        for line, (name, value) in zip(lines[2 * i : 2 * i + 2], values.items(), strict=True):
            assert name in line
            assert f"{value:.5g} N" in line
            assert ("* " in line) == (name == least)
    # Summaries are printed only if something else is asked for.
    assert "right wall: peak" not in done.output
    assert "right wall: peak" in invoked(*files, *speeds, "--contacts").output


def test_json_names_chains_and_speeds(files):
    done = invoked(*files, "--speed", "0.02m/s", "--speed", "0.04m/s", "--json")
    names = [each["name"] for each in json.loads(done.output)["runs"]]
    assert names == ["equal, 0.02 m/s", "tapered, 0.02 m/s", "equal, 0.04 m/s", "tapered, 0.04 m/s"]


def test_one_chain_has_no_marks(files):
    done = invoked(files[0], "--speed", "0.02m/s", "--speed", "0.04m/s")
    assert "1 chain at 2 speeds: force on the right wall\n" in done.output
    assert "*" not in done.output


def test_equal_speeds_and_other_commands_are_rejected(files):
    done = invoked(files[0], "--speed", "0.1 m/s", "--speed", "100 mm/s")
    assert done.exit_code == 2
    assert "--speed is 0.1 m/s twice; keep one" in done.output
    both = [files[0], "--speed", "0.1 m/s", "--speed", "0.2 m/s"]
    done = CliRunner().invoke(cli, ["pulse", *both])
    assert done.exit_code == 2
    assert "give one --speed, got 0.1 m/s, 0.2 m/s; simulate accepts several" in done.output
    done = invoked(*both, "--out", "run.nc")
    assert "require one chain FILE and one --speed" in done.output


def test_each_speed_has_its_own_figure_of_peaks():
    from hertzchain.plotting.peaks_over_speed import plot_peaks

    axes = plot_peaks(
        {"a": [0.2, 0.1], "b": [0.2, 0.1]}, {"a": [4.0, 2.0], "b": [5.0, float("inf")]},
        {"a": [3.0, 2.0]}, where="the right wall", units="SI",
    )  # fmt: skip
    assert [line.get_label() for line in axes.lines] == ["a", "a, with yield", "b"]
    assert axes.lines[1].get_xdata().tolist() == [0.1, 0.2]
    assert axes.lines[1].get_ydata().tolist() == [2.0, 3.0]
    assert axes.get_ylabel() == "peak force on the right wall [N]"
