r"""Check that the ``console`` blocks of all pages show the output of their commands.

In a block, text after ``$ `` is a command and the lines below it are its output.  ``...`` matches
any text, and a command may continue after a backslash.  ``$ cat FILE`` writes the following lines
to the file.  Pytest runs this check:

>>> from pathlib import Path
>>> for page in sorted(Path(__file__).parent.glob("*/*.md")):
...     for failure in failures(page):
...         print(page.name, failure)
"""

import multiprocessing
import os
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from doctest import ELLIPSIS, OutputChecker
from pathlib import Path

# Importing these and loading kernels takes longer than most commands.  Commands are forked from a
# process that has done both, but has not yet started threads.
CONTEXT = multiprocessing.get_context("forkserver")
CONTEXT.set_forkserver_preload(
    ["hertzchain.simulation.simulate", "hertzchain.propagation.propagate", "hertzchain.theory.bca",
     "scipy.interpolate", "scipy.optimize", "scipy.sparse", "matplotlib.pyplot", "pandas", "xarray",
     "zarr", "rich.table", "loaded_kernels"]
)  # fmt: skip


def _run(line: str, folder: Path, environment: dict[str, str]) -> tuple[str, str]:
    """Output of a command: of hertzchain, in a forked process; by the shell, if it has to."""
    if not line.startswith("hertzchain ") or set(line) & set(";|&<>$`"):
        done = subprocess.run(
            line, shell=True, cwd=folder, env=environment, capture_output=True, text=True
        )
        return done.stdout, done.stderr
    with tempfile.TemporaryDirectory() as outputs:
        files = [Path(outputs, name) for name in ("stdout", "stderr")]
        process = CONTEXT.Process(target=_hertzchain, args=(line, folder, environment, files))
        process.start()
        process.join()
        out, err = (file.read_text("utf-8") for file in files)
    return out, err


def _lines(text: str) -> str:
    """The lines without the blanks at their ends, and without blank lines around them."""
    return "\n".join(line.rstrip() for line in text.splitlines()).strip("\n") + "\n"


def _hertzchain(line: str, folder: Path, environment: dict[str, str], files: list[Path]) -> None:
    """The command `hertzchain`, in a process of its own."""
    for descriptor, file in enumerate(files, start=1):
        os.dup2(os.open(file, os.O_WRONLY | os.O_CREAT), descriptor)
    os.environ.update(environment)
    os.chdir(folder)
    sys.argv = shlex.split(line)
    from hertzchain.cli import main

    main()


def failures(page: Path) -> Iterator[str]:
    """Differences on one page, whose blocks run one after another in an empty folder."""
    blocks = re.findall(r"^```console\n(.*?)^```", page.read_text("utf-8"), re.M | re.S)
    scripts = os.pathsep.join([os.fspath(Path(sys.executable).parent), os.environ["PATH"]])
    environment = os.environ | {"PATH": scripts, "COLUMNS": "80", "MPLBACKEND": "agg"}
    with tempfile.TemporaryDirectory() as folder:
        joined = re.sub(r" \\\n +", " ", "".join(blocks))
        for command in re.split(r"^\$ ", joined, flags=re.M)[1:]:
            line, _, expected = command.partition("\n")
            if line.startswith("cat "):
                Path(folder, line.removeprefix("cat ")).write_text(expected, "utf-8")
                continue
            out, err = _run(line, Path(folder), environment)
            # On a slow machine there are lines about progress and the compiler, which are not shown
            # on the page.
            progress = (
                r"^([\w ,;]+: \d+( of \d+(, .* left)?| in total)?|hertzchain: compiling once.*"
                r"|computing a few points to estimate the time|looking for the cause:.*)\n"
            )
            got = out + re.sub(progress, "", err, flags=re.M)
            if not OutputChecker().check_output(_lines(expected), _lines(got), ELLIPSIS):
                yield f"$ {line}\nexpected:\n{expected}\ngot:\n{got}"


if __name__ == "__main__":
    pages = [Path(each) for each in sys.argv[1:]] or sorted(Path(__file__).parent.glob("*/*.md"))
    found = [each for page in pages for each in failures(page)]
    print(*found, sep="\n")
    sys.exit(bool(found))
