r"""Energy and momentum of a run over time, by location and by origin.

At every time the kinetic energy and the momentum of the beads have three parts:

leading pulse
    beads that move towards bead N, with the weights of `hertzchain.simulation.leading_pulse`: a
    bead leaves the pulse four rise times after the crest has passed it;
lagging
    all other beads that move towards bead N;
scattered back
    beads that move away from bead N.

In strong forward tapers (q > 0.05) the crest and the tail of the pulse are not separated, and the
end of the leading pulse is a convention.

Energy is also stored in contacts and walls, and lost in them; momentum is transferred to walls.
In addition to the impact, gravity, a drive and forces that hold the ends supply work and impulse.
Losses, the work of the drive and the impulses of the walls are integrated along with the motion;
all other parts follow from the saved states.

Precompression and gravity store energy in the contacts before the impact.  The excess energy does
not include it: for a contact with the static overlap :math:`d_0` and force :math:`F_0`, it is

.. math:: U(d) - U(d_0) - F_0\,(d - d_0) ,

which is never negative for an elastic contact.  The last term is the work of the constant forces
that balance the static contact forces: weights, and the forces that hold the ends.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..errors import InputError, short_repr, unknown_name_error
from ..frozen import Compared
from ..pulse.quantities import QUANTITIES
from ..representation import measure, short
from ..validation.keywords import checked_methods
from ..validation.objects import check_choice
from .kernel_input import steps_are_implicit

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

    from .horizon import Horizon

Balanced = Literal["energy", "momentum"]
BALANCED: Final[tuple[Balanced, ...]] = ("energy", "momentum")
# Colour of each location in all figures, from those of Okabe and Ito.
COLOURS: Final = {
    "leading pulse": "#0072b2", "lagging": "#56b4e9", "scattered back": "#e69f00",
    "contacts": "#b8b8b8", "walls": "#cc79a7", "left wall": "#e3b5cf", "right wall": "#cc79a7",
    "lost": "#d55e00",
}  # fmt: skip
MOVING: Final = ("leading pulse", "lagging", "scattered back")
# Parts of the largest amount in motion below which an amount is a rounding error, shown as 0.
ROUNDING: Final = 1e-12
# Relative difference of two energies that is a rounding error.
SAME: Final = 1e-14


class Parts(dict[str, Array]):
    """Amounts by location or by origin."""

    def __missing__(self, name: str) -> Array:
        error = unknown_name_error("part of a budget", name, self)
        if "kinetic" in short_repr(name):
            raise InputError(f"{error}; the kinetic energy of all beads is Budget.kinetic_energy")
        raise error


@checked_methods
@dataclass(frozen=True, eq=False)
class Budget(Compared):
    """Energy and momentum at the saved times of a run; see `hertzchain.simulation.budget`.

    Names that the dictionaries do not contain raise an error that lists those that they contain.

    Attributes
    ----------
    chain : Chain
        The chain.
    times : ndarray, shape (T,)
        Saved times [scaled, or s].
    energy : dict of ndarray, shape (T,)
        Energy by location: three parts of the kinetic energy of the beads, ``"leading pulse"``,
        ``"lagging"`` and ``"scattered back"``; the energy stored in ``"contacts"`` and in
        ``"walls"`` (in their contacts); and ``"lost"`` [scaled, or J].
    momentum : dict of ndarray, shape (T,)
        Momentum by location: the same three parts, ``"left wall"`` and ``"right wall"``
        [scaled, or N s].
    energy_given, momentum_given : dict of ndarray, shape (T,)
        Energy and momentum by origin: ``"start"``, ``"gravity"``, ``"drive"``, ``"held ends"``.
    excess : bool
        Whether the energies are those over the static state; see `over_static`.

    Examples
    --------
    >>> import hertzchain as hc
    >>> chain = hc.Chain.uniform(30).replace(right_wall=hc.Wall())
    >>> budget = hc.simulate(chain, until=60.0).budget()
    >>> round(float(budget.momentum["right wall"][-1]), 2)
    2.37
    """

    chain: Chain
    times: Array
    energy: dict[str, Array]
    momentum: dict[str, Array]
    energy_given: dict[str, Array]
    momentum_given: dict[str, Array]
    excess: bool = False
    # Energy by location and by origin that belongs to the static state.
    _static: tuple[dict[str, Array], dict[str, Array]] = field(default=({}, {}), repr=False)

    @property
    def kinetic_energy(self) -> Array:
        """Kinetic energy of all beads at the saved times, shape (T,) [scaled, or J].

        Examples
        --------
        In a solitary wave, 5/9 of the energy is kinetic on average, by the virial theorem:

        >>> import hertzchain as hc
        >>> budget = hc.simulate(hc.Chain.uniform(60), until=40.0).budget()
        >>> late = budget.times > 20.0
        >>> f"{budget.kinetic_energy[late].mean() / 0.5:.2f}"
        '0.56'
        """
        total: Array = np.sum([self.energy[name] for name in MOVING], axis=0)
        return total

    def over_static(self) -> Budget:
        """The budget with the excess energies over the static state.

        They do not include the energy that precompression or gravity stores in the contacts
        before the impact; see `hertzchain.simulation.budget`.

        Examples
        --------
        An impact of energy 1/2 on a chain that stores 7.6 before it:

        >>> import hertzchain as hc
        >>> chain = hc.Chain.uniform(20).replace(precompression=1.0, held_by="force")
        >>> budget = hc.simulate(chain, until=10.0).budget()
        >>> [round(float(each.energy_given["start"][0]), 6)
        ...  for each in (budget, budget.over_static())]
        [8.1, 0.5]
        """
        there, given = self._static
        return replace(
            self,
            energy=_without(self.energy, there),
            energy_given=_without(self.energy_given, given),
            excess=True,
            _static=({}, {}),
        )

    def residual(self, of: Balanced = "energy") -> Array:
        """Sum over locations minus sum over origins, relative to the largest amount in motion.

        Parameters
        ----------
        of : str
            ``"energy"`` or ``"momentum"``.

        Returns
        -------
        ndarray, shape (T,)
            Zero except for integration errors.

        Raises
        ------
        InputError
            For any other quantity.

        Examples
        --------
        >>> import hertzchain as hc
        >>> budget = hc.simulate(hc.Chain.uniform(9)).budget()
        >>> bool(abs(budget.residual("momentum")).max() < 1e-12)
        True
        """
        there, given = self._sides(of)
        difference: Array = np.sum([*there.values()], axis=0) - np.sum([*given.values()], axis=0)
        return difference / self._largest_in_motion(of)

    def _name(self, of: str) -> str:
        return "excess energy" if self.excess and of == "energy" else of

    def _largest_in_motion(self, of: str) -> float:
        there, _ = self._sides(of)
        moving = np.sum([np.abs(there[name]) for name in MOVING], axis=0)
        return max(float(moving.max()), np.finfo(float).tiny)

    def _sides(self, of: str) -> tuple[dict[str, Array], dict[str, Array]]:
        check_choice("balance", of, BALANCED)
        if of == "energy":
            return self.energy, self.energy_given
        return self.momentum, self.momentum_given

    def _shown(self, of: str) -> tuple[dict[str, float], dict[str, float], float]:
        """Last amounts by location and by origin, and their sum; 0 for rounding errors.

        Amounts that are 0 at all times are omitted.
        """
        least = ROUNDING * self._largest_in_motion(of)
        there, given = (
            {
                name: float(values[-1]) if abs(values[-1]) > least else 0.0
                for name, values in side.items()
                if np.any(np.abs(values) > least)
            }
            for side in self._sides(of)
        )
        return there, given, sum(given.values())

    def to_dataframe(self, of: Balanced = "energy") -> pd.DataFrame:
        """Convert to a table with one row per saved time and one column per part.

        Parameters
        ----------
        of : str
            ``"energy"`` or ``"momentum"``.

        Returns
        -------
        pandas.DataFrame
            Columns ``("location", ...)`` and ``("origin", ...)``.

        Raises
        ------
        InputError
            For any other quantity.

        Examples
        --------
        >>> import hertzchain as hc
        >>> table = hc.simulate(hc.Chain.uniform(9)).budget().to_dataframe()
        >>> round(float(table["origin", "start"].iloc[-1]), 12)
        0.5
        """
        import pandas as pd

        there, given = self._sides(of)
        columns = {("location", name): values for name, values in there.items()}
        columns |= {("origin", name): values for name, values in given.items()}
        return pd.DataFrame(columns, index=pd.Index(self.times, name="time"))

    def plot(
        self,
        of: Balanced = "energy",
        *,
        horizon: Horizon | None = None,
        legend: bool = True,
        ax: Axes | None = None,
    ) -> Axes:
        """Plot the parts over time, stacked.

        Parameters
        ----------
        of : str
            ``"energy"`` or ``"momentum"``.
        horizon : Horizon, optional
            Result of `Run.horizon`; times beyond it are shaded.
        legend : bool
            Whether there is a legend.
        ax : matplotlib.axes.Axes, optional
            Axes to draw into; those of a new figure if not given.

        Raises
        ------
        InputError
            For any other quantity.

        Examples
        --------
        >>> import hertzchain as hc
        >>> axes = hc.simulate(hc.Chain.uniform(9)).budget().plot()
        >>> axes.get_xlabel()
        'time $t$'
        """
        from ..plotting.budget import plot_budget

        return plot_budget(self, of, horizon=horizon, legend=legend, ax=ax)

    def __repr__(self) -> str:
        units, facts = self.chain.units, []
        for of in BALANCED:
            there, _, total = self._shown(of)
            parts = [
                f"{name} {amount / total:z.1%}" if total else f"{name} {amount:.4g}"
                for name, amount in there.items()
                if amount != 0.0
            ]
            amount = f"{self._name(of)} {measure(total, QUANTITIES[of].unit, units)}"
            facts.append(f"{amount}, of which {', '.join(parts)}")
        worst = max(float(np.abs(self.residual(of)).max()) for of in BALANCED)
        at = f"{self.chain.description}, at t = {measure(self.times[-1], 's', units)}"
        return short("Budget", at, *facts, f"adds up within {worst:.0e}")

    def __str__(self) -> str:
        real = self.chain.units == "SI"
        at = measure(self.times[-1], "s", self.chain.units, digits=6)
        lines = [f"{self.chain.description}, at the last saved time {at}"]
        for of in BALANCED:
            there, given, total = self._shown(of)
            heading = self._name(of) + (f" [{QUANTITIES[of].unit}]" if real else "")
            lines.append(f"  {heading:<32}{'part':>9}")
            for name, amount in {**there, **{f"from {k}": v for k, v in given.items()}}.items():
                part = f"  {amount / total:>z9.2%}" if total != 0.0 else ""
                lines.append(f"    {name:<14}{amount:>14.6g}{part}")
            worst = float(np.abs(self.residual(of)).max())
            lines.append(f"    adds up within {worst:.1e}")
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        from ..notebook.runs import budget_html

        return budget_html(self)


def budget_of(
    chain: Chain,
    times: Array,
    positions: Array,
    velocities: Array,
    forces: Array,
    accumulators: Array,
    weights: Array,
    start: tuple[float, float],
) -> Budget:
    """Compute the budget of saved states."""
    lost, worked, pushed, from_left, to_right = accumulators.T
    momenta = chain.masses * velocities
    kinetic = 0.5 * momenta * velocities
    overlaps = overlaps_of(chain, times, positions)
    stored = stored_energy(chain, overlaps, forces)
    forwards = velocities > 0.0
    parts = {
        "leading pulse": weights,
        "lagging": forwards - weights,
        "scattered back": ~forwards,
    }

    moved = positions - chain.static_state.positions
    weight = chain.masses * chain.gravity
    held = chain.static_state.body_forces - weight
    return Budget(
        chain=chain,
        times=times,
        energy=Parts(
            {name: np.sum(kinetic * part, axis=1) for name, part in parts.items()}
            | _by_location(stored)
            | {"lost": lost}
        ),
        momentum=Parts(
            {name: np.sum(momenta * part, axis=1) for name, part in parts.items()}
            | {"left wall": -from_left, "right wall": to_right}
        ),
        energy_given=Parts(
            {
                "start": np.full(len(times), start[0]),
                "gravity": moved @ weight,
                "drive": worked,
                "held ends": moved @ held,
            }
        ),
        momentum_given=Parts(
            {
                "start": np.full(len(times), start[1]),
                "gravity": times * weight.sum(),
                "drive": pushed,
                "held ends": times * held.sum(),
            }
        ),
        _static=_static_part(chain, overlaps, moved),
    )


def _without(energy: dict[str, Array], static: dict[str, Array]) -> Parts:
    """Energies without their static parts; 0 where the difference is a rounding error."""
    found = Parts({name: values - static.get(name, 0.0) for name, values in energy.items()})
    for name in static:
        found[name][np.abs(found[name]) < SAME * np.abs(energy[name])] = 0.0
    return found


def _by_location(stored: Array) -> dict[str, Array]:
    return {"contacts": stored[:, 1:-1].sum(axis=1), "walls": stored[:, 0] + stored[:, -1]}


def _static_part(
    chain: Chain, overlaps: Array, moved: Array
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Energy of contacts at rest with the work of static forces, and the energy given for both."""
    state = chain.static_state
    # Constant forces on free ends are not those of contacts.
    forces = np.where(chain.contact_stiffness > 0.0, state.forces, 0.0)
    at_rest = stored_energy(chain, state.overlaps[None], forces[None])
    pressed = forces > 0.0
    work = np.zeros_like(overlaps)
    work[:, pressed] = forces[pressed] * (overlaps - state.overlaps)[:, pressed]
    # Strikers fall freely.
    supported = pressed[:-1] | pressed[1:]
    weight = chain.masses * chain.gravity * supported
    held = state.body_forces * supported - weight
    given = {"start": at_rest.sum(), "gravity": moved @ weight, "held ends": moved @ held}
    if chain.drive is not None:
        # The static force on a driven wall also does work.
        given["drive"] = work.sum(axis=1) - given["gravity"] - given["held ends"]
    return _by_location(at_rest + work), given


def stored_energy(
    chain: Chain, overlaps: Array, forces: Array, *, may_close: bool = False
) -> Array:
    """Energy that each contact can return, by its law, from arrays of shape (T, N + 1).

    A contact whose force is cut off returns none before it opens, unless it is compressed again,
    which ``may_close`` assumes.
    """
    stored = np.zeros_like(overlaps)
    for group in chain.contact_groups:
        overlap, force, contacts = overlaps[:, group.index], forces[:, group.index], group.contacts
        cut_off = not group.law.row(contacts.exponent).attractive
        if cut_off and not may_close and not steps_are_implicit(chain):
            overlap = np.where(force > 0.0, overlap, 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            energy = group.law.stored_energy(overlap, force, contacts)
        stored[:, group.index] = np.where(contacts.stiffness > 0.0, energy, 0.0)
    return stored


def overlaps_of(chain: Chain, times: Array, positions: Array) -> Array:
    """Overlaps of all contacts; negative where the bodies are apart."""
    bounds = np.zeros((len(times), chain.beads + 2))
    bounds[:, 1:-1] = positions
    if chain.drive is not None and chain.drive.of == "displacement":
        bounds[:, 0] = chain.drive.value(times)
    return np.asarray(bounds[:, :-1] - bounds[:, 1:] - chain.static_state.gaps)
