import json

import pytest
from click.testing import CliRunner

import hertzchain as hc
from hertzchain.verification.case import ORIGINS, Case
from hertzchain.verification.cases import cases
from hertzchain.verification.verify import Verdict, verify


@pytest.mark.parametrize("case", cases(), ids=lambda case: f"{case.group}: {case.name}")
def test_known_value(case):
    verdict = Verdict(case, case.compute())
    assert verdict.agrees, f"{verdict.ours!r} instead of {case.expected!r}"


def test_a_wrong_value_is_outside():
    case = Case("a group", "a number", 1.0, 1e-9, "nowhere", lambda: 1.0 + 2e-9)
    assert not Verdict(case, case.compute()).agrees


def test_an_unknown_group_is_rejected():
    with pytest.raises(hc.InputError, match=r"unknown group of cases 'wals'.*did you mean 'walls'"):
        verify(["wals"])


def test_command_line(run):
    agreeing = sum(case.group == "restitution" for case in cases())
    command = "verify", "--only", "restitution"
    shown = run(*command).stdout
    assert f"{agreeing} of {agreeing} cases agree" in shown
    # The table has the numbers of the sources, which are listed below it.
    assert "[2]" in shown.partition("Tsuji")[0]
    assert "Tsuji et al., Powder Technol. 71, 239 (1992) (derived)" in shown
    assert json.loads(run(*command, "--json").stdout)["agreeing"] == agreeing


def test_every_case_has_its_place_and_origin():
    every = cases()
    assert len({(case.group, case.name) for case in every}) == len(every) > 120
    for case in every:
        assert case.origin in ORIGINS
        assert case.source
        # An exact number of waves; anything else has a last digit.
        assert case.tolerance > 0.0 or case.name.startswith("number of waves")


def test_the_table_is_at_most_100_columns_wide(monkeypatch):
    import hertzchain.cli.verify as command

    monkeypatch.setattr("hertzchain.verify", lambda *_, **__: [
        Verdict(case, case.expected + (case.group == "walls")) for case in cases()
    ])  # fmt: skip
    shown = CliRunner().invoke(command.verify, ["--only", "walls"], standalone_mode=False)
    lines = [line.rstrip() for line in shown.stdout.splitlines()]
    assert max(map(len, lines)) <= 100
    assert shown.return_value == 3
    assert "cases marked ! are outside" in lines[0]
    assert sum(line.startswith("!") for line in lines) == 3


def test_what_a_truncated_series_is_allowed_is_its_next_term():
    (wide,) = (c for c in cases() if c.name == "attractive, B = 0.05, to second order")
    assert abs(Verdict(wide, wide.compute()).difference) > 0.9 * wide.tolerance
