"""Fuzz every reader: 300 files changed, 100 cut off, 100 with one bit flipped; what comes of them."""

from __future__ import annotations

import sys
from collections import Counter

from hostile_files import NAMES, attempt

MUTATIONS, CUTS, FLIPS = 300, 100, 100


def main(names: list[str]) -> int:
    """Try the files of some readers, or of all; return how many outcomes are wrong."""
    wrong = 0
    for name in names or NAMES:
        found = attempt(name, 1, MUTATIONS, CUTS, FLIPS)
        print(name, dict(Counter(one.outcome.partition(":")[0] for one in found)), flush=True)
        for one in found:
            if one.wrong:
                wrong += 1
                print(f"  {one.how}: {one.wrong}")
    return wrong


if __name__ == "__main__":
    sys.exit(min(main(sys.argv[1:]), 1))
