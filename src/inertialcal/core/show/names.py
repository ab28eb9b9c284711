"""Names of rows for people, made from the fields of ``results.json``; no program reads them back."""

from __future__ import annotations

from ..results import WrittenRow, case_of, key_of


def quantity_name(row: WrittenRow) -> str:
    """Return the quantity with its power: ``"bias_temperature_2"``."""
    return key_of(row).name


def case_name(row: WrittenRow) -> str:
    """Return the method, part, place, sensor or condition of a row: ``"-20 degC"``, ``"flip 3"``; else nothing."""
    return str(case_of(row))


def full_name(row: WrittenRow) -> str:
    """Return the quantity, with its case in brackets: ``"bias (-20 degC)"``."""
    case = case_name(row)
    return f"{quantity_name(row)} ({case})" if case else quantity_name(row)


def reason_text(row: WrittenRow) -> str:
    """Return the reason of a row; empty where it has none."""
    return "" if row["reason"] is None else str(row["reason"]["text"])


def reason_code(row: WrittenRow) -> str:
    """Return the code of the reason of a row; empty where it has none."""
    return "" if row["reason"] is None else str(row["reason"]["code"])
