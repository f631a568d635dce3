"""Every keyword of a builder of chains has an effect, or is rejected."""

import dataclasses
import inspect

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.chain.builder_arguments import OTHER_FIELDS

# Values that differ from the defaults, for chains of four beads.
VALUES = {
    "taper": "backward-linear", "rate": 0.2, "beads": 6, "first": 2e-3, "last": 1e-3,
    "first_diameter": 5e-3, "last_diameter": 3e-3, "ratio": 0.7, "length": 0.025,
    "materials": "brass", "velocity": 0.3, "exponent": 2.0, "radii": [3e-3, 2e-3, 3e-3, 2e-3],
    "diameters": [5e-3, 4e-3], "cell": [2e-3, 1e-3], "cells": 3, "mass_ratio": 0.3,
    "taper_parameters": [("rate", 0.1)], "masses": [1.0, 2.0, 3.0, 4.0], "stiffness": [1e8] * 3,
    "velocities": [0.5, 0.1, 0.0, 0.0], "gaps": [1e-4, 0.0, 0.0], "strikers": 1,
    "precompression": 2.0, "held_by": "force", "gravity": 0.5, "left_wall": hc.Wall(gap=1e-3),
    "right_wall": hc.Wall(), "drive": hc.StepDrive(amplitude=1.0),
    "loss": hc.Restitution(0.9), "material": "glass",
}  # fmt: skip
CALLS = {
    "tapered": [
        {"taper": "forward-exponential", "rate": 0.1, "beads": 4},
        {"first": 4e-3, "last": 2e-3, "beads": 4},
        {"first": 4e-3, "last": 2e-3, "beads": 4, "materials": "steel-316"},
    ],
    "uniform": [{"beads": 5}],
    "from_radii": [{"radii": [1.0, 0.5, 2.0, 1.0]}],
    "from_materials": [
        {"radii": [3e-3, 2e-3, 2e-3, 1e-3], "materials": "steel-316"},
        {"diameters": "3 mm", "materials": "steel-316", "beads": 4},
        {"radii": "3 mm", "materials": "steel-316", "beads": 4, "velocities": [1, 0, 0, 0]},
    ],
    "periodic": [
        {"cell": [3e-3, 2e-3], "cells": 2},
        {"cell": [3e-3, 2e-3], "cells": 2, "materials": ["steel-316", "ptfe"]},
    ],
    "dimer": [
        {"mass_ratio": 0.5, "beads": 4},
        {"radii": [3e-3, 2e-3], "beads": 4},
        {"diameters": ["3 mm", "2 mm"], "beads": 4, "materials": ["steel-316", "ptfe"]},
    ],
}  # fmt: skip


def cases():
    for builder, bases in CALLS.items():
        signature = inspect.signature(getattr(hc.Chain, builder)).parameters.values()
        names = {each.name for each in signature if each.kind != each.VAR_KEYWORD}
        for place, base in enumerate(bases):
            for name in sorted(names | {*OTHER_FIELDS, "material"}):
                yield pytest.param(builder, base, name, id=f"{builder}-{place}-{name}")


def fields(chain):
    return {each.name: repr(getattr(chain, each.name)) for each in dataclasses.fields(chain)
            if each.name != "given"}  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize(("builder", "base", "name"), [*cases()])
def test_keywords_act_or_are_rejected(builder, base, name):
    build = getattr(hc.Chain, builder)
    before = fields(build(**base))
    try:
        after = fields(build(**(base | {name: VALUES[name]})))
    except hc.InputError:
        return
    assert after != before, f"{name} has no effect"


def test_the_materials_of_a_dimer_are_used_or_rejected():
    for more in ({"material": "steal"}, {"materials": "steel-316"}):
        with pytest.raises(hc.InputError, match="mass ratio is a scaled chain without materials"):
            hc.Chain.dimer(0.5, beads=41, **more)
    with pytest.raises(hc.InputError, match="give only one of mass_ratio and radii"):
        hc.Chain.dimer(0.5, radii=[1, 2], beads=4)
    with pytest.raises(hc.InputError, match="give only one of radii and diameters"):
        hc.Chain.dimer(diameters=[1, 2], radii=[1, 2], beads=4)
    with pytest.raises(hc.InputError, match="only one of velocity .* and velocities"):
        hc.Chain.from_materials("3 mm", "brass", beads=3, velocity=1.0, velocities=np.ones(3))
