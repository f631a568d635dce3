"""Lines of the command line on a narrow terminal, and in files and pipes."""

import os
import sys

import pytest

from hertzchain.cli.wrapped_text import show_text, wrapped

ORDER = "order: " + ", ".join(["6.35 mm steel-52100"] * 9)


@pytest.mark.parametrize("width", [40, 80, 100])
def test_long_lines_are_wrapped_and_indented(width):
    text = f"Smallest wall_force.peak: 12.79 N\n\n  {ORDER}\n  length <= 60 mm:   48.7 mm"
    first, empty, *long, last = wrapped(text, width).split("\n")
    assert (first, empty) == ("Smallest wall_force.peak: 12.79 N", "")
    assert last == "  length <= 60 mm:   48.7 mm"
    assert len(long) > 1
    assert all(len(line) <= width for line in long)
    assert long[0].startswith("  order: 6.35 mm")
    assert all(line.startswith("      ") and line[6] != " " for line in long[1:])
    assert " ".join(map(str.strip, long)) == ORDER


def test_words_are_not_broken():
    path = "/".join(["folder"] * 20)
    assert wrapped(f"written to {path}", 40) == f"written to\n    {path}"


def test_files_and_pipes_have_whole_lines(monkeypatch, capsys):
    monkeypatch.setattr("shutil.get_terminal_size", lambda: os.terminal_size((80, 24)))
    show_text(ORDER)
    assert capsys.readouterr().out == f"{ORDER}\n"
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True, raising=False)
    show_text(ORDER)
    assert capsys.readouterr().out == wrapped(ORDER, 80) + "\n"
