"""Messages about names and values that readers of the documentation are likely to try."""

import pytest

import hertzchain as hc
from hertzchain.designs.measures import parse_measure

BALLS = hc.Chain.from_materials(4e-3, "steel-52100", beads=6, velocity=0.1)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: hc.material("teflon"), "did you mean 'ptfe'"),
        (lambda: hc.material("steal"), "did you mean 'steel-52100', 'steel-304' or 'steel-316'"),
        (
            lambda: hc.material("AISI 52100"),
            "unknown material 'AISI 52100'; did you mean 'steel-52100'",
        ),
        (
            lambda: hc.chain_from_toml('[chain]\ndiametre = "5 mm"'),
            "'diametre' .did you mean 'diameter",
        ),
        (
            lambda: hc.distribution(BALLS, "velocity@last", hc.Scatter(0.01, beads="ball 2")),
            "beads must be selected by number, as in '2', .* where strikers count, got 'ball 2'",
        ),
        (lambda: hc.material("Stainless steel"), "'steel-304', 'steel-316' or 'steel-440c'"),
        (lambda: hc.simulate("chain.toml"), r"hc.load_chain\('chain.toml'\) reads one"),
        (lambda: BALLS.replace(gravity="9.81"), "is '9.81', without a unit; write '9.81 m/s"),
        (lambda: BALLS.replace(gaps=[0.0, 1e-6]), "there must be 5 numbers for the gaps"),
        (lambda: BALLS.replace(gaps="-20 um"), "gap of contact 1 is '-20 um'"),
        (lambda: hc.Wall(gap="-20 um"), "got '-20 um'"),
        (
            lambda: hc.simulate(BALLS.replace(velocities=[-0.1, 0, 0, 0, 0, 0])),
            "bead 1 moves away from the chain .velocity -0.1 m/s., so there is no impact; give",
        ),
    ],
)
def test_a_message_names_what_was_typed_and_what_to_do(call, said):
    with pytest.raises(hc.InputError, match=said):
        call()


def test_a_misspelt_function_is_suggested():
    with pytest.raises(AttributeError, match="did you mean 'simulate'"):
        _ = hc.Simulate
    with pytest.raises(AttributeError, match="propagate"):
        _ = hc.propagates
    with pytest.raises(AttributeError) as raised:
        _ = hc.something_else
    assert "did you mean" not in str(raised.value)


def test_gaps_longer_than_the_chain_are_questioned():
    with pytest.warns(hc.InputWarning, match="gap 2 is 20 m, but the beads are only 0.048 m long"):
        BALLS.replace(gaps=[0.0, 20.0, 0.0, 0.0, 0.0])
    BALLS.replace(gaps=[0.0, 0.04, 0.0, 0.0, 0.0])


def test_tables_of_pulses_have_units():
    units = hc.bca(BALLS).to_dataframe().attrs["units"]
    assert (units["velocity"], units["peak_force"]) == ("m/s", "N")
    assert set(hc.bca(hc.Chain.uniform(5)).to_dataframe().attrs["units"].values()) == {"1"}


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("right_wall", r"did you mean \[chain.right_wall\]\?"),
        ("loss", r"did you mean \[chain.loss\]\?"),
    ],
)
def test_tables_at_the_top_of_a_chain_file(tmp_path, table, message):
    path = tmp_path / "chain.toml"
    path.write_text(f"[chain]\nbeads = 5\n\n[{table}]\n")
    with pytest.raises(hc.InputError, match=message):
        hc.load_chain(path)


def test_the_bca_of_a_lossy_chain_names_its_own_restitution():
    lossy = BALLS.replace(loss=hc.Restitution(0.9))
    advised = r"use simulate, or bca\(chain.replace\(loss=None\), restitution=e\)"
    with pytest.raises(hc.InputError, match=advised):
        hc.bca(lossy)
    with pytest.raises(hc.InputError, match=r"use simulate \(chain"):
        hc.bca(lossy.replace(right_wall=hc.Wall()))


def test_a_theory_names_the_same_chain_without_walls():
    walls = hc.Chain.uniform(5).replace(left_wall=hc.Wall(), right_wall=hc.Wall())
    call = r"omit the walls: chain.replace\(left_wall=None, right_wall=None\) \("
    with pytest.raises(hc.InputError, match=call):
        hc.bca(walls)
    with pytest.raises(hc.InputError, match=r"right wall; omit it: chain.replace\(right_wall=None"):
        hc.hard_sphere(walls.replace(left_wall=None))


@pytest.mark.parametrize(("exponent", "shape"), [(2.0, r"Cone\(half_angle"), (1.3, "N/m.1.3$")])
def test_materials_without_a_stiffness_name_a_shape_of_this_exponent(exponent, shape):
    with pytest.raises(hc.InputError, match=shape):
        BALLS.replace(exponent=exponent)


def test_the_force_on_a_wall_is_found_from_that_in_a_bead():
    run = hc.simulate(BALLS.replace(right_wall=hc.Wall()), times=50)
    with pytest.raises(hc.InputError, match=r"run.wall_force\('right'\) is that on the wall"):
        run.sensor_force("wall")


@pytest.mark.parametrize("name", ["sensor.largest@wall", "peak_force@wall"])
def test_a_force_on_the_wall_as_that_of_a_bead(name):
    chain = hc.Chain.uniform(5).replace(right_wall=hc.Wall())
    spec = {"chain": {"taper": "uniform"}, "axes": {"beads": [5, 6]}, "sweep": {"keep": [name]}}
    with pytest.raises(hc.InputError, match="the wall is wall_force.peak"):
        hc.gradient(chain, name, to=["radii"])
    with pytest.raises(hc.InputError, match="the wall is wall_force.peak"):
        parse_measure(name, chain)
    for attempt in (lambda: hc.simulate_many([chain], keep=[name]), lambda: hc.sweep(spec)):
        with pytest.raises(hc.InputError, match="did you mean 'wall_force.peak'"):
            attempt()


def test_an_unknown_quantity_of_a_table_is_told_the_full_names():
    chain = hc.Chain.uniform(5).replace(right_wall=hc.Wall())
    for name in ("wall_force.max", "wall_peak_forc", "wall_peak"):
        with pytest.raises(hc.InputError) as caught:
            hc.simulate_many([chain], keep=[name])
        assert "(did you mean 'wall_force.peak'" in str(caught.value)
        assert "wall_peak_force, " not in str(caught.value)
    for other in (5, ["velocity"]):
        with pytest.raises(hc.InputError, match="unknown quantity"):
            hc.simulate_many([chain], keep=[other])


def test_sweeps_state_that_largest_velocities_need_a_bead():
    spec = {"chain": {"taper": "uniform"}, "axes": {"beads": [5, 6]},
            "sweep": {"keep": ["largest_velocity"]}}  # fmt: skip
    with pytest.raises(hc.InputError, match="needs the bead: write largest_velocity@5, "):
        hc.sweep(spec)
