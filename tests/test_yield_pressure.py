"""The yield pressure of contacts: as a factor of the yield strength, and the range if assumed."""

import itertools
import json
import math
import re
from dataclasses import replace
from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np
import pytest

import hertzchain as hc
from hertzchain.chain.yield_pressure import assumes_pressure, note_on_soft_balls, with_factor
from hertzchain.plotting.designs import KINDS
from hertzchain.plotting.distributions import plot_at_both_pressures

pytestmark = pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
ROW = (
    "--material", "steel-52100", "--diameter", "10 mm:6 mm", "--beads", "4", "--speed", "1 m/s",
    "--wall", "aluminium", "--loss",
)  # fmt: skip
FULL = "elastic-plastic, factor=2.8"


def row(**more):
    chain = hc.Chain.tapered(
        first_diameter="10 mm", last_diameter="6 mm", beads=4, material="steel-52100"
    )
    return chain.replace(velocities=[1.0, 0, 0, 0], right_wall=hc.Wall.of("aluminium"), **more)


class Contact:
    """A contact by the formulas of Thornton, which remembers its largest overlap."""

    def __init__(self, one, other, radius, factor):
        modulus = 1.0 / sum((1.0 - m.poisson**2) / m.young for m in (one, other))
        self.pressure = factor * min(one.yield_strength, other.yield_strength)
        self.radius, self.largest = radius, 0.0
        self.k = 4.0 / 3.0 * modulus * math.sqrt(radius)
        self.at = radius * (0.5 * math.pi * self.pressure / modulus) ** 2

    def load(self, d):
        if d <= self.at:
            return self.k * max(d, 0.0) ** 1.5
        return self.k * self.at**1.5 + math.pi * self.pressure * self.radius * (d - self.at)

    def force(self, d):
        if d >= self.largest:
            self.largest = d
        if self.largest <= self.at or d >= self.largest:
            return self.load(d)
        peak, at_yield = self.load(self.largest), self.k * self.at**1.5
        # k of the larger radius: sqrt(R_p) = (k_H peak-area factor)^(1/2).
        area = ((2.0 * peak + at_yield) / (2.0 * math.pi * self.pressure)) ** 1.5
        modulus = 0.75 * self.k / math.sqrt(self.radius)
        k = 4.0 / 3.0 * modulus * math.sqrt(4.0 * modulus / (3.0 * peak) * area)
        dent = self.largest - (peak / k) ** (2.0 / 3.0)
        return k * max(d - dent, 0.0) ** 1.5


def peak_by_verlet(factor, step=1e-8, end=2e-4):
    """Peak on the wall of `row`, by velocity Verlet."""
    steel, wall = hc.material("steel-52100"), hc.material("aluminium")
    radii = 5e-3 * 0.6 ** (np.arange(4) / 3)
    masses = 4.0 / 3.0 * math.pi * steel.density * radii**3
    inner = [Contact(steel, steel, a * b / (a + b), factor) for a, b in itertools.pairwise(radii)]
    contacts = [*inner, Contact(steel, wall, radii[-1], factor)]
    u, v, largest = np.zeros(5), np.array([1.0, 0.0, 0.0, 0.0, 0.0]), 0.0

    def forces():
        return np.array([c.force(u[i] - u[i + 1]) for i, c in enumerate(contacts)])

    found = forces()
    for _ in range(round(end / step)):
        v[:4] += 0.5 * step * (np.append(0.0, found[:-1]) - found) / masses
        u += step * v
        found = forces()
        v[:4] += 0.5 * step * (np.append(0.0, found[:-1]) - found) / masses
        largest = max(largest, found[-1])
    return largest


@pytest.mark.parametrize("factor", [1.6, 2.8])
def test_a_factor_scales_the_yield_pressure_of_every_material(factor):
    law = hc.ElasticPlastic() if factor == 1.6 else hc.ElasticPlastic(factor=factor)
    peak = hc.simulate(row(loss=law)).wall_force().peak
    # Measured: 8e-8 and 1e-7, of the steps of the reference.
    assert peak == pytest.approx(peak_by_verlet(factor), rel=1e-6)


def test_a_factor_is_the_pressure_of_one_material():
    pair = hc.Chain.from_materials(5e-3, "steel-316", beads=2, velocity=0.1)
    pressure = 2.2 * hc.material("steel-316").yield_strength
    by_factor = hc.ElasticPlastic(factor=2.2).restitution(0.1, chain=pair)
    by_pressure = hc.ElasticPlastic(yield_pressure=pressure).restitution(0.1, chain=pair)
    assert by_factor == pytest.approx(by_pressure, rel=1e-14)
    assert by_factor > hc.ElasticPlastic().restitution(0.1, chain=pair)


@pytest.mark.parametrize("other", ["yield_pressure", "yield_overlap"])
def test_a_factor_excludes_another_yield_point(other):
    with pytest.raises(hc.InputError, match=f"a factor or a {other}, not both"):
        hc.ElasticPlastic(factor=2.0, **{other: 1.0})
    with pytest.raises(hc.InputError, match="factor must be above 0"):
        hc.ElasticPlastic(factor=0.0)


def test_chain_files_keep_a_factor_and_sweeps_vary_it(tmp_path):
    chain = row(loss=hc.ElasticPlastic(factor=2.8))
    path = tmp_path / "row.toml"
    path.write_text(hc.chain_as_toml(chain))
    assert hc.load_chain(path).loss == chain.loss
    described = {
        "radii": 2e-3, "beads": 4, "materials": "steel-52100", "velocity": 1.0,
        "right_wall": {"material": "aluminium"}, "loss": {"law": "elastic-plastic"},
    }  # fmt: skip
    found = hc.sweep(
        {
            "chain": described,
            "sweep": {"methods": ["simulate"], "keep": ["wall_peak_force"]},
            "axes": {"loss.factor": {"list": [1.6, 2.8]}},
        }
    )
    for factor in (1.6, 2.8):
        one = hc.Chain.from_materials(
            2e-3, "steel-52100", beads=4, velocity=1.0, right_wall=hc.Wall.of("aluminium"),
            loss=hc.ElasticPlastic(factor=factor),
        )  # fmt: skip
        peak = float(found.wall_peak_force.sel(factor=factor).squeeze())
        assert peak == pytest.approx(hc.simulate(one).wall_force().peak, rel=1e-9)


def test_only_assumed_pressures_change():
    given, law = hc.ElasticPlastic("5 GPa"), hc.ElasticPlastic()
    full = hc.ElasticPlastic(factor=2.8)
    wall = hc.Wall(material="aluminium", loss=law)
    listed = row(loss=[law, given, None]).replace(right_wall=wall)
    assert assumes_pressure(listed)
    changed = with_factor(listed, 2.8)
    assert changed.loss == (full, given, None)
    assert changed.right_wall.loss == full
    assert not assumes_pressure(changed)
    pair = "steel-52100", "steel-52100"
    named = with_factor(row(loss={pair: given, "others": law}), 2.8)
    assert named.contact_losses[1:] == (given, given, given, full)
    for explicit in (given, full, hc.ElasticPlastic(factor=1.6), None):
        assert not assumes_pressure(row(loss=explicit))


def test_simulate_prints_the_range_of_an_assumed_pressure(run):
    code, out, err = run("simulate", *ROW, "elastic-plastic", "--sensor", "3")
    assert code == 0, err
    ends = [hc.simulate(row(loss=hc.ElasticPlastic(factor=f)), times=4000) for f in (1.6, 2.8)]
    low, high = (f"{each.wall_force().peak:.3g}" for each in ends)
    words = "for yield pressures of 1.6 to 2.8 times the yield strength"
    (line,) = (each for each in out.splitlines() if each.startswith("  right wall:"))
    assert line.startswith(f"  right wall: {low} to {high} N {words}")
    # The ball touches the wall several times.
    assert line.endswith("; values between can be outside this range")
    low, high = (f"{each.sensor_force(3).largest_so_far:.3g}" for each in ends)
    assert f"  sensor in bead 3: {low} to {high} N {words}\n" in out
    assert "times is possible (--loss 'elastic-plastic, factor=2.8')\n" in out
    document = json.loads(run("simulate", *ROW, "elastic-plastic", "--json").stdout)
    found = document["yield_pressure_range"]
    assert found["factors"] == [1.6, 2.8]
    (wall,) = found["ranges"]
    assert wall["name"] == "right wall"
    assert wall["values"] == pytest.approx([each.wall_force().peak for each in ends], rel=1e-9)


@pytest.mark.parametrize(
    ("loss", "speed"),
    [(FULL, "1 m/s"), ("elastic-plastic=3 GPa", "1 m/s"), ("elastic-plastic", "0.01 m/s")],
)
def test_there_is_no_range_of_a_given_pressure_or_without_yield(run, loss, speed):
    options = [speed if each == "1 m/s" else each for each in ROW] + [loss]
    assert "assumed" not in run("simulate", *options).stdout
    assert json.loads(run("simulate", *options, "--json").stdout)["yield_pressure_range"] is None


def test_long_chains_state_the_assumption_without_a_second_simulation(run, monkeypatch):
    monkeypatch.setattr("hertzchain.simulation.yield_range.MAX_BEADS", 3)
    out = run("simulate", *ROW, "elastic-plastic").stdout
    assert "the yield pressure is assumed to be 1.6" in out
    assert "for yield pressures of" not in out


def test_the_velocity_at_a_free_end_has_a_range(run):
    free = [*ROW[:-3], "--loss", "elastic-plastic"]
    ends = [
        hc.simulate(row(loss=hc.ElasticPlastic(factor=factor)).replace(right_wall=None))
        for factor in (1.6, 2.8)
    ]
    low, high = (f"{each.pulse().velocity[-1]:.4g}" for each in ends)
    words = f"in the leading pulse: {low} to {high} m/s for yield"
    out = run("simulate", *free).stdout
    assert words in out
    assert "after the impact" not in out
    box = row().replace(right_wall=None).with_cap("20 g")
    ends = [
        hc.simulate(box.replace(loss=hc.ElasticPlastic(factor=factor)), until=3e-3)
        for factor in (1.6, 2.8)
    ]
    out = run("simulate", *free, "--cap", "20 g", "--until", "3 ms").stdout
    after = (each.state.velocities[-1] for each in ends)
    pulse = (each.pulse().velocity[-1] for each in ends)
    for name, values in {"in the leading pulse": pulse, "after the impact": after}.items():
        low, high = (f"{each:.4g}" for each in values)
        assert f" (cap) {name}: {low} to {high} m/s for yield pressures" in out


def test_sensitivities_state_the_assumption(run):
    note = "is assumed to be 1.6 times the yield strength; up to 2.8 times is possible"
    out = run("sensitivity", *ROW, "elastic-plastic").stdout
    assert note in out
    assert "can change their order (--loss 'elastic-plastic, factor=2.8')" in out
    assert note not in run("sensitivity", *ROW, FULL).stdout


def test_random_chains_are_simulated_at_both_yield_pressures(run):
    command = ("scatter", "--scatter", "1%", "--chains", "4", *ROW)
    low, high = (
        hc.distribution(row(loss=hc.ElasticPlastic(factor=factor)), "wall_force.peak",
                        hc.Scatter(0.01, samples=4), seed=1)
        for factor in (1.6, 2.8)
    )  # fmt: skip
    assert high.nominal > 1.1 * low.nominal
    found = json.loads(run(*command, "elastic-plastic", "--json").stdout)
    other = found["at_fully_plastic_pressure"]
    for given, expected in ((found, low), (other, high)):
        values = [given["nominal"], given["mean"], given["percentiles"]["95"]]
        assert values == [expected.nominal, expected.mean, expected.percentile(95)]
    lines = run(*command, "elastic-plastic").stdout.splitlines()
    assert lines[2].endswith("yield 2.8 Y")
    assert lines[3].split() == ["nominal", f"{low.nominal:.2f}", "N", f"{high.nominal:.2f}", "N"]
    assert lines[-1].startswith("note: Y: yield strength")
    assert "2.8 Y" not in run(*command, FULL).stdout
    assumed = hc.distribution(row(loss=hc.ElasticPlastic()), "wall_force.peak",
                              hc.Scatter(0.01, samples=4), seed=1)  # fmt: skip
    assert "1.6 Y" in assumed.plot().get_title()
    axes = plot_at_both_pressures(assumed, high, ("low", "high"))
    assert "1.6 Y" not in axes.get_title()
    labels = axes.get_legend_handles_labels()[1]
    assert labels == [
        f"{name}: nominal {each.nominal:.2f} N, mean {each.mean:.2f} N"
        for name, each in (("low", low), ("high", high))
    ]
    assert axes.get_legend().get_title().get_text() == "contacts yield (Y: yield strength)"
    assert axes.get_ylabel() == "number of chains, of 4"
    edges = [np.array([[bar.get_x(), bar.get_x() + bar.get_width()] for bar in bars])
             for bars in axes.containers]  # fmt: skip
    assert np.array_equal(*edges)
    assert edges[0].min() == pytest.approx(assumed.values.min())
    assert edges[0].max() == pytest.approx(high.values.max())
    assert (axes.get_yticks() % 1.0 == 0.0).all()


@pytest.mark.parametrize(("law", "stated"), [
    (hc.ElasticPlastic(), "contacts yield at 1.6 Y (Y: yield strength)"),
    (hc.ElasticPlastic(factor=2.8), ""),
])  # fmt: skip
def test_the_history_of_a_design_states_the_yield_pressure(law, stated):
    found = SimpleNamespace(chain=row(loss=law), candidates=(), history=np.empty((0, 2)), unit="N",
                            _sign=1.0)  # fmt: skip
    assert KINDS["history"](found).get_title() == stated
    plt.close("all")


def test_causes_of_a_scatter_are_simulated_alone_and_sorted():
    chain = hc.Chain.uniform(3).replace(right_wall=hc.Wall())
    both = hc.Scatter(0.001, speed=0.03, samples=4)
    done = []
    found = hc.scatter_causes(
        chain, "wall_force.peak", both, progress=lambda *counts: done.append(counts)
    )
    assert done[-1] == (10, 10)
    assert list(found.alone) == ["speed +-3%", "0.1% scatter"]
    single = hc.distribution(chain, "wall_force.peak", hc.Scatter(0.001, samples=4))
    assert np.array_equal(found.alone["0.1% scatter"].values, single.values)
    assert found.to_dataframe().loc["0.1% scatter"].to_list() == [
        single.mean, single.standard_deviation, 0,
    ]  # fmt: skip
    assert "<td" in found._repr_html_()
    assert "% by speed +-3% alone" in repr(found)
    # The change of the yield pressure has its place among the causes.
    for factor, place in ((1.0, 3), (1.01, 2), (1.2, 1)):
        harder = replace(single, nominal=factor * single.nominal)
        lines = found._table(harder).splitlines()
        assert lines[0].strip().startswith("each cause alone, yield 1.6 Y")
        names = [line.split()[0] for line in lines[1:4]]
        assert names == [*(rest := ["speed", "0.1%"])[: place - 1], "yield", *rest[place - 1 :]]
        assert lines[place].split()[-1] == f"({100 * (factor - 1):+.3g}%)"
        assert "not random" in lines[4]
    assert "yield" not in str(found)
    with pytest.raises(hc.InputError, match="at least two causes.*got 0.1% scatter"):
        hc.scatter_causes(chain, "wall_force.peak", hc.Scatter(0.001))


def test_balls_with_the_strength_of_annealed_bars_have_a_note(run):
    note = "the yield strength of steel-304, 205 MPa, is the minimum of annealed bars"
    wall, steel = hc.Wall.of("steel-304"), hc.material("steel-304")

    def balls(kind, **more):
        return hc.Chain.from_materials("4 mm", kind, beads=3, right_wall=wall, **more)

    law = hc.ElasticPlastic()
    assert note_on_soft_balls(balls("steel-304", loss=law)).startswith(note)
    assert note_on_soft_balls(balls(steel.replace(name="mine"), loss=law))
    assert note_on_soft_balls(balls("steel-304"), yielding=True)
    # A wall is of bar, and a given yield pressure needs no strength.
    hard = steel.replace(yield_strength=800e6)
    for chain in (balls("steel-52100", loss=law), balls(hard, loss=law), balls("steel-304"),
                  balls("steel-304", loss=hc.ElasticPlastic(yield_pressure=3e9))):  # fmt: skip
        assert not note_on_soft_balls(chain)
    soft = ["--material", "steel-304", *ROW[2:-1]]
    # The summary of elastic contacts states the peak with contacts that yield.
    assert f"note: {note}" in " ".join(run("simulate", *soft).stdout.split())
    scatter = ("scatter", "--scatter", "1%", "--chains", "2", *soft)
    assert f"note: {note}" in " ".join(run(*scatter).stdout.split())


@pytest.mark.long
def test_designs_and_comparisons_share_the_assumption(run, tmp_path):
    chain = row(loss=hc.ElasticPlastic()).replace(materials=["steel-304"] * 4)
    note = "is assumed to be 1.6 times the yield strength"
    problem = hc.Design(chain, minimise="wall_force.peak", vary=[hc.vary.radii("3 mm", "5 mm")])
    summary = hc.design(problem, budget=82).summary()
    assert note in summary
    assert "note: the yield strength of steel-304, 205 MPa" in summary
    simulated = hc.simulate(chain, times=200, until="0.2 ms")
    path = tmp_path / "wall.csv"
    table = np.column_stack([simulated.times, simulated.sensor("wall")])
    np.savetxt(path, table, delimiter=",", header="time [s],wall [N]", comments="")
    (tmp_path / "row.toml").write_text(hc.chain_as_toml(chain))
    code, out, err = run("compare", path, tmp_path / "row.toml")
    assert code == 0, err
    assert note in out
    assert "use loss" not in out


LATE = """
[chain]
diameters = ["10 mm", "4 mm", "6 mm", "6 mm", "6 mm"]
materials = "steel-52100"
right_wall = {material = "steel-52100"}

[[chain.struck_by]]
mass = "2 g"
flat = true
velocity = "0.256 m/s"
"""


def test_a_peak_before_first_yield_is_the_same_with_contacts_that_yield(tmp_path, run):
    """The time is that of a run of contacts that yield, which has no dents before."""
    path = tmp_path / "late.toml"
    path.write_text(LATE)
    out = run("simulate", str(path)).stdout
    (time,) = re.findall(
        r"  peak with contacts that yield: the same; contacts first yield at (\S+) us, after this "
        r"peak\n", out,
    )  # fmt: skip
    assert "to 2.8 times the yield strength" not in out
    chain = hc.load_chain(path).replace(loss=hc.ElasticPlastic())
    before, after = (
        hc.simulate(chain, until=1e-6 * float(time) + shift) for shift in (-6e-7, 6e-7)
    )
    assert not before.dents.any()
    assert after.dents.any()
    assert hc.simulate(chain).wall_force().peak_time < 1e-6 * float(time)
