"""A program that is interrupted like one in a terminal, by Ctrl-C."""

import signal
import subprocess
import sys
import textwrap
import time

# Seconds within which programs that would run for minutes end after an interrupt.  Two are
# promised; processors and disks that are shared with other work need more.
PROMPT = 20.0


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
        _, errors = process.communicate(timeout=120)
        took = time.monotonic() - sent
    assert process.returncode != 0
    assert took < PROMPT
    return errors
