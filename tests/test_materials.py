"""Materials, contact stiffness from them, and the scales between SI and the paper's variables."""

import math
import re
import warnings
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import hertzchain as hc
from hertzchain import Chain, InputError, Material, Scales, Wall
from hertzchain.chain.materials import RIGID, catalogue, contact_modulus, sphere_stiffness
from hertzchain.recorded_warnings import ignore_warnings
from hertzchain.simulation.yielding import (
    dented_chain,
    elastic_springs,
    peak_with_yielding_contacts,
)

STEEL = hc.material("steel-52100")


def test_catalogue_has_common_materials():
    wanted = {
        "steel-52100", "steel-304", "steel-316", "steel-440c", "brass", "bronze", "aluminium",
        "titanium", "tungsten-carbide", "silicon-nitride", "alumina", "glass", "ptfe", "nylon",
        "polycarbonate", "acrylic", "rubber",
    }  # fmt: skip
    assert wanted <= set(catalogue())


def test_the_catalogue_is_a_dictionary_shown_as_a_table():
    found = catalogue()
    assert isinstance(found, dict)
    header, *rows = repr(found).splitlines()
    assert [row.split()[0] for row in rows] == [*found]
    assert header.split("  ")[0] == "material"
    (glass,) = (row.split() for row in rows if row.startswith("glass"))
    assert glass == ["glass", "2500", "69", "0.2"]
    html = found._repr_html_()
    assert html.count("<tr") == len(found) + 1
    assert ">2034</td>" in html
    with pytest.raises(InputError, match=r"unknown material 'stel' .did you mean 'steel-52100'"):
        found["stel"]


def test_replace_changes_fields_and_checks_them():
    found = STEEL.replace(young=200e9)
    assert found == replace(STEEL, young=200e9)
    with pytest.raises(InputError, match=r"unknown field of a material 'yong' .did you mean"):
        STEEL.replace(yong=200e9)
    with pytest.raises(InputError, match="poisson"):
        STEEL.replace(poisson=0.7)


@pytest.mark.parametrize("name", catalogue())
def test_catalogue_numbers_are_possible_and_sourced(name):
    found = hc.material(name)
    assert 900.0 < found.density < 20_000.0
    assert 1e6 <= found.young < 1e12
    assert 0.0 < found.poisson < 0.5
    assert len(found.source) > 20
    # Everything but rubber yields at a strain of 0.05% to 4%.
    if found.yield_strength is not None:
        assert 5e-4 < found.yield_strength / found.young < 0.04


def test_steel_balls_of_the_literature():
    # Published check: E = 203 GPa, nu = 0.3, rho = 7780, R = 5 mm, struck with 1 m/s.
    chain = Chain.from_materials(5e-3, "steel-52100", beads=3)
    assert chain.masses[0] == pytest.approx(4.073598e-3, rel=1e-6)
    assert chain.stiffness[0] == pytest.approx(7.435897e9, rel=1e-7)
    assert Scales.of(chain).length == pytest.approx(12.45828e-6, rel=1e-6)


def test_unlike_spheres_bear_as_hertz_says():
    # Worked by hand: 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2, 1/R = 1/R1 + 1/R2.
    one, other = Material("a", 1e3, 2e9, 0.0), Material("b", 1e3, 3e9, 0.5 - 1e-12)
    modulus = 1e9 / (0.5 + 0.75 / 3.0)
    assert contact_modulus(one, other) == pytest.approx(modulus, rel=1e-11)
    chain = Chain.from_materials([0.1, 0.3], [one, other])
    assert chain.stiffness[0] == pytest.approx(4 / 3 * modulus * math.sqrt(0.075), rel=1e-11)


def test_flat_walls_are_stiffer_by_the_known_factors():
    chain = Chain.from_materials(5e-3, STEEL, beads=2)
    pair = chain.stiffness[0]
    own, rigid = chain.replace(left_wall=Wall(), right_wall=Wall.rigid()).wall_stiffness
    assert own == pytest.approx(math.sqrt(2) * pair, rel=1e-14)
    assert rigid == pytest.approx(2 * math.sqrt(2) * pair, rel=1e-14)
    scaled = Chain.uniform(2).replace(left_wall=Wall(), right_wall=Wall.rigid())
    assert scaled.wall_stiffness == pytest.approx((math.sqrt(2), 2 * math.sqrt(2)), rel=1e-15)
    ptfe = chain.replace(right_wall=Wall.of("ptfe")).wall_stiffness[1]
    modulus = contact_modulus(STEEL, hc.material("ptfe"))
    assert ptfe == pytest.approx(float(sphere_stiffness(5e-3, np.inf, modulus)), rel=1e-15)


def test_the_papers_chains_come_back_from_si():
    radii = 5e-3 / 0.95 ** np.arange(30)
    chain = Chain.from_materials(radii, "brass", velocity=3.0)
    scaled = Scales.of(chain).to_scaled(chain)
    papers = Chain.tapered("backward-exponential", 0.05, beads=30)
    assert scaled.features == ()
    np.testing.assert_allclose(scaled.radii, papers.radii, rtol=1e-14)
    np.testing.assert_allclose(scaled.stiffness, papers.stiffness, rtol=1e-14)


def test_there_and_back_is_the_same_chain():
    chain = Chain.from_materials(
        [5e-3, 3e-3, 4e-3], ["brass", "ptfe", "glass"], gaps=[1e-6, 0.0],
        gravity=9.81, left_wall=Wall.of("steel-304", gap=1e-3), loss=hc.Dashpot(3.0),
        drive=hc.TableDrive([0.0, 1e-3], [0.0, 5.0]), velocities=[2.0, -1.0, 0.0],
    )  # fmt: skip
    scales = Scales.of(chain)
    back = scales.to_si(scales.to_scaled(chain))
    for name in ("radii", "masses", "stiffness", "velocities", "gaps", "gravity"):
        np.testing.assert_allclose(getattr(back, name), getattr(chain, name), rtol=1e-14)
    assert back.wall_stiffness == pytest.approx(chain.wall_stiffness, rel=1e-14)
    assert back.left_wall.gap == pytest.approx(1e-3, rel=1e-14)
    assert back.loss.gamma == pytest.approx(3.0, rel=1e-14)
    np.testing.assert_allclose(back.drive.times, [0.0, 1e-3], rtol=1e-14)
    np.testing.assert_allclose(back.drive.values, [0.0, 5.0], rtol=1e-14)


@pytest.mark.parametrize("loss", [hc.Viscoelastic(1e-6), hc.VelocityPower(2.0, 1.81)])
def test_losses_scale_like_the_elastic_forces(loss):
    # A contact in SI and its scaled image have the same force in newtons.
    chain = Chain.from_materials(5e-3, "steel-52100", beads=2, loss=loss)
    scales = Scales.of(chain)
    scaled = scales.to_scaled(chain)
    overlap, rate = 3e-6, 0.4

    def force(chain, d, v):
        k, law = chain.stiffness[0], chain.loss
        if isinstance(law, hc.Viscoelastic):
            return k * (d**1.5 + 1.5 * law.time * d**0.5 * v)
        return k * d**1.5 + law.gamma * v**law.alpha

    in_si = force(chain, overlap, rate)
    image = force(scaled, overlap / scales.length, rate / scales.velocity) * scales.force
    assert image == pytest.approx(in_si, rel=1e-13)


def test_a_pulse_in_newtons_and_seconds():
    chain = Chain.from_materials(5e-3, "steel-52100", beads=60)
    scales = Scales.of(chain)
    pulse = scales.to_si(hc.propagate(scales.to_scaled(chain)))
    # Published check for this chain: 674.659 m/s, 209.121 N, 9.2479 um.
    assert 0.01 / pulse.residence[50] == pytest.approx(674.659, rel=1e-5)
    assert pulse.peak_force[50] == pytest.approx(209.121, rel=1e-5)
    assert pulse.peak_overlap[50] == pytest.approx(9.2479e-6, rel=1e-4)


@pytest.mark.parametrize(
    ("build", "said"),
    [
        (lambda: Material("x", 7800.0, 2e11, 0.5), "poisson of 'x' .* below 0.5, got 0.5"),
        (lambda: Material("x", 7800.0, 2e11, -1.0), "above -1 .* got -1"),
        (lambda: Material("x", 7800.0, 0.0, 0.3), "young of 'x' must be above 0, got 0"),
        (lambda: Material("x", -1.0, 2e11, 0.3), "density of 'x' must be at least 0.001 .* got -1"),
        (lambda: Material("x", 1e30, 2e11, 0.3), "density of 'x' must be .* at most 1e.06, got 1e"),
        (lambda: Material("x", 7800.0, 2e11, 0.3, -5.0), "yield_strength .* above 0, got -5"),
        (lambda: Material("x", 7800.0, float("nan"), 0.3), "young of 'x'"),
        (lambda: hc.material("stel-304"), "did you mean 'steel-304'"),
        (lambda: Chain.from_materials([1e-3, 1e-3], ["brass"]), "2 materials, .* got 1"),
        (lambda: Chain.from_materials(5e-3, "brass"), "give beads"),
        (lambda: Chain.from_materials([5e-3] * 3, "brass", beads=4), "beads = 4, .* 3 radii"),
        (lambda: Chain(np.ones(3), units="SI"), "requires masses or materials"),
        (lambda: Scales.of(Chain.uniform(3)), "belong to a chain in SI"),
        (lambda: Scales(1.0, 0.0, 1.0, 1.0), "mass of the scales must be above 0"),
        (lambda: Scales(1.0, 1.0, 1.0, 1.0).to_scaled(Chain.uniform(3)), "scaled units already"),
        (lambda: Scales(1.0, 1.0, 1.0, 1.0).to_si(3), "cannot convert 3"),
    ],
)
def test_impossible_materials_are_rejected(build, said):
    with pytest.raises(InputError, match=said) as caught:
        build()
    assert "\n" not in str(caught.value)


def test_millimetres_given_as_metres_are_suspected():
    said = (
        "several beads have a diameter of 19 m.*the diameter as '19 mm' or the radius as '9.5 mm'"
    )
    with pytest.warns(hc.InputWarning, match=said):
        Chain.from_materials(9.5, "brass", beads=3)


def test_a_rigid_wall_has_no_compliance():
    assert RIGID.compliance == 0.0
    assert math.isinf(RIGID.sound_speed)


def test_first_yield_is_where_johnson_has_it():
    # Johnson 1985, Eq. (11.20): rho V^2/Y = 26 (Y/E*)^4 for equal spheres of radius R, in the
    # form (1/2) m V^2 = 53 R^3 Y^5/E*^4 of Eq. (11.19), with m and R those of the pair.
    steel = hc.material("steel-304")
    radius, strength = 5e-3, steel.yield_strength
    modulus = contact_modulus(steel, steel)
    mass = 4 / 3 * math.pi * steel.density * radius**3 / 2
    speed = math.sqrt(2 * 53 * (radius / 2) ** 3 * strength**5 / modulus**4 / mass)
    chain = Chain.from_materials(radius, steel, beads=2, velocity=speed)
    # The book rounds to two digits; pressure goes as the speed to the power 2/5.
    assert hc.hertz_range(chain).yield_ratio.max() == pytest.approx(1.0, abs=0.005)


def test_leaving_hertz_is_complained_of_once_each():
    fast = Chain.from_materials(5e-3, "aluminium", beads=5, velocity=200.0)
    violations = hc.hertz_range(fast).violations
    assert len(violations) == 3
    # The ratios have the names that `print(hertz_range)` shows.
    overlap, pressure, speed, *estimated = str(hc.hertz_range(fast)).splitlines()
    assert "estimated before a run" in estimated[0]
    assert "estimated" in repr(hc.hertz_range(fast))
    assert "estimated" not in str(hc.hertz_range(fast, np.zeros(6)))
    # Yield comes first.
    for line, violation in zip((pressure, overlap, speed), violations, strict=True):
        assert violation.startswith(f"{line.split('  ')[0]} is ")
        assert len(violation.split()) < 30
    gentle = Chain.from_materials(5e-3, "aluminium", beads=5, velocity=1e-4)
    assert hc.hertz_range(gentle).violations == ()


def test_a_law_that_yields_is_said_to_replace_other_losses():
    def advice(loss):
        row = Chain.from_materials(5e-3, "steel-52100", beads=5, velocity=1.0, loss=loss)
        return hc.hertz_range(row).violations[0]

    assert advice(None).endswith(
        "reduce the velocity to about 0.42 m/s or use loss=ElasticPlastic()"
    )
    lossy = "use loss=ElasticPlastic(), which replaces the loss of the chain (viscoelastic)"
    assert advice(hc.Viscoelastic(1e-6)).endswith(lossy)
    two = advice([hc.Restitution(0.9), hc.Viscoelastic(1e-6), None, None])
    assert two.endswith("which replaces the losses of the chain (restitution, viscoelastic)")


@pytest.mark.parametrize("speed", [0.45, 0.5, 0.54])
def test_a_small_excess_of_the_pressure_states_the_loss_of_velocity(speed):
    row = Chain.from_materials(5e-3, "steel-52100", beads=2, velocity=speed)
    found = hc.hertz_range(row)
    # Thornton (1997), Eq. (51), with the speed at which the pressure is that at first yield.
    u = (0.43 / speed) * (1.0 / hc.hertz_range(
        row.replace(velocities=[0.43, 0.0])
    ).yield_ratio.max()) ** 2.5  # fmt: skip
    e = (1.2 * 3**0.5 * (1 - u**2 / 6) * (u / (u + 2 * (1.2 - u**2 / 5) ** 0.5)) ** 0.5) ** 0.5
    (stated,) = re.findall(r"yield alone would cost (\S+)% of the velocity", found.violations[0])
    assert float(stated) == pytest.approx(100 * (1 - e), rel=0.5)
    assert stated == f"{100 * (1 - e):.1g}"
    fast = Chain.from_materials(5e-3, "steel-52100", beads=2, velocity=0.6)
    assert "small" not in hc.hertz_range(fast).violations[0]


def test_the_limit_is_called_cautious_for_polymers_only():
    words = "(limit of Hertz's law: 1, cautious for polymers)"
    for name, wall, cautious in (
        ("ptfe", None, True), ("ptfe", "steel-52100", True), ("aluminium", None, False),
    ):  # fmt: skip
        row = Chain.from_materials(5e-3, name, beads=3, velocity=2.0)
        row = row if wall is None else row.replace(right_wall=Wall.of(wall))
        assert (words in hc.hertz_range(row).violations[0]) is cautious


def test_a_soft_wall_is_judged_by_its_own_strength():
    wall = Wall.of("ptfe")
    chain = Chain.from_materials(5e-3, "steel-52100", beads=2, right_wall=wall)
    ratio = hc.hertz_range(chain, [0.0, 0.0, 1e-6]).yield_ratio
    ptfe = hc.material("ptfe")
    pressure = 2 / math.pi * contact_modulus(STEEL, ptfe) * math.sqrt(1e-6 / 5e-3)
    assert ratio[2] == pytest.approx(pressure / 1.6 / ptfe.yield_strength, rel=1e-12)
    assert ratio[1] == 0.0


def test_only_chains_of_materials_have_limits():
    with pytest.raises(InputError, match="require materials"):
        hc.hertz_range(Chain.uniform(3))
    with pytest.raises(InputError, match="6 numbers for the overlap"):
        hc.hertz_range(Chain.from_materials(5e-3, "brass", beads=5), [0.0] * 9)


@pytest.mark.parametrize(
    ("young", "radius", "reason"),
    [
        (1e11, 1e-110, "bead 1 has mass 0,"),
        (math.inf, 5e-3, "contact 1 has stiffness inf, .* use Wall.rigid"),
    ],
)
@pytest.mark.filterwarnings("ignore:bead 1 has a diameter")
def test_bodies_without_finite_mass_are_rejected(young, radius, reason):
    odd = Material("odd", density=7800.0, young=young, poisson=0.3)
    with pytest.raises(InputError, match=reason):
        Chain.from_materials(radius, odd, beads=3)


def first_pressure(force, chain, contact):
    """Johnson 1985, Eq. (4.24), over the pressure at first yield of the softer bead."""
    one, other = chain.materials[contact - 1 : contact + 1]
    radius = 1 / sum(1 / chain.radii[contact - 1 : contact + 1])
    pressure = np.cbrt(6 * force * contact_modulus(one, other) ** 2 / math.pi**3 / radius**2)
    return pressure / 1.6 / min(one.yield_strength, other.yield_strength)


@pytest.mark.parametrize("stiffness", [8.8e5, 1e7, 1e8])
def test_the_pressure_on_a_wall_of_given_stiffness_follows_from_its_force(stiffness):
    row = Chain.from_materials(diameters="20 mm", materials=STEEL, beads=20).struck_by(velocity=0.1)
    walled = row.replace(right_wall=Wall(stiffness=stiffness))
    with warnings.catch_warnings():
        warnings.simplefilter("error", hc.ModelRangeWarning)
        run = hc.simulate(walled, until="5 ms", times=0)
    force = run._wall_force("right").largest_so_far
    modulus, radius = contact_modulus(STEEL, STEEL), 10e-3
    pressure = np.cbrt(6 * force * modulus**2 / math.pi**3 / radius**2)
    found = hc.hertz_range(walled, run.largest_overlaps)
    assert found.yield_ratio[-1] == pytest.approx(pressure / 1.6 / STEEL.yield_strength, rel=1e-6)
    # Johnson 1985, Eq. (4.22), for the radius of the circle of contact.
    circle = np.cbrt(3 * force * radius / 4 / modulus)
    assert found.overlap_ratio[-1] == pytest.approx((circle / radius) ** 2, rel=1e-6)
    assert list(found.given.nonzero()[0]) == [walled.beads]


def test_a_contact_of_given_stiffness_yields_at_the_force_of_its_materials():
    row = Chain.from_materials(5e-3, STEEL, beads=4)
    stiffness = row.stiffness * [1.0, 1e-3, 1.0]
    soft = row.replace(stiffness=stiffness)
    # Johnson 1985, Eq. (4.24): the force at which the largest pressure is 1.6 Y.
    yielding = math.pi**3 * 2.5e-3**2 / 6 * (1.6 * STEEL.yield_strength) ** 3
    yielding /= contact_modulus(STEEL, STEEL) ** 2
    for part in (0.99, 1.01):
        overlaps = (part**3 * yielding / stiffness) ** (2 / 3)
        found = hc.hertz_range(soft, [0.0, overlaps[1], 0.0])
        assert found.yield_ratio[2] == pytest.approx(part, rel=1e-9)
        assert len(found.violations) == (part > 1.0)
    (violation,) = found.violations
    assert "at contact 2 (limit of Hertz's law: 1) for spheres of these materials" in violation
    assert "loss=ElasticPlastic(yield_overlap=...)" in violation


def test_the_material_that_yields_is_named():
    wall = hc.Wall.of("steel-304")
    row = Chain.from_materials(3e-3, STEEL, beads=2, velocity=0.05, right_wall=wall)
    (pressure, *_) = hc.hertz_range(row).violations
    assert "at the right wall in steel-304 (limit of Hertz's law: 1)" in pressure
    # Two equal bodies yield together.
    equal = hc.hertz_range(row.replace(velocities=[2.0, 0.0], right_wall=None)).violations[0]
    assert "at contact 1 (limit of Hertz's law: 1)" in equal


def advice_on_yield(chain):
    """The advice after the pressure of a run, and the chain that follows it, if there is one."""
    with ignore_warnings(hc.ModelRangeWarning):
        overlaps = hc.simulate(chain, times=0).largest_overlaps
    (pressure, *_) = hc.hertz_range(chain, overlaps).violations
    assert pressure.startswith("pressure / yield is")
    return pressure.partition("ElasticPlastic")[2]


@pytest.mark.parametrize(("wall", "advised"), [
    (hc.Wall.of("aluminium"), True),
    # The wall yields first, and keeps its own law.
    (replace(hc.Wall.of("aluminium"), loss=hc.Elastic()), False),
    (replace(hc.Wall.of("aluminium"), loss=hc.Restitution(0.9)), False),
    # A spring with a law of its own keeps it, and the balls yield.
    (hc.Wall("1 kN/mm", exponent=1, loss=hc.Dashpot("1 kg/s")), True),
])  # fmt: skip
def test_a_law_that_yields_is_advised_where_the_contact_then_has_it(wall, advised):
    row = Chain.from_materials(5e-3, STEEL, beads=4, velocity=1.0, right_wall=wall)
    text = advice_on_yield(row)
    assert text == ("()" if advised else "")
    if advised:
        after = row.replace(loss=hc.ElasticPlastic())
        assert after.right_wall.loss == wall.loss
        overlaps = hc.simulate(after, times=0).largest_overlaps
        assert not any("yield is" in each for each in hc.hertz_range(after, overlaps).violations)


def test_a_law_that_yields_is_not_advised_where_it_is_given_or_rejected():
    row = Chain.from_materials(5e-3, STEEL, beads=4, velocity=1.0)
    listed = row.replace(loss=[hc.ElasticPlastic("5 GPa"), None, None])
    assert advice_on_yield(row) == "()"
    assert advice_on_yield(listed) == ""
    cone = row.with_contacts({1: hc.Cone(80.0)})
    assert advice_on_yield(cone) == ""
    with pytest.raises(hc.InputError, match="law of spheres"):
        cone.replace(loss=hc.ElasticPlastic())
    # A linear spring between the last ball and a cap stays elastic without a law of its own.
    pad = row.with_cap("5 g", stiffness="1 kN/mm", exponent=1.0)
    assert advice_on_yield(pad) == "()"
    laws = pad.replace(loss=hc.ElasticPlastic()).contact_losses
    assert [law.yields for law in laws] == [True] * 4 + [False, True]


def test_the_peak_with_contacts_that_yield_needs_a_contact_that_yields():
    wall = replace(hc.Wall.of("aluminium"), loss=hc.Elastic())
    row = Chain.from_materials(5e-3, STEEL, beads=4, velocity=0.2)
    with ignore_warnings(hc.ModelRangeWarning):
        own = hc.simulate(row.replace(right_wall=wall))
        free = hc.simulate(row.replace(right_wall=replace(wall, loss=None)))
    assert hc.hertz_range(own.chain, own.largest_overlaps).largest_yield_ratio > 1.0
    assert peak_with_yielding_contacts(own) is None
    assert peak_with_yielding_contacts(free).value < 0.9 * free.wall_force().peak


@pytest.mark.parametrize("side", ["left", "right"])
def test_a_pad_stays_elastic_where_the_balls_yield(side):
    row = Chain.from_materials(2.4e-3, STEEL, beads=4, velocity=3.0)
    pad = hc.Wall("1 kN/mm", exponent=1)
    row = row.replace(**{f"{side}_wall": pad})
    with ignore_warnings(hc.ModelRangeWarning):
        run = hc.simulate(row)
        after = hc.simulate(row.replace(loss=hc.ElasticPlastic()))
    (pressure, *_) = hc.hertz_range(row, run.largest_overlaps).violations
    assert pressure.endswith("or use loss=ElasticPlastic()")
    assert dented_chain(row) == after.chain
    elastic, yielding = (row.masses @ each.velocities[-1] ** 2 for each in (run, after))
    assert yielding < 0.9 * elastic
    # The same as with a law of its own, as the law of pairs of materials, and in a list.
    own = row.replace(**{f"{side}_wall": replace(pad, loss=hc.Elastic())})
    laws = own.replace(loss=hc.ElasticPlastic()).contact_losses
    contact = 0 if side == "left" else 4
    assert [law.yields for law in laws[:contact] + laws[contact + 1 :]] == [True] * 4
    for loss in ({"others": hc.ElasticPlastic()}, [hc.ElasticPlastic()] * 3):
        assert row.replace(loss=loss).contact_losses == laws
    assert elastic_springs(after.chain) == [f"the {side} wall is a spring and stays elastic"]
    assert elastic_springs(row) == []
    # Another law is that of the spring, too.
    damped = row.replace(loss=hc.Dashpot("1 kg/s")).contact_losses
    assert damped == (hc.Dashpot("1 kg/s"),) * 5
    # The warning about a pad between balls does not advise a law that is rejected.
    cone = row.with_contacts({1: hc.Cone(80.0)})
    assert "ElasticPlastic" not in "".join(hc.hertz_range(cone).violations)
    # Laws of single contacts that they do not describe, and of chains without another contact.
    given = row.replace(**{f"{side}_wall": replace(pad, exponent=2, stiffness=1e9)})
    assert given.replace(loss=hc.ElasticPlastic()).contact_losses == laws
    with pytest.raises(hc.InputError, match="p = 1: use .* or loss=Elastic.. for this contact"):
        row.replace(**{f"{side}_wall": replace(pad, loss=hc.ElasticPlastic())})
    ball = Chain.from_materials(2.4e-3, STEEL, beads=1, velocity=3.0)
    with pytest.raises(hc.InputError, match="law of spheres"):
        ball.replace(loss=hc.ElasticPlastic(), **{f"{side}_wall": pad})


def test_no_velocity_is_advised_for_overlaps_of_contacts_that_yield():
    soft = Chain.from_materials(5e-3, "steel-316", beads=4, velocity=5.0)
    dented = soft.replace(loss=hc.ElasticPlastic())
    overlap = hc.hertz_range(dented, [3e-4] * 3).violations[0]
    assert overlap.endswith(
        "(limit of contacts that yield: 0.1); beyond 0.1, forces are not a prediction; reduce the "
        "velocity"
    )
    assert "reduce the velocity to about " in hc.hertz_range(soft, [1e-4] * 3).violations[-1]


def test_contacts_of_other_exponents_are_compared_by_their_force():
    row = Chain.from_materials(5e-3, STEEL, beads=3).with_contacts({1: hc.Cone(80.0)})
    force = 100.0
    overlaps = (force / row.stiffness) ** (1 / row.exponent)
    found = hc.hertz_range(row, overlaps)
    assert found.yield_ratio[1] == pytest.approx(first_pressure(force, row, 1), rel=1e-9)
    assert found.yield_ratio[1] == pytest.approx(found.yield_ratio[2], rel=1e-9)
    assert list(found.given) == [False, True, False, False]


@pytest.mark.parametrize("use", [hc.equilibrium, hc.spectrum])
def test_precompression_beyond_yield_is_reported(use):
    dimer = Chain.dimer(diameters=["10 mm", "6 mm"], materials=["steel-52100", "ptfe"], beads=20)
    held = dimer.replace(precompression=30, held_by="force")
    ratio = hc.hertz_range(held).yield_ratio
    assert ratio[1:-1] == pytest.approx(first_pressure(30.0, held, 1), rel=1e-9)
    assert ratio[0] == ratio[-1] == 0.0
    with pytest.warns(hc.ModelRangeWarning) as caught:
        use(held)
    assert len(caught) == 2
    assert all("reduce the precompression" in str(each.message) for each in caught)
    assert "the static force alone gives 8.03; " in str(caught[0].message)


def test_a_column_beyond_yield_is_told_to_reduce_gravity():
    column = Chain.from_materials(
        2.5e-3, "ptfe", beads=60, velocity=0.0, gravity=98.1, right_wall=Wall()
    )
    weight = 98.1 * float(column.masses[0])
    ratio = hc.hertz_range(column).yield_ratio[1:-1]
    expected = [first_pressure(k * weight, column, k) for k in range(1, 60)]
    np.testing.assert_allclose(ratio, expected, rtol=1e-9)
    with pytest.warns(hc.ModelRangeWarning, match="alone gives .*; use fewer beads or use loss"):
        hc.simulate(column, until=1e-5)
    slow = column.replace(gravity=9.81)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        hc.equilibrium(slow)


def test_a_weak_impact_adds_to_the_static_overlap():
    # Two beads under a constant force are a single degree of freedom, integrated by SciPy.
    force, speed = 40.0, 0.05
    held = Chain.from_materials(
        5e-3, "steel-52100", beads=2, velocity=speed, precompression=force, held_by="force"
    )
    k, mass = float(held.stiffness[0]), float(held.masses[0]) / 2
    rest = (force / k) ** (2 / 3)

    def motion(_, y):
        return y[1], (force - k * max(y[0], 0.0) ** 1.5) / mass

    def turns(_, y):
        return y[1]

    turns.terminal = True
    end = solve_ivp(motion, (0, 1e-3), (rest, speed), events=turns, rtol=1e-12, atol=1e-18)
    found = hc.hertz_range(held).overlap_ratio[1]
    assert found == pytest.approx(end.y_events[0][0][0] / 2.5e-3, rel=1e-9)
    fast = held.replace(velocities=[1.0, 0.0])
    assert "reduce the velocity" in hc.hertz_range(fast).violations[0]
    both = held.replace(velocities=[1.0, 0.0], precompression=2e3)
    assert "reduce the precompression and the velocity" in hc.hertz_range(both).violations[-1]


def test_a_name_of_several_words_follows_the_beads():
    steel = hc.Material("my steel", density=7800.0, young=2.1e11, poisson=0.3)
    for material, words in (
        ("steel-316", "14 steel-316 beads, "),
        (steel, "14 beads of my steel, "),
    ):
        chain = hc.Chain.from_materials(5e-3, material, beads=14, velocity=1e-3)
        assert chain.description.startswith(words)


def test_a_velocity_that_is_far_away_is_no_advice():
    """Twice the pressure at yield needs 0.18 of the velocity, and 1.4 times it 0.43."""
    for speed, said in ((0.7, "reduce the velocity to about"), (3.0, "; use loss=")):
        chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=5, velocity=speed)
        (first, *_) = hc.hertz_range(chain).violations
        assert said in first
        assert ("reduce" in first) == (speed < 1.0)


@pytest.mark.parametrize("run", [hc.propagate, hc.bca, hc.simulate])
@pytest.mark.parametrize(("material", "speed"), [("steel-52100", 1.0), ("aluminium", 200.0)])
def test_no_limit_is_exceeded_at_the_advised_velocity(run, material, speed):
    """All limits are named at the first velocity, and one velocity meets all of them."""
    row = hc.Chain.tapered("forward-exponential", 0.05, first_diameter="10 mm", beads=60,
                           material=material, velocity=speed)  # fmt: skip
    with pytest.warns(hc.ModelRangeWarning) as caught:
        run(row)
    first, *others = (str(each.message) for each in caught)
    if speed == 1.0 and run is not hc.bca:
        simulate = "" if run is hc.simulate else "simulate with "
        assert first.endswith(f"; use {simulate}loss=ElasticPlastic()")
    (advised,) = {re.search(r"to about (\S+) m/s", each)[1] for each in others}
    assert any(each.endswith(" m/s (all limits)") for each in others)
    slow, fast = (row.replace(velocities=row.velocities * float(advised) / speed * factor)
                  for factor in (1.0, 1.2))  # fmt: skip
    with warnings.catch_warnings():
        warnings.simplefilter("error", hc.ModelRangeWarning)
        run(slow)
    with pytest.warns(hc.ModelRangeWarning):
        run(fast)


def test_no_velocity_is_advised_for_losses_that_depend_on_it():
    lossy = hc.Chain.from_materials(5e-3, "ptfe", beads=9, loss=hc.Viscoelastic(1e-4))
    for loss, known in ((lossy.loss, False), (hc.Restitution(0.8), True)):
        found = hc.hertz_range(lossy.replace(loss=loss), [1e-4] * 8)
        assert ("to about" in found.violations[-1]) == known


def test_a_law_with_yield_is_no_advice_beyond_its_range():
    """PTFE beyond an overlap of 0.1 of the radius, and far beyond yield but below this overlap."""
    for speed, beyond in ((10.0, True), (0.5, False)):
        found = hc.hertz_range(hc.Chain.from_materials(5e-3, "ptfe", beads=5, velocity=speed))
        assert (found.overlap_ratio.max() > 0.1) == beyond
        assert ("choose another material" in found.violations[0]) == beyond
        assert ("ElasticPlastic" in found.violations[0]) == (not beyond)


def test_hardened_stainless_balls_are_stronger_than_austenitic_ones():
    """Pressures at first yield are proportional to the strength: 275 ksi against 30 ksi."""
    hard, soft = hc.material("steel-440c"), hc.material("steel-304")
    assert hard.yield_strength == pytest.approx(275 * 6.894757e6, rel=1e-3)
    assert hard.yield_strength / soft.yield_strength > 9.0
    with pytest.raises(InputError, match="'steel-304', 'steel-316' or 'steel-440c'"):
        hc.material("stainless steel")
