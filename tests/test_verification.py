import json
import subprocess
import sys
from pathlib import Path

import pytest

import hertzchain as hc
from hertzchain.verification.cases import Case, cases
from hertzchain.verification.verify import Verdict, verify


@pytest.mark.parametrize("case", cases(), ids=lambda case: f"{case.group}: {case.name}")
def test_known_value(case):
    verdict = Verdict(case, case.compute())
    assert verdict.agrees, f"{verdict.ours!r} instead of {case.expected!r}"


def test_a_wrong_value_is_outside():
    case = Case("a group", "a number", 1.0, 1e-9, "nowhere", lambda: 1.0 + 2e-9)
    assert not Verdict(case, case.compute()).agrees


def test_an_unknown_group_is_refused():
    with pytest.raises(hc.InputError, match=r"unknown group of cases 'wals'.*did you mean 'walls'"):
        verify(["wals"])


def test_command_line():
    command = [Path(sys.executable).parent / "hertzchain", "verify", "--only", "restitution"]
    shown = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert "12 of 12 cases agree" in shown
    document = subprocess.run([*command, "--json"], capture_output=True, text=True, check=True)
    assert json.loads(document.stdout)["agreeing"] == 12
