"""Tapers of given sizes, and chains that are joined, cut and reversed."""

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.cli import main

STEEL = hc.Chain.tapered(
    first="10 mm", last="2.5 mm", beads=40, material="steel-52100", velocity="1 mm/s"
)
AT_REST = STEEL.replace(velocities=None)


@pytest.mark.parametrize("shape", ["linear", "exponential"])
@pytest.mark.parametrize("last", [0.25, 0.999, 1.001, 3.0])
def test_ends_ratio_and_length_give_the_same_taper(shape, last):
    by_last = hc.Chain.tapered(shape, first=1.0, last=last, beads=17)
    expected = np.linspace(1.0, last, 17) if shape == "linear" else np.geomspace(1.0, last, 17)
    np.testing.assert_allclose(by_last.radii, expected, rtol=1e-13)
    assert by_last.taper == f"{'forward' if last < 1.0 else 'backward'}-{shape}"
    by_ratio = hc.Chain.tapered(shape, ratio=last, beads=17)
    length = 2.0 * float(expected.sum())
    by_length = hc.Chain.tapered(shape, length=length, beads=17)
    np.testing.assert_allclose(by_ratio.radii, expected, rtol=1e-13)
    np.testing.assert_allclose(by_length.radii, expected, rtol=1e-12)


@pytest.mark.parametrize("sizes", [{"ratio": 1.0}, {"length": 20.0}, {"first": 3, "last": 3}])
@pytest.mark.parametrize("shape", ["linear", "exponential"])
def test_equal_ends_are_a_uniform_chain(shape, sizes):
    assert hc.Chain.tapered(shape, beads=10, **sizes).description == "uniform, 10 beads"


def test_diameters_are_twice_the_radii():
    ends = {"first_diameter": "20 mm", "last_diameter": "0.5 cm"}
    other = hc.Chain.tapered(**ends, beads=40, material="steel-52100", velocity=1e-3)
    np.testing.assert_array_equal(other.radii, STEEL.radii)
    assert STEEL.radii[[0, -1]] == pytest.approx([10e-3, 2.5e-3], rel=1e-14)
    by_diameter = hc.Chain.from_materials(diameters=["1 cm", "8 mm"], materials="ptfe")
    assert by_diameter.radii.tolist() == [5e-3, 4e-3]
    by_length = hc.Chain.tapered(first="5 mm", length="30 cm", beads=40, material="ptfe")
    assert 2.0 * by_length.radii.sum() == pytest.approx(0.3, rel=1e-12)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({}, "needs a taper and its rate"),
        ({"taper": "linear"}, "a taper named 'linear' needs sizes"),
        ({"ratio": 2.0, "length": 9.0}, "exactly one of last .* got 2"),
        ({"rate": 0.1, "ratio": 2.0}, "a rate or sizes"),
        ({"taper": "forward-linear", "ratio": 2.0}, "choose from linear, exponential"),
        ({"ratio": 1e-3}, "less than a factor of 2; use more beads"),
        ({"ratio": 0.4**3}, "shrink by a factor of 2.5 from bead to bead"),
        ({"ratio": -1.0}, "ratio of the last to the first radius must be above 0"),
        ({"first": "1 mm", "last": 2.0}, "sizes with a unit .* give materials"),
        ({"first": 1.0, "first_diameter": 2.0, "last": 2.0}, "or its diameter, not both"),
        ({"ratio": 2.0, "material": "ptfe"}, "needs the size of its first bead"),
        ({"ratio": 2.0, "velocity": 2.0}, "velocity requires materials"),
        ({"length": 1.9}, "must be above 2, where the last bead vanishes, got 1.9"),
        ({"taper": "linear", "length": 4.0}, "change linearly .* above 4"),
    ],
)
def test_sizes_that_are_refused(arguments, said):
    with pytest.raises(hc.InputError, match=said):
        hc.Chain.tapered(beads=4, **arguments)


def test_radii_or_diameters_are_required():
    for given in ({}, {"materials": "ptfe"}):
        with pytest.raises(hc.InputError, match="needs materials and either radii or diameters"):
            hc.Chain.from_materials(**given)
    with pytest.raises(hc.InputError, match="has both radii and diameters: omit one"):
        hc.Chain.from_materials(radii=1e-3, diameters=2e-3, materials="ptfe")


def test_a_piece_has_the_beads_and_contacts_of_the_chain():
    gaps = np.linspace(0.0, 1e-6, 39)
    chain = STEEL.replace(gaps=gaps, left_wall=hc.Wall(), right_wall=hc.Wall.rigid())
    piece = chain[10:30]
    np.testing.assert_array_equal(piece.radii, chain.radii[10:30])
    np.testing.assert_array_equal(piece.masses, chain.masses[10:30])
    np.testing.assert_array_equal(piece.stiffness, chain.stiffness[10:29])
    np.testing.assert_array_equal(piece.gaps, gaps[10:29])
    assert (piece.left_wall, piece.right_wall) == (None, None)
    assert chain[10:].right_wall == hc.Wall.rigid()
    assert chain[:30].left_wall == hc.Wall()
    assert piece.velocities.tolist() == [1e-3] + 19 * [0.0]
    laws = [hc.Restitution(0.9)] * 20 + [None] * 19
    assert STEEL.replace(loss=laws)[30:].loss is None
    assert STEEL.replace(loss=laws)[:10].loss == hc.Restitution(0.9)


def test_a_scaled_piece_is_in_units_of_its_own_first_bead():
    chain = hc.Chain.tapered("backward-exponential", 0.05, beads=60)
    part = hc.propagate(chain[20:])
    other = hc.propagate(hc.Chain.tapered("backward-exponential", 0.05, beads=40))
    np.testing.assert_allclose(part.velocity, other.velocity, rtol=1e-9)
    with pytest.raises(
        hc.InputError, match="would change the units of the scaled chain .* gravity"
    ):
        _ = chain.replace(gravity=0.1)[20:]
    assert hc.Chain.uniform(9).replace(gravity=0.1)[4:].gravity == 0.1
    larger_first = hc.Chain.uniform(5).with_defects({1: 1.2}).replace(gravity=0.1)
    assert larger_first[1:].radii.tolist() == [1.0] * 4


def test_a_reversed_chain_hands_the_impact_on_from_the_other_end():
    twice = STEEL.reversed().reversed()
    for name in ("radii", "masses", "stiffness", "velocities"):
        np.testing.assert_array_equal(getattr(twice, name), getattr(STEEL, name))
    assert STEEL[::-1].radii.tolist() == STEEL.radii[::-1].tolist()
    # The mirror image of the reversed chain, struck at its last bead from the right.
    mirrored = np.zeros(40)
    mirrored[-1] = -1e-3
    one = hc.simulate(STEEL.reversed(), until=1e-3, times=2).velocities[-1]
    other = hc.simulate(STEEL.replace(velocities=mirrored), until=1e-3, times=2).velocities[-1]
    np.testing.assert_allclose(one, -other[::-1], atol=1e-13)


def test_joined_chains_are_the_chain_of_all_beads():
    whole = STEEL[:15] + STEEL[15:]
    for name in ("radii", "masses", "stiffness", "velocities", "gaps"):
        np.testing.assert_array_equal(getattr(whole, name), getattr(STEEL, name))
    parts = (
        STEEL[:15].replace(gaps=14 * [0.0]),
        STEEL[15:].replace(stiffness=STEEL[15:].stiffness, right_wall=hc.Wall()),
    )
    np.testing.assert_allclose((parts[0] + parts[1]).stiffness, STEEL.stiffness, rtol=1e-14)
    assert (parts[0] + parts[1]).right_wall == hc.Wall()
    lossy = STEEL[:15].replace(loss=hc.Restitution(0.9)) + STEEL[15:]
    assert [law is not None for law in lossy.loss] == 15 * [True] + 24 * [False]


@pytest.mark.parametrize(
    ("made", "said"),
    [
        (lambda: STEEL[3], "a bead is not a chain: use a slice"),
        (lambda: STEEL[3:3], r"\[3:3\] has 0 of 40 beads"),
        (lambda: STEEL[::2], "and a step of 2"),
        (lambda: STEEL["a":], r"whole numbers, such as chain\[10:20\], got \[a:\]"),
        (lambda: STEEL[::0], "step cannot be zero"),
        (lambda: AT_REST.struck_by(count=2)[1:], "begins with 2 strikers"),
        (lambda: AT_REST.struck_by(count=2).reversed(), "call reversed first"),
        (lambda: STEEL + hc.Chain.uniform(5), "only chains of the same kind"),
        (lambda: STEEL.replace(right_wall=hc.Wall()) + STEEL, "omit the right_wall of the first"),
        (lambda: STEEL + AT_REST.struck_by(), "omit the strikers of the second"),
        (lambda: STEEL + STEEL.replace(gravity=9.81), "gravity of joined chains must be equal"),
        (
            lambda: (
                STEEL.replace(exponent=2.0, stiffness=1e9)
                + STEEL.replace(exponent=1.8, stiffness=1e9)
            ),
            "the stiffness of the contact between the chains does not follow",
        ),
    ],
)
def test_pieces_that_are_refused(made, said):
    with pytest.raises(hc.InputError, match=said):
        made()


def test_a_chain_is_not_a_sequence_of_beads():
    with pytest.raises(TypeError):
        iter(STEEL)
    with pytest.raises(TypeError):
        STEEL + 3


@pytest.fixture
def run(monkeypatch, capsys):
    """``run(*arguments)``: exit code and printed text of a command."""

    def run(*arguments):
        monkeypatch.setattr("sys.argv", ["hertzchain", *arguments])
        with pytest.raises(SystemExit) as end:
            main()
        streams = capsys.readouterr()
        return end.value.code, streams.out + streams.err

    return run


def test_sizes_in_a_file_and_as_options(tmp_path, run):
    file = tmp_path / "sizes.toml"
    file.write_text(
        '[chain]\nfirst_diameter = "20 mm"\nlast_diameter = "5 mm"\nbeads = 40\n'
        'materials = "steel-52100"\nvelocity = "1 mm/s"\n'
    )
    np.testing.assert_array_equal(hc.load_chain(file).radii, STEEL.radii)
    options = ("--material", "steel-52100", "--diameter", "20 mm:5 mm", "--beads", "40")
    by_options = run("pulse", *options, "--speed", "1 mm/s", "--csv")
    assert by_options == run("pulse", str(file), "--csv")
    assert by_options[0] == 0
    scaled = run("pulse", "--radius", "4:1", "--taper", "linear", "--beads", "9")
    assert scaled[1].startswith("propagation: forward-linear, S = 0.09375, 9 beads")
    file.write_text('[chain]\ntaper = "linear"\nfirst = 4\nlength = 40.0\nbeads = 9\n')
    assert hc.load_chain(file).radii[-1] == pytest.approx((40.0 / 9 - 4) / 4)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--material", "brass"], "--material requires the size"),
        (["--diameter", "20:5:3"], "must look like"),
        (["--diameter", "20"], "the size of equal beads has no effect in scaled variables"),
        (["--speed", "1"], "--speed requires --material"),
        (["--material", "brass", "--diameter", "10"], "--diameter '10 mm'"),
        (["--material", "brass", "--radius", "10 mm:5"], "--radius 5 has no unit"),
        (["--material", "brass", "--radius", "5 mm", "--speed", "2"], "--speed '2 m/s'"),
        (
            ["--material", "brass", "--radius", "5 mm", "--wall", "wood"],
            "same, rigid, none, a material",
        ),
        (["--diameter", "2:1", "--radius", "2:1"], "not both"),
        (["--diameter", "2:1", "--rate", "0.1"], "omit --rate"),
        (["--taper", "linear"], "--taper linear requires two sizes"),
        (["--wall", "brass"], "--wall brass requires --material"),
    ],
)
def test_options_that_are_refused(arguments, said, run):
    code, text = run("pulse", *arguments)
    assert code == 2
    assert said in text
