"""The page of `hertzchain app` in a real browser; skipped where no Chromium is installed."""

import base64
import json
import os
import re
import shutil
import tomllib
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
from app_client import TAPER, WALL, serving

import hertzchain as hc
from hertzchain.app.about import about, gallery
from hertzchain.app.documents import chain_of, document_as_toml, document_of_chain
from hertzchain.app.explore import Conversation
from hertzchain.app.page_file import first_view, write_page
from hertzchain.app.saved_page import embedded_page
from hertzchain.app.serve import RunningServer
from hertzchain.validation.json_types import finite

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
BROWSER = os.environ.get("HERTZCHAIN_CHROMIUM") or next(
    filter(None, map(shutil.which, NAMES)), None
)
AXE = Path(__file__).parents[1] / "tools/page/node_modules/axe-core/axe.min.js"
# Set where the page must be tested: a missing browser is then a failure.
REQUIRED = os.environ.get("HERTZCHAIN_REQUIRE_BROWSER")

if BROWSER is None and not REQUIRED:
    pytest.skip("page not tested: no Chromium is installed", allow_module_level=True)
if not REQUIRED:
    pytest.importorskip("playwright", reason="page not tested: Playwright is not installed")

from playwright.sync_api import sync_playwright  # noqa: E402

OPEN_ALL = "for (const each of document.querySelectorAll('details')) each.open = true"
# Milliseconds to wait for results: the first ones of a chain with new features are compiled.
COMPILING = 180_000
SETTLED = "body[data-settled=yes]"
# The page is drawn at most once per frame.
NEXT_FRAME = """() => new Promise(
    (done) => requestAnimationFrame(() => requestAnimationFrame(() => done(null)))
)"""
EXAMPLES = {each["title"]: each for each in gallery()}
MATERIAL = "[id='c-chain.materials']"
ARRAY = """([slot, part, name]) => Array.from(hertzchain.results[slot][part].arrays.get(name))"""


@pytest.fixture(scope="module")
def running():
    with serving(TAPER) as found:
        yield found


@pytest.fixture(scope="module")
def browser():
    with sync_playwright() as playwright:
        # Chromium has no sandbox for root, as in containers.
        options = [] if getattr(os, "geteuid", lambda: 1)() else ["--no-sandbox"]
        found = playwright.chromium.launch(executable_path=BROWSER, args=options)
        yield found
        found.close()


class Page:
    """A tab, which must not write to the console or load anything from elsewhere."""

    def __init__(self, browser, running, **options):
        settings = {"viewport": {"width": 1280, "height": 900}, "reduced_motion": "reduce"}
        self.context = browser.new_context(**(settings | options))
        self.running, self.origin = running, f"http://127.0.0.1:{running.port}/"
        self.problems = []
        self.tab = self.new_tab()

    def new_tab(self, address=None):
        tab = self.context.new_page()
        tab.set_default_timeout(20_000)
        tab.on("console", lambda each: self.problems.append(each.text))
        tab.on("pageerror", lambda each: self.problems.append(str(each)))
        tab.on("request", lambda each: self.check_request(each.url))
        tab.goto(self.running.address if address is None else address)
        tab.wait_for_selector(SETTLED, timeout=COMPILING)
        return tab

    def check_request(self, url):
        if not url.startswith((self.origin, "data:", "blob:", "file:")):
            self.problems.append(f"outside request: {url}")

    def settle(self):
        # The attribute is reset as soon as the request is made, before this is called.
        self.tab.wait_for_timeout(60)
        self.tab.wait_for_selector(SETTLED, timeout=COMPILING)

    def array(self, part, name, slot="A"):
        return np.array(self.tab.evaluate(ARRAY, [slot, part, name]), float)

    def document(self, slot="A"):
        return self.tab.evaluate("slot => hertzchain.state[slot]", slot)

    def status(self):
        return self.tab.text_content("#status")


@pytest.fixture
def page(browser, running):
    found = Page(browser, running)
    yield found
    found.context.close()
    assert found.problems == []


def check_numbers(page, slot="A"):
    """Compare all numbers of the leading pulse with the library, bit for bit."""
    chain = chain_of(page.document(slot))
    assert np.array_equal(page.array("beads", "radii", slot), chain.radii)
    pulse = hc.propagate(chain)
    for quantity, values in pulse.columns().items():
        assert np.array_equal(page.array("pulse", f"exact.{quantity}", slot), values)
    for name, theory in (("bca", hc.bca), ("local-rate", hc.local_rate)):
        part = "pulse" if name == "local-rate" else "beads"
        assert np.array_equal(page.array(part, f"{name}.velocity", slot), theory(chain).velocity)
    return chain


# Marks of the chain and of the map, the forces and the budget, as often as they change.
WATCH_DRAFTS = """() => {
  const views = ["#title-A", ".plot:has(#map)", "#chart-force", "#chart-budget"];
  window.marks = [];
  new MutationObserver(() => {
    const marks = views.map((each) => getComputedStyle(document.querySelector(each), "::after").content);
    if (String(marks) !== String(window.marks.at(-1))) window.marks.push(marks);
  }).observe(document.body, { attributeFilter: ["class"] });
}"""  # noqa: E501


def drag(page, selector, to):
    box = page.tab.locator(selector).bounding_box()
    middle = box["y"] + box["height"] / 2
    at = float(page.tab.input_value(selector)) / 1000
    page.tab.mouse.move(box["x"] + 8 + at * (box["width"] - 16), middle)
    page.tab.mouse.down()
    for step in range(1, 13):
        place = at + (to - at) * step / 12
        page.tab.mouse.move(box["x"] + 8 + place * (box["width"] - 16), middle)
    page.tab.mouse.up()
    page.settle()


def slider(name):
    return f".row:has([id='c-chain.{name}']) input[type=range]"


@pytest.mark.parametrize("width", [1280, 1440])
def test_the_page_begins_with_steel_balls_and_shows_the_force_on_the_wall(browser, width):
    with serving() as server:
        page = Page(browser, server, viewport={"width": width, "height": 800})
        # The first result in the README.
        chain = hc.Chain.from_materials(10e-3, "steel-52100", beads=20, velocity=0.1)
        wall = hc.simulate(chain.replace(right_wall=hc.Wall.of("steel-52100"))).wall_force()
        assert chain_of(page.document()).radii == pytest.approx(chain.radii)
        legend = page.tab.locator("#legend-force")
        assert f"right wall: peak {wall.peak:#.4g} N" in legend.inner_text()
        impulse, duration = 1e3 * wall.impulse_of_impact, 1e6 * wall.duration
        assert legend.inner_text().endswith(
            f"impulse of the impact {impulse:#.4g} mN s; "
            f"duration (impulse / peak) {duration:#.4g} µs"
        )
        assert "sensor in bead 10: first maximum" in legend.inner_text()
        # Beads and forces can be seen without scrolling.
        box = legend.bounding_box()
        assert box["y"] + box["height"] < 800
        assert page.tab.locator("#warnings").is_hidden()
        page.context.close()
        assert page.problems == []


def test_numbers_after_a_drag_are_those_of_the_library(page):
    before = check_numbers(page)
    page.tab.evaluate(WATCH_DRAFTS)
    drag(page, slider("rate"), 0.9)
    after = check_numbers(page)
    assert dict(after.taper_parameters)["rate"] > 2 * dict(before.taper_parameters)["rate"]
    parts = page.tab.evaluate("hertzchain.answers.map(a => [a.part, a.draft])")
    assert ["pulse", True] in parts  # drafts were shown during the drag
    assert parts[-1] == ["run", False]
    # Views of a run that is a draft are marked until the exact one arrives.
    marks = page.tab.evaluate("marks")
    assert (marks[0], marks[-1]) == (['"draft"'] * 4, ["none"] * 4)


def test_errors_are_those_of_the_library(page):
    chain = chain_of(page.document())
    exact = hc.propagate(chain)
    for quantity in ("velocity", "arrival"):
        page.tab.select_option("#quantity", quantity)
        page.tab.evaluate(NEXT_FRAME)
        methods = {"bca": hc.bca, "local-rate": hc.local_rate}
        if quantity == "velocity":
            methods["modified-bca"] = hc.modified_bca
        for name, theory in methods.items():
            shown = page.tab.text_content(f"[data-curve='{name}']").rpartition(" ")[2]
            # The last bead, at the free end, is not described by theories.
            errors = theory(chain).compare(exact).errors(quantity)[1 : chain.beads - 1]
            worst = 100.0 * np.abs(errors).max()
            assert float(shown.removesuffix("%").replace("\N{MINUS SIGN}", "-")) == float(
                f"{worst:.2g}"
            )


def test_the_last_bead_at_a_free_end_is_apart(page):
    def shown(tab):
        marks = [tab.locator(f"#chart-{panel} .points").count() for panel in ("pulse", "error")]
        return "bead k (dot: free end)" in tab.text_content("#chart-pulse svg"), *marks

    # The simulation and the local-rate law; the errors end before this bead.
    assert shown(page.tab) == (True, 2, 0)
    walled = page.new_tab(f"{page.origin}#taper=uniform&beads=20&right_wall.rigid=true")
    assert shown(walled) == (False, 0, 0)


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
def test_the_rim_of_a_bead_can_be_dragged_and_undone(page):
    x, y, r = page.tab.evaluate("hertzchain.placeOf('A', 35)")
    page.tab.mouse.move(x, y - r + 1)
    page.tab.mouse.down()
    page.tab.mouse.move(x, y - 1.3 * r)
    page.tab.mouse.move(x, y - 1.5 * r)
    page.tab.mouse.up()
    page.settle()
    defects = page.document()["chain"]["with_defects"]
    assert [each["bead"] for each in defects] == [35]
    before = hc.Chain.tapered("backward-exponential", 0.05, beads=40).radii[34]
    assert 1.3 < defects[0]["radius"] / before < 1.7
    check_numbers(page)
    page.tab.keyboard.press("Control+z")
    page.settle()
    assert "with_defects" not in page.document()["chain"]
    page.tab.keyboard.press("Control+Shift+Z")
    page.settle()
    assert page.document()["chain"]["with_defects"] == defects


def test_completed_changes_are_undone_from_within_their_field(page):
    field = page.tab.get_by_label("beads", exact=True).first
    for value in ("30", "20"):
        field.fill(value)
        field.press("Enter")
        page.settle()
    assert page.document()["chain"]["beads"] == 20
    page.tab.keyboard.press("Control+z")
    page.settle()
    assert page.document()["chain"]["beads"] == 30
    page.tab.keyboard.press("Control+z")
    page.settle()
    assert page.document()["chain"]["beads"] == 40


def test_a_click_makes_a_sensor(page):
    before = page.tab.evaluate("hertzchain.state.view.sensors")
    box = page.tab.locator("#stage-A").bounding_box()
    page.tab.mouse.click(box["x"] + 0.95 * box["width"], box["y"] + 0.63 * box["height"])
    page.settle()
    after = page.tab.evaluate("hertzchain.state.view.sensors")
    assert len(after) == len(before) + 1
    force = page.array("run", f"force.{after[-1]}")
    run = hc.simulate(chain_of(page.document()), times=page.array("run", "forces.times"), rtol=1e-9)
    assert np.array_equal(force, run.sensor(after[-1]))
    assert f"sensor in bead {after[-1]}" in page.tab.text_content("#legend-force")


@pytest.mark.long
def test_every_table_of_the_schema_can_be_added_and_removed(page):
    groups = page.tab.evaluate("[...document.querySelectorAll('.group')].map(each => each.id)")
    tables = [name.removeprefix("group-") for name in groups][:-2]
    assert len(tables) >= 9
    for key in tables:
        before = page.document()
        page.tab.evaluate(f"document.getElementById('group-{key}').open = true")
        page.tab.click(f"#add-{key}")
        page.settle()
        found = page.document()
        assert set(found["chain"]) - set(before["chain"]) == {key}
        problem = page.tab.evaluate("hertzchain.results.A.problem")
        # Contacts of other bodies require materials.
        assert (problem != "") == (key == "with_contacts"), problem
        page.tab.click(f"#group-{key} button:has-text('Remove')")
        page.settle()
        assert page.document() == before


@pytest.mark.long
def test_every_law_of_loss_has_its_controls(page):
    page.tab.click("#group-loss summary")
    page.tab.click("#add-loss")
    page.settle()
    for law in page.tab.evaluate("hertzchain.about.schema.sections['chain.loss'].variants"):
        page.tab.select_option("[id='c-chain.loss']", law)
        page.settle()
        assert page.document()["chain"]["loss"]["law"] == law
        problem = page.tab.evaluate("hertzchain.results.A.problem")
        assert not problem or "yield" in problem or "SI" in problem, problem
        if not problem:
            # Theories state their reasons where their curves would be.
            assert "does not support" in page.tab.text_content("#notes-list") or law == "elastic"


@pytest.mark.long
def test_every_drive_and_every_form_has_its_controls(page):
    page.tab.click("#group-drive summary")
    page.tab.click("#add-drive")
    page.settle()
    for kind in ("sine-burst", "step", "table"):
        page.tab.select_option("[id='c-chain.drive']", kind)
        page.settle()
        assert page.document()["chain"]["drive"]["kind"] == kind
        assert page.tab.evaluate("hertzchain.results.A.problem") == ""
    page.tab.click("#group-drive button:has-text('Remove')")
    for form in ("radii", "cell", "mass_ratio", "cell_diameters", "taper", "cell", "radii"):
        page.tab.select_option("[id='c-form']", form)
        page.settle()
        assert form in page.document()["chain"]
        for material in ("brass", ""):
            page.tab.select_option("[id='c-chain.materials']", material)
            page.settle()
            assert page.tab.evaluate("hertzchain.results.A.problem") == "", (form, material)
            assert chain_of(page.document()).scaled == (material == "")
            # A material begins with an impact at which steel balls do not yield.
            assert page.document()["chain"].get("velocity", "0.1 m/s") == "0.1 m/s"


def test_own_materials_can_be_used(page):
    page.tab.click("#group-materials summary")
    page.tab.click("#add-material")
    page.settle()
    page.tab.select_option("[id='c-chain.materials']", "material 1")
    page.settle()
    page.tab.fill("[id='c-materials.material 1.density']", "2500")
    page.tab.keyboard.press("Tab")
    page.settle()
    chain = chain_of(page.document())
    assert (chain.materials[0].density, chain.materials[0].young) == (2500.0, 2e9)
    assert np.array_equal(page.array("beads", "masses"), chain.masses)


def test_units_are_converted_by_the_library(page):
    page.tab.select_option("[id='c-chain.materials']", "steel-52100")
    page.settle()
    page.tab.fill("[id='c-chain.radius']", "9.3")
    page.tab.keyboard.press("Tab")
    page.settle()
    assert page.document()["chain"]["radius"] == "9.3 mm"
    assert page.array("beads", "radii")[0] == 9.3e-3
    page.tab.select_option("[id='c-chain.materials']", "")
    page.settle()
    assert "radius" not in page.document()["chain"]
    check_numbers(page)


@pytest.mark.parametrize("example", gallery()[1::3], ids=lambda example: example["title"])
def test_links_bring_everything_back(page, example):
    page.tab.click("#open-examples")
    page.tab.click(f'button[aria-label="Open {example["title"]}"]')
    page.settle()
    page.tab.select_option("#quantity", "arrival")
    page.tab.wait_for_timeout(300)
    link = page.tab.evaluate("location.href")
    other = page.new_tab(link)
    state = "JSON.stringify(hertzchain.state)"
    assert json.loads(other.evaluate(state)) == json.loads(page.tab.evaluate(state))
    assert other.evaluate("hertzchain.state.A") == example["document"]
    assert "token" not in link


def test_two_chains_are_computed_and_compared(page):
    # All errors of beads 2 to 39 are drawn, although the smallest is 2e-10.
    errors = page.tab.get_attribute("#chart-error path.local-rate", "d")
    assert (errors.count("M"), errors.count("L")) == (1, 37)
    heights = [float(each) for each in re.findall(r" ([-\d.]+)", errors)]
    assert (
        0.0
        < min(heights)
        < max(heights)
        < page.tab.locator("#chart-error").bounding_box()["height"]
    )
    page.tab.click("#compare")
    page.settle()
    drag(page, slider("rate"), 0.1)
    assert check_numbers(page, "B").radii[-1] < check_numbers(page, "A").radii[-1]
    assert page.tab.locator("#chart-error path.other").count() == 1
    page.tab.click("#tab-A")
    drag(page, slider("beads"), 0.2)
    assert chain_of(page.document("A")).beads < 20 < chain_of(page.document("B")).beads
    page.tab.fill("[id='c-chain.beads']", "3")
    page.tab.press("[id='c-chain.beads']", "Enter")
    page.settle()
    for chart in ("#chart-error", "#chart-pulse"):
        ticks = page.tab.locator(
            f"{chart} text[text-anchor=middle]:not(.label)"
        ).all_text_contents()
        assert len(ticks) >= 2
        assert all(each.isdigit() for each in ticks)
    page.tab.click("#compare")
    page.settle()
    assert page.document("B") is None


def test_the_status_is_that_of_the_selected_chain_and_names_it(page):
    page.tab = page.new_tab(f"{page.origin}#taper=uniform&beads=5&b.taper=uniform&b.beads=9")
    for slot in ("A", "B", "A"):
        page.tab.click(f"#tab-{slot}")
        header = page.tab.evaluate("slot => hertzchain.results[slot].run.header", slot)
        assert page.status().startswith(f"Chain {slot}: {header['message']}; energy adds up")
    ends = page.tab.evaluate("['A', 'B'].map(slot => hertzchain.results[slot].run.header.message)")
    assert ends[0] != ends[1]


def test_the_dialog_to_share_names_the_chain_of_its_files(page):
    page.tab = page.new_tab(f"{page.origin}#taper=uniform&beads=5&b.taper=uniform&b.beads=9")
    for slot, chain in (("A", "5 beads"), ("B", "9 beads")):
        page.tab.click(f"#tab-{slot}")
        page.tab.click("#open-share")
        about = page.tab.text_content("#share-of")
        assert about.startswith(f"Chain {slot} of A and B: ")
        assert chain in about
        assert page.tab.text_content("#share-status") == ""
        page.tab.keyboard.press("Escape")
    page.tab = page.new_tab(f"{page.origin}#taper=uniform&beads=5&b.taper=uniform&b.beads=-9")
    page.tab.click("#tab-B")
    page.tab.click("#open-share")
    assert page.tab.text_content("#share-of").startswith("Chain B of A and B has an error. The ")
    assert "beads" in page.tab.text_content("#share-status")


def test_a_field_that_is_left_without_a_change_requests_nothing(page):
    rate = page.tab.locator("[id='c-chain.rate']")
    rate.fill("0.07")
    page.settle()
    before = page.tab.evaluate("[hertzchain.answers.length, location.hash]")
    rate.press("Tab")
    page.tab.wait_for_timeout(300)
    assert page.tab.evaluate("[hertzchain.answers.length, location.hash]") == before
    # The change is one step of the history.
    page.tab.click("#undo")
    page.settle()
    assert page.document() == TAPER
    assert page.tab.is_disabled("#undo")


def test_the_reason_why_there_are_no_theories_is_stated(page):
    ball = "diameters=12+mm&beads=4&materials=steel-52100&right_wall.rigid=true&velocity=5+m/s"
    both = "&".join(f"b.{each}" for each in ball.split("&"))
    page.tab = page.new_tab(f"{page.origin}#{ball}&{both}")
    assert page.tab.text_content("#notes-count") == "No theory supports a right wall"
    # Equal warnings of both chains are stated once.
    warnings = page.tab.locator("#warnings-count, #warnings-list li").all_text_contents()
    assert warnings
    assert all("A and B: " in each for each in warnings)


def test_axes_do_not_show_rounding_errors(page):
    balls = "first_diameter=20+mm&last_diameter=20+mm&beads=5&materials=steel-52100&gaps=5+um"
    slower = "&".join(f"b.{each}" for each in balls.split("&"))
    page.tab = page.new_tab(
        f"{page.origin}#{balls}&velocity=0.1+m/s&{slower}&b.velocity=0.01+m/s&~errors=difference"
    )
    for chart in ("#chart-pulse", "#chart-error"):
        labels = page.tab.locator(f"{chart} text[text-anchor=end]").all_text_contents()
        assert len(labels) == len(set(labels)) >= 3
        heights = page.tab.evaluate(
            """chart => [...document.querySelectorAll(chart + " path")]
              .filter(each => each.matches(".exact, .other")).map(each => each.getBBox().height)""",
            chart,
        )
        # Differences of 1e-8 are within a pixel, and so are those of 90% between the chains.
        assert heights[-1] < 1.0
    page.tab.click("#compare")
    page.settle()
    assert page.tab.locator("#chart-pulse path.exact").evaluate("e => e.getBBox().height") < 1.0


@pytest.mark.long
def test_each_lane_changes_its_own_chain(page):
    chain = "materials=steel-52100&radius=5mm&beads=8&taper=uniform&velocity=1m/s"
    page.tab = page.new_tab(page.origin + f"#{chain}&right_wall.gap=0.1mm")
    page.tab.click("#compare")
    page.settle()
    first = page.document("A")
    assert page.document("B") == first
    page.tab.click("#tab-A")
    x, y, r = page.tab.evaluate("hertzchain.placeOf('B', 8)")
    page.tab.mouse.move(x + r + 7, y)
    page.tab.mouse.down()
    page.tab.mouse.move(x + r + 17, y)
    page.tab.mouse.up()
    page.settle()
    assert page.document("A") == first
    assert float(page.document("B")["chain"]["right_wall"]["gap"].split()[0]) > 0.2
    page.tab.click("#tab-A")
    page.tab.focus("#lane-B")
    # The controls behind the lanes can be reached while those of chain A are shown.
    assert page.tab.evaluate("hertzchain.state.active") == "A"
    page.tab.keyboard.press("End")
    # A key that is held repeats before the results of the last step arrive.
    for _ in range(10):
        page.tab.keyboard.press("ArrowUp")
    page.settle()
    assert page.document("A") == first
    (defect,) = page.document("B")["chain"]["with_defects"]
    assert defect["bead"] == 8
    # A radius is rounded to three digits after each step.
    radius = float(defect["radius"].removesuffix(" mm"))
    assert radius == pytest.approx(5.0 * 1.05**10, rel=0.01)


@pytest.mark.long
def test_both_chains_are_drawn_at_the_same_scale(page):
    chains = ("radii=5+mm&beads=30&materials=steel-52100", "radii=2+mm&beads=6&materials=brass")
    second = "&".join(f"b.{each}" for each in chains[1].split("&"))

    def radius(slot):
        return page.tab.evaluate(f"hertzchain.placeOf('{slot}', 1)[2]")

    page.tab = page.new_tab(f"{page.origin}#{chains[0]}&{second}")
    small = radius("B")
    assert radius("A") == pytest.approx(2.5 * small)
    page.tab.select_option("#camera", "follow")
    page.tab.evaluate(NEXT_FRAME)
    assert radius("A") == pytest.approx(2.5 * radius("B"))
    assert radius("B") > small
    page.tab.select_option("#camera", "whole")
    # Alone, the small chain has the height of the view.
    page.tab.click("#tab-B")
    page.tab.click("#compare")
    page.settle()
    assert radius("A") > 3 * small
    # Scaled and SI units have no common scale.
    page.tab = page.new_tab(f"{page.origin}#{chains[0]}&b.taper=uniform&b.beads=6")
    assert radius("B") > 3 * small


def test_equal_beads_of_both_chains_are_below_each_other(page):
    """The first chain has two walls, the second one a small bead, and neither has both."""
    balls = "radii=5+mm&beads=20&materials=steel-52100"
    walls = "left_wall.material=steel-52100&right_wall.material=steel-52100"
    odd = "with_defects.0.bead=10&with_defects.0.radius=3+mm"
    second = "&".join(f"b.{each}" for each in f"{balls}&{odd}".split("&"))
    page.tab = page.new_tab(f"{page.origin}#{balls}&{walls}&{second}")
    for active in "AB":
        page.tab.click(f"#tab-{active}")
        page.tab.evaluate(NEXT_FRAME)
        places = np.array([[page.tab.evaluate(f"hertzchain.placeOf('{slot}', {bead})[0]")
                            for bead in range(1, 21)] for slot in "AB"])  # fmt: skip
        shift = np.diff(places, axis=0)[0]
        np.testing.assert_allclose(shift[:9], 0.0, atol=0.01)
        # The beads behind the small one are nearer by the difference of the diameters, 4 mm.
        np.testing.assert_allclose(shift[10:], -0.4 * (places[0, 1] - places[0, 0]), atol=0.01)
        width = page.tab.locator("#stage-A").bounding_box()["width"]
        assert places.min() > 300.0
        assert places.max() < places.min() + width


def open_file(page, path):
    """Open a chain file, which the server reads first."""
    with page.tab.expect_response("**/api/chain"):
        page.tab.set_input_files("#file", path)
    page.settle()


def open_example(page, title, action="Open"):
    page.tab.click("#open-examples")
    label = {"Open": "Open ", "Open as chain B": "Open as chain B: "}[action] + title
    page.tab.click(f"button[aria-label='{label}']")
    page.settle()


def test_a_chain_file_with_a_striker_of_given_mass_can_be_opened(page, tmp_path):
    chain = hc.Chain.uniform(6).struck_by(mass=4.0, radius=1.0)
    path = tmp_path / "chain.toml"
    path.write_text(hc.chain_as_toml(chain))
    open_file(page, path)
    assert page.document("A")["chain"]["struck_by"] == [
        {"velocity": 1.0, "mass": 4.0, "radius": 1.0}
    ]
    assert page.tab.evaluate("hertzchain.results.A.problem") == ""
    assert np.array_equal(page.array("beads", "masses"), chain.masses)


def test_a_chain_with_a_cap_can_be_opened_changed_and_saved(page, tmp_path):
    row = hc.Chain.from_materials("6 mm", "steel-52100", beads=5, velocity=0.02)
    chain = row.replace(right_wall=hc.Wall("5 kN/mm", exponent=1)).with_cap("5 g")
    path = tmp_path / "chain.toml"
    path.write_text(hc.chain_as_toml(chain))
    open_file(page, path)
    assert chain_of(page.document()) == chain
    assert np.array_equal(page.array("beads", "radii"), [6e-3] * 5 + [np.inf])
    page.tab.click("text=Remove >> nth=0")
    page.settle()
    assert "cap" not in page.document()["chain"]
    if not page.tab.locator("#add-cap").is_visible():
        page.tab.click("#group-cap summary")
    page.tab.click("#add-cap")
    page.settle()
    assert page.document()["chain"]["cap"] == {"mass": "5 g"}
    assert page.tab.evaluate("hertzchain.results.A.problem") == ""
    assert np.array_equal(page.array("beads", "masses"), chain.masses)
    assert hc.chain_from_toml(document_as_toml(page.document())) == chain


@pytest.mark.long
def test_opening_a_chain_removes_an_older_chain_b(page, tmp_path):
    open_example(page, "Shock absorber")
    assert page.document("B") == EXAMPLES["Shock absorber"]["other"]
    assert page.tab.locator("#legend-error table").count() == 1
    open_example(page, "Steel and PTFE shock absorber")
    assert page.document("B") is None
    assert not page.tab.locator("#lane-B").is_visible()
    assert page.tab.locator("#legend-error table").count() == 0
    open_example(page, "Equal beads: a solitary wave", "Open as chain B")
    assert page.document("A") == EXAMPLES["Steel and PTFE shock absorber"]["document"]
    assert page.document("B") == EXAMPLES["Equal beads: a solitary wave"]["document"]
    path = tmp_path / "chain.toml"
    path.write_text('[chain]\ntaper = "uniform"\nbeads = 12\n')
    open_file(page, path)
    assert page.document("B") == {"chain": {"taper": "uniform", "beads": 12}}
    assert page.document("A") == EXAMPLES["Steel and PTFE shock absorber"]["document"]
    page.tab.click("#tab-A")
    open_file(page, path)
    assert page.document("A") == {"chain": {"taper": "uniform", "beads": 12}}
    assert page.document("B") is None
    page.tab.click("#undo")
    page.settle()
    assert page.document("B") == {"chain": {"taper": "uniform", "beads": 12}}
    page.tab.evaluate("location.hash = 'taper=uniform&beads=9'")
    page.settle()
    assert page.document("B") is None
    check_numbers(page)


@pytest.mark.long
def test_views_without_results_say_that_they_are_compiled(page):
    open_example(page, "Shock absorber")
    page.tab.evaluate("""() => {
      const { A, B } = hertzchain.results;
      A.motion = null;
      A.pending = ["simulate"];
      A.pulse = B.pulse = { header: null, arrays: new Map() };
    }""")
    page.tab.select_option("#quantity", "momentum")
    page.tab.evaluate(NEXT_FRAME)
    reason = "Compiling simulate: once after an installation, about a minute …"
    assert page.tab.text_content("#map-note") == reason
    for name in ("pulse", "error", "budget", "force", "modes"):
        assert page.tab.text_content(f"#chart-{name} .nothing") == reason
    # Numbers of earlier chains are not shown next to this message.
    assert page.tab.locator("#legend-error table").count() == 0
    both = "taper=uniform&beads=9&b.radii=5+mm&b.beads=9&b.materials=steel-52100"
    page.tab.evaluate("hash => { location.hash = hash }", f"{both}&~errors=difference")
    page.settle()
    assert page.tab.text_content("#map-note") == ""
    assert "cannot be compared" in page.tab.text_content("#chart-error .nothing")


STEEL_BALLS = (
    "first_diameter=20+mm&last_diameter={}+mm&beads=20&materials=steel-52100&velocity=0.1+m/s&"
    "right_wall.rigid=false"
)
# Time and force of the top of each curve of the force on the right wall, in pixels, A first;
# and the positions and texts of the ticks of the time axis.
TOPS = """() => {
  const tops = [...document.querySelectorAll('#chart-force path.wall-right')].map((path) =>
    path.getAttribute('d').slice(1).split('L').map((each) => each.split(' ').map(Number)).sort((a, b) => a[1] - b[1])[0]);
  const texts = [...document.querySelectorAll('#chart-force text[text-anchor=middle]:not(.label)')];
  return [tops, texts.map((each) => [Number(each.getAttribute('x')), Number(each.textContent)])];
}"""  # noqa: E501


@pytest.mark.parametrize("clock", ["beads", "time"])
def test_both_chains_are_drawn_at_their_true_times(page, clock):
    own, other = STEEL_BALLS.format(8), STEEL_BALLS.format(14)
    second = "&".join(f"b.{each}" for each in other.split("&"))
    view = f"&~clock={clock}&~errors=difference&~sensors=[10]&~bead=10"
    page.tab.goto(f"{page.origin}#{own}&{second}{view}")
    page.settle()
    walls = [
        hc.simulate(chain_of(page.document(slot)), times=0, rtol=1e-9).wall_force() for slot in "AB"
    ]
    for slot, order in (("A", (0, 1)), ("B", (1, 0))):
        page.tab.click(f"#tab-{slot}")
        page.tab.evaluate(NEXT_FRAME)
        tops, ticks = page.tab.evaluate(TOPS)
        places, times = np.transpose(ticks)
        assert len(times) >= 3
        assert np.allclose(np.diff(times), times[1] - times[0], rtol=1e-9)
        slope, start = np.polyfit(times, places, 1)
        for (x, _), wall in zip(tops, walls, strict=True):
            # Coordinates are rounded to a tenth of a pixel.
            assert (x - start) / slope == pytest.approx(1e3 * wall.peak_time, abs=0.1 / slope)
        legend = page.tab.text_content("#legend-force")
        assert f"right wall: peak {walls[order[0]].peak:#.4g} N" in legend
        assert f"at {1e3 * walls[order[0]].peak_time:#.4g} ms" in legend
        # The cursor is at the time of the clock, and both chains are shown at that time.
        page.tab.evaluate("document.getElementById('time').value = 400")
        page.tab.dispatch_event("#time", "input")
        page.tab.evaluate(NEXT_FRAME)
        shown = float(page.tab.text_content("#clockface").split()[2])
        cursor = float(page.tab.get_attribute("#chart-force line.cursor", "x1"))
        assert (cursor - start) / slope == pytest.approx(shown, abs=0.5 / slope)
        rows = page.tab.locator("#legend-error tr").all_inner_texts()
        (peak,) = [each.split("\t") for each in rows if each.startswith("right wall, peak [")]
        a, b = (wall.peak for wall in walls)
        assert peak[1:] == [f"{a:#.4g}", f"{b:#.4g}", f"{b / a:#.4g}"]


@pytest.mark.long
@pytest.mark.parametrize(
    ("form", "sizes"), [("first_diameter", (5e-3, 1.5e-3)), ("first", (5e-3, 1.5e-3))]
)
def test_sizes_and_material_can_be_chosen_in_either_order(page, form, sizes):
    found = []
    for order in ((form, "steel-52100"), ("steel-52100", form)):
        page.tab.goto("about:blank")
        page.tab.goto(f"{page.origin}#taper=uniform&beads=20")
        page.tab.wait_for_selector(SETTLED, timeout=COMPILING)
        for each in order:
            page.tab.select_option("[id='c-form']" if each == form else MATERIAL, each)
            page.settle()
        # Tapers of given sizes are exponential unless something else is chosen.
        assert page.tab.input_value("[id='c-chain.taper']") == "exponential"
        found.append(page.document()["chain"])
        radii = chain_of(page.document()).radii
        assert radii[[0, -1]] == pytest.approx(sizes)
        assert np.allclose(radii[1:] / radii[:-1], radii[1] / radii[0])
    assert found[0] == found[1]
    page.tab.select_option("[id='c-chain.taper']", "linear")
    page.settle()
    radii = chain_of(page.document()).radii
    assert np.allclose(np.diff(radii), radii[1] - radii[0])
    page.tab.select_option(MATERIAL, "")
    page.settle()
    assert chain_of(page.document()).radii == pytest.approx(radii / radii[0])


def test_numbers_are_stored_with_their_unit(page):
    page.tab.select_option(MATERIAL, "steel-52100")
    page.settle()
    page.tab.fill("[id='c-chain.velocity']", "0.1")
    page.tab.keyboard.press("Tab")
    page.settle()
    assert page.document()["chain"]["velocity"] == "0.1 m/s"
    assert 'velocity = "0.1 m/s"' in document_as_toml(page.document())
    assert chain_of(page.document()).velocities[0] == 0.1


def test_lists_have_units_and_a_panel_without_curves_is_hidden(page, tmp_path):
    path = tmp_path / "chain.toml"
    path.write_text(
        "[chain]\nradii = [0.006, 0.01, 0.0025]\nmaterials = 'steel-52100'\n[chain.right_wall]\n"
    )
    assert page.tab.locator("#h-error").is_visible()
    open_file(page, path)
    radii = "[id='c-chain.radii']"
    assert page.tab.input_value(radii) == "6 mm, 10 mm, 2.5 mm"
    assert page.tab.get_attribute(radii, "title") == "6 mm, 10 mm, 2.5 mm"
    # No theory supports a wall.
    assert not page.tab.locator("#h-error").is_visible()
    page.tab.fill(radii, "5, 0.8 cm, 3 mm")
    page.tab.keyboard.press("Tab")
    page.settle()
    assert chain_of(page.document()).radii == pytest.approx([5e-3, 8e-3, 3e-3])
    # Another number of beads needs other controls, and the list remains.
    page.tab.fill(radii, "5 mm, 8 mm, 3 mm, 2 mm")
    page.tab.keyboard.press("Enter")
    page.settle()
    assert len(chain_of(page.document()).radii) == 4
    assert page.tab.input_value(radii) == "5 mm, 8 mm, 3 mm, 2 mm"


@pytest.mark.long
def test_a_decimal_comma_is_explained_and_its_text_remains(page):
    row = "diameters=10+mm&beads=3&materials=steel-52100"
    page.tab = page.new_tab(f"{page.origin}#{row}&velocity=0.1+m/s")
    for control, text, advice in (
        ("diameters", "10,5 mm", "write 10.5 mm with a decimal point, or 10 mm, 5 mm for two"),
        ("velocity", "0,05", "write 0.05 with a decimal point"),
    ):
        box = page.tab.locator(f"[id='c-chain.{control}']")
        box.fill(text)
        box.press("Enter")
        page.settle()
        assert page.document()["chain"][control] == box.input_value() == text
        problem = page.tab.text_content("#problem")
        assert problem.startswith(f"{control} must be a number, or text with a unit")
        assert advice in problem
        page.tab.click("#undo")
        page.settle()
        assert not page.tab.is_visible("#problem")


def test_a_wrong_unit_is_not_kept(page):
    row = "first_diameter=20+mm&last_diameter=1+cm&beads=3&materials=steel-52100"
    page.tab = page.new_tab(f"{page.origin}#{row}&velocity=0.1+m/s")
    box = page.tab.locator("[id='c-chain.last_diameter']")
    unit = page.tab.locator(".value:has([id='c-chain.last_diameter']) .unit")
    for wrong in ("20 kg", "20 cmm"):
        box.fill(wrong)
        box.press("Enter")
        page.settle()
        assert page.tab.is_visible("#problem")
        assert (box.input_value(), unit.text_content()) == (wrong, "cm")
        box.fill("0.8")
        box.press("Enter")
        page.settle()
        assert not page.tab.is_visible("#problem")
        assert page.document()["chain"]["last_diameter"] == "0.8 cm"
    box.fill("7 mm")
    box.press("Enter")
    page.settle()
    assert (box.input_value(), unit.text_content()) == ("7", "mm")


def test_velocities_are_listed_without_spaces_and_replace_the_impact_velocity(page):
    page.tab = page.new_tab(f"{page.origin}#diameters=20+mm&beads=3&materials=brass&velocity=1+m/s")
    page.tab.click("#group-more summary")
    box = page.tab.locator("[id='c-chain.velocities']")
    box.fill("0.1,0,0")
    box.press("Enter")
    page.settle()
    problem = page.tab.text_content("#problem")
    assert problem.startswith("there are an impact velocity and a list of velocities: empty one")
    page.tab.click("[aria-label='Use the default for impact velocity']")
    page.settle()
    assert not page.tab.is_visible("#problem")
    assert chain_of(page.document()).velocities.tolist() == [0.1, 0.0, 0.0]


@pytest.mark.long
def test_percentages_and_fractions_of_inches_can_be_entered(page):
    page.tab.fill("[id='c-chain.rate']", "4%")
    page.tab.keyboard.press("Tab")
    page.settle()
    assert page.document()["chain"]["rate"] == "4%"
    assert dict(check_numbers(page).taper_parameters)["rate"] == 0.04
    drag(page, slider("rate"), 0.9)
    rate = page.document()["chain"]["rate"]
    assert rate.endswith("%")
    assert dict(check_numbers(page).taper_parameters)["rate"] > 0.08
    # The percent sign is part of the text: a number without it is not a percentage.
    assert page.tab.input_value("[id='c-chain.rate']") == rate
    page.tab.fill("[id='c-chain.rate']", "0.03")
    page.tab.keyboard.press("Tab")
    page.settle()
    assert page.document()["chain"]["rate"] == 0.03
    page.tab.fill("[id='c-chain.rate']", rate)
    page.tab.keyboard.press("Tab")
    page.settle()
    page.tab.select_option(MATERIAL, "steel-52100")
    page.settle()
    # A part of the text is a number: the field must not be rewritten while it is typed.
    page.tab.click("[id='c-chain.radius']", click_count=3)
    page.tab.keyboard.type("3/16 in", delay=40)
    page.settle()
    assert page.tab.input_value("[id='c-chain.radius']") == "3/16 in"
    page.tab.keyboard.press("Tab")
    page.settle()
    assert page.document()["chain"]["radius"] == "3/16 in"
    assert page.array("beads", "radii")[0] == 4.7625e-3
    assert page.tab.input_value("[id='c-chain.radius']") == "0.1875"
    page.tab.fill("[id='c-chain.radius']", "7%")
    page.tab.keyboard.press("Tab")
    page.settle()
    with pytest.raises(hc.InputError, match="must have a unit such as m") as error:
        chain_of(page.document())
    assert page.tab.text_content("#problem") == str(error.value).replace(" of [chain]", "")
    page.tab.fill("[id='c-chain.radius']", "9 mm")
    page.tab.keyboard.press("Tab")
    page.settle()
    page.tab.select_option(MATERIAL, "")
    page.settle()
    assert page.document()["chain"]["rate"] == rate


def test_two_tabs_do_not_disturb_each_other(page):
    other = page.new_tab(page.origin)
    page.tab.fill("[id='c-chain.beads']", "25")
    page.settle()
    assert other.evaluate("hertzchain.results.A.beads.header.beads") == 40
    assert page.array("beads", "radii").size == 25


def test_a_bad_link_is_explained_above_the_views(page):
    tab = page.new_tab(page.origin + "#taper=unifrm&beads=20")
    shown = tab.locator("#title-A")
    assert shown.text_content() == tab.text_content("#status")
    assert "'unifrm'" in shown.text_content()
    box = shown.bounding_box()
    assert box["y"] + box["height"] < 300
    # Views without results have no axes.
    assert tab.locator(".plot svg text").count() == 0
    tab.evaluate("location.hash = '#taper=uniform&beads=20'")
    tab.wait_for_selector("#title-A:has-text('uniform, 20 beads')", timeout=COMPILING)


def test_sensors_have_the_names_of_balls(page):
    tab = page.new_tab(page.origin + "#taper=uniform&beads=12&struck_by.count=1&~sensors=[7]")
    assert "sensor in bead 8 (ball 7): first maximum" in tab.text_content("#legend-force")


@pytest.mark.long
def test_both_chains_have_sensors_and_values_at_the_same_balls(page):
    second = "b.taper=uniform&b.beads=12&b.struck_by.radius=1.5"
    view = "~sensors=[3]&~bead=3&~errors=difference"
    tab = page.tab = page.new_tab(f"{page.origin}#taper=uniform&beads=12&{second}&{view}")
    chains = [chain_of(page.document(slot)) for slot in "AB"]
    forces = [
        hc.simulate(chain, rtol=1e-9, check=False).sensor_force(bead).first_maximum
        for chain, bead in zip(chains, (3, 4), strict=True)
    ]
    rows = [each.split("\t") for each in tab.locator("#legend-error tr").all_inner_texts()]
    assert [each[1:3] for each in rows if each[0] == "sensor in ball 3, first maximum"] == [
        [f"{force:#.4g}" for force in forces]
    ]
    a, b = (hc.propagate(chain).velocity for chain in chains)
    # Without the free ends.
    changes = 100 * (b[1:] / a - 1)[:-1]
    words = tab.get_attribute("#chart-error svg", "aria-label").replace("\N{MINUS SIGN}", "-")
    end, largest = re.findall(r"(?:end|largest) ([-.\d]+)", words)
    assert [float(end), float(largest)] == pytest.approx(
        [changes[-1], np.abs(changes).max()], rel=1e-3
    )
    assert tab.get_attribute("#sensor", "aria-pressed") == "true"
    # Chains have the same letters, and differences the same sign, whichever chain is chosen.
    for slot in "AB":
        tab.click(f"#tab-{slot}")
        tab.wait_for_selector("#sensor[aria-pressed=true]")
        words = tab.get_attribute("#chart-error svg", "aria-label").replace("\N{MINUS SIGN}", "-")
        assert "(B − A) / A".replace("\N{MINUS SIGN}", "-") in words
        assert float(re.search(r"largest ([-.\d]+)", words)[1]) == pytest.approx(
            np.abs(changes).max(), rel=1e-3
        )
        assert float(re.search(r"end ([-.\d]+)", words)[1]) == pytest.approx(changes[-1], rel=1e-3)
        curves = tab.locator("#legend-pulse button").all_inner_texts()
        assert curves[:2] == ["A, simulation", "B, simulation"]
        assert all(each.startswith(f"{slot}, ") for each in curves[2:])
        forces = tab.locator("#legend-force .key").all_inner_texts()
        assert [each[:3] for each in forces] == ["A, ", "B, "]
        for heading in ("#h-map", "#h-budget", "#table-details h2"):
            assert tab.text_content(heading).endswith(f", chain {slot}")
    assert tab.input_value("#bead") == "4"
    # A sensor stays in its ball if strikers are added.
    tab.evaluate("hertzchain.state.B.chain.struck_by = {count: 2}")
    tab.select_option("#clock", "time")
    page.settle()
    assert "sensor in bead 5 (ball 3)" in tab.text_content("#legend-force")
    # Equal up to the free end of B.
    tab.goto("about:blank")
    taper = "{0}taper=forward-exponential&{0}rate=0.05&{0}beads={1}"
    tab.goto(f"{page.origin}#{taper.format('', 60)}&{taper.format('b.', 40)}&{view}")
    page.settle()
    words = tab.get_attribute("#chart-error svg", "aria-label")
    assert float(re.search(r"largest ([-.\d]+)", words)[1]) < 1.0


def test_an_arrow_points_to_a_selected_bead_outside_of_the_view(page):
    tab = page.tab
    tab.select_option("#camera", "follow")
    tab.evaluate("""() => {
        hertzchain.written = [];
        const fill = CanvasRenderingContext2D.prototype.fillText;
        CanvasRenderingContext2D.prototype.fillText = function (text, ...place) {
          if (text.includes("bead ")) hertzchain.written.push(text);
          fill.call(this, text, ...place);
        };
    }""")  # fmt: skip
    for place, bead, label in ((0, 2, "bead 2"), (0, 18, "bead 18 →"), (1, 2, "← bead 2")):
        tab.fill("#bead", str(bead))
        tab.press("#bead", "Tab")
        tab.evaluate("""(place) => {
            const slider = document.getElementById("time");
            slider.value = place ? slider.max : slider.min;
            slider.dispatchEvent(new Event("input", { bubbles: true }));
        }""", place)  # fmt: skip
        tab.evaluate(NEXT_FRAME)
        assert tab.evaluate("hertzchain.written.at(-1)") == label


HAMMER = """
[chain]
diameters = "8 mm"
materials = "steel-52100"
beads = 8
right_wall = {material = "steel-52100"}
[[chain.struck_by]]
velocity = "0.5 m/s"
mass = "50 g"
radius = inf
"""


@pytest.mark.long
def test_a_hammer_is_a_plate_with_one_velocity(page, tmp_path):
    path = tmp_path / "hammer.toml"
    path.write_text(HAMMER.partition("[[")[0])
    open_file(page, path)
    assert page.tab.locator("[id='c-chain.velocity']").count() == 1
    path.write_text(HAMMER)
    open_file(page, path)
    # The velocity of the impact is that of the striker.
    assert page.tab.locator("[id='c-chain.velocity']").count() == 0
    (x, y, r), (_, _, ball) = (page.tab.evaluate(f"hertzchain.placeOf('A', {k})") for k in (1, 2))
    assert r == pytest.approx(0.25 * ball)
    page.tab.keyboard.press("ArrowUp")
    assert page.document()["chain"]["struck_by"][0]["mass"] == "50 g"
    # The whole plate can be chosen, but has no rim.
    page.tab.mouse.move(x, y - 0.9 * ball)
    assert page.tab.evaluate("document.getElementById('stage-A').style.cursor") == "pointer"
    # Views that follow the pulse have room for the plate.
    page.tab.select_option("#camera", "follow")
    page.tab.evaluate(NEXT_FRAME)
    height = page.tab.locator("#stage-A").bounding_box()["height"]
    assert page.tab.evaluate("hertzchain.placeOf('A', 2)[2]") <= 0.26 * height + 1.0
    page.tab.select_option("#camera", "whole")
    page.tab.evaluate(NEXT_FRAME)
    # A drag changes no radius.
    page.tab.mouse.move(x, y)
    page.tab.mouse.down()
    page.tab.mouse.move(x, y - 2 * ball, steps=3)
    page.tab.mouse.up()
    page.settle()
    assert np.array_equal(page.array("beads", "radii"), [np.inf] + 8 * [4e-3])
    # A disc of this width would not cover its corner.
    left, top = (page.tab.locator("#stage-A").bounding_box()[name] for name in ("x", "y"))
    plate, outside = page.tab.evaluate(
        """(places) => {
          const canvas = document.getElementById("stage-A"), { width, height } = canvas;
          const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
          const dense = width / canvas.clientWidth;
          return places.map(([x, y]) => {
            const at = 4 * (Math.round(y * dense) * width + Math.round(x * dense));
            return [...data.slice(at, at + 4)];
          });
        }""",
        [[x - left + 0.5 * r, y - top - 0.8 * ball], [x - left - r - 6, y - top - 0.8 * ball]],
    )
    assert plate != outside


def test_a_saved_page_has_no_gap_between_its_views(page, tmp_path):
    path = tmp_path / "hammer.toml"
    path.write_text(HAMMER)
    hc.save_page(hc.load_chain(path), tmp_path / "hammer.html")
    tab = page.tab = page.new_tab(f"file://{tmp_path}/hammer.html")
    # No theory supports the wall, so that there is no comparison.
    for width, last in ((1280, ["h-pulse", "h-budget"]), (1600, ["h-budget"])):
        tab.set_viewport_size({"width": width, "height": 900})
        boxes = [tab.locator(f"section:has(#{name})").bounding_box() for name in last]
        page_box = tab.locator("#views").bounding_box()
        assert boxes[-1]["x"] + boxes[-1]["width"] == pytest.approx(
            page_box["x"] + page_box["width"], abs=1.0
        )
        assert len({each["y"] for each in boxes}) == 1
    # Nothing can be chosen in a saved page.
    warning = tab.inner_text("#warnings-count")
    assert "Contacts would be dented, and forces may be lower: pressure / " in warning
    assert "choose" not in tab.text_content("#warnings")


def test_all_views_of_a_saved_page_can_show_either_chain(page, tmp_path):
    chain = hc.Chain.uniform(12)
    hc.save_page(chain, tmp_path / "one.html")
    hc.save_page(chain, tmp_path / "two.html", other=chain.with_defects({6: 0.5}))
    tab = page.new_tab(f"file://{tmp_path}/one.html")
    assert not tab.locator("#tabs").is_visible()
    tab = page.tab = page.new_tab(f"file://{tmp_path}/two.html")
    buttons = tab.get_by_role("group", name="Chain that the views show").get_by_role("button")
    assert buttons.all_inner_texts() == ["Chain A", "Chain B"]
    tab.click("summary:has-text('Chain file')")
    for slot, document in (("B", "0.5, 1.0"), ("A", "beads = 12")):
        tab.click(f"#tab-{slot}")
        tab.evaluate(NEXT_FRAME)
        assert page.status().startswith(f"Chain {slot}: ")
        assert tab.inner_text("#h-map") == f"Space and time, chain {slot}"
        assert document in tab.inner_text("#chain-file")
        assert buttons.nth("AB".index(slot)).get_attribute("aria-pressed") == "true"


@pytest.mark.long
def test_a_saved_page_has_no_empty_panel_and_no_hint_about_changes(page, tmp_path):
    chain = hc.Chain.uniform(12)
    hc.save_page(chain, tmp_path / "free.html")
    hc.save_page(chain, tmp_path / "sensor.html", sensors=[4], other=chain.struck_by())
    tab = page.new_tab(f"file://{tmp_path}/free.html")
    assert not tab.locator("#h-force").is_visible()
    assert not tab.locator("#errors").is_visible()
    tab = page.tab = page.new_tab(f"file://{tmp_path}/sensor.html")
    tab.locator("#h-force").wait_for()
    tab.locator("#errors").wait_for()
    x, y, r = tab.evaluate("hertzchain.placeOf('A', 6)")
    tab.mouse.move(x, y - r)
    assert "resize" not in tab.evaluate("document.getElementById('stage-A').style.cursor")
    tab.mouse.down()
    tab.mouse.move(x, y - 2 * r)
    tab.mouse.up()
    tab.focus("#lane-A")
    for key in ("s", "ArrowUp", "ArrowDown", "Control+z"):
        tab.keyboard.press(key)
    assert tab.evaluate("hertzchain.state.view.sensors") == [4]
    assert "with_defects" not in page.document()["chain"]
    tab.keyboard.press("?")
    shown = tab.inner_text("body")
    assert "play or pause" in shown
    assert not re.search("sensor in the chosen|its radius|undo|Click a bead|Compare ", shown)


@pytest.mark.long
def test_no_empty_panel_of_forces_on_a_phone(browser, running):
    page = Page(browser, running, viewport={"width": 400, "height": 800})
    tab = page.tab
    assert tab.locator("#h-force").is_visible()
    page.tab = page.new_tab(f"{page.origin}#taper=uniform&beads=9")
    assert not page.tab.locator("#h-force").is_visible()
    page.tab.click("#sensor")
    page.settle()
    assert page.tab.locator("#chart-force path").count() == 1
    assert page.tab.locator("#h-force").is_visible()
    page.context.close()
    assert page.problems == []


def test_beads_of_several_materials_have_rings_and_a_legend(page):
    names = ["ptfe", "steel-316", "brass", "glass", "nylon", "rubber"]
    chain = f"#radii=5+mm&beads=6&materials={json.dumps(names)}&velocity=0.1+m/s"
    tab = page.new_tab(page.origin + chain.replace(" ", ""))
    assert tab.locator("#title-A .key").all_text_contents() == [f"{each}, 10 mm" for each in names]
    # The lowest point of each ring.
    colours = tab.evaluate("""() => {
      const canvas = document.getElementById("stage-A"), box = canvas.getBoundingClientRect();
      const pen = canvas.getContext("2d");
      const { width, data } = pen.getImageData(0, 0, canvas.width, canvas.height);
      return [1, 2, 3, 4, 5].map(bead => {
        const [x, y, r] = hertzchain.placeOf("A", bead), row = Math.round(y - box.top + 0.88 * r);
        return data.slice(4 * (row * width + Math.round(x - box.left))).slice(0, 3).join();
      });
    }""")
    styles = tab.locator("#title-A .ring").evaluate_all(
        """rings => rings.map(each => getComputedStyle(each)).map(
            style => [style.color, style.borderTopStyle])"""
    )
    assert colours == [re.sub(r"[^0-9,]", "", each) for each, _ in styles[:5]]
    assert len(set(colours)) == 5
    # Further materials have the same colours, but other rings.
    assert styles[5] == [styles[0][0], "dashed"]
    assert page.tab.locator("#title-A .key").count() == 0


def test_a_material_has_the_same_colour_in_both_chains(page):
    chains = [["ptfe", "brass"], ["glass", "brass", "ptfe"]]
    pairs = []
    for slot, each in zip(("", "b."), chains, strict=True):
        values = {"radii": "5+mm", "velocity": "0.1+m/s", "beads": len(each)}
        values["materials"] = json.dumps(each)
        pairs += [f"{slot}{name}={value}" for name, value in values.items()]
    tab = page.new_tab(page.origin + "#" + "&".join(pairs).replace(" ", ""))
    shown = [
        dict(tab.locator(f"#title-{slot} .key").evaluate_all(
            "keys => keys.map(each => [each.textContent, each.firstChild.style.color])"))
        for slot in "AB"
    ]  # fmt: skip
    assert list(shown[0]) == ["ptfe, 10 mm", "brass, 10 mm"]
    assert shown[0].items() < shown[1].items()
    assert len(set(shown[1].values())) == 3


def test_the_map_of_forces_has_the_scale_of_forces(page):
    def shown():
        page.tab.evaluate(NEXT_FRAME)
        bar = page.tab.evaluate("getComputedStyle(document.querySelector('.bar')).backgroundImage")
        names = page.tab.inner_text("#map-scale"), page.tab.inner_text(".scale")
        return [" ".join(each.split()) for each in names], bar.count("rgb")

    assert shown() == (["of each bead of all beads", "back forwards"], 5)
    page.tab.select_option("#map-of", "forces")
    # Forces are not negative: the bar has no colours of backward motion.
    assert shown() == (["of each contact of all contacts", "0 largest"], 3)
    # Bead k is between contacts k - 1 and k, and contacts 0 .. 40 have columns.
    box = page.tab.locator("#map").bounding_box()
    left, right = 52, 16
    wide = box["width"] - left - right
    page.tab.mouse.click(box["x"] + left + 30 / 41 * wide, box["y"] + 50)
    page.tab.evaluate(NEXT_FRAME)
    assert page.tab.input_value("#bead") == "30"


def test_colours_of_beads_are_continuous_at_rest(page):
    colours = page.tab.evaluate(
        """async () => {
          const { STEPS, COLOURS } = await import("/js/colour.js");
          return [COLOURS.bead, ...STEPS].map(each => each.match(/\\d+/g).map(Number));
        }"""
    )
    assert colours[0] == colours[1 + 256]
    assert np.abs(np.diff(colours[1:], axis=0)).max() < 20


@pytest.mark.long
def test_small_forces_can_be_seen_next_to_large_ones(page):
    wall = "right_wall.material=rubber&~sensors=[3]"
    row = "#diameters=12+mm&beads=10&materials=steel-52100&velocity=0.3+m/s&"
    tab = page.new_tab(page.origin + row + wall)
    heights = """[...document.querySelectorAll("#chart-force path")].map(each => {
        const ys = each.getAttribute("d").match(/ [0-9.]+/g).map(Number);
        return Math.max(...ys) - Math.min(...ys); })"""
    sensor, weak = tab.evaluate(heights)
    assert weak < 0.2 * sensor
    tab.select_option("#force-scale", "each")
    tab.wait_for_selector("#chart-force text:has-text('relative to the largest of each curve')")
    sensor, relative = tab.evaluate(heights)
    assert relative == pytest.approx(sensor, abs=0.2)
    tab.select_option("#force-scale", "log")
    tab.wait_for_selector("#chart-force text:has-text('force [N]')")
    sensor, logarithmic = tab.evaluate(heights)
    assert 0.5 * sensor < logarithmic < sensor
    assert "~forces=log" in tab.evaluate("location.hash")


def test_the_legend_states_the_force_with_contacts_that_yield(page):
    row = "#diameters=12+mm&beads=10&materials=steel-316&velocity=2+m/s&right_wall.rigid=true"
    tab = page.new_tab(page.origin + row)
    assert re.search(
        r"peak 1\.\d+ kN at .* µs; peak if contacts yield at 1\.6 Y 0\.0\d+ kN",
        tab.text_content("#legend-force"),
    )
    warning = tab.text_content("#warnings-count")
    assert warning.startswith(
        "2 warnings: Contacts would be dented, and forces may be lower: pressure / yi"
    )
    # Contacts that hardly yield do not change the peak.
    row = "#diameters=10+mm&beads=10&materials=steel-52100&velocity=0.43+m/s"
    row += "&right_wall.material=steel-52100"
    legend = page.new_tab(page.origin + row).text_content("#legend-force")
    assert re.search(r"; peak if contacts yield at 1\.6 Y: the same(;|$)", legend), legend


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
def test_the_comparison_has_the_peaks_if_contacts_yield_and_the_warnings_of_both_chains(page):
    row = "diameters=12+mm&beads=10&materials={}&velocity=2+m/s&right_wall.rigid=true"
    second = "&".join(f"b.{each}" for each in row.format("ptfe").split("&"))
    view = "&~errors=difference&~sensors=[8]"
    tab = page.new_tab(f"{page.origin}#{row.format('steel-316')}&{second}{view}")
    rows = [each.split("\t") for each in tab.locator("#legend-error tr").all_inner_texts()]
    found = {label.partition(" [")[0]: numbers for label, *numbers in rows}
    assert list(found)[1:11] == [
        "sensor in bead 8, first maximum", "sensor in bead 8, time of first maximum",
        "sensor in bead 8, largest", "sensor in bead 8, time of largest", "right wall, peak",
        "right wall, time of peak", "right wall, peak if contacts yield at 1.6 Y",
        "right wall, peak if contacts yield at 2.8 Y", "right wall, impulse of the impact",
        "right wall, duration (impulse / peak)",
    ]  # fmt: skip
    walls = [
        hc.simulate(chain_of(tab.evaluate(f"hertzchain.state.{slot}")), check=False).wall_force()
        for slot in "AB"
    ]
    for name, of in (("impulse of the impact", "impulse_of_impact"),
                     ("duration (impulse / peak)", "duration")):  # fmt: skip
        a, b = (getattr(wall, of) for wall in walls)
        assert float(found[f"right wall, {name}"][2]) == pytest.approx(b / a, rel=1e-3)
    # The unit is that of a single chain.
    duration = f"{1e6 * walls[0].duration:#.4g}"
    assert found["right wall, duration (impulse / peak)"][0] == duration
    assert f"duration (impulse / peak) {duration} µs" in tab.text_content("#legend-force")
    peaks = [page_peaks(tab, slot)["right"] for slot in "AB"]
    assert all(each["yielding"] < each["first"] for each in peaks)
    a, b = (each["yielding"] for each in peaks)
    assert found["right wall, peak if contacts yield at 1.6 Y"][2] == f"{b / a:#.4g}"
    legend = tab.text_content("#legend-force")
    assert "; the largest in this run" in legend
    assert "peak if contacts yield" in legend
    # The warnings are drawn in the frame after the last message.
    # For polymers, the limit is cautious.
    for words in ("A: Contacts would be dented", "B: Pressure / yield is"):
        tab.wait_for_selector(f"#warnings:has-text('{words}')", state="attached")
    # A chain that does not yield is compared by its peak.
    slow = second.replace("2+m/s", "1+mm/s")
    tab = page.new_tab(f"{page.origin}#{row.format('steel-316')}&{slow}{view}")
    rows = [each.split("\t") for each in tab.locator("#legend-error tr").all_inner_texts()]
    found = {label.partition(" [")[0]: numbers for label, *numbers in rows}
    a, b = (page_peaks(tab, slot)["right"] for slot in "AB")
    ratio = found["right wall, peak if contacts yield at 1.6 Y"][2]
    assert float(ratio.replace("−", "-")) == pytest.approx(b["first"] / a["yielding"], rel=5e-3)
    # It has the same peak at any yield pressure.
    at_most = found["right wall, peak if contacts yield at 2.8 Y"][1]
    assert at_most == found["right wall, peak if contacts yield at 1.6 Y"][1] != "–"


def test_a_row_and_a_column_are_compared_by_their_largest_forces(page):
    row = (
        "diameters=10+mm&beads=10&materials=steel-52100&velocity=0.1+m/s&right_wall.material=brass"
    )
    column = "&".join(f"b.{each}" for each in f"{row}&gravity=9.81+m/s%5E2".split("&"))
    tab = page.new_tab(f"{page.origin}#{row}&{column}&~errors=difference")
    rows = [each.split("\t") for each in tab.locator("#legend-error tr").all_inner_texts()]
    found = {label.partition(" [")[0]: numbers for label, *numbers in rows}
    a, b = (page_peaks(tab, slot)["right"]["largest"] for slot in "AB")
    assert found["right wall, largest"][2] == f"{b / a:#.4g}"


def page_peaks(tab, slot):
    return tab.evaluate(f"hertzchain.results.{slot}.run.header.peaks")


def test_negative_residence_times_are_explained_below_the_table(page):
    tab = page.new_tab(page.origin + '#cell=["20+mm","4+mm"]&cells=4'
                       "&materials=steel-52100&velocity=10+mm/s")  # fmt: skip
    tab.click("#table-details summary")
    tab.wait_for_selector("#table:has-text('residence: negative where')")


def test_the_table_has_the_pressure_of_each_contact(page):
    row = ('["6+mm","4+mm","5+mm"]&materials=steel-52100&velocity=0.2+m/s'
           '&right_wall={"material":"steel-52100"}')  # fmt: skip
    tab = page.new_tab(f"{page.origin}#diameters={row}")
    tab.click("#table-details summary")
    tab.wait_for_selector("#table th:has-text('largest pressure / yield')")
    head, *rows = [each.split("\t") for each in tab.locator("#table tr").all_inner_texts()]
    columns = dict(zip(head, zip(*rows, strict=True), strict=True))
    shown = [float(each) for each in columns["largest pressure / yield, contact k"]]
    chain = hc.Chain.from_materials(
        diameters=["6 mm", "4 mm", "5 mm"], materials="steel-52100", velocity="0.2 m/s",
        right_wall=hc.Wall.of("steel-52100"),
    )  # fmt: skip
    overlaps = hc.simulate(chain, times=0, check=False).largest_overlaps
    assert shown == pytest.approx(hc.hertz_range(chain, overlaps).yield_ratio[1:], rel=1e-3)
    # Units have prefixes; the last contact is that with the wall.
    assert columns["radius [mm]"] == ("3", "2", "2.5")
    assert [float(each) for each in columns["mass [mg]"]] == pytest.approx(1e6 * chain.masses)
    run = hc.simulate(chain, rtol=1e-9)
    forces = chain.contact_stiffness * run.largest_overlaps**1.5
    assert [float(each) for each in columns["largest force, contact k [N]"]] == pytest.approx(
        forces[1:], rel=1e-5
    )
    speeds = [float(each) for each in columns["velocity, leading pulse [mm/s]"]]
    assert speeds == pytest.approx(1e3 * run.pulse().velocity, rel=1e-4)


def test_the_run_can_be_continued_to_the_final_velocities(page, tmp_path):
    page.tab.click("#open-examples")
    page.tab.click('button[aria-label="Open Newton\'s cradle"]')
    page.settle()
    assert page.tab.input_value("#until") == "1"
    assert page.tab.text_content("#until-unit") == "ms"
    page.tab.click("#table-details summary")

    def column(tab):
        tab.evaluate(NEXT_FRAME)
        heads = tab.locator("#table th[scope=col]").all_text_contents()
        place = next(i for i, each in enumerate(heads) if each.startswith("velocity at the end"))
        cells = tab.locator(f"#table tbody td:nth-child({place + 1})").all_text_contents()
        return heads[place].partition("[")[2], cells

    unit, cells = column(page.tab)
    assert unit == "mm/s]"
    # Errors of the simulation, below 1e-7 of the largest velocity, are not shown.
    assert cells == ["0", "0", "0", "100", "100"]
    assert "Velocity at the end" not in page.tab.inner_text("#table")
    with page.tab.expect_download() as saving:
        page.tab.click("#open-share")
        page.tab.click("[data-export=page]")
    saving.value.save_as(tmp_path / "cradle.html")
    page.tab.keyboard.press("Escape")
    saved = page.new_tab((tmp_path / "cradle.html").as_uri())
    saved.click("#table-details summary")
    assert column(saved) == (unit, cells)
    page.tab.fill("#until", "")
    page.tab.keyboard.press("Tab")
    page.settle()
    assert column(page.tab)[1] == ["–"] * 5
    note = "1 contact still closed, so velocities are not final; increase “Run until”."
    assert note in page.tab.inner_text("#table")


@pytest.mark.parametrize("given", ["-1", "0"])
def test_ends_of_the_run_that_cannot_be_used_are_removed(page, given):
    page.tab.fill("#until", given)
    page.tab.keyboard.press("Enter")
    assert page.tab.input_value("#until") == ""
    page.tab.fill("#until", "3")
    page.tab.keyboard.press("Enter")
    assert page.tab.input_value("#until") == "3"


def test_a_saved_page_contains_the_chain_files_and_definitions(page, tmp_path):
    example = EXAMPLES["Shock absorber"]
    file = tmp_path / "absorber.html"
    write_page(example["document"], example["other"], [], file)
    saved = page.new_tab(file.as_uri())
    saved.click("summary:has-text('Chain file')")
    for slot, document in (("A", example["document"]), ("B", example["other"])):
        saved.press(f"#lane-{slot}", "Home")
        saved.evaluate(NEXT_FRAME)
        assert saved.text_content("#status").startswith(f"Chain {slot}: ")
        text = saved.inner_text("#chain-file")
        assert tomllib.loads(text) == document
        assert 'law = "restitution"' in text
    keys = saved.locator("#legend-budget .key").evaluate_all(
        "es => es.map(e => [e.innerText, e.title])"
    )
    assert ["lagging", "All other beads that move away from the impact"] in keys
    assert all(title for _, title in keys)


def test_invalid_input_is_explained_next_to_its_control(page):
    before = page.array("run", "times")
    page.tab.fill("[id='c-chain.rate']", "2")
    page.settle()
    with pytest.raises(hc.InputError) as error:
        chain_of(page.document())
    assert page.tab.text_content("#problem") == str(error.value) == page.status()
    row = page.tab.locator(".row:has([id='c-chain.rate']) + #problem")
    assert row.count() == 1
    rate = page.tab.locator("[id='c-chain.rate']")
    assert rate.get_attribute("aria-invalid") == "true"
    # There are no files of a chain with an error.
    page.tab.click("#open-share")
    assert page.tab.locator("[data-export]:enabled").count() == 0
    assert page.tab.text_content("#share-status") == str(error.value)
    page.tab.keyboard.press("Escape")
    assert rate.get_attribute("aria-errormessage") == "problem"
    assert page.tab.evaluate("document.body.classList.contains('stale')")
    assert np.array_equal(page.array("run", "times"), before)
    page.tab.fill("[id='c-chain.rate']", "0.06")
    page.settle()
    assert not page.tab.locator("#problem").is_visible()
    assert not rate.get_attribute("aria-invalid")
    assert not rate.get_attribute("aria-describedby")
    check_numbers(page)


def test_errors_are_marked_at_their_fields_until_they_are_corrected(page):
    page.tab = page.new_tab(f"{page.origin}#diameters=20+mm&beads=6&materials=brass&velocity=1+m/s"
                            "&loss.law=restitution&loss.coefficient=0.9")  # fmt: skip
    page.tab.click("#group-more summary")
    for name, text, wrong in (
        ("gaps", "0,1 um,0,0 um", ["gaps"]),
        ("loss.coefficient", "0.93", ["gaps"]),
        ("velocity", "0.2 kg", ["velocity", "gaps"]),
        ("gaps", "0,0,0,1.2 um,0", ["velocity"]),
        ("loss.coefficient", "1.9", ["velocity"]),
        # The unit of the velocity is checked before the range of the coefficient.
        ("velocity", "0.2", ["loss.coefficient"]),
        ("loss.coefficient", "0.9", []),
    ):
        box = page.tab.locator(f"[id='c-chain.{name}']")
        box.fill(text)
        box.press("Enter")
        page.settle()
        marked = "document.querySelectorAll('[aria-invalid]')"
        found = page.tab.evaluate(f"[...{marked}].map(each => each.id)")
        assert found == [f"c-chain.{each}" for each in wrong]
        assert page.tab.is_visible("#problem") == bool(wrong)
        if len(wrong) == 2:
            first, *lines = page.tab.inner_text("#problem").split("\n")
            assert first == "2 errors:"
            assert lines[0].startswith("velocity must have a unit")
            assert lines[1].endswith("or a blank after each comma of a list")
            assert page.tab.inner_text("#status").split("\n")[1:] == lines
    assert chain_of(page.document()).gaps[3] == pytest.approx(1.2e-6)


def test_files_are_saved_and_opened(page, tmp_path):
    def save(selector):
        page.tab.click("#open-share")
        with page.tab.expect_download() as download:
            page.tab.click(selector)
        path = tmp_path / download.value.suggested_filename
        download.value.save_as(path)
        return path

    chain_file = save("[data-export=toml]")
    # The dialog remains open for further files.
    assert page.tab.text_content("#share-status") == "Saved chain.toml."
    assert page.tab.text_content("#share-of") == chain_of(page.document()).description
    assert hc.load_chain(chain_file).description == chain_of(page.document()).description
    chain_file.write_text('[chain]\ntaper = "uniform"\nbeads = 12\nright_wall = {rigid = true}\n')
    open_file(page, chain_file)
    table = {"taper": "uniform", "beads": 12, "right_wall": {"rigid": True}}
    assert "undefined" not in page.tab.text_content("body")
    assert page.document() == {"chain": table}
    chain_file.write_text("[chain]\nbead = 12\n")
    page.tab.set_input_files("#file", chain_file)
    page.tab.wait_for_selector("#status.bad")
    assert "bead" in page.status()
    saved = save("[data-export=page]")
    velocity = page.array("pulse", "exact.velocity")
    page.tab.goto(f"file://{saved}")
    page.tab.wait_for_selector("#chart-pulse path.exact")
    assert np.array_equal(page.array("pulse", "exact.velocity"), velocity)
    page.tab.click("#play")
    page.tab.wait_for_timeout(200)
    assert page.tab.evaluate("hertzchain.u") > 0.0


HOST = """
<div id="cell"></div><script type="module">
  import widget from "/frame.js";
  const listeners = [];
  const model = {
    get: name => name === "page" ? window.page : 900,
    on: (name, action) => listeners.push(action), off: () => {},
    send: message => window.kernel(JSON.stringify(message)),
  };
  window.receive = (content, buffers) => {
    const views = buffers.map(text => new DataView(Uint8Array.from(atob(text), c => c.charCodeAt(0)).buffer));
    for (const action of listeners) action({content}, views);
  };
  window.show = page => { window.page = page; widget.render({ model, el: document.getElementById("cell") }); };
</script>"""  # noqa: E501


def test_the_page_works_in_a_notebook(browser):
    document = {"chain": {"taper": "uniform", "beads": 15}}
    context = browser.new_context(reduced_motion="reduce")
    tab, sent = context.new_page(), []
    talk = Conversation(document, lambda content, buffers: sent.append((content, buffers)))
    tab.expose_function("kernel", lambda text: talk.receive(json.loads(text)))
    frame_js = (files("hertzchain.app") / "notebook_frame.js").read_text("utf-8")
    bodies = {"/": ("text/html", HOST), "/frame.js": ("text/javascript", frame_js)}

    def answer(route):
        kind, body = bodies[route.request.url.removeprefix("http://notebook.test")]
        route.fulfill(body=body, content_type=kind)

    tab.route("http://notebook.test/**", answer)
    tab.goto("http://notebook.test/")
    page = embedded_page({"kind": "notebook", "about": finite(about(document))}).decode()
    tab.evaluate("page => window.show(page)", page)
    frame = tab.frames[-1]

    def relay(done):
        for _ in range(400):
            while sent:
                content, buffers = sent.pop(0)
                tab.evaluate(
                    "([content, buffers]) => receive(content, buffers)",
                    [content, [base64.b64encode(each).decode() for each in buffers]],
                )
            if done():
                return
            tab.wait_for_timeout(25)
        raise AssertionError(frame.text_content("#status"))

    relay(lambda: frame.locator(SETTLED).count() == 1)
    frame.fill("[id='c-chain.beads']", "22")
    relay(lambda: talk.documents["A"]["chain"]["beads"] == 22)
    relay(lambda: frame.locator(SETTLED).count() == 1)
    shown = frame.evaluate(ARRAY, ["A", "pulse", "exact.velocity"])
    assert np.array_equal(shown, hc.propagate(chain_of(talk.documents["A"])).velocity)
    context.close()


def test_everything_is_reachable_by_keyboard(page):
    page.tab.focus("[id='c-chain.rate']")
    page.tab.keyboard.press("Tab")
    for _ in range(3):
        page.tab.keyboard.press("ArrowRight")
    page.settle()
    assert page.document()["chain"]["rate"] > 0.05
    check_numbers(page)
    page.tab.focus("#lane-A")
    page.tab.keyboard.press("Home")
    page.tab.keyboard.press("ArrowRight")
    page.tab.keyboard.press("ArrowUp")
    page.settle()
    assert page.document()["chain"]["with_defects"][0]["bead"] == 2
    page.tab.keyboard.press("s")
    page.settle()
    assert 2 in page.tab.evaluate("hertzchain.state.view.sensors")
    page.tab.keyboard.press("Space")
    assert page.tab.evaluate("hertzchain.playing")
    page.tab.keyboard.press("?")
    assert page.tab.locator("#help").is_visible()
    page.tab.keyboard.press("Escape")
    reached = set()
    page.tab.evaluate("document.activeElement.blur()")
    for _ in range(80):
        page.tab.keyboard.press("Tab")
        reached.add(page.tab.evaluate("document.activeElement.id"))
    needed = {"open-examples", "compare", "open-share", "theme", "play", "time", "speed", "camera",
              "bead", "sensor", "map-of", "quantity", "log", "errors", "budget-of",
              "lane-A"}  # fmt: skip
    assert needed <= reached


def test_letters_typed_in_a_list_choose_an_entry(page):
    sensors = page.tab.evaluate("hertzchain.state.view.sensors")
    page.tab.focus("#quantity")
    for letter in "sf":
        page.tab.keyboard.press(letter)
    assert page.tab.evaluate("hertzchain.state.view.sensors") == sensors
    assert page.tab.evaluate("hertzchain.state.view.camera") == "whole"
    page.tab.fill("[id='c-chain.beads']", "25")
    page.settle()
    page.tab.focus("#quantity")
    page.tab.keyboard.press("Control+z")
    page.settle()
    assert page.document()["chain"]["beads"] == 40


def test_the_address_is_updated_after_skipping_to_the_chain(page):
    page.tab.focus(".skip")
    page.tab.keyboard.press("Enter")
    assert page.tab.evaluate("location.hash") == "#lane-A"
    page.tab.fill("[id='c-chain.beads']", "25")
    page.settle()
    assert "beads=25" in page.tab.evaluate("location.hash")


def test_the_time_that_is_shown_is_not_announced(page):
    announced = page.tab.get_by_role("status")
    assert [each.get_attribute("id") for each in announced.all()] == ["status"]


def test_motion_is_reduced_if_the_system_says_so(browser, running, page):
    assert not page.tab.evaluate("hertzchain.playing")
    moving = Page(browser, running, reduced_motion="no-preference")
    assert moving.tab.evaluate("hertzchain.playing")
    moving.context.close()


@pytest.mark.parametrize("width", [400, 1600])
def test_nothing_overflows(browser, running, width):
    page = Page(browser, running, viewport={"width": width, "height": 800})
    for action in ("", "document.getElementById('compare').click()", OPEN_ALL):
        page.tab.evaluate(action)
        page.settle()
        assert page.tab.evaluate("document.documentElement.scrollWidth") <= width
    # On a phone, the forces and the controls are next to the chain.
    parts = ("#lane-A", "#chart-force", "#controls", "#map", "#chart-pulse")
    tops = [page.tab.locator(each).bounding_box()["y"] for each in parts]
    if width == 400:
        assert tops == sorted(tops)
    page.context.close()
    assert page.problems == []


PLACE_OF_FOCUS = """() => {
  const { id } = document.activeElement, place = document.activeElement.closest(".card, #controls");
  return [id, place && place.getBoundingClientRect().top + scrollY];
}"""


# Whether the controls are behind the chain in the document, as on narrow screens.
CONTROLS_BEHIND = """wanted => {
  const chain = document.getElementById("lane-A"), controls = document.getElementById("controls");
  const behind = chain.compareDocumentPosition(controls) & Node.DOCUMENT_POSITION_FOLLOWING;
  return Boolean(behind) === wanted;
}"""


def test_the_keyboard_follows_the_order_on_the_screen(browser, running):
    page = Page(browser, running, viewport={"width": 400, "height": 800})
    tab = page.tab

    def reached():
        tab.evaluate("document.activeElement.blur()")
        tab.focus("#open-help")
        found = []
        while True:
            tab.keyboard.press("Tab")
            name, top = tab.evaluate(PLACE_OF_FOCUS)
            if top is None:
                return found
            found.append((name, top))

    narrow = reached()
    tops = [top for _, top in narrow]
    assert tops == sorted(tops)
    names = [name for name, _ in narrow]
    order = ["lane-A", "play", "force-scale", "c-form", "c-chain.beads", "map-of", "quantity"]
    assert [name for name in names if name in order] == order
    # The controls are to the left of the chain in a wide window.
    tab.set_viewport_size({"width": 1200, "height": 800})
    tab.wait_for_function(CONTROLS_BEHIND, arg=False)
    names = [name for name, _ in reached()]
    order = ["c-form", "c-chain.beads", "lane-A", "play", "map-of", "force-scale", "quantity"]
    assert [name for name in names if name in order] == order
    tab.set_viewport_size({"width": 400, "height": 800})
    tab.wait_for_function(CONTROLS_BEHIND, arg=True)
    assert reached() == narrow
    page.context.close()
    assert page.problems == []


# Extent of the curve of the velocities above and below its axis, at two beads.
EXTENTS = """() => {
  const canvas = document.getElementById("stage-A"), pen = canvas.getContext("2d");
  const { data, width, height } = pen.getImageData(0, 15, canvas.width, 0.36 * canvas.height - 15);
  const { left } = canvas.getBoundingClientRect();
  return [1, 5].map((bead) => {
    const x = Math.round(hertzchain.placeOf("A", bead)[0] - left);
    const rows = [...Array(height).keys()].filter((y) => data[4 * (y * width + x) + 3]);
    return [rows[0], rows.at(-1)];
  });
}"""


def test_the_curve_of_velocities_has_one_scale_in_both_directions(page):
    tab = page.new_tab(f"{page.origin}#taper=uniform&beads=5&velocities=[1,0,0,0,-1]")
    tab.evaluate(NEXT_FRAME)
    (top, _), (axis, bottom) = tab.evaluate(EXTENTS)
    assert axis - top > 20
    assert bottom - axis == pytest.approx(axis - top, abs=2)


def test_a_new_defect_is_the_chosen_bead(page):
    page.tab.fill("#bead", "7")
    page.tab.keyboard.press("Enter")
    page.tab.click("summary:has-text('Defects')")
    page.tab.click("#add-with_defects")
    page.settle()
    (defect,) = page.document()["chain"]["with_defects"]
    assert defect["bead"] == 7
    own = page.array("beads", "radii")[7]
    assert defect["radius"] == pytest.approx(1.5 * own, rel=0.3)


LISTEN_TO_CANVASES = """() => {
  const pens = CanvasRenderingContext2D.prototype, fill = pens.fillText;
  window.texts = [];
  pens.fillText = function (text, ...rest) {
    window.texts.push(text);
    return fill.call(this, text, ...rest);
  };
}"""


def test_the_size_of_a_bead_is_shown_while_it_is_dragged(page):
    tab = page.tab = page.new_tab(f"{page.origin}#diameters=20+mm&beads=9&materials=steel-52100")
    tab.evaluate(LISTEN_TO_CANVASES)
    x, y, radius = tab.evaluate("hertzchain.placeOf('A', 5)")
    tab.mouse.move(x, y - radius + 1)
    tab.mouse.down()
    tab.mouse.move(x, y - 1.3 * radius, steps=3)
    page.settle()
    diameter = 2e3 * page.array("beads", "radii")[4]
    assert diameter > 22.0
    assert tab.evaluate("window.texts").count(f"bead 5, {diameter:.4g} mm") >= 1
    tab.mouse.up()
    tab.evaluate("window.texts.length = 0")
    page.settle()
    tab.evaluate(NEXT_FRAME)
    assert not [text for text in tab.evaluate("window.texts") if text.startswith("bead 5,")]


def test_a_diameter_replaces_a_radius_and_vice_versa(page):
    tab = page.new_tab(f"{page.origin}#diameters=20+mm&beads=9&materials=steel-52100")
    page.tab = tab
    tab.click("summary:has-text('Defects')")
    tab.click("#add-with_defects")
    page.settle()
    # A diameter, as those of the chain, 1.5 times as large.
    (defect,) = page.document()["chain"]["with_defects"]
    assert (defect["diameter"], "radius" in defect) == ("30 mm", False)
    for name, other, size in (("radius", "diameter", "15 mm"), ("diameter", "radius", "24 mm")):
        choice = tab.locator("[id='c-chain.with_defects.0.radius-by']")
        choice.select_option(name)
        page.settle()
        (defect,) = page.document()["chain"]["with_defects"]
        assert (defect[name], other in defect) == (size, False)
        assert tab.locator(f"[id='c-chain.with_defects.0.{other}']").count() == 0
        tab.fill(f"[id='c-chain.with_defects.0.{name}']", "12")
        tab.keyboard.press("Tab")
        page.settle()
        (defect,) = page.document()["chain"]["with_defects"]
        assert (defect[name], other in defect) == ("12 mm", False)
        assert page.status().startswith("The run ends")


def test_the_budget_of_a_compressed_chain_is_that_over_the_static_state(page):
    held = "&precompression=0.5&held_by=force&right_wall.rigid=true"
    tab = page.new_tab(f"{page.origin}#taper=uniform&beads=12{held}")
    assert tab.text_content("#chart-budget text.label:last-child") == "excess energy"
    assert "Excess over the static state" in tab.text_content("#legend-budget")
    tab.select_option("#budget-of", "momentum")
    tab.evaluate(NEXT_FRAME)
    assert tab.text_content("#chart-budget text.label:last-child") == "momentum"
    assert "Excess" not in tab.text_content("#legend-budget")
    # Nothing moves: there is no older budget either.
    tab.select_option("#budget-of", "energy")
    tab = page.new_tab(f"{page.origin}#taper=uniform&beads=12&velocities=0{held}")
    assert tab.inner_text("#chart-budget .nothing") == "Nothing moves."


def test_a_saved_page_has_its_file_after_the_description(page, tmp_path):
    chain = hc.Chain.uniform(12)
    document = tomllib.loads('[chain]\ntaper = "uniform"\nbeads = 12\n')
    write_page(document, document, [], tmp_path / "page.html", {"A": "one.toml", "B": "two.toml"})
    tab = page.tab = page.new_tab(f"file://{tmp_path}/page.html")
    assert tab.title() == f"{chain.description} – one.toml – hertzchain"
    for slot, name in (("A", "one.toml"), ("B", "two.toml")):
        heading = tab.locator(f"#title-{slot}")
        assert heading.text_content() == f"{slot}: {chain.description}{name}"
        assert heading.locator("small").text_content() == name


def test_forced_colours_keep_states_and_legends(browser, running):
    page = Page(browser, running, forced_colors="active")
    colours = page.tab.evaluate("""() => {
      const of = (each) => getComputedStyle(each).backgroundColor;
      const all = (what) => [...document.querySelectorAll(what)].map(of);
      return [all("#sensor, #open-share"), all("#legend-budget .swatch")];
    }""")
    assert [len(set(each)) == len(each) > 1 for each in colours] == [True, True], colours
    page.context.close()
    assert page.problems == []


@pytest.mark.skipif(
    not AXE.exists(), reason="axe-core is not installed (npm install in tools/page)"
)
@pytest.mark.parametrize(("scheme", "width"), [("light", 1280), ("dark", 1280), ("light", 400)])
def test_no_violations_of_accessibility(browser, running, scheme, width):
    viewport = {"width": width, "height": 900}
    page = Page(browser, running, color_scheme=scheme, viewport=viewport)
    tab = page.tab

    def check(name):
        found = tab.evaluate("axe.run({resultTypes: ['violations']}).then(r => r.violations)")
        assert [(each["id"], each["nodes"][0]["html"]) for each in found] == [], name

    tab.evaluate(AXE.read_text("utf-8"))
    for dialog in ("examples", "share", "help") if scheme == "light" else ("share",):
        tab.click(f"#open-{dialog}")
        check(dialog)
        tab.keyboard.press("Escape")
    tab.evaluate(OPEN_ALL)
    tab.click("#compare")
    page.settle()
    check("everything open, two chains")
    tab.fill("[id='c-chain.rate']", "2")
    page.settle()
    check("invalid input")
    page.context.close()


def test_a_server_that_is_gone_is_reported_and_found_again(browser):
    first = RunningServer(0, warm_up=False)
    thread = first.start()
    page = Page(browser, first)
    cookie = first.app.guard.token
    first.stop()
    thread.join(5.0)
    page.tab.fill("[id='c-chain.beads']", "30")
    page.tab.wait_for_selector("#status.bad")
    assert "does not answer" in page.status()
    second = RunningServer(first.port, warm_up=False)
    second.app.guard.token = cookie
    thread = second.start()
    page.tab.wait_for_selector(SETTLED)
    assert page.array("beads", "radii").size == 30
    page.context.close()
    second.stop()
    thread.join(5.0)


ROW = "#diameters=12+mm&beads=12&materials=steel-52100&right_wall.material=steel-52100"


@pytest.mark.filterwarnings("ignore::hertzchain.ModelRangeWarning")
def test_a_striker_has_the_entered_velocity_of_the_impact(page):
    page.tab = page.new_tab(page.origin + ROW)
    field = page.tab.locator("[id='c-chain.velocity']")
    field.fill("0.25")
    field.press("Enter")
    page.settle()
    page.tab.click("#group-struck_by summary")
    page.tab.click("#add-struck_by")
    page.settle()
    chain = chain_of(page.document())
    assert chain.velocities.tolist() == [0.25] + 12 * [0.0]
    row = hc.Chain.from_materials(6e-3, "steel-52100", beads=12)
    struck = row.struck_by(velocity=0.25).replace(right_wall=hc.Wall.of("steel-52100"))
    peak = hc.simulate(struck, times=0, rtol=1e-9).wall_force().peak
    assert page.tab.evaluate("hertzchain.results.A.run.header.peaks.right.first") == peak
    assert "is not used" not in page.tab.text_content("#warnings")
    page.tab.click("text=Remove >> nth=0")
    page.settle()
    assert page.document()["chain"]["velocity"] == "0.25 m/s"
    assert "struck_by" not in page.document()["chain"]


def test_the_warning_about_dents_is_shown_first(page):
    tab = page.new_tab(f"{page.origin}{ROW}&velocity=0.25+m/s&struck_by.count=1")
    shown, folded = tab.text_content("#warnings-count"), tab.text_content("#warnings-list")
    assert shown.startswith("3 warnings: Contacts would be dented")
    assert folded.startswith(
        "The impact velocity, 0.25 m/s, is not used, because strikers hit a chain at rest; enter "
        "the velocity under Strikers"
    )
    assert "yield at 1.6 Y: the yield pressure is assumed to be 1.6" in folded
    # Of two chains, that whose controls are shown has the first warning.
    soft = "diameters=9+mm&beads=9&materials=brass&velocity=1+mm/s&struck_by.velocity=1+mm/s"
    second = "&".join(f"b.{each}" for each in soft.split("&"))
    tab = page.new_tab(f"{page.origin}{ROW}&velocity=0.25+m/s&struck_by.count=1&{second}")
    for slot, words in (("A", "A: Contacts would be dented"), ("B", "B: The impact velocity")):
        tab.click(f"#tab-{slot}")
        tab.wait_for_selector(f"#warnings-count:has-text('4 warnings: {words}')")


def test_constant_forces_have_no_times_in_a_comparison(page):
    row = "{0}diameters=10+mm&{0}beads=9&{0}materials=steel-52100&{0}velocity=0+m/s"
    held = row + "&{0}precompression={1}+N&{0}left_wall.rigid=true&{0}right_wall.rigid=true"
    chains = f"{held.format('', 15)}&{held.format('b.', 30)}"
    tab = page.new_tab(f"{page.origin}#{chains}&~errors=difference&~sensors=[4]")
    largest = "largest in this run (with the static force)"
    assert f"sensor in bead 4: {largest} 15.00 N" in tab.locator("#legend-force").inner_text()
    rows = dict(each.split("\t", 1) for each in tab.locator("#legend-error tr").all_inner_texts())
    assert rows["right wall, largest [N]"] == "15.00\t30.00\t2.000"
    assert not any("time of" in each for each in rows)


def test_the_spectrum_shows_bands_and_gaps(page):
    static = "velocity=0+m/s&precompression=15+N&held_by=force"
    crystal = f'cell=["10+mm","6+mm"]&cells=10&materials=steel-52100&{static}'
    tab = page.new_tab(f"{page.origin}#{crystal}")
    tab.click("text=Spectrum of small oscillations")
    tab.evaluate(NEXT_FRAME)
    spectrum = hc.spectrum(chain_of(tab.evaluate("hertzchain.state.A")))
    (_, low), (high, top) = spectrum.band_edges() / 1e3
    assert tab.text_content("#legend-modes") == (
        f"no plane wavesSound speed {spectrum.sound_speed:.4g} m/s; bands of an infinite chain "
        f"with the same cell: 0 to {low:.4g}, {high:.4g} to {top:.4g} kHz"
    )
    # The points of the modes give the scale of the axis.
    path = tab.get_attribute("#chart-modes path.modes", "d")
    heights = [float(each) for each in re.findall(r" ([\d.]+)h0", path)]
    slope, zero = np.polyfit(spectrum.frequencies / 1e3, heights, 1)
    shades = tab.locator("#chart-modes .shade").evaluate_all(
        "all => all.map(each => ['y', 'height'].map(name => Number(each.getAttribute(name))))"
    )
    # Upper and lower end of each shaded range.
    gap, above = (np.cumsum(shades, axis=1) - zero) / slope
    assert gap == pytest.approx([high, low], abs=0.01 * top)
    assert above[0] > 1.05 * top
    assert above[1] == pytest.approx(top, abs=0.01 * top)
    # Both axes have one scale; the curves are those of plane waves.
    curves = tab.locator("#chart-waves path.modes").evaluate_all(
        "all => all.map(each => each.getAttribute('d'))"
    )
    waves = 1e-3 * spectrum.bands(np.linspace(0.0, np.pi, 41)).T
    for curve, frequencies in zip(curves, waves, strict=True):
        points = np.array(re.findall(r"([\d.]+) ([\d.]+)", curve), float)
        assert (points[:, 1] - zero) / slope == pytest.approx(frequencies, abs=0.01 * top)
        assert np.ptp(np.diff(points[:, 0])) < 0.21
    # A taper does not repeat.
    taper = (
        f"taper=forward-exponential&rate=0.05&radius=5+mm&beads=9&materials=steel-52100&{static}"
    )
    tab = page.new_tab(f"{page.origin}#{taper}")
    assert tab.evaluate("hertzchain.results.A.run.arrays.has('modes.frequency')")
    assert tab.locator("#chart-modes .shade").count() == 0
    assert tab.text_content("#legend-modes") == ""
    assert not tab.locator("#chart-waves").is_visible()


def test_the_wall_can_be_dragged_at_all_its_places(page):
    page.tab = page.new_tab(page.origin + ROW)
    x, y, r = page.tab.evaluate("hertzchain.placeOf('A', 12)")
    cursor = "document.getElementById('stage-A').style.cursor"
    for place, shown in ((1, "ew-resize"), (4, "ew-resize"), (9, "ew-resize"), (-2, "nwse-resize")):
        page.tab.mouse.move(x + r + place, y)
        assert page.tab.evaluate(cursor) == shown
    page.tab.mouse.move(x + r + 2, y)
    page.tab.mouse.down()
    page.tab.mouse.move(x + r + 12, y)
    page.tab.mouse.move(x + r + 22, y)
    page.tab.mouse.up()
    page.settle()
    chain = page.document()["chain"]
    assert "with_defects" not in chain
    assert chain["right_wall"]["gap"].endswith(" mm")


# Left and right ends of the texts in the first line of a drawing.
CAPTIONS = """(id) => {
  const pen = document.getElementById(id).getContext("2d"), { fillText } = pen, found = [];
  pen.fillText = function (text, x, y) {
    const wide = this.measureText(text).width, left = this.textAlign === "right" ? x - wide : x;
    if (y === 10) found.push([left, left + wide]);
    fillText.call(this, text, x, y);
  };
  document.getElementById("speed").dispatchEvent(new Event("change"));
  return new Promise((done) => setTimeout(() => done(found), 200));
}"""


@pytest.mark.parametrize("diameter", ["20+mm", "12+mm", "10+mm", "3+mm"])
def test_nothing_overlaps_or_wraps_on_a_phone(browser, running, diameter):
    page = Page(browser, running, viewport={"width": 360, "height": 800})
    row = f"#diameters={diameter}&beads=20&materials=steel-52100&velocity=0.1+m/s"
    tab = page.new_tab(page.running.address.partition("#")[0] + row)
    found = tab.evaluate(CAPTIONS, "stage-A")
    assert len(found) >= 2
    for (size, end), (begin, wide) in zip(found[::2], found[1::2], strict=False):
        assert size < end < tab.locator("#stage-A").bounding_box()["width"]
        assert (begin, wide < size - 5) == (0, True)
    tops = tab.locator("header .tools button").evaluate_all(
        "all => all.map(each => each.getBoundingClientRect().top)"
    )
    assert len(set(tops)) == 1
    page.context.close()
    assert page.problems == []


def test_the_key_of_the_help_works_in_a_menu(page):
    page.tab.focus("#quantity")
    page.tab.keyboard.press("?")
    assert page.tab.locator("#help").is_visible()


def test_numbers_of_a_previous_chain_are_dimmed(page):
    legends = ("#legend-pulse", "#legend-budget")
    opacity = "id => getComputedStyle(document.querySelector(id)).opacity"
    assert [page.tab.evaluate(opacity, each) for each in legends] == ["1", "1"]
    field = page.tab.get_by_label("beads", exact=True).first
    field.fill("0")
    field.press("Enter")
    page.settle()
    assert page.tab.locator("body.stale").count() == 1
    assert [page.tab.evaluate(opacity, each) for each in legends] == ["0.6", "0.6"]


def test_headings_name_the_first_ball_that_differs(page):
    def titles(own, other, more):
        hash_ = f"#{own}&{more}&" + "&".join(f"b.{each}" for each in f"{other}&{more}".split("&"))
        tab = page.new_tab(page.origin + hash_)
        return [tab.text_content(f"#title-{slot}").partition(": ")[2] for slot in "AB"]

    steel = "materials=steel-52100&velocity=0.1+m/s"
    balls = 'diameters=["10+mm","10+mm","8+mm","9+mm"]', 'diameters=["10+mm","8+mm","10+mm","9+mm"]'
    a, b = titles(*balls, steel)
    assert a.partition(";")[0] == b.partition(";")[0]
    assert (a.partition("; ")[2], b.partition("; ")[2]) == ("ball 2: 10 mm", "ball 2: 8 mm")
    struck = titles(*balls, "materials=steel-52100&struck_by.velocity=0.1+m/s")
    assert [each.partition("; ")[2] for each in struck] == ["ball 2: 10 mm", "ball 2: 8 mm"]
    a, b = titles(*(each.replace("+mm", "").replace('"', "") for each in balls), "exponent=1.5")
    assert "; ball 2: radius " in a
    assert all(";" not in each for each in titles(balls[0], balls[0], steel))


@pytest.mark.long
def test_a_stiffness_without_a_unit_has_the_unit_of_its_exponent(page, tmp_path):
    path = tmp_path / "wall.toml"
    text = '[chain]\ndiameters = "10 mm"\nbeads = 8\nmaterials = "steel-52100"\n'
    for exponent, stiffness, unit, shown in (
        ("exponent = 1, ", "5e5", "N/m", "500000"), ("exponent = 1, ", "5e6", "kN/mm", "5"),
        ("", "5e6", "N/m^1.5", "5000000"),
    ):  # fmt: skip
        path.write_text(f"{text}right_wall = {{{exponent}stiffness = {stiffness}}}\n")
        open_file(page, path)
        row = page.tab.locator(".row:has([id='c-chain.right_wall.stiffness'])")
        assert row.locator("input[type=text]").input_value() == shown
        assert row.locator(".unit").text_content() == unit
        if unit == "kN/mm":
            row.locator("input[type=text]").fill("20")
            row.locator("input[type=text]").press("Tab")
            page.settle()
            assert page.document()["chain"]["right_wall"]["stiffness"] == "20 kN/mm"
    # Lists, and the unit that an empty field expects; a value may have its own.
    row = page.tab.locator(".row:has([id='c-chain.stiffness'])")
    several = "stiffness = [1e9, 2e9, 1e9, 2e9, 1e9, 2e9, 1e9]\n"
    exponents = "exponent = [1.5, 1.2, 1.5, 1.2, 1.5, 1.2, 1.5]\n"
    for lines, unit in (
        ("", "N/m^1.5"), (several, "N/m^1.5"), (several + "exponent = 1.2\n", "N/m^1.2"),
        (several + exponents, "N/m^exponent"), ('stiffness = "9 N/µm^1.5"\n', ""),
    ):  # fmt: skip
        path.write_text(text + lines)
        open_file(page, path)
        assert row.locator(".unit").text_content() == unit
    row = page.tab.locator(".row:has([id='c-chain.right_wall.stiffness'])")
    path.write_text(f'{text}right_wall = {{exponent = 1, stiffness = "5 kN/mm"}}\n')
    open_file(page, path)
    assert row.locator("input[type=text]").input_value() == "5"
    assert row.locator(".unit").text_content() == "kN/mm"


def test_the_impact_of_a_striker_has_one_of_velocity_height_and_energy(page, tmp_path):
    path = tmp_path / "striker.toml"
    path.write_text(
        '[chain]\ndiameters = "10 mm"\nbeads = 8\nmaterials = "steel-52100"\n'
        "struck_by = {velocity = 0.767071704601}\n"
    )
    open_file(page, path)
    field = page.tab.locator("[id='c-chain.struck_by.velocity']")
    assert field.input_value() == "0.767072"
    assert page.document()["chain"]["struck_by"]["velocity"] == 0.767071704601
    choice = page.tab.locator("[id='c-chain.struck_by.velocity-by']")
    for name, typed, value in (
        ("height", "20", "20 mm"), ("energy", "2", "2 mJ"), ("velocity", "0.5", "0.5 m/s")
    ):  # fmt: skip
        choice.focus()
        choice.select_option(name)
        page.settle()
        assert list(page.document()["chain"]["struck_by"]) == [name]
        assert choice.input_value() == name
        shown = [
            page.tab.locator(f"[id='c-chain.struck_by.{each}']").count()
            for each in ("velocity", "height", "energy")
        ]
        assert sum(shown) == 1
        # The field follows the choice in the order of the keys.
        choice.focus()
        page.tab.keyboard.press("Tab")
        while page.tab.evaluate("document.activeElement.tagName") == "BUTTON":
            page.tab.keyboard.press("Tab")
        field = page.tab.locator(f"[id='c-chain.struck_by.{name}']")
        assert page.tab.evaluate("document.activeElement.id") == f"c-chain.struck_by.{name}"
        field.select_text()
        field.press_sequentially(typed)
        page.settle()
        assert page.tab.is_hidden("#problem")
        assert page.document()["chain"]["struck_by"] == {name: value}
    # A size that is not given is that of the balls; the choice alone changes nothing.
    page.tab.locator("[id='c-chain.struck_by.radius-by']").select_option("diameter")
    assert page.tab.locator("[id='c-chain.struck_by.radius']").count() == 0
    assert page.tab.input_value("[id='c-chain.struck_by.diameter']") == ""
    assert page.document()["chain"]["struck_by"] == {"velocity": "0.5 m/s"}


def test_the_page_begins_with_the_chains_and_sensors_of_the_command(browser):
    other = {"chain": {"taper": "uniform", "beads": 40}}
    running = RunningServer(0, TAPER, warm_up=False, view=first_view(TAPER, other, [12]))
    thread = running.start()
    try:
        page = Page(browser, running)
        assert page.document("B") == other
        assert "B: sensor in bead 12" in page.tab.text_content("#legend-force").replace(
            "B, ", "B: "
        )
        assert page.tab.evaluate("hertzchain.state.view.errors") == "difference"
        assert page.problems == []
        page.context.close()
    finally:
        running.stop()
        thread.join(5.0)


def test_measured_data_are_shown_over_the_forces_and_can_be_shifted(browser, tmp_path):
    chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=8, velocity=0.3)
    chain = chain.replace(right_wall=hc.Wall())
    run = hc.simulate(chain, until=300e-6, times=3001)
    times = np.arange(-200, 3001) * 1e-7
    noise = np.random.default_rng(5).normal(0.0, 0.05, (2, len(times)))
    ball, wall = (np.interp(times, run.times, each) for each in (run.sensor(4), run.forces[:, -1]))
    rows = np.column_stack([1e6 * times + 50.0, ball + noise[0], wall + noise[1]])
    file = tmp_path / "record.csv"
    np.savetxt(file, rows, "%.6g", ",", header="time [us],CH1 [N],CH2 [N]", comments="")
    with serving(document_of_chain(chain)) as running:
        page = Page(browser, running)
        tab = page.tab
        tab.set_input_files("#file", file)
        tab.wait_for_selector("#record-note.bad")
        assert "column 'CH1' does not name the place" in tab.text_content("#record-note")
        assert tab.locator("#chart-force .measured").count() == 0
        # A sensor that a wrong place has added is removed when the place is corrected.
        # A place in both lists, of ball 4, remains the second sensor, of the same colour.
        for place, second, sensors in (
            ("ball 6", "ball 4", [6, 4]), ("ball 4", "ball 3", [3, 4]),
            ("ball 6", "wall", [6]), ("ball 4", "wall", [4]),
        ):  # fmt: skip
            tab.fill("#record-sensors", f"CH1={place}, CH2={second}")
            tab.press("#record-sensors", "Tab")
            tab.locator("#legend-force .key", has_text=f"measured {place}").wait_for()
            page.settle()
            assert tab.evaluate("hertzchain.state.view.sensors") == sensors
        assert tab.locator("#chart-force .line.measured").count() == 2
        # Each trace has an entry, and a colour between that of its sensor and that of the text.
        drawn = [
            (tab.locator("#legend-force .key", has_text=f"measured {place}"),
             tab.locator(f"#chart-force .line.{name}"))
            for place, name in (("ball 4", "sensor0"), ("wall", "wall-right"))
        ]  # fmt: skip
        for entry, curves in drawn:
            simulated, measured = (
                curves.nth(i).evaluate("(each) => getComputedStyle(each).stroke") for i in (0, 1)
            )
            assert entry.count() == 1
            assert entry.locator(".line").evaluate("(e) => getComputedStyle(e).stroke") == measured
            assert measured != simulated
        assert len({curves.nth(1).get_attribute("class") for _, curves in drawn}) == 2
        # Circles, which simulated curves do not have, mark measured ones, also in the legend.
        assert tab.locator("#chart-force .circles.measured").count() == 2
        assert tab.locator("#legend-force .circles.measured").count() == 2
        # In a change of the chain, the curves are aligned again.
        begin = float(tab.get_attribute("#shift", "placeholder"))
        tab.fill("[id='c-chain.velocity']", "0.1")
        tab.press("[id='c-chain.velocity']", "Enter")
        page.settle()
        assert float(tab.get_attribute("#shift", "placeholder")) < begin - 1.0
        tab.fill("[id='c-chain.velocity']", "0.3")
        tab.press("[id='c-chain.velocity']", "Enter")
        page.settle()
        # The simulation begins at 50 us of the record.
        assert float(tab.get_attribute("#shift", "placeholder")) == pytest.approx(50.0, abs=0.1)

        def crest():
            """Place of the largest measured and the largest simulated force on the wall."""
            curves = [
                tab.locator(f"#chart-force .line.wall-right{name}")
                for name in (".measured", ":not(.measured)")
            ]
            points = [
                re.findall(r"[ML]([\d.]+) ([\d.]+)", each.get_attribute("d")) for each in curves
            ]
            return [float(min(each, key=lambda point: float(point[1]))[0]) for each in points]

        measured, simulated = crest()
        assert abs(measured - simulated) < 3.0
        # Of two chains, each is aligned with the record: a faster pulse begins later.
        assert "aligned" not in tab.text_content("#record-note")
        tab.click("#compare")
        page.settle()
        tab.fill("[id='c-chain.velocity']", "0.6")
        tab.press("[id='c-chain.velocity']", "Enter")
        page.settle()
        times = {}
        for own in "AB":
            tab.click(f"#tab-{own}")
            tab.evaluate(NEXT_FRAME)
            times[own] = tab.get_attribute("#shift", "placeholder")
            note = tab.text_content("#record-note")
            assert f"aligned with chain {own} (with {'BA'['AB'.index(own)]}: " in note
        assert f"aligned with chain B (with A: {times['A']} µs)" in note
        assert float(times["B"]) > float(times["A"]) + 5.0
        tab.click("#tab-A")
        tab.click("#compare")
        page.settle()
        tab.fill("#shift", "20")
        tab.press("#shift", "Tab")
        tab.evaluate(NEXT_FRAME)
        assert crest()[0] > simulated + 10.0
        note = tab.text_content("#record-note")
        assert (
            "the time at which the simulation begins is given; by least squares, it is 50." in note
        )
        with tab.expect_download() as download:
            tab.click("#open-share")
            tab.click("[data-export=page]")
        saved = tmp_path / "saved.html"
        download.value.save_as(saved)
        tab.keyboard.press("Escape")
        tab.click("#record-close")
        page.settle()
        assert tab.locator("#chart-force .measured").count() == 0
        assert tab.is_hidden("#record")
        # Sensors of the data are removed with them.
        assert tab.evaluate("hertzchain.state.view.sensors") == []
        tab.goto(f"file://{saved}")
        tab.wait_for_selector("#chart-force .measured")
        assert (tab.input_value("#shift"), tab.is_hidden("#open-record")) == ("20", True)
        assert "record.csv" in tab.text_content("#record")
        assert page.problems == []
        page.context.close()


def shown_times(tab, chart="force"):
    """First and last tick of the time axis in seconds."""
    texts = tab.locator(f"#chart-{chart} text[text-anchor=middle]")
    *ticks, label = texts.all_text_contents()
    factor = {"µ": 1e-6, "m": 1e-3}[re.search(r"\[(.)s\]", label)[1]]
    return float(ticks[0]) * factor, float(ticks[-1]) * factor


@pytest.mark.parametrize("view", [None, first_view(TAPER, WALL, [3, 12], until=90.0)])
def test_the_page_contains_its_first_results(browser, view):
    running = RunningServer(0, TAPER, warm_up=False, view=view)
    thread = running.start()
    try:
        asked, shown = [], []
        for first in (False, True):
            if first:
                running.app.first.compute(lambda: False)
            page = Page(browser, running)
            page.tab.on("request", lambda each: asked.append(each.url))
            page.tab.goto(page.origin + "?")
            page.settle()
            assert any("/api/" in each for each in asked) is not first
            asked.clear()
            slots = "A" if view is None else "AB"
            shown.append({(s, p, n): page.array(p, n, s) for s in slots for p, n in (
                ("beads", "radii"), ("pulse", "exact.velocity"), ("run", "forces.times"),
            )})  # fmt: skip
            assert page.tab.evaluate("hertzchain.results.A.settled")
            if first:
                # Later results are requested, also those of a link.
                page.tab.goto(page.origin + "?#taper=uniform&beads=7")
                page.settle()
                assert page.document()["chain"]["beads"] == 7
                assert len(page.array("beads", "radii")) == 7
                page.tab.click("#compare")
                page.settle()
                assert len(page.array("run", "times", "B")) > 100
            assert page.problems == []
            page.context.close()
        for name, values in shown[0].items():
            assert np.array_equal(values, shown[1][name])
    finally:
        running.stop()
        thread.join(5.0)


def test_too_slow_first_results_are_not_in_the_page():
    running = RunningServer(0, TAPER, warm_up=False)
    running.app.first.compute(lambda: True)
    assert b'id="first"' not in running.app.first.page
    running.app.first.compute(lambda: False)
    assert b'id="first"' in running.app.first.page
    running.close()
    running.socket.close()


def test_a_part_of_the_time_can_be_selected(browser, tmp_path):
    chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=8, velocity=0.3)
    chain = chain.replace(right_wall=hc.Wall())
    with serving(document_of_chain(chain)) as running:
        page = Page(browser, running)
        tab = page.tab
        end = page.array("run", "times")[-1]
        box = tab.locator("#chart-force").bounding_box()
        left, right, y = box["x"] + 62, box["x"] + box["width"] - 20, box["y"] + 60
        assert tab.is_hidden("#whole")
        # A click still moves the cursor.
        tab.mouse.click((left + right) / 2, y)
        tab.evaluate(NEXT_FRAME)
        cursor = float(tab.text_content("#clockface").split()[2]) * 1e-6
        assert cursor == pytest.approx(end / 2, rel=0.02)
        # A drag selects a part, of the budget too.
        tab.mouse.move(left + 0.5 * (right - left), y)
        tab.mouse.down()
        tab.mouse.move(left + 0.6 * (right - left), y)
        tab.mouse.move(left + 0.75 * (right - left), y)
        tab.mouse.up()
        tab.wait_for_selector("#whole:not([hidden])")
        low, high = tab.evaluate("hertzchain.state.view.range")
        assert (low, high) == pytest.approx((0.5 * end, 0.75 * end), abs=0.01 * end)
        for chart in ("force", "budget"):
            first, last = shown_times(tab, chart)
            assert low <= first < last <= high
        tab.click("#open-share")
        with tab.expect_download() as download:
            tab.click("[data-export=page]")
        saved = tmp_path / "saved.html"
        download.value.save_as(saved)
        tab.keyboard.press("Escape")
        # Keys halve the range around the cursor or its middle, move it, and show all.
        tab.focus("#chart-force")
        tab.keyboard.press("+")
        tab.keyboard.press("ArrowRight")
        tab.evaluate(NEXT_FRAME)
        less, more = tab.evaluate("hertzchain.state.view.range")
        assert more - less == pytest.approx((high - low) / 2, rel=1e-3)
        tab.keyboard.press("-")
        tab.keyboard.press("0")
        assert tab.evaluate("hertzchain.state.view.range") == []
        tab.wait_for_selector("#whole", state="hidden")
        tab.mouse.move(left + 0.5 * (right - left), y)
        tab.keyboard.down("Control")
        tab.mouse.wheel(0, -100)
        tab.keyboard.up("Control")
        tab.wait_for_selector("#whole:not([hidden])")
        less, more = tab.evaluate("hertzchain.state.view.range")
        assert more - less == pytest.approx(0.8 * end, rel=1e-3)
        tab.mouse.dblclick(left + 0.3 * (right - left), y)
        tab.wait_for_selector("#whole", state="hidden")
        tab.goto(f"file://{saved}")
        tab.wait_for_selector("#whole:not([hidden])")
        assert tab.evaluate("hertzchain.state.view.range") == [low, high]
        tab.click("#whole")
        tab.wait_for_selector("#whole", state="hidden")
        assert page.problems == []
        page.context.close()


# Colour of the map at a fraction of its width and of its height, counted from below.
COLOUR_OF_MAP = """([x, y]) => {
  const map = document.getElementById("map"), scale = map.width / map.clientWidth;
  const at = [52 + x * (map.clientWidth - 68), 6 + (1 - y) * (map.clientHeight - 40)];
  const pen = new OffscreenCanvas(map.width, map.height).getContext("2d", { willReadFrequently: true });
  pen.drawImage(map, 0, 0);
  return [...pen.getImageData(...at.map((each) => each * scale), 1, 1).data];
}"""  # noqa: E501


@pytest.mark.parametrize("width", [1200, 400])
def test_the_map_and_the_clock_show_the_selected_part(browser, width):
    with serving() as running:
        page = Page(browser, running, viewport={"width": width, "height": 800})
        tab = page.tab
        end = page.array("run", "times")[-1]

        def now():
            return float(tab.text_content("#clockface").split()[2]) * 1e-3

        def last_ball(first, last):
            times = (np.array([0.1, 0.6, 0.9]) * (high - low) + low - first) / (last - first)
            return np.array([tab.evaluate(COLOUR_OF_MAP, [0.975, each]) for each in times])

        # The pulse is reflected in this part.
        low, high = 0.5 * end, 0.6 * end
        whole = last_ball(0.0, end)
        assert np.ptp(whole, axis=0).max() > 150
        chart = tab.locator("#chart-force")
        chart.scroll_into_view_if_needed()
        box = chart.bounding_box()
        left, wide, y = box["x"] + 62, box["width"] - 82, box["y"] + 60
        tab.mouse.move(left + 0.5 * wide, y)
        tab.mouse.down()
        tab.mouse.move(left + 0.6 * wide, y, steps=3)
        tab.mouse.up()
        tab.wait_for_selector("#whole:not([hidden])")
        tab.evaluate(NEXT_FRAME)
        low, high = tab.evaluate("hertzchain.state.view.range")
        # The cursor was before the selected part.
        assert now() == pytest.approx(low, rel=1e-3)
        tab.evaluate("scrollTo(0, 0)")
        assert np.abs(last_ball(low, high) - whole).max() < 20
        for part in (0.0, 0.25, 1.0):
            tab.locator("#time").fill(str(round(1000 * part)))
            tab.evaluate(NEXT_FRAME)
            assert now() == pytest.approx(low + part * (high - low), rel=2e-3)
        plot = tab.locator("#map")
        size = plot.bounding_box()
        places = {"x": 52 + 0.3 * (size["width"] - 68), "y": 6 + 0.25 * (size["height"] - 40)}
        plot.click(position=places)
        tab.evaluate(NEXT_FRAME)
        assert now() == pytest.approx(low + 0.75 * (high - low), rel=2e-3)
        # The part is repeated.
        tab.select_option("#speed", "4")
        tab.click("#play")
        seen = []
        for _ in range(25):
            tab.wait_for_timeout(100)
            seen.append(now())
        assert low * 0.999 <= min(seen) < 0.7 * low + 0.3 * high
        assert 0.3 * low + 0.7 * high < max(seen) <= high * 1.001
        assert min(np.diff(seen)) < -0.5 * (high - low)
        tab.click("#play")
        plot.dblclick(position=places)
        tab.wait_for_selector("#whole", state="hidden")
        tab.locator("#time").fill("1000")
        tab.evaluate(NEXT_FRAME)
        assert now() == pytest.approx(end, rel=1e-3)
        assert page.problems == []
        page.context.close()


@pytest.mark.parametrize("height", [720, 660])
def test_a_low_window_shows_the_chain_the_map_and_the_forces(browser, height):
    with serving() as running:
        page = Page(browser, running, viewport={"width": 1280, "height": height})
        for name in ("#lane-A", "#map", "#map-bar", "#legend-force"):
            box = page.tab.locator(name).bounding_box()
            assert box["y"] + box["height"] < height - 8, name
        assert page.tab.locator("#chart-force").bounding_box()["height"] >= 170
        assert page.problems == []
        page.context.close()


@pytest.mark.parametrize("text", ["15", "15 mm", "a ball", "-1"])
@pytest.mark.parametrize("left_by", [None, "blur", "Enter", "Tab"])
def test_the_page_settles_after_a_field_was_filled(page, text, left_by):
    page.tab.goto(page.origin + "#first_diameter=20+mm&last_diameter=20+mm&beads=5"
                  "&materials=steel-52100&velocity=0.1+m/s")  # fmt: skip
    page.settle()
    field = page.tab.get_by_label("last diameter", exact=True)
    field.fill(text)
    if left_by == "blur":
        field.blur()
    elif left_by:
        field.press(left_by)
    page.settle()
    # Text is complete when the field is left, and the chain changes with each number.
    complete = left_by or text in {"15", "-1"}
    given = {"15": "15 mm", "-1": "-1 mm"}.get(text, text) if complete else "20 mm"
    assert page.document()["chain"]["last_diameter"] == given
    assert ("must be" in page.status()) == (given in {"a ball", "-1 mm"})
    assert field.input_value() == ("15" if left_by and text == "15 mm" else text)


def test_a_size_that_was_cleared_can_be_entered_again(page):
    page.tab.goto(page.origin + "#first_diameter=20+mm&last_diameter=10+mm&beads=5"
                  "&materials=steel-52100&velocity=0.1+m/s")  # fmt: skip
    page.settle()
    for name, advice in (("first", "size of the beads"), ("last", "size of the last bead")):
        field = page.tab.get_by_label(f"{name} diameter", exact=True)
        field.fill("")
        field.press("Tab")
        page.settle()
        assert field.get_attribute("aria-invalid") == "true"
        assert f"enter the {advice}" in page.tab.text_content("#problem")
        field.fill("15")
        field.press("Tab")
        page.settle()
        assert page.tab.is_hidden("#problem")
        assert page.document()["chain"][f"{name}_diameter"] == "15 mm"


def test_a_finger_selects_a_part_of_the_time(browser, running):
    page = Page(browser, running, viewport={"width": 400, "height": 800}, has_touch=True)
    tab = page.tab
    chart = tab.locator("#chart-force")
    chart.scroll_into_view_if_needed()
    box = chart.bounding_box()
    touch = page.context.new_cdp_session(tab)
    for kind, places in (("Start", [0.5]), ("Move", [0.6]), ("Move", [0.8]), ("End", [])):
        points = [{"x": box["x"] + u * box["width"], "y": box["y"] + 60} for u in places]
        touch.send("Input.dispatchTouchEvent", {"type": f"touch{kind}", "touchPoints": points})
    tab.wait_for_selector("#whole:not([hidden])")
    assert len(tab.evaluate("hertzchain.state.view.range")) == 2
    tab.click("#whole")
    assert tab.evaluate("hertzchain.state.view.range") == []
    page.context.close()


def test_a_much_longer_run_is_cut_where_the_active_one_ends(browser):
    fast = hc.Chain.from_materials(5e-3, "steel-52100", beads=8, velocity=0.3)
    slow = hc.Chain.from_materials(5e-3, "ptfe", beads=20, velocity=0.3)
    fast, slow = (each.replace(right_wall=hc.Wall()) for each in (fast, slow))
    view = first_view(document_of_chain(fast), document_of_chain(slow), [])
    running = RunningServer(0, document_of_chain(fast), warm_up=False, view=view)
    thread = running.start()
    try:
        page = Page(browser, running)
        tab = page.tab
        ends = [page.array("run", "times", slot)[-1] for slot in "AB"]
        assert ends[1] > 3.0 * ends[0]
        assert shown_times(tab)[1] <= ends[0]
        label = tab.text_content("#chart-force text.label >> nth=0")
        assert re.fullmatch(r"time \[µs\] \(B until [\d.]+\)", label)
        tab.click("#whole")
        tab.evaluate(NEXT_FRAME)
        assert ends[0] < shown_times(tab)[1] <= ends[1]
        # The run of B is shown whole.
        tab.click("#tab-B")
        tab.evaluate(NEXT_FRAME)
        assert ends[0] < shown_times(tab)[1] <= ends[1]
        assert page.problems == []
        page.context.close()
    finally:
        running.stop()
        thread.join(5.0)


def test_a_file_can_be_dropped_on_the_page(page):
    text = "time [us],wall [N]\\n0,0\\n1,2\\n"
    page.tab.evaluate("""(text) => {
        const data = new DataTransfer();
        data.items.add(new File([text], "dropped.csv"));
        dispatchEvent(new DragEvent("drop", { dataTransfer: data, cancelable: true }));
    }""", text.replace("\\n", "\n"))  # fmt: skip
    # The chain of this page is in scaled variables.
    page.tab.wait_for_selector("#record-note.bad")
    note = page.tab.text_content("#record-note")
    assert "SI units" in note or "dropped.csv" in note
