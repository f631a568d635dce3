"""The style checker finds expressions in prose and skips code, formulas and quotations."""

import check_style
import pytest


def found(text, suffix=".md", **options):
    return [
        finding
        for paragraph in check_style.READERS[suffix](text)
        for finding in check_style.search(paragraph, **options)
    ]


@pytest.mark.parametrize(
    "sentence",
    [
        "Steps end there, lest a digit be lost.",
        "We hold the theory against the simulation.",
        "The same command goes on where it stopped.",
        "The table has a row a bead.",
        "This chain is no taper.",
        "It copies all of what it reads.",
        "What the theory predicts: velocities.",
        "The kernel knows the radii.",
        "The price of a bench with walls.",
        "All entries have the very digits.",
        "The error is two per cent.",
    ],
)
def test_each_error_is_found(sentence):
    (finding,) = found(f"Text before it.\n\n{sentence}\n")
    assert finding.level == "error"
    assert finding.line == 3


def test_errors_are_found_across_lines():
    (finding,) = found("The tables hold each number\nagainst the paper.\n")
    assert finding.text == "hold each number against"


def test_suggestions_are_optional():
    text = "The names stand in a table.\n"
    assert found(text) == []
    assert [finding.level for finding in found(text, suggestions=True)] == ["suggestion"]


@pytest.mark.parametrize(
    "text",
    [
        "```python\nprint('it knows')\n```\n",
        "    it knows\n",
        "> The paper refuses it.\n",
        "The option `knows` and the file [here](knows.md).\n",
        "The caption is “what it knows”.\n",
        "$$\nknows\n$$\n",
        "With $knows = 1$ it is finite.\n",
        "There is no wall, and it is no longer than before.\n",
    ],
)
def test_code_formulas_and_quotations_are_skipped(text):
    assert found(text, suggestions=True) == []


MODULE = '''"""A module that knows nothing.

    >>> knows = "knows"
    'knows'

.. math:: knows

Text after it tells more.
"""

# A comment that
# refuses lists.
def function(value):
    """One line."""
    knows = value  # noqa: F841
    raise ValueError(f"{value!r} is a number that the method refuses, " "and judges")
'''


def test_docstrings_comments_and_messages_are_searched():
    findings = sorted((each.line, each.text) for each in found(MODULE, ".py"))
    assert findings == [
        (1, "knows"),
        (8, "tells"),
        (12, "refuses"),
        (16, "judges"),
        (16, "refuses"),
    ]


def test_templates_are_searched_without_their_tags():
    text = "<style>\nknows\n</style>\n<p class='knows'>It {{ knows }}\nrefuses.</p>\n"
    assert [(each.line, each.text) for each in found(text, ".j2")] == [(5, "refuses")]


def test_exit_code_and_skipped_folders(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(check_style, "ROOT", tmp_path)
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs" / "page.md").write_text("It knows.\n", "utf-8")
    assert check_style.main(["docs/page.md"]) == 1
    assert capsys.readouterr().out.startswith("docs/page.md:1: error: ")
    assert check_style.main(["docs/page.md", "--skip", "docs"]) == 0
    assert capsys.readouterr().out == ""
