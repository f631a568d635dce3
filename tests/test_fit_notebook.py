"""Views of traces, comparisons and fits in notebooks."""

import re
from dataclasses import replace
from html import unescape
from xml.etree import ElementTree

import numpy as np
import pytest
from scipy_row import FREE, chain, recorded, traces

import hertzchain as hc
from hertzchain.notebook.drawing import escape, sentence

pytestmark = pytest.mark.filterwarnings("ignore::hertzchain.errors.ModelRangeWarning")
MAX_BYTES = 40_000


def as_shown(text):
    """A printed text with the signs of views."""
    return unescape(escape(text))


def parsed(item):
    """Text and number of figures of the HTML of an object, after common checks."""
    html = item._repr_html_()
    assert len(html.encode()) <= MAX_BYTES
    assert not re.search(r"\b(nan|inf)\b", html)
    assert not re.search(r"(?:^|[;\"])color:(?!inherit)", html)
    root = ElementTree.fromstring(html)
    # Signs are those of figures, not of printed text.
    for text in root.itertext():
        assert not re.search(r"\+-|(?:\d |[\d/\[(])u(?:[JNgmsV]|Pa)\b|(?:^|[\s(\[])-[\d.]", text), (
            text
        )
    return " ".join(" ".join(root.itertext()).split()), len(root.findall(".//svg"))


@pytest.fixture(scope="module")
def result():
    return hc.fit(traces(), chain(), free=FREE)


def test_traces_show_signals_noise_and_notes():
    times, columns = recorded()
    columns["ball 5 [V]"] = -0.02 * columns.pop("ball 5 [N]")
    columns["wall [N]"][7] = np.nan
    data = hc.Traces.from_arrays(times, columns)
    text, figures = parsed(data)
    assert figures == 3
    assert "ball 5 [mV]" in text
    assert f"samples {len(times)} " in text
    for signal in data.shots[0].signals:
        assert signal.name in text
    assert "1 sample of wall in shot 1 is missing" in text
    # Two shots with more sensors than are drawn.
    more = dict(columns) | {f"ball {n} [N]": columns["wall [N]"] for n in (1, 3, 4, 6, 7)}
    several = hc.Traces.from_arrays(times, more) + data
    text, figures = parsed(several)
    assert figures == 6
    hidden = len(list(several)) - 6
    assert f"{hidden} more signals are not shown here; plot() shows all." in text


def test_comparisons_show_the_table_of_their_summary():
    found = hc.simulate(chain(), until=4e-4, times=3000).compare(traces())
    text, figures = parsed(found)
    assert figures == 3
    for each in found.sensors:
        assert as_shown(" ".join((each.name, *each.cells))) in text
    assert "before the record ends" in text
    # Data in V and the scaled simulation begin at the level before the pulse.
    times, columns = recorded()
    volts = hc.Traces.from_arrays(times, {"wall [V]": 0.3 + 0.02 * columns["wall [N]"]})
    found = hc.simulate(chain(), until=4e-4, times=3000).compare(volts)
    drawn = re.findall(r'd="M\S+ ([\d.]+)L[^"]*" fill="none" stroke="#', found._repr_html_())
    data, model = map(float, drawn)
    assert data == pytest.approx(model, abs=2.0)
    assert data < 90.0


def test_fits_show_parameters_verdict_and_notes(result):
    text, figures = parsed(result)
    with pytest.raises(hc.InputError, match=r"no entries.*values\['loss.time'\] and errors\['los"):
        result["loss.tine"]
    # Each sensor has a figure of data and fit, and one of the residuals.
    assert figures == 6
    assert text.count("residual over time") == 3
    # Each of these has about 150 points, and a band of two standard deviations.
    samples = len(result.traces.shots[0].times)
    drawn = 3 * -(-samples // -(-samples // 150))
    assert result._repr_html_().count("h0") == drawn
    assert f"{drawn} of {3 * samples} residuals are drawn; plot() shows all." in text
    assert result._repr_html_().count('fill="#8a8a8a" fill-opacity="0.25"') == 3
    for name, row in result.rows():
        assert as_shown(f"{name} {row}") in text
    # The restitution at the speed of the impact: half a change of the viscous time by its error.
    e, loss = result.restitution, result.chain.contact_losses[1]
    ends = [replace(loss, time=loss.time + d).restitution(e.speed, chain=result.chain)
            for d in (-result.errors["loss.time"], result.errors["loss.time"])]  # fmt: skip
    assert e.speed == result.values["struck_by.velocity"]
    assert ends[0] > e.value > ends[1]
    assert e.error == pytest.approx(0.5 * (ends[0] - ends[1]), rel=0.05)
    assert f"  {'  '.join(e.row)}\n" in result.summary()
    assert as_shown(" ".join(e.row)) in text
    assert result.as_dict()["restitution"]["error"] == e.error
    # Whether the model describes the data is stated first, as in the summary.
    verdict = result.verdict
    assert verdict in result.summary(width=None)
    stated = text.index(as_shown(f"{verdict[0].upper()}{verdict[1:]}."))
    assert stated < text.index("residual / noise")
    wrong = hc.fit(traces(), chain(), free=["time_offset"], diagnose=False)
    assert "the model does not describe the data. The errors below have" in parsed(wrong)[0]
    # Signals of all shots are drawn, with the number of the shot.
    wall = hc.Traces.from_arrays(recorded()[0], {"wall [N]": recorded()[1]["wall [N]"]})
    twice = hc.fit(wall + wall, chain(), free=["time_offset"], diagnose=False)
    both, figures = parsed(twice)
    assert figures == 4
    assert all(f"wall, shot {shot} [N]" in both for shot in (1, 2))
    # Names of parameters remain as they are typed in ``free``.
    names = {*result.names, *(each.name for each in result.constants)}
    typed = [note for note in result.warnings if note.split()[0] in names or "." in note.split()[0]]
    assert any(note.startswith("materials[") for note in typed)
    assert all(as_shown(note) in text for note in typed)
    assert all(as_shown(note[1:]) in text for note in result.warnings)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("cap.mass is taken as exact", "cap.mass is taken as exact."),
        ("time_offset, is weak", "time_offset, is weak."),
        ("gain[wall] is 1", "gain[wall] is 1."),
        ("stiffness: weak", "stiffness: weak."),
        ("the fit stopped", "The fit stopped."),
        ("", ""),
    ],
)
def test_names_of_parameters_are_not_capitalised(text, expected):
    assert sentence(text, ["stiffness"]) == expected


def test_comparisons_of_losses_and_scans_show_what_they_found(result):
    compared = hc.compare_losses(traces(), chain(), laws=["viscoelastic", "elastic"], free=FREE)
    text, _ = parsed(compared)
    for each in compared.fits:
        assert f"{each.law} {each.bic - compared.fits[0].bic:.1f} {each.result.chi2:.1f}" in text
    assert compared.statement[1:] in text
    assert [each.mark for each in compared.fits] == ["", "*"]
    assert f"{compared.fits[1].result.chi2:.1f}*" in text
    assert "* this law does not describe the data: its values and their errors" in text
    assert text.count("*") == compared.summary(width=None).count("*") == 2
    scan = hc.scan_defects(result)
    text, figures = parsed(scan)
    assert figures == 1
    assert scan.best in text
    assert ("no gap explains more than noise would" in text.lower()) is not scan.found


def test_long_records_stay_small():
    times = 1e-7 * np.arange(20_000)
    pulse = 30.0 * np.exp(-(((times - 1e-3) / 2e-4) ** 2))
    noise = np.random.default_rng(1).standard_normal((3, 20_000))
    names = ("ball 2 [N]", "ball 5 [N]", "wall [N]")
    columns = {name: pulse + own for name, own in zip(names, noise, strict=True)}
    parsed(hc.Traces.from_arrays(times, columns))


def test_forecasts_fits_and_comparisons_are_tables():
    traces, file = hc.example_experiment()
    chain = hc.load_chain(file)
    plan = hc.forecast(chain, ["ball 6"], noise=0.1, interval="1 us", free=["stiffness"])
    html = plan._repr_html_()
    for name, row in plan.rows():
        assert name in html
        assert row.replace("+-", "±") in html or row in html
    free = ["stiffness", "time_offset", "gain[*]"]
    result = hc.fit(traces, chain, free=free, diagnose=False)
    table = result.to_dataframe()
    assert table.value.to_dict() == result.values
    assert table.error.to_dict() == result.errors
    assert table.unit["time_offset"] == "s"
    compared = hc.simulate(chain, until=600e-6, times=1201).compare(traces)
    rows = compared.to_dataframe()
    assert [*rows.index] == [each.name for each in compared.sensors]
    assert rows.delay["wall"] == compared.sensors[-1].delay
    assert rows.residual.to_dict() == compared.differences


def test_signs_are_those_of_figures():
    for printed, shown in (
        ("-3.5 +- 0.2 us, 2 N/um^1.5 [us]", "\N{MINUS SIGN}3.5 ± 0.2 µs, 2 N/µm^1.5 [µs]"),
        ("(-1e-06 to 2e-07)", "(\N{MINUS SIGN}1e\N{MINUS SIGN}06 to 2e\N{MINUS SIGN}07)"),
        # Ranges, words and code remain.
        ("balls 3-5, steel-304, at='-1', x=-1, 2026-01-02, us", None),
    ):
        assert as_shown(printed) == (shown or printed)
