"""Settings of a plan against each other: what is missing, has the wrong number of elements, or contradicts."""

from __future__ import annotations

from collections.abc import Iterator

from ....core.errors import Problem
from ....physics.motion.travel import ORDER
from ...settings_file import GroupsRead
from .drive import DRIVES
from .noise import NAMED
from .settings import HOUR, Settings, stage_of

NOT_BOTH = {
    "body.cubes": ("body.cube", "body.count"),
    "motion.stroke": ("motion.travel",),
    "orbit.gradient": ("orbit.acceleration",),
    "noise.file": tuple(f"noise.{name}" for name in NAMED),
}
ELEMENTS = {
    "body.grid": 3,
    "motion.rig": 2,
    "motion.stroke": 2,
    "instrument.first_pool": 3,
    "instrument.second_pool": 3,
}


def setting_problems(read: GroupsRead[Settings]) -> Iterator[Problem]:
    """Yield everything that is wrong with settings that are right one by one."""
    for key, others in NOT_BOTH.items():
        given = [one for one in others if _value(read, one) is not None]
        if given and _value(read, key) is not None:
            why, do = "they contradict each other", "Keep one of them"
            yield Problem(f"{key} with {', '.join(given)}", read.at(*key.split(".")), why, do, "contradiction")
    for key, count in ELEMENTS.items():
        values = _value(read, key)
        if isinstance(values, list) and (len(values) != count or (count == 2 and values[0] == values[1])):
            do = f"Give {count} different values"
            yield Problem(f"{key}: {values}", read.at(*key.split(".")), do=do, code="wrong_value")
    if read.settings.orbit is None:
        yield from _of_body(read)
        yield from _of_test(read)
    elif set(read.given) - {"orbit", "constants"}:
        unused = ", ".join(name for name in read.given if name not in {"orbit", "constants"})
        why, do = "an orbit has only the groups orbit and constants", "Remove the others"
        yield Problem(f"orbit with {unused}", read.at("orbit"), why, do, "contradiction")


def _value(read: GroupsRead[Settings], key: str) -> object:
    """Return a setting; None if it is not given."""
    group, name = key.split(".")
    return getattr(getattr(read.settings, group), name, None)


def _of_body(read: GroupsRead[Settings]) -> Iterator[Problem]:
    body, where = read.settings.body, read.at("body")
    if body is None:
        do = "Set body.stand_off, body.cube and body.count, or orbit; --write-example FILE shows all settings"
        yield Problem("body is missing", where, do=do, code="missing_key")
        return
    if body.cubes is None and body.cube is None:
        yield Problem("body.cube is missing", where, do='Example: cube = "5.08 cm"', code="missing_key")
    if body.cubes is None and body.count is None and body.mass is None:
        do = "Give the number of cubes, or the largest mass"
        yield Problem("body.count and body.mass are missing", where, do=do, code="missing_key")
    if body.grid is not None and min(body.grid, default=0) < 1:
        do = "Give the cells across, across and along the input axis: [20, 20, 10]"
        yield Problem(f"body.grid: {body.grid}", read.at("body", "grid"), do=do, code="wrong_value")
    if body.optimise == "change" and read.settings.motion.stroke is None:
        do = 'Give the ends of the drive: motion.stroke = ["12.7 cm", "43.2 cm"]'
        where = read.at("body", "optimise")
        yield Problem('body.optimise = "change" needs motion.stroke', where, do=do, code="missing_key")


def _of_test(read: GroupsRead[Settings]) -> Iterator[Problem]:
    said, timing = read.settings, read.settings.timing
    pools = [said.instrument.first_pool, said.instrument.second_pool]
    if pools != [None, None]:
        where = read.at("instrument")
        if None in pools:
            do = "Give the middles of both surfaces"
            yield Problem("instrument.first_pool without second_pool, or the reverse", where, do=do, code="missing_key")
        if stage_of(said.motion) is None:
            do = "Set motion.rig, motion.stroke or motion.travel"
            yield Problem(
                "instrument.first_pool: without a drive the mercury does not tilt", where, do=do, code="unused"
            )
    period = len(ORDER[DRIVES[timing.drive]]) * (timing.dwell + timing.move)
    if timing.length < period:
        what = f"timing.length: {timing.length / HOUR:g} h is shorter than one cycle of {period / HOUR:.3g} h"
        where, do = read.at("timing", "length"), "Give more time, or shorter dwells"
        yield Problem(what, where, do=do, code="too_short")
