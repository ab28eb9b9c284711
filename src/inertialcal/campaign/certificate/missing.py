"""What a certificate needs and the campaign does not state: one list, each with the key to write and an example.

References
----------
.. [1] ISO/IEC 17025:2017, 7.8.2.1 and 7.8.4.1: what a calibration certificate holds.
"""

from __future__ import annotations

from collections.abc import Iterator

from ...core.errors import PlanError, Problem
from ..file.certificate import Signature
from ..file.load import Campaign

CODE = "not_stated"
# Key of [certificate], what it is, an example
NEEDED = (
    ("number", "number of the certificate", '"2026-014"'),
    ("issued", "day of issue", '"2026-11-28"'),
    ("received", "day on which the item was received", '"2026-11-02"'),
    ("performed", "day of the calibration, or its first and last", '["2026-11-03", "2026-11-20"]'),
    ("laboratory.name", "name of the laboratory", '"Inertial Laboratory"'),
    ("laboratory.city", "city of the laboratory", '"Monterey"'),
    ("laboratory.country", "country of the laboratory", '"US"'),
    ("customer.name", "name of the customer", '"Small Satellite Office"'),
    ("customer.city", "city of the customer", '"Monterey"'),
    ("customer.country", "country of the customer", '"US"'),
    ("item_condition", "state of the item as received", '"no visible damage, not adjusted"'),
    ("methods", "methods that were followed", '["IEEE Std 1431-2004, 12.9 and 12.11"]'),
    ("environment", "environmental conditions in the laboratory", '"(23 +- 1) degC, 40 % to 60 % relative humidity"'),
    ("deviations", "deviations from the methods", '"none"'),
    ("signatures", "who authorises the certificate", '[{ name = "A. Person", function = "head of laboratory" }]'),
)
OF_ITEM = (
    ("maker", "manufacturer of the item", '"Systron Donner"'),
    ("part", "type of the item", '"QRS11-00005-565"'),
    ("serial", "serial number of the item", '"0042"'),
)


def check_stated(campaign: Campaign) -> None:
    """Refuse a campaign that does not state all that a certificate holds.

    Raises
    ------
    PlanError
        ``not_stated``, a problem for each key that lacks.
    """
    problems = list(_missing(campaign))
    if problems:
        raise PlanError(problems)


def _missing(campaign: Campaign) -> Iterator[Problem]:
    stated = campaign.file.certificate
    place = campaign.at("certificate")
    for name, what, example in OF_ITEM:
        if not getattr(campaign.file.item, name).strip():
            yield _problem(what, campaign.at("item"), "item", name, example)
    for key, what, example in NEEDED:
        table, _, name = key.rpartition(".")
        value = getattr(getattr(stated, table) if table else stated, name)
        if not _is_given(value):
            yield _problem(what, place, f"certificate.{table}" if table else "certificate", name, example)
    if stated.place == "other" and not stated.place_text.strip():
        yield _problem("place of the calibration", place, "certificate", "place_text", '"on the test range"')


def _is_given(value: object) -> bool:
    """Whether something is stated: no blank text, no empty list, no person without name or function."""
    if isinstance(value, list):
        return bool(value) and all(_is_given(one) for one in value)
    if isinstance(value, Signature):
        return _is_given(value.name) and _is_given(value.function)
    return bool(str(value or "").strip())


def _problem(what: str, where: str, table: str, key: str, example: str) -> Problem:
    return Problem(
        f"not stated: {what}",
        where,
        do=f"Write in [{table}]: {key} = {example}",
        code=CODE,
    )
