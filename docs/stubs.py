"""Write `campaign/calls/nouns.pyi`: the calls of Python with their types, made of the settings of each procedure.

python docs/stubs.py          # writes it
python docs/stubs.py --check  # fails where it is not fresh
"""

from __future__ import annotations

import sys
from pathlib import Path

import inertialcal
from inertialcal.campaign.calls.call import settings_by_group
from inertialcal.core.settings import Setting
from inertialcal.procedures import BUILT_IN, procedure_of

FILE = Path(inertialcal.__file__).parent / "campaign" / "calls" / "nouns.pyi"
HEAD = '''"""Made by docs/stubs.py of the settings of each procedure: do not edit."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

from .call import Reduced
from .given import Given

__all__ = {names}
'''


def type_of(one: Setting) -> str:
    """Return the type of an argument: a quantity is text with its unit."""
    if one.pairs:
        return "Mapping[str, str] | Sequence[str] | str"
    inner = f"Literal[{', '.join(map(repr, one.choices))}]" if one.choices else "str"
    inner = "bool" if one.flag else "Mapping[str, Any] | str" if one.table else inner
    inner = one.number.__name__ if one.number is not None else inner
    return f"Sequence[{inner}] | {inner}" if one.many else inner


def text() -> str:
    """Return the content of the file."""
    parts = []
    names = []
    for name in BUILT_IN:
        procedure = procedure_of(name)
        settings = [one for group in settings_by_group(procedure).values() for one in group]
        arguments = [f"    {one.name}: {type_of(one)} | None = None,\n" for one in settings]
        if "hold_out" in procedure.uses:
            arguments.append("    hold_out: Sequence[str | Path] = (),\n")
        for declared in procedure.commands:
            word = declared.word.replace("-", "_")
            names.append(word)
            lines = "".join(arguments)
            first = "    recordings: Given | Sequence[Given],\n    /,\n    *,\n"
            parts.append(f"def {word}(\n{first}{lines}) -> Reduced: ...\n")
    listed = "[\n" + "".join(f'    "{name}",\n' for name in sorted(["Reduced", *names])) + "]"
    return HEAD.format(names=listed) + "\n" + "".join(parts)


def main() -> int:
    """Write the file, or say that it is not fresh."""
    made = text()
    if "--check" not in sys.argv[1:]:
        FILE.write_text(made, encoding="utf-8")
        return 0
    if not FILE.is_file() or FILE.read_text(encoding="utf-8") != made:
        print(f"{FILE.name} is not what the settings say: run python docs/stubs.py", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
