"""Settings of a calibration of heads by others on the same rigid body."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from ...core.settings import setting


@dataclass(frozen=True)
class SaidBody:
    """What a caller says of the files."""

    body: str | None = setting(
        "TOML file of the body: position, orientation, clock and bias of each head by the name of its file, motion.",
        None, example="body.toml",
    )  # fmt: skip


@dataclass(frozen=True)
class Plan:
    """How recordings are averaged, and what is looked for in them."""

    interval: float | None = setting(
        "Time over which readings of all heads are averaged alike; about 1/240 of the record if not given.", None,
        unit="s", example="10 s", above=0.0,
    )  # fmt: skip
    ambient: float | None = setting(
        "Bound of the mean acceleration, by which errors of orientations count where no head has a bias; by default"
        " what the heads read, biases and all.", None, unit="m/s^2", example="2 ug", above=0.0,
    )  # fmt: skip
    scale_factor: Literal["auto", "none"] = setting(
        "Scale factors and misalignment against the calibrated heads: where the motion carries them, or never.", "auto"
    )
    clock_search: float = setting(
        "Largest clock offset between heads that is looked for.", 30.0, unit="s", example="30 s", above=0.0, most=3600.0
    )  # fmt: skip
