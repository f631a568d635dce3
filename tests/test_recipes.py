"""The recipes of docs/how-to/extend*.md, each applied to a copy of the package and tried.

A recipe is a section with diffs, which are applied to the copy, and a block of Python, which runs
there in a separate process and must not fail.
"""

import ast
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PAGES = sorted((ROOT / "docs" / "how-to").glob("extend*.md"))
# Recipes whose number of source files is promised by the page.
MAX_FILES = 2
# A directive that shows a class of a gallery script.
INCLUDE = r"^```\{literalinclude\} (\S+)\n:language: python\n:pyobject: (\w+)\n```$"


def sections():
    """Title, diffs and Python blocks of each section."""
    pages = "\n".join(page.read_text("utf-8") for page in PAGES)
    for section in re.split(r"^## ", pages, flags=re.M)[1:]:
        title, _, text = section.partition("\n")
        text = re.sub(INCLUDE, included, text, flags=re.M)
        diffs = re.findall(r"^```diff\n(.*?)^```$", text, re.M | re.S)
        blocks = re.findall(r"^```python\n(.*?)^```$", text, re.M | re.S)
        yield title, diffs, blocks


def recipes():
    """Parameters of the sections that have a diff."""
    return [pytest.param(diffs, blocks, id=title) for title, diffs, blocks in sections() if diffs]


def scripts():
    """Parameters of the sections without a diff: their blocks and included classes as a script."""
    return [
        pytest.param("\n\n".join(blocks), id=title)
        for title, diffs, blocks in sections() if not diffs and blocks
    ]  # fmt: skip


def included(found):
    """A block of Python with the class that a directive includes."""
    path, name = found.groups()
    text = (ROOT / "docs" / "how-to" / path).read_text("utf-8")
    (node,) = (each for each in ast.parse(text).body if getattr(each, "name", "") == name)
    first = min(each.lineno for each in (node, *node.decorator_list))
    lines = text.splitlines()[first - 1 : node.end_lineno]
    return "```python\n" + "\n".join(lines) + "\n```"


@pytest.mark.long
@pytest.mark.parametrize(("diffs", "blocks"), recipes())
def test_recipes_work(diffs, blocks, tmp_path):
    # With modification times, so that what is compiled stays valid.
    shutil.copytree(ROOT / "src", tmp_path / "src", copy_function=shutil.copy2)
    touched = set()
    for diff in diffs:
        touched |= set(re.findall(r"^\+\+\+ b/(src/\S+\.py)$", diff, re.M))
        done = subprocess.run(
            ["git", "apply", "--recount", "--whitespace=nowarn", "-"],
            cwd=tmp_path, input=diff, text=True, capture_output=True, check=False,
            env={**os.environ, "GIT_CEILING_DIRECTORIES": str(tmp_path.parent)},
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
    assert 1 <= len(touched) <= MAX_FILES
    assert blocks, "a recipe must show that it works"
    for block in blocks:
        done = subprocess.run(
            [sys.executable, "-W", "error", "-c", block],
            cwd=tmp_path, text=True, capture_output=True, check=False,
            env={**os.environ, "PYTHONPATH": str(tmp_path / "src"), "MPLBACKEND": "agg"},
        )  # fmt: skip
        assert done.returncode == 0, done.stderr


def test_the_page_has_a_law_for_a_script():
    assert [each.id for each in scripts()] == ["A loss law in a script"]


@pytest.mark.parametrize("block", scripts())
def test_scripts_work_without_a_change_of_the_package(block, tmp_path):
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", block], cwd=tmp_path, text=True, capture_output=True,
        check=False, env={**os.environ, "PYTHONPATH": str(ROOT / "src"), "MPLBACKEND": "agg"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr


def test_the_page_has_all_recipes():
    titles = {param.id for param in recipes()}
    expected = {"taper", "theory", "loss law", "wall with its own law", "quantity", "integrator",
                "plot"}  # fmt: skip
    assert expected <= {title.split(" ", 2)[2] for title in titles if title.startswith("Add a")}
