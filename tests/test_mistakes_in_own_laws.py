"""Mistakes in laws of loss of a script are reported when a chain is made, in one sentence."""

from dataclasses import dataclass

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.chain.laws.base import LAWS, Loss, parameter
from hertzchain.kernels.law_kinds import DAMPED, LawRow

NAME = "law-of-test-of-mistakes"


@pytest.fixture
def law_with():
    """Make a law with a damping of one unit and the given methods."""

    def make(unit="force/velocity", **methods):
        @dataclass(frozen=True)
        class Law(Loss, name=NAME):
            g: float = parameter("g", "damping", least=0.0, unit=unit)

            def row(self, exponent):  # noqa: ARG002
                return LawRow(DAMPED, overlap_power=0.25)

        for name, method in methods.items():
            setattr(Law, name, method)
        return Law

    yield make
    LAWS.pop(NAME, None)


def full(self, contacts):
    return np.full(len(contacts.stiffness), self.g)


@pytest.mark.parametrize(
    ("methods", "said"),
    [
        ({}, "has no method strength, so that nothing would be lost; define strength"),
        ({"strength": lambda self, _: [self.g]}, r"shape \(10,\), got shape \(1,\)"),
        ({"strength": lambda self, _: self.g}, r"one number per contact, .* got shape \(\)"),
        (
            {"strength": full, "row": lambda *_: LawRow(DAMPED, overlap_power=-1.0)},
            "overlap_power of the law .* must be >= 0, got -1",
        ),
        (
            {"strength": full, "row": lambda *_: LawRow(DAMPED, speed_power=0.0)},
            "speed_power of the law .* must be > 0, got 0",
        ),
        ({"strength": full, "row": lambda *_: DAMPED}, "must return a LawRow, got 1"),
    ],
)
def test_a_mistake_is_one_sentence(law_with, methods, said):
    law = law_with(**methods)(0.1)
    with pytest.raises(hc.InputError, match=said):
        hc.Chain.uniform(9).replace(loss=law)


@pytest.mark.parametrize("unit", ["nonsense", "force/velocity^", "length^(1/0)", "length^1/4"])
def test_a_unit_is_checked_where_it_is_given(law_with, unit):
    with pytest.raises(hc.InputError, match="a scale is a product of powers"):
        law_with(unit=unit)


def test_a_power_may_be_a_fraction(law_with):
    balls = hc.Chain.from_materials("5 mm", "steel-52100", beads=12, velocity="0.1 m/s")
    found = []
    for power in ("0.25", "(1/4)"):
        law = law_with(unit=f"force/velocity/length^{power}", strength=full)
        scales = hc.Scales.of(balls)
        scaled = hc.Chain.uniform(12).replace(loss=law(0.05))
        found.append(hc.simulate(scaled).pulse().velocity[9])
        real = scales.to_si(scaled)
        velocity = hc.simulate(real).pulse().velocity[9]
        assert velocity / scales.velocity == pytest.approx(found[-1], rel=1e-6)
        assert scales.unit(f"1/length^{power}") == pytest.approx(scales.length**-0.25, rel=1e-15)
    assert found[0] == found[1] < 0.68


def test_a_law_without_a_row_is_named(law_with):
    law = law_with(strength=full, row=Loss.row)(0.1)
    with pytest.raises(hc.InputError, match="the law Law needs a method row"):
        hc.simulate(hc.Chain.uniform(4).replace(loss=law), until=1.0)
