"""Training data of the local-rate law, and the origin of its tables."""

import dataclasses

import numpy as np
import pytest
from numpy.polynomial.chebyshev import chebval
from training import (
    alternation,
    error_fit,
    estimate_chains,
    last_fit,
    response_fit,
    responses,
    rollout,
    second_degree,
    sensitivities,
    short_chains,
    training_chains,
)
from training.second_degree import Chains
from training.sensitivities import Sensitivity
from training.table_writer import write_error, write_fast, write_tables
from training.train import LAST_COEFFICIENTS
from training.training_chains import wavy_rates

import hertzchain as hc
from hertzchain.evaluation.unseen_tapers import unseen_radii
from hertzchain.kernels.fast_changes import AHEAD, BEHIND, COLUMNS, EARLY, PAIRS
from hertzchain.theory import exponents
from hertzchain.theory import universal_functions as tables
from hertzchain.theory.local_rate import solve
from hertzchain.theory.packed_tables import STEPS, pack, unpack
from hertzchain.theory.universal_functions import INPUTS, STAGES, WITHIN, universal_functions


def test_no_unseen_taper_is_among_the_inputs():
    random = np.random.default_rng(0)
    inputs = np.concatenate(
        [
            training_chains.exponential_rates(),
            training_chains.ramp_rates(training_chains.COARSE_NODES[::2]),
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
        (training_chains.ramp_rates(training_chains.COARSE_NODES[::2]), 2),
        (training_chains.ramp_rates(training_chains.COARSE_NODES[::3], early=True), 2),
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
        # Written with nine decimals, integrated with rtol 1e-9.
        np.testing.assert_allclose(states, table[3], atol=2e-8)


@pytest.mark.parametrize("exponent", [1.5, 2.0])
def test_tables_of_single_changes_come_back(monkeypatch, exponent):
    """One place of the tables, simulated again."""
    functions = universal_functions(exponent)
    place = 40
    monkeypatch.setattr(responses, "PLACES", functions.fast.places[place : place + 1])
    found = responses.measure(exponent)["single"].reshape(18, 48)
    by_state = functions.fast.first[:, place, 3].reshape(18, 3, -1)
    table = by_state[..., : len(range(-BEHIND, AHEAD + 1))].reshape(18, -1)
    np.testing.assert_allclose(found, table, rtol=0.0, atol=STEPS["single"])


@pytest.mark.parametrize("exponent", [1.5, 2.0])
def test_the_table_of_short_chains_comes_back(monkeypatch, exponent):
    """One place and length of the table, simulated again."""
    functions = universal_functions(exponent)
    length = 6
    contacts = short_chains.SHORT_CONTACTS[length]
    place = np.searchsorted(functions.fast.end_places, -0.06)
    rate = functions.fast.end_places[place]
    table = functions.fast.short[length, :, place, 3]
    monkeypatch.setattr(short_chains, "PLACES", np.array([rate]))
    monkeypatch.setattr(short_chains, "SHORT_CONTACTS", range(contacts, contacts + 1))
    without = functions.fast._replace(short=functions.fast.short[:0])
    found = short_chains.left_by_impact(dataclasses.replace(functions, fast=without))
    np.testing.assert_allclose(found, table.reshape(1, 1, -1), rtol=0.0, atol=STEPS["short"])


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
    basis = anchors.splines(rates[:, contact])
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
    basis = anchors.splines(np.linspace(-0.05, 0.25, 7))
    expected = np.einsum("nb,fbo->nfo", basis, put_in)
    np.testing.assert_allclose(np.einsum("nb,fbo->nfo", basis, found), expected, atol=1e-4)


def test_fit_ignores_contacts_that_follow_another_law(monkeypatch):
    """Behind steep forward tapers, later waves overtake the pulse at a few contacts."""
    monkeypatch.setitem(response_fit.RIDGES, "within", 1e-12)
    random = np.random.default_rng(12)
    put_in = random.normal(0.0, 1.0, (len(tables.TERMS), len(response_fit.KNOTS) + 2, 3))
    anchors, sample, contact = made_up(put_in, WITHIN)
    sample.states[:40, contact] += random.normal(0.0, 0.1, (40, 3))
    found = response_fit.fit_contact(anchors, WITHIN, sample, [contact])
    basis = anchors.splines(np.linspace(-0.05, 0.25, 7))
    difference = np.einsum("nb,fbo->nfo", basis, found - put_in)
    # Measured: 1e-4; 0.16 if outliers have the same weight as all others.
    assert np.abs(difference).max() < 1e-3


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


@pytest.mark.long
def test_gauss_newton_follows_ramps_better_than_the_first_guess():
    random = np.random.default_rng(6)
    ramps = training_chains.ramp_rates(training_chains.COARSE_NODES[::2])
    # With a first guess, some ramps diverge at the ends of the tables.
    ramps = ramps[(ramps.min(axis=1) > -0.1) & (ramps.max(axis=1) < 0.4)]
    ramps = random.permutation(ramps)[:150]
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
    places = responses.PLACES
    measured = {
        "places": places,
        "single": random.normal(size=(len(places), 18, 48)),
        "early": random.normal(size=(len(places), 12, 3)),
        "end": random.normal(size=(len(places), 5, 51)),
        "end_slopes": random.normal(size=(len(places), 5, 3)),
        "short": random.normal(size=(len(places), len(short_chains.SHORT_CONTACTS), 24)),
        "knots": second_degree.KNOTS,
        "second": random.normal(size=(len(second_degree.KNOTS) + 2, 18 * 105)),
        "steady": np.array(0.25),
        "last_knots": last_fit.KNOTS,
        "last": 100.0 * random.normal(size=(len(last_fit.KNOTS) + 2, LAST_COEFFICIENTS)),
        "bases": alternation.BASES,
        "alternating": random.normal(size=(len(alternation.BASES), 18, 36)),
    }
    error = np.geomspace(1e-5, 5.0, 16)
    write_tables(tmp_path / "p3", anchors, response)
    write_fast(tmp_path / "p3", measured)
    write_error(tmp_path / "p3", error)
    read = tables.read_tables(tmp_path / "p3", 3.0)
    np.testing.assert_allclose(read.nodes, training_chains.NODES)
    np.testing.assert_allclose(read.error, error, rtol=5e-3)
    expected = tables.assemble(
        3.0, training_chains.NODES, anchors.values, response_fit.KNOTS, response, measured, error
    )
    # Values between nodes that are close together: the anchors are written with nine decimals.
    np.testing.assert_allclose(read.anchors[:, :, 9:], expected.anchors[:, :, 9:], atol=2e-9)
    np.testing.assert_allclose(read.response, expected.response, rtol=1e-3, atol=1e-1)
    # The last coefficients are values.  Those of `first` are sixteen responses, and others that are
    # calculated from them.
    for name in ("first", "second", "last", "alternating"):
        found, true = (getattr(of.fast, name)[..., 3, :] for of in (read, expected))
        if name == "first":
            found, true = (each.reshape(-1, 3, 36)[..., :16] for each in (found, true))
        step = STEPS["single" if name == "first" else name]
        np.testing.assert_allclose(found, true, rtol=0.0, atol=step)


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("size", [0.0, 1e-7, 1.0, 1e9])
def test_packed_tables_are_accurate_to_half_a_step(axis, size):
    values = size * np.random.default_rng(1).normal(size=(7, 5, 2))
    packed = pack(values, 1e-6, axis)
    assert packed.dtype == np.uint8
    np.testing.assert_allclose(unpack(packed, 1e-6, axis), values, rtol=1e-15, atol=0.5001e-6)


def test_responses_between_the_ends_are_those_of_the_simulation():
    """One odd rate of 1e-5 in chains whose rates are no places of the tables."""
    functions = universal_functions(1.5)
    for rate in (-0.0331, 0.0042, 0.0567):
        contacts, odd, size = 90, 44, 1e-5
        change = size * (np.arange(contacts) == odd)
        found = training_chains.states_of([rate + change, rate - change], 1.5)
        true = (found[0] - found[1]) / (2.0 * size)
        place = np.searchsorted(functions.fast.places, rate) - 1
        x = rate - functions.fast.places[place]
        first = np.array([x**3, x**2, x, 1.0]) @ functions.fast.first[EARLY, place]
        expected = first.reshape(3, -1)
        for i, offset in enumerate(range(-BEHIND, AHEAD + 1)):
            np.testing.assert_allclose(expected[:, i], true[odd - offset], atol=3e-4)


def test_the_law_is_exact_in_first_order_within_the_chain():
    """One radius of an exponential chain whose rate is no place of the tables, and far from 0."""
    functions = universal_functions(1.5)
    for rate in (-0.0613, 0.0567, 0.1042):
        bead, size, change = 40, 1e-5, np.zeros(80)
        change[bead] = size
        rates = [rate + np.diff(sign * change) for sign in (1.0, -1.0)]
        found = training_chains.states_of(rates, 1.5)
        true = (found[0] - found[1]) / (2.0 * size)
        chains = [hc.Chain.from_radii(np.exp(np.append(0.0, np.cumsum(row)))) for row in rates]
        first, second = (solve(chain, functions).states for chain in chains)
        by_law = (first - second) / (2.0 * size)
        # Measured: 0.0013, up to 0.02 without the completed first order.
        np.testing.assert_allclose(by_law[8:70], true[8:70], atol=3e-3)


@pytest.mark.parametrize("exponent", [1.5, 2.0])
@pytest.mark.parametrize(("base", "amplitude"), [(0.005, 0.055), (-0.025, 0.085), (0.052, 0.035)])
def test_the_effect_of_alternation_is_that_of_the_simulation(exponent, base, amplitude):
    """Chains between the bases and amplitudes of the table, at the settled pulse and both ends."""
    functions = universal_functions(exponent)
    rates = [alternation.alternating_rates(base, sign * amplitude) for sign in (1.0, -1.0)]
    nothing = functions.fast._replace(bases=np.zeros(0), alternating=np.zeros((0, 0, 4, 0)))
    without = dataclasses.replace(functions, fast=nothing)
    for row, true in zip(rates, training_chains.states_of(rates, exponent), strict=True):
        radii = np.exp(np.append(0.0, np.cumsum(row)))
        chain = hc.Chain.from_radii(radii, exponent=exponent)
        error = (solve(chain, functions).states - true)[:, 0]
        before = (solve(chain, without).states - true)[:, 0]
        # Measured: at most 0.04, 0.03 and 0.17.
        for part, must in ((slice(40, 60), 0.1), (slice(12), 0.1), (slice(-5, None), 0.4)):
            total = np.abs(np.cumsum(error[part])).max()
            assert total < must * np.abs(np.cumsum(before[part])).max()


def test_responses_add_up_to_the_change_of_an_exponential_chain():
    """All rates in sight of the first contacts changed together: a change of the rate."""
    step, rate = 1e-4, 0.02
    states, response = responses.respond(rate, 30, range(7), 1.5)
    moved = training_chains.states_of([np.full(30, rate + h) for h in (step, -step)], 1.5)
    slope = (moved[0] - moved[1]) / (2.0 * step)
    np.testing.assert_allclose(response[0], slope, atol=1e-4)
    alone = np.array([response[i] - response[i + 1] for i in range(6)])
    # The first four contacts see six rates.
    np.testing.assert_allclose(alone.sum(axis=0)[:4], slope[:4], atol=1e-4)
    assert np.abs(states[0, 0]) > 0.0


def products_put_in(random, same):
    """Random chains, functions with and without products, and the states of the chains."""
    put_in = universal_functions(1.5)
    second = put_in.fast.second
    if same:
        # Those of two fast changes, the same for all stages.
        second = np.repeat(second[EARLY : EARLY + 1], len(second), axis=0)
        by_state = second.reshape(*second.shape[:3], 3, COLUMNS)
        by_state[..., PAIRS:] = 0.0
    put_in = dataclasses.replace(put_in, fast=put_in.fast._replace(second=second))
    nothing = put_in.fast._replace(second=np.zeros_like(second))
    rates = training_chains.random_rates(random, 260, 63, smooth=False)
    rates = [row for row in rates if np.abs(np.diff(row)).max() < 0.05]
    states = [sensitivities.law_states(put_in, row) for row in rates]
    return put_in, dataclasses.replace(put_in, fast=nothing), rates, states


def fraction_missed(functions, unfitted, rates, states):
    def missed(of):
        differences = zip(rates, states, strict=True)
        return np.mean([np.abs(sensitivities.law_states(of, a) - b).mean() for a, b in differences])

    return missed(functions) / missed(unfitted)


def test_products_that_were_put_in_are_found():
    _, unfitted, rates, states = products_put_in(np.random.default_rng(8), same=True)
    fitted = fitted_functions(unfitted, second_degree.fit(unfitted, [Chains(rates, states)]))
    assert fraction_missed(fitted, unfitted, rates, states) < 0.1


@pytest.mark.long
def test_products_at_both_ends_are_found_from_derivatives():
    random = np.random.default_rng(8)
    put_in, unfitted, rates, states = products_put_in(random, same=False)
    chains = [sensitivities.law_slopes(put_in, row) for row in wavy_rates(random, 60, 40)]
    within = second_degree.fit(unfitted, [Chains(rates, states)], chains)
    second = second_degree.fit_stages(fitted_functions(unfitted, within), within, chains)
    fitted = fitted_functions(unfitted, second)
    # Measured: 0.19.
    assert fraction_missed(fitted, unfitted, rates, states) < 0.4
    for row in wavy_rates(random, 5, 40):
        true, found, missing = (
            sensitivities.law_slopes(functions, row).slopes
            for functions in (put_in, fitted, unfitted)
        )
        assert np.abs(found - true).mean() < 0.3 * np.abs(missing - true).mean()


def fitted_functions(functions, second):
    """The same functions with products of fast changes."""
    pieces = tables.cubic_pieces(second_degree.KNOTS, second)
    return dataclasses.replace(
        functions, fast=functions.fast._replace(second=tables._by_stage(pieces))
    )


def test_derivatives_by_all_rates_add_up_to_that_of_an_exponential_chain():
    rate, step = 0.02, 1e-4
    (found,) = sensitivities.simulate_slopes([np.full(24, rate)], 1.5)
    moved = training_chains.states_of([np.full(24, rate + h) for h in (step, -step)], 1.5)
    expected = (moved[0] - moved[1]) / (2.0 * step)
    np.testing.assert_allclose(found.slopes.sum(axis=-1), expected, atol=2e-5)
    # With all radii larger by the same factor, the states are the same.
    np.testing.assert_allclose(sensitivities.of_radii(found.slopes).sum(axis=-1), 0.0, atol=1e-12)


def test_the_estimate_exceeds_the_fraction_of_errors_that_is_required():
    random = np.random.default_rng(9)
    parts = np.exp(random.normal(size=(20_000, 2)) - 5.0)
    errors = np.abs(random.normal(size=20_000)) * (parts @ [0.3, 2.0])
    constants = error_fit.quantile_fit(parts, errors)
    assert np.mean(errors <= parts @ constants) == pytest.approx(error_fit.COVERED, abs=0.01)
    # The quantile of a normal distribution.
    np.testing.assert_allclose(constants, 2.33 * np.array([0.3, 2.0]), rtol=0.3)


def test_weights_of_the_estimate_are_those_of_repeated_errors():
    random = np.random.default_rng(10)
    parts = np.exp(random.normal(size=(6000, 2)) - 5.0)
    errors = np.abs(random.normal(size=6000)) * (parts @ [0.3, 2.0])
    often = np.where(np.arange(6000) < 500, 7, 1)
    expected = error_fit.quantile_fit(np.repeat(parts, often, axis=0), np.repeat(errors, often))
    found = error_fit.quantile_fit(parts, errors, weights=often)
    np.testing.assert_allclose(found, expected, rtol=0.02)


def test_a_term_that_never_occurs_does_not_disturb_the_others():
    random = np.random.default_rng(11)
    parts = np.exp(random.normal(size=(5000, 2)) - 5.0)
    errors = np.abs(random.normal(size=5000)) * parts[:, 0]
    parts[:, 1] = 0.0
    alone = error_fit.quantile_fit(parts[:, :1], errors)
    assert error_fit.quantile_fit(parts, errors)[0] == pytest.approx(alone[0], rel=1e-3)


@pytest.mark.parametrize("shrink", [1.0, 0.4])
def test_chains_of_the_estimate_are_of_twelve_classes_within_the_range(shrink):
    classes = estimate_chains.estimate_chains(np.random.default_rng(4), 20, shrink)
    assert [len(chains) for chains in classes] == [20] * 12
    tapers = [row for chains in classes[:2] + classes[4:9] for row in chains]
    assert min(row.min() for row in tapers) > shrink * training_chains.LOWEST_RANDOM
    everything = [row for chains in classes for row in chains]
    assert max(row.max() for row in tapers) < training_chains.HIGHEST
    assert max(abs(row.sum()) for row in everything) < training_chains.LONGEST
    assert min(len(row) for row in everything) >= 8


def test_the_interpolation_is_exact_at_the_tables_and_for_polynomials():
    nodes = exponents.EXPONENTS
    at_nodes = chebval(exponents.place_of(nodes), exponents.coefficients(np.eye(len(nodes))))
    np.testing.assert_allclose(at_nodes, np.eye(len(nodes)), atol=1e-12)
    powers = np.log(nodes)[:, None] ** np.arange(len(nodes))
    for p in (1.25, 1.77, 3.0):
        found = chebval(exponents.place_of(p), exponents.coefficients(powers))
        np.testing.assert_allclose(found, np.log(p) ** np.arange(len(nodes)), rtol=1e-9)


def test_stored_tables_of_all_exponents_are_those_that_were_packed():
    random, count = np.random.default_rng(5), len(exponents.EXPONENTS)
    shapes = {name: [count] + 3 * [9] for name in exponents.AXES} | {"second": [count, 9, 9]}
    tables_of_all = {name: random.normal(size=shape) for name, shape in shapes.items()}
    packed = exponents.pack_tables(tables_of_all)
    for index, p in enumerate(exponents.EXPONENTS):
        for name, axis in exponents.AXES.items():
            stored = unpack(packed[name], STEPS[name], axis)
            found = chebval(exponents.place_of(p), stored)
            expected = tables_of_all[name][index]
            if name == "second":
                expected = expected * exponents.product_gain(p)
            # Ten coefficients, each accurate to half a step.
            np.testing.assert_allclose(found, expected, rtol=0.0, atol=5.0 * STEPS[name])


@pytest.mark.long
def test_the_response_of_the_last_contacts_that_was_put_in_is_found():
    put_in = universal_functions(1.5).fast
    unfitted = put_in._replace(last=np.zeros_like(put_in.last))

    def chain(rates, of=put_in):
        slopes = last_fit.of_last_rates(lambda row: last_fit.last_states(of, row), rates)
        return Sensitivity(rates, last_fit.last_states(of, rates), slopes)

    rates = training_chains.ending_rates(np.random.default_rng(11), 200)
    chains = [chain(row[-30:]) for row in rates]
    found = last_fit.fit_last(unfitted, chains)
    fitted = unfitted._replace(last=tables._by_contact(last_fit.KNOTS, found))
    missed = [chain(each.rates, fitted).less(each) for each in chains]
    without = [chain(each.rates, unfitted).less(each) for each in chains]
    # Larger errors than 10% are not fitted; the smaller ones count most.
    for name in ("states", "slopes"):
        after, before = (
            np.array([np.abs(getattr(each, name)).reshape(4, -1).max(axis=1) for each in of])
            for of in (missed, without)
        )
        assert np.all(np.median(after, axis=0) < 0.1 * np.median(before, axis=0))


def test_last_contacts_of_exponential_chains_are_those_of_the_simulation():
    """States and derivatives between the places of the tables, and after a recent impact."""
    law = universal_functions(1.5)
    for rate, contacts in ((0.0007, 40), (-0.0262, 40), (0.0336, 40), (-0.02, 12)):
        (true,) = sensitivities.simulate_slopes([np.full(contacts, rate)], 1.5, last=4)
        found = last_fit.last_states(law.fast, true.rates)
        # Impact and free end overlap in short chains.
        near = 2e-5 if contacts > 20 else 1e-3
        np.testing.assert_allclose(found, true.states[-4:], atol=near)
        slopes = last_fit.of_last_rates(
            lambda row, fast=law.fast: last_fit.last_states(fast, row), true.rates
        )
        near = 1e-3 if contacts > 20 else 5e-3
        np.testing.assert_allclose(slopes[..., -4:], true.slopes[-4:], atol=near)


def test_scaled_rates_leave_growing_tapers_alone():
    for found in (
        training_chains.exponential_rates(0.3),
        training_chains.double_ramp_rates(np.random.default_rng(1), 50, 0.3),
        np.array(training_chains.odd_rates(np.random.default_rng(1), 50, 30, 0.3)),
        np.array(training_chains.steep_rates(np.random.default_rng(1), 50, 30, 0.3)),
    ):
        assert 0.3 * training_chains.LOWEST <= found.min() < 0.0
        assert found.max() > 0.1


def test_interpolated_functions_are_those_of_the_tables_of_hertz_contacts():
    """Two trainings with different chains: exponential chains agree to the rounding of tables."""
    own = universal_functions(1.5)
    found = tables.functions_of(
        1.5, exponents.interpolated_tables(tables.table_folder(1.5).parent, 1.5)
    )
    for rate in (-0.05, -0.02, 0.0, 0.05, 0.3):
        chain = hc.Chain.from_radii(np.exp(rate * np.arange(60)))
        difference = solve(chain, found).states[40] - solve(chain, own).states[40]
        np.testing.assert_allclose(difference, 0.0, atol=3e-5)


def test_random_chains_stay_within_their_range():
    for smooth in (True, False):
        rates = training_chains.random_rates(np.random.default_rng(3), 100, 30, smooth=smooth)
        assert all(len(row) == 30 for row in rates)
        assert min(row.min() for row in rates) > training_chains.LOWEST_RANDOM
        assert max(abs(row.sum()) for row in rates) < training_chains.LONGEST
