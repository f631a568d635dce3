"""Chain files of fits, which can be read, and from which another fit can start."""

import tomllib

import numpy as np
import pytest
from scipy_row import FREE, TRUTH, chain, forces, recorded, traces

import hertzchain as hc
from hertzchain.fitting.chain_parameters import with_sizes
from hertzchain.fitting.fitted_file import fitted_toml, readable_chain
from hertzchain.fitting.names import parse_name
from hertzchain.fitting.parameters import free_parameters

pytestmark = pytest.mark.filterwarnings("ignore::hertzchain.errors.ModelRangeWarning")
STEEL = "steel-52100"
PTFE = hc.Material("my ptfe", density=2170, young=1.2e9, poisson=0.46)


def row(**fields):
    balls = hc.Chain.from_materials("2.5 mm", STEEL, beads=5)
    return balls.struck_by(velocity="0.3 m/s").replace(**{"right_wall": hc.Wall()} | fields)


def listed():
    balls = hc.Chain.from_materials(
        diameters=["10 mm", "6 mm", "9.525 mm"], materials=[STEEL, PTFE, "brass"]
    )
    balls = balls.replace(gaps=[1.25e-7, 0.0])
    return balls.struck_by(diameter="12 mm", velocity="0.123456 m/s", material="steel-304")


CHAINS = {
    "plain": row(),
    "stiffness and wall": row(stiffness=1.23456789e9, right_wall=hc.Wall(7.6543210e9)),
    "wall of a material": row(right_wall=hc.Wall.of("steel-304")),
    "wall with a gap": row(right_wall=hc.Wall(3.2e8, gap=2e-7, exponent=1.4)),
    "rigid": row(right_wall=hc.Wall.rigid(), left_wall=hc.Wall()),
    "viscoelastic": row(loss=hc.Viscoelastic(0.7008e-6)),
    "attractive": row(loss=hc.Viscoelastic(0.7008e-6, attractive=True)),
    "restitution": row(loss=hc.Restitution(0.9321)),
    "elastic-plastic": row(loss=hc.ElasticPlastic()),
    "precompression": row(precompression=12.5, held_by="force"),
    "gravity": row(gravity=9.81),
    "exponent": row(exponent=1.45, stiffness=3e8, right_wall=hc.Wall(4e8)),
    "listed": listed(),
    "two strikers": row().struck_by(velocity="0.4 m/s", gap="1 um"),
    "material": hc.Chain.from_materials("2 mm", PTFE, beads=4).struck_by(velocity="0.1 m/s"),
}


@pytest.mark.parametrize("name", CHAINS)
def test_readable_chains_are_the_same_to_seven_digits(name, tmp_path):
    original = CHAINS[name]
    text = readable_chain(original)
    assert text
    (tmp_path / "row.toml").write_text(text)
    read = hc.load_chain(tmp_path / "row.toml")
    for field in ("radii", "masses", "velocities", "gaps", "contact_stiffness",
                  "contact_exponents"):  # fmt: skip
        np.testing.assert_allclose(getattr(read, field), getattr(original, field), rtol=5e-7)
    assert read.strikers == original.strikers
    assert read.features == original.features
    assert read.held_by == original.held_by
    assert read.contact_losses == original.contact_losses
    assert (read.precompression, read.gravity) == (original.precompression, original.gravity)
    assert [each.young for each in read.materials] == [each.young for each in original.materials]
    # No number has more digits than a person would write.
    assert not any(len(word.strip('",[]').replace(".", "")) > 9 for word in text.split()
                   if word.strip('",[]').replace(".", "").isdigit())  # fmt: skip


@pytest.mark.parametrize("other", [
    row(loss=[hc.Restitution(0.9), *[None] * 4]), row(masses=2e-3 * np.ones(6)),
    row(right_wall=hc.Wall(loss=hc.Restitution(0.5))), hc.Chain.uniform(4),
])  # fmt: skip
def test_chains_with_other_features_are_written_exactly(other):
    assert readable_chain(other) == ""


@pytest.fixture(scope="module")
def inverted():
    """Data of SciPy in mV of an inverted sensor, and a fit with a prior of the stiffness."""
    times, columns = recorded()
    columns["ball 5 [V]"] = -0.02 * columns.pop("ball 5 [N]")
    data = hc.Traces.from_arrays(times, columns)
    free = [*FREE, "gain[ball 5]"]
    priors = {"stiffness": (0.96, 0.02), "gain[ball 5]": (-0.02, 0.002)}
    return hc.fit(data, chain(), free=free, priors=priors)


def test_the_file_of_a_fit_has_units_and_results(inverted):
    text = inverted.chain_toml()
    document = tomllib.loads(text)
    assert document["chain"]["diameters"] == "10 mm"
    assert document["chain"]["beads"] == 15
    (striker,) = document["chain"]["struck_by"]
    assert striker["velocity"].endswith(" m/s")
    assert document["chain"]["loss"]["time"].endswith(" us")
    assert document["chain"]["right_wall"]["material"] == "steel-304"
    comments = [line for line in text.splitlines() if line.startswith("#")]
    for name, shown in inverted.rows():
        assert f"{name} {shown}" in [" ".join(line[1:].split()) for line in comments]
    assert "the model describes the data" in " ".join(line[2:] for line in comments)
    assert max(map(len, text.splitlines())) <= 100


def test_another_fit_can_start_from_the_file(inverted, tmp_path):
    (tmp_path / "fitted.toml").write_text(inverted.chain_toml())
    again = hc.fit(inverted.traces, tmp_path / "fitted.toml")
    assert [*again.names] == [*inverted.names]
    # The stiffness of the file is the fitted one; its prior is relative to it, too.
    expected = inverted.estimates.copy()
    expected[0] = 1.0
    assert again.estimates == pytest.approx(expected, rel=2e-4)
    assert again.sigmas[1:] == pytest.approx(inverted.sigmas[1:], rel=0.02)
    assert again.sigmas[0] == pytest.approx(inverted.sigmas[0] / inverted.values["stiffness"],
                                            rel=0.02)  # fmt: skip
    assert again.chi2 == pytest.approx(inverted.chi2, rel=1e-6)
    truth = TRUTH["stiffness"] / inverted.values["stiffness"]
    assert again.values["stiffness"] == pytest.approx(truth, abs=4.0 * again.sigmas[0])


@pytest.mark.long
def test_the_file_of_several_shots_has_the_values_of_each(tmp_path):
    both, chain_file = hc.example_experiment("fast", "slow")
    result = hc.fit(both, chain_file)
    (tmp_path / "fitted.toml").write_text(result.chain_toml())
    start = tomllib.loads(result.chain_toml())["fit"]["start"]
    assert "struck_by.velocity@2" in start
    assert "struck_by.velocity@1" not in start
    again = hc.fit(both, tmp_path / "fitted.toml")
    assert again.values["struck_by.velocity@2"] == pytest.approx(
        result.values["struck_by.velocity@2"], rel=1e-4
    )


@pytest.mark.parametrize("first", ["stiffness@1", "stiffness"])
def test_the_stiffness_of_each_shot_is_relative_to_that_of_the_file(first):
    shot = traces().shots[0]
    both = hc.Traces((shot, shot))
    priors = {first: (1.0, 0.1), "stiffness@2": (1.0, 0.1)}
    parameters = free_parameters(both, (chain(), chain()), [*priors], priors, {})
    values = {first: 0.8, "stiffness@2": 1.2}
    text = fitted_toml(chain(), [(first, "0.8")], "", parameters, values, both)
    settings = tomllib.loads(text)["fit"]
    assert settings["prior"] == {name: pytest.approx([1.25, 0.125]) for name in priors}
    assert settings["start"]["stiffness@2"] == pytest.approx(1.5)


@pytest.mark.long
def test_the_file_keeps_an_ac_coupling():
    times, columns = recorded(static=20.0)
    data = hc.Traces.from_arrays(
        times, {name: values - values[:50].mean() for name, values in columns.items()}
    )
    held = chain(precompression=20.0, held_by="force")
    result = hc.fit(data, held, free=["stiffness", "time_offset"])
    assert tomllib.loads(result.chain_toml())["fit"]["coupling"] == dict.fromkeys(forces(), "AC")


def test_the_noise_of_unknown_sensors_is_rejected_and_may_have_a_unit(tmp_path):
    times, columns = recorded()
    with pytest.raises(hc.InputError, match="ball 44"):
        hc.Traces.from_arrays(times, columns, noise={"ball 44": 0.003})
    found = hc.Traces.from_arrays(times, columns, noise={"ball 5": "30 mN"})
    assert found.shots[0].signals[0].noise == pytest.approx(0.03)
    file = tmp_path / "data.csv"
    header = ",".join(["time [us]", *columns]).replace("ball 5 [N]", "ball 5 [mV]")
    rows = np.column_stack([1e6 * times, *columns.values()])
    np.savetxt(file, rows, fmt="%.6g", delimiter=",", header=header, comments="")
    with pytest.raises(hc.InputError, match="ball 44"):
        hc.load_traces(file, noise={"ball 44": 0.003})
    assert hc.load_traces(file, noise={"ball 5": "3 mV"}).shots[0].signals[0].noise == 0.003
    assert hc.load_traces(file, noise={"ball 5": "2.5e3uV"}).shots[0].signals[0].noise == 2.5e-3
    for wrong in ("3 N", "-3 mV", "0 mV", "mV", "1.2.3 mV"):
        with pytest.raises(hc.InputError, match="noise of ball 5 must be"):
            hc.load_traces(file, noise={"ball 5": wrong})


def test_the_file_has_the_fitted_velocity(tmp_path):
    result = hc.fit(traces(), chain(), free=FREE)
    (tmp_path / "fitted.toml").write_text(result.chain_toml())
    read = hc.load_chain(tmp_path / "fitted.toml")
    assert read.velocities.max() == pytest.approx(result.values["struck_by.velocity"], rel=1e-6)


@pytest.mark.parametrize("ball", [7, 15])
def test_a_given_stiffness_changes_with_the_radius_of_a_ball(ball):
    """As that of the materials does, also for the wall behind the last ball."""
    nominal, sizes = chain(), {parse_name(f"radius[{ball}]"): 5.05e-3}
    given = nominal.replace(
        stiffness=0.97 * nominal.stiffness,
        right_wall=hc.Wall(stiffness=0.97 * nominal.wall_stiffness[1]),
    )
    derived, changed = (with_sizes(each, sizes, 1e-6) for each in (nominal, given))
    assert changed.contact_stiffness / 0.97 == pytest.approx(derived.contact_stiffness, rel=2e-3)
    assert changed.stiffness == pytest.approx(0.97 * derived.stiffness, rel=1e-12)
    # Contacts that are not those of spheres keep it.
    conical = given.replace(exponent=2.0)
    assert with_sizes(conical, sizes, 1e-6).stiffness == pytest.approx(conical.stiffness, rel=1e-15)


@pytest.mark.parametrize(
    ("wall", "changes", "expected"),
    [
        (hc.Wall(), {"exponent": 1.6}, 1.6),
        (hc.Wall(1e10), {"exponent": 1.6}, 1.6),
        (hc.Wall(1e10, exponent=1.5), {"exponent": 1.6}, 1.5),
        (hc.Wall("2 kN/mm", exponent=1), {"exponent": 1.6}, 1.0),
        (hc.Wall(), {"exponent": 1.6, "right_wall.exponent": 1.7}, 1.7),
    ],
)
def test_a_wall_follows_the_exponent_unless_it_has_its_own(wall, changes, expected):
    """No exponent changes the forces at the reference overlap."""
    reference, before = 2e-6, row(right_wall=wall)
    values = {parse_name(name): value for name, value in changes.items()}
    after = with_sizes(before, values, reference)
    forces = [
        each.contact_stiffness * reference**each.contact_exponents for each in (before, after)
    ]
    np.testing.assert_allclose(forces[1], forces[0], rtol=1e-12)
    assert after.contact_exponents[-1] == expected
    assert after.contact_exponents[-2] == 1.6
