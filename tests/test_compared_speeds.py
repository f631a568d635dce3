"""Chains compared at several speeds by `hertzchain simulate`."""

import json
from types import SimpleNamespace

import numpy as np
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


def soft_and_stiff(folder):
    """Rows of rubber and of steel behind a heavy striker; steel has the larger force."""
    for material in ("rubber", STEEL, "aluminium"):
        chain = hc.Chain.from_materials(diameters=["10 mm"] * 3, materials=material)
        chain = chain.replace(right_wall=hc.Wall.of(STEEL)).struck_by(
            mass="50 g", material=STEEL, velocity="1 m/s"
        )
        (folder / f"{material}.toml").write_text(hc.chain_as_toml(chain))
    return [str(folder / f"{name}.toml") for name in ("rubber", STEEL, "aluminium")]


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
def test_forces_that_are_no_predictions_are_not_compared(tmp_path):
    files = soft_and_stiff(tmp_path)
    done = invoked(*files, "--speed", "0.01m/s", "--speed", "1m/s")
    lines = [line for line in done.stdout.splitlines() if "N s" in line]
    assert "?: overlap / radius is above 0.1 with these contacts" in done.stdout
    marks = []
    for i, line in enumerate(lines):
        speed = "0.01 m/s" if i < 3 else "1 m/s"
        chain = hc.load_chain(files[i % 3])
        chain = chain.replace(velocities=chain.velocities * float(speed.split()[0]))
        found = hc.simulate(chain)
        ratio = hc.hertz_range(chain, found.largest_overlaps).overlap_ratio.max()
        assert f"{found.wall_force().peak:.5g} N" in line
        assert ("? " in line) == (ratio > 0.1)
        marks.append((line.count("?"), line.count("*")))
    # Rubber has the smallest force at both speeds; at 1 m/s, only both metals are compared.
    assert marks[0] == (0, 3)
    assert marks[3] == (3, 0)
    assert marks[4][0] == marks[5][0] == 0
    assert marks[4][1] + marks[5][1] == 3


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
def test_several_speeds_have_one_warning_for_each_limit(run, tmp_path):
    files = soft_and_stiff(tmp_path)
    speeds = ["--speed", "0.01m/s", "--speed", "1m/s"]
    code, _, err = run("simulate", *files, *speeds)
    assert code == 0
    warnings = [line for line in err.splitlines() if line.startswith("Warning: ")]
    chains = [hc.load_chain(file) for file in files]
    chains += [each.replace(velocities=0.01 * each.velocities) for each in chains]
    ranges = [hc.hertz_range(each, hc.simulate(each).largest_overlaps) for each in chains]
    overlap = ranges[0].overlap_ratio.max()
    assert f"is up to {overlap:.2g} (rubber, 1 m/s); beyond 0.1, in 1, forces" in err
    pressures = [each.largest_yield_ratio for each in ranges]
    count, highest = sum(each > 1.0 for each in pressures), max(pressures)
    assert (
        f"pressure / yield exceeds its limit in {count} of 6 runs, and is up to {highest:.2g}"
        in err
    )
    assert len(warnings) <= 3
    document = json.loads(run("simulate", *files, *speeds, "--json").stdout)
    assert [f"Warning: {text}" for text in document["warnings"]] == warnings
    predicted = [each["forces_predicted"] for each in document["runs"]]
    assert predicted == [True, True, True, False, True, True]


def test_equal_speeds_and_other_commands_are_rejected(files):
    done = invoked(files[0], "--speed", "0.1 m/s", "--speed", "100 mm/s")
    assert done.exit_code == 2
    assert "--speed is 0.1 m/s twice; keep one" in done.output
    both = [files[0], "--speed", "0.1 m/s", "--speed", "0.2 m/s"]
    done = CliRunner().invoke(cli, ["pulse", *both])
    assert done.exit_code == 2
    assert "give one --speed, got 0.1 m/s, 0.2 m/s; simulate accepts several" in done.output
    done = invoked(*both, "--out", "run.nc")
    assert "require one chain FILE and one --speed or --height" in done.output


def test_each_speed_has_its_own_figure_of_peaks():
    from hertzchain.plotting.peaks_over_impacts import plot_peaks

    kept = (False, False, False)
    axes = plot_peaks(
        {"a": [0.2, 0.1], "b": [0.2, 0.1]}, {"a": [4.0, 2.0], "b": [5.0, float("inf")]},
        {"a": [(3.0, 3.5), (1.5, 2.0)]}, {"a": [(False, True, False), kept], "b": [kept, kept]},
        factors=("1.6", "2.8"), where="the right wall", units="SI",
    )  # fmt: skip
    assert axes.get_legend_handles_labels()[1] == [
        "a", "b", "elastic", "with yield, 1.6 $Y$", "with yield, 2.8 $Y$",
        "no prediction: overlap / radius > 0.1",
    ]  # fmt: skip
    lines = {line.get_linestyle(): line for line in axes.lines[:6] if len(line.get_xdata()) == 2}
    assert lines["--"].get_xdata().tolist() == lines[":"].get_xdata().tolist() == [0.1, 0.2]
    assert lines["--"].get_ydata().tolist() == [1.5, 3.0]
    assert lines[":"].get_ydata().tolist() == [2.0, 3.5]
    # The point outside the range has a hollow marker only.
    assert lines["--"].get_markevery() == [0]
    hollow = [line for line in axes.lines if line.get_linestyle() == "None"]
    assert [line.get_xydata().tolist() for line in hollow if len(line.get_xdata())] == [
        [[0.2, 3.0]]
    ]
    (band,) = axes.collections
    corners = {tuple(point) for point in band.get_paths()[0].vertices.tolist()}
    assert corners == {(0.1, 1.5), (0.1, 2.0), (0.2, 3.0), (0.2, 3.5)}
    assert axes.get_ylabel() == "peak force on the right wall [N]"


@pytest.mark.parametrize(
    ("soft", "name"), [(4.0, "2.8 $Y$: as elastic"), (3.9, "with yield, 2.8 $Y$")]
)
def test_the_legend_of_peaks_names_curves_with_yield_that_elastic_ones_cover(soft, name):
    from hertzchain.plotting.peaks_over_impacts import plot_peaks

    kept = (False, False, False)
    axes = plot_peaks(
        {"": [0.1, 0.2]}, {"": [2.0, 4.0]}, {"": [(1.5, 2.0), (3.0, soft)]}, {"": [kept, kept]},
        factors=("1.6", "2.8"), where="the right wall", units="SI",
    )  # fmt: skip
    names = axes.get_legend_handles_labels()[1]
    assert names[-2:] == ["with yield, 1.6 $Y$", name]


def _sensor_force(speed, bead):
    """The force in a sensor and its first maximum on a fine grid of times."""
    chain = hc.Chain.from_materials(
        diameters="10 mm", beads=4, materials=STEEL, velocity=speed, right_wall=hc.Wall.of(STEEL)
    )
    found = hc.simulate(chain, times=20_000).sensor_force(bead)
    top = int(np.argmax(found.force > 0.999 * found.first_maximum))
    return float(found.force[top : top + 200].max())


def test_the_table_has_a_column_with_the_first_maxima_in_each_sensor(files):
    speeds = ["--speed", "0.02m/s", "--speed", "0.04m/s"]
    done = invoked(files[0], *speeds, "--sensor", "2", "--sensor", "3")
    assert done.exit_code == 0, done.output
    assert done.output.count("\u2500 ") == 1
    assert "2 speeds: force on the right wall (peak) and in sensors\n" in done.output
    lines = [line.split() for line in done.output.splitlines() if " m/s" in line]
    assert len(lines) == 2
    for line, speed in zip(lines, (0.02, 0.04), strict=True):
        assert line[:3] == [f"{speed:g}", "m/s", "equal"]
        assert line[4::2][:3] == ["N", "N", "N"]
        for bead, value in ((2, line[3]), (3, line[5])):
            assert float(value) == pytest.approx(_sensor_force(speed, bead), rel=1e-4)


def test_without_a_wall_the_first_sensor_has_the_peak_and_the_others_follow():
    chain = ["--material", STEEL, "--diameter", "10 mm", "--beads", "8"]
    speeds = ["--speed", "0.02m/s", "--speed", "0.04m/s"]
    done = invoked(*chain, *speeds, "--sensor", "3", "--sensor", "5")
    assert done.exit_code == 0, done.output
    assert "force in the first sensor (peak) and in other sensors\n" in done.output
    heading = next(line for line in done.output.splitlines() if "peak" in line and "bead" in line)
    assert heading.split()[:5] == ["speed", "peak", "time", "bead", "5"]
    assert "bead 3" not in done.output
    line = next(line.split() for line in done.output.splitlines() if "0.02 m/s" in line)
    assert float(line[2]) == pytest.approx(_sensor_force(0.02, 3), rel=0.1)


@pytest.mark.parametrize(
    ("changes", "entries"),
    [({}, ("2 N", "2 N")),
     ({"largest_so_far": 5.0, "largest_so_far_time": 8e-6}, ("2 N", "5 N")),
     ({"first_maximum": np.nan, "first_maximum_time": np.nan}, ("not complete", "2 N")),
     ({"reached": False}, ("not reached", "not reached"))],
)  # fmt: skip
def test_the_entries_of_a_sensor(changes, entries):
    from hertzchain.cli.compared_sensors import _entries

    first = {"first_maximum": 2.0, "first_maximum_time": 3e-6}
    sensor = first | {"largest_so_far": 2.0, "largest_so_far_time": 3e-6, "reached": True}
    assert _entries(SimpleNamespace(**sensor | changes), "SI") == entries


def test_the_largest_force_has_a_column_if_a_later_wave_is_stronger():
    from hertzchain.cli.compared_sensors import with_sensors

    first = {"first_maximum": 2.0, "first_maximum_time": 3e-6, "reached": True}
    equal = SimpleNamespace(**first, largest_so_far=2.0, largest_so_far_time=3e-6)
    later = SimpleNamespace(**first, largest_so_far=5.0, largest_so_far_time=8e-6)
    runs = {
        "a": SimpleNamespace(chain=hc.Chain.uniform(5), sensor_force={2: equal, 3: equal}.get),
        "b": SimpleNamespace(chain=hc.Chain.uniform(5), sensor_force={2: later, 3: equal}.get),
    }
    rows = {name: {"speed": "1", "peak": "9", "time": "8"} for name in runs}
    beads = {name: [2, 3] for name in runs}
    found = with_sensors(rows, runs, beads, {1.0: ""}, first_is_peak=False)
    names = ["first maximum in bead 2", "largest in bead 2", "first maximum in bead 3"]
    assert [*found["a"]] == ["speed", *names, "peak", "time"]
    assert [found["a"][name] for name in names] == ["2", "2", "2"]
    assert [found["b"][name] for name in names] == ["2", "5", "2"]
    # The peak is the largest force in the first sensor.
    found = with_sensors(rows, runs, beads, {1.0: ""}, first_is_peak=True)
    assert [*found["b"]] == ["speed", "peak", "time", names[0], names[2]]


def test_each_sensor_has_a_panel_over_impacts():
    from hertzchain.plotting.peaks_over_impacts import plot_peaks

    kept = [(False, False, False)] * 2
    axes = plot_peaks(
        {"a": [2e-3, 1e-3], "b": [1e-3, 2e-3]}, {"a": [4.0, 2.0], "b": [1.0, 3.0]}, {},
        {"a": kept, "b": kept}, factors=("1.6", "2.8"), where="the right wall", units="SI",
        heights=True,
        sensors={"ball 5": {"a": [8.0, 6.0], "b": [5.0, float("inf")]}},
    )  # fmt: skip
    upper, lower = axes.figure.axes
    assert upper is axes
    assert (upper.get_ylabel(), lower.get_ylabel()) == (
        "peak force on\nthe right wall [N]", "first maximum in\nball 5 [N]"
    )  # fmt: skip
    assert (upper.get_xlabel(), lower.get_xlabel()) == ("", "height of fall [mm]")
    lines = [line for line in lower.lines if line.get_linestyle() == "-"]
    assert lines[0].get_xydata().tolist() == [[1.0, 6.0], [2.0, 8.0]]
    assert lines[1].get_xydata()[0].tolist() == [1.0, 5.0]
    assert np.isnan(lines[1].get_ydata()[1])
    assert [each.get_color() for each in lines] == [
        each.get_color() for each in upper.lines if each.get_linestyle() == "-"
    ]


def test_the_figure_has_the_sensors_of_the_command(files, tmp_path):
    figure = tmp_path / "peaks.svg"
    speeds = ["--speed", "0.02m/s", "--speed", "0.04m/s"]
    done = invoked(*files, *speeds, "--sensor", "2", "--sensor", "3", "--plot", str(figure))
    assert done.exit_code == 0, done.output
    shown = figure.read_text()
    for label in ("the right wall [N]", "bead 2 [N]", "bead 3 [N]"):
        assert label in shown


def test_heights_are_repeated_like_speeds(files, tmp_path):
    figure = tmp_path / "peaks.png"
    heights = ["--height", "0.5 mm", "--height", "0.1cm"]
    done = invoked(*files, *heights, "--plot", str(figure), "--sensor", "2")
    assert done.exit_code == 0, done.output
    assert (
        "2 chains at 2 heights: force on the right wall (peak) and in sensors; * marks the "
        "smallest of each height" in (done.output)
    )
    assert figure.stat().st_size > 1000
    lines = [line for line in done.output.splitlines() if "N s" in line]
    sizes = ("10 mm", ["10 mm", "8 mm", "6 mm", "5 mm"])
    for line, (height, size) in zip(lines, [(h, s) for h in (0.5, 1) for s in sizes], strict=True):
        speed = (2.0 * 9.80665 * 1e-3 * height) ** 0.5
        assert f"{speed:.4g} m/s" in line
        assert f"{peak(size, speed):.5g} N" in line
    assert [" ".join(line.split()[:2]) for line in lines[::2]] == ["0.5 mm", "1 mm"]
    names = [
        each["name"] for each in json.loads(invoked(*files, *heights, "--json").output)["runs"]
    ]
    assert names == ["equal, 0.5 mm", "tapered, 0.5 mm", "equal, 1 mm", "tapered, 1 mm"]


def test_one_height_replaces_the_speed_in_every_command(run):
    balls = ("--material", STEEL, "--diameter", "10 mm", "--beads", 8)
    speed = (2.0 * 9.80665 * 5e-4) ** 0.5
    impacts = (("--height", "0.5 mm"), ("--speed", f"{speed!r} m/s"), ("--speed", "0.05 m/s"))
    found = [json.loads(run("pulse", *balls, *impact, "--json").stdout) for impact in impacts]
    assert found[0] == found[1]
    assert found[0] != found[2]


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (("--height", "1 mm", "--speed", "1 m/s"), "--height determines the speed: omit it or"),
        (("--height", "1 mm", "--height", "0.1 cm"), "--height is 1 mm twice; keep one"),
        (("--height", "1"), "--height 1 has no unit; write, for example, --height '1 mm'"),
        (("--height", "1 s"), "--height"),
        (("--height", "1 mm", "--striker", "2 g, height=1 mm"), "omit it or --height"),
    ],
)
def test_heights_that_cannot_be_used_are_rejected(files, run, given, message):
    code, _, err = run("simulate", files[0], *given)
    assert code == 2
    assert message in err


def test_a_scaled_chain_has_no_height(run, tmp_path):
    file = tmp_path / "scaled.toml"
    file.write_text('[chain]\ntaper = "uniform"\nbeads = 5\n')
    code, _, err = run("simulate", file, "--height", "1 mm")
    assert code == 2
    assert "--height requires a chain in SI units: give the velocity of the impact" in err
    code, _, err = run("simulate", "--beads", 5, "--height", "1 mm")
    assert code == 2
    assert "--height requires --material and --diameter" in err
    code, _, err = run("pulse", file, "--height", "1 mm", "--height", "2 mm")
    assert "give one --height, got 1 mm, 2 mm; simulate accepts several" in err


def test_a_figure_over_heights_is_in_millimetres():
    from hertzchain.plotting.peaks_over_impacts import plot_peaks

    axes = plot_peaks(
        {"": [2e-3, 1e-3]}, {"": [4.0, 2.0]}, {}, {"": [(False, False, False)] * 2},
        factors=("1.6", "2.8"), where="the right wall", units="SI", heights=True,
    )  # fmt: skip
    assert axes.lines[0].get_xydata().tolist() == [[1.0, 2.0], [2.0, 4.0]]
    assert axes.get_xlabel() == "height of fall [mm]"


@pytest.mark.parametrize(
    ("heights", "forces", "scale"),
    [([9e-3, 1e-3, 3e-3], [8.0, 2.0, 4.0], "log"), ([1e-3, 2e-3, 4e-3], [2.0, 3.0, 4.0], "log"),
     ([1e-3, 2e-3, 3.9e-3], [2.0, 3.0, 4.0], "linear"), ([1e-3, 9e-3], [2.0, 8.0], "linear"),
     ([1e-3, 3e-3, 9e-3], [0.0, 4.0, 8.0], "linear"),
     ([1e-3, 3e-3, 9e-3], [2.0, 4.0, float("inf")], "log"),
     ([1e-3, 9e-3, 9e-3], [2.0, 8.0, 8.0], "linear")],
)  # fmt: skip
@pytest.mark.parametrize("place", ["wall", "sensor", "yield"])
def test_many_impacts_over_a_wide_range_are_on_logarithmic_axes(heights, forces, scale, place):
    from hertzchain.plotting.peaks_over_impacts import plot_peaks

    own = forces if place == "wall" else [1.0, 2.0, 3.0][: len(heights)]
    axes = plot_peaks(
        {"a": heights}, {"a": own}, {"a": [(y, y) for y in forces]} if place == "yield" else {},
        {"a": [(False, False, False)] * len(heights)}, factors=("1.6", "2.8"),
        where="the right wall", units="SI", heights=True,
        sensors={"ball 5": {"a": forces}} if place == "sensor" else {},
    )  # fmt: skip
    for each in axes.figure.axes:
        assert (each.get_xscale(), each.get_yscale()) == (scale, scale)
        assert (each.get_ylim()[0] == 0.0) == (scale == "linear")
    if scale == "log":
        axes.figure.canvas.draw()
        labels = [text.get_text() for text in axes.figure.axes[-1].get_xticklabels()]
        assert {"1", "2"} <= set(labels)


@pytest.mark.parametrize(("low", "scale"), [(20.0, "linear"), (9.0, "log"), (0.0, "linear")])
def test_peaks_with_yield_far_below_elastic_ones_have_logarithmic_axes(low, scale):
    from hertzchain.plotting.peaks_over_impacts import plot_peaks

    axes = plot_peaks(
        {"": [0.02, 0.04, 0.06]}, {"": [50.0, 75.0, 100.0]},
        {"": [(low, 30.0), (24.0, 32.0), (26.0, 34.0)]}, {"": [(False,) * 3] * 3},
        factors=("1.6", "2.8"), where="the wall", units="SI", heights=True,
    )  # fmt: skip
    assert (axes.get_xscale(), axes.get_yscale()) == (scale, scale)
    axes.figure.clear()
