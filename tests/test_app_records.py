"""Measured data in the app: reading, alignment, saved pages, and the command."""

import base64
import json
import re
from dataclasses import replace

import click
import numpy as np
import pytest
from app_client import Client, computed, serving, unpacked

import hertzchain as hc
from hertzchain.app.record_curves import MAX_SAMPLES, record_curves
from hertzchain.app.records import keep, places_in, read_record, record_of_file
from hertzchain.app.results import limited
from hertzchain.cli import cli
from hertzchain.fitting.compare_traces import compare_traces

LAB = {
    "chain": {"radii": "5 mm", "beads": 12, "materials": "steel-52100", "right_wall": {},
              "velocity": "0.3 m/s"}
}  # fmt: skip
OFFSET = 37e-6


@pytest.fixture(scope="module")
def scope(tmp_path_factory):
    """A file of an oscilloscope: the simulation, later by a known time, and noise."""
    chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=12, velocity=0.3)
    chain = chain.replace(right_wall=hc.Wall())
    run = hc.simulate(chain, until=400e-6, times=4001)
    noise = np.random.default_rng(3)
    times = np.arange(-500, 4001) * 1e-7
    ball, wall = (np.interp(times, run.times, each) for each in (run.sensor(6), run.forces[:, -1]))
    ball += noise.normal(0.0, 0.05, len(times))
    volts = 0.02 * wall + noise.normal(0.0, 0.002, len(times))
    rows = zip(times + OFFSET, ball, volts, strict=True)
    text = "Model,X1\nTIME,CH1,CH2\n" + "".join(f"{t:.8g},{a:.6g},{b:.6g}\n" for t, a, b in rows)
    file = tmp_path_factory.mktemp("scope") / "scope.csv"
    file.write_text(text)
    return file


PLACES = "TIME=time [s], CH1=ball 6 [N], CH2=wall [V]"


def test_a_record_is_aligned_and_scaled_as_by_compare(scope):
    found = read_record({"name": "scope.csv", "text": scope.read_text(), "sensors": PLACES})
    assert (found["name"], found["balls"]) == ("scope.csv", [6])
    header, arrays = computed(LAB, sensors=[6], record=found["record"])["run"]
    measured = header["record"]
    assert measured["aligned"]
    assert measured["offset"] == pytest.approx(OFFSET, abs=1e-7)
    # As from the command line, the error has a condition, and a time that is given says so.
    aligned, condition = measured["notes"]
    begin, error = re.fullmatch(
        r"by least squares, the simulation begins at (\S+) ± (\S+) µs", aligned
    ).groups()
    assert condition == "the error of this time assumes that the chain is right"
    assert measured["given"] == [
        "the time at which the simulation begins is given; "
        f"by least squares, it is {begin} ± {error} µs"
    ]
    assert abs(1e-6 * float(begin) - OFFSET) < 4e-6 * float(error) < 4e-7
    ball, wall = measured["curves"]
    # The legend has the numbers of `Run.compare`: the peak with the noise, and three differences.
    peak, difference, arrival, residual = re.fullmatch(
        r": (\S+) N, simulated ([+-]\S+)%; arrival ([+-]\S+) µs; residual (\S+)%", ball["note"]
    ).groups()
    assert float(peak) == pytest.approx(arrays["force.6"].max(), rel=0.005)
    assert abs(float(difference)) < 0.5
    assert abs(float(arrival)) < 0.1
    # The noise is 0.05 N.
    assert float(residual) == pytest.approx(5.0 / float(peak), abs=0.05)
    assert ball["label"] == "ball 6"
    assert re.fullmatch(r"wall in V \((20|19\.99|20\.01) mV/N\)", wall["label"])
    assert re.match(r": \S+ m?V, simulated [+-]\S+%; arrival .* µs; residual ", wall["note"])
    assert [each["place"] for each in measured["curves"]] == ["6", "right"]
    # The measured curves are the simulated ones and noise, at the same times.
    for key, curve, noise in (("0", "6", 0.3), ("1", "right", 0.7)):
        simulated = np.interp(
            arrays[f"record.times.{key}"], arrays["forces.times"], arrays[f"force.{curve}"]
        )
        inside = arrays[f"record.times.{key}"] <= arrays["forces.times"][-1]
        assert np.abs(arrays[f"record.{key}"] - simulated)[inside].max() < noise
    assert computed(LAB, record=found["record"], draft=True)["run"][0]["record"] is None


@pytest.mark.long
def test_many_samples_are_thinned_with_their_extremes(scope):
    record = record_of_file(scope, places_in(PLACES))
    chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=12, velocity=0.3)
    chain = chain.replace(right_wall=hc.Wall())
    shot = record.traces.shots[0]
    fine = np.linspace(shot.times[0], shot.times[-1], 30_001)
    signals = {
        f"{each.name} [{each.unit}]": np.interp(fine, shot.times, each.values)
        for each in shot.signals
    }
    traces = hc.Traces.from_arrays(fine, signals)
    long = type(record)("long.csv", traces)
    _, arrays = record_curves(chain, long, 400e-6, limited(lambda: False))
    assert len(arrays["record.0"]) <= MAX_SAMPLES
    assert np.all(np.diff(arrays["record.times.0"]) > 0.0)
    assert arrays["record.0"].max() == traces.shots[0].signals[0].values.max()


@pytest.mark.parametrize(
    ("name", "text", "places", "said"),
    [
        ("scope.csv", "TIME,CH1\n0,1\n1,2\n", "", "scope.csv: column"),
        ("a.csv", "t [s],CH1 [N]\n0,1\n1,2\n", "", "enter CH1=wall as the sensors"),
        ("lab.docx", "", "", "lab.docx is not a CSV file"),
        ("../x.csv", "no table", "", "x.csv"),
        ("a.csv", "time [s],wall [N]\n0,1\n", "CH1", "'CH1' names no column and place"),
    ],
)  # fmt: skip
def test_a_bad_file_has_one_clear_sentence(name, text, places, said):
    with pytest.raises(hc.InputError, match=re.escape(said)) as found:
        read_record({"name": name, "text": text, "sensors": places})
    assert "/tmp" not in str(found.value)
    assert "load_traces" not in str(found.value)


def test_records_that_cannot_be_compared_say_why(scope):
    key = keep(record_of_file(scope, places_in("TIME=time [s], CH1=ball 20 [N]")))["record"]
    header, arrays = computed(LAB, record=key)["run"]
    measured = header["record"]
    assert not measured["aligned"]
    assert "not aligned: the traces have a sensor in ball 20" in measured["notes"][0]
    # All sensors in V share a sentence.
    volts = places_in("TIME=time [s], CH1=ball 20 [V], CH2=wall [V]")
    volt = keep(record_of_file(scope, volts))["record"]
    reason, others = computed(LAB, record=volt)["run"][0]["record"]["notes"]
    assert reason.startswith("not aligned: ")
    assert others.startswith("ball 20 and wall are in V, and are shown only if they can be")
    # The data are shown at their own times, and can be shifted on the page.
    assert measured["offset"] == 0.0
    assert len(arrays["record.0"]) > 4000
    (note,) = computed(LAB, record="unknown")["run"][0]["record"]["notes"]
    assert note == "the server no longer has the measured data; choose the file again"
    scaled = {"chain": {"taper": "uniform", "beads": 12}}
    (note,) = computed(scaled, record=key)["run"][0]["record"]["notes"]
    assert note.startswith("measured data are in SI units")


def test_the_server_reads_records(scope):
    with serving(LAB) as running:
        client = Client(running)
        body = {"name": "scope.csv", "text": scope.read_text(), "sensors": PLACES}
        answer = client.ask("POST", "/api/record", body).content
        assert json.loads(answer)["balls"] == [6]
        answer = client.ask("POST", "/api/record", body | {"sensors": "CH7=wall"}).content
        assert "CH7" in json.loads(answer)["error"]


@pytest.fixture
def lab(tmp_path):
    file = tmp_path / "lab.toml"
    file.write_text(
        '[chain]\nradii = "5 mm"\nbeads = 12\nmaterials = "steel-52100"\nvelocity = "0.3 m/s"\n'
        "right_wall = {}\n"
    )
    return file


def test_a_saved_page_contains_the_record(scope, lab, tmp_path):
    page = tmp_path / "page.html"
    sensors = [item for each in PLACES.split(", ") for item in ("--sensor", each)]
    given = ["app", str(lab), "--data", str(scope), *sensors, "--sensor", "ball 3"]
    cli.main([*given, "--save", str(page)], standalone_mode=False)
    stored = json.loads(re.search(r'id="embedded">(.*?)</script>', page.read_text("utf-8"))[1])
    assert stored["about"]["view"]["view"]["sensors"] == [3, 6]
    run = {h["part"]: (h, a) for h, a in unpacked(base64.b64decode(stored["parts"]))}["run"]
    assert run[0]["record"]["name"] == "scope.csv"
    assert run[0]["record"]["offset"] == pytest.approx(OFFSET, abs=1e-7)
    assert len(run[1]["record.0"]) > 4000


def test_the_live_app_begins_with_the_chains_sensors_and_data_of_the_options(
    scope, lab, monkeypatch
):
    seen = []

    class Server:
        port, address = 8765, "there"

        def __init__(self, _, document, view):
            seen.append((document, view))

        def run(self, ready):
            pass

    monkeypatch.setattr("hertzchain.app.serve.RunningServer", Server)
    given = ["app", str(lab), "--no-open", "--compare", str(lab), "--sensor", "ball 4"]
    cli.main([*given, "--until", "2ms"], standalone_mode=False)
    cli.main(["app", str(lab), "--data", str(scope), "--sensor", "TIME=time [s]",
              "--sensor", "CH1=ball 6 [N]"], standalone_mode=False)  # fmt: skip
    cli.main(["app", "--until", "1ms"], standalone_mode=False)
    cli.main(["app"], standalone_mode=False)
    (document, view), (_, measured), (default, until), (_, nothing) = seen
    assert view["B"] == document
    assert view["view"] == {"sensors": [4], "errors": "difference", "until": 2e-3}
    assert measured["view"]["sensors"] == [6]
    assert measured["record"]["name"] == "scope.csv"
    # Without sensors, the page begins with that of its first chain.
    assert (default, nothing) == (None, None)
    assert until["view"] == {"errors": "theories", "until": 1e-3}
    with pytest.raises(click.UsageError, match="'CH1=wall' is the place of a column: add --data"):
        cli.main(["app", str(lab), "--sensor", "CH1=wall"], standalone_mode=False)


def test_a_signal_with_an_absurd_scale_does_not_extend_the_axis(scope, monkeypatch):
    head, *rows = scope.read_text().splitlines()[1:]
    # The sensor in a ball shows a spike before the pulse, and noise instead of it.
    lines = [head]
    for i, row in enumerate(rows):
        time, ball, _ = row.split(",")
        lines.append(f"{time},{ball},{1.5 if i == 20 else 0.5 + 1e-5 * float(ball):.6g}")
    text = "\n".join(lines) + "\n"
    record = keep_of(text)
    header, arrays = computed(LAB, sensors=[6], record=record)["run"]
    shown = header["record"]
    assert [each["place"] for each in shown["curves"]] == ["6"]
    assert "record.1" not in arrays
    said = r"wall is not shown: with the fitted scale of .* .?V/N, it would reach"
    assert any(re.search(said, each) for each in shown["notes"])
    # The page draws the samples without their level, and the simulation as it is.
    level = "before the pulse, wall is at 500 mV; the comparison is without this level; "
    assert any(each.startswith(level) for each in shown["notes"])
    # If columns are exchanged, no scale means anything; forces in N are shown as they are.
    monkeypatch.setattr(
        "hertzchain.app.record_curves.compare_traces",
        lambda *each: replace(compare_traces(*each), exchanged=True),
    )
    header, arrays = computed(LAB, sensors=[6], record=record)["run"]
    # The page marks all remarks as an error: no level of a column that is not that of its sensor.
    said = "wall is in V, and is not shown until this is corrected"
    assert header["record"]["notes"][1:] == header["record"]["given"][1:] == [said]
    assert ("record.0" in arrays, "record.1" in arrays) == (True, False)
    assert header["record"]["exchanged"]
    assert not any("by least squares" in each for each in header["record"]["notes"])


def keep_of(text):
    return read_record({"name": "scope.csv", "text": text, "sensors": PLACES})["record"]
