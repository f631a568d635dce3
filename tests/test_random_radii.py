"""Random deviations of radii: one rule, and the same results in scaled variables and SI units."""

import json

import numpy as np
import pytest

import hertzchain as hc

BALLS = hc.Chain.from_materials(5e-3, "steel-316", beads=12, velocity=1e-3)
# Powers of the radius of bead 1 in the results, if its unit of length is another bead.
POWERS = {
    "velocity": 0, "momentum": 3, "energy": 3, "arrival": 1, "residence": 1, "peak_overlap": 1,
    "peak_force": 2,
}  # fmt: skip


def pair(chain):
    """The units of a chain in SI units, the chain, and the same in scaled variables."""
    scales = hc.Scales.of(chain)
    return scales, chain, scales.to_scaled(chain)


def test_scaled_and_si_ensembles_have_the_same_pulses():
    scales, real, scaled = pair(BALLS)
    scatter = hc.Scatter(radius=0.02, samples=6)
    si, own = (hc.propagate_many(scatter.sample(chain, 4)) for chain in (real, scaled))
    for name in ("velocity", "momentum", "energy", "arrival", "residence", "peak_force"):
        found, expected = (
            getattr(own, name),
            getattr(si, name)
            / scales.unit(
                "time" if name in ("arrival", "residence") else name.removeprefix("peak_")
            ),
        )
        np.testing.assert_allclose(found, expected, rtol=1e-12, err_msg=name)
    assert np.ptp(own.momentum[:, 0]) > 0.01
    assert np.ptp(own.arrival[:, 1]) > 0.001


def test_scaled_and_si_ensembles_have_the_same_forces_on_the_wall():
    scales, real = hc.Scales.of(BALLS), BALLS.replace(right_wall=hc.Wall())
    scaled = hc.Chain.uniform(12).replace(right_wall=hc.Wall())
    runs = [
        hc.simulate_many([chain.with_scatter(seed, relative=0.02) for seed in range(4)],
                         keep=["wall_peak_force", "wall_peak_time"])
        for chain in (real, scaled)
    ]  # fmt: skip
    for name, unit in (("wall_peak_force", scales.force), ("wall_peak_time", scales.time)):
        np.testing.assert_allclose(runs[1][name] * unit, runs[0][name], rtol=1e-9)


@pytest.mark.parametrize("beads", [None, "2:", [1, 3]])
def test_with_scatter_and_scatter_have_one_rule(beads):
    for chain in (BALLS, hc.Chain.uniform(8), hc.Chain.uniform(8).struck_by(radius=2.0, count=2)):
        one = chain.with_scatter(7, relative=0.1, beads=beads)
        (other, _) = hc.Scatter(radius=0.1, samples=2, beads=beads).sample(chain, 7)
        assert one.radii.tolist() == other.radii.tolist()
        deviate = np.flatnonzero(one.radii != chain.radii) + 1
        every = range(chain.strikers + 1, chain.beads + 1)
        expected = {None: every, "2:": range(2, chain.beads + 1)}
        assert deviate.tolist() == list(beads if isinstance(beads, list) else expected[beads])


@pytest.mark.parametrize(
    "chain",
    [hc.Chain.uniform(5).replace(masses=np.ones(5)), hc.Chain.dimer(0.5, beads=6)],
)  # fmt: skip
def test_given_masses_have_no_scatter(chain):
    for call in (
        lambda: chain.with_scatter(1, relative=0.1),
        lambda: hc.Scatter(radius=0.1).sample(chain),
    ):
        with pytest.raises(hc.InputError, match="a scatter of radii changes the masses"):
            call()


def test_gaps_and_velocities_stay():
    chain = hc.Chain.uniform(4).replace(gaps=[0.1, 0.0, 0.2], velocities=[1.0, 0.0, 0.0, -0.5])
    lot = chain.with_scatter(1, relative=0.1)
    assert lot.gaps.tolist() == chain.gaps.tolist()
    assert lot.velocities.tolist() == chain.velocities.tolist()


SMOOTH = hc.Chain.tapered("backward-exponential", 0.01, beads=40).radii
STEPPED = np.repeat([1.0, 2.0], 30)
METHODS = {
    "propagate": (hc.propagate, SMOOTH, {}),
    "propagate_many": (lambda chain: hc.propagate_many([chain])[0], SMOOTH, {}),
    "simulate": (lambda chain: hc.simulate(chain, times=0).pulse(), SMOOTH, {}),
    "bca": (hc.bca, SMOOTH, {}),
    "hard_sphere": (hc.hard_sphere, SMOOTH, {}),
    "local_rate": (hc.local_rate, SMOOTH, {}),
    "restitution": (hc.local_rate, SMOOTH, {"loss": lambda _: hc.Restitution(0.98)}),
    "viscoelastic": (hc.local_rate, SMOOTH, {"loss": lambda unit: hc.Viscoelastic(0.01 * unit)}),
    "striker": (hc.local_rate, SMOOTH,
                {"masses": lambda unit: unit**3 * np.r_[2.0, SMOOTH[1:] ** 3]}),
    "piecewise": (hc.piecewise_local_rate, STEPPED, {}),
    "disorder": (lambda chain: hc.disorder(chain, 0.01), SMOOTH, {}),
}  # fmt: skip


@pytest.mark.parametrize("name", METHODS)
def test_the_unit_of_length_of_a_scaled_chain_may_be_another_bead(name):
    """The equations of motion are homogeneous: results change by exact powers of the unit."""
    method, radii, more = METHODS[name]
    one, two = (
        method(hc.Chain(unit * radii, **{key: value(unit) for key, value in more.items()}))
        for unit in (1.0, 1.25)
    )
    for quantity, power in POWERS.items():
        if (expected := getattr(one, quantity)) is not None:
            np.testing.assert_allclose(
                getattr(two, quantity), 1.25**power * expected, rtol=1e-11, err_msg=quantity
            )


def test_the_command_has_the_spread_of_the_law(run):
    """Velocity of bead 30 for a scatter of 2%: without bead 1 it would be 1.5%."""
    args = ["scatter", "--beads", "40", "--scatter", "2%", "--quantity", "velocity@30", "--json"]

    def spread(*more):
        code, out, _ = run(*args, *more)
        assert code == 0
        found = json.loads(out)
        return found["standard_deviation"] / found["mean"]

    law = hc.disorder(hc.Chain.uniform(40), 0.02).velocity_spread[29]
    assert spread() == pytest.approx(law, rel=0.08)
    assert spread("--only", "2:") == pytest.approx(np.sqrt(law**2 - 2.55 * 0.02**2), rel=0.1)
    assert spread("--only", "1") == pytest.approx(np.sqrt(2.55) * 0.02, rel=0.1)


def test_chain_files_keep_the_unit_of_length(tmp_path):
    for chain in (
        hc.Chain.uniform(6).with_scatter(1, relative=0.1),
        hc.Chain.uniform(6).replace(gaps=[0.1, 0, 0, 0, 0]).with_scatter(1, relative=0.1),
        hc.Chain.uniform(6).struck_by(radius=2.0).with_scatter(1, relative=0.1),
        hc.Chain.uniform(6).replace(radii=np.full(6, 1.5)),
    ):
        file = tmp_path / "lot.toml"
        file.write_text(hc.chain_as_toml(chain))
        assert hc.load_chain(file).radii.tolist() == chain.radii.tolist()


def test_defects_of_bead_1_keep_the_unit_of_length():
    chain = hc.Chain.uniform(4).with_defects({1: 0.5})
    assert chain.radii.tolist() == [0.5, 1.0, 1.0, 1.0]
    assert chain.masses[0] == 0.125
    assert chain[:3].radii.tolist() == [0.5, 1.0, 1.0]
    assert chain[1:].radii.tolist() == [1.0, 1.0, 1.0]
