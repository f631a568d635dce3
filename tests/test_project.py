"""Import times, public docstrings, tracked files and versions of the project."""

import ast
import doctest
import inspect
import os
import re
import subprocess
import sys
from dataclasses import fields
from pathlib import Path

import count_lines
import numpy as np
import pytest
from documented import entries, public_classes, public_functions
from numpydoc.docscrape import FunctionDoc

import hertzchain as hc

ROOT = Path(__file__).parent.parent
HEAVY = ("numba", "matplotlib", "xarray", "zarr", "dask", "pandas", "scipy", "jinja2", "rich")


def test_import_loads_no_heavy_packages():
    code = (
        "import sys, hertzchain as hc; hc.Chain, hc.Pulse, hc.simulate, hc.bca, hc.modified_bca;"
        "hc.hard_sphere, hc.solitary_wave, hc.effective_chain;"
        f"print([name for name in {HEAVY} if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_help_loads_little():
    code = (
        "import sys; import hertzchain.cli;"
        f"print([name for name in {(*HEAVY, 'numpy')} if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_importing_is_quick():
    # CPU time of the import itself; it takes 0.01 s, and 0.1 s is promised.
    code = (
        "import time; began = time.process_time(); import hertzchain;"
        "print(time.process_time() - began)"
    )
    command = [sys.executable, "-c", code]
    times = [float(subprocess.run(command, capture_output=True, check=True).stdout)
             for _ in range(3)]  # fmt: skip
    assert min(times) < 0.1


def test_the_places_named_in_contributing_exist():
    text = (ROOT / "CONTRIBUTING.md").read_text("utf-8")
    rows = [row for row in text.splitlines() if row.startswith("|") and "](docs/" in row]
    code = [name for row in rows for name in re.findall(r"`([a-z_/]+(?:\.py|/laws))`", row)]
    pages = [name for row in rows for name in re.findall(r"\]\((docs/[^)#]+)", row)]
    assert len(rows) >= 8
    assert [name for name in code if not (ROOT / "src" / "hertzchain" / name).exists()] == []
    assert [name for name in pages if not (ROOT / name).exists()] == []
    assert len(code) > len(rows)


@pytest.mark.parametrize(
    "package", ["chain", "simulation", "theory", "traces", "fitting", "designs"]
)
def test_large_packages_list_their_modules(package):
    folder = ROOT / "src" / "hertzchain" / package
    packages = {path.parent.name for path in folder.glob("*/__init__.py")}
    modules = {path.stem for path in folder.glob("*.py")} - {"__init__"} | packages
    listed = ast.get_docstring(ast.parse((folder / "__init__.py").read_text("utf-8")))
    topics = listed[listed.index("\n- ") :].partition(".\n\n")[0]
    assert set(re.findall(r"`(\w+)`", topics)) == modules


def test_all_public_names_are_there():
    for name in hc.__all__:
        assert getattr(hc, name) is not None
    assert set(hc.__all__) <= set(dir(hc))


def test_completion_does_not_offer_internals():
    chain = hc.Chain.uniform(4)
    run = hc.simulate(chain)
    for item, internal, public in (
        (chain, {"given", "features", "contact_groups", "loads"}, {"radii", "replace", "beads"}),
        (hc.Chain, {"features", "contact_groups", "loads"}, {"uniform", "replace", "beads"}),
        (run, {"prediction", "evaluations"}, {"velocities", "waves", "status"}),
    ):
        assert not internal & set(dir(item))
        assert public <= set(dir(item))
        assert all(hasattr(item, name) for name in internal)


def documented_names():
    """Public names by module, from the tables and data of all pages of the reference."""
    found = {}
    for page in (ROOT / "docs" / "reference").glob("*.md"):
        text = page.read_text("utf-8")
        for module, name in entries(page):
            found.setdefault(module, set()).add(name)
        for module, name in re.findall(r"^\.\. py:data:: (hertzchain[\w.]*)\.(\w+)", text, re.M):
            found.setdefault(module, set()).add(name)
    return found


def test_completion_offers_documented_names_only():
    page = (ROOT / "docs" / "reference" / "api.md").read_text("utf-8")
    packages = re.findall(r"^\| `hertzchain\.(\w+)`", page, re.M)
    for name in hc.__all__:
        getattr(hc, name)  # Loading submodules must not add names.
    assert sorted(dir(hc)) == sorted(hc.__all__)
    modules = {name for name in dir(hc) if inspect.ismodule(getattr(hc, name))}
    assert modules == set(packages)
    documented = documented_names()
    anywhere = set().union(*documented.values()) | set(hc.__all__)
    anywhere |= {name for name, _ in inspect.getmembers(hc.vary, inspect.isfunction)}
    for package in packages:
        module = getattr(hc, package)
        offered = set(dir(module))
        assert documented.get(module.__name__, set()) <= offered <= anywhere
        assert all(getattr(module, name) is not None for name in offered)


def test_every_public_name_is_in_the_api_reference():
    page = ROOT / "docs" / "reference" / "api.md"
    tables = [name for _, name in entries(page)]
    data = re.findall(r"^\.\. py:data:: (\w+)", page.read_text("utf-8"), re.M)
    packages = re.findall(r"^\| `hertzchain\.(\w+)`", page.read_text("utf-8"), re.M)
    assert sorted([*tables, *data, *packages]) == sorted(hc.__all__)


def pages():
    written = (path for path in (ROOT / "docs").rglob("*.md") if path.parent.name[0] != "_")
    return [ROOT / "README.md", *sorted(written)]


@pytest.mark.parametrize("path", pages(), ids=lambda path: path.name)
def test_every_name_in_the_documentation_exists(path):
    text = path.read_text("utf-8")
    for chain in sorted(set(re.findall(r"\bhc((?:\.[A-Za-z_]\w*)+)", text))):
        item = hc
        for name in chain[1:].split("."):
            if not hasattr(item, "__name__"):
                break  # An object, of which the pages are run as doctests.
            assert hasattr(item, name), f"{path.name}: hc{chain}"
            item = getattr(item, name)


def test_pages_import_documented_packages_only():
    # A how-to page needs `hc.`, or a subpackage whose names are in its `__all__`.
    for path in [*(ROOT / "docs/how-to").glob("*.md"), *(ROOT / "docs/tutorial").glob("*.md")]:
        for module in re.findall(r">>> from (hertzchain[\w.]*) import", path.read_text("utf-8")):
            assert module.count(".") < 2, f"{path.name}: {module}"


FUNCTIONS = public_functions()
PUBLIC = FUNCTIONS | public_classes()


@pytest.mark.parametrize("name", FUNCTIONS)
def test_public_functions_are_documented(name):
    documentation = FunctionDoc(FUNCTIONS[name])
    assert documentation["Summary"], f"{name} has no summary"
    described = {
        part.strip().lstrip("*")
        for parameter in documentation["Parameters"]
        for part in parameter.name.split(",")
    }
    function = FUNCTIONS[name]
    arguments = set(inspect.signature(function).parameters) - {"self", "cls"}
    if hasattr(function, "__signature__"):
        # The signature has the fields of a class, which documents them.
        arguments, described = arguments - {each.name for each in fields(hc.Chain)}, set()
    assert arguments == described
    assert documentation["Examples"], f"{name} has no example"


@pytest.mark.parametrize("name", PUBLIC)
def test_public_examples_begin_with_the_import(name):
    examples = doctest.DocTestParser().get_examples(inspect.getdoc(PUBLIC[name]))
    if examples:  # They run in an empty namespace, see conftest.py.
        assert examples[0].source.startswith("import hertzchain as hc")


def tracked_files():
    done = subprocess.run(
        ["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    return [ROOT / name for name in done.stdout.split("\0") if name]


def test_no_tracked_file_names_a_machine():
    files = tracked_files()
    if not files:
        pytest.skip("not a git checkout")
    here = [re.escape(f"{folder}/") for folder in (ROOT.parent, Path.home())]
    hosts = r"https?://[^\s/]*(?:pypi|pythonhosted|npmjs)"
    pattern = re.compile("|".join([hosts, r"/home/\w+", *here]))
    for path in files:
        if path.suffix in (".png", ".gif", ".gz", ".npz") or path.name == Path(__file__).name:
            continue
        found = pattern.search(path.read_text("utf-8"))
        assert found is None, f"{path.name}: {found.group()}"


@pytest.fixture(scope="module")
def counts():
    return count_lines.count()


def test_files_and_functions_are_short(counts):
    _, _, too_long = counts
    assert too_long.keys() <= count_lines.EXCEPTIONS.keys()
    assert all(name.startswith("kernels/") for name in too_long)


def test_docstrings_are_slim(counts):
    code, documentation, _ = counts
    assert documentation < count_lines.MAX_RATIO * code


def test_lists_of_attributes_and_parameters_contain_nothing_else():
    """A paragraph after such a list would be rendered as the name of an attribute."""
    section = re.compile(
        r"^(Attributes|Parameters)\n-+\n(.*?)(?=^\w[\w ]*\n-{3,}\n|\Z)", re.M | re.S
    )
    for path in (ROOT / "src" / "hertzchain").rglob("*.py"):
        text = path.read_text("utf-8")
        if not re.search(r"^ *(Attributes|Parameters)\n", text, re.M):
            continue
        for node in ast.walk(ast.parse(text)):
            if not isinstance(node, ast.FunctionDef | ast.ClassDef):
                continue
            for _, body in section.findall(ast.get_docstring(node) or ""):
                lines = [line for line in body.splitlines() if re.match(r"\w", line)]
                wrong = [line for line in lines if not re.match(r"\w+(, \w+)*( : |$)", line)]
                assert not wrong, (path, node.name, wrong)


def test_versions_agree():
    citation = (ROOT / "CITATION.cff").read_text("utf-8")
    assert f"version: {hc.__version__}" in citation
    assert f"## [{hc.__version__}]" in (ROOT / "CHANGELOG.md").read_text("utf-8")


def test_cache_files_older_than_a_kernel_are_deleted(tmp_path):
    from hertzchain.kernels import _forget_stale

    cache = tmp_path / "__pycache__"
    cache.mkdir()
    texts = {"step": "", "events": "from .step import take", "walls": "from . import events",
             "forces": "import numpy\n"}  # fmt: skip
    for at, (name, text) in enumerate(texts.items()):
        (tmp_path / f"{name}.py").write_text(text)
        os.utime(tmp_path / f"{name}.py", (at, at))

    def kept(*edited):
        for name in texts:
            index = cache / f"{name}.solve-1.py311.nbi"
            index.touch()
            os.utime(index, (10, 10))
        for name in edited:
            os.utime(tmp_path / f"{name}.py", (20, 20))
        _forget_stale(tmp_path)
        for name in edited:
            os.utime(tmp_path / f"{name}.py", (0, 0))
        return {file.name.partition(".")[0] for file in cache.iterdir()}

    assert kept() == set(texts)
    assert kept("step") == {"forces"}
    assert kept("walls") == {"step", "events", "forces"}
    assert kept("forces", "events") == {"step"}
    # A cache file of a module that no longer exists.
    (cache / "old.solve-1.py311.nbi").touch()
    os.utime(cache / "old.solve-1.py311.nbi", (10, 10))
    assert "old" not in kept("forces")


def test_the_table_of_numbering_names_arrays_of_the_stated_lengths():
    chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=6, velocity=0.1)
    walled = chain.replace(right_wall=hc.Wall())
    held = walled.replace(precompression=1.0, held_by="force")
    objects = {"Chain": walled, "Pulse": hc.propagate(chain), "Run": hc.simulate(walled),
               "HertzRange": hc.hertz_range(walled), "Spectrum": hc.spectrum(held)}  # fmt: skip
    page = (ROOT / "docs" / "reference" / "numbering.md").read_text("utf-8")
    rows = re.findall(r"^\| \{obj\}`~hertzchain\.(\w+)` \|(.+)\|(.+)\|(.+)\|$", page, re.M)
    assert {name for name, *_ in rows} == set(objects)
    for name, *cells in rows:
        for length, cell in zip((6, 5, 7), cells, strict=True):
            for attribute in re.findall(r"`([\w.]+)`", cell):
                item = objects[name]
                for part in attribute.split("."):
                    item = getattr(item, part)
                if item is not None:
                    along = -1 if np.ndim(item) == 2 and "columns" in cell else 0
                    assert np.shape(item)[along] == length, attribute
