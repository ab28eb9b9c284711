"""Do stated 95 % intervals hold the truth of the independent simulators? The tables of issues 21 and 22.

::

    PYTHONPATH=src:tests python -m independent.coverage [--n 20] [--case PATTERN ...] [--jobs 2] [--out FILE.md]

Seeds are 1 to n. A line gives, for a group of figures of one case, how many stated intervals hold the truth, the exact
99.9 % binomial interval of that rate, the error (median, and root mean square), the median of u, and refusals. A rate
holds if that interval lies above 93 % or contains 95 %; of two power-ups its upper end lies above 94 %.

Blocks of seeds are kept in ``build/coverage/independent/``, so that a run that was stopped goes on (``--resume``).
"""

from __future__ import annotations

import argparse
import json
import math
import multiprocessing
import os
import statistics
import sys
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

from scipy.stats import beta

from .studies import Figure, LeftOut, Pair, Residuals, Study, Tried, every

BLOCK = 20  # seeds
KEPT = Path(__file__).parents[2] / "build/coverage/independent"


@dataclass
class Count:
    """Hits and errors of one group."""

    hits: int = 0
    n: int = 0
    missing: int = 0
    errors: list[float] = field(default_factory=list)  # estimate less truth
    parts: list[float] = field(default_factory=list)  # the same over the truth
    u: list[float] = field(default_factory=list)
    ratios: list[float] = field(default_factory=list)  # of u to that of the best estimate

    def add(self, one: Figure) -> None:
        """Count a figure."""
        if one.held is None:
            self.missing += 1
            return
        self.hits += one.held
        self.n += 1
        self.errors.append(one.error)
        self.u.append(one.u)
        if one.truth and not math.isnan(one.truth):
            self.parts.append(one.error / one.truth)
        if not math.isnan(one.ideal):
            self.ratios.append(one.u / one.ideal)


def binomial(hits: int, n: int, p: float = 0.999) -> tuple[float, float]:
    """Return the exact interval of a rate (Clopper and Pearson 1934)."""
    if not n:
        return 0.0, 1.0
    a = 0.5 * (1.0 - p)
    low = float(beta.ppf(a, hits, n - hits + 1)) if hits else 0.0
    high = float(beta.ppf(1.0 - a, hits + 1, n - hits)) if hits < n else 1.0
    return low, high


def keeps(rule: str, hits: int, n: int) -> bool:
    """Return whether a hit rate is what is asked of it."""
    low, high = binomial(hits, n)
    return rule == "shown" or (high > 0.94 if rule == "few" else low > 0.93 or high >= 0.95)


def lines(study: Study | Pair | LeftOut | Residuals, found: Sequence[Tried]) -> list[str]:
    """Return the rows of one study; a rate that is not what is asked of it is bold."""
    counts = {name: Count() for name in study.groups}
    for one in found:
        for figure in one.figures:
            counts[figure.group].add(figure)
    notes, exits = Counter(note for one in found for note in one.notes), Counter(one.exit for one in found)
    told = " ".join(f"{code}x{number}" for code, number in notes.most_common(6))
    out = " ".join(f"{code}x{number}" for code, number in sorted(exits.items()))
    rows = []
    for name, count in counts.items():
        low, high = binomial(count.hits, count.n)
        rate = f"{100 * count.hits / count.n:.1f}" if count.n else "-"
        rule = "shown" if name in study.shown else study.rule
        rate = rate if keeps(rule, count.hits, count.n) else f"**{rate}**"
        rms = math.sqrt(statistics.fmean(e * e for e in count.errors)) if count.errors else math.nan
        part = f"{100 * statistics.median(count.parts):.2g} %" if count.parts else ""
        u = statistics.median(count.u) if count.u else math.nan
        cells = [study.name, name, study.stated, f"{count.hits}/{count.n}", rate, f"{100 * low:.1f}-{100 * high:.1f}"]
        ratio = f"{statistics.median(count.ratios):.3g}" if count.ratios else ""
        cells += [part, f"{rms:.2g}", f"{u:.2g}", ratio, str(count.missing), out, told]
        rows.append("| " + " | ".join(cells) + " |")
    return rows


HEAD = (
    "| case | figure | issue | held | % | 99.9 % interval | median error | rms error | median u | u / ideal | absent | "
    "exits | notes |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|"
)


Job = tuple[str, int, int]  # name of a study, first seed, seeds


def done(job: Job) -> tuple[Job, list[Tried]]:
    """Try a block of seeds of one study."""
    name, first, seeds = job
    study = next(one for one in every() if one.name == name)
    return job, [study.tried(seed) for seed in range(first, first + seeds)]


def tried(todo: Sequence[Job], processes: int) -> Iterator[tuple[Job, list[Tried]]]:
    """Do the jobs, in several processes."""
    if processes < 2:
        yield from map(done, todo)
        return
    with multiprocessing.Pool(processes) as pool:
        yield from pool.imap(done, todo)


def kept_file(folder: Path, job: Job) -> Path:
    """Return where a block of seeds is kept."""
    name, first, seeds = job
    plain = "".join(letter if letter.isalnum() else "_" for letter in name)
    return folder / f"{plain}_{first}_{seeds}.json"


def read_kept(path: Path) -> list[Tried]:
    """Return a block of seeds that was kept."""
    return [
        Tried(one["exit"], [Figure(**figure) for figure in one["figures"]], one["notes"])
        for one in json.loads(path.read_text(encoding="utf-8"))
    ]


def main(words: Sequence[str] | None = None) -> int:
    """Print the tables, and return 1 if a rate is not what is asked of it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--n", type=int, default=20)
    parser.add_argument("--case", nargs="*", default=[], help="only studies with one of these words in their name")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--resume", action="store_true", help="go on where an earlier run stopped")
    parser.add_argument("--keep", type=Path, default=KEPT, help="where blocks are kept")
    parser.add_argument("--out", type=Path)
    given = parser.parse_args(words)
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    studies = [one for one in every() if not given.case or any(word in one.name for word in given.case)]
    blocks: dict[str, list[Job]] = {
        one.name: [(one.name, first, min(BLOCK, given.n + 1 - first)) for first in range(1, given.n + 1, BLOCK)]
        for one in studies
    }
    given.keep.mkdir(parents=True, exist_ok=True)
    have = {job for some in blocks.values() for job in some if given.resume and kept_file(given.keep, job).exists()}
    found: dict[str, list[Tried]] = defaultdict(list)
    text, rest = [HEAD], {name: len(some) for name, some in blocks.items()}
    by_name = {one.name: one for one in studies}

    def add(job: Job, some: list[Tried]) -> None:
        name = job[0]
        found[name] += some
        rest[name] -= 1
        if not rest[name]:
            text.extend(lines(by_name[name], found[name]))
            print("\n".join(lines(by_name[name], found[name])), file=sys.stderr, flush=True)

    for job in sorted(have):
        add(job, read_kept(kept_file(given.keep, job)))
    todo = [job for some in blocks.values() for job in some if job not in have]
    for job, some in tried(todo, given.jobs):
        kept_file(given.keep, job).write_text(json.dumps([asdict(one) for one in some]), encoding="utf-8")
        add(job, some)
    print("\n".join(text))
    if given.out:
        given.out.write_text("\n".join(text) + "\n", encoding="utf-8")
    return int(any("**" in line for line in text))


if __name__ == "__main__":
    sys.exit(main())
