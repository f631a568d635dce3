"""Walls, drives, losses and precompression, and methods that do not support them."""

import math

import numpy as np
import pytest

import hertzchain as hc
from hertzchain import (
    Chain,
    Dashpot,
    ElasticPlastic,
    InputError,
    Restitution,
    SineBurst,
    StepDrive,
    TableDrive,
    UnloadingRatio,
    VelocityPower,
    Viscoelastic,
    Wall,
    WaltonBraun,
    simulate,
)
from hertzchain.errors import unknown_name_error
from hertzchain.theory.dispersion import modes

CHAIN = Chain.uniform(4)


@pytest.mark.parametrize("attractive", [True, False])
@pytest.mark.parametrize("exponent", [1.5, 2.0, 3.0])
@pytest.mark.parametrize("e", [0.05, 0.3, 0.6, 0.9, 0.99])
def test_restitution_is_what_it_says_at_any_speed(e, exponent, attractive):
    """An independent integration of one collision: SciPy, from touch to the end of contact."""
    from scipy.integrate import solve_ivp

    c = Restitution(e, attractive=attractive).damping(exponent)

    def force(d, v):
        return d**exponent + c * d ** ((exponent - 1) / 2) * v

    def motion(_, y):
        return y[1], -force(max(y[0], 0.0), y[1])

    def ended(_, y):
        # Not at the start, where there is neither overlap nor force.
        return (y[0] if attractive else force(max(y[0], 0.0), y[1])) if y[1] < 0 else 1.0

    ended.terminal = True
    run = solve_ivp(
        motion, (0.0, 1e4), (0.0, 2.0), method="LSODA", events=ended, rtol=1e-11, atol=1e-14
    )
    # Measured: 7e-10 at worst.
    assert -run.y[1, -1] / 2.0 == pytest.approx(e, rel=5e-9)


def test_elastic_restitution_has_no_damping():
    assert Restitution(1.0).damping() == 0.0
    assert Restitution(1.0, attractive=False).damping() == pytest.approx(0.0, abs=1e-15)


def test_a_burst_under_its_window():
    burst = SineBurst(3.0, frequency=2.0, cycles=5)
    times = np.linspace(-1.0, 4.0, 2001)
    values = burst.value(times)
    inside = (times > 0) & (times < 2.5)
    assert not values[~inside].any()
    expected = 3 * np.sin(np.pi * times / 2.5) ** 2 * np.sin(4 * np.pi * times)
    np.testing.assert_allclose(values[inside], expected[inside], atol=1e-14)
    np.testing.assert_array_equal(burst.kinks, [0.0, 2.5])


def test_a_step_rises_smoothly_and_stays():
    step = StepDrive(2.0, rise=0.5)
    np.testing.assert_allclose(step.value([0.0, 0.125, 0.25, 0.5, 9]), [0, 0.3125, 1, 2, 2])


def test_a_table_is_joined_by_lines_and_kept():
    table = TableDrive([1.0, 2.0, 4.0], [0.0, 6.0, 2.0], of="force")
    np.testing.assert_allclose(table.value([0.0, 1.5, 3.0, 5.0]), [0, 3, 4, 2])


def test_features_are_named_in_order():
    chain = CHAIN.replace(
        gaps=[0.1, 0, 0], gravity=1.0, right_wall=Wall(), loss=Dashpot(1.0), masses=[1, 2, 1, 1],
        drive=StepDrive(1.0),
    )  # fmt: skip
    assert chain.features == (
        "masses", "gaps", "gravity", "right wall", "drive", "loss",
    )  # fmt: skip
    assert CHAIN.features == ()


def test_a_driven_chain_starts_at_rest_by_default():
    assert not CHAIN.replace(drive=StepDrive(1.0)).velocities.any()
    assert Chain.from_materials(5e-3, "brass", beads=3, drive=StepDrive(1.0)).velocities.any() == 0
    np.testing.assert_array_equal(
        CHAIN.replace(drive=StepDrive(1.0), velocities=[2, 0, 0, 0]).velocities, [2, 0, 0, 0]
    )


def test_replace_lets_follow_what_follows():
    chain = Chain.tapered("forward-linear", 0.1, beads=3).replace(radii=[1.0, 2.0, 3.0])
    np.testing.assert_array_equal(chain.masses, [1, 8, 27])
    assert chain.taper is None
    kept = CHAIN.replace(masses=[1, 2, 3, 4]).replace(radii=[1.0, 2, 2, 2])
    np.testing.assert_array_equal(kept.masses, [1, 2, 3, 4])


def test_one_number_stands_for_all_contacts():
    np.testing.assert_array_equal(CHAIN.replace(gaps=0.25).gaps, [0.25] * 3)


def test_fields_cannot_be_written_through():
    for name in ("radii", "masses", "stiffness", "velocities", "gaps"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(CHAIN, name)[0] = 2.0


def test_given_arrays_are_copied():
    given = np.ones(4)
    chain = CHAIN.replace(velocities=given)
    given[0] = 5.0
    assert chain.velocities[0] == 1.0


BENCH = CHAIN.replace(gravity=1.0, right_wall=Wall())


@pytest.mark.parametrize(
    ("method", "name"),
    [
        (hc.bca, "the BCA"),
        (hc.propagate, "propagate"),
        (hc.hard_sphere, "the hard-sphere theory"),
        (lambda chain: hc.modified_bca(chain.replace(taper=None)), "modified_bca|tapered chain"),
        (lambda chain: hc.effective_chain(chain), "effective_chain"),
    ],
)
def test_theories_say_what_they_do_not_cover(method, name):
    with pytest.raises(InputError, match=f"({name})") as caught:
        method(BENCH)
    if "tapered chain" not in str(caught.value):
        assert "gravity or a right wall" in str(caught.value)


def test_modified_bca_rejects_a_taper_with_other_features():
    chain = Chain.tapered("forward-linear", 0.005, beads=20).replace(loss=Restitution(0.9))
    with pytest.raises(InputError, match="modified_bca does not support a loss"):
        hc.modified_bca(chain)


def test_si_units_point_to_the_scales():
    with pytest.raises(InputError, match=r"SI units.*Scales.of\(chain\).to_scaled\(chain\)"):
        modes(Chain.from_materials(5e-3, "brass", beads=3, velocity=3.0), 1.0)


@pytest.mark.filterwarnings("ignore::hertzchain.errors.IncompleteWarning")
def test_many_chains_name_the_one_that_is_not_covered():
    table = hc.propagate_many([CHAIN, BENCH])
    assert "propagate_many does not support gravity" in table.reasons[1]


def test_theories_take_masses_and_contacts_of_any_kind():
    # A contact of 2^(p+1) times the stiffness has half the overlap at the same speed.
    stiff = CHAIN.replace(stiffness=2.0**2.5)
    ratio = hc.bca(stiff).peak_overlap / hc.bca(CHAIN).peak_overlap
    np.testing.assert_allclose(ratio, 0.5, rtol=1e-14)


@pytest.mark.parametrize(
    ("build", "said"),
    [
        (lambda: CHAIN.replace(gaps=[0.0, -0.1, 0.0]), "gap of contact 2 is -0.1: .* at least 0"),
        (lambda: CHAIN.replace(gaps=[0.0, 0.1]), "of two beads, without strikers and walls, got 2"),
        (lambda: CHAIN.struck_by().replace(gaps=[0.0]), "4 numbers .* strikers included, but"),
        (lambda: CHAIN.replace(masses=[1, 2, 3]), "4 numbers for the masses, .* each bead, got 3"),
        (lambda: CHAIN.replace(masses=[1, 2, 3, 0]), "mass of bead 4 is 0: .* above 0"),
        (lambda: CHAIN.replace(stiffness=[1, "k", 1]), "stiffness of contact 2 is 'k'"),
        (lambda: CHAIN.replace(velocities=[1, 0, math.nan, 0]), "velocity of bead 3 is nan"),
        (lambda: CHAIN.replace(gravity=math.inf), "gravity must be finite, got inf"),
        (lambda: CHAIN.replace(units="cgs"), "unknown units 'cgs'"),
        (lambda: CHAIN.replace(wall=Wall()), "unknown field of a chain 'wall' .did you mean"),
        (lambda: CHAIN.replace(right_wall="rigid"), "right_wall must be a Wall or None"),
        (lambda: CHAIN.replace(loss=0.9), "loss must be a law, such as Restitution"),
        (
            lambda: CHAIN.replace(drive="sine"),
            "drive must be a SineBurst, a StepDrive, a TableDrive",
        ),
        (lambda: CHAIN.replace(strikers=4), "from 0 to 3, got 4"),
        (
            lambda: CHAIN.replace(precompression=-1.0),
            "at least 0, got -1; contacts carry no tension",
        ),
        (lambda: CHAIN.replace(precompression=1.0), "left end .* is free, .* give left_wall"),
        (
            lambda: CHAIN.replace(precompression=1.0, left_wall=Wall()),
            "right end .* is free, .* give right_wall",
        ),
        (
            lambda: CHAIN.replace(
                precompression=1.0, held_by="force", left_wall=Wall(), right_wall=Wall()
            ),
            "both ends have walls",
        ),
        (lambda: CHAIN.replace(precompression=1.0, held_by="glue"), "way to hold a chain 'glue'"),
        (
            lambda: CHAIN.replace(precompression=1.0, held_by="force", gaps=[0, 0.1, 0]),
            "contact 2 has a gap of 0.1, but precompressed beads touch",
        ),
        (
            lambda: CHAIN.replace(precompression=1.0, held_by="force", right_wall=Wall(gap=0.1)),
            "wall with a gap cannot hold",
        ),
        (
            lambda: CHAIN.struck_by(mass=2.0).replace(
                precompression=1.0, left_wall=Wall(), right_wall=Wall()
            ),
            "with strikers cannot be held by a left wall",
        ),
        (
            lambda: CHAIN.struck_by(mass=2.0).replace(
                precompression=1.0, left_wall=Wall(), held_by="force"
            ),
            "left wall is behind the strikers",
        ),
        (
            lambda: CHAIN.replace(drive=StepDrive(1.0, 1.0, "displacement")),
            "left end is free; give",
        ),
        (lambda: StepDrive(1.0, of="displacement"), "needs a rise time above 0"),
        (lambda: StepDrive(1.0, of="velocity"), "unknown driven quantity 'velocity'"),
        (lambda: SineBurst(1.0, 0.0), "frequency must be above 0"),
        (lambda: SineBurst(1.0, 1.0, cycles=0.7), "multiple of 1/2"),
        (
            lambda: SineBurst(1.0, 1.0, cycles=math.inf),
            "infinitely many cycles has no window: use window='none'",
        ),
        (lambda: SineBurst(1.0, 1.0, window="tukey"), "unknown window 'tukey'"),
        (lambda: TableDrive([0.0, 1.0, 1.0], [0, 1, 2]), "that of row 3 is 1 after 1"),
        (lambda: TableDrive([0.0], [0.0]), "at least two times, got 1"),
        (lambda: TableDrive([0.0, 1.0], [0.0]), "2 numbers for the values of the drive"),
        (lambda: Wall(gap=-0.1), "gap to a wall must be at least 0"),
        (lambda: Wall(stiffness=0.0), "stiffness of a wall must be above 0"),
        (
            lambda: CHAIN.replace(left_wall=Wall(stiffness=1.0, material="brass")),
            "wall of brass requires a chain with materials",
        ),
        (lambda: Wall.of("bras"), "did you mean 'brass'"),
        (
            lambda: CHAIN.replace(left_wall=Wall.of("brass")),
            "wall of brass requires a chain with materials",
        ),
        (
            lambda: Chain.uniform(3, exponent=2.0).replace(left_wall=Wall()),
            r"give Wall\(stiffness=...\)",
        ),
        (lambda: Restitution(0.0), "coefficient of restitution must be above 0 .* got 0"),
        (lambda: Restitution(1.1), "at most 1, got 1.1"),
        (lambda: hc.Viscoelastic(-1.0), "relaxation time must be at least 0"),
        (lambda: hc.UnloadingRatio(1.0), "unloading ratio w .* at least 0 and below 1, got 1"),
        (lambda: hc.VelocityPower(1.0, 0.0), "alpha must be above 0"),
        (lambda: Dashpot(-2.0), "gamma must be at least 0, got -2"),
        (lambda: hc.WaltonBraun(0.0), "ratio K1/K2 .* above 0 and at most 1, got 0"),
    ],
)
def test_contradictions_are_rejected_in_one_sentence(build, said):
    with pytest.raises(InputError, match=said) as caught:
        build()
    assert "\n" not in str(caught.value)


def test_a_refusal_names_the_chain_in_either_units():
    balls = Chain.from_materials(5e-3, "brass", beads=9).replace(gravity=9.81)
    with pytest.raises(InputError, match=r"\(chain: 9 brass beads, diameter 10 mm, gravity\)"):
        hc.bca(balls)
    with pytest.raises(InputError, match=r"\(chain: 9 brass beads, diameter 10 mm, gravity\)"):
        hc.modified_bca(balls)


@pytest.mark.parametrize(
    ("name", "known", "meant"),
    [
        ("iron", ["brass", "bronze"], None),
        ("teflon", ["ptfe", "nylon"], None),
        (float("nan"), ["nylon"], None),
        (True, ["rubber"], None),
        ("mas", ["masses", "gaps"], "masses"),
        ("foward-linear", ["forward-linear", "backward-linear"], "forward-linear"),
        ("wall", ["gaps", "right_wall"], "right_wall"),
    ],
)
def test_only_near_names_are_suggested(name, known, meant):
    said = str(unknown_name_error("name", name, known))
    assert ("did you mean" in said) == (meant is not None)
    assert meant is None or f" (did you mean {meant!r}?): choose from " in said


BALLS = Chain.from_materials(5e-3, "steel-52100", beads=5, velocity=0.1)


def test_a_relaxation_time_longer_than_the_contacts_is_reported():
    """An elastic contact of overlap d lasts 2.943275 d/v."""
    reduced, stiffness = 0.5 * BALLS.masses[0], BALLS.stiffness[0]
    overlap = (2.5 * reduced * 0.1**2 / (2.0 * stiffness)) ** 0.4
    duration = 2.943275 * overlap / 0.1
    with pytest.warns(hc.ModelRangeWarning, match="relaxation time 1 s of Viscoelastic") as found:
        hc.simulate(BALLS.replace(loss=hc.Viscoelastic(1.0)), until=1e-6)
    assert len(found) == 1
    assert f"at most {1e6 * duration:.4g} us without loss (contact 1, at 0.1 m/s)" in str(
        found[0].message
    )
    with pytest.warns(hc.ModelRangeWarning, match="relaxation time"):
        hc.simulate(BALLS.replace(loss=hc.Viscoelastic(1.001 * duration)), until=1e-6)


@pytest.mark.parametrize(
    "chain",
    [
        # A warning would be an error.
        BALLS.replace(loss=hc.Viscoelastic(1e-5)),
        BALLS.replace(velocities=np.zeros(5), loss=hc.Viscoelastic(1.0)),
    ],
    ids=["short", "at rest"],
)
def test_other_relaxation_times_are_not_reported(chain):
    hc.simulate(chain, until=1e-6)


@pytest.mark.parametrize("wall", [None, Wall()], ids=["free", "wall"])
@pytest.mark.parametrize(
    "loss",
    [
        None, Viscoelastic(0.05), Restitution(0.8), UnloadingRatio(0.2), VelocityPower(0.1, 1.5),
        Dashpot(0.1), WaltonBraun(0.7), ElasticPlastic(yield_overlap=0.05),
    ],
    ids=lambda loss: type(loss).__name__,
)  # fmt: skip
def test_the_budget_of_every_law_adds_up(loss, wall):
    chain = Chain.uniform(8).replace(loss=loss, right_wall=wall)
    run = simulate(chain, until=30.0, times=61)
    # NaN fails these comparisons.
    total = sum(run.budget().energy.values())
    assert np.abs(total - 0.5).max() < 1e-6
    assert run.energy_drift < 1e-6
    lost = run.budget().energy["lost"]
    assert (np.diff(lost) >= -1e-9).all()
    assert lost[-1] > 1e-3 or loss is None
