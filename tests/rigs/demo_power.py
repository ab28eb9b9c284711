"""How often the campaign of a demonstration decides: verdicts of seeds in a row, none selected.

The plan of a rig (power-ups, dwells, limits; ``Bench`` in its ``setup``) is right where at least 95 of 100 seeds PASS.
Every seed is simulated and judged in memory by the same tests and rules as ``demo``, and nothing is drawn or written.
Of ``npsat1`` the record at rest for the noise is left out, as no verdict takes it.

    python -m demo_power [RIG] [FIRST [LAST]]        npsat1, seeds 1 to 100 (``make power``, ``make power RIG=climate``)
"""

from __future__ import annotations

import sys
import tomllib
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from inertialcal.campaign.calls.call import campaign_of
from inertialcal.campaign.engine.whole import reduce_campaign
from inertialcal.campaign.inputs.sources import Memory
from inertialcal.core.show.requirement_lines import requirement_lines
from inertialcal.rigs import DEMONSTRATED, RIGS
from inertialcal.rigs.npsat1.rig import build
from inertialcal.rigs.npsat1.setup import Bench
from inertialcal.rigs.twin import SEED, Twin

NEEDED = 0.95  # share of seeds that PASS


class Decided(NamedTuple):
    """A seed: the verdict on all, that on each requirement, and whether the readings fail where they are compensated.

    Verdicts are by requirement; ``raw`` has those of the readings as read, by requirement too.
    """

    verdict: str
    verdicts: dict[str, str]
    raw: dict[str, str]


def decided(seed: int, bench: Bench | None = None) -> Decided:
    """Return what the campaign of a seed comes to, of ``npsat1``."""
    bench = bench or Bench()
    parts = tuple(part for part in bench.parts if part != "noise")
    return judged(build(replace(bench, parts=parts), seed), seed)


def judged(twin: Twin, seed: int) -> Decided:
    """Return what a simulated campaign comes to."""
    campaign = campaign_of(tomllib.loads(twin.campaign.replace(SEED, str(seed))))
    extras = {name: one.content for name, one in twin.extras.items()}
    whole = reduce_campaign(campaign, Memory(twin.recordings, extras))
    lines = requirement_lines(whole.results)
    raw = {one.requirement: one.raw_verdict for one in lines if one.compensated and one.raw_verdict}
    return Decided(whole.verdict, {one.requirement: one.verdict for one in lines}, raw)


def main(given: Sequence[str]) -> int:
    """Print a line a seed that does not PASS, then the counts; 1 where too few PASS."""
    rig, *given = given if given and not given[0].isdigit() else [DEMONSTRATED, *given]
    first, last = (int(given[i]) if len(given) > i else default for i, default in ((0, 1), (1, 100)))
    count, raw = Counter[str](), Counter[tuple[str, str]]()
    for seed in range(first, last + 1):
        one = decided(seed) if rig == DEMONSTRATED else judged(RIGS.named(rig).make(seed, {}), seed)
        count[one.verdict] += 1
        raw.update(one.raw.items())
        if one.verdict != "PASS":
            open_ones = ", ".join(f"{name} {word}" for name, word in one.verdicts.items() if word != "PASS")
            print(f"seed {seed}: {one.verdict} ({open_ones})", flush=True)
    n = last - first + 1
    counts = ", ".join(f"{count[word]} {word}" for word in ("PASS", "INCONCLUSIVE", "FAIL"))
    print(f"{rig}, seeds {first} to {last}: {counts}")
    for (name, word), times in sorted(raw.items()):
        print(f"as read, {name}: {times} {word}")
    return 0 if count["PASS"] >= NEEDED * n else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
