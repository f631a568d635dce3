"""The recorded motion of a chain: saved times, forces, events and status.

`hertzchain.Run` adds methods that evaluate the motion; modules that implement them accept a
`Trajectory`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from .. import __version__
from ..chain.bead_names import bead_number, wall_number
from ..chain.chain import Chain
from ..chain.contact_groups import dents, loading_overlaps
from ..chain.scales import scale
from ..collision import Array
from ..errors import InputError
from ..frozen import Compared, ShortDir
from ..pulse.quantities import BEAD_QUANTITIES, RUN_QUANTITIES, TIME
from ..representation import counted
from ..validation.keywords import checked_methods
from ..validation.numbers import contact_number
from .budget import overlaps_of
from .end_forces import force_on_end, static_forces_around
from .largest_overlaps import largest_between, still_closed
from .run_end import NATURAL_ENDS, Status
from .run_message import FAILURES, end_message, is_sensitive
from .state import ACCUMULATOR_SCALES, ROW_SCALES, State
from .wall_bound import RIGHT

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


@checked_methods
@dataclass(frozen=True, eq=False)
class Trajectory(Compared, ShortDir):
    """The motion of a chain as recorded by the compiled loop; `hertzchain.Run` has the fields."""

    _omitted = ("evaluations", "prediction")
    chain: Chain
    times: Array = field(metadata=scale("time"))
    positions: Array = field(metadata=scale("length"))
    velocities: Array = field(metadata=scale("velocity"))
    status: Status
    end_time: float = field(metadata=scale("time"))
    energy_drift: float
    momentum_drift: float
    steps: int
    evaluations: int
    rtol: float
    method: str
    state: State
    _forces: Array | None = field(metadata=scale("force"))
    _accumulators: Array = field(metadata=scale(ACCUMULATOR_SCALES, axis=1))
    _peaks: Array = field(metadata=scale(ROW_SCALES["peaks"]))
    _crossings: Array = field(metadata=scale(ROW_SCALES["crossings"]))
    _walls: Array = field(metadata=scale(ROW_SCALES["walls"]))
    _impulses: Array = field(metadata=scale("momentum"))
    _completion: Array = field(metadata=scale(ROW_SCALES["completion"]))
    _approaches: Array = field(metadata=scale(("momentum", "energy", "force", "force", "time")))
    _complete: Array

    @cached_property
    def forces(self) -> Array:
        """Forces in the contacts at the saved times, shape (T, N + 1) [scaled, or N].

        Contact numbers include the walls: contact 0 is the one with the left wall, contact k joins
        beads k and k + 1, and contact N is the one with the right wall.  At an end without a wall,
        the force is zero.
        """
        if self._forces is not None:
            return self._forces
        overlap = np.maximum(self.positions[:, :-1] - self.positions[:, 1:], 0.0)
        return np.pad(self.chain.stiffness * overlap**self.chain.exponents, ((0, 0), (1, 1)))

    @cached_property
    def _reported(self) -> set[str]:
        """Walls whose incomplete peak was reported."""
        return set()

    @cached_property
    def largest_overlaps(self) -> Array:
        """Largest overlap of each contact, shape (N + 1,) [scaled, or m].

        Contact numbers are those of `forces`.  Maxima are located within the steps.  With fixed
        steps, those of waves after the leading pulse are interpolated between the saved times,
        if about four are saved during a contact, or else are the largest at these times.  The value
        of a wall is the overlap :math:`(F/k)^{1/p}` of an elastic contact at its largest force F.

        Examples
        --------
        How far a run exceeds the range of Hertz's law:

        >>> import hertzchain as hc
        >>> chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=20, velocity=0.3)
        >>> print(hc.hertz_range(chain, hc.simulate(chain).largest_overlaps))
        overlap / radius  0.0016 at contact 1 (limit 0.01)
        pressure / yield  0.868 at contact 1 (limit 1)
        speed / sound  5.9e-05 (limit 0.01)
        """
        from ..kernels import state_layout

        peak = np.zeros(self.chain.beads + 1)
        peak[[0, -1]] = self._walls[state_layout.WALL_PEAK]
        walls = loading_overlaps(self.chain.contact_groups, peak)[[0, -1]]
        found = self._crossings[state_layout.LARGEST_OVERLAP]
        passed = np.concatenate((walls[:1], found, walls[1:]))
        overlaps = overlaps_of(self.chain, self.times, self.positions)
        saved = np.max(overlaps, axis=0, initial=0.0)
        if np.isnan(self.rtol):
            saved = largest_between(self.times, overlaps, self.velocities)
        others = self._overlaps_at_end, self.chain.static_state.overlaps
        largest = np.maximum.reduce([passed, saved, *others])
        return np.where(self.chain.contact_stiffness > 0.0, largest, 0.0)

    @property
    def _overlaps_at_end(self) -> Array:
        """Overlaps of all contacts at the end of the run or, if it is not saved, the last step."""
        time, end = self.state.time, self.state.positions
        if len(self.times) and self.times[-1] == self.end_time:
            time, end = self.end_time, self.positions[-1]
        return overlaps_of(self.chain, np.array([time]), end[np.newaxis])[0]

    @property
    def closed_contacts(self) -> Array:
        """Numbers k of the contacts of beads k and k + 1 that still carry a force at the end.

        Contacts with walls are not included.  Without ``until``, a run ends when the pulse has
        left the last bead or the force on the wall is complete.  Beads may then still push each
        other, and their velocities are not final.

        Examples
        --------
        The relative velocity after a collision requires that the contact has opened:

        >>> import hertzchain as hc
        >>> pair = hc.Chain.uniform(2).replace(loss=hc.Restitution(0.5))
        >>> for run in (hc.simulate(pair), hc.simulate(pair, until=10.0)):
        ...     print(run.closed_contacts, round(float(run.velocities[-1] @ [-1.0, 1.0]), 3))
        [1] 0.549
        [] 0.5
        """
        return np.flatnonzero(self._closed[1:-1]) + 1

    @property
    def _closed(self) -> Array:
        """Whether each contact still acts at the end of the run; shape (N + 1,), with both ends."""
        saved = self._forces is not None and len(self.times) and self.times[-1] == self.end_time
        furthest = np.maximum(self.largest_overlaps, self.state.arrays["largest"])
        # A contact with a dent has no force at its residual overlap.
        overlaps = self._overlaps_at_end - dents(self.chain.contact_groups, furthest)
        return still_closed(overlaps, self.largest_overlaps, self.forces[-1] if saved else None)

    @property
    def _unfinished(self) -> str:
        """That contacts still act after a run without ``until``; empty if none, or if all do."""
        return self._still_closed if self.status in NATURAL_ENDS else ""

    @property
    def _still_closed(self) -> str:
        """That contacts still act at the end; empty if none, or if static forces close them."""
        closed = 0 if self.chain.static_state.forces.any() else len(self.closed_contacts)
        words = f"{counted(closed, 'contact')} still closed, so velocities are not final"
        return words if closed else ""

    @property
    def success(self) -> bool:
        """Whether the run reached its requested end."""
        return self.status not in FAILURES

    @property
    def message(self) -> str:
        """The status in a sentence."""
        return end_message(
            self.chain, self.status, self.end_time, self.steps, self.beads_passed,
            sensitive=is_sensitive(self.chain, self._walls, RIGHT),
        )  # fmt: skip

    @property
    def beads_passed(self) -> int:
        """Number of beads that the pulse has passed, without strikers."""
        # A bead is passed if its velocity peak and the contact behind it are recorded.  That of a
        # struck bead 1, at time 0, has a velocity from the start.
        found = int(self._peaks[1, 0] != 0.0)
        found += int(np.count_nonzero((self._peaks[0, 1:] != 0) & (self._crossings[0] > 0)))
        return max(0, found - self.chain.strikers)

    @property
    def _reached(self) -> bool:
        """Whether any contact between two beads was compressed, by the motion or at rest."""
        return bool(np.any(self.largest_overlaps[1:-1] > 0.0))

    def _require_times(self) -> None:
        if not len(self.times):
            raise InputError("the run has no saved times; give simulate times of at least 2")

    def force(self, contact: int) -> Array:
        """Force in one contact at the saved times.

        Parameters
        ----------
        contact : int
            Number of the contact, as in `forces`: 0 is the contact with the left wall, N the one
            with the right wall.

        Returns
        -------
        ndarray, shape (T,)
            [scaled, or N]

        Raises
        ------
        InputError
            If there is no such contact, or if it belongs to a free end.

        Examples
        --------
        >>> import hertzchain as hc
        >>> run = hc.simulate(hc.Chain.uniform(30), until=20.0)
        >>> bool(0.63 < run.force(10).max() < 0.65)
        True
        """
        return self.forces[:, self._joined(contact, "force")]

    def overlap(self, contact: int) -> Array:
        """Overlap of one contact at the saved times; negative where the bodies are apart.

        Parameters
        ----------
        contact : int
            Number of the contact, as in `force`.

        Returns
        -------
        ndarray, shape (T,)
            Overlap, static overlaps included [scaled, or m].

        Raises
        ------
        InputError
            If there is no such contact, or if it belongs to a free end.

        Examples
        --------
        >>> import hertzchain as hc
        >>> run = hc.simulate(hc.Chain.uniform(30), until=20.0)
        >>> bool(0.73 < run.overlap(10).max() < 0.75)
        True
        """
        k = self._joined(contact, "overlap")
        return overlaps_of(self.chain, self.times, self.positions)[:, k]

    def _joined(self, contact: int, what: str) -> int:
        """Number of a contact that is not at a free end."""
        k = contact_number(contact, self.chain.beads)
        if self.chain.contact_stiffness[k] == 0.0:
            side = "left" if k == 0 else "right"
            raise InputError(
                f"contact {k} has no {what}: the {side} end of this chain is free; give a contact "
                f"from 1 to {self.chain.beads - 1}, or add a {side}_wall"
            )
        return k

    def position(self, bead: int | str) -> Array:
        """Displacement of one bead, as in `positions`, shape (T,) [scaled, or m].

        Parameters
        ----------
        bead : int or str
            Number or name of the bead, as in `sensor`.

        Examples
        --------
        >>> import hertzchain as hc
        >>> run = hc.simulate(hc.Chain.uniform(5), until=1.0)
        >>> bool((run.position(1) - run.position(2) == run.overlap(1)).all())
        True
        """
        return self.positions[:, bead_number(self.chain, bead) - 1]

    def velocity(self, bead: int | str) -> Array:
        """Velocity of one bead at the saved times.

        Parameters
        ----------
        bead : int or str
            Number or name of the bead, as in `sensor`.

        Returns
        -------
        ndarray, shape (T,)
            [scaled, or m/s]

        Raises
        ------
        InputError
            If there is no such bead.

        Examples
        --------
        >>> import hertzchain as hc
        >>> float(hc.simulate(hc.Chain.uniform(5), until=1.0).velocity(1)[0])
        1.0
        """
        return self.velocities[:, bead_number(self.chain, bead) - 1]

    def sensor(self, bead: int | str) -> Array:
        r"""Signal of a force sensor embedded in a bead: :math:`(F_{k-1} + F_k)/2`.

        The usual sensor, a thin piezoelectric disc between two halves of a bead, carries the mean
        of the forces on both.  At ends, these include that of a drive or of precompression.

        Parameters
        ----------
        bead : int or str
            Number k of the bead, from 1, strikers included; or a name as in traces: ``"ball 11"``,
            counted without the strikers, is bead 12 of a chain with one striker.  ``"wall"``, or
            ``"left wall"`` and ``"right wall"`` if there are two, is the force on a wall.

        Returns
        -------
        ndarray, shape (T,)
            [scaled, or N]

        Raises
        ------
        InputError
            If there is no such bead or wall.

        Examples
        --------
        >>> import hertzchain as hc
        >>> run = hc.simulate(hc.Chain.uniform(30), until=20.0)
        >>> bool(run.sensor(10).max() < run.force(10).max())
        True

        >>> run = hc.simulate(hc.Chain.uniform(9).struck_by(), until=5.0)
        >>> bool((run.sensor("ball 6") == run.sensor(7)).all())
        True
        """
        if (wall := wall_number(self.chain, bead)) is not None:
            return self.forces[:, 0 if wall == 0 else -1]
        k = bead_number(self.chain, bead, walls=True)
        outside = (force_on_end(self.chain, contact, self.times) for contact in (k - 1, k))
        held = static_forces_around(self.chain, k)
        return 0.5 * (held + sum(outside, self.forces[:, k - 1] + self.forces[:, k]))

    def to_xarray(self) -> xr.Dataset:
        """Labelled dataset with coordinates ``time``, ``bead`` = 1..N and ``contact`` = 0..N.

        Returns
        -------
        xarray.Dataset
            ``position`` and ``velocity``, both (time, bead), ``force`` (time, contact),
            ``radius`` and ``mass``, with their units (if not scaled).  The attribute ``rate`` is
            that of a taper; other chains have none.

        Examples
        --------
        >>> import hertzchain as hc
        >>> run = hc.simulate(hc.Chain.uniform(9), until=2.0, times=5)
        >>> dict(run.to_xarray().sizes)
        {'time': 5, 'bead': 9, 'contact': 10}
        """
        import xarray as xr

        chain, units = self.chain, self.chain.units
        saved = {"position": self.positions, "velocity": self.velocities, "force": self.forces}
        variables: dict[str, tuple[object, ...]] = {
            name: (("time", quantity.per), saved[name], quantity.attributes(units))
            for name, quantity in RUN_QUANTITIES.items()
        }
        for name, values in (("radius", chain.radii), ("mass", chain.masses)):
            variables[name] = ("bead", values, BEAD_QUANTITIES[name].attributes(units))
        return xr.Dataset(
            variables,
            coords={
                "time": ("time", self.times, TIME.attributes(units)),
                "bead": np.arange(1, chain.beads + 1),
                "contact": np.arange(chain.beads + 1),
            },
            attrs={
                "hertzchain_version": __version__,
                "chain": chain.description,
                "taper": chain.taper or "",
                **({} if chain.rate is None else {"rate": chain.rate}),
                "exponent": chain.exponents,
                "status": self.status,
                "energy_drift": self.energy_drift,
                "momentum_drift": self.momentum_drift,
                "rtol": self.rtol,
            },
        )

    def to_dataframe(self) -> pd.DataFrame:
        """Table with one row per saved time and bead.

        Returns
        -------
        pandas.DataFrame
            Indexed by ``time`` and ``bead`` = 1..N; columns ``position``, ``velocity`` and
            ``force``, that of contact k in the row of bead k (``run.force(0)`` is the left
            wall's).  ``attrs["units"]`` has their units ("1": scaled).

        Examples
        --------
        >>> import hertzchain as hc
        >>> table = hc.simulate(hc.Chain.uniform(9), until=2.0, times=5).to_dataframe()
        >>> float(table.velocity.loc[0.0, 1]), len(table), table.attrs["units"]["time"]
        (1.0, 45, '1')
        """
        import pandas as pd

        columns = {
            "position": self.positions.ravel(),
            "velocity": self.velocities.ravel(),
            "force": self.forces[:, 1:].ravel(),
        }
        beads = np.arange(1, self.chain.beads + 1)
        index = pd.MultiIndex.from_product([self.times, beads], names=["time", "bead"])
        table = pd.DataFrame(columns, index=index)
        quantities = {"time": TIME, **RUN_QUANTITIES}
        table.attrs["units"] = {
            name: quantities[name].unit_in(self.chain.units) for name in ("time", *columns)
        }
        return table
