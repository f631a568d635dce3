"""Determine the tables of an exponent: ``python -m training EXPONENT FOLDER``."""

import sys
from pathlib import Path

from .train import train

if __name__ == "__main__":
    train(float(sys.argv[1]), Path(sys.argv[2]), lambda text: print(text, file=sys.stderr))
