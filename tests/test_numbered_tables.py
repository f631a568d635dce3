"""Tables of the paper by number, and numbers of waves in words."""

import pytest

import hertzchain as hc
from hertzchain.paper import reproduce_table


def test_a_table_can_be_given_by_its_number():
    assert reproduce_table(3).agreeing == reproduce_table("table3").agreeing == 20
    with pytest.raises(hc.InputError, match="table of the paper"):
        reproduce_table(7)


def test_waves_are_counted_in_words():
    waves = hc.simulate(hc.Chain.uniform(20), until=20.0, times=400).waves()
    assert "20 beads; 1 wave to the right, 0 to the left" in " ".join(str(waves).split())
