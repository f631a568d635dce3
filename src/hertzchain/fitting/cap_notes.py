"""A note on data that are recorded after the cap of a load cell has left its wall."""

from __future__ import annotations

import math

from ..chain.chain import Chain
from ..recorded_warnings import ignore_warnings
from ..representation import measure
from ..simulation.simulate import simulate
from .simulations import RTOL


def cap_notes(chain: Chain, duration: float, *, planned: bool = False) -> tuple[str, ...]:
    """A sentence if the cap leaves its wall within the duration, counted from the impact.

    Walls push, but do not pull, so that a cap that is bolted to its cell moves differently from
    then on.  ``planned`` data are those of a forecast.
    """
    if chain.cap is None:
        return ()
    with ignore_warnings():  # an incomplete peak, and contacts that yield
        run = simulate(chain, until=duration, times=2, rtol=RTOL, check=False)
        end = run.wall_force("right").first_contact_end
    if not end or not math.isfinite(end) or end >= duration:
        return ()
    time = measure(end, "s")
    what = f"give until='{time}' or an earlier one" if planned else "fit only earlier samples"
    return (
        f"the cap leaves the wall {time} after the impact, because walls do not pull; "
        f"if it is fixed to its cell, it then oscillates, and later signals are not described: "
        f"{what}",
    )
