import base64
import dataclasses
import itertools
import pickle
import re
import warnings
from importlib import resources

import matplotlib.pyplot as plt
import numpy as np
import pytest
from figure_texts import legend_texts
from matplotlib.animation import FFMpegWriter
from matplotlib.colors import to_hex, to_rgb
from PIL import Image, ImageColor

import hertzchain as hc
from hertzchain.chain.drawn_bodies import body_centres
from hertzchain.designs.distribution import Distribution
from hertzchain.notebook import animations
from hertzchain.plotting import animation
from hertzchain.plotting.animation import animate
from hertzchain.plotting.budget import plot_budget
from hertzchain.plotting.chains import material_colour, plot_chain
from hertzchain.plotting.colours import COLOURS, signed_map
from hertzchain.plotting.design_beads import plot_beads
from hertzchain.plotting.enlarged import small_groups
from hertzchain.plotting.fits import plot_correlations
from hertzchain.plotting.legends import covers_data
from hertzchain.plotting.looks import method_style
from hertzchain.plotting.methods import METHODS
from hertzchain.plotting.runs import (
    force_curve,
    plot_forces,
    plot_forces_of_runs,
    section_ends,
)
from hertzchain.plotting.signals import draw_crest, draw_signal
from hertzchain.plotting.style import broken_title, figure_bytes, label_log_axis, set_figure_title
from hertzchain.plotting.titles import chain_title
from hertzchain.store.sweep_store import FAILED, MISSING
from hertzchain.sweeps.methods import pulse_by


@pytest.fixture(scope="module")
def run():
    chain = hc.Chain.tapered("forward-exponential", 0.05, beads=12)
    return hc.simulate(chain.replace(right_wall=hc.Wall()), until=40.0, times=200)


def test_forces_of_several_runs_in_the_same_axes_have_different_colours():
    run = hc.simulate(hc.Chain.uniform(9))
    axes = plot_forces(run, [3])
    plot_forces(run, [3], ax=axes)
    assert len({line.get_color() for line in axes.lines}) == 2


def test_warnings_of_plots_name_the_line_of_the_caller():
    chain = hc.Chain.uniform(20).replace(right_wall=hc.Wall())
    for call in (
        lambda run: plot_forces(run, [21]), lambda run: run.plot_forces([21]), hc.Run.wall_force,
    ):  # fmt: skip
        run = hc.simulate(chain, until=12.0)
        with pytest.warns(hc.IncompleteWarning) as seen:
            call(run)
        assert [each.filename for each in seen] == [__file__]


def test_traces_are_the_sensors(run):
    axes = plot_forces(run, [4, 13])
    for line, force in zip(axes.lines, (run.sensor(4), run.wall_force().force), strict=True):
        shown = np.isin(line.get_xdata(), run.times)
        np.testing.assert_array_equal(line.get_ydata()[shown], force)


def test_maxima_between_the_saved_times_are_drawn(run):
    few = hc.simulate(run.chain, until=40.0, times=81)
    wall, sensor = few.wall_force(), few.sensor_force(4)
    assert wall.force.max() < 0.9999 * wall.peak
    curves = [line.get_xydata() for line in plot_forces(few, [4, 13]).lines]
    assert (sensor.first_maximum_time, sensor.first_maximum) in [tuple(p) for p in curves[0]]
    assert curves[1].max(axis=0)[1] == wall.peak


def test_forces_name_the_run_and_balls_behind_a_striker():
    chain = hc.Chain.uniform(6).struck_by(velocity=1.0).replace(right_wall=hc.Wall())
    axes = plot_forces(hc.simulate(chain), ["ball 3", 5, 8], label="equal")
    assert legend_texts(axes) == [
        "equal, bead 4 (ball 3)", "equal, bead 5 (ball 4)", "equal, right wall",
    ]  # fmt: skip


def test_si_is_drawn_in_microseconds_and_newtons():
    chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=5, velocity=0.1)
    run = hc.simulate(chain, until=1e-4, times=50)
    axes = plot_forces(run, [2])
    assert axes.lines[0].get_xdata()[-1] == pytest.approx(100.0)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("time [µs]", "force [N]")
    assert run.plot("force").get_xlabel() == "time [µs]"


@pytest.mark.parametrize("of", ["energy", "momentum"])
def test_the_stack_ends_at_what_was_given(run, of):
    budget = run.budget()
    axes = plot_budget(budget, of)
    given = sum((budget.energy_given if of == "energy" else budget.momentum_given).values())
    top = max(path.get_paths()[0].vertices[:, 1].max() for path in axes.collections
              if path.get_paths())  # fmt: skip
    line = axes.lines[0].get_ydata()
    np.testing.assert_allclose(line, given)
    assert top >= line.max() - 1e-9
    if of == "energy":
        assert top == pytest.approx(line.max(), rel=1e-9)


def test_the_chain_is_to_scale():
    chain = hc.Chain.from_radii([2.0, 1.0, 3.0])
    np.testing.assert_allclose(body_centres(chain), [1.0, 2.5, 4.5])
    radii = [patch.vertices[:, 0].max() for patch in plot_chain(chain).collections[0].get_paths()]
    np.testing.assert_allclose(radii, [1.0, 0.5, 1.5])


def hammered(beads=4):
    """A flat hammer of 50 g, which as a steel ball would have a diameter of 23.1 mm."""
    row = hc.Chain.from_materials("4 mm", "steel-52100", beads=beads, right_wall=hc.Wall())
    return row.struck_by(velocity="0.1 m/s", mass="50 g", radius=np.inf)


def test_a_flat_striker_is_a_plate_of_the_height_of_the_balls():
    axes = plot_chain(hammered())
    plate, *balls = axes.collections[0].get_paths()
    assert len(plate.vertices) == 5
    np.testing.assert_allclose(np.ptp(plate.vertices, axis=0), [2.0, 8.0])
    assert all(len(ball.vertices) > 20 for ball in balls)
    # The chain ends behind the plate of 2 mm and four balls of 8 mm, at the wall.
    np.testing.assert_allclose(
        axes.collections[0].get_offsets()[:, 0], [1.0, 6.0, 14.0, 22.0, 30.0]
    )
    wall = axes.collections[1].get_paths()[0].vertices
    assert wall[:, 0].min() == pytest.approx(34.0)
    low, high = axes.get_xlim()
    assert high - low < 34.0 + 2.0 * 4.0


def test_bodies_are_drawn_at_their_places():
    axes = plot_chain(hammered())
    axes.figure.canvas.draw()
    pixels = np.asarray(axes.figure.canvas.buffer_rgba())[:, :, :3].astype(int)

    def colour_at(x, y):
        column, row = axes.transData.transform((x, y))
        return pixels[pixels.shape[0] - 1 - round(row), round(column)].tolist()

    steel, white = colour_at(6.0, 0.0), [255, 255, 255]
    assert steel != white
    # The plate has corners where a ball has none, and nothing is left of it.
    assert colour_at(0.3, 3.7) == colour_at(1.0, 0.0) == colour_at(30.0, 0.0) == steel
    assert colour_at(2.3, 3.7) == colour_at(-0.4, 0.0) == white


@pytest.mark.long
@pytest.mark.parametrize("width", ["single column", "double column"])
def test_diameters_of_designs_leave_out_flat_strikers(width):
    balls = hc.vary.balls(materials=["steel-52100"], diameters=["6 mm", "8 mm"])
    problem = hc.Design(hammered(), minimise="wall_force.peak", vary=[balls])
    found = hc.design(problem, budget=20)
    with hc.figure_style(width):
        axes = plot_beads(found)
    texts = [text.get_text() for text in axes.findobj(plt.Text)]
    assert "flat" in texts
    assert not any("23." in text for text in texts)
    axes.figure.canvas.draw()
    # Five bodies of at most 8 mm.
    assert axes.dataLim.x1 < 2.0 + 4 * 8.0 + 1.0


def test_the_notebook_draws_flat_strikers_as_plates():
    html = hammered()._repr_html_()
    assert html.count("<circle") == 4
    # The wall is the other rectangle.
    assert html.count("<rect") == 2
    assert "11.5" not in html


@pytest.mark.long
@pytest.mark.parametrize(
    ("width", "inches"),
    [("single column", 86 / 25.4), ("double column", 178 / 25.4), ("120 mm", 120 / 25.4), (4, 4)],
)
def test_figures_have_the_width_of_a_journal_and_readable_text(run, width, inches, tmp_path):
    with hc.figure_style(width):
        for axes in (
            run.pulse().plot(),
            run.plot(),
            plot_forces(run, [4, 13]),
            plot_chain(run.chain),
        ):
            assert axes.figure.get_size_inches()[0] == pytest.approx(inches)
            assert axes.get_title() == ""
            axes.figure.savefig(tmp_path / "figure.png")
            with Image.open(tmp_path / "figure.png") as picture:
                assert picture.width == pytest.approx(300 * inches, abs=1.0)
            sizes = {text.get_fontsize() for text in axes.findobj(plt.Text) if text.get_text()}
            assert min(sizes) >= 7.0
            # The layout must leave most of the figure to the axes.
            assert axes.get_position().width > 0.6
    # Outside of the block, figures have their usual size and a title.
    axes = run.pulse().plot()
    assert axes.figure.get_size_inches()[0] == pytest.approx(5.4)
    assert axes.get_title()


@pytest.mark.parametrize("width", ["wide", "3 kg", 86, 0.0, "5 mm", None])
def test_widths_are_lengths(width):
    if width is None:  # the usual size
        with hc.figure_style(width):
            assert plt.figure().get_figwidth() == pytest.approx(5.4)
        return
    with pytest.raises(hc.InputError, match="width"), hc.figure_style(width):
        pass


def test_an_animation_moves(run, tmp_path):
    file = animate(run, tmp_path / "beads.gif", frames=6)
    with Image.open(file) as pictures:
        assert pictures.n_frames == 6
        first = np.asarray(pictures.convert("RGB"))
        pictures.seek(3)
        assert np.any(np.asarray(pictures.convert("RGB")) != first)


def test_the_axis_of_an_animation_is_not_at_the_edge_of_the_picture(tmp_path):
    run = hc.simulate(hc.Chain.uniform(5), until=9.3, times=20)
    with Image.open(animate(run, tmp_path / "a.gif", frames=2)) as pictures:
        dark = np.asarray(pictures.convert("L")) < 128
    columns = np.flatnonzero(dark.any(axis=0))
    assert columns[0] >= 10
    assert columns[-1] <= dark.shape[1] - 15


def test_panels_for_a_journal_keep_the_names_of_sensors_and_own_titles(run):
    traces, chain_file = hc.example_experiment()
    simulated = hc.simulate(hc.load_chain(chain_file), until="600 us", times=601)
    with hc.figure_style("double column"):
        figure, (left, middle, right) = plt.subplots(1, 3, figsize=(7.0, 2.3))
        left.set_title("(a) equal beads", loc="left")
        run.plot(ax=left)
        middle.set_title("own")
        run.plot(ax=middle)
        simulated.compare(traces).plot("wall", ax=right)
    assert [left.get_title(), left.get_title("left")] == ["", "(a) equal beads"]
    assert [middle.get_title(), right.get_title()] == ["own", "wall"]
    plt.close(figure)


def test_notebooks_show_animations(run, tmp_path, monkeypatch):
    file = animate(run, tmp_path / "a&b.gif", frames=2)
    path = tmp_path / "a&b.gif"
    # To a script, it is a path.
    assert (file, repr(file), hash(file)) == (path, repr(path), hash(path))
    assert pickle.loads(pickle.dumps(file)) == path
    html = file._repr_html_()
    embedded = re.search('src="data:image/gif;base64,([^"]*)"', html)[1]
    assert base64.b64decode(embedded) == path.read_bytes()
    assert "a&amp;b.gif" in html
    assert "a&b" not in html
    assert file.parent._repr_html_() is None
    video = file.with_suffix(".mp4")
    video.write_bytes(b"film")
    assert 'src="data:video/mp4;base64,ZmlsbQ=="' in video._repr_html_()
    monkeypatch.setattr(animations, "MAX_SIZE", 3.0)
    assert "data:" not in file._repr_html_()
    assert "MB and is not shown" in file._repr_html_()
    path.unlink()
    assert file._repr_html_() is None


def test_an_animation_shows_the_forces_in_sensors(run, tmp_path, monkeypatch):
    drawn = []
    plotted = plt.Axes.plot
    monkeypatch.setattr(
        plt.Axes, "plot", lambda self, *args, **kw: drawn.append(args) or plotted(self, *args, **kw)
    )
    hc.animate(run, tmp_path / "a.gif", frames=2, sensors=[3, "bead 5"])
    for (_, force), bead in zip(drawn[1:], (3, 5), strict=True):
        np.testing.assert_array_equal(force, run.sensor_force(bead).force)
    with pytest.raises(hc.InputError, match="at most 4 sensors, got 5"):
        hc.animate(run, tmp_path / "a.gif", sensors=[2, 3, 4, 5, 6])


def test_animated_beads_of_several_materials_have_rings_and_a_legend(tmp_path):
    names = ["steel-52100", "brass", "ptfe"]
    balls = hc.Chain.from_materials("10 mm", names * 2, velocity="1 mm/s", beads=6)

    def pixels(run, name):
        with Image.open(animate(run, tmp_path / name, frames=2)) as pictures:
            pictures.seek(1)
            return {colour for _, colour in pictures.convert("RGB").getcolors(1 << 16)}

    colours = {ImageColor.getrgb(material_colour(each)) for each in names}
    assert colours <= pixels(hc.simulate(balls, times=4), "several.gif")
    one = hc.Chain.from_materials("10 mm", "brass", velocity="1 mm/s", beads=6)
    assert not colours & pixels(hc.simulate(one, times=4), "one.gif")


def test_bad_requests(run, tmp_path):
    with pytest.raises(hc.InputError, match=r"end in \.gif or \.mp4"):
        animate(run, tmp_path / "beads.avi")
    with pytest.raises(hc.InputError, match="the folder .* does not exist"):
        animate(run, tmp_path / "nowhere" / "beads.gif")
    with pytest.raises(hc.InputError, match="bead must be a whole number from 1 to 12, got 99"):
        plot_forces(run, [99])
    with pytest.raises(hc.InputError, match="unknown balance"):
        plot_budget(run.budget(), "mass")
    with pytest.raises(hc.InputError, match="unknown quantity of a map"):
        run.plot("mass")


@pytest.mark.parametrize(
    ("of", "label"), [("energy", "energy [µJ]"), ("momentum", "momentum [mN s]")]
)
def test_a_budget_in_real_units_has_a_prefix(of, label):
    # 4.07 g with 0.3 m/s: 183 microjoules, 1.22 mN s.
    chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=4, velocity=0.3)
    axes = hc.simulate(chain, until=50e-6).budget().plot(of)
    assert axes.get_ylabel() == label
    start = {"energy": "183", "momentum": "1.22"}[of]
    line = axes.lines[0].get_ydata()[0]
    assert axes.yaxis.get_major_formatter()(line, 0).startswith(start)


def animated(run, tmp_path, monkeypatch, **options):
    """Centres of the beads and the walls of each frame, and the texts of the last."""
    frames = []

    def recorded(axes, *args):
        bodies, left = drawn(axes, *args)
        frames.append((bodies[0], axes))
        return bodies, left

    drawn = animation._draw_beads
    positions = []
    monkeypatch.setattr(animation, "_draw_beads", recorded)
    monkeypatch.setattr(animation, "_gif", lambda *_: b"GIF")

    def each(*_):
        beads, axes = frames[0]
        walls = [wall.get_bbox().intervalx for wall in axes.patches]
        positions.append((beads.get_offsets()[:, 0].copy(), np.array(walls)))

    animate(run, tmp_path / "x.gif", progress=each, **options)
    below = frames[0][1].figure.axes[1]
    texts = [below.get_title("left"), below.get_title("right"), below.get_xlabel()]
    return positions, texts, frames[0][1]


@pytest.mark.parametrize(
    "gap", ["0 mm", *(pytest.param(each, marks=pytest.mark.long) for each in ("1 mm", "20 um"))]
)
def test_animated_bodies_never_pass_through_each_other(gap, tmp_path, monkeypatch):
    balls = hc.Chain.from_materials("10 mm", "steel-52100", beads=5, gaps=gap)
    chain = balls.struck_by(velocity="0.1 m/s", gap=gap).replace(
        right_wall=hc.Wall(gap=gap), left_wall=hc.Wall(gap=gap), loss=hc.Restitution(0.9)
    )
    run = hc.simulate(chain, until="60 ms" if gap == "1 mm" else "3 ms", times=1500)
    frames, _, axes = animated(run, tmp_path, monkeypatch, frames=30)
    radius, touched = 0.01, 0
    pixel = np.diff(axes.get_xlim())[0] / axes.get_window_extent().width
    for centres, walls in frames:
        ends = [walls[0, 1] - radius, *centres, walls[1, 0] + radius]
        overlaps = 2.0 * radius - np.diff(ends)
        # Positions are rounded to pixels.
        assert overlaps.max() < 0.2 * radius + pixel
        touched += np.any(overlaps > -pixel)
    assert touched > 5 if gap == "0 mm" else touched
    # Walls are in front of the beads.
    assert min(wall.get_zorder() for wall in axes.patches) > axes.collections[0].get_zorder()


def test_gaps_are_magnified_like_displacements(tmp_path, monkeypatch):
    balls = hc.Chain.from_materials("10 mm", "steel-52100", beads=3, gaps="1 mm")
    chain = balls.struck_by(velocity="0.1 m/s", gap="2 mm").replace(right_wall=hc.Wall(gap="1 mm"))
    run = hc.simulate(chain, until="21 ms", times=100)
    frames, texts, axes = animated(run, tmp_path, monkeypatch, frames=5, magnify=3.0)
    centres, walls = frames[0]
    pixel = np.diff(axes.get_xlim())[0] / axes.get_window_extent().width
    np.testing.assert_allclose(np.diff(centres), [0.026, 0.023, 0.023], atol=pixel)
    assert walls[0, 0] - centres[-1] == pytest.approx(0.013, abs=pixel)
    # After 20 ms, the striker has touched bead 2 and transferred its velocity.
    assert frames[-1][0][0] - centres[0] == pytest.approx(0.006, abs=pixel)
    assert texts == [
        "displacements and gaps magnified 3 times; velocity up to 0.1 m/s: red to the right, "
        "blue to the left",
        "t = 21.00 ms", "time [ms]",
    ]  # fmt: skip


@pytest.mark.long
def test_a_driven_wall_moves_in_an_animation(tmp_path, monkeypatch):
    drive = hc.SineBurst("5 um", 5e3, cycles=0.5, of="displacement", window="none")
    balls = hc.Chain.from_materials("10 mm", "steel-52100", beads=3)
    chain = balls.replace(left_wall=hc.Wall(), drive=drive)
    run = hc.simulate(chain, until="0.2 ms", times=26)
    frames, _, _ = animated(run, tmp_path, monkeypatch, frames=26, magnify=100.0)
    edges = np.array([walls[0, 1] for _, walls in frames])
    np.testing.assert_allclose(edges, 100.0 * drive.value(run.times), atol=1e-9)


def test_an_animation_reports_its_progress_and_needs_ffmpeg_for_mp4(run, tmp_path, monkeypatch):
    drawn = []
    animate(run, tmp_path / "x.gif", frames=3, progress=lambda *done: drawn.append(done))
    assert drawn == [(1, 3), (2, 3), (3, 3)]
    monkeypatch.setattr("matplotlib.rcParams", {**plt.rcParams, "animation.ffmpeg_path": "none"})
    with pytest.raises(hc.InputError, match="requires the program ffmpeg"):
        animate(run, tmp_path / "x.mp4", frames=3)


@pytest.mark.skipif(not FFMpegWriter.isAvailable(), reason="ffmpeg is not installed")
def test_an_animation_as_mp4(run, tmp_path):
    assert b"ftyp" in animate(run, tmp_path / "x.mp4", frames=3).read_bytes()[:16]


def test_labels_state_what_differs():
    tapers = [
        hc.Chain.tapered("forward-exponential", q, beads=n)
        for q, n in ((0.01, 9), (0.02, 9), (0.02, 12))
    ]
    axes = hc.plot_pulses([hc.bca(chain) for chain in tapers])
    assert legend_texts(axes) == [
        "$q$ = 0.01, 9 beads",
        "$q$ = 0.02, 9 beads",
        "$q$ = 0.02, 12 beads",
    ]
    assert axes.get_title() == "BCA, forward-exponential"
    methods = hc.plot_pulses([hc.bca(tapers[0]), hc.propagate(tapers[0])])
    assert legend_texts(methods) == ["BCA", "propagation", "last bead (free end)"]
    assert methods.get_title() == "forward-exponential, $q$ = 0.01, 9 beads"
    alone = hc.plot_pulses(hc.bca(tapers[0]))
    assert (legend_texts(alone), alone.get_title()) == (["BCA"], methods.get_title())
    given = hc.plot_pulses([hc.bca(chain) for chain in tapers], labels=["a", "b", "$q_1$"])
    assert legend_texts(given) == ["a", "b", "$q_1$"]


def test_colours_show_chains_and_lines_show_methods():
    tapers = [hc.Chain.tapered("forward-exponential", q, beads=9) for q in (0.01, 0.02)]
    pulses = [method(chain) for chain in tapers for method in (hc.propagate, hc.bca)]
    axes = hc.plot_pulses(pulses, residuals=True)
    words = ["$q$ = 0.01", "$q$ = 0.02", "propagation", "BCA", "last bead (free end)"]
    assert legend_texts(axes) == words
    assert axes.get_title() == "forward-exponential, 9 beads"
    curves = [line for line in axes.lines if len(line.get_xdata()) > 1]
    colours, lines, markers = (
        [getattr(curve, f"get_{name}")() for curve in curves]
        for name in ("color", "linestyle", "marker")
    )
    assert colours[0] == colours[1] != colours[2] == colours[3]
    assert lines[0] == lines[2] != lines[1] == lines[3]
    assert markers[0] == markers[2] != markers[1] == markers[3]
    # Differences from the simulation of the same chain.
    _, below = axes.figure.axes
    shown = [line.get_ydata() for line in below.lines[1:] if len(line.get_ydata()) > 1]
    for (exact, theory), found in zip((pulses[:2], pulses[2:]), shown, strict=True):
        expected = 100.0 * (theory.velocity / exact.velocity - 1.0)
        np.testing.assert_allclose(found, expected[: len(found)])
    named = hc.plot_pulses(pulses, labels=["a", "b", "c", "d"])
    assert legend_texts(named)[:4] == ["a", "b", "c", "d"]
    # Chains that their descriptions do not distinguish have a colour per pulse.
    alike = hc.plot_pulses([*pulses, *pulses])
    assert len({line.get_linestyle() for line in alike.lines} - {"None"}) == 1


def test_a_method_has_one_colour_and_name_in_all_figures():
    chain = hc.Chain.tapered("forward-exponential", 0.05, beads=20)
    names = ["bca", "modified-bca", "local-rate", "two-thirds-bca", "modified-bca-printed"]
    looks = {METHODS[each].name: method_style(each)["color"] for each in names}
    assert len({*looks.values()}) == len(names)
    pulses = [pulse_by(each, chain) for each in names[::-1]]
    swept = hc.sweep({"chain": {"taper": "forward-exponential", "beads": 20},
                      "axes": {"rate": [0.02, 0.05]},
                      "sweep": {"methods": names[1:], "keep": ["velocity"]}})  # fmt: skip
    board = hc.plotting.plot_scoreboard(hc.scoreboard(theories=names[:0:-1]))
    for axes in (hc.plot_pulses(pulses), hc.plot_sweep(swept, "velocity", bead=15), board):
        drawn = {line.get_label(): line.get_color() for line in axes.lines}
        found = {name: drawn[name] for name in looks.keys() & drawn.keys()}
        assert len(found) >= len(names) - 1
        assert found == {name: looks[name] for name in found}
    # Curves that are added have colours that no method in the axes has, as long as there are any.
    axes = hc.plot_pulses([pulses[-1], hc.propagate(chain)])
    for _ in range(8):
        pulses[-1].plot(ax=axes)
        drawn = [line.get_color() for line in axes.lines if len(line.get_xdata()) > 1]
        assert len({*drawn}) == min(len(drawn), len(COLOURS))
    run = hc.simulate(chain, times=50)
    axes = run.plot_forces(3)
    axes.plot([0.0, 1.0], [0.0, 0.1], color=COLOURS[1])
    run.plot_forces([5, 7], ax=axes)
    assert len({line.get_color() for line in axes.lines}) == 4
    # A theory of the user has a colour that is not that of another curve.
    own = hc.Pulse(chain=chain, method="mine", velocity=pulses[0].velocity)
    curves = hc.plot_pulses([*pulses, own]).lines
    assert len({line.get_color() for line in curves if len(line.get_xdata()) > 1}) == len(names) + 1


def test_differences_of_a_short_chain_end_at_its_free_end():
    pulses = [hc.propagate(hc.Chain.uniform(n)) for n in (6, 12)]
    _, lower = hc.plot_pulses(pulses, residuals=True).figure.axes
    (end,) = [line for line in lower.lines if line.get_linestyle() == "None"]
    assert end.get_xdata().tolist() == [6]


def test_thousands_of_newtons_have_no_exponent():
    chain = hc.Chain.from_materials("20 mm", "steel-52100", beads=4, velocity="1 m/s")
    for factor in (0.3, 1.0, 8.0):
        struck = chain.replace(velocities=factor * chain.velocities, right_wall=hc.Wall())
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", hc.ModelRangeWarning)
            run = hc.simulate(struck)
        texts = legend_texts(
            plot_forces_of_runs({"a": run, "b": run}, {"a": ["right wall"], "b": ["right wall"]})
        )
        peak = run.wall_force().peak
        assert float(texts[0].split()[1]) == pytest.approx(peak, rel=5e-3)
        assert "e+" not in texts[0]


def test_a_shorter_run_states_where_it_ends():
    chain = hc.Chain.uniform(9).replace(right_wall=hc.Wall())
    runs = [hc.simulate(chain, until=end, times=100) for end in (20.0, 21.0, 60.0)]
    named = dict(zip("abc", runs, strict=True))
    axes = plot_forces_of_runs(named, {name: [4] for name in named})
    peak = f"{runs[0].sensor_force(4).largest_so_far:.3g}"
    shown = [
        f"a: {peak} (run ends at $t$ = 20)", f"b: {peak} (run ends at $t$ = 21)", f"c: {peak}",
    ]  # fmt: skip
    assert legend_texts(axes) == shown
    balls = hc.Chain.from_materials("5 mm", "brass", beads=9, velocity="1 cm/s")
    axes = hc.simulate(balls, until="200 us").plot_forces([4])
    hc.simulate(balls, until="600 us").plot_forces([4], ax=axes)
    assert legend_texts(axes) == ["bead 4 (run ends at 200 µs)", "bead 4"]
    with pytest.raises(hc.InputError, match=r"to compare two runs, use run.pulse\(\).compare"):
        runs[0].compare(runs[1])


def test_a_comparison_with_traces_shows_the_peaks():
    traces, chain = hc.example_experiment()
    compared = hc.simulate(hc.load_chain(chain), until=6e-4, times=1201).compare(traces)
    wall = compared.sensors[-1]
    peaks = f"data {wall.measured_peak:.4g} N, simulation {wall.simulated_peak:.4g} N"
    for axes in (compared.plot().axes[-2], compared.plot("wall")):
        assert axes.get_title() == f"wall, peak: {peaks}"
    with hc.figure_style("double column"):
        assert compared.plot("wall").get_title() == "wall"
    # The axis has the unit of the peaks, also if its limit has another one.
    (shot,) = traces.shots
    volts = 0.97 / wall.measured_peak * shot.signals[-1].values
    data = hc.Traces.from_arrays(shot.times, {"wall [V]": volts})
    axes = hc.simulate(hc.load_chain(chain), until=6e-4, times=1201).compare(data).plot("wall")
    assert "data 970.0 mV" in axes.get_title()
    assert axes.get_ylim()[1] > 1.0
    assert axes.get_ylabel() == "signal [mV]"


def test_curves_beyond_the_last_colour_have_other_symbols():
    axes = hc.plot_pulses([hc.bca(hc.Chain.uniform(n)) for n in range(5, 17)])
    looks = {(line.get_color(), line.get_marker()) for line in axes.lines}
    assert len(looks) == 12


@pytest.mark.parametrize(("largest", "scale"), [(75.0, "log"), (6.0, "linear")])
def test_differences_are_visible_beside_that_of_one_bead(largest, scale):
    exact = hc.propagate(hc.Chain.uniform(40))
    arrival = 1.02 * exact.arrival
    arrival[2] *= 1.0 + largest / 100.0
    other = dataclasses.replace(exact, arrival=arrival, method="other")
    lower = hc.plot_pulses([exact, other], "arrival", residuals=True).figure.axes[1]
    assert lower.get_yscale() == scale


def test_small_differences_are_visible_beside_large_ones():
    chain = hc.Chain.tapered("backward-exponential", 0.02, beads=60)
    pulses = [hc.propagate(chain), hc.bca(chain), hc.local_rate(chain)]
    lower = hc.plot_pulses(pulses, residuals=True).figure.axes[1]
    assert lower.get_yscale() == "log"
    assert lower.get_ylabel() == "|difference|\nfrom propagation\n[%]"
    errors = 100.0 * np.abs(pulses[2].velocity / pulses[0].velocity - 1.0)
    # The logarithmic axis has no place for the exact velocity of bead 1.
    assert errors[0] == 0.0
    np.testing.assert_allclose(lower.lines[2].get_ydata()[1:], errors[1:-1])
    assert lower.get_ylim()[0] < errors.max() < lower.get_ylim()[1]
    similar = hc.plot_pulses([pulses[0], hc.bca(chain), hc.modified_bca(chain)], residuals=True)
    assert similar.figure.axes[1].get_yscale() == "linear"


def test_maps_relative_to_each_contact_show_weak_waves():
    radii = np.where(np.arange(40) < 20, 1.0, 0.3)
    run = hc.simulate(hc.Chain.from_radii(radii), until=60.0, times=4000)
    plain, relative = (run.plot("force", relative=each).collections[0] for each in (False, True))
    assert np.max(plain.get_array()[30]) < 0.5 * np.max(run.forces)
    assert (np.max(relative.get_array()[1:-1], axis=1) > 0.98).all()
    assert np.max(relative.get_array()[-1]) == 0.0  # the free end
    label = run.plot(relative=True).figure.axes[1].get_ylabel()
    assert label == "velocity / largest of the bead"
    with pytest.raises(hc.InputError, match="relative must be True or False"):
        run.plot(relative="bead")


def test_scaled_and_si_pulses_do_not_share_an_axis():
    balls = hc.Chain.from_materials("5 mm", "brass", beads=20, velocity="1 mm/s")
    with pytest.raises(hc.InputError, match="scaled chains and of chains in SI units cannot share"):
        hc.plot_pulses([hc.propagate(hc.Chain.uniform(20)), hc.propagate(balls)], "peak_force")
    hc.plot_pulses(
        [hc.propagate(hc.Scales.of(balls).to_scaled(balls)), hc.bca(hc.Chain.uniform(20))]
    )


def test_plots_over_time_need_saved_times(tmp_path):
    run = hc.simulate(hc.Chain.uniform(5), until=1.0, times=[1.0])
    for draw, what in (
        (run.plot, "a map"),
        (lambda: run.plot_forces([2]), "a plot"),
        (run.budget().plot, "a stacked plot"),
        (lambda: hc.animate(run, tmp_path / "beads.gif"), "an animation"),
    ):
        needed = f"^{what} needs at least 2 saved times, but the run has 1; give simulate times,"
        with pytest.raises(hc.InputError, match=needed):
            draw()


def test_residuals_are_relative_differences_from_the_first_pulse():
    chain = hc.Chain.tapered("backward-exponential", 0.05, beads=30)
    exact, theory = hc.propagate(chain), hc.bca(chain)
    upper = hc.plot_pulses([exact, theory], residuals=True)
    lower = upper.figure.axes[1]
    expected = 100.0 * (theory.velocity / exact.velocity - 1.0)
    curve, end = (np.asarray(line.get_ydata()) for line in lower.lines[1:])
    np.testing.assert_allclose(np.append(curve, end), expected)
    assert len(end) == 1  # at the free end
    with pytest.raises(hc.InputError, match="residuals need at least two pulses"):
        hc.plot_pulses([exact], residuals=True)
    for bad in (upper, [upper], [upper, lower, lower]):
        with pytest.raises(hc.InputError, match="ax must be a pair of axes"):
            hc.plot_pulses([exact, theory], residuals=True, ax=bad)
    _, pair = plt.subplots(2, 2)
    assert hc.plot_pulses([exact, theory], residuals=True, ax=pair[:, 1]) is pair[0, 1]
    np.testing.assert_allclose(pair[1, 1].lines[1].get_ydata(), expected[:-1])
    assert pair[1, 1].get_xlim() == pair[0, 1].get_xlim()
    assert (pair[0, 1].get_xlabel(), pair[1, 1].get_xlabel()) == ("", "bead $k$")
    with pytest.raises(hc.InputError, match="there must be 2 labels, one per pulse, got 1"):
        hc.plot_pulses([exact, theory], labels=["one"])


def test_a_free_end_is_apart_and_exact_zeros_are_hidden_on_logarithmic_axes():
    chain = hc.Chain.tapered("backward-exponential", 0.05, beads=40)
    exact, theory, law = hc.propagate(chain), hc.bca(chain), hc.local_rate(chain)
    axes = law.compare(exact).plot("velocity")
    curve, end = axes.lines[:2]
    assert curve.get_xdata().tolist() == list(range(2, 40))
    assert (end.get_xdata().tolist(), end.get_linestyle()) == ([40], "None")
    _, (_, lower) = plt.subplots(2)
    hc.plot_pulses([exact, theory, law], residuals=True, ax=[axes, lower])
    assert lower.get_yscale() == "log"
    for line in lower.lines:
        assert not (np.asarray(line.get_ydata(), float) == 0.0).any()


def test_strikers_are_marked_above_the_chain():
    chain = hc.Chain.uniform(6)
    plain = plot_chain(chain)
    assert not plain.texts
    top = plain.get_ylim()[1]
    for count, word in ((1, "striker"), (3, "3 strikers")):
        axes = plot_chain(chain.struck_by(count=count, radius=0.5))
        assert axes.texts[-1].get_text() == word
        arrow = axes.texts[0]
        # The arrow is as long as the strikers, of radius 0.5.
        assert arrow.xy[0] - arrow.xyann[0] == pytest.approx(count)
        assert 1.0 < arrow.xy[1] < axes.get_ylim()[1]
        assert axes.get_ylim()[1] > top


def test_all_plots_of_a_run_have_the_same_title():
    balls = hc.Chain.from_materials("5 mm", "steel-52100", beads=8)
    chain = balls.struck_by(velocity=0.1, count=2).replace(
        right_wall=hc.Wall(), loss=hc.Restitution(0.95)
    )
    run = hc.simulate(chain)
    for axes in (run.plot(), run.plot_forces([3]), run.pulse().plot(), run.budget().plot()):
        title = axes.get_title().replace("\n", " ")
        assert title == "8 steel balls and 2 strikers, 10 mm, restitution 0.95"
    # Chains that differ in what titles do not contain are distinguished.
    gap = chain.replace(gaps=[0.0] * 5 + [1e-6] + [0.0] * 3)
    axes = hc.plot_pulses([run.pulse(), hc.simulate(gap).pulse()])
    assert len(set(legend_texts(axes))) == 2
    assert legend_texts(axes)[:2] == ["no gaps", "gap of 1 µm in contact 6"]


def test_locations_have_the_same_colour_in_every_budget():
    chain = hc.Chain.uniform(8).replace(right_wall=hc.Wall(), loss=hc.Restitution(0.8))
    budget = hc.simulate(chain, until=20.0).budget()
    axes = budget.plot()
    handles, labels = axes.get_legend_handles_labels()
    drawn = {
        label.removesuffix(" (kinetic)"): to_hex(handle.get_facecolor()[0])
        for handle, label in zip(handles, labels, strict=True) if label != "total input"
    }  # fmt: skip
    assert {"leading pulse", "lagging", "scattered back", "contacts", "lost"} <= set(drawn)
    static = resources.files("hertzchain.app").joinpath("static/app.css").read_text()
    html = budget._repr_html_()
    for name, colour in drawn.items():
        of_app = re.search(rf"\.{name.replace(' ', '-')}(?:, [-.a-z]+)? {{ --part: (#\w+);", static)
        assert of_app is not None
        assert of_app[1] == colour
        assert f'fill="{colour}"' in html
    # Locations that are drawn together have different colours.
    assert len(set(drawn.values())) == len(drawn)


def test_maps_of_short_runs_are_smooth():
    run = hc.simulate(hc.Chain.uniform(3), until=5.0, times=12)
    for quantity, values in (("velocity", run.velocities), ("force", run.forces)):
        axes = run.plot(quantity)
        drawn = axes.collections[0].get_array()
        assert drawn.shape[1] >= 1000
        # Between the saved times, values are interpolated.
        assert np.abs(np.diff(drawn, axis=1)).max() < 0.02 * np.ptp(values)
        np.testing.assert_allclose(drawn[:, [0, -1]], values[[0, -1]].T, atol=1e-12)


def test_titles_name_strikers_walls_and_losses():
    balls = hc.Chain.from_materials("5 mm", "steel-52100", beads=40)
    struck = balls.struck_by(radius="10 mm", velocity=0.3)
    wall = hc.Wall.of("ptfe", gap="10 um")
    for chain, title in (
        (balls, "40 steel balls, 10 mm"),
        (balls.struck_by(velocity=0.3), "40 steel balls and a striker, 10 mm"),
        (
            balls.struck_by(mass="1 g", radius=np.inf),
            "40 steel balls of 10 mm, striker of 1 g",
        ),
        (struck.replace(right_wall=hc.Wall()), "40 steel balls, 10 mm, and a striker, 20 mm"),
        (
            balls.replace(right_wall=wall, loss=hc.Restitution(0.9)),
            "40 steel balls, 10 mm, PTFE wall at a distance of 10 µm, restitution 0.9",
        ),
        (hc.Chain.uniform(5).replace(right_wall=hc.Wall.rigid()), "5 equal beads, rigid wall"),
        (hc.Chain.uniform(5).replace(loss=hc.Dashpot(0.1)), "5 equal beads, with losses"),
        (
            hc.Chain.uniform(5).struck_by(mass=5.0, radius=1.0),
            "5 equal beads and 1 striker (mass 5)",
        ),
        (hc.Chain.uniform(5).struck_by(), "5 equal beads and 1 striker"),
        (hc.Chain.uniform(5).replace(masses=[1, 1, 4, 4, 4]), "given masses, 5 beads"),
        (
            hc.Chain.dimer(diameters=["10 mm", "6 mm"], materials=["brass", "ptfe"], beads=9),
            "9 balls of brass and PTFE, 10 mm and 6 mm in turn",
        ),
        (balls.replace(right_wall=hc.Wall(5e6, exponent=1)), "40 steel balls, 10 mm, wall 5 kN/mm"),
        (
            balls.replace(right_wall=hc.Wall("2 N/mm", exponent=1, gap="10 um")),
            "40 steel balls, 10 mm, wall 2 N/mm at a distance of 10 µm",
        ),
        (
            balls.replace(right_wall=hc.Wall(5e9)),
            "40 steel balls, 10 mm, wall 5 N/µm^1.5",
        ),
        (balls.replace(right_wall=hc.Wall(3e5)), "40 steel balls, 10 mm, wall 3e+05 N/m^1.5"),
        (
            balls.replace(right_wall=hc.Wall(4e7), exponent=2.0, stiffness=1e12),
            "40 steel balls, 10 mm, p = 2, wall 4e+07 N/m^2",
        ),
        (
            hc.Chain.uniform(5).replace(right_wall=hc.Wall(5e6)),
            "5 equal beads, wall of stiffness 5e+06",
        ),
    ):
        assert chain_title(chain) == title


@pytest.mark.long
def test_every_sensor_of_a_fit_has_a_legible_crest_with_points_and_line():
    result = hc.fit(*hc.example_experiment())
    figure = result.plot()
    figure.canvas.draw()
    sensors = result.traces.shots[0].signals
    # The signals are below each other, each above its residuals and beside its crest.
    blocks = np.reshape(figure.axes, (len(sensors), 3))
    assert len({axes.get_position().x0 for axes in blocks[:, 0]}) == 1
    for signal, (upper, lower, crest) in zip(sensors, blocks, strict=True):
        assert upper.get_title() == signal.name
        assert (crest.get_title(), lower.get_ylabel()) == ("crest", "residual\n/ noise")
        assert upper.get_position().x1 < crest.get_position().x0
        data, fit = crest.lines
        assert 5 < len(data.get_xdata()) < 0.2 * len(upper.lines[0].get_xdata())
        assert fit.get_ydata().max() == upper.lines[1].get_ydata().max()
        assert (
            upper.get_ylabel() == f"{'force' if signal.unit == 'N' else 'signal'} [{signal.unit}]"
        )
        # A thin line in front of wider symbols, or of a broad line, hides no deviation.
        for axes, width in ((upper, plt.Line2D.get_linewidth), (crest, plt.Line2D.get_markersize)):
            points, line = axes.lines[:2]
            assert points.get_zorder() < line.get_zorder()
            assert width(points) > 2.0 * line.get_linewidth()
    (words,) = ([text.get_text() for text in each.get_texts()] for each in figure.legends)
    assert words == ["data", "fit", "±2σ of the noise"]
    assert min(text.get_fontsize() for text in figure.findobj(plt.Text)) >= 8.0


def test_maps_of_correlations_have_no_negative_zeros(monkeypatch):
    result = hc.fit(*hc.example_experiment())
    monkeypatch.setattr(type(result), "correlation", np.array([[1.0, -0.004], [-0.004, 1.0]]))
    axes = plot_correlations(result).axes[0]
    assert [text.get_text() for text in axes.texts] == ["1", "0.00", "1"]


@pytest.mark.long
@pytest.mark.parametrize(
    ("value", "shown"),
    [(0.997, ">0.99"), (-0.9951, "<−0.99"), (0.9949, "0.99"), (-0.42, "−0.42"), (1.0, ">0.99")],
)
def test_maps_of_correlations_distinguish_1_from_almost_1(value, shown, monkeypatch):
    result = hc.fit(*hc.example_experiment())
    monkeypatch.setattr(type(result), "correlation", np.array([[1.0, value], [value, 1.0]]))
    figure = plot_correlations(result)
    assert [text.get_text() for text in figure.axes[0].texts] == ["1", shown, "1"]
    # No number is wider than its cell, and there are none in cells that are too small.
    with hc.figure_style("single column"):
        monkeypatch.setattr(type(result), "correlation", np.eye(len(result.names)))
        assert not plot_correlations(result).axes[0].texts


def test_corner_plots_have_medians_errors_and_a_legend():
    rng = np.random.default_rng(0)
    scales = np.array([1e-6, 0.02, 3.0])
    samples = scales * (50.0 + rng.normal(size=(4000, 3)))
    names, units = ("time_offset", "struck_by.velocity", "gain[wall]"), ("s", "m/s", "")
    posterior = hc.Posterior(names, samples, 0.5, 1.0, 100, 50.0 * scales, units)
    figure = posterior.plot()
    figure.draw_without_rendering()
    titles = [axes.get_title().splitlines() for axes in figure.axes if axes.get_title()]
    assert [title[0] for title in titles] == ["time offset", "striker velocity", "gain of wall"]
    for title, values, unit in zip(titles, samples.T * [[1e6], [1.0], [1.0]], ("µs", "m/s", ""),
                                   strict=True):  # fmt: skip
        low, median, high = np.percentile(values, [16.0, 50.0, 84.0])
        numbers = [float(each) for each in re.findall(r"[+-]?\d+\.\d+", title[-1])]
        assert numbers == pytest.approx([median, high - median, low - median], abs=0.01 * median)
        assert title[-1].endswith(f" {unit}" if unit else "$")
    (words,) = ([text.get_text() for text in each.get_texts()] for each in figure.legends)
    assert words == ["samples of the posterior", "value of the fit"]


@pytest.mark.long
@pytest.mark.parametrize("count", [1, 2, 3])
def test_corner_plots_state_that_there_are_too_few_steps(count):
    samples = 50.0 + np.random.default_rng(0).normal(size=(400, count))
    names = tuple(f"gain[b{i}]" for i in range(count))
    heights = []
    for steps in (4000, 40):
        arguments = 0.5, 20.0, steps, np.full(count, 50.0), ("",) * count
        figure = hc.Posterior(names, samples, *arguments).plot()
        figure.draw_without_rendering()
        (legend,) = figure.legends
        text = " ".join(" ".join(each.get_text() for each in legend.get_texts()).split())
        assert ("not converged" in text) == (steps == 40)
        box = legend.get_window_extent()
        assert not any(box.overlaps(axes.get_tightbbox()) for axes in figure.axes)
        heights.append(figure.axes[0].bbox.height)
    assert text.endswith("too few for an autocorrelation of 20 steps: take at least 1001")
    assert heights[1] > 0.8 * heights[0]


def test_maps_of_correlations_name_parameters_in_words():
    axes = hc.fit(*hc.example_experiment()).plot_correlations().axes[0]
    for labels in (axes.get_xticklabels(), axes.get_yticklabels()):
        words = [label.get_text() for label in labels]
        assert words[:3] == ["stiffness factor", "striker velocity", "relaxation time"]


def test_sensors_in_one_figure_need_one_legend():
    traces, file = hc.example_experiment()
    result = hc.fit(traces, file)
    compared = hc.simulate(hc.load_chain(file), until=600e-6, times=1201).compare(traces)
    for plotted in (result, compared):
        _, panels = plt.subplots(2, 2)
        plotted.plot("ball 6", ax=panels[:, 0])
        plotted.plot("wall", legend=False, ax=panels[:, 1])
        assert panels[0, 0].get_legend() is not None
        assert panels[0, 1].get_legend() is None


@pytest.mark.long
def test_labels_of_large_corner_plots_grow_with_the_figure():
    sizes = []
    for count in (2, 9):
        names = tuple(f"gain[b{i}]" for i in range(count))
        samples = np.random.default_rng(0).normal(size=(100, count))
        figure = hc.Posterior(names, samples, 0.5, 1.0, 100, np.zeros(count), ("",) * count).plot()
        sizes.append(figure.axes[-1].xaxis.label.get_size() / figure.get_figwidth())
    assert sizes[1] > 0.75 * 9.0 / 7.4


def test_a_crest_with_few_samples_says_so():
    times = np.linspace(0.0, 1e-3, 20)
    data = np.where(np.arange(20) == 7, 5.0, 0.0)
    signal = hc.Traces.from_arrays(times, {"wall [N]": data}, noise=0.1).shots[0].signals[0]
    axes = plt.figure().subplots()
    draw_crest(axes, times, signal, data, "fit")
    assert [text.get_text() for text in axes.texts] == ["too few\nsamples"]


def test_numbers_below_the_crests_of_narrow_figures_do_not_touch():
    times = np.arange(282.0, 314.0)
    data = 1.25 - ((times - 297.0) / 30.0) ** 2
    signal = hc.Traces.from_arrays(times, {"wall [N]": data}, noise=0.01).shots[0].signals[0]
    with hc.figure_style("single column"):
        axes = plt.figure().subplots()
        whole = np.concatenate([[0.0], data[1:-1], [0.0]])
        draw_crest(axes, times, signal, whole, "fit")
    left, right = axes.get_xlim()
    assert (left <= axes.get_xticks()).all()
    assert (axes.get_xticks() <= right).all()
    assert len(axes.get_xticks()) == 2


@pytest.mark.parametrize(("low", "high", "shown"), [(0.09, 0.52, {0.1, 0.2, 0.3, 0.5})])
def test_logarithmic_axes_of_less_than_a_decade_have_a_tick_at_5(low, high, shown):
    axes = plt.figure().subplots()
    axes.set(xscale="log", xlim=(low, high))
    label_log_axis(axes.xaxis)
    ticks = {round(each, 6) for each in axes.get_xticks() if low <= each <= high}
    assert ticks == shown


def test_the_legend_of_bands_covers_none():
    held = {"precompression": "0.02 N", "held_by": "force"}
    dimer = hc.Chain.dimer(diameters=["10 mm", "6 mm"], materials=["brass", "ptfe"], beads=41)
    for chain in (dimer, hc.Chain.from_materials(5e-3, "brass", beads=9)):
        axes = hc.spectrum(chain.replace(**held)).plot()
        axes.figure.canvas.draw()
        legend = axes.get_legend().get_window_extent()
        assert not covers_data(axes.get_legend())
        assert not any(legend.overlaps(each.get_window_extent()) for each in axes.patches)
        assert legend.x1 <= axes.figure.bbox.x1


def test_the_wall_has_a_name_where_sensors_are_named():
    run = hc.simulate(hc.Chain.uniform(6).replace(right_wall=hc.Wall()))
    np.testing.assert_array_equal(run.sensor("wall"), run.forces[:, -1])
    np.testing.assert_array_equal(run.sensor("Right  wall"), run.forces[:, -1])
    axes = run.plot_forces([3, "wall"])
    assert legend_texts(axes) == ["bead 3", "right wall"]
    both = run.chain.replace(left_wall=hc.Wall())
    held = hc.simulate(both, until=4.0)
    np.testing.assert_array_equal(held.sensor("left wall"), held.forces[:, 0])
    with pytest.raises(hc.InputError, match="two walls: give 'right wall' or 'left wall'"):
        held.sensor("wall")
    with pytest.raises(hc.InputError, match="no left wall; add a left_wall"):
        run.sensor("left wall")
    with pytest.raises(hc.InputError, match="no wall; add a right_wall"):
        hc.simulate(hc.Chain.uniform(6)).sensor("wall")


def test_narrow_figures_have_ticks_at_whole_beads_and_lines_that_survive_grey():
    pulse = hc.propagate(hc.Chain.uniform(16))
    axes = hc.plot_pulses([pulse, hc.bca(pulse.chain)], residuals=True)
    axes.figure.set_size_inches(3.4, 2.5)
    axes.figure.canvas.draw()
    lower = axes.figure.axes[1]
    np.testing.assert_array_equal(lower.get_xticks() % 1.0, 0.0)
    assert lower.get_ylabel() == "difference from\npropagation [%]"
    run = hc.simulate(hc.Chain.uniform(16).replace(right_wall=hc.Wall()))
    *sensors, wall = run.plot_forces([4, 8, 12, "wall"]).lines
    assert len({line.get_linestyle() for line in sensors}) == 3
    # A dashed or thin curve would look like a line for reference.
    assert wall.get_linestyle() == "-"
    assert wall.get_linewidth() > 1.5 * max(line.get_linewidth() for line in sensors)


def test_methods_hide_neither_curves_nor_symbols_of_each_other():
    chain = hc.Chain.tapered("forward-linear", 0.015, beads=40)
    exact, theory, law = hc.propagate(chain), hc.bca(chain), hc.local_rate(chain)
    upper = hc.plot_pulses([exact, theory, law], log=True, residuals=True)
    lower = upper.figure.axes[1]
    curves = [line for line in upper.lines if len(line.get_xdata()) > 1]
    assert len({line.get_linestyle() for line in curves}) == 3
    symbols = [line.get_xdata()[first::step] for line in curves
               for first, step in [line.get_markevery()]]  # fmt: skip
    assert min(map(len, symbols)) >= 12
    assert len({*np.concatenate(symbols)}) == sum(map(len, symbols))
    # No difference is below the panel, and both panels have ticks of the same kind.
    differences = 100.0 * np.abs(law.velocity / exact.velocity - 1.0)
    assert lower.get_ylim()[0] < differences[differences > 0.0].min()
    upper.figure.canvas.draw()
    for axis in (upper.yaxis, lower.yaxis):
        low, high = axis.get_view_interval()
        assert not [at for at in axis.get_minorticklocs() if low < at < high]
    np.testing.assert_array_equal(upper.get_xticks(), lower.get_xticks())


def test_the_last_bead_of_a_free_end_is_marked():
    chain = hc.Chain.uniform(20)
    exact, bca = hc.propagate(chain), hc.bca(chain)
    axes = hc.plot_pulses([exact, bca])
    assert legend_texts(axes) == ["propagation", "BCA", "last bead (free end)"]
    curves = [line for line in axes.lines if len(line.get_xdata()) > 1]
    free = [line for line in axes.lines if len(line.get_xdata()) == 1]
    # The binary collision approximation has no jump there, but describes the same bead.
    for pulse, curve, end in zip((exact, bca), curves, free, strict=True):
        assert curve.get_xdata().tolist() == list(range(1, 20))
        assert curve.get_ydata().tolist() == pulse.velocity[:-1].tolist()
        assert (end.get_xdata().tolist(), end.get_ydata().tolist()) == ([20], [pulse.velocity[-1]])
        assert end.get_linestyle() == "None"
    wall = chain.replace(right_wall=hc.Wall())
    walled = hc.simulate(wall).pulse().plot()
    assert legend_texts(walled) == ["simulation"]
    assert hc.plot_pulses([exact], "peak_force").lines[0].get_xdata().size == 19


def long_run(speed, beads, times=400):
    balls = hc.Chain.from_materials(5e-3, "steel-52100", beads=beads, velocity=speed)
    return hc.simulate(balls.replace(right_wall=hc.Wall()), times=times)


def test_runs_that_differ_much_share_axes_and_the_small_ones_are_enlarged_below():
    runs = {"strong": long_run(0.1, 8), "weak": long_run(1e-3, 60)}
    first = plot_forces_of_runs(runs, {"strong": [9], "weak": [61]})
    both, weak, strong = first.figure.axes
    assert first is both
    assert {axes.get_xlabel() for axes in first.figure.axes} == {"time [ms]"}
    assert len({axes.get_ylabel() for axes in first.figure.axes}) == 1
    assert len({line.get_color() for line in both.lines}) == 2
    peaks = [run.wall_force().peak for run in runs.values()]
    assert [line.get_ydata().max() for line in both.lines] == peaks
    # The weak force has an axis of forces of its own, the short run an axis of times.
    for axes, name, number in ((weak, "weak: force", 1), (strong, "strong: time", 0)):
        (line,) = axes.lines
        assert line.get_color() == both.lines[number].get_color()
        assert axes.get_ylim()[1] < 1.2 * peaks[number]
        end = 1e3 * runs[name.split(":")[0]].times[-1]
        assert axes.get_xlim()[1] == pytest.approx(end)
        assert axes.get_title(loc="left").startswith(f"{name} axis enlarged ")
    ratio = float(re.search(r"enlarged (\S+) times", weak.get_title(loc="left"))[1])
    assert ratio == pytest.approx(peaks[0] / peaks[1], rel=0.05)


def test_titles_with_long_names_are_inside_the_figure():
    names = [f"{kind} chain with a long name, 0.2 m/s (elastic-plastic)" for kind in ("a", "one")]
    runs = dict(zip(names, (long_run(0.1, 8), long_run(1e-3, 60)), strict=True))
    figure = plot_forces_of_runs(runs, {names[0]: [9], names[1]: [61]}).figure
    set_figure_title(figure, " and ".join(names) + ": elastic contacts, beyond yield")
    figure.draw_without_rendering()
    titles = [figure._suptitle, *(axes.title for axes in figure.axes)]
    titles += [axes._left_title for axes in figure.axes]
    assert sum("\n" in title.get_text() for title in titles) >= 2
    for title in titles:
        box = title.get_window_extent()
        assert box.x0 >= 0.0
        assert box.x1 <= figure.bbox.width
        assert "elastic-\n" not in title.get_text()


def test_all_short_runs_are_enlarged():
    runs = {str(beads): long_run(0.1, beads) for beads in (8, 14, 60)}
    first = plot_forces_of_runs(runs, {name: [int(name) + 1] for name in runs})
    _, short = first.figure.axes
    ends = [1e3 * run.times[-1] for run in runs.values()]
    # The second one is longer than a fifth of the longest run, but hardly legible beside it.
    assert 5.0 * ends[0] < ends[2] < 5.0 * ends[1]
    assert short.get_title(loc="left").startswith("8, 14: time axis enlarged ")
    assert short.get_xlim()[1] == pytest.approx(ends[1])


@pytest.mark.parametrize(("tops", "ends", "expected"), [
    ([1.0, 1.0, 1.0], [1.0, 2.0, 4.9], []),
    # Of similar durations, all are short, or none.
    ([1.0] * 4, [10.0, 19.0, 24.0, 100.0], [([0, 1, 2], True)]),
    ([1.0] * 4, [10.0, 60.0, 80.0, 100.0], [([0], True)]),
    # A curve that is short in an enlarged panel, too, has another one.
    ([1.0] * 3, [1.0, 15.0, 100.0], [([0, 1], True), ([0], True)]),
    ([1.0] * 4, [1.0, 15.0, 50.0, 100.0], [([0, 1], True), ([0], True)]),
    # Forces that are weak and short do not share axes with long ones.
    ([9.0, 1.0, 1.0, 9.0], [99.0, 99.0, 9.0, 9.0], [([1], False), ([2], True), ([3], True)]),
    ([9.0, 0.0], [1.0, 1.0], []),
])  # fmt: skip
def test_curves_that_are_small_beside_others_are_grouped(tops, ends, expected):
    assert small_groups(tops, ends) == expected


def test_large_factors_of_enlarged_axes_have_no_exponent():
    runs = {"strong": long_run(0.1, 8), "weak": long_run(1e-3, 12)}
    _, weak = plot_forces_of_runs(runs, {"strong": [9], "weak": [13]}).figure.axes
    # The peak force of a solitary wave is proportional to v^(6/5).
    assert weak.get_title(loc="left") == "weak: force axis enlarged 250 times"


def test_runs_in_different_units_have_a_panel_each():
    scaled = hc.simulate(hc.Chain.uniform(6).replace(right_wall=hc.Wall()))
    runs = {"real": long_run(0.1, 8), "scaled": scaled}
    figure = plot_forces_of_runs(runs, {"real": [9], "scaled": [7]}).figure
    assert [axes.get_xlabel() for axes in figure.axes] == ["time [µs]", "time $t$"]
    assert [axes.get_ylabel() for axes in figure.axes] == ["force [N]", "force $F$"]


@pytest.mark.long
def test_all_plots_of_a_run_have_the_same_unit_of_time():
    for run, label, factor in ((long_run(0.1, 8), "time [µs]", 1e6),
                               (long_run(1e-3, 60, 2000), "time [ms]", 1e3)):  # fmt: skip
        plots = [run.plot(), run.plot("force"), run.plot_forces([3]), run.budget().plot(),
                 run.waves().plot()]  # fmt: skip
        assert {axes.get_xlabel() for axes in plots} == {label}
        assert plots[0].get_xlim()[1] == pytest.approx(factor * run.times[-1], rel=0.01)
        traces = hc.Traces.from_arrays(
            run.times, {"wall [N]": run.forces[:, -1].round(9)}, noise=0.1
        )
        axes = traces.plot()
        assert axes.get_xlabel() == label
        assert axes.lines[0].get_xdata()[-1] == pytest.approx(factor * run.times[-1])


def test_similar_runs_share_axes_and_their_unit_of_time():
    # Only the second run is longer than 2 ms.
    runs = {"fast": long_run(0.01, 30), "slow": long_run(0.005, 34)}
    ends = [1e3 * run.times[-1] for run in runs.values()]
    assert ends[0] < 2.0 < ends[1]
    axes = plot_forces_of_runs(runs, {"fast": [31], "slow": [35]})
    assert len(axes.figure.axes) == 1
    assert axes.get_xlabel() == "time [µs]"
    assert [line.get_xdata()[-1] for line in axes.lines] == pytest.approx([1e3 * t for t in ends])


def test_maps_show_the_boundaries_of_sections():
    kinds = ["steel-52100"] * 5 + ["ptfe"] * 4 + ["brass"] * 6
    run = hc.simulate(hc.Chain.from_materials(5e-3, kinds, velocity=1e-3))
    lines = {what: [line.get_ydata()[0] for line in run.plot(what).lines]
             for what in ("velocity", "force")}  # fmt: skip
    # Contact 5 joins beads 5 and 6.
    assert lines == {"velocity": [5.5, 9.5], "force": [5.0, 9.0]}
    struck = hc.Chain.from_materials(5e-3, kinds).struck_by(velocity=1e-3, diameter="6 mm")
    assert section_ends(struck) == [6, 10]
    for plain in (hc.Chain.uniform(9), hc.Chain.tapered("forward-linear", 0.02, beads=9),
                  hc.Chain.dimer(diameters=["10 mm", "6 mm"], materials=["brass", "ptfe"], beads=9,
                                 velocity=1e-3)):  # fmt: skip
        assert section_ends(plain) == []


def test_forces_of_one_place_are_drawn_without_a_list():
    run = hc.simulate(hc.Chain.uniform(8).replace(right_wall=hc.Wall()))
    for place, label in (("wall", "right wall"), (3, "bead 3"), ("bead 4", "bead 4")):
        axes = run.plot_forces(place)
        assert legend_texts(axes) == [label]
    with pytest.raises(hc.InputError, match=r"beads or walls, such as \[3, 'ball 6', 'wall'\]"):
        run.plot_forces(3.5)
    for call in (run.sensor, lambda bead: run.plot_forces([bead])):
        with pytest.raises(hc.InputError, match="or 'wall', got 'peak'"):
            call("peak")


def test_pulses_added_to_axes_continue_colours_and_share_the_free_end():
    equal, taper = (
        hc.propagate(hc.Chain.tapered("forward-linear", q, beads=20)) for q in (0.001, 0.02)
    )
    axes = equal.plot(label="equal")
    taper.plot(label="taper", ax=axes)
    hc.bca(taper.chain).plot(label="theory", legend=False, ax=axes)
    assert legend_texts(axes) == ["equal", "taper", "last bead (free end)"]
    named = {line.get_label(): line for line in axes.lines if line.get_label()[0] != "_"}
    assert list(named) == ["equal", "taper", "theory", "last bead (free end)"]
    assert len({named[name].get_color() for name in ("equal", "taper", "theory")}) == 3
    assert len({named[name].get_marker() for name in ("equal", "taper", "theory")}) == 3


def test_lines_of_titles_end_neither_with_a_colon_nor_with_a_semicolon():
    text = "d2: contacts yield at 1.6 Y (Y: yield strength); row: elastic contacts"
    assert broken_title(text, 60) == text.replace("; ", "\n")
    assert broken_title(f"{text}\npeaks", 80) == f"{text}\npeaks"


@pytest.mark.long
def test_titles_of_one_chain_only_and_those_of_the_user():
    runs = [hc.simulate(hc.Chain.uniform(n).replace(right_wall=hc.Wall())) for n in (6, 8)]
    axes = runs[0].plot_forces(["wall"])
    runs[0].plot_forces([3], ax=axes)
    assert axes.get_title() == "6 equal beads"
    for run in (*runs, runs[0]):
        run.plot_forces(["wall"], label="other", ax=axes)
    assert axes.get_title() == ""
    axes.clear()
    axes.set_title("my title")
    for run in runs:
        run.plot_forces(["wall"], ax=axes)
    assert axes.get_title() == "my title"
    with hc.figure_style("single column"):
        runs[0].plot_forces(["wall"], ax=axes)
    assert axes.get_title() == "my title"


def test_settings_inside_a_style_are_those_of_the_user():
    pulse = hc.propagate(hc.Chain.uniform(9))
    with hc.figure_style("single column"), plt.rc_context({"font.size": 6, "figure.dpi": 50}):
        axes = pulse.plot()
        assert (axes.figure.dpi, axes.figure.get_figwidth()) == (50, pytest.approx(86 / 25.4))
        with hc.figure_style():
            assert plt.rcParams["font.size"] == 6
        with hc.figure_style("double column"):
            assert plt.rcParams["font.size"] == 8
            assert pulse.plot().figure.get_figwidth() == pytest.approx(178 / 25.4)
        assert plt.rcParams["font.size"] == 6
    # Each figure outside of a block has the style, and changes nothing for others.
    before = plt.rcParams["font.size"]
    assert pulse.plot().figure.get_figwidth() == pytest.approx(5.4)
    assert plt.rcParams["font.size"] == before


def test_plotted_forces_of_few_saved_times_are_announced():
    run = hc.simulate(hc.Chain.uniform(20), until=30.0, times=25)
    with pytest.warns(hc.IncompleteWarning, match="the largest force in bead 8 may have an error"):
        run.plot_forces([8])


def test_data_in_panels_of_one_figure_have_lines_of_one_width():
    traces, file = hc.example_experiment()
    found = hc.simulate(hc.load_chain(file), until=600e-6, times=1201).compare(traces)
    names = [each.name for each in found.sensors][:3]
    with hc.figure_style("double column"):
        _, panels = plt.subplots(2, 3, sharex="col")
        for i, name in enumerate(names):
            found.plot(name, ax=panels[:, i], legend=i == 0)
    widths = {panels[0, i].get_lines()[0].get_linewidth() for i in range(3)}
    assert len(widths) == 1


@pytest.mark.parametrize("beads", [2, 3])
def test_axes_of_few_beads_have_no_ticks_between_them(beads):
    axes = hc.propagate(hc.Chain.uniform(beads)).plot()
    low, high = axes.get_xlim()
    assert [tick for tick in axes.get_xticks() if low <= tick <= high] == [*range(1, beads + 1)]


def test_ticks_begin_at_bead_1_and_fit_into_small_panels():
    pulse = hc.propagate(hc.Chain.uniform(60))
    with hc.figure_style("double column"):
        figure, panels = plt.subplots(1, 4)
        for axes in panels:
            pulse.plot(ax=axes, legend=False)
        figure.canvas.draw()
    for axes in panels:
        low, high = axes.get_xlim()
        ticks = [tick for tick in axes.xaxis.get_major_ticks() if low <= tick.get_loc() <= high]
        assert len(ticks) >= 2
        assert min(tick.get_loc() for tick in ticks) >= 1.0
        boxes = [tick.label1.get_window_extent() for tick in ticks]
        assert all(a.x1 < b.x0 for a, b in itertools.pairwise(boxes))


@pytest.mark.long
@pytest.mark.parametrize("kind", ["pulses", "forces", "budget", "waves", "traces", "sweep"])
def test_legends_can_be_omitted(kind):
    run = hc.simulate(hc.Chain.uniform(20).replace(right_wall=hc.Wall()), until=50.0)
    dataset = hc.sweep({
        "axes": {"rate": [0.01, 0.02], "beads": [10, 12, 14]}, "sweep": {"keep": ["momentum"]},
        "chain": {"taper": "forward-exponential"},
    })  # fmt: skip
    plot = {
        "pulses": run.pulse().plot, "forces": lambda **o: run.plot_forces([3, 6], **o),
        "budget": run.budget().plot, "waves": run.waves().plot,
        "traces": hc.example_experiment()[0].plot,
        "sweep": lambda **o: hc.plot_sweep(dataset, bead=9, **o),
    }[kind]  # fmt: skip
    assert plot().get_legend() is not None
    axes = plot(legend=False)
    assert axes.get_legend() is None
    assert axes.get_legend_handles_labels()[1]
    with pytest.raises(hc.InputError, match="legend must be True or False"):
        plot(legend="best")


def test_traces_and_simulation_share_axes_and_their_unit_of_time():
    traces, chain = hc.example_experiment()
    run = hc.simulate(hc.load_chain(chain), until=3e-3, times=1201)
    axes = run.plot_forces(["wall"])
    assert axes.get_xlabel() == "time [ms]"
    traces.plot(ax=axes)
    measured = next(line for line in axes.lines if line.get_label() == "wall, measured")
    assert measured.get_xdata()[-1] == pytest.approx(1e3 * traces.shots[0].times[-1])
    assert measured.get_color() != axes.lines[0].get_color()
    assert axes.get_ylabel() == "force [N] or signal [V]"


def test_one_sensor_of_a_comparison_is_drawn_into_given_axes():
    traces, chain = hc.example_experiment()
    compared = hc.simulate(hc.load_chain(chain), until=600e-6, times=1201).compare(traces)
    _, (left, right) = plt.subplots(1, 2)
    assert compared.plot("ball 11", ax=right) is right
    assert not left.lines
    drawn = {line.get_label(): line.get_ydata() for line in right.lines}
    signal = traces.shots[0].signals[1]
    np.testing.assert_array_equal(drawn["data"], signal.values)
    # The simulation is drawn from the level of the data before the pulse.
    before = drawn["simulation"][0]
    model = before + compared.scales[1] * compared.signals[1]
    np.testing.assert_allclose(drawn["simulation"], model, rtol=1e-12)
    quiet = signal.values[compared.signals[1] < 1e-9 * compared.signals[1].max()]
    assert before == pytest.approx(quiet.mean(), abs=5.0 * quiet.std() / np.sqrt(len(quiet)))
    assert (right.get_ylabel(), right.get_title()) == ("signal [V]", "ball 11")
    with pytest.raises(hc.InputError, match="sensor"):
        compared.plot("ball 12")
    with pytest.raises(hc.InputError, match="ax takes one sensor"):
        compared.plot(ax=left)


def test_the_word_striker_is_above_the_beads_of_a_small_panel():
    chain = hc.Chain.uniform(20).struck_by(velocity=1.0)
    with hc.figure_style("double column"):
        figure, panels = plt.subplots(1, 3)
        plot_chain(chain, ax=panels[1])
        figure.draw_without_rendering()
    word = next(text for text in panels[1].texts if text.get_text() == "striker")
    top = panels[1].transData.transform((0.0, 1.0))[1]
    assert word.get_window_extent().y0 > top


def test_pdf_files_contain_truetype_fonts():
    axes = hc.propagate(hc.Chain.uniform(9)).plot()
    content = figure_bytes(axes.figure, "pdf")
    assert b"/Type0" in content
    assert b"/Type3" not in content


def test_curves_of_the_user_have_the_colours_of_the_style():
    with hc.figure_style():
        _, axes = plt.subplots()
        drawn = [to_hex(axes.plot([0, 1])[0].get_color()).upper() for _ in COLOURS]
    assert sorted(drawn) == sorted(COLOURS)
    # Blue is first and black last: a curve of a plot of hertzchain, which is black, stays distinct.
    assert (drawn[0], drawn[-1]) == (COLOURS[1], COLOURS[0])


def test_plots_draw_into_parts_of_a_figure():
    run = hc.simulate(hc.Chain.uniform(12).replace(right_wall=hc.Wall()), until=40.0)
    figure = plt.figure(figsize=(8.0, 6.0), layout="constrained")
    parts = figure.subfigures(2, 2).ravel()
    pulse = hc.propagate(hc.Chain.uniform(12))
    assert run.plot(ax=parts[0].subplots()).figure is parts[0]
    assert run.plot_forces([3, "wall"], ax=parts[1].subplots()).figure is parts[1]
    pair = parts[2].subplots(2, sharex=True)
    assert hc.plot_pulses([pulse, hc.bca(pulse.chain)], residuals=True, ax=pair) is pair[0]
    assert run.budget().plot(ax=parts[3].subplots()).figure is parts[3]
    figure.draw_without_rendering()
    assert len(parts[0].axes) == 2  # the map and its colour bar


def test_one_sensor_of_a_fit_is_drawn_with_its_residuals():
    result = hc.fit(*hc.example_experiment())
    figure, panels = plt.subplots(2, 2)
    assert result.plot("wall", ax=panels[:, 1]) is panels[0, 1]
    drawn = {line.get_label(): line.get_ydata() for line in panels[0, 1].lines}
    signal = result.traces.shots[0].signals[3]
    np.testing.assert_array_equal(drawn["data"], signal.values)
    np.testing.assert_array_equal(drawn["fit"], result.predicted[0][3])
    np.testing.assert_array_equal(panels[1, 1].lines[1].get_ydata(), result.residuals()[3][2])
    ends = result.traces.shots[0].times[[0, -1]] * 1e6
    for axes in panels[:, 1]:
        np.testing.assert_allclose(axes.get_xlim(), ends)
    # One axes have no residuals.
    assert result.plot("ball 6", ax=panels[0, 0]) is panels[0, 0]
    assert panels[0, 0].get_xlabel() == "time [µs]"
    assert not panels[1, 0].lines
    assert len(result.plot("ball 11").figure.axes) == 2
    for options, message in (
        ({"sensor": "ball 7"}, "sensor"), ({"sensor": "wall", "shot": 2}, "shot"),
        ({"ax": panels[0, 0]}, "ax takes one sensor"), ({"sensor": "wall", "ax": [figure]}, "pair"),
    ):  # fmt: skip
        with pytest.raises(hc.InputError, match=message):
            result.plot(**options)


def test_errors_of_a_comparison_are_drawn_in_percent():
    chain = hc.Chain.tapered("backward-exponential", 0.05, beads=30)
    exact, theory = hc.propagate(chain), hc.bca(chain)
    axes = theory.compare(exact).plot()
    shown = {line.get_label(): line.get_ydata() for line in axes.lines[:4]}
    assert list(shown) == ["velocity", "arrival", "residence", "peak force"]
    expected = 100 * (theory.velocity / exact.velocity - 1)[1:-1]
    np.testing.assert_allclose(shown["velocity"], expected, rtol=1e-12)
    assert axes.get_xlabel() == "bead or contact $k$"
    sizes = theory.compare(exact).plot("peak_force", log=True, legend=False)
    assert (sizes.lines[0].get_ydata() > 0).all()
    assert (sizes.get_xlabel(), sizes.get_yscale()) == ("contact $k$", "log")
    assert sizes.get_legend() is None
    with pytest.raises(hc.InputError, match="unknown quantity 'width'"):
        theory.compare(exact).plot("width")


def walled_run():
    return hc.simulate(hc.Chain.uniform(12).replace(right_wall=hc.Wall()), until=40.0, times=200)


def plots_with_black_lines():
    """Plots whose first curve, zero line or marks are black or grey on white."""
    traces, chain = hc.example_experiment()
    pulse = hc.propagate(hc.Chain.tapered("backward-exponential", 0.05, beads=20))
    run = walled_run()
    sweep = hc.sweep({
        "axes": {"rate": [0.01, 0.02], "beads": [10, 12, 14]}, "sweep": {"keep": ["momentum"]},
        "chain": {"taper": "forward-exponential"},
    })  # fmt: skip
    scatter = hc.Scatter(radius=0.01, samples=20)
    spread = hc.distribution(hc.Chain.uniform(6), "velocity@last", scatter)
    compared = hc.simulate(hc.load_chain(chain), until=600e-6, times=1201).compare(traces)
    return {
        "pulses": lambda: hc.plot_pulses([pulse, hc.bca(pulse.chain)], residuals=True),
        "comparison": hc.bca(pulse.chain).compare(pulse).plot,
        "forces": lambda: run.plot_forces([3, "wall"]),
        "budget": run.budget().plot,
        "traces": traces.plot,
        "trace comparison": lambda: compared.plot("ball 11"),
        "sweep": lambda: hc.plot_sweep(sweep, bead=9),
        "distribution": spread.plot,
    }


def contrast(one, other):
    """Ratio of relative luminances, as in the Web Content Accessibility Guidelines."""

    def luminance(colour):
        rgb = np.array(to_rgb(colour))
        linear = np.where(rgb <= 0.03928, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
        return linear @ (0.2126, 0.7152, 0.0722) + 0.05

    low, high = sorted((luminance(one), luminance(other)))
    return high / low


@pytest.mark.long
@pytest.mark.parametrize("style", ["default", "dark_background"])
def test_lines_are_visible_on_the_background_of_the_style(style):
    with plt.style.context(style):
        for name, plot in plots_with_black_lines().items():
            figure = plot().figure
            seen = [line.get_color() for axes in figure.axes for line in axes.lines]
            behind = figure.axes[0].get_facecolor()
            assert seen, name
            assert min(contrast(colour, behind) for colour in seen) > 2.0, name
            legends = [axes.get_legend() for axes in figure.axes if axes.get_legend() is not None]
            for text in (text for legend in legends for text in legend.get_texts()):
                assert contrast(text.get_color(), behind) > 4.5, name
            plt.close(figure)


@pytest.mark.long
def test_a_first_curve_is_black_on_white_and_white_on_black():
    pulse = hc.propagate(hc.Chain.uniform(9))
    assert to_hex(pulse.plot().lines[0].get_color()) == "#000000"
    # The colour of given axes decides, or that of the figure behind transparent ones.
    _, (left, right) = plt.subplots(1, 2, facecolor="#202020")
    left.set_facecolor("white")
    right.set_facecolor("none")
    assert to_hex(pulse.plot(ax=left).lines[0].get_color()) == "#000000"
    assert to_hex(pulse.plot(ax=right).lines[0].get_color()) == "#ffffff"
    # Of a transparent figure, that of the text.
    clear = {"figure.facecolor": "none", "axes.facecolor": "none", "text.color": "white"}
    with plt.rc_context(clear):
        assert to_hex(pulse.plot().lines[0].get_color()) == "#ffffff"
        with hc.figure_style():
            cycle = plt.rcParams["axes.prop_cycle"].by_key()["color"]
    assert cycle == [*COLOURS[1:], "#FFFFFF"]


@pytest.mark.parametrize(("values", "expected"), [
    ([0.0, 2.0, -0.019], ("Reds", 0.0, 2.0)),
    ([0.0, 2.0, -0.021], ("RdBu_r", -2.0, 2.0)),
    ([-3.0, 0.029], ("Blues_r", -3.0, 0.0)),
    ([-3.0, 1.0, np.nan], ("RdBu_r", -3.0, 3.0)),
    ([np.nan], ("Reds", 0.0, 0.0)),
])  # fmt: skip
def test_maps_of_one_sign_use_one_colour(values, expected):
    assert signed_map(np.array(values)) == expected


def test_velocity_maps_diverge_only_if_beads_move_in_both_directions():
    mesh = walled_run().plot().collections[0]
    assert (mesh.cmap.name, mesh.norm.vmin) == ("RdBu_r", -mesh.norm.vmax)
    free = hc.simulate(hc.Chain.tapered("forward-exponential", 0.05, beads=12), until=20.0)
    assert free.velocities.min() > -0.01 * free.velocities.max()
    mesh = free.plot().collections[0]
    assert (mesh.cmap.name, mesh.norm.vmin) == ("Reds", 0.0)
    # Contact forces never pull.
    assert walled_run().plot("force").collections[0].norm.vmin == 0.0


def test_maps_of_sweeps_diverge_only_if_both_signs_occur():
    axes = {"rate": {"linspace": [0.01, 0.1, 8]}, "beads": [*range(10, 18)]}
    found = hc.sweep({
        "axes": axes, "sweep": {"at": "last"}, "chain": {"taper": "forward-exponential"},
    })  # fmt: skip
    mesh = hc.plot_sweep(found).collections[0]
    assert (mesh.cmap.name, mesh.norm.vmin) == ("viridis", pytest.approx(found.velocity.min()))
    mesh = hc.plot_sweep(found.assign(velocity=-found.velocity)).collections[0]
    assert mesh.cmap.name == "viridis"
    mesh = hc.plot_sweep(found.assign(velocity=found.velocity - 2.0)).collections[0]
    assert (mesh.cmap.name, mesh.norm.vmin) == ("RdBu_r", -mesh.norm.vmax)


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::hertzchain.errors.IncompleteWarning")
def test_the_legend_of_a_large_map_explains_legible_markers():
    axes = {"rate": {"linspace": [0.01, 0.1, 50]}, "beads": [*range(5, 55)]}
    found = hc.sweep({
        "axes": axes, "sweep": {"methods": ["bca"], "at": "last"},
        "chain": {"taper": "forward-exponential"},
    })  # fmt: skip
    status = found.status.copy(deep=True)
    status[10:30, 10:30] = FAILED
    drawn = hc.plot_sweep(
        found.assign(status=status, velocity=found.velocity.where(status != FAILED))
    )
    (text,) = drawn.get_legend().get_texts()
    assert text.get_text() == "failed"
    (handle,) = drawn.get_legend().legend_handles
    marked = max(drawn.collections, key=lambda each: len(each.get_offsets()))
    assert len(marked.get_offsets()) == 400
    assert marked.get_sizes()[0] < 5.0
    assert handle.get_sizes()[0] >= 20.0
    assert handle.get_paths()[0].vertices.tolist() == marked.get_paths()[0].vertices.tolist()


def test_sensitivities_name_the_chain_and_mark_its_strikers():
    balls = hc.Chain.from_materials(5e-3, "steel-52100", beads=6, velocity=0.0)
    chain = balls.replace(right_wall=hc.Wall()).struck_by(velocity=0.01, count=2)
    for name, first in (("radii", "2 strikers"), ("stiffness", None)):
        axes = hc.gradient(chain, "wall_force.peak", to=[name]).plot(name)
        title = axes.get_title().replace("\n", " ")
        assert title == "6 steel balls and 2 strikers, 10 mm"
        assert axes.get_ylabel().startswith("peak force on the wall:\nchange [%] per 1% of ")
        labels = axes.get_legend_handles_labels()[1]
        assert labels[:1] == ([first] if first else [])
        if first:
            low, high = (
                axes.patches[0].get_extents().transformed(axes.transData.inverted()).intervalx
            )
            assert (low, high) == pytest.approx((0.5, 2.5))
        plt.close(axes.figure)


@pytest.mark.parametrize(("chain", "words"), [
    (hc.Chain.from_materials(5e-3, "steel-52100", beads=6, precompression="0.2 N",
                             held_by="force"), "6 steel balls, 10 mm, under 0.2 N"),
    (hc.Chain.uniform(6).replace(gravity=0.1, precompression=1.0, held_by="force"),
     "6 equal beads, under gravity, under 1"),
])  # fmt: skip
def test_titles_of_spectra_state_the_static_force(chain, words):
    found = hc.spectrum(chain)
    axes = found.plot("modes"), found.plot_transfer(3)
    assert [each.get_title().replace("\n", " ") for each in axes] == [
        words, f"{words}, force on bead 1"
    ]  # fmt: skip
    for each in axes:
        plt.close(each.figure)


@pytest.mark.parametrize("size", [1.0, 25.649, 450.3443])
def test_a_narrow_distribution_has_whole_values_at_its_ticks(size):
    values = size * (1.0 + 1e-6 * np.linspace(-1.0, 1.0, 50))
    chain = hc.Chain.uniform(5)
    scatter = hc.Scatter(radius=0.01)
    found = Distribution(chain, scatter, "velocity@last", size, values)
    axes = found.plot()
    axes.figure.canvas.draw()
    labels = axes.get_xticklabels()
    assert axes.xaxis.get_offset_text().get_text() == ""
    shown = [float(label.get_text()) for label in labels]
    np.testing.assert_allclose(shown, axes.get_xticks(), rtol=1e-8)
    boxes = [label.get_window_extent() for label in labels]
    assert len(boxes) >= 3
    assert all(left.x1 < right.x0 for left, right in itertools.pairwise(boxes))
    plt.close(axes.figure)


def test_times_of_a_distribution_are_in_microseconds():
    chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=4, velocity=0.01)
    values = 450e-6 * (1.0 + 1e-3 * np.linspace(-1.0, 1.0, 50))
    found = Distribution(chain, hc.Scatter(radius=0.01), "arrival@last", 450e-6, values)
    axes = found.plot()
    assert axes.get_xlabel() == "arrival of the last bead [µs]"
    assert axes.get_xlim()[0] == pytest.approx(449.5, abs=0.1)
    plt.close(axes.figure)


def _separate_ends(axes):
    """Last beads drawn as symbols without a line, by their number."""
    return {
        int(line.get_xdata()[0]): float(line.get_ydata()[0]) for line in axes.lines
        if line.get_linestyle() == "None" and len(line.get_xdata()) == 1
    }  # fmt: skip


def test_table_of_pulses_separates_free_ends():
    chains = [
        hc.Chain.uniform(beads).with_scatter(seed, relative=0.02)
        for beads in (12, 15) for seed in range(5)
    ]  # fmt: skip
    table = hc.propagate_many(chains)
    axes = table.plot()
    expected = {count: float(np.median(table.velocity[i, count - 1]))
                for count, i in ((12, slice(5)), (15, slice(5, 10)))}  # fmt: skip
    assert _separate_ends(axes) == pytest.approx(expected)
    curve = axes.lines[0]
    assert curve.get_xdata()[-1] == 14
    assert max(curve.get_ydata()[1:]) < 0.9 < min(expected.values())
    assert "last bead (free end)" in axes.get_legend_handles_labels()[1]
    colours = {line.get_color() for line in table.plot(ax=axes).lines if len(line.get_xdata()) > 1}
    assert len(colours) == 2
    assert not _separate_ends(table.plot("arrival"))


def test_sweeps_separate_free_ends():
    def drawn(*beads, keep="velocity", **options):
        found = hc.sweep({
            "chain": {"taper": "forward-exponential", "rate": 0.02},
            "axes": {"beads": [*beads]}, "sweep": {"keep": [keep], **options},
        })  # fmt: skip
        return found, hc.plot_sweep(found)

    found, axes = drawn(12, 15)
    velocity = found.velocity.sel(approach="propagate")
    assert _separate_ends(axes) == pytest.approx(
        {count: float(velocity.sel(beads=count, bead=count)) for count in (12, 15)}
    )
    assert [line.get_xdata()[-1] for line in axes.lines if len(line.get_xdata()) > 1] == [11, 14]
    assert "last bead (free end)" in axes.get_legend_handles_labels()[1]
    assert not _separate_ends(drawn(12, 15, keep="arrival")[1])
    # Beads that are not neighbours have no curve from which the last one deviates.
    assert not _separate_ends(drawn(12, 15, at=[1, 6, 12])[1])


def test_residuals_over_the_noise_are_below_each_compared_signal():
    traces, chain = hc.example_experiment()
    compared = hc.simulate(hc.load_chain(chain), until=6e-4, times=1201).compare(traces)
    figure = compared.plot()
    for i, (upper, lower) in enumerate(np.reshape(figure.axes, (-1, 2))):
        signal, found = traces.shots[0].signals[i], compared.sensors[i]
        assert lower.get_position().y1 < upper.get_position().y0
        residual = lower.lines[1].get_ydata() * signal.sigma / found.measured_peak
        rms = np.sqrt(np.nanmean(residual**2))
        assert rms == pytest.approx(found.residual, rel=1e-6)
        assert lower.get_ylim()[1] > np.nanmax(np.abs(lower.lines[1].get_ydata()))
        # A band of twice the noise would be as thin as a line.
        assert lower.get_ylim()[1] > 20.0
        assert not lower.patches
    (words,) = ([text.get_text() for text in each.get_texts()] for each in figure.legends)
    assert words == ["data", "simulation"]
    assert len(compared.plot("wall").figure.axes) == 2


@pytest.mark.parametrize(("samples", "crowded"), [(60, False), (700, True), (20_000, True)])
def test_crowded_samples_are_a_line_and_few_have_symbols(samples, crowded):
    times = np.linspace(0.0, 1e-3, samples)
    data = np.exp(-(((times - 5e-4) / 1e-4) ** 2))
    data[samples // 4] = data[samples // 4 + 2] = np.nan
    signal = hc.Traces.from_arrays(times, {"wall [N]": data}, noise=0.1).shots[0].signals[0]
    axes = plt.figure().subplots()
    draw_signal(axes, times, signal, np.zeros(samples), "fit")
    drawn = axes.lines[0]
    assert (drawn.get_marker() == "None") == crowded
    assert (drawn.get_linestyle() == "-") == crowded
    # A sample between missing ones is not lost.
    alone = [line for line in axes.lines if len(line.get_xdata()) == 1]
    assert [line.get_marker() for line in alone] == ["o"] * crowded


def test_curves_of_two_runs_are_solid_and_differ_in_width_and_opacity_those_of_more_do_not():
    balls = hc.Chain.uniform(8).replace(right_wall=hc.Wall())
    runs = [hc.simulate(balls.replace(loss=loss), until=40.0)
            for loss in (None, hc.Restitution(0.9), hc.Restitution(0.8))]  # fmt: skip
    axes = runs[0].plot_forces([4, "wall"], label="0")
    assert len({line.get_linewidth() for line in axes.lines}) == 2
    for i, run in enumerate(runs[1:], 1):
        run.plot_forces([4, "wall"], label=f"{i}", ax=axes)
        looks = [(line.get_linewidth(), line.get_alpha()) for line in axes.lines]
        assert {line.get_linestyle() for line in axes.lines} == {"-"}
        assert looks[::2] == looks[1::2]
        if i == 1:
            assert looks[0][0] > 2.0 * looks[2][0]
    assert {alpha for _, alpha in looks} == {1.0}
    assert len(set(looks)) == 1
    assert len({line.get_color() for line in axes.lines}) == 6


@pytest.mark.parametrize(("beads", "widths"), [(8, 2), (40, 1)])
def test_only_curves_of_two_runs_that_overlap_differ_in_width(beads, widths):
    axes = None
    for count in (8, beads):
        chain = hc.Chain.uniform(count).replace(right_wall=hc.Wall())
        axes = hc.simulate(chain, until=80.0).plot_forces(["wall"], label=f"{count}", ax=axes)
    assert len({line.get_linewidth() for line in axes.lines}) == widths


def test_runs_with_many_oscillations_have_lines_of_one_width():
    balls = hc.Chain.from_materials(np.linspace(6e-3, 3e-3, 15), "steel-52100", velocity=0.05)
    balls = balls.replace(right_wall=hc.Wall("5 kN/mm", exponent=1, loss=hc.Elastic()))
    many = balls[:].replace(velocities=np.zeros(15)).struck_by(mass="100 g", velocity="0.05 m/s")
    few = balls.replace(loss=hc.Restitution(0.6))
    for chains, widths in (((few, few), 2), ((few, many), 1)):
        runs = {f"{i}": hc.simulate(chain, times=4000) for i, chain in enumerate(chains)}
        axes = plot_forces_of_runs(runs, {name: ["wall"] for name in runs})
        assert len({line.get_linewidth() for line in axes.lines}) == widths
        peaks = [run.wall_force().peak for run in runs.values()]
        shown = [f"{i}: {peak:.3g} N" for i, peak in enumerate(peaks)]
        assert [each.partition(" (run ends")[0] for each in legend_texts(axes)] == shown


def test_runs_have_the_same_style_in_all_panels():
    balls = hc.Chain.uniform(8).replace(right_wall=hc.Wall())
    chains = {"strong": balls, "weak": balls.replace(velocities=0.05 * balls.velocities)}
    runs = {name: hc.simulate(chain, until=60.0) for name, chain in chains.items()}
    first, weak = plot_forces_of_runs(runs, {name: [4, 9] for name in runs}).figure.axes

    def looks(axes):
        names = ("color", "linestyle", "linewidth", "alpha")
        return {tuple(plt.getp(line, name) for name in names) for line in axes.lines}

    assert len(looks(first)) == 4
    assert len(looks(weak)) == 2
    assert looks(weak) < looks(first)


def test_several_places_of_several_runs_have_a_panel_each():
    balls = hc.Chain.uniform(8).replace(right_wall=hc.Wall())
    runs = {name: hc.simulate(balls.replace(loss=loss), until=40.0)
            for name, loss in (("elastic", None), ("lossy", hc.Restitution(0.9)))}  # fmt: skip
    first = plot_forces_of_runs(runs, {name: [4, 9] for name in runs})
    panels = first.figure.axes
    assert [axes.get_title(loc="left") for axes in panels] == ["bead 4", "right wall"]
    assert legend_texts(first) == [*runs]
    for axes, bead in zip(panels, (4, 9), strict=True):
        for line, run in zip(axes.lines, runs.values(), strict=True):
            assert line.get_ydata().max() == force_curve(run, bead)[1].max()


@pytest.mark.filterwarnings("ignore::hertzchain.IncompleteWarning")
def test_a_panel_of_several_runs_states_that_a_peak_is_not_complete():
    balls = hc.Chain.uniform(8).replace(right_wall=hc.Wall())
    runs = {name: hc.simulate(balls.replace(loss=loss), until=9.0)
            for name, loss in (("elastic", None), ("lossy", hc.Restitution(0.9)))}  # fmt: skip
    assert not any(run.wall_force().complete for run in runs.values())
    first = plot_forces_of_runs(runs, {name: [4, 9] for name in runs})
    assert legend_texts(first) == [*runs]
    wall = first.figure.axes[1]
    assert legend_texts(wall) == [f"{name} (a larger force may follow)" for name in runs]


@pytest.mark.parametrize(
    ("magnify", "words"),
    [(0.162, "drawn at 0.16 of their size"), (1.0, "to scale"), (30.0, "magnified 30 times")],
)
def test_animations_say_how_large_the_motion_is_drawn(magnify, words, run, tmp_path, monkeypatch):
    _, texts, _ = animated(run, tmp_path, monkeypatch, frames=2, magnify=magnify)
    assert texts[0].startswith(f"displacements {words}; velocity up to ")


@pytest.mark.parametrize("beads", [5, 20, 60])
def test_figures_of_chains_are_filled_by_the_beads(beads):
    for width in (None, "single column", "double column"):
        with hc.figure_style(width):
            axes = plot_chain(hc.Chain.uniform(beads).struck_by().replace(right_wall=hc.Wall()))
            axes.figure.draw_without_rendering()
        whole = axes.figure.bbox.height
        assert whole - axes.get_tightbbox().height < 0.35 * axes.figure.dpi


def test_medians_of_a_narrow_corner_plot_are_listed_above_it():
    rng = np.random.default_rng(0)
    samples = 50.0 + rng.normal(size=(500, 4))
    names = ("stiffness", "loss.time", "struck_by.velocity", "time_offset")
    posterior = hc.Posterior(names, samples, 0.5, 1.0, 100, np.full(4, 50.0), ("",) * 4)
    with hc.figure_style("single column"):
        figure = posterior.plot()
        figure.draw_without_rendering()
    assert not any(axes.get_title() for axes in figure.axes)
    (legend,) = figure.legends
    texts = [text.get_text() for text in legend.get_texts()]
    words = ["stiffness factor", "relaxation time", "striker velocity", "time offset"]
    assert [text.partition(":")[0] for text in texts[2:]] == words
    top = max(axes.bbox.y1 for axes in figure.axes)
    assert legend.get_window_extent().y0 > top
    # All labels are inside the figure.
    boxes = [axes.get_tightbbox() for axes in figure.axes]
    assert all(figure.bbox.x0 <= box.x0 and box.x1 <= figure.bbox.x1 for box in boxes)


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
def test_the_legend_of_a_map_in_a_column_leaves_it_its_size():
    found = hc.sweep({
        "chain": {"first_diameter": "10 mm", "materials": "steel-52100", "beads": 6},
        "axes": {"velocity": {"linspace": [0.1, 1.3, 9], "unit": "m/s"},
                 "ratio": {"linspace": [0.4, 1.0, 9]}},
        "sweep": {"methods": ["simulate"], "keep": ["velocity"], "at": "last"},
    })  # fmt: skip
    with hc.figure_style("single column"):
        axes = hc.plot_sweep(found)
        axes.figure.draw_without_rendering()
    whole = axes.figure.bbox
    assert axes.bbox.width > 0.55 * whole.width
    box = axes.get_legend().get_window_extent()
    assert whole.x0 <= box.x0 < box.x1 <= whole.x1
    assert whole.y0 <= box.y0 < box.y1 <= axes.xaxis.label.get_window_extent().y0


@pytest.mark.parametrize(("largest", "shown"), [(15.0, True), (30.0, False)])
def test_the_band_of_the_noise_is_explained_only_where_it_is_visible(largest, shown):
    from hertzchain.plotting.signals import draw_residuals

    _, axes = plt.subplots()
    draw_residuals(axes, np.arange(3.0), np.array([0.0, 1.0, largest]))
    assert axes.get_legend_handles_labels()[1] == ["±2σ of the noise"] * shown
    assert len(axes.patches) == shown


@pytest.mark.parametrize("width", ["single column", "60 mm", None])
def test_legends_above_panels_are_inside_the_figure(width):
    from hertzchain.plotting.legends import legend_above

    with hc.figure_style(width):
        figure, axes = plt.subplots(layout="constrained")
        for name in ("CH1 (ball 10)", "CH2 (ball 18)", "wall", "±2σ of white noise", "normal law"):
            axes.plot([0.0, 1.0], label=name)
        legend_above(figure, axes)
        figure.draw_without_rendering()
    (legend,) = figure.legends
    box = legend.get_window_extent()
    assert figure.bbox.x0 <= box.x0 < box.x1 <= figure.bbox.x1
    assert box.y0 >= axes.bbox.y1


@pytest.mark.parametrize("width", [None, "single column"])
def test_legends_of_spectra_are_not_on_ranges_that_they_explain(width):
    cells = hc.Chain.periodic(
        ["4.7625 mm", "4.7625 mm"], cells=20, materials=["steel-52100", "brass"]
    )
    found = hc.spectrum(cells.replace(precompression=0.5, held_by="force"))
    with hc.figure_style(width):
        drawn = [found.plot(), found.plot_transfer(15)]
        _, panels = plt.subplots(1, 2, figsize=(8.2, 3.5))
        drawn += [found.plot(ax=panels[0]), found.plot_transfer(15, ax=panels[1])]
    for axes in drawn:
        axes.figure.draw_without_rendering()
        box = axes.get_legend().get_window_extent()
        ranges = [each for each in axes.patches if each.get_window_extent().width > 0.0]
        assert len(ranges) >= 2
        assert not any(box.overlaps(each.get_window_extent()) for each in ranges)


@pytest.mark.filterwarnings("ignore::hertzchain.IncompleteWarning")
def test_labels_of_a_user_have_no_remarks():
    chain = hc.Chain.uniform(9).replace(right_wall=hc.Wall())
    short, long = (hc.simulate(chain, until=end, times=200) for end in (10.0, 60.0))
    axes = short.plot_forces(["wall"], label="A")
    long.plot_forces(["wall"], label="B", ax=axes)
    assert [line.get_label() for line in axes.lines[:2]] == ["A", "B"]
    # The circle at the end of the first is explained by an entry of its own.
    assert legend_texts(axes) == ["A", "B", "a larger force may follow"]
    long.plot_forces([4, "wall"], label="C", ax=axes)
    assert legend_texts(axes)[-2:] == ["C, right wall", "a larger force may follow"]
    assert legend_texts(axes).count("a larger force may follow") == 1


@pytest.mark.filterwarnings("ignore::hertzchain.IncompleteWarning")
@pytest.mark.parametrize("width", [None, "single column"])
def test_figures_of_journals_have_no_remarks_on_forces(width):
    chain = hc.Chain.uniform(9).replace(right_wall=hc.Wall())
    short, long = (hc.simulate(chain, until=end, times=200) for end in (10.0, 60.0))
    with hc.figure_style(width):
        axes = long.plot_forces([4], ax=short.plot_forces(["wall"]))
    remarks = " (a larger force may follow, run ends at $t$ = 10)" if width is None else ""
    assert legend_texts(axes) == [f"right wall{remarks}", "bead 4"]
    assert axes.lines[0].get_marker() == ("o" if width is None else "None")


def test_measured_and_simulated_curves_are_distinguished():
    balls = hc.Chain.from_materials("5 mm", "steel-52100", beads=9).struck_by(velocity=0.1)
    run = hc.simulate(balls, until="200 us", times=201)
    traces = hc.Traces.from_arrays(run.times, {"ball 4 [N]": run.sensor("ball 4")})
    axes = run.plot_forces(["ball 4"])
    assert legend_texts(axes) == ["bead 5 (ball 4)"]
    both = ["bead 5 (ball 4), simulated", "ball 4, measured"]
    assert legend_texts(traces.plot(ax=axes)) == both
    assert legend_texts(run.plot_forces(["ball 4"], ax=traces.plot())) == both[::-1]
    named = traces.plot(ax=run.plot_forces(["ball 4"], label="model"))
    assert legend_texts(named) == ["model", "ball 4, measured"]


def test_runs_of_almost_the_same_length_end_together():
    chain = hc.Chain.uniform(9)
    # A static force acts until the end.
    pressed = chain.replace(precompression=0.1, held_by="force")
    runs = [hc.simulate(pressed, until=end, times=200) for end in (28.0, 30.0)]
    first = plot_forces_of_runs(dict(zip("ab", runs, strict=True)), {"a": [4], "b": [4]})
    assert first.get_xlim() == (0.0, 28.0)
    # A largest force beyond this time, and a limit of the user, remain.
    later = hc.simulate(chain.replace(right_wall=hc.Wall()), until=10.0, times=200)
    longer = hc.simulate(chain.replace(right_wall=hc.Wall()), until=10.9, times=200)
    assert longer.plot_forces([9], ax=later.plot_forces([9])).get_xlim()[1] == pytest.approx(10.9)
    axes = runs[0].plot_forces([4])
    axes.set_xlim(0.0, 50.0)
    assert runs[1].plot_forces([4], ax=axes).get_xlim() == (0.0, 50.0)


@pytest.mark.parametrize(("change", "words"), [
    (0.1, "(dashed: with yield, 1.6 Y)"), (0.001, "(with yield: the same curve)"),
])  # fmt: skip
def test_legends_of_designs_mention_dashes_only_if_they_are_visible(change, words, monkeypatch):
    from hertzchain.designs.curves import Curve
    from hertzchain.plotting import designs

    balls = hc.Chain.from_materials("5 mm", "steel-52100", beads=4, velocity=0.1)
    sizes = hc.vary.balls(materials=["steel-52100"], diameters=["5 mm", "10 mm"])
    found = hc.design(hc.Design(balls, maximise="momentum@last", vary=[sizes]), budget=20, seed=1)
    beads = np.arange(1.0, 5.0)
    dented = (1.0 - change) * beads
    curves = [
        Curve("design", False, beads, beads, 4.0), Curve("design", True, beads, dented, dented[-1])
    ]  # fmt: skip
    monkeypatch.setattr(designs, "compared_curves", lambda *_: curves)
    assert legend_texts(designs.plot_forces(found)) == [f"design = best geometric taper\n{words}"]


def test_the_label_of_peak_forces_excludes_damping_only_where_a_law_has_it():
    chain = hc.Chain.uniform(5)
    usual, without = "largest force $F_k$", "largest force without damping $F_k$"
    # That of a wall acts on no bead of the row.
    wall = chain.replace(right_wall=hc.Wall(loss=hc.Restitution(0.9)))
    for each, label in (
        (chain, usual), (chain.replace(loss=hc.UnloadingRatio(0.9)), usual), (wall, usual),
        (chain.replace(loss=hc.Restitution(0.9)), without),
        (chain.replace(loss=[None, hc.Viscoelastic(0.01), None, None]), without),
    ):  # fmt: skip
        pulse = hc.simulate(each, until=8.0).pulse()
        assert pulse.plot("peak_force").get_ylabel() == label


def test_animations_of_compressed_rows_show_changes_of_forces(tmp_path, monkeypatch):
    row = hc.Chain.from_materials(
        5e-3, "steel-52100", beads=8, velocity=0.01, precompression=20.0, held_by="walls",
        left_wall=hc.Wall(), right_wall=hc.Wall(),
    )  # fmt: skip
    run = hc.simulate(row, until=200e-6, times=300)
    seen = []
    close = plt.close
    monkeypatch.setattr(plt, "close", lambda figure: (seen.append(figure), close(figure)))
    hc.animate(run, tmp_path / "a.gif", frames=2, sensors=["ball 4"])
    below = seen[0].axes[1]
    assert below.get_ylabel() == "change of force on wall\nand in sensors [N]"
    wall, sensor, _ = below.lines
    assert wall.get_ydata()[0] == pytest.approx(0.0, abs=1e-6)
    assert np.max(sensor.get_ydata()) == pytest.approx(run.sensor(4).max() - 20.0, rel=1e-6)


@pytest.mark.filterwarnings("ignore::hertzchain.errors.IncompleteWarning")
def test_many_missing_points_of_a_map_are_filled():
    """Small marks beside each other would be black lines."""
    axes = {"rate": {"linspace": [0.01, 0.1, 20]}, "beads": [*range(5, 25)]}
    found = hc.sweep({
        "axes": axes, "sweep": {"methods": ["bca"], "at": "last"},
        "chain": {"taper": "forward-exponential"},
    })  # fmt: skip
    status = found.status.copy(deep=True)
    status[5:15, 10:18] = MISSING
    part = found.assign(status=status, velocity=found.velocity.where(status != MISSING))
    drawn = hc.plot_sweep(part)
    (text,) = drawn.get_legend().get_texts()
    assert text.get_text() == "missing, not computed yet"
    (handle,) = drawn.get_legend().legend_handles
    filled = drawn.collections[-1]
    assert not any(len(each.get_offsets()) > 1 for each in drawn.collections[:-1])
    assert (~np.ma.getmaskarray(filled.get_array())).sum() == 80
    assert filled.cmap(0.0) == handle.get_facecolor()
