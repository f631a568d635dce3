"""HTML for notebooks: well-formed, small, escaped, and true to the numbers."""

import itertools
import re
import subprocess
import sys
import warnings
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.notebook.drawing import COLUMNS, Curve, chart, engineering, thinned, ticks

MAX_BYTES = 40_000
UNITS = ("scaled", "SI")


def balls(beads, units, velocity=0.1):
    if units == "SI":
        return hc.Chain.from_materials(5e-3, "steel-52100", beads=beads, velocity=velocity)
    return hc.Chain.uniform(beads)


def parsed(item):
    """Elements of the HTML of an object, after common checks."""
    html = item._repr_html_()
    assert len(html.encode()) <= MAX_BYTES
    assert not re.search(r"\b(nan|inf)\b", html)
    # The colours of text and axes are those of the page.
    assert not re.search(r"(?:^|[;\"])color:(?!inherit)", html)
    root = ElementTree.fromstring(html)
    # Signs are those of figures, not of printed text.
    for text in root.itertext():
        assert not re.search(r"\+-|(?:\d |[\d/\[(])u(?:[JNgmsV]|Pa)\b|(?:^|[\s(\[])-[\d.]", text), (
            text
        )
    return root, " ".join(" ".join(root.itertext()).split())


@pytest.fixture(scope="module", params=[(n, u) for u in UNITS for n in (3, 300)], ids=str)
def results(request):
    beads, units = request.param
    chain = balls(beads, units).replace(right_wall=hc.Wall())
    unit = hc.Scales.of(chain).time if units == "SI" else 1.0
    run = hc.simulate(chain, until=(2.2 * beads + 20) * unit, times=7 * beads + 100)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hc.IncompleteWarning)
        return beads, units, run, run.wall_force()


def test_every_kind_is_small_and_has_its_numbers(results):
    beads, units, run, wall = results
    si = units == "SI"
    kind = "steel-52100 beads, diameter 10 mm" if si else "beads"
    free = balls(beads, units)
    pulse = hc.bca(free)
    for item, words in (
        (
            run.chain,
            [f"{beads} {kind}, right wall", f"bead 1 at velocity {'100 mm/s' if si else 1}"],
        ),
        (pulse, ["by BCA", "last bead", "largest force", " N (contact" if si else "(contact"]),
        (run.pulse(), ["by simulation", "arrival"]),
        (run, ["time reached", f"{beads} of {beads}", "energy drift", "velocity [m" * si]),
        (run.budget(), ["scattered back", "right wall", "add up within", "[N s]" * si]),
        (wall, [engineering(wall.largest_so_far, "N", units), "impulse of the run"]),
        (pulse.compare(hc.propagate(free)), ["of BCA with propagation", "rms error", "velocity"]),
    ):
        root, text = parsed(item)
        assert text.startswith(type(item).__name__)
        assert root.find(".//svg") is not None
        assert root.find(".//table") is not None or root.find(".//dl") is not None
        for word in words:
            assert word in text, (word, text)


@pytest.mark.parametrize("units", UNITS)
@pytest.mark.parametrize("beads", [3, 400])
def test_sensors_spectra_and_limits_have_their_numbers(beads, units):
    chain = balls(beads, units)
    run = hc.simulate(chain, times=7 * beads + 100)
    sensor = run.sensor_force(2)
    held = chain.replace(precompression=1.0, held_by="force", loss=hc.Viscoelastic(1e-6))
    spectrum = hc.spectrum(held)
    highest = engineering(spectrum.frequencies[-1], "Hz", units)
    for item, words in (
        (sensor, ["bead 2", engineering(sensor.first_maximum, "N", units), "largest so far"]),
        (spectrum, [highest, f"{beads}", "slowest decay", "Bands of an infinite chain"]),
    ):
        root, text = parsed(item)
        assert text.startswith(type(item).__name__)
        assert root.find(".//svg") is not None
        for word in words:
            assert word in text, (word, text)


def test_what_a_spectrum_or_sensor_does_not_have_is_left_out():
    taper = hc.Chain.tapered("forward-linear", 0.05, beads=9)
    held = taper.replace(precompression=1.0, held_by="force")
    text = parsed(hc.spectrum(held))[1]
    assert "Bands" not in text
    assert "decay" not in text
    with pytest.warns(hc.IncompleteWarning):
        early = hc.simulate(hc.Chain.uniform(20), until=5.0).sensor_force(15)
    assert "The pulse has not arrived." in parsed(early)[1]


def test_forces_above_a_static_force_fill_the_axis():
    wall = hc.Wall()
    row = hc.Chain.from_materials(
        diameters="10 mm", materials="steel-52100", beads=6, precompression="20 N",
        left_wall=wall, right_wall=wall, velocity="1 mm/s",
    )  # fmt: skip
    run = hc.simulate(row, until="0.2 ms", times=201, check=False)
    sensor = run.sensor_force(3)
    with pytest.warns(hc.IncompleteWarning):
        force = run.wall_force()
    above = engineering(sensor.first_maximum - sensor.static_force, "N", "SI")
    for item, words in (
        (sensor, f"static force, included 20 N first maximum above it {above}"),
        (force, "static force, included 20 N"),
    ):
        root, text = parsed(item)
        assert words in text
        ends = [each.text for each in root.iter() if each.get("text-anchor") == "end"]
        assert float(ends[0]) > 15.0


@pytest.mark.parametrize(
    ("law", "words"),
    [
        (hc.Viscoelastic("0.5 us"), ["time", "500 ns", "relaxation time of the material"]),
        (hc.Viscoelastic(0.1), ["0.1 s (scaled: in its unit of time)"]),
        (hc.Dashpot("3 N s/m"), ["gamma", "3 kg/s", "damping constant"]),
        (hc.ElasticPlastic("2 GPa"), ["elastic-plastic", "yield_pressure", "2 GPa"]),
        (hc.Elastic(), ["No loss"]),
    ],
)
def test_laws_of_loss_have_a_table_of_parameters(law, words):
    text = parsed(law)[1].replace("\N{NO-BREAK SPACE}", " ")
    assert text.startswith(type(law).__name__)
    assert all(word in text for word in words)
    assert "None" not in text


@pytest.mark.parametrize("units", UNITS)
def test_waves_fronts_and_states_have_their_numbers(units):
    chain = balls(40, units, None).struck_by(count=2, velocity=0.2).replace(right_wall=hc.Wall())
    unit = hc.Scales.of(chain).time if units == "SI" else 1 / 0.2**0.2
    run = hc.simulate(chain, until=80.0 * unit, times=2000)
    waves, flux, leading = run.waves(), run.energy_flux(), run.leading_pulse()
    fronts = hc.simulate(balls(40, units).replace(drive=hc.StepDrive(0.5)), until=60.0 * unit,
                         times=900).fronts()  # fmt: skip
    fastest = int(np.argmax(np.abs(run.state.velocities)))
    last = np.flatnonzero(np.isfinite(leading.momentum))[-1]
    strongest = max(waves, key=lambda wave: wave.energy)
    for item, words in (
        # The unit is in the head of the column.
        (waves, ["to the left", engineering(strongest.energy, "J", units).partition(" ")[0],
                 f"{strongest.contacts.min()} to {strongest.contacts.max()}"]),
        (flux, ["contact", "to the right"]),
        (leading, [f"crest at contact {last + 1}",
                   engineering(leading.kinetic_energy[last], "J", units)]),
        (fronts, [f"{np.isfinite(fronts.times).sum()} of 39",
                  engineering(np.nanmax(fronts.times), "s", units)]),
        (run.state, [engineering(run.state.time, "s", units), f"{fastest + 1}",
                     "the last whole step before the end of the run"]),
    ):  # fmt: skip
        root, text = parsed(item)
        assert text.startswith(type(item).__name__)
        assert root.find(".//svg") is not None
        for word in words:
            assert word in text, (word, text)
    # One row for each wave, one track of a colour for each direction.
    root, _ = parsed(waves)
    assert len(root.findall(".//table/tr")) == min(len(waves), 12) + 1
    assert "no waves" in parsed(waves.passing(20).left.right)[1]
    text = parsed(flux.balance(20, 40))[1]
    for words in ("contacts 20 and 40", "relative", engineering(flux.right[19], "J", units)):
        assert words in text


@pytest.mark.parametrize("units", UNITS)
def test_single_waves_reflections_peaks_and_horizons_have_their_numbers(units):
    chain = balls(40, units).replace(right_wall=hc.Wall())
    unit = hc.Scales.of(chain).time if units == "SI" else 1.0
    run = hc.simulate(chain, until=80.0 * unit, times=2000)
    wave, found = run.waves().left[0], run.reflection(20, 40)
    peaks, horizon = run.velocity_peaks(10), run.horizon()
    for item, words in (
        (wave, ["to the left", engineering(wave.energy, "J", units),
                f"{wave.contacts.min()} to {wave.contacts.max()}"]),
        (found, ["between contacts 20 and 40", f"{found.reflected_energy:.4f}",
                 engineering(found.incident.energy, "J", units)]),
        (peaks, ["of bead 10", engineering(peaks.times[0], "s", units)]),
        (horizon, ["predictable within 1% at all saved times"]),
    ):  # fmt: skip
        root, text = parsed(item)
        assert text.startswith(type(item).__name__)
        assert root.find(".//svg") is not None or root.find(".//table") is not None
        for word in words:
            assert word in text, (word, text)
    rows = found.to_dataframe()
    assert rows["part"].tolist() == ["incident", "reflected"]
    np.testing.assert_allclose(rows["energy"][1] / rows["energy"][0], found.reflected_energy)
    slow = replace(found, momentum_on_its_way=(0.03, 0.0))
    assert f"{found.reflected_momentum:.4f} (up to 0.0300 more)" in parsed(slow)[1]
    coarse = replace(wave, events=tuple(replace(each, samples=3.0) for each in wave.events))
    assert "not resolved, with 3 saved times" in parsed(coarse)[1]


def test_samples_of_a_fit_are_listed():
    samples = np.array([[1e-6], [3e-6]])
    text = parsed(hc.Posterior(("lag",), samples, 0.5, np.nan, 20, np.zeros(1), ("s",)))[1]
    assert "Posterior 2 samples" in text
    assert "lag 2.0 ± 1.0 µs" in text
    assert "20 steps are too few" in text


def test_gradients_show_where_a_quantity_depends_on_the_chain():
    chain = balls(12, "SI").replace(right_wall=hc.Wall())
    for found in (
        hc.gradient(chain, "wall_force.peak", to=["radii", "gaps", "right_wall.gap"]),
        hc.gradient(hc.Chain.uniform(12), "pulse.velocity@8", to=["radii"]),
    ):
        root, text = parsed(found)
        assert text.startswith(f"Gradient {found.quantity}")
        radii = found["radii"]
        k = int(np.argmax(np.abs(radii)))
        unit = f" {found.units['radii']}" if found.unit else ""
        assert f"radii {radii[k]:.4g}{unit} {k + 1}" in text
        # Gaps of 0 have no relative derivatives.
        curves = [each for each in root.findall(".//path") if each.get("stroke-width") == "1.6"]
        assert len(curves) == 1
    with pytest.warns(hc.IncompleteWarning):
        short = hc.gradient(chain, "wall_force.peak", to=["radii"], until=1e-5)
    text = parsed(short)[1]
    assert "value none" in text
    assert "The force on the wall has no maximum before the end of the run" in text


def test_materials_and_scales_are_tables():
    steel = hc.material("steel-52100")
    text = parsed(steel)[1]
    assert f"{steel.density:g} kg/m^3" in text
    assert engineering(steel.young, "Pa") in text
    assert steel.source in text
    assert "speed of sound" not in parsed(hc.Wall.rigid().material)[1]
    scales = hc.Scales.of(balls(5, "SI"))
    text = parsed(scales)[1]
    for word in ("radius 5 mm", "velocity 100 mm/s", f"force {engineering(scales.force, 'N')}"):
        assert word in text


def test_a_line_of_modes_does_not_cross_the_gap():
    held = {"precompression": "0.02 N", "held_by": "force"}
    dimer = hc.Chain.periodic([9e-3, 4e-3], cells=9, materials=["steel-316", "ptfe"])
    pieces = []
    for chain in (dimer.replace(**held), balls(18, "SI").replace(**held)):
        root, _ = parsed(hc.spectrum(chain))
        (curve,) = [each for each in root.findall(".//path") if each.get("stroke-width") == "1.6"]
        pieces.append(curve.get("d").count("M"))
        assert len(root.findall(".//circle")) == 18
    assert pieces[0] > pieces[1] == 1


def test_materials_have_a_legend_only_where_each_bead_is_drawn():
    for cells, drawn in ((5, True), (150, False)):
        dimer = hc.Chain.periodic([9e-3, 4e-3], cells=cells, materials=["steel-316", "ptfe"])
        root, _ = parsed(dimer)
        words = [each.text for each in root.iter("span")] + [
            each.tail for each in root.iter("span")
        ]
        assert ("ptfe" in words) == bool(root.findall(".//circle")) == drawn


def test_limits_of_hertz_are_a_table():
    fast = hc.Chain.from_materials(5e-3, "steel-52100", beads=4, velocity=0.45)
    found = hc.hertz_range(fast)
    text = parsed(found)[1]
    assert f"{found.yield_ratio.max():.3g} contact 1 1 exceeded" in text
    assert found.violations[0][1:] in text
    slow = hc.hertz_range(fast.replace(velocities=[0.01, 0.0, 0.0, 0.0]))
    assert "exceeded" not in parsed(slow)[1]


def test_peaks_that_are_not_complete_say_so():
    chain = hc.Chain.uniform(20).replace(right_wall=hc.Wall())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hc.IncompleteWarning)
        early = hc.simulate(chain, until=24.0).wall_force()
        none = hc.simulate(chain, until=5.0)
        before = none.wall_force()
    root, text = parsed(early)
    assert "not complete" in text
    assert "so far" in text
    assert root.find(".//circle").get("fill") == "none"
    assert "The pulse has not arrived." in parsed(before)[1]
    assert "right wall, largest force so far none yet" in parsed(none)[1]
    complete = hc.simulate(chain).wall_force()
    root, text = parsed(complete)
    assert f"peak {complete.peak:.4g}" in text
    assert root.find(".//circle").get("fill") != "none"


def test_a_chain_has_a_circle_for_each_bead_to_scale():
    radii = np.array([1.0, 0.5, 0.25, 2.0])
    root, _ = parsed(hc.Chain.from_radii(radii).replace(left_wall=hc.Wall(stiffness=1.0)))
    circles = root.findall(".//circle")
    drawn = np.array([float(each.get("r")) for each in circles]) + 0.4
    np.testing.assert_allclose(drawn / drawn[0], radii, rtol=0.01)
    centres = np.array([float(each.get("cx")) for each in circles])
    # Neighbours touch.
    np.testing.assert_allclose(np.diff(centres), drawn[1:] + drawn[:-1], atol=0.15)
    assert len(root.findall(".//rect")) == 1


def test_strikers_and_materials_are_distinguished():
    chain = hc.Chain.periodic([9e-3, 4e-3], cells=5, materials=["brass", "ptfe"])
    root, text = parsed(chain.struck_by(velocity=0.3, count=2))
    assert [each.get("fill") for each in root.findall(".//circle")][:2] == ["none", "none"]
    assert "brass" in text
    assert "2 beads at velocity 300 mm/s" in text


def test_names_are_escaped():
    name = "<script>alert('&')</script>"
    bad = hc.Material(name, 8000.0, 2e11, 0.3)
    chain = hc.Chain.from_materials([5e-3, 4e-3, 5e-3], [bad, "brass", bad], velocity=0.01)
    pulse = hc.Pulse(hc.Chain.uniform(3), name, np.ones(3))
    for item in (chain, hc.bca(chain), hc.simulate(chain), pulse, pulse.compare(pulse)):
        html = item._repr_html_()
        assert "<script" not in html
        ElementTree.fromstring(html)
        assert name in "".join(ElementTree.fromstring(html).itertext())


def test_runs_without_saved_times_have_numbers_only():
    run = hc.simulate(hc.Chain.uniform(5), times=0)
    root, text = parsed(run)
    assert root.find(".//svg") is None
    assert "No times were saved" in text


def test_values_that_are_missing_leave_gaps():
    run = hc.simulate(hc.Chain.uniform(30), until=12.0)
    pulse = run.pulse()
    assert np.isnan(pulse.velocity).any()
    html = pulse._repr_html_().replace(">nan<", "><")
    assert "no first maximum of the velocity" in html
    assert not re.search(r"[ML ]nan", html)


def test_curves_keep_their_extremes_when_thinned():
    x = np.arange(100_000.0)
    y = np.zeros(100_000)
    y[[777, 50_001]] = 5.0, -3.0
    few, values = thinned(x, y)
    assert len(few) <= 3 * COLUMNS
    assert (values.max(), values.min()) == (5.0, -3.0)
    assert few[np.argmax(values)] == 777.0
    assert (np.diff(few) > 0.0).all()


def test_axes_show_the_values():
    root = ElementTree.fromstring(
        chart([Curve(np.array([5.0, 10.0]), np.array([0.0, 100.0]))], "x", "y")
    )
    labels = {each.text: each for each in root.iter("text")}
    dots = [(float(each.get("cx")), float(each.get("cy"))) for each in root.iter("circle")]
    assert float(labels["0"].get("y")) - 4 == pytest.approx(dots[0][1], abs=0.1)
    assert float(labels["100"].get("y")) - 4 == pytest.approx(dots[1][1], abs=0.1)
    assert float(labels["10"].get("x")) == pytest.approx(dots[1][0], abs=0.1)


@pytest.mark.parametrize(
    ("low", "high", "whole", "expected"),
    [
        (0.0, 1.0, False, [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]),
        (1.0, 3.0, True, [1.0, 2.0, 3.0]),
        (1.0, 14.0, True, [5.0, 10.0]),
        (-2.1, 7.0, False, [-2.0, 0.0, 2.0, 4.0, 6.0]),
    ],
)
def test_ticks_are_round_numbers_inside(low, high, whole, expected):
    assert ticks(low, high, whole=whole) == pytest.approx(expected)


@pytest.mark.parametrize("height", [130, 190])
@pytest.mark.parametrize("log", [False, True])
def test_axes_have_four_numbers_or_more_that_do_not_overlap(height, log):
    """At all peaks within a decade; a line of text is 11 pixels high, a digit 7 wide."""
    for peak in np.geomspace(100.0, 1000.0, 60):
        x, y = np.array([0.0, 1.3 * peak]), np.array([20.0, peak])
        root = ElementTree.fromstring(chart([Curve(x, y)], "x", "y", log=log, height=height))
        shown = [each for each in root.iter("text") if re.match(r"[\d.]+$", each.text)]
        rows = sorted(float(each.get("y")) for each in shown if each.get("text-anchor") == "end")
        columns = sorted((float(each.get("x")), len(each.text)) for each in shown
                         if each.get("text-anchor") == "middle")  # fmt: skip
        assert len(rows) >= 4
        assert len(columns) >= 4
        assert min(np.diff(rows)) > 11.0
        assert all(b - a > 3.5 * (n + m) for (a, n), (b, m) in itertools.pairwise(columns))


@pytest.mark.parametrize(
    ("size", "label"), [(2e5, "1e5"), (3e-7, "2e\N{MINUS SIGN}7"), (2e12, "1e12")]
)
def test_powers_of_ten_have_no_zeros(size, label):
    root = ElementTree.fromstring(chart([Curve(np.arange(2.0), np.array([0.0, size]))], "x", "y"))
    assert label in [each.text for each in root.iter("text")]


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (2.349e-5, "s", "23.49 µs"), (0.0, "N", "0 N"), (1300.5, "N", "1.3 kN"),
        (1e-3, "m", "1 mm"), (0.0311, "N s", "31.1 mN s"), (0.5, "N s", "500 mN s"),
        (-0.25, "m/s", "-250 mm/s"), (1e-20, "J", "1e-08 pJ"),
    ],
)  # fmt: skip
def test_numbers_have_a_prefix(value, unit, text):
    assert engineering(value, unit) == text
    assert engineering(value, unit, "scaled") == f"{value:.4g}"


def test_no_plotting_library_is_loaded():
    code = (
        "import sys, hertzchain as hc; chain = hc.Chain.uniform(9); pulse = hc.bca(chain);"
        "[item._repr_html_() for item in (chain, pulse, pulse.compare(pulse))];"
        "print([name for name in ('matplotlib', 'pandas', 'xarray') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_walls_have_numbers():
    assert "material steel-304" in parsed(hc.Wall.of("steel-304", gap="10 um"))[1]
    assert "gap 10 µm" in parsed(hc.Wall.of("steel-304", gap="10 um"))[1]
    assert "stiffness 2 kN/mm" in parsed(hc.Wall("2 kN/mm", exponent=1))[1]
    text = parsed(hc.Wall(loss=hc.Restitution(0.9)))[1]
    assert "material that of the bead" in text
    assert "coefficient=0.9" in text


def test_designs_have_a_value_a_search_and_a_list_of_parts():
    chain = balls(6, "SI").replace(right_wall=hc.Wall())
    problem = hc.Design(
        chain, minimise="wall_force.peak", subject_to={"length": "<= 1 m"},
        vary=[hc.vary.balls("bearing-balls", materials=["steel-52100"], diameters=["5 mm", "6 mm"],
                            beads="5:")],
    )  # fmt: skip
    result = hc.design(problem, method="enumerate")
    root, text = parsed(result)
    assert f"value {result.value:.4g} N" in text
    assert "best of all 4 simulated choices" in text
    assert "length <= 1 m" in text
    cells = [cell.text for cell in root.findall(".//td")]
    for count, ball in result.parts:
        assert cells[cells.index(ball) - 1] == str(count)


def test_a_distribution_names_percentiles_that_it_does_not_determine():
    for samples, few in ((10, True), (20, False)):
        found = hc.distribution(
            hc.Chain.uniform(5), "velocity@last", hc.Scatter(0.01, samples=samples)
        )
        said = "10 chains do not determine the percentiles 5% and 95%; at least 20 do."
        assert (said in found._repr_html_()) == few


def test_one_chain_exceeds_the_limits():
    found = hc.distribution(hc.Chain.uniform(5), "velocity@last", hc.Scatter(0.01, samples=20))
    for count, said in ((1, "1 chain exceeds the limits"), (2, "2 chains exceed the limits")):
        assert said in parsed(replace(found, outside_range=count))[1]


@pytest.mark.parametrize("units", UNITS)
def test_a_distribution_has_its_numbers(units):
    chain = balls(10, units).replace(right_wall=hc.Wall())
    found = hc.distribution(chain, "wall_force.peak", hc.Scatter(radius=0.02, samples=40))
    _, shown = parsed(found)
    unit = "N" if units == "SI" else ""
    for value in (found.nominal, found.mean, found.standard_deviation, found.percentile(95)):
        assert engineering(value, unit, units) in shown
    assert "peak force on the wall" in shown
    assert "number of chains" in shown


@pytest.mark.parametrize("units", UNITS)
def test_an_effective_chain_has_its_numbers(units):
    found = hc.effective_chain(balls(21, units).decorated(0.3))
    _, shown = parsed(found)
    assert "21 of 41" in shown
    for value in (found.masses.min(), found.masses.max()):
        text = f"{1e3 * value:.4g} g" if units == "SI" else f"{value:.4g}"
        assert text in shown
    assert "mkg" not in found._repr_html_()
    assert f"{found.stiffness[5]:.4g}" in shown


def test_the_view_of_a_run_of_a_decorated_chain_has_its_large_beads():
    html = hc.simulate(hc.Chain.uniform(20).decorated(0.4))._repr_html_()
    assert re.findall(r"</span>bead (\d+)<", html) == ["1", "11", "21", "29", "39"]


def test_the_view_of_a_disordered_chain_has_the_spread():
    chain = hc.Chain.uniform(20)
    pulse = hc.disorder(chain, scatter=0.02)
    shown = f" +- {100.0 * pulse.velocity_spread[-1]:.2f}%"
    assert shown in repr(pulse)
    assert shown in str(pulse)
    html = pulse._repr_html_()
    assert shown.replace("+-", "±") in html
    for words in ("spread [%]", "one standard deviation"):
        assert words in html
        assert words not in hc.propagate(chain)._repr_html_()


def test_last_bead_at_a_free_end_is_apart():
    taper = hc.Chain.tapered("forward-exponential", 0.02, beads=20)
    html = hc.propagate(taper)._repr_html_()
    assert "last bead (free end)" in html
    assert html.count('r="4"') == 1
    closed = hc.simulate(taper.replace(right_wall=hc.Wall()), times=0).pulse()._repr_html_()
    assert "free end" not in closed
    assert 'r="4"' not in closed


def test_no_line_joins_free_ends_in_comparisons_and_tables():
    chain = hc.Chain.tapered("forward-exponential", 0.03, beads=30)
    compared = hc.bca(chain).compare(hc.propagate(chain))
    table = hc.propagate_many([chain.with_scatter(seed, relative=0.02) for seed in range(20)])
    for item in (compared, table):
        root, _ = parsed(item)
        paths = [path.get("d") for path in root.iter("path") if path.get("stroke-width") == "1.6"]
        circles = [circle for circle in root.iter("circle") if circle.get("r") == "4"]
        (right,) = {float(circle.get("cx")) for circle in circles}
        height = float(circles[0].get("cy"))
        points = [tuple(map(float, re.findall(r"[\d.]+", point)))
                  for path in paths for point in path.split("L")]  # fmt: skip
        assert (right, height) not in {(x, y) for x, *rest in points for y in rest}


def test_names_of_curves_are_those_of_figures():
    traces, chain = hc.example_experiment()
    compared = hc.simulate(hc.load_chain(chain), until=6e-4, times=1201).compare(traces)
    root, text = parsed(compared)
    assert "data simulation" in text
    assert "model" not in text
    # The data are a broad, pale line behind the simulation.
    drawn = [path for path in root.iter("path") if path.get("stroke-linejoin") == "round"]
    widths = [float(path.get("stroke-width")) for path in drawn]
    assert widths == [4.0, 1.6] * (len(drawn) // 2)
    assert all(path.get("stroke-opacity") == "0.5" for path in drawn[::2])


def test_pages_of_walls_have_the_unit_of_a_given_stiffness():
    assert "5 kN/mm" in hc.Wall("5000 N/mm", exponent=1)._repr_html_()
    assert "5e+06" in hc.Wall(5e6)._repr_html_()


def test_scatter_has_a_view():
    _, text = parsed(hc.Scatter(radius=0.01, gaps="5 um", beads="2:", measure="cvar90"))
    assert "Scatter 1% scatter, random gaps (5 µm)" in text
    assert "beads 2: samples 40 measure CVaR90" in text
