"""Chains at rest: forces balance on every bead, from walls, weights and held ends."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hertzchain as hc
from hertzchain import Chain, Wall


def contact_forces(chain, state):
    """Forces from the overlaps of the state, independently of how it was found."""
    x = np.concatenate(([0.0], state.positions, [0.0]))
    return chain.contact_stiffness * np.maximum(x[:-1] - x[1:] - state.gaps, 0.0) ** chain.exponent


def net_forces(chain, state):
    contact = contact_forces(chain, state)
    return contact[:-1] - contact[1:] + state.body_forces


RADII = st.lists(st.floats(0.3, 3.0), min_size=2, max_size=8)


@given(
    RADII,
    st.floats(0.01, 10.0),
    st.floats(-1.0, 1.0),
    st.sampled_from([(True, True), (True, False), (False, True), (False, False)]),
    st.floats(1.2, 4.0),
)
def test_precompressed_beads_are_at_rest(radii, force, gravity, walls, exponent):
    left, right = (Wall(stiffness=1.7) if wall else None for wall in walls)
    chain = Chain.from_radii(radii, exponent=exponent).replace(
        precompression=force, gravity=gravity, left_wall=left, right_wall=right,
        held_by="walls" if all(walls) else "force",
    )  # fmt: skip
    state = hc.equilibrium(chain)
    largest = state.forces.max()
    # Overlaps are differences of positions, and forces powers of them.
    np.testing.assert_allclose(net_forces(chain, state), 0.0, atol=1e-10 * largest)
    assert state.forces[1:-1].min() >= force * (1 - 1e-12)
    assert min(state.forces) == pytest.approx(force, rel=1e-12)


@pytest.mark.parametrize(("gravity", "side"), [(0.2, "right_wall"), (-0.2, "left_wall")])
def test_a_chain_stands_on_its_wall(gravity, side):
    chain = Chain.from_radii([1.0, 0.7, 1.3]).replace(gravity=gravity, **{side: Wall()})
    state = hc.equilibrium(chain)
    np.testing.assert_allclose(net_forces(chain, state), 0.0, atol=1e-14)
    at_wall = contact_forces(chain, state)[-1 if side == "right_wall" else 0]
    assert at_wall == pytest.approx(0.2 * chain.masses.sum(), rel=1e-13)


def test_walls_keep_their_gap_from_the_settled_chain():
    chain = Chain.uniform(3).replace(
        gravity=0.2, right_wall=Wall(), left_wall=Wall(gap=0.1)
    )  # fmt: skip
    state = hc.equilibrium(chain)
    assert 0.0 - state.positions[0] - state.gaps[0] == pytest.approx(-0.1, rel=1e-12)


@pytest.mark.parametrize(
    "fields",
    [
        {"gravity": 0.2},
        {"gravity": -0.2, "right_wall": Wall()},
        {"gravity": 0.2, "right_wall": Wall(gap=0.1)},
        {"gravity": 0.2, "right_wall": Wall(), "gaps": [0.0, 0.1]},
        {"left_wall": Wall(), "right_wall": Wall()},
    ],
)
def test_what_nothing_holds_is_where_it_was_put(fields):
    chain = Chain.uniform(3).replace(**fields)
    state = hc.equilibrium(chain)
    assert not state.positions.any()
    assert not state.forces.any()
    np.testing.assert_array_equal(state.body_forces, chain.gravity * chain.masses)
    np.testing.assert_array_equal(state.gaps[1:-1], chain.gaps)


def test_strikers_just_meet_the_compressed_chain():
    chain = Chain(
        np.ones(4), strikers=1, gaps=[0.3, 0, 0], precompression=1.0, held_by="force",
        right_wall=Wall(stiffness=1.0),
    )  # fmt: skip
    state = hc.equilibrium(chain)
    np.testing.assert_allclose(contact_forces(chain, state), [0, 0, 1, 1, 1], atol=1e-14)
    np.testing.assert_allclose(net_forces(chain, state), 0.0, atol=1e-14)
    assert state.positions[0] - state.positions[1] - state.gaps[1] == pytest.approx(-0.3)


@pytest.mark.filterwarnings("ignore:the gravity is 1e.09 m/s:hertzchain.errors.InputWarning")
def test_beads_are_not_pressed_through_each_other():
    balls = Chain.from_materials(5e-3, "brass", beads=5)
    with pytest.raises(hc.InputError, match=r"contact 1, .* 0\.005 m; .* at most 1\.35e\+06 N"):
        balls.replace(precompression=1e30, held_by="force")
    held = balls.replace(precompression=1.35e6, held_by="force")
    # Just below a radius, by Hertz' law: F = k d^(3/2).
    assert 0.99 < (1.35e6 / held.stiffness[0]) ** (2.0 / 3.0) / 5e-3 < 1.0
    with pytest.raises(hc.InputError, match=r"^gravity exerts .* on contact 4, .* reduce gravity"):
        balls.replace(gravity=1e9, right_wall=Wall())


def test_the_motion_beside_a_scaled_precompression_is_seen():
    with pytest.raises(
        hc.InputError, match=r"1e\+06 times that of an impact; .* at most 9.95e\+08"
    ):
        Chain.uniform(5).replace(precompression=1e30, held_by="force")
    force = 9.95e8
    chain = Chain.uniform(5).replace(precompression=force, held_by="force")
    # So stiff a chain is linear: its normal modes, of springs p k^(1/p) F^(1 - 1/p).
    spring = 1.5 * force ** (1.0 / 3.0)
    row = np.diff(np.eye(5), axis=0)
    squares, shapes = np.linalg.eigh(spring * row.T @ row)
    time = 6.0 / np.sqrt(spring)
    start = shapes[0]
    exact = shapes @ (np.cos(np.sqrt(np.abs(squares)) * time) * start)
    run = hc.simulate(chain, times=[time])
    np.testing.assert_allclose(run.velocities[0], exact, atol=1e-6)  # measured: 1.3e-7
