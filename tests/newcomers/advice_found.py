"""Every advice that the sources give: texts of messages that name an option, or a command to type.

Found by walking the syntax trees. A text with fields is known by a template, ``Add --unit {}``, and matches what it
becomes. Left out are texts that give no advice: help of options, examples (they have tests of their own), docstrings,
what a message says is wrong, comments and heads of written files, and what an option said (``as --shared says``).
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Set
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import inertialcal
from inertialcal.cli.commands import PLAN, words

FIELD = "{}"
SOURCES = Path(inertialcal.__file__).parent
TYPED = "|".join(
    sorted((*words(), PLAN.word, f"{FIELD} ", "--"), key=len, reverse=True)
)  # what may follow the program's name
NAMED = re.compile(rf"(?<![\w-])--[a-z][a-z-]+\b(?! says)|\binertialcal (?:{TYPED})(?![\w-])|\bpip install\b")
HELP = {"Option", "Argument", "option", "setting", "Command", "Example", "Group", "write_starter"}  # they describe
LEAVES = (ast.Name, ast.expr_context, ast.operator, ast.cmpop, ast.arg, ast.alias)  # they hold no text
COMMENT = re.compile(r"^#.*$", re.MULTILINE)  # of a file that is written
NOT_SAID = ("cli/commands.py", "report/figures/drawing/", "report/paper.py", "files/write/exchange.py")


@dataclass(frozen=True)
class Advice:
    """An advice: where it stands, and its text with ``{}`` for what is filled in."""

    where: str
    template: str

    def gave(self, text: str) -> bool:
        """Whether a message holds it."""
        parts = [re.escape(one) for one in self.template.split(FIELD)]
        return re.search(r"[\s\S]*?".join(parts).replace(r"\ ", r"\s+"), text) is not None


@cache
def advices() -> tuple[Advice, ...]:
    """Return every advice of the sources, each text once."""
    found: dict[str, Advice] = {}
    for path in sorted(SOURCES.rglob("*.py")):
        name = path.relative_to(SOURCES).as_posix()
        text = path.read_text(encoding="utf-8")
        if not name.startswith(NOT_SAID) and (NAMED.search(text) or ".add(" in text):
            for line, template in _in_module(ast.parse(text), "examples=" in text):
                found.setdefault(template, Advice(f"{name}:{line}", template))
    return tuple(found.values())


def _in_module(tree: ast.Module, has_examples: bool) -> Iterator[tuple[int, str]]:
    """Yield line and template of each advice of a module."""
    made = [node for node in ast.walk(tree) if isinstance(node, ast.keyword)] if has_examples else []
    examples = {one.id for node in made if node.arg == "examples"
                for one in ast.walk(node) if isinstance(one, ast.Name)}  # fmt: skip
    yield from _in_node(tree, examples)


def _in_node(node: ast.AST, examples: Set[str]) -> Iterator[tuple[int, str]]:
    """Yield line and template of each advice in a node; none within one that is found, or that gives none."""
    if isinstance(node, LEAVES) or _is_no_advice(node, examples):
        return
    template = COMMENT.sub("", _template(node))
    is_option = template.startswith("--")
    if template.strip("-{} ") and (NAMED.search(template) if not is_option else " " in template):
        yield node.lineno, template  # type: ignore[attr-defined]
        return
    wrong: ast.AST | None = None  # what is wrong, said before what to do
    if isinstance(node, ast.Call) and _called(node).endswith(("Error", "Remark")):
        said = 0 if _called(node).endswith("Error") else 2
        wrong = node.args[said] if len(node.args) > said else None
    for child in ast.iter_child_nodes(node):
        if child is not wrong:
            yield from _in_node(child, examples)


def _is_no_advice(node: ast.AST, examples: Set[str]) -> bool:
    """Whether a node holds a docstring, help of an option, an example or what one is made of, or what is wrong."""
    if isinstance(node, ast.Expr):
        return isinstance(node.value, ast.Constant)
    if isinstance(node, ast.Assign):
        return any(isinstance(one, ast.Name) and one.id in {"what", *examples} for one in node.targets)
    if isinstance(node, ast.keyword):
        return node.arg in ("help", "examples", "example", "what", "metavar")
    return isinstance(node, ast.Call) and _called(node) in HELP


def _called(node: ast.Call) -> str:
    """Return the name of what is called."""
    function = node.func
    return function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")


def _template(node: ast.AST) -> str:
    """Return the text of a node, ``{}`` for its fields; options that ``given.add`` makes as they are typed."""
    if isinstance(node, ast.Constant):
        return node.value if isinstance(node.value, str) else ""
    if isinstance(node, ast.JoinedStr):
        return "".join(_template(one.value) if isinstance(one, ast.FormattedValue) else _template(one)
                       for one in node.values)  # fmt: skip
    if isinstance(node, ast.Call) and _called(node) == "add" and len(node.args) == 2:
        option, value = (_template(one) for one in node.args)
        if option:
            quoted = f'"{value}"' if " " in value else value
            return f"--{option.replace('_', '-')} {quoted}"
    return FIELD if isinstance(node, ast.expr) else ""
