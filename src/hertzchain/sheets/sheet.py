"""A laboratory sheet: the forces and times that a chain should show at several speeds."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from ..chain.bead_names import bead_number, usual_spelling, wall_number
from ..chain.chain import Chain
from ..chain.feature_support import require_chain
from ..chain.hertz_range import hertz_range
from ..chain.impact_speed import at_impact_speed
from ..chain.strikers import speed_of_fall
from ..collision import Array
from ..errors import InputError, short_repr
from ..representation import counted, measure, short
from ..simulation.simulate_many import tabulate_runs
from ..store.writing import write_bytes
from ..validation.keywords import checked_arguments, checked_methods
from ..validation.numbers import number
from ..validation.objects import check_bool, check_list, file_path, text
from .first_pulse import first_on_wall

if TYPE_CHECKING:
    import pandas as pd

WALL: Final = "wall"
ENDINGS: Final = (".html", ".md")
LEAST, MOST, MOST_SENSORS = 2, 12, 4
# Units of the columns of a table.
UNITS: Final = MappingProxyType(
    {"sensor": "", "height": "m", "speed": "m/s", "force": "N", "time": "s"}
)


@checked_methods
@dataclass(frozen=True, eq=False, repr=False)
class LabSheet:
    """Predictions for an experiment at several speeds; the result of `hertzchain.lab_sheet`.

    Attributes
    ----------
    chain : Chain
        The row.
    places : tuple of str
        Sensors: beads such as ``"ball 6"``, or ``"wall"``.
    heights : ndarray, shape (S,), or None
        Heights from which the striker falls [m], if they were given.
    speeds : ndarray, shape (S,)
        Speeds of the impact [m/s].
    forces, times : ndarray, shape (S, K)
        First maximum of the force in each sensor or on the wall [N], by the rule of
        `SensorForce`, and its time after the impact [s]; NaN if there is none.  A later pulse,
        such as a second one from a heavy striker, may be stronger.
    warnings : tuple of str
        Limits of Hertz's law that are exceeded, each with the speed.
    title : str
        Title of the sheet.
    blank : bool
        Whether only the page for the teacher has the predictions.
    """

    chain: Chain
    places: tuple[str, ...]
    heights: Array | None
    speeds: Array
    forces: Array
    times: Array
    warnings: tuple[str, ...]
    title: str
    blank: bool

    @property
    def exponents(self) -> Array:
        """Exponents of the speed between successive speeds, shape (S - 1, K)."""
        slopes = np.diff(np.log(self.forces), axis=0)
        return np.asarray(slopes / np.diff(np.log(self.speeds))[:, None])

    def to_html(self) -> str:
        """A page that is printed from a browser: the sheet, and on a new page the answers.

        Examples
        --------
        >>> import hertzchain as hc
        >>> row = hc.Chain.from_materials(diameters="10 mm", materials="steel-52100", beads=5)
        >>> sheet = hc.lab_sheet(row, sensors=["ball 3"], speeds=["50 mm/s", "0.1 m/s"])
        >>> "For the teacher" in sheet.to_html()
        True
        """
        from .pages import html

        return html(self)

    def to_markdown(self) -> str:
        """The same text in Markdown, which pandoc converts for a word processor or LaTeX.

        Examples
        --------
        >>> import hertzchain as hc
        >>> row = hc.Chain.from_materials(diameters="10 mm", materials="steel-52100", beads=5)
        >>> sheet = hc.lab_sheet(row, sensors=["ball 3"], speeds=["50 mm/s", "0.1 m/s"])
        >>> print(*sheet.to_markdown().splitlines()[8:], sep="\\n", end="")  # doctest: +ELLIPSIS
        | quantity | v [mm/s] | predicted | reading 1 | reading 2 | mean |
        |---|---|---|---|---|---|
        | force, ball 3 [N] | 50.0 | 4.040 |  |  |  |
        | force, ball 3 [N] | 100.0 | 9.282 |  |  |  |
        ...
        """
        from .pages import markdown

        return markdown(self)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the sheet to a file, HTML (``.html``) or Markdown (``.md``).

        Parameters
        ----------
        path : path-like
            The file.

        Raises
        ------
        InputError
            If the file has another ending or cannot be written.

        Examples
        --------
        >>> import hertzchain as hc
        >>> import tempfile
        >>> from pathlib import Path
        >>> row = hc.Chain.from_materials(diameters="10 mm", materials="steel-52100", beads=5)
        >>> sheet = hc.lab_sheet(row, sensors=["ball 3"], speeds=["50 mm/s", "0.1 m/s"])
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     sheet.save(Path(folder) / "sheet.md")
        """
        target = file_path("file of the sheet", path)
        if target.suffix not in ENDINGS:
            raise InputError(f"the file of the sheet must end in .html or .md, got {target.name!r}")
        page = self.to_html() if target.suffix == ".html" else self.to_markdown()
        write_bytes(target, page.encode())

    def _repr_html_(self) -> str:
        from ..notebook.sheets import sheet_html

        return sheet_html(self)

    def to_dataframe(self) -> pd.DataFrame:
        """Table with one row per speed and sensor.

        Its columns are the sensor, the height [m] if heights were given, the speed [m/s], and the
        force [N] and time [s] of the first maximum, which are NaN if there is none.
        ``attrs["units"]`` has the units of the columns.

        Returns
        -------
        pandas.DataFrame
            Sorted by speed.

        Examples
        --------
        >>> import hertzchain as hc
        >>> row = hc.Chain.from_materials(diameters="10 mm", materials="steel-52100", beads=5)
        >>> sheet = hc.lab_sheet(row, sensors=["ball 3"], speeds=["50 mm/s", "0.1 m/s"])
        >>> sheet.to_dataframe()[["sensor", "speed", "force"]].round(2)
           sensor  speed  force
        0  ball 3   0.05   4.04
        1  ball 3   0.10   9.28
        """
        import pandas as pd

        count = len(self.places)
        columns: dict[str, Any] = {"sensor": self.places * len(self.speeds)}
        if self.heights is not None:
            columns["height"] = np.repeat(self.heights, count)
        columns |= {
            "speed": np.repeat(self.speeds, count),
            "force": self.forces.ravel(), "time": self.times.ravel(),
        }  # fmt: skip
        table = pd.DataFrame(columns)
        table.attrs["units"] = {name: UNITS[name] for name in columns}
        return table

    def __repr__(self) -> str:
        ends = [
            f"{1e3 * self.speeds[i]:.1f} mm/s: "
            + ", ".join(
                f"{place} {measure(force, 'N')}"
                for place, force in zip(self.places, self.forces[i], strict=True)
            )
            for i in (0, -1)
        ]
        at = counted(len(self.speeds), "speed")
        return short("LabSheet", self.chain.description, at, *ends)


@checked_arguments("lab_sheet")
def lab_sheet(
    chain: Chain,
    *,
    sensors: Iterable[int | str] = (WALL,),
    heights: Sequence[float | str] | None = None,
    speeds: Sequence[float | str] | None = None,
    title: str = "Impacts on a row of balls",
    blank: bool = False,
    until: float | str | None = None,
) -> LabSheet:
    """Make a laboratory sheet of a chain: predictions, readings, tasks, and the answers.

    Parameters
    ----------
    chain : Chain
        The row, in SI units, with one striker or moving ball.
    sensors : iterable of int or str
        Up to four beads with force sensors, such as ``"ball 6"``, and ``"wall"``, or
        ``"load cell"`` if the wall is a linear spring.  The sheet has them in the order in which
        the pulse arrives.
    heights : sequence of float or str, optional
        Heights from which the striker falls [m], or is raised as a pendulum.
    speeds : sequence of float or str, optional
        Speeds of the impact [m/s], instead of heights.
    title : str
        Title of the sheet.
    blank : bool
        Whether the students' page has no predictions, but only columns for readings.
    until : float or str, optional
        Time at which the simulations end [s]; by default as in `simulate_many`.

    Returns
    -------
    LabSheet
        With methods ``save``, ``to_html`` and ``to_markdown``.

    Raises
    ------
    InputError
        If the chain is scaled or has a drive, or there are no two heights or speeds.

    Examples
    --------
    >>> import hertzchain as hc
    >>> row = hc.Chain.from_materials(diameters="16 mm", materials="steel-52100", beads=12)
    >>> cell = row.replace(right_wall=hc.Wall("40 kN/mm", exponent=1)).with_cap("5 g")
    >>> cell = cell.struck_by()
    >>> sheet = hc.lab_sheet(cell, sensors=["ball 6", "wall"], heights=["1 mm", "2 mm", "4 mm"])
    >>> sheet.forces.round(2)
    array([[ 35.8 ,  79.28],
           [ 54.26, 116.57],
           [ 82.25, 170.76]])
    """
    require_chain("lab_sheet", chain)
    if chain.units != "SI":
        raise InputError("a laboratory sheet needs a chain in SI units; use Chain.from_materials")
    places = places_of(chain, sensors)
    falls, values = _speeds(heights, speeds)
    end = None if until is None else number("until", until, unit="s", above=0.0)
    chains = [at_impact_speed(chain, value) for value in values]
    beads = [bead_number(chain, place) for place in places if place != WALL]
    keep = [f"sensor_first_maximum{at}" for at in ("", "_time")] if beads else []
    keep += ["wall_peak_force", "wall_peak_time"] if WALL in places else []
    table = tabulate_runs(
        chains, keep=[*keep, "largest_overlap"], sensors=sorted(set(beads)), until=end
    )
    if table.reasons:
        raise InputError(f"a row cannot be simulated: {next(iter(table.reasons.values()))}")
    forces, times = np.zeros((2, len(values), len(places)))
    for j, place in enumerate(places):
        if place == WALL:
            peaks = zip(chains, table["wall_peak_force"], table["wall_peak_time"], strict=True)
            found = [first_on_wall(each, float(f), float(t), end) for each, f, t in peaks]
            forces[:, j], times[:, j] = np.array(found).T
        else:
            k = table.sensors.index(bead_number(chain, place))
            forces[:, j] = table["sensor_first_maximum"][:, k]
            times[:, j] = table["sensor_first_maximum_time"][:, k]
    warnings = [
        f"at {1e3 * value:.4g} mm/s, {violation}"
        for i, (each, value) in enumerate(zip(chains, values, strict=True))
        for violation in hertz_range(each, table._overlaps[i, : each.beads + 1]).violations
    ] if chain.materials is not None else []  # fmt: skip
    return LabSheet(
        chains[0],
        places,
        falls,
        values,
        forces,
        times,
        tuple(warnings),
        text("title", title),
        check_bool("blank", blank),
    )


def _speeds(heights: Any, speeds: Any) -> tuple[Array | None, Array]:
    """The heights, if they are given, and the speeds, in ascending order."""
    if (heights is None) == (speeds is None):
        raise InputError("give either heights, such as ['1 mm', '4 mm'], or speeds of the impact")
    given, what = (speeds, "speeds") if heights is None else (heights, "heights")
    # A scalar quantity of Pint has a length that raises.
    scalar = isinstance(given, str) or getattr(given, "ndim", 1) == 0
    if scalar or not hasattr(given, "__len__") or not LEAST <= len(given) <= MOST:
        raise InputError(
            f"{what} must be a list of {LEAST} to {MOST} values, such as "
            f"{['1 mm', '4 mm'] if heights is not None else ['0.1 m/s', '0.2 m/s']}, got "
            f"{short_repr(given)}"
        )
    unit = "m/s" if heights is None else "m"
    plain = sorted(number(what[:-1], each, unit=unit, above=0.0) for each in given)
    if len(set(plain)) < len(plain):
        raise InputError(f"{what} must be different, got {short_repr(given)}")
    if heights is None:
        return None, np.array(plain)
    return np.array(plain), np.array([speed_of_fall("height", each) for each in plain])


def places_of(chain: Chain, sensors: Any, what: str = "sensor") -> tuple[str, ...]:
    """Names of the sensors of a chain, in the order in which the pulse arrives."""
    given = (
        [sensors]
        if isinstance(sensors, str | int)
        else check_list("sensors", sensors, "places, such as 'ball 6'")
    )
    if not 1 <= len(given) <= MOST_SENSORS:
        raise InputError(f"sensors must be 1 to {MOST_SENSORS} places, got {len(given)}")
    found: dict[str, int] = {}
    for each in given:
        name = usual_spelling(each) if isinstance(each, str) else ""
        if name in (WALL, "right wall") and chain.right_wall is None:
            raise InputError(
                "the sensor 'wall' needs a right wall: add one, or use the sensor 'last'"
            )
        # The right wall of a chain with two.
        if wall_number(chain, "right wall" if name == WALL else name) == chain.beads + 1:
            found[WALL] = chain.beads + 1
            continue
        bead = bead_number(chain, each, what, walls=True)
        found[name or f"bead {bead}"] = bead
    if len(set(found.values())) < len(given):
        raise InputError(f"sensors must be different places, got {short_repr(given)}")
    return tuple(sorted(found, key=found.__getitem__))
