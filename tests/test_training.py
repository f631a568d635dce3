"""Training data of the local-rate law, and the origin of its tables."""

import numpy as np
import pytest
from training import response_fit, rollout, training_chains
from training.table_writer import write_tables

from hertzchain.evaluation.unseen_tapers import unseen_radii
from hertzchain.theory import universal_functions as tables
from hertzchain.theory.universal_functions import INPUTS, STAGES, WITHIN, universal_functions


def test_no_unseen_taper_is_among_the_inputs():
    random = np.random.default_rng(0)
    inputs = np.concatenate(
        [
            training_chains.exponential_rates(),
            training_chains.ramp_rates(training_chains.NODES),
            training_chains.double_ramp_rates(random, training_chains.DOUBLE_RAMPS),
        ]
    )
    for name, radii in unseen_radii().items():
        rates = np.diff(np.log(radii))[: inputs.shape[1]]
        nearest = np.abs(inputs - rates).max(axis=1).min()
        # Relative to the radius or, for the gentlest tapers, to the range of rates.
        assert nearest > min(1e-3, 0.2 * np.ptp(rates)), name


def test_inputs_are_exponential_chains_and_ramps_alone():
    exponential = training_chains.exponential_rates()
    assert np.all(exponential == exponential[:, :1])
    for rates, most in (
        (training_chains.ramp_rates(training_chains.NODES[::2]), 2),
        (training_chains.double_ramp_rates(np.random.default_rng(1), 300), 5),
    ):
        slopes = np.diff(rates, axis=1).round(9)
        # Piecewise linear rates: the number of changes of the slope is limited.
        assert np.count_nonzero(np.diff(slopes, axis=1), axis=1).max() <= most


@pytest.mark.parametrize("node", [0, 20, 43, 60])
def test_tables_of_exponential_chains_come_back(node):
    rates = training_chains.exponential_rates()[node : node + 1]
    states = training_chains.follow(rates, 1.5).states[0, training_chains.BEADS // 2 + 12]
    functions = universal_functions(1.5)
    table = functions.anchors[WITHIN, min(node, len(functions.nodes) - 2)].reshape(4, 3)
    if node < len(functions.nodes) - 1:
        expected = table[3].copy()
        expected[0] += tables.bca_growth(rates[0, 0])
        # Written with nine decimals, integrated with rtol 1e-9.
        np.testing.assert_allclose(states, expected, atol=2e-8)


def made_up(response, stage, chains=4000):
    """States of contacts that follow a given response of one stage exactly."""
    random = np.random.default_rng(2)
    contacts = 12
    rates = random.uniform(-0.1, 0.3, (chains, 1)) + np.cumsum(
        random.normal(0.0, 0.01, (chains, contacts)), axis=1
    )
    exponential = training_chains.Sample(
        training_chains.exponential_rates(),
        np.zeros((len(training_chains.NODES), training_chains.BEADS - 1, 3)),
    )
    anchors = response_fit.Anchors(exponential)
    states = random.normal(0.0, 0.03, (chains, contacts, 3))
    contact = 6
    x = response_fit.inputs(anchors, stage, rates, contact, states[:, contact - 1])
    basis = response_fit.splines(rates[:, contact])
    states[:, contact] = anchors(stage, rates[:, contact]) + np.einsum(
        "cf,cb,fbo->co", response_fit.terms(x)[0], basis, response
    )
    return anchors, training_chains.Sample(rates, states), contact


def test_fit_finds_a_response_that_was_put_in(monkeypatch):
    monkeypatch.setitem(response_fit.RIDGES, "within", 1e-12)
    random = np.random.default_rng(3)
    shape = len(tables.TERMS), len(response_fit.KNOTS) + 2, 3
    put_in = random.normal(0.0, 1.0, shape)
    anchors, sample, contact = made_up(put_in, WITHIN)
    found = response_fit.fit_contact(anchors, WITHIN, sample, [contact])
    # Splines at rates that occur: the response is a function, not its coefficients.
    basis = response_fit.splines(np.linspace(-0.05, 0.25, 7))
    expected = np.einsum("nb,fbo->nfo", basis, put_in)
    np.testing.assert_allclose(np.einsum("nb,fbo->nfo", basis, found), expected, atol=1e-4)


def test_terms_have_the_slopes_they_say():
    random = np.random.default_rng(4)
    x = random.normal(size=(3, len(INPUTS)))
    values, slopes = response_fit.terms(x)
    assert values.shape == (3, len(tables.TERMS))
    step = 1e-6
    for i in range(len(INPUTS)):
        moved = x.copy()
        moved[:, i] += step
        np.testing.assert_allclose((response_fit.terms(moved)[0] - values) / step, slopes[:, :, i],
                                   atol=1e-5)  # fmt: skip


def test_gauss_newton_follows_ramps_better_than_the_first_guess():
    ramps = training_chains.double_ramp_rates(np.random.default_rng(6), 60)
    gentle = ramps[np.abs(np.diff(ramps, axis=1)).max(axis=1) < 0.05]
    sample = training_chains.follow(gentle, 1.5)
    exponential = training_chains.follow(training_chains.exponential_rates(), 1.5)
    anchors = response_fit.Anchors(exponential)
    guess = response_fit.fit_contact(
        anchors, WITHIN, sample, list(range(rollout.START, rollout.UNTIL))
    )

    def error(response):
        followed = rollout.Rollout(anchors, response, sample)
        while followed.contact < rollout.UNTIL - 1:
            followed.step()
        growth = sample.states[:, rollout.START : rollout.UNTIL, 0].sum(axis=1)
        assert not followed.lost.any()
        return np.sqrt(np.mean((followed.log_velocity - growth) ** 2))

    assert error(rollout.refine(anchors, guess, sample, rounds=2)) < 0.5 * error(guess)


def test_tables_are_read_as_they_were_written(tmp_path):
    random = np.random.default_rng(7)
    anchors = response_fit.Anchors(
        training_chains.Sample(
            training_chains.exponential_rates(),
            random.normal(size=(len(training_chains.NODES), training_chains.BEADS - 1, 3)),
        )
    )
    response = random.normal(size=(len(STAGES), len(tables.TERMS), len(response_fit.KNOTS) + 2, 3))
    write_tables(tmp_path / "p3", anchors, response, np.array([1e-5, 2e-3, 3e-3, 4.0]))
    read = tables.read_tables(tmp_path / "p3", 3.0)
    np.testing.assert_allclose(read.nodes, training_chains.NODES)
    np.testing.assert_allclose(read.error, [1e-5, 2e-3, 3e-3, 4.0])
    expected = tables.assemble(
        3.0, training_chains.NODES, anchors.values, response_fit.KNOTS, response, read.error
    )
    np.testing.assert_allclose(read.anchors, expected.anchors, atol=1e-2)
    np.testing.assert_allclose(read.response, expected.response, rtol=1e-3, atol=1e-1)
