"""Constraints of designs: their bounds, and values that are unknown."""

import pytest

import hertzchain as hc
from hertzchain.designs.bounds import bounds_of, impossible


@pytest.mark.parametrize("quantity", ["energy", "energy_share"])
def test_a_ratio_of_energies_has_no_bound(quantity):
    """The bound of an energy is not that of its ratio to a smaller one."""
    ratio = f"{quantity}@8/{quantity}@4"
    problem = hc.Design(
        hc.Chain.uniform(10), maximise="velocity@last", vary=[hc.vary.radii(0.5, 1.5)],
        subject_to={ratio: ">= 1.5", f"{quantity}@4": ">= 0.05"},
    )  # fmt: skip
    assert impossible(problem) is None
    assert [str(bound.measure) for bound in bounds_of(problem)] == [f"{quantity}@4"]
    # A light bead passes most of its energy on before its velocity is largest.
    chain = hc.Chain([1.0, 1.0, 1.0, 0.6, *[1.0] * 6])
    assert problem.evaluate(chain).values[ratio] > 1.5
