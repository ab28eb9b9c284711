"""The final output table of a rate-sensor suite: what a flight computer needs of each sensor, chosen from the results.

As the thesis collects it in its Table 15 [1]_: bias over the volts of the temperature channel, what is left of it on
the rate table, scale factor and the row of the matrix; here with what the thesis does not give: the offset in vacuum,
what compensation leaves, and every uncertainty.

References
----------
.. [1] V. V. Badescu, NPS thesis, September 2011, Table 15.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..results import WrittenRow, case_of
from .sentence import R

FIRST = "bias_voltage"  # in volts, volts per volt, ...: of the thermal test
AFTER = ("bias", "scale_factor", "scale_factor_error", "misalignment")  # of the rate table
OTHERS = ("vacuum_offset", "residual_bias", "angle_random_walk")
NOTE = {"bias": "residual, on the rate table"}


def output_rows(rows: Sequence[R], steps: Sequence[Mapping[str, Any]]) -> list[R]:
    """Return the rows of the table, sensor by sensor; none without a rate table after a thermal test.

    Parameters
    ----------
    rows, steps : sequence of mapping
        ``results`` and ``sequence`` of ``results.json``.
    """
    table = next((step for step in steps if step.get("after") and step.get("use") == "fit"), None)
    if table is None:
        return []
    first = table["after"][0]
    cases = [case_of(row) for row in rows]
    own = [row for row, case in zip(rows, cases, strict=True) if not case.beside and case.at is None]
    turned = {step["test"] for step in steps if step.get("procedure") == table.get("procedure")} - {table["test"]}
    chosen = [row for row in own if row["test"] not in turned and _is_chosen(row, first, table["test"])]
    return sorted(chosen, key=_order)


def _is_chosen(row: WrittenRow, first: str, table: str) -> bool:
    if row["test"] == first:
        return bool(row["quantity"] == FIRST)
    return row["quantity"] in (AFTER if row["test"] == table else OTHERS)


def _order(row: WrittenRow) -> tuple[str, int, str, int, str, str]:
    """Return sensor by sensor: polynomial, rate table, others."""
    name = str(row["quantity"])
    place = [FIRST, *AFTER, *OTHERS].index(name)
    return str(row["axis"])[:1], place, name, int(float(row["power"])), str(row["axis"]), str(row["test"])


def note(row: Mapping[str, Any]) -> str:
    """Return what a row is beside its quantity."""
    return NOTE.get(str(row["quantity"]), "")
