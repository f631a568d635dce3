"""A single ball: struck by another one, against the closed form of a Hertz collision, or alone."""

import math

import numpy as np
import pytest

import hertzchain as hc

STEEL, BRASS = hc.material("steel-52100"), hc.material("brass")


def ball(**fields):
    return hc.Chain.from_materials(diameters=["12 mm"], materials="steel-52100", **fields)


def of_hertz(chain):
    """Velocities after the collision of two balls, duration, and largest overlap and force."""
    (m1, m2), v = chain.masses, chain.velocities[0] - chain.velocities[1]
    (r1, r2), (one, two) = chain.radii, chain.materials
    compliance = sum((1.0 - each.poisson**2) / each.young for each in (one, two))
    k = 4.0 / 3.0 / compliance * math.sqrt(r1 * r2 / (r1 + r2))
    overlap = (5.0 * m1 * m2 / (m1 + m2) * v**2 / (4.0 * k)) ** 0.4
    duration = 4.0 * math.sqrt(math.pi) * math.gamma(0.4) / (5.0 * math.gamma(0.9)) * overlap / v
    after = v * np.array([m1 - m2, 2.0 * m1]) / (m1 + m2)
    return after, duration, overlap, k * overlap**1.5


@pytest.mark.parametrize(
    "striker",
    [{}, {"diameter": "19 mm"}, {"diameter": "6 mm", "material": "brass"}],
    ids=["equal", "large", "small and softer"],
)
def test_a_struck_ball_is_a_collision_of_hertz(striker):
    chain = ball().struck_by(velocity="0.02 m/s", **striker)
    assert (chain.beads, chain.strikers) == (2, 1)
    after, duration, overlap, force = of_hertz(chain)
    run = hc.simulate(chain, until=2.0 * duration, times=2)
    np.testing.assert_allclose(run.velocities[-1], after, rtol=1e-10, atol=1e-14)
    for pulse in (run.pulse(), hc.propagate(chain)):
        assert pulse.peak_overlap[0] == pytest.approx(overlap, rel=1e-10)
        assert pulse.peak_force[0] == pytest.approx(force, rel=1e-10)
    # The struck ball is fastest when the contact opens.
    assert run.pulse().peak_time[1] == pytest.approx(duration, rel=1e-8)


def test_equal_balls_exchange_their_velocities():
    run = hc.simulate(ball().struck_by(velocity=0.1))
    assert run.velocities[-1] == pytest.approx([0.0, 0.1], abs=1e-14)


def test_a_struck_ball_with_restitution():
    chain = ball(loss=hc.Restitution(0.9)).struck_by(velocity=0.1)
    velocities = hc.simulate(chain, until=1e-3).velocities[-1]
    assert velocities == pytest.approx([0.005, 0.095], rel=2e-3)


def test_a_struck_ball_at_a_wall_and_by_materials():
    by_pairs = {("steel-52100", "steel-52100"): hc.Restitution(0.95)}
    chain = ball(right_wall=hc.Wall(), loss=by_pairs).struck_by(velocity=0.1)
    assert hc.simulate(chain).wall_force().peak > 0.0
    assert isinstance(chain.contact_losses[1], hc.Restitution)


@pytest.mark.parametrize(
    "call",
    [hc.simulate, hc.propagate, hc.bca, hc.local_rate, hc.hard_sphere, hc.spectrum,
     lambda chain: hc.gradient(chain, "velocity@1", to=["radii"]),
     lambda chain: hc.distribution(chain, "velocity@1", hc.Scatter(radius=0.01, samples=2)),
     lambda chain: hc.Design(chain, minimise="velocity@1", vary=[hc.vary.radii(1e-3, 9e-3)])],
)  # fmt: skip
def test_a_single_ball_alone_has_no_pulse(call):
    with pytest.raises(hc.InputError, match="at least .* beads, got .*1 steel-52100 bead.*struck"):
        call(ball())


def test_one_ball_and_a_wall_need_another_ball():
    with pytest.raises(hc.InputError, match="only to bead 2, which hits the wall"):
        hc.simulate(ball(right_wall=hc.Wall()))


def hertz_wall(chain, energy):
    """Overlap and force of ball 2 on a flat wall of the same material that stops this energy.

    From L. D. Landau, E. M. Lifshitz, Theory of Elasticity, section 9.
    """
    modulus = STEEL.young / (1.0 - STEEL.poisson**2) / 2.0
    k = 4.0 / 3.0 * modulus * math.sqrt(chain.radii[1])
    overlap = (2.5 * energy / k) ** 0.4
    return overlap, k * overlap**1.5


def test_a_ball_on_a_wall_is_a_collision_of_hertz():
    """Peak force and time in contact, 2.943 overlap / v."""
    chain = hc.Chain.from_materials(
        6e-3, "steel-52100", beads=2, velocities=[0.0, 0.1], gaps="1 mm", right_wall=hc.Wall()
    )
    run = hc.simulate(chain, until="300 us", times=2)
    overlap, force = hertz_wall(chain, 0.5 * chain.masses[1] * 0.1**2)
    assert run.wall_force().peak == pytest.approx(force, rel=1e-12)
    duration = 2.943275 * overlap / 0.1
    # The first contact ends with the step in which it opens.
    assert run.wall_force().first_contact_end == pytest.approx(duration, rel=1e-4)
    np.testing.assert_allclose(run.velocities[-1], [0.0, -0.1], atol=1e-14)


def test_a_ball_that_falls_on_a_wall():
    """The energy of the fall and the work of the weight during the contact, to first order."""
    height, g = 2e-3, 9.81
    chain = hc.Chain.from_materials(
        6e-3, "steel-52100", beads=2, velocities=0.0, gaps="20 mm", gravity=g,
        right_wall=hc.Wall(gap=height),
    )  # fmt: skip
    run = hc.simulate(chain, until="30 ms", times=2)
    overlap, _ = hertz_wall(chain, chain.masses[1] * g * height)
    _, force = hertz_wall(chain, chain.masses[1] * g * (height + overlap))
    wall = run._wall_force("right")
    assert wall.largest_so_far == pytest.approx(force, rel=1e-6)
    fall, speed = math.sqrt(2.0 * height / g), math.sqrt(2.0 * g * height)
    assert wall.first_contact_end == pytest.approx(fall + 2.943 * overlap / speed, rel=1e-5)


def test_a_struck_ball_has_no_bca():
    with pytest.raises(hc.InputError, match="the BCA does not support strikers"):
        hc.bca(ball().struck_by())
    with pytest.raises(
        hc.InputError, match="requires at least 3 beads, strikers included, got .*; use propagate"
    ):
        hc.local_rate(ball().struck_by())


def test_files_of_a_single_ball(tmp_path):
    file = tmp_path / "ball.toml"
    file.write_text(
        '[chain]\ndiameters = ["12 mm"]\nmaterials = "steel-52100"\n'
        '[chain.struck_by]\nvelocity = "0.1 m/s"\n'
    )
    assert hc.load_chain(file) == ball().struck_by(velocity=0.1)
    for chain in (ball(), ball().struck_by(velocity=0.1), hc.Chain.uniform(1)):
        file.write_text(hc.chain_as_toml(chain))
        assert hc.load_chain(file) == chain
    table = tmp_path / "ball.csv"
    table.write_text("radius [mm],material\n6,steel-52100\n")
    assert hc.load_chain(table).beads == 1


def test_pieces_of_one_ball():
    chain = hc.Chain.uniform(3)
    assert chain[:1].beads == 1
    assert chain[:1] + chain[1:] == chain
    assert chain[:1] + chain[1:2] + chain[2:] == chain
    assert hc.Chain.from_radii([2.0]).reversed().radii == 1.0
    with pytest.raises(hc.InputError, match="at least one bead, without a step"):
        chain[1:1]


def test_a_single_ball_at_rest_and_its_representations():
    held = ball(gravity=9.81, right_wall=hc.Wall())
    weight = 9.81 * held.masses[0]
    assert hc.equilibrium(held).forces == pytest.approx([0.0, weight])
    assert hc.hertz_range(held).speed_ratio == 0.0
    assert "1 steel-52100 bead" in held._repr_html_()
    assert repr(ball().struck_by(velocity=0.1)) == (
        "Chain(1 steel-52100 bead, diameter 12 mm, and 1 striker, impact at 0.1 m/s)"
    )


@pytest.mark.filterwarnings("ignore::hertzchain.errors.IncompleteWarning")
@pytest.mark.parametrize(
    "chains",
    [np.ones((2, 1)), [[1.0], [1.0]], [hc.Chain.uniform(1)], [ball()], [[1.0], [1.0, 1.0]]],
    ids=["array", "lists", "scaled", "of a material", "different lengths"],
)
def test_single_balls_among_many_chains_have_a_reason(chains):
    found = hc.propagate_many(chains)
    assert "propagate_many requires at least 2 beads, got " in found.reasons[0]
    assert np.isnan(found.velocity[0]).all()
    assert (1 in found.reasons) == (len(chains) > 1 and len(chains[1]) == 1)


def test_a_sweep_over_the_number_of_beads_begins_with_a_struck_ball():
    axes, method = {"beads": [1, 4]}, {"methods": ["propagate"]}
    with pytest.warns(hc.IncompleteWarning, match="at beads = 1, .* requires at least 2 beads"):
        found = hc.sweep({"chain": {"taper": "uniform"}, "axes": axes, "sweep": method})
    assert found.status.values.ravel().tolist() == [2, 1]
    struck = {"taper": "uniform", "struck_by": {"mass": 2.0, "radius": 1.0}}
    found = hc.sweep({"chain": struck, "axes": axes, "sweep": method})
    assert found.status.values.ravel().tolist() == [1, 1]
    assert found.velocity.sel(beads=1)[0, 1] == pytest.approx(4.0 / 3.0, rel=1e-9)
