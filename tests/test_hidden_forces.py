"""Curves of forces that cover each other."""

import hertzchain as hc


def test_a_covered_curve_is_dashed_on_top():
    row = hc.Chain.from_radii([1.0] * 5 + [0.02]).replace(right_wall=hc.Wall())
    run = hc.simulate(row, until=20.0, times=2001)
    covered, wall, other = hc.plotting.plot_forces(run, [6, 7, 3]).lines[:3]
    assert covered.get_zorder() > wall.get_zorder()
    assert covered.is_dashed()
    assert other.get_zorder() <= wall.get_zorder()
