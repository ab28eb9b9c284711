"""Play the sessions of pages again and write what they print now: ``python docs/refresh.py PAGE...``.

An output with ``...`` keeps its parts: each part is replaced by the most similar lines of the new output. Read the
difference before you commit it; the words around a session do not change by themselves.
"""

import os
import re
import shlex
import sys
import tempfile
from difflib import SequenceMatcher
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from test_manual import ELLIPSIS, FENCE, Session, steps  # noqa: E402 - found by the line above


def refreshed(shown: list[str], printed: list[str]) -> list[str]:
    """Return the new output, with the same parts left out."""
    if not shown or ELLIPSIS not in shown:
        return printed
    parts: list[list[str]] = [[]]
    for line in shown:
        if line == ELLIPSIS:
            parts.append([])
        else:
            parts[-1].append(line)
    found, at = [], 0
    for number, part in enumerate(parts):
        last = number == len(parts) - 1
        end = len(printed) - len(part)
        starts = [0] if number == 0 else [end] if last else range(at, end + 1)
        if end < at:
            return printed  # nothing of it is left: cut it anew
        best = max(starts, key=lambda i: likeness(part, printed[i : i + len(part)])) if part else at
        found.append(printed[best : best + len(part)])
        at = best + len(part)
    return [line for i, part in enumerate(found) for line in ([ELLIPSIS] if i else []) + part]


def likeness(old: list[str], new: list[str]) -> float:
    """Return how alike two stretches of lines are, blanks aside."""
    pairs = zip(old, new, strict=False)
    return sum(SequenceMatcher(None, " ".join(a.split()), " ".join(b.split())).ratio() for a, b in pairs)


def refresh(page: Path) -> None:
    """Rewrite one page."""
    text, session = page.read_text(encoding="utf-8"), Session()

    def replayed(match: re.Match[str]) -> str:
        if match["kind"] != "console":
            session.play(match["kind"], match["body"])
            return match[0]
        lines = []
        for step in steps(match["body"]):
            lines += [f"$ {step.typed}", *refreshed(step.shown, session.command(shlex.split(step.typed)))]
        return "\n".join(["```console", *lines, "```"])

    with tempfile.TemporaryDirectory() as folder:
        here = Path.cwd()
        os.chdir(folder)
        try:
            new = FENCE.sub(replayed, text)
        finally:
            os.chdir(here)
    page.write_text(new, encoding="utf-8")


if __name__ == "__main__":
    os.environ["COLUMNS"] = "200"
    for name in sys.argv[1:]:
        refresh(Path(name).resolve())
