"""The command `design`: search for a chain that does what a file requires."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from .chain_completion import complete_losses
from .exit_codes import DONE, OUTSIDE_TOLERANCE
from .interrupts import exit_soon
from .options import StrictCommand, check_writable, figure_option, json_option
from .output import save_figure, show_json
from .progress import progress_bar
from .wording import on_command_line
from .wrapped_text import show_text


@click.command(cls=StrictCommand)
@click.argument("file", type=click.Path(path_type=Path), metavar="FILE.toml")
@click.option(
    "--budget",
    metavar="SIZE",
    help="Number of simulations, or a time such as '60 s'.  [default: that of FILE, or 20000]",
)
@click.option(
    "--method",
    metavar="NAME",
    help="Method of the search.  For sizes: law, scan, hybrid, gradient or evolution.  For balls "
    "and their order: enumerate or genetic.  [default: that of FILE, or the one that suits the "
    "problem]",
)
@click.option("--seed", type=int, help="Seed of the random numbers.  [default: that of FILE, or 0]")
@click.option(
    "--store",
    type=click.Path(path_type=Path),
    metavar="FOLDER",
    help="Folder for the records of trials, from which an interrupted search resumes.  "
    "[default: the name of FILE with .design, in the working folder]",
)
@click.option("--threads", type=int, help="Number of threads.  [default: one per processor]")
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Write the chain that was found to FILE (.toml, or .csv with one row per bead).  The "
    "chains of a Pareto front are written to NAME-1.toml and so on.",
)
@click.option(
    "--dry-run",
    is_flag=True,
    help="Show the method, the values of the given chain and the estimated time, without a "
    "search.  The file is checked as for a search, with the same exit codes.",
)
@click.option(
    "--loss",
    metavar="LAW",
    shell_complete=complete_losses,
    help="Law of the loss in contacts, such as elastic-plastic, instead of that of FILE.",
)
@figure_option("Plot chains, forces, history and sensitivity to FILE.")
@json_option()
def design(
    file: Path, budget: str | None, method: str | None, seed: int | None, store: Path | None,
    threads: int | None, out: Path | None, dry_run: bool, loss: str | None,
    plot: Path | None, as_json: bool,
) -> int:  # fmt: skip
    """Search for a chain that minimises or maximises a quantity.

    The file is a chain file with a table [design]: the quantity, what may vary, and constraints.
    All trials are written to a folder.  If the search is interrupted, run the same command again
    and it resumes.

    Exit codes: 0 done, 2 the file or an option is invalid, 3 the constraints are not met by any
    chain that was found, or not if its contacts yield (at 1.6 or 2.8 times the yield strength),
    130 interrupted.

    \b
    Examples:
      hertzchain design absorber.toml --dry-run
      hertzchain design absorber.toml
      hertzchain design absorber.toml --budget '60 s' --plot design.png --out absorber-chain.toml
    """
    import hertzchain

    from ..designs.limits_if_yielding import met_if_yielding
    from ..designs.problem_files import read_design
    from .chain_changes import law_from

    check_writable(out, "--out", (".toml", ".csv"))
    problem, options = read_design(
        file, None if loss is None else lambda chain: chain.replace(loss=law_from(loss, chain))
    )
    given = {"budget": budget, "method": method, "seed": seed}
    options |= {name: value for name, value in given.items() if value is not None}
    if dry_run:
        return _show_estimate(problem, options | {"threads": threads}, as_json)
    target = Path(f"{file.stem}.design") if store is None else store
    unit = "simulations" if _counts(options.get("budget")) else "seconds"
    resume = f"trials are in {target}; run the same command again to resume"
    with progress_bar(unit, rate=unit == "simulations") as progress, exit_soon(resume):
        result = hertzchain.design(
            problem, store=target, threads=threads, progress=progress, **options
        )
    if result.method == "none":
        for missing in (out, plot):
            if missing is not None:
                click.echo(f"{missing} was not written, because there is no design", err=True)
    else:
        _write(result, out, plot)
    if as_json:
        show_json(result.as_dict())
    else:
        show_text(on_command_line(result.summary()))
    return DONE if met_if_yielding(result) else OUTSIDE_TOLERANCE


def _show_estimate(problem: Any, options: dict[str, Any], as_json: bool) -> int:
    from ..designs.bounds import note_on_impact
    from ..designs.design import dry_run
    from ..designs.dry_run import in_lines
    from ..validation.json_types import finite

    found = dry_run(problem, **options)
    code = DONE if found.impossible is None else OUTSIDE_TOLERANCE
    if not as_json:
        show_text(on_command_line(in_lines(problem, found)))
        return code
    show_json({
        "objectives": [*map(str, problem.objectives)],
        "method": found.method, "size": found.size, "compared": found.compared,
        "budget": finite({"simulations": found.budget.runs, "seconds": found.budget.seconds}),
        "simulations_per_trial": found.samples, "impossible": found.impossible,
        "values": finite(found.given), "pressure": found.pressure or None,
        "seconds_per_trial": found.trial, "seconds": found.seconds,
        "notes": note_on_impact(problem),
    })  # fmt: skip
    return code


def _counts(budget: Any) -> bool:
    """Whether a budget is a number of simulations."""
    from ..designs.search_budget import budget_from

    return budget_from(budget).runs < float("inf")


def _write(result: Any, out: Path | None, plot: Path | None) -> None:
    if out is not None:
        from ..store.writing import write_bytes

        numbered = [out.with_name(f"{out.stem}-{i}{out.suffix}")
                    for i in range(1, len(result.front) + 1)]  # fmt: skip
        for file, each in zip(numbered or [out], result.front or [result], strict=True):
            text = each.to_csv() if out.suffix == ".csv" else each.to_toml()
            write_bytes(file, text.encode())
    if plot is not None:
        from ..plotting.designs import plot_design

        save_figure(plot_design(result).axes[0], plot)
