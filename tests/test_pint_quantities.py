"""Quantities with units as input."""

import numpy as np
import pint
import pytest

import hertzchain as hc
from hertzchain.collision import collision_overlap, hertz_stiffness
from hertzchain.simulation.state import fingerprint
from hertzchain.theory import dispersion, long_wave
from hertzchain.theory.modified_bca import printed_velocity

UNIT = pint.UnitRegistry()


def test_a_chain_described_in_everyday_units():
    radii = np.array([5.0, 4.0]) * UNIT.mm
    chain = hc.Chain.from_materials(
        radii, "brass", gaps=[2 * UNIT.um],
        gravity=981 * UNIT.cm / UNIT.s**2, right_wall=hc.Wall(gap=0.1 * UNIT.mm),
        loss=hc.Viscoelastic(3 * UNIT.us),
        drive=hc.SineBurst(2 * UNIT.kN, 5 * UNIT.kHz),
        velocities=[1.2, 0.0] * UNIT.m / UNIT.s,
    )  # fmt: skip
    plain = hc.Chain.from_materials(
        [5e-3, 4e-3], "brass", gaps=[2e-6], gravity=9.81, right_wall=hc.Wall(gap=1e-4),
        loss=hc.Viscoelastic(3e-6), drive=hc.SineBurst(2e3, 5e3), velocities=[1.2, 0.0],
    )  # fmt: skip
    for name in ("radii", "masses", "stiffness", "velocities", "gaps", "gravity"):
        np.testing.assert_allclose(getattr(chain, name), getattr(plain, name), rtol=1e-14)
    assert chain.right_wall.gap == pytest.approx(1e-4, rel=1e-14)
    assert chain.loss.time == pytest.approx(3e-6, rel=1e-14)
    assert chain.drive.amplitude == pytest.approx(2e3)
    assert chain.drive.frequency == pytest.approx(5e3)


def test_one_radius_and_the_speed_of_the_strike():
    chain = hc.Chain.from_materials(
        9.525 / 2 * UNIT.mm, "brass", beads=3, velocity=3 * UNIT.km / UNIT.hour
    )
    assert chain.radii[2] == pytest.approx(9.525e-3 / 2)
    assert chain.velocities[0] == pytest.approx(3 / 3.6)


def test_own_materials_may_have_units():
    mine = hc.Material("mine", 7.8 * UNIT.g / UNIT.cm**3, 200 * UNIT.GPa, 0.3, 400 * UNIT.MPa)
    assert (mine.density, mine.young) == pytest.approx((7800.0, 200e9))
    assert mine.yield_strength == pytest.approx(400e6)


def test_the_wrong_dimension_is_rejected():
    with pytest.raises(hc.InputError, match="velocity must be convertible to m/s.*meter"):
        hc.Chain.from_materials(5e-3, "brass", beads=3, velocity=3 * UNIT.m)
    with pytest.raises(hc.InputError, match="density of 'x' must be convertible to kg/m"):
        hc.Material("x", 3 * UNIT.m, 2e11, 0.3)


def test_scaled_chains_take_plain_numbers_only():
    with pytest.raises(hc.InputError, match="gap has a unit .* scaled variables"):
        hc.Chain.uniform(3).replace(gaps=[1 * UNIT.m, 0 * UNIT.m])


Q = UNIT.Quantity
BALLS = hc.Chain.from_materials(5e-3, "steel-52100", beads=4, velocity=0.1)
SCALED = hc.Chain.uniform(4)


def test_times_are_converted():
    run = hc.simulate(BALLS, times=Q([0.05, 0.1], "ms"))
    assert run.end_time == pytest.approx(1e-4, rel=1e-12)
    np.testing.assert_allclose(run.times, [5e-5, 1e-4], rtol=1e-12)
    for until in (Q(0.1, "ms"), "0.1 ms", "100us"):
        assert hc.simulate(BALLS, until=until, times=2).end_time == pytest.approx(1e-4, rel=1e-12)
    np.testing.assert_allclose(hc.simulate(BALLS, times=["50 us", 1e-4]).times, [5e-5, 1e-4])


def test_a_streamed_run_converts_its_times(tmp_path):
    stored = hc.stream(BALLS, tmp_path / "run", times=Q([0.05, 0.1], "ms"))
    np.testing.assert_allclose(stored.load().time, [5e-5, 1e-4], rtol=1e-12)


def test_a_chain_described_by_text():
    chain = hc.Chain.from_materials(
        "5 mm", "brass", beads=3, velocities=["12 cm/s", 0.0, 0.0], gaps=["2 um", 1e-6],
        gravity="9.81 m/s^2", right_wall=hc.Wall(stiffness="7 N/um^1.5", gap="0.1 mm"),
        loss=hc.Viscoelastic("3 us"), drive=hc.StepDrive("5 N", rise="1 ms"),
    )  # fmt: skip
    plain = hc.Chain.from_materials(
        5e-3, "brass", beads=3, velocity=0.12, gaps=[2e-6, 1e-6], gravity=9.81,
        right_wall=hc.Wall(stiffness=7e9, gap=1e-4), loss=hc.Viscoelastic(3e-6),
        drive=hc.StepDrive(5.0, rise=1e-3),
    )  # fmt: skip
    assert fingerprint(chain) == fingerprint(plain)
    assert chain.right_wall == plain.right_wall
    at_rest = BALLS.replace(velocities=None)
    struck = at_rest.struck_by(velocity="1 m/s", mass="4 g", gap="1 um", stiffness="7 N/um^1.5")
    same = at_rest.struck_by(velocity=1.0, mass=4e-3, gap=1e-6, stiffness=7e9)
    assert fingerprint(struck) == fingerprint(same)
    assert hc.Chain.from_radii(["5 mm", "0.25 cm"]).radii[1] == 0.5
    assert hc.Scales("5 mm", "4 g", "1 m/s", "12 um") == hc.Scales(5e-3, 4e-3, 1.0, 12e-6)


# Every part of a chain that can have a unit, in pint and as text.
PARTS = {
    "right_wall": (lambda: hc.Wall(gap=Q(5, "mm")), lambda: hc.Wall(gap="5 mm")),
    "left_wall": (lambda: hc.Wall.rigid(gap=Q(5, "mm")), lambda: hc.Wall.of("brass", gap="5 mm")),
    "loss": (
        lambda: hc.Viscoelastic(Q(3, "us")), lambda: hc.Viscoelastic("3 us"),
        lambda: hc.Dashpot(Q(3, "kg/s")), lambda: hc.Dashpot("3 kg/s"),
        lambda: hc.VelocityPower(Q(3, "N*s**0.5/m**0.5"), 0.5),
        lambda: hc.VelocityPower("3 N*s^0.5/m^0.5", 0.5),
    ),
    "drive": (
        lambda: hc.StepDrive(Q(5, "N")), lambda: hc.StepDrive(5.0, rise="1 ms"),
        lambda: hc.SineBurst(Q(5, "N"), 1.0), lambda: hc.SineBurst(5.0, "1 kHz"),
        lambda: hc.TableDrive(Q([0, 1], "ms"), [0, 1]),
        lambda: hc.TableDrive([0, 1], ["0 N", "1 N"]),
    ),
}  # fmt: skip


@pytest.mark.parametrize(
    ("name", "build"), [(name, build) for name, builds in PARTS.items() for build in builds]
)
def test_a_scaled_chain_rejects_parts_with_units(name, build):
    part = build()
    with pytest.raises(hc.InputError, match=f"{name} has a unit in its .* scaled variables"):
        SCALED.replace(**{name: part})
    assert getattr(BALLS.replace(**{name: part}), name) is part


@pytest.mark.parametrize(
    "call",
    [
        lambda x: hc.simulate(SCALED, until=x),
        lambda x: hc.simulate(SCALED, times=[x]),
        lambda x: SCALED.struck_by(velocity=x),
        lambda x: SCALED.struck_by(radius=x),
        lambda x: SCALED.struck_by(mass=x, radius=1.0),
        lambda x: SCALED.struck_by(stiffness=x),
        lambda x: SCALED.struck_by(gap=x),
        lambda x: SCALED.decorated(radius=x),
        lambda x: SCALED.with_defects({2: x}),
        lambda x: SCALED.replace(masses=[x] * 4),
        lambda x: SCALED.replace(stiffness=[x] * 3),
        lambda x: SCALED.replace(velocities=[x] * 4),
        lambda x: SCALED.replace(gaps=[x] * 3),
        lambda x: SCALED.replace(gravity=x),
        lambda x: SCALED.replace(precompression=x),
        lambda x: SCALED.replace(radii=[x] * 4),
    ],
)
@pytest.mark.parametrize("value", [Q(1, "m"), Q(1, "s"), Q(1, "kg"), "1 m", "1 s"])
def test_a_scaled_chain_rejects_units_everywhere(call, value):
    with pytest.raises(hc.InputError, match="has a unit .* scaled variables"):
        call(value)


@pytest.mark.parametrize(
    "call",
    [
        lambda x: hc.Restitution(x),
        lambda x: hc.UnloadingRatio(x),
        lambda x: hc.WaltonBraun(x),
        lambda x: hc.VelocityPower(1.0, x),
        lambda x: hc.SineBurst(1.0, 1.0, x),
        lambda x: hc.simulate(SCALED, rtol=x),
        lambda x: hc.propagate(SCALED, rtol=x),
        lambda x: hc.Chain.tapered("forward-linear", x, beads=4),
        lambda x: hc.Chain.uniform(4, exponent=x),
        lambda x: hc.Chain.uniform(x),
        lambda x: hc.Chain.dimer(x, beads=4),
        lambda x: SCALED.decorated(x),
        lambda x: SCALED.with_scatter(1, relative=x),
        lambda x: hc.bca(SCALED, restitution=x),
        lambda x: hc.solitary_wave(x),
        lambda x: hc.Pulse(SCALED, "x", velocity=[x] * 4),
        lambda x: hc.hertz_range(BALLS, [x] * 3),
        lambda x: hertz_stiffness(x, 1.0),
        lambda x: collision_overlap(1.0, 1.0, x),
        lambda x: dispersion.dispersion_uniform(x),
        lambda x: dispersion.linear_stiffness(x, 1.0),
        lambda x: dispersion.linear_stiffness(1.0, x),
        lambda x: long_wave.sen_manciu_velocity(x),
        lambda x: long_wave.precompressed_speed(x),
        lambda x: printed_velocity("backward-linear", 0.1, x),
    ],
)
def test_arguments_without_dimension_reject_units(call):
    for value in (Q(1, "m"), Q([1.0, 1.0], "s")):
        with pytest.raises(hc.InputError) as caught:
            call(value)
        assert "\n" not in str(caught.value)


def test_pure_numbers_of_pint_are_numbers():
    assert hc.Restitution(Q(90, "percent")).coefficient == pytest.approx(0.9)
    assert SCALED.replace(gravity=Q(1, "mm/m")).gravity == pytest.approx(1e-3)


def test_the_stiffness_of_a_wall_has_a_unit_of_spheres_only():
    wall = hc.Wall(stiffness=Q(7, "N/um**1.5"))
    assert wall.stiffness == pytest.approx(7e9)
    assert BALLS.replace(right_wall=wall).wall_stiffness[1] == pytest.approx(7e9)
    square = hc.Chain([5e-3] * 3, 2.0, units="SI", masses=1e-3, stiffness=1e12)
    with pytest.raises(hc.InputError, match=r"right_wall was given in N/m\^1.5, .* p = 2"):
        square.replace(right_wall=wall)


def test_parts_of_a_converted_chain_are_scaled():
    scales = hc.Scales.of(BALLS)
    chain = BALLS.replace(right_wall=hc.Wall(gap="1 um"), loss=hc.Viscoelastic("1 us"))
    scaled = scales.to_scaled(chain)
    assert scaled.right_wall.gap == pytest.approx(1e-6 / scales.length)
    assert scales.to_si(scaled).loss.time == pytest.approx(1e-6)


@pytest.mark.filterwarnings("ignore::hertzchain.errors.IncompleteWarning")
@pytest.mark.parametrize(
    "call",
    [
        lambda x: hc.Chain.from_radii(x),
        lambda x: hc.Chain.from_materials(1e-3 * x, "brass"),
        lambda x: hc.Chain.uniform(3).replace(masses=x),
        lambda x: hc.Chain.uniform(3).replace(velocities=x),
        lambda x: hc.Chain.from_radii(list(x)),
        lambda x: hc.Chain.from_radii(Q(x, "mm")),
        lambda x: hc.TableDrive(x, [0.0, 1.0, 0.0]),
        lambda x: hc.StepDrive(1.0).value(x),
        lambda x: hc.simulate(SCALED, times=x),
        lambda x: hc.propagate_many([x, x])[0],
        lambda x: hc.propagate_many(np.ma.stack([x, x]))[0],
        lambda x: hc.Pulse(hc.Chain.uniform(3), "x", velocity=x),
        lambda x: hertz_stiffness(x, 1.0),
    ],
)
def test_masked_numbers_are_no_numbers(call):
    masked = np.ma.array([1.0, 2.0, 3.0], mask=[False, False, True])
    with pytest.raises((hc.InputError, hc.SimulationError), match="masked entries|plain numbers"):
        call(masked)
    # Where nothing is masked, nothing is lost.
    assert call(np.ma.array([1.0, 2.0, 3.0])) is not None


def test_arrays_of_xarray_keep_their_unit():
    import xarray as xr

    radii = xr.DataArray(Q([5.0, 4.0], "mm"))
    np.testing.assert_allclose(hc.Chain.from_materials(radii, "brass").radii, [5e-3, 4e-3])
    with pytest.raises(hc.InputError, match="scaled variables"):
        hc.Chain(radii)


class Hostile:
    def __repr__(self):
        raise RuntimeError


def test_errors_can_show_anything():
    with pytest.raises(hc.InputError, match="must be a Wall or None, got 5 millimeter"):
        SCALED.replace(right_wall=Q(5, "mm"))
    with pytest.raises(hc.InputError, match="got an object of type Hostile"):
        SCALED.replace(right_wall=Hostile())
