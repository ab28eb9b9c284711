"""What the gate makes of every line of issue 20, of an examiner's variations, and of clean records.

::

    PYTHONPATH=src:tests python -m independent.gate [--n 60] [--clean 900] [--resume] [--out FILE]
    PYTHONPATH=src:tests python -m independent.gate --line glitch --on allan --n 5 --show
    PYTHONPATH=src:tests python -m independent.gate --line glitch --write FOLDER

Seeds are 1 to n, never chosen; variations take a third of them. A line passes if it is named in 57 of 60 cases (see
``trial``), writes no model where it must not, and keeps the figures that it must keep. Of a line that is no fault of
this issue nothing is asked.

n of n
    cases that pass; then named, other and silent;
    ``model``: cases in which a model was written; ``kept``: of figures that must be those of the clean record;
    ``held``: stated 95 % intervals that hold the truth, clean and spoiled; ``shift``: largest change of a figure in its
    clean standard uncertainties, ``width``: largest ratio of its uncertainty to the clean one, medians over the seeds.

Cases are kept in ``build/gate/``, so that a run that was stopped goes on with ``--resume``.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import shlex
import statistics
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TextIO

from .case import Case
from .faults import FAULTS, Fault, spoiled
from .records import bases, variations
from .records.clean import CODES, KINDS, MOST
from .trial import Outcome, changed, hits, kept, tried, verdict

BASES = bases.BASES | variations.BASES
ALL = FAULTS | variations.VARIATIONS
LEAST = 0.95  # of the cases of a line: 57 of 60
ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "gate.md"
BEGIN, END = "<!-- make gate -->\n", "<!-- end of make gate -->"


@dataclass(frozen=True)
class Result:
    """What one case came to; of a clean record ``line`` is its kind and ``on`` is empty."""

    line: str
    on: str
    seed: int
    verdict: str
    exit: int
    model: bool
    kept: bool = True
    codes: list[str] = field(default_factory=list)  # that the clean case has not
    held: tuple[int, int] = (0, 0)
    clean_held: tuple[int, int] = (0, 0)
    shift: float = float("nan")
    width: float = float("nan")

    @property
    def passed(self) -> bool:
        """Whether the case is as the line asks."""
        fault = ALL[self.line]
        return self.verdict in ("named", "absent") and self.kept and (fault.model or not self.model)


def lines(names: Sequence[str] = (), on: Sequence[str] = ()) -> list[tuple[Fault, str]]:
    """Return faults with the bases that they are put into."""
    return [(fault, base) for fault in ALL.values() for base in fault.on
            if (not names or fault.name in names) and (not on or base in on)
            and (bases.SHARED.is_dir() or base not in ("allan:real", "allan:archive"))]  # fmt: skip


def tried_lines(on: str, seed: int, faults: Sequence[Fault], show: bool = False) -> list[Result]:
    """Try faults on one base, one seed: the clean case is made once."""
    case = BASES[on](seed)
    before = tried(case)
    return [judged(fault, on, seed, case, before, show) for fault in faults]


def judged(fault: Fault, on: str, seed: int, case: Case, before: Outcome, show: bool = False) -> Result:
    """Return what the command makes of a fault."""
    bad = spoiled(case, fault)
    after = tried(bad)
    shift, width = changed(case, before, after)
    same = not (fault.keeps and case.procedure == "allan") or kept(fault, before, after)
    found = Result(
        fault.name, on, seed, verdict(fault, bad, after, before), after.exit, after.model, same,
        sorted(after.codes - before.codes), hits(bad, after), hits(case, before), shift, width,
    )  # fmt: skip
    if show:
        print(f"\n{fault.name} on {on}, seed {seed}: {found.verdict}, exit {after.exit}, spoiled {bad.spoiled}")
        print("\n".join(f"  {code}: {text}" for code, text in after.said) or after.printed[-2000:])
    return found


def tried_clean(kind: str, seed: int, show: bool = False) -> Result:
    """Try one clean record."""
    after = tried(next(one for one in KINDS if one.name == kind).case(seed))
    alarms = sorted(set(after.codes) & CODES)
    refused = after.exit not in (0, 4)
    if show and (alarms or refused):
        print(f"\n{kind}, seed {seed}: exit {after.exit}")
        print("\n".join(f"  {code}: {text}" for code, text in after.said) or after.printed[-2000:])
    return Result(kind, "", seed, "alarm" if alarms else "refused" if refused else "clean", after.exit, after.model,
                  codes=alarms or (sorted(after.codes) if refused else []))  # fmt: skip


Job = tuple[str, int, list[str], bool]  # base, seed, faults; or kind, seed, no fault


def done(job: Job) -> list[Result]:
    """Do one job."""
    name, seed, faults, show = job
    if not faults:
        return [tried_clean(name, seed, show)]
    return tried_lines(name, seed, [ALL[one] for one in faults], show)


def jobs(
    pairs: Iterable[tuple[Fault, str]], n: int, clean: int, have: set[tuple[str, str, int]], show: bool
) -> list[Job]:
    """Return what is still to be done: a slice of every line first, so that a run that is stopped says much."""
    by_base: dict[str, list[str]] = defaultdict(list)
    for fault, on in pairs:
        by_base[on].append(fault.name)
    found: list[Job] = []
    for seed in range(1, n + 1):
        for on, names in by_base.items():
            rest = [name for name in names if (name, on, seed) not in have and (name in FAULTS or seed <= -(-n // 3))]
            if rest:
                found.append((on, seed, rest, show))
    records: list[Job] = [
        (kind.name, seed, [], show)
        for kind in KINDS
        for seed in range(1, -(-kind.number * clean // 900) + 1)
        if (kind.name, "", seed) not in have
    ]
    return found + (sorted(records, key=lambda one: one[1]) if clean else [])


def results(todo: Sequence[Job], processes: int) -> Iterator[Result]:
    """Do the jobs, in several processes."""
    if processes < 2:
        for job in todo:
            yield from done(job)
        return
    with multiprocessing.Pool(processes) as pool:
        for some in pool.imap_unordered(done, todo):
            yield from some


def shown(found: Sequence[Result], issue: bool | None = None) -> str:
    """Return the table of the lines in Markdown; ``issue``: only those that the issue names, or only variations."""
    rows = [
        "| issue | fault | on | pass | named | other | silent | model | kept | exits | held | shift | width | codes |",
        "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    by_line: dict[tuple[str, str], list[Result]] = defaultdict(list)
    for one in found:
        if one.on:
            by_line[one.line, one.on].append(one)
    for fault, on in lines():
        some = by_line.get((fault.name, on), [])
        if not some or (issue is not None and issue == (fault.name in variations.VARIATIONS)):
            continue
        n = len(some)
        verdicts = Counter(one.verdict for one in some)
        named = verdicts["absent" if fault.expects == "absent" else "named"]
        passed = f"{sum(one.passed for one in some)}/{n}" if fault.issue else "-"
        if fault.issue and sum(one.passed for one in some) < LEAST * n:
            passed = f"**{passed}**"
        exits = " ".join(f"{code}x{count}" for code, count in sorted(Counter(one.exit for one in some).items()))
        held = " -> ".join(
            f"{sum(one[0] for one in pairs)}/{sum(one[1] for one in pairs)}"
            for pairs in ([one.clean_held for one in some], [one.held for one in some])
        )
        codes = Counter(code for one in some for code in one.codes)
        model = f"{sum(one.model for one in some)}" + ("" if fault.model else " (of 0)")
        keeps = f"{sum(one.kept for one in some)}" if fault.keeps and on.startswith("allan") else ""
        shift, width = (f"{statistics.median(getattr(one, name) for one in some):.3g}" for name in ("shift", "width"))
        said = " ".join(f"{code}x{count}" for code, count in codes.most_common(4))
        other = verdicts["other"] + verdicts["false"]
        cells = [fault.issue, fault.name, on, passed, str(named), str(other), str(verdicts["silent"]), model, keeps]
        rows.append("| " + " | ".join([*cells, exits, held, shift, width, said]) + " |")
    return "\n".join(rows)


def shown_short(found: Sequence[Result]) -> str:
    """Return the table of the manual: what was found of each line of the issue, and in clean records."""
    by_issue: dict[str, dict[str, list[Result]]] = defaultdict(lambda: defaultdict(list))
    for one in found:
        if one.on and one.line in FAULTS and ALL[one.line].issue:
            by_issue[ALL[one.line].issue][one.on.split(":")[0]].append(one)
    rows = ["| what goes wrong | cases in which it is found |", "|---|---|"]
    for issue in dict.fromkeys(fault.issue for fault in FAULTS.values() if fault.issue in by_issue):
        counts = (f"`{on}` {sum(r.passed for r in some)} of {len(some)}" for on, some in by_issue[issue].items())
        rows.append(f"| {issue} | {', '.join(counts)} |")
    rows += ["", "| clean records | false alarms |", "|---|---|"]
    kinds: dict[str, list[Result]] = defaultdict(list)
    for one in found:
        if not one.on:
            kinds[one.line].append(one)
    rows += [f"| {kind} | {sum(r.verdict != 'clean' for r in some)} of {len(some)} |" for kind, some in kinds.items()]
    every = [one for some in kinds.values() for one in some]
    rows.append(f"| all | {sum(r.verdict != 'clean' for r in every)} of {len(every)} |")
    return "\n".join(rows)


def shown_clean(found: Sequence[Result]) -> str:
    """Return the table of the clean records."""
    rows = ["| clean record | records | false alarms | refused | codes |", "|---|---|---|---|---|"]
    some = [one for one in found if not one.on]
    for name in [*dict.fromkeys(one.line for one in some), "all"]:
        of = [one for one in some if name in (one.line, "all")]
        alarms, refused = (sum(one.verdict == word for one in of) for word in ("alarm", "refused"))
        codes = Counter(code for one in of for code in one.codes)
        said = " ".join(f"{code}x{k}" for code, k in codes.most_common())
        rows.append(f"| {name} | {len(of)} | {alarms} | {refused} | {said} |")
    return "\n".join(rows)


def failures(found: Sequence[Result]) -> list[str]:
    """Return what does not hold: lines of the issue below 57 of 60, and too many false alarms."""
    by_line: dict[tuple[str, str], list[Result]] = defaultdict(list)
    for one in found:
        if one.on and ALL[one.line].issue and not ALL[one.line].limit and one.line in FAULTS:
            by_line[one.line, one.on].append(one)
    failed = [
        f"{line} on {on}: {sum(one.passed for one in some)} of {len(some)}"
        for (line, on), some in by_line.items()
        if sum(one.passed for one in some) < LEAST * len(some)
    ]
    clean = [one for one in found if not one.on]
    wrong = sum(one.verdict != "clean" for one in clean)
    if wrong > max(1, MOST * len(clean) / 900):
        failed.append(f"clean records: {wrong} false alarms and refusals of {len(clean)}")
    return failed


def _kept(path: Path, resume: bool) -> tuple[list[Result], TextIO]:
    """Return the results of a run that was stopped, and the file to go on in."""
    path.parent.mkdir(parents=True, exist_ok=True)
    found = []
    if resume and path.exists():
        for text in path.read_text(encoding="utf-8").splitlines():
            one = json.loads(text)
            found.append(Result(**one | {name: tuple(one[name]) for name in ("held", "clean_held")}))
    return found, path.open("a" if resume else "w", encoding="utf-8")


def _written(folder: Path, pairs: Sequence[tuple[Fault, str]]) -> int:
    """Write the files of seed 1, clean and with each fault, and print the command of each."""
    for fault, on in pairs:
        case = BASES[on](1)
        for name, one in (("clean", case), (fault.name, spoiled(case, fault))):
            print(shlex.join(["inertialcal", *one.write(folder / on.replace(":", "_") / name)]))
    return 0


def main(words: Sequence[str] | None = None) -> int:
    """Print the tables, and return 1 if something does not hold."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--n", type=int, default=60, help="cases a line")
    parser.add_argument("--clean", type=int, default=900, help="clean records; 0: none")
    parser.add_argument("--line", nargs="*", default=[], help="only these faults")
    parser.add_argument("--on", nargs="*", default=[], help="only on these procedures")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--resume", action="store_true", help="go on where an earlier run stopped")
    parser.add_argument("--show", action="store_true", help="print what was said of each case")
    parser.add_argument("--keep", type=Path, default=ROOT / "build/gate/cases.jsonl", help="where cases are kept")
    parser.add_argument("--out", type=Path, help="write the tables there too")
    parser.add_argument("--page", action="store_true", help=f"put the short tables into docs/{PAGE.name}")
    parser.add_argument("--write", type=Path, metavar="FOLDER", help="only write the files, and print their commands")
    given = parser.parse_args(words)
    pairs = lines(given.line, given.on)
    if given.write:
        return _written(given.write, pairs)
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    begin = time.monotonic()
    found, file = _kept(given.keep, given.resume)
    todo = jobs(
        pairs,
        given.n,
        0 if given.line or given.on else given.clean,
        {(r.line, r.on, r.seed) for r in found},
        given.show,
    )
    with file:
        for one in results(todo, given.jobs):
            file.write(json.dumps(asdict(one)) + "\n")
            file.flush()
            found.append(one)
    tables = [f"Seeds 1 to {given.n}.", shown(found, True), "Variations:", shown(found, False), shown_clean(found)]
    text = "\n\n".join(tables)
    print(text)
    if given.out:
        given.out.write_text(text + "\n", encoding="utf-8")
    if given.page:
        page = PAGE.read_text(encoding="utf-8")
        before, _, rest = page.partition(BEGIN)
        PAGE.write_text(f"{before}{BEGIN}\n{shown_short(found)}\n\n{END}{rest.partition(END)[2]}", encoding="utf-8")
    failed = failures(found)
    print(f"\n{len(found)} cases, {len(todo)} jobs in {time.monotonic() - begin:.0f} s")
    print("\n".join(["", *failed]) if failed else "Every line holds.")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
