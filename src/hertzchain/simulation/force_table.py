"""Tables of forces over time: as files that `load_traces` reads, and as data frames."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..chain.bead_names import bead_number, wall_number
from ..collision import Array
from ..errors import InputError
from ..pulse.quantities import RUN_QUANTITIES, TIME
from ..validation.objects import check_list
from .trajectory import Trajectory

if TYPE_CHECKING:
    import pandas as pd


def force_dataframe(times: Array, force: Array, units: str) -> pd.DataFrame:
    """Table with the index ``time`` and the column ``force``."""
    import pandas as pd

    table = pd.DataFrame({"force": force}, index=pd.Index(times, name="time"))
    table.attrs["units"] = {
        "time": TIME.attributes(units)["units"],
        "force": RUN_QUANTITIES["force"].attributes(units)["units"],
    }
    return table


def save_forces_of(
    self: Trajectory,
    path: str | os.PathLike[str],
    sensors: Sequence[int | str] | None = None,
) -> None:
    """Save the forces on walls and in sensors as CSV, one row per saved time.

    The headers, such as ``time [us],ball 6 [N],wall [N]``, are those of traces, so
    `hertzchain.load_traces` reads the file.  Forces are rounded to less than a millionth of the
    largest one.

    Parameters
    ----------
    path : path-like
        File to write, ``.csv``; an existing file is replaced when the new one is complete.
    sensors : sequence of int or str, optional
        Beads with a sensor and walls, such as ``["ball 6", 8, "wall"]``, as in `sensor`; by
        default, the walls.

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
        names = [each for each in ("left wall", "right wall") if each in self.chain.features]
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
        columns[name] = self.sensor(each)
    write_forces(self.times, columns, self.chain.units, path)


def _column_name(run: Trajectory, place: int | str) -> str:
    """Name of a column for `load_traces`: ``wall``, ``left wall``, ``ball 6`` or ``bead 7``."""
    if (wall := wall_number(run.chain, place)) is not None:
        return "left wall" if wall == 0 else "wall"
    bead = bead_number(run.chain, place, "sensor", walls=True)
    ball = bead - run.chain.strikers
    return f"ball {ball}" if run.chain.strikers and ball > 0 else f"bead {bead}"
