"""Options that describe or change a chain, and messages in the words of the command line."""

import json
import math
import re

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.simulation.yielding import dented_chain
from hertzchain.store.chain_as_toml import chain_as_toml

BALLS = ("--material", "steel-52100", "--diameter", "10 mm", "--beads", 8)
FILE = """
[chain]
diameters = "10 mm"
materials = "steel-52100"
beads = 8
velocity = "0.1 m/s"
[chain.right_wall]
rigid = true
"""


def row(speed=0.1):
    """Eight balls; at rest without a speed."""
    return hc.Chain.from_materials(5e-3, "steel-52100", beads=8, velocity=speed)


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "row.toml"
    path.write_text(FILE)
    return path


def wall_peak(run, *options):
    code, out, err = run("simulate", *options, "--json")
    assert code == 0, err
    (wall,) = json.loads(out)["walls"]
    return wall["peak"]


@pytest.mark.parametrize(
    ("options", "changes"),
    [
        (("--wall", "brass"), {"right_wall": hc.Wall.of("brass")}),
        (("--wall", "rigid", "--loss", "restitution=90%"),
         {"right_wall": hc.Wall.rigid(), "loss": hc.Restitution(0.9)}),
        (("--wall", "same", "--loss", "viscoelastic=0.6us"),
         {"right_wall": hc.Wall(), "loss": hc.Viscoelastic(0.6e-6)}),
        (("--wall", "same", "--loss", "viscoelastic=0.6 us,attractive=true"),
         {"right_wall": hc.Wall(), "loss": hc.Viscoelastic(0.6e-6, attractive=True)}),
        (("--wall", "same", "--loss", "elastic-plastic"),
         {"right_wall": hc.Wall(), "loss": hc.ElasticPlastic()}),
        (("--wall", "same", "--loss", "velocity-power=900,alpha=1.2"),
         {"right_wall": hc.Wall(), "loss": hc.VelocityPower(900.0, 1.2)}),
        (("--wall", "brass", "--loss", "restitution=0.9", "--wall-loss", "restitution=70%"),
         {"right_wall": hc.Wall(material="brass", loss=hc.Restitution(0.7)),
          "loss": hc.Restitution(0.9)}),
        (("--wall", "same", "--wall-loss", "viscoelastic, restitution=0.9, speed=0.1 m/s"),
         {"right_wall": hc.Wall(loss=hc.Viscoelastic.from_restitution(
             0.9, speed=0.1, chain=row().replace(right_wall=hc.Wall()), contact=8))}),
        (("--wall", "same", "--loss", "viscoelastic, restitution=0.9, height=30 mm, contact=wall"),
         {"right_wall": hc.Wall(), "loss": hc.Viscoelastic.from_restitution(
             0.9, speed=math.sqrt(2 * 9.80665 * 0.03),
             chain=row().replace(right_wall=hc.Wall()), contact=8)}),
    ],
)  # fmt: skip
@pytest.mark.filterwarnings("ignore::hertzchain.errors.ModelRangeWarning")
def test_wall_and_loss_change_described_chains_and_files(run, file, options, changes):
    expected = hc.simulate(row().replace(**changes)).wall_force().peak
    assert wall_peak(run, *BALLS, "--speed", "0.1 m/s", *options) == pytest.approx(expected)
    assert wall_peak(run, file, *options) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("law", "message"),
    [
        ("height=30 mm", "with a restitution needs its speed, too"),
        ("restitution=0.9, height=30", "height of --loss 30.0 has no unit"),
        ("restitution=0.9, height=30 mm, speed=1 m/s", "a speed and a height to fall from"),
        ("restitution=0.9, height=3 kg", "height of --loss"),
        ("restitution=0.9, speed=1 m/s, contact=wall", "the chain has no wall"),
    ],
)
def test_heights_and_walls_of_a_restitution_are_checked(run, law, message):
    code, _, err = run("simulate", *BALLS, "--loss", f"viscoelastic, {law}")
    assert code == 2
    assert message in err


def test_the_last_bead_can_have_a_sensor(run):
    outs = [
        run("simulate", *BALLS, "--speed", "0.1 m/s", "--sensor", bead).stdout
        for bead in ("last", "8")
    ]
    assert outs[0] == outs[1]
    assert "sensor in bead 8" in outs[0]


@pytest.mark.parametrize(
    ("material", "size", "chain"),
    [
        ("steel-304, PTFE", "10 mm",
         hc.Chain.dimer(diameters="10 mm", materials=["steel-304", "ptfe"], beads=5)),
        ("steel-304,ptfe,brass", "10 mm:5 mm",
         hc.Chain.tapered(first_diameter="10 mm", last_diameter="5 mm", beads=5,
                          materials=["steel-304", "ptfe", "brass", "steel-304", "ptfe"])),
        ("brass,ptfe,ptfe,brass,brass", "10 mm",
         hc.Chain.from_materials("5 mm", ["brass", "ptfe", "ptfe", "brass", "brass"])),
    ],
)  # fmt: skip
def test_several_materials_are_those_of_the_beads_in_turn(run, material, size, chain):
    expected = hc.simulate(chain.replace(velocities=0.001 * chain.velocities,
                                         right_wall=hc.Wall())).wall_force().peak  # fmt: skip
    options = ("--material", material, "--diameter", size, "--beads", 5)
    assert wall_peak(run, *options, "--speed", "1 mm/s", "--wall", "same") == pytest.approx(
        expected
    )
    code, _, err = run("pulse", *options[:-1], 1)
    assert code == 2
    assert "materials, but there is only 1 bead: omit some" in " ".join(err.split())


def test_strikers_are_beads_like_the_first_one_at_the_speed_of_the_impact(run, file):
    struck = row(None).struck_by(velocity=0.1, count=2).replace(right_wall=hc.Wall.rigid())
    expected = hc.simulate(struck).wall_force().peak
    options = ("--speed", "0.1 m/s", "--striker", 2, "--wall", "rigid")
    assert wall_peak(run, *BALLS, *options) == pytest.approx(expected)
    assert wall_peak(run, file, "--striker", 2) == pytest.approx(expected)
    faster = struck.replace(velocities=2.0 * struck.velocities)
    found = wall_peak(run, file, "--striker", 2, "--velocity", "20 cm/s")
    assert found == pytest.approx(hc.simulate(faster).wall_force().peak)
    shown = run("simulate", file, "--striker", 2).stdout
    assert "diameter 10 mm, and 2 strikers, rigid right wall, impact at 0.1 m/s\n" in shown
    found = json.loads(run("pulse", "--beads", 8, "--striker", 1, "--json").stdout)["pulses"][0]
    scaled = hc.Chain.uniform(8).struck_by()
    np.testing.assert_allclose(found["velocity"], hc.propagate(scaled).velocity, rtol=1e-9)


@pytest.mark.filterwarnings("ignore::hertzchain.errors.ModelRangeWarning")
@pytest.mark.parametrize(
    ("options", "striker", "wall"),
    [
        (("--striker", "30 g"), {"mass": 0.03}, hc.Wall()),
        (("--striker", "30 g, flat"), {"mass": 0.03, "radius": np.inf}, hc.Wall()),
        (("--striker", "2, 12 mm, brass"), {"count": 2, "diameter": 0.012, "material": "brass"},
         hc.Wall()),
        (("--striker", "1", "--wall", "5 kN/mm"), {}, hc.Wall(5e6, exponent=1, loss=hc.Elastic())),
        (("--striker", "1", "--wall", "2e10 N/m^1.5"), {}, hc.Wall(2e10)),
    ],
)  # fmt: skip
def test_other_strikers_and_walls_of_known_stiffness(run, file, options, striker, wall):
    options = options if "--wall" in options else (*options, "--wall", "same")
    chain = row(None).struck_by(velocity=0.1, **striker).replace(right_wall=wall)
    expected = hc.simulate(chain).wall_force().peak
    assert wall_peak(run, *BALLS, "--speed", "0.1 m/s", *options) == pytest.approx(expected)
    assert wall_peak(run, file, *options) == pytest.approx(expected)


@pytest.mark.filterwarnings("ignore::hertzchain.IncompleteWarning")
@pytest.mark.parametrize("force", [0.0, 20.0])
def test_wall_none_frees_the_last_bead_or_the_cap_of_a_file(run, tmp_path, force):
    chain = row().replace(right_wall=hc.Wall(), left_wall=hc.Wall())
    chain = chain.replace(precompression=force, held_by="walls") if force else chain
    file = tmp_path / "row.toml"
    file.write_text(chain_as_toml(chain), "utf-8")
    code, out, err = run("simulate", file, "--wall", "none", "--cap", "100 g", "--until", "1 ms",
                         "--json")  # fmt: skip
    assert code == 0, err
    held = {"held_by": "force"} if force else {}
    free = chain.replace(right_wall=None, **held).with_cap("100 g")
    expected = hc.simulate(free, until="1 ms").body_force().force
    document = json.loads(out)
    assert [wall["side"] for wall in document["walls"]] == ["left"]
    assert document["last_bead_force"]["force"] == pytest.approx(expected)


def test_the_speed_of_a_chain_at_rest_is_that_of_its_strikers_or_of_bead_1(run, tmp_path):
    file, options = tmp_path / "rest.toml", ("--speed", "0.1 m/s")
    still = FILE.replace("0.1 m/s", "0 m/s")
    file.write_text(still, "utf-8")
    wall = {"right_wall": hc.Wall.rigid()}
    expected = hc.simulate(row().replace(**wall)).wall_force().peak
    assert wall_peak(run, file, *options, "--wall", "rigid") == pytest.approx(expected)
    struck = row(None).struck_by(velocity=0.1, count=2).replace(**wall)
    expected = hc.simulate(struck).wall_force().peak
    both = (*options, "--wall", "rigid", "--striker", 2)
    assert wall_peak(run, file, *both) == pytest.approx(expected)
    file.write_text(still + "[[chain.struck_by]]\nvelocity = 0.0\ncount = 2\n", "utf-8")
    assert wall_peak(run, file, *options, "--wall", "rigid") == pytest.approx(expected)


@pytest.mark.filterwarnings("always::UserWarning")
def test_simulate_states_the_speed_of_the_impact(run, file):
    out = run("simulate", *BALLS).stdout
    assert out.splitlines()[0].endswith("diameter 10 mm, impact at 1 m/s (default)")
    out = run("simulate", *BALLS, "--velocity", "1 m/s").stdout
    assert out.splitlines()[0].endswith("diameter 10 mm, impact at 1 m/s")
    assert ", impact at 0.1 m/s\n" in run("simulate", file).stdout
    # In scaled variables, the speed is the unit.
    assert "impact" not in run("simulate", "--beads", 8).stdout
    assert "default: 1 m/s" in " ".join(run("simulate", "--help").stdout.split())


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--loss", "visco=2us"), "did you mean 'viscoelastic'"),
        (("--loss", "viscoelastic=2"), "no unit; write, for example, --loss 'viscoelastic=2 us'"),
        (("--loss", "restitution"), "requires the value of its coefficient"),
        (("--loss", "restitution=1.1"), "coefficient of restitution must be"),
        (("--loss", "restitution=0.9,foo=2"), "has no argument 'foo'"),
        (("--loss", "elastic=2"), "has no parameters: write --loss elastic"),
        (("--striker", "0"), "--striker must be"),
        (("--wall", "same", "--wall-loss", "visco=2us"), "law of --wall-loss"),
        (
            ("--wall", "same", "--wall-loss", "viscoelastic=2"),
            "no unit; write, for example, --wall-loss 'viscoelastic=2 us'",
        ),
        (
            ("--wall", "same", "--wall-loss", "viscoelastic, restitution=0.9"),
            "--wall-loss viscoelastic with a restitution needs its speed, too",
        ),
        (
            ("--wall", "butter"),
            "none, a material or a stiffness such as '5 kN/mm': unknown material 'butter'",
        ),
        (("--wall", "2 kg/mm"), "or a stiffness such as '5 kN/mm' (exponent 1)"),
        (("--wall", "2"), "or a stiffness such as '5 kN/mm' (exponent 1)"),
        (("--striker", "50 s"), "such as --striker '50 g, flat', got '50 s'"),
        (("--striker", "50 g, 20 g"), "'50 g, 20 g' has two values of the mass: omit one"),
        (("--striker", "butter"), "unknown material 'butter'"),
        (("--striker", "flat"), "has no default mass; give mass"),
    ],
)
def test_bad_changes_are_rejected(run, file, options, words):
    for chain in ((*BALLS, "--speed", "0.1 m/s"), (file,)):
        code, out, err = run("simulate", *chain, *options)
        assert (code, out) == (2, "")
        assert words in " ".join(err.split())


def test_a_loss_of_a_wall_needs_a_wall(run):
    code, out, err = run("simulate", *BALLS, "--wall-loss", "restitution=0.9")
    assert (code, out) == (2, "")
    assert "--wall-loss is that of the contact with a wall: add --wall" in " ".join(err.split())


@pytest.mark.filterwarnings("always::UserWarning")
def test_the_advice_for_a_linear_wall_can_be_followed(run, file):
    file.write_text(FILE.replace("0.1 m/s", "1 m/s").replace(
        "rigid = true", 'stiffness = "5 kN/mm"\nexponent = 1'))  # fmt: skip
    options = ("--loss", "elastic-plastic")
    assert "add --loss elastic-plastic\n" in run("simulate", file).stderr
    assert "the right wall is a spring and stays elastic" in run("simulate", file, *options).stdout
    wall = hc.Wall("5 kN/mm", exponent=1, loss=hc.Elastic())
    expected = row(1.0).replace(right_wall=wall, loss=hc.ElasticPlastic())
    assert wall_peak(run, file, *options) == pytest.approx(hc.simulate(expected).wall_force().peak)


def test_strikers_of_files_are_not_doubled(run, file):
    at_rest = FILE.replace('velocity = "0.1 m/s"\n', "")
    file.write_text(at_rest + "[[chain.struck_by]]\nvelocity = 0.2\n")
    code, _, err = run("simulate", file, "--striker", 2)
    assert code == 2
    assert "but the file has some" in err
    file.write_text(FILE.replace('velocity = "0.1 m/s"', "velocities = [0, 0.1, 0, 0, 0, 0, 0, 0]"))
    code, _, err = run("simulate", file, "--striker", 2)
    assert code == 2
    assert "other beads move" in err


@pytest.mark.filterwarnings("always::UserWarning")
def test_messages_have_the_words_of_the_command_line(run):
    err = run("simulate", *BALLS).stderr
    assert "or add --loss elastic-plastic\n" in err
    err = run(
        "simulate", *BALLS, "--wall", "same", "--speed", "0.1 m/s", "--until", "200 us"
    ).stderr
    assert "the largest until" in err
    assert "use the largest force so far" in err
    err = run("simulate", "--beads", 20, "--max-steps", 20).stderr
    assert "raise --max-steps" in err
    assert not re.search(r"ElasticPlastic|largest_so_far|[^-]max_steps", err)
    rubber = ("simulate", "--material", "rubber", "--diameter", "10 mm", "--beads", 3, "--loss")
    code, _, err = run(*rubber, "elastic-plastic")
    assert code == 2
    assert "'rubber' and 'rubber', which meet at contact 1" in err
    assert "give --loss 'elastic-plastic=5 MPa', or yield_strength in [materials.NAME]" in err
    assert run(*rubber, "elastic-plastic=5 MPa").returncode == 0
    out = run(*rubber, "elastic-plastic", "--wall", "steel-52100").stdout
    assert "contacts of rubber with rubber have no known yield strength and stay elastic; " in out


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
@pytest.mark.filterwarnings("ignore:the striker has:hertzchain.InputWarning")
def test_simulate_states_the_peak_with_contacts_that_yield(run, tmp_path):
    command = ("simulate", "--material", "steel-52100", "--diameter", "20 mm:5 mm", "--beads", 12,
               "--speed", "1 m/s", "--wall", "same")  # fmt: skip
    out = run(*command).stdout
    stated = float(re.search(r"peak with contacts that yield: ([0-9.]+) N", out)[1])
    yielding = json.loads(run(*command, "--loss", "elastic-plastic", "--json").stdout)
    assert stated == pytest.approx(yielding["walls"][0]["peak"], rel=1e-4)
    assert yielding["peak_with_yielding_contacts"] is None
    elastic = json.loads(run(*command, "--json").stdout)
    assert elastic["peak_with_yielding_contacts"] == pytest.approx(stated, rel=1e-4)
    assert stated < 0.7 * elastic["walls"][0]["peak"]
    # The range ends at the pressure of fully plastic contacts.
    harder = json.loads(run(*command, "--loss", "elastic-plastic, factor=2.8", "--json").stdout)
    ends = stated, harder["walls"][0]["peak"]
    assert elastic["peak_range_with_yielding_contacts"] == pytest.approx(ends, rel=1e-4)
    assert f"\n    {ends[0]:.3g} to {ends[1]:.3g} N for yield pressures of 1.6 to 2.8 times" in out
    # The peak of the elastic contacts is complete, but not that of those that yield.
    hammered = hc.Chain.from_materials("3 mm", ["steel-52100", "ptfe"] * 2, velocity=0.0)
    hammered = hammered.struck_by(mass=0.2, radius=math.inf, material="steel-304", velocity=0.1)
    hammered = hammered.replace(right_wall=hc.Wall.of("steel-52100"), gravity=100.0)
    assert hc.simulate(hammered, times=0).wall_force().complete
    assert not hc.simulate(dented_chain(hammered), times=0)._wall_force("right").complete
    (tmp_path / "row.toml").write_text(chain_as_toml(hammered))
    document = json.loads(run("simulate", tmp_path / "row.toml", "--json").stdout)
    assert document["walls"][0]["peak"] > 0.0
    assert document["peak_with_yielding_contacts"] is None
    assert "contacts that yield" not in run("simulate", tmp_path / "row.toml").stdout
    slow = run(*command[:-3], "0.01 m/s", "--wall", "same").stdout
    assert "contacts that yield" not in slow


@pytest.mark.parametrize(("option", "advice"), [
    (("--until", "1e-4"), "write, for example, --until '100 us'"),
    (("--step", "2e-9"), "write, for example, --step '0.002 us'"),
    (("--speed", "1"), "write, for example, --speed '1 m/s'"),
    # The option has two names.
    (("--velocity=1",), "Error: --velocity 1 has no unit; write, for example, --velocity '1 m/s'"),
    (("--velocity", "-1 m/s", "--striker", "1"), "above 0, but that of the impact is -1: give a "
     "positive --velocity"),
])  # fmt: skip
def test_quantities_of_options_need_units(run, option, advice):
    balls = ("simulate", *BALLS, "--method", "symplectic")
    code, _, err = run(*balls, *option)
    assert (code, advice in err) == (2, True)
    code, _, err = run("simulate", "--beads", 8, "--until", "5ms")
    assert code == 2
