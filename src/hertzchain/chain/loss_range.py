"""Compare a chain with the range of its laws of loss."""

from __future__ import annotations

import numpy as np

from ..collision import compression_time
from ..errors import ModelRangeWarning, warn_user
from ..representation import measure
from .chain import Chain


def warn_outside_losses(chain: Chain) -> None:
    """Warn about relaxation times that exceed the duration of every contact at time 0.

    The law of viscoelastic contacts is the first order in the relaxation time over the duration.
    """
    speed = float(np.ptp(chain.velocities)) or float(np.abs(chain.velocities).max())
    if speed == 0.0:
        return
    for group in chain.contact_groups:
        law, present = group.law, np.flatnonzero(group.contacts.stiffness > 0.0)
        if law.relaxation_time == 0.0 or not present.size:
            continue
        some = group.contacts.only(present)
        lasts = 2.0 * compression_time(some.reduced_mass, some.stiffness, speed, some.exponent)
        longest = int(np.argmax(lasts))
        if law.relaxation_time > lasts[longest]:
            time, duration = (
                measure(float(each), "s", chain.units)
                for each in (law.relaxation_time, lasts[longest])
            )
            warn_user(
                f"the relaxation time {time} of {type(law).__name__} exceeds the duration of its "
                f"contacts, at most {duration} without loss (contact "
                f"{group.index[present[longest]]}, at {measure(speed, 'm/s', chain.units)}); the "
                "law requires a much shorter time: check its unit",
                ModelRangeWarning,
            )
