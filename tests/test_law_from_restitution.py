"""Loss laws with a given coefficient of restitution at one speed."""

import pytest
from scipy.integrate import solve_ivp

import hertzchain as hc

PAIR = hc.Chain.from_materials("5 mm", "steel-52100", beads=2)
SPEED = 0.8


def rebound(force):
    """Restitution of two balls of PAIR by SciPy, for a force of overlap and its rate."""
    mass = PAIR.masses[0] / 2.0

    def ends(_, y):
        return force(y[0], y[1]) if y[1] < 0.0 else 1.0

    ends.terminal = True
    done = solve_ivp(lambda _, y: (y[1], -force(max(y[0], 0.0), y[1]) / mass), (0.0, 1e-3),
                     (0.0, SPEED), events=ends, rtol=1e-10, atol=1e-16, max_step=1e-7)  # fmt: skip
    return -done.y[1, -1] / SPEED


@pytest.mark.parametrize("e", [0.99, 0.93, 0.7])
def test_a_viscoelastic_law_has_the_given_restitution(e):
    law = hc.Viscoelastic.from_restitution(e, speed="0.8 m/s", chain=PAIR)
    k = PAIR.stiffness[0]
    found = rebound(lambda d, v: k * (d**1.5 + 1.5 * law.time * max(d, 0.0) ** 0.5 * v))
    assert found == pytest.approx(e, abs=2e-6)


def test_laws_with_closed_forms():
    assert hc.UnloadingRatio.from_restitution(0.9, speed=1.0, chain=PAIR).ratio == pytest.approx(
        0.19
    )
    assert hc.WaltonBraun.from_restitution(0.9, speed=1.0, chain=PAIR).ratio == pytest.approx(0.81)
    given = hc.Restitution.from_restitution("90%", speed=1.0, chain=PAIR)
    assert given.coefficient == pytest.approx(0.9)


def test_scaled_chains_and_given_parameters():
    chain = hc.Chain.uniform(3)
    for law, others in ((hc.Dashpot, {}), (hc.VelocityPower, {"alpha": 1.5})):
        made = law.from_restitution(0.9, speed=1.0, chain=chain, contact=2, given=others)
        assert made.restitution(1.0, chain=chain, contact=2) == pytest.approx(0.9, abs=1e-9)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: hc.Viscoelastic.from_restitution(1.2, speed=1.0, chain=PAIR), "below 1, got 1.2"),
        (lambda: hc.Viscoelastic.from_restitution(0.9, speed=0.0, chain=PAIR), "above 0, got 0"),
        (lambda: hc.Viscoelastic.from_restitution(0.9, speed="1 m", chain=PAIR), "speed must have"),
        (lambda: hc.ElasticPlastic.from_restitution(0.9, speed=1.0, chain=PAIR), "yield strengths"),
        (lambda: hc.VelocityPower.from_restitution(0.9, speed=1.0, chain=PAIR),
         "not 2 .gamma, alpha.: give all but one"),
        (lambda: hc.Dashpot.from_restitution(0.9, speed=1.0, chain=PAIR, given={"alpha": 2.0}),
         "dashpot has no parameter 'alpha'"),
        (lambda: hc.Elastic.from_restitution(0.9, speed=1.0, chain=PAIR), "has no parameter"),
        (lambda: hc.Dashpot.from_restitution(0.9, speed=1.0, chain=PAIR, contact=5), "contact"),
        (lambda: hc.Dashpot.from_restitution(0.9, speed=1.0, chain=PAIR, contact=2), "is free"),
    ],
)  # fmt: skip
def test_errors(call, said):
    with pytest.raises(hc.InputError, match=said):
        call()


def test_on_the_command_line(run):
    options = ("--material", "steel-52100", "--diameter", "10 mm", "--beads", 8, "--wall", "same",
               "--speed", "0.1 m/s")  # fmt: skip
    law = hc.Viscoelastic.from_restitution(0.93, speed=0.8, chain=PAIR)
    chain = hc.Chain.from_materials("5 mm", "steel-52100", beads=8, velocity=0.1, loss=law,
                                    right_wall=hc.Wall())  # fmt: skip
    text = "viscoelastic, restitution=0.93, speed=0.8 m/s"
    shown = run("simulate", *options, "--loss", text).stdout
    done = run("simulate", *options, "--striker", "30 g", "--loss", text)
    assert (
        "from the restitution in contact 2; all contacts between beads have this law" in done.stderr
    )
    last = run("simulate", *options, "--loss", f"{text}, contact=8").stderr
    assert "contact 8" in last
    peak = f"peak {hc.simulate(chain).wall_force().peak:.4f}"[:11]
    assert peak in shown
    for wrong, said in (
        ("viscoelastic, restitution=0.93", "with a restitution needs its speed, too"),
        ("viscoelastic, restitution=0.93, speed=0.8", "speed of --loss 0.8 has no unit"),
        ("viscoelastic, restitution=1.93, speed=0.8 m/s", "below 1, got 1.93"),
    ):
        code, out, err = run("simulate", *options, "--loss", wrong)
        assert (code, out) == (2, "")
        assert said in " ".join(err.split())
