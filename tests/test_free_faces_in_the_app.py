"""In the app, a sensor with a free face has the same remark as on the command line."""

import pytest
from app_client import computed

from hertzchain.simulation.sensor_force import FREE_FACE


@pytest.mark.parametrize(("wall", "half"), [({}, ["bead 1", "bead 6"]), (None, ["bead 1"])])
def test_sensors_in_beads_at_free_ends_have_the_remark(wall, half):
    chain = {"taper": "uniform", "beads": 6} | ({} if wall == {} else {"right_wall": {}})
    header, _ = computed({"chain": chain}, sensors=[1, 3, 6])["run"]
    peaks = header["peaks"].values()
    found = [each["label"] for each in peaks if each.get("remark") == FREE_FACE]
    assert found == [f"sensor in {each}" for each in half]
