"""Walls of a given stiffness that are stiffer than the contact of the last ball."""

import json

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.integrate import solve_ivp

import hertzchain as hc
from hertzchain.cli import cli

STIFF = hc.Wall("50 kN/mm", exponent=1)
ROW = hc.Chain.from_materials(
    diameters="10 mm", materials="steel-52100", beads=3, velocity="0.1 m/s"
)
TOML = """[chain]
diameters = "10 mm"
materials = "steel-52100"
beads = 3
velocity = "0.1 m/s"
right_wall = "{wall}"
"""


def _series_peak(chain, stiffness):
    """Peak force of the spring in series with the Hertz contact of the last ball, by SciPy."""
    steel, radius = chain.materials[0], float(chain.radii[0])
    modulus = steel.young / (1.0 - steel.poisson**2) / 2.0
    between, at_wall = (4 / 3 * modulus * np.sqrt(each) for each in (radius / 2.0, radius))
    forces = np.linspace(0.0, 500.0, 100_001)
    overlaps = (forces / at_wall) ** (2 / 3) + forces / stiffness

    def motion(_, y):
        x, v = y[:3], y[3:]
        push = between * np.maximum(x[:2] - x[1:], 0.0) ** 1.5
        total = -np.append(push, np.interp(x[2], overlaps, forces)) + np.insert(push, 0, 0.0)
        return np.concatenate([v, total / chain.masses])

    start = np.zeros(6)
    start[3] = 0.1
    found = solve_ivp(motion, (0.0, 2e-4), start, rtol=1e-9, atol=1e-13, max_step=2e-7)
    return float(np.interp(found.y[2], overlaps, forces).max())


def test_the_note_is_right_and_its_cap_corrects_the_force():
    run = hc.simulate(ROW.replace(right_wall=STIFF))
    (note,) = run.notes
    ball = ROW.materials[0]
    force = run.wall_force().peak
    modulus = ball.young / (1.0 - ball.poisson**2) / 2.0
    overlap = (force / (4 / 3 * modulus * np.sqrt(5e-3))) ** (2 / 3)
    assert f"under the same force, {1e6 * overlap:.2g} um" in note
    assert f"deflection of {1e6 * force / 5e7:.2g} um" in note
    exact = _series_peak(ROW, 5e7)
    assert abs(force / exact - 1.0) > 0.1
    capped = hc.simulate(ROW.replace(right_wall=STIFF).with_cap("0.05 g"))
    assert not capped.notes
    assert capped.wall_force().peak == pytest.approx(exact, rel=0.03)


@pytest.mark.parametrize(
    "wall", [None, hc.Wall(), hc.Wall.rigid(gap="1 um"), hc.Wall("0.5 kN/mm", exponent=1)]
)
def test_there_is_no_note_on_soft_springs_and_other_walls(wall):
    assert hc.simulate(ROW.replace(right_wall=wall)).notes == ()


def test_a_soft_spring_without_a_note_has_nearly_the_force_of_both_in_series():
    run = hc.simulate(ROW.replace(right_wall=hc.Wall("0.5 kN/mm", exponent=1)), until="2 ms")
    assert run.notes == ()
    capped = hc.simulate(
        ROW.replace(right_wall=hc.Wall("0.5 kN/mm", exponent=1)).with_cap("0.05 g"), until="2 ms"
    )
    assert run.wall_force().peak == pytest.approx(capped.wall_force().peak, rel=0.05)


def test_a_chain_without_materials_has_no_note():
    chain = hc.Chain.uniform(3).replace(right_wall=hc.Wall(50.0, exponent=1))
    assert hc.simulate(chain, until=10.0).notes == ()


def test_the_command_states_it_with_its_own_option(tmp_path):
    file = tmp_path / "stiff.toml"
    file.write_text(TOML.format(wall="50 kN/mm"))
    done = CliRunner().invoke(cli, ["simulate", str(file)])
    assert "the spring of the right wall replaces the Hertz contact of bead 3" in done.output
    assert "note: the spring of the right wall" in done.output
    assert "add a light cap: --cap '0.08 g'" in " ".join(done.output.split())
    (note,) = json.loads(CliRunner().invoke(cli, ["simulate", str(file), "--json"]).stdout)["notes"]
    assert "--cap" in note
    several = ["--speed", "0.05m/s", "--speed", "0.1m/s"]
    done = CliRunner().invoke(cli, ["simulate", str(file), *several])
    assert "Warning: stiff, 0.05 m/s: the spring" in " ".join(done.stderr.split())
    file.write_text(TOML.format(wall="0.5 kN/mm"))
    assert "replaces" not in CliRunner().invoke(cli, ["simulate", str(file)]).output


def test_a_design_does_not_claim_to_have_checked_the_spring():
    problem = hc.Design(
        ROW.replace(right_wall=STIFF), minimise="wall_force.peak",
        vary=[hc.vary.balls(materials=["steel-52100"], diameters=["8 mm", "10 mm"], beads="3")],
    )  # fmt: skip
    result = hc.design(problem, budget=4, seed=1)
    assert result.verified.stiff_walls == result.verified.stiff_walls[:1] != ()
    text = " ".join(result.summary().split())
    assert "all contacts stayed" not in text
    assert "the spring of the wall is too stiff to replace one (see the notes)" in text
    assert "add a light cap" in text


def test_the_left_wall_is_checked_too():
    chain = ROW.replace(left_wall=STIFF, velocities=[-0.1, 0.0, 0.0])
    (note,) = hc.simulate(chain, until="0.2 ms").notes
    assert "the spring of the left wall" in note


def test_the_json_document_has_the_largest_pressure_of_the_text(tmp_path):
    file = tmp_path / "row.toml"
    file.write_text(TOML.format(wall="same"))
    text = CliRunner().invoke(cli, ["simulate", str(file)]).output
    found = json.loads(CliRunner().invoke(cli, ["simulate", str(file), "--json"]).stdout)
    largest = found["largest_pressure_over_yield"]
    place = "the right wall" if largest["contact"] == 3 else f"contact {largest['contact']}"
    assert f"pressure / yield {largest['pressure_over_yield']:.2g} at {place}" in text
    assert len(largest["between"]) == 2
    assert "contacts" not in found
    scaled = CliRunner().invoke(cli, ["simulate", "--beads", "5", "--json"])
    assert json.loads(scaled.stdout)["largest_pressure_over_yield"] is None


def test_tables_of_many_chains_count_it():
    chains = [ROW.replace(right_wall=hc.Wall(each, exponent=1)) for each in (5e5, 5e7)]
    table = hc.simulate_many(chains, keep=["wall_peak_force"])
    assert "in 1 chain, the spring of a wall is too stiff" in " ".join(repr(table).split())
    assert "in 1 chain, the spring of a wall is too stiff" in table._repr_html_()
    for other in (
        hc.simulate_many(chains[:1], keep=["wall_peak_force"]),
        # Overlaps of whole runs are unknown.
        hc.simulate_many(chains, keep=["velocity"], check_range=False),
    ):
        assert "stiff" not in repr(other)


@pytest.mark.parametrize(
    "command", [("scatter", "--grade", "100", "--chains", "9"), ("sensitivity",)], ids=" ".join
)
def test_scatter_and_sensitivity_have_the_note_of_the_run(tmp_path, command):
    file = tmp_path / "row.toml"
    name, *options = command
    found = {}
    for wall in ("50 kN/mm", "0.5 kN/mm"):
        file.write_text(TOML.format(wall=wall))
        text = CliRunner().invoke(cli, [name, str(file), *options]).output
        shown = CliRunner().invoke(cli, [name, str(file), *options, "--json"]).stdout
        found[wall] = " ".join(text.split()), " ".join(json.loads(shown)["notes"])
    for text in found["50 kN/mm"]:
        assert "the spring of the right wall replaces the Hertz contact of bead 3" in text
        assert "add a light cap: --cap '0.08 g'" in text
    assert all("spring" not in text for text in found["0.5 kN/mm"])


# With the first quantities, all points are simulated together; with the others, one by one.
@pytest.mark.parametrize("keep", [["wall_peak_force"], ["wall_peak_force", "yield_ratio"]])
def test_sweeps_name_the_points(tmp_path, keep):
    document = {
        "chain": ROW.replace(right_wall=STIFF),
        "axes": {"right_wall.stiffness": [5e5, 5e7]},
        "sweep": {"methods": ["simulate"], "keep": keep},
    }
    store = tmp_path / "walls.zarr"
    with pytest.warns(hc.ModelRangeWarning, match="at 1 of 2 points, the spring of a wall is too"):
        found = hc.sweep(document, store)
    soft, stiff = found.reason.values.ravel()
    assert soft == ""
    assert stiff.startswith("the spring of the right wall is too stiff")
    assert stiff.endswith("add a light cap of 0.08 g")
    assert (found.outside_range == 0).all()
    done = CliRunner().invoke(cli, ["sweep", "status", str(store)])
    assert done.exit_code == 0
    assert "the Hertz contact of a ball: 1 (see variable `reason`)" in done.output
    shown = CliRunner().invoke(cli, ["sweep", "status", str(store), "--json"]).stdout
    assert json.loads(shown)["stiff_wall"] == 1
