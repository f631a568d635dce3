"""Reflection coefficients of weak reflectors in runs that end before the wave has returned."""

import re
import warnings

import numpy as np
import pytest

import hertzchain as hc

STEP = hc.Chain.from_radii(np.where(np.arange(120) < 60, 1.0, 1.2))


@pytest.mark.parametrize("until", [105.0, 120.0])
def test_a_weak_wave_that_has_not_returned_causes_a_warning(until):
    run = hc.simulate(STEP, until=until, times=3000)
    with pytest.warns(hc.IncompleteWarning, match="reflected energy, 0.0000, is not complete: .* "
                      "on their way to contact 30 at .*; simulate for longer"):  # fmt: skip
        found = run.reflection(30, 75)
    assert found.stored_energy < 0.05


def test_the_energy_on_its_way_is_the_one_that_returns():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        late = hc.simulate(STEP, until=140.0, times=3000).reflection(30, 75)
    with pytest.warns(hc.IncompleteWarning, match=r"waves with 0\.0448 of the incident energy"):
        hc.simulate(STEP, until=105.0, times=3000).reflection(30, 75)
    assert late.reflected_energy + late.stored_energy == pytest.approx(0.0448, abs=1e-4)


def test_a_transmitted_wave_that_has_not_passed_is_named():
    """A bead of mass 20 pushes the beads behind it slowly."""
    masses = np.ones(120)
    masses[59] = 20.0
    run = hc.simulate(hc.Chain.uniform(120).replace(masses=masses), until=170.0, times=4000)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        late = run.reflection(48, 72)
    with pytest.warns(hc.IncompleteWarning, match="transmitted energy, 0.2151, is not complete"):
        early = run.reflection(48, 72, until=140.0)
    assert early.transmitted_energy < 0.96 * late.transmitted_energy


@pytest.fixture(scope="module")
def train():
    """Waves beyond a step to smaller beads follow each other ever more slowly."""
    chain = hc.Chain.from_radii(np.where(np.arange(160) < 60, 1.0, 0.5))
    return hc.simulate(chain, until=150.0, times=6000)


def test_a_momentum_that_has_not_passed_is_named_when_it_is_read(train):
    early = train.reflection(50, 75, until=90.0)
    assert early.transmitted_energy > 0.95  # so that there is no other warning
    said = "transmitted momentum, 0.76.*, is not complete: .* contact 75 at t = 90; simulate for"
    with pytest.warns(hc.IncompleteWarning, match=said):
        momentum = early.transmitted_momentum
    assert "(not complete), " in " ".join(repr(early).split())
    assert "transmitted momentum is not complete" in early._repr_html_()
    # The two contacts are open then, so that the beads between them have all of the rest.
    assert momentum + early.momentum_on_its_way[1] == pytest.approx(1.0, abs=2e-3)
    assert early.kept_momentum == pytest.approx(early.momentum_on_its_way[1], abs=2e-3)
    late = train.reflection(50, 75)
    assert late.transmitted_momentum == pytest.approx(0.9813, abs=1e-4)
    assert "not complete" not in repr(late)


def test_a_few_percent_of_momentum_on_its_way_are_stated():
    chain = hc.Chain.from_radii(np.where(np.arange(120) == 59, 2.0, 1.0))
    early, late = (
        hc.simulate(chain, until=until, times=3000).reflection(45, 75, until=until)
        for until in (150.0, 170.0)
    )
    words = " ".join(repr(early).split())
    (stated,) = re.findall(r"momentum 1\.63\d\d \(up to (\S+) more\)", words)
    assert float(stated) == pytest.approx(early.momentum_on_its_way[1], abs=5e-5)
    assert 0 < late.transmitted_momentum - early.transmitted_momentum <= float(stated)
    assert max(map(len, repr(early).splitlines())) <= 100
    assert repr(early).count("more") == 1


def test_sweeps_mark_momenta_that_are_not_complete():
    names = ["transmitted_momentum", "transmitted_energy", "kept_momentum"]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hc.IncompleteWarning)
        found = hc.sweep({
            "chain": {"radii": 1.0, "beads": 160}, "axes": {"radii.61-160": [0.5, 0.9]},
            "sweep": {"methods": ["simulate"], "keep": [f"reflection.{n}@50-75" for n in names]},
            "method": {"until": 110.0},
        }).sel(approach="simulate")  # fmt: skip
    assert found.incomplete.values.tolist() == [True, False]
    assert np.isnan(found.transmitted_momentum_50_75.values).tolist() == [True, False]
    assert found.transmitted_energy_50_75.values == pytest.approx([0.9907, 0.9993], abs=1e-4)
    assert found.kept_momentum_50_75.values == pytest.approx([0.1117, 0.0431], abs=1e-4)
    assert "transmitted momentum, 0.8883, is not complete" in found.reason.values[0]


def test_sweeps_give_the_reason():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = hc.sweep({
            "chain": {"taper": "uniform", "beads": 140, "masses": 1.0},
            "axes": {"masses.70": [0.5, 0.7]},
            "sweep": {"methods": ["simulate"], "keep": ["reflection.reflected_energy@25-84"]},
            "method": {"until": 115.0},
        })  # fmt: skip
    for reason in found.reason.values.ravel():
        assert "reflected energy, 0.0000, is not complete" in reason
