"""List every text that a user reads in a terminal, a message, help or a report: to be read aloud.

python docs/texts.py [PART OF A PATH]       # file:line, kind, text
python docs/texts.py --words                # those with words that no engineer says to a colleague
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import inertialcal

ROOT = Path(inertialcal.__file__).parent
SPOKEN = (
    "Error",
    "Problem",
    "Remark",
    "Reason",
    "Command",
    "Option",
    "Argument",
    "FigureSpec",
    "setting",
    "fact",
    "print",
)
NAMES = {"what", "why", "do", "text", "caption", "title", "reason", "help", "SHOWS", "finding"}
WORDS = re.compile(
    r"\b(nothing says|is no [a-z]|are no [a-z]|told|of its own|one that|beside|found that|untold|at no)\b"
)


def pieces(node: ast.AST) -> str:
    """Return a string of the source, with what is filled in as ``{}``."""
    if isinstance(node, ast.Constant):
        return node.value if isinstance(node.value, str) else ""
    if isinstance(node, ast.JoinedStr):
        return "".join(pieces(part) if isinstance(part, ast.Constant) else "{}" for part in node.values)
    return ""


def texts(path: Path) -> Iterator[tuple[int, str, str]]:
    """Yield line, kind and text of all that a module says to people."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        said: list[ast.AST] = []
        kind = ""
        if isinstance(node, ast.Call):
            kind = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            if kind.endswith(SPOKEN):
                said = [*node.args, *(one.value for one in node.keywords)]
        elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name) and node.targets[0].id in NAMES:
            kind, said = node.targets[0].id, [node.value]
        for one in said:
            text = pieces(one)
            if " " in text.strip():
                yield one.lineno, kind, text


def main() -> int:
    """Print the list."""
    words = "--words" in sys.argv[1:]
    parts = [one for one in sys.argv[1:] if not one.startswith("--")]
    count = 0
    for path in sorted(ROOT.rglob("*.py")):
        where = str(path.relative_to(ROOT))
        if parts and not any(part in where for part in parts):
            continue
        for line, kind, text in texts(path):
            if not words or WORDS.search(text):
                print(f"{where}:{line}: {kind}: {text}")
                count += 1
    print(f"{count} texts", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
