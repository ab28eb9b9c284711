"""Links: how the bytes of an instrument come and go, by the word that LAB.toml has for each."""

from __future__ import annotations

from ....core.registry import Registry
from .link import LinkKind

BUILT_IN = {
    "serial": "serial:KIND", "visa": "visa:KIND", "tcp": "network:TCP", "udp": "network:UDP", "file": "growing:KIND",
    "replay": "recorded:REPLAY", "rig": "recorded:RIG", "bench": "bench:KIND",
    "planned": "planned:KIND", "phone": "phone:KIND",
}  # fmt: skip
LINKS: Registry[LinkKind] = Registry(
    "link", LinkKind, "inertialcal.links", {name: f"{__name__}.{place}" for name, place in BUILT_IN.items()}
)

__all__ = ["LINKS", "LinkKind"]
