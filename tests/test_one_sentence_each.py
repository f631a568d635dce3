"""Bad input that once got a message about something else."""

import pytest

import hertzchain as hc

ROW = ["--material", "steel-52100", "--diameter", "10 mm", "--beads", 4, "--speed", "0.1 m/s"]


@pytest.mark.parametrize(("options", "message"), [
    (("--gravity", "nan m/s^2"), "--gravity must be finite, got 'nan m/s^2'"),
    (("--until", "nan s"), "--until must be above 0 and finite, got 'nan s'"),
    (("--wall", "-5 kN/mm"), "stiffness of a wall must be above 0, got '-5 kN/mm'; for a rigid "
                             "wall, use --wall rigid, or rigid = true in the chain file"),
    (("--sensor", 2, "--sensor", "ball 2"), "--sensor names bead 2 twice; keep one"),
])  # fmt: skip
def test_messages(run, options, message):
    done = run("simulate", *ROW, *options)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.splitlines()[-1] == f"Error: {message}"


def test_a_rising_force_on_a_cap_is_marked(run):
    done = run("simulate", *ROW, "--cap", "20 g", "--until", "90 us")
    (line,) = (each for each in done.stdout.splitlines() if "force on it" in each)
    assert "no maximum yet, largest so far" in line
    assert line.endswith("a larger force may follow")
    chain = hc.Chain.from_materials("5 mm", "steel-52100", beads=4, velocity="0.1 m/s")
    axes = hc.simulate(chain.with_cap("20 g"), until="90 us").plot_forces("body")
    (text,) = axes.get_legend().get_texts()
    assert text.get_text() == "force on the cap (a larger force may follow)"


def test_one_chain_is_not_plural():
    table = hc.simulate_many([hc.Chain.uniform(3)], keep="velocity")
    assert repr(table).startswith("RunTable(1 chain of up to 3 beads")
    assert repr(hc.propagate_many([hc.Chain.uniform(3)])).startswith("PulseTable(1 chain of")


def test_tables_of_chains_have_the_range_and_mean_at_the_last_beads():
    chains = [hc.Chain.uniform(n).replace(right_wall=hc.Wall()) for n in (4, 8)]
    table = hc.simulate_many(chains, keep=["velocity", "wall_peak_force", "peak_force"])
    pulses = hc.propagate_many([[1.0, 1.0, 1.0], [1.0, 2.0]])
    for found, name, ends in (
        (table, "velocity of the last bead", [table["velocity"][0, 3], table["velocity"][1, 7]]),
        (table, "peak_force of the last contact",
         [table["peak_force"][0, 2], table["peak_force"][1, 6]]),
        (table, "wall_peak_force", table["wall_peak_force"]),
        (pulses, "velocity of the last bead", [pulses.velocity[0, 2], pulses.velocity[1, 1]]),
    ):  # fmt: skip
        told = f"{name} {min(ends):.4g} to {max(ends):.4g}, mean {sum(ends) / 2:.4g}"
        assert told in " ".join(repr(found).split())
    early = hc.simulate_many(chains, keep="wall_peak_force", until=1.0)
    assert ", 2 incomplete: wall_peak_force not known" in repr(early)


def test_titles_of_tables_are_complete(run):
    done = run("pulse", *ROW, "--cap", "5 g", "--wall", "5 kN/mm", "--striker", "10 g",
               "--method", "simulate")  # fmt: skip
    assert done.stdout.splitlines()[0].endswith("right wall of 5 kN/mm")


def test_percentiles_in_the_legend_have_the_same_decimals():
    chain = hc.Chain.uniform(6).replace(right_wall=hc.Wall())
    found = hc.distribution(chain, "wall_force.peak", hc.Scatter(radius=0.01, samples=40))
    (text,) = (each.get_text() for each in found.plot().get_legend().get_texts()
               if "median" in each.get_text())  # fmt: skip
    numbers = text.partition(": ")[2].split(", ")
    assert len({len(each.partition(".")[2]) for each in numbers}) == 1
