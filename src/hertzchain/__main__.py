"""Run the command `hertzchain` with ``python -m hertzchain``."""

from .cli import main

if __name__ == "__main__":
    main()
