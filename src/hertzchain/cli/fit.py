"""The command `fit`: fit a chain and its sensors to measured traces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from ..recorded_warnings import ignore_warnings
from ..simulation.yielding import pressures_below_yield
from .defect_lines import other_kind, other_place, trying
from .exit_codes import DONE, FAILED, OUTSIDE_TOLERANCE
from .fit_options import (
    also_free_option,
    begin_option,
    free_option,
    part_of,
    prior_option,
    priors_from,
    start_from,
    start_option,
    time_offset_from,
    time_offset_option,
    until_option,
)
from .options import (
    StrictCommand,
    check_chain_file,
    check_writable,
    figure_option,
    json_option,
    names_from,
    noise_from,
    noise_option,
    sensors_from,
    sensors_option,
)
from .output import save_figure, show_json
from .postponed_diagnosis import PostponedDiagnosis, add_advice, cause_of_misfit
from .progress import progress_bar
from .wording import on_command_line
from .wrapped_text import show_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..fitting.defect_scan import DefectScan
    from ..fitting.posterior import Posterior
    from ..fitting.result import FitResult
    from ..traces.traces import Traces


HELD_BACK: Final = (
    "gaps and odd balls are not searched for, because the cause named above describes the data: "
    "correct it first"
)


@click.command(cls=StrictCommand)
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
@sensors_option
@noise_option
@click.option(
    "--channels", is_flag=True, help="The files of traces are channels of one shot, not shots."
)
@free_option
@also_free_option
@prior_option
@start_option
@time_offset_option
@begin_option
@until_option
@click.option(
    "--starts", type=int, default=4, show_default=True, help="Largest number of starting points."
)
@click.option(
    "--laws",
    metavar="NAMES",
    help="Compare loss laws with that of the chain file: all, or names separated by commas; for 10 "
    "balls and 1600 samples, all takes 1 to 2 min of processor time.",
)
@click.option(
    "--defects",
    is_flag=True,
    help="Search for the gap or odd ball that explains most of the residuals, and fit it; this "
    "takes 40 to 80 s of processor time for 20 balls and 1800 samples.",
)
@click.option(
    "--diagnosis/--no-diagnosis",
    "diagnosis",
    default=True,
    help="Whether to look for the cause if the model does not describe the data; for 15 balls and "
    "3000 samples, this takes 1 to 2 min of processor time.  [default: --diagnosis]",
)
@click.option(
    "--sample",
    type=int,
    metavar="STEPS",
    help="Also sample the posterior with emcee (extra: fit), as a check of the errors; d "
    "parameters need about 100 + 5 d steps.",
)
@figure_option(
    "Plot data, fit and residuals to FILE; residuals, correlations, defects "
    "and the corner plot get names with -residuals, -correlations, -defects and -corner."
)
@click.option(
    "--out", type=click.Path(path_type=Path), metavar="FILE", help="Write the fitted chain (.toml)."
)
@json_option()
def fit(
    files: tuple[Path, ...], sensors: tuple[str, ...], noises: tuple[str, ...], channels: bool,
    free: tuple[str, ...], also_free: tuple[str, ...], priors: tuple[str, ...],
    starting_values: tuple[str, ...], time_offset: tuple[str, ...], begin: str | None,
    until: str | None, starts: int, laws: str | None, defects: bool, diagnosis: bool,
    sample: int | None, plot: Path | None, out: Path | None, as_json: bool,
) -> int:  # fmt: skip
    """Fit a chain and its sensors to measured traces.

    FILES are one or several CSV files of traces, one per shot or, with --channels, one per channel
    of a shot, followed by the chain file.  Columns are, for example, time [us], ball 6 [N], ball 11
    [mV], wall [N] and ball 3 velocity [m/s].  The table [fit] of the chain file names free
    parameters and priors.

    The exit code is 1 if the search does not converge, and 3 if the model does not describe the
    data within their noise, if this cannot be decided, if a value contradicts its prior, or if the
    data of a sensor whose gain or delay is free contain no pulse.  With --defects, the fit is
    printed before the search begins; if that finds a gap or an odd ball, the fit that includes it
    follows, and the exit code, --out, --plot and --sample refer to this fit.  The same holds for
    the fit with the best of --laws if the data reject the law of the chain file.  All results are
    printed and written before sampling begins, so only the posterior is lost if sampling is
    interrupted; with --json, they are printed at the end.  If the model does not describe the data,
    further fits look for the cause after the fit is printed and written; Ctrl-C ends them, and
    --no-diagnosis omits them.

    \b
    Examples:
      hertzchain fit data.csv experiment.toml
      hertzchain fit fast.csv slow.csv experiment.toml --plot fit.png --out fitted.toml
      hertzchain fit scope.csv experiment.toml --sensor CH1=wall
      hertzchain fit ch1.csv ch2.csv experiment.toml --channels --sensor ch1.csv=wall \\
          --sensor "ch2.csv=ball 5"
      hertzchain fit scope.csv experiment.toml --sensor CH2=wall --time-offset -50us
      hertzchain fit data.csv experiment.toml --free stiffness --free loss.time --laws all
    """
    import hertzchain

    from ..fitting.diagnosis import without_tested

    if len(files) < 2:
        raise click.UsageError("give at least one CSV file of traces and, last, the chain file")
    check_writable(out, "--out", (".toml",))
    check_chain_file(files[-1])
    places = sensors_from(sensors)
    noise: Any = noise_from(noises)
    traces = hertzchain.load_traces(*files[:-1], sensors=places, channels=channels, noise=noise)
    traces = part_of(traces, begin, until)
    settings: dict[str, Any] = {
        "free": list(free) or None, "also_free": list(also_free) or None,
        "priors": priors_from(priors), "start": start_from(starting_values),
        "time_offset": time_offset_from(time_offset),
    }  # fmt: skip
    postponed = PostponedDiagnosis()
    result = _first_fit(traces, files[-1], postponed, starts, settings)
    tested = _tested(laws=laws is not None, defects=defects)
    result = without_tested(result, *tested)
    document = result.as_dict()
    # The search for defects takes long and may be stopped.
    shown = _show_first(result, laws) if defects and not as_json else None
    lines: list[str] = []
    found = Found(result)
    if laws is not None:
        found.result, lines = _laws(result, document, laws, files[-1], settings)
    if defects:
        found = _searched(found.result, document, tested, postponed if diagnosis else None)
        lines += found.lines
    # Sampling and diagnosis take long and may be stopped: the rest is printed and written before.
    if not as_json:
        if found.result is not shown:
            first = (*_summary(found.result, laws), *_pressures(found.result))
            lines.insert(0, "\n".join(first))
        click.echo(on_command_line(("\n" if shown else "") + "\n\n".join(lines)))
    _write_files(found, out, plot)
    if diagnosis and not defects and postponed.left and not found.result.describes:
        advised = cause_of_misfit(found.result, document, postponed, as_json=as_json)
        found.result = without_tested(advised, *tested)
        add_advice(found.result, document, first=result, as_json=as_json)
    _end(found.result, document, sample, plot, as_json=as_json)
    return _exit_code(found.result)


@dataclass
class Found:
    """The result of a search for defects, the lines that it prints, its scans and fits."""

    result: FitResult
    lines: list[str] = field(default_factory=list)
    scans: list[DefectScan] = field(default_factory=list)
    fits: dict[str, FitResult] = field(default_factory=dict)


def _searched(
    result: FitResult, document: dict[str, Any], tested: Sequence[str],
    postponed: PostponedDiagnosis | None,
) -> Found:  # fmt: skip
    """Search for defects, unless another cause is known, and for other causes without success."""
    from ..fitting.diagnosis import without_tested

    if result.explained:
        return Found(result, [HELD_BACK])
    best, scans, lines, fits = _defects(result, document, tested)
    if not fits and postponed is not None:
        advised = without_tested(postponed.diagnosed(result), *tested)
        document |= advised.as_dict()
        lines = [*(each for each in advised.advice if each not in result.advice), *lines]
    return Found(best, lines, scans, fits)


def _first_fit(
    traces: Traces, chain: Path, postponed: PostponedDiagnosis, starts: int,
    settings: dict[str, Any],
) -> FitResult:  # fmt: skip
    """The fit of the chain of the file, of whose diagnosis most is postponed."""
    from ..fitting.fit import fit_experiment

    # The number of simulations is not known in advance.
    with progress_bar("simulations", counted=False) as progress:
        return fit_experiment(
            traces, chain, postponed.quickly, starts=starts, progress=progress, **settings
        )


def _write_files(found: Found, out: Path | None, plot: Path | None) -> None:
    """Write the fitted chain and the figures of a fit."""
    if out is not None:
        from ..store.writing import write_bytes

        write_bytes(out, found.result.chain_toml().encode())
    if plot is not None:
        _save_plots(found.result, plot, found.scans, found.fits)


def _end(
    result: FitResult, document: dict[str, Any], sample: int | None, plot: Path | None, *,
    as_json: bool,
) -> None:  # fmt: skip
    """Sample the posterior, and print the fit as JSON."""
    if sample is not None:
        posterior = _posterior(result, sample, plot)
        document["posterior"] = _document(posterior)
        if not as_json:
            click.echo(f"\n{posterior.summary()}")
    if as_json:
        show_json(document)


def _show_first(result: FitResult, laws: str | None) -> FitResult:
    """Print the fit without a defect, and return it."""
    show_text(on_command_line("\n".join((*_summary(result, laws), *_pressures(result)))))
    return result


def _exit_code(result: FitResult) -> int:
    """Whether the fit has converged, describes the data and agrees with its priors."""
    if not result.converged and not result.meaningless:
        return FAILED
    good = result.describes and not (result.prior_conflict or result.undetermined)
    return DONE if good and not result.meaningless else OUTSIDE_TOLERANCE


def _document(posterior: Posterior) -> dict[str, Any]:
    """Plain values for JSON."""
    return {
        "mean": posterior.means, "error": posterior.errors, "long_enough": posterior.long_enough
    }  # fmt: skip


def _laws(
    result: FitResult, document: dict[str, Any], laws: str, chain: Path, settings: dict[str, Any]
) -> tuple[FitResult, list[str]]:
    """Compare loss laws; returns the fit with the best one if the data reject that of the chain."""
    import hertzchain

    from ..fitting.loss_comparison import DEFAULT_LAWS, law_of, rejected_law

    names = list(DEFAULT_LAWS) if laws == "all" else names_from(laws) or []
    own = law_of(result.chain)
    more = [own] if own is not None and own.name not in names else []
    with progress_bar("laws fitted") as progress:
        compared = hertzchain.compare_losses(
            result.traces, chain, laws=[*names, *more], progress=progress, **settings
        )
    document["comparison"] = compared.as_dict()
    lines = [compared.summary(width=None)]
    lines += [f"{each.name}, the law of the chain file, is compared, too" for each in more]
    if rejected := rejected_law(compared, result.chain):
        lines.append(
            f"the fit above is that with {compared.fits[0].law}, because the data reject the law "
            f"of the chain file, {rejected}"
        )
        result = compared.best
        document["fit_with_best_law"] = result.as_dict()
    return result, lines


def _summary(result: FitResult, laws: str | None) -> list[str]:
    """Lines of the summary, without the advice to compare loss laws if they are compared."""
    lines = result.summary(width=None).splitlines()
    return lines if laws is None else [line for line in lines if line != result._loss_note]


def _tested(*, laws: bool, defects: bool) -> list[str]:
    """Causes of residuals that the command tests, so that its advice omits them."""
    from ..fitting.advice import DEFECTS, LAWS

    return [*([LAWS] if laws else []), *([DEFECTS] if defects else [])]


def _defects(
    result: FitResult, document: dict[str, Any], tested: Sequence[str]
) -> tuple[FitResult, list[DefectScan], list[str], dict[str, FitResult]]:
    """Scan for a gap or odd ball and fit it; the last fit, the scans, lines, and all fits."""
    import hertzchain

    from ..fitting.defect_fits import candidates_of, fits_of_defect, not_determined
    from ..fitting.defect_scan import defect_names
    from ..fitting.diagnosis import diagnosed, without_tested
    from ..fitting.fit import fitted
    from ..fitting.goodness import NO_ERRORS

    scans = []
    steps = (("gap", "step 1 of 4, contacts tried"), ("bead", "step 2 of 4, balls tried"))
    for kind, what in steps:
        names = defect_names(result, kind)
        with progress_bar(trying(what, names), rate=True) as progress:
            scans.append(hertzchain.scan_defects(result, kind, progress=progress))
    document["defects"] = [
        {"name": name, "value": float(size), "chi2_improvement": float(gained)}
        for scan in scans
        for name, size, gained in zip(scan.names, scan.sizes, scan.improvements, strict=True)
    ]
    found: dict[str, FitResult] = {}
    others: dict[str, list[FitResult]] = {}
    for scan, (step, what) in zip(scans, ((3, "gaps"), (4, "odd balls")), strict=True):
        if scan.found:
            words = trying(f"step {step} of 4, {what} fitted", candidates_of(scan))
            with progress_bar(words, rate=True) as progress:
                found[scan.kind], *others[scan.kind] = fits_of_defect(scan, progress=progress)
    if not found:
        return result, scans, [scan.summary(width=None) for scan in scans], found
    kind = min(found, key=lambda each: found[each].chi2 + found[each]._penalty)
    best = without_tested(diagnosed(found[kind], {}, fitted), *tested)
    document["fit_with_defect"] = best.as_dict()
    # The errors above are those of the fit with the defect.
    verdict = result.verdict.removesuffix(NO_ERRORS)
    scans.sort(key=lambda scan: scan.kind != kind)
    return (
        best,
        scans,
        [
            scans[0].summary(width=None),
            *other_place(scans[0], best),
            *not_determined(scans[0], best, others[kind]),
            *(other_kind(scan, found.get(scan.kind), best) for scan in scans[1:]),
            f"without {best.names[-1]}: {verdict}",
        ],
        found | {kind: best},
    )


def _pressures(result: FitResult) -> list[str]:
    """A line with the largest pressure in all shots, if it is known and below the limit."""
    import hertzchain

    if result.meaningless:
        return []
    shots = zip(result.chains, result.traces.shots, strict=True)
    with ignore_warnings():  # the notes of the fit have the violations
        runs = [
            hertzchain.simulate(
                chain, until=float(shot.times[-1] - shot.times[0]), times=2, check=False
            )
            for chain, shot in shots
        ]
    return pressures_below_yield(*runs)


def _posterior(result: FitResult, steps: int, plot: Path | None) -> Posterior:
    """Sample the posterior and, if there is a file for figures, save the corner plot."""
    from ..fitting.posterior import steps_needed

    needed = steps_needed(len(result.names))
    if steps < needed:
        click.echo(
            f"{len(result.names)} parameters need about {needed} steps, more than --sample {steps}",
            err=True,
        )
    with progress_bar("steps of the walkers", rate=True) as progress:
        posterior = result.sample(steps, progress=progress)
    if plot is not None:
        _save_figure(posterior.plot(), plot, "-corner")
    return posterior


def _save_plots(
    result: FitResult, plot: Path, scans: Sequence[DefectScan], fits: Mapping[str, FitResult]
) -> None:
    from ..plotting.defects import plot_fitted_defects

    if scans:
        _save_figure(plot_fitted_defects(scans, fits), plot, "-defects")
    _save_figure(result.plot(), plot)
    _save_figure(result.plot_residuals(), plot, "-residuals")
    _save_figure(result.plot_correlations(), plot, "-correlations")


def _save_figure(figure: Figure, plot: Path, suffix: str = "") -> None:
    save_figure(figure.axes[0], plot.with_name(f"{plot.stem}{suffix}{plot.suffix}"))
