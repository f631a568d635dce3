"""Tables of forces over time: as files that `load_traces` reads, and as data frames."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from ..chain.bead_names import CAP, bead_number, usual_spelling, wall_number
from ..collision import Array
from ..errors import InputError
from ..pulse.quantities import RUN_QUANTITIES, TIME
from ..validation.objects import check_list
from .trajectory import Trajectory

if TYPE_CHECKING:
    import pandas as pd

# Name of the last body of a free right end, as in `hertzchain.plotting.plot_forces`.
BODY: Final = "body"


def force_dataframe(times: Array, force: Array, units: str) -> pd.DataFrame:
    """Table with the index ``time`` and the column ``force``."""
    import pandas as pd

    table = pd.DataFrame({"force": force}, index=pd.Index(times, name="time"))
    table.attrs["units"] = {
        "time": TIME.unit_in(units),
        "force": RUN_QUANTITIES["force"].unit_in(units),
    }
    return table


def save_forces_of(
    self: Trajectory,
    path: str | os.PathLike[str],
    sensors: Sequence[int | str] | None = None,
) -> None:
    """Save the forces on walls, in sensors and on a free body as CSV, one row per saved time.

    The headers, such as ``time [us],ball 6 [N],wall [N]``, are those of traces, so
    `hertzchain.load_traces` reads the file.  Forces are rounded to less than a millionth of the
    largest one.  The force on a free body, ``body [N]``, and its acceleration, which is this force
    over the mass, are not signals of sensors; name the other columns in ``sensors`` of
    `load_traces`.

    Parameters
    ----------
    path : path-like
        File to write, ``.csv``; an existing file is replaced when the new one is complete.
    sensors : sequence of int or str, optional
        Beads with a sensor and walls, such as ``["ball 6", 8, "wall"]``, as in `sensor`;
        ``"body"`` is the whole force on the last body of a free right end, without the static
        force, and its acceleration.  A sensor in this body has half of the force.  By default, the
        walls, and the body if it is a cap.

    Raises
    ------
    InputError
        If there is no such bead or wall, no wall and no sensor, or no times were saved; for another
        extension, or if the file cannot be written.

    Examples
    --------
    >>> import hertzchain as hc, tempfile
    >>> from pathlib import Path
    >>> chain = hc.Chain.from_materials("10 mm", "steel-52100", beads=9, velocity="0.2 m/s")
    >>> run = hc.simulate(chain.replace(right_wall=hc.Wall()))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "forces.csv"
    ...     run.save_forces(file, [5, "wall"])
    ...     file.read_text().splitlines()[0]
    'time [us],bead 5 [N],wall [N]'
    """
    from ..store.results import write_forces

    if sensors is None:
        ends = ("left wall", "right wall")
        names: list[int | str] = [each for each in ends if each in self.chain.features]
        names += [BODY] * self.chain._free_cap
        if not names:
            raise InputError(
                "the chain has no wall; give sensors, such as ['bead 5'], or add a right_wall"
            )
        sensors = names
    places = check_list("sensors", sensors, "beads or walls such as 'ball 6' or 'wall'")
    if not places:
        raise InputError("sensors must name a bead or a wall, such as 'ball 6' or 'wall', got none")
    self._require_times()
    columns: dict[str, Array] = {}
    for each in places:
        name = _column_name(self, each)
        if name in columns:
            raise InputError(f"sensors name {name!r} twice; keep one")
        columns[name] = force_on_free_body(self) if name == BODY else self.sensor(each)
    acceleration = columns[BODY] / self.chain.masses[-1] if BODY in columns else None
    write_forces(self.times, columns, self.chain.units, path, acceleration)


def force_on_free_body(run: Trajectory) -> Array:
    """Force on the last body of a free right end at the saved times, without the static force."""
    if run.chain.right_wall is not None:
        raise InputError(
            "'body' is the last body of a free right end, but the chain has a right wall; use "
            "'wall'"
        )
    contact = run.chain.beads - 1
    force: Array = run.forces[:, contact] - float(run.chain.static_state.forces[contact])
    return force


def _column_name(run: Trajectory, place: int | str) -> str:
    """Name of a column: ``wall``, ``left wall``, ``ball 6``, ``bead 7``, ``cap`` or ``body``."""
    if isinstance(place, str) and usual_spelling(place) == BODY:
        return BODY
    if (wall := wall_number(run.chain, place)) is not None:
        return "left wall" if wall == 0 else "wall"
    bead = bead_number(run.chain, place, "sensor", walls=True)
    if run.chain.cap is not None and bead == run.chain.beads:
        return CAP
    ball = bead - run.chain.strikers
    return f"ball {ball}" if run.chain.strikers and ball > 0 else f"bead {bead}"
