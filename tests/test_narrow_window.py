"""The front-following kernel: its method, its interpolation, its lanes and its refusals."""

import numpy as np
import pytest
from kernel_call import callable_from_python
from numba import njit

import hertzchain as hc
from hertzchain.kernels import hermite, narrow_window, narrow_window_events, rkn8
from hertzchain.kernels import narrow_window_rows as rows
from hertzchain.propagation.batch import Batch
from hertzchain.threads import COUNT

STEP = (0.15, 0.1)
NO_LIMITS = (np.inf, np.inf, np.inf)
NODES = (0.0, rkn8.C1, rkn8.C2, rkn8.C3, rkn8.C4, rkn8.C5, rkn8.C6, rkn8.C7)


def follow(
    chains, window=(13, 8), lanes=narrow_window.ABREAST, limits=NO_LIMITS, step=STEP, power=None
):
    """Columns of each chain, and what became of it."""
    batch = Batch.of(chains)
    columns = np.full((rows.COLUMNS, len(batch.masses)), np.nan)
    status = np.zeros(len(chains), np.int64)
    narrow_window.follow(
        lanes, (*window, *step), limits, (batch.given, batch.first, batch.beads, power), columns,
        status, np.zeros(2, np.int64), narrow_window.scratch_of(lanes),
    )  # fmt: skip
    return np.split(columns, batch.first[1:], axis=1), status


def test_rkn8_weights_satisfy_the_quadrature_conditions():
    # sum b' c^k = 1/(k+1), sum b c^k = 1/((k+1)(k+2)): the conditions for x'' = f(t).
    for k in range(8):
        powers = np.array(NODES) ** k
        assert np.dot(rkn8.B_VELOCITY, powers) == pytest.approx(1 / (k + 1), rel=1e-13)
        if k < 7:
            exact = 1 / ((k + 1) * (k + 2))
            assert np.dot(rkn8.B_POSITION, powers[:7]) == pytest.approx(exact, rel=1e-13)
    rows = (rkn8.A1, rkn8.A2, rkn8.A3, rkn8.A4, rkn8.A5, rkn8.A6, rkn8.A7)
    for node, row in zip(NODES[1:], rows, strict=True):
        assert sum(row) == pytest.approx(node**2 / 2, rel=1e-12)


def test_error_weights_vanish_on_polynomials_of_degree_5_only():
    nodes = np.array([*NODES, 1.0])
    errors = [abs(np.dot(rkn8.E_VELOCITY, nodes**k)) for k in range(7)]
    assert max(errors[:6]) < 1e-15
    assert errors[6] > 1e-4


@njit
def steps_of_two_beads(w, steps):
    for _ in range(steps):
        rows.accelerate(w, 0, 2, rows.STAGE_0, 1, None)
        rows.take_step(w, 2, 1, None)


def relative_velocity_error(steps):
    """Two compressed beads are released: the exact velocity follows from energy."""
    w = np.zeros(rows.END)
    w[rows.STIFFNESS] = 1.0
    w[rows.INVERSE_MASS : rows.INVERSE_MASS + 2] = 1.0
    w[rows.POSITION] = 1.0
    w[rows.STEP : rows.STEP + 2] = 1.0 / steps
    steps_of_two_beads(w, steps)
    overlap = w[rows.POSITION] - w[rows.POSITION + 1]
    speed = w[rows.VELOCITY + 1] - w[rows.VELOCITY]
    return abs(speed**2 / 4.0 + 0.4 * overlap**2.5 - 0.4)


def test_order_8():
    # Before rounding counts, the order seen rises from 7.2 towards 8.
    errors = [relative_velocity_error(steps) for steps in (4, 8, 12)]
    orders = np.log(np.array(errors[:-1]) / errors[1:]) / np.log([2.0, 1.5])
    assert errors[0] < 1e-9
    assert np.all(orders > 7.1)


def test_hermite_polynomial_reproduces_degree_7():
    rng = np.random.default_rng(5)
    p = np.polynomial.Polynomial(rng.normal(size=8))
    h = 0.7
    derivatives = [p, p.deriv(), p.deriv(2), p.deriv(3)]
    value, slope = callable_from_python(hermite.value), callable_from_python(hermite.slope)
    curvature, third = callable_from_python(hermite.curvature), callable_from_python(hermite.third)
    at_ends = [d(time) for time in (0.0, h) for d in derivatives]
    c = callable_from_python(hermite.hermite)(h, *at_ends)
    s = 0.37
    assert value(c, s) == pytest.approx(p(s * h), rel=1e-12)
    assert slope(c, s) == pytest.approx(p.deriv()(s * h) * h, rel=1e-12)
    assert curvature(c, s) == pytest.approx(p.deriv(2)(s * h) * h**2, rel=1e-12)
    assert third(c, s) == pytest.approx(p.deriv(3)(s * h) * h**3, rel=1e-12)


def test_released_contact_gives_the_rest_of_the_impulse():
    # Two beads just before they part: the exact final speed follows from the energy.
    w = np.zeros(rows.END)
    w[rows.STIFFNESS + 1] = 1.0
    w[rows.INVERSE_MASS + 1 : rows.INVERSE_MASS + 3] = 1.0
    overlap, speed = 1e-3, 0.5
    w[rows.POSITION + 1] = overlap
    w[rows.VELOCITY + 1], w[rows.VELOCITY + 2] = -speed / 2, speed / 2
    w[rows.STAGE_0 + 2] = overlap**1.5
    w[rows.STAGE_0 + 1] = -(overlap**1.5)
    callable_from_python(narrow_window_events.release)(w, 1, 1, overlap / speed, None)
    exact = np.sqrt(speed**2 + 1.6 * overlap**2.5) / 2.0
    assert w[rows.VELOCITY + 2] - speed / 2 == pytest.approx(exact - speed / 2, rel=1e-5)
    assert w[rows.STIFFNESS + 1] == 0.0


@pytest.mark.parametrize("lanes", [narrow_window.ALONE, narrow_window.ABREAST])
def test_lanes_do_not_touch_each_other(lanes):
    """More chains than lanes, of different lengths: each gives the same bits as separately."""
    rates = (0.01, 0.03, 0.05, 0.07)
    chains = [
        hc.Chain.tapered(taper, rate, beads=20 + 3 * i)
        for i, rate in enumerate(rates)
        for taper in ("backward-exponential", "forward-exponential", "backward-linear")
    ]
    together, status = follow(chains, lanes=lanes)
    assert np.all(status == rows.FOLLOWED)
    for chain, columns in zip(chains, together, strict=True):
        alone, _ = follow([chain], lanes=narrow_window.ALONE)
        assert np.array_equal(alone[0], columns, equal_nan=True)


def test_convergence_with_the_step():
    chain = hc.Chain.tapered("backward-exponential", 0.05, beads=40)
    fine = follow([chain], step=(0.05, 0.02), lanes=narrow_window.ALONE)[0][0]
    errors = [
        np.nanmax(
            np.abs(
                follow([chain], step=(part, 0.1), lanes=narrow_window.ALONE)[0][0][0] / fine[0]
                - 1.0
            )
        )
        for part in (0.3, 0.15)
    ]
    assert errors[1] < 3e-9
    assert errors[0] > 8 * errors[1]


def test_window_too_narrow_behind_is_noticed():
    chain = hc.Chain.tapered("forward-exponential", 0.05, beads=60)
    limits = (1e-8, np.inf, np.inf)
    assert (
        follow([chain], window=(9, 4), limits=limits, lanes=narrow_window.ALONE)[1][0]
        == rows.REAR_CUT
    )
    wrong = follow([chain], window=(9, 4), lanes=narrow_window.ALONE)[0][0][0]
    right = follow([chain], lanes=narrow_window.ALONE)[0][0][0]
    assert np.max(np.abs(wrong / right - 1.0)[1:]) > 1e-5  # so it was worth noticing


def test_window_too_narrow_ahead_is_noticed():
    chain = hc.Chain.uniform(40)
    limits = (np.inf, 1e-9, np.inf)
    assert (
        follow([chain], window=(10, 8), limits=limits, lanes=narrow_window.ALONE)[1][0]
        == rows.FRONT_CUT
    )
    assert follow([chain], limits=limits, lanes=narrow_window.ALONE)[1][0] == rows.FOLLOWED


def test_too_long_steps_are_noticed():
    chain = hc.Chain.uniform(40)
    limits = (np.inf, np.inf, 1e-6)
    assert (
        follow([chain], limits=limits, step=(0.6, 0.1), lanes=narrow_window.ALONE)[1][0]
        == rows.INACCURATE
    )
    assert follow([chain], limits=limits, lanes=narrow_window.ALONE)[1][0] == rows.FOLLOWED


@pytest.mark.parametrize("rate", [0.15, 0.3])
def test_beads_out_of_order_are_noticed(rate):
    chain = hc.Chain.tapered("forward-exponential", rate, beads=40)
    assert follow([chain], lanes=narrow_window.ALONE)[1][0] == rows.OUT_OF_ORDER


def test_stop_signal_ends_the_kernel():
    batch = Batch.of([hc.Chain.uniform(50)] * 3)
    signal = np.array([1, 0])
    status = np.zeros(3, np.int64)
    narrow_window.follow(
        narrow_window.ABREAST, (13, 8, *STEP), NO_LIMITS,
        (batch.given, batch.first, batch.beads, None), np.empty((rows.COLUMNS, 150)),
        status, signal, narrow_window.scratch_of(narrow_window.ABREAST),
    )  # fmt: skip
    assert np.all(status == rows.WAITING)
    assert signal[COUNT] == 0
