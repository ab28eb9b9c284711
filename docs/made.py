"""Write `campaign/calls/nouns.pyi`: the calls of Python with their types, made of the settings of each procedure.

python docs/made.py          # writes it
python docs/made.py --check  # fails where it is not fresh
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path

from click import Context
from typer.main import get_command

import inertialcal
from inertialcal.campaign.calls.call import settings_by_group
from inertialcal.cli.app import app
from inertialcal.core.settings import Setting, settings_of
from inertialcal.core.units import factor, parse_quantity
from inertialcal.procedures import BUILT_IN, procedure_of
from inertialcal.rigs import BUILT_IN as RIG_NAMES
from inertialcal.rigs import RIGS
from inertialcal.rigs.faults import FAULTS
from inertialcal.signals.sense.limits import limits_table

FILE = Path(inertialcal.__file__).parent / "campaign" / "calls" / "nouns.pyi"
COMMANDS = get_command(app)
VALUES = {
    "max_memory": " SIZE",
    "digits": " N",
    "output": " FILE",
    "campaign": " FOLDER",
    "figure": " NAME",
    "figure_axis": " AXIS",
}
PAGES = Path(__file__).parent / "procedures"
GATE = Path(__file__).parent / "gate.md"
OF_PLANNERS = ("positions_planning.md", "mass_attraction.md")  # their settings are of another list
HEAD = '''"""Made by docs/made.py of the settings of each procedure: do not edit."""

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
    if one.name == "like":
        return "str | Path"
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
            word = declared.function
            names.append(word)
            lines = "".join(arguments)
            first = "    recordings: Given | Sequence[Given],\n    /,\n    *,\n"
            parts.append(f"def {word}(\n{first}{lines}) -> Reduced: ...\n")
    listed = "[\n" + "".join(f'    "{name}",\n' for name in sorted(["Reduced", *names])) + "]"
    return HEAD.format(names=listed) + "\n" + "".join(parts)


def kind_of(one: Setting) -> str:
    """Return how a setting is written, for the manual."""
    limits = [f"> {one.above:g}"] if one.above is not None else []
    limits += [f">= {one.least:g}"] if one.least is not None else []
    limits += [f"<= {one.most:g}"] if one.most is not None else []
    own = " or ".join(f'`"{word}"`' for word in one.choices) if one.choices else ""
    own = own or ("true or false" if one.flag else "table" if one.table else "quantity" if one.unit else "")
    own = own or {int: "integer", float: "number"}.get(one.number, "text")  # type: ignore[arg-type]
    whole = " ".join([own, *limits])
    return f"list, each {whole}" if one.many else whole


def default_of(one: Setting) -> str:
    """Return the default of a setting as a campaign file has it."""
    if one.needed:
        return "required"
    if one.default is None or callable(one.default) or one.default == "":
        return "none"
    if one.flag:
        return f"`{str(one.default).lower()}`"
    if not one.unit:
        return f"`{one.default}`" if one.number is not None else f'`"{one.default}"`'
    unit = one.unit if one.difference or one.unit == "degC" else parse_quantity(one.example).unit
    scale = 1.0 if unit == one.unit else factor(one.unit, unit)
    return f'`"{float(str(one.default)) * scale:g} {unit}"`'


def table(kind: type[object]) -> list[str]:
    """Return the lines of a table of settings."""
    lines = ["| key | kind | default | example | meaning |", "|---|---|---|---|---|"]
    for one in settings_of(kind):
        example = f"`{one.example}`" if one.example else ""
        lines.append(f"| `{one.name}` | {kind_of(one)} | {default_of(one)} | {example} | {one.help} |")
    return lines


def page(text: str, tables: Mapping[str, type[object] | list[str]]) -> str:
    """Return a page whose tables, each the first after its mark at the start of a line, are made anew."""
    lines = text.split("\n")
    for mark, kind in tables.items():
        at = next((i for i, line in enumerate(lines) if line.startswith(mark)), None)
        if at is None:
            continue
        first = next(i for i in range(at, len(lines)) if lines[i].startswith("|"))
        last = next(i for i in range(first, len(lines)) if not lines[i].startswith("|"))
        lines[first:last] = kind if isinstance(kind, list) else table(kind)
    return "\n".join(lines)


def options(word: str) -> list[str]:
    """Return the lines of the table of a noun's options."""
    lines = ["| option | meaning |", "|---|---|"]
    for one in COMMANDS.get_command(Context(COMMANDS), word).params:
        if one.param_type_name == "argument":
            lines.append(f"| `{str(one.name).upper()}` | {one.help} |")
            continue
        names = [*one.opts, *one.secondary_opts]
        value = "" if one.is_flag or one.secondary_opts or one.name == "help" else VALUES.get(str(one.name), " VALUE")
        shown = ", ".join(f"`{name}{value}`" for name in names)
        lines.append(f"| {shown} | {escaped(one.help or '')} |")
    return [*lines, "| `--help` | Show the options. |"]


def terms() -> list[str]:
    """Return the lines of the table of what each procedure gives to the model of a sensor."""
    giving = {name: procedure_of(name).gives for name in BUILT_IN}
    lines = ["| procedure | kinds of term |", "|---|---|"]
    return lines + [
        f"| `{name}` | {', '.join(f'`{one}`' for one in kinds)} |" for name, kinds in giving.items() if kinds
    ]


def faults() -> list[str]:
    """Return the lines of the table of general faults, with the rigs that take each."""
    lines = ["| fault | size | what it does | expected | rigs |", "|---|---|---|---|---|"]
    for name, one in FAULTS.items():
        rigs = ", ".join(f"`{rig}`" for rig in RIG_NAMES if RIGS[rig].every_fault.get(name) is one)
        codes = " or ".join(f"`{code}`" for code in one.codes)
        expected = {"refused": f"refused, {codes}", "named": codes, "covered": "intervals hold"}[one.expects]
        lines.append(f"| `{name}` | {one.default} | {escaped(one.what)} | {expected} | {rigs} |")
    return lines


def limits() -> list[str]:
    """Return the lines of the table of what sensors can read."""
    rows = [" | ".join(("", *cells, "")).strip() for cells in limits_table()]
    return ["| kind | least | largest | why |", "|---|---|---|---|", *rows]


def escaped(text: str) -> str:
    """Return text that does not end a cell."""
    return text.replace("|", "\\|")


def made() -> dict[Path, str]:
    """Return the content of every file, by its path."""
    found = {FILE: text()}
    found[GATE] = page(
        GATE.read_text(encoding="utf-8"), {"## What is possible": limits(), "## Rigs that misbehave": faults()}
    )
    campaign = GATE.with_name("campaign.md")
    given = {"## Which procedure gives": terms()}
    found[campaign] = page(campaign.read_text(encoding="utf-8"), given)
    for name in BUILT_IN:
        plan = procedure_of(name).plan_type
        marks = {"## Settings": plan}
        marks |= {f"`{one.name}`:": one.table for one in settings_of(plan) if one.table is not None}
        for path in sorted(PAGES.glob(f"{name}*.md")):
            found[path] = page(path.read_text(encoding="utf-8"), marks)
        for declared in procedure_of(name).commands:
            path = PAGES.parent / "commands" / f"{declared.word.replace(' ', '-')}.md"
            found[path] = page(path.read_text(encoding="utf-8"), {"## Options": options(declared.word)})
    return {path: content for path, content in found.items() if path.name not in OF_PLANNERS}


def main() -> int:
    """Write the files, or name those that are not fresh."""
    wrong = [path for path, content in made().items()
             if not path.is_file() or path.read_text(encoding="utf-8") != content]  # fmt: skip
    if "--check" not in sys.argv[1:]:
        for path in wrong:
            path.write_text(made()[path], encoding="utf-8")
        return 0
    for path in wrong:
        print(f"{path.name} is not what the settings say: run python docs/made.py", file=sys.stderr)
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
