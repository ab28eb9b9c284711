"""Thousands of commands on mutated inputs; each must answer or refuse in words, and leave everything else as it was.

::

    python tests/torture/torture.py                        5,000 trials and the special inputs, two at a time
    python tests/torture/torture.py --trials 300           fewer; numbers always start at 1
    python tests/torture/torture.py --resume               go on where an earlier run stopped, what failed once more
    python tests/torture/torture.py --page                 and put the tables into the manual
    python tests/torture/torture.py --replay 1234          one trial again, its files kept; -12: a special input

A trial follows from its number alone; numbers are never selected. A failure is: exit status other than 0 to 4 or 130,
a signal, more than 10 s, more than 1 GiB and three times the input, a traceback or a warning, a refusal without a word,
``--json`` that is not one object of its schema, an input that changed, a file that is lost, left over or elsewhere.
"""

from __future__ import annotations

import argparse
import json
import os
import shlex
import shutil
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterable, Mapping
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parents[1])]
os.environ.setdefault("OMP_NUM_THREADS", "1")

from forked import ANSWERED, Judged, changes, failures, past_parser, ran, snapshot, warm  # noqa: E402
from seed_files import write_seeds  # noqa: E402
from trials import FIXED, fixed, trial  # noqa: E402

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "robustness.md"
TRIALS = 5000
PAST = 0.5  # of the trials, at least, get past the parser


def main() -> int:
    """Run trials, print the table, and return 1 if one failed or too few got past the parser."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", maxsplit=1)[0])
    parser.add_argument("--trials", type=int, default=TRIALS)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--resume", action="store_true", help="keep what passed in an earlier run")
    parser.add_argument("--page", action="store_true", help=f"put the tables into {PAGE.name}")
    parser.add_argument("--replay", type=int, help="one trial again, its files kept")
    parser.add_argument("--folder", type=Path, default=ROOT / "build" / "torture")
    given = parser.parse_args()
    folder = given.folder.resolve()
    seeds = seeds_in(folder, keep=given.resume or given.replay is not None)
    if given.replay is not None:
        return replayed(given.replay, seeds, folder)
    if not given.resume:
        for old in folder.glob("trials-*.jsonl"):
            old.unlink()
    begin = time.monotonic()
    numbers = [*range(1, given.trials + 1), *range(-len(FIXED), 0)]
    judged = tortured(numbers, seeds, folder, given.jobs)
    tables = {
        "mutated inputs": table(one for one in judged if one.number > 0),
        "special inputs": table(one for one in judged if one.number < 0),
    }
    print("\n\n".join(tables.values()))
    if given.page:
        write_tables(PAGE, tables)
    print(f"\n{len(judged)} commands in {time.monotonic() - begin:.0f} s")
    return verdict(judged)


def write_tables(page: Path, tables: Mapping[str, str]) -> None:
    """Put tables into a page of the manual, each between the marks of its name."""
    text = page.read_text(encoding="utf-8")
    for name, rows in tables.items():
        begin, end = f"<!-- {name} -->\n", f"<!-- end of {name} -->"
        before, _, rest = text.partition(begin)
        text = f"{before}{begin}\n{rows}\n\n{end}{rest.partition(end)[2]}"
    page.write_text(text, encoding="utf-8")


def verdict(judged: Iterable[Judged]) -> int:
    """Print each failure and return 1 if there is one, or if too few trials got past the parser."""
    judged = list(judged)
    failed = [one for one in judged if one.failures]
    for one in failed:
        print(f"{one.number} [{one.label}] inertialcal {shlex.join(one.words)}\n    {'; '.join(one.failures)}")
    mutated = [one for one in judged if one.number > 0]
    share = sum(one.past for one in mutated) / max(1, len(mutated))
    print(f"{share:.0%} past the parser, {len(failed)} failed")
    return 1 if failed or share < PAST else 0


def seeds_in(folder: Path, keep: bool = False) -> Path:
    """Return the folder with the seeds, made anew unless they are there and kept."""
    seeds = folder / "seeds"
    if keep and (seeds / "complete").exists():
        return seeds
    shutil.rmtree(seeds, ignore_errors=True)
    seeds.mkdir(parents=True)
    child = os.fork()  # what it leaves in memory is not that of the commands
    if not child:
        status = 1
        try:
            write_seeds(seeds)
            status = 0
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(status)
    if os.waitpid(child, 0)[1]:
        raise SystemExit("the seeds could not be made")
    (seeds / "complete").touch()
    return seeds


def tortured(numbers: Iterable[int], seeds: Path, folder: Path, jobs: int) -> list[Judged]:
    """Run the trials of some numbers in several workers, each of which forks its commands; return all results."""
    warm()
    numbers, workers = list(numbers), []
    for job in range(jobs):
        child = os.fork()
        if not child:
            status = 1
            try:
                _work(numbers[job::jobs], seeds, folder / f"trials-{job}.jsonl")
                status = 0
            finally:
                sys.stdout.flush()
                sys.stderr.flush()
                os._exit(status)
        workers.append(child)
    ends = [os.waitpid(child, 0)[1] for child in workers]
    if any(ends):
        raise SystemExit("a worker failed")
    last = {one.number: one for path in sorted(folder.glob("trials-*.jsonl")) for one in _read(path)}
    return [last[number] for number in sorted(numbers)]


def _read(path: Path) -> list[Judged]:
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    return [Judged(**json.loads(line)) for line in lines]


def _work(numbers: list[int], seeds: Path, results: Path) -> None:
    done = {one.number for one in _read(results) if not one.failures}
    with results.open("a", encoding="utf-8") as to, tempfile.TemporaryDirectory(prefix="torture-") as scratch:
        for number in numbers:
            if number not in done:
                to.write(judged_trial(number, seeds, Path(scratch) / "trial").line() + "\n")
                to.flush()


def judged_trial(number: int, seeds: Path, folder: Path, keep: bool = False) -> Judged:
    """Run one trial in a folder that is emptied before, and after unless it is kept and all is printed."""
    shutil.rmtree(folder, ignore_errors=True)
    case, aside = folder / "case", folder / "aside"
    case.mkdir(parents=True)
    made = trial(number, seeds, case) if number > 0 else fixed(number, seeds, case)
    before = snapshot(case)
    size = sum(one.lstat().st_size for one in case.rglob("*") if one.is_file())
    end = ran(made.words, case, aside, made.process)
    left = [_told(one, aside) for one in (aside / "tmp").rglob("*")]
    found = failures(made.words, end, size, left, made.process) + changes(before, snapshot(case), made.outputs)
    found += made.check(case, end)
    if keep:
        print(
            f"[{made.label}] cd {case}; inertialcal {shlex.join(made.words)}\n{end.out}\n{end.err}\ncodes {end.codes}"
        )
    else:
        shutil.rmtree(folder)
    seconds, mib = round(end.seconds, 3), round(end.mib, 1)
    return Judged(number, made.label, made.words, end.status, seconds, mib, past_parser(end), tuple(found))


def _told(path: Path, aside: Path) -> str:
    """Return the name of a temporary file that was left, with the end of a log."""
    lines = path.read_text(errors="replace").splitlines() if path.suffix == ".log" else []
    return " ".join([str(path.relative_to(aside)), *(line.strip() for line in lines[-4:])])


def replayed(number: int, seeds: Path, folder: Path) -> int:
    """Run one trial again, its files kept, and print all of it."""
    warm()
    found = judged_trial(number, seeds, folder / f"replay-{number}", keep=True)
    print(f"exit {found.status}, {found.seconds:.1f} s, {found.mib:.0f} MiB, past the parser: {found.past}")
    print("\n".join(found.failures) or "nothing failed")
    return 1 if found.failures else 0


def table(judged: Iterable[Judged]) -> str:
    """Return a row for each class: what was tried, got past the parser, was refused, was answered, failed."""
    classes: dict[str, list[Judged]] = defaultdict(list)
    for one in judged:
        classes[one.label].append(one)
    rows = [_row(label, classes[label]) for label in sorted(classes)]
    rows.append(_row("all", [one for found in classes.values() for one in found]))
    heads = ("class", "tried", "past the parser", "refused", "answered", "failed", "worst s", "worst MiB")
    return "\n".join(f"| {' | '.join(row)} |" for row in (heads, ("---",) * len(heads), *rows))


def _row(label: str, found: list[Judged]) -> tuple[str, ...]:
    counts = (
        len(found),
        sum(one.past for one in found),
        sum(one.status in {2, 3} for one in found),
        sum(one.status in ANSWERED for one in found),
        sum(bool(one.failures) for one in found),
    )
    worst = (f"{max(one.seconds for one in found):.1f}", f"{max(one.mib for one in found):.0f}") if found else ("", "")
    return (label.replace("|", "\\|"), *map(str, counts), *worst)


if __name__ == "__main__":
    sys.exit(main())
