"""Random gaps: their distribution, chains, designs, files and commands."""

import json

import numpy as np
import pytest
from figure_texts import legend_texts

import hertzchain as hc
from hertzchain.designs import new_samples
from hertzchain.designs.sensitivity import GAP_STEP

BALLS = hc.Chain.from_materials("5 mm", "steel-52100", beads=8, right_wall=hc.Wall())
ROW = BALLS.struck_by(velocity="0.1 m/s")
SIZE = 5e-6


def _gaps(seed: int, samples: int, beads: int) -> np.ndarray:
    """The documented half-normal gaps, with the second part of the random numbers."""
    rng = np.random.default_rng(seed)
    rng.standard_normal((samples, beads))
    return SIZE * np.abs(rng.standard_normal((samples, beads)))[:, :-1]


def _peaks(chains: list[hc.Chain]) -> list[float]:
    return [hc.simulate(chain).wall_force().peak for chain in chains]


def test_distribution_of_gaps_is_that_of_a_loop_of_simulations() -> None:
    found = hc.distribution(ROW, "wall_force.peak", hc.Scatter(gaps="5 um", samples=6), seed=3)
    gaps = _gaps(3, 6, ROW.beads)
    gaps[:, 0] = 0.0  # that of the striker, which only delays the impact
    expected = _peaks([ROW.replace(gaps=row) for row in gaps])
    np.testing.assert_allclose(found.values, expected, rtol=1e-7)
    assert found.values.std() > 1e-3 * found.nominal


def test_gaps_and_diameters_are_combined() -> None:
    radii = hc.Scatter(radius="1%", samples=4).sample(ROW)
    gaps = hc.Scatter(gaps=SIZE, samples=4).sample(ROW)
    both = hc.Scatter(radius=0.01, gaps="5 um", samples=4).sample(ROW)
    for one, other, each in zip(radii, gaps, both, strict=True):
        np.testing.assert_array_equal(each.radii, one.radii)
        np.testing.assert_array_equal(each.gaps, other.gaps)
        assert not one.gaps.any()
        np.testing.assert_array_equal(other.radii, ROW.radii)


def test_gaps_are_half_normal_and_added_to_those_of_the_chain() -> None:
    chain = hc.Chain.from_materials("5 mm", "brass", beads=4001, gaps=np.full(4000, 1e-5))
    added = chain.with_scatter(1, gaps="5 um").gaps - 1e-5
    assert (added > 0.0).all()
    # Mean s sqrt(2/pi) and median 0.6745 s, within 4 standard errors.
    assert added.mean() == pytest.approx(SIZE * np.sqrt(2.0 / np.pi), rel=0.05)
    assert np.median(added) == pytest.approx(0.6745 * SIZE, rel=0.08)


def test_gaps_between_beads_that_both_deviate() -> None:
    gaps = ROW.with_scatter(1, gaps=SIZE, beads="3:5").gaps
    assert np.flatnonzero(gaps).tolist() == [2, 3]
    assert ROW.with_scatter(1, gaps=SIZE, grade=10).gaps[0] == 0.0


def test_scaled_gaps_have_no_unit() -> None:
    chain = hc.Chain.uniform(5)
    assert chain.with_scatter(1, gaps=0.5).gaps.any()
    with pytest.raises(hc.InputError, match="gaps of a scatter"):
        hc.Scatter(gaps="5 um").sample(chain)


@pytest.mark.parametrize("gaps", [0.0, -1e-6, "5 kg", np.nan])
def test_impossible_gaps_are_rejected(gaps: object) -> None:
    for call in (lambda: hc.Scatter(gaps=gaps), lambda: ROW.with_scatter(1, gaps=gaps)):
        with pytest.raises(hc.InputError, match="gaps of a scatter"):
            call()


def test_precompressed_beads_have_no_random_gaps() -> None:
    held = BALLS.replace(left_wall=hc.Wall(), precompression="10 N")
    with pytest.raises(hc.InputError, match="precompressed beads touch and have no gaps"):
        held.with_scatter(1, gaps=SIZE)


def test_beads_at_rest_under_gravity_have_no_random_gaps(run, tmp_path) -> None:
    column = BALLS.replace(right_wall=hc.Wall(), gravity="9.81 m/s^2")
    with pytest.raises(hc.InputError, match="a chain with gaps would fall: omit the gaps, or the"):
        column.with_scatter(1, gaps=SIZE)
    falling = column.replace(right_wall=None).with_scatter(1, gaps=SIZE)
    assert (falling.gaps > 0.0).all()
    (tmp_path / "column.toml").write_text(hc.chain_as_toml(column))
    code, _, err = run("sensitivity", tmp_path / "column.toml", "--to", "gaps", "--until", "1 ms")
    assert code == 2
    assert "a chain with gaps would fall" in err


def test_chain_file_with_random_gaps() -> None:
    text = (
        '[chain]\ndiameters = "10 mm"\nbeads = 8\nmaterials = "steel-52100"\n'
        '[chain.with_scatter]\nseed = 4\ngaps = "5 um"\n'
    )
    gaps = hc.chain_from_toml(text).gaps
    np.testing.assert_allclose(gaps, _gaps(4, 1, 8)[0], rtol=1e-14)
    both = hc.chain_from_toml(text.replace("gaps", 'relative = "1%"\ngaps'))
    np.testing.assert_array_equal(hc.chain_from_toml(hc.chain_as_toml(both)).gaps, gaps)


def test_design_with_random_gaps(monkeypatch) -> None:
    monkeypatch.setattr(new_samples, "FRESH", 40)
    scatter = {"gaps": "5 um", "samples": 2, "measure": "mean"}
    problem = hc.Design(
        ROW, minimise="wall_force.peak", vary=[hc.vary.radii("4 mm", "5 mm", beads="2:")],
        scatter=scatter,
    )  # fmt: skip
    found = hc.design(problem, budget=200, seed=2)
    gaps = _gaps(2 + 1_000_003, 40, ROW.beads)
    gaps[:, 0] = 0.0
    peaks = _peaks([found.chain.replace(gaps=row) for row in gaps])
    assert found.verified.scattered["mean of wall_force.peak"] == pytest.approx(
        np.mean(peaks), rel=1e-6
    )


def test_scatter_command(run) -> None:
    options = ["--material", "steel-52100", "--diameter", "10mm", "--beads", "8", "--speed",
               "0.1m/s", "--wall", "same", "--striker", "1"]  # fmt: skip
    out = run("scatter", *options, "--gaps", "5um", "--chains", "5", "--json").stdout
    expected = hc.distribution(ROW, "wall_force.peak", hc.Scatter(gaps=SIZE, samples=5)).values
    np.testing.assert_allclose(json.loads(out)["values"], expected, rtol=1e-12)


def test_sensitivity_to_gaps_is_that_of_simulations(run) -> None:
    options = ["--material", "steel-52100", "--diameter", "10mm", "--beads", "8", "--speed",
               "0.1m/s", "--wall", "same", "--striker", "1", "--to", "gaps"]  # fmt: skip
    found = json.loads(run("sensitivity", *options, "--json").stdout)
    step, words = GAP_STEP["SI"]
    assert f"% for +{words}" in run("sensitivity", *options).stdout
    nominal, *peaks = _peaks(
        [ROW, *(ROW.replace(gaps=row) for row in step * np.eye(ROW.beads - 1))]
    )
    np.testing.assert_allclose(
        found["change_if_larger"], np.array(peaks) / nominal - 1.0, atol=1e-6
    )
    assert found["gradient_unit"] == "N/m"


def test_titles_name_the_gaps() -> None:
    scatter = hc.Scatter(radius="1%", gaps=SIZE, samples=2)
    title = hc.distribution(ROW, "wall_force.peak", scatter).plot().get_title()
    assert title.replace("\n", " ").endswith("1% scatter, random gaps (5 µm)")


def test_percentiles_far_from_the_nominal_value_are_in_the_legend() -> None:
    found = hc.distribution(ROW, "wall_force.peak", hc.Scatter(gaps="10 um", samples=150))
    axes = found.plot()
    factor = 1.0 if found.unit == "N" else 1e-3
    labels = legend_texts(axes)
    # With four digits, two of them would coincide.
    values = ", ".join(f"{factor * found.percentile(each):.4f}" for each in (5.0, 50.0, 95.0))
    assert any(each.startswith(f"5%, median, 95%: {values}") for each in labels)
    assert any(each.startswith("mean: ") for each in labels)
    # No label stands at a line, where it could cover another.
    assert not axes.texts
