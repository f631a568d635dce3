"""Laws of loss that are defined in a script, not in the package."""

from dataclasses import dataclass

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.chain.laws.base import LAWS, Loss, may_pull, parameter
from hertzchain.kernels.law_kinds import DAMPED, UNLOADING, LawRow
from hertzchain.store.chain_files import chain_from

PRESSED = {"precompression": 0.1, "held_by": "force"}


@pytest.fixture(scope="module")
def laws():
    """The classes, which are known only during these tests."""

    @dataclass(frozen=True)
    class AreaDashpot(Loss, name="area-dashpot-of-test"):
        """Damping in proportion to the overlap, without a method ``damper``."""

        gamma: float = parameter("gamma", "damping", least=0.0, unit="force/velocity/length")
        power: float = parameter("power", "power of the speed", above=0.0, default=1.0)
        attractive: bool = may_pull(default=True)

        def row(self, exponent):  # noqa: ARG002
            return LawRow(
                DAMPED, overlap_power=1.0, speed_power=self.power, attractive=self.attractive
            )

        def strength(self, contacts):
            return np.full(len(contacts.stiffness), self.gamma)

    @dataclass(frozen=True)
    class HalfReturned(Loss, name="half-returned-of-test"):
        """A force that is halved in unloading."""

        def row(self, exponent):  # noqa: ARG002
            return LawRow(UNLOADING, kept=0.5)

    yield AreaDashpot, HalfReturned
    for law in (AreaDashpot, HalfReturned):
        del LAWS[law.name]


def test_small_motions_are_damped_by_the_form_of_the_law(laws):
    AreaDashpot, _ = laws
    chain = hc.Chain.uniform(2).replace(loss=AreaDashpot(0.2), **PRESSED)
    rate = hc.spectrum(chain).decay_rates[-1]
    # The relative motion of two beads: x'' = -2 k x - 2 c x', with c = gamma d.
    overlap = 0.1 ** (2.0 / 3.0)
    assert rate == pytest.approx(0.2 * overlap, rel=1e-12)
    run = hc.simulate(chain.replace(velocities=[1e-5, -1e-5]), until=200.0, times=4000, rtol=1e-11)
    speed = np.abs(run.velocities[:, 0] - run.velocities[:, 1])
    half = len(speed) // 2
    decay = np.log(speed[:half].max() / speed[half:].max()) / (run.times[-1] / 2.0)
    assert decay == pytest.approx(rate, rel=0.02)


def test_laws_that_are_not_linear_at_rest_say_so(laws):
    AreaDashpot, HalfReturned = laws
    for law in (AreaDashpot(0.2, 0.5), HalfReturned()):
        with pytest.raises(hc.InputError, match="no motion is small enough to be linear"):
            hc.spectrum(hc.Chain.uniform(5).replace(loss=law, **PRESSED))
    with pytest.warns(hc.ModelRangeWarning, match="power 2 of the speed: small motions are not"):
        found = hc.spectrum(hc.Chain.uniform(5).replace(loss=AreaDashpot(0.2, 2.0), **PRESSED))
    assert not found.decay_rates.any()


def test_an_unknown_law_may_be_one_whose_module_is_not_imported(laws):
    AreaDashpot, _ = laws
    loss = {"law": AreaDashpot.name, "gamma": 0.2}
    document = {"chain": {"taper": "uniform", "beads": 5, "loss": loss}}
    assert chain_from(document).contact_losses[1] == AreaDashpot(0.2)
    loss["law"] = "area-dashpott"
    with pytest.raises(hc.InputError, match="import the module that defines it first"):
        chain_from(document)


def test_laws_with_a_viscous_force_say_so():
    examples = [
        hc.Elastic(), hc.Restitution(0.9), hc.Viscoelastic(0.1), hc.VelocityPower(0.1, alpha=1.8),
        hc.Dashpot(0.1), hc.WaltonBraun(0.8), hc.UnloadingRatio(0.1),
        hc.ElasticPlastic(yield_overlap=0.1),
    ]  # fmt: skip
    assert {each.name for each in examples} == {
        name for name, law in LAWS.items() if law.__module__.startswith("hertzchain.")
    }
    for law in examples:
        assert law.damps == (law.row(1.5).kind == DAMPED), law
