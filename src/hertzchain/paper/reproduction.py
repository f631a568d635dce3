"""Regenerate everything the paper prints and hold it against the print."""

from __future__ import annotations

import functools
import time
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field

from hertzchain.calibration import BEADS, Window, beads_in_window
from hertzchain.chain.chain import Chain, Taper
from hertzchain.errors import InputError, unknown_name
from hertzchain.paper.errata import Erratum, errata, errata_chains
from hertzchain.paper.figures import Figure, figure_chains, reproduce_figure
from hertzchain.paper.formulas import printed_and_mended_errors
from hertzchain.paper.published import Fit, published_figures, published_tables
from hertzchain.paper.tables import WINDOWS, Pulses, Table, reproduce_table, table_chains
from hertzchain.pulse.pulse import Pulse
from hertzchain.scoreboard.judge import scoreboard
from hertzchain.scoreboard.scoreboard import Scoreboard, percentage
from hertzchain.simulation.simulate import DEFAULT_RTOL, simulate
from hertzchain.verification.verify import Verdict, verify

Progress = Callable[[int, int], None]


@dataclass(frozen=True, eq=False)
class Reproduction:
    """What came of regenerating the paper, or the parts that were asked for."""

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

    @property
    def entries(self) -> int:
        """Numbers in the reproduced tables."""
        return sum(len(table.entries) for table in self.tables)

    @property
    def agreeing_entries(self) -> int:
        """Of these, how many agree with the print."""
        return sum(table.agreeing for table in self.tables)

    @property
    def holding_statements(self) -> int:
        """Figures whose statement holds."""
        return sum(figure.statement.holds for figure in self.figures)

    @property
    def within_tolerance(self) -> bool:
        """Whether every entry agrees, every statement holds and every known value is met."""
        all_entries = self.agreeing_entries == self.entries
        all_known = all(verdict.agrees for verdict in self.verification)
        return all_entries and all_known and self.holding_statements == len(self.figures)

    @functools.cached_property
    def verdict(self) -> str:
        """The outcome in one or two sentences."""
        parts = []
        if self.tables:
            exact = sum(entry.units == 0 for table in self.tables for entry in table.entries)
            seven_decimals = (
                " (the forward momentum rates, printed to seven decimals, within 1.0e-6)"
                if any(table.published.name == "table1" for table in self.tables)
                else ""
            )
            parts.append(
                f"{self.agreeing_entries} of {self.entries} numbers of the tables agree with the "
                f"print within one unit of the last digit{seven_decimals}; {exact} have the very "
                "digits."
            )
        if self.figures:
            parts.append(
                f"{self.holding_statements} of {len(self.figures)} figures pass their check."
            )
        if self.errata:
            printed, mended = printed_and_mended_errors(self.pulses)
            parts.append(
                f"{len(self.errata)} places to correct are shown: the paper's four velocity "
                f"formulas miss the integration by up to {printed:.0%} as printed, and by up to "
                f"{mended:.0%} once mended (linear tapers by the exact product of the BCA)."
            )
        if self.scoreboard is not None:
            parts.append(_best_theory(self.scoreboard))
        if self.verification:
            agreeing = sum(verdict.agrees for verdict in self.verification)
            parts.append(
                f"Beyond the paper, {agreeing} of {len(self.verification)} quantities with exact "
                "or published values are met."
            )
        return " ".join(parts)


def checked_parts(only: Collection[str] | None) -> set[str]:
    """The parts of a reproduction, if all of them exist.

    Parameters
    ----------
    only : collection of str, optional
        Names of parts; all by default.

    Returns
    -------
    set of str

    Raises
    ------
    InputError
        For an unknown part, or none.

    Examples
    --------
    >>> checked_parts(["table1"])
    {'table1'}
    """
    parts = set(items() if only is None else only)
    if isinstance(only, str) or not parts:
        raise InputError(f"name at least one part in a list, of {', '.join(items())}; got {only!r}")
    for part in parts:
        if part not in items():
            raise unknown_name("table or figure", part, items())
    return parts


def reproduce(
    only: Collection[str] | None = None,
    *,
    windows: Mapping[Fit, Window] | None = None,
    progress: Progress | None = None,
) -> Reproduction:
    """Integrate the paper's chains and hold its tables, figures and formulas against them.

    Parameters
    ----------
    only : collection of str, optional
        Parts to do: ``"table1"`` to ``"table3"``, ``"figure1"`` to ``"figure14"``,
        ``"errata"``, ``"scoreboard"``, ``"verification"``.  All by default.
    windows : mapping, optional
        First and last bead of the fits of ``"exponential"`` tables (1 and 2) and the
        ``"linear"`` one (3).
    progress : callable, optional
        Called as ``progress(chains_done, chains)``.

    Returns
    -------
    Reproduction

    Raises
    ------
    InputError
        For an unknown part or a window outside the chains.

    Examples
    --------
    >>> reproduce(["table3"]).within_tolerance
    True
    """
    started = time.perf_counter()
    parts = checked_parts(only)
    used: dict[Fit, Window] = {**WINDOWS}
    for fit, window in (windows or {}).items():
        if fit not in WINDOWS:
            raise unknown_name("fit", fit, WINDOWS)
        beads_in_window(window, BEADS)
        used[fit] = window
    tables = [name for name in published_tables() if name in parts]
    figures = [name for name in published_figures() if name in parts]
    wanted: set[tuple[Taper, float]] = set()
    wanted.update(*map(table_chains, tables), *map(figure_chains, figures))
    if "errata" in parts:
        wanted |= errata_chains()
    drifts: list[tuple[float, float]] = []
    pulses = integrate_chains(wanted, progress=progress, drifts=drifts)
    return Reproduction(
        tables=tuple(
            reproduce_table(name, pulses, used[published_tables()[name].fit]) for name in tables
        ),
        figures=tuple(reproduce_figure(name, pulses) for name in figures),
        errata=tuple(errata(pulses)) if "errata" in parts else (),
        pulses=pulses,
        energy_drift=max((energy for energy, _ in drifts), default=0.0),
        momentum_drift=max((momentum for _, momentum in drifts), default=0.0),
        scoreboard=scoreboard() if "scoreboard" in parts else None,
        seconds=time.perf_counter() - started,
        windows=used,
        verification=tuple(verify()) if "verification" in parts else (),
    )


def integrate_chains(
    chains: Iterable[tuple[Taper, float]],
    *,
    beads: int = BEADS,
    progress: Progress | None = None,
    drifts: list[tuple[float, float]] | None = None,
) -> dict[tuple[Taper, float], Pulse]:
    """Integrate tapered chains with the full-chain engine.

    Parameters
    ----------
    chains : iterable of (taper, rate)
        Chains to integrate.
    beads : int
        Beads of each.
    progress : callable, optional
        Called as ``progress(chains_done, chains)``.
    drifts : list, optional
        Receives each run's drift of energy and momentum.

    Returns
    -------
    dict of (taper, rate) to Pulse

    Examples
    --------
    >>> pulses = integrate_chains([("forward-linear", 0.01)], beads=20)
    >>> pulses["forward-linear", 0.01].chain
    Chain(forward-linear, S = 0.01, 20 beads)
    """
    ordered = sorted(chains)
    pulses = {}
    for done, (taper, rate) in enumerate(ordered, start=1):
        run = simulate(Chain.tapered(taper, rate, beads=beads), times=0, rtol=DEFAULT_RTOL)
        pulses[taper, rate] = run.pulse()
        if drifts is not None:
            drifts.append((run.energy_drift, run.momentum_drift))
        if progress is not None:
            progress(done, len(ordered))
    return pulses


def _best_theory(board: Scoreboard) -> str:
    """The BCA and the best theory on smooth unseen tapers, in one sentence."""
    worst = board.table("velocity", by="group").loc["smooth"].dropna()
    best, tapers = worst.idxmin(), len(board.rows("group")["smooth"])
    return (
        f"On {tapers} smooth tapers that no theory was fitted to, the BCA's velocity is wrong by "
        f"up to {percentage(worst['bca'])}% (k = 10..{board.last_bead}), that of the best theory, "
        f"{best}, by up to {percentage(worst[best])}%."
    )


def items() -> tuple[str, ...]:
    """Names of all that can be reproduced, in the order of the paper.

    Returns
    -------
    tuple of str

    Examples
    --------
    >>> items()[0], items()[-1], len(items())
    ('table1', 'verification', 20)
    """
    return (*published_tables(), *published_figures(), "errata", "scoreboard", "verification")
