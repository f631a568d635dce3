"""Comparisons with an effective chain, and the speed of sound of a host, in words and numbers."""

import click
import numpy as np
import pytest

import hertzchain as hc
from hertzchain.cli.wording import on_command_line


def test_the_first_arrival_of_an_effective_chain_has_a_reason():
    chain = hc.Chain.dimer(0.1, beads=81)
    compared = hc.effective_chain(chain).bca().pulse().compare(hc.propagate(chain))
    assert compared.worst_bead("arrival") == 3
    errors = np.abs(compared.errors("arrival")[10:])
    said = f"from bead 11 on, the largest error is {100.0 * np.nanmax(errors):.2f}%"
    assert said in str(compared)
    same = hc.bca(hc.Chain.uniform(40))
    assert "from bead 11 on" not in str(same.compare(same))


@pytest.mark.parametrize("masses", [[1.0], [1.0, 0.4]])
def test_the_host_has_the_sound_speed_of_the_chain_without_odd_beads(masses):
    periodic = hc.Chain.uniform(40).replace(
        masses=np.resize(masses, 40), precompression=0.1, held_by="force"
    )
    exact = hc.spectrum(periodic).sound_speed
    assert hc.spectrum(periodic).host_sound_speed == pytest.approx(exact, rel=1e-14)
    light = hc.Chain.uniform(40).with_defects({20: 0.5})
    odd = light.replace(
        masses=np.where(np.arange(40) == 19, 0.1, np.resize(masses, 40)),
        precompression=0.1, held_by="force",
    )  # fmt: skip
    found = hc.spectrum(odd)
    assert found.host_sound_speed == pytest.approx(exact, rel=1e-14)
    with pytest.raises(hc.InputError, match="use host_edges and host_sound_speed"):
        _ = found.sound_speed


def test_the_number_of_saved_times_is_an_option():
    with click.Context(click.Command("simulate")) as context:
        context.params = {"times": 200}
        assert on_command_line("required; times=47 is enough") == "required; --times 47 is enough"
        said = on_command_line("it passes; give simulate more times")
    assert said == "it passes; give more --times"
