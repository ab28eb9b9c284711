"""A rehearsal: LAB.toml and campaign of a simulated rig, or of a plan, so that all of it is made by one command.

The campaign is that of the rig, without its recordings, and with its sealed truth; what the sequence records stands as
Parquet, and what the table was told as schedules.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit

from ...campaign.twins.twin import write_twin
from ...core.campaign_text import Noted, toml_text
from ...core.errors import UsageError
from ...core.recording import SECOND
from ...files.write.atomic import atomic_write, work_folder, write_folder
from ...procedures.protocol import Planned, Procedure
from ...procedures.rehearsed import Rehearsal
from ...rigs import RIGS
from ...rigs.parts.campaign import Content, campaign_head
from ...rigs.twin import Twin
from ..instruments.frames import STAMP
from ..instruments.links.bench import Bench, applied_columns, bench_of
from ..instruments.links.planned import POWER_UP, rehearsal_of
from .store import CAMPAIGN

SPEED = 100_000  # of the clock
PART = 0.7  # of a dwell that is recorded
WITHIN = 1e-3  # of the rate, in its unit
LASTING = 4.0  # [s] for which the rate has to be held
NAME = "bench"  # of the instrument
PLAN, SCHEDULE = "plan.toml", "schedule.csv"


def write_rehearsal(rig: str, folder: Path, seed: int) -> Path:
    """Write LAB.toml and the campaign of a rig into a new folder; return the path of LAB.toml.

    Raises
    ------
    UsageError
        If there is no such rig, the folder is not empty, or the rig cannot be rehearsed.
    StoreError
        If it cannot be written.
    """
    _refuse_full(folder)
    twin = RIGS.named(rig).twin(seed)
    if twin.texts or any(one.stamps is None for one in twin.recordings.values()):
        what = f"rig {rig} cannot be rehearsed: its loggers write files of their own"
        raise UsageError(what, do=f"Say: inertialcal simulate {rig} -o DIR", code="no_bench")
    text = tomlkit.parse(twin.campaign)
    recordings: Any = text["recordings"]
    applied = applied_columns(twin.campaign)
    names: dict[str, str] = {}
    for name, one in recordings.items():
        file = str(one["file"])
        names.setdefault(file, name)  # two recordings may be of one file
        one["file"] = str(Path(file).with_suffix(".parquet"))
        one["clock"]["column"] = "time"
        if file in applied:
            del one["channels"]["applied"]
            one["schedule"] = {"file": f"schedules/{name}.csv", "unit": applied[file][1]}
    lab = "".join(_lab(rig, seed, bench_of(rig, seed), names, applied))
    folder.mkdir(parents=True, exist_ok=True)
    write_twin(replace(twin, campaign=tomlkit.dumps(text), recordings={}), folder / CAMPAIGN)
    with atomic_write(folder / "LAB.toml") as aside:
        aside.write_text(lab, encoding="utf-8", newline="\n")
    return folder / "LAB.toml"


def write_planned(word: str, procedure: Procedure[Any, Any, Any], settings: Mapping[str, Any], folder: Path,
                  seed: int) -> Planned:  # fmt: skip
    """Plan a test, and write what rehearses its programme on a simulated unit into a new folder; return the plan.

    LAB.toml, the schedule, the campaign with its sealed truth, and the plan's settings.

    Raises
    ------
    UsageError
        If the folder is not empty, or the settings cannot be meant.
    StoreError
        If it cannot be written.
    """
    _refuse_full(folder)
    settings = {name: str(one.resolve()) if isinstance(one, Path) else one for name, one in settings.items()}
    with work_folder(folder.parent) as work:
        found: Any = procedure.planned({**settings, "schedule": str(work / SCHEDULE)})
        head = {"procedure": procedure.name, "schedule": SCHEDULE, "settings": settings}
        (work / PLAN).write_text(tomlkit.dumps(head), encoding="utf-8", newline="\n")
        made = rehearsal_of(work / PLAN, seed)
        texts = {name: (work / name).read_bytes() for name in (SCHEDULE, PLAN)}
        title = f"rehearsal of plan {word}"
        named = word.replace("-", "_")
        about = f"the plan of {word}, on a simulated unit"
        campaign = toml_text({**campaign_head(f"plan_{named}", "simulated unit", title, about), **made.content})
        lab = toml_text(_planned_lab(title, made, seed))
    write_folder(folder, {**texts, "LAB.toml": lab.encode()})
    write_twin(Twin(campaign, {}, made.truth, {}, rig=f"plan {word}", seed=seed), folder / CAMPAIGN)
    planned: Planned = replace(found, written=str(folder / SCHEDULE))
    return planned


def _planned_lab(title: str, made: Rehearsal, seed: int) -> Content:
    """Return what LAB.toml says."""
    way = made.way
    limits = {POWER_UP: ["1", str(max(len(made.recordings), 2))]}
    told = {f"{NAME}.{POWER_UP}": POWER_UP}
    if way.setting:
        values = np.array([one[2] for own in made.stretches.values() for one in own])
        spare = 0.1 * max(float(np.max(np.abs(values))), 1.0)
        limits[way.setting] = [f"{end:g} {way.unit}".rstrip() for end in (values.min() - spare, values.max() + spare)]
        told[f"{NAME}.{way.setting}"] = way.setting
    bench = {"link": "planned", "plan": PLAN, "seed": seed, "limits": limits}
    columns = {"file": SCHEDULE, "name": "name", "recording": "recording", "prompt": "prompt", "set": told}
    span = Noted({"for": "1 s"}, "in its place: from start to stop of each row")
    return {
        "schema": 1,
        "lab": {"title": title, "speed": Noted(SPEED, "of the clock"), "sync": "60 s"},
        "instruments": {NAME: bench},
        "sequence": {"campaign": CAMPAIGN, "schedule": {**columns, **made.sequence, "record": span}},
    }


def _refuse_full(folder: Path) -> None:
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise UsageError(f"{folder} exists and is not empty", do="Name a new folder", code="exists")


def _lab(
    rig: str, seed: int, bench: Bench, names: dict[str, str], applied: dict[str, tuple[str, str]]
) -> Iterator[str]:
    """Yield LAB.toml, part by part."""
    unit = next(iter(applied.values()))[1] if applied else ""
    rates = [abs(stretch[2]) for own in bench.stretches for stretch in own if np.isfinite(stretch[2])]
    most = 1.1 * max(rates, default=1.0)
    limits = f'recording = ["1", "{max(len(bench.names), 2)}"]'
    limits += f', rate = ["-{most:g} {unit}", "{most:g} {unit}"]' if applied else ""
    yield f'schema = 1\n\n[lab]\ntitle = "rehearsal of the rig {rig}"\n'
    yield f'speed = {SPEED}  # of the clock\nsync = "60 s"\n\n'
    yield f'[instruments.{NAME}]\nlink = "bench"\nrig = "{rig}"\nseed = {seed}\nlimits = {{ {limits} }}\n\n'
    yield f'[sequence]\ncampaign = "{CAMPAIGN}"\n'
    for number, file in enumerate(bench.names):
        column, stamps = applied.get(file, ("", ""))[0], bench.rows[number][STAMP]
        for at, (first, stop, rate) in enumerate(bench.stretches[number]):
            told = [f'"{NAME}.recording" = "{number + 1}"'] if at == 0 else []
            length = float(stamps[stop - 1] - stamps[first]) / SECOND
            name, stable = names[file], ""
            if column:
                told.append(f'"{NAME}.rate" = "{rate:g} {unit}"')
                name += f" at {rate:g} {unit}"
                held = int(np.count_nonzero(bench.rows[number][column][first:stop] == rate))
                length = round(PART * float(stamps[stop - 1] - stamps[stop - held]) / SECOND, 1)
                stable = f'stable = {{ channel = "{column}", follows = "{NAME}.rate",'
                stable += f' within = "{WITHIN:g} {unit}", for = "{LASTING:g} s" }}\n'
            yield f'\n[[sequence.steps]]\nname = "{name}"\nrecording = "{names[file]}"\nset = {{ {", ".join(told)} }}\n'
            yield f'{stable}record = {{ for = "{length!r} s" }}\n'
