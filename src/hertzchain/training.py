r"""Find the universal functions of the local-rate law from our own integration.

Exponential chains, ramps of the rate and the strike at their first bead: nothing else goes in.
The response is fitted in two ways: at the ends of the chain contact by contact, each from the
true state before; within it so that the velocity *added up* along the whole ramp comes out
right (Gauss-Newton), since an error of one contact is passed on to all that follow.

    python -m hertzchain.training 1.5 src/hertzchain/theory/universal_tables
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from scipy.interpolate import BSpline, CubicSpline
from scipy.optimize import minimize

from hertzchain import __version__
from hertzchain.chain import Chain
from hertzchain.contacts import Array
from hertzchain.errors import SimulationError
from hertzchain.propagation import propagate_many
from hertzchain.theory.local_rate import solve
from hertzchain.theory.universal import (
    END,
    INPUTS,
    PAIRS,
    REFERENCES,
    STAGES,
    START,
    STATE,
    TERMS,
    WITHIN,
    UniversalFunctions,
    assembled,
    bca_growth,
    padded_knots,
    state,
)

# Rates beyond which a pulse in a forward taper has several maxima, and beyond which the BCA
# differs by a constant; nodes of the tables of exponential chains, dense where they bend.
LOWEST: Final = -0.165
HIGHEST: Final = 1.1
NODES: Final = np.unique(
    np.round([*np.linspace(LOWEST, 0.15, 43), *np.linspace(0.15, HIGHEST, 30)], 4)
)
KNOTS: Final = np.array(
    [LOWEST, -0.13, -0.1, -0.07, -0.035, 0.0, 0.04, 0.1, 0.2, 0.35, 0.5, 0.75, HIGHEST]
)
BEADS: Final = 64
# The last contacts of a long chain are not used for those within.
UNTIL: Final = BEADS - 7
RTOL: Final = 1e-8
# Changes of the rate along a ramp, numbers of contacts over which it changes, and contacts
# (counted from 0) where it begins.
CHANGES: Final = (0.005, 0.02, 0.05, 0.1, 0.2, 0.4)
LENGTHS: Final = (1, 2, 3, 5, 9, 17, 33, 58)
BEGINNINGS: Final = (0, 1, 3, 22)
# A deviation of this size counts as one in the fits, where it is punished to be large.
UNIT: Final = 0.1
RIDGES: Final = {"start": 1e-4, "within": 1e-3, "end": 1e-2}
# Ramps that the Gauss-Newton steps follow as a whole.
FOLLOWED: Final = 3000
# Errors of velocity below this are as good as none.
SMALLEST_ERROR: Final = 6e-5
DOUBLE_RAMPS: Final = 6000
# Exponential chains, on which the law should be exact, count so many times beside them.
REPEATED: Final = 5
# Ramps that the error is estimated from, and the part of their errors that it covers.
HELD_OUT: Final = 2000
COVERED: Final = 0.975


@dataclass(frozen=True, eq=False)
class Sample:
    """Chains of one length and what the pulse does to them.

    Attributes
    ----------
    rates : ndarray, shape (C, M)
        Rates of the contacts.
    states : ndarray, shape (C, M, 3)
        States of the contacts.
    """

    rates: Array
    states: Array

    def part(self, rows: Array | slice) -> Sample:
        """Some of the chains."""
        return Sample(self.rates[rows], self.states[rows])


def joined(samples: Sequence[Sample]) -> Sample:
    """One sample of several.

    Parameters
    ----------
    samples : sequence of Sample
        Chains of one length.

    Returns
    -------
    Sample
    """
    return Sample(
        np.concatenate([sample.rates for sample in samples]),
        np.concatenate([sample.states for sample in samples]),
    )


def exponential_rates() -> Array:
    """Rates of the exponential chains, shape (nodes, contacts)."""
    return np.repeat(NODES[:, None], BEADS - 1, axis=1)


def ramp_rates(beginnings: Array) -> Array:
    """Rates of the ramps: from one to another over some contacts, then constant.

    Parameters
    ----------
    beginnings : ndarray
        Rates that they begin with.

    Returns
    -------
    ndarray, shape (ramps, contacts)

    Examples
    --------
    >>> rates = ramp_rates(NODES[::2])
    >>> bool(np.all((rates >= -0.165) & (rates <= 1.1)))
    True
    """
    contact = np.arange(BEADS - 1)
    ramps = []
    for start in beginnings:
        for change in (*CHANGES, *(-change for change in CHANGES)):
            end = start + change
            steep = abs(change) > 0.15 and min(start, end) < -0.1
            if not LOWEST <= end <= HIGHEST or steep:
                continue
            for length in LENGTHS:
                for begin in BEGINNINGS:
                    if begin + length <= BEADS - 4:
                        # A ramp from contact 0 over one contact would be a constant.
                        position = (contact - begin) / length if begin or length > 1 else contact
                        ramps.append(start + change * np.clip(position, 0.0, 1.0))
    return np.array(ramps)


def double_ramp_rates(random: np.random.Generator, count: int) -> Array:
    """Rates of ramps that go on in another direction: two changes close to each other.

    Parameters
    ----------
    random : numpy.random.Generator
        Chooses rates, lengths and beginnings.
    count : int
        How many.

    Returns
    -------
    ndarray, shape (count, contacts)
    """
    contact = np.arange(BEADS - 1)
    ramps: list[Array] = []
    while len(ramps) < count:
        rates = np.full(BEADS - 1, random.uniform(LOWEST, 0.5))
        first = int(random.choice((0, 1, 3, 12, 22)))
        for _ in range(2):
            length = int(random.choice((1, 1, 2, 3, 6, 12)))
            change = random.choice((-1.0, 1.0)) * np.exp(random.uniform(np.log(0.003), np.log(0.3)))
            rates += change * np.clip((contact - first) / length, 0.0, 1.0)
            first += length + int(random.choice((0, 0, 1, 3)))
        if rates.min() >= LOWEST and rates.max() <= HIGHEST:
            ramps.append(rates)
    return np.array(ramps)


def truncated(rates: Array, random: np.random.Generator) -> list[Array]:
    """Rates of ramps cut off while they still change, or soon after.

    Parameters
    ----------
    rates : ndarray, shape (ramps, contacts)
        Rates of ramps.
    random : numpy.random.Generator
        Chooses where.

    Returns
    -------
    list of ndarray
    """
    changing = np.diff(rates, axis=1) != 0.0
    first = np.argmax(changing, axis=1)
    last = changing.shape[1] - np.argmax(changing[:, ::-1], axis=1)
    lengths = np.clip(random.integers(first + 1, last + 4), 9, rates.shape[1])
    return [row[:length] for row, length in zip(rates, lengths, strict=True)]


def follow(rates: Array | list[Array], exponent: float, last: int = BEADS) -> Sample:
    """Integrate chains of the given rates, and leave out those that cannot be.

    Parameters
    ----------
    rates : ndarray or list of ndarray
        A row a chain.
    exponent : float
        Exponent p of the contact force.
    last : int
        How many contacts to keep, counted from the end.

    Returns
    -------
    Sample
    """
    radii = (np.exp(np.concatenate([[0.0], np.cumsum(row)])) for row in rates)
    table = propagate_many((Chain.from_radii(row, exponent=exponent) for row in radii), rtol=RTOL)
    # The strongest backward ramps end where the clock has no digits left.
    rows = [row for row in range(len(table)) if row not in table.reasons]
    if len(rows) < 0.9 * len(table):
        raise SimulationError(f"{len(table) - len(rows)} of {len(table)} chains failed")
    kept = [state(table[row])[-last:] for row in rows]
    return Sample(np.array([rates[row][-last:] for row in rows]), np.array(kept))


def splines(rate: Array) -> Array:
    """Values of all B-splines at some rates, shape (..., splines)."""
    flat = np.clip(rate, LOWEST, HIGHEST).ravel()
    return BSpline.design_matrix(flat, padded_knots(KNOTS), 3).toarray().reshape(*rate.shape, -1)


def terms(inputs: Array) -> tuple[Array, Array]:
    """All terms of second degree of the inputs, and their derivatives.

    Parameters
    ----------
    inputs : ndarray, shape (C, 7)
        Deviations, in units of `UNIT`.

    Returns
    -------
    values : ndarray, shape (C, terms)
    slopes : ndarray, shape (C, terms, 7)
    """
    i, j = np.array(PAIRS).T
    values = np.concatenate([inputs, inputs[:, i] * inputs[:, j]], axis=1)
    slopes = np.zeros((*values.shape, len(INPUTS)))
    linear, products = np.arange(len(INPUTS)), len(INPUTS) + np.arange(len(PAIRS))
    slopes[:, linear, linear] = 1.0
    slopes[:, products, i] += inputs[:, j]
    slopes[:, products, j] += inputs[:, i]
    return values, slopes


class Anchors:
    """State of each stage on an exponential chain, as a function of its rate."""

    def __init__(self, exponential: Sample) -> None:
        at = [*range(START), BEADS // 2 + 12, *range(-END, 0)]
        self.values = exponential.states[:, at]
        self.values[..., 0] -= bca_growth(NODES)[:, None]
        self.spline = CubicSpline(NODES, self.values)

    def __call__(self, stage: int, rate: Array) -> Array:
        """States of a stage, shape (..., 3)."""
        found = self.spline(np.clip(rate, LOWEST, HIGHEST))[..., stage, :]
        found[..., 0] += bca_growth(rate)
        return np.asarray(found)


def inputs(anchors: Anchors, stage: int, rates: Array, contact: int, before: Array | None) -> Array:
    """What the state of a contact responds to, in units of `UNIT`, shape (C, 7).

    Parameters
    ----------
    anchors : Anchors
        States on exponential chains.
    stage : int
        Index in `STAGES`.
    rates : ndarray, shape (C, M)
        Rates of the contacts.
    contact : int
        Contact, counted from 0 at the first column.
    before : ndarray, shape (C, 3), or None
        State of the contact before, if there is one.

    Returns
    -------
    ndarray
    """
    found = np.zeros((len(rates), len(INPUTS)))
    if before is not None:
        found[:, :3] = before - anchors(REFERENCES[stage], rates[:, contact - 1])
    # Differences that reach beyond the strike or the free end count as none.
    ahead = 2 if stage <= WITHIN else 0
    for column, last in enumerate(range(contact - 1, contact + ahead + 1), start=len(STATE)):
        if last >= 1:
            found[:, column] = rates[:, last] - rates[:, last - 1]
    return found / UNIT


def fit_contact(anchors: Anchors, stage: int, sample: Sample, contacts: list[int]) -> Array:
    """Response of one stage by least squares, contact by contact, shape (terms, splines, 3)."""
    ridge = RIDGES[STAGES[stage].split()[0]]
    xs, ys, rates = [], [], []
    for contact in contacts:
        before = sample.states[:, contact - 1] if contact else None
        xs.append(inputs(anchors, stage, sample.rates, contact, before))
        rates.append(sample.rates[:, contact])
        ys.append(sample.states[:, contact] - anchors(stage, sample.rates[:, contact]))
    x, y, rate = np.concatenate(xs), np.concatenate(ys), np.concatenate(rates)
    size = UNIT * np.linalg.norm(x, axis=1)
    # Errors are judged by the size of what caused them: fully within, less at the ends.
    weight = 1.0 / (size + 1e-4) if stage == WITHIN else 1.0 / (np.sqrt(size) + 1e-2)
    used = (size > 3e-5) & (size < 0.5) if stage == WITHIN else np.full(len(size), True)
    x, y, rate, weight = x[used], y[used], rate[used], weight[used, None]
    unknowns = len(TERMS) * (len(KNOTS) + 2)
    matrix, right = np.zeros((unknowns, unknowns)), np.zeros((unknowns, len(STATE)))
    for rows in np.array_split(np.arange(len(x)), 1 + len(x) // 5000):
        part = terms(x[rows])[0][:, :, None] * splines(rate[rows])[:, None, :]
        part = part.reshape(len(rows), -1) * weight[rows]
        matrix += part.T @ part
        right += part.T @ (y[rows] * weight[rows])
    # What does not occur, such as differences before the strike, gets no response.
    occurs = np.diag(matrix) > 0.0
    scale = np.sqrt(np.diag(matrix)[occurs])
    normal = matrix[np.ix_(occurs, occurs)] / scale[:, None] / scale + ridge * np.eye(len(scale))
    found = np.zeros((unknowns, len(STATE)))
    found[occurs] = np.linalg.solve(normal, right[occurs] / scale[:, None]) / scale[:, None]
    return found.reshape(len(TERMS), -1, len(STATE))


class Rollout:
    """The law followed along many ramps at once, with its derivatives to the response within.

    Attributes
    ----------
    contact : int
        Contact reached, counted from 0.
    state : ndarray, shape (C, 3)
        Its state.
    slopes : ndarray, shape (C, 3, 3 * terms * splines)
        Derivatives of the state to the response, the component's number first.
    log_velocity, velocity_slopes : ndarray
        Growth added up since the start, and its derivatives.
    lost : ndarray of bool, shape (C,)
        Ramps that have run away.
    """

    def __init__(self, anchors: Anchors, response: Array, sample: Sample) -> None:
        chains = len(sample.rates)
        self.anchors, self.response, self.sample = anchors, response, sample
        self.contact = START - 1
        self.state = sample.states[:, self.contact]
        self.slopes = np.zeros((chains, 3, response.size))
        self.log_velocity = np.zeros(chains)
        self.velocity_slopes = np.zeros((chains, response.size))
        self.lost = np.zeros(chains, bool)

    def step(self) -> None:
        """Go on to the next contact."""
        self.contact += 1
        rate = self.sample.rates[:, self.contact]
        x = inputs(self.anchors, WITHIN, self.sample.rates, self.contact, self.state)
        values, slopes = terms(x)
        basis = splines(rate)
        local = np.einsum("cb,fbo->cfo", basis, self.response)
        change = np.einsum("cf,cfo->co", values, local)
        jacobian = np.einsum("cfi,cfo->coi", slopes[:, :, :3], local) / UNIT
        # With a first guess some run away: they are held, and count no more.
        self.lost |= ~(np.abs(change).max(axis=1) < 1.0)
        change[self.lost], jacobian[self.lost] = 0.0, 0.0
        self.state = self.anchors(WITHIN, rate) + change
        self.slopes = jacobian @ self.slopes
        direct = (values[:, :, None] * basis[:, None, :]).reshape(len(rate), -1)
        for component in range(3):
            first = component * direct.shape[1]
            self.slopes[:, component, first : first + direct.shape[1]] += direct
        self.log_velocity += self.state[:, 0]
        self.velocity_slopes += self.slopes[:, 0]


def refine(anchors: Anchors, response: Array, sample: Sample, rounds: int = 3) -> Array:
    """Response within that follows whole ramps best: Gauss-Newton from a first guess.

    Each ramp counts by its roughest change of rate, and outliers by the root of their error.

    Parameters
    ----------
    anchors : Anchors
        States on exponential chains.
    response : ndarray, shape (terms, splines, 3)
        First guess.
    sample : Sample
        Ramps.
    rounds : int
        Steps of Gauss-Newton.

    Returns
    -------
    ndarray, shape (terms, splines, 3)
    """
    roughest = np.abs(np.diff(sample.rates[:, START - 1 : UNTIL])).max(axis=1)
    weight = 1.0 / (SMALLEST_ERROR + 0.03 * roughest)
    growth = np.cumsum(sample.states[:, START:UNTIL, 0], axis=1)
    for _ in range(rounds):
        rollout = Rollout(anchors, response, sample)
        matrix, right = np.zeros((response.size, response.size)), np.zeros(response.size)
        for contact in range(START, UNTIL):
            rollout.step()
            true = sample.states[:, contact]
            errors = [rollout.log_velocity - growth[:, contact - START]]
            errors += [0.5 * (rollout.state[:, i] - true[:, i]) for i in (1, 2)]
            slopes = [rollout.velocity_slopes, *(0.5 * rollout.slopes[:, i] for i in (1, 2))]
            for error, slope in zip(errors, slopes, strict=True):
                kept = ~rollout.lost
                judged = weight[kept] * error[kept]
                lenient = 1.0 / np.sqrt(1.0 + np.abs(judged) / 3.0)
                part = slope[kept] * (weight[kept] * lenient)[:, None]
                matrix += part.T @ part
                right += part.T @ (judged * lenient)
        scale = np.sqrt(np.diag(matrix))
        scale += 1e-3 * scale.max()
        change = np.linalg.solve(matrix + 1e-4 * np.diag(scale**2), right)
        response = response - np.moveaxis(change.reshape(3, *response.shape[:2]), 0, -1)
    return response


def response(
    anchors: Anchors,
    exponential: Sample,
    ramps: Sample,
    ends: Sample,
    random: np.random.Generator,
) -> Array:
    """Response of every stage, shape (stages, terms, splines, 3), in units of the inputs.

    Parameters
    ----------
    anchors : Anchors
        States on exponential chains.
    exponential : Sample
        These chains.
    ramps : Sample
        Ramps in chains so long that the free end is not felt.
    ends : Sample
        The last contacts of ramps cut off.
    random : numpy.random.Generator
        Chooses the ramps that are followed as a whole.

    Returns
    -------
    ndarray
    """
    last = ends.rates.shape[1]
    start = [fit_contact(anchors, k, ramps, [k]) for k in range(START)]
    within = fit_contact(anchors, WITHIN, ramps, list(range(START, UNTIL)))
    chosen = random.choice(len(ramps.rates), min(FOLLOWED, len(ramps.rates)), replace=False)
    followed = [ramps.part(chosen), *[exponential] * REPEATED]
    within = refine(anchors, within, joined(followed))
    end = [fit_contact(anchors, WITHIN + 1 + i, ends, [last - END + i]) for i in range(END)]
    found = np.array([*start, within, *end])
    degree = np.array([1] * len(INPUTS) + [2] * len(PAIRS))
    return found / UNIT ** degree[:, None, None]


def error_constants(functions: UniversalFunctions, ramps: Sample) -> Array:
    """Constants of the estimated error, by quantile regression of the true error's logarithm.

    Parameters
    ----------
    functions : UniversalFunctions
        The law.
    ramps : Sample
        Ramps that it was not fitted to.

    Returns
    -------
    ndarray, shape (4,)
    """
    parts, errors = [], []
    for rates, states in zip(ramps.rates, ramps.states, strict=True):
        radii = np.exp(np.concatenate([[0.0], np.cumsum(rates)]))
        solution = solve(Chain.from_radii(radii, exponent=functions.exponent), functions)
        if solution.lost == len(rates):
            parts.append(solution.error_parts[START:])
            errors.append(np.cumsum(solution.states[:, 0] - states[:, 0])[START:])
    part = np.concatenate(parts)
    logarithm = np.log(np.abs(np.concatenate(errors)) + 1e-7)

    def loss(constants: Array) -> float:
        beyond = logarithm - np.log(part @ np.exp(constants))
        return float(np.mean(np.where(beyond > 0.0, COVERED, COVERED - 1.0) * beyond))

    guess = np.log([1e-5, 1e-3, 3e-4, 1.0])
    return np.asarray(
        np.exp(minimize(loss, guess, method="Nelder-Mead", options={"maxfev": 5000}).x)
    )


def write_tables(folder: Path, anchors: Anchors, found: Array, error: Array) -> None:
    """Write the three tables of an exponent.

    Parameters
    ----------
    folder : Path
        Where to; made if it is not there.
    anchors : Anchors
        States on exponential chains.
    found : ndarray, shape (stages, terms, splines, 3)
        The response.
    error : ndarray, shape (4,)
        Constants of the estimated error.
    """
    folder.mkdir(parents=True, exist_ok=True)
    names = [f"{stage} {name}" for stage in STAGES for name in STATE]
    rows = anchors.values.reshape(len(NODES), -1)
    _write(
        folder / "exponential.csv",
        "State of each stage on exponential chains of rate s; growth beyond that of the BCA.",
        ["s", *names],
        [
            [f"{s:g}", *(f"{value:.9f}" for value in row)]
            for s, row in zip(NODES, rows, strict=True)
        ],
    )
    listed: list[list[str]] = [["", "", "knots", *(f"{knot:g}" for knot in KNOTS), "", ""]]
    for i, stage in enumerate(STAGES):
        for j, term in enumerate(TERMS):
            for o, name in enumerate(STATE):
                if found[i, j, :, o].any():
                    listed.append([stage, name, term, *(f"{c:.6g}" for c in found[i, j, :, o])])
    _write(
        folder / "response.csv",
        "Response of the state to deviations: coefficients of cubic B-splines in s.",
        ["stage", "state", "term", *(f"c{n}" for n in range(1, found.shape[2] + 1))],
        listed,
    )
    _write(
        folder / "error.csv",
        "Constants of the estimated error of velocity, found on ramps that were not fitted.",
        ["one", "deviations, start", "deviations, others", "third degree"],
        [[f"{value:.3g}" for value in error]],
    )


def _write(file: Path, title: str, names: list[str], rows: list[list[str]]) -> None:
    with file.open("w", encoding="utf-8", newline="") as text:
        text.write(
            f"# {title}\n# Written by python -m hertzchain.training, hertzchain {__version__}"
        )
        text.write(f"; integrated with rtol = {RTOL:g}.\n")
        csv.writer(text, lineterminator="\n").writerows([names, *rows])


def train(exponent: float, folder: Path, tell: Callable[[str], None]) -> None:
    """Find the universal functions of an exponent and write their tables.

    Parameters
    ----------
    exponent : float
        Exponent p of the contact force.
    folder : Path
        Folder of all tables.
    tell : callable
        Told what is being done.
    """
    random = np.random.default_rng(0)
    tell(f"p = {exponent:g}: {len(NODES)} exponential chains")
    exponential = follow(exponential_rates(), exponent)
    anchors = Anchors(exponential)
    held_out = ramp_rates(NODES[1::2])
    held_out = held_out[random.choice(len(held_out), HELD_OUT // 2, replace=False)]
    held_out = np.concatenate([held_out, double_ramp_rates(random, HELD_OUT // 2)])
    rates = np.concatenate([ramp_rates(NODES[::2]), double_ramp_rates(random, DOUBLE_RAMPS)])
    tell(f"{len(rates)} ramps, cut off at their ends, and {HELD_OUT} held out")
    ramps = follow(rates, exponent)
    ends = follow(truncated(rates, random), exponent, last=START + END + 1)
    tell("fit")
    found = response(anchors, exponential, ramps, ends, random)
    functions = assembled(exponent, NODES, anchors.values, KNOTS, found, np.zeros(4))
    error = error_constants(functions, follow(held_out, exponent))
    write_tables(folder / f"p{exponent:g}", anchors, found, error)


if __name__ == "__main__":
    train(float(sys.argv[1]), Path(sys.argv[2]), lambda text: print(text, file=sys.stderr))
