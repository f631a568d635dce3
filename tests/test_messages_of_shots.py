"""Messages on numbers of shots and beads."""

import numpy as np
import pytest
from click import UsageError

import hertzchain as hc
from hertzchain.cli.chain_options import _materials


def row():
    return hc.Chain.from_materials("5 mm", "brass", beads=12).struck_by(velocity="0.1 m/s")


def test_a_parameter_of_a_shot_that_does_not_exist():
    with pytest.raises(hc.InputError) as caught:
        hc.forecast(row(), ["ball 5"], noise=0.02, interval="1 us", free=["struck_by.velocity@2"])
    assert str(caught.value) == (
        "struck_by.velocity@2 belongs to shot 2, but there is only one shot: remove '@2', or give "
        "the data of this shot"
    )


def test_one_of_something_is_singular():
    traces = hc.Traces.from_arrays(np.arange(3.0), {"ball 3 [N]": [0.0, 1.0, 0.0]}, noise=0.1)
    with pytest.raises(hc.InputError, match="there is 1 shot, but 2 chains; give one for each"):
        hc.fit(traces, [row(), row()], free=["stiffness"])
    with pytest.raises(hc.InputError, match="but there is 1 diameter: omit beads"):
        hc.Chain.from_materials(diameters=["5 mm"], materials="brass", beads=2)
    with pytest.raises(UsageError, match="there is only 1 bead: omit some"):
        _materials("brass,glass", 1)
