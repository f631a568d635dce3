"""Messages about unknown and missing arguments of builders and functions."""

import dataclasses
import inspect
import pydoc
import subprocess
import sys

import pytest
from test_input_validation import INTERNAL, RESULTS, error_of

import hertzchain as hc
from hertzchain.store.chain_files import chain_from

BALLS = {"first_diameter": "20 mm", "last_diameter": "5 mm", "beads": 5}
STEEL = "steel-52100"


@pytest.mark.parametrize(("call", "said"), [
    (lambda: hc.Chain.tapered(**BALLS, material=STEEL, speed=1),
     "Chain.tapered has no argument 'speed'; did you mean 'velocity'\\?"),
    (lambda: hc.Chain.tapered(**BALLS),
     "sizes with a unit \\(first_diameter = '20 mm'\\) need the material .*: give materials"),
    (lambda: hc.Chain.tapered(first=2, length="1 m", beads=5), "length = '1 m'.* give materials"),
    (lambda: hc.Chain.tapered(**BALLS, materials=STEEL, material=STEEL),
     "materials and material are the same: give one of them"),
    (lambda: hc.Chain.periodic([1e-2], cells=4, material="brass", materials="ptfe"), "the same"),
    (lambda: hc.Chain.uniform(5).with_scatter(1, seed=1, relative=0.1), "seed, which is given"),
    (lambda: hc.Chain.uniform(5).with_scatter(rng=1, seed=1, relative=0.1), "seed and rng are the"),
    (lambda: chain_from({"chain": {"radii": 5e-3, "beads": 3, "material": STEEL,
                                   "materials": STEEL}}),
     "\\[chain\\] has materials and material, which are the same: omit one"),
    (lambda: hc.sweep({"chain": {"radii": 5e-3, "beads": 3, "material": STEEL, "materials": STEEL},
                       "axes": {"velocity": [1.0]}}), "has materials and material"),
    (lambda: hc.Design(hc.Chain.uniform(5), minimize="momentum@last"),
     "Design has no argument 'minimize'; did you mean 'minimise'\\?"),
    (lambda: hc.vary.radii(0.5, 1.0, bead="2:"), "vary.radii has no argument 'bead'; .* 'beads'"),
    (lambda: hc.distribution(hc.Chain.uniform(5), "momentum@last", chains=100),
     "no argument 'chains'; use scatter=Scatter\\(..., samples=100\\)$"),
    (lambda: hc.distribution(hc.Chain.uniform(5), "momentum@last", hc.Scatter(0.01), samples=9),
     "no argument 'samples'; use scatter=Scatter\\(..., samples=100\\)$"),
    (lambda: hc.distribution(hc.Chain.uniform(4), "length", gaps=1e-6), "gaps=\"5 um\"\\)$"),
    (lambda: hc.distribution(hc.Chain.uniform(4), "length", 0.01),
     "scatter must be a Scatter, .*, got 0.01"),
    (lambda: hc.Scatter(relative=0.01), "Scatter has no argument 'relative'; use radius=0.01$"),
    (lambda: hc.Scatter(scatter=0.01), "Scatter has no argument 'scatter'; use radius=0.01$"),
    (lambda: hc.Chain.uniform(4).with_scatter(1, scatter=0.01), "; use relative=0.01$"),
    (lambda: hc.Chain.uniform(4).struck_by(mass=2.0, flat=True), '; use radius="flat"$'),
    (lambda: hc.disorder(hc.Chain.uniform(40), relative=0.01), "; use scatter=0.01$"),
    (lambda: hc.disorder(hc.Chain.uniform(40), 0.01, beads="2:"),
     "'beads'; use distribution with .* beads"),
    (lambda: hc.simulate(hc.Chain.uniform(4), wall=hc.Wall()),
     "simulate has no argument 'wall'; use chain.replace\\(right_wall=...\\)$"),
    (lambda: hc.propagate(hc.Chain.uniform(4), gravity=1), "use chain.replace\\(gravity=...\\)$"),
    (lambda: hc.Scatter(0.01, chains=100), "no argument 'chains'; did you mean 'samples'"),
    (lambda: hc.vary.gaps(0.0), "vary.gaps: missing the argument 'high'; it takes low, high"),
    (lambda: hc.Restitution(), "Restitution: missing the argument 'coefficient'"),
    (lambda: hc.Restitution(coefficients=0.9), "no argument 'coefficients'; .* 'coefficient'"),
    (lambda: hc.StepDrive(amplitudes=0.9), "StepDrive has no argument .* 'amplitude'"),
    (lambda: hc.Cone(half_angel=40.0), "Cone has no argument .* 'half_angle'"),
    (lambda: hc.Material("x", rho=1.0), "Material has no argument 'rho'; did you mean 'density'"),
    (lambda: hc.simulate(hc.Chain.uniform(4), steps=1.0), "simulate has no .* 'step'"),
    (lambda: hc.simulate(hc.Chain.uniform(4)).plot_forces([2], labels=["x"]),
     "Run.plot_forces has no argument 'labels'; did you mean 'label'\\?"),
    (lambda: hc.plot_pulses([], residual=True), "plot_pulses has no .* 'residuals'"),
    (lambda: hc.Wall(STEEL), "its stiffness, .*'steel-52100'; .* is Wall.of\\('steel-52100'\\)"),
    (lambda: hc.Wall(hc.material("ptfe")), "Wall.of\\('ptfe'\\)"),
    (lambda: hc.Chain.dimer(diameters=[1, 2, 3], beads=4), "two sizes, .* got a list of 3"),
    (lambda: hc.Chain.tapered("forward-linear", 0.1),
     "Chain.tapered: missing the argument 'beads'; it requires only beads"),
    (lambda: hc.Chain.from_materials(5e-3, STEEL, beads=3, speed=3),
     "Chain.from_materials has no argument 'speed'; did you mean 'velocity'"),
    (lambda: hc.Chain.from_materials(5e-3, STEEL, beads=3, units="SI"), "no argument 'units'"),
    (lambda: hc.Chain.uniform(5, speed=1), "no argument 'speed'; did you mean 'velocities'"),
    (lambda: hc.Chain.from_radii([1, 2], weight=[1, 2]), "no argument 'weight'; it takes radii"),
    (lambda: hc.Chain.periodic([1, 2], cells=4, velocity=2), "no argument 'velocity'"),
    (lambda: hc.Chain.periodic([1, 2], cells=4, radius=2), "Chain.periodic has no argument"),
    (lambda: hc.Chain.dimer(0.5, beads=4, velocity=2), "of a mass ratio has no argument"),
    (lambda: hc.Chain.dimer(0.5, beads=4, masses=[1.0]), "of a mass ratio has no argument"),
    (lambda: hc.Chain.uniform(5, material=STEEL),
     "no argument 'material'; .*; Chain.from_materials and Chain.tapered make chains of materials"),
    (lambda: hc.Chain([1, 1], material=STEEL), "Chain has no argument 'material'; .* 'materials'"),
    (lambda: hc.Wall(materials=STEEL), "Wall has no argument 'materials'; did you mean 'material'"),
    (lambda: hc.Wall.of(material=STEEL), "Wall.of has no argument 'material'; .* 'name'"),
    (lambda: hc.Chain.uniform(5).struck_by(3), "struck_by: too many positional arguments; give "),
    (lambda: hc.local_rate_gradient(hc.Chain.uniform(70), "velocity", 60),
     "local_rate_gradient: too many positional arguments; write bead=60; it takes chain, quantity"),
    (lambda: hc.simulate(hc.Chain.uniform(4), 60),
     "simulate: too many positional arguments; give others by keyword, such as until=60; it takes"),
    (lambda: hc.disorder(hc.Chain.uniform(40), 0.01, 0.02), "write modulus_scatter=0.02; it takes"),
    (lambda: hc.propagate(), "propagate: missing the argument 'chain'"),
    (lambda: hc.Chain.uniform(5).with_scatter(1, sigma=0.1), "with_scatter has no argument"),
    (lambda: hc.attenuation(hc.Chain.uniform(5)), "attenuation: missing the argument 'velocity'"),
    (lambda: hc.hertz_range(hc.propagate(hc.Chain.uniform(5))), "use hertz_range.result.chain."),
    (lambda: hc.bca(hc.propagate(hc.Chain.uniform(5))), "; pass result.chain instead$"),
    (lambda: hc.ElasticPlastic().restitution(1.0, reduced_mass=1e-3, stiffness=1e9),
     "use ElasticPlastic\\(yield_overlap=...\\).restitution"),
    (lambda: chain_from({"chain": {"taper": "uniform", "beads": 5, "diametres": 1,
                                   "rigth_wall": {}}}),
     r"'diametres' \(did you mean 'diameters'\?\), 'rigth_wall' \(did you mean 'right_wall'\?\)"),
])  # fmt: skip
def test_a_wrong_call_is_explained(call, said):
    with pytest.raises(hc.InputError, match=said):
        call()


def documented_calls():
    """Public functions and methods by name; methods of objects without values."""
    for module in (hc, hc.evaluation, hc.paper, hc.plotting, hc.theory):
        for name in dir(module):
            item = getattr(module, name)
            if inspect.isfunction(item) and not name.startswith("_"):
                yield name, item
    for name, item in vars(hc).items():
        if not inspect.isclass(item) or issubclass(item, Exception):
            continue
        if name not in RESULTS:
            yield name, item
        for method, function in inspect.getmembers(item, callable):
            if not method.startswith("_") and method not in (*INTERNAL, "parameters", "replace"):
                # Class methods are bound; other methods get an object without values.
                bound = inspect.ismethod(function)
                yield (
                    f"{name}.{method}",
                    function if bound else function.__get__(object.__new__(item)),
                )


def test_unknown_arguments_of_public_functions_are_explained():
    for name in hc.__all__:
        getattr(hc, name)
    calls = dict(documented_calls())
    assert len(calls) > 200
    for name, function in calls.items():
        error = error_of(function, {"nonsense": 1})
        assert isinstance(error, hc.InputError), (name, error)
        assert "has no argument 'nonsense'" in str(error), name


def test_errors_of_types_within_a_function_are_not_taken_for_wrong_arguments():
    def progress(done):
        """A callback that lacks its second argument."""

    with pytest.raises(TypeError, match=r"progress\(\) takes 1 positional argument"):
        hc.simulate(hc.Chain.uniform(4), progress=progress)


def test_missing_arguments_of_functions_and_methods_are_named():
    with pytest.raises(hc.InputError, match="local_rate: missing the argument 'chain'"):
        hc.local_rate()
    with pytest.raises(hc.InputError, match="Run.force: missing the argument 'contact'"):
        hc.simulate(hc.Chain.uniform(4)).force()


def test_a_run_in_place_of_its_chain_is_explained():
    run = hc.simulate(hc.Chain.uniform(4))
    with pytest.raises(hc.InputError, match=r"hertz_range\(run.chain, run.largest_overlaps\)"):
        hc.hertz_range(run)


def test_a_list_of_materials_gives_the_number_of_equal_beads():
    kinds = ["brass", "glass"] * 7 + ["brass"]
    chain = chain_from({"chain": {"diameters": "10 mm", "materials": kinds}})
    assert chain.radii.tolist() == [5e-3] * 15
    assert [each.name for each in chain.materials] == kinds
    with pytest.raises(
        hc.InputError, match="one radius or diameter and one material .* give beads"
    ):
        chain_from({"chain": {"diameters": "10 mm", "materials": "brass"}})
    with pytest.raises(hc.InputError, match="must be 4 materials"):
        chain_from({"chain": {"diameters": "10 mm", "materials": kinds, "beads": 4}})


def test_the_yield_overlap_gives_the_restitution_in_si_units():
    law = hc.ElasticPlastic(yield_overlap=1e-6)
    slow = law.restitution(1e-4, reduced_mass=2e-3, stiffness=7.4e9)
    fast = law.restitution(1.0, reduced_mass=2e-3, stiffness=7.4e9)
    assert slow == pytest.approx(1.0, abs=1e-9)
    assert 0.1 < fast < 0.9


def test_kilometres_per_hour_are_a_unit_of_speed():
    chain = hc.Chain.from_materials(5e-3, "brass", beads=3, velocity="3.6 km/h")
    assert chain.velocities[0] == pytest.approx(1.0, rel=1e-15)


@pytest.mark.parametrize("name", ["material", "materials"])
def test_the_materials_of_a_chain_have_two_names(name):
    one, two = {name: STEEL}, {name: [STEEL, "ptfe"]}
    for chain in (
        hc.Chain.tapered(**BALLS, **one),
        hc.Chain.from_materials(5e-3, beads=5, **one),
        hc.Chain.periodic([5e-3], cells=5, **one),
        hc.Chain.dimer(diameters="10 mm", beads=5, **one),
        chain_from({"chain": {"diameters": "10 mm", "beads": 5, **one}}),
        chain_from({"chain": BALLS | one}),
    ):
        assert [each.name for each in chain.materials] == 5 * [STEEL]
    for chain in (
        hc.Chain.tapered(first="10 mm", last="9 mm", beads=2, **two),
        hc.Chain.dimer(diameters="10 mm", beads=2, **two),
        chain_from({"chain": {"cell": [5e-3, 4e-3], "cells": 1, **two}}),
    ):
        assert [each.name for each in chain.materials] == [STEEL, "ptfe"]
    found = hc.sweep({
        "chain": {"radii": 5e-3, "beads": 5, "velocity": 1e-3, **one},
        "axes": {name: [STEEL, "ptfe"]},
        "sweep": {"at": "last", "keep": "arrival"},
    })  # fmt: skip
    assert found.arrival.dims[0] == "materials"
    assert found.arrival.values[0] < found.arrival.values[1]


@pytest.mark.parametrize("name", ["material", "materials"])
def test_points_of_a_sweep_name_materials_in_two_ways(name, tmp_path):
    file = tmp_path / "points.csv"
    file.write_text(f"{name},velocity\n{STEEL},1e-3\nptfe,1e-3\n")
    rows = [{name: STEEL, "velocity": 1e-3}, {name: "ptfe", "velocity": 1e-3}]
    chain = {"radii": 5e-3, "beads": 5, name: "brass"}
    for points in (str(file), rows):
        found = hc.sweep({
            "chain": chain, "points": points, "sweep": {"at": "last", "keep": "arrival"},
        })  # fmt: skip
        assert found.materials.values.tolist() == [STEEL, "ptfe"]
        assert found.arrival.values[0] < found.arrival.values[1]


def test_points_of_a_sweep_name_materials_once(tmp_path):
    file = tmp_path / "points.csv"
    file.write_text("material,materials\nbrass,ptfe\n")
    row = {"material": "brass", "materials": "ptfe"}
    for points, said in ((str(file), "two columns 'materials'"), ([row], "twice, by two names")):
        with pytest.raises(hc.InputError, match=said):
            hc.sweep({"chain": {"radii": 5e-3, "beads": 5}, "points": points})


def test_one_size_of_a_dimer_is_that_of_both_kinds():
    one = hc.Chain.dimer(diameters="10 mm", materials=[STEEL, "ptfe"], beads=5)
    two = hc.Chain.dimer(diameters=["10 mm", "10 mm"], materials=[STEEL, "ptfe"], beads=5)
    assert one.radii.tolist() == two.radii.tolist() == 5 * [5e-3]
    assert one.materials == two.materials


def test_strikers_keep_their_sizes_if_radii_scatter():
    balls = hc.Chain.from_materials(5e-3, STEEL, beads=6)
    struck = balls.struck_by(velocity=0.1, diameter="8 mm", count=2, gap="1 mm")
    chain = struck.with_scatter(seed=3, relative=0.05)
    assert chain.radii[:2].tolist() == [4e-3, 4e-3]
    assert (chain.radii[2:] != 5e-3).all()
    assert chain.strikers == 2
    assert chain.velocities.tolist() == struck.velocities.tolist()
    assert chain.gaps.tolist() == struck.gaps.tolist()
    # The masses follow from the radii.
    assert chain.masses[2:] == pytest.approx(balls.masses[0] * (chain.radii[2:] / 5e-3) ** 3)
    assert struck.with_scatter(3, relative=0.05).radii.tolist() == chain.radii.tolist()
    every = struck.with_scatter(3, relative=0.05, beads="1:")
    assert (every.radii[:2] != 4e-3).all()
    assert every.radii[2:].tolist() == chain.radii[2:].tolist()
    scaled = hc.Chain.uniform(6).struck_by(radius=2.0).with_scatter(3, relative=0.05)
    assert scaled.radii[0] == 2.0
    assert (scaled.radii[1:] != 1.0).all()
    heavy = balls.struck_by(mass="1 g", radius="5 mm")
    assert heavy.with_scatter(3, relative=0.05).masses[0] == 1e-3
    with pytest.raises(hc.InputError, match="mass of bead 1, a striker, is given and would not"):
        heavy.with_scatter(3, relative=0.05, beads="1:")


def test_other_words_for_functions_are_explained():
    for word, meant in (("dispersion", "spectrum"), ("band_gap", "spectrum"), ("run", "simulate"),
                        ("solve", "simulate"), ("force", "wall_force"), ("plot", "plot_pulses"),
                        ("simulte", "simulate")):  # fmt: skip
        with pytest.raises(AttributeError, match=f"no attribute '{word}'; did you mean '.*{meant}"):
            getattr(hc, word)
    with pytest.raises(AttributeError, match="xyzzy"):
        _ = hc.xyzzy


def test_private_names_are_not_suggested_for_attributes():
    # Python suggests names of `dir`, here in the text of an uncaught error.
    code = "import hertzchain as hc; hc.simulate(hc.Chain.uniform(3)).peak_force"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert "'Run' object has no attribute 'peak_force'" in done.stderr
    assert "_wall_force" not in done.stderr
    chain = hc.Chain.uniform(3)
    for each in (chain, hc.bca(chain)):
        assert not [name for name in dir(each) if name[:1] == "_" != name[1:2]]


def test_the_class_of_chains_has_builders_and_methods_but_no_fields():
    code = "import hertzchain as hc; hc.Chain.taper('forward-linear', 0.01)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert "type object 'Chain' has no attribute 'taper'. Did you mean: 'tapered'?" in done.stderr
    fields = {each.name for each in dataclasses.fields(hc.Chain)}
    assert not fields & {*dir(hc.Chain)}
    assert fields < {*dir(hc.Chain.uniform(3))} | {"given"}


def test_help_names_methods_and_functions():
    titles = {"Run.reflection": hc.Run.reflection, "Run.waves": hc.Run.waves,
              "catalogue": hc.catalogue}  # fmt: skip
    for name, item in titles.items():
        words = f"Python Library Documentation: function {name.partition('.')[2] or name} in "
        assert pydoc.render_doc(item, renderer=pydoc.plaintext).startswith(words)
        assert item.__qualname__ == name


def test_completion_sees_the_fields_of_replace():
    found = inspect.signature(hc.Chain.uniform(3).replace).parameters
    fields = [each.name for each in dataclasses.fields(hc.Chain) if each.init]
    assert list(found) == fields
    assert {each.kind for each in found.values()} == {inspect.Parameter.KEYWORD_ONLY}
    completer = pytest.importorskip("IPython.core.completer").IPCompleter(
        namespace={"chain": hc.Chain.uniform(3)}, use_jedi=False
    )
    line = "chain.replace(right"
    completer.text_until_cursor = line
    matches = completer.python_func_kw_matches("right")
    assert "right_wall=" in matches


def test_completion_shows_public_names_only():
    modules = {"collision", "evaluation", "paper", "plotting", "theory", "vary"}
    assert {name for name in dir(hc) if inspect.ismodule(getattr(hc, name))} == modules
    for module in (hc, *(getattr(hc, name) for name in modules), hc.chain.materials):
        assert sorted(dir(module)) == sorted(module.__all__)
        for name in set(dir(module)) - modules:
            assert not inspect.ismodule(getattr(module, name)), name
    assert dir(hc.chain) == ["laws", "materials"]
    assert {"LAWS", "Loss", "restitution"} < {*dir(hc.chain.laws)}
    assert not {"annotations", "import_module", "_module"} & {*dir(hc.chain.laws)}
    completer = pytest.importorskip("IPython.core.completer").IPCompleter(
        namespace={"hc": hc}, use_jedi=False
    )
    found = completer.attr_matches("hc.chain.")
    assert {each for each in found if "._" not in each} == {"hc.chain.laws", "hc.chain.materials"}


def test_quantities_of_sensors_have_the_names_of_attributes_too():
    chain = hc.Chain.uniform(6, right_wall=hc.Wall())
    scatter = hc.Scatter(radius="1%", samples=2)
    for name in ("sensor.largest@4", "sensor.largest_so_far@4", "sensor_largest_so_far@4"):
        assert hc.distribution(chain, name, scatter).quantity == "sensor.largest@4"
        assert hc.gradient(chain, name, until=9.0).quantity == "sensor.largest@4"


def test_the_last_bead_of_a_gradient():
    chain = hc.Chain.uniform(6)
    for name, usual in (("pulse.velocity@last", "pulse.velocity@6"),
                        ("velocity@last", "pulse.velocity@6"),
                        ("peak_force@last", "pulse.peak_force@5")):  # fmt: skip
        found = hc.gradient(chain, name)
        assert found.quantity == usual
        assert found.value == hc.gradient(chain, usual).value
    with pytest.raises(hc.InputError, match="bead of 'velocity@end' must be a number or 'last'"):
        hc.gradient(chain, "velocity@end")
    with pytest.raises(
        hc.InputError, match="unknown quantity 'velocty'.*did you mean 'pulse.velocity'"
    ):
        hc.gradient(chain, "velocty@3")


def test_one_quantity_in_a_plot():
    pulse = hc.bca(hc.Chain.uniform(5))
    with pytest.raises(hc.InputError, match="plot_pulses draws one quantity, .* once for each"):
        hc.plot_pulses([pulse], ["velocity", "momentum"])
    with pytest.raises(hc.InputError, match="did you mean 'velocity'"):
        hc.plot_pulses([pulse], "velocty")


def test_a_free_end_has_no_contact():
    run = hc.simulate(hc.Chain.uniform(5), until=10.0)
    for contact, side in ((0, "left"), (5, "right")):
        for ask in (run.force, run.overlap):
            with pytest.raises(hc.InputError, match=f"the {side} end of .* add a {side}_wall"):
                ask(contact)
    with pytest.raises(
        hc.InputError,
        match="from 0 to 5, where 0 and 5 are walls, got 6",
    ):
        run.force(6)


def test_missing_attributes_of_a_run_name_the_usual_ones():
    run = hc.simulate(hc.Chain.uniform(3))
    with pytest.raises(
        AttributeError, match="no attribute 'peak_force'; use pulse\\(\\).peak_force"
    ):
        run.peak_force  # noqa: B018
    assert not hasattr(run, "weight")
    for item, name, meant in (
        (
            run,
            "peak_force",
            r"a Run has no entries, got \['peak_force'\]; use pulse\(\).peak_force",
        ),
        (run, "velocitys", "use the attribute or method velocity"),
        (run.pulse(), "peak_forc", "a Pulse has no entries.* method peak_force"),
        (run.pulse(), 0, "dir lists"),
    ):
        with pytest.raises(hc.InputError, match=meant):
            item[name]
    with pytest.raises(TypeError, match="not iterable"):
        list(run)
