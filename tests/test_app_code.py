"""The code of the app's page: its pure functions, types and style; and its size."""

import gzip
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from hertzchain.app.static_files import static_files
from hertzchain.app.yield_notes import AT_MOST, IF_YIELDING

ROOT = Path(__file__).parents[1]
TOOLS = ROOT / "tools/page"
VIEWS = ROOT / "src/hertzchain/app/static/js/views.js"
NODE = shutil.which("node")

needs_node = pytest.mark.skipif(NODE is None, reason="code of the page not tested: no node")


def run(*command):
    done = subprocess.run(
        [NODE, *map(str, command)], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def tool(path):
    found = TOOLS / "node_modules" / path
    if not found.exists():
        pytest.skip(f"{found.name} is not installed (npm install in tools/page)")
    return found


@needs_node
def test_pure_functions():
    tests = sorted((ROOT / "tests/page").glob("*.test.js"))
    assert "fail 0" in run("--test", *tests)


@needs_node
def test_types():
    run(tool("typescript/bin/tsc"), "-p", TOOLS / "tsconfig.json")


@needs_node
def test_style():
    lint = tool("eslint/bin/eslint.js")
    run(lint, "--config", TOOLS / "eslint.config.js", "src/hertzchain/app/static/js", "tests/page")


def test_the_page_is_small_and_complete():
    files = {path: file for path, file in static_files().items() if path != "/"}
    # With the description of the program and the results, the page makes two more requests.
    assert len(files) <= 23
    # Measured data over the simulated forces are 5 kB of these, 2 kB compressed.
    assert sum(len(file.content) for file in files.values()) < 190_000
    assert sum(len(gzip.compress(file.content)) for file in files.values()) < 64_000
    sources = {path: file.content.decode() for path, file in files.items()}
    named = re.findall(r'(?:src|href)="(/[^"]+)"', sources["/index.html"])
    named += [f"/js/{name}" for path, text in sources.items() if path.endswith(".js")
              for name in re.findall(r'from "\./([^"]+)"', text)]  # fmt: skip
    assert set(named) == set(files) - {"/index.html"}


def test_the_page_obeys_its_own_policy():
    for path, file in static_files().items():
        text = file.content.decode()
        assert not re.search(r"https?://(?!www\.w3\.org/|127\.0\.0\.1:)", text), path
        if path.endswith(".js"):
            assert not re.search(r"innerHTML\s*=|\beval\(|new Function|insertAdjacentHTML", text)
        if path.endswith(".html"):
            assert not re.search(r'\sstyle="|\son\w+="|<script>', text)


def test_the_page_knows_the_label_of_the_largest_yield_pressure():
    (pattern,) = re.findall(r"AT_MOST = /(.+?)/;", VIEWS.read_text("utf-8"))
    assert re.search(pattern, AT_MOST)
    assert not re.search(pattern, IF_YIELDING)
