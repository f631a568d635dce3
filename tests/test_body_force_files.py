"""The force on a free body behind the row, and its acceleration, in files of forces."""

import csv

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.app.exports import export

BOX = {
    "diameters": "12 mm", "beads": 8, "materials": "steel-52100", "cap": {"mass": "60 g"},
    "struck_by": [{"mass": "20 g", "velocity": "0.1 m/s"}],
}  # fmt: skip
BODY = ["body [N]", "body acceleration [m/s^2]"]


@pytest.fixture
def box(tmp_path):
    row = hc.Chain.from_materials(diameters="12 mm", materials="steel-52100", beads=8)
    chain = row.with_cap("60 g").struck_by(mass="20 g", velocity="0.1 m/s")
    (tmp_path / "box.toml").write_text(hc.chain_as_toml(chain))
    return chain


def columns(path):
    header, *rows = csv.reader(path.read_text().splitlines())
    return dict(zip(header, np.array(rows, float).T, strict=True))


def test_the_command_saves_the_force_on_the_body_and_its_acceleration(run, box, tmp_path):
    path = tmp_path / "forces.csv"
    code, _, err = run("simulate", tmp_path / "box.toml", "--until", "1ms", "--forces", path)
    assert code == 0, err
    found = columns(path)
    assert [*found] == ["time [us]", *BODY]
    force, acceleration = (found[name] for name in BODY)
    np.testing.assert_allclose(acceleration, force / 60e-3, atol=1e-6 * acceleration.max())
    # The impulse is the momentum of the body.
    velocity = hc.simulate(box, until="1 ms").velocities[-1, -1]
    impulse = np.trapezoid(force, 1e-6 * found["time [us]"])
    assert impulse == pytest.approx(60e-3 * velocity, rel=1e-4)


def test_a_sensor_in_the_cap_is_named_cap_and_has_half_of_the_force(run, box, tmp_path):
    path = tmp_path / "forces.csv"
    names = ("--sensor", "cap", "--sensor", "ball 8")
    code, _, err = run("simulate", tmp_path / "box.toml", *names, "--forces", path)
    assert code == 0, err
    found = columns(path)
    assert [*found] == ["time [us]", "cap [N]", "ball 8 [N]", *BODY]
    np.testing.assert_allclose(2.0 * found["cap [N]"], found["body [N]"], atol=1e-3)
    traces = hc.load_traces(path, sensors=["cap", "ball 8"])
    assert traces.names == ("cap", "ball 8")
    simulated = hc.simulate(box, times=4001)
    assert max(simulated.compare(traces).differences.values()) < 1e-2


def test_a_trace_of_a_cap_requires_a_cap(box, tmp_path):
    run = hc.simulate(box, times=4001)
    run.save_forces(tmp_path / "forces.csv", ["cap"])
    traces = hc.load_traces(tmp_path / "forces.csv")
    plain = hc.Chain.from_materials("12 mm", "steel-52100", beads=8, velocity="0.1 m/s")
    with pytest.raises(hc.InputError, match="sensor 'cap', but the chain has no cap"):
        hc.simulate(plain).compare(traces)


def test_the_body_is_saved_by_default_and_without_the_static_force(box, tmp_path):
    run = hc.simulate(box.replace(precompression=20.0, held_by="force"), until="0.5 ms", times=800)
    run.save_forces(tmp_path / "forces.csv")
    force = columns(tmp_path / "forces.csv")["body [N]"]
    assert force[0] == pytest.approx(0.0, abs=1e-6)
    assert force.max() == pytest.approx(run.force(box.beads - 1).max() - 20.0, rel=1e-6)
    scaled = hc.simulate(hc.Chain.uniform(5), times=50)
    scaled.save_forces(tmp_path / "scaled.csv", ["body"])
    assert [*columns(tmp_path / "scaled.csv")] == ["time", "body", "body acceleration"]


def test_a_wall_is_not_a_free_body(box, tmp_path):
    run = hc.simulate(box.replace(right_wall=hc.Wall("5 kN/mm", exponent=1)), times=50)
    with pytest.raises(hc.InputError, match="the chain has a right wall; use 'wall'"):
        run.save_forces(tmp_path / "forces.csv", ["body"])
    assert not (tmp_path / "forces.csv").exists()


def test_the_app_exports_the_force_on_the_body(tmp_path):
    found = export({"kind": "forces", "document": {"chain": BOX}}, lambda: False)
    (tmp_path / "forces.csv").write_bytes(found.content)
    table = columns(tmp_path / "forces.csv")
    assert [*table] == ["time [us]", *BODY]
    chain = hc.Chain.from_materials(diameters="12 mm", materials="steel-52100", beads=8)
    chain = chain.with_cap("60 g").struck_by(mass="20 g", velocity="0.1 m/s")
    largest = hc.simulate(chain, times=20001).force(9).max()
    assert table["body [N]"].max() == pytest.approx(largest, rel=3e-3)
