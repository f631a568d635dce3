"""Run what most commands run, so that processes forked from this one have its kernels loaded."""

import hertzchain as hc

ROW = hc.Chain.tapered(first="10 mm", last="8 mm", beads=12, material="steel-52100").struck_by(
    velocity="0.1 m/s"
)
for chain in (ROW, ROW.replace(right_wall=hc.Wall()), ROW.replace(loss=hc.Restitution(0.9))):
    hc.simulate(chain, times=3)
    hc.simulate_many([chain] * 9)
for theory in (hc.propagate, hc.bca, hc.local_rate):
    theory(hc.Chain.tapered("backward-linear", 0.1, beads=12))
