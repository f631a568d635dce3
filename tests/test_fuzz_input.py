"""Malformed chain files, specifications, tables and arguments, at random with fixed seeds.

Each is read, or rejected with one sentence; no other exception may be raised.  A chain that was
read must be the same after it is written and read again.
"""

import copy
import datetime
import math
import random
import string
import tomllib
import warnings

import numpy as np
import pint
import pytest
from test_input_validation import public_calls

import hertzchain as hc
from hertzchain.simulation.state import fingerprint
from hertzchain.store.bead_tables import load_beads
from hertzchain.store.chain_files import chain_from
from hertzchain.store.chain_schema import KEYS, SECTIONS
from hertzchain.store.toml_files import toml_text
from hertzchain.sweeps.plan import Plan
from hertzchain.sweeps.specification import read_specification

UNIT = pint.UnitRegistry()
STEEL = {"density": 7800.0, "young": 2e11, "poisson": 0.3}
BALLS = {"radii": 5e-3, "beads": 5, "materials": "steel-52100"}
# Valid chain files, in which every section and every kind of key occurs.
CHAINS = [
    {"chain": {"taper": "uniform", "beads": 6}},
    {"chain": {"taper": "forward-linear", "rate": 0.05, "beads": 6, "exponent": 2.0}},
    {"chain": {"radii": [5.0, 4.0, 3.0], "gaps": [0.0, 0.1], "velocities": [1.0, 0.0, 0.0]}},
    {"chain": {"cell": [2.0, 1.0], "cells": 3, "masses": 1.5, "stiffness": [1.0, 2.0, 1, 2, 1.0]}},
    {"chain": {"mass_ratio": 0.5, "beads": 6, "precompression": 0.1, "held_by": "force"}},
    {"chain": BALLS | {"velocity": "50 cm/s", "right_wall": {"material": "brass", "gap": "1 um"}}},
    {"chain": {"radii": {"list": [5, 4.5], "unit": "mm"}, "materials": ["brass", "mine"]},
     "materials": {"mine": STEEL | {"yield_strength": "400 MPa", "source": "measured"}}},
    {"chain": {"taper": "uniform", "beads": 5, "radius": "5 mm", "materials": "brass",
               "left_wall": {"rigid": True}, "right_wall": {}, "precompression": "5 N"}},
    {"chain": {"units": "SI", "radii": [5e-3, 4e-3], "masses": ["1 g", 2e-3], "stiffness": [1e9]}},
    {"chain": {"taper": "uniform", "beads": 9, "decorated": {"ratio": 0.3, "between": 2},
               "with_scatter": {"seed": 4, "relative": 0.01}}},
    {"chain": {"taper": "uniform", "beads": 9, "with_defects": [{"bead": 3, "radius": 0.5}],
               "struck_by": [{"mass": 2.0, "velocity": 2.0}, {"radius": 1.5, "gap": 0.1}]}},
    {"chain": BALLS | {"gravity": "9.81 m/s^2", "loss": {"law": "viscoelastic", "time": "1 us"}}},
    {"chain": BALLS | {"loss": {"law": "restitution", "coefficient": 0.9, "attractive": False},
                       "drive": {"kind": "sine-burst", "amplitude": "50 N", "frequency": "9 kHz",
                                 "cycles": 0.5, "window": "none"}}},
    {"chain": BALLS | {"left_wall": {"stiffness": "7 N/um^1.5"},
                       "drive": {"kind": "step", "amplitude": "1 um", "rise": "9 us",
                                 "of": "displacement"}}},
    {"chain": BALLS | {"drive": {"kind": "table", "times": {"list": [0, 1, 2], "unit": "ms"},
                                 "values": [0, "2 N", 0.0]}}},
    {"chain": {"taper": "uniform", "beads": 5, "loss": {"law": "velocity-power", "gamma": 0.1,
                                                        "alpha": 1.5}}},
    {"chain": {"taper": "uniform", "beads": 5, "loss": {"law": "dashpot", "gamma": 0.1}}},
    {"chain": {"taper": "uniform", "beads": 5, "loss": {"law": "walton-braun", "ratio": 0.9}}},
    {"chain": {"taper": "uniform", "beads": 5, "loss": {"law": "unloading-ratio", "ratio": 0.1}}},
]  # fmt: skip
DEEP: list = []
for _ in range(150):
    DEEP = [DEEP]
# Values of wrong types, and values at the limits of their ranges.
ODD = [
    0, 1, -1, 2, 3, 7, 10**15, -(10**40), 0.0, -0.5, 0.5, 1.5, 1e-300, 1e300, math.inf, -math.inf,
    math.nan, True, False, "", "x", "5", "5 mm", "-1 um", "3 kg", "2 furlong", "1 m/s", "2ms",
    "false", "SI", "scaled", "brass", "steel", "banana", "\0", "\x7f", "\ud800", "a\nb", "no.csv",
    [], [1], [1.0, 2.0], [[1], [2, 3]], ["5 mm", 4e-3], ["x"], [True], [{}], {}, {"a": 1},
    {"list": [1, 2], "unit": "mm"}, {"list": [1, "2"], "unit": "mm"}, {"unit": "mm"}, {"law": 3},
    {"list": [1], "unit": 3}, {"rigid": "false"}, datetime.date(2026, 1, 1), datetime.time(1), DEEP,
]  # fmt: skip
NAMES = ["", "x", "radius ", "Radii", "bead", "rng", "name", "list", "unit", "law", "kind", *KEYS]


def places(entry, path=()):
    """Paths of all entries of nested tables and lists."""
    items = entry.items() if isinstance(entry, dict) else enumerate(entry)
    for key, value in items:
        yield (*path, key)
        if isinstance(value, dict | list):
            yield from places(value, (*path, key))


def mutated(rng, document, odd=ODD, names=NAMES):
    """A copy of a document with one to three changes."""
    document = copy.deepcopy(document)
    for _ in range(rng.randint(1, 3)):
        found = list(places(document))
        if not found:
            return document
        *path, last = rng.choice(found)
        table = document
        for key in path:
            table = table[key]
        kind = rng.randrange(8)
        if kind == 0:
            del table[last]
        elif kind == 1 and isinstance(table, dict):
            table[rng.choice(names)] = copy.deepcopy(rng.choice(odd))
        elif kind == 2 and isinstance(table, dict):
            section = rng.choice(list(SECTIONS.values()))
            keys = [key.name for key in section.keys] or ["law"]
            table[rng.choice(keys)] = copy.deepcopy(rng.choice(odd))
        elif kind == 3:
            table[last] = [table[last]]
        else:
            table[last] = copy.deepcopy(rng.choice(odd))
    return document


def outcome(call):
    """Result of a call, or None if it raised the expected error."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hc.InputWarning)
        warnings.simplefilter("ignore", hc.ModelRangeWarning)
        warnings.simplefilter("ignore", hc.IncompleteWarning)
        try:
            return call()
        except hc.InputError as error:
            said = str(error)
    assert said
    assert "Traceback" not in said
    assert len(said.splitlines()) == 1 or "errors:" in said, said
    said.encode()  # a message can be printed
    return None


def assert_written_and_read(chain):
    if outcome(lambda: fingerprint(chain)) is None:
        return  # a chain that nothing can integrate, such as one with an infinite damping
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hc.InputWarning)
        again = chain_from(tomllib.loads(hc.chain_as_toml(chain)))
        assert fingerprint(again) == fingerprint(chain)


def counts(short, long):
    """Numbers of trials of `make test` and of `make test-long`."""
    return pytest.mark.parametrize("number", [short, pytest.param(long, marks=pytest.mark.long)])


def test_the_chains_to_start_from_are_sound():
    for document in CHAINS:
        assert_written_and_read(chain_from(document))


@counts(3000, 60_000)
def test_chain_files_of_wrong_types(number):
    rng, read = random.Random(1), 0
    for _ in range(number):
        document = mutated(rng, rng.choice(CHAINS))
        chain = outcome(lambda document=document: chain_from(document))
        if chain is not None:
            assert_written_and_read(chain)
            read += 1
    assert number // 50 < read < number // 2


@counts(500, 10_000)
def test_chain_files_damaged_at_any_place(number, tmp_path):
    rng, file = random.Random(2), tmp_path / "chain.toml"
    texts = [
        "\n".join(f"[{name}]\n" + "\n".join(f"{key} = {toml_text(value)}" for key, value in
                                             table.items()) for name, table in lines.items())
        for lines in ({"chain": each["chain"]} for each in CHAINS)
    ]  # fmt: skip
    odd = [*string.punctuation, "\0", "\n", "é", "[[", "]]", "nan", "9" * 5000, "[" * 3000, '"""']
    for _ in range(number):
        text = rng.choice(texts)
        for _ in range(rng.randint(1, 3)):
            at = rng.randrange(len(text))
            text = text[:at] + rng.choice(odd) + text[at + rng.randrange(4) :]
        content = text.encode()
        if rng.randrange(20) == 0:
            content = content[: len(content) // 2] + b"\xff\xfe" + content[len(content) // 2 :]
        file.write_bytes(content)
        outcome(lambda: hc.load_chain(file))


SPECIFICATIONS = [
    {"title": "one", "chain": {"taper": "forward-linear", "beads": 20},
     "axes": {"rate": {"linspace": [0.01, 0.02, 3]}, "exponent": [1.5, 2.0]},
     "sweep": {"methods": ["propagate", "bca"], "keep": ["velocity"], "at": "last",
               "errors": ["velocity"]}, "method": {"rtol": 1e-8}},
    {"chain": BALLS | {"right_wall": {"gap": "1 um"}, "struck_by": {"velocity": 0.1}},
     "axes": {"struck_by.mass": {"geomspace": [0.5, 5.0, 2], "unit": "g"},
              "right_wall": {"gap": ["1 um", "2 um"]}},
     "sweep": {"methods": ["simulate"], "keep": ["wall_peak_force"], "at": [1, 3], "batch": 2},
     "method": {"until": "2 ms", "max_steps": 10_000}},
    {"chain": {"taper": "uniform", "loss": {"law": "restitution"}},
     "points": [{"beads": 5, "loss": {"coefficient": 0.9}},
                {"beads": 6, "loss": {"coefficient": 0.8}}]},
    {"chain": BALLS | {"materials": "mine"}, "materials": {"mine": STEEL},
     "axes": {"radii": {"list": [4, 5], "unit": "mm"}, "velocity": [0.1, 0.2]},
     "sweep": {"combine": "zip"}},
]  # fmt: skip


@counts(500, 20_000)
def test_specifications_of_wrong_types(number):
    rng, read = random.Random(3), 0
    names = [*NAMES, "axes", "chain", "points", "sweep", "rate", "method.until", "loss.law", "5"]
    for _ in range(number):
        document = mutated(rng, rng.choice(SPECIFICATIONS), names=names)
        found = outcome(lambda document=document: read_specification(document))
        if found is None:
            continue
        read += 1
        assert read_specification(found.as_json() and document).as_json() == found.as_json()
        plan = Plan(found)
        if plan.points < 100:
            for index in plan.tried():
                outcome(lambda plan=plan, index=index: plan.chain(index))
    assert number // 50 < read < number


TABLES = [
    "# measured\ndiameter [mm],material,gap [um],velocity [cm/s],bead\n10.0,brass,2,50,1\n\n"
    "9.5,glass,0,0,2\n9.0,brass,,0,3\n",
    "radius,gap\n2,0.1\n1,\n",
    "radius [mm],mass [g],stiffness [N/um^1.5]\n5,4,7\n5,4,\n",
    "time [us],force [kN]\n0,0\n10,0.5\n30,0\n",
    "time [ms],displacement [um]\n0,0\n10,0.5\n",
]


@counts(500, 20_000)
def test_tables_damaged_at_any_place(number, tmp_path):
    rng, file = random.Random(4), tmp_path / "table.csv"
    odd = [*",;\t\n\"'[]()# .-+eE59", "nan", "inf", "mm", "1e999", "\0", "é", "\r", " [kg]"]
    for _ in range(number):
        text = rng.choice(TABLES)
        for _ in range(rng.randint(1, 4)):
            at = rng.randrange(len(text))
            text = text[:at] + rng.choice(odd) + text[at + rng.randrange(3) :]
        if rng.randrange(5) == 0:
            text = text.replace(",", rng.choice([";", "\t", ", "]))
        file.write_text(text, "utf-8")
        for read in (load_beads, hc.load_drive):
            chain = outcome(lambda read=read: read(file))
            if isinstance(chain, hc.Chain):
                assert_written_and_read(chain)


ARGUMENTS = [
    *ODD[:-3], None, object(), b"5", 3 + 4j, range(3), {1, 2}, np.float64(0.5), np.int64(3),
    np.array(2.0), np.array([1.0, 2.0]), np.array([[1.0], [2.0]]), np.array(["5 mm"]),
    np.array([1, None]), np.ma.array([1.0, 2.0], mask=[False, True]), np.ma.array(1.0, mask=True),
    np.datetime64("2026-01-01"), UNIT.Quantity(5, "mm"), UNIT.Quantity(2.0, "kg"),
    UNIT.Quantity(0.5), UNIT.Quantity(3, "m/s"), UNIT.Quantity([1.0, 2.0], "ms"),
    UNIT.Quantity(math.nan, "s"), [UNIT.Quantity(1, "s"), 2.0], ["1 s", "2 s"], hc.Wall(),
    hc.Wall(gap="1 um"), hc.Dashpot("3 kg/s"), hc.StepDrive("5 N"), hc.material("brass"),
    hc.Chain.uniform(3), hc.Chain.from_materials(5e-3, "brass", beads=3),
]  # fmt: skip
# With valid arguments, these take long or accept any object.
SLOW = ("verify", "animate", "sweep", "stream", "merge_sweeps", "StoredRun", "plot", "open_sweep")
OTHERS = (IndexError, hc.SimulationError)


@counts(1000, 40_000)
def test_arguments_of_public_functions(number, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rng = random.Random(5)
    public = {
        name: call
        for name, call in public_calls(tmp_path).items()
        if not any(part in name for part in SLOW) and call[1]
    }
    for _ in range(number):
        name = rng.choice(list(public))
        door, good = public[name]
        given = dict(good)
        for argument in rng.sample(list(good), min(len(good), rng.randint(1, 2))):
            given[argument] = rng.choice(ARGUMENTS)
        if "max_steps" in given:
            given["max_steps"] = 2000
        try:
            result = outcome(lambda door=door, given=given: door(**given))
        except OTHERS:
            continue
        if isinstance(result, hc.Chain):
            assert_written_and_read(result)
