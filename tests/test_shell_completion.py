"""Names that the shell completes with the Tab key."""

import pytest
from click.shell_completion import ShellComplete

from hertzchain.cli import cli


@pytest.mark.parametrize(
    ("words", "typed", "expected"),
    [
        ((), "sc", ["scatter", "scoreboard"]),
        (("simulate", "--material"), "steel-5", ["steel-52100"]),
        (("simulate", "--material"), "ptfe,steel-5", ["ptfe,steel-52100"]),
        (("scatter", "--grade"), "1", ["10", "16", "100"]),
        (("scatter", "--grade"), "G2", ["G20", "G24", "G28", "G200"]),
        (("scatter", "--quantity"), "arr", ["arrival@last"]),
        (("sensitivity", "--quantity"), "wall_force.p", ["wall_force.peak"]),
        (("scatter",), "--speed-", ["--speed-scatter"]),
    ],
)
def test_names_are_completed(words, typed, expected):
    shell = ShellComplete(cli, {}, "hertzchain", "_HERTZCHAIN_COMPLETE")
    assert [each.value for each in shell.get_completions([*words], typed)] == expected
