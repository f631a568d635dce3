"""Simulations and theories by name."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Final

from ..chain.chain import Chain
from ..propagation.propagate import checked_rtol as checked_rtol_of_propagate
from ..propagation.propagate import propagate
from ..pulse.pulse import Pulse
from ..simulation.simulate import checked_rtol as checked_rtol_of_simulate
from ..simulation.simulate import simulate
from ..theory.catalogue import THEORIES
from ..theory.piecewise import piecewise_local_rate
from ..validation.numbers import number, whole_number
from ..validation.objects import Progress

SIMULATIONS: Final = ("propagate", "simulate")
# The scoreboard does not have the piecewise law, which equals the local-rate law without steps.
PIECEWISE: Final = "piecewise-local-rate"
METHODS: Final[tuple[str, ...]] = (*SIMULATIONS, *THEORIES, PIECEWISE)
# Options that each simulation accepts.
OPTIONS_OF: Final[Mapping[str, tuple[str, ...]]] = {
    "propagate": ("rtol",),
    "simulate": ("rtol", "until", "max_steps"),
}


def check_option(name: str, value: Any, methods: Iterable[str]) -> None:
    """Check the value of an option of the simulations."""
    if name == "max_steps":
        whole_number(name, value, least=1)
    elif name == "until":
        # `simulate` checks whether the chain is in SI units, for which the value may have a unit.
        number(name, value, unit="s", above=0.0)
    else:
        ranges = {"propagate": checked_rtol_of_propagate, "simulate": checked_rtol_of_simulate}
        for method in ranges.keys() & {*methods}:
            ranges[method](value)


def pulse_by(method: str, chain: Chain, progress: Progress | None = None, **options: Any) -> Pulse:
    """Compute the leading pulse of a chain, scaled or in SI units, by any method.

    Parameters
    ----------
    method : str
        A name of `METHODS`.
    chain : Chain
        The chain.
    progress : callable, optional
        Called as ``progress(beads_passed, beads)`` by a simulation.
    **options
        Options of the simulation, as in `OPTIONS_OF`.

    Returns
    -------
    Pulse
        In the units of the chain.

    Raises
    ------
    InputError
        If the method does not support the chain.
    SimulationError
        If a simulation could not be finished.

    Examples
    --------
    >>> import hertzchain as hc
    >>> from hertzchain.sweeps.methods import pulse_by
    >>> chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=20, velocity=0.1)
    >>> pulse_by("bca", chain).unit("velocity")
    'm/s'
    """
    if method == "simulate":
        return simulate(chain, times=0, progress=progress, **options).pulse()
    if method == "propagate":
        return propagate(chain, progress=progress, **options)
    if method == PIECEWISE:
        return piecewise_local_rate(chain)
    return THEORIES[method](chain)
