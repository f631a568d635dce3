"""Laboratory sheets: predictions, exponents, tables for readings, and answers."""

import json
import os
import re
import shutil
import subprocess
from html.parser import HTMLParser

import numpy as np
import pytest

import hertzchain as hc
from hertzchain.app.documents import document_of_chain
from hertzchain.app.page_file import first_view
from hertzchain.recorded_warnings import ignore_warnings
from hertzchain.sheets import answers
from hertzchain.sheets.similarity import other_scales

ROW = hc.Chain.from_materials(diameters="16 mm", materials="steel-52100", beads=12)
CELL = ROW.replace(right_wall=hc.Wall("40 kN/mm", exponent=1)).with_cap("5 g").struck_by()
HEIGHTS = ["1 mm", "2 mm", "4 mm"]
NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
BROWSER = os.environ.get("HERTZCHAIN_CHROMIUM") or next(
    filter(None, map(shutil.which, NAMES)), None
)


@pytest.fixture(scope="module")
def sheet():
    return hc.lab_sheet(CELL, sensors=["ball 6", "wall"], heights=HEIGHTS)


def test_predictions_are_those_of_another_integration(sheet):
    """Values of an integration of the equations of motion with DOP853 of SciPy."""
    ball = [(35.80, 233.4), (54.26, 217.8), (82.25, 203.2)]
    cell = [(79.28, 478.7), (116.57, 447.6), (170.76, 418.6)]
    for j, values in enumerate((ball, cell)):
        for i, (force, time) in enumerate(values):
            assert sheet.forces[i, j] == pytest.approx(force, abs=0.006)
            assert 1e6 * sheet.times[i, j] == pytest.approx(time, abs=0.06)
    assert sheet.speeds == pytest.approx(np.sqrt(2 * 9.80665 * np.array([1e-3, 2e-3, 4e-3])))


def test_exponents_are_six_fifths_where_hertz_law_is_the_only_scale(sheet):
    assert sheet.exponents[:, 0] == pytest.approx([1.2, 1.2], abs=1e-5)
    # The force on a linear spring is no power of the speed.
    assert (sheet.exponents[:, 1] < 1.12).all()
    assert sheet.exponents[1, 1] < sheet.exponents[0, 1]
    steel = ROW.replace(right_wall=hc.Wall.of("steel-52100"))
    hertz = hc.lab_sheet(steel, sensors=["ball 3", "wall"], speeds=["50 mm/s", "0.1 m/s"])
    assert hertz.exponents == pytest.approx(1.2, abs=1e-5)
    times = answers.fitted_exponents(hertz, hertz.times)
    assert times == pytest.approx(-0.2, abs=1e-5)
    # A very soft wall stops the row as one mass on a spring: F = v sqrt(k m).
    soft = ROW.replace(right_wall=hc.Wall("1 N/mm", exponent=1))
    slow = hc.lab_sheet(soft, speeds=["10 mm/s", "20 mm/s"], until="0.2 s")
    assert slow.exponents == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize(
    ("change", "reason"),
    [({"right_wall": hc.Wall("40 kN/mm", exponent=1)}, "linear spring"),
     ({"gaps": 1e-5}, "gaps"), ({"loss": hc.Viscoelastic(1e-6)}, "lose energy"),
     ({"gravity": 9.81}, "static force")],
)  # fmt: skip
def test_reasons_for_other_exponents_are_stated(change, reason):
    assert not other_scales(ROW)
    (found,) = other_scales(ROW.replace(**change))
    assert reason in found


@pytest.mark.parametrize(
    "law", [hc.Restitution(0.9), hc.UnloadingRatio(0.2), hc.WaltonBraun(0.8)], ids=str
)
def test_constant_restitution_keeps_the_exponent(law):
    """Its laws contain no unit, so that a scaled motion solves the equations, too."""
    row = ROW.replace(loss=law, right_wall=hc.Wall())
    assert not other_scales(row)
    lossy = hc.lab_sheet(row, sensors=["ball 3", "wall"], speeds=["50 mm/s", "0.1 m/s"])
    assert lossy.exponents == pytest.approx(1.2, abs=1e-5)
    answer = answers.on_exponents(lossy)
    assert "restitution of its law does not depend on the speed" in answer
    assert "only if" not in answer


class Text(HTMLParser):
    """Cells of the tables, and the text before and after the page for the teacher."""

    def __init__(self):
        super().__init__()
        self.parts, self.open = {"sheet": [], "teacher": []}, "sheet"
        self.cells = {"sheet": [], "teacher": []}
        self.in_cell = False

    def handle_starttag(self, tag, attrs):
        if ("class", "teacher") in attrs:
            self.open = "teacher"
        self.in_cell = tag == "td"
        if self.in_cell:
            self.cells[self.open].append("")

    def handle_endtag(self, tag):
        self.in_cell = self.in_cell and tag != "td"

    def handle_data(self, data):
        self.parts[self.open].append(data)
        if self.in_cell:
            self.cells[self.open][-1] += data


def test_the_page_has_readings_and_the_answers_are_on_a_page_of_their_own(sheet):
    page = Text()
    page.feed(sheet.to_html())
    cells = page.cells["sheet"]
    assert {"35.80", "82.25", "79.28", "245.3"} <= set(cells)
    # Two forces and a time at three speeds, with two readings and a mean.
    assert cells.count("") == 3 * 3 * 3
    own, teacher = ("".join(page.parts[each]) for each in ("sheet", "teacher"))
    assert "1.107" not in own
    assert "differs from 1.200 on the load cell (1.107)" in teacher
    assert "in ball 6 (" not in teacher
    assert "behind the row is a linear spring" in teacher
    assert re.search(r"\.teacher \{ break-before: page;", sheet.to_html())


def test_a_blank_sheet_has_predictions_only_for_the_teacher():
    blank = hc.lab_sheet(CELL, sensors=["ball 6"], heights=HEIGHTS, blank=True, title="Row <1>")
    page = Text()
    page.feed(blank.to_html())
    assert "35.80" not in page.cells["sheet"]
    assert "35.80" in page.cells["teacher"]
    assert "Row &lt;1&gt;" in blank.to_html()
    own = blank.to_markdown().split("## For the teacher")[0]
    assert "predicted" not in own
    assert "4. Ask your teacher for the predictions, and divide your means by them." in own
    lossy = CELL.replace(loss=hc.Restitution(0.9))
    own = hc.lab_sheet(lossy, heights=HEIGHTS, blank=True).to_markdown()
    assert "The teacher's predictions include losses in the contacts (restitution 0.9)." in own


def test_the_answers_say_to_which_tasks_they_belong(sheet):
    own, teacher = sheet.to_markdown().split("## For the teacher")
    assert "4. Divide your means by the predictions." in own
    tasks = re.findall(r"^(\d)\. ", own, re.MULTILINE)
    answered = re.findall(r"^(\d)\. ", teacher, re.MULTILINE)
    assert answered == tasks[1:]
    assert f"\nAnswers to tasks {answered[0]} to {answered[-1]}:\n\n{answered[0]}. " in teacher
    assert "<p>Answers to tasks 2 to 5:</p>" in sheet.to_html()


def test_the_speed_of_the_pulse_is_that_of_the_solitary_wave():
    """In a long row of equal balls; between centres of balls, and to the wall."""
    row = ROW.replace(right_wall=hc.Wall.of("steel-52100"))
    long = hc.Chain.from_materials(diameters="16 mm", materials="steel-52100", beads=40)
    sheet = hc.lab_sheet(long, sensors=["ball 15", "ball 25"], speeds=["50 mm/s", "0.1 m/s"])
    run = hc.simulate(long.replace(velocities=0.1 * (long.velocities > 0)))
    arrival = run.pulse().peak_time
    expected = 10 * 16e-3 / (arrival[24] - arrival[14])
    assert float(answers.travel(sheet).rows[1][1]) == pytest.approx(expected, rel=1e-3)
    assert answers._distance(row, "ball 3", "ball 5") == pytest.approx(32e-3)
    apart = CELL.replace(gaps=1e-4)
    assert answers._distance(apart, "ball 3", "ball 5") == pytest.approx(32.2e-3)


def test_no_speed_of_the_pulse_is_stated_up_to_the_wall(sheet):
    assert answers.travel(sheet) is None
    assert "What is the speed of the pulse" not in sheet.to_markdown()
    assert "includes the compression of the load cell and the cap" in answers.on_travel(sheet)
    three = hc.lab_sheet(CELL, sensors=["ball 3", "wall", "ball 6"], heights=HEIGHTS[:2])
    assert answers.travel(three).heads == ("v [mm/s]", "ball 3 to ball 6 [m/s]")
    # Sensors are in the order in which the pulse arrives.
    assert three.places == ("ball 3", "ball 6", "wall")
    assert (np.diff(three.times) > 0.0).all()
    expected = 48e-3 / (three.times[0, 1] - three.times[0, 0])
    assert float(answers.travel(three).rows[0][1]) == pytest.approx(expected, rel=1e-3)
    page = three.to_markdown()
    assert "What is the speed of the pulse between ball 3 and ball 6, and is it constant?" in page
    two = hc.lab_sheet(ROW, sensors=["ball 3", "ball 6"], heights=HEIGHTS[:2]).to_markdown()
    assert "What is the speed of the pulse between them, and is it constant?" in two
    assert "compression of the" not in two


def effects(row):
    """Ratios and delays in a row of the table of causes."""
    found = [re.fullmatch(r"([\d.]+)%, ([+-][\d.]+) µs", each).groups() for each in row[1:]]
    return np.array(found, float).T


def test_losses_and_gaps_are_compared_with_the_prediction(sheet):
    table = answers.causes(sheet)
    gaps = "with gaps of 10 µm between the balls"
    changes = ["with restitution 0.95", "with restitution 0.9", gaps, f"{gaps}, and before the cap"]
    assert [row[0] for row in table.rows] == changes
    lossy = CELL.replace(
        loss=hc.Restitution(0.9), velocities=sheet.speeds[1] * (CELL.velocities > 0)
    )
    run = hc.simulate(lossy, times=8001)
    ratio = run.sensor_force("ball 6").first_maximum / sheet.forces[1, 0]
    assert effects(table.rows[1])[0, 0] == pytest.approx(100 * ratio, abs=0.06)
    # From the row with losses, the row without them is the inverse change.
    found = answers.causes(hc.lab_sheet(lossy, sensors=["ball 6", "wall"], heights=HEIGHTS))
    assert [row[0] for row in found.rows] == ["without losses", gaps, f"{gaps}, and before the cap"]
    (ratios, delays), (back, earlier) = effects(table.rows[1]), effects(found.rows[0])
    assert back == pytest.approx(1e4 / ratios, abs=0.15)
    assert earlier == pytest.approx(-delays, abs=0.11)


def test_delays_by_gaps_are_those_of_the_first_maxima(sheet):
    """The two contacts of a ball between gaps act one after the other, with similar forces."""
    table = answers.causes(sheet)
    assert table.caption.endswith("delays of the first maxima")
    still = CELL.strikers + np.arange(CELL.beads - 3)
    apart = CELL.replace(gaps=np.isin(np.arange(CELL.beads - 1), still) * 1e-5,
                         velocities=sheet.speeds[1] * (CELL.velocities > 0))  # fmt: skip
    run = hc.simulate(apart, times=20001)
    ball = CELL.strikers + 6
    behind, ahead = (run.times[run.force(k).argmax()] for k in (ball - 1, ball))
    delay = effects(table.rows[2])[1, 0]
    assert delay == pytest.approx(1e6 * (behind - sheet.times[1, 0]), abs=0.3)
    assert ahead - behind > 50e-6


def test_gaps_are_compared_with_the_losses_of_the_chain():
    """Also of a load cell with a law of its own, and from a row that has gaps."""
    cell = hc.Wall("40 kN/mm", exponent=1, loss=hc.Elastic())
    lossy = CELL.replace(loss=hc.Viscoelastic("2 us"), right_wall=cell)
    sheet = hc.lab_sheet(lossy, sensors=["ball 6"], heights=HEIGHTS)
    without, gaps, _ = answers.causes(sheet).rows
    still = lossy.strikers + np.arange(CELL.beads - 3)
    apart = lossy.replace(gaps=np.isin(np.arange(CELL.beads - 1), still) * 1e-5,
                          velocities=sheet.speeds[1] * (CELL.velocities > 0))  # fmt: skip
    found = hc.simulate(apart, times=8001).sensor_force("ball 6").first_maximum
    assert effects(gaps)[0, 0] == pytest.approx(100 * found / sheet.forces[1, 0], abs=0.06)
    elastic = hc.lab_sheet(CELL, sensors=["ball 6"], heights=HEIGHTS)
    ratio = 100 * elastic.forces[1, 0] / sheet.forces[1, 0]
    assert effects(without)[0, 0] == pytest.approx(ratio, abs=0.06)
    back = answers.causes(hc.lab_sheet(apart, sensors=["ball 6"], heights=HEIGHTS)).rows[-1]
    assert back[0] == "without gaps"
    assert effects(back)[0, 0] == pytest.approx(100 * sheet.forces[1, 0] / found, abs=0.06)


@pytest.mark.parametrize(
    ("change", "said"),
    [({"loss": hc.Restitution(0.95)}, "restitution 0.95"),
     ({"loss": hc.Viscoelastic("0.5 us"),
       "right_wall": hc.Wall("40 kN/mm", exponent=1, loss=hc.Elastic())},
      "viscoelastic 0.5 µs; load cell elastic"),
     ({"right_wall": hc.Wall(loss=hc.VelocityPower(0.1, 0.2))},
      "elastic; wall velocity-power (gamma 0.1, alpha 0.2)"),
     ({"loss": [hc.Elastic()] * 3 + [hc.ElasticPlastic()] + [hc.Elastic()] * 7},
      "elastic in contacts 1 to 3 and 5 to 11; elastic-plastic in contact 4")],
)  # fmt: skip
def test_the_teacher_reads_the_laws_of_loss(change, said):
    page = hc.lab_sheet(ROW.replace(**change), sensors=["ball 3"], speeds=[0.05, 0.1]).to_markdown()
    (row,) = [line for line in page.splitlines() if line.startswith("Row: ")]
    assert row.endswith(f". Loss: {said}.")
    assert "loss" not in row.partition(". Loss")[0]


def test_the_teacher_reads_that_a_load_cell_inherits_the_loss():
    lossy = CELL.replace(loss=hc.Restitution(0.95))
    own = lossy.replace(right_wall=hc.Wall("40 kN/mm", exponent=1, loss=hc.Elastic()))
    for chain, stated in ((lossy, True), (own, False), (CELL, False)):
        page = hc.lab_sheet(chain, speeds=[0.05, 0.1]).to_markdown()
        (row,) = [line for line in page.splitlines() if line.startswith("Row: ")]
        assert row.endswith("describe the wall with the loss elastic.") == stated
        assert page.count("No loss is given for the load cell") == stated


def test_gaps_do_not_postpone_the_impact():
    """Values of an integration of the row of 14 balls with SciPy, without and with the last gap."""
    row = hc.Chain.from_materials(diameters="16 mm", materials="steel-52100", beads=14)
    cell = row.replace(right_wall=hc.Wall("30 kN/mm", exponent=1)).with_cap("8 g")
    sheet = hc.lab_sheet(cell.struck_by(), heights=["2 mm", "4 mm", "8 mm"])
    balls, cap = answers.causes(sheet).rows[-2:]
    assert effects(balls)[0] == pytest.approx(103.5, abs=0.1)
    ratio, delay = effects(cap)
    assert ratio == pytest.approx(108.7, abs=0.1)
    assert delay == pytest.approx(992 - 486, abs=1.0)
    free = hc.lab_sheet(row, sensors=["ball 2"], heights=HEIGHTS[:2])
    (name, effect) = answers.causes(free).rows[-1]
    assert name == "with gaps of 10 µm between the balls"
    # The gap of 10 µm behind ball 1, which moves at 198 mm/s, would take 50 µs.
    assert effects((name, effect))[1] < 45.0


def test_exponents_are_raised(sheet):
    page = sheet.to_html()
    assert "proportional to v<sup>6/5</sup>" in page
    # Answers 2 and 3 write the exponent of times in the same way.
    assert "proportional to v<sup>-1/5</sup>" in page
    assert "v^(-0.2)" not in sheet.to_markdown()
    assert "&lt;sup" not in page
    assert "v^(6/5)" in sheet.to_markdown()


@pytest.fixture(scope="module")
def column():
    """A vertical column on a load cell, struck by a heavy flat body."""
    row = hc.Chain.from_materials(
        diameters="19.05 mm", materials="steel-52100", beads=12, gravity="9.81 m/s^2",
        right_wall=hc.Wall("200 kN/mm", exponent=1),
    )  # fmt: skip
    struck = row.struck_by(mass="0.5 kg", radius="inf", height="1 mm")
    return hc.lab_sheet(struck, sensors=["ball 6", "wall"], heights=["1 mm", "2 mm", "5 mm"])


def test_forces_on_a_load_cell_are_those_of_the_first_pulse(column):
    """A second pulse of a heavy striker is stronger; values of DOP853 of SciPy."""
    assert column.forces[:, 1] == pytest.approx([402.1, 614.7, 1073.0], rel=4e-4)
    delays = 1e6 * np.diff(column.times, axis=1)[:, 0]
    assert delays == pytest.approx([207.0, 195.8, 181.8], abs=0.25)
    with ignore_warnings():
        largest = hc.simulate(column.chain).wall_force().peak
    assert largest > 1.02 * column.forces[0, 1]
    # Times of contacts that follow Hertz's law have the exponent -0.2.
    assert answers.fitted_exponents(column, delays[:, None])[0] == pytest.approx(-0.16, abs=0.01)


def test_a_column_under_gravity_has_no_gaps(column):
    table = answers.causes(column)
    assert [row[0] for row in table.rows] == ["with restitution 0.95", "with restitution 0.9"]
    (note,) = table.notes
    assert "effect of gaps is not computed: the balls rest on each other" in note
    for page in (column.to_html(), column.to_markdown()):
        assert note in page
        assert "gaps between" not in page.split("For the teacher")[0]
        assert "Gaps delay the pulse" not in page


def test_a_change_that_cannot_be_simulated_is_named(column, monkeypatch):
    def fail():
        raise hc.InputError("no such chain")

    monkeypatch.setattr(answers, "_changes", lambda _: {"without losses": fail})
    expected = "The effect without losses is not computed: no such chain."
    assert expected in answers.causes(column).notes
    assert expected in column.to_markdown()


def test_a_column_is_drawn_from_top_to_bottom(column):
    page = column.to_html()
    (figure,) = re.findall(r'<svg class="column".*?</svg>', page, re.DOTALL)
    assert "matrix(0 1 1 0 0 0)" in figure
    names = re.findall(r'<text x="([\d.]+)" y="([\d.]+)">([^<]*)<', figure)
    assert [name for *_, name in names] == ["striker", "ball 6", "load cell"]
    assert len({x for x, *_ in names}) == 1
    heights = [float(y) for _, y, _ in names]
    assert heights == sorted(heights)
    assert len(re.findall("<circle", figure)) == 12
    assert "Below the column is a load cell" in page
    assert "fall onto the column from the heights" in page


def test_the_command_advises_its_own_options(run, tmp_path):
    target = tmp_path / "sheet.html"
    done = run("sheet", "--material", "steel-52100", "--diameter", "19.05 mm", "--beads", 4,
               "--striker", "0.5 kg, flat", "--wall", "same", "--height", "20mm", "--height",
               "50mm", "--to", target)  # fmt: skip
    assert "add --loss elastic-plastic" in done.stderr
    assert "ElasticPlastic" not in done.stderr + target.read_text()


@pytest.mark.parametrize(
    ("chain", "sensors", "said"),
    [(CELL, ["ball 6", "wall"], "The row has 12 balls of steel-52100 with a diameter of 16 mm and "
      "a mass of 16.69 g. The striker is another ball of this kind. Behind the row is a load cell "
      "with a stiffness of 40 kN/mm and a cap of 5 g. A force sensor is in ball 6, and the load "
      "cell measures the force at the end of the row."),
     (ROW, ["ball 3", "ball 5"], "Its first ball is the striker. The far end of the row is free. "
      "Force sensors are in ball 3 and ball 5."),
     (ROW.replace(right_wall=hc.Wall.of("glass")).struck_by(radius="10 mm", material="brass"),
      ["wall"], "The striker is a ball of brass with a diameter of 20 mm and a mass of 35.73 g. "
      "Behind the row is a wall of glass. The force on the wall is measured."),
     (ROW.replace(loss=hc.Restitution(0.9), gaps=1e-5).with_cap("5 g"), ["cap"],
      "The last body is a cap of 5 g. The predictions include gaps of up to 10 µm and losses in "
      "the contacts (restitution 0.9). A force sensor is in the cap."),
     (hc.Chain.from_materials(diameters=["16 mm", "12 mm"], materials=["steel-52100", "glass"]),
      ["ball 2"], "The row has 2 balls of steel-52100 and glass (16 mm to 12 mm) with masses "
      "between ")],
)  # fmt: skip
def test_the_row_is_described_for_students(chain, sensors, said):
    found = hc.lab_sheet(chain, sensors=sensors, speeds=[0.05, 0.1])
    own = found.to_markdown().split("## For the teacher")[0]
    assert said in own
    assert "exponents" not in own


@pytest.mark.parametrize(
    ("wall", "said"),
    [(hc.Wall(2.5e7, exponent=1), "a load cell with a stiffness of 25 kN/mm."),
     (hc.Wall(5e9), "a wall with a contact stiffness of 5 N/um^1.5.")],
)  # fmt: skip
def test_stiffnesses_without_a_unit_are_in_the_si(wall, said):
    found = hc.lab_sheet(ROW.replace(right_wall=wall), speeds=[0.05, 0.1])
    assert said in found.to_markdown()


def test_the_sketch_shows_bodies_sensors_and_load_cell(sheet):
    (figure,) = re.findall(r"<svg.*?</svg>", sheet.to_html(), re.DOTALL)
    circles = re.findall(r'<circle cx="([\d.]+)".*? r="([\d.]+)" fill="(#\w+)"', figure)
    assert len(circles) == 13
    # Ball 6 is behind the striker and five other balls.
    assert [k for k, each in enumerate(circles) if each[2] == "#999"] == [6]
    steps = np.diff([float(each[0]) for each in circles])
    assert steps == pytest.approx(2 * (float(circles[0][1]) + 0.5), abs=0.2)
    assert re.findall("<text[^>]*>([^<]*)<", figure) == ["striker", "ball 6", "load cell"]
    assert figure.count("<rect") == 2
    assert figure.count("<path") == 1
    places = [float(each) for each in re.findall('<text x="([\\d.]+)"', figure)]
    assert places[1] == pytest.approx(float(circles[6][0]))
    long = hc.lab_sheet(hc.Chain.from_materials(diameters="2 mm", materials="brass", beads=150),
                        sensors=["ball 6"], speeds=[0.05, 0.1])  # fmt: skip
    assert "<svg" not in long.to_html()


@pytest.mark.skipif(BROWSER is None, reason="print not tested: no Chromium is installed")
def test_three_sensors_and_three_heights_are_printed_on_one_page(tmp_path):
    """A page for students, with room for a longer description, and one for the teacher."""
    full = hc.lab_sheet(CELL, sensors=["ball 3", "ball 6", "wall"], heights=HEIGHTS)
    page = full.to_html()
    longer = page.replace("</h1>", '</h1><p style="height: 20mm"></p>')
    for name, text in (("sheet", page), ("longer", longer)):
        source, printed = tmp_path / f"{name}.html", tmp_path / f"{name}.pdf"
        source.write_text(text, encoding="utf-8")
        command = [BROWSER, "--headless", "--no-sandbox", f"--user-data-dir={tmp_path}/profile",
                   f"--print-to-pdf={printed}", source.as_uri()]  # fmt: skip
        subprocess.run(command, check=True, capture_output=True, timeout=120)
        assert len(re.findall(rb"/Type */Page\b", printed.read_bytes())) == 2


def test_contacts_that_yield_are_reported():
    found = hc.lab_sheet(CELL, sensors=["ball 6"], speeds=["0.1 m/s", "5 m/s"])
    assert found.warnings
    assert all(each.startswith("at 5000 mm/s, ") for each in found.warnings)
    page = found.to_html()
    # The teacher reads a sentence without arguments of Python or options.
    assert ">At 5000 mm/s, pressure / yield" in page
    assert "use smaller speeds.</p>" in page
    assert "ElasticPlastic" not in page


@pytest.mark.parametrize(
    ("change", "said"),
    [({"heights": None}, "give either heights"), ({"speeds": [1.0, 2.0]}, "give either heights"),
     ({"heights": ["1 mm"]}, "list of 2 to 12"), ({"heights": ["1 mm", "1 mm"]}, "different"),
     ({"sensors": []}, "1 to 4 places"), ({"sensors": ["ball 6", "ball 6"]}, "different places"),
     ({"sensors": ["ball 60"]}, "12"), ({"heights": ["1 mm", "-1 mm"]}, "height"),
     ({"chain": hc.Chain.uniform(5)}, "SI units"), ({"chain": ROW}, "needs a right wall")],
)  # fmt: skip
def test_impossible_sheets_are_rejected(change, said):
    good = {"chain": CELL, "sensors": ["wall"], "heights": HEIGHTS}
    with pytest.raises(hc.InputError, match=said):
        hc.lab_sheet(**(good | change))


FILE = """[chain]
diameters = "16 mm"
materials = "steel-52100"
beads = 12
right_wall = {stiffness = "40 kN/mm", exponent = 1}
[chain.cap]
mass = "5 g"
[[chain.struck_by]]
velocity = "0.2 m/s"
"""


def test_the_command_writes_the_sheet(tmp_path, run, sheet):
    (tmp_path / "lab.toml").write_text(FILE)
    options = ("--sensor", "ball 6", "--sensor", "wall")
    heights = [part for each in HEIGHTS for part in ("--height", each.replace(" ", ""))]
    for name, expected in (("a.html", sheet.to_html()), ("a.md", sheet.to_markdown())):
        code, out, err = run("sheet", tmp_path / "lab.toml", *options, *heights, "--to",
                             tmp_path / name)  # fmt: skip
        assert (code, out, err) == (0, "", "")
        assert (tmp_path / name).read_text(encoding="utf-8") == expected
    speeds = ("--speed", "0.1m/s", "--speed", "0.2m/s")
    code, out, _ = run("sheet", tmp_path / "lab.toml", *speeds, "--json")
    document = json.loads(out)
    assert code == 0
    assert document["speeds"] == [0.1, 0.2]
    assert document["sensors"] == ["wall"]
    out = run("simulate", tmp_path / "lab.toml", "--sensor", "load cell", "--speed", "0.1m/s")[1]
    assert "\nright wall (load cell): peak" in out
    assert document["forces"][1][0] == pytest.approx(117.84, abs=0.006)


def test_a_law_of_the_load_cell_in_a_file_keeps_the_unit_of_its_stiffness(tmp_path, run):
    file, page = tmp_path / "lab.toml", tmp_path / "a.md"
    file.write_text(FILE.replace("exponent = 1}", 'exponent = 1, loss = {law = "elastic"}}'))
    assert run("sheet", file, "--speed", "0.1m/s", "--speed", "0.2m/s", "--to", page)[0] == 0
    assert "a load cell with a stiffness of 40 kN/mm and a cap" in page.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("options", "said"),
    [(("--height", "1mm", "--height", "2mm"), "--to sheet.html"),
     (("--height", "1mm", "--height", "2mm", "--to", "a.pdf"), ".html or .md"),
     (("--to", "a.md"), "--height or --speed at least twice"),
     (("--height", "1", "--height", "2mm", "--to", "a.md"), "no unit"),
     (("--height", "1mm", "--to", "a.md"), "at least twice"),
     (("--height", "1mm", "--sensor", "ball 17"), "ball 17"),
     (("--height", "1mm", "--sensor", "load cel"), "--sensor must be"),
     (("--height", "1mm", "--sensor", "load cel"), "did you mean 'load cell'?")],
)  # fmt: skip
def test_bad_options_are_explained(tmp_path, run, options, said, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab.toml").write_text(FILE)
    code, _, err = run("sheet", "lab.toml", *options)
    assert code == 2
    assert said in err
    assert not list(tmp_path.glob("a.*"))


def test_static_forces_are_listed_for_sensors_with_ac_coupling():
    column = CELL.replace(gravity=9.81)
    sheet = hc.lab_sheet(column, sensors=["ball 6", "wall"], heights=HEIGHTS)
    forces, page = column.static_state.forces, sheet.to_markdown()
    k = column.strikers + 6
    ball = 0.5 * (forces[k - 1] + forces[k])
    said = f"The static force is {ball:.3g} N in ball 6 and {forces[-1]:.3g} N on the load cell."
    assert said in page
    assert "AC coupling" in page
    assert "AC coupling" not in hc.lab_sheet(CELL, heights=HEIGHTS).to_markdown()
    # The row has a second scale, so that only Hertz's law itself has the exponent 0.6 of h.
    assert "As a function of the height h, with v² = 2gh, Hertz's exponent is 0.6." in page


def test_the_sheet_has_a_table(sheet):
    table = sheet.to_dataframe()
    assert table.columns.tolist() == ["sensor", "height", "speed", "force", "time"]
    assert table.attrs["units"] == {
        "sensor": "", "height": "m", "speed": "m/s", "force": "N", "time": "s",
    }  # fmt: skip
    assert len(table) == sheet.forces.size
    for i, height in enumerate(sheet.heights):
        for j, place in enumerate(("ball 6", "wall")):
            (row,) = table[(table.height == height) & (table.sensor == place)].itertuples()
            assert (row.speed, row.force) == (sheet.speeds[i], sheet.forces[i, j])
            assert row.time == sheet.times[i, j]
    speeds = hc.lab_sheet(ROW, sensors=["ball 3"], speeds=[0.05, 0.1]).to_dataframe()
    assert speeds.columns.tolist() == ["sensor", "speed", "force", "time"]
    # The integration of SciPy above, at the least and at the largest height.
    assert " ".join(repr(sheet).split()).endswith(
        "; 140.0 mm/s: ball 6 35.8 N, wall 79.28 N; 280.1 mm/s: ball 6 82.25 N, wall 170.8 N)"
    )


def test_a_cradle_may_have_several_strikers():
    balls = hc.Chain.from_materials(diameters="20 mm", materials="steel-52100", beads=5)
    cradle = hc.Chain.from_materials(diameters="20 mm", materials="steel-52100", beads=3)
    cradle = cradle.struck_by(velocity=0.1).struck_by(velocity=0.1)
    found = hc.lab_sheet(cradle, sensors=["ball 1", "last"], heights=HEIGHTS[:2])
    # The same five balls, of which the first two move.
    for speed, force in zip(found.speeds, found.forces, strict=True):
        run = hc.simulate(balls.replace(velocities=[speed, speed, 0, 0, 0]), times=4001)
        forces = [run.sensor_force(bead).first_maximum for bead in (3, 5)]
        assert force == pytest.approx(forces, rel=1e-4)
    page = found.to_markdown()
    assert "so that they touch each other and arrive at the speed v" in page
    assert "Force sensors are in ball 1 and the last ball." in page
    assert "ball 1 to last ball [m/s]" in page


def test_the_end_of_the_row_has_the_name_load_cell(sheet):
    named = hc.lab_sheet(CELL, sensors=["ball 6", "load cell"], heights=HEIGHTS)
    assert named.places == sheet.places
    assert (named.forces == sheet.forces).all()
    with pytest.raises(hc.InputError, match="different places"):
        hc.lab_sheet(CELL, sensors=["load cell", "wall"], heights=HEIGHTS)
    hard = ROW.replace(right_wall=hc.Wall())
    for row, name in ((ROW, f"bead {ROW.beads}"), (hard, "wall"), (ROW.with_cap("5 g"), "cap")):
        with pytest.raises(hc.InputError, match=f"has no load cell.* use the sensor '{name}'"):
            hc.lab_sheet(row, sensors=["load cell"], heights=HEIGHTS)
        with pytest.raises(hc.InputError, match="has no load cell"):
            first_view(document_of_chain(row), None, ["load cell"])
        with pytest.raises(hc.InputError, match="has no load cell"):
            hc.forecast(
                row.struck_by(velocity=0.1), sensors=["load cell"], noise=1.0,
                free=["stiffness"], interval="1 us", until="1 ms",
            )  # fmt: skip
    assert first_view(document_of_chain(CELL), None, ["load cell", 6])["view"]["sensors"] == [5]


def test_traces_and_runs_have_the_sensor_load_cell(tmp_path):
    slow = CELL.replace(velocities=0.1 * CELL.velocities)
    run = hc.simulate(slow, until="1 ms", times=2001)
    assert (run.sensor("load cell") == run.sensor("wall")).all()
    run.save_forces(tmp_path / "run.csv", ["ball 6", "wall"])
    text = (tmp_path / "run.csv").read_text(encoding="utf-8")
    (tmp_path / "cell.csv").write_text(text.replace("wall", "Load cell"), encoding="utf-8")
    options = {"noise": {"load cell": 0.1, "*": 0.1}, "coupling": {"load cell": "DC"}}
    cell, wall = (hc.load_traces(tmp_path / f"{name}.csv", **options) for name in ("cell", "run"))
    assert cell.names == wall.names
    assert [signal.coupling for _, signal in wall] == ["", "DC"]
    assert run.compare(cell).differences == run.compare(wall).differences
    free = slow.replace(right_wall=None)
    other = hc.simulate(free, until="1 ms", times=2001)
    with pytest.raises(hc.InputError, match="sensor 'load cell', but the chain has no load cell"):
        other.compare(cell)


def test_noise_parameters_and_priors_of_a_fit_know_the_sensor_load_cell():
    def plan(name, noise):
        return hc.forecast(
            CELL, ["ball 6", name], noise={name: 0.5, **noise}, interval="4 us",
            free=["stiffness", f"gain[{name}]", f"delay[{name}]"],
            priors={f"gain[{name}]": (1.0, 0.01)}, until="400 us",
        )  # fmt: skip

    one, two = plan("load cell", {"ball 6": 0.3}), plan("wall", {"ball 6": 0.3})
    assert one.errors == two.errors
    assert "delay[wall]" in one.errors
    with pytest.raises(hc.InputError, match="'wall' names the sensor 'wall', which is given twice"):
        plan("load cell", {"ball 6": 0.3, "wall": 1.0})


def test_a_notebook_shows_the_predictions(sheet):
    shown = sheet._repr_html_()
    assert sheet.title in shown
    for value in sheet.forces.ravel():
        assert f">{value:#.4g}</td>" in shown
    assert "reading 1" not in shown
    yielding = hc.lab_sheet(CELL, sensors=["ball 6"], speeds=["0.1 m/s", "5 m/s"], title="<b>")
    assert "at 5000 mm/s, pressure / yield" in yielding._repr_html_()
    assert "&lt;b&gt;" in yielding._repr_html_()


def test_speeds_have_the_same_number_of_decimals():
    speeds = [0.4491, 0.481, 0.5151]
    found = hc.lab_sheet(CELL, sensors=["ball 3", "ball 6"], speeds=speeds)
    assert answers.exponents(found).heads[1:3] == ("449.1 to 481.0 mm/s", "481.0 to 515.1 mm/s")
    assert answers.causes(found).caption.startswith("Forces at 481.0 mm/s")
    assert all(len(row[1]) == 5 for row in answers.travel(found).rows)
