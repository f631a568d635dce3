"""Chains whose contacts and walls have different laws and exponents."""

import math

import numpy as np
import pytest
from kernel_call import callable_from_python
from random_chains import mixed_case, random_law
from scipy.integrate import quad
from scipy.special import beta
from scipy_chain import Units
from test_random_chains import deviation

import hertzchain as hc
from hertzchain import Chain, InputError, Wall
from hertzchain.chain.laws import LAWS
from hertzchain.chain.laws.base import ContactArrays, Loss
from hertzchain.chain.materials import contact_modulus
from hertzchain.simulation.kernel_input import kernel_chain
from hertzchain.simulation.state import fingerprint

pytestmark = [
    pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning"),
    pytest.mark.filterwarnings("ignore::hertzchain.IncompleteWarning"),
    # Of random chains.
    pytest.mark.filterwarnings("ignore:the gravity is:hertzchain.InputWarning"),
    pytest.mark.filterwarnings("ignore:.*gap .* but the beads are only:hertzchain.InputWarning"),
]
MIXED = Chain.uniform(5).replace(
    loss=[hc.Dashpot(0.1), None, hc.WaltonBraun(0.8), hc.ElasticPlastic(yield_overlap=0.1)],
    exponent=[2.0, 1.5, 1.5, 1.5],
    right_wall=Wall(stiffness=2.0, gap=0.1, exponent=1.8, loss=hc.UnloadingRatio(0.3)),
)
STEEL_AND_PTFE = Chain.periodic([9.5e-3] * 2, cells=3, materials=["steel-316", "ptfe"])
PAIRS = {("steel-316", "ptfe"): hc.Restitution(0.6), ("ptfe", "ptfe"): hc.Restitution(0.4)}


@pytest.mark.parametrize(
    "seed", [0, 4, 8, 9, 11, 14, 19, pytest.param(20, marks=pytest.mark.long), 30, 35]
)
def test_random_chains_agree_with_scipy(seed):
    # Measured on the first 130 seeds: 1e-7.
    assert deviation(mixed_case(seed)) < 5e-7


def test_each_contact_has_its_own_restitution():
    """Beads so far apart that each collision of two is over before the next begins."""
    coefficients = np.array([0.9, 0.5, 0.7])
    laws = [
        hc.Restitution(0.9), hc.UnloadingRatio(1.0 - 0.5**2), hc.WaltonBraun(0.7**2),
    ]  # fmt: skip
    radii = [1.0, 0.8, 1.3, 0.6]
    chain = Chain.from_radii(radii).replace(loss=laws, gaps=[0.0, 50.0, 50.0])
    run = hc.simulate(chain, until=400.0, times=2)
    m = np.array(radii) ** 3
    passed = np.cumprod((1.0 + coefficients) / (1.0 + m[1:] / m[:-1]))
    assert run.velocities[-1, -1] == pytest.approx(passed[-1], rel=1e-9)


@pytest.mark.parametrize("exponent", [1.2, 1.5, 2.5])
def test_each_contact_has_its_own_exponent(exponent):
    """Largest overlap of a collision of two: all energy is in the contact."""
    chain = Chain.uniform(3).replace(exponent=[exponent, 3.0], gaps=[0.0, 50.0])
    run = hc.simulate(chain, until=200.0, times=2)
    expected = [((p + 1.0) * 0.25) ** (1.0 / (p + 1.0)) for p in (exponent, 3.0)]
    np.testing.assert_allclose(run.largest_overlaps[1:3], expected, rtol=1e-9)


def published_restitution(ratio):
    """C. Thornton, J. Appl. Mech. 64, 383 (1997), of the ratio of yield speed to speed."""
    root = math.sqrt(6.0 / 5.0 - ratio**2 / 5.0)
    first = math.sqrt(6.0 * math.sqrt(3.0) / 5.0) * math.sqrt(1.0 - ratio**2 / 6.0)
    return first * (ratio / (ratio + 2.0 * root)) ** 0.25


@pytest.mark.parametrize("ratio", [1.5, 1.0, 0.7, 0.3, 0.03])
def test_elastic_plastic_spheres_have_the_published_restitution(ratio):
    law = hc.ElasticPlastic(yield_overlap=0.2)
    speed = math.sqrt(2.0 * 0.4 * 0.2**2.5 / 0.5) / ratio
    chain = Chain.uniform(2).replace(velocities=[speed, 0.0], loss=law)
    run = hc.simulate(chain, until=20.0 * speed**-0.2, times=2)
    expected = published_restitution(ratio) if ratio < 1.0 else 1.0
    # Measured: 2e-10 at the default tolerance.
    after = np.diff(run.velocities[-1])[0] / speed
    assert after == pytest.approx(expected, rel=2e-9)
    assert law.restitution(speed) == pytest.approx(expected, rel=1e-14)


def test_materials_yield_at_the_published_speed():
    """A sphere on a plane, of one material: v_y = 1.56 (p_y^5/(E*^4 rho))^(1/2)."""
    steel = hc.material("steel-316")
    pressure = 1.6 * steel.yield_strength
    speed = 1.56 * math.sqrt(pressure**5 / (contact_modulus(steel, steel) ** 4 * steel.density))
    for factor, elastic in ((0.99, True), (1.02, False)):
        bead = Chain.from_materials(5e-3, steel, beads=2).replace(
            velocities=[0.0, factor * speed], gaps=[1e-3], right_wall=Wall(),
            loss=hc.ElasticPlastic(),
        )  # fmt: skip
        returned = -hc.simulate(bead, until=2e-4, times=2).velocities[-1, 1] / (factor * speed)
        assert (returned > 1.0 - 1e-9) == elastic


def test_elastic_plastic_contacts_at_rest_are_loaded_beyond_yield():
    chain = Chain.uniform(4).replace(
        precompression=1.0,
        held_by="force",
        velocities=0.0,
        loss=hc.ElasticPlastic(yield_overlap=0.25),
    )
    # F_y = 1/8, and the slope beyond is 1.5 sqrt(1/4).
    overlaps = -np.diff(hc.equilibrium(chain).positions)
    np.testing.assert_allclose(overlaps, 0.25 + (1.0 - 0.125) / 0.75, rtol=1e-14)
    run = hc.simulate(chain, until=10.0, times=5)
    assert np.abs(run.velocities).max() < 1e-14


@pytest.mark.parametrize("name", sorted(LAWS))
def test_stored_energy_is_that_of_the_kernel(name):
    """The law's own formula, for saved states, and the kernel's, along a loading and unloading."""
    from hertzchain.kernels.contact_law import LOADED, RELEASED, Law, contact_force, potential

    force_of, energy_of = callable_from_python(contact_force), callable_from_python(potential)
    rng = np.random.default_rng(3)
    class_name = LAWS[name].__name__
    for exponent in (1.5,) if name == "elastic-plastic" else (1.5, 2.2):
        law = random_law(rng, Units(), (class_name,))
        contacts = ContactArrays(exponent, np.array([1.7]), np.array([0.6]))
        row, damping = law.row(exponent), float(law.strength(contacts)[0])
        numbers = Law(**row._asdict(), exponent=exponent, implicit=False, slowest=0.0, shared=True)
        for largest, mode in ((0.05, LOADED), (0.9, LOADED), (0.05, RELEASED), (1.4, RELEASED)):
            damped = row.overlap_power or row.speed_power != 1.0 or not row.attractive
            if mode == RELEASED and (damped or name in ("dashpot", "elastic")):
                continue
            for part in (1.0, 0.97, 0.6):
                d = largest * (part if mode == RELEASED else 1.0)
                state = d, 1e-300, mode, largest, 1.7, damping, numbers
                force, _ = force_of(*state)
                expected = energy_of(d, 1.7, damping, mode, largest, numbers)
                own = law.stored_energy(np.array([d]), np.array([force]), contacts)[0]
                assert own == pytest.approx(expected, rel=1e-10, abs=1e-15)


@pytest.mark.parametrize("exponent", [1.5, 2.0, 3.0])
@pytest.mark.parametrize("law", [hc.Restitution(0.7), hc.Restitution(0.7, attractive=False)])
def test_the_integrated_collision_is_right(law, exponent):
    contacts = ContactArrays(exponent, np.array([2.0]), np.array([0.3]))
    # Measured: 4e-10.
    assert Loss._restitution(law, 0.8, contacts) == pytest.approx(0.7, rel=4e-9)


@pytest.mark.parametrize(
    "law", [hc.Dashpot(0.2), hc.Viscoelastic(0.1), hc.VelocityPower(0.1, 1.8)], ids=repr
)
def test_restitution_is_that_of_two_beads(law):
    chain = Chain.from_radii([1.0, 0.8]).replace(loss=law, velocities=[1.3, 0.0])
    run = hc.simulate(chain, until=100.0, times=2)
    m, k = chain.masses, float(chain.stiffness[0])
    own = law.restitution(1.3, reduced_mass=float(m[0] * m[1] / m.sum()), stiffness=k)
    assert np.diff(run.velocities[-1])[0] / 1.3 == pytest.approx(own, rel=1e-8)


def test_energy_is_accounted_for():
    walled = MIXED.replace(gravity=0.02, left_wall=Wall(stiffness=1.0))
    run = hc.simulate(walled, until=60.0, times=200)
    budget = run.budget()
    # Both force laws and energies change where a sphere yields: measured 2e-9.
    for of in ("energy", "momentum"):
        assert np.abs(budget.residual(of)).max() < 1e-8
    assert run.energy_drift < 1e-8
    assert budget.energy["lost"][-1] > 0.1


def test_a_run_resumes_bit_for_bit(tmp_path):
    whole = hc.simulate(MIXED, until=40.0, times=2)
    half = hc.simulate(MIXED, until=17.3, times=2)
    hc.save_state(half.state, tmp_path / "state.npz")
    start = hc.load_state(tmp_path / "state.npz", MIXED)
    rest = hc.simulate(MIXED, start=start, until=40.0, times=2)
    np.testing.assert_array_equal(whole.velocities[-1], rest.velocities[-1])


def test_a_streamed_run_is_the_same(tmp_path):
    times = np.linspace(0.0, 30.0, 16)
    stored = hc.stream(MIXED, tmp_path / "run", times=times)
    run = hc.simulate(MIXED, times=times)
    np.testing.assert_array_equal(stored.load()["velocity"], run.velocities)


def test_equal_laws_are_one_law():
    listed = Chain.uniform(4).replace(loss=[hc.Dashpot(0.1)] * 3, exponent=[2.0] * 3)
    assert listed.loss == hc.Dashpot(0.1)
    assert listed.exponent == 2.0
    assert listed.features == ("loss",)
    assert kernel_chain(listed).law.shared
    assert Chain.uniform(4).replace(loss=[None, hc.Elastic(), None]).features == ()


def test_walls_are_by_default_like_the_contact_next_to_them():
    assert [law.name for law in MIXED.contact_losses] == [
        "dashpot", "dashpot", "elastic", "walton-braun", "elastic-plastic", "unloading-ratio",
    ]  # fmt: skip
    np.testing.assert_array_equal(MIXED.contact_exponents, [2.0, 2.0, 1.5, 1.5, 1.5, 1.8])
    other = MIXED.replace(left_wall=Wall(stiffness=1.0, loss=hc.Elastic()))
    assert other.contact_losses[0] == hc.Elastic()
    assert (
        "mixed losses" in Chain.uniform(3).replace(right_wall=Wall(loss=hc.Dashpot(1.0))).features
    )


def test_laws_by_pairs_of_materials():
    chain = STEEL_AND_PTFE.replace(loss=PAIRS, right_wall=Wall())
    assert chain.contact_losses == (hc.Restitution(0.6),) * 6 + (hc.Restitution(0.4),)
    # Later changes also follow from the pairs.
    longer = chain.replace(radii=[9.5e-3] * 3, materials=["ptfe", "ptfe", "steel-316"],
                           right_wall=None, gaps=None, velocities=None)  # fmt: skip
    assert longer.contact_losses[1:3] == (hc.Restitution(0.4), hc.Restitution(0.6))
    listed = STEEL_AND_PTFE.replace(
        loss=[hc.Restitution(0.6)] * 5, right_wall=Wall(loss=hc.Restitution(0.4))
    )
    runs = [hc.simulate(each, until=5e-4, times=2) for each in (chain, listed)]
    np.testing.assert_array_equal(runs[0].velocities, runs[1].velocities)
    p = {("steel-316", "ptfe"): 1.5, ("ptfe", "ptfe"): 1.5}
    assert STEEL_AND_PTFE.replace(exponent=p).features == STEEL_AND_PTFE.features


def test_the_law_of_all_other_pairs(tmp_path):
    loss = {("steel-316", "ptfe"): hc.Restitution(0.6), "others": hc.Dashpot(2.0)}
    chain = STEEL_AND_PTFE.replace(loss=loss, left_wall=Wall(), right_wall=Wall.of("brass"))
    inner = (hc.Restitution(0.6),) * 5
    assert chain.contact_losses == (hc.Dashpot(2.0), *inner, hc.Dashpot(2.0))
    assert "others: Dashpot(gamma=2.0" in repr(chain.loss)
    text = hc.chain_as_toml(chain)
    assert text.count("between") == 1
    path = tmp_path / "pairs.toml"
    path.write_text(text)
    assert hc.load_chain(path).loss == chain.loss
    assert hc.load_chain(path) == chain
    none = chain.replace(loss={("ptfe", "steel-316"): None, "others": hc.Restitution(0.4)})
    assert [law.name for law in none.contact_losses] == [
        "restitution", *["elastic"] * 5, "restitution",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("second", "said"),
    [
        ('between = ["ptfe", "steel-316"]\n', "two tables of [[chain.loss]] have the same between"),
        ('between = ["ptfe"]\n', "must have two materials, got ['ptfe']; a table without between"),
        ("", "two tables of [[chain.loss]] are without between: omit one"),
    ],
)
def test_pairs_of_chain_files_are_given_once(tmp_path, second, said):
    law = 'law = "restitution"\ncoefficient = 0.5\n'
    tables = ('between = ["steel-316", "ptfe"]\n', "", second)
    (tmp_path / "twice.toml").write_text(
        '[chain]\ncell = ["9.5 mm", "9.5 mm"]\ncells = 3\nmaterials = ["steel-316", "ptfe"]\n'
        + "".join(f"[[chain.loss]]\n{each}{law}" for each in tables)
    )
    with pytest.raises(hc.InputError) as raised:
        hc.load_chain(tmp_path / "twice.toml")
    assert said in str(raised.value)


@pytest.mark.parametrize(
    ("build", "said"),
    [
        (lambda: MIXED.replace(loss=[hc.Dashpot(1.0)]), "must be 4 laws of loss, .* got 1; a wall"),
        (lambda: MIXED.replace(exponent=[1.5, 2.0]), "must be 4 exponents, .* got 2; a wall has"),
        (lambda: MIXED.replace(exponent=[1.5, 2.0, 0.9, 1.5]), "exponent .* at least 1 .* got 0.9"),
        (lambda: MIXED.replace(loss=[0.9] * 4), "loss must be a law, such as Restitution"),
        (lambda: MIXED.replace(loss=PAIRS), "loss by pairs of materials needs a chain of mat"),
        (
            lambda: STEEL_AND_PTFE.replace(loss=PAIRS, left_wall=Wall()),
            "no loss for steel-316 on steel-316, which meet at the left wall: give it for",
        ),
        (lambda: STEEL_AND_PTFE.replace(loss={"ptfe": None}), "needs pairs such as .* got 'ptfe'"),
        (lambda: STEEL_AND_PTFE.replace(loss={}), "loss by materials has no pairs"),
        (lambda: STEEL_AND_PTFE.replace(exponent=[1.5, 2, 1.5, 1.5, 1.5]), "not of p = 2; give st"),
        (lambda: Wall(loss=0.9), "loss of a wall must be a law, .* got 0.9; Elastic"),
        (lambda: Wall(exponent=0.5), "the contact with a wall must be at least 1 and"),
        (
            lambda: Chain.uniform(3).replace(right_wall=Wall(exponent=2.0)),
            r"give Wall\(stiffness=...\)",
        ),
        (
            lambda: Chain.uniform(3, exponent=2.0).replace(loss=hc.ElasticPlastic(yield_overlap=1)),
            "law of spheres .* p = 2: use WaltonBraun",
        ),
        (lambda: Chain.uniform(3).replace(loss=hc.ElasticPlastic()), "scaled chain needs a yie"),
        (
            lambda: Chain.from_materials(5e-3, hc.Material("a", 1e3, 1e9, 0.3), beads=2,
                                         loss=hc.ElasticPlastic()),
            "'a' and 'a', which meet at contact 1, have none, .*; give ElasticPlastic",
        ),
        (lambda: hc.ElasticPlastic(1e9, 1e-6), "a yield_pressure or a yield_overlap, not both"),
        (
            lambda: hc.simulate(MIXED.replace(right_wall=Wall(stiffness=1.0,
                                              loss=hc.VelocityPower(0.1, 0.5)))),
            "alpha < 1.* need implicit steps, which cannot follow .*WaltonBraun.*: use alpha",
        ),
        (lambda: MIXED.decorated(0.2), "but its exponents and losses belong to the present ones"),
    ],
)  # fmt: skip
def test_contradictions_are_rejected_in_one_sentence(build, said):
    with pytest.raises(InputError, match=said) as caught:
        build()
    assert "\n" not in str(caught.value)


def test_contacts_without_known_yield_strength_stay_elastic_beside_contacts_that_yield():
    """Two equal rubber balls exchange their velocities; rubber on wax loses energy."""
    law, wax = hc.ElasticPlastic(), hc.Material("wax", 900.0, 1e9, 0.4, yield_strength=1e5)
    chain = Chain.from_materials(5e-3, ["rubber", "rubber", wax], velocity=0.1, loss=law)
    chain = chain.replace(gaps=[0.0, "1 mm"])
    assert chain.contact_losses[1:3] == (hc.Elastic(), law)
    assert hc.simulate(chain, until="9 ms").velocities[-1] == pytest.approx([0, 0.1, 0], abs=1e-8)
    moving = chain.masses @ hc.simulate(chain, until="30 ms").velocities[-1] ** 2
    e = law.restitution(0.1, chain=chain, contact=2)
    lost = chain.masses[1] * chain.masses[2] / chain.masses[1:].sum() * (1.0 - e**2) * 0.1**2
    assert e < 0.9
    assert moving == pytest.approx(chain.masses[0] * 0.1**2 - lost, rel=1e-6)


@pytest.mark.parametrize("method", [hc.propagate, hc.bca, hc.hard_sphere, hc.effective_chain])
def test_theories_reject_mixed_contacts_in_one_sentence(method):
    chain = MIXED.replace(right_wall=None)
    what = "mixed losses" if method is hc.propagate else "mixed exponents or mixed losses"
    with pytest.raises(InputError, match=f"does not support {what}"):
        method(chain)
    if method is not hc.propagate:
        with pytest.raises(InputError, match="does not support mixed exponents"):
            method(Chain.uniform(4).replace(exponent=[1.5, 2.0, 1.5]))


def test_small_motions_of_mixed_contacts():
    """Each contact is its own spring and damper at the static force."""
    force = 0.7
    chain = Chain.uniform(4).replace(
        precompression=force, held_by="force", exponent=[1.5, 2.0, 3.0],
        loss=[hc.Dashpot(0.3), hc.Viscoelastic(0.2), None],
    )  # fmt: skip
    contacts = hc.spectrum(chain).contacts
    p = np.array([1.5, 2.0, 3.0])
    springs = p * force ** (1.0 - 1.0 / p)
    np.testing.assert_allclose(contacts.springs[1:-1], springs, rtol=1e-14)
    np.testing.assert_allclose(contacts.dampers[1:-1], [0.3, 0.2 * springs[1], 0.0], rtol=1e-14)


def test_units_of_mixed_contacts():
    """Scaled and back, a chain moves as before."""
    chain = Chain.from_materials(
        [5e-3, 4e-3, 6e-3, 5e-3], ["steel-316", "brass", "brass", "steel-316"], velocity=0.2,
        loss=[hc.Dashpot(3.0), hc.ElasticPlastic(), hc.Viscoelastic(1e-6)],
        right_wall=Wall.of("aluminium"),
    ).with_contacts({1: hc.Cone(80.0)})  # fmt: skip
    scales = hc.Scales.of(chain)
    scaled = scales.to_scaled(chain)
    back = scales.to_si(scaled)
    assert scaled.features[-2:] == ("mixed exponents", "mixed losses")
    for name in ("stiffness", "masses", "contact_exponents", "contact_stiffness"):
        np.testing.assert_allclose(getattr(back, name), getattr(chain, name), rtol=1e-13)
    until = 2e-4
    si = hc.simulate(chain, until=until, times=2).velocities[-1]
    own = hc.simulate(scaled, until=until / scales.time, times=2).velocities[-1]
    np.testing.assert_allclose(own * scales.velocity, si, rtol=0, atol=1e-9 * 0.2)


@pytest.mark.parametrize(
    "chain",
    [
        MIXED,
        STEEL_AND_PTFE.replace(loss=PAIRS, right_wall=Wall()),
        STEEL_AND_PTFE.with_contacts({2: hc.Cone(75.0), 3: hc.CrossedCylinders(angle=45.0)}),
        STEEL_AND_PTFE.replace(
            loss=hc.ElasticPlastic(yield_pressure=1e8), left_wall=Wall(loss=hc.Elastic())
        ),
        Chain.uniform(3, exponent=2.0).replace(left_wall=Wall(stiffness=1.0, exponent=1.5)),
        STEEL_AND_PTFE.replace(
            exponent={("steel-316", "ptfe"): 1.5, ("ptfe", "brass"): 2.0},
            right_wall=Wall(stiffness=1e9, exponent=1.7),
        ),
        STEEL_AND_PTFE.replace(left_wall=Wall.of("brass")).with_contacts({0: hc.Cone(60.0)}),
    ],
    ids=str,
)  # fmt: skip
def test_chain_files_carry_mixed_contacts(chain, tmp_path):
    file = tmp_path / "chain.toml"
    file.write_text(hc.chain_as_toml(chain), "utf-8")
    read = hc.load_chain(file)
    assert read.contact_losses == chain.contact_losses
    np.testing.assert_array_equal(read.contact_exponents, chain.contact_exponents)
    np.testing.assert_array_equal(read.contact_stiffness, chain.contact_stiffness)
    assert fingerprint(read) == fingerprint(chain)


SHAPED = """
[chain]
cell = ["9.5 mm", "9.5 mm"]
cells = 3
materials = ["steel-316", "ptfe"]

[chain.right_wall]
material = "brass"

[[chain.with_contacts]]
shape = "crossed-cylinders"
contacts = [2, 5]
angle = 45

[[chain.with_contacts]]
shape = "crossed-cylinders"
contacts = 1
radius = "4 mm"

[[chain.with_contacts]]
shape = "cone"
contacts = [3, 6]
half_angle = 75.0
"""
BY_PAIRS = """
[chain]
cell = ["9.5 mm", "9.5 mm"]
cells = 3
materials = ["steel-316", "ptfe"]
stiffness = 1e8
exponent = [
    {between = ["steel-316", "ptfe"], value = 1.6},
    {between = ["ptfe", "ptfe"], value = 2.0},
]

[chain.right_wall]
stiffness = 2e8
"""


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            SHAPED,
            STEEL_AND_PTFE.replace(right_wall=Wall.of("brass")).with_contacts(
                {
                    **dict.fromkeys((2, 5), hc.CrossedCylinders(angle=45.0)),
                    1: hc.CrossedCylinders(4e-3),
                    **dict.fromkeys((3, 6), hc.Cone(75.0)),
                }
            ),
        ),
        (
            '[chain]\nradii = 5e-3\nbeads = 4\nmaterials = "brass"\n'
            '[[chain.struck_by]]\nradius = 6e-3\n[chain.with_contacts]\nshape = "cone"\n'
            "half_angle = 80",
            Chain.from_materials(5e-3, "brass", beads=4)
            .struck_by(radius=6e-3)
            .with_contacts(hc.Cone(80.0)),
        ),
        (
            BY_PAIRS,
            STEEL_AND_PTFE.replace(
                stiffness=1e8,
                exponent={("steel-316", "ptfe"): 1.6, ("ptfe", "ptfe"): 2.0},
                right_wall=Wall(stiffness=2e8),
            ),
        ),
    ],
    ids=["shapes", "all contacts", "pairs of materials"],
)
def test_contacts_of_a_chain_file_are_those_of_python(text, expected, tmp_path):
    file = tmp_path / "chain.toml"
    file.write_text(text, "utf-8")
    read = hc.load_chain(file)
    assert fingerprint(read) == fingerprint(expected)
    np.testing.assert_array_equal(read.contact_exponents, expected.contact_exponents)
    file.write_text(hc.chain_as_toml(read), "utf-8")
    assert fingerprint(hc.load_chain(file)) == fingerprint(expected)


def test_exponents_by_pairs_are_written_as_pairs(tmp_path):
    chain = STEEL_AND_PTFE.replace(
        exponent={("steel-316", "ptfe"): 1.6, ("ptfe", "ptfe"): 2.0}, stiffness=1e8
    )
    file = tmp_path / "chain.toml"
    file.write_text(hc.chain_as_toml(chain), "utf-8")
    # The exponent of a wall that is added later also follows from the pairs.
    wall = Wall(stiffness=1e8)
    again = hc.load_chain(file).replace(right_wall=wall)
    assert (
        again.contact_exponents[-1] == chain.replace(right_wall=wall).contact_exponents[-1] == 2.0
    )


def test_shapes_can_be_varied_in_sweeps():
    balls = Chain.from_materials(5e-3, "brass", beads=4, velocity=0.01)
    shape = {"shape": "crossed-cylinders", "contacts": [2]}
    found = hc.sweep({
        "chain": {"radii": 5e-3, "beads": 4, "materials": "brass", "velocity": 0.01,
                  "with_contacts": shape},
        "axes": {"with_contacts.angle": [30.0, 90.0]},
        "sweep": {"methods": ["simulate"], "keep": ["peak_force"]},
    })  # fmt: skip
    for angle, forces in zip((30.0, 90.0), found.peak_force.values[:, 0], strict=True):
        shaped = balls.with_contacts({2: hc.CrossedCylinders(angle=angle)})
        # The sweep uses simulate_many.
        np.testing.assert_allclose(forces, hc.simulate(shaped).pulse().peak_force, rtol=1e-11)


def test_strikers_are_like_the_first_contact():
    struck = MIXED.struck_by(count=2, stiffness=1.0)
    assert struck.loss[:3] == (hc.Dashpot(0.1),) * 3
    np.testing.assert_array_equal(struck.exponent[:4], [2.0, 2.0, 2.0, 1.5])


@pytest.mark.parametrize("axes", [(1.0, 1.0), (1.0, 0.7), (3.0, 0.2), (1.0, 0.01)])
def test_crossed_cylinders_by_the_integrals_of_hertz(axes):
    """For an ellipse (a, b): force, curvatures and approach by quadrature; Johnson, Sec. 4.2."""
    a, b = axes
    size = 3.0 / (4.0 * math.pi)  # of a force and a modulus of one

    def integral(*powers):
        def integrand(t):  # w = t^2
            one, other = a * a + t * t, b * b + t * t
            return 2.0 / (one ** powers[0] * other ** powers[1])

        return quad(integrand, 0.0, math.inf, epsabs=0.0, epsrel=1e-12, limit=500)[0]

    approach = size * integral(0.5, 0.5)
    small, large = size * integral(1.5, 0.5), size * integral(0.5, 1.5)
    # Equal cylinders: A + B = 1/R and B - A = cos(angle)/R.
    radius = 1.0 / (small + large)
    angle = math.degrees(math.acos(min(1.0, (large - small) * radius)))
    shape = hc.CrossedCylinders(radius, angle=angle)
    assert shape.stiffness(1.0) * approach**1.5 == pytest.approx(1.0, rel=1e-9)


def test_crossed_cylinders_like_a_sphere_on_a_plane():
    radius, modulus = 4e-3, 1e11
    k = hc.CrossedCylinders(radius).stiffness(modulus)
    assert k == pytest.approx(4.0 / 3.0 * modulus * math.sqrt(radius), rel=1e-15)


def test_a_cone_by_its_pressure():
    """Sneddon: d = (pi/2) a cot(theta), mean pressure E*/2 cot(theta) on a circle of radius a."""
    theta, modulus, a = math.radians(80.0), 2e11, 1e-5
    overlap = 0.5 * math.pi * a / math.tan(theta)
    force = 0.5 * modulus / math.tan(theta) * math.pi * a**2
    assert hc.Cone(80.0).stiffness(modulus) * overlap**2 == pytest.approx(force, rel=1e-13)


def test_shapes_at_walls_and_invalid_ones():
    chain = STEEL_AND_PTFE.replace(right_wall=Wall.of("brass"))
    shaped = chain.with_contacts({6: hc.Cone(60.0)})
    modulus = contact_modulus(hc.material("ptfe"), hc.material("brass"))
    assert shaped.wall_stiffness[1] == hc.Cone(60.0).stiffness(modulus)
    np.testing.assert_array_equal(shaped.contact_exponents, [1.5] * 6 + [2.0])
    given = chain.replace(
        right_wall=Wall(stiffness=shaped.wall_stiffness[1], exponent=2.0, material="brass")
    )
    overlaps = np.full(7, 1e-6)
    expected = hc.hertz_range(given, overlaps).yield_ratio
    np.testing.assert_array_equal(hc.hertz_range(shaped, overlaps).yield_ratio, expected)
    for shapes, said in (
        ({0: hc.Cone(60.0)}, "has no left_wall"),
        ({6: hc.CrossedCylinders()}, "need a radius where they are not at"),
        ({7: hc.Cone(60.0)}, "from 0 to 6, where 0 and 6 are walls, got 7"),
        ({1: hc.Wall()}, "shape of contact 1 must be a CrossedCylinders, Cone or Pad"),
    ):
        with pytest.raises(InputError, match=said):
            chain.with_contacts(shapes)
    with pytest.raises(InputError, match="follows from materials"):
        Chain.uniform(3).with_contacts(hc.Cone(60.0))


@pytest.mark.parametrize("alpha", [2.0, 3.0, 10.0])
def test_restitution_vanishes_with_strong_damping(alpha):
    """As gamma^(-1/(alpha - 2 p/(p + 1))), the speed at which damping and elastic force are equal
    in a collision of this speed."""
    power = 1.0 / (alpha - 3.0 / 2.5)
    gamma = 10.0 ** min(6.0 / power, 30.0)
    found = [hc.VelocityPower(by * gamma, alpha).restitution(1.0) for by in (1.0, 100.0)]
    assert found[1] / found[0] == pytest.approx(100.0**-power, rel=1e-3)
    assert hc.VelocityPower(1e300, alpha).restitution(1.0) == 0.0


@pytest.mark.parametrize("attractive", [True, False])
@pytest.mark.parametrize("gamma", [1e9, 1e150, 1e300])
def test_restitution_of_the_strongest_dashpots_is_zero(gamma, attractive):
    law = hc.Dashpot(gamma, attractive)
    assert law.restitution(1.0) == pytest.approx(0.0, abs=1e-14)
    assert law.restitution(1.0, stiffness=1e-300) == pytest.approx(0.0, abs=1e-14)


@pytest.mark.parametrize("gamma", [1e-300, 1e-20, 1e-14, 1e-10, 1e-7])
def test_restitution_of_the_weakest_losses(gamma):
    """1 - e = gamma/mu times the integral of d' over the elastic collision, over the speed."""
    law, speed, mass, k = hc.Dashpot(gamma), 0.7, 0.3, 2.0
    overlap = (2.5 * mass * speed**2 / (2.0 * k)) ** 0.4
    lost = gamma * 2.0 * overlap * beta(0.4, 1.5) / 2.5 / (mass * speed)
    found = law.restitution(speed, reduced_mass=mass, stiffness=k)
    assert found <= 1.0
    # The rounding error of 1, the error of the integration, and the square of the loss.
    assert 1.0 - found == pytest.approx(lost, rel=2e-8 + 10.0 * lost, abs=3e-16)


@pytest.mark.parametrize(("speed", "expected"), [
    # Integrated with SciPy: a steel ball of 10 mm diameter on a steel plate, A = 0.8 us.
    (0.3132091952673165, 0.9051522960), (0.5424942396007537, 0.8949388647),
    (0.7672027111526654, 0.8879860567),
])  # fmt: skip
def test_restitution_of_a_contact_of_a_chain(speed, expected):
    balls = Chain.from_materials("5 mm", "steel-52100", beads=2, right_wall=Wall())
    for law in (hc.Viscoelastic("0.8 us"), hc.Viscoelastic(0.8e-6)):
        for given in (speed, f"{speed!r} m/s"):
            assert law.restitution(given, chain=balls, contact=2) == pytest.approx(
                expected, abs=1e-8
            )
    mass, k = float(balls.masses[1]), float(balls.contact_stiffness[2])
    assert law.restitution(speed, reduced_mass=f"{1e3 * mass!r} g", stiffness=k) == pytest.approx(
        expected, abs=1e-8
    )


def test_restitution_of_elastic_plastic_contacts_of_a_chain():
    balls = Chain.from_materials("5 mm", "steel-52100", beads=2, loss=hc.ElasticPlastic())
    run = hc.simulate(balls.replace(velocities=[0.8, 0.0]), until=5e-4)
    closing = run.velocities[-1, 1] - run.velocities[-1, 0]
    law = hc.ElasticPlastic()
    assert law.restitution(0.8, chain=balls) == pytest.approx(closing / 0.8, rel=1e-6)
    assert law.restitution(0.8, chain=balls) < 0.99
    assert law.restitution(0.2, chain=balls) == 1.0


@pytest.mark.parametrize(("law", "options", "said"), [
    (hc.Viscoelastic("0.8 us"), {}, "units \\(time\\) depends on the bodies"),
    (hc.Viscoelastic("0.8 us"), {"stiffness": 1e9}, "depends on the bodies"),
    (hc.Viscoelastic(0.1), {"reduced_mass": "4 g"}, "give both reduced_mass and stiffness"),
    (hc.Viscoelastic(0.1), {"chain": Chain.uniform(3), "contact": 0}, "this end .* is free"),
    (hc.Viscoelastic(0.1), {"chain": Chain.uniform(3), "stiffness": 1.0}, "not both"),
    (hc.Viscoelastic(0.1), {"chain": 3}, "chain must be a Chain, got 3"),
])  # fmt: skip
def test_restitution_without_the_bodies_is_refused(law, options, said):
    with pytest.raises(InputError, match=said):
        law.restitution(0.1, **options)


def test_restitution_of_a_law_in_si_units_without_bodies_warns():
    with pytest.warns(hc.InputWarning, match="in scaled variables"):
        hc.Viscoelastic(0.8e-6).restitution(0.1)


def test_restitution_beyond_floating_point_numbers_is_refused():
    with pytest.raises(hc.InputError, match="outside the range of floating-point numbers"):
        hc.Dashpot(1.0).restitution(1e200, reduced_mass=1e300)


def test_a_wall_of_a_chain_with_given_stiffness():
    """The advice is exact: sqrt(R) against sqrt(R/2), for the same elastic modulus."""
    said = r"in a chain with given stiffness; give Wall\(stiffness=\.\.\.\), which is sqrt\(2\)"
    for chain in (
        Chain.dimer(0.3, beads=8),
        Chain(np.ones(5), units="SI", masses=np.ones(5), stiffness=np.ones(4)),
    ):
        with pytest.raises(InputError, match=said):
            chain.replace(right_wall=Wall())
        assert chain.replace(right_wall=Wall(stiffness=2e9)).wall_stiffness == (0.0, 2e9)
    steel = Chain.from_materials(5e-3, "steel-316", beads=5).replace(right_wall=Wall())
    ratio = steel.wall_stiffness[1] / steel.stiffness[-1]
    assert ratio == pytest.approx(np.sqrt(2.0), rel=1e-14)
    with pytest.raises(
        InputError, match=r"only for Hertz contacts \(exponent 1.5\), not for p = 2;"
    ):
        Chain.uniform(5).replace(exponent=2.0, right_wall=Wall())


def test_energy_of_dented_contacts_is_that_of_their_unloading_curve():
    """Thornton's curve from any largest overlap, in units of the point of yield."""
    random = np.random.default_rng(4)
    law, size = hc.ElasticPlastic(yield_overlap=1e-6), 2000
    k, furthest = 10.0 ** random.uniform(0, 10, size), 1e-6 * 10.0 ** random.uniform(0.1, 4, size)
    peak = k * 1e-3 * (1.5 * furthest - 0.5e-6)
    width, part = peak / (k * np.sqrt(furthest)), random.uniform(0.01, 1.0, size)
    overlap, force = furthest - (1.0 - part) * width, peak * part**1.5
    contacts = ContactArrays(1.5, k, np.ones(size))
    stored = law.stored_energy(overlap, force, contacts)
    np.testing.assert_allclose(stored, 0.4 * force * part * width, rtol=1e-10)
    returned = 0.4 * peak * width
    np.testing.assert_allclose(law.largest_overlap(returned, contacts), furthest, rtol=1e-12)
    elastic = 1e-6 * random.uniform(0.0, 1.0, size)
    stored = law.stored_energy(elastic, k * elastic**1.5, contacts)
    np.testing.assert_allclose(stored, 0.4 * k * elastic**2.5, rtol=1e-12)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"loss": hc.Restitution(0.93)}, "restitution 0.93"),
        ({"loss": hc.Viscoelastic("0.5 us"), "right_wall": Wall()}, "viscoelastic 0.5 us"),
        ({"loss": hc.WaltonBraun(0.81)}, "walton-braun 0.81"),
        ({"loss": hc.ElasticPlastic()}, "elastic-plastic"),
        ({"loss": hc.VelocityPower(2.0, alpha=1.2)}, "velocity-power (gamma 2, alpha 1.2)"),
        ({"loss": hc.Restitution(0.93), "right_wall": Wall(loss=hc.Elastic())},
         "restitution 0.93 between beads"),
        ({"right_wall": Wall(loss=hc.Restitution(0.93))}, "mixed losses"),
        ({"loss": [hc.Restitution(0.9), hc.Restitution(0.8)]}, "mixed losses"),
    ],
)  # fmt: skip
def test_descriptions_state_the_law_with_its_value(changes, words):
    chain = Chain.from_materials("5 mm", "steel-316", beads=3).replace(**changes)
    assert chain.description.endswith(f", {words}")
