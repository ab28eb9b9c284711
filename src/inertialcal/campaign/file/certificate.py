"""[certificate] of campaign.toml: what a certificate states beside its figures.

Every key may be absent: a campaign is run without them, and ``inertialcal certificate`` lists what it misses.
"""

from __future__ import annotations

from datetime import date, datetime
from itertools import pairwise
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, model_validator

from ...core.schema.quantities import Strict, Text

Place = Literal["laboratory", "customer", "laboratory_branch", "customer_branch", "other"]


def _day(given: object) -> date:
    if isinstance(given, date) and not isinstance(given, datetime):
        return given
    try:
        return date.fromisoformat(given if isinstance(given, str) else "")
    except ValueError:
        raise ValueError(f'{given!r} is no day: write "2026-11-28"') from None


Day = Annotated[date, BeforeValidator(_day)]
Country = Annotated[str, Field(pattern="^[A-Z]{2}$")]


class Address(Strict):
    """Name and address: of the laboratory, of the customer."""

    name: Text = ""
    street: Text = ""
    post_code: Text = ""
    city: Text = ""
    country: Country | None = None  # ISO 3166-1, two letters
    email: Text = ""
    phone: Text = ""


class Signature(Strict):
    """A person who authorises the certificate."""

    name: Text = ""
    function: Text = ""


class Certificate(Strict):
    """[certificate]."""

    number: Text = ""
    issued: Day | None = None
    received: Day | None = None
    performed: Annotated[list[Day], Field(min_length=1, max_length=2)] | None = None
    place: Place = "laboratory"
    place_text: Text = ""
    laboratory: Address = Address()
    customer: Address = Address()
    item_condition: Text = ""
    methods: list[Text] = Field(default=[])
    environment: Text = ""
    deviations: Text = ""
    signatures: list[Signature] = Field(default=[])
    replaces: Text = ""
    remarks: Text = ""

    @model_validator(mode="after")
    def _in_order(self) -> Certificate:
        performed = self.performed or []
        days = [("received", self.received), *(("performed", day) for day in performed), ("issued", self.issued)]
        given = [(name, day) for name, day in days if day is not None]
        for (name, day), (later, other) in pairwise(given):
            if other < day:
                raise ValueError(f"{later} {other} lies before {name} {day}")
        return self
