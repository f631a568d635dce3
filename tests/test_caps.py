"""Caps of load cells: flat last bodies of given mass, in chains whose other beads follow."""

import json
import math
import pickle

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import hertzchain as hc
from hertzchain.app.documents import chain_of, document_as_toml, document_of_chain, document_of_toml
from hertzchain.chain.bead_names import bead_label, with_bead_numbers
from hertzchain.chain.cap import Cap
from hertzchain.fitting.chain_parameters import with_sizes
from hertzchain.fitting.fitted_file import readable_chain
from hertzchain.fitting.names import Name
from hertzchain.plotting.chains import length_of
from hertzchain.plotting.titles import chain_words

STEEL = "steel-52100"
CELL = hc.Wall("5 kN/mm", exponent=1)
SIZES = np.array([5.0, 4.0, 6.0, 4.5, 5.5]) * 1e-3
HAMMER = {"mass": "50 g", "radius": "flat", "velocity": 0.01}


def balls(radii=SIZES, **fields):
    fields = {"right_wall": CELL} | fields
    return hc.Chain.from_materials(radii, STEEL, velocity=0.02, **fields)


def struck(chain, **striker):
    return chain.replace(velocities=None).struck_by(**(striker or HAMMER))


def peak(chain, **options):
    options = {"until": 1e-3 if chain.units == "SI" else 60.0} | options
    return hc.simulate(chain, **options).wall_force().peak


CHAINS = {
    "mass": balls().with_cap("5 g"),
    "material": balls().with_cap("5 g", material="brass"),
    "own material": balls().with_cap("5 g", material=hc.Material("x", 7000, 2e11, 0.3)),
    "stiffness": balls().with_cap("5 g", stiffness=1e9),
    "frequency": balls().with_cap(frequency="5 kHz"),
    "struck": struck(balls().with_cap("5 g")),
    "scatter": balls().with_cap("5 g").with_scatter(1, relative=0.01),
    "scatter first": balls().with_scatter(1, relative=0.01).with_cap("5 g"),
    "defect": struck(balls().with_cap("5 g")).with_defects(diameters={3: "8 mm"}),
    "masses": balls(masses=np.arange(1.0, 6.0) * 1e-3).with_cap("5 g"),
    "gap": balls().with_cap("5 g").replace(gaps=[0, 0, 0, 0, 1e-5]),
    "velocities": balls().with_cap("5 g").replace(velocities=[0.1, 0, 0, 0, 0.1, 0.2]),
    "losses": balls(loss=[hc.Restitution(0.9)] * 3 + [hc.Restitution(0.8)]).with_cap("5 g"),
    "loss": balls(loss=hc.Restitution(0.9)).with_cap("5 g"),
    "cone": balls().with_cap("5 g").with_contacts({5: hc.Cone(70)}),
    "compressed": hc.Chain.from_materials(SIZES, STEEL, left_wall=hc.Wall(), right_wall=CELL)
    .with_cap("5 g").replace(precompression=5.0),
    "weight": balls(gravity=9.81).with_cap("5 g"),
    "one ball": balls(SIZES[:1]).with_cap("5 g"),
    "free": balls(right_wall=None).with_cap("5 g"),
    "no materials": hc.Chain(SIZES, units="SI", masses=np.full(5, 1e-3), stiffness=[1e9] * 4)
    .with_cap("5 g", stiffness=3e9),
    "scaled": hc.Chain.uniform(5).with_cap(4.0),
    "scaled, struck": hc.Chain.uniform(5).with_cap(4.0).struck_by(mass=2.0, radius=1.0),
    "dimer": hc.Chain.dimer(0.3, beads=5).with_cap(4.0, stiffness=1.4),
}  # fmt: skip
EACH = pytest.mark.parametrize("chain", [pytest.param(each, id=name)
                                         for name, each in CHAINS.items()])  # fmt: skip


@pytest.mark.parametrize("striker", [{}, HAMMER | {"stiffness": 2e9}])
def test_a_cap_moves_like_a_last_bead_of_given_mass(striker):
    """As in the construction without `with_cap`: a bead of a given mass and contacts."""
    cap = balls().with_cap("5 g", material="brass")
    flat = balls(SIZES[-1:]).replace(right_wall=hc.Wall.of("brass")).wall_stiffness[1]
    row = hc.Chain.from_materials(
        [*SIZES, 1.0], [STEEL] * 5 + ["brass"], velocity=0.02, right_wall=CELL,
        masses=[*balls().masses, 5e-3], stiffness=[*balls().stiffness, flat],
    )  # fmt: skip
    if striker:
        cap, row = (struck(each, **striker) for each in (cap, row))
    assert cap.stiffness == pytest.approx(row.stiffness, rel=1e-14)
    assert cap.masses == pytest.approx(row.masses, rel=1e-14)
    one, other = (hc.simulate(each, until=5e-4, rtol=1e-11) for each in (cap, row))
    assert one.forces == pytest.approx(other.forces, rel=1e-9, abs=1e-9)


def test_a_ball_on_a_cap_agrees_with_scipy():
    """The equations of motion, written again with Hertz's stiffness of a sphere on a flat face."""
    chain = hc.Chain.from_materials("5 mm", STEEL, beads=1, velocity=0.05, right_wall=CELL)
    chain = chain.with_cap("5 g", material="brass")
    steel, brass = hc.material(STEEL), hc.material("brass")
    soft = sum((1 - each.poisson**2) / each.young for each in (steel, brass))
    hertz = 4 / 3 / soft * math.sqrt(5e-3)
    ball, cap = 4 / 3 * math.pi * 5e-3**3 * steel.density, 5e-3

    def motion(_, state):
        x, y, v, w = state
        contact, spring = hertz * max(x - y, 0.0) ** 1.5, 5e6 * max(y, 0.0)
        return [v, w, -contact / ball, (contact - spring) / cap]

    times = np.linspace(0.0, 3e-4, 301)
    found = solve_ivp(motion, (0.0, times[-1]), [0.0, 0.0, 0.05, 0.0], t_eval=times,
                      method="DOP853", rtol=1e-11, atol=1e-16, max_step=1e-6)  # fmt: skip
    run = hc.simulate(chain, times=times, rtol=1e-10)
    expected = 5e6 * np.maximum(found.y[1], 0.0)
    assert run.wall_force().force == pytest.approx(expected, abs=1e-6 * expected.max())
    assert run.velocities[:, 0] == pytest.approx(found.y[2], abs=1e-7)
    assert run.velocities[:, 1] == pytest.approx(found.y[3], abs=1e-7)


def test_the_frequency_of_a_cap_is_that_of_its_oscillation_on_the_wall():
    chain = CHAINS["frequency"]
    assert chain.cap.mass == pytest.approx(5e6 / (2 * math.pi * 5e3) ** 2, rel=1e-14)
    alone = balls(SIZES[:1], gravity=1e-6).with_cap(frequency="5 kHz", stiffness=1.0)
    assert hc.spectrum(alone).frequencies[-1] == pytest.approx(5e3, rel=1e-6)


def test_masses_and_contacts_of_the_other_beads_follow_from_their_radii():
    radii = SIZES * np.linspace(0.9, 1.2, 5)
    changed = CHAINS["material"].replace(radii=[*radii, 1.0])
    assert changed == balls(radii).with_cap("5 g", material="brass")


@EACH
def test_files_describe_the_same_chain(chain, tmp_path):
    assert hc.chain_from_toml(hc.chain_as_toml(chain)) == chain
    assert pickle.loads(pickle.dumps(chain)) == chain
    opened = chain_of(document_of_toml(document_as_toml(document_of_chain(chain))))
    assert opened == chain
    run = hc.simulate(chain, until=1e-5 if chain.units == "SI" else 1.0)
    hc.save_run(run, tmp_path / "run.nc")
    assert hc.load_run(tmp_path / "run.nc").chain == chain
    # Files of fits have seven digits, or are not written for other features.
    text = readable_chain(chain)
    assert (text == "") == (
        chain.units == "scaled" or chain.materials is None or chain.scatter is not None
        or "masses" in chain.given or chain in (CHAINS["cone"], CHAINS["losses"])
    )  # fmt: skip
    if text:
        assert hc.chain_from_toml(text).masses == pytest.approx(chain.masses, rel=1e-5)


@pytest.mark.parametrize("name", [
    "mass", "frequency", "free", "gap", "losses", "masses", "one ball", "scatter", "struck",
])  # fmt: skip
def test_a_cap_replaces_another_one(name):
    chain = CHAINS[name]
    for cap in ({"mass": "8 g", "material": "brass"},
                {"mass": "3 g", "stiffness": "1 kN/mm", "exponent": 1}):  # fmt: skip
        replaced = chain.with_cap("7 g", stiffness="2 kN/mm", exponent=1).with_cap(**cap)
        assert replaced.beads == chain.beads
        assert replaced == chain.with_cap(**cap)
        assert (replaced.masses[-1], replaced.materials[-1].name) == (
            pytest.approx(float(cap["mass"][0]) * 1e-3),
            cap.get("material", STEEL),
        )
        assert replaced.contact_exponents[-2] == cap.get("exponent", 1.5)


def test_a_chain_file_describes_a_cap():
    text = (
        '[chain]\ndiameters = "10 mm"\nbeads = 4\nmaterials = "brass"\n'
        'with_defects = [{bead = 2, diameter = "8 mm"}]\n'
        'right_wall = {stiffness = "5 kN/mm", exponent = 1}\n[chain.cap]\n'
    )
    row = hc.Chain.from_materials("5 mm", "brass", beads=4, right_wall=CELL)
    row = row.with_defects(diameters={2: "8 mm"})
    read = hc.chain_from_toml(text + 'mass = "5 g"\nmaterial = "steel-304"')
    assert read == row.with_cap("5 g", material="steel-304")
    read = hc.chain_from_toml(text + 'frequency = "5 kHz"\nstiffness = 1e9')
    assert read == row.with_cap(frequency="5 kHz", stiffness=1e9)
    for count in (3, 5):
        gaps = f"gaps = {[1e-6] * count}\n[chain.cap]\n"
        with pytest.raises(hc.InputError, match=f"must be 4 num.* but with the cap, got {count}"):
            hc.chain_from_toml(text.replace("[chain.cap]\n", gaps) + 'mass = "5 g"')
    file = text.replace("[chain.cap]\n", f"gaps = {[1e-6] * 4}\n[chain.cap]\n") + 'mass = "5 g"'
    assert (hc.chain_from_toml(file).gaps == 1e-6).all()


@pytest.mark.parametrize(("cap", "said"), [
    ("cap = {}", r"\[chain.cap\] requires mass or frequency"),
    ('cap = {mass = "5 g", frequency = "5 kHz"}', "such as '5 kHz': both were given"),
    ('cap = 5', r"\[chain.cap\] must be a table, such as {mass = \"5 g\"}, or text such as"),
    ('cap = "5"', r"cap of \[chain\] must be a mass or the resonance frequency .* got '5'"),
    ('cap = "5 g, 3 g"', r"cap of \[chain\] '5 g, 3 g' has two values of the mass: omit one"),
    ('cap = "0,5 g"', r"cap of \[chain\] has a comma between two digits"),
    ('cap = {mass = "5 g", radius = 1}', r"unknown key of \[chain.cap\] 'radius'"),
    ('cap = {mass = "5 g", stiffness = 1e9}\nstiffness = 1e9', "cap also has stiffness"),
    ('cap = {mass = "5 g"}\nmasses = [1e-3, 1e-3, 6e-3]', "0.006, is not the mass of .*, 0.005"),
    ('cap = {mass = "5 g"}\nright_wall = {}', "has no Hertz contact with a wall"),
])  # fmt: skip
def test_chain_files_with_other_caps_are_rejected(cap, said):
    text = '[chain]\ndiameters = "10 mm"\nbeads = 2\nmaterials = "brass"\n'
    with pytest.raises(hc.InputError, match=said):
        hc.chain_from_toml(text + cap)


@pytest.mark.parametrize(("build", "said"), [
    (lambda: balls().with_cap(), "such as '5 kHz': neither was given"),
    (lambda: balls().with_cap("5 g", frequency="5 kHz"), "both were given"),
    (lambda: balls().with_cap("5 mm"), "mass of a cap"),
    (lambda: balls().with_cap(-1.0), "mass of a cap must be above 0"),
    (lambda: balls().with_cap("5 g", stiffness="1 kN", exponent=1),
     "must have a unit such as N/m, N/mm, kN/mm, got 'kN'"),
    (lambda: balls().with_cap("5 g", stiffness="1 kN/mm", exponent=2),
     "N/m.2, Pa, .*, got 'kN/mm'"),
    (lambda: balls().with_cap("5 g", stiffness=0.0), "stiffness of the contact of a cap must be"),
    (lambda: balls().with_cap("5 g", material="stele-304"), "unknown material"),
    (lambda: hc.Chain.uniform(3).with_cap(1.0, material="brass"), "requires a chain with mat"),
    (lambda: hc.Chain.uniform(3).with_cap("5 g"), "mass of a cap"),
    (lambda: hc.Chain.uniform(3, exponent=2.0).with_cap(1.0), "of a cap cannot be computed"),
    (lambda: hc.Chain.dimer(0.3, beads=4).with_cap(1.0), "of a cap cannot be computed"),
    (lambda: balls(right_wall=hc.Wall()).with_cap("5 g"),
     "flat striker or cap has no Hertz contact with a wall: give the stiffness of the wall"),
    (lambda: CHAINS["mass"].replace(right_wall=hc.Wall()), "omit the wall behind a free body"),
    (lambda: balls(right_wall=None).with_cap(frequency="5 kHz"),
     "requires a linear right wall, such as .*, but the chain has no right wall; set the wall"),
    (lambda: balls(right_wall=hc.Wall()).with_cap(frequency="5 kHz"), "requires a linear right"),
    (lambda: balls(right_wall=hc.Wall(1e9)).with_cap(frequency="5 kHz"), "requires a linear"),
    (lambda: CHAINS["mass"].reversed(), "with strikers, a cap .* cannot be reversed: call rev"),
    (lambda: CHAINS["free"] + balls(), "omit the cap of the first chain"),
    (lambda: CHAINS["mass"][-1:], "a cap requires a ball in front of it"),
    (lambda: CHAINS["mass"].replace(strikers=5), "a cap requires a ball in front of it"),
    (lambda: hc.Chain.from_radii([1.0, 2.0, 3.0]).with_cap(1.0)[1:], "and with them its cap"),
    (lambda: balls().replace(cap=5e-3), "cap must be"),
    (lambda: balls().replace(cap=Cap()), "a cap has no default mass; give mass"),
    (lambda: hc.Chain.uniform(3).replace(cap=Cap("5 g")), "a cap has a unit in its mass"),
    (lambda: CHAINS["mass"].decorated(0.3), "but its velocities|but its cap"),
    (lambda: CHAINS["mass"].with_defects({6: 5e-3}), "mass of bead 6, a cap, is given"),
    (lambda: CHAINS["struck"].with_defects({1: 5e-3}), "mass of bead 1, a striker, is given"),
    (lambda: CHAINS["masses"].with_defects({2: 5e-3}),
     "the masses of this chain are given .* call with_defects first, .* or omit them with "
     r"replace\(masses=None\)"),
    (lambda: CHAINS["mass"].with_scatter(1, relative=0.01, beads="2:6"),
     "bead 6, a cap, is given"),
    (lambda: CHAINS["mass"].with_contacts(hc.CrossedCylinders()), "or cap is not a cylinder"),
    (lambda: hc.local_rate(CHAINS["free"]), "does not support a cap; use propagate or simulate"),
    (lambda: hc.bca(CHAINS["free"]), "the BCA does not support a cap"),
    (lambda: hc.simulate(balls(), until=1e-5).sensor("cap"), "the chain has no cap"),
])  # fmt: skip
def test_what_a_cap_cannot_be_is_explained(build, said):
    with pytest.raises(hc.InputError, match=said):
        build()


def test_defects_of_chains_with_strikers_gaps_and_losses():
    """The chain is that which is built from the balls of the defect."""
    row = balls(gaps=[0, 0, 1e-6, 0], loss=hc.Restitution(0.9))
    sizes = SIZES.copy()
    sizes[2] = 3e-3
    small = balls(sizes, gaps=[0, 0, 1e-6, 0], loss=hc.Restitution(0.9))
    assert row.with_defects({3: 3e-3}) == small
    for striker in (HAMMER, {"radius": 3e-3}):
        assert struck(row, **striker).with_defects({4: 3e-3}) == struck(small, **striker)


def test_pieces_keep_or_lose_their_cap():
    chain = CHAINS["material"]
    assert chain[:-1] == balls(right_wall=None)
    assert chain[2:].cap == chain.cap
    assert chain[2:].replace(velocities=None) == (
        balls(SIZES[2:]).with_cap("5 g", material="brass").replace(velocities=None)
    )
    front = balls([4e-3, 5e-3], right_wall=None)
    whole = balls([4e-3, 5e-3, *SIZES]).with_cap("5 g", material="brass")
    assert front + chain == whole


@pytest.mark.parametrize("name", ["mass", "material", "stiffness", "struck", "masses"])
def test_converted_chains_keep_their_cap(name):
    chain = CHAINS[name]
    scales = hc.Scales.of(chain)
    scaled = scales.to_scaled(chain)
    assert scaled.cap.mass == pytest.approx(chain.cap.mass / scales.mass, rel=1e-14)
    if name != "masses":
        assert scaled.given.isdisjoint({"masses", "stiffness"})
    back = scales.to_si(scaled)
    assert "masses" in back.given if name == "masses" else "masses" not in back.given
    assert (back.cap.stiffness is None) == (chain.cap.stiffness is None)
    for field in ("radii", "masses", "stiffness"):
        assert getattr(back, field) == pytest.approx(getattr(chain, field), rel=1e-13)
    force = peak(chain, rtol=1e-10)
    until = 1e-3 / scales.time
    assert peak(scaled, until=until, rtol=1e-10) * scales.force == pytest.approx(force, rel=1e-8)


def test_the_last_bead_of_a_taper_can_become_a_cap():
    taper = hc.Chain.tapered("forward-exponential", 0.05, beads=6)
    chain = taper.replace(cap=Cap(4.0))
    assert chain == taper[:-1].with_cap(4.0)
    assert chain.replace(gravity=0.1).description.startswith("forward-exponential, q = 0.05, 5 b")


def test_listed_masses_and_contacts_are_those_of_the_cap_too():
    chain = CHAINS["mass"].replace(masses=[1e-3] * 5 + [7e-3], stiffness=[1e9] * 4 + [2e9])
    assert chain.cap == Cap(7e-3)
    again = chain.replace(masses=None, stiffness=None)
    assert again == balls().with_cap(7e-3)


@pytest.mark.parametrize("name", ["material", "stiffness", "struck"])
def test_derivatives_are_differences_of_rebuilt_chains(name):
    chain = CHAINS[name]
    strikers = chain.strikers
    found = hc.gradient(chain, "wall_force.peak", to=["radii", "masses"], until=1e-3, rtol=1e-11)

    def rebuilt(factor, bead):
        radii = chain.radii.copy()
        radii[bead] *= factor
        return peak(chain.replace(radii=radii), rtol=1e-11)

    for bead in (strikers, strikers + 4):
        expected = (rebuilt(1 + 1e-4, bead) - rebuilt(1 - 1e-4, bead)) / 2e-4
        slope = found["radii"][bead] * chain.radii[bead]
        assert slope == pytest.approx(expected, rel=1e-4, abs=1e-5)
    assert found["radii"][-1] == 0.0
    heavy, light = (
        peak(chain.replace(cap=Cap(5e-3 * factor, chain.cap.stiffness)), rtol=1e-11)
        for factor in (1 + 1e-4, 1 - 1e-4)
    )
    assert found["masses"][-1] == pytest.approx((heavy - light) / 1e-6, rel=1e-4)


def test_random_radii_do_not_change_the_cap():
    chain = struck(balls().with_cap("5 g"))
    for beads in (None, "2:"):
        random = chain.with_scatter(3, relative=0.05, beads=beads)
        assert (random.radii[1:-1] != chain.radii[1:-1]).all()
        assert random.masses[[0, -1]].tolist() == [0.05, 5e-3]
        built = struck(balls(random.radii[1:-1]).with_cap("5 g"))
        assert random == built.replace(scatter=random.scatter)
    lot = hc.Scatter(grade=200, samples=6)
    found = hc.distribution(chain, "wall_force.peak", lot, seed=1, until=1e-3)
    rows = [each.radii[1:-1] for each in lot.sample(chain, seed=1)]
    expected = [peak(struck(balls(row).with_cap("5 g"))) for row in rows]
    assert np.sort(found.values) == pytest.approx(np.sort(expected), rel=1e-6)


def test_designs_vary_the_balls_and_not_the_cap():
    chain = struck(balls().with_cap("5 g"), velocity=0.05, mass="2 g")
    problem = hc.Design(chain, minimise="wall_force.peak", until=1e-3,
                        vary=[hc.vary.diameters("6 mm", "12 mm", beads="2:")],
                        subject_to={"length": "<= 50 mm"})  # fmt: skip
    found = hc.design(problem, budget=120)
    built = struck(balls(found.chain.radii[1:-1]).with_cap("5 g"), velocity=0.05, mass="2 g")
    assert found.chain.masses == pytest.approx(built.masses, rel=1e-13)
    assert found.value == pytest.approx(peak(built, rtol=1e-11), rel=1e-6)
    length = 2.0 * found.chain.radii[1:-1].sum()
    assert found.values["length"] == pytest.approx(length, rel=1e-12)
    assert length <= 50e-3 * (1 + 1e-9)
    summary = found.summary()
    assert "without the striker and the cap" in summary
    assert ", flat\n" in summary
    assert "\nin all, without the striker and the cap: 5 beads" in summary
    with pytest.raises(hc.InputError, match="the size of bead 7, the cap, cannot vary: .* up to 6"):
        hc.Design(chain, minimise="wall_force.peak",
                  vary=[hc.vary.diameters("6 mm", "12 mm", beads="2:7")])  # fmt: skip


@pytest.mark.parametrize("vary", [
    hc.vary.order(), hc.vary.balls(diameters=["8 mm", "10 mm"], materials=[STEEL]),
    hc.vary.balls(diameters=["8 mm", "10 mm"], materials=[STEEL], optional=True),
])  # fmt: skip
def test_designs_choose_balls_in_front_of_a_cap(vary):
    chain = balls(SIZES[:4]).with_cap("5 g", material="brass")
    problem = hc.Design(chain, minimise="wall_force.peak", vary=[vary], until=1e-3)
    found = hc.design(problem, budget=60)
    built = balls(found.chain.radii[:-1]).with_cap("5 g", material="brass")
    assert found.chain.masses == pytest.approx(built.masses, rel=1e-13)
    assert found.value == pytest.approx(peak(built, rtol=1e-11), rel=1e-6)
    (order,) = [line for line in found.summary().splitlines() if line.startswith("order: ")]
    assert order.endswith(", cap")
    assert "flat" not in order


def test_a_design_with_scatter_in_front_of_a_cap():
    chain = balls(SIZES[:3]).with_cap("5 g")
    scatter = hc.Scatter(radius="1%", samples=2, measure="mean")
    problem = hc.Design(chain, minimise="wall_force.peak", until=1e-3, scatter=scatter,
                        vary=[hc.vary.diameters("6 mm", "12 mm")])  # fmt: skip
    found = hc.design(problem, budget=200)
    assert found.chain.masses[-1] == 5e-3
    assert found.chain.cap == chain.cap


def test_sweeps_over_caps_and_radii():
    chain = balls(SIZES[:3]).with_cap("5 g")
    settings = {
        "sweep": {"methods": ["simulate"], "keep": ["wall_force.peak"]}, "method": {"until": 1e-3}
    }  # fmt: skip
    axes = {"cap.mass": ["4 g", "6 g"], "radii.2": [4e-3, 6e-3]}
    found = hc.sweep({"chain": chain, "axes": axes} | settings)["wall_peak_force"]
    for i, j in np.ndindex(2, 2):
        row = balls([5e-3, (4e-3, 6e-3)[j], 6e-3]).with_cap((4e-3, 6e-3)[i])
        assert float(found[i, j].item()) == pytest.approx(peak(row), rel=1e-6)
    found = hc.sweep({"chain": chain, "axes": {"cap.material": ["brass"]}} | settings)
    expected = peak(balls(SIZES[:3]).with_cap("5 g", material="brass"))
    assert np.ravel(found["wall_peak_force"]) == pytest.approx([expected], rel=1e-6)


def test_the_pulse_in_a_window_agrees_with_the_whole_chain():
    chain = struck(CHAINS["free"])
    window, whole = hc.propagate(chain), hc.simulate(chain, rtol=1e-11).pulse()
    assert window.velocity == pytest.approx(whole.velocity, rel=1e-6)


def test_limits_of_hertz_law_use_the_radius_of_the_ball():
    chain = balls([5e-3, 5e-3]).with_cap("5 g")
    overlap, steel = 1e-6, hc.material(STEEL)
    found = hc.hertz_range(chain, [0.0, 0.0, overlap, 1e-6])
    modulus = steel.young / (2 * (1 - steel.poisson**2))
    pressure = 2 / math.pi * modulus * math.sqrt(overlap / 5e-3)
    assert found.overlap_ratio[2] == pytest.approx(overlap / 5e-3, rel=1e-12)
    assert found.yield_ratio[2] == pytest.approx(pressure / (1.6 * steel.yield_strength), rel=1e-12)
    # The cap and its load cell are a linear spring.
    assert np.isnan(found.yield_ratio[3])


def test_fitted_radii_masses_and_moduli_in_front_of_a_cap():
    chain = CHAINS["stiffness"]
    changed = with_sizes(chain, {Name("radius", "5"): 7e-3, Name("mass", "6"): 9e-3}, 1e-5)
    assert changed.cap.mass == 9e-3
    assert changed.stiffness[-1] == pytest.approx(1e9 * math.sqrt(7.0 / 5.5), rel=1e-12)
    with pytest.raises(hc.InputError, match=r"radius\[6\] is not a ball .* are 1 to 5"):
        with_sizes(chain, {Name("radius", "6"): 7e-3}, 1e-5)


def test_descriptions_titles_and_names():
    steel = hc.Chain.from_materials("5 mm", STEEL, beads=10, right_wall=CELL).with_cap("5 g")
    assert steel.description == (
        "10 steel-52100 beads, diameter 10 mm, and a cap (5 g, steel-52100), right wall of 5 kN/mm"
    )
    assert chain_words(steel) == "10 steel balls, 10 mm, cap 5 g, wall 5 kN/mm"
    with_striker = steel.struck_by(diameter="12 mm")
    assert with_striker.description.startswith(
        "10 steel-52100 beads, diameter 10 mm, 1 striker (12 mm, 7.039 g) and a cap "
        "(5 g, steel-52100), right wall"
    )
    assert CHAINS["material"].description.count("a cap (5 g, brass)") == 1
    assert CHAINS["scaled"].description == "uniform, 5 beads, and a cap (mass 4)"
    assert chain_words(CHAINS["scaled"]) == "5 equal beads, cap of mass 4"
    assert "1% scatter, and a cap" in CHAINS["scatter"].description
    assert CHAINS["scatter"].description == CHAINS["scatter first"].description
    heavy = CHAINS["scatter"].replace(cap=Cap(9e-3))
    assert "1% scatter, and a cap (9 g, steel-52100)" in heavy.description
    assert (
        "10, and 1 striker (12 mm, 7.039 g) and a cap (5 g, steel-52100)"
        in with_striker._repr_html_()
    )
    run = hc.simulate(CHAINS["struck"], until=1e-4)
    assert (run.sensor("cap") == run.sensor(7)).all()
    assert "bead 7 (cap)" in {bead_label(run.chain, k) for k in range(1, 8)}
    assert with_bead_numbers(run.chain, "velocity@cap") == "velocity@7"


def test_a_cap_is_drawn_as_a_plate():
    """Half as wide as a ball, and as high: the row is not 2 m long."""
    chain = hc.Chain.from_materials("5 mm", STEEL, beads=3, right_wall=CELL).with_cap("5 g")
    axes = hc.plot_chain(chain)
    *circles, plate = axes.collections[0].get_paths()
    assert len(circles) == 3
    np.testing.assert_allclose(np.ptp(plate.vertices, axis=0), [2.5, 10.0])
    assert length_of(chain) == pytest.approx(32.5e-3)


def test_the_command_adds_a_cap(run, tmp_path):
    described = ["--material", STEEL, "--diameter", "10 mm", "--beads", "4", "--speed", "0.05 m/s"]
    options = [*described, "--wall", "5 kN/mm", "--cap", "5 g, tungsten-carbide", "--until", "1 ms"]
    _, out, _ = run("simulate", *options)
    assert "4 steel-52100 beads, diameter 10 mm, and a cap (5 g, tungsten-carbide)" in out
    file = tmp_path / "chain.toml"
    file.write_text(hc.chain_as_toml(CHAINS["free"]))
    _, out, _ = run("sensitivity", file, "--quantity", "velocity@cap")
    assert "6 (cap)" in out
    for cap, said in {
        "5": "--cap must be a mass or the resonance frequency", "3 mm": "got '3 mm'",
        "5 g, 3 g": "has two values of the mass: omit one", "brass": "neither was given",
    }.items():  # fmt: skip
        code, _, err = run("simulate", *described, "--wall", "5 kN/mm", "--cap", cap)
        assert code == 2
        assert said in err
    code, _, err = run("simulate", *described, "--wall", "same", "--cap", "5 g")
    assert (code, "give the stiffness of the wall, such as --wall '5 kN/mm'" in err) == (2, True)
    code, _, err = run("simulate", *described, "--cap", "5 kHz")
    assert "such as --wall '5 kN/mm', but the chain has no right wall; add --wall" in err
    code, out, err = run("simulate", file, "--cap", "8 g", "--until", "1 ms")
    assert (code, "and a cap (8 g, steel-52100)" in out) == (0, True), err
    code, _, err = run("simulate", "--beads", "4", "--cap", "5 g")
    assert (code, "--cap '5 g' requires --material" in err) == (2, True)


@pytest.mark.parametrize(("cap", "file", "arguments"), [
    ("5 g, 1 kN/mm", 'mass = "5 g"\nstiffness = "1 kN/mm"\nexponent = 1',
     {"mass": "5 g", "stiffness": "1 kN/mm", "exponent": 1}),
    ("3e8 N/m^1.5, tungsten-carbide, flat, 5 kHz",
     'frequency = "5 kHz"\nmaterial = "tungsten-carbide"\nstiffness = "3e8 N/m^1.5"',
     {"frequency": "5 kHz", "material": "tungsten-carbide", "stiffness": "3e8 N/m^1.5"}),
])  # fmt: skip
def test_option_file_and_method_agree_on_a_cap_with_stiffness(run, tmp_path, cap, file, arguments):
    command = ["simulate", "--until", "1 ms", "--json"]
    described = ["--material", STEEL, "--diameter", "10 mm", "--beads", "4", "--speed", "0.05 m/s"]
    _, out, _ = run(*command, *described, "--wall", "5 kN/mm", "--cap", cap)
    path = tmp_path / "chain.toml"
    path.write_text(
        f'[chain]\ndiameters = "10 mm"\nbeads = 4\nmaterials = "{STEEL}"\nvelocity = "0.05 m/s"\n'
        f'[chain.right_wall]\nstiffness = "5 kN/mm"\nexponent = 1\n[chain.cap]\n{file}\n'
    )
    _, of_file, _ = run(*command, path)
    row = hc.Chain.from_materials(diameters="10 mm", materials=STEEL, beads=4, velocity=0.05)
    row = row.replace(right_wall=hc.Wall("5 kN/mm", exponent=1)).with_cap(**arguments)
    assert hc.load_chain(path) == row
    peak = hc.simulate(row, until="1 ms").wall_force().peak
    hertz = row[:-1].with_cap(row.masses[-1]).replace(right_wall=row.right_wall)
    assert peak < 0.99 * hc.simulate(hertz, until="1 ms").wall_force().peak
    for each in (out, of_file):
        assert json.loads(each)["walls"][0]["peak"] == pytest.approx(peak, rel=1e-9)


def test_a_cap_has_one_stiffness_and_the_unit_of_its_exponent(run):
    described = ["--material", STEEL, "--diameter", "10 mm", "--beads", "4", "--wall", "5 kN/mm"]
    for cap, said in {
        "5 g, 1 kN/mm, 2 kN/mm": "has two values of the stiffness: omit one",
        "1 kN/mm": "neither was given", "5 g, 1e9": "or '5 g, 1 kN/mm' with a pad, got '1e9'",
    }.items():  # fmt: skip
        code, _, err = run("simulate", *described, "--cap", cap)
        assert (code, said in err) == (2, True)


def test_the_summary_states_when_the_cap_leaves_the_wall(run, tmp_path):
    row = hc.Chain.from_materials(diameters="10 mm", materials="steel-52100", beads=6)
    cell = hc.Wall("50 kN/mm", exponent=1)
    row = row.replace(right_wall=cell).with_cap("5 g").struck_by(velocity="0.1 m/s")
    end = hc.simulate(row).wall_force().first_contact_end
    (tmp_path / "row.toml").write_text(hc.chain_as_toml(row))
    _, out, _ = run("simulate", tmp_path / "row.toml")
    assert f"the cap leaves the wall at t = {1e6 * end:.4g} us, because walls do not pull" in out
