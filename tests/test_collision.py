import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import beta

from hertzchain import collision


def test_hertz_stiffness_is_symmetric_and_survives_tiny_radii():
    assert collision.hertz_stiffness(0.3, 2.0) == collision.hertz_stiffness(2.0, 0.3)
    assert collision.hertz_stiffness(1e-100, 1e-100) == pytest.approx(1e-50, rel=1e-14)


def test_stiffness_of_the_paper():
    # r_k = [2 R R' / (R + R')]^(1/2), below Eq. (4).
    assert collision.hertz_stiffness(1.0, 0.5) == pytest.approx(np.sqrt(2 / 3), rel=1e-15)


@pytest.mark.parametrize("ratio", [0.01, 0.5, 1.0, 3.0, 100.0])
def test_transfer_conserves_energy_and_momentum(ratio):
    struck = collision.velocity_transfer(1.0, ratio)
    striker = 1.0 - ratio * struck
    assert striker**2 + ratio * struck**2 == pytest.approx(1.0, rel=1e-13)


@pytest.mark.parametrize("p", [1.25, 1.5, 2.0, 3.0])
def test_collision_against_its_differential_equation(p):
    mu, k, v = 0.7, 1.9, 0.4

    def stops(_, y):
        return y[1]

    stops.terminal, stops.direction = True, -1
    end = solve_ivp(
        lambda _, y: [y[1], -k / mu * max(y[0], 0.0) ** p],
        (0, 50),
        [0.0, v],
        events=stops,
        method="DOP853",
        rtol=1e-12,
        atol=1e-14,
    )
    assert collision.compression_time(mu, k, v, p) == pytest.approx(end.t[-1], rel=1e-9)
    assert collision.collision_overlap(mu, k, v, p) == pytest.approx(end.y[0, -1], rel=1e-9)


@pytest.mark.parametrize(
    ("p", "integral"), [(1.5, 1.47163759216), (2, 1.40218210533), (3, 1.31102877715)]
)
def test_integral_of_the_compression_time(p, integral):
    overlap = collision.collision_overlap(0.5, 1.0, 1.0, p)
    assert collision.compression_time(0.5, 1.0, 1.0, p) / overlap == pytest.approx(
        integral, rel=1e-11
    )
    # The same integral as a beta function: int du / sqrt(1 - u^(p+1)).
    assert integral == pytest.approx(beta(1 / (p + 1), 0.5) / (p + 1), rel=1e-11)
