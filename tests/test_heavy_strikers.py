"""Impacts of heavy strikers on columns under gravity: the end of the first impact."""

import functools
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import hertzchain as hc

pytestmark = [
    pytest.mark.filterwarnings(f"ignore::hertzchain.errors.{each}")
    for each in ("ModelRangeWarning", "IncompleteWarning")
]

GRAVITY, BALLS, RADIUS, STRIKER = 9.81, 12, 19.05e-3 / 2, 0.5
CELL = 2e8
NYLON = hc.material("nylon")


def column(height="5 mm", gravity=GRAVITY):
    row = hc.Chain.from_materials(
        diameters="19.05 mm", materials="nylon", beads=BALLS, gravity=gravity,
        right_wall=hc.Wall(CELL, exponent=1),
    )  # fmt: skip
    return row.struck_by(mass=STRIKER, radius="inf", height=height)


@functools.cache
def integrated(height):
    """Peak, its time, end and impulse of the first contact with the cell, by SciPy."""
    modulus = NYLON.young / (2.0 * (1.0 - NYLON.poisson**2))
    masses = np.array([STRIKER] + [4.0 / 3.0 * math.pi * NYLON.density * RADIUS**3] * BALLS)
    radii = np.array([RADIUS] + [RADIUS / 2.0] * (BALLS - 1))
    stiffness = 4.0 / 3.0 * modulus * np.sqrt(radii)
    weights = np.cumsum(masses[1:]) * GRAVITY
    x = np.zeros(BALLS + 1)
    x[BALLS] = weights[-1] / CELL
    for i in range(BALLS - 1, 0, -1):
        x[i] = x[i + 1] + (weights[i - 1] / stiffness[i]) ** (2.0 / 3.0)
    x[0] = x[1]
    v = np.zeros(BALLS + 1)
    v[0] = math.sqrt(2.0 * 9.80665 * height)

    def forces(x):
        overlaps = np.maximum(np.append(x[:-1] - x[1:], x[-1]), 0.0)
        return np.append(stiffness * overlaps[:-1] ** 1.5, CELL * overlaps[-1])

    def rates(_, y):
        f = forces(y[: BALLS + 1])
        return [*y[BALLS + 1 : -1], *((np.append(0.0, f[:-1]) - f) / masses + GRAVITY), f[-1]]

    def leaves(_, y):
        return y[BALLS]

    leaves.terminal, leaves.direction = True, -1
    found = solve_ivp(
        rates, (0.0, 20e-3), [*x, *v, 0.0], method="DOP853", rtol=1e-10, atol=1e-13,
        events=leaves, max_step=4e-6,
    )  # fmt: skip
    force = CELL * found.y[BALLS]
    return force.max(), found.t[np.argmax(force)], found.t[-1], found.y[-1, -1]


@pytest.fixture(scope="module")
def first_run():
    return hc.simulate(column())


def test_the_first_impact_on_soft_balls_is_over_when_the_striker_has_rebounded(first_run):
    """With a stiff cell, the energy that rattles in the row could otherwise exceed any peak."""
    peak, time, end, impulse = integrated(5e-3)
    wall = first_run.wall_force()
    assert wall.complete
    assert not wall.proven
    assert wall.peak == pytest.approx(peak, rel=2e-4)
    assert wall.peak_time == pytest.approx(time, abs=4e-6)
    # The static force remains for a while after the force has fallen to it.
    assert wall.complete_since == pytest.approx(end, rel=0.01)
    assert wall.impulse_of_impact == pytest.approx(impulse, rel=1e-3)
    assert wall.duration == pytest.approx((impulse - end * wall.static_force) / peak, rel=0.01)
    assert "later impact may be stronger" in repr(wall)
    # The striker takes most of the energy away.
    kinetic = 0.5 * first_run.chain.masses * first_run.velocities[-1] ** 2
    assert first_run.velocities[-1, 0] < 0.0
    assert kinetic[0] > 0.9 * kinetic.sum()


@pytest.mark.parametrize("until", ["20 ms", "40 ms"])
def test_the_first_impact_remains_over_while_the_striker_falls_back(first_run, until):
    first, later = first_run.wall_force(), hc.simulate(column(), until=until).wall_force()
    for name in ("peak", "peak_time", "complete_since", "impulse_of_impact", "duration"):
        assert getattr(later, name) == pytest.approx(getattr(first, name), rel=1e-9)
    assert later.impulse > first.impulse


def test_a_stronger_later_impact_replaces_the_first_one(first_run):
    second = hc.simulate(column(), until="90 ms").wall_force()
    assert second.largest_so_far > 2.0 * first_run.wall_force().peak
    assert second.largest_so_far_time > 50e-3
    assert not second.complete or second.peak == second.largest_so_far


def test_ensembles_and_gradients_have_the_same_peak(first_run):
    wall = first_run.wall_force()
    table = hc.simulate_many(
        [column()], keep=["wall_peak_force", "wall_impulse_of_impact"], check_range=False
    )
    assert table["wall_peak_force"][0] == pytest.approx(wall.peak, rel=1e-6)
    assert table["wall_impulse_of_impact"][0] == pytest.approx(wall.impulse_of_impact, rel=1e-3)
    late = hc.simulate_many([column()], keep="wall_peak_force", until=20e-3, check_range=False)
    assert late["wall_peak_force"][0] == pytest.approx(wall.peak, rel=1e-6)
    slope = hc.gradient(column(), "wall_force.peak", to="velocities", until="20 ms")
    assert slope.value == pytest.approx(wall.peak, rel=1e-6)


def test_a_row_that_is_still_pressed_is_not_over():
    """Before the striker has left the row, its motion may still cause a larger force."""
    with pytest.warns(hc.IncompleteWarning, match="moves or can fall towards the wall"):
        early = hc.simulate(column(), until="6 ms").wall_force()
    assert not early.complete


def test_losses_do_not_keep_the_impact_from_ending():
    lossy = column().replace(loss=hc.Viscoelastic("7 us"))
    wall = hc.simulate(lossy).wall_force()
    assert wall.complete
    assert wall.peak < 125.0
    plastic = hc.simulate(column().replace(loss=hc.ElasticPlastic())).wall_force()
    assert plastic.complete


FILE = """[chain]
diameters = "19.05 mm"
beads = 12
materials = "nylon"
gravity = "9.81 m/s^2"
struck_by = {mass = "0.5 kg", radius = inf, height = "5 mm"}
right_wall = {stiffness = "200 kN/mm", exponent = 1}
"""
HEIGHTS = ("--height", "2mm", "--height", "5mm", "--height", "10mm")


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "ny.toml"
    path.write_text(FILE)
    return path


def test_a_figure_without_any_peak_is_not_written(run, file, tmp_path):
    figure = tmp_path / "z.png"
    done = run("simulate", file, *HEIGHTS, "--until", "5ms", "--plot", figure)
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1] == (
        "Error: --plot has nothing to plot, because no peak is complete; give a later --until"
    )
    assert done.stdout.count("not complete") == 3
    assert not figure.exists()
    done = run("simulate", file, *HEIGHTS, "--plot", figure)
    assert done.returncode == 0
    assert figure.exists()


def test_a_panel_without_forces_says_so():
    """The logarithmic axes of the others need no value in it."""
    from hertzchain.plotting.peaks_over_impacts import plot_peaks

    x = [0.1, 0.2, 0.4]
    axes = plot_peaks(
        {"": x}, {"": [math.inf] * 3}, {}, {"": [(False, False, False)] * 3},
        factors=("1.6", "2.8"), where="the right wall", units="SI",
        sensors={"ball 4": {"": [1.0, 2.0, 4.0]}},
    )  # fmt: skip
    empty, other = axes.figure.axes
    axes.figure.canvas.draw()
    assert [each.get_text() for each in empty.texts] == ["no force is known"]
    assert not other.texts
    assert other.get_yscale() == "log"


def test_the_table_of_heights_states_that_peaks_are_so_far(run, file):
    done = run("simulate", file, *HEIGHTS)
    assert "peak: so far; the beads can return to the wall, and a later impact" in done.stdout


def test_the_rebound_is_printed_without_a_given_end(run, file, first_run):
    done = run("simulate", file)
    velocity = first_run.state.velocities[0]
    assert velocity < 0.0
    assert f"striker at the end of the run: velocity {velocity:.4g} m/s" in done.stdout


def test_a_chain_file_keeps_the_height(file):
    chain = hc.load_chain(file)
    written = hc.chain_as_toml(chain)
    assert 'height = "5 mm"' in written
    path = file.with_name("again.toml")
    path.write_text(written)
    assert hc.load_chain(path).velocities[0] == chain.velocities[0]
    assert 'velocity = "0.3 m/s"' in hc.chain_as_toml(
        chain.replace(velocities=[0.3] + [0.0] * BALLS)
    )


@pytest.mark.parametrize(
    ("part", "said"),
    [("flt", "--striker: 'flt' is not known; did you mean 'flat'?"),
     ("heght=5mm", "--striker has no key 'heght'; did you mean 'height=5mm'?"),
     ("speed=5", "--striker has no key 'speed': choose height=..., the height of a fall")],
)  # fmt: skip
def test_misspelt_parts_of_a_striker_are_corrected(run, part, said):
    done = run("simulate", "--material", "nylon", "--diameter", "1 cm", "--beads", 3,
                  "--striker", f"0.5 kg, {part}")  # fmt: skip
    assert done.returncode == 2
    assert said in done.stderr


def test_a_forecast_says_how_to_see_the_whole_pulse(file):
    place = ["ball 4"]
    short = hc.forecast(file, place, noise=0.5, interval="5 us", free=["stiffness"], until="2 ms")
    text = short.summary(width=None)
    assert "ball 4 not complete; give a later until, at which all forces have fallen" in text
    assert math.isnan(short.recommended_interval)
    long = hc.forecast(file, place, noise=0.5, interval="5 us", free=["stiffness"], until="9 ms")
    assert long.recommended_interval > 0.0
    assert "not complete" not in long.summary(width=None)
