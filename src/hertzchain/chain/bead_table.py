"""Table of the beads of a chain."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .bead_names import CAP
from .chain import Chain
from .drawn_bodies import body_centres, flat_bodies

if TYPE_CHECKING:
    import pandas as pd


def bead_table(chain: Chain) -> pd.DataFrame:
    """One row per bead, with the units of the columns in ``attrs``."""
    import pandas as pd

    numbers = range(1, chain.beads + 1)
    # The radius of a flat body is only that from which its mass was computed.
    radii = np.where(flat_bodies(chain), np.nan, chain.radii)
    columns: dict[str, object] = {}
    if chain.strikers or chain.cap is not None:
        columns["name"] = [_name(chain, k) for k in numbers]
    if chain.materials is not None:
        columns["material"] = [each.name for each in chain.materials]
    columns |= {
        "radius": radii, "diameter": 2.0 * radii, "mass": chain.masses,
        "position": body_centres(chain), "gap": np.append(chain.gaps, np.nan),
        "velocity": chain.velocities,
    }  # fmt: skip
    if chain.right_wall is not None:
        columns["gap"] = np.append(chain.gaps, chain.right_wall.gap)
    table = pd.DataFrame(columns, index=pd.Index(numbers, name="bead"))
    units = dict.fromkeys(("radius", "diameter", "position", "gap"), "m")
    units |= {"mass": "kg", "velocity": "m/s"}
    table.attrs["units"] = {
        name: "1" if chain.scaled else units[name] for name in columns if name in units
    }
    return table


def _name(chain: Chain, bead: int) -> str:
    if bead <= chain.strikers:
        return "striker" if chain.strikers == 1 else f"striker {bead}"
    last = bead == chain.beads and chain.cap is not None
    return CAP if last else f"ball {bead - chain.strikers}"
