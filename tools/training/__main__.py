"""Determine the tables of an exponent: ``python -m training EXPONENT FOLDER [WORK]``.

WORK keeps the results of finished stages, so that an interrupted run can be resumed.
"""

import sys
from pathlib import Path
from time import process_time

from .train import train


def report(stage: str) -> None:
    """Print the name of a stage and the processor time until then."""
    print(f"{process_time():7.0f} s  {stage}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    work = Path(sys.argv[3]) if len(sys.argv) > 3 else None
    train(float(sys.argv[1]), Path(sys.argv[2]), report, work)
