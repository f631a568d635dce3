"""A program that is interrupted like one in a terminal, by Ctrl-C."""

import signal
import subprocess
import sys
import textwrap
import time


def interrupted(code):
    """Standard error of a program that was interrupted after it had printed "working"."""
    with subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(code)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    ) as process:  # fmt: skip
        assert process.stdout.readline() == "working\n"
        time.sleep(0.3)
        process.send_signal(signal.SIGINT)
        sent = time.monotonic()
        _, errors = process.communicate(timeout=30)
        took = time.monotonic() - sent
    assert process.returncode != 0
    # Within two seconds; where other work takes the processors, somewhat later.
    assert took < 4.0
    return errors
