"""Units of printed numbers, in which impulses and momenta are the same."""

import pytest

from hertzchain.pulse.quantities import QUANTITIES
from hertzchain.representation import measure


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (5.39e-3, "5.39 mN s"), (24.99, "24.99 N s"), (0.99999, "1 N s"), (-3e-7, "-300 nN s"),
        (0.0, "0 N s"), (2e-11, "20 pN s"), (5e4, "50 kN s"), (float("nan"), "nan N s"),
    ],
)  # fmt: skip
def test_impulses_have_a_prefix(value: float, text: str) -> None:
    assert measure(value, "N s") == text


def test_lengths_below_a_millimetre_are_in_micrometres() -> None:
    assert measure(5e-6, "m") == "5 um"
    assert measure(0.133, "m") == "0.133 m"


def test_momenta_have_the_unit_of_impulses() -> None:
    units = {each.unit for name, each in QUANTITIES.items() if each.scale == "momentum"}
    assert units == {"N s"}
