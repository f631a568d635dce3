r"""Tables of the disorder law: mean and variance over random chains, on exponential chains.

`tools/disorder_tables.py` determines them from ensembles of simulated pulses.
"""

from __future__ import annotations

import csv
import functools
from dataclasses import dataclass
from importlib import resources
from typing import Final

import numpy as np

from ..collision import Array

# Rates of the exponential chains, and scatters of the radii.
RATES: Final = (
    -0.1, -0.05, -0.03, -0.02, -0.01, -0.005, -0.0025, -0.001, 0.0,
    0.001, 0.0025, 0.005, 0.01, 0.02, 0.03, 0.05, 0.1,
)  # fmt: skip
SCATTERS: Final = (0.0005, 0.001, 0.002, 0.005, 0.01, 0.02, 0.03)
# Contacts that depend on the impact, and on the free end.
START, END = 6, 2
STAGES: Final = (*(f"start {k + 1}" for k in range(START)), "within",
                 *(f"end {END - k}" for k in range(END)))  # fmt: skip
MEANS: Final = ("s", "scatter", *(f"{of}, {stage}" for of in ("velocity", "force", "time")
                                  for stage in STAGES))  # fmt: skip
_SPLIT: Final = (*STAGES[:START], "start", *STAGES[START:])
SPREADS: Final = ("s", *(f"{of}, {stage}" for of in ("velocity", "force")
                         for stage in _SPLIT))  # fmt: skip
# Contacts whose residence times depend on the impact, and beads around a contact.
DELAYED: Final = 8
OFFSETS: Final = range(-10, 3)
DELAYS: Final = ("s", *(f"{stage}, {offset}"
                        for stage in (*(f"start {k + 1}" for k in range(DELAYED)), "within", "end")
                        for offset in OFFSETS),
                 *(f"bead {j + 1}" for j in range(len(OFFSETS))))  # fmt: skip


@dataclass(frozen=True, eq=False)
class DisorderTables:
    """Means and variances over random chains, in units of the squared scatter, by rate.

    Attributes
    ----------
    means : ndarray, shape (scatters, rates, 3, stages)
        Loss of ln v per contact, and the offsets of ln F and ln T.
    velocity, force : ndarray, shape (rates, stages + 1)
        Variances: total of the early stages, part from the beads near the impact, part from the
        beads around the pulse.
    delay : ndarray, shape (rates, stages, offsets)
        Derivatives of ln T with respect to ln R or ln E of the beads around the contact, for the
        early contacts, those within and the last one; and finally those of the later contacts
        with respect to the first beads.
    """

    means: Array
    velocity: Array
    force: Array
    delay: Array

    def mean(self, scatter: float, rates: Array) -> Array:
        """Means at a scatter and each contact's rate, shape (contacts, 3, stages)."""
        from scipy.interpolate import PchipInterpolator

        table = self.means[0]
        if len(self.means) > 1:
            at = min(max(np.log(scatter), np.log(SCATTERS[0])), np.log(SCATTERS[-1]))
            table = PchipInterpolator(np.log(SCATTERS), self.means)(at)
        return np.asarray(PchipInterpolator(RATES, table)(rates))

    def at(self, name: str, rates: Array) -> Array:
        """``velocity``, ``force`` or ``delay`` at each rate."""
        from scipy.interpolate import PchipInterpolator

        return np.asarray(PchipInterpolator(RATES, getattr(self, name))(rates))


@functools.cache
def disorder_tables() -> dict[str, DisorderTables]:
    """Tables for scatter of ``"radii"`` and of ``"moduli"``."""
    means, spreads = _read("means.csv", MEANS), _read("spreads.csv", SPREADS)
    delays = _read("delays.csv", DELAYS)[:, 1:].reshape(len(RATES), 2, -1, len(OFFSETS))
    rates = len(RATES)
    values = means[:, 2:].reshape(rates, 1 + len(SCATTERS), 3, len(STAGES))
    spreads = spreads[:, 1:].reshape(rates, 2, -1)
    found = {}
    for kind, name in enumerate(("radii", "moduli")):
        chosen = values[:, -1:] if kind else values[:, :-1]
        velocity, force = np.split(spreads[:, kind], 2, axis=1)
        found[name] = DisorderTables(
            np.moveaxis(chosen, 1, 0),
            velocity,
            force,
            delays[:, kind],
        )
    return found


def _read(name: str, header: tuple[str, ...]) -> Array:
    path = resources.files("hertzchain.theory") / "disorder_tables" / name
    lines = path.read_text(encoding="utf-8").splitlines()
    names, *rows = csv.reader(line for line in lines if not line.startswith("#"))
    if tuple(names) != tuple(",".join(header).split(",")):
        raise RuntimeError(f"{name} does not have the columns of this version")
    return np.array(rows, dtype=float)
