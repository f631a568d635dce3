"""Processor time of compiling, for each function that Python calls and each kind of chain.

All kernels are compiled in one process, with an empty cache.  A function that several kernels call
is compiled once for the same types of arguments; its time is that of the first of them.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from typing import Any


def print_times() -> None:
    """Compile all kernels and print the time of each outermost function."""
    from numba.core import event

    from hertzchain import Chain
    from hertzchain.warm_start import BEADS, STAGES

    class Outermost(event.Listener):
        """The time of functions that no other function calls."""

        depth = 0
        began = 0.0

        def on_start(self, event: Any) -> None:  # noqa: ARG002
            """Start the clock with the outermost function."""
            if self.depth == 0:
                self.began = time.process_time()
            self.depth += 1

        def on_end(self, event: Any) -> None:
            """Print the time of the outermost function."""
            self.depth -= 1
            if self.depth == 0:
                function = event.data["dispatcher"].py_func
                module = function.__module__.rpartition(".")[2]
                seconds = time.process_time() - self.began
                if seconds > 0.05:
                    print(f"{seconds:10.1f}    {module}.{function.__name__}", flush=True)

    event.register("numba:compile", Outermost())
    began, chain = time.process_time(), Chain.tapered("backward-exponential", 0.05, beads=BEADS)
    for stage in STAGES:
        before = time.process_time()
        print(stage.name)
        stage.run(chain)
        print(f"{time.process_time() - before:6.1f} s", flush=True)
    print(f"all: {time.process_time() - began:.0f} s of processor time")


def main() -> None:
    """Print the times, measured in another process with an empty cache."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, __file__, "--here"]
        subprocess.run(command, check=True, env=os.environ | {"NUMBA_CACHE_DIR": folder})


if __name__ == "__main__":
    print_times() if "--here" in sys.argv else main()
