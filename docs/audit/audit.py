"""Recompute the printed figures of the three documents, and write ``docs/source_audit.md``.

``python docs/audit/audit.py`` writes the page; ``--check`` only says whether the page is what the tables give.
"""

import sys
from pathlib import Path

from source_audit.documents import DOCUMENTS
from source_audit.page import page

PAGE = Path(__file__).resolve().parents[1] / "source_audit.md"


def main(arguments: list[str]) -> int:
    """Write or check the page."""
    text = page([document() for document in DOCUMENTS])
    if arguments == ["--check"]:
        same = PAGE.is_file() and PAGE.read_text(encoding="utf-8") == text
        print(f"{PAGE.name} is {'up to date' if same else 'out of date: python docs/audit/audit.py'}")
        return 0 if same else 1
    PAGE.write_text(text, encoding="utf-8")
    print(f"{PAGE.name} written")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
