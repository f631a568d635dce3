"""Labels of several results name the properties in which their chains differ."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from figure_texts import legend_texts

import hertzchain as hc
from hertzchain.plotting.differences import words_of_chains
from hertzchain.plotting.labels import distinguish


def row(material="steel-52100", **striker):
    balls = hc.Chain.from_materials("5 mm", material, beads=20)
    return balls.struck_by(**({"velocity": "0.1 m/s", "material": material} | striker))


BALLS, BEADS = row(), hc.Chain.uniform(20)
GAP = [0.0] * 7 + [1e-6] + [0.0] * 12
CELL = hc.Wall("5 kN/mm", exponent=1)
WALLS = {"left_wall": hc.Wall(), "right_wall": hc.Wall()}


def lossy(law):
    return BALLS.replace(loss=law)


@pytest.mark.parametrize(
    ("chains", "labels"),
    [
        ([lossy(hc.Restitution(e)) for e in (0.95, 0.9)], ["restitution 0.95", "restitution 0.9"]),
        ([lossy(hc.Restitution(e)) for e in (0.95, 0.9500001)],
         ["restitution 0.95", "restitution 0.9500001"]),
        ([BEADS.replace(loss=hc.Restitution(e)) for e in (0.95, 0.9)],
         ["restitution 0.95", "restitution 0.9"]),
        ([lossy(hc.Viscoelastic(f"{t} us")) for t in (0.3, 0.6)],
         ["viscoelastic 0.3 µs", "viscoelastic 0.6 µs"]),
        ([lossy(each) for each in (None, hc.ElasticPlastic(), hc.Dashpot("2 g/s"),
                                   hc.ElasticPlastic(yield_pressure="2 GPa"),
                                   hc.VelocityPower(0.1, alpha=1.8),
                                   hc.Restitution(0.9, attractive=False))],
         ["no loss", "elastic-plastic", "dashpot 0.002 kg/s",
          "elastic-plastic (yield pressure 2 GPa)", "velocity-power (gamma 0.1, alpha 1.8)",
          "restitution (0.9, without attraction)"]),
        ([BALLS, row(velocity="0.2 m/s")], ["impact at 0.1 m/s", "impact at 0.2 m/s"]),
        ([BEADS, BEADS.replace(velocities=[2.0] + [0.0] * 19)], ["impact at 1", "impact at 2"]),
        ([BALLS, BALLS.replace(right_wall=hc.Wall()),
          BALLS.replace(right_wall=hc.Wall.of("brass", gap="10 um"))],
         ["no right wall", "steel right wall", "brass right wall at a distance of 10 µm"]),
        ([BALLS.replace(right_wall=hc.Wall(loss=law)) for law in (None, hc.Restitution(0.9))],
         ["steel right wall", "steel right wall with restitution 0.9"]),
        ([BEADS, BEADS.replace(left_wall=hc.Wall())], ["no left wall", "left wall"]),
        ([row(diameter="5 mm"), row(diameter="8 mm")],
         ["steel striker of 5 mm", "steel striker of 8 mm"]),
        ([row(radius=np.inf, mass=m) for m in ("5 g", "5.00001 g")],
         ["steel striker of 5 g", "steel striker of 5.00001 g"]),
        ([lossy(hc.Restitution(0.9)), row("steel-316")],
         ["20 steel-52100 beads, restitution 0.9", "20 steel-316 beads, no loss"]),
        ([BALLS, BALLS.replace(gaps=GAP)], ["no gaps", "gap of 1 µm in contact 8"]),
        ([BEADS.replace(gaps=[each] * 19) for each in (0.01, 0.02)],
         ["gaps up to 0.01", "gaps up to 0.02"]),
        ([BEADS.replace(right_wall=hc.Wall(), gravity=each) for each in (0.0, 1e-4)],
         ["no gravity", "gravity 0.0001"]),
        ([BEADS.replace(precompression=each, **WALLS) for each in (0.01, 0.02)],
         ["precompression 0.01", "precompression 0.02"]),
        ([hc.Chain.from_radii([1.0, 0.9, 0.8, each] * 5) for each in (1.1, 1.2)],
         ["radius of bead 4: 1.1", "radius of bead 4: 1.2"]),
        ([BEADS, BEADS.replace(stiffness=[1.0] * 18 + [0.5])],
         ["stiffness of contact 19: 1", "stiffness of contact 19: 0.5"]),
        ([BEADS, hc.Chain.uniform(20, exponent=2.0)], ["p = 1.5", "p = 2"]),
        ([BALLS.with_scatter(relative="1%", seed=2), BALLS.with_scatter(relative="2%", seed=2)],
         ["1% scatter", "2% scatter"]),
        ([BALLS.replace(right_wall=CELL), BALLS.replace(right_wall=CELL).with_cap("5 g")],
         ["no cap", "cap 5 g"]),
        ([BEADS.replace(drive=hc.SineBurst(a, 0.1), velocities=[0.0] * 20) for a in (0.1, 0.2)],
         ["force drive by a sine burst (amplitude 0.1 and frequency 0.1 and cycles 5)",
          "force drive by a sine burst (amplitude 0.2 and frequency 0.1 and cycles 5)"]),
    ],
)  # fmt: skip
def test_labels_name_the_property_that_differs(chains, labels):
    found, title = distinguish([["simulation", *words] for words in words_of_chains(chains)])
    assert found == labels
    # The title has the rest.
    assert title.startswith("simulation, ")
    assert "loss" not in title


def test_a_common_precompression_is_in_the_title():
    held = {"precompression": "20 N", "held_by": "force"}
    chains = [
        hc.Chain.from_materials(size, "steel-52100", beads=9, **held) for size in (5e-3, 6e-3)
    ]
    for given in (chains[:1], chains):
        _, title = distinguish([["simulation", *words] for words in words_of_chains(given)])
        assert title.count("under 20 N") == 1
        assert "precompression" not in title


def test_beads_whose_words_do_not_differ_are_named_by_one_of_them():
    chains = [BALLS.with_scatter(relative="1%", seed=seed) for seed in (1, 2)]
    words = words_of_chains(chains)
    sizes = [float(each[-1].removesuffix(" mm").rpartition(" ")[2]) for each in words]
    place = int(words[0][-1].removeprefix("radius of bead ").partition(":")[0])
    for chain, size in zip(chains, sizes, strict=True):
        assert size == pytest.approx(1e3 * chain.radii[place - 1], rel=1e-5)
    # Losses of single contacts.
    laws = [[hc.Restitution(0.9)] * 18 + [hc.Restitution(e)] for e in (0.8, 0.7)]
    words = words_of_chains([BEADS.replace(loss=each) for each in laws])
    assert [each[-1] for each in words] == [
        "restitution 0.9 except restitution 0.8 in contact 19",
        "restitution 0.9 except restitution 0.7 in contact 19",
    ]
    # Of more contacts.
    laws = [[hc.Restitution(0.9)] * 17 + [hc.Restitution(e)] * 2 for e in (0.8, 0.7)]
    words = words_of_chains([BEADS.replace(loss=each) for each in laws])
    assert [each[-1] for each in words] == [
        "loss of contact 18: restitution 0.8", "loss of contact 18: restitution 0.7"
    ]  # fmt: skip


def test_a_single_loss_of_a_pad_is_named_in_figures():
    row = BALLS.with_contacts({4: hc.Pad(1e6)}).replace(right_wall=hc.Wall())
    lossy = row.replace(loss=[None] * 3 + [hc.Dashpot(2.0)] + [None] * (row.beads - 5))
    runs = [hc.simulate(lossy, times=0, rtol=rtol) for rtol in (1e-6, 1e-9)]
    title = runs[0].pulse().compare(runs[1].pulse()).plot().get_title()
    assert "dashpot 2 kg/s in contact 4" in title.replace("\n", " ")
    assert "mixed losses" not in title


def test_pulses_forces_and_comparisons_name_the_same_differences():
    chains = [lossy(hc.Viscoelastic(f"{t} us")) for t in (0.3, 0.6)]
    names = ["viscoelastic 0.3 µs", "viscoelastic 0.6 µs"]
    runs = [hc.simulate(chain, until="0.6 ms", times=300) for chain in chains]
    pulses = [run.pulse() for run in runs]
    assert legend_texts(hc.plot_pulses(pulses))[:2] == names
    axes = plt.subplots()[1]
    for run in runs:
        run.plot_forces(["ball 5", "ball 9"], ax=axes)
    places = ("bead 6 (ball 5)", "bead 10 (ball 9)")
    assert legend_texts(axes) == [f"{place}, {name}" for name in names for place in places]
    # Names of a user remain.
    axes = plt.subplots()[1]
    for run, name in zip(runs, "ab", strict=True):
        run.plot_forces(["ball 5"], label=name, ax=axes)
    assert legend_texts(axes) == ["a", "b"]
    title = pulses[0].compare(pulses[1]).plot().get_title().replace("\n", " ")
    assert title == (
        "viscoelastic 0.3 µs against viscoelastic 0.6 µs, simulation, 20 steel balls and a "
        "striker, 10 mm"
    )


def test_equal_pulses_have_numbers():
    pulse = hc.bca(BEADS)
    assert legend_texts(hc.plot_pulses([pulse, pulse]))[:2] == ["BCA (1)", "BCA (2)"]


def test_a_law_named_after_people_has_capital_letters():
    chain = hc.Chain.uniform(9)
    laws = [chain.replace(loss=hc.WaltonBraun(ratio)) for ratio in (0.9, 0.8)]
    assert [words[-1] for words in words_of_chains(laws)] == [
        "Walton\N{EN DASH}Braun 0.9", "Walton\N{EN DASH}Braun 0.8",
    ]  # fmt: skip


def test_common_places_and_walls_are_in_the_title():
    shapes = ("linear", "exponential")
    tapers = [
        hc.Chain.tapered(
            shape, first_diameter="12 mm", last_diameter="8 mm", beads=8, material="steel-52100",
            velocity="0.1 m/s",
        ).replace(right_wall=hc.Wall())
        for shape in shapes
    ]  # fmt: skip
    runs = [hc.simulate(chain, until="0.5 ms", times=200) for chain in tapers]
    names, common = [f"{shape} taper" for shape in shapes], "8 steel balls, 12 mm to 8 mm"
    axes = runs[1].plot_forces(["wall"], ax=runs[0].plot_forces(["wall"]))
    assert legend_texts(axes) == names
    assert axes.get_title() == f"force on the right wall, {common}"
    axes = runs[1].plot_forces([3, "wall"], ax=runs[0].plot_forces([3, "wall"]))
    places = ("bead 3", "right wall")
    assert legend_texts(axes) == [f"{place}, {name}" for name in names for place in places]
    assert axes.get_title() == f"{common}, right wall"
    axes = hc.plot_pulses([run.pulse() for run in runs], residuals=True)
    assert legend_texts(axes)[:2] == names
    assert axes.get_title() == f"simulation, {common}, right wall"
    assert axes.figure.axes[1].get_ylabel() == "difference from\nlinear taper [%]"


def test_a_loss_of_few_contacts_is_named():
    law = hc.Restitution(0.9)
    one, two = ([law if k in places else None for k in range(1, 20)] for places in ((6,), (6, 9)))
    words = words_of_chains([BEADS, *(BEADS.replace(loss=each) for each in (one, two))])
    assert distinguish([["", *each] for each in words])[0] == [
        "no loss", "restitution 0.9 in contact 6", "restitution 0.9 in 2 contacts"
    ]  # fmt: skip
