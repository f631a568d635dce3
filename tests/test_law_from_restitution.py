"""Loss laws with a given coefficient of restitution at one speed."""

import warnings

import pytest
from scipy.integrate import solve_ivp

import hertzchain as hc

PAIR = hc.Chain.from_materials("5 mm", "steel-52100", beads=2)
# A ball of PTFE that falls onto a plate.
DROP = hc.Chain.from_materials("5 mm", "ptfe", beads=1, right_wall=hc.Wall.of("steel-52100"))
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


@pytest.mark.parametrize("e", [0.5, 0.7, 0.9, 0.99])
@pytest.mark.parametrize("materials", ["steel-316", ["ptfe", "steel-316"]])
def test_the_yield_pressure_from_a_rebound_is_that_of_a_simulated_collision(e, materials):
    speed = 5.0 if e < 0.6 else 0.05
    pair = hc.Chain.from_materials("5 mm", materials, beads=2)
    with warnings.catch_warnings():
        # The pressures of these pairs need not be those of real materials.
        warnings.simplefilter("ignore", hc.InputWarning)
        law = hc.ElasticPlastic.from_restitution(e, speed=speed, chain=pair)
    assert law.yield_pressure is law.yield_overlap is None
    run = hc.simulate(pair.replace(loss=law, velocities=[speed, 0.0]), until="3 ms", check=False)
    left, right = run.velocities[-1]
    assert (right - left) / speed == pytest.approx(e, rel=1e-7)


def test_the_yield_pressure_without_a_known_strength_and_in_scaled_chains():
    ceramic = hc.Chain.from_materials("5 mm", "silicon-nitride", beads=2)
    scaled = hc.Chain.uniform(3)
    for chain, name in ((ceramic, "yield_pressure"), (scaled, "yield_overlap")):
        law = hc.ElasticPlastic.from_restitution(0.9, speed=3.0, chain=chain)
        assert [each for each in law.parameters() if getattr(law, each) is not None] == [name]
        assert law.restitution(3.0, chain=chain) == pytest.approx(0.9, abs=1e-12)


def test_a_loss_that_is_hardly_due_to_yield_is_reported():
    with pytest.warns(hc.InputWarning, match="0.002.* times the yield strength, far from"):
        hc.ElasticPlastic.from_restitution(0.5, speed=1e-6, chain=PAIR)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        hc.ElasticPlastic.from_restitution(0.6, speed=0.5, chain=DROP)


def test_the_yield_pressure_in_a_chain_file():
    rebound = 'law = "elastic-plastic", restitution = 0.6, speed = "0.5 m/s"'
    text = f'{{material = "steel-316"}}\nloss = [{{between = ["ptfe", "steel-316"], {rebound}}}]'
    chain = read(MIXED + text)
    law = hc.ElasticPlastic.from_restitution(0.6, speed=0.5, chain=chain)
    assert chain.contact_losses[1] == law
    assert hc.chain_from_toml(hc.chain_as_toml(chain)).contact_losses[1] == law


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
        (lambda: hc.ElasticPlastic.from_restitution(1.0, speed=1.0, chain=PAIR),
         "has not yielded.* give a coefficient below 1"),
        (lambda: hc.ElasticPlastic.from_restitution(1.2, speed=1.0, chain=PAIR), "at most 1"),
        (lambda: hc.ElasticPlastic.from_restitution(0.9, speed=1.0, chain=PAIR,
                                                    given={"yield_pressure": 1e9}),
         "^restitution and yield_pressure are both given.*: omit one"),
        (lambda: hc.ElasticPlastic.from_restitution(0.9, speed=1.0, chain=PAIR, given={"f": 2.0}),
         "no parameter 'f'"),
        (lambda: hc.ElasticPlastic.from_restitution(
            0.9, speed=1.0, chain=PAIR.replace(right_wall=hc.Wall("5 kN/mm", exponent=1)),
            contact=2),
         "a law of spheres"),
        (lambda: hc.VelocityPower.from_restitution(0.9, speed=1.0, chain=PAIR),
         "not 2 .gamma, alpha.: give all but one"),
        (lambda: hc.Restitution.from_restitution(0.9, speed=1.0, chain=PAIR,
                                                 given={"coefficient": 0.8}),
         "^restitution and coefficient are both given, but the restitution determines coef.*omit"),
        (lambda: hc.VelocityPower.from_restitution(0.9, speed=1.0, chain=PAIR,
                                                   given={"gamma": 0.1, "alpha": 1.0}),
         "^restitution, gamma and alpha are all given, but .* one of gamma and alpha: omit one"),
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
    assert "in contact 8 (right wall); all contacts, including this one, have this law" in last
    at_wall = ("--loss", f"{text}, contact=wall")
    assert run("simulate", *options, *at_wall).stderr == last
    own = run("simulate", *options, *at_wall, "--wall-loss", "elastic").stderr
    assert "in contact 8 (right wall); all contacts between beads have this law" in own
    yielding = "elastic-plastic, restitution=0.93, speed=0.8 m/s"
    factor = hc.ElasticPlastic.from_restitution(0.93, speed=0.8, chain=PAIR).factor
    found = run("simulate", *options, "--loss", yielding).stderr
    assert f"factor {factor:.4g} from the restitution in contact 1" in found
    peak = f"peak {hc.simulate(chain).wall_force().peak:.4f}"[:11]
    assert peak in shown
    for wrong, said in (
        ("viscoelastic, restitution=0.93", "with a restitution needs its speed, too"),
        (
            "viscoelastic, restitution=0.93, speed=0.8",
            "speed=0.8 has no unit; write, for example, speed=0.8 m/s",
        ),
        ("viscoelastic, restitution=1.93, speed=0.8 m/s", "below 1, got 1.93"),
    ):
        code, out, err = run("simulate", *options, "--loss", wrong)
        assert (code, out) == (2, "")
        assert said in " ".join(err.split())


BALLS = 'diameters = "10 mm"\nbeads = 5\nmaterials = "steel-52100"\n'
LAW = 'law = "viscoelastic", restitution = 0.93, speed = "0.8 m/s"'
# Steel, PTFE, steel, PTFE in front of steel.
MIXED = 'diameters = "10 mm"\nmaterials = ["steel-316", "ptfe", "steel-316", "ptfe"]\nright_wall = '


def read(text):
    return hc.chain_from_toml(f"[chain]\n{text}\n")


def time_of(chain, contact, speed="0.8 m/s", e=0.93):
    return hc.Viscoelastic.from_restitution(e, speed=speed, chain=chain, contact=contact).time


@pytest.mark.parametrize(
    ("text", "contact"),
    [
        ("", 1),
        ("[chain.right_wall]", 1),
        ('[chain.struck_by]\nmass = "30 g"', 2),
        ('[chain.struck_by]\nmass = "30 g"\ncount = 2', 3),
        ("with_contacts = {shape = \"crossed-cylinders\", radius = \"2 mm\"}", 1),
    ],
)  # fmt: skip
def test_in_a_chain_file_it_is_that_of_the_first_contact_of_two_balls(text, contact):
    chain = read(f"{BALLS}loss = {{{LAW}}}\n{text}")
    assert chain.loss.time == time_of(chain, contact)
    assert chain.loss.restitution(0.8, chain=chain, contact=contact) == pytest.approx(0.93)
    # The file that is written has the parameter.
    written = hc.chain_as_toml(chain)
    assert f"time = {chain.loss.time!r}" in written
    assert "restitution" not in written
    assert hc.chain_from_toml(written).loss == chain.loss


def test_a_given_contact_and_known_parameters():
    chain = read(f"{BALLS}right_wall = {{}}\nloss = {{{LAW}, contact = 5}}")
    assert chain.loss.time == time_of(chain, 5)
    law = read(f'{BALLS}loss = {{law = "velocity-power", alpha = 1.5, restitution = "93%", '
               'speed = 0.8}').loss  # fmt: skip
    assert law.restitution(0.8, chain=PAIR) == pytest.approx(0.93, abs=1e-9)
    scaled = read('taper = "uniform"\nbeads = 3\nloss = {law = "dashpot", restitution = 0.9, '
                  "speed = 1.0}")  # fmt: skip
    assert scaled.loss.restitution(1.0, chain=scaled) == pytest.approx(0.9, abs=1e-9)


def test_pairs_lists_and_walls():
    # Without a contact of their own in the chain, two balls of steel have the law of the wall.
    chain = read(
        MIXED + f'{{material = "steel-316"}}\nloss = [{{between = ["ptfe", "steel-316"], {LAW}}}]'
    )
    assert chain.contact_losses[-1].time == chain.contact_losses[1].time == time_of(chain, 1)
    # All other pairs are only that of PTFE on PTFE, at the wall.
    others = '{law = "viscoelastic", restitution = 0.5, speed = "0.8 m/s"}'
    chain = read(MIXED + f'{{}}\nloss = [{{between = ["ptfe", "steel-316"], {LAW}}}, {others}]')
    assert [chain.contact_losses[c].time for c in (1, 4)] == [
        time_of(chain, 1), time_of(chain, 4, e=0.5)
    ]  # fmt: skip
    chain = read(MIXED + f"{{loss = {{{LAW}}}}}")
    assert chain.right_wall.loss.time == time_of(chain, 4)
    radii = 'diameters = ["10 mm", "8 mm", "6 mm"]\nmaterials = "brass"\n'
    chain = read(f"{radii}loss = [{{{LAW}}}, {{{LAW}}}]")
    assert [law.time for law in chain.loss] == [time_of(chain, 1), time_of(chain, 2)]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (BALLS + 'loss = {law = "dashpot", restitution = 0.9}',
         r"\[chain.loss\] has restitution but no speed: .* add speed, such as speed = \"0.8 m/s"),
        (BALLS + 'loss = {law = "dashpot", gamma = 1, speed = 1}', "has speed but no restitution"),
        (BALLS + 'loss = {law = "viscoelastic"}', "requires time or restitution"),
        (BALLS + f"loss = {{{LAW}, time = 1e-6}}", r"\[chain.loss\]: restitution and time are"),
        (BALLS + 'loss = {law = "dashpot", restitution = 1.9, speed = 1}', "below 1, got 1.9"),
        (BALLS + 'loss = {law = "dashpot", restitution = 0.9, speed = "1 m"}', "speed.* must have"),
        (BALLS + 'loss = {law = "elastic-plastic", factor = 2, restitution = 0.9, speed = 1}',
         r"\[chain.loss\]: restitution and factor are both given"),
        (BALLS + f"loss = {{{LAW}, contact = 7}}", "contact must be .* got 7"),
        (BALLS + f"loss = {{{LAW}, contact = 5}}", "end of the chain is free"),
        (BALLS + f"right_wall = {{loss = {{{LAW}, between = ['brass', 'ptfe']}}}}", "omit between"),
        (BALLS + f'loss = [{{between = ["brass", "ptfe"], {LAW}}}, {{law = "elastic"}}]',
         "touch nowhere in this chain: give the contact"),
        (f'taper = "uniform"\nbeads = 3\nloss = [{{between = ["brass", "ptfe"], {LAW}}}]', "unit"),
    ],
)  # fmt: skip
def test_errors_in_chain_files(text, said):
    with pytest.raises(hc.InputError, match=said):
        read(text)


def test_a_restitution_can_be_swept(tmp_path):
    specification = {
        "chain": {"diameters": "10 mm", "beads": 4, "materials": "steel-52100",
                  "velocity": "0.01 m/s", "loss": {"law": "viscoelastic", "speed": "0.8 m/s"}},
        "axes": {"loss.restitution": [0.9, 0.95]},
        "sweep": {"methods": ["simulate"], "keep": ["velocity"]},
    }  # fmt: skip
    found = hc.sweep(specification, store=tmp_path / "sweep.zarr")
    chain = hc.Chain.from_materials("5 mm", "steel-52100", beads=4, velocity=0.01)
    lossy = chain.replace(loss=hc.Viscoelastic(time_of(chain, 1, e=0.9)))
    expected = hc.simulate(lossy).pulse().velocity
    assert found.velocity.sel(restitution=0.9).values.ravel() == pytest.approx(expected, rel=1e-6)
