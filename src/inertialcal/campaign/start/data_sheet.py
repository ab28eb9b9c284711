"""What a data sheet says of a sensor, as a first campaign.toml has it: facts, and limits to be judged."""

from __future__ import annotations

from collections.abc import Mapping

from ...core.campaign_text import Noted
from ...procedures import all_quantities
from ...sensors.catalogue import Figure, PublishedSensor

LIMITS = ("at most", "less than", "plus or minus")  # relations that a requirement on both sides, or above, can say


def requirements(sensor: PublishedSensor) -> list[dict[str, object]]:
    """Return a requirement for each figure that a test can judge."""
    judged = [one for one in sensor.figures if _judged(one)]
    return [_requirement(number, one, sensor) for number, one in enumerate(judged, 1)]


def unjudged(sensor: PublishedSensor) -> str:
    """Return lines that name the other figures; empty where there are none."""
    others = [f"  {one.said}" for one in sensor.figures if not _judged(one)]
    return "\n".join([f"Published ({sensor.source}), but no limit that a test here judges:", *others]) if others else ""


def _judged(one: Figure) -> bool:
    return one.relation in LIMITS and one.judged_by in all_quantities()


def _requirement(number: int, one: Figure, sensor: PublishedSensor) -> dict[str, object]:
    side = "upper" if all_quantities()[one.judged_by].size else "limit"
    text = f"{one.said} ({one.source or sensor.source})"
    found = {"id": f"D{number}", "text": text, "quantity": one.judged_by, side: f"{one.value:g} {one.unit}"}
    return {**found, **({"where": one.where} if one.where else {})}


def with_facts(tables: Mapping[str, object], sensor: PublishedSensor) -> dict[str, object]:
    """Return the tables of sensors with what is published of those of its kind: range, cut-off, ideal scale factor."""
    return {name: _with_facts(table, sensor) for name, table in tables.items()}


def _with_facts(table: object, sensor: PublishedSensor) -> object:
    if isinstance(table, Noted):
        return Noted(_with_facts(table.value, sensor), table.note, table.above, table.example)
    if not isinstance(table, Mapping) or _plain(table.get("kind")) != sensor.kind:
        return table
    figures = {one.quantity: one for one in sensor.figures}
    made: dict[str, object] = dict(table)
    span, output, cut_off = (figures.get(name) for name in ("input_range", "full_scale_output", "bandwidth"))
    if span is not None and span.relation == "plus or minus":
        made["range"] = Noted([f"-{span.value:g} {span.unit}", f"{span.value:g} {span.unit}"], "of the data sheet")
        if output is not None and _example(table.get("chain")):
            made["chain"] = {
                "kind": "none",
                "scale_factor": f"{output.value / span.value:g} {output.unit}/({span.unit})",
            }
    if cut_off is not None and cut_off.relation == "equals":
        made["cut_off"] = Noted(f"{cut_off.value:g} {cut_off.unit}", "of the data sheet")
    return made


def _plain(value: object) -> object:
    return value.value if isinstance(value, Noted) else value


def _example(value: object) -> bool:
    """Whether nothing is said but an example."""
    return value is None or (isinstance(value, Noted) and value.example)
