"""Summaries of runs with drives and static forces."""

import json

import hertzchain as hc


def test_an_endless_shaker_gives_no_last_bead_in_the_leading_pulse(run, tmp_path):
    row = hc.Chain.uniform(6).replace(
        precompression=0.1, held_by="force", velocities=[0.0] * 6, loss=hc.Dashpot(0.05)
    )
    shaker = {"amplitude": 0.01, "frequency": 0.2, "window": "none"}
    found = {}
    for name, cycles in (("endless", float("inf")), ("burst", 2.0)):
        driven = row.replace(drive=hc.SineBurst(cycles=cycles, **shaker))
        (tmp_path / f"{name}.toml").write_text(hc.chain_as_toml(driven))
        _, out, _ = run("simulate", tmp_path / f"{name}.toml", "--until", "60", "--json")
        found[name] = json.loads(out)["last_bead"]
    assert found["endless"] is None
    assert found["burst"] is not None


def test_static_forces_are_options_of_chains(run):
    row = ["--material", "steel-52100", "--diameter", "10 mm", "--beads", "9"]
    code, out, _ = run("simulate", *row, "--speed", "10 mm/s", "--striker", "1", "--wall", "same",
                       "--gravity", "9.81 m/s^2", "--json")  # fmt: skip
    balls = hc.Chain.from_materials(diameters="10 mm", materials="steel-52100", beads=9)
    weight = 9.81 * balls.masses.sum()
    assert code == 0
    assert abs(json.loads(out)["walls"][0]["static_force"] / weight - 1.0) < 1e-12
    pressed = [*row, "--speed", "1 mm/s", "--precompression", "10 N", "--until", "0.2 ms"]
    code, out, _ = run("simulate", *pressed, "--sensor", "5")
    assert code == 0
    assert ", with the static force of 10 N" in out
    for option, said in (("--gravity", "'9.81 m/s^2'"), ("--precompression", "'9.81 N'")):
        code, _, err = run("simulate", *row, option, "9.81")
        assert code == 2
        assert f"{option} 9.81 has no unit; write, for example, {option} {said}" in err


def test_zero_requires_no_unit_and_other_numbers_of_options_do(run):
    row = ["simulate", "--material", "brass", "--diameter", "10 mm", "--beads", "3"]
    assert run(*row, "--speed", "1 cm/s", "--gravity", "0", "--json")[0] == 0
    for option, text, example in (
        ("--speed", "2", "2 m/s"), ("--until", "0.5", "500 ms"), ("--until", "5", "5 us"),
        ("--precompression", "-1e-3", "-1e-3 N"),
    ):  # fmt: skip
        code, _, err = run(*row, option, text)
        assert code == 2
        assert err.strip().endswith(
            f"{option} {text} has no unit; write, for example, {option} '{example}'"
        )
    code, _, err = run(*row, "--speed", "0")
    assert code == 2
    assert "is not struck" in err


def test_the_force_on_a_wall_is_stated_with_its_static_part(run, tmp_path):
    row = hc.Chain.from_materials(
        diameters="10 mm", materials="steel-52100", beads=4, velocity="0.05 m/s",
        right_wall=hc.Wall(), precompression="20 N", held_by="force",
    )  # fmt: skip
    for force, stated in ((20.0, True), (0.0, False)):
        chain = row.replace(precompression=force)
        (tmp_path / "row.toml").write_text(hc.chain_as_toml(chain))
        _, out, _ = run("simulate", tmp_path / "row.toml", "--until", "0.2 ms")
        assert (" (with the static force of 20 N); " in out) == stated
        assert ("N s in the whole run with the static force" in out) == stated


def test_masses_of_strikers_are_in_grams():
    row = hc.Chain.from_materials(diameters="10 mm", materials="steel-52100", beads=4)
    for mass, said in (
        ("0.15 kg", "1 striker (mass 150 g, flat)"),
        (1.5, "1 striker (mass 1.5 kg, flat)"),
    ):
        assert said in row.struck_by(mass=mass, radius="flat", velocity=0.1).description
