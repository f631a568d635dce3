"""Messages that state what to write instead."""

import pytest

import hertzchain as hc

ROW = """
[chain]
diameters = {diameters}
materials = "steel-52100"
beads = 3
[[chain.struck_by]]
mass = "50 g"
{striker}
"""


@pytest.mark.parametrize(
    ("striker", "hint"),
    [
        ("flat = true", "for a flat face, write radius = inf"),
        ('radius = "Inf"', "got 'Inf'; write inf without quotation marks"),
    ],
)
def test_mistakes_about_flat_strikers_are_explained(striker, hint, tmp_path):
    path = tmp_path / "chain.toml"
    path.write_text(ROW.format(diameters='"8 mm"', striker=striker))
    with pytest.raises(hc.InputError, match=hint):
        hc.load_chain(path)
    path.write_text(ROW.format(diameters='"8 mm"', striker="radius = inf"))
    assert hc.load_chain(path).striker_properties[0].flat


def test_an_empty_list_of_diameters_is_named_as_it_is_written(tmp_path):
    path = tmp_path / "chain.toml"
    path.write_text(ROW.format(diameters="[]", striker="radius = inf"))
    with pytest.raises(hc.InputError, match="diameters .*must have at least one number"):
        hc.load_chain(path)


@pytest.mark.parametrize("name", ["steel-440c", "Steel 440C"])
def test_steels_that_are_not_in_the_catalogue_are_answered_with_its_steels(name):
    kinds = "did you mean 'steel-52100' or 'steel-304' or 'steel-316'[?]"
    with pytest.raises(hc.InputError, match=kinds):
        hc.material(name)


def test_a_peak_force_without_a_bead_may_be_that_on_a_wall():
    chain = hc.Chain.uniform(9).replace(right_wall=hc.Wall())
    with pytest.raises(
        hc.InputError, match=r"peak_force@last; that on a wall is wall_force\.peak$"
    ):
        hc.Design(chain, minimise="peak_force", vary=[hc.vary.radii(0.5, 1.0)])


STRUCK = hc.Chain.from_materials("10 mm", "steel-52100", beads=4).struck_by(velocity="0.2 m/s")


@pytest.mark.parametrize(
    ("kind", "name", "meant"),
    [
        ("chain", "radius", "radii"),
        ("chain", "diameters", "radii"),
        ("chain", "rigth_wall", "right_wall"),
        ("chain", "plot", "hertzchain.plot_chain"),
        ("run", "walforce", "wall_force"),
        ("run", "time", "times"),
        ("run", "to_csv", "save"),
        ("pulse", "velocites", "velocity"),
        ("pulse", "force", "peak_force"),
        ("wall", "maximum", "peak"),
    ],
)
def test_misspelt_attributes_are_named(kind, name, meant):
    run = hc.simulate(STRUCK.replace(right_wall=hc.Wall()), times=20)
    items = {"chain": run.chain, "run": run, "pulse": run.pulse(), "wall": run.wall_force()}
    with pytest.raises(AttributeError) as raised:
        getattr(items[kind], name)
    assert str(raised.value).endswith(f"has no attribute {name!r}; did you mean {meant!r}?")
    # Python would add a second suggestion if it had the object.
    assert (raised.value.name, raised.value.obj) == (name, None)


def test_words_for_attributes_name_existing_ones():
    run = hc.simulate(STRUCK.replace(right_wall=hc.Wall()), times=20)
    for item in (run, run.chain, run.pulse(), run.wall_force()):
        for word, meant in item._other_words.items():
            assert not hasattr(item, word)
            owner, _, name = meant.rpartition(".")
            owners = {"": item, "hertzchain": hc, "Run": run, "wall_force()": run.wall_force()}
            assert hasattr(owners[owner], name)


def test_other_missing_attributes_have_no_hint():
    chain = hc.Chain.uniform(3)
    with pytest.raises(AttributeError, match="^'Chain' object has no attribute 'qwertz'$"):
        chain.qwertz  # noqa: B018
    with pytest.raises(AttributeError, match="has no attribute '_radii'$"):
        chain._radii  # noqa: B018


def test_errors_of_properties_are_not_hidden(monkeypatch):
    monkeypatch.setattr(hc.Chain, "description", property(lambda self: self.masses.nothing))
    with pytest.raises(AttributeError, match="'numpy.ndarray' object has no attribute 'nothing'"):
        hc.Chain.uniform(3).description  # noqa: B018
