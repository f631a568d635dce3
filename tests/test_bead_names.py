"""Names of balls, which do not count the strikers, are accepted where a bead is."""

import json

import numpy as np
import pytest

import hertzchain as hc

ROW = hc.Chain.from_materials("10 mm", "steel-52100", beads=6).struck_by(velocity="0.2 m/s")
CHAIN = ROW.replace(right_wall=hc.Wall())


def test_sensors_of_many_chains_have_names():
    keep = ["sensor_first_maximum", "sensor_largest_so_far"]
    named = hc.simulate_many([CHAIN, CHAIN], keep=keep, sensors=["ball 4", "bead 3"])
    assert named.sensors == (5, 3)
    numbered = hc.simulate_many([CHAIN], keep=keep, sensors=[5, 3])
    for name in keep:
        np.testing.assert_array_equal(named[name][0], numbered[name][0])
    longer = hc.Chain.from_materials("10 mm", "steel-52100", beads=9).struck_by(velocity=0.2)
    table = hc.simulate_many([CHAIN, longer], keep=keep, sensors=["ball 9"])
    assert table.sensors == (10,)
    assert [*table.reasons] == [0]


@pytest.mark.parametrize(
    ("chains", "sensor", "words"),
    [
        ([CHAIN], "ball 7", "6 balls after its strikers, no ball 7"),
        ([CHAIN], "marble 2", "or a name such as 'ball 11'"),
        ([CHAIN], "0", "or a name such as 'ball 11'"),
        ([CHAIN, hc.Chain.from_materials("10 mm", "steel-52100", beads=6, velocity=0.2)],
         "ball 4", "different numbers of strikers"),
    ],
)  # fmt: skip
def test_wrong_names_of_sensors_are_explained(chains, sensor, words):
    with pytest.raises(hc.InputError, match=words):
        hc.simulate_many(chains, keep=["sensor_first_maximum"], sensors=[sensor])


def test_gradients_accept_names():
    numbered = hc.gradient(CHAIN, "velocity@5")
    for found in (hc.gradient(CHAIN, "velocity@ball 4"),
                  hc.gradient(CHAIN, "velocity", bead="ball 4")):  # fmt: skip
        assert found.quantity == numbered.quantity
        np.testing.assert_array_equal(found["radii"], numbered["radii"])


@pytest.mark.parametrize("command", ["scatter", "sensitivity"])
def test_quantities_of_commands_have_names(command, run, tmp_path):
    (tmp_path / "row.toml").write_text(hc.chain_as_toml(CHAIN))
    more = ("--relative", "1%", "--chains", "4") if command == "scatter" else ()
    texts = []
    for quantity in ("peak_force@ball 4", "peak_force@5"):
        code, out, err = run(command, tmp_path / "row.toml", "--quantity", quantity, *more,
                             "--json")  # fmt: skip
        assert code == 0, err
        texts.append(json.loads(out))
    assert texts[0] == texts[1]
    code, _, err = run(command, tmp_path / "row.toml", "--quantity", "velocity@ball 9", *more)
    assert code == 2
    assert "6 balls after its strikers, no ball 9" in err
