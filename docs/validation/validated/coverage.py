"""Whether stated 95 % intervals hold the truth of simulators that share nothing with the estimators.

The studies of ``tests/independent``, from the blocks of seeds that ``python -m independent.coverage --resume`` keeps.
"""

from __future__ import annotations

from collections import defaultdict

from independent.coverage import BLOCK, KEPT, Count, binomial, keeps, kept_file, read_kept
from independent.studies import every

from .found import AbsentError, Line, Table

FEW = 20  # seeds of a study, at least


def tables() -> list[Table]:
    """Return a table of each procedure; a study of fewer than ``FEW`` seeds is left out."""
    rows: dict[str, list[Line]] = defaultdict(list)
    seeds = []
    for study in every():
        jobs = [(study.name, first, BLOCK) for first in range(1, 1001, BLOCK)]
        found = [one for job in jobs if kept_file(KEPT, job).exists() for one in read_kept(kept_file(KEPT, job))]
        if len(found) < FEW:
            continue
        seeds.append(len(found))
        counts = {name: Count() for name in study.groups}
        for one in found:
            for figure in one.figures:
                counts[figure.group].add(figure)
        for group, count in counts.items():
            if not count.n:
                continue
            rule = "shown" if group in study.shown else study.rule
            low, high = binomial(count.hits, count.n)
            rate = 100.0 * count.hits / count.n
            cells = (study.name.partition(", ")[2] or study.name, group, len(found), count.hits, count.n, rate,
                     f"{100 * low:.1f} to {100 * high:.1f}")  # fmt: skip
            rows[study.name.partition(",")[0]].append(Line(cells, keeps(rule, count.hits, count.n), rule != "shown"))
    if not rows:
        raise AbsentError("no seeds are kept: python -m independent.coverage --n 20 --resume")
    heads = ("case", "figure", "campaigns", "held", "intervals", "%", "99.9 % interval of the rate")
    text = (
        f"Seeds 1 to {min(seeds)} of each case, of some to {max(seeds)}. A rate holds if its exact binomial interval "
        "contains 95 %, or lies above 93 %; of figures of two power-ups, whose spread nobody knows well, if it reaches "
        "94 %. Of cases that show a fault that cannot be seen in the data nothing is asked."
    )
    return [
        Table(f"Coverage: {name}", text, heads, (0, 0, 0, 0, 0, 3, 0), tuple(some))
        for name, some in sorted(rows.items())
    ]
