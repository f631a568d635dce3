"""Times of the forces in the figure of a design."""

import numpy as np
import pytest

from hertzchain.designs.curves import Curve, _until_quiet


@pytest.mark.parametrize(("late", "end"), [(0.02, 0.55), (0.2, 3.0)])
def test_small_late_contacts_do_not_lengthen_the_figure(late, end):
    times = np.linspace(0.0, 3.0, 3001)
    force = np.where(times < 0.5, np.sin(np.pi * times / 0.5), 0.0)
    force[1990:2000] = late
    (found,) = _until_quiet([Curve("design", False, times, force, 1.0)])
    assert found.x[-1] == pytest.approx(end, rel=0.11)
