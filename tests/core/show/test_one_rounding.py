"""One rounding rule: against decimal arithmetic, in the source, and in every table that campaigns print."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from decimal import ROUND_HALF_EVEN, Context, Decimal
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import inertialcal
from inertialcal.core.show.rounding import dof, ends, near, uncertainty, with_uncertainty

SOURCE = Path(inertialcal.__file__).parent
EXACT = Context(prec=1200, rounding=ROUND_HALF_EVEN)
FIGURE = re.compile(r"\(?(-?[\d.]+) ± ([\d.]+)\)?(e[+-]\d+)?")
ENDS = re.compile(r"\(?(-?[\d.]+) \.\. (-?[\d.]+)\)?(e[+-]\d+)?")
UNCERTAIN = re.compile(r"(stated_)?u|u_(?!rounded)\w+|dof|deciding_u")  # names of what rounding.py alone makes text of
ENDS_OF_ROWS = {"lo", "hi"}  # where they are fields: a bare name may be any range
values = st.floats(-1e12, 1e12, allow_nan=False)
sizes = st.floats(1e-12, 1e9, allow_nan=False)


def last_of(u: float) -> Decimal:
    """The decade of the second significant digit of u, once it is rounded to two."""
    rounded = Context(prec=2, rounding=ROUND_HALF_EVEN).plus(Decimal(u))
    return Decimal(1).scaleb(rounded.adjusted() - 1)


def number_of(text: str, power: str | None) -> Decimal:
    return Decimal(text) * (Decimal(1) if power is None else Decimal(f"1{power}"))


def place_of(text: str, power: str | None) -> Decimal:
    """One unit of the last digit that is shown."""
    return Decimal(1).scaleb(-len(text.partition(".")[2])) * (Decimal(1) if power is None else Decimal(f"1{power}"))


@given(values, sizes)
def test_value_and_uncertainty_by_decimal_arithmetic(value: float, u: float) -> None:
    found = FIGURE.fullmatch(with_uncertainty(value, u))
    assert found
    last = last_of(u)
    assert place_of(found[1], found[3]) == place_of(found[2], found[3]) == last
    assert number_of(found[1], found[3]) == EXACT.quantize(Decimal(value), last)
    assert number_of(found[2], found[3]) == EXACT.quantize(Decimal(u), last)
    assert not found[1].startswith("-") or number_of(found[1], found[3]) != 0


@given(values, sizes, st.floats(0.1, 30.0), st.floats(0.1, 30.0))
def test_ends_stand_where_the_value_does(value: float, u: float, below: float, above: float) -> None:
    lo, hi = value - below * u, value + above * u
    found, last = ENDS.fullmatch(ends(value, u, lo, hi)), last_of(u)
    assert found
    pair = [(found[1], lo), (found[2], hi)]
    plain = [EXACT.quantize(Decimal(end), last) for end in (lo, hi)]
    finer = plain[0] == plain[1] or any(end and not text for end, text in zip((lo, hi), plain, strict=True))
    last = last / 10 if finer else last
    for text, end in pair:
        assert place_of(text, found[3]) == last
        assert number_of(text, found[3]) == EXACT.quantize(Decimal(end), last)


@given(sizes)
def test_an_uncertainty_alone_has_two_digits(u: float) -> None:
    two = Context(prec=2, rounding=ROUND_HALF_EVEN).plus(Decimal(u))
    assert Decimal(uncertainty(u)) == two
    assert len(re.sub(r"e.*|\.", "", uncertainty(u)).lstrip("0")) == 2


@given(values, sizes)
def test_a_figure_beside_has_one_digit_more(value: float, u: float) -> None:
    assert Decimal(near(value, u)) == EXACT.quantize(Decimal(value), last_of(u) / 10)


@given(st.floats(1.0, 99_000.0))
def test_degrees_of_freedom_have_no_exponent(value: float) -> None:
    assert re.fullmatch(r"\d+(\.\d+)?", dof(value))
    assert float(dof(value)) == pytest.approx(value, rel=5.01e-3)


def test_what_is_not_finite() -> None:
    assert ends(1.0, None, 0.98, 1.02) == "0.980 .. 1.020"  # a quarter of the interval is its u
    assert ends(1.0, 0.1, None, 1.2) == "- .. 1.20"
    assert [uncertainty(None), uncertainty(0.0), uncertainty(float("inf")), ends(1.0, None, None, None)] == [
        "-", "0", "-", "- .. -",
    ]  # fmt: skip


def last_name(node: ast.expr) -> str:
    """The name that an expression ends in: of ``row["u"]``, ``one.u`` and ``float(u)`` that is u."""
    if isinstance(node, ast.Call):
        return last_name(node.args[0]) if len(node.args) == 1 else ""
    if isinstance(node, ast.Subscript):
        return node.slice.value if isinstance(node.slice, ast.Constant) and isinstance(node.slice.value, str) else (
            last_name(node.value)
        )  # fmt: skip
    if isinstance(node, ast.BinOp):
        names = [last_name(side) for side in (node.left, node.right)]
        return next(filter(UNCERTAIN.fullmatch, names), "") if isinstance(node.op, ast.Mult) else ""
    return node.attr if isinstance(node, ast.Attribute) else node.id if isinstance(node, ast.Name) else ""


def is_uncertain(node: ast.expr) -> bool:
    name = last_name(node)
    return bool(UNCERTAIN.fullmatch(name)) or (name in ENDS_OF_ROWS and not isinstance(node, ast.Name))


def made_elsewhere(tree: ast.AST) -> Iterator[ast.expr]:
    """Places that make text of an uncertainty, an end or degrees of freedom with digits of their own."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.args:
            if node.func.id in {"number", "settled_number"} and is_uncertain(node.args[0]):
                yield node
        elif isinstance(node, ast.FormattedValue) and node.format_spec is not None:
            said = ast.unparse(node.format_spec)
            if is_uncertain(node.value) and re.search(r"\.\d+[gf]", said):  # g alone: as it was given
                yield node


def test_no_other_place_makes_text_of_uncertainties() -> None:
    found = [
        f"{path.relative_to(SOURCE)}:{node.lineno}: {ast.unparse(node)}"
        for path in sorted(SOURCE.rglob("*.py"))
        if path.name != "rounding.py"
        for node in made_elsewhere(ast.parse(path.read_text()))
    ]
    assert not found


@pytest.mark.parametrize(
    "line", ['number(row["u"], 3)', 'f"{u:.2g}"', "number(float(one.u * k), 2)", "number(row.lo, 4)"]
)
def test_the_walk_finds_them(line: str) -> None:
    assert list(made_elsewhere(ast.parse(line)))
