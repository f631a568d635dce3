"""Stages of a training run: the first contacts, constants of the estimate, stored results."""

import dataclasses

import numpy as np
import pytest
from training import balance, response_fit, start_fit, training_chains
from training.second_degree import Chains
from training.sensitivities import law_states
from training.stored import Stored

from hertzchain.theory import universal_functions as tables
from hertzchain.theory.universal_functions import INPUTS, START, universal_functions


@pytest.mark.parametrize(
    ("make", "lowest"),
    [
        (training_chains.starting_rates, training_chains.LOWEST_RANDOM),
        (training_chains.oscillating_rates, -0.12),
    ],
)
@pytest.mark.parametrize("shrink", [1.0, 0.4])
def test_chains_with_quick_changes_stay_within_the_tables(make, lowest, shrink):
    rates = np.array(make(np.random.default_rng(1), 200, 40, shrink))
    assert rates.shape == (200, 40)
    assert shrink * lowest < rates.min() < 0.3 * shrink * lowest
    assert rates.max() < training_chains.HIGHEST
    # Behind the impact, or all along.
    changes = np.abs(np.diff(rates, axis=1))
    early, late = np.median(changes[:, :4]), np.median(changes[:, -8:])
    assert early > 0.002
    assert (late > 0.002) == (make is training_chains.oscillating_rates)


def test_the_second_order_of_the_first_contacts_is_found():
    """The response within the chain is kept, and so is the first order."""
    random = np.random.default_rng(2)
    law = universal_functions(1.5)
    knots, coefficients = tables.read_response(tables.table_folder(1.5) / "response.csv")
    put_in = coefficients.copy()
    put_in[:START, len(INPUTS) :] *= random.uniform(0.5, 1.5, (START, len(tables.PAIRS), 1, 1))

    def functions(response):
        pieces = tables.cubic_pieces(knots, np.moveaxis(response, 2, 0))
        return dataclasses.replace(law, response=tables._side_by_side(pieces))

    anchors = response_fit.Anchors(training_chains.follow(training_chains.exponential_rates(), 1.5))
    rates = training_chains.starting_rates(random, 900, 16)
    states = [law_states(functions(put_in), row) for row in rates]
    found = start_fit.fit_start(functions, anchors, coefficients, [Chains(rates, states)])
    np.testing.assert_array_equal(found[START], coefficients[START])
    np.testing.assert_array_equal(found[:, : len(INPUTS)], coefficients[:, : len(INPUTS)])

    def missed(response):
        of = functions(response)
        pairs = zip(rates, states, strict=True)
        return np.median([np.abs(law_states(of, a) - b)[:START].max() for a, b in pairs])

    assert missed(found) < 0.1 * missed(coefficients)


def made_up_beads(random):
    """Errors that are normally distributed about zero, as large as the terms with constants."""
    chains, beads = 400, 50
    parts = np.exp(random.normal(size=(chains * beads, 16))) * 1e-6
    parts[:, 2:] = 0.0
    errors = np.abs(random.normal(size=len(parts))) * (parts[:, :2] @ [1.0, 4.0]) + 1e-9
    return balance.Beads(
        ["one", "other"], parts, errors, np.zeros(len(parts)), beads * np.arange(chains),
        np.repeat([0, 1], chains // 2), np.zeros(chains, bool),
    )  # fmt: skip


def test_the_search_of_constants_balances_coverage_and_size():
    beads = made_up_beads(np.random.default_rng(3))
    for start in (0.3, 30.0):
        found = balance.balance(beads, np.full(16, start))
        for of in balance.results(beads, found):
            assert of.covered > 95.0
            assert of.median < 10.0
            assert of.ratios.max() < 6.0
        assert balance.score(beads, found) < 0.5 * balance.score(beads, np.full(16, start))


def test_results_of_the_estimate_are_those_of_each_chain():
    beads = made_up_beads(np.random.default_rng(4))
    constants = np.full(16, 2.0)
    first, second = balance.results(beads, constants)
    estimate = np.expm1(beads.parts @ constants).reshape(-1, 50)
    errors = beads.errors.reshape(-1, 50)
    np.testing.assert_allclose(
        np.concatenate([first.ratios, second.ratios]), (errors / estimate).max(axis=1)
    )
    assert first.covered == pytest.approx(100.0 * np.mean(errors[:200] <= estimate[:200]))
    assert second.median == pytest.approx(np.median((estimate / errors)[200:]))
    # An error of 2% that is not announced costs more than anything else.
    loud = dataclasses.replace(beads, errors=np.where(np.arange(20_000) == 7, 0.02, beads.errors))
    assert balance.results(loud, constants)[0].unwarned[0] == 0.02
    assert balance.score(loud, constants) > balance.score(beads, constants) + 50.0


def test_chains_of_the_search_are_simulated_with_their_class():
    functions = universal_functions(1.5)
    beads = balance.beads_of(functions, balance.estimate_pulses(seeds=(12,), count=1))
    assert len(beads.names) > 20
    assert list(beads.of_class) == sorted(beads.of_class)
    constants = functions.error
    smooth = balance.results(beads, constants)[beads.names.index("equal beads, scatter 0.1%")]
    assert smooth.ratios.max() < 6.0
    assert smooth.unwarned.max() < 1e-3


def test_finished_stages_are_not_run_again(tmp_path):
    stages, runs = [], []
    stored = Stored(tmp_path / "work", stages.append)
    for _ in range(2):
        assert stored("first stage", lambda: runs.append(1) or {"a": np.arange(3)})["a"][2] == 2
    assert stages == ["first stage"] * 2
    assert runs == [1]
    assert [file.name for file in (tmp_path / "work").iterdir()] == ["first-stage.pickle"]
    assert Stored(None, stages.append)("first stage", lambda: 5) == 5


def test_an_interrupted_stage_runs_again(tmp_path):
    stored = Stored(tmp_path, print)

    def interrupted():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        stored("stage", interrupted)
    assert stored("stage", lambda: 3) == 3
