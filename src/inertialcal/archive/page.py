"""One page on a unit: when it is due, its figures over time, verdicts, every result, remarks.

It stands by itself, like ``report.html``, whose looks and policy it has: nothing is loaded from anywhere.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from markupsafe import Markup
from sqlalchemy import select

from ..core.remarks import Remark
from ..core.show.rounding import number, settled
from ..core.show.tables import Table
from ..core.times import instant_text
from ..report import drawings
from ..report.page import MOST_FIGURES, ZOOM, environment
from .archive import Archive, Listing
from .history import History
from .tables import verdicts

MOST_ROWS = 2_000  # of a table
WORST = ("FAIL", "INCONCLUSIVE", "OPEN", "PASS")
RESULTS = ("figure", "test", "campaign", "tested", "value", "unit")
VERDICTS = ("campaign", "requirement", "figure", "test", "value", "limits", "unit", "verdict", "of")


def history_page(archive: Archive, found: History) -> str:
    """Return the page.

    Parameters
    ----------
    archive : Archive
        That holds the unit.
    found : History
        Of the unit: what is shown of it.
    """
    item = found.item
    listed = tuple(
        one for one in archive.list(item["serial"]).campaigns if (one.maker, one.part) == (item["maker"], item["part"])
    )
    newest = {one.number: one.name for one in listed if not one.replaced}
    every = drawings.of_campaign(found.content())
    drawn = every[:MOST_FIGURES]
    blocks = {one.key: Markup(one.svg()) + ZOOM for one in drawn}  # noqa: S704 - an XML writer escaped it
    data = environment().get_template("data.html")
    for one in drawn:
        blocks[f"data-{one.key}"] = Markup(data.render(key=one.key, tables=one.data()))  # noqa: S704 - a template did
    parts = [part for part in found.parts() if isinstance(part, Table)]
    campaigns = Listing(archive.database.name, listed).parts()
    tables = {
        "drifts": parts,
        "campaigns": [part for part in campaigns if isinstance(part, Table)],
        "verdicts": [_verdicts(archive, newest)],
        "results": [_results(found)],
    }
    shown = {
        "item": item,
        "due": "" if found.due_ns is None else instant_text(found.due_ns)[:10],
        "limited": any(one.limit is not None for one in found.series),
        "last": next((one.verdict for one in reversed(listed) if not one.replaced), ""),
        "drawn": drawn,
        "results": bool(found.series),
        "left": str(len(every) - len(drawn)) if len(every) > len(drawn) else "",
        "blocks": blocks,
        "tables": tables,
        "remarks": [_remark(one) for one in found.remarks],
    }
    return environment().get_template("history.html").render(shown)


def _remark(one: Remark) -> dict[str, str]:
    times = f" ({one.count} ×)" if one.count > 1 else ""
    return {"severity": one.severity, "what": one.what, "count": times, "do": one.do, "where": one.where}


def _results(found: History) -> Table:
    rows = [
        [_name(one.row.key.name, one.row.axis, one.row.key.at), one.row.test, one.name,
         instant_text(one.time_ns or 0)[:10], settled(one.row.value, one.row.u), one.row.unit]
        for series in found.series for one in series.points
    ]  # fmt: skip
    return _cut("results of each test, with standard uncertainty", RESULTS, rows, (4,))


def _verdicts(archive: Archive, newest: dict[int, str]) -> Table:
    """Return the verdicts of campaigns, one row for those of one figure of a requirement: the worst of them."""
    query = select(verdicts).where(verdicts.c.campaign_id.in_(newest))
    with archive.database.reading() as connection:
        found = connection.execute(query.order_by(verdicts.c.campaign_id, verdicts.c.position)).mappings().all()
    groups: dict[tuple[str, ...], list[Any]] = {}
    for one in found:
        named = _name(one["quantity"], one["axis"], None)
        figure = (newest[one["campaign_id"]], one["requirement"], named, one["test"])
        groups.setdefault(figure, []).append(one)
    rows = []
    for key, mine in groups.items():
        one = min(mine, key=lambda row: WORST.index(row["verdict"]) if row["verdict"] in WORST else len(WORST))
        limits = " .. ".join(number(end, 6) if end is not None else "-" for end in (one["lower"], one["upper"]))
        value = "-" if one["value"] is None else settled(one["value"], one["u"])
        rows.append([*key, value, limits, one["unit"], one["verdict"], str(len(mine))])
    return _cut("verdicts of each campaign; of several on one figure the worst", VERDICTS, rows, (4, 5, 8))


def _name(quantity: str, axis: str, at: object) -> str:
    return f"{quantity} {axis}".strip() + (f" at {at}" if at else "")


def _cut(caption: str, heads: Sequence[str], rows: Sequence[Sequence[str]], right: Sequence[int]) -> Table:
    """Return a table of so many rows that a browser shows it, and say how many there are."""
    more = f"; {MOST_ROWS} of {len(rows)}" if len(rows) > MOST_ROWS else ""
    return Table(heads, rows[:MOST_ROWS], f"{caption}{more}", right)
