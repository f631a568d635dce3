"""Write a reproduction to disk: report, verdict, summary, figures and their data.

====================  =========================================================
`report.html`         a self-contained page with tables, figures, errata and method
`verdict.json`        all results as JSON; ``schema_version`` increases with changes
`summary.md`          a short summary
`figures/`            each figure as SVG and PNG, and its data as CSV
`.hertzchain.json`    checksums of these files, which show whether a file was changed
====================  =========================================================
"""

from __future__ import annotations

import base64
import functools
import importlib.metadata
import json
import platform
import re
import tempfile
from concurrent.futures import Executor
from pathlib import Path
from typing import Any, Final

from jinja2 import Environment, PackageLoader, select_autoescape
from matplotlib.figure import Figure as MatplotlibFigure

from ..chain.tapers import rate_symbol
from ..evaluation.cases import GROUPS
from ..evaluation.scoreboard import QUANTITIES, Scoreboard
from ..evaluation.scoreboard_rows import percentage
from ..plotting.scoreboard import plot_scoreboard
from ..representation import listed
from ..store.writing import cannot_write
from ..validation.keywords import checked_arguments
from ..validation.objects import Progress
from ..verification.case import ORIGINS
from ..verification.verify import as_dict
from .drawings import Drawing, drawn
from .figures import Figure, draw_figure, figure_csv
from .mathml import plain, typeset
from .report_folder import HINT, WRITING, earlier_figures, move_report, reserved
from .reproduction import Reproduction
from .tables import WINDOWS, Table
from .velocity_formulas import draw_formula_errors

SCHEMA_VERSION: Final = 1


@checked_arguments("write_report")
def write_report(
    reproduction: Reproduction,
    out: Path,
    *,
    progress: Progress | None = None,
) -> Path:
    """Write the report of a reproduction to a folder.

    All files are first written to a temporary folder and then moved; an earlier report
    therefore stays complete if writing fails.  Figures of an earlier report that are not part
    of this one are kept.

    Raises
    ------
    InputError
        If the folder contains files but was not written by `write_report`, or if a file that
        the report would replace has been changed.
    """
    with reserved(out, reproduction.parts):
        return write_reserved(reproduction, out, progress=progress)


def write_reserved(
    reproduction: Reproduction,
    out: Path,
    *,
    progress: Progress | None = None,
    pool: Executor | None = None,
) -> Path:
    """Write a report to a folder that is `reserved`; a pool of processes draws figures, too."""
    try:
        with tempfile.TemporaryDirectory(dir=out, prefix=WRITING) as folder:
            fresh = Path(folder)
            images = _write_figures(reproduction, fresh / "figures", progress, pool)
            earlier = earlier_figures(out, reproduction.parts)
            _write_pages(reproduction, fresh, images, earlier)
            move_report(fresh, out, reproduction.parts)
    except OSError as error:
        raise cannot_write(out, error, HINT) from None
    return out / "report.html"


def _write_pages(
    reproduction: Reproduction, folder: Path, images: dict[str, str], earlier: list[str]
) -> None:
    plain = json.dumps(verdict(reproduction), indent=2, allow_nan=False) + "\n"
    (folder / "verdict.json").write_text(plain, "utf-8")
    (folder / "summary.md").write_text(
        _render("summary.md.j2", reproduction, earlier=earlier), "utf-8"
    )
    page = _render("report.html.j2", reproduction, images=images, earlier=earlier)
    (folder / "report.html").write_text(page, "utf-8")


@checked_arguments("verdict")
def verdict(reproduction: Reproduction) -> dict[str, Any]:
    """Content of ``verdict.json``."""
    return {
        "schema_version": SCHEMA_VERSION,
        "within_tolerance": reproduction.within_tolerance,
        "verdict": reproduction.verdict,
        "tables": {
            table.published.name: {
                "window": list(table.window),
                "entries": [
                    {
                        "taper": entry.taper,
                        "column": entry.column,
                        "rate": entry.rate,
                        "printed": entry.printed.text,
                        "ours": entry.ours,
                        "units_of_last_digit": entry.units,
                        "tolerance": entry.tolerance,
                        "agrees": entry.agrees,
                    }
                    for entry in table.entries
                ],
            }
            for table in reproduction.tables
        },
        "figures": {
            figure.published.name: {
                "claim": figure.statement.claim,
                "measured": figure.statement.measured,
                "bounds": [figure.statement.low, figure.statement.high],
                "holds": figure.statement.holds,
                "order_as_captioned": figure.order_as_captioned,
            }
            for figure in reproduction.figures
        },
        "errata": [
            {
                "place": plain(erratum.place),
                "printed": plain(erratum.printed),
                "follows": plain(erratum.follows),
                "concerns": list(erratum.concerns),
                "inference": erratum.inference,
                "evidence": dict(erratum.evidence),
            }
            for erratum in reproduction.errata
        ],
        "scoreboard": reproduction.scoreboard.as_dict("family") if reproduction.scoreboard else {},
        "verification": as_dict(reproduction.verification)["cases"],
        "method": method(reproduction),
    }


def method(reproduction: Reproduction) -> dict[str, Any]:
    """Integrator, tolerance, windows, versions and time of a reproduction."""
    packages = ("hertzchain", "numpy", "scipy", "numba", "matplotlib")
    return {
        "integrator": "RKN8(6), all beads, step errors relative to the speeds of nearby beads",
        "rtol": reproduction.rtol,
        "beads": reproduction.beads,
        "chains": len(reproduction.pulses),
        "energy_drift": reproduction.energy_drift,
        "momentum_drift": reproduction.momentum_drift,
        "windows": {fit: list(window) for fit, window in reproduction.windows.items()},
        "seconds": round(reproduction.seconds, 3),
        "python": platform.python_version(),
        "versions": {package: importlib.metadata.version(package) for package in packages},
    }


def _write_figures(
    reproduction: Reproduction,
    folder: Path,
    progress: Progress | None,
    pool: Executor | None,
) -> dict[str, str]:
    """Save all figures; return them as data URLs for the page."""
    folder.mkdir()
    drawings: dict[str, Drawing] = {}
    board = reproduction.scoreboard
    if board is not None:
        drawings["scoreboard"] = Drawing(_draw_scoreboard, board)
        (folder / "scoreboard.csv").write_text(board.to_dataframe().to_csv(index=False), "utf-8")
    if reproduction.all_errata:
        drawings["errata"] = Drawing(draw_formula_errors, reproduction.pulses)
    for figure in reproduction.figures:
        name = figure.published.name
        drawings[name] = Drawing(draw_figure, figure)
        (folder / f"{name}.csv").write_text(figure_csv(figure), "utf-8")
    images = {}
    for done, (name, (vector, pixels)) in enumerate(drawn(drawings, pool), start=1):
        (folder / f"{name}.svg").write_bytes(vector)
        (folder / f"{name}.png").write_bytes(pixels)
        encoded = base64.b64encode(vector).decode("ascii")
        images[name] = f"data:image/svg+xml;base64,{encoded}"
        if progress is not None:
            progress(done, len(drawings))
    return images


def _draw_scoreboard(board: Scoreboard) -> MatplotlibFigure:
    canvas = plot_scoreboard(board).figure
    assert isinstance(canvas, MatplotlibFigure)
    return canvas


@functools.cache
def _templates() -> Environment:
    loader = PackageLoader("hertzchain.paper", "templates")
    environment = Environment(
        loader=loader,
        autoescape=select_autoescape(["html.j2", "html"]),
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["describe"] = _measured
    environment.filters["minus"] = _with_minus
    environment.filters["typeset"] = typeset
    environment.filters["plain"] = plain
    return environment


def _render(template: str, reproduction: Reproduction, **more: Any) -> str:
    return _templates().get_template(template).render(
        reproduction=reproduction,
        method=method(reproduction),
        rate_symbol=rate_symbol,
        rows=_rows,
        scores=_scores(reproduction.scoreboard) if reproduction.scoreboard else None,
        origins=ORIGINS,
        listed=listed,
        default_windows=dict(reproduction.windows) == WINDOWS,
        **more,
    )  # fmt: skip


def _scores(board: Scoreboard) -> dict[str, list[tuple[str, list[tuple[str, list[str]]]]]]:
    """Cells of the scoreboard's two tables, in groups of labelled rows."""
    errors, outside = board.table("velocity"), board.outside()
    families: dict[str, list[tuple[str, list[str]]]] = {}
    for label, members in board.rows("family").items():
        cells = [
            percentage(error) + ("*" if warned and error == error else "")
            for error, warned in zip(errors.loc[label], outside.loc[label], strict=True)
        ]
        heading = GROUPS[board.cases[members[0]].group]
        families.setdefault(heading, []).append((label, cells))
    groups: dict[str, list[tuple[str, list[str]]]] = {GROUPS[group]: [] for group in GROUPS}
    for quantity in QUANTITIES:
        for group, row in board.table(quantity, by="group").iterrows():
            cells = [percentage(error) for error in row]
            groups[GROUPS[group]].append((quantity.replace("_", " "), cells))
    return {"families": list(families.items()), "groups": list(groups.items())}


def _rows(table: Table) -> list[list[Any]]:
    """Rows of a table: one row per rate, with the columns of both tapers."""
    by_rate: dict[float, list[Any]] = {}
    for entry in table.entries:
        by_rate.setdefault(entry.rate, []).append(entry)
    return list(by_rate.values())


def _with_minus(text: object) -> str:
    """Text with true minus signs in front of numbers and in their exponents."""
    return re.sub(r"(?<!\w)-(?=\d)|(?<=\de)-(?=\d)", "−", str(text))


def _measured(figure: Figure) -> str:
    """Measured value of a statement, or the range of several values."""
    values = figure.statement.measured.values()
    low, high = min(values), max(values)
    return f"{low:.4g}" if low == high else f"{low:.4g} to {high:.4g}"
