"""Which commands there are, built when one is typed: nouns as the procedures declare them, and the verbs.

A noun ``word`` (it may be two words) of a procedure ``name`` is the function ``word`` in ``cli/nouns/<name>.py``, its
plan the function ``plan`` in ``cli/nouns/<name>_plan.py``; a procedure of others names modules of its own. Help of all
commands builds none of the nouns: their line stands in the declaration.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from importlib import import_module
from pathlib import Path
from typing import Any

import typer
from typer.core import TyperCommand, TyperGroup
from typer.main import get_command_from_info
from typer.models import CommandInfo

from ..core.show.rounding import digits_shown
from ..files.budget import max_memory
from ..procedures import procedure_names, procedure_of
from ..procedures.protocol import Command
from .shown.screen import shown_whole

FIRST = {"info": "verbs.info"}
VERBS = {
    "init": "verbs.init", "check": "verbs.campaigns", "run": "verbs.campaigns", "demo": "verbs.demos",
    "show": "verbs.models", "compensate": "verbs.models", "convert": "verbs.models", "export": "verbs.models",
    "budget": "verbs.campaigns", "compare": "verbs.models", "simulate": "verbs.twins", "score": "verbs.twins",
    "programme-1969": "verbs.programme1969", "filter": "verbs.filters", "certificate": "verbs.certificate",
    "vibration profile": "verbs.vibration_profile", "acquire": "verbs.acquire", "live": "verbs.live",
    "sequence": "verbs.sequence",
    "guide": "verbs.guide", "lot": "verbs.lot",
}  # fmt: skip
NO_FIGURES = (
    "info",
    "init",
    "filter",
    "check",
    "demo",
    "compensate",
    "convert",
    "export",
    "budget",
    "simulate",
    "score",
    "certificate",
    "acquire",
    "live",
    "archive add",
    "archive list",
    "sequence",
    "archive export",
    "archive import",
    "archive verify",
    "archive migrate",
    "guide",
    "lot",
)
READ_NOTHING = ("demo", "simulate")  # commands that read no file of a user
OF_ARCHIVE = (
    "add",
    "list",
    "history",
    "trend",
    "compare",
    "export",
    "import",
    "verify",
    "migrate",
)  # what may follow ``archive``
Built = TyperCommand | TyperGroup
MAX_MEMORY = "Memory that files may take: 4GiB, 500MB. 1 GiB and three times each file if not given."
ALL = "Show long results whole on a terminal too; into a file or a pipe they always are."
DIGITS = "Significant digits of the figures in tables, or full. As many as the uncertainty has if not given."
ARCHIVE = Command("archive", "Every test of every unit in one database: archive list, archive history SERIAL, ...")
PLAN = Command("plan", "What a test will give, before it is made: plan TEST.")


def words() -> tuple[str, ...]:
    """Return the words of all commands that are no group, in the order of the help."""
    return (*FIRST, *_nouns(), *VERBS)


EXAMPLES = {  # word of a verb -> what may follow it, for its help
    "info": ("imu.csv", "imu.csv --unit acc=m/s2"),
    "init": ("gyros", "gyros --yes"),
    "check": ("inertialcal-demo", "inertialcal-demo --json"),
    "run": ("inertialcal-demo", "inertialcal-demo --archive lab.db"),
    "demo": ("npsat2011", "rate_table"),
    "certificate": ("inertialcal-demo-npsat1 -o certificate.pdf", "inertialcal-demo-npsat1 -o certificate.xml"),
    "show": ("inertialcal-demo", "inertialcal-demo -o matrix.png"),
    "compensate": ("inertialcal-demo flight.csv -o true.csv --uncertainty", "flight_unit counts.csv --steps"),
    "convert": ("inertialcal-demo/table10_x.csv table10.parquet", "inertialcal-demo/table10_x.csv table10.h5"),
    "export": ("inertialcal-demo --to json -o gyro.json --unjudged", "inertialcal-demo --to c -o flight --unjudged"),
    "budget": (
        "inertialcal-demo-rate_table",
        'inertialcal-demo-rate_table --test model --wanted "scale_factor_error=0.03 %"',
    ),
    "compare": (
        "inertialcal-demo/out/model.json other/out/model.json",
        'inertialcal-demo/out/model.json other/out/model.json --allowed bias="0.001 deg/s"',
    ),
    "simulate": ("rate_table -o twin --seed 1", "still_gyro --faults"),
    "score": ("twin", "--rig rate_table --n 3"),
    "programme-1969": (
        "run1.cards",
        'run1.csv --column pulses --period "480 s" --amplitude "23 ng" --wrong 41 -o run1',
    ),
    "archive add": ("gyro7-2026 --archive lab.db", "gyro7-2026 --archive lab.db --json"),
    "archive list": ("--archive lab.db", "--archive lab.db --serial 7"),
    "archive history": (
        "7 --archive lab.db --quantity scale_factor_error",
        '7 --archive lab.db --limit scale_factor_error="0.1 %"',
    ),
    "archive trend": (
        "scale_factor_error --archive lab.db --every",
        "scale_factor_error --archive lab.db --every --axis x",
    ),
    "archive compare": ("1 6 --archive lab.db", '1 6 --archive lab.db --allowed scale_factor_error="0.5 %"'),
    "archive export": ("lab.zip --archive lab.db", "lab.zip --archive lab.db --json"),
    "archive import": ("lab.zip --archive copy.db", "lab.zip --archive copy.db --quiet"),
    "archive verify": ("--archive lab.db", "--archive lab.db --json"),
    "archive migrate": ("--archive lab.db", "--archive lab.db --to 0002"),
    "acquire": ("LAB.toml -o recorded", "--seal recorded"),
    "live": ("recorded --state", "recorded --state --json"),
    "sequence": ("rehearsal/LAB.toml --check", "rehearsal/LAB.toml --check --json"),
    "guide": (
        'LAB.toml -o imu --no-page --gravity "9.807 m/s2" --label z+=label --for px4',
        'LAB.toml -o again --no-page --target bias="2 mg" --rest "2 s"',
    ),
    "lot": ("LOT.toml -o lot7", "gyros -o lot9 --archive lab.db"),
    "vibration profile": ("table01.csv -o profile.svg", "table01.csv --band 20..100"),
    "filter": (
        "inertialcal-demo rest.csv",
        'inertialcal-demo rest.csv --motion "20 deg/s" --motion-time "0.5 s" --for px4',
    ),
}


def _nouns() -> dict[str, tuple[str, Command]]:
    """Return procedure and declaration of each noun."""
    return {one.word: (name, one) for name in procedure_names() for one in procedure_of(name).commands}


def _planners() -> dict[str, tuple[str, Command]]:
    """Return procedure and declaration of each test that can be planned."""
    named = {name: procedure_of(name).planner for name in procedure_names()}
    return {one.word: (name, one) for name, one in named.items() if one is not None}


def _noun(name: str, declared: Command) -> Callable[..., Any]:
    """Return the function of a noun: made of the settings of its procedure, unless it has a module of its own."""
    if (Path(__file__).parent / "nouns" / f"{name}.py").exists():  # until all are made
        return _function(name, name, declared.function)
    from .nouns.factory import command_of

    return command_of(procedure_of(name), declared)


def _function(name: str, default: str, called: str) -> Callable[..., Any]:
    """Return the function of a noun of a procedure."""
    own = procedure_of(name).command_module
    module = import_module(own) if own else import_module(f".nouns.{default}", __package__)
    found: Callable[..., Any] = getattr(module, called)
    return found


def _epilog(words: str, examples: Sequence[str]) -> str:
    """Return the last lines of the help of a command; the first mark keeps them as they are."""
    return "\n".join(["\b", "Examples:", *(f"  inertialcal {words} {one}" for one in examples)]) if examples else ""


def _built(function: Callable[..., Any], word: str, about: str | None = None, epilog: str = "") -> Built:
    """Return a command, for the parser."""
    info = CommandInfo(name=word, callback=function, help=about, epilog=epilog)
    made: Any = get_command_from_info(info, pretty_exceptions_short=True, rich_markup_mode=None)
    found: TyperCommand = made
    if word not in READ_NOTHING:  # built in one place: no command can lack it
        found.params.append(_held("--max-memory", "SIZE", max_memory, MAX_MEMORY))
    if word not in NO_FIGURES:
        found.params.append(_held("--digits", "N", digits_shown, DIGITS))
    found.params.append(_held("--all", None, shown_whole, ALL))
    return found


def _held(name: str, metavar: str | None, holding: Callable[[Any], AbstractContextManager[None]], about: str) -> Any:
    """Return an option whose value holds until the command ends; without a metavar, a flag."""

    def hold(ctx: typer.Context, said: Any) -> None:
        if said is not None:
            ctx.with_resource(holding(said))

    option = typer.Option(None, name, metavar=metavar, callback=hold, expose_value=False, help=about)

    def holder(said: Any = option) -> None:
        """Have the parser make the option."""

    holder.__annotations__ = {"said": (str if metavar else bool) | None, "return": None}

    made: Any = get_command_from_info(
        CommandInfo(name="holder", callback=holder), pretty_exceptions_short=True, rich_markup_mode=None
    )
    option_made = made.params[0]
    option_made.name = name.strip("-").replace("-", "_")  # else all would be one
    return option_made


def _verb(word: str) -> Built:
    """Return a command that is no procedure's."""
    where = "verbs.archive" if word.partition(" ")[0] == ARCHIVE.word else (FIRST | VERBS)[word]
    module = import_module(f".{where}", __package__)
    return _built(getattr(module, word.replace("-", "_").replace(" ", "_")), word, epilog=_epilog(word, EXAMPLES[word]))


class _Lazy(TyperGroup):
    """A group whose commands are built when one is typed."""

    def names(self) -> list[str]:
        """Return the words of its commands."""
        raise NotImplementedError

    def line(self, word: str) -> Built:
        """Return a command that has nothing but its help."""
        raise NotImplementedError

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the words of the commands."""
        return self.names()

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """List the commands by their lines of help: none is built for it."""
        self.commands = {word: self.line(word) for word in self.names()}
        plain = TyperGroup(name=self.name, commands=self.commands, rich_markup_mode=None)
        plain.list_commands = lambda ctx: list(self.commands)  # type: ignore[method-assign]
        plain.format_commands(ctx, formatter)

    def get_command(self, ctx: object, cmd_name: str) -> Built | None:
        """Return a command, built now; None if there is none of that name."""
        raise NotImplementedError

    def resolve_command(self, ctx: typer.Context, args: list[str]) -> tuple[str | None, Built | None, list[str]]:  # type: ignore[override]
        """Return the command that was typed, and what follows it: its name may be two words."""
        both = " ".join(args[:2])
        if both in self.names():
            return both, self.get_command(ctx, both), args[2:]
        found: tuple[str | None, Built | None, list[str]] = super().resolve_command(ctx, args)  # type: ignore[assignment]
        return found


class Root(_Lazy):
    """All commands."""

    def names(self) -> list[str]:
        """Return the words of all commands."""
        return [*words(), ARCHIVE.word, PLAN.word]

    def line(self, word: str) -> Built:
        """Return a command that has nothing but its help; a verb is cheap, and built."""
        nouns = {noun: one for noun, (_, one) in _nouns().items()} | {PLAN.word: PLAN, ARCHIVE.word: ARCHIVE}
        return TyperCommand(word, help=nouns[word].help) if word in nouns else _verb(word)

    def get_command(self, ctx: object, cmd_name: str) -> Built | None:
        """Return a command, built now; None if there is none of that name."""
        if cmd_name == PLAN.word:
            return Planners(name=PLAN.word, help=PLAN.help, no_args_is_help=True, rich_markup_mode=None)
        if cmd_name == ARCHIVE.word:
            return OfArchive(name=ARCHIVE.word, help=ARCHIVE.help, no_args_is_help=True, rich_markup_mode=None)
        if cmd_name in _nouns():
            name, declared = _nouns()[cmd_name]
            return _built(_noun(name, declared), cmd_name, declared.help, _epilog(cmd_name, declared.examples))
        return _verb(cmd_name) if cmd_name in FIRST | VERBS else None


class OfArchive(_Lazy):
    """``archive``, and what may follow it."""

    def names(self) -> list[str]:
        """Return what may follow."""
        return list(OF_ARCHIVE)

    def line(self, word: str) -> Built:
        """Return a command that has nothing but its help."""
        return _verb(f"{ARCHIVE.word} {word}")

    def get_command(self, ctx: object, cmd_name: str) -> Built | None:
        """Return a command, built now; None if there is none of that name."""
        return self.line(cmd_name) if cmd_name in OF_ARCHIVE else None


class Planners(_Lazy):
    """``plan TEST``."""

    def names(self) -> list[str]:
        """Return the tests that can be planned."""
        return list(_planners())

    def line(self, word: str) -> Built:
        """Return a command that has nothing but its help."""
        return TyperCommand(word, help=_planners()[word][1].help)

    def get_command(self, ctx: object, cmd_name: str) -> Built | None:
        """Return a command, built now; None if there is none of that name."""
        if cmd_name not in _planners():
            return None
        name, declared = _planners()[cmd_name]
        epilog = _epilog(f"{PLAN.word} {cmd_name}", declared.examples)
        if procedure_of(name).planner_type is not None:
            from .nouns.planner import planner_of

            return _built(planner_of(procedure_of(name), declared), cmd_name, declared.help, epilog)
        return _built(_function(name, f"{name}_plan", "plan"), cmd_name, declared.help, epilog)


__all__ = ["PLAN", "Planners", "Root", "words"]
