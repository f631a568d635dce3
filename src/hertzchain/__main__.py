"""``python -m hertzchain`` is the command `hertzchain`."""

from hertzchain.cli import main

if __name__ == "__main__":
    main()
