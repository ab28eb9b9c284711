"""Set the tool against truth that is not its own, and write ``docs/validation.md``.

::

    python docs/validation/validation.py                  # every part, then the page
    python docs/validation/validation.py noise peers      # some parts; the others stay as they were found
    python docs/validation/validation.py --page           # the page alone, from what was found

What a part found is kept in ``found.json`` beside this file, with its date. A line that does not hold is bold on the
page, and the command then ends with 1. A part whose recordings or peers are absent is left as it was, and says so.
"""

import argparse
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
TESTS = HERE.parents[1] / "tests"
HELPERS = ("", "statistics", "signals/allan", "procedures/positions")  # tests whose data and exact sums are taken
sys.path[:0] = [str(TESTS / one) for one in HELPERS]

from validated import PARTS, AbsentError  # noqa: E402
from validated.found import load, store  # noqa: E402
from validated.page import page  # noqa: E402

PAGE = HERE.parent / "validation.md"


def main() -> int:
    """Try the parts, keep what they found, write the page."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("parts", nargs="*", choices=[[], *PARTS], metavar="PART", help=", ".join(PARTS))
    words.add_argument("--page", action="store_true", help="write the page from what was found")
    given = words.parse_args()
    for name in () if given.page else given.parts or PARTS:
        try:
            tables = PARTS[name]()
        except AbsentError as absent:
            print(f"{name}: left as it was: {absent}", file=sys.stderr, flush=True)
            continue
        store(name, tables)
        held, judged = (sum(one.counted[i] for one in tables) for i in (0, 1))
        print(f"{name}: {held} of {judged} lines hold", file=sys.stderr, flush=True)
    found = load()
    PAGE.write_text(page(found), encoding="utf-8")
    print(f"{PAGE.name} written")
    return int(any(not line.holds for part in found.values() for table in part.tables for line in table.lines))


if __name__ == "__main__":
    sys.exit(main())
