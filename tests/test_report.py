import io
import json
import multiprocessing
import os
import pickle
import re
import threading
import time
from html.parser import HTMLParser

import matplotlib.pyplot as plt
import pytest

from hertzchain.evaluation.evaluate import scoreboard
from hertzchain.paper.drawings import Drawing, drawing_pool, drawn
from hertzchain.paper.mathml import plain, typeset
from hertzchain.paper.report import _draw_scoreboard, write_report, write_reserved
from hertzchain.paper.report_folder import reserved
from hertzchain.paper.reproduction import reproduce
from hertzchain.plotting.style import figure_bytes, figure_style, svg_and_png
from hertzchain.sweeps.executors import local_pool


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("report")
    write_report(reproduce(["table2", "figure6", "figure11", "errata", "scoreboard"]), out)
    return out


def test_files(folder):
    assert {path.name for path in folder.iterdir()} == {
        ".lock", ".hertzchain.json", "report.html", "verdict.json", "summary.md", "figures",
    }  # fmt: skip
    assert {path.name for path in (folder / "figures").iterdir()} == {
        f"{name}.{ending}" for name in ("figure6", "figure11") for ending in ("svg", "png", "csv")
    } | {"errata.svg", "errata.png", "scoreboard.svg", "scoreboard.png", "scoreboard.csv"}


class _Addresses(HTMLParser):
    def __init__(self):
        super().__init__()
        self.found, self.images = [], 0

    def handle_starttag(self, tag, attrs):
        for name, value in attrs:
            if name in ("src", "srcset", "data") or (tag == "link" and name == "href"):
                self.found.append(value)
        self.images += tag == "img"


def test_the_page_asks_for_nothing(folder):
    page = (folder / "report.html").read_text("utf-8")
    addresses = _Addresses()
    addresses.feed(page)
    assert addresses.images == 4
    assert all(address.startswith("data:image/svg+xml;base64,") for address in addresses.found)
    assert not re.search(r"@import|url\(", page)
    assert "<script" not in page


def test_numbers_on_the_page_have_true_minus_signs(folder):
    page = (folder / "report.html").read_text("utf-8")
    cells = re.findall(r"<td[^>]*>([^<]*)</td>", page)
    assert any(cell.startswith("−") for cell in cells)
    assert not [cell for cell in cells if re.search(r"(?<!\w)-\d|\de-\d", cell)]
    assert re.search(r"drift of energy \d\.\de−\d", page)
    # Files with data keep the hyphens that other programs read.
    assert "−" not in (folder / "figures" / "scoreboard.csv").read_text("utf-8")


def test_the_page_opens_with_the_verdict(folder):
    page = (folder / "report.html").read_text("utf-8")
    opening = page[: page.index("<h2")]
    assert "28 of 28 table entries agree" in opening
    assert "as printed" in opening


def test_the_summary_is_a_table_and_formulas_are_mathml(folder):
    page = (folder / "report.html").read_text("utf-8")
    rows = re.findall(r'<th scope="row"><a href="#(\w+)">', page)
    assert rows == ["tables", "figures", "errata", "scoreboard"]
    assert all(f'id="{row}"' in page for row in rows)
    opening = page[: page.index("<nav ")]
    assert re.findall(r'aria-label="([^"]*tolerance)"', opening) == ["within tolerance"] * 4
    body = page[page.index("</style>") :]
    assert "$" not in body
    assert not re.search(r"[A-Za-z]\^[\w(]|\w_\d", re.sub(r"<[^>]*>", " ", body))


def test_formulas_are_converted_to_mathml():
    assert typeset("a < b") == "a &lt; b"
    assert typeset("in $c_0 q^x$ units") == (
        "in <math><mrow><msub><mi>c</mi><mn>0</mn></msub><msup><mi>q</mi><mi>x</mi></msup></mrow>"
        "</math> units"
    )
    assert typeset("E_90 of v^u") == f"{typeset('$E_90$')} of {typeset('$v^u$')}"
    # The parentheses of an exponent are not shown, others are.
    assert typeset("v^u_fl") == typeset("v_fl^u")
    assert typeset("$(1+S)^(-3/2)$") == (
        "<math><mrow><msup><mrow><mo>(</mo><mrow><mn>1</mn><mo>+</mo><mi>S</mi></mrow><mo>)</mo>"
        "</mrow><mrow><mo>−</mo><mn>3</mn><mo>/</mo><mn>2</mn></mrow></msup></mrow></math>"
    )
    for formula in ("$(1+S$", "$k^(3/2$", "$1+S)$"):
        with pytest.raises(ValueError, match="unmatched parenthesis"):
            typeset(formula)
    assert plain("in $c_0 q^x$ units") == "in c_0 q^x units"


def test_verdict_is_plain_versioned_data(folder):
    verdict = json.loads((folder / "verdict.json").read_text("utf-8"))
    assert verdict["schema_version"] == 1
    assert verdict["within_tolerance"] is True
    assert len(verdict["tables"]["table2"]["entries"]) == 28
    assert verdict["tables"]["table2"]["window"] == [5, 80]
    assert verdict["figures"]["figure6"]["holds"] is True
    assert len(verdict["errata"]) == 19
    assert "$" not in json.dumps(verdict["errata"])
    assert verdict["method"]["energy_drift"] < 1e-10
    rows = {row["name"]: row["theories"] for row in verdict["scoreboard"]["rows"]}
    assert rows["waist"]["bca"]["errors"]["velocity"]["from_10"]["worst"] > 0.4
    assert "refusal" in rows["waist"]["modified-bca"]


def test_the_scoreboard_is_in_page_and_summary(folder):
    page = (folder / "report.html").read_text("utf-8")
    assert '<h2 id="scoreboard">' in page
    verdict = page[: page.index("<nav ")]
    assert "On 13 smooth tapers that no theory was fitted to" in verdict
    (row,) = re.findall('<td class="text">waist</td>(.*)', page)
    (line,) = re.findall(r"^\| waist \|(.*)\|$", (folder / "summary.md").read_text("utf-8"), re.M)
    cells = [cell.strip() for cell in line.split("|")]
    assert re.findall("<td>(.*?)</td>", row) == cells
    assert cells[0] == "53"
    assert "–" in cells


@pytest.mark.long
def test_a_scoreboard_alone_is_a_report(tmp_path):
    result = reproduce(["scoreboard"])
    assert result.verdict.startswith("On 13 smooth")
    assert write_report(result, tmp_path).exists()


def test_two_reports_have_the_same_figures(folder, tmp_path):
    write_report(reproduce(["figure6"]), tmp_path)
    for ending in ("svg", "csv", "png"):
        name = f"figures/figure6.{ending}"
        assert (tmp_path / name).read_bytes() == (folder / name).read_bytes()


def figure_files(folder):
    return {path.name: path.read_bytes() for path in (folder / "figures").iterdir()}


@pytest.mark.long
def test_figures_drawn_in_processes_are_the_same(tmp_path):
    parts = ["figure1", "figure3", "figure6", "figure9", "figure13", "errata"]
    result = reproduce(parts)
    write_report(result, tmp_path / "alone")
    done = []
    with reserved(tmp_path / "both"), local_pool("processes", 1) as pool:
        write_reserved(
            result, tmp_path / "both", progress=lambda *counts: done.append(counts), pool=pool
        )
    assert done == [(count, 6) for count in range(1, 7)]
    assert figure_files(tmp_path / "both") == figure_files(tmp_path / "alone")
    assert len(figure_files(tmp_path / "both")) == 3 * 5 + 2


def draw_or_die(text):
    if multiprocessing.parent_process() is not None:
        os._exit(1)
    with figure_style():
        return plt.figure(label=text)


HERE, BESIDE = b'width="144pt"', b'width="216pt"'


def draw_where(_):
    with figure_style():
        return plt.figure(figsize=(2 if multiprocessing.parent_process() is None else 3, 1))


def test_figures_are_drawn_here_if_processes_die():
    drawings = {f"figure{number}": Drawing(draw_or_die, number) for number in range(5)}
    with local_pool("processes", 1) as pool:
        files = dict(drawn(drawings, pool))
    assert files.keys() == drawings.keys()
    assert all(png.startswith(b"\x89PNG") for _, png in files.values())


@pytest.mark.long
def test_processes_draw_beside_this_one():
    drawings = {str(number): Drawing(draw_where, number) for number in range(30)}
    with local_pool("processes", 1) as pool:
        pool.submit(draw_where, 0).result()
        files = dict(drawn(drawings, pool))
    sizes = [size for svg, _ in files.values() for size in (HERE, BESIDE) if size in svg]
    assert len(sizes) == 30
    assert set(sizes) == {HERE, BESIDE}
    with drawing_pool(2) as pool:
        assert pool is None
    assert all(HERE in svg for _, (svg, _) in drawn(drawings, None))


@pytest.mark.long
def test_a_process_receives_a_scoreboard_unchanged():
    drawing = Drawing(_draw_scoreboard, scoreboard(theories=["hard-sphere"]))
    assert pickle.loads(pickle.dumps(drawing)).files() == drawing.files()


def test_svg_is_that_of_savefig_and_png_has_its_size():
    def figure():
        with figure_style():
            canvas, axes = plt.subplots()
            axes.loglog([1, 10, 100], [3, 2, 1], label="$q = 0.1$")
            axes.legend()
        return canvas

    svg, png = svg_and_png(figure())
    assert svg == figure_bytes(figure(), "svg")
    shapes = [plt.imread(io.BytesIO(file)).shape for file in (png, figure_bytes(figure(), "png"))]
    assert shapes[0] == shapes[1]


def test_a_failure_leaves_the_earlier_report(tmp_path, monkeypatch):
    result = reproduce(["figure6"])
    write_report(result, tmp_path)
    before = (tmp_path / "report.html").read_bytes()

    def fails(*_):
        raise RuntimeError("no drawing today")

    monkeypatch.setattr("hertzchain.paper.report.draw_figure", fails)
    with pytest.raises(RuntimeError):
        write_report(result, tmp_path)
    assert (tmp_path / "report.html").read_bytes() == before
    assert {path.name for path in tmp_path.iterdir()} == {
        ".lock", ".hertzchain.json", "report.html", "verdict.json", "summary.md", "figures",
    }  # fmt: skip


def test_windows_that_were_asked_for_are_said_to_be(tmp_path):
    write_report(reproduce(["table3"], windows={"linear": (5, 99)}), tmp_path)
    page = (tmp_path / "report.html").read_text("utf-8")
    assert "were requested" in page
    assert "verdict bad" in page


def test_known_values_are_no_longer_computed_after_an_interrupt(monkeypatch):
    cases = []

    def verify(*, progress):
        for done in range(100):
            cases.append(done)
            time.sleep(0.02)
            progress(done, 100)

    def interrupt(_done, _chains):
        raise KeyboardInterrupt

    monkeypatch.setattr("hertzchain.paper.reproduction.verify", verify)
    threads = threading.active_count()
    with pytest.raises(KeyboardInterrupt):
        reproduce(["figure6", "verification"], progress=interrupt)
    assert len(cases) < 100
    assert threading.active_count() == threads
