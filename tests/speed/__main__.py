"""Print the table of speed.

::

    PYTHONPATH=src:tests python -m speed [TEXT ...] [--store] [--processor]

Of all lines, or of those whose names hold one of the texts. ``--store`` keeps the ratios, for the next comparison:
regressions by more than a fifth against the stored ratios are named, and end the command with 1. ``--processor`` counts
the time of the processor.
"""

from __future__ import annotations

import argparse
import sys
import time

from .comparison import bandwidth, every_line, measured
from .table import regressions, row, store, stored, table


def main() -> int:
    """Measure, print, and compare with what is stored."""
    parser = argparse.ArgumentParser(prog="python -m speed", description="Print the table of speed.")
    parser.add_argument("texts", nargs="*", metavar="TEXT", help="only lines whose names hold one of these")
    parser.add_argument("--store", action="store_true", help="keep the ratios")
    parser.add_argument("--processor", action="store_true", help="time of the processor, where others use the machine")
    asked = parser.parse_args()
    clock = time.process_time if asked.processor else time.perf_counter
    chosen = [one for one in every_line().values() if not asked.texts or any(text in one.name for text in asked.texts)]
    speed, before, done = bandwidth(), stored(), []
    for entry in chosen:
        done.append(measured(entry, speed, clock))
        print(f"{entry.name}: {done[-1].ratio:.3g}", file=sys.stderr, flush=True)
    print(f"\nMemory is read at {speed / 1e9:.1f} GB/s: the ratio at that speed is the limit.\n")
    print(table(row(one) for one in done))
    slower = regressions(done, before)
    print("\n".join(["", "Slower by more than a fifth than stored:", *slower]) if slower else "")
    if asked.store:
        store(done)
    return 1 if slower else 0


if __name__ == "__main__":
    sys.exit(main())
