"""Steps of the radius and odd beads in the local-rate law, against simulations."""

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.theory.piecewise import find_jumps

BEADS, FIRST = 100, 41
K = np.arange(BEADS)
TAPERS = {
    "uniform": np.ones(BEADS),
    "exponential": np.exp(-0.02 * K),
    "linear": 1 + 0.05 * K,
    "kink": np.exp(np.minimum(0.02 * K, 0.04 * FIRST - 0.02 * K)),
}


def errors(radii, quantity="velocity"):
    chain = hc.Chain.from_radii(radii)
    compared = hc.piecewise_local_rate(chain).compare(hc.propagate(chain))
    return np.abs(compared.errors(quantity))


@pytest.mark.parametrize("taper", TAPERS)
@pytest.mark.parametrize("factor", [0.55, 0.8, 1.3, 1.9])
def test_velocity_transmitted_by_a_step(taper, factor):
    radii = np.where(K >= FIRST, factor, 1.0) * TAPERS[taper]
    found = errors(radii)
    assert found[1 : FIRST - 8].max() < 5e-4
    assert found[FIRST + 40 : -3].max() < 5e-3
    assert errors(radii, "peak_force")[FIRST + 40 : -3].max() < 5e-3
    assert errors(radii, "arrival")[FIRST + 40 :].max() < 2e-3


@pytest.mark.parametrize("taper", TAPERS)
@pytest.mark.parametrize("factor", [0.55, 0.8, 1.3, 1.9])
def test_velocity_transmitted_by_an_odd_bead(taper, factor):
    found = errors(np.where(K == FIRST, factor, 1.0) * TAPERS[taper])
    assert found[FIRST + 40 : -3].max() < 5e-3


def test_the_beads_next_to_a_jump():
    for factor in (0.85, 1.5):
        for jump in (K >= FIRST, K == FIRST):
            radii = np.where(jump, factor, 1.0)
            for quantity in ("velocity", "peak_force", "residence"):
                assert errors(radii, quantity)[FIRST - 8 : FIRST + 30].max() < 3e-3


def test_two_jumps_far_apart():
    radii = np.select([K < 25, K < 50], [1.0, 1.4], 0.9)
    radii[70] *= 0.7
    assert errors(radii)[1:-3].max() < 5e-3


def test_smooth_chains_have_no_jumps():
    for radii in TAPERS.values():
        assert find_jumps(np.diff(np.log(radii))) == []
    chain = hc.Chain.tapered("backward-linear", 0.1, beads=40)
    piecewise, law = hc.piecewise_local_rate(chain), hc.local_rate(chain)
    np.testing.assert_array_equal(piecewise.velocity, law.velocity)
    assert piecewise.method == "piecewise local-rate law"


def test_si_units_and_error_estimate():
    radii = 5e-3 * np.where(K >= FIRST, 1.3, 1.0)
    chain = hc.Chain.from_materials(radii, "steel-52100", velocity=0.2)
    law = hc.piecewise_local_rate(chain)
    compared = law.compare(hc.propagate(chain))
    assert compared.worst("velocity") < 2e-3
    assert compared.worst("peak_force") < 2e-3
    assert law.velocity_error[30] < 1e-3 < 5e-3 <= law.velocity_error[60]


@pytest.mark.parametrize(("radii", "message"), [
    (np.where(K >= FIRST, 3.0, 1.0), "factor of 3 at contact 41"),
    (np.where(K >= 4, 1.5, 1.0), "8 contacts"),
    (np.where(K >= BEADS - 3, 1.5, 1.0), "before the end"),
    (np.where((K >= FIRST) & (K < FIRST + 5), 1.5, 1.0), "there are 4 before"),
    (np.where(K >= 1, 1.5, 1.0), "at an end"),
    (np.where(K >= FIRST, 1.5, 1.0) * np.exp(0.1 * K), "rates at a jump"),
])  # fmt: skip
def test_other_jumps_are_rejected(radii, message):
    with pytest.raises(hc.InputError, match=message):
        hc.piecewise_local_rate(hc.Chain.from_radii(radii))


def test_jumps_need_hertz_contacts():
    chain = hc.Chain.from_radii(np.where(K >= FIRST, 2.0, 1.0), exponent=2.0)
    with pytest.raises(hc.InputError, match=r"exponent 1\.5\) only, got 2; use propagate"):
        hc.piecewise_local_rate(chain)
    with pytest.warns(hc.ModelRangeWarning) as raised:
        hc.local_rate(chain)
    assert "piecewise" not in str(raised[0].message)
    # Without jumps, the law has tables for this exponent.
    smooth = hc.Chain.from_radii(np.exp(0.01 * K), exponent=2.0)
    exact = hc.propagate(smooth).velocity
    # Measured: 1.1e-6.
    np.testing.assert_allclose(hc.piecewise_local_rate(smooth).velocity[1:], exact[1:], rtol=1e-5)


def test_fast_changes_next_to_a_jump_are_announced():
    radii = np.where(K >= FIRST, 0.5, 1.0) * np.exp(0.2 * np.sin(K / 10))
    chain = hc.Chain.from_radii(radii)
    with pytest.warns(hc.ModelRangeWarning, match="jump of the radius at contact 41") as raised:
        law = hc.piecewise_local_rate(chain)
    assert raised[0].filename == __file__
    errors = np.abs(law.compare(hc.propagate(chain)).errors("velocity"))
    assert (errors <= law.velocity_error)[FIRST + 20 : -3].all()


def test_warnings_name_the_theory_and_the_chain_without_jumps():
    radii = np.resize([1.0, 0.93], 80) * np.where(np.arange(80) < 40, 1.0, 1.5)
    chain = hc.Chain.from_radii(radii)
    with pytest.warns(hc.ModelRangeWarning) as raised:
        hc.piecewise_local_rate(chain)
    first = str(raised[0].message)
    assert first.startswith("piecewise_local_rate may be inaccurate for this chain (")
    assert "80 beads, without its jumps)" in first
    assert "local_rate for steps" not in first


STEP = "[chain]\nradii = [1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2]\n"


@pytest.mark.filterwarnings("always::hertzchain.ModelRangeWarning")
def test_the_law_on_the_command_line_and_in_sweeps(run, tmp_path):
    (tmp_path / "step.toml").write_text(STEP)
    advice = run("pulse", tmp_path / "step.toml", "--method", "local-rate").stderr
    assert "or --method piecewise-local-rate for steps and odd beads" in advice
    done = run("pulse", tmp_path / "step.toml", "--method", "piecewise-local-rate", "--csv")
    chain = hc.Chain.from_radii([1.0] * 12 + [2.0] * 12)
    rows = np.genfromtxt(done.stdout.splitlines(), delimiter=",", names=True)
    exact = hc.propagate(chain).velocity[1:21]
    np.testing.assert_allclose(rows["velocity"][1:21], exact, rtol=3e-3)

    document = {"chain": {"radii": [1.0] * 12 + [2.0] * 12}, "axes": {"exponent": [1.5]},
                "sweep": {"methods": ["piecewise-local-rate"]}}  # fmt: skip
    velocity = hc.sweep(document).velocity.squeeze()
    np.testing.assert_allclose(velocity[1:21], exact, rtol=3e-3)
