"""With --json, the warnings on standard error are in the document, too."""

import json

import pytest

pytestmark = pytest.mark.filterwarnings("always")
BEYOND = ["--material", "steel-304", "--diameter", "10 mm", "--beads", 4, "--speed", "1 m/s",
          "--wall", "same"]  # fmt: skip


@pytest.mark.parametrize("command", [
    ("simulate", "--until", "40 us"), ("pulse", "--method", "simulate"), ("sensitivity",),
    ("scatter", "--scatter", "1%", "--chains", 4),
])  # fmt: skip
def test_documents_have_the_printed_warnings_once(run, command):
    done = run(*command, *BEYOND, "--json")
    printed = [line.removeprefix("Warning: ") for line in done.stderr.splitlines()
               if line.startswith("Warning: ")]  # fmt: skip
    assert printed
    assert json.loads(done.stdout)["warnings"] == printed


def test_warnings_of_an_earlier_command_are_not_repeated(run):
    run("pulse", *BEYOND, "--method", "simulate", "--json")
    done = run("pulse", "--beads", 3, "--json")
    assert (done.stderr, json.loads(done.stdout)["warnings"]) == ("", [])
