"""What holds for the project as a whole: lightness, docstrings, no traces of a machine."""

import inspect
import os
import pkgutil
import re
import subprocess
import sys
import time
from importlib import import_module
from pathlib import Path

import pytest
from numpydoc.docscrape import FunctionDoc

import hertzchain as hc

ROOT = Path(__file__).parent.parent
HEAVY = ("numba", "matplotlib", "xarray", "zarr", "dask", "pandas", "scipy", "jinja2", "rich")


def test_light_floors_load_nothing_heavy():
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


def test_importing_takes_no_time():
    started = time.perf_counter()
    subprocess.run([sys.executable, "-c", "import hertzchain"], check=True)
    assert time.perf_counter() - started < 3.0


def test_all_public_names_are_there():
    for name in hc.__all__:
        assert getattr(hc, name) is not None


def public_functions():
    for info in pkgutil.walk_packages(hc.__path__, "hertzchain."):
        if ".kernels" in info.name or ".cli" in info.name or "._" in info.name:
            continue
        module = import_module(info.name)
        for name, item in vars(module).items():
            if name.startswith("_") or getattr(item, "__module__", "") != info.name:
                continue
            if inspect.isfunction(item):
                yield f"{info.name}.{name}", item
            elif inspect.isclass(item):
                for method, function in inspect.getmembers(item, inspect.isfunction):
                    if not method.startswith("_"):
                        yield f"{info.name}.{name}.{method}", function


FUNCTIONS = dict(public_functions())


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_public_argument_is_described(name):
    function = FUNCTIONS[name]
    documentation = FunctionDoc(function)
    assert documentation["Summary"], f"{name} has no summary"
    if name.endswith("Correction.velocity") or (".paper.figures." in name and "." in name[30:]):
        return
    described = {
        part.strip().lstrip("*") for parameter in documentation["Parameters"]
        for part in parameter.name.split(",")
    }  # fmt: skip
    arguments = set(inspect.signature(function).parameters) - {"self", "cls"}
    assert arguments == described
    if ".paper." not in name:
        assert documentation["Examples"], f"{name} has no example"


def tracked_files():
    done = subprocess.run(
        ["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    return [ROOT / name for name in done.stdout.split("\0") if name]


def test_no_tracked_file_speaks_of_a_machine():
    files = tracked_files()
    if not files:
        pytest.skip("not a git checkout")
    here = [re.escape(f"{folder}/") for folder in (ROOT.parent, Path.home())]
    hosts = r"https?://[^\s/]*(?:pypi|pythonhosted|npmjs)"
    pattern = re.compile("|".join([hosts, r"/home/\w+", *here]))
    for path in files:
        if path.suffix in (".png", ".gz") or path.name == Path(__file__).name:
            continue
        found = pattern.search(path.read_text("utf-8"))
        assert found is None, f"{path.name}: {found.group()}"


def test_versions_agree():
    citation = (ROOT / "CITATION.cff").read_text("utf-8")
    assert f"version: {hc.__version__}" in citation
    assert f"## [{hc.__version__}]" in (ROOT / "CHANGELOG.md").read_text("utf-8")


def test_what_was_compiled_before_a_kernel_changed_is_thrown_away(tmp_path):
    from hertzchain.kernels import _forget_stale

    source, cache = tmp_path / "kernel.py", tmp_path / "__pycache__"
    cache.mkdir()
    old, new = cache / "old.nbi", cache / "new.nbi"
    for at, file in enumerate((old, source, new)):
        file.touch()
        os.utime(file, (at, at))
    _forget_stale(tmp_path)
    assert [file.name for file in cache.iterdir()] == ["new.nbi"]
