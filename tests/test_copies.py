"""Copies, pickles, pages and files of everything public: equal, read-only, and escaped."""

import copy
import math
import pickle
import tomllib

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.fitting.loss_comparison import LossFit
from hertzchain.frozen import Frozen
from hertzchain.simulation.state import fingerprint
from hertzchain.store import chain_as_toml as writer
from hertzchain.store import chain_files
from hertzchain.theory.wave_profile import WaveProfile

WAYS_TO_COPY = {
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
    "pickle": lambda item: pickle.loads(pickle.dumps(item)),
}


@pytest.fixture(scope="module")
def everything(tmp_path_factory):
    """An object of each public type."""
    folder = tmp_path_factory.mktemp("copies")
    balls = hc.Chain.from_materials(5e-3, "brass", beads=6, velocity=0.01)
    chain = hc.Chain.uniform(6).replace(right_wall=hc.Wall())
    run = hc.simulate(chain, until=40.0, times=400)
    long = hc.simulate(hc.Chain.uniform(20), until=40.0, times=400)
    pulse = hc.bca(hc.Chain.uniform(6))
    traces, file = hc.example_experiment()
    fit = hc.fit(traces, file)
    measured = hc.simulate(hc.load_chain(file), until=6e-4, times=1201)
    radii = hc.vary.radii(0.5, 1.0, by="common")
    problem = hc.Design(hc.Chain.uniform(4), maximise="velocity@last", vary=[radii])
    found = [
        hc.forecast(balls, ["ball 4"], noise=1e-3, interval="1 us", free=["stiffness"]),
        traces, fit, hc.scan_defects(fit), measured.compare(traces),
        hc.LossComparison(fits=(LossFit("viscoelastic", fit, bic=1.0),)),
        hc.Posterior(("gain",), np.ones((3, 1)), 0.3, np.nan, 4, np.ones((1, 2)), ("",)),
        chain, balls, hc.Chain.tapered("forward-linear", 0.05, beads=5), run, run.state,
        run.budget(), run.wall_force("right"), run.sensor_force(3), run.waves(), run.waves()[0],
        run.waves()[0].events[0], run.velocity_peaks(3), run.fronts(), run.leading_pulse(),
        run.energy_flux(), run.horizon(), long.reflection(5, 15), pulse, pulse.compare(pulse),
        hc.propagate_many([[1.0, 1.0], [1.0, 0.9]]), hc.simulate_many([chain]),
        hc.gradient(chain, "wall_force.peak"),
        hc.distribution(chain, "velocity@3", hc.Scatter(radius=0.01, samples=3)),
        hc.solitary_wave(),
        hc.solitary_wave().velocity, hc.effective_chain(hc.Chain.uniform(5).decorated(0.2)),
        hc.equilibrium(chain), hc.hertz_range(balls), hc.Scales.of(balls), hc.material("brass"),
        hc.Wall(gap="1 um"), hc.Restitution(0.9), hc.Viscoelastic("1 us"), hc.UnloadingRatio(0.1),
        hc.VelocityPower(0.1, 1.5), hc.Dashpot(0.1), hc.WaltonBraun(0.9), hc.StepDrive(1.0),
        hc.Elastic(), hc.ElasticPlastic(yield_overlap=0.1), hc.Cone(60.0), hc.CrossedCylinders(),
        hc.Pad(1e6), hc.SineBurst(1.0, 2.0), hc.TableDrive([0.0, 1.0], [0.0, 1.0]),
        hc.stream(chain, folder / "run", times=[1.0, 2.0]), hc.InputError("a"),
        hc.SimulationError("b"), hc.StoreError("c"), hc.ModelRangeWarning("d"),
        hc.DamageWarning("e"), hc.IncompleteWarning("f"),
        hc.spectrum(chain.replace(precompression=1.0, held_by="force")),
        hc.InputWarning("e"), hc.effective_chain(hc.Chain.uniform(5).decorated(0.2)).bca(),
        hc.scoreboard(theories=["hard-sphere"]), hc.verify(groups=["restitution"])[0],
        hc.calibrate("backward-linear", rates=(0.5,), beads=30, window=(5, 25)),
        problem, hc.design(problem, budget=150), hc.Scatter(radius=0.01),
    ]  # fmt: skip
    return {type(item).__name__ + str(place): item for place, item in enumerate(found)}


@pytest.mark.long
def test_no_public_type_is_left_out(everything):
    types = {getattr(hc, name) for name in hc.__all__ if isinstance(getattr(hc, name), type)}
    assert types <= {type(item) for item in everything.values()}


def arrays(item, depth=0):
    """Arrays in what a copy of an object is made from, by path."""
    state = item.__getstate__() if hasattr(item, "__getstate__") else None
    for name, value in state.items() if isinstance(state, dict) else ():
        if isinstance(value, np.ndarray):
            yield name, value
        elif depth < 2:
            yield from ((f"{name}.{path}", each) for path, each in arrays(value, depth + 1))


@pytest.mark.parametrize("way", WAYS_TO_COPY)
def test_copies_are_equal_and_read_only(everything, way):
    for name, item in everything.items():
        again = WAYS_TO_COPY[way](item)
        assert type(again) is type(item)
        assert repr(again) == repr(item), name
        one, other = dict(arrays(item)), dict(arrays(again))
        assert one.keys() == other.keys()
        for path, values in one.items():
            np.testing.assert_array_equal(values, other[path])
            assert values.flags.writeable == other[path].flags.writeable, (name, path)


@pytest.mark.parametrize("way", WAYS_TO_COPY)
def test_a_copied_chain_cannot_be_changed(way):
    chain = hc.Chain.from_materials(5e-3, "brass", beads=3, drive=hc.TableDrive([0, 1], [0, 1]))
    again = WAYS_TO_COPY[way](chain)
    assert fingerprint(again) == fingerprint(chain)
    for values in (again.radii, again.masses, again.velocities, again.drive.values):
        with pytest.raises(ValueError, match="read-only"):
            values[0] = 9.0


@pytest.mark.parametrize("way", WAYS_TO_COPY)
def test_copies_remember_their_units(way):
    for name, part in (("right_wall", hc.Wall(gap="1 um")), ("drive", hc.StepDrive("5 N"))):
        with pytest.raises(hc.InputError, match="scaled variables"):
            hc.Chain.uniform(3).replace(**{name: WAYS_TO_COPY[way](part)})


@pytest.mark.filterwarnings("ignore::hertzchain.errors.IncompleteWarning")
def test_a_copied_table_still_says_why_chains_failed():
    table = copy.deepcopy(hc.propagate_many([[1.0, 1.0], [1.0, -1.0]]))
    assert "radius of bead 2" in table.reasons[1]
    with pytest.raises(TypeError):
        table.reasons[1] = "nothing"


NAMES = [
    "<img src=x onerror=alert(1)>", "a & b", '"quoted"', r"$\frac$", "cost $5", "stål 🔩",
    "a.b [c]", r"back\slash", "x" * 300, "#", " ", "'''",
]  # fmt: skip


def named(name):
    steel = hc.Material(name, density=7800.0, young=2e11, poisson=0.3, source=f"{name}\n\x7f")
    return hc.Chain.from_materials(5e-3, steel, beads=3, right_wall=hc.Wall.of(steel))


@pytest.mark.parametrize("name", NAMES)
def test_names_of_any_kind_can_be_shown_and_written(name, tmp_path):
    chain = named(name)
    path = tmp_path / "chain.toml"
    path.write_text(hc.chain_as_toml(chain), "utf-8")
    again = hc.load_chain(path)
    assert again.materials == chain.materials
    assert fingerprint(again) == fingerprint(chain)
    assert "<img" not in hc.Pulse(chain, name, velocity=np.ones(3))._repr_html_()


@pytest.mark.long
@pytest.mark.parametrize("name", [r"$\frac$", "$5 or $6"])
def test_no_name_is_taken_for_mathematics(name):
    chain = named(name)
    run = hc.simulate(chain, until=1e-5, times=9)
    pulse = hc.Pulse(chain, name, velocity=np.ones(3))
    for axes in (pulse.plot(), run.plot(), hc.plot_chain(chain), run.budget().plot()):
        axes.figure.canvas.draw()
        assert axes.get_title().replace(r"\$", "$").replace("\n", " ").count(name) == 1


def test_a_page_escapes_the_method():
    pulse = hc.Pulse(hc.Chain.uniform(3), "<script>alert(1)</script>", velocity=np.ones(3))
    assert "<script" not in pulse._repr_html_()
    assert "&lt;script&gt;" in pulse._repr_html_()


@pytest.mark.parametrize("name", ["a\nb", "a\x7f", "\ud800", "tab\t", "\0", "\x9b"])
def test_names_that_no_file_can_carry_are_rejected(name):
    with pytest.raises(hc.InputError, match=r"character \d of .* is U\+") as caught:
        named(name)
    str(caught.value).encode()
    with pytest.raises(hc.InputError, match="source of a material"):
        hc.Material("a", 1.0, 1.0, 0.3, source="\ud800")


STEEL = hc.Material("steel", 7800.0, 200e9, 0.3)
SOFT = hc.Material("steel", 7800.0, 50e9, 0.3)
THIRD = hc.Material("steel (2)", 7800.0, 100e9, 0.3)


@pytest.mark.parametrize(
    "chain",
    [
        hc.Chain.from_materials(5e-3, STEEL, beads=4, right_wall=hc.Wall.of(SOFT)),
        hc.Chain.from_materials([5e-3] * 4, [STEEL, SOFT, THIRD, STEEL]),
        hc.Chain.from_materials([5e-3] * 3, [THIRD, STEEL, SOFT], right_wall=hc.Wall.of(STEEL)),
    ],
)
def test_materials_of_one_name_stay_two(chain):
    again = chain_files.chain_from(tomllib.loads(hc.chain_as_toml(chain)))
    assert fingerprint(again) == fingerprint(chain)
    young = [each.young for each in chain.materials]
    assert [each.young for each in again.materials] == young
    assert len({each.name for each in again.materials}) == len(set(young))


def test_a_sweep_of_materials_of_one_name_is_that_of_the_chain():
    """Beads of 200 GPa against a plate of 50 GPa, both called steel."""
    chain = hc.Chain.from_materials(5e-3, STEEL, beads=4, velocity=1.0)
    hard, soft = (chain.replace(right_wall=hc.Wall.of(each)) for each in (STEEL, SOFT))
    peaks = [hc.simulate(each, until=2e-4).wall_force("right").peak for each in (hard, soft)]
    assert not math.isclose(*peaks, rel_tol=0.1)
    found = hc.sweep({
        "chain": soft, "axes": {"gravity": [0.0]}, "method": {"until": 2e-4},
        "sweep": {"methods": ["simulate"], "keep": ["wall_peak_force"]},
    })  # fmt: skip
    assert found.wall_peak_force.item() == pytest.approx(peaks[1], rel=1e-11)


def test_a_scaled_chain_of_known_materials_stays_scaled():
    balls = hc.Chain.from_materials(5e-3, "brass", beads=4, velocity=0.5)
    scaled = hc.Scales.of(balls, velocity=1.0).to_scaled(balls)
    again = chain_files.chain_from(tomllib.loads(hc.chain_as_toml(scaled)))
    assert again.units == "scaled"
    assert fingerprint(again) == fingerprint(scaled)


def test_given_contacts_of_a_chain_of_materials_are_written():
    chain = hc.Chain.from_materials(
        5e-3, "brass", beads=3, exponent=2.0, stiffness=1e12, velocity=0.1
    )
    again = chain_files.chain_from(tomllib.loads(hc.chain_as_toml(chain)))
    assert fingerprint(again) == fingerprint(chain)


def test_a_chain_that_cannot_be_written_is_rejected(monkeypatch):
    chain = hc.Chain.uniform(3).replace(gaps=[0.1, 0.2])
    monkeypatch.setattr(writer, "ARRAYS", ("masses",))
    with pytest.raises(hc.InputError, match="cannot be written .* moves differently"):
        hc.chain_as_toml(chain)


@pytest.mark.parametrize("way", WAYS_TO_COPY)
def test_copies_are_equal_and_have_the_same_hash(everything, way):
    compared = 0
    for name, item in everything.items():
        # Functions, such as those of a wave profile, are compared by identity.
        frozen = isinstance(item, Frozen) and type(item).__eq__ is Frozen.__eq__
        if frozen and not isinstance(item, WaveProfile):
            again = WAYS_TO_COPY[way](item)
            assert again == item, name
            assert hash(again) == hash(item), name
            compared += 1
    assert compared > 5


def test_chains_are_equal_if_all_fields_are():
    chain = hc.Chain.uniform(5)
    assert chain == hc.Chain.uniform(5)
    assert {chain: 1}[hc.Chain.uniform(5)] == 1
    wall, drive = hc.Wall(), hc.TableDrive([0.0, 1.0], [0.0, 2.0])
    full = chain.replace(right_wall=wall, gaps=[0.0, -0.0, 0.1, 0.0], loss=hc.Restitution(0.9))
    same = chain.replace(right_wall=hc.Wall(), gaps=[-0.0, 0.0, 0.1, 0.0], loss=hc.Restitution(0.9))
    assert full == same
    assert hash(full) == hash(same)
    moved = chain.replace(drive=drive)
    assert moved == chain.replace(drive=hc.TableDrive([0.0, 1.0], [0.0, 2.0]))
    others = [
        hc.Chain.uniform(6), hc.Chain.uniform(5, exponent=2.0), full, chain.replace(gravity=0.1),
        chain.replace(masses=np.ones(5)), chain.replace(strikers=1), moved,
        chain.replace(drive=hc.TableDrive([0.0, 1.0], [0.0, 3.0])), chain.replace(right_wall=wall),
        hc.Chain.from_materials(1.0, "brass", beads=5), chain.replace(velocities=[2.0, 0, 0, 0, 0]),
    ]  # fmt: skip
    for i, one in enumerate(others):
        assert one != chain
        assert chain not in others
        assert all(one != other for other in others[i + 1 :])
    assert chain != "chain"


@pytest.mark.filterwarnings("ignore::hertzchain.errors.IncompleteWarning")
def test_results_are_compared_by_their_values():
    chain = hc.Chain.uniform(8)
    assert hc.propagate(chain) == hc.propagate(hc.Chain.uniform(8))
    assert hc.propagate(chain) != hc.bca(chain)
    # Entries of chains that failed are NaN.
    tables = [hc.propagate_many([[1.0, 1.0], [1.0, -1.0]]) for _ in range(2)]
    assert tables[0] == tables[1]
    assert tables[0] != hc.propagate_many([[1.0, 1.0], [1.0, 1.0]])


def test_a_row_of_a_table_does_not_compute_quantities_of_all_chains(monkeypatch):
    """A loop over the rows would take a time proportional to the square of their number."""
    table = hc.propagate_many([[1.0, 1.0, 1.0], [1.0, 2.0, 1.0]])
    momentum = table.momentum[1]

    def fail(_):
        raise AssertionError

    monkeypatch.setattr(type(table), "masses", property(fail))
    assert table[1].momentum == pytest.approx(momentum)


def test_equal_runs_and_their_results_are_equal():
    chain = hc.Chain.uniform(6).replace(right_wall=hc.Wall())
    run, again, other = (hc.simulate(chain, times=n) for n in (200, 200, 199))
    assert run == again != other
    assert hash(run) == hash(again)
    assert run.state == again.state
    for way in WAYS_TO_COPY.values():
        assert way(run) == run
        for name in ("waves", "budget", "horizon", "leading_pulse", "fronts", "wall_force"):
            result = getattr(run, name)()
            assert way(result) == result, name
    changed = copy.deepcopy(run)
    changed.velocities[-1, -1] += 1.0
    assert changed != run
    assert hash(changed) == hash(run)
