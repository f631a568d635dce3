"""Every method that gives a pulse, by its name: the integrations and the theories."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, Final

from hertzchain.chain.chain import Chain
from hertzchain.chain.hertz_range import warn_outside_hertz
from hertzchain.chain.scales import Scales
from hertzchain.checks import number, whole_number
from hertzchain.propagation.propagate import checked_rtol as checked_rtol_of_propagate
from hertzchain.propagation.propagate import propagate
from hertzchain.pulse.pulse import Pulse
from hertzchain.simulation.simulate import checked_rtol as checked_rtol_of_simulate
from hertzchain.simulation.simulate import simulate
from hertzchain.theory.catalogue import THEORIES

Progress = Callable[[int, int], None]

INTEGRATIONS: Final = ("propagate", "simulate")
METHODS: Final[tuple[str, ...]] = (*INTEGRATIONS, *THEORIES)
# What an integration may be told.
OPTIONS: Final[Mapping[str, tuple[str, ...]]] = {
    "propagate": ("rtol",),
    "simulate": ("rtol", "until", "max_steps"),
}


def check_option(name: str, value: Any, methods: Iterable[str]) -> None:
    """Refuse a value that an option of the integrations cannot have.

    Parameters
    ----------
    name : str
        Name of the option.
    value : object
        What was given.
    methods : iterable of str
        The methods that are told.

    Raises
    ------
    InputError
        If one of them takes the option, but not this value.

    Examples
    --------
    >>> check_option("rtol", 1e-8, ["propagate", "simulate", "bca"])
    """
    if name == "max_steps":
        whole_number(name, value, least=1)
    elif name == "until":
        # Whether the chains are in SI units, in which it may have one, is checked by the run.
        number(name, value, unit="s", above=0.0)
    else:
        ranges = {"propagate": checked_rtol_of_propagate, "simulate": checked_rtol_of_simulate}
        for method in ranges.keys() & {*methods}:
            ranges[method](value)


def pulse_by(method: str, chain: Chain, progress: Progress | None = None, **options: Any) -> Pulse:
    """The leading pulse of a chain, scaled or in SI units, by a method of any kind.

    Parameters
    ----------
    method : str
        A name of `METHODS`.
    chain : Chain
        The chain.
    progress : callable, optional
        Called as ``progress(beads_passed, beads)`` by an integration.
    **options
        Of the integration, as in `OPTIONS`.

    Returns
    -------
    Pulse
        In the units of the chain.

    Raises
    ------
    InputError
        If the method does not cover the chain.
    SimulationError
        If an integration could not be finished.

    Examples
    --------
    >>> import hertzchain as hc
    >>> chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=20, velocity=0.1)
    >>> pulse_by("bca", chain).unit("velocity")
    'm/s'
    """
    if method == "simulate":
        return simulate(chain, times=0, progress=progress, **options).pulse()
    if chain.units == "SI":
        scales = Scales.of(chain)
        pulse = scales.to_si(pulse_by(method, scales.to_scaled(chain), progress, **options))
        if pulse.peak_overlap is not None:
            warn_outside_hertz(chain, pulse.peak_overlap)
        return pulse
    if method == "propagate":
        return propagate(chain, progress=progress, **options)
    return THEORIES[method](chain)
