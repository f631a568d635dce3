"""The schema of chain files agrees with the functions and classes of the package."""

import inspect
import itertools
import json
import math
import re
from functools import partial
from pathlib import Path

import pytest

import hertzchain as hc
from hertzchain.chain.laws import LAWS, Loss
from hertzchain.chain.materials import Material
from hertzchain.store.chain_files import BEAD_METHODS, PARTS, SHAPES, chain_from
from hertzchain.store.chain_schema import (
    FORMS,
    KEYS,
    SECTIONS,
    TABLES,
    chain_schema,
)
from hertzchain.store.drive_tables import DRIVES
from hertzchain.store.schema_checks import check_document
from hertzchain.store.schema_paths import dimensions_of
from hertzchain.sweeps.specification import specification_schema
from hertzchain.units import UNITS

DOCS = Path(__file__).parent.parent / "docs" / "how-to"
# Arguments with another name in Python: mappings of sizes by bead.
RENAMED = {
    (hc.Chain.with_defects, "radii"): {"bead", "radius"},
    (hc.Chain.with_defects, "diameters"): {"diameter"},
}


def parameters(function):
    return {
        name: item
        for name, item in inspect.signature(function).parameters.items()
        if name not in ("self", "cls")
    }


def functions():
    """Each section that is a function or class of Python, with its keys."""
    for name in BEAD_METHODS:
        method = "with_cap" if name == "cap" else name
        yield getattr(hc.Chain, method), SECTIONS[f"chain.{name}"].keys
    for name, law in LAWS.items():
        yield law, SECTIONS["chain.loss"].variants[name]
    for name, shape in SHAPES.items():
        yield shape, SECTIONS["chain.with_contacts"].variants[name]
    for name, drive in DRIVES.items():
        keys = SECTIONS["chain.drive"].variants[name]
        yield drive, [key for key in keys if key.kind not in ("file", "signal")]
    signal = [key for key in SECTIONS["chain.drive"].variants["table"] if key.kind == "signal"]
    yield partial(hc.load_drive, "no.csv"), signal
    for side in ("left_wall", "right_wall"):
        keys = SECTIONS[f"chain.{side}"].keys
        yield hc.Wall, [key for key in keys if key.name != "rigid"]
    yield Material, SECTIONS["materials.NAME"].keys


@pytest.mark.parametrize(("function", "keys"), [*functions()])
def test_keys_and_defaults_are_those_of_python(function, keys):
    named = {}
    for name, item in parameters(function).items():
        if function is Material and name == "name":
            continue
        for own in RENAMED.get((function, name), {name}):
            named[own] = item.default
    own = {key.name: key for key in keys}
    assert named.keys() == own.keys()
    for name, default in named.items():
        if default is inspect.Parameter.empty:
            listed = own[name].per == "row"  # a table may come from a file
            assert own[name].required or listed
        elif name not in ("bead", "radius", "seed") or function is not hc.Chain.with_defects:
            assert not own[name].required or own[name].unless
            # Strikers without a velocity have that of their height, or 1.
            struck = function is hc.Chain.struck_by and name == "velocity"
            assert own[name].default == (1.0 if struck else default)


def test_fields_of_a_chain_are_those_of_python():
    fields = parameters(hc.Chain)
    in_files = {key.name: key for key in SECTIONS["chain"].keys}
    assert fields.keys() - {"taper_parameters", "scatter"} <= in_files.keys() | {*TABLES}
    for name, item in fields.items():
        if name in ("exponent", "strikers", "precompression", "held_by", "gravity"):
            assert in_files[name].default == item.default
    assert {*FORMS} < {*KEYS}
    others = {"with_contacts", "exponent", "striker_properties"}
    assert {*BEAD_METHODS, *PARTS, *others} == {*TABLES}
    assert {*LAWS.values()} == {*Loss.__subclasses__()}


def bounds():
    """Numbers just outside the bounds of each key, in a chain that is sound without them."""
    for section in SECTIONS.values():
        variants = section.variants.items() or [("", ())]
        for variant, more in variants:
            for key in (*section.keys, *more):
                tiny = 1 if key.kind == "integer" else 1e-3
                for value in (key.least - tiny, key.most + tiny, key.above, key.below):
                    if math.isfinite(value) and key.kind in ("number", "integer"):
                        yield section, variant, key, value


def with_key(section, variant, key, value):
    """A chain file with a value of a key, and all that the key needs."""
    chain = {"radii": 5e-3, "beads": 4, "materials": "brass"}
    if section.name == "chain":
        needs = {"rate": {"taper": "forward-linear", "beads": 4}, "cell": {"cells": 2},
                 "cells": {"cell": [1.0, 2.0]}, "mass_ratio": {"beads": 4},
                 "radius": {"taper": "uniform", "beads": 4, "materials": "brass"},
                 "radii": {}, "beads": {"taper": "uniform"},
                 "exponent": {"taper": "uniform", "beads": 4}}  # fmt: skip
        chain = needs.get(key.name, chain)
        listed = (key.per and not key.one_for_all) or key.name == "radii"
        return {"chain": chain | {key.name: [value, value] if listed else value}}
    if section.name == "materials.NAME":
        own = {"density": 1.0, "young": 1.0, "poisson": 0.3, key.name: value}
        return {"chain": chain | {"materials": "own"}, "materials": {"own": own}}
    table = {
        part.name: {"number": 2.0, "integer": 1, "choice": part.default, "material": ["brass"] * 2}[
            part.kind
        ]
        for part in (*section.keys, *section.variants.get(variant, ()))
        if part.required
    }
    if section.name == "chain.decorated":
        table = {"ratio": 0.3}
    if section.name == "chain.with_scatter":
        table |= {"relative": 0.1}
    if variant == "table":
        table = {"times": [0.0, 1.0], "values": [0.0, 1.0]}
    table[key.name] = [value, value] if key.per else value
    if section.name == "chain.decorated" and key.name in ("radius", "diameter"):
        del table["ratio"]
    if section.variant_key:
        table[section.variant_key] = variant
    return {"chain": chain | {section.name.removeprefix("chain."): table}}


@pytest.mark.filterwarnings("ignore:.*without a unit:hertzchain.errors.InputWarning")
@pytest.mark.parametrize(("section", "variant", "key", "value"), [*bounds()])
def test_values_beyond_the_bounds_are_rejected(section, variant, key, value):
    document = with_key(section, variant, key, value)
    assert not [*check_document(document)]
    with pytest.raises(hc.InputError):
        chain_from(document)


def test_the_schema_is_json():
    for schema in (chain_schema(), specification_schema()):
        text = json.dumps(schema, allow_nan=False)
        assert json.loads(text) == json.loads(json.dumps(schema))
    sections = chain_schema()["sections"]
    assert {*sections} == {*SECTIONS}
    for name, section in sections.items():
        for key in itertools.chain(section["keys"], *section["variants"].values()):
            assert key["description"], (name, key)
            assert key["dimension"] == "" or key["dimension"] in UNITS


def test_the_pages_name_every_key():
    text = (DOCS / "chain_files.md").read_text("utf-8")
    for section in SECTIONS.values():
        for key in section.keys:
            assert f"`{key.name}`" in text or f"`{key.name} =" in text, (section.name, key.name)
        for law in section.variants:
            assert f"`{law}`" in text, law


def test_dimensions_by_path():
    assert dimensions_of(("struck_by", "2", "mass")) == {"mass"}
    assert dimensions_of(("drive", "amplitude")) == {"force", "length"}
    assert dimensions_of(("loss", "gamma")) == {"", "damping"}
    assert dimensions_of(("no", "such")) == {""}


def test_the_reference_lists_every_key():
    import schema_tables

    page = schema_tables.chain_file_page()
    for name, section in chain_schema()["sections"].items():
        assert re.search(rf"^## `\[+{re.escape(name)}\]+`$", page, re.M)
        for keys in (section["keys"], *section.get("variants", {}).values()):
            for key in keys:
                ends = re.escape(f"| {key['description']} |")
                (row, *_) = re.findall(rf"^\| `{key['name']}` \| .*{ends}$", page, re.M)
                assert f"| {key['unit']} |" in row
                assert bool(re.search(r"\| required(, or `\w+`)? \|", row)) == key["required"]


def test_the_reference_lists_the_settings_of_a_fit():
    import schema_tables

    _, found, section = schema_tables.chain_file_page().partition("## `[fit]`\n")
    assert found
    for key in ("free", "prior", "start", "coupling"):
        assert f"| `{key}` | " in section


def test_the_table_of_calibrated_constants_is_that_of_the_package():
    import schema_tables

    from hertzchain.theory.modified_bca import calibrated_corrections

    rows = [row.split(" | ") for row in schema_tables.calibration_table().splitlines()[2:]]
    assert len(rows) == 4
    for taper, _, constants, *errors in rows:
        shown = re.findall(r" = (-?[\d.]+) ± [\d.]+", constants)
        shipped = vars(calibrated_corrections()[taper.strip("| ")])
        assert list(map(float, shown)) == pytest.approx([*shipped.values()][: len(shown)])
        assert all(text.strip(" |").endswith("%") for text in errors)
