"""The state of a run between two steps: all that is needed to go on from there."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from hertzchain.chain.chain import Chain
from hertzchain.chain.equilibrium import equilibrium
from hertzchain.contacts import Array
from hertzchain.errors import InputError
from hertzchain.simulation.equations import equation_of, start_of, transit_times

if TYPE_CHECKING:
    from hertzchain.chain.scales import Scales
    from hertzchain.kernels.forces import Bench, Contacts, Plain


@dataclass(frozen=True, eq=False)
class State:
    """Where a run stands, to the last bit.

    ``run.state`` is one; `hertzchain.simulate` goes on from it with ``start=``, and the
    longer run is then the one that had never stopped.

    Attributes
    ----------
    chain : Chain
        The chain.
    time : float
        Time of the state [scaled, or s]: the end of the last step that was not cut short
        by the end of the run.
    positions, velocities : ndarray, shape (N,)
        Of the beads [scaled, or m and m/s].
    arrays : dict of ndarray
        Everything, as the compiled loop keeps it.

    Examples
    --------
    >>> import hertzchain as hc
    >>> chain = hc.Chain.uniform(20)
    >>> state = hc.simulate(chain, until=5.0).state
    >>> later = hc.simulate(chain, start=state, times=[10.0])
    >>> whole = hc.simulate(chain, times=[10.0])
    >>> bool((later.velocities == whole.velocities).all())
    True
    """

    chain: Chain
    arrays: dict[str, Array]

    @property
    def time(self) -> float:
        """Time of the state [scaled, or s]."""
        from hertzchain.kernels import records

        return float(self.arrays["clock"][records.TIME])

    @property
    def positions(self) -> Array:
        """Displacements of the beads, shape (N,) [scaled, or m]."""
        return self.arrays["y"][: self.chain.beads] + equilibrium(self.chain).positions

    @property
    def velocities(self) -> Array:
        """Velocities of the beads, shape (N,) [scaled, or m/s]."""
        return self.arrays["y"][self.chain.beads : 2 * self.chain.beads].copy()

    @property
    def start(self) -> tuple[float, float]:
        """Energy (with what is stored) and momentum with which the run began."""
        from hertzchain.kernels import records

        clock = self.arrays["clock"]
        return float(clock[records.INITIAL_ENERGY]), float(clock[records.INITIAL_MOMENTUM])

    def factors(self, scales: Scales) -> Mapping[str, Mapping[str, Array]]:
        """Units of the arrays, for `hertzchain.Scales`.

        Parameters
        ----------
        scales : Scales
            The units.

        Returns
        -------
        dict

        Examples
        --------
        >>> import hertzchain as hc
        >>> state = hc.simulate(hc.Chain.uniform(2), until=3.0).state
        >>> scales = hc.Scales(radius=1.0, mass=1.0, velocity=2.0, length=6.0)
        >>> scales.to_si(state).time == 3.0 * state.time
        True
        """
        from hertzchain.kernels import records

        motion = np.repeat([scales.length, scales.velocity], self.chain.beads)
        clock = np.full(records.CLOCK_SIZE, np.nan)
        clock[[records.TIME, records.STEP, records.SINCE_CROSSING]] = scales.time
        clock[records.FASTEST] = scales.velocity
        clock[[records.INITIAL_ENERGY, records.ENERGY_UNIT, records.ENERGY_DRIFT]] = scales.energy
        clock[[records.INITIAL_MOMENTUM, records.MOMENTUM_UNIT, records.MOMENTUM_DRIFT]] = (
            scales.momentum
        )
        return {
            "arrays": {
                "y": np.concatenate([motion, ledger_units(scales)])[: len(self.arrays["y"])],
                "clock": clock,
                "largest": np.array(scales.length),
                **records_units(scales),
            }
        }

    def copy(self) -> State:
        """The same state in arrays of its own.

        Examples
        --------
        >>> import hertzchain as hc
        >>> state = hc.simulate(hc.Chain.uniform(5), until=1.0).state
        >>> state.copy().time == state.time
        True
        """
        return replace(self, arrays={name: value.copy() for name, value in self.arrays.items()})

    def reversed(self) -> State:
        """The state with all velocities turned round, at time 0.

        A lossless chain that goes on from it runs back to where it came from.

        Returns
        -------
        State

        Raises
        ------
        InputError
            If the chain has losses or a drive, which know the direction of time.

        Examples
        --------
        >>> import hertzchain as hc
        >>> chain = hc.Chain.uniform(10)
        >>> state = hc.simulate(chain, until=8.0).state
        >>> back = hc.simulate(chain, start=state.reversed(), times=[state.time])
        >>> bool(abs(back.velocities[0, 0] + 1.0) < 1e-10)
        True
        """
        for name in ("loss", "drive"):
            if name in self.chain.features:
                raise InputError(f"a chain with {name} does not run backwards: leave it out")
        return new_state(self.chain, self.arrays["y"][: self.chain.beads], -self.velocities)


def ledger_units(scales: Scales) -> Array:
    """Units of what is integrated along with the motion.

    Parameters
    ----------
    scales : Scales
        The units.

    Returns
    -------
    ndarray, shape (5,)
        Of the energy lost, work and impulse of the drive, impulses of left and right wall.

    Examples
    --------
    >>> import hertzchain as hc
    >>> ledger_units(hc.Scales(radius=1.0, mass=3.0, velocity=2.0, length=1.0))
    array([12., 12.,  6.,  6.,  6.])
    """
    return np.repeat([scales.energy, scales.momentum], [2, 3])


def records_units(scales: Scales) -> dict[str, Array]:
    """Units of what is recorded between the steps, row by row.

    Parameters
    ----------
    scales : Scales
        The units.

    Returns
    -------
    dict of ndarray, shape (rows, 1)
        Of ``peaks``, ``crossings``, ``walls`` and ``completion``.

    Examples
    --------
    >>> import hertzchain as hc
    >>> records_units(hc.Scales(radius=1.0, mass=1.0, velocity=2.0, length=6.0))["peaks"]
    array([[3.],
           [2.]])
    """
    time, length, velocity = scales.time, scales.length, scales.velocity
    momentum, energy = scales.momentum, scales.energy
    return {
        "peaks": np.array([[time], [velocity]]),
        "crossings": np.array([[time], [length], [time], [momentum], [time], [momentum], [energy]]),
        "walls": np.array([[time], [scales.force], [momentum], [time], [time], [1.0], [1.0]]),
        "completion": np.array([[time], [time], [time], [time], [momentum], [1.0]]),
    }


def new_state(chain: Chain, positions: Array, velocities: Array) -> State:
    """A state at time 0 with nothing recorded yet.

    Parameters
    ----------
    chain : Chain
        Any chain.
    positions, velocities : ndarray, shape (N,)
        Of the beads, positions counted from equilibrium [scaled, or m and m/s].

    Returns
    -------
    State

    Examples
    --------
    >>> new_state(Chain.uniform(2), np.zeros(2), np.array([0.0, 1.0])).velocities
    array([0., 1.])
    """
    from hertzchain.kernels import forces, full_chain, records

    beads, equation = chain.beads, equation_of(chain)
    plain = isinstance(equation, forces.Plain)
    arrays = {
        "y": np.concatenate([positions, velocities, np.zeros(0 if plain else forces.LEDGER)]),
        "clock": np.zeros(records.CLOCK_SIZE),
        "counts": np.zeros(records.COUNTS_SIZE, np.int64),
        "mode": np.zeros(beads + 1, np.int64),
        "largest": np.zeros(beads + 1),
        "peaks": np.zeros((2, beads)),
        "crossings": np.zeros((records.CROSSING_ROWS, beads - 1)),
        "walls": np.zeros((records.WALL_ROWS, 2)),
        "completion": np.zeros((records.COMPLETION_ROWS, 2)),
    }
    momenta = chain.masses * velocities
    arrays["crossings"][records.HANDED_OVER] = -np.cumsum(momenta[:0:-1])[::-1]
    # Strikers are the pulse from the start on; the maximum of a driven bead 1 is found.
    struck = max(chain.strikers, int(velocities[0] > 0.0))
    arrays["peaks"][0, 1:struck] = records.FROM_THE_START
    arrays["peaks"][1, :struck] = velocities[:struck]
    first_step = 1e-4 * float(transit_times(chain)[0])
    full_chain.start(
        arrays["y"], arrays["clock"], arrays["counts"], equation,
        contacts_of(arrays, equation), first_step,
    )  # fmt: skip
    # Without bead 1's.
    arrays["counts"][records.PEAKS] = max(struck, 1) - 1
    return State(chain, arrays)


def first_state(chain: Chain) -> State:
    """The state of a chain at time 0, as it is described.

    Parameters
    ----------
    chain : Chain
        Any chain.

    Returns
    -------
    State

    Examples
    --------
    >>> first_state(Chain.uniform(3)).velocities
    array([1., 0., 0.])
    """
    start = start_of(chain)
    return new_state(chain, start[: chain.beads], start[chain.beads :])


def contacts_of(arrays: dict[str, Array], equation: Plain | Bench) -> Contacts | None:
    """The kernel's view of what contacts remember.

    Parameters
    ----------
    arrays : dict of ndarray
        The arrays of a `State`.
    equation : Plain or Bench
        What acts on the beads; implicit steps need more scratch.

    Returns
    -------
    Contacts or None
        None where there is nothing to remember.

    Examples
    --------
    >>> chain = Chain.uniform(2).replace(gravity=0.1)
    >>> contacts_of(first_state(chain).arrays, equation_of(chain)).force.shape
    (3,)
    """
    from hertzchain.kernels.forces import Contacts, Plain
    from hertzchain.kernels.stiff_law import new_implicit

    if isinstance(equation, Plain):
        return None
    number = len(arrays["mode"])
    force, last_force = np.zeros((2, number))
    scratch, powers = np.zeros((3, number)), np.zeros((4, number))
    within = new_implicit(number) if equation.law.implicit else None
    return Contacts(arrays["mode"], arrays["largest"], force, last_force, scratch, powers, within)


def same_motion(chain: Chain, other: Chain) -> bool:
    """Whether two chains move alike: the same equation and the same start.

    Parameters
    ----------
    chain, other : Chain
        Any chains.

    Returns
    -------
    bool

    Examples
    --------
    >>> same_motion(Chain.uniform(3), Chain.from_radii([5, 5, 5]))
    True
    """
    return chain is other or fingerprint(chain) == fingerprint(other)


def fingerprint(chain: Chain) -> str:
    """A hash of all that decides how a chain moves.

    Parameters
    ----------
    chain : Chain
        Any chain.

    Returns
    -------
    str

    Examples
    --------
    >>> fingerprint(Chain.uniform(3)) == fingerprint(Chain.uniform(4))
    False
    """
    digest = hashlib.sha256(start_of(chain).tobytes())
    for part in equation_of(chain):
        digest.update(np.asarray(part).tobytes())
    return digest.hexdigest()
