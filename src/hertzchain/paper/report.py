"""Write a reproduction to disk: report, verdict, summary, figures and their data.

====================  =========================================================
`report.html`         a self-contained page with tables, figures, errata and method
`verdict.json`        all results as JSON; ``schema_version`` is increased by changes
`summary.md`          a short summary
`figures/`            each figure as SVG and PNG, and its data as CSV
====================  =========================================================
"""

from __future__ import annotations

import base64
import contextlib
import functools
import importlib.metadata
import json
import os
import platform
import re
import shutil
import tempfile
from collections.abc import Iterator
from concurrent.futures import Executor
from pathlib import Path
from typing import Any, Final

from jinja2 import Environment, PackageLoader, select_autoescape
from matplotlib.figure import Figure as MatplotlibFigure

from ..chain.tapers import rate_symbol
from ..errors import InputError
from ..evaluation.cases import GROUPS
from ..evaluation.scoreboard import QUANTITIES, Scoreboard, percentage
from ..plotting.scoreboard import plot_scoreboard
from ..store.file_lock import lock
from ..store.writing import cannot_write
from ..validation.keywords import checked_arguments
from ..validation.objects import Progress
from ..verification.case import ORIGINS
from ..verification.verify import as_dict
from .drawings import Drawing, drawn
from .figures import Figure, draw_figure, figure_csv
from .mathml import plain, typeset
from .reproduction import Reproduction
from .tables import WINDOWS, Table
from .velocity_formulas import draw_formula_errors

SCHEMA_VERSION: Final = 1
PAGES: Final = ("report.html", "verdict.json", "summary.md")
WRITING: Final = ".writing-"
# Names given by `tempfile`.
LEFT_BEHIND: Final = re.compile(rf"{re.escape(WRITING)}[a-z0-9_]{{8}}")
OUR_FIGURE: Final = re.compile(r"(figure\d+|errata|scoreboard)\.(svg|png|csv)")


@checked_arguments("write_report")
def write_report(
    reproduction: Reproduction,
    out: Path,
    *,
    progress: Progress | None = None,
) -> Path:
    """Write the report of a reproduction to a folder.

    All files are first written to a temporary folder and then moved, so that an earlier
    report stays complete if writing fails.
    """
    with reserved(out):
        return write_reserved(reproduction, out, progress=progress)


@contextlib.contextmanager
def reserved(out: Path) -> Iterator[None]:
    """Lock a folder, and remove temporary folders of processes that were killed."""
    check_writable(out)
    with lock(out / ".lock", out):
        for left in out.glob(f"{WRITING}*"):
            if _is_ours(left):
                shutil.rmtree(left, ignore_errors=True)
        yield


def _is_ours(folder: Path) -> bool:
    """Whether a folder is the temporary folder of a process that was killed."""
    if folder.is_symlink() or not LEFT_BEHIND.fullmatch(folder.name):
        return False
    files = [path for path in folder.rglob("*") if not path.is_dir()]
    pages = [folder / name for name in PAGES]
    figures = folder / "figures"
    return all(
        file in pages or (file.parent == figures and OUR_FIGURE.fullmatch(file.name))
        for file in files
    )


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
            _write_pages(reproduction, fresh, images)
            _replace(fresh, out)
    except OSError as error:
        raise cannot_write(out, error, "choose another folder with --out") from None
    return out / "report.html"


def _write_pages(reproduction: Reproduction, folder: Path, images: dict[str, str]) -> None:
    plain = json.dumps(verdict(reproduction), indent=2, allow_nan=False) + "\n"
    (folder / "verdict.json").write_text(plain, "utf-8")
    (folder / "summary.md").write_text(_render("summary.md.j2", reproduction), "utf-8")
    page = _render("report.html.j2", reproduction, images=images)
    (folder / "report.html").write_text(page, "utf-8")


def _replace(fresh: Path, out: Path) -> None:
    """Replace an old report by a new one; other files in the folder are not changed."""
    figures = out / "figures"
    figures.mkdir(exist_ok=True)
    for path in figures.iterdir():
        if OUR_FIGURE.fullmatch(path.name):
            path.unlink()
    for path in (fresh / "figures").iterdir():
        path.replace(figures / path.name)
    for name in PAGES:
        (fresh / name).replace(out / name)


def check_writable(out: Path) -> None:
    """Create a folder and check that files can be written to it."""
    blocked = [name for name in PAGES if (out / name).is_dir()]
    if (out / "figures").exists() and not (out / "figures").is_dir():
        blocked.append("figures")
    if blocked:
        raise InputError(
            f"{os.fspath(out / blocked[0])!r} exists and cannot be replaced by the report; choose "
            "another folder with --out"
        )
    try:
        out.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=out):
            pass
    except OSError as error:
        raise cannot_write(out, error, "choose another folder with --out") from None


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
        # The cases of a scoreboard are functions, which cannot be sent to another process.
        drawings["scoreboard"] = Drawing(_draw_scoreboard, board, movable=False)
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


def _measured(figure: Figure) -> str:
    """Measured value of a statement, or the range of several values."""
    values = figure.statement.measured.values()
    low, high = min(values), max(values)
    return f"{low:.4g}" if low == high else f"{low:.4g} to {high:.4g}"
