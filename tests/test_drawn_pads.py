"""Pads and load cells in figures and in the app: layers at contacts that are linear springs."""

import pytest
from app_client import computed
from matplotlib.patches import Rectangle

import hertzchain as hc
from hertzchain.chain.drawn_bodies import contact_places, pad_contacts
from hertzchain.plotting.chains import PAD, PAD_COLOUR

ROW = hc.Chain.from_materials(10e-3, "steel-52100", beads=4, velocity=0.2)
PAD_ON_WALL = ROW.replace(right_wall=hc.Wall("1 kN/mm", exponent=1))


def layers(axes):
    """Left edges and widths of the layers."""
    found = [each for each in axes.patches if isinstance(each, Rectangle)]
    return [(each.get_x(), each.get_width()) for each in found]


@pytest.mark.parametrize(
    ("chain", "contacts", "left"),
    [
        (ROW.replace(right_wall=hc.Wall()), [], []),
        (PAD_ON_WALL, [4], [80.0]),
        (ROW.replace(right_wall=hc.Wall("1 kN/mm", exponent=1, gap="2 mm")), [4],
         [82.0]),
        (ROW.replace(left_wall=hc.Wall("1 kN/mm", exponent=1)), [0], [-10.0 * PAD]),
        (ROW.with_contacts({2: hc.Pad("1 kN/mm")}), [2], [40.0 - 5.0 * PAD]),
        (ROW.with_cap(mass="5 g", stiffness="1 kN/mm", exponent=1), [4], [80.0 - 5.0 * PAD]),
    ],
)  # fmt: skip
def test_pads_are_drawn_where_they_are(chain, contacts, left):
    assert pad_contacts(chain) == contacts
    axes = hc.plot_chain(chain)
    assert [x for x, _ in layers(axes)] == pytest.approx(left)
    assert all(width == pytest.approx(10.0 * PAD) for _, width in layers(axes))
    # The hatching of a wall covers no part of its layer.
    walls = [each for each in axes.collections if each.get_hatch()]
    for x, width in layers(axes):
        for wall in walls:
            begin, end = wall.get_paths()[0].get_extents().intervalx
            assert min(end, x + width) - max(begin, x) < 1e-9


def test_contacts_of_scaled_chains_are_between_touching_beads():
    chain = hc.Chain([1.0, 0.5, 1.0])
    assert contact_places(chain).tolist() == [0.0, 2.0, 3.0, 5.0]
    assert pad_contacts(chain) == []


def test_the_app_and_animations_show_the_pad(tmp_path):
    document = {"chain": {"radii": "10 mm", "beads": 4, "materials": "steel-52100",
                          "velocity": "0.2 m/s",
                          "right_wall": {"stiffness": "1 kN/mm", "exponent": 1}}}  # fmt: skip
    assert computed(document)["beads"][0]["pads"] == [4]
    run = hc.simulate(PAD_ON_WALL, until=2e-3, times=50)
    file = hc.animate(run, tmp_path / "a.gif", frames=2)
    from PIL import Image

    grey = tuple(bytes.fromhex(PAD_COLOUR[1:]))
    with Image.open(file) as picture:
        colours = picture.convert("RGB").getcolors(1 << 20)
    near = [
        n for n, each in colours if max(abs(a - b) for a, b in zip(each, grey, strict=True)) < 24
    ]
    assert sum(near) > 200
