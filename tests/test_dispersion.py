import numpy as np
import pytest
from scipy.linalg import eigh

import hertzchain as hc
from hertzchain.theory.dispersion import (
    band_edges,
    dispersion_diatomic,
    dispersion_uniform,
    linear_stiffness,
    modes,
    spring_modes,
)


def stiffness_matrix(springs, ends=(0.0, 0.0)):
    """Row sums of a chain of springs, written down one spring at a time."""
    n = len(springs) + 1
    matrix = np.zeros((n, n))
    for k, spring in enumerate(springs):
        matrix[k : k + 2, k : k + 2] += spring * np.array([[1.0, -1.0], [-1.0, 1.0]])
    matrix[0, 0] += ends[0]
    matrix[-1, -1] += ends[1]
    return matrix


def test_linear_stiffness_is_the_slope_of_the_force():
    k, p, force = 2.3, 1.5, 0.7
    overlap, step = (force / k) ** (1 / p), 1e-5
    slope = (k * (overlap + step) ** p - k * (overlap - step) ** p) / (2 * step)
    assert linear_stiffness(k, force, p) == pytest.approx(slope, rel=1e-9)


def test_diatomic_chain_of_equal_masses_is_the_uniform_one_folded():
    q = np.linspace(0.0, np.pi, 40)
    acoustic, optical = dispersion_diatomic(q, mass=1.7, other_mass=1.7, spring=0.6)
    values = {"mass": 1.7, "spring": 0.6}
    np.testing.assert_allclose(acoustic, dispersion_uniform(q / 2, **values), atol=1e-14)
    np.testing.assert_allclose(optical, dispersion_uniform(np.pi - q / 2, **values), rtol=1e-14)


def test_band_edges_are_the_ends_of_the_branches():
    for mass, other in ((1.0, 0.2), (0.2, 1.0)):
        values = {"mass": mass, "other_mass": other, "spring": 3.0}
        acoustic, optical = dispersion_diatomic([0.0, np.pi], **values)
        ends = [acoustic[0], acoustic[1], optical[1], optical[0]]
        np.testing.assert_allclose(band_edges(**values), ends, rtol=1e-15)
    heavy, light = np.sqrt(6.0), np.sqrt(6.0 / 0.2)
    np.testing.assert_allclose(ends[1:], [heavy, light, np.sqrt(36.0)], rtol=1e-14)


@pytest.mark.parametrize("exponent", [1.5, 3.0])
def test_modes_of_uniform_chains_lie_on_the_dispersion_relation(exponent):
    n, force = 31, 0.4
    chain = hc.Chain.uniform(n, exponent=exponent)
    spring = float(linear_stiffness(1.0, force, exponent))
    free, _ = modes(chain, force)
    np.testing.assert_allclose(
        free, dispersion_uniform(np.pi * np.arange(n) / n, spring=spring), rtol=1e-12, atol=1e-14
    )
    fixed, shapes = modes(chain, force, ends=("fixed", "fixed"))
    q = np.pi * np.arange(1, n + 1) / (n + 1)
    np.testing.assert_allclose(fixed, dispersion_uniform(q, spring=spring), rtol=1e-12)
    third = np.sin(3 * np.pi * np.arange(1, n + 1) / (n + 1)) * np.sqrt(2 / (n + 1))
    np.testing.assert_allclose(np.abs(shapes[:, 2]), np.abs(third), atol=1e-12)
    mixed, _ = modes(chain, force, ends=("fixed", "free"))
    q = np.pi * (np.arange(n) + 0.5) / (n + 0.5)
    np.testing.assert_allclose(mixed, dispersion_uniform(q, spring=spring), rtol=1e-12)
    turned, _ = modes(chain, force, ends=("free", "fixed"))
    np.testing.assert_allclose(turned, mixed, rtol=1e-12)


def test_modes_between_walls_lie_on_the_diatomic_branches():
    n, heavy, light, spring = 21, 1.0, 0.3, 2.0
    masses = np.where(np.arange(n) % 2, light, heavy)
    found, _ = spring_modes(masses, np.full(n - 1, spring), (spring, spring))
    q = 2 * np.pi * np.arange(1, (n + 1) // 2) / (n + 1)
    branches = dispersion_diatomic(q, mass=heavy, other_mass=light, spring=spring)
    lone = band_edges(mass=heavy, other_mass=light, spring=spring)[1]
    np.testing.assert_allclose(found, np.sort([*np.concatenate(branches), lone]), rtol=1e-12)


def test_modes_of_tapered_chains_by_the_generalized_eigenproblem():
    chain = hc.Chain.tapered("forward-exponential", 0.1, beads=25)
    frequencies, shapes = modes(chain, 0.3, ends=("fixed", "free"))
    springs = linear_stiffness(chain.stiffness, 0.3)
    matrix = stiffness_matrix(springs, (float(linear_stiffness(1.0, 0.3)), 0.0))
    squares, vectors = eigh(matrix, np.diag(chain.masses))
    np.testing.assert_allclose(frequencies, np.sqrt(squares), rtol=1e-11)
    np.testing.assert_allclose(np.abs(shapes), np.abs(vectors), atol=1e-9 * np.abs(vectors).max())
    np.testing.assert_allclose(
        matrix @ shapes, chain.masses[:, None] * shapes * frequencies**2, atol=1e-11
    )
    np.testing.assert_allclose(shapes.T @ (chain.masses[:, None] * shapes), np.eye(25), atol=1e-12)


def test_wall_at_the_small_end_is_a_bead_like_the_last():
    chain = hc.Chain.from_radii([1.0, 0.5])
    frequencies, _ = modes(chain, 1.0, ends=("free", "fixed"))
    matrix = stiffness_matrix(linear_stiffness(chain.stiffness, 1.0), (0.0, 1.5 * 0.5 ** (1 / 3)))
    squares = eigh(matrix, np.diag(chain.masses), eigvals_only=True)
    np.testing.assert_allclose(frequencies, np.sqrt(squares), rtol=1e-12)


def test_given_stiffness_counts_at_fixed_ends():
    # 8 times as stiff: by k^(1/p), all frequencies double.
    chain, ends = hc.Chain.uniform(4), ("fixed", "fixed")
    plain, _ = modes(chain, 1.0, ends=ends)
    stiff, _ = modes(chain.replace(stiffness=8.0), 1.0, ends=ends)
    np.testing.assert_allclose(stiff, 2.0 * plain, rtol=1e-13)
    unlike = chain.replace(stiffness=[8.0, 1.0, 27.0])
    found, _ = modes(unlike, 1.0, ends=ends)
    matrix = stiffness_matrix(1.5 * np.array([4.0, 1.0, 9.0]), (6.0, 13.5))
    np.testing.assert_allclose(found, np.sqrt(eigh(matrix, eigvals_only=True)), rtol=1e-12)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (
            lambda: modes(hc.Chain.uniform(3).replace(precompression=1.0, held_by="force"), 1.0),
            "does not support precompression.*use hertzchain.spectrum",
        ),
        (lambda: modes(hc.Chain.uniform(3), 0.0), "force must be above 0, got 0"),
        (lambda: modes(hc.Chain.uniform(3), 1.0, ends=("free", "wall")), "unknown end 'wall'"),
        (
            lambda: linear_stiffness([1.0, -2.0], 1.0),
            "stiffness must be finite and above 0, got -2",
        ),
        (lambda: dispersion_diatomic(0.1, other_mass=0.0), "other_mass must be above 0"),
        (lambda: spring_modes([1.0, 1.0], [1.0, 1.0]), "2 masses .* 1 springs .* got 2"),
        (lambda: spring_modes([1.0, 1.0], [1.0], (-1.0, 0.0)), "end .* got -1"),
    ],
)
def test_bad_input_is_rejected(call, said):
    with pytest.raises(hc.InputError, match=said):
        call()
