"""Verification after a search: which trials need new samples, their journal, and progress."""

import dataclasses
import re

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.designs import verification
from hertzchain.designs.new_samples import FRESH, OTHER_SEED
from hertzchain.designs.search_budget import budget_from
from hertzchain.designs.trials import Trials
from hertzchain.designs.verification import Verification
from hertzchain.store.journal import Journal

SCATTER = hc.Scatter(radius=0.02, samples=4)
WALLED = hc.Chain.uniform(5).replace(right_wall=hc.Wall())
PROBLEM = hc.Design(
    WALLED, minimise="wall_force.peak", vary=[hc.vary.radii(0.5, 1.0)], scatter=SCATTER
)


def cvar90(chain, seed):
    """CVaR90 of the peak on the wall in the new samples of a verification."""
    chains = SCATTER._chains(chain, SCATTER._draws(seed + OTHER_SEED, chain.beads, FRESH))
    peaks = np.sort(hc.simulate_many(chains, keep=["wall_peak_force"])["wall_peak_force"])
    return peaks[-FRESH // 10 :].mean()


@pytest.fixture(scope="module")
def second():
    return hc.design(PROBLEM, budget=600, seed=2)


@pytest.fixture(scope="module")
def first():
    return hc.design(PROBLEM, budget=600)


@pytest.mark.long
def test_the_design_and_the_references_have_the_same_new_samples(second):
    found = second
    for each in (found.verified, *found.references.values()):
        sampled = each.scattered["CVaR90 of wall_force.peak"]
        assert sampled == pytest.approx(cvar90(each.chain, 2), rel=1e-6)
    assert len(found.runners_up) == 4
    assert not any(each.scattered for each in found.runners_up)


def test_references_are_compared_by_the_statistic_of_the_scatter(second):
    found = second
    own = cvar90(found.chain, 2)
    lines = found.summary().splitlines()
    assert len(found.references) == 3
    for name, each in found.references.items():
        (place,) = (i for i, text in enumerate(lines) if re.match(rf"  (best )?{name}\b", text))
        word, *both = lines[place + 1].split()
        *words, part, nominal_part = lines[place + 2].replace("%", "").split()
        assert [word, *words] == ["value", "this", "design", "/", "value"]
        value, nominal, part, nominal_part = map(float, [*both, part, nominal_part])
        assert value == pytest.approx(cvar90(each.chain, 2), rel=5e-4)
        assert part == pytest.approx(100 * own / cvar90(each.chain, 2), abs=0.051)
        peaks = [hc.simulate(chain).wall_force().peak for chain in (each.chain, found.chain)]
        assert nominal == pytest.approx(peaks[0], rel=5e-4)
        assert nominal_part == pytest.approx(100 * peaks[1] / peaks[0], abs=0.051)
        # Notebooks show the same words.
        words = f"CVaR90 {both[0]}; this design: {part}% of this value; no scatter {both[1]}; "
        assert words in found._repr_html_()
    assert "CVaR90 in the search" in found._repr_html_()


def test_references_that_violate_a_limit_in_new_samples_are_not_compared(first):
    found = first
    name, other = next(iter(found.references.items()))
    worse = 1.01 * other.values["wall_force.peak"]
    assert worse < other.scattered["CVaR90 of wall_force.peak"]
    limited = dataclasses.replace(PROBLEM, subject_to={"wall_force.peak": f"<= {worse}"})
    lines = dataclasses.replace(found, problem=limited).summary().splitlines()
    place = next(i for i, text in enumerate(lines) if name in text)
    (line,) = (text for text in lines[place : place + 4] if "NOT meet" in text)
    assert "does NOT meet CVaR90 of wall_force.peak <= " in line
    assert line.endswith("in 400 new samples")
    assert "NOT" not in found.summary()


@pytest.mark.long
def test_new_samples_are_read_from_the_journal(tmp_path, monkeypatch):
    given = {"budget": 600, "store": tmp_path}
    found = hc.design(PROBLEM, **given)
    monkeypatch.delattr(verification, "sampled_values")
    again = hc.design(PROBLEM, **given)
    assert again.summary() == found.summary()
    assert again.verified.scattered == found.verified.scattered
    assert again.seconds == found.seconds


@pytest.mark.parametrize(
    ("excess", "sampled"),
    [([0, 0, 0, 0], 1), ([1, 0, 0, 0], 2), ([1, 2, 0, 3], 3), ([4, 3, 2, 1], 4), ([1, 1, 1, 1], 4)],
)
def test_new_samples_are_simulated_until_the_best_trial_is_known(monkeypatch, excess, sampled):
    """The order is that of a comparison of all trials."""
    trials = Trials(PROBLEM, budget_from(100), Journal(None, ""), seed=0)
    points = [np.full(4, level) for level in (0.2, 0.4, 0.6, 0.8)]
    tops = sorted(trials.evaluate(points), key=lambda each: each.rank)
    verify = Verification(trials, len(tops))
    amounts = {verify.numbers(top).chain: each for top, each in zip(tops, excess, strict=True)}
    asked = []

    def excess_of(_, found):
        asked.append(found.chain)
        return {"limit": float(amounts[found.chain])}

    monkeypatch.setattr(verification, "sampled_values", lambda *_: np.ones((FRESH, 1)))
    monkeypatch.setattr(verification, "excess_with_scatter", excess_of)
    best, _, others = verify.best(tops)
    ranks = [(top.rank[0] + each, top.rank[1]) for top, each in zip(tops, excess, strict=True)]
    assert best is tops[int(np.argmin([first for first, _ in ranks]))]
    assert len(asked) == sampled
    assert len(others) == 3


def test_lines_state_what_is_verified(monkeypatch):
    lines = []
    monkeypatch.setattr(verification, "INTERVAL", 0.0)
    monkeypatch.setattr(verification, "write_current", lines.append)
    hc.design(PROBLEM, budget=600)
    assert lines == []
    hc.design(PROBLEM, budget=600, progress=lambda *_: None)
    begin = "hertzchain: verifying the result: "
    assert lines
    assert all(line.startswith(begin) for line in lines)
    texts = [line.removeprefix(begin) for line in lines]
    assert any(text.endswith("of 8 is integrated again at rtol 1e-11") for text in texts)
    for what in ("design", "chain to compare with"):
        assert f"{FRESH} of {FRESH} new samples of the scatter, {what}" in texts


def test_the_initial_chain_of_a_figure_needs_no_new_samples(first):
    found = first
    assert found._initial.scattered == {}
    assert found.problem.evaluate(WALLED).scattered["mean of wall_force.peak"] > 0.0
