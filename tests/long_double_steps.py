"""RKN8(6) steps of given lengths in long double, as a reference for derivatives of steps.

Written from the coefficients of the method; nothing of the kernels is used.
"""

import numpy as np

from hertzchain.kernels import rkn8

LD = np.longdouble
C = [0, rkn8.C1, rkn8.C2, rkn8.C3, rkn8.C4, rkn8.C5, rkn8.C6, rkn8.C7]
A = [(), rkn8.A1, rkn8.A2, rkn8.A3, rkn8.A4, rkn8.A5, rkn8.A6, rkn8.A7]
B, D = (*rkn8.B_POSITION, 0.0), rkn8.B_VELOCITY


class Steps:
    """An elastic chain; contacts 0..N include the walls."""

    def __init__(self, equation, **changes):
        names = "masses", "stiffness", "exponents", "overlaps", "velocities", "body"
        for name in names:
            setattr(self, name, np.array(getattr(equation, name), LD))
        for name, (index, change) in changes.items():
            getattr(self, name)[index] += LD(change)

    def overlaps_at(self, x):
        return self.overlaps - np.diff(np.concatenate(([LD(0)], x, [LD(0)])))

    def forces(self, x):
        return self.stiffness * np.maximum(self.overlaps_at(x), 0) ** self.exponents

    def accelerations(self, x):
        return -np.diff(self.forces(x)) / self.masses + self.body

    def step(self, x, v, h):
        stages, forces = [], []
        for s in range(8):
            push = sum((LD(a) * f for a, f in zip(A[s], stages, strict=True)), 0 * x)
            at = x + h * (LD(C[s]) * v + h * push)
            stages.append(self.accelerations(at))
            forces.append(self.forces(at))
        x = x + h * (v + h * sum(LD(b) * f for b, f in zip(B, stages, strict=True)))
        v = v + h * sum(LD(d) * f for d, f in zip(D, stages, strict=True))
        return x, v, h * sum(LD(d) * f for d, f in zip(D, forces, strict=True))

    def run(self, lengths):
        """Positions and velocities after some steps, and the impulse of each contact."""
        self.x, self.v, self.impulse = 0 * self.velocities, self.velocities, 0 * self.stiffness
        for h in lengths:
            self.x, self.v, part = self.step(self.x, self.v, LD(h))
            self.impulse = self.impulse + part
        return self


def derivative(equation, name, index, lengths, read, size=1e-9):
    """Central difference of a quantity on fixed steps."""
    high, low = (
        read(Steps(equation, **{name: (index, sign * size)}).run(lengths)) for sign in (1, -1)
    )
    return float((high - low) / (2 * LD(size)))
