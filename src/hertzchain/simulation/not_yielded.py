"""Statement that laws with a yield point have not changed a run."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from ..chain.chain import Chain
    from ..collision import Array

NOT_YIELDED: Final = "no contact has yielded"


def elastic_in_words(chain: Chain, overlaps: Array) -> str:
    """State that no contact has yielded; empty if one has, or if no law has a yield point."""
    if not any(law.yields for law in chain.contact_losses):
        return ""
    # The command line states its help without numpy.
    import numpy as np

    from ..chain.contact_groups import law_yield_ratios

    ratios = law_yield_ratios(chain.contact_groups, overlaps)
    known = ratios[np.isfinite(ratios)]
    return NOT_YIELDED if len(known) and known.max() < 1.0 else ""
