"""Settings: the fields of a Plan, once, for the campaign schema, options, arguments and manual. Free of numpy."""

from __future__ import annotations

import sys
from collections.abc import Collection, Mapping
from dataclasses import MISSING, Field, dataclass, field, fields, is_dataclass, replace
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

PER_ACCELERATION = "output/(m/s^2)"  # unit of a setting: pulses a second, volts or counts per acceleration


@dataclass(frozen=True)
class Setting:
    """One field of a Plan that a user may set."""

    name: str  # As the field is called
    help: str  # One sentence
    example: str  # How to write it
    unit: str  # Inside; empty for what is no quantity
    difference: bool  # Of temperatures
    many: bool  # A list
    flag: bool  # Yes or no
    choices: tuple[str, ...]  # Words that there are
    number: type | None  # ``int`` or ``float`` where it is a bare number
    default: object  # Inside; None where it has none; of a list or table what makes it
    needed: bool  # Has no default
    kind: Any  # Its type inside, as annotated
    table: type[Any] | None = None  # Settings of its own: their dataclass
    above: float | None = None  # Limit: larger than this
    least: float | None = None  # Limit: no smaller
    most: float | None = None  # Limit: no larger
    pairs: bool = False  # ``NAME=VALUE``, which may be repeated; in Python a mapping
    flag_name: str = ""  # Name on the command line where that is another one

    @property
    def option(self) -> str:
        """Name on the command line."""
        return self.flag_name or self.name.replace("_", "-")

    @property
    def type_text(self) -> str:
        """Type as documentation has it: a quantity is text with its unit."""
        own = f"{{{', '.join(map(repr, self.choices))}}}" if self.choices else "bool" if self.flag else ""
        own = own or ("dict" if self.table else "mapping of str to str" if self.pairs else "")
        own = own or (self.number.__name__ if self.number else "str")
        return f"{f'sequence of {own}' if self.many else own}, optional"

    @property
    def described(self) -> str:
        """Help with choices, example and default."""
        words = f"One of: {', '.join(self.choices)}." if self.choices else ""
        written = "" if self.choices or self.example == self.plain_default else self.example
        example = f"Example: {written}." if written else ""
        default = f"Default: {self.plain_default}." if self.plain_default else ""
        return " ".join(part for part in (self.help, words, example, default) if part)

    @property
    def plain_default(self) -> str:
        """Default in the unit inside, for help, which must not load the units; empty without one."""
        if self.default is None or self.default == "" or callable(self.default) or self.needed:
            return ""
        if self.flag:
            return "yes" if self.default else "no"
        return f"{self.default:g} {self.unit}" if self.unit and isinstance(self.default, float) else str(self.default)

    @property
    def about(self) -> str:
        """Help with the words to choose from."""
        return f"{self.help} One of: {', '.join(self.choices)}." if self.choices else self.help

    @property
    def path(self) -> bool:
        """Whether it names a file."""
        return Path in (self.kind, *get_args(self.kind))

    @property
    def written(self) -> str:
        """Example as a line of TOML: ``cube = "5.08 cm"``."""
        if self.pairs and self.example and not self.example.startswith("{"):
            key, _, value = self.example.partition("=")
            return f"{self.name} = {{ {key} = {value} }}"
        if self.many and self.example and self.table is None and not self.example.startswith("["):
            quoted = self.number is not None or self.example.startswith('"')
            return f"{self.name} = [{self.example}]" if quoted else f'{self.name} = ["{self.example}"]'
        bare = self.many or self.flag or self.number is not None or self.table is not None
        return f"{self.name} = {self.example}" if bare else f'{self.name} = "{self.example}"'


def setting(
    help: str,
    default: Any = MISSING,
    *,
    unit: str = "",
    difference: str = "",
    example: str = "",
    above: float | None = None,
    least: float | None = None,
    most: float | None = None,
    option: str = "",
) -> Any:
    """Return a field of a Plan: one sentence on it, its unit, its limits, how to write it, its option."""
    given: Mapping[str, object] = {
        "help": help, "unit": unit, "difference": difference, "example": example, "above": above, "least": least,
        "most": most, "option": option,
    }  # fmt: skip
    kept = {name: value for name, value in given.items() if value not in ("", None)}
    if callable(default):
        return field(default_factory=default, metadata=kept)
    return field(default=default, metadata=kept)


def fact(help: str, origin: Literal["sensor", "site", "standards", "command"], default: Any = MISSING) -> Any:
    """Return a field of a Plan that nobody sets: it comes from the sensor, the site, the standards or a command."""
    kept: Mapping[str, object] = {"help": help, "from": origin}
    if callable(default):
        return field(default_factory=default, metadata=kept)
    return field(default=default, metadata=kept)


_KNOWN: dict[type[object], tuple[Setting, ...]] = {}  # each call of a noun asks for all of its own, which take 25 ms


def settings_of(plan: type[object]) -> tuple[Setting, ...]:
    """Return the settings of a Plan that a user may give, in its order."""
    if plan not in _KNOWN:
        hints = get_type_hints(plan, vars(sys.modules[plan.__module__]))
        known = fields(plan)  # type: ignore[arg-type]
        _KNOWN[plan] = tuple(_setting(one, hints[one.name]) for one in known if "from" not in one.metadata)
    return _KNOWN[plan]


def grouped_settings(kinds: Mapping[str, type[object] | None]) -> dict[str, tuple[Setting, ...]]:
    """Return the settings of several dataclasses by group; what two of them have is the first one's.

    An option whose word another setting has taken is called as its field is: ``--stop`` where ``--to`` is taken.
    """
    found: dict[str, tuple[Setting, ...]] = {}
    names: set[str] = set()
    options: set[str] = set()
    for group, kind in kinds.items():
        every = () if kind is None else settings_of(kind)
        free = [one for one in every if one.name not in names]
        found[group] = tuple(replace(one, flag_name="") if one.option in options else one for one in free)
        names |= {one.name for one in every}
        options |= {one.option for one in found[group]}
    return found


def _setting(one: Field[Any], hint: Any) -> Setting:
    parts = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    kind = next(part for part in parts if part is not NoneType)
    many = get_origin(kind) in (list, tuple)
    inner = get_args(kind)[0] if many else kind
    choices = tuple(map(str, get_args(inner))) if get_origin(inner) is Literal else ()
    meta = one.metadata
    example = str(meta.get("example", "")) or (choices[0] if choices else "")
    unit = str(meta.get("unit") or meta.get("difference") or "")
    number = inner if inner in (int, float) and not unit else None
    needed = one.default is MISSING and one.default_factory is MISSING
    default = one.default_factory if one.default is MISSING else one.default
    return Setting(
        one.name, str(meta.get("help", "")), example, unit, "difference" in meta, many,
        inner is bool, choices, number, None if default is MISSING else default, needed, hint,
        inner if isinstance(inner, type) and is_dataclass(inner) else None,
        meta.get("above"), meta.get("least"), meta.get("most"), get_origin(kind) in (dict, Mapping),
        meta.get("option", ""),
    )  # fmt: skip


def starter(kind: type[object], active: Collection[str], head: str) -> str:
    """Return a settings file as TOML: every setting with its help; those not in `active` are commented out.

    Parameters
    ----------
    kind : type
        Dataclass whose settings are groups.
    active : collection of str
        ``"group.key"`` of those to begin with.
    head : str
        First line.
    """
    lines = [f"# {head}"]
    for group in settings_of(kind):
        known = settings_of(group.table) if group.table is not None else ()
        off = "" if group.needed or any(f"{group.name}.{one.name}" in active for one in known) else "# "
        lines += ["", f"# {group.help}", f"{off}[{group.name}]"]
        for one in known:
            mark = "" if f"{group.name}.{one.name}" in active else "# "
            lines.append(f"{mark}{one.written}  # {one.about}")
    return "\n".join(lines) + "\n"


def settings_table(kind: type[object]) -> list[tuple[str, str, str, str]]:
    """Return a row for each setting of the groups of a dataclass: key, how to write it, default, help."""
    from .units import factor, parse_quantity  # noqa: PLC0415 - numpy starts slowly

    rows = []
    for group in settings_of(kind):
        for one in () if group.table is None else settings_of(group.table):
            default = one.plain_default
            if default and one.unit:
                unit = parse_quantity(one.example).unit
                default = f"{float(str(one.default)) * factor(one.unit, unit):g} {unit}"
            rows.append((f"{group.name}.{one.name}", one.written.partition(" = ")[2], default, one.about))
    return rows
