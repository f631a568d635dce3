"""Chains from TOML and CSV files: each feature once, and invalid files."""

import re
import tomllib

import numpy as np
import pytest

import hertzchain as hc
from hertzchain import Chain, InputError, Wall
from hertzchain.store.chain_files import chain_from
from hertzchain.store.results import document_of

FIELDS = (
    "radii", "exponent", "taper", "rate", "masses", "stiffness", "units", "velocities", "gaps",
    "strikers", "precompression", "held_by", "gravity", "left_wall", "right_wall", "loss",
    "materials",
)  # fmt: skip


def written(folder, text, name="chain.toml"):
    path = folder / name
    path.write_text(text, "utf-8")
    return path


def assert_same(one, other):
    for name in FIELDS:
        left, right = getattr(one, name), getattr(other, name)
        if isinstance(left, np.ndarray):
            np.testing.assert_array_equal(left, right, err_msg=name)
        else:
            assert left == right, name
    times = np.linspace(0.0, 2.0, 9)
    assert (one.drive is None) == (other.drive is None)
    if one.drive is not None:
        np.testing.assert_array_equal(one.drive.value(times), other.drive.value(times))


STEEL = "steel-52100"


@pytest.mark.parametrize("row", ['radii = ["1 mm", "2 mm"]', "[chain]\nbeads = 9"])
def test_a_toml_file_is_not_a_table_of_beads(row, tmp_path):
    (tmp_path / "row.toml").write_text(row)
    (tmp_path / "chain.toml").write_text('[chain]\nfile = "row.toml"\n')
    with pytest.raises(hc.InputError, match=r"row.toml: is a TOML file.*\(CSV.*copy the keys of"):
        hc.load_chain(tmp_path / "chain.toml")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("cell = [2, 1]\ncells = 3", Chain.periodic([2, 1], cells=3)),
        ("cell_diameters = [4, 2]\ncells = 3", Chain.periodic([2, 1], cells=3)),
        ("mass_ratio = 0.3428\nbeads = 6", Chain.dimer(0.3428, beads=6)),
        (
            'radii = 5e-3\nbeads = 4\nmaterials = "brass"',
            Chain.from_materials(5e-3, "brass", beads=4),
        ),
        (
            'radii = [5e-3, 4e-3]\nmaterials = ["brass", "glass"]\nvelocity = 2',
            Chain.from_materials([5e-3, 4e-3], ["brass", "glass"], velocity=2.0),
        ),
        (
            'taper = "forward-linear"\nrate = 0.1\nbeads = 4\nradius = 5e-3\nmaterials = "brass"',
            Chain.from_materials(
                5e-3 * Chain.tapered("forward-linear", 0.1, beads=4).radii, "brass"
            ),
        ),
        (
            'cell = [5e-3, 4e-3]\ncells = 2\nmaterials = ["brass", "glass"]',
            Chain.periodic([5e-3, 4e-3], cells=2, materials=["brass", "glass"]),
        ),
        (
            'cell_diameters = ["1 cm", "8 mm"]\ncells = 2\nmaterials = ["brass", "glass"]',
            Chain.periodic([5e-3, 4e-3], cells=2, materials=["brass", "glass"]),
        ),
        (
            'units = "SI"\ncell_diameters = ["1 cm", "8 mm"]\ncells = 1\nmasses = [1e-3, 2e-3]\n'
            "stiffness = [1e9]",
            Chain([5e-3, 4e-3], units="SI", masses=[1e-3, 2e-3], stiffness=[1e9]),
        ),
        (
            'units = "SI"\nradii = [5e-3, 4e-3]\nmasses = [1e-3, 2e-3]\nstiffness = [1e9]',
            Chain([5e-3, 4e-3], units="SI", masses=[1e-3, 2e-3], stiffness=[1e9]),
        ),
        (
            'taper = "uniform"\nbeads = 4\n[chain.decorated]\nratio = 0.3\nbetween = 2',
            Chain.uniform(4).decorated(0.3, between=2),
        ),
        (
            'diameter = "20 mm"\nbeads = 4\nmaterials = "brass"\n[chain.decorated]\n'
            'diameter = "8 mm"',
            Chain.from_materials(10e-3, "brass", beads=4).decorated(radius=4e-3),
        ),
        (
            'taper = "uniform"\nbeads = 9\n[[chain.with_defects]]\nbead = 3\nradius = 0.5\n'
            "[[chain.with_defects]]\nbead = 7\nradius = 2\n[chain.with_scatter]\nseed = 4\n"
            "relative = 0.1",
            Chain.uniform(9).with_defects({3: 0.5, 7: 2.0}).with_scatter(4, relative=0.1),
        ),
        (
            'taper = "uniform"\nbeads = 3\ngaps = [0, 0.1]\n[[chain.struck_by]]\nmass = 4\n'
            "velocity = 2\ngap = 0.5\n[chain.right_wall]\nrigid = true\n[chain.loss]\n"
            'law = "restitution"\ncoefficient = 0.9',
            Chain.uniform(3)
            .replace(gaps=[0, 0.1])
            .struck_by(mass=4.0, velocity=2.0, gap=0.5)
            .replace(right_wall=Wall.rigid(), loss=hc.Restitution(0.9)),
        ),
        (
            'taper = "forward-linear"\nrate = "5%"\nbeads = 4\n[chain.loss]\nlaw = "restitution"\n'
            'coefficient = "95%"\n[chain.with_scatter]\nseed = 4\nrelative = "1 %"',
            Chain.tapered("forward-linear", 0.05, beads=4)
            .replace(loss=hc.Restitution(0.95))
            .with_scatter(4, relative=0.01),
        ),
        (
            'taper = "uniform"\nbeads = 3\nprecompression = 0.5\nheld_by = "force"\n'
            'gravity = 0.01\n[chain.drive]\nkind = "sine-burst"\namplitude = 0.1\nfrequency = 2',
            Chain.uniform(3).replace(
                precompression=0.5, held_by="force", gravity=0.01, drive=hc.SineBurst(0.1, 2.0)
            ),
        ),
        (
            'radii = 5e-3\nbeads = 3\nmaterials = "mine"\n[chain.right_wall]\nmaterial = "mine"\n'
            "gap = 1e-5\n[materials.mine]\ndensity = 1000\nyoung = 1e9\npoisson = 0.25",
            Chain.from_materials(
                5e-3, hc.Material("mine", 1000, 1e9, 0.25), beads=3,
                right_wall=Wall.of(hc.Material("mine", 1000, 1e9, 0.25), gap=1e-5),
            ),
        ),
    ],
)  # fmt: skip
def test_files_and_python_describe_the_same_chain(tmp_path, text, expected):
    loaded = hc.load_chain(written(tmp_path, f"[chain]\n{text}\n"))
    assert_same(loaded, expected)
    # The written file describes the same chain.
    again = written(tmp_path, hc.chain_as_toml(expected), "again.toml")
    assert_same(hc.load_chain(again), expected)


def test_one_table_in_a_list_is_the_law_of_all_contacts(tmp_path):
    law = '[[chain.loss]]\nlaw = "restitution"\ncoefficient = 0.9'
    text = f'[chain]\ntaper = "uniform"\nbeads = 3\n{law}'
    assert hc.load_chain(written(tmp_path, text)).loss == hc.Restitution(0.9)


@pytest.mark.parametrize(
    "loss",
    [
        hc.Restitution(0.9, attractive=False), hc.Viscoelastic(1e-6), hc.UnloadingRatio(0.1),
        hc.VelocityPower(0.1, 1.81), hc.Dashpot(6.0), hc.WaltonBraun(0.8),
    ],
)  # fmt: skip
def test_every_loss_can_be_written_and_read(tmp_path, loss):
    chain = Chain.uniform(3).replace(loss=loss)
    assert hc.load_chain(written(tmp_path, hc.chain_as_toml(chain))).loss == loss


def test_every_drive_can_be_written_and_read(tmp_path):
    for drive in (hc.StepDrive(2.0, 0.5, "displacement"), hc.TableDrive([0, 1, 2], [0, 3, 1])):
        chain = Chain.uniform(3).replace(drive=drive, left_wall=Wall())
        assert_same(hc.load_chain(written(tmp_path, hc.chain_as_toml(chain))), chain)


def test_beads_from_a_table(tmp_path):
    path = written(
        tmp_path,
        "# measured\n diameter [mm] ,material,gap [um],velocity [cm/s],bead\n"
        "10.0,brass,2,50,1\n\n9.5,glass,0,0,2\n9.0,brass,,0,3\n",
        "beads.csv",
    )
    expected = Chain.from_materials(
        [5e-3, 4.75e-3, 4.5e-3], ["brass", "glass", "brass"], gaps=[2e-6, 0],
        velocities=[0.5, 0, 0],
    )  # fmt: skip
    chain = hc.load_chain(path)
    for name in ("radii", "masses", "stiffness", "gaps", "velocities"):
        np.testing.assert_allclose(getattr(chain, name), getattr(expected, name), rtol=1e-14)
    toml = written(tmp_path, '[chain]\nfile = "beads.csv"\n[chain.right_wall]\nmaterial = "glass"')
    assert hc.load_chain(toml).right_wall == Wall.of("glass")


def test_a_table_without_units_is_scaled(tmp_path):
    chain = hc.load_chain(written(tmp_path, "radius,gap\n2,0.1\n1,\n", "beads.csv"))
    np.testing.assert_array_equal(chain.radii, [1.0, 0.5])
    np.testing.assert_array_equal(chain.gaps, [0.1])
    assert chain.units == "scaled"


def test_an_empty_mass_is_that_of_a_sphere(tmp_path):
    rows = "diameter [mm],material,mass [g]\n10,brass,{}\n8,glass,{}\n6,brass,{}\n"
    spheres = Chain.from_materials(diameters=["10 mm", "8 mm", "6 mm"],
                                   materials=["brass", "glass", "brass"])  # fmt: skip
    chain = hc.load_chain(written(tmp_path, rows.format("", 0.5, ""), "beads.csv"))
    masses = [spheres.masses[0], 0.5e-3, spheres.masses[2]]
    np.testing.assert_allclose(chain.masses, masses, rtol=1e-15)
    # A column without any mass has no effect.
    assert hc.load_chain(written(tmp_path, rows.format("", "", ""), "beads.csv")) == spheres
    # Also of custom materials, and in scaled variables.
    own = '[chain]\nfile = "beads.csv"\n[materials.brass]\ndensity = 4000\nyoung = 1e11\n'
    written(tmp_path, rows.format("", 0.5, 1.0), "beads.csv")
    light = hc.load_chain(written(tmp_path, own + "poisson = 0.3")).masses
    assert light[0] == pytest.approx(4000.0 * 4.0 / 3.0 * np.pi * 5e-3**3)
    scaled = hc.load_chain(written(tmp_path, "radius,mass\n2,\n1,0.5\n1,\n", "beads.csv"))
    np.testing.assert_array_equal(scaled.masses, [1.0, 0.5, 0.125])


def test_a_byte_order_mark_and_other_line_ends_are_read_over(tmp_path):
    path = tmp_path / "beads.csv"
    path.write_bytes("\ufeffradius [mm],material\r\n5,brass\r\n4,brass\r\n".encode())
    assert hc.load_chain(path).beads == 2


def test_drives_from_a_table(tmp_path):
    path = written(tmp_path, "time [us],force [kN]\n0,0\n10,0.5\n", "hammer.csv")
    drive = hc.load_drive(path)
    np.testing.assert_allclose(drive.times, [0.0, 1e-5], rtol=1e-14)
    np.testing.assert_allclose(drive.values, [0.0, 500.0])
    chain = written(
        tmp_path,
        '[chain]\nradii = 5e-3\nbeads = 3\nmaterials = "brass"\n[chain.drive]\nkind = "table"\n'
        'file = "hammer.csv"\n',
    )
    assert hc.load_chain(chain).drive.of == "force"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("radius [mm],material\n5,brass\n5\n", "row 2 has 1 cell, but the header has 2"),
        ("radius [mm],materal\n5,brass\n", "unknown column 'materal'.*did you mean 'material'"),
        ("radius [mm],radius [mm]\n5,5\n4,4\n", "column 'radius' occurs 2 times"),
        ("radius [mm],radius [m]\n5,5\n4,4\n", "column 'radius' occurs 2 times"),
        ("material\nbrass\nbrass\n", "requires either a column radius or a column diameter"),
        (
            "radius [mm],diameter [mm],material\n5,10,brass\n5,10,brass\n",
            "either a column radius or a",
        ),
        ("radius [mm],material\n5,brass\nfive,brass\n", "row 2 of column 'radius' is 'five'"),
        ("radius [mm],material\n5,brass\n,brass\n", "row 2 of column 'radius' is empty"),
        ("radius [mm],material\n5,brass\n5,\n", "row 2 of column 'material' is empty"),
        (
            "radius [mm],mass [g]\n5,1\n5,\n",
            "row 2 of column 'mass' is empty: .* add a column material, or give all masses",
        ),
        ("radius,velocity\n5,1\n5,\n", "row 2 of column 'velocity' is empty; write 0 for a bead"),
        ("radius,gap\n5,\n5,\n", "row 1 of column 'gap' is empty; write 0 for beads that touch"),
        ("radius,stiffness\n5,\n5,\n", "'stiffness' is empty; give that of every contact, or"),
        ("radius [mm],material\n5,brass\nnan,brass\n", "row 2 of column 'radius' is 'nan'"),
        (
            "diameter [mm],material\n5,brass\n-10,brass\n",
            "row 2 of column 'diameter' is '-10' \\[mm\\]: it must be above 0",
        ),
        ("radius,mass\n1,1\n1,0\n", "row 2 of column 'mass' is '0': it must be above 0"),
        (
            "radius,material\n5 mm,brass\n5 mm,brass\n",
            "'radius' is '5 mm': .* a number; write 5, and the unit in the header: radius \\[mm\\]",
        ),
        ("radius [mm],material\n5 mm,brass\n5,brass\n", "; write 5, .* radius \\[mm\\]"),
        ("radius [mm],material\n5 cm,brass\n5,brass\n", "'5 cm': .*; convert it to mm, the unit"),
        ("radius [furlong],material\n5,brass\n5,brass\n", "unit of column 'radius' 'furlong'"),
        ("radius,material\n5,brass\n5,brass\n", r"write radius \[mm\]"),
        ("radius [mm],gap,material\n5,0,brass\n5,,brass\n", r"'gap' has no unit.*write gap \["),
        ("radius [mm],material [m]\n5,brass\n", "column 'material' must have no unit, got"),
        ("radius [mm],gap [um],material\n5,0,brass\n5,1,brass\n", "last row must be empty"),
        (
            "radius [mm],gap [um],material\n5,-1,brass\n5,,brass\n",
            "row 1 of column 'gap' is '-1' \\[um\\]: it must be at least 0",
        ),
        ("radius [mm],material\n5,bras\n5,brass\n", "row 1: unknown material 'bras'"),
        ("bead,radius\n1,5\n3,5\n", "column 'bead' must count 1, 2, 3"),
        ("radius [mm]\n5\n5\n", "requires masses or materials"),
        ("", "no header"),
    ],
)
def test_bad_bead_tables_name_row_and_column(tmp_path, text, said):
    with pytest.raises(InputError, match=said) as caught:
        hc.load_chain(written(tmp_path, text, "beads.csv"))
    assert "beads.csv" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("time [us],force [N]\n0,0\n10,5\n10,6\n", "that of row 3 is 1e-05 after 1e-05"),
        ("time [us]\n0\n1\n", "either force or displacement, got time"),
        ("time [us],force [N],displacement [um]\n0,0,0\n1,1,1\n", "either force or"),
        ("time [us],force [N]\n0,0\n", "at least two times"),
    ],
)
def test_bad_drive_tables_are_rejected(tmp_path, text, said):
    with pytest.raises(InputError, match=said) as caught:
        hc.load_drive(written(tmp_path, text, "drive.csv"))
    assert "drive.csv" in str(caught.value)


U = 'taper = "uniform"\nbeads = 3\n'
SI = 'radii = 5e-3\nbeads = 3\nmaterials = "brass"\n'


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (U + "radii = [1, 2]", "has taper and also radii"),
        (U + "cells = 3", "has taper and also cells"),
        ("cell = [1, 2]", "no cells, which goes with cell"),
        ("cell = [1, 2]\ncell_diameters = [2, 4]\ncells = 2", "cell and also cell_diameters"),
        ("cell_diameters = [1, -2]\ncells = 2", "diameter of bead 2 .*-2"),
        (U + "velocity = 2.0", "has velocity but no materials: .* omit velocity"),
        (U + "radius = 2.0", "has radius but no materials"),
        ('taper = "uniform"\nbeads = 3\nmaterials = "brass"', "no radius, which goes with taper"),
        ('mass_ratio = 0.5\nbeads = 3\nmaterials = "brass"', "mass_ratio, which describes a"),
        (SI + "velocity = 1\nvelocities = [1, 0, 0]", "has velocity and also velocities"),
        ('file = "beads.csv"\nmaterials = "brass"', "file and also materials"),
        ('file = "none.csv"', r"none\.csv.*No such file"),
        ('radii = 5e-3\nbeads = 3\nmaterials = 3', "materials of .chain. must be a name, got 3"),
        (U + "right_wall = 3", r"\[chain.right_wall\] must be a table"),
        (U + "[chain.right_wall]\nstif = 3", r"key of \[chain.right_wall\] 'stif'.*stiffness"),
        (U + '[chain.right_wall]\nrigid = true\nmaterial = "brass"', "omit one"),
        (
            U + '[chain.right_wall.loss]\nlaw = "elastic"\nbetween = ["brass", "ptfe"]',
            r"loss of \[chain.right_wall\] has between, but .* omit between",
        ),
        (U + "[[chain.exponent]]\nvalue = 2.0", r"\[chain.exponent\] requires between"),
        (
            U + 'exponent = [{between = ["brass"], value = 2}]',
            r"between of \[chain.exponent\] must have two materials, got \['brass'\]",
        ),
        (U + 'exponent = [{between = ["brass", "ptfe"], value = 2}]', "needs a chain of materials"),
        (U + "exponent = [1.5, {value = 2}]", r"must be a table, such as \{between"),
        (SI + "[chain.with_contacts]\nangle = 5.0", "has no shape: choose from cone, crossed-cyl"),
        (SI + 'with_contacts = {shape = "cone"}', r"\[chain.with_contacts\] requires half_angle"),
        (
            SI + 'with_contacts = {shape = "cone", half_angle = 70, angle = 3}',
            r"unknown key of \[chain.with_contacts\] 'angle' .did you mean 'half_angle'",
        ),
        (SI + 'with_contacts = {shape = "cone", half_angle = 70, contacts = [4]}',
         "0 to 3, where 0 and 3 are walls"),
        (SI + 'with_contacts = {shape = "cone", half_angle = 70, contacts = 3}', "no right_wall"),
        (
            SI + 'with_contacts = {shape = "cone", half_angle = 70, contacts = [1.5]}',
            "contacts of .chain.with_contacts. must be a whole number, got 1.5",
        ),
        (
            U + "[chain.loss]\ncoefficient = 0.9",
            r"\[chain.loss\] has no law: choose from dashpot, elastic, elastic-plastic, rest",
        ),
        (U + '[chain.loss]\nlaw = "restitutoin"', "did you mean 'restitution'"),
        (U + '[chain.loss]\nlaw = "restitution"', r"\[chain.loss\] requires coefficient"),
        (U + '[chain.loss]\nlaw = "restitution"\ncoefficient = 2', "at most 1, got 2"),
        (U + '[chain.loss]\nlaw = "restitution"\ncoefficient = "9 mm"', "must have no unit"),
        (U + '[chain.loss]\nlaw = "restitution"\ncoefficient = "much"', "a percentage such as"),
        (U + '[chain.with_scatter]\nseed = 1\nrelative = "31%"', "at most 30%"),
        (U + "[chain.drive]\namplitude = 0.9", r"\[chain.drive\] has no kind: choose from sine"),
        (U + "[chain.loss]\nlaw = 3", r"unknown law of \[chain.loss\] 3: choose from"),
        (U + '[chain.drive]\nkind = "sine"', "did you mean 'sine-burst'"),
        (U + '[chain.drive]\nkind = "table"\nfile = "a.csv"\nof = "force"',
         r"\[chain.drive\] has file and also of: omit it"),
        (U + '[chain.drive]\nkind = "table"\ntimes = [0, 1]\nvalues = [0, 1]\ngain = "1 N/V"',
         r"\[chain.drive\] has gain, but no file"),
        (U + '[chain.drive]\nkind = "table"\ntimes = [0, 0]\nvalues = [1, 1]', "must increase"),
        (U + "[chain.with_scatter]\nrelative = 0.1", "requires seed"),
        (U + "[[chain.with_defects]]\nbead = 2", r"requires radius or diameter \(radius of"),
        (U + "[[chain.with_defects]]\nbead = 2\nradius = 1\ndiameter = 2",
         "of bead 2 has a radius and a diameter: omit one"),
        (SI + 'with_defects = {bead = 2, diameter = "4 kg"}', "diameter .* unit such as m"),
        (U + "[chain.decorated]\nration = 0.3", "did you mean 'ratio'"),
        (U + "[[chain.struck_by]]\nspeed = 3", r"'speed' .did you mean 'velocity'.*choose"),
        (
            U + "wall = 1\nnumber = 3\nxyz = 4",
            r"unknown keys of \[chain\] 'wall' \(did you mean 'right_wall'\?\), 'number' \(did you "
            r"mean 'beads'\?\), 'xyz': choose from",
        ),
        (U + "strikers = [2.0]", r"got \[2.0\] \(.*\[\[chain.struck_by\]\] adds others"),
        (SI + "[materials.mine]\ndensity = 1.0\nyoung = 1.0", r"\[materials.mine\] requires poi"),
        (U + "gaps = [0, -1]", "gap of contact 2 is -1"),
        (U + "masses = [1, 1, 1]\n[[chain.with_defects]]\nbead = 2\nradius = 0.5",
         "has masses, which would not follow the radii that with_defects changes"),
        (U + "stiffness = [1, 1]\n[chain.with_scatter]\nseed = 1\nrelative = 0.01",
         "has stiffness, which would not follow the radii that with_scatter changes"),
        (U + "precompression = 1", "left end .* is free"),
        (U + "masses = [1, 2]", "3 numbers for the masses"),
    ],
)  # fmt: skip
def test_errors_of_chain_files_state_the_problem(tmp_path, text, said):
    with pytest.raises(InputError, match=said) as caught:
        hc.load_chain(written(tmp_path, f"[chain]\n{text}\n"))
    assert "chain.toml" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ("radius\n1\nnan\n", "row 2 of column 'radius' is 'nan': it must be finite"),
        ("radius\n-inf\n1\n", "row 1 of column 'radius' is '-inf': it must be finite"),
        ("radius\n1\nbig\n", "row 2 of column 'radius' is 'big': it must be a number"),
        ("radius [mm]\n", r"list of numbers, one for each bead, got \[\]$"),
    ],
)
def test_numbers_in_tables_are_finite(tmp_path, table, said):
    file = tmp_path / "beads.csv"
    file.write_text(table)
    with pytest.raises(hc.InputError, match=said):
        hc.load_chain(file)


DEEP = "[" * 3000 + "]" * 3000


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("file = 5", "file of .chain. must be a path, got 5"),
        ("file = {a = 1}", "file of .chain. must be a path"),
        ('file = ""', "file of .chain. must be a path, got ''"),
        (U + "drive = {kind = 'table', file = 5}", "file of .chain.drive. must be a path, got 5"),
        (U + "drive = {kind = 'table'}", "has no times; a table has times and values or a file"),
        (SI + "radius = 2026-01-01", "radius of .chain. must be a number"),
        (SI.replace("5e-3", "{a = 1}"), r"radii of .chain. must be a list, or a table such as"),
        (SI.replace("5e-3", "'5 kg'"), "radii of .* must have a unit such as m, cm, mm.* got 'kg'"),
        (SI.replace("5e-3", "['5 mm', '-5 mm']"), "radius of bead 2 is '-5 mm'"),
        (SI.replace("radii = 5e-3", "diameters = ['5 mm', '-5 mm']"),
         "diameter of bead 2 is '-5 mm': it must be finite and above 0"),
        ("diameters = [20, 0]", "diameter of bead 2 is 0: it must be finite and above 0"),
        (SI.replace("radii = 5e-3", "diameters = ['5 mm', '6 mm']"),
         "beads = .*, but there are 2 diameters"),
        (SI.replace("5e-3", "'5 furlong'"), "unit of radii .* 'furlong': choose from m, cm"),
        (SI.replace("5e-3", "'10,5 mm'"),
         "got '10,5 mm'; write 10.5 mm with a decimal point, or 10 mm, 5 mm for two values$"),
        (SI.replace("5e-3", "'5,5 mm,5,5 mm'"),
         "write 5.5 mm with a decimal point, or a list in brackets$"),
        (SI.replace("5e-3", "['10,5 mm', '5 mm']"),
         "value 1 of radii .* got '10,5 mm'; write 10.5 mm with a decimal point$"),
        (SI + "velocity = '0,5 m'",
         "got '0,5 m'; write 0.5 with a decimal point and a unit such as m/s, cm/s, mm/s$"),
        (SI.replace("5e-3", "true"), "radii of .chain. must be a number, .* got True"),
        (U + "radius = true", "radius of .chain. must be a number, .* got True"),
        ('cell = [5e-3]\ncells = "2"\nmaterials = "brass"', "cells .* whole number, got '2'"),
        ('cell = [5e-3]\ncells = 2.5\nmaterials = "brass"', "cells .* whole number, got 2.5"),
        ('cell = [5e-3]\ncells = -2\nmaterials = "brass"', "cells must be .* at least 1, got -2"),
        ('cell = [5e-3]\ncells = 9000000000000\nmaterials = "brass"', "GiB of memory, but"),
        ("cell = [[1], [1, 2]]\ncells = 2", "cell of .chain. must be a list of numbers, got"),
        ("radii = [[1, 2], [3, 4]]", "radii of .chain. must be a list of numbers, got"),
        (U + "with_defects = [{bead = [1], radius = 0.5}]", "bead .* whole number, got .1."),
        (U + "with_defects = 3", r"\[chain.with_defects\] must be a table, got 3"),
        (U + "with_scatter = {seed = 1, rng = 2, relative = 0.1}", "unknown key .* 'rng'"),
        (U + 'right_wall = {rigid = "false"}', "rigid .* must be true or false, got 'false'"),
        (U + "right_wall = true", r"must be a table, such as \{rigid = true\}.*got True"),
        (U + "loss = 0.95", r'such as \{law = "restitution", coefficient = 0.95\}, got 0.95'),
        (U + 'units = "banana"', "unknown units of .chain. 'banana': choose from scaled, SI"),
        (U + "units = 3", "unknown units of .chain. 3: choose from scaled, SI"),
        (U + 'units = ["SI"]', "unknown units of .chain. .'SI'.: choose from scaled, SI"),
        (U + 'units = "SI "', "unknown units of .chain. 'SI ' .did you mean 'SI'"),
        (SI + 'units = "scaled"', "has units = 'scaled' and also materials"),
        (SI.replace("brass", "steel"), "did you mean 'steel-52100', 'steel-304', 'steel-316' or"),
        (SI + '[materials.x]\nname = "y"\ndensity = 1.0\nyoung = 1.0\npoisson = 0.3', "'name'"),
        (SI + "[materials]\nx = 3", r"\[materials.x\] must be a table, got 3"),
        (U + "exponent = '2 m'", "exponent of .chain. must be a number, got '2 m'"),
        (U + "gaps = ['1 um', 0]", "gap has a unit .'1 um'., but the chain is in scaled"),
        (U + "right_wall = {gap = '1 um'}", "right_wall has a unit in its gap, but .* scaled"),
        (U + 'gaps = {list = [1, "2"], unit = "mm"}', "list of plain numbers next to its unit"),
        (U + "gaps = {list = [1, 2], unit = 3}", "unit of gaps of .chain. must be text, got 3"),
        (U + "rate = " + DEEP, "is nested too deeply"),
        (U + "rate = " + "9" * 5001, "a whole number of thousands of digits"),
    ],
)  # fmt: skip
def test_values_of_the_wrong_type_are_rejected(tmp_path, text, said):
    with pytest.raises(InputError, match=said) as caught:
        hc.load_chain(written(tmp_path, f"[chain]\n{text}\n"))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            'taper = "forward-linear"\nrate = 0.1\nbeads = 4\nradius = "5 mm"\nmaterials = "brass"',
            Chain.from_materials(
                5e-3 * Chain.tapered("forward-linear", 0.1, beads=4).radii, "brass"
            ),
        ),
        (
            'radii = {list = [5, 4.5], unit = "mm"}\nmaterials = "brass"\nvelocity = "1 m/s"',
            Chain.from_materials([5e-3, 4.5e-3], "brass", velocity=1.0),
        ),
        (
            'cell = ["5 mm", 4e-3]\ncells = 2\nmaterials = "brass"\nprecompression = "1 kN"\n'
            'left_wall = {}\nright_wall = {}',
            Chain.periodic([5e-3, 4e-3], cells=2, materials="brass", precompression=1000.0,
                           left_wall=Wall(), right_wall=Wall()),
        ),
        (
            'units = "SI"\ncell = [5e-3, 4e-3]\ncells = 2\nmasses = ["1 g", "2 g", 3e-3, 4e-3]\n'
            'stiffness = "7 N/um^1.5"\ngaps = {list = [1, 0, 2.5], unit = "um"}',
            Chain([5e-3, 4e-3] * 2, units="SI", masses=[1e-3, 2e-3, 3e-3, 4e-3], stiffness=7e9,
                  gaps=[1e-6, 0, 2.5e-6]),
        ),
        (
            SI + 'with_defects = [{bead = 2, diameter = "8 mm"}, {bead = 3, radius = "3 mm"}]',
            Chain.from_materials(5e-3, "brass", beads=3).with_defects({2: 4e-3, 3: 3e-3}),
        ),
        (
            SI + 'with_defects = {bead = 2, radius = "4 mm"}\n'
            'struck_by = {mass = "2 g", gap = "1 um"}\nloss = {law = "dashpot", gamma = "6 kg/s"}\n'
            'drive = {kind = "table", times = {list = [0, 1], unit = "ms"}, values = ["0 N", 3]}',
            Chain.from_materials(5e-3, "brass", beads=3).with_defects({2: 4e-3})
            .struck_by(mass=2e-3, gap=1e-6)
            .replace(loss=hc.Dashpot(6.0), drive=hc.TableDrive([0, 1e-3], [0, 3])),
        ),
    ],
)  # fmt: skip
def test_units_in_chain_files(tmp_path, text, expected):
    loaded = hc.load_chain(written(tmp_path, f"[chain]\n{text}\n"))
    assert_same(loaded, expected)
    again = written(tmp_path, hc.chain_as_toml(loaded), "again.toml")
    assert_same(hc.load_chain(again), expected)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("radius [mm];material\n5,0;brass\n4,5;brass\n", "separated by semicolons; .* commas"),
        ("radius [mm]\tmaterial\n5\tbrass\n", "separated by tabs; .* commas"),
        ("radius/mm,material\n5,brass\n", r"must be written as radius \[mm\]"),
        ("Radius_mm,material\n5,brass\n", r"must be written as radius \[mm\]"),
        ('radius [mm],material\n"5,5",brass\n4,brass\n', "use a decimal point: 5.5"),
        ("radius [kg],material\n5,brass\n", "column 'radius' must have a unit such as m, cm"),
        ("radius [mm],stiffness [N/m^2]\n5,1\n5,\n", "'stiffness' must have a unit such as"),
    ],
)  # fmt: skip
def test_tables_from_elsewhere_get_advice(tmp_path, text, said):
    with pytest.raises(InputError, match=said):
        hc.load_chain(written(tmp_path, text, "beads.csv"))


def test_units_of_tables_may_be_in_parentheses(tmp_path):
    beads = "Radius (mm),material\n5,brass\n4,brass\n"
    chain = hc.load_chain(written(tmp_path, beads, "beads.csv"))
    assert chain.radii.tolist() == [5e-3, 4e-3]
    (tmp_path / "hammer.csv").write_text("t [ms],Force (N)\n0,0\n0.5,80\n1,0\n")
    drive = hc.load_drive(tmp_path / "hammer.csv")
    assert drive.times.tolist() == [0.0, 5e-4, 1e-3]
    assert drive.of == "force"
    assert drive.values.tolist() == [0.0, 80.0, 0.0]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            {"right_wall": True},
            r"must be a Wall or None, got True; Wall\(\) has the material of the bead",
        ),
        ({"left_wall": "brass"}, r"got 'brass'; .*Wall.of\('brass'\)"),
        ({"loss": 0.95}, r"Restitution\(0.95\) with the coefficient .* got 0.95"),
        ({"drive": 100.0}, r"got 100.0; for example, StepDrive\(100.0\) is a force"),
    ],
)
def test_parts_in_python_get_advice(change, said):
    with pytest.raises(InputError, match=said):
        Chain.uniform(3).replace(**change)


def test_text_in_a_table_is_exactly_what_it_says(tmp_path):
    chain = hc.load_chain(
        written(tmp_path, "radius [mm],material\n9.3,brass\n4.1,brass\n", "b.csv")
    )
    assert chain.radii.tolist() == [9.3e-3, 4.1e-3]


STEEL = "steel-52100"
COMPACT = {
    "equal": (
        lambda: Chain.from_materials("10 mm", STEEL, beads=20, velocity="0.1 m/s"),
        {"diameters": "20 mm", "beads": 20, "materials": STEEL, "velocity": "0.1 m/s"},
    ),
    "struck": (
        lambda: Chain.from_materials("10 mm", STEEL, beads=20).struck_by(velocity=0.2),
        {"diameters": "20 mm", "beads": 20, "struck_by": [{"velocity": "0.2 m/s"}]},
    ),
    "uniform": (
        lambda: Chain.uniform(7, exponent=2.5),
        {"taper": "uniform", "beads": 7, "exponent": 2.5},
    ),
    "sizes": (
        lambda: Chain.tapered(first="10 mm", last="2.5 mm", beads=40, materials=STEEL),
        {"first_diameter": "20 mm", "last_diameter": "5 mm", "taper": "exponential", "beads": 40},
    ),
    "linear sizes": (
        lambda: Chain.tapered("linear", first="3 mm", last="8 mm", beads=11, materials="ptfe"),
        {"first_diameter": "6 mm", "last_diameter": "16 mm", "taper": "linear", "beads": 11},
    ),
    "rate": (
        lambda: chain_from({"chain": {
            "taper": "forward-exponential", "rate": 0.0625, "radius": "7 mm", "beads": 31,
            "materials": "brass"}}),
        {"taper": "forward-exponential", "rate": 0.0625, "radius": "7 mm", "beads": 31,
         "materials": "brass"},
    ),
    "dimer": (
        lambda: Chain.dimer(diameters=["10 mm", "6 mm"], materials=STEEL, beads=20),
        {"cell_diameters": ["10 mm", "6 mm"], "cells": 10, "materials": STEEL},
    ),
    "two materials": (
        lambda: Chain.periodic([9.5e-3, 9.5e-3], cells=5, materials=["steel-316", "ptfe"]),
        {"cell_diameters": ["19 mm", "19 mm"], "cells": 5, "materials": ["steel-316", "ptfe"]},
    ),
    "trimer": (
        lambda: Chain.periodic([2.0, 1.0, 0.3], cells=4),
        {"cell": [1.0, 0.5, 0.15], "cells": 4},
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", COMPACT)
def test_regular_chains_are_written_compactly_and_exactly(case):
    make, keys = COMPACT[case]
    chain = make()
    text = hc.chain_as_toml(chain)
    document = tomllib.loads(text)
    assert {key: document["chain"].get(key) for key in keys} == keys
    assert set(document) == {"chain"}
    again = chain_from(document)
    for name in ("radii", "masses", "stiffness", "velocities", "gaps"):
        assert np.array_equal(getattr(again, name), getattr(chain, name)), name
    assert again.materials == chain.materials
    assert again.strikers == chain.strikers
    assert hc.chain_as_toml(again) == text


def test_irregular_chains_are_written_bead_by_bead():
    radii = np.array([5e-3, 5e-3, 5e-3, 5e-3, np.nextafter(5e-3, 1.0)])
    chain = Chain.from_materials(radii, STEEL)
    document = tomllib.loads(hc.chain_as_toml(chain))
    assert document["chain"]["diameters"] == ["10 mm"] * 4 + ["10.000000000000002 mm"]
    assert chain_from(document).radii.tolist() == radii.tolist()
    taper = Chain.tapered(first="10 mm", last="2.5 mm", beads=9, materials=STEEL)
    bent = taper.radii.copy()
    bent[4] = np.nextafter(bent[4], 0.0)
    document = tomllib.loads(hc.chain_as_toml(Chain.from_materials(bent, STEEL)))
    assert chain_from(document).radii.tolist() == bent.tolist()


def test_sizes_are_written_in_millimetres_to_the_last_bit():
    rng = np.random.default_rng(1)
    radii = np.exp(rng.uniform(np.log(5e-6), np.log(0.5), 200))
    text = hc.chain_as_toml(Chain.from_materials(radii, STEEL))
    assert text.count(" mm") == 200
    assert hc.chain_from_toml(text).radii.tolist() == radii.tolist()
    # Powders are written in m, and documents of results in plain numbers.
    assert "radii = 1e-06\n" in hc.chain_as_toml(Chain.from_materials(1e-6, "glass", beads=3))
    plain = document_of(Chain.from_materials("4.7 mm", STEEL, beads=3))["chain_file"]["chain"]
    assert plain["radii"] == 4.7e-3


def test_only_own_materials_are_written_with_their_properties():
    own = hc.Material(STEEL, density=7800.0, young=2.0e11, poisson=0.3)
    document = tomllib.loads(hc.chain_as_toml(Chain.from_materials(5e-3, own, beads=4)))
    assert document["materials"][STEEL]["young"] == 2.0e11
    assert document["chain"]["materials"] == STEEL
    mixed = Chain.from_materials(5e-3, [own, STEEL, own])
    again = chain_from(tomllib.loads(hc.chain_as_toml(mixed)))
    assert [each.young for each in again.materials] == [each.young for each in mixed.materials]


def test_the_text_of_a_chain_file_is_read_like_the_file(tmp_path):
    chain = Chain.from_materials(5e-3, STEEL, beads=6, velocity=0.1).replace(right_wall=Wall())
    assert_same(hc.chain_from_toml(hc.chain_as_toml(chain)), chain)
    written(tmp_path, "radius [mm],material\n5,steel-52100\n4,steel-52100\n", "balls.csv")
    text = '[chain]\nfile = "balls.csv"\n'
    assert_same(hc.chain_from_toml(text, tmp_path), hc.load_chain(written(tmp_path, text)))
    assert_same(hc.chain_from_toml(f"\ufeff{text}", folder=str(tmp_path)),
                hc.load_chain(tmp_path / "chain.toml"))  # fmt: skip
    for wrong, message in (
        ("chain.toml", "load_chain reads a file"),
        ('[chain]\ntaper = "uniform"\nbeads = 3\nbaeds = 4', "unknown key of [chain] 'baeds'"),
        ('[chain]\ntaper = "uniform"\nbeads = 0', "beads"),
        ("[chain]\nbeads = " + "9" * 5000, "thousands of digits"),
        (b"[chain]", "text must be a str"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=re.escape(message)):
            hc.chain_from_toml(wrong)


@pytest.mark.parametrize("cap", [False, True])
def test_random_gaps_of_a_file_keep_its_masses_and_add_to_its_gaps(cap):
    text = (
        '[chain]\nmaterials = "brass"\nradii = ["5 mm", "5 mm", "4 mm"]\n'
        'masses = ["4 g", "5 g", "3 g"LAST]\ngaps = ["1 um", "2 um"NONE]\n'
        '[chain.with_scatter]\nseed = 1\ngaps = "5 um"\n'
    )
    last, none = (', "6 g"', ", 0") if cap else ("", "")
    text = text.replace("LAST", last).replace("NONE", none)
    read = hc.chain_from_toml(text + '[chain.cap]\nmass = "6 g"\n' * cap)
    same = hc.Chain.from_materials(["5 mm", "5 mm", "4 mm"], "brass")
    same = same.replace(masses=[4e-3, 5e-3, 3e-3], gaps=["1 um", "2 um"])
    same = same.with_scatter(1, gaps="5 um")
    balls = slice(None, 3)
    np.testing.assert_allclose(read.masses[balls], same.masses, rtol=1e-15)
    np.testing.assert_allclose(read.gaps[:2], same.gaps, rtol=1e-12)
    assert np.all(same.gaps > [1e-6, 2e-6])
    assert read.gaps[2:].tolist() == [0.0] * cap
    with pytest.raises(hc.InputError, match="has masses, which would not follow the radii"):
        hc.chain_from_toml(text + 'relative = "1%"\n')


@pytest.mark.parametrize("beads", ['taper = "uniform"', 'diameters = "9 mm"\nmaterial = "brass"'])
def test_the_material_of_a_wall_can_be_that_of_the_next_bead(tmp_path, beads):
    path = tmp_path / "chain.toml"
    wall = "right_wall = {material = 'same', gap = 1e-5}"
    path.write_text(f"[chain]\n{beads}\nbeads = 3\n{wall}\n")
    assert hc.load_chain(path).right_wall == hc.Wall(gap=1e-5)


ROW = '[chain]\ndiameters = "10 mm"\nbeads = 4\nvelocity = "0.1 m/s"\nmaterials = "brass"\n'


@pytest.mark.parametrize(
    ("text", "wall"),
    [
        ("same", Wall()),
        ("rigid", Wall.rigid()),
        (STEEL, Wall.of(STEEL)),
        ("5 kN/mm", Wall("5 kN/mm", exponent=1, loss=hc.Elastic())),
        ("2e10 N/m^1.5", Wall("2e10 N/m^1.5")),
    ],
)
def test_a_wall_as_text_is_that_of_the_option(text, wall, run, tmp_path):
    for side in ("left_wall", "right_wall"):
        chain = hc.chain_from_toml(f'{ROW}{side} = "{text}"\n')
        assert getattr(chain, side) == wall
        # Files that hertzchain writes have tables.
        assert isinstance(tomllib.loads(hc.chain_as_toml(chain))["chain"][side], dict)
    options = ("--material", "brass", "--diameter", "10 mm", "--beads", 4, "--speed", "1 mm/s")
    file = written(tmp_path, ROW.replace("0.1 m/s", "1 mm/s") + f'right_wall = "{text}"\n')
    found = [
        run("simulate", *chain, "--json").stdout for chain in ((*options, "--wall", text), (file,))
    ]
    assert "wall" in found[0]
    assert found[0] == found[1]


def test_a_wall_as_text_can_be_of_a_material_of_the_file():
    own = '[materials.lead]\ndensity = 11340\nyoung = "16 GPa"\npoisson = 0.44\n'
    chain = hc.chain_from_toml(f'{ROW}right_wall = "lead"\n{own}')
    assert chain.right_wall.material.density == 11340


@pytest.mark.parametrize(
    ("wall", "message"),
    [
        ("5", "right_wall of .chain. must be same, rigid, a material, or a stiffness .* got '5'"),
        ("", "right_wall of .chain. must be same, rigid, a material, or a stiffness .* got ''"),
        ("butter", "unknown material 'butter'"),
        ("5 mm", "right_wall of .chain. must be same"),
    ],
)
def test_other_texts_are_no_walls(wall, message):
    with pytest.raises(InputError, match=message):
        hc.chain_from_toml(f'{ROW}right_wall = "{wall}"\n')


@pytest.mark.parametrize(
    ("text", "given"),
    [
        ("5 g", {"mass": "5 g"}),
        ("5 g, steel-304", {"mass": "5 g", "material": "steel-304"}),
        ("5 g, 1 kN/mm", {"mass": "5 g", "stiffness": "1 kN/mm", "exponent": 1}),
    ],
)
def test_a_cap_as_text_is_that_of_the_option(text, given):
    chain = hc.chain_from_toml(f'{ROW}cap = "{text}"\n')
    assert chain == hc.chain_from_toml(ROW).with_cap(**given)


@pytest.mark.parametrize("beads", ['diameters = "10 mm"', 'taper = "uniform"\nradius = "5 mm"'])
def test_materials_of_a_file_repeat_in_turn(beads):
    text = f"[chain]\n{beads}\nbeads = 7\nmaterials = ['{STEEL}', 'glass', 'glass']\n"
    names = [each.name for each in hc.chain_from_toml(text).materials]
    assert names == [STEEL, "glass", "glass"] * 2 + [STEEL]


def test_the_diameter_of_a_taper_is_that_of_its_first_bead():
    text = "[chain]\ntaper = 'forward-exponential'\nrate = 0.05\nbeads = 6\nmaterials = 'brass'\n"
    chain = hc.Chain.tapered(
        "forward-exponential", 0.05, first_diameter="10 mm", beads=6, materials="brass"
    )
    assert hc.chain_from_toml(f"{text}diameter = '10 mm'") == chain
    with pytest.raises(hc.InputError, match="has first_diameter and diameter, which are the same"):
        hc.chain_from_toml(f"{text}diameter = '10 mm'\nfirst_diameter = '10 mm'")
    equal = text.replace("forward-exponential", "uniform").replace("rate = 0.05\n", "")
    with pytest.raises(hc.InputError, match="'uniform' and also diameter: omit taper"):
        hc.chain_from_toml(f"{equal}diameter = '10 mm'")
    with pytest.raises(hc.InputError, match="no argument 'diameter'; use first_diameter="):
        hc.Chain.tapered("forward-exponential", 0.05, diameter="10 mm", beads=6, material="brass")


def test_materials_that_do_not_repeat_once_have_a_warning():
    text = f"{ROW}".replace('"brass"', '["brass", "glass", "ptfe"]')
    with pytest.warns(hc.InputWarning, match="3 materials for 4 beads, .* bead 4 is of brass"):
        chain = hc.chain_from_toml(text)
    assert [each.name for each in chain.materials] == ["brass", "glass", "ptfe", "brass"]
    with pytest.raises(InputError, match="there must be 4 materials, one for each bead, got 5"):
        hc.chain_from_toml(ROW.replace('"brass"', '["brass", "glass", "ptfe", "brass", "ptfe"]'))


STEEL_ROW = (
    '[chain]\ndiameters = "10 mm"\nbeads = 4\nmaterials = "steel-52100"\nvelocity = "1 m/s"\n'
)


@pytest.mark.parametrize(
    ("text", "law"),
    [
        ("viscoelastic=0.6 us", hc.Viscoelastic("0.6 us")),
        ("restitution=0.95", hc.Restitution(0.95)),
        ("restitution = 95%, attractive=false", hc.Restitution(0.95, attractive=False)),
        ("elastic-plastic", hc.ElasticPlastic()),
        ("elastic-plastic, factor=2.8", hc.ElasticPlastic(factor=2.8)),
        ("elastic", hc.Elastic()),
    ],
)
def test_a_loss_can_be_the_text_of_the_option(tmp_path, text, law):
    chain = hc.load_chain(written(tmp_path, f'{STEEL_ROW}loss = "{text}"\n'))
    assert chain.loss == (None if isinstance(law, hc.Elastic) else law) or chain.loss == law


def test_a_loss_as_text_can_follow_from_a_collision(tmp_path):
    text = "viscoelastic, restitution=0.95, speed=1 m/s"
    table = '{law = "viscoelastic", restitution = 0.95, speed = "1 m/s"}'
    one, other = (
        hc.load_chain(written(tmp_path, f"{STEEL_ROW}loss = {each}\n")).loss
        for each in (f'"{text}"', table)
    )
    assert one == other


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("viscous=1", "unknown law of loss of [chain] 'viscous': choose from"),
        ("elastic=3", "elastic has no parameter"),
        ("restitution", "requires coefficient or restitution"),
        ("viscoelastic=0,6 us", "comma between two digits"),
        ("viscoelastic=", "must be a law with its parameter"),
        ("restitution=0.9, 0.8", "must be a law with its parameter"),
        ("restitution=0.9, coefficient=0.8", "two values of the coefficient"),
        ("restitution=0.9, x=1", "unknown key of [chain.loss] 'x'"),
        ("viscoelastic=true", "must be a number"),
    ],
)
def test_errors_of_losses_as_text(tmp_path, text, said):
    with pytest.raises(InputError, match=re.escape(said)):
        hc.load_chain(written(tmp_path, f'{STEEL_ROW}loss = "{text}"\n'))
