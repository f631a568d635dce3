"""Values of simulated quantities and their derivatives with respect to parameters of a chain."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from functools import partial

import numpy as np

from ..chain.chain import Chain
from ..chain.feature_support import require_chain
from ..chain.hertz_warnings import warn_outside_hertz
from ..collision import Array
from ..errors import IncompleteWarning, InputError, warn_user
from ..simulation.simulate import default_step_limit
from ..validation.keywords import checked_arguments
from ..validation.numbers import number, whole_number
from ..validation.objects import Progress, callback, check_list
from .accuracy import TIGHTER, Accuracy, SecondRun, least_error
from .backward_pass import Slopes, backward_pass
from .dependence import Reader
from .differences import Differences, differences, needs_differences
from .equation import METHOD, Equation, equation_of
from .gauges import Missing
from .kinks import has_kinks, kinks_of_maxima
from .names import Name, parse
from .parameters import by_fields, checked_parameters
from .record import run
from .relative import per_unit, unit_of_parameter, unit_of_quantity, value_of_parameter
from .result import Gradient
from .targets import Ending, targets_of
from .window import follow_pulse

DEFAULT_RTOL, WINDOW_RTOL, DAMPED_RTOL = 1e-10, 3e-8, 1e-12
MIN_RTOL, MAX_RTOL = 1e-14, 1e-5


@checked_arguments("gradient")
def gradient(
    chain: Chain,
    quantity: str,
    *,
    to: str | Iterable[str] = ("radii",),
    bead: int | str | None = None,
    until: float | None = None,
    rtol: float | None = None,
    max_steps: int | None = None,
    progress: Progress | None = None,
) -> Gradient:
    r"""Value of a simulated quantity and its derivatives with respect to parameters.

    The chain is integrated by the Runge-Kutta-Nyström pair RKN8(6) of `simulate_many` with a
    separate step size; with damping, by DOP853.  One backward pass over the stored steps then
    gives the derivatives with respect to all parameters (the *discrete adjoint*, E. Hairer, S. P.
    Nørsett, G. Wanner, Solving Ordinary Differential Equations I, Sec. II.6): with
    :math:`y_{n+1} = \Phi_n(y_n, p)` and a quantity :math:`Q(y_M, p)`,

    .. math::

        \lambda_M = \frac{\partial Q}{\partial y_M}, \qquad
        \lambda_n = \left(\frac{\partial \Phi_n}{\partial y_n}\right)^{\!T} \lambda_{n+1}, \qquad
        \frac{dQ}{dp} = \frac{\partial Q}{\partial p}
            + \sum_n \lambda_{n+1}^T \frac{\partial \Phi_n}{\partial p} .

    At a maximum the derivative of its time does not contribute (envelope theorem).  Derivatives
    of times follow from the implicit function theorem.

    These derivatives are exact.  They exist for elastic chains and for the losses `Viscoelastic`,
    `Restitution` and `Dashpot`.  The forces of other losses, such as `ElasticPlastic`, jump when a
    contact begins to open, are not linear in the closing speed, or depend on the past.  Their
    derivatives are central differences of simulations, in which a parameter of a bead is larger
    and smaller by 0.1% and 0.2%: ``method`` and ``error`` of the result state this and the
    difference between both steps.

    The largest force on a wall is the largest of several maxima, and has a kink where two of them
    are equal, as is usual for a design.  ``kinks`` of the result names the parameters of which a
    change by 1% leads beyond such a kink, so that the derivatives are valid for smaller changes
    only; with differences, it follows from two more simulations per bead.

    Parameters
    ----------
    chain : Chain
        A chain without drive.
    quantity : str
        ``"pulse."`` and a column of `Pulse`, of a ``bead``; ``"wall_force."`` or
        ``"left_wall_force."`` and ``peak``, ``peak_time``, ``impulse``, ``impulse_of_impact``,
        ``first_contact_impulse`` or ``duration``; ``"body_force.peak"`` or
        ``"body_force.acceleration"`` of the last body of a free right end; ``"sensor."`` and
        ``first_maximum``, ``first_maximum_time``, ``largest``, ``largest_time`` or ``impulse``, of
        a sensor in a ``bead``; ``"bead.largest_velocity"``, ``"bead.largest_momentum"`` or
        ``"bead.largest_energy"`` at the largest forward velocity of a ``bead`` in the whole run;
        ``"final.velocity"`` or ``"final.position"`` of a ``bead`` at ``until``; or
        ``"energy."`` and ``kinetic``, ``forward``, ``backward``, ``contacts`` or ``walls``, the
        energy at ``until``.  ``"pulse.velocity@90"`` and
        ``"velocity@last"`` include the bead.  Differences have those that `simulate_many` gives.
    to : str or iterable of str
        Parameters: ``"radii"``, ``"masses"``, ``"stiffness"``, ``"gaps"``, ``"velocities"``,
        ``"young"``, ``"poisson"``, ``"density"`` (of each bead), with `ElasticPlastic`
        ``"yield_strength"``, ``"left_wall.stiffness"``,
        ``"right_wall.stiffness"``, ``"left_wall.gap"``, ``"right_wall.gap"``,
        ``"precompression"``, ``"gravity"``, ``"loss.time"``, ``"loss.coefficient"`` or
        ``"loss.gamma"``; by differences, those of each bead or contact except gaps, where they are
        not 0 (NaN otherwise).  Masses and stiffness follow the radii and materials unless they are
        given in the chain.  A wall with a given material keeps it.  The unit of a scaled chain
        remains fixed when radius 1 is varied.
    bead : int or str, optional
        Number k of the bead, from 1, or its name, such as ``"ball 9"``.
    until : float, optional
        Stop time [scaled, or s].  By default the run ends when the quantity is complete.
    rtol : float, optional
        Relative tolerance per step, 1e-14 .. 1e-5; by default 1e-10, 1e-12 with damping, and
        3e-8 for the leading pulse in a free chain whose neighbours differ little, because only
        the beads around this pulse are then integrated.  The error of a gradient is about the 0.6th
        power of the tolerance for Hertz contacts, because their force rises with an infinite
        curvature, and about its square root with damping.
    max_steps : int, optional
        Step limit; by default 2000 per bead, and at least a million.
    progress : callable, optional
        Called as ``progress(chains_done, chains)`` if derivatives are differences of simulations.

    Returns
    -------
    Gradient

    Raises
    ------
    InputError
        If the chain does not have the quantity or a parameter, has a drive, or an argument is out
        of range.
    SimulationError
        If the step limit is reached.

    Warns
    -----
    IncompleteWarning
        If the quantity does not exist in the run or is not complete at its end; ``status``
        states why.
    ModelRangeWarning
        If a chain of materials exceeds the limits of Hertz's law in the run (`hertz_range`).

    Examples
    --------
    The peak force on a wall falls most if the bead next to it becomes smaller:

    >>> import hertzchain as hc
    >>> chain = hc.Chain.tapered("forward-exponential", 0.05, beads=20)
    >>> chain = chain.replace(right_wall=hc.Wall())
    >>> value, slope = hc.gradient(chain, "wall_force.peak", to=("radii", "gaps"))
    >>> round(value, 3), slope["gaps"].shape
    (0.889, (19,))
    """
    if not isinstance(quantity, str):
        raise InputError("gradient requires the name of one quantity; use gradients for several")
    found = gradients(
        chain, [quantity], to=to, bead=bead, until=until, rtol=rtol, max_steps=max_steps,
        progress=progress,
    )  # fmt: skip
    return found[0]


@checked_arguments("gradients")
def gradients(
    chain: Chain,
    quantities: Iterable[str],
    *,
    to: str | Iterable[str] = ("radii",),
    bead: int | str | None = None,
    until: float | None = None,
    rtol: float | None = None,
    max_steps: int | None = None,
    progress: Progress | None = None,
) -> list[Gradient]:
    """Values of several quantities and their derivatives, from one run.

    Parameters
    ----------
    chain, to, bead, until, rtol, max_steps, progress
        As for `gradient`.
    quantities : iterable of str
        Names as for `gradient`.  ``"wall_force.maxima"`` gives several: all maxima of at least
        half the largest force, the largest first.

    Raises
    ------
    InputError, SimulationError
        In the cases listed for `gradient`.

    Examples
    --------
    >>> import hertzchain as hc
    >>> chain = hc.Chain.uniform(10).replace(right_wall=hc.Wall())
    >>> for each in hc.gradients(chain, ["wall_force.peak", "pulse.arrival@10"]):
    ...     print(each.quantity, round(each.value, 3), each["radii"].shape)
    wall_force.peak 1.244 (10,)
    pulse.arrival@10 10.91 (10,)
    """
    require_chain(METHOD, chain)
    callback("progress", progress)
    quantities = check_list("quantities", quantities, "names of quantities")
    if needs_differences(chain):
        names = [parse(chain, each, bead, until) for each in quantities]
        parameters = checked_parameters(chain, to)
        runs, overlaps = differences(
            chain, names, parameters, until=until, rtol=rtol, max_steps=max_steps,
            progress=progress,
        )  # fmt: skip
        found = [_of_differences(chain, *each) for each in zip(names, runs, strict=True)]
    else:
        reader, names, rtol, parameters = _recorded(
            chain, quantities, to=to, bead=bead, until=until, rtol=rtol, max_steps=max_steps
        )
        second = SecondRun(partial(_slopes_again, chain, quantities, parameters, bead, until, rtol))
        found = _read(reader, names, parameters, rtol, second)
        overlaps = reader.record.largest_overlaps()
    for each in found:
        if each.status != "complete":
            warn_user(f"{each.quantity}: {each.status}", IncompleteWarning)
    if chain.units == "SI":
        warn_outside_hertz(chain, overlaps, method="gradient")
    return found


def quantity_values(
    chain: Chain, quantities: Iterable[str], *, until: float | None, rtol: float | None
) -> list[tuple[float, str]]:
    """Values and status of several quantities, without derivatives."""
    reader, names, *_ = _recorded(chain, quantities, to="masses", until=until, rtol=rtol)
    found = []
    for name in names:
        try:
            found += [(each.value, note or "complete") for _, each, note in reader.read(name)]
        except Missing as missing:
            found.append((math.nan, str(missing)))
    return found


def _recorded(
    chain: Chain,
    quantities: Iterable[str],
    *,
    to: str | Iterable[str],
    bead: int | str | None = None,
    until: float | None = None,
    rtol: float | None = None,
    max_steps: int | None = None,
    other: bool = False,
) -> tuple[Reader, list[Name], float, tuple[str, ...]]:
    """Integrate a chain; returns the reader, checked names, the tolerance, and the parameters."""
    equation = equation_of(chain)
    if until is not None:
        until = number("until", until, unit=chain._unit("s"), above=0.0)
    if rtol is not None:
        rtol = number("rtol", rtol, least=MIN_RTOL, most=MAX_RTOL)
    limit = default_step_limit(chain.beads)
    if max_steps is not None:
        limit = whole_number("max_steps", max_steps, least=1)
    given = check_list("quantities", quantities, "names of quantities")
    names = [parse(chain, each, bead, until) for each in given]
    parameters = checked_parameters(chain, to)
    targets = targets_of(equation, names)
    ending = Ending(equation, names, targets)
    pulses_only = all(name.group == "pulse" for name in names)
    of_pulse = pulses_only and until is None
    record = None
    if of_pulse:
        record = follow_pulse(equation, targets.array(), rtol or WINDOW_RTOL, other=other)
    if record is not None:
        rtol = rtol or WINDOW_RTOL
    else:
        rtol = rtol or (DEFAULT_RTOL if equation.hertz is not None else DAMPED_RTOL)
        record = run(
            equation, targets.array(), math.inf if until is None else until, rtol, limit,
            (lambda _: False) if until is not None else ending.finished, pulses_only,
        )  # fmt: skip
    if until is not None:
        ending.finished(record)
    return Reader(record, ending, until), names, rtol, parameters


def _slopes_again(
    chain: Chain, quantities: Sequence[str], to: tuple[str, ...], bead: int | str | None,
    until: float | None, rtol: float,
) -> list[dict[str, Array]]:  # fmt: skip
    """Derivatives at a smaller tolerance, with other settings of a window.

    At the smallest tolerance, a larger one is used.
    """
    factor = TIGHTER if TIGHTER * rtol >= MIN_RTOL else 1.0 / TIGHTER
    reader, names, *_ = _recorded(
        chain, quantities, to=to, bead=bead, until=until, rtol=factor * rtol, other=True
    )
    return [slopes for name in names for _, _, slopes, _ in _derivatives(reader, name, to)]


def _derivatives(
    reader: Reader, name: Name, to: tuple[str, ...]
) -> list[tuple[str, float, dict[str, Array], str]]:
    """Name, value, derivatives and status of a quantity; `wall_force.maxima` has several."""
    equation: Equation = reader.record.equation
    try:
        read = reader.read(name)
    except Missing as missing:
        nothing = {key: _nan_like(equation, key) for key in to}
        return [(str(name), math.nan, nothing, str(missing))]
    out = []
    for each, dependence, note in read:
        arrays = by_fields(equation, backward_pass(reader.record, dependence), to)
        for values in arrays.values():
            values.setflags(write=False)
        out.append((str(each), dependence.value, arrays, note or "complete"))
    return out


def _read(
    reader: Reader, names: Iterable[Name], to: tuple[str, ...], rtol: float, second: SecondRun
) -> list[Gradient]:
    equation: Equation = reader.record.equation
    steps, chain, least = reader.record.steps, equation.chain, least_error(equation, rtol)
    read = [(name, each) for name in names for each in _derivatives(reader, name, to)]
    out = []
    for index, (name, (label, value, arrays, status)) in enumerate(read):
        accuracy = Accuracy(least, second, index, len(read))
        settings = _settings(chain, name, to)
        known = math.isfinite(value)
        kinks = kinks_of_maxima(reader, name, arrays, settings[-1]) if known else ()
        out.append(
            Gradient(label, value, arrays, status, steps, accuracy, *settings, chain, kinks=kinks)
        )
    return out


def _of_differences(chain: Chain, name: Name, found: Differences) -> Gradient:
    """The result of differences of simulations."""
    complete = math.isfinite(found.value)
    status = "complete" if complete else f"{name} is not complete at the end of the run"
    for values in found.slopes.values():
        values.setflags(write=False)
    settings = _settings(chain, name, tuple(found.slopes))
    return Gradient(
        str(name), found.value, found.slopes, status, 0, found, *settings, chain,
        "central differences", found.kinks if has_kinks(name) else (),
    )  # fmt: skip


def _settings(
    chain: Chain, name: Name, to: tuple[str, ...]
) -> tuple[str, dict[str, str], dict[str, Array]]:
    """Units of the value and of the derivatives, and values of the parameters."""
    unit = unit_of_quantity(chain, name)
    units = {key: per_unit(unit, unit_of_parameter(chain, key)) for key in to}
    return unit, units, {key: value_of_parameter(chain, key) for key in to}


def _nan_like(equation: Equation, name: str) -> Array:
    shape = by_fields(equation, Slopes.zero(equation.beads), [name])[name].shape
    return np.full(shape, math.nan)
