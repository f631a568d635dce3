"""Write the tables that `hertzchain.theory.universal_functions` reads."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Final

import numpy as np

from hertzchain import __version__
from hertzchain.collision import Array
from hertzchain.theory.packed_tables import STEPS, pack
from hertzchain.theory.universal_functions import (
    FAST_ARGUMENTS,
    FAST_VALUES,
    STAGES,
    STATE,
    TERMS,
)

from .response_fit import KNOTS, Anchors
from .training_chains import NODES, RTOLS

# Terms of the estimated error, in the order of `hertzchain.kernels.error_terms.write_parts`.
PARTS: Final = [
    "one", "exponential", "start", "impact", "deviations", "third degree", "a^3", "a^2 q",
    "a^2 b^2", "fading", "fading, steep", "end b^2", "end a^2", "end, short", "maxima",
    "jagged",
]  # fmt: skip


def write_tables(folder: Path, anchors: Anchors, found: Array) -> None:
    """Write the tables of slow changes of an exponent."""
    folder.mkdir(parents=True, exist_ok=True)
    names = [f"{stage} {name}" for stage in STAGES for name in STATE]
    rows = anchors.values.reshape(len(NODES), -1)
    _write(
        folder / "exponential.csv",
        "State of each stage on exponential chains of rate s; growth beyond that of the BCA.",
        ["s", *names],
        [
            [f"{s:g}", *(f"{value:.9f}" for value in row)]
            for s, row in zip(NODES, rows, strict=True)
        ],
    )
    listed: list[list[str]] = [["", "", "knots", *(f"{knot:g}" for knot in KNOTS), "", ""]]
    for i, stage in enumerate(STAGES):
        for j, term in enumerate(TERMS):
            for o, name in enumerate(STATE):
                if found[i, j, :, o].any():
                    listed.append([stage, name, term, *(f"{c:.6g}" for c in found[i, j, :, o])])
    _write(
        folder / "response.csv",
        "Response of the state to deviations: coefficients of cubic B-splines in s.",
        ["stage", "state", "term", *(f"c{n}" for n in range(1, found.shape[2] + 1))],
        listed,
    )


def write_fast(folder: Path, measured: dict[str, Array]) -> None:
    """Write the tables of fast changes of an exponent."""
    np.savez_compressed(
        folder / "fast.npz",
        **{name: measured[name] for name in FAST_ARGUMENTS},
        **{name: pack(measured[name], STEPS[name], 0) for name in FAST_VALUES},
    )


def write_error(folder: Path, error: Array) -> None:
    """Write the constants of the estimated error of an exponent."""
    _write(
        folder / "error.csv",
        "Constants of the estimated error of velocity, found on random chains not used in the fit.",
        PARTS,
        [[f"{value:.3g}" for value in error]],
    )


def _write(file: Path, title: str, names: list[str], rows: list[list[str]]) -> None:
    with file.open("w", encoding="utf-8", newline="") as text:
        text.write(f"# {title}\n# Written by python -m training, hertzchain {__version__}")
        text.write(f"; integrated with rtol = {RTOLS[0]:g}.\n")
        csv.writer(text, lineterminator="\n").writerows([names, *rows])
