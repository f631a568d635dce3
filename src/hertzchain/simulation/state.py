"""The state of a run between two steps: everything that is needed to continue the run."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from ..chain.chain import Chain
from ..chain.contact_groups import dents
from ..chain.scales import Scale, scale
from ..collision import Array
from ..errors import InputError
from ..frozen import Compared
from ..representation import measure, short
from ..validation.keywords import checked_methods
from .kernel_input import initial_state, kernel_chain
from .time_scales import transit_times

if TYPE_CHECKING:
    from ..kernels.forces import Contacts, DefaultChain, GeneralChain


# Units of the entries of `clock` and of the rows of records, in the order of `state_layout`.
ROW_SCALES: Final[Mapping[str, tuple[str, ...]]] = {
    "clock": (
        "time", "time", "time", "velocity", "energy", "momentum", "energy", "momentum", "energy",
        "momentum", "velocity", "time",
    ),
    "flights": ("length", "time"),
    "peaks": ("time", "velocity"),
    "crossings": (
        "time", "length", "time", "momentum", "time", "momentum", "energy", "length",
    ),
    "walls": ("time", "force", "momentum", "time", "time", "1", "1", "time", "momentum"),
    "completion": ("time", "time", "time", "time", "time", "momentum", "1"),
}  # fmt: skip
LAST_STEP: Final = (
    "this is the last whole step before the end of the run; the last saved values are "
    "run.velocities[-1], at run.times[-1]"
)
# Units of the accumulators, which are integrated along with the motion.
ACCUMULATOR_SCALES: Final = ("energy", "energy", "momentum", "momentum", "momentum")


def _array_scales(state: State) -> Mapping[str, Scale]:
    """Units of the arrays of a state."""
    beads = state.chain.beads
    motion = ("length",) * beads + ("velocity",) * beads + ACCUMULATOR_SCALES
    return {"y": motion[: len(state.arrays["y"])], "largest": "length", **ROW_SCALES}


@checked_methods
@dataclass(frozen=True, eq=False)
class State(Compared):
    """The complete state of a run, such as ``run.state``.

    With ``start=``, `hertzchain.simulate` continues from it.  The result is equal, bit for bit, to
    that of an uninterrupted run.

    Attributes
    ----------
    chain : Chain
        The chain.
    time : float
        Time of the state [scaled, or s]: the end of the last whole step.  A run until a given time
        ends within the next step, with the velocities ``run.velocities[-1]`` at ``run.times[-1]``.
    positions, velocities : ndarray, shape (N,)
        Positions and velocities of the beads [scaled, or m and m/s].
    arrays : dict of ndarray
        Arrays of the compiled loop.

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
    arrays: dict[str, Array] = field(metadata=scale(_array_scales))

    @property
    def time(self) -> float:
        """Time of the state [scaled, or s]."""
        from ..kernels import state_layout

        return float(self.arrays["clock"][state_layout.TIME])

    @property
    def positions(self) -> Array:
        """Displacements of the beads, shape (N,) [scaled, or m]."""
        return self.arrays["y"][: self.chain.beads] + self.chain.static_state.positions

    @property
    def velocities(self) -> Array:
        """Velocities of the beads, shape (N,) [scaled, or m/s]."""
        return self.arrays["y"][self.chain.beads : 2 * self.chain.beads].copy()

    @property
    def start(self) -> tuple[float, float]:
        """Energy, stored energy included, and momentum at the start of the run."""
        from ..kernels import state_layout

        clock = self.arrays["clock"]
        return float(clock[state_layout.INITIAL_ENERGY]), float(
            clock[state_layout.INITIAL_MOMENTUM]
        )

    def __repr__(self) -> str:
        from ..kernels import state_layout

        steps = int(self.arrays["counts"][state_layout.STEPS])
        fastest = measure(float(np.abs(self.velocities).max()), "m/s", self.chain.units)
        time = measure(self.time, "s", self.chain.units)
        return short(
            "State",
            f"{self.chain.description}, at t = {time}, after {steps} steps",
            f"fastest bead {fastest}",
            *([LAST_STEP] if steps else []),
        )

    def copy(self) -> State:
        """Copy the state to separate arrays.

        Examples
        --------
        >>> import hertzchain as hc
        >>> state = hc.simulate(hc.Chain.uniform(5), until=1.0).state
        >>> state.copy().time == state.time
        True
        """
        return replace(self, arrays={name: value.copy() for name, value in self.arrays.items()})

    def reversed(self) -> State:
        """Reverse all velocities, at time 0.

        A lossless chain that continues from the result returns to its initial state.

        Raises
        ------
        InputError
            If the chain has losses or a drive, whose motion cannot be reversed in time.

        Examples
        --------
        >>> import hertzchain as hc
        >>> chain = hc.Chain.uniform(10)
        >>> state = hc.simulate(chain, until=8.0).state
        >>> back = hc.simulate(chain, start=state.reversed(), times=[state.time])
        >>> bool(abs(back.velocities[0, 0] + 1.0) < 1e-10)
        True
        """
        present = {"losses": not self.chain.lossless, "a drive": self.chain.drive is not None}
        for name, irreversible in present.items():
            if irreversible:
                raise InputError(
                    f"a run of a chain with {name} cannot be reversed: use a chain without {name}"
                )
        return new_state(self.chain, self.arrays["y"][: self.chain.beads], -self.velocities)

    def struck_again(self) -> State:
        """The same impact again: beads that touch at their dents, at time 0.

        The beads have the initial velocities of the chain, and every contact keeps the largest
        overlap of the run.  A dented contact closes at its dent and follows the steeper curve of
        unloading until its force exceeds that of the run; beyond, it yields further.  Beads touch
        each other and the right wall, except for the gaps of the chain.

        Raises
        ------
        InputError
            If the chain has static forces, in which dented contacts have another equilibrium, or a
            drive.

        Examples
        --------
        A second impact of two balls at the same speed loses less energy, because most of the work
        of yielding has been done:

        >>> import hertzchain as hc
        >>> pair = hc.Chain.from_materials("5 mm", "steel-52100", beads=2, velocity="2 m/s")
        >>> first = hc.simulate(pair.replace(loss=hc.ElasticPlastic()), until="1 ms")
        >>> second = hc.simulate(first.chain, start=first.state.struck_again(), until="1 ms")
        >>> for run in (first, second):
        ...     rebound = run.velocities[-1] @ [-1.0, 1.0] / 2.0
        ...     print(f"restitution {rebound:.3f}, dent {1e6 * run.dents[1]:.2f} um")
        restitution 0.786, dent 5.70 um
        restitution 0.891, dent 7.58 um
        """
        chain = self.chain
        if chain.drive is not None:
            raise InputError(
                "a chain with a drive cannot be struck again with its dents: use a chain without a "
                "drive, or simulate both impacts in one run"
            )
        if chain.static_state.forces.any():
            raise InputError(
                "a chain with static forces cannot be struck again with its dents: omit gravity "
                "and precompression if they are small compared with the peak, or simulate until a "
                "striker has fallen back onto the chain"
            )
        from ..kernels.contact_law import RELEASED

        # That of a contact that is still loaded is recorded when it unloads.
        closing = -np.diff(np.pad(self.arrays["y"][: chain.beads], 1)) - chain.static_state.gaps
        largest = np.maximum(self.arrays["largest"], closing)
        dented = dents(chain.contact_groups, largest)
        fresh = first_state(chain)
        # The last bead touches the right wall at its dent, and each bead the next one.
        fresh.arrays["y"][: chain.beads] = np.cumsum(dented[:0:-1])[::-1]
        closed = dented > 0.0
        fresh.arrays["largest"][closed] = largest[closed]
        fresh.arrays["mode"][closed] = RELEASED
        return fresh

    def _repr_html_(self) -> str:
        from ..notebook.waves import state_html

        return state_html(self)


def new_state(chain: Chain, positions: Array, velocities: Array) -> State:
    """A state at time 0 without records."""
    from ..kernels import forces, full_chain, state_layout

    beads, equation = chain.beads, kernel_chain(chain)
    is_default = isinstance(equation, forces.DefaultChain)
    arrays = {
        "y": np.concatenate(
            [positions, velocities, np.zeros(0 if is_default else forces.ACCUMULATORS)]
        ),
        "clock": np.zeros(state_layout.CLOCK_SIZE),
        "counts": np.zeros(state_layout.COUNTS_SIZE, np.int64),
        "mode": np.zeros(beads + 1, np.int64),
        "largest": np.zeros(beads + 1),
        "flights": np.zeros((state_layout.FLIGHT_ROWS, beads)),
        "peaks": np.zeros((2, beads)),
        "crossings": np.zeros((state_layout.CROSSING_ROWS, beads - 1)),
        "walls": np.zeros((state_layout.WALL_ROWS, 2)),
        "completion": np.zeros((state_layout.COMPLETION_ROWS, 2)),
    }
    momenta = chain.masses * velocities
    arrays["crossings"][state_layout.HANDED_OVER] = -np.cumsum(momenta[:0:-1])[::-1]
    # Strikers have their largest velocity at the start; that of a driven bead 1 is located later.
    struck = max(chain.strikers, int(velocities[0] > 0.0))
    arrays["peaks"][0, 1:struck] = state_layout.STRIKER_PEAK_TIME
    arrays["peaks"][1, :struck] = velocities[:struck]
    first_step = 1e-4 * float(transit_times(chain)[0])
    full_chain.start(
        arrays["y"], arrays["clock"], arrays["counts"], equation,
        contacts_of(arrays, equation), first_step,
    )  # fmt: skip
    # The kernel counts velocity maxima from bead 2 on.
    arrays["counts"][state_layout.PEAKS] = max(struck, 1) - 1
    return State(chain, arrays)


def first_state(chain: Chain) -> State:
    """The state of a chain at time 0."""
    start = initial_state(chain)
    return new_state(chain, start[: chain.beads], start[chain.beads :])


def contacts_of(arrays: dict[str, Array], equation: DefaultChain | GeneralChain) -> Contacts | None:
    """Modes and history of the contacts, as arrays of the kernel."""
    from ..kernels.forces import Contacts, DefaultChain
    from ..kernels.stiff_law import new_implicit

    if isinstance(equation, DefaultChain):
        return None
    number = len(arrays["mode"])
    force, last_force = np.zeros((2, number))
    scratch, powers = np.zeros((3, number)), np.zeros((4, number))
    within = new_implicit(number) if equation.law.implicit else None
    positions = True if depends_on_positions(equation) else None
    return Contacts(
        arrays["mode"], arrays["largest"], force, last_force, scratch, powers, within,
        positions,
    )  # fmt: skip


def depends_on_positions(equation: GeneralChain) -> bool:
    """Whether the forces on a chain depend on positions and time only."""
    from ..kernels.contact_law import KIND
    from ..kernels.law_kinds import ELASTIC

    return bool(np.all(equation.laws[:, KIND] == ELASTIC))


def same_motion(chain: Chain, other: Chain) -> bool:
    """Whether two chains have the same equation of motion and the same initial state."""
    return chain is other or fingerprint(chain) == fingerprint(other)


def fingerprint(chain: Chain) -> str:
    """A hash of the equation of motion and the initial state."""
    digest = hashlib.sha256(initial_state(chain).tobytes())
    for part in kernel_chain(chain):
        digest.update(np.asarray(part).tobytes())
    return digest.hexdigest()
