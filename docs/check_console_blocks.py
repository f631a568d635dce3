r"""Check that the ``console`` blocks of all pages show the output of their commands.

In a block, text after ``$ `` is a command and the lines below it are its output.  ``...`` matches
any text, and a command may continue after a backslash.  ``$ cat FILE`` writes the following lines
to the file.  Pytest runs this check:

>>> from pathlib import Path
>>> for page in sorted(Path(__file__).parent.glob("*/*.md")):
...     for failure in failures(page):
...         print(page.name, failure)
"""

import doctest
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


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
            done = subprocess.run(
                line, shell=True, cwd=folder, env=environment, capture_output=True, text=True
            )
            # On a slow machine there are lines about progress and the compiler, which are not shown
            # on the page.
            progress = r"^([\w ]+: \d+ of \d+(, .* to go)?|hertzchain: compiling once.*)\n"
            got = done.stdout + re.sub(progress, "", done.stderr, flags=re.M)
            if not doctest.OutputChecker().check_output(expected, got, FLAGS):
                yield f"$ {line}\nexpected:\n{expected}\ngot:\n{got}"
