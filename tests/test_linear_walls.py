"""Walls that are linear springs: a bead on a spring moves in half a sine."""

import math

import numpy as np
import pytest
from scipy_chain import Units, trajectory

import hertzchain as hc

STIFFNESS, SPEED, GAP = 0.3, 0.7, 0.5


def one_bead(**wall):
    """Three beads of which only the last one moves and meets the wall."""
    wall = hc.Wall(stiffness=STIFFNESS, exponent=1, gap=GAP, **wall)
    return hc.Chain.uniform(3).replace(velocities=[0.0, 0.0, SPEED], right_wall=wall)


@pytest.mark.parametrize(
    ("options", "error"), [({}, 1e-10), ({"method": "verlet", "drift": 1e-9}, 1e-8)]
)
def test_one_bead_on_a_linear_wall(options, error):
    """Contact time pi sqrt(m/k), largest force v sqrt(k m), impulse 2 m v."""
    chain = one_bead()
    lasts = GAP / SPEED + math.pi / math.sqrt(STIFFNESS)
    wall = hc.simulate(chain, until=lasts + 1.0, times=0, **options)._wall_force("right")
    assert wall.largest_so_far == pytest.approx(SPEED * math.sqrt(STIFFNESS), rel=error)
    assert wall.first_contact_impulse == pytest.approx(2.0 * SPEED, rel=error)
    middle = GAP / SPEED + 0.5 * math.pi / math.sqrt(STIFFNESS)
    assert wall.largest_so_far_time == pytest.approx(middle, rel=1e-5)
    for time, force in ((-0.01, True), (0.01, False)):
        run = hc.simulate(chain, until=lasts + time, times=2, **options)
        assert (run.forces[-1, -1] > 0.0) == force


@pytest.mark.parametrize("pulls", [True, False])
def test_a_dashpot_at_a_linear_wall(pulls):
    """Schwager, Poeschel, Granular Matter 9, 465 (2007): without pull, the force ends at 0."""
    gamma = 0.2
    chain = one_bead(loss=hc.Dashpot(gamma, attractive=pulls))
    run = hc.simulate(chain, until=7.0, times=0)
    root = math.sqrt(STIFFNESS)
    damping = 0.5 * gamma / root
    turn = math.sqrt(1.0 - damping**2)
    angle = math.pi if pulls else math.acos(2.0 * damping**2 - 1.0)
    left = math.exp(-damping / turn * angle)
    assert -run.state.velocities[-1] / SPEED == pytest.approx(left, rel=1e-8)


def test_a_restitution_at_a_linear_wall():
    run = hc.simulate(one_bead(loss=hc.Restitution(0.8)), until=7.0, times=0)
    assert -run.state.velocities[-1] / SPEED == pytest.approx(0.8, rel=1e-8)


def test_a_pulse_on_a_linear_wall():
    """Compared with SciPy, by all methods."""
    chain = hc.Chain.uniform(8).replace(right_wall=hc.Wall(stiffness=STIFFNESS, exponent=1.0))
    run = hc.simulate(chain, times=0, rtol=1e-12)
    wall = run.wall_force()
    near = wall.peak_time + np.linspace(-0.05, 0.05, 201)
    force = trajectory(chain, np.append(0.0, near), Units(1.0, 1.0, 1.0)).forces[1:, -1]
    assert wall.peak == pytest.approx(force.max(), rel=1e-7)
    table = hc.simulate_many([chain], keep=["wall_peak_force", "wall_impulse"], rtol=1e-12)
    assert table["wall_peak_force"][0] == pytest.approx(wall.peak, rel=1e-9)
    assert wall.proven
    value, slope = hc.gradient(chain, "wall_force.peak", to="right_wall.stiffness")
    peaks = [
        hc.simulate(
            chain.replace(right_wall=hc.Wall(stiffness=part * STIFFNESS, exponent=1.0)), times=0,
            rtol=1e-13,
        ).wall_force().peak
        for part in (1.0 - 1e-4, 1.0 + 1e-4)
    ]  # fmt: skip
    assert value == pytest.approx(wall.peak, rel=1e-9)
    difference = (peaks[1] - peaks[0]) / (2e-4 * STIFFNESS)
    assert slope["right_wall.stiffness"] == pytest.approx(difference, rel=1e-5)


def test_units_and_files_of_linear_walls(tmp_path):
    wall = hc.Wall("2 kN/mm", exponent=1)
    assert wall.stiffness == 2e6
    chain = hc.Chain.from_materials(10e-3, "steel-52100", beads=5, velocity=0.1, right_wall=wall)
    run = hc.simulate(chain, times=0)
    file = tmp_path / "chain.toml"
    file.write_text(hc.chain_as_toml(chain))
    assert hc.load_chain(file).right_wall.exponent == 1.0
    # The unit of the table of a file, as of the app, determines the exponent.
    file.write_text('[chain]\nradii = [1.0, 1.0]\nmaterials = "brass"\n'
                    '[chain.right_wall]\nstiffness = "2 kN/mm"\n')  # fmt: skip
    assert hc.load_chain(file).right_wall == wall
    scales = hc.Scales.of(chain)
    scaled = scales.to_scaled(chain)
    peak = scales.force * hc.simulate(scaled, times=0).wall_force().peak
    assert peak == pytest.approx(run.wall_force().peak, rel=1e-8)
    assert hc.Wall("2 kN/mm") == wall
    assert hc.Wall("2 N/m^1.5").exponent is None
    with pytest.raises(hc.InputError, match="contacts with this unit have exponent = 1"):
        hc.Wall("2 kN/mm", exponent=1.5)
    for wrong in (0.9, 0.0, 51.0):
        with pytest.raises(hc.InputError, match="a wall must be at least 1 and at most 50"):
            hc.Wall(stiffness=1.0, exponent=wrong)
    with pytest.raises(hc.InputError, match="must be above 1"):
        hc.Chain.uniform(5, exponent=1.0)


def test_the_spectrum_of_a_precompressed_row_on_a_spring():
    """Eigenvalues of the matrix of springs, 3/2 k^(2/3) F^(1/3) between the beads."""
    force, spring = 50.0, 2e6
    row = hc.Chain.from_materials(10e-3, "steel-52100", beads=8, left_wall=hc.Wall())
    held = row.replace(precompression=force, right_wall=hc.Wall(stiffness=spring, exponent=1))
    k = np.append(1.5 * held.contact_stiffness[:-1] ** (2 / 3) * force ** (1 / 3), spring)
    matrix = np.diag(k[:-1] + k[1:]) - np.diag(k[1:-1], 1) - np.diag(k[1:-1], -1)
    expected = np.sqrt(np.linalg.eigvalsh(matrix / held.masses[0])) / (2.0 * math.pi)
    np.testing.assert_allclose(hc.spectrum(held).frequencies, expected, rtol=1e-9)


@pytest.mark.parametrize("material", [None, "rubber"])
def test_the_contact_with_a_pad_is_not_checked(material, run, tmp_path):
    # Over a plate, the force of the pad acts on more than one point of the ball.
    pad = hc.Wall("2 kN/mm", exponent=1, material=material)
    chain = hc.Chain.from_materials("5 mm", "steel-52100", beads=3, velocity=0.3, right_wall=pad)
    found = hc.simulate(chain)
    limits = hc.hertz_range(chain, found.largest_overlaps)
    assert np.isnan([limits.yield_ratio[3], limits.overlap_ratio[3]]).all()
    assert np.isfinite([limits.yield_ratio[1:3], limits.overlap_ratio[1:3]]).all()
    assert limits.violations == ()
    assert "nan" not in str(limits) + repr(limits) + limits._repr_html_()
    # A wall with the exponent of spheres is checked.
    stiff = chain.replace(right_wall=hc.Wall(1e9, material=material))
    assert np.isfinite(hc.hertz_range(stiff, found.largest_overlaps).overlap_ratio[3])
    path = tmp_path / "pad.toml"
    path.write_text(hc.chain_as_toml(chain))
    code, out, err = run("simulate", path, "--contacts")
    assert code == 0
    assert err == ""
    assert "spring, not checked" in next(line for line in out.splitlines() if "ball 3 and" in line)
    assert "no known yield strength" not in out


ROW = hc.Chain.from_materials("5 mm", "brass", beads=10)
CELL = hc.Wall("5 kN/mm", exponent=1)


@pytest.mark.parametrize(
    ("chain", "end"),
    [
        (ROW.replace(right_wall=hc.Wall()), "diameter 10 mm, right wall"),
        (ROW.replace(right_wall=hc.Wall.of("brass")), "diameter 10 mm, right wall"),
        (ROW.replace(right_wall=hc.Wall.of("glass")), "right wall of glass"),
        (ROW.replace(right_wall=hc.Wall.rigid()), "rigid right wall"),
        (ROW.replace(right_wall=CELL), "10 mm, right wall of 5 kN/mm"),
        (ROW.replace(right_wall=hc.Wall("900 N/mm", exponent=1, material="glass")),
         "10 mm, right wall of 900 N/mm"),
        (ROW.replace(right_wall=hc.Wall(1e10)), "right wall of 10 N/um^1.5"),
        (ROW.replace(right_wall=CELL).with_cap("5 g", stiffness="1 kN/mm", exponent=1),
         "a cap (5 g, brass, pad of 1 kN/mm), right wall of 5 kN/mm"),
        (ROW[:1].replace(right_wall=CELL).with_cap("5 g"),
         "a cap (5 g, brass), right wall of 5 kN/mm"),
        (one_bead(), "3 beads, velocities, right wall of stiffness 0.3 (p = 1)"),
        (hc.Chain.uniform(3).replace(exponent=[1.5, 2.0], right_wall=hc.Wall(2.0)),
         "right wall of stiffness 2, mixed exponents"),
        (hc.Chain.uniform(3).replace(left_wall=hc.Wall(2.0)), "left wall of stiffness 2"),
    ],
)  # fmt: skip
def test_descriptions_name_the_wall_and_not_the_exponent_of_a_spring(chain, end):
    assert chain.description.endswith(end)
    assert ("mixed exponents" in chain.description) == ("mixed exponents" in end)
