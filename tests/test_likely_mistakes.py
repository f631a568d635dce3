"""Messages about arguments that contradict each other or are probably in another unit."""

import pytest

import hertzchain as hc

BALLS = hc.Chain.from_materials(diameters="10 mm", materials="steel-52100", beads=6)
CAPPED = """
[chain]
diameters = "10 mm"
materials = "steel-52100"
beads = 6
cap = {mass = "15 g", stiffness = "1 kN/mm", exponent = 1}
right_wall = {stiffness = "20 kN/mm", exponent = 1}
velocity = "0.1 m/s"
"""


def test_the_mass_of_a_sphere_in_kg_without_a_unit_is_reported():
    with pytest.warns(hc.InputWarning, match="982 times .* write mass='4 g', otherwise .*'4 kg'"):
        BALLS.struck_by(mass=4)


@pytest.mark.parametrize(
    "striker", [{"mass": "4 kg"}, {"mass": 0.9}, {"mass": 4.0, "radius": "flat"}]
)
def test_masses_with_units_of_hammers_and_of_light_strikers_are_accepted(striker):
    assert BALLS.struck_by(**striker).strikers == 1


def test_all_wrong_units_of_a_file_are_reported():
    text = (
        '[chain]\ndiameters = "10 mm"\nmaterials = "brass"\nbeads = 3\nvelocity = "0.1 km"\n'
        'precompression = "5 J"\nright_wall = {gap = "1 N"}\n'
    )
    with pytest.raises(hc.InputError, match="3 errors") as caught:
        hc.chain_from_toml(text)
    for said in (
        "velocity of [chain] must have a unit such as m/s",
        "precompression of [chain] must have a unit such as N, kN, mN, MN, got 'J'",
        "gap of [chain.right_wall] must have a unit such as m,",
    ):
        assert said in str(caught.value)


@pytest.mark.parametrize("seed", [0.01, "1%"])
def test_the_first_argument_of_with_scatter_is_a_seed(seed):
    with pytest.raises(hc.InputError, match=f"first .* is the seed .* got {seed!r}; .*relative="):
        BALLS.with_scatter(seed)


def test_a_scatter_given_by_position_beside_a_seed():
    said = "the first argument is seed, .* as 0.01 and as seed=1; .* such as relative=0.01"
    with pytest.raises(hc.InputError, match=said):
        BALLS.with_scatter(0.01, seed=1)


@pytest.mark.parametrize(("scatter", "shown"), [(2, "'2%'"), (0.02, "0.02"), ("2%", "'2%'")])
def test_a_scatter_given_by_position_is_suggested_as_one_that_is_accepted(scatter, shown):
    with pytest.raises(hc.InputError, match=f"such as relative={shown};"):
        BALLS.with_scatter(0, scatter)
    assert BALLS.with_scatter(0, relative="2%") == BALLS.with_scatter(0, relative=0.02)


def test_an_argument_given_by_position_and_keyword_is_named():
    with pytest.raises(
        hc.InputError, match="with_cap: the first argument is mass, .*; give others"
    ):
        BALLS.with_cap("5 g", mass="6 g")
    with pytest.raises(
        hc.InputError, match="simulate: the first argument is chain, .*give it once"
    ):
        hc.simulate(BALLS, chain=BALLS)


def test_names_of_balls_do_not_count_the_cap(run, tmp_path):
    (tmp_path / "capped.toml").write_text(CAPPED)
    result = run("simulate", tmp_path / "capped.toml", "--sensor", "ball 9")
    assert result.returncode == 2
    assert "6 balls and a cap; give a number from 1 to 6, or 'cap'" in " ".join(
        result.stderr.split()
    )


@pytest.mark.parametrize("command", ["simulate", "design", "pulse", "sensitivity"])
def test_json_takes_no_file(run, command):
    result = run(command, "row.toml", "--json", "row.json")
    assert result.returncode == 2
    assert "redirect the output, --json > row.json" in " ".join(result.stderr.split())


def test_a_striker_needs_a_positive_speed(run):
    options = ("--diameter", "10 mm", "--beads", 5, "--material", "brass")
    result = run("simulate", *options, "--speed", "-1.5 m/s", "--striker", "150 g, flat")
    assert result.returncode == 2
    words = " ".join(result.stderr.split())
    assert "of the impact is -1.5: give a positive --speed" in words
    assert "file" not in words.split("Error:")[1]
