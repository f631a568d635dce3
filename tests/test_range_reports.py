"""Every command and function reports once that chains are outside the range of Hertz's law."""

import json
import math
import warnings

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.derivatives.gradient import _recorded

WALLED = ["--material", "ptfe", "--diameter", "10 mm", "--beads", "10", "--wall", "same"]


def row(speed=0.5, **fields):
    return hc.Chain.from_materials(5e-3, "ptfe", beads=12, velocity=speed).replace(**fields)


def walled(speed=0.5, **fields):
    return row(speed, right_wall=hc.Wall.of("ptfe"), **fields)


def warned(function):
    """Result of a function, and messages of its warnings about ranges."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        found = function()
    return found, [str(each.message) for each in caught if each.category is hc.ModelRangeWarning]


def scattered(chain):
    return hc.distribution(chain, "velocity@12", hc.Scatter(radius=0.01, samples=8))


# Yield begins at 2.63 times lower pressure, which is proportional to the speed to the power 2/5.
SLOW, FAST = 0.5 / 2.63**2.5 / 1.3, 0.5

REPORTS = {
    "gradient of the pulse": lambda v: hc.gradient(row(v), "pulse.velocity@12"),
    "gradient of the wall": lambda v: hc.gradient(walled(v), "wall_force.peak"),
    "gradient with damping": lambda v: hc.gradient(
        row(v, loss=hc.Viscoelastic(1e-7)), "pulse.velocity@12"
    ),
    "local_rate_gradient": lambda v: hc.local_rate_gradient(row(v), "velocity", bead=12),
    "disorder": lambda v: hc.disorder(row(v), 0.01),
    "attenuation": lambda v: hc.attenuation(row(v, loss=hc.Restitution(0.99)), velocity=v),
    "distribution": lambda v: scattered(row(v)),
    "distribution with losses": lambda v: scattered(row(v, loss=hc.Restitution(0.99))),
    "sweep": lambda v: hc.sweep({
        "chain": {"diameters": "10 mm", "materials": "ptfe", "velocity": v},
        "axes": {"beads": [12, 14]},
        "sweep": {"methods": ["simulate"], "keep": ["velocity"], "at": "last"},
    }),
}  # fmt: skip


@pytest.mark.parametrize("name", REPORTS)
def test_results_outside_the_range_of_hertz_law_warn_once(name):
    _, messages = warned(lambda: REPORTS[name](FAST))
    limits = [each for each in messages if "pressure / yield" in each or "points are" in each]
    assert len(limits) == 1
    _, messages = warned(lambda: REPORTS[name](SLOW))
    assert messages == []


@pytest.mark.parametrize("chain", [row(), walled(), row(loss=hc.Viscoelastic(1e-7))])
def test_overlaps_of_gradients_are_those_of_the_run(chain):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hc.ModelRangeWarning)
        run = hc.simulate(chain, until=3e-3)
        reader, *_ = _recorded(chain, ["final.velocity@1"], to="radii", until=3e-3)
    found = reader.record.largest_overlaps()
    # Overlaps between the stages of steps are larger by less than this.
    assert np.allclose(found, run.largest_overlaps, rtol=2e-3, atol=0.0)
    assert (found[-1] > 0.0) == (chain.right_wall is not None)


def test_distributions_count_chains_outside_the_range():
    # The chain without deviations is just inside the range; about half of the others are not.
    speed = 0.5
    for _ in range(40):
        if not warned(lambda v=speed: hc.propagate(row(v)))[1]:
            break
        speed *= 0.9
    low, high = speed, speed / 0.9
    for _ in range(20):
        middle = 0.5 * (low + high)
        inside = not warned(lambda v=middle: hc.propagate(row(v)))[1]
        low, high = (middle, high) if inside else (low, middle)
    found, messages = warned(lambda: hc.distribution(
        row(low), "velocity@12", hc.Scatter(radius=0.01, samples=40)
    ))  # fmt: skip
    chains = hc.Scatter(radius=0.01, samples=40).sample(row(low), 1)
    expected = sum(bool(warned(lambda c=chain: hc.propagate(c))[1]) for chain in chains)
    assert 0 < expected < 40
    assert found.outside_range == pytest.approx(expected, abs=1)
    assert f"{found.outside_range} chains outside Hertz's range" in " ".join(repr(found).split())
    (message,) = messages
    assert message.startswith(f"{found.outside_range} of 40 random chains exceed the limits")
    # From single runs; the first chain outside the range is another one.
    ratios = [
        hc.hertz_range(chain, run.largest_overlaps).largest_yield_ratio
        for chain in chains
        if (run := warned(lambda c=chain: hc.simulate(c))[0])
    ]
    worst = 1 + int(np.argmax(ratios))
    assert worst > 1 + next(i for i, ratio in enumerate(ratios) if ratio > 1.0)
    assert f"in the worst, random chain {worst}, pressure / yield is" in message


@pytest.mark.filterwarnings("default::hertzchain.ModelRangeWarning")
@pytest.mark.parametrize("command", [["scatter", "--scatter", "1%", "--chains", "5"],
                                     ["sensitivity"]])  # fmt: skip
def test_commands_report_the_range_once(command, run):
    code, _, err = run(*command, *WALLED, "--speed", "0.5 m/s")
    assert code == 0
    assert err.count("pressure / yield is 2.63 at contact 1") == 1
    _, _, err = run(*command, *WALLED, "--speed", "5 mm/s")
    assert "Warning" not in err


@pytest.mark.filterwarnings("default::hertzchain.ModelRangeWarning")
def test_the_document_of_scatter_counts_chains_outside_the_range(run):
    options = ["scatter", "--scatter", "1%", "--chains", "5", "--json", "--speed", "0.5 m/s"]
    _, out, _ = run(*options, *WALLED)
    assert json.loads(out)["outside_range"] == 5


def test_values_of_scatter_are_printed_as_csv(run):
    options = ["scatter", *WALLED, "--speed", "5 mm/s", "--scatter", "1%", "--chains", "5"]
    _, out, _ = run(*options, "--csv")
    header, *rows = out.splitlines()
    assert header == "wall_force.peak [N]"
    assert [float(row) for row in rows] == json.loads(run(*options, "--json")[1])["values"]


@pytest.mark.filterwarnings("ignore::hertzchain.errors.ModelRangeWarning")
def test_tables_of_runs_state_the_number_of_chains_outside_the_range():
    table = hc.simulate_many([walled(FAST), walled(SLOW)])
    assert "1 of 2 chains outside Hertz's range:" in " ".join(repr(table).split())
    assert table.exceeded_limits(0)[0].startswith("pressure / yield is 2.63 at contact 1")
    assert table.exceeded_limits(1) == ()
    assert "range" not in repr(hc.simulate_many([hc.Chain.uniform(5)]))


# The wave from the wall loads contacts more than the leading pulse.
REFLECTED = np.array([6.35, 6.35, 4.0, 4.0, 6.35, 3.0, 4.0, 3.0, 4.0]) * 0.5e-3


def reflecting(velocity, **more):
    chain = hc.Chain.from_materials(REFLECTED, "steel-52100", velocity=velocity)
    return chain.replace(right_wall=hc.Wall.of("steel-52100"), **more)


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
@pytest.mark.parametrize("loss", [{}, {"loss": hc.Restitution(0.999)}], ids=["elastic", "lossy"])
def test_tables_of_runs_check_reflected_waves(loss):
    """References: runs of `simulate`."""
    chains = [reflecting(each, **loss) for each in (0.2, 0.3, 0.4)]
    table = hc.simulate_many(chains, keep=["yield_ratio", "peak_overlap"], rtol=1e-10)
    ratios = [
        hc.hertz_range(each, hc.simulate(each, times=2000, rtol=1e-11).largest_overlaps).yield_ratio
        for each in chains
    ]
    assert table["yield_ratio"] == pytest.approx(np.max(ratios, axis=1), rel=1e-6)
    assert table.outside_range.tolist() == [False, True, True]
    leading = hc.hertz_range(chains[1], table["peak_overlap"][1]).yield_ratio.max()
    assert leading < 1.0 < table["yield_ratio"][1]
    assert table.to_dataframe()["outside_range"].tolist() == [False, True, True]
    assert table.to_xarray()["outside_range"].values.tolist() == [False, True, True]
    found = hc.simulate_many(chains).outside_range
    assert found.tolist() == [False, True, True]


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
def test_sweeps_check_reflected_waves():
    """The flag is set where `simulate` warns, and values of the whole run are kept."""
    speeds = [0.2, 0.25, 0.3, 0.4]
    found = hc.sweep({
        "chain": reflecting(0.2), "axes": {"velocity": speeds},
        "sweep": {"methods": ["simulate"], "keep": ["yield_ratio", "largest_overlap"]},
    })  # fmt: skip
    runs = [warned(lambda v=each: hc.simulate(reflecting(v))) for each in speeds]
    expected = [bool(messages) for _, messages in runs]
    assert expected == [False, True, True, True]
    assert found.outside_range.values[:, 0].astype(bool).tolist() == expected
    for i, (run, _) in enumerate(runs):
        assert found.largest_overlap.values[i, 0] == pytest.approx(
            run.largest_overlaps[1:-1], rel=1e-6
        )
        ratio = hc.hertz_range(run.chain, run.largest_overlaps).yield_ratio.max()
        assert found.yield_ratio.values[i, 0] == pytest.approx(ratio, rel=1e-6)


def test_designs_state_that_the_range_is_exceeded():
    problem = hc.Design(
        walled(), minimise="wall_force.peak", vary=[hc.vary.radii(4e-3, 6e-3, by="common")]
    )
    assert "outside Hertz's range" in " ".join(repr(hc.design(problem, budget=20)).split())


def isolated_pressure(radius, velocity, *, wall=False):
    """Pressure over that at first yield of a collision of two balls of steel, or with a plate.

    Johnson, Contact Mechanics, Eqs. (4.22) to (4.24), with first yield at 1.6 Y.
    """
    steel = hc.material("steel-52100")
    modulus = 0.5 * steel.young / (1.0 - steel.poisson**2)
    effective = radius if wall else radius / 2
    mass = steel.density * 4 / 3 * np.pi * radius**3
    energy = (0.5 if wall else 0.25) * mass * velocity**2
    overlap = (2.5 * energy / (4 / 3 * modulus * effective**0.5)) ** 0.4
    return 2 / np.pi * modulus * (overlap / effective) ** 0.5 / 1.6 / steel.yield_strength


def pressure_line(out):
    (line,) = [each for each in out.splitlines() if each.startswith("pressure / yield")]
    return line


@pytest.mark.parametrize("speed", [0.001, 0.1, 0.2])
def test_runs_state_the_largest_pressure_below_yield(speed, run):
    balls = ("--material", "steel-52100", "--diameter", "10 mm", "--beads", "2")
    code, out, err = run("simulate", *balls, "--speed", f"{speed} m/s")
    assert (code, err) == (0, "")
    expected = isolated_pressure(5e-3, speed)
    line = pressure_line(out)
    assert line == f"pressure / yield {expected:.2g} at contact 1 (limit of Hertz's law: 1)"


def test_the_largest_pressure_may_be_at_the_wall(run):
    balls = ("--material", "steel-52100", "--diameter", "10 mm", "--beads", "2", "--wall", "rigid")
    _, out, _ = run("simulate", *balls, "--speed", "0.1 m/s")
    assert "at the right wall (limit of Hertz's law: 1" in pressure_line(out)


@pytest.mark.filterwarnings("default::hertzchain.ModelRangeWarning")
def test_no_pressure_over_yield_is_stated_if_it_is_unknown(run, tmp_path):
    _, out, _ = run("simulate", "--taper", "uniform", "--beads", "4")
    assert "pressure" not in out
    balls = ("--material", "steel-52100", "--diameter", "10 mm", "--beads", "2")
    _, out, err = run("simulate", *balls, "--speed", "1 m/s")
    line = f"pressure / yield {isolated_pressure(5e-3, 1.0):.2g} at contact 1"
    assert pressure_line(out) == f"{line} (limit of Hertz's law: 1, exceeded)"
    assert "pressure / yield is" in err
    soft = "density = 7800\nyoung = 2e11\npoisson = 0.3\n"
    (tmp_path / "row.toml").write_text(
        '[chain]\nradii = 0.005\nbeads = 2\nmaterial = "soft"\nvelocity = 0.1\n[materials.soft]\n'
        + soft
    )
    code, out, _ = run("simulate", tmp_path / "row.toml")
    assert code == 0
    assert "pressure / yield" not in out
    # Johnson, Contact Mechanics, Eqs. (11.20) and (4.24), of two equal spheres.
    mass, modulus, radius = 0.5 * 7800 * 4 / 3 * math.pi * 0.005**3, 2e11 / (2 * 0.91), 0.0025
    overlap = (15 * mass * 0.1**2 / (16 * modulus * radius**0.5)) ** 0.4
    pressure = 2 * modulus / math.pi * (overlap / radius) ** 0.5
    assert f"; their pressure (up to {pressure / 1e9:.2g} GPa) is not checked" in out


@pytest.mark.long
def test_fits_state_the_largest_pressure_of_all_shots(run):
    traces, chain_file = hc.example_experiment("fast", "slow")
    folder = chain_file.parent
    code, out, err = run("fit", folder / "fast.csv", folder / "slow.csv", chain_file)
    assert code == 0, err
    fitted = hc.fit(traces, chain_file).chains
    ratios = []
    for chain, shot in zip(fitted, traces.shots, strict=True):
        run_of_shot = hc.simulate(chain, until=float(np.ptp(shot.times)))
        ratios.append(hc.hertz_range(chain, run_of_shot.largest_overlaps).yield_ratio.max())
    assert len(ratios) == 2
    assert float(pressure_line(out).split()[3]) == pytest.approx(max(ratios), abs=0.006)
    speeds = [float(chain.velocities[0]) for chain in fitted]
    # The pressure is proportional to the speed to the power 2/5; precompression is absent.
    assert min(ratios) / max(ratios) == pytest.approx((min(speeds) / max(speeds)) ** 0.4, rel=0.02)


def test_pressure_over_yield_is_unknown_without_a_yield_strength():
    """Glass has none in the catalogue; the harder body of a contact with steel does not yield."""
    glass = hc.Chain.from_materials(5e-3, "glass", beads=4, velocity=0.1)
    found = hc.hertz_range(glass.replace(right_wall=hc.Wall()))
    assert np.isnan(found.yield_ratio).all()
    assert np.isnan(found.largest_yield_ratio)
    assert "pressure / yield  unknown" in str(found)
    assert "pressure / yield unknown" in repr(found)
    assert "unknown" in found._repr_html_()
    assert not found.violations
    table = hc.simulate_many([glass], keep=["yield_ratio"])
    assert np.isnan(table["yield_ratio"][0])
    mixed = hc.Chain.from_materials(5e-3, ["steel-52100", "glass", "glass"], velocity=1.0)
    steel = hc.hertz_range(mixed)
    assert np.isnan(steel.yield_ratio[2])
    assert steel.largest_yield_ratio == steel.yield_ratio[1] > 0.0
    with pytest.raises(
        hc.InputError,
        match="yield_ratio is unknown, because no elastic contact has a known yield strength",
    ):
        hc.Design(glass, minimise="velocity@last", vary=[hc.vary.radii("3 mm", "6 mm")],
                  subject_to={"yield_ratio": "<= 1"})  # fmt: skip


def test_designs_do_not_claim_limits_that_are_unknown():
    """The contacts of steel with glass and with the wall are checked, those of glass are not."""
    materials = ["steel-52100", "glass", "glass"]
    chain = hc.Chain.from_materials(5e-3, materials, velocity=0.01)
    chain = chain.replace(right_wall=hc.Wall.of("steel-52100"))
    found = hc.design(
        hc.Design(chain, minimise="wall_force.peak", vary=[hc.vary.radii("4 mm", "6 mm")]),
        budget=100,
    )
    text = found.summary()
    assert "no known limit of Hertz's law was exceeded (see the notes)" in text
    assert "all contacts" not in text
    assert "note: contacts of glass with glass have no known yield strength; their pressure" in text
    assert "steel-52100" not in text.partition("note: contacts of")[2].splitlines()[0]


def test_advice_of_an_unfinished_run_states_that_larger_overlaps_may_follow():
    balls = hc.Chain.from_materials("5 mm", "steel-52100", beads=10, velocity="1 m/s")
    with pytest.warns(hc.ModelRangeWarning, match="pressure / yield is 1.29") as early:
        run = hc.simulate(balls, until="10 us")
    assert run.beads_passed < 10
    (said,) = (str(each.message) for each in early)
    assert said.endswith(
        f"this is the largest value so far: the run ends when the pulse has passed "
        f"{run.beads_passed} of 10 beads, and a larger one may follow"
    )
    for until in ("0.3 ms", None):
        with pytest.warns(hc.ModelRangeWarning, match="pressure / yield is 1.4") as late:
            assert hc.simulate(balls, until=until).beads_passed == 10
        assert "so far" not in str(late[0].message)
