"""The force on a body behind the row, its acceleration, and its peak with contacts that yield."""

import json
import re

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.simulation.body_force import body_force

pytestmark = pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")


def box(mass="100 g", beads=8, velocity="0.4 m/s", **more):
    row = hc.Chain.from_materials(diameters="10 mm", materials="steel-52100", beads=beads)
    hammer = {"mass": "50 g", "radius": "flat", "velocity": velocity}
    return row.with_cap(mass).struck_by(**hammer).replace(**more)


def written(folder, **chains):
    for name, chain in chains.items():
        (folder / f"{name}.toml").write_text(hc.chain_as_toml(chain))
    return [folder / f"{name}.toml" for name in chains]


def sampled(chain, until="2 ms"):
    """Largest force of the last contact and the time around it above a tenth, from samples."""
    run = hc.simulate(chain, until=until, times=100001)
    force = run.force(chain.beads - 1)
    below, top = np.flatnonzero(force < 0.1 * force.max()), int(force.argmax())
    duration = run.times[below[below > top][0]] - run.times[below[below < top][-1]]
    return force.max(), duration


@pytest.mark.parametrize("times", [400, 4000])
@pytest.mark.parametrize("loss", [None, hc.Restitution(0.9), hc.ElasticPlastic()])
def test_force_and_duration_are_those_of_the_last_contact(loss, times):
    chain = box(loss=loss)
    found = body_force(hc.simulate(chain, times=times))
    force, duration = sampled(chain)
    assert found.force == pytest.approx(force, rel=1e-3 if loss else 1e-6)
    assert abs(found.force - force) < found.error + 1e-6 * force
    assert found.acceleration == found.force / 0.1
    assert found.duration == pytest.approx(duration, abs=3e-7)


def test_the_static_force_of_a_precompressed_row_does_not_accelerate_the_body():
    row = hc.Chain.uniform(6).replace(precompression=0.05, held_by="force")
    run = hc.simulate(row, until=20.0, times=4001)
    net = run.force(5) - 0.05
    found = body_force(run)
    assert found.force == pytest.approx(net.max(), rel=1e-4)
    # The derivative of the velocity is the acceleration of mass 1.
    slope = np.gradient(run.velocities[:, -1], run.times)
    assert found.acceleration == pytest.approx(slope.max(), rel=1e-3)


@pytest.mark.parametrize("run_until", [1e-4, 1.6e-4])
def test_a_run_that_ends_too_early_says_so(run_until):
    found = body_force(hc.simulate(box(), until=run_until))
    if run_until == 1e-4:
        assert found is None
    else:
        assert np.isnan(found.duration)


def test_the_command_states_force_acceleration_and_duration(run, tmp_path):
    (file,) = written(tmp_path, box=box())
    force, duration = sampled(box())
    out = run("simulate", file).stdout
    assert f"largest force on it, from contact 9: {force:.5g} N at t = " in out
    g0 = force / 0.1 / 9.80665
    assert f"unfiltered): {force / 0.1:.4g} m/s^2, {g0:.4g} g0 (g0 = 9.80665 m/s^2)" in out
    assert f"above 10% of it): {1e6 * duration:.3g} us" in out
    document = json.loads(run("simulate", file, "--json").stdout)["last_bead_force"]
    assert document["force"] == pytest.approx(force, rel=1e-6)
    assert document["acceleration"] == pytest.approx(10.0 * force, rel=1e-6)
    assert document["acceleration_in_g0"] == pytest.approx(g0, rel=1e-6)
    assert document["duration"] == pytest.approx(duration, abs=1e-7)
    walled = box().replace(right_wall=hc.Wall("5 kN/mm", exponent=1))
    (file,) = written(tmp_path, walled=walled)
    assert json.loads(run("simulate", file, "--json").stdout)["last_bead_force"] is None


def test_an_elastic_run_onto_a_cap_states_the_peak_with_yield(run, tmp_path):
    (file,) = written(tmp_path, box=box())
    ends = [
        body_force(hc.simulate(box(loss=hc.ElasticPlastic(factor=each)))).force
        for each in (1.6, 2.8)
    ]
    out = run("simulate", file).stdout
    assert f"  peak with contacts that yield: {ends[0]:.5g} N (--loss elastic-plastic)\n" in out
    assert f"    {ends[0]:.0f} to {ends[1]:.0f} N for yield pressures of 1.6 to 2.8" in out
    document = json.loads(run("simulate", file, "--json", "--until", "2ms").stdout)
    assert document["peak_range_with_yielding_contacts"] == pytest.approx(ends, rel=1e-6)
    # The pulse has not arrived, or no contact yields.
    assert "contacts that yield" not in run("simulate", file, "--until", "100us").stdout
    (slow,) = written(tmp_path, slow=box(velocity="0.1 m/s"))
    assert "contacts that yield" not in run("simulate", slow).stdout
    (free,) = written(tmp_path, free=box()[:9])
    assert "contacts that yield" not in run("simulate", free).stdout


def test_a_run_with_yield_states_the_range_of_the_force_on_the_cap(run, tmp_path):
    (file,) = written(tmp_path, box=box(loss=hc.ElasticPlastic()))
    out = run("simulate", file).stdout
    assert "  force on bead 10 (cap): 303 to 338 N for yield pressures of 1.6 to 2.8" in out
    hits = run("simulate", file, "--hits", "2").stdout
    assert "largest on the cap N" in hits
    assert re.search(r"\n +1 +302\.84 ", hits)


def rows_of(out):
    lines = out[out.index(" chains: ") :].splitlines()
    return {line.split()[0]: line for line in lines[3:] if line.strip() and "\u2500" not in line}


@pytest.mark.parametrize("sensor", [(), ("--sensor", "cap")])
def test_a_table_compares_the_whole_forces_on_caps(run, tmp_path, sensor):
    chains = {"heavy": box(), "light": box("50 g"), "long": box(beads=12)}
    code, out, err = run("simulate", *written(tmp_path, **chains), *sensor)
    assert code == 0, err
    assert "3 chains: force on the last body; * marks the smallest" in out
    assert "acceleration: peak / mass of the last body, unfiltered" in out
    rows = rows_of(out)
    forces = {name: sampled(chain)[0] for name, chain in chains.items()}
    assert f"* {forces['light']:.5g} N" in rows["light"]
    assert f"{forces['long']:.5g} N" in rows["long"]
    assert f"* {10.0 * forces['heavy']:.4g} m/s^2" in rows["heavy"]
    for factor in (1.6, 2.8):
        loss = hc.ElasticPlastic(factor=factor)
        peaks = {
            name: body_force(hc.simulate(chain.replace(loss=loss))).force
            for name, chain in chains.items()
        }
        for name, peak in peaks.items():
            mark = "* " if peak == min(peaks.values()) else " "
            assert f"{mark}{peak:.5g} N" in rows[name]


def test_sensors_with_a_free_face_are_named_below_a_table(run, tmp_path):
    files = written(tmp_path, box=box(), balls=box()[:9])
    out = run("simulate", *files, "--sensor", "9").stdout
    assert "force in the first sensor" in out
    assert "\nsensor of balls: mean of the forces on both faces; the free face has none" in out
    out = run("simulate", *files, "--sensor", "5").stdout
    assert "\nsensor of" not in out[out.index(" chains: ") :]


def test_a_figure_of_forces_on_caps_states_the_peaks_with_yield():
    from hertzchain.cli.compared_yield import figure_title
    from hertzchain.cli.run_summary import peaks_if_yielding

    runs = {"box": hc.simulate(box())}
    yielding = {"box": peaks_if_yielding(runs["box"])}
    peak = body_force(hc.simulate(box(loss=hc.ElasticPlastic()))).force
    assert figure_title(runs, yielding) == (
        f"elastic contacts; peak if contacts yield at 1.6 Y: {peak:.3g} N"
    )


@pytest.mark.parametrize("behind", ["cap", "wall"])
def test_a_larger_force_of_a_second_hit_is_stated(run, tmp_path, behind):
    chain = box(loss=hc.ElasticPlastic())
    if behind == "wall":
        chain = heavy_on_wall(hc.ElasticPlastic())
    (file,) = written(tmp_path, row=chain)
    first = hc.simulate(chain, times=4000)
    second = hc.simulate(chain, start=first.state.struck_again(), times=4000)
    one, two = (
        each.wall_force().peak if behind == "wall" else each.force(chain.beads - 1).max()
        for each in (first, second)
    )
    out = run("simulate", file).stdout
    stated = re.search(r"a second, equal impact on these dents: peak (\S+) N, (\d+)% larger", out)
    assert float(stated[1]) == pytest.approx(two, rel=1e-4)
    assert int(stated[2]) == pytest.approx(100 * (two / one - 1), abs=1)
    document = json.loads(run("simulate", file, "--json").stdout)
    assert document["peak_of_second_hit"] == pytest.approx(two, rel=1e-4)
    assert "second, equal" not in run("simulate", file, "--hits", "2").stdout


def heavy_on_wall(loss):
    row = hc.Chain.from_materials(diameters="10 mm", materials="steel-52100", beads=8)
    hammer = {"mass": "50 g", "radius": "flat", "velocity": "0.4 m/s"}
    return row.struck_by(**hammer).replace(right_wall=hc.Wall(), loss=loss)


def test_hits_without_dents_are_all_the_same(run, tmp_path):
    for loss in (None, hc.Restitution(0.9), hc.ElasticPlastic(factor=2.8)):
        (file,) = written(tmp_path, row=heavy_on_wall(loss))
        assert "second, equal" not in run("simulate", file).stdout


def test_a_peak_in_a_later_contact_with_the_wall_says_so(run, tmp_path):
    kinds = ["steel-52100"] * 3 + ["ptfe"] * 5 + ["steel-52100"] * 3
    balls = hc.Chain.from_materials(np.linspace(6e-3, 3e-3, 11), kinds, right_wall=hc.Wall())
    chain = balls.struck_by(mass="30 g", velocity="0.5 m/s").replace(loss=hc.ElasticPlastic())
    wall = hc.simulate(chain).wall_force()
    assert wall.touches > 1
    assert wall.peak_time > wall.first_contact_end
    (file,) = written(tmp_path, row=chain)
    out = run("simulate", file).stdout
    assert "; in a later contact with the wall than the first; " in out
    assert f"({wall.touches} separate contacts with the wall)" in out


DESIGN = """
[chain]
diameters = ["10 mm", "8 mm", "10 mm"]
materials = "steel-52100"
cap = {mass = "100 g"}
velocities = ["0.1 m/s", "0 m/s", "0 m/s", "0 m/s"]

[design]
minimise = "sensor.largest@SENSOR"
budget = 20
until = "1 ms"

[[design.vary]]
order = true
beads = "2:3"
"""


@pytest.mark.parametrize(("sensor", "half"), [("cap", True), ("last", True), ("3", False)])
def test_a_design_says_that_a_sensor_in_a_cap_has_half_of_the_force(run, tmp_path, sensor, half):
    file = tmp_path / "design.toml"
    file.write_text(DESIGN.replace("SENSOR", sensor))
    code, out, err = run("design", file, "--store", tmp_path / "trials")
    assert code == 0, err
    stated = f"\nnote: sensor.largest@{sensor}: mean of the forces on both faces; the free face has"
    assert (stated in out) == half
