r"""Scoreboard: errors of all theories, compared with the simulation, on many tapers.

The chains are the paper's four tapers, at its rates and beyond them, and tapers to which no
theory was fitted (`hertzchain.evaluation.cases`).  Errors are evaluated from bead 2 or a later
bead to bead N - 3.  Only the local-rate law describes the free end, which the last beads leave;
its effect on bead N - 3 and all beads before it is below 1e-9.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from ..collision import Array
from ..errors import InputError
from ..pulse.quantities import QUANTITIES as TABLE
from ..representation import counted, listed
from ..validation.keywords import checked_methods
from ..validation.numbers import whole_number
from ..validation.objects import check_choice
from .cases import FIRST_BEADS, Case
from .unseen_tapers import is_smooth

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

Row = Literal["family", "case", "group"]
Statistic = Literal["worst", "rms"]
STATISTICS: Final[tuple[Statistic, ...]] = get_args(Statistic)

# Quantities by which theories are evaluated.
QUANTITIES: Final = tuple(name for name, quantity in TABLE.items() if quantity.scored)


@checked_methods
@dataclass(frozen=True, eq=False)
class Scoreboard:
    """Relative errors of theories on chains, bead by bead.

    Attributes
    ----------
    cases : tuple of Case
        The C chains.
    theories : tuple of str
        Names of the T theories.
    errors : mapping of str to ndarray, shape (T, C, N)
        Relative error of each quantity at bead (or contact) k = 1..N, where N is the length of
        the longest chain.  It is NaN beyond the last evaluated bead, and for all beads if a
        theory does not support a chain or does not predict the quantity.
    warned : ndarray of bool, shape (T, C)
        Whether the theory issued a `ModelRangeWarning` for the chain.
    refusals : mapping of (str, str) to str
        Reasons why theories do not support chains, by the names of both.
    estimates : ndarray, shape (T, C, N)
        Relative velocity error as estimated by the theory; NaN if it has no estimate, or the error
        is unknown.

    Examples
    --------
    >>> import hertzchain as hc
    >>> board = hc.scoreboard(theories=["bca"])
    >>> board.cases[0].name, hc.evaluation.percentage(board.worst("velocity")[0, 0])
    ('backward-linear, S = 0.1', '49')
    """

    cases: tuple[Case, ...]
    theories: tuple[str, ...]
    errors: Mapping[str, Array]
    warned: NDArray[np.bool_]
    refusals: Mapping[tuple[str, str], str]
    estimates: Array

    @property
    def last_bead(self) -> int:
        """Last bead (or contact) that is evaluated in every chain."""
        return min(case.last_bead for case in self.cases)

    def worst(self, quantity: str, *, first_bead: int = 10) -> Array:
        """Largest absolute relative error along each chain.

        Parameters
        ----------
        quantity : str
            One of `QUANTITIES`.
        first_bead : int
            First bead (or contact) that is evaluated.

        Returns
        -------
        ndarray, shape (T, C)
            Errors; NaN if a theory does not support a chain or does not predict the quantity.

        Raises
        ------
        InputError
            If the quantity is unknown, or some chains do not have the bead.

        Examples
        --------
        >>> import hertzchain as hc
        >>> import numpy as np
        >>> board = hc.scoreboard(theories=["hard-sphere"])
        >>> bool(np.isnan(board.worst("arrival")).all())
        True
        """
        return np.asarray(np.fmax.reduce(np.abs(self._counted(quantity, first_bead)), axis=2))

    def rms(self, quantity: str, *, first_bead: int = 10) -> Array:
        """Root mean square of the relative errors along each chain.

        Parameters
        ----------
        quantity, first_bead
            As for `worst`.

        Returns
        -------
        ndarray, shape (T, C)
            Errors, NaN in the same places as for `worst`.

        Examples
        --------
        >>> import hertzchain as hc
        >>> board = hc.scoreboard(theories=["bca"])
        >>> bool((board.rms("energy") < board.worst("energy")).all())
        True
        """
        errors = self._counted(quantity, first_bead)
        beads = np.sum(~np.isnan(errors), axis=2)
        with np.errstate(invalid="ignore"):
            return np.asarray(np.sqrt(np.nansum(errors**2, axis=2) / beads))

    def _counted(self, quantity: str, first_bead: int) -> Array:
        check_choice("quantity of the scoreboard", quantity, tuple(self.errors))
        first = whole_number("first_bead", first_bead, least=2, most=self.last_bead)
        return self.errors[quantity][:, :, first - 1 :]

    def coverage(self, theory: str, *groups: str) -> tuple[float, float]:
        """Quality of a theory's estimate of its velocity error, from bead 2 on.

        Parameters
        ----------
        theory : str
            Name of a theory that estimates its error.
        *groups : str
            Groups of chains, keys of ``rows("group")``; by default, all.

        Returns
        -------
        covered : float
            Fraction of the beads at which the true error is at most the estimated one.
        ratio : float
            Median ratio of the estimated to the true error.

        Raises
        ------
        InputError
            If the theory or a group is unknown, or the theory does not estimate its error.

        Examples
        --------
        >>> import hertzchain as hc
        >>> covered, ratio = hc.scoreboard(theories=["local-rate"]).coverage("local-rate", "smooth")
        >>> covered > 0.9
        True
        """
        check_choice("theory", theory, self.theories)
        rows = self.rows("group")
        groups = groups or tuple(rows)
        for group in groups:
            check_choice("group", group, tuple(rows))
        t = self.theories.index(theory)
        chosen = [c for group in groups for c in rows[group]]
        estimated = self.estimates[t, chosen, 1:]
        true = np.abs(self.errors["velocity"][t, chosen, 1:])
        counted = np.isfinite(true) & np.isfinite(estimated)
        if not counted.any():
            raise InputError(
                f"{theory} does not estimate its error on the chains of {listed(groups)}"
            )
        estimated, true = estimated[counted], true[counted]
        with np.errstate(divide="ignore"):
            return float(np.mean(true <= estimated)), float(np.median(estimated / true))

    def table(
        self,
        quantity: str = "velocity",
        *,
        first_bead: int = 10,
        statistic: Statistic = "worst",
        by: Row = "family",
    ) -> pd.DataFrame:
        """Error of each theory on each family of chains.

        Parameters
        ----------
        quantity : str
            One of `QUANTITIES`.
        first_bead : int
            First bead (or contact) that is evaluated.
        statistic : str
            ``"worst"``, or ``"rms"`` over beads and then over the chains of a row.
        by : str
            Meaning of a row: a ``"family"``, a single ``"case"`` or a ``"group"``.

        Returns
        -------
        pandas.DataFrame
            Relative errors, with one column per theory; NaN if a theory does not support all
            chains of a row.

        Raises
        ------
        InputError
            If a name is unknown, or some chains do not have the bead.

        Examples
        --------
        >>> import hertzchain as hc
        >>> table = hc.scoreboard().table("velocity", by="group")
        >>> table.loc["smooth", "two-thirds-bca"] < table.loc["smooth", "bca"]
        np.True_
        """
        import pandas as pd

        check_choice("statistic", statistic, STATISTICS)
        values = getattr(self, statistic)(quantity, first_bead=first_bead)
        rows = {
            label: [_summarise(values[t, members], statistic) for t in range(len(self.theories))]
            for label, members in self.rows(by).items()
        }
        return pd.DataFrame.from_dict(rows, orient="index", columns=list(self.theories))

    def outside(self, by: Row = "family") -> pd.DataFrame:
        """Whether a theory warned that a chain of a row is outside its range.

        Parameters
        ----------
        by : str
            Meaning of a row, as for `table`.

        Returns
        -------
        pandas.DataFrame
            Booleans, with one column per theory.

        Examples
        --------
        >>> import hertzchain as hc
        >>> outside = hc.scoreboard(theories=["modified-bca"]).outside()
        >>> outside.index[outside["modified-bca"]][0]
        'backward-linear, S = 1'
        """
        import pandas as pd

        rows = {label: self.warned[:, found].any(axis=1) for label, found in self.rows(by).items()}
        return pd.DataFrame.from_dict(rows, orient="index", columns=list(self.theories))

    def rows(self, by: Row) -> dict[str, list[int]]:
        """Indices of the chains of each family, case or group, in order.

        Parameters
        ----------
        by : str
            Meaning of a row, as for `table`.

        Returns
        -------
        dict of str to list of int
            Indices into ``cases``.

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.scoreboard(theories=["bca"]).rows("family")["backward-linear, S = 0.1..0.9"]
        [0, 1, 2, 3, 4]
        """
        check_choice("row", by, get_args(Row))
        found: dict[str, list[int]] = {}
        for c, case in enumerate(self.cases):
            found.setdefault(case.name if by == "case" else getattr(case, by), []).append(c)
        return found

    def to_xarray(self) -> xr.Dataset:
        """Labelled dataset of the errors, with dimensions ``theory``, ``case`` and ``bead``.

        Returns
        -------
        xarray.Dataset
            One variable per quantity, and ``warned``; ``family`` and ``group`` are coordinates.

        Examples
        --------
        >>> import hertzchain as hc
        >>> errors = hc.scoreboard().to_xarray()
        >>> round(float(errors.velocity.sel(theory="bca", case="bump", bead=20)), 2)
        0.46
        """
        import xarray as xr

        dims = ("theory", "case", "bead")
        columns: dict[str, tuple[object, ...]] = {
            name: (dims, values, {"long_name": f"relative error of {name}"})
            for name, values in self.errors.items()
        }
        columns["warned"] = (dims[:2], self.warned, {"long_name": "outside the theory's range"})
        longest = max(case.chain.beads for case in self.cases)
        return xr.Dataset(
            columns,
            coords={
                "theory": list(self.theories),
                "case": [case.name for case in self.cases],
                "bead": np.arange(1, longest + 1),
                "family": ("case", [case.family for case in self.cases]),
                "group": ("case", [case.group for case in self.cases]),
            },
        )

    def to_dataframe(self) -> pd.DataFrame:
        """Table with one row per theory, chain, quantity and first bead.

        Returns
        -------
        pandas.DataFrame
            Columns ``theory``, ``case``, ``family``, ``group``, ``quantity``, ``first_bead``
            (2 and 10), ``worst``, ``rms`` and ``warned``; NaN if a theory does not support a
            chain or does not predict the quantity.

        Examples
        --------
        >>> import hertzchain as hc
        >>> rows = hc.scoreboard(theories=["bca"]).to_dataframe()
        >>> len(rows), rows.worst.isna().sum().item()
        (520, 0)
        """
        import pandas as pd

        rows = []
        for quantity in self.errors:
            for first in FIRST_BEADS:
                worst, rms = (f(quantity, first_bead=first) for f in (self.worst, self.rms))
                for t, c in np.ndindex(worst.shape):
                    case = self.cases[c]
                    rows.append(
                        (self.theories[t], case.name, case.family, case.group, quantity, first,
                         worst[t, c], rms[t, c], self.warned[t, c])
                    )  # fmt: skip
        names = "theory", "case", "family", "group", "quantity", "first_bead"
        return pd.DataFrame(rows, columns=[*names, "worst", "rms", "warned"])

    def as_dict(self, by: Row = "case") -> dict[str, Any]:
        """Convert to a dictionary of JSON types.

        Parameters
        ----------
        by : str
            Meaning of a row, as for `table`.

        Returns
        -------
        dict
            For each row, the ``worst`` and ``rms`` errors of each theory and quantity, from
            bead 2 and from bead 10 on.  Errors that are not available are omitted.

        Examples
        --------
        >>> import hertzchain as hc
        >>> (first, *_) = hc.scoreboard(theories=["bca"]).as_dict()["rows"]
        >>> list(first["theories"]["bca"]["errors"]["arrival"])
        ['from_2', 'from_10']
        """
        tables = {
            (quantity, first, statistic): self.table(
                quantity, first_bead=first, statistic=statistic, by=by
            )
            for quantity in self.errors for first in FIRST_BEADS for statistic in STATISTICS
        }  # fmt: skip
        rows: list[dict[str, Any]] = []
        for label, members in self.rows(by).items():
            cases = [self.cases[c] for c in members]
            theories: dict[str, Any] = {}
            for t, name in enumerate(self.theories):
                theories[name] = {"warned": bool(self.warned[t, members].any()), "errors": {}}
                reasons = {self.refusals.get((name, case.name)) for case in cases} - {None}
                if reasons:
                    theories[name]["refusal"] = "; ".join(sorted(map(str, reasons)))
            for (quantity, first, statistic), table in tables.items():
                for name, error in table.loc[label].dropna().items():
                    found = theories[name]["errors"].setdefault(quantity, {})
                    found.setdefault(f"from_{first}", {})[statistic] = float(error)
            rows.append(
                {
                    "name": label,
                    "group": cases[0].group,
                    "chains": [case.name for case in cases],
                    "smooth": all(is_smooth(case.chain.radii) for case in cases),
                    "theories": theories,
                }
            )
        return {
            "theories": list(self.theories),
            "quantities": list(self.errors),
            "last_bead": self.last_bead,
            "rows": rows,
        }

    def __repr__(self) -> str:
        theories = "1 theory" if len(self.theories) == 1 else f"{len(self.theories)} theories"
        return f"Scoreboard({theories} on {counted(len(self.cases), 'chain')})"

    def __str__(self) -> str:
        from .scoreboard_rows import scoreboard_text

        return scoreboard_text(self)

    def _repr_html_(self) -> str:
        from ..notebook.theories import scoreboard_html

        return scoreboard_html(self)


def _summarise(values: Array, statistic: Statistic) -> float:
    """Summarise the errors of several chains; NaN if one of them is NaN."""
    return float(np.max(values) if statistic == "worst" else np.sqrt(np.mean(values**2)))
