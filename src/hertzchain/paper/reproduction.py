"""Recompute the paper's tables, figures and formulas and compare them with the printed ones."""

from __future__ import annotations

import functools
import threading
import time
from collections.abc import Collection, Iterator, Mapping
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from ..calibration import BEADS, Window, beads_in_window
from ..errors import InputError, unknown_name_error
from ..evaluation.evaluate import scoreboard
from ..evaluation.scoreboard import Scoreboard
from ..evaluation.scoreboard_rows import percentage
from ..frozen import ShortDir
from ..notebook.drawing import note, numbers, page
from ..representation import counted, listed, short
from ..simulation.simulate import DEFAULT_RTOL
from ..validation.keywords import checked_arguments
from ..validation.objects import Progress
from ..verification.verify import Verdict, verify
from .erratum import Erratum
from .figures import LAYOUTS, RECALIBRATED, Figure, figure_chains, reproduce_figure
from .listed_errata import CONCERNED, errata, errata_chains
from .published import Fit, published_figures, published_tables
from .simulated_chains import Pulses, integrate_chains
from .tables import WINDOWS, Table, reproduce_table, table_chains
from .velocity_formulas import printed_and_corrected_errors

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False)
class Reproduction(ShortDir):
    """Result of recomputing the paper, or the requested parts.

    Attributes
    ----------
    tables : tuple of Table
        The recomputed tables.
    figures : tuple of Figure
        The recomputed figures, with the statement that was checked.
    errata : tuple of Erratum
        Contradictions within the paper, with evidence.
    pulses : mapping of (str, float) to Pulse
        Simulated pulses by taper and rate.
    energy_drift, momentum_drift : float
        Largest relative drift of a simulation.
    seconds : float
        Time of the computation.
    rtol : float
        Tolerance of the simulations.
    beads : int
        Number of beads of each chain.
    windows : mapping
        First and last bead of the fits.
    scoreboard : Scoreboard or None
        Comparison of the theories.
    verification : tuple of Verdict
        Exact and published values beyond the paper.
    """

    _omitted = ("entries", "agreeing_entries", "holding_statements", "rtol", "beads", "windows")

    tables: tuple[Table, ...]
    figures: tuple[Figure, ...]
    errata: tuple[Erratum, ...]
    pulses: Pulses
    energy_drift: float
    momentum_drift: float
    seconds: float
    rtol: float = DEFAULT_RTOL
    beads: int = BEADS
    windows: Mapping[Fit, Window] = field(default_factory=lambda: WINDOWS)
    scoreboard: Scoreboard | None = None
    verification: tuple[Verdict, ...] = ()
    all_errata: bool = False

    @property
    def parts(self) -> tuple[str, ...]:
        """Names of the recomputed parts, as in `reproduce`."""
        others = {
            "errata": self.all_errata,
            "scoreboard": self.scoreboard is not None,
            "verification": bool(self.verification),
        }
        return (
            *(table.published.name for table in self.tables),
            *(figure.published.name for figure in self.figures),
            *(part for part, present in others.items() if present),
        )

    @property
    def entries(self) -> int:
        """Number of entries in the reproduced tables."""
        return sum(len(table.entries) for table in self.tables)

    @property
    def agreeing_entries(self) -> int:
        """Number of entries that agree with the printed values."""
        return sum(table.agreeing for table in self.tables)

    @property
    def holding_statements(self) -> int:
        """Number of figures whose statement holds."""
        return sum(figure.statement.holds for figure in self.figures)

    @property
    def within_tolerance(self) -> bool:
        """Whether all entries agree, all statements hold and all known values are reproduced."""
        all_entries = self.agreeing_entries == self.entries
        all_known = all(verdict.agrees for verdict in self.verification)
        return all_entries and all_known and self.holding_statements == len(self.figures)

    def to_dataframe(self) -> pd.DataFrame:
        """Entries of all tables, one row each, as `Table.to_dataframe`.

        Returns
        -------
        pandas.DataFrame
            With a further column ``table``.

        Examples
        --------
        >>> from hertzchain.paper import reproduce
        >>> reproduce(["table1"]).to_dataframe().table.unique().tolist()
        ['table1']
        """
        import pandas as pd

        frames = [each.to_dataframe().assign(table=each.published.name) for each in self.tables]
        return pd.concat(frames, ignore_index=True) if frames else pd.DataFrame()

    def __repr__(self) -> str:
        known = sum(verdict.agrees for verdict in self.verification)
        return short(
            "Reproduction",
            f"{counted(len(self.tables), 'table')}, {counted(len(self.figures), 'figure')}",
            f"{self.agreeing_entries} of {self.entries} entries agree" if self.tables else "",
            f"checks passed: {self.holding_statements} of {len(self.figures)}"
            if self.figures else "",
            f"errata: {len(self.errata)}" if self.errata else "",
            f"{known} of {len(self.verification)} known values" if self.verification else "",
            f"{self.seconds:.1f} s",
        )  # fmt: skip

    def _repr_html_(self) -> str:
        return _reproduction_html(self)

    @functools.cached_property
    def verdict(self) -> str:
        """Summary of the outcome in a few sentences."""
        return " ".join(sentence for _, sentence, _ in self.summary)

    @functools.cached_property
    def summary(self) -> tuple[tuple[str, str, bool], ...]:
        """Part, outcome in one sentence, and whether it is within its tolerance."""
        parts = []
        if self.tables:
            exact = sum(entry.units == 0 for table in self.tables for entry in table.entries)
            seven_decimals = (
                " (the forward momentum rates, which have seven decimals, to within ten units)"
                if any(table.published.name == "table1" for table in self.tables)
                else ""
            )
            sentence = (
                f"{self.agreeing_entries} of {self.entries} table entries agree with the paper to "
                f"within one unit of the last printed digit{seven_decimals}; {exact} match every "
                "digit."
            )
            parts.append(("tables", sentence, self.agreeing_entries == self.entries))
        if self.figures:
            count = len(self.figures)
            sentence = f"{self.holding_statements} of {count} figures pass their checks"
            numbers = [figure.published.number for figure in self.figures]
            if refitted := [str(n) for n in numbers if LAYOUTS[n].theory == RECALIBRATED]:
                sentence += (
                    f"; in figure{'s' * (len(refitted) > 1)} {listed(refitted)}, the constants of "
                    "the modified BCA are recalibrated"
                )
            sentence += "."
            parts.append(("figures", sentence, self.holding_statements == count))
        if self.errata:
            parts.append(("errata", self._sentence_on_errata(), True))
        if self.scoreboard is not None:
            parts.append(("scoreboard", _best_theory(self.scoreboard), True))
        if self.verification:
            agreeing, count = sum(each.agrees for each in self.verification), len(self.verification)
            sentence = (
                f"Beyond the paper, {agreeing} of {count} exact or published values are reproduced."
            )
            parts.append(("verification", sentence, agreeing == count))
        return tuple(parts)

    def _sentence_on_errata(self) -> str:
        count = len(self.errata)
        if not self.all_errata:
            verb = "concerns" if count == 1 else "concern"
            names = {name for each in self.errata for name in each.concerns}
            chosen = [("table", table.published.name) for table in self.tables]
            chosen += [("figure", figure.published.name) for figure in self.figures]
            shown = listed([f"{kind} {name.removeprefix(kind)}" for kind, name in chosen
                            if name in names])  # fmt: skip
            return f"{count} {'erratum' if count == 1 else 'errata'} {verb} {shown}."
        printed, corrected = printed_and_corrected_errors(self.pulses)
        return (
            f"{count} errata are listed: the paper's four velocity formulas differ from the "
            f"simulation by up to {printed:.0%} as printed and by up to {corrected:.0%} as "
            "corrected (for linear tapers, using the exact BCA product)."
        )


def _reproduction_html(found: Reproduction) -> str:
    """Outcome of each part."""
    sentences = [
        note(sentence if good else f"{sentence} This is outside the tolerance.")
        for _, sentence, good in found.summary
    ]
    shown = {
        "chains": f"{len(found.pulses)} of {found.beads} beads",
        "drift of the energy": f"{found.energy_drift:.0e}",
        "time": f"{found.seconds:.1f} s",
    }
    return page("Reproduction", "of the paper", *sentences, numbers(shown))


def checked_parts(only: Collection[str] | None) -> set[str]:
    """Check that all requested parts of a reproduction exist."""
    known = part_names()
    parts = set(known if only is None else only)
    if isinstance(only, str) or not parts:
        raise InputError(
            f"parts must be a list of at least one of {', '.join(known)}; got {only!r}"
        )
    for part in parts:
        if part not in known:
            raise unknown_name_error("part of the reproduction", part, known)
    return parts


@checked_arguments("reproduce")
def reproduce(
    only: Collection[str] | None = None,
    *,
    windows: Mapping[Fit, Window] | None = None,
    progress: Progress | None = None,
) -> Reproduction:
    """Simulate the paper's chains and compare its tables, figures and formulas with them.

    Parameters
    ----------
    only : collection of str, optional
        Parts, such as ``["table1", "figure3", "errata"]``; all by default.  An unknown name
        raises an error that lists them.
    windows : mapping, optional
        First and last bead of the ``"exponential"`` and ``"linear"`` fits of the tables.
    progress : callable, optional
        Called as ``progress(chains_done, chains)``.

    Returns
    -------
    Reproduction

    Raises
    ------
    InputError
        If a part or fit does not exist, or a window is not within the chain.

    Examples
    --------
    >>> from hertzchain.paper import reproduce
    >>> reproduce(["table3"]).within_tolerance
    True
    """
    started = time.perf_counter()
    parts = checked_parts(only)
    used: dict[Fit, Window] = {**WINDOWS}
    for fit, window in (windows or {}).items():
        if fit not in WINDOWS:
            raise unknown_name_error("fit", fit, WINDOWS)
        beads_in_window(window, BEADS)
        used[fit] = window
    tables = [name for name in published_tables() if name in parts]
    figures = [name for name in published_figures() if name in parts]
    wanted: set[tuple[str, float]] = set()
    wanted.update(*map(table_chains, tables), *map(figure_chains, figures))
    if "errata" in parts or not parts.isdisjoint(CONCERNED):
        wanted |= errata_chains()
    drifts: list[tuple[float, float]] = []
    # Most of the time, both are in compiled code, which runs in parallel.
    with _verifying("verification" in parts) as verified:
        pulses = integrate_chains(wanted, progress=progress, drifts=drifts)
        verification = tuple(verified.result())
    return Reproduction(
        tables=tuple(
            reproduce_table(name, pulses, used[published_tables()[name].fit]) for name in tables
        ),
        figures=tuple(reproduce_figure(name, pulses) for name in figures),
        errata=_errata(pulses, parts),
        all_errata="errata" in parts,
        pulses=pulses,
        energy_drift=max((energy for energy, _ in drifts), default=0.0),
        momentum_drift=max((momentum for _, momentum in drifts), default=0.0),
        scoreboard=scoreboard() if "scoreboard" in parts else None,
        seconds=time.perf_counter() - started,
        windows=used,
        verification=verification,
    )


def _errata(pulses: Pulses, parts: set[str]) -> tuple[Erratum, ...]:
    """All errata if they are requested, otherwise those of the requested tables and figures."""
    if "errata" in parts:
        return tuple(errata(pulses))
    return () if parts.isdisjoint(CONCERNED) else tuple(errata(pulses, parts))


@contextmanager
def _verifying(wanted: bool) -> Iterator[Future[list[Verdict]]]:
    """Compute known values in another thread, which stops if the block raises an exception."""
    stopped = threading.Event()

    def stop_if_asked(_done: int, _cases: int) -> None:
        if stopped.is_set():
            raise CancelledError

    with ThreadPoolExecutor(max_workers=1) as thread:
        try:
            yield thread.submit(lambda: verify(progress=stop_if_asked) if wanted else [])
        except BaseException:
            stopped.set()
            raise


def _best_theory(board: Scoreboard) -> str:
    """One sentence about the BCA and the best theory on smooth unseen tapers."""
    worst = board.table("velocity", by="group").loc["smooth"].dropna()
    best, tapers = worst.idxmin(), len(board.rows("group")["smooth"])
    return (
        f"On {tapers} smooth tapers that no theory was fitted to, the largest velocity error "
        f"(beads 10 to {board.last_bead}) is {percentage(worst['bca'])}% for the BCA and "
        f"{percentage(worst[best])}% for the best theory, {best}."
    )


def part_names() -> tuple[str, ...]:
    """Names of all parts that can be reproduced, in the order of the paper."""
    return (*published_tables(), *published_figures(), "errata", "scoreboard", "verification")
