"""Figures over several speeds of chains whose contacts have a law of yield."""

import pytest

from hertzchain.plotting.peaks_over_impacts import plot_peaks

KEPT = (False, False, False)


def _axes(**changes):
    yielding = {"ep": [(3.0, 3.5), (1.5, 2.0)], "elastic": [(3.0, 3.5), (1.5, 1.9)]}
    return plot_peaks(
        {"elastic": [0.2, 0.1], "ep": [0.2, 0.1]}, {"elastic": [4.0, 2.0], "ep": [3.0, 1.5]},
        yielding, {"elastic": [KEPT, KEPT], "ep": [KEPT, KEPT]},
        factors=("1.6", "2.8"), where="the right wall", units="SI", **changes,
    )  # fmt: skip


def test_peaks_at_an_assumed_pressure_are_not_drawn_as_elastic():
    axes = _axes(lawful=["ep"])
    colour = next(line for line in axes.lines if line.get_label() == "ep").get_color()
    curves = {
        line.get_linestyle(): line.get_ydata().tolist()
        for line in axes.lines
        if line.get_color() == colour and len(line.get_xdata()) == 2
    }
    assert curves == {"--": [1.5, 3.0], ":": [2.0, 3.5]}
    assert len(axes.collections) == 2
    assert axes.get_legend_handles_labels()[1] == [
        "elastic", "ep", "elastic", "with yield, 1.6 $Y$", "with yield, 2.8 $Y$"
    ]  # fmt: skip


def test_the_legend_does_not_call_a_given_yield_pressure_elastic():
    names = _axes(given_pressure=True).get_legend_handles_labels()[1]
    assert "elastic, or its own yield pressure" in names


def test_sensors_of_such_a_chain_are_dashed():
    forces = {"ball 2": {"elastic": [8.0, 6.0], "ep": [5.0, 4.0]}}
    lower = _axes(lawful=["ep"], sensors=forces).figure.axes[1]
    styles = {tuple(line.get_ydata()): line.get_linestyle() for line in lower.lines}
    assert styles[6.0, 8.0] == "-"
    assert styles[4.0, 5.0] == "--"


@pytest.mark.parametrize("lawful", [["ep"], []])
def test_two_chains_without_elastic_peaks_are_not_the_same_curve(lawful):
    axes = _axes(lawful=["elastic", *lawful])
    assert not any("same curve" in name for name in axes.get_legend_handles_labels()[1])


def test_a_single_chain_with_a_law_has_no_elastic_curve():
    axes = plot_peaks(
        {"": [0.1, 0.2]}, {"": [1.5, 3.0]}, {"": [(1.5, 2.0), (3.0, 3.5)]}, {"": [KEPT, KEPT]},
        factors=("1.6", "2.8"), where="the right wall", units="SI", lawful=[""],
    )  # fmt: skip
    assert axes.get_legend_handles_labels()[1] == ["with yield, 1.6 $Y$", "with yield, 2.8 $Y$"]
    assert not any(line.get_linestyle() == "-" for line in axes.lines)


def test_the_command_draws_both_ends_of_a_law_of_yield(tmp_path, monkeypatch):
    from click.testing import CliRunner

    import hertzchain.plotting.peaks_over_impacts as module
    from hertzchain.cli import cli

    taken = {}
    draw = module.plot_peaks

    def recorded(*given, **options):
        taken.update(given=given, **options)
        return draw(*given, **options)

    monkeypatch.setattr(module, "plot_peaks", recorded)
    row = ["--material", "steel-52100", "--diameter", "10 mm", "--beads", "3", "--cap", "50 g"]
    both = ["--speed", "0.02m/s", "--speed", "0.04m/s", "--plot", str(tmp_path / "cap.svg")]
    done = CliRunner().invoke(cli, ["simulate", *row, *both])
    assert done.exit_code == 0, done.output
    assert taken["where"] == "the cap"
    chain = ["--material", "steel-304", "--diameter", "10 mm", "--beads", "4", "--wall", "same"]
    done = CliRunner().invoke(cli, [
        "simulate", *chain, "--loss", "elastic-plastic", "--speed", "0.1m/s", "--speed", "0.2m/s",
        "--plot", str(tmp_path / "p.svg"),
    ])  # fmt: skip
    assert done.exit_code == 0, done.output
    ((name, pairs),) = taken["given"][2].items()
    assert taken["lawful"] == [name]
    # The table has the same values.
    for low, high in pairs:
        assert f"{low:.5g} N" in done.output
        assert f"{high:.5g} N" in done.output
