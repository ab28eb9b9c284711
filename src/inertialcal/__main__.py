"""``python -m inertialcal``: the command line."""

from .cli.__main__ import entry

if __name__ == "__main__":
    entry()
