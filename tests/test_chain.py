import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hertzchain import Chain, InputError
from hertzchain.chain.tapers import TAPERS


def test_an_assignment_points_to_replace():
    chain = Chain.uniform(3)
    with pytest.raises(dataclasses.FrozenInstanceError, match=r"chain.replace\(radii=...\)"):
        chain.radii = [1.0, 2.0, 3.0]
    assert chain.replace(radii=[1.0, 2.0, 3.0]).radii.tolist() == [1.0, 2.0, 3.0]


def test_tapers_follow_their_equations():
    k = np.arange(1, 11)
    expected = {
        "backward-linear": 1 + 0.05 * (k - 1),
        "backward-exponential": 0.95 ** -(k - 1.0),
        "forward-linear": 1 - 0.05 * (k - 1),
        "forward-exponential": 1.05 ** -(k - 1.0),
    }
    for taper in TAPERS:
        chain = Chain.tapered(taper, 0.05, beads=10)
        np.testing.assert_allclose(chain.radii, expected[taper], rtol=1e-15)
        np.testing.assert_array_equal(chain.masses, chain.radii**3)


def test_radii_are_kept_in_units_of_the_first():
    chain = Chain.from_radii([4.0, 2.0, 1.0])
    np.testing.assert_array_equal(chain.radii, [1.0, 0.5, 0.25])


def test_a_chain_cannot_be_changed():
    chain = Chain.uniform(3)
    with pytest.raises(ValueError, match="read-only"):
        chain.radii[0] = 2.0
    with pytest.raises(AttributeError):
        chain.rate = 0.1


def test_the_longest_forward_linear_chain_is_named_and_is_the_longest():
    with pytest.raises(InputError, match="at most 100 beads"):
        Chain.tapered("forward-linear", 0.01, beads=101)
    assert Chain.tapered("forward-linear", 0.01, beads=100).radii[-1] > 0


@given(st.floats(1e-3, 0.9))
def test_the_named_longest_forward_linear_chain_exists(rate):
    with pytest.raises(InputError) as caught:
        Chain.tapered("forward-linear", rate, beads=5000)
    longest = int(str(caught.value).split("at most ")[1].split()[0])
    assert Chain.tapered("forward-linear", rate, beads=longest).radii.min() > 0
    with pytest.raises(InputError):
        Chain.tapered("forward-linear", rate, beads=longest + 1)


@pytest.mark.parametrize(
    ("build", "said"),
    [
        (lambda: Chain.tapered("backward-exponential", 1.0, beads=5), "between 0 and 1, got 1"),
        (lambda: Chain.tapered("forward-exponential", 1.5, beads=5), "between 0 and 1, got 1.5"),
        (lambda: Chain.tapered("forward-exponential", float("nan"), beads=5), "got nan"),
        (lambda: Chain.tapered("backward-linear", -0.1, beads=5), "positive and finite, got -0.1"),
        (lambda: Chain.tapered("backward-linear", float("inf"), beads=5), "finite, got inf"),
        (
            lambda: Chain.tapered("backward-linear", "x", beads=5),
            "must be a number or a percentage such as '5%', got 'x'",
        ),
        (lambda: Chain.tapered("forward-linear", 1.5, beads=5), "below 1 even for two beads"),
        (lambda: Chain.tapered("bakward-linear", 0.1, beads=5), "did you mean 'backward-linear'"),
        (lambda: Chain.tapered("backward-exponential", 0.5, beads=2000), "bead 343 .*represented"),
        (lambda: Chain.tapered("forward-exponential", 0.5, beads=2000), "bead 584 .*represented"),
        (lambda: Chain.uniform(0), "whole number of at least 1, got 0$"),
        (lambda: Chain.tapered("backward-linear", 0.1, beads=1), "at least 2, got 1$"),
        (lambda: Chain.dimer(0.5, beads=1), "whole number of at least 2, got 1$"),
        (lambda: Chain.uniform(2.5), "whole number of at least 1, got 2.5$"),
        (lambda: Chain.uniform(30.0), "whole number of at least 1, got 30.0; write 30$"),
        (lambda: Chain.uniform(0.0), "whole number of at least 1, got 0.0$"),
        (lambda: Chain.uniform(True), "whole number of at least 1, got True"),
        (
            lambda: Chain.uniform(10**15),
            "beads need 372529029.8 GiB of memory, but .* are free; use fewer",
        ),
        (lambda: Chain.uniform(5, exponent=1.0), "above 1 and at most 50, got 1"),
        (lambda: Chain.uniform(5, exponent="hard"), "must be a number, got 'hard'"),
        (lambda: Chain.from_radii([]), r"list of numbers, one for each bead, got \[\]$"),
        (lambda: Chain.from_radii([[1.0, 2.0]]), "list of numbers, one for each bead"),
        (lambda: Chain.uniform(1, exponent=[]), "single bead has no contact and no list of exp"),
        (lambda: Chain.uniform(1, loss=[]), "single bead has no contact and no list of laws"),
        (lambda: Chain.from_radii([1.0, 0.0]), "bead 2 is 0: radii must be positive"),
        (lambda: Chain.from_radii([1.0, 2.0, -3.0]), "bead 3 is -3"),
        (lambda: Chain.from_radii([1.0, float("nan")]), "bead 2 is nan"),
        (lambda: Chain.from_radii([1.0, "big"]), "bead 2 is 'big'"),
        (lambda: Chain.from_radii("radii"), "list of numbers, got 'radii'"),
        (lambda: Chain.from_radii([1.0, 1e-200]), "bead 2 has 1e-200 times .*1e-102 to 1e102"),
        (lambda: Chain.from_radii([1.0, float("inf")]), "bead 2 is inf: radii must be positive"),
        (lambda: Chain.from_radii([True, True]), "bead 1 is True"),
        (lambda: Chain.from_radii([1.0, True]), "radius of bead 2 is True: it must be a number"),
        (lambda: Chain.from_radii(np.array([True, True])), "radius of bead 1 is True"),
        (lambda: Chain.from_radii(np.array(5.0)), "list of numbers, one for each bead, got"),
        (lambda: Chain.uniform(2).replace(masses=[1.0, False]), "mass of bead 2 is False"),
        (
            lambda: Chain.from_radii(np.array([1 + 1j, 2])),
            r"bead 1 is \(1\+1j\): it must be a number",
        ),
        (lambda: Chain.from_radii([1, 10**400]), "radius is too large: at most 1.8e308"),
        (lambda: Chain.tapered("backward-linear", True, beads=5), "must be a number, got True"),
        (lambda: Chain.tapered("backward-linear", 10**400, beads=5), "too large"),
        (lambda: Chain.tapered("uniform", 0.1, beads=5), "Chain.uniform"),
        (lambda: Chain(np.array([0.01, 0.02])), "first radius of a scaled .* be 1, or .* got 0.01"),
        (
            lambda: Chain([0.01, 2.0, 1.0], strikers=1).replace(radii=[1.0, 60.0, 1.0]),
            "first radius after the strikers .* got 60",
        ),
        (lambda: Chain(np.ones(3), taper="backward-linear"), "requires rate; give rate"),
        (
            lambda: Chain(np.ones(3), taper="backward-linear", taper_parameters=[("rate", 0.1)]),
            "are not those of a",
        ),
    ],
)
def test_bad_chains_are_rejected_in_one_sentence(build, said):
    with pytest.raises(InputError, match=said) as caught:
        build()
    assert "\n" not in str(caught.value)


def test_rounding_of_one_over_s_leaves_no_bead_of_nothing():
    # 1/(1/49) is rounded up to 49.00000000000001, and bead 50 would have a radius of 1e-16.
    with pytest.raises(InputError, match="at most 49 beads"):
        Chain.tapered("forward-linear", 1 / 49, beads=50)
    assert Chain.tapered("forward-linear", 1 / 49, beads=49).radii[-1] == pytest.approx(1 / 49)
