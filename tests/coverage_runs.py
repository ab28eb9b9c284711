"""Coverage of every rig: do the stated 95 % intervals hold the truth? ``make coverage``, in slices that can be resumed.

    python tests/coverage_runs.py [RIG ...] [--n 1000] [--out build/coverage]

Seeds are 1 to n, in blocks of 50; each block is kept, so that a run that was stopped goes on where it was. The table at
the end is what the manual shows.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import defaultdict
from pathlib import Path

from inertialcal.campaign.twins.score import P, score_rig
from inertialcal.rigs import BUILT_IN
from inertialcal.statistics.intervals import binomial_interval, covers

BLOCK = 50


def counted(rig: str, n: int, folder: Path) -> dict[str, tuple[int, int]]:
    """Return hits and intervals of each quantity, over seeds 1 to n."""
    folder.mkdir(parents=True, exist_ok=True)
    totals: dict[str, tuple[int, int]] = defaultdict(lambda: (0, 0))
    for first in range(1, n + 1, BLOCK):
        size = min(BLOCK, n + 1 - first)
        kept = folder / f"{rig}_{first}_{size}.json"
        if not kept.exists():
            found = {f"{one.test} {one.key}": (one.hits, one.n) for one in score_rig(rig, size, first)}
            kept.write_text(json.dumps(found), encoding="utf-8")
        for name, (hits, intervals) in json.loads(kept.read_text(encoding="utf-8")).items():
            totals[name] = (totals[name][0] + hits, totals[name][1] + intervals)
        print(f"{rig}: seeds 1 to {first + size - 1}", file=sys.stderr, flush=True)
    return totals


def main() -> int:
    """Print a line a rig, and each quantity that fails the rule."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("rigs", nargs="*", default=[])
    words.add_argument("--n", type=int, default=1000)
    words.add_argument("--out", type=Path, default=Path("build/coverage"))
    given = words.parse_args()
    failed = 0
    print("| rig | campaigns | quantities | hit rates of the 95 % intervals [%] | all together [%] | fail the rule |")
    print("|---|---|---|---|---|---|")
    for rig in given.rigs or BUILT_IN:
        found = counted(rig, given.n, given.out)
        rates = sorted(100.0 * hits / intervals for hits, intervals in found.values() if intervals)
        hits, intervals = (sum(one[i] for one in found.values()) for i in (0, 1))
        bad = {name: one for name, one in found.items() if not one[1] or not covers(*one)}
        failed += len(bad)
        span = f"{rates[0]:.1f} to {rates[-1]:.1f}"
        print(
            f"| {rig} | {given.n} | {len(found)} | {span} | {100.0 * hits / intervals:.2f} | {len(bad)} |", flush=True
        )
        for name, (held, of) in bad.items():
            low, high = binomial_interval(held, of, P) if of else (0.0, 1.0)
            print(f"  {name}: {held} of {of} ({100 * low:.1f} to {100 * high:.1f} %)", file=sys.stderr)
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
