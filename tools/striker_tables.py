"""Table of the effect of strikers, from simulated pulses: ``python tools/striker_tables.py FILE``.

Exponential chains are struck by bodies of different masses and contacts; the table has the
logarithms of velocity, overlap and residence time relative to those of the chain struck by the
bead that continues the taper.  The waves behind heavy strikers are those of equal beads.  About
one minute.
"""

import sys

import numpy as np
from scipy.interpolate import CubicSpline

import hertzchain as hc
from hertzchain.theory.striker_train import MASS_RATIOS, WAVES, particle_velocity
from hertzchain.theory.strikers import CONTACTS, LOG_MASSES, LOG_STIFFNESS, RATES

BEADS = CONTACTS + 20


def logarithms(rate, log_masses, log_stiffness):
    """Logarithms of velocity, overlap and residence time, by mass and contact of the striker."""
    chain = hc.Chain.from_radii(np.exp(rate * np.arange(BEADS)))
    chains = []
    for log_mass in log_masses:
        for log_k in log_stiffness:
            masses, stiffness = chain.masses.copy(), chain.stiffness.copy()
            masses[0] *= np.exp(log_mass)
            stiffness[0] *= np.exp(log_k)
            chains.append(chain.replace(masses=masses, stiffness=stiffness))
    table = hc.propagate_many(chains, rtol=1e-10, threads=1)
    columns = table.velocity[:, 1 : CONTACTS + 1], table.peak_overlap[:, :CONTACTS]
    every = np.stack([*columns, table.residence[:, :CONTACTS]], axis=1)
    return np.log(every).reshape(len(log_masses), len(log_stiffness), 3, CONTACTS)


def train(mass_ratio, beads=420, bead=130):
    """Factors of the velocities of successive waves, while they vary smoothly; then NaN."""
    chain = hc.Chain.uniform(beads).struck_by(mass=mass_ratio, radius=1.0)
    run = hc.simulate(chain, until=420.0, times=6000, rtol=1e-9)
    curve = CubicSpline(run.times, run.velocity(bead + 1))
    at = curve.derivative().roots(extrapolate=False)
    at = at[np.isfinite(at)]
    waves = curve(at[(curve(at, 2) < 0.0) & (curve(at) > 0.005)])[:WAVES]
    factors = waves / [particle_velocity(mass_ratio, n) for n in range(len(waves))]
    rough = np.flatnonzero(factors[1:] > 1.03 * factors[:-1]) + 1
    found = np.full(WAVES, np.nan)
    smooth = min([len(waves), *rough]) if mass_ratio > 1.6 else min(len(waves), 2)
    found[:smooth] = factors[:smooth]
    return found


def main(path):
    """Write the table."""
    found = np.array([logarithms(s, LOG_MASSES, LOG_STIFFNESS) for s in RATES])
    clean = np.array([logarithms(s, [0.0], [0.0])[0, 0] for s in RATES])
    table = found - clean[:, np.newaxis, np.newaxis]
    np.savez_compressed(path, effect=table.astype(np.float32), train=[*map(train, MASS_RATIOS)])


if __name__ == "__main__":
    main(sys.argv[1])
