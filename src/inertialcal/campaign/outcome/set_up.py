"""Site and sensors as the campaign says them: every quantity as text "number unit", as it can be pasted back."""

from __future__ import annotations

from typing import Any

from ...core.units import Quantity, convert
from ...procedures.display import ten_digits
from ..file.schema import Site
from ..file.sensors import Sensor

SITE = {"latitude": ("rad", "deg"), "height": ("m", "m"), "gravity": ("m/s^2", "m/s^2")}
CHAIN = {"lsb": "V", "reference": "V", "validity_minimum": "V", "gate": "s"}


def site_content(site: Site) -> dict[str, str | None]:
    """Return latitude, height and gravity as text; null where the campaign does not say them."""
    return {name: _text(getattr(site, name), *units) for name, units in SITE.items()}


def sensors_content(sensors: dict[str, Sensor]) -> dict[str, Any]:
    """Return kind, axes, unit, range, mounting and signal chain of each sensor."""
    return {name: sensor.model_dump() | {"chain": _chain(sensor)} for name, sensor in sensors.items()}


def _chain(sensor: Sensor) -> dict[str, Any]:
    said = sensor.chain.model_dump()
    pair = said["counts"]
    given = {name: _text(said[name], unit, unit) for name, unit in CHAIN.items() if isinstance(said[name], float)}
    return said | given | {"counts": None if pair is None else list(pair)}


def _text(value: float | None, unit: str, shown: str) -> str | None:
    if value is None or unit == shown:
        return None if value is None else str(Quantity(value, unit))
    return str(Quantity(ten_digits(float(convert(value, unit, shown))), shown))
